//! Rockfall: what is steeper than its material can stand comes down, loose ground at its own angle, bedrock at that of its bed.
//!
//! # Equations
//! `h` height, `r` surface of the bedrock, `s = h - r` loose ground, `T` tangents of the steepest slopes times the distance, `D` drop from a cell
//! to a lower neighbour.
//! 1. A cell gives a neighbour `e = max(min(k (D - T_loose)+, s m), k (D - T_rock)+)`, with `k = rate / 12` for neighbours that share an
//!    edge and half of it for diagonal ones, and `m` 1/12 and 1/24: loose ground goes from its angle on, as far as there is some,
//!    bedrock from that of its bed on.
//! 2. `h' = h + sum of what comes - sum of what goes`. What arrives is loose: the bedrock's surface stays as it is.
//! 3. Where a bed lies on a weak one, which is as erodible as `weak` says or more while it is not itself, the face between a cell and its
//!    lower neighbour shows the bed down to its bottom, `t`, and `u = D - t` of the weak one. If the bed presses more than that,
//!    `t density >= u weak_density`, the weak one trickles out from under it, `k (u - T_loose)+`; if it presses less, both slide,
//!    `k (D - T_loose)+`. `e` is no less than that. Where what lies below is firm, (1) alone holds, and nothing moves.
//!
//! # Source
//! Musgrave, Kolb and Mace 1989; materials in layers after Benes and Forsbach 2001; the three cases of hard rock on loose ground, decided
//! by pressure, after the German thesis of which the process `strata` has its materials.
//!
//! # Differences
//! - Pairs of cells exchange what exceeds the angle, as in the process `thermal`, and both compute the same amount.
//! - The angle of a pair is that of the higher cell's material, or in (3) that of loose ground.
//! - Beds keep their place: what trickled out from under a bed is taken from its top, as if as much of it had broken off and fallen.
//! - Of the beds on a face two are looked at. A weak bed counts as reaching down to the lower cell's ground.
//!
//! # Layers
//! Reads `bedrock` (m) and `rock_slope`, `erodibility` and `erodibility_below` (1) and `bed_left` (m), which the process `strata` makes;
//! reads and writes `height` (m).
//!
//! # Limits
//! Stable for every rate within 0..=1: the shares of the 8 neighbours sum to `rate / 2`.
//!
//! # Conserves
//! Ground, to rounding (`tests/it/rockfall.rs`).

use eyot_core::layer::known::HEIGHT;
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::rule_params;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::strata::{BED_LEFT, BEDROCK, ERODIBILITY, ERODIBILITY_BELOW, ROCK_SLOPE};

/// Walls come down at the angle of their rock, scree lies at its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Rockfall {
    /// Steepest slope of loose ground: about 33 degrees for dry sand, 35 to 40 for scree.
    #[schemars(range(min = 0.0, max = 89.0), extend("unit" = "degree", "between_cells" = true))]
    pub talus: f32,
    /// How much of the excess moves in a step. 1 is the stable limit.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1", "between_cells" = true))]
    pub rate: f32,
    /// Erodibility from which on a bed is so weak that it comes out from under a stronger one: sand and regolith, as they usually are.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1", "between_cells" = true))]
    pub weak: f32,
    /// Mass of a cubic metre of what lies on weak beds. A thin light bed slides with them, a thick heavy one holds.
    #[schemars(range(min = 100.0, max = 10000.0), extend("unit" = "kg/m3", "between_cells" = true))]
    pub density: f32,
    /// Mass of a cubic metre of weak beds.
    #[schemars(range(min = 100.0, max = 10000.0), extend("unit" = "kg/m3", "between_cells" = true))]
    pub weak_density: f32,
}

impl Default for Rockfall {
    fn default() -> Self {
        Self { talus: 35.0, rate: 0.5, weak: 0.9, density: 2500.0, weak_density: 1950.0 }
    }
}

