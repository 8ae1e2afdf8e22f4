//! Key frames of a camera in a TOML file.
//!
//! ```toml
//! closed = false          # whether the last key is the first again
//!
//! [[key]]
//! time = 0.0              # s; without times the keys are evenly spaced
//! azimuth = 205.0         # degrees; 370 goes on from 350 the short way
//! elevation = 15.0
//! distance = 1.06
//! target = [0.5, 0.5]
//! target_height = 0.4
//! field_of_view = 37.0
//!
//! [[key]]
//! time = 4.0
//! distance = 0.5          # what a key leaves out is as in the key before
//! ```

use eyot_render::{CameraPath, Key, Pose};
use eyot_session::RunError;
use serde::Deserialize;
use std::path::Path;

/// Most bytes and keys of a file.
const MOST_BYTES: u64 = 1 << 20;
const MOST_KEYS: usize = 10_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    #[serde(default)]
    closed: bool,
    #[serde(default)]
    key: Vec<KeyFrame>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFrame {
    time: Option<f32>,
    azimuth: Option<f32>,
    elevation: Option<f32>,
    distance: Option<f32>,
    target: Option<[f32; 2]>,
    target_height: Option<f32>,
    field_of_view: Option<f32>,
}

/// Reads and checks a file.
pub(super) fn read(file: &Path) -> Result<Keys, RunError> {
    let refuse = |reason: String| {
        RunError::refused(
            format!("the camera's path `{}`: {reason}", file.display()),
            "write [[key]] tables with time, azimuth, elevation, distance, target, target_height, field_of_view",
        )
    };
    let meta = std::fs::metadata(file).map_err(|e| refuse(e.to_string()))?;
    if !meta.is_file() || meta.len() > MOST_BYTES {
        return Err(refuse(format!("it is no file, or one of more than {} MiB", MOST_BYTES >> 20)));
    }
    let text = std::fs::read_to_string(file).map_err(|e| refuse(e.to_string()))?;
    parse(&text).map_err(refuse)
}

fn parse(text: &str) -> Result<Keys, String> {
    let keys: Keys = toml::from_str(text).map_err(|e| e.to_string().trim_end().to_owned())?;
    if keys.key.is_empty() || keys.key.len() > MOST_KEYS {
        return Err(format!("it has {} keys, where 1 to {MOST_KEYS} make a path", keys.key.len()));
    }
    let timed = keys.key.iter().filter(|k| k.time.is_some()).count();
    if timed != 0 && timed != keys.key.len() {
        return Err("some keys have a time and some have none; give it to all or to none".to_owned());
    }
    for (i, k) in keys.key.iter().enumerate() {
        let [u, v] = k.target.map_or([None; 2], |t| t.map(Some));
        let ranges = [
            ("time", k.time, 0.0, 86_400.0),
            ("azimuth", k.azimuth, -36_000.0, 36_000.0),
            ("elevation", k.elevation, 1.0, 89.0),
            ("distance", k.distance, 0.05, 50.0),
            ("target", u, -10.0, 10.0),
            ("target", v, -10.0, 10.0),
            ("target_height", k.target_height, -10.0, 10.0),
            ("field_of_view", k.field_of_view, 5.0, 120.0),
        ];
        for (name, value, low, high) in ranges {
            if let Some(x) = value.filter(|x| !(low..=high).contains(x)) {
                return Err(format!("{name} of key {} is {x}, where {low} to {high} would be right", i + 1));
            }
        }
        if let (Some(a), Some(b)) = (i.checked_sub(1).and_then(|i| keys.key[i].time), k.time)
            && b <= a
        {
            return Err(format!("key {} comes at {b} s, no later than the one before", i + 1));
        }
    }
    Ok(keys)
}

impl Keys {
    /// The path; `start` is what the first key leaves out.
    pub(super) fn path(&self, start: Pose) -> CameraPath {
        let mut pose = start;
        let key = |(i, k): (usize, &KeyFrame)| {
            pose = Pose {
                azimuth_deg: k.azimuth.unwrap_or(pose.azimuth_deg),
                elevation_deg: k.elevation.unwrap_or(pose.elevation_deg),
                distance: k.distance.unwrap_or(pose.distance),
                target: k.target.unwrap_or(pose.target),
                target_height: k.target_height.unwrap_or(pose.target_height),
                field_of_view_deg: k.field_of_view.unwrap_or(pose.field_of_view_deg),
            };
            Key { time: k.time.unwrap_or(i as f32), pose }
        };
        CameraPath { keys: self.key.iter().enumerate().map(key).collect(), closed: self.closed }
    }

    /// True if the keys say when they come.
    pub(super) fn is_timed(&self) -> bool {
        self.key.iter().all(|k| k.time.is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Pose = Pose {
        azimuth_deg: 205.0,
        elevation_deg: 15.0,
        distance: 1.0,
        target: [0.5, 0.5],
        target_height: 0.4,
        field_of_view_deg: 37.0,
    };

    #[test]
    fn keys_go_on_from_the_one_before() {
        let keys = parse("[[key]]\ntime = 1\ndistance = 2.0\n[[key]]\ntime = 3\nazimuth = 300").unwrap();
        assert!(keys.is_timed());
        let path = keys.path(START);
        assert_eq!(path.keys[0], Key { time: 1.0, pose: Pose { distance: 2.0, ..START } });
        assert_eq!(path.keys[1], Key { time: 3.0, pose: Pose { distance: 2.0, azimuth_deg: 300.0, ..START } });
    }

    #[test]
    fn mistakes_are_named() {
        let cases = [
            ("", "0 keys"),
            ("[[key]]\nheigth = 3", "heigth"),
            ("[[key]]\nelevation = 95", "elevation of key 1"),
            ("[[key]]\ndistance = nan", "distance of key 1"),
            ("[[key]]\ntime = 2\n[[key]]\ntime = 2", "key 2"),
            ("[[key]]\ntime = 2\n[[key]]\nazimuth = 2", "some have none"),
            ("[[key]]\ntarget = [0.5, inf]", "target of key 1"),
        ];
        for (text, part) in cases {
            let e = parse(text).err().unwrap_or_default();
            assert!(e.contains(part), "{text:?}: {e}");
        }
    }
}
