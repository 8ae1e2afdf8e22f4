//! Where a world came from, in the words of the files of research.

use crate::zarr::SECONDS;
use eyot_core::World;
use serde_json::{Map, Value, json};

/// What is known of a world's origin beside the world itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin<'a> {
    /// What the landscape is called.
    pub name: &'a str,
    /// The recipe's text.
    pub recipe: Option<&'a str>,
    /// Seconds of a step of simulation, if steps have a length in time.
    pub seconds_per_step: Option<f64>,
    /// Engines that simulated, in order: `cpu`, or `gpu` with the adapter's name. Generators run on the processor.
    pub engines: &'a [String],
}

impl Origin<'_> {
    /// Attributes for the root of a store.
    pub fn attributes(&self, world: &World) -> Map<String, Value> {
        let version = env!("CARGO_PKG_VERSION");
        let backend = if self.engines.is_empty() { "cpu".to_owned() } else { self.engines.join(", ") };
        let mut m = Map::new();
        m.insert("title".to_owned(), json!(self.name));
        m.insert("source".to_owned(), json!(format!("Eyot {version}")));
        m.insert("engine_version".to_owned(), json!(version));
        m.insert("backend".to_owned(), json!(backend));
        m.insert("seed".to_owned(), json!(world.seed));
        m.insert("steps_done".to_owned(), json!(world.step));
        m.insert("sea_level_m".to_owned(), json!(world.sea_level_m));
        m.extend(self.seconds_per_step.map(|seconds| (SECONDS.to_owned(), json!(seconds))));
        m.extend(self.recipe.map(|recipe| ("recipe".to_owned(), json!(recipe))));
        m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};

    #[test]
    fn the_backend_is_what_simulated() {
        let grid = Grid::new(2, 2, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let world = World::new(grid, 7);
        let backend = |engines: &[&str]| {
            let engines: Vec<String> = engines.iter().map(|e| (*e).to_owned()).collect();
            Origin { engines: &engines, ..Origin::default() }.attributes(&world)["backend"].clone()
        };
        assert_eq!(backend(&[]), "cpu");
        assert_eq!(backend(&["gpu (llvmpipe)"]), "gpu (llvmpipe)");
        assert_eq!(backend(&["cpu", "gpu (llvmpipe)"]), "cpu, gpu (llvmpipe)");
    }
}
