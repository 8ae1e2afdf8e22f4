//! Contour lines: on land whose lines are known.

use eyot_core::component::signed_double_area;
use eyot_core::{Boundary, Control, Field, Grid, Limits};
use eyot_land::analyse::{contours, round_interval};

fn grid(n: usize) -> Grid {
    Grid::new(n, n, 10.0, Boundary::OPEN, &Limits::default()).unwrap()
}

#[test]
fn a_cone_has_circles_around_its_summit() {
    let (n, slope) = (81, 0.3);
    let grid = grid(n);
    let middle = n as f32 * 5.0;
    let radius = |x: f32, y: f32| ((x - middle).powi(2) + (y - middle).powi(2)).sqrt();
    let cone = Field::from_fn(n, n, |x, y| 500.0 - slope * radius(x as f32 * 10.0 + 5.0, y as f32 * 10.0 + 5.0));
    let lines = contours(&cone, &grid, 20.0, &Control::none()).unwrap();
    let mut rings = 0;
    for i in 0..lines.len() {
        let level: f64 = lines.attributes().row(i).next().unwrap();
        let wanted = (500.0 - level) / f64::from(slope);
        for [x, y, z] in lines.parts(i).flatten() {
            let r = f64::from(radius(*x, *y));
            assert!((r - wanted).abs() < 2.0, "{r} m from the summit, {wanted} at {level} m");
            assert_eq!(f64::from(*z), level);
        }
        if lines.attributes().row(i).nth(1) == Some(1.0) {
            let ring = lines.parts(i).next().unwrap();
            assert_eq!(ring.first(), ring.last());
            // Higher ground on the right: around a summit clockwise.
            let area = -signed_double_area(ring) / 2.0;
            assert!((area / (std::f64::consts::PI * wanted * wanted) - 1.0).abs() < 0.05, "{area} m2 at {level} m");
            rings += 1;
        }
    }
    // From 400 m up, circles close before the rim, 400 m away; the summit at 500 m is a single place and no line.
    assert_eq!(rings, 5, "levels 400 to 480");
    assert!(lines.len() > 5, "and arcs that end at the rim");
}

#[test]
fn a_saddle_is_parted_by_its_middle() {
    let grid = grid(2);
    for (lift, together) in [(0.2_f32, true), (-0.2, false)] {
        let field = Field::from_fn(2, 2, |x, y| if x == y { 1.0 + lift } else { -1.0 + lift });
        let lines = contours(&field, &grid, 10.0, &Control::none()).unwrap();
        assert_eq!(lines.len(), 2);
        // The line cuts off one corner: the lower ones if the higher ones join.
        let cut_is_high = lines.parts(0).flatten().all(|v| (v[0] - v[1]).abs() < 10.0);
        let ends: Vec<_> = lines.parts(0).flatten().collect();
        let corner = [ends.iter().map(|v| v[0]).sum::<f32>() / 2.0, ends.iter().map(|v| v[1]).sum::<f32>() / 2.0];
        let high = (corner[0] < 10.0) == (corner[1] < 10.0);
        assert_eq!(high, !together, "lift {lift}: corner near {corner:?} (within reach: {cut_is_high})");
    }
}

#[test]
fn levels_on_flat_ground_and_bad_intervals() {
    let (flat, grid) = (Field::new(4, 4, 20.0), grid(4));
    assert!(contours(&flat, &grid, 10.0, &Control::none()).unwrap().is_empty());
    let steps = Field::from_fn(4, 4, |x, _| if x < 2 { 20.0 } else { 10.0 });
    let lines = contours(&steps, &grid, 10.0, &Control::none()).unwrap();
    assert_eq!(lines.len(), 1, "a line at 20 m along the edge, and none around all that is at 10 m");
    for interval in [0.0, -1.0, f64::NAN, 1e-9] {
        let e = contours(&steps, &grid, interval, &Control::none()).unwrap_err().to_string();
        assert!(e.contains("contours.interval"), "{e}");
    }
    assert_eq!([(0.0, 1000.0), (0.0, 390.0), (-1.0, 1.0)].map(|(a, b)| round_interval(a, b)), [50.0, 20.0, 0.1]);
}
