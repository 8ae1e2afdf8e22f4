//! Wind carries what it should, where it should.

use common::{CYLINDER, fill, planet, run};
use eyot_climate::units::FULL_WIND_CELLS;
use eyot_climate::{Humidity, Temperature, Wind};
use eyot_core::process::Scheduled;
use eyot_core::{Boundary, World};
use eyot_testing::one;

use crate::common;

/// Nothing but transport.
fn air() -> Scheduled {
    one(Humidity {
        water_add: 0.0,
        land_dry: 0.0,
        land_add: 0.0,
        ice_dry: 0.0,
        mixing: 0.0,
        storms: 0.0,
        ..Default::default()
    })
}

/// Column of the middle of mass of a layer on a ring of `width`, by the phase of its first harmonic.
fn middle(world: &World, layer: &str) -> f64 {
    let f = world.get(layer).unwrap();
    let width = world.grid.width as f64;
    let (mut c, mut s) = (0.0, 0.0);
    for row in f.rows() {
        for (x, v) in row.iter().enumerate() {
            let a = std::f64::consts::TAU * x as f64 / width;
            (c, s) = (c + f64::from(*v) * a.cos(), s + f64::from(*v) * a.sin());
        }
    }
    s.atan2(c).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU * width
}

#[test]
fn a_blob_keeps_its_mass_and_moves_with_the_wind() {
    for (wind, steps) in [(10.0f32, 100u64), (-5.0, 120)] {
        let processes = [air()];
        let mut world = planet(128, Boundary::WRAP);
        fill(&mut world, &processes, "wind_x", |_, _| wind);
        // So hot that nothing rains.
        fill(&mut world, &processes, "temperature", |_, _| 290.0);
        fill(&mut world, &processes, "humidity", |x, y| {
            let (dx, dy) = (x as f32 - 64.0, y as f32 - 32.0);
            0.1 * (-(dx * dx + dy * dy) / 50.0).exp()
        });
        let before = world.get("humidity").unwrap().iter().map(f64::from).sum::<f64>();
        let from = middle(&world, "humidity");
        run(&mut world, &processes, steps);
        let after = world.get("humidity").unwrap().iter().map(f64::from).sum::<f64>();
        // What still rains is counted.
        let rained = world.ledger.amount("humidity.rained")
            / f64::from(eyot_climate::units::AIR_WATER)
            / world.grid.cell_area_m2();
        assert!((after + rained - before).abs() < 1e-5 * before, "{before} became {after} and {rained} of rain");
        assert!(rained < 1e-3 * before, "{rained} of {before} rained");
        let cells = f64::from(FULL_WIND_CELLS * wind / 10.0) * steps as f64;
        let moved = (middle(&world, "humidity") - from + 192.0).rem_euclid(128.0) - 64.0;
        assert!((moved - cells).abs() < 0.02 * cells.abs(), "moved {moved} cells instead of {cells}");
    }
}

/// In an even wind, temperature moves as matter does: as a property it needs no mass.
#[test]
fn warmth_moves_with_the_wind() {
    let still = Temperature { response: 1e4, sea_slowness: 100.0, mixing: 0.0, storms: 0.0, ..Default::default() };
    let processes = [one(still)];
    let mut world = planet(128, CYLINDER);
    fill(&mut world, &processes, "wind_x", |_, _| 10.0);
    fill(&mut world, &processes, "height", |_, _| -100.0);
    fill(&mut world, &processes, "temperature", |x, _| if (40..60).contains(&x) { 50.0 } else { 0.0 });
    let from = middle(&world, "temperature");
    run(&mut world, &processes, 100);
    let moved = middle(&world, "temperature") - from;
    assert!((moved - 20.0).abs() < 1.0, "{moved} cells instead of 20");
}

