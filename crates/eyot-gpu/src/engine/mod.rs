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
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::{Group, JOB_WORDS};
use crate::layer_view::LayerView;
use crate::reduce::Reducer;
use eyot_core::control::Control;
use eyot_core::engine::Saved;
use eyot_core::graph::Graph;
use eyot_core::plan::RuleKind;
use eyot_core::process::{Scheduled, Span, acts};
use eyot_core::rule::Tally;
use eyot_core::stepper::Simulation;
use eyot_core::{Grid, LayerSpec, World};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

mod options;
mod pace;
mod resident;
mod submit;
mod transfer;

pub use options::{Options, Work};
use pace::Pace;

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
}

/// The step after the last one of the block that begins at `at`: it ends at a multiple of `block` and before each step in which
/// some process acts.
pub(crate) fn block_end(processes: &[Scheduled], at: u64, block: u64) -> u64 {
    let end = at - at % block + block;
    (at + 1..end).find(|&step| acts(processes, step)).unwrap_or(end)
}
