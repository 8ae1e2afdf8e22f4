//! Every kept input, and some damage to each.

use eyot_fuzz::mutate::{Random, damage};
use eyot_fuzz::{TARGETS, corpus};

#[test]
fn kept_inputs_and_damaged_ones_come_to_an_end() {
    let count = if cfg!(debug_assertions) { 5 } else { 50 };
    for target in TARGETS {
        let inputs = corpus::inputs(target);
        let seeds = inputs.iter().filter(|(name, _)| name.starts_with("seed "));
        for (name, bytes) in seeds {
            assert!((target.run)(bytes), "{}: {name} is refused", target.name);
        }
        for (i, (_, bytes)) in inputs.iter().enumerate() {
            (target.run)(bytes);
            let mut r = Random::new(i as u64);
            for _ in 0..count {
                let mut damaged = bytes.clone();
                damage(&mut damaged, &inputs[r.below(inputs.len())].1, target.words, &mut r);
                (target.run)(&damaged);
            }
        }
    }
}

#[test]
fn every_corpus_has_a_target() {
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/corpus")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(eyot_fuzz::target(&name).is_some(), "nobody reads corpus/{name}");
    }
}
