//! The engine as its users meet it: parity over long runs, actions, stops, lost devices, memory, and how much it does.

use eyot_core::component::Numbers;
use eyot_core::control::{Cancel, Control};
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known;
use eyot_core::process::{Action, ActionInstance, Locality, Moment, Process, Scheduled, Site, Span};
use eyot_core::{Boundary, Error, Field, Grid, Limits, World};
use eyot_gpu::{Choice, GpuEngine, GpuError, Options, blocking};
use eyot_land::generate::GENERATORS;
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::{PROCESSES, Thermal, Wetness};
use eyot_testing::one;
use std::time::Duration;

use crate::common;

pub(crate) fn engine(options: Options) -> Option<GpuEngine> {
    common::gpu().map(|gpu| GpuEngine::new(gpu, options, None).unwrap())
}

/// A mountain of noise, 100 m high.
pub(crate) fn mountain(side: usize, rim: Boundary) -> World {
    let grid = Grid::new(side, side, 10.0, rim, &Limits::default()).unwrap();
    let mut world = World::new(grid, 3);
    let fbm = GENERATORS.iter().find(|e| e.name == "fbm").unwrap();
    let mut table = (fbm.defaults)();
    table["amplitude"] = 100.0.into();
    let generator = (fbm.make)(table).unwrap();
    let base = Field::new(side, side, 0.0);
    let field = generator.generate(&Site::whole(grid, 5, &world, &Control::none()), &base).unwrap();
    world.put(&known::HEIGHT, field).unwrap();
    world
}

pub(crate) fn erosion() -> Vec<Scheduled> {
    let rain = Hydraulic { rain: 0.01, ..Default::default() };
    vec![
        one(rain),
        Scheduled { name: "thermal", process: Box::new(Thermal::default()), every: 3 },
        Scheduled { name: "wetness", process: Box::new(Wetness::default()), every: 2 },
    ]
}

fn on_cpu(world: &mut World, processes: &[Scheduled], from: u64, steps: u64) {
    CpuEngine::default().simulate(world, processes, Span { from, steps }, &Control::none()).unwrap();
}

fn height(world: &World) -> Vec<f32> {
    world.get("height").unwrap().to_vec()
}

