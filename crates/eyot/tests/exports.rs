//! Exports by recipes, presets and conversions: exact sizes, scales and orders, and nothing lost.

use eyot::convert::{ConvertOptions, convert};
use eyot::io::{ByteOrder, ReadOptions, RowOrder, Sample, WriteOptions, read_raster};
use eyot::{Limits, Overrides, Preset, Recipe, RecipeSource, Registry, Run, RunOptions};
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

fn recipe(more: &str, presets: &[Preset]) -> Result<Recipe, String> {
    let source = RecipeSource { name: "hill.toml".into(), text: format!("{LAND}{more}"), folder: ".".into() };
    let overrides = Overrides { presets: presets.to_vec(), ..Overrides::default() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).map_err(|p| p.to_string())
}

fn made(out: &Path, more: &str, presets: &[Preset]) -> eyot::World {
    let options = RunOptions { out: Some(out.to_owned()), ..RunOptions::default() };
    Run::start(recipe(more, presets).unwrap(), options).unwrap().join().unwrap().world
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn raster(path: &Path) -> eyot::io::Raster {
    read_raster(path, &ReadOptions::default(), &Limits::default()).unwrap()
}

#[test]
fn every_format_of_a_recipe_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let formats = ["png16", "geotiff", "r32", "r16", "exr", "npy", "zarr", "glb", "obj", "splat", "map"];
    let mut more: String = formats.iter().map(|f| format!("[[export]]\nformat = \"{f}\"\n")).collect();
    more += "[[export]]\nformat = \"mask\"\nlayers = [\"grass\", \"rock\"]\n";
    let world = made(&out, &more, &[]);
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
    // A second run into the same folder replaces the store like any file.
    made(&out, &more, &[]);
}

#[test]
fn unreal_has_its_sizes_scales_and_orders() {
    let folder = tempfile::tempdir().unwrap();
    made(folder.path(), "", &[Preset::Unreal]);
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
    let world = made(folder.path(), "[[export]]\npreset = \"unity\"\nsize = 129\n", &[]);
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
}

#[test]
fn other_presets_write_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let world = made(folder.path(), "[[export]]\n", &[Preset::Godot, Preset::Blender, Preset::Gis]);
    let field = world.get("height").unwrap();
    assert_eq!(&raster(&folder.path().join("godot_height.exr")).field, field);
    assert_eq!(json(&folder.path().join("godot.json"))["vertex_spacing"], 20.0);
    assert_eq!(&raster(&folder.path().join("blender_height.exr")).field, field);
    assert!(folder.path().join("blender_terrain.glb").exists());
    // The recipe's own export has the plain name.
    let r = raster(&folder.path().join("gis_height.tif"));
    assert_eq!(&r.field, field);
    assert!(folder.path().join("height.tif").exists());
}

