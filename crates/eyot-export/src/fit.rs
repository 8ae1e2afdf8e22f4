//! The same land on another number of vertices, for programs that accept only some.
//!
//! Engines draw heights at vertices, and a landscape of n vertices is n - 1 quads wide; the middles of Eyot's cells become
//! these vertices. So the first and the last vertex lie exactly on the first and the last cell, whatever the sizes, and
//! the extent is that between the middles of the border cells.

use crate::error::ExportError;
use eyot_core::{Field, Georeference, Grid, Limits, World};

/// Where the samples of an axis lie between the first (0) and the last cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Samples {
    /// On so many vertices, the first and the last on the border cells.
    Vertices(usize),
    /// In the middles of so many quads.
    Quads(usize),
}

impl Samples {
    fn count(self) -> usize {
        match self {
            Self::Vertices(n) | Self::Quads(n) => n,
        }
    }

    /// Distance of samples and position of the first, in cells.
    fn step(self, cells: usize) -> (f64, f64) {
        let span = (cells - 1) as f64;
        match self {
            Self::Vertices(n) => (span / (n - 1) as f64, 0.0),
            Self::Quads(n) => (span / n as f64, 0.5 * span / n as f64),
        }
    }
}

/// A world with the named layers at other places. At least 2 x 2 cells and as many samples are needed.
///
/// Each sample is a mean under Catmull and Rom's cubic, widened where samples are farther apart than cells; at a cell of
/// the same distance that is the cell's own value, bit for bit. Values stay within the range of their layer.
pub(crate) fn fit(
    world: &World,
    layers: &[&str],
    samples: [Samples; 2],
    limits: &Limits,
) -> Result<World, ExportError> {
    let g = &world.grid;
    let [(sx, x0), (sy, y0)] = [samples[0].step(g.width), samples[1].step(g.height)];
    let (w, h) = (samples[0].count(), samples[1].count());
    let grid = Grid { width: w, height: h, cell_x_m: g.cell_x_m * sx, cell_y_m: g.cell_y_m * sy, rim: g.rim };
    let grid = grid.checked(limits).map_err(ExportError::file)?;
    let bytes = (w as u128 * (h as u128 * layers.len() as u128 + g.height as u128)) * 4;
    limits.check_bytes("the resampled world", bytes).map_err(ExportError::file)?;
    let mut out = World::new(grid, world.seed);
    out.sea_level_m = world.sea_level_m;
    out.step = world.step;
    out.georeference = world.georeference.as_ref().map(|g| moved(g, [(sx, x0), (sy, y0)]));
    let columns = axis(g.width, w, (sx, x0));
    let rows = axis(g.height, h, (sy, y0));
    for name in layers {
        let Some(layer) = world.layers().iter().find(|l| l.spec.name == *name) else { continue };
        let field = resample(&layer.field, &columns, &rows, layer.spec.range);
        out.put(&layer.spec, field).map_err(ExportError::file)?;
    }
    Ok(out)
}

/// First cell and weights of each sample.
fn axis(cells: usize, count: usize, (step, first): (f64, f64)) -> Vec<(usize, Vec<f64>)> {
    let scale = step.max(1.0);
    (0..count)
        .map(|k| {
            // The last vertex falls on the last cell in spite of rounding.
            let at = (first + k as f64 * step).min((cells - 1) as f64);
            let low = (at - 2.0 * scale).ceil() as isize;
            let high = (at + 2.0 * scale).floor() as isize;
            let inside = |i: isize| i.clamp(0, cells as isize - 1) as usize;
            let start = inside(low);
            let mut weights = vec![0.0; inside(high) - start + 1];
            for i in low..=high {
                // Beyond the border lies the border's value.
                weights[inside(i) - start] += cubic((i as f64 - at) / scale);
            }
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= sum);
            (start, weights)
        })
        .collect()
}

/// Catmull and Rom's cubic kernel.
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        1.0 + x * x * (1.5 * x - 2.5)
    } else if x < 2.0 {
        2.0 + x * (-4.0 + x * (2.5 - 0.5 * x))
    } else {
        0.0
    }
}

fn resample(
    field: &Field,
    columns: &[(usize, Vec<f64>)],
    rows: &[(usize, Vec<f64>)],
    (low, high): (f32, f32),
) -> Field {
    let sum = |weights: &[f64], value: &dyn Fn(usize) -> f32| -> f64 {
        weights.iter().enumerate().map(|(i, w)| w * f64::from(value(i))).sum()
    };
    let narrow = Field::from_fn(columns.len(), field.height(), |x, y| {
        let (start, weights) = &columns[x];
        let row = field.row(y);
        sum(weights, &|i| row[start + i]) as f32
    });
    Field::from_fn(columns.len(), rows.len(), |x, y| {
        let (start, weights) = &rows[y];
        (sum(weights, &|i| narrow.get(x, start + i)) as f32).clamp(low, high)
    })
}

