//! Oceanic crust sinks: volcanoes rise behind the trench, and the slab pulls its plate.
//!
//! What is thicker than oceanic crust (sediment, worn islands) is scraped off and stays at the edge of the upper plate. Of what sinks, a
//! share comes up `arc_distance` behind the trench, in the direction in which the slab moves. Volcanoes are patches in the frame of the
//! upper plate, so they stand still on it and make chains of islands, not walls; the thicker the crust the less is added.

use crate::changes::Changes;
use crate::crust::{OCEANIC_M, is_continental, metres, units};
use crate::geometry::Geometry;
use crate::growth::unit;
use crate::plate::Plate;

/// Crust of an island arc or a volcanic range that grows no more, m.
const FULL_ARC_M: f32 = 38_000.0;
const FULL_RANGE_M: f32 = 58_000.0;
/// Distance of volcanoes, m.
const SPACING_M: f64 = 400_000.0;

/// What remains of crust that goes under: scraped off, and sunk, units.
pub(crate) fn scrape(crust: i32) -> (i32, i32) {
    let sunk = crust.min(units(OCEANIC_M));
    (crust - sunk, sunk)
}

/// Volcanoes of a whole plate, in its own frame: one in each square of a lattice that fits the grid, somewhere in it, of any strength.
/// All plates have the same; where their trenches lie decides which ones are active.
pub(crate) struct Volcanoes {
    squares: [usize; 2],
    /// Place in the square, and strength.
    each: Vec<[f32; 3]>,
}

impl Volcanoes {
    pub(crate) fn new(g: &Geometry, seed: u64) -> Self {
        // A square is no smaller than a cell.
        let along = |n: usize, cell_m: f64| ((n as f64 * cell_m / SPACING_M).round() as usize).clamp(1, n);
        let squares = [along(g.width, g.cell_m.0), along(g.height, g.cell_m.1)];
        let number = |square: usize, k: u64| unit(seed ^ k, square as u64) as f32;
        let one = |s: usize| [number(s, 1), number(s, 2), number(s, 3).powi(2)];
        Self { squares, each: (0..squares[0] * squares[1]).map(one).collect() }
    }

    /// How active the ground is at `(x, y)` in the frame of a plate, as shares of the grid: about 1 on average, next to nothing between
    /// volcanoes.
    fn activity(&self, place: [f64; 2]) -> f32 {
        let at = [0, 1].map(|i| (place[i] * self.squares[i] as f64) as f32);
        let square = at.map(|a| a.floor());
        let mut activity = 0.0;
        for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))) {
            let wrap = |k: usize, d: isize| (square[k] as isize + d).rem_euclid(self.squares[k] as isize) as usize;
            let [px, py, strength] = self.each[wrap(1, j) * self.squares[0] + wrap(0, i)];
            let (x, y) = (square[0] + i as f32 + px - at[0], square[1] + j as f32 + py - at[1]);
            activity += strength * (1.0 - 4.0 * (x * x + y * y)).max(0.0);
        }
        7.0 * activity
    }
}

/// What volcanoes grow on.
pub(crate) struct Arcs<'a> {
    pub(crate) g: &'a Geometry,
    pub(crate) crust: &'a [i32],
    pub(crate) owner: &'a [u8],
    pub(crate) volcanoes: &'a Volcanoes,
    pub(crate) share: f32,
    pub(crate) distance_m: f64,
}

impl Arcs<'_> {
    /// Adds what comes up of `sunk` units that went under at `cell`, and returns how much that is.
    pub(crate) fn erupt(
        &self,
        cell: usize,
        sunk: i32,
        slab: (f64, f64),
        over: (u8, &Plate),
        changes: &mut Changes,
    ) -> i64 {
        let away = |d: f64, size: f64| (d * self.distance_m / size).round() as isize;
        let (x, y) = self.g.place(cell);
        let (x, y) = (x + away(slab.0, self.g.cell_m.0), y + away(slab.1, self.g.cell_m.1));
        let Some(centre) = self.g.cell(x, y) else { return 0 };
        let own = |place: isize, moved: f64, n: usize| (place as f64 + 0.5 - moved).rem_euclid(n as f64) / n as f64;
        let frame = [own(x, over.1.moved[0], self.g.width), own(y, over.1.moved[1], self.g.height)];
        let amount = sunk as f32 * self.share * self.volcanoes.activity(frame);
        if amount < 1.0 {
            return 0;
        }
        // Islands stay low; ranges rise where the continent goes on beyond them.
        let beyond = self.g.cell(x + away(slab.0, self.g.cell_m.0), y + away(slab.1, self.g.cell_m.1));
        let inland = beyond.is_some_and(|b| is_continental(self.crust[b]));
        let full = if inland { FULL_RANGE_M } else { FULL_ARC_M };
        let mut erupted = 0;
        // A volcano is wider than a cell: half on it, the rest on its sides.
        let spread = std::iter::once((centre, 0.5)).chain(self.g.sides(centre).map(|c| (c, 0.125)));
        for (to, part) in spread.filter(|&(c, _)| self.owner[c] == over.0) {
            let thick = metres(self.crust[to]);
            let units = (amount * part * (1.0 - thick / full).max(0.0)) as i32;
            changes.add(to, units);
            erupted += i64::from(units);
        }
        erupted
    }
}
