//! The shaders of a plan, without a GPU: for tests and for those who want to read them.

use crate::group::{Bounds, Layers, groups};
use crate::shader::{self, Setting};
use eyot_core::graph::Graph;
use eyot_core::plan::Plan;
use eyot_core::{Boundary, LayerSpec};

/// WGSL of every group that a plan is cut into, with the names of its rules.
///
/// `specs` are the layers of the world, followed by the scratch layers of the plan; `world_layers` says how many are the world's.
/// `most_passes` bounds the passes of a group; `split` is for grids that are cut into slabs.
///
/// `None` if the plan names another layer.
pub fn of_plan(
    plan: &Plan,
    specs: &[LayerSpec],
    world_layers: usize,
    rim: Boundary,
    most_passes: usize,
    split: bool,
) -> Option<Vec<(Vec<&'static str>, String)>> {
    let bounds = Bounds { shared: crate::engine::SHARED, passes: most_passes };
    let mut rest = plan.passes();
    let mut shaders = Vec::new();
    for group in groups(rest, &Layers { specs, world_layers }, bounds)? {
        let (passes, later) = rest.split_at(group.stages.len());
        rest = later;
        let graphs: Vec<Graph> = passes.iter().map(|p| p.graph()).collect();
        let graphs: Vec<&Graph> = graphs.iter().collect();
        let names = passes.iter().map(|p| p.name()).collect();
        shaders.push((names, shader::wgsl(&group, &graphs, Setting { specs, rim, split })));
    }
    Some(shaders)
}
