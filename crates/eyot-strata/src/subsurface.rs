//! What lies below each place of a world: ordered runs of material, from the surface down.
//!
//! This is the one place that knows how layers and the [`Sequence`] of beds make a column. Sections, the cut sides of block pictures and
//! exports all ask it.
//!
//! From the top down a column is sand (`sand`), reef limestone (`limestone`), other loose ground (down to `bedrock`), new rock
//! (`new_rock_1` to `new_rock_6`), and the beds. The bottom of bed `i` lies at `D - (t_1 + ... + t_i)`, with `D` of the layer `bed_datum` and the
//! thicknesses `t` of the sequence; where it has a surface of its own (`bed_1` to `bed_4`), that much lower or at that depth, but never above
//! the bottom of the bed over it: equation (3) of the process `strata`. A world without strata has plain ground below sand and limestone.

use crate::materials::colour;
use crate::sequence::Sequence;
use crate::strata::{BED_DATUM, BED_SURFACES, BEDROCK, NEW_ROCK, SLOTS, SURFACES, Surfaces};
use eyot_core::layer::known::{HEIGHT, LIMESTONE, SAND};
use eyot_core::{Field, Result, World};

/// Runs that a column has at most; the last one then goes on to the floor. Sequences that repeat could have millions.
pub const MOST_RUNS: usize = 1024;

/// A kind of ground in a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Its name in legends.
    pub name: String,
    /// Its colour, sRGB.
    pub colour: [u8; 3],
}

/// A stretch of one kind of ground in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Its place in [`Subsurface::kinds`]. With strata those are the materials by their numbers, and then what no material is.
    pub kind: usize,
    /// Which bed it is, counted down from the uppermost of the sequence, which is 0; below 0 in a repetition above that. `None` for what
    /// lies on the bedrock, and in worlds without strata.
    pub bed: Option<i32>,
    /// Height of its top, m.
    pub top_m: f64,
    /// Height of its bottom, m.
    pub bottom_m: f64,
}

impl Run {
    /// How thick it is, m.
    pub fn thickness_m(&self) -> f64 {
        self.top_m - self.bottom_m
    }
}

/// What a column is made of, m.
#[derive(Clone, Copy, Debug)]
struct Heights {
    height: f64,
    bedrock: f64,
    datum: f64,
    sand: f64,
    limestone: f64,
    new_rock: [f64; SLOTS],
    surfaces: [f64; SURFACES],
}

