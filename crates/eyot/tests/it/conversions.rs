//! `convert`: every pair of formats, all that a file says of itself, and options that cannot apply.

use crate::common;

use common::{json, raster, recipe, run};
use eyot::formats::{ConvertOptions, convert};
use eyot::{Field, Georeference, Limits, Preset, RunError};
use eyot_core::CoordinateSystem;
use eyot_io::{About, ByteOrder, RasterFormat, ReadOptions, RowOrder, Sample, WriteOptions, write_rows, write_store};
use std::path::{Path, PathBuf};

const LAND: &str = "name = \"Hill\"\nseed = 7\n[grid]\nsize = [40, 30]\ncell = 20.0\n[[step]]\ngenerate = \"fbm\"\n\
    [[step]]\ngenerate = \"ramp\"\nlayer = \"share\"\n[view]\nenabled = false\n";

fn go(from: &Path, to: &Path, options: &ConvertOptions) -> Vec<String> {
    // Most of these tests convert to one name again and again.
    let options = &ConvertOptions { force: true, ..options.clone() };
    let done = convert(from, to, options, &Limits::default()).unwrap_or_else(|e| panic!("{from:?} -> {to:?}: {e}"));
    done.notes.iter().map(ToString::to_string).collect()
}

fn refused(from: &Path, to: &Path, options: &ConvertOptions) -> String {
    let options = &ConvertOptions { force: true, ..options.clone() };
    match convert(from, to, options, &Limits::default()) {
        Err(RunError::File(message) | RunError::Input { reason: message, .. }) => message.to_string(),
        other => panic!("{from:?} -> {to:?}: {other:?}"),
    }
}

fn plain() -> ConvertOptions {
    ConvertOptions::default()
}

fn layers(names: &[&str]) -> ConvertOptions {
    ConvertOptions { layers: names.iter().map(|n| (*n).to_owned()).collect(), ..plain() }
}

/// Heights from below the sea to mountains, in numbers that no short decimal makes.
fn heights(w: usize, h: usize) -> Field {
    Field::from_fn(w, h, |x, y| -431.7 + 2876.1 * ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0)
}

/// Rasters of odd sizes here and there.
fn rasters() -> Vec<(&'static str, Field, About)> {
    let about = |cell_m, georeference| About {
        name: "height".to_owned(),
        unit: "m".to_owned(),
        meaning: "Height of the \"ground\" & sea floor, \u{e9}t\u{e9}".to_owned(),
        cell_m,
        georeference,
        tags: [("SOURCE".to_owned(), "USGS <public domain>".to_owned())].into(),
        range: None,
    };
    let place =
        |transform, epsg, geographic, nodata| Some(Georeference { transform, epsg, geographic, nodata, system: None });
    let utm = place([499_980.0, 30.0, 0.0, 4_000_020.0, 0.0, -30.0], Some(32611), false, Some(-32768.0));
    let (s, c) = 0.3f64.sin_cos();
    let turned = place([5e5, 25.0 * c, 25.0 * s, 4e6, 25.0 * s, -25.0 * c], Some(25832), false, None);
    let local = place([-0.1, 0.1, 0.0, 77.3, 0.0, -0.3], None, false, Some(-1.0));
    let degrees = place([-84.41375, 1.0 / 1200.0, 0.0, 36.44625, 0.0, -1.0 / 1200.0], Some(4326), true, None);
    let per_degree = (89_657.265 / 1200.0, 110_967.2 / 1200.0);
    vec![
        ("utm", heights(27, 51), about((30.0, 30.0), utm.clone())),
        ("turned", heights(27, 51), about((25.0, 25.0), turned)),
        ("local", heights(8, 3), about((0.1, 0.3), local)),
        ("degrees", heights(16, 9), about(per_degree, degrees)),
        ("nowhere", heights(51, 27), about((3.0, 5.5), None)),
        ("one", heights(1, 1), about((30.0, 30.0), utm.clone())),
        ("column", heights(1, 7), about((30.0, 30.0), utm)),
        ("row", heights(7, 1), about((2.0, 3.0), None)),
        ("flat", Field::new(5, 4, -3.25), about((2.0, 2.0), None)),
    ]
}

