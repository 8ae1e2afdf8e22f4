//! Between the world and the card: what is lent, what is brought anew.

use super::{GpuEngine, Resident};
use crate::error::{GpuError, Result};
use eyot_core::World;
use eyot_core::engine::Borrowed;
use eyot_core::process::{Scheduled, Span};

impl GpuEngine {
    /// Lends the world those layers that somebody reads, and takes those that he writes.
    pub(crate) fn lend_layers(
        &mut self,
        world: &mut World,
        borrowed: &Borrowed,
        work: &mut dyn FnMut(&mut World) -> eyot_core::Result<()>,
    ) -> Result<()> {
        self.finish()?;
        let r = self.resident.as_mut().ok_or_else(|| GpuError::Fault("no world is on the card".into()))?;
        r.hold(world, |spec| borrowed.is_borrowed(&spec.name))?;
        r.download(&self.gpu, world, |spec| borrowed.is_read(&spec.name))?;
        work(world)?;
        for l in (0..r.world_layers).filter(|&l| borrowed.is_written(&r.specs[l].name)) {
            let field = &world.layer(&r.specs[l].name)?.field;
            r.arena.upload(&self.gpu, r.slots[&(l, r.current[l])], field)?;
            r.stale[l] = false;
        }
        r.share(&self.gpu);
        Ok(())
    }

    /// Finds values that are not finite without moving layers.
    pub(super) fn check_finite(&mut self, world: &mut World) -> Result<()> {
        let Some(r) = &self.resident else { return Ok(()) };
        let changed: Vec<usize> = (0..r.world_layers).filter(|&l| r.stale[l]).collect();
        for l in changed {
            let r = self.resident.as_ref().ok_or_else(|| GpuError::Fault("no world is on the card".into()))?;
            let slot = r.slots[&(l, r.current[l])];
            if self.gpu.complete(self.reducer.range(&self.gpu, &r.arena, slot))?.not_finite > 0 {
                // Names the place.
                return self.download(world);
            }
        }
        Ok(())
    }

    /// Brings the world to the card, with room for copies of layers that were needed before.
    pub(crate) fn make_resident(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        copies: &[(String, usize)],
    ) -> Result<()> {
        let resident = Resident::new(self, world, processes, span, copies)?;
        self.resident = Some(resident);
        // Another world's dispatches may take far longer.
        self.pace.most = 1;
        Ok(())
    }

    /// Downloads the world and brings it to the card anew, with room for what lies ahead. In the middle of a step the world as it was when it
    /// was last downloaded is kept to fall back to.
    pub(crate) fn rebuild(
        &mut self,
        world: &mut World,
        processes: &[Scheduled],
        span: Span,
        within_step: bool,
    ) -> Result<()> {
        self.finish()?;
        let mut kept = None;
        if let Some(r) = self.resident.as_mut().filter(|_| within_step) {
            r.hold(world, |_| true)?;
            r.download(&self.gpu, world, |_| true)?;
            kept = r.held.take().map(|held| (r.synced, held));
        } else {
            self.download(world)?;
        }
        let copies = self.resident.as_ref().map(Resident::copies).unwrap_or_default();
        self.release();
        let outcome = self.make_resident(world, processes, span, &copies);
        match (kept, self.resident.as_mut()) {
            (Some((synced, held)), Some(r)) => (r.synced, r.held) = (synced, Some(held)),
            // Nothing is on the card that could fall back.
            (Some((synced, held)), None) => {
                held.put_back(world);
                (world.step, world.sea_level_m) = synced;
            }
            (None, _) => {}
        }
        outcome
    }
}
