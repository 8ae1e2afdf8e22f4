//! Compiled pipelines that outlive the process. The bytes are the driver's; whoever starts the program keeps them in a file.

// Reason for the exception: bytes from a file go to the driver.
#![allow(unsafe_code)]

use crate::device::Gpu;

/// Opens a pipeline cache, filled with `data` if the driver takes it. `None` if the driver has none.
pub(crate) fn open(gpu: &Gpu, data: Option<&[u8]>) -> Option<wgpu::PipelineCache> {
    if !gpu.device.features().contains(wgpu::Features::PIPELINE_CACHE) {
        return None;
    }
    let descriptor = wgpu::PipelineCacheDescriptor { label: Some("eyot"), data, fallback: true };
    // SAFETY: the data came from `PipelineCache::get_data`; wgpu checks its header against this driver and falls back to an empty
    // cache.
    Some(unsafe { gpu.device.create_pipeline_cache(&descriptor) })
}
