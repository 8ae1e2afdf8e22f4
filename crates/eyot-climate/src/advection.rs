//! What wind carries: flow through faces from the cell that the wind comes from.

use crate::units::hours_per_step;
use eyot_core::Grid;
use eyot_core::given::Given;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Slot};

/// Share of a cell that a wind of 1 m/s through an eastern and through a southern face carries away in a step, s/m.
pub(crate) fn shares(grid: &Grid) -> (f32, f32) {
    let seconds = 3600.0 * hours_per_step(grid);
    ((seconds / grid.cell_x_m) as f32, (seconds / grid.cell_y_m) as f32)
}

/// Share of a difference that mixes between two neighbours in a step, 1, from a diffusivity in m2/s: never more than
/// leaves room for wind.
pub(crate) fn mixing(grid: &Grid, diffusivity: Given) -> Given {
    let cell = grid.cell_x_m.min(grid.cell_y_m);
    (diffusivity.wide() * 3600.0 * hours_per_step(grid) / (cell * cell)).min(0.05).narrow()
}

/// The slots of a quantity and of the wind, with [`shares`].
#[derive(Clone, Copy)]
pub(crate) struct Carrier<R> {
    /// What is carried.
    pub(crate) what: Slot,
    /// Wind through eastern faces.
    pub(crate) wind_x: Slot,
    /// Wind through southern faces.
    pub(crate) wind_y: Slot,
    /// Share for eastern faces, s/m.
    pub(crate) share_x: R,
    /// Share for southern faces, s/m.
    pub(crate) share_y: R,
    /// Share of a difference that mixes between two neighbours, 1.
    pub(crate) mixing: R,
}

impl<R: Real> Carrier<R> {
    /// Amount that crosses the eastern face of the cell `at` columns east, positive to the east.
    #[inline(always)]
    pub(crate) fn east(&self, c: &impl Cell<R>, at: isize) -> R {
        let (here, next) = (c.at(self.what, at, 0), c.at(self.what, at + 1, 0));
        crossing(self.share_x * c.at(self.wind_x, at, 0), self.mixing, here, next)
    }

    /// Amount that crosses the southern face of the cell `at` rows south, positive to the south.
    #[inline(always)]
    pub(crate) fn south(&self, c: &impl Cell<R>, at: isize) -> R {
        let (here, next) = (c.at(self.what, 0, at), c.at(self.what, 0, at + 1));
        crossing(self.share_y * c.at(self.wind_y, 0, at), self.mixing, here, next)
    }

    /// What the cell gains if the quantity is matter: inflows less outflows.
    #[inline(always)]
    pub(crate) fn gain(&self, c: &impl Cell<R>) -> R {
        (self.east(c, -1) - self.east(c, 0)) + (self.south(c, -1) - self.south(c, 0))
    }

    /// By how much the quantity changes if it is a property of the air: what arrives replaces what was there.
    #[inline(always)]
    pub(crate) fn change(&self, c: &impl Cell<R>) -> R {
        let west = self.arriving(c, self.share_x * c.at(self.wind_x, -1, 0), -1, 0);
        let east = self.arriving(c, -(self.share_x * c.here(self.wind_x)), 1, 0);
        let north = self.arriving(c, self.share_y * c.at(self.wind_y, 0, -1), 0, -1);
        let south = self.arriving(c, -(self.share_y * c.here(self.wind_y)), 0, 1);
        (west + east) + (north + south)
    }

    /// What the air of a neighbour changes here, of which the share `towards` blows over.
    #[inline(always)]
    fn arriving(&self, c: &impl Cell<R>, towards: R, dx: isize, dy: isize) -> R {
        (towards.positive() + self.mixing) * (c.at(self.what, dx, dy) - c.here(self.what))
    }
}

/// The upwind cell decides.
#[inline(always)]
fn crossing<R: Real>(share: R, mixing: R, here: R, next: R) -> R {
    share.positive() * here + share.min(R::of(0.0)) * next + mixing * (here - next)
}

/// Passes of mixing by storms in a step, and the share of a difference that mixes between two neighbours in each where
/// there are most of them, from a diffusivity in m2/s. Beyond [`MAX_PASSES`] there is less of it.
pub(crate) fn storms(grid: &Grid, diffusivity: f32) -> (usize, f32) {
    let cell = grid.cell_x_m.min(grid.cell_y_m);
    let wanted = f64::from(diffusivity) * 3600.0 * hours_per_step(grid) / (cell * cell);
    let passes = (wanted / MAX_SHARE).ceil().min(MAX_PASSES);
    (passes as usize, (wanted / passes.max(1.0)).min(MAX_SHARE) as f32)
}

/// Most passes of mixing by storms in a step.
const MAX_PASSES: f64 = 4.0;
/// Most of a difference that mixes between two neighbours in a pass: four of them leave a fifth.
const MAX_SHARE: f64 = 0.2;
