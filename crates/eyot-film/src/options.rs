//! What a film is told, and what it tells.

use crate::artist::ViewRequest;
use crate::video::Video;
use eyot_core::World;
use eyot_core::remedy::Remedy;
use std::path::{Path, PathBuf};

/// The way of the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FilmPath {
    /// Once around the land.
    Orbit,
    /// A flight around and over the land.
    Fly,
    /// The camera stands where the view puts it.
    Still,
    /// No camera: reliefs of the land from above, north up, drawn by the processor. They are as large as the view's size allows in the
    /// map's own shape, with even sides.
    Above,
    /// Key frames from a TOML file.
    File(PathBuf),
}

/// How a film is made.
#[derive(Clone, Debug)]
pub struct FilmOptions {
    /// Camera at the start, sun, size, colours and engine.
    pub request: ViewRequest,
    /// The way of the camera.
    pub path: FilmPath,
    /// Pictures; 1 to [`MAX_FRAMES`]. `None` takes ten seconds, or the time that a file of key frames names; of a recording,
    /// as many as it would have frames if none had been dropped.
    pub frames: Option<u32>,
    /// Pictures a second, 1 to 240.
    pub fps: f32,
    /// Which video is made of the pictures if ffmpeg is there.
    pub video: Video,
    /// Whether a film of something else in the folder may be overwritten.
    pub restart: bool,
}

/// Most pictures of a film.
pub const MAX_FRAMES: u32 = 100_000;

/// How far a film is.
#[derive(Clone, Debug)]
pub struct FilmProgress {
    /// Pictures that are there.
    pub done: u32,
    /// Pictures in all.
    pub frames: u32,
    /// Seconds that the rest will take, once there is something to tell it from.
    pub seconds_left: Option<f64>,
    /// The engine that draws.
    pub engine: String,
}

/// A finished film.
#[derive(Clone, Debug)]
pub struct Filmed {
    /// Pictures that were drawn now; the others were there.
    pub drawn: u32,
    /// Pictures in all.
    pub frames: u32,
    /// The video, if one was made.
    pub video: Option<PathBuf>,
    /// Things to know.
    pub notes: Vec<Remedy>,
}

/// What a film shows.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Subject<'a> {
    /// A world, which stands still.
    World(&'a World),
    /// The finished run in a folder: its recipe is carried out again, by the processor, and the pictures show the land from the
    /// first step of its simulations to the last.
    Run(&'a Path),
    /// The recording in the folder of a run, which may be at work or have ended early: each picture shows the last frame that can be
    /// read and is no later than its moment.
    Recording(&'a Path),
}
