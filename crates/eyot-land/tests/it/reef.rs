//! Reef growth and seabed against closed forms: light, keep-up and give-up, sea level, limestone, atolls.
//!
//! Numbers after "measured" were read when the test was written; the assertion beside them is the criterion.

use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::{CARBON, HEIGHT, LIMESTONE, WATER, WETNESS};
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::reference::Reference;
use eyot_core::rng::{self, Key};
use eyot_core::{Boundary, Field, Grid, Limits, World};
use eyot_land::simulate::reef::{Light, Limit, Reef};
use eyot_land::simulate::{Hydraulic, Seabed};

fn scheduled(p: impl Process + 'static) -> Scheduled {
    Scheduled { name: "test", process: Box::new(p), every: 1 }
}

fn world(width: usize, height: usize, cell_m: f64, rim: Boundary, ground: impl Fn(usize, usize) -> f32) -> World {
    let mut w = World::new(Grid::new(width, height, cell_m, rim, &Limits::default()).unwrap(), 1);
    w.put(&HEIGHT, Field::from_fn(width, height, ground)).unwrap();
    w
}

fn run(w: &mut World, p: &Reef, steps: u64) {
    go(w, &[scheduled(p.clone())], 0, steps);
}

fn go(w: &mut World, processes: &[Scheduled], from: u64, steps: u64) {
    CpuEngine::default().simulate(w, processes, Span { from, steps }, &Control::none()).unwrap();
}

fn noise(x: usize, y: usize) -> f32 {
    rng::unit::<f32>(rng::hash(Key::new(31, 0, 0), (y * 4096 + x) as u32))
}

/// Light alone, nothing else moves.
fn lit() -> Reef {
    Reef { limit: Limit::Light, years_per_step: 1.0, ..Default::default() }
}

// -------------------------------------------------------------------------------------------------------------- Light

/// G1.
#[test]
fn growth_is_monotone_in_light_and_ends_at_both_depths() {
    for light in [Light::Exponential, Light::Saturating] {
        let p = Reef { light, ..lit() };
        // Depths 0, 0.25, 0.5 ... 50 m, one a column.
        let mut w = world(201, 1, 10.0, Boundary::CLOSED, |x, _| -0.25 * x as f32);
        run(&mut w, &p, 1);
        let grown = w.get("limestone").unwrap();
        let mut last = f32::INFINITY;
        for x in 0..201 {
            let (depth, g) = (0.25 * x as f32, grown.get(x, 0));
            if depth <= p.shallow || depth >= p.deep {
                assert_eq!(g, 0.0, "{light:?} at {depth} m");
            } else {
                assert!(g > 0.0 && g <= last, "{light:?} at {depth} m: {g} after {last}");
                assert!(g <= p.growth * p.years_per_step * (1.0 + f32::EPSILON));
                last = g;
            }
        }
    }
    // More light at the same depth never means less growth.
    let mut last = 0.0;
    for surface_light in [1.0, 50.0, 200.0, 1000.0, 5000.0, 10_000.0] {
        let mut w = world(1, 1, 10.0, Boundary::CLOSED, |_, _| -15.0);
        run(&mut w, &Reef { light: Light::Saturating, surface_light, ..lit() }, 1);
        let g = w.get("limestone").unwrap().get(0, 0);
        assert!(g >= last, "{surface_light}: {g} after {last}");
        last = g;
    }
    assert!(last > 0.0119, "saturated: {last} m a year of 0.012");
}

/// Bosscher and Schlager 1992: growth tanh(I0 e^(-k g) / Ik).
#[test]
fn saturating_light_follows_its_formula() {
    let p = Reef { light: Light::Saturating, ..lit() };
    for depth in [1.0f64, 5.0, 10.0, 20.0, 30.0, 39.0] {
        let mut r = Reference::<f64>::new(&world(1, 1, 10.0, Boundary::CLOSED, |_, _| -depth as f32));
        r.simulate(&[scheduled(p.clone())], 1);
        let grown: f64 = r.get("limestone", 0, 0);
        let relative = 2000.0 * (-f64::from(p.attenuation) * depth).exp() / 250.0;
        let expected = f64::from(p.growth) * relative.tanh();
        assert!((grown / expected - 1.0).abs() < 1e-6, "{depth} m: {grown}, {expected}");
    }
}

