//! The command as people meet it: what it prints, what it leaves, how it ends.

use crate::common;

use common::{assert_said, eyot, said};
use std::path::Path;
use std::process::Stdio;

/// What a command prints as JSON.
fn json(folder: &Path, args: &[&str]) -> serde_json::Value {
    let o = eyot(folder, args).output().unwrap();
    assert_said(&o, 0, &[]);
    serde_json::from_slice(&o.stdout).unwrap()
}

const SMALL: &str = "name = \"Small\"\n[grid]\nsize = 24\ncell = 20.0\n[[step]]\nname = \"hill\"\ngenerate = \"cone\"\nheight = 200.0\n[[export]]\nformat = \"r32\"\n[view]\nsize = [64, 48]\n";

#[test]
fn a_run_from_recipe_to_picture() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    said(f, &["check", "small.toml"], 0, &["the recipe is sound"]);
    let effective = ["check", "small.toml", "--effective", "--set", "hill.height=300"];
    let effective = eyot(f, &effective).output().unwrap();
    assert_said(&effective, 0, &["height = 300"]);
    std::fs::write(f.join("all.toml"), effective.stdout).unwrap();
    said(f, &["check", "all.toml"], 0, &["the recipe is sound"]);
    let bare = "[grid]\nsize = 24\n[[step]]\nsimulate = \"hydraulic\"\n";
    std::fs::write(f.join("bare.toml"), bare).unwrap();
    let doubted = said(f, &["check", "bare.toml"], 0, &["no step before it makes the layer `height`"]);
    assert!(!doubted.contains("sound"), "{doubted}");
    let text = said(f, &["run", "small.toml", "--set", "hill.height=300", "--seed", "4", "--threads", "1"], 0, &[]);
    assert!(text.contains("writing small/height.r32") && text.contains("fingerprint"), "{text}");
    assert_eq!(said(f, &["run", "small.toml", "--out", "quiet", "--quiet"], 0, &[]), "");
    said(f, &["stats", "small"], 0, &["24 x 24 cells"]);
    let stats: serde_json::Value = json(f, &["stats", "small", "--json"]);
    assert!(stats.is_object());
    // Cells of 20 m: what makes a channel is an area that can be set, and is printed.
    assert_eq!(json(f, &["stats", "small", "--json", "--channel-area", "8000"])["channel_area_m2"], 8000.0);
    let table = said(f, &["stats", "small", "--csv", "--channel-area", "8000"], 0, &[]);
    assert!(table.starts_with("measure,value cells,576 ") && table.contains(" channel_area_m2,8000.0 "), "{table}");
    assert!(table.contains(" landforms.peak,") && table.split(' ').all(|l| l.split(',').count() == 2), "{table}");
    said(f, &["stats", "small", "--channel-area", "-1"], 2, &["an area in m2, above 0"]);
    said(f, &["render", "small", "--size", "64x48", "--azimuth", "-30"], 0, &[]);
    said(f, &["render", "small", "--layer", "height", "--out", "map.png"], 0, &[]);
    assert!(f.join("small/render.png").is_file() && f.join("map.png").is_file());
    // A section: its areas are those of the cells of a row.
    said(f, &["section", "small"], 0, &["wrote small/section.png: 480 m long", "ground"]);
    let cut = ["section", "small", "--line", "0m,5m,480m,5m", "--out", "cut.svg", "--exaggeration", "2", "--json"];
    let cut = json(f, &cut);
    assert!(f.join("cut.svg").is_file() && cut["exaggeration"] == 2.0 && cut["length_m"] == 480.0, "{cut}");
    said(f, &["section", "small", "--line", "0,0,1"], 2, &["x0,y0,x1,y1"]);
    said(f, &["section", "small", "--line", "-1,0.5,1,0.5"], 2, &["shares from 0 to 1"]);
    let long = said(f, &["section", "small", "--line", &"9".repeat(300)], 2, &["is no line"]);
    assert!(!long.contains(&"9".repeat(100)), "{long}");
    said(f, &["section", "small", "--line", "0m,0m,9m,999m"], 2, &["outside the land of 480 x 480 m"]);
    said(f, &["section", "small", "--out", "cut.jpg"], 2, &["ends in .png or .svg"]);
    // Without a word more it is the run's own picture, and a changed view is that of the run.
    let view = ["view.azimuth=70", "view.size=[80, 56]", "view.sun_elevation=12"];
    let set: Vec<&str> = view.iter().flat_map(|v| ["--set", v]).collect();
    said(f, &[&["run", "small.toml", "--out", "seen"], &set[..]].concat(), 0, &[]);
    said(f, &["render", "seen", "--engine", "cpu"], 0, &["heights to scale"]);
    said(
        f,
        &["render", "seen", "--engine", "cpu", "--sun-elevation", "50", "--exaggeration", "2", "--out", "noon.png"],
        0,
        &["heights times 2"],
    );
    let bytes = |name: &str| std::fs::read(f.join(name)).unwrap();
    assert_eq!(bytes("seen/render.png"), bytes("seen/preview.png"));
    assert_ne!(bytes("noon.png"), bytes("seen/preview.png"));
    assert_eq!(bytes("noon.png")[16..24], bytes("seen/preview.png")[16..24]);
    said(f, &["render", "small", "--layer", "heigt"], 2, &["did you mean --layer height?"]);
    said(f, &["resume", "small"], 2, &["the run there is finished"]);
}

