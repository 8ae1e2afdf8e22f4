//! Every rule on the GPU against the reference: every rim, odd sizes, alone and in groups, in one piece and in slabs.

use eyot_core::conformance::{random_world, rims};
use eyot_core::control::Control;
use eyot_core::plan::Plan;
use eyot_core::process::{Moment, Scheduled, Span, plan_step};
use eyot_core::reference::Reference;
use eyot_core::{Boundary, World};
use eyot_gpu::{Choice, Gpu, GpuEngine, GpuError, Options, blocking};
use eyot_testing::climate::{climate_start, climate_variants};
use eyot_testing::{land, plants, strata};

use crate::common;

/// The processes of all crates.
fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    land::variants().into_iter().chain(climate_variants()).chain(strata::variants()).chain(plants::variants()).collect()
}

/// A plausible value of a layer in the processes of that name.
fn start_of(name: &str) -> fn(&str, f32) -> f32 {
    let is_one = |of: Vec<(&str, Vec<Scheduled>)>| of.iter().any(|(n, _)| *n == name);
    match name {
        _ if is_one(land::variants()) => land::start,
        _ if is_one(strata::variants()) => strata::start,
        _ if is_one(plants::variants()) => plants::start,
        _ => climate_start,
    }
}

/// A shape for each thing that can go wrong: no neighbours, one row, one column, less than a tile, one more than a tile, not a
/// multiple of anything.
const SHAPES: [(usize, usize); 8] = [(1, 1), (1, 7), (9, 1), (3, 5), (27, 51), (33, 17), (64, 64), (100, 35)];

/// Largest difference of the layers, in units in the last place of the largest value of the same unit, how many values differ by
/// more than `most_ulp`, and where the largest is.
fn difference(world: &World, reference: &Reference<f32>, most_ulp: f64) -> (f64, usize, String) {
    let (mut worst, mut beyond) = ((0.0, String::new()), 0);
    for l in world.layers() {
        // Small values come from differences of larger ones: a load is what the rounded ground gave.
        let like = world.layers().iter().filter(|other| other.spec.unit == l.spec.unit);
        let scale = like.flat_map(|l| l.field.iter()).fold(f32::MIN_POSITIVE, |m, v| m.max(v.abs()));
        let ulp = f64::from(f32::from_bits(scale.to_bits() + 1) - scale);
        for y in 0..world.grid.height {
            for x in 0..world.grid.width {
                let (got, want) = (l.field.get(x, y), reference.get(&l.spec.name, x, y));
                let d = f64::from((got - want).abs()) / ulp;
                beyond += usize::from(d > most_ulp || d.is_nan());
                if d > worst.0 || d.is_nan() {
                    worst = (d, format!("{} at ({x}, {y}) is {got:?}, the reference has {want:?}", l.spec.name));
                }
            }
        }
    }
    (worst.0, beyond, worst.1)
}

fn run(engine: &mut GpuEngine, world: &mut World, processes: &[Scheduled], steps: u64) {
    while let Err(e) = engine.simulate(world, processes, Span { from: 0, steps }, &Control::none()) {
        // As many slabs as can be.
        assert!(matches!(e, GpuError::Limits { .. }), "{e}");
        engine.options.most_bytes += engine.options.most_bytes / 4;
    }
    engine.download(world).unwrap();
    engine.release();
}

/// Passes of a step.
fn passes(world: &World, processes: &[Scheduled]) -> usize {
    let mut moment = Moment::whole(world.grid, 0, 0.0);
    let mut plan = Plan::default();
    plan_step(processes, 0, &mut moment, &mut plan);
    plan.passes().len()
}

/// Compares every variant; D2 allows 8 units in the last place after one step.
fn check(gpu: Gpu, options: Options, shapes: &[(usize, usize)], rims: &[Boundary], steps: u64) -> f64 {
    let mut engine = GpuEngine::new(gpu, options, None).unwrap();
    let mut worst: f64 = 0.0;
    for (name, processes) in variants() {
        let (mut of_this, mut of_passes) = (0.0f64, 0);
        for &shape in shapes {
            for (i, &rim) in rims.iter().enumerate() {
                let mut world = random_world(shape, rim, 7 + i as u64, &processes, &start_of(name)).unwrap();
                let mut reference = Reference::<f32>::new(&world);
                reference.simulate(&processes, steps);
                engine.options = options;
                run(&mut engine, &mut world, &processes, steps);
                let most_ulp = steps as f64 * 8.0;
                let (d, beyond, place) = difference(&world, &reference, most_ulp);
                // A rule that chooses (is there limestone left?) may choose otherwise where rounding decides, once there has been any.
                if steps > 1 && d > most_ulp && beyond <= shape.0 * shape.1 / 200 {
                    println!("{name} {shape:?} {rim:?}: {beyond} cells chose otherwise: {place}");
                    continue;
                }
                assert!(d <= most_ulp, "{name} {shape:?} {rim:?}: {d} ulp: {place}");
                (of_this, of_passes) = (of_this.max(d), passes(&world, &processes));
                for (account, want) in &reference.ledger {
                    let got = world.ledger.amount(account);
                    // What rounding leaves is another number wherever another order of operations rounds.
                    let ulp = if account.ends_with(".rounded") { 1e-6 * world.grid.cell_area_m2() } else { 1e-8 };
                    let slack = 1e-6 + ulp * world.grid.cells() as f64;
                    assert!(
                        (got - want).abs() <= 1e-5 * want.abs() + slack,
                        "{account}: {got}, reference {want}; {name} {shape:?} {rim:?}"
                    );
                }
            }
        }
        println!("{name}: {of_this} ulp in {of_passes} passes");
        worst = worst.max(of_this);
    }
    worst
}

#[test]
fn one_step_equals_the_reference_for_every_rule() {
    let Some(gpu) = common::gpu() else { return };
    let worst = check(gpu, Options::default(), &SHAPES, &rims(), 1);
    println!("largest difference: {worst} ulp");
}

#[test]
fn some_steps_in_groups_equal_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let options = Options::default().most_passes(8);
    let worst = check(gpu, options, &[(27, 51), (64, 40)], &rims(), 5);
    println!("largest difference: {worst} ulp");
}

#[test]
fn passes_one_by_one_equal_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    let options = Options::default().most_passes(1);
    let worst = check(gpu, options, &[(27, 51)], &[Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP], 5);
    println!("largest difference: {worst} ulp");
}

/// Buffers so small that the grid is cut into slabs.
#[test]
fn slabs_equal_the_reference() {
    let Some(gpu) = common::gpu() else { return };
    for most_passes in [1, 4] {
        let options = Options::default().most_passes(most_passes).most_bytes(20_000);
        let worst = check(
            blocking::open(&Choice::Best).unwrap(),
            options,
            &[(27, 97), (64, 64)],
            &[Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP],
            5,
        );
        println!("largest difference: {worst} ulp");
    }
    drop(gpu);
}
