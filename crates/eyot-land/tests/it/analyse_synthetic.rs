//! The measures of landscapes whose values are known from theory.

use eyot_core::{Boundary, BoundaryCondition, Error, Field, Grid, Limits};
use eyot_land::analyse::{TerrainOptions, TerrainStats, spectral_beta, terrain_stats};
use proptest::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::PI;

fn grid(width: usize, height: usize, cell_m: f64, rim: Boundary) -> Grid {
    Grid::new(width, height, cell_m, rim, &Limits::default()).unwrap()
}

fn measure(z: &Field, grid: &Grid, sea_level_m: Option<f64>) -> TerrainStats {
    terrain_stats(z, grid, sea_level_m, &TerrainOptions::default(), &Limits::default()).unwrap()
}

struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Nearly Gaussian: the sum of twelve uniform numbers.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A corner of `n` x `n` cells of a periodic Gaussian surface of twice that side whose power falls as `k^-beta`.
fn gaussian_surface(n: usize, beta: f64, seed: u64) -> Field {
    let (m, mut random) = (2 * n, Random(seed));
    let mut a: Vec<Complex<f64>> = (0..m * m).map(|_| Complex::new(random.normal(), 0.0)).collect();
    let mut planner = FftPlanner::new();
    let transpose = |a: &[Complex<f64>]| -> Vec<_> { (0..m * m).map(|i| a[(i % m) * m + i / m]).collect() };
    planner.plan_fft_forward(m).process(&mut a);
    a = transpose(&a);
    planner.plan_fft_forward(m).process(&mut a);
    for (i, c) in a.iter_mut().enumerate() {
        let k = |i: usize| i.min(m - i) as f64;
        let k2 = k(i % m).powi(2) + k(i / m).powi(2);
        *c *= if k2 > 0.0 { k2.powf(-beta / 4.0) } else { 0.0 };
    }
    planner.plan_fft_inverse(m).process(&mut a);
    a = transpose(&a);
    planner.plan_fft_inverse(m).process(&mut a);
    Field::from_fn(n, n, |x, y| a[y * m + x].re as f32)
}

#[test]
fn spectral_surfaces_have_the_exponent_they_were_made_with() {
    for beta in [2.0, 3.0, 3.6, 4.0] {
        let g = grid(384, 384, 30.0, Boundary::CLOSED);
        let seeds = 8;
        let found =
            (1..=seeds).map(|s| spectral_beta(&gaussian_surface(384, beta, s), &g).unwrap().unwrap()).sum::<f64>();
        let found = found / seeds as f64;
        println!("beta made with {beta}, found {found}");
        assert!((found - beta).abs() < 0.1, "made with {beta}, found {found}");
    }
    let mut random = Random(5);
    let noise = Field::from_fn(512, 512, |_, _| random.normal() as f32);
    let beta = measure(&noise, &grid(512, 512, 1.0, Boundary::CLOSED), None).beta_2d.unwrap();
    assert!(beta.abs() < 0.1, "white noise: {beta}");
}

#[test]
fn oblong_cells_do_not_bend_the_spectrum() {
    // Every second row of a surface, as cells of twice the height.
    let g = grid(512, 256, 10.0, Boundary::CLOSED);
    let oblong = Grid { cell_y_m: 20.0, ..g };
    let square = grid(512, 512, 10.0, Boundary::CLOSED);
    let z = gaussian_surface(512, 3.4, 4);
    let thin = Field::from_fn(512, 256, |x, y| z.get(x, 2 * y));
    let (a, b) = (spectral_beta(&z, &square).unwrap().unwrap(), spectral_beta(&thin, &oblong).unwrap().unwrap());
    assert!((a - b).abs() < 0.1, "{a} on square, {b} on oblong cells");
}

#[test]
fn brownian_surfaces_have_h_one_half() {
    let mut sum = 0.0;
    for seed in 1..=4 {
        sum += measure(&gaussian_surface(256, 3.0, seed), &grid(256, 256, 30.0, Boundary::CLOSED), None).hurst.unwrap();
    }
    // The power beyond the grid's own frequency is missing, which smooths the shortest lags.
    assert!((sum / 4.0 - 0.5).abs() < 0.06, "{}", sum / 4.0);
}

#[test]
fn white_noise_has_a_pit_in_nine_cells() {
    let mut random = Random(1);
    let z = Field::from_fn(600, 600, |_, _| random.uniform() as f32);
    let s = measure(&z, &grid(600, 600, 10.0, Boundary::WRAP), None);
    assert!((s.pits_per_1000.unwrap() - 1000.0 / 9.0).abs() < 1.5, "{:?}", s.pits_per_1000);
    assert!(s.curvature_skew.unwrap().abs() < 0.02);
    assert!((s.hypsometric_integral.unwrap() - 0.5).abs() < 0.002);
    assert!(s.hurst.unwrap().abs() < 0.01);
}

