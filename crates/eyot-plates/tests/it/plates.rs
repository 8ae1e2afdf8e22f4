//! Plates as a library: robust, exact, deterministic, and shaped as a world should be.

use eyot_core::{Boundary, BoundaryCondition, Grid, Limits};
use eyot_plates::crust::CONTINENTAL_M;
use eyot_plates::{Plates, Start, Tectonics, hypsometry};
use rayon::prelude::*;

fn grid(w: usize, h: usize, rim: Boundary) -> Grid {
    Grid::new(w, h, (4e7 / w as f64).min(1e6), rim, &Limits::default()).unwrap()
}

const CYLINDER: Boundary = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };

fn new(g: &Grid, seed: u64, p: &Tectonics) -> Plates {
    Plates::new(g, seed, p.clone(), Start::Noise).unwrap()
}

fn run(g: &Grid, seed: u64, p: &Tectonics, steps: usize) -> Plates {
    let mut plates = new(g, seed, p);
    (0..steps).for_each(|_| plates.step());
    plates
}

fn land(p: &Plates) -> f64 {
    p.height().iter().filter(|h| **h > 0.0).count() as f64 / p.height().len() as f64
}

fn continental(p: &Plates) -> f64 {
    p.crust_m().filter(|&c| c >= CONTINENTAL_M).count() as f64 / p.height().len() as f64
}

/// Level of the sea in buoyancy, m.
fn level(p: &Plates) -> f64 {
    p.state(0.0).numbers()[4]
}

/// Everything that a state is.
fn state(p: &Plates) -> (Vec<u32>, Vec<u8>, Vec<u32>, Vec<u64>) {
    let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    (
        bits(p.height()),
        p.owner().to_vec(),
        bits(p.age_myr()),
        p.state(0.0).numbers().iter().map(|n| n.to_bits()).collect(),
    )
}

/// 200 seeds, all rims, 2 to 30 plates, over more than a whole cycle: no crash, nothing lost, no world that stands still before its cycle
/// ends, land within 3 points of the asked share after every single step, and heights with two peaks.
#[test]
fn two_hundred_seeds_neither_crash_nor_stall_and_keep_their_land() {
    (0..200u64).into_par_iter().for_each(|seed| {
        let rim = [Boundary::WRAP, CYLINDER, Boundary::CLOSED, Boundary::OPEN][seed as usize % 4];
        let p =
            Tectonics { count: 2 + (seed % 29) as u32, land: 0.1 + 0.1 * (seed % 6) as f32, ..Tectonics::default() };
        let (w, h) = [(64, 32), (48, 48), (37, 53), (80, 20), (128, 64)][seed as usize / 4 % 5];
        // A quarter of the Earth's girth, so that plates cross a cell every few steps.
        let small = Grid::new(w, h, 1e7 / w as f64, rim, &Limits::default()).unwrap();
        let mut plates = new(&small, seed, &p);
        // Where plates have come to a halt, a new cycle begins: sea floor is made in each part of the time.
        for part in 0..6 {
            let before = plates.budget().ridges;
            for step in 0..52 {
                plates.step();
                assert!(plates.crust_m().all(|c| c >= 0.0), "seed {seed}");
                // Over open rims continents leave for good.
                let off = land(&plates) - f64::from(p.land);
                assert!(rim == Boundary::OPEN || off.abs() < 0.03, "seed {seed}: {off} in step {step} of part {part}");
            }
            assert!(plates.budget().ridges > before, "seed {seed} stands still in part {part}");
        }
        assert!(plates.cycle_and_steps().0 > 1, "a whole cycle");
        assert_eq!(plates.crust_units(), plates.budget().net(), "seed {seed}");
        assert!(plates.crust_m().all(|c| (0.0..=100_000.0).contains(&c)), "seed {seed}");
        assert!(plates.height().iter().all(|h| h.is_finite()), "seed {seed}");
        if rim != Boundary::OPEN {
            // The level does not hide that the continents are gone.
            let kept = continental(&plates) / f64::from(p.land);
            assert!(kept > 0.85, "seed {seed}: {kept}");
            if w * h > 4000 {
                let h = hypsometry(plates.height().iter().copied());
                let (sea, ground) = h.peaks_m.unwrap_or_else(|| panic!("seed {seed}: {:?}", h.shares));
                assert!(sea < -2000.0 && (-500.0..1500.0).contains(&ground), "seed {seed}: {sea} {ground}");
            }
        }
    });
}

