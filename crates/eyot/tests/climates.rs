//! The planets of the built-in recipes have plausible climates.

use eyot::climate::stats::{Planet, Zonal, planet};
use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions, World};

fn run(name: &str, set: &[&str]) -> World {
    let size = (name != "earth").then_some((128, None));
    let overrides = Overrides { size, set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    let source = RecipeSource::builtin(name).unwrap();
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap();
    Run::start(recipe, RunOptions::default()).unwrap().join().unwrap().world
}

fn of(name: &str, set: &[&str]) -> (World, Planet) {
    let world = run(name, set);
    let planet = planet(&world).unwrap();
    (world, planet)
}

/// The belt whose middle is at this latitude.
fn belt(p: &Planet, latitude: f64) -> &Zonal {
    p.zonal.iter().find(|z| (z.latitude - latitude).abs() < 1.0).unwrap()
}

#[test]
fn the_world_has_wet_tropics_dry_belts_and_cold_poles() {
    let (world, p) = of("world", &["life.steps=900"]);
    assert!((p.ocean_share - 0.66).abs() < 0.02, "{}", p.ocean_share);
    assert!((5.0..20.0).contains(&p.temperature_c) && (300.0..1500.0).contains(&p.rain_mm), "{p:?}");
    let equator = 0.5 * (belt(&p, 7.5).rain_mm + belt(&p, -7.5).rain_mm);
    let dry = 0.5 * (belt(&p, 22.5).rain_mm + belt(&p, -22.5).rain_mm);
    let westerlies = 0.5 * (belt(&p, 52.5).rain_mm + belt(&p, -52.5).rain_mm);
    assert!(dry < 0.6 * equator, "{dry} mm in the dry belts, {equator} mm at the equator");
    assert!(westerlies > 0.8 * dry && belt(&p, 82.5).rain_mm < 0.3 * equator, "{p:?}");
    assert!(belt(&p, 7.5).temperature_c > 20.0 && belt(&p, 82.5).temperature_c < -8.0);
    assert!((0.02..0.4).contains(&p.ice_share), "{}", p.ice_share);
    // Deserts and forests, rivers and lakes.
    let share = |layer: &str, word: &str| -> f64 {
        p.zones[layer].iter().filter(|(name, _)| name.contains(word)).map(|(_, share)| share).sum()
    };
    assert!((0.05..0.7).contains(&share("koeppen", "B")), "{:?}", p.zones["koeppen"]);
    assert!(share("holdridge", "forest") > 0.1, "{:?}", p.zones["holdridge"]);
    assert!(share("zone", "river") > 0.001, "{:?}", p.zones["zone"]);
    let dry_land = |latitude: f64| belt(&p, latitude).land_rain_mm;
    assert!([22.5, -22.5].into_iter().filter_map(dry_land).any(|mm| mm < 500.0));
    // Plates made the continents and went on while the weather ran.
    let plates = eyot::plates::report(&world).unwrap().unwrap();
    assert!(plates.steps == 265 + 9 && plates.plates.len() > 4, "{plates:?}");
    assert!(plates.hypsometry.peaks_m.is_some(), "{:?}", plates.hypsometry);
    world.check_finite("the end").unwrap();
}

#[test]
fn an_ice_age_has_more_ice() {
    let (_, now) = of("world", &["life.steps=900"]);
    let (_, then) = of("iceage", &["life.steps=900"]);
    assert!(then.temperature_c < now.temperature_c - 4.0, "{} {}", then.temperature_c, now.temperature_c);
    assert!(then.ice_share > 1.1 * now.ice_share, "{} {}", then.ice_share, now.ice_share);
}

#[test]
fn a_locked_world_has_a_warm_and_a_frozen_side() {
    let (world, _) = of("locked", &["life.steps=900"]);
    let t = world.get("temperature_mean").unwrap();
    let mean = |x: usize| (24..40).map(|y| t.get(x, y)).sum::<f32>() / 16.0;
    assert!(mean(0) > mean(64) + 20.0, "{} {}", mean(0), mean(64));
}

/// The real relief: where the model must agree with any atlas.
#[test]
fn the_earth_has_its_sahara_and_its_ice_caps() {
    let (world, p) = of("earth", &["life.steps=1200"]);
    assert!((0.6..0.75).contains(&p.ocean_share), "{}", p.ocean_share);
    let at = |layer: &str, north: f64, east: f64| {
        world.get(layer).unwrap().get((east + 180.0) as usize, (90.0 - north) as usize)
    };
    assert!(at("height", 33.0, 88.0) > 4000.0, "Tibet is where it should be");
    let (sahara, amazon, congo) =
        (at("rain_mean", 22.0, 10.0), at("rain_mean", -3.0, -62.0), at("rain_mean", 0.0, 22.0));
    assert!(sahara < 300.0 && amazon > 3.0 * sahara && congo > 2.0 * sahara, "{sahara} {amazon} {congo}");
    let (congo, greenland, pole) =
        (at("temperature_mean", 0.0, 22.0), at("temperature_mean", 72.0, -40.0), at("temperature_mean", -88.0, 0.0));
    assert!(congo > 18.0 && greenland < -12.0 && pole < -20.0, "{congo} {greenland} {pole}");
    // The Andes of the south keep the westerlies' rain from Patagonia.
    let (west, east) = (at("rain_mean", -46.0, -75.0), at("rain_mean", -46.0, -68.0));
    assert!(east < 0.8 * west, "{west} mm west of the Andes, {east} mm east of them");
}
