//! What a world was, to go back to.

use crate::component::Components;
use crate::error::Result;
use crate::field::Field;
use crate::ledger::Ledger;
use crate::world::World;
use std::borrow::Cow;

/// Clock, ledger and some layers of a world at one moment.
#[derive(Clone, Debug)]
pub struct Saved {
    step: u64,
    sea_level_m: f64,
    layers: Vec<(Cow<'static, str>, Field)>,
    ledger: Ledger,
    components: Components,
}

impl Saved {
    /// All of a world but its layers.
    pub fn new(world: &World) -> Self {
        Self {
            step: world.step,
            sea_level_m: world.sea_level_m,
            layers: Vec::new(),
            ledger: world.ledger.clone(),
            components: world.components.clone(),
        }
    }

    /// Keeps a layer too, unless it is kept already.
    ///
    /// # Errors
    /// If there is no layer of that name.
    pub fn keep(&mut self, world: &World, name: &str) -> Result<()> {
        if self.layers.iter().all(|(kept, _)| kept != name) {
            let layer = world.layer(name)?;
            self.layers.push((layer.spec.name.clone(), layer.field.clone()));
        }
        Ok(())
    }

    /// Makes a world what it was.
    pub fn put_back(self, world: &mut World) {
        for (name, field) in self.layers {
            // Whoever removed a layer does not want it back.
            if let Ok(layer) = world.layer_mut(&name) {
                layer.field = field;
            }
        }
        (world.ledger, world.components) = (self.ledger, self.components);
        (world.step, world.sea_level_m) = (self.step, self.sea_level_m);
    }
}
