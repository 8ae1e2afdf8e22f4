//! The records of the protocol, as bytes and back. `docs/book/src/reference/stream.md` is their table.

use crate::bytes::{Put, Take};

/// The first four bytes of every record.
pub const MAGIC: [u8; 4] = *b"EYST";
/// Version of the protocol.
pub const VERSION: u16 = 2;
/// Bytes before a record's own: magic, version, kind, length, and how many records of the same moment follow.
pub const HEADER: usize = 16;
/// Longest record, bytes. Those of a server are at most about [`PART`] long.
pub const MAX_RECORD: usize = 16 << 20;
/// What does not fit into so many bytes is sent in several records.
pub const PART: usize = 1 << 20;
/// Rays of a colony, 15 degrees apart, the first one to the east, the next ones towards the south.
pub const RAYS: usize = 24;
/// Most steps that a client may ask for at once.
pub const MAX_STEPS: u64 = 1_000_000_000;

/// Bytes of a colony without rays, and of an alga.
const COLONY: usize = 40;
const ALGA: usize = 32;

/// What is wrong with a record, and at which byte of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("byte {at}: {what}")]
pub struct Malformed {
    /// Offset from the record's first byte.
    pub at: usize,
    /// What is wrong.
    pub what: String,
}

/// A record with the number of records of the same moment that follow it.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// 0 where the moment is complete.
    pub more: u32,
    /// What it says.
    pub body: Body,
}

/// What a record says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Body {
    /// The first record of every connection.
    Hello(Hello),
    /// A whole state begins: forget what was before.
    Snapshot(Moment),
    /// What has changed since the moment before.
    Step(Moment),
    /// Colonies.
    Colonies {
        /// Why they are here.
        why: Why,
        /// Whether rays follow each row.
        rays: bool,
        /// The colonies.
        rows: Vec<Colony>,
    },
    /// Macroalgae.
    Algae {
        /// Why they are here.
        why: Why,
        /// The algae.
        rows: Vec<Alga>,
    },
    /// Numbers of colonies and algae that live no more.
    Gone(Vec<u64>),
    /// A part of a layer.
    Tile(Tile),
    /// Whether the run works.
    Status(Status),
    /// The run has ended; nothing follows.
    End {
        /// How.
        how: Ending,
        /// What there is to say.
        message: String,
    },
    /// An order was refused; the connection stays.
    Refused(String),
    /// The run was changed by hand.
    Changed(Changed),
    /// What a client may ask for.
    Order(Order),
}

/// A change by hand.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Changed {
    /// Number of the recipe's step, from 1.
    pub recipe_step: u32,
    /// Steps of it that were done before.
    pub step: u64,
    /// What was changed, as the run's journal has it: `hydraulic.rain = 0.004`.
    pub set: String,
}

/// What a client may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Permission {
    /// Watch.
    #[default]
    Watch,
    /// Also pause, resume and step the run, which changes no byte of its result.
    Pause,
    /// Also change its parameters, its sea and its layers.
    Change,
}

/// What a client may ask for.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Order {
    /// Wait after the present step.
    Pause,
    /// Go on.
    Resume,
    /// Do so many steps, then wait.
    Step(u64),
    /// Change the simulation under way.
    Set {
        /// Keys with dots between them: `hydraulic.rain`, `sea_level`, `layer.water`; empty if the value is a table of several changes that
        /// are made together.
        path: String,
        /// The new value, JSON.
        value: String,
    },
}

impl Order {
    /// What a client needs for it.
    pub fn needs(&self) -> Permission {
        match self {
            Self::Pause | Self::Resume | Self::Step(_) => Permission::Pause,
            Self::Set { .. } => Permission::Change,
        }
    }
}

/// Why individuals are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Why {
    /// They are all there are, or a part of all.
    All,
    /// They are new.
    Born,
    /// They were there, and something about them is different.
    Changed,
}

/// Whether the run works.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Status {
    /// It does steps.
    #[default]
    Runs,
    /// It waits for somebody to resume it.
    Paused,
    /// It waits for clients.
    Waits,
    /// It writes its files.
    Writes,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// With the last step of its recipe.
    Done,
    /// Stopped; it can be resumed.
    Stopped,
    /// With an error.
    Failed,
}

