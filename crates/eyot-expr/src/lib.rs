//! Layers and rules of a recipe's own: expressions over layers, checked and made into programs for both engines.
//!
//! A [`RuleDefinition`] holds texts such as `clamp(0.98 * wetness + 0.02 * step(0.01, water), 0, 1)`. [`rule`] reads them, checks
//! names, types, units and limits, and gives a [`TextRule`]: a [`Program`](eyot_core::program::Program) with what it needs to
//! be a process. A [`Term`] is a parameter of a built-in process as such a text. A [`ParseError`] knows its place in the text to the character. [`functions::FUNCTIONS`] and
//! [`functions::NAMES`] are all that the language knows beside layers and parameters.
//!
//! The way of a text: `token` and `syntax` make a tree of it, `meaning` finds out what the names are and whether
//! the types and units fit, `evaluate` computes a checked formula in any kind of number: on single cells as the reference, and on
//! graph nodes, which makes the program.

mod evaluate;
pub mod functions;
mod parse_error;
mod rule;
mod syntax;
mod term;
#[cfg(test)]
mod tests;
mod token;
mod typecheck;
mod unit;

pub use parse_error::{ParseError, Part, Problem};
pub use rule::{DeclaredLayer, ExprProcess, LayerDefinition, RuleDefinition, TextRule, layer, rule};
pub use term::{Obstacle, ParameterizedProcess, Term, TermDefinition, Terms, numbers, of_schema, term};
pub use typecheck::{Known, Scope};
pub use unit::check as check_unit;

/// Longest text of an expression, bytes.
pub const MAX_BYTES: usize = 4096;
/// Most numbers, names, calls and operators of a text.
pub const MAX_ITEMS: usize = 512;
/// Deepest nesting of parentheses, calls and signs.
pub const MAX_DEPTH: usize = 40;

/// Reads a text without looking at what its names mean; for tests that feed the parser.
///
/// # Errors
/// The first mistake.
pub fn parse(text: &str) -> Result<(), ParseError> {
    syntax::Text::parse(text).map(drop)
}
