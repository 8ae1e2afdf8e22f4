//! Bodies of balls, rounded cylinders and cones that melt into each other.
//!
//! # Equations
//! 1. A primitive has the value `k_i = k(d_i / R_i)` at a point, `k` being the [`Kernel`], `d_i` the distance to its axis, and
//!    `R_i = r_i / k^-1(1/2)`, so that alone it has the surface where `d_i = r_i`.
//! 2. [`Blend::Sum`]: `F = sum of k_i`. Bodies swell where many primitives overlap.
//! 3. [`Blend::Normalised`]: `F = (sum of k_i^9 / sum of k_i)^(1/8)`, the Gini mean of orders 9 and 1: between the largest
//!    `k_i` and 0.9 of it. However many primitives lie on top of each other, they are as large as one.
//! 4. The field is `F - iso`.
//!
//! # Source
//! Blinn 1982, Wyvill and others 1986, Nishimura and others 1985, Muraki 1991 for kernels and sums.

use super::field::{ScalarField, Within};
use super::kernel::Kernel;
use super::vector::{dot, sub};
use crate::error::{Error, Result};
use crate::primitive::{Point, Primitive};
use eyot_core::Limits;
use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::real::Real;
use eyot_core::rng::mix64;

/// What becomes of primitives that overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Blend {
    /// Their values add up; bodies swell.
    Sum,
    /// They melt into each other and keep their size.
    #[default]
    Normalised,
}

/// A body of primitives.
pub struct Blobs {
    kernel: Kernel,
    blend: Blend,
    iso: f32,
    shapes: Vec<Shape>,
    buckets: Buckets,
}

/// A primitive as it is evaluated.
#[derive(Clone, Copy, Debug)]
struct Shape {
    from: Point,
    /// From one end to the other.
    axis: Point,
    /// One over the squared length of the axis; 0 for a ball.
    per_length2: f32,
    /// Radius of influence at the first end, and what it gains towards the other.
    radius: f32,
    gain: f32,
    /// One over the squared radius of influence, if it is the same at both ends.
    per_radius2: f32,
    low: Point,
    high: Point,
}

impl Blobs {
    /// A body of these primitives: the isosurface 1/2, so that a single one has its own radius.
    ///
    /// # Errors
    /// If a primitive's place or radius is no finite number or a radius is not above 0, or if there are more primitives than
    /// the limits have bytes for.
    pub fn new(primitives: &[Primitive], kernel: Kernel, blend: Blend, limits: &Limits) -> Result<Self> {
        limits.check_bytes("a body of primitives", primitives.len() as u128 * 2 * size_of::<Shape>() as u128)?;
        if let Some(index) = primitives.iter().position(|p| !p.is_sound()) {
            return Err(Error::BadPrimitive { index, primitive: primitives[index] });
        }
        // A hair more, so that rounding never cuts off what is not quite nothing.
        let factor = 1.0 / kernel.radius_of(0.5);
        let shape = |p: &Primitive| {
            let axis = sub(p.ends[1], p.ends[0]);
            let length2 = dot(axis, axis);
            let [low, high] = p.reach(1.0001 * factor);
            let radius = factor * p.radii[0];
            Shape {
                from: p.ends[0],
                axis,
                per_length2: if length2 > f32::MIN_POSITIVE { 1.0 / length2 } else { 0.0 },
                radius,
                per_radius2: 1.0 / (radius * radius),
                gain: factor * (p.radii[1] - p.radii[0]),
                low,
                high,
            }
        };
        let shapes: Vec<Shape> = primitives.iter().map(shape).collect();
        let buckets = Buckets::new(&shapes);
        Ok(Self { kernel, blend, iso: 0.5, shapes, buckets })
    }

    /// The same with another isosurface, within 0..1: lower ones are thicker by the same factor everywhere, see
    /// [`Kernel::radius_of`].
    #[must_use]
    pub fn with_iso(mut self, iso: f32) -> Self {
        self.iso = iso.clamp(1e-3, 0.999);
        self
    }

    /// The box outside of which there is nothing; `None` without primitives.
    pub fn bounds(&self) -> Option<[Point; 2]> {
        let first = self.shapes.first()?;
        Some(self.shapes.iter().fold([first.low, first.high], |[low, high], s| {
            [std::array::from_fn(|i| low[i].min(s.low[i])), std::array::from_fn(|i| high[i].max(s.high[i]))]
        }))
    }

