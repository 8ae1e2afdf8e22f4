//! From a document to a checked recipe: everything that is wrong is collected, with its place.

use crate::check;
use crate::diagnostic::{Diagnostic, ENOUGH, Problems, Source, alternatives, nearest};
use crate::host::{RasterInfo, Refusal};
use crate::keys::{self, Cells, Edges, Export, Lengths, Preset, View, What};
use crate::memory::{self, Obstacle, Place};
use crate::node::{Kind, Node, Span};
use crate::recipe::{Overrides, Recipe, RecipeSource, Step, Texts};
use crate::registry::{Registry, TABLES};
use crate::set;
use eyot_core::process::{Parameters, parameters_from, schema_of};
use eyot_core::remedy;
use eyot_core::remedy::{Setting, Worded};
use eyot_core::{Boundary, Error, Georeference, Grid, LayerSpec, Limits};
use serde_json::Value;
use std::collections::HashSet;
use std::path::Path;

/// Bytes of a file name: 255 on every system, less what the description of a file adds to it.
const MAX_FILE_NAME: usize = 250;

/// Checks a document. Files whose texts are known already are not read.
pub(crate) fn recipe(
    source: RecipeSource,
    overrides: Overrides,
    registry: &Registry,
    limits: &Limits,
    texts: Texts,
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
    let mut v = Validator {
        registry,
        limits,
        folder: &source.folder,
        out,
        layers: Vec::new(),
        specs: Vec::new(),
        resting: Vec::new(),
        views: Vec::new(),
        own: Vec::new(),
        sources: &sources,
        grid: None,
        written: None,
        texts,
    };
    let document: keys::Document = v.keys_of(&doc, check::ROOT, &TABLES);
    let (grid, georeference) = v.grid(doc.get("grid"), overrides.size);
    v.grid = grid;
    v.declare(&doc);
    v.materials(&mut doc);
    let steps = v.steps(&doc, document.seed);
    v.unused();
    let mut exports = v.exports(doc.get("export"));
    exports.extend(v.presets(&overrides.presets, &exports));
    let view = doc.get("view").map(|n| v.keys_of::<View>(n, "view", &[])).unwrap_or_default();
    v.memory(&doc, grid, &steps, &exports, &view);
    v.clock(&doc, grid, document.sea_level, &steps);
    let (out, texts) = (v.out, v.texts);
    if !out.is_empty() {
        return Err(Problems::new(sources, out));
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
    let document = doc.to_json();
    Ok(Recipe {
        name,
        about,
        seed,
        grid,
        georeference,
        sea_level_m,
        steps,
        exports,
        view,
        source,
        overrides,
        texts,
        document,
    })
}

mod beds;
pub(crate) mod clock;
mod materials;
pub(crate) mod rules;
pub(crate) mod shared;
mod steps;
pub(crate) mod terms;

struct Validator<'a> {
    registry: &'a Registry,
    limits: &'a Limits,
    folder: &'a Path,
    out: Vec<Diagnostic>,
    /// Layers that exist after the steps checked so far.
    layers: Vec<String>,
    /// What the layers of processes and of the recipe's own are.
    specs: Vec<LayerSpec>,
    /// The recipe's own layers and rules.
    own: Vec<rules::Own>,
    sources: &'a [Source],
    /// Layers that steps and processes would make that are switched off.
    resting: Vec<String>,
    /// Tables, points and lines that processes keep, also those that are switched off.
    views: Vec<String>,
    /// The grid, once it has been checked and is sound.
    grid: Option<Grid>,
    /// Columns and rows that the recipe gives the grid, whatever the run is told.
    written: Option<(usize, usize)>,
    /// Text files that the recipe names.
    texts: Texts,
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
        parameters_from(own).unwrap_or_else(|e| {
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
        let base = raster.as_ref().map(|r| (r.width, r.height));
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
        self.written = Some((w, h));
        if let Some((first, second)) = size {
            let (ex, ey) = (w as f64 * dx, h as f64 * dy);
            let longer = w.max(h) as f64;
            let scaled = |n: usize| ((n as f64 * f64::from(first) / longer).round() as usize).max(1);
            (w, h) = second.map_or((scaled(w), scaled(h)), |s| (first as usize, s as usize));
            (dx, dy) = (ex / w as f64, ey / h as f64);
        }
        let rim = match keys.rim {
            None => Boundary::CLOSED,
            Some(Edges::One(e)) => Boundary::both(e),
            Some(Edges::Two([x, y])) => Boundary { x, y },
        };
        match (Grid { width: w, height: h, cell_x_m: dx, cell_y_m: dy, rim }).checked(self.limits) {
            Ok(grid) => {
                let georeference = raster.and_then(|r| r.georeference).zip(base).map(|(g, b)| g.rescaled(b, (w, h)));
                (Some(grid), georeference)
            }
            Err(e) => {
                let help = remedy![
                    "choose a size such as [512, 512] and a cell size in metres, or raise the limit with ",
                    Setting::MaxMemory,
                ];
                self.out.push(Diagnostic::at(place("size"), e, "this grid").help(help));
                (None, None)
            }
        }
    }

    fn raster(&mut self, file: &str, span: Span) -> Option<RasterInfo> {
        let path = self.file(file, &span)?;
        let found = self.registry.files().raster(&path, self.limits);
        self.found(found, &span)
    }

    /// The full path of a file that the recipe names.
    fn file(&mut self, file: &str, span: &Span) -> Option<String> {
        let found = self.registry.files().locate(file, self.folder);
        self.found(found, span)
    }

    /// The text of a file that the recipe names.
    fn text(&mut self, file: &str, span: &Span) -> Option<String> {
        if let Some(known) = self.texts.get(file) {
            return Some(known.clone());
        }
        let found = self.registry.files().text(file, self.folder);
        let text = self.found(found, span)?;
        self.texts.insert(file.to_owned(), text.clone());
        Some(text)
    }

    fn found<T>(&mut self, found: Result<T, Refusal>, span: &Span) -> Option<T> {
        let refused = |Refusal { message, help }| {
            self.out.push(Diagnostic::at(span.clone(), message, "this file").help(help));
        };
        found.map_err(refused).ok()
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
            if self.out.len() >= ENOUGH {
                break;
            }
            let before = self.out.len();
            let export: Export = self.keys_of(item, "export", &[]);
            if self.out.len() > before {
                // Nobody knows what it was meant to be.
                continue;
            }
            let place = |key: &str| item.get(key).map_or_else(|| item.span.clone(), |n| n.span.clone());
            if !export.prefix.chars().all(|c| c.is_alphanumeric() || "_-. ".contains(c))
                || export.prefix.starts_with('.')
            {
                let message = format!("\"{}\" cannot start a file name", export.prefix);
                let help = "use letters, digits, dots, dashes and underscores; all files go into the output folder";
                self.out.push(Diagnostic::at(place("prefix"), message, "this prefix").help(help));
            }
            for (i, layer) in export.layers.iter().enumerate().filter(|_| export.uses_layers()) {
                let material = export.knows(layer);
                if sure && export.enabled && !material && !self.layers.contains(layer) && !self.resting.contains(layer)
                {
                    let span = item
                        .get("layers")
                        .and_then(|l| l.elements().get(i))
                        .map_or_else(|| place("layers"), |n| n.span.clone());
                    let problem = self.no_layer(layer, span);
                    self.out.push(problem);
                }
            }
            if let (What::View(name), true, None) = (export.shows(), sure && export.enabled, export.preset)
                && !self.views.contains(&name)
            {
                let problem = self.no_view(&name, place("what"));
                self.out.push(problem);
            }
            let narrow = self.grid.is_some_and(|g| g.width < 2 || g.height < 2);
            if narrow && export.enabled && export.needs_two_cells() {
                let (key, what) = match export.preset {
                    Some(preset) => ("preset", format!("the preset `{}`", preset.name())),
                    None if export.what.is_none() => ("format", "a mesh".to_owned()),
                    None => ("what", "a mesh".to_owned()),
                };
                let message = format!("{what} needs at least 2 x 2 cells");
                self.out.push(
                    Diagnostic::at(place(key), message, "this export")
                        .help("choose a larger [grid], or leave out this export"),
                );
            }
            self.export_keys(item, &export);
            let longest = export.files().into_iter().max_by_key(String::len).filter(|f| f.len() > MAX_FILE_NAME);
            if let Some(file) = longest {
                let message = format!("a file name of {} bytes is too long: there can be {MAX_FILE_NAME}", file.len());
                let help = "choose a shorter `prefix`";
                self.out.push(Diagnostic::at(place("prefix"), message, "this prefix").help(help));
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

    /// The exports of `--preset`. One that the recipe has already is not written twice.
    fn presets(&mut self, presets: &[Preset], present: &[Export]) -> Vec<Export> {
        let mut more = Vec::new();
        for &preset in presets.iter().filter(|p| !present.iter().any(|e| e.enabled && e.preset == Some(**p))) {
            let export = Export { preset: Some(preset), prefix: preset.free_prefix(present), ..Export::default() };
            if self.grid.is_some_and(|g| g.width < 2 || g.height < 2) && export.needs_two_cells() {
                let message = format!("the preset `{}` needs at least 2 x 2 cells", preset.name());
                self.out.push(Diagnostic::whole(message).help("choose a larger [grid]"));
            }
            more.push(export);
        }
        more
    }

    /// Keys that do not go together.
    fn export_keys(&mut self, item: &Node, export: &Export) {
        let span = |key: &str| item.get(key).map(|n| n.span.clone());
        for key in ["what", "format"].into_iter().filter(|_| export.preset.is_some()) {
            if let Some(at) = span(key) {
                let help = "keep one of them: a preset chooses its files and their formats itself";
                let message = format!("both `{key}` and `preset` are given");
                self.out.push(Diagnostic::at(at, message, "one too many").help(help));
            }
        }
        if let (Some((message, help)), None) = (export.format_problem(), export.preset) {
            let at = span("format").unwrap_or_else(|| item.span.clone());
            self.out.push(Diagnostic::at(at, message, "this format").help(help));
        }
        if let Some(preset) = export.preset {
            let layers = if preset == Preset::Gis { None } else { Some("layers") };
            let levels = if preset == Preset::Blender { None } else { Some("levels") };
            let first_row = if preset == Preset::Unity { None } else { Some("first_row") };
            for key in ["range", "bytes"].into_iter().chain(first_row).chain(layers).chain(levels) {
                if let Some(at) = span(key) {
                    let message = format!("`{key}` has no effect with the preset `{}`", preset.name());
                    let help = "leave it out: a preset decides this itself; or choose a `format` instead of a preset";
                    self.out.push(Diagnostic::at(at, message, "this key").help(help));
                }
            }
        }
        for (key, fits, needs) in export.narrow_keys() {
            if let Some(at) = span(key).filter(|_| !fits) {
                let message = format!("`{key}` has no effect here: it belongs to {needs}");
                self.out.push(Diagnostic::at(at, message, "this key").help("leave it out"));
            }
        }
        if let (Some(at), Some(grid)) = (span("tiles"), self.grid)
            && (export.tiles[0] as usize >= grid.width || export.tiles[1] as usize >= grid.height)
        {
            let message = format!("{:?} tiles cannot be cut from {} x {} cells", export.tiles, grid.width, grid.height);
            self.out.push(Diagnostic::at(at, message, "this many").help("choose fewer tiles, or a larger [grid]"));
        }
        if let (Some(at), Some(size)) = (span("size"), export.size) {
            let problem = match export.preset {
                Some(preset) => preset.size_problem(size),
                None => {
                    let help = "set the size of the [grid], or choose preset = \"unreal\" or \"unity\"".to_owned();
                    Some(("`size` belongs to presets".to_owned(), help))
                }
            };
            if let Some((message, help)) = problem {
                self.out.push(Diagnostic::at(at, message, "this size").help(help));
            }
        }
        if let (Some(at), Some([low, high])) = (span("range"), export.range)
            && low >= high
        {
            let message = format!("`range` goes from {low} to {high}");
            self.out.push(Diagnostic::at(at, message, "this range").help("give the lower number first"));
        }
    }

    fn no_view(&self, name: &str, span: Span) -> Diagnostic {
        let views = self.views.iter().map(String::as_str);
        let known: Vec<&str> = What::ALL.iter().map(What::name).chain(views).collect();
        let help = match nearest(name, known.iter().copied()) {
            Some(n) => format!("did you mean \"{n}\"?"),
            None => format!("`what` may be {}", alternatives(known)),
        };
        Diagnostic::at(span, format!("no step leaves something that is called `{name}`"), "unknown").help(help)
    }

    fn no_layer(&self, name: &str, span: Span) -> Diagnostic {
        let help = match nearest(name, self.layers.iter().map(String::as_str)) {
            Some(n) => format!("did you mean `{n}`?"),
            None if self.layers.is_empty() => "no step has made a layer yet".to_owned(),
            None => format!("the steps make {}", alternatives(self.layers.iter().map(String::as_str))),
        };
        Diagnostic::at(span, format!("no step makes a layer `{name}`"), "unknown layer").help(help)
    }

    /// Worlds that do not fit in one piece must be such that they can be streamed.
    fn memory(&mut self, doc: &Node, grid: Option<Grid>, steps: &[Step], exports: &[Export], view: &View) {
        let (Some(node), Some(grid)) = (doc.get("grid"), grid) else { return };
        if self.layers.len() > self.limits.max_layers {
            let message = format!("{} layers exceed the limit of {}", self.layers.len(), self.limits.max_layers);
            self.out.push(Diagnostic::whole(message));
        }
        let size = node.get("size").map_or_else(|| node.span.clone(), |n| n.span.clone());
        let layers = match self.layers.len() {
            1 => "1 layer".to_owned(),
            n => format!("{n} layers"),
        };
        let what = format!("this recipe with {layers} of {} x {} cells", grid.width, grid.height);
        let outputs = self.registry.outputs();
        match memory::obstacle(steps, exports, &grid) {
            // A step that is wrong has no memory that could be known.
            Some(obstacle) if self.out.is_empty() => {
                let peak = match memory::working(steps, &grid) {
                    Ok(peak) => peak,
                    Err(e) => return self.out.push(Diagnostic::at(size, e, "this grid")),
                };
                let what =
                    peak.step.map_or_else(|| what.clone(), |s| format!("step {} ({}) of {what}", s.number, s.name));
                if let Err(e) = self.limits.check_bytes(&what, peak.bytes) {
                    self.too_large(doc, size, &obstacle, &e);
                }
                self.output_memory(doc, &grid, peak.world_bytes, exports, view);
            }
            None if self.out.is_empty() => {
                let whole = match memory::whole(steps, exports, view, &grid, outputs, self.limits) {
                    Ok(bytes) if bytes <= u128::from(self.limits.max_bytes) => return,
                    Ok(bytes) => bytes,
                    Err(e) => return self.out.push(Diagnostic::at(size, e, "this grid")),
                };
                // A program that cannot stream needs all of it.
                let needed = outputs.streamed(steps, &grid).and_then(|streamed| match streamed {
                    Some(s) => {
                        let what = format!("{what}, even streamed,");
                        self.limits.check_bytes(&what, s.held + s.writers).map(|()| (s.overview, s.held))
                    }
                    None => self.limits.check_bytes(&what, whole).map(|()| (grid, whole)),
                });
                match needed {
                    Ok((coarse, held)) => self.output_memory(doc, &coarse, held, exports, view),
                    Err(e) => {
                        let help = remedy!["choose fewer cells, or raise the limit with ", Setting::MaxMemory];
                        self.out.push(Diagnostic::at(size, e, "this grid").help(help));
                    }
                }
            }
            _ => {}
        }
    }

    fn too_large(&mut self, doc: &Node, size: Span, obstacle: &Obstacle, e: &Error) {
        let item = match obstacle.place {
            Place::Step(number) => doc.get("step").and_then(|n| n.elements().get(number - 1)),
            Place::Export(i) => doc.get("export").and_then(|n| n.elements().get(i)),
        };
        let span = item.map_or(size, |n| n.span.clone());
        let message = remedy![format!("{}, and there is not enough: ", obstacle.reason), e.sentence()];
        let help = remedy![
            "choose fewer cells, raise the limit with ",
            Setting::MaxMemory,
            ", or switch this off: a world that is only generated and written as rasters, masks, splat maps or maps is \
             streamed",
        ];
        self.out.push(Diagnostic::at(span, message, "this does not fit").help(help));
    }

    /// Pictures and meshes of a grid beside what is held already.
    fn output_memory(&mut self, doc: &Node, grid: &Grid, held: u128, exports: &[Export], view: &View) {
        if !self.out.is_empty() {
            return;
        }
        let place = |n: Option<&Node>| n.or(doc.get("grid")).unwrap_or(doc).span.clone();
        let outputs = self.registry.outputs();
        if view.enabled
            && let Err(e) = memory::check_bytes(
                "drawing the pictures of this world",
                held + outputs.pictures(grid, view),
                self.limits,
                memory::picture_remedy(),
            )
        {
            self.out.push(Diagnostic::at(place(doc.get("view")), e, "these pictures"));
        }
        for (i, export) in exports.iter().enumerate().filter(|(_, e)| e.enabled) {
            let what = format!("making `{}`", export.files()[0]);
            let bytes = held + outputs.export(grid, export, self.limits);
            if let Err(e) = memory::check_bytes(&what, bytes, self.limits, memory::export_remedy()) {
                let item = doc.get("export").and_then(|x| x.elements().get(i));
                self.out.push(Diagnostic::at(place(item), e, "this export"));
            }
        }
    }
}

/// The table as JSON without some keys.
pub(super) fn without(node: &Node, keys: &[&str]) -> Value {
    let entries = node.entries().iter().filter(|(k, _)| !keys.contains(&k.name.as_str()));
    Value::Object(entries.map(|(k, v)| (k.name.clone(), v.to_json())).collect())
}
