//! Processes: what ages a landscape, each in a module of its own.
//!
//! A process never calls another one; recipes put them together.

pub mod drainage;
pub mod holes;
pub mod hydraulic;
pub mod motu;
pub mod reef;
pub mod seabed;
pub mod streampower;
pub mod thermal;
pub mod wetness;

use eyot_core::process::{Entry, Process};
use eyot_core::{BoundaryCondition, Centering, LayerSpec, about};

pub use drainage::Drainage;
pub use holes::Holes;
pub use hydraulic::Hydraulic;
pub use motu::Motu;
pub use reef::Reef;
pub use seabed::Seabed;
pub use streampower::Streampower;
pub use thermal::Thermal;
pub use wetness::Wetness;

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[
    Entry::<dyn Process>::process::<Hydraulic>("hydraulic", about!("hydraulic/mod.rs"), &["mei2007", "obrien1995"]),
    Entry::<dyn Process>::process::<Thermal>("thermal", about!("thermal.rs"), &["musgrave1989", "olsen2004"]),
    Entry::<dyn Process>::process::<Seabed>("seabed", about!("seabed.rs"), &[]),
    Entry::<dyn Process>::process::<Reef>("reef", about!("reef.rs"), &["bosscher1992", "darwin1842", "meyer2014"]),
    Entry::<dyn Process>::process::<Motu>("motu", about!("motu.rs"), &["mclean1994", "kench2005"]),
    Entry::<dyn Process>::process::<Drainage>(
        "drainage",
        about!("drainage.rs"),
        &[
            "barnes2014",
            "barnes2014flats",
            "cordonnier2019",
            "freeman1991",
            "lindsay2015",
            "ocallaghan1984",
            "tarboton1997",
        ],
    ),
    Entry::<dyn Process>::process::<Streampower>(
        "streampower",
        about!("streampower/mod.rs"),
        &["howard1994", "braun2013", "roering1999", "yuan2019", "fairfield1991"],
    ),
    Entry::<dyn Process>::process::<Wetness>("wetness", about!("wetness.rs"), &[]),
    Entry::<dyn Process>::process::<Holes>("holes", about!("holes.rs"), &[]),
];

/// A layer of fluxes through faces, m/s.
pub(crate) const fn face(name: &'static str, meaning: &'static str, centering: Centering) -> LayerSpec {
    LayerSpec::new(name, "m/s", meaning, (-1e9, 1e9)).on(centering)
}

/// The first and the last of `cells` along an axis, as rules compare their place with; there are none on a ring.
pub(crate) fn ends(cells: usize, rim: BoundaryCondition) -> [f32; 2] {
    if rim == BoundaryCondition::Wrap { [-1e9, 1e9] } else { [0.0, cells as f32 - 1.0] }
}
