//! Throw-away probe of the engine's speed.
use eyot_core::engine::CpuEngine;
use eyot_core::isa::Isa;
use eyot_core::plan::Plan;
use eyot_core::process::*;
use eyot_core::*;
use eyot_land::simulate::hydraulic::*;
use eyot_land::simulate::thermal::*;
struct H;
impl Process for H {
    fn layers(&self) -> Vec<(LayerSpec, f32)> {
        use layer::known::*;
        vec![
            (HEIGHT, 0.0),
            (WATER, 0.0),
            (SEDIMENT, 0.0),
            (LayerSpec::new("flux_x", "m/s", "", (-1e9, 1e9)).on(Stagger::FaceX), 0.0),
            (LayerSpec::new("flux_y", "m/s", "", (-1e9, 1e9)).on(Stagger::FaceY), 0.0),
        ]
    }
    fn plan(&self, _m: &Moment, plan: &mut Plan) {
        plan.scratch(&LayerSpec::new("raw_x", "m/s", "", (-1e9, 1e9)).on(Stagger::FaceX));
        plan.scratch(&LayerSpec::new("raw_y", "m/s", "", (-1e9, 1e9)).on(Stagger::FaceY));
        plan.scratch(&LayerSpec::new("afford", "m/s", "", (-1e9, 1e9)).empty_outside());
        plan.scratch(&LayerSpec::new("afford_sediment", "m/s", "", (-1e9, 1e9)).empty_outside());
        let dt = 0.1;
        plan.push::<Flux>(FluxParams { push_x: dt * 9.81, push_y: dt * 9.81, keep: 0.99, dt, sea: -1e30 });
        plan.push::<Erode>(ErodeParams {
            dt,
            dx: 1.0,
            dy: 1.0,
            slope_x: 0.5,
            slope_y: 0.5,
            rain: 0.002,
            keep: 0.9995,
            dry: 0.005,
            speed2_max: 25.0,
            sine2_min: 0.0025,
            sine2_max: 0.25,
            capacity: 0.1,
            ramp: 10.0,
            dig: 0.03,
            settle: 0.03,
            dig_limit: 0.25,
            sea: -1e30,
        });
    }
}
struct T;
impl Process for T {
    fn layers(&self) -> Vec<(LayerSpec, f32)> {
        vec![(layer::known::HEIGHT, 0.0)]
    }
    fn plan(&self, _m: &Moment, plan: &mut Plan) {
        plan.push::<Slump>(SlumpParams { stay_x: 0.6, stay_y: 0.6, stay_d: 0.85, rate: 0.08, rate_d: 0.04 });
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: usize = a[1].parse().unwrap();
    let threads: usize = a[2].parse().unwrap();
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().unwrap();
    for isa in Isa::ALL {
        if !isa.is_available() || (a.len() > 3 && a[3] != isa.name()) {
            continue;
        }
        for chain in a[4].split(',').map(|c| c.parse::<usize>().unwrap()) {
            for which in 0..2 {
                let grid = Grid::new(n, n, 1.0, Rim::CLOSED, &Limits::default()).unwrap();
                let mut w = World::new(grid, 1);
                w.put(
                    &layer::known::HEIGHT,
                    Field::from_fn(n, n, |x, y| {
                        40.0 + 20.0 * ((x as f32 * 0.05).sin() * (y as f32 * 0.043).cos())
                            + 3.0 * ((x as f32 * 0.9).sin() + (y as f32 * 1.1).cos())
                    }),
                )
                .unwrap();
                let ps: Vec<Scheduled> = vec![if which == 0 {
                    Scheduled { name: "h", process: Box::new(H), every: 1 }
                } else {
                    Scheduled { name: "t", process: Box::new(T), every: 1 }
                }];
                let e = CpuEngine { isa, chain, ..Default::default() };
                let steps = (if isa == Isa::Scalar { 20_000_000 } else { 200_000_000usize } / (n * n)).max(8) as u64;
                let steps = if isa == Isa::Scalar { (20_000_000 / (n * n)).max(8) as u64 } else { steps };
                e.simulate(&mut w, &ps, Span { from: 0, steps: steps / 4 }, &Control::none()).unwrap();
                let mut best = f64::MAX;
                for _ in 0..3 {
                    let t = std::time::Instant::now();
                    e.simulate(&mut w, &ps, Span { from: 0, steps }, &Control::none()).unwrap();
                    best = best.min(t.elapsed().as_secs_f64());
                }
                println!(
                    "{} {} chain {chain}: {:.0} Mcs  fp {:x}",
                    ["hydraulic", "thermal"][which],
                    isa.name(),
                    (n * n) as f64 * steps as f64 / best / 1e6,
                    w.fingerprint()
                );
            }
        }
    }
}