fn largest_difference(a: &World, b: &World) -> f32 {
    height(a).iter().zip(height(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Kolmogorov and Smirnov's distance of two samples.
fn distance(mut a: Vec<f32>, mut b: Vec<f32>) -> f64 {
    a.sort_by(f32::total_cmp);
    b.sort_by(f32::total_cmp);
    let share = |sorted: &[f32], v: f32| sorted.partition_point(|x| *x <= v) as f64 / sorted.len() as f64;
    a.iter().chain(&b).map(|&v| (share(&a, v) - share(&b, v)).abs()).fold(0.0, f64::max)
}

fn slopes(world: &World) -> Vec<f32> {
    let h = world.get("height").unwrap();
    let n = world.grid.width - 1;
    let at = |x: usize, y: usize| {
        let (dx, dy) = (h.get(x + 1, y) - h.get(x, y), h.get(x, y + 1) - h.get(x, y));
        (dx * dx + dy * dy).sqrt()
    };
    (0..n).flat_map(|y| (0..n).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

fn hypsometric_integral(world: &World) -> f64 {
    let h = world.get("height").unwrap();
    let (low, high) = h.min_max();
    (h.sum() / h.iter().count() as f64 - f64::from(low)) / f64::from(high - low)
}

/// D2: after 100 steps at most 1e-4 of the relief, after 10,000 steps equal statistics.
#[test]
fn long_runs_agree_with_the_processor() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let processes = erosion();
    let start = mountain(64, Boundary::CLOSED);
    let (low, high) = start.get("height").unwrap().min_max();
    let (mut a, mut b) = (start.clone(), start);
    on_cpu(&mut a, &processes, 0, 100);
    engine.simulate(&mut b, &processes, Span { from: 0, steps: 100 }, &Control::none()).unwrap();
    engine.download(&mut b).unwrap();
    let d = largest_difference(&a, &b) / (high - low);
    println!("after 100 steps: {d:e} of the relief");
    assert!(d <= 1e-4, "{d}");

    on_cpu(&mut a, &processes, 100, 9900);
    engine.simulate(&mut b, &processes, Span { from: 100, steps: 9900 }, &Control::none()).unwrap();
    engine.download(&mut b).unwrap();
    assert_eq!((a.step, b.step), (10_000, 10_000));
    let mass = |w: &World| w.get("height").unwrap().sum() + w.get("sediment").unwrap().sum();
    let mass = (mass(&a) - mass(&b)).abs() / mass(&a).abs();
    let integral = (hypsometric_integral(&a) - hypsometric_integral(&b)).abs();
    let slopes = distance(slopes(&a), slopes(&b));
    println!("after 10000 steps: mass {mass:e}, hypsometric integral {integral:e}, slopes {slopes:e}");
    println!("ledger: {:?} {:?}", a.ledger.amount("water.rain"), b.ledger.amount("water.rain"));
    assert!(mass <= 1e-6 && integral <= 0.01 && slopes <= 0.02);
    // What rounding leaves is another number wherever another order of operations rounds.
    for (name, account) in a.ledger.iter().filter(|(name, _)| !name.ends_with(".rounded")) {
        let (want, got) = (account.amount, b.ledger.amount(name));
        // How often a limit acts differs more than what moves.
        let share = if name.starts_with("hydraulic.") { 1e-2 } else { 1e-3 };
        assert!((want - got).abs() <= share * want.abs().max(1.0), "{name}: {got}, on the processor {want}");
    }
}

/// Drainage is no rule of cells: it runs on the processor between dispatches.
#[test]
fn actions_run_between_dispatches() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let entry = PROCESSES.iter().find(|e| e.name == "streampower").unwrap();
    let mut processes = erosion();
    processes.push(Scheduled { name: "streampower", process: (entry.make)((entry.defaults)()).unwrap(), every: 4 });
    let start = mountain(48, Boundary::OPEN);
    let (mut a, mut b) = (start.clone(), start.clone());
    on_cpu(&mut a, &processes, 0, 10);
    engine.simulate(&mut b, &processes, Span { from: 0, steps: 10 }, &Control::none()).unwrap();
    engine.download(&mut b).unwrap();
    assert!(largest_difference(&a, &start) > 0.01, "something happened");
    let d = largest_difference(&a, &b);
    assert!(d < 1e-2, "{d} m");
    assert_eq!(a.step, b.step);
}

/// How fast the card is must not decide what is added to what: neither layers nor the ledger differ by a bit, however many dispatches go
/// into a submission, wherever spans end between blocks, and however often somebody looks.
#[test]
fn neither_pace_nor_looks_change_a_bit() {
    let processes = erosion();
    let start = mountain(40, Boundary::OPEN);
    let run = |submission: Duration, blocks_a_span: u64, looks: bool| {
        let mut engine = engine(Options::default().submission(submission))?;
        let mut world = start.clone();
        let stride = blocks_a_span * engine.block(&world.grid);
        let mut from = 0;
        while from < 150 {
            let steps = stride.min(150 - from);
            engine.simulate(&mut world, &processes, Span { from, steps }, &Control::none()).unwrap();
            from += steps;
            if looks {
                engine.download(&mut world).unwrap();
            }
        }
        engine.download(&mut world).unwrap();
        Some((world, engine.work()))
    };
    let Some((slow, many)) = run(Duration::ZERO, 100, false) else { return };
    let Some((fast, few)) = run(Duration::from_secs(10), 100, false) else { return };
    let Some((cut, _)) = run(Duration::from_millis(1), 3, false) else { return };
    let Some((seen, _)) = run(Duration::from_millis(1), 1, true) else { return };
    assert!(few.submissions * 4 < many.submissions, "{} and {} submissions", few.submissions, many.submissions);
    assert_eq!(few.dispatches, many.dispatches);
    assert!(slow.ledger.amount("water.evaporated") > 0.0);
    for other in [&fast, &cut, &seen] {
        assert!(slow.layers() == other.layers());
        for (name, account) in slow.ledger.iter() {
            let (a, b) = (account.amount, other.ledger.amount(name));
            assert_eq!(a.to_bits(), b.to_bits(), "{name}: {a:?} and {b:?}");
        }
    }
}

#[test]
fn a_request_to_stop_leaves_whole_steps() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let processes = erosion();
    let start = mountain(40, Boundary::WRAP);
    let cancel = Cancel::default();
    let raised = cancel.clone();
    let progress = move |done: u64, _: u64| {
        if done > 20 {
            raised.raise();
        }
    };
    let mut world = start.clone();
    let outcome =
        engine.simulate(&mut world, &processes, Span { from: 0, steps: 1_000_000 }, &Control::new(cancel, &progress));
    assert!(matches!(outcome, Err(GpuError::Core(Error::Cancelled(_)))));
    engine.download(&mut world).unwrap();
    assert!(world.step > 20 && world.step < 1_000_000, "{}", world.step);
    let mut again = start;
    engine.release();
    engine.simulate(&mut again, &processes, Span { from: 0, steps: world.step }, &Control::none()).unwrap();
    engine.download(&mut again).unwrap();
    assert_eq!(again.step, world.step);
    assert!(largest_difference(&again, &world) < 1e-3);
}

#[test]
fn a_device_lost_on_the_way_leaves_the_last_sound_world() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let processes = erosion();
    let start = mountain(40, Boundary::CLOSED);
    let mut whole = start.clone();
    engine.simulate(&mut whole, &processes, Span { from: 0, steps: 50 }, &Control::none()).unwrap();
    engine.download(&mut whole).unwrap();
    engine.release();

    let mut world = start;
    engine.simulate(&mut world, &processes, Span { from: 0, steps: 20 }, &Control::none()).unwrap();
    engine.download(&mut world).unwrap();
    let sound = world.clone();
    engine.simulate(&mut world, &processes, Span { from: 20, steps: 10 }, &Control::none()).unwrap();
    assert_eq!(world.step, 30);
    engine.gpu().destroy();
    let outcome = engine.simulate(&mut world, &processes, Span { from: 30, steps: 20 }, &Control::none());
    assert!(outcome.is_err_and(|e| e.is_lost()));
    assert_eq!(world, sound, "what was last brought back");

    // On with another device.
    let mut other = GpuEngine::new(blocking::open(&Choice::Best).unwrap(), Options::default(), None).unwrap();
    other.simulate(&mut world, &processes, Span { from: 20, steps: 30 }, &Control::none()).unwrap();
    other.download(&mut world).unwrap();
    assert!(largest_difference(&world, &whole) < 1e-3);
}

/// Lifts the land by a metre, counts how often, and may take the device away.
#[derive(Clone)]
pub(crate) struct Lift(pub(crate) Option<(wgpu::Device, f64)>);

impl Process for Lift {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![known::HEIGHT.changed(0.0)]
    }

    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for Lift {
    fn instantiate(&self, _world: &World) -> eyot_core::Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn cannot_fail(&self) -> bool {
        true
    }

    fn locality(&self) -> Locality {
        Locality::Cell
    }

    fn bytes_per_cell(&self) -> usize {
        0
    }
}

impl ActionInstance for Lift {
    fn act(&mut self, moment: &Moment, world: &mut World, _: &Control<'_>) -> eyot_core::Result<()> {
        world.layer_mut("height")?.field.map_in_place(|h| h + 1.0);
        world.ledger.add("lift.rock", world.grid.cells() as f64, "m3", "Rock from below", 1);
        world.components.entry("lift", || Numbers(vec![0.0]))?.0[0] += 1.0;
        if let Some((device, turn)) = &self.0
            && *turn == moment.turn as f64
        {
            device.destroy();
        }
        Ok(())
    }
}

/// Whoever cannot fail acts on a world of which the card alone knows the rest.
#[test]
fn quick_actions_leave_the_world_on_the_card() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let with = |lift| {
        let mut processes = erosion();
        processes.insert(1, Scheduled { name: "lift", process: Box::new(Lift(lift)), every: 4 });
        processes
    };
    let (processes, start) = (with(None), mountain(40, Boundary::CLOSED));
    let (mut cpu, mut whole, mut parts) = (start.clone(), start.clone(), start.clone());
    on_cpu(&mut cpu, &processes, 0, 30);
    engine.simulate(&mut whole, &processes, Span { from: 0, steps: 30 }, &Control::none()).unwrap();
    engine.download(&mut whole).unwrap();
    assert!(largest_difference(&whole, &cpu) < 1e-2, "{}", largest_difference(&whole, &cpu));
    let lifts = whole.components.get::<Numbers>("lift").unwrap().unwrap().0[0];
    assert_eq!((lifts, whole.ledger.amount("lift.rock")), (8.0, 8.0 * 1600.0));
    assert!(whole.ledger.amount("water.rain") > 0.0);
    engine.release();
    for from in (0..30).step_by(3) {
        engine.simulate(&mut parts, &processes, Span { from, steps: 3 }, &Control::none()).unwrap();
        engine.download(&mut parts).unwrap();
    }
    assert!(largest_difference(&parts, &whole) < 1e-3);
    engine.release();

    // Lost with some layers of the world newer than others; and in a step in whose middle the world moved to a larger place, since
    // what is due then needs copies of layers that were not there.
    for turn in [2.0, 0.0] {
        let Some(mut engine) = self::engine(Options::default()) else { return };
        let mut world = start.clone();
        let none = Control::none();
        if turn > 0.0 {
            engine.simulate(&mut world, &processes, Span { from: 0, steps: 3 }, &none).unwrap();
            engine.download(&mut world).unwrap();
        }
        let sound = world.clone();
        let lossy = with(Some((engine.gpu().device().clone(), turn)));
        let outcome = engine.simulate(&mut world, &lossy, Span { from: sound.step, steps: 20 }, &none);
        assert!(outcome.is_err(), "turn {turn}");
        assert_eq!((world.step, world.components.clone()), (sound.step, sound.components.clone()), "turn {turn}");
        for l in sound.layers() {
            assert!(world.get(&l.spec.name) == Some(&l.field), "turn {turn}: {}", l.spec.name);
        }
        assert_eq!(world.ledger, sound.ledger, "turn {turn}");
    }
}

