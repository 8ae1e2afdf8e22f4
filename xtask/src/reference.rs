//! The pages of the book that are made from the schema and the heads of source files.
//!
//! A comment `<!-- made: NAME -->` in a chapter is replaced by what is made for it; generators and processes get a page each.

use eyot::{Citation, Description, Expression, ParameterInfo, Registry, all_citations, describe};
use eyot_core::LayerSpec;
use mdbook_driver::book::{Book, BookItem, Chapter, SectionNumber};
use mdbook_driver::errors::{Error, Result};
use mdbook_preprocessor::{Preprocessor, PreprocessorContext};
use std::fmt::Write;

/// Tables of a recipe in the order of the reference, with what they are.
const TABLES: [(&str, &str); 11] = [
    ("recipe", "The head of the document"),
    ("grid", "`[grid]`"),
    ("material", "`[[material]]`"),
    ("layer", "`[[layer]]`"),
    ("rule", "`[[rule]]`"),
    ("expressions", "Expressions of layers and rules"),
    ("generate", "`[[step]]` that generates"),
    ("simulate", "`[[step]]` that simulates"),
    ("schedule", "A process in a step"),
    ("export", "`[[export]]`"),
    ("view", "`[view]`"),
];

/// Fills the reference in while mdBook builds the book.
pub(crate) struct Reference;

impl Preprocessor for Reference {
    fn name(&self) -> &str {
        "reference"
    }

    fn run(&self, _: &PreprocessorContext, mut book: Book) -> Result<Book> {
        let maker = Maker {
            registry: Registry::standard(),
            sources: all_citations(&Registry::standard()).map_err(Error::msg)?,
        };
        let mut failed = None;
        book.for_each_chapter_mut(|chapter| failed = failed.take().or(maker.fill(chapter).err()));
        match failed {
            Some(e) => Err(e),
            None => Ok(book),
        }
    }
}

struct Maker {
    registry: Registry,
    sources: Vec<Citation>,
}

impl Maker {
    /// Replaces the marks of a chapter, and adds the pages below it.
    fn fill(&self, chapter: &mut Chapter) -> Result<()> {
        while let Some((before, rest)) = chapter.content.split_once("<!-- made: ") {
            let (name, after) = rest.split_once(" -->").unwrap_or((rest, ""));
            let made = match name {
                "recipe" => self.tables()?,
                "generators" => self.list(self.registry.generator_names(), "generators")?,
                "processes" => self.list(self.registry.process_names(), "processes")?,
                "layers" => self.layers()?,
                "sources" => self.sources(),
                _ => return Err(Error::msg(format!("{}: nothing is made for `{name}`", chapter.name))),
            };
            let pages = match name {
                "generators" => self.pages(chapter, self.registry.generator_names(), name)?,
                "processes" => self.pages(chapter, self.registry.process_names(), name)?,
                _ => Vec::new(),
            };
            chapter.content = format!("{before}{made}{after}");
            chapter.sub_items.extend(pages);
        }
        Ok(())
    }

    fn describe(&self, name: &str) -> Result<Description> {
        describe(name, &self.registry).map_err(Error::msg)
    }

    /// All tables of a recipe.
    fn tables(&self) -> Result<String> {
        let mut out = String::new();
        for (name, title) in TABLES {
            let d = self.describe(name)?;
            writeln!(out, "## {title}\n\n{}\n", paragraphs(&d))?;
            out += &parameters(&d.parameters, 3)?;
        }
        Ok(out)
    }

    /// A table of names with their summaries.
    fn list(&self, names: impl Iterator<Item = &'static str>, folder: &str) -> Result<String> {
        let mut out = "| name | |\n| --- | --- |\n".to_owned();
        for name in names {
            writeln!(out, "| [`{name}`]({folder}/{name}.md) | {} |", cell(&self.describe(name)?.summary))?;
        }
        Ok(out)
    }

    /// A page for each name.
    fn pages(
        &self,
        parent: &Chapter,
        names: impl Iterator<Item = &'static str>,
        folder: &str,
    ) -> Result<Vec<BookItem>> {
        let above = [parent.parent_names.clone(), vec![parent.name.clone()]].concat();
        (1..)
            .zip(names)
            .map(|(i, name)| {
                let path = format!("reference/{folder}/{name}.md");
                let mut page = Chapter::new(name, self.page(name)?, path, above.clone());
                // The place in the table of contents.
                page.number = parent.number.as_ref().map(|n| SectionNumber::new([n.as_slice(), &[i]].concat()));
                Ok(BookItem::Chapter(page))
            })
            .collect()
    }

