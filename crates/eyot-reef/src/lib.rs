//! The living reef of Eyot: a community of corals, and grammars that grow their branches.
//!
//! [`community`] simulates single colonies, macroalgae and turf on a plot, month by month. It opens no files: temperatures come as
//! text that somebody else has read, rasters of the ground as fields, and results are rows of numbers. [`lsystem`] derives words
//! from grammars and draws them. [`bodies`] gives every colony a body of triangles.
//!
//! ```
//! use eyot_reef::community::{Community, Forcing, Plot, Site};
//!
//! let community = Community::default();
//! let forcing = Forcing::chumbe(&community, 1)?;
//! let mut plot = Plot::new(community, Site::flat(10.0, 10.0), forcing, 1)?;
//! let mut cover = 0.0;
//! for _ in 0..24 {
//!     cover = plot.month()?.coral_cover();
//! }
//! assert!(cover > 0.0 && cover < 1.0);
//! # Ok::<(), eyot_core::Error>(())
//! ```

pub mod bodies;
pub mod community;
pub mod corals;
pub mod lsystem;
mod skeleton;

use corals::CORALS;
use eyot_core::ComponentKind;
use eyot_core::process::{Entry, Process};

/// Every process of this crate, by its name in recipes.
pub const PROCESSES: &[Entry<dyn Process>] = &[CORALS];

/// Every kind of components that they keep in worlds.
pub static COMPONENTS: [&ComponentKind; 1] = [&community::POPULATION];