/// The driver itself says that there is no memory left: at the beginning, and when layers are to come back.
#[test]
fn a_card_without_memory_left_says_so_and_the_world_stays_sound() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let processes = erosion();
    let mut world = mountain(100, Boundary::CLOSED);
    let start = world.clone();
    let span = |from, steps| Span { from, steps };
    engine.gpu().run_short_of_memory(100_000);
    let e = engine.simulate(&mut world, &processes, span(0, 5), &Control::none()).unwrap_err();
    assert!(matches!(e, GpuError::OutOfMemory { .. }), "{e}");
    let says = e.to_string();
    assert!(says.contains("the layers (2 MiB)") && says.contains(engine.gpu().name()), "{says}");
    assert!(says.contains("the engine `cpu`"), "{says}");
    assert_eq!((world.step, &height(&world)), (0, &height(&start)), "nothing has begun");

    engine.gpu().run_short_of_memory(u64::MAX);
    engine.simulate(&mut world, &processes, span(0, 16), &Control::none()).unwrap();
    engine.download(&mut world).unwrap();
    let sound = world.clone();
    engine.simulate(&mut world, &processes, span(16, 16), &Control::none()).unwrap();
    engine.gpu().run_short_of_memory(10_000);
    let e = engine.download(&mut world).unwrap_err();
    assert!(matches!(e, GpuError::OutOfMemory { .. }), "{e}");
    assert_eq!(world, sound, "what was last brought back");

    engine.gpu().run_short_of_memory(u64::MAX);
    engine.simulate(&mut world, &processes, span(16, 16), &Control::none()).unwrap();
    engine.download(&mut world).unwrap();
    let mut whole = start;
    engine.release();
    engine.simulate(&mut whole, &processes, span(0, 32), &Control::none()).unwrap();
    engine.download(&mut whole).unwrap();
    assert_eq!(height(&world), height(&whole), "as if nothing had been");
}

