//! Errors of reading and writing files: which file, what is wrong, what to do.

use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting, Worded};
use std::io;
use std::path::{Path, PathBuf};

/// Result with the file formats' [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused to read or write.
    #[error("cannot {action} `{}`: {source}{}", path.display(), remedy_for(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was being done, as a verb.
        action: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// The content, or the request, does not fit the format.
    #[error("`{}`: {problem}; {remedy}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
        /// What to do about it.
        remedy: Remedy,
    },
    /// A cell holds a number that is not finite.
    #[error("`{}`: the value at column {x}, row {y} is {value}; {remedy}", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// NaN or an infinity.
        value: f32,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// What to do about it.
        remedy: Remedy,
    },
    /// The content exceeds a limit or makes no sound grid or layer.
    #[error("`{}`: {source}", path.display())]
    Core {
        /// The file.
        path: PathBuf,
        /// What the core found.
        source: eyot_core::Error,
    },
}

impl Error {
    /// The file that the error is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::Io { path, .. }
            | Self::Format { path, .. }
            | Self::NotFinite { path, .. }
            | Self::Core { path, .. } => path,
        }
    }

    /// The same error of a file that was to be moved from below `from` to the same place below `to`.
    pub(crate) fn moved(mut self, from: &Path, to: &Path) -> Self {
        let (Self::Io { path, .. }
        | Self::Format { path, .. }
        | Self::NotFinite { path, .. }
        | Self::Core { path, .. }) = &mut self;
        if let Ok(rest) = path.strip_prefix(from) {
            *path = if rest.as_os_str().is_empty() { to.to_owned() } else { to.join(rest) };
        }
        self
    }

    pub(crate) fn format(path: &Path, problem: impl Into<String>, remedy: impl Into<Remedy>) -> Self {
        Self::Format { path: path.to_owned(), problem: problem.into(), remedy: remedy.into() }
    }

    /// For `map_err` on operations of the system.
    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), action, source }
    }

    /// For `map_err` on limits that the content of a file exceeds.
    pub(crate) fn beyond(path: &Path) -> impl FnOnce(eyot_core::Error) -> Self {
        use eyot_core::Error::Limit;
        move |e| {
            Self::core(path)(match e {
                Limit { what, needed, limit, .. } => Limit {
                    what,
                    needed,
                    limit,
                    remedy: remedy![
                        "is the file damaged? If not, make it smaller with another program, or raise the limit with ",
                        Setting::MaxMemory,
                    ],
                },
                other => other,
            })
        }
    }

    /// For `map_err` on checks of the core.
    pub(crate) fn core(path: &Path) -> impl FnOnce(eyot_core::Error) -> Self {
        move |source| Self::Core { path: path.to_owned(), source }
    }
}

impl From<Error> for Remedy {
    fn from(e: Error) -> Self {
        e.sentence()
    }
}

impl Worded for Error {
    fn sentence(&self) -> Remedy {
        match self {
            Self::Io { .. } => self.to_string().into(),
            Self::Format { path, problem, remedy } => {
                remedy![format!("`{}`: {problem}; ", path.display()), remedy.clone()]
            }
            Self::NotFinite { path, value, x, y, remedy } => {
                let problem = format!("the value at column {x}, row {y} is {value}");
                remedy![format!("`{}`: {problem}; ", path.display()), remedy.clone()]
            }
            Self::Core { path, source } => remedy![format!("`{}`: ", path.display()), source.sentence()],
        }
    }
}

/// The first thing to try for a refusal of the system.
fn remedy_for(e: &io::Error) -> &'static str {
    use io::ErrorKind as K;
    match e.kind() {
        K::NotFound => "; check the name, and make its folder first",
        K::PermissionDenied | K::ReadOnlyFilesystem => {
            "; choose a place that you may write to, or change its permissions"
        }
        K::StorageFull | K::QuotaExceeded => "; make room on the disk or write elsewhere; the former file is unharmed",
        K::FileTooLarge => "; the file system or a limit (ulimit -f) refuses files of this size: write elsewhere",
        K::NotADirectory => "; check the name: a part of it is a file, not a folder",
        K::IsADirectory => "; give the name of a file in it",
        // Loops have no kind of their own in stable Rust.
        _ if e.to_string().contains("symbolic link") => "; the link leads to itself: give the file that it is to name",
        _ => "; check the file and the disk that it is on",
    }
}
