//! The living world of Eyot: weather, water, sand, ice and climate zones as rules of cells.
//!
//! Every process is one or two rules, runs on every engine, and can be switched on and off while a world runs. All of
//! them together make a world that lives: belts of wind carry water from the sea, mountains take it out of the air,
//! rivers and glaciers bring it back.
//!
//! # Order
//! In the source every process reads the state before the step, so that their order does not matter. Here a process
//! reads what those before it in the recipe have left, as everywhere in Eyot: nothing needs to be kept twice, and
//! matter that one process moves cannot be moved again by another. The recipes' order is wind, temperature, humidity,
//! water, ice, weathering, sand, climate, zones; another one shifts what happens by at most a step (`tests/it/worlds.rs`).
//!
//! # Time
//! A step is as long as the strongest wind needs for a fifth of a cell, see [`units::hours_per_step`]. What the ground
//! does is faster by [`units::GROUND_YEARS_PER_HOUR`].
//!
//! ```
//! use eyot_climate::{Temperature, Wind};
//! use eyot_core::engine::CpuEngine;
//! use eyot_core::process::{Scheduled, Span};
//! use eyot_core::{Control, BoundaryCondition, Grid, Limits, Boundary, World};
//!
//! let grid = Grid::new(64, 32, 625_000.0, Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed }, &Limits::default())?;
//! let mut world = World::new(grid, 1);
//! let every = 1;
//! let processes = [
//!     Scheduled { name: "wind", process: Box::new(Wind::default()), every },
//!     Scheduled { name: "temperature", process: Box::new(Temperature::default()), every },
//! ];
//! CpuEngine::default().simulate(&mut world, &processes, Span { from: 0, steps: 100 }, &Control::none())?;
//! let t = world.layer("temperature")?;
//! assert!(t.field.get(0, 16) > 20.0 && t.field.get(0, 0) < 0.0);
//! # Ok::<(), eyot_core::Error>(())
//! ```

mod advection;
pub mod humidity;
pub mod ice;
mod level;
pub mod sand;
pub mod seasons;
pub mod sky;
pub mod stats;
pub mod temperature;
mod turbulence;
pub mod units;
pub mod water;
pub mod weathering;
pub mod wind;
pub mod zones;

pub use humidity::Humidity;
pub use ice::Ice;
pub use sand::Sand;
pub use seasons::Climate;
pub use temperature::Temperature;
pub use water::Water;
pub use weathering::Weathering;
pub use wind::Wind;
pub use zones::Zones;

use eyot_core::about;
use eyot_core::process::{Entry, Process};

/// All processes that recipes can name, in the order in which they should act.
pub const PROCESSES: &[Entry<dyn Process>] = &[
    Entry::<dyn Process>::process::<Wind>("wind", about!("wind.rs"), &["gerteis2017", "bridson2007", "gill1980"]),
    Entry::<dyn Process>::process::<Temperature>("temperature", about!("temperature.rs"), &["gerteis2017"]),
    Entry::<dyn Process>::process::<Humidity>("humidity", about!("humidity.rs"), &["gerteis2017", "manabe1969"]),
    Entry::<dyn Process>::process::<Water>("water", about!("water.rs"), &["gerteis2017", "holdridge1967"]),
    Entry::<dyn Process>::process::<Ice>("ice", about!("ice.rs"), &["gerteis2017", "hock2003"]),
    Entry::<dyn Process>::process::<Weathering>("weathering", about!("weathering.rs"), &["gerteis2017"]),
    Entry::<dyn Process>::process::<Sand>("sand", about!("sand.rs"), &["gerteis2017"]),
    Entry::<dyn Process>::process::<Climate>("climate", about!("seasons.rs"), &[]),
    Entry::<dyn Process>::process::<Zones>(
        "zones",
        about!("zones/mod.rs"),
        &["gerteis2017", "holdridge1947", "holdridge1967", "koeppen1936", "peel2007"],
    ),
];
