//! Writes the start of a benchmark and its state some steps later as raw `f32`, for `benches/peers/check.py`.
//!
//! `peer_fields CASE SIZE STEPS FILE` with CASE = signed, classic, thermal or reef writes FILE (start) and FILE.eyot, the
//! layers one after the other in the order of the process, and prints their names and the ledger in cell thicknesses.
//! `peer_fields drainage SIZE 0 FILE` writes the heights that `benches/peers/drainage_peers.py` drains.

use eyot_bench::cpu::{self, BenchSubject};
use eyot_core::engine::CpuEngine;
use eyot_core::process::Span;
use eyot_core::{Control, World};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [case, size, steps, file] = args.as_slice() else {
        return Err("usage: peer_fields signed|classic|thermal|reef|drainage SIZE STEPS FILE".into());
    };
    if case == "drainage" {
        let (_, height) = cpu::drainage_case(size.parse()?)?;
        std::fs::write(file, height.iter().flat_map(|z| z.to_le_bytes()).collect::<Vec<u8>>())?;
        return Ok(());
    }
    let (what, classic) = match case.as_str() {
        "classic" => (BenchSubject::Hydraulic, true),
        name => (name.parse()?, false),
    };
    let (mut world, processes) = cpu::case(what, classic, size.parse()?)?;
    let start = PathBuf::from(file);
    write(&world, start.clone())?;
    let span = Span { from: 0, steps: steps.parse()? };
    CpuEngine::default().simulate(&mut world, &processes, span, &Control::none())?;
    write(&world, start.with_added_extension("eyot"))?;

    let area = world.grid.cell_area_m2();
    let thickness = |unit: &str, amount: f64| if unit == "m3" { amount / area } else { amount };
    let ledger: BTreeMap<&str, f64> =
        world.ledger.iter().map(|(name, a)| (name, thickness(&a.unit, a.amount))).collect();
    let layers: Vec<&str> = world.layers().iter().map(|l| &*l.spec.name).collect();
    println!("{}", serde_json::json!({ "layers": layers, "ledger": ledger }));
    Ok(())
}

fn write(world: &World, path: PathBuf) -> std::io::Result<()> {
    let values = world.layers().iter().flat_map(|l| l.field.iter());
    std::fs::write(path, values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}