#[test]
fn a_world_too_large_for_the_limits_is_refused_before_it_moves() {
    let limits = Limits { max_bytes: 100_000, ..Limits::default() };
    let Some(mut engine) = engine(Options::default().limits(limits)) else { return };
    let mut world = mountain(100, Boundary::CLOSED);
    let before = world.get("height").unwrap().clone();
    let outcome = engine.simulate(&mut world, &erosion(), Span { from: 0, steps: 1 }, &Control::none());
    let Err(GpuError::Core(e @ Error::Limit { .. })) = outcome else { panic!("{outcome:?}") };
    assert!(e.to_string().contains("graphics card"), "{e}");
    assert_eq!(*world.get("height").unwrap(), before);
}

#[test]
fn a_world_too_large_for_the_card_is_refused() {
    // A single row of which exceeds what one buffer may hold.
    let Some(mut engine) = engine(Options::default().most_bytes(4096)) else { return };
    let mut world = mountain(100, Boundary::CLOSED);
    let outcome = engine.simulate(&mut world, &erosion(), Span { from: 0, steps: 1 }, &Control::none());
    assert!(matches!(outcome, Err(GpuError::Limits { .. })), "{outcome:?}");
    // It is of further use.
    engine.options.most_bytes = u64::MAX;
    engine.simulate(&mut world, &erosion(), Span { from: 0, steps: 1 }, &Control::none()).unwrap();
}