#[test]
fn no_wind_crosses_a_closed_pole_and_none_is_too_strong() {
    let wild = Wind {
        global_wind: 2.0,
        distortion: 2.0,
        local_pressure: 2.0,
        roughness: 8.0,
        turbulence: 20,
        ..Default::default()
    };
    let processes = [one(wild)];
    let mut world = planet(64, CYLINDER);
    fill(&mut world, &processes, "height", |x, y| if (x / 3 + y / 5) % 2 == 0 { 9000.0 } else { -9000.0 });
    run(&mut world, &processes, 50);
    let [x, y] = ["wind_x", "wind_y"].map(|l| world.get(l).unwrap());
    assert!(y.row(31).iter().all(|v| *v == 0.0));
    assert!(x.iter().chain(y.iter()).all(|v| v.abs() <= 10.0) && x.iter().any(|v| v.abs() > 5.0));
}

/// Eddies neither gather nor part air: what flows into a cell flows out of it.
#[test]
fn eddies_have_no_divergence() {
    let eddies = Wind { global_wind: 0.0, distortion: 0.3, local_pressure: 0.0, monsoon: 0.0, ..Default::default() };
    let processes = [one(eddies)];
    let mut world = planet(64, CYLINDER);
    run(&mut world, &processes, 30);
    let [u, v] = ["wind_x", "wind_y"].map(|l| world.get(l).unwrap());
    let strongest = u.iter().chain(v.iter()).fold(0.0f32, |m, w| m.max(w.abs()));
    assert!(strongest > 1.0, "{strongest} m/s");
    for y in 3..29 {
        for x in 0..64 {
            let gathered = (u.get((x + 63) % 64, y) - u.get(x, y)) + (v.get(x, y - 1) - v.get(x, y));
            assert!(gathered.abs() < 0.05 * strongest, "({x}, {y}): {gathered} of {strongest} m/s");
        }
    }
}

/// V1: eddies that stay where they are part and gather no air (1e-4 of the wind over a cell), and wind over level ground of one warmth
/// is the same along a whole row (1e-6 of it). There is no projection whose rest could be larger, and belts follow the latitude, so that no
/// planet can be turned by a right angle; north and south are mirrors of each other (`worlds.rs`).
#[test]
fn wind_neither_gathers_nor_becomes_uneven() {
    let calm = Wind { distortion: 0.0, local_pressure: 0.0, monsoon: 0.0, wind_speed: 0.0, ..Default::default() };
    let eddies = [one(Wind { global_wind: 0.0, distortion: 0.3, ..calm.clone() })];
    let mut world = planet(64, CYLINDER);
    run(&mut world, &eddies, 60);
    let [u, v] = ["wind_x", "wind_y"].map(|l| world.get(l).unwrap());
    let strongest = u.iter().chain(v.iter()).fold(0.0f32, |m, w| m.max(w.abs()));
    let mut most = 0.0f32;
    for y in 8..24 {
        for x in 0..64 {
            most = most.max(((u.get((x + 63) % 64, y) - u.get(x, y)) + (v.get(x, y - 1) - v.get(x, y))).abs());
        }
    }
    println!("V1 divergence {:e}", most / strongest);
    assert!(strongest > 1.0 && most <= 1e-4 * strongest);

    let even = [one(calm)];
    let mut world = planet(64, CYLINDER);
    fill(&mut world, &even, "height", |_, _| -100.0);
    run(&mut world, &even, 60);
    let [u, v] = ["wind_x", "wind_y"].map(|l| world.get(l).unwrap());
    for row in u.rows().chain(v.rows()) {
        assert!(row.iter().all(|w| (w - row[0]).abs() <= 1e-6 * row[0].abs()), "{row:?}");
    }
    assert!(u.iter().any(|w| w.abs() > 5.0));
}

/// At full drift, eddies of both hemispheres move a cell in five steps, in opposite directions.
#[test]
fn eddies_drift_apart() {
    let processes = [one(Wind { wind_speed: 1.0, ..Default::default() })];
    let mut world = planet(64, CYLINDER);
    run(&mut world, &processes, 1);
    let before = world.get("turbulence").unwrap().clone();
    run(&mut world, &processes, 10);
    let after = world.get("turbulence").unwrap();
    for x in 0..64 {
        assert_eq!(after.get((x + 2) % 64, 8), before.get(x, 8));
        assert_eq!(after.get(x, 24), before.get((x + 2) % 64, 24));
    }
}