    fn part(&self, low: Point, high: Point) -> Part {
        let shapes = self.buckets.near(&self.shapes, low, high);
        Part { kernel: self.kernel, blend: self.blend, iso: self.iso, shapes }
    }
}

impl ScalarField for Blobs {
    fn value(&self, p: Point) -> f32 {
        self.part(p, p).value(p)
    }

    fn slope(&self, p: Point, voxel: f32) -> (f32, Point) {
        self.part(p, p).slope(p, voxel)
    }

    fn within(&self, low: Point, high: Point) -> Within<'_> {
        let part = self.part(low, high);
        if part.shapes.is_empty() { Within::Nothing } else { Within::Part(Box::new(part)) }
    }
}

/// The primitives that matter in some box, in the order in which all of them stand. Sums in that order, to which the others
/// add exactly nothing, have the same bits in every box, for one point and for sixteen.
struct Part {
    kernel: Kernel,
    blend: Blend,
    iso: f32,
    shapes: Vec<Shape>,
}

impl Shape {
    /// From the axis to a point, where the axis is nearest, in axes, and that before it ends where the axis does.
    #[inline(always)]
    fn off<R: Real>(&self, p: [R; 3]) -> ([R; 3], R, R) {
        let n = R::of;
        let to = [p[0] - n(self.from[0]), p[1] - n(self.from[1]), p[2] - n(self.from[2])];
        if self.per_length2 == 0.0 {
            return (to, n(0.0), n(0.0));
        }
        let a = [n(self.axis[0]), n(self.axis[1]), n(self.axis[2])];
        let along = product(to, a) * n(self.per_length2);
        let t = along.clamp(n(0.0), n(1.0));
        ([to[0] - a[0] * t, to[1] - a[1] * t, to[2] - a[2] * t], t, along)
    }

    /// `1 - (d / R)^2`, not below 0, at a point.
    #[inline(always)]
    fn depth<R: Real>(&self, p: [R; 3]) -> R {
        let (off, t, _) = self.off(p);
        (R::of(1.0) - self.share(off, t).0).positive()
    }

    /// `(d / R)^2`, and one over `R^2`.
    #[inline(always)]
    fn share<R: Real>(&self, off: [R; 3], t: R) -> (R, R) {
        let n = R::of;
        let per_radius2 = if self.gain == 0.0 {
            n(self.per_radius2)
        } else {
            let radius = n(self.radius) + t * n(self.gain);
            n(1.0) / (radius * radius)
        };
        (product(off, off) * per_radius2, per_radius2)
    }

    /// The same as [`Shape::depth`] with its gradient, which means nothing where the value is 0.
    #[inline(always)]
    fn slope<R: Real>(&self, p: [R; 3]) -> (R, [R; 3]) {
        let n = R::of;
        let (off, t, along) = self.off(p);
        let (share, per_radius2) = self.share(off, t);
        // v = 1 - |off|^2 / R^2; off stands on the axis, so only R changes along it.
        let across = n(-2.0) * per_radius2;
        let mut gradient = [off[0] * across, off[1] * across, off[2] * across];
        if self.gain != 0.0 {
            let radius = n(self.radius) + t * n(self.gain);
            let growth = n(2.0) * share / radius * n(self.gain * self.per_length2);
            let growth = along.lt(n(0.0)).pick(n(0.0), n(1.0).lt(along).pick(n(0.0), growth));
            for (g, a) in gradient.iter_mut().zip(self.axis) {
                *g = *g + n(a) * growth;
            }
        }
        ((n(1.0) - share).positive(), gradient)
    }

    /// True if it may matter somewhere in a box.
    fn touches(&self, low: Point, high: Point) -> bool {
        (0..3).fold(true, |all, i| all & (self.low[i] <= high[i]) & (low[i] <= self.high[i]))
    }

    /// From where to where along y the shape reaches at this z.
    fn reach_at(&self, z: f32) -> [f32; 2] {
        let (dz, r) = (self.axis[2], 1.001 * self.radius.max(self.radius + self.gain));
        if dz.abs() < 0.01 * r {
            return [self.low[1], self.high[1]];
        }
        // Parts of the axis that are nearer than that in z.
        let at = |z: f32| ((z - self.from[2]) / dz).clamp(0.0, 1.0);
        let y = [at(z - r), at(z + r)].map(|t| self.from[1] + t * self.axis[1]);
        [(y[0].min(y[1]) - r).max(self.low[1]), (y[0].max(y[1]) + r).min(self.high[1])]
    }
}

