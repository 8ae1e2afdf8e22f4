//! The pipelines that draw, and pictures.

use crate::card::CardMaker;
use crate::detail::Look;
use crate::frame::Parts;
use crate::levels::PATCH;
use crate::maps::{MapMaker, Maps};
use crate::scene::Scene;
use crate::shaders;
use crate::shot::Shot;
use crate::texture::Kind;
use eyot_gpu::{Gpu, GpuError, Result};
use eyot_render::{Camera, Picture};
use std::collections::HashMap;
use std::sync::OnceLock;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Samples a pixel: what every device offers.
const SAMPLES: u32 = 4;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Of pictures that are read back.
const PICTURE: TextureFormat = TextureFormat::Rgba8Unorm;

/// Draws scenes on one device.
pub struct Renderer {
    maker: MapMaker,
    /// Made when a scene first follows a simulation.
    card: OnceLock<CardMaker>,
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    sampler: wgpu::Sampler,
    quads: wgpu::Buffer,
    pipelines: HashMap<(TextureFormat, u32), Pipelines>,
    canvas: Option<Targets>,
}

/// The pipelines for one format of targets.
struct Pipelines {
    terrain: wgpu::RenderPipeline,
    walls: wgpu::RenderPipeline,
    sea: wgpu::RenderPipeline,
    backdrop: wgpu::RenderPipeline,
}

/// Colours with several samples, and depths, for pictures of one size.
struct Targets {
    size: [u32; 2],
    format: TextureFormat,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
}

/// What a picture is drawn on: a texture's view of any format that can be drawn to, with one sample.
#[non_exhaustive]
pub struct Canvas<'a> {
    /// The view.
    pub view: &'a wgpu::TextureView,
    /// Its format. Formats that put colours on the sRGB curve get linear ones.
    pub format: TextureFormat,
    /// Columns and rows.
    pub size: [u32; 2],
}

impl<'a> Canvas<'a> {
    /// A view of that format and size (columns, rows).
    pub fn new(view: &'a wgpu::TextureView, format: TextureFormat, size: [u32; 2]) -> Self {
        Self { view, format, size }
    }
}

