//! Lakes and rivers: where water stands and runs on a land, as level surfaces and as a graph of lines.
//!
//! [`Rivers`] is the process that recipes name. It finds the lakes of a landscape by the balance of their water ([`lakes`]), the
//! discharge of its rivers ([`runoff`]), makes lines of them ([`network`], [`course`]) and digs their beds ([`bed`]). What it finds is
//! kept with the world: the components [`RIVERS`], [`LAKES`], [`OXBOWS`] and [`WATERFALLS`], and layers.

pub mod bed;
pub mod braid;
pub mod course;
pub mod kept;
pub mod lakes;
pub mod lines;
pub mod meander;
pub mod measures;
pub mod network;
pub mod rivers;
pub mod runoff;
pub mod shores;
pub mod wander;

pub use measures::{GraphStats, graph_stats};
pub use rivers::{Rivers, Springs};

use eyot_core::about;
use eyot_core::layer::LayerSpec;
use eyot_core::process::{Entry, Process};

/// The component that holds the rivers: lines, one a reach.
pub const RIVERS: &str = "rivers";
/// The component that holds the lakes: polygons.
pub const LAKES: &str = "lakes";
/// The component that holds the lakes that cut-off bends left behind: polygons.
pub const OXBOWS: &str = "oxbow_lakes";
/// The component that holds the waterfalls: points.
pub const WATERFALLS: &str = "waterfalls";

/// Level of lakes.
pub const LAKE_LEVEL: LayerSpec = LayerSpec::new(
    "lake_level",
    "m",
    "Height of the surface of the lake here, the same in the whole lake; that of the ground where there is none",
    (-12000.0, 12000.0),
);
/// Water that runs through.
pub const DISCHARGE: LayerSpec =
    LayerSpec::new("discharge", "m3/s", "Water that runs through the cell in the mean of a year", (0.0, 1e9));
/// Rivers as a mask.
pub const RIVER: LayerSpec = LayerSpec::new("river", "1", "Share of the cell that a river covers", (0.0, 1.0));
/// The source's count.
pub const RIVER_PASSES: LayerSpec =
    LayerSpec::new("river_passes", "1", "Springs whose water runs through the cell", (0.0, 1e9));

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[Entry::<dyn Process>::process::<Rivers>(
    "rivers",
    about!("rivers.rs"),
    &[
        "riesen2015",
        "barnes2020",
        "barnes2021",
        "budyko1974",
        "zhang2001",
        "turc1954",
        "leopold1953",
        "moody2002",
        "andreadis2013",
        "lehner2013",
        "yuksel2011",
        "howard1984",
        "paris2023",
        "leopold1957",
        "ashmore2013",
    ],
)];
