//! The world on its way back from the card.

use super::resident::Resident;
use crate::arena::Pending;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::reading::Reading;
use eyot_core::{Field, LayerSpec, World};

/// Layers and sums on their way back: one layer after the other, since all of them together may be more than the host's memory holds
/// beside the world.
pub(super) struct Coming {
    /// Those that are out of date and wanted.
    layers: Vec<usize>,
    arrived: Vec<Field>,
    layer: Option<Pending>,
    sums: Option<Reading>,
}

impl Coming {
    /// Goes on until everything has arrived.
    ///
    /// # Errors
    /// [`GpuError::CannotWait`] if it is `polled` and something has not arrived, or if the device fails.
    fn go_on(&mut self, r: &Resident, gpu: &Gpu, polled: bool) -> Result<Option<Vec<u8>>> {
        while let Some(&l) = self.layers.get(self.arrived.len()) {
            let mut pending = match self.layer.take() {
                Some(pending) => pending,
                None => r.arena.request(gpu, r.slots[&(l, r.current[l])])?,
            };
            if polled && !pending.is_ready()? {
                self.layer = Some(pending);
                return Err(GpuError::CannotWait);
            }
            self.arrived.push(pending.take(gpu)?);
        }
        let sums = match self.sums.take() {
            Some(sums) => Some(sums),
            None => r.arena.request_sums(gpu)?,
        };
        let Some(sums) = sums else { return Ok(None) };
        if polled && !sums.is_ready()? {
            self.sums = Some(sums);
            return Err(GpuError::CannotWait);
        }
        gpu.complete(sums).map(Some)
    }
}

impl Resident {
    /// Downloads everything that is out of date.
    pub(super) fn download_all(&mut self, gpu: &Gpu, world: &mut World, polled: bool) -> Result<()> {
        self.download(gpu, world, polled, |_| true)?;
        self.synced = (world.step, world.sea_level_m);
        self.held = None;
        Ok(())
    }

    /// Downloads the layers that are out of date and `wanted`, and the ledger.
    ///
    /// # Errors
    /// [`GpuError::CannotWait`] if it is `polled` and not all has arrived, or if the device fails. Nothing has changed then.
    pub(super) fn download(
        &mut self,
        gpu: &Gpu,
        world: &mut World,
        polled: bool,
        wanted: impl Fn(&LayerSpec) -> bool,
    ) -> Result<()> {
        gpu.check()?;
        let layers: Vec<usize> = (0..self.world_layers).filter(|&l| self.stale[l] && wanted(&self.specs[l])).collect();
        let mut coming = self.coming.take().filter(|c| c.layers == layers).unwrap_or_else(|| Coming {
            layers,
            arrived: Vec::new(),
            layer: None,
            sums: None,
        });
        let sums = match coming.go_on(self, gpu, polled) {
            Err(e @ GpuError::CannotWait) => {
                self.coming = Some(coming);
                return Err(e);
            }
            outcome => outcome?,
        };
        // Nothing can fail from here on: the world changes as a whole.
        for (&l, field) in coming.layers.iter().zip(coming.arrived) {
            world.layer_mut(&self.specs[l].name)?.field = field;
            self.stale[l] = false;
        }
        let (area, totals) = (world.grid.cell_area_m2(), self.arena.totals(sums.as_deref().unwrap_or_default()));
        self.accounts.iter_mut().zip(totals).for_each(|(account, total)| account.post(&mut world.ledger, total, area));
        Ok(())
    }
}
