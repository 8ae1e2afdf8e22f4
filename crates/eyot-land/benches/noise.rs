//! Speed of noise on one thread, for each instruction set: first a table of best times, then criterion's statistics.
//!
//! `cargo bench -p eyot-land --bench noise`; `-- --list` prints the table only.

use criterion::{Criterion, Throughput};
use eyot_core::isa::Isa;
use eyot_core::{Boundary, Control, Grid, Limits};
use eyot_land::generate::noise::{Basis, Noise, Sum};
use std::time::Instant;

const SIDE: usize = 1024;

fn cases() -> Vec<(&'static str, Noise, f64, Boundary)> {
    let noise = |basis, sum| Noise { basis, sum, scale_m: 0.25 * SIDE as f64, seed: 1, ..Noise::default() };
    vec![
        ("perlin", noise(Basis::Perlin, Sum::Fbm), 0.0, Boundary::CLOSED),
        ("simplex", noise(Basis::Simplex, Sum::Fbm), 0.0, Boundary::CLOSED),
        ("perlin_ridged", noise(Basis::Perlin, Sum::Ridged(2.0)), 0.0, Boundary::CLOSED),
        ("simplex_warped", noise(Basis::Simplex, Sum::Fbm), 100.0, Boundary::CLOSED),
        ("perlin_wrap", noise(Basis::Perlin, Sum::Fbm), 0.0, Boundary::WRAP),
        ("simplex_wrap", noise(Basis::Simplex, Sum::Fbm), 0.0, Boundary::WRAP),
    ]
}

fn main() {
    // One thread: numbers per core.
    if let Err(e) = rayon::ThreadPoolBuilder::new().num_threads(1).build_global() {
        eprintln!("running on more than one thread: {e}");
    }
    let isas: Vec<Isa> = Isa::ALL.into_iter().filter(|i| i.is_available()).collect();
    println!("8 octaves, {SIDE}x{SIDE}, one thread, best of 15, million points/s");
    let mut criterion = Criterion::default().sample_size(20).configure_from_args();
    for (name, noise, warp_m, rim) in cases() {
        // 8 octaves are all visible: the last has features of two cells.
        let Ok(grid) = Grid::new(SIDE, SIDE, 1.0, rim, &Limits::default()) else { continue };
        print!("{name:16}");
        for &isa in &isas {
            let best = (0..15)
                .map(|_| {
                    let start = Instant::now();
                    let field = noise.warped_field(warp_m, &grid, 0..SIDE, isa, &Control::none());
                    assert!(std::hint::black_box(field).is_ok());
                    start.elapsed().as_secs_f64()
                })
                .fold(f64::INFINITY, f64::min);
            print!("  {} {:6.1}", isa.name(), grid.cells() as f64 / best / 1e6);
        }
        println!();
    }
    for (name, noise, warp_m, rim) in cases() {
        let Ok(grid) = Grid::new(SIDE, SIDE, 1.0, rim, &Limits::default()) else { continue };
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(grid.cells() as u64));
        for &isa in &isas {
            group.bench_function(isa.name(), |b| {
                b.iter(|| noise.warped_field(warp_m, &grid, 0..SIDE, isa, &Control::none()))
            });
        }
        group.finish();
    }
    criterion.final_summary();
}
