//! Thousands of damaged files: whatever happens to the bytes, reading ends with a raster or an error.
//!
//! `EYOT_MUTATIONS` sets how many files of each kind are tried.

use eyot_core::{Boundary, Field, Georeference, Grid, Limits, World, layer::known};
use eyot_io::{RasterFormat, ReadOptions, checkpoint, read_raster, write_layer};
use std::path::Path;

/// SplitMix64: any generator would do, this one needs no crate.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Flips, overwrites with numbers that headers dislike, cuts, repeats.
fn mutate(bytes: &mut Vec<u8>, r: &mut Random) {
    const NASTY: [u32; 8] = [0, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0xffff, 0x1_0000, 200_000];
    for _ in 0..=r.below(3) {
        if bytes.is_empty() {
            return;
        }
        // Headers and directories sit at the start; half of the damage goes there.
        let span = if r.below(2) == 0 { bytes.len().min(600) } else { bytes.len() };
        let at = r.below(span);
        match r.below(6) {
            0 => bytes[at] ^= 1 << r.below(8),
            1 => bytes[at] = r.next() as u8,
            2 => {
                let value = NASTY[r.below(NASTY.len())];
                let nasty = if r.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
                bytes.iter_mut().skip(at).zip(nasty).for_each(|(b, n)| *b = n);
            }
            3 => bytes.truncate(at),
            4 => {
                let piece = bytes[at..(at + 16).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
            _ => {
                let end = (at + 1 + r.below(8)).min(bytes.len());
                bytes.drain(at..end);
            }
        }
    }
}

fn world() -> World {
    let mut world = World::new(Grid::new(70, 40, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
    world.georeference = Some(Georeference {
        transform: [5e5, 10.0, 0.0, 4e6, 0.0, -10.0],
        epsg: Some(32611),
        geographic: false,
        nodata: Some(-1.0),
        ..Georeference::default()
    });
    let field = Field::from_fn(70, 40, |x, y| (x as f32 * 0.3).sin() * 50.0 + y as f32);
    world.put(&known::HEIGHT, field).unwrap();
    world
}

fn rounds() -> usize {
    std::env::var("EYOT_MUTATIONS").ok().and_then(|n| n.parse().ok()).unwrap_or(2000)
}

/// Tries `read` on damaged copies of `original`.
fn batter(original: &[u8], path: &Path, seed: u64, read: impl Fn(&Path)) {
    let mut r = Random(seed);
    for _ in 0..rounds() {
        let mut bytes = original.to_vec();
        mutate(&mut bytes, &mut r);
        std::fs::write(path, &bytes).unwrap();
        read(path);
    }
}

fn tight() -> Limits {
    Limits { max_cells: 1 << 22, max_bytes: 256 << 20, ..Limits::default() }
}

fn try_raster(path: &Path) {
    let options = ReadOptions { low_m: Some(0.0), high_m: Some(1.0), ..ReadOptions::default() };
    if let Ok(r) = read_raster(path, &options, &tight()) {
        assert!(r.field.find_not_finite().is_none());
        assert!(r.field.width() > 0 && r.field.height() > 0);
        assert!(r.cell_m.is_none_or(|(x, y)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0), "{:?}", r.cell_m);
    }
}

#[test]
fn damaged_rasters_end_in_a_raster_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    for (i, format) in
        [RasterFormat::GeoTiff, RasterFormat::Png16, RasterFormat::Exr, RasterFormat::Npy].into_iter().enumerate()
    {
        let path = folder.path().join("whole");
        write_layer(&path, &world, &world.layers()[0], format).unwrap();
        let original = std::fs::read(&path).unwrap();
        batter(&original, &folder.path().join("damaged"), i as u64, try_raster);
    }
    let jacksboro = Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif");
    let original = std::fs::read(jacksboro).unwrap();
    batter(&original, &folder.path().join("damaged"), 7, try_raster);
}

#[test]
fn damaged_zarr_metadata_end_in_a_raster_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    let store = folder.path().join("a.zarr");
    write_layer(&store, &world, &world.layers()[0], RasterFormat::Zarr).unwrap();
    for file in ["height/zarr.json", "spatial_ref/zarr.json", "x/zarr.json", "time/zarr.json", "height/c/0/0/0"] {
        let file = store.join(file);
        let original = std::fs::read(&file).unwrap();
        batter(&original, &file, 5, |_| try_raster(&store));
        std::fs::write(&file, original).unwrap();
    }
}

#[test]
fn damaged_descriptions_end_in_a_raster_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let world = world();
    let path = folder.path().join("a.r32");
    write_layer(&path, &world, &world.layers()[0], RasterFormat::R32).unwrap();
    let sidecar = folder.path().join("a.r32.json");
    let original = std::fs::read(&sidecar).unwrap();
    batter(&original, &sidecar, 3, |_| try_raster(&path));
}

#[test]
fn damaged_checkpoints_are_always_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ckpt");
    checkpoint::save(&path, &world(), "seed = 7", &serde_json::Value::Null).unwrap();
    let original = std::fs::read(&path).unwrap();
    batter(&original, &path, 4, |path| {
        let same = std::fs::read(path).unwrap() == original;
        assert_eq!(checkpoint::load(path, &tight(), &eyot_core::ComponentKinds::core()).is_ok(), same);
    });
}
