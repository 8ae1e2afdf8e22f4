//! The device as wgpu knows it: for hosts that own one, such as a window, and for crates that work on the same one.
//!
//! This is the only part of the crate whose signatures name wgpu's types, so it alone follows wgpu's versions; use the `wgpu` that
//! this crate re-exports.

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::THREADS;
use crate::group::{JOB_BYTES, SHARED_BYTES};
use crate::reading::Reading;
use std::sync::atomic::Ordering;

/// Fails with all that is too small for the engine and the drawing.
pub(crate) fn check_limits(adapter: &str, l: &wgpu::Limits) -> Result<()> {
    let needed = [
        ("threads of a workgroup", THREADS as u64, u64::from(l.max_compute_invocations_per_workgroup)),
        ("threads of a workgroup along x", THREADS as u64, u64::from(l.max_compute_workgroup_size_x)),
        ("bytes of a workgroup's memory", SHARED_BYTES as u64, u64::from(l.max_compute_workgroup_storage_size)),
        ("storage buffers of a shader", 2, u64::from(l.max_storage_buffers_per_shader_stage)),
        ("bytes of a uniform block", JOB_BYTES, l.max_uniform_buffer_binding_size),
        ("uniform buffers with an offset", 1, u64::from(l.max_dynamic_uniform_buffers_per_pipeline_layout)),
        ("storage textures of a shader", 4, u64::from(l.max_storage_textures_per_shader_stage)),
        ("textures of a shader", 5, u64::from(l.max_sampled_textures_per_shader_stage)),
    ];
    let missing: Vec<String> = needed
        .iter()
        .filter(|(_, least, has)| has < least)
        .map(|(what, least, has)| format!("{least} {what} (it has {has})"))
        .collect();
    if missing.is_empty() {
        Ok(())
    } else {
        Err(GpuError::Unfit { adapter: adapter.to_owned(), missing: missing.join(", ") })
    }
}

/// The part of a device that names wgpu's types.
impl Gpu {
    /// A device that somebody else owns, such as a window or a game. Nothing of it is changed: no handler is set, so uncaptured errors
    /// go where the host wants them, and a host that hears of a lost device may pass it on with [`Gpu::tell_lost`].
    ///
    /// The engine works faster with limits as large as the adapter's (WebGPU's defaults bound a layer buffer at 128 MiB; larger worlds
    /// are then cut into slabs). `TIMESTAMP_QUERY` lets it measure the card's own time, `PIPELINE_CACHE` keep compiled pipelines;
    /// it does without either.
    ///
    /// # Errors
    /// [`GpuError::Unfit`] with everything that is missing.
    pub fn from_parts(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self> {
        Self::on(device, queue)
    }

    /// From now on the device counts as lost.
    pub fn tell_lost(&self, reason: &str) {
        self.health.note_lost(reason);
    }

    /// Makes buffers and pipelines.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Takes work.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Makes a buffer; fails instead of aborting if there is no memory for it. Browsers say so at the next [`Gpu::check`].
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
        let (buffer, error) = self.scoped(wgpu::ErrorFilter::OutOfMemory, || {
            let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
            let buffer = self.device.create_buffer(&descriptor);
            self.exhaust_for_tests(size);
            buffer
        });
        if error.is_some() {
            return Err(self.out_of_memory(what, size));
        }
        self.check()?;
        Ok(buffer)
    }

    /// Makes a texture; fails instead of aborting if there is no memory for it.
    ///
    /// # Errors
    /// [`GpuError::Limits`] if a side is longer than the device allows, [`GpuError::OutOfMemory`].
    pub fn texture(&self, what: &str, descriptor: &wgpu::TextureDescriptor<'_>) -> Result<wgpu::Texture> {
        let limit = self.device.limits().max_texture_dimension_2d;
        let wgpu::Extent3d { width, height, .. } = descriptor.size;
        if width.max(height) > limit {
            return Err(GpuError::Limits {
                adapter: self.name().to_owned(),
                what: what.to_owned(),
                needed: format!("a texture of {width}x{height}"),
                limit: format!("{limit} a side"),
            });
        }
        let (texture, error) = self.scoped(wgpu::ErrorFilter::OutOfMemory, || self.device.create_texture(descriptor));
        if error.is_some() {
            let texel = u64::from(descriptor.format.block_copy_size(None).unwrap_or(4) * descriptor.sample_count);
            return Err(self.out_of_memory(what, u64::from(width) * u64::from(height) * texel));
        }
        Ok(texture)
    }

    /// Begins to read `size` bytes of a buffer from `offset` on, as they are after all work submitted before.
    ///
    /// # Errors
    /// If there is no memory for the copy.
    pub fn read(&self, buffer: &wgpu::Buffer, offset: u64, size: u64) -> Result<Reading> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let staging = self.buffer("read-back", size, usage)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, offset, &staging, 0, size);
        self.queue.submit([encoder.finish()]);
        Ok(self.read_mapped(staging))
    }

    /// Begins to read a buffer that can be mapped.
    pub fn read_mapped(&self, staging: wgpu::Buffer) -> Reading {
        self.traffic.bytes.fetch_add(staging.size(), Ordering::Relaxed);
        Reading::new(self, staging)
    }
}
