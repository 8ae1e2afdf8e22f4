//! The one place that says which crates read, write, draw and analyse.
//!
//! Stand-ins with the signatures of the real crates, until those are merged. To swap, replace this file by
//! `pub(crate) use {eyot_io as io, eyot_mesh as mesh, eyot_render as render, eyot_land::analyse as analyse};` and keep `write_text`.
// Stand-ins have more of the real surface than is used.
#![allow(unreachable_pub, dead_code)]

/// Writes a text file, whole or not at all. With the real crate the error is `eyot_io::Error::Io`.
pub(crate) fn write_text(path: &std::path::Path, text: &str) -> io::Result<()> {
    use std::io::Write;
    io::write_atomically(path, |w| w.write_all(text.as_bytes()).map_err(|source| io::Error::Io { path: path.to_owned(), action: "write", source }))
}

pub(crate) mod io {
    use eyot_core::{Field, Georeference, Grid, Layer, LayerSpec, Ledger, Limits, World};
    use std::fmt;
    use std::io::{BufWriter, Write};
    use std::path::Path;

    #[derive(Debug)]
    pub enum Error {
        Io { path: std::path::PathBuf, action: &'static str, source: std::io::Error },
        Other(String),
    }
    pub type Result<T, E = Error> = std::result::Result<T, E>;
    impl fmt::Display for Error {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            match self {
                Self::Io { path, action, source } => write!(f, "cannot {action} `{}`: {source}", path.display()),
                Self::Other(text) => f.write_str(text),
            }
        }
    }
    impl std::error::Error for Error {}
    fn err(path: &Path, e: impl fmt::Display) -> Error {
        Error::Other(format!("`{}`: {e}", path.display()))
    }

    #[derive(Clone, Copy)]
    pub enum RasterFormat {
        Png16,
        GeoTiff,
        R32,
    }

    #[derive(Clone, Debug, Default)]
    pub struct ReadOptions {
        pub low_m: Option<f32>,
        pub high_m: Option<f32>,
    }

    pub struct Raster {
        pub field: Field,
        pub cell_m: Option<(f64, f64)>,
        pub georeference: Option<Georeference>,
        pub filled: usize,
    }

    pub fn write_atomically(path: &Path, write: impl FnOnce(&mut BufWriter<std::fs::File>) -> Result<()>) -> Result<()> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let temporary = tempfile::NamedTempFile::new_in(folder).map_err(|e| err(path, e))?;
        let mut out = BufWriter::new(temporary.reopen().map_err(|e| err(path, e))?);
        write(&mut out)?;
        out.flush().map_err(|e| err(path, e))?;
        out.get_ref().sync_all().map_err(|e| err(path, e))?;
        temporary.persist(path).map_err(|e| err(path, e))?;
        Ok(())
    }

    /// Not a real raster format: width and height as text, then floats.
    pub fn write_layer(path: &Path, _world: &World, layer: &Layer, _format: RasterFormat) -> Result<()> {
        write_atomically(path, |w| {
            let mut bytes = format!("SHIM {} {}\n", layer.field.width(), layer.field.height()).into_bytes();
            layer.field.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
            w.write_all(&bytes).map_err(|e| err(path, e))
        })
    }

    pub fn read_raster(path: &Path, _options: &ReadOptions, limits: &Limits) -> Result<Raster> {
        let bytes = std::fs::read(path).map_err(|e| err(path, e))?;
        let line = bytes.iter().position(|b| *b == b'\n').ok_or_else(|| err(path, "no height map"))?;
        let head = String::from_utf8_lossy(&bytes[..line]).into_owned();
        let words: Vec<usize> = head.split(' ').skip(1).filter_map(|w| w.parse().ok()).collect();
        let &[w, h] = words.as_slice() else { return Err(err(path, "no height map")) };
        limits.check_cells(w, h).map_err(|e| err(path, e))?;
        let values: Vec<f32> = bytes[line + 1..].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let field = Field::from_slice(w, h, &values).map_err(|e| err(path, e))?;
        Ok(Raster { field, cell_m: None, georeference: None, filled: 0 })
    }

    pub fn write_rgb_png(path: &Path, width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<()> {
        write_atomically(path, |w| {
            let head = format!("P6 {width} {height} 255\n");
            w.write_all(head.as_bytes()).and_then(|()| w.write_all(pixels.as_flattened())).map_err(|e| err(path, e))
        })
    }

    pub mod checkpoint {
        use super::*;
        use serde_json::{Value, json};

        pub struct Checkpoint {
            pub world: World,
            pub recipe_toml: String,
            pub state: Value,
            pub engine_version: String,
        }

        pub fn save(path: &Path, world: &World, recipe_toml: &str, state: &Value) -> Result<()> {
            let layers: Vec<Value> = world.layers().iter().map(|l| json!([l.spec, l.field.iter().map(f32::to_bits).collect::<Vec<_>>()])).collect();
            let doc = json!({ "grid": world.grid, "seed": world.seed, "sea": world.sea_level_m, "step": world.step, "ledger": world.ledger,
                "georeference": world.georeference, "layers": layers, "recipe": recipe_toml, "state": state, "version": "0.1.0" });
            write_atomically(path, |w| serde_json::to_writer(w, &doc).map_err(|e| err(path, e)))
        }

        pub fn load(path: &Path, _limits: &Limits) -> Result<Checkpoint> {
            let text = std::fs::read(path).map_err(|e| err(path, e))?;
            let doc: Value = serde_json::from_slice(&text).map_err(|e| err(path, e))?;
            let get = |k: &str| doc[k].clone();
            let grid: Grid = serde_json::from_value(get("grid")).map_err(|e| err(path, e))?;
            let mut world = World::new(grid, doc["seed"].as_u64().unwrap_or(0));
            world.sea_level_m = doc["sea"].as_f64().unwrap_or(0.0);
            world.step = doc["step"].as_u64().unwrap_or(0);
            world.ledger = serde_json::from_value::<Ledger>(get("ledger")).map_err(|e| err(path, e))?;
            world.georeference = serde_json::from_value(get("georeference")).map_err(|e| err(path, e))?;
            let layers: Vec<(LayerSpec, Vec<u32>)> = serde_json::from_value(get("layers")).map_err(|e| err(path, e))?;
            for (spec, bits) in layers {
                let values: Vec<f32> = bits.into_iter().map(f32::from_bits).collect();
                let field = Field::from_slice(grid.width, grid.height, &values).map_err(|e| err(path, e))?;
                world.put(&spec, field).map_err(|e| err(path, e))?;
            }
            let text = |k: &str| doc[k].as_str().unwrap_or("").to_owned();
            Ok(Checkpoint { world, recipe_toml: text("recipe"), state: get("state"), engine_version: text("version") })
        }
    }

    pub fn write_terrain_glb(path: &Path, levels: &[super::mesh::Lod], name: &str) -> Result<()> {
        write_atomically(path, |w| {
            for l in levels {
                write!(w, "{name} {:?} {} {}", l.mesh, l.ratio, l.error_m).map_err(|e| err(path, e))?;
            }
            Ok(())
        })
    }
}

