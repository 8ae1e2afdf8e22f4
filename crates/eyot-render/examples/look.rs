//! Draws synthetic worlds to PNG files: `cargo run --release -p eyot-render --example look -- FOLDER [SIZE [NAME]]`.

use eyot_core::layer::known;
use eyot_core::{Boundary, Field, Grid, Limits, World};
use eyot_render::{MapOptions, Picture, ReliefOptions, ViewOptions, layer_map, perspective, relief};
use std::time::Instant;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome {
    let mut args = std::env::args().skip(1);
    let folder = args.next().unwrap_or_else(|| "look".to_owned());
    let size: usize = args.next().map_or(Ok(512), |s| s.parse())?;
    let only = args.next().unwrap_or_default();
    let folder = &Folder { path: folder.into(), only };
    std::fs::create_dir_all(&folder.path)?;

    let island = island(size)?;
    let mountains = mountains(size)?;
    for _ in 0..2 {
        time(folder, "island", || perspective(&island, &ViewOptions::default()))?;
    }
    time(folder, "island-near", || {
        perspective(
            &island,
            &ViewOptions {
                distance: Some(0.5),
                elevation_deg: Some(17.0),
                azimuth_deg: 150.0,
                ..ViewOptions::default()
            },
        )
    })?;
    time(folder, "island-high", || {
        perspective(
            &island,
            &ViewOptions {
                elevation_deg: Some(50.0),
                distance: Some(1.2),
                azimuth_deg: 250.0,
                sun_azimuth_deg: 140.0,
                ..ViewOptions::default()
            },
        )
    })?;
    time(folder, "island-evening", || {
        let o = ViewOptions {
            sun_elevation_deg: 11.0,
            sun_azimuth_deg: 268.0,
            elevation_deg: Some(10.0),
            haze: 1.6,
            ..ViewOptions::default()
        };
        perspective(&island, &o)
    })?;
    time(folder, "mountains", || perspective(&mountains, &ViewOptions::default()))?;
    let mut coast = mountains.clone();
    coast.sea_level_m = 320.0;
    time(folder, "coast", || perspective(&coast, &ViewOptions { azimuth_deg: 150.0, ..ViewOptions::default() }))?;
    for (name, world) in [("island", &island), ("mountains", &mountains), ("coast", &coast)] {
        time(folder, &format!("{name}-relief"), || relief(world, &ReliefOptions::default()))?;
        time(folder, &format!("{name}-height"), || layer_map(world, "height", &MapOptions::default()))?;
    }
    time(folder, "island-limestone", || layer_map(&island, "limestone", &MapOptions::default()))?;
    time(folder, "mountains-water", || layer_map(&mountains, "water", &MapOptions::default()))?;
    Ok(())
}

/// Where pictures go, and with what their names must begin.
struct Folder {
    path: std::path::PathBuf,
    only: String,
}

