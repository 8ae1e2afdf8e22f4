//! Pictures of small worlds: same bytes on any number of threads, mirror symmetry, and no world too small or too odd.

use eyot_core::layer::known;
use eyot_core::{Boundary, Error, Field, Grid, Limits, World};
use eyot_render::{
    ColourMap, MapOptions, Picture, ReliefOptions, Setting, Stage, ViewOptions, layer_map, perspective, relief,
    terrain_colours,
};

fn world(w: usize, h: usize, f: impl FnMut(usize, usize) -> f32) -> World {
    let mut world = World::new(Grid::new(w, h, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
    world.put(&known::HEIGHT, Field::from_fn(w, h, f)).unwrap();
    world
}

/// A lopsided island with a lagoon.
fn island(n: usize) -> World {
    world(n, n, |x, y| {
        let (u, v) = (x as f32 / n as f32 - 0.55, y as f32 / n as f32 - 0.45);
        let r = u.hypot(v) * (1.0 + 0.3 * (7.0 * u.atan2(v)).sin() * u);
        4.0 * n as f32 * (0.25 - r) + 0.3 * ((x * 7 + y * 13) % 11) as f32
    })
}

fn small() -> ViewOptions {
    ViewOptions { width: 96, height: 54, ..ViewOptions::default() }
}

fn with_threads<T: Send>(n: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(f)
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let mut w = island(70);
    w.put(&known::WATER, Field::from_fn(70, 70, |x, _| if x == 30 { 0.8 } else { 0.001 })).unwrap();
    let draw = || {
        let block = ViewOptions { setting: Setting::Block, ..small() };
        [
            perspective(&w, &small()).unwrap(),
            perspective(&w, &block).unwrap(),
            relief(&w, &ReliefOptions::default()).unwrap(),
            layer_map(&w, "water", &MapOptions::default()).unwrap(),
        ]
    };
    let one = with_threads(1, draw);
    for n in [2, 3, 8] {
        assert!(one == with_threads(n, draw), "{n} threads");
    }
}

/// Flat, steep and long blocks, from the side and over a corner, in wide and in tall pictures.
#[test]
fn a_relief_model_is_seen_as_a_whole() {
    for (w, h, steep) in [(40, 40, 0.2), (40, 40, 20.0), (60, 20, 5.0), (20, 60, 5.0)] {
        let land = world(w, h, |x, y| steep * (x + y) as f32);
        for (azimuth_deg, width, height) in [(180.0, 320, 200), (205.0, 320, 200), (225.0, 320, 180), (225.0, 100, 300)]
        {
            let o = ViewOptions { azimuth_deg, width, height, setting: Setting::Block, ..ViewOptions::default() };
            let stage = Stage::new(&land, &o).unwrap();
            let (camera, [e, s]) = (stage.camera(&o), stage.size_m());
            let (low, high) = stage.tops().iter().fold((f32::MAX, f32::MIN), |(l, t), &v| (l.min(v), t.max(v)));
            for (x, y) in [(0.0, 0.0), (e, 0.0), (0.0, s), (e, s)] {
                for z in [stage.block_span(low, high).0, stage.height_at(x, y)] {
                    let p = [x - camera.eye[0], y - camera.eye[1], z - camera.eye[2]];
                    let [right, up, deep] =
                        [camera.right, camera.up, camera.forward].map(|a| a[0] * p[0] + a[1] * p[1] + a[2] * p[2]);
                    let aspect = width as f32 / height as f32;
                    let inside = right.abs() < camera.tan * aspect * deep && up.abs() < camera.tan * deep;
                    assert!(inside, "{w}x{h}, {steep}: corner {x}, {y}, {z} from {azimuth_deg} in {width}x{height}");
                }
            }
        }
    }
}

#[test]
fn a_mirrored_world_gives_a_mirrored_relief() {
    let n = 64;
    let w = island(n);
    let h = w.get("height").unwrap();
    let mirrored = world(n, n, |x, y| h.get(n - 1 - x, y));
    let o = ReliefOptions { variation: 0.0, min_size: 64, ..ReliefOptions::default() };
    let a = relief(&w, &o).unwrap();
    let b = relief(&mirrored, &ReliefOptions { sun_azimuth_deg: 360.0 - o.sun_azimuth_deg, ..o }).unwrap();
    let mut far = 0;
    for y in 0..a.height {
        for x in 0..a.width {
            let (p, q) = (a.get(x, y), b.get(a.width - 1 - x, y));
            far += usize::from((0..3).any(|k| p[k].abs_diff(q[k]) > 3));
        }
    }
    // Shadows are walked from both sides, so their edges may differ by a rounding here and there.
    assert!(far * 100 < a.pixels.len(), "{far} of {} pixels differ", a.pixels.len());
}

#[test]
fn no_grid_is_too_small_and_no_world_too_flat() {
    for (w, h) in [(1, 1), (1, 9), (9, 1), (2, 2), (3, 1), (1, 300), (17, 3)] {
        for level in [-10.0, 0.0, 1000.0] {
            for slope in [0.0, 3.0] {
                let mut world = world(w, h, |x, y| slope * (x + 2 * y) as f32);
                world.sea_level_m = level;
                world.ensure(&known::WATER, 0.0);
                world.ensure(&known::LIMESTONE, 1.0);
                assert_eq!(terrain_colours(&world).unwrap().len(), w * h);
                for setting in [Setting::Auto, Setting::Block, Setting::OpenSea] {
                    let o = ViewOptions { setting, ..small() };
                    assert_eq!(perspective(&world, &o).unwrap().pixels.len(), 96 * 54);
                }
                relief(&world, &ReliefOptions::default()).unwrap();
                for layer in ["height", "water", "limestone"] {
                    layer_map(&world, layer, &MapOptions::default()).unwrap();
                    layer_map(&world, layer, &MapOptions { log: Some(true), ..MapOptions::default() }).unwrap();
                }
            }
        }
    }
}

#[test]
fn odd_values_and_odd_options_are_survived() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 0.0];
    for kind in 0..odd.len() {
        let w = world(8, 8, |x, y| if x == y { odd[kind] } else { (x * y) as f32 });
        perspective(&w, &small()).unwrap();
        relief(&w, &ReliefOptions::default()).unwrap();
        layer_map(&w, "height", &MapOptions::default()).unwrap();
    }
    let w = island(24);
    for x in odd {
        let o = ViewOptions {
            azimuth_deg: x,
            elevation_deg: Some(x),
            distance: Some(x),
            field_of_view_deg: x,
            target: [x, x],
            target_height: Some(x),
            vertical_exaggeration: Some(x),
            sun_azimuth_deg: x,
            sun_elevation_deg: x,
            haze: x,
            clouds: x,
            exposure: x,
            sea_clarity_m: Some(x),
            ..small()
        };
        perspective(&w, &o).unwrap();
        perspective(&w, &ViewOptions { setting: Setting::Block, ..o }).unwrap();
        let o = ReliefOptions {
            sun_azimuth_deg: x,
            sun_elevation_deg: x,
            vertical_exaggeration: Some(x),
            shadows: x,
            variation: x,
            ..ReliefOptions::default()
        };
        relief(&w, &o).unwrap();
        layer_map(&w, "height", &MapOptions { range: Some((x, x)), hillshade: x, ..MapOptions::default() }).unwrap();
    }
    for (width, height, samples) in [(0, 0, 0), (1, 1, 1), (0, 7, 2), (7, 0, 99)] {
        let p = perspective(&w, &ViewOptions { width, height, samples, ..ViewOptions::default() }).unwrap();
        assert_eq!(p.pixels.len(), width * height);
    }
    for size in [0, 1, 5, 100_000] {
        relief(&w, &ReliefOptions { min_size: 0, max_size: size, ..ReliefOptions::default() }).unwrap();
        layer_map(&w, "height", &MapOptions { min_size: 0, max_size: size, ..MapOptions::default() }).unwrap();
    }
}

