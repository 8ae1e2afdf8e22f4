//! Changes to a simulation at work: to its processes (`hydraulic.rain=0.004`, `hydraulic.rain="0.004 * u"`, `thermal.enabled=false`)
//! and to its world (`sea_level=-20`, `layer.water=0`).

use crate::change::{LAYER, SEA_LEVEL};
use crate::check;
use crate::diagnostic::{Diagnostic, Problems, Source, alternatives, nearest};
use crate::keys::Schedule;
use crate::node::{Key, Node};
use crate::recipe::{Actor, ProcessUse};
use crate::registry::{Registry, SCHEDULE_KEYS};
use crate::set;
use crate::texts;
use crate::validate::{clock, rules, shared, terms};
use eyot_core::process::{over, schema_of};
use eyot_core::remedy;
use eyot_core::remedy::Remedy;
use eyot_core::{Grid, LayerSpec};
use eyot_expr::ParseError;
use serde_json::Value;

pub use clock::foresee;

/// What a change does to the world, beside the processes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum WorldChange {
    /// The sea stands at this level now, m.
    SeaLevel(f64),
    /// All cells of a layer have this value now.
    Layer {
        /// Its name.
        name: String,
        /// The value, in the layer's unit.
        value: f32,
    },
}

/// Applies a change to the processes of a step and says what else it does, or says why not; then nothing has changed. `has` says which
/// layers are there.
///
/// # Errors
/// If no such process acts in the step, or it does not take the value, or the processes of the step would not agree any more on
/// what they share.
pub fn apply(
    uses: &mut [ProcessUse],
    flag: &str,
    registry: &Registry,
    grid: &Grid,
    has: &dyn Fn(&str) -> bool,
) -> Result<Vec<WorldChange>, Problems> {
    let (text, parsed) = set::parse(flag, 0);
    let fail = |diagnostics| Problems::new(vec![Source { name: "set".to_owned(), text: text.clone() }], diagnostics);
    let node = parsed.map_err(fail)?;
    let mut out = Vec::new();
    let (mut changes, mut expressions) = (Vec::new(), Vec::new());
    let mut world = Vec::new();
    for (key, table) in node.entries() {
        if [SEA_LEVEL, LAYER].contains(&key.name.as_str()) {
            world_changes(key, table, has, &mut world, &mut out);
            continue;
        }
        let Some(i) = uses.iter().position(|u| u.actor.name() == key.name) else {
            let names = uses.iter().map(|u| u.actor.name());
            let help = match nearest(&key.name, names.clone()) {
                Some(n) => format!("did you mean `{n}`?"),
                None => format!(
                    "this step simulates {}; `{SEA_LEVEL}` and `{LAYER}.NAME` change the world",
                    alternatives(names)
                ),
            };
            let message = format!("this step does not simulate `{}`", key.name);
            out.push(Diagnostic::at(key.span.clone(), message, "not here").help(help));
            continue;
        };
        let name = uses[i].actor.name();
        let (texts, table) = &terms::apart(&uses[i].actor, table);
        expressions.push((i, texts.clone()));
        check::table(&uses[i].actor.schema(), table, name, &SCHEDULE_KEYS, &mut out);
        let schedule = schema_of::<Schedule>().to_value();
        for (k, v) in table.entries() {
            if SCHEDULE_KEYS.contains(&k.name.as_str()) {
                let mut one = table.clone();
                one.kind = crate::node::Kind::Table(vec![(k.clone(), v.clone())]);
                check::table(&schedule, &one, name, &[], &mut out);
            }
            texts::settled(&uses[i].actor, &k.name, flag)?;
            changes.push((i, k.name.clone(), v.to_json()));
        }
    }
    if !out.is_empty() {
        return Err(fail(out));
    }
    let mut changed = uses.to_vec();
    let named: Vec<(usize, String)> = {
        let texts = expressions.iter().flat_map(|(i, texts)| texts.iter().map(|(key, _)| (*i, key.name.clone())));
        changes.iter().map(|(i, key, _)| (*i, key.clone())).chain(texts).collect()
    };
    for (i, key, value) in changes {
        let u = &mut changed[i];
        match key.as_str() {
            "every" => u.every = value.as_u64().unwrap_or(1),
            "enabled" => u.enabled = value.as_bool().unwrap_or(true),
            _ => {
                if !u.parameters.is_object() {
                    u.parameters = Value::Object(serde_json::Map::new());
                }
                // A number takes the place of an expression.
                u.terms = u.terms.without(&key);
                // What a table does not name stays as it is now, and not as it usually is.
                let now = u.in_force();
                let refuse = |e: String| fail(vec![Diagnostic::whole(format!("{}.{key}: {e}", u.actor.name()))]);
                u.parameters[&key] = over(&now[&key], value).map_err(refuse)?;
            }
        }
    }
    for (i, texts) in expressions.into_iter().filter(|(_, texts)| !texts.is_empty()) {
        let u = &mut changed[i];
        let Actor::Process(entry) = u.actor else { continue };
        // As in a recipe: what is an expression is no number.
        let is_new = |name: &str| texts.iter().any(|(key, _)| key.name == name);
        let numbers = u.parameters.as_object().into_iter().flatten().filter(|(key, _)| !is_new(key));
        let parameters = Value::Object(numbers.map(|(key, v)| (key.clone(), v.clone())).collect());
        let kept: Vec<_> = u.terms.list().iter().filter(|t| !is_new(t.parameter())).cloned().collect();
        let say = |node: &Node, mistake: &ParseError| {
            let sources = [Source { name: "set".to_owned(), text: text.clone() }];
            rules::mistaken(registry, rules::inside(&sources, node, mistake), mistake)
        };
        let on = Some(grid).filter(|_| u.enabled);
        u.terms = terms::check(entry, &parameters, &texts, kept, &u.scope, on, &say).map_err(fail)?;
        u.parameters = parameters;
    }
    for u in &changed {
        let refuse = |e: Remedy| fail(vec![Diagnostic::whole(remedy![format!("{}: ", u.actor.name()), e])]);
        let process = u.make().map_err(|e| refuse(e.to_string().into()))?;
        if u.enabled {
            // Whatever would end the run at its next step.
            process.check(grid).map_err(|e| refuse(e.into()))?;
            if let Some(name) = process.needs().into_iter().find(|name| !has(name)) {
                return Err(refuse(format!("this needs the layer `{name}`, which no step has made").into()));
            }
        }
    }
    // A process that is switched on brings all that it shares.
    let given = |name: &str, key: &str| {
        let is_on = |i: usize| !uses[i].enabled && changed[i].enabled;
        named.iter().any(|(i, k)| changed[*i].actor.name() == name && (k == key || is_on(*i)))
    };
    if let Some(c) = shared::conflicts(&changed, &given).into_iter().next() {
        return Err(fail(vec![Diagnostic::whole(c.message).help(c.help)]));
    }
    uses.clone_from_slice(&changed);
    Ok(world)
}

