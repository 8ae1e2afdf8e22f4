//! What is there in the end is what was there before, with what the ledger says.

use common::{CYLINDER, fill, mirrored_land, planet, random, run, volume};
use eyot_climate::units::AIR_WATER;
use eyot_climate::*;
use eyot_core::conformance::{random_world, rims};
use eyot_core::process::Scheduled;
use eyot_core::{Boundary, World};
use eyot_testing::climate::{climate_start, world};
use eyot_testing::one;

use crate::common;

/// Depth of the water in full soil, m.
const SOIL_M: f64 = 0.016;

/// Fails unless the layer's change is what the ledger says, within `share` of all that was or moved.
fn assert_closed(before: &World, after: &World, layer: &str, factor: f64, share: f64, place: &str) {
    let (a, b) = (factor * volume(before, layer), factor * volume(after, layer));
    let turnover: f64 =
        after.ledger.iter().filter(|(n, _)| n.starts_with(&format!("{layer}."))).map(|(_, a)| a.amount.abs()).sum();
    let missing = (b - a - after.ledger.net(layer)).abs();
    assert!(turnover > 0.0, "{layer} has no accounts; {place}");
    assert!(missing <= share * (a.abs() + turnover), "{layer}: {a} to {b}, {missing} unaccounted for; {place}");
}

fn check(processes: &[Scheduled], layers: &[(&str, f64)]) {
    for (i, rim) in rims().into_iter().enumerate() {
        let before = random_world((33, 26), rim, 3 + i as u64, processes, &climate_start).unwrap();
        let mut after = before.clone();
        run(&mut after, processes, 200);
        for &(layer, factor) in layers {
            assert_closed(&before, &after, layer, factor, 2e-6, &format!("{rim:?}"));
        }
    }
}

#[test]
fn water_with_rain_evaporation_and_drainage() {
    check(&[one(Water { rain: 2.0, evaporate: 2.0, ..Default::default() })], &[("water", 1.0)]);
}

#[test]
fn ice_with_freezing_melting_and_calving() {
    check(&[one(Ice { flow: 0.25, freeze: 10.0, melt: 10.0, ..Default::default() })], &[("ice", 1.0), ("water", 1.0)]);
}

#[test]
fn sand_with_erosion() {
    check(&[one(Sand { erode: 2.0, slump: 2.0 })], &[("sand", 1.0)]);
}

#[test]
fn humidity_with_uptake_rain_and_drying() {
    check(
        &[one(Humidity { water_add: 5.0, land_add: 2.0, land_dry: 5.0, ..Default::default() })],
        &[("humidity", f64::from(AIR_WATER)), ("soil_moisture", SOIL_M)],
    );
}

/// All processes on a planet: nothing is lost between them either.
#[test]
fn a_world_with_everything() {
    let processes = world();
    let mut before = planet(128, CYLINDER);
    fill(&mut before, &processes, "height", mirrored_land(128));
    let mut after = before.clone();
    for l in processes.iter().flat_map(|p| p.process.layers()) {
        let (spec, value) = (l.spec, l.start);
        before.ensure(&spec, value);
    }
    run(&mut after, &processes, 1500);
    for (layer, factor) in
        [("water", 1.0), ("ice", 1.0), ("sand", 1.0), ("humidity", f64::from(AIR_WATER)), ("soil_moisture", SOIL_M)]
    {
        assert_closed(&before, &after, layer, factor, 1e-5, "planet");
    }
    assert!(after.ledger.amount("water.melted") > 0.0 && after.ledger.amount("water.frozen") > 0.0);
    assert!(after.ledger.amount("sand.eroded") > 0.0);
}

/// Ground that crumbles and sand that moves change nothing in sum.
#[test]
fn ground_is_conserved_on_a_ring() {
    let processes =
        [one(Weathering { min_difference: 1.0, max_difference: 500.0, strength: 5.0 }), one(Sand::default())];
    let mut world = planet(64, Boundary::WRAP);
    world.sea_level_m = -1e4;
    fill(&mut world, &processes, "height", |x, y| 300.0 * random(1, x, y));
    fill(&mut world, &processes, "sand", |x, y| 5.0 * random(2, x, y));
    let before = volume(&world, "height");
    let start = world.get("height").unwrap().clone();
    run(&mut world, &processes, 500);
    assert!((volume(&world, "height") - before).abs() < 1e-6 * before);
    assert_ne!(&start, world.get("height").unwrap());
}

/// S1, as far as there is such sand: no wind moves it here, so that there are neither dunes nor their shadows (S2). Without water a heap
/// slumps and does nothing else: no sand is made or lost, the rock below stays, the heap gets lower and nothing rises above what was
/// highest beside it.
#[test]
fn dry_sand_only_slumps() {
    let processes = [one(Sand::default())];
    let mut world = planet(64, Boundary::WRAP);
    world.sea_level_m = -1e4;
    let rock = |x: usize, y: usize| 50.0 * random(1, x / 4, y / 4);
    let sand = |x: usize, y: usize| (40.0 - 3.0 * (x as f32 - 30.0).hypot(y as f32 - 17.0)).max(0.0);
    fill(&mut world, &processes, "height", |x, y| rock(x, y) + sand(x, y));
    fill(&mut world, &processes, "sand", sand);
    let start = volume(&world, "sand");
    let mut top = world.get("height").unwrap().min_max().1;
    for _ in 0..20 {
        run(&mut world, &processes, 50);
        let now = world.get("height").unwrap().min_max().1;
        assert!(now <= top, "{now} m after {top} m");
        top = now;
    }
    let (height, sand) = (world.get("height").unwrap(), world.get("sand").unwrap());
    for y in 0..32 {
        for x in 0..64 {
            let left = height.get(x, y) - sand.get(x, y);
            assert!((left - rock(x, y)).abs() < 2e-3, "rock at ({x}, {y}): {left} of {}", rock(x, y));
        }
    }
    let change = volume(&world, "sand") / start - 1.0;
    println!("S1 sand {change:e}, highest {top} m");
    assert!(change.abs() <= 1e-6);
    assert_eq!(world.ledger.amount("sand.eroded"), 0.0);
    assert!(sand.min_max().1 < 40.0, "it did slump: {}", sand.min_max().1);
}
