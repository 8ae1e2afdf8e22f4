//! What can go wrong with files and pictures.

use std::fmt::Display;
use std::path::PathBuf;

/// An error of an export, a conversion or a picture. The message names the file, and the remedy where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// What was asked for cannot be: an input that is not there or is something else, an output that makes no sense.
    #[error("{reason}")]
    Input {
        /// What is wrong, and where.
        reason: String,
        /// What would be right, if that does not say it.
        help: Option<&'static str>,
    },
    /// A file or a picture could not be made.
    #[error("{0}")]
    File(String),
    /// Values do not fit the format.
    #[error("{0}")]
    Values(String),
    /// The folder cannot be used.
    #[error("cannot use `{}`: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Somebody asked for a stop.
    #[error("stopped on request")]
    Stopped,
}

impl ExportError {
    pub(crate) fn input(reason: impl Display) -> Self {
        Self::Input { reason: reason.to_string(), help: None }
    }

    pub(crate) fn file(reason: impl Display) -> Self {
        Self::File(reason.to_string())
    }

    /// Of work that can be stopped.
    pub fn stopped(e: eyot_core::Error) -> Self {
        if matches!(e, eyot_core::Error::Cancelled(_)) { Self::Stopped } else { Self::file(e) }
    }
}
