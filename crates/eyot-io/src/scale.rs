//! Values as whole numbers of 16 bits, and back.

use crate::about::About;
use crate::error::{Error, Result};
use crate::format::WriteOptions;
use crate::rows::{Rows, range_of};
use std::path::Path;

/// Largest number of 16 bits.
const STEPS: f64 = 65535.0;

/// A linear map between values and 0..=65535.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Value of 0.
    pub(crate) low: f64,
    /// Value of 65535.
    pub(crate) high: f64,
}

impl Scale {
    /// What the options or the range of the values give.
    pub(crate) fn of(path: &Path, rows: &mut dyn Rows, about: &About, options: &WriteOptions) -> Result<Self> {
        if let Some((low, high)) = options.scale {
            if !(low.is_finite() && high.is_finite() && low <= high) {
                let problem = format!("0 is to stand for {low} and 65535 for {high}");
                return Err(Error::format(path, problem, "give two finite numbers, the smaller one first"));
            }
            return Ok(Self { low, high });
        }
        let (min, max) = match about.range {
            Some(range) => range,
            None => range_of(path, rows)?,
        };
        // In f64: the range of finite f32 values can overflow f32.
        Ok(Self { low: min.into(), high: max.into() })
    }

    /// The numbers of `values`, refused if one leaves the scale by more than half a step.
    pub(crate) fn quantise(&self, path: &Path, values: &[f32], out: &mut Vec<u16>) -> Result<()> {
        let range = self.high - self.low;
        let per_unit = if range > 0.0 { STEPS / range } else { 0.0 };
        out.clear();
        let mut beyond = None;
        out.extend(values.iter().map(|&v| {
            let s = (f64::from(v) - self.low) * per_unit;
            if !(-0.5..=STEPS + 0.5).contains(&s) || (range == 0.0 && f64::from(v) != self.low) {
                beyond = Some(v);
            }
            s.round() as u16
        }));
        match beyond {
            None => Ok(()),
            Some(v) => {
                let problem = format!("the value {v} lies beyond the scale from {} to {}", self.low, self.high);
                Err(Error::format(path, problem, "widen the scale, or leave it out"))
            }
        }
    }

    /// The value of a number.
    pub(crate) fn value(&self, s: f64) -> f32 {
        (self.low + s / STEPS * (self.high - self.low)) as f32
    }
}