#[test]
fn json_is_one_event_a_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let o = eyot(folder.path(), &["run", "small.toml", "--json"]).output().unwrap();
    assert_said(&o, 0, &[]);
    let events: Vec<serde_json::Value> =
        String::from_utf8(o.stdout).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(events.first().unwrap()["event"], "started");
    assert_eq!(events.last().unwrap()["event"], "done");
}

#[test]
fn every_wrong_thing_is_answered_with_place_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("typo.toml"), SMALL.replace("height", "hieght")).unwrap();
    std::fs::write(f.join("broken.toml"), "name = \"x\n").unwrap();
    std::fs::write(f.join("binary.toml"), [0xff, 0xfe, 0, 1]).unwrap();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    std::fs::write(f.join("noise.tif"), [7; 100]).unwrap();
    std::fs::write(f.join("noise.r32"), [7; 100]).unwrap();
    std::fs::write(f.join("empty.png"), []).unwrap();
    std::fs::write(f.join("bad.eyot"), b"EYOTCKPT\x01").unwrap();
    std::fs::write(f.join("empty.json"), "{}").unwrap();
    // What a run leaves that is killed at once: the lock, by the number of a process that is no more.
    std::fs::create_dir(f.join("killed")).unwrap();
    std::fs::write(f.join("killed/eyot.lock"), "4194304\n").unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["run", "typo.toml"], "did you mean `height`?"),
        (&["check", "typo.toml"], "typo.toml:8:1"),
        (&["check", "broken.toml"], "not valid TOML"),
        (&["check", "binary.toml"], "not UTF-8"),
        (&["run", "nothere.toml"], "eyot list"),
        (&["run", "ilsand"], "did you mean the built-in recipe `island`?"),
        (&["run", "."], "is not a file"),
        (&["run", "small.toml", "--set", "hill.heigt=3"], "did you mean `height`?"),
        (&["run", "small.toml", "--set", "grid.size=0"], "must be at least 1"),
        (&["run", "small.toml", "--set", "nonsense"], "write key=value"),
        (&["run", "small.toml", "--size", "0"], "512x256"),
        (&["run", "small.toml", "--size", "12y4"], "512x256"),
        (&["run", "small.toml", "--size", "4000000000"], "--max-memory"),
        (&["run", "small.toml", "--seed", "-1"], "--seed"),
        (&["run", "small.toml", "--threads", "0"], "1..=4096"),
        (&["run", "small.toml", "--max-memory", "1K"], "--max-memory"),
        (&["run", "small.toml", "--max-memory", "lots"], "8G"),
        (&["run", "small.toml", "--checkpoint-seconds", "-1"], "seconds"),
        (&["run", "small.toml", "--replay", "nothere.json"], "run.json"),
        (&["run", "small.toml", "--replay", "binary.toml"], "it is no JSON"),
        (&["run", "small.toml", "--replay", "small.toml"], "it is no JSON"),
        (&["run", "small.toml", "--replay", "empty.json"], "it lists no commands"),
        (&["run", "small.toml", "--record", "-1"], "write a whole number of at least 1"),
        (&["rewind", "killed", "--to", "-1"], "write a whole number of at least 0"),
        (&["run", "small.toml", "--set", "seed=-1"], "`seed` is -1: it must be at least 0"),
        (&["check", "small.toml", "--set", "hill.height=1e308"], "`cone.height` is 1e308"),
        (&["resume", "killed"], "was killed before it began"),
        (&["resume", "killed"], "holds no stopped run"),
        (&["resume", "nothere"], "--out"),
        (&["resume", "."], "stopped run"),
        (&["new", "a", "--from", "iland"], "did you mean --from island?"),
        (&["new", ".."], "is no name of a file"),
        (&["describe", "conne"], "did you mean `cone`?"),
        (&["run", "small.tml"], "did you mean `small.toml`?"),
        (&["check", "smal"], "did you mean `small.toml`?"),
        (&["check", "small.toml", "--set", "hill.height=0,5"], "write 0.5"),
        (&["render", "nothere"], "height map"),
        (&["render", "."], "holds no run"),
        (&["render", "noise.tif"], "noise.tif"),
        (&["stats", "empty.png"], "empty.png"),
        (&["stats", "bad.eyot"], "bad.eyot"),
        (&["render", "noise.tif", "--azimuth", "north"], "-360 to 360"),
        (&["run", "small.toml", "--seed", "99999999999999999999"], "from 0 to 18446744073709551615"),
        (&["run", "small.toml", "--set", "seed=99999999999999999999"], "at most 18446744073709551615"),
        (&["check", "small.toml", "--preset", "unreal", "--set", "grid.size=[1, 9]"], "`unreal` needs at least 2 x 2"),
        (&["check", "small.toml", "--max-memory", "100"], "the limit is 100 bytes"),
        (&["check", "small.toml", "--preset", "unity", "--stream", "always"], "cannot be streamed"),
        (&["convert", "nothere.tif", "a.png"], "nothere.tif"),
        (&["convert", "noise.tif", "a.png"], "noise.tif"),
        (&["convert", "noise.tif", "a.doc"], "does not say its format"),
        (&["render", "noise.r32", "--out", "a.jpg"], "ends in .png"),
        (&["bench", "drainage", "--size", "32768"], "--size"),
        (&["bench", "drainage", "--engine", "gpu"], "--engine cpu"),
        (&["bench", "hydraulic", "--engine", "gpu", "--size", "32768"], "--size"),
        (&["bench", "thermal", "--engine", "gpu", "--adapter", "no such card"], "no such card"),
        (&["frobnicate"], "--help"),
        (&[], "Usage"),
    ];
    for (args, answer) in cases {
        said(f, args, 2, &[answer]);
    }
    assert!(!f.join("small").exists(), "a refused run leaves nothing");
}

