//! Everybody who lives on a plot, as a component of its world: what a reef goes on from.

use super::colony::{Alga, Colony};
use super::forcing::Forcing;
use super::geometry::{RAYS, Rays, mean};
use super::parameters::{Community, bad};
use super::plot::Plot;
use super::site::Site;
use eyot_core::component::{Attribute, Decoder, Encoder, Numbers, Points, Shape, Values, View};
use eyot_core::{Component, ComponentKind, Fingerprint, Limits, Result};
use std::borrow::Cow;
use std::sync::Arc;

/// Begins the numbers of a population: version 1 of its encoding, and its share of the fingerprint.
const VERSION_1: f64 = 1.0;
/// Numbers before the individuals, and of one of them, in version 1.
const HEAD: usize = 10;
const COLONY: usize = 10 + RAYS;
const ALGA: usize = 6;
/// Bytes of an individual in version 2.
const COLONY_BYTES: u64 = 8 + 1 + 4 + 4 * (7 + RAYS as u64);
const ALGA_BYTES: u64 = 8 + 4 + 4 * 4;
/// Far higher than any alga grows, m.
const MAX_ALGA_M: f32 = 1e6;
/// Whole numbers beyond this are not exact.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Colonies, macroalgae and turf, and the dates of what is to come. Whether they fit a community and a place is seen by
/// [`Plot::of_population`].
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// Months done.
    pub(super) month: u64,
    pub(super) next_id: u64,
    /// Date and shortened interval of the next small and the next large disturbance.
    pub(super) calendars: [[f64; 2]; 2],
    pub(super) colonies: Vec<Colony>,
    /// Of the colonies, in their order.
    pub(super) rays: Vec<Rays>,
    pub(super) algae: Vec<Alga>,
    /// Cover of each cell of turf, row by row from the north.
    pub(super) turf: Vec<f32>,
}

/// How populations are read: version 1 is the list of numbers that worlds kept under `corals`.
pub static POPULATION: ComponentKind = ComponentKind {
    name: "reef.population",
    version: 2,
    formerly: &["corals"],
    decode: |version, from| {
        let population = match version {
            1 => of_numbers(from)?,
            _ => Population::decode(from)?,
        };
        population.check().map_err(|reason| from.wrong(reason))?;
        Ok(Arc::new(population))
    },
};

impl Population {
    /// Months done.
    pub const fn months(&self) -> u64 {
        self.month
    }

    /// Living colonies, in the order in which they came.
    pub fn colonies(&self) -> &[Colony] {
        &self.colonies
    }

    /// Lengths of the colonies' rays, m, in their order.
    pub fn rays(&self) -> &[Rays] {
        &self.rays
    }

    /// Living macroalgae, in the order in which they came.
    pub fn algae(&self) -> &[Alga] {
        &self.algae
    }

    /// What can be said without knowing the community and the place.
    fn check(&self) -> std::result::Result<(), String> {
        let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
        if self.calendars.as_flattened().iter().any(|d| !d.is_finite()) {
            return Err("dates that are not finite".into());
        }
        if self.month.max(self.next_id) as f64 >= MAX_EXACT {
            return Err(format!("month {} and individual {}, which no reef comes to", self.month, self.next_id));
        }
        // Dates before this month would all be made up for, one after the other.
        if self.calendars.iter().any(|[next, shrunk]| *next < self.month as f64 || !(0.0..=1.0).contains(shrunk)) {
            return Err(format!("disturbances before month {}, or at no interval", self.month));
        }
        for (c, rays) in self.colonies.iter().zip(&self.rays) {
            let longest = rays.iter().copied().fold(0.0, f32::max);
            let sound = finite(rays)
                && finite(&[c.x, c.y, c.radius, c.calcified_kg])
                && [c.bleaching, c.light, c.vigour].iter().all(|share| (0.0..=1.0).contains(share))
                && rays.iter().all(|r| *r >= 0.0)
                && (mean(rays) - c.radius).abs() <= 1e-3 * longest;
            if !sound {
                return Err(format!("colony {} is none", c.id));
            }
        }
        let sound =
            |a: &Alga| finite(&[a.x, a.y]) && [a.radius, a.height].iter().all(|v| (0.0..=MAX_ALGA_M).contains(v));
        match self.algae.iter().find(|a| !sound(a)) {
            Some(a) => Err(format!("alga {} is none", a.id)),
            None if self.turf.iter().any(|c| !(0.0..=1.0).contains(c)) => Err("turf beyond 0 to 1".into()),
            None => Ok(()),
        }
    }