#[test]
fn every_pair_of_formats_keeps_all_that_it_can() {
    let folder = tempfile::tempdir().unwrap();
    for (name, field, about) in rasters() {
        for from in RasterFormat::ALL {
            let source = folder.path().join(format!("{name}-from.{}", from.extension()));
            write_rows(&source, &mut &field, &about, from, &WriteOptions::default()).unwrap();
            let a = raster(&source);
            for to in RasterFormat::ALL {
                let what = format!("{name}: {} -> {}", from.name(), to.name());
                let target = folder.path().join(format!("{name}-{}-to.{}", from.name(), to.extension()));
                assert_eq!(go(&source, &target, &plain()), Vec::<String>::new(), "{what}");
                let b = raster(&target);
                if from.is_quantised() || !to.is_quantised() {
                    assert_eq!(b.field, a.field, "{what}");
                } else {
                    let (low, high) = a.field.min_max();
                    let half = 0.5001 * (f64::from(high) - f64::from(low)) / 65535.0;
                    let off = |(a, b): (f32, f32)| (f64::from(a) - f64::from(b)).abs();
                    let worst = a.field.iter().zip(b.field.iter()).map(off).fold(0.0, f64::max);
                    assert!(worst <= half.max(1e-4), "{what}: {worst} of {half}");
                }
                // A GeoTIFF names a value for missing cells even where none is missing.
                let mut place = b.georeference.clone();
                if let (Some(found), Some(Georeference { nodata: None, .. })) = (&mut place, &about.georeference) {
                    found.nodata = found.nodata.filter(|n| *n != -9999.0);
                }
                assert_eq!(place, about.georeference, "{what}");
                // Cells of geographic grids are measured anew.
                let tolerance = if name == "degrees" { 1e-3 } else { 1e-9 };
                let ((x, y), (ax, ay)) = (b.cell_m.unwrap(), about.cell_m);
                assert!((x / ax - 1.0).abs() < tolerance && (y / ay - 1.0).abs() < tolerance, "{what}: {x} {y}");
                assert_eq!((&b.name, &b.unit), (&about.name, &about.unit), "{what}");
                assert_eq!((&b.meaning, &b.tags), (&about.meaning, &about.tags), "{what}");
            }
        }
    }
}

#[test]
fn every_format_goes_into_every_preset_and_mesh_or_says_why_not() {
    let folder = tempfile::tempdir().unwrap();
    for (name, field, about) in rasters() {
        for from in RasterFormat::ALL {
            let source = folder.path().join(format!("{name}.{}", from.extension()));
            write_rows(&source, &mut &field, &about, from, &WriteOptions::default()).unwrap();
            let narrow = field.width() < 2 || field.height() < 2;
            for preset in [Preset::Unreal, Preset::Unity, Preset::Godot, Preset::Blender, Preset::Gis] {
                // Once is enough for the large ones.
                let large = matches!(preset, Preset::Unreal | Preset::Unity);
                if large && (name, from) != ("utm", RasterFormat::GeoTiff) && !narrow {
                    continue;
                }
                let out = folder.path().join(format!("{name}-{}-{preset:?}", from.name()));
                let options = ConvertOptions { preset: Some(preset), ..plain() };
                if narrow && preset != Preset::Gis {
                    let e = refused(&source, &out, &options);
                    assert!(e.contains("less than 2 x 2 cells") && !out.exists(), "{e}");
                } else {
                    go(&source, &out, &options);
                }
            }
            for mesh in ["glb", "obj"] {
                let out = folder.path().join(format!("{name}-{}.{mesh}", from.name()));
                if narrow {
                    assert!(refused(&source, &out, &plain()).contains("such as .tif"));
                } else {
                    go(&source, &out, &plain());
                }
            }
        }
    }
    let gis = raster(&folder.path().join("utm-npy-Gis/height.tif"));
    assert_eq!((gis.field, gis.georeference.unwrap().nodata), (heights(27, 51), Some(-9999.0)));
}

