//! The same recipe gives the same bytes: for any number of threads, chains, bands and pieces, in debug and in release; and
//! no parameters within their documented ranges lead to anything that is not a number.

use eyot_core::conformance::{random_world, rims};
use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::isa::Isa;
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Boundary, Error, Grid, Limits, World};
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic, SPRINGS};
use eyot_land::simulate::{PROCESSES, Reef, Seabed, Thermal, Wetness};
use proptest::prelude::*;
use serde_json::{Map, Value, json};

/// All processes, some of them not in every step, with a time step that is cut into parts.
fn all() -> Vec<Scheduled> {
    let every = |process: Box<dyn Process>, every| Scheduled { name: "test", process, every };
    let reef = Reef {
        years_per_step: 5.0,
        diffusivity: 2.0,
        subsidence: 0.001,
        sea_level_rise: 0.002,
        sea_level_curve: vec![[0.0, 0.0], [40.0, 0.5], [90.0, -0.3]],
        ..Default::default()
    };
    vec![
        every(Box::new(Hydraulic { time_step: 0.2, rain: 0.01, springs: 0.01, ..Default::default() }), 1),
        every(Box::<Thermal>::default(), 1),
        every(Box::<Wetness>::default(), 2),
        every(Box::<Seabed>::default(), 3),
        every(Box::new(Thermal { inverted: true, ..Default::default() }), 4),
        every(Box::new(reef), 2),
        every(Box::new(Hydraulic { time_step: 0.1, flux: FluxForm::Classic, ..Default::default() }), 5),
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
        _ => u,
    }
}

/// Asks for the layer of springs, which the hydraulic process expects to find.
struct Springs;

impl Process for Springs {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![SPRINGS.changed(0.0)]
    }
    fn plan(&self, _: &eyot_core::process::Moment, _: &mut eyot_core::plan::Plan) {}
}

fn first_world(shape: (usize, usize), rim: Boundary) -> World {
    let mut processes = vec![Scheduled { name: "springs", process: Box::new(Springs), every: 1 }];
    processes.extend(all());
    let mut w = random_world(shape, rim, 17, &processes, &start).unwrap();
    w.sea_level_m = 0.25;
    w
}

fn run(world: &World, engine: CpuEngine, pieces: &[u64]) -> World {
    let mut w = world.clone();
    let mut from = 0;
    for &steps in pieces {
        engine.simulate(&mut w, &all(), Span { from, steps }, &Control::none()).unwrap();
        from += steps;
    }
    w
}

const STEPS: u64 = 23;

#[test]
fn threads_chains_and_bands_change_no_byte() {
    for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
        let world = first_world((75, 203), rim);
        let expected = run(&world, CpuEngine { chain: 1, band: 1000, ..Default::default() }, &[STEPS]);
        assert_ne!(expected.fingerprint(), world.fingerprint());
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for (chain, band) in [(0, 0), (1, 16), (2, 64), (3, 33), (4, 16), (7, 64), (1, 7), (30, 0)] {
                let engine = CpuEngine { chain, band, ..Default::default() };
                let w = pool.install(|| run(&world, engine, &[STEPS]));
                let here = format!("{rim:?} {threads} threads chain {chain} band {band}");
                assert_eq!(w.fingerprint(), expected.fingerprint(), "{here}");
                assert_eq!(w.ledger, expected.ledger, "{here}");
            }
        }
    }
}

