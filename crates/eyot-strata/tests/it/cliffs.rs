//! What beds make of a landscape: cliffs that stay cliffs, and benches on hard rock.

use crate::scheduled;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, Limits, World};
use eyot_land::simulate::{Hydraulic, Streampower};
use eyot_strata::{Bed, Material, Rockfall, Strata};

fn bed(material: &str, thickness: f32) -> Bed {
    Bed { material: material.into(), thickness }
}

fn materials() -> Vec<Material> {
    let mut all = eyot_strata::standard();
    all.push(Material { name: "middling".into(), talus: 55.0, erodibility: 0.3, density: 2500.0 });
    all
}

fn ripple(x: usize, y: usize) -> f32 {
    ((x * 7919 + y * 104_729 + x * y * 31) % 1021) as f32 / 1021.0
}

fn run(w: &mut World, all: &[Scheduled], steps: u64) {
    let from = w.step;
    CpuEngine::default().simulate(w, all, Span { from, steps }, &Control::none()).unwrap();
}

/// Mean over rows of a scarp: columns to the east.
fn profile(w: &World) -> Vec<f32> {
    let h = w.get("height").unwrap();
    (0..w.grid.width).map(|x| (0..w.grid.height).map(|y| h.get(x, y)).sum::<f32>() / w.grid.height as f32).collect()
}

/// A plateau at 100 m in the west, a plain at 0 m in the east, and a scarp of 45 degrees between them.
fn scarp() -> World {
    let rim = Boundary { x: BoundaryCondition::Open, y: BoundaryCondition::Wrap };
    let grid = Grid::new(100, 16, 10.0, rim, &Limits::default()).unwrap();
    let mut w = World::new(grid, 1);
    w.sea_level_m = -12_000.0;
    let h = |x: usize, y: usize| {
        (100.0 - 10.0 * (x as f32 - 60.0)).clamp(2.0 - 0.02 * x as f32, 101.0 - 0.01 * x as f32) + 0.3 * ripple(x, y)
    };
    w.put(&HEIGHT, Field::from_fn(100, 16, h)).unwrap();
    w
}

#[test]
fn explore_scarps() {
    let capped = Strata {
        materials: materials(),
        beds: vec![bed("granite", 15.0), bed("sandstone", 500.0)],
        top: 101.0,
        ..Strata::default()
    };
    let uniform = Strata { beds: vec![bed("sandstone", 1000.0)], ..capped.clone() };
    for (what, water) in [("hydraulic", 0), ("streampower 1", 1), ("streampower 0.7", 2)] {
        for (name, beds) in [("capped", &capped), ("uniform", &uniform)] {
            let eroding = match water {
                0 => scheduled(Hydraulic { by_rock: true, sea: false, ..Hydraulic::default() }),
                n => scheduled(Streampower {
                    years_per_step: 1000.0,
                    uplift: 0.0,
                    erodibility: 2e-5,
                    slope_exponent: if n == 1 { 1.0 } else { 0.7 },
                    diffusivity: 0.0,
                    ..Streampower::default()
                }),
            };
            let all = [eroding, scheduled(Rockfall::default()), scheduled(beds.clone())];
            let mut w = scarp();
            for k in 0..9 {
                let p = profile(&w);
                let at = |h: f32| p.iter().position(|v| *v < h).unwrap_or(0);
                let steep = p.windows(4).map(|q| ((q[0] - q[3]) / 30.0).atan().to_degrees()).fold(0.0, f32::max);
                println!("{what} {name} {}: 80 m at {}, 50 m at {}, steepest {steep:.1}", k * 150, at(80.0), at(50.0));
                if k == 8 {
                    let text: Vec<String> = p.iter().step_by(2).map(|h| format!("{h:.0}")).collect();
                    println!("   {}", text.join(" "));
                }
                run(&mut w, &all, 150);
            }
        }
    }
}

#[test]
fn explore_benches() {
    let beds: Vec<Bed> = (0..5).flat_map(|_| [bed("sandstone", 30.0), bed("granite", 10.0)]).collect();
    let layered = Strata { materials: materials(), beds, top: 220.0, ..Strata::default() };
    let uniform = Strata { beds: vec![bed("middling", 1000.0)], ..layered.clone() };
    for (what, water) in [("hydraulic", 0), ("streampower", 1)] {
        for (name, beds) in [("layered", &layered), ("uniform", &uniform)] {
            let eroding = match water {
                0 => scheduled(Hydraulic { by_rock: true, sea: false, ..Hydraulic::default() }),
                _ => scheduled(Streampower {
                    years_per_step: 1000.0,
                    uplift: 0.0,
                    erodibility: 2e-5,
                    ..Streampower::default()
                }),
            };
            let all = [eroding, scheduled(Rockfall::default()), scheduled(beds.clone())];
            let grid = Grid::new(96, 96, 20.0, Boundary::OPEN, &Limits::default()).unwrap();
            let mut w = World::new(grid, 1);
            w.sea_level_m = -12_000.0;
            let h = |x: usize, y: usize| {
                let (u, v) = (x as f32 / 95.0, y as f32 / 95.0);
                let edge = u.min(1.0 - u).min(v).min(1.0 - v);
                210.0 * (4.0 * edge).min(1.0)
                    + 8.0 * ((9.0 * u + 3.0 * v).sin() + (7.0 * v - 4.0 * u).cos())
                    + 3.0 * ripple(x, y)
            };
            w.put(&HEIGHT, Field::from_fn(96, 96, h)).unwrap();
            for k in 0..7 {
                // Tops of granite: 190, 150, 110, 70, 30 m.
                let h = w.get("height").unwrap();
                let on_top = h.iter().filter(|h| (0..5).any(|i| (h - (190.0 - 40.0 * i as f32)).abs() < 2.0)).count();
                println!("{what} {name} {}: {on_top} cells, {:?}", k * 100, h.min_max());
                run(&mut w, &all, 100);
            }
        }
    }
}