#[test]
fn conversions_go_around_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let real = Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif");
    let original = raster(&real);
    assert!(original.tags["SOURCE"].contains("SRTM"), "{:?}", original.tags);
    // Through every format of floats and back.
    let mut from = real.clone();
    for name in ["a.exr", "b.npy", "c.zarr", "d.r32", "e.tif", "f.exr"] {
        go(&from, &at(name), &plain());
        from = at(name);
    }
    let back = raster(&at("f.exr"));
    assert_eq!((&back.field, &back.georeference), (&original.field, &original.georeference));
    assert_eq!((&back.unit, &back.tags), (&original.unit, &original.tags));
    // Through every format of 16 bits: the numbers stay.
    let scaled = ConvertOptions { range: Some((-100.0, 3000.0)), ..plain() };
    go(&real, &at("a.r16"), &scaled);
    go(&at("a.r16"), &at("b.png"), &plain());
    go(&at("b.png"), &at("c.tif"), &plain());
    go(&at("c.tif"), &at("d.r16"), &scaled);
    go(&at("b.png"), &at("e.r16"), &plain());
    let bytes = |name: &str| std::fs::read(at(name)).unwrap();
    assert_eq!(bytes("a.r16"), bytes("e.r16"));
    assert_eq!(bytes("a.r16"), bytes("d.r16"));
    // Other orders, and back by flags alone.
    let orders = ConvertOptions { byte_order: Some(ByteOrder::Big), row_order: Some(RowOrder::SouthFirst), ..plain() };
    go(&at("a.r16"), &at("big.r16"), &orders);
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
    go(&at("bare.bin"), &at("g.r16"), &ConvertOptions { read, cell_m: Some((5.0, 5.0)), ..plain() });
    assert_eq!(bytes("g.r16"), bytes("a.r16"));
    assert_eq!(raster(&at("g.r16")).cell_m, Some((5.0, 5.0)));
    // Meshes and presets.
    let notes = go(&real, &at("unity"), &ConvertOptions { preset: Some(Preset::Unity), ..plain() });
    assert!(notes.iter().any(|n| n.contains("unity takes 513 x 513")), "{notes:?}");
    let itself = refused(&at("a.r16"), &at("a.r16"), &plain());
    assert!(itself.contains("over itself"), "{itself}");
    assert!(refused(&real, &at("m.xyz"), &plain()).contains(".zarr"));
}

/// A store of two layers, one with words of its own, as somebody would keep it beside a recipe.
fn store(folder: &Path) -> PathBuf {
    let path = folder.join("two.zarr");
    let (height, water) = (heights(9, 6), heights(9, 6));
    let about = |name: &str, unit: &str| About {
        name: name.to_owned(),
        unit: unit.to_owned(),
        meaning: format!("What {name} is"),
        cell_m: (4.0, 4.0),
        tags: [("history".to_owned(), format!("made as {name}"))].into(),
        ..About::default()
    };
    let attributes = serde_json::json!({ "seed": 11, "recipe": "name = \"A\"", "steps_done": 5 });
    let (a, b) = (about("height", "m"), about("water", "kg"));
    write_store(&path, &mut [(&a, &mut &height), (&b, &mut &water)], attributes.as_object().unwrap()).unwrap();
    path
}

#[test]
fn all_layers_go_along_where_there_is_room() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let source = store(folder.path());
    let read = |path: &Path, layer: &str| {
        let options = ReadOptions { layer: Some(layer.to_owned()), ..ReadOptions::default() };
        eyot_io::read_raster(path, &options, &Limits::default()).unwrap()
    };
    go(&source, &at("again.zarr"), &plain());
    go(&source, &at("all.exr"), &plain());
    go(&at("all.exr"), &at("back.zarr"), &plain());
    for file in ["again.zarr", "all.exr", "back.zarr"] {
        for (layer, unit) in [("height", "m"), ("water", "kg")] {
            let (a, b) = (read(&source, layer), read(&at(file), layer));
            assert_eq!((&a.field, a.cell_m), (&b.field, b.cell_m), "{file} {layer}");
            assert_eq!((&*b.name, &*b.unit, &b.meaning), (layer, unit, &a.meaning), "{file} {layer}");
        }
    }
    // What the store says of itself.
    let root = |name: &str| json(&at(name).join("zarr.json"))["attributes"].clone();
    assert_eq!(root("again.zarr"), root("two.zarr"));
    assert_eq!(root("again.zarr")["recipe"], "name = \"A\"");
    assert_eq!(read(&at("again.zarr"), "water").tags["history"], "made as water");
    // Some of them.
    go(&source, &at("one.zarr"), &layers(&["water"]));
    assert_eq!(raster(&at("one.zarr")).name, "water");
    go(&source, &at("both.exr"), &layers(&["water", "height"]));
    assert_eq!(eyot_io::layer_names(&at("both.exr")).unwrap(), ["height", "water"]);
    go(&source, &at("water.tif"), &layers(&["water"]));
    assert_eq!((raster(&at("water.tif")).name, raster(&at("water.tif")).unit), ("water".to_owned(), "kg".to_owned()));
    // Files of one layer take the height; the preset of GIS takes all.
    go(&source, &at("height.tif"), &plain());
    assert_eq!(raster(&at("height.tif")).name, "height");
    go(&source, &at("gis"), &ConvertOptions { preset: Some(Preset::Gis), ..plain() });
    assert_eq!(raster(&at("gis/water.tif")).field, read(&source, "water").field);
    assert!(refused(&source, &at("a.tif"), &layers(&["height", "water"])).contains("name one with `layer`"));
    assert!(refused(&source, &at("a.tif"), &layers(&["snow"])).contains("there is height, water"));
}

