//! Lakes: which depressions hold water when as much evaporates and runs over as comes in, and how high it stands.
//!
//! # Rule
//! 1. Water runs to the bottom of its basin. A depression that is full loses `C = sum over its cells of (E - AET) a` beyond what the
//!    same land would; what comes in beyond that runs over its pass, into the next depression or away.
//! 2. Two depressions that are both full and run over into each other become one, with the water of both.
//! 3. One that gets less than `C` has no outflow. Its level is that at which its surface loses what comes in: `A = Q / (E - AET)`.
//! 4. Depressions that are too small or too shallow for lakes are filled with ground, those that are nearly dry hold none.
//!
//! # Source
//! Barnes, Callaghan & Wickert (2021), Computing water flow through complex landscapes, part 3: Fill-Spill-Merge: flow routing in
//! depression hierarchies, Earth Surface Dynamics 9, 105-121. Ours: what fills a depression is a balance of rates and not a volume.

use eyot_core::{Control, Grid, Result};
use eyot_drainage::{Hierarchy, Routing, fill};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What comes in and what a lake's surface loses.
#[derive(Clone, Copy, Debug)]
pub struct Balance<'a> {
    /// What runs off each cell, m3/s.
    pub runoff: &'a [f64],
    /// What each cell loses beyond that as a part of a lake, m3/s, >= 0.
    pub loss: &'a [f64],
}

/// Depressions below these are no lakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Least {
    /// m2.
    pub area_m2: f64,
    /// m, at the deepest place.
    pub depth_m: f64,
}

/// A lake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lake {
    /// Height of its surface, m.
    pub level: f32,
    /// The cell that it runs over; `None` if it is closed.
    pub outlet: Option<u32>,
    /// Cells.
    pub cells: u32,
    /// Water, m3.
    pub volume_m3: f64,
    /// Deepest place, m.
    pub max_depth_m: f64,
    /// What comes in, rain on it included as the runoff of land, m3/s.
    pub inflow: f64,
    /// What runs over, m3/s.
    pub outflow: f64,
}

/// The lakes of a landscape, and how water runs between them.
#[derive(Clone, Debug)]
pub struct Lakes {
    /// By number from 1 on; 0 is no lake.
    pub lakes: Vec<Lake>,
    /// Of each cell the number of its lake, or 0.
    pub lake: Vec<u32>,
    /// Ground and lakes: heights without depressions but for those that keep their water, m.
    pub surface: Vec<f32>,
    /// Where water goes on that surface; closed lakes and dry hollows are outlets.
    pub routing: Routing,
    /// What runs through each cell, m3/s; within lakes it may be anything.
    pub discharge: Vec<f64>,
}

/// What is known of a depression while water is poured in.
struct Pouring<'a> {
    hierarchy: &'a Hierarchy<f32>,
    /// Water that a full one loses, m3/s.
    capacity: Vec<f64>,
    /// Water that has come, m3/s.
    water: Vec<f64>,
    full: Vec<bool>,
    /// Of each the one that it is a part of by now; by halving the ways to it.
    now: Vec<u32>,
}

impl Pouring<'_> {
    fn now(&mut self, mut d: u32) -> u32 {
        while self.now[d as usize] != d {
            let up = self.now[self.now[d as usize] as usize];
            self.now[d as usize] = up;
            d = up;
        }
        d
    }

    /// Adds water to a basin. Returns what runs over, and the basin that it runs to.
    fn pour(&mut self, basin: u32, amount: f64) -> Option<(u32, f64)> {
        let mut d = self.now(basin);
        self.water[d as usize] += amount;
        loop {
            let i = d as usize;
            let over = self.water[i] - self.capacity[i];
            if over <= 0.0 {
                return None;
            }
            self.water[i] = self.capacity[i];
            self.full[i] = true;
            let here = self.hierarchy.depressions[i];
            let children = here.parent.and_then(|p| self.hierarchy.depressions[p as usize].children.map(|c| (p, c)));
            match children {
                Some((parent, [a, b])) if self.full[a as usize] && self.full[b as usize] => {
                    (self.now[a as usize], self.now[b as usize]) = (parent, parent);
                    self.water[parent as usize] = self.water[a as usize] + self.water[b as usize] + over;
                    d = parent;
                }
                _ => return Some((here.spills_into, over)),
            }
        }
    }
}

/// What the cells below the level of each depression come to.
struct Measure {
    cells: Vec<u32>,
    loss: Vec<f64>,
    lowest: Vec<f32>,
    /// The lowest cell.
    pit: Vec<u32>,
}

