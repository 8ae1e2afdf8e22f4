//! Recordings come back bit by bit, keep within their bound, survive a kill at any moment, and are refused if they are broken.

use eyot_core::{
    Boundary, BoundaryCondition, Centering, ComponentKinds, Field, Georeference, Grid, LayerSpec, Limits, World,
    layer::known,
};
use eyot_io::timeline::{Record, Timeline, is_recording, remove};
use eyot_io::{ReadOptions, read_raster};
use serde_json::{Map, Value, json};
use std::fs;
use std::path::{Path, PathBuf};

const PLENTY: Record = Record { every: 5, max_bytes: 1 << 40 };
const SIZE: (usize, usize) = (140, 9);

/// A world at a step: every value says which; a late layer from step 20 on.
fn world(step: u64) -> World {
    let (w, h) = SIZE;
    let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open };
    let mut world = World::new(Grid::new(w, h, 10.0, rim, &Limits::default()).unwrap(), 7);
    world.step = step;
    world.sea_level_m = step as f64 / 3.0;
    let transform = [0.1, 1.0, 0.0, 4e6, 0.0, -1.0];
    world.georeference =
        Some(Georeference { transform, epsg: Some(32611), geographic: false, nodata: None, system: None });
    world.ledger.add("water.rain", 1e300 / (step as f64 + 3.0), "m3", "Rain", 1);
    let value = |x: usize, y: usize| ((x * 31 + y * 17) as u64 ^ step.wrapping_mul(0x9e37_79b9)) as f32 / 7.0;
    world.put(&known::HEIGHT, Field::from_fn(w, h, value)).unwrap();
    for (name, centering, n) in [("flux_x", Centering::FaceX, 1.0), ("flux_y", Centering::FaceY, 2.0)] {
        let spec = LayerSpec::new(name, "m3/s", "Flux", (-1.0, 1.0)).on(centering);
        let field = &mut world.ensure(&spec, 0.0).field;
        field.rows_mut().enumerate().for_each(|(y, r)| r.iter_mut().for_each(|v| *v = -n - (y as f32)));
        // On both sides: a checkpoint keeps them, whatever the layer means.
        let outer: Vec<f32> = (0..w + h).map(|i| n * i as f32 + step as f32).collect();
        field.set_outer_faces(&outer).unwrap();
    }
    if step >= 20 {
        world.put(&known::LIMESTONE, Field::from_fn(w, h, |x, _| x as f32 - step as f32)).unwrap();
    }
    world
}

fn state(step: u64) -> Value {
    json!({ "done": step, "journal": ["a", "b"] })
}

fn recorded(path: &Path, record: Record, steps: impl IntoIterator<Item = u64>) -> Timeline {
    let attributes = json!({ "title": "Test" }).as_object().cloned().unwrap();
    let mut t = Timeline::create(path, record, &attributes, &Limits::default()).unwrap();
    for step in steps {
        t.append(&world(step), "name = \"Test\"", &state(step)).unwrap();
    }
    t
}

fn steps(t: &Timeline) -> Vec<u64> {
    t.frames().iter().map(|f| f.step).collect()
}

/// What the metadata of the coordinate `time` say, by itself and in the root.
fn time_attributes(path: &Path) -> Value {
    let read = |file: &Path| -> Value { serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap() };
    let own = read(&path.join("time/zarr.json"))["attributes"].clone();
    assert_eq!(read(&path.join("zarr.json"))["consolidated_metadata"]["metadata"]["time"]["attributes"], own);
    own
}

