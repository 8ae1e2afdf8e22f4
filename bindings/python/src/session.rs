//! Runs that Python advances.

use crate::error;
use crate::event;
use crate::recipe::{Recipe, limits};
use crate::work::{Done, attended, pool};
use crate::world::World;
use eyot::session::{Budget, Memory, SessionOptions, Status, Storage};
use eyot::{
    Cancel, Centering, Change, Command, EngineChoice, EngineOptions, Event, Field, JournalEntry, Record, Registry,
    RunError, RunOptions, World as Land,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::ThreadPool;
use std::io::Read;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// A run that is polled. Only one thread at a time advances it; commands may come from any.
#[pyclass(module = "eyot._eyot", frozen)]
pub(crate) struct Session {
    inner: Mutex<Inner>,
    commands: Mutex<Vec<Command>>,
    cancel: Cancel,
    pool: Arc<ThreadPool>,
    view: eyot::View,
    /// The files of the results, if they are kept in memory.
    kept: Option<Memory>,
}

struct Inner {
    session: Option<eyot::session::Session>,
    ended: Option<Ended>,
    /// The world while Python looks at it.
    lent: Option<Py<World>>,
    /// Events of a session that is over, which nobody has heard.
    unheard: Vec<Event>,
}

impl Inner {
    /// Keeps of a session that has failed what it has told.
    fn give_up(&mut self) {
        let events = self.session.take().map(|mut session| session.events());
        self.unheard.extend(events.into_iter().flatten());
    }
}

struct Ended {
    world: Py<World>,
    fingerprint: String,
    finished: bool,
    outputs: Vec<PathBuf>,
    journal: Vec<JournalEntry>,
}

/// The engine of that name; `None` leaves it open.
pub(crate) fn engine(py: Python<'_>, name: Option<&str>, adapter: Option<String>) -> PyResult<Option<EngineOptions>> {
    let refuse = |message: &str, help| Err(error::raise(py, message, Some(help)));
    let choice = match name {
        None if adapter.is_none() => return Ok(None),
        Some("cpu") if adapter.is_some() => {
            return refuse(
                "`engine=\"cpu\"` takes no graphics adapter",
                "leave `adapter=` out, or choose `engine=\"gpu\"`",
            );
        }
        None | Some("gpu") => EngineChoice::Gpu,
        Some("cpu") => EngineChoice::Cpu,
        Some("auto") => EngineChoice::Auto,
        Some(other) => return refuse(&format!("there is no engine `{other}`"), "there is auto, cpu and gpu"),
    };
    Ok(Some(EngineOptions { choice, adapter, ..EngineOptions::default() }))
}

#[pymethods]
impl Session {
    /// A run of `recipe`, or the stopped run in the folder `out` if there is none, or what [`Session::freeze`] gave.
    #[new]
    #[pyo3(signature = (recipe=None, *, threads=0, out=None, engine=None, adapter=None, max_memory=None, paused=false, restart=false,
        force=false, record=None, record_limit=None, checkpoint_seconds=60.0, replay=None, checkpoint=None, files=false))]
    fn new(
        py: Python<'_>,
        recipe: Option<&Recipe>,
        threads: usize,
        out: Option<PathBuf>,
        engine: Option<&str>,
        adapter: Option<String>,
        max_memory: Option<u64>,
        paused: bool,
        restart: bool,
        force: bool,
        record: Option<u64>,
        record_limit: Option<u64>,
        checkpoint_seconds: f64,
        replay: Option<&str>,
        checkpoint: Option<&[u8]>,
        files: bool,
    ) -> PyResult<Self> {
        let wrong = |message: &str, help| error::raise(py, message, Some(help));
        let replay: Vec<JournalEntry> = serde_json::from_str(replay.unwrap_or("[]"))
            .map_err(|e| wrong(&format!("`replay=` is no journal: {e}"), "give the `journal` of an earlier run"))?;
        let checkpoint_every = Duration::try_from_secs_f64(checkpoint_seconds)
            .map_err(|_| wrong("`checkpoint_seconds=` is no time", "give seconds, such as 60"))?;
        let options = RunOptions {
            out: out.clone(),
            engine: self::engine(py, engine, adapter)?,
            limits: limits(max_memory),
            paused,
            restart,
            force,
            checkpoint_every,
            replay,
            record: record.map(|every| Record { every, max_bytes: record_limit.unwrap_or(4 << 30) }),
            ..RunOptions::default()
        };
        let pool = pool(py, threads)?;
        let kept = files.then(Memory::new);
        let begin = || match (recipe, &out, checkpoint) {
            (Some(recipe), None, None) if kept.is_some() => {
                in_memory(recipe, options, kept.clone().unwrap_or_default())
            }
            (_, _, Some(bytes)) => eyot::Run::session_of(bytes, &eyot::Registry::standard(), options),
            (Some(recipe), ..) => eyot::Run::session(recipe.0.clone(), options),
            (None, Some(folder), _) => eyot::Run::resume_session(folder, &eyot::Registry::standard(), options),
            (None, None, None) => Err(RunError::input("there is neither a recipe nor a folder to go on in")),
        };
        let session = attended(py, &pool, None, begin)?.result.map_err(|e| error::run(py, &e))?;
        let (cancel, view) = (session.cancel(), session.recipe().view.clone());
        let inner = Inner { session: Some(session), ended: None, lent: None, unheard: Vec::new() };
        Ok(Self { inner: Mutex::new(inner), commands: Mutex::default(), cancel, pool, view, kept })
    }

    /// Works for so many steps or seconds, or to the end, and says how the run stands: `working`, `paused`, `finished` or `stopped`. On
    /// Ctrl-C the run is stopped, with a checkpoint if it has a folder.
    #[pyo3(signature = (steps=None, seconds=None))]
    fn advance(&self, py: Python<'_>, steps: Option<u64>, seconds: Option<f64>) -> PyResult<&'static str> {
        let mut inner = self.inner(py)?;
        if inner.lent.is_some() {
            let help = Some("leave the block of `with run.paused()` first");
            return Err(error::raise(py, "the run cannot go on while its world is looked at", help));
        }
        let Some(session) = inner.session.as_mut() else {
            return Ok(inner.ended.as_ref().map_or("failed", |e| if e.finished { "finished" } else { "stopped" }));
        };
        let commands = std::mem::take(&mut *self.commands.lock().unwrap_or_else(PoisonError::into_inner));
        commands.into_iter().for_each(|c| session.command(c));
        let budget = match (steps, seconds) {
            (Some(n), _) => Budget::Steps(n),
            (None, Some(s)) => Budget::Time(Duration::try_from_secs_f64(s).unwrap_or_default()),
            (None, None) => Budget::Time(Duration::MAX),
        };
        let cancel = self.cancel.clone();
        let work = || -> Result<Status, RunError> {
            let mut status = session.advance(budget)?;
            while cancel.is_raised() && !is_over(status) {
                session.command(Command::Stop);
                status = session.advance(Budget::Piece)?;
            }
            Ok(status)
        };
        let done = attended(py, &self.pool, Some(&self.cancel), work);
        // The signal of a handler that raised; what was under way is finished by now, or stopped.
        let (result, signal) = match done {
            Ok(Done { result: Ok(status), signal: Some(signal) }) if !is_over(status) => {
                let stop = || loop {
                    session.command(Command::Stop);
                    match session.advance(Budget::Piece) {
                        Ok(status) if !is_over(status) => {}
                        other => break other,
                    }
                };
                (attended(py, &self.pool, None, stop).map(|done| done.result), Some(signal))
            }
            Ok(Done { result, signal }) => (Ok(result), signal),
            Err(panicked) => (Err(panicked), None),
        };
        let status = match result {
            Ok(Ok(status)) => status,
            Ok(Err(e)) => {
                inner.give_up();
                return Err(error::run(py, &e));
            }
            Err(panicked) => {
                inner.session = None;
                return Err(panicked);
            }
        };
        if is_over(status) {
            self.keep_end(py, &mut inner)?;
        }
        signal.map_or(Ok(()), Err)?;
        Ok(match status {
            Status::Paused => "paused",
            Status::Finished => "finished",
            Status::Stopped => "stopped",
            Status::Failed => "failed",
            _ => "working",
        })
    }

    /// How a run that is over ended; nothing while it is not, or at work in another thread.
    fn state(&self) -> Option<&'static str> {
        let inner = self.inner.try_lock().ok()?;
        match (&inner.session, &inner.ended) {
            (Some(_), _) => None,
            (None, Some(ended)) => Some(if ended.finished { "finished" } else { "stopped" }),
            (None, None) => Some("failed"),
        }
    }

    /// What has happened since the last call.
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let mut inner = self.inner(py)?;
        let mut events = std::mem::take(&mut inner.unheard);
        events.extend(inner.session.as_mut().map(|s| s.events()).unwrap_or_default());
        events.iter().map(|e| event::to_dict(py, e)).collect()
    }

    /// Gives a command: `pause`, `resume`, `step`, `stop`, `set` with a text, `rewind` and `branch` with a step.
    #[pyo3(signature = (name, *, steps=0, set=None, forget=false, out=None))]
    fn command(
        &self,
        py: Python<'_>,
        name: &str,
        steps: u64,
        set: Option<&str>,
        forget: bool,
        out: Option<PathBuf>,
    ) -> PyResult<()> {
        let command = match (name, set, out) {
            ("pause", ..) => Command::Pause,
            ("resume", ..) => Command::Resume,
            ("step", ..) => Command::Step(steps),
            ("stop", ..) => {
                self.cancel.raise();
                Command::Stop
            }
            ("set", Some(text), _) => Command::Change(Change::parse(text).map_err(|p| error::recipe(py, &p))?),
            ("rewind", ..) => Command::Rewind { step: steps, forget },
            ("branch", _, Some(out)) => Command::Branch { step: steps, out },
            _ => return Err(error::raise(py, &format!("there is no command `{name}`"), None)),
        };
        self.commands.lock().unwrap_or_else(PoisonError::into_inner).push(command);
        Ok(())
    }

    /// Takes the world out, without a copy. It is to be given back.
    fn lend(&self, py: Python<'_>) -> PyResult<Py<World>> {
        let mut inner = self.inner(py)?;
        let Some(session) = inner.session.as_mut() else {
            return Err(error::raise(py, "the run is over", Some("its last world is `run.dataset()`")));
        };
        let lent = attended(py, &self.pool, None, || session.lend())?.result;
        let Some(world) = lent else {
            return Err(error::raise(py, "the world is being looked at already", Some("leave the other block first")));
        };
        let world = Py::new(py, World::of_run(world, self.view.clone()))?;
        inner.lent = Some(world.clone_ref(py));
        Ok(world)
    }

    /// Gives the world back, with other values for some layers, arrays of its own shape. If arrays on its memory are still there they keep it, and
    /// the run goes on with a copy.
    #[pyo3(signature = (changes=Vec::new()))]
    fn restore(&self, py: Python<'_>, changes: Vec<(String, numpy::PyReadonlyArray2<'_, f32>)>) -> PyResult<()> {
        let mut inner = self.inner(py)?;
        let Some(lent) = inner.lent.take() else { return Ok(()) };
        let opened = lent.get().0.clone();
        drop(lent);
        let Some(session) = inner.session.as_mut() else { return Ok(()) };
        let world = Arc::try_unwrap(opened).map_or_else(|shared| shared.world.clone(), |own| own.world);
        session.restore(world);
        if changes.is_empty() {
            return Ok(());
        }
        let fields: Vec<(String, Field)> = changes
            .iter()
            .map(|(name, values)| {
                let array = values.as_array();
                let (rows, columns) = array.dim();
                (name.clone(), Field::from_fn(columns, rows, |x, y| array[[y, x]]))
            })
            .collect();
        let edit = || session.edit(|land| put(land, fields));
        let done = attended(py, &self.pool, None, edit)?.result.map_err(|e| error::run(py, &e))?;
        done.map_err(|message| error::raise(py, &message, Some("nothing of it was changed")))
    }

    /// Writes a checkpoint, and says where; nothing without a folder.
    fn save(&self, py: Python<'_>) -> PyResult<Option<PathBuf>> {
        let mut inner = self.inner(py)?;
        let Some(session) = inner.session.as_mut() else { return Ok(None) };
        attended(py, &self.pool, None, || session.save_checkpoint())?.result.map_err(|e| error::run(py, &e))
    }

    /// A checkpoint as bytes; none of a run that is over or whose world is looked at.
    fn freeze<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let mut inner = self.inner(py)?;
        let Some(session) = inner.session.as_mut() else { return Ok(None) };
        let bytes =
            attended(py, &self.pool, None, || session.checkpoint_bytes())?.result.map_err(|e| error::run(py, &e))?;
        Ok(bytes.map(|b| PyBytes::new(py, &b)))
    }

    /// A copy of the world as it is; the last one without a copy.
    fn world(&self, py: Python<'_>) -> PyResult<Py<World>> {
        let mut inner = self.inner(py)?;
        if let Some(ended) = &inner.ended {
            return Ok(ended.world.clone_ref(py));
        }
        let Some(session) = inner.session.as_mut() else { return Err(error::raise(py, "the run has failed", None)) };
        let copy = || {
            let world = session.lend()?;
            let copy = world.clone();
            session.restore(world);
            Some(copy)
        };
        match attended(py, &self.pool, None, copy)?.result {
            Some(world) => Py::new(py, World::of_run(world, self.view.clone())),
            None => Err(error::raise(
                py,
                "the world is being looked at",
                Some("leave the block of `with run.paused()` first"),
            )),
        }
    }

    /// Names of the files that are kept in memory.
    fn file_names(&self) -> Vec<String> {
        self.kept.as_ref().map(Memory::names).unwrap_or_default()
    }

    /// The bytes of one of them.
    fn file<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyBytes>>> {
        let Some(mut blob) = self.kept.as_ref().and_then(|memory| memory.open(name).ok()) else { return Ok(None) };
        let mut bytes = Vec::new();
        blob.input.read_to_end(&mut bytes)?;
        Ok(Some(PyBytes::new(py, &bytes)))
    }

    /// Fingerprint, whether it came to its end, files and journal of a run that is over.
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let inner = self.inner(py)?;
        let Some(e) = &inner.ended else { return Ok(None) };
        let value = serde_json::json!({
            "fingerprint": e.fingerprint, "finished": e.finished, "outputs": e.outputs, "journal": e.journal,
        });
        crate::recipe::to_python(py, &value).map(Some)
    }
}

