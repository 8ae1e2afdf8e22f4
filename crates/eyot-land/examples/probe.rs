use eyot_core::engine::CpuEngine;
use eyot_core::isa::Isa;
use eyot_core::process::*;
use eyot_core::*;
use eyot_land::simulate::hydraulic::*;
use eyot_land::simulate::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: usize = a[1].parse().unwrap();
    rayon::ThreadPoolBuilder::new().num_threads(a[2].parse().unwrap()).build_global().unwrap();
    let isa = Isa::ALL.into_iter().find(|i| i.name() == a[3]).unwrap();
    for chain in a[4].split(',').map(|c| c.parse::<usize>().unwrap()) {
        for which in a[5].split(',') {
            let grid = Grid::new(n, n, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
            let mut w = World::new(grid, 1);
            w.sea_level_m = 300.0;
            w.put(
                &layer::known::HEIGHT,
                Field::from_fn(n, n, |x, y| {
                    10.0 * (40.0
                        + 20.0 * ((x as f32 * 0.05).sin() * (y as f32 * 0.043).cos())
                        + 3.0 * ((x as f32 * 0.9).sin() + (y as f32 * 1.1).cos()))
                }),
            )
            .unwrap();
            let p: Box<dyn Process> = match which {
                "h" => Box::new(Hydraulic::default()),
                "c" => Box::new(Hydraulic { flux: FluxForm::Classic, time_step: 0.25, ..Default::default() }),
                "t" => Box::new(Thermal::default()),
                _ => Box::new(Reef { diffusivity: 2.0, ..Default::default() }),
            };
            let ps = vec![Scheduled { name: "x", process: p, every: 1 }];
            let band = a.get(6).map_or(0, |b| b.parse().unwrap());
            let e = CpuEngine { isa, chain, band, ..Default::default() };
            let steps = (300_000_000 / (n * n)).max(8) as u64;
            e.simulate(&mut w, &ps, Span { from: 0, steps: steps / 2 }, &Control::none()).unwrap();
            let mut best = f64::MAX;
            for _ in 0..5 {
                let t = std::time::Instant::now();
                e.simulate(&mut w, &ps, Span { from: 0, steps }, &Control::none()).unwrap();
                best = best.min(t.elapsed().as_secs_f64());
            }
            println!("{which} {n} chain {chain}: {:.0} Mcs", (n * n) as f64 * steps as f64 / best / 1e6);
        }
    }
}
