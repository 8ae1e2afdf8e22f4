//! What this machine can simulate on, and whether it does so rightly: `eyot doctor`.

use eyot::engines::{self, isa};
use eyot::{EngineChoice, EngineOptions};
use eyot_core::engine::CpuEngine;
use eyot_core::isa::Isa;
use eyot_core::process::{Scheduled, Span};
use eyot_core::remedy::Remedy;
use eyot_core::{Control, Error, Field, Grid, Limits, Rim, World};
use eyot_gpu::{AdapterReport, Gpu, GpuEngine, GpuError, Options, blocking};
use eyot_land::simulate::{Hydraulic, Thermal};
use serde::Serialize;
use std::time::Instant;

/// Side of the world of the self-test, cells.
const SIZE: usize = 96;
/// Steps of the self-test.
const STEPS: u64 = 50;
/// The results may differ by so much of the relief.
const TOLERANCE: f64 = 1e-4;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Examination {
    /// Threads of the processor.
    pub threads: usize,
    /// Instruction set that the processor works with.
    pub isa: &'static str,
    /// Graphics adapters, the best one first.
    pub adapters: Vec<Adapter>,
    /// What `--engine auto` takes.
    pub auto: String,
    /// Why.
    pub because: String,
    /// The self-test.
    pub test: Test,
}

/// A graphics adapter.
#[derive(Clone, Debug, Serialize)]
pub struct Adapter {
    /// Its name.
    pub name: String,
    /// Discrete, integrated, virtual or software.
    pub kind: &'static str,
    /// The interface through which it is reached.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
    /// Largest buffer, bytes.
    pub max_buffer: u64,
    /// Largest part of a buffer that a rule can reach, bytes.
    pub max_binding: u64,
    /// Memory of a workgroup, bytes.
    pub workgroup_memory: u32,
    /// Whether it can time its own work.
    pub timestamps: bool,
}

/// The same erosion on two engines.
#[derive(Clone, Debug, Serialize)]
pub struct Test {
    /// What the processor was compared with.
    pub compared: String,
    /// Cells along a side.
    pub size: usize,
    /// Steps.
    pub steps: u64,
    /// Largest difference of the heights as a share of the relief; `None` if the other engine failed.
    pub difference: Option<f64>,
    /// Largest difference that passes.
    pub tolerance: f64,
    /// Time of the processor, s.
    pub processor_s: f64,
    /// Time of the other one, s, with the way to the card and back.
    pub other_s: Option<f64>,
    /// What went wrong.
    pub failure: Option<Remedy>,
    /// Whether it passed.
    pub passed: bool,
}

/// Looks at the machine and tests the adapter whose name contains `adapter`, or the best one.
///
/// # Errors
/// If the processor itself fails.
pub fn examine(adapter: Option<&str>) -> Result<Examination, Error> {
    let reports = blocking::adapters();
    let hardware = reports.iter().find(|r| r.is_hardware());
    let (auto, because) = match (hardware, reports.first()) {
        (Some(r), _) => (format!("gpu ({})", r.name), "it is hardware".to_owned()),
        (None, Some(r)) => {
            let because = format!("`{}` only imitates a graphics card, and the processor does better", r.name);
            (format!("cpu ({})", isa().name()), because)
        }
        (None, None) => (format!("cpu ({})", isa().name()), "there is no graphics adapter".to_owned()),
    };
    Ok(Examination {
        threads: rayon::current_num_threads(),
        isa: isa().name(),
        auto,
        because,
        test: test(adapter, reports.is_empty())?,
        adapters: reports.iter().map(Adapter::of).collect(),
    })
}

impl Adapter {
    fn of(r: &AdapterReport) -> Self {
        Self {
            name: r.name.clone(),
            kind: r.kind.name(),
            backend: r.backend.clone(),
            driver: format!("{} {}", r.driver, r.driver_info).trim().to_owned(),
            max_buffer: r.max_buffer,
            max_binding: r.max_binding,
            workgroup_memory: r.workgroup_memory,
            timestamps: r.timestamps,
        }
    }
}

fn test(adapter: Option<&str>, no_adapters: bool) -> Result<Test, Error> {
    let one = |name, process| Scheduled { name, process, every: 1 };
    let processes =
        vec![one("hydraulic", Box::<Hydraulic>::default() as Box<_>), one("thermal", Box::<Thermal>::default())];
    let start = hills()?;
    let (low, high) = start.layer("height")?.field.min_max();
    let span = Span { from: 0, steps: STEPS };
    let mut reference = start.clone();
    let begun = Instant::now();
    CpuEngine::default().simulate(&mut reference, &processes, span, &Control::none())?;
    let processor_s = begun.elapsed().as_secs_f64();

    let mut world = start;
    let begun = Instant::now();
    let (compared, outcome) = if no_adapters && adapter.is_none() {
        let plain = CpuEngine { isa: Isa::Scalar, ..CpuEngine::default() };
        let outcome = plain.simulate(&mut world, &processes, span, &Control::none()).map_err(GpuError::Core);
        (format!("cpu ({})", Isa::Scalar.name()), outcome)
    } else {
        let options =
            EngineOptions { choice: EngineChoice::Gpu, adapter: adapter.map(str::to_owned), ..Default::default() };
        match blocking::open(&engines::adapter(&options)) {
            Ok(gpu) => (format!("gpu ({})", gpu.name()), on_card(gpu, &mut world, &processes, span)),
            Err(e) => (format!("gpu ({})", adapter.unwrap_or("the best one")), Err(e)),
        }
    };
    let other_s = outcome.is_ok().then(|| begun.elapsed().as_secs_f64());
    let failure = outcome.err().map(Remedy::from);
    let difference = match &failure {
        None => {
            let (a, b) = (&reference.layer("height")?.field, &world.layer("height")?.field);
            let worst = a.iter().zip(b.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            Some(f64::from(worst) / f64::from(high - low))
        }
        Some(_) => None,
    };
    let passed = difference.is_some_and(|d| d <= TOLERANCE);
    Ok(Test {
        compared,
        size: SIZE,
        steps: STEPS,
        difference,
        tolerance: TOLERANCE,
        processor_s,
        other_s,
        failure,
        passed,
    })
}

fn on_card(gpu: Gpu, world: &mut World, processes: &[Scheduled], span: Span) -> Result<(), GpuError> {
    let mut engine = GpuEngine::new(gpu, Options::default(), None)?;
    engine.simulate(world, processes, span, &Control::none())?;
    engine.download(world)
}

/// Rounded hills of 60 m by the sea.
fn hills() -> Result<World, Error> {
    let grid = Grid::new(SIZE, SIZE, 10.0, Rim::CLOSED, &Limits::default())?;
    let mut world = World::new(grid, 1);
    let wave = |t: f32| eyot_core::math::sin(t);
    let field = Field::from_fn(SIZE, SIZE, |x, y| {
        let (x, y) = (x as f32, y as f32);
        20.0 + 20.0 * wave(0.13 * x + 1.0) * wave(0.11 * y)
            + 10.0 * wave(0.31 * (x + y))
            + 5.0 * wave(0.5 * x - 0.7 * y)
    });
    world.put(&eyot_core::layer::known::HEIGHT, field)?;
    Ok(world)
}
