//! The GPU engine: runs plans on the card, with the layers left there.
//!
//! A simulation makes the world **resident**: its layers are brought to the card once and stay there. Steps are planned on the
//! processor in **blocks** that begin at fixed steps, and cut into [groups](crate::group); hundreds of dispatches go to the card in
//! one submission. Two submissions are under way at a time, each short enough that desktops stay responsive and a request to stop
//! is met. How long they are depends on the card's speed, how groups are cut does not: rounding is the same in every run. What has
//! no rule (an [`Action`](eyot_core::process::Action)) runs on the processor, with only the layers moved that changed.
//!
//! The world's own layers are out of date until [`GpuEngine::download`].

mod account;
mod coming;
mod dispatch;
mod options;
mod pace;
mod resident;
mod timer;

use crate::arena::Pending;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::{Bounds, JOB_BYTES, SHARED_BYTES};
use crate::layer_view::LayerView;
use crate::reduce::Reducer;
use dispatch::Batch;
use eyot_core::control::Control;
use eyot_core::engine::Borrowed;
use eyot_core::process::{Scheduled, Span};
use eyot_core::stepper::Simulation;
use eyot_core::{Grid, World};
use pace::Pace;
use resident::Resident;
use std::collections::HashMap;
use std::sync::atomic::Ordering::Relaxed;
use timer::Timer;

pub(crate) use dispatch::Misfit;
pub use options::{Options, Work};
pub(crate) use resident::block_end;

/// Most dispatches of one submission.
const MAX_DISPATCHES: usize = 4096;
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
        let job = gpu.buffer("jobs", JOB_BYTES * MAX_DISPATCHES as u64, usage)?;
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
        Work { layers_back, bytes_back, waits: traffic.waits.load(Relaxed), ..self.work }
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
    /// and if the device fails: the world is then what it was when it was last downloaded. [`GpuError::CannotWait`] if the engine is
    /// [polled](Options::polled), which takes a [`Simulation`] that keeps its place.
    pub fn simulate(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        control: &Control<'_>,
    ) -> Result<()> {
        if self.options.polled {
            return Err(GpuError::CannotWait);
        }
        Simulation::new(processes).advance(self, world, span, control).map_err(GpuError::from)
    }

    /// Makes the layers and the ledger of `world` what they are on the card.
    ///
    /// # Errors
    /// If the device was lost; `world` is then what it was when it was last downloaded. [`GpuError::CannotWait`] if the engine is
    /// [polled](Options::polled) and not all has arrived: then nothing has changed.
    pub fn download(&mut self, world: &mut World) -> Result<()> {
        // What still waits in the batch has marked its layers as changed already.
        let finished = self.finish();
        let Some(r) = &mut self.resident else { return finished };
        match finished.and_then(|()| r.download_all(&self.gpu, world, self.options.polled)) {
            Err(e @ GpuError::CannotWait) => return Err(e),
            Err(e) => {
                self.fall_back(world);
                return Err(e);
            }
            Ok(()) => {}
        }
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
        let ranging = self.reducer.request(&self.gpu, &r.arena, r.slots[&(layer, r.current[layer])])?;
        (&ranging).await.map(Some)
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
        r.download(&self.gpu, world, self.options.polled, |spec| borrowed.is_read(&spec.name))?;
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
        let Some(r) = &mut self.resident else { return Ok(()) };
        if r.checks.is_empty() {
            for l in (0..r.world_layers).filter(|&l| r.stale[l]) {
                r.checks.push(self.reducer.request(&self.gpu, &r.arena, r.slots[&(l, r.current[l])])?);
            }
        }
        let mut not_finite = 0;
        for check in &r.checks {
            if self.options.polled && !check.is_ready()? {
                return Err(GpuError::CannotWait);
            }
            not_finite += self.gpu.complete(check)?.not_finite;
        }
        if not_finite > 0 {
            // Names the place.
            self.download(world)?;
        }
        if let Some(r) = &mut self.resident {
            r.checks.clear();
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
            r.download(&self.gpu, world, self.options.polled, |_| true)?;
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

    fn bounds(&self, grid: &Grid) -> Bounds {
        let passes = match self.options.most_passes {
            0 if grid.cells() <= SMALL => 8,
            0 => 4,
            n => n,
        };
        Bounds { shared: SHARED, passes }
    }

    fn read_timer(&mut self) -> Result<()> {
        if let Some(timer) = &mut self.timer {
            self.work.card_s += timer.seconds(&self.gpu, self.options.polled)?;
        }
        Ok(())
    }
}