/// As CF has it: numbers with a factor and a unit, and a calendar where there can be one.
#[test]
fn steps_become_times_where_their_length_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let record = Record { every: 10, max_bytes: 1 << 30 };
    for (seconds, units, calendar, factor) in [
        (1562.5, "seconds since 2000-01-01 00:00:00", json!("proleptic_gregorian"), 1562.5),
        (1e6 * 365.25 * 86_400.0, "years", Value::Null, 1e6),
    ] {
        let path = folder.path().join("timeline.zarr");
        let attributes = json!({ "seconds_per_step": seconds }).as_object().cloned().unwrap();
        let mut t = Timeline::create(&path, record, &attributes, &Limits::default()).unwrap();
        [0, 10, 20].into_iter().for_each(|step| t.append(&world(step), "", &state(step)).unwrap());
        let said = time_attributes(&path);
        assert_eq!((&said["units"], &said["calendar"]), (&json!(units), &calendar), "{said}");
        assert!((said["scale_factor"].as_f64().unwrap() / factor - 1.0).abs() < 1e-12, "{said}");
        // Steps are what is kept, whatever they mean.
        let mut t = Timeline::open_to_write(&path, &Limits::default()).unwrap();
        assert_eq!(steps(&t), [0, 10, 20]);
        t.lose_clock().unwrap();
        let said = time_attributes(&path);
        assert!(said["units"] == "1" && said["scale_factor"].is_null() && said["comment"].is_string(), "{said}");
        assert_eq!(steps(&Timeline::open(&path, &Limits::default()).unwrap()), [0, 10, 20]);
    }
}

fn assert_whole(t: &Timeline) {
    for (i, frame) in t.frames().iter().enumerate() {
        let back = t.load(i, &ComponentKinds::core()).unwrap();
        assert_eq!(back.world, world(frame.step));
        assert_eq!(back.world.fingerprint(), world(frame.step).fingerprint());
        assert_eq!((back.recipe_toml.as_str(), &back.state), ("name = \"Test\"", &state(frame.step)));
        assert_eq!(t.state(i).unwrap(), state(frame.step));
    }
}

/// All files of a folder with their bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut out = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            out.extend(files(&path));
        } else {
            out.push((path.clone(), fs::read(&path).unwrap()));
        }
    }
    out.sort();
    out
}

fn bytes(folder: &Path) -> u64 {
    files(folder).iter().map(|f| f.1.len() as u64).sum()
}

fn place() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("timeline.zarr");
    (folder, path)
}

#[test]
fn every_frame_comes_back_to_the_bit() {
    let (_folder, path) = place();
    let t = recorded(&path, PLENTY, (0..10).map(|i| 5 * i));
    assert_whole(&t);
    let again = Timeline::open(&path, &Limits::default()).unwrap();
    assert_eq!((again.frames(), again.record()), (t.frames(), PLENTY));
    assert_whole(&again);
    assert!(again.load(10, &ComponentKinds::core()).unwrap_err().to_string().contains("no frame 10"));
    let inside = t.frames().iter().map(|f| f.bytes).sum::<u64>();
    assert!(inside < bytes(&path) && inside > bytes(&path) / 2, "{inside} of {}", bytes(&path));
    // Others find the last step of a layer in it.
    let raster = read_raster(&path, &ReadOptions::default(), &Limits::default()).unwrap();
    assert_eq!((raster.field, raster.steps), (world(45).get("height").unwrap().clone(), 10));
}

#[test]
fn a_recording_goes_on_where_it_was_opened_or_cut() {
    let (_folder, path) = place();
    drop(recorded(&path, PLENTY, [0, 5, 10, 20, 25]));
    let mut t = Timeline::open_to_write(&path, &Limits::default()).unwrap();
    let late = t.append(&world(25), "", &Value::Null).unwrap_err().to_string();
    assert!(late.contains("step 25 after one of step 25"), "{late}");
    t.truncate(10).unwrap();
    assert_eq!(steps(&t), [0, 5]);
    t.append(&world(12), "name = \"Test\"", &state(12)).unwrap();
    assert_whole(&t);
    let again = Timeline::open(&path, &Limits::default()).unwrap();
    assert_eq!(steps(&again), [0, 5, 12]);
    assert_whole(&again);
    // Nothing of the frames that were dropped is left.
    assert!(
        !path.join("limestone/c/3").exists()
            && !path.join("height/c/3").exists()
            && !path.join(".frames/3.eyot").exists()
    );
}

