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
//!    5 m from cell to cell at a slope above 0.5 with more than 0.5 m3/s. Reaches that fall less than 0.005 through plains of five widths
//!    meander (`meander.rs`) until they are `sinuosity` times as long as the straight way.
//! 6. Beds at least 0.7 cells wide are dug: see `bed.rs`. With `bed = "passes"` every cell of a river is lowered by `pass_depth` for each
//!    spring above it, as in the source.
//!
//! # Source
//! Riesen 2015, sections 6.2 and 6.3: springs at random places in a band of heights, the way of least resistance to a lake, and beds
//! by the number of passes. Barnes, Callaghan and Wickert 2020 and 2021 for the depressions; Budyko 1974 in the form of Zhang et al.
//! 2001; Turc 1954; Leopold and Maddock 1953, Moody and Troutman 2002 and Andreadis et al. 2013 for widths and depths; Lehner and Grill 2013
//! for the names of attributes; Yuksel, Schaefer and Keyser 2011 for the lines; Howard and Knutson 1984 and Paris et al. 2023
//! for the meanders.
//!
//! # Differences
//! The source's lakes were tilted, and its rivers unfinished. Ours are level, and rivers are complete: no loops, no vertex uphill.
//!
//! # Layers
//! Changes `height` (m); writes `water` (m), `lake_level` (m), `discharge` (m3/s), `river` (1) and, with springs in a band,
//! `river_passes` (1). Keeps the components `rivers` (lines), `lakes` (polygons) and `waterfalls` (points).
//!
//! # Conserves
//! What fills small depressions and what beds are dug from is in the ledger (`ground.silted`, `ground.carved`;
//! `tests/it/rivers.rs`).

use crate::bed::{self, Piece};
use crate::course::{Course, course};
use crate::lakes::{self, Balance, Lakes, Least};
use crate::meander::meander;
use crate::network::{End, Network, Reach, trace};
use crate::runoff::{Climate, evaporation_of};
use crate::{DISCHARGE, LAKE_LEVEL, LAKES, RIVER, RIVER_PASSES, RIVERS, WATERFALLS, shores};
use eyot_core::component::{Features, Form, Points, Shape, Type};
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
            bed: Bed::Hydraulic,
            pass_depth: 0.2,
            closed_rims: true,
        }
    }
}

/// Exponents of width and depth over discharge.
const WIDTH_EXPONENT: f64 = 0.5;
const DEPTH_EXPONENT: f64 = 0.3;
/// What makes a waterfall: fall (m), slope (1), water (m3/s).
const FALL: (f64, f64, f64) = (5.0, 0.5, 0.5);
/// Steeper rivers do not meander, 1.
const MEANDER_SLOPE: f64 = 0.005;
/// Ground that lies at most so far above or below a reach is its flood plain, m.
const PLAIN_M: f32 = 2.0;
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
        vec![(RIVERS, Shape::Features), (LAKES, Shape::Features), (WATERFALLS, Shape::Points)]
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
struct Section {
    width_m: f64,
    depth_m: f64,
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
        let floor = sea as f32;
        let surface: Vec<f32> = found.surface.iter().map(|z| z.max(floor)).collect();
        let seed = world.seed;
        let courses: Vec<Course> = network
            .reaches
            .par_iter()
            .map(|r| self.wandered(r, course(&r.cells, grid, &found.routing, &surface, seed), &found, grid))
            .collect();
        control.check()?;

        let ground: Vec<f32> =
            (0..height.len()).map(|i| if found.lake[i] > 0 { height[i] } else { found.surface[i] }).collect();
        let passes = self.counts_passes().then(|| passes(&found, &springs)).transpose()?;
        let pieces = self.pieces(&network, &courses, &found, passes.as_deref(), grid);
        let beds = bed::dig(&ground, grid, &pieces, self.bed != Bed::None, |i| f64::from(ground[i]) <= sea);
        self.keep(world, grid, &found, &network, &courses, &beds.ground)?;
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
        put(world, &WATER, water)?;
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