#[test]
fn tiny_grids_work() {
    for (w, h) in [(1, 1), (1, 7), (7, 1), (2, 2), (3, 5)] {
        for rim in [Boundary::WRAP, Boundary::CLOSED, Boundary::OPEN, CYLINDER] {
            let p = run(&grid(w, h, rim), 3, &Tectonics::default(), 40);
            assert_eq!(p.crust_units(), p.budget().net(), "{w} x {h}");
        }
    }
}

#[test]
fn land_keeps_its_share() {
    for (seed, wanted) in [(1, 0.3), (2, 0.15), (3, 0.5), (4, 0.3)] {
        let g = grid(128, 64, if seed < 4 { CYLINDER } else { Boundary::WRAP });
        let mut p = new(&g, seed, &Tectonics { land: wanted, ..Tectonics::default() });
        let mut worst = 0.0f64;
        for _ in 0..310 {
            let before = level(&p);
            p.step();
            worst = worst.max((land(&p) - f64::from(wanted)).abs());
            // The coast is steady.
            assert!((level(&p) - before).abs() < 25.001, "seed {seed}: {before} to {}", level(&p));
        }
        assert!(worst < 0.03, "seed {seed}: {worst}");
        assert!(p.cycle_and_steps().0 > 1, "a whole cycle");
        // The level does not hide that the continents are gone.
        assert!(continental(&p) > 0.8 * f64::from(wanted), "seed {seed}: {}", continental(&p));
    }
}

#[test]
fn hypsometry_has_two_peaks() {
    for seed in 1..6 {
        let p = run(&grid(128, 64, CYLINDER), seed, &Tectonics::default(), 250);
        let h = hypsometry(p.height().iter().copied());
        let (sea, ground) = h.peaks_m.unwrap_or_else(|| panic!("seed {seed}: {:?}", h.shares));
        assert!((-7000.0..-3000.0).contains(&sea) && (-500.0..1800.0).contains(&ground), "seed {seed}: {sea} {ground}");
        let highest = p.height().iter().fold(0f32, |a, &b| a.max(b));
        assert!((2000.0..9500.0).contains(&highest), "seed {seed}: {highest} m");
    }
}

/// Lengths of straight pieces of coast along rows and columns, cells.
fn straight_coasts(height: &[f32], w: usize) -> Vec<usize> {
    let land = |x: usize, y: usize| height[y * w + x] > 0.0;
    let h = height.len() / w;
    let mut lengths = Vec::new();
    let mut line = |sides: &mut dyn Iterator<Item = (bool, bool)>| {
        let mut last = None;
        for (a, b) in sides {
            let side = (a != b).then_some(a);
            match lengths.last_mut() {
                Some(n) if side.is_some() && side == last => *n += 1,
                _ if side.is_some() => lengths.push(1),
                _ => {}
            }
            last = side;
        }
    };
    (0..h - 1).for_each(|y| line(&mut (0..w).map(|x| (land(x, y), land(x, y + 1)))));
    (0..w - 1).for_each(|x| line(&mut (0..h).map(|y| (land(x, y), land(x + 1, y)))));
    lengths
}

/// After a supercontinent has broken up: ranges that are high and rare, no coasts drawn with a ruler, and little land at the poles, none of
/// it from the start.
#[test]
fn a_broken_continent_looks_like_one() {
    let g = grid(256, 128, CYLINDER);
    let p = Tectonics { count: 12, gather: 0.9, breakup: 0.7, cycle: 0.0, ..Tectonics::default() };
    let worlds: Vec<Plates> = (1..7u64)
        .into_par_iter()
        .map(|seed| {
            let mut world = new(&g, seed, &p);
            let h = world.height();
            let at_pole = |c: &usize| !(8 * 256..120 * 256).contains(c) && h[*c] > 0.0;
            assert_eq!((0..h.len()).filter(at_pole).count(), 0, "seed {seed} begins at a pole");
            (0..250).for_each(|_| world.step());
            world
        })
        .collect();
    let mut straight = 0.0;
    let mut highest = Vec::new();
    for (world, seed) in worlds.iter().zip(1..) {
        let lengths = straight_coasts(world.height(), 256);
        let all: usize = lengths.iter().sum();
        straight += lengths.iter().filter(|&&n| n >= 8).sum::<usize>() as f64 / all as f64 / 6.0;
        assert!(lengths.iter().all(|&n| n < 30), "seed {seed}: a coast of {:?} cells", lengths.iter().max());
        let share = |m: f32| world.height().iter().filter(|h| **h > m).count() as f64 / (256.0 * 128.0 * 0.3);
        assert!((0.002..0.25).contains(&share(2000.0)) && share(4000.0) < 0.03, "seed {seed}: {}", share(2000.0));
        highest.push(world.height().iter().fold(0f32, |a, &b| a.max(b)));
    }
    assert!(straight < 0.04, "{straight}");
    highest.sort_by(f32::total_cmp);
    assert!(highest[2] > 3000.0 && highest[5] < 8000.0, "{highest:?}");
}

