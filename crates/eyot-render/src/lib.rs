//! Pictures of Eyot worlds, made on the CPU: perspective views, reliefs from above and maps of layers.

mod albedo;
mod block;
mod ground;
mod light;
mod math;
mod noise;
mod perspective;
mod picture;
mod scene;
mod sea;
mod sky;
mod surface;
mod view;
mod water;

pub use albedo::terrain_colours;
pub use perspective::perspective;
pub use picture::Picture;
pub use view::{Setting, ViewOptions};
