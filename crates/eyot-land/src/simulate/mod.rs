//! Processes by name.
use eyot_core::process::{Entry, Process};

pub mod hydraulic;
pub mod thermal;

/// All processes that recipes can name.
pub const PROCESSES: &[Entry<dyn Process>] = &[];
