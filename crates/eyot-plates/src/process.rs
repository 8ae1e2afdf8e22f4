//! Plates that drift over the world: oceans open at ridges and close at trenches, and continents break apart and fold into ranges.
//!
//! Between its steps other processes may shape the land; what they did moves on with the plate. Run it in every n-th step (`every`): a
//! million years are long for rivers. The world does not wait: each step begins when the one before it has been shown, on threads of its
//! own, and what others did in the meantime is added to it, where the plate has carried it.
//!
//! # Equations
//! 1. Plates: `dv/dt = (speed (heading + slab_pull pull) - v) / 20 Myr`. Each shifts by the whole cells in its way and keeps the rest.
//! 2. Gaps get crust of 7 km and age 0, and from the edge of a continent `stretch` of its crust.
//! 3. Where two meet, oceanic crust (below 20 km) sinks; `arcs` of it comes up `arc_distance` further, as volcanoes, and what is scraped
//!    off it folds into the upper plate's continent. Slabs that slide along a border feed no volcanoes. Of two continental cells the
//!    crust of one folds into a belt of `fold_width` to either side, and both plates are braked:
//!    `v_a += friction n sqrt((a + b) / (a b)) (v_b - v_a) b / (a + b)`, with `n` cells of front and areas of `a` and `b` cells.
//! 4. Two plates whose continents lost `suture_area`, or `suture_share` of the smaller ones, grow together there.
//! 5. Rivers and waves: on each face `q = dt / cell^2 (erosion (p_a - p_b) + coast (s_a - s_b)) / A`, `p = max(height, 0)`, and `s` the
//!    height from -100 to 200 m where one is sea. `dh/dt = -denudation (p / 1 km)^3`, carried to the edges of the plate's shelves
//!    (-130 m).
//! 6. Heights: `dry = A crust + w theta(age) - level`, with `A = 1 - 2800 / 3300`; below the sea 1.45 times that. `theta` makes ocean
//!    floor sink by `350 sqrt(age)` to 70 Myr and towards 6400 m beyond; `w` ends it at 35 km of crust.
//! 7. `level` moves to where the heights around the coast give the share of land that is aimed at, up to 25 m a step, and at once where
//!    that would be 2 points off; the aim follows `land` by half a point a step.
//! 8. After `cycle`, when plates have come to a halt, or when one has 70 % of the world, new plates are made from the crust that is there
//!    (numbered, grown from seeds at different speeds, with borders frayed by noise), and set off away from where the continents are.
//!
//! # Source
//! The course of a step follows Viitanen (2012). Crust floats by Airy (1855), the ocean floor sinks by Parsons and Sclater (1977), new
//! crust is as thick as White, McKenzie and O'Nions (1992) found it. Land is worn down the faster the higher it stands, more than in
//! proportion (Ahnert 1970; Montgomery and Brandon 2002). Plates grow by Dijkstra (1959), noise is Perlin's (2002).
//!
//! # Differences
//! - Overlaps are counted for a whole cycle, so that an area can be their limit: within a step it never is.
//! - One crust a cell, in whole units of 1/128 m: no mass gets lost or negative (`crust_is_accounted_for`).
//! - Who overrides whom is decided for the border of a pair of plates, not for each cell: no combs.
//! - Plates work beside the world and not within its step, and that changes no byte (`a_step_made_ahead_is_the_step`).
//! - Land has the asked share all the time (`land_keeps_its_share`); the source lost a third of it.
//! - Heights are metres and depend on thickness and age; the source shows thickness, with a bonus for the youngest.
//! - The noise of the start repeats nowhere (`the_start_does_not_repeat`). Erosion has no noise and only moves crust.
//! - Borders may be closed: crust sinks or folds there, and continents that touch them slide along.
//!
//! # Layers
//! Reads and writes `height` (m), `plate`, `crust` (m) and `crust_age` (Myr). On a flat world it makes continents of its own; any other
//! land gets the crust that carries it. What others add to the height becomes crust with the root that belongs to it, seven metres for
//! one, so that the height stays.
//!
//! # Limits
//! Plates shift and do not rotate. A plate crosses at most 32 cells in a step, and rivers take 64 passes at most; recipes beyond are
//! refused. Crust that is thicker than 1.1 `max_crust` after it flowed sinks. There can be 100 plates. Over open rims continents leave
//! for good, and then no level keeps the share of land.
//!
//! # Conserves
//! Crust, exactly: start, ridges, arcs and deposits make it, subduction, delamination, removal and open rims take it (`crust.*` in the
//! ledger; `crust_is_accounted_for`).