/// The ground of a world below its surface. See the head of this file.
#[derive(Debug)]
pub struct Subsurface<'a> {
    height: &'a Field,
    bedrock: Option<&'a Field>,
    datum: Option<&'a Field>,
    sand: Option<&'a Field>,
    limestone: Option<&'a Field>,
    new_rock: [Option<&'a Field>; SLOTS],
    surfaces: [Option<&'a Field>; SURFACES],
    sequence: Option<&'a Sequence>,
    kinds: Vec<Kind>,
    /// Places in `kinds` of loose ground, of ground that no bed is known of, of sand and of limestone.
    loose: usize,
    ground: usize,
    sand_kind: usize,
    limestone_kind: usize,
}

impl<'a> Subsurface<'a> {
    /// That of a world.
    ///
    /// # Errors
    /// If the world has no layer `height`, or its strata are damaged.
    pub fn of(world: &'a World) -> Result<Self> {
        let height = &world.layer(&HEIGHT.name)?.field;
        let layer = |name: &str| world.get(name).filter(|f| f.shape() == height.shape());
        let (bedrock, datum) = (layer(&BEDROCK.name), layer(&BED_DATUM.name));
        let sequence = Sequence::of(world)?.filter(|_| bedrock.is_some() && datum.is_some());
        let mut kinds: Vec<Kind> =
            sequence.into_iter().flat_map(|s| &s.materials).enumerate().map(of_material).collect();
        let mut more = |name: &str, colour| {
            kinds.push(Kind { name: name.to_owned(), colour });
            kinds.len() - 1
        };
        let ground = more(if bedrock.is_some() { "bedrock" } else { "ground" }, [150, 134, 116]);
        let sand_kind = more("sand and soil", [222, 200, 146]);
        let limestone_kind = more("reef limestone", [238, 228, 204]);
        let loose = match sequence {
            Some(s) => usize::from(s.loose),
            None => more("loose ground", colour(0)),
        };
        let (sand, limestone) = (layer(&SAND.name), layer(&LIMESTONE.name));
        let stages = sequence.is_some_and(|s| !s.stages.is_empty());
        let new_rock = NEW_ROCK.map(|s| layer(&s.name).filter(|_| stages));
        let bent = sequence.is_some_and(|s| s.surfaces != Surfaces::Flat);
        let surfaces = BED_SURFACES.map(|s| layer(&s.name).filter(|_| bent));
        Ok(Self {
            height,
            bedrock,
            datum,
            sand,
            limestone,
            new_rock,
            surfaces,
            sequence,
            kinds,
            loose,
            ground,
            sand_kind,
            limestone_kind,
        })
    }

    /// Everything that columns can be made of.
    pub fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    /// The beds, if the world has strata.
    pub fn sequence(&self) -> Option<&'a Sequence> {
        self.sequence
    }

    /// Puts the runs of a cell down to `floor_m` into `out`, from the surface down; each is thicker than 0.
    pub fn of_cell(&self, x: usize, y: usize, floor_m: f64, out: &mut Vec<Run>) {
        self.column(self.heights(x, y), floor_m, out);
    }

    /// Thickness of each kind of ground in a cell down to `floor_m`, m, into `sums`, in the order of [`Subsurface::kinds`]. Unlike the runs, of
    /// which there are at most [`MOST_RUNS`], it is right for any number of repetitions of the beds; `runs` is for its own use.
    pub fn thicknesses(&self, x: usize, y: usize, floor_m: f64, runs: &mut Vec<Run>, sums: &mut [f64]) {
        let heights = self.heights(x, y);
        self.column(heights, floor_m, runs);
        sums.fill(0.0);
        if let (Some(sequence), Some(last)) = (self.sequence.filter(|s| s.repeat), runs.last().copied())
            && let Some(bed) = last.bed
        {
            let count = sequence.beds.len() as i32;
            let thickness = f64::from(sequence.beds[bed.rem_euclid(count) as usize].thickness_m);
            if last.thickness_m() > 1.5 * thickness {
                // The run in which the list of runs ended stands for all that follow.
                runs.pop();
                sequence.add_between(heights.datum - last.top_m, heights.datum - last.bottom_m, sums);
            }
        }
        runs.iter().for_each(|r| sums[r.kind] += r.thickness_m());
    }

    /// Height of the top of a bed in a cell, worn away or not, m. Beds are counted from 0; of a sequence that repeats it is that of the first
    /// turn. `None` if the world has no such bed.
    pub fn top_of_bed(&self, x: usize, y: usize, bed: usize) -> Option<f64> {
        let sequence = self.sequence.filter(|s| bed < s.beds.len())?;
        let h = self.heights(x, y);
        let (mut depth, mut top) = (0.0, f64::INFINITY);
        for (n, above) in sequence.beds[..bed].iter().enumerate() {
            depth += f64::from(above.thickness_m);
            top = (h.datum - bottom_below_datum(sequence, &h, n, depth)).min(top);
        }
        Some(if bed == 0 { h.datum } else { top })
    }

    fn heights(&self, x: usize, y: usize) -> Heights {
        let height = f64::from(self.height.get(x, y));
        let of = |field: Option<&Field>, else_: f64| field.map_or(else_, |f| f64::from(f.get(x, y)));
        Heights {
            height,
            bedrock: of(self.bedrock, height),
            datum: of(self.datum, 0.0),
            sand: of(self.sand, 0.0),
            limestone: of(self.limestone, 0.0),
            new_rock: self.new_rock.map(|f| of(f, 0.0)),
            surfaces: self.surfaces.map(|f| of(f, 0.0)),
        }
    }

    /// As [`Subsurface::of_cell`] between the middles of cells: a place in columns and rows, 0 in the middle of the first cell. Surfaces
    /// run straight from cell to cell; beds lie in each cell as they do towards that neighbour to which they bend less, so that
    /// faults stay steps.
    pub fn at(&self, x: f64, y: f64, floor_m: f64, out: &mut Vec<Run>) {
        let of = |field: Option<&Field>, else_: f64| field.map_or(else_, |f| between(f, x, y));
        let height = between(self.height, x, y);
        self.column(
            Heights {
                height,
                bedrock: of(self.bedrock, height),
                datum: self.datum.map_or(0.0, |f| leaning(f, x, y)),
                sand: of(self.sand, 0.0),
                limestone: of(self.limestone, 0.0),
                new_rock: self.new_rock.map(|f| of(f, 0.0)),
                surfaces: self.surfaces.map(|f| of(f, 0.0)),
            },
            floor_m,
            out,
        );
    }

    fn column(&self, h: Heights, floor_m: f64, out: &mut Vec<Run>) {
        out.clear();
        let bedrock = h.bedrock.min(h.height);
        let mut top = h.height.max(floor_m);
        let mut lay = |kind: usize, bed: Option<i32>, bottom: f64| {
            let bottom_m = bottom.max(floor_m);
            if bottom_m < top {
                match out.last_mut() {
                    Some(above) if above.kind == kind && above.bed == bed => above.bottom_m = bottom_m,
                    _ => out.push(Run { kind, bed, top_m: top, bottom_m }),
                }
                top = bottom_m;
            }
            top > floor_m
        };
        // Sand and limestone are parts of the height; with a bedrock, of what lies on it.
        let lowest = if self.bedrock.is_some() { bedrock } else { f64::NEG_INFINITY };
        let sand = (h.height - h.sand.max(0.0)).max(lowest);
        lay(self.sand_kind, None, sand);
        let limestone = (sand - h.limestone.max(0.0)).max(lowest);
        lay(self.limestone_kind, None, limestone);
        lay(self.loose, None, bedrock.min(limestone));
        let Some(sequence) = self.sequence else {
            lay(self.ground, None, f64::NEG_INFINITY);
            return;
        };
        let mut rock = bedrock;
        for (stage, thickness) in sequence.stages.iter().zip(h.new_rock) {
            rock -= thickness.max(0.0);
            lay(usize::from(*stage), None, rock);
        }
        let (count, whole) = (sequence.beds.len(), sequence.thickness_m());
        let turn = if sequence.repeat { ((h.datum - rock) / whole).floor() } else { 0.0 };
        let mut depth = turn * whole;
        let mut bottom = f64::INFINITY;
        for n in 0..MOST_RUNS.max(count) {
            let bed = &sequence.beds[n % count];
            depth += f64::from(bed.thickness_m);
            let last = if sequence.repeat { n + 1 >= MOST_RUNS } else { n + 1 >= count };
            let lower = if last { f64::INFINITY } else { bottom_below_datum(sequence, &h, n, depth) };
            bottom = (h.datum - lower).min(bottom);
            let number = (turn as i64 * count as i64 + n as i64) as i32;
            if !lay(usize::from(bed.material), Some(number), bottom) || last {
                return;
            }
        }
    }
}

