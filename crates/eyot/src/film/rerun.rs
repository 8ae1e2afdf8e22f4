//! A run that is done again for a film: the recipe of a finished run, held at each moment that is to be seen.

use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting};
use eyot_core::{Control, Limits, World};
use eyot_export::estimate;
use eyot_io::checkpoint;
use eyot_io::run_folder::WORLD_FILE;
use eyot_recipe::{Recipe, Work, memory};
use eyot_session::{Command, Event, Handle, Host, Run, RunError, RunOptions, State, Stream};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// How often a request to stop is looked for while the run is at work.
const LOOK: Duration = Duration::from_millis(100);

/// What the folder of a finished run says about it.
pub(super) struct Made {
    /// The world that it ended with.
    pub(super) world: World,
    recipe: Recipe,
    state: State,
    host: Host,
}

impl Made {
    /// Reads the folder of a finished run.
    ///
    /// # Errors
    /// If it holds none, or one that simulates nothing, or the run does not fit into memory beside its film.
    pub(super) fn open(folder: &Path, host: &Host, limits: &Limits) -> Result<Self, RunError> {
        let refuse = |reason: Remedy| {
            let simulate = " films runs that simulate something and that ";
            RunError::refused(reason, remedy![Setting::Run, simulate, Action::Run, " finished in one piece"])
        };
        let file = folder.join(WORLD_FILE);
        let saved = checkpoint::load(&file, limits, host.registry.components()).map_err(|e| refuse(e.into()))?;
        let state: State = serde_json::from_value(saved.state)
            .map_err(|e| refuse(format!("`{}` holds no state of a run: {e}", file.display()).into()))?;
        if !state.finished {
            return Err(refuse(format!("the run in `{}` is not finished", folder.display()).into()));
        }
        let overrides = state.overrides.clone();
        let recipe = state.recipe(saved.recipe_toml, overrides, &host.registry, limits)?;
        let made = Self { world: saved.world, recipe, state, host: host.clone() };
        let (first, last) = made.span();
        if first == last {
            return Err(refuse(format!("the run in `{}` simulates nothing", folder.display()).into()));
        }
        let peak = memory::working(&made.recipe.steps, &made.recipe.grid).map_err(RunError::file)?;
        // The run, a copy of its world, and the world that it ended with.
        estimate::check("this film of a run", &made.world, peak.bytes + peak.world_bytes, limits, remedy())
            .map_err(RunError::file)?;
        Ok(made)
    }

    /// The first and the last moment worth seeing, in steps since the beginning; a generator counts as one.
    fn span(&self) -> (u64, u64) {
        let steps = |work: &Work| if let Work::Simulate(s) = work { s.steps } else { 1 };
        let works = || self.recipe.enabled_steps().map(|s| &s.work);
        let ground = works().take_while(|w| !matches!(w, Work::Simulate(_))).count() as u64;
        (ground, works().map(steps).sum())
    }

    /// The moment that a picture of a film shows: evenly from the first to the last; a single picture shows the end.
    pub(super) fn moment(&self, picture: u32, frames: u32) -> u64 {
        let (first, last) = self.span();
        if frames <= 1 {
            return last;
        }
        let share = f64::from(picture) / f64::from(frames - 1);
        first + (share * (last - first) as f64).round() as u64
    }

    /// Begins the run again.
    ///
    /// # Errors
    /// As [`Run::start`].
    pub(super) fn start(&self, limits: &Limits, control: &Control<'_>) -> Result<Rerun, RunError> {
        let options = RunOptions {
            limits: *limits,
            stream: Stream::Never,
            paused: true,
            replay: self.state.journal.clone(),
            ..RunOptions::default()
        };
        let handle = Run::start(self.recipe.clone(), options, &self.host)?;
        let mut rerun = Rerun { handle: Some(handle), done: 0, last: self.span().1, end: None, notes: Vec::new() };
        rerun.wait(control, |e| matches!(e, Event::Paused { .. }))?;
        Ok(rerun)
    }
}

fn remedy() -> Remedy {
    remedy!["film the finished world without ", Setting::Run, ", or choose a smaller grid"]
}

/// A run at work, waiting at a moment.
pub(super) struct Rerun {
    handle: Option<Handle>,
    done: u64,
    last: u64,
    end: Option<Arc<World>>,
    /// What the run had to say.
    pub(super) notes: Vec<Remedy>,
}

impl Rerun {
    /// The world after so many steps; moments come in their order.
    ///
    /// # Errors
    /// If the run fails, and [`RunError::Stopped`] on a request to stop.
    pub(super) fn world_at(&mut self, moment: u64, control: &Control<'_>) -> Result<Arc<World>, RunError> {
        if moment > self.done {
            self.send(Command::Step(moment - self.done));
            self.done = moment;
            if moment < self.last {
                self.wait(control, |e| matches!(e, Event::Paused { .. }))?;
            }
        }
        if moment >= self.last {
            return self.end(control);
        }
        self.send(Command::Snapshot);
        match self.wait(control, |e| matches!(e, Event::Snapshot { .. }))? {
            Some(Event::Snapshot { world, .. }) => Ok(world),
            _ => self.end(control),
        }
    }

    /// The world at the end of the run.
    fn end(&mut self, control: &Control<'_>) -> Result<Arc<World>, RunError> {
        if self.end.is_none() {
            self.wait(control, |_| false)?;
            let handle = self.handle.take().ok_or_else(|| RunError::Fault("a film's run was lost".to_owned()))?;
            self.end = Some(Arc::new(handle.join()?.world));
        }
        self.end.clone().ok_or(RunError::Stopped)
    }

    fn send(&self, command: Command) {
        // A run that has failed says so when it is joined.
        let _ = self.handle.as_ref().is_some_and(|h| h.send(command));
    }

    /// The next event that is wanted, or `None` if the run ends without one.
    fn wait(&mut self, control: &Control<'_>, wanted: impl Fn(&Event) -> bool) -> Result<Option<Event>, RunError> {
        let Some(handle) = &self.handle else { return Ok(None) };
        loop {
            control.check().map_err(|_| RunError::Stopped)?;
            match handle.events().recv_timeout(LOOK) {
                Ok(Event::Warning { message }) => self.notes.push(message),
                Ok(event) if wanted(&event) => return Ok(Some(event)),
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
            }
        }
    }
}

impl Drop for Rerun {
    fn drop(&mut self) {
        if let Some(handle) = self.handle.take() {
            handle.send(Command::Stop);
            // What a run without a film ends with is of no use to anybody.
            let _ = handle.join();
        }
    }
}