#[test]
fn runs_give_all_layers_or_those_that_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let world = run(recipe(LAND, &[]), &at("run"));
    go(&at("run"), &at("all.zarr"), &plain());
    assert_eq!(eyot_io::layer_names(&at("all.zarr")).unwrap(), ["height", "share"]);
    let root = json(&at("all.zarr/zarr.json"));
    assert_eq!((&root["attributes"]["seed"], &root["attributes"]["backend"]), (&7.into(), &"cpu".into()));
    go(&at("run"), &at("share.exr"), &layers(&["share"]));
    go(&at("run"), &at("gis"), &ConvertOptions { preset: Some(Preset::Gis), ..layers(&["share"]) });
    assert_eq!(&raster(&at("gis/share.tif")).field, world.get("share").unwrap());
    assert!(!at("gis/height.tif").exists());
    let e = refused(&at("run"), &at("x.tif"), &layers(&["shre"]));
    assert!(e.contains("shre") && e.contains("share"), "{e}");
    for (name, options) in
        [("m.glb", layers(&["share"])), ("unity", ConvertOptions { preset: Some(Preset::Unity), ..layers(&["share"]) })]
    {
        assert!(refused(&at("run"), &at(name), &options).contains("the height of a run; leave out `layer`"));
    }
    let read = ReadOptions { nodata: Some(0.0), ..ReadOptions::default() };
    assert!(refused(&at("run"), &at("x.tif"), &ConvertOptions { read, ..plain() }).contains("leave out `input_range`"));
}

