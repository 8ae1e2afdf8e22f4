//! Benchmarks of the GPU engine: `eyot bench --engine gpu`.
//!
//! First everything is compiled, then the pace settles and the time of a step is found, then the clock runs. A timing ends when the
//! queue is drained and a layer has been read back. Beside it stands what the work would take if nothing but the card's memory were
//! in its way: the bytes that fused passes must move, over the bandwidth of a plain copy.

use crate::cpu::{self, BenchSubject};
use eyot::engines::{card, keep_pipelines};
use eyot::{EngineOptions, Overrides, Recipe, RecipeSource, Registry, Run, RunError, RunOptions, Work as StepWork};
use eyot_core::process::{Scheduled, Span};
use eyot_core::remedy;
use eyot_core::remedy::{Action, Setting};
use eyot_core::{Control, Error, Limits, World};
use eyot_gpu::{GpuEngine, GpuError, Options, Work, copy_bandwidth};
use serde::Serialize;
use std::time::Instant;

/// Steps of the island as it is measured: those of the recipe `island`, in proportion.
pub const ISLAND_STEPS: u64 = 3000;

/// What to measure on a graphics card.
#[derive(Clone, Debug)]
pub struct GpuBenchOptions {
    /// One of the simulations; `None` is the island: the steps of the recipe of that name, [`ISLAND_STEPS`] of them.
    pub what: Option<BenchSubject>,
    /// Cells along a side of the square grid.
    pub size: usize,
    /// Hydraulic erosion as published in 2007.
    pub classic: bool,
    /// Time to spend, s; compiling and settling come on top.
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
    /// What was run: each phase with its steps.
    pub phases: Vec<BenchPhase>,
    /// Steps that were timed.
    pub steps: u64,
    /// All of the island's steps, from its start; `None` for what has no end, and if there was no time for all of them.
    pub whole: Option<WholeRun>,
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

/// A part of what was run.
#[derive(Clone, Debug, Serialize)]
pub struct BenchPhase {
    /// Its name in the recipe, or the process.
    pub name: String,
    /// Steps that were timed, in all repeats.
    pub steps: u64,
}

/// How long all of a run took on average.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct WholeRun {
    /// Steps.
    pub steps: u64,
    /// From the first submission until a layer has been read back, s.
    pub seconds: f64,
    /// The card's own time, s; 0 if it has no time stamps.
    pub card_seconds: f64,
}

/// Processes that act together for a while.
struct Phase {
    name: String,
    processes: Vec<Scheduled>,
    /// `None` if there is no end to it.
    steps: Option<u64>,
}

/// Runs a benchmark on a graphics card.
///
/// # Errors
/// If there is no adapter, the device fails, or the world does not fit it.
pub fn run(options: &GpuBenchOptions) -> Result<GpuBenchReport, RunError> {
    if !(options.seconds > 0.0 && options.seconds <= 86_400.0) {
        return Err(RunError::input(format!("seconds: {} is not above 0 and at most 86400", options.seconds)));
    }
    let (world, phases) = case(options)?;
    let how = Options::default().timed(true).most_passes(options.most_passes);
    let mut engine = card(&options.engine, how).map_err(device)?;
    let copy_bandwidth = copy_bandwidth(engine.gpu()).map_err(device)?;
    let cells = world.grid.cells() as f64;
    let start = phases.iter().any(|p| p.steps.is_some()).then(|| world.clone());
    let mut bench = Bench { engine: &mut engine, phases: &phases, start, world, done: 0 };
    let outcome = bench.measure(options.seconds);
    keep_pipelines(&engine);
    let Timed { seconds, steps, work, repeats } = outcome?;
    let n: u64 = steps.iter().sum();
    let whole = phases.iter().zip(&steps).all(|(p, n)| p.steps.is_some_and(|all| *n == all * repeats));
    let each = |total: f64| total / repeats as f64;
    let card = if work.card_s > 0.0 { work.card_s } else { seconds };
    let per = |total: f64| total / n as f64;
    Ok(GpuBenchReport {
        what: options.what.map_or("island", BenchSubject::name),
        size: options.size,
        adapter: engine.gpu().name().to_owned(),
        phases: phases.into_iter().zip(steps).map(|(p, steps)| BenchPhase { name: p.name, steps }).collect(),
        steps: n,
        whole: whole.then(|| WholeRun { steps: n / repeats, seconds: each(seconds), card_seconds: each(work.card_s) }),
        seconds_per_step: per(seconds),
        card_seconds_per_step: per(work.card_s),
        cell_steps_per_second: cells / per(seconds),
        dispatches_per_step: per(work.dispatches as f64),
        steps_per_submission: n as f64 / work.submissions.max(1) as f64,
        bytes_per_cell_step: per(work.bytes as f64) / cells,
        copy_bandwidth,
        share_of_bandwidth: work.bytes as f64 / card / copy_bandwidth,
        pipelines: engine.work().pipelines,
    })
}

/// What does not fit is refused before anything is measured.
fn device(e: GpuError) -> RunError {
    match e {
        GpuError::Core(e) => input(e),
        e => RunError::Device(e.into()),
    }
}