/// G1: a column of coral in exponential light: `dg/dt = -G e^(-g/D)`, so `d/dt e^(g/D) = -G / D`: `e^(g/D)` falls in a
/// straight line, `e^(g/D) = e^(g0/D) - G t / D`, until the coral is at the shallow limit.
#[test]
fn a_column_follows_the_closed_form() {
    let p = lit();
    let (growth, scale) = (f64::from(p.growth), f64::from(p.light_depth));
    for start in [38.0f64, 25.0, 10.0] {
        let mut w = world(1, 1, 10.0, Boundary::CLOSED, |_, _| -start as f32);
        let e0 = (start / scale).exp();
        let mut worst = 0.0f64;
        // Years until depth 1 m.
        let years = ((e0 - (1.0 / scale).exp()) * scale / growth) as u64;
        for i in 0..20 {
            go(&mut w, &[scheduled(p.clone())], i * (years / 20), years / 20);
            let depth = -f64::from(w.get("height").unwrap().get(0, 0));
            let expected = e0 - growth * ((i + 1) * (years / 20)) as f64 / scale;
            worst = worst.max(((depth / scale).exp() / expected - 1.0).abs());
        }
        println!("G1 column from {start} m, {years} years: {worst:e}");
        // Criterion 1e-3. Measured 5e-4.
        assert!(worst <= 1e-3);
        run(&mut w, &p, 1000);
        let depth = -w.get("height").unwrap().get(0, 0);
        assert!((depth - p.shallow).abs() < 1e-5, "it ends at the shallow limit: {depth}");
    }
}

/// G1: where the sea rises at `r`, depth follows `dg/dt = r - G e^(-g/D)`. Growth falls with depth, so `g* = D ln(G / r)` is an
/// equilibrium that repels: shallower reefs rise to the shallow limit `s` and stay there, deeper ones drown. A reef that
/// starts at depth `g0` therefore switches from keeping up to giving up at `r = G e^(-g0/D)`, and one that has reached its
/// limit at `r = G e^(-s/D)`: the depth that decides is the one from which it starts, and for a grown reef the shallow
/// limit. In steps of `T` years the latter has sunk to `s + r T` when it grows, here 0.012 m deeper, 0.06 % of `r`; rounding
/// does as much again once the sea stands 700 m higher, where floats have steps of 6e-5 m.
#[test]
fn reefs_keep_up_or_give_up_at_the_analytic_rate() {
    let keeps_up = |rise: f64, start: f64| {
        let p = Reef { sea_level_rise: rise as f32, ..lit() };
        let mut w = world(1, 1, 10.0, Boundary::CLOSED, |_, _| -start as f32);
        run(&mut w, &p, 60_000);
        let depth = w.sea_level_m - f64::from(w.get("height").unwrap().get(0, 0));
        // A repelling equilibrium: whoever is shallower than at the start keeps up, whoever is deeper drowns.
        depth < start.max(f64::from(p.shallow) + 0.1)
    };
    let p = lit();
    for start in [f64::from(p.shallow), 5.0, 15.0, 30.0] {
        let analytic = f64::from(p.growth) * (-start / f64::from(p.light_depth)).exp();
        let (mut low, mut high) = (0.5 * analytic, 1.5 * analytic);
        assert!(keeps_up(low, start) && !keeps_up(high, start));
        while high - low > 2e-4 * analytic {
            let middle = 0.5 * (low + high);
            if keeps_up(middle, start) { low = middle } else { high = middle }
        }
        println!("G1 switch from {start} m at {low:.7} m/yr, analytic {analytic:.7}: {:+.5}", low / analytic - 1.0);
        // Criterion 2 %. Measured -0.13 % at the limit, 0.02 % from the other depths.
        assert!((low / analytic - 1.0).abs() <= 0.02);
    }
}