    /// The course of a reach that meanders, if it runs slowly enough through a plain that is wide enough.
    fn wandered(&self, reach: &Reach, course: Course, found: &Lakes, grid: &Grid) -> Course {
        let width = self.section(reach.discharge).width_m;
        let (first, last) = (course.line[0], course.line[course.line.len() - 1]);
        let (length, fall) = (length_m(&course.line), f64::from(first[2]) - f64::from(last[2]));
        let cell_m = grid.cell_x_m.min(grid.cell_y_m);
        let slow = fall <= MEANDER_SLOPE * length && length >= 20.0 * width && width >= 0.25 * cell_m;
        if self.sinuosity <= 1.0 || reach.lake > 0 || !slow {
            return course;
        }
        let plain = |p: [f64; 2]| {
            let (x, y) = ((p[0] / grid.cell_x_m).floor(), (p[1] / grid.cell_y_m).floor());
            if x < 0.0 || y < 0.0 || x >= grid.width as f64 || y >= grid.height as f64 {
                return false;
            }
            let i = y as usize * grid.width + x as usize;
            found.lake[i] == 0 && (last[2] - PLAIN_M..=first[2] + PLAIN_M).contains(&found.surface[i])
        };
        let line: Vec<[f64; 2]> = course.line.iter().map(|v| [f64::from(v[0]), f64::from(v[1])]).collect();
        // Half of five widths to each side, by the axes.
        let wide = |p: &&[f64; 2]| {
            let off = 2.5 * width;
            [[off, 0.0], [-off, 0.0], [0.0, off], [0.0, -off]].iter().all(|d| plain([p[0] + d[0], p[1] + d[1]]))
        };
        if 2 * line.iter().filter(wide).count() < line.len() {
            return course;
        }
        let wound = meander(&line, width, f64::from(self.sinuosity), plain).line;
        // Heights fall evenly along the longer way.
        let parts = (wound.len() - 1) as f64;
        let place = |k: usize| (k as f64 / parts * (reach.cells.len() - 1) as f64) as f32;
        let height = |k: usize| {
            let at = course.place.partition_point(|p| *p < place(k)).min(course.line.len() - 1);
            course.line[at][2]
        };
        let mut found = Course::default();
        for (k, p) in wound.iter().enumerate() {
            let end = if k == 0 { Some(first) } else { (k + 1 == wound.len()).then_some(last) };
            found.line.push(end.unwrap_or([p[0] as f32, p[1] as f32, height(k)]));
            found.place.push(place(k));
        }
        found
    }

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
                let mut section = self.section(found.discharge[cell]);
                if let (Bed::Passes, Some(passes)) = (self.bed, passes) {
                    section.depth_m = f64::from(self.pass_depth) * f64::from(passes[cell]);
                    section.width_m = section.width_m.max(grid.cell_x_m.max(grid.cell_y_m));
                }
                Piece { ends: [ends[0], ends[1]], width_m: section.width_m, depth_m: section.depth_m }
            };
            if reach.lake > 0 {
                return Vec::new();
            }
            course.line.windows(2).zip(course.place.windows(2)).map(cut).collect()
        };
        let each: Vec<Vec<Piece>> = network.reaches.par_iter().zip(courses).map(pieces).collect();
        each.concat()
    }

    /// Keeps rivers, lakes and waterfalls with the world.
    fn keep(
        &self,
        world: &mut World,
        grid: &Grid,
        found: &Lakes,
        network: &Network,
        courses: &[Course],
        ground: &[f32],
    ) -> Result<()> {
        let reaches = &network.reaches;
        let length: Vec<f64> = courses.iter().map(|c| length_m(&c.line)).collect();
        let drained = found.routing.upstream_cells();
        let upwards = found.routing.longest_upstream_m();
        let mut down = vec![f64::NAN; reaches.len()];
        for k in 0..reaches.len() {
            let (mut way, mut at) = (vec![k], k);
            while let Some(next) = reaches[at].next.map(|n| n as usize).filter(|_| down[at].is_nan()) {
                way.push(next);
                at = next;
            }
            for at in way.into_iter().rev() {
                down[at] = reaches[at].next.map_or(0.0, |n| down[n as usize] + length[n as usize]);
            }
        }
        let mut rivers = Features::new(Form::Lines, RIVER_ATTRIBUTES);
        let mut falls =
            Points::new([("drop", "m", Type::F32), ("discharge", "m3/s", Type::F32), ("slope", "1", Type::F32)]);
        for (k, (reach, course)) in reaches.iter().zip(courses).enumerate() {
            let section = self.section(reach.discharge);
            let fall = f64::from(course.line[0][2]) - f64::from(course.line[course.line.len() - 1][2]);
            let last = reach.cells[reach.cells.len() - 2] as usize;
            let id = |r: u32| f64::from(r + 1);
            let end = match reach.end {
                End::Reach => 0.0,
                End::Sea => 1.0,
                End::Rim => 2.0,
                End::Lake => 3.0,
                End::Hollow => 4.0,
            };
            let row = [
                id(k as u32),
                reach.next.map_or(0.0, id),
                id(reach.mouth),
                length[k] / 1000.0,
                down[k] / 1000.0,
                upwards[last] / 1000.0,
                f64::from(drained[last]) * grid.cell_area_m2() / 1e6,
                reach.discharge,
                f64::from(reach.order),
                section.width_m,
                section.depth_m,
                if length[k] > 0.0 { fall / length[k] } else { 0.0 },
                f64::from(reach.lake),
                end,
            ];
            rivers.push(&[&course.line], &row)?;
            if reach.lake == 0 {
                waterfalls(reach, course, found, &mut falls)?;
            }
        }
        world.components.insert(RIVERS, rivers);
        world.components.insert(LAKES, lake_features(found, ground, grid)?);
        world.components.insert(WATERFALLS, falls);
        Ok(())
    }
}

