//! Blobs as files.

use super::{Blob, Entry, Fill, FillGroup, Keep, Spool, Storage};
use crate::atomic::{remove_leftovers, write_atomically, write_folder_atomically};
use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A folder whose files are the blobs, and whose folders are the groups.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// When the disk was last flushed by a thrifty writer, and the time that took.
    flushed: Mutex<Option<(Instant, Duration)>>,
    /// The folder itself, whatever its name leads to by now.
    held: Option<File>,
}

impl Folder {
    /// The folder at `path`, which need not exist before something is written.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), flushed: Mutex::new(None), held: None }
    }

    /// The folder at `path`, which exists, and no other one: if it is moved away, or another one or a link to one takes its place,
    /// nothing more is written. On Windows none of that can happen as long as it is held: the system refuses to move or remove it. On
    /// systems that have neither, as [`Folder::new`].
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn held(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        let name = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
        let held = hold(name).map_err(Error::io(&path, "use the folder"))?;
        Ok(Self { held, ..Self::new(path) })
    }

    /// The folder around a file or folder, and the name that this has in it.
    pub fn around(path: &Path) -> (Self, String) {
        let parent = path.parent().unwrap_or(Path::new("")).to_owned();
        match path.file_name().and_then(|n| n.to_str()) {
            Some(name) if parent.join(name) == path => (Self::new(parent), name.to_owned()),
            _ => (Self::new(path), String::new()),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        if name.is_empty() { self.path.clone() } else { self.path.join(name) }
    }

    fn write_thrifty(&self, name: &str, fill: &mut Fill<'_>) -> Result<()> {
        let last = *self.flushed.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_some_and(|(at, cost)| at.elapsed() < 10 * cost) {
            return self.write(name, Keep::Whole, fill);
        }
        let begun = Instant::now();
        self.write(name, Keep::Lasting, fill)?;
        *self.flushed.lock().unwrap_or_else(PoisonError::into_inner) = Some((Instant::now(), begun.elapsed()));
        Ok(())
    }
}

impl Storage for Folder {
    fn place(&self, name: &str) -> PathBuf {
        self.path(name)
    }

    fn check(&self) -> Result<()> {
        match &self.held {
            Some(held) if !is_at(held, &self.path) => Err(Error::format(
                &self.path,
                "the folder was moved, removed or replaced while a run was writing to it",
                "what the run had written is where the folder is now: continue it there",
            )),
            _ => Ok(()),
        }
    }

    fn open(&self, name: &str) -> io::Result<Blob> {
        let path = self.path(name);
        let metadata = fs::metadata(&path)?;
        if !metadata.is_file() {
            // A pipe could wait for ever.
            return Err(io::Error::new(ErrorKind::InvalidInput, "this is no ordinary file"));
        }
        let input = BufReader::with_capacity(1 << 18, File::open(&path)?);
        Ok(Blob { input: Box::new(input), bytes: metadata.len() })
    }

    fn bytes(&self, name: &str) -> Option<u64> {
        fs::metadata(self.path(name)).ok().filter(fs::Metadata::is_file).map(|m| m.len())
    }

    fn is_group(&self, name: &str) -> bool {
        self.path(name).is_dir()
    }

    fn make_group(&self, name: &str) -> Result<()> {
        self.check()?;
        let path = self.path(name);
        fs::create_dir_all(&path).map_err(Error::io(&path, "make the folder"))
    }

    fn write(&self, name: &str, keep: Keep, fill: &mut Fill<'_>) -> Result<()> {
        self.check()?;
        let path = self.path(name);
        match keep {
            Keep::Lasting => write_atomically(&path, |out| fill(out)),
            Keep::Thrifty => self.write_thrifty(name, fill),
            Keep::Whole => {
                let new = path.with_file_name(".new");
                write_file(&new, fill)?;
                fs::rename(&new, &path).map_err(Error::io(&path, "write"))
            }
            Keep::Loose => write_file(&path, fill),
        }
    }

