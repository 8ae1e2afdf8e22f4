//! Adapters and what happens when they fail.

use crate::common;
use eyot_gpu::{Choice, Gpu, GpuError};

#[test]
fn a_device_reads_back_what_was_written() {
    let Some(gpu) = common::gpu() else { return };
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let buffer = gpu.buffer("test", 64, usage).unwrap();
    gpu.queue.write_buffer(&buffer, 16, &[1, 2, 3, 4]);
    assert_eq!(gpu.read(&buffer, 16, 4).unwrap(), [1, 2, 3, 4]);
}

#[test]
fn an_unknown_adapter_is_refused_with_those_that_there_are() {
    let Err(e) = Gpu::open(&Choice::Named("no such thing".into())) else { panic!("opened") };
    assert!(e.to_string().contains("no such thing") && e.to_string().contains("found:"), "{e}");
}

#[test]
fn more_memory_than_there_is_is_refused() {
    let Some(gpu) = common::gpu() else { return };
    let most = gpu.device.limits().max_buffer_size;
    let Err(e) = gpu.buffer("a test", most.saturating_add(4), wgpu::BufferUsages::STORAGE) else { panic!("made") };
    assert!(matches!(e, GpuError::Limits { .. }), "{e}");
    assert!(gpu.check().is_ok(), "the device is still of use");
}

#[test]
fn a_lost_device_says_so() {
    let Some(gpu) = common::gpu() else { return };
    gpu.device.destroy();
    let outcome = gpu.wait(None).and_then(|()| {
        let buffer = gpu.buffer("test", 64, wgpu::BufferUsages::COPY_SRC)?;
        gpu.read(&buffer, 0, 4)
    });
    assert!(outcome.is_err_and(|e| e.is_lost()));
}
