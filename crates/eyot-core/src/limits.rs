//! One set of limits that every generator and importer meets before it allocates.

use crate::error::{Error, Result};

/// Upper bounds on what one world may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Cells of a grid.
    pub max_cells: u64,
    /// Bytes that a single request may allocate.
    pub max_bytes: u64,
    /// Vertices of a mesh.
    pub max_vertices: u64,
    /// Layers of a world.
    pub max_layers: usize,
    /// Steps of one recipe entry.
    pub max_steps: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_cells: 1 << 30,
            max_bytes: 16 << 30,
            max_vertices: 1 << 28,
            max_layers: 256,
            max_steps: 1_000_000_000,
        }
    }
}

impl Limits {
    /// Checks a grid's size.
    ///
    /// # Errors
    /// If `width * height` exceeds [`Limits::max_cells`].
    pub fn check_cells(&self, width: usize, height: usize) -> Result<()> {
        let cells = width as u128 * height as u128;
        if cells > u128::from(self.max_cells) {
            return Err(Error::Limit {
                what: format!("a grid of {width} x {height}"),
                needed: format!("{cells} cells"),
                limit: format!("{} cells", self.max_cells),
                remedy: "choose fewer cells or larger ones",
            });
        }
        Ok(())
    }

    /// Checks an allocation.
    ///
    /// # Errors
    /// If `bytes` exceeds [`Limits::max_bytes`].
    pub fn check_bytes(&self, what: &str, bytes: u128) -> Result<()> {
        if bytes > u128::from(self.max_bytes) {
            return Err(Error::Limit {
                what: what.to_owned(),
                needed: format!("{} MiB", bytes >> 20),
                limit: format!("{} MiB", self.max_bytes >> 20),
                remedy: "choose a smaller grid, fewer layers, or raise the limit with --max-memory",
            });
        }
        Ok(())
    }
}
