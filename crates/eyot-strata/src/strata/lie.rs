//! Where the beds lie at the start, and how they rise: equations (5) and (6) of the parent module.

use super::beds::tangent;
use super::{MOST_BENDS, Strata};
use eyot_core::Grid;
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, ParamSet, Read, Rule, Tally, TallyUnit, read};
use eyot_core::rule_params;

impl Strata {
    pub(super) fn lie(&self, grid: &Grid) -> LieParams<f32> {
        let cell = [grid.cell_x_m, grid.cell_y_m];
        // Columns to the east and rows to the south, in metres.
        let along = |degrees: f32| {
            let d = f64::from(degrees);
            [sin_degrees(d) * cell[0], -cos_degrees(d) * cell[1]]
        };
        let sink = along(self.dip_direction).map(|c| (tangent(self.dip) * c) as f32);
        let mut p = LieParams {
            middle: [0.5 * (grid.width as f32 - 1.0), 0.5 * (grid.height as f32 - 1.0)],
            top: self.top,
            sink,
            folds: [[0.0; 4]; MOST_BENDS],
            faults: [[0.0; 4]; MOST_BENDS],
        };
        for (to, f) in p.folds.iter_mut().zip(&self.folds) {
            let turns = std::f64::consts::TAU / f64::from(f.wavelength);
            let [x, y] = along(f.direction).map(|c| (turns * c) as f32);
            *to = [x, y, (turns * f64::from(f.crest)) as f32, f.amplitude];
        }
        for (to, f) in p.faults.iter_mut().zip(&self.faults) {
            // To the right of its direction.
            let [x, y] = along(f.strike + 90.0).map(|c| c as f32);
            *to = [x, y, f.distance, f.throw];
        }
        p
    }
}

/// Parameters of [`Lie`].
#[derive(Clone, Copy, Debug)]
pub struct LieParams<T> {
    /// The middle of the grid, column and row.
    pub middle: [T; 2],
    /// Height of the top there, m.
    pub top: T,
    /// What beds sink by to the next column and row, m.
    pub sink: [T; 2],
    /// Folds: radians to the next column and row, radians at the middle, amplitude (m).
    pub folds: [[T; 4]; MOST_BENDS],
    /// Faults: metres away from it to the next column and row, metres at the middle, throw (m).
    pub faults: [[T; 4]; MOST_BENDS],
}

const LIE: &[&str] = &[
    "middle_x",
    "middle_y",
    "top",
    "sink_x",
    "sink_y",
    "fold_x_0",
    "fold_y_0",
    "fold_phase_0",
    "fold_amplitude_0",
    "fold_x_1",
    "fold_y_1",
    "fold_phase_1",
    "fold_amplitude_1",
    "fold_x_2",
    "fold_y_2",
    "fold_phase_2",
    "fold_amplitude_2",
    "fold_x_3",
    "fold_y_3",
    "fold_phase_3",
    "fold_amplitude_3",
    "fault_x_0",
    "fault_y_0",
    "fault_distance_0",
    "fault_throw_0",
    "fault_x_1",
    "fault_y_1",
    "fault_distance_1",
    "fault_throw_1",
    "fault_x_2",
    "fault_y_2",
    "fault_distance_2",
    "fault_throw_2",
    "fault_x_3",
    "fault_y_3",
    "fault_distance_3",
    "fault_throw_3",
];

impl ParamSet for LieParams<()> {
    type Of<T: Copy + 'static> = LieParams<T>;
    const NAMES: &'static [&'static str] = LIE;

    fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> LieParams<U> {
        let mut names = LIE.iter();
        let mut next = || f(names.next().copied().unwrap_or_default());
        LieParams {
            middle: std::array::from_fn(|_| next()),
            top: next(),
            sink: std::array::from_fn(|_| next()),
            folds: std::array::from_fn(|_| std::array::from_fn(|_| next())),
            faults: std::array::from_fn(|_| std::array::from_fn(|_| next())),
        }
    }

    #[inline(always)]
    fn map<T: Copy + 'static, U: Copy + 'static>(
        p: &LieParams<T>,
        mut f: impl FnMut(&'static str, T) -> U,
    ) -> LieParams<U> {
        let mut names = LIE.iter();
        let mut next = |v: T| f(names.next().copied().unwrap_or_default(), v);
        LieParams {
            middle: p.middle.map(&mut next),
            top: next(p.top),
            sink: p.sink.map(&mut next),
            folds: p.folds.map(|fold| fold.map(&mut next)),
            faults: p.faults.map(|fault| fault.map(&mut next)),
        }
    }
}

/// Equation (5).
pub struct Lie;

impl Rule for Lie {
    const NAME: &'static str = "strata_lie";
    const READS: &'static [Read] = &[read("bed_shift", 0)];
    const WRITES: &'static [&'static str] = &["bed_datum"];
    type Params = LieParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &LieParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let (x, y) = (c.x() - p.middle[0], c.y() - p.middle[1]);
        let mut datum = p.top + c.here(0) - (p.sink[0] * x + p.sink[1] * y);
        let mut i = 0;
        while i < MOST_BENDS {
            let [fold, fault] = [p.folds[i], p.faults[i]];
            datum = datum + fold[3] * (fold[0] * x + fold[1] * y - fold[2]).cos();
            let right = (fault[0] * x + fault[1] * y - fault[2]).gt(R::of(0.0));
            datum = datum + right.pick(fault[3], R::of(0.0));
            i += 1;
        }
        ([datum], [])
    }
}

rule_params! {
    /// Parameters of [`Lift`].
    pub struct LiftParams {
        /// What land and beds rise by in a step, m.
        risen,
    }
}

/// Equation (6) of the parent module.
pub struct Lift;

impl Rule for Lift {
    const NAME: &'static str = "strata_lift";
    const READS: &'static [Read] = &[read("height", 0), read("bedrock", 0), read("bed_datum", 0)];
    const WRITES: &'static [&'static str] = &["height", "bedrock", "bed_datum"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "ground.uplifted", unit: TallyUnit::Thickness, sign: 1, meaning: "Ground that rose" }];
    type Params = LiftParams<()>;
    type Out<R: Real> = [R; 3];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &LiftParams<R>, c: &impl Cell<R>) -> ([R; 3], [R; 1]) {
        // All by what the height really rose by, so that nothing loose comes or goes by rounding; no compiler may see that it is
        // `p.risen` but for that.
        let height = (c.here(0) + p.risen).no_contract();
        let risen = height - c.here(0);
        ([height, c.here(1) + risen, c.here(2) + risen], [risen])
    }
}

rule_params! {
    /// Parameters of [`Bury`].
    pub struct BuryParams {
        /// Thickness of the loose ground, m.
        regolith,
    }
}

/// The bedrock at the start: below the loose ground.
pub struct Bury;

impl Rule for Bury {
    const NAME: &'static str = "strata_bury";
    const READS: &'static [Read] = &[read("height", 0)];
    const WRITES: &'static [&'static str] = &["bedrock"];
    type Params = BuryParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &BuryParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([c.here(0) - p.regolith], [])
    }
}
