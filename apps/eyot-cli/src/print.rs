//! Output to the standard output that survives a reader who has gone.

use crate::Failure;
use std::borrow::Cow;
use std::io::{ErrorKind, Write};

/// A text as it may reach a terminal: control characters, which names from files and recipes can hold, would move the cursor, change
/// colours or the order of letters. Each becomes a sign of as many bytes, so that places in the text stay where they are.
pub(crate) fn clean(text: &str) -> Cow<'_, str> {
    let harmful = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        c.is_control() && c != '\n' && c != '\t' || turns
    };
    if !text.contains(harmful) {
        return Cow::Borrowed(text);
    }
    let sign = |c: char| match c.len_utf8() {
        _ if !harmful(c) => c,
        1 => '?',
        2 => '\u{bf}',
        _ => '\u{fffd}',
    };
    let (mut out, mut chars) = (String::with_capacity(text.len()), text.chars().peekable());
    while let Some(c) = chars.next() {
        // Lines that end as on Windows are sound.
        let ends = c == '\r' && chars.peek() == Some(&'\n');
        out.push(if ends { c } else { sign(c) });
    }
    Cow::Owned(out)
}

/// Writes text and a line end.
pub(crate) fn line(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{}", clean(text.trim_end_matches('\n'))).and_then(|()| out.flush()) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Err(Failure::Closed),
        Err(e) => {
            Err(Failure::Failed(crate::report::plain(&format!("cannot write to the standard output: {e}"), None)))
        }
    }
}

/// Writes to the standard error; if that is closed nobody is left to tell.
pub(crate) fn note(text: &str) {
    drawn(&clean(text));
}

/// As [`note`], of a text that has colours of our own and else nothing but what is [`clean`].
pub(crate) fn drawn(text: &str) {
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
    fn what_would_steer_a_terminal_becomes_signs_of_as_many_bytes() {
        for sound in ["Eyot\n\tis fine: \u{e9}\u{2192}\u{1f3dd}", ""] {
            assert!(matches!(clean(sound), Cow::Borrowed(s) if s == sound));
        }
        assert_eq!(clean("a\r\nb\r\n"), "a\r\nb\r\n");
        let bad = "a\u{1b}[31mred\u{7}\rb\u{9b}2Jc\u{202e}d\u{7f}";
        let good = clean(bad);
        assert_eq!(good, "a?[31mred??b\u{bf}2Jc\u{fffd}d?");
        assert_eq!(good.len(), bad.len());
    }

    #[test]
    fn cell_sizes_are_short() {
        assert_eq!(cell(10.0, 10.0), "10 m");
        assert_eq!(cell(24.793_388_429_752_067, 30.921_2), "24.79 x 30.92 m");
        assert_eq!(cell(1.25, 1.250_000_000_1), "1.25 m");
        assert_eq!(cell(123_456.7, 0.000_123_456), "123457 x 0.0001235 m");
    }
}
