//! Adapters and devices: which graphics hardware there is, and how it is opened.

use crate::error::{GpuError, Result};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{AdapterInfo, DeviceType, Features, Limits};

/// The interfaces to graphics hardware that are tried.
const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// What an adapter is and can do.
#[derive(Clone, Debug)]
pub struct AdapterReport {
    /// Name and kind.
    pub info: AdapterInfo,
    /// What it allows.
    pub limits: Limits,
    /// What it offers beyond WebGPU.
    pub features: Features,
}

impl AdapterReport {
    fn of(adapter: &wgpu::Adapter) -> Self {
        Self { info: adapter.get_info(), limits: adapter.limits(), features: adapter.features() }
    }

    /// True for hardware, false for a software renderer, which is right but slower than the CPU engine.
    pub fn is_hardware(&self) -> bool {
        rank(&self.info) < SOFTWARE
    }
}

const SOFTWARE: u8 = 4;

/// Order of preference: lower is better.
fn rank(info: &AdapterInfo) -> u8 {
    match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => SOFTWARE,
    }
}

/// All adapters, the best one first.
pub fn adapters() -> Vec<AdapterReport> {
    sorted().iter().map(AdapterReport::of).collect()
}

fn sorted() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: BACKENDS,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let mut adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    adapters.sort_by_key(|a| rank(&a.get_info()));
    adapters
}

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Choice {
    /// The best one, a software renderer if there is nothing else.
    #[default]
    Best,
    /// The best one that is hardware.
    Hardware,
    /// The first one whose name contains this, in any case.
    Named(String),
}

/// An open device.
pub struct Gpu {
    /// What it is and can do.
    pub report: AdapterReport,
    /// Makes buffers and pipelines.
    pub device: wgpu::Device,
    /// Takes work.
    pub queue: wgpu::Queue,
    lost: Arc<Mutex<Option<String>>>,
    fault: Arc<Mutex<Option<String>>>,
    short_from: AtomicU64,
}

impl Gpu {
    /// Opens a device on the chosen adapter, with all that the adapter allows.
    ///
    /// # Errors
    /// If there is no such adapter or its driver refuses.
    pub fn open(choice: &Choice) -> Result<Self> {
        let all = sorted();
        let fits = |a: &&wgpu::Adapter| match choice {
            Choice::Best => true,
            Choice::Hardware => AdapterReport::of(a).is_hardware(),
            Choice::Named(name) => a.get_info().name.to_lowercase().contains(&name.to_lowercase()),
        };
        let Some(adapter) = all.iter().find(fits) else {
            let wanted = match choice {
                Choice::Best => "that this program can use".to_owned(),
                Choice::Hardware => "that is hardware".to_owned(),
                Choice::Named(name) => format!("whose name contains `{name}`"),
            };
            let names: Vec<String> = all.iter().map(|a| format!("`{}`", a.get_info().name)).collect();
            let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return Err(GpuError::NoAdapter { wanted, found });
        };
        Self::on(adapter)
    }

    fn on(adapter: &wgpu::Adapter) -> Result<Self> {
        let report = AdapterReport::of(adapter);
        let wanted = Features::TIMESTAMP_QUERY | Features::PIPELINE_CACHE | Features::FLOAT32_FILTERABLE;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("eyot"),
            required_features: report.features & wanted,
            required_limits: report.limits.clone(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Refused { adapter: report.info.name.clone(), reason: e.to_string() })?;
        let (lost, fault) = (Arc::<Mutex<Option<String>>>::default(), Arc::<Mutex<Option<String>>>::default());
        let keep = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, text| note(&keep, &format!("{reason:?} {text}")));
        let keep = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| note(&keep, &e.to_string())));
        Ok(Self { report, device, queue, lost, fault, short_from: AtomicU64::new(u64::MAX) })
    }

    /// Name of the adapter.
    pub fn name(&self) -> &str {
        &self.report.info.name
    }

    /// Fails if the device was lost or refused something since the last call.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Fault`].
    pub fn check(&self) -> Result<()> {
        if let Some(text) = self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Err(GpuError::Lost(text));
        }
        match self.fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(text) => Err(GpuError::Fault(text)),
            None => Ok(()),
        }
    }

    /// Waits until a submission is done, or all of them.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
        let outcome = self.device.poll(wgpu::PollType::Wait { submission_index: submission, timeout: None });
        self.check()?;
        outcome.map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Makes a buffer; fails instead of aborting if there is no memory for it.
    ///
    /// # Errors
    /// [`GpuError::Limits`], [`GpuError::OutOfMemory`] or as [`Gpu::check`].
    pub fn buffer(&self, what: &str, size: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer> {
        let limit = self.device.limits().max_buffer_size;
        if size > limit {
            return Err(GpuError::Limits {
                adapter: self.name().to_owned(),
                what: what.to_owned(),
                needed: format!("{} MiB in one piece", size >> 20),
                limit: format!("{} MiB", limit >> 20),
            });
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage,
            mapped_at_creation: false,
        });
        if size >= self.short_from.load(Ordering::Relaxed) {
            self.exhaust();
        }
        if pollster::block_on(scope.pop()).is_some() {
            let (adapter, what) = (self.name().to_owned(), what.to_owned());
            return Err(GpuError::OutOfMemory { adapter, what, mib: size.div_ceil(1 << 20) });
        }
        self.check()?;
        Ok(buffer)
    }

    /// For tests: from now on the device runs out of memory whenever a buffer of so many bytes or more is made.
    #[doc(hidden)]
    pub fn run_short_of_memory(&self, from_bytes: u64) {
        self.short_from.store(from_bytes, Ordering::Relaxed);
    }

    /// Asks the driver for more memory than any device has.
    fn exhaust(&self) {
        let limits = self.device.limits();
        let side = limits.max_texture_dimension_2d;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("more than there is"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: limits.max_texture_array_layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        drop(texture);
    }

    /// Reads `size` bytes of a buffer from `offset` on; waits for all work submitted before.
    ///
    /// # Errors
    /// As [`Gpu::check`], and if there is no memory for the copy.
    pub fn read(&self, buffer: &wgpu::Buffer, offset: u64, size: u64) -> Result<Vec<u8>> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging = self.buffer("read-back", size, usage)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, offset, &staging, 0, size);
        self.queue.submit([encoder.finish()]);
        self.mapped(&staging)
    }

    /// The bytes of a buffer that can be mapped.
    pub(crate) fn mapped(&self, staging: &wgpu::Buffer) -> Result<Vec<u8>> {
        staging.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait(None)?;
        let bytes = staging.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?.to_vec();
        staging.unmap();
        Ok(bytes)
    }
}

fn note(place: &Mutex<Option<String>>, text: &str) {
    place.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| text.to_owned());
}