#[test]
fn options_that_cannot_apply_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (_, field, about) = rasters().remove(0);
    for format in RasterFormat::ALL {
        let path = at(&format!("h.{}", format.extension()));
        write_rows(&path, &mut &field, &about, format, &WriteOptions::default()).unwrap();
    }
    let with = |f: &dyn Fn(&mut ConvertOptions)| {
        let mut options = plain();
        f(&mut options);
        options
    };
    let preset = |p| with(&move |o: &mut ConvertOptions| o.preset = Some(p));
    let range = Some((0.0, 9.0));
    let cases = [
        ("h.tif", "o.npy", layers(&["height"]), "`", "single layer; leave out `layer`"),
        ("h.r16", "o.npy", layers(&["height"]), "`", "single layer; leave out `layer`"),
        (
            "h.tif",
            "o.tif",
            with(&|o| o.byte_order = Some(ByteOrder::Little)),
            "order of bytes",
            "leave out `byte_order`",
        ),
        ("h.tif", "o.png", with(&|o| o.row_order = Some(RowOrder::SouthFirst)), "north on top", "leave out `rows`"),
        ("h.tif", "o.tif", with(&|o| o.range = range), "without a scale", "leave out `range`"),
        ("h.tif", "o.r32", with(&|o| o.range = range), "without a scale", "input_range"),
        ("h.tif", "o", ConvertOptions { range, ..preset(Preset::Unreal) }, "a preset chooses", "leave out `range`"),
        (
            "h.tif",
            "o",
            ConvertOptions { row_order: Some(RowOrder::SouthFirst), ..preset(Preset::Unreal) },
            "this preset chooses",
            "leave out `rows`",
        ),
        (
            "h.tif",
            "o",
            ConvertOptions { byte_order: Some(ByteOrder::Big), ..preset(Preset::Unity) },
            "a preset chooses",
            "leave out `byte_order`",
        ),
        ("h.tif", "o", ConvertOptions { size: Some(512), ..preset(Preset::Unity) }, "no size for", "513"),
        (
            "h.tif",
            "o",
            ConvertOptions { size: Some(513), ..preset(Preset::Godot) },
            "keeps the size",
            "leave `size` out",
        ),
        ("h.tif", "o.png", with(&|o| o.size = Some(513)), "keeps the size", "the preset `unreal` or unity"),
        ("h.tif", "o.npy", with(&|o| o.read.size = Some((3, 3))), "says its size", "leave out `input_size`"),
        ("h.exr", "o.npy", with(&|o| o.read.sample = Some(Sample::Float(4))), "its numbers", "input_type"),
        ("h.zarr", "o.npy", with(&|o| o.read.row_order = Some(RowOrder::SouthFirst)), "itself", "input_rows"),
        (
            "h.tif",
            "o.npy",
            with(&|o| (o.read.low_m, o.read.high_m) = (Some(0.0), Some(1.0))),
            "as they are",
            "input_range",
        ),
        ("h.tif", "o.npy", with(&|o| o.cell_m = Some((5.0, 5.0))), "says where it lies", "leave out `cell`"),
    ];
    for (from, to, options, problem, remedy) in cases {
        let e = refused(&at(from), &at(to), &options);
        assert!(e.contains(problem) && e.contains(remedy), "{from} -> {to}: {e}");
        assert!(!at(to).exists(), "{to} was written");
    }
    // The same options where they do apply.
    go(
        &at("h.tif"),
        &at("o.r16"),
        &with(&|o| {
            (o.range, o.byte_order, o.row_order) =
                (Some((-500.0, 3000.0)), Some(ByteOrder::Big), Some(RowOrder::SouthFirst));
        }),
    );
    go(&at("h.png"), &at("o.tif"), &with(&|o| (o.read.low_m, o.read.high_m) = (Some(0.0), Some(1.0))));
    assert_eq!(raster(&at("o.tif")).field.min_max(), (0.0, 1.0));
    // Unity can be told to flip its file.
    let north = ConvertOptions { row_order: Some(RowOrder::NorthFirst), size: Some(33), ..preset(Preset::Unity) };
    go(&at("h.tif"), &at("north"), &north);
    go(&at("h.tif"), &at("south"), &ConvertOptions { row_order: None, ..north });
    let rows = |f: &str| std::fs::read(at(f)).unwrap().chunks(66).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let (a, mut b) = (rows("north/unity_height.raw"), rows("south/unity_height.raw"));
    b.reverse();
    assert_eq!(a, b);
    let flips = |f: &str| json(&at(f).join("unity.json"))["heightmap"]["flip_vertically"].clone();
    assert_eq!((flips("north"), flips("south")), (true.into(), false.into()));
}

