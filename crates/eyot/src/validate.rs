//! From a document to a checked recipe: everything that is wrong is collected, with its place.

use crate::check;
use crate::diagnostic::{Diagnostic, Problems, Source, alternatives, nearest};
use crate::import;
use crate::keys::{self, Cells, Edges, Export, ExportFormat, Lengths, Names, Schedule, View};
use crate::merge::Merge;
use crate::node::{Kind, Node, Span};
use crate::recipe::{GenerateStep, Overrides, ProcessUse, Recipe, RecipeSource, SimulateStep, Step, Work};
use crate::registry::{DOCUMENT_KEYS, GENERATE_KEYS, Registry, SCHEDULE_KEYS, SIMULATE_KEYS};
use crate::set;
use crate::shim::io::ReadOptions;
use eyot_core::process::{Parameters, schema_of};
use eyot_core::{Georeference, Grid, Limits, Rim};
use serde_json::Value;
use std::collections::HashSet;
use std::path::Path;

/// Checks a document.
pub(crate) fn recipe(
    source: RecipeSource,
    overrides: Overrides,
    registry: &Registry,
    limits: &Limits,
) -> Result<Recipe, Problems> {
    let mut sources = vec![Source { name: source.name.clone(), text: source.text.clone() }];
    let mut doc = match Node::parse(&source.text, 0) {
        Ok(doc) => doc,
        Err(errors) => return Err(Problems::new(sources, errors)),
    };
    let mut out = Vec::new();
    for flag in &overrides.set {
        set::apply(&mut doc, flag, registry, &mut sources, &mut out);
    }
    let mut v = Validator { registry, limits, folder: &source.folder, out, layers: Vec::new() };
    let document: keys::Document = v.keys_of(&doc, "recipe", &["grid", "step", "export", "view"]);
    let (grid, georeference) = v.grid(doc.get("grid"), overrides.size);
    let steps = v.steps(&doc, document.seed);
    let exports = v.exports(doc.get("export"));
    let view = doc.get("view").map(|n| v.keys_of::<View>(n, "view", &[])).unwrap_or_default();
    v.memory(doc.get("grid"), grid, &steps);
    if !v.out.is_empty() {
        return Err(Problems::new(sources, v.out));
    }
    let Some(grid) = grid else {
        return Err(Problems::new(
            sources,
            vec![Diagnostic::whole("this recipe has no grid").help("add [grid] with size = [512, 512]")],
        ));
    };
    let keys::Document { mut name, about, seed, sea_level: sea_level_m } = document;
    if name.is_empty() {
        name = Path::new(&source.name).file_stem().map_or(String::new(), |s| s.to_string_lossy().into_owned());
    }
    Ok(Recipe { name, about, seed, grid, georeference, sea_level_m, steps, exports, view, source, overrides })
}

struct Validator<'a> {
    registry: &'a Registry,
    limits: &'a Limits,
    folder: &'a Path,
    out: Vec<Diagnostic>,
    /// Layers that exist after the steps checked so far.
    layers: Vec<String>,
}

