//! The maps that pictures read, and the compute passes that make them from cells.

use crate::levels::{Levels, MAX_LEVELS};
use crate::shaders;
use crate::texture::{self, Kind};
use eyot_gpu::{Gpu, Result};
use eyot_render::{PENUMBRA_DEG, Stage};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Texels along the longer side of the light map, about.
const LIGHT: u32 = 1024;
/// Nodes along the longer side of the level that light is read from, at most.
const LIGHT_NODES: u32 = 1024;
/// Threads along a side of a workgroup; as in the shaders.
const GROUP: u32 = 16;
/// Distance of two blocks of uniforms, bytes: what every device allows.
const ALIGN: u64 = 256;

/// What the compute passes need to know of a scene; as `Job` in `maps.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Job {
    cells: [u32; 4],
    nodes: [u32; 4],
    light: [u32; 4],
    size: [f32; 4],
    sun: [f32; 4],
    levels: [[u32; 4]; MAX_LEVELS],
}

/// The compute pipelines.
pub(crate) struct MapMaker {
    heights: wgpu::ComputePipeline,
    level: wgpu::ComputePipeline,
    ground: wgpu::ComputePipeline,
    relief: wgpu::ComputePipeline,
    light: wgpu::ComputePipeline,
    mip: wgpu::ComputePipeline,
}

impl MapMaker {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let module = |name, text: &'static str| {
            gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            })
        };
        let (maps, mips) = (module("maps", shaders::MAPS), module("mips", shaders::MIPS));
        let pipeline = |module, entry| {
            gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            heights: pipeline(&maps, "make_heights"),
            level: pipeline(&maps, "make_level"),
            ground: pipeline(&maps, "make_ground"),
            relief: pipeline(&maps, "make_relief"),
            light: pipeline(&maps, "make_light"),
            mip: pipeline(&mips, "make_mip"),
        }
    }
}

/// The textures of a scene.
pub(crate) struct Maps {
    pub(crate) levels: Levels,
    /// Nodes a texel of the light map, and its size.
    pub(crate) light_stride: u32,
    pub(crate) light_size: [u32; 2],
    cells: [u32; 2],
    factor: u32,
    job: wgpu::Buffer,
    turns: wgpu::Buffer,
    pub(crate) cells_top: wgpu::Texture,
    pub(crate) cells_fresh: wgpu::Texture,
    pub(crate) cells_ground: wgpu::Texture,
    pub(crate) heights: wgpu::Texture,
    pub(crate) ground: wgpu::Texture,
    pub(crate) relief: wgpu::Texture,
    pub(crate) light: wgpu::Texture,
    pub(crate) flow: wgpu::Texture,
}

impl Maps {
    /// Textures for `stage`, still empty.
    ///
    /// # Errors
    /// If the device has not enough memory.
    pub(crate) fn new(gpu: &Gpu, stage: &Stage, has_flow: bool) -> Result<Self> {
        let cells = stage.cells().map(|n| n as u32);
        let (nodes, factor) = stage.nodes();
        let levels = Levels::new(nodes.map(|n| n as u32));
        let longer = levels.nodes[0].max(levels.nodes[1]);
        let light_stride = ((longer + LIGHT / 2) / LIGHT).max(1);
        let light_size = levels.nodes.map(|n| (n - 1).div_ceil(light_stride) + 1);
        let read = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let made = TextureUsages::TEXTURE_BINDING | TextureUsages::STORAGE_BINDING;
        // Written by the processor or, where the layers lie on the card, by a compute pass.
        let cell = read | TextureUsages::STORAGE_BINDING;
        let fresh = if stage.fresh().is_some() { cells } else { [1, 1] };
        let flow = if has_flow { cells } else { [1, 1] };
        let half = TextureFormat::Rgba16Float;
        let map = |what| {
            let mips = texture::mip_count(levels.nodes);
            Kind { mips, ..Kind::new(what, levels.nodes, half, made) }.make(gpu)
        };
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let turns = gpu.buffer("levels", ALIGN * MAX_LEVELS as u64, uniform)?;
        for level in 0..MAX_LEVELS as u32 {
            gpu.queue().write_buffer(&turns, ALIGN * u64::from(level), bytemuck::cast_slice(&[level, 0, 0, 0]));
        }
        Ok(Self {
            light_stride,
            light_size,
            cells,
            factor: factor as u32,
            job: gpu.buffer("job of maps", size_of::<Job>() as u64, uniform)?,
            turns,
            cells_top: Kind::new("heights of cells", cells, TextureFormat::R32Float, cell).make(gpu)?,
            cells_fresh: Kind::new("water of cells", fresh, TextureFormat::R32Float, cell).make(gpu)?,
            cells_ground: Kind::new("colours of cells", cells, TextureFormat::Rgba8UnormSrgb, read).make(gpu)?,
            heights: Kind::new("the surface", levels.texture, TextureFormat::R32Float, made).make(gpu)?,
            ground: map("colours")?,
            relief: map("slopes")?,
            light: Kind::new("light", light_size, half, made).make(gpu)?,
            flow: Kind::new("flow of water", flow, TextureFormat::Rgba8Snorm, read).make(gpu)?,
            levels,
        })
    }

