//! Parameters of processes that are given as expressions.

use super::Validator;
use crate::diagnostic::{Diagnostic, alternatives};
use crate::node::{Key, Kind, Node};
use crate::recipe::Actor;
use eyot_rules::{Obstacle, Replaced, TermDefinition, Terms};
use serde_json::Value;
use std::sync::Arc;

/// The texts that stand for numbers of a process, and the table without them.
pub(super) fn apart(actor: &Actor, table: &Node) -> (Vec<(Key, Node)>, Node) {
    let Actor::Process(entry) = actor else { return (Vec::new(), table.clone()) };
    let schema = (entry.schema)().to_value();
    let is_term = |key: &Key, value: &Node| {
        value.text().is_some() && eyot_rules::numbers(&schema).any(|(name, _)| *name == key.name)
    };
    let Kind::Table(entries) = &table.kind else { return (Vec::new(), table.clone()) };
    let (texts, rest) = entries.iter().cloned().partition(|(key, value)| is_term(key, value));
    (texts, Node { span: table.span.clone(), kind: Kind::Table(rest) })
}

impl Validator<'_> {
    /// Checks the texts; nothing comes back if one of them is wrong.
    pub(super) fn terms(
        &mut self,
        actor: &Actor,
        parameters: &Value,
        texts: &[(Key, Node)],
        acts: bool,
    ) -> Option<Arc<Terms>> {
        let Actor::Process(entry) = actor else { return Some(Arc::default()) };
        let before = self.out.len();
        let schema = (entry.schema)().to_value();
        let plain = (entry.make)(parameters.clone()).ok()?;
        if let Some((key, value)) = texts.first().filter(|_| plain.action().is_some()) {
            let message = format!("`{}.{}` must be a number", entry.name, key.name);
            let help = format!("`{}` is more than rules of cells, so its parameters are no expressions", entry.name);
            self.out.push(Diagnostic::at(value.span.clone(), message, "an expression").help(help));
            return None;
        }
        let (scope, _) = self.scope();
        let mut list = Vec::new();
        for (key, value) in texts {
            let (unit, range) = eyot_rules::of_schema(&schema["properties"][&key.name]);
            let (process, parameter) = (entry.name.to_owned(), key.name.clone());
            let text = value.text().unwrap_or_default().to_owned();
            match eyot_rules::term(&TermDefinition { process, parameter, unit, range, text }, &scope) {
                Ok(term) => list.push(Arc::new(term)),
                Err(mistake) => {
                    let place = self.inside(value, &mistake);
                    let diagnostic = self.mistaken(place, &mistake);
                    self.out.push(diagnostic);
                }
            }
        }
        if self.out.len() > before {
            return None;
        }
        let terms = Terms::new(list);
        let Some(grid) = self.grid.filter(|_| acts && !texts.is_empty()) else { return Some(terms) };
        let replaced = Replaced::new(entry, parameters.clone(), Arc::clone(&terms)).ok()?;
        if let Some((parameter, obstacle)) = replaced.obstacle(&grid) {
            let place = texts.iter().find(|(k, _)| k.name == parameter).map(|(_, value)| value.span.clone());
            let message = format!("`{}.{parameter}` cannot differ from cell to cell: {obstacle}", entry.name);
            let possible = Replaced::possible(entry);
            let help = match (&obstacle, possible.is_empty()) {
                (Obstacle::Limit(_), _) => "read fewer layers, or compute a part of it in a [[rule]] before".to_owned(),
                (_, true) => "an expression of `steps` and `sea_level` alone works".to_owned(),
                (_, false) => {
                    let list = alternatives(possible.iter().map(String::as_str));
                    format!("an expression of `steps` and `sea_level` alone works; from cell to cell can differ {list}")
                }
            };
            self.out.push(Diagnostic::at(place.unwrap_or_default(), message, "here").help(help));
            return None;
        }
        for need in eyot_core::process::Process::needs(&replaced) {
            if !self.layers.iter().any(|l| l == need) {
                let place = texts.first().map(|(_, value)| value.span.clone()).unwrap_or_default();
                let problem = self.no_layer(need, place);
                self.out.push(problem);
            }
        }
        for (spec, _) in eyot_core::process::Process::layers(&replaced) {
            if !self.layers.iter().any(|l| *l == *spec.name) {
                self.layers.push(spec.name.into_owned());
            }
        }
        (self.out.len() == before).then_some(terms)
    }
}
