//! Grid, fields, layers, limits, ledger, random numbers and the world: what goes in comes out.

use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::rng::{self, Key};
use eyot_core::{Boundary, BoundaryCondition, Centering, Error, Field, Grid, LayerSpec, Ledger, Limits, World};
use proptest::prelude::*;

fn grid(width: usize, height: usize) -> Grid {
    Grid::new(width, height, 10.0, Boundary::OPEN, &Limits::default()).unwrap()
}

const FACES: LayerSpec = LayerSpec::new("faces", "1", "On faces", (-1.0, 1.0)).on(Centering::FaceX);

// ---------------------------------------------------------------------------------------------------------------- Grid

#[test]
fn unsound_grids_are_refused() {
    let new = |w, h, cell| Grid::new(w, h, cell, Boundary::CLOSED, &Limits::default());
    assert!(new(1, 1, 1e-6).is_ok() && new(1, 1, 1e7).is_ok());
    for (w, h, cell) in [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.0), (1, 1, -1.0), (1, 1, f64::NAN), (1, 1, f64::INFINITY)] {
        assert!(matches!(new(w, h, cell), Err(Error::BadGrid(_))), "{w}x{h} of {cell} m");
    }
    assert!(matches!(Grid { cell_y_m: 0.0, ..grid(2, 2) }.checked(&Limits::default()), Err(Error::BadGrid(_))));
    // The product must not wrap around on its way to the comparison.
    assert!(matches!(new(usize::MAX, usize::MAX, 1.0), Err(Error::Limit { .. })));
    assert!(matches!(new(1 << 31, 1 << 33, 1.0), Err(Error::Limit { .. })));
}

