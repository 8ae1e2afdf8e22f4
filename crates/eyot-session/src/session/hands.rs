//! The world in the hands of the host, between two steps: to be looked at, and to be changed by something that is no command.

use super::device::Layers;
use super::{Phase, Session};
use crate::error::RunError;
use crate::files::CHECKPOINT_FILE;
use eyot_core::layer::known;
use eyot_core::{Centering, World};
use eyot_io::storage::{Memory, read_bytes};
use std::path::PathBuf;

impl Session {
    /// Takes the world out, brought up to all that was done, without a copy. Until [`Session::restore`] gives it back the session does
    /// nothing, and [`Session::advance`] says that it is paused. `None` if the engine is not ready, the world is lent already or the
    /// session is over.
    pub fn lend(&mut self) -> Option<World> {
        if self.lent || matches!(self.phase, Phase::Over(_)) || !self.is_brought_back() {
            return None;
        }
        self.settle();
        self.lent = true;
        let empty = World::new(self.world.grid, self.world.seed);
        Some(std::mem::replace(&mut self.world, empty))
    }

    /// Gives back what [`Session::lend`] gave, or an equal world. Nothing happens if none was lent.
    pub fn restore(&mut self, world: World) {
        if std::mem::take(&mut self.lent) {
            self.world = world;
        }
    }

    /// Lets the host change the world between two steps, by what is no [`Command`](crate::Command): its own processes. The journal does
    /// not know of it, so that a replay lacks it; checkpoints and recordings from here on have it. What is put into layers or taken out
    /// has an account in the ledger.
    ///
    /// # Errors
    /// If the world is lent, the session is over, or the engine is not ready; and if the change leaves a value that is not finite. What has been
    /// changed stays then.
    pub fn edit<T>(&mut self, edit: impl FnOnce(&mut World) -> T) -> Result<T, RunError> {
        let Some(mut world) = self.lend() else {
            return Err(RunError::input("the world cannot be changed now: it is lent, over, or its engine is at work"));
        };
        let before = contents(&world);
        let result = edit(&mut world);
        for (name, unit, amount) in contents(&world) {
            let was = before.iter().find(|(n, ..)| *n == name).map_or(0.0, |(.., amount)| *amount);
            if amount != was {
                let meaning = "Put in by hand; below 0, taken out";
                world.ledger.add(&format!("{name}.by_hand"), amount - was, &unit, meaning, 1);
            }
        }
        let sound = world.check_finite("a change by hand");
        self.restore(world);
        // What the engine holds is the world before.
        self.engine.engine_mut().release();
        self.layers = Layers::Current;
        self.settled = self.state.done;
        self.invalidate_view();
        sound.map_err(|e| RunError::input(eyot_core::remedy::Worded::sentence(&e)))?;
        Ok(result)
    }

    /// Writes a checkpoint into the host's storage now, and says where; `None` without a storage, or while the world is lent.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn save_checkpoint(&mut self) -> Result<Option<PathBuf>, RunError> {
        if self.lent || matches!(self.phase, Phase::Over(_)) || !self.is_brought_back() {
            return Ok(None);
        }
        self.checkpoint()
    }

    /// A checkpoint as bytes, from which [`Run::session_of`](crate::Run::session_of) goes on, wherever they are taken. `None` while the world is
    /// lent, and of a session that is over.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn checkpoint_bytes(&mut self) -> Result<Option<Vec<u8>>, RunError> {
        if self.lent || matches!(self.phase, Phase::Over(_)) || !self.is_brought_back() {
            return Ok(None);
        }
        self.settle();
        let memory = Memory::new();
        self.save_in(&memory)?;
        read_bytes(&memory, CHECKPOINT_FILE, u64::MAX).map(Some).map_err(RunError::file)
    }
}

/// What layers on cells hold whose sums mean something: material, unit and amount.
fn contents(world: &World) -> Vec<(String, String, f64)> {
    let area_m2 = world.grid.cell_area_m2();
    let cells = world.layers().iter().filter(|l| l.spec.centering == Centering::Cell);
    let amount = |layer: &eyot_core::Layer| {
        let unit = match &*layer.spec.unit {
            "m" => "m3".to_owned(),
            unit => unit.strip_suffix("/m2")?.to_owned(),
        };
        let material = if layer.spec.name == known::HEIGHT.name { "ground" } else { &layer.spec.name };
        Some((material.to_owned(), unit, layer.field.sum() * area_m2))
    };
    cells.filter_map(amount).collect()
}
