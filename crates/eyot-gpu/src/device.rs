//! An open device, whoever opened it: this crate, or a host whose guest the engine is (`guest.rs`).

use crate::adapter::{AdapterReport, Choice, sorted};
use crate::error::{GpuError, Result};
use crate::health::Health;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, Waker};
use wgpu::Features;

/// An open device.
pub struct Gpu {
    /// What it is and can do.
    pub report: AdapterReport,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) health: Arc<Health>,
    pub(crate) traffic: Traffic,
    short_from: AtomicU64,
}

/// What has come back from the card, and how often a thread has waited for it.
#[derive(Default)]
pub(crate) struct Traffic {
    pub(crate) layers: AtomicU64,
    pub(crate) bytes: AtomicU64,
    pub(crate) waits: AtomicU64,
}

impl Gpu {
    /// Opens a device on the chosen adapter, with all that the adapter allows.
    ///
    /// # Errors
    /// If there is no such adapter or its driver refuses.
    pub async fn open(choice: &Choice) -> Result<Self> {
        let all = sorted().await;
        let Some((adapter, report)) = all.iter().find(|(_, r)| choice.fits(r)) else {
            let names: Vec<String> = all.iter().map(|(_, r)| format!("`{}`", r.name)).collect();
            let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return Err(GpuError::NoAdapter { wanted: choice.wanted(), found });
        };
        let wanted = Features::TIMESTAMP_QUERY | Features::PIPELINE_CACHE | Features::FLOAT32_FILTERABLE;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("eyot"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let refused =
            |e: wgpu::RequestDeviceError| GpuError::Refused { adapter: report.name.clone(), reason: e.to_string() };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(refused)?;
        let gpu = Self::on(device, queue)?;
        gpu.health.listen(&gpu.device);
        Ok(gpu)
    }

    pub(crate) fn on(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self> {
        let report = AdapterReport::new(device.adapter_info(), &device.limits(), device.features());
        crate::guest::check_limits(&report.name, &device.limits())?;
        Ok(Self {
            report,
            device,
            queue,
            health: Arc::default(),
            traffic: Traffic::default(),
            short_from: AtomicU64::new(u64::MAX),
        })
    }

    /// Name of the adapter.
    pub fn name(&self) -> &str {
        &self.report.name
    }

    /// Fails if the device was lost or refused something since the last call.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Fault`].
    pub fn check(&self) -> Result<()> {
        self.health.check()
    }

    /// Lets futures of this device go on. A window's host, which submits a picture sixty times a second, need not call it; browsers do
    /// it themselves. Does not wait.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn poll(&self) -> Result<()> {
        // A failed poll means a lost device, which `check` reports.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.check()
    }

    /// Gives the device up, as if it had been unplugged.
    pub fn destroy(&self) {
        self.device.destroy();
    }

    /// What a future of this device gives, such as [`Pending`](crate::Pending) or [`Reading`](crate::Reading); waits for the card
    /// where a thread may wait.
    ///
    /// # Errors
    /// Those of the future, and [`GpuError::CannotWait`] in a browser if it is not ready.
    pub fn complete<T>(&self, future: impl Future<Output = Result<T>>) -> Result<T> {
        let mut future = pin!(future);
        loop {
            if let Poll::Ready(outcome) = future.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
                return outcome;
            }
            self.wait(None)?;
        }
    }

    /// Browsers let no thread wait for the card.
    ///
    /// # Errors
    /// Always.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn wait(&self, _: Option<wgpu::SubmissionIndex>) -> Result<()> {
        self.check().and(Err(GpuError::CannotWait))
    }

    /// Makes something on the device; with it comes what went wrong, if the platform says so at once. In browsers, which say it later,
    /// the next [`Gpu::check`] tells.
    pub(crate) fn scoped<T>(&self, filter: wgpu::ErrorFilter, make: impl FnOnce() -> T) -> (T, Option<wgpu::Error>) {
        let scope = self.device.push_error_scope(filter);
        let made = make();
        let mut outcome = Box::pin(scope.pop());
        match outcome.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(error) => (made, error),
            Poll::Pending => {
                self.health.ask_later(outcome);
                (made, None)
            }
        }
    }

    /// Error of a buffer or texture for which there is no memory.
    pub(crate) fn out_of_memory(&self, what: &str, bytes: u64) -> GpuError {
        GpuError::OutOfMemory { adapter: self.name().to_owned(), what: what.to_owned(), mib: bytes.div_ceil(1 << 20) }
    }

    /// For tests: from now on the device runs out of memory whenever a buffer of so many bytes or more is made.
    #[doc(hidden)]
    pub fn run_short_of_memory(&self, from_bytes: u64) {
        self.short_from.store(from_bytes, Ordering::Relaxed);
    }

    /// Asks the driver for more memory than any device has, if it is to have no room for a buffer of `size` bytes.
    pub(crate) fn exhaust_for_tests(&self, size: u64) {
        if size < self.short_from.load(Ordering::Relaxed) {
            return;
        }
        let limits = self.device.limits();
        let side = limits.max_texture_dimension_2d;
        drop(self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("more than there is"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: limits.max_texture_array_layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        }));
    }
}
