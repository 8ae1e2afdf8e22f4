//! The one place that says which crates read, write, draw and analyse.

pub(crate) use {eyot_io as io, eyot_land::analyse, eyot_mesh as mesh, eyot_render as render};

use std::io::Write;
use std::path::Path;

/// Writes a text file, whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> io::Result<()> {
    let fail = |source| io::Error::Io { path: path.to_owned(), action: "write", source };
    io::write_atomically(path, |w| w.write_all(text.as_bytes()).map_err(fail))
}