pub(crate) mod mesh {
    use eyot_core::{Field, Grid, Limits};

    #[derive(Clone, Debug)]
    pub struct TerrainMesh {}
    pub struct Lod {
        pub mesh: TerrainMesh,
        pub ratio: f64,
        pub error_m: f32,
    }
    #[derive(Clone, Copy, Default)]
    pub struct MeshOptions {}
    pub struct Terrain {
        pub mesh: TerrainMesh,
    }
    pub fn terrain(_height: &Field, _grid: &Grid, _colours: &[[f32; 3]], _options: &MeshOptions, _limits: &Limits) -> Result<Terrain, eyot_core::Error> {
        Ok(Terrain { mesh: TerrainMesh {} })
    }
    pub fn levels_of_detail(mesh: &TerrainMesh, ratios: &[f64]) -> Vec<Lod> {
        ratios.iter().map(|r| Lod { mesh: mesh.clone(), ratio: *r, error_m: 0.0 }).collect()
    }
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
    }
    #[derive(Default)]
    pub struct ReliefOptions {
        pub vertical_exaggeration: f32,
        pub sun_azimuth_deg: f32,
        pub sun_elevation_deg: f32,
    }
    #[derive(Default)]
    pub struct MapOptions {}

    pub fn perspective(world: &World, o: &ViewOptions) -> Result<Picture> {
        let _ = (o.azimuth_deg, o.elevation_deg, o.distance, o.field_of_view_deg, o.vertical_exaggeration, o.sun_azimuth_deg, o.sun_elevation_deg);
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

pub(crate) mod analyse {
    use eyot_core::{Field, Grid};

    #[derive(serde::Serialize)]
    pub struct TerrainStats {
        lowest_m: f32,
        highest_m: f32,
        mean_m: f64,
        land_share: f64,
        area_km2: f64,
    }
    pub fn terrain_stats(height: &Field, grid: &Grid, sea_level_m: Option<f64>) -> TerrainStats {
        let (lowest_m, highest_m) = height.min_max();
        let n = grid.cells() as f64;
        let land = height.iter().filter(|h| sea_level_m.is_none_or(|s| f64::from(*h) > s)).count();
        TerrainStats { lowest_m, highest_m, mean_m: height.sum() / n, land_share: land as f64 / n, area_km2: n * grid.cell_area_m2() / 1e6 }
    }
}
