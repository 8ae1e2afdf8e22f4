//! A world of plates, and one step of it.

use crate::budget::Budget;
use crate::changes::Changes;
use crate::collision::{brake, brake_at_rim, fold, reach};
use crate::course::Course;
use crate::crust::{HIGHEST_M, is_continental, metres, nearest_units};
use crate::drift::{Borders, Maps, drift};
use crate::erosion;
use crate::geometry::{Geometry, rows_at_once};
use crate::growth::unit;
use crate::isostasy::crust_m;
use crate::level::{aim, at_once, correction, heights};
use crate::meeting::{Contact, Kind, Polarity};
use crate::motion;
use crate::pairs::Pairs;
use crate::parameters::Tectonics;
use crate::parts;
use crate::plate::{Plate, PlateInfo};
use crate::restart;
use crate::ridge;
use crate::runs::{self, Run};
use crate::start::{self, Start};
use crate::subduction::{Arcs, Volcanoes, scrape};
use crate::suture;
use eyot_core::process::check_ranges;
use eyot_core::rng::mix64;
use eyot_core::{BoundaryCondition, Error, Grid, Result};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rivers and waves work in every so many steps, for as many steps.
const EROSION_EVERY: u64 = 4;
/// Crust is carried from the land to the shelves in every so many steps, for as many: a multiple of the above.
const DENUDATION_EVERY: u64 = 8;
/// Borders are tidied in every so many steps.
const TIDY_EVERY: u64 = 4;
/// A part that is cut off is a plate of its own from this share of the world on.
const OWN_PLATE: f64 = 0.01;
/// Plates below this share of the world join a neighbour.
const SMALLEST_PLATE: f64 = 0.002;
/// Most plates that there can be: more are not made by cutting.
const MAX_PLATES: usize = 100;
/// A cycle is no shorter, Myr, unless it is asked for.
const SHORTEST_MYR: f64 = 25.0;
/// A cycle ends when one plate has grown to this share of the world.
const LARGEST_PLATE: f64 = 0.7;
/// Pairs that grow together at once.
const MAX_SUTURES: usize = 8;
/// How much more a plate must bring to a border than the other one to turn its polarity, cells.
const TURN: (f64, f64) = (1.5, 6.0);
/// Cosine of the angle to a border from which on a plate sinks there and does not slide along it.
pub(crate) const SLIDES: f64 = 0.35;
/// What is left of the memory of a border after a step.
const BORDER_MEMORY: f64 = 0.95;

/// What belongs to no cell and to no plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    /// Steps done.
    pub(crate) steps: u64,
    /// Cycles begun, from 1.
    pub(crate) cycle: u64,
    /// Time since the cycle began, Myr.
    pub(crate) since_myr: f64,
    /// Level of the sea in buoyancy for which the heights are, m.
    pub(crate) level: f64,
    /// What it rises by before the next heights, m.
    pub(crate) rise: f64,
    /// Share of land that the level aims at, on its way to the asked one.
    pub(crate) aim: f64,
    /// Restarts asked for when the last one was made.
    pub(crate) restarts: u32,
    /// True once the last cycle is over.
    pub(crate) at_rest: bool,
}

/// Plates on a grid: a step moves them, and folds, sinks and makes crust at their borders.
///
/// ```
/// use eyot_core::{Grid, Limits, Boundary};
/// use eyot_plates::{Plates, Start, Tectonics};
///
/// let grid = Grid::new(96, 48, 400_000.0, Boundary::WRAP, &Limits::default())?;
/// let mut plates = Plates::new(&grid, 7, Tectonics::default(), Start::Noise)?;
/// for _ in 0..50 {
///     plates.step();
/// }
/// let land = plates.height().iter().filter(|h| **h > 0.0).count();
/// assert!((land as f64 / (96.0 * 48.0) - 0.3).abs() < 0.03);
/// # Ok::<(), eyot_core::Error>(())
/// ```
pub struct Plates {
    pub(crate) g: Geometry,
    pub(crate) seed: u64,
    pub(crate) parameters: Tectonics,
    pub(crate) maps: Maps,
    pub(crate) height: Vec<f32>,
    pub(crate) plates: Vec<Plate>,
    /// Area lost in collisions, km2; only pairs with the lower number first.
    pub(crate) overlap: Pairs,
    /// Continental cells that a plate brought to the border with another one, lately.
    pub(crate) brought: Pairs,
    /// 1 where a plate overrides another one.
    pub(crate) over: Pairs,
    pub(crate) clock: Clock,
    pub(crate) budget: Budget,
    pub(crate) volcanoes: Volcanoes,
    /// True if somebody wants to know how far the plates go.
    pub(crate) followed: bool,
    /// How far they went in the last step; `None` if none went anywhere.
    pub(crate) course: Option<Course>,
    /// The maps of the step before: memory to write the next into.
    pub(crate) spare: Maps,
}

