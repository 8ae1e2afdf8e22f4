//! Generators by name.
//!
//! Sources make a field from parameters and a seed; filters change the field that is there. All of them look at metres, not
//! at cells, so that a recipe on a finer grid shows the same land.

use eyot_core::process::{Entry, Generator, Parameters, defaults_of, schema_of};
use eyot_core::{Control, Error, Field, Grid, Result};
use rayon::prelude::*;
use serde_json::Value;
use std::ops::Range;

mod cone;
mod constant;
mod crater;
mod fbm;
pub mod noise;
mod ramp;
mod ridged;
mod smooth;
pub mod warp;

pub use cone::Cone;
pub use constant::Constant;
pub use crater::Crater;
pub use fbm::Fbm;
pub use ramp::Ramp;
pub use ridged::Ridged;
pub use smooth::Smooth;
pub use warp::Warp;

/// All generators that recipes can name.
pub const GENERATORS: &[Entry<dyn Generator>] = &[
    Entry::<dyn Generator>::generator::<Cone>("cone", &[]),
    Entry::<dyn Generator>::generator::<Constant>("constant", &[]),
    Entry::<dyn Generator>::generator::<Crater>("crater", &[]),
    Entry::<dyn Generator>::generator::<Fbm>("fbm", &["perlin1985", "perlin2001", "perlin2002", "ebert2003"]),
    Entry::<dyn Generator>::generator::<Ramp>("ramp", &[]),
    Entry::<dyn Generator>::generator::<Ridged>("ridged", &["musgrave1989", "ebert2003", "perlin2001", "perlin2002"]),
    Entry::<dyn Generator>::generator::<Smooth>("smooth", &[]),
    Entry::<dyn Generator>::generator::<Warp>("warp", &["ebert2003"]),
];

/// Rows that are handed out between two looks at the stop button.
const BAND: usize = 128;

/// Computes rows of a new field in parallel; `row` gets the row's number in the whole grid and its cells, which are 0.
fn fill(
    grid: &Grid,
    window: Range<usize>,
    control: &Control<'_>,
    row: impl Fn(usize, &mut [f32]) + Sync,
) -> Result<Field> {
    let mut field = Field::new(grid.width, window.len(), 0.0);
    let mut rows: Vec<&mut [f32]> = field.rows_mut().collect();
    for (band, rows) in rows.chunks_mut(BAND).enumerate() {
        let first = window.start + band * BAND;
        control.tick((first - window.start) as u64, window.len() as u64)?;
        rows.par_iter_mut().enumerate().for_each(|(y, cells)| row(first + y, cells));
    }
    Ok(field)
}

/// Fails if a parameter is outside the range that its schema gives, or not a number.
///
/// Recipes are checked before they get here; this is for structs that a program filled.
fn check<P: Parameters>(owner: &str, parameters: &P) -> Result<()> {
    let schema = schema_of::<P>();
    let (values, defaults) = (serde_json::to_value(parameters).unwrap_or_default(), defaults_of::<P>());
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return Ok(()) };
    for (field, rule) in properties {
        let (value, default) = (&values[field], &defaults[field]);
        let pairs = match (value.as_array(), default.as_array()) {
            (Some(v), Some(d)) => v.iter().zip(d).map(|(v, d)| (v, d, &rule["items"])).collect(),
            _ => vec![(value, default, rule)],
        };
        for (value, default, rule) in pairs.into_iter().filter(|(_, default, _)| default.is_number()) {
            let low = rule["minimum"].as_f64().unwrap_or(f64::MIN);
            let high = rule["maximum"].as_f64().unwrap_or(f64::MAX);
            // Not-a-numbers become null on the way. A range is written in f64, a parameter may have been rounded to f32.
            let slack = 1e-6 * low.abs().max(high.abs()).min(1.0);
            let fits = value.as_f64().is_some_and(|v| (low - slack..=high + slack).contains(&v));
            if !fits {
                return Err(Error::BadParameter {
                    owner: owner.to_owned(),
                    field: field.clone(),
                    reason: format!("{value} is outside {low}..={high}; the default is {default}"),
                });
            }
        }
    }
    Ok(())
}

/// Size of features: `size_m`, or if that is 0, `share` of the grid's longer side.
fn scale_m(grid: &Grid, share: f32, size_m: f32) -> f64 {
    let (w, h) = grid.extent_m();
    if size_m > 0.0 { f64::from(size_m) } else { f64::from(share) * w.max(h) }
}
