//! What can go wrong with a run.

use crate::diagnostic::Problems;
use std::path::PathBuf;

/// An error of a run, with its remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The recipe is not right.
    #[error("{0}")]
    Recipe(#[from] Problems),
    /// A generator, a process or the engine failed.
    #[error("{step}: {source}")]
    Step {
        /// The step, by number and name.
        step: String,
        /// What happened.
        source: eyot_core::Error,
    },
    /// A file could not be read or written.
    #[error("{0}")]
    File(String),
    /// The output folder cannot be used.
    #[error("cannot use `{}`: {source}", path.display())]
    Folder {
        /// The folder or file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Another run works in the folder.
    #[error("another run{} is writing to `{}`", pid.map(|p| format!(" (process {p})")).unwrap_or_default(), folder.display())]
    Busy {
        /// The folder.
        folder: PathBuf,
        /// The other process.
        pid: Option<u32>,
    },
    /// The folder holds a run that was stopped.
    #[error("`{}` holds a run that was stopped and can be continued", folder.display())]
    Unfinished {
        /// The folder.
        folder: PathBuf,
    },
    /// There is nothing to resume.
    #[error("`{}` holds no stopped run", folder.display())]
    NothingToResume {
        /// The folder.
        folder: PathBuf,
        /// Whether a finished run is there.
        finished: bool,
    },
    /// The run cannot be streamed, which was asked for.
    #[error("the run cannot be streamed: {0}")]
    NotStreamed(String),
    /// Somebody asked for a stop while results were written.
    #[error("stopped on request")]
    Stopped,
    /// The thread pool could not be made.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// The system's reason.
        reason: String,
    },
    /// A fault of the program.
    #[error("the run broke: {0}")]
    Fault(String),
}

impl RunError {
    /// Errors of files and pictures name the file and the remedy themselves.
    pub(crate) fn file(e: impl std::fmt::Display) -> Self {
        Self::File(e.to_string())
    }

    /// What to do about it.
    pub fn help(&self) -> Option<String> {
        use eyot_core::Error as Core;
        Some(match self {
            Self::Step { source: Core::NotFinite { .. }, .. } => {
                "the parameters of this step are too strong for the grid; lower them, or report it if they are all within their ranges".to_owned()
            }
            Self::Step { source: Core::Limit { remedy, .. }, .. } => (*remedy).to_owned(),
            Self::Step { source: Core::BadParameter { owner, .. }, .. } => format!("`eyot describe {owner}` explains its parameters"),
            Self::Folder { .. } => "choose another folder with --out, or check its permissions and the space on its disk".to_owned(),
            Self::Busy { .. } => "wait for it, stop it, or choose another folder with --out".to_owned(),
            Self::Unfinished { folder } => {
                format!("continue it with `eyot resume {0}`, start over with --restart, or choose another folder with --out", folder.display())
            }
            Self::NothingToResume { finished: true, folder } => {
                format!("the run there is finished; look at it with `eyot render {0}` or `eyot stats {0}`", folder.display())
            }
            Self::NothingToResume { .. } => "give the folder that a stopped run was writing to".to_owned(),
            Self::NotStreamed(_) => "leave out --stream always, or switch off what stands in the way".to_owned(),
            Self::Threads { .. } => "choose fewer with --threads".to_owned(),
            Self::Fault(_) => "this is a fault of Eyot: please report it with the recipe; the last checkpoint is sound".to_owned(),
            _ => return None,
        })
    }
}
