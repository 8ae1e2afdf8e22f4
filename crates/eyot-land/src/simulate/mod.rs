//! Processes by name.
use eyot_core::process::{Entry, Process};

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[];