/// A box that holds another point, too.
fn bounds([low, high]: [Point; 2], p: &Point) -> [Point; 2] {
    [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
}

/// Product of two vectors.
#[inline(always)]
fn product<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn eighth_power<R: Real>(k: R) -> R {
    let k2 = k * k;
    (k2 * k2) * (k2 * k2)
}

impl Part {
    /// Field from the sums of values and of their ninth powers.
    #[inline(always)]
    fn blended<R: Real>(&self, sum: R, ninth: R) -> R {
        let n = R::of;
        match self.blend {
            Blend::Sum => sum - n(self.iso),
            Blend::Normalised => {
                let mean8 = n(0.0).lt(sum).pick(ninth / sum, n(0.0));
                mean8.sqrt().sqrt().sqrt() - n(self.iso)
            }
        }
    }

    /// Value and gradient at points, from these primitives, among which are all that matter there.
    #[inline(always)]
    fn slope_of<R: Real>(&self, shapes: &[u32], p: [R; 3]) -> (R, [R; 3]) {
        let n = R::of;
        let (mut sum, mut ninth) = (n(0.0), n(0.0));
        let (mut by_sum, mut by_ninth) = ([n(0.0); 3], [n(0.0); 3]);
        for &i in shapes {
            let (v, gradient) = self.shapes[i as usize].slope(p);
            let k = self.kernel.at(v);
            let eighth = eighth_power(k);
            sum = sum + k;
            ninth = ninth + k * eighth;
            let by_depth = self.kernel.derivative(v);
            let nine = n(9.0) * eighth;
            for axis in 0..3 {
                let g = n(0.0).lt(v).pick(gradient[axis] * by_depth, n(0.0));
                by_sum[axis] = by_sum[axis] + g;
                by_ninth[axis] = by_ninth[axis] + g * nine;
            }
        }
        let value = self.blended(sum, ninth);
        match self.blend {
            Blend::Sum => (value, by_sum),
            Blend::Normalised => {
                // ln F = (ln ninth - ln sum) / 8
                let f = (value + n(self.iso)) * n(0.125);
                let (high, low) = (f / ninth, f / sum);
                for axis in 0..3 {
                    let g = by_ninth[axis] * high - by_sum[axis] * low;
                    by_sum[axis] = n(0.0).lt(ninth).pick(g, n(0.0));
                }
                (value, by_sum)
            }
        }
    }
}

/// Values at the points of a plane of rows along x, sixteen to a row.
struct Plane<'a> {
    part: &'a Part,
    xs: &'a [f32; WIDTH],
    ys: &'a [f32],
    z: f32,
    rows: &'a mut [[f32; WIDTH]],
}

impl LaneTask for Plane<'_> {
    type Out = ();

    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let Plane { part, xs, ys, z, rows } = self;
        let (n, x) = (rows.len().min(WIDTH), L::from_array(*xs));
        let mut sums = [[L::of(0.0); 2]; WIDTH];
        for shape in part.shapes.iter().filter(|s| s.low[2] <= z && z <= s.high[2]) {
            let [low, high] = shape.reach_at(z);
            for (sums, &y) in sums[..n].iter_mut().zip(ys) {
                if low <= y && y <= high {
                    let k = part.kernel.at(shape.depth([x, L::of(y), L::of(z)]));
                    sums[0] = sums[0] + k;
                    sums[1] = sums[1] + k * eighth_power(k);
                }
            }
        }
        for (row, [sum, ninth]) in rows.iter_mut().zip(sums) {
            *row = part.blended(sum, ninth).to_array();
        }
    }
}

/// Values and gradients at points for which the same primitives matter.
struct Slopes<'a> {
    part: &'a Part,
    shapes: &'a [u32],
    /// Numbers of the points.
    chosen: &'a [u32],
    points: &'a [Point],
    slopes: &'a mut [(f32, Point)],
}