#[test]
fn a_copy_is_as_long_as_one_wants_and_the_original_stays() {
    let (folder, path) = place();
    let t = recorded(&path, PLENTY, [0, 10, 20, 30]);
    let before = files(&path);
    let other = folder.path().join("other.zarr");
    let mut copy = t.copy(3, &other).unwrap();
    assert_eq!(steps(&copy), [0, 10, 20]);
    assert_whole(&copy);
    copy.append(&world(21), "name = \"Test\"", &state(21)).unwrap();
    assert_whole(&Timeline::open(&other, &Limits::default()).unwrap());
    assert_eq!(files(&path), before);
}

#[test]
fn old_frames_thin_out_within_the_bound() {
    let (_folder, path) = place();
    let one = recorded(&path, PLENTY, [0, 20]).frames()[1].bytes;
    // What all arrays' metadata may take, and some frames.
    let max_bytes = (320 << 10) + 10 * one;
    let two = Record::least_bytes(4 * 4 * (SIZE.0 * SIZE.1) as u128, 4, 20);
    assert!(two > 2 * u128::from(one));
    let mut t = recorded(&path, Record { every: 3, max_bytes }, []);
    for i in 0..50 {
        t.append(&world(3 * i), "name = \"Test\"", &state(3 * i)).unwrap();
        assert!(bytes(&path) <= max_bytes, "{} bytes after {i} frames", bytes(&path));
        let s = steps(&t);
        assert_eq!((s[0], s.last()), (0, Some(&(3 * i))));
    }
    let s = steps(&t);
    assert!(s.len() > 4 && s.len() < 20, "{s:?}");
    // The newest stay dense, the oldest do not.
    assert_eq!(s[s.len() - 1] - s[s.len() - 2], 3);
    assert!(s[1] - s[0] > 12, "{s:?}");
    assert_whole(&t);
    assert_whole(&Timeline::open(&path, &Limits::default()).unwrap());
    let mut t = recorded(&path, Record { every: 1, max_bytes: 3000 }, []);
    let e = t.append(&world(0), "", &Value::Null).unwrap_err().to_string();
    assert!(e.contains("does not hold two frames") && e.contains("raise the bound"), "{e}");
}

/// Changes the files of a recording.
type Change<'a> = Box<dyn Fn(&Path) + 'a>;

/// A thinning that a kill cut off, after any of its changes to files. The late layer is there from the fifth frame on.
#[test]
fn a_thinning_that_was_cut_off_is_finished() {
    let (folder, path) = place();
    let t = recorded(&path, PLENTY, (0..9).map(|i| 5 * i));
    let all = steps(&t);
    drop(t);
    let keep: Vec<(usize, u64)> =
        all.iter().copied().enumerate().filter(|(i, _)| i % 2 == 0 || *i == all.len() - 1).collect();
    let kept: Vec<u64> = keep.iter().map(|k| k.1).collect();
    let layers = ["height", "flux_x", "flux_y", "limestone"];
    let plan = |dropped: bool| json!({ "frames": all.len(), "keep": keep, "dropped": dropped }).to_string();
    // Every action that changes a file, in their order.
    let mut actions: Vec<Change<'_>> =
        vec![Box::new(|s| fs::write(s.join(".frames/thinning.json"), plan(false)).unwrap())];
    for i in (0..all.len()).filter(|i| !keep.iter().any(|k| k.0 == *i)) {
        actions.push(Box::new(move |s| fs::remove_file(s.join(format!(".frames/{i}.eyot"))).unwrap()));
        for l in layers {
            actions.push(Box::new(move |s| {
                let _ = fs::remove_dir_all(s.join(format!("{l}/c/{i}")));
            }));
        }
    }
    actions.push(Box::new(|s| fs::write(s.join(".frames/thinning.json"), plan(true)).unwrap()));
    for (to, (from, _)) in keep.iter().copied().enumerate().filter(|(to, (from, _))| to != from) {
        for l in layers {
            actions.push(Box::new(move |s| {
                let _ = fs::rename(s.join(format!("{l}/c/{from}")), s.join(format!("{l}/c/{to}")));
            }));
        }
        actions.push(Box::new(move |s| {
            fs::rename(s.join(format!(".frames/{from}.eyot")), s.join(format!(".frames/{to}.eyot"))).unwrap();
        }));
    }
    for cut in 1..=actions.len() {
        let copy = folder.path().join("copy.zarr");
        remove(&copy).unwrap();
        for (file, content) in files(&path) {
            let to = copy.join(file.strip_prefix(&path).unwrap());
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::write(to, content).unwrap();
        }
        actions[..cut].iter().for_each(|a| a(&copy));
        let mut t = Timeline::open_to_write(&copy, &Limits::default()).unwrap();
        assert_eq!(steps(&t), kept, "cut after {cut} of {} actions", actions.len());
        assert_whole(&t);
        if cut % 7 == 0 {
            let next = all.last().unwrap() + 2;
            t.append(&world(next), "name = \"Test\"", &state(next)).unwrap();
            assert_whole(&Timeline::open_to_write(&copy, &Limits::default()).unwrap());
        }
        assert!(!copy.join(".frames/thinning.json").exists());
    }
}

