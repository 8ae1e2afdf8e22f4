//! Pictures of a film from above: reliefs, for worlds that no camera on the ground sees.

use crate::artist::{ViewRequest, stopped};
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Control, Grid, Limits, World};
use eyot_export::pictures::relief_options;
use eyot_export::{Subject, estimate};
use eyot_render::{Picture, ReliefOptions, relief_controlled};
use eyot_session::{EngineChoice, RunError};

/// A world from above, whose last state scales all pictures.
pub(super) struct Map {
    options: ReliefOptions,
    /// What was drawn last.
    drawn: Option<Picture>,
    /// Things to know.
    pub(super) notes: Vec<Remedy>,
}

impl Map {
    /// Makes ready for pictures of `world` and, if it `moves`, its earlier states.
    ///
    /// # Errors
    /// If the world has no height, or there is not enough memory.
    pub(super) fn of(world: &World, moves: bool, request: &ViewRequest, limits: &Limits) -> Result<Self, RunError> {
        let view = &request.view;
        let size = best_fit(&world.grid, view.size);
        let longer = size[0].max(size[1]);
        let bytes = estimate::picture(&world.grid, view, Subject::ReliefAt(longer));
        estimate::check("this picture", world, bytes, limits, estimate::picture_remedy()).map_err(stopped)?;
        let options = ReliefOptions { even: true, ..relief_options(view, Some(longer)) };
        let mut notes = Vec::new();
        if size != view.size {
            notes.push(format!("the pictures have the shape of the map: {} x {} pixels", size[0], size[1]).into());
        }
        if request.engine.choice == EngineChoice::Gpu {
            notes.push("reliefs from above are drawn by the processor".into());
        }
        if !moves {
            notes.push(remedy![
                "a map of the finished world stands still; ",
                Setting::Run,
                " and ",
                Setting::Recording,
                " show how it came to be",
            ]);
        }
        Ok(Self { options: options.scaled_to(world).map_err(stopped)?, drawn: None, notes })
    }

    /// Draws a state of the world.
    ///
    /// # Errors
    /// If it has no height, and on a request to stop.
    pub(super) fn draw(&mut self, world: &World, control: &Control<'_>) -> Result<(), RunError> {
        self.drawn = Some(relief_controlled(world, &self.options, control).map_err(stopped)?);
        Ok(())
    }

    /// The picture that was drawn last, or that of `world` if there is none.
    ///
    /// # Errors
    /// As [`Map::draw`].
    pub(super) fn picture(&mut self, world: &World, control: &Control<'_>) -> Result<&Picture, RunError> {
        if self.drawn.is_none() {
            self.draw(world, control)?;
        }
        self.drawn.as_ref().ok_or(RunError::Stopped)
    }
}

/// The largest even sides, in pixels, of a picture of the whole map within `size`.
fn best_fit(grid: &Grid, size: [u32; 2]) -> [u32; 2] {
    let across = grid.width as f64 * grid.cell_x_m;
    let down = grid.height as f64 * grid.cell_y_m;
    let pairs = size.map(|n| f64::from((n / 2).max(1)));
    let scale = (pairs[0] / across).min(pairs[1] / down);
    [across, down].map(|m| 2 * ((m * scale).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::Rim;

    #[test]
    fn the_whole_map_fits_in_even_sides() {
        let fit = |cells: [usize; 2], size| {
            best_fit(&Grid::new(cells[0], cells[1], 20.0, Rim::CLOSED, &Limits::default()).unwrap(), size)
        };
        assert_eq!(fit([512, 256], [1280, 800]), [1280, 640]);
        assert_eq!(fit([512, 256], [1281, 500]), [1000, 500]);
        assert_eq!(fit([100, 300], [640, 640]), [214, 640]);
        assert_eq!(fit([300, 100], [301, 301]), [300, 100]);
    }
}
