//! How fast the card's memory is: the bound of most rules.

use crate::clock::Instant;
use crate::device::Gpu;
use crate::error::Result;

/// Bytes that a copy within the card's memory reads and writes in a second, measured for about a fifth of a second.
///
/// # Errors
/// If the device fails or has no memory left.
pub fn copy_bandwidth(gpu: &Gpu) -> Result<f64> {
    let limits = gpu.device.limits();
    let hardware = gpu.report.is_hardware();
    // More than caches hold; a software renderer would take long.
    let wanted = if hardware { 512 << 20 } else { 64 << 20 };
    let size = limits.max_buffer_size.min(wanted);
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let buffers = [gpu.buffer("bandwidth", size, usage)?, gpu.buffer("bandwidth", size, usage)?];
    let copies = |n: usize| -> Result<f64> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for i in 0..n {
            encoder.copy_buffer_to_buffer(&buffers[i % 2], 0, &buffers[(i + 1) % 2], 0, size);
        }
        let begun = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        gpu.wait(None)?;
        Ok(begun.elapsed().as_secs_f64())
    };
    // Touches the memory.
    let once = copies(2)? / 2.0;
    let n = ((0.2 / once.max(1e-6)) as usize).clamp(2, 2000);
    Ok(2.0 * size as f64 * n as f64 / copies(n)?)
}
