//! Errors of meshing.

/// Result with the meshing [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong when a mesh is made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A grid with a single row or column has no area to cover with triangles.
    #[error("a terrain mesh needs at least 2x2 cells, this grid has {width}x{height}; export it as a raster instead")]
    NoTriangle {
        /// Columns of the grid.
        width: usize,
        /// Rows of the grid.
        height: usize,
    },
    /// Fewer vertices are allowed than two rows and two columns need.
    #[error("a terrain mesh needs at least 4 vertices, max_vertices is {max_vertices}; raise it")]
    TooFewVertices {
        /// The option or limit that was given.
        max_vertices: u64,
    },
    /// A height that is not a finite number.
    #[error("the height is {value} at column {x}, row {y}; a mesh needs finite heights")]
    NotFinite {
        /// NaN or an infinity.
        value: f32,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// Sizes that must agree do not, or a limit is exceeded.
    #[error(transparent)]
    Core(#[from] eyot_core::Error),
}
