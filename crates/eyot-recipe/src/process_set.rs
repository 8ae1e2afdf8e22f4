//! Changes to a process while it runs: `hydraulic.rain=0.004`, `hydraulic.rain="0.004 * u"`, `thermal.enabled=false`.

use crate::check;
use crate::diagnostic::{Diagnostic, Problems, Source, alternatives, nearest};
use crate::keys::Schedule;
use crate::node::Node;
use crate::recipe::{Actor, ProcessUse};
use crate::registry::{Registry, SCHEDULE_KEYS};
use crate::set;
use crate::texts;
use crate::validate::{rules, terms};
use eyot_core::Grid;
use eyot_core::process::{over, schema_of};
use eyot_core::remedy;
use eyot_core::remedy::Remedy;
use eyot_expr::ParseError;
use serde_json::Value;

/// Applies a change to the processes of a step, or says why not; then nothing has changed. `has` says which layers are there.
///
/// # Errors
/// If no such process acts in the step, or it does not take the value.
pub fn apply(
    uses: &mut [ProcessUse],
    flag: &str,
    registry: &Registry,
    grid: &Grid,
    has: &dyn Fn(&str) -> bool,
) -> Result<(), Problems> {
    let (text, parsed) = set::parse(flag, 0);
    let fail = |diagnostics| Problems::new(vec![Source { name: "set".to_owned(), text: text.clone() }], diagnostics);
    let node = parsed.map_err(fail)?;
    let mut out = Vec::new();
    let (mut changes, mut expressions) = (Vec::new(), Vec::new());
    for (key, table) in node.entries() {
        let Some(i) = uses.iter().position(|u| u.actor.name() == key.name) else {
            let names = uses.iter().map(|u| u.actor.name());
            let help = match nearest(&key.name, names.clone()) {
                Some(n) => format!("did you mean `{n}`?"),
                None => format!("this step simulates {}", alternatives(names)),
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
    uses.clone_from_slice(&changed);
    Ok(())
}
