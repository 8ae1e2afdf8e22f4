//! Where a file goes: to a path, to a blob of a storage, or to any writer.

use crate::atomic::put;
use crate::error::{Error, Result};
use crate::storage::{Folder, Keep, Spool, Storage, WriteSeek, write_bytes};
use std::cell::RefCell;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

/// Where a file goes. Whatever writes one takes `impl Into<Target>`: a path, a name in a [`Storage`], or a writer.
///
/// At a path and in a storage a file appears whole or not at all ([`crate::write_atomically`], [`Keep::Lasting`]), and formats that need a
/// second file beside it (`NAME.json`) put it there. A writer gets the one file alone, as far as it comes.
///
/// ```
/// use eyot_io::{storage::{Memory, read_bytes}, write_rgb_png};
///
/// # fn main() -> eyot_io::Result<()> {
/// let mut bytes = Vec::new();
/// write_rgb_png(&mut bytes, 2, 1, &[[255, 0, 0], [0, 0, 255]])?;
/// let memory = Memory::new();
/// write_rgb_png((&memory, "a.png"), 2, 1, &[[255, 0, 0], [0, 0, 255]])?;
/// assert_eq!(read_bytes(&memory, "a.png", 1000)?, bytes);
/// # Ok(())
/// # }
/// ```
pub struct Target<'a> {
    place: PathBuf,
    way: Way<'a>,
}

enum Way<'a> {
    Spot(Spot<'a>),
    Stream(RefCell<&'a mut dyn Write>),
}

/// A name in a storage.
pub(crate) enum Spot<'a> {
    /// What was given as a path.
    File(Folder, String),
    Blob(&'a dyn Storage, &'a str),
}

impl Spot<'_> {
    pub(crate) fn file(path: &Path) -> Self {
        let (folder, name) = Folder::around(path);
        Self::File(folder, name)
    }

    pub(crate) fn get(&self) -> (&dyn Storage, &str) {
        match self {
            Self::File(folder, name) => (folder, name),
            Self::Blob(storage, name) => (*storage, name),
        }
    }
}

impl<'a> Target<'a> {
    /// A blob of a storage.
    pub fn blob(storage: &'a dyn Storage, name: &'a str) -> Self {
        Self { place: storage.place(name), way: Way::Spot(Spot::Blob(storage, name)) }
    }

    /// What people may call it, for messages.
    pub fn place(&self) -> &Path {
        &self.place
    }

    /// The storage and the name in it, unless it is a writer.
    pub(crate) fn storage(&self) -> Option<(&dyn Storage, &str)> {
        match &self.way {
            Way::Spot(spot) => Some(spot.get()),
            Way::Stream(_) => None,
        }
    }

    /// Writes the file from its first to its last byte.
    pub(crate) fn write(&self, fill: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
        match &self.way {
            Way::Stream(out) => fill(&mut **out.borrow_mut()),
            _ => self.write_seeking(|mut out| fill(&mut out)),
        }
    }

    /// Writes a file whose beginning is known last; for a writer it is made in memory.
    pub(crate) fn write_seeking(&self, fill: impl FnOnce(&mut dyn WriteSeek) -> Result<()>) -> Result<()> {
        if let Way::Stream(out) = &self.way {
            let mut bytes = Cursor::new(Vec::new());
            fill(&mut bytes)?;
            return put(&mut **out.borrow_mut(), &self.place, bytes.get_ref());
        }
        let Some((storage, name)) = self.storage() else { return Ok(()) };
        let mut fill = Some(fill);
        storage.write(name, Keep::Lasting, &mut |out| fill.take().map_or(Ok(()), |fill| fill(out)))
    }

    /// Writes the text that says what the file holds, as `NAME.json`.
    pub(crate) fn write_beside(&self, text: &str) -> Result<()> {
        let Some((storage, name)) = self.storage() else { return Ok(()) };
        write_bytes(storage, &format!("{name}.json"), Keep::Lasting, text.as_bytes())
    }

    /// Room for what must wait until it is written.
    pub(crate) fn spool(&self) -> Result<Box<dyn Spool>> {
        let Some((storage, _)) = self.storage() else { return Ok(Box::new(Cursor::new(Vec::new()))) };
        storage.spool().map_err(Error::io(self.folder(), "write temporary data to"))
    }

    /// The folder that it lies in, for messages.
    pub(crate) fn folder(&self) -> &Path {
        self.place.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }
}

/// Writes a text.
///
/// # Errors
/// If it cannot be written.
pub fn write_text<'a>(to: impl Into<Target<'a>>, text: &str) -> Result<()> {
    let to = to.into();
    to.write(|file| put(file, to.place(), text.as_bytes()))
}

impl From<&Path> for Target<'_> {
    fn from(path: &Path) -> Self {
        Self { place: path.to_owned(), way: Way::Spot(Spot::file(path)) }
    }
}

impl From<&PathBuf> for Target<'_> {
    fn from(path: &PathBuf) -> Self {
        Self::from(path.as_path())
    }
}

impl<'a, S: Storage> From<(&'a S, &'a str)> for Target<'a> {
    fn from((storage, name): (&'a S, &'a str)) -> Self {
        Self::blob(storage, name)
    }
}

impl<'a, W: Write> From<&'a mut W> for Target<'a> {
    fn from(out: &'a mut W) -> Self {
        Self { place: PathBuf::from("output"), way: Way::Stream(RefCell::new(out)) }
    }
}
