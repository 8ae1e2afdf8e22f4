//! The literature and the data that a landscape owes something to, from `references.bib`.

use crate::builtin;
use crate::recipe::{Recipe, Work};
use crate::registry::Registry;
use biblatex::{Bibliography, ChunksExt, Entry, RawBibliography};
use serde_json::{Value, json};

/// The project's literature, BibTeX.
pub const REFERENCES: &str = include_str!("../references.bib");

/// What stands behind parts of the engine that no recipe names: the part, and keys.
const ENGINE: [(&str, &[&str]); 4] = [
    ("Eyot", &["eyot"]),
    ("random numbers", &["steele2014"]),
    ("elementary functions", &["moshier1992"]),
    ("statistics of terrain", &["barnes2014", "jasiewicz2013"]),
];

/// One source.
#[derive(Clone, Debug, PartialEq)]
pub struct Citation {
    /// Key in `references.bib`.
    pub key: String,
    /// What uses it: `Eyot`, and names of generators, processes and built-in data.
    pub used_by: Vec<String>,
    /// One line for a list of references.
    pub text: String,
    /// The BibTeX entry as it stands in the file.
    pub bibtex: &'static str,
    /// The source as CSL-JSON, which reference managers read.
    pub csl: Value,
}

/// What a recipe owes something to.
#[derive(Clone, Debug, PartialEq)]
pub struct Citations {
    /// Eyot first, then in the recipe's order, each once.
    pub sources: Vec<Citation>,
    /// Files of the user's own, whose sources only the user knows.
    pub files: Vec<String>,
}

/// The sources of all generators, processes and built-in data that a recipe uses; what is switched off does not count.
///
/// # Errors
/// If a key is not in `references.bib`, or the file cannot be read: a mistake in Eyot.
pub fn cite(recipe: &Recipe) -> Result<Citations, String> {
    let mut uses = Uses::default();
    uses.add("Eyot", &["eyot"]);
    let mut files = Vec::new();
    for step in recipe.enabled_steps() {
        match &step.work {
            Work::Generate(g) => {
                uses.add(g.entry.name, g.entry.cites);
                let Some(file) = g.parameters["file"].as_str() else { continue };
                match file.strip_prefix("builtin:").and_then(builtin::data) {
                    Some(data) => uses.add(data.name, data.cites),
                    None if files.iter().any(|f| f == file) => {}
                    None => files.push(file.to_owned()),
                }
            }
            Work::Simulate(s) => {
                s.processes.iter().filter(|p| p.enabled).for_each(|p| uses.add(p.actor.name(), p.actor.cites()))
            }
        }
    }
    Ok(Citations { sources: uses.look_up()?, files })
}

/// All sources of Eyot and what uses them, by key.
///
/// # Errors
/// As [`cite`].
pub fn all_citations(registry: &Registry) -> Result<Vec<Citation>, String> {
    let mut uses = Uses::default();
    ENGINE.iter().for_each(|(part, keys)| uses.add(part, keys));
    registry.generators().iter().for_each(|e| uses.add(e.name, e.cites));
    registry.processes().iter().for_each(|e| uses.add(e.name, e.cites));
    builtin::DATA.iter().for_each(|d| uses.add(d.name, d.cites));
    let mut all = uses.look_up()?;
    all.sort_by(|a, b| a.key.cmp(&b.key));
    Ok(all)
}

