//! The rock cycle: waiting times, thickness, disturbance and the ledger.

use crate::{go, scheduled, value, world};
use eyot_core::World;
use eyot_core::process::Scheduled;
use eyot_strata::{NEW_ROCK, RockCycle, Strata};

/// Ten metres of loose ground on granite; a turn is a quarter of the first waiting time.
fn resting() -> (World, Vec<Scheduled>) {
    let w = world([2, 2], 10.0, |_, _| 100.0);
    let beds = vec![eyot_strata::Bed { material: "granite".into(), thickness: 1.0 }];
    let strata = Strata { beds, top: 100.0, regolith: 10.0, new_rock: true, ..Strata::default() };
    let cycle = RockCycle { years_per_turn: 250.0, wait: 1000.0, ..RockCycle::default() };
    (w, vec![scheduled(strata), scheduled(cycle)])
}

fn thickness(w: &World) -> [f32; 7] {
    let loose = value(w, "height", 0, 0) - value(w, "bedrock", 0, 0);
    std::array::from_fn(|k| if k == 0 { loose } else { value(w, &NEW_ROCK[k - 1].name, 0, 0) })
}

#[test]
fn stages_follow_each_other_in_waiting_times_that_grow_as_powers_of_four() {
    let (mut w, all) = resting();
    // The first turn begins to count.
    go(&mut w, &all, 1);
    let mut turns = 0u64;
    let mut expect = 10.0f32;
    for stage in 0..6 {
        // 1000, 4000, 16000 .. years of 250.
        let wait = 4u64.pow(stage as u32 + 1);
        go(&mut w, &all, wait - 1);
        turns += wait;
        let now = thickness(&w);
        assert!((now[stage] - expect).abs() < 1e-4, "stage {stage} rests until turn {turns}: {now:?}");
        go(&mut w, &all, 1);
        expect /= 2.0;
        let now = thickness(&w);
        assert!(
            now[stage] == 0.0 && (now[stage + 1] - expect).abs() < 1e-4,
            "stage {stage} hardens in turn {turns}: {now:?}"
        );
        assert!((value(&w, "height", 0, 0) - 90.0 - expect).abs() < 1e-3);
    }
    go(&mut w, &all, 1);
    assert_eq!(value(&w, "material", 1, 1), 6.0, "granite at last");
    // 10 m became 10 / 64 m; the ledger has the rest, on 400 m2.
    let lost = w.ledger.amount("ground.compacted");
    assert!((lost - 400.0 * 10.0 * (1.0 - 1.0 / 64.0)).abs() < 1.0, "{lost}");
    assert!((w.ledger.amount("rock.hardened_1") - 4000.0).abs() < 1.0);
    assert!((w.ledger.net("ground") + lost).abs() < 1e-6);
}

#[test]
fn disturbance_begins_the_wait_anew_and_only_for_what_lies_uppermost() {
    let (mut w, all) = resting();
    go(&mut w, &all, 1);
    for _ in 0..6 {
        // Each time just before it would harden.
        go(&mut w, &all, 3);
        let height = &mut w.layer_mut("height").unwrap().field;
        let h = height.get(0, 0);
        height.row_mut(0)[0] = h + 0.1;
    }
    assert!(thickness(&w)[0] > 10.0 && thickness(&w)[1] == 0.0, "{:?}", thickness(&w));
    assert!(value(&w, "new_rock_1", 1, 1) > 4.9, "its neighbour has hardened");
    // Sand below loose ground goes on to rest while that is disturbed.
    go(&mut w, &all, 5);
    assert!(thickness(&w)[1] > 5.0, "{:?}", thickness(&w));
    for _ in 0..16 {
        let height = &mut w.layer_mut("height").unwrap().field;
        let h = height.get(0, 0);
        height.row_mut(0)[0] = h + 0.1;
        go(&mut w, &all, 1);
    }
    assert!(thickness(&w)[2] > 2.4, "{:?}", thickness(&w));
    // A little less than what disturbs does not.
    let (mut w, all) = resting();
    go(&mut w, &all, 1);
    for _ in 0..4 {
        let height = &mut w.layer_mut("height").unwrap().field;
        let h = height.get(0, 0);
        height.row_mut(0)[0] = h + 0.005;
        go(&mut w, &all, 1);
    }
    assert!(thickness(&w)[1] > 4.9, "{:?}", thickness(&w));
}

#[test]
fn uplift_is_no_disturbance() {
    let (mut w, mut all) = resting();
    let beds = vec![eyot_strata::Bed { material: "granite".into(), thickness: 1.0 }];
    let rising = Strata {
        beds,
        top: 100.0,
        regolith: 10.0,
        new_rock: true,
        uplift: 0.002,
        years_per_step: 250.0,
        ..Strata::default()
    };
    all[0] = scheduled(rising);
    go(&mut w, &all, 6);
    assert!(value(&w, "height", 0, 0) > 97.0 && thickness(&w)[1] > 4.9, "{:?}", thickness(&w));
}