#[test]
fn what_a_killed_writer_left_is_removed() {
    let (_folder, path) = place();
    drop(recorded(&path, PLENTY, [0, 5]));
    // Shards of a frame that never was, one of them of a layer that never was; metadata ahead of the root.
    for (file, text) in [
        ("height/c/2/0/0", "half"),
        ("growth/c/2/0/0", "half"),
        ("growth/zarr.json", "{"),
        ("height/.new", "{"),
        (".eyot-abc.tmp", "{"),
        (".frames/2.eyot", "EYOTCKPT"),
    ] {
        fs::create_dir_all(path.join(file).parent().unwrap()).unwrap();
        fs::write(path.join(file), text).unwrap();
    }
    let own = path.join("height/zarr.json");
    let text = fs::read_to_string(&own).unwrap();
    let mut ahead: Value = serde_json::from_str(&text).unwrap();
    ahead["shape"][0] = json!(3);
    fs::write(&own, ahead.to_string()).unwrap();
    assert_whole(&Timeline::open(&path, &Limits::default()).unwrap());
    let mut t = Timeline::open_to_write(&path, &Limits::default()).unwrap();
    assert_eq!(fs::read_to_string(&own).unwrap(), text);
    assert!(
        !path.join("growth").exists() && !path.join("height/c/2").exists() && !path.join(".frames/2.eyot").exists()
    );
    t.append(&world(10), "name = \"Test\"", &state(10)).unwrap();
    assert_whole(&Timeline::open(&path, &Limits::default()).unwrap());
}

#[test]
fn a_frame_that_cannot_be_is_refused_and_the_others_stay() {
    let (_folder, path) = place();
    let mut t = recorded(&path, PLENTY, [0, 5]);
    let before = files(&path);
    let mut bad = world(6);
    bad.layer_mut("height").unwrap().field.set(3, 4, f32::NAN);
    let e = t.append(&bad, "", &Value::Null).unwrap_err().to_string();
    assert!(e.contains("column 3, row 4"), "{e}");
    let mut bad = world(6);
    bad.put(&LayerSpec::new("time", "1", "", (0.0, 1.0)), Field::new(SIZE.0, SIZE.1, 0.0)).unwrap();
    assert!(t.append(&bad, "", &Value::Null).unwrap_err().to_string().contains("cannot name an array"));
    assert_eq!(files(&path), before);
    assert_whole(&t);
    assert!(Timeline::create(&path, Record { every: 0, ..PLENTY }, &Map::new(), &Limits::default()).is_err());
}

#[test]
fn only_recordings_are_removed() {
    let (folder, path) = place();
    remove(&path).unwrap();
    fs::create_dir(&path).unwrap();
    fs::write(path.join("mine.txt"), "x").unwrap();
    assert!(remove(&path).unwrap_err().to_string().contains("something else"));
    assert!(Timeline::create(&path, PLENTY, &Map::new(), &Limits::default()).is_err());
    assert!(!is_recording(&path) && path.join("mine.txt").exists());
    let other = folder.path().join("b.zarr");
    drop(recorded(&other, PLENTY, [0]));
    assert!(is_recording(&other));
    remove(&other).unwrap();
    assert!(!other.exists());
}