impl Session {
    /// Nobody waits for it with Python's lock in hand: whoever has it may need that lock to go on.
    fn inner(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Inner>> {
        match self.inner.try_lock() {
            Ok(inner) => Ok(inner),
            Err(TryLockError::Poisoned(e)) => Ok(e.into_inner()),
            Err(TryLockError::WouldBlock) => {
                let help = Some("give it commands, or ask it again when that thread has it no more");
                Err(error::raise(py, "the run is at work in another thread", help))
            }
        }
    }

    /// Takes the world of a session that is over.
    fn keep_end(&self, py: Python<'_>, inner: &mut Inner) -> PyResult<()> {
        let Some(mut session) = inner.session.take() else { return Ok(()) };
        inner.unheard.extend(session.events());
        let Some(outcome) = session.into_outcome() else { return Ok(()) };
        inner.ended = Some(Ended {
            world: Py::new(py, World::of_run(outcome.world, self.view.clone()))?,
            fingerprint: format!("{:016x}", outcome.fingerprint),
            finished: outcome.finished,
            outputs: outcome.outputs,
            journal: outcome.journal,
        });
        Ok(())
    }
}

/// A run whose results are files in memory.
fn in_memory(recipe: &Recipe, options: RunOptions, memory: Memory) -> Result<eyot::session::Session, RunError> {
    let options = SessionOptions {
        // Nobody outside sees a checkpoint there.
        checkpoint_every: Duration::MAX,
        limits: options.limits,
        engine: options.engine,
        paused: options.paused,
        replay: options.replay,
        record: options.record,
        ..SessionOptions::default()
    };
    let host = eyot::host(&Registry::standard()).with_storage(memory);
    eyot::session::Session::new(recipe.0.clone(), options, host)
}

/// Puts other values into layers: into all or none.
fn put(land: &mut Land, fields: Vec<(String, Field)>) -> Result<(), String> {
    for (name, field) in &fields {
        let layer = land.layer(name).map_err(|e| e.to_string())?;
        let [rows, columns] = layer.field.shape();
        if field.shape() != [rows, columns] {
            let [r, c] = field.shape();
            return Err(format!("`{name}` has {rows} rows and {columns} columns, not {r} and {c}"));
        }
        if layer.spec.centering != Centering::Cell {
            return Err(format!("`{name}` is on the faces of cells, where matter would come out of nothing"));
        }
        let (low, high) = layer.spec.range;
        if let Some(v) = field.iter().find(|v| !(low..=high).contains(v)) {
            return Err(format!("`{name}` takes {low} to {high} {}, not {v}", layer.spec.unit));
        }
    }
    for (name, field) in fields {
        let layer = land.layer_mut(&name).map_err(|e| e.to_string())?;
        for (to, from) in layer.field.rows_mut().zip(field.rows()) {
            to.copy_from_slice(from);
        }
    }
    Ok(())
}

fn is_over(status: Status) -> bool {
    matches!(status, Status::Finished | Status::Stopped | Status::Failed)
}
