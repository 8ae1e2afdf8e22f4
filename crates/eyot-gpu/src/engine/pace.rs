//! How many dispatches go into a submission, and which submissions are under way.

use super::MAX_DISPATCHES;
use crate::clock::Instant;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// See the module.
pub(super) struct Pace {
    pub(super) most: usize,
    /// Steps of the span that are done.
    pub(super) done: u64,
    pub(super) under_way: VecDeque<Submission>,
    last: Instant,
}

/// What was sent to the card.
pub(super) struct Submission {
    index: wgpu::SubmissionIndex,
    dispatches: usize,
    /// Steps that are complete with it.
    steps: u64,
    /// Set by the device where nobody waits for it.
    done: Arc<AtomicBool>,
}

impl Default for Pace {
    fn default() -> Self {
        Self { most: 1, done: 0, under_way: VecDeque::new(), last: Instant::now() }
    }
}

impl Pace {
    pub(super) fn begun(
        &mut self,
        gpu: &Gpu,
        index: wgpu::SubmissionIndex,
        dispatches: usize,
        steps: u64,
        polled: bool,
    ) {
        if self.under_way.is_empty() {
            self.last = Instant::now();
        }
        let done = Arc::<AtomicBool>::default();
        if polled {
            let tell = Arc::clone(&done);
            gpu.queue.on_submitted_work_done(move || tell.store(true, Ordering::Release));
        }
        self.under_way.push_back(Submission { index, dispatches, steps, done });
    }

    /// Waits until no more than `keep` submissions are under way, which aim at `long`; where nobody may wait it looks.
    ///
    /// # Errors
    /// [`GpuError::CannotWait`] if it is `polled` and more are under way, or if the device fails.
    pub(super) fn wait(&mut self, gpu: &Gpu, keep: usize, long: Duration, polled: bool) -> Result<()> {
        if polled && self.under_way.len() > keep {
            gpu.poll()?;
        }
        while self.under_way.len() > keep {
            if polled && !self.under_way.front().is_some_and(|s| s.done.load(Ordering::Acquire)) {
                return Err(GpuError::CannotWait);
            }
            let Some(Submission { index, dispatches, steps, .. }) = self.under_way.pop_front() else { break };
            if !polled {
                gpu.wait(Some(index))?;
            }
            let took = self.last.elapsed();
            self.last = Instant::now();
            let wanted = (dispatches as f64 * long.as_secs_f64() / took.as_secs_f64().max(1e-6)) as usize;
            // The end of a span says nothing about how many there could be.
            if dispatches >= self.most || wanted < self.most {
                self.most = wanted.clamp(1, (2 * self.most).min(MAX_DISPATCHES));
            }
            self.done += steps;
        }
        Ok(())
    }
}