#[test]
fn a_plane_is_a_plane() {
    let z = Field::from_fn(80, 60, |x, y| 100.0 + 6.0 * x as f32 + 8.0 * y as f32);
    let s = measure(&z, &grid(80, 60, 10.0, Boundary::OPEN), None);
    assert_eq!(s.slope_mean_deg, s.slope_p95_deg);
    assert!((s.slope_mean_deg.unwrap() - 45.0).abs() < 1e-5);
    assert_eq!((s.slope_skew, s.curvature_skew, s.beta_2d), (None, None, None));
    assert_eq!((s.pits_per_1000, s.depression_fraction, s.fill_mean_m), (Some(0.0), Some(0.0), Some(0.0)));
    assert!((s.hypsometric_integral.unwrap() - 0.5).abs() < 1e-6);
    assert!((s.hurst.unwrap() - 1.0).abs() < 1e-9);
    assert_eq!(s.landforms.unwrap().slope, 1.0);
    assert_eq!(s.relief_m, Some(6.0 * 79.0 + 8.0 * 59.0));
}

#[test]
fn a_cone_is_steep_everywhere_and_drains() {
    // tan = 0.5, tip in the middle; a third of the volume of the cylinder lies under it.
    let z = Field::from_fn(201, 201, |x, y| 500.0 - 5.0 * ((x as f32 - 100.0).hypot(y as f32 - 100.0)));
    let s = measure(&z, &grid(201, 201, 10.0, Boundary::CLOSED), Some(0.0));
    assert!((s.land_share - PI * 100.0 * 100.0 / (201.0 * 201.0)).abs() < 0.002);
    assert!((s.hypsometric_integral.unwrap() - 1.0 / 3.0).abs() < 0.003);
    assert!((s.slope_mean_deg.unwrap() - 0.5_f64.atan().to_degrees()).abs() < 0.05);
    assert_eq!((s.pits_per_1000, s.fill_mean_m), (Some(0.0), Some(0.0)));
    let forms = s.landforms.unwrap();
    assert!(forms.peak > 0.0 && forms.valley == 0.0 && forms.pit == 0.0);
}

#[test]
fn a_bowl_holds_its_volume() {
    // z = 0.02 r^2 spills where the border is nearest, at r = 600 m: depth 72 m, volume pi R^2 depth / 2.
    let (n, cell) = (121, 10.0);
    let z = Field::from_fn(n, n, |x, y| {
        let (dx, dy) = ((x as f32 - 60.0) * 10.0, (y as f32 - 60.0) * 10.0);
        0.0002 * (dx * dx + dy * dy)
    });
    let s = measure(&z, &grid(n, n, cell, Boundary::CLOSED), None);
    let (area, all) = (PI * 600.0 * 600.0, (n as f64 * cell).powi(2));
    let expected = area * 72.0 / 2.0 / all;
    assert!((s.fill_mean_m.unwrap() / expected - 1.0).abs() < 0.002, "{:?} {expected}", s.fill_mean_m);
    assert!((s.depression_fraction.unwrap() - area / all).abs() < 0.003);
    assert!((s.fill_over_relief.unwrap() - expected / 144.0).abs() < 0.001);
    assert!((s.pits_per_1000.unwrap() - 1000.0 / (119.0 * 119.0)).abs() < 1e-9);
}

#[test]
fn the_sea_floor_does_not_count_as_land() {
    let island = gaussian_surface(128, 3.4, 9);
    let (lo, hi) = island.min_max();
    let z = Field::from_fn(128, 128, |x, y| {
        let r = ((x as f32 - 64.0).hypot(y as f32 - 64.0) / 64.0).min(1.0);
        300.0 * (1.0 - r) - 40.0 + 150.0 * (island.get(x, y) - lo) / (hi - lo)
    });
    let g = grid(128, 128, 30.0, Boundary::CLOSED);
    let a = measure(&z, &g, Some(90.0));
    // Another floor: slopes and curvatures at the shore change, what lives on the land alone does not.
    let mut deep = z.clone();
    deep.map_in_place(|z| if z > 90.0 { z } else { 3.0 * z - 500.0 });
    let b = measure(&deep, &g, Some(90.0));
    let alone = |s: &TerrainStats| {
        let heights = (s.land_share, s.min_m, s.max_m, s.mean_m, s.hypsometric_integral, s.hurst, s.pits_per_1000);
        (heights, (s.depression_fraction, s.fill_mean_m, s.concavity, s.hack, s.horton_area, s.drainage_density_per_km))
    };
    assert_eq!(alone(&a), alone(&b));
    assert_eq!(a.landforms, b.landforms);
    assert!(a.land_share > 0.1 && a.land_share < 0.9);
    assert!(a.min_m.unwrap() > 90.0);
    let drowned = measure(&z, &g, Some(1e4));
    assert_eq!((drowned.land_share, drowned.max_m, drowned.landforms), (0.0, None, None));
}

