//! Remap: every height is looked up on a curve (filter).
//!
//! # Equations
//! 1. `t = (h - from_0) / (from_1 - from_0)`.
//! 2. `h' = to_0 + (to_1 - to_0) C(t)` with a curve `C` through the points, straight or a monotone cubic, which rises where the
//!    points rise and never overshoots them.
//!
//! # Source
//! Fritsch and Carlson 1980 (monotone cubic).

use super::check;
use eyot_core::process::{Around, Generator, Reach, Site};
use eyot_core::{Error, Field, Grid, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a curve runs from point to point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Curve {
    /// Straight.
    Linear,
    /// Without kinks and without overshooting.
    #[default]
    Smooth,
}

/// Changes heights by a curve, or moves a range of heights to another one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Remap {
    /// Heights at the beginning and at the end of the curve. If both are the same, the lowest and the highest of the land.
    #[schemars(inner(range(min = -1e6, max = 1e6)), extend("unit" = "m"))]
    pub from: [f32; 2],
    /// Heights that they become. If both are the same, those of `from`.
    #[schemars(inner(range(min = -1e6, max = 1e6)), extend("unit" = "m"))]
    pub to: [f32; 2],
    /// Points [x, y] of the curve, x increasing: shares of the way from the lower to the upper height, before and after.
    /// Below the diagonal land sinks: the default makes plains and leaves the peaks.
    #[schemars(length(min = 2, max = 64), extend("unit" = "1"))]
    pub points: Vec<[f32; 2]>,
    /// How the curve runs from point to point.
    pub curve: Curve,
    /// Whether heights beyond the first and last point stay at its value; else the curve goes on straight.
    pub clamp: bool,
}

impl Default for Remap {
    fn default() -> Self {
        Self {
            from: [0.0, 0.0],
            to: [0.0, 0.0],
            points: vec![[0.0, 0.0], [0.4, 0.12], [0.7, 0.45], [1.0, 1.0]],
            curve: Curve::Smooth,
            clamp: true,
        }
    }
}

/// Points with the slope of the curve at each.
struct Prepared {
    points: Vec<[f32; 2]>,
    slopes: Vec<f32>,
    curve: Curve,
    clamp: bool,
}

impl Prepared {
    fn at(&self, t: f32) -> f32 {
        let (p, last) = (&self.points, self.points.len() - 1);
        for (end, beyond) in [(0, t <= p[0][0]), (last, t >= p[last][0])] {
            if beyond {
                let slope = if self.clamp { 0.0 } else { self.slopes[end] };
                return p[end][1] + slope * (t - p[end][0]);
            }
        }
        let i = p.partition_point(|q| q[0] <= t) - 1;
        let ([x0, y0], [x1, y1]) = (p[i], p[i + 1]);
        let (w, s) = (x1 - x0, (t - x0) / (x1 - x0));
        match self.curve {
            Curve::Linear => y0 + s * (y1 - y0),
            Curve::Smooth => {
                // Hermite's cubic.
                let (a, b, r) = (self.slopes[i] * w, self.slopes[i + 1] * w, y1 - y0);
                y0 + s * (a + s * (3.0 * r - 2.0 * a - b + s * (a + b - 2.0 * r)))
            }
        }
    }
}

impl Remap {
    fn prepared(&self) -> Prepared {
        let p = &self.points;
        let rise: Vec<f32> = p.windows(2).map(|q| (q[1][1] - q[0][1]) / (q[1][0] - q[0][0])).collect();
        let slopes = (0..p.len())
            .map(|i| match (i.checked_sub(1).map(|k| rise[k]), rise.get(i)) {
                // The harmonic mean keeps the cubic monotone; at a turning point it is level.
                (Some(a), Some(&b)) if a * b > 0.0 && self.curve == Curve::Smooth => 2.0 * a * b / (a + b),
                (Some(_), Some(_)) => 0.0,
                (Some(a), None) => a,
                (None, b) => b.copied().unwrap_or(0.0),
            })
            .collect();
        Prepared { points: p.clone(), slopes, curve: self.curve, clamp: self.clamp }
    }
}

impl Generator for Remap {
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let from = if self.from[0] == self.from[1] { base.min_max().into() } else { self.from };
        let to = if self.to[0] == self.to[1] { from } else { self.to };
        let base = Around::new(site, self.reach(&site.grid), base)?;
        let curve = self.prepared();
        let (rise, span) = (to[1] - to[0], from[1] - from[0]);
        Field::from_rows(site.grid.width, site.rows.clone(), site.control, |y, row| {
            for (v, &h) in row.iter_mut().zip(base.row(y)) {
                // Level land has no range: it is at the beginning of the curve.
                let t = if span == 0.0 { 0.0 } else { (h - from[0]) / span };
                *v = to[0] + rise * curve.at(t);
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("remap", self)?;
        let fault = |reason: String| Error::BadParameter { owner: "remap".into(), field: "points".into(), reason };
        if !(2..=64).contains(&self.points.len()) {
            return Err(fault(format!("a curve takes 2 to 64 points, not {}", self.points.len())));
        }
        if let Some(p) = self.points.iter().flatten().find(|v| !(-1e3..=1e3).contains(*v)) {
            return Err(fault(format!("{p} is outside -1000..=1000; points are shares, mostly from 0 to 1")));
        }
        match self.points.windows(2).find(|p| p[1][0] - p[0][0] < 1e-5) {
            Some(p) => {
                Err(fault(format!("{} does not come after {}: the x of points must increase", p[1][0], p[0][0])))
            }
            None => Ok(()),
        }
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        if self.from[0] == self.from[1] { Reach::Whole } else { Reach::Cell }
    }

    fn is_filter(&self) -> bool {
        true
    }
}
