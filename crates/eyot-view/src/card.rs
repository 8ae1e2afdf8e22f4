//! Scenes that follow a simulation on its card: the layers never leave it.
//!
//! Compute passes read the engine's buffers and write what [`Maps::write_heights`] and [`Maps::write_colours`] would send. The processor
//! learns one thing, for it selects what is drawn: the lowest and highest height of each patch, 8 bytes for 32 x 32 quads.

use crate::detail::Bounds;
use crate::levels::PATCH;
use crate::maps::Maps;
use crate::shaders;
use crate::texture;
use bytemuck::{Pod, Zeroable};
use eyot_core::Error;
use eyot_gpu::{Gpu, GpuEngine, GpuError, LayerPart, LayerView, Reading, Result};
use eyot_render::{LayerColours, Stage, colour_bytes};
use std::pin::Pin;
use std::task::{Context, Poll};
use wgpu::BufferUsages;
use wgpu::util::DeviceExt;

/// Threads along a side of a workgroup, and of one that makes spans; as in the shader.
const GROUP: u32 = 16;
const SPANS: u32 = 64;
/// Colours of a table: more than bytes tell apart.
const TABLE: usize = 4096;

/// As `Job` in `card.wgsl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Job {
    cells: [u32; 4],
    world: [u32; 4],
    places: [u32; 4],
    strides: [u32; 4],
    scale: [f32; 4],
    colour: [f32; 4],
    patches: [u32; 4],
}

/// The compute pipelines.
pub(crate) struct CardMaker {
    cells: wgpu::ComputePipeline,
    colours: wgpu::ComputePipeline,
    spans: wgpu::ComputePipeline,
}

impl CardMaker {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("card"),
            source: wgpu::ShaderSource::Wgsl(shaders::CARD.into()),
        });
        let pipeline = |entry| {
            gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self { cells: pipeline("make_cells"), colours: pipeline("make_colours"), spans: pipeline("make_spans") }
    }
}

/// The colours of a layer as the shader looks them up.
pub(crate) struct CardColours {
    table: wgpu::Buffer,
    /// As `colour` of the job.
    scale: [f32; 4],
}

impl CardColours {
    pub(crate) fn new(gpu: &Gpu, colours: &LayerColours) -> Self {
        let table = colours.table(TABLE);
        let contents = colour_bytes(&table.colours, None);
        let table_buffer = gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("colours of a layer"),
            contents: bytemuck::cast_slice(&contents),
            usage: BufferUsages::STORAGE,
        });
        let kind = if table.log { 2.0 } else { f32::from(u8::from(table.middle.is_some())) };
        Self { table: table_buffer, scale: [table.from, table.middle.unwrap_or(table.from), table.to, kind] }
    }
}

/// Heights of patches on their way back from the card.
pub(crate) struct Spans(Reading);

impl Future for Spans {
    type Output = Result<Vec<[f32; 2]>>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let outcome = Pin::new(&mut self.0).poll(context);
        outcome.map_ok(|bytes| bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect())
    }
}

impl Spans {
    pub(crate) fn is_ready(&self) -> Result<bool> {
        self.0.is_ready()
    }
}

/// What a scene takes from a card.
pub(crate) struct Card<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) maker: &'a CardMaker,
    pub(crate) maps: &'a Maps,
    pub(crate) stage: &'a Stage,
    /// Cells of the world that became one of the scene, along a side.
    pub(crate) coarser: usize,
    pub(crate) height: LayerView<'a>,
    pub(crate) water: Option<LayerView<'a>>,
}

/// A layer of the engine that is as large as the scene's world.
///
/// # Errors
/// If it is not on the card, or of another size.
pub(crate) fn layer<'a>(engine: &'a GpuEngine, name: &str, stage: &Stage, coarser: usize) -> Result<LayerView<'a>> {
    let none = || Error::NoLayer { name: name.to_owned(), present: "those that are on the card".to_owned() };
    let view = engine.layer(name).ok_or_else(none)?;
    let cells = [view.width, view.height].map(|n| n.div_ceil(coarser));
    if cells != stage.cells() {
        let [width, height] = stage.cells();
        return Err(GpuError::Core(Error::Shape {
            what: format!("the layer `{name}` of a scene of {width}x{height} cells"),
            expected: width * height,
            found: cells[0] * cells[1],
        }));
    }
    Ok(view)
}