#[test]
fn threads_do_not_change_a_bit() {
    let z = gaussian_surface(150, 3.2, 2);
    let g = grid(150, 150, 20.0, Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open });
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measure(&z, &g, Some(0.0)))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
}

#[test]
fn bad_requests_are_errors() {
    let g = grid(4, 4, 1.0, Boundary::CLOSED);
    let limits = Limits::default();
    let plain = TerrainOptions::default();
    assert!(matches!(terrain_stats(&Field::new(4, 3, 0.0), &g, None, &plain, &limits), Err(Error::Shape { .. })));
    let mut z = Field::new(4, 4, 0.0);
    let tight = Limits { max_bytes: 100, ..limits };
    assert!(matches!(terrain_stats(&z, &g, None, &plain, &tight), Err(Error::Limit { .. })));
    assert!(matches!(terrain_stats(&z, &g, Some(f64::NAN), &plain, &limits), Err(Error::BadParameter { .. })));
    let bad = TerrainOptions { channel_area_m2: Some(-1.0), ..plain.clone() };
    assert!(matches!(terrain_stats(&z, &g, None, &bad, &limits), Err(Error::BadParameter { .. })));
    z.set(2, 1, f32::NAN);
    assert!(matches!(terrain_stats(&z, &g, None, &plain, &limits), Err(Error::NotFinite { x: 2, y: 1, .. })));
}

proptest! {
    /// Any finite heights on any small grid: no panic, and no number that JSON cannot hold.
    #[test]
    fn anything_can_be_measured(
        w in 1_usize..40,
        h in 1_usize..40,
        cells in (0.01_f64..1e4, 0.01_f64..1e4),
        rim in (0_usize..3, 0_usize..3),
        scale in prop::sample::select(vec![0.0_f32, 1e-30, 1.0, 1e3, 3e38]),
        sea in prop::option::of(-1.0_f64..1.0),
        radius in 1_usize..12,
        seed in any::<u64>(),
    ) {
        let edge = |i| [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap][i];
        let mut random = Random(seed);
        let z = Field::from_fn(w, h, |_, _| (random.uniform() as f32 - 0.5) * scale);
        let g = Grid { cell_x_m: cells.0, cell_y_m: cells.1, ..grid(w, h, 1.0, Boundary { x: edge(rim.0), y: edge(rim.1) }) };
        let options = TerrainOptions {
            channel_area_m2: Some(3.0 * g.cell_area_m2()),
            geomorphon_radius_cells: radius,
            ..TerrainOptions::default()
        };
        let s = terrain_stats(&z, &g, sea, &options, &Limits::default()).unwrap();
        let text = format!("{s:?}");
        prop_assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        let shares = s.landforms.map(|l| l.to_array().iter().sum::<f64>());
        prop_assert!(shares.is_none_or(|sum| (sum - 1.0).abs() < 1e-9));
        // What is null in the text is None here, and the other way round.
        let json = serde_json::to_value(&s).unwrap();
        let nulls = json.as_object().unwrap().values().filter(|v| v.is_null()).count();
        prop_assert_eq!(nulls, text.matches("None").count());
    }
}

/// The target is 1.5 s; run alone: `cargo test --release -p eyot-land --test it analyse_synthetic -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement of time"]
fn a_million_cells_in_a_second_and_a_half() {
    let z = gaussian_surface(1024, 3.4, 1);
    let g = grid(1024, 1024, 10.0, Boundary::CLOSED);
    for sea in [None, Some(0.0)] {
        let start = std::time::Instant::now();
        let s = measure(&z, &g, sea);
        println!("1024^2, sea {sea:?}: {:?}\n{s:?}", start.elapsed());
        assert!(start.elapsed().as_secs_f64() < 1.5);
    }
}