#[test]
fn a_missing_layer_is_an_error_that_lists_the_others() {
    let w = island(8);
    let e = layer_map(&w, "gold", &MapOptions::default()).unwrap_err();
    assert!(e.to_string().contains("gold") && e.to_string().contains("height"), "{e}");
    let empty = World::new(w.grid, 1);
    assert!(matches!(perspective(&empty, &small()), Err(Error::NoLayer { .. })));
    assert!(matches!(relief(&empty, &ReliefOptions::default()), Err(Error::NoLayer { .. })));
    assert!(matches!(terrain_colours(&empty), Err(Error::NoLayer { .. })));
}

#[test]
fn the_legend_can_be_left_out() {
    let w = island(16);
    let size = |legend| {
        let p = layer_map(&w, "height", &MapOptions { legend, min_size: 320, ..MapOptions::default() }).unwrap();
        (p.width, p.height)
    };
    assert_eq!(size(false), (320, 320));
    assert!(size(true).1 > 360);
}

#[test]
fn deeper_sea_is_darker_and_bluer() {
    // A ramp from the shore down to 80 m, high land at the west end.
    let w = world(256, 8, |x, _| if x < 10 { 60.0 } else { -0.35 * (x - 10) as f32 });
    let p = relief(&w, &ReliefOptions { variation: 0.0, min_size: 1, ..ReliefOptions::default() }).unwrap();
    let green = |x: usize| p.get(x, 4)[1];
    for x in (20..240).step_by(10) {
        assert!(green(x) + 1 >= green(x + 10), "column {x}: {} then {}", green(x), green(x + 10));
    }
    let deep = p.get(250, 4);
    assert!(deep[2] > deep[1] && deep[1] > deep[0], "{deep:?}");
}

