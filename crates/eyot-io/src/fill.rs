//! Filling missing cells from their neighbours, smoothly and in linear time.
//!
//! The field is averaged down over its valid cells, level by level, until no cell is missing; on the way back, missing
//! cells take the interpolated coarse value and are then relaxed towards the mean of their four neighbours (Laplace's
//! equation: no new hills or pits). Plain relaxation alone needs as many sweeps as a hole is wide, squared.

use crate::error::{Error, Result};
use eyot_core::Field;
use std::path::Path;

/// Sweeps at each level; the coarse levels have done the far-reaching work.
const SWEEPS: usize = 24;

/// Fills the cells that `missing` marks (row by row) and returns how many they were, or `None` if no cell is valid.
pub(crate) fn fill(field: &mut Field, missing: &[bool]) -> Option<usize> {
    let count = missing.iter().filter(|&&m| m).count();
    if count == missing.len() {
        return None;
    }
    if count > 0 {
        let mut level =
            Level { width: field.width(), height: field.height(), values: field.to_vec(), missing: missing.to_vec() };
        level.fill();
        for (y, row) in level.values.chunks_exact(level.width).enumerate() {
            field.row_mut(y).copy_from_slice(row);
        }
    }
    Some(count)
}

/// Collects the missing cells of a raster while it is read.
pub(crate) struct Missing {
    size: (usize, usize),
    nodata: Option<f64>,
    marks: Option<Vec<bool>>,
}

impl Missing {
    /// For a raster in which `nodata` marks missing cells.
    pub(crate) fn new(width: usize, height: usize, nodata: Option<f64>) -> Self {
        Self { size: (width, height), nodata, marks: None }
    }

    /// Marks the cell if its number in the file is the nodata value.
    pub(crate) fn look_at(&mut self, x: usize, y: usize, number: f64) {
        if let Some(nodata) = self.nodata
            // Values of `f32` files are often given with digits that name another `f64`.
            && (number == nodata || (number.is_nan() && nodata.is_nan()) || number as f32 == nodata as f32)
        {
            self.mark(x, y);
        }
    }

    /// Marks the cell.
    pub(crate) fn mark(&mut self, x: usize, y: usize) {
        let (width, height) = self.size;
        self.marks.get_or_insert_with(|| vec![false; width * height])[y * width + x] = true;
    }

    /// Fills what was marked and returns the marks.
    pub(crate) fn fill(self, path: &Path, field: &mut Field) -> Result<Option<Vec<bool>>> {
        if let Some(marks) = &self.marks {
            fill(field, marks)
                .ok_or_else(|| Error::format(path, "every cell is marked as missing", "check the nodata value"))?;
        }
        Ok(self.marks)
    }
}

struct Level {
    width: usize,
    height: usize,
    values: Vec<f32>,
    missing: Vec<bool>,
}

impl Level {
    fn fill(&mut self) {
        let holes: Vec<usize> = (0..self.values.len()).filter(|&i| self.missing[i]).collect();
        if holes.is_empty() {
            return;
        }
        let mut coarse = self.coarser();
        coarse.fill();
        for &i in &holes {
            self.values[i] = coarse.interpolated(i % self.width, i / self.width);
        }
        for _ in 0..SWEEPS {
            for &i in &holes {
                self.values[i] = self.neighbour_mean(i);
            }
        }
    }

    /// Half the size; a cell is the mean of the valid ones of its four, and missing if there is none.
    fn coarser(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut out = Self { width, height, values: vec![0.0; width * height], missing: vec![true; width * height] };
        for y in 0..height {
            for x in 0..width {
                let (mut sum, mut n) = (0.0f64, 0u32);
                for j in 2 * y..(2 * y + 2).min(self.height) {
                    for i in 2 * x..(2 * x + 2).min(self.width) {
                        if !self.missing[j * self.width + i] {
                            sum += f64::from(self.values[j * self.width + i]);
                            n += 1;
                        }
                    }
                }
                if n > 0 {
                    out.values[y * width + x] = (sum / f64::from(n)) as f32;
                    out.missing[y * width + x] = false;
                }
            }
        }
        out
    }

