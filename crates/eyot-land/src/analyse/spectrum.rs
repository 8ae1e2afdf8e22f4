//! Spectral exponent: how the power of the height falls with frequency.
//!
//! # Equations
//! 1. The least-squares plane is taken off, `r = z - (a + b x + c y)`.
//! 2. A Hann window on both axes, `w(i) = (1 - cos(2 pi i / (n - 1))) / 2`, suppresses the jump at the rim.
//! 3. `P(kx, ky) = |DFT(r w)|^2`, the 2-D periodogram, with `k = hypot(kx, ky)` in cycles per metre.
//! 4. `P` is averaged in 29 rings of `k` whose radii grow geometrically from `1 / L` to `1 / (2 d)`, where `L` is
//!    the shorter extent and `d` the larger cell side.
//! 5. `-beta` is the slope of the least-squares line through `log P` over `log k` of the rings whose mean `log k` lies
//!    within `4 / L ..= 1 / (6 d)`: below, window and plane have bent the spectrum, above, interpolation and aliasing have.
//!
//! # Reading
//! This is the exponent of the 2-D periodogram; the one of a profile is smaller by about one. `H = (beta - 2) / 2` for a
//! self-affine surface. Mountains have 3.3..4.2, and so has noise: beta alone proves nothing about realism.
//!
//! # Source
//! Perron, Kirchner & Dietrich (2008), Spectral signatures of characteristic spatial scales and nonfractal structure in
//! landscapes, JGR Earth Surface 113, F04003 (detrending, window, binning).

use super::check_fits;
use super::moments::line_slope;
use eyot_core::{Field, Grid, Result};
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};

/// Rings between the lowest and the highest frequency.
const RINGS: usize = 29;

/// Bytes that [`spectral_beta`] needs for a grid of `cells`.
pub(super) const fn spectrum_bytes(cells: usize) -> u128 {
    2 * 16 * cells as u128
}

/// Spectral exponent beta of the radially averaged 2-D periodogram, positive where power falls with frequency.
///
/// `None` if fewer than three rings lie within the fitted band (a grid of fewer than about 35 cells a side) or have any
/// power (level or plane ground).
///
/// # Errors
/// If `height` has another size than `grid`.
pub fn spectral_beta(height: &Field, grid: &Grid) -> Result<Option<f64>> {
    check_fits(height, grid)?;
    let (w, h) = (grid.width, grid.height);
    let (extent_x_m, extent_y_m) = grid.extent_m();
    let (extent_m, cell_m) = (extent_x_m.min(extent_y_m), grid.cell_x_m.max(grid.cell_y_m));
    let (low, high) = (4.0 / extent_m, 1.0 / (6.0 * cell_m));
    if w.min(h) < 3 || low >= high {
        return Ok(None);
    }
    let (mut spectrum, roughness) = windowed_residual(height);
    if roughness == 0.0 {
        return Ok(None);
    }
    transform_rows(&mut spectrum, w);
    let mut spectrum = transpose(&spectrum, w, h);
    transform_rows(&mut spectrum, h);

    // Rings of equal width in log k; ring r begins at bottom + r width.
    let bottom = (1.0 / extent_m).ln();
    let width = ((1.0 / (2.0 * cell_m)).ln() - bottom) / RINGS as f64;
    let (mut power, mut log_k, mut count) = ([0.0; RINGS], [0.0; RINGS], [0_u64; RINGS]);
    // The heights are real: rows beyond half the frequencies repeat the others.
    for (x, column) in spectrum.chunks_exact(h).enumerate().take(w / 2 + 1) {
        let kx = x as f64 / extent_x_m;
        // Columns that stand for their mirror image as well.
        let twins = if x == 0 || 2 * x == w { 1 } else { 2 };
        for (y, c) in column.iter().enumerate() {
            let ky = y.min(h - y) as f64 / extent_y_m;
            let k2 = kx * kx + ky * ky;
            let ln_k = 0.5 * k2.ln();
            let ring = ((ln_k - bottom) / width).floor();
            if (0.0..RINGS as f64).contains(&ring) {
                power[ring as usize] += f64::from(twins) * c.norm_sqr();
                log_k[ring as usize] += f64::from(twins) * ln_k;
                count[ring as usize] += twins as u64;
            }
        }
    }
    // Narrow rings hold few frequencies, and these not evenly: their own mean is the place of a ring.
    let points: Vec<(f64, f64)> = (0..RINGS)
        .filter(|&r| power[r] > 0.0)
        .map(|r| (log_k[r] / count[r] as f64, (power[r] / count[r] as f64).ln()))
        .filter(|(k, _)| (low.ln()..=high.ln()).contains(k))
        .collect();
    Ok(if points.len() < 3 { None } else { line_slope(&points).map(|s| -s) })
}

