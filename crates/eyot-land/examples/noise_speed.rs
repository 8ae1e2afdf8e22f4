//! Speed of fractal noise for every instruction set: `cargo run --release -p eyot-land --example noise_speed`.
use eyot_core::isa::Isa;
use eyot_core::process::Site;
use eyot_core::{Control, Grid, Limits, Rim, World};
use eyot_land::generate::{Basis, Fbm};

fn main() {
    let n = 1024;
    let Ok(grid) = Grid::new(n, n, 10.0, Rim::CLOSED, &Limits::default()) else { return };
    let world = World::new(grid, 1);
    let control = Control::none();
    let site = Site { grid, seed: 7, world: &world, control: &control };
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
    for basis in [Basis::Perlin, Basis::Simplex] {
        for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
            let fbm = Fbm { basis, ..Fbm::default() };
            let best = (0..5)
                .map(|_| {
                    let start = std::time::Instant::now();
                    let _ = pool.install(|| fbm.compute(&site, isa));
                    start.elapsed().as_secs_f64()
                })
                .fold(f64::INFINITY, f64::min);
            println!("{basis:?} {}: {:.1} Mpoints/s, 8 octaves, one thread", isa.name(), (n * n) as f64 / best / 1e6);
        }
    }
}
