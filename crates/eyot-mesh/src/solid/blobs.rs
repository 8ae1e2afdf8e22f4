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

use super::field::{Point, ScalarField, Within};
use super::kernel::Kernel;
use super::vector::{add, dot, scale, sub};
use crate::error::{Error, Result};
use eyot_core::Limits;
use eyot_core::rng::mix64;

/// A ball, a rounded cylinder or a rounded cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primitive {
    /// Ends of the axis.
    pub ends: [Point; 2],
    /// Radius at either end.
    pub radii: [f32; 2],
}

impl Primitive {
    /// A ball.
    pub const fn ball(centre: Point, radius: f32) -> Self {
        Self { ends: [centre; 2], radii: [radius; 2] }
    }

    /// A cylinder with rounded ends.
    pub const fn cylinder(from: Point, to: Point, radius: f32) -> Self {
        Self { ends: [from, to], radii: [radius; 2] }
    }

    /// A cone with rounded ends; the radius goes linearly from one end of the axis to the other.
    pub const fn cone(from: Point, to: Point, radii: [f32; 2]) -> Self {
        Self { ends: [from, to], radii }
    }

    /// The box of all points that are nearer to the axis than `factor` radii of the thicker end.
    fn reach(&self, factor: f32) -> [Point; 2] {
        let r = factor * self.radii[0].max(self.radii[1]);
        let [a, b] = self.ends;
        [std::array::from_fn(|i| a[i].min(b[i]) - r), std::array::from_fn(|i| a[i].max(b[i]) + r)]
    }

    fn is_sound(&self) -> bool {
        let finite = self.ends.as_flattened().iter().chain(&self.radii).all(|v| v.is_finite());
        finite && self.radii.iter().all(|&r| r > 0.0)
    }
}

/// What becomes of primitives that overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
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
            Shape {
                from: p.ends[0],
                axis,
                per_length2: if length2 > 0.0 { 1.0 / length2 } else { 0.0 },
                radius: factor * p.radii[0],
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

    fn part(&self, near: Vec<Shape>, low: Point, high: Point) -> Part {
        let corners = Corners::new(&near, low, high);
        Part { kernel: self.kernel, blend: self.blend, iso: self.iso, shapes: near, corners }
    }
}

impl ScalarField for Blobs {
    fn value(&self, p: Point) -> f32 {
        self.part(self.buckets.near(&self.shapes, p, p), p, p).value(p)
    }

    fn slope(&self, p: Point, voxel: f32) -> (f32, Point) {
        self.part(self.buckets.near(&self.shapes, p, p), p, p).slope(p, voxel)
    }

    fn within(&self, low: Point, high: Point) -> Within<'_> {
        let near = self.buckets.near(&self.shapes, low, high);
        if near.is_empty() { Within::Nothing } else { Within::Part(Box::new(self.part(near, low, high))) }
    }
}

/// The primitives that matter in some box, in the order in which all of them stand. Sums in that order, to which the others
/// add exactly nothing, have the same bits in every box.
struct Part {
    kernel: Kernel,
    blend: Blend,
    iso: f32,
    shapes: Vec<Shape>,
    corners: Corners,
}

/// Which primitives of a box matter in each of its 64 parts, for questions about single points.
#[derive(Default)]
struct Corners {
    low: Point,
    per_m: Point,
    lists: Vec<Vec<u16>>,
}

impl Corners {
    /// Parts along a side.
    const SIDE: usize = 4;
    /// Fewer primitives are asked one by one.
    const FEW: usize = 8;

    fn new(shapes: &[Shape], low: Point, high: Point) -> Self {
        if shapes.len() <= Self::FEW || shapes.len() > usize::from(u16::MAX) || (0..3).any(|i| low[i] >= high[i]) {
            return Self::default();
        }
        let per_m = std::array::from_fn(|i| Self::SIDE as f32 / (high[i] - low[i]));
        let mut corners = Self { low, per_m, lists: vec![Vec::new(); Self::SIDE.pow(3)] };
        for (number, s) in shapes.iter().enumerate() {
            let ([x0, y0, z0], [x1, y1, z1]) = (corners.part(s.low), corners.part(s.high));
            for (z, y) in (z0..=z1).flat_map(|z| (y0..=y1).map(move |y| (z, y))) {
                let row = (z * Self::SIDE + y) * Self::SIDE;
                corners.lists[row + x0..=row + x1].iter_mut().for_each(|list| list.push(number as u16));
            }
        }
        corners
    }

    /// The part in which a point lies. The same rounding for points and boxes, so that nobody is overlooked.
    fn part(&self, p: Point) -> [usize; 3] {
        std::array::from_fn(|i| ((p[i] - self.low[i]) * self.per_m[i]).clamp(0.0, Self::SIDE as f32 - 1.0) as usize)
    }

    /// Numbers of the primitives that matter at a point of the box; all of them if nothing better is known.
    fn near(&self, p: Point) -> Option<&[u16]> {
        let [x, y, z] = self.part(p);
        self.lists.get((z * Self::SIDE + y) * Self::SIDE + x).map(Vec::as_slice)
    }
}

impl Shape {
    /// `1 - (d / R)^2`, not below 0, at a point.
    #[inline(always)]
    fn depth(&self, p: Point) -> f32 {
        let to = sub(p, self.from);
        let t = (dot(to, self.axis) * self.per_length2).clamp(0.0, 1.0);
        let off = sub(to, scale(self.axis, t));
        let radius = self.radius + t * self.gain;
        (1.0 - dot(off, off) / (radius * radius)).max(0.0)
    }

