//! Fields that are there already, as numbers on a lattice: scans, simulations, samples of something slow.

use super::field::ScalarField;
use super::lattice::Lattice;
use crate::error::{Error, Result};
use crate::primitive::Point;
use eyot_core::Limits;
use eyot_core::lanes::WIDTH;

/// Values at the points of a lattice, in between trilinear, beyond as at the nearest point.
///
/// ```
/// use eyot_core::Limits;
/// use eyot_mesh::{MeshingOptions, Volume, mesh_field};
///
/// // A ball of a radius of 6 mm, sampled every millimetre.
/// let n = 16;
/// let at = |i: usize| i as f32 - 7.5;
/// let mut values = Vec::new();
/// for (z, y, x) in (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| (z, y, x)))) {
///     values.push(6.0 - (at(x) * at(x) + at(y) * at(y) + at(z) * at(z)).sqrt());
/// }
/// let limits = Limits::default();
/// let scan = Volume::new([0; 3], [n; 3], 0.001, values)?;
/// let body = mesh_field(&scan, &scan.lattice(&limits)?, &MeshingOptions::default(), &limits)?;
/// assert!(body.topology().is_closed_manifold());
/// # Ok::<(), eyot_mesh::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Volume {
    first: [i32; 3],
    size: [usize; 3],
    voxel: f32,
    per_voxel: f32,
    values: Vec<f32>,
}

impl Volume {
    /// `size` values on x, y and z, along x first; the first one is at `first` voxels from the origin. The body is where they
    /// are above 0.
    ///
    /// # Errors
    /// If there are not as many values as points, if an axis has fewer than 2, or if the lattice is none ([`Lattice::over`]).
    pub fn new(first: [i32; 3], size: [usize; 3], voxel: f32, values: Vec<f32>) -> Result<Self> {
        let points: u128 = size.iter().map(|&n| n as u128).product();
        if points != values.len() as u128 || size.iter().any(|n| !(2..=1 << 22).contains(n)) {
            return Err(Error::BadVolume { size, values: values.len() });
        }
        let volume = Self { first, size, voxel, per_voxel: 1.0 / voxel, values };
        // What is too large in memory is here already.
        volume.lattice(&Limits { max_cells: u64::MAX, ..Limits::default() })?;
        Ok(volume)
    }

    /// The lattice of its points. A body that goes on beyond ends flat at the outermost ones.
    ///
    /// # Errors
    /// As [`Lattice::over`].
    pub fn lattice(&self, limits: &Limits) -> Result<Lattice> {
        let at = |i: usize, n: usize| (i64::from(self.first[i]) + n as i64) as f32 * self.voxel;
        let axes = [0, 1, 2];
        Lattice::over(axes.map(|i| at(i, 0)), axes.map(|i| at(i, self.size[i] - 1)), self.voxel, limits)
    }

    /// Its values, along x first.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The point before a place, and how far it is on the way to the next one.
    #[inline]
    fn cell(&self, axis: usize, v: f32) -> (usize, f32) {
        let points = self.size[axis];
        let at = (v * self.per_voxel - self.first[axis] as f32).clamp(0.0, (points - 1) as f32);
        let cell = (at as usize).min(points - 2);
        (cell, at - cell as f32)
    }

    /// The eight values around a place, and where in between it lies.
    #[inline]
    fn around(&self, p: Point) -> ([f32; 8], Point) {
        let [(x, u), (y, v), (z, w)] = [self.cell(0, p[0]), self.cell(1, p[1]), self.cell(2, p[2])];
        let (row, plane) = (self.size[0], self.size[0] * self.size[1]);
        let near = &self.values[(z * self.size[1] + y) * row + x..][..plane + row + 2];
        let far = plane + row;
        let values =
            [near[0], near[1], near[row], near[row + 1], near[plane], near[plane + 1], near[far], near[far + 1]];
        (values, [u, v, w])
    }

    /// Numbers of lattice lines, if these are such, one after the other.
    fn lines(&self, axis: usize, lines: &[f32]) -> Option<i64> {
        let first = (lines[0] / self.voxel).round() as i32;
        let are = lines.iter().zip(first..).all(|(&v, i)| v == i as f32 * self.voxel);
        are.then(|| i64::from(first) - i64::from(self.first[axis]))
    }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

impl ScalarField for Volume {
    fn value(&self, p: Point) -> f32 {
        self.slope(p, self.voxel).0
    }

    #[inline]
    fn slope(&self, p: Point, _voxel: f32) -> (f32, Point) {
        let (v, [x, y, z]) = self.around(p);
        let along = [mix(v[0], v[1], x), mix(v[2], v[3], x), mix(v[4], v[5], x), mix(v[6], v[7], x)];
        let across = [mix(along[0], along[1], y), mix(along[2], along[3], y)];
        let by_x = mix(mix(v[1] - v[0], v[3] - v[2], y), mix(v[5] - v[4], v[7] - v[6], y), z);
        let by_y = mix(along[1] - along[0], along[3] - along[2], z);
        let by_z = across[1] - across[0];
        (mix(across[0], across[1], z), [by_x * self.per_voxel, by_y * self.per_voxel, by_z * self.per_voxel])
    }

    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        let lines = [self.lines(0, xs), self.lines(1, ys), self.lines(2, zs)];
        let [Some(x), Some(y), Some(z)] = lines else {
            for (row, values) in values.chunks_exact_mut(xs.len()).enumerate() {
                self.row(xs, ys[row % ys.len()], zs[row / ys.len()], values);
            }
            return;
        };
        let within = |axis: usize, i: i64| i.clamp(0, self.size[axis] as i64 - 1) as usize;
        let is_whole = x >= 0 && x as usize + xs.len() <= self.size[0];
        for (row, values) in values.chunks_exact_mut(xs.len()).enumerate() {
            let (y, z) = (within(1, y + (row % ys.len()) as i64), within(2, z + (row / ys.len()) as i64));
            let row = &self.values[(z * self.size[1] + y) * self.size[0]..][..self.size[0]];
            if let (true, Some(values)) = (is_whole, values.first_chunk_mut::<WIDTH>().filter(|_| xs.len() == WIDTH)) {
                // A known length is copied without a call.
                values.copy_from_slice(&row[x as usize..x as usize + WIDTH]);
            } else if is_whole {
                values.copy_from_slice(&row[x as usize..x as usize + xs.len()]);
            } else {
                values.iter_mut().enumerate().for_each(|(i, v)| *v = row[within(0, x + i as i64)]);
            }
        }
    }
}
