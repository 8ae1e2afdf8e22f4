//! What to do about an error, as a value: words, and between them the settings and actions that a front end offers.
//!
//! A library does not know whether a memory limit is a flag, a keyword argument or a field of a form. It names the
//! [`Setting`], and each front end words it with a [`Wording`]. `Display` words it for users of the library.
//!
//! ```
//! use eyot_core::remedy::{Action, Setting, Wording};
//!
//! let remedy = eyot_core::remedy!["choose fewer cells, or raise the limit with ", Setting::MaxMemory];
//! assert_eq!(remedy.to_string(), "choose fewer cells, or raise the limit with `max_memory`");
//!
//! struct Flags;
//! impl Wording for Flags {
//!     fn setting(&self, setting: Setting) -> String {
//!         format!("--{}", setting.name().replace('_', "-"))
//!     }
//!     fn form(&self, setting: Setting) -> String {
//!         format!("{} VALUE", self.setting(setting))
//!     }
//!     fn choice(&self, setting: Setting, value: &str) -> String {
//!         format!("{} {value}", self.setting(setting))
//!     }
//!     fn action(&self, action: &Action) -> String {
//!         format!("{action:?}")
//!     }
//! }
//! assert_eq!(remedy.worded(&Flags), "choose fewer cells, or raise the limit with --max-memory");
//! ```

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

/// Something that a user may set, beside what stands in a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Setting {
    /// Name of the graphics adapter.
    Adapter,
    /// Order of the bytes of a bare raster that is written.
    ByteOrder,
    /// Size of a raster's cells.
    Cell,
    /// What a film's ground is covered with.
    Drape,
    /// The engine that computes.
    Engine,
    /// Whether files are overwritten that are not of a former run.
    Force,
    /// Pictures a second.
    Fps,
    /// Pictures of a film.
    Frames,
    /// What the whole numbers of an input stand for.
    InputRange,
    /// Which row of a bare input is the first.
    InputRows,
    /// Columns and rows of a bare input.
    InputSize,
    /// Kind of a bare input's numbers.
    InputType,
    /// The layer that is meant.
    Layer,
    /// Address that a server listens on.
    Listen,
    /// Bytes that a request may allocate.
    MaxMemory,
    /// The number that marks missing cells.
    Nodata,
    /// Output folder.
    Out,
    /// Way of a film's camera.
    Path,
    /// Target program of an export.
    Preset,
    /// Whether other machines may connect.
    Public,
    /// What the whole numbers of an output stand for.
    Range,
    /// Steps between recorded states.
    Record,
    /// Bytes that a recording may take.
    RecordLimit,
    /// The recording that is filmed.
    Recording,
    /// Whether what an output folder holds is thrown away.
    Restart,
    /// Order of the rows that are written.
    Rows,
    /// The run that is filmed.
    Run,
    /// A change of the recipe.
    Set,
    /// Cells or pixels of a side.
    Size,
    /// Whether a run works out of core.
    Stream,
    /// Threads that work.
    Threads,
    /// Tiles that a mesh is cut into.
    Tiles,
    /// Most vertices of a mesh.
    Vertices,
}

impl Setting {
    /// The name that options of the libraries give it: lower case with underscores.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Adapter => "adapter",
            Self::ByteOrder => "byte_order",
            Self::Cell => "cell",
            Self::Drape => "drape",
            Self::Engine => "engine",
            Self::Force => "force",
            Self::Fps => "fps",
            Self::Frames => "frames",
            Self::InputRange => "input_range",
            Self::InputRows => "input_rows",
            Self::InputSize => "input_size",
            Self::InputType => "input_type",
            Self::Layer => "layer",
            Self::Listen => "listen",
            Self::MaxMemory => "max_memory",
            Self::Nodata => "nodata",
            Self::Out => "out",
            Self::Path => "path",
            Self::Preset => "preset",
            Self::Public => "public",
            Self::Range => "range",
            Self::Record => "record",
            Self::RecordLimit => "record_limit",
            Self::Recording => "recording",
            Self::Restart => "restart",
            Self::Rows => "rows",
            Self::Run => "run",
            Self::Set => "set",
            Self::Size => "size",
            Self::Stream => "stream",
            Self::Threads => "threads",
            Self::Tiles => "tiles",
            Self::Vertices => "vertices",
        }
    }

    /// This setting with a value, to be worded as one: "the engine `cpu`".
    pub fn to(self, value: impl Into<Cow<'static, str>>) -> Part {
        Part::Choice(self, value.into())
    }

    /// This setting with the form of its value, where the front end shows one: `--from-size COLUMNSxROWS`.
    pub const fn form(self) -> Part {
        Part::Form(self)
    }
}

/// Something that a user may do. Each is worded as a noun: what it is, or what it shows.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Action {
    /// Reading what the benchmarks can be asked.
    BenchOptions,
    /// Citing what a recipe uses.
    Cite,
    /// Converting a file to another format.
    Convert,
    /// The same, named in passing.
    Converter,
    /// Reading the description of a process, generator or subject.
    Describe(String),
    /// Examining what this machine can use.
    Doctor,
    /// Listing recipes, generators and processes.
    List,
    /// Recording a run.
    Record,
    /// Recording a run, with the form of the request where the front end shows one.
    RecordForm,
    /// Drawing the run in a folder.
    Render(PathBuf),
    /// Resuming a stopped run, in a folder if it is known.
    Resume(Option<PathBuf>),
    /// Running a recipe.
    Run,
    /// Running a recipe anew in a folder, over what is there.
    StartOver(PathBuf),
    /// Statistics of the run in a folder.
    Stats(PathBuf),
    /// Listing what a recording holds.
    Timeline,
}

