//! Pictures of Eyot worlds, made on the CPU: perspective views, reliefs from above and maps of layers.

mod albedo;
mod block;
mod colour_map;
mod ground;
mod hillshade;
mod legend;
mod light;
mod map;
mod math;
mod noise;
mod perspective;
mod picture;
mod relief;
mod resample;
mod scene;
mod sea;
mod sky;
mod surface;
mod text;
mod view;
mod water;

pub use albedo::terrain_colours;
pub use colour_map::ColourMap;
pub use map::{MapOptions, layer_map};
pub use perspective::perspective;
pub use picture::Picture;
pub use relief::{ReliefOptions, relief};
pub use view::{Setting, ViewOptions};