/// Reads what a change says of the world.
fn world_changes(
    key: &Key,
    value: &Node,
    has: &dyn Fn(&str) -> bool,
    world: &mut Vec<WorldChange>,
    out: &mut Vec<Diagnostic>,
) {
    let mut number = |node: &Node| {
        let number = node.to_json().as_f64().filter(|n| n.is_finite());
        if number.is_none() {
            let message = format!("this must be a number, not {}", node.describe());
            out.push(Diagnostic::at(node.span.clone(), message, "here"));
        }
        number
    };
    if key.name == SEA_LEVEL {
        world.extend(number(value).map(WorldChange::SeaLevel));
        return;
    }
    let found: Vec<_> = value
        .entries()
        .iter()
        .filter_map(|(name, node)| {
            Some((name, WorldChange::Layer { name: name.name.clone(), value: number(node)? as f32 }))
        })
        .collect();
    if value.entries().is_empty() {
        let help = format!("write {LAYER}.NAME = NUMBER, for example {LAYER}.water = 0");
        out.push(Diagnostic::at(value.span.clone(), "no layer is named", "which one?").help(help));
    }
    for (name, change) in found {
        if has(&name.name) && LayerSpec::is_name(&name.name) {
            world.push(change);
        } else {
            out.push(Diagnostic::at(name.span.clone(), format!("there is no layer `{}`", name.name), "not here"));
        }
    }
}
