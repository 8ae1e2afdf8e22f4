//! Drainage of a land that changes: keeps lakes and drained areas up to date, and can do away with depressions.
//!
//! # Equations
//! 1. With `depressions = "fill"`, floors of depressions are raised to where they run over; with `"breach"`, trenches are cut
//!    from their bottoms to lower ground, as deep and long as allowed; with `"keep"` the land stays as it is.
//! 2. `lake` becomes the depth that would fill the depressions that are left, `drained_area` the area that drains through
//!    each cell once they are full.
//!
//! Water leaves over open rims and into the sea. Where neither is, the lowest cells are where it gathers. Let it run in every
//! n-th step only (`every`): drainage changes slowly.
//!
//! # Source
//! See `eyot_drainage`, which does the work.
//!
//! # Layers
//! Reads and writes `height` (m); writes `lake` (m) and `drained_area` (m2).
//!
//! # Conserves
//! What filling adds and breaching removes is in the ledger (`ground.filled`, `ground.breached`;
//! `tests/it/drainage_process.rs`).

use eyot_core::layer::known::{DRAINED_AREA, HEIGHT, LAKE};
use eyot_core::process::{Action, ActionInstance, LayerUse, Locality, Moment, Process};
use eyot_core::{Control, Field, Result, World};
use eyot_drainage::{BreachLimits, Land, RoutingRule, breach, fill};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What becomes of depressions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Depressions {
    /// They stay, as lakes.
    #[default]
    Keep,
    /// They are filled with ground.
    Fill,
    /// Trenches are cut out of them.
    Breach,
}

/// Keeps lakes and drained areas up to date, and can fill or breach depressions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Drainage {
    /// What becomes of depressions: keep them as lakes, fill them with ground, or breach their walls.
    pub depressions: Depressions,
    /// When breaching, no cell is lowered by more than this in a turn.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub max_depth: f32,
    /// When breaching, no trench is longer than this.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "m"))]
    pub max_length: f32,
    /// How water goes from cell to cell: to one neighbour (d8), to all lower ones (multiple), or straight down the slope, to one
    /// or two (dinf).
    pub routing: RoutingRule,
    /// With multiple routing, how much water prefers the steeper way: 1.1 suits cones, more gathers it in valleys.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1"))]
    pub exponent: f32,
    /// Water leaves over closed rims too, as from a map that was cut out of a larger one.
    pub closed_rims: bool,
}

impl Default for Drainage {
    fn default() -> Self {
        Self {
            depressions: Depressions::Keep,
            max_depth: 50.0,
            max_length: 2000.0,
            routing: RoutingRule::D8,
            exponent: 1.1,
            closed_rims: false,
        }
    }
}

impl Process for Drainage {
    fn layers(&self) -> Vec<LayerUse> {
        let keep = self.depressions == Depressions::Keep;
        let height = if keep { HEIGHT.read(0.0) } else { HEIGHT.changed(0.0) };
        vec![height, LAKE.written(0.0), DRAINED_AREA.written(0.0)]
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Drainage {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Whole
    }

    fn bytes_per_cell(&self) -> usize {
        34
    }
}

impl ActionInstance for Drainage {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        let grid = &moment.grid;
        if self.depressions != Depressions::Keep {
            let (mut height, outlets) = self.land(moment, &world.layer("height")?.field).heights_and_outlets()?;
            let limits =
                BreachLimits { max_depth_m: f64::from(self.max_depth), max_length_m: f64::from(self.max_length) };
            match self.depressions {
                Depressions::Breach => breach(&mut height, grid, &outlets, &limits, control)?,
                _ => fill(&mut height, grid, &outlets, control)?,
            }
            let field = &mut world.layer_mut("height")?.field;
            let moved = replace(field, &height) * grid.cell_area_m2();
            let (account, meaning, sign) = match self.depressions {
                Depressions::Breach => ("ground.breached", "Ground dug out of the walls of depressions", -1),
                _ => ("ground.filled", "Ground that depressions were filled with", 1),
            };
            world.ledger.add(account, moved.abs(), "m3", meaning, sign);
        }
        let height = &world.layer("height")?.field;
        let drained = self.land(moment, height).drain(self.routing, f64::from(self.exponent), control)?;
        let depth: Vec<f32> = drained.filled.iter().zip(height.iter()).map(|(f, h)| f - h).collect();
        let area: Vec<f32> = drained.area_m2.iter().map(|&a| a as f32).collect();
        replace(&mut world.layer_mut("lake")?.field, &depth);
        replace(&mut world.layer_mut("drained_area")?.field, &area);
        Ok(())
    }
}

impl Drainage {
    fn land<'a>(&self, moment: &'a Moment, height: &'a Field) -> Land<'a> {
        Land { height, grid: &moment.grid, sea_level_m: moment.sea_level_m, closed_rims: self.closed_rims }
    }
}

/// Puts `values` in place of a field's, and returns by how much its sum grew.
fn replace(field: &mut Field, values: &[f32]) -> f64 {
    let width = field.width();
    let rows = field.rows_mut().zip(values.chunks_exact(width));
    rows.map(|(row, new)| {
        let grown: f64 = row.iter().zip(new).map(|(&old, &new)| f64::from(new) - f64::from(old)).sum();
        row.copy_from_slice(new);
        grown
    })
    .sum()
}
