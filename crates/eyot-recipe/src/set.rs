//! `--set key=value`: changes to the parsed document, before it is checked.

use crate::diagnostic::{Diagnostic, Source, alternatives, nearest};
use crate::keys::View;
use crate::node::{Key, Kind, Node, Span};
use crate::registry::{DOCUMENT_KEYS, Registry};
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use serde_json::Value;

/// Applies one `key=value` text to the document. The text becomes a source of its own, so that what is wrong with it is
/// shown in it.
pub(crate) fn apply(
    doc: &mut Node,
    flag: &str,
    registry: &Registry,
    sources: &mut Vec<Source>,
    out: &mut Vec<Diagnostic>,
) {
    let index = sources.len();
    let (text, parsed) = parse(flag, index);
    sources.push(Source { name: Source::SET.to_owned(), text });
    let assignment = match parsed {
        Ok(node) => node,
        Err(problems) => return out.extend(problems),
    };
    for (key, value) in assignment.entries() {
        if let Err(problem) = place(doc, key, value, registry) {
            out.push(problem);
        }
    }
}

/// Reads `key=value`. A value that is a bare word is taken as a text: `--set grid.rim=open`.
pub(crate) fn parse(flag: &str, source: usize) -> (String, Result<Node, Vec<Diagnostic>>) {
    let whole = Span { source, start: 0, end: flag.len() };
    let Some((key, value)) = flag.split_once('=') else {
        let problem = Diagnostic::at(whole, format!("`{flag}` sets nothing"), "no `=` here").help(remedy![
            "write key=value, for example ",
            Setting::Set.to("hydraulic.rain=0.004"),
            ", ",
            Setting::Set.to("grid.size=256"),
            " or ",
            Setting::Set.to("step.2.enabled=false"),
        ]);
        return (flag.to_owned(), Err(vec![problem]));
    };
    match Node::parse(flag, source) {
        Ok(node) if !node.entries().is_empty() => (flag.to_owned(), Ok(node)),
        Ok(_) => {
            let problem = Diagnostic::at(whole, format!("`{flag}` sets nothing"), "here").help("write key=value");
            (flag.to_owned(), Err(vec![problem]))
        }
        Err(first) => {
            let value = value.trim();
            let bare = value.chars().next().is_some_and(|c| c.is_alphabetic() || "_./~".contains(c))
                && !value.contains(['"', '\'', '\n', '\\']);
            if bare {
                let quoted = format!("{}=\"{value}\"", key.trim());
                if let Ok(node) = Node::parse(&quoted, source) {
                    return (quoted, Ok(node));
                }
            }
            (flag.to_owned(), Err(first))
        }
    }
}

fn place(doc: &mut Node, key: &Key, value: &Node, registry: &Registry) -> Result<(), Diagnostic> {
    let name = key.name.as_str();
    if ["step", "export", "material", "layer", "rule"].contains(&name) {
        return into_element(doc, key, value);
    }
    if DOCUMENT_KEYS.contains(&name) {
        if name == "grid" {
            // A cell size given by hand replaces an extent in the recipe, and the other way round.
            if let Some(Node { kind: Kind::Table(grid), .. }) = entry_mut(doc, "grid") {
                let given = |k: &str| value.get(k).is_some();
                grid.retain(|(k, _)| !(given("cell") && k.name == "extent_m" || given("extent_m") && k.name == "cell"));
            }
        }
        return doc.put(key, value.clone());
    }
    if registry.process(name).is_some() || declares(doc, name) {
        let mut found = false;
        for step in steps_mut(doc) {
            if simulates(step, name) {
                step.put(key, value.clone())?;
                found = true;
            }
        }
        return if found { Ok(()) } else { Err(nobody(key, "simulates", doc)) };
    }
    if let Some(step) = steps_mut(doc).iter_mut().find(|s| s.get("name").and_then(Node::text) == Some(name)) {
        return into_table(step, &key.name, key, value);
    }
    if registry.generator(name).is_some() {
        let mut found = false;
        for step in steps_mut(doc).iter_mut().filter(|s| s.get("generate").and_then(Node::text) == Some(name)) {
            into_table(step, &key.name, key, value)?;
            found = true;
        }
        return if found { Ok(()) } else { Err(nobody(key, "generates with", doc)) };
    }
    let targets = targets(doc);
    let known = DOCUMENT_KEYS.iter().copied().chain(targets.iter().map(String::as_str));
    let help = match nearest(name, known) {
        Some(n) => format!("did you mean `{n}`?"),
        None => format!(
            "it starts with a key of the recipe ({}), `step.NUMBER`, or one of this recipe's steps and processes ({})",
            alternatives(["seed", "sea_level", "grid", "view"]),
            targets.join(", ")
        ),
    };
    Err(Diagnostic::at(key.span.clone(), format!("nothing in this recipe is called `{name}`"), "unknown name")
        .help(help))
}

