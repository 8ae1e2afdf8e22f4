//! Where water stands, what it softens, and how it levels the ground.

use crate::{go, scheduled, value, world};
use eyot_core::layer::known::{BEDROCK, ERODIBILITY, WATER};
use eyot_core::{Field, World};
use eyot_strata::Soak;

/// A bowl of bare rock, 20 cells wide, with water up to 10 m.
fn lake() -> World {
    let bowl = |x: usize, y: usize| 0.1 * ((x as f32 - 9.5).powi(2) + (y as f32 - 9.5).powi(2));
    let mut w = world([20, 20], 10.0, bowl);
    w.sea_level_m = -12_000.0;
    let field = |f: &dyn Fn(f32) -> f32| Field::from_fn(20, 20, |x, y| f(bowl(x, y)));
    w.put(&WATER, field(&|h| (10.0 - h).max(0.0))).unwrap();
    w.put(&BEDROCK, field(&|h| h)).unwrap();
    w.put(&ERODIBILITY, Field::from_fn(20, 20, |x, _| if x < 10 { 0.5 } else { 0.1 })).unwrap();
    w
}

fn sum(w: &World, layer: &str) -> f64 {
    w.get(layer).unwrap().sum()
}

#[test]
fn standing_water_softens_rock_by_its_kind() {
    let mut w = lake();
    let soak = [scheduled(Soak { rate: 0.01, level: 0.0, ..Soak::default() })];
    go(&mut w, &soak, 1);
    assert!(w.get("bedrock") == lake().get("bedrock"), "how steady the water is shows in the second step");
    go(&mut w, &soak, 1);
    let loose = |w: &World, x: usize, y: usize| value(w, "height", x, y) - value(w, "bedrock", x, y);
    assert!((loose(&w, 9, 9) - 0.005).abs() < 1e-5 && (loose(&w, 10, 9) - 0.001).abs() < 1e-5);
    assert_eq!((loose(&w, 0, 0), loose(&w, 19, 0)), (0.0, 0.0), "the shore is dry");
    assert!(w.get("height") == lake().get("height"), "heights stay");
    let soaked = (sum(&lake(), "bedrock") - sum(&w, "bedrock")) * 100.0;
    assert!((w.ledger.amount("rock.soaked") / soaked - 1.0).abs() < 1e-4, "{}", w.ledger.amount("rock.soaked"));
    // As loose ground gathers, it slows down: s' = rate E e^(-s / cover).
    go(&mut w, &soak, 398);
    let want = 0.5 * (1.0 + 0.005 * 399.0 / 0.5f32).ln();
    assert!((loose(&w, 9, 9) - want).abs() < 0.01, "{} of {want} m", loose(&w, 9, 9));
}

#[test]
fn a_river_in_balance_does_not_stand_and_water_that_rises_does_not_either() {
    // A metre of water on a slope of 1 in 100, the same in every step.
    let mut river = world([20, 20], 10.0, |x, _| 0.1 * x as f32);
    river.sea_level_m = -12_000.0;
    let rock = river.get("height").unwrap().clone();
    river.put(&BEDROCK, rock.clone()).unwrap();
    river.put(&WATER, Field::new(20, 20, 1.0)).unwrap();
    go(&mut river, &[scheduled(Soak::default())], 5);
    assert!(river.get("bedrock").unwrap() == &rock);
    let mut w = lake();
    for _ in 0..5 {
        go(&mut w, &[scheduled(Soak::default())], 1);
        w.layer_mut("water").unwrap().field.rows_mut().flatten().filter(|d| **d > 0.0).for_each(|d| *d += 0.1);
    }
    assert!(w.get("bedrock") == lake().get("bedrock"));
}

#[test]
fn loose_ground_under_the_sea_levels_out_and_rock_stays() {
    let bumps = |x: usize, y: usize| -20.0 + 3.0 * ((0.9 * x as f32).sin() + (0.7 * y as f32).cos());
    // Rock in the west, ten metres of sand in the east.
    let make = || {
        let mut w = world([40, 40], 10.0, bumps);
        let rock = |x: usize, y: usize| bumps(x, y) - if x < 20 { 0.0 } else { 10.0 };
        w.put(&BEDROCK, Field::from_fn(40, 40, rock)).unwrap();
        w
    };
    let mut w = make();
    go(&mut w, &[scheduled(Soak { rate: 0.0, level: 1.0, ..Soak::default() })], 400);
    let spread = |w: &World| {
        let h: Vec<f64> = (24..40)
            .flat_map(|x| (0..40).map(move |y| (x, y)))
            .map(|(x, y)| f64::from(value(w, "height", x, y)))
            .collect();
        let mean = h.iter().sum::<f64>() / h.len() as f64;
        (h.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / h.len() as f64).sqrt()
    };
    assert!(spread(&w) < 0.2 * spread(&make()), "{} of {} m", spread(&w), spread(&make()));
    for x in 0..20 {
        for y in 0..40 {
            assert!(value(&w, "height", x, y) >= bumps(x, y) - 1e-5, "rock stays");
            assert_eq!(value(&w, "bedrock", x, y), bumps(x, y));
        }
    }
    let error = (sum(&w, "height") - sum(&make(), "height")) * 100.0 - w.ledger.net("ground");
    assert!((error / (sum(&w, "height") * 100.0)).abs() < 1e-9, "{error} m3");
    // Where the sea does not count, there is no water at all.
    let mut dry = make();
    go(&mut dry, &[scheduled(Soak { sea: false, ..Soak::default() })], 5);
    assert!(dry.get("height") == make().get("height") && dry.get("bedrock") == make().get("bedrock"));
}
