//! Cone, ramp, constant, crater, smoothing and warp against what they should be.
use eyot_core::isa::Isa;
use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, Limits, World};
use eyot_land::generate::{Cone, Constant, Crater, Ramp, Smooth, Warp};

fn grid(width: usize, height: usize, cell_x_m: f64, cell_y_m: f64, rim: Boundary) -> Grid {
    Grid { width, height, cell_x_m, cell_y_m, rim }.checked(&Limits::default()).unwrap()
}

fn make(what: &dyn Generator, base: &Field, grid: Grid) -> Field {
    let (world, control) = (World::new(grid, 1), Control::none());
    what.generate(&Site::whole(grid, 1, &world, &control), base).unwrap()
}

/// Something rough.
fn rough(w: usize, h: usize) -> Field {
    Field::from_fn(w, h, |x, y| {
        (((x * 2654435761usize) ^ (y * 40503)).wrapping_mul(0x9e37_79b1) >> 7 & 1023) as f32 - 300.0
    })
}

#[test]
fn cone_is_the_formula() {
    let g = grid(61, 40, 10.0, 14.0, Boundary::CLOSED);
    for (exponent, tolerance) in [(1.0, 2e-4), (2.0, 1e-3), (0.6, 1e-3)] {
        let cone = Cone { height: 900.0, radius: 0.4, exponent, centre: [0.4, 0.55], apex: 0.0 };
        let f = make(&cone, &Field::new(61, 40, 0.0), g);
        let radius = 0.4 * 560.0;
        for y in 0..40 {
            for x in 0..61 {
                let r = ((x as f64 + 0.5) * 10.0 - 0.4 * 610.0).hypot((y as f64 + 0.5) * 14.0 - 0.55 * 560.0) / radius;
                let want = if r < 1.0 { 900.0 * (1.0 - r.powf(f64::from(exponent))) } else { 0.0 };
                let got = f64::from(f.get(x, y));
                assert!((got - want).abs() < tolerance, "{exponent} at {x}, {y}: {got} for {want}");
            }
        }
    }
}

#[test]
fn a_rounded_apex_is_smooth_and_leaves_the_flank() {
    for exponent in [0.7, 1.0, 2.0] {
        let g = grid(2001, 1, 1.0, 2001.0, Boundary::CLOSED);
        let sharp = Cone { exponent, radius: 0.4, ..Cone::default() };
        let (a, b) = (
            make(&sharp, &Field::new(2001, 1, 0.0), g),
            make(&Cone { apex: 0.25, ..sharp }, &Field::new(2001, 1, 0.0), g),
        );
        let (mut steepest, mut sharpest) = (0f32, 0f32);
        for x in 1..2000usize {
            let r = x.abs_diff(1000) as f64 / (0.4 * 2001.0);
            if r > 0.2502 {
                assert_eq!(a.get(x, 0), b.get(x, 0));
            } else {
                assert!(b.get(x, 0) <= a.get(x, 0) + 1e-3);
                steepest = steepest.max((b.get(x + 1, 0) - b.get(x, 0)).abs());
                sharpest = sharpest.max((b.get(x + 1, 0) - 2.0 * b.get(x, 0) + b.get(x - 1, 0)).abs());
            }
        }
        assert!(sharpest < 0.02 * steepest, "no kink anywhere: {sharpest} beside slopes of {steepest}");
    }
}

#[test]
fn ramp_and_constant() {
    for (direction, low_corner, high_corner) in
        [(0.0, (3, 19), (3, 0)), (90.0, (0, 5), (29, 5)), (180.0, (3, 0), (3, 19)), (-90.0, (29, 5), (0, 5))]
    {
        let g = grid(30, 20, 10.0, 15.0, Boundary::CLOSED);
        let f = make(&Ramp { direction, low: 100.0, high: 400.0 }, &Field::new(30, 20, 0.0), g);
        let half = if direction.rem_euclid(180.0) == 0.0 { 300.0 / 40.0 } else { 300.0 / 60.0 };
        assert!((f.get(low_corner.0, low_corner.1) - (100.0 + half)).abs() < 1e-4, "{direction}");
        assert!((f.get(high_corner.0, high_corner.1) - (400.0 - half)).abs() < 1e-4, "{direction}");
        // Nothing changes across the slope, not even in the last bit.
        assert_eq!(f.get(4, 4), if half == 7.5 { f.get(17, 4) } else { f.get(4, 17) });
    }
    let g = grid(64, 64, 1.0, 1.0, Boundary::CLOSED);
    let f = make(&Ramp { direction: 135.0, low: 0.0, high: 1.0 }, &Field::new(64, 64, 0.0), g);
    assert!((f.get(0, 0) - 1.0 / 128.0).abs() < 1e-6 && (f.get(63, 63) - 127.0 / 128.0).abs() < 1e-6);
    assert!(make(&Constant { value: -7.5 }, &f, g).iter().all(|v| v == -7.5));
}

