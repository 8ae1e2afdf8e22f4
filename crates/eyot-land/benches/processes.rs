//! Cell-steps a second of the processes with default parameters, on all cores, to notice when a change makes one slower.
//!
//! A sample is one call of the engine over several steps, including what it sets up. Comparisons with others are made by
//! `eyot bench` and `benches/peers`.

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use eyot_core::engine::CpuEngine;
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Boundary, Control, Grid, Limits, World, rng};
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::{Reef, Thermal};
use std::time::Duration;

/// Steps of a sample: enough that setting up does not count, little enough for few seconds at 2048 x 2048.
const STEPS: u64 = 16;

type Case = (&'static str, fn() -> Box<dyn Process>);

/// Rough hills from 60 m below the sea to 140 m above, on cells of 10 m, with shallow water everywhere.
fn world(size: usize, process: &dyn Process) -> World {
    let grid = Grid::new(size, size, 10.0, Boundary::CLOSED, &Limits::default()).expect("the grid is sound");
    let mut world = World::new(grid, 1);
    for l in process.layers() {
        let (spec, value) = (l.spec, l.start);
        let field = &mut world.ensure(&spec, value).field;
        for y in 0..size {
            for x in 0..size {
                let u = rng::unit::<f32>(rng::hash(rng::Key::new(1, 0, 0), (y * size + x) as u32));
                match &*spec.name {
                    "height" => {
                        let hills = (x as f32 * 0.06).sin() * (y as f32 * 0.045).cos();
                        field.set(x, y, 40.0 + 90.0 * hills + 10.0 * u);
                    }
                    "water" => field.set(x, y, 0.2 * u),
                    _ => {}
                }
            }
        }
    }
    world
}

fn processes(c: &mut Criterion) {
    let cases: [Case; 4] = [
        ("hydraulic_signed", || Box::new(Hydraulic::default())),
        // Half a step, because the classic form is stable only that far.
        ("hydraulic_classic", || {
            Box::new(Hydraulic { flux: FluxForm::Classic, time_step: 0.25, ..Default::default() })
        }),
        ("thermal", || Box::new(Thermal::default())),
        // A year a step makes one spreading of carbon a growth.
        ("reef", || Box::new(Reef { years_per_step: 1.0, ..Default::default() })),
    ];
    for (name, make) in cases {
        let mut group = c.benchmark_group(name);
        group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
        for size in [512, 2048] {
            group.throughput(Throughput::Elements((size * size) as u64 * STEPS));
            let start = world(size, &*make());
            let scheduled = [Scheduled { name, process: make(), every: 1 }];
            group.bench_function(BenchmarkId::from_parameter(size), |b| {
                b.iter_batched_ref(
                    || start.clone(),
                    |world| {
                        let span = Span { from: 0, steps: STEPS };
                        CpuEngine::default().simulate(world, &scheduled, span, &Control::none())
                    },
                    BatchSize::PerIteration,
                );
            });
        }
        group.finish();
    }
}

criterion_group!(benches, processes);
criterion_main!(benches);
