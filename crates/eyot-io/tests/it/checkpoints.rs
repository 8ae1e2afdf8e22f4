//! Checkpoints come back bit by bit, and damaged ones are refused without harm.

use eyot_core::component::Numbers;
use eyot_core::{
    Boundary, BoundaryCondition, Centering, ComponentKinds, Field, Georeference, Grid, LayerSpec, Limits, World,
    layer::known,
};
use eyot_io::checkpoint::{Checkpoint, save};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A checkpoint without components of other kinds than those of the core.
fn load(path: &Path, limits: &Limits) -> eyot_io::Result<Checkpoint> {
    eyot_io::checkpoint::load(path, limits, &ComponentKinds::core())
}

fn world(w: usize, h: usize, values: &[f32]) -> World {
    let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open };
    let mut world = World::new(
        Grid { cell_y_m: 0.1 + 0.2, ..Grid::new(w, h, 10.0, rim, &Limits::default()).unwrap() },
        u64::MAX - 3,
    );
    world.step = 1 << 47;
    world.sea_level_m = -1.0 / 3.0;
    world.georeference = Some(Georeference {
        transform: [0.1, 1e-17, -0.0, 4e6, 0.0, -0.3],
        epsg: Some(4326),
        geographic: true,
        nodata: None,
        system: Some(eyot_core::CoordinateSystem::GeoKeys {
            directory: vec![1, 1, 0, 1, 1024, 0, 1, 2],
            doubles: vec![0.1 + 0.2],
            ascii: "ellipso\u{ef}d|".to_owned(),
        }),
    });
    world.ledger.add("water.rain", 1e300 / 3.0, "m3", "Rain that \"fell\"", 1);
    world.components.insert("plates", Numbers(vec![1.0 / 3.0, -1e-300, 12.0]));
    world.ledger.add("water.out", 5e-324, "m3", "Left over the rim", -1);
    world.put(&known::HEIGHT, Field::from_slice(w, h, values).unwrap()).unwrap();
    let flux = LayerSpec::new("flux", "m3/s", "Flux", (f32::NEG_INFINITY, f32::INFINITY)).on(Centering::FaceX);
    world.put(&flux, Field::from_fn(w, h, |x, y| -(x as f32) / (y as f32 + 3.0))).unwrap();
    world
}

fn bits(world: &World) -> Vec<(String, Vec<u32>)> {
    world.layers().iter().map(|l| (l.spec.name.to_string(), l.field.iter().map(f32::to_bits).collect())).collect()
}

fn saved(folder: &Path) -> (PathBuf, World) {
    let path = folder.join("run.ckpt");
    let mut world = world(5, 4, &[0.5; 20]);
    world.components.insert("corals", Numbers(vec![1.5, -0.0, 3.0]));
    world.components.insert("plates", Numbers(Vec::new()));
    save(&path, &world, "name = \"Atoll\"\n", &json!({"entry": 3, "left": [1.5, null]})).unwrap();
    (path, world)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn every_bit_comes_back(w in 1usize..40, h in 1usize..20, pattern in prop::collection::vec(any::<u32>(), 1..50),
                            amount in any::<f64>().prop_filter("finite", |v| v.is_finite())) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ckpt");
        // Any bits at all: denormals, -0.0, infinities and NaN with their payload.
        let values: Vec<f32> = (0..w * h).map(|i| f32::from_bits(pattern[i % pattern.len()])).collect();
        let mut world = world(w, h, &values);
        world.ledger.add("sand.in", amount, "m3", "Sand", 1);
        let numbers: Vec<f64> = pattern.iter().map(|&bits| f64::from_bits(u64::from(bits) << 29)).collect();
        world.components.insert("corals", Numbers(numbers.clone()));
        let state = json!({"amount": amount});
        save(&path, &world, "seed = 7", &state).unwrap();
        let back = load(&path, &Limits::default()).unwrap();
        prop_assert_eq!(bits(&back.world), bits(&world));
        prop_assert_eq!(back.world.fingerprint(), world.fingerprint());
        let back_bits: Vec<u64> = back.world.components.get::<Numbers>("corals").unwrap().unwrap().0.iter().map(|n| n.to_bits()).collect();
        prop_assert_eq!(back_bits, numbers.iter().map(|n| n.to_bits()).collect::<Vec<_>>());
        prop_assert_eq!(back.world.ledger.amount("sand.in").to_bits(), amount.to_bits());
        prop_assert_eq!(&back.world.ledger, &world.ledger);
        prop_assert_eq!(&back.world.components, &world.components);
        prop_assert_eq!(back.world.sea_level_m.to_bits(), world.sea_level_m.to_bits());
        prop_assert_eq!(&back.world.georeference, &world.georeference);
        prop_assert_eq!((back.world.grid, back.world.seed, back.world.step), (world.grid, world.seed, world.step));
        prop_assert_eq!((back.recipe_toml.as_str(), &back.state), ("seed = 7", &state));
        for (a, b) in back.world.layers().iter().zip(world.layers()) {
            prop_assert_eq!(&a.spec, &b.spec);
        }
    }
}