/// What is said of a reach; the names are those of HydroRIVERS where it has them.
const RIVER_ATTRIBUTES: [(&str, &str, Type); 14] = [
    ("HYRIV_ID", "1", Type::U32),
    ("NEXT_DOWN", "1", Type::U32),
    ("MAIN_RIV", "1", Type::U32),
    ("LENGTH_KM", "km", Type::F64),
    ("DIST_DN_KM", "km", Type::F64),
    ("DIST_UP_KM", "km", Type::F64),
    ("UPLAND_SKM", "km2", Type::F64),
    ("DIS_AV_CMS", "m3/s", Type::F64),
    ("ORD_STRA", "1", Type::U8),
    ("WIDTH_M", "m", Type::F64),
    ("DEPTH_M", "m", Type::F64),
    ("SLOPE", "1", Type::F64),
    ("LAKE_ID", "1", Type::U32),
    ("END", "1", Type::U8),
];

/// Length of a line, m.
fn length_m(line: &[[f32; 3]]) -> f64 {
    let step = |pair: &[[f32; 3]]| {
        let (dx, dy) = (f64::from(pair[1][0] - pair[0][0]), f64::from(pair[1][1] - pair[0][1]));
        (dx * dx + dy * dy).sqrt()
    };
    line.windows(2).map(step).sum()
}

/// The steps of a reach over which water falls.
fn waterfalls(reach: &Reach, course: &Course, found: &Lakes, falls: &mut Points) -> Result<()> {
    for (k, pair) in reach.cells.windows(2).enumerate() {
        let (above, below) = (pair[0] as usize, pair[1] as usize);
        let drop = f64::from(found.surface[above]) - f64::from(found.surface[below]);
        let (slope, discharge) = (drop / found.routing.distance_m(above), found.discharge[above]);
        if drop > FALL.0 && slope > FALL.1 && discharge > FALL.2 {
            let at = course.place.partition_point(|p| (*p as usize) < k);
            falls.push(course.line[at], &[drop, discharge, slope])?;
        }
    }
    Ok(())
}

/// The lakes as polygons.
fn lake_features(found: &Lakes, ground: &[f32], grid: &Grid) -> Result<Features> {
    let mut features = Features::new(
        Form::Polygons,
        [
            ("LAKE_ID", "1", Type::U32),
            ("LEVEL_M", "m", Type::F32),
            ("AREA_SKM", "km2", Type::F64),
            ("VOLUME_M3", "m3", Type::F64),
            ("DEPTH_AVG", "m", Type::F64),
            ("DEPTH_MAX", "m", Type::F64),
            ("SHORE_KM", "km", Type::F64),
            ("INFLOW_CMS", "m3/s", Type::F64),
            ("OUTFLOW_CMS", "m3/s", Type::F64),
            ("RES_TIME_Y", "a", Type::F64),
            ("OUTLET_X", "m", Type::F64),
            ("OUTLET_Y", "m", Type::F64),
        ],
    );
    for (id, rings) in shores::shores(found, ground, grid).into_iter().enumerate().skip(1) {
        let lake = found.lakes[id];
        let parts: Vec<&[[f32; 3]]> = rings.iter().map(Vec::as_slice).collect();
        let area_m2 = f64::from(lake.cells) * grid.cell_area_m2();
        let place = |i: u32| {
            let (x, y) = (i as usize % grid.width, i as usize / grid.width);
            [(x as f64 + 0.5) * grid.cell_x_m, (y as f64 + 0.5) * grid.cell_y_m]
        };
        let outlet = lake.outlet.map_or([f64::NAN; 2], place);
        let row = [
            id as f64,
            f64::from(lake.level),
            area_m2 / 1e6,
            lake.volume_m3,
            lake.volume_m3 / area_m2,
            lake.max_depth_m,
            shores::length_m(&rings) / 1000.0,
            lake.inflow,
            lake.outflow,
            if lake.inflow > 0.0 { lake.volume_m3 / lake.inflow / SECONDS_PER_YEAR } else { f64::NAN },
            outlet[0],
            outlet[1],
        ];
        if !parts.is_empty() {
            features.push(&parts, &row)?;
        }
    }
    Ok(features)
}