fn measure(z: &[f32], hierarchy: &Hierarchy<f32>, whole: &[u32], loss: &[f64]) -> Measure {
    let depressions = &hierarchy.depressions;
    let n = depressions.len();
    let mut m = Measure { cells: vec![0; n], loss: vec![0.0; n], lowest: vec![f32::MAX; n], pit: vec![0; n] };
    // Ways up with jumps (Myers 1983), so that deep hierarchies cost no more than their logarithm.
    let (mut depth, mut jump) = (vec![0_u32; n], (0..n as u32).collect::<Vec<_>>());
    for d in (0..n).rev() {
        if let Some(p) = depressions[d].parent.map(|p| p as usize) {
            depth[d] = depth[p] + 1;
            let (j, jj) = (jump[p] as usize, jump[jump[p] as usize] as usize);
            jump[d] = if depth[p] - depth[j] == depth[j] - depth[jj] { jj } else { p } as u32;
        }
    }
    for (i, (&z, &basin)) in z.iter().zip(&hierarchy.basin).enumerate() {
        if basin == 0 || z >= depressions[whole[basin as usize] as usize].level {
            continue;
        }
        let mut d = basin as usize;
        if z < m.lowest[d] {
            (m.lowest[d], m.pit[d]) = (z, i as u32);
        }
        while depressions[d].level <= z {
            let far = jump[d] as usize;
            d = if depressions[far].level <= z { far } else { depressions[d].parent.map_or(d, |p| p as usize) };
        }
        m.cells[d] += 1;
        m.loss[d] += loss[i];
    }
    for d in 0..n {
        if let Some(p) = depressions[d].parent.map(|p| p as usize) {
            m.cells[p] += m.cells[d];
            m.loss[p] += m.loss[d];
            if m.lowest[d] < m.lowest[p] {
                (m.lowest[p], m.pit[p]) = (m.lowest[d], m.pit[d]);
            }
        }
    }
    m
}

/// Finds the lakes of `z`, from which water leaves at `outlets`.
///
/// # Errors
/// If a slice has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop.
pub fn find(
    z: &[f32],
    grid: &Grid,
    outlets: &[bool],
    balance: &Balance<'_>,
    least: &Least,
    control: &Control<'_>,
) -> Result<Lakes> {
    eyot_drainage::check_length("runoff", z.len(), balance.runoff.len())?;
    eyot_drainage::check_length("losses of lakes", z.len(), balance.loss.len())?;
    let hierarchy = Hierarchy::new(z, grid, outlets, control)?;
    let whole = hierarchy.outermost();
    let measure = measure(z, &hierarchy, &whole, balance.loss);
    let area_m2 = grid.cell_area_m2();
    let large = |cells: u32, depth_m: f64| f64::from(cells) * area_m2 >= least.area_m2 && depth_m >= least.depth_m;
    let is_lake = |d: usize| {
        let level = hierarchy.depressions[d].level;
        measure.cells[d] > 0 && large(measure.cells[d], f64::from(level) - f64::from(measure.lowest[d]))
    };
    let holds: Vec<bool> = (0..hierarchy.depressions.len()).map(|d| is_lake(whole[d] as usize)).collect();
    control.check()?;

    let pouring = pour_all(&hierarchy, &whole, &holds, measure.loss.clone(), balance.runoff);
    let (mut ground, mut ends) = (z.to_vec(), outlets.to_vec());
    let mut lakes = vec![Lake::default()];
    // Of each depression its lake, and how high that stands.
    let mut of = vec![(0_u32, f32::NEG_INFINITY); hierarchy.depressions.len()];
    let closed = closed_levels(z, &hierarchy, &whole, &holds, &pouring, balance.loss);
    for d in (1..hierarchy.depressions.len()).filter(|&d| holds[d] && pouring.now[d] as usize == d) {
        let is_basin = d < hierarchy.basins;
        if !is_basin && pouring.water[d] == 0.0 {
            // Not yet what its children are.
            continue;
        }
        let (level, outlet) = if pouring.full[d] {
            (hierarchy.depressions[d].level, Some(hierarchy.depressions[d].pass))
        } else {
            (closed[d].0, None)
        };
        let cells = if pouring.full[d] { measure.cells[d] } else { closed[d].1 };
        if large(cells, f64::from(level) - f64::from(measure.lowest[d])) && cells > 0 {
            of[d] = (lakes.len() as u32, level);
            lakes.push(Lake { level, outlet, ..Lake::default() });
        } else if !pouring.full[d] && measure.cells[d] > 0 {
            ends[measure.pit[d] as usize] = true;
        }
    }
    let mut now = pouring.now;
    for d in (0..now.len()).rev() {
        now[d] = now[now[d] as usize];
    }
    let mut lake = vec![0; z.len()];
    for (i, &basin) in hierarchy.basin.iter().enumerate() {
        let (id, level) = of[now[basin as usize] as usize];
        if id > 0 && z[i] < level {
            lake[i] = id;
            let l = &mut lakes[id as usize];
            let depth = f64::from(level) - f64::from(z[i]);
            (l.cells, l.volume_m3, l.max_depth_m) =
                (l.cells + 1, l.volume_m3 + depth * area_m2, l.max_depth_m.max(depth));
            if l.outlet.is_none() {
                (ground[i], ends[i]) = (level, true);
            }
        }
    }
    let mut surface = ground;
    fill(&mut surface, grid, &ends, control)?;
    let routing = Routing::new(&surface, grid, &ends, control)?;
    let mut discharge = balance.runoff.to_vec();
    for (i, q) in discharge.iter_mut().enumerate().filter(|(i, _)| lake[*i] > 0) {
        *q -= if lakes[lake[i] as usize].outlet.is_some() { balance.loss[i] } else { 0.0 };
    }
    routing.accumulate(&mut discharge)?;
    for i in (0..z.len()).filter(|&i| lake[i] > 0) {
        let l = &mut lakes[lake[i] as usize];
        let leaves = lake[routing.receiver(i)] != lake[i];
        if l.outlet.is_none() {
            l.inflow += discharge[i];
        } else {
            let out = if leaves { discharge[i].max(0.0) } else { 0.0 };
            (l.outflow, l.inflow) = (l.outflow + out, l.inflow + out + balance.loss[i]);
        }
    }
    Ok(Lakes { lakes, lake, surface, routing, discharge })
}

