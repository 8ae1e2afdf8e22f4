//! What can go wrong with a run.

use eyot_core::engine::DeviceError;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting, Worded};
use eyot_recipe::Problems;
use std::path::{Path, PathBuf};

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
    /// What was asked for cannot be: an input that is not there or is something else, an output that makes no sense.
    #[error("{reason}")]
    Input {
        /// What is wrong, and where.
        reason: Remedy,
        /// What would be right, if that does not say it.
        help: Option<Remedy>,
    },
    /// The device that carries out plans or draws cannot be used.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A file could not be written.
    #[error("{0}")]
    File(Remedy),
    /// Values do not fit the file that they were to be exported to. Everything else is written.
    #[error("{0}")]
    Export(Remedy),
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
    /// The run in a folder cannot be continued from what it left.
    #[error("{reason}")]
    Checkpoint {
        /// The folder.
        folder: PathBuf,
        /// What is wrong with the file, by name.
        reason: Remedy,
    },
    /// A command of an earlier run does not fit the recipe.
    #[error("`{set}` cannot be given again in step {step}: {reason}")]
    Replay {
        /// The change.
        set: String,
        /// Number of the recipe's step.
        step: usize,
        /// Why not.
        reason: Remedy,
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

/// A path as a shell takes it as one word, for commands that people copy.
pub fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "_-./+=@%:,".contains(c);
    match text.starts_with('-') {
        // Not an option.
        true => shell_word(&Path::new(".").join(path)),
        false if !text.is_empty() && text.chars().all(plain) => text,
        // Quotes of Windows' shells; its paths hold none themselves.
        false if cfg!(windows) => format!("\"{text}\""),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

impl RunError {
    /// What was asked for is not there, and the message says all.
    pub fn input(reason: impl Into<Remedy>) -> Self {
        Self::Input { reason: reason.into(), help: None }
    }

    /// The same, with what would be right.
    pub fn refused(reason: impl Into<Remedy>, help: impl Into<Remedy>) -> Self {
        Self::Input { reason: reason.into(), help: Some(help.into()) }
    }

    /// True if nothing was begun, because what was asked for cannot be: the recipe, the input or the options are wrong. False
    /// if work failed, or something could not be written.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Recipe(_)
            | Self::Input { .. }
            | Self::Busy { .. }
            | Self::Unfinished { .. }
            | Self::NothingToResume { .. }
            | Self::Checkpoint { .. }
            | Self::Replay { .. }
            | Self::NotStreamed(_) => true,
            Self::Device(e) => e.refused,
            Self::Step { .. }
            | Self::File(_)
            | Self::Export(_)
            | Self::Folder { .. }
            | Self::Stopped
            | Self::Threads { .. }
            | Self::Fault(_) => false,
        }
    }

    /// Errors of files and pictures name the file and the remedy themselves.
    pub fn file(e: impl Into<Remedy>) -> Self {
        Self::File(e.into())
    }

    /// What to do about it.
    pub fn help(&self) -> Option<Remedy> {
        use eyot_core::Error as Core;
        Some(match self {
            Self::Input { help, .. } => return help.clone(),
            Self::Step { source: Core::NotFinite { .. }, .. } => {
                "if a rule of the recipe makes that layer, guard its divisions, roots and logarithms; if not, the parameters of this step \
                 are too strong for the grid: lower them, or report it if they are all within their ranges".into()
            }
            Self::Step { source: Core::Limit { remedy, .. }, .. } => remedy.clone(),
            Self::Step { source: Core::Clock { .. }, .. } => {
                "do fewer steps, or let the sea rise or fall less in each; the last checkpoint is sound".into()
            }
            Self::Step { source: Core::BadParameter { owner, .. } | Core::BadFile { owner, .. }, .. } => {
                remedy![Action::Describe(owner.clone()), " explains its parameters"]
            },
            Self::Device(_) => remedy![Action::Doctor, " says what can be used and why"],
            Self::Export(_) => {
                remedy![
                    "all other files are there; ",
                    Action::Convert,
                    " makes this one from the folder of the run, or change the export",
                ]
            }
            Self::Folder { .. } => remedy![
                "choose another folder with ",
                Setting::Out,
                ", or check its permissions and the space on its disk",
            ],
            Self::Busy { .. } => remedy!["wait for it, stop it, or choose another folder with ", Setting::Out],
            Self::Unfinished { folder } => {
                remedy![
                    "continue it with ",
                    Action::Resume(Some(folder.clone())),
                    ", start over with ",
                    Setting::Restart,
                    ", or choose another folder with ",
                    Setting::Out,
                ]
            }
            Self::NothingToResume { finished: true, folder } => {
                remedy![
                    "the run there is finished; look at it with ",
                    Action::Render(folder.clone()),
                    " or ",
                    Action::Stats(folder.clone()),
                ]
            }
            Self::NothingToResume { .. } => "give the folder that a stopped run was writing to".into(),
            Self::Checkpoint { folder, .. } => {
                remedy!["start over with ", Action::StartOver(folder.clone())]
            }
            Self::Replay { .. } => "give the run.json of a run of the same recipe, with the same steps switched on".into(),
            Self::NotStreamed(_) => remedy!["leave out ", Setting::Stream.to("always"), ", or switch off what stands in the way"],
            Self::Threads { .. } => remedy!["choose fewer with ", Setting::Threads],
            Self::Fault(_) => "this is a fault of Eyot: please report it with the recipe; the last checkpoint is sound".into(),
            _ => return None,
        })
    }
}

impl From<RunError> for Remedy {
    fn from(e: RunError) -> Self {
        e.sentence()
    }
}

impl Worded for RunError {
    fn sentence(&self) -> Remedy {
        match self {
            Self::Step { step, source } => remedy![format!("{step}: "), source.sentence()],
            Self::Input { reason: sentence, .. }
            | Self::Checkpoint { reason: sentence, .. }
            | Self::File(sentence)
            | Self::Export(sentence) => sentence.clone(),
            Self::Recipe(problems) => problems.sentence(),
            Self::Replay { set, step, reason } => {
                remedy![format!("`{set}` cannot be given again in step {step}: "), reason.clone()]
            }
            Self::Device(e) => e.sentence.clone(),
            other => other.to_string().into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn paths_are_one_word_of_a_shell() {
        let word = |p: &str| shell_word(Path::new(p));
        assert_eq!(word("out/a-1.b"), "out/a-1.b");
        assert_eq!(word("my island"), "'my island'");
        assert_eq!(word("it's; rm *"), r"'it'\''s; rm *'");
        assert_eq!(word("-out"), "./-out");
    }
}
