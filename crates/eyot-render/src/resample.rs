//! From cells to the pixels of a flat picture: one to one, several pixels a cell, or means over several cells.

use crate::ground::Ground;
use crate::surface::b_spline;
use rayon::prelude::*;

/// How cells become pixels.
#[derive(Clone, Copy)]
pub(crate) struct Raster {
    cells: [usize; 2],
    /// Pixels a cell, or 1.
    up: usize,
    /// Cells a pixel, or 1.
    down: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Raster {
    /// Keeps the longer side within `min..=max` where whole factors allow it.
    pub(crate) fn new(width: usize, height: usize, min: usize, max: usize) -> Self {
        let longer = width.max(height);
        let down = longer.div_ceil(max.max(1));
        let up = if down == 1 { (min.min(max) / longer).clamp(1, 64) } else { 1 };
        let size = |n: usize| n.div_ceil(down) * up;
        Self { cells: [width, height], up, down, width: size(width), height: size(height) }
    }

    /// At least `n` pixels, and not many more, along the longer side: the next whole factor.
    pub(crate) fn around(width: usize, height: usize, n: usize) -> Self {
        let (longer, n) = (width.max(height), n.clamp(1, 16384));
        if n >= longer {
            let size = longer * n.div_ceil(longer);
            return Self::new(width, height, size, size);
        }
        Self::new(width, height, 1, longer.div_ceil(longer / n))
    }

    /// Size of a pixel, m.
    pub(crate) fn pixel_m(&self, g: &Ground) -> [f32; 2] {
        g.cell.map(|c| c * self.down as f32 / self.up as f32)
    }

    /// A smooth raster of `values`.
    pub(crate) fn map(&self, values: &[f32]) -> Vec<f32> {
        match (self.up, self.down) {
            (1, 1) => values.to_vec(),
            (1, _) => self.means(values),
            _ => self.spline(values),
        }
    }

    /// A raster that shows every cell as it is.
    pub(crate) fn cells(&self, values: &[f32]) -> Vec<f32> {
        if self.down > 1 {
            return self.means(values);
        }
        (0..self.width * self.height)
            .map(|i| values[(i / self.width / self.up) * self.cells[0] + i % self.width / self.up])
            .collect()
    }

    /// Means over squares of cells; cells that are not finite do not count.
    fn means(&self, values: &[f32]) -> Vec<f32> {
        let ([w, h], k) = (self.cells, self.down);
        let mut out = vec![0.0; self.width * self.height];
        out.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| {
            for (x, o) in row.iter_mut().enumerate() {
                let (mut sum, mut n) = (0.0f64, 0u32);
                for cy in y * k..((y + 1) * k).min(h) {
                    for v in &values[cy * w + x * k..cy * w + ((x + 1) * k).min(w)] {
                        if v.is_finite() {
                            (sum, n) = (sum + f64::from(*v), n + 1);
                        }
                    }
                }
                *o = if n > 0 { (sum / f64::from(n)) as f32 } else { f32::NAN };
            }
        });
        out
    }

    fn spline(&self, values: &[f32]) -> Vec<f32> {
        let ([w, h], k) = (self.cells, self.up);
        let at = |i: isize, n: usize| i.clamp(0, n as isize - 1) as usize;
        // Pixel centres lie at fractions of a cell from its centre.
        let place = |p: usize| {
            let c = (p as f32 + 0.5) / k as f32 - 0.5;
            (c.floor() as isize, b_spline(c - c.floor()))
        };
        let mut across = vec![0.0; self.width * h];
        across.par_chunks_mut(self.width).zip(values.par_chunks(w)).for_each(|(out, row)| {
            for (x, o) in out.iter_mut().enumerate() {
                let (c, k) = place(x);
                *o = (0..4).map(|j| k[j] * row[at(c + j as isize - 1, w)]).sum();
            }
        });
        let mut out = vec![0.0; self.width * self.height];
        out.par_chunks_mut(self.width).enumerate().for_each(|(y, line)| {
            let (c, k) = place(y);
            for (x, o) in line.iter_mut().enumerate() {
                *o = (0..4).map(|j| k[j] * across[at(c + j as isize - 1, h) * self.width + x]).sum();
            }
        });
        out
    }
}
