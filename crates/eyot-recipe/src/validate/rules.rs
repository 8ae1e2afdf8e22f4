//! The `[[layer]]` and `[[rule]]` tables: the recipe's own layers and rules, and mistakes in their texts to the character.

use super::Validator;
use crate::check;
use crate::diagnostic::{Diagnostic, Source, alternatives, nearest};
use crate::keys::{self, Amount};
use crate::layers;
use crate::node::{Kind, Node, Span};
use crate::registry::{DOCUMENT_KEYS, Registry, SCHEDULE_KEYS, SIMULATE_KEYS};
use eyot_core::LayerSpec;
use eyot_core::process::{Parameters, schema_of};
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy};
use eyot_rules::{
    DeclaredLayer, Known, LayerDefinition, Mistake, Part, Problem, RuleDefinition, Scope, TextRule, functions,
};
use serde_json::json;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Most of the recipe's own layers and rules together.
const MOST: usize = 64;

/// A layer or rule of the recipe's own.
pub(super) struct Own {
    pub(super) name: String,
    pub(super) every: u64,
    pub(super) parameters: Vec<(String, f32)>,
    what: What,
    node: Node,
    /// A step names it.
    listed: bool,
}

enum What {
    Layer(Box<LayerDefinition>, Option<String>, Option<String>),
    Rule(BTreeMap<String, String>, Option<String>),
}

