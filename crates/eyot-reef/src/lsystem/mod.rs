//! L-systems: grammars that grow lines, branches and plants.
//!
//! A [`Grammar`] derives words; a turtle draws them.
//!
//! ```
//! use eyot_core::Limits;
//! use eyot_reef::lsystem::Grammar;
//!
//! let plant = Grammar::parse("
//!     axiom: F
//!     angle: 25.7
//!     steps: 5
//!     F -> F[+F]F[-F]F
//! ")?;
//! let word = plant.derive(plant.steps, 1, &Limits::default())?;
//! let drawing = plant.draw(&word, 1, &Limits::default())?;
//! assert_eq!((word.len(), drawing.segments.len()), (7811, 3125));
//! # Ok::<(), eyot_core::Error>(())
//! ```
//!
//! # The format
//! Lines; `#` begins a comment line. A line with `->` is a rule, the others are settings `name: value`:
//!
//! | setting | meaning |
//! |---|---|
//! | `axiom: A(1)[+B]` | what derivation begins with |
//! | `steps: 5` | steps that the author suggests |
//! | `angle: 25` `step: 1` `width: 1` | turns in degrees, lengths and width where no number says something else |
//! | `thinning: 0.7` | what `!` without a number makes of the width |
//! | `draw: F L R` | symbols that draw a step; `F` if not given |
//! | `ignore: + - F` | symbols that contexts do not see |
//! | `tropism: 0 0 -1`, `elasticity: 0.1` | direction and strength of bending, radians a step |
//! | `define: R = 1.456` | a constant |
//! | `rules:` | rules from here on are productions, as they are at the beginning |
//! | `decomposition: 16` | rules from here on are applied after each step, at most so often |
//! | `interpretation: 16` | rules from here on are applied when the word is drawn |
//!
//! A symbol is one sign; a query is `?` and a letter. Numbers stand in parentheses: `F(2, w/2)`.
//!
//! A rule is `left < module > right : condition @ weight -> successor`; all but module and successor may be missing. Contexts skip
//! branches and ignored symbols; a right context may name branches in brackets. The first rule that fits is applied; if it has a
//! weight, one of all fitting rules with weights, by chance. Expressions know `+ - * / ^`, comparisons, `&& || !`, `sin cos` (of
//! degrees) `sqrt abs floor exp ln min max mod random(low, high)`.
//!
//! # The turtle
//! `F` draws a step, `f` moves; `+ -` turn left and right, `& ^` pitch down and up, `\ /` roll left and right, `|` turns round, `$`
//! rolls upright; `[ ]` begin and end a branch; `!` sets the width, `'` the colour; `{ . }` outline a shape; `%` cuts off the rest of
//! the branch; `?P ?H ?U ?L` ask for place and directions, other queries ask the environment. All else does nothing.
//!
//! # Source
//! Prusinkiewicz and Lindenmayer 1990; queries after Mech and Prusinkiewicz 1996.

mod context;
mod derive;
mod expression;
mod grammar;
mod text;
mod turtle;
mod word;

pub use grammar::{Grammar, Turtle};
pub use turtle::{Ask, Drawing, Polyline, Segment, Vector};
pub use word::{Symbol, Word};
