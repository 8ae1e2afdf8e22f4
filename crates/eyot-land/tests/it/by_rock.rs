//! Processes that know how hard the rock is that they wear.

use crate::common::grid;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::{ERODIBILITY, HEIGHT};
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Boundary, Control, Field, World};
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};

fn run(world: &mut World, process: impl Process + 'static, steps: u64) {
    let one = [Scheduled { name: "test", process: Box::new(process), every: 1 }];
    CpuEngine::default().simulate(world, &one, Span { from: 0, steps }, &Control::none()).unwrap();
}

fn hills() -> World {
    let mut w = World::new(grid(40, 30, 10.0, Boundary::CLOSED), 3);
    let hill = |x: usize, y: usize| 2.0 * x as f32 + 15.0 * ((0.4 * x as f32).sin() * (0.3 * y as f32).cos() + 1.0);
    w.put(&HEIGHT, Field::from_fn(40, 30, hill)).unwrap();
    w
}

/// The world with rock of this factor.
fn of_rock(w: &World, factor: f32) -> World {
    let mut w = w.clone();
    w.put(&ERODIBILITY, Field::new(w.grid.width, w.grid.height, factor)).unwrap();
    w
}

const FORMS: [FluxForm; 3] = [FluxForm::Eight, FluxForm::Signed, FluxForm::Classic];

#[test]
fn water_digs_as_much_of_rock_as_its_factor_says() {
    for flux in FORMS {
        let plain = Hydraulic { flux, ..Hydraulic::default() };
        let by_rock = Hydraulic { by_rock: true, ..plain.clone() };
        let mut rivers = hills();
        run(&mut rivers, plain.clone(), 150);
        let change = |factor: f32| {
            let mut w = of_rock(&rivers, factor);
            run(&mut w, by_rock.clone(), 1);
            let after = w.get("height").unwrap().clone();
            rivers.get("height").unwrap().iter().zip(after.iter()).map(|(a, b)| b - a).collect::<Vec<f32>>()
        };
        let (whole, quarter, none) = (change(1.0), change(0.25), change(-2.0));
        let mut dug = 0;
        for ((whole, quarter), none) in whole.iter().zip(&quarter).zip(&none) {
            if *whole < 0.0 {
                dug += 1;
                // Heights have steps of 8e-6 m.
                assert!((quarter - 0.25 * whole).abs() < 2e-5, "{flux:?}: {whole} and {quarter} m");
                assert_eq!(*none, 0.0, "{flux:?}: a factor below 0 is 0");
            } else {
                assert!(quarter == whole && none == whole, "{flux:?}: what settles knows no rock");
            }
        }
        assert!(dug > 200, "{flux:?}: {dug} cells were dug");
        // Soft rock fills the load at most, and keeps to the limit of digging.
        let soft = change(1e6);
        let limited = whole.iter().zip(&soft).all(|(whole, soft)| *whole >= 0.0 || soft <= whole);
        assert!(limited && soft.iter().all(|d| d.is_finite() && *d > -20.0), "{flux:?}");
    }
}

#[test]
fn loose_ground_is_the_same_with_and_without_rock() {
    for flux in FORMS {
        let plain = Hydraulic { flux, ..Hydraulic::default() };
        let mut without = hills();
        run(&mut without, plain.clone(), 60);
        let mut with = of_rock(&hills(), 1.0);
        run(&mut with, Hydraulic { by_rock: true, ..plain }, 60);
        for layer in ["height", "water", "sediment"] {
            assert!(with.get(layer).unwrap() == without.get(layer).unwrap(), "{flux:?}: {layer}");
        }
    }
}
