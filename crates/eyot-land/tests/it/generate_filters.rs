//! Terraces, curves, masks and small kernels against what they should be.
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_land::generate::mask::Shape;
use eyot_land::generate::remap::Curve;
use eyot_land::generate::smooth::Kernel;
use eyot_land::generate::{Hypsometry, MaskCurvature, MaskHeight, MaskNoise, MaskSlope, Remap, Smooth, Terraces};

fn grid(width: usize, height: usize, cell_x_m: f64, cell_y_m: f64, rim: Boundary) -> Grid {
    Grid { width, height, cell_x_m, cell_y_m, rim }.checked(&Limits::default()).unwrap()
}

/// The base is also the world's height.
fn make(what: &dyn Generator, base: &Field, grid: Grid) -> Field {
    let mut world = World::new(grid, 1);
    world.put(&HEIGHT, base.clone()).unwrap();
    let control = Control::none();
    what.generate(&Site::whole(grid, 1, &world, &control), base).unwrap()
}

#[test]
fn hypsometry_gives_the_asked_ocean_and_keeps_the_order() {
    let g = grid(100, 40, 1.0, 1.0, Boundary::CLOSED);
    // A permutation: no two cells are equally high.
    let base = Field::from_fn(100, 40, |x, y| ((y * 100 + x) * 1237 % 4000) as f32);
    let planet = Hypsometry { ocean: 0.6, highest: 5000.0, deepest: 6000.0 };
    let f = make(&planet, &base, g);
    let ocean = f.iter().filter(|h| *h < 0.0).count();
    assert_eq!(ocean, 2400);
    let mut pairs: Vec<(f32, f32)> = base.iter().zip(f.iter()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(pairs.windows(2).all(|w| w[0].1 <= w[1].1), "what was higher stays higher");
    // Equations (1) and (2) at the ends and in the middle of the land: 0.05 + 0.24 / 64 of the highest.
    let (low, high) = f.min_max();
    assert!((low + 6000.0).abs() < 30.0 && (high - 5000.0).abs() < 60.0, "{low} {high}");
    assert!((pairs[3200].1 - 268.8).abs() < 2.0, "{}", pairs[3200].1);
}

#[test]
fn terraces_are_level_and_keep_the_order() {
    let g = grid(1000, 1, 1.0, 1.0, Boundary::CLOSED);
    let base = Field::from_fn(1000, 1, |x, _| x as f32 * 0.5 - 100.0);
    for softness in [0.0, 0.3, 1.0] {
        let f = make(&Terraces { step_m: 100.0, softness, jitter: 0.0, ..Terraces::default() }, &base, g);
        let mut level = 0;
        for x in 1..1000 {
            let (h, v) = (base.get(x, 0), f.get(x, 0));
            assert!(v >= f.get(x - 1, 0), "what was higher stays higher");
            assert!((v - h).abs() <= 50.1);
            level += usize::from(v == f.get(x - 1, 0));
        }
        // Half a step from the middle of a riser is the middle of a tread.
        assert_eq!([f.get(0, 0), f.get(200, 0), f.get(400, 0)], [-100.0, 0.0, 100.0]);
        let share = level as f32 / 999.0;
        assert!((share - (1.0 - softness)).abs() < 0.02, "{softness}: {share} is level");
    }
    // As many steps as were asked for, and the treads wander when they are told to.
    let count = Terraces { count: 5, softness: 0.0, jitter: 0.0, ..Terraces::default() };
    let mut treads = make(&count, &base, g).to_vec();
    treads.dedup();
    assert_eq!(treads.len(), 6, "{treads:?}");
    let flat = Field::new(64, 64, 30.0);
    assert_eq!(make(&Terraces::default(), &flat, grid(64, 64, 1.0, 1.0, Boundary::CLOSED)), flat);
}

#[test]
fn curves_pass_through_their_points_and_never_overshoot() {
    let g = grid(2001, 1, 1.0, 1.0, Boundary::CLOSED);
    let base = Field::from_fn(2001, 1, |x, _| x as f32 - 500.0);
    let points = vec![[0.0, 0.0], [0.2, 0.5], [0.5, 0.5], [0.8, 0.9], [1.0, 0.6]];
    let remap = Remap { from: [0.0, 1000.0], to: [100.0, 300.0], points, ..Remap::default() };
    for curve in [Curve::Linear, Curve::Smooth] {
        let f = make(&Remap { curve, ..remap.clone() }, &base, g);
        for (x, want) in [(500, 100.0), (700, 200.0), (1000, 200.0), (1300, 280.0), (1500, 220.0)] {
            assert!((f.get(x, 0) - want).abs() < 0.01, "{curve:?} at {x}: {}", f.get(x, 0));
        }
        // Monotone between points, constant beyond them.
        for x in 1..2001 {
            let rise = f.get(x, 0) - f.get(x - 1, 0);
            match x {
                0..=500 | 1501.. => assert_eq!(rise, 0.0),
                501..=1300 => assert!(rise >= -1e-4, "{curve:?} at {x}: {rise}"),
                _ => assert!(rise <= 1e-4, "{curve:?} at {x}: {rise}"),
            }
        }
        let on = make(&Remap { curve, clamp: false, ..remap.clone() }, &base, g);
        assert!((on.get(400, 0) - (100.0 - 0.1 * 2.5 * 200.0)).abs() < 0.01, "{curve:?}: {}", on.get(400, 0));
    }
    // A curve along the diagonal changes nothing; without ranges it normalises.
    let diagonal = Remap { points: vec![[0.0, 0.0], [1.0, 1.0]], ..Remap::default() };
    assert!(make(&diagonal, &base, g).iter().zip(base.iter()).all(|(a, b)| (a - b).abs() < 1e-3));
    let unit = make(&Remap { to: [0.0, 1.0], ..diagonal.clone() }, &base, g);
    assert_eq!(unit.min_max(), (0.0, 1.0));
    let flat = Field::new(9, 9, 7.0);
    assert_eq!(make(&diagonal, &flat, grid(9, 9, 1.0, 1.0, Boundary::CLOSED)), flat);
}

#[test]
fn masks_of_height_and_slope_meet_their_bands() {
    // Rises by tan(40 degrees) to the east, then lies level; on cells that are not square.
    let g = grid(64, 40, 10.0, 20.0, Boundary::CLOSED);
    let steep = 40f32.to_radians().tan() * 10.0;
    let base = Field::from_fn(64, 40, |x, _| x.min(32) as f32 * steep);
    let mask = |from, to, edge| MaskSlope { from, to, edge, scale: 0.0, ..MaskSlope::default() };
    for (from, to, on_slope) in [(30.0, 50.0, 1.0), (45.0, 90.0, 0.0), (0.0, 35.0, 0.0), (39.0, 90.0, 1.0)] {
        let f = make(&mask(from, to, 0.0), &base, g);
        for y in 0..40 {
            assert!((1..31).all(|x| f.get(x, y) == on_slope), "{from} to {to}");
            assert_eq!(f.get(0, y), on_slope, "the border cell has the slope of the cell beside it");
            assert!((34..64).all(|x| f.get(x, y) == f32::from(from == 0.0)));
        }
        let turned = make(&MaskSlope { invert: true, ..mask(from, to, 0.0) }, &base, g);
        assert!(f.iter().zip(turned.iter()).all(|(a, b)| a + b == 1.0));
    }
    let soft = make(&mask(40.0, 90.0, 10.0), &base, g);
    assert!((soft.get(10, 10) - 0.45).abs() < 0.1, "half way at the band's end: {}", soft.get(10, 10));

    let base = Field::from_fn(64, 40, |x, _| x as f32 * 10.0);
    let f = make(&MaskHeight { from: 200.0, to: 400.0, edge: 40.0, ..MaskHeight::default() }, &base, g);
    for x in 0..64 {
        let (h, v) = (x as f32 * 10.0, f.get(x, 7));
        assert!((0.0..=1.0).contains(&v));
        assert!(!(220.0..=380.0).contains(&h) || v == 1.0);
        assert!((180.0..=420.0).contains(&h) || v == 0.0);
    }
    assert_eq!([f.get(20, 0), f.get(40, 0)], [0.5, 0.5]);
}

#[test]
fn masks_of_curvature_tell_ridges_from_valleys() {
    let g = grid(96, 96, 10.0, 10.0, Boundary::WRAP);
    // A ridge along column 24, a valley along column 72.
    let base = Field::from_fn(96, 96, |x, _| 100.0 * (x as f32 / 96.0 * std::f32::consts::TAU).sin());
    let of = |shape| MaskCurvature { shape, from: 0.0, to: 0.05, scale_m: 60.0, ..MaskCurvature::default() };
    let (ridge, valley) = (make(&of(Shape::Convex), &base, g), make(&of(Shape::Concave), &base, g));
    for y in 0..96 {
        assert!(ridge.get(24, y) > 0.5 && valley.get(72, y) > 0.5, "{} {}", ridge.get(24, y), valley.get(72, y));
        assert!(ridge.get(72, y) == 0.0 && valley.get(24, y) == 0.0);
    }
    let plane = Field::from_fn(96, 96, |x, y| (3 * x + y) as f32);
    let closed = Grid { rim: Boundary::CLOSED, ..g };
    let f = make(&of(Shape::Convex), &plane, closed);
    assert!((10..86).all(|i| f.get(i, i) == 0.0), "a plane is neither");
}

#[test]
fn noise_masks_cover_what_their_level_says() {
    let g = grid(512, 512, 10.0, 10.0, Boundary::CLOSED);
    let flat = Field::new(512, 512, 0.0);
    let cover = |level| {
        let f = make(&MaskNoise { level, ..MaskNoise::default() }, &flat, g);
        assert!(f.iter().all(|v| (0.0..=1.0).contains(&v)));
        f.sum() / (512.0 * 512.0)
    };
    let [low, middle, high] = [-0.3, 0.0, 0.3].map(cover);
    println!("{low:.3} {middle:.3} {high:.3}");
    assert!((middle - 0.5).abs() < 0.12 && low > 0.7 && high < 0.3, "{low} {middle} {high}");
}

#[test]
fn small_kernels_are_their_tables() {
    let g = grid(9, 9, 10.0, 10.0, Boundary::CLOSED);
    let mut base = Field::new(9, 9, 0.0);
    base.set(4, 4, 48.0);
    for (kernel, table) in [(Kernel::Binomial, [3.0, 6.0, 12.0]), (Kernel::Gentle, [2.0, 4.0, 24.0])] {
        let f = make(&Smooth { kernel, ..Smooth::default() }, &base, g);
        for y in 0..9usize {
            for x in 0..9usize {
                let want = match (x.abs_diff(4), y.abs_diff(4)) {
                    (0, 0) => table[2],
                    (0, 1) | (1, 0) => table[1],
                    (1, 1) => table[0],
                    _ => 0.0,
                };
                assert!((f.get(x, y) - want).abs() < 1e-5, "{kernel:?} at {x}, {y}: {}", f.get(x, y));
            }
        }
        // Several passes are one pass several times; nothing is lost at closed and wrapping rims.
        for rim in [Boundary::CLOSED, Boundary::WRAP] {
            let g = grid(23, 17, 10.0, 10.0, rim);
            let rough = Field::from_fn(23, 17, |x, y| ((x * 37 + y * y * 13) % 101) as f32);
            let mut by_hand = rough.clone();
            for _ in 0..4 {
                by_hand = make(&Smooth { kernel, ..Smooth::default() }, &by_hand, g);
            }
            let at_once = make(&Smooth { kernel, passes: 4, ..Smooth::default() }, &rough, g);
            assert_eq!(at_once, by_hand);
            assert!((at_once.sum() - rough.sum()).abs() < 1e-3);
        }
    }
}