    fn write_group(&self, name: &str, mark: &str, fill: &mut FillGroup<'_>) -> Result<()> {
        self.check()?;
        write_folder_atomically(&self.path(name), mark, |folder| {
            fill(&|piece, bytes| write_piece(&folder.join(piece), bytes))
        })
    }

    fn spool(&self) -> io::Result<Box<dyn Spool>> {
        let path = if self.path.as_os_str().is_empty() { Path::new(".") } else { &self.path };
        Ok(Box::new(tempfile::tempfile_in(path)?))
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        self.check()?;
        let (from, to) = (self.path(from), self.path(to));
        fs::rename(from, &to).map_err(Error::io(&to, "rename to"))
    }

    fn remove(&self, name: &str) -> Result<()> {
        self.check()?;
        let path = self.path(name);
        let removed = match fs::symlink_metadata(&path) {
            Ok(m) if m.is_dir() => fs::remove_dir_all(&path),
            Ok(_) => fs::remove_file(&path),
            Err(e) => Err(e),
        };
        match removed {
            // Where a part of the name is a file, there is nothing of the whole name either.
            Err(e) if !matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                Err(Error::io(&path, "remove")(e))
            }
            _ => Ok(()),
        }
    }

    fn prune(&self, name: &str) {
        // Of a folder that is not empty the system keeps hold itself.
        let _ = fs::remove_dir(self.path(name));
    }

    fn list(&self, name: &str) -> Vec<Entry> {
        let path = self.path(name);
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
        let entry = |e: fs::DirEntry| {
            // A link to a folder is no group: what is in it is not ours.
            let is_folder = e.file_type().is_ok_and(|t| t.is_dir());
            let bytes = (!is_folder).then(|| e.metadata().map_or(0, |m| m.len()));
            Some(Entry { name: e.file_name().into_string().ok()?, bytes })
        };
        fs::read_dir(path).into_iter().flatten().flatten().filter_map(entry).collect()
    }

    fn tidy(&self, name: &str) {
        remove_leftovers(&self.path(name));
    }
}

/// Opens a folder, so that it can be told from others.
#[cfg(unix)]
fn hold(path: &Path) -> io::Result<Option<File>> {
    File::open(path).map(Some)
}

/// Opens a folder and lets nobody delete it meanwhile, which moving takes, too.
#[cfg(windows)]
fn hold(path: &Path) -> io::Result<Option<File>> {
    use std::os::windows::fs::OpenOptionsExt;
    /// What opening folders takes (`CreateFileW`).
    const FILE_FLAG_BACKUP_SEMANTICS: u32 = 0x0200_0000;
    const FILE_SHARE_READ: u32 = 1;
    const FILE_SHARE_WRITE: u32 = 2;
    let mut options = fs::OpenOptions::new();
    options.read(true).share_mode(FILE_SHARE_READ | FILE_SHARE_WRITE).custom_flags(FILE_FLAG_BACKUP_SEMANTICS);
    options.open(path).map(Some)
}

#[cfg(not(any(unix, windows)))]
fn hold(_path: &Path) -> io::Result<Option<File>> {
    Ok(None)
}

/// True if the name leads to this folder.
#[cfg(unix)]
fn is_at(held: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    match (held.metadata(), fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// True as long as it is held on Windows, where it cannot have gone.
#[cfg(not(unix))]
fn is_at(_held: &File, path: &Path) -> bool {
    path.is_dir()
}

/// Writes a file of a folder that is to be whole, through to the disk.
fn write_piece(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    }
    let write = || -> io::Result<()> {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(Error::io(path, "write"))
}

fn write_file(path: &Path, fill: &mut Fill<'_>) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    }
    let mut out = BufWriter::new(File::create(path).map_err(Error::io(path, "write"))?);
    fill(&mut out)?;
    out.flush().map_err(Error::io(path, "write"))
}
