//! What the tests of broken files share.
#![allow(unreachable_pub)] // every test file is a crate of its own

use eyot_core::Limits;
use eyot_io::{Raster, ReadOptions, Result, read_raster};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder for hand-made files.
pub struct Fixture(pub TempDir);

impl Fixture {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

pub fn read(path: &Path) -> Result<Raster> {
    read_raster(
        path,
        &ReadOptions { low_m: Some(0.0), high_m: Some(100.0), ..ReadOptions::default() },
        &Limits::default(),
    )
}

/// The error's text, which must name the file.
pub fn refused(path: &Path) -> String {
    let text = read(path).expect_err(&path.display().to_string()).to_string();
    assert!(text.contains(path.file_name().unwrap().to_str().unwrap()), "{text}");
    text
}