/// What a stream is about.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Hello {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Columns and rows of the grid; row 0 is north.
    pub size: [u32; 2],
    /// Size of a cell to the east and to the south, m.
    pub cell_m: [f64; 2],
    /// Level of the sea, m.
    pub sea_level_m: f64,
    /// Steps of simulation from one moment to the next.
    pub every: u64,
    /// Whether colonies come with rays.
    pub rays: bool,
    /// What this client may do.
    pub may: Permission,
    /// Version of the engine.
    pub engine: String,
    /// Name of the recipe.
    pub recipe: String,
    /// Species of colonies.
    pub species: Vec<SpeciesInfo>,
    /// Layers that are sent.
    pub layers: Vec<LayerInfo>,
    /// Names of the numbers of the census.
    pub columns: Vec<String>,
}

/// A species of colonies.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SpeciesInfo {
    /// Its name.
    pub name: String,
    /// 0 massive, 1 branching: how it fights for space.
    pub form: u8,
    /// Growth form of the bodies: 0 massive, 1 branching, 2 columnar, 3 encrusting, 4 foliaceous, 5 laminar, 6 free-living.
    pub shape: u8,
    /// Colour in plots, sRGB.
    pub colour: [u8; 3],
}

/// A layer.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LayerInfo {
    /// Its name.
    pub name: String,
    /// Its unit, `1` for a plain number.
    pub unit: String,
    /// Smallest and largest valid value.
    pub range: [f32; 2],
    /// 0 in the middle of the cell, 1 on its face to the east, 2 on its face to the south.
    pub stagger: u8,
}

/// Where a run is, and its census.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Moment {
    /// Number of the moment, from 0; a change is one to the moment before.
    pub number: u64,
    /// Steps of simulation done in all.
    pub steps_done: u64,
    /// Number of the recipe's step, from 1.
    pub recipe_step: u32,
    /// Steps done of it, and all of them.
    pub step: [u64; 2],
    /// Mean temperature of the sea in this step, C; not a number where nobody knows.
    pub temperature_c: f32,
    /// Level of the sea, m; in full precision where it began in [`Hello`].
    pub sea_level_m: f32,
    /// Colonies and algae that live.
    pub living: [u32; 2],
    /// The census by the columns of [`Hello`], or nothing.
    pub census: Vec<f64>,
}

/// A colony.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Colony {
    /// Never given again in a run; algae share the numbers.
    pub id: u64,
    /// Month of the community in which it settled; negative for those of the beginning.
    pub settled: i32,
    /// Number of its species.
    pub species: u16,
    /// Whether it is bleached.
    pub bleached: bool,
    /// Centre, m from the west side.
    pub x: f32,
    /// Centre, m from the north side.
    pub y: f32,
    /// Mean length of its rays, m; its area is that of this disc.
    pub radius: f32,
    /// Height of its body above the ground as its species has it, m.
    pub height: f32,
    /// 1 fully bleached, 0 healthy.
    pub bleaching: f32,
    /// Length of its longest ray, m.
    pub reach: f32,
    /// Lengths of its rays, m; zeros in streams without rays.
    pub rays: [f32; RAYS],
}

/// A macroalga.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Alga {
    /// Never given again in a run.
    pub id: u64,
    /// Month of the community in which it settled.
    pub settled: i32,
    /// Centre, m from the west side.
    pub x: f32,
    /// Centre, m from the north side.
    pub y: f32,
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
}

/// A part of a layer.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Tile {
    /// Number of the layer in [`Hello`].
    pub layer: u16,
    /// First column and row.
    pub at: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
    /// Values, row by row.
    pub values: Vec<f32>,
}

impl Body {
    fn kind(&self) -> u16 {
        match self {
            Self::Hello(_) => 1,
            Self::Snapshot(_) => 2,
            Self::Step(_) => 3,
            Self::Colonies { .. } => 4,
            Self::Algae { .. } => 5,
            Self::Gone(_) => 6,
            Self::Tile(_) => 7,
            Self::Status(_) => 8,
            Self::End { .. } => 9,
            Self::Refused(_) => 10,
            Self::Changed(_) => 11,
            Self::Order(Order::Pause) => 32,
            Self::Order(Order::Resume) => 33,
            Self::Order(Order::Step(_)) => 34,
            Self::Order(Order::Set { .. }) => 35,
        }
    }
}