// ---------------------------------------------------------------------------------------------------------- Sea level

#[test]
fn the_sea_follows_rise_and_curve() {
    let p = Reef {
        years_per_step: 10.0,
        sea_level_rise: 0.001,
        sea_level_curve: vec![[100.0, 2.0], [200.0, -6.0], [250.0, 4.0]],
        ..Default::default()
    };
    let curve = |t: f64| match t {
        t if t <= 100.0 => 2.0,
        t if t <= 200.0 => 2.0 - 8.0 * (t - 100.0) / 100.0,
        t if t <= 250.0 => -6.0 + 10.0 * (t - 200.0) / 50.0,
        _ => 4.0,
    };
    let mut w = world(2, 2, 10.0, Boundary::CLOSED, |_, _| -100.0);
    w.sea_level_m = 3.0;
    for i in 0..40 {
        go(&mut w, &[scheduled(p.clone())], i, 1);
        let t = 10.0 * (i + 1) as f64;
        // The level at the start is the one that the world has; the curve tells how it changes from there.
        let expected = 3.0 + 0.001 * t + curve(t) - curve(0.0);
        assert!((w.sea_level_m - expected).abs() < 1e-6, "year {t}: {}, expected {expected}", w.sea_level_m);
    }
    // A step longer than the curve's pieces arrives at the same level.
    let long = Reef { years_per_step: 400.0, ..p };
    assert!((long.sea_level_change(0) - (0.4 + 4.0 - 2.0)).abs() < 1e-6);
    assert_eq!(Reef::default().sea_level_change(7), 0.0);
}

#[test]
fn curves_that_go_back_in_time_are_refused() {
    for curve in [vec![[1.0, 0.0], [1.0, 1.0]], vec![[2.0, 0.0], [1.0, 0.0]], vec![[0.0, f64::NAN]]] {
        let p = Reef { sea_level_curve: curve, ..Default::default() };
        let mut w = world(2, 2, 10.0, Boundary::CLOSED, |_, _| -10.0);
        let refused =
            CpuEngine::default().simulate(&mut w, &[scheduled(p)], Span { from: 0, steps: 1 }, &Control::none());
        assert!(refused.unwrap_err().to_string().contains("sea_level_curve"));
    }
}

#[test]
fn subsidence_takes_ground_and_limestone_along() {
    let p = Reef { subsidence: 0.002, growth: 0.0, years_per_step: 10.0, ..Default::default() };
    let mut w = world(9, 7, 10.0, Boundary::CLOSED, |x, y| 30.0 * noise(x, y) - 20.0);
    let before = w.get("height").unwrap().clone();
    run(&mut w, &p, 500);
    for (a, b) in before.iter().zip(w.get("height").unwrap().iter()) {
        assert!((a - b - 10.0).abs() < 1e-3, "{a} became {b}");
    }
    let sunk = w.ledger.amount("ground.subsided");
    // Steps of 0.02 m, rounded at heights of 10 to 30 m; measured 1.5e-5. The ledger knows the rounded ones.
    assert!((sunk / (63.0 * 100.0 * 10.0) - 1.0).abs() < 1e-4, "{sunk} m3");
    let lost = (before.sum() - w.get("height").unwrap().sum()) * 100.0;
    assert!((sunk / lost - 1.0).abs() < 1e-9, "{sunk} m3 in the ledger, {lost} m3 lost");
    assert_eq!(w.get("limestone").unwrap().min_max(), (0.0, 0.0));
}

// ---------------------------------------------------------------------------------------------------------- Limestone

/// An island in a shallow sea, with room for reefs.
fn island(n: usize, cell_m: f64, rim: Boundary, top: f32, slope: f32) -> World {
    world(n, n, cell_m, rim, |x, y| {
        let c = (n - 1) as f32 / 2.0;
        top - slope * cell_m as f32 * (x as f32 - c).hypot(y as f32 - c)
    })
}

