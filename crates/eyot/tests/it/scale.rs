//! The same recipe shows the same land at any number of cells: lengths are shares of the extent, not cells.

use eyot::{Field, Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions};

const COARSE: u32 = 256;
const FACTOR: usize = 4;

fn height(text: &str, size: u32, set: &[&str]) -> Field {
    let source = RecipeSource { name: "land.toml".into(), text: text.into(), folder: ".".into() };
    let set = set.iter().map(|s| (*s).to_owned()).collect();
    let overrides = Overrides { size: Some((size, None)), set, ..Overrides::default() };
    let recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).expect("a sound recipe");
    Run::start(recipe, RunOptions::default())
        .expect("a run")
        .join()
        .expect("an end")
        .world
        .get("height")
        .unwrap()
        .clone()
}

/// Means over blocks of `FACTOR` x `FACTOR` cells.
fn downsampled(fine: &Field) -> Field {
    Field::from_fn(fine.width() / FACTOR, fine.height() / FACTOR, |x, y| {
        let block = (0..FACTOR * FACTOR).map(|i| fine.get(x * FACTOR + i % FACTOR, y * FACTOR + i / FACTOR));
        (block.map(f64::from).sum::<f64>() / (FACTOR * FACTOR) as f64) as f32
    })
}

/// Root mean square of the difference between 1024 cells across, downsampled, and 256, over the relief.
fn difference(text: &str, set: &[&str]) -> f64 {
    let coarse = height(text, COARSE, set);
    let fine = downsampled(&height(text, COARSE * FACTOR as u32, set));
    assert_eq!((coarse.width(), coarse.height()), (fine.width(), fine.height()));
    let squares: f64 = coarse.iter().zip(fine.iter()).map(|(a, b)| (f64::from(a) - f64::from(b)).powi(2)).sum();
    let (low, high) = coarse.min_max();
    (squares / (coarse.width() * coarse.height()) as f64).sqrt() / f64::from(high - low)
}

/// A grid whose extent stays, twice as wide as high, so that mistaking one side for the other shows.
fn land(steps: &str) -> String {
    format!("seed = 9\n[grid]\nsize = [256, 128]\ncell = 20.0\n{steps}")
}

/// A mask of smooth hills, as the height.
fn mask(of: &str, parameters: &str) -> String {
    let hills = HILLS.replace("octaves = 5", "octaves = 3");
    format!("{hills}[[step]]\ngenerate = \"mask_{of}\"\nmerge = \"set\"\n{parameters}\n")
}

const HILLS: &str = "[[step]]\ngenerate = \"fbm\"\namplitude = 500.0\noctaves = 5\n";

#[test]
fn generators_make_the_same_land_at_any_size() {
    // Tolerances are less than twice what was measured, which stands behind them. The finest of eight octaves are smaller
    // than two coarse cells and alias, and kinks (folds of ridged noise, the crater's crest) are rounded off by the
    // downsampling. A land shifted by half a coarse cell, the likeliest mistake, would differ by 3.5e-3 in the cone.
    let cases: &[(&str, String, f64)] = &[
        ("cone", "[[step]]\ngenerate = \"cone\"\n".into(), 2e-4), // 1.1e-4
        ("fbm, 8 octaves", "[[step]]\ngenerate = \"fbm\"\n".into(), 3.5e-3), // 2.1e-3
        ("fbm, 3 octaves", "[[step]]\ngenerate = \"fbm\"\noctaves = 3\n".into(), 4.5e-4), // 2.8e-4
        ("fbm, warped", "[[step]]\ngenerate = \"fbm\"\noctaves = 3\nwarp = 0.5\n".into(), 2e-3), // 1.2e-3
        ("ridged, 8 octaves", "[[step]]\ngenerate = \"ridged\"\n".into(), 7.5e-3), // 4.6e-3
        ("ridged, 3 octaves", "[[step]]\ngenerate = \"ridged\"\noctaves = 3\n".into(), 1.2e-3), // 7.0e-4
        ("hills", HILLS.into(), 2e-3),                            // 1.0e-3
        ("warp", format!("{HILLS}[[step]]\ngenerate = \"warp\"\n"), 4e-3), // 2.4e-3
        ("smooth", format!("{HILLS}[[step]]\ngenerate = \"smooth\"\nsigma_m = 100.0\n"), 2e-4), // 1.1e-4
        ("crater", "[[step]]\ngenerate = \"cone\"\n[[step]]\ngenerate = \"crater\"\n".into(), 3.5e-3), // 2.2e-3
        ("billow", "[[step]]\ngenerate = \"billow\"\n".into(), 9e-3), // 5.3e-3
        ("value noise", "[[step]]\ngenerate = \"fbm\"\nbasis = \"value\"\n".into(), 4.5e-3), // 2.5e-3
        ("worley", "[[step]]\ngenerate = \"worley\"\n".into(), 3.5e-3), // 2.0e-3
        ("diamond-square", "[[step]]\ngenerate = \"diamond_square\"\n".into(), 3e-3), // 1.7e-3
        ("random additions", "[[step]]\ngenerate = \"random_additions\"\n".into(), 7e-3), // 3.9e-3
        ("faulting", "[[step]]\ngenerate = \"faulting\"\n".into(), 1.8e-3), // 9.6e-4
        ("circles", "[[step]]\ngenerate = \"circles\"\n".into(), 7e-3), // 4.3e-3
        ("terraces", format!("{HILLS}[[step]]\ngenerate = \"terraces\"\n"), 7e-3), // 3.9e-3
        ("remap", format!("{HILLS}[[step]]\ngenerate = \"remap\"\n"), 5.5e-3), // 3.2e-3
        ("mask of slopes", mask("slope", "from = 10.0"), 5.5e-2), // 3.2e-2
        ("mask of ridges", mask("curvature", "from = 0.0\nto = 0.05\nscale_m = 80.0"), 1.1e-1), // 7.3e-2
    ];
    let mut wrong = Vec::new();
    for (name, steps, tolerance) in cases {
        let d = difference(&land(steps), &[]);
        if d > *tolerance {
            wrong.push(format!("{name}: {d:.2e} of the relief, more than {tolerance:.0e}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_island_starts_the_same_at_any_size() {
    let text = RECIPES.iter().find(|r| r.name == "island").expect("a built-in recipe").text;
    let off = ["erosion.enabled=false", "growth.enabled=false"];
    let d = difference(text, &off);
    assert!(d <= 1e-2, "{d:.2e} of the relief"); // Cliffs and ridges are sharper than a coarse cell.
}
