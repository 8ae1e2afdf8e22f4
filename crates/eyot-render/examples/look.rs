//! Draws synthetic worlds to PNG files: `cargo run --release -p eyot-render --example look -- FOLDER [SIZE]`.

use eyot_core::layer::known;
use eyot_core::{Field, Grid, Limits, Rim, World};
use eyot_render::{Picture, ViewOptions, perspective};
use std::path::Path;
use std::time::Instant;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome {
    let mut args = std::env::args().skip(1);
    let folder = args.next().unwrap_or_else(|| "look".to_owned());
    let size: usize = args.next().map_or(Ok(512), |s| s.parse())?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;

    let island = island(size)?;
    let mountains = mountains(size)?;
    for _ in 0..2 {
        time(folder, "island", || perspective(&island, &ViewOptions::default()))?;
    }
    time(folder, "island-near", || {
        perspective(
            &island,
            &ViewOptions { distance: 0.5, elevation_deg: 16.0, azimuth_deg: 150.0, ..ViewOptions::default() },
        )
    })?;
    time(folder, "island-high", || {
        perspective(
            &island,
            &ViewOptions { elevation_deg: 50.0, azimuth_deg: 250.0, sun_azimuth_deg: 140.0, ..ViewOptions::default() },
        )
    })?;
    time(folder, "island-evening", || {
        let o = ViewOptions {
            sun_elevation_deg: 9.0,
            sun_azimuth_deg: 335.0,
            elevation_deg: 12.0,
            haze: 2.0,
            ..ViewOptions::default()
        };
        perspective(&island, &o)
    })?;
    time(folder, "mountains", || {
        perspective(&mountains, &ViewOptions { elevation_deg: 32.0, ..ViewOptions::default() })
    })?;
    let mut coast = mountains.clone();
    coast.sea_level_m = 420.0;
    time(folder, "coast", || perspective(&coast, &ViewOptions { elevation_deg: 35.0, ..ViewOptions::default() }))?;
    Ok(())
}

fn time(folder: &Path, name: &str, draw: impl Fn() -> eyot_core::Result<Picture>) -> Outcome {
    let start = Instant::now();
    let picture = draw()?;
    println!("{name:16} {}x{} {:6.0} ms", picture.width, picture.height, start.elapsed().as_secs_f64() * 1e3);
    let file = std::io::BufWriter::new(std::fs::File::create(folder.join(format!("{name}.png")))?);
    let mut encoder = png::Encoder::new(file, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(picture.bytes())?;
    Ok(())
}

/// A volcanic island of 5 km with a barrier reef.
fn island(n: usize) -> Outcome<World> {
    let mut world = World::new(Grid::new(n, n, 5120.0 / n as f64, Rim::CLOSED, &Limits::default())?, 7);
    let mut limestone = Field::new(n, n, 0.0);
    let height = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32 - 0.5, (y as f32 + 0.5) / n as f32 - 0.5);
        let warp = fbm(u * 4.0 + 3.0, v * 4.0, 4);
        let q = (u * u + v * v).sqrt();
        let r = q * (1.0 + 0.55 * warp);
        let cone = (1.0 - r / 0.27).max(-0.25);
        let carved = eroded(u * 6.0 + 2.0 + 0.3 * warp, v * 6.0 + 1.0);
        let mut h = 1000.0 * cone * (0.55 + 0.85 * carved) + 60.0 * (carved - 0.4);
        // The summit has fallen in.
        let crater = 1.0 - ((u + 0.015).hypot(v - 0.01) / 0.055).powi(2);
        h -= 430.0 * crater.max(0.0).powf(0.7) * (0.8 + 0.5 * warp);
        if h < 0.0 {
            h *= 0.35;
        }
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
        let tide = -0.9 + 2.6 * fbm(u * 26.0, v * 26.0, 4) + 1.8 * fbm(u * 8.0 + 4.0, v * 8.0, 2);
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
    let mut world = World::new(Grid::new(n, n, 20_000.0 / n as f64, Rim::OPEN, &Limits::default())?, 11);
    let mut water = Field::new(n, n, 0.0);
    let height = Field::from_fn(n, n, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / n as f32, (y as f32 + 0.5) / n as f32);
        let course = 0.5 + 0.22 * (u * 5.0).sin() + 0.10 * fbm(u * 4.0, 0.3, 3);
        let off = (v - course).abs();
        let valley = (off / 0.22).min(1.0).powf(1.3);
        let mut h = 350.0
            + 150.0 * u
            + valley * (250.0 + 700.0 * ridged(u * 3.0, v * 3.0) + 2300.0 * eroded(u * 4.5, v * 4.5).powf(1.3));
        let wide =
            0.0055 + 0.03 * (1.0 - ((u - 0.59) / 0.08).powi(2)).max(0.0).sqrt() * (1.0 + 0.6 * fbm(u * 14.0, 2.0, 3));
        let depth = (1.0 - off / wide).max(0.0) * if wide > 0.02 { 30.0 } else { 6.0 };
        h -= depth;
        water.set(x, y, depth + 0.003);
        h
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
    let (mut sum, mut a, mut dx, mut dy) = (0.0, 0.5, 0.0, 0.0);
    for _ in 0..8 {
        const E: f32 = 0.01;
        let n = 1.0 - (1.2 * value(x, y)).abs();
        dx += (1.0 - (1.2 * value(x + E, y)).abs() - n) / E * 0.6;
        dy += (1.0 - (1.2 * value(x, y + E)).abs() - n) / E * 0.6;
        sum += a * n / (1.0 + 0.5 * (dx * dx + dy * dy));
        a *= 0.5;
        (x, y) = (1.6 * x - 1.2 * y + 11.0, 1.2 * x + 1.6 * y + 5.0);
    }
    sum * 1.25
}

/// Sharp crests and round valleys, 0..1.
fn ridged(mut x: f32, mut y: f32) -> f32 {
    let (mut sum, mut a, mut weight) = (0.0, 0.55, 1.0);
    for _ in 0..6 {
        let r = 1.0 - (1.3 * value(x, y)).abs().min(1.0);
        sum += a * r * r * weight;
        weight = r;
        a *= 0.5;
        (x, y) = (1.6 * x - 1.2 * y + 11.0, 1.2 * x + 1.6 * y + 5.0);
    }
    sum
}
