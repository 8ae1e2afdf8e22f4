//! How a recipe comes from a document.

use crate::diagnostic::Problems;
use crate::doc::RecipeDoc;
use crate::recipe::{Overrides, Recipe, RecipeSource, Texts};
use crate::registry::Registry;
use crate::validate;
use eyot_core::Limits;

impl Recipe {
    /// Checks a document and makes a recipe of it.
    ///
    /// # Errors
    /// Everything that is wrong with it, in one go.
    pub fn parse(
        source: RecipeSource,
        overrides: Overrides,
        registry: &Registry,
        limits: &Limits,
    ) -> Result<Self, Problems> {
        validate::recipe(source, overrides, registry, limits, Texts::new())
    }

    /// As [`Recipe::parse`], with text files that were read before: those are not asked for again.
    ///
    /// # Errors
    /// As [`Recipe::parse`].
    pub fn parse_with(
        source: RecipeSource,
        overrides: Overrides,
        registry: &Registry,
        limits: &Limits,
        texts: Texts,
    ) -> Result<Self, Problems> {
        validate::recipe(source, overrides, registry, limits, texts)
    }

    /// Checks a document that was built in code. What is wrong points into [`RecipeDoc::to_toml`].
    ///
    /// # Errors
    /// As [`Recipe::parse`].
    pub fn check(
        doc: &RecipeDoc,
        overrides: Overrides,
        registry: &Registry,
        limits: &Limits,
    ) -> Result<Self, Problems> {
        Self::parse(doc.source(), overrides, registry, limits)
    }
}