impl Plates {
    /// Makes crust and plates.
    ///
    /// # Errors
    /// If a parameter is out of its range or cannot work on this grid, or a given height has not one finite value for each cell.
    pub fn new(grid: &Grid, seed: u64, parameters: Tectonics, start: Start<'_>) -> Result<Self> {
        check(&parameters, grid)?;
        let g = Geometry::new(grid);
        let crust = match start {
            Start::Noise => start::from_noise(&g, seed, f64::from(parameters.land), parameters.gather),
            Start::Height(height) if height.len() == g.cells() && height.iter().all(|h| h.is_finite()) => {
                start::from_height(height)
            }
            Start::Height(height) => {
                let finite = height.iter().filter(|h| h.is_finite()).count();
                return Err(Error::Shape {
                    what: "finite heights of a start".into(),
                    expected: g.cells(),
                    found: finite,
                });
            }
        };
        let mut plates = Self {
            g,
            seed,
            maps: Maps { owner: vec![0; g.cells()], crust: crust.thickness, age: crust.age },
            height: vec![0.0; g.cells()],
            plates: Vec::new(),
            overlap: Pairs::default(),
            brought: Pairs::default(),
            over: Pairs::default(),
            clock: Clock {
                steps: 0,
                cycle: 0,
                since_myr: 0.0,
                level: crust.level,
                rise: 0.0,
                aim: 0.0,
                restarts: parameters.restarts,
                at_rest: false,
            },
            budget: Budget::default(),
            volcanoes: Volcanoes::new(&g, seed),
            followed: false,
            course: None,
            spare: Maps::empty(g.cells()),
            parameters,
        };
        plates.budget.start = plates.crust_units();
        let Self { maps, height, clock, .. } = &mut plates;
        let coast = heights(g.width, &maps.crust, &mut maps.age, 0.0, clock.level, height);
        clock.aim = coast.land() as f64 / g.cells() as f64;
        plates.restart();
        Ok(plates)
    }

    /// One step of `years_per_step`.
    pub fn step(&mut self) {
        self.course = None;
        if self.parameters.restarts != self.clock.restarts {
            self.clock.restarts = self.parameters.restarts;
            self.clock.at_rest = false;
            self.restart();
        }
        self.clock.steps += 1;
        // Before the plates move: then heights and crust are those of the same cells.
        if self.clock.steps.is_multiple_of(EROSION_EVERY) {
            self.erode();
        }
        if !self.clock.at_rest {
            self.move_plates();
        }
        let myr = self.parameters.myr_per_step();
        let Self { g, maps, height, clock, .. } = self;
        clock.level += clock.rise;
        let mut coast = heights(g.width, &maps.crust, &mut maps.age, myr as f32, clock.level, height);
        if let Some(rise) = at_once(coast, height, clock.aim) {
            clock.level += rise;
            coast = heights(g.width, &maps.crust, &mut maps.age, 0.0, clock.level, height);
        }
        clock.aim = aim(clock.aim, coast.land() as f64 / g.cells() as f64, f64::from(self.parameters.land));
        clock.rise = correction(coast, g.cells(), clock.aim);
        clock.since_myr += myr;
        if !clock.at_rest {
            self.end_cycle();
        }
    }

    fn move_plates(&mut self) {
        motion::accelerate(&mut self.plates, &self.parameters);
        let years = f64::from(self.parameters.years_per_step);
        let parts = motion::shifts(&self.g, &self.plates, years);
        self.overlap.scale(suture::MEMORY);
        self.brought.scale(BORDER_MEMORY);
        for plate in &mut self.plates {
            plate.pull = plate.pull.map(|p| 0.9 * p);
        }
        let mut ways = vec![(0, 0); self.plates.len()];
        for _ in 0..parts {
            let rows = runs::of_rows(&self.maps.owner, self.g.width);
            let areas = runs::areas(&rows, self.plates.len());
            let borders = runs::borders(&self.g, &rows, self.plates.len());
            let shifts = motion::shift(&self.g, &mut self.plates, years, parts, &areas, &borders);
            if shifts.iter().any(|&s| s != (0, 0)) {
                self.shift(&rows, &areas, &shifts);
                let add = |way: &mut (isize, isize), s: &(i8, i8)| {
                    *way = (way.0 + isize::from(s.0), way.1 + isize::from(s.1));
                };
                ways.iter_mut().zip(&shifts).for_each(|(way, s)| add(way, s));
            }
        }
        if self.followed {
            self.course = Course::new(&self.g, &self.maps.owner, ways);
        }
        if self.clock.steps.is_multiple_of(TIDY_EVERY) {
            self.tidy();
        }
    }