impl From<Body> for Record {
    /// A record that stands alone.
    fn from(body: Body) -> Self {
        Self { more: 0, body }
    }
}

impl Record {
    /// The record as bytes. Of lists that are longer than their count can say, and of texts that are too long, the rest is left
    /// out.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(64);
        out.bytes(&MAGIC);
        out.u16(VERSION);
        out.u16(self.body.kind());
        out.u32(0);
        out.u32(self.more);
        match &self.body {
            Body::Hello(h) => put_hello(&mut out, h),
            Body::Snapshot(m) | Body::Step(m) => put_moment(&mut out, m),
            Body::Colonies { why, rays, rows } => {
                out.reserve(rows.len() * (COLONY + if *rays { 4 * RAYS } else { 0 }));
                out.u32(rows.len() as u32);
                out.u16(*why as u16);
                out.u16(if *rays { RAYS as u16 } else { 0 });
                for c in rows {
                    out.u64(c.id);
                    out.i32(c.settled);
                    out.u16(c.species);
                    out.u16(u16::from(c.bleached));
                    for v in [c.x, c.y, c.radius, c.height, c.bleaching, c.reach] {
                        out.f32(v);
                    }
                    if *rays {
                        c.rays.iter().for_each(|&r| out.f32(r));
                    }
                }
            }
            Body::Algae { why, rows } => {
                out.reserve(rows.len() * ALGA);
                out.u32(rows.len() as u32);
                out.u16(*why as u16);
                out.u16(0);
                for a in rows {
                    out.u64(a.id);
                    out.i32(a.settled);
                    out.u32(0);
                    for v in [a.x, a.y, a.radius, a.height] {
                        out.f32(v);
                    }
                }
            }
            Body::Gone(ids) => {
                out.u32(ids.len() as u32);
                out.u32(0);
                ids.iter().for_each(|&id| out.u64(id));
            }
            Body::Tile(t) => {
                out.reserve(4 * t.values.len());
                out.u16(t.layer);
                out.u16(0);
                [t.at, t.size].into_iter().flatten().for_each(|v| out.u32(v));
                out.u32(0);
                t.values.iter().for_each(|&v| out.f32(v));
            }
            Body::Status(s) => out.u32(*s as u32),
            Body::End { how, message } => {
                out.u32(*how as u32);
                out.text(message);
            }
            Body::Refused(message) => out.text(message),
            Body::Changed(c) => {
                out.u32(c.recipe_step);
                out.u32(0);
                out.u64(c.step);
                out.text(&c.set);
            }
            Body::Order(Order::Step(n)) => out.u64(*n),
            Body::Order(Order::Set { path, value }) => {
                out.text(path);
                out.text(value);
            }
            Body::Order(Order::Pause | Order::Resume) => {}
        }
        let length = out.len() as u32;
        out[8..12].copy_from_slice(&length.to_le_bytes());
        out
    }

    /// The record that these bytes are, all of them.
    ///
    /// # Errors
    /// If they are none of this version.
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut take = Take::new(bytes, 0);
        if !bytes.starts_with(&MAGIC) {
            return Err(take.wrong("this is no record: it does not begin with EYST"));
        }
        take = Take::new(bytes, MAGIC.len());
        let version = take.u16()?;
        if version != VERSION {
            return Err(Malformed { at: 4, what: format!("version {version}; this program speaks {VERSION}") });
        }
        let kind = take.u16()?;
        let length = take.u32()? as usize;
        if length != bytes.len() || length > MAX_RECORD {
            let what = format!("a record of {length} bytes in {}; at most {MAX_RECORD}", bytes.len());
            return Err(Malformed { at: 8, what });
        }
        let more = take.u32()?;
        let body = body(kind, &mut take)?;
        take.end()?;
        if more != 0
            && !matches!(
                body,
                Body::Snapshot(_)
                    | Body::Step(_)
                    | Body::Colonies { .. }
                    | Body::Algae { .. }
                    | Body::Gone(_)
                    | Body::Tile(_)
            )
        {
            return Err(Malformed { at: 12, what: "nothing can follow this record in its moment".to_owned() });
        }
        Ok(Self { more, body })
    }
}

