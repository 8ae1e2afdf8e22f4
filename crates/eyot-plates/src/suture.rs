//! Continents that have collided long enough grow together.
//!
//! For each pair of plates the area that was lost in collisions is counted over the whole cycle; it fades by a percent a step where
//! they no longer touch. Once it exceeds `suture_area`, or `suture_share` of the continents of the plate that has less of them, that plate
//! gives the continents that touch the other one to it, and if little is left of it, everything. Momentum is conserved, and the border
//! jumps to the far coast, where a new trench or ridge begins.

use crate::crust::units;
use crate::geometry::Geometry;
use crate::pairs::Pairs;
use crate::parameters::Tectonics;
use crate::plate::Plate;

/// Margins down to this thickness go with their continent, m.
const MARGIN_M: f32 = 11_000.0;
/// A plate that would keep less than this share of its area goes as a whole.
const REST: f64 = 0.3;
/// What is left after a step of an overlap that does not grow.
pub(crate) const MEMORY: f64 = 0.99;

/// The pair that has to grow together first, as (taker, giver): the one with the most overlap relative to its limit.
pub(crate) fn due(overlap: &Pairs, continents: &[u32], cell_km2: f64, p: &Tectonics) -> Option<(u8, u8)> {
    let n = continents.len() as u8;
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
    let excess = |(a, b): (u8, u8)| {
        let area = overlap.get(a, b) + overlap.get(b, a);
        let smaller = f64::from(continents[usize::from(a)].min(continents[usize::from(b)])) * cell_km2;
        let limit = f64::from(p.suture_area).min(f64::from(p.suture_share) * smaller);
        if smaller > 0.0 && area > limit { area / limit.max(cell_km2) } else { 0.0 }
    };
    let (most, pair) =
        pairs.map(|pair| (excess(pair), pair)).fold((0.0, (0, 0)), |best, now| if now.0 > best.0 { now } else { best });
    let (a, b) = pair;
    let a_gives = continents[usize::from(a)] < continents[usize::from(b)];
    (most > 0.0).then_some(if a_gives { (b, a) } else { (a, b) })
}

/// Gives the taker what it is to get; returns the number of cells.
pub(crate) fn join(
    g: &Geometry,
    owner: &mut [u8],
    crust: &[i32],
    plates: &mut [Plate],
    areas: &[u32],
    (taker, giver): (u8, u8),
) -> usize {
    let margin = units(MARGIN_M);
    let mut front: Vec<usize> = (0..owner.len())
        .filter(|&c| owner[c] == giver && crust[c] >= margin && g.sides(c).any(|s| owner[s] == taker))
        .collect();
    let mut taken = vec![false; owner.len()];
    front.iter().for_each(|&c| taken[c] = true);
    let mut cells = 0;
    while let Some(cell) = front.pop() {
        cells += 1;
        for side in g.sides(cell) {
            if owner[side] == giver && crust[side] >= margin && !taken[side] {
                taken[side] = true;
                front.push(side);
            }
        }
    }
    let (a, b) = (f64::from(areas[usize::from(taker)]), f64::from(areas[usize::from(giver)]));
    let all = b - (cells as f64) < REST * b;
    for (o, t) in owner.iter_mut().zip(&taken) {
        if *t || (all && *o == giver) {
            *o = taker;
        }
    }
    let gained = if all { b } else { cells as f64 };
    let (from, to) = (plates[usize::from(giver)], &mut plates[usize::from(taker)]);
    for i in 0..2 {
        let mix = |own: f64, new: f64| (own * a + new * gained) / (a + gained).max(1.0);
        to.velocity[i] = mix(to.velocity[i], from.velocity[i]);
        to.heading[i] = mix(to.heading[i], from.heading[i]);
    }
    cells
}
