//! `sweep` and the plots of `stats`.

use crate::common;

use common::{contents, eyot, said};
use std::path::Path;

const HILL: &str = r#"
name = "Hill"
seed = 5
[grid]
size = [64, 48]
cell = 20.0
rim = "open"
[[step]]
name = "hill"
generate = "cone"
height = 300.0
[[step]]
name = "rough"
generate = "fbm"
amplitude = 60.0
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("hill.toml"), HILL).expect("a recipe");
    folder
}

fn rows(at: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(at).expect("a table");
    text.lines().map(|l| l.split(',').map(str::to_owned).collect()).collect()
}

/// The bytes of all files of a sweep.
fn all(out: &Path) -> Vec<Vec<u8>> {
    let named = ["sweep.csv", "sweep.json", "sheet.png"].map(|f| std::fs::read(out.join(f)).expect("a file"));
    named.into_iter().chain(contents(&out.join("runs")).into_values()).collect()
}

#[test]
fn a_grid_of_parameters_gives_a_table_and_a_sheet() {
    let f = folder();
    let args = ["sweep", "hill.toml", "--set", "hill.height=100..300:3", "--set", "rough.amplitude=10,40", "--quiet"];
    said(f.path(), &args, 0, &["wrote hill-sweep/sweep.csv", "sheet.png"]);
    let out = f.path().join("hill-sweep");
    let table = rows(&out.join("sweep.csv"));
    assert_eq!(
        (table.len(), &table[0][1..5]),
        (7, &["hill.height", "rough.amplitude", "fingerprint", "error"].map(String::from)[..])
    );
    assert!(table.iter().all(|r| r.len() == table[0].len()));
    let column = table[0].iter().position(|c| c == "max_m").expect("heights");
    let max = |run: usize| table[run][column].parse::<f64>().expect("a number");
    assert!(max(5) > max(3) && max(3) > max(1), "{table:?}");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("sweep.json")).expect("a file")).expect("JSON");
    assert_eq!(json["results"][5]["set"]["hill.height"], 300);
    assert_eq!(json["results"].as_array().map(Vec::len), Some(6));

    // Each run is the one that the same values make alone.
    said(
        f.path(),
        &["run", "hill.toml", "--out", "one", "--set", "hill.height=200", "--set", "rough.amplitude=40", "--quiet"],
        0,
        &[],
    );
    let run: serde_json::Value =
        serde_json::from_slice(&std::fs::read(f.path().join("one/run.json")).expect("a file")).expect("JSON");
    assert_eq!(run["fingerprint"], json["results"][3]["fingerprint"]);

    // Again, nothing is made anew; with one thread, the same bytes.
    let before = all(&out);
    said(f.path(), &args, 0, &[]);
    assert_eq!(before, all(&out));
    let other = [&args[..], &["--threads", "1", "--out", "other"]].concat();
    said(f.path(), &other, 0, &[]);
    assert_eq!(before, all(&f.path().join("other")));
}

#[test]
fn a_run_that_fails_loses_no_other_and_is_tried_again() {
    let f = folder();
    let args = ["sweep", "hill.toml", "--set", "grid.rim=open,nonsense,closed", "--out", "rims", "--quiet"];
    said(f.path(), &args, 1, &["1 of 3 runs failed"]);
    let table = rows(&f.path().join("rims/sweep.csv"));
    assert_eq!(table.len(), 4);
    assert!(table[1][3].is_empty() && !table[2][3].is_empty() && table[3][3].is_empty(), "{table:?}");
    // What is wrong with all of them is told as of a single run, and nothing is begun.
    said(f.path(), &["sweep", "hill.toml", "--set", "hill.hight=1..3:3", "--out", "none"], 2, &["hight"]);
    assert!(!f.path().join("none").exists());
    said(f.path(), &["sweep", "hill.toml", "--set", "seed=1..3"], 2, &[":COUNT"]);
    said(f.path(), &["sweep", "hill.toml", "--set", "seed=1,2", "--set", "seed=3,4"], 2, &["given twice"]);
    // Files of others stay.
    std::fs::create_dir(f.path().join("mine")).expect("a folder");
    std::fs::write(f.path().join("mine/sheet.png"), "mine").expect("a file");
    said(f.path(), &["sweep", "hill.toml", "--set", "seed=1,2", "--out", "mine"], 2, &["sheet.png"]);
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_keeps_what_is_done_and_goes_on() {
    let f = folder();
    let long = "[[step]]\nsimulate = [\"hydraulic\"]\nsteps = 4000\n";
    std::fs::write(f.path().join("long.toml"), format!("{HILL}{long}")).expect("a recipe");
    let args = ["sweep", "long.toml", "--set", "seed=1..6:6", "--threads", "1", "--out", "out"];
    let mut child = eyot(f.path(), &args).stderr(std::process::Stdio::null()).spawn().expect("the command starts");
    let runs = f.path().join("out/runs");
    let done = || {
        std::fs::read_dir(&runs)
            .map_or(0, |d| d.flatten().filter(|e| e.path().extension().is_some_and(|x| x == "json")).count())
    };
    while done() == 0 && child.try_wait().expect("a state").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill").success());
    let code = child.wait().expect("an end").code();
    let kept = done();
    // Unless the machine was so fast that all was done, something is left to do, and the table has what is done.
    if code == Some(130) {
        assert!((1..6).contains(&kept));
        assert!(rows(&f.path().join("out/sweep.csv")).len() > 1);
    }
    said(f.path(), &args, 0, &["wrote out/sheet.png"]);
    assert_eq!((done(), rows(&f.path().join("out/sweep.csv")).len()), (6, 7));
}

#[test]
fn stats_draw_their_curves() {
    let f = folder();
    said(f.path(), &["run", "hill.toml", "--quiet", "--set", "grid.size=[128, 128]"], 0, &[]);
    said(
        f.path(),
        &["stats", "hill", "--plots", "plots", "--channel-area", "20000"],
        0,
        &["wrote plots/rivers.png", "concavity"],
    );
    for name in ["hypsometry", "slope_area", "rivers"] {
        let svg = std::fs::read_to_string(f.path().join(format!("plots/{name}.svg"))).expect("a drawing");
        assert!(svg.contains("hill: ") && svg.matches("<polyline").count() > 8, "{name}");
        assert!(std::fs::read(f.path().join(format!("plots/{name}.png"))).expect("a picture").starts_with(b"\x89PNG"));
    }
}