#[test]
fn crust_is_accounted_for() {
    let mut p = new(&grid(96, 64, Boundary::WRAP), 5, &Tectonics::default());
    for _ in 0..100 {
        p.step();
        assert_eq!(p.crust_units(), p.budget().net());
    }
    let b = *p.budget();
    assert!(b.ridges > 0 && b.subducted > 0 && b.arcs > 0 && b.left == 0, "{b:?}");
    assert!(b.arcs < b.subducted, "volcanoes bring up a part of what sank: {b:?}");
    let open = run(&grid(96, 64, Boundary::OPEN), 5, &Tectonics::default(), 60);
    assert!(open.budget().left > 0);
}

/// What others do to the land is there after the plates have moved, on the plate that it was done to.
#[test]
fn what_others_did_survives_a_step() {
    let g = grid(128, 64, CYLINDER);
    let p = Tectonics { erosion: 0.0, coast: 0.0, denudation: 0.0, ..Tectonics::default() };
    let mut plates = run(&g, 8, &p, 20);
    let before = *plates.budget();
    let mut height = plates.height().to_vec();
    let natural = height.clone();
    let chosen: Vec<usize> = (0..height.len()).filter(|c| c % 97 == 0).collect();
    for &c in &chosen {
        height[c] += if c % 2 == 0 { 250.0 } else { -250.0 };
    }
    plates.set_height(&height).unwrap();
    let mut other = run(&g, 8, &p, 20);
    assert_eq!(plates.crust_units(), plates.budget().net());
    assert!(plates.budget().deposited > before.deposited && plates.budget().removed > before.removed);
    plates.step();
    other.step();
    // The cells may have moved: the sum of what differs is what was done, where nothing sank.
    let differs: Vec<f32> = plates.height().iter().zip(other.height()).map(|(a, b)| a - b).collect();
    let kept = differs.iter().filter(|d| (d.abs() - 250.0).abs() < 5.0).count();
    assert!(kept as f64 > 0.9 * chosen.len() as f64, "{kept} of {} survive", chosen.len());
    assert_eq!(natural.len(), differs.len());
}

#[test]
fn threads_change_nothing() {
    let g = grid(128, 96, Boundary::WRAP);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| state(&run(&g, 4, &Tectonics::default(), 60)))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

#[test]
fn a_state_can_be_stored_and_continued() {
    let g = grid(96, 48, CYLINDER);
    let p = Tectonics { cycle: 60.0, ..Tectonics::default() };
    let straight = run(&g, 6, &p, 130);
    let first = run(&g, 6, &p, 47);
    let maps = (first.owner().iter().map(|&o| f32::from(o)), first.crust_m(), first.age_myr().iter().copied());
    let mut second = Plates::of_state(&g, 6, p, &first.state(0.0), maps).unwrap();
    assert_eq!(state(&second), state(&first));
    (47..130).for_each(|_| second.step());
    assert!(state(&second) == state(&straight));
}

/// The correlation of the two halves of a world, north and south, or west and east.
fn halves(field: &[f32], w: usize, h: usize, vertical: bool) -> f64 {
    let pair = |i: usize| {
        let (x, y) = (i % w, i / w);
        if vertical { (y < h / 2).then(|| (i, (y + h / 2) * w + x)) } else { (x < w / 2).then(|| (i, i + w / 2)) }
    };
    let pairs: Vec<(f64, f64)> =
        (0..w * h).filter_map(pair).map(|(a, b)| (f64::from(field[a]), f64::from(field[b]))).collect();
    let n = pairs.len() as f64;
    let (ma, mb) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
    let (va, vb) = (sum(&|p| (p.0 - ma).powi(2)), sum(&|p| (p.1 - mb).powi(2)));
    sum(&|p| (p.0 - ma) * (p.1 - mb)) / (va * vb).sqrt()
}