#[test]
fn outer_faces_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("w.eyot");
    let grid = Grid::new(3, 2, 1.0, eyot_core::Boundary::OPEN, &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    let spec = LayerSpec::new("flux_x", "m/s", "Flux", (-1.0, 1.0)).on(eyot_core::Centering::FaceX);
    world.ensure(&spec, 0.5).field.set_outer_faces(&[1.0, -2.0, 3.0, 4.0, -0.0]).unwrap();
    save(&path, &world, "", &Value::Null).unwrap();
    let back = load(&path, &Limits::default()).unwrap().world;
    assert_eq!(back.get("flux_x").unwrap().outer_faces(), [1.0, -2.0, 3.0, 4.0, -0.0]);
    assert_eq!(back.fingerprint(), world.fingerprint());
}

#[test]
fn saving_again_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = saved(folder.path());
    let first = std::fs::read(&path).unwrap();
    let back = load(&path, &Limits::default()).unwrap();
    assert_eq!(back.engine_version, env!("CARGO_PKG_VERSION"));
    save(&path, &back.world, &back.recipe_toml, &back.state).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), first);
}

#[test]
fn every_truncation_and_every_flipped_bit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = saved(folder.path());
    let whole = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8], what: &str| {
        std::fs::write(&path, bytes).unwrap();
        let e = load(&path, &Limits::default()).expect_err(what).to_string();
        assert!(e.contains("run.ckpt"), "{e}");
    };
    for n in 0..whole.len() {
        refused(&whole[..n], &format!("cut to {n} bytes"));
    }
    for i in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[i] ^= 1 << (i % 8);
        refused(&bytes, &format!("bit flipped in byte {i}"));
    }
    refused(&[&whole[..], &[0]].concat(), "one byte too many");
}

#[test]
fn foreign_files_versions_and_folders_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = saved(folder.path());
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[8] = 9;
    std::fs::write(&path, &bytes).unwrap();
    let e = load(&path, &Limits::default()).unwrap_err().to_string();
    assert!(e.contains("format version 9") && e.contains("version of Eyot that wrote it"), "{e}");
    std::fs::write(&path, [b'x'; 100]).unwrap();
    let e = load(&path, &Limits::default()).unwrap_err().to_string();
    assert!(e.contains("no Eyot checkpoint"), "{e}");
    assert!(load(folder.path(), &Limits::default()).is_err());
    assert!(load(&folder.path().join("none"), &Limits::default()).unwrap_err().to_string().contains("check the name"));
}

