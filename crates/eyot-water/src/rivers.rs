//! Lakes and rivers: level lakes with outlets, rivers as a graph of smooth lines, and their beds.
//!
//! Acts on the land as it is; one step is enough. Where the world has a climate (`rain_mean` or `precipitation`, `temperature_mean` or
//! `temperature`), rain and evaporation are taken from it, else `rain` and `evaporation` hold everywhere.
//!
//! # Equations
//! 1. Runoff of a cell: `R = P - AET`, `AET = P [phi tanh(1/phi) (1 - exp(-phi))]^(1/2)`, `phi = E / P`; with a climate
//!    `E = 0.3 + 0.025 T + 0.00005 T^3` m a year, `T` in degrees C.
//! 2. A depression fills until it runs over its pass, or until it loses what comes in, `Q = (E - AET) A`. Every cell of a lake has its level,
//!    to the bit. Depressions smaller than `min_lake_area` or shallower than `min_lake_depth` are filled with ground.
//! 3. Discharge `Q = sum R a` over all cells upstream, less what lakes lose on the way.
//! 4. Rivers run from their springs along the steepest way to the sea, the rim, a closed lake or a hollow that dries them up. Orders are
//!    Strahler's. `w = width Q^0.5`, `d = depth Q^0.3` (m, Q in m3/s).
//! 5. Lines are smoothed within half a cell of their way, heights never rise downstream. A waterfall is where the water falls more than
//!    5 m from cell to cell at a slope above 0.5 with more than 0.5 m3/s. Reaches in plains of five widths braid where they are steep for
//!    their water (`braid.rs`), else they meander where they fall less than 0.005, until they are `sinuosity` times as long as the
//!    straight way (`meander.rs`), and leave oxbow lakes.
//! 6. Beds at least 0.7 cells wide are dug: see `bed.rs`. With `bed = "passes"` every cell of a river is lowered by `pass_depth` for each
//!    spring above it, as in the source.
//!
//! # Source
//! Riesen 2015, sections 6.2 and 6.3: springs at random places in a band of heights, the way of least resistance to a lake, and beds
//! by the number of passes. Barnes, Callaghan and Wickert 2020 and 2021 for the depressions; Budyko 1974 in the form of Zhang et al.
//! 2001; Turc 1954; Leopold and Maddock 1953, Moody and Troutman 2002 and Andreadis et al. 2013 for widths and depths; Lehner and Grill 2013
//! for the names of attributes; Yuksel, Schaefer and Keyser 2011 for the lines; Howard and Knutson 1984 and Paris et al. 2023
//! for the meanders; Leopold and Wolman 1957 and Ashmore 2013 for braids.
//!
//! # Differences
//! The source's lakes were tilted, and its rivers unfinished. Ours are level, and rivers are complete: no loops, no vertex uphill.
//!
//! # Layers
//! Changes `height` (m); writes `water` (m), `lake_level` (m), `discharge` (m3/s), `river` (1) and, with springs in a band,
//! `river_passes` (1). Keeps the components `rivers` (lines), `lakes` and `oxbow_lakes` (polygons) and `waterfalls` (points).
//!
//! # Conserves
//! What fills small depressions, what beds are dug from, and the water that stood on the land and runs off are in the ledger
//! (`ground.silted`, `ground.carved`, `water.routed`; `tests/it/rivers.rs`).

use crate::bed::{self, Piece};
use crate::course::{Course, course};
use crate::kept;
use crate::lakes::{self, Balance, Lakes, Least};
use crate::network::{End, Network, Reach, trace};
use crate::runoff::{Climate, evaporation_of};
use crate::wander::{Freedom, Ground};
use crate::{DISCHARGE, LAKE_LEVEL, LAKES, OXBOWS, RIVER, RIVER_PASSES, RIVERS, WATERFALLS};
use eyot_core::component::Shape;
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::math64::pow;
use eyot_core::process::{Action, ActionInstance, LayerUse, Locality, Moment, Process, SECONDS_PER_YEAR, check_ranges};
use eyot_core::rng::{Key, hash};
use eyot_core::{BoundaryCondition, Control, Error, Field, Grid, LayerSpec, Result, World};
use eyot_drainage::Land;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where rivers begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Springs {
    /// Where enough water has come together.
    #[default]
    Discharge,
    /// Where enough land has come together.
    Area,
    /// At random places in a band of heights.
    Band,
    /// At the outlets of lakes.
    Lakes,
}

