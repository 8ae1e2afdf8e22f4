//! Paths of a camera: orbits, flights and key frames, with smooth motion between them.

use crate::math::smoothstep;
use crate::stage::Stage;
use crate::view::ViewOptions;

/// Where a camera stands, seen from what it looks at: the same words as [`ViewOptions`]. It fits worlds of any size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Bearing from the target to the camera, degrees clockwise from north; beyond 360 it turns on.
    pub azimuth_deg: f32,
    /// Height of the camera over the horizon as seen from the target, 1 to 89 degrees.
    pub elevation_deg: f32,
    /// Distance from target to camera, in lengths of the grid's longer side.
    pub distance: f32,
    /// What the camera looks at, as shares of the grid's width and height.
    pub target: [f32; 2],
    /// Height of the target over the sea or over the low end of the land, as a share of the relief.
    pub target_height: f32,
    /// Angle of view from the picture's bottom to its top, 5 to 120 degrees.
    pub field_of_view_deg: f32,
}

impl Pose {
    fn values(&self) -> [f32; 7] {
        let [u, v] = self.target;
        [self.azimuth_deg, self.elevation_deg, self.distance, u, v, self.target_height, self.field_of_view_deg]
    }

    fn of(v: [f32; 7]) -> Self {
        Self {
            azimuth_deg: v[0],
            elevation_deg: v[1],
            distance: v[2],
            target: [v[3], v[4]],
            target_height: v[5],
            field_of_view_deg: v[6],
        }
    }
}

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Seconds from the start, or any other even measure.
    pub time: f32,
    /// The pose.
    pub pose: Pose,
}

/// A path through key frames: at least one, their times rising.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// The keys.
    pub keys: Vec<Key>,
    /// The last key is the first again (but for whole turns of the bearing), and the motion goes on through it.
    pub closed: bool,
}

impl CameraPath {
    /// Where `o` puts the camera, all the time.
    pub fn still(stage: &Stage, o: &ViewOptions) -> Self {
        Self { keys: vec![Key { time: 0.0, pose: stage.pose(o) }], closed: false }
    }

    /// Once around the target of `o`, clockwise as seen from above.
    pub fn orbit(stage: &Stage, o: &ViewOptions) -> Self {
        let from = stage.pose_all_around(o);
        let key = |i: u32| {
            let share = i as f32 / 4.0;
            Key { time: share, pose: Pose { azimuth_deg: from.azimuth_deg + 360.0 * share, ..from } }
        };
        Self { keys: (0..=4).map(key).collect(), closed: true }
    }

    /// A flight around and over the land, low over the shores and clear of the mountains; closed.
    pub fn fly(stage: &Stage, o: &ViewOptions) -> Self {
        const KEYS: usize = 32;
        let start = stage.pose(o);
        let size = stage.size_m();
        let place = |turn: f32, reach: f32| {
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            [size[0] * (0.5 + reach * sin), size[1] * (0.5 - reach * cos)]
        };
        let base = start.azimuth_deg / 360.0;
        // Far out at the start, close in half way round.
        let reach = |t: f32| 0.46 - 0.18 * smoothstep(0.0, 1.0, 1.0 - (2.0 * t - 1.0).abs());
        let relief = stage.height_of_share(1.0) - stage.height_of_share(0.0);
        // The highest ground within an eighth of the way, so that the flight rises before the mountain does.
        let ground = |t: f32| {
            let near = (-8..=8).map(|k| t + k as f32 / 128.0);
            let over = near.map(|t| {
                let [x, y] = place(base + t, reach(t.rem_euclid(1.0)));
                stage.height_at(x, y)
            });
            over.fold(stage.height_of_share(0.0), f32::max)
        };
        let lifts: Vec<f32> = (0..KEYS).map(|i| ground(i as f32 / KEYS as f32)).collect();
        let eye_height = |i: usize| {
            let smooth: f32 = (0..5).map(|k| lifts[(i + KEYS + k - 2) % KEYS]).sum::<f32>() / 5.0;
            smooth.max(lifts[i % KEYS]) + 0.16 * relief + 0.015 * stage.extent
        };
        let mut keys: Vec<Key> = Vec::new();
        for i in 0..=KEYS {
            let t = i as f32 / KEYS as f32;
            let [x, y] = place(base + t, reach(t.rem_euclid(1.0)));
            // Looks ahead and inward.
            let [tx, ty] = place(base + t + 0.16, 0.11);
            let share = 0.35;
            let way = [x - tx, y - ty, eye_height(i) - stage.height_of_share(share)];
            let distance = way.iter().map(|w| w * w).sum::<f32>().sqrt();
            let azimuth = way[0].atan2(-way[1]).to_degrees();
            // Goes on turning instead of jumping back by a turn.
            let before = keys.last().map_or(start.azimuth_deg, |k| k.pose.azimuth_deg);
            let azimuth = azimuth + 360.0 * ((before - azimuth) / 360.0).round();
            let pose = Pose {
                azimuth_deg: azimuth,
                elevation_deg: (way[2] / distance).asin().to_degrees().clamp(1.0, 89.0),
                distance: distance / stage.extent,
                target: [tx / size[0], ty / size[1]],
                target_height: share,
                field_of_view_deg: start.field_of_view_deg.max(45.0),
            };
            keys.push(Key { time: t, pose });
        }
        Self { keys, closed: true }
    }

