//! Adapters, devices of others, and what happens when they fail.

use crate::common;
use eyot_gpu::{Choice, Gpu, GpuError, blocking};
use std::task::{Context, Poll, Waker};

const COPIED: wgpu::BufferUsages = wgpu::BufferUsages::COPY_SRC.union(wgpu::BufferUsages::COPY_DST);

#[test]
fn a_device_reads_back_what_was_written() {
    let Some(gpu) = common::gpu() else { return };
    let buffer = gpu.buffer("test", 64, COPIED).unwrap();
    gpu.queue().write_buffer(&buffer, 16, &[1, 2, 3, 4]);
    let reading = gpu.read(&buffer, 16, 4).unwrap();
    assert_eq!(gpu.complete(reading).unwrap(), [1, 2, 3, 4]);
}

#[test]
fn a_reading_can_be_looked_at_until_it_is_there() {
    let Some(gpu) = common::gpu() else { return };
    let buffer = gpu.buffer("test", 64, COPIED).unwrap();
    gpu.queue().write_buffer(&buffer, 0, &[7; 64]);
    let mut reading = std::pin::pin!(gpu.read(&buffer, 0, 64).unwrap());
    let begun = std::time::Instant::now();
    while !reading.is_ready().unwrap() {
        assert!(begun.elapsed().as_secs() < 60, "nothing came back");
        std::thread::yield_now();
    }
    let outcome = reading.as_mut().poll(&mut Context::from_waker(Waker::noop()));
    assert!(matches!(outcome, Poll::Ready(Ok(bytes)) if bytes == [7; 64]));
}

/// A device that a window would own, with these limits.
fn hosts_device(limits: wgpu::Limits) -> Option<(wgpu::Device, wgpu::Queue)> {
    common::gpu()?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let opened = pollster::block_on(async {
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.unwrap();
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        adapter.request_device(&descriptor).await.unwrap()
    });
    Some(opened)
}

#[test]
fn a_guest_of_a_windows_device_works() {
    // What every browser gives.
    let Some((device, queue)) = hosts_device(wgpu::Limits::default()) else { return };
    let gpu = Gpu::from_parts(device.clone(), queue).unwrap();
    let buffer = gpu.buffer("test", 64, COPIED).unwrap();
    gpu.queue().write_buffer(&buffer, 0, &[1, 2, 3, 4]);
    assert_eq!(gpu.complete(gpu.read(&buffer, 0, 4).unwrap()).unwrap(), [1, 2, 3, 4]);
    // Its host hears of the loss and passes it on; otherwise it shows when nothing comes back.
    device.destroy();
    let e = gpu.read(&buffer, 0, 4).and_then(|r| gpu.complete(r)).unwrap_err();
    assert!(e.is_lost(), "{e}");
    gpu.tell_lost("the window was closed");
    assert!(matches!(gpu.check(), Err(GpuError::Lost(text)) if text.contains("window")));
}

#[test]
fn a_device_with_too_little_is_refused_with_all_that_is_missing() {
    let few = wgpu::Limits::downlevel_webgl2_defaults();
    let Some((device, queue)) = hosts_device(few) else { return };
    let Err(e) = Gpu::from_parts(device, queue) else { panic!("taken") };
    assert!(matches!(e, GpuError::Unfit { .. }), "{e}");
    for part in ["256 threads of a workgroup (it has 0)", "storage buffers", "storage textures", "memory"] {
        assert!(e.to_string().contains(part), "{e}");
    }
}

#[test]
fn an_unknown_adapter_is_refused_with_those_that_there_are() {
    let Err(e) = blocking::open(&Choice::Named("no such thing".into())) else { panic!("opened") };
    assert!(e.to_string().contains("no such thing") && e.to_string().contains("found:"), "{e}");
}

#[test]
fn more_memory_than_there_is_is_refused() {
    let Some(gpu) = common::gpu() else { return };
    let most = gpu.report.max_buffer;
    let Err(e) = gpu.buffer("a test", most.saturating_add(4), wgpu::BufferUsages::STORAGE) else { panic!("made") };
    assert!(matches!(e, GpuError::Limits { .. }), "{e}");
    assert!(gpu.check().is_ok(), "the device is still of use");
}

#[test]
fn a_lost_device_says_so() {
    let Some(gpu) = common::gpu() else { return };
    gpu.destroy();
    let outcome = gpu.drain().and_then(|()| {
        let buffer = gpu.buffer("test", 64, wgpu::BufferUsages::COPY_SRC)?;
        gpu.complete(gpu.read(&buffer, 0, 4)?)
    });
    assert!(outcome.is_err_and(|e| e.is_lost()));
}