fn input(e: Error) -> RunError {
    match e {
        // A benchmark has no setting for the limit on memory.
        Error::Limit { what, needed, limit, .. } => RunError::refused(
            format!("too large: {what} needs {needed}, the limit is {limit}"),
            remedy!["choose fewer cells with ", Setting::Size],
        ),
        e => RunError::refused(e, remedy!["see ", Action::BenchOptions]),
    }
}

/// The world at the start, and what is to be done to it.
fn case(options: &GpuBenchOptions) -> Result<(World, Vec<Phase>), RunError> {
    let Some(what) = options.what else { return island(options.size) };
    let none = || {
        RunError::refused(
            format!("`{}` has no rules of cells and runs on the processor", what.name()),
            remedy!["choose ", Setting::Engine.to("cpu")],
        )
    };
    match what {
        BenchSubject::Noise
        | BenchSubject::Drainage
        | BenchSubject::Rivers
        | BenchSubject::Community
        | BenchSubject::Plates => {
            return Err(none());
        }
        _ => {}
    }
    let (world, processes) = cpu::case(what, options.classic, options.size).map_err(input)?;
    if processes.iter().any(|s| s.process.action().is_some()) {
        return Err(none());
    }
    Ok((world, vec![Phase { name: what.name().to_owned(), processes, steps: None }]))
}

/// The recipe `island`: its generators have been at work, its simulations are the phases.
fn island(size: usize) -> Result<(World, Vec<Phase>), RunError> {
    let source = RecipeSource::builtin("island").ok_or_else(|| RunError::Fault("there is no island".into()))?;
    let side = u32::try_from(size).map_err(|e| RunError::input(e.to_string()))?;
    let overrides = Overrides { size: Some((side, Some(side))), ..Overrides::default() };
    let mut recipe = Recipe::parse(source, overrides, &Registry::standard(), &Limits::default())?;
    let mut phases = Vec::new();
    for step in recipe.steps.iter_mut().filter(|s| s.enabled) {
        if let StepWork::Simulate(s) = &step.work {
            let processes = s.schedule().map_err(input)?;
            phases.push(Phase { name: step.name.clone(), processes, steps: Some(s.steps) });
            step.enabled = false;
        }
    }
    let all: u64 = phases.iter().filter_map(|p| p.steps).sum();
    for p in &mut phases {
        p.steps = p.steps.map(|n| n * ISLAND_STEPS / all.max(1));
    }
    let world = Run::start(recipe, RunOptions::default())?.join()?.world;
    Ok((world, phases))
}

/// A benchmark at work.
struct Bench<'a> {
    engine: &'a mut GpuEngine,
    phases: &'a [Phase],
    /// Where phases that have an end begin; for others no second copy is held.
    start: Option<World>,
    /// The world that is worked on, and how many steps of the phase it has done.
    world: World,
    done: u64,
}

/// What was timed.
struct Timed {
    seconds: f64,
    /// Of each phase, in all repeats.
    steps: Vec<u64>,
    work: Work,
    repeats: u64,
}

impl Bench<'_> {
    fn measure(&mut self, seconds: f64) -> Result<Timed, RunError> {
        let per_step = self.phases.iter().map(|p| self.settle(p, seconds)).collect::<Result<Vec<f64>, _>>()?;
        // What has an end is done from the beginning to the end, or in parts that take the time together.
        let wanted = self.phases.iter().zip(&per_step).map(|(p, each)| match p.steps {
            Some(all) => all,
            None => ((0.1 * seconds / each) as u64).max(1),
        });
        let wanted: Vec<u64> = wanted.collect();
        let steps = within(seconds, &wanted, &per_step, self.engine.block(&self.world.grid));
        let before = self.engine.work();
        let (mut timed, mut repeats) = (0.0, 0);
        loop {
            timed += self.repeat(&steps)?;
            repeats += 1;
            if timed + 0.5 * timed / repeats as f64 > seconds {
                break;
            }
        }
        let work = self.engine.work().since(before);
        Ok(Timed { seconds: timed, steps: steps.iter().map(|n| n * repeats).collect(), work, repeats })
    }

    /// Compiles, touches memory and finds the pace; seconds a step then.
    fn settle(&mut self, phase: &Phase, seconds: f64) -> Result<f64, RunError> {
        let mut steps = self.engine.block(&self.world.grid);
        self.begin_anew();
        // Two blocks: copies of layers take turns.
        self.stretch(phase, 2 * steps)?;
        loop {
            let took = self.stretch(phase, steps)?;
            // The clock is fine enough for this.
            if took >= (0.05 * seconds).min(0.25) || steps >= 1 << 20 {
                return Ok((took / steps as f64).max(1e-12));
            }
            steps *= 2;
        }
    }

    fn begin_anew(&mut self) {
        if let Some(start) = &self.start {
            self.engine.release();
            self.world.clone_from(start);
            self.done = 0;
        }
    }

    /// All phases one after the other; seconds.
    fn repeat(&mut self, steps: &[u64]) -> Result<f64, RunError> {
        let mut seconds = 0.0;
        for (i, (phase, &n)) in self.phases.iter().zip(steps).enumerate() {
            if phase.steps.is_some() {
                if i == 0 {
                    self.begin_anew();
                } else {
                    // As runs do between two steps of a recipe.
                    self.engine.download(&mut self.world).map_err(device)?;
                    self.engine.release();
                    self.done = 0;
                }
            }
            seconds += self.stretch(phase, n)?;
        }
        Ok(seconds)
    }

    /// Runs steps, drains the queue and reads a layer back; seconds.
    fn stretch(&mut self, phase: &Phase, steps: u64) -> Result<f64, RunError> {
        let begun = Instant::now();
        let span = Span { from: self.done, steps };
        self.engine.simulate(&mut self.world, &phase.processes, span, &Control::none()).map_err(device)?;
        if let Some(pending) = self.engine.request("height").map_err(device)? {
            std::hint::black_box(pending.take(self.engine.gpu()).map_err(device)?.get(0, 0));
        }
        self.done += steps;
        Ok(begun.elapsed().as_secs_f64())
    }
}