    /// The same with its gradient.
    fn slope(&self, p: Point) -> (f32, Point) {
        let to = sub(p, self.from);
        let along = dot(to, self.axis) * self.per_length2;
        let t = along.clamp(0.0, 1.0);
        let off = sub(to, scale(self.axis, t));
        let radius = self.radius + t * self.gain;
        // The same operations as in `depth`, so that both give the same value.
        let share = dot(off, off) / (radius * radius);
        if share >= 1.0 {
            return (0.0, [0.0; 3]);
        }
        // v = 1 - |off|^2 / R^2; off stands on the axis, so only R changes along it.
        let mut gradient = scale(off, -2.0 / (radius * radius));
        if t == along {
            gradient = add(gradient, scale(self.axis, 2.0 * share / radius * self.gain * self.per_length2));
        }
        (1.0 - share, gradient)
    }
}

fn eighth_power(k: f32) -> f32 {
    let k2 = k * k;
    (k2 * k2) * (k2 * k2)
}

impl Part {
    /// Field from the sums of values and of their ninth powers.
    #[inline(always)]
    fn blended(&self, sum: f32, ninth: f32) -> f32 {
        match self.blend {
            Blend::Sum => sum - self.iso,
            Blend::Normalised => {
                let mean8 = if sum > 0.0 { ninth / sum } else { 0.0 };
                mean8.sqrt().sqrt().sqrt() - self.iso
            }
        }
    }

    /// Adds each primitive to the sums of a row; `kernel` is a constant here, so that the loop is one of plain arithmetic.
    #[inline(always)]
    fn sums(&self, kernel: Kernel, xs: &[f32], y: f32, z: f32, sums: &mut [[f32; MAX_ROW]; 2]) {
        for shape in &self.shapes {
            if y < shape.low[1] || y > shape.high[1] || z < shape.low[2] || z > shape.high[2] {
                continue;
            }
            let begin = xs.partition_point(|&x| x < shape.low[0]);
            let end = begin + xs[begin..].partition_point(|&x| x <= shape.high[0]);
            let [sum, ninth] = sums;
            for ((&x, s), n) in xs[begin..end].iter().zip(&mut sum[begin..end]).zip(&mut ninth[begin..end]) {
                let k = kernel.at(shape.depth([x, y, z]));
                *s += k;
                *n += k * eighth_power(k);
            }
        }
    }
}

/// Points of a row that are summed at once.
const MAX_ROW: usize = 32;

impl ScalarField for Part {
    fn value(&self, p: Point) -> f32 {
        let mut value = [0.0];
        self.row(&[p[0]], p[1], p[2], &mut value);
        value[0]
    }

    fn row(&self, xs: &[f32], y: f32, z: f32, values: &mut [f32]) {
        for (xs, values) in xs.chunks(MAX_ROW).zip(values.chunks_mut(MAX_ROW)) {
            let mut sums = [[0.0; MAX_ROW]; 2];
            match self.kernel {
                Kernel::Blinn => self.sums(Kernel::Blinn, xs, y, z, &mut sums),
                Kernel::Wyvill => self.sums(Kernel::Wyvill, xs, y, z, &mut sums),
                Kernel::Nishimura => self.sums(Kernel::Nishimura, xs, y, z, &mut sums),
                Kernel::Muraki => self.sums(Kernel::Muraki, xs, y, z, &mut sums),
            }
            for (i, v) in values.iter_mut().enumerate() {
                *v = self.blended(sums[0][i], sums[1][i]);
            }
        }
    }

    fn slope(&self, p: Point, _voxel: f32) -> (f32, Point) {
        let (mut sum, mut ninth, mut by_sum, mut by_ninth) = (0.0, 0.0, [0.0; 3], [0.0; 3]);
        let mut add_one = |shape: &Shape| {
            let (v, depth_gradient) = shape.slope(p);
            if v > 0.0 {
                let k = self.kernel.at(v);
                let gradient = scale(depth_gradient, self.kernel.derivative(v));
                let eighth = eighth_power(k);
                (sum, ninth) = (sum + k, ninth + k * eighth);
                by_sum = add(by_sum, gradient);
                by_ninth = add(by_ninth, scale(gradient, 9.0 * eighth));
            }
        };
        match self.corners.near(p) {
            Some(near) => near.iter().for_each(|&i| add_one(&self.shapes[usize::from(i)])),
            None => self.shapes.iter().for_each(&mut add_one),
        }
        let value = self.blended(sum, ninth);
        match self.blend {
            Blend::Sum => (value, by_sum),
            Blend::Normalised if sum > 0.0 && ninth > 0.0 => {
                // ln F = (ln ninth - ln sum) / 8
                let f = (value + self.iso) / 8.0;
                (value, sub(scale(by_ninth, f / ninth), scale(by_sum, f / sum)))
            }
            Blend::Normalised => (value, [0.0; 3]),
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
const FEW: usize = 64;

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
        let touches = |s: &Shape| (0..3).all(|i| s.low[i] <= high[i] && low[i] <= s.high[i]);
        if self.members.is_empty() {
            return shapes.iter().filter(|s| touches(s)).copied().collect();
        }
        let mut found: Vec<u32> = Vec::new();
        self.reached(low, high, |b| {
            let members = &self.members[self.starts[b]..self.starts[b + 1]];
            found.extend(members.iter().filter(|&&m| touches(&shapes[m as usize])));
        });
        found.sort_unstable();
        found.dedup();
        found.iter().map(|&m| shapes[m as usize]).collect()
    }
}