use crate::analyse::{Report, hypsometry};
use crate::crust::metres;
use crate::geometry::rows_at_once;
use crate::lookahead::{Lookahead, Made};
use crate::parameters::Tectonics;
use crate::plates::{Plates, check};
use crate::start::Start;
use crate::store::PlateState;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{
    Action, ActionInstance, Entry, LayerUse, Locality, Moment, Process, SECONDS_PER_YEAR, defaults_of, parameters_from,
    schema_of,
};
use eyot_core::{Control, Grid, LayerSpec, Result, World, about};
use rayon::prelude::*;

/// The plate that owns a cell.
pub const PLATE: LayerSpec = LayerSpec::new("plate", "1", "Number of the plate that owns this cell", (0.0, 254.0));
/// Thickness of the crust.
pub const CRUST: LayerSpec = LayerSpec::new("crust", "m", "Thickness of the crust", (0.0, 100_000.0));
/// Age of the crust.
pub const CRUST_AGE: LayerSpec = LayerSpec::new("crust_age", "Myr", "Age of the crust", (0.0, 1e6));

/// Name of the component of all plates in a world, a [`PlateState`].
pub const STATE: &str = "plates";

/// All processes of this crate.
pub const PROCESSES: &[Entry<dyn Process>] = &[Entry {
    name: "plates",
    schema: schema_of::<Tectonics>,
    defaults: defaults_of::<Tectonics>,
    make: |table| Ok(Box::new(Drift::new(parameters_from(table)?))),
    about: about!("process.rs"),
    cites: &[
        "ahnert1970",
        "airy1855",
        "dijkstra1959",
        "montgomery2002",
        "parsons1977",
        "perlin2002",
        "viitanen2012",
        "white1992",
    ],
}];

/// Plates as a process of a world.
pub struct Drift {
    parameters: Tectonics,
}

impl Drift {
    /// Plates with these parameters.
    pub fn new(parameters: Tectonics) -> Self {
        Self { parameters }
    }
}

impl Process for Drift {
    fn layers(&self) -> Vec<LayerUse> {
        vec![HEIGHT.changed(0.0), PLATE.changed(0.0), CRUST.changed(0.0), CRUST_AGE.changed(0.0)]
    }

    fn makes_ground(&self) -> bool {
        true
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        check(&self.parameters, grid)
    }

    /// Makes crust and plates: under the land that is there, or, where it is flat, continents and oceans from noise.
    fn prepare(&self, world: &mut World) -> Result<()> {
        if world.components.get::<PlateState>(STATE)?.is_none() {
            let sea = world.sea_level_m as f32;
            let height: Vec<f32> = world.layer("height")?.field.iter().map(|h| h - sea).collect();
            let flat = height.iter().all(|&h| h == height[0]);
            let start = if flat { Start::Noise } else { Start::Height(&height) };
            let plates = Plates::new(&world.grid, world.seed, self.parameters.clone(), start)?;
            plates.publish(world, sea, flat)?;
            plates.budget().post(&mut world.ledger, world.grid.cell_area_m2());
        }
        Ok(())
    }