impl LaneTask for Slopes<'_> {
    type Out = ();

    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        for chosen in self.chosen.chunks(WIDTH) {
            // Lanes that are left over repeat the first point.
            let mut p = [[0.0; WIDTH]; 3];
            for lane in 0..WIDTH {
                let point = self.points[chosen[if lane < chosen.len() { lane } else { 0 }] as usize];
                for axis in 0..3 {
                    p[axis][lane] = point[axis];
                }
            }
            let p = [L::from_array(p[0]), L::from_array(p[1]), L::from_array(p[2])];
            let (value, gradient) = self.part.slope_of(self.shapes, p);
            let (value, g) =
                (value.to_array(), [gradient[0].to_array(), gradient[1].to_array(), gradient[2].to_array()]);
            for (lane, &i) in chosen.iter().enumerate() {
                self.slopes[i as usize] = (value[lane], [g[0][lane], g[1][lane], g[2][lane]]);
            }
        }
    }
}

/// Parts along each side of a box of points that are asked together.
const PARTS: usize = 2;

impl ScalarField for Part {
    fn value(&self, p: Point) -> f32 {
        let (mut sum, mut ninth) = (0.0, 0.0);
        for shape in &self.shapes {
            let k = self.kernel.at(shape.depth(p));
            (sum, ninth) = (sum + k, ninth + k * eighth_power(k));
        }
        self.blended(sum, ninth)
    }

    fn fill(&self, [xs, ys, zs]: [&[f32]; 3], values: &mut [f32]) {
        let (nx, ny) = (xs.len(), ys.len());
        let isa = Isa::best();
        for first_x in (0..nx).step_by(WIDTH) {
            let wide = WIDTH.min(nx - first_x);
            // What is left over repeats the last point.
            let lanes: [f32; WIDTH] = std::array::from_fn(|i| xs[first_x + i.min(wide - 1)]);
            for (plane, &z) in zs.iter().enumerate() {
                for (first_y, ys) in (0..).step_by(WIDTH).zip(ys.chunks(WIDTH)) {
                    let mut rows = [[0.0; WIDTH]; WIDTH];
                    run_lanes(isa, Plane { part: self, xs: &lanes, ys, z, rows: &mut rows[..ys.len()] });
                    for (y, row) in rows[..ys.len()].iter().enumerate() {
                        let at = (plane * ny + first_y + y) * nx + first_x;
                        values[at..at + wide].copy_from_slice(&row[..wide]);
                    }
                }
            }
        }
    }

    fn slope(&self, p: Point, _voxel: f32) -> (f32, Point) {
        let all: Vec<u32> = (0..self.shapes.len() as u32).collect();
        self.slope_of(&all, p)
    }

    fn slopes(&self, points: &[Point], _voxel: f32, slopes: &mut [(f32, Point)]) {
        let Some(&first) = points.first() else { return };
        let [low, high] = points.iter().fold([first; 2], bounds);
        let per_part: Point = std::array::from_fn(|i| PARTS as f32 / (high[i] - low[i]).max(f32::MIN_POSITIVE));
        let part = |p: &Point| {
            let at = |i: usize| (((p[i] - low[i]) * per_part[i]) as usize).min(PARTS - 1);
            (at(2) * PARTS + at(1)) * PARTS + at(0)
        };
        // Points in the order of their parts.
        let mut ends = [0u32; PARTS * PARTS * PARTS];
        points.iter().for_each(|p| ends[part(p)] += 1);
        let mut all = 0;
        for end in &mut ends {
            (*end, all) = (all, all + *end);
        }
        let mut chosen = vec![0u32; points.len()];
        for (i, p) in points.iter().enumerate() {
            let next = &mut ends[part(p)];
            chosen[*next as usize] = i as u32;
            *next += 1;
        }
        let (isa, mut begin) = (Isa::best(), 0);
        let mut shapes = vec![0u32; self.shapes.len()];
        for end in ends.map(|e| e as usize) {
            let chosen = &chosen[std::mem::replace(&mut begin, end)..end];
            let Some(&one) = chosen.first() else { continue };
            let one = points[one as usize];
            let [low, high] = chosen.iter().fold([one; 2], |b, &i| bounds(b, &points[i as usize]));
            // Every number is written and only those of neighbours stay: whether a shape is one is a coin toss, not to be bet on.
            let mut near = 0;
            for (i, shape) in self.shapes.iter().enumerate() {
                shapes[near] = i as u32;
                near += usize::from(shape.touches(low, high));
            }
            run_lanes(isa, Slopes { part: self, shapes: &shapes[..near], chosen, points, slopes: &mut *slopes });
        }
    }

