//! `sweep`: a recipe with each value of some parameters, a table and a sheet of pictures.
//!
//! Each run has a name that follows from all that decides its bytes and its statistics. What it came to lies under that name in `runs/`, so
//! that a second call, with more values or after a stop, finds what is done.

use crate::args::Sweep;
use crate::runs::{Interrupts, folder_name};
use crate::wording::CommandLine;
use crate::{Failure, print, recipe_cmd, report};
use eyot::analyse::TerrainOptions;
use eyot::formats::write_rgb_png;
use eyot::remedy::Worded;
use eyot::store::{self, Picture, SheetCell, Subject};
use eyot::{Command, Limits, Overrides, Recipe, RecipeSource, Registry, RunError, RunOptions, Stream};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// Most runs of a sweep.
const MOST: usize = 10_000;
/// Values of one parameter, at most.
const MOST_VALUES: usize = 1000;
/// A run looks this often whether all is to stop.
const LOOK: Duration = Duration::from_millis(100);
/// What a sweep writes beside `runs/`.
const FILES: [&str; 3] = ["sweep.csv", "sweep.json", "sheet.png"];

/// A parameter and its values as texts of TOML.
struct Axis {
    key: String,
    values: Vec<String>,
}

/// One run of the sweep.
struct Cell {
    /// `key=value` of each axis.
    set: Vec<String>,
    values: Vec<String>,
}

/// What came of a run.
enum Done {
    Made { about: Value, picture: Picture },
    Failed(String),
}

pub(crate) fn sweep(args: &Sweep) -> Result<(), Failure> {
    let axes: Vec<Axis> = args.set.iter().map(|s| axis(s)).collect::<Result<_, _>>()?;
    let mut keys = BTreeSet::new();
    if let Some(twice) = axes.iter().find(|a| !keys.insert(a.key.as_str())) {
        return Err(report::usage(
            &format!("`{}` is given twice", twice.key),
            "give all its values at once: KEY=A,B,C",
        ));
    }
    let cells = cells(&axes)?;
    let source = RecipeSource::find(&args.recipe).map_err(|p| report::recipe(&p))?;
    // What is wrong with the recipe itself is told before anything is begun.
    let parse = |cell: &Cell, limits: &Limits| {
        let overrides = Overrides { set: cell.set.clone(), size: args.size, presets: Vec::new() };
        Recipe::parse(source.clone(), overrides, &Registry::standard(), limits)
    };
    let limits = recipe_cmd::limits(args.max_memory);
    let sound: Vec<bool> = cells.iter().map(|c| parse(c, &limits).is_ok()).collect();
    if !sound.contains(&true) {
        return Err(parse(&cells[0], &limits).err().map_or(Failure::Closed, |p| report::recipe(&p)));
    }
    let threads = args.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    // As many at a time as there are threads, or as memory holds of those that it holds one of.
    let share = |n: usize| Limits { max_bytes: limits.max_bytes / n as u64, ..limits };
    let fit = |n: usize| cells.iter().zip(&sound).filter(|(_, s)| **s).all(|(c, _)| parse(c, &share(n)).is_ok());
    let at_once = (1..=threads.min(cells.len())).rev().find(|&n| n == 1 || fit(n)).unwrap_or(1);

    let out = args.out.clone().unwrap_or_else(|| {
        let mut name = folder_name(&args.recipe).into_os_string();
        name.push("-sweep");
        name.into()
    });
    let runs = out.join("runs");
    if let Some(there) = FILES.iter().map(|f| out.join(f)).find(|f| f.exists()).filter(|_| !runs.is_dir()) {
        let message = format!("`{}` is there already and of no sweep", there.display());
        return Err(report::usage(&message, "choose another folder with --out"));
    }
    std::fs::create_dir_all(&runs).map_err(|e| unwritable(&runs, &e))?;

    let interrupts =
        Interrupts::saying("stopping; what is done stays, and the same command goes on; Ctrl-C again ends at once");
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::SeqCst);
            let Some(cell) = cells.get(i).filter(|_| !interrupts.came()) else { return };
            let one = One {
                args,
                runs: &runs,
                limits: share(at_once),
                threads: (threads / at_once).max(1),
                interrupts: &interrupts,
            };
            let Some(result) = one.carry_out(parse(cell, &share(at_once))) else { return };
            if !args.quiet {
                let what = match &result {
                    Done::Made { .. } => "done".to_owned(),
                    Done::Failed(why) => format!("failed: {why}"),
                };
                print::note(&format!("{} of {}: {}: {what}", i + 1, cells.len(), cell.set.join(" ")));
            }
            if let Ok(mut done) = done.lock() {
                done.push((i, result));
            }
        }
    };
    std::thread::scope(|s| {
        for _ in 0..at_once {
            s.spawn(work);
        }
    });
    let mut done = done.into_inner().unwrap_or_default();
    done.sort_by_key(|(i, _)| *i);
    write_results(args, &out, &axes, &cells, &done, &source.name)?;
    let failed = done.iter().filter(|(_, d)| matches!(d, Done::Failed(_))).count();
    if done.len() < cells.len() {
        print::note(&format!("stopped after {} of {} runs; the same command goes on", done.len(), cells.len()));
        return Err(Failure::Stopped);
    }
    for file in FILES {
        print::line(&format!("wrote {}", out.join(file).display()))?;
    }
    if failed > 0 {
        let message = format!("{failed} of {} runs failed; the table says why", cells.len());
        return Err(Failure::Failed(report::plain(&message, Some("the same command tries these again".to_owned()))));
    }
    Ok(())
}