/// What messages say to do, the command that says it can do.
#[test]
fn commands_that_read_height_maps_take_the_flags_that_they_name() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let values: Vec<u8> = (0..24u8).flat_map(|i| f32::from(i * 10 % 70).to_le_bytes()).collect();
    std::fs::write(f.join("odd.raw"), &values).unwrap();
    for verb in ["stats", "render", "film"] {
        said(f, &[verb, "odd.raw"], 2, &["--from-size"]);
        let described = ["odd.raw", "--from-size", "6x4", "--from-type", "f32le", "--max-memory"];
        let with = |memory: &'static str| [&[verb][..], &described[..], &[memory]].concat();
        said(f, &with("1K"), 2, &["the limit is 1.0 KiB", "--max-memory"]);
        if verb == "stats" {
            said(f, &with("1G"), 0, &["6 x 4 cells"]);
        }
    }
    said(
        f,
        &["stats", "odd.raw", "--from-size", "6x4", "--from-type", "f32le", "--nodata", "10"],
        0,
        &["cells without a value"],
    );
}

/// Without graphics hardware the processor is measured instead, and so is what only the processor does.
#[test]
fn a_benchmark_of_either_engine_falls_back_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    for what in ["thermal", "drainage"] {
        let out = eyot(f, &["bench", what, "--engine", "auto", "--size", "32", "--seconds", "0.05"]).output().unwrap();
        let [stdout, stderr] = [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(stdout.starts_with(what), "{stdout}{stderr}");
        let by_processor = stdout.contains("threads");
        assert_eq!(stderr.contains("the processor is measured"), by_processor, "{stdout}{stderr}");
        assert!(by_processor || what != "drainage", "{stdout}");
    }
}

