//! Worlds as a whole: symmetry, bounds, seeds and threads, and what single processes do to them.

use common::{CYLINDER, fill, mirrored_land, planet, random, run};
use eyot_climate::*;
use eyot_core::process::Scheduled;
use eyot_core::{Boundary, Control, Field, World};
use eyot_testing::climate::world;
use eyot_testing::one;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::{Value, json};

use crate::common;

/// All processes with some parameters changed, by process name.
fn world_with(change: impl Fn(&str, &mut Value)) -> Vec<Scheduled> {
    let made = PROCESSES.iter().map(|e| {
        let mut parameters = (e.defaults)();
        change(e.name, &mut parameters);
        Scheduled { name: e.name, process: (e.make)(parameters).unwrap(), every: 1 }
    });
    made.collect()
}

/// A world whose land, year and eddies are mirrored stays mirrored: the southern spring begins half a year later, and
/// mirrored eddies turn and drift the other way.
#[test]
fn mirrored_worlds_stay_mirrored() {
    const HALF_YEAR: u64 = 400;
    const STEPS: u64 = 600;
    let halves = |mirrored: bool| {
        let mut w = planet(96, CYLINDER);
        let hours = HALF_YEAR as f64 * units::hours_per_step(&w.grid);
        let processes = world_with(|name, p| {
            if p.get("year").is_some() {
                p["year"] = json!(2.0 * hours);
            }
            if name == "temperature" {
                // It is the same hour of the day in both, and one sun beside the seasons shows which way is north.
                p["rotation_speed"] = json!(0.0);
                p["sun_angle"] = json!(if mirrored { -5.0 } else { 5.0 });
            }
            if name == "wind" && mirrored {
                p["wind_speed"] = json!(-p["wind_speed"].as_f64().unwrap());
            }
        });
        let mut land = mirrored_land(96);
        // Only one half has this continent.
        fill(&mut w, &processes, "height", |x, y| {
            let (dx, dy) = (x as f32 - 40.0, if mirrored { 47.0 - y as f32 } else { y as f32 } - 12.0);
            land(x, y) + 2500.0 * (-(dx * dx + dy * dy) / 40.0).exp()
        });
        let eddy = |x: usize, y: usize| {
            let (u, v) = (x as f32 / 96.0 * std::f32::consts::TAU, (y + 1) as f32 / 48.0 * std::f32::consts::TAU);
            3.0 * v.sin() * ((3.0 * u).sin() + (5.0 * u + v).cos())
        };
        fill(&mut w, &processes, "turbulence", |x, y| match (mirrored, y) {
            // Corners lie on edges of rows: those of the poles and the equator are still.
            (_, 23 | 47) => 0.0,
            (true, y) => -eddy(x, 46 - y),
            (false, y) => eddy(x, y),
        });
        w.step = if mirrored { HALF_YEAR } else { 0 };
        run(&mut w, &processes, STEPS);
        w
    };
    let (north, south) = (halves(false), halves(true));
    for l in north.layers() {
        let other = south.get(&l.spec.name).unwrap();
        let (low, high) = l.field.min_max();
        let (mut worst, mut apart): (f32, usize) = (0.0, 0);
        for y in 0..48 {
            for x in 0..96 {
                let (a, b) = match &*l.spec.name {
                    // Southern faces are the northern ones of the mirror, and flow the other way.
                    "wind_y" | "flow_y" | "turbulence" if y == 47 => continue,
                    "wind_y" | "flow_y" | "turbulence" => (l.field.get(x, y), -other.get(x, 46 - y)),
                    // Swings are with the northern year.
                    n if n.ends_with("_cos") || n.ends_with("_sin") => (l.field.get(x, y), -other.get(x, 47 - y)),
                    _ => (l.field.get(x, y), other.get(x, 47 - y)),
                };
                worst = worst.max((a - b).abs());
                apart += usize::from((a - b).abs() > 1e-3 * (high - low).max(1e-6));
            }
        }
        println!("{}: {worst} of {low}..{high}, {apart} cells apart", l.spec.name);
        assert!(apart <= 5, "{}: {apart} cells differ, by {worst} of {low}..{high}", l.spec.name);
    }
    let swing = north.get("temperature_sin").unwrap();
    let of = |y: usize| swing.row(y).iter().sum::<f32>() / 96.0;
    assert!(of(8) > 3.0 && of(39) < -3.0, "seasons swing: {} {}", of(8), of(39));
    let t = north.get("temperature").unwrap();
    // It ends in the northern winter.
    assert!(t.row(6).iter().sum::<f32>() < t.row(41).iter().sum::<f32>() - 96.0, "both halves are in one season");
}

