//! Stream power: rivers cut into rising ground, and hillslopes creep. Ranges, connected valleys, graded rivers.
//!
//! # Equations
//! `z` height, `A` drained area, `S` slope along the way of the water, all in metres; `t` in years.
//! 1. `dz/dt = U - K A^m S^n + D laplacian(z)`.
//! 2. In steady state and without creep `S = (U / K)^(1/n) A^(-m/n)`: Flint's law with concavity `m / n` and steepness
//!    `(U / K)^(1/n)`.
//! 3. With deposition, `+ G Q / A` on the right of (1): `Q` is what is carried away upstream per year (m3), the cell included.
//!    The steepness of steady rivers becomes `(U (1 + G) / K)^(1/n)`.
//! 4. With a critical slope `S_c`, creep is `D div(grad z / (1 - (|grad z| / S_c)^2))`: gentle slopes creep as in (1), none gets
//!    much steeper than `S_c` (`critical.rs`).
//!
//! A step of `T` years lifts the ground by `U T`, lets the water cut it, and lets it creep. Cutting is implicit in the
//! downstream height (`law.rs`, `incise.rs`), from the outlets upstream (`stack.rs`), so that a step may be as long as one
//! likes, and nothing is ever cut below what it drains to.
//!
//! # Source
//! Howard 1994 (detachment-limited incision); the implicit step after Braun and Willett 2013; deposition of Yuan, Braun,
//! Guerit, Rouby and Cordonnier 2019; the critical slope of Roering, Kirchner and Dietrich 1999; routing by steepest descent
//! over filled depressions (`eyot_drainage`).
//!
//! # Differences
//! - Water takes the steepest of eight ways, which small valleys then follow: of the steps of channels that 8 to 29 cells drain
//!   through, 0.21 are diagonal where 0.41 would be if all directions were alike, 0.28 at 30 to 299 cells and 0.47 at 300 to 3000
//!   (192 x 192 cells, `tests/it/directions.rs`). Hillslopes of less than 8 cells have 0.64, because the nearest of eight directions
//!   is diagonal on half of all slopes and small valleys are fed from both sides. `directions = "rho8"` (Fairfield and Leymarie
//!   1991) brings the first to 0.31 and leaves the others nearly as they are, but valleys with `n` below 1 or with deposition then
//!   never come to rest. Large valleys run in all directions with both.
//! - Any `n > 0`, below 1 too, is solved to the last digit and cannot fail (`law.rs`).
//! - Lakes are base levels: what flows into one is cut to its surface, its bed is not cut (deposition raises it), and its sill
//!   is, so that it empties.
//!
//! # Base level
//! Border cells of open rims hold their height. The sea is a base level for the land around it; its floor rises with the
//! uplift. Where there is neither, the lowest cell holds its height.
//!
//! # Layers
//! Reads and writes `height` and `height_rest` (m), which hold it in double precision together. Reads `uplift` and
//! `erodibility` (1) if the recipe makes them: factors on `U` and `K`, cell by cell; and `bed_left` (m) with `erodibility_below` (1),
//! which `strata` writes: a step that cuts through the bed at the surface cuts the next one at its own rate, in the time that is left.
//!
//! # Limits
//! Stable for steps of any length. The order of uplift, cutting and creep within a step makes an error that falls with its
//! length. Deposition and a critical slope are solved in turns, so that steps take several times as long. Of the beds that a step cuts
//! through it knows two.
//!
//! # Conserves
//! What rises is in `ground.uplifted`, what rivers carry away in `ground.incised`, what creeps into cells that hold their
//! height in `ground.crept`, what rivers lay down in `ground.deposited`; the ledger closes to rounding
//! (`tests/it/streampower.rs`).

mod creep;
mod critical;
mod heights;
mod incise;
mod law;
mod stack;

pub use heights::HEIGHT_REST;

