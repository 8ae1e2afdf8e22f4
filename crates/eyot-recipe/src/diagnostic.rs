//! What is wrong with a recipe, where, and what would be right.
//!
//! The facade only collects; a front end decides how to show it. [`Problems`] displays itself as plain text, the command
//! line draws the source around the place.

use crate::node::Span;
use eyot_core::Remedy;
use std::fmt;
use std::sync::Arc;

/// A text that a span points into: the recipe, or a change of it such as `grid.cell=5`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// File name, or [`Source::SET`].
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// One sentence: what is wrong.
    pub message: Remedy,
    /// Short text at the place itself.
    pub label: String,
    /// What would be right.
    pub help: Option<Remedy>,
    /// The place, if there is one.
    pub span: Option<Span>,
}

impl Source {
    /// Name of the texts that are changes of a recipe.
    pub const SET: &str = "set";
}

impl Diagnostic {
    /// A diagnostic at a place.
    pub fn at(span: Span, message: impl Into<Remedy>, label: impl Into<String>) -> Self {
        Self { message: message.into(), label: label.into(), help: None, span: Some(span) }
    }

    /// A diagnostic about the document as a whole.
    pub fn whole(message: impl Into<Remedy>) -> Self {
        Self { message: message.into(), label: String::new(), help: None, span: None }
    }

    /// The same with a remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<Remedy>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// Problems that are told; the others follow from these, or are of the same kind.
const MOST: usize = 20;
/// Problems after which nothing more is looked for.
pub(crate) const ENOUGH: usize = 200;
/// Words that a list of alternatives names.
const MOST_WORDS: usize = 60;

/// What is wrong with a recipe, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems {
    /// The texts; spans name them by index. The first is the recipe.
    pub sources: Arc<Vec<Source>>,
    /// At least one, and the first twenty.
    pub diagnostics: Vec<Diagnostic>,
    /// How many there are beside these, at least.
    pub more: usize,
}

impl Problems {
    /// Problems in the order of the text.
    pub fn new(sources: Vec<Source>, mut diagnostics: Vec<Diagnostic>) -> Self {
        diagnostics.sort_by_key(|d| d.span.as_ref().map_or((usize::MAX, 0), |s| (s.source, s.start)));
        diagnostics.dedup();
        let more = diagnostics.len().saturating_sub(MOST);
        diagnostics.truncate(MOST);
        Self { sources: Arc::new(sources), diagnostics, more }
    }

    /// A line on those that are not told, if there are any.
    pub fn rest(&self) -> Option<String> {
        let at_least = if self.more + MOST >= ENOUGH { "at least " } else { "" };
        (self.more > 0).then(|| format!("and {at_least}{} more; mend these first", self.more))
    }

    /// The source that a span points into.
    pub fn source(&self, span: &Span) -> Option<&Source> {
        self.sources.get(span.source)
    }

    /// Line and column of a span's start, both counted from 1; the column counts characters.
    pub fn line_column(&self, span: &Span) -> (usize, usize) {
        let text = self.source(span).map_or("", |s| s.text.as_str());
        let before = &text[..text.floor_char_boundary(span.start)];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        (line, column)
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, d) in self.diagnostics.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            let place = d.span.as_ref().and_then(|s| Some((s, self.source(s)?)));
            if let Some((span, source)) = place {
                let (line, column) = self.line_column(span);
                write!(f, "{}:{line}:{column}: ", source.name)?;
            } else if let Some(first) = self.sources.first() {
                write!(f, "{}: ", first.name)?;
            }
            write!(f, "{}", d.message)?;
            if !d.label.is_empty() {
                write!(f, " ({})", d.label)?;
            }
            if let Some(help) = &d.help {
                write!(f, "\n  help: {}", help.to_string().replace('\n', "\n        "))?;
            }
        }
        if let Some(rest) = self.rest() {
            write!(f, "\n{rest}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// The candidate that `word` most likely was meant to be, if any is near enough.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    candidates
        .into_iter()
        .map(|c| {
            let contained = c.len() >= 4 && lower.len() >= 4 && (c.contains(&lower) || lower.contains(c));
            (if contained { 1 } else { strsim::damerau_levenshtein(&lower, c) }, c)
        })
        .filter(|(d, c)| *d <= (c.chars().count().max(lower.chars().count()) / 3).max(1))
        .min_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(b.1)))
        .map(|(_, c)| c)
}

/// `a, b or c`.
pub fn alternatives<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let mut all = words.into_iter();
    let mut words: Vec<String> = all.by_ref().take(MOST_WORDS).map(|w| format!("`{w}`")).collect();
    let more = all.count();
    if more > 0 {
        words.push(format!("{more} others"));
    }
    match words.split_last() {
        None => "nothing".to_owned(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_and_nonsense_is_not() {
        let names = ["hydraulic", "thermal", "reef"];
        assert_eq!(nearest("hydralic", names), Some("hydraulic"));
        assert_eq!(nearest("Thermal", names), Some("thermal"));
        assert_eq!(nearest("reefs", names), Some("reef"));
        assert_eq!(nearest("zebra", names), None);
    }

    #[test]
    fn columns_count_characters() {
        let p = Problems::new(vec![Source { name: "a".into(), text: "é=1\nñx=2".into() }], vec![]);
        assert_eq!(p.line_column(&Span { source: 0, start: 7, end: 8 }), (2, 2));
    }
}
