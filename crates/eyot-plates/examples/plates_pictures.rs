//! Draws worlds of plates as an atlas would: `cargo run --release -p eyot-plates --example plates_pictures -- OUT [SEED] [STEPS] [SIDE] [KEY=VALUE...]`
use eyot_core::{Boundary, BoundaryCondition, Grid, Limits};
use eyot_plates::{Plates, Start, Tectonics, hypsometry};
use std::fs::File;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (pairs, plain): (Vec<&String>, Vec<&String>) = arguments.iter().partition(|a| a.contains('='));
    let number = |i: usize, usual: u64| plain.get(i).map_or(Ok(usual), |t| t.parse::<u64>());
    let out = Path::new(plain.first().map_or("target", |s| s.as_str()));
    let (seed, steps, height) = (number(1, 1)?, number(2, 200)?, number(3, 256)? as usize);
    let width = 2 * height;
    let mut table = serde_json::to_value(Tectonics::default())?;
    for pair in pairs {
        let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
        table[key] = serde_json::from_str(value)?;
    }
    let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };
    let grid = Grid::new(width, height, 4e7 / width as f64, rim, &Limits::default())?;
    let mut plates = Plates::new(&grid, seed, serde_json::from_value(table)?, Start::Noise)?;
    std::fs::create_dir_all(out)?;
    for step in 0..=steps {
        if step % 50 == 0 || step == steps {
            let h = hypsometry(plates.height().iter().copied());
            let range = plates.height().iter().fold((0f32, 0f32), |r, &h| (r.0.min(h), r.1.max(h)));
            println!(
                "step {step}: {} plates, {:.1} mm/yr, land {:.3}, continental {:.3}, peaks {:?}, heights {range:?}, cycle {:?}, {:?}",
                plates.list().len(),
                1e3 * plates.mean_speed(),
                h.land,
                plates.list().iter().map(|p| p.continental * p.area_m2).sum::<f64>()
                    / (grid.cells() as f64 * grid.cell_area_m2()),
                h.peaks_m,
                plates.cycle_and_steps(),
                plates.budget(),
            );
            assert_eq!(plates.crust_units(), plates.budget().net());
            picture(&out.join(format!("{seed}-{step:04}.png")), &plates, width, height)?;
        }
        plates.step();
    }
    Ok(())
}

/// Shaded relief above the map of plates.
fn picture(path: &Path, plates: &Plates, w: usize, h: usize) -> Result<(), Box<dyn std::error::Error>> {
    let height = plates.height();
    let at = |x: isize, y: isize| height[y.clamp(0, h as isize - 1) as usize * w + x.rem_euclid(w as isize) as usize];
    let mut bytes = vec![0u8; 3 * w * 2 * h];
    for y in 0..h {
        for x in 0..w {
            let (i, j) = (x as isize, y as isize);
            let slope = at(i - 1, j - 1) - at(i + 1, j + 1);
            let light = 1.0 + (slope / 4000.0).clamp(-0.35, 0.35);
            let c = tint(at(i, j)).map(|c| (c * light).clamp(0.0, 255.0) as u8);
            bytes[3 * (y * w + x)..][..3].copy_from_slice(&c);
            let o = u32::from(plates.owner()[y * w + x]);
            let age = (plates.age_myr()[y * w + x] / 150.0).min(1.0);
            let c = [37u32, 91, 151].map(|k| (80.0 + 0.35 * ((o * k + 60) % 256) as f32 + 80.0 * (1.0 - age)) as u8);
            bytes[3 * ((y + h) * w + x)..][..3].copy_from_slice(&c);
        }
    }
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(File::create(path)?), w as u32, 2 * h as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&bytes)?;
    Ok(())
}

fn tint(h: f32) -> [f32; 3] {
    const STOPS: [(f32, [f32; 3]); 11] = [
        (-7000.0, [24.0, 44.0, 92.0]),
        (-5500.0, [38.0, 74.0, 130.0]),
        (-4000.0, [66.0, 110.0, 165.0]),
        (-2500.0, [104.0, 150.0, 196.0]),
        (-200.0, [168.0, 205.0, 226.0]),
        (0.0, [200.0, 226.0, 236.0]),
        (0.1, [120.0, 160.0, 100.0]),
        (800.0, [198.0, 196.0, 140.0]),
        (2000.0, [186.0, 150.0, 104.0]),
        (3800.0, [140.0, 104.0, 84.0]),
        (5500.0, [248.0, 246.0, 244.0]),
    ];
    let i = STOPS.iter().rposition(|s| s.0 <= h).unwrap_or(0).min(STOPS.len() - 2);
    let (a, b) = (STOPS[i], STOPS[i + 1]);
    let t = ((h - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
    [0, 1, 2].map(|k| a.1[k] + t * (b.1[k] - a.1[k]))
}