    /// Hands out the numbers of version 1: version, month, next id, colonies, algae, cells of turf, next date and interval of small and
    /// of large disturbances; then each colony (id, species, age, x, y, radius, bleaching, light, vigour, limestone, 24 rays), each
    /// alga (id, age, x, y, radius, height), each cell of turf.
    fn numbers(&self, mut add: impl FnMut(f64)) {
        let counts = [self.colonies.len(), self.algae.len(), self.turf.len()].map(|n| n as f64);
        [VERSION_1, self.month as f64, self.next_id as f64].into_iter().chain(counts).for_each(&mut add);
        self.calendars.as_flattened().iter().copied().for_each(&mut add);
        for (c, rays) in self.colonies.iter().zip(&self.rays) {
            [c.id as f64, f64::from(c.species), f64::from(c.age)].into_iter().for_each(&mut add);
            let values = [c.x, c.y, c.radius, c.bleaching, c.light, c.vigour, c.calcified_kg];
            values.iter().chain(rays).for_each(|v| add(f64::from(*v)));
        }
        for a in &self.algae {
            [a.id as f64, f64::from(a.age)].into_iter().for_each(&mut add);
            [a.x, a.y, a.radius, a.height].into_iter().for_each(|v| add(f64::from(v)));
        }
        self.turf.iter().for_each(|c| add(f64::from(*c)));
    }

    fn decode(from: &mut Decoder<'_>) -> Result<Self> {
        let (month, next_id) = (from.u64()?, from.u64()?);
        let calendars = [[from.f64()?, from.f64()?], [from.f64()?, from.f64()?]];
        let (mut colonies, mut rays) = (Vec::new(), Vec::new());
        for _ in 0..from.count(COLONY_BYTES)? {
            let (id, species, age) = (from.u64()?, from.u8()?, from.u32()?);
            let mut next = || from.f32();
            let [x, y, radius] = [next()?, next()?, next()?];
            let [bleaching, light, vigour, calcified_kg] = [next()?, next()?, next()?, next()?];
            let mut lengths = [0.0; RAYS];
            for length in &mut lengths {
                *length = next()?;
            }
            colonies.push(Colony { id, species, age, x, y, radius, bleaching, light, vigour, calcified_kg });
            rays.push(lengths);
        }
        let mut algae = Vec::new();
        for _ in 0..from.count(ALGA_BYTES)? {
            let (id, age) = (from.u64()?, from.u32()?);
            let [x, y, radius, height] = [from.f32()?, from.f32()?, from.f32()?, from.f32()?];
            algae.push(Alga { id, age, x, y, radius, height });
        }
        let cells = from.count(4)?;
        Ok(Self { month, next_id, calendars, colonies, rays, algae, turf: from.f32s(cells)? })
    }
}

/// Version 1.
fn of_numbers(from: &mut Decoder<'_>) -> Result<Population> {
    let Numbers(numbers) = Numbers::decode(from)?;
    let Some((head, rest)) = numbers.split_at_checked(HEAD) else { return Err(from.wrong("too few numbers")) };
    if head[0] != VERSION_1 || numbers.iter().any(|n| !n.is_finite()) {
        return Err(from.wrong("numbers of another kind"));
    }
    if head[1..6].iter().any(|n| !(0.0..MAX_EXACT).contains(n) || n.fract() != 0.0) {
        return Err(from.wrong("counts that are none"));
    }
    let [colonies, algae, turf] = [head[3], head[4], head[5]].map(|n| n as usize);
    let expected = colonies as u128 * COLONY as u128 + algae as u128 * ALGA as u128 + turf as u128;
    if expected != rest.len() as u128 {
        return Err(from.wrong(format!("{} numbers for {expected} and {HEAD}", numbers.len())));
    }
    let (colonies, rest) = rest.split_at(colonies * COLONY);
    let (algae, turf) = rest.split_at(algae * ALGA);
    let colony = |n: &[f64]| {
        let [x, y, radius, bleaching, light, vigour, calcified_kg] = std::array::from_fn(|i| n[3 + i] as f32);
        let (id, species, age) = (n[0] as u64, n[1] as u8, n[2] as u32);
        Colony { id, species, age, x, y, radius, bleaching, light, vigour, calcified_kg }
    };
    let alga = |n: &[f64]| {
        let [x, y, radius, height] = std::array::from_fn(|i| n[2 + i] as f32);
        Alga { id: n[0] as u64, age: n[1] as u32, x, y, radius, height }
    };
    Ok(Population {
        month: head[1] as u64,
        next_id: head[2] as u64,
        calendars: [[head[6], head[7]], [head[8], head[9]]],
        rays: colonies.chunks_exact(COLONY).map(|n| std::array::from_fn(|i| n[10 + i] as f32)).collect(),
        colonies: colonies.chunks_exact(COLONY).map(colony).collect(),
        algae: algae.chunks_exact(ALGA).map(alga).collect(),
        turf: turf.iter().map(|c| *c as f32).collect(),
    })
}