/// All the `wanted` steps of each phase if there is time for them, else the same share of each, in whole blocks.
fn within(seconds: f64, wanted: &[u64], per_step: &[f64], block: u64) -> Vec<u64> {
    let total: f64 = wanted.iter().zip(per_step).map(|(n, each)| *n as f64 * each).sum();
    let part = |all: u64| ((all as f64 * seconds / total) as u64).max(1).next_multiple_of(block).min(all);
    wanted.iter().map(|&all| if total <= seconds { all } else { part(all) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(what: Option<BenchSubject>, size: usize) -> GpuBenchOptions {
        GpuBenchOptions { what, size, classic: false, seconds: 0.3, most_passes: 0, engine: EngineOptions::default() }
    }

    /// `None` where there is no adapter and none is required.
    fn measured(options: &GpuBenchOptions) -> Option<GpuBenchReport> {
        match run(options) {
            Err(RunError::Device(e)) if e.refused && std::env::var_os("EYOT_REQUIRE_GPU").is_none() => None,
            outcome => Some(outcome.unwrap()),
        }
    }

    #[test]
    fn what_cannot_be_measured_is_refused_with_what_to_do() {
        for (options, remedy) in [
            (options(Some(BenchSubject::Drainage), 64), "the engine `cpu`"),
            (options(Some(BenchSubject::Noise), 64), "the engine `cpu`"),
            (options(Some(BenchSubject::Streampower), 64), "the engine `cpu`"),
            (options(Some(BenchSubject::Hydraulic), 200_000), "`size`"),
        ] {
            let e = run(&options).unwrap_err();
            assert!(e.is_refusal(), "{e}");
            assert!(e.help().unwrap().to_string().contains(remedy), "{e}: {:?}", e.help());
            assert!(!e.to_string().contains("max_memory"), "{e}");
        }
        let forever = GpuBenchOptions { seconds: f64::INFINITY, ..options(Some(BenchSubject::Thermal), 64) };
        assert!(run(&forever).unwrap_err().to_string().contains("seconds"));
    }

    #[test]
    fn a_simulation_is_timed_with_all_compiled_before() {
        let Some(r) = measured(&options(Some(BenchSubject::Hydraulic), 64)) else { return };
        assert!(r.whole.is_none() && r.steps > 0 && r.seconds_per_step > 0.0);
        assert_eq!((r.phases.len(), r.phases[0].steps), (1, r.steps));
        assert!(r.bytes_per_cell_step > 0.0 && r.dispatches_per_step > 0.0 && r.dispatches_per_step <= 2.0);
    }

    #[test]
    fn the_island_is_the_recipes_and_whole_if_there_is_time() {
        let (world, phases) = island(32).unwrap();
        assert!(world.get("height").unwrap().min_max().1 > 300.0, "the generators have been at work");
        let steps: Vec<u64> = phases.iter().filter_map(|p| p.steps).collect();
        assert_eq!(steps.iter().sum::<u64>(), ISLAND_STEPS);
        let of_erosion: Vec<&str> = phases[0].processes.iter().map(|s| s.name).collect();
        assert_eq!(of_erosion, ["hydraulic", "thermal", "seabed", "wetness"]);
        assert!(phases[0].processes[1].every > 1, "the recipe's schedule");

        let Some(r) = measured(&options(None, 32)) else { return };
        assert_eq!(r.phases.iter().map(|p| p.steps).sum::<u64>(), r.steps);
        assert_eq!(r.whole.is_some(), r.steps % ISLAND_STEPS == 0);
        assert_eq!(within(10.0, &[1500, 1500], &[0.002, 0.001], 8), [1500, 1500], "4.5 s");
        assert_eq!(within(3.0, &[1500, 1500], &[0.002, 0.001], 8), [1000, 1000]);
        assert_eq!(within(0.001, &[1500, 4], &[0.002, 0.001], 8), [8, 4], "a block at least");
    }
}
