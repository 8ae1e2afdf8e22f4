//! Glaciers: ice that flows, slides over its bed and carves it, carries debris and leaves moraines.
//!
//! A step is a round: the ice flows for `ice_years` towards a steady state, then wears its bed for `years` as it stands.
//!
//! # Equations
//! `H` thickness of the ice, `b` its bed, `s = b + H`, all in m; `n = 3`; times in years.
//! 1. `dH/dt = div(D grad s) + m`, `D = (2 A (rho g)^3 H^5 / 5 + C (rho g)^3 H^4) |grad s|^2`: it shears and slides.
//! 2. Sliding `u = C (rho g H |grad s|)^3`, with `C = sliding / (1 + constriction k)`, `k` the curvature of a hollow bed across the flow:
//!    the walls of narrow valleys hold the ice.
//! 3. Mass balance `m = min(gradient (s - E), accumulation)`, `E = ela + ela_change turn + aspect n_y`: `turn` is the number of rounds before,
//!    `n_y` is 1 on walls that face south and -1 on those that face north. With a climate `m = (P - M) / 0.91`,
//!    `M = 0.645 + 0.296 T + 0.009 T^2` m, `T` the mean of summer in degrees C.
//! 4. Snow and ice on slopes above `repose` fall to lower neighbours.
//! 5. Erosion `abrasion u^2 (1 + |grad b|^2)^(1/2) + plucking u max(0, fall of b along the flow)`, times `H^2 / (H^2 + (80 m)^2)`, since
//!    thin ice is mostly frozen to its bed, and times the layer `erodibility` if there is one; `u` is smoothed by `smoothing` turns of weights 1, 2, 1. Moraines are taken before rock.
//! 6. Debris goes down the ice to where that ends. There a share of `1 - washed_out` stays, where the ground is not steep and up to
//!    `moraine` metres in all; meltwater takes the rest away.
//!
//! # Source
//! The flow of Halfar 1983, whose dome is met within 2 % (`tests/it/flow.rs`); constriction of Braun, Zwartz and Tomkin 1999;
//! abrasion of Herman et al. 2015; plucking on falling beds after Iverson 2012; mass balance by climate of Ohmura, Kasser and Funk 1992; rounds
//! of ice and erosion after Cordonnier et al. 2023. Egholm et al. 2011 for what flow in steep mountains lacks here.
//!
//! # Differences
//! - The flow is Newton's step of an implicit scheme with two factors (`sheet.rs`), and no cell gives more than it has.
//! - Ice is pulled by the slope at its place alone: the push and pull of ice around it stands only in the smoothing of the speed and in
//!   the constriction.
//!
//! # Layers
//! Changes `height` (m), `glacier` (m of ice), `glacial_erosion` (m) and `moraine` (m); writes `glacier_sliding` (m/a). Reads
//! `erodibility` (1) if there is one and, with `climate`, `temperature_mean` or `temperature` with `rain_mean` or `precipitation`.
//!
//! # Limits
//! Any `time_step` is stable; long ones reach the steady state in fewer steps, and their ice lags behind. A round takes 30 m of rock at most.
//! Lengths in cells (smoothing, the curvature of beds) make details depend on the resolution.
//!
//! # Conserves
//! Ice: what falls, melts, breaks off and leaves is in the accounts `glacier`. Rock: what is taken from the ground is left in moraines or
//! washed out, in the accounts `ground` and `debris` (`tests/it/ledger.rs`).

