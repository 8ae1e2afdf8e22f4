//! Exports by recipes and presets: exact sizes, scales and orders, and nothing lost.

use crate::common;

use common::{json, parse, raster, run};
use eyot::{Limits, Overrides, Preset, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_io::{ReadOptions, read_raster};
use serde_json::Value;
use std::path::Path;

const LAND: &str = r#"
    name = "Hill"
    seed = 7
    [grid]
    size = [300, 200]
    cell = 20.0
    [[step]]
    generate = "cone"
    height = 900.0
    [[step]]
    generate = "fbm"
    [view]
    enabled = false
"#;

fn complaints(more: &str) -> String {
    parse(LAND, &[more], Overrides::default(), &Limits::default()).err().unwrap_or_default()
}

fn made(out: &Path, exports: &[&str], presets: &[Preset]) -> World {
    let overrides = Overrides { presets: presets.to_vec(), ..Overrides::default() };
    run(parse(LAND, exports, overrides, &Limits::default()).unwrap(), out)
}

#[test]
fn every_format_of_a_recipe_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let formats = ["png16", "geotiff", "r32", "r16", "exr", "npy", "zarr", "glb", "obj"];
    let mut exports: Vec<String> = formats.iter().map(|f| format!("format = \"{f}\"")).collect();
    exports.extend(["splat", "map"].map(|what| format!("what = \"{what}\"")));
    exports.push("what = \"mask\"\nlayers = [\"grass\", \"rock\"]".to_owned());
    // The shares of the ground as floats, for research.
    exports.push("format = \"npy\"\nlayers = [\"grass\", \"rock\", \"sand\", \"snow\"]".to_owned());
    let exports: Vec<&str> = exports.iter().map(String::as_str).collect();
    let world = made(&out, &exports, &[]);
    let field = world.get("height").unwrap();
    for file in ["height.tif", "height.r32", "height.exr", "height.npy", "world.zarr"] {
        let r = raster(&out.join(file));
        assert_eq!(&r.field, field, "{file}");
        assert_eq!(r.cell_m, Some((20.0, 20.0)), "{file}");
    }
    for file in ["height.png", "height.r16"] {
        let (low, high) = field.min_max();
        let step = (high - low) / 65535.0;
        let r = raster(&out.join(file));
        assert!(r.field.iter().zip(field.iter()).all(|(a, b)| (a - b).abs() <= 0.51 * step), "{file}");
    }
    for file in [
        "terrain.glb",
        "terrain.obj",
        "splat.png",
        "splat.png.json",
        "height_map.png",
        "grass_mask.png",
        "rock_mask.png",
    ] {
        assert!(out.join(file).metadata().unwrap().len() > 0, "{file}");
    }
    let root = json(&out.join("world.zarr/zarr.json"));
    let a = &root["attributes"];
    assert_eq!((a["seed"].as_u64(), a["engine_version"].as_str()), (Some(7), Some(eyot::VERSION)));
    assert!(a["recipe"].as_str().unwrap().contains("name = \"Hill\""));
    let shares = ["grass", "rock", "sand", "snow"].map(|m| raster(&out.join(format!("{m}.npy"))));
    assert_eq!((&*shares[1].name, &*shares[1].unit), ("rock", "1"));
    let options = ReadOptions { low_m: Some(0.0), high_m: Some(1.0), ..ReadOptions::default() };
    let mask = read_raster(&out.join("rock_mask.png"), &options, &Limits::default()).unwrap().field;
    for (x, y) in [(0, 0), (150, 100), (299, 199), (20, 77)] {
        let sum: f32 = shares.iter().map(|s| s.field.get(x, y)).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        assert!((mask.get(x, y) - shares[1].field.get(x, y)).abs() < 1.0 / 255.0);
    }
    // A second run into the same folder replaces the store like any file.
    made(&out, &exports, &[]);
}

