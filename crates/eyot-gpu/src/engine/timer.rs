//! The card's own time.

use crate::device::Gpu;
use crate::error::Result;
use crate::reading::Reading;

/// Most passes that are timed between two readings: twice as many time stamps are what one set of queries may hold.
pub(super) const MAX_TIMED: u32 = 2048;

/// Time stamps of compute passes.
pub(super) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Submissions timed since the last reading.
    pub(super) used: u32,
    /// Times on their way back.
    coming: Option<Reading>,
}

impl Timer {
    pub(super) fn new(gpu: &Gpu) -> Result<Self> {
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timer"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * MAX_TIMED,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.buffer("timer", 16 * u64::from(MAX_TIMED), usage)?;
        Ok(Self { queries, resolved, used: 0, coming: None })
    }

    /// Where the next pass is to write its times, if there is room.
    pub(super) fn writes(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (self.used < MAX_TIMED).then(|| wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * self.used),
            end_of_pass_write_index: Some(2 * self.used + 1),
        })
    }

    /// The card's time since the last reading, s; where nobody waits for it, what has come back of it.
    pub(super) fn seconds(&mut self, gpu: &Gpu, polled: bool) -> Result<f64> {
        let reading = match self.coming.take() {
            Some(reading) => reading,
            None if self.used == 0 => return Ok(0.0),
            None => {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encoder.resolve_query_set(&self.queries, 0..2 * self.used, &self.resolved, 0);
                gpu.queue.submit([encoder.finish()]);
                let reading = gpu.read(&self.resolved, 0, 16 * u64::from(self.used))?;
                self.used = 0;
                reading
            }
        };
        if polled && !reading.is_ready()? {
            self.coming = Some(reading);
            return Ok(0.0);
        }
        let bytes = gpu.complete(reading)?;
        let ticks: Vec<[u64; 2]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let ticks: u64 = ticks.iter().map(|[begin, end]| end.saturating_sub(*begin)).sum();
        Ok(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9)
    }
}