/// Lets everything that runs off find its depression.
fn pour_all<'a>(
    hierarchy: &'a Hierarchy<f32>,
    whole: &[u32],
    holds: &[bool],
    capacity: Vec<f64>,
    runoff: &[f64],
) -> Pouring<'a> {
    let n = hierarchy.depressions.len();
    let now = (0..n as u32).collect();
    let mut pouring = Pouring { hierarchy, capacity, water: vec![0.0; n], full: vec![false; n], now };
    let mut waiting = vec![0.0; hierarchy.basins];
    for (basin, amount) in hierarchy.basin.iter().zip(runoff) {
        waiting[*basin as usize] += amount;
    }
    waiting[0] = 0.0;
    // From the highest passes down, so that what comes from above has come when the lower ones run over.
    let key = |basin: u32| {
        let level = hierarchy.depressions[whole[basin as usize] as usize].level;
        (eyot_drainage::Height::key(level), Reverse(basin))
    };
    let mut open: BinaryHeap<_> =
        (1..hierarchy.basins as u32).filter(|b| waiting[*b as usize] > 0.0).map(key).collect();
    while let Some((_, Reverse(basin))) = open.pop() {
        let amount = std::mem::take(&mut waiting[basin as usize]);
        if amount <= 0.0 {
            continue;
        }
        let over = if holds[basin as usize] {
            pouring.pour(basin, amount)
        } else {
            Some((hierarchy.depressions[whole[basin as usize] as usize].spills_into, amount))
        };
        if let Some((to, amount)) = over.filter(|(to, _)| *to != 0) {
            if waiting[to as usize] == 0.0 {
                open.push(key(to));
            }
            waiting[to as usize] += amount;
        }
    }
    pouring
}

/// Of depressions without outflow, the level at which the surface loses what comes in, and the cells below it.
fn closed_levels(
    z: &[f32],
    hierarchy: &Hierarchy<f32>,
    whole: &[u32],
    holds: &[bool],
    pouring: &Pouring<'_>,
    loss: &[f64],
) -> Vec<(f32, u32)> {
    let mut levels = vec![(f32::NEG_INFINITY, 0); hierarchy.depressions.len()];
    let mut now = pouring.now.clone();
    for d in (0..now.len()).rev() {
        now[d] = now[now[d] as usize];
    }
    let mut cells: Vec<(u32, u32, u32)> = Vec::new();
    for (i, &basin) in hierarchy.basin.iter().enumerate() {
        let d = now[basin as usize] as usize;
        let inside = holds[d] && !pouring.full[d] && pouring.water[d] > 0.0;
        if inside && z[i] < hierarchy.depressions[d].level && whole[d] != 0 {
            cells.push((d as u32, eyot_drainage::Height::key(z[i]), i as u32));
        }
    }
    cells.sort_unstable();
    for group in cells.chunk_by(|a, b| a.0 == b.0) {
        let d = group[0].0 as usize;
        let (mut left, mut level) = (pouring.water[d], z[group[0].2 as usize]);
        for (_, _, i) in group {
            level = z[*i as usize];
            left -= loss[*i as usize];
            if left < 0.0 {
                break;
            }
        }
        let below = group.iter().filter(|(_, _, i)| z[*i as usize] < level).count();
        levels[d] = (level, below as u32);
    }
    levels
}
