//! Pictures of small worlds: same bytes on any number of threads, mirror symmetry, and no world too small or too odd.

use eyot_core::layer::known;
use eyot_core::{Boundary, Error, Field, Grid, Limits, World};
use eyot_render::cover::{HALO, LAYERS, Strip};
use eyot_render::{
    CameraPath, Class, ColourMap, Cover, Looks, MapOptions, Palette, Picture, ReliefOptions, Season, Setting, Stage,
    ViewOptions, layer_map, perspective, relief, terrain_colours,
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

/// How far the highest `land` reaches to the left, right, top and bottom of a picture of that aspect; 1 is its edge.
fn reach(stage: &Stage, o: &ViewOptions, land: impl Fn(f32) -> bool) -> [f32; 4] {
    let (camera, [w, h], cell) = (stage.camera(o), stage.cells(), stage.cell_m());
    let aspect = o.width as f32 / o.height as f32;
    let mut most = [0.0f32; 4];
    for i in (0..w * h).filter(|&i| land(stage.tops()[i])) {
        let p = [(i % w) as f32 * cell[0], (i / w) as f32 * cell[1], stage.tops()[i]];
        let p: [f32; 3] = std::array::from_fn(|k| p[k] - camera.eye[k]);
        let [right, up, deep] =
            [camera.right, camera.up, camera.forward].map(|a| a[0] * p[0] + a[1] * p[1] + a[2] * p[2]);
        assert!(deep > 0.0, "land behind the camera");
        let (x, y) = (right / (camera.tan * aspect * deep), up / (camera.tan * deep));
        for (m, v) in most.iter_mut().zip([-x, x, y, -y]) {
            *m = m.max(v);
        }
    }
    most
}

/// Whatever its shape, its place in the grid and the picture's shape: the land is not cut off and as large as it can be.
#[test]
fn an_island_fills_the_picture() {
    let hill = |x: f32, y: f32, long: f32, high: f32| {
        world(96, 96, move |i, j| high * (1.0 - ((i as f32 - x) / long).hypot((j as f32 - y) / 8.0)))
    };
    for land in [hill(48.0, 48.0, 20.0, 60.0), hill(30.0, 70.0, 22.0, 300.0), hill(66.0, 20.0, 8.0, 200.0)] {
        for (width, height) in [(320, 200), (100, 300), (600, 100)] {
            for (azimuth_deg, elevation_deg) in [(180.0, None), (230.0, Some(40.0)), (90.0, Some(80.0))] {
                let o = ViewOptions { width, height, azimuth_deg, elevation_deg, ..ViewOptions::default() };
                let stage = Stage::new(&land, &o).unwrap();
                let [left, right, top, bottom] = reach(&stage, &o, |z| z > 0.0);
                let all = [left, right, top, bottom];
                assert!(all.iter().all(|m| *m < 0.99), "{width}x{height} from {azimuth_deg}: {all:?}");
                // It reaches across the picture one way or the other, and stands in its middle.
                assert!(left.min(right) > 0.8 || top.min(bottom) > 0.65, "{width}x{height}: {all:?}");
                assert!((left - right).abs() < 0.15, "{width}x{height} from {azimuth_deg}: {all:?}");
                assert!((top - bottom).abs() < 0.25, "{width}x{height} from {azimuth_deg}: {all:?}");
            }
        }
    }
}

/// A turn around the land cuts off none of it, from wherever, and a later state of the world moves no camera.
#[test]
fn an_orbit_shows_every_side_and_cameras_stay() {
    let long = world(96, 96, |x, y| 90.0 * (1.0 - ((x as f32 - 40.0) / 30.0).hypot((y as f32 - 60.0) / 9.0)));
    for elevation_deg in [None, Some(35.0)] {
        let o = ViewOptions { elevation_deg, ..small() };
        let mut stage = Stage::new(&long, &o).unwrap();
        let orbit = CameraPath::orbit(&stage, &o);
        for i in 0..24 {
            let p = orbit.pose(i as f32 / 24.0);
            let from = ViewOptions {
                azimuth_deg: p.azimuth_deg,
                distance: Some(p.distance),
                target: Some(p.target),
                target_height: Some(p.target_height),
                ..o.clone()
            };
            let all = reach(&stage, &from, |z| z > 0.0);
            assert!(all.iter().all(|m| *m < 1.0), "{i}: {all:?}");
            assert!(all.iter().any(|m| *m > 0.4), "{i}: {all:?}");
        }
        let before = stage.camera(&o);
        stage.follow(&world(96, 96, |x, _| x as f32)).unwrap();
        assert_eq!(stage.camera(&o), before);
    }
}

/// Heights are drawn to scale unless somebody asks.
#[test]
fn heights_are_drawn_to_scale() {
    let flat = world(50, 50, |x, y| 100.0 + 0.1 * (x + y) as f32);
    assert_eq!(Stage::new(&flat, &ViewOptions::default()).unwrap().exaggeration, 1.0);
    let asked = ViewOptions { vertical_exaggeration: 3.0, ..ViewOptions::default() };
    assert_eq!(Stage::new(&flat, &asked).unwrap().exaggeration, 3.0);
}

/// Bare noise from the foot of mountains to their tops.
fn mountains(n: usize) -> World {
    let mut w = world(n, n, |x, y| {
        let (x, y) = (x as f32 * 0.018, y as f32 * 0.018);
        2100.0 + 3800.0 * eyot_noise::picture::fbm(x, y, 4, 3)
    });
    w.grid.cell_x_m = 150.0;
    w.grid.cell_y_m = 150.0;
    w.sea_level_m = -1000.0;
    w
}

/// The shares of the land's classes, and the mean colours of a tenth of the land each, from the lowest to the highest.
fn tenths(w: &World, looks: &Looks) -> Vec<[f32; 3]> {
    let colours = terrain_colours(w, looks).unwrap();
    let height = w.get("height").unwrap();
    let mut order: Vec<(f32, [f32; 3])> = height.iter().zip(colours).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mean = |part: &[(f32, [f32; 3])]| {
        std::array::from_fn(|k| part.iter().map(|(_, c)| c[k]).sum::<f32>() / part.len() as f32)
    };
    order.chunks(order.len().div_ceil(10)).map(mean).collect()
}

/// Bare noise is woods and meadows at its foot, stone higher up and snow on top: most of it is not of one colour, and no green shouts.
#[test]
fn bare_mountains_are_green_grey_and_white() {
    let w = mountains(128);
    let [low, middle, high] = [0, 6, 9].map(|i| tenths(&w, &Looks::default())[i]);
    let sum = |c: [f32; 3]| c[0] + c[1] + c[2];
    assert!(low[1] > low[0] && low[1] > 1.3 * low[2], "the foot is not green: {low:?}");
    assert!(low[1] < 1.6 * low[0], "the green is not muted: {low:?}");
    assert!(middle[0] >= 0.95 * middle[1] && sum(middle) > sum(low), "no stone: {middle:?}");
    assert!(high[2] > 0.9 * high[0] && sum(high) > 2.0 * sum(middle), "no snow: {high:?}");
    // Each class has its place, none all of it.
    let strip = Strip::whole(&w);
    let cover = Cover::new([150.0; 2], 0.0, -1000.0, 5, &Looks::default());
    let mut shares = [0.0; Class::ALL.len()];
    for i in 0..128 * 128 {
        let weights = cover.weights(&strip, i % 128, i / 128);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-4 && weights.iter().all(|w| (0.0..=1.0).contains(w)));
        shares.iter_mut().zip(weights).for_each(|(s, w)| *s += w / (128.0 * 128.0));
    }
    assert!(shares.iter().all(|s| *s < 0.5), "{shares:?}");
    for class in [Class::Forest, Class::Grass, Class::Scree, Class::Rock, Class::Snow] {
        assert!(shares[class as usize] > 0.02, "{class:?}: {shares:?}");
    }
    assert!(shares[Class::SeaFloor as usize] + shares[Class::Sand as usize] < 0.01, "{shares:?}");
}