/// A header with a sound checksum that claims what is not there.
#[test]
fn hostile_headers_are_refused_before_anything_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = saved(folder.path());
    let whole = std::fs::read(&path).unwrap();
    let length = u64::from_le_bytes(whole[12..20].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&whole[20..20 + length]).unwrap();
    let attack = |change: &dyn Fn(&mut Value)| {
        let mut h = header.clone();
        change(&mut h);
        let text = serde_json::to_vec(&h).unwrap();
        let mut bytes = [&whole[..12], &(text.len() as u64).to_le_bytes(), &text].concat();
        let crc = crc32fast::hash(&bytes);
        bytes.extend(crc.to_le_bytes());
        bytes.extend(&whole[24 + length..]);
        std::fs::write(&path, bytes).unwrap();
        load(&path, &Limits::default()).unwrap_err().to_string()
    };
    assert!(attack(&|h| h["grid"]["width"] = json!(1u64 << 40)).contains("too large"));
    assert!(attack(&|h| h["grid"]["width"] = json!(20_000)).contains("bytes, the file"));
    assert!(attack(&|h| h["grid"]["width"] = json!(0)).contains("at least 1x1"));
    assert!(attack(&|h| h["grid"]["cell_x_m"] = json!(-1.0)).contains("cell size"));
    assert!(attack(&|h| h["grid"]["height"] = json!(u64::MAX)).contains("too large"));
    assert!(attack(&|h| h["layers"] = json!([])).contains("bytes, the file"));
    let again = header["layers"][0].clone();
    assert!(attack(&|h| h["layers"][1] = again.clone()).contains("two layers"));
    assert!(attack(&|h| h["layers"] = json!(vec![again.clone(); 300])).contains("300 layers"));
    assert!(attack(&|h| h["seed"] = json!("x")).contains("unreadable header"));
    // Names that would write elsewhere, and numbers that no run has.
    for name in ["../../../x", "/x", "a/b", "a\\b", "", "..", "X", "9a", "a b", &"a".repeat(65)] {
        let e = attack(&|h| h["layers"][0]["name"] = json!(name));
        assert!(e.contains("a layer is called"), "{name}: {e}");
    }
    assert!(attack(&|h| h["step"] = json!(1_000_000_000_000_000_000u64)).contains("a world goes up to step"));
    assert!(attack(&|h| h["sea_level_m"] = json!(1e308)).contains("the sea would stand at 1000"));
    // A length that no file has.
    let mut bytes = whole.clone();
    bytes[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    assert!(load(&path, &Limits::default()).is_err());
}

#[test]
fn numbers_that_json_cannot_carry_stop_the_save_and_leave_the_former_file() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut world) = saved(folder.path());
    let before = std::fs::read(&path).unwrap();
    world.ledger.add("water.rain", f64::NAN, "m3", "", 1);
    assert!(save(&path, &world, "", &Value::Null).unwrap_err().to_string().contains("former one is unharmed"));
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

#[test]
fn what_may_be_written_may_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut world) = saved(folder.path());
    let before = std::fs::read(&path).unwrap();
    let refuse = |change: fn(&mut World)| {
        let mut bad = world.clone();
        change(&mut bad);
        let e = save(&path, &bad, "", &Value::Null).unwrap_err().to_string();
        assert_eq!(std::fs::read(&path).unwrap(), before, "{e}");
        e
    };
    assert!(refuse(|w| w.sea_level_m = 12000.1).contains("the sea would stand at 12000.1 m"));
    assert!(refuse(|w| w.sea_level_m = f64::NAN).contains("the former one is unharmed"));
    assert!(refuse(|w| w.step = eyot_core::MAX_STEP + 1).contains("281474976710657"));
    let long = |w: &mut World| w.components.insert("n".repeat(300), Numbers(Vec::new()));
    assert!(refuse(long).contains("a name that is too long"));
    (world.step, world.sea_level_m) = (eyot_core::MAX_STEP, -12000.0);
    save(&path, &world, "", &Value::Null).unwrap();
    assert_eq!(load(&path, &Limits::default()).unwrap().world, world);
}