#[test]
fn limestone_is_what_the_ledger_says_and_counters_stay_within_bounds() {
    for (limit, light) in [(Limit::Carbon, Light::Exponential), (Limit::Light, Light::Saturating)] {
        let p = Reef { limit, light, sea_level_rise: 0.002, subsidence: 0.001, ..Default::default() };
        let mut w = island(40, 20.0, Boundary::OPEN, 30.0, 0.2);
        let before = w.get("height").unwrap().sum();
        run(&mut w, &p, 1000);
        let area = w.grid.cell_area_m2();
        let stone = w.get("limestone").unwrap().sum() * area;
        let (grown, worn) = (w.ledger.amount("limestone.grown"), w.ledger.amount("limestone.worn"));
        println!(
            "G1 {limit:?}: limestone {stone:e}, ledger off by {:e}, grown {grown:e}, worn {worn:e}",
            w.ledger.net("limestone") / stone - 1.0
        );
        // Criterion 1e-6. Measured 8e-13, for the ground 2e-11. Without erosion nothing but rounding is worn.
        assert!(stone > 0.0 && (w.ledger.net("limestone") / stone - 1.0).abs() <= 1e-6);
        assert!(worn <= 1e-4 * grown);
        let ground = (w.get("height").unwrap().sum() - before) * area;
        println!("G1 ground off by {:e}", (ground - w.ledger.net("ground")) / grown);
        assert!((ground - w.ledger.net("ground")).abs() <= 1e-6 * grown);
        for (name, low, high) in [("growth", 0.0, 1.0), ("carbon", 0.0, 1.0)] {
            let (a, b) = w.get(name).unwrap().min_max();
            assert!(low <= a && b <= high && b > 0.0, "{name}: {a}..{b}");
        }
        // Growth has a memory: it is above zero where coral grew lately and only there.
        let (c, s) = (w.get("growth").unwrap(), w.get("limestone").unwrap());
        assert!(c.iter().zip(s.iter()).all(|(c, s)| c == 0.0 || s > 0.0));
    }
}

#[test]
fn erosion_takes_limestone_before_the_ground_below() {
    let mut w = world(4, 1, 10.0, Boundary::CLOSED, |_, _| -10.0);
    run(&mut w, &Reef { growth: 0.01, ..lit() }, 500);
    let grown = w.get("limestone").unwrap().get(0, 0);
    assert!(grown > 2.0 && grown < 10.0);
    // Something else takes a metre, everything and more, nothing; and puts a metre of sand on the last.
    let floor = w.get("reef_floor").unwrap().get(0, 0);
    assert!((floor + 10.0).abs() < 1e-4);
    for (x, change) in [-1.0, -(grown + 2.0), 0.0, 1.0].into_iter().enumerate() {
        let h = &mut w.layer_mut("height").unwrap().field;
        h.set(x, 0, h.get(x, 0) + change);
    }
    let dead = Reef { growth: 0.0, ..lit() };
    run(&mut w, &dead, 1);
    let stone = w.get("limestone").unwrap().to_vec();
    for (got, want) in stone.iter().zip([grown - 1.0, 0.0, grown, grown]) {
        assert!((got - want).abs() < 1e-4, "{stone:?}, grown {grown}");
    }
    let worn = w.ledger.amount("limestone.worn") / 100.0;
    assert!((worn - f64::from(1.0 + grown)).abs() < 1e-3, "{worn}");
    // Sand goes first.
    let h = &mut w.layer_mut("height").unwrap().field;
    h.set(3, 0, h.get(3, 0) - 0.5);
    run(&mut w, &dead, 1);
    assert!((w.get("limestone").unwrap().get(3, 0) - grown).abs() < 1e-4);
}

#[test]
fn limestone_from_elsewhere_is_kept() {
    let mut w = world(2, 1, 10.0, Boundary::CLOSED, |x, _| [-10.0, 8.0][x]);
    w.ensure(&LIMESTONE, 5.0);
    run(&mut w, &Reef { growth: 0.0, ..lit() }, 3);
    assert_eq!(w.get("limestone").unwrap().to_vec(), [5.0, 5.0]);
    assert_eq!(w.get("reef_floor").unwrap().to_vec(), [-15.0, 3.0]);
    assert_eq!(w.ledger.amount("limestone.worn"), 0.0);
}

