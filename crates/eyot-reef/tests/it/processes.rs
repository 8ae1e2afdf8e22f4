//! Each process on its own, against what can be worked out by hand.

#![allow(missing_docs)]

use crate::common;

use common::{bare, cool, quiet};
use eyot_core::Control;
use eyot_reef::community::{Community, Forcing, Heat, Plot, Temperatures, grazing_probability};

const LOBATA: usize = 0;
const LUTEA: usize = 1;
const MURICATA: usize = 2;
const DAMICORNIS: usize = 3;

/// Heat that lasts for the first month and never comes back.
fn hot_january(community: &Community) -> Forcing {
    let text: String = (0..12).map(|m| format!("2001-{:02},{}\n", m + 1, if m == 0 { 31.0 } else { 26.0 })).collect();
    Forcing::series(&Temperatures::parse(&text, false).unwrap(), community).unwrap()
}

/// A community in which heat bleaches everybody and kills nobody.
fn harmless_heat(compat: bool) -> Community {
    let mut c = Community { compat, ..quiet() };
    for s in &mut c.species {
        (s.bleaching_min, s.bleaching_max, s.death_min, s.death_max) = (29.5, 30.0, 40.0, 50.0);
    }
    c
}

/// Colonies of one species, far from each other.
fn rows(plot: &mut Plot, species: usize, radius: f32, age: u32, apart: f32) -> u64 {
    let side = plot.site().width_m as f32;
    let n = (side / apart) as usize;
    for i in 0..n * n {
        let at = |k: usize| (k as f32 + 0.5) * apart;
        plot.add_colony(species, at(i % n), at(i / n), radius, age).unwrap();
    }
    (n * n) as u64
}

/// Within four standard deviations of a binomial number.
fn is_binomial(hits: u64, n: u64, p: f64) -> bool {
    let (n, hits) = (n as f64, hits as f64);
    (hits - n * p).abs() <= 4.0 * (n * p * (1.0 - p)).sqrt() + 1e-9
}

#[test]
fn in_isolation_colonies_grow_at_their_species_rate_up_to_their_size() {
    for compat in [false, true] {
        let mut plot = bare(Community { compat, ..quiet() }, cool(), 40.0, 1);
        for (n, x) in [(LOBATA, 5.0), (LUTEA, 15.0), (MURICATA, 25.0), (DAMICORNIS, 35.0)] {
            plot.add_colony(n, x, 20.0, 0.05, 5).unwrap();
        }
        (0..24).for_each(|_| drop(plot.month().unwrap()));
        for c in plot.colonies() {
            let want = 0.05 + 2.0 * plot.community().species[usize::from(c.species)].growth;
            assert!((c.radius - want).abs() < 1e-5, "{c:?}: {want}");
            assert_eq!(c.age, 29);
        }
        (0..200).for_each(|_| drop(plot.month().unwrap()));
        assert_eq!(plot.colonies()[MURICATA].radius, 0.5);
        assert_eq!(plot.colonies()[DAMICORNIS].radius, 0.3);
    }
}

