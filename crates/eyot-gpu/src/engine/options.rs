//! How the engine works, and what it has done.

use eyot_core::Limits;
use std::time::Duration;

/// How the engine works; nothing here changes a result by more than rounding.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Options {
    /// Bounds on what may be allocated.
    pub limits: Limits,
    /// Passes of a dispatch; 0 chooses, 1 switches fusing off.
    pub most_passes: usize,
    /// Bytes of one buffer, beside the device's own bound; larger grids are cut.
    pub most_bytes: u64,
    /// Measures the card's own time with timestamps, if it has them.
    pub timed: bool,
    /// A submission aims at this long.
    pub submission: Duration,
    /// Never waits for the card: whatever would have to answers [`GpuError::CannotWait`](crate::GpuError::CannotWait), has changed
    /// nothing, and is to be called again. In browsers there is no other way.
    pub polled: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            most_passes: 0,
            most_bytes: u64::MAX,
            timed: false,
            submission: Duration::from_millis(20),
            polled: cfg!(target_arch = "wasm32"),
        }
    }
}

impl Options {
    /// With these bounds on what may be allocated.
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// With so many passes of a dispatch.
    pub fn most_passes(self, most_passes: usize) -> Self {
        Self { most_passes, ..self }
    }

    /// With buffers of at most so many bytes.
    pub fn most_bytes(self, most_bytes: u64) -> Self {
        Self { most_bytes, ..self }
    }

    /// Measuring the card's own time, or not.
    pub fn timed(self, timed: bool) -> Self {
        Self { timed, ..self }
    }

    /// With submissions of about this long.
    pub fn submission(self, submission: Duration) -> Self {
        Self { submission, ..self }
    }

    /// For a host that polls, or one that waits.
    pub fn polled(self, polled: bool) -> Self {
        Self { polled, ..self }
    }
}

/// What the engine has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Work {
    /// Steps.
    pub steps: u64,
    /// Submissions.
    pub submissions: u64,
    /// Dispatches, with a barrier before each.
    pub dispatches: u64,
    /// Bytes moved between the card's memory and its processors if every layer is moved once a dispatch.
    pub bytes: u64,
    /// Pipelines compiled.
    pub pipelines: u64,
    /// The card's own time, s; 0 without [`Options::timed`].
    pub card_s: f64,
    /// Layers that were brought back from the card.
    pub layers_back: u64,
    /// Bytes that were brought back from the card: layers, sums, ranges, pictures.
    pub bytes_back: u64,
    /// How often a thread has waited for the card.
    pub waits: u64,
}

impl Work {
    /// What was done after `earlier`.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            steps: self.steps - earlier.steps,
            submissions: self.submissions - earlier.submissions,
            dispatches: self.dispatches - earlier.dispatches,
            bytes: self.bytes - earlier.bytes,
            pipelines: self.pipelines - earlier.pipelines,
            card_s: self.card_s - earlier.card_s,
            layers_back: self.layers_back - earlier.layers_back,
            bytes_back: self.bytes_back - earlier.bytes_back,
            waits: self.waits - earlier.waits,
        }
    }
}
