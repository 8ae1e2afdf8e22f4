//! Trees as points.

use crate::world;
use eyot_core::{Field, World};
use eyot_plants::trees::{DISTANCE_M, Tree, Trees, points};
use eyot_plants::{FOREST, TREE_SIZE};

fn wood(share: f32) -> World {
    let mut w = world([40, 30], 10.0, |x, y| x as f32 + 2.0 * y as f32);
    w.put(&FOREST, Field::new(40, 30, share)).unwrap();
    w.put(&TREE_SIZE, Field::from_fn(40, 30, |x, _| 0.1 + 0.02 * x as f32)).unwrap();
    w
}

fn all(w: &World) -> Vec<Tree> {
    Trees::of(w).unwrap().all()
}

#[test]
fn no_two_trees_stand_too_close_and_a_closed_forest_has_few_gaps() {
    let trees = all(&wood(1.0));
    for (i, a) in trees.iter().enumerate() {
        for b in &trees[..i] {
            let d = (a.place[0] - b.place[0]).hypot(a.place[1] - b.place[1]);
            assert!(d >= DISTANCE_M, "{d} m");
        }
    }
    // The densest packing has 1.15 trees on the square of the distance, random ones that leave no gap some 0.7.
    let density = trees.len() as f32 * DISTANCE_M * DISTANCE_M / (400.0 * 300.0);
    assert!((0.5..0.7).contains(&density), "{density}");
    let mut ids: Vec<u64> = trees.iter().map(|t| t.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), trees.len());
    assert!(trees.iter().all(|t| t.height > 0.0 && t.crown > 0.0 && t.age > 0.0));
}

/// Steps from tree to tree go in all directions alike: nothing of the lattice is seen.
#[test]
fn nothing_of_the_lattice_is_seen() {
    let trees = all(&wood(1.0));
    let mut bins = [0.0f32; 12];
    for a in &trees {
        let near = trees.iter().filter(|b| b.id != a.id).map(|b| [b.place[0] - a.place[0], b.place[1] - a.place[1]]);
        let [dx, dy] = near.min_by(|p, q| p[0].hypot(p[1]).total_cmp(&q[0].hypot(q[1]))).unwrap();
        let turn = dy.atan2(dx).rem_euclid(std::f32::consts::PI) / std::f32::consts::PI;
        bins[((turn * 12.0) as usize).min(11)] += 12.0 / trees.len() as f32;
    }
    assert!(bins.iter().all(|b| (0.75..1.25).contains(b)), "{bins:?}");
}

#[test]
fn a_tree_is_the_same_in_every_window_and_on_any_threads() {
    let w = wood(0.8);
    let trees = all(&w);
    let window = [[113.0, 71.0], [260.0, 190.0]];
    let part = Trees::of(&w).unwrap().within(window);
    let inside = |t: &&Tree| (0..2).all(|i| (window[0][i]..window[1][i]).contains(&t.place[i]));
    assert!(part.len() > 100 && trees.iter().filter(inside).eq(&part));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert!(pool.install(|| all(&w)) == trees);
    let mut other = wood(0.8);
    other.seed = 2;
    assert!(all(&other) != trees);
}

#[test]
fn trees_stand_in_the_forest_and_follow_its_size() {
    let mut w = wood(1.0);
    w.put(&FOREST, Field::from_fn(40, 30, |x, _| if x < 20 { 1.0 } else { 0.0 })).unwrap();
    let trees = all(&w);
    assert!(trees.iter().all(|t| t.place[0] < 205.0));
    let mean = |low: f32, high: f32| {
        let found: Vec<f32> = trees.iter().filter(|t| (low..high).contains(&t.place[0])).map(|t| t.height).collect();
        found.iter().sum::<f32>() / found.len() as f32
    };
    assert!(mean(0.0, 50.0) < 0.6 * mean(150.0, 200.0));
    for t in &trees {
        let ground = (t.place[0] / 10.0 - 0.5).max(0.0) + 2.0 * (t.place[1] / 10.0 - 0.5).clamp(0.0, 29.0);
        assert!((t.place[2] - ground).abs() < 1e-3, "{t:?}");
    }
    assert_eq!(points(&trees).unwrap().len(), trees.len());
    assert!(Trees::of(&world([4, 4], 10.0, |_, _| 0.0)).is_none());
}