#[test]
fn neighbours_slow_the_rays_whose_tips_they_cover() {
    // Rays of the first colony that point at the other one are covered by it, those that point away are not.
    let growth_of_rays = |species: [usize; 2], radii: [f32; 2], d: f32, compat: bool| {
        let mut plot = bare(Community { compat, ..quiet() }, cool(), 10.0, 1);
        plot.add_colony(species[0], 4.0, 5.0, radii[0], 5).unwrap();
        plot.add_colony(species[1], 4.0 + d, 5.0, radii[1], 5).unwrap();
        plot.month().unwrap();
        let own = plot.community().species[species[0]].growth / 12.0;
        let share = |k: usize| ((plot.rays()[0][k] - radii[0]) / own * 100.0).round() / 100.0;
        [share(0), share(12)]
    };
    // A smaller and a larger neighbour.
    assert_eq!(growth_of_rays([LOBATA, LOBATA], [0.5, 0.3], 0.6, false), [0.7, 1.0]);
    assert_eq!(growth_of_rays([LOBATA, LOBATA], [0.3, 0.5], 0.6, false), [0.21, 1.0]);
    // Branches stop at a massive body, however small.
    assert_eq!(growth_of_rays([MURICATA, LOBATA], [0.4, 0.2], 0.5, false), [0.0, 1.0]);
    assert_eq!(growth_of_rays([LOBATA, MURICATA], [0.5, 0.3], 0.6, false), [0.7, 1.0]);
    // Among branching corals the original slows the larger one instead of the smaller one.
    assert_eq!(growth_of_rays([MURICATA, MURICATA], [0.2, 0.4], 0.5, false), [0.21, 1.0]);
    assert_eq!(growth_of_rays([MURICATA, MURICATA], [0.2, 0.4], 0.5, true), [0.7, 1.0]);
    assert_eq!(growth_of_rays([MURICATA, MURICATA], [0.4, 0.2], 0.5, true), [0.21, 1.0]);
    // Strength beats size, but not in the original.
    assert_eq!(growth_of_rays([LUTEA, LOBATA], [0.31, 0.3], 0.5, false), [0.21, 1.0]);
    assert_eq!(growth_of_rays([LUTEA, LOBATA], [0.31, 0.3], 0.5, true), [0.7, 1.0]);
}

#[test]
fn the_engulfed_die_at_once_unless_the_larger_one_is_bleached() {
    let c = harmless_heat(false);
    let survivors = |community: Community, forcing: Forcing, at: f32| {
        let mut plot = bare(community, forcing, 10.0, 1);
        plot.add_colony(LOBATA, 5.0, 5.0, 1.0, 5).unwrap();
        plot.add_colony(DAMICORNIS, at, 5.0, 0.1, 5).unwrap();
        let census = plot.month().unwrap();
        (plot.colonies().len(), census.species[DAMICORNIS].deaths.overgrowth)
    };
    assert_eq!(survivors(quiet(), cool(), 5.89), (1, 1));
    // 9 cm further out two thirds are covered.
    assert_eq!(survivors(quiet(), cool(), 5.98), (2, 0));
    assert_eq!(survivors(c.clone(), hot_january(&c), 5.89), (2, 0));
}

/// Distance of two discs of radius 1 that share this part of one.
fn distance_for(share: f64) -> f32 {
    let overlap = |d: f64| (2.0 * (d / 2.0).acos() - d / 2.0 * (4.0 - d * d).sqrt()) / std::f64::consts::PI;
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if overlap(middle) > share { low = middle } else { high = middle }
    }
    low as f32
}

#[test]
fn overgrowth_kills_from_three_quarters_on_and_leaves_one_of_two() {
    for (share, alive) in [(0.74, 2), (0.76, 1)] {
        for seed in 0..8 {
            let mut plot = bare(quiet(), cool(), 10.0, seed);
            plot.add_colony(LOBATA, 4.0, 5.0, 1.0, 5).unwrap();
            plot.add_colony(LUTEA, 4.0 + distance_for(share), 5.0, 1.0, 5).unwrap();
            let census = plot.month().unwrap();
            assert_eq!(census.colonies(), alive, "{share}");
            assert_eq!(census.species.iter().map(|s| s.deaths.overgrowth).sum::<u64>(), 2 - alive);
        }
    }
    // Which one, chance decides.
    let lobata = |seed: u64| {
        let mut plot = bare(quiet(), cool(), 10.0, seed);
        plot.add_colony(LOBATA, 4.0, 5.0, 1.0, 5).unwrap();
        plot.add_colony(LUTEA, 4.0 + distance_for(0.8), 5.0, 1.0, 5).unwrap();
        plot.month().unwrap().species[LOBATA].colonies
    };
    assert!(is_binomial((0..400).map(lobata).sum(), 400, 0.5));
    // Two neighbours that cover 40 % each; among branching corals smaller massive ones do not count.
    for (species, neighbour, radius, alive) in
        [(LOBATA, LOBATA, 0.4, 2), (MURICATA, LOBATA, 0.399, 3), (MURICATA, LOBATA, 0.401, 2)]
    {
        let mut plot = bare(quiet(), cool(), 10.0, 1);
        plot.add_colony(species, 5.0, 5.0, 0.4, 5).unwrap();
        for side in [-1.0, 1.0] {
            plot.add_colony(neighbour, 5.0 + side * 0.4 * distance_for(0.4), 5.0, radius, 5).unwrap();
        }
        assert_eq!(plot.month().unwrap().colonies(), alive, "{species} {neighbour} {radius}");
    }
}

