//! The GPU engine: runs plans on the card, with the layers left there.
//!
//! A simulation makes the world **resident**: its layers are brought to the card once and stay there. Steps are planned on the
//! processor in **blocks** that begin at fixed steps, and cut into [groups](crate::group); hundreds of dispatches go to the card in
//! one submission. Two submissions are under way at a time, each short enough that desktops stay responsive and a request to stop
//! is met. How long they are depends on the card's speed, how groups are cut does not: rounding is the same in every run. What has
//! no rule (an [`Action`](eyot_core::process::Action)) runs on the processor, with only the layers moved that changed.
//!
//! The world's own layers are out of date until [`GpuEngine::download`].

use crate::arena::{Arena, Pending};
use crate::clock::Instant;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::{Bounds, Group, JOB_WORDS, Layers, TILE, groups};
use crate::layer_view::LayerView;
use crate::reduce::Reducer;
use crate::shader::{self, Setting};
use eyot_core::control::Control;
use eyot_core::engine::{Borrowed, Saved};
use eyot_core::graph::Graph;
use eyot_core::plan::{Pass, Plan, RuleKind};
use eyot_core::process::{Moment, Scheduled, Span, acts, plan_step};
use eyot_core::rule::{Tally, TallyUnit};
use eyot_core::stepper::Simulation;
use eyot_core::{Edge, Field, Grid, LayerSpec, Ledger, Limits, Stagger, World};
use std::borrow::Cow;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Bytes of the uniform block of a dispatch.
pub(crate) const JOB_BYTES: u64 = 4 * JOB_WORDS as u64;
/// Most dispatches of one submission.
const MOST_DISPATCHES: usize = 4096;
/// Bytes of a workgroup's memory that every WebGPU device has.
pub(crate) const SHARED_BYTES: usize = 16384;
/// Numbers in a workgroup's memory that every WebGPU device has, less those that the sums need.
pub(crate) const SHARED: usize = SHARED_BYTES / 4 - 4 * crate::group::THREADS;
/// Below so many cells the time of a dispatch is that of its launch, and several steps go into one.
const SMALL: usize = 1 << 18;
/// Submissions under way at a time: one on the card while the next is written.
const IN_FLIGHT: usize = 2;

/// How the engine works; nothing here changes a result by more than rounding.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Bounds on what may be allocated.
    pub limits: Limits,
    /// Passes of a dispatch; 0 chooses, 1 switches fusing off.
    pub most_passes: usize,
    /// Bytes of one buffer, beside the device's own bound; larger grids are cut.
    pub most_bytes: u64,
    /// Measures the card's own time with timestamps, if it has them.
    pub timed: bool,
    /// A submission aims at this long.
    pub submission: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            most_passes: 0,
            most_bytes: u64::MAX,
            timed: false,
            submission: Duration::from_millis(20),
        }
    }
}

impl Options {
    /// With these bounds on what may be allocated.
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// With so many passes of a dispatch.
    pub fn most_passes(self, most_passes: usize) -> Self {
        Self { most_passes, ..self }
    }

    /// With buffers of at most so many bytes.
    pub fn most_bytes(self, most_bytes: u64) -> Self {
        Self { most_bytes, ..self }
    }

    /// Measuring the card's own time, or not.
    pub fn timed(self, timed: bool) -> Self {
        Self { timed, ..self }
    }

    /// With submissions of about this long.
    pub fn submission(self, submission: Duration) -> Self {
        Self { submission, ..self }
    }
}

/// What the engine has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Work {
    /// Steps.
    pub steps: u64,
    /// Submissions.
    pub submissions: u64,
    /// Dispatches, with a barrier before each.
    pub dispatches: u64,
    /// Bytes moved between the card's memory and its processors if every layer is moved once a dispatch.
    pub bytes: u64,
    /// Pipelines compiled.
    pub pipelines: u64,
    /// The card's own time, s; 0 without [`Options::timed`].
    pub card_s: f64,
    /// Layers that were brought back from the card.
    pub layers_back: u64,
    /// Bytes that were brought back from the card: layers, sums, ranges, pictures.
    pub bytes_back: u64,
}

impl Work {
    /// What was done after `earlier`.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            steps: self.steps - earlier.steps,
            submissions: self.submissions - earlier.submissions,
            dispatches: self.dispatches - earlier.dispatches,
            bytes: self.bytes - earlier.bytes,
            pipelines: self.pipelines - earlier.pipelines,
            card_s: self.card_s - earlier.card_s,
            layers_back: self.layers_back - earlier.layers_back,
            bytes_back: self.bytes_back - earlier.bytes_back,
        }
    }
}

