//! What clients of a run see: its world as the scene of a stream.

use super::ServeOptions;
use crate::{Alga, Colony, Hello, LayerInfo, Moment, Permission, Raster, Scene, Server, SpeciesInfo};
use eyot_core::component::Table;
use eyot_core::process::parameters_from;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Cancel, Centering, Limits, World};
use eyot_recipe::{Recipe, Work, layers};
use eyot_reef::bodies::Shape;
use eyot_reef::community::{Form, Population, RAYS};
use eyot_reef::corals::{CORALS, Corals, POPULATION};
use eyot_session::{Look, RunError, Watch};
use std::sync::Arc;
use std::time::{Duration, Instant};

// The protocol's colonies are those of the reef.
const _: () = assert!(RAYS == crate::RAYS);

/// A run that waits for its pace looks so often whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);
/// Copies of a layer that are held: the state before, the one that is compared with it, its frames, one that waits, and the next.
const COPIES: u128 = 5;

/// Looks at the world and publishes it.
pub(super) struct Stage {
    server: Arc<Server>,
    options: ServeOptions,
    corals: Option<Corals>,
    /// When the next moment may come.
    next: Option<Instant>,
}

impl Stage {
    pub(super) fn new(server: Arc<Server>, options: ServeOptions) -> Self {
        Self { server, options, corals: None, next: None }
    }

    fn scene(&self, look: &Look<'_>) -> Result<Scene, Remedy> {
        let world = look.world;
        let mut scene = Scene {
            moment: Moment {
                steps_done: world.step,
                recipe_step: look.recipe_step as u32,
                step: [look.step, look.total],
                temperature_c: f32::NAN,
                sea_level_m: world.sea_level_m as f32,
                ..Moment::default()
            },
            layers: self.options.layers.iter().map(|name| raster(world, name)).collect(),
            ..Scene::default()
        };
        // Before their first month there is nobody.
        let population = world.components.get::<Population>(POPULATION)?;
        if let (Some(corals), Some(population)) = (&self.corals, population) {
            let census = corals.census(world)?;
            add_reef(&mut scene, corals, population, &census, self.options.rays);
        }
        Ok(scene)
    }

    /// Waits until the next moment may come.
    fn pace(&mut self, steps: u64, cancel: &Cancel) {
        let Some(rate) = self.options.rate else { return };
        let now = Instant::now();
        let due = self.next.unwrap_or(now);
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|d| !d.is_zero()) {
            if cancel.is_raised() {
                return;
            }
            std::thread::sleep(left.min(LOOK));
        }
        // What was late is not made up for by hurry.
        let span = Duration::try_from_secs_f64(steps as f64 / rate).unwrap_or(Duration::MAX);
        self.next = due.max(now).checked_add(span);
    }
}

impl Watch for Stage {
    fn every(&self) -> u64 {
        self.options.every
    }

    fn begin(&mut self, recipe: &Recipe, limits: &Limits) -> Result<(), RunError> {
        let hello = hello(recipe, &self.options, limits)?;
        self.corals = corals(recipe);
        self.server.hello(hello);
        Ok(())
    }

    fn look(&mut self, look: &Look<'_>) -> Result<(), Remedy> {
        let unseen = |e| remedy![format!("clients do not see step {}: ", look.world.step), e];
        let scene = self.scene(look).map_err(unseen)?;
        // Generators have no pace.
        if look.total > 1 {
            self.pace(self.options.every, look.cancel);
        }
        self.server.publish(scene);
        Ok(())
    }
}

/// The corals of a recipe, as its last step has them.
fn corals(recipe: &Recipe) -> Option<Corals> {
    parameters_from(recipe.last_use(CORALS.name)?.parameters.clone()).ok()
}