/// An array of 64-bit floats as numpy saves it.
fn npy64(path: &Path, (w, h): (usize, usize), value: impl Fn(usize) -> f64) {
    let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({h}, {w}), }}");
    text = format!("{text:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend((0..w * h).flat_map(|i| value(i).to_le_bytes()));
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn what_is_lost_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let notes = |from: &str, options: &ConvertOptions| go(&at(from), &at("o.tif"), options).join("\n");
    npy64(&at("exact.npy"), (3, 5), |i| i as f64 * 0.5);
    assert!(!notes("exact.npy", &plain()).contains("rounded"));
    npy64(&at("fine.npy"), (3, 5), |i| 1000.0 + i as f64 * 1e-9);
    let said = notes("fine.npy", &plain());
    assert!(
        said.contains("more than 32 bits; they were rounded, by 1.4e-8 at most") && said.contains("`cell`"),
        "{said}"
    );
    let wide = std::fs::read(at("fine.npy")).unwrap()[128..].to_vec();
    std::fs::write(at("fine.bin"), wide).unwrap();
    let read = ReadOptions { size: Some((3, 5)), sample: Some(Sample::Float(8)), ..ReadOptions::default() };
    assert!(notes("fine.bin", &ConvertOptions { read, ..plain() }).contains("1.4e-8"));
    // Missing cells.
    npy64(&at("holes.npy"), (4, 4), |i| if i % 5 == 0 { f64::NAN } else { -3.0 });
    let e = refused(&at("holes.npy"), &at("o.tif"), &plain());
    assert!(e.contains("column 0, row 0 is NaN") && e.contains("`nodata`"), "{e}");
    let nan = ReadOptions { nodata: Some(f64::NAN), ..ReadOptions::default() };
    let said = notes("holes.npy", &ConvertOptions { read: nan, ..plain() });
    assert!(said.contains("4 cells without a value stay without one"), "{said}");
    assert!(raster(&at("o.tif")).field.iter().all(|v| v == -3.0));
    // The marker of other programs, which is far beyond 32 bits, is no rounding.
    npy64(&at("marked.npy"), (4, 4), |i| if i == 3 { -f64::MAX } else { 0.25 });
    let lowest = ReadOptions { nodata: Some(-f64::MAX), ..ReadOptions::default() };
    let said = notes("marked.npy", &ConvertOptions { read: lowest, ..plain() });
    assert!(said.contains("1 cells") && !said.contains("rounded"), "{said}");
    npy64(&at("empty.npy"), (2, 2), |_| f64::NAN);
    let e = refused(
        &at("empty.npy"),
        &at("o.tif"),
        &ConvertOptions { read: ReadOptions { nodata: Some(f64::NAN), ..ReadOptions::default() }, ..plain() },
    );
    assert!(e.contains("every cell is marked as missing"), "{e}");
    npy64(&at("huge.npy"), (2, 2), |_| 1e300);
    assert!(refused(&at("huge.npy"), &at("o.tif"), &plain()).contains("do not fit the 32 bits"));
}

/// An Albers projection as its parameters, without a code, and WGS 84 with heights above the EGM2008 geoid.
fn systems() -> [(Option<u32>, bool, CoordinateSystem); 2] {
    let keys = |directory: &[u16], doubles: &[f64], ascii: &str| CoordinateSystem::GeoKeys {
        directory: directory.to_vec(),
        doubles: doubles.to_vec(),
        ascii: ascii.to_owned(),
    };
    let albers = [
        [1, 1, 0, 7],
        [1024, 0, 1, 1],
        [1025, 0, 1, 1],
        [1026, 34737, 8, 0],
        [3072, 0, 1, 32767],
        [3075, 0, 1, 11],
        [3076, 0, 1, 9001],
        [3078, 34736, 1, 0],
    ];
    let compound = [[1, 1, 1, 4], [1024, 0, 1, 2], [1025, 0, 1, 1], [2048, 0, 1, 4326], [4096, 0, 1, 3855]];
    [
        (None, false, keys(albers.as_flattened(), &[29.5], "Albers 7|")),
        (Some(4326), true, keys(compound.as_flattened(), &[], "")),
    ]
}