/// What a thread needs to carry out a run.
struct One<'a> {
    args: &'a Sweep,
    runs: &'a Path,
    limits: Limits,
    threads: usize,
    interrupts: &'a Interrupts,
}

impl One<'_> {
    /// `None` if it was stopped.
    fn carry_out(&self, recipe: Result<Recipe, eyot::Problems>) -> Option<Done> {
        let recipe = match recipe {
            Ok(recipe) => recipe,
            Err(problems) => {
                let first = problems.diagnostics.first();
                return Some(Done::Failed(
                    first.map_or_else(|| problems.to_string(), |d| d.message.worded(&CommandLine)),
                ));
            }
        };
        let name = self.name(&recipe);
        if let Some(found) = self.read(&name) {
            return Some(found);
        }
        match self.run(recipe, &name) {
            Ok(done) => done,
            Err(why) => Some(Done::Failed(why)),
        }
    }

    /// All that decides what comes of a run, as a short number.
    fn name(&self, recipe: &Recipe) -> String {
        let text =
            format!("{} {:?} {} {}", eyot::VERSION, self.args.channel_area, self.args.picture, recipe.effective_toml());
        // FNV-1a: short, and the same everywhere.
        let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        format!("{hash:016x}")
    }

    fn read(&self, name: &str) -> Option<Done> {
        let text = std::fs::read_to_string(self.runs.join(format!("{name}.json"))).ok()?;
        let about: Value = serde_json::from_str(&text).ok()?;
        let (width, height, pixels) = store::read_rgb_png(&self.runs.join(format!("{name}.png")), &self.limits).ok()?;
        Some(Done::Made { about, picture: Picture { width, height, pixels } })
    }

    fn run(&self, recipe: Recipe, name: &str) -> Result<Option<Done>, String> {
        let word = |e: RunError| e.worded(&CommandLine);
        let view = recipe.view.clone();
        let options = RunOptions {
            threads: Some(self.threads),
            limits: self.limits,
            stream: Stream::Never,
            ..RunOptions::default()
        };
        let handle = eyot::Run::start(recipe, options).map_err(word)?;
        loop {
            match handle.events().recv_timeout(LOOK) {
                Err(RecvTimeoutError::Disconnected) => break,
                _ if self.interrupts.came() => drop(handle.send(Command::Stop)),
                _ => {}
            }
        }
        let outcome = handle.join().map_err(word)?;
        if !outcome.finished {
            return Ok(None);
        }
        let opened = store::of_run(outcome.world, view);
        let options = TerrainOptions { channel_area_m2: self.args.channel_area, ..TerrainOptions::default() };
        let stats = store::stats(&opened, &options, &self.limits).map_err(word)?;
        let about = json!({ "fingerprint": format!("{:016x}", outcome.fingerprint), "stats": stats });
        // The picture first: what has its numbers has it as well.
        let path = self.runs.join(format!("{name}.png"));
        let subject = Subject::ReliefAt(self.args.picture);
        store::draw(&opened.world, &opened.view, subject, &path, &self.limits).map_err(word)?;
        let (width, height, pixels) = store::read_rgb_png(&path, &self.limits).map_err(|e| e.to_string())?;
        let path = self.runs.join(format!("{name}.json"));
        write(&path, &format!("{about:#}\n")).map_err(|e| format!("cannot write `{}`: {e}", path.display()))?;
        Ok(Some(Done::Made { about, picture: Picture { width, height, pixels } }))
    }
}

