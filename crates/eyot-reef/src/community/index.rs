//! Who stands near a place: grids of cells, one for each doubling of size, so that a recruit of a millimetre finds the colony of
//! three metres that covers it without looking at all the others.

use rayon::prelude::*;

/// What a neighbour is to others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Massive,
    Branching,
    Alga,
}

/// All that others need to know of an individual, kept together for the cache's sake.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Centre, m.
    pub(super) x: f32,
    pub(super) y: f32,
    /// Mean radius, m.
    pub(super) radius: f32,
    /// Longest ray, m.
    pub(super) reach: f32,
    /// Radius of a disc that it surely covers, m.
    pub(super) inner: f32,
    /// What decides who is the larger one.
    pub(super) rank: f32,
    /// Its number among its like.
    pub(super) who: u32,
    pub(super) kind: Kind,
    pub(super) bleached: bool,
}

/// A rectangle, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) from: [f32; 2],
    pub(super) to: [f32; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Level {
    /// Twice the largest reach that this level is for, m.
    edge: f32,
    columns: usize,
    rows: usize,
    /// Its first cell among those of all levels.
    first: usize,
    /// Largest reach of those who are in it, m.
    reach: f32,
    entries: usize,
}

impl Level {
    /// Column or row of a coordinate, clamped to the grid.
    #[inline]
    fn cell(&self, v: f32, from: f32, count: usize) -> usize {
        // Negative numbers become 0.
        (((v - from) / self.edge) as usize).min(count - 1)
    }
}

/// The index. Filled anew each month; memory is kept.
#[derive(Debug, Default)]
pub(super) struct Index {
    from: [f32; 2],
    levels: Vec<Level>,
    /// Where the entries of a cell begin; one more than there are cells.
    starts: Vec<u32>,
    entries: Vec<Entry>,
    cells: Vec<u32>,
}

/// Edge of the finest cells, m, unless individuals are so few that larger ones do.
const FINEST_M: f32 = 0.5;

impl Index {
    /// Sorts individuals into cells. Places outside the extent are kept in the cells at its border.
    pub(super) fn fill(
        &mut self,
        extent: Extent,
        max_reach: f32,
        individuals: impl ExactSizeIterator<Item = Entry> + Clone,
    ) {
        let sides = [extent.to[0] - extent.from[0], extent.to[1] - extent.from[1]];
        // At most about two cells of the finest level for each individual.
        let sparse = (sides[0] * sides[1] / (2.0 * individuals.len() as f32 + 4096.0)).sqrt();
        self.from = extent.from;
        self.levels.clear();
        let (mut edge, mut first) = (FINEST_M.max(sparse), 0);
        loop {
            let count = |side: f32| ((side / edge).ceil() as usize).max(1);
            let level = Level { edge, columns: count(sides[0]), rows: count(sides[1]), first, reach: 0.0, entries: 0 };
            first += level.columns * level.rows;
            self.levels.push(level);
            if edge >= 2.0 * max_reach {
                break;
            }
            edge *= 2.0;
        }
        self.starts.clear();
        self.starts.resize(first + 1, 0);
        self.cells.clear();
        for e in individuals.clone() {
            let last = self.levels.len() - 1;
            let l = self.levels[..last].iter().position(|l| 2.0 * e.reach <= l.edge).unwrap_or(last);
            let level = &mut self.levels[l];
            level.entries += 1;
            level.reach = level.reach.max(e.reach);
            let (i, j) = (level.cell(e.x, self.from[0], level.columns), level.cell(e.y, self.from[1], level.rows));
            let cell = level.first + j * level.columns + i;
            self.cells.push(cell as u32);
            self.starts[cell + 1] += 1;
        }
        for i in 1..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        // Fills each cell from its end; what was a cell's end is its start afterwards.
        let blank = Entry {
            x: 0.0,
            y: 0.0,
            radius: 0.0,
            reach: 0.0,
            inner: 0.0,
            rank: 0.0,
            who: 0,
            kind: Kind::Alga,
            bleached: false,
        };
        self.entries.clear();
        self.entries.resize(self.cells.len(), blank);
        for (&cell, e) in self.cells.iter().zip(individuals) {
            let at = &mut self.starts[cell as usize];
            self.entries[*at as usize] = e;
            *at += 1;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// The numbers of all individuals, neighbours near each other.
    pub(super) fn order(&self) -> impl IndexedParallelIterator<Item = usize> {
        self.entries.par_iter().map(|e| e.who as usize)
    }

    /// Calls `f` for all whose reach and the disc around (x, y) may meet, in an order that depends on nothing but what is in the
    /// index.
    #[inline]
    pub(super) fn visit(&self, x: f32, y: f32, reach: f32, mut f: impl FnMut(&Entry)) {
        for l in self.levels.iter().filter(|l| l.entries > 0) {
            let far = reach + l.reach;
            let (i0, i1) = (l.cell(x - far, self.from[0], l.columns), l.cell(x + far, self.from[0], l.columns));
            let (j0, j1) = (l.cell(y - far, self.from[1], l.rows), l.cell(y + far, self.from[1], l.rows));
            for j in j0..=j1 {
                let row = l.first + j * l.columns;
                let range = self.starts[row + i0] as usize..self.starts[row + i1 + 1] as usize;
                self.entries[range].iter().for_each(&mut f);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::community::random::{Draws, Stream};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_index_finds_all_that_a_scan_of_everybody_finds(seed in 0u64..1000, n in 0usize..400, side in 0.5f32..50.0, big in 0.01f32..4.0) {
            let draws = Draws::new(seed, Stream::Placing, 0);
            let all: Vec<Entry> = (0..n as u64)
                .map(|i| {
                    let size = draws.unit(4 * i);
                    let reach = big * size * size * size;
                    // Some stand outside the extent.
                    let [x, y] = [1, 2].map(|k| (draws.unit(4 * i + k) * 1.4 - 0.2) * side);
                    Entry { x, y, radius: reach, reach, inner: reach, rank: reach, who: i as u32, kind: Kind::Massive, bleached: false }
                })
                .collect();
            let mut index = Index::default();
            index.fill(Extent { from: [0.0; 2], to: [side; 2] }, big, all.iter().copied());
            for e in &all {
                let meets = |o: &Entry| (o.x - e.x).hypot(o.y - e.y) < o.reach + e.reach;
                let mut found = Vec::new();
                index.visit(e.x, e.y, e.reach, |o| if meets(o) { found.push(o.who) });
                found.sort_unstable();
                let want: Vec<u32> = all.iter().filter(|o| meets(o)).map(|o| o.who).collect();
                prop_assert_eq!(found, want);
            }
        }
    }
}
