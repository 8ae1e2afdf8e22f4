//! The `[[step]]` tables: what each does, with whose parameters, and what it leaves for the next.

use super::{Validator, shared, terms, without};
use crate::check;
use crate::diagnostic::{Diagnostic, ENOUGH, alternatives, nearest};
use crate::keys::{self, Names, Schedule};
use crate::merge::Merge;
use crate::node::{Kind, Node};
use crate::recipe::{Actor, GenerateStep, ProcessUse, SimulateStep, Step, Work};
use crate::registry::{DOCUMENT_KEYS, GENERATE_KEYS, Registry, SCHEDULE_KEYS, SIMULATE_KEYS};
use crate::texts;
use eyot_core::LayerSpec;
use eyot_core::layer::known;
use eyot_core::process::{Entry, Generator, Process, schema_of};
use eyot_core::remedy;
use eyot_core::remedy::{Action, Remedy, Setting, Worded};
use eyot_core::rng::mix64;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::sync::Arc;

impl Validator<'_> {
    pub(super) fn steps(&mut self, doc: &Node, seed: u64) -> Vec<Step> {
        let Some(node) = doc.get("step") else {
            let help = "add a table [[step]] with generate = \"cone\", or simulate = [\"...\"] and steps = 1000";
            self.out.push(Diagnostic::whole("the recipe has no steps").help(help));
            return Vec::new();
        };
        let Kind::Array(items) = &node.kind else {
            let message = format!("`step` must be a list of tables, not {}", node.describe());
            self.out.push(
                Diagnostic::at(node.span.clone(), message, "here")
                    .help("write [[step]] with two brackets on each side"),
            );
            return Vec::new();
        };
        let mut names = HashSet::new();
        let mut steps = Vec::new();
        for (i, item) in items.iter().enumerate() {
            if self.out.len() >= ENOUGH {
                break;
            }
            if let Some(named) = item.get("name").filter(|n| n.text().is_some()) {
                self.name(named, &mut names);
            }
            let made_before = self.layers.len();
            let step = match (item.get("generate"), item.get("simulate")) {
                (Some(_), None) => self.generate(item, i + 1, seed),
                (None, Some(_)) => self.simulate(item, i + 1),
                (Some(_), Some(simulate)) => {
                    let help = "split it into two [[step]] tables";
                    let message = "a step either generates or simulates, this one does both";
                    self.out.push(Diagnostic::at(simulate.span.clone(), message, "one too many").help(help));
                    None
                }
                (None, None) => {
                    let message = format!("step {} does nothing", i + 1);
                    let keys: Vec<&str> = item.entries().iter().map(|(k, _)| k.name.as_str()).collect();
                    let guess = keys.iter().find_map(|k| nearest(k, ["generate", "simulate"]));
                    let help = match guess {
                        Some(g) => format!("did you mean `{g}`?"),
                        None => "give it generate = \"NAME\" or simulate = [\"NAME\"]".to_owned(),
                    };
                    self.out.push(
                        Diagnostic::at(item.span.clone(), message, "`generate` or `simulate` is missing").help(help),
                    );
                    None
                }
            };
            if step.as_ref().is_some_and(|s| !s.enabled) {
                // A step that does not run makes no layers.
                let rest = self.layers.split_off(made_before);
                self.resting.extend(rest);
            }
            steps.extend(step);
        }
        steps
    }

    fn name(&mut self, node: &Node, names: &mut HashSet<String>) {
        let name = node.text().unwrap_or("");
        let taken = DOCUMENT_KEYS.contains(&name) || self.registry.process(name).is_some();
        let span = node.span.clone();
        if name.is_empty() || name.bytes().all(|b| b.is_ascii_digit()) || taken {
            let message = format!("a step cannot be named \"{name}\"");
            let help = remedy![
                "`",
                Setting::Set.to("NAME.parameter=value"),
                "` must be able to tell it from numbers, processes and keys of the recipe",
            ];
            self.out.push(Diagnostic::at(span, message, "choose another name").help(help));
        } else if !names.insert(name.to_owned()) {
            let message = format!("two steps are named \"{name}\"");
            self.out
                .push(Diagnostic::at(span, message, "used before").help("give each step a name of its own, or none"));
        }
    }

    fn generate(&mut self, node: &Node, number: usize, seed: u64) -> Option<Step> {
        let before = self.out.len();
        let entry = self.known_generator(node.get("generate")?);
        // The step's own keys and the generator's stand in one table; each schema checks its share.
        let own = schema_of::<keys::Generate>().to_value();
        let theirs = entry.map(|e| (e.schema)().to_value());
        let mine = Node {
            span: node.span.clone(),
            kind: Kind::Table(
                node.entries().iter().filter(|(k, _)| GENERATE_KEYS.contains(&k.name.as_str())).cloned().collect(),
            ),
        };
        check::table(&own, &mine, "step", &[], &mut self.out);
        if let (Some(entry), Some(schema)) = (entry, &theirs) {
            check::table(schema, node, entry.name, &GENERATE_KEYS, &mut self.out);
        }
        let entry = entry?;
        let mut parameters = without(node, &GENERATE_KEYS);
        if entry.name == "import" {
            let file = node.get("file");
            let span = file.map_or_else(|| node.span.clone(), |n| n.span.clone());
            match file.map(Node::text) {
                None | Some(Some("")) => {
                    let message = "`import` needs the key `file`";
                    let help = "add file = \"NAME.tif\", relative to the recipe's folder";
                    self.out.push(Diagnostic::at(span, message, "which file?").help(help));
                }
                Some(Some(file)) => parameters["file"] = self.file(file, &span).map_or(Value::Null, Value::String),
                Some(None) => {}
            }
            parameters["max_bytes"] = Value::from(self.limits.max_bytes);
        }
        if entry.name == "import" && self.out.len() == before {
            self.bed_file(node, &parameters);
        }
        if self.out.len() > before {
            let layer = node.get("layer").and_then(Node::text).unwrap_or("height");
            if !self.layers.iter().any(|l| l == layer) {
                self.layers.push(layer.to_owned());
            }
            return None;
        }
        let keys: keys::Generate = self.keys_of(&mine, "step", &[]);
        let generator = match (entry.make)(parameters.clone()) {
            Ok(g) => g,
            Err(e) => {
                self.out.push(Diagnostic::at(node.span.clone(), format!("`{}`: {e}", entry.name), "this step"));
                return None;
            }
        };
        if let Some(Err(e)) = self.grid.filter(|_| keys.enabled).map(|g| generator.check(&g)) {
            self.out.push(refused(&e, entry.name, node));
            return None;
        }
        if !LayerSpec::is_name(&keys.layer) || LayerSpec::is_axis(&keys.layer) {
            let span = node.get("layer").map_or_else(|| node.span.clone(), |n| n.span.clone());
            let message = format!("a layer cannot be named \"{}\"", keys.layer);
            self.out.push(
                Diagnostic::at(span, message, "this name")
                    .help("use lower-case letters, digits and underscores, a letter first"),
            );
            return None;
        }
        if let Some(mask) = &keys.mask
            && !self.layers.contains(mask)
        {
            let span = node.get("mask").map_or_else(|| node.span.clone(), |n| n.span.clone());
            let problem = self.no_layer(mask, span);
            self.out.push(problem);
        }
        for read in generator.reads().into_iter().filter(|l| keys.enabled && !self.layers.iter().any(|k| k == l)) {
            let mut problem = self.no_layer(read, node.span.clone());
            problem.message = remedy![format!("`{}` looks at another layer: ", entry.name), problem.message];
            self.out.push(problem);
        }
        if keys.enabled && generator.is_filter() && !self.layers.contains(&keys.layer) {
            let message = format!("`{}` changes a layer, but there is no layer `{}` yet", entry.name, keys.layer);
            let help = "let another step make the layer before this one";
            self.out.push(Diagnostic::at(node.get("generate")?.span.clone(), message, "nothing to change").help(help));
        }
        if keys.enabled && !self.layers.contains(&keys.layer) {
            self.layers.push(keys.layer.clone());
        }
        let marks =
            keys.enabled && keys.layer == known::HEIGHT.name && !self.layers.iter().any(|l| *l == known::MISSING.name);
        if marks && self.grid.is_some_and(|g| generator.missing(&g).is_ok_and(|m| m.is_some())) {
            self.layers.push(known::MISSING.name.into_owned());
        }
        let merge = keys.merge.unwrap_or(if generator.is_filter() { Merge::Set } else { Merge::Add });
        let work = GenerateStep {
            entry,
            parameters,
            layer: keys.layer,
            merge,
            mask: keys.mask,
            amount: keys.amount,
            doubts: self.grid.filter(|_| keys.enabled).map(|g| generator.doubts(&g)).unwrap_or_default(),
            seed: step_seed(keys.seed.unwrap_or(seed), if keys.seed.is_some() { 0 } else { number as u64 }),
        };
        let name = keys.name.unwrap_or_else(|| entry.name.to_owned());
        Some(Step { number, name, enabled: keys.enabled, work: Work::Generate(work) })
    }

    fn known_generator(&mut self, node: &Node) -> Option<&'static Entry<dyn Generator>> {
        let Some(name) = node.text() else {
            let message = format!("`generate` must be the name of a generator, not {}", node.describe());
            self.out
                .push(Diagnostic::at(node.span.clone(), message, "wrong type").help("for example generate = \"cone\""));
            return None;
        };
        let entry = self.registry.generator(name);
        if entry.is_none() {
            let help = if self.registry.process(name).is_some() {
                Remedy::from(format!("`{name}` is a process: write simulate = [\"{name}\"]"))
            } else if let Some(help) = value_of_another(self.registry, name) {
                help.into()
            } else {
                suggestion(name, self.registry.generator_names().collect())
            };
            self.out.push(
                Diagnostic::at(node.span.clone(), format!("there is no generator `{name}`"), "unknown generator")
                    .help(help),
            );
        }
        entry
    }

    fn simulate(&mut self, node: &Node, number: usize) -> Option<Step> {
        let before = self.out.len();
        let list = node.get("simulate")?;
        let single = std::slice::from_ref(list);
        let named = if list.text().is_some() { single } else { list.elements() };
        let mut uses: Vec<(&Node, Named)> = Vec::new();
        for n in named {
            if self.out.len() >= ENOUGH {
                break;
            }
            let Some(name) = n.text() else { continue };
            let own = || self.own.iter().position(|o| o.name == name).map(Named::Own);
            match self.registry.process(name).map(Named::Process).or_else(own) {
                Some(_) if uses.iter().any(|(n, _)| n.text() == Some(name)) => {
                    let message = format!("`{name}` is listed twice");
                    let help = "a process acts once a step; use a second [[step]] to let it act twice";
                    self.out.push(Diagnostic::at(n.span.clone(), message, "again").help(help));
                }
                Some(found) => uses.push((n, found)),
                None => {
                    let help = if self.registry.generator(name).is_some() {
                        Remedy::from(format!("`{name}` is a generator: write generate = \"{name}\""))
                    } else {
                        let mut known: Vec<&str> = self.registry.process_names().collect();
                        known.extend(self.own.iter().map(|o| o.name.as_str()));
                        suggestion(name, known)
                    };
                    self.out.push(
                        Diagnostic::at(n.span.clone(), format!("there is no process `{name}`"), "unknown process")
                            .help(help),
                    );
                }
            }
        }
        let complete = self.out.len() == before;
        let tables: Vec<&str> =
            node.entries().iter().map(|(k, _)| k.name.as_str()).filter(|k| !SIMULATE_KEYS.contains(k)).collect();
        let own: Vec<&str> = uses.iter().filter_map(|(n, _)| n.text()).collect();
        for (key, _) in
            node.entries().iter().filter(|(k, _)| tables.contains(&k.name.as_str()) && !own.contains(&k.name.as_str()))
        {
            let name = key.name.as_str();
            let (message, help) = if self.registry.process(name).is_some() || self.own.iter().any(|o| o.name == name) {
                (
                    format!("`{name}` is not simulated in this step"),
                    format!("add \"{name}\" to `simulate`, or remove its parameters"),
                )
            } else if !complete {
                continue; // Most likely the table of the process whose name is wrong.
            } else {
                let known: Vec<&str> = own.iter().copied().chain(SIMULATE_KEYS).collect();
                let inside = uses.iter().find(|(_, what)| match what {
                    Named::Process(e) => !(e.schema)().to_value()["properties"][name].is_null(),
                    Named::Own(i) => self.own[*i].parameters.iter().any(|(p, _)| p == name),
                });
                let help = match (inside.and_then(|(n, _)| n.text()), nearest(name, known.iter().copied())) {
                    (Some(e), _) => format!("parameters of a process carry its name: write {e}.{name}"),
                    (None, Some(n)) => format!("did you mean `{n}`?"),
                    (None, None) => format!("it takes {}", alternatives(known)),
                };
                (format!("a simulating step has no key `{name}`"), help)
            };
            self.out.push(Diagnostic::at(key.span.clone(), message, "unknown key").help(help));
        }
        let keys: keys::Simulate = self.keys_of(node, "step", &tables);
        let processes: Vec<ProcessUse> = uses
            .iter()
            .filter_map(|(place, what)| self.acting(place.text().and_then(|n| node.get(n)), place, what, keys.enabled))
            .collect();
        if keys.enabled {
            self.shared(node, &processes);
        }
        if matches!(&keys.simulate, Names::Many(names) if names.is_empty()) && self.out.len() == before {
            self.out.push(
                Diagnostic::at(list.span.clone(), "no process is listed", "empty").help(remedy!["see ", Action::List]),
            );
        }
        if keys.steps > self.limits.max_steps {
            let span = node.get("steps").map_or_else(|| node.span.clone(), |n| n.span.clone());
            let message = format!("{} steps exceed the limit of {}", keys.steps, self.limits.max_steps);
            self.out
                .push(Diagnostic::at(span, message, "too many").help("choose fewer steps, or several [[step]] tables"));
        }
        if self.out.len() > before {
            return None;
        }
        let name = keys.name.unwrap_or_else(|| own.join(" + "));
        let work = Work::Simulate(SimulateStep { steps: keys.steps, processes });
        Some(Step { number, name, enabled: keys.enabled, work })
    }

    /// Finds parameters that processes share and do not agree on.
    fn shared(&mut self, node: &Node, processes: &[ProcessUse]) {
        let place = |name: &str, key: &str| node.get(name).and_then(|table| table.get(key));
        for c in shared::conflicts(processes, &|name, key| place(name, key).is_some()) {
            let span = place(c.process, &c.key).map_or_else(|| node.span.clone(), |n| n.span.clone());
            self.out.push(Diagnostic::at(span, c.message, "not what the others have").help(c.help));
        }
    }

    fn acting(&mut self, table: Option<&Node>, place: &Node, what: &Named, step_enabled: bool) -> Option<ProcessUse> {
        let actor = match what {
            Named::Process(entry) => Actor::Process(entry),
            Named::Own(i) => Actor::Rule(self.rule(*i)?),
        };
        let usual = if let Named::Own(i) = what { self.own[*i].every } else { 1 };
        let empty = Node { span: place.span.clone(), kind: Kind::Table(Vec::new()) };
        let node = table.unwrap_or(&empty);
        let before = self.out.len();
        let (name, own) = (actor.name(), actor.schema());
        let (texts, node) = &terms::apart(&actor, node);
        let schedule = schema_of::<Schedule>().to_value();
        let theirs = Node {
            span: node.span.clone(),
            kind: Kind::Table(
                node.entries().iter().filter(|(k, _)| SCHEDULE_KEYS.contains(&k.name.as_str())).cloned().collect(),
            ),
        };
        check::table(&own, node, name, &SCHEDULE_KEYS, &mut self.out);
        check::table(&schedule, &theirs, name, &[], &mut self.out);
        if self.out.len() > before {
            self.presume(&actor);
            return None;
        }
        let mut schedule: Schedule = serde_json::from_value(theirs.to_json()).unwrap_or_default();
        if theirs.get("every").is_none() {
            schedule.every = usual;
        }
        let mut parameters = without(node, &SCHEDULE_KEYS);
        for key in texts::parameters(&actor) {
            if let Some((file, n)) =
                node.get(&key).and_then(|n| Some((n.text()?.to_owned(), n))).filter(|f| !f.0.is_empty())
            {
                parameters[&key] = Value::String(self.text(&file, &n.span)?);
            }
        }
        let acts = step_enabled && schedule.enabled;
        match actor.make(&parameters) {
            Ok(process) => {
                if let Some(Err(e)) = self.grid.filter(|_| acts).map(|g| process.check(&g)) {
                    self.out.push(refused(&e, name, node));
                    self.presume(&actor);
                    return None;
                }
                let needs = process.needs().into_iter().filter(|_| acts);
                for layer in needs.filter(|name| !self.layers.iter().any(|l| l == name)).collect::<Vec<_>>() {
                    let span = node.get(layer).map_or_else(|| node.span.clone(), |n| n.span.clone());
                    let mut problem = self.no_layer(layer, span);
                    problem.message = remedy![format!("`{name}` needs another layer: "), problem.message];
                    let help = format!("make it before with a generate step that has layer = \"{layer}\"");
                    self.out.push(problem.help(help));
                }
                self.views.extend(process.views().into_iter().map(|(name, _)| name.to_owned()));
                for spec in process.layers().into_iter().map(|l| l.spec) {
                    if !self.specs.iter().any(|s| s.name == spec.name) {
                        self.specs.push(spec.clone());
                    }
                    if !schedule.enabled {
                        self.resting.push(spec.name.into_owned());
                    } else if !self.layers.iter().any(|l| *l == *spec.name) {
                        self.layers.push(spec.name.into_owned());
                    }
                }
                let scope = Arc::new(self.scope().0);
                let terms = self.terms(&actor, &parameters, texts, &scope, acts)?;
                Some(ProcessUse { actor, parameters, terms, scope, every: schedule.every, enabled: schedule.enabled })
            }
            Err(e) => {
                self.out.push(Diagnostic::at(node.span.clone(), format!("`{name}`: {e}"), "here"));
                self.presume(&actor);
                None
            }
        }
    }

    /// Takes the layers of a process that is wrong for made, so that later steps are not blamed for it.
    fn presume(&mut self, actor: &Actor) {
        let Ok(process) = actor.make(&json!({})) else { return };
        for spec in process.layers().into_iter().map(|l| l.spec) {
            if !self.layers.iter().any(|l| *l == *spec.name) {
                self.layers.push(spec.name.into_owned());
            }
        }
    }
}

