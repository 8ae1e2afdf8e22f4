//! Ways over flats: towards the lower edge and away from higher ground, so that water gathers in the middle.
//!
//! # Equations
//! `m = 2 t - a`, with `t` the fewest steps over the flat to one of its cells that has a lower neighbour, and `a` the fewest
//! steps from its cells beside higher ground (1 there, 0 everywhere on a flat without such cells). Water goes to the
//! neighbour on the flat with the lowest `m`, of equal ones the first clockwise from north. One of the neighbours has `t`
//! less by one and `a` more or less by at most one, so `m` falls on every step and no cell is left over.
//!
//! # Source
//! Barnes, Lehman & Mulla (2014), An efficient assignment of drainage direction over flat surfaces in raster digital
//! elevation models, Computers & Geosciences 62, 128-135.
//!
//! # Differences
//! The paper inverts `a` within each flat; differences within a flat are all that counts, so flats need no labels.

use super::Height;
use super::neighbours::Neighbours;
use super::steepest::{FLAT, NOWHERE};
use eyot_core::{Control, Result};

/// A cell on the lower edge of a flat; its direction is in the low bits.
const EDGE: u8 = 0x10;
/// A cell of a flat from which the lower edge can be reached.
const REACHED: u8 = 0x20;

/// Gives the cells marked [`FLAT`] a direction; those of flats that nothing leaves become outlets.
pub(super) fn resolve_flats<T: Height>(
    z: &[T],
    around: &Neighbours,
    direction: &mut [u8],
    control: &Control<'_>,
) -> Result<()> {
    let flat: Vec<u32> = (0..z.len() as u32).filter(|&i| direction[i as usize] == FLAT).collect();
    if flat.is_empty() {
        return Ok(());
    }
    control.check()?;
    let (mut edges, mut frontier, mut m) = (Vec::new(), Vec::new(), vec![0_i32; z.len()]);
    for &i in &flat {
        let mut high = false;
        around.each(i as usize, |_, j| {
            high |= z[j] > z[i as usize];
            if z[j] == z[i as usize] && direction[j] < EDGE && direction[j] != FLAT {
                direction[j] |= EDGE;
                edges.push(j as u32);
            }
        });
        if high {
            m[i as usize] = -1;
            frontier.push(i);
        }
    }
    for &i in &edges {
        let mut high = false;
        around.each(i as usize, |_, j| high |= z[j] > z[i as usize]);
        if high {
            m[i as usize] = -1;
            frontier.push(i);
        }
    }
    let on_flat = |d: u8| d >= FLAT;
    // Away from higher ground.
    let mut next = Vec::new();
    while !frontier.is_empty() {
        for i in frontier.drain(..) {
            let i = i as usize;
            around.each(i, |_, j| {
                if m[j] == 0 && on_flat(direction[j]) && z[j] == z[i] {
                    m[j] = m[i] - 1;
                    next.push(j as u32);
                }
            });
        }
        std::mem::swap(&mut frontier, &mut next);
    }
    control.check()?;
    // Towards the lower edge.
    frontier.extend_from_slice(&edges);
    let mut steps = 0;
    while !frontier.is_empty() {
        steps += 2;
        for i in frontier.drain(..) {
            let i = i as usize;
            around.each(i, |_, j| {
                if direction[j] == FLAT && z[j] == z[i] {
                    direction[j] = REACHED;
                    m[j] += steps;
                    next.push(j as u32);
                }
            });
        }
        std::mem::swap(&mut frontier, &mut next);
    }
    control.check()?;
    for &i in &flat {
        let i = i as usize;
        let (mut best, mut to) = (m[i], NOWHERE);
        if direction[i] == REACHED {
            around.each(i, |d, j| {
                if m[j] < best && direction[j] >= EDGE && z[j] == z[i] {
                    (best, to) = (m[j], d as u8);
                }
            });
        }
        direction[i] = to | REACHED;
    }
    flat.iter().chain(&edges).for_each(|&i| direction[i as usize] &= EDGE - 1);
    Ok(())
}
