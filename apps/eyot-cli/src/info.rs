//! `list`, `describe`, `schema`: what there is and what it takes.

use crate::args::{Describe, List};
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::Registry;
use serde_json::json;

/// Recipes, generators and processes with one line each.
pub(crate) fn list(args: &List) -> Result<(), Failure> {
    let registry = Registry::standard();
    let summary = |name: &str| eyot::describe(name, &registry).map(|d| d.summary).unwrap_or_default();
    let recipes: Vec<(String, String)> = eyot::RECIPES.iter().map(|r| (r.name.to_owned(), r.about())).collect();
    let generators: Vec<(String, String)> = registry.generator_names().map(|n| (n.to_owned(), summary(n))).collect();
    let processes: Vec<(String, String)> = registry.process_names().map(|n| (n.to_owned(), summary(n))).collect();
    let layers = eyot::describe("layers", &registry).map(|d| d.parameters).unwrap_or_default();
    let layers: Vec<(String, String)> = layers
        .into_iter()
        .map(|l| (l.name, l.meaning.split_once('.').map_or(String::new(), |(what, _)| format!("{what} ({})", l.unit))))
        .collect();
    let groups = [("recipes", recipes), ("generators", generators), ("processes", processes), ("layers", layers)];
    if args.json {
        let object: serde_json::Map<String, serde_json::Value> = groups
            .iter()
            .map(|(group, all)| {
                ((*group).to_owned(), all.iter().map(|(name, about)| json!({ "name": name, "about": about })).collect())
            })
            .collect();
        return print::line(&serde_json::Value::Object(object).to_string());
    }
    for (group, all) in groups {
        let heading = match group {
            "recipes" => "Recipes (eyot run NAME, eyot new MINE --from NAME)",
            "generators" => "Generators (generate = \"NAME\", eyot describe NAME)",
            "processes" => "Processes (simulate = [\"NAME\"], eyot describe NAME)",
            _ => "Layers (eyot describe layers)",
        };
        print::line(heading)?;
        for (name, about) in all {
            print::line(&format!("  {name:<14} {about}"))?;
        }
        print::line(" ")?;
    }
    Ok(())
}

/// What a generator, process or table takes.
pub(crate) fn describe(args: &Describe) -> Result<(), Failure> {
    let found = eyot::describe(&args.name, &Registry::standard())
        .map_err(|m| report::usage(&m, "`eyot list` shows everything"))?;
    if args.json {
        let text =
            serde_json::to_string_pretty(&found).map_err(|e| Failure::Failed(report::plain(&e.to_string(), None)))?;
        return print::line(&text);
    }
    print::line(&found.worded(&CommandLine))
}

/// The JSON Schema of recipes.
pub(crate) fn schema() -> Result<(), Failure> {
    print::line(&format!("{:#}", eyot::recipe_schema(&Registry::standard())))
}
