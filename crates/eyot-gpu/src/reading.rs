//! Bytes on their way back from the card.

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::health::Health;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// Bytes on their way back from the card: a future, or something to look at now and then with [`Reading::is_ready`].
///
/// On desktops a future goes on when the device is polled: by a submission, by [`Gpu::poll`], or by being polled itself.
pub struct Reading {
    device: wgpu::Device,
    health: Arc<Health>,
    staging: wgpu::Buffer,
    told: Arc<Mutex<Told>>,
}

#[derive(Default)]
struct Told {
    outcome: Option<bool>,
    waker: Option<Waker>,
}

impl Reading {
    pub(crate) fn new(gpu: &Gpu, staging: wgpu::Buffer) -> Self {
        let told = Arc::<Mutex<Told>>::default();
        let tell = Arc::clone(&told);
        // Buffers of a lost device are not sound; `outcome` says so, and a host without a handler for errors must not hear of it.
        let _ = gpu.scoped(wgpu::ErrorFilter::Validation, || {
            staging.map_async(wgpu::MapMode::Read, .., move |outcome| {
                let mut told = tell.lock().unwrap_or_else(PoisonError::into_inner);
                told.outcome = Some(outcome.is_ok());
                if let Some(waker) = told.waker.take() {
                    waker.wake();
                }
            });
        });
        Self { device: gpu.device.clone(), health: Arc::clone(&gpu.health), staging, told }
    }

    /// True once the bytes are there. Does not wait.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn is_ready(&self) -> Result<bool> {
        self.look(None)
    }

    fn look(&self, waker: Option<&Waker>) -> Result<bool> {
        // A failed poll means a lost device, which `check` reports.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.health.check()?;
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        match told.outcome {
            Some(true) => Ok(true),
            Some(false) => Err(GpuError::Lost("it gave back no memory".into())),
            None => {
                // Whoever only looks takes nobody's place.
                if waker.is_some() {
                    told.waker = waker.cloned();
                }
                Ok(false)
            }
        }
    }

    /// Does something with the bytes, which are there.
    pub(crate) fn with<T>(&self, read: impl FnOnce(&[u8]) -> T) -> Result<T> {
        let bytes = self.staging.get_mapped_range(..).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(read(&bytes))
    }

    /// Ready once the bytes are there.
    pub(crate) fn poll_ready(&self, context: &mut Context<'_>) -> Poll<Result<()>> {
        match self.look(Some(context.waker())) {
            Ok(true) => Poll::Ready(Ok(())),
            Ok(false) => Poll::Pending,
            Err(e) => Poll::Ready(Err(e)),
        }
    }
}

impl Future for Reading {
    type Output = Result<Vec<u8>>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        self.poll_ready(context).map(|outcome| outcome.and_then(|()| self.with(<[u8]>::to_vec)))
    }
}