/// `step.2.height=400`, `step.volcano.height=400`, `export.1.format="r32"`; counted from 1.
fn into_element(doc: &mut Node, key: &Key, value: &Node) -> Result<(), Diagnostic> {
    let Some(Node { kind: Kind::Array(items), .. }) = entry_mut(doc, &key.name) else {
        return Err(Diagnostic::at(
            key.span.clone(),
            format!("this recipe has no [[{}]]", key.name),
            "nothing to change",
        ));
    };
    let count = items.len();
    if !matches!(value.kind, Kind::Table(_)) {
        let help = format!("write {0}.NUMBER.key=value with a NUMBER from 1 to {count}", key.name);
        return Err(
            Diagnostic::at(key.span.clone(), format!("`{}` alone cannot be set", key.name), "which one?").help(help)
        );
    }
    for (which, change) in value.entries() {
        let by_number = which.name.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|n| *n < count);
        let by_name = || items.iter().position(|s| s.get("name").and_then(Node::text) == Some(which.name.as_str()));
        let Some(i) = by_number.or_else(by_name) else {
            let message = format!("this recipe has no {} `{}`", key.name, which.name);
            let help = format!("it has {count}, counted from 1; a step's `name` will do as well");
            return Err(Diagnostic::at(which.span.clone(), message, "not there").help(help));
        };
        into_table(&mut items[i], &format!("{}.{}", key.name, which.name), which, change)?;
    }
    Ok(())
}

/// Puts a table of values into a part of the document, which is called `path` from its top.
fn into_table(target: &mut Node, path: &str, key: &Key, value: &Node) -> Result<(), Diagnostic> {
    if !matches!(value.kind, Kind::Table(_)) {
        let help = format!("write {path}.parameter=value");
        return Err(
            Diagnostic::at(key.span.clone(), format!("`{path}` alone cannot be set"), "which parameter?").help(help)
        );
    }
    value.entries().iter().try_for_each(|(k, v)| target.put(k, v.clone()))
}

fn nobody(key: &Key, verb: &str, doc: &mut Node) -> Diagnostic {
    let targets = targets(doc).join(", ");
    Diagnostic::at(key.span.clone(), format!("no step of this recipe {verb} `{}`", key.name), "not in this recipe")
        .help(format!("this recipe has: {targets}"))
}

/// True if the recipe has a layer or rule of its own of that name.
fn declares(doc: &Node, name: &str) -> bool {
    let lists = ["layer", "rule"].into_iter().filter_map(|key| doc.get(key));
    lists.flat_map(Node::elements).any(|item| item.get("name").and_then(Node::text) == Some(name))
}

fn entry_mut<'a>(doc: &'a mut Node, name: &str) -> Option<&'a mut Node> {
    match &mut doc.kind {
        Kind::Table(t) => t.iter_mut().find(|(k, _)| k.name == name).map(|(_, v)| v),
        _ => None,
    }
}

fn steps_mut(doc: &mut Node) -> &mut [Node] {
    match entry_mut(doc, "step") {
        Some(Node { kind: Kind::Array(items), .. }) => items,
        _ => &mut [],
    }
}

fn simulates(step: &Node, name: &str) -> bool {
    step.get("simulate").is_some_and(|s| s.text() == Some(name) || s.elements().iter().any(|e| e.text() == Some(name)))
}

/// Names that `--set` may start with because of the recipe's steps.
fn targets(doc: &mut Node) -> Vec<String> {
    let mut names = Vec::new();
    for step in steps_mut(doc) {
        let single = [step.get("name"), step.get("generate"), step.get("simulate")];
        names.extend(single.into_iter().flatten().filter_map(Node::text).map(str::to_owned));
        names.extend(
            step.get("simulate").into_iter().flat_map(Node::elements).filter_map(Node::text).map(str::to_owned),
        );
    }
    names.sort();
    names.dedup();
    names
}

/// The value at a path of keys of a document after `key=value` changes, both unchecked; `None` if it has none. The path begins
/// with a key of the document: what processes and generators are called does not matter here.
pub fn value_of(text: &str, changes: &[&str], path: &[&str]) -> Option<Value> {
    let mut doc = Node::parse(text, 0).ok()?;
    let (mut sources, mut problems) = (Vec::new(), Vec::new());
    let nobody = Registry::new(&[], &[]);
    changes.iter().for_each(|change| apply(&mut doc, change, &nobody, &mut sources, &mut problems));
    path.iter().try_fold(&doc, |node, key| node.get(key)).map(Node::to_json)
}

/// The view of a run's recipe, a text, after the changes of a list of texts; the default one if it has none that can be read.
pub fn view_of(recipe: &Value, set: &Value) -> View {
    // What a run was begun with has passed its checks.
    let set: Vec<&str> = set.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let recipe = recipe.as_str().unwrap_or_default();
    value_of(recipe, &set, &["view"]).and_then(|view| serde_json::from_value(view).ok()).unwrap_or_default()
}