/// Whatever ends a run before its first step, `check` says as well, in the same words.
#[test]
fn check_refuses_what_run_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("noise.tif"), [7; 100]).unwrap();
    std::fs::write(f.join("odd.r32"), [7; 24]).unwrap();
    std::fs::write(f.join("nan.r32"), f32::NAN.to_le_bytes()).unwrap();
    // 2^20 x 2^20 values, of which none is there.
    let mut bomb = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1048576, 1048576), }";
    bomb.extend((header.len() as u16).to_le_bytes());
    bomb.extend(header.as_bytes());
    std::fs::write(f.join("bomb.npy"), bomb).unwrap();
    let import = |file: &str| format!("generate = \"import\"\nfile = \"{file}\"\n");
    let water = "generate = \"cone\"\n[[step]]\nsimulate = \"hydraulic\"\nsteps = 9\n";
    for (step, answer) in [
        (import("nothere.tif"), "there is no such file"),
        (import("noise.tif"), "no GeoTIFF"),
        (import("odd.r32"), "make no square"),
        (import("nan.r32"), "nodata"),
        (import("bomb.npy"), "too large"),
        (import("."), "is not a file"),
        (format!("{water}hydraulic.springs = 0.1\n"), "no step makes a layer `springs`"),
        (format!("{water}hydraulic.time_step = 1e6\n"), "time_step"),
        (format!("{water}every = 3\n"), "no key `every`"),
    ] {
        std::fs::write(f.join("a.toml"), format!("[grid]\nsize = 8\n[[step]]\n{step}")).unwrap();
        let refused = said(f, &["check", "a.toml"], 2, &[answer]);
        assert_eq!(said(f, &["run", "a.toml"], 2, &[]), refused);
    }
    assert!(!f.join("a").exists(), "a refused run leaves nothing");
    // What is switched off needs nothing.
    let off = format!("[grid]\nsize = 8\n[[step]]\n{water}hydraulic.springs = 0.1\nhydraulic.enabled = false\n");
    std::fs::write(f.join("a.toml"), off).unwrap();
    said(f, &["check", "a.toml"], 0, &[]);
}

/// Commands that people copy from messages work on any name of a folder.
#[test]
fn commands_in_messages_are_quoted() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    said(f, &["run", "small.toml", "--out", "my land", "--quiet"], 0, &[]);
    said(f, &["resume", "my land"], 2, &["`eyot render 'my land'`"]);
    said(f, &["new", "my recipe"], 0, &["eyot run 'my recipe.toml'"]);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    said(folder.path(), &["run", "small.toml", "--out", "small.toml"], 1, &["--out"]);
    said(folder.path(), &["new", "nothere/a"], 1, &["choose a place that exists"]);
}

#[test]
fn new_recipes_are_sound_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    for from in eyot::RECIPES.iter().map(|r| r.name) {
        said(folder.path(), &["new", from, "--from", from], 0, &[]);
        said(folder.path(), &["check", &format!("{from}.toml")], 0, &[]);
    }
    said(folder.path(), &["new", "island"], 2, &["nothing is overwritten"]);
}

#[test]
fn words_are_printed_and_parse() {
    let here = Path::new(".");
    said(here, &["list"], 0, &["island"]);
    said(here, &["describe", "cone"], 0, &["unit m"]);
    said(here, &["describe", "step"], 0, &["simulate", "generate", "mask"]);
    said(here, &["describe", "[[export]]"], 0, &["prefix"]);
    said(here, &["describe", "layers"], 0, &["sediment", "Changed by `hydraulic`"]);
    for table in ["grid", "view", "layer", "recipe"] {
        said(here, &["describe", table], 0, &["(table)"]);
    }
    for args in [&["list", "--json"][..], &["describe", "cone", "--json"], &["schema"]] {
        let value: serde_json::Value = json(here, args);
        assert!(value.is_object());
    }
    said(here, &["--help"], 0, &["Examples:"]);
    said(here, &["run", "--help"], 0, &["--set"]);
}

