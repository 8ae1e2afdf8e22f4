//! What bodies are made of.

/// A point or a vector.
pub type Point = [f32; 3];

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
    pub(crate) fn reach(&self, factor: f32) -> [Point; 2] {
        let r = factor * self.radii[0].max(self.radii[1]);
        let [a, b] = self.ends;
        [std::array::from_fn(|i| a[i].min(b[i]) - r), std::array::from_fn(|i| a[i].max(b[i]) + r)]
    }

    pub(crate) fn is_sound(&self) -> bool {
        let finite = self.ends.as_flattened().iter().chain(&self.radii).all(|v| v.is_finite());
        finite && self.radii.iter().all(|&r| r > 0.0)
    }
}