/// How deep beds are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Bed {
    /// As deep as the water, where the river is wide enough for a cell to show it.
    #[default]
    Hydraulic,
    /// By the number of springs above, on every river.
    Passes,
    /// Rivers dig no beds.
    None,
}

/// Lakes with outlets, and rivers from their springs to the sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Rivers {
    /// Rain and snow of a year, where the world has no climate. More makes wider rivers.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m/a"))]
    pub rain: f32,
    /// What open water loses in a year, where the world has no climate. More than the rain makes closed lakes.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "m/a"))]
    pub evaporation: f32,
    /// Rain and evaporation come from the layers of a climate where there are some.
    pub climate: bool,
    /// Where rivers begin: where enough water (discharge) or land (area) has come together, at random places in a band of heights
    /// (band), or at the outlets of lakes.
    pub springs: Springs,
    /// Water of the smallest river, with springs by discharge.
    #[schemars(range(min = 0.000001, max = 1000000.0), extend("unit" = "m3/s"))]
    pub min_discharge: f32,
    /// Land above the highest springs, with springs by area.
    #[schemars(range(min = 0.0, max = 1.0e12), extend("unit" = "m2"))]
    pub min_area: f32,
    /// How many springs lie in the band.
    #[schemars(range(min = 1, max = 1000000), extend("unit" = "1"))]
    pub spring_count: u32,
    /// Lowest height of springs in a band.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub spring_low: f32,
    /// Greatest height of springs in a band.
    #[schemars(range(min = -12000.0, max = 12000.0), extend("unit" = "m"))]
    pub spring_high: f32,
    /// Smaller depressions are no lakes and are filled with ground.
    #[schemars(range(min = 0.0, max = 1.0e12), extend("unit" = "m2"))]
    pub min_lake_area: f32,
    /// Shallower depressions are no lakes and are filled with ground.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub min_lake_depth: f32,
    /// Width of a river of 1 m3/s; it grows with the square root of the discharge.
    #[schemars(range(min = 0.01, max = 1000.0), extend("unit" = "m"))]
    pub width: f32,
    /// Depth of a river of 1 m3/s; it grows with the discharge to the power of 0.3.
    #[schemars(range(min = 0.001, max = 100.0), extend("unit" = "m"))]
    pub depth: f32,
    /// How winding rivers become that run slowly through wide plains: length over the straight way. 1 leaves them as they are.
    #[schemars(range(min = 1.0, max = 2.5), extend("unit" = "1"))]
    pub sinuosity: f32,
    /// Rivers that are steep for their water braid where they have a flood plain.
    pub braids: bool,
    /// How beds are dug: as deep as the water (hydraulic), by the number of springs above (passes), or not at all (none).
    pub bed: Bed,
    /// With beds by passes, what each spring above digs.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub pass_depth: f32,
    /// Water leaves over closed rims too, as from a map that was cut out of a larger one.
    pub closed_rims: bool,
}

impl Default for Rivers {
    fn default() -> Self {
        Self {
            rain: 1.2,
            evaporation: 0.6,
            climate: true,
            springs: Springs::Discharge,
            min_discharge: 0.05,
            min_area: 1e6,
            spring_count: 250,
            spring_low: 0.0,
            spring_high: 12000.0,
            min_lake_area: 20_000.0,
            min_lake_depth: 1.0,
            width: 7.2,
            depth: 0.27,
            sinuosity: 1.5,
            braids: true,
            bed: Bed::Hydraulic,
            pass_depth: 0.2,
            closed_rims: true,
        }
    }
}

/// Exponents of width and depth over discharge.
const WIDTH_EXPONENT: f64 = 0.5;
const DEPTH_EXPONENT: f64 = 0.3;
/// The account of water.
const ROUTED: &str = "Water that rivers took away, less what they and lakes were filled with";
/// Stream of random numbers of the springs.
const STREAM: u32 = 0x5350_5247;

