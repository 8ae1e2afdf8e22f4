//! Fixtures that the tests of several crates share. Not published; only ever a dev-dependency.

pub mod climate;
pub mod counting;
pub mod land;
pub mod plants;
pub mod strata;

use eyot_core::process::{Process, Scheduled};
use eyot_core::{Boundary, Grid, Limits};

/// A process that runs in every step.
pub fn one(process: impl Process + 'static) -> Scheduled {
    Scheduled { name: "test", process: Box::new(process), every: 1 }
}

/// The tests that rules of every kind pass: lanes = scalar = reference bit by bit on all shapes and rims, steps keep to the layers that they
/// declare, windows have the bytes of the whole, graphs mean what the rules mean.
///
/// Takes a function that gives names and processes, and one that gives a plausible value of a layer from a number within 0..1.
#[macro_export]
macro_rules! conformance_suite {
    ($variants:path, $start:path) => {
        #[test]
        fn engine_equals_reference_for_every_rule() {
            for (name, processes) in $variants() {
                println!("{name}");
                $crate::conformance::check(&processes, &$start).unwrap();
            }
        }

        #[test]
        fn steps_keep_to_the_layers_that_they_declare() {
            for (name, processes) in $variants() {
                println!("{name}");
                $crate::conformance::check_access(&processes, &$start).unwrap();
            }
        }

        #[test]
        fn windows_have_the_bytes_of_the_whole_grid() {
            for (name, processes) in $variants() {
                println!("{name}");
                assert!($crate::conformance::check_windows(&processes, &$start).unwrap(), "{name} is rules");
            }
        }

        #[test]
        fn graphs_mean_what_the_rules_mean() {
            for (_, processes) in $variants() {
                $crate::conformance::check_graphs(&processes, $crate::wide());
            }
        }
    };
}
pub use eyot_core::conformance;

/// An oblong grid on which graphs are checked.
///
/// # Panics
/// Never: it is a small one.
pub fn wide() -> Grid {
    Grid::new(64, 32, 3.0, Boundary::OPEN, &Limits::default()).unwrap_or_else(|e| panic!("{e}"))
}
