//! Every rule of every process: lanes = scalar = reference bit by bit on all shapes and rims; the traced graph means the
//! same; its WGSL is valid.

use eyot_core::conformance;
use eyot_core::layer::known;
use eyot_core::process::{Moment, Process, Scheduled};
use eyot_core::wgsl::wgsl;
use eyot_core::{Grid, LayerSpec, Limits, Rim};
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::reef::{Light, Limit, Reef};
use eyot_land::simulate::{PROCESSES, Seabed, Thermal, Wetness};

fn one(process: impl Process + 'static) -> Scheduled {
    Scheduled { name: "test", process: Box::new(process), every: 1 }
}

/// Every process in every variant that has rules of its own.
fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    // A time step that needs two parts on the suite's cells of 2 x 2.5 m.
    let hydraulic = Hydraulic { time_step: 0.2, rain: 0.01, ..Default::default() };
    vec![
        ("hydraulic", vec![one(hydraulic.clone())]),
        ("hydraulic classic", vec![one(Hydraulic { flux: FluxForm::Classic, ..hydraulic.clone() })]),
        ("thermal", vec![one(Thermal::default())]),
        ("thermal inverted", vec![one(Thermal { inverted: true, ..Default::default() })]),
        ("seabed", vec![one(Seabed::default())]),
        ("reef", vec![one(Reef { years_per_step: 1.0, diffusivity: 3.0, sea_level_rise: 0.01, ..Default::default() })]),
        ("reef, plain diffusion", vec![one(Reef { years_per_step: 1.0, diffusivity: 0.5, ..Default::default() })]),
        // So many stages that the engine cuts the step into several chains.
        ("reef, 23 stages", vec![one(Reef { years_per_step: 10.0, diffusivity: 30.0, ..Default::default() })]),
        ("reef in light", vec![one(Reef { limit: Limit::Light, light: Light::Saturating, ..Default::default() })]),
        ("wetness", vec![one(Wetness::default())]),
        (
            "all",
            vec![
                one(hydraulic),
                one(Thermal::default()),
                Scheduled { name: "wetness", process: Box::new(Wetness::default()), every: 2 },
                Scheduled { name: "seabed", process: Box::new(Seabed::default()), every: 3 },
                one(Reef { years_per_step: 1.0, subsidence: 0.001, ..Default::default() }),
            ],
        ),
    ]
}

fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 12.0 * u - 4.0,
        "water" => (2.0 * u - 0.8).max(0.0),
        "sediment" => 0.1 * u,
        "limestone" => (2.0 * u - 1.0).max(0.0),
        "reef_floor" => 12.0 * u - 6.0,
        name if name.starts_with("flux") => u - 0.5,
        name if name.starts_with("outflow") => u,
        _ => u,
    }
}

#[test]
fn engine_equals_reference_for_every_rule() {
    for (name, processes) in variants() {
        println!("{name}");
        conformance::check(&processes, &start).unwrap();
    }
}

#[test]
fn springs_conform() {
    let with_springs = Hydraulic { springs: 0.01, ..Default::default() };
    struct WithSprings(Hydraulic);
    impl Process for WithSprings {
        fn layers(&self) -> Vec<(LayerSpec, f32)> {
            let mut l = self.0.layers();
            l.push((eyot_land::simulate::hydraulic::SPRINGS, 0.0));
            l
        }
        fn plan(&self, m: &Moment, p: &mut eyot_core::plan::Plan) {
            self.0.plan(m, p);
        }
    }
    conformance::check(&[one(WithSprings(with_springs))], &start).unwrap();
}

#[test]
fn graphs_mean_what_the_rules_mean() {
    let grid = Grid::new(64, 32, 3.0, Rim::OPEN, &Limits::default()).unwrap();
    for (_, processes) in variants() {
        conformance::check_graphs(&processes, grid);
    }
}

#[test]
fn every_rule_prints_as_valid_wgsl() {
    let grid = Grid::new(64, 32, 3.0, Rim::OPEN, &Limits::default()).unwrap();
    let mut seen = Vec::new();
    for (_, processes) in variants() {
        let mut plan = eyot_core::plan::Plan::default();
        let moment = Moment { grid, step: 0, turn: 0, sea_level_m: 0.0 };
        let mut specs: Vec<LayerSpec> = Vec::new();
        for s in &processes {
            s.process.plan(&moment, &mut plan);
            specs.extend(s.process.layers().into_iter().map(|l| l.0));
        }
        specs.extend(plan.scratch_layers().iter().cloned());
        for pass in plan.passes() {
            let graph = pass.graph();
            let spec = |name: &str| specs.iter().find(|s| s.name == name).cloned().unwrap_or(known::HEIGHT);
            let source = wgsl(&graph, spec);
            let module = naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|e| panic!("{}: {}\n{source}", pass.name(), e.emit_to_string(&source)));
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
                .validate(&module)
                .unwrap_or_else(|e| panic!("{}: {e:?}\n{source}", pass.name()));
            seen.push(pass.name());
        }
    }
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), 13, "{seen:?}");
}

#[test]
fn registry_is_sound() {
    for e in PROCESSES {
        let process = (e.make)((e.defaults)()).unwrap_or_else(|err| panic!("{}: {err}", e.name));
        assert!(!process.layers().is_empty());
        let schema = (e.schema)();
        let properties = schema.as_value()["properties"].as_object().unwrap();
        for (name, p) in properties {
            assert!(p["description"].is_string(), "{}.{name} says nothing about itself", e.name);
            if p["type"] == "number" || p["type"] == "integer" {
                assert!(
                    p["unit"].is_string() && p["minimum"].is_number() && p["maximum"].is_number(),
                    "{}.{name}: {p}",
                    e.name
                );
            }
        }
    }
}
