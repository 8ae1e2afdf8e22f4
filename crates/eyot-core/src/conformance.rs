//! One suite that every engine must pass for every rule: [`check`] compares it with the reference, bit by bit.
//!
//! Crates that define processes call it from their tests with their registries.

use crate::control::Control;
use crate::domain::Domain;
use crate::engine::CpuEngine;
use crate::error::Result;
use crate::grid::{Boundary, BoundaryCondition, Grid};
use crate::isa::Isa;
use crate::layer::{Centering, Layer, LayerSpec};
use crate::limits::Limits;
use crate::process::{Locality, Moment, Scheduled, Span};
use crate::reference::Reference;
use crate::rng::{self, Key};
use crate::stepper::reach;
use crate::world::World;

/// Grid shapes that find mistakes at rims, tails of lanes and cuts of bands.
pub const SHAPES: [(usize, usize); 12] =
    [(1, 1), (1, 7), (9, 1), (2, 2), (3, 5), (15, 4), (16, 16), (17, 3), (27, 51), (33, 40), (64, 9), (5, 97)];

/// The nine rims.
pub fn rims() -> Vec<Boundary> {
    let edges = [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap];
    edges.iter().flat_map(|&x| edges.iter().map(move |&y| Boundary { x, y })).collect()
}

/// A world of random values within every layer's plausible range: `start(layer name, uniform number)` gives the value.
///
/// # Errors
/// If the grid is not sound.
pub fn random_world(
    shape: (usize, usize),
    rim: Boundary,
    seed: u64,
    processes: &[Scheduled],
    start: &dyn Fn(&str, f32) -> f32,
) -> Result<World> {
    let mut grid = Grid::new(shape.0, shape.1, 2.0, rim, &Limits::default())?;
    grid.cell_y_m = 2.5;
    let mut world = World::new(grid, seed);
    for s in processes {
        for l in s.process.layers() {
            world.ensure(&l.spec, l.start);
        }
    }
    let names: Vec<String> = world.layers().iter().map(|l| l.spec.name.to_string()).collect();
    for (i, name) in names.iter().enumerate() {
        let field = &mut world.layer_mut(name)?.field;
        for y in 0..shape.1 {
            for x in 0..shape.0 {
                let u = rng::unit::<f32>(rng::hash(Key::new(seed, i as u32, 0), (y * shape.0 + x) as u32));
                field.set(x, y, start(name, u));
            }
        }
    }
    for s in processes {
        s.process.prepare(&mut world)?;
    }
    Ok(world)
}

/// Runs the processes on random worlds of all shapes and rims with every instruction set, chain length and band height,
/// and compares layers with the single-precision reference bit by bit and the ledger within rounding.
///
/// # Errors
/// If a simulation fails.
///
/// # Panics
/// With the layer, cell and both values, where engine and reference differ.
pub fn check(processes: &[Scheduled], start: &dyn Fn(&str, f32) -> f32) -> Result<()> {
    let steps = 5;
    for shape in SHAPES {
        for (i, rim) in rims().into_iter().enumerate() {
            let world = random_world(shape, rim, 7 + i as u64, processes, start)?;
            let mut reference = Reference::<f32>::new(&world);
            reference.simulate(processes, steps);
            for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
                for (chain, band) in [(1, 0), (2, 1), (5, 1)] {
                    let mut w = world.clone();
                    let engine = CpuEngine { isa, chain, band, ..CpuEngine::default() };
                    engine.simulate(&mut w, processes, Span { from: 0, steps }, &Control::none())?;
                    let here = format!("{shape:?} {rim:?} {} chain {chain} band {band}", isa.name());
                    for l in w.layers() {
                        for y in 0..shape.1 {
                            for x in 0..shape.0 {
                                let (got, want) = (l.field.get(x, y), reference.get(&l.spec.name, x, y));
                                assert!(
                                    got.to_bits() == want.to_bits(),
                                    "{} at ({x}, {y}) is {got:?}, the reference has {want:?}; {here}",
                                    l.spec.name
                                );
                            }
                        }
                    }
                    for (account, want) in &reference.ledger {
                        let got = w.ledger.amount(account);
                        assert!(
                            (got - want).abs() <= 1e-5 * want.abs() + 1e-6,
                            "{account}: {got}, reference {want}; {here}"
                        );
                    }
                }
            }
        }
    }
    Ok(())
}