#[test]
fn sources_follow_the_recipe_and_come_once() {
    let here = Path::new(".");
    let text = said(here, &["cite", "island"], 0, &[]);
    let order = ["Eyot", "Perlin", "Xing Mei", "Jacob Olsen", "Bosscher"].map(|name| text.find(name).expect(name));
    assert!(order.is_sorted(), "{text}");
    assert_eq!(text.matches("An Image Synthesizer").count(), 1, "{text}");
    assert!(!text.contains("Radar"), "{text}");
    let off = said(here, &["cite", "island", "--set", "reef.enabled=false"], 0, &[]);
    assert!(off.contains("Xing Mei") && !off.contains("Bosscher"), "{off}");
    said(here, &["cite", "real", "--format", "bibtex"], 0, &["@article{farr2007,"]);
    let items: serde_json::Value = json(here, &["cite", "real", "--format", "json"]);
    assert_eq!((&items[0]["id"], &items[0]["type"]), (&"eyot".into(), &"software".into()));
    assert_eq!(items[1]["author"][0]["literal"], "NASA");
}

/// Thousands of mistakes are told in a few lines, and found in no time.
#[test]
fn very_many_mistakes_are_not_all_told() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let head = "[grid]\nsize = 8\n[[step]]\ngenerate = \"fbm\"\n";
    let keys: String = (0..20_000).map(|i| format!("k{i} = 1\n")).collect();
    let steps = "[[step]]\ngenerate = \"nope\"\n".repeat(20_000);
    let list = format!("[[step]]\ngenerate = \"remap\"\npoints = [{}]\n", "1, ".repeat(20_000));
    for (text, answer) in [
        (head.to_owned() + &keys, "`fbm` has no key"),
        (head.to_owned() + &steps, "`nope`"),
        (head.to_owned() + &list, "remap"),
    ] {
        std::fs::write(f.join("many.toml"), text).unwrap();
        let begun = std::time::Instant::now();
        let text = said(f, &["check", "many.toml"], 2, &[answer, "more; mend these first"]);
        assert!(text.len() < 40_000, "{} characters", text.len());
        assert!(begun.elapsed().as_secs() < 20, "{:?}", begun.elapsed());
    }
}

#[test]
fn a_reader_who_leaves_is_no_error() {
    let mut child = eyot(Path::new("."), &["schema"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert!(!String::from_utf8_lossy(&o.stderr).contains("panicked"));
    assert_eq!(o.status.code(), Some(0));
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let long = format!("{SMALL}[[step]]\nsimulate = [\"thermal\"]\nsteps = 1000000000\n");
    std::fs::write(folder.path().join("long.toml"), long).unwrap();
    for (args, signal) in [(["run", "long.toml"], "-INT"), (["resume", "long"], "-TERM")] {
        let child = common::start_until(folder.path(), &args, "step_begun", 1);
        common::signal(&child, signal);
        assert_said(&child.wait_with_output().unwrap(), 130, &["eyot resume long"]);
        assert!(folder.path().join("long/checkpoint.eyot").is_file());
    }
}

#[test]
fn an_endless_line_is_not_echoed() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let long = "x".repeat(100_000);
    std::fs::write(f.join("broken.toml"), format!("name = \"{long}\nseed = 1\n")).unwrap();
    std::fs::write(f.join("key.toml"), format!("{long} = 1\n{SMALL}")).unwrap();
    for args in [&["check", "broken.toml"][..], &["check", "key.toml"], &["run", "island", "--set", &long]] {
        let text = said(f, args, 2, &[]);
        assert!(text.len() < 8000, "{} characters", text.len());
        assert!(text.contains("of a long line"), "{text}");
    }
}

/// A grey picture that does not say which heights it means, 3 x 2.
const SILENT_PNG: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 3, 0, 0, 0, 2, 8, 0, 0, 0, 0, 184, 31, 57,
    198, 0, 0, 0, 16, 73, 68, 65, 84, 120, 156, 99, 96, 16, 80, 96, 248, 223, 224, 0, 0, 5, 69, 1, 240, 166, 192, 91,
    65, 0, 0, 0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

/// What its pixels hold.
const SILENT_PNG_GREYS: &[u8] = &[0, 16, 32, 255, 128, 64];

#[test]
fn a_picture_without_heights_gives_a_grid_and_the_right_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("grey.png"), SILENT_PNG).unwrap();
    let recipe = "[grid]\nfrom = \"grey.png\"\n[[step]]\ngenerate = \"import\"\nfile = \"grey.png\"\n";
    std::fs::write(f.join("bare.toml"), recipe).unwrap();
    std::fs::write(f.join("told.toml"), format!("{recipe}low_m = 0.0\nhigh_m = 90.0\n")).unwrap();
    said(f, &["check", "told.toml"], 0, &["3 x 2 cells of 10 m"]);
    said(f, &["run", "told.toml"], 0, &[]);
    for args in [["check", "bare.toml"], ["run", "bare.toml"]] {
        said(f, &args, 2, &["low_m and high_m in a recipe (generate = \"import\")"]);
    }
    said(f, &["convert", "grey.png", "grey.tif"], 2, &["--from-range"]);
    // To look at it needs no heights.
    said(f, &["render", "grey.png", "--relief"], 0, &["metres are assumed"]);
    said(f, &["stats", "grey.png"], 0, &["metres are assumed"]);
    let (low, high) = (SILENT_PNG_GREYS.iter().min().unwrap(), SILENT_PNG_GREYS.iter().max().unwrap());
    let stats = json(f, &["stats", "grey.png", "--json"]);
    let found = |key: &str| stats[key].as_f64().unwrap();
    assert_eq!((found("min_m"), found("max_m")), (f64::from(*low), f64::from(*high)));
}