#[test]
fn wrong_exports_are_named_with_their_place() {
    for (more, part) in [
        ("[[export]]\npreset = \"unreal\"\nsize = 512\n", "choose 505, 1009, 2017, 4033, 8129"),
        ("[[export]]\npreset = \"godot\"\nsize = 512\n", "keeps the size of the grid"),
        ("[[export]]\nsize = 505\n", "belongs to presets"),
        ("[[export]]\npreset = \"unreal\"\nformat = \"r16\"\n", "one too many"),
        ("[[export]]\npreset = \"unity\"\nbytes = \"big\"\n", "no effect with the preset `unity`"),
        ("[[export]]\nformat = \"r16\"\nrange = [3.0, 1.0]\n", "lower number first"),
        ("[[export]]\nformat = \"mask\"\nlayers = [\"gras\"]\n", "no step makes a layer `gras`"),
        ("[[export]]\nformat = \"exe\"\n", "did you mean \"exr\""),
        ("[[export]]\npreset = \"unrael\"\n", "did you mean \"unreal\""),
    ] {
        let e = recipe(more, &[]).err().unwrap_or_default();
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

#[test]
fn conversions_go_around_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let limits = Limits::default();
    let real = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/jacksboro.tif");
    let original = raster(&real);
    let go = |from: &Path, to: &Path, o: &ConvertOptions| convert(from, to, o, &limits).unwrap();
    let d = ConvertOptions::default();
    // Through every format of floats and back: values and place to the bit.
    let mut from = real.clone();
    for name in ["a.exr", "b.npy", "c.zarr", "d.r32", "e.tif", "f.exr"] {
        go(&from, &at(name), &d);
        from = at(name);
    }
    let back = raster(&at("f.exr"));
    assert_eq!(back.field, original.field);
    let (a, b) = (back.georeference.unwrap(), original.georeference.clone().unwrap());
    assert_eq!((a.epsg, a.geographic, a.nodata), (b.epsg, b.geographic, b.nodata));
    assert!(a.transform.iter().zip(b.transform).all(|(x, y)| (x - y).abs() < 1e-12));
    let (x, y) = back.cell_m.unwrap();
    let (ox, oy) = original.cell_m.unwrap();
    assert!((x - ox).abs() < 1e-6 && (y - oy).abs() < 1e-6, "{x} {ox}");
    // Through every format of 16 bits: the numbers stay.
    go(
        &real,
        &at("a.r16"),
        &ConvertOptions { write: WriteOptions { scale: Some((-100.0, 3000.0)), ..d.write.clone() }, ..d.clone() },
    );
    go(&at("a.r16"), &at("b.png"), &d);
    go(&at("b.png"), &at("c.tif"), &d);
    let scaled =
        ConvertOptions { write: WriteOptions { scale: Some((-100.0, 3000.0)), ..d.write.clone() }, ..d.clone() };
    go(&at("c.tif"), &at("d.r16"), &scaled);
    go(&at("b.png"), &at("e.r16"), &d);
    let bytes = |name: &str| std::fs::read(at(name)).unwrap();
    assert_eq!(bytes("a.r16"), bytes("e.r16"));
    assert_eq!(bytes("a.r16"), bytes("d.r16"));
    assert_eq!(raster(&at("e.r16")).georeference.unwrap().epsg, Some(4326));
    // Other orders, and back by flags alone.
    let write = WriteOptions { byte_order: ByteOrder::Big, row_order: RowOrder::SouthFirst, ..WriteOptions::default() };
    go(&at("a.r16"), &at("big.r16"), &ConvertOptions { write, ..d.clone() });
    assert_ne!(bytes("big.r16"), bytes("a.r16"));
    std::fs::copy(at("big.r16"), at("bare.bin")).unwrap();
    let read = ReadOptions {
        size: Some((403, 344)),
        sample: Some(Sample::Unsigned(2)),
        byte_order: Some(ByteOrder::Big),
        row_order: Some(RowOrder::SouthFirst),
        low_m: Some(-100.0),
        high_m: Some(3000.0),
        ..ReadOptions::default()
    };
    go(&at("bare.bin"), &at("g.r16"), &ConvertOptions { read, cell_m: Some((5.0, 5.0)), ..d.clone() });
    assert_eq!(bytes("g.r16"), bytes("a.r16"));
    assert_eq!(raster(&at("g.r16")).cell_m, Some((5.0, 5.0)));
    // Meshes and presets.
    let done = go(&real, &at("unity"), &ConvertOptions { preset: Some(Preset::Unity), ..d.clone() });
    assert!(done.notes.iter().any(|n| n.contains("unity takes 513 x 513")), "{:?}", done.notes);
    assert!(at("unity/unity_height.raw").exists());
    go(&real, &at("m.obj"), &d);
    let itself = convert(&at("a.r16"), &at("a.r16"), &d, &limits).unwrap_err().to_string();
    assert!(itself.contains("over itself"), "{itself}");
    assert!(convert(&real, &at("m.xyz"), &d, &limits).unwrap_err().to_string().contains(".zarr"));
}