#[test]
fn rivers_wear_limestone_that_fell_dry() {
    let mut w = island(30, 10.0, Boundary::OPEN, 20.0, 0.2);
    run(&mut w, &Reef { limit: Limit::Light, ..Default::default() }, 300);
    let grown = w.ledger.amount("limestone.grown");
    w.sea_level_m -= 30.0;
    let both = [scheduled(Hydraulic { rain: 0.02, ..Default::default() }), scheduled(Reef { growth: 0.0, ..lit() })];
    go(&mut w, &both, 0, 500);
    let stone = w.get("limestone").unwrap();
    let worn = w.ledger.amount("limestone.worn");
    println!("G1 worn {:.3} of what had grown", worn / grown);
    assert!(worn > 0.01 * grown);
    assert!((w.ledger.net("limestone") / (stone.sum() * 100.0) - 1.0).abs() < 1e-6);
    assert!(stone.min_max().0 >= 0.0);
    let (h, floor) = (w.get("height").unwrap(), w.get("reef_floor").unwrap());
    let above = h.iter().zip(floor.iter()).zip(stone.iter());
    above.for_each(|((h, f), s)| assert!(s == 0.0 || s <= h - f + 1e-4, "{s} m of limestone between {f} and {h} m"));
}

// ------------------------------------------------------------------------------------------------------------- Seabed

#[test]
fn the_seabed_levels_conserves_and_leaves_limestone_alone() {
    for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
        let mut w = world(25, 21, 10.0, rim, |x, y| 20.0 * noise(x, y) - 14.0);
        w.ensure(&LIMESTONE, 0.0);
        for x in 0..25 {
            w.layer_mut("limestone").unwrap().field.set(x, 9, 1.0);
        }
        let before = w.clone();
        let p = || vec![scheduled(Seabed::default())];
        let mut r = Reference::<f64>::new(&w);
        let sum = r.sum("height");
        r.simulate(&p(), 300);
        let exact = r.sum("height") / sum - 1.0;
        go(&mut w, &p(), 0, 1000);
        let (a, b) = (before.get("height").unwrap(), w.get("height").unwrap());
        println!("seabed {rim:?}: f64 {exact:e}, f32 {:e}", b.sum() / a.sum() - 1.0);
        // Criteria 1e-12 and 1e-6. Measured 1e-15 and 2e-7.
        assert!(exact.abs() <= 1e-12 && (b.sum() / a.sum() - 1.0).abs() <= 1e-6);
        let (mut rough, mut smooth) = (0.0, 0.0);
        for y in 0..21 {
            for x in 0..25 {
                let rim = rim != Boundary::WRAP && (x == 0 || y == 0 || x == 24 || y == 20);
                if a.get(x, y) >= 0.0 || y == 9 || rim {
                    assert_eq!(a.get(x, y), b.get(x, y), "land, limestone and rim at ({x}, {y})");
                } else if x > 1 && y != 9 && a.get(x - 1, y) < 0.0 {
                    rough += (a.get(x, y) - a.get(x - 1, y)).powi(2);
                    smooth += (b.get(x, y) - b.get(x - 1, y)).powi(2);
                }
            }
        }
        assert!(smooth < 1e-3 * rough, "{smooth} of {rough}");
        assert_eq!(before.get("limestone").unwrap(), w.get("limestone").unwrap());
        // What rounding changed is in the ledger.
        let change = (b.sum() - a.sum()) * w.grid.cell_area_m2();
        let unaccounted = (change - w.ledger.net("ground")) / (a.sum() * w.grid.cell_area_m2());
        println!("seabed not in the ledger: {unaccounted:e}");
        assert!(unaccounted.abs() <= 1e-8);
    }
}

