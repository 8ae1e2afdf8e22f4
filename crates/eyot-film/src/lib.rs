//! **Films and views**: pictures of a world from a camera, by the processor's rays or a graphics card.
//!
//! [`draw_view`] makes one picture. [`film`] makes many along a camera's path, of a world that stands still, a run that is done again, or
//! a recording, and a video of them. A film is a folder of numbered PNG files and a `film.json` that says what they show. Each
//! picture appears whole or not at all, so a film that was stopped goes on with the first one that is missing.

mod artist;
#[cfg(feature = "gpu")]
mod card;
#[cfg(not(feature = "gpu"))]
#[path = "no_card.rs"]
mod card;
mod film;
mod folder;
mod map;
mod options;
mod path_file;
mod reel;
mod rerun;
mod video;

pub use artist::{Drawn, ViewRequest, draw_view};
pub use film::film;
pub use options::{FilmOptions, FilmPath, FilmProgress, Filmed, MAX_FRAMES, Subject};
pub use video::Video;
