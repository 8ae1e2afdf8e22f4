//! What forests weigh, where they end, how dense they stand, and which plants grow in which climate.

use super::{go, mean, scheduled, value, world};
use eyot_core::{Field, LayerSpec, World};
use eyot_plants::types::{TYPES, by_name};
use eyot_plants::{ClimateFrom, Plants};

/// Mean and swing of the temperature (°C), rain (mm) and dip of its driest month.
type Country = [f32; 4];

const RAIN_FOREST: Country = [26.0, 1.5, 2600.0, 0.3];
const TEMPERATE: Country = [9.0, 9.5, 800.0, 0.2];
const BOREAL: Country = [1.0, 15.0, 550.0, 0.25];
const SAVANNA: Country = [26.0, 3.0, 1000.0, 1.0];
const MONSOON: Country = [26.0, 3.0, 1400.0, 1.0];

fn of([temperature, swing, rain, dry_season]: Country) -> Plants {
    Plants { temperature, swing, rain, dry_season, hold: 0.0, ..Plants::default() }
}

/// Plants after so many years on a plain at 0 m.
fn grown(plants: Plants, size: usize, years: u64) -> World {
    let mut world = world([size, size], 20.0, |_, _| 0.0);
    go(&mut world, &[scheduled(plants)], years);
    world
}

/// Dry matter, t/ha.
fn tons(world: &World) -> f64 {
    10.0 * mean(world, "plant_mass")
}

/// Share of the cells whose cover is within these.
fn share(world: &World, low: f32, high: f32) -> f64 {
    let cover = world.get("forest").unwrap();
    let values = cover.to_vec();
    values.iter().filter(|c| (low..high).contains(c)).count() as f64 / values.len() as f64
}

#[test]
fn forests_weigh_what_forests_weigh() {
    for (name, country, low, high) in [
        ("tropical", RAIN_FOREST, 250.0, 350.0),
        ("temperate", TEMPERATE, 150.0, 250.0),
        ("boreal", BOREAL, 60.0, 120.0),
        ("savanna", [26.0, 3.0, 500.0, 1.0], 10.0, 60.0),
    ] {
        let found = tons(&grown(Plants { fires: 0.2, ..of(country) }, 32, 250));
        assert!((low..=high).contains(&found), "{name}: {found:.0} t/ha, not {low} to {high}");
    }
}

#[test]
fn stands_thin_themselves_by_the_rule_of_three_halves() {
    for (name, country) in [("temperate_summergreen", TEMPERATE), ("tropical_evergreen", RAIN_FOREST)] {
        let (n, t) = (by_name(name).unwrap(), TYPES[by_name(name).unwrap()]);
        let plants = Plants { types: vec![name.into()], far: 0.0, fires: 0.0, ..of(country) };
        let mut w = world([12, 12], 20.0, |_, _| 0.0);
        // Eight stems on 10 m2, thick as a thumb.
        let put = |w: &mut World, spec: LayerSpec, v: f32| w.put(&spec, Field::from_fn(12, 12, |_, _| v)).unwrap();
        put(&mut w, eyot_plants::types::biomass(n), 0.8 * t.mass_of(0.02));
        put(&mut w, eyot_plants::types::stem(n), 0.02);
        let mut points = Vec::new();
        for _ in 0..28 {
            go(&mut w, &[scheduled(plants.clone())], 5);
            // Where no old tree has fallen.
            let of = |layer: &str, i: usize| value(&w, &format!("{layer}_{name}"), i % 12, i / 12);
            let whole = (0..144).max_by(|a, b| of("stem", *a).total_cmp(&of("stem", *b))).unwrap();
            let (stem, biomass) = (of("stem", whole), of("biomass", whole));
            let number = biomass / t.mass_of(stem);
            if number < 0.7 && stem < 0.35 * t.stem {
                points.push((f64::from(number).ln(), f64::from(t.mass_of(stem)).ln()));
            }
        }
        let k = points.len() as f64;
        let (sx, sy) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / k, b + y / k));
        let (sxy, sxx) =
            points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - sx) * (y - sy), b + (x - sx).powi(2)));
        let exponent = sxy / sxx;
        println!("{name}: {exponent:.2} of {k} points");
        assert!((exponent + 1.5).abs() <= 0.2, "{name}: {exponent:.2}");
    }
}

