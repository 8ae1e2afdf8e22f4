//! Streamed runs: the files of a run in one piece, less memory, and stops that lose nothing.

use crate::common;

use common::recipe;
use eyot::store::{self, Subject};
use eyot::{Command, Event, Limits, Overrides, Recipe, Registry, Run, RunError, RunOptions, Stream, View};
use std::collections::BTreeMap;
use std::path::Path;

/// So wide that its rows are made in several bands.
const WIDE: &str = r#"
    name = "Wide"
    seed = 3
    [grid]
    size = [20000, 430]
    cell = 15.0
    [[step]]
    generate = "fbm"
    octaves = 2
    [[step]]
    generate = "ramp"
    layer = "share"
    high = 1.0
    [[step]]
    generate = "smooth"
    sigma_m = 60.0
    mask = "share"
    [view]
    size = [64, 48]
"#;

const EXPORTS: [&str; 11] = [
    "format = \"geotiff\"\nlayers = [\"height\", \"share\"]",
    "format = \"zarr\"\nlayers = [\"height\", \"share\"]",
    "format = \"exr\"\nlayers = [\"height\", \"share\"]",
    "format = \"r32\"\nfirst_row = \"south\"",
    "format = \"r16\"",
    "format = \"png16\"",
    "format = \"npy\"",
    "preset = \"gis\"\nprefix = \"gis_\"",
    "what = \"mask\"\nlayers = [\"share\", \"rock\"]",
    "what = \"splat\"\nrock_slope = 10.0",
    "format = \"npy\"\nlayers = [\"sand\"]",
];

fn parse(text: &str, exports: &[&str], limits: &Limits) -> Result<Recipe, String> {
    common::parse(text, exports, Overrides::default(), limits)
}

fn options(out: &Path, stream: Stream) -> RunOptions {
    RunOptions { out: Some(out.to_owned()), stream, ..RunOptions::default() }
}

/// All files below a folder by their names, but for the report, which tells times.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            let inner = files(&entry.path());
            found.extend(inner.into_iter().map(|(n, bytes)| (format!("{name}/{n}"), bytes)));
        } else if name != "run.json" {
            found.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    found
}

/// The same files with the same bytes. `pictures` are those that see means of cells in a streamed run.
fn assert_same(mut streamed: BTreeMap<String, Vec<u8>>, mut whole: BTreeMap<String, Vec<u8>>, pictures: &[&str]) {
    assert!(whole.remove("world.eyot").is_some());
    for picture in pictures {
        assert!(streamed.remove(*picture).is_some() && whole.remove(*picture).is_some(), "{picture}");
    }
    assert_eq!(streamed.keys().collect::<Vec<_>>(), whole.keys().collect::<Vec<_>>());
    for (name, bytes) in &streamed {
        assert!(bytes == &whole[name], "{name} differs");
    }
}

#[test]
fn files_are_those_of_a_run_in_one_piece() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["streamed", "whole"].map(|n| folder.path().join(n));
    let streamed = Run::start(recipe(WIDE, &EXPORTS), options(&a, Stream::Always)).unwrap().join().unwrap();
    let whole = Run::start(recipe(WIDE, &EXPORTS), options(&b, Stream::Never)).unwrap().join().unwrap();
    assert_eq!(streamed.fingerprint, whole.fingerprint);
    assert_eq!((streamed.world.grid.width, streamed.world.grid.height), (2000, 43));
    assert_same(files(&a), files(&b), &["preview.png", "relief.png"]);
}

/// A grid that needs no overview also has the same pictures.
#[test]
fn pictures_of_small_worlds_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["streamed", "whole"].map(|n| folder.path().join(n));
    let text = WIDE.replace("[20000, 430]", "[300, 200]");
    let exports = ["what = \"map\"\nlayers = [\"height\", \"share\"]"];
    Run::start(recipe(&text, &exports), options(&a, Stream::Always)).unwrap().join().unwrap();
    Run::start(recipe(&text, &exports), options(&b, Stream::Never)).unwrap().join().unwrap();
    assert_same(files(&a), files(&b), &[]);
}

