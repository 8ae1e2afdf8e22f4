//! What can go wrong on a GPU.

use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting, Worded};
use std::fmt;

/// Result with [`GpuError`].
pub type Result<T, E = GpuError> = std::result::Result<T, E>;

/// What can go wrong on a GPU. Each text says what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter, or none of that name.
    NoAdapter {
        /// What was asked for, as "that ...".
        wanted: String,
        /// The adapters that there are.
        found: String,
    },
    /// The adapter would not give a device.
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// What the driver says.
        reason: String,
    },
    /// A device that somebody else opened lacks something.
    Unfit {
        /// Name of the adapter.
        adapter: String,
        /// All that is missing, with what there is.
        missing: String,
    },
    /// The device is not done yet, and nobody may wait for it: browsers let no thread do so, and [`Options::polled`](crate::Options)
    /// asks for it. The same call again, or a future, gives the answer.
    CannotWait,
    /// The device is gone: unplugged, reset, or its driver crashed.
    Lost(String),
    /// The adapter's limits are too small for what was asked.
    Limits {
        /// Name of the adapter.
        adapter: String,
        /// What was asked for.
        what: String,
        /// What it needs.
        needed: String,
        /// What there is.
        limit: String,
    },
    /// A picture larger than the adapter draws.
    Picture {
        /// Name of the adapter.
        adapter: String,
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
        /// Most of either.
        limit: u32,
    },
    /// The device has not enough memory left.
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
        /// What was asked for.
        what: String,
        /// How much that is.
        mib: u64,
    },
    /// The driver refused something that should be sound.
    Fault(String),
    /// What the core reports: parameters, limits, values that are not finite, a request to stop.
    Core(eyot_core::Error),
}

impl GpuError {
    /// True if the device is of no further use, though the world may be continued on another.
    pub const fn is_lost(&self) -> bool {
        matches!(self, Self::Lost(_))
    }
}

impl Worded for GpuError {
    fn sentence(&self) -> Remedy {
        let cpu = || Setting::Engine.to("cpu");
        match self {
            Self::NoAdapter { wanted, found } => {
                let problem = format!("no graphics adapter {wanted}; found: {found}");
                remedy![problem, " (run on the processor with ", cpu(), ")"]
            }
            Self::Refused { adapter, reason } => format!("`{adapter}` gives no device: {reason}").into(),
            Self::Unfit { adapter, missing } => {
                format!("`{adapter}` was opened with too little: it needs {missing}").into()
            }
            Self::CannotWait => "the graphics device is not done yet, and its host does not wait".into(),
            Self::Lost(reason) => format!("the graphics device was lost: {reason}").into(),
            Self::Limits { adapter, what, needed, limit } => {
                let problem = format!("`{adapter}` cannot do this: {what} needs {needed}, it allows {limit}");
                remedy![problem, "; choose a smaller grid or ", cpu()]
            }
            Self::Picture { adapter, width, height, limit } => {
                let problem =
                    format!("`{adapter}` draws pictures of up to {limit} pixels a side, not {width}x{height}");
                remedy![problem, "; choose a smaller ", Setting::Size, " or ", cpu()]
            }
            Self::OutOfMemory { adapter, what, mib } => {
                let problem = format!("`{adapter}` has not enough memory for {what} ({mib} MiB)");
                remedy![problem, "; choose a smaller grid or picture, or ", cpu()]
            }
            Self::Fault(reason) => {
                let problem = format!("fault in the GPU engine: {reason}");
                remedy![problem, " (please report it; ", cpu(), " works meanwhile)"]
            }
            Self::Core(e) => e.sentence(),
        }
    }
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.sentence().fmt(f)
    }
}

impl std::error::Error for GpuError {}

impl From<eyot_core::Error> for GpuError {
    fn from(e: eyot_core::Error) -> Self {
        Self::Core(e)
    }
}

impl From<GpuError> for Remedy {
    fn from(e: GpuError) -> Self {
        e.sentence()
    }
}