fn time(folder: &Folder, name: &str, draw: impl Fn() -> eyot_core::Result<Picture>) -> Outcome {
    if !name.starts_with(&folder.only) {
        return Ok(());
    }
    let start = Instant::now();
    let picture = draw()?;
    println!("{name:16} {}x{} {:6.0} ms", picture.width, picture.height, start.elapsed().as_secs_f64() * 1e3);
    let file = std::io::BufWriter::new(std::fs::File::create(folder.path.join(format!("{name}.png")))?);
    let mut encoder = png::Encoder::new(file, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(picture.bytes())?;
    Ok(())
}

/// A volcanic island of 5 km with a barrier reef.
fn island(n: usize) -> Outcome<World> {
    let mut world = World::new(Grid::new(n, n, 5120.0 / n as f64, Boundary::CLOSED, &Limits::default())?, 7);
    let mut limestone = Field::new(n, n, 0.0);
    let land = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32 - 0.5, (y as f32 + 0.5) / n as f32 - 0.5);
        let warp = fbm(u * 4.0 + 3.0, v * 4.0, 4);
        let q = (u * u + v * v).sqrt();
        let r = q * (1.0 + 0.55 * warp);
        let cone = (1.0 - r / 0.27).max(-0.25);
        let carved = eroded(u * 6.0 + 2.0 + 0.3 * warp, v * 6.0 + 1.0);
        let mut h = 1150.0 * cone * (0.55 + 0.85 * carved) + 60.0 * (carved - 0.4);
        // The summit has fallen in.
        let crater = 1.0 - ((u + 0.015).hypot(v - 0.01) / 0.055).powi(2);
        h -= 430.0 * crater.max(0.0).powf(0.7) * (0.8 + 0.5 * warp);
        if h < 0.0 { 0.35 * h } else { h }
    });
    let mut land = land.to_vec();
    carve(&mut land, n, 5120.0 / n as f32, 40, 0.022);
    let height = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32 - 0.5, (y as f32 + 0.5) / n as f32 - 0.5);
        let q = (u * u + v * v).sqrt();
        let mut h = land[y * n + x];
        // A lagoon behind a reef that rises to the tide, with passes; beyond it the drop.
        let ring = 0.345 + 0.05 * fbm(u * 3.0 + 9.0, v * 3.0, 3) + 0.008 * fbm(u * 22.0, v * 22.0, 3);
        let floor = -16.0 - 12.0 * fbm(u * 12.0, v * 12.0, 4);
        let out = ((q - ring - 0.02) / 0.12).max(0.0);
        h = h.max(floor).min(h.max(floor) - 900.0 * out.powf(1.15));
        let open = (fbm(u * 5.0 + 1.5, v * 5.0 + 7.0, 2) * 4.0 + 1.5).clamp(0.0, 1.0);
        let inner = ((q - ring + 0.045) / 0.045).clamp(0.0, 1.0);
        let outer = (1.0 - (q - ring) / 0.028).clamp(0.0, 1.0);
        let crest = (inner * inner * outer * open).min(0.5) * 2.0;
        let heads =
            ((fbm(u * 30.0 + 5.0, v * 30.0, 4) - 0.16) * 5.0).clamp(0.0, 1.0) * if q < ring { 0.8 } else { 0.0 };
        let tide = -0.9 + 2.6 * fbm(u * 26.0, v * 26.0, 4) + 5.0 * fbm(u * 8.0 + 4.0, v * 8.0, 3);
        if h < tide {
            let top = h + (tide - h) * crest.max(heads);
            limestone.set(x, y, top - h);
            h = top;
        }
        h
    });
    world.put(&known::HEIGHT, height)?;
    world.put(&known::LIMESTONE, limestone)?;
    Ok(world)
}

/// Inland mountains of 20 km with a river and a lake.
fn mountains(n: usize) -> Outcome<World> {
    let mut world = World::new(Grid::new(n, n, 20_000.0 / n as f64, Boundary::OPEN, &Limits::default())?, 11);
    let mut water = Field::new(n, n, 0.0);
    let land = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32, (y as f32 + 0.5) / n as f32);
        let course = 0.5 + 0.22 * (u * 5.0).sin() + 0.10 * fbm(u * 4.0, 0.3, 3);
        let valley = ((v - course).abs() / 0.30).min(1.0).powf(1.2);
        200.0 + 150.0 * u + valley * (500.0 + 2600.0 * eroded(u * 3.5, v * 3.5) + 900.0 * fbm(u * 3.0, v * 3.0, 4))
    });
    let mut land = land.to_vec();
    carve(&mut land, n, 20_000.0 / n as f32, 40, 0.022);
    let height = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32, (y as f32 + 0.5) / n as f32);
        let course = 0.5 + 0.22 * (u * 5.0).sin() + 0.10 * fbm(u * 4.0, 0.3, 3);
        let wide =
            0.0055 + 0.03 * (1.0 - ((u - 0.59) / 0.08).powi(2)).max(0.0).sqrt() * (1.0 + 0.6 * fbm(u * 14.0, 2.0, 3));
        let off = (v - course).abs();
        let level = 150.0 + 150.0 * u;
        let flat = ((off - wide) / 0.02).clamp(0.0, 1.0);
        let depth = (1.0 - off / wide).max(0.0) * if wide > 0.012 { 30.0 } else { 6.0 };
        water.set(x, y, depth + 0.003);
        level - depth + (land[y * n + x] - level).max(0.0) * flat * flat
    });
    world.put(&known::HEIGHT, height)?;
    world.put(&known::WATER, water)?;
    world.sea_level_m = -50.0;
    Ok(world)
}