use crate::balance::Balance;
use crate::bed::{self, Wear};
use crate::padded::Padded;
use crate::sheet::{Sheet, Sums};
use crate::{GLACIAL_EROSION, GLACIER, GLACIER_SLIDING, MORAINE, debris};
use eyot_core::layer::known::{ERODIBILITY, HEIGHT};
use eyot_core::process::{Action, ActionInstance, LayerUse, Locality, Moment, Process, SECONDS_PER_YEAR, check_ranges};
use eyot_core::{Control, Error, Field, Grid, LayerSpec, Result, World};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Glaciers that flow, carve valleys and leave moraines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Glaciers {
    /// Years that the ice wears its bed in a step. More carves faster, with fewer turns between ice and land.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "yr"))]
    pub years: f32,
    /// Years that the ice flows in a step before. The first glaciers need some 300 to grow, later rounds less.
    #[schemars(range(min = 0.0, max = 1e6), extend("unit" = "yr"))]
    pub ice_years: f32,
    /// Time step of the flow.
    #[schemars(range(min = 0.01, max = 50.0), extend("unit" = "yr"))]
    pub time_step: f32,
    /// Height of the equilibrium line, where as much snow falls as melts: 3000 m in the Alps now, 1800 m in the last ice age.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub ela: f32,
    /// How much higher the equilibrium line is in each step than in the one before. Above zero glaciers retreat.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub ela_change: f32,
    /// How much higher the equilibrium line is on a wall that faces south; it is as much lower on one that faces north. Negative south of
    /// the equator.
    #[schemars(range(min = -2000.0, max = 2000.0), extend("unit" = "m"))]
    pub aspect: f32,
    /// Change of the mass balance with height.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1/a"))]
    pub gradient: f32,
    /// Snow of a year at most, as ice.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m/a"))]
    pub accumulation: f32,
    /// The balance comes from the layers of a climate where there are some.
    pub climate: bool,
    /// With a climate, how much warmer summers are than the mean of the year.
    #[schemars(range(min = 0.0, max = 40.0), extend("unit" = "K"))]
    pub summer: f32,
    /// Rate factor A of ice that shears: 7.6e-17 at the melting point, less where it is cold.
    #[schemars(range(min = 0.0, max = 1e-12), extend("unit" = "Pa^-3/a"))]
    pub softness: f64,
    /// Rate C of sliding under a pull. More makes thinner and faster ice.
    #[schemars(range(min = 0.0, max = 1e-8), extend("unit" = "m/(a Pa^3)"))]
    pub sliding: f64,
    /// How much the walls of narrow valleys hold the ice. 0 leaves V-shaped valleys V-shaped.
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "m"))]
    pub constriction: f32,
    /// Abrasion of a year over the square of the speed.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "a/m"))]
    pub abrasion: f32,
    /// Plucking over speed and fall of the bed: steps of valleys wander up, basins become deeper.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub plucking: f32,
    /// How often the speed is smoothed by weights 1, 2, 1 before it wears the bed.
    #[schemars(range(min = 0, max = 64), extend("unit" = "1"))]
    pub smoothing: u32,
    /// Steepest slope that snow and ice keep.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub repose: f32,
    /// Share of the debris that meltwater carries off the map.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub washed_out: f32,
    /// Height of moraines at most.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub moraine: f32,
}

impl Default for Glaciers {
    fn default() -> Self {
        Self {
            years: 4000.0,
            ice_years: 100.0,
            time_step: 0.5,
            ela: 1800.0,
            ela_change: 0.0,
            aspect: 100.0,
            gradient: 0.008,
            accumulation: 1.5,
            climate: true,
            summer: 8.0,
            softness: 7.57e-17,
            sliding: 3e-14,
            constriction: 1000.0,
            abrasion: 2.7e-7,
            plucking: 1e-5,
            smoothing: 6,
            repose: 35.0,
            washed_out: 0.9,
            moraine: 40.0,
        }
    }
}

/// Times that the ground is smoothed before walls face anywhere.
const ASPECT_SMOOTHING: usize = 4;
/// How much colder it is higher up, K/m.
const LAPSE: f32 = 0.0065;
/// Tangents of slopes on which all debris stays, and on which none does.
const LIES: (f32, f32) = (0.25, 0.6);

impl Process for Glaciers {
    fn layers(&self) -> Vec<LayerUse> {
        vec![
            HEIGHT.changed(0.0),
            GLACIER.changed(0.0),
            GLACIAL_EROSION.changed(0.0),
            MORAINE.changed(0.0),
            GLACIER_SLIDING.written(0.0),
        ]
    }

    fn reads(&self) -> Vec<Cow<'static, str>> {
        let own = [HEIGHT, GLACIER, GLACIAL_EROSION, MORAINE, ERODIBILITY].map(|l| l.name);
        let climate = ["rain_mean", "precipitation", "temperature_mean", "temperature"];
        let climate = climate.into_iter().filter(|_| self.climate);
        own.into_iter().chain(climate.map(Cow::Borrowed)).collect()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("glaciers", self)?;
        if self.ice_years > 0.0 && self.ice_years < self.time_step {
            let reason = format!(
                "is {} years and `time_step` {}: ice that flows needs one time step at least",
                self.ice_years, self.time_step
            );
            return Err(Error::BadParameter { owner: "glaciers".into(), field: "ice_years".into(), reason });
        }
        Ok(())
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        let years = self.years.max(self.ice_years);
        (years > 0.0).then(|| f64::from(years) * SECONDS_PER_YEAR)
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Glaciers {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        128
    }
}

