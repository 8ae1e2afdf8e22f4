//! What the check of a recipe asks of the program around it.

use crate::keys::{Export, View};
use crate::recipe::Step;
use eyot_core::remedy::Remedy;
use eyot_core::{Georeference, Grid, Limits, Result};
use std::path::Path;

/// Why a file that a recipe names cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// One sentence: what is wrong.
    pub message: Remedy,
    /// What would be right.
    pub help: Remedy,
}

impl Refusal {
    /// A refusal with its remedy.
    pub fn new(message: impl Into<Remedy>, help: impl Into<Remedy>) -> Self {
        Self { message: message.into(), help: help.into() }
    }
}

/// What a grid takes over from a raster.
#[derive(Clone, Debug, PartialEq)]
pub struct RasterInfo {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Size of a cell, west-east and north-south, m; `None` if the file does not say.
    pub cell_m: Option<(f64, f64)>,
    /// Its place on Earth, if the file says it.
    pub georeference: Option<Georeference>,
}

/// Files that recipes name. Names are as the recipe gives them, relative to the recipe's `folder`.
pub trait Resolver: Send + Sync {
    /// The text of a file.
    ///
    /// # Errors
    /// If there is no such text.
    fn text(&self, file: &str, folder: &Path) -> std::result::Result<String, Refusal>;

    /// The name under which a generator finds a raster, whatever the current folder is.
    ///
    /// # Errors
    /// If there is no such raster.
    fn locate(&self, file: &str, folder: &Path) -> std::result::Result<String, Refusal>;

    /// Size and place of a raster, by the name that [`Resolver::locate`] gave.
    ///
    /// # Errors
    /// If it is no raster, or too large for the limits.
    fn raster(&self, located: &str, limits: &Limits) -> std::result::Result<RasterInfo, Refusal>;
}

/// A world that is made while its files are written: what is held of it.
#[derive(Clone, Copy, Debug)]
pub struct Streamed {
    /// The overview in coarser cells, of which pictures are drawn.
    pub overview: Grid,
    /// Bytes of windows and overview.
    pub held: u128,
    /// Bytes of the writers.
    pub writers: u128,
}

/// Memory that outputs of a recipe take.
pub trait Estimator: Send + Sync {
    /// Bytes that the pictures of a run take while they are drawn, beside the world.
    fn pictures(&self, grid: &Grid, view: &View) -> u128;

    /// Bytes that an export takes while it is made, beside the world.
    fn export(&self, grid: &Grid, export: &Export, limits: &Limits) -> u128;

    /// Memory of a run that never holds the whole world, for recipes without [`crate::memory::obstacle`]; `None` if the
    /// program cannot do this.
    ///
    /// # Errors
    /// If a step is not what it seemed to be.
    fn streamed(&self, steps: &[Step], grid: &Grid) -> Result<Option<Streamed>>;
}

/// Knows no files: a recipe that names one is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl NoFiles {
    fn refuse<T>(file: &str) -> std::result::Result<T, Refusal> {
        Err(Refusal::new(format!("`{file}` cannot be read: this program reads no files"), "leave the file out"))
    }
}

impl Resolver for NoFiles {
    fn text(&self, file: &str, _: &Path) -> std::result::Result<String, Refusal> {
        Self::refuse(file)
    }

    fn locate(&self, file: &str, _: &Path) -> std::result::Result<String, Refusal> {
        Self::refuse(file)
    }

    fn raster(&self, located: &str, _: &Limits) -> std::result::Result<RasterInfo, Refusal> {
        Self::refuse(located)
    }
}

/// Takes outputs for free: the memory of a run is that of its steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoOutputs;

impl Estimator for NoOutputs {
    fn pictures(&self, _: &Grid, _: &View) -> u128 {
        0
    }

    fn export(&self, _: &Grid, _: &Export, _: &Limits) -> u128 {
        0
    }

    fn streamed(&self, _: &[Step], _: &Grid) -> Result<Option<Streamed>> {
        Ok(None)
    }
}