/// See the module.
pub struct GpuEngine {
    gpu: Gpu,
    /// How it works.
    pub options: Options,
    bind_layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    job: wgpu::Buffer,
    pipelines: HashMap<String, wgpu::ComputePipeline>,
    cache: Option<wgpu::PipelineCache>,
    reducer: Reducer,
    resident: Option<Resident>,
    timer: Option<Timer>,
    batch: Batch,
    pace: Pace,
    work: Work,
}

/// A world whose layers are on the card.
struct Resident {
    arena: Arena,
    specs: Vec<LayerSpec>,
    world_layers: usize,
    /// Which of its two copies holds each layer.
    current: Vec<usize>,
    /// Slots by layer and copy.
    slots: HashMap<(usize, usize), usize>,
    /// Layers that the world's own copies of are out of date.
    stale: Vec<bool>,
    accounts: Vec<Account>,
    seed: u64,
    kernels: HashMap<Group, Arc<Kernel>>,
    graphs: HashMap<RuleKind, Arc<Graph>>,
    /// Step and sea level of the world's own copies.
    synced: (u64, f64),
    /// What actions have changed since the world was downloaded as a whole, as it was then: so that a lost device leaves no mixture.
    held: Option<Saved>,
}

/// A group that is ready to run.
struct Kernel {
    pipeline: wgpu::ComputePipeline,
    outer: [usize; 2],
    bytes_per_cell: usize,
}

/// An account of the ledger whose sum grows on the card.
struct Account {
    tally: Tally,
    /// What it held before.
    before: f64,
    /// What was last written to the ledger.
    written: f64,
}

/// Dispatches that have not gone to the card yet.
#[derive(Default)]
struct Batch {
    jobs: Vec<u32>,
    dispatches: Vec<Dispatch>,
    /// Steps that are complete with them.
    steps: u64,
}

/// One dispatch of a submission.
struct Dispatch {
    kernel: Arc<Kernel>,
    slab: usize,
    job: u32,
    tiles: [u32; 2],
    last_of_group: bool,
}

struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Submissions timed since the last reading.
    used: u32,
}

/// Why a resident world cannot go on as it is.
pub(crate) enum Misfit {
    /// A layer, copy or account is needed that it was not made for.
    Rebuild,
    Failed(GpuError),
}

impl From<GpuError> for Misfit {
    fn from(e: GpuError) -> Self {
        Self::Failed(e)
    }
}