    /// Moves plates by whole cells and settles what happens at their borders.
    fn shift(&mut self, rows: &[Vec<Run>], areas: &[u32], shifts: &[(i8, i8)]) {
        let over: Vec<bool> = self.over.values().iter().map(|&v| v > 0.0).collect();
        let polarity = Polarity { plates: self.plates.len(), over: &over };
        let borders = drift(&self.g, rows, &self.maps, &mut self.spare, shifts, &polarity);
        std::mem::swap(&mut self.maps, &mut self.spare);
        let Borders { gaps, contacts } = borders;
        let mut changes = Changes::default();
        self.budget.ridges +=
            ridge::fill(&self.g, &self.maps, &gaps, (&self.plates, shifts), self.parameters.stretch, &mut changes);
        self.settle(&contacts, areas, &mut changes);
        self.budget.delaminated += changes.apply(&self.g, &mut self.maps.crust, self.parameters.max_crust);
        self.turn_polarity();
    }

    /// Folds and sinks what lost its cell, and lets the plates feel it.
    fn settle(&mut self, contacts: &[Contact], areas: &[u32], changes: &mut Changes) {
        let n = self.plates.len();
        let mut fronts = Pairs::new(n);
        let mut at_rim = vec![[0.0; 2]; n];
        let mut pull = vec![[0.0; 2]; n];
        let cell_km2 = self.g.cell_area_m2() * 1e-6;
        let reach = reach(&self.g, self.parameters.fold_width);
        let crust = &self.maps.crust;
        let arcs = Arcs {
            g: &self.g,
            crust,
            owner: &self.maps.owner,
            volcanoes: &self.volcanoes,
            share: self.parameters.arcs,
            distance_m: f64::from(self.parameters.arc_distance),
        };
        for c in contacts {
            let cell = c.cell as usize;
            let max_crust = self.parameters.max_crust;
            let (over, under) = (&self.plates[usize::from(c.over)], &self.plates[usize::from(c.under)]);
            let slab = direction([0, 1].map(|i| under.velocity[i] - over.velocity[i]));
            if c.over != c.under {
                *self.brought.at(c.over, c.under) += f64::from(u8::from(c.continental.0));
                *self.brought.at(c.under, c.over) += f64::from(u8::from(c.continental.1));
            }
            match c.kind {
                Kind::Boundary(dx, _) if self.rim(dx) == BoundaryCondition::Open => {
                    self.budget.left += i64::from(c.crust);
                }
                Kind::Boundary(dx, dy) if c.continental.0 => {
                    let inward = (-f64::from(dx), -f64::from(dy));
                    fold(&self.g, crust, cell, c.crust, inward, (0, 2 * reach), max_crust, changes);
                    at_rim[usize::from(c.over)][0] += f64::from(dx);
                    at_rim[usize::from(c.over)][1] += f64::from(dy);
                }
                Kind::Boundary(..) => {
                    let (scraped, sunk) = scrape(c.crust);
                    changes.add(cell, scraped);
                    self.budget.subducted += i64::from(sunk);
                }
                Kind::Collides => {
                    fold(&self.g, crust, cell, c.crust, slab, (-reach, reach), max_crust, changes);
                    *fronts.at(c.over.min(c.under), c.over.max(c.under)) += 1.0;
                    *self.overlap.at(c.over.min(c.under), c.over.max(c.under)) += cell_km2;
                }
                Kind::Sinks => {
                    let (scraped, sunk) = scrape(c.crust);
                    if scraped > 0 && is_continental(crust[cell]) {
                        fold(&self.g, crust, cell, scraped, slab, (0, reach), max_crust, changes);
                    } else {
                        changes.add(cell, scraped);
                    }
                    self.budget.subducted += i64::from(sunk);
                    // Where a continent was scraped off the slab it is the upper plate's own floor that sank.
                    if !c.continental.1 && self.converges(c, slab) {
                        self.budget.arcs += arcs.erupt(cell, sunk, slab, (c.over, over), changes);
                        let heavy = f64::from((c.age / 80.0).min(1.0));
                        let side = f64::from(areas[usize::from(c.under)].max(1)).sqrt();
                        pull[usize::from(c.under)][0] += heavy * slab.0 / side;
                        pull[usize::from(c.under)][1] += heavy * slab.1 / side;
                    }
                }
            }
        }
        self.feel(&fronts, &at_rim, &pull, areas);
    }

