//! Which bed comes to light, what is loose, and how the beds lie.

use crate::{go, scheduled, value, world};
use eyot_core::process::Process;
use eyot_core::{Boundary, Grid, Limits};
use eyot_strata::{BED_SHIFT, Bed, Fault, Fold, Strata};

fn bed(material: &str, thickness: f32) -> Bed {
    Bed { material: material.into(), thickness }
}

/// Limestone (3) for 20 m, schist (4) for 30 m, granite (6) below; top at 100 m.
fn three() -> Strata {
    Strata {
        beds: vec![bed("limestone", 20.0), bed("schist", 30.0), bed("granite", 50.0)],
        top: 100.0,
        ..Strata::default()
    }
}

#[test]
fn each_height_shows_its_bed() {
    // 110, 109, ... m.
    let mut w = world([120, 1], 10.0, |x, _| 110.0 - x as f32);
    go(&mut w, &[scheduled(three())], 1);
    for x in 0..120 {
        let depth = x as f32 - 10.0;
        let (material, erodibility, degrees) = match depth {
            d if d < 20.0 => (3.0, 0.65, 60.0f32),
            d if d < 50.0 => (4.0, 0.3, 60.0),
            _ => (6.0, 0.05, 70.0),
        };
        assert_eq!(value(&w, "material", x, 0), material, "{depth} m deep");
        assert!((value(&w, "erodibility", x, 0) - erodibility).abs() < 1e-6, "{depth} m deep");
        assert!((value(&w, "rock_slope", x, 0) - degrees.to_radians().tan()).abs() < 1e-4, "{depth} m deep");
    }
    // The same beds again and again.
    let mut w = world([220, 1], 10.0, |x, _| 210.0 - x as f32);
    go(&mut w, &[scheduled(Strata { repeat: true, ..three() })], 1);
    for x in 0..220 {
        let depth = (x as f32 - 110.0).rem_euclid(100.0);
        let material = if depth < 20.0 {
            3.0
        } else if depth < 50.0 {
            4.0
        } else {
            6.0
        };
        assert_eq!(value(&w, "material", x, 0), material, "{depth} m deep");
    }
}

#[test]
fn what_others_take_is_loose_ground_first_and_what_they_lay_down_is_loose() {
    let mut w = world([4, 1], 10.0, |_, _| 90.0);
    let beds = [scheduled(Strata { regolith: 2.0, cover: 0.1, ..three() })];
    go(&mut w, &beds, 1);
    assert_eq!(value(&w, "material", 0, 0), 0.0, "regolith covers it");
    let ground = w.layer_mut("height").unwrap();
    for (x, by) in [-1.5, -12.0, 3.0, 0.0].into_iter().enumerate() {
        let h = ground.field.get(x, 0);
        ground.field.row_mut(0)[x] = h + by;
    }
    go(&mut w, &beds, 1);
    let loose = |x: usize| value(&w, "height", x, 0) - value(&w, "bedrock", x, 0);
    assert_eq!([loose(0), loose(1), loose(2), loose(3)], [0.5, 0.0, 5.0, 2.0]);
    assert_eq!([0, 1, 2, 3].map(|x| value(&w, "material", x, 0)), [0.0, 4.0, 0.0, 0.0]);
    // 10 m of rock on 100 m2.
    assert!((w.ledger.amount("rock.worn") - 1000.0).abs() < 0.1, "{}", w.ledger.amount("rock.worn"));
}

/// Soil under itself: `ds/dt = P e^(-s / d)`, so `s = d ln(1 + P t / d)`.
#[test]
fn soil_forms_as_its_law_says() {
    let mut w = world([2, 2], 10.0, |_, _| 60.0);
    let beds = Strata { soil: 0.0005, soil_depth: 0.4, years_per_step: 5.0, ..three() };
    let processes = [scheduled(beds)];
    for n in 1..=20u32 {
        go(&mut w, &processes, 100);
        let years = 500.0 * f64::from(n);
        let want = 0.4 * (1.0 + 0.0005 * years / 0.4).ln();
        let got = f64::from(value(&w, "height", 0, 0) - value(&w, "bedrock", 0, 0));
        assert!((got / want - 1.0).abs() < 0.01, "{years} years: {got} m, {want} m");
    }
    let weathered = w.ledger.amount("rock.weathered") / 400.0;
    let soil = f64::from(value(&w, "height", 0, 0) - value(&w, "bedrock", 0, 0));
    assert!((weathered / soil - 1.0).abs() < 1e-3, "{weathered} of {soil}");
}