impl Order {
    /// The order that a client's message is.
    ///
    /// # Errors
    /// If it is no record, or none of a client.
    pub fn decode(bytes: &[u8]) -> Result<Self, Malformed> {
        match Record::decode(bytes)?.body {
            Body::Order(order) => Ok(order),
            _ => Err(Malformed { at: 6, what: "only servers send records of this kind".to_owned() }),
        }
    }
}

fn body(kind: u16, take: &mut Take<'_>) -> Result<Body, Malformed> {
    Ok(match kind {
        1 => Body::Hello(hello(take)?),
        2 => Body::Snapshot(moment(take)?),
        3 => Body::Step(moment(take)?),
        4 => {
            let (count, why) = (take.u32()?, why(take)?);
            let rays = match take.u16()? {
                0 => false,
                n if usize::from(n) == RAYS => true,
                n => return Err(take.wrong(format!("{n} rays; there are 0 or {RAYS}"))),
            };
            let count = take.table(count.into(), COLONY + if rays { 4 * RAYS } else { 0 })?;
            let rows = (0..count).map(|_| colony(take, rays)).collect::<Result<_, _>>()?;
            Body::Colonies { why, rays, rows }
        }
        5 => {
            let (count, why) = (take.u32()?, why(take)?);
            take.zeros(2)?;
            let count = take.table(count.into(), ALGA)?;
            let rows = (0..count).map(|_| alga(take)).collect::<Result<_, _>>()?;
            Body::Algae { why, rows }
        }
        6 => {
            let count = take.u32()?;
            take.zeros(4)?;
            let count = take.table(count.into(), 8)?;
            Body::Gone((0..count).map(|_| take.u64()).collect::<Result<_, _>>()?)
        }
        7 => {
            let layer = take.u16()?;
            take.zeros(2)?;
            let [x, y, w, h] = [take.u32()?, take.u32()?, take.u32()?, take.u32()?];
            take.zeros(4)?;
            let count = take.table(u64::from(w) * u64::from(h), 4)?;
            let values = (0..count).map(|_| take.f32()).collect::<Result<_, _>>()?;
            Body::Tile(Tile { layer, at: [x, y], size: [w, h], values })
        }
        8 => Body::Status(match take.u32()? {
            0 => Status::Runs,
            1 => Status::Paused,
            2 => Status::Waits,
            3 => Status::Writes,
            n => return Err(take.wrong(format!("status {n}, which there is not"))),
        }),
        9 => {
            let how = match take.u32()? {
                0 => Ending::Done,
                1 => Ending::Stopped,
                2 => Ending::Failed,
                n => return Err(take.wrong(format!("ending {n}, which there is not"))),
            };
            Body::End { how, message: take.text()? }
        }
        10 => Body::Refused(take.text()?),
        11 => {
            let recipe_step = take.u32()?;
            take.zeros(4)?;
            Body::Changed(Changed { recipe_step, step: take.u64()?, set: take.text()? })
        }
        32 => Body::Order(Order::Pause),
        33 => Body::Order(Order::Resume),
        34 => match take.u64()? {
            n @ 1..=MAX_STEPS => Body::Order(Order::Step(n)),
            n => return Err(take.wrong(format!("{n} steps; ask for 1 to {MAX_STEPS}"))),
        },
        35 => Body::Order(Order::Set { path: take.text()?, value: take.text()? }),
        n => return Err(Malformed { at: 6, what: format!("kind {n}, which there is not") }),
    })
}

fn why(take: &mut Take<'_>) -> Result<Why, Malformed> {
    Ok(match take.u16()? {
        0 => Why::All,
        1 => Why::Born,
        2 => Why::Changed,
        n => return Err(take.wrong(format!("reason {n}, which there is not"))),
    })
}