/// Steps 1 and 2: the height without its plane, under the window, and the largest residual (0 for plane ground).
fn windowed_residual(height: &Field) -> (Vec<Complex<f64>>, f64) {
    let (w, h) = (height.width(), height.height());
    let (cx, cy) = ((w - 1) as f64 / 2.0, (h - 1) as f64 / 2.0);
    // With coordinates measured from the middle the three normal equations separate.
    let (mut sum, mut sum_x, mut sum_y, mut largest) = (0.0, 0.0, 0.0, 0.0_f64);
    for (y, row) in height.rows().enumerate() {
        let (mut row_sum, mut row_x) = (0.0, 0.0);
        for (x, &z) in row.iter().enumerate() {
            row_sum += f64::from(z);
            row_x += f64::from(z) * (x as f64 - cx);
            largest = largest.max(f64::from(z).abs());
        }
        sum += row_sum;
        sum_x += row_x;
        sum_y += row_sum * (y as f64 - cy);
    }
    let square = |n: usize| (n * n - 1) as f64 / 12.0;
    let cells = (w * h) as f64;
    let (a, b, c) = (sum / cells, sum_x / (cells * square(w)), sum_y / (cells * square(h)));
    let hann = |n: usize| -> Vec<f64> {
        (0..n).map(|i| 0.5 - 0.5 * (std::f64::consts::TAU * i as f64 / (n - 1) as f64).cos()).collect()
    };
    let (wx, wy) = (hann(w), hann(h));
    let mut roughness = 0.0_f64;
    let mut out = Vec::with_capacity(w * h);
    for (y, row) in height.rows().enumerate() {
        let line = a + c * (y as f64 - cy);
        for (x, &z) in row.iter().enumerate() {
            let r = f64::from(z) - (line + b * (x as f64 - cx));
            roughness = roughness.max(r.abs());
            out.push(Complex::new(r * wx[x] * wy[y], 0.0));
        }
    }
    // What is left of a plane is the rounding of its f32 heights.
    (out, if roughness <= 2.0 * largest * f64::from(f32::EPSILON) { 0.0 } else { roughness })
}

fn transform_rows(data: &mut [Complex<f64>], width: usize) {
    let fft = FftPlanner::new().plan_fft_forward(width);
    data.par_chunks_mut(width * 16).for_each(|rows| fft.process(rows));
}

/// `data` of `w` columns and `h` rows with columns and rows exchanged.
fn transpose(data: &[Complex<f64>], w: usize, h: usize) -> Vec<Complex<f64>> {
    let mut out = vec![Complex::new(0.0, 0.0); data.len()];
    // Bands of rows that together fit in the cache with their targets.
    out.par_chunks_mut(h * 8).enumerate().for_each(|(band, rows)| {
        let columns = rows.len() / h;
        for y in 0..h {
            let source = &data[y * w + band * 8..][..columns];
            source.iter().enumerate().for_each(|(x, &c)| rows[x * h + y] = c);
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    #[test]
    fn the_plane_is_taken_off() {
        let grid = Grid::new(64, 48, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let plane = Field::from_fn(64, 48, |x, y| 5.0 + 3.0 * x as f32 - 2.0 * y as f32);
        assert_eq!(spectral_beta(&plane, &grid).unwrap(), None);
        assert_eq!(spectral_beta(&Field::new(64, 48, 0.1), &grid).unwrap(), None);
        let mut s = 3_u64;
        let rough = Field::from_fn(64, 48, |_, _| {
            s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (s >> 40) as f32
        });
        let tilted = Field::from_fn(64, 48, |x, y| rough.get(x, y) + 4096.0 * plane.get(x, y));
        let (a, b) = (spectral_beta(&rough, &grid).unwrap().unwrap(), spectral_beta(&tilted, &grid).unwrap().unwrap());
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }

    #[test]
    fn small_grids_have_none() {
        for (w, h) in [(1, 1), (1, 50), (2, 2), (20, 20)] {
            let grid = Grid::new(w, h, 1.0, Boundary::CLOSED, &Limits::default()).unwrap();
            assert_eq!(spectral_beta(&Field::from_fn(w, h, |x, y| ((x * y) % 3) as f32), &grid).unwrap(), None);
        }
    }
}
