//! What lies below the land, and what a line across it cuts through.

use crate::{go, scheduled, value, world};
use eyot_core::component::{Decoder, Encoder};
use eyot_core::layer::known::{LIMESTONE, SAND};
use eyot_core::{Boundary, Component, Field, Grid, Limits, World};
use eyot_strata::section::{areas_m2, check};
use eyot_strata::sequence::SEQUENCE;
use eyot_strata::{
    BED_SURFACES, BEDROCK, Bed, ERODIBILITY, Fault, Fold, NEW_ROCK, Section, Sequence, Strata, Subsurface, Surfaces,
};

fn bed(material: &str, thickness: f32) -> Bed {
    Bed { material: material.into(), thickness }
}

fn beds() -> Strata {
    Strata {
        beds: vec![bed("limestone", 20.0), bed("schist", 30.0), bed("granite", 50.0)],
        top: 100.0,
        regolith: 2.0,
        ..Strata::default()
    }
}

/// A hilly land of 30 x 20 cells of 10 m on beds, aged for a step.
fn land(strata: Strata) -> World {
    let hill = |x: usize, y: usize| 70.0 + 30.0 * (0.4 * x as f32).sin() * (0.3 * y as f32).cos();
    let mut w = world([30, 20], 10.0, hill);
    go(&mut w, &[scheduled(strata)], 1);
    w
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs().max(1.0)
}

/// Level beds below two steps of ground, computed by hand: 90 m high for 30 m, then 60 m high.
#[test]
fn areas_are_those_of_beds_computed_by_hand() {
    let mut w = world([10, 1], 10.0, |x, _| if x < 3 { 90.0 } else { 60.0 });
    go(&mut w, &[scheduled(beds())], 1);
    let section = Section::along(&w, &[[0.0, 5.0], [100.0, 5.0]], 0.0).unwrap();
    let areas = section.areas_m2();
    let area = |name: &str| areas[section.kinds.iter().position(|k| k.name == name).unwrap()];
    // Of each column: 2 m of regolith; limestone down to 80, schist to 50, granite below.
    assert!(near(area("regolith"), 100.0 * 2.0));
    assert!(near(area("limestone"), 30.0 * 8.0));
    assert!(near(area("schist"), 30.0 * 30.0 + 70.0 * 8.0));
    assert!(near(area("granite"), 100.0 * 50.0));
    assert!(near(areas.iter().sum(), 30.0 * 90.0 + 70.0 * 60.0) && section.length_m == 100.0);
    // Half of the line, and down to 70 m only.
    let section = Section::along(&w, &[[15.0, 5.0], [65.0, 5.0]], 70.0).unwrap();
    assert!(near(section.areas_m2()[3], 15.0 * 8.0) && near(section.areas_m2().iter().sum(), 15.0 * 20.0));
}

#[test]
fn sections_of_all_rows_hold_the_volume_of_all_columns() {
    let bent = Strata {
        dip: 12.0,
        folds: vec![Fold { wavelength: 90.0, amplitude: 9.0, direction: 60.0, crest: 0.0 }],
        faults: vec![Fault { strike: 30.0, distance: 7.0, throw: 25.0 }],
        repeat: true,
        ..beds()
    };
    let w = land(bent);
    let below = Subsurface::of(&w).unwrap();
    let (mut columns, mut runs) = (vec![0.0; below.kinds().len()], Vec::new());
    for (x, y) in (0..20).flat_map(|y| (0..30).map(move |x| (x, y))) {
        below.of_cell(x, y, -150.0, &mut runs);
        runs.iter().for_each(|r| columns[r.kind] += 100.0 * r.thickness_m());
        // One on the other from the surface to the floor, and what is on top is what the layer says.
        assert!(near(runs[0].top_m, f64::from(value(&w, "height", x, y))) && runs[runs.len() - 1].bottom_m == -150.0);
        assert!(runs.windows(2).all(|r| r[0].bottom_m == r[1].top_m && r[0].thickness_m() > 0.0));
        assert_eq!(runs[0].kind as f32, value(&w, "material", x, y), "{runs:?}");
    }
    let mut volumes = vec![0.0; columns.len()];
    for y in 0..20 {
        let north = 10.0 * y as f64 + 5.0;
        let section = Section::along(&w, &[[0.0, north], [110.0, north], [300.0, north]], -150.0).unwrap();
        volumes.iter_mut().zip(section.areas_m2()).for_each(|(v, a)| *v += 10.0 * a);
    }
    assert!(columns.iter().filter(|v| **v > 0.0).count() == 4, "{columns:?}");
    assert!(volumes.iter().zip(&columns).all(|(v, c)| near(*v, *c)), "{volumes:?} {columns:?}");
}

