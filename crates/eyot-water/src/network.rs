//! The network of rivers: reaches between springs, junctions, shores and mouths.
//!
//! Rivers run where the routing leads from their springs on, so that they have no loops; they end where water leaves: in the sea, at
//! the rim, in a closed lake, or in a hollow that dries it up. Through lakes they go on as reaches that say so.
//!
//! # Source
//! Strahler, A. N. (1957), Quantitative analysis of watershed geomorphology, Transactions AGU 38, 913-920: orders. Lehner & Grill
//! (2013), Global river hydrography and network routing, Hydrological Processes 27, 2171-2186: what is said of a reach.

use crate::lakes::Lakes;
use eyot_drainage::Routing;

/// Where a reach ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum End {
    /// In the next reach.
    Reach,
    /// In the sea.
    Sea,
    /// At the rim of the grid.
    Rim,
    /// In a lake without outflow.
    Lake,
    /// In a hollow without a lake.
    Hollow,
}

/// A part of a river between two places that matter.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// Its cells from its spring, or the end of those above it, to the first cell of the next one.
    pub cells: Vec<u32>,
    /// The reach that it flows into.
    pub next: Option<u32>,
    /// The last reach of its river system.
    pub mouth: u32,
    /// Strahler's order.
    pub order: u8,
    /// What runs through it at its lower end, m3/s.
    pub discharge: f64,
    /// The lake that it runs through, or 0.
    pub lake: u32,
    /// Where it ends.
    pub end: End,
}

/// The rivers of a landscape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// Reaches, in the order of the cells that they begin at.
    pub reaches: Vec<Reach>,
}

/// No reach begins here.
const NONE: u32 = u32::MAX;

/// What is said of a cell of a river: that it is one,
const ON: u8 = 0x80;
/// that a shore lies between it and a cell above it,
const SHORE: u8 = 0x40;
/// and how many cells of rivers flow into it.
const DONORS: u8 = 0x0f;

/// The rivers that begin at `springs`. `end_at(cell)` says what an outlet of the routing is.
pub fn trace(lakes: &Lakes, springs: &[u32], end_at: impl Fn(usize) -> End) -> Network {
    let routing: &Routing = &lakes.routing;
    let mut cell = vec![0_u8; routing.cells()];
    for &spring in springs {
        let mut i = spring as usize;
        while cell[i] & ON == 0 {
            cell[i] |= ON;
            let r = routing.receiver(i);
            if r == i {
                break;
            }
            cell[r] += 1;
            cell[r] |= if lakes.lake[r] == lakes.lake[i] { 0 } else { SHORE };
            i = r;
        }
    }
    // A reach begins at springs, junctions and shores, and where water leaves another reach ends.
    let begins = |i: usize| {
        let r = routing.receiver(i);
        r != i && cell[i] & ON != 0 && cell[i] & (DONORS | SHORE) != 1
    };
    let starts: Vec<u32> = (0..cell.len()).filter(|&i| cell[i] & ON != 0 && begins(i)).map(|i| i as u32).collect();
    let mut at = std::collections::HashMap::with_capacity(starts.len());
    at.extend(starts.iter().enumerate().map(|(k, &i)| (i, k as u32)));
    let mut reaches: Vec<Reach> = Vec::with_capacity(starts.len());
    for &start in &starts {
        let (mut cells, mut i) = (vec![start], start as usize);
        loop {
            let r = routing.receiver(i);
            cells.push(r as u32);
            i = r;
            if routing.receiver(i) == i || at.contains_key(&(i as u32)) {
                break;
            }
        }
        let last = cells[cells.len() - 2] as usize;
        // Water that has come into a lake runs through it as far as the reach does; in it no single cell carries it.
        let within = lakes.lake[start as usize];
        let next = at.get(&(i as u32)).copied();
        let end = if next.is_some() { End::Reach } else { end_at(i) };
        let discharge = lakes.discharge[last].max(0.0);
        reaches.push(Reach { cells, next, mouth: NONE, order: 0, discharge, lake: within, end });
    }
    order(&mut reaches);
    Network { reaches }
}

/// Orders and mouths, from the springs down.
fn order(reaches: &mut [Reach]) {
    let mut above = vec![0_u32; reaches.len()];
    for r in reaches.iter() {
        if let Some(next) = r.next {
            above[next as usize] += 1;
        }
    }
    // Of each reach the highest order that flows in, and how many times.
    let mut highest = vec![(0_u8, 0_u8); reaches.len()];
    let mut open: Vec<u32> = (0..reaches.len() as u32).filter(|&k| above[k as usize] == 0).collect();
    let mut downwards = Vec::with_capacity(reaches.len());
    while let Some(k) = open.pop() {
        let (order, times) = highest[k as usize];
        let own = if order == 0 { 1 } else { order + u8::from(times > 1) };
        reaches[k as usize].order = own;
        downwards.push(k);
        if let Some(next) = reaches[k as usize].next {
            let h = &mut highest[next as usize];
            *h = match own.cmp(&h.0) {
                std::cmp::Ordering::Greater => (own, 1),
                std::cmp::Ordering::Equal => (own, h.1.saturating_add(1)),
                std::cmp::Ordering::Less => *h,
            };
            above[next as usize] -= 1;
            if above[next as usize] == 0 {
                open.push(next);
            }
        }
    }
    for k in downwards.into_iter().rev() {
        let r = &reaches[k as usize];
        reaches[k as usize].mouth = r.next.map_or(k, |next| reaches[next as usize].mouth);
    }
}