#[test]
fn the_tree_line_is_where_the_season_is_too_cold() {
    // A slope from 0 to 3000 m, in three climates.
    for (temperature, swing) in [(8.0, 9.0), (12.0, 8.0), (4.0, 13.0)] {
        let plants = Plants { temperature, swing, rain: 1500.0, lapse: 6.0, slope: 89.0, fires: 0.0, ..of(TEMPERATE) };
        let mut w = world([8, 151], 20.0, |_, y| 20.0 * y as f32);
        go(&mut w, &[scheduled(plants)], 300);
        let season = |h: f32| {
            let mean = f64::from(temperature - 0.006 * h);
            let days: Vec<f64> = (0..365).map(|d| mean - f64::from(swing) * (f64::from(d) * 0.017_214).cos()).collect();
            let warm: Vec<f64> = days.into_iter().filter(|t| *t > 0.9).collect();
            (warm.len(), warm.iter().sum::<f64>() / warm.len().max(1) as f64)
        };
        let theirs =
            (0..3000).map(|h| h as f32).take_while(|h| season(*h).0 >= 94 && season(*h).1 >= 6.4).last().unwrap();
        let row = |y: usize| (0..8).map(|x| value(&w, "forest", x, y)).sum::<f32>() / 8.0;
        let ours = 20.0 * (0..151).rev().find(|y| row(*y) > 0.1).unwrap() as f32;
        println!("{temperature} °C: trees up to {ours} m, the line is at {theirs} m");
        assert!((ours - theirs).abs() <= 100.0, "{temperature} °C: trees up to {ours} m, the line is at {theirs} m");
    }
}

#[test]
fn woody_cover_stays_below_sankarans_line() {
    for rain in [150.0f32, 250.0, 350.0, 450.0, 550.0, 650.0] {
        for fires in [0.0, 0.6] {
            let w = grown(Plants { rain, fires, ..of(SAVANNA) }, 16, 250);
            let most = 0.01 * (0.14 * f64::from(rain) - 14.2);
            let cover = mean(&w, "forest") + mean(&w, "shrubs");
            println!("{rain} mm, fires {fires}: {cover:.3} of at most {most:.3}");
            assert!(cover <= most, "{rain} mm: {cover:.3} is above {most:.3}");
        }
    }
}

#[test]
fn fire_makes_savanna_and_forest_of_one_climate() {
    let burnt = grown(of(MONSOON), 40, 300);
    let [open, between, closed] = [(0.0, 0.5), (0.5, 0.75), (0.75, 1.1)].map(|(a, b)| share(&burnt, a, b));
    println!("open {open:.2}, between {between:.2}, closed {closed:.2}");
    assert!(open > 0.15 && closed > 0.15 && between < 0.15, "open {open:.2}, between {between:.2}, closed {closed:.2}");
    let spared = share(&grown(Plants { fires: 0.0, ..of(MONSOON) }, 24, 300), 0.75, 1.1);
    assert!(spared > 0.85, "without fires {spared:.2} is closed");
}

/// Biomes as Whittaker draws them over the mean temperature (°C) and the rain (mm).
fn whittaker(t: f32, p: f32) -> &'static str {
    match t {
        t if t < -5.0 => "tundra",
        t if t < 4.0 => {
            if p < 220.0 {
                "grassland"
            } else {
                "boreal forest"
            }
        }
        t if t < 19.0 => match p {
            p if p < 200.0 + 15.0 * t => "grassland",
            p if p < 400.0 + 30.0 * t => "woodland",
            _ => "temperate forest",
        },
        _ => match p {
            p if p < 400.0 => "desert",
            p if p < 2200.0 => "savanna, seasonal forest",
            _ => "rain forest",
        },
    }
}

