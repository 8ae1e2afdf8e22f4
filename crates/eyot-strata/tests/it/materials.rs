//! What the ledger says of each material is what sections show: beds, new rock, what becomes soil, and what hardens.

use crate::columns::{bed, dig, noise};
use crate::{go, scheduled, world};
use eyot_core::process::Process;
use eyot_core::{Field, World};
use eyot_strata::{
    BED_SURFACES, Bed, Fold, Material, NEW_ROCK, RockCycle, Rockfall, Section, Sequence, Soak, Strata, Surfaces,
};

const SIDE: usize = 24;
const CELL_M: f64 = 10.0;
/// Below all that is ever cut.
const FLOOR_M: f64 = -400.0;

/// Volume of each material of the world, m3, from sections through all rows.
fn volumes(w: &World) -> Vec<f64> {
    let materials = Sequence::of(w).unwrap().unwrap().materials.len();
    let mut volumes = vec![0.0; materials];
    for y in 0..SIDE {
        let north = CELL_M * (y as f64 + 0.5);
        let section = Section::along(w, &[[0.0, north], [CELL_M * SIDE as f64, north]], FLOOR_M).unwrap();
        let areas = section.areas_m2();
        assert!(areas[materials..].iter().all(|a| *a == 0.0), "all of it is of materials");
        volumes.iter_mut().zip(areas).for_each(|(v, a)| *v += CELL_M * a);
    }
    volumes
}

/// What the ledger says that each material but loose ground has gained, m3.
fn told(w: &World, compaction: f64) -> Vec<f64> {
    let sequence = Sequence::of(w).unwrap().unwrap();
    let account = |name: String| w.ledger.amount(&name);
    let mut gained = vec![0.0; sequence.materials.len()];
    for (n, bed) in sequence.beds.iter().enumerate() {
        let n = n + 1;
        gained[usize::from(bed.material)] -=
            account(format!("rock.worn_bed_{n}")) + account(format!("rock.soaked_bed_{n}"));
    }
    for (k, stage) in sequence.stages.iter().enumerate() {
        let k = k + 1;
        let gain =
            (1.0 - compaction) * account(format!("rock.hardened_{k}")) - account(format!("rock.hardened_{}", k + 1));
        gained[usize::from(*stage)] +=
            gain - account(format!("rock.worn_new_{k}")) - account(format!("rock.soaked_new_{k}"));
    }
    gained
}

/// Random columns with random cuts and deposits; what each material lost is what the ledger says of it.
fn keeps_books(name: &str, beds: Strata) {
    let mut w = world([SIDE, SIDE], CELL_M, |x, y| 60.0 + 60.0 * noise(x, y, 1));
    w.sea_level_m = if beds.soaked { 500.0 } else { 0.0 };
    let field = |salt: u32, of: &dyn Fn(f32) -> f32| Field::from_fn(SIDE, SIDE, |x, y| of(noise(x, y, salt)));
    for (k, slot) in NEW_ROCK.iter().enumerate().filter(|_| beds.new_rock) {
        w.put(slot, field(10 + k as u32, &|u| (2.0 * u - 1.0).max(0.0))).unwrap();
    }
    for (k, surface) in BED_SURFACES.iter().enumerate().filter(|_| beds.surfaces == Surfaces::Lower) {
        w.put(surface, field(20 + k as u32, &|u| 9.0 * u - 3.0)).unwrap();
    }
    go(&mut w, &[scheduled(beds.clone())], 1);
    let (before, booked) = (volumes(&w), told(&w, 0.5));
    let cycle = RockCycle { years_per_turn: 10.0, wait: 15.0, disturbance: 3.0, ..RockCycle::default() };
    for step in 0..12 {
        let cut: Vec<f32> =
            (0..SIDE * SIDE).map(|i| (9.0 * noise(i % SIDE, i / SIDE, 100 + step) - 4.0).max(-1.0)).collect();
        dig(&mut w, &beds, &cut);
        let mut others = vec![scheduled(Rockfall::default())];
        if beds.soaked {
            // Every cell counts as standing under the sea, and loses up to a metre.
            others.push(scheduled(Soak { depth: 0.001, slope: 1.0, rate: 1.0, level: 0.5, ..Soak::default() }));
        }
        if beds.new_rock {
            others.push(scheduled(cycle.clone()));
        }
        go(&mut w, &others, 1);
        // What fell is booked by the beds.
        go(&mut w, &[scheduled(beds.clone())], 1);
    }
    let now = volumes(&w);
    let loose = usize::from(Sequence::of(&w).unwrap().unwrap().loose);
    let gained: Vec<f64> = told(&w, 0.5).iter().zip(booked).map(|(now, before)| now - before).collect();
    let mut lost = 0.0;
    for (n, m) in beds.materials.iter().enumerate().filter(|(n, _)| *n != loose) {
        let got = now[n] - before[n];
        // Heights are of single precision: 2 um on 120 m, in each of the cells and steps.
        let rounding = 4e-5 * (SIDE * SIDE) as f64 * CELL_M * CELL_M;
        assert!((got - gained[n]).abs() < rounding + 1e-4 * got.abs(), "{name}, {}: {got}, not {}", m.name, gained[n]);
        lost -= got.min(0.0);
    }
    assert!(lost > 1e5, "{name}: rock was cut, {lost} m3");
}

