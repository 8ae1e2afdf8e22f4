//! The process `plants`: what is conserved, what kills, what holds, and what is refused.

use super::{go, mean, scheduled, value, world};
use eyot_core::layer::known::ERODIBILITY;
use eyot_core::process::Process;
use eyot_core::{Field, World};
use eyot_plants::{Plants, types};

fn temperate() -> Plants {
    Plants { temperature: 9.0, swing: 9.0, rain: 800.0, ..Plants::default() }
}

fn few(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

fn hills(size: usize) -> World {
    world([size, size], 20.0, |x, y| 60.0 * ((x as f32 * 0.3).sin() + (y as f32 * 0.23).cos()))
}

#[test]
fn what_there_is_is_what_grew_less_what_died_and_burnt() {
    let mut w = hills(24);
    go(&mut w, &[scheduled(Plants { fires: 0.8, dry_season: 1.0, ..temperate() })], 60);
    let there: f64 = types::TYPES.iter().map(|t| w.get(&format!("biomass_{}", t.name)).unwrap().sum()).sum();
    // A kg/m2 is a mm in the ledger.
    let there = 1e-3 * there * w.grid.cell_area_m2();
    let of = |account: &str| w.ledger.iter().find(|a| a.0 == account).map_or(0.0, |a| a.1.amount.abs());
    let [grown, died, burnt] = ["plants.grown", "plants.died", "plants.burnt"].map(of);
    println!("{there} of {grown} grown, {died} died, {burnt} burnt");
    assert!(there > 1.0 && died > 0.1 && burnt > 0.1);
    assert!((grown - died - burnt - there).abs() < 1e-3 * grown);
}

#[test]
fn water_slides_and_rivers_kill() {
    let mut w = hills(16);
    let plants = || [scheduled(temperate())];
    go(&mut w, &plants(), 60);
    assert!(mean(&w, "forest") > 0.3, "{}", mean(&w, "forest"));
    let grown: Vec<(usize, usize)> =
        (0..256).map(|i| (i % 16, i / 16)).filter(|(x, y)| value(&w, "plant_mass", *x, *y) > 1.0).collect();
    let [slide, lake, river] = [grown[0], grown[40], grown[80]];
    let mut slid = w.clone();
    for (layer, (x, y), v) in [("height", slide, 500.0), ("lake", lake, 3.0), ("river", river, 1.0)] {
        slid.layer_mut(layer).unwrap().field.set(x, y, v);
    }
    go(&mut slid, &plants(), 1);
    for (x, y) in [slide, river] {
        assert!(value(&slid, "plant_mass", x, y) < 0.05, "{x} {y}");
    }
    go(&mut slid, &plants(), 3);
    assert!(value(&slid, "plant_mass", lake.0, lake.1) < 0.05);
}

#[test]
fn roots_hold_the_ground_and_leave_what_others_write() {
    let mut w = hills(16);
    w.put(&ERODIBILITY, Field::from_fn(16, 16, |x, _| 0.5 + 0.1 * x as f32)).unwrap();
    go(&mut w, &[scheduled(temperate())], 40);
    let (x, y) = (8, 8);
    let cover = {
        let bare = ["forest", "shrubs"].map(|l| 1.0 - value(&w, l, x, y));
        1.0 - bare[0] * bare[1] * (1.0 - 0.7 * value(&w, "grass", x, y))
    };
    let held = value(&w, "erodibility", x, y);
    assert!((held - 1.3 * (1.0 - 0.9 * cover)).abs() < 1e-3, "{held} under {cover}");
    // Another rock comes to light.
    w.layer_mut("erodibility").unwrap().field.set(x, y, 0.2);
    go(&mut w, &[scheduled(temperate())], 2);
    assert!((value(&w, "erodibility_bare", x, y) - 0.2).abs() < 1e-5);
    assert!((value(&w, "erodibility_bare", 3, 3) - 0.8).abs() < 1e-5);
    // Without it the layer stays away.
    let mut none = hills(8);
    go(&mut none, &[scheduled(Plants { hold: 0.0, ..temperate() })], 1);
    assert!(none.get("erodibility").is_none());
}

#[test]
fn what_bears_shade_follows_what_needs_light() {
    let plants = Plants {
        types: few(&["boreal_summergreen", "boreal_needle"]),
        temperature: 1.0,
        swing: 15.0,
        rain: 550.0,
        fires: 0.0,
        ..Plants::default()
    };
    let mut w = world([24, 24], 20.0, |_, _| 0.0);
    let share = |w: &World| {
        let [birch, spruce] = ["boreal_summergreen", "boreal_needle"].map(|n| mean(w, &format!("biomass_{n}")));
        birch / (birch + spruce)
    };
    go(&mut w, &[scheduled(plants.clone())], 40);
    let young = share(&w);
    go(&mut w, &[scheduled(plants)], 260);
    let old = share(&w);
    println!("birch: {young:.2} of the young wood, {old:.2} of the old one");
    assert!(young > 0.6 && old < 0.4, "{young:.2} {old:.2}");
}

#[test]
fn what_cannot_be_is_refused() {
    let w = hills(8);
    let refused = |plants: Plants| plants.check(&w.grid).unwrap_err().to_string();
    let unknown = refused(Plants { types: few(&["larch", "oak"]), ..Plants::default() });
    assert!(unknown.contains("`oak`") && unknown.contains("boreal_needle"), "{unknown}");
    let twice = refused(Plants { types: few(&["larch", "larch"]), ..Plants::default() });
    assert!(twice.contains("twice"), "{twice}");
    assert!(refused(Plants { types: Vec::new(), ..Plants::default() }).contains("at least one"));
    let wrong = refused(Plants { open: 0.7, closed: 0.5, ..Plants::default() });
    assert!(wrong.contains("0.7") && wrong.contains("`closed`"), "{wrong}");
}