    /// True if the lower plate comes towards the upper one, and does not slide along it.
    fn converges(&self, c: &Contact, slab: (f64, f64)) -> bool {
        let (mut x, mut y) = (0.0, 0.0);
        for (dx, dy) in [(-2, -2), (0, -2), (2, -2), (-2, 0), (2, 0), (-2, 2), (0, 2), (2, 2)] {
            let below = self.g.beside(c.cell as usize, dx, dy).is_some_and(|n| self.maps.owner[n] == c.under);
            let way = f64::from(u8::from(below));
            (x, y) = (x + way * dx as f64, y + way * dy as f64);
        }
        slab.0 * x + slab.1 * y < -SLIDES * x.hypot(y)
    }

    fn rim(&self, dx: i8) -> BoundaryCondition {
        if dx != 0 { self.g.rim.0 } else { self.g.rim.1 }
    }

    fn feel(&mut self, fronts: &Pairs, at_rim: &[[f64; 2]], pull: &[[f64; 2]], areas: &[u32]) {
        let friction = f64::from(self.parameters.friction);
        let n = self.plates.len();
        for p in 0..n {
            for q in p + 1..n {
                let cells = fronts.get(p as u8, q as u8);
                if cells > 0.0 {
                    let (left, right) = self.plates.split_at_mut(q);
                    let area = (f64::from(areas[p].max(1)), f64::from(areas[q].max(1)));
                    brake(&mut left[p], &mut right[0], cells, area, friction);
                }
            }
            let plate = &mut self.plates[p];
            let out = at_rim[p];
            if out != [0.0; 2] {
                brake_at_rim(plate, out, out[0].hypot(out[1]), f64::from(areas[p].max(1)), friction);
            }
            for i in 0..2 {
                plate.pull[i] = (plate.pull[i] + 0.1 * pull[p][i]).clamp(-1.5, 1.5);
            }
        }
    }

    /// A border turns over when the lower plate clearly brings more continents to it.
    fn turn_polarity(&mut self) {
        let n = self.plates.len() as u8;
        for (p, q) in (0..n).flat_map(|p| (0..n).map(move |q| (p, q))) {
            let (above, below) = (self.brought.get(p, q), self.brought.get(q, p));
            if self.over.get(p, q) > 0.0 && below > TURN.0 * above + TURN.1 {
                *self.over.at(p, q) = 0.0;
                *self.over.at(q, p) = 1.0;
            }
        }
    }

    /// Straightens borders, lets continents grow together, and gives cut-off parts to others.
    fn tidy(&mut self) {
        let rows = runs::of_rows(&self.maps.owner, self.g.width);
        parts::smooth(&self.g, &rows, &mut self.maps.owner);
        self.join_continents();
        let rows = runs::of_rows(&self.maps.owner, self.g.width);
        self.settle_parts(&rows);
        self.forget_empty();
        self.hold_at_rims();
    }

    fn join_continents(&mut self) {
        let cell_km2 = self.g.cell_area_m2() * 1e-6;
        for _ in 0..MAX_SUTURES {
            let continents = self.continents();
            let Some((taker, giver)) = suture::due(&self.overlap, &continents, cell_km2, &self.parameters) else {
                return;
            };
            let areas = runs::areas(&runs::of_rows(&self.maps.owner, self.g.width), self.plates.len());
            suture::join(&self.g, &mut self.maps.owner, &self.maps.crust, &mut self.plates, &areas, (taker, giver));
            *self.overlap.at(taker.min(giver), taker.max(giver)) = 0.0;
        }
    }