impl Renderer {
    /// Compiles what does not depend on the target.
    ///
    /// # Errors
    /// If the device is lost or the driver refuses a shader.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let device = gpu.device();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("picture"),
            source: wgpu::ShaderSource::Wgsl(shaders::picture().into()),
        });
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: both, ty, count: None };
        let texture = |binding, filterable| {
            let ty = wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            };
            entry(binding, ty)
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("picture"),
            entries: &[
                entry(0, uniform),
                texture(1, false),
                texture(2, true),
                texture(3, true),
                texture(4, true),
                texture(5, true),
                entry(6, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("maps"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let quads = quads();
        let usage = BufferUsages::INDEX | BufferUsages::COPY_DST;
        let buffer = gpu.buffer("quads of a patch", size_of_val(&quads[..]) as u64, usage)?;
        gpu.queue().write_buffer(&buffer, 0, bytemuck::cast_slice(&quads));
        let maker = MapMaker::new(gpu);
        gpu.check()?;
        Ok(Self {
            maker,
            card: OnceLock::new(),
            module,
            layout,
            sampler,
            quads: buffer,
            pipelines: HashMap::new(),
            canvas: None,
        })
    }

    pub(crate) fn maker(&self) -> &MapMaker {
        &self.maker
    }

    pub(crate) fn card(&self, gpu: &Gpu) -> &CardMaker {
        self.card.get_or_init(|| CardMaker::new(gpu))
    }

    pub(crate) fn bind(&self, gpu: &Gpu, frame: &wgpu::Buffer, maps: &Maps) -> wgpu::BindGroup {
        let views = Scene::views(maps);
        let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }];
        entries.extend(views.iter().enumerate().map(|(i, v)| wgpu::BindGroupEntry {
            binding: i as u32 + 1,
            resource: wgpu::BindingResource::TextureView(v),
        }));
        entries.push(wgpu::BindGroupEntry { binding: 6, resource: wgpu::BindingResource::Sampler(&self.sampler) });
        gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.layout,
            entries: &entries,
        })
    }

    /// Makes room for pictures of `size` (columns, rows), so that what is too large is refused before anything is begun.
    ///
    /// # Errors
    /// [`GpuError::Picture`] if a side is 0 or larger than the device draws, [`GpuError::OutOfMemory`] if it has no room.
    pub fn reserve(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<()> {
        self.canvas = Some(Targets::new(gpu, size, PICTURE)?);
        Ok(())
    }

    fn check_size(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<()> {
        let limit = gpu.device().limits().max_texture_dimension_2d;
        if width == 0 || height == 0 || width.max(height) > limit {
            return Err(GpuError::Picture { adapter: gpu.name().to_owned(), width, height, limit });
        }
        Ok(())
    }

    /// A picture of `size` (columns, rows), `time_s` seconds after the waves began to move.
    ///
    /// # Errors
    /// If the picture is larger than the device draws, its memory is full, or it is lost.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        camera: &Camera,
        size: [u32; 2],
        time_s: f32,
    ) -> Result<Shot<Picture>> {
        Self::check_size(gpu, size)?;
        let format = PICTURE;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = Kind::new("picture", size, format, usage).make(gpu)?;
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.paint(gpu, scene, camera, time_s, &Canvas { view: &view, format, size })?;
        let [width, height] = size.map(|n| n as usize);
        Shot::new(gpu, &target, 4, move |bytes| {
            let pixels = bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
            Picture { width, height, pixels }
        })
    }

    /// Distances of what the middles of pixels show from the camera along its view, m, row by row; infinite for sky and backdrop.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn distances(&mut self, gpu: &Gpu, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Result<Shot<Vec<f32>>> {
        Self::check_size(gpu, size)?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let format = PICTURE;
        let depth = Kind::new("distances", size, DEPTH, usage).make(gpu)?;
        let colour = Kind::new("picture", size, format, usage).make(gpu)?;
        let view = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        let targets = Targets { size, format, colour: view(&colour), depth: view(&depth) };
        self.pipelines(gpu, format, 1)?;
        self.pass(gpu, scene, camera, 0.0, &targets, None, 1)?;
        let near = 1e-4 * scene.stage().extent;
        Shot::new(gpu, &depth, 4, move |bytes| {
            bytes.chunks_exact(4).map(|b| near / f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
        })
    }

    /// Draws onto `canvas`.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn paint(&mut self, gpu: &Gpu, scene: &Scene, camera: &Camera, time_s: f32, canvas: &Canvas<'_>) -> Result<()> {
        let (size, format) = (canvas.size, canvas.format);
        self.pipelines(gpu, format, SAMPLES)?;
        let targets = match self.canvas.take().filter(|t| t.size == size && t.format == format) {
            Some(t) => t,
            None => Targets::new(gpu, size, format)?,
        };
        let done = self.pass(gpu, scene, camera, time_s, &targets, Some(canvas.view), SAMPLES);
        self.canvas = Some(targets);
        done
    }

    /// One pass over all that the camera sees.
    fn pass(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        camera: &Camera,
        time_s: f32,
        targets: &Targets,
        resolved: Option<&wgpu::TextureView>,
        samples: u32,
    ) -> Result<()> {
        let (stage, size) = (scene.stage(), targets.size);
        let span = scene.span();
        let extent = stage.size_m();
        let look = Look {
            levels: &scene.maps.levels,
            bounds: &scene.bounds,
            step: [0, 1].map(|k| extent[k] / (scene.maps.levels.nodes[k] - 1) as f32),
            camera,
            size,
            hidden_below: if stage.sea { 0.0 } else { f32::NEG_INFINITY },
            base: stage.block.then_some(span.0),
        };
        let detail = look.select();
        let parts = Parts {
            stage,
            maps: &scene.maps,
            detail: &detail,
            camera,
            size,
            time_s,
            srgb: targets.format.is_srgb(),
            painted: scene.is_painted(),
            span,
            flows: scene.flows,
        };
        gpu.queue().write_buffer(&scene.frame, 0, bytemuck::bytes_of(&parts.frame()));
        let places: Vec<[u32; 4]> = detail.patches.iter().chain(&detail.walls).copied().collect();
        let bytes: &[u8] = bytemuck::cast_slice(&places);
        let usage = BufferUsages::VERTEX | BufferUsages::COPY_DST;
        let instances = gpu.buffer("patches", (bytes.len() as u64).max(16), usage)?;
        gpu.queue().write_buffer(&instances, 0, bytes);

        let Some(pipelines) = self.pipelines.get(&(targets.format, samples)) else {
            return Err(GpuError::Fault("the pipelines of a picture are missing".to_owned()));
        };
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &targets.colour,
                depth_slice: None,
                resolve_target: resolved,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: if resolved.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                // Near things are 1, the horizon is 0.
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let (patches, all) = (detail.patches.len() as u32, places.len() as u32);
        pass.set_bind_group(0, &scene.bind, &[]);
        pass.set_vertex_buffer(0, instances.slice(..));
        pass.set_index_buffer(self.quads.slice(..), wgpu::IndexFormat::Uint16);
        pass.set_pipeline(&pipelines.terrain);
        pass.draw_indexed(0..6 * PATCH * PATCH, 0, 0..patches);
        if all > patches {
            pass.set_pipeline(&pipelines.walls);
            pass.draw(0..2 * (PATCH + 1), patches..all);
        }
        if stage.sea {
            pass.set_pipeline(&pipelines.sea);
            pass.draw(0..if stage.block { 6 } else { 12 }, 0..1);
        }
        pass.set_pipeline(&pipelines.backdrop);
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.queue().submit([encoder.finish()]);
        gpu.check()
    }

    /// Compiles the pipelines for a format and a number of samples, once.
    fn pipelines(&mut self, gpu: &Gpu, format: TextureFormat, samples: u32) -> Result<()> {
        if self.pipelines.contains_key(&(format, samples)) {
            return Ok(());
        }
        let layout = gpu.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let patch = wgpu::VertexBufferLayout {
            array_stride: 16,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &[wgpu::VertexAttribute {
                format: wgpu::VertexFormat::Uint32x4,
                offset: 0,
                shader_location: 0,
            }],
        };
        let make = |name: &str, buffers: &[Option<wgpu::VertexBufferLayout<'_>>], topology, depth| {
            gpu.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some(&format!("{name}_vertex")),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(depth),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
                fragment: Some(wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some(&format!("{name}_fragment")),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let (list, strip) = (wgpu::PrimitiveTopology::TriangleList, wgpu::PrimitiveTopology::TriangleStrip);
        let (nearer, nearest) = (wgpu::CompareFunction::Greater, wgpu::CompareFunction::GreaterEqual);
        let made = Pipelines {
            terrain: make("terrain", &[Some(patch.clone())], list, nearer),
            walls: make("wall", &[Some(patch)], strip, nearer),
            // At the horizon the depth is that of an empty picture.
            sea: make("sea", &[], list, nearest),
            backdrop: make("backdrop", &[], list, nearest),
        };
        gpu.check()?;
        self.pipelines.insert((format, samples), made);
        Ok(())
    }
}

impl Targets {
    fn new(gpu: &Gpu, size: [u32; 2], format: TextureFormat) -> Result<Self> {
        Renderer::check_size(gpu, size)?;
        let make = |what, format| {
            let kind = Kind { samples: SAMPLES, ..Kind::new(what, size, format, TextureUsages::RENDER_ATTACHMENT) };
            kind.make(gpu).map(|t| t.create_view(&wgpu::TextureViewDescriptor::default()))
        };
        Ok(Self {
            size,
            format,
            colour: make("colours of a picture", format)?,
            depth: make("depths of a picture", DEPTH)?,
        })
    }
}

/// Two triangles for every quad of a patch.
fn quads() -> Vec<u16> {
    let side = PATCH as u16 + 1;
    let quad = |i: u16| {
        let a = i / PATCH as u16 * side + i % PATCH as u16;
        [a, a + 1, a + side, a + side, a + 1, a + side + 1]
    };
    (0..(PATCH * PATCH) as u16).flat_map(quad).collect()
}
