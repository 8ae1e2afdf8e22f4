//! Rain makes rivers: what hydraulic and thermal erosion do to noise, measured.
//!
//! Noise is no landscape: it is full of pits, its valleys lead nowhere and are as sharp as its ridges. Erosion has to drain
//! it, and to dig where much water flows rather than everywhere.

use eyot::{Control, Field, Grid, Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_drainage::{Base, FlatRule, Routing, fill, outlets};
use eyot_land::analyse::{TerrainOptions, TerrainStats, terrain_stats};

/// Hills of 25 degrees on average: about as steep as noise may be before nothing but slides happens.
const LAND: &str = r#"
seed = 3
sea_level = -5000.0

[grid]
size = 256
cell = 30.0
rim = "open"

[[step]]
generate = "fbm"
amplitude = 500.0
scale = 0.4
octaves = 9
offset = 1200.0

[[step]]
name = "rain"
simulate = ["hydraulic", "thermal"]
steps = 1500
hydraulic.time_step = 1.0
hydraulic.capacity = 1.0
hydraulic.ramp_depth = 0.3
hydraulic.dig = 0.1
hydraulic.settle = 0.02
hydraulic.rain = 0.004
hydraulic.evaporation = 0.002
hydraulic.max_speed = 5.0
thermal.talus = 28.0
thermal.every = 3

[view]
enabled = false
"#;

fn run(set: &[&str]) -> World {
    let source = RecipeSource { name: "rivers.toml".into(), text: LAND.into(), folder: ".".into() };
    let overrides = Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..Overrides::default() };
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).expect("a sound recipe");
    Run::start(recipe, RunOptions::default()).expect("a run").join().expect("an end").world
}

fn height(world: &World) -> &Field {
    world.get("height").expect("land")
}

fn measured(height: &Field, grid: &Grid) -> TerrainStats {
    terrain_stats(height, grid, None, &TerrainOptions::default(), &Limits::default()).expect("statistics")
}

/// Gaussian smoothing over `sigma` cells; the rim's cell goes on beyond it.
fn smoothed(f: &Field, sigma: f64) -> Field {
    let reach = (4.0 * sigma).ceil() as isize;
    let bell: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let sum: f64 = bell.iter().sum();
    let along = |f: &Field, dx: isize, dy: isize| {
        Field::from_fn(f.width(), f.height(), |x, y| {
            let at = |k: isize| {
                let x = (x as isize + k * dx).clamp(0, f.width() as isize - 1);
                let y = (y as isize + k * dy).clamp(0, f.height() as isize - 1);
                f64::from(f.get(x as usize, y as usize))
            };
            (bell.iter().zip(-reach..=reach).map(|(b, k)| b * at(k)).sum::<f64>() / sum) as f32
        })
    };
    along(&along(f, 1, 0), 0, 1)
}

/// How much deeper the cells of `channels` lie under the smoothed surface than its cells do on average, m.
fn depth_under_smoothed(height: &Field, channels: &[bool]) -> f64 {
    let smooth = smoothed(height, 4.0);
    let depth: Vec<f64> = smooth.iter().zip(height.iter()).map(|(s, h)| f64::from(s) - f64::from(h)).collect();
    let in_channels: Vec<f64> = depth.iter().zip(channels).filter(|&(_, &c)| c).map(|(d, _)| *d).collect();
    in_channels.iter().sum::<f64>() / in_channels.len() as f64 - depth.iter().sum::<f64>() / depth.len() as f64
}

/// The 3 % of the cells that the most water would flow through.
fn channels(height: &Field, grid: &Grid) -> Vec<bool> {
    let mut z = height.to_vec();
    let out = outlets(&z, grid, &Base { closed_rims: true, ..Base::default() }).expect("outlets");
    fill(&mut z, grid, &out, &Control::none()).expect("filled land");
    let cells =
        Routing::with_flats(&z, grid, &out, FlatRule::Shortest, &Control::none()).expect("a network").upstream_cells();
    let mut sorted = cells.clone();
    sorted.sort_unstable();
    let least = sorted[sorted.len() - 1 - sorted.len() * 3 / 100];
    cells.iter().map(|&c| c > least).collect()
}

#[test]
fn rain_and_slides_drain_noise() {
    let (start, end) = (run(&["rain.enabled=false"]), run(&[]));
    let (before, after) = (measured(height(&start), &start.grid), measured(height(&end), &end.grid));
    let both = format!("before {before:?}\nafter {after:?}");
    // 13.6 to 5.6. Seeds 4 to 6: 12.6 to 3.9, 12.9 to 3.7, 13.3 to 5.0.
    assert!(after.pits_per_1000 < before.pits_per_1000.map(|p| 0.5 * p), "{both}");
    // 0.303 to 0.243: the pits are gone, the lakes between the largest hills are not. Seeds 4 to 6: a fall of 0.05 to 0.07.
    assert!(after.depression_fraction < before.depression_fraction.map(|d| d - 0.03), "{both}");
    // 23.2 m to 15.1 m. Seeds 4 to 6: to 0.64, 0.56 and 0.49 of the start.
    assert!(after.fill_mean_m < before.fill_mean_m.map(|f| 0.8 * f), "{both}");
    // -0.001 to 0.046: channels of eight pipes are narrower than those of four, which end at -0.122 with ridges sharper than the
    // floors of valleys. Measured land lies between -0.8 and -0.02.
    let (skew0, skew1) = (before.curvature_skew.unwrap(), after.curvature_skew.unwrap());
    assert!(skew0.abs() < 0.02 && skew1 < 0.06, "{both}");
    let four = run(&["rain.hydraulic.flux=signed"]);
    let skew4 = measured(height(&four), &four.grid).curvature_skew.unwrap();
    assert!((-0.8..-0.02).contains(&skew4), "{skew4}");
}

/// Incision: how much deeper the cells with the most water lie under their surroundings than they did at the start.
///
/// Of the water alone. With slides at 28 degrees as well, which level hollows everywhere, the same cells end between 1.2 m
/// less and 0.3 m more deep than they began (seeds 3 to 6), so that this measure says nothing about the water.
#[test]
fn rain_digs_where_water_gathers() {
    let start = run(&["rain.enabled=false"]);
    let deepening = |world: &World| {
        let rivers = channels(height(world), &world.grid);
        depth_under_smoothed(height(world), &rivers) - depth_under_smoothed(height(&start), &rivers)
    };
    // 4.1 m on 8.4 m. Seeds 4 to 6: 1.0 m, 3.2 m, 2.2 m.
    let water = deepening(&run(&["thermal.enabled=false"]));
    assert!(water > 1.5, "{water} m");
    // What is not made by water shows nothing: 0.2 m. Seeds 4 to 6: 0.0 m, -0.2 m, -0.7 m.
    let slides = deepening(&run(&["hydraulic.enabled=false"]));
    assert!(slides.abs() < 0.5, "{slides} m");
}