impl ActionInstance for Glaciers {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        let grid = &moment.grid;
        let sea = moment.sea_level_m as f32;
        let padded = |world: &World, name: &str| -> Result<Padded> {
            let field = &world.layer(name)?.field;
            Ok(Padded::from_fn(grid, |x, y| field.get(x, y)))
        };
        let (ground, ice) = (padded(world, "height")?, padded(world, "glacier")?);
        let before = total(&ice, grid);
        let mut surface = Padded::from_fn(grid, |x, y| ground.at(x, y) + ice.at(x, y));
        surface.smooth(grid, ASPECT_SMOOTHING);
        let balance = self.balance(world, moment, &surface);
        let slip = bed::slip(grid, &ground, &surface, Sheet::slip_of(self.sliding), self.constriction);
        drop(surface);
        let mut sheet = Sheet::new(grid, ground, ice, slip, self.softness);
        let repose = tangent(self.repose);
        let count = (f64::from(self.ice_years) / f64::from(self.time_step)).ceil() as u64;
        let years = f64::from(self.ice_years) / count.max(1) as f64;
        let mut sums = Sums::default();
        for k in 0..count {
            sums += sheet.step(years, &balance, repose, sea);
            control.tick(k + 1, count)?;
        }
        let rounded = total(&sheet.ice, grid) - before - (sums.snow - sums.melted - sums.calved - sums.left);
        let speed = bed::speed(grid, &sheet.ice, &sheet.surface, &sheet.slip, self.smoothing as usize);
        put(world, &GLACIER, |x, y| sheet.ice.at(x, y))?;
        put(world, &GLACIER_SLIDING, |x, y| if sheet.ice.at(x, y) > 0.0 { speed.at(x, y) } else { 0.0 })?;
        let area = grid.cell_area_m2();
        for (account, sum, sign, meaning) in [
            ("glacier.snow", sums.snow, 1, "Snow that became ice of glaciers"),
            ("glacier.melted", sums.melted, -1, "Ice of glaciers that melted"),
            ("glacier.calved", sums.calved, -1, "Ice of glaciers that broke off into the sea"),
            ("glacier.left", sums.left, -1, "Ice of glaciers that left over an open rim"),
            ("glacier.rounded", rounded, 1, "Ice of glaciers that rounding made, or lost where negative"),
        ] {
            world.ledger.add(account, sum * area, "m3", meaning, sign);
        }
        if self.years > 0.0 {
            self.carve(world, grid, &sheet, &speed)?;
        }
        Ok(())
    }
}

impl Glaciers {
    /// What falls and melts where. `surface`: of the ice, smoothed, m.
    fn balance(&self, world: &World, moment: &Moment, surface: &Padded) -> Balance {
        let grid = &moment.grid;
        let layer =
            |names: [&str; 2]| names.into_iter().filter(|_| self.climate).find_map(|n| world.get(n)).map(Field::to_vec);
        let climate = layer(["temperature_mean", "temperature"]).zip(layer(["rain_mean", "precipitation"]));
        if let Some((temperature, rain)) = climate {
            let ground = world.get("height").map(Field::to_vec).unwrap_or_default();
            let at_zero = |(t, z): (f32, f32)| t + self.summer + LAPSE * z;
            return Balance::Climate {
                summer: temperature.into_iter().zip(ground).map(at_zero).collect(),
                precipitation: rain.into_iter().map(|p| 0.001 * p).collect(),
                lapse: LAPSE,
            };
        }
        let line = self.ela + self.ela_change * moment.turn as f32;
        let (w, dx, dy) = (grid.width, grid.cell_x_m as f32, grid.cell_y_m as f32);
        let south = |i: usize| {
            let (a, b, c) = (surface.framed(i / w), surface.framed(i / w + 1), surface.framed(i / w + 2));
            let x = i % w;
            let (gx, gy) = ((b[x + 2] - b[x]) / (2.0 * dx), (c[x + 1] - a[x + 1]) / (2.0 * dy));
            -gy / (1.0 + gx * gx + gy * gy).sqrt()
        };
        Balance::Heights {
            line: (0..grid.cells()).into_par_iter().map(|i| line + self.aspect * south(i)).collect(),
            gradient: self.gradient,
            most: self.accumulation,
        }
    }