/// Each palette, line, season and ramp changes the picture in its own way.
#[test]
fn looks_are_a_choice() {
    let w = mountains(64);
    let top = |looks: &Looks| tenths(&w, looks)[9].iter().sum::<f32>();
    let plain = Looks::default();
    let deep = Looks { snow_line_m: Some(200.0), ..plain.clone() };
    let none = Looks { snow_line_m: Some(9000.0), ..plain.clone() };
    assert!(tenths(&w, &deep)[3][2] > 2.0 * tenths(&w, &plain)[3][2], "the snow line does nothing");
    assert!(top(&none) < 0.8 * top(&plain), "the snow line does nothing");
    let bare = tenths(&w, &Looks { tree_line_m: Some(-500.0), ..plain.clone() })[1];
    let woods = tenths(&w, &Looks { tree_line_m: Some(5000.0), snow_line_m: Some(9000.0), ..plain.clone() })[1];
    assert!(bare.iter().sum::<f32>() > 1.3 * woods.iter().sum::<f32>(), "{bare:?}, {woods:?}");
    let season = |season| terrain_colours(&w, &Looks { season, ..plain.clone() }).unwrap();
    let palette = |palette| terrain_colours(&w, &Looks { palette, ..plain.clone() }).unwrap();
    let all = [
        season(Season::Spring),
        season(Season::Autumn),
        season(Season::Winter),
        palette(Palette::Temperate),
        palette(Palette::Tropical),
        palette(Palette::Alpine),
        palette(Palette::Desert),
        palette(Palette::Arctic),
        palette(Palette::Volcanic),
    ];
    for (i, a) in all.iter().enumerate() {
        for b in &all[..i] {
            let differ = a.iter().zip(b).filter(|(a, b)| (0..3).any(|k| (a[k] - b[k]).abs() > 0.01)).count();
            assert!(differ * 5 > a.len(), "{differ} of {} cells differ", a.len());
        }
    }
    let ramp = vec![(0.0, [0.5, 0.0, 0.0]), (3000.0, [0.0, 0.0, 0.5])];
    let [low, .., high] = tenths(&w, &Looks { ramp, ..plain })[..] else { panic!() };
    assert!(
        low[0] > 3.0 * low[1] && low[0] > low[2] && high[2] > high[0] && high[2] > 3.0 * high[1],
        "{low:?} {high:?}"
    );
}

