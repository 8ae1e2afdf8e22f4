//! Seconds that each generator takes with its defaults: `cargo run --release -p eyot-land --example generators -- 4096`.
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::Site;
use eyot_core::{Boundary, Control, Grid, Limits, World};
use eyot_land::generate::GENERATORS;
use serde_json::json;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let side: usize = std::env::args().nth(1).map_or(Ok(1024), |a| a.parse())?;
    println!("{side}x{side}, {} threads, best of 3, s", rayon::current_num_threads());
    for rim in [Boundary::CLOSED, Boundary::WRAP] {
        println!("rim {:?}", rim.x);
        let grid = Grid::new(side, side, 10.0, rim, &Limits::default())?;
        let control = Control::none();
        // Filters and masks work on hills.
        let mut world = World::new(grid, 1);
        let fbm = GENERATORS.iter().find(|e| e.name == "fbm").ok_or("there is no fbm")?;
        let flat = eyot_core::Field::new(side, side, 0.0);
        let hills = (fbm.make)(json!({}))?.generate(&Site::whole(grid, 1, &world, &control), &flat)?;
        world.put(&HEIGHT, hills.clone())?;
        for entry in GENERATORS {
            let generator = (entry.make)(json!({}))?;
            let mut best = f64::INFINITY;
            for _ in 0..3 {
                let start = Instant::now();
                std::hint::black_box(generator.generate(&Site::whole(grid, 1, &world, &control), &hills)?);
                best = best.min(start.elapsed().as_secs_f64());
            }
            println!("  {:18} {best:8.3}", entry.name);
        }
    }
    Ok(())
}