    fn stamp(&self) -> Option<u64> {
        let mut stamp = mix64(self.kernel as u64 ^ (self.blend as u64) << 8 ^ u64::from(self.iso.to_bits()) << 16);
        for s in &self.shapes {
            let numbers = [s.from, s.axis, [s.radius, s.gain, 0.0]];
            for pair in numbers.as_flattened().chunks(2) {
                let second = pair.get(1).map_or(0, |v| v.to_bits());
                stamp = mix64(stamp ^ u64::from(pair[0].to_bits()) << 32 ^ u64::from(second));
            }
        }
        Some(stamp)
    }
}

/// A coarse grid over all primitives; each bucket knows those that reach into it.
#[derive(Default)]
struct Buckets {
    low: Point,
    per_m: Point,
    counts: [usize; 3],
    /// Where each bucket's list begins in `members`.
    starts: Vec<usize>,
    members: Vec<u32>,
}

/// Fewer primitives are looked through one by one.
const FEW: usize = 512;

impl Buckets {
    fn new(shapes: &[Shape]) -> Self {
        if shapes.len() <= FEW {
            return Self::default();
        }
        let n = shapes.len() as f32;
        let low: Point = std::array::from_fn(|i| shapes.iter().map(|s| s.low[i]).fold(f32::INFINITY, f32::min));
        let high: Point = std::array::from_fn(|i| shapes.iter().map(|s| s.high[i]).fold(f32::NEG_INFINITY, f32::max));
        // Buckets as wide as primitives on average reach, and not many more than there are primitives.
        let mut most = (n.cbrt().ceil() * 2.0).min(128.0);
        loop {
            let counts = std::array::from_fn(|i| {
                let mean = shapes.iter().map(|s| s.high[i] - s.low[i]).sum::<f32>() / n;
                (((high[i] - low[i]) / mean).clamp(1.0, most)) as usize
            });
            let per_m = std::array::from_fn(|i| counts[i] as f32 / (high[i] - low[i]));
            let mut buckets = Self { low, per_m, counts, ..Self::default() };
            let mut sizes = vec![0usize; counts.iter().product::<usize>() + 1];
            for s in shapes {
                buckets.reached(s.low, s.high, |b| sizes[b + 1] += 1);
            }
            // A few large ones among many small ones would stand in too many lists.
            if sizes.iter().sum::<usize>() > 64 * shapes.len() && most > 1.0 {
                most *= 0.5;
                continue;
            }
            buckets.list(shapes, sizes);
            return buckets;
        }
    }

    /// Writes each primitive into the lists of its buckets; `sizes[b + 1]` is the length of list `b`.
    fn list(&mut self, shapes: &[Shape], mut sizes: Vec<usize>) {
        for b in 1..sizes.len() {
            sizes[b] += sizes[b - 1];
        }
        self.starts = sizes.clone();
        let mut members = vec![0; sizes[sizes.len() - 1]];
        for (i, s) in shapes.iter().enumerate() {
            self.reached(s.low, s.high, |b| {
                members[sizes[b]] = i as u32;
                sizes[b] += 1;
            });
        }
        self.members = members;
    }

    /// Calls `f` with the number of each bucket that a box reaches.
    fn reached(&self, low: Point, high: Point, mut f: impl FnMut(usize)) {
        let index =
            |v: f32, i: usize| (((v - self.low[i]) * self.per_m[i]).clamp(0.0, self.counts[i] as f32 - 1.0)) as usize;
        for z in index(low[2], 2)..=index(high[2], 2) {
            for y in index(low[1], 1)..=index(high[1], 1) {
                for x in index(low[0], 0)..=index(high[0], 0) {
                    f((z * self.counts[1] + y) * self.counts[0] + x);
                }
            }
        }
    }

    /// Primitives that reach into a box, in their order.
    fn near(&self, shapes: &[Shape], low: Point, high: Point) -> Vec<Shape> {
        if self.members.is_empty() {
            return shapes.iter().filter(|s| s.touches(low, high)).copied().collect();
        }
        let mut found: Vec<u32> = Vec::new();
        self.reached(low, high, |b| {
            let members = &self.members[self.starts[b]..self.starts[b + 1]];
            found.extend(members.iter().filter(|&&m| shapes[m as usize].touches(low, high)));
        });
        found.sort_unstable();
        found.dedup();
        found.iter().map(|&m| shapes[m as usize]).collect()
    }
}
