//! Where a file comes from: a path, a blob of a storage, or any reader.

use crate::error::{Error, Result};
use crate::storage::{ReadSeek, Storage};
use crate::target::Spot;
use std::fs::{self, File};
use std::io::SeekFrom;
use std::path::{Path, PathBuf};

/// Where a file comes from. Whatever reads one takes `impl Into<Input>`: a path, a name in a [`Storage`], or a reader.
///
/// Files that lie beside it (`NAME.json`, `NAME.tif.msk`) are found at paths and in storages; a reader has the one file alone.
///
/// ```
/// use eyot_core::Limits;
/// use eyot_io::{read_rgb_png, write_rgb_png};
/// use std::io::Cursor;
///
/// # fn main() -> eyot_io::Result<()> {
/// let mut bytes = Vec::new();
/// write_rgb_png(&mut bytes, 2, 1, &[[255, 0, 0], [0, 0, 255]])?;
/// let (width, height, pixels) = read_rgb_png(&mut Cursor::new(bytes), &Limits::default())?;
/// assert_eq!((width, height, pixels[1]), (2, 1, [0, 0, 255]));
/// # Ok(())
/// # }
/// ```
pub struct Input<'a> {
    at: At<'a>,
    stream: Option<&'a mut dyn ReadSeek>,
}

/// Where an input lies, and what is beside it.
pub(crate) struct At<'a> {
    /// What people may call it, for messages; the path, if it is one.
    pub(crate) place: PathBuf,
    /// Nothing for readers.
    pub(crate) spot: Option<Spot<'a>>,
}

/// An input that is open, at its first byte.
pub(crate) struct Opened<'a> {
    pub(crate) at: At<'a>,
    pub(crate) input: Box<dyn ReadSeek + 'a>,
    pub(crate) bytes: u64,
}

impl<'a> Input<'a> {
    /// A blob of a storage.
    pub fn blob(storage: &'a dyn Storage, name: &'a str) -> Self {
        Self { at: At { place: storage.place(name), spot: Some(Spot::Blob(storage, name)) }, stream: None }
    }

    /// What people may call it, for messages; the path, if it is one.
    pub fn place(&self) -> &Path {
        &self.at.place
    }

    /// The path, if it is one.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.at.path()
    }

    pub(crate) fn open(self) -> Result<Opened<'a>> {
        let at = self.at;
        let fail = || Error::io(&at.place, "read");
        let (input, bytes): (Box<dyn ReadSeek + 'a>, u64) = match (&at.spot, self.stream) {
            (Some(Spot::File(..)), _) => {
                let file = open_ordinary(&at.place)?;
                let bytes = file.metadata().map_err(fail())?.len();
                (Box::new(file), bytes)
            }
            (Some(Spot::Blob(storage, name)), _) => {
                let blob = storage.open(name).map_err(fail())?;
                (blob.input, blob.bytes)
            }
            (None, Some(stream)) => {
                let bytes = stream.seek(SeekFrom::End(0)).map_err(fail())?;
                stream.rewind().map_err(fail())?;
                (Box::new(stream), bytes)
            }
            (None, None) => return Err(Error::format(&at.place, "there is nothing to read", "name a file")),
        };
        Ok(Opened { at, input, bytes })
    }
}

impl At<'_> {
    pub(crate) fn path(&self) -> Option<&Path> {
        matches!(self.spot, Some(Spot::File(..))).then_some(&*self.place)
    }

    /// Storage and name of the file beside it whose name ends like this, if there is one.
    pub(crate) fn beside(&self, ending: &str) -> Option<(&dyn Storage, String)> {
        let (storage, name) = self.spot.as_ref()?.get();
        let name = format!("{name}{ending}");
        storage.bytes(&name).map(|_| (storage, name))
    }
}

/// Opens a file, and nothing else: a pipe could wait for ever, a device give bytes without end.
fn open_ordinary(path: &Path) -> Result<File> {
    let metadata = fs::metadata(path).map_err(Error::io(path, "read"))?;
    if !metadata.is_file() {
        return Err(Error::format(path, "this is no ordinary file", "copy its content to a file first"));
    }
    File::open(path).map_err(Error::io(path, "read"))
}

impl From<&Path> for Input<'_> {
    fn from(path: &Path) -> Self {
        Self { at: At { place: path.to_owned(), spot: Some(Spot::file(path)) }, stream: None }
    }
}

impl From<&PathBuf> for Input<'_> {
    fn from(path: &PathBuf) -> Self {
        Self::from(path.as_path())
    }
}

impl<'a, S: Storage> From<(&'a S, &'a str)> for Input<'a> {
    fn from((storage, name): (&'a S, &'a str)) -> Self {
        Self::blob(storage, name)
    }
}

impl<'a, R: ReadSeek> From<&'a mut R> for Input<'a> {
    fn from(input: &'a mut R) -> Self {
        Self { at: At { place: PathBuf::from("input"), spot: None }, stream: Some(input) }
    }
}
