//! Seeds of `volcanic_island` are different islands, and all of them are islands.
use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, Control, Error, Field, Grid, Limits, World};
use eyot_land::generate::VolcanicIsland;

const SEA: f64 = 130.0;
const SIDE_M: f64 = 5120.0;

fn make(what: &VolcanicIsland, cells: usize, seed: u64) -> Field {
    let grid = Grid::new(cells, cells, SIDE_M / cells as f64, Boundary::CLOSED, &Limits::default()).unwrap();
    let (mut world, control) = (World::new(grid, seed), Control::none());
    world.sea_level_m = SEA;
    what.generate(&Site::whole(grid, seed, &world, &control), &Field::new(cells, cells, 0.0)).unwrap()
}

/// What tells islands apart.
struct Island {
    /// The highest cell as shares of the sides.
    top: [f64; 2],
    top_m: f64,
    land: f64,
    /// Length of the coast over that of a circle around the same area, with steps along cells: 4 / pi for a circle.
    coast: f64,
    /// Cells higher than everything within a sixteenth of the side, and than a third of the top.
    peaks: usize,
}

fn island(z: &Field) -> Island {
    let n = z.width();
    let dry = |x: usize, y: usize| f64::from(z.get(x, y)) > SEA;
    let (mut top, mut land, mut coast) = ((0, 0), 0, 0);
    for y in 1..n - 1 {
        for x in 1..n - 1 {
            if z.get(x, y) > z.get(top.0, top.1) {
                top = (x, y);
            }
            if dry(x, y) {
                land += 1;
                coast += [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)].iter().filter(|p| !dry(p.0, p.1)).count();
            }
        }
    }
    let top_m = f64::from(z.get(top.0, top.1)) - SEA;
    let r = n / 16;
    let higher = |x: usize, y: usize| {
        let h = z.get(x, y);
        let around = (y - r..=y + r).flat_map(|j| (x - r..=x + r).map(move |i| (i, j)));
        f64::from(h) - SEA > top_m / 3.0 && around.filter(|&p| p != (x, y)).all(|(i, j)| z.get(i, j) < h)
    };
    let peaks = (r..n - r).flat_map(|y| (r..n - r).map(move |x| (x, y))).filter(|&(x, y)| higher(x, y)).count();
    Island {
        top: [top.0, top.1].map(|i| (i as f64 + 0.5) / n as f64),
        top_m,
        land: f64::from(land) / (n * n) as f64,
        coast: coast as f64 / (4.0 * std::f64::consts::PI * f64::from(land)).sqrt(),
        peaks,
    }
}

/// Lowest and highest.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::MAX, f64::MIN], |[low, high], v| [low.min(v), high.max(v)])
}

#[test]
fn twelve_seeds_are_twelve_islands() {
    let n = 128;
    let fields: Vec<Field> = (1..=12).map(|seed| make(&VolcanicIsland::default(), n, seed)).collect();
    let all: Vec<Island> = fields.iter().map(island).collect();
    for (i, a) in all.iter().enumerate() {
        println!(
            "{}: {:?} {:.0} m, land {:.3}, coast {:.2}, {} peaks",
            i + 1,
            a.top,
            a.top_m,
            a.land,
            a.coast,
            a.peaks
        );
    }
    for axis in 0..2 {
        let [low, high] = range(all.iter().map(|a| a.top[axis]));
        assert!(high - low > 0.15, "summits between {low} and {high}");
    }
    let [low, high] = range(all.iter().map(|a| a.top_m));
    assert!(low > 200.0 && high < 1100.0 && high > 1.5 * low, "summits of {low} to {high} m");
    let [low, high] = range(all.iter().map(|a| a.land));
    assert!(low > 0.08 && high < 0.45, "land {low} to {high}");
    // Bays and headlands: all coasts are longer than a circle's.
    let [low, high] = range(all.iter().map(|a| a.coast));
    assert!(low > 1.4 && high > 1.2 * low, "coasts {low} to {high}");
    let [few, many] = range(all.iter().map(|a| a.peaks as f64));
    assert!(few >= 1.0 && many >= few + 2.0, "{few} to {many} peaks");
    for (i, a) in fields.iter().enumerate() {
        for b in &fields[i + 1..] {
            let (high_a, high_b): (Vec<bool>, Vec<bool>) =
                a.iter().zip(b.iter()).map(|(a, b)| (f64::from(a) > SEA + 100.0, f64::from(b) > SEA + 100.0)).unzip();
            let both = high_a.iter().zip(&high_b).filter(|(a, b)| **a && **b).count() as f64;
            let any = high_a.iter().zip(&high_b).filter(|(a, b)| **a || **b).count() as f64;
            assert!(both / any < 0.85, "two islands share {} of their ground", both / any);
        }
    }
}

#[test]
fn no_summit_is_a_needle_and_no_coast_touches_the_rim() {
    let n = 128;
    for seed in 1..=12 {
        let z = make(&VolcanicIsland::default(), n, seed);
        let at = island(&z).top.map(|v| (v * n as f64) as usize);
        // Around the top, 120 m away, the ground is on average less than 110 m lower: slopes below 43 degrees.
        let ring: Vec<f64> = (0..32)
            .map(|i| {
                let (s, c) = (f64::from(i) * std::f64::consts::TAU / 32.0).sin_cos();
                f64::from(z.get((at[0] as f64 + 3.0 * c).round() as usize, (at[1] as f64 + 3.0 * s).round() as usize))
            })
            .collect();
        let fall = f64::from(z.get(at[0], at[1])) - ring.iter().sum::<f64>() / ring.len() as f64;
        assert!(fall < 110.0, "seed {seed}: the top stands {fall} m over its surroundings");
        let rim = (0..n).flat_map(|i| [(i, 0), (i, n - 1), (0, i), (n - 1, i)]);
        assert!(rim.map(|(x, y)| f64::from(z.get(x, y))).all(|h| h < SEA - 2.0), "seed {seed}: land at the rim");
    }
}

#[test]
fn a_finer_grid_shows_the_same_island() {
    for seed in 1..=3 {
        let (coarse, fine) = (make(&VolcanicIsland::default(), 64, seed), make(&VolcanicIsland::default(), 192, seed));
        let off: f64 = (0..64 * 64)
            .map(|i| f64::from((coarse.get(i % 64, i / 64) - fine.get(3 * (i % 64) + 1, 3 * (i / 64) + 1)).abs()))
            .sum();
        assert!(off / 4096.0 < 5.0, "seed {seed}: {} m apart on average", off / 4096.0);
    }
}

#[test]
fn parameters_say_what_they_do() {
    let one = VolcanicIsland { volcanoes: [1, 1], variation: 0.0, calderas: 0.0, collapses: 0.0, ..Default::default() };
    let young = island(&make(&VolcanicIsland { age: [0.0, 0.0], ..one.clone() }, 96, 4));
    let old = island(&make(&VolcanicIsland { age: [1.0, 1.0], ..one.clone() }, 96, 4));
    assert!(old.top_m < young.top_m && old.land < young.land, "age lowers and the sea enters");
    let smooth = VolcanicIsland { rifts: 0.0, roughness: 0.0, cliffs: 0.0, age: [0.0, 0.0], ..one.clone() };
    assert!(island(&make(&smooth, 96, 4)).coast < young.coast);
    let bad = VolcanicIsland { age: [0.5, 0.2], ..one };
    let grid = Grid::new(8, 8, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    assert!(matches!(bad.check(&grid), Err(Error::BadParameter { field, .. }) if field == "age"));
}