    /// The page of a generator or process.
    fn page(&self, name: &str) -> Result<String> {
        let d = self.describe(name)?;
        let mut out = format!("# {name}\n\n{}\n\n", paragraphs(&d));
        if crate::root().join(format!("docs/gallery/{name}.png")).exists() {
            writeln!(out, "![What `{name}` does](../../gallery/{name}.png)\n")?;
        }
        // Pictures of other choices, such as `fbm-value.png`.
        for (parameter, choice) in d.parameters.iter().flat_map(|p| p.choices.iter().map(move |c| (p, c))) {
            let file = format!("{name}-{}.png", choice.value);
            if crate::root().join("docs/gallery").join(&file).exists() {
                writeln!(out, "`{} = \"{}\"`:\n\n![{file}](../../gallery/{file})\n", parameter.name, choice.value)?;
            }
        }
        writeln!(out, "## Parameters\n\n{}", parameters(&d.parameters, 3)?)?;
        if d.kind == "process" {
            writeln!(out, "Written as `{name}.parameter` in the step; `every` and `enabled` say when it acts.\n")?;
        }
        // The head of the source file has sections of its own; on this page they are one level lower.
        let about = d.about.lines().map(|l| if l.starts_with('#') { format!("#{l}\n") } else { format!("{l}\n") });
        writeln!(out, "## How it works\n\n{}", about.collect::<String>())?;
        let cited: Vec<&Citation> = self.sources.iter().filter(|c| d.sources.contains(&c.key)).collect();
        if !cited.is_empty() {
            writeln!(out, "## References\n")?;
            cited.iter().try_for_each(|c| writeln!(out, "- {}", c.text))?;
        }
        Ok(out)
    }

    /// All layers of all processes with default parameters, and who uses them.
    fn layers(&self) -> Result<String> {
        let mut layers: Vec<(LayerSpec, Vec<String>)> = Vec::new();
        for entry in self.registry.processes() {
            let user = format!("[`{0}`](processes/{0}.md)", entry.name);
            for spec in (entry.make)((entry.defaults)())?.layers().into_iter().map(|l| l.spec) {
                match layers.iter_mut().find(|(s, _)| s.name == spec.name) {
                    Some((_, users)) => users.push(user.clone()),
                    None => layers.push((spec, vec![user.clone()])),
                }
            }
        }
        let mut out = "| layer | unit | meaning | used by |\n| --- | --- | --- | --- |\n".to_owned();
        for (spec, users) in layers {
            writeln!(
                out,
                "| `{}` | {} | {} | {} |",
                spec.name,
                cell(&spec.unit),
                cell(&spec.meaning),
                users.join(", ")
            )?;
        }
        Ok(out)
    }

    /// All sources, with what uses them.
    fn sources(&self) -> String {
        self.sources.iter().map(|c| format!("- {}  \n  `{}`: {}\n", c.text, c.key, c.used_by.join(", "))).collect()
    }
}

fn paragraphs(d: &Description) -> String {
    format!("{}\n\n{}", d.summary, d.details).trim_end().to_owned()
}

/// A table of parameters, and below it what their choices mean, under headings of a level.
fn parameters(parameters: &[ParameterInfo], level: usize) -> Result<String> {
    let mut out = "| name | takes | default | meaning |\n| --- | --- | --- | --- |\n".to_owned();
    for p in parameters {
        let takes = p.takes.strip_prefix("a number from ").unwrap_or(&p.takes);
        let unit = if p.unit == "1" { "" } else { &p.unit };
        let takes = format!("{takes} {unit}");
        let term = match p.expression {
            Expression::No => "",
            Expression::Time => "; or an expression of time",
            Expression::Cells => "; or an expression",
        };
        let tables = p.default_tables();
        let default = match (p.default.is_null(), tables.is_empty()) {
            (true, _) => String::new(),
            (false, true) => format!("`{}`", p.default),
            (false, false) => {
                let text = |(name, entries): &(String, Vec<String>)| format!("{name} `{}`", entries.join(", "));
                tables.iter().map(text).collect::<Vec<_>>().join("; ").trim().to_owned()
            }
        };
        writeln!(
            out,
            "| `{}` | {} | {} | {} |",
            p.name,
            cell(&format!("{}{term}", takes.trim())),
            cell(&default),
            cell(&p.meaning)
        )?;
    }
    for p in parameters.iter().filter(|p| p.choices.iter().any(|c| !c.meaning.is_empty())) {
        writeln!(out, "\n{} `{}`\n\n| choice | meaning |\n| --- | --- |", "#".repeat(level), p.name)?;
        p.choices.iter().try_for_each(|c| writeln!(out, "| `{}` | {} |", c.value, cell(&c.meaning)))?;
    }
    out.push('\n');
    Ok(out)
}

/// A text as a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}
