//! Masks and weights of ground materials as 8-bit pictures for game engines and renderers.

use crate::error::{Error, Result};
use crate::png_write::write_data_png;
use crate::rows::{Rows, read_band};
use crate::target::Target;
use serde_json::json;

/// Writes a mask as grey PNG, one byte a cell: 0 for 0 and 255 for 1.
///
/// # Errors
/// If `rows` fail or give a value that is not from 0 to 1, or if the file cannot be written.
pub fn write_mask<'a>(to: impl Into<Target<'a>>, rows: &mut dyn Rows) -> Result<()> {
    let to = to.into();
    let path = to.place();
    let size = rows.size();
    let mut values = Vec::new();
    write_data_png::<1>(&to, size, &mut |first, out| {
        values.resize(out.len(), 0.0);
        read_band(path, rows, first, &mut values)?;
        if let Some(i) = values.iter().position(|v| !(0.0..=1.0).contains(v)) {
            let problem = format!("the value {} at column {}, row {}", values[i], i % size.0, first + i / size.0);
            return Err(Error::format(path, problem, "a mask holds those from 0 to 1: export this as geotiff or map"));
        }
        out.iter_mut().zip(&values).for_each(|(o, v)| *o = [(v * 255.0).round() as u8]);
        Ok(())
    })
}

/// Puts the weights of whole rows, from the given one (0 is north) on, into a slice.
pub type Weights<'a> = dyn FnMut(usize, &mut [[u8; 4]]) -> eyot_core::Result<()> + 'a;

/// Writes the weights of up to four materials as the red, green, blue and alpha of a PNG, and their names as JSON beside
/// it (`PATH.json`). Alpha is a weight like the others: programs must not multiply the colours with it.
///
/// # Errors
/// If a side is 0, if `weights` fail or do not sum to 255 in a cell, if there are no or more than four names, or if a file
/// cannot be written.
pub fn write_splat<'a>(
    to: impl Into<Target<'a>>,
    (width, height): (usize, usize),
    materials: &[&str],
    weights: &mut Weights<'_>,
) -> Result<()> {
    let to = to.into();
    let path = to.place();
    if materials.is_empty() || materials.len() > 4 {
        let problem = format!("{} materials are to be written", materials.len());
        return Err(Error::format(path, problem, "a picture holds one to four"));
    }
    write_data_png::<4>(&to, (width, height), &mut |first, out| {
        weights(first, out).map_err(Error::core(path))?;
        match out.iter().find(|w| w.iter().map(|&v| u32::from(v)).sum::<u32>() != 255) {
            None => Ok(()),
            Some(w) => {
                let problem = format!("the weights {w:?} do not sum to 255");
                Err(Error::format(path, problem, "make them with eyot_io::shares"))
            }
        }
    })?;
    let channels: serde_json::Map<_, _> =
        ["red", "green", "blue", "alpha"].iter().zip(materials).map(|(c, m)| ((*c).to_owned(), json!(m))).collect();
    let legend = json!({
        "format": "splat",
        "width": width,
        "height": height,
        "row_order": "north to south",
        "channels": channels,
        "sum": 255,
    });
    to.write_beside(&format!("{legend:#}\n"))
}

/// Weights as bytes that sum to exactly 255, by the largest remainder: each differs from its exact share by less than one.
/// Weights that are negative or not finite count as zero; if none is left, the first material takes all.
pub fn shares(weights: [f32; 4]) -> [u8; 4] {
    let weights = weights.map(|w| if w.is_finite() { f64::from(w.max(0.0)) } else { 0.0 });
    let sum: f64 = weights.iter().sum();
    if sum <= 0.0 {
        return [255, 0, 0, 0];
    }
    let exact = weights.map(|w| w / sum * 255.0);
    let mut bytes = exact.map(|w| w.floor() as u8);
    let left = 255 - bytes.iter().map(|&b| usize::from(b)).sum::<usize>();
    let mut order = [0, 1, 2, 3];
    // Stable: of equal remainders, the earlier material's comes first.
    order.sort_by(|&a, &b| exact[b].fract().total_cmp(&exact[a].fract()));
    for &i in order.iter().cycle().take(left) {
        bytes[i] += 1;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn shares_of_known_weights() {
        assert_eq!(shares([1.0, 0.0, 0.0, 0.0]), [255, 0, 0, 0]);
        assert_eq!(shares([1.0, 1.0, 1.0, 1.0]), [64, 64, 64, 63]);
        assert_eq!(shares([0.0, 0.5, 0.0, 0.5]), [0, 128, 0, 127]);
        assert_eq!(shares([0.0; 4]), [255, 0, 0, 0]);
        assert_eq!(shares([f32::NAN, -3.0, 2.0, f32::INFINITY]), [0, 0, 255, 0]);
    }

    proptest! {
        #[test]
        fn shares_sum_to_255_and_are_close(w in prop::array::uniform4(0.0f32..1e6)) {
            let s = shares(w);
            prop_assert_eq!(s.iter().map(|&v| u32::from(v)).sum::<u32>(), 255);
            let sum: f64 = w.iter().map(|&v| f64::from(v)).sum();
            for (byte, weight) in s.iter().zip(w).filter(|_| sum > 0.0) {
                prop_assert!((f64::from(*byte) - f64::from(weight) / sum * 255.0).abs() < 1.0);
            }
        }
    }
}
