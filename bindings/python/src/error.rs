//! What goes wrong, as exceptions of the Python half: `eyot.EyotError` and `eyot.RecipeError`.

use eyot::remedy::{Action, Setting, Worded, Wording};
use eyot::{Problems, RunError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Settings as keyword arguments, actions as calls.
pub(crate) struct Python;

impl Wording for Python {
    fn setting(&self, setting: Setting) -> String {
        let key = match setting {
            // What a file leaves open stands in a recipe that imports it.
            Setting::InputRange => "low_m",
            Setting::InputRows => "first_row",
            Setting::InputSize => "columns_rows",
            Setting::InputType => "numbers",
            other => return format!("`{}=`", other.name()),
        };
        format!("`{key}` of the generator `import`")
    }

    fn form(&self, setting: Setting) -> String {
        self.setting(setting)
    }

    fn choice(&self, setting: Setting, value: &str) -> String {
        match setting {
            Setting::InputRange | Setting::InputRows | Setting::InputSize | Setting::InputType => self.setting(setting),
            _ => format!("`{}={value:?}`", setting.name()),
        }
    }

    fn action(&self, action: &Action) -> String {
        let call = match action {
            Action::Cite => "eyot.Recipe(...).cite()".to_owned(),
            Action::Describe(what) => format!("eyot.describe({what:?})"),
            Action::List => "eyot.recipes()".to_owned(),
            Action::Record | Action::RecordForm => "eyot.run(..., record=STEPS)".to_owned(),
            Action::Render(folder) => format!("eyot.open({:?}).eyot.render()", folder.display().to_string()),
            Action::Resume(None) => "eyot.Run.resume(FOLDER)".to_owned(),
            Action::Resume(Some(folder)) => format!("eyot.Run.resume({:?})", folder.display().to_string()),
            Action::Run => "eyot.run".to_owned(),
            Action::StartOver(folder) => {
                format!("eyot.run(RECIPE, out={:?}, restart=True)", folder.display().to_string())
            }
            Action::Stats(folder) => format!("eyot.open({:?}).eyot.stats()", folder.display().to_string()),
            Action::Doctor => return "the command `eyot doctor`".to_owned(),
            other => return eyot::remedy::Neutral.action(other),
        };
        format!("`{call}`")
    }
}

/// An `EyotError`.
pub(crate) fn raise(py: pyo3::Python<'_>, message: &str, help: Option<&str>) -> PyErr {
    make(py, "EyotError", message, help, None)
}

/// An `EyotError` about a fault of the program.
pub(crate) fn fault(py: pyo3::Python<'_>, what: &str) -> PyErr {
    let help = "this is a fault of Eyot: please report it with the recipe";
    raise(py, &format!("the work broke: {what}"), Some(help))
}

/// Anything with a sentence.
pub(crate) fn plain(py: pyo3::Python<'_>, e: &dyn Worded) -> PyErr {
    raise(py, &e.worded(&Python), None)
}

/// A `RecipeError` with all places and remedies.
pub(crate) fn recipe(py: pyo3::Python<'_>, problems: &Problems) -> PyErr {
    let list = || -> PyResult<Bound<'_, PyList>> {
        let list = PyList::empty(py);
        for d in &problems.diagnostics {
            let entry = PyDict::new(py);
            entry.set_item("message", d.message.worded(&Python))?;
            entry.set_item("help", d.help.as_ref().map(|h| h.worded(&Python)))?;
            let place = d.span.as_ref().and_then(|s| Some((s, problems.source(s)?)));
            entry.set_item("source", place.map(|(_, source)| source.name.clone()))?;
            let (line, column) = place.map(|(s, _)| problems.line_column(s)).unzip();
            entry.set_item("line", line)?;
            entry.set_item("column", column)?;
            entry.set_item("label", &d.label)?;
            list.append(entry)?;
        }
        Ok(list)
    };
    match list() {
        Ok(list) => make(py, "RecipeError", &problems.worded(&Python), None, Some(list)),
        Err(e) => e,
    }
}

/// An error of a run.
pub(crate) fn run(py: pyo3::Python<'_>, e: &RunError) -> PyErr {
    match e {
        RunError::Recipe(problems) => recipe(py, problems),
        other => {
            let help = other.help().map(|h| h.worded(&Python));
            raise(py, &other.worded(&Python), help.as_deref())
        }
    }
}

fn make(
    py: pyo3::Python<'_>,
    class: &str,
    message: &str,
    help: Option<&str>,
    problems: Option<Bound<'_, PyList>>,
) -> PyErr {
    let made = py.import("eyot._errors").and_then(|m| m.getattr(class)).and_then(|class| match problems {
        Some(problems) => class.call1((message, help, problems)),
        None => class.call1((message, help)),
    });
    made.map_or_else(|e| e, PyErr::from_value)
}