#[test]
fn crater_folds_exactly() {
    let g = grid(33, 21, 1.0, 1.0, Boundary::CLOSED);
    let base = rough(33, 21);
    let f = make(&Crater { level_m: 250.0, ..Crater::default() }, &base, g);
    for (h, v) in base.iter().zip(f.iter()) {
        assert_eq!(v, if h > 250.0 { 500.0 - h } else { h });
    }
    let top = base.min_max().1;
    let share = make(&Crater { level: 0.5, ..Crater::default() }, &base, g);
    for (h, v) in base.iter().zip(share.iter()) {
        assert_eq!(v, if h > 0.5 * top { top - h } else { h });
    }
    assert_eq!(make(&Crater { level: 1.0, ..Crater::default() }, &base, g), base);
}

#[test]
fn a_rounded_crest_has_no_edge() {
    // A straight flank through the level: the fold is a parabola between 180 and 220 m and exact outside.
    let g = grid(4000, 1, 1.0, 1.0, Boundary::CLOSED);
    let base = Field::from_fn(4000, 1, |x, _| x as f32 * 0.1);
    let f = make(&Crater { level_m: 200.0, crest_m: 20.0, ..Crater::default() }, &base, g);
    for x in 1..3999 {
        let h = base.get(x, 0);
        let bend = f.get(x - 1, 0) - 2.0 * f.get(x, 0) + f.get(x + 1, 0);
        assert!(bend.abs() < 0.1 * 0.1 / 20.0 + 1e-4, "{bend} at {h}");
        if (h - 200.0).abs() > 20.001 {
            assert_eq!(f.get(x, 0), h.min(400.0 - h));
        }
    }
    assert!((f.min_max().1 - 190.0).abs() < 1e-3);
}

#[test]
fn smoothing_keeps_constants_and_mass() {
    let mut worst = 0f64;
    for (w, h) in [(1, 1), (1, 40), (40, 1), (3, 5), (64, 48), (130, 33)] {
        for x in [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap] {
            for y in [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap] {
                let g = grid(w, h, 10.0, 17.0, Boundary { x, y });
                for smooth in [
                    Smooth { sigma_cells: 0.0, ..Smooth::default() },
                    Smooth::default(),
                    Smooth { sigma_cells: 20.0, ..Smooth::default() },
                    Smooth { sigma_m: 35.0, ..Smooth::default() },
                    Smooth { sigma_m: 1e6, ..Smooth::default() },
                ] {
                    let level = Field::new(w, h, 123.456);
                    assert_eq!(make(&smooth, &level, g), level);
                    let base = rough(w, h);
                    let f = make(&smooth, &base, g);
                    let ((low, high), (l, h)) = (base.min_max(), f.min_max());
                    assert!(l >= low - 1e-3 && h <= high + 1e-3);
                    if x != BoundaryCondition::Open && y != BoundaryCondition::Open {
                        let moved = base.iter().map(|v| f64::from(v.abs())).sum::<f64>().max(1.0);
                        worst = worst.max((f.sum() - base.sum()).abs() / moved);
                    }
                }
            }
        }
    }
    println!("mass changes by up to {worst:e} of the sum of magnitudes");
    assert!(worst < 1e-6, "{worst:e}");
}

/// A Gaussian that is wider than the grid meets each cell again and again; every rim says where.
#[test]
fn a_wide_gaussian_is_what_its_sum_says() {
    let (n, sigma) = (24_i64, 30.0);
    let base = rough(n as usize, 1);
    for edge in [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap] {
        let g = grid(n as usize, 1, 1.0, 1.0, Boundary::both(edge));
        let f = make(&Smooth { sigma_cells: sigma as f32, ..Smooth::default() }, &base, g);
        for x in 0..n {
            let cell = |i: i64| match edge {
                BoundaryCondition::Wrap => i.rem_euclid(n),
                BoundaryCondition::Open => i.clamp(0, n - 1),
                BoundaryCondition::Closed => i.rem_euclid(2 * n).min(2 * n - 1 - i.rem_euclid(2 * n)),
            };
            let (mut sum, mut total) = (0.0, 0.0);
            for k in -120..=120 {
                let w = (-0.5 * (k as f64 / sigma).powi(2)).exp();
                sum += w * f64::from(base.get(cell(x + k) as usize, 0));
                total += w;
            }
            let found = f64::from(f.get(x as usize, 0));
            assert!((found - sum / total).abs() < 1e-3, "{edge:?}, column {x}: {found} for {}", sum / total);
        }
    }
}

