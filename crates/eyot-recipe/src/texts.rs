//! Text files that a recipe names, such as series of temperatures: read once, and kept with the run.

use crate::diagnostic::{Diagnostic, Problems, Source};
use crate::recipe::Actor;

/// Parameters of a process that name a text file: those whose schema says `file`.
pub(crate) fn parameters(actor: &Actor) -> Vec<String> {
    let schema = actor.schema();
    let named = schema["properties"].as_object().into_iter().flatten();
    named.filter(|(_, property)| property["file"] == "text").map(|(name, _)| name.clone()).collect()
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