impl Process for Rivers {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = vec![
            HEIGHT.changed(0.0),
            WATER.written(0.0),
            LAKE_LEVEL.written(0.0),
            DISCHARGE.written(0.0),
            RIVER.written(0.0),
        ];
        if self.counts_passes() {
            layers.push(RIVER_PASSES.written(0.0));
        }
        layers
    }

    fn reads(&self) -> Vec<std::borrow::Cow<'static, str>> {
        let climate = ["rain_mean", "precipitation", "temperature_mean", "temperature"];
        let climate = climate.into_iter().filter(|_| self.climate);
        std::iter::once("height").chain(climate).map(std::borrow::Cow::Borrowed).collect()
    }

    fn views(&self) -> Vec<(&'static str, Shape)> {
        let features = [RIVERS, LAKES, OXBOWS].map(|name| (name, Shape::Features));
        features.into_iter().chain([(WATERFALLS, Shape::Points)]).collect()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check_ranges("rivers", self)?;
        let bad = |field: &str, reason: String| {
            Err(Error::BadParameter { owner: "rivers".into(), field: field.into(), reason })
        };
        if self.springs == Springs::Band && self.spring_low >= self.spring_high {
            let (low, high) = (self.spring_low, self.spring_high);
            return bad("spring_low", format!("is {low} m and `spring_high` {high} m: the band must have a height"));
        }
        if self.bed == Bed::Passes && self.springs != Springs::Band {
            return bad("bed", "by passes needs springs to count: set `springs` to \"band\"".into());
        }
        Ok(())
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Rivers {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        110
    }
}

/// Width and depth of a river, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Width of the water, m.
    pub width_m: f64,
    /// Its depth, m.
    pub depth_m: f64,
}

impl ActionInstance for Rivers {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        let grid = &moment.grid;
        let sea = moment.sea_level_m;
        let land =
            Land { height: &world.layer("height")?.field, grid, sea_level_m: sea, closed_rims: self.closed_rims };
        let (height, outlets) = land.heights_and_outlets()?;
        let (runoff, loss) = self.rates(world, grid, &height);
        let least = Least { area_m2: f64::from(self.min_lake_area), depth_m: f64::from(self.min_lake_depth) };
        let balance = Balance { runoff: &runoff, loss: &loss };
        let found = lakes::find(&height, grid, &outlets, &balance, &least, control)?;
        drop((runoff, loss));
        control.check()?;

        let springs = self.springs(&found, &height, &outlets, grid, moment, world.seed)?;
        let edge = |i: usize| {
            let (x, y) = (i % grid.width, i / grid.width);
            let ends = |rim: BoundaryCondition| rim != BoundaryCondition::Wrap;
            (ends(grid.rim.x) && (x == 0 || x + 1 == grid.width))
                || (ends(grid.rim.y) && (y == 0 || y + 1 == grid.height))
        };
        let end = |i: usize| match i {
            _ if found.lake[i] > 0 => End::Lake,
            _ if f64::from(height[i]) <= sea => End::Sea,
            _ if edge(i) && outlets[i] => End::Rim,
            _ => End::Hollow,
        };
        let network = trace(&found, &springs, end);
        // The sea's surface, where rivers end in it.
        let surface: Vec<f32> = found.surface.iter().map(|z| z.max(sea as f32)).collect();
        let seed = world.seed;
        let freedom = Freedom { sinuosity: f64::from(self.sinuosity), braids: self.braids };
        let wide = |r: &Reach| self.section(r.discharge).width_m;
        let floor = Ground::new(&found, grid, &network, freedom, wide);
        let led = |r: &Reach| course(&r.cells, grid, &found.routing, &surface, seed);
        let courses: Vec<Course> = (0..network.reaches.len() as u32)
            .into_par_iter()
            .zip(&network.reaches)
            .map(|(k, r)| floor.wandered(k, r, led(r), wide(r), freedom, seed))
            .collect();
        drop(floor);
        control.check()?;