/// Changes the root of a sound recording.
fn with_root(path: &Path, change: impl Fn(&mut Value)) {
    let root = path.join("zarr.json");
    let mut value: Value = serde_json::from_slice(&fs::read(&root).unwrap()).unwrap();
    change(&mut value);
    fs::write(&root, value.to_string()).unwrap();
}

#[test]
fn broken_and_hostile_recordings_are_refused() {
    let array = |name: &'static str, key: &'static str, to: Value| -> Change<'static> {
        Box::new(move |p| with_root(p, |r| r["consolidated_metadata"]["metadata"][name][key] = to.clone()))
    };
    let piece = |name: &'static str, to: Value| -> Change<'static> {
        Box::new(move |p| {
            with_root(p, |r| {
                r["consolidated_metadata"]["metadata"][name]["chunk_grid"]["configuration"]["chunk_shape"] = to.clone()
            })
        })
    };
    let write = |file: &'static str, text: &'static str| -> Change<'static> {
        Box::new(move |p| fs::write(p.join(file), text).unwrap())
    };
    let times = |steps: [i64; 3]| -> Change<'static> {
        Box::new(move |p| {
            let mut bytes = fs::read(p.join("time/c/0")).unwrap();
            steps.iter().zip(bytes.chunks_exact_mut(8)).for_each(|(t, b)| b.copy_from_slice(&t.to_le_bytes()));
            fs::write(p.join("time/c/0"), bytes).unwrap();
        })
    };
    let gone = |file: &'static str| -> Change<'static> { Box::new(move |p| fs::remove_file(p.join(file)).unwrap()) };
    let cases: Vec<(Change<'static>, &str)> = vec![
        (write("zarr.json", "{ \"zarr_format\": 3"), "not valid JSON"),
        (write("zarr.json", "{ \"zarr_format\": 3 }"), "no recording"),
        (Box::new(|p| with_root(p, |r| r["consolidated_metadata"] = Value::Null)), "time"),
        (array("time", "shape", json!([u64::MAX])), "time"),
        (array("time", "shape", json!([1u64 << 40])), "frames"),
        (piece("time", json!([1u64 << 20])), "pieces of 1024"),
        (times([0, 20, 10]), "frame 1 is of step 20, frame 2 of step 10"),
        (times([0, 10, 10]), "frame 1 is of step 10, frame 2 of step 10"),
        (times([0, -5, 10]), "frame 1 is of step -5"),
        (times([0, 10, 1 << 60]), "which no run comes to"),
        (array("y", "shape", json!([12])), "12 cells along y, `height` has 9"),
        (array("y", "dimension_names", json!(["x"])), "no such"),
        (array("height", "dimension_names", json!(["y", "time", "x"])), "no such"),
        (array("height", "shape", json!([2, 9, 140])), "3 frames"),
        (array("time", "shape", json!([4])), "steps that do not increase"),
        (array("time", "shape", json!([2, 2])), "time"),
        (array("time", "data_type", json!("float64")), "time"),
        (piece("time", json!([1u64 << 50])), "time"),
        (gone("time/c/0"), "missing"),
        (write("time/c/0", "short"), "time"),
        (gone(".frames/1.eyot"), "frame 1 is missing"),
        (write(".frames/1.eyot", "EYOTCKPT"), "1.eyot"),
        (write(".frames/1.eyot", "garbage of some length that is no head"), "no Eyot checkpoint"),
        (gone("height/c/1/0/0"), "a chunk of frame 1 is missing"),
        (write("height/c/1/0/0", "garbage"), "height"),
        (array("height", "shape", json!([3, 9, 141])), "cells along x"),
        (array("height", "shape", json!([3, 1u64 << 40, 1u64 << 20])), "height"),
        (array("height", "shape", json!([])), "height"),
        (array("height", "shape", json!([1, 9, 140])), "no such"),
        (piece("height", json!([1, 1, 1])), "height"),
        (piece("height", json!([1u64 << 40, 512, 512])), "height"),
        (array("flux_x", "shape", json!([3, 9, 140])), "cells along x"),
        (
            Box::new(|p| {
                with_root(p, |r| drop(r["consolidated_metadata"]["metadata"].as_object_mut().unwrap().remove("height")))
            }),
            "does not name",
        ),
        (Box::new(|p| with_root(p, |r| r["consolidated_metadata"]["metadata"]["../up"] = Value::Null)), "../up"),
        (
            Box::new(|p| fs::copy(p.join(".frames/0.eyot"), p.join(".frames/1.eyot")).map(drop).unwrap()),
            "its time is 10",
        ),
    ];
    for (change, part) in cases {
        let (_folder, path) = place();
        drop(recorded(&path, PLENTY, [0, 10, 20]));
        change(&path);
        let read = || -> eyot_io::Result<()> {
            Timeline::open(&path, &Limits::default())?.load(1, &ComponentKinds::core()).map(drop)
        };
        let e = read().expect_err(part).to_string();
        assert!(e.contains(part) && e.contains("timeline.zarr"), "{part}: {e}");
    }
    let (_folder, path) = place();
    drop(recorded(&path, PLENTY, [0]));
    let small = Limits { max_cells: 100, ..Limits::default() };
    assert!(Timeline::open(&path, &small).unwrap_err().to_string().contains("cells"));
    fs::write(path.join(".frames/thinning.json"), "{\"frames\": 9, \"keep\": [[5, 1]], \"dropped\": true}").unwrap();
    assert!(Timeline::open_to_write(&path, &Limits::default()).unwrap_err().to_string().contains("thinning.json"));
}