#[test]
fn unreal_has_its_sizes_scales_and_orders() {
    let folder = tempfile::tempdir().unwrap();
    made(folder.path(), &[], &[Preset::Unreal]);
    let about = json(&folder.path().join("unreal.json"));
    assert_eq!(about["resolution"], serde_json::json!([505, 505]));
    assert_eq!((about["section_size_quads"].as_u64(), about["components"][0].as_u64()), (Some(63), Some(8)));
    let number = |v: &Value| v.as_f64().unwrap();
    // 505 vertices over 299 and 199 cells.
    assert!((number(&about["scale"]["x"]) - 299.0 * 2000.0 / 504.0).abs() < 1e-6);
    assert!((number(&about["scale"]["y"]) - 199.0 * 2000.0 / 504.0).abs() < 1e-6);
    let (low, high) = (number(&about["value_of_0_m"]), number(&about["value_of_65535_m"]));
    // What Unreal makes of a number: (n - 32768) / 128 cm at scale 1, plus the location.
    let z = number(&about["scale"]["z"]);
    let height = |n: f64| ((n - 32768.0) / 128.0 * z + number(&about["location_z_cm"])) / 100.0;
    assert!((height(0.0) - low).abs() < 1e-6 * (high - low) && (height(65535.0) - high).abs() < 1e-6 * (high - low));
    assert!((z / ((high - low) * 0.195_312_5) - 1.0).abs() < 2e-5);

    let raw = std::fs::read(folder.path().join("unreal_height.r16")).unwrap();
    assert_eq!(raw.len(), 2 * 505 * 505);
    let r = raster(&folder.path().join("unreal_height.png"));
    let (x, y) = (100, 30);
    let at = 2 * (y * 505 + x);
    let number = f64::from(u16::from_le_bytes([raw[at], raw[at + 1]]));
    let expected = low + number / 65535.0 * (high - low);
    assert!((f64::from(r.field.get(x, y)) - expected).abs() < 1e-3, "little-endian, north first");
    let masks: Vec<Vec<u8>> = about["weightmaps"]
        .as_array()
        .unwrap()
        .iter()
        .map(|w| {
            let path = folder.path().join(w["file"].as_str().unwrap());
            let o = ReadOptions { low_m: Some(0.0), high_m: Some(255.0), ..ReadOptions::default() };
            read_raster(&path, &o, &Limits::default()).unwrap().field.iter().map(|v| v as u8).collect()
        })
        .collect();
    assert_eq!(masks.len(), 4);
    assert!((0..505 * 505).all(|i| masks.iter().map(|m| u32::from(m[i])).sum::<u32>() == 255));
}

#[test]
fn unity_has_its_size_and_starts_in_the_south() {
    let folder = tempfile::tempdir().unwrap();
    let world = made(folder.path(), &["preset = \"unity\"\nsize = 129"], &[]);
    let about = json(&folder.path().join("unity.json"));
    assert_eq!(about["heightmap"]["resolution"], 129);
    let raw = std::fs::read(folder.path().join("unity_height.raw")).unwrap();
    assert_eq!(raw.len(), 2 * 129 * 129);
    let (low, high) = (about["value_of_0_m"].as_f64().unwrap(), about["value_of_65535_m"].as_f64().unwrap());
    // The first number is the south-west corner, which is a cell of the world.
    let first = low + f64::from(u16::from_le_bytes([raw[0], raw[1]])) / 65535.0 * (high - low);
    let corner = f64::from(world.get("height").unwrap().get(0, 199));
    // Averaged over two cells.
    assert!((first - corner).abs() < 0.05 * (high - low), "{first} {corner}");
    let size = &about["terrain_size_m"];
    assert_eq!((size["x"].as_f64(), size["z"].as_f64()), (Some(299.0 * 20.0), Some(199.0 * 20.0)));
    assert!((size["y"].as_f64().unwrap() - (high - low)).abs() < 1e-9);
    // Our own sidecar brings it back the right way up.
    let r = raster(&folder.path().join("unity_height.raw"));
    assert!((f64::from(r.field.get(0, 128)) - first).abs() < 1e-2);
    assert_eq!(about["splatmap"]["resolution"], 128);
    // North first on request; then Unity has to flip it.
    let flipped = tempfile::tempdir().unwrap();
    made(flipped.path(), &["preset = \"unity\"\nsize = 129\nfirst_row = \"north\""], &[]);
    let north = std::fs::read(flipped.path().join("unity_height.raw")).unwrap();
    assert!(north.chunks(258).eq(raw.chunks(258).rev()));
    let about = json(&flipped.path().join("unity.json"));
    assert_eq!(about["heightmap"]["flip_vertically"], true);
}

#[test]
fn other_presets_write_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let world = made(folder.path(), &[""], &[Preset::Godot, Preset::Blender, Preset::Gis]);
    let field = world.get("height").unwrap();
    assert_eq!(&raster(&folder.path().join("godot_height.exr")).field, field);
    assert_eq!(json(&folder.path().join("godot.json"))["vertex_spacing"], 20.0);
    assert_eq!(&raster(&folder.path().join("blender_height.exr")).field, field);
    // Blender makes attributes of the mesh of these.
    let glb = std::fs::read(folder.path().join("blender_terrain.glb")).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    for mesh in document["meshes"].as_array().unwrap().iter().filter(|m| m["name"] != "water") {
        for name in ["_GRASS", "_ROCK", "_SAND", "_SNOW"] {
            assert!(mesh["primitives"][0]["attributes"][name].is_u64(), "{name}");
        }
    }
    // The recipe's own export has the plain name.
    let r = raster(&folder.path().join("gis_height.tif"));
    assert_eq!(&r.field, field);
    assert!(folder.path().join("height.tif").exists());
}

