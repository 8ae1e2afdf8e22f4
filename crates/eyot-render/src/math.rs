//! Vectors of three floats (points, directions and linear colours) and the blends that every picture uses.

pub(crate) use eyot_core::math::smoothstep;
pub(crate) use eyot_core::vec3::{add, cross, dot, scale};

/// A point, a direction or a linear RGB colour.
pub(crate) type V3 = [f32; 3];

/// Component by component: light on a surface colour.
pub(crate) fn mul(a: V3, b: V3) -> V3 {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// `a` with length 1; straight up if it has no length.
pub(crate) fn unit(a: V3) -> V3 {
    let l = dot(a, a).sqrt();
    if l > 0.0 { scale(a, 1.0 / l) } else { [0.0, 0.0, 1.0] }
}

/// `a` at `t = 0`, `b` at `t = 1`.
pub(crate) fn mix(a: V3, b: V3, t: f32) -> V3 {
    [lerp(a[0], b[0], t), lerp(a[1], b[1], t), lerp(a[2], b[2], t)]
}

pub(crate) fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Component by component `exp(-k x)`: what is left of light on a way `x` through water or air.
pub(crate) fn attenuate(k: V3, x: f32) -> V3 {
    [(-k[0] * x).exp(), (-k[1] * x).exp(), (-k[2] * x).exp()]
}

/// The direction to a compass bearing and elevation, in east, south, up coordinates.
pub(crate) fn direction(azimuth_deg: f32, elevation_deg: f32) -> V3 {
    let (sa, ca) = azimuth_deg.to_radians().sin_cos();
    let (se, ce) = elevation_deg.to_radians().sin_cos();
    [sa * ce, -ca * ce, se]
}
