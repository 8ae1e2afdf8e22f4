//! Cameras: where a view is taken from.

use crate::math::{V3, add, cross, scale, unit};

/// A pinhole camera in metres east, south and up, from the grid's north-west node and from the sea (or the world's zero).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: V3,
    /// Unit vector to the middle of the picture.
    pub forward: V3,
    /// Unit vector to the right of the picture.
    pub right: V3,
    /// Unit vector to the top of the picture.
    pub up: V3,
    /// Tangent of half the angle of view from the picture's bottom to its top.
    pub tan: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, its horizon level. The angle of view goes from the bottom to the top, 5 to 120.
    pub fn looking(eye: V3, target: V3, field_of_view_deg: f32) -> Self {
        let forward = unit([target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]]);
        // East cross north is up; south counts positive, so the order is turned.
        let right = unit(cross([0.0, 0.0, 1.0], forward));
        let up = cross(forward, right);
        let tan = (0.5 * field_of_view_deg.clamp(5.0, 120.0)).to_radians().tan();
        Self { eye, forward, right, up, tan }
    }

    /// Length of a pixel at distance 1 in a picture of so many rows.
    pub fn pixel(&self, rows: usize) -> f32 {
        2.0 * self.tan / rows.max(1) as f32
    }

    /// Direction through a point of a picture of `size` (columns, rows), in pixels from its top left corner.
    pub fn ray(&self, x: f32, y: f32, size: [usize; 2]) -> V3 {
        let pixel = self.pixel(size[1]);
        let (a, b) = ((x - 0.5 * size[0] as f32) * pixel, (0.5 * size[1] as f32 - y) * pixel);
        unit(add(self.forward, add(scale(self.right, a), scale(self.up, b))))
    }
}