impl Validator<'_> {
    /// Reads the tables; their texts are looked at where a step names them, for then it is known which layers there are.
    pub(super) fn declare(&mut self, doc: &Node) {
        for key in ["layer", "rule"] {
            let Some(node) = doc.get(key) else { continue };
            let Kind::Array(items) = &node.kind else {
                let message = format!("`{key}` must be a list of tables, not {}", node.describe());
                let help = format!("write [[{key}]] with two brackets on each side");
                self.out.push(Diagnostic::at(node.span.clone(), message, "here").help(help));
                continue;
            };
            for item in items {
                if self.own.len() == MOST {
                    let message = format!("a recipe has at most {MOST} layers and rules of its own");
                    self.out.push(Diagnostic::at(item.span.clone(), message, "one too many"));
                    return;
                }
                let own = if key == "layer" { self.own_layer(item) } else { self.own_rule(item) };
                self.own.extend(own);
            }
        }
    }

    fn own_layer(&mut self, item: &Node) -> Option<Own> {
        let keys: keys::Layer = self.own_keys("layer", item)?;
        let name = self.own_name("layer", &keys.name, item)?;
        let parameters = self.parameters(&keys.parameters, item)?;
        let place = |key: &str| item.get(key).map_or_else(|| item.span.clone(), |n| n.span.clone());
        let range = match keys.range {
            Some([low, high]) if low >= high => {
                let message = format!("`range` goes from {low} to {high}");
                self.out
                    .push(Diagnostic::at(place("range"), message, "this range").help("give the lower number first"));
                return None;
            }
            Some([low, high]) => (low as f32, high as f32),
            None => (f32::MIN, f32::MAX),
        };
        let start = match &keys.start {
            Amount::Text(text) => text.clone(),
            Amount::Number(n) if (*n as f32) < range.0 || (*n as f32) > range.1 => {
                let message = format!("the start value {n} is outside the range");
                let help = format!("`range` is {} to {}", range.0, range.1);
                self.out.push(Diagnostic::at(place("start"), message, "out of range").help(help));
                return None;
            }
            Amount::Number(n) => check::number(*n),
        };
        if let (Some(unit), Some(node)) = (&keys.unit, item.get("unit"))
            && let Err(mistake) = eyot_rules::check_unit(unit)
        {
            let diagnostic = self.mistaken(self.inside(node, &mistake), &mistake);
            self.out.push(diagnostic);
            return None;
        }
        if keys.next.is_none() && keys.mask.is_some() {
            let help = "add `next`, or leave out the mask";
            self.out.push(Diagnostic::at(place("mask"), "there is no rule to mask", "no `next`").help(help));
        }
        let spec = LayerSpec {
            name: Cow::Owned(name.clone()),
            unit: Cow::Owned(keys.unit.clone().unwrap_or_else(|| "1".to_owned())),
            meaning: Cow::Owned(keys.about.unwrap_or_else(|| "A layer of the recipe's own".to_owned())),
            range,
            ..LayerSpec::new("", "1", "", range)
        };
        let definition = LayerDefinition { spec, measured: keys.unit.is_some(), start, parameters: parameters.clone() };
        let what = What::Layer(Box::new(definition), keys.next, keys.mask);
        Some(Own { name, every: keys.every, parameters, what, node: item.clone(), listed: false })
    }

    fn own_rule(&mut self, item: &Node) -> Option<Own> {
        let keys: keys::Rule = self.own_keys("rule", item)?;
        let name = self.own_name("rule", &keys.name, item)?;
        let parameters = self.parameters(&keys.parameters, item)?;
        if keys.set.is_empty() {
            let help = "add set.LAYER = \"expression\", for example set.water = \"0.99 * water\"";
            self.out
                .push(Diagnostic::at(item.span.clone(), format!("the rule `{name}` sets nothing"), "here").help(help));
            return None;
        }
        let what = What::Rule(keys.set, keys.mask);
        Some(Own { name, every: keys.every, parameters, what, node: item.clone(), listed: false })
    }

    /// The keys of a table, if they are sound.
    fn own_keys<T: Parameters>(&mut self, owner: &str, item: &Node) -> Option<T> {
        let before = self.out.len();
        let has = schema_of::<T>().to_value();
        for (key, wanted) in [("set", "string"), ("parameters", "number")] {
            let Some(table) = item.get(key).filter(|_| has["properties"][key].is_object()) else { continue };
            let entries = table.entries().iter();
            let properties = entries.map(|(k, _)| (k.name.clone(), json!({ "type": wanted, "format": "float" })));
            let schema = json!({ "properties": properties.collect::<serde_json::Map<_, _>>() });
            check::table(&schema, table, &format!("{owner}.{key}"), &[], &mut self.out);
        }
        if self.out.len() > before {
            return None;
        }
        let keys = self.keys_of::<T>(item, owner, &[]);
        (self.out.len() == before).then_some(keys)
    }

    fn own_name(&mut self, kind: &str, name: &str, item: &Node) -> Option<String> {
        let span = item.get("name").map_or_else(|| item.span.clone(), |n| n.span.clone());
        let mut fail = |message: String, help: Remedy| {
            self.out.push(Diagnostic::at(span.clone(), message, "this name").help(help));
            None
        };
        if !LayerSpec::is_name(name) {
            let help = "use lower-case letters, digits and underscores, a letter first".into();
            return fail(format!("a {kind} cannot be named \"{name}\""), help);
        }
        let key = [&DOCUMENT_KEYS[..], &SIMULATE_KEYS, &SCHEDULE_KEYS].concat().contains(&name);
        let other = || Remedy::from(format!("choose another name, for example `own_{name}`"));
        if let Some(meaning) = functions::taken(name) {
            return fail(format!("`{name}` {meaning}"), other());
        }
        if key || LayerSpec::is_axis(name) {
            return fail(format!("`{name}` means something else in recipes"), other());
        }
        if self.registry.process(name).is_some() || self.registry.generator(name).is_some() {
            let help = remedy!["choose another name; ", Action::List, " shows those that are taken"];
            return fail(format!("there is a process or generator `{name}` already"), help);
        }
        let usual = self.registry.processes().iter().filter_map(|e| (e.make)(json!({})).ok());
        if layers::known(name).is_some() || usual.flat_map(|p| p.layers()).any(|l| l.spec.name == name) {
            let help =
                format!("choose another name, or change it with a [[rule]] that has set.{name} = \"...\"").into();
            return fail(format!("`{name}` is a layer that comes with Eyot"), help);
        }
        if self.own.iter().any(|o| o.name == name) {
            return fail(format!("two layers or rules are named `{name}`"), "give each a name of its own".into());
        }
        Some(name.to_owned())
    }

    fn parameters(&mut self, given: &BTreeMap<String, f64>, item: &Node) -> Option<Vec<(String, f32)>> {
        let before = self.out.len();
        for name in given.keys() {
            let taken = functions::meaning(name);
            if taken.is_some() || SCHEDULE_KEYS.contains(&name.as_str()) || !LayerSpec::is_name(name) {
                let key = item.get("parameters").and_then(|t| t.entries().iter().find(|(k, _)| k.name == *name));
                let span = key.map_or_else(|| item.span.clone(), |(k, _)| k.span.clone());
                let because = taken.map_or(String::new(), |meaning| format!(": it {meaning}"));
                let message = format!("a parameter cannot be named \"{name}\"{because}");
                let help = "use lower-case letters, digits and underscores, and no name that expressions know already";
                self.out.push(Diagnostic::at(span, message, "this name").help(help));
            }
        }
        (self.out.len() == before).then(|| given.iter().map(|(k, v)| (k.clone(), *v as f32)).collect())
    }

    /// The rule of the recipe's own layer or rule of this number, against the layers that there are now.
    pub(super) fn rule(&mut self, number: usize) -> Option<Arc<TextRule>> {
        self.own[number].listed = true;
        let (scope, failed) = self.scope();
        let own = &self.own[number];
        let definition = |values: Vec<(String, String)>, mask: &Option<String>| RuleDefinition {
            name: own.name.clone(),
            values,
            mask: mask.clone(),
            parameters: own.parameters.clone(),
        };
        let result = match &own.what {
            What::Layer(_, next, mask) => match scope.layer(&own.name).and_then(|k| k.declared.clone()) {
                None => return self.report(number, failed.get(&own.name).cloned().unwrap_or_default(), &failed),
                Some(layer) => {
                    let values = next.iter().map(|text| (own.name.clone(), text.clone())).collect();
                    eyot_rules::rule(&definition(values, mask), Some(&layer), &scope)
                }
            },
            What::Rule(set, mask) => {
                let values = set.iter().map(|(k, v)| (k.clone(), v.clone())).collect();
                eyot_rules::rule(&definition(values, mask), None, &scope)
            }
        };
        match result {
            Ok(rule) => Some(rule),
            Err(problems) => self.report(number, problems, &failed),
        }
    }

    /// What texts may name now, and what is wrong with the start values of layers that are left out.
    pub(super) fn scope(&self) -> (Scope, HashMap<String, Vec<Problem>>) {
        let (mut scope, mut failed) = (Scope::default(), HashMap::new());
        let own = |name: &str| self.own.iter().any(|o| o.name == name && matches!(o.what, What::Layer(..)));
        for name in self.layers.iter().filter(|n| !own(n)) {
            let found = self.specs.iter().find(|s| s.name == *name).cloned().or_else(|| layers::known(name));
            let (spec, measured) = match found {
                Some(spec) => (spec, true),
                None => (LayerSpec { name: Cow::Owned(name.clone()), ..plain() }, false),
            };
            scope.layers.push(Known { spec, measured, declared: None });
        }
        for (order, own) in self.own.iter().enumerate() {
            let What::Layer(definition, ..) = &own.what else { continue };
            match eyot_rules::layer(definition, order, &scope) {
                Ok(layer) => scope.layers.push(declared(layer, definition)),
                Err(problems) => drop(failed.insert(own.name.clone(), problems)),
            }
        }
        (scope, failed)
    }

    /// Says what is wrong with a rule.
    fn report(
        &mut self,
        number: usize,
        problems: Vec<Problem>,
        failed: &HashMap<String, Vec<Problem>>,
    ) -> Option<Arc<TextRule>> {
        for (part, mistake) in problems {
            // What is unknown may be a layer whose start value is wrong: that is what must be put right.
            let behind = mistake.unknown.as_deref().and_then(|(name, _)| failed.get(name));
            let other = behind
                .and_then(|_| self.own.iter().position(|o| Some(&o.name) == mistake.unknown.as_ref().map(|u| &u.0)));
            match (behind, other) {
                (Some(problems), Some(other)) if other != number => {
                    for (part, mistake) in problems.clone() {
                        let diagnostic = self.diagnostic(other, &part, &mistake);
                        self.out.push(diagnostic);
                    }
                }
                _ => {
                    let diagnostic = self.diagnostic(number, &part, &mistake);
                    self.out.push(diagnostic);
                }
            }
        }
        None
    }

    fn diagnostic(&self, number: usize, part: &Part, mistake: &Mistake) -> Diagnostic {
        let own = &self.own[number];
        let text = match part {
            Part::Start => own.node.get("start"),
            Part::Mask => own.node.get("mask"),
            Part::Value(layer) => match &own.what {
                What::Layer(..) => own.node.get("next"),
                What::Rule(..) => own.node.get("set").and_then(|s| s.get(layer)),
            },
            Part::Whole => None,
        };
        let span = text.map_or_else(|| own.node.span.clone(), |node| self.inside(node, mistake));
        self.mistaken(span, mistake)
    }

    pub(super) fn mistaken(&self, span: Span, mistake: &Mistake) -> Diagnostic {
        mistaken(self.registry, span, mistake)
    }

    pub(super) fn inside(&self, node: &Node, mistake: &Mistake) -> Span {
        inside(self.sources, node, mistake)
    }

    /// Finds what no step names and no rule needs.
    pub(super) fn unused(&mut self) {
        if !self.out.is_empty() {
            return;
        }
        for own in self.own.iter().filter(|o| !o.listed) {
            let known = self.layers.contains(&own.name) || self.resting.contains(&own.name);
            if known && matches!(own.what, What::Layer(_, None, _)) {
                continue;
            }
            let span = own.node.get("name").map_or_else(|| own.node.span.clone(), |n| n.span.clone());
            let message = format!("no step simulates `{}`", own.name);
            let help = format!("add \"{}\" to `simulate` of the step in which it is to act", own.name);
            self.out.push(Diagnostic::at(span, message, "never acts").help(help));
        }
    }
}