/// How a front end words settings and actions.
pub trait Wording {
    /// A setting.
    fn setting(&self, setting: Setting) -> String;
    /// A setting with the form of its value.
    fn form(&self, setting: Setting) -> String;
    /// A setting with a value.
    fn choice(&self, setting: Setting, value: &str) -> String;
    /// An action.
    fn action(&self, action: &Action) -> String;
}

/// For users of the libraries: settings by the names of options, actions by what they are.
#[derive(Clone, Copy, Debug)]
pub struct Neutral;

impl Wording for Neutral {
    fn setting(&self, setting: Setting) -> String {
        format!("`{}`", setting.name())
    }

    fn form(&self, setting: Setting) -> String {
        self.setting(setting)
    }

    fn choice(&self, setting: Setting, value: &str) -> String {
        match setting {
            Setting::Stream => format!("the streaming mode `{value}`"),
            Setting::Listen => format!("the address `{value}`"),
            _ => format!("the {} `{value}`", setting.name().replace('_', " ")),
        }
    }

    fn action(&self, action: &Action) -> String {
        match action {
            Action::BenchOptions => "the options of the benchmarks".to_owned(),
            Action::Cite => "the citations of the recipe".to_owned(),
            Action::Convert => "a conversion".to_owned(),
            Action::Converter => "the converter".to_owned(),
            Action::Describe(what) => format!("the description of `{what}`"),
            Action::Doctor => "the report on this machine".to_owned(),
            Action::List => "the list of what is built in".to_owned(),
            Action::Record | Action::RecordForm => "a run that sets `record`".to_owned(),
            Action::Render(_) => "a picture".to_owned(),
            Action::Resume(_) => "`resume`".to_owned(),
            Action::Run => "a run".to_owned(),
            Action::StartOver(_) => "a run that sets `restart`".to_owned(),
            Action::Stats(_) => "its statistics".to_owned(),
            Action::Timeline => "the timeline".to_owned(),
        }
    }
}

/// A piece of a [`Remedy`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Part {
    /// Plain words.
    Words(Cow<'static, str>),
    /// A setting.
    Setting(Setting),
    /// A setting with the form of its value.
    Form(Setting),
    /// A setting with a value.
    Choice(Setting, Cow<'static, str>),
    /// An action.
    Action(Action),
}

/// A sentence that says what to do, or what is wrong and what to do; made by [`remedy!`](crate::remedy!).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Remedy(Box<[Part]>);

impl Remedy {
    /// The sentence in the words of a front end.
    pub fn worded(&self, wording: &dyn Wording) -> String {
        let mut out = String::new();
        for part in &self.0 {
            match part {
                Part::Words(words) => out += words,
                Part::Setting(setting) => out += &wording.setting(*setting),
                Part::Form(setting) => out += &wording.form(*setting),
                Part::Choice(setting, value) => out += &wording.choice(*setting, value),
                Part::Action(action) => out += &wording.action(action),
            }
        }
        out
    }

    /// Sentences one after the other, with words between them.
    pub fn joined(all: impl IntoIterator<Item = Self>, between: &'static str) -> Self {
        let mut parts = Vec::new();
        for (i, one) in all.into_iter().enumerate() {
            parts.extend((i > 0).then(|| Part::Words(between.into())));
            parts.extend(one.0);
        }
        parts.into_iter().collect()
    }

    /// Its pieces.
    pub fn parts(&self) -> &[Part] {
        &self.0
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.worded(&Neutral))
    }
}

impl FromIterator<Part> for Remedy {
    fn from_iter<I: IntoIterator<Item = Part>>(parts: I) -> Self {
        Self(parts.into_iter().collect())
    }
}

impl From<Part> for Remedy {
    fn from(part: Part) -> Self {
        Self(Box::new([part]))
    }
}

impl From<&'static str> for Remedy {
    fn from(words: &'static str) -> Self {
        Part::Words(words.into()).into()
    }
}

impl From<String> for Remedy {
    fn from(words: String) -> Self {
        Part::Words(words.into()).into()
    }
}

impl From<Setting> for Remedy {
    fn from(setting: Setting) -> Self {
        Part::Setting(setting).into()
    }
}

impl From<Action> for Remedy {
    fn from(action: Action) -> Self {
        Part::Action(action).into()
    }
}

/// Written as the sentence that users of the library read.
impl serde::Serialize for Remedy {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// An error whose message may name settings and actions. Its `Display` words them for users of the library.
pub trait Worded {
    /// The whole message.
    fn sentence(&self) -> Remedy;

    /// The whole message in the words of a front end.
    fn worded(&self, wording: &dyn Wording) -> String {
        self.sentence().worded(wording)
    }
}

/// A [`Remedy`](crate::remedy::Remedy) of pieces in their order: words, settings, actions, and other remedies.
#[macro_export]
macro_rules! remedy {
    ($($piece:expr),+ $(,)?) => {
        [$($crate::remedy::Remedy::from($piece)),+]
            .iter()
            .flat_map(|r| r.parts().iter().cloned())
            .collect::<$crate::remedy::Remedy>()
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_read_well_without_a_front_end() {
        let engine = remedy!["choose a smaller grid or ", Setting::Engine.to("cpu")];
        assert_eq!(engine.to_string(), "choose a smaller grid or the engine `cpu`");
        let see = remedy![Action::Describe("thermal".into()), " explains its parameters"];
        assert_eq!(see.to_string(), "the description of `thermal` explains its parameters");
        let both = remedy![engine.clone(), "; ", see, String::from(".")];
        assert_eq!(
            both.to_string(),
            "choose a smaller grid or the engine `cpu`; the description of `thermal` explains its parameters."
        );
        assert_eq!(remedy!["say so with ", Setting::InputSize.form()].to_string(), "say so with `input_size`");
    }
}
