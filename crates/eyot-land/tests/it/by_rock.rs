//! Processes that know how hard the rock is that they wear.

use crate::common::grid;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::{BED_LEFT, ERODIBILITY, ERODIBILITY_BELOW, HEIGHT, LIMESTONE};
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, World};
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::streampower::{HEIGHT_REST, Streampower};
use eyot_land::simulate::{Seabed, Thermal};

fn run(world: &mut World, process: impl Process + 'static, steps: u64) {
    run_boxed(world, Box::new(process), steps);
}

fn run_boxed(world: &mut World, process: Box<dyn Process>, steps: u64) {
    let one = [Scheduled { name: "test", process, every: 1 }];
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
        // Short enough to be no two parts of a step in the classic form.
        let plain = Hydraulic { flux, time_step: 0.4, ..Hydraulic::default() };
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

/// Beds that lie level, from the top: bottom (m of height) and factor on the erodibility. Writes what `strata` would.
fn expose(w: &mut World, beds: &[(f64, f32)]) {
    let height = heights(w);
    let (mut here, mut left, mut below) = (Vec::new(), Vec::new(), Vec::new());
    for z in height {
        let k = beds.iter().position(|(bottom, _)| z > *bottom).unwrap_or(beds.len() - 1);
        here.push(beds[k].1);
        left.push((z - beds[k].0) as f32);
        below.push(beds[(k + 1).min(beds.len() - 1)].1);
    }
    for (spec, values) in [(&ERODIBILITY, here), (&BED_LEFT, left), (&ERODIBILITY_BELOW, below)] {
        let width = w.grid.width;
        w.put(spec, Field::from_fn(width, w.grid.height, |x, y| values[y * width + x])).unwrap();
    }
}

fn heights(w: &World) -> Vec<f64> {
    let (height, rest) = (w.get("height").unwrap(), w.get("height_rest").unwrap());
    height.iter().zip(rest.iter()).map(|(h, r)| f64::from(h) + f64::from(r)).collect()
}

/// A row of cells, of which the western one holds its height.
fn row(cells: usize, cell_m: f64, height: impl Fn(usize) -> f32) -> World {
    let rim = Boundary { x: BoundaryCondition::Open, y: BoundaryCondition::Closed };
    let mut w = World::new(grid(cells, 1, cell_m, rim), 1);
    w.sea_level_m = -12_000.0;
    w.put(&HEIGHT, Field::from_fn(cells, 1, |x, _| height(x))).unwrap();
    w.ensure(&HEIGHT_REST, 0.0);
    w
}

/// Rivers for which `c = K T / L` is 0.25 in loose ground, whatever they drain.
fn quarter() -> Streampower {
    Streampower {
        years_per_step: 1000.0,
        uplift: 0.0,
        erodibility: 0.025,
        area_exponent: 0.0,
        diffusivity: 0.0,
        ..Streampower::default()
    }
}

/// Both by hand: `b / K1 + (100 - b - h) / K2 = 0.25 h`, over ground at 0 m.
#[test]
fn a_river_that_cuts_through_a_bed_keeps_its_budget_of_time() {
    for (beds, want) in [
        // 5 m of loose ground over rock: 5 + (95 - h) / 0.1 = 0.25 h. Without a budget 80 m.
        ([(95.0, 1.0), (-1e3, 0.1)], 955.0 / 10.25),
        // 1 m of rock over loose ground: 1 / 0.1 + (99 - h) = 0.25 h. Without a budget 97.56 m.
        ([(99.0, 0.1), (-1e3, 1.0)], 109.0 / 1.25),
        // Rock that holds: (100 - h) / 0.1 = 0.25 h.
        ([(90.0, 0.1), (-1e3, 1.0)], 1000.0 / 10.25),
        // What nothing wears stays: 100 - 5.
        ([(95.0, 1.0), (-1e3, 0.0)], 95.0),
        // Equal beds are one: (100 - h) = 0.25 h.
        ([(95.0, 1.0), (-1e3, 1.0)], 80.0),
    ] {
        let mut w = row(3, 100.0, |x| if x == 1 { 100.0 } else { 0.0 });
        expose(&mut w, &beds);
        run(&mut w, quarter(), 1);
        let got = heights(&w)[1];
        assert!((got - want).abs() < 1e-4, "{beds:?}: {got}, {want} m");
    }
}

/// A hard bed of 2 m that one long step would jump.
#[test]
fn a_thin_hard_bed_holds_as_long_in_long_steps_as_in_short_ones() {
    let beds = [(80.0, 1.0), (78.0, 0.05), (-1e3, 1.0)];
    for n in [0.7_f32, 1.0, 1.6] {
        let cut = |parts: u32, beds: &[(f64, f32)]| {
            let mut w = row(3, 100.0, |x| if x == 1 { 85.0 } else { 0.0 });
            let p = Streampower { years_per_step: 400.0 / parts as f32, slope_exponent: n, ..quarter() };
            for _ in 0..parts {
                expose(&mut w, beds);
                run(&mut w, p.clone(), 1);
            }
            heights(&w)[1]
        };
        let fine = cut(2000, &beds);
        let coarse = cut(4, &beds);
        // Without the bed, a step cuts more than it is thick.
        let soft = cut(4, &[(-1e3, 1.0)]);
        println!("n {n}: {fine:.3} m in short steps, {coarse:.3} in long ones, {soft:.3} without the bed");
        assert!((coarse - fine).abs() < 0.1 * (fine - soft), "n {n}: {coarse} and {fine} m, {soft} without the bed");
    }
}

/// Perne, Covington, Thaler and Myre 2017: beds that lie level retreat at one rate, `K A^m S^(n - 1)`, so that the steepness of
/// channels goes with `K^(-1 / (n - 1))`: below n = 1 they are steeper in weak beds, above it in strong ones.
#[test]
fn below_n_1_channels_are_steeper_in_weak_beds_and_above_it_in_strong_ones() {
    let (cells, cell_m, thick) = (400, 5.0, 40.0);
    for (n, slope) in [(0.5_f32, 0.3_f64), (2.0, 0.3)] {
        let (strong, weak) = (0.8_f32, 1.2_f32);
        let uplift = 1e-3;
        let p = Streampower {
            years_per_step: 1000.0,
            uplift: uplift as f32,
            erodibility: (uplift / slope.powf(f64::from(n))) as f32,
            slope_exponent: n,
            ..quarter()
        };
        let mut w = row(cells, cell_m, |x| (slope * cell_m * x as f64) as f32);
        // Sums of slopes in weak and strong beds, away from the outlet and the divide.
        let mut slopes = [(0.0, 0.0); 2];
        for step in 0..2400 {
            // The land rises and takes its beds along.
            let risen = uplift * 1000.0 * f64::from(step);
            let bed = |k: i32| (risen - thick * f64::from(k), if k.rem_euclid(2) == 0 { weak } else { strong });
            let beds: Vec<_> = (-25..=80).map(bed).collect();
            expose(&mut w, &beds);
            run(&mut w, p.clone(), 1);
            if step < 1200 || step % 20 != 0 {
                continue;
            }
            let (z, rock) = (heights(&w), w.get("erodibility").unwrap());
            for x in 100..cells - 100 {
                let of = &mut slopes[usize::from(rock.get(x, 0) < 1.0)];
                of.0 += (z[x + 1] - z[x - 1]) / (2.0 * cell_m);
                of.1 += 1.0;
            }
        }
        let [in_weak, in_strong] = slopes.map(|(sum, count)| sum / count);
        let want = f64::from(strong / weak).powf(1.0 / (f64::from(n) - 1.0));
        println!(
            "n {n}: {in_weak:.3} in weak beds, {in_strong:.3} in strong ones: {:.2}, {want:.2} wanted",
            in_weak / in_strong
        );
        assert!(((in_weak / in_strong).ln() / want.ln() - 1.0).abs() < 0.35, "n {n}: {in_weak} over {in_strong}");
    }
}

fn moved(a: &World, b: &World) -> f64 {
    let (a, b) = (a.get("height").unwrap(), b.get("height").unwrap());
    a.iter().zip(b.iter()).map(|(a, b)| f64::from((a - b).abs())).sum()
}

#[test]
fn slopes_and_the_seabed_move_by_their_rock() {
    let mut start = hills();
    start.layer_mut("height").unwrap().field.rows_mut().flatten().for_each(|h| *h *= 4.0);
    start.sea_level_m = 200.0;
    start.ensure(&LIMESTONE, 0.0);
    type Make = fn(bool) -> Box<dyn Process>;
    let all: [(&str, Make); 3] = [
        ("seabed", |by_rock| Box::new(Seabed { by_rock, ..Seabed::default() })),
        ("thermal", |by_rock| Box::new(Thermal { by_rock, ..Thermal::default() })),
        ("inverted", |by_rock| Box::new(Thermal { by_rock, inverted: true, ..Thermal::default() })),
    ];
    for (name, make) in all {
        let after = |by_rock: bool, factor: f32| {
            let mut w = of_rock(&start, factor);
            run_boxed(&mut w, make(by_rock), 1);
            w
        };
        let plain = after(false, 0.25);
        assert!(moved(&start, &plain) > 100.0, "{name} moves the ground");
        assert!(after(true, 1.0).get("height") == plain.get("height"), "{name}: loose ground is as it was");
        assert!(
            after(true, 7.0).get("height") == plain.get("height"),
            "{name}: soft rock is no faster than loose ground"
        );
        assert!(after(true, -1.0).get("height") == start.get("height"), "{name}: a factor below 0 is 0");
        let quarter = moved(&start, &after(true, 0.25)) / moved(&start, &plain);
        assert!((quarter - 0.25).abs() < 1e-3, "{name}: {quarter}");
        // Hard rock in the west, and nothing is lost where it ends.
        let mut w = start.clone();
        w.put(&ERODIBILITY, Field::from_fn(40, 30, |x, _| if x < 20 { 0.05 } else { 1.0 })).unwrap();
        run_boxed(&mut w, make(true), 200);
        let sum = |w: &World| w.get("height").unwrap().sum();
        let lost = sum(&w) - sum(&start) - w.ledger.net("ground") / 100.0;
        assert!((lost / sum(&start)).abs() < 1e-9, "{name}: {lost} m");
    }
}