#[test]
fn bleaching_and_death_have_the_probabilities_of_the_worked_values() {
    let c = Community::default();
    let risks = |index: f32, n: usize| Heat { index, ..Default::default() }.risks(&c.heat, &c.species[n]);
    // Heat index of 1998, 2010 and 2009; probability of bleaching and of death if bleached.
    for (index, species, want) in [
        (30.55, LOBATA, (0.714, 0.442)),
        (30.55, LUTEA, (0.714, 0.442)),
        (30.55, MURICATA, (0.803, 0.618)),
        (30.55, DAMICORNIS, (0.685, 1.0)),
        (29.98, LOBATA, (0.351, 0.223)),
        (29.98, MURICATA, (0.554, 0.468)),
        (29.98, DAMICORNIS, (0.0, 0.0)),
        (29.70, MURICATA, (0.431, 0.395)),
        (29.70, LOBATA, (0.0, 0.0)),
    ] {
        let got = risks(index, species);
        assert!((got.0 - want.0).abs() < 6e-4 && (got.1 - want.1).abs() < 6e-4, "{index} {species}: {got:?} {want:?}");
    }
    // And colonies bleach and die as often.
    let mut plot = bare(quiet(), Forcing::constant(Heat { index: 30.55, ..Default::default() }), 300.0, 3);
    let n = rows(&mut plot, MURICATA, 0.1, 5, 3.0);
    let census = &plot.month().unwrap().species[MURICATA];
    assert!(is_binomial(census.deaths.heat, n, 0.803 * 0.618), "{census:?}");
    assert!(is_binomial(census.bleached, n, 0.803 * (1.0 - 0.618)), "{census:?}");
}

#[test]
fn recovery_takes_six_months_and_slows_growth() {
    for (compat, species, want) in [
        // Growth in the months after bleaching, as a share of that of a healthy colony.
        (false, LOBATA, [0.0, 0.17, 0.34, 0.51, 0.68, 0.85, 1.0, 1.0]),
        (false, MURICATA, [0.0, 0.17, 0.34, 0.51, 0.68, 0.85, 1.0, 1.0]),
        // The original forgets it for massive corals and is a month late for branching ones.
        (true, LOBATA, [1.0; 8]),
        (true, MURICATA, [1.0, 0.0, 0.17, 0.34, 0.51, 0.68, 0.85, 1.0]),
    ] {
        let c = harmless_heat(compat);
        let mut plot = bare(c.clone(), hot_january(&c), 10.0, 1);
        plot.add_colony(species, 5.0, 5.0, 0.1, 5).unwrap();
        let full = plot.community().species[species].growth / 12.0;
        let mut radius = 0.1;
        for (month, want) in want.into_iter().enumerate() {
            let census = plot.month().unwrap();
            let colony = plot.colonies()[0];
            assert_eq!(census.species[species].bleached, u64::from(month < 6), "month {month}");
            assert!(
                (colony.radius - radius - want * full).abs() < 1e-6,
                "{compat} {species} month {month}: {colony:?}"
            );
            radius = colony.radius;
        }
    }
}

