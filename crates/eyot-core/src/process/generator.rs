//! Generators: what makes a layer once, and how a grid can be cut for it.

use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::grid::{BoundaryCondition, Grid};
use crate::remedy::Remedy;
use crate::world::World;
use std::ops::Range;

/// What a generator may look at, and which rows it is to make.
///
/// A grid may be made in windows, so that it need never be in memory as a whole. Then `rows` are the rows to make, and the
/// base and the layers of `world` hold the rows [`Reach::around`] these; the world's own grid is as high as they are.
pub struct Site<'a> {
    /// The whole grid.
    pub grid: Grid,
    /// The rows of it to make.
    pub rows: Range<usize>,
    /// Seed of this step: the recipe's seed mixed with the step's position in it.
    pub seed: u64,
    /// The world so far.
    pub world: &'a World,
    /// Cancellation and progress.
    pub control: &'a Control<'a>,
}

impl<'a> Site<'a> {
    /// All rows of the grid.
    pub const fn whole(grid: Grid, seed: u64, world: &'a World, control: &'a Control<'a>) -> Self {
        Self { grid, rows: 0..grid.height, seed, world, control }
    }
}

/// How far a generator looks, and so how a grid can be cut for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// A cell depends on nothing but its place and the cell that was there.
    Cell,
    /// Also on this many rows to the north and to the south.
    Rows(usize),
    /// On everything: the grid can only be made in one piece.
    Whole,
}

impl Reach {
    /// The rows of base and world that are needed to make `rows`. Beyond closed and open rims there are none; on a wrapping
    /// rim numbers below 0 and from the height on stand for the far side, unless all rows are needed.
    pub fn around(self, grid: &Grid, rows: &Range<usize>) -> Range<isize> {
        self.around_any(grid, &(rows.start as isize..rows.end as isize))
    }

    /// As [`Reach::around`] of rows that may themselves lie beyond a wrapping rim.
    pub fn around_any(self, grid: &Grid, rows: &Range<isize>) -> Range<isize> {
        let height = grid.height as isize;
        let n = match self {
            Self::Cell => 0,
            Self::Rows(n) => n.min(grid.height) as isize,
            Self::Whole => height,
        };
        let (from, to) = (rows.start - n, rows.end + n);
        match grid.rim.y {
            BoundaryCondition::Wrap if to - from < height => from..to,
            BoundaryCondition::Wrap => 0..height,
            BoundaryCondition::Closed | BoundaryCondition::Open => from.max(0)..to.min(height),
        }
    }
}

/// The rows of a field around a window, by their numbers in the whole grid.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    field: &'a Field,
    /// Row of the grid that is row 0 of the field; may be negative on a wrapping rim.
    first: isize,
    height: usize,
}

impl<'a> Around<'a> {
    /// `field` holds the rows that a generator with this `reach` needs at this `site`.
    ///
    /// # Errors
    /// If it holds another number of rows or columns.
    pub fn new(site: &Site<'_>, reach: Reach, field: &'a Field) -> Result<Self> {
        let rows = reach.around(&site.grid, &site.rows);
        if (field.width(), field.height()) != (site.grid.width, rows.len()) {
            return Err(Error::Shape {
                what: format!("rows {rows:?} of {} cells", site.grid.width),
                expected: site.grid.width * rows.len(),
                found: field.width() * field.height(),
            });
        }
        Ok(Self { field, first: rows.start, height: site.grid.height })
    }

    /// Row `y` of the grid.
    ///
    /// # Panics
    /// If it is not one of the rows around the window.
    pub fn row(&self, y: usize) -> &'a [f32] {
        self.field.row((y as isize - self.first).rem_euclid(self.height as isize) as usize)
    }
}

/// Makes a layer from parameters and a seed, or from the layer that is there.
pub trait Generator: Send + Sync {
    /// Computes the rows `site.rows` of a new field: as many rows as that. `base` is the layer that they will be merged into;
    /// a source ignores it, a filter transforms it.
    ///
    /// # Errors
    /// If a parameter cannot work here, or on a request to stop.
    fn generate(&self, site: &Site<'_>, base: &Field) -> Result<Field>;

    /// Finds parameters that cannot work together or on this grid, before anything runs.
    ///
    /// # Errors
    /// The first such parameter, by name.
    fn check(&self, _grid: &Grid) -> Result<()> {
        Ok(())
    }

    /// How a grid can be cut for this generator. If not at all, it is only ever asked for all rows.
    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Whole
    }

    /// The most that it holds for each cell while it generates, the result included, bytes. Measured as
    /// [`Action::bytes_per_cell`](super::Action::bytes_per_cell). Most make their result row by row and hold nothing else.
    fn bytes_per_cell(&self, _grid: &Grid) -> usize {
        size_of::<f32>()
    }

    /// The cells whose values it could only fill in: 1 for each of them and 0 for the others; `None` if there are none. They are kept
    /// with the world as the layer [`known::MISSING`](crate::layer::known::MISSING), which exports mark.
    ///
    /// # Errors
    /// As [`Generator::generate`].
    fn missing(&self, _grid: &Grid) -> Result<Option<Field>> {
        Ok(None)
    }

    /// What it can do on this grid and most likely was not meant to, a sentence each with its remedy.
    fn doubts(&self, _grid: &Grid) -> Vec<Remedy> {
        Vec::new()
    }

    /// Layers that it looks at beside its base.
    fn reads(&self) -> Vec<&str> {
        Vec::new()
    }

    /// True if the result replaces the base instead of being merged with it.
    fn is_filter(&self) -> bool {
        false
    }
}
