//! Who draws views of a world: the processor's rays, or a graphics card.

use crate::card::Card;
use eyot_core::engine::EngineError;
use eyot_core::remedy;
use eyot_core::remedy::Remedy;
use eyot_core::{Control, Limits, World};
use eyot_export::pictures::{check_picture_name, map_of, view_options};
use eyot_export::{ExportError, Subject, estimate};
use eyot_recipe::View;
use eyot_render::{self as render, Camera, LayerColours, Picture, Stage};
use eyot_session::{EngineChoice, EngineOptions, RunError};
use std::path::Path;

/// What is drawn.
#[derive(Clone, Debug, Default)]
pub struct ViewRequest {
    /// Camera, sun and size.
    pub view: View,
    /// The layer whose colours the land wears; its own colours if not given.
    pub drape: Option<String>,
    /// Who draws. `Auto` takes a graphics card only if it is hardware.
    pub engine: EngineOptions,
}

/// A world made ready to be drawn from any number of cameras.
pub(crate) struct ViewRenderer {
    backend: Backend,
    /// Things to know about the choice.
    pub(crate) notes: Vec<Remedy>,
}

enum Backend {
    Cpu { scene: Box<render::Scene>, worn: Option<LayerColours> },
    Card(Card),
}

impl ViewRenderer {
    /// Makes `world` ready.
    ///
    /// # Errors
    /// If there is no such layer or adapter, or not enough memory.
    pub(crate) fn new(
        world: &World,
        request: &ViewRequest,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Self, RunError> {
        if let Some(layer) = &request.drape {
            world.layer(layer).map_err(RunError::input)?;
        }
        let auto = request.engine.choice == EngineChoice::Auto;
        let mut notes = Vec::new();
        if request.engine.choice != EngineChoice::Cpu {
            match Card::open(world, request, limits) {
                Ok(card) => return Ok(Self { backend: Backend::Card(card), notes }),
                Err(EngineError::Core(e)) => return Err(stopped(e)),
                Err(EngineError::Device(e)) if auto => notes.push(remedy![e, "; the processor draws instead"]),
                Err(EngineError::Device(e)) => return Err(RunError::Device(e)),
                Err(e) => return Err(RunError::file(e.to_string())),
            }
        }
        Ok(Self { backend: Backend::cpu(world, request, limits, control)?, notes })
    }

    /// The engine at work, for people.
    pub(crate) fn name(&self) -> String {
        match &self.backend {
            Backend::Cpu { .. } => "cpu".to_owned(),
            Backend::Card(card) => card.name(),
        }
    }

    /// What all engines share.
    pub(crate) fn stage(&self) -> &Stage {
        match &self.backend {
            Backend::Cpu { scene, .. } => &scene.stage,
            Backend::Card(card) => card.stage(),
        }
    }

    /// Takes over a later state of the world; what scales the picture stays.
    ///
    /// # Errors
    /// If the world is of another size or has not the layer that the land wears, on a request to stop, or if the graphics card fails.
    pub(crate) fn follow(&mut self, world: &World, control: &Control<'_>) -> Result<(), RunError> {
        match &mut self.backend {
            Backend::Cpu { scene, worn } => {
                if let Some(w) = worn {
                    w.follow(world).map_err(stopped)?;
                }
                scene.follow(world, worn.as_ref(), control).map_err(stopped)
            }
            Backend::Card(card) => Ok(card.follow(world)?),
        }
    }

    /// A picture of `size` (columns, rows), with the legend below it if the land wears a layer. Waves stand still on the processor.
    ///
    /// # Errors
    /// On a request to stop, or if the graphics card fails.
    pub(crate) fn draw(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        time_s: f32,
        control: &Control<'_>,
    ) -> Result<Picture, RunError> {
        match &mut self.backend {
            Backend::Cpu { scene, worn } => {
                let picture = scene.picture(camera, size.map(|n| n as usize), control).map_err(stopped)?;
                Ok(worn.as_ref().map_or(picture.clone(), |w| w.with_legend(&picture)))
            }
            Backend::Card(card) => {
                control.check().map_err(stopped)?;
                Ok(card.draw(camera, size, time_s)?)
            }
        }
    }
}

impl Backend {
    fn cpu(world: &World, s: &ViewRequest, limits: &Limits, control: &Control<'_>) -> Result<Self, RunError> {
        let fail = |e: eyot_core::Error| stopped(e);
        let bytes = estimate::picture(&world.grid, &s.view, Subject::View);
        estimate::check("this picture", world, bytes, limits, estimate::picture_remedy()).map_err(fail)?;
        let options = view_options(&s.view);
        let worn = match &s.drape {
            Some(layer) => Some(LayerColours::new(world, layer, &map_of(world, layer, None)).map_err(fail)?),
            None => None,
        };
        let scene = match &worn {
            Some(colours) => render::Scene::wearing(world, colours, &options, control),
            None => render::Scene::new(world, &options, control),
        };
        Ok(Self::Cpu { scene: Box::new(scene.map_err(fail)?), worn })
    }
}

pub(crate) fn stopped(e: eyot_core::Error) -> RunError {
    ExportError::stopped(e).into()
}

/// A picture that was drawn.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The engine that drew it.
    pub engine: String,
    /// Things to know.
    pub notes: Vec<Remedy>,
}

/// Draws a view of a world into a PNG file.
///
/// # Errors
/// If `path` has another extension than `.png` or cannot be written, which is found out first, there is no such layer or
/// adapter, or the picture exceeds the limits.
pub fn draw_view(world: &World, request: &ViewRequest, path: &Path, limits: &Limits) -> Result<Drawn, RunError> {
    check_picture_name(path).map_err(RunError::from)?;
    let control = Control::none();
    let mut renderer = ViewRenderer::new(world, request, limits, &control)?;
    let camera = renderer.stage().camera(&view_options(&request.view));
    let picture = renderer.draw(&camera, request.view.size, 0.0, &control)?;
    eyot_io::write_rgb_png(path, picture.width, picture.height, &picture.pixels).map_err(RunError::file)?;
    Ok(Drawn { engine: renderer.name(), notes: renderer.notes })
}