impl GpuEngine {
    /// An engine on an open device. `cache` is what [`GpuEngine::cache_data`] gave in an earlier process, or nothing.
    ///
    /// # Errors
    /// If the device fails.
    pub fn new(gpu: Gpu, options: Options, cache: Option<&[u8]>) -> Result<Self> {
        let device = &gpu.device;
        let storage = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: false },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let job_entry = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: None,
            },
            count: None,
        };
        let bind_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("rules"),
            entries: &[job_entry, storage(1), storage(2)],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("rules"),
            bind_group_layouts: &[Some(&bind_layout)],
            immediate_size: 0,
        });
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let job = gpu.buffer("jobs", JOB_BYTES * MOST_DISPATCHES as u64, usage)?;
        let timed = options.timed && device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let timer = if timed { Some(Timer::new(&gpu)?) } else { None };
        let cache = crate::cache::open(&gpu, cache);
        let reducer = Reducer::new(&gpu);
        gpu.check()?;
        Ok(Self {
            gpu,
            options,
            bind_layout,
            pipeline_layout,
            job,
            pipelines: HashMap::new(),
            cache,
            reducer,
            resident: None,
            timer,
            batch: Batch::default(),
            pace: Pace::default(),
            work: Work::default(),
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// What has been done so far.
    pub fn work(&self) -> Work {
        let traffic = &self.gpu.traffic;
        let (layers_back, bytes_back) = (traffic.layers.load(Relaxed), traffic.bytes.load(Relaxed));
        Work { layers_back, bytes_back, ..self.work }
    }

    /// Compiled pipelines for [`GpuEngine::new`] of the next process, if the driver gives them away.
    pub fn cache_data(&self) -> Option<Vec<u8>> {
        self.cache.as_ref().and_then(wgpu::PipelineCache::get_data)
    }

    /// Runs a span of steps of the given processes on the world, as the CPU engine does; what acts is made anew, which a
    /// [`Simulation`] keeps. Afterwards the step and the sea level
    /// of `world` are right, its layers and its ledger not until [`GpuEngine::download`].
    ///
    /// Between two calls the world must not be changed unless it was downloaded and [`GpuEngine::release`]d.
    ///
    /// # Errors
    /// If a parameter does not fit the world or memory would exceed the limits (before the first step), on a request to stop
    /// (the world is then in the state after some whole step; `world.step` tells which), if a value that is not finite turns up,
    /// and if the device fails: the world is then what it was when it was last downloaded.
    pub fn simulate(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        control: &Control<'_>,
    ) -> Result<()> {
        Simulation::new(processes).advance(self, world, span, control).map_err(GpuError::from)
    }

    /// Makes the layers and the ledger of `world` what they are on the card.
    ///
    /// # Errors
    /// If the device was lost; `world` is then what it was when it was last downloaded.
    pub fn download(&mut self, world: &mut World) -> Result<()> {
        let Some(r) = &mut self.resident else { return Ok(()) };
        let outcome = r.download_all(&self.gpu, world);
        if outcome.is_err() {
            self.fall_back(world);
        }
        outcome?;
        world.check_finite(&format!("step {}", world.step))?;
        Ok(())
    }

    /// Begins to download one layer while the simulation goes on. `None` if no layer of that name is on the card.
    ///
    /// # Errors
    /// If the device fails.
    pub fn request(&self, name: &str) -> Result<Option<Pending>> {
        let Some(r) = &self.resident else { return Ok(None) };
        let Some(layer) = r.specs[..r.world_layers].iter().position(|s| s.name == name) else { return Ok(None) };
        r.arena.request(&self.gpu, r.slots[&(layer, r.current[layer])]).map(Some)
    }

    /// Smallest and largest value of a layer and how many of its values are not finite, found on the card.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn range(&self, name: &str) -> Result<Option<crate::reduce::Range>> {
        let Some(r) = &self.resident else { return Ok(None) };
        let Some(layer) = r.specs[..r.world_layers].iter().position(|s| s.name == name) else { return Ok(None) };
        self.reducer.range(&self.gpu, &r.arena, r.slots[&(layer, r.current[layer])]).await.map(Some)
    }

    /// A layer where it lies on the card, for shaders of others. `None` if no layer of that name is there.
    pub fn layer(&self, name: &str) -> Option<LayerView<'_>> {
        let r = self.resident.as_ref()?;
        let layer = r.specs[..r.world_layers].iter().position(|s| s.name == name)?;
        Some(r.arena.view(r.slots[&(layer, r.current[layer])]))
    }

    /// Gives the card's memory back. What was not downloaded is lost.
    pub fn release(&mut self) {
        self.resident = None;
        self.batch = Batch::default();
    }

    /// Steps that are planned at a time. Who ends spans at multiples of it gets the same bytes wherever they end: rounding depends on
    /// what goes into a dispatch, and a span that ends within a block cuts it in two.
    pub fn block(&self, grid: &Grid) -> u64 {
        // As many steps as a dispatch may have passes fill their dispatches, however many passes a step has.
        self.bounds(grid).passes as u64
    }

    /// Makes the world what it was when it was last downloaded.
    pub(crate) fn fall_back(&mut self, world: &mut World) {
        if let Some(r) = self.resident.take() {
            if let Some(held) = r.held {
                held.put_back(world);
            }
            (world.step, world.sea_level_m) = r.synced;
        }
        self.batch = Batch::default();
        self.pace.under_way.clear();
    }

    /// True if a world is on the card.
    pub(crate) fn is_resident(&self) -> bool {
        self.resident.is_some()
    }

    /// The grid of the world on the card.
    pub(crate) fn resident_grid(&self) -> Option<&Grid> {
        self.resident.as_ref().map(|r| &r.arena.grid)
    }

    /// Steps of the span that the card has done.
    pub(crate) fn steps_completed(&self) -> u64 {
        self.pace.done
    }

    pub(crate) fn start_span(&mut self) {
        self.pace.done = 0;
    }

    pub(crate) fn count_steps(&mut self, steps: u64) {
        self.work.steps += steps;
    }

    pub(crate) fn end_span(&mut self, world: &mut World) -> Result<()> {
        self.finish()?;
        self.read_timer()?;
        self.check_finite(world)
    }

    /// Lends the world those layers that somebody reads, and takes those that he writes.
    pub(crate) fn lend_layers(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> eyot_core::Result<()>,
    ) -> Result<()> {
        self.finish()?;
        let r = self.resident.as_mut().ok_or_else(|| GpuError::Fault("no world is on the card".into()))?;
        r.hold(world, |spec| borrowed.is_borrowed(&spec.name))?;
        r.download(&self.gpu, world, |spec| borrowed.is_read(&spec.name))?;
        work(world)?;
        for l in (0..r.world_layers).filter(|&l| borrowed.is_written(&r.specs[l].name)) {
            let field = &world.layer(&r.specs[l].name)?.field;
            r.arena.upload(&self.gpu, r.slots[&(l, r.current[l])], field)?;
            r.stale[l] = false;
        }
        r.share(&self.gpu);
        Ok(())
    }

    /// Finds values that are not finite without moving layers.
    fn check_finite(&mut self, world: &mut World) -> Result<()> {
        let Some(r) = &self.resident else { return Ok(()) };
        let changed: Vec<usize> = (0..r.world_layers).filter(|&l| r.stale[l]).collect();
        for l in changed {
            let r = self.resident.as_ref().ok_or_else(|| GpuError::Fault("no world is on the card".into()))?;
            let slot = r.slots[&(l, r.current[l])];
            if self.gpu.complete(self.reducer.range(&self.gpu, &r.arena, slot))?.not_finite > 0 {
                // Names the place.
                return self.download(world);
            }
        }
        Ok(())
    }

    /// Brings the world to the card, with room for copies of layers that were needed before.
    pub(crate) fn make_resident(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        copies: &[(String, usize)],
    ) -> Result<()> {
        let resident = Resident::new(self, world, processes, span, copies)?;
        self.resident = Some(resident);
        // Another world's dispatches may take far longer.
        self.pace.most = 1;
        Ok(())
    }

    /// Downloads the world and brings it to the card anew, with room for what lies ahead. In the middle of a step the world as it was when it
    /// was last downloaded is kept to fall back to.
    pub(crate) fn rebuild(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        within_step: bool,
    ) -> Result<()> {
        self.finish()?;
        let mut kept = None;
        if let Some(r) = self.resident.as_mut().filter(|_| within_step) {
            r.hold(world, |_| true)?;
            r.download(&self.gpu, world, |_| true)?;
            kept = r.held.take().map(|held| (r.synced, held));
        } else {
            self.download(world)?;
        }
        let copies = self.resident.as_ref().map(Resident::copies).unwrap_or_default();
        self.release();
        let outcome = self.make_resident(world, processes, span, &copies);
        match (kept, self.resident.as_mut()) {
            (Some((synced, held)), Some(r)) => (r.synced, r.held) = (synced, Some(held)),
            // Nothing is on the card that could fall back.
            (Some((synced, held)), None) => {
                held.put_back(world);
                (world.step, world.sea_level_m) = synced;
            }
            (None, _) => {}
        }
        outcome
    }

    /// Adds a plan of whole steps, or a part of one step, to the batch, which goes to the card as often as the pace asks for.
    pub(crate) fn submit(&mut self, plan: &Plan, steps: u64) -> Result<(), Misfit> {
        let Some(mut r) = self.resident.take() else {
            return Err(GpuError::Fault("no world is on the card".into()).into());
        };
        let outcome = self.submit_to(&mut r, plan);
        self.resident = Some(r);
        outcome?;
        self.batch.steps += steps;
        Ok(())
    }

    fn submit_to(&mut self, r: &mut Resident, plan: &Plan) -> Result<(), Misfit> {
        let passes = plan.passes();
        let layers = Layers { specs: &r.specs, world_layers: r.world_layers };
        let groups = groups(passes, &layers, self.bounds(&r.arena.grid)).ok_or(Misfit::Rebuild)?;
        r.check_room(&groups, passes)?;
        let mut first = 0;
        for group in &groups {
            let of_group = &passes[first..first + group.stages.len()];
            first += group.stages.len();
            let waiting = self.batch.dispatches.len();
            if waiting >= self.pace.most || waiting + r.arena.slabs.len() > MOST_DISPATCHES {
                self.flush(r)?;
            }
            let kernel = self.kernel(r, group, of_group)?;
            r.dispatch(group, of_group, &kernel, &mut self.batch);
            self.work.bytes += (kernel.bytes_per_cell * r.arena.grid.cells()) as u64;
            for &(layer, elsewhere) in &group.outputs {
                if elsewhere {
                    r.current[layer] = 1 - r.current[layer];
                }
                if layer < r.world_layers {
                    r.stale[layer] = true;
                }
            }
        }
        Ok(())
    }

    /// Sends what is left of the batch and waits until the card has nothing to do.
    pub(crate) fn finish(&mut self) -> Result<()> {
        if let Some(r) = self.resident.take() {
            let outcome = self.flush(&r);
            self.resident = Some(r);
            outcome?;
        }
        self.pace.wait(&self.gpu, 0, self.options.submission)
    }

    fn bounds(&self, grid: &Grid) -> Bounds {
        let passes = match self.options.most_passes {
            0 if grid.cells() <= SMALL => 8,
            0 => 4,
            n => n,
        };
        Bounds { shared: SHARED, passes }
    }

    /// Submits the batch, and waits until one submission less than may be is under way.
    fn flush(&mut self, r: &Resident) -> Result<()> {
        let passes = if r.arena.split() { self.batch.dispatches.len() / r.arena.slabs.len() } else { 1 };
        if self.timer.as_ref().is_some_and(|t| t.used as usize + passes > MOST_TIMED as usize) {
            self.read_timer()?;
        }
        let Batch { jobs, dispatches, steps } = &mut self.batch;
        if dispatches.is_empty() {
            self.pace.done += std::mem::take(steps);
            return Ok(());
        }
        self.gpu.queue.write_buffer(&self.job, 0, bytemuck::cast_slice(jobs));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut next = 0;
        while next < dispatches.len() {
            // Between slabs rows must be shared, which cannot be done inside a pass.
            let end = if r.arena.split() {
                next + 1
                    + dispatches[next..].iter().position(|d| d.last_of_group).unwrap_or(dispatches.len() - next - 1)
            } else {
                dispatches.len()
            };
            let timestamp_writes = self.timer.as_ref().and_then(Timer::writes);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            for d in &dispatches[next..end] {
                pass.set_pipeline(&d.kernel.pipeline);
                pass.set_bind_group(0, &r.arena.slabs[d.slab].bind, &[d.job]);
                pass.dispatch_workgroups(d.tiles[0], d.tiles[1], 1);
            }
            drop(pass);
            if let Some(timer) = &mut self.timer {
                timer.used = (timer.used + 1).min(MOST_TIMED);
            }
            r.arena.share(&mut encoder);
            next = end;
        }
        self.work.submissions += 1;
        self.work.dispatches += dispatches.len() as u64;
        let index = self.gpu.queue.submit([encoder.finish()]);
        self.pace.begun(index, dispatches.len(), std::mem::take(steps));
        jobs.clear();
        dispatches.clear();
        self.gpu.check()?;
        self.pace.wait(&self.gpu, IN_FLIGHT - 1, self.options.submission)
    }

    fn read_timer(&mut self) -> Result<()> {
        if let Some(timer) = &mut self.timer {
            self.work.card_s += self.gpu.complete(timer.seconds(&self.gpu))?;
        }
        Ok(())
    }

    /// The pipeline of a group, compiled when it is first needed.
    fn kernel(&mut self, r: &mut Resident, group: &Group, passes: &[Pass]) -> Result<Arc<Kernel>> {
        if let Some(kernel) = r.kernels.get(group) {
            return Ok(Arc::clone(kernel));
        }
        let graphs: Vec<Arc<Graph>> = passes
            .iter()
            .map(|p| Arc::clone(r.graphs.entry(p.kind()).or_insert_with(|| Arc::new(p.graph()))))
            .collect();
        let graphs: Vec<&Graph> = graphs.iter().map(|g| &**g).collect();
        let setting = Setting { specs: &r.specs, rim: r.arena.grid.rim, split: r.arena.split() };
        let source = shader::wgsl(group, &graphs, setting);
        let pipeline = match self.pipelines.get(&source) {
            Some(p) => p.clone(),
            None => {
                let p = self.compile(passes[0].name(), &source)?;
                self.pipelines.insert(source, p.clone());
                p
            }
        };
        let outer = group.outer_faces(&r.specs, r.arena.grid.rim);
        let kernel = Arc::new(Kernel { pipeline, outer, bytes_per_cell: group.bytes_per_cell() });
        r.kernels.insert(group.clone(), Arc::clone(&kernel));
        Ok(kernel)
    }

    fn compile(&mut self, name: &str, source: &str) -> Result<wgpu::ComputePipeline> {
        let (pipeline, error) = self.gpu.scoped(wgpu::ErrorFilter::Validation, || {
            let module = self.gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
            self.gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&self.pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                // A workgroup writes its memory before it reads it.
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: self.cache.as_ref(),
            })
        });
        self.work.pipelines += 1;
        match error {
            Some(e) => Err(GpuError::Fault(format!("rule `{name}`: {e}"))),
            None => self.gpu.check().map(|()| pipeline),
        }
    }
}