#[test]
fn values_that_are_not_finite_are_found_and_named() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let mut world = mountain(40, Boundary::CLOSED);
    world.layer_mut("height").unwrap().field.set(7, 9, f32::NAN);
    let outcome = engine.simulate(&mut world, &erosion(), Span { from: 0, steps: 3 }, &Control::none());
    let Err(GpuError::Core(Error::NotFinite { .. })) = outcome else { panic!("{outcome:?}") };
}

#[test]
fn layers_come_back_while_the_simulation_goes_on() {
    let Some(mut engine) = engine(Options::default()) else { return };
    let processes = erosion();
    let mut world = mountain(40, Boundary::CLOSED);
    engine.simulate(&mut world, &processes, Span { from: 0, steps: 10 }, &Control::none()).unwrap();
    let pending = engine.request("height").unwrap().unwrap();
    assert!(engine.request("no such layer").unwrap().is_none());
    let range = engine.gpu().complete(engine.range("height")).unwrap().unwrap();
    let mut at_ten = world.clone();
    engine.download(&mut at_ten).unwrap();
    engine.simulate(&mut world, &processes, Span { from: 10, steps: 10 }, &Control::none()).unwrap();
    let field = pending.take(engine.gpu()).unwrap();
    assert_eq!(field, *at_ten.get("height").unwrap());
    assert_eq!((range.low, range.high, range.not_finite), (field.min_max().0, field.min_max().1, 0));
    engine.download(&mut world).unwrap();
    assert_ne!(field, *world.get("height").unwrap());
}

/// What goes to the card is what the plan says: fused passes, one dispatch each, nothing compiled twice.
#[test]
fn work_is_what_the_plan_says() {
    let four = || Hydraulic { flux: FluxForm::Signed, ..Default::default() };
    let hydraulic = || vec![one(four())];
    let mut moved = Vec::new();
    for (most_passes, dispatches) in [(1, 200), (2, 100)] {
        let Some(mut engine) = engine(Options::default().most_passes(most_passes)) else { return };
        let mut world = mountain(40, Boundary::CLOSED);
        engine.simulate(&mut world, &hydraulic(), Span { from: 0, steps: 100 }, &Control::none()).unwrap();
        let work = engine.work();
        assert_eq!((work.steps, work.dispatches), (100, dispatches));
        assert!(work.submissions < 100);
        // Heavier rain is another number in the job and not another shader.
        let compiled = work.pipelines;
        let more = vec![one(Hydraulic { rain: 0.02, ..four() })];
        engine.simulate(&mut world, &more, Span { from: 100, steps: 10 }, &Control::none()).unwrap();
        assert_eq!(engine.work().pipelines, compiled);
        moved.push(work.bytes / (100 * 40 * 40));
    }
    // Height, water, sediment and two fluxes in and out; unfused also raw fluxes and shares, written once and read once.
    assert_eq!(moved, [84, 40], "bytes a cell and step");
}
