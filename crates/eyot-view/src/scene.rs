//! A world on the device, ready to be drawn.

use crate::detail::Bounds;
use crate::flow::flow;
use crate::frame::Frame;
use crate::maps::Maps;
use crate::renderer::Renderer;
use crate::shrink::shrunk;
use crate::texture;
use eyot_core::World;
use eyot_gpu::{Gpu, Result};
use eyot_render::{LayerColours, MapOptions, Picture, Stage, ViewOptions, colour_bytes};
use wgpu::BufferUsages;

/// A world's surface, colours and light on the device.
pub struct Scene {
    stage: Stage,
    paint: Option<Paint>,
    /// Cells of the world that became one of the scene, along a side.
    coarser: usize,
    pub(crate) flows: bool,
    pub(crate) maps: Maps,
    pub(crate) bounds: Bounds,
    pub(crate) frame: wgpu::Buffer,
    pub(crate) bind: wgpu::BindGroup,
}

/// The layer that the ground wears.
struct Paint {
    layer: String,
    colours: LayerColours,
}

impl Scene {
    /// A scene of `world` in its natural colours. Size, camera and samples of the options do not matter here.
    ///
    /// # Errors
    /// If the world has no height, or the device not enough memory.
    pub fn from_world(gpu: &Gpu, renderer: &Renderer, world: &World, options: &ViewOptions) -> Result<Self> {
        Self::new(gpu, renderer, world, options, None)
    }

    /// A relief model of `world` that wears the colours of a layer, without sea and rivers, which would hide them.
    ///
    /// # Errors
    /// As [`Scene::from_world`], and if there is no such layer.
    pub fn of_layer(
        gpu: &Gpu,
        renderer: &Renderer,
        world: &World,
        layer: &str,
        options: &ViewOptions,
        colours: &MapOptions,
    ) -> Result<Self> {
        Self::new(gpu, renderer, world, &options.draped(), Some((layer, colours)))
    }

    fn new(
        gpu: &Gpu,
        renderer: &Renderer,
        world: &World,
        options: &ViewOptions,
        wears: Option<(&str, &MapOptions)>,
    ) -> Result<Self> {
        let coarser = coarser(gpu, world);
        let world = shrunk(world, coarser, wears.map(|w| w.0))?;
        let stage = Stage::new(&world, options)?;
        let paint = match wears {
            Some((layer, o)) => Some(Paint { layer: layer.to_owned(), colours: LayerColours::new(&world, layer, o)? }),
            None => None,
        };
        let flow = stage.fresh().and_then(|_| flow(&world));
        let maps = Maps::new(gpu, &stage, flow.is_some())?;
        let bounds = bounds(&maps, &stage);
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let frame = gpu.buffer("frame", size_of::<Frame>() as u64, uniform)?;
        let bind = renderer.bind(gpu, &frame, &maps);
        let mut scene = Self { stage, paint, coarser, flows: flow.is_some(), maps, bounds, frame, bind };
        scene.send(gpu, renderer, &world, [true, true]);
        if let Some(flow) = flow {
            scene.maps.write_flow(gpu, &flow);
        }
        gpu.check()?;
        Ok(scene)
    }

    /// What the scene shares with pictures of the CPU: cameras, sizes, light.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// True if the ground wears the colours of a layer.
    pub fn is_painted(&self) -> bool {
        self.paint.is_some()
    }

    /// `picture` with the legend of the layer that the ground wears, or as it is.
    pub fn with_legend(&self, picture: Picture) -> Picture {
        self.paint.as_ref().map_or(picture.clone(), |p| p.colours.with_legend(&picture))
    }

    /// Takes over the named layers of `world`, a later state of the same world. Only what hangs on them is sent and made again, and
    /// the picture's scales stay, so that it does not jump.
    ///
    /// # Errors
    /// If the world is of another size, or the device is lost.
    pub fn update(&mut self, gpu: &Gpu, renderer: &Renderer, world: &World, layers: &[&str]) -> Result<()> {
        let world = shrunk(world, self.coarser, self.paint.as_ref().map(|p| &*p.layer))?;
        let changed = |names: &[&str]| names.iter().any(|n| layers.contains(n));
        let mut heights = changed(&["height", "water"]);
        if heights {
            self.stage.follow(&world)?;
            self.bounds = bounds(&self.maps, &self.stage);
        }
        let mut colours = match &mut self.paint {
            Some(p) if layers.contains(&&*p.layer) => {
                p.colours.follow(&world)?;
                true
            }
            Some(_) => false,
            None => heights || changed(&["wetness", "limestone", "growth", "aridity"]),
        };
        let moves = changed(&["height", "water", "flux_x", "flux_y"]);
        let flow = if moves { self.stage.fresh().and_then(|_| flow(&world)) } else { None };
        let flows = if moves { flow.is_some() } else { self.flows };
        if !self.maps.hold(&self.stage, flows) {
            // Water came, for which there was no place.
            self.maps = Maps::new(gpu, &self.stage, flows)?;
            self.bind = renderer.bind(gpu, &self.frame, &self.maps);
            (heights, colours) = (true, true);
        }
        self.flows = flows;
        self.send(gpu, renderer, &world, [heights, colours]);
        if let Some(flow) = flow {
            self.maps.write_flow(gpu, &flow);
        }
        gpu.check()
    }

    /// Sends heights and colours, as asked, and makes their maps again.
    fn send(&mut self, gpu: &Gpu, renderer: &Renderer, world: &World, [heights, colours]: [bool; 2]) {
        if heights {
            self.maps.write_heights(gpu, &self.stage);
        }
        if colours {
            let bytes = match &self.paint {
                Some(p) => colour_bytes(&p.colours.colours, None),
                None => colour_bytes(&self.stage.colours(world), self.stage.foam().as_deref()),
            };
            self.maps.write_colours(gpu, &bytes);
        }
        let top = self.bounds.whole()[1];
        self.maps.remake(gpu, renderer.maker(), &self.stage, top, heights, colours);
    }

    /// Base and top of the relief model, m.
    pub(crate) fn span(&self) -> (f32, f32) {
        let [low, top] = self.bounds.whole();
        self.stage.block_span(low, top)
    }

    /// All textures that a picture reads, in the order of their bindings.
    pub(crate) fn views(maps: &Maps) -> [wgpu::TextureView; 5] {
        let whole = |t: &wgpu::Texture| t.create_view(&wgpu::TextureViewDescriptor::default());
        [
            texture::mip(&maps.heights, 0),
            whole(&maps.ground),
            whole(&maps.relief),
            whole(&maps.light),
            whole(&maps.flow),
        ]
    }
}

fn bounds(maps: &Maps, stage: &Stage) -> Bounds {
    let (_, factor) = stage.nodes();
    Bounds::new(&maps.levels, stage.tops(), stage.cells(), factor)
}

/// How many cells along a side must become one so that the surface and its coarser levels fit in a texture.
fn coarser(gpu: &Gpu, world: &World) -> usize {
    let most = (gpu.device().limits().max_texture_dimension_2d as usize - 64) * 2 / 3;
    world.grid.width.max(world.grid.height).div_ceil(most)
}
