//! What can be chosen; everything may change between two steps.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How plates are made, how they move, and what happens where they meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Tectonics {
    /// Share of the world above the sea. Kept by the level of the sea: see Equations.
    #[schemars(range(min = 0.02, max = 0.9), extend("unit" = "1"))]
    pub land: f32,
    /// Plates at the beginning of a cycle.
    #[schemars(range(min = 2, max = 60), extend("unit" = "1"))]
    pub count: u32,
    /// Time that passes in a step. A plate may cross 32 cells in a step at most.
    #[schemars(range(min = 100.0, max = 10000000.0), extend("unit" = "yr"))]
    pub years_per_step: f32,
    /// Usual speed of a plate that nothing holds; Earth's have 0.01 to 0.1.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "m/yr"))]
    pub speed: f32,
    /// How fast plates turn their heading at most, each to its own side.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "degree/Myr"))]
    pub turning: f32,
    /// How far the first continents are gathered around the middle of the world: 0 spreads them, 1 makes one of them. For worlds
    /// that start from noise.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub gather: f32,
    /// At the beginning of a cycle, how much plates head away from those with which they share a continent, and from where the
    /// continents are gathered: 0 anywhere, 1 straight away.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub breakup: f32,
    /// How much sinking slabs pull their plate along.
    #[schemars(range(min = 0.0, max = 3.0), extend("unit" = "1"))]
    pub slab_pull: f32,
    /// How much colliding continents brake each other. 0 lets them plough on.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "1"))]
    pub friction: f32,
    /// Two continents that have been pushed over each other by more than this area grow together.
    #[schemars(range(min = 0.0, max = 1e9), extend("unit" = "km2"))]
    pub suture_area: f32,
    /// They also grow together once the area is a larger share of the smaller plate's continents than this.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    pub suture_share: f32,
    /// Half the width of the belt over which colliding continents fold: small makes high narrow ranges, large makes plateaus.
    #[schemars(range(min = 0.0, max = 3000000.0), extend("unit" = "m"))]
    pub fold_width: f32,
    /// Crust thicker than this flows apart, which limits mountains: 70 km carry about 5 km.
    #[schemars(range(min = 40000.0, max = 90000.0), extend("unit" = "m"))]
    pub max_crust: f32,
    /// Share of its crust that the edge of a continent gives to the gap when plates part: it makes shelves and slopes.
    #[schemars(range(min = 0.0, max = 0.45), extend("unit" = "1"))]
    pub stretch: f32,
    /// Share of the sunken crust that comes up again in volcanoes behind the trench.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub arcs: f32,
    /// Distance of the volcanoes from the trench.
    #[schemars(range(min = 0.0, max = 2000000.0), extend("unit" = "m"))]
    pub arc_distance: f32,
    /// Levelling of the land by rivers, as a diffusivity. 0 where other processes erode. Too much wears mountains down.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m2/yr"))]
    pub erosion: f32,
    /// How fast rivers lower land of 1000 m and carry it to the edges of the shelves; it grows with the cube of the height. 0 where
    /// other processes erode.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m/Myr"))]
    pub denudation: f32,
    /// Levelling between land and sea by waves, which takes the lowest 200 m of narrow islands first.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m2/yr"))]
    pub coast: f32,
    /// Length of a cycle, after which new plates are made from the crust that is there. 0 is without end.
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "Myr"))]
    pub cycle: f32,
    /// Cycles before the plates come to rest. 0 is without end.
    #[schemars(range(min = 0, max = 100000), extend("unit" = "1"))]
    pub cycles: u32,
    /// A cycle also ends when plates move slower than this share of their usual speed on average.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub stall: f32,
    /// Raise it while the world runs to begin a new cycle at once.
    #[schemars(range(min = 0, max = 1000000), extend("unit" = "1"))]
    pub restarts: u32,
}

impl Default for Tectonics {
    fn default() -> Self {
        Self {
            land: 0.3,
            count: 10,
            years_per_step: 1e6,
            speed: 0.05,
            turning: 0.3,
            gather: 0.0,
            breakup: 0.5,
            slab_pull: 0.6,
            friction: 3.0,
            suture_area: 1e6,
            suture_share: 0.15,
            fold_width: 350_000.0,
            max_crust: 70_000.0,
            stretch: 0.3,
            arcs: 0.15,
            arc_distance: 250_000.0,
            erosion: 30.0,
            denudation: 0.6,
            coast: 30.0,
            cycle: 300.0,
            cycles: 0,
            stall: 0.15,
            restarts: 0,
        }
    }
}

impl Tectonics {
    /// Time of a step, Myr.
    pub(crate) fn myr_per_step(&self) -> f64 {
        f64::from(self.years_per_step) * 1e-6
    }

    /// The fastest that a plate may become, m/yr.
    pub(crate) fn top_speed(&self) -> f64 {
        2.0 * f64::from(self.speed)
    }
}
