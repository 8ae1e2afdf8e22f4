//! Runs that are killed: whenever it happens, going on leads to the bytes of a run in one piece.

use crate::common;

use common::{SHORE, assert_said, assert_same, contents, eyot, said};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// The long step cut to a moment, for kills that come after it.
const SHORT: &[&str] = &["--set", "rain.steps=40", "--set", "pipes.steps=20"];

/// Checkpoints come as often as the engine looks whether one is due.
const OFTEN: &[&str] = &["--checkpoint-seconds", "0.02"];

fn finish_well(folder: &Path, args: &[&str]) {
    said(folder, args, 0, &[]);
}

/// Nothing but results: no checkpoint, no lock, no half-written file.
fn assert_tidy(out: &Path, what: &str) {
    for entry in std::fs::read_dir(out).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(
            !name.starts_with(".eyot-") && name != "checkpoint.eyot" && name != "eyot.lock",
            "{what}: {name} was left behind"
        );
    }
}

/// Goes on where a killed run left off, or runs again if it left nothing, which the command has to say.
/// True if there was something to go on from.
fn go_on(folder: &Path, start: &[&str], threads: &str) -> bool {
    let o = eyot(folder, &["resume", "out", "--threads", threads]).output().expect("the command starts");
    if o.status.success() {
        return !common::text(&o).contains("begins anew");
    }
    assert_said(&o, 2, &[]);
    let text = common::text(&o);
    if text.contains("finished") {
        assert!(folder.join("out/run.json").is_file(), "called finished without a report: {text}");
        return true;
    }
    assert!(text.contains("holds no stopped run") || text.contains("is not a folder"), "{text}");
    finish_well(folder, &[start, &["--quiet", "--threads", threads]].concat());
    false
}

/// Starts a command and kills it after a time. True if it was still at work.
fn kill_after(folder: &Path, args: &[&str], time: Duration) -> bool {
    let mut child = eyot(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command starts");
    let begun = Instant::now();
    while begun.elapsed() < time {
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1).min(time.saturating_sub(begun.elapsed())));
    }
    kill(&mut child)
}

fn kill(child: &mut Child) -> bool {
    // SIGKILL: nothing in the program can answer it.
    child.kill().expect("a child that can be killed");
    !child.wait().expect("a child").success()
}