use eyot_core::layer::known::{BED_LEFT, ERODIBILITY_BELOW, HEIGHT};
use eyot_core::process::{Action, ActionInstance, LayerUse, Locality, Moment, Process, SECONDS_PER_YEAR, check_ranges};
use eyot_core::{BoundaryCondition, Control, Field, Grid, LayerSpec, Result, World};
use eyot_drainage::{Base, Descent, Neighbours, Routing, fill, outlets};
use incise::{Cut, Rock};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Rivers cut into rising ground, and hillslopes creep: mountain ranges, connected valleys, graded rivers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Streampower {
    /// Years of a step. Longer steps reach the steady state sooner; shorter ones follow changes on the way more closely.
    #[schemars(range(min = 0.001, max = 1e9), extend("unit" = "yr"))]
    pub years_per_step: f32,
    /// Rise of the ground, times the layer `uplift` if there is one: 0.1 to 1 mm a year in old and young mountains, up to
    /// 10 where continents collide. Relief grows with it, to the power of one over the slope exponent.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "m/yr"))]
    pub uplift: f32,
    /// Erodibility K, times the layer `erodibility` if there is one. Its unit depends on the area exponent m, so that a value
    /// goes with its exponents: about 1e-6 for hard and 1e-4 for soft rock at m = 0.45, n = 1.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m^(1-2m)/yr"))]
    pub erodibility: f32,
    /// Exponent m of the drained area. Rivers have m / n of 0.35 to 0.6.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub area_exponent: f32,
    /// Exponent n of the slope. Above 1 steep reaches are cut fastest and knickpoints sharpen; below 1 they smooth out.
    #[schemars(range(min = 0.05, max = 20.0), extend("unit" = "1"))]
    pub slope_exponent: f32,
    /// Deposition coefficient G: how much of what comes from upstream rivers lay down. 0 carries everything away, as on bare
    /// rock; about 1 in nature, where valleys fill and fans grow, and rivers become steeper by (1 + G)^(1/n).
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub deposition: f32,
    /// Water of a smaller area does not cut: it belongs to the hillslopes, which creep, or slump with `thermal`.
    #[schemars(range(min = 0.0, max = 1e12), extend("unit" = "m2"))]
    pub channel_area: f32,
    /// Diffusivity D of creep: 0.001 to 0.1 in nature; larger cells need more to round their crests. 0 leaves it out.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "m2/yr"))]
    pub diffusivity: f32,
    /// Critical slope of creep, as a tangent: soil slides where slopes come near it, so that crests stay sharp. 1.2 in nature;
    /// 0 leaves it out.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1"))]
    pub critical_slope: f32,
    /// Which way water takes on a slope. `d8`: the steepest of eight directions; `rho8`: as the land falls on the whole, with lots
    /// for diagonal ways, so that small valleys keep less to the grid, but not always with a steady state.
    pub directions: Descent,
}

impl Default for Streampower {
    fn default() -> Self {
        Self {
            years_per_step: 5000.0,
            uplift: 0.001,
            erodibility: 2e-5,
            area_exponent: 0.45,
            slope_exponent: 1.0,
            deposition: 0.0,
            channel_area: 0.0,
            diffusivity: 0.01,
            critical_slope: 0.0,
            directions: Descent::D8,
        }
    }
}

/// Factor on the uplift.
pub const UPLIFT: LayerSpec = LayerSpec::new("uplift", "1", "Factor on the uplift of stream power", (-1e3, 1e3));
pub use eyot_core::layer::known::ERODIBILITY;

impl Process for Streampower {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), HEIGHT_REST.changed(0.0)]
    }

    fn reads(&self) -> Vec<Cow<'static, str>> {
        // The factors only where somebody has made them.
        [HEIGHT, HEIGHT_REST, UPLIFT, ERODIBILITY, BED_LEFT, ERODIBILITY_BELOW].map(|l| l.name).into()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("streampower", self)
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.years_per_step) * SECONDS_PER_YEAR)
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Streampower {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        54
    }
}

impl ActionInstance for Streampower {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        let (grid, sea_level_m) = (moment.grid, moment.sea_level_m);
        let years = f64::from(self.years_per_step);
        let mut z = heights::load(world)?;
        let outlets = outlets(&z, &grid, &Base { sea_level_m: Some(sea_level_m), ..Base::default() })?;
        let held = Held::new(&grid, &outlets, &z, sea_level_m);
        let routing = if drains(&z, &grid, &outlets) {
            Routing::with_descent(&z, &grid, &outlets, self.directions, control)?
        } else {
            let mut surface = z.clone();
            fill(&mut surface, &grid, &outlets, control)?;
            Routing::with_descent(&surface, &grid, &outlets, self.directions, control)?
        };

        let uplifted = uplift(&mut z, &grid, &held, f64::from(self.uplift) * years, world.get(&UPLIFT.name));
        control.check()?;
        let Cut { incised, deposited } = self.incise(&mut z, &grid, &routing, sea_level_m, rock(world), control)?;
        control.check()?;
        let crept = if self.diffusivity > 0.0 {
            let before = row_sums(&z, &grid);
            let diffusion_m2 = f64::from(self.diffusivity) * years;
            if self.critical_slope > 0.0 {
                critical::creep(&mut z, &grid, diffusion_m2, f64::from(self.critical_slope));
            } else {
                creep::creep(&mut z, &grid, diffusion_m2);
            }
            held.restore(&mut z);
            before - row_sums(&z, &grid)
        } else {
            0.0
        };
        heights::store(world, &z)?;