/// New rock and beds with bottoms of their own, by hand: what the layer `material` says is what lies on top.
#[test]
fn columns_have_new_rock_and_bent_beds() {
    let beds = Strata { new_rock: true, surfaces: Surfaces::Lower, regolith: 0.0, ..beds() };
    let mut w = world([2, 1], 10.0, |_, _| 90.0);
    w.put(&BEDROCK, Field::new(2, 1, 89.0)).unwrap();
    // The first bed ends 5 m lower in the second cell; 2 m of sandstone and 3 m of marble have hardened there.
    w.put(&BED_SURFACES[0], Field::from_fn(2, 1, |x, _| 5.0 * x as f32)).unwrap();
    w.put(&NEW_ROCK[1], Field::from_fn(2, 1, |x, _| 2.0 * x as f32)).unwrap();
    w.put(&NEW_ROCK[4], Field::from_fn(2, 1, |x, _| 3.0 * x as f32)).unwrap();
    w.put(&ERODIBILITY, Field::new(2, 1, 1.0)).unwrap();
    go(&mut w, &[scheduled(beds.clone())], 1);
    let below = Subsurface::of(&w).unwrap();
    let mut runs = Vec::new();
    let mut column = |x| {
        below.of_cell(x, 0, 0.0, &mut runs);
        runs.iter().map(|r| (below.kinds()[r.kind].name.clone(), r.bottom_m)).collect::<Vec<_>>()
    };
    let of = |name: &str, bottom: f64| (name.to_owned(), bottom);
    assert_eq!(column(0), [of("regolith", 89.0), of("limestone", 80.0), of("schist", 50.0), of("granite", 0.0)]);
    let second = [
        of("regolith", 89.0),
        of("sandstone", 87.0),
        of("marble", 84.0),
        of("limestone", 75.0),
        of("schist", 50.0),
        of("granite", 0.0),
    ];
    assert_eq!(column(1), second);
    // Heights of bottoms: the first at 70 m, and the second, which would lie above it, nowhere.
    w.put(&BED_SURFACES[0], Field::new(2, 1, 70.0)).unwrap();
    w.put(&BED_SURFACES[1], Field::new(2, 1, 85.0)).unwrap();
    go(&mut w, &[scheduled(Strata { surfaces: Surfaces::Height, ..beds })], 1);
    let below = Subsurface::of(&w).unwrap();
    below.of_cell(0, 0, 0.0, &mut runs);
    let kinds: Vec<_> = runs.iter().map(|r| (r.kind, r.bottom_m)).collect();
    assert_eq!(kinds, [(0, 89.0), (3, 70.0), (6, 0.0)]);
}

