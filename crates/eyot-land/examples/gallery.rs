//! Pictures of what the generators make, to look at: `cargo run --release -p eyot-land --example gallery -- FOLDER`.
use eyot_core::process::{Generator, Site};
use eyot_core::{Control, Field, Grid, Limits, Rim, World};
use eyot_land::generate::noise::Basis;
use eyot_land::generate::{Cone, Crater, Fbm, Ramp, Ridged, Smooth, Warp};
use std::error::Error;
use std::path::Path;

const SIDE: usize = 512;

fn make(what: &dyn Generator, base: &Field, rim: Rim, seed: u64) -> Result<Field, eyot_core::Error> {
    let grid = Grid::new(base.width(), base.height(), 10.0, rim, &Limits::default())?;
    what.generate(&Site::whole(grid, seed, &World::new(grid, seed), &Control::none()), base)
}

fn save(folder: &Path, name: &str, width: usize, pixels: &[u8]) -> Result<(), Box<dyn Error>> {
    let file = std::io::BufWriter::new(std::fs::File::create(folder.join(format!("{name}.png")))?);
    let mut encoder = png::Encoder::new(file, width as u32, (pixels.len() / width) as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}

/// Light from the north-west, a little grey for height; `times` copies side by side show the seams.
fn shade(f: &Field, times: usize) -> (usize, Vec<u8>) {
    let (w, h) = (f.width(), f.height());
    let (low, high) = f.min_max();
    let at = |x: usize, y: usize| f.get(x % w, y % h);
    let mut pixels = Vec::new();
    for y in 0..h * times {
        for x in 0..w * times {
            let (x1, y1) = if times > 1 { (x + 1, y + 1) } else { ((x + 1).min(w - 1), (y + 1).min(h - 1)) };
            let (dx, dy) = (at(x1, y) - at(x, y), at(x, y1) - at(x, y));
            let (dx, dy) = (dx * 0.05, dy * 0.05);
            let light = (0.7 + 0.5 * (dx + dy)) / (1.0 + dx * dx + dy * dy).sqrt();
            let tone = (at(x, y) - low) / (high - low).max(1e-9);
            pixels.push((30.0 + light.clamp(0.0, 1.0) * (160.0 + 60.0 * tone)).min(255.0) as u8);
        }
    }
    (w * times, pixels)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "out/gallery".to_owned());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let flat = Field::new(SIDE, SIDE, 0.0);
    let picture = |name: &str, f: &Field, times: usize| {
        let (width, pixels) = shade(f, times);
        let (low, high) = f.min_max();
        println!("{name:16} {low:8.1} to {high:8.1} m");
        save(folder, name, width, &pixels)
    };
    for (basis, name) in [(Basis::Simplex, "simplex"), (Basis::Perlin, "perlin")] {
        let fbm = Fbm { basis, amplitude: 1500.0, ..Fbm::default() };
        picture(&format!("{name}_fbm"), &make(&fbm, &flat, Rim::CLOSED, 1)?, 1)?;
        let one = Fbm { octaves: 1, scale: 0.06, amplitude: 200.0, ..fbm.clone() };
        picture(&format!("{name}_one"), &make(&one, &flat, Rim::CLOSED, 1)?, 1)?;
        picture(&format!("{name}_warped"), &make(&Fbm { warp: 1.0, ..fbm.clone() }, &flat, Rim::CLOSED, 1)?, 1)?;
        picture(&format!("{name}_wrap"), &make(&fbm, &flat, Rim::WRAP, 1)?, 2)?;
        let ridged = Ridged { basis, ..Ridged::default() };
        picture(&format!("{name}_ridged"), &make(&ridged, &flat, Rim::CLOSED, 1)?, 1)?;
        picture(&format!("{name}_ridged_wrap"), &make(&ridged, &flat, Rim::WRAP, 1)?, 2)?;
    }
    let noise = make(&Fbm { amplitude: 1.0, ..Fbm::default() }, &flat, Rim::CLOSED, 3)?;
    let mut island = make(&Cone { height: 1.0, ..Cone::default() }, &flat, Rim::CLOSED, 0)?;
    for y in 0..SIDE {
        for x in 0..SIDE {
            island.set(x, y, 900.0 * island.get(x, y).powf((1.0 + noise.get(x, y)).max(0.1)));
        }
    }
    picture("island", &island, 1)?;
    picture("crater", &make(&Crater { crest_m: 40.0, ..Crater::default() }, &island, Rim::CLOSED, 0)?, 1)?;
    picture("island_warped", &make(&Warp::default(), &island, Rim::CLOSED, 5)?, 1)?;
    picture("island_smooth", &make(&Smooth { sigma_cells: 6.0, ..Smooth::default() }, &island, Rim::CLOSED, 5)?, 1)?;
    let cone = make(&Cone { apex: 0.2, exponent: 0.7, ..Cone::default() }, &flat, Rim::CLOSED, 0)?;
    picture("cone", &cone, 1)?;
    picture("ramp", &make(&Ramp { direction: 30.0, high: 2000.0, low: 0.0 }, &flat, Rim::CLOSED, 0)?, 1)?;
    Ok(())
}