impl Validator<'_> {
    /// Checks a table's keys against the schema of `T` and reads them; the default if anything is wrong.
    fn keys_of<T: Parameters>(&mut self, node: &Node, owner: &str, elsewhere: &[&str]) -> T {
        let schema = schema_of::<T>().to_value();
        let before = self.out.len();
        check::table(&schema, node, owner, elsewhere, &mut self.out);
        if self.out.len() > before {
            return T::default();
        }
        let own = without(node, elsewhere);
        serde_json::from_value(own).unwrap_or_else(|e| {
            self.out.push(Diagnostic::at(node.span.clone(), format!("`{owner}`: {e}"), "here"));
            T::default()
        })
    }

    fn grid(&mut self, node: Option<&Node>, size: Option<(u32, Option<u32>)>) -> (Option<Grid>, Option<Georeference>) {
        let Some(node) = node else {
            self.out.push(
                Diagnostic::whole("the recipe has no grid")
                    .help("add a table [grid] with size = [512, 512] and cell = 10.0"),
            );
            return (None, None);
        };
        let before = self.out.len();
        let keys: keys::Grid = self.keys_of(node, "grid", &[]);
        if self.out.len() > before {
            return (None, None);
        }
        let place = |key: &str| node.get(key).map_or_else(|| node.span.clone(), |n| n.span.clone());
        let raster = match &keys.from {
            None => None,
            Some(file) => match self.raster(file, place("from")) {
                Some(r) => Some(r),
                None => return (None, None),
            },
        };
        let base = raster.as_ref().map(|r| (r.field.width(), r.field.height()));
        let named = keys.size.map(|s| match s {
            Cells::One(n) => (n as usize, n as usize),
            Cells::Two([w, h]) => (w as usize, h as usize),
        });
        let Some((mut w, mut h)) = named.or(base) else {
            let help = "add size = [512, 512], or from = \"FILE\" to take the grid of a height map";
            self.out.push(Diagnostic::at(node.span.clone(), "the grid has no size", "size is missing").help(help));
            return (None, None);
        };
        if keys.cell.is_some() && keys.extent_m.is_some() {
            let help = "keep one of them: the extent is the size times the cell";
            self.out.push(
                Diagnostic::at(place("extent_m"), "both `cell` and `extent_m` are given", "one too many").help(help),
            );
            return (None, None);
        }
        let two = |l: Lengths| match l {
            Lengths::One(a) => (a, a),
            Lengths::Two([a, b]) => (a, b),
        };
        let (mut dx, mut dy) = if let Some(cell) = keys.cell {
            two(cell)
        } else if let Some(extent) = keys.extent_m {
            let (ex, ey) = match extent {
                // One number is the longer side; cells are square.
                Lengths::One(a) => (a * w as f64 / w.max(h) as f64, a * h as f64 / w.max(h) as f64),
                Lengths::Two([a, b]) => (a, b),
            };
            (ex / w as f64, ey / h as f64)
        } else if let (Some((cx, cy)), Some((bw, bh))) = (raster.as_ref().and_then(|r| r.cell_m), base) {
            (cx * bw as f64 / w as f64, cy * bh as f64 / h as f64)
        } else {
            (10.0, 10.0)
        };
        if let Some((first, second)) = size {
            let (ex, ey) = (w as f64 * dx, h as f64 * dy);
            let longer = w.max(h) as f64;
            let scaled = |n: usize| ((n as f64 * f64::from(first) / longer).round() as usize).max(1);
            (w, h) = second.map_or((scaled(w), scaled(h)), |s| (first as usize, s as usize));
            (dx, dy) = (ex / w as f64, ey / h as f64);
        }
        let rim = match keys.rim {
            None => Rim::CLOSED,
            Some(Edges::One(e)) => Rim::both(e),
            Some(Edges::Two([x, y])) => Rim { x, y },
        };
        match (Grid { width: w, height: h, cell_x_m: dx, cell_y_m: dy, rim }).checked(self.limits) {
            Ok(grid) => {
                let georeference =
                    raster.and_then(|r| r.georeference).zip(base).map(|(g, b)| import::rescaled(&g, b, (w, h)));
                (Some(grid), georeference)
            }
            Err(e) => {
                let help =
                    "choose a size such as [512, 512] and a cell size in metres, or raise the limit with --max-memory";
                self.out.push(Diagnostic::at(place("size"), e.to_string(), "this grid").help(help));
                (None, None)
            }
        }
    }

    fn raster(&mut self, file: &str, span: Span) -> Option<crate::shim::io::Raster> {
        let path = self.file(file, &span)?;
        match import::read(&path, &ReadOptions::default(), self.limits) {
            Ok(r) => Some(r),
            Err(reason) => {
                self.out.push(
                    Diagnostic::at(span, reason, "this file")
                        .help("it must be a height map: GeoTIFF, TIFF, PNG or R32"),
                );
                None
            }
        }
    }

    /// The full path of a file that the recipe names.
    fn file(&mut self, file: &str, span: &Span) -> Option<String> {
        match import::resolve(file, self.folder) {
            Ok(path) => Some(path),
            Err((message, help)) => {
                self.out.push(Diagnostic::at(span.clone(), message, "this file").help(help));
                None
            }
        }
    }

    fn steps(&mut self, doc: &Node, seed: u64) -> Vec<Step> {
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
            if let Some(named) = item.get("name").filter(|n| n.text().is_some()) {
                self.name(named, &mut names);
            }
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
            let help =
                "`--set NAME.parameter=value` must be able to tell it from numbers, processes and keys of the recipe";
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
        }
        if self.out.len() > before {
            self.layers.extend(node.get("layer").and_then(Node::text).or(Some("height")).map(str::to_owned));
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
        if !layer_name_ok(&keys.layer) {
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
        if keys.enabled && generator.is_filter() && !self.layers.contains(&keys.layer) {
            let message = format!("`{}` changes a layer, but there is no layer `{}` yet", entry.name, keys.layer);
            let help = "let another step make the layer before this one";
            self.out.push(Diagnostic::at(node.get("generate")?.span.clone(), message, "nothing to change").help(help));
        }
        if keys.enabled && !self.layers.contains(&keys.layer) {
            self.layers.push(keys.layer.clone());
        }
        let merge = keys.merge.unwrap_or(if generator.is_filter() { Merge::Set } else { Merge::Add });
        let work = GenerateStep {
            entry,
            parameters,
            layer: keys.layer,
            merge,
            mask: keys.mask,
            amount: keys.amount,
            seed: step_seed(keys.seed.unwrap_or(seed), if keys.seed.is_some() { 0 } else { number as u64 }),
        };
        let name = keys.name.unwrap_or_else(|| entry.name.to_owned());
        Some(Step { number, name, enabled: keys.enabled, work: Work::Generate(work) })
    }

    fn known_generator(
        &mut self,
        node: &Node,
    ) -> Option<&'static eyot_core::process::Entry<dyn eyot_core::process::Generator>> {
        let Some(name) = node.text() else {
            let message = format!("`generate` must be the name of a generator, not {}", node.describe());
            self.out
                .push(Diagnostic::at(node.span.clone(), message, "wrong type").help("for example generate = \"cone\""));
            return None;
        };
        let entry = self.registry.generator(name);
        if entry.is_none() {
            let help = if self.registry.process(name).is_some() {
                format!("`{name}` is a process: write simulate = [\"{name}\"]")
            } else {
                suggestion(name, self.registry.generator_names().collect(), "eyot list")
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
        let mut uses: Vec<(&Node, &'static eyot_core::process::Entry<dyn eyot_core::process::Process>)> = Vec::new();
        for n in named {
            let Some(name) = n.text() else { continue };
            match self.registry.process(name) {
                Some(entry) if uses.iter().any(|(_, e)| e.name == name) => {
                    let message = format!("`{}` is listed twice", entry.name);
                    let help = "a process acts once a step; use a second [[step]] to let it act twice";
                    self.out.push(Diagnostic::at(n.span.clone(), message, "again").help(help));
                }
                Some(entry) => uses.push((n, entry)),
                None => {
                    let help = if self.registry.generator(name).is_some() {
                        format!("`{name}` is a generator: write generate = \"{name}\"")
                    } else {
                        suggestion(name, self.registry.process_names().collect(), "eyot list")
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
        let own: Vec<&str> = uses.iter().map(|(_, e)| e.name).collect();
        for (key, _) in
            node.entries().iter().filter(|(k, _)| tables.contains(&k.name.as_str()) && !own.contains(&k.name.as_str()))
        {
            let name = key.name.as_str();
            let (message, help) = if self.registry.process(name).is_some() {
                (
                    format!("`{name}` is not simulated in this step"),
                    format!("add \"{name}\" to `simulate`, or remove its parameters"),
                )
            } else if !complete {
                continue; // Most likely the table of the process whose name is wrong.
            } else {
                let known: Vec<&str> = own.iter().copied().chain(SIMULATE_KEYS).collect();
                let inside = uses.iter().find(|(_, e)| !(e.schema)().to_value()["properties"][name].is_null());
                let help = match (inside, nearest(name, known.iter().copied())) {
                    (Some((_, e)), _) => format!("parameters of a process carry its name: write {}.{name}", e.name),
                    (None, Some(n)) => format!("did you mean `{n}`?"),
                    (None, None) => format!("it takes {}", alternatives(known)),
                };
                (format!("a simulating step has no key `{name}`"), help)
            };
            self.out.push(Diagnostic::at(key.span.clone(), message, "unknown key").help(help));
        }
        let keys: keys::Simulate = self.keys_of(node, "step", &tables);
        let processes =
            uses.iter().filter_map(|(place, entry)| self.process(node.get(entry.name), place, entry)).collect();
        if matches!(&keys.simulate, Names::Many(names) if names.is_empty()) && self.out.len() == before {
            self.out.push(Diagnostic::at(list.span.clone(), "no process is listed", "empty").help("see `eyot list`"));
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

    fn process(
        &mut self,
        table: Option<&Node>,
        place: &Node,
        entry: &'static eyot_core::process::Entry<dyn eyot_core::process::Process>,
    ) -> Option<ProcessUse> {
        let empty = Node { span: place.span.clone(), kind: Kind::Table(Vec::new()) };
        let node = table.unwrap_or(&empty);
        let before = self.out.len();
        let own = (entry.schema)().to_value();
        let schedule = schema_of::<Schedule>().to_value();
        let theirs = Node {
            span: node.span.clone(),
            kind: Kind::Table(
                node.entries().iter().filter(|(k, _)| SCHEDULE_KEYS.contains(&k.name.as_str())).cloned().collect(),
            ),
        };
        check::table(&own, node, entry.name, &SCHEDULE_KEYS, &mut self.out);
        check::table(&schedule, &theirs, entry.name, &[], &mut self.out);
        if self.out.len() > before {
            return None;
        }
        let schedule: Schedule = serde_json::from_value(theirs.to_json()).unwrap_or_default();
        let parameters = without(node, &SCHEDULE_KEYS);
        match (entry.make)(parameters.clone()) {
            Ok(process) => {
                if schedule.enabled {
                    for (spec, _) in process.layers() {
                        if !self.layers.iter().any(|l| *l == *spec.name) {
                            self.layers.push(spec.name.into_owned());
                        }
                    }
                }
                Some(ProcessUse { entry, parameters, every: schedule.every, enabled: schedule.enabled })
            }
            Err(e) => {
                self.out.push(Diagnostic::at(node.span.clone(), format!("`{}`: {e}", entry.name), "here"));
                None
            }
        }
    }

    fn exports(&mut self, node: Option<&Node>) -> Vec<Export> {
        let Some(node) = node else { return Vec::new() };
        let Kind::Array(items) = &node.kind else {
            let message = format!("`export` must be a list of tables, not {}", node.describe());
            self.out.push(
                Diagnostic::at(node.span.clone(), message, "here")
                    .help("write [[export]] with two brackets on each side"),
            );
            return Vec::new();
        };
        let mut files = HashSet::new();
        let mut exports = Vec::new();
        // If a step is wrong, nobody knows which layers it would have made.
        let sure = self.out.is_empty();
        for item in items {
            let export: Export = self.keys_of(item, "export", &[]);
            let place = |key: &str| item.get(key).map_or_else(|| item.span.clone(), |n| n.span.clone());
            if !export.prefix.chars().all(|c| c.is_alphanumeric() || "_-. ".contains(c))
                || export.prefix.starts_with('.')
            {
                let message = format!("\"{}\" cannot start a file name", export.prefix);
                let help = "use letters, digits, dots, dashes and underscores; all files go into the output folder";
                self.out.push(Diagnostic::at(place("prefix"), message, "this prefix").help(help));
            }
            for (i, layer) in export.layers.iter().enumerate().filter(|_| export.uses_layers()) {
                if sure && export.enabled && !self.layers.contains(layer) {
                    let span = item
                        .get("layers")
                        .and_then(|l| l.elements().get(i))
                        .map_or_else(|| place("layers"), |n| n.span.clone());
                    let problem = self.no_layer(layer, span);
                    self.out.push(problem);
                }
            }
            for file in export.files().into_iter().filter(|_| export.enabled) {
                if !files.insert(file.clone()) {
                    let message = format!("two exports would write `{file}`");
                    self.out.push(
                        Diagnostic::at(item.span.clone(), message, "the second one")
                            .help("give one of them a `prefix`"),
                    );
                }
            }
            exports.push(export);
        }
        exports
    }

    fn no_layer(&self, name: &str, span: Span) -> Diagnostic {
        let help = match nearest(name, self.layers.iter().map(String::as_str)) {
            Some(n) => format!("did you mean `{n}`?"),
            None if self.layers.is_empty() => "no step has made a layer yet".to_owned(),
            None => format!("the steps make {}", alternatives(self.layers.iter().map(String::as_str))),
        };
        Diagnostic::at(span, format!("no step makes a layer `{name}`"), "unknown layer").help(help)
    }

    /// Two buffers a layer while the engine runs, and two more fields for a generator at work.
    fn memory(&mut self, node: Option<&Node>, grid: Option<Grid>, steps: &[Step]) {
        let (Some(node), Some(grid)) = (node, grid) else { return };
        let most = self.layers.len().max(1) as u128 * 2
            + if steps.iter().any(|s| matches!(s.work, Work::Generate(_))) { 2 } else { 0 };
        let bytes = grid.cells() as u128 * 4 * most;
        let what = format!("this recipe with {} layers of {} x {} cells", self.layers.len(), grid.width, grid.height);
        if let Err(e) = self.limits.check_bytes(&what, bytes) {
            let span = node.get("size").map_or_else(|| node.span.clone(), |n| n.span.clone());
            self.out.push(
                Diagnostic::at(span, e.to_string(), "this grid")
                    .help("choose fewer cells, or raise the limit with --max-memory"),
            );
        }
        if self.layers.len() > self.limits.max_layers {
            let message = format!("{} layers exceed the limit of {}", self.layers.len(), self.limits.max_layers);
            self.out.push(Diagnostic::whole(message));
        }
    }
}

impl Export {
    /// False for exports that always show the height.
    pub(crate) fn uses_layers(&self) -> bool {
        !matches!(self.format, ExportFormat::Glb | ExportFormat::Relief)
    }

    /// The names of the files that it writes.
    pub(crate) fn files(&self) -> Vec<String> {
        let p = &self.prefix;
        match self.format {
            ExportFormat::Glb => vec![format!("{p}terrain.glb")],
            ExportFormat::Relief => vec![format!("{p}relief.png")],
            ExportFormat::Map => self.layers.iter().map(|l| format!("{p}{l}_map.png")).collect(),
            ExportFormat::Png16 => self.layers.iter().map(|l| format!("{p}{l}.png")).collect(),
            ExportFormat::GeoTiff => self.layers.iter().map(|l| format!("{p}{l}.tif")).collect(),
            ExportFormat::R32 => self.layers.iter().map(|l| format!("{p}{l}.r32")).collect(),
        }
    }
}

fn suggestion(name: &str, known: Vec<&'static str>, command: &str) -> String {
    match nearest(name, known.iter().copied()) {
        Some(n) => format!("did you mean `{n}`? `{command}` shows all of them"),
        None if known.is_empty() => "this build of Eyot has none".to_owned(),
        None => format!("there is {}; `{command}` says what they do", alternatives(known)),
    }
}

fn layer_name_ok(name: &str) -> bool {
    let mut chars = name.chars();
    chars.next().is_some_and(|c| c.is_ascii_lowercase() || c == '_')
        && name.len() <= 64
        && chars.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

/// The table as JSON without some keys.
fn without(node: &Node, keys: &[&str]) -> Value {
    let entries = node.entries().iter().filter(|(k, _)| !keys.contains(&k.name.as_str()));
    Value::Object(entries.map(|(k, v)| (k.name.clone(), v.to_json())).collect())
}

/// The seed of a step (splitmix64), so that neighbouring steps and seeds share nothing.
pub(crate) fn step_seed(seed: u64, position: u64) -> u64 {
    let mut z = seed.wrapping_add(position.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