impl Card<'_> {
    /// Makes heights and water of cells, and begins to read the spans of patches.
    ///
    /// # Errors
    /// If there is no memory for the spans, or the device is lost.
    pub(crate) fn heights(&self) -> Result<Spans> {
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let (tops, fresh) = (texture::mip(&self.maps.cells_top, 0), texture::mip(&self.maps.cells_fresh, 0));
        for (i, part) in self.height.parts.iter().enumerate() {
            let water = self.water.as_ref().map(|w| w.parts[i]);
            let mut job = self.job(part);
            (job.places[0], job.strides[0]) = (part.offset as u32, part.row_stride as u32);
            if let Some(water) = water {
                (job.places[1], job.strides[1]) = (water.offset as u32, water.row_stride as u32);
            }
            // Without water its place is taken by something that nobody reads.
            let water = water.map_or(part.buffer, |w| w.buffer);
            let bindings = [
                (1, part.buffer.as_entire_binding()),
                (2, water.as_entire_binding()),
                (3, wgpu::BindingResource::TextureView(&tops)),
                (4, wgpu::BindingResource::TextureView(&fresh)),
            ];
            let groups = [job.cells[0].div_ceil(GROUP), job.places[3].div_ceil(GROUP)];
            self.dispatch(&mut pass, &self.maker.cells, &job, &bindings, groups);
        }
        let [columns, rows] = Bounds::patches(&self.maps.levels);
        let count = (columns * rows) as u32;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let spans = self.gpu.buffer("heights of patches", 8 * u64::from(count), usage)?;
        let bindings = [(8, wgpu::BindingResource::TextureView(&tops)), (9, spans.as_entire_binding())];
        let groups = count.div_ceil(SPANS);
        let across = groups.min(1 << 15);
        let job = self.job(&self.height.parts[0]);
        self.dispatch(&mut pass, &self.maker.spans, &job, &bindings, [across, groups.div_ceil(across)]);
        drop(pass);
        self.gpu.queue().submit([encoder.finish()]);
        self.gpu.read(&spans, 0, spans.size()).map(Spans)
    }

    /// Makes the colours of cells from the layer `worn`.
    ///
    /// # Errors
    /// If there is no memory for them, or the device is lost.
    pub(crate) fn colours(&self, worn: &LayerView<'_>, colours: &CardColours) -> Result<()> {
        let (width, height) = (self.maps.cells_ground.width(), self.maps.cells_ground.height());
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        // Textures on the sRGB curve cannot be written by a compute pass.
        let made = self.gpu.buffer("colours of cells", u64::from(row) * u64::from(height), usage)?;
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        for part in &worn.parts {
            let mut job = self.job(part);
            (job.places[2], job.strides[2], job.strides[3]) = (part.offset as u32, part.row_stride as u32, row / 4);
            job.colour = colours.scale;
            let bindings = [
                (5, part.buffer.as_entire_binding()),
                (6, colours.table.as_entire_binding()),
                (7, made.as_entire_binding()),
            ];
            let groups = [job.cells[0].div_ceil(GROUP), job.places[3].div_ceil(GROUP)];
            self.dispatch(&mut pass, &self.maker.colours, &job, &bindings, groups);
        }
        drop(pass);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo { buffer: &made, layout },
            self.maps.cells_ground.as_image_copy(),
            texture::extent([width, height]),
        );
        self.gpu.queue().submit([encoder.finish()]);
        self.gpu.check()
    }

    /// The job of a part, but for where the layers lie.
    fn job(&self, part: &LayerPart<'_>) -> Job {
        let [width, height] = self.stage.cells().map(|n| n as u32);
        // Squares belong to the part that holds their first row; the rest of their rows is shared with it.
        let rows = [part.first_row, part.first_row + part.rows].map(|y| y.div_ceil(self.coarser) as u32);
        let (_, factor) = self.stage.nodes();
        let [columns, patch_rows] = Bounds::patches(&self.maps.levels);
        let (river_from, river_to) = self.stage.river_depths();
        Job {
            cells: [width, height, self.coarser as u32, u32::from(self.water.is_some())],
            world: [self.height.width as u32, self.height.height as u32, part.first_row as u32, rows[0]],
            places: [0, 0, 0, rows[1] - rows[0]],
            strides: [0; 4],
            scale: [self.stage.datum(), self.stage.exaggeration, river_from, river_to],
            colour: [0.0; 4],
            patches: [columns as u32, patch_rows as u32, PATCH, factor as u32],
        }
    }

    fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        pipeline: &wgpu::ComputePipeline,
        job: &Job,
        bindings: &[(u32, wgpu::BindingResource<'_>)],
        groups: [u32; 2],
    ) {
        let job = self.gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("job of cells"),
            contents: bytemuck::bytes_of(job),
            usage: BufferUsages::UNIFORM,
        });
        let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: job.as_entire_binding() }];
        entries.extend(
            bindings.iter().map(|(binding, r)| wgpu::BindGroupEntry { binding: *binding, resource: r.clone() }),
        );
        let bind = self.gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }
}
