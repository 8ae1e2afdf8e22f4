//! What the tests of the command share.

// Each of them uses only a part of it.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// Every process, both forms of water, layers that come late, an open rim (whose fluxes leave through the last faces),
/// cells that are not square, and processes that act in every third or fifth step only.
pub(crate) const SHORE: &str = r#"
name = "Shore"
seed = 5
sea_level = 40.0
[grid]
size = [150, 110]
cell = [10.0, 12.0]
rim = "open"
[[step]]
name = "hill"
generate = "cone"
height = 150.0
radius = 0.6
[[step]]
name = "rough"
generate = "fbm"
amplitude = 60.0
[[step]]
name = "rain"
simulate = ["hydraulic", "thermal", "seabed", "wetness", "reef"]
steps = 1600
thermal.every = 3
wetness.every = 5
reef.sea_level_rise = 0.004
[[step]]
name = "ash"
generate = "fbm"
amplitude = 5.0
[[step]]
name = "pipes"
simulate = ["hydraulic", "thermal", "reef"]
steps = 900
hydraulic.flux = "classic"
thermal.every = 5
[[export]]
format = "r32"
layers = ["height", "water", "limestone"]
[view]
size = [64, 48]
"#;

/// The command, to be started in a folder.
pub(crate) fn eyot(folder: &Path, args: &[&str]) -> Command {
    let mut c = Command::new(env!("CARGO_BIN_EXE_eyot"));
    c.args(args).current_dir(folder).stdin(Stdio::null());
    c
}

/// Runs the command in a folder to its end; checks its exit code and that its words hold all of `answers`, and returns them.
pub(crate) fn said(folder: &Path, args: &[&str], code: i32, answers: &[&str]) -> String {
    let o = eyot(folder, args).output().expect("the command starts");
    assert_said(&o, code, answers);
    text(&o)
}

/// Everything that a command said, in one line.
pub(crate) fn text(o: &Output) -> String {
    // The report wraps long lines and begins each with a bar.
    let all = format!("{}{}", String::from_utf8_lossy(&o.stdout), String::from_utf8_lossy(&o.stderr));
    all.split_whitespace().filter(|w| *w != "|").collect::<Vec<_>>().join(" ")
}

/// Checks how a command ended, that it did not break, and that its words hold all of `answers`.
pub(crate) fn assert_said(o: &Output, code: i32, answers: &[&str]) {
    let said = text(o);
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(o.status.code(), Some(code), "{said}");
    for answer in answers {
        assert!(said.contains(answer), "`{answer}` is missing: {said}");
    }
}

/// Every file of a folder; the report without what it says of time.
pub(crate) fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("a file").path());
    files
        .map(|path| {
            let mut bytes = std::fs::read(&path).expect("a file");
            if path.ends_with("run.json") {
                let mut report: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
                let timing = report.as_object_mut().expect("a table").remove("timing");
                assert!(timing.expect("times")["seconds"].is_number());
                bytes = report.to_string().into_bytes();
            }
            (path.file_name().expect("a name").to_string_lossy().into_owned(), bytes)
        })
        .collect()
}

/// Asserts that two folders hold the same files with the same bytes.
pub(crate) fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    assert!(a.keys().eq(b.keys()), "{what}: {:?} and {:?}", a.keys(), b.keys());
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{what}: {name} differs");
    }
}

/// Starts a command with `--json` and gives it back when it has told `n` events of a kind.
pub(crate) fn start_until(folder: &Path, args: &[&str], event: &str, n: usize) -> Child {
    let mut child = eyot(folder, &[args, &["--json"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut out = BufReader::new(child.stdout.take().expect("a pipe"));
    let (start, mut seen, mut line) = (format!("{{\"event\":\"{event}\""), 0, String::new());
    while seen < n {
        line.clear();
        assert!(out.read_line(&mut line).expect("a line") > 0, "the run ended before event {n} `{event}`");
        seen += usize::from(line.starts_with(&start));
    }
    // Somebody must go on reading, or the run would wait for room in the pipe.
    std::thread::spawn(move || std::io::copy(&mut out, &mut std::io::sink()));
    child
}

/// Waits for a child, and returns how it ended and the most memory that it held, KiB.
#[cfg(target_os = "linux")]
pub(crate) fn wait_with_peak(mut child: Child) -> (std::process::ExitStatus, u64) {
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    loop {
        // The system keeps the highest value, so that looking now and then misses nothing but the last moment.
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        most = most.max(line.unwrap_or(0));
        if let Some(ended) = child.try_wait().expect("a child") {
            assert!(most > 0, "the system does not tell");
            return (ended, most);
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

/// Sends a signal to a child.
#[cfg(unix)]
pub(crate) fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
}