#[test]
fn the_start_does_not_repeat() {
    let (mut most, mut mean) = (0.0f64, 0.0);
    for seed in 0..12 {
        let p = new(&grid(96, 96, Boundary::WRAP), seed, &Tectonics::default());
        for vertical in [false, true] {
            let c = halves(p.height(), 96, 96, vertical);
            most = most.max(c);
            mean += c / 24.0;
        }
        // No seam: across the rim heights differ as they do inside.
        let step = |a: usize, b: usize| f64::from((p.height()[a] - p.height()[b]).abs());
        let seam: f64 = (0..96).map(|i| step(i, 95 * 96 + i) + step(96 * i, 96 * i + 95)).sum();
        let inside: f64 = (0..96).map(|i| step(40 * 96 + i, 41 * 96 + i) + step(96 * i + 40, 96 * i + 41)).sum();
        assert!(seam < 4.0 * inside.max(1.0), "seed {seed}: {seam} {inside}");
    }
    assert!(most < 0.8 && mean.abs() < 0.25, "{most} {mean}");
}

/// On a torus a world that starts elsewhere takes the same course there.
#[test]
fn a_torus_has_no_special_place() {
    let (w, h) = (64, 48);
    let g = grid(w, h, Boundary::WRAP);
    // Volcanoes stand on a lattice that belongs to the plate's place at its birth.
    let p = Tectonics { arcs: 0.0, ..Tectonics::default() };
    let first = run(&g, 9, &p, 8);
    let (dx, dy) = (23, 31);
    let from = |i: usize| (i / w + h - dy) % h * w + (i % w + w - dx) % w;
    let (crust, numbers): (Vec<f32>, _) = (first.crust_m().collect(), first.state(0.0));
    let restored = |shifted: bool| {
        let at = |i: usize| if shifted { from(i) } else { i };
        let maps = (
            (0..w * h).map(|i| f32::from(first.owner()[at(i)])),
            (0..w * h).map(|i| crust[at(i)]),
            (0..w * h).map(|i| first.age_myr()[at(i)]),
        );
        let mut p = Plates::of_state(&g, 9, first.parameters().clone(), &numbers, maps).unwrap();
        (0..12).for_each(|_| p.step());
        p
    };
    let (here, there) = (restored(false), restored(true));
    let same = (0..w * h).filter(|&i| here.owner()[from(i)] == there.owner()[i]).count();
    // Where three plates meet in one cell the order of rows decides.
    assert!(same as f64 > 0.995 * (w * h) as f64, "{same} of {}", w * h);
    let differs = (0..w * h).filter(|&i| (here.height()[from(i)] - there.height()[i]).abs() > 20.0).count();
    assert!((differs as f64) < 0.02 * (w * h) as f64, "{differs}");
}

/// Mean over four seeds of a measure after 60 steps.
fn mean(p: &Tectonics, measure: impl Fn(&Plates) -> f64) -> f64 {
    let g = grid(96, 48, CYLINDER);
    let worlds: Vec<Plates> = (1..5u64).into_par_iter().map(|seed| run(&g, seed, p, 60)).collect();
    worlds.iter().map(measure).sum::<f64>() / 4.0
}