    /// From the first key's time to the last one's.
    pub fn duration(&self) -> f32 {
        match (self.keys.first(), self.keys.last()) {
            (Some(a), Some(b)) => b.time - a.time,
            _ => 0.0,
        }
    }

    /// The pose at a share 0..1 of the whole: cubic between keys, through every key, with a steady velocity (Catmull and Rom 1974,
    /// in Hermite's form for uneven times).
    ///
    /// # Panics
    /// If there is no key.
    pub fn pose(&self, share: f32) -> Pose {
        let keys = &self.keys;
        let last = keys.len() - 1;
        if last == 0 {
            return keys[0].pose;
        }
        let time = keys[0].time + share.clamp(0.0, 1.0) * self.duration();
        let i = keys.partition_point(|k| k.time <= time).clamp(1, last) - 1;
        let span = keys[i + 1].time - keys[i].time;
        let t = if span > 0.0 { (time - keys[i].time) / span } else { 0.0 };
        let (a, b) = (keys[i].pose.values(), keys[i + 1].pose.values());
        let (va, vb) = (self.velocity(i), self.velocity(i + 1));
        let (t2, t3) = (t * t, t * t * t);
        Pose::of(std::array::from_fn(|k| {
            let (h00, h10) = (2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + t);
            let (h01, h11) = (3.0 * t2 - 2.0 * t3, t3 - t2);
            h00 * a[k] + h10 * span * va[k] + h01 * b[k] + h11 * span * vb[k]
        }))
    }

    /// Velocity at a key: of the way between its neighbours; at the ends of an open path the camera rests.
    fn velocity(&self, i: usize) -> [f32; 7] {
        let last = self.keys.len() - 1;
        let at = |i: usize| (self.keys[i].time, self.keys[i].pose.values());
        let end = i == 0 || i == last;
        if end && !self.closed {
            return [0.0; 7];
        }
        let (before, here, after) = if end { (at(last - 1), at(last), at(1)) } else { (at(i - 1), at(i), at(i + 1)) };
        // Through the seam of a closed path, times and bearings go on from the last key.
        let first = at(0);
        let (past, next): ([f32; 7], [f32; 7]) = if end {
            (std::array::from_fn(|k| here.1[k] - before.1[k]), std::array::from_fn(|k| after.1[k] - first.1[k]))
        } else {
            (std::array::from_fn(|k| here.1[k] - before.1[k]), std::array::from_fn(|k| after.1[k] - here.1[k]))
        };
        let time = (here.0 - before.0) + if end { after.0 - first.0 } else { after.0 - here.0 };
        std::array::from_fn(|k| if time > 0.0 { (past[k] + next[k]) / time } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(azimuth_deg: f32, distance: f32) -> Pose {
        Pose {
            azimuth_deg,
            elevation_deg: 20.0,
            distance,
            target: [0.5, 0.5],
            target_height: 0.2,
            field_of_view_deg: 40.0,
        }
    }

    fn path(closed: bool) -> CameraPath {
        let keys = [(0.0, 10.0, 1.0), (1.0, 100.0, 0.6), (3.0, 180.0, 0.7), (4.0, 370.0, 1.0)];
        CameraPath { keys: keys.iter().map(|&(time, a, d)| Key { time, pose: pose(a, d) }).collect(), closed }
    }

    #[test]
    fn it_passes_through_its_keys_without_jumps_or_kinks() {
        for closed in [false, true] {
            let p = path(closed);
            for k in &p.keys {
                let at = p.pose(k.time / 4.0);
                assert!(
                    (at.azimuth_deg - k.pose.azimuth_deg).abs() < 1e-3 && (at.distance - k.pose.distance).abs() < 1e-5
                );
            }
            let n = 4000;
            let a: Vec<f32> = (0..=n).map(|i| p.pose(i as f32 / n as f32).azimuth_deg).collect();
            let speed: Vec<f32> = a.windows(2).map(|w| w[1] - w[0]).collect();
            assert!(speed.windows(2).all(|w| (w[1] - w[0]).abs() < 0.01), "a kink");
            let seam = (speed[0] - speed[n - 1]).abs();
            assert!(if closed { seam < 0.01 } else { speed[0].abs() < 0.01 && speed[n - 1].abs() < 0.01 });
        }
    }

    #[test]
    fn a_single_key_stands_still() {
        let p = CameraPath { keys: vec![Key { time: 3.0, pose: pose(1.0, 2.0) }], closed: false };
        assert_eq!((p.pose(0.0), p.pose(1.0)), (pose(1.0, 2.0), pose(1.0, 2.0)));
    }
}
