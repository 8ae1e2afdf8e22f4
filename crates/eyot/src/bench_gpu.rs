//! Benchmarks of the GPU engine: `eyot bench --engine gpu`.
//!
//! A timing ends when the queue is drained and a layer has been read back. Beside it stands what the work would take if nothing
//! but the card's memory were in its way: the bytes that fused passes must move, over the bandwidth of a plain copy.

use crate::bench::{self, BenchSubject};
use crate::engines::EngineOptions;
use crate::error::RunError;
use eyot_core::process::{Process, Scheduled, Span};
use eyot_core::{Control, Limits, World};
use eyot_gpu::{Gpu, GpuEngine, GpuError, Options, Work, copy_bandwidth};
use eyot_land::simulate::{Hydraulic, Reef, Thermal};
use serde::Serialize;
use std::time::Instant;

/// What to measure on a graphics card.
#[derive(Clone, Debug)]
pub struct GpuBenchOptions {
    /// One of the simulations; `None` is the work of the island: hydraulic and thermal erosion and reef growth in every step.
    pub what: Option<BenchSubject>,
    /// Cells along a side of the square grid.
    pub size: usize,
    /// Hydraulic erosion as published in 2007.
    pub classic: bool,
    /// Time to spend, s.
    pub seconds: f64,
    /// Passes of a dispatch; 0 chooses.
    pub most_passes: usize,
    /// Which adapter.
    pub engine: EngineOptions,
}

/// What was measured on a graphics card.
#[derive(Clone, Debug, Serialize)]
pub struct GpuBenchReport {
    /// What was measured.
    pub what: &'static str,
    /// Cells along a side.
    pub size: usize,
    /// The adapter.
    pub adapter: String,
    /// Steps that were timed.
    pub steps: u64,
    /// Seconds a step, from the first submission until a layer has been read back.
    pub seconds_per_step: f64,
    /// The card's own seconds a step, from its time stamps; 0 if it has none.
    pub card_seconds_per_step: f64,
    /// Cells times steps a second.
    pub cell_steps_per_second: f64,
    /// Dispatches a step, each with a barrier.
    pub dispatches_per_step: f64,
    /// Steps a submission.
    pub steps_per_submission: f64,
    /// Bytes that fused passes must move between memory and processors for a cell and step.
    pub bytes_per_cell_step: f64,
    /// Bandwidth of a copy within the card's memory, bytes read and written a second.
    pub copy_bandwidth: f64,
    /// Share of that bandwidth that the work makes use of: the bound is 1.
    pub share_of_bandwidth: f64,
    /// Pipelines compiled, all before the clock ran.
    pub pipelines: u64,
}

/// Runs a benchmark on a graphics card.
///
/// # Errors
/// If there is no adapter, the device fails, or the world does not fit it.
pub fn run(options: &GpuBenchOptions) -> Result<GpuBenchReport, RunError> {
    let failed = |e: eyot_core::Error| RunError::Gpu(GpuError::Core(e));
    let (mut world, processes) = match options.what {
        Some(what) => bench::case(what, options.classic, options.size).map_err(failed)?,
        None => island(options.size).map_err(failed)?,
    };
    if processes.iter().any(|s| s.process.action().is_some()) {
        return Err(RunError::input("this work has no rules of cells and runs on the processor; choose --engine cpu"));
    }
    let gpu = Gpu::open(&options.engine.adapter())?;
    let copy_bandwidth = copy_bandwidth(&gpu)?;
    let engine_options = Options { timed: true, most_passes: options.most_passes, ..Options::default() };
    let mut engine = GpuEngine::new(gpu, engine_options, None)?;
    let mut done = 0;
    // Compiles, touches memory and finds the pace.
    let once = stretch(&mut engine, &mut world, &processes, &mut done, 8)?;
    let steps = ((options.seconds / once.max(1e-9)) as u64).clamp(8, 1_000_000);
    let before = engine.work();
    let seconds = stretch(&mut engine, &mut world, &processes, &mut done, steps)?;
    let work = difference(engine.work(), before);
    let cells = world.grid.cells() as f64;
    let (n, bytes) = (steps as f64, work.bytes as f64);
    let card = if work.card_s > 0.0 { work.card_s / n } else { seconds };
    Ok(GpuBenchReport {
        what: options.what.map_or("island", BenchSubject::name),
        size: options.size,
        adapter: engine.gpu().name().to_owned(),
        steps,
        seconds_per_step: seconds,
        card_seconds_per_step: work.card_s / n,
        cell_steps_per_second: cells / seconds,
        dispatches_per_step: work.dispatches as f64 / n,
        steps_per_submission: n / work.submissions.max(1) as f64,
        bytes_per_cell_step: bytes / (n * cells),
        copy_bandwidth,
        share_of_bandwidth: bytes / n / card / copy_bandwidth,
        pipelines: engine.work().pipelines,
    })
}

/// Runs steps, drains the queue and reads a layer back; seconds a step.
fn stretch(
    engine: &mut GpuEngine,
    world: &mut World,
    processes: &[Scheduled],
    done: &mut u64,
    steps: u64,
) -> Result<f64, RunError> {
    let begun = Instant::now();
    engine.simulate(world, processes, Span { from: *done, steps }, &Control::none())?;
    if let Some(pending) = engine.request("height")? {
        std::hint::black_box(pending.take(engine.gpu())?.get(0, 0));
    }
    *done += steps;
    Ok(begun.elapsed().as_secs_f64() / steps as f64)
}

fn difference(now: Work, before: Work) -> Work {
    Work {
        steps: now.steps - before.steps,
        submissions: now.submissions - before.submissions,
        dispatches: now.dispatches - before.dispatches,
        bytes: now.bytes - before.bytes,
        pipelines: now.pipelines - before.pipelines,
        card_s: now.card_s - before.card_s,
    }
}

/// The three processes of the island on the start fields of the hydraulic benchmark.
fn island(size: usize) -> eyot_core::Result<(World, Vec<Scheduled>)> {
    let (world, _) = bench::case(BenchSubject::Hydraulic, false, size)?;
    world.grid.checked(&Limits::default())?;
    let one = |name, process: Box<dyn Process>| Scheduled { name, process, every: 1 };
    let processes = vec![
        one("hydraulic", Box::<Hydraulic>::default()),
        one("thermal", Box::<Thermal>::default()),
        one("reef", Box::<Reef>::default()),
    ];
    Ok((world, processes))
}