/// Lakes that a rising sea or a sinking land brings under the sea join it; those above it stay.
#[test]
fn what_the_sea_drowns_joins_it() {
    let moves = [
        Reef { sea_level_rise: 0.01, years_per_step: 10.0, ..lit() },
        Reef { sea_level_curve: vec![[0.0, 0.0], [200.0, 2.0]], years_per_step: 10.0, ..lit() },
        Reef { subsidence: 0.01, years_per_step: 10.0, ..lit() },
    ];
    for p in moves {
        // Ground from -3.5 to 5.5 m with half a metre of fresh water everywhere.
        let mut w = world(10, 4, 10.0, Boundary::CLOSED, |x, _| x as f32 - 3.5);
        w.ensure(&WATER, 0.5);
        w.ensure(&WETNESS, 1.0);
        run(&mut w, &p, 20);
        let (height, water, wetness) = (w.get("height").unwrap(), w.get("water").unwrap(), w.get("wetness").unwrap());
        let mut drowned = 0;
        for ((h, d), wet) in height.iter().zip(water.iter()).zip(wetness.iter()) {
            let under = f64::from(h) < w.sea_level_m - 1e-5;
            drowned += usize::from(under);
            assert_eq!(
                (d, wet),
                if under { (0.0, 0.0) } else { (0.5, 1.0) },
                "at {h} m, the sea at {} m",
                w.sea_level_m
            );
        }
        assert_eq!(drowned, 24, "16 at the start, and two metres more");
        let joined = w.ledger.amount("water.drained");
        assert!((joined - 0.5 * 100.0 * drowned as f64).abs() < 1e-3, "{joined} m3 of {drowned} cells");
    }
    // A reef in a sea that stays asks for no water.
    let mut w = world(4, 4, 10.0, Boundary::CLOSED, |_, _| -5.0);
    run(&mut w, &lit(), 1);
    assert!(w.get("water").is_none());
}

// -------------------------------------------------------------------------------------------------------------- Atoll

/// Darwin 1842: a sinking island with a fringing reef becomes an atoll, because the reef's crest keeps up where the open
/// sea feeds it while the middle sinks.
#[test]
fn a_sinking_island_becomes_an_atoll() {
    let n = 61;
    let p = Reef { subsidence: 0.001, years_per_step: 20.0, ..Default::default() };
    let mut w = island(n, 30.0, Boundary::OPEN, 60.0, 0.15);
    let ray = |w: &World, turn: usize| -> Vec<f32> {
        let angle = turn as f64 * std::f64::consts::TAU / 24.0;
        let at = |r: usize| {
            let (x, y) = (30.0 + r as f64 * angle.cos(), 30.0 + r as f64 * angle.sin());
            -w.get("height").unwrap().get(x.round() as usize, y.round() as usize)
        };
        (0..30).map(at).collect()
    };

    // After 20 000 years: land in the middle, and a reef at the shallow limit all around it.
    go(&mut w, &[scheduled(p.clone())], 0, 1000);
    for turn in 0..24 {
        let depth = ray(&w, turn);
        assert!(depth[0] < -30.0, "land: {depth:?}");
        assert!(depth.iter().any(|d| (d - p.shallow).abs() < 0.02), "a fringing reef or barrier: {depth:?}");
    }
    // After 80 000 years and 80 m of sinking: no land, a lagoon of 50 m, and the same crest around it.
    go(&mut w, &[scheduled(p.clone())], 1000, 3000);
    let mut deepest = 0.0f32;
    for turn in 0..24 {
        let depth = ray(&w, turn);
        let crest = depth.iter().position(|d| (d - p.shallow).abs() < 0.02).unwrap_or_else(|| panic!("{depth:?}"));
        assert!((14..=22).contains(&crest), "crest at cell {crest}: {depth:?}");
        assert!(depth[..crest].iter().all(|d| *d > p.shallow), "the lagoon is deeper than its rim: {depth:?}");
        assert!(depth.iter().all(|d| *d > p.shallow - 0.02), "no land: {depth:?}");
        assert!(depth[29] > 100.0, "outside is the open sea");
        deepest = depth[..crest].iter().fold(deepest, |a, b| a.max(*b));
    }
    let centre = ray(&w, 0)[0];
    println!("G1 atoll: centre at {centre:.1} m, lagoon down to {deepest:.1} m, crest at {} m", p.shallow);
    assert!(centre > 4.0 * p.shallow && deepest > 40.0);
}

