//! Bad luck: interrupts while files are written, full disks and devices, folders in use, checkpoints that are damaged. It
//! always ends with a message, and what was there before is still there.

use crate::common;

use common::{assert_said, assert_same, contents, eyot, said};
use std::path::Path;
use std::process::{Command, Stdio};

/// Little to simulate, much to write.
const RECIPE: &str = r#"
name = "Unlucky"
seed = 3
sea_level = 20.0

[grid]
size = 200
cell = 10.0

[[step]]
name = "hill"
generate = "cone"
height = 150.0
radius = 0.6

[[step]]
name = "rain"
simulate = ["hydraulic", "thermal"]
steps = 60

[[export]]
format = "r32"
layers = ["height", "water"]

[[export]]
format = "glb"

[view]
size = [1400, 900]
"#;

fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), RECIPE).unwrap();
    folder
}

#[test]
fn two_runs_leave_the_same_folder_whatever_their_threads_and_timing() {
    let folder = place();
    let f = folder.path();
    said(f, &["run", "a.toml", "--out", "one", "--threads", "1"], 0, &[]);
    said(f, &["run", "a.toml", "--out", "three", "--threads", "3", "--checkpoint-seconds", "0.01"], 0, &[]);
    let (one, three) = (contents(&f.join("one")), contents(&f.join("three")));
    assert!(one.len() > 7, "{:?}", one.keys());
    assert_same(&one, &three, "1 and 3 threads");
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_results_are_written_stops_and_resume_finishes_them() {
    let folder = place();
    let f = folder.path();
    said(f, &["run", "a.toml", "--out", "out", "--quiet"], 0, &[]);
    let whole = contents(&f.join("out"));
    // World, two rasters, the mesh, the view: while each of them is under way.
    for n in 1..=5 {
        std::fs::remove_dir_all(f.join("out")).unwrap();
        let child = common::start_until(f, &["run", "a.toml", "--out", "out"], "writing", n);
        common::signal(&child, if n % 2 == 0 { "-TERM" } else { "-INT" });
        assert_said(&child.wait_with_output().unwrap(), 130, &["eyot resume out"]);
        for (name, bytes) in contents(&f.join("out")) {
            // The lock and the temporary files are gone; what is there is what it will be.
            assert!(name == "checkpoint.eyot" || bytes == whole[&name], "stopped at file {n}: {name}");
        }
        assert!(!f.join("out/run.json").exists(), "stopped at file {n}: it passes for finished");
        said(f, &["run", "a.toml", "--out", "out"], 2, &["can be continued"]);
        said(f, &["resume", "out", "--threads", "1"], 0, &[]);
        assert_same(&contents(&f.join("out")), &whole, &format!("stopped at file {n}"));
    }
}

#[cfg(unix)]
#[test]
fn a_folder_belongs_to_the_run_at_work() {
    let folder = place();
    let f = folder.path();
    let start: &[&str] = &["run", "a.toml", "--out", "out", "--set", "rain.steps=300"];
    said(f, start, 0, &[]);
    let whole = contents(&f.join("out"));
    std::fs::remove_dir_all(f.join("out")).unwrap();
    let child = common::start_until(f, start, "step_begun", 1);
    common::signal(&child, "-STOP");
    for args in [start, &["resume", "out"], &[start, &["--restart"]].concat()] {
        said(f, args, 2, &["another run (process", "choose another folder"]);
    }
    common::signal(&child, "-CONT");
    assert_said(&child.wait_with_output().unwrap(), 0, &[]);
    assert_same(&contents(&f.join("out")), &whole, "with three others at the door");
}

/// Every write to `/dev/full` fails as on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_no_success() {
    let folder = place();
    let f = folder.path();
    let full = || Stdio::from(std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    for args in [
        &["run", "a.toml", "--out", "out", "--json"][..],
        &["list"],
        &["schema"],
        &["check", "a.toml"],
        &["--help"],
        &["--version"],
        &["stats", "out", "--json"],
    ] {
        let o = eyot(f, args).stdout(full()).output().unwrap();
        assert_said(&o, 1, &["cannot write to the standard output"]);
    }
    assert!(f.join("out/run.json").exists(), "the files are wanted all the same");
}

/// Runs the command where the system refuses files over 64 or 128 KiB (shells count in different blocks), by a signal that
/// would end it without a word.
#[cfg(unix)]
fn with_small_files(folder: &Path, args: &[&str]) -> std::process::Output {
    let mut c = Command::new("sh");
    c.args(["-c", r#"ulimit -f 128; exec "$@""#, "sh", env!("CARGO_BIN_EXE_eyot")]);
    c.args(args).current_dir(folder).output().unwrap()
}

#[cfg(unix)]
#[test]
fn a_disk_that_refuses_leaves_earlier_results_alone() {
    let folder = place();
    let f = folder.path();
    said(f, &["run", "a.toml", "--out", "out"], 0, &[]);
    let before = contents(&f.join("out"));
    assert!(before["world.eyot"].len() > 1 << 17);
    let o = with_small_files(f, &["run", "a.toml", "--out", "out", "--seed", "9"]);
    assert_said(&o, 1, &["checkpoint.eyot", "cannot write"]);
    assert_same(&contents(&f.join("out")), &before, "after a refused write");
    // A checkpoint on the way is a warning, and one is enough; the run goes on to its end.
    let o = with_small_files(f, &["run", "a.toml", "--out", "out", "--seed", "9", "--checkpoint-seconds", "0"]);
    assert_said(&o, 1, &["warning: no checkpoint", "the run goes on", "2. rain:", "cannot write"]);
    assert_eq!(common::text(&o).matches("no checkpoint").count(), 1);
    assert_same(&contents(&f.join("out")), &before, "after a refused checkpoint");
    let o = with_small_files(f, &["render", "out", "--out", "big.png"]);
    assert_said(&o, 1, &["big.png"]);
    assert!(!f.join("big.png").exists());
}

/// Runs the command with a small or read-only file system in `disk`; nothing where this user may mount none.
#[cfg(target_os = "linux")]
fn on_a_disk(folder: &Path, options: &str, script: &str) -> Option<std::process::Output> {
    std::fs::create_dir_all(folder.join("disk")).unwrap();
    let mount = format!("mount -t tmpfs -o {options} tmpfs disk");
    let in_namespace = |script: &str| {
        let mut c = Command::new("unshare");
        c.args(["--user", "--map-root-user", "--mount", "sh", "-c", script, "sh", env!("CARGO_BIN_EXE_eyot")]);
        c.current_dir(folder).output()
    };
    if !in_namespace(&mount).is_ok_and(|o| o.status.success()) {
        eprintln!("skipped: this user may not mount a file system");
        return None;
    }
    Some(in_namespace(&format!("{mount} && {script}")).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_called_one_and_the_run_goes_on_when_there_is_room() {
    let folder = place();
    // World, rasters and mesh of 200 x 200 cells take 4.6 MB: the world fits, not everything.
    let script = r#""$1" run a.toml --out disk/out 2> first; echo "rc $?"; ls -A disk/out; mount -o remount,size=64m disk
        "$1" resume disk/out --quiet; echo "rc $?"; ls -A disk/out"#;
    let Some(o) = on_a_disk(folder.path(), "size=1500k", script) else { return };
    let told = String::from_utf8_lossy(&o.stdout).into_owned();
    let first = std::fs::read_to_string(folder.path().join("first")).unwrap();
    assert!(first.contains("make room") && !first.contains("panicked"), "{first}");
    let (before, after) =
        told.split_once("rc 1\n").expect("the first run fails").1.split_once("rc 0\n").expect("then not");
    assert!(before.contains("world.eyot") && !before.contains("run.json") && !before.contains(".tmp"), "{told}");
    assert!(after.contains("run.json") && after.contains("terrain.glb"), "{told}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_left_as_it_was() {
    let folder = place();
    let script = r#"dd if=/dev/zero of=disk/fill bs=4096 2> /dev/null
        "$1" new disk/n; echo "rc $?"
        "$1" run a.toml --out disk; echo "rc $?"
        "$1" convert builtin:jacksboro.tif disk/gis --preset gis; echo "rc $?"
        "$1" convert builtin:jacksboro.tif disk/a.zarr; echo "rc $?"
        ls -A disk"#;
    let Some(o) = on_a_disk(folder.path(), "size=256k", script) else { return };
    assert_eq!(String::from_utf8_lossy(&o.stdout), "rc 1\nrc 1\nrc 1\nrc 1\nfill\n", "{}", common::text(&o));
    let told = common::text(&o);
    assert!(told.contains("disk/a.zarr/") && !told.contains(".eyot-"), "{told}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_read_only_folder_is_called_one() {
    let folder = place();
    let Some(o) = on_a_disk(folder.path(), "ro", r#""$1" run a.toml --out disk/out"#) else { return };
    assert_said(&o, 1, &["disk/out", "--out"]);
    let Some(o) = on_a_disk(folder.path(), "ro", r#""$1" run a.toml --out disk"#) else { return };
    assert_said(&o, 1, &["disk", "--out"]);
}

#[test]
fn damaged_and_foreign_checkpoints_are_refused_and_nothing_is_lost() {
    let folder = place();
    let f = folder.path();
    said(f, &["run", "a.toml", "--out", "out"], 0, &[]);
    // A finished world without a report is where writing goes on.
    std::fs::remove_file(f.join("out/run.json")).unwrap();
    let (path, original) = (f.join("out/world.eyot"), std::fs::read(f.join("out/world.eyot")).unwrap());
    let changed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = original.clone();
        change(&mut bytes);
        bytes
    };
    let middle = original.len() / 2;
    let cases = [
        (changed(&|b| b[middle] ^= 4), "truncated or damaged"),
        (changed(&|b| b[100] ^= 1), "truncated or damaged"),
        (changed(&|b| b.truncate(middle)), "truncated or damaged"),
        (changed(&|b| b.extend([0; 8])), "truncated or damaged"),
        (changed(&|b| b.clear()), "too few"),
        (changed(&|b| b[8] = 77), "format version 77"),
        (changed(&|b| b[0] = b'X'), "no Eyot checkpoint"),
    ];
    for (bytes, answer) in cases {
        std::fs::write(&path, &bytes).unwrap();
        let before = contents(&f.join("out"));
        said(f, &["resume", "out"], 2, &["world.eyot", answer, "--out out --restart"]);
        said(f, &["stats", "out"], 2, &["world.eyot", answer]);
        assert_same(&contents(&f.join("out")), &before, answer);
    }
    // A sound file whose recipe is about another grid, and one without the state of a run.
    std::fs::write(&path, &original).unwrap();
    let saved = eyot::formats::checkpoint::load(&path, &eyot::Limits::default(), &eyot::component_kinds()).unwrap();
    let other = RECIPE.replace("size = 200", "size = 100");
    for (recipe, state, answer) in [
        (other.as_str(), saved.state.clone(), "does not fit its recipe"),
        ("seed = ", saved.state.clone(), "not valid TOML"),
        (RECIPE, serde_json::json!({ "done": "much" }), "no state of a run"),
    ] {
        eyot::formats::checkpoint::save(&path, &saved.world, recipe, &state).unwrap();
        said(f, &["resume", "out"], 2, &[answer]);
    }
    std::fs::write(&path, &original).unwrap();
    said(f, &["resume", "out"], 0, &[]);
}

/// Files of an earlier run that the new one does not write belong to the user, who has to know of them.
#[test]
fn what_an_earlier_run_left_is_named_and_stays() {
    let folder = place();
    let f = folder.path();
    let args = ["run", "a.toml", "--out", "out", "--set", "rain.steps=1", "--set", "view.enabled=false"];
    said(f, &args, 0, &[]);
    let mesh = std::fs::read(f.join("out/terrain.glb")).unwrap();
    let other = [&args[..], &["--set", "export.2.enabled=false", "--seed", "4"]].concat();
    said(f, &other, 0, &["still holds the file `terrain.glb` of an earlier run"]);
    assert_eq!(std::fs::read(f.join("out/terrain.glb")).unwrap(), mesh);
    // Nothing to say of files that are gone, or that are written again.
    std::fs::remove_file(f.join("out/terrain.glb")).unwrap();
    assert!(!said(f, &args, 0, &[]).contains("earlier run"));
    assert!(!said(f, &args, 0, &[]).contains("earlier run"));
    // A report may say anything; only names in this folder count.
    std::fs::write(f.join("kept"), "").unwrap();
    std::fs::write(f.join("out/run.json"), r#"{ "outputs": ["../kept", "/etc/passwd", 3] }"#).unwrap();
    let forced = [&args[..], &["--force"]].concat();
    assert!(!said(f, &forced, 0, &[]).contains("earlier run"));
    // Quiet is quiet.
    assert_eq!(said(f, &[&other[..], &["--quiet"]].concat(), 0, &[]), "");
}

/// Hours of work must not be lost, nor end in a run that can never be finished, because a peak exceeds the scale of a file.
#[test]
fn an_export_that_values_do_not_fit_costs_only_itself() {
    let folder = place();
    let f = folder.path();
    let narrow = format!("{RECIPE}[[export]]\nformat = \"r16\"\nrange = [0.0, 1.0]\n[[export]]\nformat = \"npy\"\n");
    std::fs::write(f.join("b.toml"), narrow).unwrap();
    let answers = ["height.r16", "beyond the scale", "all other files are there", "eyot convert"];
    said(f, &["run", "b.toml", "--out", "out", "--set", "rain.steps=1"], 1, &answers);
    for file in ["world.eyot", "height.r32", "height.npy", "terrain.glb", "preview.png", "run.json"] {
        assert!(f.join("out").join(file).is_file(), "{file}");
    }
    assert!(!f.join("out/height.r16").exists());
    assert!(!std::fs::read_to_string(f.join("out/run.json")).unwrap().contains("height.r16"));
    said(f, &["resume", "out"], 2, &["is finished"]);
    said(f, &["convert", "out", "out/height.r16"], 0, &[]);
}

/// What lies in the folder and is of no run was put there by somebody.
#[test]
fn files_of_others_in_the_folder_are_not_overwritten() {
    let folder = place();
    let f = folder.path();
    std::fs::create_dir(f.join("out")).unwrap();
    std::fs::write(f.join("out/height.r32"), "mine").unwrap();
    let args = ["run", "a.toml", "--out", "out", "--set", "rain.steps=1", "--set", "view.enabled=false"];
    said(f, &args, 2, &["would overwrite `height.r32` in `out`, which is not of a former run", "--force", "--out"]);
    assert_eq!(std::fs::read(f.join("out/height.r32")).unwrap(), b"mine");
    assert_eq!(std::fs::read_dir(f.join("out")).unwrap().count(), 1, "something was begun");
    // A report of another program, and a link, are no more ours.
    std::fs::rename(f.join("out/height.r32"), f.join("out/run.json")).unwrap();
    said(f, &args, 2, &["`run.json`"]);
    std::fs::remove_file(f.join("out/run.json")).unwrap();
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(f.join("nowhere"), f.join("out/terrain.glb")).unwrap();
        said(f, &args, 2, &["`terrain.glb`"]);
        std::fs::remove_file(f.join("out/terrain.glb")).unwrap();
    }
    std::fs::write(f.join("out/height.r32"), "mine").unwrap();
    said(f, &[&args[..], &["--force"]].concat(), 0, &[]);
    // From here on everything is its own, also what one of two recipes leaves alone.
    said(f, &[&args[..], &["--set", "export.2.enabled=false"]].concat(), 0, &["terrain.glb"]);
    said(f, &[&args[..], &["--set", "export.2.enabled=false"]].concat(), 0, &["terrain.glb"]);
    said(f, &args, 0, &[]);
}