#[test]
fn an_island_stands_in_an_endless_sea() {
    // The four corners of a picture from above look at open sea far outside the grid: no square, no void.
    let o = ViewOptions { elevation_deg: Some(80.0), distance: Some(4.0), haze: 0.0, ..small() };
    let p = perspective(&island(64), &o).unwrap();
    let corners = [p.get(0, 0), p.get(95, 0), p.get(0, 53), p.get(95, 53)];
    for c in corners {
        assert!(c[2] > c[0] + 20, "not sea: {c:?}");
        assert!((0..3).all(|k| c[k].abs_diff(corners[0][k]) < 40), "{corners:?}");
    }
}

#[test]
fn colour_maps_end_where_the_originals_do() {
    let bytes = |m: ColourMap, t: f32| m.at(t).map(|c| (c * 255.0).round() as u8);
    assert_eq!(bytes(ColourMap::Viridis, 0.0), [68, 1, 84]);
    assert_eq!(bytes(ColourMap::Viridis, 1.0), [253, 231, 37]);
    assert_eq!(bytes(ColourMap::Magma, 1.0), [252, 253, 191]);
    assert_eq!(bytes(ColourMap::Viridis, f32::NAN), [68, 1, 84]);
    let light = |m: ColourMap, t: f32| m.at(t).iter().zip([0.21, 0.72, 0.07]).map(|(c, k)| c * k).sum::<f32>();
    for m in [ColourMap::Viridis, ColourMap::Magma, ColourMap::Cividis] {
        for i in 0..50 {
            assert!(light(m, i as f32 / 50.0) < light(m, (i + 1) as f32 / 50.0) + 1e-3, "{m:?} at {i}");
        }
    }
}

#[test]
fn pictures_give_their_bytes() {
    let p = Picture::new(2, 1, [1, 2, 3]);
    assert_eq!(p.bytes(), [1, 2, 3, 1, 2, 3]);
}

#[test]
fn aridity_turns_green_land_into_desert() {
    let mut w = world(64, 64, |x, y| 900.0 + 60.0 * ((x * x + 3 * y) % 97) as f32 / 97.0 + 4.0 * y as f32);
    let reds = |w: &World| {
        let colours = terrain_colours(w).unwrap();
        colours.iter().filter(|c| c[0] > 1.2 * c[1]).count()
    };
    let none = reds(&w);
    w.put(&known::ARIDITY, Field::from_fn(64, 64, |x, _| if x < 32 { 1.0 } else { 0.0 })).unwrap();
    let half = reds(&w) - none;
    assert!((1200..=2048).contains(&half), "{half} of 2048 cells turned red, {none} were");
    w.put(&known::ARIDITY, Field::from_fn(64, 64, |_, _| f32::NAN)).unwrap();
    assert_eq!(reds(&w), none);
}
