//! The shaders of every rule, without a GPU: valid on every rim, alone and in groups, and readable.

use eyot_core::conformance::rims;
use eyot_core::plan::Plan;
use eyot_core::process::{Moment, Scheduled, plan_step};
use eyot_core::{Boundary, Grid, LayerSpec, Limits};
use eyot_gpu::shaders;
use eyot_testing::climate::climate_variants;
use eyot_testing::land::variants;
use eyot_testing::{plants, strata};

/// A plan of some steps, the layers that it works on, and how many of them are the world's.
fn plan(processes: &[Scheduled], rim: Boundary, steps: u64) -> (Plan, Vec<LayerSpec>, usize) {
    let grid = Grid::new(64, 32, 3.0, rim, &Limits::default()).unwrap();
    let mut moment = Moment::whole(grid, 0, 0.0);
    let mut plan = Plan::default();
    (0..steps).for_each(|i| plan_step(processes, i, &mut moment, &mut plan));
    let mut specs: Vec<LayerSpec> = Vec::new();
    for spec in processes.iter().flat_map(|s| s.process.layers()).map(|l| l.spec) {
        if !specs.iter().any(|s| s.name == spec.name) {
            specs.push(spec);
        }
    }
    let world_layers = specs.len();
    specs.extend(plan.scratch_layers().iter().cloned());
    (plan, specs, world_layers)
}

fn validate(names: &[&str], source: &str) {
    let module = naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|e| panic!("{names:?}: {}\n{source}", e.emit_to_string(source)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{names:?}: {e:?}\n{source}"));
    // What every WebGPU device offers.
    let shared: u32 = module
        .global_variables
        .iter()
        .filter(|(_, v)| v.space == naga::AddressSpace::WorkGroup)
        .map(|(_, v)| module.types[v.ty].inner.size(module.to_ctx()))
        .sum();
    assert!(shared <= 16384, "{names:?} needs {shared} bytes of workgroup memory");
    let storage = module.global_variables.iter().filter(|(_, v)| matches!(v.space, naga::AddressSpace::Storage { .. }));
    assert!(storage.count() <= 8);
}

#[test]
fn every_group_prints_as_valid_wgsl() {
    let mut seen = Vec::new();
    let mut longest = 0;
    for (_, processes) in
        variants().into_iter().chain(climate_variants()).chain(strata::variants()).chain(plants::variants())
    {
        for rim in rims() {
            for most_passes in [1, 4, 8] {
                let (plan, specs, world_layers) = plan(&processes, rim, 3);
                for split in [false, true] {
                    let shaders = shaders::of_plan(&plan, &specs, world_layers, rim, most_passes, split).unwrap();
                    for (names, source) in shaders {
                        validate(&names, &source);
                        longest = longest.max(names.len());
                        assert!(names.len() <= most_passes);
                        seen.extend(names);
                    }
                }
            }
        }
    }
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), 120, "{seen:?}");
    // More than one step of a process that has two passes.
    assert!(longest > 4, "the longest group has {longest} passes");
}

/// Three rules as they are read by people.
#[test]
fn three_rules_look_as_they_did() {
    for (variant, rim) in [("thermal", Boundary::CLOSED), ("hydraulic", Boundary::OPEN), ("wetness", Boundary::WRAP)] {
        let (_, processes) = variants().into_iter().find(|(name, _)| *name == variant).unwrap();
        let (plan, specs, world_layers) = plan(&processes, rim, 1);
        let shaders = shaders::of_plan(&plan, &specs, world_layers, rim, 4, false).unwrap();
        let text: String = shaders.into_iter().map(|(_, source)| source).collect::<Vec<_>>().join("\n");
        let path = format!("{}/tests/wgsl/{variant}.wgsl", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("EYOT_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let want = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(text == want, "{path} is out of date; EYOT_BLESS=1 writes it anew\n{text}");
    }
}