/// The values that `KEY=VALUES` stands for.
fn axis(text: &str) -> Result<Axis, Failure> {
    let help = "write KEY=LOW..HIGH:COUNT, such as hydraulic.rain=0.001..0.005:5, or KEY=A,B,C, or KEY=VALUE";
    let bad = |why: &str| report::usage(&format!("`{text}`: {why}"), help);
    let (key, values) = text.split_once('=').ok_or_else(|| bad("there is no `=`"))?;
    let (key, values) = (key.trim().to_owned(), values.trim());
    let quoted = values.starts_with(['"', '\'', '[', '{']);
    let Some((low, rest)) = values.split_once("..").filter(|_| !quoted) else {
        let values: Vec<String> = match quoted {
            true => vec![values.to_owned()],
            false => values.split(',').map(|v| v.trim().to_owned()).collect(),
        };
        if key.is_empty() || values.iter().any(String::is_empty) {
            return Err(bad("a key or a value is missing"));
        }
        return Ok(Axis { key, values });
    };
    let (high, count) = rest.split_once(':').ok_or_else(|| bad("how many values? a range ends in :COUNT"))?;
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let (a, b) = number(low).zip(number(high)).ok_or_else(|| bad("both ends of a range are numbers"))?;
    let n = count.trim().parse::<usize>().ok().filter(|n| (2..=MOST_VALUES).contains(n));
    let n = n.ok_or_else(|| bad(&format!("the count is a whole number from 2 to {MOST_VALUES}")))?;
    let whole = [low, high].iter().all(|s| s.trim().parse::<i64>().is_ok());
    let value = |i: usize| {
        let v = a + (b - a) * i as f64 / (n - 1) as f64;
        // Twelve digits, without the noise of the last ones of a double.
        let v: f64 = format!("{v:.11e}").parse().unwrap_or(v);
        if whole && v.fract() == 0.0 { format!("{v}") } else { format!("{v:?}") }
    };
    Ok(Axis { key, values: (0..n).map(value).collect() })
}

/// All combinations, the last parameter changing first.
fn cells(axes: &[Axis]) -> Result<Vec<Cell>, Failure> {
    let count = axes.iter().try_fold(1usize, |n, a| n.checked_mul(a.values.len()).filter(|n| *n <= MOST));
    let count = count.ok_or_else(|| {
        report::usage(&format!("these are more than {MOST} runs"), "give fewer values, or sweep in several commands")
    })?;
    let cell = |mut i: usize| {
        let mut values = Vec::new();
        for a in axes.iter().rev() {
            values.insert(0, a.values[i % a.values.len()].clone());
            i /= a.values.len();
        }
        let set = axes.iter().zip(&values).map(|(a, v)| format!("{}={v}", a.key)).collect();
        Cell { set, values }
    };
    Ok((0..count).map(cell).collect())
}

fn unwritable(path: &Path, e: &std::io::Error) -> Failure {
    Failure::Failed(report::plain(&format!("cannot write `{}`: {e}", path.display()), None))
}

/// Writes a text whole or not at all.
fn write(path: &Path, text: &str) -> std::io::Result<()> {
    let part: PathBuf = path.with_extension(format!("{}.part", std::process::id()));
    std::fs::write(&part, text)?;
    std::fs::rename(&part, path)
}

/// Numbers of nested tables under their joined names; lists have no column.
fn flat(name: &str, value: &Value, out: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(k, v)| {
            flat(&if name.is_empty() { k.clone() } else { format!("{name}.{k}") }, v, out);
        }),
        Value::Number(n) => out.push((name.to_owned(), n.to_string())),
        _ => {}
    }
}

