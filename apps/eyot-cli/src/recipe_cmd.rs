//! `new`, `check` and `cite`: recipe files.

use crate::args::{Change, Check, Cite, CiteFormat, New};
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::{Limits, Overrides, Preset, Recipe, RecipeSource, Registry, RunOptions, Work};
use std::io::Write;

/// Writes a recipe file to start from.
pub(crate) fn new(args: &New) -> Result<(), Failure> {
    let known: Vec<&str> = eyot::RECIPES.iter().map(|r| r.name).collect();
    let Some(from) = eyot::RECIPES.iter().find(|r| r.name == args.from) else {
        let help = match eyot::nearest(&args.from, known.iter().copied()) {
            Some(n) => format!("did you mean --from {n}?"),
            None => format!("there is: {}", known.join(", ")),
        };
        return Err(report::usage(&format!("there is no built-in recipe `{}`", args.from), &help));
    };
    if args.name.file_name().is_none() {
        return Err(report::usage(
            &format!("`{}` is no name of a file", args.name.display()),
            "for example: eyot new mine",
        ));
    }
    let mut path = args.name.clone();
    if path.extension().is_none_or(|e| e != "toml") {
        path.as_mut_os_string().push(".toml");
    }
    let refuse = |e: std::io::Error| {
        let message = format!("cannot write `{}`: {e}", path.display());
        if e.kind() == std::io::ErrorKind::AlreadyExists {
            return report::usage(&message, "choose another name, or remove the file first: nothing is overwritten");
        }
        let help = "choose a place that exists, that you may write to, and that has room";
        Failure::Failed(report::plain(&message, Some(help.to_owned())))
    };
    let mut file = std::fs::OpenOptions::new().write(true).create_new(true).open(&path).map_err(refuse)?;
    if let Err(e) = file.write_all(from.text.as_bytes()).and_then(|()| file.sync_all()) {
        // The name must be free again when there is room; what else can be done about a file that cannot be removed?
        let _ = std::fs::remove_file(&path);
        return Err(refuse(e));
    }
    print::line(&format!("wrote {}; run it with: eyot run {}", path.display(), eyot::shell_word(&path)))
}

/// Checks a recipe and says what it would do.
pub(crate) fn check(args: &Check) -> Result<(), Failure> {
    let recipe = read(&args.recipe, &args.change, &args.shape.preset)?;
    let options =
        RunOptions { limits: limits(args.change.max_memory), stream: args.shape.stream, ..RunOptions::default() };
    eyot::Run::check(&recipe, &options).map_err(|e| report::run(&e))?;
    if args.effective {
        return print::line(recipe.effective_toml().trim_end());
    }
    let g = recipe.grid;
    let (w_m, h_m) = g.extent_m();
    let mut text = format!(
        "{}: {} x {} cells of {} ({:.2} x {:.2} km)\n",
        recipe.name,
        g.width,
        g.height,
        print::cell(g.cell_x_m, g.cell_y_m),
        w_m / 1e3,
        h_m / 1e3
    );
    for step in &recipe.steps {
        let what = match &step.work {
            Work::Generate(g) => format!("generate {} -> {}", g.entry.name, g.layer),
            Work::Simulate(s) => {
                let names: Vec<&str> = s.processes.iter().filter(|p| p.enabled).map(|p| p.actor.name()).collect();
                format!("simulate {} for {} steps", names.join(", "), s.steps)
            }
        };
        let off = if step.enabled { "" } else { " (switched off)" };
        text += &format!("  {}. {}: {what}{off}\n", step.number, step.name);
    }
    let doubts = recipe.doubts();
    if doubts.is_empty() {
        return print::line(&(text + "the recipe is sound"));
    }
    doubts.iter().for_each(|d| text += &format!("  doubt: {}\n", d.worded(&CommandLine)));
    print::line(&(text + "the recipe can be run"))
}

/// Says what a recipe rests on.
pub(crate) fn cite(args: &Cite) -> Result<(), Failure> {
    let recipe = read(&args.recipe, &args.change, &[])?;
    let citations = eyot::cite(&recipe).map_err(|m| Failure::Failed(report::plain(&m, None)))?;
    match args.format {
        CiteFormat::Text => print::line(citations.to_text().trim_end()),
        CiteFormat::Bibtex => print::line(&citations.to_bibtex()),
        CiteFormat::Json => print::line(&format!("{:#}", citations.to_json())),
    }
}

/// Reads a recipe with the changes of the command line.
pub(crate) fn read(name: &str, change: &Change, presets: &[Preset]) -> Result<Recipe, Failure> {
    let source = RecipeSource::find(name).map_err(|p| report::recipe(&p))?;
    let mut set = change.set.clone();
    set.extend(change.seed.map(|s| format!("seed={s}")));
    let overrides = Overrides { set, size: change.size, presets: presets.to_vec() };
    Recipe::parse(source, overrides, &Registry::standard(), &limits(change.max_memory)).map_err(|p| report::recipe(&p))
}

/// The limits with another bound on memory.
pub(crate) fn limits(max_memory: Option<u64>) -> Limits {
    let d = Limits::default();
    match max_memory {
        // Four bytes a value: more cells than this cannot fit.
        Some(b) => Limits { max_bytes: b, max_cells: d.max_cells.max(b / 4), ..d },
        None => d,
    }
}