/// Evaluates every rule's graph on random inputs and compares it with the rule itself, bit by bit.
///
/// # Panics
/// Where they differ, or where a rule reads farther than it declares.
pub fn check_graphs(processes: &[Scheduled], grid: Grid) {
    let mut plan = crate::plan::Plan::default();
    crate::process::plan_step(processes, 0, &mut Moment::whole(grid, 0, 0.5), &mut plan);
    for pass in plan.passes() {
        let graph = pass.graph();
        for (slot, r) in pass.reads().iter().enumerate() {
            assert_eq!(graph.reach(slot), r.reach, "reach of `{}` in rule `{}`", r.layer, pass.name());
        }
        for trial in 0..200u32 {
            let at = |slot: usize, dx: isize, dy: isize| {
                let cell = (dy + 2) as u32 * 5 + (dx + 2) as u32;
                4.0 * rng::unit::<f32>(rng::hash(Key::new(1, slot as u32, u64::from(trial)), cell)) - 1.0
            };
            let bits = |s: u32| rng::hash(Key::new(3, s, 9), trial);
            let (x, y) = (trial as f32, 3.0);
            let view = crate::erased::View { at: &at, uniform: &|s| rng::unit::<f32>(bits(s)), x, y };
            let (out, sums) = graph.evaluate(&pass.params(), &view);
            let (want, want_sums) = pass.rule.cell_f32(&view);
            let same = |a: &[f32], b: &[f32]| a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits()));
            assert!(same(&out, &want) && same(&sums, &want_sums), "graph of `{}`: {out:?} {want:?}", pass.name());
        }
    }
}

/// Fails where a step of the processes reads or writes what they do not declare: once as their rules say it, and once as it is seen in
/// a world whose other layers are filled with something else.
///
/// # Errors
/// If a simulation fails.
///
/// # Panics
/// With the process and the layer.
pub fn check_access(processes: &[Scheduled], start: &dyn Fn(&str, f32) -> f32) -> Result<()> {
    check_access_in(
        &random_world(
            (17, 9),
            Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed },
            3,
            processes,
            start,
        )?,
        processes,
    )
}

/// [`check_access`] in a world that is not random, for processes that cannot do without some sense in their layers.
///
/// # Errors
/// As [`check_access`].
///
/// # Panics
/// As [`check_access`].
pub fn check_access_in(world: &World, processes: &[Scheduled]) -> Result<()> {
    let mut world = world.clone();
    // Something that nobody declares.
    world.ensure(&LayerSpec::new("stranger", "1", "of the suite", (0.0, 1.0)), 0.25);
    for s in processes {
        let (reads, writes) = (s.process.reads(), s.process.writes());
        let moment = Moment::whole(world.grid, 0, 0.0);
        let mut plan = crate::plan::Plan::default();
        s.process.plan(&moment, &mut plan);
        let scratch = |name: &str| plan.scratch_layers().iter().any(|l| l.name == name);
        let mut made: Vec<&str> = Vec::new();
        for pass in plan.passes() {
            for name in pass.reads().iter().map(|r| r.layer).filter(|n| !scratch(n) && !made.contains(n)) {
                assert!(reads.iter().any(|n| n == name), "{}: `{}` reads `{name}`", s.name, pass.name());
            }
            for name in pass.writes().iter().filter(|n| !scratch(n)) {
                assert!(writes.iter().any(|n| n == name), "{}: `{}` writes `{name}`", s.name, pass.name());
                made.push(name);
            }
        }
        let one = || Span { from: 0, steps: 1 };
        let alone = std::slice::from_ref(s);
        let mut before = world.clone();
        // Whatever a preparation makes.
        crate::stepper::prepare(&mut CpuEngine::default().runner(), &mut before, alone).map_err(|e| match e {
            crate::engine::EngineError::Core(e) => e,
            e => unreachable!("{e}"),
        })?;
        // Engines shut the faces of closed rims, whoever runs.
        let settle =
            |world: &mut World| CpuEngine::default().simulate(world, &[], Span { from: 0, steps: 0 }, &Control::none());
        settle(&mut before)?;
        let mut other = before.clone();
        let unread: Vec<String> = before.layers().iter().map(|l| l.spec.name.to_string()).collect();
        for name in unread.iter().filter(|n| !reads.iter().any(|r| r == *n)) {
            other.layer_mut(name)?.field.map_in_place(|v| 0.5 * v + 0.125);
        }
        settle(&mut other)?;
        let (mut after, changed) = (before.clone(), other.clone());
        CpuEngine::default().simulate(&mut after, alone, one(), &Control::none())?;
        CpuEngine::default().simulate(&mut other, alone, one(), &Control::none())?;
        for (i, l) in after.layers().iter().enumerate() {
            let written = writes.contains(&l.spec.name);
            assert!(written || l.field == before.layers()[i].field, "{} writes `{}`", s.name, l.spec.name);
            let same = if written { &l.field } else { &changed.layers()[i].field };
            assert!(other.layers()[i].field == *same, "{}: `{}` depends on what it does not read", s.name, l.spec.name);
        }
        assert!(other.components == after.components, "{}: a component depends on what it does not read", s.name);
    }
    Ok(())
}

