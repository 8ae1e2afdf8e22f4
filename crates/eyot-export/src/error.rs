//! What can go wrong with files and pictures.

use eyot_core::Remedy;
use std::path::PathBuf;

/// An error of an export, a conversion or a picture. The message names the file, and the remedy where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// What was asked for cannot be: an input that is not there or is something else, an output that makes no sense.
    #[error("{reason}")]
    Input {
        /// What is wrong, and where.
        reason: Remedy,
        /// What would be right, if that does not say it.
        help: Option<Remedy>,
    },
    /// A file or a picture could not be made.
    #[error("{0}")]
    File(Remedy),
    /// Values do not fit the format.
    #[error("{0}")]
    Values(Remedy),
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
    pub(crate) fn input(reason: impl Into<Remedy>) -> Self {
        Self::Input { reason: reason.into(), help: None }
    }

    pub(crate) fn file(reason: impl Into<Remedy>) -> Self {
        Self::File(reason.into())
    }

    pub(crate) fn refused(reason: impl Into<Remedy>, help: impl Into<Remedy>) -> Self {
        Self::Input { reason: reason.into(), help: Some(help.into()) }
    }

    /// Of work that can be stopped.
    pub fn stopped(e: eyot_core::Error) -> Self {
        if matches!(e, eyot_core::Error::Cancelled(_)) { Self::Stopped } else { Self::file(e) }
    }
}

impl From<ExportError> for Remedy {
    fn from(e: ExportError) -> Self {
        match e {
            ExportError::Input { reason: sentence, .. }
            | ExportError::File(sentence)
            | ExportError::Values(sentence) => sentence,
            other => other.to_string().into(),
        }
    }
}
