//! The flow of ice against what is known of it.

use crate::common::{layer, run, world};
use eyot_core::{Boundary, Field};
use eyot_ice::{GLACIER, Glaciers};

/// Ice that only flows.
fn still() -> Glaciers {
    Glaciers { years: 0.0, gradient: 0.0, sliding: 0.0, aspect: 0.0, repose: 89.0, ..Glaciers::default() }
}

/// Thickness of Halfar's dome, m, `t` times as old as when it was 1000 m high and had a radius of 20 km; its age then, years.
fn halfar(t: f64, r_m: f64, softness: f64) -> (f64, f64) {
    let (h0, r0) = (1000.0_f64, 20_000.0_f64);
    let gamma = 0.4 * softness * (910.0 * 9.81_f64).powi(3);
    let age = (7.0f64 / 4.0).powi(3) * r0.powi(4) / (18.0 * gamma * h0.powi(7));
    let inner = 1.0 - (r_m / (r0 * t.powf(1.0 / 18.0))).powf(4.0 / 3.0);
    (h0 * t.powf(-1.0 / 9.0) * inner.max(0.0).powf(3.0 / 7.0), age)
}

#[test]
fn halfars_dome_is_met_within_two_percent() {
    let (size, cell) = (96usize, 500.0);
    let glaciers = still();
    let from_centre = |x: usize, y: usize| {
        let d = |i: usize| (i as f64 + 0.5 - size as f64 / 2.0) * cell;
        d(x).hypot(d(y))
    };
    let dome = |t: f64| move |x: usize, y: usize| halfar(t, from_centre(x, y), glaciers.softness).0 as f32;
    let age = halfar(1.0, 0.0, glaciers.softness).1;
    let mut world = world((size, size), cell, Boundary::CLOSED, |_, _| 0.0);
    world.put(&GLACIER, Field::from_fn(size, size, dome(1.0))).unwrap();
    // Until it is three times as old.
    let glaciers = Glaciers { ice_years: (2.0 * age) as f32, time_step: (age / 200.0) as f32, ..glaciers.clone() };
    run(&mut world, &glaciers, 1).unwrap();
    let ice = layer(&world, "glacier");
    let (mut off, mut worst, mut sum) = (0.0f64, 0.0f64, 0.0f64);
    for y in 0..size {
        for x in 0..size {
            let exact = f64::from(dome(3.0)(x, y));
            let error = f64::from(ice[y * size + x]) - exact;
            off += error.abs();
            sum += exact;
            if from_centre(x, y) < 18_000.0 {
                worst = worst.max(error.abs() / 1000.0);
            }
        }
    }
    println!("age {age} a; mean error over mean thickness {}, worst over height {worst}", off / sum);
    assert!(off / sum < 0.02, "sum of errors over volume: {}", off / sum);
    assert!(worst < 0.02, "worst error within 18 km over the height at the start: {worst}");
}

#[test]
fn a_dome_over_the_seams_of_a_ring_is_that_in_the_middle() {
    let (w, h) = (40usize, 36usize);
    let dome = |cx: f64, cy: f64| {
        let mut world = world((w, h), 500.0, Boundary::WRAP, |_, _| 100.0);
        let near = |d: f64, n: usize| d.abs().min(n as f64 - d.abs());
        let thick = |x: usize, y: usize| {
            let (dx, dy) = (near(x as f64 + 0.5 - cx, w), near(y as f64 + 0.5 - cy, h));
            (400.0 - 12.0 * (dx * dx + 2.0 * dy * dy)).max(0.0) as f32
        };
        world.put(&GLACIER, Field::from_fn(w, h, thick)).unwrap();
        run(&mut world, &Glaciers { ice_years: 100.0, sliding: 3e-14, ..still() }, 1).unwrap();
        layer(&world, "glacier")
    };
    let (middle, seam) = (dome(20.0, 18.0), dome(0.0, 0.0));
    for y in 0..h {
        for x in 0..w {
            let (a, b) = (middle[y * w + x], seam[(y + 18) % h * w + (x + 20) % w]);
            assert!((a - b).abs() < 0.5, "{a} and {b} m at {x}, {y}");
        }
    }
}
