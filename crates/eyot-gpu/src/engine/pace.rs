//! How many dispatches go into a submission, and which submissions are under way.

use super::MAX_DISPATCHES;
use crate::clock::Instant;
use crate::device::Gpu;
use crate::error::Result;
use std::collections::VecDeque;
use std::time::Duration;

/// See the module.
pub(super) struct Pace {
    pub(super) most: usize,
    /// Steps of the span that are done.
    pub(super) done: u64,
    /// With their dispatches, and the steps that are complete with them.
    pub(super) under_way: VecDeque<(wgpu::SubmissionIndex, usize, u64)>,
    last: Instant,
}

impl Default for Pace {
    fn default() -> Self {
        Self { most: 1, done: 0, under_way: VecDeque::new(), last: Instant::now() }
    }
}

impl Pace {
    pub(super) fn begun(&mut self, submission: wgpu::SubmissionIndex, dispatches: usize, steps: u64) {
        if self.under_way.is_empty() {
            self.last = Instant::now();
        }
        self.under_way.push_back((submission, dispatches, steps));
    }

    /// Waits until no more than `keep` submissions are under way, which aim at `long`.
    pub(super) fn wait(&mut self, gpu: &Gpu, keep: usize, long: Duration) -> Result<()> {
        while self.under_way.len() > keep {
            let Some((submission, dispatches, steps)) = self.under_way.pop_front() else { break };
            gpu.wait(Some(submission))?;
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