/// Help that is given leads on; what cannot have an effect is refused, with the code of a refusal.
#[test]
fn remedies_fit_and_refusals_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let npy = |name: &str, descr: &str, bytes: &[u8]| {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 2), }}");
        let all = [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), bytes].concat();
        std::fs::write(f.join(name), all).unwrap();
    };
    npy("good.npy", "<f4", &[0; 16]);
    npy("nan.npy", "<f4", &[f32::NAN.to_le_bytes(); 4].concat());
    npy("huge.npy", "<f8", &[1e300f64.to_le_bytes(); 4].concat());
    assert!(!said(f, &["stats", "nan.npy"], 2, &["--nodata"]).contains("give the --out folder"));
    said(f, &["convert", "huge.npy", "a.tif"], 2, &["do not fit the 32 bits"]);
    std::fs::create_dir(f.join("plain.zarr")).unwrap();
    said(f, &["convert", "good.npy", "plain.zarr"], 2, &["is there already", "--force"]);
    let forced = ["convert", "good.npy", "plain.zarr", "--force"];
    assert!(!said(f, &forced, 1, &["holds no zarr.json"]).contains("other files"));
    said(f, &["convert", "good.npy", "a.tif", "--cell", "5"], 0, &[]);
    let before = std::fs::read(f.join("a.tif")).unwrap();
    said(f, &["convert", "good.npy", "a.tif", "--cell", "7"], 2, &["`a.tif` is there already; nothing was written"]);
    assert!(std::fs::read(f.join("a.tif")).unwrap() == before);
    said(f, &["convert", "good.npy", "a.tif", "--cell", "7", "--force"], 0, &[]);
    std::fs::write(f.join("a.r32.json"), "mine").unwrap();
    said(f, &["convert", "good.npy", "a.r32"], 2, &["`a.r32.json` is there already"]);
    said(f, &["convert", "good.npy", "b.tif", "--from-range", "0,1"], 2, &["leave out --from-range"]);
    for name in ["a.zarr", "x.TIF", "x.glb"] {
        said(f, &["convert", "good.npy", name, "--preset", "unity"], 2, &["would be a folder", "another name"]);
        assert!(!f.join(name).exists());
    }
    for flag in [["--azimuth", "5"], ["--elevation", "5"], ["--distance", "2"], ["--field-of-view", "30"]] {
        said(f, &["render", "good.npy", "--relief", flag[0], flag[1]], 2, &["cannot be used with"]);
        said(f, &["render", "good.npy", "--layer", "height", flag[0], flag[1]], 2, &["cannot be used with"]);
    }
    said(f, &["render", "good.npy", "--layer", "height", "--sun-azimuth", "9"], 2, &["cannot be used with"]);
    said(f, &["render", "good.npy", "--relief", "--sun-azimuth", "9"], 0, &[]);
}