/// How [`check_windows`] cuts a grid: columns and rows of all windows.
fn cuts(g: &Grid) -> Vec<(&'static str, Vec<[std::ops::Range<usize>; 2]>)> {
    let (w, h) = (g.width, g.height);
    let tiles = |columns: &[std::ops::Range<usize>], rows: &[std::ops::Range<usize>]| {
        rows.iter().flat_map(|r| columns.iter().map(|c| [c.clone(), r.clone()])).collect()
    };
    let (a, b) = (w / 3, h / 4);
    let (columns, rows) = (0..w, 0..h);
    let (all_columns, all_rows) = (std::slice::from_ref(&columns), std::slice::from_ref(&rows));
    vec![
        ("rows", tiles(all_columns, &[0..b, b..h - 2, h - 2..h])),
        ("columns", tiles(&[0..a, a..w - 5, w - 5..w], all_rows)),
        ("tiles", tiles(&[0..a, a..w], &[0..h - b, h - b..h])),
        ("strips", (0..h).map(|y| [0..w, y..y + 1]).collect()),
    ]
}

/// Runs a step of the processes on a whole grid and on windows of it, and compares the insides bit by bit and what they add to the
/// ledger within rounding. True if they were compared, false if something acts that looks at the whole grid.
///
/// # Errors
/// If a simulation fails.
///
/// # Panics
/// With the layer and the window where they differ.
pub fn check_windows(processes: &[Scheduled], start: &dyn Fn(&str, f32) -> f32) -> Result<bool> {
    let (one, none) = (Span { from: 0, steps: 1 }, Control::none());
    for (i, rim) in rims().into_iter().enumerate() {
        let mut world = random_world((37, 13), rim, 11 + i as u64, processes, start)?;
        // Random numbers and the sun are not those of the first step.
        world.step = 5;
        let halo = match reach(processes, Moment::of(&world), one) {
            Locality::Whole => return Ok(false),
            Locality::Rows(n) => n,
            Locality::Cell => 0,
        };
        let rules = processes.iter().all(|s| s.process.action().is_none());
        let mut whole = world.clone();
        CpuEngine::default().simulate(&mut whole, processes, one, &none)?;
        let mut reference = Reference::<f32>::new(&world);
        if rules {
            reference.simulate(processes, 1);
        }
        for (cut, windows) in cuts(&world.grid) {
            let isas = Isa::ALL.into_iter().filter(|i| i.is_available());
            for isa in isas.filter(|&isa| isa == Isa::best() || cut == "tiles") {
                let here = format!("{cut} of {rim:?}, halo {halo}, {}", isa.name());
                let mut joined = world.clone();
                for [columns, rows] in &windows {
                    let domain = Domain::window(world.grid, columns.clone(), rows.clone(), halo)?;
                    let mut part = world.cut(domain)?;
                    CpuEngine { isa, ..CpuEngine::default() }.simulate(&mut part, processes, one, &none)?;
                    joined.paste(&part)?;
                    for (account, cells) in &reference.by_cell {
                        let inside = || {
                            let cells = rows.clone().map(|y| &cells[y * world.grid.width..][columns.clone()]);
                            cells.flatten().copied()
                        };
                        let (got, want) = (part.ledger.amount(account), inside().sum::<f64>());
                        let slack = 1e-5 * inside().map(f64::abs).sum::<f64>() + 1e-6;
                        assert!(
                            (got - want).abs() <= slack,
                            "{account}: {got} in columns {columns:?} and rows {rows:?}, reference {want}; {here}"
                        );
                    }
                    if cut == "tiles" && rules && isa == Isa::best() {
                        same_as_reference(&world.cut(domain)?, &part, processes, &here);
                    }
                }
                for (l, want) in joined.layers().iter().zip(whole.layers()) {
                    assert!(l.spec == want.spec && bits(l) == bits(want), "`{}` differs; {here}", l.spec.name);
                }
            }
        }
    }
    Ok(true)
}

/// The bits of a layer, outer faces included.
fn bits(l: &Layer) -> Vec<u32> {
    let faces = if l.spec.centering == Centering::Cell { Vec::new() } else { l.field.outer_faces() };
    l.field.iter().chain(faces).map(f32::to_bits).collect()
}

/// Compares all that is held of a window, right or not, with what the reference makes of it.
fn same_as_reference(before: &World, after: &World, processes: &[Scheduled], here: &str) {
    let mut reference = Reference::<f32>::new(before);
    reference.simulate(processes, 1);
    for l in after.layers() {
        for (y, row) in l.field.rows().enumerate() {
            let same =
                (row.iter().enumerate()).all(|(x, v)| v.to_bits() == reference.get(&l.spec.name, x, y).to_bits());
            assert!(same, "`{}` is not the reference's in held row {y}; {here}", l.spec.name);
        }
    }
}