#[test]
fn every_parameter_does_what_it_says() {
    let usual = Tectonics::default();
    let higher = |name: &str, low: Tectonics, high: Tectonics, measure: &dyn Fn(&Plates) -> f64| {
        let (a, b) = (mean(&low, measure), mean(&high, measure));
        assert!(b > a, "{name}: {a} and {b}");
    };
    let budget = |f: fn(&eyot_plates::Budget) -> i64| move |p: &Plates| f(p.budget()) as f64;
    let highest = |p: &Plates| p.height().iter().fold(0.0, |a, &b| f64::max(a, f64::from(b)));
    let with = |f: &dyn Fn(&mut Tectonics)| {
        let mut t = usual.clone();
        f(&mut t);
        t
    };
    higher("land", with(&|t| t.land = 0.2), with(&|t| t.land = 0.4), &land);
    let plates = |p: &Plates| p.list().len() as f64;
    higher("count", with(&|t| t.count = 4), with(&|t| t.count = 20), &plates);
    let ridges = budget(|b| b.ridges);
    higher("years_per_step", with(&|t| t.years_per_step = 2e5), usual.clone(), &ridges);
    higher("speed", with(&|t| t.speed = 0.02), with(&|t| t.speed = 0.08), &ridges);
    higher("slab_pull", with(&|t| t.slab_pull = 0.0), with(&|t| t.slab_pull = 1.5), &Plates::mean_speed);
    higher("friction", with(&|t| t.friction = 20.0), with(&|t| t.friction = 0.0), &Plates::mean_speed);
    let eager = Tectonics { suture_share: 0.0, ..usual.clone() };
    let never = Tectonics { suture_share: 10.0, suture_area: 1e9, ..usual.clone() };
    let thick = |p: &Plates| p.crust_m().filter(|&c| c > 50_000.0).count() as f64;
    higher("suture", eager, never, &thick);
    higher("fold_width", with(&|t| t.fold_width = 1.5e6), with(&|t| t.fold_width = 1e5), &highest);
    higher("max_crust", with(&|t| t.max_crust = 50_000.0), with(&|t| t.max_crust = 80_000.0), &highest);
    let shelf = |p: &Plates| p.crust_m().filter(|c| (9_000.0..20_000.0).contains(c)).count() as f64;
    higher("stretch", with(&|t| t.stretch = 0.0), with(&|t| t.stretch = 0.45), &shelf);
    higher("arcs", with(&|t| t.arcs = 0.0), with(&|t| t.arcs = 0.5), &budget(|b| b.arcs));
    higher("erosion", with(&|t| t.erosion = 1000.0), with(&|t| t.erosion = 0.0), &thick);
    higher("denudation", with(&|t| t.denudation = 20.0), with(&|t| t.denudation = 0.0), &highest);
    let coasts = |p: &Plates| p.height().iter().filter(|h| (0.0..100.0).contains(*h)).count() as f64;
    assert_ne!(mean(&with(&|t| t.coast = 0.0), coasts), mean(&with(&|t| t.coast = 2000.0), coasts));
    let cycles = |p: &Plates| p.cycle_and_steps().0 as f64;
    higher("cycle", usual.clone(), with(&|t| t.cycle = 20.0), &cycles);
    let rests = |p: &Plates| f64::from(u8::from(p.is_at_rest()));
    let ends = |cycles: u32| Tectonics { cycle: 20.0, cycles, ..usual.clone() };
    higher("cycles", ends(0), ends(2), &rests);
    higher("stall", usual.clone(), with(&|t| t.stall = 1.0), &cycles);
    let turned = |p: &Plates| {
        let start = new(&grid(96, 48, CYLINDER), 1, p.parameters());
        start.list().iter().zip(p.list()).map(|(a, b)| (a.azimuth_deg - b.azimuth_deg).abs()).sum::<f64>()
    };
    assert_ne!(mean(&with(&|t| t.turning = 0.0), turned), mean(&with(&|t| t.turning = 5.0), turned));
    let far = |p: &Tectonics| mean(p, |p| p.list().iter().map(|i| i.continental).fold(0.0, f64::max));
    assert_ne!(far(&with(&|t| t.breakup = 0.0)), far(&with(&|t| t.breakup = 1.0)));
    assert_ne!(
        mean(&with(&|t| t.arc_distance = 0.0), highest),
        mean(&with(&|t| t.arc_distance = 1e6), highest),
        "arc_distance"
    );
    // One continent has less coast than several.
    let coast = |p: &Plates| {
        let h = p.height();
        (0..h.len() - 96).filter(|&i| (h[i] > 0.0) != (h[i + 96] > 0.0)).count() as f64
    };
    let g = grid(96, 48, CYLINDER);
    let start = |gather: f32| {
        let t = Tectonics { gather, ..usual.clone() };
        (1..6).map(|seed| coast(&new(&g, seed, &t))).sum::<f64>()
    };
    assert!(start(1.0) < start(0.0), "gather");
}

/// Parameters may change between steps, and a raised counter begins a new cycle.
#[test]
fn parameters_are_live() {
    let g = grid(96, 48, CYLINDER);
    let mut p = run(&g, 2, &Tectonics::default(), 30);
    p.set_parameters(&g, Tectonics { land: 0.36, restarts: 1, count: 5, ..Tectonics::default() }).unwrap();
    p.step();
    assert_eq!((p.cycle_and_steps().0, p.list().len()), (2, 5));
    (0..80).for_each(|_| p.step());
    assert!((land(&p) - 0.36).abs() < 0.03, "{}", land(&p));
}