/// Beds in this order, one of each thickness.
fn many(count: usize) -> Vec<Bed> {
    let order = ["sandstone", "marble", "sand", "granite", "limestone", "schist"];
    (0..count).map(|n| bed(order[n % order.len()], 3.0 + (n % 4) as f32)).collect()
}

#[test]
fn every_material_is_in_the_books_with_as_much_as_sections_show() {
    let of = |count: usize| Strata {
        beds: many(count),
        top: 110.0,
        cover: 0.2,
        soil: 0.002,
        years_per_step: 10.0,
        ..Strata::default()
    };
    // Four, eight and twelve beds are rules of their own, and the thirteenth has no bottom.
    for count in [1, 3, 4, 5, 8, 9, 12, 13] {
        keeps_books(&format!("{count} beds"), of(count));
        keeps_books(&format!("{count} beds under new rock"), Strata { new_rock: true, ..of(count) });
    }
    for count in [3, 8, 10, 13] {
        // A step cuts through no more than one bed of the turn above.
        let mut again = Strata { repeat: true, dip: 3.0, ..of(count) };
        again.beds.iter_mut().for_each(|b| b.thickness *= 4.0);
        keeps_books(&format!("{count} beds again and again"), again.clone());
        keeps_books(&format!("{count} beds again and again under new rock"), Strata { new_rock: true, ..again });
        let uneven = Strata { surfaces: Surfaces::Lower, ..of(count) };
        keeps_books(&format!("{count} uneven beds"), uneven.clone());
        keeps_books(&format!("{count} uneven beds under new rock"), Strata { new_rock: true, ..uneven });
    }
    for (count, new_rock, repeat) in
        [(3, true, false), (9, true, true), (13, false, true), (13, true, false), (5, false, false)]
    {
        let mut soaked = Strata { soaked: true, new_rock, repeat, ..of(count) };
        soaked.beds.iter_mut().filter(|_| repeat).for_each(|b| b.thickness *= 4.0);
        keeps_books(&format!("{count} beds under water, new rock {new_rock}, again {repeat}"), soaked);
    }
    keeps_books("uneven beds under water", Strata { soaked: true, new_rock: true, surfaces: Surfaces::Lower, ..of(8) });
    let fold = Fold { wavelength: 90.0, amplitude: 9.0, direction: 60.0, crest: 0.0 };
    keeps_books("folded beds", Strata { folds: vec![fold], ..of(9) });
}

#[test]
fn materials_have_colours_of_their_own() {
    let mut beds = Strata { beds: many(2), ..Strata::default() };
    beds.materials[2].colour = Some("#a01020".into());
    beds.materials.push(Material { name: "chalk".into(), colour: None, ..Material::default() });
    let mut w = world([4, 4], 10.0, |_, _| 10.0);
    beds.check(&w.grid).unwrap();
    go(&mut w, &[scheduled(beds.clone())], 1);
    let below = eyot_strata::Subsurface::of(&w).unwrap();
    assert_eq!(below.kinds()[2].colour, [160, 16, 32]);
    assert_eq!(below.kinds()[7].colour, eyot_strata::materials::colour(7), "one by its number");
    let classes = eyot_strata::classes_of(&w, "material").unwrap();
    assert_eq!((classes[2].colour, classes[7].name), ([160, 16, 32], "chalk"));
    for wrong in ["red", "#12345", "#12345g", "a01020"] {
        beds.materials[2].colour = Some(wrong.into());
        let said = beds.check(&w.grid).unwrap_err().to_string();
        assert!(said.contains("materials.sandstone.colour") && said.contains("is no colour"), "{said}");
    }
}