fn put_hello(out: &mut Vec<u8>, h: &Hello) {
    const MAX: usize = u16::MAX as usize;
    out.u64(h.seed);
    h.size.into_iter().for_each(|v| out.u32(v));
    h.cell_m.into_iter().for_each(|v| out.f64(v));
    out.f64(h.sea_level_m);
    out.u64(h.every);
    out.u16(if h.rays { RAYS as u16 } else { 0 });
    out.u16(h.may as u16);
    for count in [h.species.len(), h.layers.len(), h.columns.len()] {
        out.u16(count.min(MAX) as u16);
    }
    out.bytes(&[0; 6]);
    out.text(&h.engine);
    out.text(&h.recipe);
    for s in h.species.iter().take(MAX) {
        out.text(&s.name);
        out.bytes(&[s.form, s.shape, s.colour[0], s.colour[1], s.colour[2]]);
    }
    for l in h.layers.iter().take(MAX) {
        out.text(&l.name);
        out.text(&l.unit);
        l.range.into_iter().for_each(|v| out.f32(v));
        out.u8(l.stagger);
    }
    h.columns.iter().take(MAX).for_each(|c| out.text(c));
}

fn hello(take: &mut Take<'_>) -> Result<Hello, Malformed> {
    let seed = take.u64()?;
    let size = [take.u32()?, take.u32()?];
    let cell_m = [take.f64()?, take.f64()?];
    let (sea_level_m, every) = (take.f64()?, take.u64()?);
    let rays = match take.u16()? {
        0 => false,
        n if usize::from(n) == RAYS => true,
        n => return Err(take.wrong(format!("{n} rays; there are 0 or {RAYS}"))),
    };
    let may = match take.u16()? {
        0 => Permission::Watch,
        1 => Permission::Pause,
        2 => Permission::Change,
        n => return Err(take.wrong(format!("permission {n}, which there is not"))),
    };
    let [species, layers, columns] = [take.u16()?, take.u16()?, take.u16()?];
    take.zeros(6)?;
    Ok(Hello {
        seed,
        size,
        cell_m,
        sea_level_m,
        every,
        rays,
        may,
        engine: take.text()?,
        recipe: take.text()?,
        species: (0..species)
            .map(|_| {
                let name = take.text()?;
                let [form, shape] = [take.u8()?, take.u8()?];
                Ok(SpeciesInfo { name, form, shape, colour: [take.u8()?, take.u8()?, take.u8()?] })
            })
            .collect::<Result<_, _>>()?,
        layers: (0..layers)
            .map(|_| {
                let (name, unit) = (take.text()?, take.text()?);
                Ok(LayerInfo { name, unit, range: [take.f32()?, take.f32()?], stagger: take.u8()? })
            })
            .collect::<Result<_, _>>()?,
        columns: (0..columns).map(|_| take.text()).collect::<Result<_, _>>()?,
    })
}

fn flag(take: &mut Take<'_>) -> Result<bool, Malformed> {
    match take.u16()? {
        0 => Ok(false),
        1 => Ok(true),
        n => Err(take.wrong(format!("{n} where 0 or 1 belongs"))),
    }
}

fn put_moment(out: &mut Vec<u8>, m: &Moment) {
    out.u64(m.number);
    out.u64(m.steps_done);
    m.step.into_iter().for_each(|v| out.u64(v));
    out.u32(m.recipe_step);
    out.f32(m.temperature_c);
    m.living.into_iter().for_each(|v| out.u32(v));
    out.u32(m.census.len() as u32);
    out.f32(m.sea_level_m);
    m.census.iter().for_each(|&v| out.f64(v));
}

fn moment(take: &mut Take<'_>) -> Result<Moment, Malformed> {
    let [number, steps_done, step, total] = [take.u64()?, take.u64()?, take.u64()?, take.u64()?];
    let (recipe_step, temperature_c) = (take.u32()?, take.f32()?);
    let living = [take.u32()?, take.u32()?];
    let (count, sea_level_m) = (take.u32()?, take.f32()?);
    let count = take.table(count.into(), 8)?;
    let census = (0..count).map(|_| take.f64()).collect::<Result<_, _>>()?;
    Ok(Moment { number, steps_done, recipe_step, step: [step, total], temperature_c, sea_level_m, living, census })
}

fn colony(take: &mut Take<'_>, has_rays: bool) -> Result<Colony, Malformed> {
    let (id, settled, species) = (take.u64()?, take.i32()?, take.u16()?);
    let bleached = flag(take)?;
    let [x, y, radius, height, bleaching, reach] =
        [take.f32()?, take.f32()?, take.f32()?, take.f32()?, take.f32()?, take.f32()?];
    let mut rays = [0.0; RAYS];
    if has_rays {
        for r in &mut rays {
            *r = take.f32()?;
        }
    }
    Ok(Colony { id, settled, species, bleached, x, y, radius, height, bleaching, reach, rays })
}

