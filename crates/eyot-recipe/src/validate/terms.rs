//! Parameters of processes that are given as expressions, in recipes and while a run is at work.

use super::Validator;
use crate::diagnostic::{Diagnostic, alternatives};
use crate::node::{Key, Kind, Node};
use crate::recipe::Actor;
use eyot_core::Grid;
use eyot_core::process::{Entry, Process};
use eyot_expr::{Obstacle, ParameterizedProcess, ParseError, Scope, Term, TermDefinition, Terms};
use serde_json::Value;
use std::sync::Arc;

/// The texts that stand for numbers of a process, and the table without them.
pub(crate) fn apart(actor: &Actor, table: &Node) -> (Vec<(Key, Node)>, Node) {
    let Actor::Process(entry) = actor else { return (Vec::new(), table.clone()) };
    let schema = (entry.schema)().to_value();
    let is_term = |key: &Key, value: &Node| {
        value.text().is_some() && eyot_expr::numbers(&schema).any(|(name, _)| *name == key.name)
    };
    let Kind::Table(entries) = &table.kind else { return (Vec::new(), table.clone()) };
    let (texts, rest) = entries.iter().cloned().partition(|(key, value)| is_term(key, value));
    (texts, Node { span: table.span.clone(), kind: Kind::Table(rest) })
}

/// Checks texts for parameters of a process beside those that are expressions already, `kept`. On a grid it is found out, too,
/// whether they may differ from cell to cell. `say` shows a mistake in a text.
pub(crate) fn check(
    entry: &'static Entry<dyn Process>,
    parameters: &Value,
    texts: &[(Key, Node)],
    kept: impl IntoIterator<Item = Arc<Term>>,
    scope: &Scope,
    grid: Option<&Grid>,
    say: &dyn Fn(&Node, &ParseError) -> Diagnostic,
) -> Result<Arc<Terms>, Vec<Diagnostic>> {
    let mut list: Vec<Arc<Term>> = kept.into_iter().collect();
    let Some((_, first)) = texts.first() else { return Ok(Terms::new(list)) };
    let unfit = |e: serde_json::Error| vec![Diagnostic::at(first.span.clone(), e.to_string(), "here")];
    let plain = (entry.make)(parameters.clone()).map_err(unfit)?;
    if plain.action().is_some() {
        let message = format!("`{}.{}` must be a number", entry.name, texts[0].0.name);
        let help = format!("`{}` is more than rules of cells, so its parameters are no expressions", entry.name);
        return Err(vec![Diagnostic::at(first.span.clone(), message, "an expression").help(help)]);
    }
    let schema = (entry.schema)().to_value();
    let mut out = Vec::new();
    for (key, value) in texts {
        let (unit, range) = eyot_expr::of_schema(&schema["properties"][&key.name]);
        let (process, parameter) = (entry.name.to_owned(), key.name.clone());
        let text = value.text().unwrap_or_default().to_owned();
        match eyot_expr::term(&TermDefinition { process, parameter, unit, range, text }, scope) {
            Ok(term) => list.push(Arc::new(term)),
            Err(mistake) => out.push(say(value, &mistake)),
        }
    }
    if !out.is_empty() {
        return Err(out);
    }
    let terms = Terms::new(list);
    let Some(grid) = grid else { return Ok(terms) };
    let replaced = ParameterizedProcess::new(entry, parameters.clone(), Arc::clone(&terms)).map_err(unfit)?;
    let Some((parameter, obstacle)) = replaced.obstacle(grid) else { return Ok(terms) };
    let place = texts.iter().find(|(k, _)| k.name == parameter).map_or(first, |(_, value)| value);
    let message = format!("`{}.{parameter}` cannot differ from cell to cell: {obstacle}", entry.name);
    let possible = ParameterizedProcess::possible(entry);
    let help = match (&obstacle, possible.is_empty()) {
        (Obstacle::Limit(_), _) => "read fewer layers, or compute a part of it in a [[rule]] before".to_owned(),
        (_, true) => "an expression of `steps` and `sea_level` alone works".to_owned(),
        (_, false) => {
            let list = alternatives(possible.iter().map(String::as_str));
            format!("an expression of `steps` and `sea_level` alone works; from cell to cell can differ {list}")
        }
    };
    Err(vec![Diagnostic::at(place.span.clone(), message, "here").help(help)])
}

impl Validator<'_> {
    /// Checks the texts; nothing comes back if one of them is wrong.
    pub(super) fn terms(
        &mut self,
        actor: &Actor,
        parameters: &Value,
        texts: &[(Key, Node)],
        scope: &Scope,
        acts: bool,
    ) -> Option<Arc<Terms>> {
        let Actor::Process(entry) = actor else { return Some(Arc::default()) };
        let before = self.out.len();
        let grid = self.grid.filter(|_| acts);
        let say = |node: &Node, mistake: &ParseError| self.mistaken(self.inside(node, mistake), mistake);
        let terms = match check(entry, parameters, texts, [], scope, grid.as_ref(), &say) {
            Ok(terms) => terms,
            Err(problems) => {
                self.out.extend(problems);
                return None;
            }
        };
        if grid.is_none() || texts.is_empty() {
            return Some(terms);
        }
        let replaced = ParameterizedProcess::new(entry, parameters.clone(), Arc::clone(&terms)).ok()?;
        for need in Process::needs(&replaced) {
            if !self.layers.iter().any(|l| l == need) {
                let place = texts.first().map(|(_, value)| value.span.clone()).unwrap_or_default();
                let problem = self.no_layer(need, place);
                self.out.push(problem);
            }
        }
        for spec in Process::layers(&replaced).into_iter().map(|l| l.spec) {
            if !self.layers.iter().any(|l| *l == *spec.name) {
                self.layers.push(spec.name.into_owned());
            }
        }
        (self.out.len() == before).then_some(terms)
    }
}