/// What a name in `simulate` means.
enum Named {
    Process(&'static Entry<dyn Process>),
    /// The recipe's own layer or rule of this number.
    Own(usize),
}

/// What a process or generator says of its parameters, at the parameter if it names one.
fn refused(e: &eyot_core::Error, owner: &str, node: &Node) -> Diagnostic {
    let field = match e {
        eyot_core::Error::BadParameter { field, .. } => node.at_path(field),
        _ => None,
    };
    // Where no parameter is wrong, it is the file, if there is one.
    let field = field.or_else(|| node.get("file")).or_else(|| node.get("generate"));
    let span = field.map_or_else(|| node.span.clone(), |n| n.span.clone());
    let help = remedy![Action::Describe(owner.to_owned()), " says what its parameters mean"];
    Diagnostic::at(span, e.sentence(), "this does not work").help(help)
}

/// What to write if `name` is no generator but one of the choices of a generator's parameter.
fn value_of_another(registry: &Registry, name: &str) -> Option<String> {
    let found: Vec<(&str, String)> = registry
        .generators()
        .iter()
        .filter_map(|e| {
            let schema = (e.schema)().to_value();
            let takes = |p: &Value| check::choices(p).is_some_and(|all| all.contains(&name));
            let key = schema["properties"].as_object()?.iter().find(|(_, p)| takes(p)).map(|(key, _)| key.clone())?;
            Some((e.name, key))
        })
        .collect();
    // Many generators take the bases of noise; this is the plain one.
    let (first, key) = found.iter().find(|(generator, _)| *generator == "fbm").or(found.first())?;
    let generators = alternatives(found.iter().map(|(generator, _)| *generator));
    Some(format!("`{name}` is a value of `{key}` of {generators}: write generate = \"{first}\" and {key} = \"{name}\""))
}

fn suggestion(name: &str, known: Vec<&str>) -> Remedy {
    match nearest(name, known.iter().copied()) {
        Some(n) => remedy![format!("did you mean `{n}`? "), Action::List, " shows all of them"],
        None if known.is_empty() => "this build of Eyot has none".into(),
        None => remedy![format!("there is {}; ", alternatives(known)), Action::List, " says what they do"],
    }
}

/// The seed of a step, so that neighbouring steps and seeds share nothing.
fn step_seed(seed: u64, position: u64) -> u64 {
    mix64(seed.wrapping_add(position.wrapping_sub(1).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}