/// The biome of what grows, in the same words.
fn biome(t: f32, [forest, shrubs, grass]: [f32; 3], kind: &str) -> &'static [&'static str] {
    match kind {
        k if forest > 0.4 && k == "tropical_evergreen" => &["rain forest"],
        k if forest > 0.4 && k.starts_with("tropical") => &["savanna, seasonal forest"],
        k if forest > 0.4 && (k.starts_with("boreal") || k == "larch") => &["boreal forest"],
        _ if forest > 0.6 => &["temperate forest"],
        _ if t >= 19.0 && grass > 0.35 => &["savanna, seasonal forest"],
        // Scrub is a desert to Whittaker.
        _ if t >= 19.0 && forest.max(shrubs) > 0.1 => &["savanna, seasonal forest", "desert"],
        _ if forest > 0.2 => &["woodland", "savanna, seasonal forest"],
        _ if t < -5.0 => &["tundra"],
        _ if t >= 19.0 => &["desert"],
        _ if shrubs > 0.3 => &["woodland"],
        _ => &["grassland", "tundra"],
    }
}

#[test]
fn what_grows_is_what_the_climate_asks_for() {
    const COUNTRIES: [usize; 2] = [15, 12];
    let climate = |x: usize, y: usize| (-11.25 + 2.75 * (x / 4) as f32, 120.0 * 1.35f32.powi((y / 4) as i32));
    let [w, h] = COUNTRIES.map(|n| 4 * n);
    let mut land = world([w, h], 20.0, |_, _| 0.0);
    let mut put = |name: &'static str, f: &dyn Fn(f32, f32) -> f32| {
        let spec = LayerSpec::new(name, "1", "Climate", (-1e8, 1e8));
        land.put(
            &spec,
            Field::from_fn(w, h, |x, y| {
                let (t, p) = climate(x, y);
                f(t, p)
            }),
        )
        .unwrap();
    };
    put("temperature_mean", &|t, _| t);
    put("temperature_cos", &|t, _| (0.45 * (27.0 - t)).max(1.5));
    put("temperature_sin", &|_, _| 0.0);
    put("rain_mean", &|_, p| p);
    // Where it is hot a season is dry, unless there is rain for all of the year.
    put("rain_cos", &|t, p| {
        if t < 19.0 {
            0.2 * p
        } else if p < 2000.0 {
            p
        } else {
            0.2 * p
        }
    });
    put("rain_sin", &|_, _| 0.0);
    go(&mut land, &[scheduled(Plants { climate: ClimateFrom::Layers, hold: 0.0, ..Plants::default() })], 300);
    let (mut right, mut all) = (0, 0);
    for j in 0..COUNTRIES[1] {
        let mut line = String::new();
        for i in 0..COUNTRIES[0] {
            let (t, p) = climate(4 * i, 4 * j);
            let cells = || (0..16).map(|k| (4 * i + k % 4, 4 * j + k / 4));
            let of = |layer: &str| cells().map(|(x, y)| value(&land, layer, x, y)).sum::<f32>() / 16.0;
            let weight = |n: &usize| of(&format!("biomass_{}", TYPES[*n].name));
            let most = (0..11).max_by(|a, b| weight(a).total_cmp(&weight(b))).unwrap();
            let found = biome(t, ["forest", "shrubs", "grass"].map(of), TYPES[most].name);
            // Borders are no lines in nature either.
            let near =
                [(0.0, 1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.85), (0.0, 1.15)].map(|(d, f)| whittaker(t + d, f * p));
            let fits = near.iter().any(|b| found.contains(b));
            line.push_str(&format!("{}{:3} ", if fits { ' ' } else { '!' }, &found[0][..3]));
            all += 1;
            right += usize::from(fits);
        }
        println!("{:5.0} mm {line}", climate(0, 4 * j).1);
    }
    let share = right as f64 / all as f64;
    println!("{share:.3}");
    assert!(share >= 0.85, "{right} of {all} biomes are right");
}

#[test]
#[ignore = "prints a table for choosing how often it burns"]
fn cover_by_fires() {
    for fires in [0.45, 0.5, 0.55, 0.6] {
        for rain in [350.0, 500.0, 650.0, 900.0, 1400.0] {
            let w = grown(Plants { rain, fires, ..of(SAVANNA) }, 40, 250);
            println!(
                "fires {fires} rain {rain}: {:.0} t/ha cover {:.2} open {:.2} closed {:.2} grass {:.2} burnt {:.2} shrubs {:.2}",
                tons(&w),
                mean(&w, "forest"),
                share(&w, 0.0, 0.5),
                share(&w, 0.75, 1.1),
                mean(&w, "grass"),
                mean(&w, "burnt_area"),
                mean(&w, "shrubs")
            );
        }
    }
}
