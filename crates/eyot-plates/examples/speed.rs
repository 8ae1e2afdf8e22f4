//! Times the steps of a world of plates: `cargo run --release -p eyot-plates --example speed -- [SIDE] [STEPS]`
use eyot_core::{Boundary, Grid, Limits};
use eyot_plates::{Plates, Start, Tectonics};
use std::time::Instant;

fn main() {
    let number = |i: usize, usual: usize| std::env::args().nth(i).map_or(usual, |s| s.parse().unwrap_or(usual));
    let (side, steps) = (number(1, 512), number(2, 1100));
    let grid = Grid::new(side, side, 4e7 / side as f64, Boundary::WRAP, &Limits::default()).expect("a sound grid");
    let p = Tectonics { land: 0.35, cycle: 550.0, ..Default::default() };
    let start = Instant::now();
    let mut plates = Plates::new(&grid, 3, p, Start::Noise).expect("sound parameters");
    println!("start: {:?}", start.elapsed());
    let start = Instant::now();
    (0..steps).for_each(|_| plates.step());
    println!("{:?} a step, cycle {:?}", start.elapsed() / steps as u32, plates.cycle_and_steps());
}
