//! The limit on memory binds the whole of a conversion or a picture: under the smallest limit that lets it through, it holds no more.

use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::{Boundary, ComponentKinds, Control, Field, Grid, Limits, World};
use eyot_export::convert::{ConvertOptions, convert};
use eyot_export::{Subject, pictures};
use eyot_recipe::{Preset, View};
use eyot_testing::counting::{Counting, held};
use std::path::Path;

#[global_allocator]
static COUNTING: Counting = Counting;

const SIZE: (usize, usize) = (400, 330);
/// What does not grow with the cells: tables of compressors, blocks of files, texts.
const AROUND: usize = 3 << 20;

fn height(x: usize, y: usize) -> f32 {
    80.0 * (x as f32 * 0.03).sin() * (y as f32 * 0.05).cos() + ((x * 7919 + y * 104_729) % 1021) as f32 * 0.02
}

fn limits(bytes: u64) -> Limits {
    Limits { max_bytes: bytes, ..Limits::default() }
}

/// The smallest limit, to a fiftieth, that lets some work through, and what it then holds.
fn smallest(work: &dyn Fn(&Limits) -> Result<(), String>) -> (u64, usize) {
    let (mut low, mut high) = (10_000_u64, 1_u64 << 30);
    work(&limits(high)).unwrap_or_else(|e| panic!("{e}"));
    while high - low > high / 50 {
        let middle = ((low as f64) * (high as f64)).sqrt() as u64;
        match work(&limits(middle.clamp(low + 1, high - 1))) {
            Ok(()) => high = middle.clamp(low + 1, high - 1),
            Err(e) => {
                assert!(e.contains("too large") || e.contains("more than") || e.contains("limit"), "{e}");
                low = middle.clamp(low + 1, high - 1);
            }
        }
    }
    (high, held(|| work(&limits(high)).unwrap()).0)
}

/// All in one test: what others do at the same time would be counted, too.
#[test]
fn the_limit_on_memory_binds_conversions_meshes_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let grid = Grid::new(SIZE.0, SIZE.1, 20.0, Boundary::OPEN, &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    world.put(&HEIGHT, Field::from_fn(SIZE.0, SIZE.1, height)).unwrap();
    world.put(&WATER, Field::new(SIZE.0, SIZE.1, 0.1)).unwrap();
    let kinds = ComponentKinds::core();
    let go = |from: &Path, to: &Path, preset: Option<Preset>, limits: &Limits| {
        let options = ConvertOptions { preset, force: true, ..ConvertOptions::default() };
        convert(from, to, &options, limits, &kinds).map(drop).map_err(|e| e.to_string())
    };
    let about = eyot_io::About { name: "height".into(), unit: "m".into(), ..eyot_io::About::default() };
    let field = Field::from_fn(SIZE.0, SIZE.1, height);
    let write = eyot_io::WriteOptions::default();
    eyot_io::write_rows(&at("in.tif"), &mut &field, &about, eyot_io::RasterFormat::GeoTiff, &write).unwrap();
    let mut found = Vec::new();
    let mut compare = |what: String, (limit, most): (u64, usize)| {
        println!("{what}: {:.1} MB held within {:.1} MB", most as f64 * 1e-6, limit as f64 * 1e-6);
        if most as u64 > limit + AROUND as u64 {
            found.push(format!("{what} held {most} bytes within a limit of {limit}"));
        }
    };
    let formats = ["tif", "npy", "png", "r16", "r32", "exr", "zarr"];
    for format in formats.into_iter().chain(["glb", "obj"]) {
        let out = at(&format!("out.{format}"));
        compare(format!("tif to {format}"), smallest(&|limits| go(&at("in.tif"), &out, None, limits)));
    }
    for format in formats {
        let from = at(&format!("out.{format}"));
        compare(format!("{format} to tif"), smallest(&|limits| go(&from, &at("back.tif"), None, limits)));
    }
    for preset in [Preset::Gis, Preset::Unity, Preset::Unreal, Preset::Godot, Preset::Blender] {
        let out = at(&format!("{preset:?}"));
        compare(format!("preset {preset:?}"), smallest(&|limits| go(&at("in.tif"), &out, Some(preset), limits)));
    }
    let view = View { size: [320, 200], ..View::default() };
    for subject in [Subject::View, Subject::Relief, Subject::ReliefAt(1500), Subject::Layer("height")] {
        let draw = |limits: &Limits| {
            let drawn = pictures::draw(&world, &view, subject, limits, &Control::none());
            drawn.map(drop).map_err(|e| e.to_string())
        };
        let (limit, most) = smallest(&draw);
        // The world was there before.
        let world: usize = world.layers().iter().map(|l| l.field.bytes()).sum();
        compare(format!("picture {subject:?}"), (limit, most + world));
    }
    assert!(found.is_empty(), "{found:#?}");
}
