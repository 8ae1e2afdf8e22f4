//! Terrains as glTF, read back: texture coordinates, water, tiles that fit, bounded sizes.

use crate::common;

use common::{json, parse, run};
use eyot::formats::{ConvertOptions, convert};
use eyot::{Limits, Overrides, Run, RunOptions};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// An island in a sea, with a crater lake of level water.
const LAND: &str = r#"
    name = "Isle"
    seed = 3
    [grid]
    size = [97, 81]
    cell = 20.0
    [[step]]
    generate = "ramp"
    [[step]]
    generate = "ramp"
    layer = "water"
    [[rule]]
    name = "shape"
    set.height = "400 * exp(-6 * ((u - 0.5)^2 + (v - 0.5)^2)) - 150 - 180 * exp(-120 * ((u - 0.5)^2 + (v - 0.5)^2))"
    [[rule]]
    name = "pond"
    set.water = "max(180 - height, 0) * (1 - step(0.02, (u - 0.5)^2 + (v - 0.5)^2))"
    [[step]]
    simulate = ["shape"]
    steps = 1
    [[step]]
    simulate = ["pond"]
    steps = 1
    [view]
    enabled = false
"#;

struct Gltf {
    json: Value,
    data: Vec<u8>,
}

impl Gltf {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
        let n = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: Value = serde_json::from_slice(&bytes[20..20 + n]).unwrap();
        let data = bytes[28 + n..].to_vec();
        assert_eq!(data.len() as u64, json["buffers"][0]["byteLength"].as_u64().unwrap());
        Self { json, data }
    }

    /// The numbers of an accessor, shares of whole numbers from 0 to 1.
    fn numbers(&self, accessor: &Value) -> Vec<f32> {
        let a = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.json["bufferViews"][a["bufferView"].as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        assert!(first.is_multiple_of(4));
        let bytes = &self.data[first..first + view["byteLength"].as_u64().unwrap() as usize];
        let share = a["normalized"] == true;
        match a["componentType"].as_u64().unwrap() {
            5126 => bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect(),
            5125 => bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()) as f32).collect(),
            5123 => bytes
                .chunks_exact(2)
                .map(|b| f32::from(u16::from_le_bytes(b.try_into().unwrap())) / if share { 65535.0 } else { 1.0 })
                .collect(),
            other => panic!("{other}"),
        }
    }

    fn mesh(&self, name: &str) -> &Value {
        let meshes = self.json["meshes"].as_array().unwrap();
        meshes.iter().find(|m| m["name"] == name).unwrap_or_else(|| panic!("no mesh {name}"))
    }

    fn points(&self, primitive: &Value, attribute: &str, of: usize) -> Vec<Vec<f32>> {
        self.numbers(&primitive["attributes"][attribute]).chunks_exact(of).map(<[f32]>::to_vec).collect()
    }
}

fn made(out: &Path, exports: &[&str]) {
    run(parse(LAND, exports, Overrides::default(), &Limits::default()).unwrap(), out);
}

#[test]
fn a_terrain_has_texture_coordinates_short_indices_and_level_water() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    made(&out, &["format = \"glb\"", "format = \"glb\"\nwater = false\nprefix = \"dry_\"", "format = \"obj\""]);
    let gltf = Gltf::read(&out.join("terrain.glb"));
    let ground = &gltf.mesh("Isle")["primitives"][0];
    let texture = gltf.points(ground, "TEXCOORD_0", 2);
    let places = gltf.points(ground, "POSITION", 3);
    assert_eq!((texture.len(), places.len()), (97 * 81, 97 * 81));
    for (axis, n) in [(0, 97.0), (1, 81.0)] {
        let (low, high) = texture.iter().fold((1.0f32, 0.0f32), |(a, b), t| (a.min(t[axis]), b.max(t[axis])));
        // To the middles of the outer pixels.
        assert!((low - 0.5 / n).abs() < 1e-4 && (high - 1.0 + 0.5 / n).abs() < 1e-4, "{low} {high}");
    }
    let indices = &gltf.json["accessors"][ground["indices"].as_u64().unwrap() as usize];
    assert_eq!(indices["componentType"], 5123);

    // The sea at 0, the crater lake at 180 m, nothing else.
    let water = &gltf.mesh("water")["primitives"][0];
    let mut levels: BTreeMap<u32, usize> = BTreeMap::new();
    for p in gltf.points(water, "POSITION", 3) {
        *levels.entry(p[1].to_bits()).or_default() += 1;
    }
    let (sea, lake) = (0.0f32.to_bits(), 180.0f32.to_bits());
    assert!(levels[&sea] > 100 && levels[&lake] > 10, "{levels:?}");
    assert!(levels.keys().all(|&l| l == sea || (f32::from_bits(l) - 180.0).abs() < 1e-3), "{levels:?}");
    let material = &gltf.json["materials"][water["material"].as_u64().unwrap() as usize];
    assert_eq!((&material["name"], &material["alphaMode"]), (&Value::from("water"), &Value::from("BLEND")));
    assert_eq!(gltf.json["scenes"][0]["nodes"].as_array().unwrap().len(), 2);

    let dry = Gltf::read(&out.join("dry_terrain.glb"));
    assert_eq!(dry.json["scenes"][0]["nodes"].as_array().unwrap().len(), 1);
    let text = std::fs::read_to_string(out.join("terrain.obj")).unwrap();
    assert!(text.contains("\no water\n") && text.matches("\nvt ").count() > 97 * 81);
}