#[test]
fn strata_lie_as_they_are_tilted_folded_and_broken() {
    let datum = |beds: Strata, x: usize, y: usize| {
        let mut w = world([41, 41], 10.0, |_, _| 0.0);
        go(&mut w, &[scheduled(beds)], 1);
        value(&w, "bed_datum", x, y)
    };
    // The middle is column and row 20. Ten degrees down to the east.
    let tilted = Strata { dip: 10.0, dip_direction: 90.0, ..three() };
    assert!((datum(tilted.clone(), 20, 20) - 100.0).abs() < 1e-3);
    assert!((datum(tilted.clone(), 40, 7) - (100.0 - 200.0 * 10f32.to_radians().tan())).abs() < 1e-2);
    // Down to the south: rows grow to the south.
    let south = Strata { dip_direction: 180.0, ..tilted };
    assert!(datum(south.clone(), 20, 30) < 90.0 && datum(south, 20, 10) > 110.0);
    let folded =
        Strata { folds: vec![Fold { wavelength: 200.0, amplitude: 15.0, direction: 0.0, crest: 50.0 }], ..three() };
    // The crest lies 50 m to the north of the middle, the trough 100 m further.
    assert!((datum(folded.clone(), 3, 15) - 115.0).abs() < 0.01);
    assert!((datum(folded, 33, 5) - 85.0).abs() < 0.01);
    // A fault that runs north through the middle lifts what is to the right of it: the east.
    let broken = Strata { faults: vec![Fault { strike: 0.0, distance: 0.0, throw: 40.0 }], ..three() };
    assert_eq!((datum(broken.clone(), 19, 5), datum(broken.clone(), 21, 5)), (100.0, 140.0));
    // What a generator made is added.
    let mut w = world([41, 41], 10.0, |_, _| 0.0);
    w.put(&BED_SHIFT, eyot_core::Field::from_fn(41, 41, |x, _| x as f32)).unwrap();
    go(&mut w, &[scheduled(broken)], 1);
    assert_eq!((value(&w, "bed_datum", 19, 5), value(&w, "bed_datum", 21, 5)), (119.0, 161.0));
}

#[test]
fn uplift_lifts_land_and_beds_and_is_in_the_ledger() {
    let mut w = world([3, 3], 10.0, |x, _| 70.0 + x as f32);
    let beds = Strata { uplift: 0.001, years_per_step: 100.0, regolith: 1.0, ..three() };
    go(&mut w, &[scheduled(beds)], 50);
    for x in 0..3 {
        assert!((value(&w, "height", x, 1) - 75.0 - x as f32).abs() < 1e-3);
        assert!((value(&w, "height", x, 1) - value(&w, "bedrock", x, 1) - 1.0).abs() < 1e-3);
        assert!((value(&w, "bed_datum", x, 1) - 105.0).abs() < 1e-3);
    }
    assert!((w.ledger.net("ground") - 5.0 * 900.0).abs() < 0.5, "{}", w.ledger.net("ground"));
}

#[test]
fn beds_that_cannot_be_are_refused_by_name() {
    let grid = Grid::new(8, 8, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let refused = |change: &dyn Fn(&mut Strata)| {
        let mut beds = three();
        change(&mut beds);
        beds.check(&grid).unwrap_err().to_string()
    };
    for (change, words) in [
        (&(|b: &mut Strata| b.beds[1].thickness = 0.0) as &dyn Fn(&mut Strata), "beds.2.thickness"),
        (&|b| b.beds[1].thickness = -3.0, "beds.2.thickness"),
        (&|b| b.beds[1].thickness = f32::NAN, "beds.2.thickness"),
        (&|b| b.beds[0].material = "cheese".into(), "there is no material `cheese`; there are regolith, sand"),
        (&|b| b.beds[2].material = "cheese".into(), "beds.3.material"),
        (&|b| b.stages.truncate(1), "1 material; new rock has 6 stages"),
        (&|b| b.stages[3] = "cheese".into(), "stages.4"),
        (&|b| b.stages[3] = "sandstone".into(), "`sandstone` is a stage already"),
        (&|b| b.materials[3].name = String::new(), "a material has no name"),
        (&|b| b.loose = "mud".into(), "there is no material `mud`"),
        (&|b| b.beds = vec![], "0 beds; there can be 1 to 13"),
        (&|b| b.beds = vec![bed("sand", 1.0); 14], "14 beds"),
        (&|b| b.materials[2].talus = 95.0, "materials.sandstone.talus"),
        (&|b| b.materials[3].name = "sand".into(), "two of the name `sand`"),
        (&|b| b.folds = vec![Fold::default(); 5], "5 folds; there can be 4"),
        (&|b| b.folds = vec![Fold { wavelength: 0.0, ..Fold::default() }], "folds.wavelength"),
        (&|b| b.faults = vec![Fault { throw: f32::INFINITY, ..Fault::default() }], "faults.throw"),
    ] {
        let said = refused(change);
        assert!(said.contains(words), "{said}, not {words}");
    }
}
