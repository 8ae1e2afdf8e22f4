//! Wetness: a bounded memory of where rivers ran, for colours.
//!
//! # Equations
//! 1. `w' = w + (min(1, q / river) - w) / memory` with `q` the discharge through the cell over its width, m2/s.
//!
//! # Source
//! Ours: an exponential memory, so that rock shows where rivers recently ran.
//!
//! # Layers
//! Reads `flux_x`, `flux_y`, `flux_se`, `flux_sw` (m/s); reads and writes `wetness` (1).
//!
//! # Differences
//! It reads the fluxes of the signed forms; where hydraulic erosion runs in the classic form there are none, and nothing
//! gets wet.
//!
//! # Limits
//! Always within 0..=1.

use super::hydraulic::{FLUX_SE, FLUX_SW, FLUX_X, FLUX_Y};
use eyot_core::given::Given;
use eyot_core::layer::known::WETNESS;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::{given, rule_params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Remembers where rivers ran, for colours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Wetness {
    /// Discharge per metre of width that counts as a river.
    #[schemars(range(min = 0.000001, max = 10000.0), extend("unit" = "m2/s"))]
    pub river: f32,
    /// Turns after which two thirds of the past are forgotten.
    #[schemars(range(min = 1.0, max = 1000000.0), extend("unit" = "turns"))]
    pub memory: f32,
}

impl Default for Wetness {
    fn default() -> Self {
        Self { river: 10.0, memory: 20.0 }
    }
}

impl Process for Wetness {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers: Vec<LayerUse> = [FLUX_X, FLUX_Y, FLUX_SE, FLUX_SW].map(|f| f.read(0.0)).into();
        layers.push(WETNESS.changed(0.0));
        layers
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        plan.push_given::<Remember>(RememberParams {
            half_dx: (0.5 * moment.grid.cell_x_m as f32).into(),
            half_dy: (0.5 * moment.grid.cell_y_m as f32).into(),
            per_river: 1.0 / given!(plan, self.river),
            share: 1.0 / given!(plan, self.memory).max(Given::of(1.0)),
        });
    }
}

rule_params! {
    /// Parameters of [`Remember`].
    pub struct RememberParams {
        /// Half the cell's east-west size, m.
        half_dx,
        /// Half the cell's north-south size, m.
        half_dy,
        /// `1 / river`, s/m2.
        per_river,
        /// `1 / memory`, 1.
        share,
    }
}

/// Equation (1).
pub struct Remember;

impl Rule for Remember {
    const NAME: &'static str = "wetness_remember";
    const READS: &'static [Read] =
        &[read("flux_x", 1), read("flux_y", 1), read("flux_se", 1), read("flux_sw", 1), read("wetness", 0)];
    const WRITES: &'static [&'static str] = &["wetness"];
    type Params = RememberParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &RememberParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let (falling, rising) = (c.at(2, -1, -1) + c.here(2), c.at(3, 1, -1) + c.here(3));
        let qx = p.half_dx * ((c.at(0, -1, 0) + c.here(0)) + (falling - rising));
        let qy = p.half_dy * ((c.at(1, 0, -1) + c.here(1)) + (falling + rising));
        let now = ((qx * qx + qy * qy).sqrt() * p.per_river).min(R::of(1.0));
        let w = c.here(4);
        ([(w + p.share * (now - w)).flushed()], [])
    }
}