#[test]
fn limits_name_what_they_refuse() {
    let l = Limits { max_cells: 12, max_bytes: 1 << 20, ..Limits::default() };
    assert!(l.check_cells(4, 3).is_ok() && l.check_bytes("x", 1 << 20).is_ok());
    let message = l.check_cells(13, 1).unwrap_err().to_string();
    assert!(message.contains("13 x 1") && message.contains("12 cells"), "{message}");
    let message = l.check_bytes("the picture", (1 << 20) + 1).unwrap_err().to_string();
    assert!(message.contains("the picture"), "{message}");
    assert!(l.check_bytes("x", u128::MAX).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn columns_beyond_the_rim_are_resolved(width in 1..50usize, x in -200..200isize) {
        let g = |edge| Grid { rim: Boundary::both(edge), ..grid(width, 1) };
        for edge in [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap] {
            let inside = g(edge).wrap_x(x);
            prop_assert!(inside < width);
            if (0..width as isize).contains(&x) {
                prop_assert_eq!(inside, x as usize);
            } else if edge == BoundaryCondition::Wrap {
                prop_assert_eq!((inside as isize - x).rem_euclid(width as isize), 0);
            } else {
                prop_assert_eq!(inside, if x < 0 { 0 } else { width - 1 });
            }
        }
        prop_assert_eq!(g(BoundaryCondition::Closed).wrap_y(x), 0);
    }

    // ----------------------------------------------------------------------------------------------------------- Field

    #[test]
    fn fields_keep_what_they_are_given(width in 0..70usize, height in 0..20usize, cache_offset in 0..100usize, seed: u64) {
        let value = |x: usize, y: usize| rng::unit::<f32>(rng::hash(Key::new(seed, 0, 0), (y * 100 + x) as u32)) - 0.5;
        let values: Vec<f32> = (0..height).flat_map(|y| (0..width).map(move |x| value(x, y))).collect();
        let f = Field::from_slice(width, height, &values).unwrap();
        prop_assert_eq!((f.width(), f.height()), (width, height));
        prop_assert_eq!(f.to_vec(), values.clone());
        prop_assert_eq!(&Field::from_fn(width, height, value), &f);
        prop_assert_eq!(f.iter().collect::<Vec<_>>(), values.clone());
        prop_assert_eq!(f.rows().len(), height);

        let mut s = Field::with_cache_offset(width, height, 3.0, cache_offset);
        prop_assert!(s.iter().all(|v| v == 3.0));
        s.rows_mut().enumerate().for_each(|(y, r)| r.iter_mut().enumerate().for_each(|(x, v)| *v = value(x, y)));
        prop_assert_eq!(&s, &f);
        let sum: f64 = values.iter().map(|&v| f64::from(v)).sum();
        prop_assert!((f.sum() - sum).abs() < 1e-9);
        s.map_in_place(|v| v + 1.0);
        prop_assert!(values.is_empty() || s != f);
        if let Some(&v) = values.first() {
            prop_assert_eq!(f.get(0, 0), v);
            s.set(width - 1, height - 1, f32::NAN);
            let (x, y, _) = s.find_not_finite().unwrap();
            prop_assert_eq!((x, y), (width - 1, height - 1));
            let (low, high) = f.min_max();
            prop_assert_eq!(low, values.iter().copied().fold(f32::INFINITY, f32::min));
            prop_assert_eq!(high, values.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        }
    }

    #[test]
    fn outer_faces_round_trip_and_survive_a_clone(width in 1..40usize, height in 1..20usize) {
        let faces: Vec<f32> = (0..width + height).map(|i| i as f32 + 1.0).collect();
        let mut f = Field::new(width, height, 0.0);
        f.set_outer_faces(&faces).unwrap();
        prop_assert!(f.iter().all(|v| v == 0.0), "the interior is not touched");
        prop_assert_eq!(f.outer_faces(), faces.clone());
        prop_assert_eq!(f.clone().outer_faces(), faces.clone());
        prop_assert!(f.set_outer_faces(&faces[1..]).is_err());
    }
}

#[test]
fn values_that_are_not_finite_are_found() {
    let mut f = Field::new(33, 5, f32::MAX);
    assert_eq!(f.find_not_finite(), None, "a sum that overflows is no reason");
    f.set(20, 3, f32::NEG_INFINITY);
    f.set(5, 4, f32::NAN);
    assert_eq!(f.find_not_finite(), Some((20, 3, f32::NEG_INFINITY)));
    let mut w = World::new(grid(33, 5), 1);
    w.put(&HEIGHT, f).unwrap();
    let message = w.check_finite("step 7").unwrap_err().to_string();
    assert!(
        message.contains("`height`") && message.contains("column 20, row 3") && message.contains("step 7"),
        "{message}"
    );
}

#[test]
fn slices_of_the_wrong_length_are_refused() {
    assert!(matches!(Field::from_slice(3, 2, &[0.0; 5]), Err(Error::Shape { expected: 6, found: 5, .. })));
    let mut w = World::new(grid(3, 2), 1);
    assert!(matches!(w.put(&HEIGHT, Field::new(2, 3, 0.0)), Err(Error::Shape { .. })));
}

#[test]
fn layers_on_faces_differ_by_their_outer_faces_and_others_do_not() {
    for (spec, differs) in [(FACES, true), (HEIGHT, false)] {
        let mut a = World::new(grid(4, 3), 1);
        a.ensure(&spec, 1.0);
        let mut b = a.clone();
        assert_eq!(a, b);
        b.layer_mut(&spec.name).unwrap().field.set_outer_faces(&[2.0; 7]).unwrap();
        assert_eq!(a != b, differs, "{}", spec.name);
    }
}

// --------------------------------------------------------------------------------------------------------------- World

#[test]
fn layers_are_made_found_replaced_and_removed() {
    let mut w = World::new(grid(4, 3), 1);
    w.ensure(&HEIGHT, 2.0);
    w.ensure(&HEIGHT, 9.0);
    assert_eq!(w.get("height").unwrap().min_max(), (2.0, 2.0), "a layer that exists keeps its values");
    w.put(&WATER, Field::new(4, 3, 1.0)).unwrap();
    w.put(&WATER, Field::new(4, 3, 5.0)).unwrap();
    assert_eq!(w.layers().len(), 2);
    assert_eq!(w.layer("water").unwrap().field.get(3, 2), 5.0);
    let message = w.layer("wind").unwrap_err().to_string();
    assert!(message.contains("wind") && message.contains("height, water"), "{message}");
    assert!(w.remove("water").is_some() && w.remove("water").is_none());
}

#[test]
fn fingerprints_see_every_bit() {
    let mut w = World::new(grid(5, 4), 1);
    w.ensure(&HEIGHT, 1.0);
    w.ensure(&FACES, 0.0);
    let first = w.fingerprint();
    assert_eq!(w.clone().fingerprint(), first);
    let changes: [&dyn Fn(&mut World); 6] = [
        &|w| w.layer_mut("height").unwrap().field.set(4, 3, f32::from_bits(1.0f32.to_bits() + 1)),
        &|w| w.layer_mut("faces").unwrap().field.set(0, 0, -0.0),
        &|w| w.layer_mut("faces").unwrap().field.set_outer_faces(&[1e-30; 9]).unwrap(),
        &|w| w.step += 1,
        &|w| w.sea_level_m = -0.0,
        &|w| drop(w.remove("faces")),
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut other = w.clone();
        change(&mut other);
        assert_ne!(other.fingerprint(), first, "change {i}");
    }
}

// -------------------------------------------------------------------------------------------------------------- Ledger

#[test]
fn the_ledger_adds_up_by_material() {
    let mut l = Ledger::default();
    l.add("water.rain", 3.0, "m3", "Rain", 1);
    l.add("water.rain", 2.0, "m3", "Rain", 1);
    l.add("water.drained", 4.5, "m3", "Drained", -1);
    l.add("water.moved", 100.0, "m3", "Only reports", 0);
    l.add("ground.left", 7.0, "m3", "Left", -1);
    l.add("waters.of.elsewhere", 1.0, "m3", "Another material", 1);
    assert_eq!((l.amount("water.rain"), l.amount("water.snow")), (5.0, 0.0));
    assert_eq!((l.net("water"), l.net("ground"), l.net("lava")), (0.5, -7.0, 0.0));
    let names: Vec<&str> = l.iter().map(|(n, _)| n).collect();
    assert!(names.is_sorted(), "{names:?}");
    let text = serde_json::to_string(&l).unwrap();
    assert_eq!(serde_json::from_str::<Ledger>(&text).unwrap(), l);
}

#[test]
fn grids_and_layers_round_trip_as_json() {
    let g = Grid {
        cell_y_m: 0.1 + 0.2,
        rim: Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open },
        ..grid(7, 9)
    };
    assert_eq!(serde_json::from_str::<Grid>(&serde_json::to_string(&g).unwrap()).unwrap(), g);
    assert_eq!(serde_json::from_str::<LayerSpec>(&serde_json::to_string(&FACES).unwrap()).unwrap(), FACES);
}

// ------------------------------------------------------------------------------------------------------ Random numbers

/// Recipes and seeds that people share must mean the same for ever.
#[test]
fn random_numbers_are_pinned() {
    assert_eq!(rng::mix64(0), 0xe220_a839_7b1d_cdaf, "SplitMix64's first number from seed 0, as published");
    let bits = |seed, stream, step, cell: u32| rng::hash(Key::new(seed, stream, step), cell);
    let got = [bits(0, 0, 0, 0), bits(7, 1, 2, 3), bits(u64::MAX, u32::MAX, u64::MAX, u32::MAX)];
    assert_eq!(got, [0xc5b3_00b2, 0x0091_5e49, 0x7160_41c0], "{got:#x?}");
}

#[test]
fn unit_numbers_stay_below_one() {
    assert_eq!(rng::unit::<f32>(0), 0.0);
    assert!(rng::unit::<f32>(u32::MAX) < 1.0);
    assert_eq!(f64::from(rng::unit::<f32>(u32::MAX)), 1.0 - 1.0 / 16_777_216.0);
}

#[test]
fn a_strided_view_shows_the_values_without_a_copy() {
    let mut f = Field::from_fn(5, 3, |x, y| (10 * y + x) as f32);
    assert_eq!(f.shape(), [3, 5]);
    let (values, stride) = f.as_strided();
    assert!(stride > 5 && values.len() == 2 * stride + 5);
    assert!(std::ptr::eq(&raw const values[stride + 2], &raw const f.row(1)[2]));
    for (y, row) in values.chunks(stride).enumerate() {
        assert_eq!(&row[..5], f.row(y));
    }
    let (values, stride) = f.as_strided_mut();
    values[2 * stride + 4] = -1.0;
    assert_eq!(f.get(4, 2), -1.0);
    assert!(Field::new(0, 3, 0.0).as_strided().0.is_empty() && Field::new(3, 0, 0.0).as_strided().0.is_empty());
}
