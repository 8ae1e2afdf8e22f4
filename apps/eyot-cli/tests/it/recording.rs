//! Recordings from the command line: kills while frames come and go, ways back, and what is refused.

use crate::common;

use common::{SHORE, assert_same, contents, eyot, said};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Room for a dozen frames of some seventy.
const RECORD: &[&str] = &["--record", "20", "--record-limit", "2500K", "--checkpoint-seconds", "0.3"];

fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    // A smaller and shorter one; the later steps first, as the others become what they were.
    let sizes = [("[150, 110]", "[90, 70]"), ("steps = 900", "steps = 500"), ("steps = 1600", "steps = 900")];
    let shore = sizes.iter().fold(SHORE.to_owned(), |text, (from, to)| text.replace(from, to));
    std::fs::write(folder.path().join("shore.toml"), shore).unwrap();
    folder
}

/// The results of a run, and its recording removed.
fn results(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let recording = out.join("timeline.zarr");
    if recording.exists() {
        std::fs::remove_dir_all(recording).unwrap();
    }
    contents(out)
}

/// Bytes of all files of a folder.
fn bytes(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    entries.map(|e| if e.path().is_dir() { bytes(&e.path()) } else { e.metadata().map_or(0, |m| m.len()) }).sum()
}

/// What the command says of a recording.
fn frames(folder: &Path, out: &str) -> Vec<u64> {
    let o = eyot(folder, &["timeline", out, "--json"]).output().expect("the command starts");
    assert!(o.status.success(), "{}", common::text(&o));
    let list: serde_json::Value = serde_json::from_slice(&o.stdout).expect("JSON");
    list["frames"].as_array().unwrap().iter().map(|f| f["steps_done"].as_u64().unwrap()).collect()
}

fn assert_sound(steps: &[u64], what: &str) {
    assert!(steps.windows(2).all(|w| w[0] < w[1]), "{what}: {steps:?}");
    assert!(steps.first().is_none_or(|s| *s == 0), "{what}: {steps:?}");
}