impl Resident {
    fn new(
        engine: &GpuEngine,
        world: &World,
        processes: &[Scheduled],
        span: Span,
        copies: &[(String, usize)],
    ) -> Result<Self> {
        let mut specs: Vec<LayerSpec> = world.layers().iter().map(|l| l.spec.clone()).collect();
        let world_layers = specs.len();
        // Which layers are looked at from other cells, and which are written, over enough steps to see every schedule.
        let mut moment = Moment { grid: world.grid, step: world.step, turn: 0, sea_level_m: world.sea_level_m };
        let (end, block) = (span.from + span.steps.clamp(1, 64), engine.block(&world.grid));
        let (mut plans, mut at) = (Vec::new(), span.from);
        while at < end {
            let mut plan = Plan::default();
            let next = block_end(processes, at, block).min(end);
            for step in at..next {
                plan_step(processes, step, &mut moment, &mut plan);
            }
            at = next;
            for spec in plan.scratch_layers() {
                if !specs.iter().any(|s| s.name == spec.name) {
                    specs.push(spec.clone());
                }
            }
            plans.push(plan);
        }
        let layers = Layers { specs: &specs, world_layers };
        let bounds = engine.bounds(&world.grid);
        let missing = || GpuError::Fault("a rule names a layer that its process does not".into());
        let mut all = Vec::new();
        for plan in &plans {
            all.extend(groups(plan.passes(), &layers, bounds).ok_or_else(missing)?);
        }
        let passes: Vec<&Pass> = plans.iter().flat_map(Plan::passes).collect();
        let mut slots = HashMap::new();
        let mut add = |key| {
            let n = slots.len();
            slots.entry(key).or_insert(n);
        };
        (0..world_layers).for_each(|l| add((l, 0)));
        for (layer, spec) in specs.iter().enumerate() {
            let written = passes.iter().any(|p| p.writes().contains(&&*spec.name));
            let read = passes.iter().any(|p| p.reads().iter().any(|r| r.layer == spec.name));
            // A span may end anywhere and cut a block; small grids have room for any copy that is then needed.
            let stored = layer < world_layers
                || world.grid.cells() <= SMALL
                || all.iter().any(|g| g.outputs.iter().any(|(l, _)| *l == layer));
            if written && stored {
                add((layer, 0));
                if read {
                    add((layer, 1));
                }
            }
        }
        for (name, copy) in copies {
            if let Some(layer) = specs.iter().position(|s| s.name == *name) {
                add((layer, *copy));
            }
        }
        let mut accounts: Vec<Account> = Vec::new();
        for t in passes.iter().flat_map(|p| p.tallies()) {
            if !accounts.iter().any(|a| a.tally.account == t.account) {
                let before = world.ledger.amount(t.account);
                accounts.push(Account { tally: *t, before, written: before });
            }
        }
        let bytes = u128::from(Arena::slot_bytes(&world.grid)) * slots.len() as u128;
        engine.options.limits.check_bytes("the layers of this simulation on the graphics card", bytes)?;
        let arena = Arena::new(
            &engine.gpu,
            &engine.bind_layout,
            &engine.job,
            world.grid,
            slots.len(),
            accounts.len(),
            engine.options.most_bytes,
        )?;
        let mut stale = vec![false; specs.len()];
        for (l, layer) in world.layers().iter().enumerate() {
            let field = shut(&layer.spec, &world.grid, &layer.field);
            arena.upload(&engine.gpu, slots[&(l, 0)], &field)?;
            stale[l] = matches!(field, Cow::Owned(_));
        }
        let r = Self {
            arena,
            current: vec![0; specs.len()],
            stale,
            specs,
            world_layers,
            slots,
            accounts,
            seed: world.seed,
            kernels: HashMap::new(),
            graphs: HashMap::new(),
            synced: (world.step, world.sea_level_m),
            held: None,
        };
        r.share(&engine.gpu);
        Ok(r)
    }