#[test]
fn turf_smothers_settlers_for_two_months() {
    let mut plot = bare(quiet(), cool(), 200.0, 2);
    plot.set_turf(0.6).unwrap();
    let n = rows(&mut plot, LOBATA, 0.001, 0, 2.0);
    let first = plot.month().unwrap().species[LOBATA].deaths.turf;
    let second = plot.month().unwrap().species[LOBATA].deaths.turf;
    let third = plot.month().unwrap().species[LOBATA].deaths.turf;
    assert!(is_binomial(first, n, 0.3), "{first} of {n}");
    assert!(is_binomial(second, n - first, 0.3), "{second}");
    assert_eq!(third, 0);
}

#[test]
fn turf_grows_where_no_coral_covers_it() {
    let mut c = quiet();
    c.turf.growth = 0.05;
    let mut plot = bare(c, cool(), 10.0, 2);
    plot.add_colony(LOBATA, 5.0, 5.0, 2.5, 5).unwrap();
    (0..3).for_each(|_| drop(plot.month().unwrap()));
    // Far away, overlapped, covered.
    assert!((plot.turf_at(0.5, 0.5) - 0.15).abs() < 1e-6);
    assert!((plot.turf_at(7.2, 5.5) - 0.135).abs() < 1e-6, "{}", plot.turf_at(7.2, 5.5));
    assert_eq!(plot.turf_at(5.5, 5.5), 0.0);
    (0..30).for_each(|_| drop(plot.month().unwrap()));
    assert_eq!(plot.turf_at(0.5, 0.5), 1.0);
}

#[test]
fn disturbances_come_at_their_intervals_and_clear_discs() {
    let mut c = quiet();
    (c.small_disturbances.events, c.large_disturbances.events) = (1.0, 1.0);
    let mut plot = bare(c.clone(), cool(), 40.0, 5);
    let mut dates = [Vec::new(), Vec::new()];
    for month in 0..7200 {
        let counts = plot.month().unwrap().disturbances;
        (0..2).filter(|&k| counts[k] > 0).for_each(|k| dates[k].push(month));
    }
    for (dates, mean, spread) in [(&dates[0], 12.0, 1.2), (&dates[1], 36.0, 3.6)] {
        let gaps: Vec<f64> = dates.windows(2).map(|w| f64::from(w[1] - w[0])).collect();
        let n = gaps.len() as f64;
        let got = gaps.iter().sum::<f64>() / n;
        let sd = (gaps.iter().map(|g| (g - got).powi(2)).sum::<f64>() / n).sqrt();
        assert!((got - mean).abs() < 4.0 * spread / n.sqrt() + 0.05, "{got} {mean}");
        // Whole months spread dates by another 0.41.
        assert!((sd - spread.hypot(0.41)).abs() < 0.15 * spread, "{sd} {spread}");
    }
    // What dies lies in a disc of the right size, everything else lives.
    c.large_disturbances.events = 0.0;
    let mut widest = 0.0f32;
    for seed in 0..30 {
        let mut plot = bare(c.clone(), cool(), 40.0, seed);
        let n = rows(&mut plot, DAMICORNIS, 0.01, 5, 0.5);
        let before: Vec<_> = plot.colonies().to_vec();
        let census = (0..24).map(|_| plot.month().unwrap()).find(|c| c.disturbances[0] > 0).unwrap();
        let dead = census.species[DAMICORNIS].deaths.disturbance;
        assert_eq!(dead + census.species[DAMICORNIS].colonies, n);
        let living: std::collections::BTreeSet<u64> = plot.colonies().iter().map(|c| c.id).collect();
        let gone: Vec<_> = before.iter().filter(|c| !living.contains(&c.id)).collect();
        assert_eq!(gone.len() as u64, dead);
        for a in &gone {
            for b in &gone {
                widest = widest.max((a.x - b.x).hypot(a.y - b.y));
            }
        }
    }
    assert!((3.0..=4.0).contains(&widest), "{widest} m");
}

