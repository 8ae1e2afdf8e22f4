//! Drainage: where water goes on a landscape. Depressions, receivers, drained areas.
//!
//! Everything here works on heights in metres, row by row from the north-west, in `f32` or `f64`, together with their
//! [`eyot_core::Grid`]: neighbours are the eight around a cell, a wrapping axis is a ring, other rims end. Heights must
//! be finite. The usual chain is
//!
//! ```
//! use eyot_core::{Control, Grid, Limits, Boundary};
//! use eyot_drainage::{Base, Routing, fill, outlets};
//!
//! let grid = Grid::new(64, 64, 30.0, Boundary::OPEN, &Limits::default())?;
//! let mut height: Vec<f32> = (0..grid.cells()).map(|i| (i * 7919 % 101) as f32).collect();
//! let outlets = outlets(&height, &grid, &Base::default())?;
//! fill(&mut height, &grid, &outlets, &Control::none())?;
//! let routing = Routing::new(&height, &grid, &outlets, &Control::none())?;
//! let cells = routing.upstream_cells();
//! let drained: u32 = (0..grid.cells()).filter(|&i| routing.is_outlet(i)).map(|i| cells[i]).sum();
//! assert_eq!(drained as usize, grid.cells());
//! # Ok::<(), eyot_core::Error>(())
//! ```

mod accumulate;
mod bands;
mod breach;
mod cascade;
mod descent;
mod dinf;
mod fill;
mod flats;
mod height;
mod hierarchy;
mod land;
mod multiple;
mod neighbours;
mod outlets;
mod place;
mod routing;
mod spill;
mod spread;
mod steepest;
mod tilt;

pub use breach::{BreachLimits, breach};
pub use fill::fill;
pub use height::Height;
pub use hierarchy::{Depression, Hierarchy};
pub use land::{Drained, Land, RoutingRule};
pub use neighbours::{Neighbours, STEPS};
pub use outlets::{Base, outlets};
pub use routing::{Descent, FlatRule, Routing};
pub use spread::Spread;

use eyot_core::{Error, Grid, Result};

/// The most that [`fill`], [`Routing::new`] and [`Routing::upstream_cells`], one after the other, hold for each cell beside
/// the heights (`f32`), bytes. Measured by `tests/memory.rs` of `eyot-land`.
pub const BYTES_PER_CELL: usize = 29;

/// Fails if the grid has more cells than 32 bits can number, or a slice has another length than the grid has cells.
fn check_sizes(grid: &Grid, sizes: &[(&str, usize)]) -> Result<()> {
    if u32::try_from(grid.cells()).is_err() {
        return Err(Error::Limit {
            what: format!("drainage of {} x {}", grid.width, grid.height),
            needed: format!("{} cells", grid.cells()),
            limit: format!("{} cells, which 32 bits can number", u32::MAX),
            remedy: "choose fewer cells or larger ones".into(),
        });
    }
    sizes.iter().try_for_each(|(what, found)| check_length(what, grid.cells(), *found))
}

/// Fails if `found` values of `what` are not `expected`.
///
/// # Errors
/// [`Error::Shape`] if the two differ.
pub fn check_length(what: &str, expected: usize, found: usize) -> Result<()> {
    if expected == found { Ok(()) } else { Err(Error::Shape { what: what.to_owned(), expected, found }) }
}
