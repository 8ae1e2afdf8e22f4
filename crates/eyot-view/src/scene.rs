//! A world on the device, ready to be drawn.

use crate::card::{self, Card, CardColours, Spans};
use crate::detail::Bounds;
use crate::flow::flow;
use crate::frame::Frame;
use crate::maps::Maps;
use crate::renderer::Renderer;
use crate::shrink::shrunk;
use crate::texture;
use eyot_core::World;
use eyot_core::layer::known;
use eyot_gpu::{Gpu, GpuEngine, Result};
use eyot_render::{LayerColours, MapOptions, Picture, Stage, ViewOptions, colour_bytes};
use std::collections::VecDeque;
use wgpu::BufferUsages;

/// Heights of patches that may be on their way back at a time: more than pictures that a host has under way.
const MAX_SPANS: usize = 4;

/// A world's surface, colours and light on the device.
pub struct Scene {
    stage: Stage,
    paint: Option<Paint>,
    /// Cells of the world that became one of the scene, along a side.
    coarser: usize,
    pub(crate) flows: bool,
    pub(crate) maps: Maps,
    pub(crate) bounds: Bounds,
    /// On their way back from the card, the oldest first.
    spans: VecDeque<Spans>,
    pub(crate) frame: wgpu::Buffer,
    pub(crate) bind: wgpu::BindGroup,
}

/// The layer that the ground wears.
struct Paint {
    layer: String,
    colours: LayerColours,
    on_card: CardColours,
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
            Some((layer, o)) => {
                let colours = LayerColours::new(&world, layer, o)?;
                let on_card = CardColours::new(gpu, &colours);
                Some(Paint { layer: layer.to_owned(), colours, on_card })
            }
            None => None,
        };
        let flow = stage.fresh().and_then(|_| flow(&world));
        let maps = Maps::new(gpu, &stage, flow.is_some())?;
        let bounds = bounds(&maps, &stage);
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let frame = gpu.buffer("frame", size_of::<Frame>() as u64, uniform)?;
        let bind = renderer.bind(gpu, &frame, &maps);
        let mut scene =
            Self { stage, paint, coarser, flows: flow.is_some(), maps, bounds, spans: VecDeque::new(), frame, bind };
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
            self.spans.clear();
            self.bounds = bounds(&self.maps, &self.stage);
        }
        let mut colours = match &mut self.paint {
            Some(p) if layers.contains(&&*p.layer) => {
                p.colours.follow(&world)?;
                true
            }
            Some(_) => false,
            None => heights || changed(&eyot_render::cover::LAYERS),
        };
        let moves = changed(&["height", "water", "flux_x", "flux_y", "flux_se", "flux_sw"]);
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

    /// Takes over the state of a simulation whose world this is, from where it lies on the card: no layer is copied over the bus, and
    /// nothing waits. Heights, fresh water and the layer that the ground wears are followed. What the processor makes stays as it was at the last
    /// [`Scene::update`]: natural colours, foam, the flow of rivers, scales, and heights that [`Stage`] places cameras over. Water that
    /// comes to a world that had no layer of it needs an update, too.
    ///
    /// How far patches reach up and down comes back meanwhile; see [`Scene::settle`].
    ///
    /// # Errors
    /// If the engine holds no such layers, or a world of another size, or the device is lost.
    pub fn follow(&mut self, renderer: &Renderer, engine: &GpuEngine) -> Result<()> {
        let (gpu, coarser) = (engine.gpu(), self.coarser);
        let of = |name: &str| card::layer(engine, name, &self.stage, coarser);
        let water = self.stage.fresh().map(|_| of(&known::WATER.name)).transpose()?;
        let height = of(&known::HEIGHT.name)?;
        let worn = self.paint.as_ref().map(|p| of(&p.layer).map(|view| (view, &p.on_card))).transpose()?;
        let card =
            Card { gpu, maker: renderer.card(gpu), maps: &self.maps, stage: &self.stage, coarser, height, water };
        let spans = card.heights()?;
        if let Some((worn, colours)) = &worn {
            card.colours(worn, colours)?;
        }
        // Light looks for what stands between a place and the sun, however high that is.
        self.maps.remake(gpu, renderer.maker(), &self.stage, f32::MAX, true, worn.is_some());
        if self.spans.len() == MAX_SPANS {
            // The oldest ones are about to arrive.
            self.spans.pop_back();
        }
        self.spans.push_back(spans);
        gpu.check()
    }

    /// True once pictures show exactly what [`Scene::follow`] took over. Until then patches are selected by the heights before, which is as
    /// good while they differ little. Does not wait; to be called before each picture.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn settle(&mut self, gpu: &Gpu) -> Result<bool> {
        while let Some(spans) = self.spans.front() {
            if !spans.is_ready()? {
                return Ok(false);
            }
            let ready = self.spans.pop_front();
            self.adopt(gpu, ready)?;
        }
        Ok(true)
    }

    /// As [`Scene::settle`], but waits.
    ///
    /// # Errors
    /// If the device is lost, and in a browser, which does not wait, if there is something to wait for.
    pub fn settled(&mut self, gpu: &Gpu) -> Result<()> {
        let last = self.spans.pop_back();
        self.spans.clear();
        self.adopt(gpu, last)
    }

    fn adopt(&mut self, gpu: &Gpu, spans: Option<Spans>) -> Result<()> {
        if let Some(spans) = spans {
            self.bounds = Bounds::over(&self.maps.levels, gpu.complete(spans)?);
        }
        Ok(())
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
