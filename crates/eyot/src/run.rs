//! Runs with everything that comes with Eyot.

use crate::engines::Engines;
use crate::registry::Registry;
use eyot_export::RunFiles;
use eyot_recipe::Recipe;
use eyot_session::{Clock, Handle, Host, RunError, RunOptions, Session};
use std::path::Path;

/// A host for sessions and runs of recipes of this registry: all engines, and the files of [`RunFiles`].
pub fn host(registry: &Registry) -> Host {
    Host::new(registry, Clock::system()).with_engines(Engines).with_outputs(RunFiles)
}

/// The entry point to runs.
#[derive(Clone, Copy, Debug)]
pub struct Run;

impl Run {
    /// Finds what [`Run::start`] would refuse beside the folder for the results, and says whether the run would be streamed.
    ///
    /// # Errors
    /// As [`eyot_session::Run::check`].
    pub fn check(recipe: &Recipe, options: &RunOptions) -> Result<bool, RunError> {
        eyot_session::Run::check(recipe, options, &Registry::standard())
    }

    /// Starts a recipe on a thread of its own.
    ///
    /// # Errors
    /// As [`eyot_session::Run::start`].
    pub fn start(recipe: Recipe, options: RunOptions) -> Result<Handle, RunError> {
        eyot_session::Run::start(recipe, options, &host(&Registry::standard()))
    }

    /// Continues a stopped run at the exact step: that of its checkpoint, or of the last recorded frame if it is later.
    ///
    /// # Errors
    /// As [`eyot_session::Run::resume`].
    pub fn resume(folder: &Path, registry: &Registry, options: RunOptions) -> Result<Handle, RunError> {
        eyot_session::Run::resume(folder, options, &host(registry))
    }

    /// A recipe as a session that the caller polls, in a folder of its own if the options name one.
    ///
    /// # Errors
    /// As [`eyot_session::Run::session`].
    pub fn session(recipe: Recipe, options: RunOptions) -> Result<Session, RunError> {
        eyot_session::Run::session(recipe, options, &host(&Registry::standard()))
    }

    /// A stopped run as a session that the caller polls.
    ///
    /// # Errors
    /// As [`eyot_session::Run::resume_session`].
    pub fn resume_session(folder: &Path, registry: &Registry, options: RunOptions) -> Result<Session, RunError> {
        eyot_session::Run::resume_session(folder, options, &host(registry))
    }

    /// What a session saved as bytes, as a session without a folder.
    ///
    /// # Errors
    /// As [`eyot_session::Run::session_of`].
    pub fn session_of(checkpoint: &[u8], registry: &Registry, options: RunOptions) -> Result<Session, RunError> {
        eyot_session::Run::session_of(checkpoint, options, &host(registry))
    }
}