/// What does not fit together is an error that says so, never a panic.
#[test]
fn sizes_that_differ_are_refused() {
    use eyot_core::{Boundary, Control};
    use eyot_drainage::Routing;
    use eyot_land::analyse;
    let g = Grid::new(8, 6, 10.0, Boundary::OPEN, &Limits::default()).unwrap();
    let (other, fits) = (Field::new(6, 8, 0.0), Field::new(8, 6, 0.0));
    let (few, all) = (vec![true; 9], vec![true; 48]);
    let flow = Routing::new(&fits.to_vec(), &g, &all, &Control::none()).unwrap();
    let errors = [
        analyse::curvatures(&other, &g, |_| true).unwrap_err(),
        analyse::geomorphons(&other, &g, 3, 1.0).unwrap_err(),
        analyse::count_pits(&other, &g, |_| true).unwrap_err(),
        analyse::slope_deg(&other, &g).unwrap_err(),
        analyse::spectral_beta(&other, &g).unwrap_err(),
        analyse::hurst_exponent(&other, &g, &all).unwrap_err(),
        analyse::hurst_exponent(&fits, &g, &few).unwrap_err(),
        analyse::strahler_orders(&flow, &few).unwrap_err(),
        analyse::hack_exponent(&flow, &all, &[1; 9]).unwrap_err(),
        analyse::hack_exponent(&flow, &few, &[1; 48]).unwrap_err(),
        analyse::streams_by_order(&flow, &[1; 9], &[1; 48]).unwrap_err(),
        analyse::streams_by_order(&flow, &[1; 48], &[1; 9]).unwrap_err(),
        analyse::concavity(&[0.0; 9], &flow, &all, &[1; 48], 1.0).unwrap_err(),
        analyse::concavity(&[0.0; 48], &flow, &few, &[1; 48], 1.0).unwrap_err(),
        analyse::concavity(&[0.0; 48], &flow, &all, &[1; 9], 1.0).unwrap_err(),
    ];
    for e in errors {
        assert!(matches!(e, eyot_core::Error::Shape { .. }) && e.to_string().contains("48"), "{e}");
    }
}

/// What makes a channel is an area of the map, not a number of cells.
#[test]
fn coarse_and_fine_maps_of_a_land_have_channels_from_one_area_on() {
    let of = |n: usize, options: &TerrainOptions| {
        let g = Grid::new(n, n, 5120.0 / n as f64, Boundary::CLOSED, &Limits::default()).unwrap();
        // Valleys 640 m apart that fall to the south.
        let z = Field::from_fn(n, n, |x, y| {
            let [x, y] = [x, y].map(|i| (i as f32 + 0.5) / n as f32);
            400.0 - 300.0 * y + 160.0 * (x * 8.0 - (x * 8.0).round()).abs()
        });
        terrain_stats(&z, &g, None, options, &Limits::default()).unwrap()
    };
    let plain = TerrainOptions::default();
    let (coarse, fine) = (of(128, &plain), of(256, &plain));
    assert_eq!(coarse.channel_area_m2, 600.0 * 100.0);
    assert_eq!(fine.channel_area_m2, 600.0 * 100.0);
    let (a, b) = (coarse.drainage_density_per_km.unwrap(), fine.drainage_density_per_km.unwrap());
    assert!(a > 0.5 && (a / b - 1.0).abs() < 0.25, "{a} and {b} per km");
    let none = of(64, &TerrainOptions { channel_area_m2: Some(1e9), ..plain });
    assert!(none.drainage_density_per_km.is_some_and(|d| d == 0.0 && d.is_sign_positive()), "no channel is 0, not -0");
}

/// A valley that falls evenly to the west, with its sides: a river as long as the map, and a hypsometric curve from the highest to the lowest cell.
#[test]
fn curves_of_a_valley() {
    use eyot_core::{Boundary, Field, Grid, Limits};
    use eyot_land::analyse::{TerrainOptions, terrain_curves};
    let grid = Grid::new(200, 61, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let height = Field::from_fn(200, 61, |x, y| 2.0 * x as f32 + 5.0 * (y as f32 - 30.0).abs());
    let options = TerrainOptions { channel_area_m2: Some(2e4), ..TerrainOptions::default() };
    let c = terrain_curves(&height, &grid, None, &options, &Limits::default()).unwrap();
    assert_eq!((c.hypsometry[0], c.hypsometry[100]), ([0.0, 548.0], [1.0, 0.0]));
    assert!(c.hypsometry.windows(2).all(|p| p[0][0] < p[1][0] && p[0][1] >= p[1][1]));
    let trunk = &c.rivers[0];
    let (mouth, source) = (trunk[0], trunk[trunk.len() - 1]);
    assert_eq!(mouth, [0.0, 0.0]);
    assert!(source[0] > 1800.0 && (source[1] / source[0] - 0.2).abs() < 0.01, "{source:?}");
    assert!(trunk.windows(2).all(|p| p[0][0] < p[1][0] && p[0][1] <= p[1][1]));
    // All rivers are channels of a size, and there is none under the sea.
    let sea = terrain_curves(&height, &grid, Some(1e4), &options, &Limits::default()).unwrap();
    assert!(sea.rivers.is_empty() && sea.hypsometry.is_empty() && sea.fit.is_none());
}