fn alga(take: &mut Take<'_>) -> Result<Alga, Malformed> {
    let (id, settled) = (take.u64()?, take.i32()?);
    take.zeros(4)?;
    Ok(Alga { id, settled, x: take.f32()?, y: take.f32()?, radius: take.f32()?, height: take.f32()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The offsets that the book prints.
    #[test]
    fn records_lie_as_the_table_says() {
        let c =
            Colony { id: 7, settled: -3, species: 2, bleached: true, radius: 0.5, reach: 0.75, ..Colony::default() };
        let bytes = Record::from(Body::Colonies { why: Why::Changed, rays: false, rows: vec![c] }).encode();
        assert_eq!(&bytes[..4], b"EYST");
        assert_eq!(bytes[4..16], [2, 0, 4, 0, 64, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[16..24], [1, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!((bytes[24], bytes[36], bytes[38]), (7, 2, 1));
        assert_eq!(bytes[32..36], (-3_i32).to_le_bytes());
        assert_eq!(
            (bytes[48..52].to_vec(), bytes[60..64].to_vec()),
            (0.5_f32.to_le_bytes().into(), 0.75_f32.to_le_bytes().into())
        );
        let pause = Record::from(Body::Order(Order::Pause)).encode();
        assert_eq!(pause, [b'E', b'Y', b'S', b'T', 2, 0, 32, 0, 16, 0, 0, 0, 0, 0, 0, 0]);
        let set = Order::Set { path: "a.b".into(), value: "1.5".into() };
        let bytes = Record::from(Body::Order(set)).encode();
        assert_eq!(bytes[6..10], [35, 0, 26, 0]);
        assert_eq!(bytes[16..], *b"\x03\0a.b\x03\x001.5");
        let changed = Changed { recipe_step: 2, step: 7, set: "a = 1".into() };
        let bytes = Record::from(Body::Changed(changed)).encode();
        assert_eq!((bytes[6], bytes[16], bytes[24]), (11, 2, 7));
        assert_eq!(bytes[32..], *b"\x05\0a = 1");
        let moment =
            Moment { steps_done: 5, sea_level_m: 3.0, temperature_c: 1.0, census: vec![2.0], ..Moment::default() };
        let bytes = Record { more: 3, body: Body::Step(moment) }.encode();
        assert_eq!((bytes.len(), bytes[12], bytes[24]), (80, 3, 5));
        assert_eq!(bytes[68..72], 3.0_f32.to_le_bytes());
        assert_eq!(
            (bytes[52..56].to_vec(), bytes[72..80].to_vec()),
            (1.0_f32.to_le_bytes().into(), 2.0_f64.to_le_bytes().into())
        );
    }

    #[test]
    fn what_a_client_may_not_send_is_refused() {
        let order = |o| Record::from(Body::Order(o)).encode();
        assert_eq!(Order::decode(&order(Order::Step(12))), Ok(Order::Step(12)));
        let mut cut = order(Order::Step(12));
        cut.pop();
        assert_eq!(Order::decode(&cut).unwrap_err().at, 8);
        let mut other = order(Order::Pause);
        other[4] = 9;
        assert_eq!(Order::decode(&other).unwrap_err().at, 4);
        assert!(Order::decode(&order(Order::Step(0))).is_err());
        assert!(Order::decode(&Record::from(Body::Gone(vec![1])).encode()).is_err());
        assert!(Order::decode(b"pause").unwrap_err().what.contains("EYST"));
    }

    /// A count that lies must not be believed before the bytes are there.
    #[test]
    fn counts_that_lie_are_refused() {
        let mut gone = Record::from(Body::Gone(vec![1, 2])).encode();
        gone[16..20].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(Record::decode(&gone).unwrap_err().what.contains("4294967295 rows"));
        let mut tile =
            Record::from(Body::Tile(Tile { size: [2, 1], values: vec![0.0; 2], ..Tile::default() })).encode();
        tile[28..36].fill(0xff);
        assert!(Record::decode(&tile).is_err());
    }
}
