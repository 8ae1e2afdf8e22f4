//! Writers take rows band by band: the same bytes as from a field, and never many rows at once.

use eyot_core::{Error as CoreError, Field, Result as CoreResult};
use eyot_io::{About, RasterFormat, RowOrder, Rows, WriteOptions, write_rows};
use std::path::{Path, PathBuf};

/// A land that exists only row by row; remembers how much was asked for at once.
struct Made {
    size: (usize, usize),
    most: usize,
    /// Row that cannot be made.
    broken: Option<usize>,
}

fn value(x: usize, y: usize) -> f32 {
    (x as f32 * 0.013).sin() * 300.0 + (y as f32 * 0.021).cos() * 200.0 + ((x * 31 + y * 17) % 13) as f32
}

impl Rows for Made {
    fn size(&self) -> (usize, usize) {
        self.size
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> CoreResult<()> {
        self.most = self.most.max(out.len());
        for (j, row) in out.chunks_exact_mut(self.size.0).enumerate() {
            if self.broken == Some(first + j) {
                return Err(CoreError::Cancelled(std::time::Duration::ZERO));
            }
            row.iter_mut().enumerate().for_each(|(x, v)| *v = value(x, first + j));
        }
        Ok(())
    }
}

/// All files under a folder with their contents.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(f) = folders.pop() {
        for entry in std::fs::read_dir(f).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                all.push((path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap()));
            }
        }
    }
    all.sort();
    all
}

#[test]
fn streams_and_fields_make_the_same_bytes_in_bounded_memory() {
    // Five shards, twenty tiles and several bands high.
    let (w, h) = (3000, 2300);
    let field = Field::from_fn(w, h, value);
    let about = About { name: "height".into(), unit: "m".into(), cell_m: (5.0, 5.0), ..About::default() };
    for format in RasterFormat::ALL {
        for row_order in [RowOrder::NorthFirst, RowOrder::SouthFirst] {
            let options = WriteOptions { row_order, ..WriteOptions::default() };
            let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
            let mut made = Made { size: (w, h), most: 0, broken: None };
            write_rows(&a.path().join("x"), &mut made, &about, format, &options).unwrap();
            write_rows(&b.path().join("x"), &mut &field, &about, format, &options).unwrap();
            assert!(contents(a.path()) == contents(b.path()), "{format:?}");
            // 16 MiB, or the rows of a tile or shard.
            assert!(made.most <= (4 << 20).max(512 * w), "{format:?}: {}", made.most);
        }
    }
}

#[test]
fn a_stream_that_breaks_leaves_nothing() {
    let about = About { name: "height".into(), cell_m: (1.0, 1.0), range: Some((-600.0, 600.0)), ..About::default() };
    for format in RasterFormat::ALL {
        let folder = tempfile::tempdir().unwrap();
        let mut made = Made { size: (700, 900), most: 0, broken: Some(801) };
        let e = write_rows(&folder.path().join("x"), &mut made, &about, format, &WriteOptions::default());
        let e = e.unwrap_err();
        assert!(matches!(e, eyot_io::Error::Core { source: CoreError::Cancelled(_), .. }), "{format:?}: {e}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{format:?}");
    }
}