/// A low islet on a reef: sand at the water, palms in the middle, and nothing under it but pale sea floor and reef.
#[test]
fn islets_are_sand_with_palms() {
    let mut w = world(80, 80, |x, y| 3.2 - 0.012 * ((x as f32 - 40.0).powi(2) + (y as f32 - 40.0).powi(2)));
    w.put(&known::LIMESTONE, Field::from_fn(80, 80, |_, _| 5.0)).unwrap();
    let strip = Strip::whole(&w);
    let looks = Looks::default().resolved(|layer| w.get(layer).is_some());
    assert_eq!(looks.palette, Palette::Tropical);
    let cover = Cover::new([10.0; 2], -30.0, 0.0, 5, &looks);
    let height = w.get("height").unwrap();
    let (mut shore, mut middle) = ([0.0; 3], [0.0; 3]);
    for i in 0..80 * 80 {
        let (x, y) = (i % 80, i / 80);
        let s = cover.weights(&strip, x, y);
        let sand = s[Class::Sand as usize] + s[Class::WetSand as usize];
        let of = match height.get(x, y) {
            0.3..1.2 => &mut shore,
            2.4..4.0 => &mut middle,
            _ => continue,
        };
        let palms = s[Class::Forest as usize] + s[Class::Shrub as usize] + s[Class::Grass as usize];
        of.iter_mut().zip([sand, palms, 1.0]).for_each(|(o, v)| *o += v);
    }
    assert!(shore[0] > 0.75 * shore[2], "{shore:?}");
    assert!(middle[1] > 0.3 * middle[2], "{middle:?}");
}

/// What a strip of rows says of its middle is what the whole says.
#[test]
fn ground_is_the_same_in_a_window() {
    let w = mountains(48);
    let height = w.get("height").unwrap();
    let rows = |from: usize, to: usize| (from..to).flat_map(|y| height.row(y).to_vec()).collect::<Vec<f32>>();
    let cover = Cover::new([150.0; 2], 0.0, -1000.0, 5, &Looks::default());
    let mut layers: [Option<Vec<f32>>; LAYERS.len()] = Default::default();
    layers[0] = Some(rows(20 - HALO, 23 + HALO));
    let (part, whole) = (Strip::new(48, 20 - HALO, layers), Strip::whole(&w));
    for i in 0..3 * 48 {
        let (x, y) = (i % 48, 20 + i / 48);
        assert_eq!(cover.weights(&part, x, y), cover.weights(&whole, x, y));
        assert_eq!(cover.colour(&part, x, y), cover.colour(&whole, x, y));
    }
}

#[test]
fn maps_have_the_size_that_is_asked_for() {
    let w = world(30, 20, |x, y| (x * y) as f32);
    for (size, wide, high) in [(100, 100, 67), (15, 15, 10), (30, 30, 20)] {
        let o = MapOptions { size: Some(size), legend: false, ..MapOptions::default() };
        let map = layer_map(&w, "height", &o).unwrap();
        assert_eq!((map.width, map.height), (wide, high));
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
                assert_eq!(terrain_colours(&world, &Looks::default()).unwrap().len(), w * h);
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
            target: Some([x, x]),
            target_height: Some(x),
            vertical_exaggeration: x,
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
    assert!(matches!(terrain_colours(&empty, &Looks::default()), Err(Error::NoLayer { .. })));
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
        let colours = terrain_colours(w, &Looks::default()).unwrap();
        colours.iter().filter(|c| c[0] > 1.2 * c[1]).count()
    };
    let none = reds(&w);
    w.put(&known::ARIDITY, Field::from_fn(64, 64, |x, _| if x < 32 { 1.0 } else { 0.0 })).unwrap();
    let half = reds(&w) - none;
    assert!((1200..=2048).contains(&half), "{half} of 2048 cells turned red, {none} were");
    w.put(&known::ARIDITY, Field::from_fn(64, 64, |_, _| f32::NAN)).unwrap();
    assert_eq!(reds(&w), none);
}
