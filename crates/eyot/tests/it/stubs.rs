//! A generator and a process for tests, so that the tests do not depend on what the land crate holds.

use eyot::{Limits, Overrides, Problems, Recipe, RecipeSource, Registry};
use eyot_core::plan::Plan;
use eyot_core::process::{Entry, Generator, Moment, Process, Site};
use eyot_core::{Field, Result, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number from the seed in every cell.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Noise {
    /// Largest value.
    #[schemars(range(min = 0.0, max = 5000.0), extend("unit" = "m"))]
    pub height: f32,
}

impl Default for Noise {
    fn default() -> Self {
        Self { height: 100.0 }
    }
}

impl Generator for Noise {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        site.control.check()?;
        let g = site.grid;
        Ok(Field::from_fn(g.width, g.height, |x, y| {
            let n = site.seed ^ ((x as u64) << 32 | y as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            self.height * ((n >> 40) as f32 / (1_u64 << 24) as f32)
        }))
    }
}

/// The negative of what is there.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Flip {}

impl Generator for Flip {
    fn generate(&self, _site: &Site<'_>, base: &Field) -> Result<Field> {
        let mut f = base.clone();
        f.map_in_place(|v| -v);
        Ok(f)
    }

    fn is_filter(&self) -> bool {
        true
    }
}

/// Rain that does nothing but be configured.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Hydraulic {
    /// Water that falls in a second.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/s"))]
    pub rain: f32,
    /// How water moves.
    pub scheme: Scheme,
}

/// A way for water to move.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Scheme {
    /// One signed flux an edge.
    #[default]
    Signed,
    /// Four fluxes a cell.
    Classic,
}

impl Default for Hydraulic {
    fn default() -> Self {
        Self { rain: 0.002, scheme: Scheme::Signed }
    }
}

impl Process for Hydraulic {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![eyot_core::layer::known::HEIGHT.changed(0.0), eyot_core::layer::known::WATER.changed(0.0)]
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        // Later than any rain: the layer shows with which parameter the run ended.
        world.layer_mut("water")?.field.map_in_place(|_| self.rain);
        Ok(())
    }

    fn plan(&self, _moment: &Moment, _plan: &mut Plan) {}
}

pub(crate) static GENERATORS: &[Entry<dyn Generator>] = &[
    Entry::<dyn Generator>::generator::<Noise>("noise", "", &["perlin1985"]),
    Entry::<dyn Generator>::generator::<Flip>("flip", "", &[]),
];
pub(crate) static PROCESSES: &[Entry<dyn Process>] =
    &[Entry::<dyn Process>::process::<Hydraulic>("hydraulic", "", &["mei2007"])];

pub(crate) fn registry() -> Registry {
    Registry::new(GENERATORS, PROCESSES)
}

pub(crate) fn source(text: &str) -> RecipeSource {
    RecipeSource { name: "test.toml".into(), text: text.into(), folder: ".".into() }
}

pub(crate) fn parse(text: &str, set: &[&str]) -> std::result::Result<Recipe, Problems> {
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    Recipe::parse(source(text), overrides, &registry(), &Limits::default())
}

pub(crate) const GOOD: &str = r#"
name = "Test"
seed = 5
sea_level = 10.0
[grid]
size = [16, 12]
cell = 5.0
[[step]]
name = "base"
generate = "noise"
height = 300.0
[[step]]
simulate = ["hydraulic"]
steps = 400
hydraulic.rain = 0.1
[[step]]
generate = "noise"
layer = "rough"
merge = "max"
[[export]]
format = "r32"
layers = ["height", "rough"]
"#;