#[test]
fn coordinate_systems_without_a_code_survive() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (epsg, geographic, system) in systems() {
        let (step, scale) = if geographic { (0.01, 1113.0) } else { (30.0, 30.0) };
        let transform = [-84.0, step, 0.0, 36.0, 0.0, -step];
        let place = Georeference { transform, epsg, geographic, nodata: Some(-9999.0), system: Some(system) };
        let about = About {
            name: "height".to_owned(),
            unit: "m".to_owned(),
            cell_m: (scale, scale),
            georeference: Some(place.clone()),
            ..About::default()
        };
        let options = WriteOptions::default();
        write_rows(&at("a.tif"), &mut &heights(9, 7), &about, RasterFormat::GeoTiff, &options).unwrap();
        assert_eq!(raster(&at("a.tif")).georeference, Some(place.clone()));
        for format in RasterFormat::ALL {
            let (there, back) = (at(&format!("there.{}", format.extension())), at("back.tif"));
            let notes = go(&at("a.tif"), &there, &plain());
            // What others do not find is said.
            assert_eq!(
                notes.iter().any(|n| n.contains("only Eyot finds it")),
                format == RasterFormat::Zarr,
                "{notes:?}"
            );
            assert_eq!(go(&there, &back, &plain()), Vec::<String>::new());
            assert_eq!(raster(&back).georeference, Some(place.clone()), "{}", format.name());
        }
        // Through a recipe, with the same cells and with others.
        let text = "[grid]\nfrom = \"FILE\"\n[[step]]\ngenerate = \"import\"\nfile = \"FILE\"\n[[export]]\nformat = \
                    \"geotiff\"\n[view]\nenabled = false\n";
        let text = text.replace("FILE", &at("a.tif").display().to_string());
        run(recipe(&text, &[]), &at("run"));
        let found = raster(&at("run/height.tif")).georeference.unwrap();
        assert_eq!((found.system, found.epsg), (place.system, epsg));
        std::fs::remove_dir_all(at("run")).unwrap();
    }
    // Words that a GeoTIFF has no place for: kept where they can be, and missed aloud.
    let words = CoordinateSystem::Text("PROJCS[\"mine\",UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]]]".to_owned());
    let place =
        Georeference { transform: [5.0, 2.0, 0.0, 9.0, 0.0, -2.0], system: Some(words), ..Georeference::default() };
    let about =
        About { name: "height".to_owned(), cell_m: (2.0, 2.0), georeference: Some(place.clone()), ..About::default() };
    write_rows(&at("w.zarr"), &mut &heights(9, 7), &about, RasterFormat::Zarr, &WriteOptions::default()).unwrap();
    assert_eq!(go(&at("w.zarr"), &at("w2.zarr"), &plain()), Vec::<String>::new());
    assert_eq!(raster(&at("w2.zarr")).georeference, Some(place));
    assert!(go(&at("w2.zarr"), &at("w.tif"), &plain()).join("").contains("is lost"));
}

/// Whole numbers keep their values in 16 bits, and numbers of 16 bits come back from any format of floats.
#[test]
fn whole_numbers_stay_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let npy = |name: &str, descr: &str, bytes: Vec<u8>| {
        let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 4), }}");
        text = format!("{text:<117}\n");
        let head = [b"\x93NUMPY\x01\x00", &(text.len() as u16).to_le_bytes()[..], text.as_bytes()].concat();
        std::fs::write(at(name), [head, bytes].concat()).unwrap();
    };
    let (small, signed) = ([7u16, 0, 300, 65535, 12, 90, 1000, 4242], [-7i16, 0, 300, -32768, 32767, 90, 1, -1]);
    npy("u.npy", "<u2", small.iter().flat_map(|n| n.to_le_bytes()).collect());
    npy("part.npy", "<u2", small.iter().flat_map(|n| (n / 2 + 5).to_le_bytes()).collect());
    npy("i.npy", "<i2", signed.iter().flat_map(|n| n.to_le_bytes()).collect());
    npy("b.npy", "|u1", small.iter().map(|n| *n as u8).collect());
    for source in ["u.npy", "part.npy", "i.npy", "b.npy"] {
        for to in ["o.png", "o.r16"] {
            go(&at(source), &at(to), &ConvertOptions { cell_m: Some((1.0, 1.0)), ..plain() });
            assert_eq!(raster(&at(to)).field, raster(&at(source)).field, "{source} -> {to}");
        }
    }
    go(&at("part.npy"), &at("o.r16"), &plain());
    let numbers = |n: &u16| (n / 2 + 5).to_le_bytes();
    assert_eq!(std::fs::read(at("o.r16")).unwrap(), small.iter().flat_map(numbers).collect::<Vec<_>>());
    // A scale that the values do not fill.
    let scaled = ConvertOptions { range: Some((-100.0, 1234.5)), ..plain() };
    let land = Field::from_fn(9, 6, |x, y| (x * y) as f32 * 3.7);
    let about = About { name: "height".to_owned(), cell_m: (2.0, 2.0), ..About::default() };
    write_rows(&at("land.tif"), &mut &land, &about, RasterFormat::GeoTiff, &WriteOptions::default()).unwrap();
    go(&at("land.tif"), &at("a.r16"), &scaled);
    for format in RasterFormat::ALL {
        let there = at(&format!("there.{}", format.extension()));
        go(&at("a.r16"), &there, &plain());
        assert!(raster(&there).tags.is_empty(), "{:?}", raster(&there).tags);
        go(&there, &at("back.r16"), &plain());
        assert_eq!(std::fs::read(at("back.r16")).unwrap(), std::fs::read(at("a.r16")).unwrap(), "{}", format.name());
        let (low, high) = raster(&at("back.r16")).scale.unwrap();
        assert_eq!((low, high), (-100.0, 1234.5), "{}", format.name());
    }
}

