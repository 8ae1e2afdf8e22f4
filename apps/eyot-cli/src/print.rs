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