    /// True if there is a place for all that `stage` has, and for a flow if it has one.
    pub(crate) fn hold(&self, stage: &Stage, has_flow: bool) -> bool {
        let whole = |t: &wgpu::Texture| [t.width(), t.height()] == self.cells;
        (stage.fresh().is_none() || whole(&self.cells_fresh)) && (!has_flow || whole(&self.flow))
    }

    /// New heights and water; their maps follow with [`Maps::remake`].
    pub(crate) fn write_heights(&self, gpu: &Gpu, stage: &Stage) {
        texture::write(gpu, &self.cells_top, bytemuck::cast_slice(stage.tops()));
        if let Some(fresh) = stage.fresh() {
            texture::write(gpu, &self.cells_fresh, bytemuck::cast_slice(fresh));
        }
    }

    /// New colours: sRGB bytes, with the cover of foam.
    pub(crate) fn write_colours(&self, gpu: &Gpu, colours: &[[u8; 4]]) {
        texture::write(gpu, &self.cells_ground, bytemuck::cast_slice(colours));
    }

    /// New velocities, which need no more work.
    pub(crate) fn write_flow(&self, gpu: &Gpu, flow: &[[i8; 4]]) {
        texture::write(gpu, &self.flow, bytemuck::cast_slice(flow));
    }

    /// Makes what hangs on heights, on colours, or on both. `top` is the highest height.
    pub(crate) fn remake(&self, gpu: &Gpu, maker: &MapMaker, stage: &Stage, top: f32, heights: bool, colours: bool) {
        gpu.queue().write_buffer(&self.job, 0, bytemuck::bytes_of(&self.job(stage, top)));
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        if heights {
            self.dispatch(gpu, &mut pass, &maker.heights, &[0, 2, 5], 0, self.levels.nodes);
            for (level, place) in self.levels.places.iter().enumerate().skip(1) {
                let size = [place[2] + 1, place[3] + 1];
                self.dispatch(gpu, &mut pass, &maker.level, &[0, 1, 5], level, size);
            }
            self.dispatch(gpu, &mut pass, &maker.relief, &[0, 3, 5, 7], 0, self.levels.nodes);
            self.dispatch(gpu, &mut pass, &maker.light, &[0, 5, 8], 0, self.light_size);
            mips(gpu, &mut pass, &maker.mip, &self.relief);
        }
        if colours {
            self.dispatch(gpu, &mut pass, &maker.ground, &[0, 4, 6], 0, self.levels.nodes);
            mips(gpu, &mut pass, &maker.mip, &self.ground);
        }
        drop(pass);
        gpu.queue().submit([encoder.finish()]);
    }

    fn job(&self, stage: &Stage, top: f32) -> Job {
        let [nx, ny] = self.levels.nodes;
        let level = (0..self.levels.top()).find(|l| nx.max(ny) >> l <= LIGHT_NODES).unwrap_or(self.levels.top());
        let step = stage.cell_m().map(|c| c / self.factor as f32);
        let (sin, cos) = stage.sun_azimuth_deg.to_radians().sin_cos();
        let tan = |e: f32| e.clamp(-89.0, 89.0).to_radians().tan();
        let floor = if stage.sea { 0.0 } else { f32::MIN };
        Job {
            cells: [self.cells[0], self.cells[1], self.factor, u32::from(stage.fresh().is_some())],
            nodes: [nx, ny, level as u32, self.light_stride],
            light: [self.light_size[0], self.light_size[1], 0, 0],
            size: [step[0], step[1], floor, top],
            sun: [
                sin / step[0],
                -cos / step[1],
                tan(stage.sun_elevation_deg - PENUMBRA_DEG),
                tan(stage.sun_elevation_deg + PENUMBRA_DEG),
            ],
            levels: self.levels.uniform(),
        }
    }

    /// Runs a pipeline over `size` texels with those of the bindings of `maps.wgsl` that it names.
    fn dispatch(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        pipeline: &wgpu::ComputePipeline,
        bindings: &[u32],
        level: usize,
        size: [u32; 2],
    ) {
        let view = |t: &wgpu::Texture| texture::mip(t, 0);
        let views = [
            view(&self.cells_top),
            view(&self.cells_fresh),
            view(&self.cells_ground),
            view(&self.heights),
            view(&self.ground),
            view(&self.relief),
            view(&self.light),
        ];
        let turn = wgpu::BufferBinding {
            buffer: &self.turns,
            offset: ALIGN * level as u64,
            size: std::num::NonZeroU64::new(16),
        };
        let entry = |&binding: &u32| {
            let resource = match binding {
                0 => self.job.as_entire_binding(),
                1 => wgpu::BindingResource::Buffer(turn.clone()),
                n => wgpu::BindingResource::TextureView(&views[n as usize - 2]),
            };
            wgpu::BindGroupEntry { binding, resource }
        };
        let entries: Vec<_> = bindings.iter().map(entry).collect();
        let bind = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind, &[]);
        pass.dispatch_workgroups(size[0].div_ceil(GROUP), size[1].div_ceil(GROUP), 1);
    }
}

/// Makes the smaller levels of a map.
fn mips(gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, texture: &wgpu::Texture) {
    for level in 1..texture.mip_level_count() {
        let bind = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&texture::mip(texture, level - 1)),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&texture::mip(texture, level)),
                },
            ],
        });
        let side = |n: u32| (n >> level).max(1).div_ceil(GROUP);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bind, &[]);
        pass.dispatch_workgroups(side(texture.width()), side(texture.height()), 1);
    }
}
