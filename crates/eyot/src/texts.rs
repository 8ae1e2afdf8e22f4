//! Text files that a recipe names, such as series of temperatures: read once, and kept with the run.

use crate::diagnostic::{Diagnostic, Problems, Source};
use crate::recipe::Actor;
use std::collections::BTreeMap;
use std::path::Path;

/// Texts of files by the names that the recipe gives them.
///
/// Checkpoints carry them, so that a run that goes on, is set back or is run again has the same ones, whatever has become of the files.
pub(crate) type Texts = BTreeMap<String, String>;

/// Longest such text, bytes: some centuries of days.
const MOST_BYTES: u64 = 4 << 20;

/// Parameters of a process that name a text file: those whose schema says `file`.
pub(crate) fn parameters(actor: &Actor) -> Vec<String> {
    let schema = actor.schema();
    let named = schema["properties"].as_object().into_iter().flatten();
    named.filter(|(_, property)| property["file"] == "text").map(|(name, _)| name.clone()).collect()
}

/// The text of a file that a recipe in `folder` means, or a sentence about why there is none, and a remedy.
pub(crate) fn read(file: &str, folder: &Path) -> Result<String, (String, String)> {
    let path = folder.join(file);
    let fail = |reason: &str, help: &str| Err((format!("cannot read `{}`: {reason}", path.display()), help.to_owned()));
    let meta = match std::fs::metadata(&path) {
        Ok(meta) => meta,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            return fail("there is no such file", "file names are relative to the recipe's folder");
        }
        Err(e) => return fail(&e.to_string(), "check its name and its permissions"),
    };
    if !meta.is_file() {
        return fail("it is not a file", "give the name of a text file");
    }
    if meta.len() > MOST_BYTES {
        let reason = format!("it has {} bytes, {MOST_BYTES} are allowed", meta.len());
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

/// Fails for a change to a parameter that names a file: the run keeps the text with which it began.
pub(crate) fn settled(actor: &Actor, key: &str, flag: &str) -> Result<(), Problems> {
    if !parameters(actor).iter().any(|p| p == key) {
        return Ok(());
    }
    let message = format!("`{}.{key}` names a file, which a run reads only when it begins", actor.name());
    let source = Source { name: "set".to_owned(), text: flag.to_owned() };
    Err(Problems::new(vec![source], vec![Diagnostic::whole(message).help("start a new run with this change")]))
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
        put("long.csv", &vec![b'0'; MOST_BYTES as usize + 1]);
        assert_eq!(read("sea.csv", folder.path()).unwrap(), "2001-01,27\n");
        for (name, words) in [
            ("sea.cvs", "no such file"),
            (".", "not a file"),
            ("none.csv", "empty"),
            ("picture.png", "UTF-8"),
            ("long.csv", "4194304 are allowed"),
        ] {
            let (message, help) = read(name, folder.path()).unwrap_err();
            assert!(message.contains(words) && message.contains(name) && !help.is_empty(), "{message}");
        }
    }
}