/// Random values of all parameters within their ranges, on small planets.
#[test]
fn nothing_leaves_its_bounds() {
    let mut runner = TestRunner::new_with_rng(
        Config { cases: 60, failure_persistence: None, ..Config::default() },
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    let dice = (proptest::collection::vec(0.0f64..1.0, 64), 0usize..3);
    runner
        .run(&dice, |(dice, rim)| {
            let drawn = std::cell::Cell::new(0);
            let processes = world_with(|name, p| {
                let schema = PROCESSES.iter().find(|e| e.name == name).unwrap().schema;
                let schema = schema().to_value();
                for (key, value) in p.as_object_mut().unwrap().iter_mut() {
                    let rule = &schema["properties"][key];
                    let (Some(low), Some(high)) = (rule["minimum"].as_f64(), rule["maximum"].as_f64()) else {
                        continue;
                    };
                    let u = dice[drawn.replace(drawn.get() + 1) % dice.len()];
                    // The ends are the hardest.
                    let u = if u < 0.25 {
                        0.0
                    } else if u > 0.75 {
                        1.0
                    } else {
                        2.0 * u - 0.5
                    };
                    *value = if value.is_f64() {
                        json!(low + u * (high - low))
                    } else {
                        json!((low + u * (high - low)) as u64)
                    };
                }
            });
            let rims = [CYLINDER, Boundary::WRAP, Boundary::OPEN];
            let mut w = planet(32, rims[rim]);
            fill(&mut w, &processes, "height", |x, y| 12_000.0 * (random(1, x, y) - 0.6));
            run(&mut w, &processes, 150);
            for l in w.layers() {
                if let Some((x, y, v)) = l.field.find_not_finite() {
                    panic!("{} is {v} at ({x}, {y})", l.spec.name);
                }
                let (low, high) = l.field.min_max();
                // Ground that moves has no bounds of its own but those of what was there.
                if l.spec.name != "height" {
                    prop_assert!(low >= l.spec.range.0 && high <= l.spec.range.1, "{} is {low}..{high}", l.spec.name);
                }
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn threads_change_nothing_and_seeds_do() {
    let fingerprint = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let processes = world();
            let mut w = planet(90, CYLINDER);
            w.seed = seed;
            fill(&mut w, &processes, "height", mirrored_land(90));
            run(&mut w, &processes, 120);
            w.fingerprint()
        })
    };
    let one = fingerprint(1, 5);
    assert_eq!([2, 3, 8].map(|n| fingerprint(n, 5)), [one; 3]);
    assert_ne!(fingerprint(1, 6), one);
}

/// Going on from where a simulation ended is the same as not having stopped.
#[test]
fn spans_change_nothing() {
    use eyot_core::engine::CpuEngine;
    use eyot_core::process::Span;
    let processes = world();
    let span = |w: &mut World, from: u64, steps: u64| {
        CpuEngine::default().simulate(w, &processes, Span { from, steps }, &Control::none()).unwrap();
    };
    let mut whole = planet(64, CYLINDER);
    fill(&mut whole, &processes, "height", mirrored_land(64));
    let mut parts = whole.clone();
    span(&mut whole, 0, 60);
    span(&mut parts, 0, 23);
    span(&mut parts, 23, 37);
    assert_eq!(whole.fingerprint(), parts.fingerprint());
}

/// The order of the processes matters little: a step is short.
#[test]
fn another_order_makes_the_same_world() {
    let settle = |backwards: bool| {
        let mut processes = world();
        if backwards {
            processes.reverse();
        }
        let mut w = planet(64, CYLINDER);
        fill(&mut w, &world(), "height", mirrored_land(64));
        run(&mut w, &processes, 600);
        w
    };
    let (a, b) = (settle(false), settle(true));
    for (layer, tolerance) in [("temperature_mean", 0.5), ("rain_mean", 40.0)] {
        let difference = a.get(layer).unwrap().iter().zip(b.get(layer).unwrap().iter()).map(|(x, y)| (x - y).abs());
        let mean = difference.sum::<f32>() / (64.0 * 32.0);
        assert!(mean < tolerance, "{layer}: {mean}");
    }
}

fn settled(processes: &[Scheduled], steps: u64, height: impl FnMut(usize, usize) -> f32) -> World {
    let mut w = planet(64, CYLINDER);
    fill(&mut w, processes, "height", height);
    run(&mut w, processes, steps);
    w
}

fn row_mean(f: &Field, y: usize) -> f32 {
    f.row(y).iter().sum::<f32>() / f.width() as f32
}

/// Without wind, season and night, temperature settles at the balance of the sun and falls by the lapse with height.
#[test]
fn it_gets_colder_with_height_and_latitude() {
    let still = Temperature {
        day_night: 0.0,
        mixing: 0.0,
        storms: 0.0,
        contrast: 1.0,
        currents: 0.0,
        wet_cooling: 0.0,
        sun_strength: -0.17,
        seasons: sky::Seasons { tilt: 0.0, year: 0.0 },
        ..Default::default()
    };
    let w = settled(&[one(still)], 800, |x, _| if x < 32 { 0.0 } else { 4000.0 });
    let t = w.get("temperature").unwrap();
    for y in 0..32 {
        let s = ((31.0 - 2.0 * y as f32) * std::f32::consts::FRAC_PI_2 / 32.0).sin();
        let want = 12.0 + 24.0 * (1.0 - 0.17 - s * s - s * s * s * s);
        assert!((t.get(3, y) - want).abs() < 0.01, "row {y}: {} instead of {want}", t.get(3, y));
        assert!((t.get(3, y) - t.get(40, y) - 26.0).abs() < 0.01, "4000 m cool by 26 degrees");
    }
}

/// The temperature of a place on land repeats after a day, and not before.
#[test]
fn a_day_lasts_as_long_as_it_should() {
    let day = Temperature {
        seasons: sky::Seasons { tilt: 0.0, year: 0.0 },
        rotation_speed: 0.262,
        response: 6.0,
        ..Default::default()
    };
    let processes = [one(day)];
    // Cells of a length that makes a step half an hour.
    let hours = 0.5;
    let cell = hours * 3600.0 * 10.0 / 0.2;
    let grid = eyot_core::Grid::new(64, 32, cell, CYLINDER, &eyot_core::Limits::default()).unwrap();
    let mut w = World::new(grid, 1);
    fill(&mut w, &processes, "height", |_, _| 10.0);
    let series: Vec<f32> = (0..400)
        .map(|_| {
            run(&mut w, &processes, 1);
            w.get("temperature").unwrap().get(20, 16)
        })
        .collect();
    let late = &series[200..];
    let (low, high) = late.iter().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    assert!(high - low > 1.0, "{low}..{high}");
    let apart = |steps: usize| late.windows(steps + 1).map(|w| (w[steps] - w[0]).abs()).fold(0.0, f32::max);
    // A day of 23.98 h: 48 steps.
    assert!(apart(48) < 0.1 * (high - low), "{}", apart(48));
    assert!(apart(24) > 0.8 * (high - low) && apart(40) > 0.3 * (high - low));
}

/// A stopped clock: one side stays dark and freezes.
#[test]
fn a_locked_world_has_a_frozen_side() {
    let processes = world_with(|name, p| {
        if name == "temperature" {
            p["rotation_speed"] = json!(0.0);
            p["day_night"] = json!(-2.0);
        }
    });
    let w = settled(&processes, 1200, |_, _| -100.0);
    let (t, ice) = (w.get("temperature").unwrap(), w.get("ice").unwrap());
    // Noon is at column 0.
    assert!(t.get(0, 16) > 20.0 && t.get(32, 16) < -5.0, "{} {}", t.get(0, 16), t.get(32, 16));
    assert!(ice.get(0, 16) == 0.0 && ice.get(32, 16) > 0.5);
}

/// Winter and summer: half a year apart the hemispheres change places, and the climate knows by how much.
#[test]
fn seasons_swing_opposite_in_the_hemispheres() {
    let processes = world();
    let w = settled(&processes, 700, |x, _| if (20..44).contains(&x) { 200.0 } else { -3000.0 });
    let swing = w.get("temperature_sin").unwrap();
    assert!(swing.get(32, 7) > 3.0 && swing.get(32, 24) < -3.0, "{} {}", swing.get(32, 7), swing.get(32, 24));
    assert!(swing.get(32, 7) > 1.5 * swing.get(4, 7), "land swings more than the sea");
    let t = w.get("temperature_mean").unwrap();
    assert!(row_mean(t, 16) > row_mean(t, 0) + 25.0);
}

/// A ridge across the wind: wet where it comes from, dry behind.
#[test]
fn mountains_cast_a_rain_shadow() {
    let processes = world_with(|name, p| {
        if name == "wind" {
            p["distortion"] = json!(0.0);
        }
    });
    let mut w = planet(128, CYLINDER);
    // A wide continent with a range near its western shore, in the westerlies.
    let land = |x: usize| match x {
        45..47 => 3500.0,
        40..90 => 200.0,
        _ => -3000.0,
    };
    fill(&mut w, &processes, "height", |x, _| land(x));
    run(&mut w, &processes, 2500);
    let rain = w.get("rain_mean").unwrap();
    let mean = |columns: std::ops::Range<usize>| {
        let cells = columns.flat_map(|x| (11..17).map(move |y| (x, y)));
        let v: Vec<f32> = cells.map(|(x, y)| rain.get(x, y)).collect();
        v.iter().sum::<f32>() / v.len() as f32
    };
    let (windward, lee) = (mean(42..46), mean(48..54));
    assert!(lee < 0.6 * windward, "{windward} mm before the mountains, {lee} mm behind");
}

/// Water on a slope runs down, fills a hollow and stays there.
#[test]
fn water_runs_down_and_stands_in_hollows() {
    let processes = [one(Water { evaporate: 0.0, ..Default::default() })];
    let mut w = planet(32, Boundary::CLOSED);
    w.sea_level_m = -1e4;
    fill(&mut w, &processes, "height", |x, y| ((x as f32 - 16.0).abs() + (y as f32 - 8.0).abs()) * 100.0);
    fill(&mut w, &processes, "water", |_, _| 1.0);
    run(&mut w, &processes, 2000);
    let d = w.get("water").unwrap();
    assert!(d.get(16, 8) > 100.0 && d.get(0, 0) < 1e-3, "{} {}", d.get(16, 8), d.get(0, 0));
    // A level surface.
    let h = w.get("height").unwrap();
    let surface = |x: usize, y: usize| h.get(x, y) + d.get(x, y);
    assert!((surface(16, 8) - surface(17, 8)).abs() < 1.0, "{} {}", surface(16, 8), surface(17, 8));
}

/// Rock weathers between the limits alone, and not under water.
#[test]
fn rock_weathers_between_its_limits() {
    let processes = [one(Weathering { min_difference: 300.0, max_difference: 3000.0, strength: 1.0 })];
    let mut w = planet(32, Boundary::CLOSED);
    fill(&mut w, &processes, "height", |x, y| match (x, y) {
        (4, 4) => 200.0,
        (12, 4) => 1000.0,
        (20, 4) => 5000.0,
        (28, 4) => 1000.0,
        _ => 0.0,
    });
    fill(&mut w, &processes, "water", |x, _| if x > 24 { 1.0 } else { 0.0 });
    run(&mut w, &processes, 20);
    let h = w.get("height").unwrap();
    assert_eq!([h.get(4, 4), h.get(20, 4), h.get(28, 4)], [200.0, 5000.0, 1000.0]);
    assert!(h.get(12, 4) < 900.0 && h.get(13, 4) > 10.0);
}