        let ground: Vec<f32> =
            (0..height.len()).map(|i| if found.lake[i] > 0 { height[i] } else { found.surface[i] }).collect();
        let passes = self.counts_passes().then(|| passes(&found, &springs)).transpose()?;
        let pieces = self.pieces(&network, &courses, &found, passes.as_deref(), grid);
        let beds = bed::dig(&ground, grid, &pieces, self.bed != Bed::None, |i| f64::from(ground[i]) <= sea);
        let (rivers, falls) =
            kept::rivers(&network, &courses, &found, grid, |r, threads| self.section(r.discharge / threads as f64))?;
        world.components.insert(RIVERS, rivers);
        world.components.insert(WATERFALLS, falls);
        world.components.insert(LAKES, kept::lakes(&found, &beds.ground, grid)?);
        world.components.insert(OXBOWS, kept::oxbows(&network, &courses, wide)?);
        let volume = |from: &[f32], to: &[f32]| {
            let grown = from.iter().zip(to).map(|(a, b)| f64::from(*b) - f64::from(*a));
            grown.sum::<f64>() * grid.cell_area_m2()
        };
        let (silted, carved) = (volume(&height, &ground), -volume(&ground, &beds.ground));
        world.ledger.add("ground.silted", silted, "m3", "Ground that small depressions were filled with", 1);
        world.ledger.add("ground.carved", carved, "m3", "Ground that rivers dug out of their beds", -1);

        let level =
            |i: usize| if found.lake[i] > 0 { found.lakes[found.lake[i] as usize].level } else { beds.ground[i] };
        let water = |i: usize| if found.lake[i] > 0 { (level(i) - beds.ground[i]).max(0.0) } else { beds.water[i] };
        put(world, &LAKE_LEVEL, level)?;
        let stood = world.layer("water")?.field.sum();
        put(world, &WATER, water)?;
        let ran_off = (stood - world.layer("water")?.field.sum()) * grid.cell_area_m2();
        world.ledger.add("water.routed", ran_off, "m3", ROUTED, -1);
        put(world, &DISCHARGE, |i| found.discharge[i].max(0.0) as f32)?;
        put(world, &RIVER, |i| if found.lake[i] > 0 { 0.0 } else { beds.cover[i] })?;
        if let Some(passes) = &passes {
            put(world, &RIVER_PASSES, |i| passes[i])?;
        }
        put(world, &HEIGHT, |i| beds.ground[i])
    }
}

/// Gives every cell of a layer a new value.
fn put(world: &mut World, spec: &LayerSpec, value: impl Fn(usize) -> f32) -> Result<()> {
    let field: &mut Field = &mut world.layer_mut(&spec.name)?.field;
    let width = field.width();
    for (y, row) in field.rows_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(x, v)| *v = value(y * width + x));
    }
    Ok(())
}

/// Springs whose water runs through each cell.
fn passes(found: &Lakes, springs: &[u32]) -> Result<Vec<f32>> {
    let mut count = vec![0.0; found.lake.len()];
    springs.iter().for_each(|&i| count[i as usize] = 1.0);
    found.routing.accumulate(&mut count)?;
    Ok(count.into_iter().map(|n| n as f32).collect())
}

impl Rivers {
    fn counts_passes(&self) -> bool {
        self.springs == Springs::Band
    }

    /// What runs off each cell, and what it loses beyond that as a part of a lake, m3/s.
    fn rates(&self, world: &World, grid: &Grid, height: &[f32]) -> (Vec<f64>, Vec<f64>) {
        let per_second = grid.cell_area_m2() / SECONDS_PER_YEAR;
        let layer =
            |names: [&str; 2]| names.into_iter().filter(|_| self.climate).find_map(|n| world.get(n)).map(Field::to_vec);
        let rain = layer(["rain_mean", "precipitation"]);
        let temperature = layer(["temperature_mean", "temperature"]);
        let even = Climate { rain: f64::from(self.rain), evaporation: f64::from(self.evaporation) };
        if rain.is_none() && temperature.is_none() {
            let rates = (even.runoff() * per_second, even.lake_loss() * per_second);
            return (vec![rates.0; height.len()], vec![rates.1; height.len()]);
        }
        (0..height.len())
            .into_par_iter()
            .map(|i| {
                let climate = Climate {
                    // Layers are in mm a year.
                    rain: rain.as_ref().map_or(even.rain, |r| f64::from(r[i]) / 1000.0),
                    evaporation: temperature.as_ref().map_or(even.evaporation, |t| evaporation_of(f64::from(t[i]))),
                };
                (climate.runoff() * per_second, climate.lake_loss() * per_second)
            })
            .unzip()
    }

