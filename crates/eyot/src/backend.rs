//! The one place that says which crates read, write, draw and analyse.
//!
//! `render` is a stand-in until all of the real one is merged. To swap, remove the module and add
//! `eyot_render as render` to the list.

pub(crate) use {eyot_io as io, eyot_land::analyse, eyot_mesh as mesh};

use std::io::Write;
use std::path::Path;

/// Writes a text file, whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> io::Result<()> {
    let fail = |source| io::Error::Io { path: path.to_owned(), action: "write", source };
    io::write_atomically(path, |w| w.write_all(text.as_bytes()).map_err(fail))
}

/// Grey pictures with the signatures of the real crate.
#[allow(unreachable_pub, reason = "stand-ins look like the real thing")]
pub(crate) mod render {
    use eyot_core::{Result, World};

    pub struct Picture {
        pub width: usize,
        pub height: usize,
        pub pixels: Vec<[u8; 3]>,
    }

    #[derive(Default)]
    #[allow(dead_code, reason = "the stand-in looks at nothing")]
    pub struct ViewOptions {
        pub width: usize,
        pub height: usize,
        pub azimuth_deg: f32,
        pub elevation_deg: Option<f32>,
        pub distance: Option<f32>,
        pub field_of_view_deg: f32,
        pub vertical_exaggeration: Option<f32>,
        pub sun_azimuth_deg: f32,
        pub sun_elevation_deg: f32,
        pub samples: usize,
    }

    #[derive(Default)]
    #[allow(dead_code, reason = "the stand-in looks at nothing")]
    pub struct ReliefOptions {
        pub max_size: usize,
        pub vertical_exaggeration: Option<f32>,
        pub sun_azimuth_deg: f32,
        pub sun_elevation_deg: f32,
        pub sea: bool,
    }

    #[derive(Default)]
    pub struct MapOptions {}

    pub fn perspective(world: &World, o: &ViewOptions) -> Result<Picture> {
        world.layer("height")?;
        Ok(Picture { width: o.width, height: o.height, pixels: vec![[90, 120, 90]; o.width * o.height] })
    }

    pub fn relief(world: &World, _o: &ReliefOptions) -> Result<Picture> {
        layer_map(world, "height", &MapOptions {})
    }

    pub fn layer_map(world: &World, name: &str, _o: &MapOptions) -> Result<Picture> {
        let field = &world.layer(name)?.field;
        let (lo, hi) = field.min_max();
        let grey = |v: f32| [((v - lo) / (hi - lo).max(1e-30) * 255.0) as u8; 3];
        Ok(Picture { width: field.width(), height: field.height(), pixels: field.iter().map(grey).collect() })
    }

    pub fn terrain_colours(world: &World) -> Result<Vec<[f32; 3]>> {
        world.layer("height")?;
        Ok(vec![[0.5, 0.5, 0.4]; world.grid.cells()])
    }
}