/// The checksum of a checkpoint's header.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _: i32| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(u32::MAX, |crc, b| (0..8).fold(crc ^ u32::from(*b), step))
}

/// A saved world that somebody has forged, with its checksums right, writes nothing outside its folder.
#[test]
fn a_forged_world_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    said(f, &["run", "small.toml"], 0, &[]);
    let saved = eyot::formats::checkpoint::load(
        &f.join("small/world.eyot"),
        &eyot::Limits::default(),
        &eyot::component_kinds(),
    )
    .unwrap();
    let mut world = saved.world;
    // Eyot itself writes no such name: it is put in afterwards, with a checksum that fits.
    let spec = eyot::LayerSpec { name: "xxxxxxxxxx".into(), ..eyot::process::known::WATER };
    world.ensure(&spec, 1.0);
    let path = f.join("small/world.eyot");
    eyot::formats::checkpoint::save(&path, &world, &saved.recipe_toml, &saved.state).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.windows(10).position(|w| w == b"xxxxxxxxxx").unwrap();
    bytes[at..at + 10].copy_from_slice(b"../../../x");
    let end = 20 + u64::from_le_bytes(bytes[12..20].try_into().unwrap()) as usize;
    let sum = crc32(&bytes[..end]);
    bytes[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    std::fs::remove_file(f.join("small/run.json")).unwrap();
    for args in [
        &["resume", "small"][..],
        &["stats", "small"],
        &["render", "small", "--layer", "../../../x"],
        &["convert", "small", "deep/g", "--preset", "gis"],
    ] {
        said(f, args, 2, &["a layer is called"]);
    }
    assert!(!f.join("deep").exists());
}

#[test]
fn reliefs_have_the_size_that_was_asked_for_and_bad_places_are_found_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    said(f, &["run", "small.toml", "--set", "grid.size=[48, 30]"], 0, &[]);
    for (size, expected) in [("1000", [1000, 625]), ("100x300", [300, 188]), ("20", [20, 13])] {
        said(f, &["render", "small", "--relief", "--size", size, "--out", "r.png"], 0, &[]);
        let png = std::fs::read(f.join("r.png")).unwrap();
        let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        assert_eq!([side(16), side(20)], expected, "--size {size}");
    }
    // At this size a picture takes far longer than the test may.
    let big = ["render", "small", "--size", "16384x16384", "--out"];
    for out in ["nothere/r.png", "small", "/dev/null"] {
        said(f, &[&big[..], &[out]].concat(), 1, &[]);
    }
    said(f, &["render", "small", "--layer", "height", "--size", "400", "--out", "m.png"], 0, &[]);
    let width = |name: &str| u32::from_be_bytes(std::fs::read(f.join(name)).unwrap()[16..20].try_into().unwrap());
    assert_eq!(width("m.png"), 400);
}

#[test]
fn pictures_and_meshes_count_as_memory() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), format!("{SMALL}[[export]]\nformat = \"glb\"\n")).unwrap();
    let check = |set: &str, most: &str, code| {
        said(f, &["check", "small.toml", "--set", set, "--set", "grid.size=2000", "--max-memory", most], code, &[])
    };
    // The land alone: 64 MB while a generator is at work. Its view needs 400 MB, its mesh 1.6 GB.
    let text = check("view.size=[64, 64]", "200M", 2);
    assert!(text.contains("drawing the pictures") && text.contains("view.enabled=false"), "{text}");
    assert!(text.contains("terrain.glb") && text.contains("leave out this export"), "{text}");
    assert!(check("view.enabled=false", "200M", 2).contains("terrain.glb"));
    let text = check("export.2.enabled=false", "200M", 2);
    assert!(text.contains("drawing the pictures") && !text.contains("terrain.glb"), "{text}");
    check("view.size=[64, 64]", "2G", 0);
    // A large picture of small land.
    let args = ["check", "small.toml", "--max-memory", "100M", "--set", "view.size=[16384, 16384]"];
    said(f, &args, 2, &["make it smaller with `size`"]);
}

#[test]
fn a_wrong_instruction_set_is_refused_and_a_lesser_one_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    let with =
        |isa: &str| eyot(f, &["run", "small.toml", "--out", "out", "--restart"]).env("EYOT_ISA", isa).output().unwrap();
    assert_said(&with("avx3"), 2, &["avx3", "scalar, baseline"]);
    let mut worlds = ["scalar", "baseline", ""].map(|isa| {
        assert!(with(isa).status.success());
        std::fs::read(f.join("out/world.eyot")).unwrap()
    });
    worlds.sort();
    assert_eq!(worlds.first(), worlds.last());
}

