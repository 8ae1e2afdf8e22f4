//! Recipes and text files from folders of this machine.

use crate::builtin;
use crate::diagnostic::{Diagnostic, Problems, Source, nearest};
use crate::host::Refusal;
use crate::recipe::{Overrides, Recipe, RecipeSource};
use crate::registry::Registry;
use eyot_core::Limits;
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy};
use std::path::Path;

/// Longest text that a recipe may name, bytes: some centuries of days.
const MAX_TEXT_BYTES: u64 = 4 << 20;

impl Recipe {
    /// Reads and checks a recipe from a file.
    ///
    /// # Errors
    /// As [`Recipe::parse`], and if the file cannot be read.
    pub fn read(path: &Path, overrides: Overrides, registry: &Registry, limits: &Limits) -> Result<Self, Problems> {
        Self::parse(RecipeSource::read(path)?, overrides, registry, limits)
    }
}

impl RecipeSource {
    /// Reads a recipe's text from a file.
    ///
    /// # Errors
    /// If the file cannot be read, is not text, or is far too long for a recipe.
    pub fn read(path: &Path) -> Result<Self, Problems> {
        const MAX_BYTES: u64 = 4 << 20;
        let name = path.display().to_string();
        let fail = |message: String, help: Remedy| {
            let source = Source { name: name.clone(), text: String::new() };
            Problems::new(vec![source], vec![Diagnostic::whole(message).help(help)])
        };
        let known = builtin::RECIPES.iter().map(|r| r.name);
        let meta = std::fs::metadata(path).map_err(|e| {
            if let Some(there) = beside(path) {
                return fail(
                    format!("cannot read the recipe `{name}`: {e}"),
                    format!("did you mean `{there}`?").into(),
                );
            }
            let guess = path.file_stem().and_then(|s| s.to_str()).and_then(|s| nearest(s, known.clone()));
            let help = match guess {
                Some(n) => {
                    remedy![format!("did you mean the built-in recipe `{n}`? "), Action::List, " shows all of them",]
                }
                None => remedy!["give the name of a recipe file, or of a built-in recipe from ", Action::List],
            };
            fail(format!("cannot read the recipe `{name}`: {e}"), help)
        })?;
        if !meta.is_file() {
            return Err(fail(
                format!("`{name}` is not a file"),
                remedy!["give the name of a recipe file; ", Action::Resume(None), " takes a folder"],
            ));
        }
        if meta.len() > MAX_BYTES {
            let message = format!("`{name}` has {} bytes, which no recipe needs", meta.len());
            return Err(fail(message, "recipes are short TOML documents; is this the right file?".into()));
        }
        let bytes = std::fs::read(path)
            .map_err(|e| fail(format!("cannot read the recipe `{name}`: {e}"), "check its permissions".into()))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let message = format!("`{name}` is not text: byte {} is not UTF-8", e.utf8_error().valid_up_to());
            fail(message, "recipes are TOML documents in UTF-8; is this the right file?".into())
        })?;
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = std::path::absolute(parent).unwrap_or_else(|_| parent.to_owned());
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        Ok(Self { name, text, folder })
    }

    /// A built-in recipe if there is one of that name, else the file.
    ///
    /// # Errors
    /// As [`RecipeSource::read`].
    pub fn find(name: &str) -> Result<Self, Problems> {
        match Self::builtin(name) {
            Some(s) => Ok(s),
            None => Self::read(Path::new(name)),
        }
    }
}

/// The text of a file that a recipe in `folder` means, or a sentence about why there is none, and a remedy.
///
/// # Errors
/// If there is no such file, or it is no text, or longer than 4 MiB.
pub fn text(file: &str, folder: &Path) -> Result<String, Refusal> {
    let path = folder.join(file);
    let fail = |reason: &str, help: &str| {
        Err(Refusal::new(format!("cannot read `{}`: {reason}", path.display()), help.to_owned()))
    };
    let meta = match std::fs::metadata(&path) {
        Ok(meta) => meta,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            return fail("there is no such file", &name_help(file));
        }
        Err(e) => return fail(&e.to_string(), "check its name and its permissions"),
    };
    if !meta.is_file() {
        return fail("it is not a file", "give the name of a text file");
    }
    if meta.len() > MAX_TEXT_BYTES {
        let reason = format!("it has {} bytes, {MAX_TEXT_BYTES} are allowed", meta.len());
        return fail(&reason, "give the days that the run needs, or months instead of days");
    }
    let bytes = match std::fs::read(&path) {
        Ok(bytes) => bytes,
        Err(e) => return fail(&e.to_string(), "check its permissions"),
    };
    match String::from_utf8(bytes) {
        Ok(text) if text.trim().is_empty() => fail("it is empty", "give a line for each date"),
        Ok(text) => Ok(text),
        Err(e) => {
            let reason = format!("byte {} is not UTF-8", e.utf8_error().valid_up_to());
            fail(&reason, "save it as text in UTF-8")
        }
    }
}

/// What to do about a file that a recipe names and that is not there.
pub fn name_help(file: &str) -> String {
    if file.contains(char::is_control) {
        return "the name holds a control character: in double quotes a backslash begins an escape, so write / between folders"
            .to_owned();
    }
    if file.contains('\\') && !cfg!(windows) {
        return format!("folders are divided by /: write \"{}\"", file.replace('\\', "/"));
    }
    "file names are relative to the recipe's folder".to_owned()
}

/// The recipe file in the same folder whose name is most like that of one that is not there.
fn beside(path: &Path) -> Option<String> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let wanted = path.file_stem()?.to_str()?;
    let names = std::fs::read_dir(parent).ok()?.filter_map(|e| e.ok()?.file_name().into_string().ok());
    let mut stems: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(".toml")?.to_owned())).collect();
    stems.sort();
    let found = format!("{}.toml", nearest(wanted, stems.iter().map(String::as_str))?);
    Some(path.with_file_name(found).display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_short_text_is_refused_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        put("sea.csv", b"2001-01,27\n");
        put("none.csv", b" \n");
        put("picture.png", &[0x89, 0x50, 0xff]);
        put("long.csv", &vec![b'0'; MAX_TEXT_BYTES as usize + 1]);
        assert_eq!(text("sea.csv", folder.path()).unwrap(), "2001-01,27\n");
        for (name, words) in [
            ("sea.cvs", "no such file"),
            (".", "not a file"),
            ("none.csv", "empty"),
            ("picture.png", "UTF-8"),
            ("long.csv", "4194304 are allowed"),
        ] {
            let Refusal { message, help } = text(name, folder.path()).unwrap_err();
            assert!(
                message.to_string().contains(words)
                    && message.to_string().contains(name)
                    && !help.to_string().is_empty(),
                "{message}"
            );
        }
    }
}