/// A wish for more or less land, or land that others raised, is answered within some dozens of steps, and by no flood.
#[test]
fn the_sea_goes_where_it_is_asked_to_without_haste() {
    let g = grid(96, 48, CYLINDER);
    let mut p = run(&g, 2, &Tectonics::default(), 30);
    for wanted in [0.38, 0.15, 0.3] {
        p.set_parameters(&g, Tectonics { land: wanted, ..Tectonics::default() }).unwrap();
        for _ in 0..90 {
            let (before, level_before) = (land(&p), level(&p));
            p.step();
            assert!((land(&p) - before).abs() < 0.03, "{wanted}: from {before} to {}", land(&p));
            assert!((level(&p) - level_before).abs() < 25.001, "{wanted}: {level_before} to {}", level(&p));
        }
        assert!((land(&p) - f64::from(wanted)).abs() < 0.02, "{wanted}: {}", land(&p));
    }
    let raised: Vec<f32> = (0..96 * 48).map(|c| if c % 96 < 10 { 800.0 } else { p.height()[c] }).collect();
    p.set_height(&raised).unwrap();
    let (high, level_before) = (land(&p), level(&p));
    p.step();
    assert!(high > 0.36 && land(&p) > high - 0.03 && (level(&p) - level_before).abs() < 25.001, "{high} {}", land(&p));
    (0..80).for_each(|_| p.step());
    assert!((land(&p) - 0.3).abs() < 0.02, "{}", land(&p));
}

/// New cycles asked for by hand in every third step, and all numbers of plates, leave a world that works.
#[test]
fn restarts_by_hand_and_any_number_of_plates_work() {
    let g = grid(96, 48, CYLINDER);
    let mut p = run(&g, 5, &Tectonics::default(), 5);
    for (restarts, count) in (1..).zip([2, 30, 3, 60, 2, 10, 30, 2]) {
        p.set_parameters(
            &g,
            Tectonics { restarts, count, speed: 0.03 + 0.01 * restarts as f32, ..Tectonics::default() },
        )
        .unwrap();
        p.step();
        assert_eq!(p.cycle_and_steps().0, u64::from(restarts) + 1);
        // Slivers join their neighbours at once.
        let plates = p.list().len();
        assert!(plates <= count as usize && plates as f64 >= 0.9 * f64::from(count), "{plates} of {count}");
        (0..2).for_each(|_| p.step());
        assert_eq!(p.crust_units(), p.budget().net());
        assert!((land(&p) - 0.3).abs() < 0.03, "{}", land(&p));
    }
    for count in [2, 30] {
        let t = Tectonics { count, cycle: 40.0, ..Tectonics::default() };
        let p = run(&g, 6, &t, 205);
        assert!(p.cycle_and_steps().0 >= 6 && p.list().len() >= 2, "{count}: {:?}", p.cycle_and_steps());
        assert!((land(&p) - 0.3).abs() < 0.03 && continental(&p) > 0.25, "{count}: {} {}", land(&p), continental(&p));
        let h = hypsometry(p.height().iter().copied());
        assert!(h.peaks_m.is_some(), "{count}: {:?}", h.shares);
    }
}

#[test]
fn what_cannot_work_is_refused_by_name() {
    let small = Grid::new(64, 64, 1000.0, Boundary::WRAP, &Limits::default()).unwrap();
    let said = |g: &Grid, p: Tectonics| Plates::new(g, 1, p, Start::Noise).err().unwrap().to_string();
    let text = said(&small, Tectonics::default());
    assert!(text.contains("plates.years_per_step") && text.contains("320000 at most"), "{text}");
    let text = said(&small, Tectonics { years_per_step: 1e5, speed: 0.01, erosion: 10_000.0, ..Tectonics::default() });
    assert!(text.contains("plates.erosion"), "{text}");
    let g = grid(16, 16, Boundary::WRAP);
    assert!(said(&g, Tectonics { count: 1, ..Tectonics::default() }).contains("plates.count"));
    assert!(said(&g, Tectonics { speed: f32::NAN, ..Tectonics::default() }).contains("plates.speed"));
    let bad = Plates::new(&g, 1, Tectonics::default(), Start::Height(&[f32::NAN; 256]));
    assert!(bad.err().unwrap().to_string().contains("finite heights"));
}

/// A given land is kept: its crust carries it.
#[test]
fn a_given_height_is_kept() {
    let g = grid(64, 32, CYLINDER);
    let height: Vec<f32> = (0..64 * 32).map(|i| -6000.0 + 10_500.0 * (i % 64) as f32 / 63.0).collect();
    let p = Plates::new(&g, 1, Tectonics::default(), Start::Height(&height)).unwrap();
    let worst = p.height().iter().zip(&height).map(|(a, b)| (a - b).abs()).fold(0f32, f32::max);
    assert!(worst < 1.0, "{worst}");
}