/// Starts a command and kills it when it says for the `n`-th time that it writes a file. True if it was still at work.
fn kill_while_writing(folder: &Path, args: &[&str], n: usize) -> bool {
    let mut child = eyot(folder, &[args, &["--json"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command starts");
    let lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let mut seen = 0;
    for line in lines {
        seen += usize::from(line.expect("a line").starts_with("{\"event\":\"writing\""));
        if seen == n {
            return kill(&mut child);
        }
    }
    child.wait().expect("a child");
    false
}

/// Numbers in 0..1 from a seed, the same on every machine.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shore.toml"), SHORE).unwrap();
    folder
}

/// What a run in one piece leaves, and the time it took. The folder is then as before: a saved world says where its recipe
/// lies, so runs are compared that were started in one place.
fn in_one_piece(folder: &Path, start: &[&str]) -> (BTreeMap<String, Vec<u8>>, Duration) {
    let begun = Instant::now();
    finish_well(folder, &[start, &["--quiet", "--threads", "2"]].concat());
    let time = begun.elapsed();
    let whole = contents(&folder.join("out"));
    clear(folder);
    (whole, time)
}

fn clear(folder: &Path) {
    let out = folder.join("out");
    if out.exists() {
        std::fs::remove_dir_all(out).expect("a folder of ours");
    }
}

fn assert_whole(folder: &Path, whole: &BTreeMap<String, Vec<u8>>, what: &str) {
    let out = folder.join("out");
    assert_same(&contents(&out), whole, what);
    assert_tidy(&out, what);
}

#[test]
fn a_run_killed_at_any_moment_goes_on_to_the_same_bytes() {
    let start = [&["run", "shore.toml", "--out", "out"], OFTEN].concat();
    let (folder, first) = (place(), [&start[..], &["--quiet", "--threads", "2"]].concat());
    let folder = folder.path();
    let (whole, time) = in_one_piece(folder, &start);
    assert_eq!(whole.len(), 3 + 3 + 2 + 2, "three layers and what describes them, two pictures, world and report");
    let mut dice = Dice(20);
    let mut resumed = 0;
    for i in 0..20 {
        let mut moment = time.mul_f64((f64::from(i) + dice.roll()) / 20.0);
        // Machines get faster when another test ends; an earlier moment will do as well.
        while !kill_after(folder, &first, moment) {
            clear(folder);
            moment = moment.mul_f64(0.7);
        }
        resumed += usize::from(go_on(folder, &start, ["1", "2", "3"][i as usize % 3]));
        assert_whole(folder, &whole, &format!("killed after {moment:?} of {time:?}"));
        clear(folder);
    }
    assert!(resumed >= 8, "only {resumed} of 20 runs left a checkpoint");
}

/// The first checkpoint of such a run would come after a minute.
#[test]
fn a_run_killed_before_its_first_checkpoint_begins_anew() {
    let start =
        ["run", "shore.toml", "--out", "out", "--seed", "9", "--set", "rain.steps=400", "--set", "pipes.steps=20"];
    let folder = place();
    let folder = folder.path();
    let (whole, _) = in_one_piece(folder, &start);
    for n in 1..=3 {
        let mut child = common::start_until(folder, &start, "step_begun", n);
        assert!(kill(&mut child), "the run was over before step {n}");
        said(folder, &start, 2, &["holds a run that was stopped and can be continued", "eyot resume out"]);
        said(folder, &["resume", "out"], 0, &["begins anew"]);
        assert_whole(folder, &whole, &format!("killed in step {n}"));
        clear(folder);
    }
}

#[test]
fn a_run_killed_while_it_writes_its_results_goes_on_to_the_same_bytes() {
    let start = [&["run", "shore.toml", "--out", "out"], SHORT].concat();
    let folder = place();
    let folder = folder.path();
    let (whole, _) = in_one_piece(folder, &start);
    // World, three layers, two pictures, the report: with a checkpoint to return to, and without.
    for often in [OFTEN, &[]] {
        let mut killed = 0;
        for n in 1..=7 {
            killed += usize::from(kill_while_writing(folder, &[&start, often].concat(), n));
            go_on(folder, &start, "2");
            assert_whole(folder, &whole, &format!("killed at file {n}"));
            clear(folder);
        }
        assert!(killed >= 4, "only {killed} of 7 runs were killed");
    }
}

#[test]
fn a_run_killed_over_an_older_result_does_not_pass_for_finished() {
    let start = [&["run", "shore.toml", "--out", "out"], SHORT].concat();
    let other = [&start[..], &["--seed", "6"]].concat();
    let folder = place();
    let folder = folder.path();
    let (whole, _) = in_one_piece(folder, &other);
    for n in [1, 3, 6] {
        finish_well(folder, &[&start[..], &["--quiet"]].concat());
        if kill_while_writing(folder, &other, n) {
            let old = std::fs::read_to_string(folder.join("out/run.json")).is_ok_and(|t| t.contains("\"seed\": 5"));
            assert!(!old || n == 1, "the older report stands beside files of the other run");
            if old && !folder.join("out/checkpoint.eyot").exists() {
                // Killed before anything of it was whole: the older result is still there, all of it.
                finish_well(folder, &[&other[..], &["--quiet"]].concat());
            } else {
                go_on(folder, &other, "2");
            }
        }
        assert_whole(folder, &whole, &format!("killed at file {n}"));
        clear(folder);
    }
}

#[test]
fn a_run_killed_again_and_again_goes_on_to_the_same_bytes() {
    let start = [&["run", "shore.toml", "--out", "out"], OFTEN].concat();
    let folder = place();
    let folder = folder.path();
    let (whole, time) = in_one_piece(folder, &start);
    let part = time.mul_f64(0.4);
    kill_after(folder, &[&start[..], &["--threads", "2"]].concat(), part);
    for threads in ["1", "3"] {
        let again = [&["resume", "out", "--threads", threads], OFTEN].concat();
        kill_after(folder, &again, part);
    }
    go_on(folder, &start, "2");
    assert_whole(folder, &whole, "killed three times");
}

#[test]
fn half_written_files_and_locks_of_the_dead_are_in_nobodys_way() {
    let start = [&["run", "shore.toml", "--out", "out"], SHORT].concat();
    let folder = place();
    let folder = folder.path();
    let (whole, _) = in_one_piece(folder, &start);
    let out = folder.join("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join(".eyot-abcdef.tmp"), b"EYOTCKPT half a check").unwrap();
    std::fs::write(out.join("eyot.lock"), "4194304\n").unwrap();
    said(folder, &["resume", "out"], 2, &[]);
    finish_well(folder, &[&start[..], &["--quiet"]].concat());
    assert_whole(folder, &whole, "files of a dead run");
}