/// Keys in the order of their first use, with their users.
#[derive(Default)]
struct Uses(Vec<(&'static str, Vec<String>)>);

impl Uses {
    fn add(&mut self, user: &str, keys: &[&'static str]) {
        for key in keys {
            let at = self.0.iter().position(|(k, _)| k == key).unwrap_or_else(|| {
                self.0.push((key, Vec::new()));
                self.0.len() - 1
            });
            let users = &mut self.0[at].1;
            if users.iter().all(|u| u != user) {
                users.push(user.to_owned());
            }
        }
    }

    fn look_up(self) -> Result<Vec<Citation>, String> {
        let library = Bibliography::parse(REFERENCES).map_err(|e| format!("references.bib: {e}"))?;
        let raw = RawBibliography::parse(REFERENCES).map_err(|e| format!("references.bib: {e}"))?;
        let find = |key: &str| {
            let entry = library.get(key)?;
            // The parser's span ends before the closing brace.
            let from = &REFERENCES[raw.entries.iter().find(|e| e.v.key.v == key)?.span.start..];
            Some((entry, from.split_inclusive("\n}").next()?))
        };
        self.0
            .into_iter()
            .map(|(key, used_by)| {
                let (entry, bibtex) = find(key).ok_or_else(|| format!("references.bib has no entry `{key}`"))?;
                Ok(Citation { key: key.to_owned(), used_by, text: text(entry), bibtex, csl: csl(entry) })
            })
            .collect()
    }
}

impl Citations {
    /// A list of references, one a paragraph, with what uses them.
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        for c in &self.sources {
            out += &format!("{}\n    [{}]\n", c.text, c.used_by.join(", "));
        }
        for file in &self.files {
            out += &format!("{file}: your own data; its source is yours to cite\n");
        }
        out
    }

    /// The entries of `references.bib`.
    pub fn to_bibtex(&self) -> String {
        self.sources.iter().map(|c| c.bibtex.trim()).collect::<Vec<_>>().join("\n\n")
    }

    /// A list of CSL-JSON items; `note` says what uses each.
    pub fn to_json(&self) -> Value {
        self.sources
            .iter()
            .map(|c| {
                let mut item = c.csl.clone();
                item["note"] = json!(format!("used by {}", c.used_by.join(", ")));
                item
            })
            .collect()
    }
}

/// The first of these fields that an entry has, without TeX and with plain hyphens.
fn field(entry: &Entry, names: &[&str]) -> Option<String> {
    names.iter().find_map(|n| entry.get(n)).map(|c| c.format_verbatim().replace('\u{2013}', "-"))
}

/// Where a work appeared.
const CONTAINERS: [&str; 2] = ["journal", "booktitle"];
const PUBLISHERS: [&str; 2] = ["publisher", "institution"];

/// `Authors Year: Title. Container 12(3), 1-9. Publisher. Note. doi:...`
fn text(entry: &Entry) -> String {
    let people = entry.author().unwrap_or_default();
    let names: Vec<String> = people.iter().map(|p| format!("{} {}", p.given_name, p.name).trim().to_owned()).collect();
    let names = match names.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        // Long lists are cut, as reference styles do.
        [first, .., _] if names.len() > 6 => format!("{first} et al."),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    };
    let mut out = format!("{names} ({}): ", field(entry, &["year"]).unwrap_or_default());
    out += &field(entry, &["title"]).unwrap_or_default();
    out.push('.');
    if let Some(container) = field(entry, &CONTAINERS) {
        out += &format!(" {container}");
        out += &field(entry, &["volume"]).map_or(String::new(), |v| format!(" {v}"));
        out += &field(entry, &["number"]).map_or(String::new(), |n| format!("({n})"));
        out += &field(entry, &["pages"]).map_or(String::new(), |p| format!(", {p}"));
        out.push('.');
    }
    for name in ["publisher", "institution", "note"] {
        out += &field(entry, &[name]).map_or(String::new(), |v| format!(" {}.", v.trim_end_matches('.')));
    }
    out += &field(entry, &["doi"]).map_or(String::new(), |d| format!(" doi:{d}"));
    out
}

/// The entry as an item of CSL-JSON.
fn csl(entry: &Entry) -> Value {
    let kind = match entry.entry_type.to_string().as_str() {
        "article" => "article-journal",
        "incollection" => "chapter",
        "inproceedings" => "paper-conference",
        "book" => "book",
        "techreport" | "report" => "report",
        "phdthesis" | "mastersthesis" | "thesis" => "thesis",
        "software" => "software",
        "dataset" => "dataset",
        _ => "document",
    };
    let mut item = json!({ "id": entry.key, "type": kind });
    let people = entry.author().unwrap_or_default();
    let person = |p: &biblatex::Person| match p.given_name.as_str() {
        "" => json!({ "literal": p.name }),
        given => json!({ "family": p.name, "given": given }),
    };
    item["author"] = people.iter().map(person).collect();
    if let Some(year) = field(entry, &["year"]).and_then(|y| y.parse::<i32>().ok()) {
        item["issued"] = json!({ "date-parts": [[year]] });
    }
    let fields: [(&str, &[&str]); 8] = [
        ("title", &["title"]),
        ("container-title", &CONTAINERS),
        ("volume", &["volume"]),
        ("issue", &["number"]),
        ("page", &["pages"]),
        ("edition", &["edition"]),
        ("publisher", &PUBLISHERS),
        ("DOI", &["doi"]),
    ];
    for (key, names) in fields {
        if let Some(value) = field(entry, names) {
            item[key] = json!(value);
        }
    }
    item
}