/// Starts a command and kills it after a time. True if it was still at work.
fn kill_after(folder: &Path, args: &[&str], time: Duration) -> bool {
    let mut child = eyot(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command starts");
    let begun = Instant::now();
    while begun.elapsed() < time {
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    // SIGKILL: nothing in the program can answer it.
    child.kill().expect("a child that can be killed");
    !child.wait().expect("a child").success()
}

#[test]
fn a_recorded_run_killed_at_any_moment_goes_on_to_the_same_bytes() {
    let folder = place();
    let folder = folder.path();
    let start = ["run", "shore.toml", "--out", "out", "--quiet"];
    said(folder, &start, 0, &[]);
    let whole = results(&folder.join("out"));
    std::fs::remove_dir_all(folder.join("out")).unwrap();
    let recorded = [&start[..], RECORD].concat();
    let begun = Instant::now();
    said(folder, &recorded, 0, &[]);
    let time = begun.elapsed();
    let all = frames(folder, "out");
    assert_sound(&all, "in one piece");
    assert!(all.len() > 4 && all.len() < 60 && all.last() == Some(&1400), "it thinned out: {all:?}");
    assert!(bytes(&folder.join("out/timeline.zarr")) <= 2500 << 10);
    assert_same(&results(&folder.join("out")), &whole, "recorded");
    let (mut resumed, mut killed) = (0, 0);
    for i in 0..6 {
        std::fs::remove_dir_all(folder.join("out")).unwrap();
        // Spread over the run, at moments that have nothing to do with its steps.
        let moment = time.mul_f64((f64::from(i) + 0.37 * f64::from(i % 3)) / 7.0);
        killed += usize::from(kill_after(folder, &recorded, moment));
        let what = format!("killed after {moment:?} of {time:?}");
        if folder.join("out/timeline.zarr/zarr.json").exists() {
            let steps = frames(folder, "out");
            assert_sound(&steps, &what);
            assert!(bytes(&folder.join("out/timeline.zarr")) <= 2500 << 10, "{what}");
        }
        let again = eyot(folder, &["resume", "out", "--quiet", "--checkpoint-seconds", "0.3"]).output().unwrap();
        if again.status.success() {
            resumed += 1;
            let steps = frames(folder, "out");
            assert_sound(&steps, &what);
            assert_eq!(steps.last(), Some(&1400), "{what}");
            // Every frame is whole: a branch loads it.
            let middle = steps[steps.len() / 2].to_string();
            said(folder, &["branch", "out", "--to", &middle, "--out", "other"], 0, &["resume other"]);
            std::fs::remove_dir_all(folder.join("other")).unwrap();
        } else {
            said(folder, &recorded, 0, &[]);
        }
        assert_same(&results(&folder.join("out")), &whole, &what);
    }
    assert!(resumed >= 3 && killed >= 4, "{resumed} of 6 runs went on, {killed} were killed");
}

#[test]
fn the_way_back_in_words() {
    let folder = place();
    let f = folder.path();
    let short = ["--set", "rain.steps=30", "--set", "pipes.steps=20", "--quiet"];
    said(f, &[&["run", "shore.toml", "--out", "out", "--record", "10"][..], &short].concat(), 0, &[]);
    let saved = contents_without_recording(&f.join("out"));
    said(f, &["timeline", "out"], 0, &["6 frames, one each 10 steps", "2.0 GiB", "5 after 0"]);
    let words = ["frame 2, 20 steps done", "3 later frames", "as it was", "eyot resume out"];
    said(f, &["rewind", "out", "--to", "25"], 0, &words);
    assert_eq!(frames(f, "out"), [0, 10, 20]);
    said(f, &["run", "shore.toml", "--out", "out"], 2, &["can be continued"]);
    said(f, &["branch", "out", "--frame", "1", "--out", "wet", "--set", "hydraulic.rain=0.01"], 0, &["10 steps done"]);
    for folder in ["out", "wet"] {
        said(f, &["resume", folder, "--quiet"], 0, &[]);
    }
    assert_same(&contents_without_recording(&f.join("out")), &saved, "set back");
    assert_eq!(frames(f, "wet"), [0, 10, 20, 30, 40, 50]);
    assert_ne!(contents_without_recording(&f.join("wet"))["height.r32"], saved["height.r32"]);
    for (args, words) in [
        (&["rewind", "out"][..], "--to"),
        (&["rewind", "out", "--frame", "6"], "the recording has 6"),
        (&["rewind", "out", "--to", "1", "--frame", "1"], "cannot be used with"),
        (&["timeline", "nowhere"], "holds no recording"),
        (&["branch", "out", "--to", "1", "--out", "wet"], "not empty"),
        (&["run", "shore.toml", "--out", "x", "--record", "5", "--record-limit", "64K"], "cannot hold two frames"),
        (&["run", "shore.toml", "--out", "x", "--record", "0"], "record"),
        (&["run", "shore.toml", "--out", "x", "--record-limit", "1G"], "--record"),
        (
            &[
                "run",
                "shore.toml",
                "--out",
                "x",
                "--record",
                "5",
                "--set",
                "rain.enabled=false",
                "--set",
                "pipes.enabled=false",
            ],
            "simulates nothing",
        ),
    ] {
        said(f, args, 2, &[words]);
    }
    assert!(!f.join("x").exists());
}

fn contents_without_recording(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let aside = out.with_extension("aside");
    std::fs::rename(out.join("timeline.zarr"), &aside).unwrap();
    let saved = contents(out);
    std::fs::rename(&aside, out.join("timeline.zarr")).unwrap();
    saved
}

#[test]
fn lost_frames_are_named_by_every_verb() {
    let folder = place();
    let f = folder.path();
    let short = ["--set", "rain.steps=30", "--set", "pipes.steps=20", "--quiet"];
    said(f, &[&["run", "shore.toml", "--out", "out", "--record", "10"][..], &short].concat(), 0, &[]);
    std::fs::remove_file(f.join("out/timeline.zarr/.frames/2.eyot")).unwrap();
    std::fs::write(f.join("out/timeline.zarr/height/c/1/0/0"), "damaged").unwrap();
    let lost = "frame 2 of step 20 cannot be read";
    said(f, &["timeline", "out"], 0, &["5 frames and 1 damaged", lost, "2.eyot", "frame 2 is missing"]);
    said(f, &["branch", "out", "--frame", "2", "--out", "x"], 2, &[lost, "`eyot timeline` lists them"]);
    let film = ["film", "out", "--recording", "--size", "64x40", "--video", "none", "--out", "film"];
    said(f, &film, 0, &[lost, "frame 1 of step 10", "another frame is shown in its place", "6 pictures"]);
    let words = [lost, "frame 1 of step 10", "height", "at frame 0, 0 steps done"];
    said(f, &["branch", "out", "--to", "25", "--out", "branch"], 0, &words);
    said(f, &["rewind", "out", "--to", "25"], 0, &words);
    said(f, &["resume", "out", "--quiet"], 0, &[]);
}