    /// Lets the ice wear its bed, and lays down what it carries.
    fn carve(&self, world: &mut World, grid: &Grid, sheet: &Sheet, speed: &Padded) -> Result<()> {
        let w = grid.width;
        let wear = Wear { abrasion: self.abrasion, plucking: self.plucking, years: self.years };
        let rock = world.get(&ERODIBILITY.name);
        let factor = |x: usize, y: usize| rock.map_or(1.0, |r| r.get(x, y));
        let (ice, surface) = (&sheet.ice, &sheet.surface);
        let eroded = bed::erosion(grid, &sheet.bed, ice, surface, speed, wear, factor);
        let arrived = debris::arrive(grid, ice, surface, eroded.clone());
        let mut bed = sheet.bed.clone();
        bed.smooth(grid, 1);
        let (dx, dy) = (grid.cell_x_m as f32, grid.cell_y_m as f32);
        let old = world.layer("moraine")?.field.clone();
        // Moraines are wider than a cell.
        let mut laid = Padded::from_fn(grid, |x, y| (1.0 - self.washed_out) * arrived[y * w + x]);
        laid.smooth(grid, 2);
        let laid = Padded::from_fn(grid, |x, y| {
            let (a, b, c) = (bed.framed(y), bed.framed(y + 1), bed.framed(y + 2));
            let (gx, gy) = ((b[x + 2] - b[x]) / (2.0 * dx), (c[x + 1] - a[x + 1]) / (2.0 * dy));
            let steep = (((gx * gx + gy * gy).sqrt() - LIES.0) / (LIES.1 - LIES.0)).clamp(0.0, 1.0);
            let room = (self.moraine - (old.get(x, y) - eroded[y * w + x]).max(0.0)).max(0.0);
            (laid.at(x, y) * (1.0 - steep)).min(room)
        });
        // The ground in single precision decides what was taken and laid down.
        let (mut taken, mut left) = (0.0, 0.0);
        let height = &mut world.layer_mut("height")?.field;
        let rows = height.rows_mut().enumerate().map(|(y, row)| {
            let mut sums = (0.0, 0.0);
            for (x, z) in row.iter_mut().enumerate() {
                let low = *z - eroded[y * w + x];
                let new = low + laid.at(x, y);
                sums.0 += f64::from(*z) - f64::from(low);
                sums.1 += f64::from(new) - f64::from(low);
                *z = new;
            }
            sums
        });
        rows.for_each(|(t, l)| (taken, left) = (taken + t, left + l));
        put(world, &MORAINE, |x, y| (old.get(x, y) - eroded[y * w + x]).max(0.0) + laid.at(x, y))?;
        let carved = world.layer("glacial_erosion")?.field.clone();
        put(world, &GLACIAL_EROSION, |x, y| carved.get(x, y) + (eroded[y * w + x] - old.get(x, y)).max(0.0))?;
        let area = grid.cell_area_m2();
        for (account, sum, sign, meaning) in [
            ("ground.taken_by_ice", taken, -1, "Ground that glaciers took away"),
            ("ground.moraines", left, 1, "Ground that glaciers left in moraines"),
            ("debris.taken_up", taken, 1, "Debris that glaciers took up"),
            ("debris.laid_down", left, -1, "Debris that glaciers laid down in moraines"),
            ("debris.washed_out", taken - left, -1, "Debris that meltwater carried off the map"),
        ] {
            world.ledger.add(account, sum * area, "m3", meaning, sign);
        }
        Ok(())
    }
}

/// Tangent of degrees.
fn tangent(degrees: f32) -> f32 {
    let degrees = f64::from(degrees);
    (eyot_core::math64::sin_degrees(degrees) / eyot_core::math64::cos_degrees(degrees)) as f32
}

/// Sum over the grid, rows folded from north to south, m.
fn total(v: &Padded, grid: &Grid) -> f64 {
    (0..grid.height).map(|y| v.row(y).iter().map(|v| f64::from(*v)).sum::<f64>()).sum()
}

/// Gives every cell of a layer a new value.
fn put(world: &mut World, spec: &LayerSpec, value: impl Fn(usize, usize) -> f32) -> Result<()> {
    let field: &mut Field = &mut world.layer_mut(&spec.name)?.field;
    for (y, row) in field.rows_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(x, v)| *v = value(x, y));
    }
    Ok(())
}
