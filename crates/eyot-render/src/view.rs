//! The options of a perspective view and the camera that they describe.

use crate::math::{V3, add, cross, direction, scale, unit};

/// What stands around the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Setting {
    /// Open sea around islands; a block for everything else.
    #[default]
    Auto,
    /// Open sea to the horizon; the ground falls off to deep water beyond the rim.
    OpenSea,
    /// A relief model: a solid block with cut sides on a neutral ground.
    Block,
}

/// How a perspective view is taken. Angles in degrees, bearings clockwise from north.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewOptions {
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// Bearing from the target to the camera: 180 looks from the south to the north.
    pub azimuth_deg: f32,
    /// Height of the camera over the horizon as seen from the target, 1 to 89.
    pub elevation_deg: f32,
    /// Distance from target to camera, in lengths of the grid's longer side.
    pub distance: f32,
    /// Angle of view from the picture's bottom to its top, 5 to 120.
    pub field_of_view_deg: f32,
    /// What the camera looks at, as shares of the grid's width and height; 0.5, 0.5 is the middle.
    pub target: [f32; 2],
    /// Height of the target over the sea or over the low end of the land, as a share of the relief.
    pub target_height: f32,
    /// Factor on heights. `None` draws flat land higher so that it reads as land, and mountains as they are.
    pub vertical_exaggeration: Option<f32>,
    /// Bearing of the sun.
    pub sun_azimuth_deg: f32,
    /// Height of the sun over the horizon, 1 to 89.
    pub sun_elevation_deg: f32,
    /// Haze in the air: 0 none, 1 a clear day, 4 a hot afternoon. A block stands in clear air.
    pub haze: f32,
    /// Fair-weather clouds, 0 to 1.
    pub clouds: f32,
    /// Factor on the light of the whole picture.
    pub exposure: f32,
    /// Draw the sea.
    pub sea: bool,
    /// Depth at which the sea's bottom is all but lost, m. `None` takes clear tropical water, scaled down for small worlds.
    pub sea_clarity_m: Option<f32>,
    /// Draw rivers and lakes of the layer `water`.
    pub fresh_water: bool,
    /// What stands around the grid.
    pub setting: Setting,
    /// Samples in pixels with edges, 1 to 16; even pixels take one.
    pub samples: usize,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            azimuth_deg: 205.0,
            elevation_deg: 19.0,
            distance: 1.12,
            field_of_view_deg: 36.0,
            target: [0.5, 0.5],
            target_height: 0.42,
            vertical_exaggeration: None,
            sun_azimuth_deg: 285.0,
            sun_elevation_deg: 36.0,
            haze: 1.0,
            clouds: 0.5,
            exposure: 1.0,
            sea: true,
            sea_clarity_m: None,
            fresh_water: true,
            setting: Setting::Auto,
            samples: 5,
        }
    }
}

/// A pinhole camera in east, south, up metres.
pub(crate) struct Camera {
    pub(crate) eye: V3,
    forward: V3,
    right: V3,
    up: V3,
    /// Length of a pixel at distance 1.
    pub(crate) pixel: f32,
    centre: [f32; 2],
}

impl Camera {
    /// A camera that looks at `target` from `distance_m`; `clearance` is the least height of the eye at a place.
    pub(crate) fn new(o: &ViewOptions, target: V3, distance_m: f32, clearance: impl Fn(V3) -> f32) -> Self {
        let back = direction(finite(o.azimuth_deg, 180.0), finite(o.elevation_deg, 25.0).clamp(1.0, 89.0));
        let mut eye = add(target, scale(back, distance_m));
        eye[2] = eye[2].max(clearance(eye));
        let forward = unit([target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]]);
        // East cross north is up; south counts positive, so the order is turned.
        let right = unit(cross([0.0, 0.0, 1.0], forward));
        let up = cross(forward, right);
        let tan = (0.5 * finite(o.field_of_view_deg, 36.0).clamp(5.0, 120.0)).to_radians().tan();
        let pixel = 2.0 * tan / o.height.max(1) as f32;
        Self { eye, forward, right, up, pixel, centre: [0.5 * o.width as f32, 0.5 * o.height as f32] }
    }

    /// Direction through a point of the picture, in pixels from its top left corner.
    pub(crate) fn ray(&self, x: f32, y: f32) -> V3 {
        let (a, b) = ((x - self.centre[0]) * self.pixel, (self.centre[1] - y) * self.pixel);
        unit(add(self.forward, add(scale(self.right, a), scale(self.up, b))))
    }
}

/// `x`, or `instead` if it is not a number one can work with.
pub(crate) fn finite(x: f32, instead: f32) -> f32 {
    if x.is_finite() { x } else { instead }
}
