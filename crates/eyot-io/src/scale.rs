//! Values as whole numbers of 16 bits, and back.

use crate::about::About;
use crate::error::{Error, Result};
use crate::options::WriteOptions;
use crate::raster::{Numbers, Raster, ReadOptions};
use crate::rows::{Rows, range_of};
use eyot_core::remedy;
use eyot_core::remedy::{Action, Setting};
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
        // Multiplied first: whole numbers that stand for whole numbers then come out exactly.
        (self.low + s * (self.high - self.low) / STEPS) as f32
    }
}

/// What the whole numbers of a file stand for.
#[derive(Clone, Copy)]
pub(crate) struct Meaning {
    /// Values of the smallest and the largest number.
    pub(crate) scale: Scale,
    /// The largest number: 255 or 65535.
    largest: f64,
    /// True if nothing says so.
    bare: bool,
}

impl Meaning {
    /// What the options say, or the file; `low` and `high` are the file's. Numbers of which neither speaks are refused, or
    /// stand for themselves if the options say so.
    pub(crate) fn of(
        path: &Path,
        largest: f64,
        low: Option<f64>,
        high: Option<f64>,
        options: &ReadOptions,
    ) -> Result<Self> {
        let (low, high) = (options.low_m.or(low), options.high_m.or(high));
        let (scale, bare) = match low.zip(high) {
            Some((low, high)) if (low as f32).is_finite() && (high as f32).is_finite() => (Scale { low, high }, false),
            Some((low, high)) => {
                let problem = format!("0 (black) stands for {low} and {largest} (white) for {high}");
                return Err(Error::format(
                    path,
                    problem,
                    remedy!["give finite numbers for low_m and high_m (", Setting::InputRange, ")"],
                ));
            }
            None if options.bare_numbers => (Scale { low: 0.0, high: largest }, true),
            None => {
                let problem = format!("nothing says which heights 0 (black) and {largest} (white) stand for");
                let remedy = remedy![
                    "give low_m and high_m in a recipe (generate = \"import\"), or ",
                    Setting::InputRange.form(),
                    " to ",
                    Action::Converter,
                ];
                return Err(Error::format(path, problem, remedy));
            }
        };
        Ok(Self { scale, largest, bare })
    }

    /// The value of a number.
    pub(crate) fn value(&self, number: f64) -> f32 {
        self.scale.value(number * (STEPS / self.largest))
    }

    /// The raster with what is known of its numbers.
    pub(crate) fn describe(&self, raster: Raster) -> Raster {
        let numbers = if self.bare { Numbers::Bare } else { Numbers::Scaled };
        Raster { scale: Some((self.scale.low, self.scale.high)), numbers, ..raster }
    }
}