    fn seconds_per_step(&self, _grid: &Grid) -> Option<f64> {
        Some(f64::from(self.parameters.years_per_step) * SECONDS_PER_YEAR)
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Drift {
    /// Begins the first step.
    fn instantiate(&self, world: &World) -> Result<Box<dyn ActionInstance>> {
        let mut drifting = Drifting { parameters: self.parameters.clone(), ahead: Lookahead::default(), last: NEVER };
        if let Some((plates, state)) = of_world(world, self.parameters.clone())? {
            drifting.ahead.begin(&world.grid, state.clone(), plates, true);
        }
        Ok(Box::new(drifting))
    }

    fn cannot_fail(&self) -> bool {
        true
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        58
    }
}

/// Plates in a simulation.
struct Drifting {
    parameters: Tectonics,
    /// The step to come.
    ahead: Lookahead,
    /// The world's step of the last turn; `NEVER` before the first.
    last: u64,
}

const NEVER: u64 = u64::MAX;

impl ActionInstance for Drifting {
    fn act(&mut self, moment: &Moment, world: &mut World, _control: &Control<'_>) -> Result<()> {
        let made = match self.ahead.take(world) {
            Some(made) => made,
            None => {
                let Some((plates, state)) = of_world(world, self.parameters.clone())? else { return Ok(()) };
                Made::new(&world.grid, state.clone(), plates)
            }
        };
        let sea = made.before.state.sea_level_m as f32;
        let Made { mut plates, before } = made;
        let own = *plates.budget();
        plates.add_changes(&before, &world.layer("height")?.field, sea);
        // Nobody does anything in the meantime, so there is nothing to be done beside.
        let last = std::mem::replace(&mut self.last, moment.step);
        let alone = *plates.budget() == own && last.wrapping_add(1) == moment.step;
        let mut budget = *plates.budget();
        budget.start = 0;
        budget.post(&mut world.ledger, moment.grid.cell_area_m2());
        plates.publish(world, sea, true)?;
        self.ahead.begin(&world.grid, plates.state(f64::from(sea)), plates, !alone);
        Ok(())
    }
}

/// The plates of a world, and what it keeps of them beside layers; `None` if it has none.
fn of_world(world: &World, parameters: Tectonics) -> Result<Option<(Plates, &PlateState)>> {
    let Some(state) = world.components.get::<PlateState>(STATE)? else { return Ok(None) };
    let layer = |spec: &LayerSpec| Ok::<_, eyot_core::Error>(world.layer(&spec.name)?.field.iter());
    let maps = (layer(&PLATE)?, layer(&CRUST)?, layer(&CRUST_AGE)?);
    Ok(Some((Plates::of_state(&world.grid, world.seed, parameters, state, maps)?, state)))
}

/// What there is to say about the plates of a world; `None` if it has none.
///
/// # Errors
/// If layers that plates need are missing or do not fit.
pub fn report(world: &World) -> Result<Option<Report>> {
    let Some((plates, state)) = of_world(world, Tectonics::default())? else { return Ok(None) };
    let sea = state.sea_level_m as f32;
    let (cycle, steps) = plates.cycle_and_steps();
    let hypsometry = hypsometry(world.layer("height")?.field.iter().map(|h| h - sea));
    Ok(Some(Report { cycle, steps, plates: plates.list(), hypsometry }))
}

impl Plates {
    /// Writes layers and state; the height only if `with_height`.
    fn publish(&self, world: &mut World, sea: f32, with_height: bool) -> Result<()> {
        let mut put = |spec: &LayerSpec, row_of: &(dyn Fn(std::ops::Range<usize>, &mut [f32]) + Sync)| -> Result<()> {
            let width = self.g.width;
            let rows: Vec<&mut [f32]> = world.layer_mut(&spec.name)?.field.rows_mut().collect();
            let rows = rows.into_par_iter().enumerate().with_min_len(rows_at_once(width));
            rows.for_each(|(y, row)| row_of(y * width..(y + 1) * width, row));
            Ok(())
        };
        put(&PLATE, &|cells, row| row.iter_mut().zip(&self.maps.owner[cells]).for_each(|(v, &o)| *v = f32::from(o)))?;
        put(&CRUST, &|cells, row| row.iter_mut().zip(&self.maps.crust[cells]).for_each(|(v, &c)| *v = metres(c)))?;
        put(&CRUST_AGE, &|cells, row| row.copy_from_slice(&self.maps.age[cells]))?;
        if with_height {
            put(&HEIGHT, &|cells, row| row.iter_mut().zip(&self.height[cells]).for_each(|(v, &h)| *v = h + sea))?;
        }
        world.components.insert(STATE, self.state(f64::from(sea)));
        Ok(())
    }
}
