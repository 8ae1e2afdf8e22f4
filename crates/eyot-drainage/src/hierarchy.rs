//! The hierarchy of depressions: which basin spills where, and which depressions become one when they are full.
//!
//! Leaves are the basins that steepest paths lead to. Two groups of them that meet by their lowest pass become the children of a new
//! depression, which is what holds water once both are full. A group that meets the outside by its lowest pass has no parent: what
//! runs over goes on to a basin of another group, or leaves.
//!
//! # Source
//! Barnes, Callaghan & Wickert (2020), Computing water flow through complex landscapes, part 2: Finding hierarchies in depressions and
//! morphological segmentations, Earth Surface Dynamics 8, 431-445.
//!
//! # Differences
//! Basins are those of [`fill`](super::fill()), labelled in parallel; only the passes between them are sorted.

use super::descent::{OUTSIDE, basins};
use super::spill::{find, passes};
use super::{Height, check_sizes};
use eyot_core::{Control, Grid, Result};
use rayon::prelude::*;

/// A depression: a basin, or two depressions that share one water table once both are full.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depression<T> {
    /// Level at which it runs over, m; minus infinity for the outside, and for numbers that no cell has.
    pub level: T,
    /// The cell that it runs over.
    pub pass: u32,
    /// The basin that then takes the water; 0 is the outside.
    pub spills_into: u32,
    /// What both become when they are full; none if what it spills leaves.
    pub parent: Option<u32>,
    /// What it is made of; none if it is a basin.
    pub children: Option<[u32; 2]>,
}

/// The depressions of a landscape.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy<T> {
    /// Of each cell the basin that it drains to, row by row; 0 where water leaves without meeting a depression.
    pub basin: Vec<u32>,
    /// How many numbers of basins there are, 0 included.
    pub basins: usize,
    /// All depressions: by number the outside (0), the basins, and then what they become, children before parents.
    pub depressions: Vec<Depression<T>>,
}

impl<T: Height> Hierarchy<T> {
    /// The depressions of `height`, from which water leaves at `outlets` (one flag a cell, at least one set).
    ///
    /// # Errors
    /// If `height` or `outlets` has another size than `grid`, the grid has 2^32 cells or more, or on a request to stop.
    pub fn new(height: &[T], grid: &Grid, outlets: &[bool], control: &Control<'_>) -> Result<Self> {
        check_sizes(grid, &[("height", height.len()), ("outlets", outlets.len())])?;
        let basins = basins(height, grid, outlets, control)?;
        let mut passes = passes::<_, u32>(height, grid, &basins, control)?;
        // Of equally low passes the order decides who is whose sibling: it must not be left to the sort.
        passes.par_sort_unstable_by_key(|p| (p.height.key(), p.basins, p.mark));
        control.check()?;
        let none =
            Depression { level: T::of(f64::NEG_INFINITY), pass: 0, spills_into: OUTSIDE, parent: None, children: None };
        let mut depressions = vec![none; basins.labels];
        let mut group: Vec<u32> = (0..basins.labels as u32).collect();
        // Of each group the depression that it is by now.
        let mut whole = group.clone();
        for pass in &passes {
            let [a, b] = pass.basins.map(|l| find(&mut group, l));
            if a == b {
                continue;
            }
            let outside = find(&mut group, OUTSIDE);
            let parent = (a != outside && b != outside).then_some(depressions.len() as u32);
            let children = [whole[a as usize], whole[b as usize]];
            for (k, root) in [a, b].into_iter().enumerate().filter(|(_, root)| *root != outside) {
                let d = &mut depressions[whole[root as usize] as usize];
                (d.level, d.pass, d.spills_into, d.parent) = (pass.height, pass.mark, pass.basins[1 - k], parent);
            }
            if parent.is_some() {
                depressions.push(Depression { children: Some(children), ..none });
            }
            // The outside stays the root of its group, so that it is found at once.
            let (root, joined) = if b == outside { (b, a) } else { (a, b) };
            group[joined as usize] = root;
            whole[root as usize] = parent.unwrap_or(OUTSIDE);
        }
        Ok(Self { basin: basins.label, basins: basins.labels, depressions })
    }

    /// Of each depression the one that it belongs to when everything is full; 0 for the outside.
    pub fn outermost(&self) -> Vec<u32> {
        let mut whole: Vec<u32> = (0..self.depressions.len() as u32).collect();
        for d in (0..whole.len()).rev() {
            if let Some(parent) = self.depressions[d].parent {
                whole[d] = whole[parent as usize];
            }
        }
        whole
    }
}