impl Process for Rockfall {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.changed(0.0),
            BEDROCK.read(-12000.0),
            ROCK_SLOPE.read(1.0),
            ERODIBILITY.read(1.0),
            BED_LEFT.read(0.0),
            ERODIBILITY_BELOW.read(0.0),
        ]
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (dx, dy) = (moment.grid.cell_x_m, moment.grid.cell_y_m);
        let angle = f64::from(self.talus);
        plan.push::<Fall>(FallParams {
            loose: (sin_degrees(angle) / cos_degrees(angle)) as f32,
            dx: dx as f32,
            dy: dy as f32,
            dd: (dx * dx + dy * dy).sqrt() as f32,
            rate: self.rate / 12.0,
            share: 1.0 / 12.0,
            weak: self.weak,
            pressure: self.density / self.weak_density,
        });
    }
}

rule_params! {
    /// Parameters of [`Fall`].
    pub struct FallParams {
        /// Tangent of the steepest slope of loose ground, 1.
        loose,
        /// Distance of eastern and western neighbours, m.
        dx,
        /// Of northern and southern ones, m.
        dy,
        /// Of diagonal ones, m.
        dd,
        /// Share of the excess that moves between neighbours that share an edge, 1.
        rate,
        /// Share of the loose ground that can go to one of them, 1.
        share,
        /// Erodibility of the strongest of weak beds, 1.
        weak,
        /// Density of what lies on weak beds, over theirs, 1.
        pressure,
    }
}

/// Equations (1) to (3).
pub struct Fall;

impl Rule for Fall {
    const NAME: &'static str = "rockfall_fall";
    const READS: &'static [Read] = &[
        read("height", 1),
        read("bedrock", 1),
        read("rock_slope", 1),
        read("erodibility", 1),
        read("bed_left", 1),
        read("erodibility_below", 1),
    ];
    const WRITES: &'static [&'static str] = &["height"];
    type Params = FallParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &FallParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let one = R::of(1.0);
        // Opposite neighbours are added first, so that mirrored worlds stay mirrored to the bit.
        let x = comes(p, c, 1, 0, p.dx, one) + comes(p, c, -1, 0, p.dx, one);
        let y = comes(p, c, 0, 1, p.dy, one) + comes(p, c, 0, -1, p.dy, one);
        let half = R::of(0.5);
        let d = (comes(p, c, 1, 1, p.dd, half) + comes(p, c, -1, -1, p.dd, half))
            + (comes(p, c, -1, 1, p.dd, half) + comes(p, c, 1, -1, p.dd, half));
        ([(c.here(0) + ((x + y) + d)).named("(2) fallen")], [])
    }
}

/// Equations (1) and (3): what comes from a neighbour, below 0 if it goes there. Both cells compute the same.
#[inline(always)]
fn comes<R: Real>(p: &FallParams<R>, c: &impl Cell<R>, dx: isize, dy: isize, distance: R, part: R) -> R {
    let zero = R::of(0.0);
    let (here, there) = (c.here(0), c.at(0, dx, dy));
    let drop = (there - here).abs();
    let falls_here = here.lt(there);
    let rock = falls_here.pick(c.at(1, dx, dy), c.here(1));
    let slope = falls_here.pick(c.at(2, dx, dy), c.here(2));
    let high = there.max(here);
    let loose = (high - rock).positive();
    let slid = (p.rate * part * (drop - p.loose * distance).positive()).min(p.share * part * loose);
    let fell = p.rate * part * (drop - slope * distance).positive();
    // (3) A strong bed on a weak one.
    let of_higher = |slot: usize| falls_here.pick(c.at(slot, dx, dy), c.here(slot));
    let (strength, cap, below) = (of_higher(3), of_higher(4), of_higher(5));
    let shown = drop - cap;
    let presses = shown.lt(cap * p.pressure);
    let face = presses.pick(shown, drop);
    let trickled = p.rate * part * (face - p.loose * distance).positive();
    let undermined = below.lt(p.weak).pick(zero, strength.lt(p.weak).pick(trickled, zero));
    let came_out = shown.lt(zero).pick(zero, undermined);
    let moved = slid.max(fell).max(came_out);
    falls_here.pick(moved, zero - moved)
}
