//! T2: talus in layers. Every material stops at its own angle, and nothing is lost.

use crate::{go, scheduled, value, world};
use eyot_core::layer::known::{BED_LEFT, ERODIBILITY, ERODIBILITY_BELOW};
use eyot_core::{Field, World};
use eyot_strata::{BEDROCK, ROCK_SLOPE, Rockfall, Strata};

/// A pile of loose ground, or of rock, on a plain.
fn pile(loose: bool) -> World {
    let n = 65;
    let mut w = world([n, n], 10.0, |x, y| {
        let r = ((x as f32 - 32.0).powi(2) + (y as f32 - 32.0).powi(2)).sqrt();
        (300.0 - 60.0 * r).max(0.0)
    });
    let rock = Field::from_fn(n, n, |x, y| if loose { -10.0 } else { value(&w, "height", x, y) });
    w.put(&eyot_strata::BEDROCK, rock).unwrap();
    w
}

fn steepest(w: &World) -> f32 {
    let h = |x: usize, y: usize| value(w, "height", x, y);
    let mut most = 0.0f32;
    for y in 1..64 {
        for x in 1..64 {
            for (dx, dy) in [(1usize, 0usize), (0, 1)] {
                most = most.max((h(x, y) - h(x - dx, y - dy)).abs() / 10.0);
            }
        }
    }
    most.atan().to_degrees()
}

fn volume(w: &World) -> f64 {
    w.get("height").unwrap().iter().map(f64::from).sum()
}

#[test]
fn t2_loose_ground_slides_to_its_angle_and_rock_to_that_of_its_bed() {
    for (loose, talus, want) in [(true, 35.0, 35.0f32), (true, 25.0, 25.0), (false, 35.0, 35.0)] {
        let mut w = pile(loose);
        let before = volume(&w);
        // Granite stands at 70 degrees; what fell from it lies at the angle of loose ground.
        let beds = Strata { top: 1000.0, ..Strata::default() };
        let all = [scheduled(beds), scheduled(Rockfall { talus, rate: 1.0, ..Rockfall::default() })];
        go(&mut w, &all, 3000);
        assert!((volume(&w) / before - 1.0).abs() < 1e-4, "{} of {before}", volume(&w));
        let got = steepest(&w);
        if loose {
            assert!((got - want).abs() < 0.3, "{got} degrees");
        } else {
            // The rock's core is steeper than scree and flatter than its own angle.
            assert!(got > want + 5.0 && got < 70.3, "{got} degrees");
        }
    }
}

#[test]
fn t2_what_its_material_carries_stays_to_the_bit() {
    // A wall of 55 degrees in rock that stands at 60, without loose ground.
    let mut w = world([40, 20], 10.0, |x, _| 14.28 * x as f32);
    let beds = Strata {
        top: 900.0,
        beds: vec![eyot_strata::Bed { material: "limestone".into(), thickness: 2000.0 }],
        ..Strata::default()
    };
    let before = w.get("height").unwrap().clone();
    go(&mut w, &[scheduled(beds.clone()), scheduled(Rockfall::default())], 50);
    assert!(w.get("height").unwrap() == &before);
    // In sandstone, which stands at 50, it comes down.
    let soft = Strata { beds: vec![eyot_strata::Bed { material: "sandstone".into(), thickness: 2000.0 }], ..beds };
    go(&mut w, &[scheduled(soft), scheduled(Rockfall::default())], 50);
    assert!(w.get("height").unwrap() != &before);
}

#[test]
fn little_loose_ground_does_not_take_rock_along() {
    // 40 degrees of rock under half a metre of scree that would lie at 35.
    let mut w = world([60, 20], 10.0, |x, _| 8.391 * x as f32);
    let beds = Strata { top: 2000.0, regolith: 0.5, ..Strata::default() };
    let all = [scheduled(beds), scheduled(Rockfall { talus: 35.0, rate: 1.0, ..Rockfall::default() })];
    go(&mut w, &all, 500);
    let rock = w.get("bedrock").unwrap();
    for x in 2..58 {
        assert!((rock.get(x, 10) - (8.391 * x as f32 - 0.5)).abs() < 1e-3, "rock at {x}: {}", rock.get(x, 10));
    }
    assert!(value(&w, "height", 50, 10) - rock.get(50, 10) < 0.05, "the slope is swept");
    assert!(value(&w, "height", 0, 10) - rock.get(0, 10) > 1.0, "scree at its foot");
}

/// Three bare columns, 10 m apart: a wall of 25 m in rock that stands at 70 degrees, `cap` metres of it on a bed of this erodibility.
fn columns(cap: f32, below: f32) -> World {
    let mut w = world([3, 1], 10.0, |x, _| if x == 0 { 125.0 } else { 100.0 });
    let rock = w.get("height").unwrap().clone();
    w.put(&BEDROCK, rock).unwrap();
    let slope = 70f32.to_radians().tan();
    for (spec, value) in [(ROCK_SLOPE, slope), (ERODIBILITY, 0.1), (BED_LEFT, cap), (ERODIBILITY_BELOW, below)] {
        w.put(&spec, Field::new(3, 1, value)).unwrap();
    }
    go(&mut w, &[scheduled(Rockfall::default())], 1);
    w
}

/// Hard rock on loose ground, as Benes and Olsen have it. By hand: `0.5 / 12` of what exceeds 10 m x tan 35 = 7.002 m, and half of that
/// to each of the two diagonal neighbours, which are the same cell beyond a closed rim, beyond 9.902 m.
#[test]
fn hard_rock_on_loose_ground_has_three_cases() {
    let (granite, sand) = (0.05, 0.9);
    let cases = [
        // 1: the bed below is as firm, or the weak one does not come to light in the wall, or as a step of 5 m that it keeps.
        (columns(5.0, granite), 0.0),
        (columns(30.0, sand), 0.0),
        (columns(20.0, sand), 0.0),
        // 2: 15 m x 2500 kg/m3 press more than 10 m x 1950 kg/m3, which trickle out from under them.
        (columns(15.0, sand), (10.0 - 7.002) + (10.0 - 9.902)),
        // 3: 5 m press less than 20 m: all 25 m slide.
        (columns(5.0, sand), (25.0 - 7.002) + (25.0 - 9.902)),
    ];
    for (i, (w, excess)) in cases.iter().enumerate() {
        let want = 0.5 / 12.0 * excess;
        let fallen: Vec<f32> =
            [125.0, 100.0, 100.0].iter().zip(0..).map(|(h, x)| value(w, "height", x, 0) - h).collect();
        let near = |got: f32, want: f32| (got - want).abs() < 5e-5 * (1.0 + want.abs());
        assert!(near(fallen[0], -want) && near(fallen[1], want) && fallen[2] == 0.0, "{i}: {fallen:?}, {want} m");
        assert!(*excess > 0.0 || fallen == [0.0; 3], "{i}: nothing moves: {fallen:?}");
        assert_eq!(value(w, "bedrock", 1, 0), 100.0, "{i}: what arrives is loose");
    }
    // A lighter bed slides where a heavier one holds.
    let mut w = columns(9.0, granite);
    let before = w.get("height").unwrap().clone();
    w.put(&ERODIBILITY_BELOW, Field::new(3, 1, sand)).unwrap();
    let fallen = |density: f32| {
        let mut w = w.clone();
        go(&mut w, &[scheduled(Rockfall { density, ..Rockfall::default() })], 1);
        before.get(0, 0) - value(&w, "height", 0, 0)
    };
    assert!(fallen(3000.0) > fallen(4000.0) + 0.2, "{} and {} m", fallen(3000.0), fallen(4000.0));
}
