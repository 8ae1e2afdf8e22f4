//! Groves of the automaton, and where trees stand.

use crate::{go, mean, scheduled, value, world};
use eyot_core::layer::known::{DRAINED_AREA, LAKE};
use eyot_core::process::Process as _;
use eyot_core::{Boundary, Field, Grid, Limits, World};
use eyot_plants::layers::RIVER;
use eyot_plants::{Forest, GROVE};

fn everywhere() -> Forest {
    Forest { slope: 89.0, lower: -100.0, upper: 5000.0, belt: 0.0, ..Forest::default() }
}

/// A world whose automaton begins as drawn.
fn drawn(rows: &[&str]) -> World {
    let mut w = world([rows[0].len(), rows.len()], 10.0, |_, _| 10.0);
    let alive = |x: usize, y: usize| f32::from(u8::from(rows[y].as_bytes()[x] == b'#'));
    w.put(&GROVE, Field::from_fn(rows[0].len(), rows.len(), alive)).unwrap();
    w
}

#[test]
fn fewer_than_four_neighbours_die_four_flip_and_more_live() {
    let forest = [scheduled(everywhere())];
    // The middle has 3, 4 and 5 neighbours; alive and not.
    for (rows, middle) in [
        ([".....", ".###.", ".....", ".....", "....."], 0.0),
        ([".....", ".###.", "..#..", ".....", "....."], 0.0),
        ([".....", ".###.", ".#...", ".....", "....."], 1.0),
        ([".....", ".###.", ".##..", ".....", "....."], 0.0),
        ([".....", ".###.", ".#.#.", ".....", "....."], 1.0),
        ([".....", ".###.", ".###.", ".....", "....."], 1.0),
    ] {
        let mut w = drawn(&rows);
        go(&mut w, &forest, 1);
        assert_eq!(value(&w, "grove", 2, 2), middle, "{rows:?}");
    }
}

#[test]
fn stripes_checkerboards_and_single_cells_are_cleared_away() {
    // The automaton turns checkerboards and stripes over in every step, and keeps them for ever.
    let board = ["#.#.#.#.", ".#.#.#.#"].repeat(4);
    let stripes = ["########", "........"].repeat(4);
    for rows in [board, stripes] {
        let mut w = drawn(&rows);
        go(&mut w, &[scheduled(everywhere())], 1);
        let inside = || (2..6).flat_map(|y| (2..6).map(move |x| (x, y)));
        assert!(inside().any(|(x, y)| value(&w, "grove", x, y) == 1.0));
        assert!(inside().all(|(x, y)| value(&w, "forest", x, y) == 0.0));
    }
    let mut w = drawn(&["########"; 8]);
    go(&mut w, &[scheduled(everywhere())], 1);
    assert_eq!(mean(&w, "forest"), 1.0);
}

#[test]
fn rivers_are_not_hidden_under_trees() {
    let mut w = drawn(&["########"; 8]);
    w.put(&RIVER, Field::from_fn(8, 8, |x, _| if x == 4 { 0.3 } else { 0.05 })).unwrap();
    go(&mut w, &[scheduled(everywhere())], 2);
    assert_eq!((value(&w, "forest", 4, 3), value(&w, "forest", 3, 3)), (0.0, 1.0));
}

#[test]
fn groves_close_from_noise_and_half_is_the_least() {
    let share = |share: f32| {
        let mut w = world([96, 96], 10.0, |_, _| 10.0);
        go(&mut w, &[scheduled(Forest { share, ..everywhere() })], 20);
        mean(&w, "forest")
    };
    let half = share(0.5);
    assert!((0.2..0.8).contains(&half), "{half}");
    assert!(share(0.55) > half + 0.05 && share(0.9) > 0.999);
    let grid = Grid::new(8, 8, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
    assert!(Forest { share: 0.4, ..Forest::default() }.check(&grid).is_err());
}

#[test]
fn trees_stand_on_gentle_ground_between_the_tree_lines_and_not_in_water() {
    // 100 m a cell, higher by 20 m a column: 11 degrees; a cliff in the middle of the southern half.
    let ground = |x: usize, y: usize| 20.0 * x as f32 + if y > 20 && x > 30 { 300.0 } else { 0.0 };
    let mut w = world([60, 40], 100.0, ground);
    w.put(&LAKE, Field::from_fn(60, 40, |x, y| if x == 20 && y < 10 { 1.0 } else { 0.0 })).unwrap();
    w.put(&DRAINED_AREA, Field::from_fn(60, 40, |x, y| if x == 21 && y < 10 { 1e7 } else { 0.0 })).unwrap();
    let forest =
        Forest { share: 1.0, lower: 195.0, upper: 1005.0, belt: 0.0, fade: 400.0, size: 0.2, ..Forest::default() };
    go(&mut w, &[scheduled(forest)], 3);
    for (y, x) in (1..39).flat_map(|y| (1..59).map(move |x| (y, x))) {
        let (h, found) = (ground(x, y), value(&w, "forest", x, y));
        let cliff = (y > 20 && (30..=31).contains(&x)) || ((20..=21).contains(&y) && x > 30);
        let wet = y < 10 && (20..=21).contains(&x);
        let want = (195.0..=1005.0).contains(&h) && !cliff && !wet;
        assert_eq!(found == 1.0, want, "{x} {y}");
        let size = if (195.0..=1005.0).contains(&h) { ((1005.0 - h) / 400.0 + 0.2).min(1.0) } else { 0.0 };
        assert!((value(&w, "tree_size", x, y) - size).abs() < 1e-6, "{x} {y}");
    }
}

#[test]
fn groves_thin_out_below_the_tree_line() {
    let mut w = world([100, 100], 100.0, |x, _| 10.0 * x as f32);
    go(&mut w, &[scheduled(Forest { share: 0.7, upper: 900.0, belt: 600.0, ..everywhere() })], 8);
    let share = |columns: std::ops::Range<usize>| {
        let cells = columns.len() * 100;
        columns.flat_map(|x| (0..100).map(move |y| (x, y))).map(|(x, y)| value(&w, "forest", x, y)).sum::<f32>()
            / cells as f32
    };
    assert!(
        share(5..25) > 0.9 && share(40..60) < 0.6 && share(80..90) < 0.1,
        "{} {} {}",
        share(5..25),
        share(40..60),
        share(80..90)
    );
}

#[test]
fn tree_lines_that_contradict_each_other_are_refused() {
    let grid = Grid::new(8, 8, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let error = Forest { lower: 900.0, upper: 800.0, ..Forest::default() }.check(&grid).unwrap_err().to_string();
    assert!(error.contains("forest.lower") && error.contains("900") && error.contains("800"), "{error}");
}
