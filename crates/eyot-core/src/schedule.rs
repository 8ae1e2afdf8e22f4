//! Turns a plan into a schedule: which buffer each pass reads and writes, and how far it must lag behind the others.
//!
//! A pass that reads its own layer only at the cell itself overwrites it in place; one that looks at neighbours writes
//! the layer's other buffer. Pass p may work on row y once every earlier pass q that it depends on has done the rows
//! within p's reach, and once nobody needs what it overwrites any more. In both cases that is a distance in rows, so
//! one number per pass, its **lag**, carries all dependencies:
//!
//! ```text
//! lag(p) >= lag(q) + reach   if q writes what p reads, or q reads what p overwrites
//! lag(p) >= lag(q)           if both write the same buffer
//! ```
//!
//! With lags known, rows can be swept as one skewed wave through all passes of several steps, and the grid can be cut
//! into bands that do not overlap (see `engine`).

use crate::error::{Error, Result};
use crate::layer::LayerSpec;
use crate::plan::Pass;

/// A layer's buffer: which layer, which of its two copies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Buffer {
    pub(crate) layer: usize,
    pub(crate) copy: usize,
}

/// A pass with its buffers, lag and sums.
#[derive(Debug)]
pub(crate) struct Scheduled {
    pub(crate) reads: Vec<(Buffer, usize)>,
    pub(crate) writes: Vec<Buffer>,
    pub(crate) lag: usize,
}

/// See the module.
#[derive(Debug, Default)]
pub(crate) struct Schedule {
    pub(crate) passes: Vec<Scheduled>,
    /// Which copy of each layer holds its value at the end.
    pub(crate) current: Vec<usize>,
    pub(crate) longest_lag: usize,
}

impl Schedule {
    /// Schedules `passes` over `layers`, whose values are in the copies `current`: all of them, or those before the first
    /// whose lag would exceed `most_lag`, but at least one.
    pub(crate) fn new(passes: &[Pass], layers: &[LayerSpec], current: &[usize], most_lag: usize) -> Result<Self> {
        let mut s = Self { current: current.to_vec(), ..Self::default() };
        let find = |name: &str| {
            layers.iter().position(|l| l.name == name).ok_or_else(|| Error::NoLayer {
                name: name.to_owned(),
                present: layers.iter().map(|l| &*l.name).collect::<Vec<_>>().join(", "),
            })
        };
        for pass in passes {
            let mut reads = Vec::with_capacity(pass.reads().len());
            for r in pass.reads() {
                let layer = find(r.layer)?;
                reads.push((Buffer { layer, copy: s.current[layer] }, r.reach));
            }
            let mut writes = Vec::with_capacity(pass.writes().len());
            for name in pass.writes() {
                let layer = find(name)?;
                let looks_around = reads.iter().any(|(b, reach)| b.layer == layer && *reach > 0);
                let copy = if looks_around { 1 - s.current[layer] } else { s.current[layer] };
                writes.push(Buffer { layer, copy });
            }
            let mut lag = 0;
            for q in &s.passes {
                let read_after_write = reads.iter().filter(|(b, _)| q.writes.contains(b)).map(|(_, reach)| *reach);
                let write_after_read = q.reads.iter().filter(|(b, _)| writes.contains(b)).map(|(_, reach)| *reach);
                let write_after_write = q.writes.iter().filter(|b| writes.contains(b)).map(|_| 0);
                if let Some(d) = read_after_write.chain(write_after_read).chain(write_after_write).max() {
                    lag = lag.max(q.lag + d);
                }
            }
            if lag > most_lag && !s.passes.is_empty() {
                break;
            }
            for b in &writes {
                s.current[b.layer] = b.copy;
            }
            s.longest_lag = s.longest_lag.max(lag);
            s.passes.push(Scheduled { reads, writes, lag });
        }
        Ok(s)
    }
}