/// The georeference of the cells around the samples.
fn moved(g: &Georeference, [(sx, x0), (sy, y0)]: [(f64, f64); 2]) -> Georeference {
    let t = g.transform;
    // Corner of the first new cell, in old cells: half a new cell before the first sample.
    let (cx, cy) = (0.5 + x0 - 0.5 * sx, 0.5 + y0 - 0.5 * sy);
    let transform =
        [t[0] + cx * t[1] + cy * t[2], t[1] * sx, t[2] * sy, t[3] + cx * t[4] + cy * t[5], t[4] * sx, t[5] * sy];
    Georeference { transform, ..g.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::Boundary;
    use eyot_core::layer::known;

    fn world(w: usize, h: usize, f: impl FnMut(usize, usize) -> f32) -> World {
        let limits = Limits::default();
        let mut world = World::new(Grid::new(w, h, 10.0, Boundary::CLOSED, &limits).unwrap(), 1);
        world.georeference =
            Some(Georeference { transform: [1000.0, 10.0, 0.0, 5000.0, 0.0, -10.0], ..Georeference::default() });
        world.put(&known::HEIGHT, Field::from_fn(w, h, f)).unwrap();
        world
    }

    fn fitted(world: &World, samples: [Samples; 2]) -> World {
        fit(world, &["height"], samples, &Limits::default()).unwrap()
    }

    #[test]
    fn the_same_size_keeps_every_bit() {
        let a = world(37, 21, |x, y| 0.1 + (x * 31 % 17) as f32 / (y + 1) as f32);
        let b = fitted(&a, [Samples::Vertices(37), Samples::Vertices(21)]);
        assert_eq!(a.get("height"), b.get("height"));
        assert_eq!((a.grid, &a.georeference), (b.grid, &b.georeference));
    }

    #[test]
    fn planes_stay_planes_and_borders_stay_on_borders() {
        let a = world(40, 30, |x, y| 3.0 * x as f32 - 2.0 * y as f32);
        for n in [9, 33, 65, 129] {
            let b = fitted(&a, [Samples::Vertices(n), Samples::Vertices(n)]);
            let f = b.get("height").unwrap();
            let (sx, sy) = (39.0 / (n - 1) as f32, 29.0 / (n - 1) as f32);
            // Near the border the repeated border value bends the plane.
            let margin = (2.0 / sx.min(sy)).ceil().max(3.0) as usize;
            // A kernel that was widened by no whole number does not weigh both sides quite alike: a hundredth of a cell.
            let tolerance = if n < 40 { 0.05 } else { 1e-3 };
            for y in margin..n - margin {
                for x in margin..n - margin {
                    let exact = 3.0 * x as f32 * sx - 2.0 * y as f32 * sy;
                    assert!((f.get(x, y) - exact).abs() < tolerance, "{n} {x} {y}: {} {exact}", f.get(x, y));
                }
            }
            let grid = &b.grid;
            assert!((grid.cell_x_m * (n - 1) as f64 - 390.0).abs() < 1e-9);
            // The middle of the first cell stays where it was.
            let t = b.georeference.unwrap().transform;
            assert!((t[0] + 0.5 * t[1] - 1005.0).abs() < 1e-9 && (t[3] + 0.5 * t[5] - 4995.0).abs() < 1e-9);
        }
        let b = fitted(&a, [Samples::Vertices(79), Samples::Vertices(59)]);
        let (a, b) = (a.get("height").unwrap(), b.get("height").unwrap());
        // Every second vertex lies on a cell.
        assert!((0..30).all(|y| (0..40).all(|x| a.get(x, y) == b.get(2 * x, 2 * y))));
    }

    #[test]
    fn quads_lie_between_their_vertices() {
        let a = world(33, 33, |x, _| x as f32);
        let b = fitted(&a, [Samples::Quads(32), Samples::Quads(32)]);
        let f = b.get("height").unwrap();
        assert!((2..30).all(|x| (f.get(x, 9) - (x as f32 + 0.5)).abs() < 1e-5));
    }

    #[test]
    fn coarser_samples_keep_the_mean() {
        let a = world(256, 256, |x, y| ((x * 7919 + y * 104_729) % 101) as f32);
        let b = fitted(&a, [Samples::Vertices(33), Samples::Vertices(33)]);
        let mean = |w: &World| w.get("height").unwrap().sum() / w.grid.cells() as f64;
        // Averaged, not picked: the spread of 101 values, 29, falls to a few.
        let f = b.get("height").unwrap();
        let spread = (f.iter().map(|v| (f64::from(v) - mean(&b)).powi(2)).sum::<f64>() / 1089.0).sqrt();
        assert!((mean(&a) - mean(&b)).abs() < 1.0 && spread < 6.0, "{} {} {spread}", mean(&a), mean(&b));
    }
}
