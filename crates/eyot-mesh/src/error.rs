//! Errors of meshing.

use crate::primitive::{Point, Primitive};
use eyot_core::remedy::{Remedy, Worded};

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
    /// More tiles along a side than quads.
    #[error("{tiles:?} tiles cannot be cut from {quads:?} quads; choose fewer")]
    TooManyTiles {
        /// Tiles from west to east and from north to south.
        tiles: [usize; 2],
        /// Quads between vertices along both sides.
        quads: [usize; 2],
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
    /// A primitive of a body that cannot be drawn.
    #[error("primitive {index} of a body is {primitive:?}; it needs finite numbers and radii above 0")]
    BadPrimitive {
        /// Its place in the list.
        index: usize,
        /// What was given.
        primitive: Primitive,
    },
    /// A lattice that cannot be sampled.
    #[error("no lattice from {low:?} to {high:?} with a voxel of {voxel}: {reason}")]
    BadLattice {
        /// First corner of the box.
        low: Point,
        /// The other corner.
        high: Point,
        /// Length of an edge.
        voxel: f32,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A volume without a value for each of its points, or without a cell.
    #[error("a volume of {} x {} x {} points with {values} values; it needs one each, and 2 to 4,194,304 points along each axis", size[0], size[1], size[2])]
    BadVolume {
        /// Points on x, y and z.
        size: [usize; 3],
        /// Values that were given.
        values: usize,
    },
    /// A value of a field that is not a finite number.
    #[error("the field is {value} at {at:?}; meshing needs finite values in the whole box")]
    FieldNotFinite {
        /// NaN or an infinity.
        value: f32,
        /// Where.
        at: Point,
    },
    /// A field said that a box holds nothing, but its surface runs into it.
    #[error(
        "the field's surface runs into a block at {at:?} of which its `within` says that it holds nothing; let it say more"
    )]
    FieldOverlooked {
        /// A corner of the block beside.
        at: Point,
    },
    /// Sizes that must agree do not, or a limit is exceeded.
    #[error(transparent)]
    Core(#[from] eyot_core::Error),
}

impl From<Error> for Remedy {
    fn from(e: Error) -> Self {
        e.sentence()
    }
}

impl Worded for Error {
    fn sentence(&self) -> Remedy {
        match self {
            Self::Core(e) => e.sentence(),
            other => other.to_string().into(),
        }
    }
}
