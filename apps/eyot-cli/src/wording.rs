//! Remedies as the command line words them: settings are flags, actions are commands.

use eyot::core::remedy::{Action, Setting, Wording};
use eyot::shell_word;

/// The wording of this program.
pub(crate) struct CommandLine;

impl Wording for CommandLine {
    fn setting(&self, setting: Setting) -> String {
        match setting {
            Setting::ByteOrder => "--bytes".to_owned(),
            Setting::InputRange => "--from-range".to_owned(),
            Setting::InputRows => "--from-rows".to_owned(),
            Setting::InputSize => "--from-size".to_owned(),
            Setting::InputType => "--from-type".to_owned(),
            other => format!("--{}", other.name().replace('_', "-")),
        }
    }

    fn form(&self, setting: Setting) -> String {
        let value = match setting {
            Setting::InputRange => "LOW,HIGH",
            Setting::InputSize => "COLUMNSxROWS",
            Setting::Layer => "NAME",
            _ => return self.setting(setting),
        };
        self.choice(setting, value)
    }

    fn choice(&self, setting: Setting, value: &str) -> String {
        format!("{} {value}", self.setting(setting))
    }

    fn action(&self, action: &Action) -> String {
        let command = match action {
            // Said in passing, within brackets or a sentence.
            Action::Converter => return "eyot convert".to_owned(),
            Action::BenchOptions => "bench --help".to_owned(),
            Action::Cite => "cite RECIPE".to_owned(),
            Action::Convert => "convert".to_owned(),
            Action::Describe(what) => format!("describe {what}"),
            Action::Doctor => "doctor".to_owned(),
            Action::List => "list".to_owned(),
            Action::Record => "run --record".to_owned(),
            Action::RecordForm => "run RECIPE --record STEPS".to_owned(),
            Action::Render(folder) => format!("render {}", shell_word(folder)),
            Action::Resume(None) => "resume".to_owned(),
            Action::Resume(Some(folder)) => format!("resume {}", shell_word(folder)),
            Action::Run => "run".to_owned(),
            Action::StartOver(folder) => format!("run RECIPE --out {} --restart", shell_word(folder)),
            Action::Stats(folder) => format!("stats {}", shell_word(folder)),
            Action::Timeline => "timeline".to_owned(),
            other => return eyot::core::remedy::Neutral.action(other),
        };
        format!("`eyot {command}`")
    }
}
