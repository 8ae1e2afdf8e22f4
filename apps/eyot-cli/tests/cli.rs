//! The command as people meet it: what it prints, what it leaves, how it ends.

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn eyot(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eyot")).args(args).current_dir(folder).output().expect("the command starts")
}

/// Runs the command; checks its exit code and that nothing broke; returns both outputs together.
fn said(folder: &Path, args: &[&str], code: i32) -> String {
    let o = eyot(folder, args);
    let text = format!("{}{}", String::from_utf8_lossy(&o.stdout), String::from_utf8_lossy(&o.stderr));
    assert!(!text.contains("panicked"), "{args:?}: {text}");
    assert_eq!(o.status.code(), Some(code), "{args:?}: {text}");
    text
}

const SMALL: &str = "name = \"Small\"\n[grid]\nsize = 24\ncell = 20.0\n[[step]]\nname = \"hill\"\ngenerate = \"cone\"\nheight = 200.0\n[[export]]\nformat = \"r32\"\n[view]\nsize = [64, 48]\n";

#[test]
fn a_run_from_recipe_to_picture() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    std::fs::write(f.join("small.toml"), SMALL).unwrap();
    assert!(said(f, &["check", "small.toml"], 0).contains("the recipe is sound"));
    let text = said(f, &["run", "small.toml", "--set", "hill.height=300", "--seed", "4", "--threads", "1"], 0);
    assert!(text.contains("writing small/height.r32") && text.contains("fingerprint"), "{text}");
    assert_eq!(said(f, &["run", "small.toml", "--out", "quiet", "--quiet"], 0), "");
    assert!(said(f, &["stats", "small"], 0).contains("24 x 24 cells"));
    let stats: serde_json::Value = serde_json::from_str(&said(f, &["stats", "small", "--json"], 0)).unwrap();
    assert!(stats.is_object());
    said(f, &["render", "small", "--size", "64x48", "--azimuth", "-30"], 0);
    said(f, &["render", "small", "--layer", "height", "--out", "map.png"], 0);
    assert!(f.join("small/render.png").is_file() && f.join("map.png").is_file());
    assert!(said(f, &["render", "small", "--layer", "heigt"], 2).contains("did you mean --layer height?"));
    assert!(said(f, &["resume", "small"], 2).contains("the run there is finished"));
}

#[test]
fn json_is_one_event_a_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let text = said(folder.path(), &["run", "small.toml", "--json"], 0);
    let events: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
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
    std::fs::write(f.join("empty.png"), []).unwrap();
    std::fs::write(f.join("bad.eyot"), b"EYOTCKPT\x01").unwrap();
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
        (&["resume", "nothere"], "--out"),
        (&["resume", "."], "stopped run"),
        (&["new", "a", "--from", "iland"], "did you mean --from island?"),
        (&["new", "nothere/a"], "choose a place that exists"),
        (&["describe", "conne"], "did you mean `cone`?"),
        (&["render", "nothere"], "height map"),
        (&["render", "."], "holds no run"),
        (&["render", "noise.tif"], "noise.tif"),
        (&["stats", "empty.png"], "empty.png"),
        (&["stats", "bad.eyot"], "bad.eyot"),
        (&["render", "noise.tif", "--azimuth", "north"], "-360 to 360"),
        (&["frobnicate"], "--help"),
        (&[], "Usage"),
    ];
    for (args, answer) in cases {
        let text = said(f, args, 2);
        // The report wraps long lines.
        let flat = text.split_whitespace().filter(|w| *w != "|").collect::<Vec<_>>().join(" ");
        assert!(flat.contains(answer), "{args:?}\n{text}");
    }
    assert!(!f.join("small").exists(), "a refused run leaves nothing");
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    let text = said(folder.path(), &["run", "small.toml", "--out", "small.toml"], 1);
    assert!(text.contains("--out"), "{text}");
}

#[test]
fn new_recipes_are_sound_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    for from in ["island", "atoll", "real", "alps", "canyon"] {
        said(folder.path(), &["new", from, "--from", from], 0);
        said(folder.path(), &["check", &format!("{from}.toml")], 0);
    }
    assert!(said(folder.path(), &["new", "island"], 2).contains("nothing is overwritten"));
}

#[test]
fn words_are_printed_and_parse() {
    let here = Path::new(".");
    assert!(said(here, &["list"], 0).contains("island"));
    assert!(said(here, &["describe", "cone"], 0).contains("unit m"));
    for args in [&["list", "--json"][..], &["describe", "cone", "--json"], &["schema"]] {
        let value: serde_json::Value = serde_json::from_str(&said(here, args, 0)).unwrap();
        assert!(value.is_object());
    }
    assert!(said(here, &["--help"], 0).contains("Examples:"));
    assert!(said(here, &["run", "--help"], 0).contains("--set"));
}

#[test]
fn a_reader_who_leaves_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_eyot"))
        .arg("schema")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let o = child.wait_with_output().unwrap();
    assert!(!String::from_utf8_lossy(&o.stderr).contains("panicked"));
    assert_eq!(o.status.code(), Some(0));
}

/// Needs a process to have something to interrupt.
#[cfg(unix)]
#[test]
fn an_interrupted_run_can_be_resumed() {
    let list: serde_json::Value = serde_json::from_str(&said(Path::new("."), &["list", "--json"], 0)).unwrap();
    let Some(process) = list["processes"][0]["name"].as_str() else { return };
    let folder = tempfile::tempdir().unwrap();
    let long = format!("{SMALL}[[step]]\nsimulate = [\"{process}\"]\nsteps = 1000000000\n");
    std::fs::write(folder.path().join("long.toml"), long).unwrap();
    for (args, signal) in [(["run", "long.toml"], "-INT"), (["resume", "long"], "-TERM")] {
        let child = Command::new(env!("CARGO_BIN_EXE_eyot"))
            .args(args)
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_secs(2));
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let o = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&o.stderr);
        assert_eq!(o.status.code(), Some(130), "{text}");
        assert!(text.contains("eyot resume long"), "{text}");
        assert!(folder.path().join("long/checkpoint.eyot").is_file());
    }
}
