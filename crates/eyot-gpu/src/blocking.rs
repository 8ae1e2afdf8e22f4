//! For programs whose threads may wait: everything else in this crate is asynchronous. Browsers have no such threads, so this module is
//! left out there.

use crate::adapter::{self, AdapterReport, Choice};
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use std::sync::atomic::Ordering;

/// As [`adapter::adapters`].
pub fn adapters() -> Vec<AdapterReport> {
    pollster::block_on(adapter::adapters())
}

/// As [`Gpu::open`].
///
/// # Errors
/// As [`Gpu::open`].
pub fn open(choice: &Choice) -> Result<Gpu> {
    pollster::block_on(Gpu::open(choice))
}

impl Gpu {
    /// Waits until a submission is done, or all of them.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub(crate) fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
        self.traffic.waits.fetch_add(1, Ordering::Relaxed);
        let outcome = self.device.poll(wgpu::PollType::Wait { submission_index: submission, timeout: None });
        self.check()?;
        outcome.map(|_| ()).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Waits until the card has nothing to do.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn drain(&self) -> Result<()> {
        self.wait(None)
    }
}