    /// Bilinear value at the middle of cell (x, y) of the next finer level.
    fn interpolated(&self, x: usize, y: usize) -> f32 {
        // Fine cell x lies a quarter of a coarse cell left or right of the middle of coarse cell x / 2.
        let near = |i: usize, n: usize| {
            let other = if i.is_multiple_of(2) { (i / 2).saturating_sub(1) } else { (i / 2 + 1).min(n - 1) };
            (i / 2, other)
        };
        let ((x0, x1), (y0, y1)) = (near(x, self.width), near(y, self.height));
        let at = |x: usize, y: usize| self.values[y * self.width + x];
        let row = |y: usize| 0.75 * at(x0, y) + 0.25 * at(x1, y);
        0.75 * row(y0) + 0.25 * row(y1)
    }

    fn neighbour_mean(&self, i: usize) -> f32 {
        let (x, y) = (i % self.width, i / self.width);
        let (mut sum, mut n) = (0.0, 0.0);
        let mut add = |present: bool, j: usize| {
            if present {
                sum += self.values[j];
                n += 1.0;
            }
        };
        add(x > 0, i.wrapping_sub(1));
        add(x + 1 < self.width, i + 1);
        add(y > 0, i.wrapping_sub(self.width));
        add(y + 1 < self.height, i + self.width);
        if n > 0.0 { sum / n } else { self.values[i] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_in_a_plane_becomes_plane_again() {
        let (w, h) = (61, 47);
        let plane = Field::from_fn(w, h, |x, y| 3.0 * x as f32 - 2.0 * y as f32);
        let missing: Vec<bool> =
            (0..w * h).map(|i| (15..40).contains(&(i % w)) && (10..30).contains(&(i / w))).collect();
        let mut holed = Field::from_fn(w, h, |x, y| if missing[y * w + x] { -9999.0 } else { plane.get(x, y) });
        assert_eq!(fill(&mut holed, &missing), Some(500));
        // The plane's relief over the hole is about 120.
        let worst = holed.iter().zip(plane.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 3.0, "{worst}");
    }

    #[test]
    fn valid_cells_never_change_and_filled_ones_stay_within_the_range() {
        let (w, h) = (33, 9);
        let valid = |x: usize, y: usize| (x * 31 + y * 17).is_multiple_of(11);
        let mut f = Field::from_fn(w, h, |x, y| if valid(x, y) { (x * y % 7) as f32 } else { f32::NAN });
        let before = f.clone();
        let missing: Vec<bool> = (0..w * h).map(|i| !valid(i % w, i / w)).collect();
        fill(&mut f, &missing);
        for y in 0..h {
            for x in 0..w {
                if valid(x, y) {
                    assert_eq!(f.get(x, y), before.get(x, y));
                } else {
                    assert!((0.0..=6.0).contains(&f.get(x, y)));
                }
            }
        }
    }

    #[test]
    fn single_rows_single_valid_cells_and_none() {
        let mut row = Field::from_slice(5, 1, &[1.0, 0.0, 0.0, 0.0, 5.0]).unwrap();
        assert_eq!(fill(&mut row, &[false, true, true, true, false]), Some(3));
        for (found, expected) in row.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0]) {
            assert!((found - expected).abs() < 0.05, "{found} {expected}");
        }
        let mut one = Field::from_fn(4, 4, |x, y| if (x, y) == (2, 1) { 7.0 } else { f32::NAN });
        let missing: Vec<bool> = (0..16).map(|i| i != 6).collect();
        assert_eq!(fill(&mut one, &missing), Some(15));
        assert!(one.iter().all(|v| v == 7.0));
        assert_eq!(fill(&mut Field::new(2, 2, 0.0), &[true; 4]), None);
    }
}
