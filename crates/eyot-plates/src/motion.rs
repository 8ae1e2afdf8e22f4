//! Where plates go.
//!
//! # Equations
//! 1. `dv/dt = (speed (heading + slab_pull pull) - v) / 20 Myr`, with `v` at most twice the usual speed
//! 2. `pull` is the sum of the directions in which the plate's cells sank, the older the heavier, relative to the length of a square
//!    plate's side and to the way it went in a step, smoothed over ten steps
//! 3. the heading turns by `turning spin dt`
//!
//! The headings of all plates, weighed by area, add up to nothing at the beginning of a cycle, so the world does not drift as a whole.

use crate::geometry::Geometry;
use crate::growth::unit;
use crate::pairs::Pairs;
use crate::parameters::Tectonics;
use crate::plate::Plate;
use eyot_core::math64::{cos_degrees, sin_degrees};

/// Time in which a plate takes up its speed, Myr.
const RESPONSE_MYR: f64 = 20.0;
/// Plates that are so much nearer or farther than they should be slip by a cell, cells.
const APART: f64 = 0.8;
/// Most cells that a plate may cross in a step; each is a shift of its own.
pub(crate) const MAX_SHIFTS: f64 = 32.0;

/// Moves the velocities on by a step.
pub(crate) fn accelerate(plates: &mut [Plate], p: &Tectonics) {
    let myr = p.myr_per_step();
    let (speed, top) = (f64::from(p.speed), p.top_speed());
    let relax = (myr / RESPONSE_MYR).min(1.0);
    for plate in plates {
        let angle = f64::from(p.turning) * plate.spin * myr;
        let (s, c) = (sin_degrees(angle), cos_degrees(angle));
        let [x, y] = plate.heading;
        plate.heading = [c * x - s * y, s * x + c * y];
        // What cannot move along one axis goes along the other.
        match plate.held {
            [true, false] => plate.heading = [0.0, x.hypot(y).copysign(y)],
            [false, true] => plate.heading = [x.hypot(y).copysign(x), 0.0],
            _ => {}
        }
        for i in 0..2 {
            let wanted = speed * (plate.heading[i] + f64::from(p.slab_pull) * plate.pull[i]);
            plate.velocity[i] += relax * (wanted - plate.velocity[i]);
        }
        (0..2).filter(|&i| plate.held[i]).for_each(|i| plate.velocity[i] = 0.0);
        let now = plate.velocity[0].hypot(plate.velocity[1]);
        if now > top {
            plate.velocity = plate.velocity.map(|v| v * top / now);
        }
    }
}

/// Cells that a plate crosses in a step.
pub(crate) fn way(g: &Geometry, plate: &Plate, years: f64) -> [f64; 2] {
    [plate.velocity[0] * years / g.cell_m.0, plate.velocity[1] * years / g.cell_m.1]
}

/// Shifts that the fastest plate needs in a step.
pub(crate) fn shifts(g: &Geometry, plates: &[Plate], years: f64) -> u32 {
    let most = plates.iter().flat_map(|p| way(g, p, years)).fold(0.0, |m: f64, w| m.max(w.abs()));
    most.ceil().clamp(1.0, MAX_SHIFTS) as u32
}

