//! One set of limits that every generator and importer meets before it allocates.

use crate::error::{Error, Result};
use crate::remedy;
use crate::remedy::Setting;

/// Steps that a world can have done: far more than any recipe can ask for, and few enough for exact arithmetic with them.
pub const MAX_STEP: u64 = 1 << 48;

/// Upper bounds on what one world may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Cells of a grid.
    pub max_cells: u64,
    /// Bytes that a single request may allocate.
    pub max_bytes: u64,
    /// Vertices of a mesh.
    pub max_vertices: u64,
    /// Layers of a world.
    pub max_layers: usize,
    /// Steps of one recipe entry.
    pub max_steps: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_cells: 1 << 30,
            max_bytes: 16 << 30,
            max_vertices: 1 << 28,
            max_layers: 256,
            max_steps: 1_000_000_000,
        }
    }
}

impl Limits {
    /// Checks a grid's size.
    ///
    /// # Errors
    /// If `width * height` exceeds [`Limits::max_cells`].
    pub fn check_cells(&self, width: usize, height: usize) -> Result<()> {
        let cells = width as u128 * height as u128;
        if cells > u128::from(self.max_cells) {
            return Err(Error::Limit {
                what: format!("a grid of {width} x {height}"),
                needed: format!("{cells} cells"),
                limit: format!("{} cells", self.max_cells),
                remedy: "choose fewer cells or larger ones".into(),
            });
        }
        Ok(())
    }

    /// Checks an allocation.
    ///
    /// # Errors
    /// If `bytes` exceeds [`Limits::max_bytes`].
    pub fn check_bytes(&self, what: &str, bytes: u128) -> Result<()> {
        if bytes > u128::from(self.max_bytes) {
            let mut amounts = [bytes, u128::from(self.max_bytes)].map(amount);
            if amounts[0] == amounts[1] {
                amounts = [bytes, u128::from(self.max_bytes)].map(|n| format!("{n} bytes"));
            }
            let [needed, limit] = amounts;
            return Err(Error::Limit {
                what: what.to_owned(),
                needed,
                limit,
                remedy: remedy!["choose a smaller grid, fewer layers, or raise the limit with ", Setting::MaxMemory],
            });
        }
        Ok(())
    }
}

/// Bytes in the largest unit that is not too large for them, to a tenth.
fn amount(bytes: u128) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let unit = (0..units.len()).rfind(|i| bytes >> (10 * i) > 0).unwrap_or(0);
    if unit == 0 {
        return if bytes == 1 { "1 byte".to_owned() } else { format!("{bytes} bytes") };
    }
    format!("{:.1} {}", bytes as f64 / 1024_f64.powi(unit as i32), units[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_never_nothing() {
        assert_eq!((amount(1).as_str(), amount(1023).as_str()), ("1 byte", "1023 bytes"));
        assert_eq!(amount(1024), "1.0 KiB");
        assert_eq!(amount(3 << 19), "1.5 MiB");
        assert_eq!(amount(40 << 30), "40.0 GiB");
        let limits = Limits { max_bytes: 1000, ..Limits::default() };
        let e = limits.check_bytes("a thing", 1536).unwrap_err().to_string();
        assert!(e.contains("needs 1.5 KiB, the limit is 1000 bytes"), "{e}");
        let limits = Limits { max_bytes: 4096, ..Limits::default() };
        let e = limits.check_bytes("a thing", 4097).unwrap_err().to_string();
        assert!(e.contains("needs 4097 bytes, the limit is 4096 bytes"), "{e}");
    }
}
