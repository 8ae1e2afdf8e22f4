//! A graphics card that draws.

use crate::artist::ViewRequest;
use eyot_core::engine::{DeviceError, EngineError};
use eyot_core::{Limits, World};
use eyot_export::pictures::{map_of, view_options};
use eyot_export::{Subject, estimate};
use eyot_gpu::{Choice, Gpu, blocking};
use eyot_render::{Camera, Picture, Stage};
use eyot_session::EngineChoice;
use eyot_view::{Renderer, Scene};

/// A world on a card.
pub(crate) struct Card {
    gpu: Box<Gpu>,
    renderer: Box<Renderer>,
    scene: Box<Scene>,
}

impl Card {
    pub(crate) fn open(world: &World, s: &ViewRequest, limits: &Limits) -> Result<Self, EngineError> {
        let hardware = s.engine.choice == EngineChoice::Auto;
        let gpu = blocking::open(&Choice::of(s.engine.adapter.as_deref(), hardware))?;
        // Cells and nodes take less than for rays; a pixel has four samples of colour and depth, and is read back.
        let pixels = s.view.size.iter().map(|n| u128::from(*n)).product::<u128>();
        let bytes = estimate::picture(&world.grid, &s.view, Subject::View) + 47 * pixels;
        estimate::check("this picture", world, bytes, limits, estimate::picture_remedy())?;
        let mut renderer = Renderer::new(&gpu)?;
        renderer.reserve(&gpu, s.view.size)?;
        let options = view_options(&s.view);
        let scene = match &s.drape {
            Some(layer) => Scene::of_layer(&gpu, &renderer, world, layer, &options, &map_of(world, layer, None))?,
            None => Scene::from_world(&gpu, &renderer, world, &options)?,
        };
        Ok(Self { gpu: Box::new(gpu), renderer: Box::new(renderer), scene: Box::new(scene) })
    }

    pub(crate) fn name(&self) -> String {
        format!("gpu ({})", self.gpu.name())
    }

    pub(crate) fn stage(&self) -> &Stage {
        self.scene.stage()
    }

    pub(crate) fn follow(&mut self, world: &World) -> Result<(), DeviceError> {
        let layers: Vec<&str> = world.layers().iter().map(|l| &*l.spec.name).collect();
        Ok(self.scene.update(&self.gpu, &self.renderer, world, &layers)?)
    }

    pub(crate) fn draw(&mut self, camera: &Camera, size: [u32; 2], time_s: f32) -> Result<Picture, DeviceError> {
        let Self { gpu, renderer, scene } = self;
        let picture = renderer.draw(gpu, scene, camera, size, time_s).and_then(|shot| shot.take(gpu))?;
        Ok(scene.with_legend(picture))
    }
}