#[test]
fn disturbances_fit_the_area_and_in_the_original_the_plot() {
    let events = |compat: bool, side: f64| {
        let mut c = Community { compat, ..quiet() };
        c.small_disturbances.events = 1.0;
        let mut plot = bare(c, cool(), side, 5);
        (0..1200).map(|_| u64::from(plot.month().unwrap().disturbances[0])).sum::<u64>()
    };
    assert!((98..=102).contains(&events(true, 10.0)) && (98..=102).contains(&events(true, 80.0)));
    // (10 + 3)^2 / (40 + 3)^2 and (80 + 3)^2 / 43^2 of them.
    assert!((3..=18).contains(&events(false, 10.0)), "{}", events(false, 10.0));
    assert!((340..=410).contains(&events(false, 80.0)), "{}", events(false, 80.0));
}

#[test]
fn larvae_follow_the_mature_surface_and_settle_in_their_season() {
    let mut c = quiet();
    c.species = Community::default().species;
    let mut plot = bare(c, cool(), 40.0, 1);
    // 8.1 % of Porites lobata, in equal colonies.
    let n = rows(&mut plot, LOBATA, 1.0, 50, 6.0);
    let surface_cm2 = n as f64 * 2.0 * std::f64::consts::PI * 1e4 * 1.5;
    let own = (surface_cm2 * 1210.0 * 4.5e-9).floor();
    let from_elsewhere = (own + 0.006 * 1600.0).floor();
    assert_eq!(plot.larvae(LOBATA), own + from_elsewhere);
    rows(&mut plot, DAMICORNIS, 0.25, 50, 1.9);
    let recruits: Vec<[u64; 2]> = (0..28)
        .map(|_| {
            let census = plot.month().unwrap();
            [census.species[LOBATA].recruits, census.species[DAMICORNIS].recruits]
        })
        .collect();
    for (month, [yearly, monthly]) in recruits.iter().enumerate() {
        assert_eq!(*yearly > 0, month % 12 == 3, "month {month}");
        assert_eq!(*monthly > 0, month >= 1, "month {month}");
    }
    // A hump: more cover has more larvae, immature cover none.
    let mut closed = Community::default();
    closed.species.iter_mut().for_each(|s| s.imported_recruits = 0.0);
    let larvae = |radius: f32| {
        let mut plot = bare(closed.clone(), cool(), 40.0, 1);
        rows(&mut plot, MURICATA, radius, 50, 1.0);
        plot.larvae(MURICATA)
    };
    assert_eq!(larvae(0.034), 0.0);
    assert!(larvae(0.2) > 3.9 * larvae(0.1) && larvae(0.1) > 0.0);
}

#[test]
fn branching_corals_fragment_when_full_grown_and_break_without_support() {
    let mut c = Community { fragmentation: 0.002, ..quiet() };
    c.overgrowth = 100.0;
    let mut plot = bare(c, cool(), 300.0, 4);
    let n = rows(&mut plot, MURICATA, 0.5, 50, 3.0);
    let fragments = plot.month().unwrap().species[MURICATA].fragments;
    // 1 % of them, two each; a few land outside.
    assert!((0.6..=1.4).contains(&(fragments as f64 / (0.02 * n as f64))), "{fragments} of {n}");
    let small = plot.colonies().iter().filter(|c| c.radius < 0.06).count() as u64;
    assert_eq!(small, fragments);
    // Breakage: 0.5 % a month, none with a neighbour of half the size.
    for (support, expected) in [(0.04, 0.005), (0.06, 0.0)] {
        let mut plot = bare(Community { breakage: 0.001, overgrowth: 100.0, ..quiet() }, cool(), 300.0, 4);
        let n = rows(&mut plot, MURICATA, 0.1, 50, 3.0);
        for i in 0..n as usize {
            let c = plot.colonies()[i];
            plot.add_colony(LOBATA, c.x + 0.12, c.y, support, 50).unwrap();
        }
        let broken = plot.month().unwrap().species[MURICATA].deaths.breakage;
        assert!(is_binomial(broken, n, expected), "{support}: {broken} of {n}");
    }
}

