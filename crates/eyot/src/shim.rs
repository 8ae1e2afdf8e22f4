//! The one place that says which crates read, write, draw and analyse.
//!
//! `render` is a stand-in until the real one is merged. To swap, remove it and write
//! `pub(crate) use eyot_render as render;`.
// Stand-ins have more of the real surface than is used.
#![allow(unreachable_pub, dead_code)]

pub(crate) use {eyot_io as io, eyot_land::analyse, eyot_mesh as mesh};

/// Writes a text file, whole or not at all.
pub(crate) fn write_text(path: &std::path::Path, text: &str) -> io::Result<()> {
    use std::io::Write;
    let fail = |source| io::Error::Io { path: path.to_owned(), action: "write", source };
    io::write_atomically(path, |w| w.write_all(text.as_bytes()).map_err(fail))
}

pub(crate) mod render {
    use eyot_core::{Result, World};

    pub struct Picture {
        pub width: usize,
        pub height: usize,
        pub pixels: Vec<[u8; 3]>,
    }
    #[derive(Default)]
    pub struct ViewOptions {
        pub width: usize,
        pub height: usize,
        pub azimuth_deg: f32,
        pub elevation_deg: f32,
        pub distance: f32,
        pub field_of_view_deg: f32,
        pub vertical_exaggeration: Option<f32>,
        pub sun_azimuth_deg: f32,
        pub sun_elevation_deg: f32,
        pub samples: usize,
    }
    #[derive(Default)]
    pub struct ReliefOptions {
        pub vertical_exaggeration: f32,
        pub sun_azimuth_deg: f32,
        pub sun_elevation_deg: f32,
        pub samples: usize,
    }
    #[derive(Default)]
    pub struct MapOptions {}

    pub fn perspective(world: &World, o: &ViewOptions) -> Result<Picture> {
        let _ = (
            o.azimuth_deg,
            o.elevation_deg,
            o.distance,
            o.field_of_view_deg,
            o.vertical_exaggeration,
            o.sun_azimuth_deg,
            o.sun_elevation_deg,
        );
        world.layer("height")?;
        Ok(Picture { width: o.width, height: o.height, pixels: vec![[90, 120, 90]; o.width * o.height] })
    }
    pub fn relief(world: &World, o: &ReliefOptions) -> Result<Picture> {
        let _ = (o.vertical_exaggeration, o.sun_azimuth_deg, o.sun_elevation_deg);
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