    fn settle_parts(&mut self, rows: &[Vec<Run>]) {
        let cells = self.g.cells() as f64;
        let found = parts::find(&self.g, rows);
        let mut largest = vec![(0u32, usize::MAX); self.plates.len()];
        for (i, part) in found.iter().enumerate() {
            let l = &mut largest[usize::from(part.owner)];
            if part.cells > l.0 {
                *l = (part.cells, i);
            }
        }
        for (i, part) in found.iter().enumerate() {
            let share = f64::from(part.cells) / cells;
            let own = largest[usize::from(part.owner)].1 == i;
            let becomes = if own && share >= SMALLEST_PLATE {
                None
            } else if !own && share >= OWN_PLATE && self.plates.len() < MAX_PLATES {
                Some(self.split(part.owner))
            } else {
                part.neighbour(&self.g, rows, &self.maps.owner)
            };
            if let Some(new) = becomes {
                part.iter(self.g.width, rows).for_each(|c| self.maps.owner[c] = new);
            }
        }
    }

    /// Plates whose continents touch a closed rim slide along it: what left it would have a straight coast.
    fn hold_at_rims(&mut self) {
        let (w, h) = (self.g.width, self.g.height);
        let rows = [0, h - 1].into_iter().flat_map(|y| (0..w).map(move |x| (1, y * w + x)));
        let columns = [0, w - 1].into_iter().flat_map(|x| (0..h).map(move |y| (0, y * w + x)));
        let closed = [self.g.rim.0, self.g.rim.1].map(|e| e == BoundaryCondition::Closed);
        let mut touching = vec![[0u32; 2]; self.plates.len()];
        for (axis, cell) in rows.chain(columns) {
            if closed[axis] && is_continental(self.maps.crust[cell]) {
                touching[usize::from(self.maps.owner[cell])][axis] += 1;
            }
        }
        for (plate, [columns, rows]) in self.plates.iter_mut().zip(touching) {
            // From a corner a plate moves on along the rim that it touches more.
            plate.held = [columns > rows, rows > 0 && rows >= columns];
        }
    }

    /// A new plate that moves as `parent` does.
    fn split(&mut self, parent: u8) -> u8 {
        let new = self.plates.len() as u8;
        let mut plate = self.plates[usize::from(parent)];
        plate.spin = 2.0 * unit(self.seed ^ mix64(self.clock.steps), u64::from(new)) - 1.0;
        self.plates.push(plate);
        [&mut self.overlap, &mut self.brought, &mut self.over].into_iter().for_each(Pairs::push);
        // It overrides whom its parent overrides, and its parent.
        for other in 0..new {
            let over = other == parent || self.over.get(parent, other) > 0.0;
            *self.over.at(new, other) = f64::from(u8::from(over));
            *self.over.at(other, new) = f64::from(u8::from(!over));
        }
        new
    }

    /// Plates without cells are no more.
    fn forget_empty(&mut self) {
        let areas = runs::areas(&runs::of_rows(&self.maps.owner, self.g.width), self.plates.len());
        let keep: Vec<usize> = (0..areas.len()).filter(|&p| areas[p] > 0).collect();
        if keep.len() == areas.len() {
            return;
        }
        let mut number = [0u8; 256];
        for (new, &old) in keep.iter().enumerate() {
            number[old] = new as u8;
        }
        self.maps.owner.iter_mut().for_each(|o| *o = number[usize::from(*o)]);
        self.plates = keep.iter().map(|&p| self.plates[p]).collect();
        [&mut self.overlap, &mut self.brought, &mut self.over].into_iter().for_each(|t| t.keep(&keep));
    }

    fn erode(&mut self) {
        let p = &self.parameters;
        let years = f64::from(p.years_per_step) * EROSION_EVERY as f64;
        if self.clock.steps.is_multiple_of(DENUDATION_EVERY) {
            let years = f64::from(p.years_per_step) * DENUDATION_EVERY as f64;
            erosion::denude(&self.g, p, years, self.plates.len(), &self.maps.owner, &self.height, &mut self.maps.crust);
        }
        let passes = erosion::passes(&self.g, p, years);
        for pass in 0..passes {
            if pass > 0 {
                let level = self.clock.level;
                heights(self.g.width, &self.maps.crust, &mut self.maps.age, 0.0, level, &mut self.height);
            }
            let years = years / f64::from(passes);
            erosion::pass(&self.g, p, years, &self.height, &self.maps.crust, &mut self.spare.crust);
            std::mem::swap(&mut self.maps.crust, &mut self.spare.crust);
        }
    }

