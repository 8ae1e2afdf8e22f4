//! The grid: how many cells, how large they are, and what happens at the rim.

use crate::error::{Error, Result};
use crate::limits::Limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What lies beyond the last cell along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BoundaryCondition {
    /// A wall: nothing enters or leaves.
    #[default]
    Closed,
    /// A free outfall: matter leaves and is counted, nothing enters.
    Open,
    /// The far side of the grid: the axis is a ring.
    Wrap,
}

/// The rim of a grid, axis by axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Boundary {
    /// West and east sides.
    pub x: BoundaryCondition,
    /// North and south sides.
    pub y: BoundaryCondition,
}

impl Boundary {
    /// Walls on all four sides.
    pub const CLOSED: Self = Self::both(BoundaryCondition::Closed);
    /// Outfalls on all four sides.
    pub const OPEN: Self = Self::both(BoundaryCondition::Open);
    /// A torus.
    pub const WRAP: Self = Self::both(BoundaryCondition::Wrap);

    /// The same edge on both axes.
    pub const fn both(edge: BoundaryCondition) -> Self {
        Self { x: edge, y: edge }
    }
}

/// A rectangle of cells. Row 0 is north, column 0 is west.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// East-west size of a cell, m, positive.
    pub cell_x_m: f64,
    /// North-south size of a cell, m, positive.
    pub cell_y_m: f64,
    /// What lies beyond the border cells.
    pub rim: Boundary,
}

impl Grid {
    /// A grid of square cells.
    ///
    /// # Errors
    /// If a side is zero, the cell size is not a positive finite number, or the cell count exceeds `limits`.
    pub fn new(width: usize, height: usize, cell_m: f64, rim: Boundary, limits: &Limits) -> Result<Self> {
        Self { width, height, cell_x_m: cell_m, cell_y_m: cell_m, rim }.checked(limits)
    }

    /// Returns `self` if its sizes are sound and within `limits`.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn checked(self, limits: &Limits) -> Result<Self> {
        if self.width == 0 || self.height == 0 {
            return Err(Error::BadGrid(format!(
                "a grid needs at least 1x1 cells, this one has {}x{}",
                self.width, self.height
            )));
        }
        for (name, c) in [("x", self.cell_x_m), ("y", self.cell_y_m)] {
            if !(c.is_finite() && (1e-6..=1e7).contains(&c)) {
                return Err(Error::BadGrid(format!(
                    "the cell size along {name} is {c} m; it must lie within 1e-6..=1e7 m"
                )));
            }
        }
        limits.check_cells(self.width, self.height)?;
        Ok(self)
    }

    /// Number of cells.
    pub const fn cells(&self) -> usize {
        self.width * self.height
    }

    /// Area of one cell, m2.
    pub fn cell_area_m2(&self) -> f64 {
        self.cell_x_m * self.cell_y_m
    }

    /// East-west and north-south extent, m.
    pub fn extent_m(&self) -> (f64, f64) {
        (self.width as f64 * self.cell_x_m, self.height as f64 * self.cell_y_m)
    }

    /// The column that stands for `x` under this grid's rim; beyond closed and open rims that is the nearest one.
    pub fn wrap_x(&self, x: isize) -> usize {
        resolve(x, self.width, self.rim.x)
    }

    /// The row that stands for `y` under this grid's rim; see [`Grid::wrap_x`].
    pub fn wrap_y(&self, y: isize) -> usize {
        resolve(y, self.height, self.rim.y)
    }
}

fn resolve(i: isize, n: usize, edge: BoundaryCondition) -> usize {
    match edge {
        BoundaryCondition::Wrap => i.rem_euclid(n as isize) as usize,
        BoundaryCondition::Closed | BoundaryCondition::Open => i.clamp(0, n as isize - 1) as usize,
    }
}