        let area = grid.cell_area_m2();
        for (account, sum, sign, meaning) in [
            ("ground.uplifted", uplifted, 1, "Ground that rose"),
            ("ground.incised", incised, -1, "Ground that rivers cut and carried away"),
            ("ground.crept", crept, -1, "Ground that crept into cells that hold their height"),
        ] {
            world.ledger.add(account, sum * area, "m3", meaning, sign);
        }
        if self.deposition > 0.0 {
            world.ledger.add("ground.deposited", deposited * area, "m3", "Ground that rivers laid down", 1);
        }
        Ok(())
    }
}

/// What the world knows of its rock.
fn rock(world: &World) -> Option<Rock<'_>> {
    let below = world.get(&BED_LEFT.name).zip(world.get(&ERODIBILITY_BELOW.name));
    world.get(&ERODIBILITY.name).map(|here| Rock { here, below })
}

/// True if every cell but the outlets has a lower neighbour. Rivers that have been cut for a while leave no lakes.
fn drains(z: &[f64], grid: &Grid, outlets: &[bool]) -> bool {
    let around = Neighbours::new(grid);
    let w = grid.width;
    (0..grid.height).into_par_iter().all(|y| {
        let inner = y > 0 && y + 1 < grid.height;
        (y * w..(y + 1) * w).all(|i| {
            let x = i - y * w;
            if outlets[i] {
                return true;
            }
            if inner && x > 0 && x + 1 < w {
                let lowest = |k: usize| z[k - 1].min(z[k]).min(z[k + 1]);
                return lowest(i - w).min(lowest(i)).min(lowest(i + w)) < z[i];
            }
            let mut lower = false;
            around.each(i, |_, j| lower |= z[j] < z[i]);
            lower
        })
    })
}

/// Lifts the ground and returns the sum, m.
fn uplift(z: &mut [f64], grid: &Grid, held: &Held, rise_m: f64, factor: Option<&Field>) -> f64 {
    let (columns, rows) = held.free(grid);
    let sums: Vec<f64> = z
        .par_chunks_exact_mut(grid.width)
        .enumerate()
        .filter(|(y, _)| rows.contains(y))
        .map(|(y, row)| {
            let factors = factor.map(|f| &f.row(y)[columns.clone()]);
            let mut sum = 0.0;
            for (x, z) in row[columns.clone()].iter_mut().enumerate() {
                let new = *z + factors.map_or(rise_m, |f| rise_m * f64::from(f[x]));
                sum += new - *z;
                *z = new;
            }
            sum
        })
        .collect();
    sums.iter().sum::<f64>() - held.restore(z)
}

/// Sum over the grid, m, rows folded from north to south.
fn row_sums(z: &[f64], grid: &Grid) -> f64 {
    let rows: Vec<f64> = z.par_chunks_exact(grid.width).map(|row| row.iter().sum()).collect();
    rows.iter().sum()
}

/// Cells that hold their height.
struct Held {
    open_x: bool,
    open_y: bool,
    /// The lowest cells of a world that has neither an open rim nor a sea, with their heights, m.
    lowest: Vec<(u32, f64)>,
}

impl Held {
    fn new(grid: &Grid, outlets: &[bool], z: &[f64], sea_level_m: f64) -> Self {
        let (open_x, open_y) = (grid.rim.x == BoundaryCondition::Open, grid.rim.y == BoundaryCondition::Open);
        let lowest = if open_x || open_y {
            Vec::new()
        } else {
            let held = outlets.iter().enumerate().filter(|&(i, &o)| o && z[i] > sea_level_m);
            held.map(|(i, _)| (i as u32, z[i])).collect()
        };
        Self { open_x, open_y, lowest }
    }

    /// Columns and rows within the open rims.
    fn free(&self, grid: &Grid) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let within =
            |cells: usize, open: bool| if open { 1.min(cells)..cells.saturating_sub(1).max(1) } else { 0..cells };
        (within(grid.width, self.open_x), within(grid.height, self.open_y))
    }

    /// Puts the lowest cells back and returns how much that took, m.
    fn restore(&self, z: &mut [f64]) -> f64 {
        let taken = |&(i, height): &(u32, f64)| std::mem::replace(&mut z[i as usize], height) - height;
        self.lowest.iter().map(taken).sum()
    }
}
