//! What can go wrong on a GPU.

/// Result with [`GpuError`].
pub type Result<T, E = GpuError> = std::result::Result<T, E>;

/// What can go wrong on a GPU. Each text says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter, or none of that name.
    #[error("no graphics adapter {wanted}; found: {found} (run on the processor with --engine cpu)")]
    NoAdapter {
        /// What was asked for, as "that ...".
        wanted: String,
        /// The adapters that there are.
        found: String,
    },
    /// The adapter would not give a device.
    #[error("`{adapter}` gives no device: {reason}")]
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// What the driver says.
        reason: String,
    },
    /// A device that somebody else opened lacks something.
    #[error("`{adapter}` was opened with too little: it needs {missing}")]
    Unfit {
        /// Name of the adapter.
        adapter: String,
        /// All that is missing, with what there is.
        missing: String,
    },
    /// The device is not done yet, and nobody may wait for it: browsers let no thread do so, and [`Options::polled`](crate::Options)
    /// asks for it. The same call again, or a future, gives the answer.
    #[error("the graphics device is not done yet, and its host does not wait")]
    CannotWait,
    /// The device is gone: unplugged, reset, or its driver crashed.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The adapter's limits are too small for what was asked.
    #[error(
        "`{adapter}` cannot do this: {what} needs {needed}, it allows {limit}; choose a smaller grid or --engine cpu"
    )]
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
    #[error(
        "`{adapter}` draws pictures of up to {limit} pixels a side, not {width}x{height}; choose a smaller --size or --engine cpu"
    )]
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
    #[error(
        "`{adapter}` has not enough memory for {what} ({mib} MiB); choose a smaller grid or picture, or --engine cpu"
    )]
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
        /// What was asked for.
        what: String,
        /// How much that is.
        mib: u64,
    },
    /// The driver refused something that should be sound.
    #[error("fault in the GPU engine: {0} (please report it; --engine cpu works meanwhile)")]
    Fault(String),
    /// What the core reports: parameters, limits, values that are not finite, a request to stop.
    #[error(transparent)]
    Core(#[from] eyot_core::Error),
}

impl GpuError {
    /// True if the device is of no further use, though the world may be continued on another.
    pub const fn is_lost(&self) -> bool {
        matches!(self, Self::Lost(_))
    }
}