/// Heights in feet are never taken for metres, and a conversion leaves them as they are.
#[test]
fn feet_are_no_metres() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let feet = Field::from_fn(8, 8, |x, y| 1000.0 + (x * y) as f32);
    for (unit, factor) in [("ft", 0.3048), ("US survey foot", 1200.0 / 3937.0), ("m", 1.0), ("kg", 1.0)] {
        let about = About { name: "height".to_owned(), unit: unit.to_owned(), cell_m: (5.0, 5.0), ..About::default() };
        write_rows(&at("a.tif"), &mut &feet, &about, RasterFormat::GeoTiff, &WriteOptions::default()).unwrap();
        go(&at("a.tif"), &at("a.exr"), &plain());
        assert_eq!((&raster(&at("a.exr")).field, &*raster(&at("a.exr")).unit), (&feet, unit));
        let opened = eyot::store::open(&at("a.exr"), &Limits::default()).unwrap();
        let metres = Field::from_fn(8, 8, |x, y| (f64::from(feet.get(x, y)) * factor) as f32);
        assert_eq!(opened.world.get("height").unwrap(), &metres, "{unit}");
        assert_eq!(opened.notes.iter().any(|n| n.to_string().contains("feet")), factor != 1.0);
        let text = format!(
            "[grid]\nsize = 8\n[[step]]\ngenerate = \"import\"\nfile = '{}'\n[view]\nenabled = false\n",
            at("a.tif").display()
        );
        assert_eq!(run(recipe(&text, &[]), &at("run")).get("height").unwrap(), &metres, "{unit}");
        std::fs::remove_dir_all(at("run")).unwrap();
    }
}

/// Names in files of others stay in the folder that they are written to.
#[test]
fn names_of_layers_do_not_leave_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let about = About { name: "../up".to_owned(), cell_m: (5.0, 5.0), ..About::default() };
    write_rows(&at("a.npy"), &mut &heights(4, 4), &about, RasterFormat::Npy, &WriteOptions::default()).unwrap();
    let e = refused(&at("a.npy"), &at("deep/gis"), &ConvertOptions { preset: Some(Preset::Gis), ..plain() });
    assert!(e.contains("cannot name a file") && !at("deep").exists(), "{e}");
}

/// What a mesh takes while it is made is many times what it is.
#[test]
fn meshes_and_presets_meet_the_limit_on_memory_with_all_that_they_take() {
    let f = tempfile::tempdir().unwrap();
    let world = common::run(
        common::recipe(
            "[grid]\nsize = 256\n[[step]]\ngenerate = \"cone\"\nheight = 300.0\n[view]\nenabled = false\n",
            &[],
        ),
        &f.path().join("run"),
    );
    assert_eq!(world.grid.cells(), 1 << 16);
    let limits = Limits { max_bytes: 16 << 20, ..Limits::default() };
    let refused = |to: &str, options: &ConvertOptions| {
        let to = f.path().join(to);
        let e = convert(&f.path().join("run"), &to, options, &limits).unwrap_err().to_string();
        assert!(e.contains("too large") && !to.exists(), "{e}");
    };
    refused("a.glb", &ConvertOptions::default());
    refused("a.obj", &ConvertOptions::default());
    refused("blender", &ConvertOptions { preset: Some(eyot::Preset::Blender), ..ConvertOptions::default() });
    // Rasters are written in bands of rows, beside what was read.
    let small = Limits { max_bytes: 900 << 10, ..limits };
    let npy = f.path().join("run.npy");
    go(&f.path().join("run"), &npy, &ConvertOptions::default());
    let e = convert(&npy, &f.path().join("a.zarr"), &ConvertOptions::default(), &small).unwrap_err().to_string();
    assert!(e.contains("a.zarr") && e.contains("too large"), "{e}");
    // In as much as it asks for, it works.
    let enough = Limits { max_bytes: 40 << 20, ..Limits::default() };
    convert(&f.path().join("run"), &f.path().join("a.glb"), &ConvertOptions::default(), &enough).unwrap();
}