/// Lists in statistics are tables: no line of the text is JSON, and none has digits that say nothing.
#[test]
fn statistics_of_a_planet_are_tables() {
    let dir = tempfile::tempdir().unwrap();
    let f = dir.path();
    said(f, &["run", "world", "--size", "32", "--set", "drift.steps=4", "--set", "life.steps=8", "--quiet"], 0, &[]);
    let output = eyot(f, &["stats", "world"]).output().unwrap();
    assert_said(&output, 0, &["zonal", "land_rain_mm", "plates", "speed_m_per_year", "shares"]);
    let words = String::from_utf8(output.stdout).unwrap();
    for line in words.lines() {
        assert!(!line.contains("{\"") && !line.contains('['), "{line}");
        let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count();
        assert!(line.split_whitespace().all(|word| digits(word) <= 12), "{line}");
    }
    // Twelve belts from the north, in columns as wide as their names.
    let lines: Vec<&str> = words.lines().collect();
    let zonal = lines.iter().position(|l| l.trim() == "zonal").unwrap();
    let belts = &lines[zonal + 1..zonal + 14];
    assert!(belts.iter().all(|l| l.len() == belts[0].len()), "{belts:#?}");
    assert!(belts[12].contains("-82.500"), "{belts:#?}");
}

/// A recipe or a file of somebody else must not steer the terminal of whoever looks at it.
#[test]
fn escape_sequences_in_names_do_not_reach_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let wild = "\\u001b]0;owned\\u0007\\u009b31m";
    let text = SMALL.replace("\"Small\"", &format!("\"a{wild}b\"")).replace("\"hill\"", &format!("\"c{wild}d\""));
    std::fs::write(f.join("wild.toml"), &text).unwrap();
    let raw = "\u{1b}[2J";
    std::fs::write(f.join("raw.toml"), format!("{SMALL}# {raw}\nheihgt{raw} = 3 # {raw}\n")).unwrap();
    std::fs::write(f.join("odd.toml"), SMALL.replace("height = 200.0", "height = \"\\u001b[2J\"")).unwrap();
    let runs: [&[&str]; 5] = [
        &["run", "wild.toml", "--out", "out"],
        &["check", "wild.toml"],
        &["check", "raw.toml"],
        &["check", "odd.toml"],
        &["stats", "out"],
    ];
    for args in runs {
        let o = eyot(f, args).output().unwrap();
        for bytes in [&o.stdout, &o.stderr] {
            let said = String::from_utf8_lossy(bytes);
            assert!(!said.contains(['\u{1b}', '\u{7}', '\u{9b}']), "{args:?}: {said:?}");
        }
    }
}

#[test]
fn a_prefix_that_is_too_long_for_a_file_name_is_refused_by_the_check() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let with =
        |n: usize| SMALL.replace("format = \"r32\"", &format!("format = \"r32\"\nprefix = \"{}\"", "p".repeat(n)));
    std::fs::write(f.join("long.toml"), with(250)).unwrap();
    said(f, &["check", "long.toml"], 2, &["a file name of 260 bytes", "shorter `prefix`"]);
    std::fs::write(f.join("good.toml"), with(230)).unwrap();
    said(f, &["check", "good.toml"], 0, &[]);
    said(f, &["run", "good.toml", "--out", "out"], 0, &[]);
}

/// Hours of work must not end in a refusal that could be foreseen.
#[test]
fn the_check_refuses_what_a_run_would_refuse_at_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("a.toml"), "[grid]\nsize = 6000\n[[step]]\ngenerate = \"cone\"\nheight = 300.0\n").unwrap();
    // One layer of 137 MiB fits, its pictures do not.
    let tight = ["check", "a.toml", "--max-memory", "1500M"];
    said(f, &tight, 0, &[]);
    said(f, &[&tight[..], &["--stream", "never"]].concat(), 2, &["in one piece, with its files,"]);
    said(f, &["check", "reef", "--max-memory", "80M"], 2, &["dive.png"]);
}
