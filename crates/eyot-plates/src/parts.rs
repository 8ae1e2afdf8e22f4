//! Connected parts of plates: what is cut off from a plate joins a neighbour or becomes a plate of its own.

use crate::geometry::Geometry;
use crate::runs::Run;

/// A connected part of a plate.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) owner: u8,
    pub(crate) cells: u32,
    /// Its runs, as row and number in the row.
    runs: Vec<(u32, u32)>,
}

/// All parts, in the order of their first cell.
pub(crate) fn find(g: &Geometry, rows: &[Vec<Run>]) -> Vec<Part> {
    let first: Vec<usize> = rows
        .iter()
        .scan(0, |n, r| {
            let at = *n;
            *n += r.len();
            Some(at)
        })
        .collect();
    let total: usize = rows.iter().map(Vec::len).sum();
    let mut parent: Vec<u32> = (0..total as u32).collect();
    for (y, row) in rows.iter().enumerate() {
        if let (Some(a), Some(b), Some(_)) = (row.first(), row.last(), g.column(-1))
            && a.owner == b.owner
        {
            join(&mut parent, first[y], first[y] + row.len() - 1);
        }
        let Some(south) = g.row(y as isize + 1).filter(|&s| s != y) else { continue };
        let below = &rows[south];
        let (mut i, mut j) = (0, 0);
        while i < row.len() && j < below.len() {
            if row[i].owner == below[j].owner {
                join(&mut parent, first[y] + i, first[south] + j);
            }
            let (a, b) = (row[i].end, below[j].end);
            i += usize::from(a <= b);
            j += usize::from(b <= a);
        }
    }
    let mut part_of = vec![u32::MAX; total];
    let mut parts: Vec<Part> = Vec::new();
    for (y, row) in rows.iter().enumerate() {
        for (i, run) in row.iter().enumerate() {
            let root = find_root(&mut parent, first[y] + i);
            if part_of[root] == u32::MAX {
                part_of[root] = parts.len() as u32;
                parts.push(Part { owner: run.owner, cells: 0, runs: Vec::new() });
            }
            let part = &mut parts[part_of[root] as usize];
            part.cells += run.end - run.start;
            part.runs.push((y as u32, i as u32));
        }
    }
    parts
}

impl Part {
    /// Its cells.
    pub(crate) fn iter<'a>(&'a self, width: usize, rows: &'a [Vec<Run>]) -> impl Iterator<Item = usize> + 'a {
        self.runs
            .iter()
            .flat_map(move |&(y, i)| rows[y as usize][i as usize].range().map(move |x| y as usize * width + x))
    }

    /// The plate with which it shares the longest border, if there is any other.
    pub(crate) fn neighbour(&self, g: &Geometry, rows: &[Vec<Run>], owner: &[u8]) -> Option<u8> {
        let mut contact = [0u32; 256];
        for cell in self.iter(g.width, rows) {
            g.sides(cell).filter(|&s| owner[s] != self.owner).for_each(|s| contact[usize::from(owner[s])] += 1);
        }
        // The first of equals.
        let best = (0..256).rev().max_by_key(|&p| contact[p])?;
        (contact[best] > 0).then_some(best as u8)
    }
}

fn find_root(parent: &mut [u32], mut i: usize) -> usize {
    while parent[i] as usize != i {
        parent[i] = parent[parent[i] as usize];
        i = parent[i] as usize;
    }
    i
}

fn join(parent: &mut [u32], a: usize, b: usize) {
    let (a, b) = (find_root(parent, a), find_root(parent, b));
    parent[a.max(b)] = a.min(b) as u32;
}

/// Gives cells to a neighbour that surrounds them: those of whose eight neighbours at least six belong to one other plate.
pub(crate) fn smooth(g: &Geometry, rows: &[Vec<Run>], owner: &mut [u8]) {
    let mut changes: Vec<(usize, u8)> = Vec::new();
    for (y, row) in rows.iter().enumerate() {
        let (north, south) = (g.row(y as isize - 1), g.row(y as isize + 1));
        for run in row {
            // A cell with so few of its own around it is at an end of a run, or has others to its north and south.
            let (start, end) = (run.start as usize, run.end as usize);
            let alone =
                |x: usize| [north, south].into_iter().flatten().all(|row| owner[row * g.width + x] != run.owner);
            for x in run.range().filter(|&x| x < start + 2 || x + 2 >= end || alone(x)) {
                let cell = y * g.width + x;
                let mut count = [0u8; 256];
                g.ring(cell).for_each(|n| count[usize::from(owner[n])] += 1);
                let other = g.ring(cell).map(|n| owner[n]).find(|&o| o != run.owner && count[usize::from(o)] >= 6);
                changes.extend(other.map(|o| (cell, o)));
            }
        }
    }
    for (cell, o) in changes {
        owner[cell] = o;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::of_rows;
    use eyot_core::{Boundary, Grid, Limits};

    #[test]
    fn parts_are_connected_over_the_rim_and_islands_are_parts() {
        let map = [
            0, 0, 1, 1, 0, //
            1, 1, 1, 1, 1, //
            1, 2, 1, 0, 1, //
            0, 1, 1, 1, 0,
        ];
        let parts = |rim: Boundary| {
            let g = Geometry::new(&Grid::new(5, 4, 1.0, rim, &Limits::default()).unwrap());
            let rows = of_rows(&map, 5);
            let found = find(&g, &rows);
            let two = found.iter().find(|p| p.owner == 2).unwrap();
            assert_eq!(two.neighbour(&g, &rows, &map), Some(1));
            assert_eq!(two.iter(5, &rows).collect::<Vec<_>>(), [11]);
            found.iter().map(|p| (p.owner, p.cells)).collect::<Vec<_>>()
        };
        assert_eq!(parts(Boundary::CLOSED), [(0, 2), (1, 13), (0, 1), (2, 1), (0, 1), (0, 1), (0, 1)]);
        assert_eq!(parts(Boundary::WRAP), [(0, 5), (1, 13), (2, 1), (0, 1)]);
    }
}