    /// Copies the rows that slabs share.
    fn share(&self, gpu: &Gpu) {
        if self.arena.split() {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.arena.share(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
        }
    }

    /// Downloads everything that is out of date.
    fn download_all(&mut self, gpu: &Gpu, world: &mut World) -> Result<()> {
        self.download(gpu, world, |_| true)?;
        self.synced = (world.step, world.sea_level_m);
        self.held = None;
        Ok(())
    }

    /// Keeps what an action may change, ledger included, as it was when the world was last downloaded.
    fn hold(&mut self, world: &World, wanted: impl Fn(&LayerSpec) -> bool) -> Result<()> {
        let held = self.held.get_or_insert_with(|| Saved::new(world));
        let mut wanted = self.specs[..self.world_layers].iter().filter(|s| wanted(s));
        Ok(wanted.try_for_each(|s| held.keep(world, &s.name))?)
    }

    /// Downloads the layers that are out of date and `wanted`, and the ledger.
    fn download(&mut self, gpu: &Gpu, world: &mut World, wanted: impl Fn(&LayerSpec) -> bool) -> Result<()> {
        gpu.check()?;
        let mut fields: Vec<(usize, Field)> = Vec::new();
        for l in (0..self.world_layers).filter(|&l| self.stale[l] && wanted(&self.specs[l])) {
            fields.push((l, self.arena.request(gpu, self.slots[&(l, self.current[l])])?.take(gpu)?));
        }
        let totals = gpu.complete(self.arena.totals(gpu))?;
        // Nothing can fail from here on: the world changes as a whole.
        for (l, field) in fields {
            world.layer_mut(&self.specs[l].name)?.field = field;
            self.stale[l] = false;
        }
        let area = world.grid.cell_area_m2();
        self.accounts.iter_mut().zip(totals).for_each(|(account, total)| account.post(&mut world.ledger, total, area));
        Ok(())
    }

    /// Finds slots and accounts that the groups need and that are not there.
    fn check_room(&self, groups: &[Group], passes: &[Pass]) -> Result<(), Misfit> {
        let mut current = self.current.clone();
        for group in groups {
            let there = |l: usize, copy: usize| self.slots.contains_key(&(l, copy));
            let inputs = group.inputs.iter().all(|&l| there(l, current[l]));
            for &(l, elsewhere) in &group.outputs {
                if elsewhere {
                    current[l] = 1 - current[l];
                }
            }
            if !inputs || !group.outputs.iter().all(|&(l, _)| there(l, current[l])) {
                return Err(Misfit::Rebuild);
            }
        }
        let mut tallies = passes.iter().flat_map(|p| p.tallies());
        if tallies.any(|t| self.account(t).is_none()) {
            return Err(Misfit::Rebuild);
        }
        Ok(())
    }

    /// Number of the account of a tally.
    fn account(&self, tally: &Tally) -> Option<usize> {
        self.accounts.iter().position(|a| a.tally.account == tally.account)
    }

    /// The copies of layers that there is room for.
    fn copies(&self) -> Vec<(String, usize)> {
        self.slots.keys().map(|&(l, copy)| (self.specs[l].name.to_string(), copy)).collect()
    }

    /// Adds the dispatches of a group, one a slab.
    fn dispatch(&self, group: &Group, passes: &[Pass], kernel: &Arc<Kernel>, batch: &mut Batch) {
        let Batch { jobs, dispatches, .. } = batch;
        let (a, g) = (&self.arena, &self.arena.grid);
        for (n, slab) in a.slabs.iter().enumerate() {
            let outer = [kernel.outer[0], if n == 0 { kernel.outer[1] } else { 0 }];
            let (left, top) = (-(outer[0] as i32), slab.first as i32 - outer[1] as i32);
            let start = jobs.len();
            let end_row = slab.first + slab.rows;
            // In the order of `shader::job_fields`.
            let head = [g.width as i32, g.height as i32, left, top, a.first_row(slab), end_row as i32];
            jobs.extend(head.map(|v| v as u32));
            jobs.extend([a.stride, a.slots, slab.first_group, a.groups].map(|v| v as u32));
            jobs.extend(group.inputs.iter().map(|&l| self.slots[&(l, self.current[l])] as u32));
            jobs.extend(group.outputs.iter().map(|&(l, elsewhere)| {
                let copy = if elsewhere { 1 - self.current[l] } else { self.current[l] };
                self.slots[&(l, copy)] as u32
            }));
            for pass in passes {
                if self.graphs.get(&pass.kind()).is_some_and(|g| shader::is_random(g)) {
                    let key = pass.key(self.seed);
                    jobs.extend([key.low, key.high]);
                }
                jobs.extend(pass.params().iter().map(|p| p.to_bits()));
                jobs.extend(pass.tallies().iter().map(|t| self.account(t).unwrap_or_default() as u32));
            }
            jobs.resize(start + JOB_WORDS, 0);
            let tiles =
                [(g.width + outer[0]).div_ceil(TILE[0]) as u32, (slab.rows + outer[1]).div_ceil(TILE[1]) as u32];
            dispatches.push(Dispatch {
                kernel: Arc::clone(kernel),
                slab: n,
                job: 4 * start as u32,
                tiles,
                last_of_group: n + 1 == a.slabs.len(),
            });
        }
    }
}

impl Account {
    /// Makes the ledger's amount what there was before and the sum on the card. Written like this, and not as what the sum has grown
    /// by since the last time, it does not depend on how often somebody has looked.
    fn post(&mut self, ledger: &mut Ledger, total: f64, area: f64) {
        let t = &self.tally;
        let (scale, unit) = match t.unit {
            TallyUnit::Thickness => (area, "m3"),
            TallyUnit::Count => (1.0, "1"),
        };
        // Actions keep accounts, too.
        self.before += ledger.amount(t.account) - self.written;
        self.written = self.before + scale * total;
        ledger.set(t.account, self.written, unit, t.meaning, t.sign);
    }
}

/// The step after the last one of the block that begins at `at`: it ends at a multiple of `block` and before each step in which
/// some process acts.
pub(crate) fn block_end(processes: &[Scheduled], at: u64, block: u64) -> u64 {
    let end = at - at % block + block;
    (at + 1..end).find(|&step| acts(processes, step)).unwrap_or(end)
}

/// The layer as rules must find it: shut on the faces of closed rims.
fn shut<'a>(spec: &LayerSpec, grid: &Grid, field: &'a Field) -> Cow<'a, Field> {
    let (x, y) = (grid.rim.x == Edge::Closed, grid.rim.y == Edge::Closed);
    match spec.stagger {
        Stagger::FaceX if x => {
            let mut field = field.clone();
            field.rows_mut().for_each(|r| r[grid.width - 1] = 0.0);
            Cow::Owned(field)
        }
        Stagger::FaceY if y => {
            let mut field = field.clone();
            field.row_mut(grid.height - 1).fill(0.0);
            Cow::Owned(field)
        }
        _ => Cow::Borrowed(field),
    }
}

