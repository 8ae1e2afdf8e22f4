//! A world that is made while it is read.

use super::stages::Stages;
use super::survey::{Survey, survey};
use eyot_core::{Cancel, Control, Error, Georeference, Grid, LayerSpec, Result};
use eyot_io::{About, Rows, Source};
use eyot_recipe::Recipe;
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// A recipe's world, any rows of whose layers can be asked for.
pub(crate) struct StreamedWorld<'a> {
    pub(super) grid: Grid,
    georeference: Option<Georeference>,
    layers: Vec<StreamedLayer>,
    stages: Mutex<Stages>,
    control: &'a Control<'a>,
    rows_done: AtomicU64,
    rows_in_all: u64,
}

pub(super) struct StreamedLayer {
    pub(super) spec: LayerSpec,
    /// The stage that leaves it in its last state.
    pub(super) stage: usize,
    /// Smallest and largest value, once the survey is done.
    range: Option<(f32, f32)>,
}

impl<'a> StreamedWorld<'a> {
    /// The world of a recipe without obstacles (see [`super::obstacle`]). The control hears how many rows have been made of
    /// all that the survey and the exports from `done_exports` on ask for.
    ///
    /// # Errors
    /// If a step does not work.
    pub(crate) fn new(recipe: &Recipe, done_exports: usize, cancel: &Cancel, control: &'a Control<'a>) -> Result<Self> {
        let mut stages = Stages::new(&recipe.steps, recipe.grid, recipe.sea_level_m)?;
        stages.cancel = cancel.clone();
        let layers: Vec<StreamedLayer> = stages
            .layers()
            .iter()
            .map(|(spec, stage)| StreamedLayer { spec: spec.clone(), stage: *stage, range: None })
            .collect();
        let exported = recipe.exports.iter().skip(done_exports).filter(|e| e.enabled).flat_map(|e| &e.layers);
        let passes = stages.below_tops().len()
            + layers.len()
            + exported
                .filter(|name| {
                    eyot_recipe::MATERIALS.contains(&name.as_str())
                        || eyot_recipe::GROUND.contains(&name.as_str())
                        || layers.iter().any(|l| l.spec.name == **name)
                })
                .count();
        Ok(Self {
            grid: recipe.grid,
            georeference: recipe.georeference.clone(),
            layers,
            stages: Mutex::new(stages),
            control,
            rows_done: AtomicU64::new(0),
            rows_in_all: (passes * recipe.grid.height) as u64,
        })
    }

    /// Rows that survey and exports ask for.
    pub(crate) fn rows_in_all(&self) -> u64 {
        self.rows_in_all
    }

    /// Goes once through all layers.
    ///
    /// # Errors
    /// As [`Rows::read`].
    pub(crate) fn survey(&mut self, recipe: &Recipe) -> Result<Survey> {
        let tops = self.stages()?.below_tops();
        for (stage, base) in tops {
            let top = super::survey::range(&mut self.rows(base))?.1;
            self.stages()?.set_top(stage, top);
        }
        let (survey, ranges) = survey(self, &self.layers, recipe)?;
        self.layers.iter_mut().zip(ranges).for_each(|(layer, range)| layer.range = Some(range));
        Ok(survey)
    }

    #[cfg(test)]
    pub(super) fn set_band(&mut self, rows: usize) {
        self.stages().unwrap().band = rows;
    }

    /// Rows of the layer as a stage leaves it.
    pub(super) fn rows(&self, stage: usize) -> LayerRows<'_> {
        LayerRows { world: self, stage }
    }

    fn stages(&self) -> Result<std::sync::MutexGuard<'_, Stages>> {
        // Only a panic while rows were made could have broken it; that panic has ended the run.
        self.stages.lock().map_err(|_| Error::Cancelled(std::time::Duration::ZERO))
    }
}

impl Source for StreamedWorld<'_> {
    fn layer<'b>(&'b self, name: &str) -> Option<(About, Box<dyn Rows + 'b>)> {
        let layer = self.layers.iter().find(|l| l.spec.name == name)?;
        let about = About {
            name: layer.spec.name.to_string(),
            unit: layer.spec.unit.to_string(),
            meaning: layer.spec.meaning.to_string(),
            cell_m: (self.grid.cell_x_m, self.grid.cell_y_m),
            georeference: self.georeference.clone(),
            tags: BTreeMap::new(),
            range: layer.range,
        };
        Some((about, Box::new(self.rows(layer.stage))))
    }
}

/// The rows of one layer.
pub(super) struct LayerRows<'a> {
    world: &'a StreamedWorld<'a>,
    stage: usize,
}

impl Rows for LayerRows<'_> {
    fn size(&self) -> (usize, usize) {
        (self.world.grid.width, self.world.grid.height)
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> Result<()> {
        let width = self.world.grid.width;
        let mut stages = self.world.stages()?;
        let band = stages.band;
        for (i, out) in out.chunks_mut(width * band).enumerate() {
            stages.read(self.stage, first + i * band, out)?;
            let rows = (out.len() / width) as u64;
            let done = self.world.rows_done.fetch_add(rows, Ordering::Relaxed) + rows;
            self.world.control.tick(done.min(self.world.rows_in_all), self.world.rows_in_all)?;
        }
        Ok(())
    }
}
