//! Smallest and largest value of a layer, found on the card: one workgroup a row, rows folded from north to south.

use crate::arena::Arena;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::reading::Reading;
use bytemuck::{Pod, Zeroable};
use std::pin::Pin;
use std::task::{Context, Poll};
use wgpu::util::DeviceExt;

/// What [`crate::GpuEngine::range`] gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest finite value; infinity if there is none.
    pub low: f32,
    /// Largest finite value; negative infinity if there is none.
    pub high: f32,
    /// Values that are infinite or not numbers.
    pub not_finite: u64,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Rows {
    /// Index of column 0 of the first row.
    first: u32,
    /// Distance of two rows.
    distance: u32,
    width: u32,
    count: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct RowRange {
    low: f32,
    high: f32,
    not_finite: u32,
    unused: u32,
}

const SOURCE: &str = "
struct Rows { first: u32, distance: u32, width: u32, count: u32 }
struct RowRange { low: f32, high: f32, not_finite: u32, unused: u32 }
@group(0) @binding(0) var<uniform> rows: Rows;
@group(0) @binding(1) var<storage, read> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> ranges: array<RowRange>;
var<workgroup> parts: array<RowRange, 256>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let row = group.y * groups.x + group.x;
    // Infinities, as bit patterns: shaders have no literals for them.
    var part = RowRange(bitcast<f32>(job_infinity(0u)), bitcast<f32>(job_infinity(0x80000000u)), 0u, 0u);
    if row < rows.count {
        for (var x = thread; x < rows.width; x += 256u) {
            let v = state[rows.first + row * rows.distance + x];
            if (bitcast<u32>(v) & 0x7f800000u) == 0x7f800000u {
                part.not_finite += 1u;
            } else {
                part.low = min(part.low, v);
                part.high = max(part.high, v);
            }
        }
    }
    parts[thread] = part;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            let other = parts[thread + half];
            parts[thread].low = min(parts[thread].low, other.low);
            parts[thread].high = max(parts[thread].high, other.high);
            parts[thread].not_finite += other.not_finite;
        }
    }
    if thread == 0u && row < rows.count {
        ranges[row] = parts[0];
    }
}

// The sign comes as an argument, so that no compiler folds it into a constant, which must be finite.
fn job_infinity(sign: u32) -> u32 {
    return sign | select(0x7f7fffffu, 0x7f800000u, rows.width > 0u);
}
";

/// The pipeline.
pub(crate) struct Reducer {
    pipeline: wgpu::ComputePipeline,
}

impl Reducer {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("range"),
            source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("range"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline }
    }

    /// Begins to find the range of a slot.
    pub(crate) fn request(&self, gpu: &Gpu, arena: &Arena, slot: usize) -> Result<Ranging> {
        let mut slabs = Vec::new();
        for slab in &arena.slabs {
            let place = |y: usize| (arena.offset(slab, slot, y as isize) / 4 + 1) as u32;
            let rows = Rows {
                first: place(slab.first),
                distance: (arena.slots * arena.stride) as u32,
                width: arena.grid.width as u32,
                count: slab.rows as u32,
            };
            let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("rows"),
                contents: bytemuck::bytes_of(&rows),
                usage: wgpu::BufferUsages::UNIFORM,
            });
            let size = (slab.rows * size_of::<RowRange>()) as u64;
            let ranges = gpu.buffer("ranges", size, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC)?;
            let entry = |binding, buffer: &wgpu::Buffer| (binding, buffer.clone());
            let buffers = [entry(0, &uniform), entry(1, &slab.state), entry(2, &ranges)];
            let entries: Vec<wgpu::BindGroupEntry<'_>> = buffers
                .iter()
                .map(|(binding, b)| wgpu::BindGroupEntry { binding: *binding, resource: b.as_entire_binding() })
                .collect();
            let bind = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("range"),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bind, &[]);
            // More rows than one dimension of a dispatch takes.
            let across = slab.rows.min(1 << 15);
            pass.dispatch_workgroups(across as u32, slab.rows.div_ceil(across) as u32, 1);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            slabs.push(gpu.read(&ranges, 0, size)?);
        }
        gpu.check().map(|()| Ranging(slabs)).map_err(|e| match e {
            GpuError::Fault(text) => GpuError::Fault(format!("range: {text}")),
            e => e,
        })
    }
}

/// A range on its way back from the card, slab by slab: a future that gives the same however often it is asked.
pub(crate) struct Ranging(Vec<Reading>);

impl Ranging {
    /// True once it has arrived. Does not wait.
    pub(crate) fn is_ready(&self) -> Result<bool> {
        self.0.iter().try_fold(true, |ready, slab| Ok(ready && slab.is_ready()?))
    }

    /// The range, which has arrived.
    fn range(&self) -> Result<Range> {
        let mut range = Range { low: f32::INFINITY, high: f32::NEG_INFINITY, not_finite: 0 };
        for slab in &self.0 {
            slab.with(|bytes| {
                for row in bytes.chunks_exact(size_of::<RowRange>()) {
                    let row: RowRange = bytemuck::pod_read_unaligned(row);
                    range.low = range.low.min(row.low);
                    range.high = range.high.max(row.high);
                    range.not_finite += u64::from(row.not_finite);
                }
            })?;
        }
        Ok(range)
    }
}

impl Future for &Ranging {
    type Output = Result<Range>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        for slab in &self.0 {
            match slab.poll_ready(context) {
                Poll::Ready(Ok(())) => {}
                Poll::Ready(Err(e)) => return Poll::Ready(Err(e)),
                Poll::Pending => return Poll::Pending,
            }
        }
        Poll::Ready(self.range())
    }
}
