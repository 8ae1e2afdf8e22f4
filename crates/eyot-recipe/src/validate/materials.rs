//! The `[[material]]` tables: rock of the recipe's own, for every step that has beds.

use super::Validator;
use crate::diagnostic::{Diagnostic, alternatives, nearest};
use crate::keys;
use crate::node::{Key, Kind, Node, Span};
use crate::rock::STRATA;
use eyot_core::process::LIKE;
use eyot_core::remedy;
use eyot_core::remedy::Action;

/// What a material that is like no other has to say of itself.
const NEEDED: [&str; 3] = ["talus", "erodibility", "density"];
/// Where a process has its materials.
const MATERIALS: &str = "materials";

impl Validator<'_> {
    /// Checks the tables and puts them into `strata.materials` of every step that simulates that process, below what the step
    /// itself says of its materials. The document has them no longer then; each value keeps its place for messages.
    pub(super) fn materials(&mut self, doc: &mut Node) {
        let Kind::Table(entries) = &mut doc.kind else { return };
        let Some(at) = entries.iter().position(|(k, _)| k.name == "material") else { return };
        let (key, node) = entries.remove(at);
        let Kind::Array(items) = &node.kind else {
            let message = format!("`material` must be a list of tables, not {}", node.describe());
            let help = "write [[material]] with two brackets on each side";
            self.out.push(Diagnostic::at(node.span.clone(), message, "here").help(help));
            return;
        };
        let usual: Vec<String> = self.registry.process(STRATA).map(|e| names(&(e.defaults)())).unwrap_or_default();
        let mut all: Vec<(String, Node)> = Vec::new();
        for item in items {
            if let Some(made) = self.material(item, &usual, &all) {
                all.push(made);
            }
        }
        let mut used = false;
        for step in doc.get_mut("step").and_then(Node::elements_mut).into_iter().flatten() {
            let named = step.get("simulate").is_some_and(|s| s.text() == Some(STRATA) || lists(s));
            if named {
                used = true;
                into_step(step, &key.span, &all);
            }
        }
        if !used && self.out.is_empty() {
            let message = format!("no step simulates `{STRATA}`, which makes beds of materials");
            let help = remedy![
                format!("add \"{STRATA}\" to `simulate` of a step, and its beds; "),
                Action::Describe(STRATA.to_owned()),
                " says how",
            ];
            self.out.push(Diagnostic::at(key.span, message, "never used").help(help));
        }
    }

    /// Name and values of one of them; `None` if it has no name. One that is wrong is like the first of the usual ones, so that the
    /// beds are not blamed for it.
    fn material(&mut self, item: &Node, usual: &[String], former: &[(String, Node)]) -> Option<(String, Node)> {
        let before = self.out.len();
        let keys: keys::Material = self.keys_of(item, "material", &[]);
        let name = item.get("name").and_then(Node::text).unwrap_or_default().to_owned();
        let place = |key: &str| item.get(key).map_or_else(|| item.span.clone(), |n| n.span.clone());
        if self.out.len() == before && name.is_empty() {
            let message = "a material has no name";
            let help = "add name = \"NAME\", by which beds call it";
            self.out.push(Diagnostic::at(place("name"), message, "which one?").help(help));
        }
        if former.iter().any(|(n, _)| *n == name) {
            let message = format!("two materials are named \"{name}\"");
            let help = "give each a name of its own; one table says everything about a material";
            self.out.push(Diagnostic::at(place("name"), message, "used before").help(help));
            return None;
        }
        let made = former.iter().find(|(n, _)| Some(n) == keys.like.as_ref()).map(|(_, node)| node);
        if let Some(like) = keys.like.as_ref().filter(|l| made.is_none() && !usual.contains(l)) {
            let known: Vec<&str> = usual.iter().chain(former.iter().map(|(n, _)| n)).map(String::as_str).collect();
            let help = match nearest(like, known.iter().copied()) {
                Some(n) => format!("did you mean \"{n}\"?"),
                None => format!("it may be {}", alternatives(known)),
            };
            let message = format!("the material \"{name}\" is like `{like}`, which there is not");
            self.out.push(Diagnostic::at(place(LIKE), message, "unknown material").help(help));
        }
        if self.out.len() == before && keys.like.is_none() && !usual.contains(&name) {
            let missing: Vec<&str> = NEEDED.into_iter().filter(|key| item.get(key).is_none()).collect();
            if !missing.is_empty() {
                let message = format!("the material \"{name}\" is new and lacks {}", words(&missing));
                let known = usual.iter().map(String::as_str);
                let help = format!(
                    "add that, or say whose values it takes: {LIKE} = \"NAME\", one of {}",
                    alternatives(known)
                );
                self.out.push(Diagnostic::at(item.span.clone(), message, "not all is known").help(help));
            }
        }
        let sound = self.out.len() == before;
        if name.is_empty() {
            return None;
        }
        // What a material made before gives, then its own.
        let mut values: Vec<(Key, Node)> = made.map(|n| n.entries().to_vec()).unwrap_or_default();
        for (key, value) in item.entries().iter().filter(|(k, _)| sound && k.name != "name") {
            if key.name == LIKE && made.is_some() {
                continue;
            }
            values.retain(|(k, _)| k.name != key.name);
            values.push((key.clone(), value.clone()));
        }
        if !usual.contains(&name) && !values.iter().any(|(k, _)| k.name == LIKE) {
            // It says everything, and the form in which steps have materials wants a pattern all the same.
            let pattern = usual.first().cloned().unwrap_or_default();
            values.push(text(LIKE, &item.span, pattern));
        }
        Some((name, Node { span: item.span.clone(), kind: Kind::Table(values) }))
    }
}