/// Moves each plate on by one of `parts` parts of a step, and returns by how many whole cells it shifts.
///
/// If each plate shifted when its own way is a whole cell, two plates that move side by side would shift at different times, and at each
/// time a row of crust between them would be lost or made for nothing. So a plate may be up to a cell ahead or behind, and the largest
/// plates choose first; the others go along with the neighbours with which they share the longest `borders`, as long as they are not
/// a cell apart from where they should be, seen from there.
pub(crate) fn shift(
    g: &Geometry,
    plates: &mut [Plate],
    years: f64,
    parts: u32,
    areas: &[u32],
    borders: &Pairs,
) -> Vec<(i8, i8)> {
    let mut order: Vec<usize> = (0..plates.len()).collect();
    order.sort_by_key(|&p| (std::cmp::Reverse(areas[p]), p));
    for plate in plates.iter_mut() {
        let way = way(g, plate, years);
        (0..2).for_each(|i| plate.rest[i] += way[i] / f64::from(parts));
    }
    let mut whole = vec![[0i8; 2]; plates.len()];
    for axis in 0..2 {
        for (done, &q) in order.iter().enumerate() {
            let rest = plates[q].rest[axis];
            let cost = |s: i8| {
                let left = rest - f64::from(s);
                let along = |&p: &usize| {
                    let slips = f64::from(u8::from(s != whole[p][axis]));
                    let apart = f64::from(u8::from((left - plates[p].rest[axis]).abs() > APART));
                    borders.get(p as u8, q as u8) * (slips + 4.0 * apart)
                };
                // As near as it can be where neighbours do not matter, and never more than a cell away.
                let far = if left.abs() > 1.0 { 1e9 * left.abs() } else { 0.0 };
                order[..done].iter().map(along).sum::<f64>() + left.abs() + far
            };
            let best = [0, 1, -1]
                .map(|s| (cost(s), s))
                .into_iter()
                .fold((f64::INFINITY, 0), |best, now| if now.0 < best.0 { now } else { best });
            whole[q][axis] = best.1;
            let plate = &mut plates[q];
            plate.rest[axis] = (rest - f64::from(best.1)).clamp(-1.5, 1.5);
            plate.moved[axis] += f64::from(best.1);
        }
    }
    whole.into_iter().map(|w| (w[0], w[1])).collect()
}

/// Headings and spins at the beginning of a cycle: random, turned away from other continents, without a common drift.
///
/// `away` gives for each plate the direction away from the continents, of length 0 (they are everywhere) to 1; `areas` its cells.
pub(crate) fn set_off(plates: &mut [Plate], areas: &[u32], away: &[(f64, f64)], p: &Tectonics, seed: u64) {
    for (i, plate) in plates.iter_mut().enumerate() {
        let number = |k: u64| unit(seed, 16 * i as u64 + k);
        let (angle, spin) = (360.0 * number(0), 2.0 * number(1) - 1.0);
        let (x, y) = (cos_degrees(angle), sin_degrees(angle));
        let b = f64::from(p.breakup);
        plate.heading = [(1.0 - b) * x + 2.0 * b * away[i].0, (1.0 - b) * y + 2.0 * b * away[i].1];
        let length = plate.heading[0].hypot(plate.heading[1]).max(1e-6);
        let pace = 0.7 + 0.6 * number(2);
        plate.heading = plate.heading.map(|h| h / length * pace);
        plate.spin = spin;
    }
    let cells: f64 = areas.iter().map(|&a| f64::from(a)).sum();
    for i in 0..2 {
        let mean = plates.iter().zip(areas).map(|(p, &a)| p.heading[i] * f64::from(a)).sum::<f64>() / cells;
        plates.iter_mut().for_each(|p| p.heading[i] -= mean);
    }
    plates.iter_mut().for_each(|q| q.velocity = q.heading.map(|h| h * f64::from(p.speed)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};

    fn slips(velocities: [f64; 2], steps: usize) -> (usize, f64) {
        let g = Geometry::new(&Grid::new(64, 64, 1000.0, Boundary::WRAP, &Limits::default()).unwrap());
        let mut plates = velocities.map(|v| Plate { velocity: [v, 0.0], ..Plate::default() });
        plates[1].rest[0] = 0.4;
        let mut borders = Pairs::new(2);
        (*borders.at(0, 1), *borders.at(1, 0)) = (64.0, 64.0);
        let mut slips = 0;
        for _ in 0..steps {
            let s = shift(&g, &mut plates, 1000.0, 1, &[2048, 2048], &borders);
            slips += usize::from(s[0].0 != s[1].0);
        }
        (slips, plates[0].moved[0] - plates[1].moved[0])
    }

    #[test]
    fn plates_slip_no_more_than_they_move_apart() {
        let (side_by_side, apart) = slips([0.37, 0.37], 1000);
        assert!(side_by_side <= 1 && apart.abs() <= 1.0, "{side_by_side} {apart}");
        let (n, apart) = slips([0.37, 0.36], 1000);
        assert!((apart - 10.0).abs() <= 2.0 && n <= 12, "{n} {apart}");
        let (n, apart) = slips([0.5, -0.3], 1000);
        assert!((apart - 800.0).abs() <= 2.0, "{n} {apart}");
    }
}
