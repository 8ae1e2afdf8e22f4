//! Columns of beds, new rock and loose ground: each wears for as long as it lasts, and nothing is lost.

use crate::{go, scheduled, value, world};
use eyot_core::layer::known::{BEDROCK, ERODIBILITY, SEDIMENT};
use eyot_core::{Field, World};
use eyot_strata::{BED_SURFACES, Bed, NEW_ROCK, Strata, Surfaces};

pub(crate) fn bed(material: &str, thickness: f32) -> Bed {
    Bed { material: material.into(), thickness }
}

/// Erodibilities of the standard materials.
const SAND: f64 = 0.9;
const SANDSTONE: f64 = 0.7;
const MARBLE: f64 = 0.1;
const GRANITE: f64 = 0.05;

fn beds() -> Strata {
    Strata {
        beds: vec![bed("sandstone", 2.0), bed("marble", 1.0), bed("sand", 3.0), bed("granite", 1.0)],
        top: 100.0,
        cover: 0.1,
        ..Strata::default()
    }
}

/// Digs `cut` m from the ground into the sediment, as water does, and lets the beds answer.
pub(crate) fn dig(w: &mut World, beds: &Strata, cut: &[f32]) {
    let (width, height) = (w.grid.width, w.grid.height);
    let change = |w: &mut World, layer: &str, sign: f32| {
        let field = &mut w.layer_mut(layer).unwrap().field;
        for y in 0..height {
            for x in 0..width {
                let v = field.get(x, y) + sign * cut[(y * width + x) % cut.len()];
                field.row_mut(y)[x] = v;
            }
        }
    };
    change(w, "height", -1.0);
    change(w, "sediment", 1.0);
    go(w, &[scheduled(beds.clone())], 1);
}

/// What a cut of `cut` at the rate of the first becomes in beds of `(thickness, erodibility)`, to the bit of arithmetic.
fn budget(cut: f64, beds: &[(f64, f64)]) -> f64 {
    let (mut time, mut depth) = (cut / beds[0].1, 0.0);
    for &(thickness, erodibility) in beds {
        let worn = (erodibility * time).min(thickness);
        depth += worn;
        if worn < thickness {
            break;
        }
        time -= worn / erodibility;
    }
    depth.min(cut)
}

#[test]
fn a_step_that_cuts_through_beds_takes_each_for_as_long_as_it_lasts() {
    let cuts = [0.5f32, 2.0, 2.4, 5.0, 9.0, 12.0, 40.0];
    let mut w = world([7, 1], 10.0, |_, _| 100.0);
    go(&mut w, &[scheduled(beds())], 1);
    dig(&mut w, &beds(), &cuts);
    let column = [(2.0, SANDSTONE), (1.0, MARBLE), (3.0, SAND), (1e9, GRANITE)];
    let mut worn = 0.0;
    for (x, &cut) in cuts.iter().enumerate() {
        let want = budget(f64::from(cut), &column);
        let got = 100.0 - f64::from(value(&w, "height", x, 0));
        assert!((got - want).abs() < 2e-5, "{cut} m at the rate of sandstone cut {got}, not {want}");
        assert_eq!(value(&w, "height", x, 0), value(&w, "bedrock", x, 0), "bare");
        assert!((f64::from(value(&w, "sediment", x, 0)) - want).abs() < 2e-5, "what is not cut is not carried");
        worn += want;
    }
    assert!(budget(12.0, &column) > 3.9 && budget(2.4, &column) < 2.1, "some cuts go through beds, some end in them");
    // The ledger knows each bed: 100 m2 a cell.
    let account = |name: &str| w.ledger.amount(name) / 100.0;
    assert!((account("rock.worn") - worn).abs() < 1e-3, "{} of {worn}", account("rock.worn"));
    let of = |top: f64, bottom: f64| -> f64 {
        cuts.iter().map(|&c| (budget(f64::from(c), &column).min(bottom) - top).max(0.0)).sum()
    };
    for (name, top, bottom) in [("bed_1", 0.0, 2.0), ("bed_2", 2.0, 3.0), ("bed_3", 3.0, 6.0), ("bed_4", 6.0, 1e9)] {
        let got = account(&format!("rock.worn_{name}"));
        assert!((got - of(top, bottom)).abs() < 1e-3, "{name}: {got}, not {}", of(top, bottom));
    }
}