// ---------------------------------------------------------------------------------------------------------- Diffusion

/// A cosine of carbon in deep still water decays as e^(-D k^2 t), in plain steps and in stages, and stays smooth and within
/// its bounds however long the step.
#[test]
fn carbon_diffuses_at_the_stated_rate() {
    let (n, cell) = (64, 10.0);
    let k = 2.0 * std::f64::consts::PI / (n as f64 * cell);
    // Diffusion numbers per step of 0.2, 4 and 266 (1, 5 and 33 stages). The scheme is of first order in time: in the last
    // case the cosine decays by a factor 3.6 in a single step.
    for (years, steps, tolerance) in [(1.0f32, 200, 0.002), (20.0, 10, 0.005), (1331.0, 1, 0.1)] {
        let p = Reef { growth: 0.0, diffusivity: 10.0, years_per_step: years, open_sea: 1000.0, ..Default::default() };
        let mut w = world(n, n, cell, Boundary::WRAP, |_, _| -30.0);
        go(&mut w, &[scheduled(p.clone())], 0, 0);
        let wave = |x: usize| (k * (x as f64 + 0.5) * cell).cos();
        w.put(&CARBON, Field::from_fn(n, n, |x, _| (0.5 + 0.4 * wave(x)) as f32)).unwrap();
        run(&mut w, &p, steps);
        let decay = (-10.0 * k * k * f64::from(years) * steps as f64).exp();
        let carbon = w.get("carbon").unwrap();
        for x in 0..n {
            let (got, want) = (f64::from(carbon.get(x, 7)), 0.5 + 0.4 * decay * wave(x));
            assert!((got - want).abs() < tolerance, "{years} yr: {got}, exactly {want}");
        }
        // White noise never leaves its bounds nor gets rougher.
        w.put(&CARBON, Field::from_fn(n, n, noise)).unwrap();
        let rough = |f: &Field| (0..n - 1).map(|x| (f.get(x + 1, 9) - f.get(x, 9)).abs()).fold(0.0, f32::max);
        let before = rough(w.get("carbon").unwrap());
        run(&mut w, &p, 1);
        let after = w.get("carbon").unwrap();
        assert!(rough(after) <= before && after.iter().all(|v| (0.0..=1.0).contains(&v)));
    }
}

#[test]
fn carbon_that_was_not_there_is_in_the_ledger() {
    // Diffusion and growth over a level bed, first with what the water holds, then with more than that.
    for (uptake, years, short) in [(0.1, 20.0f32, false), (400.0, 400.0, true)] {
        let (n, depth) = (32, 8.0);
        let p = Reef { uptake, years_per_step: years, open_sea: 1000.0, ..Default::default() };
        let mut w = world(n, n, 10.0, Boundary::WRAP, |_, _| -depth);
        go(&mut w, &[scheduled(p.clone())], 0, 0);
        w.put(&CARBON, Field::from_fn(n, n, noise)).unwrap();
        let before = w.get("carbon").unwrap().sum() * f64::from(depth);
        run(&mut w, &p, 1);
        let after = w.get("carbon").unwrap().sum() * f64::from(depth);
        let grown = w.ledger.amount("limestone.grown") / w.grid.cell_area_m2();
        let made = w.ledger.amount("carbon.clamped") / w.grid.cell_area_m2();
        let error = (after - before - made + f64::from(uptake) * grown) / before;
        println!("carbon, uptake {uptake}: grown {grown:.3}, made {made:e}, error {error:e}");
        assert!(error.abs() < 1e-6 && grown > 0.0);
        assert!(if short { made > 0.01 * before } else { made.abs() < 1e-6 * before }, "{made}");
    }
}
