//! Where a camera must stand so that a picture shows the land as a whole, as large as it can be.
//!
//! A camera that only moves keeps its axes, so each place of the land bounds where it may stand by four planes, one for each side of
//! the picture. Along the camera's own axes these bounds are sums: the nearest stand is found from the outermost
//! places for each side, for any shape of land and of picture.

use crate::math::{V3, add, direction, dot, scale};
use crate::path::Pose;
use crate::stage::Stage;
use rayon::prelude::*;

/// Shares of half the picture that stay free on either side, at the top and at the bottom.
const SIDES: f32 = 0.05;
const ABOVE: f32 = 0.07;
const BELOW: f32 = 0.10;

/// The outermost places as seen along fixed axes: for each side of the picture the bound that they set.
#[derive(Clone, Copy)]
struct Bounds {
    left: f32,
    right: f32,
    bottom: f32,
    top: f32,
    /// How far forward the nearest place is.
    near: f32,
}

impl Bounds {
    const NOTHING: Self = Self {
        left: f32::INFINITY,
        right: f32::NEG_INFINITY,
        bottom: f32::INFINITY,
        top: f32::NEG_INFINITY,
        near: f32::INFINITY,
    };

    fn and(self, o: Self) -> Self {
        Self {
            left: self.left.min(o.left),
            right: self.right.max(o.right),
            bottom: self.bottom.min(o.bottom),
            top: self.top.max(o.top),
            near: self.near.min(o.near),
        }
    }
}

/// What a picture of a stage is to show.
struct Subject<'a> {
    stage: &'a Stage,
    /// Smallest and largest east, south and height of it, m.
    span: [[f32; 2]; 3],
}

impl<'a> Subject<'a> {
    fn new(stage: &'a Stage) -> Self {
        let mut subject = Self { stage, span: [[0.0; 2]; 3] };
        let nothing = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
        let span = subject.fold(
            nothing,
            |s, p| std::array::from_fn(|k| [s[k][0].min(p[k]), s[k][1].max(p[k])]),
            |a, b| std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])]),
        );
        let size = stage.size_m();
        let whole = [[0.0, size[0]], [0.0, size[1]], [0.0, 0.0]];
        // An open sea without land is seen as far as the grid goes.
        subject.span = if span[0][0] <= span[0][1] { span } else { whole };
        subject
    }

    /// Folds all places that must be in the picture: the surface of a relief model with its foot, or land and shoals of an open sea.
    fn fold<T: Copy + Send + Sync>(
        &self,
        start: T,
        with: impl Fn(T, V3) -> T + Send + Sync,
        both: impl Fn(T, T) -> T + Send + Sync,
    ) -> T {
        let (stage, [w, _]) = (self.stage, self.stage.cells());
        let [dx, dy] = stage.cell_m();
        // A single row or column is a strip of its own width.
        let [e, s] = stage.size_m();
        let shoal = -0.35 * stage.clarity * stage.exaggeration;
        let rows = stage.tops().par_chunks(w).enumerate().map(|(y, row)| {
            row.iter().enumerate().fold(start, |all, (x, &z)| {
                let at = [x as f32 * dx, y as f32 * dy];
                if stage.block {
                    with(all, [at[0], at[1], if stage.sea { z.max(0.0) } else { z }])
                } else if z > shoal {
                    with(all, [at[0], at[1], z.max(0.0)])
                } else {
                    all
                }
            })
        });
        let mut all = rows.reduce(|| start, &both);
        if stage.block {
            let foot = stage.foot();
            for (x, y) in [(0.0, 0.0), (e, 0.0), (0.0, s), (e, s)] {
                let rim = stage.height_at(x, y).max(if stage.sea { 0.0 } else { f32::NEG_INFINITY });
                all = with(with(all, [x, y, foot]), [x, y, rim]);
            }
        }
        all
    }

    fn middle(&self) -> V3 {
        self.span.map(|[low, high]| 0.5 * (low + high))
    }
}

