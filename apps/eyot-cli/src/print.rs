//! Output to the standard output that survives a reader who has gone.

use crate::Failure;
use std::io::{ErrorKind, Write};

/// Writes text and a line end.
pub(crate) fn line(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{}", text.trim_end_matches('\n')).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Err(Failure::Closed),
        Err(e) => {
            Err(Failure::Failed(crate::report::plain(&format!("cannot write to the standard output: {e}"), None)))
        }
    }
}

/// Writes to the standard error; if that is closed nobody is left to tell.
pub(crate) fn note(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// The size of a cell with its unit, to four digits: `10 m`, `24.79 x 30.92 m`.
pub(crate) fn cell(x_m: f64, y_m: f64) -> String {
    let (x, y) = (four(x_m), four(y_m));
    if x == y { format!("{x} m") } else { format!("{x} x {y} m") }
}

fn four(x: f64) -> String {
    if !x.is_finite() || x == 0.0 {
        return x.to_string();
    }
    let places = (3 - x.abs().log10().floor() as i32).clamp(0, 12);
    let text = format!("{x:.0$}", places as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_sizes_are_short() {
        assert_eq!(cell(10.0, 10.0), "10 m");
        assert_eq!(cell(24.793_388_429_752_067, 30.921_2), "24.79 x 30.92 m");
        assert_eq!(cell(1.25, 1.250_000_000_1), "1.25 m");
        assert_eq!(cell(123_456.7, 0.000_123_456), "123457 x 0.0001235 m");
    }
}