#[test]
fn algae_grow_in_width_then_in_height_fragment_and_die_of_age() {
    for (compat, allowed) in [(false, [0, 1, 2]), (true, [0, 2, 2])] {
        let mut c = Community { compat, ..quiet() };
        c.algae.fragment_range = 0.0;
        let mut plot = bare(c, cool(), 10.0, 1);
        plot.add_alga(5.0, 5.0, 0.005).unwrap();
        let mut sizes = Vec::new();
        for month in 0..14 {
            let before = plot.algae().len();
            plot.month().unwrap();
            let Some(a) = plot.algae().first().filter(|a| a.id == 0) else {
                assert_eq!(month, 13, "it dies beyond the age of 12 months");
                break;
            };
            sizes.push((a.radius, a.height));
            // Fragments land on their parent, which shades them to death.
            let more = plot.algae().len() as i64 - 1;
            assert!(before <= 3 && allowed.contains(&more), "month {month}: {more}");
        }
        assert_eq!(sizes[5], (0.175, 0.175));
        assert!((sizes[2].0 - 0.095).abs() < 1e-6 && (sizes[2].1 - 0.095).abs() < 1e-6);
        assert!((sizes[9].1 - 0.295).abs() < 1e-6, "{sizes:?}");
    }
}

#[test]
fn algae_give_way_to_corals_and_to_taller_algae() {
    let lives = |setting: &dyn Fn(&mut Plot)| {
        let mut plot = bare(quiet(), cool(), 10.0, 1);
        plot.add_alga(5.0, 5.0, 0.1).unwrap();
        setting(&mut plot);
        plot.month().unwrap();
        plot.algae().iter().any(|a| a.id == 0)
    };
    assert!(lives(&|_| ()));
    // Its centre on a larger massive coral, or its whole disc among branches.
    assert!(!lives(&|p| _ = p.add_colony(LOBATA, 5.45, 5.0, 0.5, 5).unwrap()));
    assert!(lives(&|p| _ = p.add_colony(LOBATA, 5.55, 5.0, 0.5, 5).unwrap()));
    assert!(!lives(&|p| _ = p.add_colony(MURICATA, 5.25, 5.0, 0.4, 5).unwrap()));
    assert!(lives(&|p| _ = p.add_colony(MURICATA, 5.35, 5.0, 0.4, 5).unwrap()));
    assert!(!lives(&|p| _ = p.add_alga(5.2, 5.0, 0.15).unwrap()));
    assert!(lives(&|p| _ = p.add_alga(5.15, 5.0, 0.09).unwrap()));
    // In the original height has no end.
    for compat in [false, true] {
        let mut c = Community { compat, ..quiet() };
        (c.algae.max_age, c.algae.max_fragments, c.algae.fragmentation_height) = (1000, 0, 20.0);
        let mut plot = bare(c, cool(), 10.0, 1);
        plot.add_alga(5.0, 5.0, 0.1).unwrap();
        (0..40).for_each(|_| drop(plot.month().unwrap()));
        assert_eq!(plot.algae()[0].height > 0.6, compat, "{:?}", plot.algae()[0]);
    }
}