/// How many dispatches go into a submission, and which submissions are under way.
struct Pace {
    most: usize,
    /// Steps of the span that are done.
    done: u64,
    /// With their dispatches, and the steps that are complete with them.
    under_way: VecDeque<(wgpu::SubmissionIndex, usize, u64)>,
    last: Instant,
}

impl Default for Pace {
    fn default() -> Self {
        Self { most: 1, done: 0, under_way: VecDeque::new(), last: Instant::now() }
    }
}

impl Pace {
    fn begun(&mut self, submission: wgpu::SubmissionIndex, dispatches: usize, steps: u64) {
        if self.under_way.is_empty() {
            self.last = Instant::now();
        }
        self.under_way.push_back((submission, dispatches, steps));
    }

    /// Waits until no more than `keep` submissions are under way, which aim at `long`.
    fn wait(&mut self, gpu: &Gpu, keep: usize, long: Duration) -> Result<()> {
        while self.under_way.len() > keep {
            let Some((submission, dispatches, steps)) = self.under_way.pop_front() else { break };
            gpu.wait(Some(submission))?;
            let took = self.last.elapsed();
            self.last = Instant::now();
            let wanted = (dispatches as f64 * long.as_secs_f64() / took.as_secs_f64().max(1e-6)) as usize;
            // The end of a span says nothing about how many there could be.
            if dispatches >= self.most || wanted < self.most {
                self.most = wanted.clamp(1, (2 * self.most).min(MOST_DISPATCHES));
            }
            self.done += steps;
        }
        Ok(())
    }
}

/// Most passes that are timed between two readings: twice as many time stamps are what one set of queries may hold.
const MOST_TIMED: u32 = 2048;

impl Timer {
    fn new(gpu: &Gpu) -> Result<Self> {
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timer"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST_TIMED,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.buffer("timer", 16 * u64::from(MOST_TIMED), usage)?;
        Ok(Self { queries, resolved, used: 0 })
    }

    /// Where the next pass is to write its times, if there is room.
    fn writes(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (self.used < MOST_TIMED).then(|| wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * self.used),
            end_of_pass_write_index: Some(2 * self.used + 1),
        })
    }

    /// The card's time since the last reading, s.
    async fn seconds(&mut self, gpu: &Gpu) -> Result<f64> {
        if self.used == 0 {
            return Ok(0.0);
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.resolve_query_set(&self.queries, 0..2 * self.used, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read(&self.resolved, 0, 16 * u64::from(self.used))?.await?;
        self.used = 0;
        let ticks: Vec<[u64; 2]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let ticks: u64 = ticks.iter().map(|[begin, end]| end.saturating_sub(*begin)).sum();
        Ok(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