    fn end_cycle(&mut self) {
        let p = &self.parameters;
        let old = p.cycle > 0.0 && self.clock.since_myr >= f64::from(p.cycle);
        let slow = p.speed > 0.0 && self.mean_speed() < f64::from(p.stall * p.speed);
        // A cycle that has just begun is never over.
        let over = self.clock.since_myr > SHORTEST_MYR && (slow || self.is_one_plate());
        if old || over {
            if p.cycles > 0 && self.clock.cycle >= u64::from(p.cycles) {
                self.clock.at_rest = true;
            } else {
                self.restart();
            }
        }
    }

    /// True if one plate has taken most of the world. Two plates may be so from the start.
    fn is_one_plate(&self) -> bool {
        if !self.clock.steps.is_multiple_of(TIDY_EVERY) || self.plates.len() == 2 {
            return self.plates.len() < 2;
        }
        let areas = runs::areas(&runs::of_rows(&self.maps.owner, self.g.width), self.plates.len());
        areas.iter().any(|&a| f64::from(a) > LARGEST_PLATE * self.g.cells() as f64)
    }

    /// Begins a new cycle: new plates from the crust that is there.
    pub fn restart(&mut self) {
        self.clock.cycle += 1;
        self.clock.since_myr = 0.0;
        restart::divide(self);
        self.hold_at_rims();
    }

    /// Takes a height that others have changed: the crust of the plate that owns the cell gets what they added, and what they took is
    /// taken from it, with the root that goes with it, so that the height stays as it is. Less than 2 mm is nothing.
    ///
    /// # Errors
    /// If there is not one finite value for each cell.
    pub fn set_height(&mut self, height: &[f32]) -> Result<()> {
        if height.len() != self.height.len() || height.iter().any(|h| !h.is_finite()) {
            let found = height.iter().filter(|h| h.is_finite()).count();
            return Err(Error::Shape { what: "finite heights for plates".into(), expected: self.g.cells(), found });
        }
        let width = self.g.width;
        self.shape(&|row, new| new.copy_from_slice(&height[row * width..][..width]));
        Ok(())
    }

    /// As [`Plates::set_height`], where `change` gets each row and its heights to change. Cells where they are no numbers then get no
    /// other crust, but that height, for whoever looks for such.
    pub(crate) fn shape(&mut self, change: &(impl Fn(usize, &mut [f32]) + Sync)) {
        let (level, width) = (self.clock.level as f32, self.g.width);
        let rows = self.height.par_chunks_mut(width).zip(self.maps.crust.par_chunks_mut(width));
        let rows = rows.zip(self.maps.age.par_chunks(width)).enumerate().with_min_len(rows_at_once(width));
        let sum = |a: [i64; 3], b: [i64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let [deposited, removed, gained] = rows
            .map_with(vec![0.0; width], |changed, (y, ((old, crust), age))| {
                changed.copy_from_slice(old);
                change(y, changed);
                let mut sums = [0; 3];
                // Without a branch, so that many cells go at a time.
                for (((old, &new), crust), age) in old.iter_mut().zip(&*changed).zip(crust).zip(age) {
                    // Less than a height far above the sea can hold, so it came by rounding.
                    let same = (new - *old).abs() < 2e-3;
                    let thick = nearest_units(crust_m(new, *age, level).min(HIGHEST_M));
                    let grown = if same | !new.is_finite() { 0 } else { thick - *crust };
                    *crust += grown;
                    let land = i32::from(new > 0.0) - i32::from(*old > 0.0);
                    *old = if same { *old } else { new };
                    let here = [grown.max(0), (-grown).max(0), if same { 0 } else { land }];
                    sums = sum(sums, here.map(i64::from));
                }
                sums
            })
            .reduce(|| [0; 3], sum);
        self.budget.deposited += deposited;
        self.budget.removed += removed;
        // The sea does not answer at once.
        self.clock.aim += gained as f64 / self.g.cells() as f64;
    }

    /// Changes the parameters from the next step on.
    ///
    /// # Errors
    /// As [`Plates::new`]; the old ones then stay.
    pub fn set_parameters(&mut self, grid: &Grid, parameters: Tectonics) -> Result<()> {
        check(&parameters, grid)?;
        self.parameters = parameters;
        Ok(())
    }

    /// The parameters.
    pub fn parameters(&self) -> &Tectonics {
        &self.parameters
    }

    /// Height above the sea, m, row by row from the north.
    pub fn height(&self) -> &[f32] {
        &self.height
    }

    /// The plate that owns each cell.
    pub fn owner(&self) -> &[u8] {
        &self.maps.owner
    }

    /// Age of the crust, Myr.
    pub fn age_myr(&self) -> &[f32] {
        &self.maps.age
    }

    /// Thickness of the crust, m.
    pub fn crust_m(&self) -> impl Iterator<Item = f32> + '_ {
        self.maps.crust.iter().map(|&c| metres(c))
    }

