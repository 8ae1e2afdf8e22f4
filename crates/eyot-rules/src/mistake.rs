//! What is wrong with a text, and where.

use eyot_core::Remedy;
use std::ops::Range;

/// A mistake in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// Its bytes in the text.
    pub span: Range<usize>,
    /// One sentence: what is wrong.
    pub message: String,
    /// Short text at the place itself.
    pub label: String,
    /// What would be right.
    pub help: Option<Remedy>,
    /// Where a name is unknown: the name, and those that there are.
    pub unknown: Option<Box<(String, Vec<String>)>>,
}

impl Mistake {
    pub(crate) fn at(span: &Range<usize>, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self { span: span.clone(), message: message.into(), label: label.into(), help: None, unknown: None }
    }

    #[must_use]
    pub(crate) fn help(mut self, help: impl Into<Remedy>) -> Self {
        self.help = Some(help.into());
        self
    }

    #[must_use]
    pub(crate) fn among(mut self, name: &str, known: Vec<String>) -> Self {
        self.unknown = Some(Box::new((name.to_owned(), known)));
        self
    }
}

/// Which text of a layer or rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// The start value of a layer.
    Start,
    /// The new value of this layer.
    Value(String),
    /// Where the rule applies.
    Mask,
    /// The layer or rule as a whole; the mistake has no place.
    Whole,
}

/// A mistake and the text that it is in.
pub type Problem = (Part, Mistake);