/// What is wrong at this place.
pub(crate) fn mistaken(registry: &Registry, span: Span, mistake: &Mistake) -> Diagnostic {
    let diagnostic = Diagnostic::at(span, mistake.message.clone(), mistake.label.clone());
    let unknown = mistake.unknown.as_deref();
    let help = unknown.map(|(name, known)| instead(registry, name, known)).or(mistake.help.clone());
    match help {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

/// What was meant by an unknown name.
fn instead(registry: &Registry, name: &str, known: &[String]) -> Remedy {
    let names = || known.iter().map(String::as_str);
    if let Some(near) = nearest(name, names()) {
        return format!("did you mean `{near}`?").into();
    }
    let usual = |e: &&&'static eyot_core::process::Entry<dyn eyot_core::process::Process>| {
        (e.make)(json!({})).is_ok_and(|p| p.layers().iter().any(|l| l.spec.name == name))
    };
    match registry.processes().iter().find(usual) {
        Some(e) => format!("`{}` makes such a layer: name it in `simulate` before this rule", e.name).into(),
        None if known.len() > 24 => remedy![Action::Describe("expressions".to_owned()), " lists names and functions"],
        None => format!("there is {}", alternatives(names())).into(),
    }
}

/// The place of a mistake in a document. A text with escapes is shown as a whole.
pub(crate) fn inside(sources: &[Source], node: &Node, mistake: &Mistake) -> Span {
    let whole = node.span.clone();
    let written = sources.get(whole.source).and_then(|s| s.text.get(whole.start..whole.end));
    let at = written.zip(node.text()).and_then(|(written, text)| written.find(text));
    let Some(at) = at else { return whole };
    let start = whole.start + at + mistake.span.start;
    // The end of a text is shown at its closing quote.
    let end = (whole.start + at + mistake.span.end).max(start + 1).min(whole.end);
    Span { source: whole.source, start, end }
}

fn plain() -> LayerSpec {
    LayerSpec::new("", "1", "", (f32::MIN, f32::MAX))
}

fn declared(layer: Arc<DeclaredLayer>, definition: &LayerDefinition) -> Known {
    Known { spec: definition.spec.clone(), measured: definition.measured, declared: Some(layer) }
}