/// A frame without its head, one whose head is garbage and one without a chunk: the others can be read, copied, thinned out and
/// gone on with.
#[test]
fn frames_that_are_lost_harm_no_others() {
    let (folder, path) = place();
    drop(recorded(&path, PLENTY, [0, 10, 20, 30, 40, 50]));
    fs::remove_file(path.join(".frames/1.eyot")).unwrap();
    fs::write(path.join(".frames/2.eyot"), "garbage of some length that is no head").unwrap();
    fs::remove_file(path.join("height/c/4/0/0")).unwrap();
    let assert_rest = |t: &Timeline, whole: &[usize]| {
        for i in 0..t.frames().len() {
            let loaded = t.load(i, &ComponentKinds::core());
            assert_eq!(loaded.is_ok(), whole.contains(&i), "frame {i}");
            assert_eq!(t.look(i).is_ok(), loaded.is_ok(), "frame {i}");
            if let Ok(saved) = loaded {
                assert_eq!(saved.world, world(t.frames()[i].step));
            }
        }
    };
    let t = Timeline::open(&path, &Limits::default()).unwrap();
    assert_eq!(steps(&t), [0, 10, 20, 30, 40, 50]);
    assert_eq!(t.frames().iter().map(|f| f.is_there).collect::<Vec<_>>(), [true, false, true, true, true, true]);
    assert_rest(&t, &[0, 3, 5]);
    assert!(t.load(1, &ComponentKinds::core()).unwrap_err().to_string().contains("frame 1 is missing"));
    let copy = t.copy(4, &folder.path().join("copy.zarr")).unwrap();
    assert_rest(&copy, &[0, 3]);
    let mut t = Timeline::open_to_write(&path, &Limits::default()).unwrap();
    t.append(&world(60), "name = \"Test\"", &state(60)).unwrap();
    assert_rest(&t, &[0, 3, 5, 6]);
    // With no room left, the missing frame goes first, and what is damaged moves with its number.
    let max_bytes = (320 << 10) + 6 * t.frames()[6].bytes;
    t.set_record(Record { max_bytes, ..PLENTY }).unwrap();
    let mut later = 60;
    while steps(&t).contains(&10) {
        later += 10;
        t.append(&world(later), "name = \"Test\"", &state(later)).unwrap();
    }
    let again = Timeline::open(&path, &Limits::default()).unwrap();
    assert_eq!(again.frames(), t.frames());
    for (i, frame) in again.frames().iter().enumerate().filter(|(_, f)| ![20, 40].contains(&f.step)) {
        assert_eq!(
            again.load(i, &ComponentKinds::core()).unwrap().world,
            world(frame.step),
            "frame {i} of step {}",
            frame.step
        );
    }
}