    /// Thickness of all crust, units of 1/128 m times cells: always the same as [`Budget::net`].
    pub fn crust_units(&self) -> i64 {
        self.maps.crust.iter().map(|&c| i64::from(c)).sum()
    }

    /// Where crust came from and went.
    pub fn budget(&self) -> &Budget {
        &self.budget
    }

    /// Cycles begun, from 1, and steps done in all.
    pub fn cycle_and_steps(&self) -> (u64, u64) {
        (self.clock.cycle, self.clock.steps)
    }

    /// True once the last cycle is over.
    pub fn is_at_rest(&self) -> bool {
        self.clock.at_rest
    }

    /// Speed of all plates, weighed by nothing, m/yr.
    pub fn mean_speed(&self) -> f64 {
        let sum: f64 = self.plates.iter().map(|p| p.velocity[0].hypot(p.velocity[1])).sum();
        sum / self.plates.len().max(1) as f64
    }

    /// Continental cells of each plate.
    pub(crate) fn continents(&self) -> Vec<u32> {
        let mut cells = vec![0; self.plates.len()];
        for (&o, &c) in self.maps.owner.iter().zip(&self.maps.crust) {
            cells[usize::from(o)] += u32::from(is_continental(c));
        }
        cells
    }

    /// All plates.
    pub fn list(&self) -> Vec<PlateInfo> {
        let continents = self.continents();
        let centres = restart::centres(&self.g, self.plates.len(), |c| Some(self.maps.owner[c]));
        let mut crust = vec![0i64; self.plates.len()];
        let mut cells = vec![0u32; self.plates.len()];
        for (&o, &c) in self.maps.owner.iter().zip(&self.maps.crust) {
            crust[usize::from(o)] += i64::from(c);
            cells[usize::from(o)] += 1;
        }
        let area = self.g.cell_area_m2();
        let info = |(i, p): (usize, &Plate)| PlateInfo {
            index: i as u8,
            area_m2: f64::from(cells[i]) * area,
            continental: f64::from(continents[i]) / f64::from(cells[i].max(1)),
            crust_m3: crust[i] as f64 / f64::from(crate::crust::UNITS_PER_M) * area,
            speed_m_per_year: p.velocity[0].hypot(p.velocity[1]),
            azimuth_deg: (p.velocity[0].atan2(-p.velocity[1]) * 180.0 / PI).rem_euclid(360.0),
            centre: centres[i].0,
        };
        self.plates.iter().enumerate().map(info).collect()
    }
}

/// Finds parameters out of range, and steps in which a plate would go too far.
pub(crate) fn check(p: &Tectonics, grid: &Grid) -> Result<()> {
    check_ranges("plates", p)?;
    let cell = grid.cell_x_m.min(grid.cell_y_m);
    let cells = p.top_speed() * f64::from(p.years_per_step) / cell;
    if cells > motion::MAX_SHIFTS {
        let most = motion::MAX_SHIFTS * cell / p.top_speed();
        let reason = format!(
            "in {} years a plate could cross {cells:.0} cells of {cell} m, {} at most; make it {most:.0} at most, or the cells larger",
            p.years_per_step,
            motion::MAX_SHIFTS
        );
        return Err(Error::BadParameter { owner: "plates".into(), field: "years_per_step".into(), reason });
    }
    let passes = erosion::passes(&Geometry::new(grid), p, f64::from(p.years_per_step) * EROSION_EVERY as f64);
    if passes > 64 {
        let reason =
            format!("so fast on cells of {cell} m it would need {passes} passes, 64 at most; lower it, and coast");
        return Err(Error::BadParameter { owner: "plates".into(), field: "erosion".into(), reason });
    }
    Ok(())
}

/// The direction of a vector; nowhere if it has no length.
fn direction(v: [f64; 2]) -> (f64, f64) {
    let length = v[0].hypot(v[1]);
    if length > 0.0 { (v[0] / length, v[1] / length) } else { (0.0, 0.0) }
}