#[test]
fn what_the_beds_tell_is_how_far_the_surface_reaches_and_what_comes_next() {
    let mut w = world([4, 1], 10.0, |x, _| [99.5, 97.5, 95.0, 90.0][x]);
    go(&mut w, &[scheduled(beds())], 1);
    let left = [0, 1, 2].map(|x| value(&w, "bed_left", x, 0));
    assert_eq!(left, [1.5, 0.5, 1.0]);
    assert!(value(&w, "bed_left", 3, 0) > 1e5, "the last bed goes on for ever");
    let below = [0, 1, 2, 3].map(|x| f64::from(value(&w, "erodibility_below", x, 0)));
    for (got, want) in below.into_iter().zip([MARBLE, SAND, GRANITE, GRANITE]) {
        assert!((got - want).abs() < 1e-6, "{below:?}");
    }
    // Two metres of loose ground come first.
    let height = &mut w.layer_mut("height").unwrap().field;
    height.row_mut(0)[0] += 2.0;
    go(&mut w, &[scheduled(beds())], 1);
    assert_eq!(value(&w, "bed_left", 0, 0), 2.0);
    assert!((f64::from(value(&w, "erodibility_below", 0, 0)) - SANDSTONE).abs() < 1e-6);
}

#[test]
fn bottoms_of_beds_can_be_surfaces_of_their_own() {
    let three =
        Strata { beds: vec![bed("sandstone", 10.0), bed("marble", 10.0), bed("granite", 1.0)], top: 100.0, ..beds() };
    let material = |surfaces: Surfaces, bottom: fn(usize) -> f32, height: f32| -> Vec<f32> {
        let mut w = world([4, 1], 10.0, |_, _| height);
        w.put(&BED_SURFACES[0], Field::from_fn(4, 1, |x, _| bottom(x))).unwrap();
        // The second follows the thickness, or lies at 80 m.
        let second = if surfaces == Surfaces::Height { 80.0 } else { 0.0 };
        w.put(&BED_SURFACES[1], Field::from_fn(4, 1, |_, _| second)).unwrap();
        go(&mut w, &[scheduled(Strata { surfaces, ..three.clone() })], 1);
        (0..4).map(|x| value(&w, "material", x, 0)).collect()
    };
    // 90, 85, 80 and 75 m; beds keep their order where a surface dips below the next.
    let lower = |x: usize| 5.0 * x as f32;
    assert_eq!(material(Surfaces::Lower, lower, 88.0), [5.0, 2.0, 2.0, 2.0]);
    assert_eq!(material(Surfaces::Lower, lower, 82.0), [5.0, 5.0, 2.0, 2.0]);
    assert_eq!(material(Surfaces::Lower, lower, 78.0), [6.0, 6.0, 6.0, 2.0]);
    let height = |x: usize| 90.0 - 5.0 * x as f32;
    for at in [88.0, 82.0, 78.0] {
        assert_eq!(material(Surfaces::Height, height, at), material(Surfaces::Lower, lower, at), "{at} m");
    }
}

/// A number within 0..1 for each cell and purpose.
pub(crate) fn noise(x: usize, y: usize, salt: u32) -> f32 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B) ^ salt.wrapping_mul(0xC2B2_AE35);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 13;
    (h >> 8) as f32 / (1u32 << 24) as f32
}

fn sum(w: &World, layer: &str) -> f64 {
    w.get(layer).unwrap().iter().map(f64::from).sum()
}