/// Puts materials below those that a step has.
fn into_step(step: &mut Node, span: &Span, all: &[(String, Node)]) {
    let key = |name: &str| Key { span: span.clone(), name: name.to_owned() };
    let table = || Node { span: span.clone(), kind: Kind::Table(Vec::new()) };
    let Some(strata) = step.entry(key(STRATA), table) else { return };
    let Some(materials) = strata.entry(key(MATERIALS), table) else { return };
    let own = std::mem::replace(&mut materials.kind, Kind::Table(Vec::new()));
    match own {
        Kind::Table(own) => {
            let mut united: Vec<(Key, Node)> = all
                .iter()
                .map(|(name, node)| (Key { span: node.span.clone(), name: name.clone() }, node.clone()))
                .collect();
            for (name, value) in own {
                match united.iter_mut().find(|(k, _)| k.name == name.name) {
                    Some((_, Node { kind: Kind::Table(values), .. })) => {
                        values.retain(|(k, _)| value.get(&k.name).is_none());
                        values.extend(value.entries().iter().cloned());
                    }
                    _ => united.push((name, value)),
                }
            }
            materials.kind = Kind::Table(united);
        }
        Kind::Array(mut own) => {
            for (name, node) in all {
                if own.iter().any(|e| e.get("name").and_then(Node::text) == Some(name)) {
                    continue;
                }
                let mut values = node.entries().to_vec();
                values.push(text("name", &node.span, name.clone()));
                own.push(Node { span: node.span.clone(), kind: Kind::Table(values) });
            }
            materials.kind = Kind::Array(own);
        }
        // Its check will say what is wrong with it.
        other => materials.kind = other,
    }
}

fn text(key: &str, span: &Span, value: String) -> (Key, Node) {
    (Key { span: span.clone(), name: key.to_owned() }, Node { span: span.clone(), kind: Kind::Text(value) })
}

fn lists(simulate: &Node) -> bool {
    simulate.elements().iter().any(|e| e.text() == Some(STRATA))
}

/// Names of the materials that the process has by itself.
fn names(defaults: &serde_json::Value) -> Vec<String> {
    let list = defaults[MATERIALS].as_array();
    list.into_iter().flatten().filter_map(|m| m["name"].as_str()).map(str::to_owned).collect()
}

/// `a`, `a` and `b`, ...
fn words(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
        None => String::new(),
    }
}
