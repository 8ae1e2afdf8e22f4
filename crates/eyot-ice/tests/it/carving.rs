//! What ice makes of a valley that a river cut.

use crate::common::{layer, run, world};
use eyot_core::{Boundary, World};
use eyot_ice::Glaciers;

const SIZE: (usize, usize) = (96, 160);
const CELL_M: f64 = 80.0;

/// A V-shaped valley that falls to the south, between ridges.
fn valley() -> World {
    world(SIZE, CELL_M, Boundary::OPEN, |x, y| {
        let side = (x as f32 - 47.5).abs() * 80.0;
        let way = y as f32 * 80.0;
        2900.0 - 0.04 * way + 0.5 * side.min(2400.0) - 0.25 * (side - 2400.0).max(0.0)
    })
}

/// The exponent of the valley's sides, by least squares of the logarithms, from 10 to 70 % of the walls' height.
fn exponent(height: &[f32], y: usize) -> f64 {
    let row = &height[y * SIZE.0..(y + 1) * SIZE.0];
    let inner = &row[18..78];
    let low = inner.iter().copied().fold(f32::MAX, f32::min);
    let top = inner[0].min(inner[59]);
    // The middle of the floor.
    let floor: Vec<usize> = (0..60).filter(|&i| inner[i] - low < 0.1 * (top - low)).collect();
    let at = (floor[0] + floor[floor.len() - 1]) as f64 / 2.0;
    let (mut n, mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, z) in inner.iter().enumerate() {
        let share = (z - low) / (top - low);
        let side = (i as f64 - at).abs();
        if (0.1..0.7).contains(&share) && side > 0.0 {
            let (x, y) = (side.ln(), f64::from(z - low).ln());
            (n, sx, sy, sxx, sxy) = (n + 1.0, sx + x, sy + y, sxx + x * x, sxy + x * y);
        }
    }
    (n * sxy - sx * sy) / (n * sxx - sx * sx)
}

#[test]
fn a_v_becomes_a_u_with_basins_and_moraines() {
    let mut world = valley();
    let before = layer(&world, "height");
    let b = exponent(&before, 70);
    assert!((0.9..1.15).contains(&b), "a V has {b}");
    let carve = Glaciers { ela: 2900.0, ice_years: 40.0, years: 10_000.0, time_step: 1.0, ..Glaciers::default() };
    run(&mut world, &Glaciers { ice_years: 150.0, years: 0.0, ..carve.clone() }, 1).unwrap();
    run(&mut world, &carve, 20).unwrap();
    let away = Glaciers { ela: 3200.0, ela_change: 400.0, years: 500.0, ..carve };
    run(&mut world, &away, 5).unwrap();
    let (height, eroded) = (layer(&world, "height"), layer(&world, "glacial_erosion"));
    let moraine = layer(&world, "moraine").into_iter().fold(0.0f32, f32::max);
    let ice: f32 = layer(&world, "glacier").iter().sum();
    let found: Vec<f64> = (40..110).step_by(10).map(|y| exponent(&height, y)).collect();
    let mut sorted = found.clone();
    sorted.sort_by(f64::total_cmp);
    // How far the floor rises again downstream.
    let floor: Vec<f32> = (0..SIZE.1)
        .map(|y| height[y * SIZE.0..(y + 1) * SIZE.0][24..72].iter().copied().fold(f32::MAX, f32::min))
        .collect();
    let (mut low, mut basin) = (f32::MAX, 0.0f32);
    for z in &floor {
        low = low.min(*z);
        basin = basin.max(z - low);
    }
    let deepest = eroded.iter().copied().fold(0.0f32, f32::max);
    println!("b {found:.2?}; basin {basin} m; moraine {moraine} m; eroded {deepest} m; ice left {ice}");
    assert!(sorted[sorted.len() / 2] >= 1.5, "exponents {found:?}");
    assert!(basin >= 5.0, "deepest basin {basin} m");
    assert!((5.0..=50.0).contains(&moraine), "highest moraine {moraine} m");
    assert!(ice < 1.0, "{ice} m of ice are left");
}