#[test]
fn random_columns_lose_nothing() {
    let n = 48;
    let beds = Strata { new_rock: true, soil: 0.002, years_per_step: 10.0, cover: 0.2, ..beds() };
    let mut w = world([n, n], 10.0, |x, y| 95.0 + 12.0 * noise(x, y, 1));
    for (k, slot) in NEW_ROCK.iter().enumerate() {
        let salt = 10 + k as u32;
        w.put(slot, Field::from_fn(n, n, |x, y| (2.0 * noise(x, y, salt) - 1.0).max(0.0))).unwrap();
    }
    go(&mut w, &[scheduled(beds.clone())], 1);
    let ground = |w: &World| sum(w, "height") + sum(w, "sediment");
    let slots = |w: &World| -> f64 { NEW_ROCK.iter().map(|s| sum(w, &s.name)).sum() };
    let [ground_before, slots_before, bedrock_before] = [ground(&w), slots(&w), sum(&w, "bedrock")];
    let worn_before =
        ["rock.worn", "rock.weathered", "rock.worn_new", "rock.weathered_new"].map(|a| w.ledger.amount(a));
    for step in 0..20 {
        let cut: Vec<f32> = (0..n * n).map(|i| (1.2 * noise(i % n, i / n, 100 + step) - 0.5).max(-0.2)).collect();
        dig(&mut w, &beds, &cut);
        let loose = w.get("height").unwrap().iter().zip(w.get("bedrock").unwrap().iter()).map(|(h, r)| h - r);
        assert!(loose.fold(f32::INFINITY, f32::min) >= 0.0, "rock lies above the ground in step {step}");
        for slot in &NEW_ROCK {
            assert!(w.get(&slot.name).unwrap().iter().all(|t| t >= 0.0), "{} in step {step}", slot.name);
        }
    }
    let cells = (n * n) as f64;
    assert!((ground(&w) - ground_before).abs() < 1e-4 * cells, "{} of {ground_before}", ground(&w));
    // What the rock lost is what the ledger says, kind by kind.
    let now = ["rock.worn", "rock.weathered", "rock.worn_new", "rock.weathered_new"].map(|a| w.ledger.amount(a));
    let [worn, weathered, worn_new, weathered_new] = std::array::from_fn(|i| (now[i] - worn_before[i]) / 100.0);
    let slots_lost = slots_before - slots(&w);
    assert!(slots_lost > 100.0, "new rock wears: {slots_lost}");
    assert!(
        (slots_lost - worn_new - weathered_new).abs() < 1e-3 * slots_lost,
        "{slots_lost}, {worn_new} + {weathered_new}"
    );
    let rock_lost = bedrock_before - sum(&w, "bedrock");
    let told = worn + weathered + worn_new + weathered_new;
    assert!((rock_lost - told).abs() < 1e-3 * rock_lost, "{rock_lost}, not {told}");
}

#[test]
fn new_rock_wears_at_its_own_rate_and_is_seen() {
    let beds = Strata { new_rock: true, ..beds() };
    let mut w = world([3, 1], 10.0, |_, _| 100.0);
    // 1 m of sandstone on 2 m of marble (the second and the fifth stage); the beds begin at 97 m here.
    w.put(&NEW_ROCK[1], Field::new(3, 1, 1.0)).unwrap();
    w.put(&NEW_ROCK[4], Field::new(3, 1, 2.0)).unwrap();
    w.put(&BEDROCK, Field::new(3, 1, 100.0)).unwrap();
    w.put(&ERODIBILITY, Field::new(3, 1, 1.0)).unwrap();
    w.put(&SEDIMENT, Field::new(3, 1, 0.0)).unwrap();
    go(&mut w, &[scheduled(beds.clone())], 1);
    assert_eq!([value(&w, "material", 0, 0), value(&w, "bed_left", 0, 0)], [2.0, 1.0]);
    assert!((f64::from(value(&w, "erodibility_below", 0, 0)) - MARBLE).abs() < 1e-6);
    let cuts = [0.5f32, 1.7, 30.0];
    dig(&mut w, &beds, &cuts);
    // Below the new rock lies what the beds have at 97 m: sand down to 94 m, then granite.
    let column = [(1.0, SANDSTONE), (2.0, MARBLE), (3.0, SAND), (1e9, GRANITE)];
    for (x, &cut) in cuts.iter().enumerate() {
        let want = budget(f64::from(cut), &column);
        let got = 100.0 - f64::from(value(&w, "height", x, 0));
        assert!((got - want).abs() < 2e-5, "{cut}: {got}, not {want}");
    }
    let slots = [1, 4].map(|k: usize| [0, 1, 2].map(|x| value(&w, &NEW_ROCK[k].name, x, 0)));
    assert_eq!(slots[0], [0.5, 0.0, 0.0]);
    assert!((slots[1][1] - 1.9).abs() < 1e-5 && slots[1][2] == 0.0, "{slots:?}");
    assert_eq!([0, 1].map(|x| value(&w, "material", x, 0)), [2.0, 5.0]);
    assert!((value(&w, "rock_slope", 1, 0) - 65f32.to_radians().tan()).abs() < 1e-4);
}