#[test]
fn tiles_fit_to_the_bit_and_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    made(&out, &["format = \"glb\"\ntiles = [3, 2]"]);
    let list = json(&out.join("terrain.json"));
    let files = list["files"].as_array().unwrap();
    assert_eq!(files.len(), 6);
    assert!(list["skirt_m"].as_f64().unwrap() >= 10.0);
    let mut heights: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for file in files {
        let name = format!("terrain_x{}_y{}", file["x"], file["y"]);
        assert_eq!(file["file"], format!("{name}.glb"));
        let gltf = Gltf::read(&out.join(format!("{name}.glb")));
        let primitives = gltf.mesh(&name)["primitives"].as_array().unwrap();
        assert_eq!((primitives.len(), &primitives[1]["extras"]["part"]), (2, &Value::from("skirt")));
        for p in gltf.points(&primitives[0], "POSITION", 3) {
            let before = heights.insert([p[0].to_bits(), p[2].to_bits()], p[1].to_bits());
            assert!(before.is_none_or(|z| z == p[1].to_bits()), "{name} {p:?}");
        }
        let low = file["min_m"][1].as_f64().unwrap() as f32;
        assert_eq!(gltf.json["accessors"][0]["min"][1].as_f64().unwrap() as f32, low);
        let levels = file["levels"].as_array().unwrap();
        assert!(levels.len() >= 3 && levels[0]["triangles"].as_u64() > levels[2]["triangles"].as_u64());
    }
    assert_eq!(heights.len(), 97 * 81);
    // Whatever the threads, the same bytes.
    let again = folder.path().join("again");
    let recipe = parse(LAND, &["format = \"glb\"\ntiles = [3, 2]"], Overrides::default(), &Limits::default()).unwrap();
    let options = RunOptions { out: Some(again.clone()), threads: Some(1), ..RunOptions::default() };
    Run::start(recipe, options).unwrap().join().unwrap();
    for file in files {
        let name = file["file"].as_str().unwrap();
        assert_eq!(std::fs::read(out.join(name)).unwrap(), std::fs::read(again.join(name)).unwrap(), "{name}");
    }
}

#[test]
fn meshes_are_bounded_and_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    made(&out, &["format = \"glb\"\nvertices = 3000"]);
    let gltf = Gltf::read(&out.join("terrain.glb"));
    let ground = &gltf.mesh("Isle")["primitives"][0];
    assert!(gltf.points(ground, "POSITION", 3).len() <= 3000);

    let to = folder.path().join("t.glb");
    let options = ConvertOptions { vertices: Some(3000), ..ConvertOptions::default() };
    let done = convert(&out, &to, &options, &Limits::default()).unwrap();
    let told: Vec<String> = done.notes.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|n| n.contains("each second column") && n.contains("tiles")), "{told:?}");
    // In tiles every cell has its vertex.
    let options = ConvertOptions { vertices: Some(3000), tiles: Some([2, 2]), ..ConvertOptions::default() };
    let done = convert(&out, &to, &options, &Limits::default()).unwrap();
    assert!(done.notes.is_empty() && done.files.len() == 5, "{done:?}");
    let again = convert(&out, &to, &options, &Limits::default()).unwrap_err();
    assert!(again.to_string().contains("there already"), "{again}");
}

#[test]
fn keys_that_cannot_have_an_effect_are_refused() {
    for (keys, told) in [
        ("format = \"obj\"\ntiles = [2, 2]", "`tiles` has no effect here: it belongs to a terrain or trees as `glb`"),
        ("format = \"glb\"\nskirt = 3.0", "`skirt` has no effect here"),
        ("format = \"geotiff\"\nwater = true", "`water` has no effect here"),
        ("what = \"map\"\ninterval = 10.0", "`interval` has no effect here: it belongs to `contours`"),
        ("preset = \"godot\"\nvertices = 100", "`vertices` has no effect here"),
        ("format = \"glb\"\ntiles = [64, 64]\nskirt = -1.0", "skirt"),
    ] {
        let e = parse(LAND, &[keys], Overrides::default(), &Limits::default()).err().unwrap_or_default();
        assert!(e.contains(told), "{keys}: {e}");
    }
}