#[test]
fn grazing_follows_the_cover_of_algae() {
    let rules = Community::default().grazing;
    let p = |cover: f64| f64::from(grazing_probability(&rules, 0.18, cover));
    assert!((p(0.0617) - 0.1018).abs() < 1e-4 && (p(0.075) - 0.14).abs() < 1e-6);
    assert!((p(0.18) - 0.2061).abs() < 1e-4 && p(10.0) <= 0.22);
    assert_eq!((p(0.02), p(0.0)), (0.0, 0.0));
    // Algae are grazed as often.
    let mut c = quiet();
    c.grazing = rules;
    let mut plot = bare(c, cool(), 100.0, 6);
    for i in 0..10_000 {
        plot.add_alga((i % 100) as f32 + 0.5, (i / 100) as f32 + 0.5, 0.1).unwrap();
    }
    let census = plot.month().unwrap();
    assert_eq!(census.algae, 10_000);
    let eaten = 10_000 - plot.algae().len() as u64;
    assert!(is_binomial(eaten, 10_000, f64::from(census.grazing)), "{eaten}, {}", census.grazing);
}

#[test]
fn rugosity_feeds_back_on_grazing_and_disturbances_in_its_time() {
    let mut c = quiet();
    c.grazing = Community::default().grazing;
    (c.feedback_from, c.feedback_until) = (24, 600);
    c.small_disturbances.events = 1.0;
    c.algae.max_age = 1200;
    let mut plot = bare(c, cool(), 10.0, 6);
    for i in 0..900 {
        plot.add_alga((i % 30) as f32 / 3.0 + 0.1, (i / 30) as f32 / 3.0 + 0.1, 0.17).unwrap();
    }
    plot.add_colony(LOBATA, 5.0, 5.0, 1.0, 5).unwrap();
    let rows: Vec<_> = (0..600).map(|_| plot.month().unwrap()).collect();
    // Rugosity of one colony: its hemisphere is 1.5 times as large, the rest is bare.
    let r2 = f64::from(plot.community().species[LOBATA].growth / 12.0) + 1.0;
    let disc = std::f64::consts::PI * r2 * r2;
    let flat = ((2.0 * disc * 1.5 + 100.0 - disc) / 100.0).sqrt();
    assert!((rows[0].rugosity - flat).abs() < 1e-4, "{} {flat}", rows[0].rugosity);
    // Before: around 0.18; later around 0.18 (rugosity - 1) / 2.5, which is little.
    assert!(rows[0].grazing > 0.2 && rows[24].grazing < 0.08, "{} {}", rows[0].grazing, rows[24].grazing);
}

#[test]
fn a_flat_reef_is_disturbed_ever_more_often() {
    let dates = |from: u32| {
        let mut c = Community { compat: true, ..quiet() };
        c.small_disturbances.events = 1.0;
        (c.feedback_from, c.feedback_until) = (from, 100_000);
        let mut plot = bare(c, cool(), 10.0, 6);
        (0..240).map(|_| plot.month().unwrap().disturbances[0]).sum::<u32>()
    };
    // Without feedback 20 in 20 years; with it the interval shrinks by a tenth a year.
    assert!((18..=21).contains(&dates(50_000)), "{}", dates(50_000));
    assert!(dates(0) > 40, "{}", dates(0));
}

#[test]
fn skeletons_weigh_what_they_grow() {
    let mut plot = bare(quiet(), cool(), 10.0, 1);
    plot.add_colony(LOBATA, 5.0, 5.0, 0.5, 5).unwrap();
    plot.month().unwrap();
    // A hemisphere of 0.5 m grows by 0.0116 / 12 m.
    let volume = |r: f64| 2.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let gained = 1280.0 * (volume(0.5 + 0.0116 / 12.0) - volume(0.5));
    let got = f64::from(plot.colonies()[0].calcified_kg);
    assert!((got / gained - 1.0).abs() < 0.003, "{got} {gained}");
    // The terrain gets what the census says.
    let census = plot.month().unwrap();
    let mut limestone = eyot_core::Field::new(5, 5, 0.0);
    plot.deposit(2.0, 0.0, &mut limestone, &Control::none()).unwrap();
    let mass = census.species[LOBATA].calcified_kg;
    assert!((limestone.sum() * 4.0 - mass / (2930.0 * 0.5)).abs() < 1e-9 && limestone.get(2, 2) > 0.0);
    // Waves spread it, and nothing leaves the plot.
    let mut spread = eyot_core::Field::new(40, 40, 0.0);
    plot.deposit(0.25, 6.0, &mut spread, &Control::none()).unwrap();
    assert!((spread.sum() / 16.0 / (mass / (2930.0 * 0.5)) - 1.0).abs() < 1e-5);
    assert!(spread.get(20, 20) > spread.get(20, 0) && spread.get(20, 0) > 0.0 && spread.get(0, 0) == 0.0);
    assert!((census.limestone_m * 100.0 - mass / (2930.0 * 0.5)).abs() < 1e-12);
}

