//! The beginning of a cycle: new plates, made from the crust that is there.
//!
//! Crust, ages and heights stay as they are; only the plates are new, so nothing is seen of it at first. With `breakup`, plates
//! head away from those with which they share a continent, and from the middle of all continents, the more the closer these lie
//! together: what has gathered drifts apart again, and continents do not begin by folding.

use crate::crust::is_continental;
use crate::geometry::Geometry;
use crate::growth::{grow, unit};
use crate::motion;
use crate::pairs::Pairs;
use crate::plate::Plate;
use crate::plates::Plates;
use eyot_core::BoundaryCondition;
use eyot_core::math64::{acos, cos_degrees, sin_degrees};
use eyot_core::rng::mix64;

/// Divides the world into plates and sets them off.
pub(crate) fn divide(world: &mut Plates) {
    let seed = mix64(world.seed ^ mix64(world.clock.cycle));
    let g = world.g;
    world.maps.owner = grow(&g, world.parameters.count as usize, seed);
    let n = world.maps.owner.iter().max().map_or(1, |&p| usize::from(p) + 1);
    let mut areas = vec![0u32; n];
    world.maps.owner.iter().for_each(|&o| areas[usize::from(o)] += 1);
    world.plates = vec![Plate::default(); n];

    let continents = world.continents();
    let (middle, gathered) = centres(&g, 1, |c| is_continental(world.maps.crust[c]).then_some(0))[0];
    let middles = centres(&g, n, |c| Some(world.maps.owner[c]));
    let shared = shared(world, n);
    let away: Vec<(f64, f64)> = (0..n)
        .map(|p| {
            let (x, y) = unit_way(&g, middle, middles[p].0);
            let mut away = (gathered * x, gathered * y);
            let total: f64 = (0..n).map(|q| shared.get(p as u8, q as u8)).sum();
            for q in 0..n {
                let (x, y) = unit_way(&g, middles[q].0, middles[p].0);
                let weight = shared.get(p as u8, q as u8) / total.max(1.0);
                away = (away.0 + weight * x, away.1 + weight * y);
            }
            let length = away.0.hypot(away.1).max(1.0);
            (away.0 / length, away.1 / length)
        })
        .collect();
    motion::set_off(&mut world.plates, &areas, &away, &world.parameters, mix64(seed ^ 0x60));

    // Where plates meet for the first time, the one that has more continents stays on top.
    let rank = |p: u8| {
        let i = usize::from(p);
        (1.0 - f64::from(continents[i]) / f64::from(areas[i].max(1)) + 1e-3 * unit(seed, 0xa11 + i as u64), p)
    };
    world.overlap = Pairs::new(n);
    world.brought = Pairs::new(n);
    world.over = Pairs::new(n);
    for (p, q) in (0..n as u8).flat_map(|p| (0..n as u8).map(move |q| (p, q))).filter(|(p, q)| p != q) {
        *world.over.at(p, q) = f64::from(u8::from(rank(p) < rank(q)));
    }
}

/// Direction from one place to another, of length 1.
fn unit_way(g: &Geometry, from: (f64, f64), to: (f64, f64)) -> (f64, f64) {
    let (x, y) = g.way(from, to);
    let (x, y) = (x * g.cell_m.0, y * g.cell_m.1);
    let length = x.hypot(y).max(1e-9);
    (x / length, y / length)
}

/// Length of the border, in cells, on which each pair of plates shares a continent.
fn shared(world: &Plates, n: usize) -> Pairs {
    let mut shared = Pairs::new(n);
    let (owner, crust) = (&world.maps.owner, &world.maps.crust);
    for cell in (0..owner.len()).filter(|&c| is_continental(crust[c])) {
        for side in world.g.sides(cell).filter(|&s| owner[s] != owner[cell] && is_continental(crust[s])) {
            *shared.at(owner[cell], owner[side]) += 1.0;
        }
    }
    shared
}

/// The middle of each of `n` sets of cells, and how far its cells are gathered there, 0..=1. On rings it is the mean direction.
pub(crate) fn centres(g: &Geometry, n: usize, set: impl Fn(usize) -> Option<u8>) -> Vec<((f64, f64), f64)> {
    let circle = |n: usize| -> Vec<(f64, f64)> {
        let degrees = |i: usize| 360.0 * (i as f64 + 0.5) / n as f64;
        (0..n).map(|i| (cos_degrees(degrees(i)), sin_degrees(degrees(i)))).collect()
    };
    let (east, south) = (circle(g.width), circle(g.height));
    // Count, sums along the circles, and plain sums.
    let mut sums = vec![[0.0f64; 7]; n];
    for cell in 0..g.cells() {
        let Some(set) = set(cell) else { continue };
        let (x, y) = (cell % g.width, cell / g.width);
        let s = &mut sums[usize::from(set)];
        let add = [1.0, east[x].0, east[x].1, south[y].0, south[y].1, x as f64, y as f64];
        s.iter_mut().zip(add).for_each(|(s, a)| *s += a);
    }
    sums.iter()
        .map(|s| {
            let count = s[0].max(1.0);
            let along = |edge: BoundaryCondition, cos: f64, sin: f64, plain: f64, n: usize| {
                if edge != BoundaryCondition::Wrap {
                    return (plain / count, 1.0);
                }
                let r = cos.hypot(sin);
                let angle = acos(cos / r.max(1e-12)) * if sin < 0.0 { -1.0 } else { 1.0 };
                let place = (angle / std::f64::consts::TAU).rem_euclid(1.0) * n as f64 - 0.5;
                (place, (r / count).min(1.0))
            };
            let (x, rx) = along(g.rim.0, s[1], s[2], s[5], g.width);
            let (y, ry) = along(g.rim.1, s[3], s[4], s[6], g.height);
            ((x, y), rx * ry)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};

    #[test]
    fn middles_are_found_over_the_rim() {
        let g = Geometry::new(&Grid::new(20, 10, 1.0, Boundary::WRAP, &Limits::default()).unwrap());
        let near = |c: usize| [18, 19, 0, 1].contains(&(c % 20)) && [4, 5].contains(&(c / 20));
        let ((x, y), gathered) = centres(&g, 1, |c| near(c).then_some(0))[0];
        assert!(((x + 0.5).abs() < 1e-9 || (x - 19.5).abs() < 1e-9) && (y - 4.5).abs() < 1e-9, "{x} {y}");
        assert!(gathered > 0.8);
        assert!(centres(&g, 1, |_| Some(0))[0].1 < 1e-9);
    }
}
