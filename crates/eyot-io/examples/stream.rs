//! Measures the writers on a raster that never exists as a whole: time, bytes and peak memory.
//!
//! Usage: `cargo run --release -p eyot-io --example stream -- FOLDER SIZE FORMAT...`

use eyot_io::{About, RasterFormat, Rows, WriteOptions, write_rows};
use std::path::PathBuf;
use std::time::Instant;

struct Waves(usize);

impl Rows for Waves {
    fn size(&self) -> (usize, usize) {
        (self.0, self.0)
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()> {
        for (j, row) in out.chunks_exact_mut(self.0).enumerate() {
            let y = (first + j) as f32;
            // Smooth hills under a little roughness, about as compressible as eroded land.
            row.iter_mut().enumerate().for_each(|(x, v)| {
                let (x, rough) = (x as f32, (x * 7919 + (first + j) * 104_729) % 257);
                *v = 400.0 * (x * 0.004).sin() * (y * 0.003).cos() + rough as f32 * 0.01;
            });
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, size, formats @ ..] = args.as_slice() else {
        return Err("usage: stream FOLDER SIZE FORMAT...".into());
    };
    let about = About {
        name: "height".into(),
        unit: "m".into(),
        cell_m: (1.0, 1.0),
        range: Some((-500.0, 500.0)),
        ..About::default()
    };
    for name in formats {
        let format = RasterFormat::from_name(name).ok_or("no such format")?;
        let path = PathBuf::from(folder).join(format!("stream.{}", format.extension()));
        let start = Instant::now();
        write_rows(&path, &mut Waves(size.parse()?), &about, format, &WriteOptions::default())?;
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let peak = status.lines().find(|l| l.starts_with("VmHWM")).unwrap_or("");
        println!("{name}: {:.1} s, {peak}", start.elapsed().as_secs_f64());
    }
    Ok(())
}