impl Stage {
    /// `pose` moved along its own axes, so that a picture of so many columns a row shows all of a relief model, or the land and shoals of an open
    /// sea, as large as it can. Direction and angle of view stay.
    pub(crate) fn framed(&self, pose: &Pose, aspect: f32) -> Pose {
        let subject = Subject::new(self);
        let middle = subject.middle();
        let camera = self.camera_towards(pose);
        let ([right, up, forward], aspect) = ([camera.right, camera.up, camera.forward], aspect.clamp(0.01, 100.0));
        let (across, over, under) =
            (camera.tan * aspect * (1.0 - SIDES), camera.tan * (1.0 - ABOVE), camera.tan * (1.0 - BELOW));
        let bounds = |p: V3| {
            let p = add(p, scale(middle, -1.0));
            let [r, u, f] = [right, up, forward].map(|axis| dot(axis, p));
            Bounds { left: r + across * f, right: r - across * f, bottom: u + under * f, top: u - over * f, near: f }
        };
        let mut b = subject.fold(Bounds::NOTHING, |all, p| all.and(bounds(p)), Bounds::and);
        if !(b.left.is_finite() && b.right.is_finite() && b.bottom.is_finite() && b.top.is_finite()) {
            let [[x0, x1], [y0, y1], [z, _]] = subject.span;
            b = [[x0, y0, z], [x1, y0, z], [x0, y1, z], [x1, y1, z]]
                .into_iter()
                .fold(Bounds::NOTHING, |all, p| all.and(bounds(p)));
        }
        // The eye, seen from the middle, at (r, u, f): b.right + across f <= r <= b.left - across f, and likewise for u.
        let back = ((b.left - b.right) / (2.0 * across)).min((b.bottom - b.top) / (over + under));
        // No peak comes nearer than a third of the way to the middle.
        let back = back.min(1.5 * b.near).min(-1e-6 * self.extent);
        let mut r = 0.5 * (b.left + b.right);
        let u = 0.5 * ((b.top + over * back) + (b.bottom - under * back));
        // A picture that is wider than the land needs leaves a choice: what is seen left and right of its middle is as wide.
        for _ in 0..3 {
            let seen = |p: V3| {
                let p = add(p, scale(middle, -1.0));
                (dot(right, p) - r) / (dot(forward, p) - back).max(1e-6 * self.extent)
            };
            let (west, east) = subject.fold(
                (f32::INFINITY, f32::NEG_INFINITY),
                |(w, e), p| (w.min(seen(p)), e.max(seen(p))),
                |a, b| (a.0.min(b.0), a.1.max(b.1)),
            );
            if !(west + east).is_finite() {
                break;
            }
            r -= 0.5 * (west + east) * back;
        }
        let target = add(middle, add(scale(right, r), scale(up, u)));
        let size = self.size_m();
        let framed = Pose {
            target: [target[0] / size[0], target[1] / size[1]],
            target_height: self.share_of_height(target[2]),
            distance: -back / self.extent,
            ..*pose
        };
        let sound = [framed.target[0], framed.target[1], framed.target_height, framed.distance];
        if sound.iter().all(|v| v.is_finite()) { framed } else { *pose }
    }

    /// The pose for a whole turn around the land that no part of it leaves: the middle of the land in the middle of the picture, from so far
    /// that every side of it fits.
    pub(crate) fn framed_all_around(&self, pose: &Pose, aspect: f32) -> Pose {
        const TURNS: usize = 16;
        let size = self.size_m();
        let middle = Subject::new(self).middle();
        let framed: Vec<Pose> = (0..TURNS)
            .map(|i| Pose { azimuth_deg: pose.azimuth_deg + 360.0 * i as f32 / TURNS as f32, ..*pose })
            .map(|p| self.framed(&p, aspect))
            .collect();
        // How far a framed picture's middle lies from the land's is made up for by distance.
        let needed = framed.iter().map(|p| {
            let off = (p.target[0] * size[0] - middle[0]).hypot(p.target[1] * size[1] - middle[1]) / self.extent;
            p.distance + off
        });
        let distance = needed.fold(0.0, f32::max);
        let height = framed.iter().map(|p| p.target_height).sum::<f32>() / TURNS as f32;
        Pose { target: [middle[0] / size[0], middle[1] / size[1]], target_height: height, distance, ..*pose }
    }

    /// A camera with the axes and the angle of view of a pose.
    fn camera_towards(&self, pose: &Pose) -> crate::camera::Camera {
        let back = direction(pose.azimuth_deg, pose.elevation_deg.clamp(1.0, 89.0));
        crate::camera::Camera::looking(back, [0.0; 3], pose.field_of_view_deg)
    }
}