fn hash(x: i32, y: i32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 15)).wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 13)).wrapping_mul(0x27d4_eb2f);
    (h ^ (h >> 16)) as f32 / u32::MAX as f32 * 2.0 - 1.0
}

fn value(x: f32, y: f32) -> f32 {
    let (fx, fy) = (x.floor(), y.floor());
    let s = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (s(x - fx), s(y - fy));
    let at = |dx: i32, dy: i32| hash(fx as i32 + dx, fy as i32 + dy);
    let (a, b) = (at(0, 0) + (at(1, 0) - at(0, 0)) * u, at(0, 1) + (at(1, 1) - at(0, 1)) * u);
    a + (b - a) * v
}

fn fbm(mut x: f32, mut y: f32, octaves: usize) -> f32 {
    let (mut sum, mut a) = (0.0, 0.5);
    for _ in 0..octaves {
        sum += a * value(x, y);
        a *= 0.5;
        (x, y) = (1.6 * x - 1.2 * y + 11.0, 1.2 * x + 1.6 * y + 5.0);
    }
    sum
}

/// Noise whose small hills fade where the large ones are steep, as on eroded land; about 0..1.
fn eroded(mut x: f32, mut y: f32) -> f32 {
    let round = |v: f32| 1.0 - 1.2 * (v * v + 0.003).sqrt();
    let (mut sum, mut a, mut dx, mut dy) = (0.0, 0.5, 0.0, 0.0);
    for _ in 0..8 {
        const E: f32 = 0.01;
        let n = round(value(x, y));
        dx += (round(value(x + E, y)) - n) / E * 0.6;
        dy += (round(value(x, y + E)) - n) / E * 0.6;
        sum += a * n / (1.0 + 0.5 * (dx * dx + dy * dy));
        a *= 0.5;
        (x, y) = (1.6 * x - 1.2 * y + 11.0, 1.2 * x + 1.6 * y + 5.0);
    }
    sum * 1.25
}

/// Rivers cut valleys: implicit stream power along steepest descent, with creep on the slopes.
fn carve(h: &mut [f32], n: usize, cell: f32, passes: usize, strength: f32) {
    let mut order: Vec<u32> = (0..h.len() as u32).collect();
    let mut to = vec![0u32; h.len()];
    for _ in 0..passes {
        order.sort_unstable_by(|&a, &b| h[a as usize].total_cmp(&h[b as usize]).then(a.cmp(&b)));
        let mut area = vec![1.0f32; h.len()];
        for &i in order.iter().rev() {
            let (x, y) = ((i as usize % n) as isize, (i as usize / n) as isize);
            let (mut best, mut slope) = (i as usize, 0.0);
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)] {
                let (px, py) = (x + dx, y + dy);
                if px < 0 || py < 0 || px >= n as isize || py >= n as isize {
                    continue;
                }
                let j = py as usize * n + px as usize;
                let s = (h[i as usize] - h[j]) / ((dx * dx + dy * dy) as f32).sqrt();
                if s > slope {
                    (best, slope) = (j, s);
                }
            }
            if best == i as usize && h[best] > 0.0 && x > 0 && y > 0 && x < n as isize - 1 && y < n as isize - 1 {
                // A pit fills until it spills.
                let around = [h[best - 1], h[best + 1], h[best - n], h[best + n]];
                h[best] = around.into_iter().fold(f32::INFINITY, f32::min) + 0.01;
            }
            to[i as usize] = best as u32;
            if best != i as usize {
                area[best] += area[i as usize];
            }
        }
        for &i in &order {
            let (i, j) = (i as usize, to[i as usize] as usize);
            if h[i] > 0.0 && i != j {
                let f = strength * area[i].sqrt();
                h[i] = (h[i] + f * h[j].max(-1.0)) / (1.0 + f);
            }
        }
        let before = h.to_vec();
        for y in 1..n - 1 {
            for x in 1..n - 1 {
                let i = y * n + x;
                if before[i] > 0.0 {
                    let around = [before[i - 1], before[i + 1], before[i - n], before[i + n]];
                    let creep: f32 = around
                        .iter()
                        .map(|&b| (b - before[i]) * if (b - before[i]).abs() > 0.9 * cell { 0.10 } else { 0.04 })
                        .sum();
                    h[i] += creep;
                }
            }
        }
    }
}