    /// Cells that rivers begin at.
    fn springs(
        &self,
        found: &Lakes,
        height: &[f32],
        outlets: &[bool],
        grid: &Grid,
        moment: &Moment,
        seed: u64,
    ) -> Result<Vec<u32>> {
        let cells = 0..height.len();
        let those = |is: &(dyn Fn(usize) -> bool + Sync)| -> Vec<u32> {
            cells.clone().into_par_iter().filter(|&i| !outlets[i] && is(i)).map(|i| i as u32).collect()
        };
        match self.springs {
            Springs::Discharge => {
                Ok(those(&|i| found.lake[i] == 0 && found.discharge[i] >= f64::from(self.min_discharge)))
            }
            Springs::Area => {
                let area = found.routing.upstream_area_m2(grid);
                Ok(those(&|i| found.lake[i] == 0 && area[i] >= f64::from(self.min_area)))
            }
            Springs::Lakes => {
                Ok(found.lakes.iter().filter_map(|l| l.outlet).filter(|&i| !outlets[i as usize]).collect())
            }
            Springs::Band => {
                let key = Key::new(seed, STREAM, moment.step);
                let band = self.spring_low..=self.spring_high;
                let mut open: Vec<(u32, u32)> = those(&|i| band.contains(&height[i]) && found.lake[i] == 0)
                    .into_iter()
                    .map(|i| (hash(key, i), i))
                    .collect();
                if open.is_empty() {
                    let low = height.iter().copied().fold(f32::MAX, f32::min);
                    let high = height.iter().copied().fold(f32::MIN, f32::max);
                    let reason = format!(
                        "to `spring_high` holds no dry land: the land lies from {low} to {high} m; choose a band within that"
                    );
                    return Err(Error::BadParameter { owner: "rivers".into(), field: "spring_low".into(), reason });
                }
                let count = (self.spring_count as usize).min(open.len());
                open.select_nth_unstable(count - 1);
                open.truncate(count);
                open.sort_unstable();
                Ok(open.into_iter().map(|(_, i)| i).collect())
            }
        }
    }

    /// Width and depth of a river.
    fn section(&self, discharge: f64) -> Section {
        let q = discharge.max(0.0);
        let depth_m = f64::from(self.depth) * pow(q, DEPTH_EXPONENT);
        Section { width_m: f64::from(self.width) * pow(q, WIDTH_EXPONENT), depth_m }
    }

    /// The pieces of all rivers outside of lakes.
    fn pieces(
        &self,
        network: &Network,
        courses: &[Course],
        found: &Lakes,
        passes: Option<&[f32]>,
        grid: &Grid,
    ) -> Vec<Piece> {
        let pieces = |(reach, course): (&Reach, &Course)| -> Vec<Piece> {
            let cut = |(ends, place): (&[[f32; 3]], &[f32])| {
                let k = place[0] as usize;
                let cell = reach.cells[k] as usize;
                let mut section = self.section(found.discharge[cell] / course.thread_count() as f64);
                if let (Bed::Passes, Some(passes)) = (self.bed, passes) {
                    section.depth_m = f64::from(self.pass_depth) * f64::from(passes[cell]);
                    section.width_m = section.width_m.max(grid.cell_x_m.max(grid.cell_y_m));
                }
                Piece { ends: [ends[0], ends[1]], width_m: section.width_m, depth_m: section.depth_m }
            };
            if reach.lake > 0 {
                return Vec::new();
            }
            let threads = course.lines().flat_map(|line| line.windows(2).zip(course.place.windows(2)).map(cut));
            let whole = self.section(reach.discharge);
            let level = |p: [f64; 2], z: f32| [p[0] as f32, p[1] as f32, z];
            let oxbows = course.oxbows.iter().flat_map(|o| {
                o.line.windows(2).map(|p| Piece {
                    ends: [level(p[0], o.level), level(p[1], o.level)],
                    width_m: whole.width_m,
                    depth_m: whole.depth_m,
                })
            });
            threads.chain(oxbows).collect()
        };
        let each: Vec<Vec<Piece>> = network.reaches.par_iter().zip(courses).map(pieces).collect();
        each.concat()
    }
}
