//! `run` and `resume`: starts a run, listens to it, and to Ctrl-C.

use crate::args::{Resume, Run, Work};
use crate::progress::Bars;
use crate::wording::CommandLine;
use crate::{Failure, print, recipe_cmd, report};
use eyot::{Command, Handle, JournalEntry, Record, Registry, Remote, RunOptions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Interrupts that come closer together than this are one.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);

/// Runs a recipe.
pub(crate) fn run(args: &Run) -> Result<(), Failure> {
    let recipe = recipe_cmd::read(&args.recipe, &args.change, &args.shape.preset)?;
    let out = args.out.clone().unwrap_or_else(|| folder_name(&args.recipe));
    let replay = args.replay.as_deref().map(journal).transpose()?.unwrap_or_default();
    let options = RunOptions {
        out: Some(out.clone()),
        limits: recipe_cmd::limits(args.change.max_memory),
        stream: args.shape.stream,
        restart: args.restart,
        force: args.force,
        replay,
        ..options(&args.work)?
    };
    let interrupts = Interrupts::install();
    let handle = eyot::Run::start(recipe, options).map_err(|e| report::run(&e))?;
    attend(handle, &interrupts, &args.work, &out)
}

/// Continues a stopped run.
pub(crate) fn resume(args: &Resume) -> Result<(), Failure> {
    if !args.folder.is_dir() {
        let message = format!("`{}` is not a folder", args.folder.display());
        return Err(report::usage(&message, "give the folder that a stopped run was writing to (its --out)"));
    }
    let options = RunOptions { limits: recipe_cmd::limits(args.max_memory), ..options(&args.work)? };
    let interrupts = Interrupts::install();
    let handle = eyot::Run::resume(&args.folder, &Registry::standard(), options).map_err(|e| report::run(&e))?;
    attend(handle, &interrupts, &args.work, &args.folder)
}

pub(crate) fn options(work: &Work) -> Result<RunOptions, Failure> {
    Ok(RunOptions {
        threads: work.threads.map(usize::from),
        checkpoint_every: Duration::from_secs_f64(work.checkpoint_seconds),
        engine: work.engine.options()?,
        record: work.record.map(|every| Record { every, max_bytes: work.record_limit }),
        ..RunOptions::default()
    })
}

/// `recipes/island.toml` and `island` both write to `island`.
pub(crate) fn folder_name(recipe: &str) -> PathBuf {
    Path::new(recipe).file_stem().map_or_else(|| PathBuf::from("eyot-run"), PathBuf::from)
}

fn journal(path: &Path) -> Result<Vec<JournalEntry>, Failure> {
    let help = "give the run.json of an earlier run";
    let fail = |m: String| report::usage(&format!("cannot replay `{}`: {m}", path.display()), help);
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        return Err(fail("it is not a file".into()));
    }
    let bytes = std::fs::read(path).map_err(|e| fail(e.to_string()))?;
    let report: serde_json::Value = serde_json::from_slice(&bytes).map_err(|_| fail("it is no JSON".into()))?;
    let Some(journal) = report.get("journal") else { return Err(fail("it lists no commands".into())) };
    serde_json::from_value(journal.clone()).map_err(|e| fail(format!("its list of commands is damaged: {e}")))
}

/// Ctrl-C and the system's request to end: the first stops the run with a checkpoint, the second ends at once.
pub(crate) struct Interrupts {
    count: Arc<AtomicU32>,
    remote: Arc<Mutex<Option<Remote>>>,
}

impl Interrupts {
    pub(crate) fn install() -> Self {
        Self::saying("stopping with a checkpoint; Ctrl-C again ends at once")
    }

    /// As [`Interrupts::install`], with other words for the first.
    pub(crate) fn saying(words: &'static str) -> Self {
        let this = Self { count: Arc::default(), remote: Arc::default() };
        let (count, remote) = (this.count.clone(), this.remote.clone());
        let first: Mutex<Option<Instant>> = Mutex::default();
        let handler = move || {
            if count.fetch_add(1, Ordering::SeqCst) > 0 {
                // A terminal and a wrapper may both pass the same Ctrl-C on: that is still the first.
                if first.lock().is_ok_and(|f| f.is_none_or(|at| at.elapsed() < SAME_INTERRUPT)) {
                    return;
                }
                std::process::exit(130);
            }
            if let Ok(mut first) = first.lock() {
                *first = Some(Instant::now());
            }
            let sent = remote.lock().is_ok_and(|r| r.as_ref().is_none_or(|r| r.send(Command::Stop)));
            print::note(if sent { words } else { "ending" });
        };
        if let Err(e) = ctrlc::set_handler(handler) {
            print::note(&format!("warning: Ctrl-C will end the run without a checkpoint: {e}"));
        }
        this
    }

    /// Connects the run; an interrupt that came before stops it now.
    pub(crate) fn connect(&self, run: Remote) {
        if let Ok(mut remote) = self.remote.lock() {
            *remote = Some(run.clone());
        }
        if self.came() {
            run.send(Command::Stop);
        }
    }

    /// Whether one came.
    pub(crate) fn came(&self) -> bool {
        self.count.load(Ordering::SeqCst) > 0
    }
}

/// Shows what the run tells until it ends.
fn attend(handle: Handle, interrupts: &Interrupts, work: &Work, out: &Path) -> Result<(), Failure> {
    interrupts.connect(handle.remote());
    let mut bars = (!work.quiet && !work.json).then(Bars::new);
    let mut unheard = None;
    for event in handle.events() {
        if work.json {
            // A reader that has gone away or a full device do not stop the run: its files are still wanted.
            let text = serde_json::to_string(&event.worded(&CommandLine)).unwrap_or_default();
            if unheard.is_none() {
                unheard = print::line(&text).err();
            }
        } else if let Some(bars) = &mut bars {
            bars.show(&event);
        }
    }
    drop(bars);
    let outcome = handle.join().map_err(|e| report::run(&e))?;
    if outcome.finished {
        // Without all the events, a script must not take the run for a success.
        return unheard.filter(|f| !matches!(f, Failure::Closed)).map_or(Ok(()), Err);
    }
    print::note(&format!("stopped; continue with: eyot resume {}", eyot::shell_word(out)));
    Err(Failure::Stopped)
}