impl Component for Population {
    fn kind(&self) -> &'static ComponentKind {
        &POPULATION
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        out.u64(self.month);
        out.u64(self.next_id);
        out.f64s(self.calendars.as_flattened());
        out.count(self.colonies.len());
        for (c, rays) in self.colonies.iter().zip(&self.rays) {
            out.u64(c.id);
            out.u8(c.species);
            out.u32(c.age);
            out.f32s(&[c.x, c.y, c.radius, c.bleaching, c.light, c.vigour, c.calcified_kg]);
            out.f32s(rays);
        }
        out.count(self.algae.len());
        for a in &self.algae {
            out.u64(a.id);
            out.u32(a.age);
            out.f32s(&[a.x, a.y, a.radius, a.height]);
        }
        out.count(self.turf.len());
        out.f32s(&self.turf);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        self.numbers(|n| print.number(n));
    }

    fn bytes(&self) -> usize {
        let individuals = size_of_val(&*self.colonies) + size_of_val(&*self.rays) + size_of_val(&*self.algae);
        individuals + size_of_val(&*self.turf)
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("colonies", Shape::Points), ("algae", Shape::Points)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        let points = match name {
            "colonies" => {
                let all = || self.colonies.iter();
                let single = |of: fn(&Colony) -> f32| Values::F32(all().map(of).collect());
                let columns = vec![
                    column("id", "1", Values::U64(all().map(|c| c.id).collect())),
                    column("species", "1", Values::U8(all().map(|c| c.species).collect())),
                    column("age", "month", Values::U32(all().map(|c| c.age).collect())),
                    column("radius", "m", single(|c| c.radius)),
                    column("bleaching", "1", single(|c| c.bleaching)),
                    column("calcified", "kg", single(|c| c.calcified_kg)),
                ];
                Points::of(all().map(|c| [c.x, c.y, 0.0]).collect(), columns)
            }
            "algae" => {
                let all = || self.algae.iter();
                let columns = vec![
                    column("id", "1", Values::U64(all().map(|a| a.id).collect())),
                    column("age", "month", Values::U32(all().map(|a| a.age).collect())),
                    column("radius", "m", Values::F32(all().map(|a| a.radius).collect())),
                    column("height", "m", Values::F32(all().map(|a| a.height).collect())),
                ];
                Points::of(all().map(|a| [a.x, a.y, 0.0]).collect(), columns)
            }
            _ => return None,
        };
        points.ok().map(|points| View::Points(Cow::Owned(points)))
    }
}

fn column(name: &str, unit: &str, values: Values) -> Attribute {
    Attribute { name: name.to_owned(), unit: unit.to_owned(), values }
}

impl Plot {
    /// The plot that a population goes on living on: from the same month to the same bits.
    ///
    /// # Errors
    /// As [`Plot::new`], or if the population is not one of such a plot.
    pub fn of_population(
        community: Community,
        site: Site,
        forcing: Forcing,
        seed: u64,
        limits: Limits,
        population: Population,
    ) -> Result<Self> {
        let mut plot = Self::empty(community, site, forcing, seed, limits)?;
        plot.check_fits(&population)
            .map_err(|what| bad("community", "saved state", format!("{what}; it does not belong to this reef")))?;
        let Population { month, next_id, calendars, colonies, rays, algae, turf } = population;
        for (calendar, [next, shrunk]) in plot.calendars.iter_mut().zip(calendars) {
            (calendar.next, calendar.shrunk) = (next, shrunk);
        }
        (plot.month, plot.next_id) = (month, next_id);
        (plot.colonies, plot.rays, plot.algae) = (colonies, rays, algae);
        plot.turf.cover_mut().copy_from_slice(&turf);
        Ok(plot)
    }

    /// What can only be said of a population with its community and its place.
    fn check_fits(&self, population: &Population) -> std::result::Result<(), String> {
        for (c, rays) in population.colonies.iter().zip(&population.rays) {
            let species = self.community.species.get(usize::from(c.species));
            let longest = species.map_or(0.0, |s| 1.001 * s.max_radius);
            let sound =
                rays.iter().all(|r| (0.0..=longest).contains(r)) && (mean(rays) - c.radius).abs() <= 1e-3 * longest;
            if !sound || !self.keeps(c.x, c.y) {
                return Err(format!("colony {}", c.id));
            }
        }
        let fits = |a: &Alga| (0.0..=self.community.algae.max_radius).contains(&a.radius) && self.keeps(a.x, a.y);
        if let Some(a) = population.algae.iter().find(|a| !fits(a)) {
            return Err(format!("alga {}", a.id));
        }
        let (found, cells) = (population.turf.len(), self.turf.cover().len());
        if found != cells { Err(format!("turf of {found} cells, not {cells}")) } else { Ok(()) }
    }

    /// Everybody who lives on the plot, and what else it goes on from.
    pub fn into_population(self) -> Population {
        Population {
            month: self.month,
            next_id: self.next_id,
            calendars: self.calendars.map(|c| [c.next, c.shrunk]),
            colonies: self.colonies,
            rays: self.rays,
            algae: self.algae,
            turf: self.turf.into_cover(),
        }
    }
}