#[test]
fn a_run_in_pieces_gives_the_same_bytes() {
    for rim in rims() {
        let world = first_world((37, 41), rim);
        let whole = run(&world, CpuEngine::default(), &[STEPS]);
        for pieces in [&[1u64; STEPS as usize][..], &[7, 16], &[2, 3, 5, 13], &[0, 22, 1]] {
            let parts = run(&world, CpuEngine { chain: 3, ..Default::default() }, pieces);
            assert_eq!((parts.step, parts.sea_level_m), (whole.step, whole.sea_level_m));
            assert_eq!(parts.fingerprint(), whole.fingerprint(), "{rim:?} in pieces {pieces:?}");
            assert_eq!(parts.ledger, whole.ledger, "{rim:?} in pieces {pieces:?}");
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_bytes() {
    let world = first_world((75, 50), Boundary::OPEN);
    let expected = run(&world, CpuEngine { isa: Isa::Scalar, ..Default::default() }, &[STEPS]);
    for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
        let w = run(&world, CpuEngine { isa, ..Default::default() }, &[STEPS]);
        assert_eq!(w.fingerprint(), expected.fingerprint(), "{}", isa.name());
        assert_eq!(w.ledger, expected.ledger, "{}", isa.name());
    }
}

/// Bytes that a build of this program must give, whatever the profile and the machine. They change when a rule, a default
/// or the order of an addition changes; then this line changes with them, in the same commit.
#[test]
fn the_fingerprint_of_a_tiny_world_is_pinned() {
    let w = run(&first_world((13, 11), Boundary::OPEN), CpuEngine::default(), &[STEPS]);
    assert_eq!(format!("{:016x}", w.fingerprint()), "84aebd0fc1668589");
}

// ------------------------------------------------------------------------------------------------------ Random parameters

/// Parameters drawn from what the schema of `name` allows: numbers evenly or, over more than two orders of magnitude,
/// evenly in the logarithm, with both ends of the range now and then.
fn draw(name: &str, mut unit: impl FnMut() -> f64) -> Value {
    let entry = PROCESSES.iter().find(|e| e.name == name).unwrap();
    let schema = (entry.schema)();
    let mut out = Map::new();
    for (field, p) in schema.as_value()["properties"].as_object().into_iter().flatten() {
        let u = unit();
        let choices: Vec<Value> = match (p.get("enum"), p.get("oneOf")) {
            (Some(e), _) => e.as_array().unwrap().clone(),
            (_, Some(o)) => o.as_array().unwrap().iter().map(|c| c["const"].clone()).collect(),
            _ => Vec::new(),
        };
        let value = match p["type"].as_str() {
            Some("boolean") => json!(u < 0.5),
            Some("number") => {
                let (low, high) = (p["minimum"].as_f64().unwrap(), p["maximum"].as_f64().unwrap());
                let logarithmic = low >= 0.0 && high > 100.0 * low;
                let from = if low > 0.0 { low } else { 1e-6 * high };
                json!(match u {
                    u if u < 0.05 => low,
                    u if u > 0.95 => high,
                    u if logarithmic => (from * (high / from).powf(u)).clamp(low, high),
                    u => low + u * (high - low),
                })
            }
            Some("array") if field == "sea_level_curve" => json!([[0.0, 10.0 * u], [100.0 * u + 1.0, -20.0 * u]]),
            _ if !choices.is_empty() => choices[(u * choices.len() as f64) as usize % choices.len()].clone(),
            _ => panic!("{name}.{field}: do not know how to draw {p}"),
        };
        out.insert(field.clone(), value);
    }
    Value::Object(out)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 160, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn no_parameters_in_range_break_a_world(
        which in 0..PROCESSES.len() + 1,
        width in 1..=40usize,
        height in 1..=40usize,
        rim in 0..9usize,
        cell in (-0.5..3.0f64, -0.5..3.0f64),
        sea in -20.0..20.0f64,
        relief in 0.0..3.5f64,
        seed: u64,
    ) {
        let mut n = 0u32;
        let mut unit = || {
            n += 1;
            f64::from(eyot_core::rng::unit::<f32>(eyot_core::rng::hash(eyot_core::rng::Key::new(seed, 1, 0), n)))
        };
        let names: Vec<&str> = PROCESSES.iter().map(|e| e.name).collect();
        let names = if which < names.len() { vec![names[which]] } else { names };
        let mut grid = Grid::new(width, height, 10f64.powf(cell.0), rims()[rim], &Limits::default()).unwrap();
        grid.cell_y_m = 10f64.powf(cell.1);
        let mut world = World::new(grid, seed);
        world.sea_level_m = sea;
        world.ensure(&SPRINGS, 0.0);
        let mut described = Vec::new();
        let mut processes = Vec::new();
        for name in names {
            let entry = PROCESSES.iter().find(|e| e.name == name).unwrap();
            let mut parameters = draw(name, &mut unit);
            if name == "hydraulic" {
                // Steps of many parts take long and show nothing new.
                let p: Hydraulic = serde_json::from_value(parameters.clone()).unwrap();
                let parts = p.substeps(grid.cell_x_m, grid.cell_y_m).0;
                let time_step = f64::from(p.time_step) * (20.0 / f64::from(parts)).min(1.0);
                parameters["time_step"] = json!(time_step);
            }
            described.push(format!("{name} {parameters}"));
            processes.push(Scheduled { name: entry.name, process: (entry.make)(parameters).unwrap(), every: 1 });
        }
        for s in &processes {
            for l in s.process.layers() {
                let (spec, value) = (l.spec, l.start);
                world.ensure(&spec, value);
            }
        }
        let top = 10f64.powf(relief) as f32;
        let names: Vec<String> = world.layers().iter().map(|l| l.spec.name.to_string()).collect();
        for name in &names {
            world.layer_mut(name).unwrap().field.map_in_place(|_| {
                let u = unit() as f32;
                match name.as_str() {
                    "height" => top * (u - 0.3),
                    "reef_floor" => top * (u - 0.6),
                    "water" | "limestone" | "sediment" => (0.1 * top * (u - 0.5)).max(0.0),
                    n if n.starts_with("flux") => top * (u - 0.5),
                    n if n.starts_with("outflow") => top * u,
                    _ => u,
                }
            });
        }
        let outcome = CpuEngine::default().simulate(&mut world, &processes, Span { from: 0, steps: 20 }, &Control::none());
        match outcome {
            Ok(()) => {}
            // A process may say that parameters do not fit together or this grid, before the first step.
            Err(Error::BadParameter { .. }) if world.step == 0 => return Ok(()),
            // Nor may a reef's sea leave the range of heights.
            Err(Error::Clock { .. }) => return Ok(()),
            Err(e) => prop_assert!(false, "{e}; {described:?}"),
        }
        prop_assert!(world.sea_level_m.is_finite());
        for l in world.layers() {
            let (low, high) = l.field.min_max();
            prop_assert!(l.field.find_not_finite().is_none());
            if ["water", "sediment", "limestone", "growth", "carbon", "wetness"].contains(&&*l.spec.name) {
                prop_assert!(low >= 0.0, "{} {low}; {described:?}", l.spec.name);
            }
            if ["growth", "carbon", "wetness"].contains(&&*l.spec.name) {
                prop_assert!(high <= 1.0, "{} {high}; {described:?}", l.spec.name);
            }
        }
        for (account, a) in world.ledger.iter() {
            prop_assert!(a.amount.is_finite(), "{account}; {described:?}");
        }
    }
}