/// Few adults have few larvae, many leave no room for them: those who live are most in between.
#[test]
fn recruitment_has_a_hump_over_cover() {
    let recruits = |apart: f32| {
        let mut c = quiet();
        let species = &mut c.species[LOBATA];
        (species.propagules, species.max_radius, species.max_initial_radius) = (1210.0, 1.0, 1.0);
        species.retention *= 100.0;
        let mut plot = bare(c, cool(), 40.0, 9);
        let adults = rows(&mut plot, LOBATA, 1.0, 50, apart);
        (0..6).for_each(|_| drop(plot.month().unwrap()));
        let young = plot.colonies().iter().filter(|c| c.age < 12).count();
        (std::f64::consts::PI * adults as f64 / 1600.0, young)
    };
    let [(sparse, few), (half, most), (full, less)] = [10.0, 2.5, 2.0].map(recruits);
    assert!(sparse < 0.04 && (0.45..0.55).contains(&half) && full > 0.75, "{sparse} {half} {full}");
    assert!(most > 4 * few && most as f64 > 1.2 * less as f64 && less > few, "{few} {most} {less}");
    // Larvae come in proportion to adults, and those on top of one die.
    let expected = |cover: f64| cover * (1.0 - cover);
    let ratio = less as f64 / most as f64 / (expected(full) / expected(half));
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

#[test]
fn the_original_throws_fragments_too_far_to_one_side_and_counts_a_day_too_many() {
    let farthest = |compat: bool| {
        let mut c = Community { compat, fragmentation: 1.0, overgrowth: 100.0, ..quiet() };
        c.species[MURICATA].surface_factor = 1.0;
        let mut plot = bare(c, cool(), 30.0, 4);
        for i in 0..400u64 {
            plot.add_colony(MURICATA, 15.0, 15.0, 0.5, 50 + i as u32).unwrap();
        }
        // All stand in the middle, so that only fragments are away from it.
        plot.month().unwrap();
        let away = |v: fn(&eyot_reef::community::Colony) -> f32| {
            let offsets = plot.colonies().iter().map(move |c| v(c) - 15.0);
            offsets.fold([0.0f32; 2], |[low, high], o| [low.min(o), high.max(o)])
        };
        [away(|c| c.x), away(|c| c.y)]
    };
    for [low, high] in farthest(false) {
        assert!((-5.0..-4.9).contains(&low) && (4.9..=5.0).contains(&high), "{low} {high}");
    }
    for [low, high] in farthest(true) {
        assert!((-5.0..-4.9).contains(&low) && (5.02..=5.1).contains(&high), "{low} {high}");
    }
    // 25 days of 30 C in a month: 20 of them, or 21 over 20.
    let text: String = (1..=31).map(|d| format!("2001-01-{d:02},{}\n", if d <= 25 { 30.0 } else { 26.0 })).collect();
    for (compat, index) in [(false, 30.0), (true, 30.05)] {
        let c = Community { compat, ..quiet() };
        let heat = Forcing::series(&Temperatures::parse(&text, compat).unwrap(), &c).unwrap().heat(0);
        assert!((heat.index - index).abs() < 1e-4, "{compat}: {heat:?}");
    }
}