#[test]
fn wrong_exports_are_named_with_their_place() {
    for (more, part) in [
        ("preset = \"unreal\"\nsize = 512\n", "choose 505, 1009, 2017, 4033, 8129"),
        ("preset = \"godot\"\nsize = 512\n", "keeps the size of the grid"),
        ("size = 505\n", "belongs to presets"),
        ("preset = \"unreal\"\nformat = \"r16\"\n", "one too many"),
        ("preset = \"unity\"\nbytes = \"big\"\n", "no effect with the preset `unity`"),
        ("preset = \"unreal\"\nfirst_row = \"south\"\n", "no effect with the preset `unreal`"),
        ("what = \"map\"\nlayers = [\"rock\"]\n", "no step makes a layer `rock`"),
        ("format = \"r16\"\nrange = [3.0, 1.0]\n", "lower number first"),
        ("what = \"mask\"\nlayers = [\"gras\"]\n", "no step makes a layer `gras`"),
        ("preset = \"unreal\"\nwhat = \"terrain\"\n", "both `what` and `preset` are given"),
        ("format = \"exe\"\n", "did you mean \"exr\""),
        ("format = \"coralsobj\"\n", "help: write\n        what = \"corals\"\n        format = \"obj\""),
        ("format = \"parquet\"\n", "help: write\n        what = \"census\"\n        format = \"parquet\""),
        ("format = \"png\"\n", "add `what`: it may be `splat`, `mask`, `map`, `plots` or `dive`"),
        ("what = \"terrain\"\nformat = \"geotiff\"\n", "it is written as `glb` or `obj`"),
        ("what = \"terain\"\n", "did you mean \"terrain\""),
        ("what = \"corals.colonies\"\n", "no step leaves something that is called `corals.colonies`"),
        ("preset = \"unrael\"\n", "did you mean \"unreal\""),
    ] {
        let e = complaints(more);
        assert!(e.contains(part), "{more}: {e}");
    }
}

/// A grey PNG of a few kilobytes and 900 million cells.
#[test]
fn imports_keep_to_the_memory_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.png");
    let mut e = png::Encoder::new(std::fs::File::create(&path).unwrap(), 30_000, 30_000);
    e.set_color(png::ColorType::Grayscale);
    let mut writer = e.write_header().unwrap();
    // No pixels: the header alone must be enough.
    writer.write_chunk(png::chunk::IDAT, &[]).unwrap();
    drop(writer);
    let text = format!(
        "[grid]\nsize = 64\n[[step]]\ngenerate = \"import\"\nfile = \"{}\"\nlow_m = 0.0\nhigh_m = 9.0\n",
        path.display()
    );
    let source = RecipeSource { name: "a.toml".into(), text, folder: ".".into() };
    let limits = Limits { max_bytes: 500 << 20, ..Limits::default() };
    let e = Recipe::parse(source, Overrides::default(), &Registry::standard(), &limits).err().unwrap().to_string();
    assert!(e.contains("the raster needs 3.4 GiB, the limit is 500.0 MiB"), "{e}");
}

#[test]
fn bare_numbers_are_imported_by_keys() {
    let folder = tempfile::tempdir().unwrap();
    let numbers: Vec<u8> = (0..64u16 * 32).flat_map(|i| (i % 64 * 1000).to_be_bytes()).collect();
    std::fs::write(folder.path().join("bare.bin"), numbers).unwrap();
    let text = "[grid]\nsize = [64, 32]\n[[step]]\ngenerate = \"import\"\nfile = \"bare.bin\"\nlow_m = 0.0\n\
        high_m = 65.535\ncolumns_rows = [64, 32]\nnumbers = \"u16be\"\n";
    let source = RecipeSource { name: "a.toml".into(), text: text.into(), folder: folder.path().to_owned() };
    let recipe = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default());
    let world = Run::start(recipe.unwrap(), RunOptions::default()).unwrap().join().unwrap().world;
    let field = world.get("height").unwrap();
    assert!((0..64).all(|x| (field.get(x, 17) - x as f32).abs() < 1e-3));
}