#[test]
fn a_stopped_run_goes_on_with_the_file_that_it_was_writing() {
    let folder = tempfile::tempdir().unwrap();
    let [out, whole] = ["stopped", "whole"].map(|n| folder.path().join(n));
    let exports = ["format = \"r32\"", "format = \"npy\""];
    let paused = RunOptions { paused: true, ..options(&out, Stream::Always) };
    let handle = Run::start(recipe(WIDE, &exports), paused).unwrap();
    let mut at_second = false;
    for event in handle.events() {
        match event {
            Event::Writing { path } => at_second |= path.ends_with("height.npy"),
            Event::Paused { .. } if at_second => assert!(handle.send(Command::Stop)),
            Event::Paused { .. } => assert!(handle.send(Command::Step(1))),
            _ => {}
        }
    }
    let outcome = handle.join().unwrap();
    assert!(at_second && !outcome.finished);
    let names: Vec<String> = files(&out).into_keys().collect();
    assert_eq!(names, ["checkpoint.eyot", "height.r32", "height.r32.json"]);
    let made = |name: &str| std::fs::metadata(out.join(name)).unwrap().modified().unwrap();
    let first = made("height.r32");

    let refused = Run::start(recipe(WIDE, &exports), options(&out, Stream::Always));
    assert!(matches!(refused, Err(RunError::Unfinished { .. })));
    let resumed = Run::resume(&out, &Registry::standard(), RunOptions::default()).unwrap().join().unwrap();
    assert!(resumed.finished);
    assert_eq!(made("height.r32"), first, "a whole file was written again");
    Run::start(recipe(WIDE, &exports), options(&whole, Stream::Never)).unwrap().join().unwrap();
    assert_same(files(&out), files(&whole), &["preview.png", "relief.png"]);
}

/// There is no `world.eyot` to look at later, but there are the exports.
#[test]
fn streamed_runs_are_opened_by_their_exports() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let text = WIDE.replace("[20000, 430]", "[120, 90]").replace("seed = 3", "seed = 3\nsea_level = 12.0");
    Run::start(recipe(&text, &EXPORTS[..1]), options(&out, Stream::Always)).unwrap().join().unwrap();
    let opened = store::open(&out, &Limits::default()).unwrap();
    assert!(opened.has_sea && opened.world.sea_level_m == 12.0);
    assert!(opened.file.ends_with("height.tif"), "{opened:?}");
    store::draw(&opened.world, &View::default(), Subject::Relief, &out.join("again.png"), &Limits::default()).unwrap();
    let bare = folder.path().join("bare");
    Run::start(recipe(&text, &[]), options(&bare, Stream::Always)).unwrap().join().unwrap();
    let e = store::open(&bare, &Limits::default()).unwrap_err().to_string();
    assert!(e.contains("streamed run") && e.contains("run it again"), "{e}");
}

#[test]
fn what_does_not_fit_is_streamed_or_refused_with_its_place() {
    let tight = Limits { max_bytes: 1000 << 20, ..Limits::default() };
    let large = "[grid]\nsize = 12000\n[[step]]\ngenerate = \"fbm\"\n";
    assert!(parse(large, &["format = \"geotiff\""], &tight).is_ok());
    let refused = [
        (
            format!("{large}[[step]]\nsimulate = [\"thermal\"]\n"),
            "",
            "step 2 (thermal): a simulation needs the whole grid",
        ),
        (large.to_owned(), "format = \"glb\"", "the export `terrain.glb` needs the whole grid"),
        (large.to_owned(), "preset = \"unity\"", "needs the whole grid in memory"),
        (
            format!("{large}[[step]]\ngenerate = \"import\"\nfile = \"builtin:jacksboro.tif\"\n"),
            "",
            "step 2 (import): `import` as it is used here needs the whole grid",
        ),
    ];
    for (text, export, message) in &refused {
        let exports = if export.is_empty() { &[][..] } else { &[*export][..] };
        let problem = parse(text, exports, &tight).map(|_| ()).unwrap_err();
        assert!(problem.contains(message) && problem.contains("`max_memory`"), "{problem}");
        // With more memory all of them are sound.
        parse(text, exports, &Limits { max_bytes: 32 << 30, ..Limits::default() }).unwrap();
    }
    let less = Limits { max_bytes: 100 << 20, ..Limits::default() };
    let problem = parse(large, &[], &less).map(|_| ()).unwrap_err();
    assert!(problem.contains("even streamed") && problem.contains("`max_memory`"), "{problem}");
}

#[test]
fn streams_are_not_forced() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[grid]\nsize = 64\n[[step]]\ngenerate = \"fbm\"\n[[step]]\nsimulate = [\"thermal\"]\n";
    let always = options(folder.path(), Stream::Always);
    let Err(e) = Run::start(recipe(text, &[]), always) else { panic!("a simulation was streamed") };
    assert!(e.to_string().contains("step 2 (thermal)") && e.help().is_some(), "{e}");
    let large = "[grid]\nsize = 12000\n[[step]]\ngenerate = \"fbm\"\n";
    let tight = Limits { max_bytes: 1000 << 20, ..Limits::default() };
    let never = RunOptions { limits: tight, ..options(folder.path(), Stream::Never) };
    let Err(e) = Run::start(parse(large, &[], &tight).unwrap(), never) else { panic!("it does not fit") };
    assert!(e.to_string().contains("in one piece"), "{e}");
}
