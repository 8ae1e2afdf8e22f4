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

/// Places that stand for the land along a side of the grid at most: all cells of most grids, the highest of some in larger ones.
const PLACES: usize = 512;

/// What pictures of a stage are to show, as places: the surface of a relief model with its foot, or land and shoals of an open sea. A later state of the
/// world changes nothing of it, so that cameras do not jump.
#[derive(Default)]
pub(crate) struct Subject {
    places: Vec<V3>,
    /// The middle of the smallest box around them.
    middle: V3,
}

impl Subject {
    pub(crate) fn of(stage: &Stage) -> Self {
        let ([w, h], [dx, dy], [e, s]) = (stage.cells(), stage.cell_m(), stage.size_m());
        let (tops, floor) = (stage.tops(), if stage.sea { 0.0 } else { f32::NEG_INFINITY });
        let shoal = if stage.block { f32::NEG_INFINITY } else { -0.35 * stage.clarity * stage.exaggeration };
        let step = w.max(h).div_ceil(PLACES);
        let highest = |x: usize, y: usize| {
            let cells = (y..(y + step).min(h)).flat_map(|y| (x..(x + step).min(w)).map(move |x| y * w + x));
            cells.max_by(|&a, &b| tops[a].total_cmp(&tops[b])).filter(|&i| tops[i] > shoal)
        };
        let tiles = (0..h).step_by(step).flat_map(|y| (0..w).step_by(step).map(move |x| (x, y)));
        let place = |i: usize| [(i % w) as f32 * dx, (i / w) as f32 * dy, tops[i].max(floor)];
        let mut places: Vec<V3> = tiles.filter_map(|(x, y)| highest(x, y)).map(place).collect();
        let corners = [[0.0, 0.0], [e, 0.0], [0.0, s], [e, s]];
        if stage.block {
            let foot = stage.foot();
            places.extend(corners.map(|[x, y]| [x, y, foot]));
            places.extend(corners.map(|[x, y]| [x, y, stage.height_at(x, y).max(floor)]));
        } else if places.is_empty() {
            // An open sea without land is seen as far as the grid goes.
            places.extend(corners.map(|[x, y]| [x, y, 0.0]));
        }
        let middle = std::array::from_fn(|k| {
            let (low, high) =
                places.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            0.5 * (low + high)
        });
        Self { places, middle }
    }
}

impl Stage {
    /// `pose` moved along its own axes, so that a picture of so many columns a row shows all of a relief model, or the land and shoals of an open
    /// sea, as large as it can. Direction and angle of view stay.
    pub(crate) fn framed(&self, pose: &Pose, aspect: f32) -> Pose {
        let (places, middle) = (&self.subject.places, self.subject.middle);
        let camera = self.camera_towards(pose);
        let ([right, up, forward], aspect) = ([camera.right, camera.up, camera.forward], aspect.clamp(0.01, 100.0));
        let (across, over, under) =
            (camera.tan * aspect * (1.0 - SIDES), camera.tan * (1.0 - ABOVE), camera.tan * (1.0 - BELOW));
        let bounds = |p: V3| {
            let p = add(p, scale(middle, -1.0));
            let [r, u, f] = [right, up, forward].map(|axis| dot(axis, p));
            Bounds { left: r + across * f, right: r - across * f, bottom: u + under * f, top: u - over * f, near: f }
        };
        let b = places.par_iter().map(|p| bounds(*p)).reduce(|| Bounds::NOTHING, Bounds::and);
        // The eye, seen from the middle, at (r, u, f): b.right + across f <= r <= b.left - across f, and likewise for u.
        let back = ((b.left - b.right) / (2.0 * across)).min((b.bottom - b.top) / (over + under));
        // No peak comes nearer than a third of the way to the middle.
        let back = back.min(1.5 * b.near).min(-1e-6 * self.extent);
        let mut r = 0.5 * (b.left + b.right);
        let mut u = 0.5 * ((b.top + over * back) + (b.bottom - under * back));
        // A picture that is wider or higher than the land needs leaves a choice: what is seen on both sides of its middle is as long.
        for _ in 0..3 {
            let seen = |p: V3| {
                let p = add(p, scale(middle, -1.0));
                let deep = (dot(forward, p) - back).max(1e-6 * self.extent);
                let [x, y] = [(dot(right, p) - r) / deep, (dot(up, p) - u) / deep];
                [x, y, -x, -y]
            };
            let most = |a: [f32; 4], b: [f32; 4]| -> [f32; 4] { std::array::from_fn(|k| a[k].max(b[k])) };
            let [east, top, west, bottom] = places.par_iter().map(|p| seen(*p)).reduce(|| [f32::NEG_INFINITY; 4], most);
            if ![east, top, west, bottom].iter().all(|v| v.is_finite()) {
                break;
            }
            r -= 0.5 * (east - west) * back;
            u -= (top * under - bottom * over) / (over + under) * back;
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

    /// The pose for a whole turn around the land that no part of it leaves: around its middle, from so far that every side of it fits.
    pub(crate) fn framed_all_around(&self, pose: &Pose, aspect: f32) -> Pose {
        const TURNS: usize = 24;
        let (size, middle) = (self.size_m(), self.subject.middle);
        let turned = |i: usize| Pose { azimuth_deg: pose.azimuth_deg + 360.0 * i as f32 / TURNS as f32, ..*pose };
        let needed = |i: usize| {
            let camera = self.camera_towards(&turned(i));
            let [across, over, under] =
                [aspect.clamp(0.01, 100.0) * (1.0 - SIDES), 1.0 - ABOVE, 1.0 - BELOW].map(|share| camera.tan * share);
            // Seen from the distance D, a place lies `D + f` deep in the picture.
            let far = |p: &V3| {
                let p = add(*p, scale(middle, -1.0));
                let [r, u, f] = [camera.right, camera.up, camera.forward].map(|axis| dot(axis, p));
                (r.abs() / across).max(u / over).max(-u / under) - f
            };
            self.subject.places.par_iter().map(far).reduce(|| 0.0, f32::max)
        };
        let distance = (0..TURNS).map(needed).fold(0.0, f32::max) / self.extent;
        let framed = Pose {
            target: [middle[0] / size[0], middle[1] / size[1]],
            target_height: self.share_of_height(middle[2]),
            distance,
            ..*pose
        };
        if distance.is_finite() && distance > 0.0 { framed } else { *pose }
    }

    /// A camera with the axes and the angle of view of a pose.
    fn camera_towards(&self, pose: &Pose) -> crate::camera::Camera {
        let back = direction(pose.azimuth_deg, pose.elevation_deg.clamp(1.0, 89.0));
        crate::camera::Camera::looking(back, [0.0; 3], pose.field_of_view_deg)
    }
}
