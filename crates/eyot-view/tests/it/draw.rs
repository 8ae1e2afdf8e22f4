//! Pictures of a GPU: close to those of the CPU, whole, moving, and the same twice.

use crate::common;

use common::gpu;
use eyot_core::layer::known;
use eyot_core::{Boundary, Control, Field, Grid, LayerSpec, Limits, World};
use eyot_gpu::{Gpu, GpuError};
use eyot_render::{Camera, MapOptions, Picture, Setting, ViewOptions};
use eyot_view::{Renderer, Scene};

fn world(w: usize, h: usize, cell: f64, f: impl FnMut(usize, usize) -> f32) -> World {
    let mut world = World::new(Grid::new(w, h, cell, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
    world.put(&known::HEIGHT, Field::from_fn(w, h, f)).unwrap();
    world
}

/// A volcano of 700 m with ridges and a lagoon around it.
fn island(n: usize) -> World {
    let cell = 5000.0 / n as f64;
    world(n, n, cell, |x, y| {
        let (u, v) = (x as f32 / n as f32 - 0.5, y as f32 / n as f32 - 0.48);
        let r = u.hypot(v);
        let ridges = (9.0 * v.atan2(u)).cos() * (23.0 * r).sin();
        let reef = 90.0 * (-((r - 0.40) / 0.02).powi(2)).exp();
        700.0 * (1.0 - r / 0.28).max(-0.15) + 60.0 * ridges * (0.4 - r).max(0.0) - 20.0 + reef
    })
}

/// Hills without a sea, and a river from north to south that flows.
fn valley(w: usize, h: usize) -> World {
    let mid = w as f32 / 2.0;
    let mut v = world(w, h, 20.0, |x, y| {
        200.0 + 3.0 * (x as f32 - mid).abs() + 12.0 * (0.3 * x as f32).sin() * (0.25 * y as f32).cos() - 0.2 * y as f32
    });
    let near = |x: usize| (x as f32 - mid).abs() < 2.0;
    v.put(&known::WATER, Field::from_fn(w, h, |x, _| if near(x) { 2.0 } else { 0.0 })).unwrap();
    let flux = |n: &'static str| LayerSpec::new(n, "m/s", "Flux", (-1e6, 1e6));
    v.put(&flux("flux_x"), Field::new(w, h, 0.0)).unwrap();
    v.put(&flux("flux_y"), Field::from_fn(w, h, |x, _| if near(x) { 0.5 } else { 0.0 })).unwrap();
    v
}

fn options(width: usize, height: usize) -> ViewOptions {
    ViewOptions { width, height, ..ViewOptions::default() }
}

/// A device with its renderer.
fn ready() -> Option<(Gpu, Renderer)> {
    let gpu = gpu()?;
    let renderer = Renderer::new(&gpu).unwrap();
    Some((gpu, renderer))
}

fn draw(gpu: &Gpu, r: &mut Renderer, world: &World, o: &ViewOptions, time_s: f32) -> Picture {
    let scene = Scene::from_world(gpu, r, world, o).unwrap();
    let picture = r
        .draw(gpu, &scene, &scene.stage().camera(o), [o.width as u32, o.height as u32], time_s)
        .unwrap()
        .take(gpu)
        .unwrap();
    keep(&picture);
    picture
}

/// Leaves pictures in the folder that `EYOT_PICTURES` names, for the eye.
pub(crate) fn keep(p: &Picture) {
    static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
    let Some(folder) = std::env::var_os("EYOT_PICTURES") else { return };
    let i = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let test = std::thread::current().name().unwrap_or("picture").to_owned();
    let file = std::fs::File::create(std::path::Path::new(&folder).join(format!("{test}-{i:02}.png"))).unwrap();
    let mut encoder = png::Encoder::new(file, p.width as u32, p.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(p.bytes()).unwrap();
}

/// Mean of the absolute differences of all bytes, of 255.
pub(crate) fn difference(a: &Picture, b: &Picture) -> f64 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let sum: f64 = a.bytes().iter().zip(b.bytes()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / a.bytes().len() as f64
}

/// Structural similarity of the green channels (Wang et al. 2004), over squares of 8 pixels.
fn similarity(a: &Picture, b: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for y in (0..a.height / 8 * 8).step_by(8) {
        for x in (0..a.width / 8 * 8).step_by(8) {
            let square =
                |p: &Picture| -> Vec<f64> { (0..64).map(|i| f64::from(p.get(x + i % 8, y + i / 8)[1])).collect() };
            let (p, q) = (square(a), square(b));
            let mean = |v: &[f64]| v.iter().sum::<f64>() / 64.0;
            let (mp, mq) = (mean(&p), mean(&q));
            let product = |s: &[f64], t: &[f64], ms: f64, mt: f64| {
                s.iter().zip(t).map(|(a, b)| (a - ms) * (b - mt)).sum::<f64>() / 63.0
            };
            let (vp, vq, vpq) = (product(&p, &p, mp, mp), product(&q, &q, mq, mq), product(&p, &q, mp, mq));
            let (c1, c2) = (6.5025, 58.5225);
            sum += (2.0 * mp * mq + c1) * (2.0 * vpq + c2) / ((mp * mp + mq * mq + c1) * (vp + vq + c2));
            count += 1.0;
        }
    }
    sum / count
}

/// Mean of how much a pixel's green stands out from its neighbours above and below, of 255: grain of what is seen at a grazing angle.
fn roughness(p: &Picture) -> f64 {
    let at = |x: usize, y: usize| f64::from(p.get(x, y)[1]);
    let stands_out = |x: usize, y: usize| (at(x, y) - 0.5 * (at(x, y - 1) + at(x, y + 1))).abs();
    let sum: f64 = (1..p.height - 1).map(|y| (0..p.width).map(|x| stands_out(x, y)).sum::<f64>()).sum();
    sum / ((p.height - 2) * p.width) as f64
}

/// A view from low over the land.
fn low(distance: f32, elevation_deg: f32, azimuth_deg: f32, o: &ViewOptions) -> ViewOptions {
    ViewOptions { distance: Some(distance), elevation_deg: Some(elevation_deg), azimuth_deg, ..o.clone() }
}

/// The island without its sea, and a lake in a hollow of it.
fn lake(n: usize) -> World {
    let mut w = island(n);
    w.sea_level_m = -1e4;
    let h = w.get("height").unwrap();
    let fill = Field::from_fn(n, n, |x, y| (40.0 - h.get(x, y)).max(0.0));
    w.put(&known::WATER, fill).unwrap();
    w
}

#[test]
fn gpu_and_cpu_show_the_same() {
    let Some((gpu, mut r)) = ready() else { return };
    let o = options(320, 180);
    let block = ViewOptions { setting: Setting::Block, ..o.clone() };
    let above = ViewOptions { elevation_deg: Some(60.0), azimuth_deg: 90.0, sun_elevation_deg: 15.0, ..o.clone() };
    let cases = [
        ("open sea", island(128), o.clone()),
        ("block with sea", island(128), block),
        ("low sun from above", island(96), above),
        ("valley", valley(120, 90), o.clone()),
        ("along the ground", island(256), ViewOptions { field_of_view_deg: 90.0, ..low(0.12, 8.0, 200.0, &o) }),
        ("lake against the sun", lake(128), ViewOptions { sun_elevation_deg: 12.0, ..low(0.3, 5.0, 120.0, &o) }),
    ];
    for (name, world, o) in cases {
        let picture = draw(&gpu, &mut r, &world, &o, 0.0);
        let reference = eyot_render::perspective(&world, &o).unwrap();
        keep(&reference);
        let (off, alike) = (difference(&picture, &reference), similarity(&picture, &reference));
        let grain = roughness(&picture) / roughness(&reference);
        println!("{name}: mean difference {off:.2} of 255, similarity {alike:.4}, {grain:.3} times the grain");
        assert!(off < 2.5 && alike > 0.9, "{name}: mean difference {off:.2}, similarity {alike:.4}");
        // The processor takes sixteen samples where neighbours differ; what these do not show would shimmer in films.
        assert!(grain < 1.15, "{name}: {grain:.3} times the grain of the reference");
    }
}

#[test]
fn nothing_shows_through_the_ground() {
    let Some((gpu, mut r)) = ready() else { return };
    // Rough land, seen from close by so that levels of all kinds meet, and from above so that no sky is in the picture.
    let rough = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 97) as f32 * 3.0;
    let o = ViewOptions { vertical_exaggeration: 1.0, ..options(160, 120) };
    for (w, h) in [(700, 500), (1500, 1100)] {
        let world = world(w, h, 10.0, rough);
        let scene = Scene::from_world(&gpu, &r, &world, &o).unwrap();
        let e = scene.stage().size_m();
        for (u, v, height, down) in [(0.5, 0.5, 350.0, 0.6), (0.3, 0.4, 900.0, 1.2), (0.5, 0.5, 2600.0, 3.0)] {
            let eye = [u * e[0], v * e[1], height];
            let camera = Camera::looking(eye, [eye[0] + 700.0, eye[1] + 300.0, height - 761.0 * down], 40.0);
            let far = r.distances(&gpu, &scene, &camera, [160, 120]).unwrap().take(&gpu).unwrap();
            let over = |i: usize| {
                let d = camera.ray((i % 160) as f32 + 0.5, (i / 160) as f32 + 0.5, [160, 120]);
                let level = (eye[2] - 150.0) / -d[2];
                let at = [0, 1].map(|k| eye[k] + d[k] * level);
                d[2] < -0.15 && (0..2).all(|k| at[k] > 0.05 * e[k] && at[k] < 0.95 * e[k])
            };
            let seen: Vec<usize> = (0..far.len()).filter(|i| over(*i)).collect();
            assert!(seen.len() > 8000, "only {} pixels look at the ground", seen.len());
            let holes = seen.iter().filter(|i| !far[**i].is_finite()).count();
            assert_eq!(holes, 0, "{holes} of {} pixels at {eye:?} over {w}x{h} cells", seen.len());
        }
    }
}

#[test]
fn distances_are_those_of_the_surface() {
    let Some((gpu, mut r)) = ready() else { return };
    let flat = world(300, 200, 10.0, |_, _| 40.0);
    let o = ViewOptions { vertical_exaggeration: 1.0, ..options(64, 48) };
    let scene = Scene::from_world(&gpu, &r, &flat, &o).unwrap();
    let camera = Camera::looking([1500.0, 1000.0, 640.0], [1500.1, 1000.0, 0.0], 50.0);
    let far = r.distances(&gpu, &scene, &camera, [64, 48]).unwrap().take(&gpu).unwrap();
    // All of a level plane is equally far along a view straight down.
    for d in far {
        assert!((d - 600.0).abs() < 0.6, "{d}");
    }
}

#[test]
fn waves_and_rivers_move_and_land_does_not() {
    let Some((gpu, mut r)) = ready() else { return };
    let o = options(200, 120);
    let (sea, river) = (island(96), valley(64, 64));
    let close = ViewOptions { distance: Some(0.25), elevation_deg: Some(50.0), target_height: Some(0.0), ..o.clone() };
    for (world, o) in [(sea, o.clone()), (river, close)] {
        let scene = Scene::from_world(&gpu, &r, &world, &o).unwrap();
        let camera = scene.stage().camera(&o);
        let mut at = |t: f32| r.draw(&gpu, &scene, &camera, [200, 120], t).unwrap().take(&gpu).unwrap();
        let (a, again, b) = (at(0.0), at(0.0), at(0.7));
        keep(&a);
        keep(&b);
        assert!(a == again, "the same moment gives the same picture");
        let moved = a.pixels.iter().zip(&b.pixels).filter(|(p, q)| p != q).count();
        println!("{moved} of {} pixels moved", a.pixels.len());
        assert!(moved > a.pixels.len() / 100, "only {moved} pixels moved");
        assert!(moved < a.pixels.len() * 9 / 10, "{moved} pixels moved, the land among them");
    }
    let mut dry = valley(64, 64);
    dry.remove("water");
    let (a, b) = (draw(&gpu, &mut r, &dry, &o, 0.0), draw(&gpu, &mut r, &dry, &o, 5.0));
    assert!(a == b, "dry land does not move");
}

#[test]
fn an_update_is_as_good_as_a_new_scene() {
    let Some((gpu, mut r)) = ready() else { return };
    let o = ViewOptions { sea_clarity_m: Some(20.0), vertical_exaggeration: 1.0, ..options(160, 90) };
    let before = island(80);
    let mut after = before.clone();
    let field = after.get("height").unwrap();
    let raised = Field::from_fn(80, 80, |x, y| field.get(x, y) + if x > 50 && x < 60 && y > 40 { 150.0 } else { 0.0 });
    after.put(&known::HEIGHT, raised).unwrap();
    let mut scene = Scene::from_world(&gpu, &r, &before, &o).unwrap();
    let camera = scene.stage().camera(&o);
    let old = r.draw(&gpu, &scene, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap();
    scene.update(&gpu, &r, &after, &["height"]).unwrap();
    let updated = r.draw(&gpu, &scene, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap();
    let fresh = Scene::from_world(&gpu, &r, &after, &o).unwrap();
    let fresh = r.draw(&gpu, &fresh, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap();
    assert!(difference(&old, &updated) > 1.0, "the update shows");
    let off = difference(&updated, &fresh);
    assert!(off < 0.5, "mean difference {off}");
    // Another layer alone leaves the heights where they are.
    let mut wet = after.clone();
    wet.put(&known::WETNESS, Field::new(80, 80, 1.0)).unwrap();
    scene.update(&gpu, &r, &wet, &["wetness"]).unwrap();
    let wet = r.draw(&gpu, &scene, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap();
    assert!(difference(&wet, &updated) > 0.5);
    // A world of another size is not the same world.
    let e = scene.update(&gpu, &r, &island(81), &["height"]).unwrap_err();
    assert!(e.to_string().contains("80"), "{e}");
}

#[test]
fn the_ground_wears_the_colours_of_a_layer_and_the_picture_its_legend() {
    let Some((gpu, mut r)) = ready() else { return };
    let mut w = island(64);
    w.put(&known::ARIDITY, Field::from_fn(64, 64, |x, _| x as f32 / 63.0)).unwrap();
    let o = ViewOptions { elevation_deg: Some(89.0), sun_elevation_deg: 89.0, ..options(240, 240) };
    let scene = Scene::of_layer(&gpu, &r, &w, "aridity", &o, &MapOptions::default()).unwrap();
    let picture = r.draw(&gpu, &scene, &scene.stage().camera(&o), [240, 240], 0.0).unwrap().take(&gpu).unwrap();
    let whole = scene.with_legend(picture.clone());
    keep(&whole);
    assert!(whole.height > picture.height);
    // Viridis: dark blue in the west, yellow in the east.
    let (west, east) = (picture.get(60, 120), picture.get(180, 120));
    assert!(west[2] > west[0] && east[0] > east[2] && east[1] > 120, "{west:?} {east:?}");
    assert!(Scene::of_layer(&gpu, &r, &w, "snow", &o, &MapOptions::default()).is_err());
}

#[test]
fn odd_worlds_and_odd_pictures() {
    let Some((gpu, mut r)) = ready() else { return };
    for (w, h) in [(1, 1), (2, 3), (1, 40), (27, 51), (300, 2)] {
        for low in [-20.0, 5.0] {
            let world = world(w, h, 3.0, |x, y| low + 7.0 * ((x + 2 * y) % 5) as f32);
            for (pw, ph) in [(1, 1), (33, 7)] {
                let p = draw(&gpu, &mut r, &world, &options(pw, ph), 0.0);
                assert_eq!((p.width, p.height), (pw, ph));
            }
        }
    }
    // Heights that are none are drawn as the lowest.
    let holes = world(20, 20, 5.0, |x, y| if (x + y) % 7 == 0 { f32::NAN } else { x as f32 });
    draw(&gpu, &mut r, &holes, &options(40, 30), 0.0);
}

#[test]
fn pictures_beyond_the_limits_are_refused() {
    let Some((gpu, mut r)) = ready() else { return };
    let o = options(64, 64);
    let scene = Scene::from_world(&gpu, &r, &island(16), &o).unwrap();
    let camera = scene.stage().camera(&o);
    for size in [[1_000_000, 64], [64, 1_000_000], [0, 5]] {
        let Err(e) = r.draw(&gpu, &scene, &camera, size, 0.0) else { panic!("drawn") };
        assert!(matches!(e, GpuError::Picture { .. }) && e.to_string().contains("`size`"), "{e}");
    }
    // Eight samples of four bytes a pixel, far more than a software renderer lends; a large card may have as much.
    let most = gpu.report.max_picture;
    match r.reserve(&gpu, [most, most]) {
        Err(e) => assert!(matches!(e, GpuError::OutOfMemory { .. }) && e.to_string().contains("picture"), "{e}"),
        Ok(()) => assert!(gpu.report.is_hardware()),
    }
    // And the renderer still works.
    r.draw(&gpu, &scene, &camera, [64, 64], 0.0).unwrap().take(&gpu).unwrap();
}

#[test]
fn a_large_world_is_drawn() {
    let Some((gpu, mut r)) = ready() else { return };
    let n = 4096;
    let big = world(n, n, 10.0, |x, y| {
        let (u, v) = (x as f32 / n as f32 - 0.5, y as f32 / n as f32 - 0.5);
        3000.0 * (0.2 - u.hypot(v)) + 25.0 * (0.05 * x as f32).sin() * (0.07 * y as f32).cos()
    });
    let o = options(160, 90);
    let scene = Scene::from_world(&gpu, &r, &big, &o).unwrap();
    let camera = scene.stage().camera(&o);
    let far = r.distances(&gpu, &scene, &camera, [160, 90]).unwrap().take(&gpu).unwrap();
    assert!(far.iter().any(|d| d.is_finite()) && far.iter().any(|d| !d.is_finite()));
    let p = r.draw(&gpu, &scene, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap();
    keep(&p);
    let green = p.pixels.iter().filter(|c| c[1] > c[2]).count();
    assert!(green > p.pixels.len() / 50, "{green} pixels show land");
}

#[test]
fn a_scene_can_be_stopped_being_drawn_by_the_cpu_and_go_on_with_the_gpu() {
    // The two share their stage: one camera serves both.
    let Some((gpu, mut r)) = ready() else { return };
    let (w, o) = (island(48), options(96, 54));
    let cpu = eyot_render::Scene::new(&w, &o, &Control::none()).unwrap();
    let camera = cpu.stage.camera(&o);
    let scene = Scene::from_world(&gpu, &r, &w, &o).unwrap();
    assert_eq!(camera, scene.stage().camera(&o));
    let a = cpu.picture(&camera, [96, 54], &Control::none()).unwrap();
    let b = r.draw(&gpu, &scene, &camera, [96, 54], 0.0).unwrap().take(&gpu).unwrap();
    assert!(difference(&a, &b) < 3.0);
}
