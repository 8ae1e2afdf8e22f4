//! What a device says went wrong, whenever it says so.

use crate::error::{GpuError, Result};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

/// The outcome of an error scope that is not known yet.
type Outcome = Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>;

/// See the module.
#[derive(Default)]
pub(crate) struct Health {
    lost: Mutex<Option<String>>,
    fault: Mutex<Option<String>>,
    unknown: Mutex<Vec<Outcome>>,
}

fn lock<T>(place: &Mutex<T>) -> MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Health {
    /// Takes the device's reports over.
    pub(crate) fn listen(self: &Arc<Self>, device: &wgpu::Device) {
        let keep = Arc::clone(self);
        device.set_device_lost_callback(move |reason, text| keep.note_lost(&format!("{reason:?} {text}")));
        let keep = Arc::clone(self);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| keep.note_fault(&e.to_string())));
    }

    /// The first text stays.
    pub(crate) fn note_lost(&self, text: &str) {
        lock(&self.lost).get_or_insert_with(|| text.to_owned());
    }

    /// The first text stays.
    pub(crate) fn note_fault(&self, text: &str) {
        lock(&self.fault).get_or_insert_with(|| text.to_owned());
    }

    /// An outcome that the next [`Health::check`] looks for.
    pub(crate) fn ask_later(&self, outcome: Outcome) {
        lock(&self.unknown).push(outcome);
    }

    /// See [`crate::Gpu::check`].
    pub(crate) fn check(&self) -> Result<()> {
        lock(&self.unknown).retain_mut(|o| match o.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(Some(e)) => {
                self.note_fault(&e.to_string());
                false
            }
            Poll::Ready(None) => false,
            Poll::Pending => true,
        });
        if let Some(text) = lock(&self.lost).clone() {
            return Err(GpuError::Lost(text));
        }
        match lock(&self.fault).take() {
            Some(text) => Err(GpuError::Fault(text)),
            None => Ok(()),
        }
    }
}
