//! Where the values of exports come from: a world in memory, or one that is made while it is written.

use crate::about::About;
use crate::rows::Rows;
use eyot_core::World;

/// Layers whose rows can be read one band after the other.
pub trait Source {
    /// What the layer is, and its rows; `None` if there is no such layer.
    fn layer<'a>(&'a self, name: &str) -> Option<(About, Box<dyn Rows + 'a>)>;
}

impl Source for World {
    fn layer<'a>(&'a self, name: &str) -> Option<(About, Box<dyn Rows + 'a>)> {
        let layer = World::layer(self, name).ok()?;
        let about = About { range: Some(layer.field.min_max()), ..About::of(self, layer) };
        Some((about, Box::new(&layer.field)))
    }
}
