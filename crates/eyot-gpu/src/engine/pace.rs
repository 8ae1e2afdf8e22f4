//! How much goes to the card at a time, and how long it takes.

use super::{MOST_DISPATCHES, Timer};
use crate::clock::Instant;
use crate::device::Gpu;
use crate::error::Result;
use std::collections::VecDeque;
use std::time::Duration;

/// How many dispatches go into a submission, and which submissions are under way.
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
                self.most = wanted.clamp(1, (2 * self.most).min(MOST_DISPATCHES));
            }
            self.done += steps;
        }
        Ok(())
    }
}

/// Most passes that are timed between two readings: twice as many time stamps are what one set of queries may hold.
pub(super) const MOST_TIMED: u32 = 2048;

impl Timer {
    pub(super) fn new(gpu: &Gpu) -> Result<Self> {
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timer"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MOST_TIMED,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.buffer("timer", 16 * u64::from(MOST_TIMED), usage)?;
        Ok(Self { queries, resolved, used: 0 })
    }

    /// Where the next pass is to write its times, if there is room.
    pub(super) fn writes(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (self.used < MOST_TIMED).then(|| wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * self.used),
            end_of_pass_write_index: Some(2 * self.used + 1),
        })
    }

    /// The card's time since the last reading, s.
    pub(super) async fn seconds(&mut self, gpu: &Gpu) -> Result<f64> {
        if self.used == 0 {
            return Ok(0.0);
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.resolve_query_set(&self.queries, 0..2 * self.used, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read(&self.resolved, 0, 16 * u64::from(self.used))?.await?;
        self.used = 0;
        let ticks: Vec<[u64; 2]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let ticks: u64 = ticks.iter().map(|[begin, end]| end.saturating_sub(*begin)).sum();
        Ok(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
