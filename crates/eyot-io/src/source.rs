//! Where the values of exports come from: a world in memory, or one that is made while it is written.

use crate::about::About;
use crate::rows::Rows;
use eyot_core::layer::known;
use eyot_core::{Field, World};

/// Layers whose rows can be read one band after the other.
pub trait Source {
    /// What the layer is, and its rows; `None` if there is no such layer.
    fn layer<'a>(&'a self, name: &str) -> Option<(About, Box<dyn Rows + 'a>)>;
}

impl Source for World {
    fn layer<'a>(&'a self, name: &str) -> Option<(About, Box<dyn Rows + 'a>)> {
        let layer = World::layer(self, name).ok()?;
        let about = About { range: Some(layer.field.min_max()), ..About::of(self, layer) };
        let marks = self.get(&known::MISSING.name).filter(|_| layer.spec.name != known::MISSING.name);
        Some((
            about,
            match marks {
                Some(marks) => {
                    Box::new(Marked { field: &layer.field, missing: marks.iter().map(|m| m > 0.5).collect() })
                }
                None => Box::new(&layer.field),
            },
        ))
    }
}

/// The values of a layer, of which some are only filled in.
struct Marked<'a> {
    field: &'a Field,
    missing: Vec<bool>,
}

impl Rows for Marked<'_> {
    fn size(&self) -> (usize, usize) {
        (self.field.width(), self.field.height())
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> eyot_core::Result<()> {
        (&mut self.field).read(first, out)
    }

    fn missing(&self) -> Option<&[bool]> {
        Some(&self.missing)
    }
}