/// What a stream of this recipe is about.
///
/// # Errors
/// If it makes no such layers, or they do not fit into memory.
pub(super) fn hello(recipe: &Recipe, options: &ServeOptions, limits: &Limits) -> Result<Hello, RunError> {
    let corals = corals(recipe);
    let grid = &recipe.grid;
    let made = made(recipe);
    let mut infos = Vec::new();
    for (i, name) in options.layers.iter().enumerate() {
        if options.layers[..i].contains(name) {
            return Err(RunError::input(format!("the layer `{name}` is to be sent twice")));
        }
        if !made.contains(name) {
            return Err(RunError::input(format!("no step makes a layer `{name}`; there is: {}", made.join(", "))));
        }
        let spec = layers::spec(name, "", &recipe.steps);
        infos.push(LayerInfo {
            name: name.clone(),
            unit: spec.unit.into_owned(),
            range: [spec.range.0, spec.range.1],
            stagger: match spec.centering {
                Centering::Cell => 0,
                Centering::FaceX => 1,
                Centering::FaceY => 2,
            },
        });
    }
    let bytes = 4 * grid.cells() as u128 * COPIES * infos.len() as u128;
    limits
        .check_bytes("copies of these layers for clients", bytes)
        .map_err(|e| RunError::refused(e, remedy!["send fewer layers, or raise ", Setting::MaxMemory]))?;
    let species = corals.iter().flat_map(|c| &c.community.species).map(|s| SpeciesInfo {
        name: s.name.clone(),
        form: match s.form {
            Form::Massive => 0,
            Form::Branching => 1,
        },
        shape: match s.body.shape {
            Shape::Massive => 0,
            Shape::Branching => 1,
            Shape::Columnar => 2,
            Shape::Encrusting => 3,
            Shape::Foliaceous => 4,
            Shape::Laminar => 5,
            Shape::FreeLiving => 6,
        },
        colour: s.colour,
    });
    let columns = corals.as_ref().map_or_else(Vec::new, Corals::census_columns);
    Ok(Hello {
        seed: recipe.seed,
        size: [grid.width as u32, grid.height as u32],
        cell_m: [grid.cell_x_m, grid.cell_y_m],
        sea_level_m: recipe.sea_level_m,
        every: options.every.max(1),
        rays: options.rays && corals.is_some(),
        // It differs from client to client; the server fills it in.
        may: Permission::Watch,
        engine: eyot_session::VERSION.to_owned(),
        recipe: recipe.name.clone(),
        species: species.collect(),
        layers: infos,
        columns: columns.into_iter().map(|c| c.name).collect(),
    })
}

/// Names of all layers that the recipe's steps make.
fn made(recipe: &Recipe) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for step in recipe.enabled_steps() {
        let of_step = match &step.work {
            Work::Generate(g) => vec![g.layer.clone()],
            Work::Simulate(s) => {
                let processes = s.processes.iter().filter(|u| u.enabled).filter_map(|u| u.make().ok());
                processes.flat_map(|p| p.layers()).map(|l| l.spec.name.into_owned()).collect()
            }
        };
        for name in of_step {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

fn raster(world: &World, name: &str) -> Option<Raster> {
    world.get(name).map(|f| Raster { width: f.width() as u32, values: f.to_vec() })
}

/// Everybody who lives on the reef, and the last row of its census.
fn add_reef(scene: &mut Scene, corals: &Corals, population: &Population, census: &Table, with_rays: bool) {
    let last = census.len().checked_sub(1);
    scene.moment.census = last.map_or_else(Vec::new, |last| census.row(last).collect());
    let month = scene.moment.census.first().map_or(0, |m| *m as i64 + 1);
    let settled = |age: u32| (month - i64::from(age)).clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    let temperature = census.get("temperature_c").zip(last).map(|(c, last)| c.values.number(last));
    scene.moment.temperature_c = temperature.map_or(f32::NAN, |t| t as f32);
    let height = |species: u8| corals.community.species.get(usize::from(species)).map_or(1.0, |s| s.body.height);
    scene.colonies = population
        .colonies()
        .iter()
        .zip(population.rays())
        .map(|(c, rays)| Colony {
            id: c.id,
            settled: settled(c.age),
            species: c.species.into(),
            bleached: c.is_bleached(),
            x: c.x,
            y: c.y,
            radius: c.radius,
            height: height(c.species) * c.radius,
            bleaching: c.bleaching,
            reach: rays.iter().copied().fold(0.0, f32::max),
            rays: if with_rays { *rays } else { [0.0; RAYS] },
        })
        .collect();
    let alga = |a: &eyot_reef::community::Alga| Alga {
        id: a.id,
        settled: settled(a.age),
        x: a.x,
        y: a.y,
        radius: a.radius,
        height: a.height,
    };
    scene.algae = population.algae().iter().map(alga).collect();
}
