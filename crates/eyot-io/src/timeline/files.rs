//! The files of a recording: which belong to which frame, and how they come and go.

use super::{HEADS, Timeline};
use crate::error::{Error, Result};
use crate::head::HeadFile;
use crate::zarr::{Flush, METADATA, write_piece};
use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Folder of an array's pieces.
const PIECES: &str = "c";

impl Timeline {
    /// The folder of frame `i` in the array `name`.
    pub(super) fn pieces(&self, name: &str, i: usize) -> PathBuf {
        self.path.join(name).join(PIECES).join(i.to_string())
    }

    /// Bytes of the files of frame `i`.
    pub(super) fn frame_bytes(&self, i: usize) -> u64 {
        let head = fs::metadata(self.head_path(i)).map_or(0, |m| m.len());
        head + self.arrays.keys().map(|name| bytes_within(&self.pieces(name, i))).sum::<u64>()
    }

    /// Bytes of the first `n` frames; `None` for those without a head. Looks at what is there, whatever `n` claims.
    pub(super) fn measure(&self, n: usize) -> Vec<Option<u64>> {
        let mut sizes = vec![None; n];
        for head in entries(&self.path.join(HEADS)).filter(|e| e.path().extension() == Some(OsStr::new("eyot"))) {
            if let Some(size) = number(&head.path()).and_then(|i| sizes.get_mut(i)) {
                *size = Some(head.metadata().map_or(0, |m| m.len()));
            }
        }
        for piece in self.arrays.keys().flat_map(|name| entries(&self.path.join(name).join(PIECES))).filter(is_folder) {
            if let Some(Some(size)) = number(&piece.path()).and_then(|i| sizes.get_mut(i)) {
                *size += bytes_within(&piece.path());
            }
        }
        sizes
    }

    /// Removes frame `i`, its head first.
    pub(super) fn remove_frame(&self, i: usize) -> Result<()> {
        remove_file(&self.head_path(i))?;
        for name in self.arrays.keys() {
            let pieces = self.pieces(name, i);
            if pieces.is_dir() {
                fs::remove_dir_all(&pieces).map_err(Error::io(&pieces, "remove"))?;
            }
        }
        Ok(())
    }

    /// Gives frame `i`, which is of `step`, the number `to`, which is free. Its head goes last: what has a head is in its place.
    /// A frame without a head of that step is none: nothing of it moves.
    pub(super) fn move_frame(&self, i: usize, step: u64, to: usize) -> Result<()> {
        let is_here = |path: &Path| HeadFile::open(path).is_ok_and(|file| file.head.step == step);
        let (head, done) = (self.head_path(i), self.head_path(to));
        if is_here(&done) || !is_here(&head) {
            return Ok(());
        }
        for name in self.arrays.keys() {
            let (from, to) = (self.pieces(name, i), self.pieces(name, to));
            if !from.is_dir() {
                continue;
            }
            if to.is_dir() {
                // Of a frame without a head.
                fs::remove_dir_all(&to).map_err(Error::io(&to, "remove"))?;
            }
            fs::rename(&from, &to).map_err(Error::io(&to, "rename the frame to"))?;
        }
        fs::rename(head, &done).map_err(Error::io(&done, "rename the frame to"))
    }

    /// Removes all that belongs to frames from number `n` on, also in arrays that no visible frame has.
    pub(super) fn remove_from(&self, n: usize) -> Result<()> {
        let late = |e: &DirEntry| number(&e.path()).is_some_and(|i| i >= n);
        for head in entries(&self.path.join(HEADS)).filter(late) {
            remove_file(&head.path())?;
        }
        for array in entries(&self.path).filter(is_folder) {
            let pieces = array.path().join(PIECES);
            for piece in entries(&pieces).filter(is_folder).filter(late) {
                fs::remove_dir_all(piece.path()).map_err(Error::io(&pieces, "remove"))?;
            }
            if array.file_name().to_str().is_none_or(|name| name != HEADS && !self.arrays.contains_key(name)) {
                // The array of a layer whose first frame never was; if it is anything else it is not empty and stays.
                let _ = fs::remove_dir(&pieces);
                if entries(&array.path()).all(|e| e.file_name() == METADATA) {
                    remove_file(&array.path().join(METADATA))?;
                    let _ = fs::remove_dir(array.path());
                }
            }
        }
        Ok(())
    }
}

/// Removes the folder of a recording, of which [`HEADS`] is left to the last: it tells what the folder is.
pub(super) fn remove_all(path: &Path) -> Result<()> {
    // Half of a recording must not look like one.
    remove_file(&path.join(METADATA))?;
    for entry in entries(path).filter(|e| e.file_name() != HEADS) {
        let (path, folder) = (entry.path(), is_folder(&entry));
        let removed = if folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        removed.map_err(Error::io(&path, "remove"))?;
    }
    fs::remove_dir_all(path).map_err(Error::io(path, "remove"))
}

/// Puts a small file in the place of another one. A kill leaves one of them whole.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let new = path.with_file_name(".new");
    write_piece(&new, bytes, Flush::No)?;
    fs::rename(&new, path).map_err(Error::io(path, "write"))
}

/// Copies an array: coordinates whole, of layers the first `n` frames.
pub(super) fn copy_array(from: &Path, to: &Path, n: usize) -> Result<()> {
    for entry in entries(&from.join(PIECES)) {
        let to = to.join(PIECES).join(entry.file_name());
        if !is_folder(&entry) {
            copy_file(&entry.path(), &to)?;
        } else if number(&entry.path()).is_some_and(|i| i < n) {
            for row in entries(&entry.path()) {
                for piece in entries(&row.path()) {
                    copy_file(&piece.path(), &to.join(row.file_name()).join(piece.file_name()))?;
                }
            }
        }
    }
    // The one number of a place has no dimensions and no folder.
    let lone = from.join(PIECES);
    if lone.is_file() { copy_file(&lone, &to.join(PIECES)) } else { Ok(()) }
}

pub(super) fn copy_file(from: &Path, to: &Path) -> Result<()> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    }
    fs::copy(from, to).map(drop).map_err(Error::io(from, "copy"))
}

pub(super) fn remove_file(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(Error::io(path, "remove")(e)),
        _ => Ok(()),
    }
}

/// The number that a file or folder is named by.
fn number(path: &Path) -> Option<usize> {
    path.file_stem().and_then(OsStr::to_str)?.parse().ok()
}

/// What is in a folder; nothing if there is none.
fn entries(folder: &Path) -> impl Iterator<Item = DirEntry> + use<> {
    fs::read_dir(folder).into_iter().flatten().flatten()
}

/// True for folders, false for links to them.
fn is_folder(entry: &DirEntry) -> bool {
    entry.file_type().is_ok_and(|t| t.is_dir())
}

/// Bytes of all files of a frame's folder.
fn bytes_within(folder: &Path) -> u64 {
    let bytes = |e: DirEntry| if is_folder(&e) { bytes_within(&e.path()) } else { e.metadata().map_or(0, |m| m.len()) };
    entries(folder).map(bytes).sum()
}