/// As RFC 4180 asks where a text has a comma, a quote or a line's end.
fn field(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

fn write_results(
    args: &Sweep,
    out: &Path,
    axes: &[Axis],
    cells: &[Cell],
    done: &[(usize, Done)],
    name: &str,
) -> Result<(), Failure> {
    let mut columns: Vec<String> = Vec::new();
    let mut rows = Vec::new();
    let mut list = Vec::new();
    let mut sheet: Vec<SheetCell> = Vec::new();
    let swept: Vec<usize> = (0..axes.len()).filter(|&i| axes[i].values.len() > 1).collect();
    for (i, result) in done {
        let cell = &cells[*i];
        let mut numbers = Vec::new();
        let (fingerprint, error) = match result {
            Done::Made { about, .. } => {
                flat("", &about["stats"], &mut numbers);
                (about["fingerprint"].as_str().unwrap_or_default(), "")
            }
            Done::Failed(why) => ("", why.as_str()),
        };
        for (column, _) in &numbers {
            if !columns.contains(column) {
                columns.push(column.clone());
            }
        }
        let set: Map<String, Value> = axes
            .iter()
            .zip(&cell.values)
            .map(|(a, v)| (a.key.clone(), serde_json::from_str(v).unwrap_or_else(|_| json!(v))))
            .collect();
        list.push(match result {
            Done::Made { about, .. } => {
                json!({ "run": i + 1, "set": set, "fingerprint": fingerprint, "stats": about["stats"] })
            }
            Done::Failed(why) => json!({ "run": i + 1, "set": set, "error": why }),
        });
        rows.push((i + 1, &cell.values, fingerprint.to_owned(), error.to_owned(), numbers));
        let shown = |k: &usize| format!("{}={}", axes[*k].key, cell.values[*k]);
        let mut words: Vec<String> = swept.iter().map(shown).collect();
        let picture = match result {
            Done::Made { picture, .. } => Some(picture.clone()),
            Done::Failed(_) => {
                words.push("failed".to_owned());
                None
            }
        };
        sheet.push(SheetCell { words, picture });
    }
    let mut csv = ["run"]
        .into_iter()
        .chain(axes.iter().map(|a| a.key.as_str()))
        .chain(["fingerprint", "error"])
        .map(field)
        .collect::<Vec<_>>()
        .join(",");
    columns.iter().for_each(|c| csv += &format!(",{}", field(c)));
    csv.push('\n');
    for (run, values, fingerprint, error, numbers) in &rows {
        csv += &run.to_string();
        values.iter().for_each(|v| csv += &format!(",{}", field(v)));
        csv += &format!(",{fingerprint},{}", field(error));
        for column in &columns {
            let value = numbers.iter().find(|(c, _)| c == column).map_or("", |(_, v)| v.as_str());
            csv += &format!(",{value}");
        }
        csv.push('\n');
    }
    let all = json!({ "recipe": name, "engine_version": eyot::VERSION, "runs": cells.len(), "results": list });
    for (file, text) in [(FILES[0], csv), (FILES[1], format!("{all:#}\n"))] {
        let path = out.join(file);
        write(&path, &text).map_err(|e| unwritable(&path, &e))?;
    }
    let columns = match swept.as_slice() {
        [.., last] if swept.len() > 1 => axes[*last].values.len(),
        _ => (done.len() as f64).sqrt().ceil() as usize,
    };
    let picture =
        store::contact_sheet(&format!("{name}, {} runs", cells.len()), &sheet, columns, args.picture as usize);
    write_rgb_png(&out.join(FILES[2]), picture.width, picture.height, &picture.pixels)
        .map_err(|e| Failure::Failed(report::plain(&e.to_string(), None)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        axis(text).map(|a| a.values).unwrap_or_default()
    }

    #[test]
    fn ranges_lists_and_single_values() {
        assert_eq!(values("a=1..5:5"), ["1", "2", "3", "4", "5"]);
        assert_eq!(values("a=0.1..0.3:3"), ["0.1", "0.2", "0.3"]);
        assert_eq!(values("a=1..2:3"), ["1", "1.5", "2"]);
        assert_eq!(values("a=-5..5:2"), ["-5", "5"]);
        assert_eq!(values("a=open,wrap"), ["open", "wrap"]);
        assert_eq!(values("grid.size=[4, 5]"), ["[4, 5]"]);
        for bad in ["a", "a=", "a=1..5", "a=1..x:3", "a=1..5:1", "=3", "a=1,,2"] {
            assert!(axis(bad).is_err(), "{bad}");
        }
        let axes = [axis("a=1,2"), axis("b=3..5:3")].map(|a| a.unwrap_or_else(|_| panic!()));
        let all: Vec<String> = cells(&axes).map(|c| c.iter().map(|c| c.set.join(" ")).collect()).unwrap_or_default();
        assert_eq!(all, ["a=1 b=3", "a=1 b=4", "a=1 b=5", "a=2 b=3", "a=2 b=4", "a=2 b=5"]);
    }
}
