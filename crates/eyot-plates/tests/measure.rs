use eyot_core::{Edge, Grid, Limits, Rim};
use eyot_plates::crust::CONTINENTAL_M;
use eyot_plates::{Plates, Start, Tectonics, hypsometry};
use rayon::prelude::*;
const CYLINDER: Rim = Rim { x: Edge::Wrap, y: Edge::Closed };
fn land(p: &Plates) -> f64 {
    p.height().iter().filter(|h| **h > 0.0).count() as f64 / p.height().len() as f64
}
#[test]
fn measure() {
    let scale: usize = std::env::var("SCALE").ok().map_or(1, |s| s.parse().unwrap());
    let rows: Vec<String> = (0..200u64)
        .into_par_iter()
        .map(|seed| {
            let rim = [Rim::WRAP, CYLINDER, Rim::CLOSED, Rim::OPEN][seed as usize % 4];
            let p = Tectonics { count: 2 + (seed % 29) as u32, land: 0.1 + 0.1 * (seed % 6) as f32, ..Tectonics::default() };
            let (w, h) = [(64, 32), (48, 48), (37, 53), (80, 20), (128, 64)][seed as usize / 4 % 5];
            let (w, h) = (w * scale, h * scale);
            let small = Grid::new(w, h, 1e7 / w as f64, rim, &Limits::default()).unwrap();
            let mut plates = Plates::new(&small, seed, p.clone(), Start::Noise).unwrap();
            let (mut worst, mut at, mut over) = (0.0f64, 0, 0);
            let l0 = plates.numbers()[4];
            let mut jump = 0f64;
            let mut stands = 0; let mut still = 0; let mut ridges = plates.budget().ridges;
            let c0 = plates.crust_m().filter(|&c| c >= CONTINENTAL_M).count();
            let mut last = l0;
            for s in 0..320 {
                plates.step();
                let d = land(&plates) - f64::from(p.land);
                if d.abs() > worst.abs() { worst = d; at = s }
                over += usize::from(d.abs() > 0.03);
                let l = plates.numbers()[4];
                jump = jump.max((l - last).abs());
                last = l;
                if plates.budget().ridges == ridges { still += 1; stands = stands.max(still) } else { still = 0 }
                ridges = plates.budget().ridges;
            }
            let c1 = plates.crust_m().filter(|&c| c >= CONTINENTAL_M).count();
            let hy = hypsometry(plates.height().iter().copied());
            format!("{seed:3} {} {w}x{h} n{:2} land {:.1} worst {:+.4} at {at} over {over} level {:+.0} jump {jump:.0} still {stands} cont {c0}->{c1} ({:.2} of land) peaks {:?} cycles {} delam {:.2} removed arcs {:.2}", ["wrap","cyl ","clsd","open"][seed as usize%4], p.count, p.land, worst, last - l0,
              c1 as f64/(w*h) as f64/f64::from(p.land), hy.peaks_m, plates.cycle_and_steps().0, plates.budget().delaminated as f64 / plates.budget().start as f64, plates.budget().arcs as f64 / plates.budget().start as f64)
        })
        .collect();
    for r in rows {
        println!("{r}");
    }
}
#[test]
fn dump() {
    let var = |n: &str, d: &str| std::env::var(n).unwrap_or(d.into());
    let w: usize = var("W", "512").parse().unwrap();
    let g = Grid::new(w, w / 2, 4e7 / w as f64, CYLINDER, &Limits::default()).unwrap();
    let at: Vec<usize> = var("AT", "1,60,120,180,250").split(',').map(|s| s.parse().unwrap()).collect();
    let default = Tectonics::default();
    let p = if var("EARTH", "") != "" {
        default
    } else {
        Tectonics { count: 12, gather: 0.9, breakup: 0.7, cycle: 0.0, ..default }
    };
    for seed in var("SEEDS", "4").split(',').map(|s| s.parse::<u64>().unwrap()) {
        let mut plates = Plates::new(&g, seed, p.clone(), Start::Noise).unwrap();
        let t = std::time::Instant::now();
        for s in 1..=*at.last().unwrap() {
            plates.step();
            if at.contains(&s) {
                let bytes: Vec<u8> = plates
                    .height()
                    .iter()
                    .flat_map(|h| h.to_le_bytes())
                    .chain(plates.owner().iter().copied())
                    .collect();
                std::fs::write(format!("/work/wt/tmp-tecto/d_{seed}_{s}.bin"), bytes).unwrap();
            }
        }
        println!("seed {seed}: {:?}, level {}", t.elapsed(), plates.numbers()[4]);
    }
}
#[test]
fn speed() {
    let g = Grid::new(512, 512, 4e7 / 512.0, Rim::WRAP, &Limits::default()).unwrap();
    let time = |p: Tectonics, what: &str| {
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let mut plates = Plates::new(&g, 1, p.clone(), Start::Noise).unwrap();
            let t = std::time::Instant::now();
            for _ in 0..150 {
                plates.step();
            }
            best = best.min(t.elapsed().as_secs_f64() / 150.0 * 1e3);
        }
        println!("{what}: {best:.3} ms a step");
    };
    let d = Tectonics::default();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        time(d.clone(), "all");
        time(Tectonics { denudation: 0.0, ..d.clone() }, "no denudation");
        time(Tectonics { speed: 0.0, ..d.clone() }, "standing");
        time(Tectonics { speed: 0.0, denudation: 0.0, ..d.clone() }, "standing, no denudation");
        time(Tectonics { cycle: 10.0, ..d.clone() }, "15 restarts");
        time(Tectonics { arcs: 0.0, ..d.clone() }, "no arcs");
    });
}