/// Depth of the bottom of bed `n` below the datum, m, before it gives way to that above it; `depth` is the sum of the thicknesses.
fn bottom_below_datum(sequence: &Sequence, h: &Heights, n: usize, depth: f64) -> f64 {
    match (sequence.surfaces, h.surfaces.get(n)) {
        (Surfaces::Lower, Some(lower)) => depth + lower,
        (Surfaces::Height, Some(height)) => f64::from(sequence.top_m) - height,
        _ => depth,
    }
}

/// A material by its number, and its colour.
fn of_material((number, m): (usize, &crate::Material)) -> Kind {
    Kind { name: m.name.clone(), colour: m.shown(number) }
}

/// A place between two cells of `n`: both, and how far it is on the way.
fn interval(at: f64, n: usize) -> (usize, usize, f64) {
    let at = at.clamp(0.0, (n - 1) as f64);
    let first = (at as usize).min(n - 1);
    (first, (first + 1).min(n - 1), at - first as f64)
}

/// The value between the middles of four cells.
fn between(f: &Field, x: f64, y: f64) -> f64 {
    let ((x0, x1, u), (y0, y1, v)) = (interval(x, f.width()), interval(y, f.height()));
    let row = |y: usize| {
        let (a, b) = (f64::from(f.get(x0, y)), f64::from(f.get(x1, y)));
        a + (b - a) * u
    };
    let (north, south) = (row(y0), row(y1));
    north + (south - north) * v
}

/// The value at a place of a cell that leans towards its neighbours as its smaller differences say.
fn leaning(f: &Field, x: f64, y: f64) -> f64 {
    let cell = |at: f64, n: usize| (at.round().clamp(0.0, (n - 1) as f64)) as usize;
    let (cx, cy) = (cell(x, f.width()), cell(y, f.height()));
    let here = f64::from(f.get(cx, cy));
    let smaller = |before: Option<f64>, after: Option<f64>| match (before, after) {
        (Some(a), Some(b)) => {
            if a.abs() <= b.abs() {
                a
            } else {
                b
            }
        }
        (a, b) => a.or(b).unwrap_or(0.0),
    };
    let value = |x: usize, y: usize| f64::from(f.get(x, y));
    let lean_x =
        smaller((cx > 0).then(|| here - value(cx - 1, cy)), (cx + 1 < f.width()).then(|| value(cx + 1, cy) - here));
    let lean_y =
        smaller((cy > 0).then(|| here - value(cx, cy - 1)), (cy + 1 < f.height()).then(|| value(cx, cy + 1) - here));
    here + lean_x * (x - cx as f64) + lean_y * (y - cy as f64)
}
