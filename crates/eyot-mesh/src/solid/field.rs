//! What can be meshed: a number at every point of space, above 0 inside the body.

use crate::primitive::Point;

/// A scalar field. Where its value is above 0 is the body; where it is 0 is the body's surface.
///
/// A field is a pure function: asked twice, it gives the same bits.
///
/// ```
/// use eyot_core::Limits;
/// use eyot_mesh::{Lattice, MeshingOptions, Point, ScalarField, mesh_field};
///
/// struct Gyroid;
///
/// impl ScalarField for Gyroid {
///     fn value(&self, [x, y, z]: Point) -> f32 {
///         x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos() + 0.4
///     }
/// }
///
/// let lattice = Lattice::over([-6.0; 3], [6.0; 3], 0.3, &Limits::default())?;
/// let body = mesh_field(&Gyroid, &lattice, &MeshingOptions::default(), &Limits::default())?;
/// assert!(body.topology().is_closed_manifold());
/// # Ok::<(), eyot_mesh::Error>(())
/// ```
pub trait ScalarField: Sync {
    /// Value at a point.
    fn value(&self, p: Point) -> f32;

    /// Value and gradient at a point. Without an own implementation these are central differences over a twentieth of
    /// `voxel`, the length of the lattice's edges.
    fn slope(&self, p: Point, voxel: f32) -> (f32, Point) {
        let step = 0.05 * voxel;
        let gradient = std::array::from_fn(|axis| {
            let mut ends = [p; 2];
            ends[0][axis] -= step;
            ends[1][axis] += step;
            (self.value(ends[1]) - self.value(ends[0])) / (ends[1][axis] - ends[0][axis])
        });
        (self.value(p), gradient)
    }

    /// Values and gradients at many points, as [`ScalarField::slope`] has them.
    fn slopes(&self, points: &[Point], voxel: f32, slopes: &mut [(f32, Point)]) {
        slopes.iter_mut().zip(points).for_each(|(s, &p)| *s = self.slope(p, voxel));
    }

    /// Values at points of a row along x. `xs` are their x, `values` what comes out; y and z are those of the row.
    fn row(&self, xs: &[f32], y: f32, z: f32, values: &mut [f32]) {
        values.iter_mut().zip(xs).for_each(|(v, &x)| *v = self.value([x, y, z]));
    }

    /// Values at all points with an x, a y and a z of these, rows along x, then planes of rows along y. No axis is empty.
    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        for (row, values) in values.chunks_exact_mut(xs.len()).enumerate() {
            self.row(xs, ys[row % ys.len()], zs[row / ys.len()], values);
        }
    }

    /// What of the field lies within a box. Meshing asks each block of the lattice once and then only the answer.
    fn within(&self, _low: Point, _high: Point) -> Within<'_> {
        Within::Whole
    }

    /// A number that is the same as long as all values are the same; [`Remesher`](super::Remesher) keeps blocks whose part
    /// has the stamp that it had before. Without one it always meshes them again.
    fn stamp(&self) -> Option<u64> {
        None
    }
}

/// What of a field lies within a box.
pub enum Within<'a> {
    /// All values are 0 or less.
    Nothing,
    /// No simpler field is known.
    Whole,
    /// A field with the same values in the box, bit by bit.
    Part(Box<dyn ScalarField + Send + 'a>),
}

/// A field cut off by a box: inside where both are. What would leave the lattice is closed by the box's faces.
pub(crate) struct Boxed<'a> {
    pub(crate) field: &'a dyn ScalarField,
    pub(crate) low: Point,
    pub(crate) high: Point,
    /// What the distance to the box is multiplied by, 1/m.
    pub(crate) steepness: f32,
}

impl Boxed<'_> {
    /// Distance to the nearest face, positive inside, times the steepness; axis and direction of that face.
    fn depth(&self, p: Point) -> (f32, usize, f32) {
        let mut nearest = (f32::INFINITY, 0, 0.0);
        for axis in 0..3 {
            for (distance, inwards) in [(p[axis] - self.low[axis], 1.0), (self.high[axis] - p[axis], -1.0)] {
                if distance < nearest.0 {
                    nearest = (distance, axis, inwards);
                }
            }
        }
        (nearest.0 * self.steepness, nearest.1, nearest.2)
    }

    /// Takes the nearest face where that cuts the field off.
    fn limit(&self, p: Point, slope: &mut (f32, Point)) {
        let (depth, axis, inwards) = self.depth(p);
        if slope.0 > depth {
            let mut normal = [0.0; 3];
            normal[axis] = inwards * self.steepness;
            *slope = (depth, normal);
        }
    }
}

impl ScalarField for Boxed<'_> {
    fn value(&self, p: Point) -> f32 {
        smaller(self.field.value(p), self.depth(p).0)
    }

    fn slope(&self, p: Point, voxel: f32) -> (f32, Point) {
        let mut slope = self.field.slope(p, voxel);
        self.limit(p, &mut slope);
        slope
    }

    fn slopes(&self, points: &[Point], voxel: f32, slopes: &mut [(f32, Point)]) {
        self.field.slopes(points, voxel, slopes);
        for (slope, &p) in slopes.iter_mut().zip(points) {
            self.limit(p, slope);
        }
    }

    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        self.field.fill([xs, ys, zs], values);
        let from_sides = |axis: usize, v: f32| (v - self.low[axis]).min(self.high[axis] - v);
        for (row, values) in values.chunks_exact_mut(xs.len()).enumerate() {
            let row = from_sides(1, ys[row % ys.len()]).min(from_sides(2, zs[row / ys.len()]));
            for (v, &x) in values.iter_mut().zip(xs) {
                *v = smaller(*v, from_sides(0, x).min(row) * self.steepness);
            }
        }
    }
}

/// The smaller one; what is no number stays so, so that it is found.
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}
