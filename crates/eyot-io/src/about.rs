//! What the values of a raster are: name, unit, place.

use eyot_core::{Georeference, Layer, World};
use std::collections::BTreeMap;

/// What a file can say of its values beside the values themselves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Name of the layer.
    pub name: String,
    /// Unit in SI notation, `1` for a plain number.
    pub unit: String,
    /// One sentence of meaning.
    pub meaning: String,
    /// East-west and north-south size of a cell, m.
    pub cell_m: (f64, f64),
    /// Where the raster lies.
    pub georeference: Option<Georeference>,
    /// What else a file said of itself, by keyword: source, licence, date. Goes along from format to format.
    pub tags: BTreeMap<String, String>,
    /// Smallest and largest value, if they are known; bounds that are not reached do as well.
    pub range: Option<(f32, f32)>,
}

impl About {
    /// What a world says of one of its layers.
    pub fn of(world: &World, layer: &Layer) -> Self {
        Self {
            name: layer.spec.name.to_string(),
            unit: layer.spec.unit.to_string(),
            meaning: layer.spec.meaning.to_string(),
            cell_m: (world.grid.cell_x_m, world.grid.cell_y_m),
            georeference: world.georeference.clone(),
            tags: BTreeMap::new(),
            range: None,
        }
    }

    /// The map from (column, row) to coordinates: the georeference, or metres with the south-west corner at (0, 0).
    pub(crate) fn transform(&self, height: usize) -> [f64; 6] {
        match &self.georeference {
            Some(g) => g.transform,
            None => [0.0, self.cell_m.0, 0.0, height as f64 * self.cell_m.1, 0.0, -self.cell_m.1],
        }
    }
}
