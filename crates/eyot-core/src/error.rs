//! Errors of the core and of everything that builds on it.

use crate::layer::known;
use crate::remedy;
use crate::remedy::{Remedy, Worded};
use std::time::Duration;

/// Result with the core's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong in the core. Rules themselves cannot fail.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The grid has no cells, or cells without a size.
    #[error("bad grid: {0}")]
    BadGrid(String),
    /// A request exceeds a limit; the text names the limit and how to raise it.
    #[error("too large: {what} needs {needed}, the limit is {limit} ({remedy})")]
    Limit {
        /// What was asked for.
        what: String,
        /// What it needs.
        needed: String,
        /// What is allowed.
        limit: String,
        /// How to raise the limit or shrink the request.
        remedy: Remedy,
    },
    /// A layer that is needed is not there.
    #[error("layer `{name}` is missing; this world has: {present}")]
    NoLayer {
        /// The missing layer.
        name: String,
        /// The layers that exist, comma separated.
        present: String,
    },
    /// A component of a world is not what it should be.
    #[error("component `{name}`: {reason}")]
    Component {
        /// Its name, or that of the part of it.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// A parameter has a value that the process or generator cannot work with.
    #[error("{owner}.{field}: {reason}")]
    BadParameter {
        /// Process or generator.
        owner: String,
        /// Parameter name.
        field: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A file that a generator or process is to read cannot be used.
    #[error("{owner}.{field}: {reason}")]
    BadFile {
        /// Process or generator.
        owner: String,
        /// The parameter that names the file.
        field: String,
        /// What is wrong with the file and what to do.
        reason: Remedy,
    },
    /// Sizes of two things that must agree do not.
    #[error("{what}: expected {expected} values, found {found}")]
    Shape {
        /// What was being filled or compared.
        what: String,
        /// Values that it needs.
        expected: usize,
        /// Values that were given.
        found: usize,
    },
    /// A value that is not a finite number turned up.
    #[error("layer `{layer}` holds {value} at column {x}, row {y} after {after}; the last checkpoint is sound")]
    NotFinite {
        /// The layer.
        layer: String,
        /// NaN or an infinity.
        value: f32,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The step or process after which it was found.
        after: String,
    },
    /// A step number or a level of the sea that no world can have.
    #[error("after step {step} the sea would stand at {sea_level_m:.1} m; a world goes up to step {}, with its sea from {} to {} m", crate::limits::MAX_STEP, known::HEIGHT.range.0, known::HEIGHT.range.1)]
    Clock {
        /// Steps done.
        step: u64,
        /// Level of the sea, m.
        sea_level_m: f64,
    },
    /// Something cannot be done on a part of a grid.
    #[error("a window of the grid: {0}")]
    Window(String),
    /// The caller asked to stop.
    #[error("stopped on request after {0:?}")]
    Cancelled(Duration),
}

impl From<Error> for Remedy {
    fn from(e: Error) -> Self {
        e.sentence()
    }
}

impl Worded for Error {
    fn sentence(&self) -> Remedy {
        match self {
            Self::Limit { what, needed, limit, remedy } => {
                remedy![format!("too large: {what} needs {needed}, the limit is {limit} ("), remedy.clone(), ")"]
            }
            Self::BadFile { owner, field, reason } => remedy![format!("{owner}.{field}: "), reason.clone()],
            other => other.to_string().into(),
        }
    }
}
