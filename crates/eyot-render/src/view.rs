//! The options of a perspective view.

use crate::cover::Looks;

/// What stands around the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
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
    /// Height of the camera over the horizon as seen from the target, 1 to 89. `None` looks over an open sea with some
    /// sky above it, and down on a block.
    pub elevation_deg: Option<f32>,
    /// Distance from target to camera, in lengths of the grid's longer side. Without it, a target and its height, the camera stands
    /// where it shows the land as a whole, as large as it can be; with one of them, `None` takes what suits the setting.
    pub distance: Option<f32>,
    /// Angle of view from the picture's bottom to its top, 5 to 120.
    pub field_of_view_deg: f32,
    /// What the camera looks at, as shares of the grid's width and height; 0.5, 0.5 is the middle. `None`: see `distance`.
    pub target: Option<[f32; 2]>,
    /// Height of the target over the sea or over the low end of the land, as a share of the relief.
    /// `None`: see `distance`.
    pub target_height: Option<f32>,
    /// Factor on heights; 1 draws them as they are.
    pub vertical_exaggeration: f32,
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
    /// Colours of the ground.
    pub looks: Looks,
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
            elevation_deg: None,
            distance: None,
            field_of_view_deg: 37.0,
            target: None,
            target_height: None,
            vertical_exaggeration: 1.0,
            sun_azimuth_deg: 285.0,
            sun_elevation_deg: 36.0,
            haze: 1.0,
            clouds: 0.5,
            exposure: 1.0,
            looks: Looks::default(),
            sea: true,
            sea_clarity_m: None,
            fresh_water: true,
            setting: Setting::Auto,
            samples: 5,
        }
    }
}

/// `x`, or `instead` if it is not a number one can work with.
pub(crate) fn finite(x: f32, instead: f32) -> f32 {
    if x.is_finite() { x } else { instead }
}

impl ViewOptions {
    /// Columns a row of the picture.
    pub(crate) fn aspect(&self) -> f32 {
        self.width.max(1) as f32 / self.height.max(1) as f32
    }

    /// The same view of a relief model that wears a layer's colours: without sea and rivers, which would hide them.
    pub fn draped(&self) -> Self {
        Self { sea: false, fresh_water: false, setting: Setting::Block, ..self.clone() }
    }
}