/// A thousand passes, each wider than the grid: the land is level after the first few, and the others are not worth the wait.
#[test]
fn smoothing_beyond_all_measure_is_level_and_quick() {
    let (w, h) = (300, 200);
    let base = rough(w, h);
    let mean = base.sum() / (w * h) as f64;
    for rim in [Boundary::CLOSED, Boundary::WRAP, Boundary::OPEN] {
        for (sigma_m, sigma_cells) in [(1e7, 0.0), (0.0, 1024.0), (0.0, 150.0)] {
            let begun = std::time::Instant::now();
            let f = make(
                &Smooth { passes: 1000, sigma_m, sigma_cells, ..Smooth::default() },
                &base,
                grid(w, h, 10.0, 10.0, rim),
            );
            let (low, high) = f.min_max();
            assert!(high - low < 0.01, "{rim:?}: from {low} to {high}");
            if rim != Boundary::OPEN {
                assert!((f64::from(low) - mean).abs() < 0.01, "{low} for {mean}");
            }
            // A thousand such passes take minutes.
            assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
        }
    }
}

#[test]
fn smoothing_one_cell_gives_a_round_gaussian() {
    let g = grid(65, 65, 10.0, 10.0, Boundary::CLOSED);
    let mut base = Field::new(65, 65, 0.0);
    base.set(32, 32, 1000.0);
    let f = make(&Smooth { sigma_cells: 3.0, ..Smooth::default() }, &base, g);
    for y in 0..65 {
        for x in 0..65 {
            let v = f.get(x, y);
            assert_eq!(v, f.get(64 - x, y));
            assert_eq!(v, f.get(x, 64 - y));
            assert!((v - f.get(y, x)).abs() <= 1e-6 * v.abs().max(1e-3));
            let r2 = (x as f64 - 32.0).powi(2) + (y as f64 - 32.0).powi(2);
            let want = 1000.0 / (2.0 * std::f64::consts::PI * 9.0) * (-r2 / 18.0).exp();
            assert!((f64::from(v) - want).abs() < 0.004, "{v} for {want}");
        }
    }
    // On cells that are not square the spot is round in metres.
    let g = grid(65, 65, 10.0, 20.0, Boundary::CLOSED);
    let f = make(&Smooth { sigma_m: 60.0, ..Smooth::default() }, &base, g);
    assert!((f.get(36, 32) / f.get(32, 34) - 1.0).abs() < 1e-3);
}

#[test]
fn smoothing_meets_its_rim() {
    let ring = grid(40, 24, 1.0, 1.0, Boundary::WRAP);
    let base = rough(40, 24);
    let f = make(&Smooth { sigma_cells: 2.0, ..Smooth::default() }, &base, ring);
    let moved = Field::from_fn(40, 24, |x, y| base.get((x + 7) % 40, (y + 5) % 24));
    let g = make(&Smooth { sigma_cells: 2.0, ..Smooth::default() }, &moved, ring);
    assert!((0..24).all(|y| (0..40).all(|x| g.get(x, y) == f.get((x + 7) % 40, (y + 5) % 24))), "a ring has no place");
}

#[test]
fn smoothing_gives_the_same_bytes_everywhere() {
    let g = grid(133, 57, 1.0, 1.0, Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Wrap });
    let (base, smooth) = (rough(133, 57), Smooth { sigma_cells: 4.0, ..Smooth::default() });
    let (world, control) = (World::new(g, 1), Control::none());
    let site = Site::whole(g, 1, &world, &control);
    let reference = smooth.smoothed(&site, &base, Isa::Scalar).unwrap();
    for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let f = pool.install(|| smooth.smoothed(&site, &base, isa)).unwrap();
            assert_eq!(f, reference, "{} {threads}", isa.name());
        }
    }
}

#[test]
fn warp_moves_and_does_not_make() {
    use eyot_land::generate::fractal::Octaves;
    use eyot_land::generate::warp::Interpolation;
    for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
        let g = grid(96, 64, 10.0, 10.0, rim);
        let base = rough(96, 64);
        for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
            let none = Warp { strength: 0.0, interpolation, ..Warp::default() };
            assert_eq!(make(&none, &base, g), base);
            let level = Field::new(96, 64, 42.0);
            assert_eq!(make(&Warp { interpolation, ..Warp::default() }, &level, g), level);
        }
        let f = make(&Warp { interpolation: Interpolation::Linear, ..Warp::default() }, &base, g);
        let ((low, high), (l, h)) = (base.min_max(), f.min_max());
        assert!(l >= low && h <= high && f != base);
        let bends = Octaves { octaves: 3, scale_m: 200.0, ..Octaves::default() };
        // A plane is moved by the displacement, exactly so by both interpolations.
        let plane = Field::from_fn(96, 64, |x, y| (x + 2 * y) as f32);
        let [a, b] = [Interpolation::Linear, Interpolation::Cubic]
            .map(|interpolation| make(&Warp { interpolation, noise: bends.clone(), strength: 0.2 }, &plane, g));
        for y in 8..56 {
            for x in 8..88 {
                assert!((a.get(x, y) - b.get(x, y)).abs() < 1e-3);
            }
        }
    }
}
