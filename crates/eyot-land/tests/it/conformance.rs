//! Every rule of every process: lanes = scalar = reference bit by bit on all shapes and rims; the traced graph means the
//! same.

use eyot_core::conformance;
use eyot_core::process::{Locality, Moment, Process, Scheduled};
use eyot_land::simulate::PROCESSES;
use eyot_land::simulate::hydraulic::Hydraulic;
use eyot_testing::land::{start, variants};
use eyot_testing::one;

eyot_testing::conformance_suite!(variants, start);

#[test]
fn steps_with_defaults_keep_to_the_layers_that_they_declare() {
    for e in PROCESSES {
        let process = (e.make)((e.defaults)()).unwrap();
        conformance::check_access(&[Scheduled { name: e.name, process, every: 1 }], &start).unwrap();
    }
}

/// What a window makes of its inside is what the whole world has there.
#[test]
fn windows_with_defaults_have_the_bytes_of_the_whole_grid() {
    for e in PROCESSES {
        let process = (e.make)((e.defaults)()).unwrap();
        let whole = process.action().map(|a| a.locality());
        let compared = conformance::check_windows(&[Scheduled { name: e.name, process, every: 1 }], &start).unwrap();
        // Water finds its way over the whole grid.
        let acts = ["drainage", "streampower"].contains(&e.name);
        assert_eq!(whole, acts.then_some(Locality::Whole), "{}", e.name);
        assert_eq!(compared, !acts, "{}", e.name);
    }
}

#[test]
fn springs_conform() {
    let with_springs = Hydraulic { springs: 0.01, ..Default::default() };
    struct WithSprings(Hydraulic);
    impl Process for WithSprings {
        fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
            let mut l = self.0.layers();
            l.push(eyot_land::simulate::hydraulic::SPRINGS.changed(0.0));
            l
        }
        fn plan(&self, m: &Moment, p: &mut eyot_core::plan::Plan) {
            self.0.plan(m, p);
        }
    }
    conformance::check(&[one(WithSprings(with_springs))], &start).unwrap();
}
