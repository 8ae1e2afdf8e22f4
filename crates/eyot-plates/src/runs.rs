//! Rows as runs of cells with one owner: borders are short, so most of the work is copying.

use crate::geometry::{Geometry, rows_at_once};
use crate::pairs::Pairs;
use rayon::prelude::*;

/// Cells `start..end` of a row that one plate owns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Run {
    pub(crate) start: u32,
    pub(crate) end: u32,
    pub(crate) owner: u8,
}

impl Run {
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// The runs of every row.
pub(crate) fn of_rows(owner: &[u8], width: usize) -> Vec<Vec<Run>> {
    owner.par_chunks(width).with_min_len(rows_at_once(width)).map(of_row).collect()
}

fn of_row(row: &[u8]) -> Vec<Run> {
    let mut runs = Vec::with_capacity(16);
    let mut start = 0;
    while start < row.len() {
        let end = start + equal(&row[start..], row[start]);
        runs.push(Run { start: start as u32, end: end as u32, owner: row[start] });
        start = end;
    }
    runs
}

/// Cells at the beginning that have this value.
pub(crate) fn equal(row: &[u8], value: u8) -> usize {
    let words = row.chunks_exact(16).take_while(|c| c.iter().fold(0, |d, &v| d | (v ^ value)) == 0).count();
    let at = words * 16;
    at + row[at..].iter().take_while(|&&v| v == value).count()
}

/// Length of the border between each pair of plates, cells.
pub(crate) fn borders(g: &Geometry, rows: &[Vec<Run>], plates: usize) -> Pairs {
    let mut borders = Pairs::new(plates);
    let mut touch = |a: u8, b: u8, cells: u32| {
        if a != b {
            *borders.at(a, b) += f64::from(cells);
            *borders.at(b, a) += f64::from(cells);
        }
    };
    for (y, row) in rows.iter().enumerate() {
        row.windows(2).for_each(|w| touch(w[0].owner, w[1].owner, 1));
        if let (Some(first), Some(last), Some(_)) = (row.first(), row.last(), g.column(-1)) {
            touch(first.owner, last.owner, 1);
        }
        let Some(below) = g.row(y as isize + 1).map(|s| &rows[s]) else { continue };
        let (mut i, mut j) = (0, 0);
        while i < row.len() && j < below.len() {
            let (a, b) = (row[i], below[j]);
            touch(a.owner, b.owner, a.end.min(b.end) - a.start.max(b.start));
            i += usize::from(a.end <= b.end);
            j += usize::from(b.end <= a.end);
        }
    }
    borders
}

/// Cells owned by each plate.
pub(crate) fn areas(rows: &[Vec<Run>], plates: usize) -> Vec<u32> {
    let mut areas = vec![0; plates];
    for r in rows.iter().flatten() {
        areas[usize::from(r.owner)] += r.end - r.start;
    }
    areas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_the_row() {
        let row: Vec<u8> = (0..100).map(|i| [3, 3, 3, 1, 1, 7][(i / 9) % 6]).collect();
        let runs = of_row(&row);
        let back: Vec<u8> = runs.iter().flat_map(|r| r.range().map(|_| r.owner)).collect();
        assert_eq!(back, row);
        assert!(runs.windows(2).all(|w| w[0].owner != w[1].owner && w[0].end == w[1].start));
        assert_eq!(areas(&[runs], 8), [0, 36, 0, 54, 0, 0, 0, 10]);
    }
}