#[test]
fn lines_pass_every_cell_between_their_ends() {
    let w = land(beds());
    let section = Section::along(&w, &[[5.0, 5.0], [295.0, 195.0], [295.0, 40.0]], 0.0).unwrap();
    let way = (290.0f64).hypot(190.0);
    assert!(near(section.length_m, way + 155.0));
    assert!(section.pieces.windows(2).all(|p| p[0].to_m == p[1].from_m || near(p[0].to_m, p[1].from_m)));
    assert_eq!((section.pieces[0].cell, section.pieces[section.pieces.len() - 1].cell), ([0, 0], [29, 4]));
    // From one cell to one that touches it.
    let apart = |p: &[eyot_strata::Piece]| (0..2).map(|i| p[0].cell[i].abs_diff(p[1].cell[i])).sum::<usize>();
    assert!(section.pieces.windows(2).all(|p| apart(p) <= 2));
    assert!(near(section.pieces.iter().map(|p| p.to_m - p.from_m).sum(), section.length_m));
    let grid = w.grid;
    for (line, words) in [
        (vec![[0.0, 0.0], [301.0, 0.0]], "(301 m, 0 m) lies outside the land of 300 x 200 m"),
        (vec![[0.0, 0.0], [0.0, f64::NAN]], "lies outside"),
        (vec![[5.0, 5.0], [5.0, 5.0]], "two points that differ"),
        (vec![[5.0, 5.0], [5.0 + 1e-9, 5.0]], "two points that differ"),
        (vec![[5.0, 5.0]], "two points"),
        (vec![[0.0, 0.0], [1e300, 0.0]], "(1e300 m, 0 m) lies outside"),
        ((0..101).map(|i| [f64::from(i), 0.0]).collect(), "at most 100 points, this one has 101"),
        (vec![], "two points"),
    ] {
        let said = check(&grid, &line).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
}

/// Far thinner beds than a column has runs for: shares of the ground are those of the sequence.
#[test]
fn areas_are_right_however_thin_the_beds_are() {
    let thin = vec![bed("sand", 0.05), bed("marble", 0.15), bed("granite", 0.1)];
    let w = land(Strata { beds: thin, repeat: true, dip: 20.0, regolith: 0.0, ..beds() });
    let below = Subsurface::of(&w).unwrap();
    let line = [[0.0, 105.0], [300.0, 105.0]];
    let areas = areas_m2(&below, &w.grid, &line, -2000.0).unwrap();
    let whole: f64 = areas.iter().sum();
    for (kind, share) in [(1, 1.0 / 6.0), (5, 0.5), (6, 1.0 / 3.0)] {
        assert!((areas[kind] / whole - share).abs() < 1e-3, "{kind}: {} of {whole}", areas[kind]);
    }
    // Where the list of runs holds all of them, both ways agree.
    let w = land(Strata { repeat: true, ..beds() });
    let below = Subsurface::of(&w).unwrap();
    let both = [areas_m2(&below, &w.grid, &line, -500.0), Section::along(&w, &line, -500.0).map(|s| s.areas_m2())];
    let [a, b] = both.map(Result::unwrap);
    assert!(a.iter().zip(&b).all(|(a, b)| near(*a, *b)), "{a:?} {b:?}");
}

/// Between cells, planes stay planes and faults stay steps.
#[test]
fn beds_between_cells_dip_and_break_as_they_do_in_cells() {
    let dip = 10.0f64;
    let fault = Fault { strike: 0.0, distance: 0.0, throw: 40.0 };
    let w = land(Strata { dip: dip as f32, faults: vec![fault], ..beds() });
    let below = Subsurface::of(&w).unwrap();
    let mut runs = Vec::new();
    for i in 0..290 {
        let x = 0.1 * f64::from(i);
        below.at(x, 7.3, -300.0, &mut runs);
        // The fault lies between the cells 14 and 15.
        let throw = if x < 14.5 { 0.0 } else { 40.0 };
        let datum = 100.0 + throw - 10.0 * (x - 14.5) * dip.to_radians().tan();
        let schist = runs.iter().find(|r| r.bed == Some(1)).map(|r| r.bottom_m);
        assert!(schist.is_none_or(|z| (z - (datum - 50.0)).abs() < 1e-3), "{x}: {schist:?}, {}", datum - 50.0);
    }
}

#[test]
fn worlds_without_strata_have_ground_below_sand_and_limestone() {
    let mut w = world([3, 1], 10.0, |_, _| 50.0);
    w.put(&SAND, Field::from_fn(3, 1, |x, _| x as f32)).unwrap();
    w.put(&LIMESTONE, Field::from_fn(3, 1, |x, _| if x == 2 { 4.0 } else { 0.0 })).unwrap();
    let below = Subsurface::of(&w).unwrap();
    assert!(below.sequence().is_none());
    let mut runs = Vec::new();
    let mut names = |x| {
        below.of_cell(x, 0, 10.0, &mut runs);
        runs.iter().map(|r| (below.kinds()[r.kind].name.clone(), r.thickness_m())).collect::<Vec<_>>()
    };
    let of = |name: &str, thickness| (name.to_owned(), thickness);
    assert_eq!(names(0), [of("ground", 40.0)]);
    assert_eq!(names(1), [of("sand and soil", 1.0), of("ground", 39.0)]);
    assert_eq!(names(2), [of("sand and soil", 2.0), of("reef limestone", 4.0), of("ground", 34.0)]);
    // What would lie below the floor is not there.
    below.of_cell(0, 0, 60.0, &mut runs);
    assert!(runs.is_empty());
}

#[test]
fn worlds_know_their_beds_and_files_give_them_back() {
    let w = land(beds());
    let sequence = Sequence::of(&w).unwrap().unwrap();
    assert_eq!(sequence, &beds().sequence().unwrap());
    assert_eq!((sequence.loose, sequence.thickness_m()), (0, 100.0));
    let mut bytes = Vec::new();
    let mut out = Encoder::new(&mut bytes);
    sequence.encode(&mut out);
    out.finish().unwrap();
    let grid = Grid::new(4, 4, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
    let limits = Limits::default();
    let read_as = |version: u32, bytes: &[u8]| {
        let mut input = bytes;
        let mut from = Decoder::new("strata", &mut input, bytes.len() as u64, &grid, &limits);
        let component = (SEQUENCE.decode)(version, &mut from)?;
        from.finish().map(|()| component)
    };
    let read = |bytes: &[u8]| read_as(2, bytes);
    assert!(read(&bytes).unwrap().equals(sequence));
    // Version 1 had no colours: an empty text after the name and three numbers of each of seven materials.
    let mut empty = Vec::new();
    let mut out = Encoder::new(&mut empty);
    out.text("");
    out.finish().unwrap();
    let (mut former, mut at) = (vec![bytes[0]], 1);
    for m in &sequence.materials {
        let end = at + empty.len() + m.name.len() + 12;
        former.extend(&bytes[at..end]);
        at = end + empty.len();
    }
    former.extend(&bytes[at..]);
    assert!(read_as(1, &former).unwrap().equals(sequence));
    // Cut short anywhere, or of a material that is not there.
    assert!((0..bytes.len()).all(|n| read(&bytes[..n]).is_err()));
    // The material of the last bed: before its thickness, the kind of surfaces, the top, and no stages.
    let last = bytes.len() - 11;
    assert_eq!(bytes[last], 6);
    bytes[last] = 200;
    assert!(read(&bytes).is_err());
}
