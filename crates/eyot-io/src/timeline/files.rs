//! The blobs of a recording: which belong to which frame, and how they come and go.

use super::{HEADS, Timeline};
use crate::error::{Error, Result};
use crate::head::HeadFile;
use crate::storage::{Entry, Keep, Storage, within};
use crate::zarr::METADATA;
use std::io;

/// Group of an array's pieces.
const PIECES: &str = "c";

impl Timeline {
    /// The group of frame `i` in the array `name`.
    pub(super) fn pieces(&self, name: &str, i: usize) -> String {
        self.name(&format!("{name}/{PIECES}/{i}"))
    }

    /// Bytes of the blobs of frame `i`.
    pub(super) fn frame_bytes(&self, i: usize) -> u64 {
        let head = self.storage.bytes(&self.head_name(i)).unwrap_or(0);
        let pieces = self.arrays.keys().map(|name| bytes_within(&*self.storage, &self.pieces(name, i)));
        head + pieces.sum::<u64>()
    }

    /// Bytes of the first `n` frames; `None` for those without a head. Looks at what is there, whatever `n` claims.
    pub(super) fn measure(&self, n: usize) -> Vec<Option<u64>> {
        let mut sizes = vec![None; n];
        for Entry { name, bytes } in self.storage.list(&self.name(HEADS)) {
            if let Some(size) = number(&name).filter(|_| name.ends_with(".eyot")).and_then(|i| sizes.get_mut(i)) {
                *size = bytes;
            }
        }
        for array in self.arrays.keys() {
            let pieces = self.name(&within(array, PIECES));
            for piece in self.storage.list(&pieces).iter().filter(|e| e.bytes.is_none()) {
                if let Some(Some(size)) = number(&piece.name).and_then(|i| sizes.get_mut(i)) {
                    *size += bytes_within(&*self.storage, &within(&pieces, &piece.name));
                }
            }
        }
        sizes
    }

    /// Removes frame `i`, its head first.
    pub(super) fn remove_frame(&self, i: usize) -> Result<()> {
        self.storage.remove(&self.head_name(i))?;
        self.arrays.keys().try_for_each(|name| self.storage.remove(&self.pieces(name, i)))
    }

    /// Gives frame `i`, which is of `step`, the number `to`, which is free. Its head goes last: what has a head is in its place.
    /// A frame without a head of that step is none: nothing of it moves.
    pub(super) fn move_frame(&self, i: usize, step: u64, to: usize) -> Result<()> {
        let is_here = |name: &str| HeadFile::open_in(&*self.storage, name).is_ok_and(|file| file.head.step == step);
        let (head, done) = (self.head_name(i), self.head_name(to));
        if is_here(&done) || !is_here(&head) {
            return Ok(());
        }
        for name in self.arrays.keys() {
            let (from, to) = (self.pieces(name, i), self.pieces(name, to));
            if self.storage.is_group(&from) {
                // What is there is of a frame without a head.
                self.storage.remove(&to)?;
                self.storage.rename(&from, &to)?;
            }
        }
        self.storage.rename(&head, &done)
    }

    /// Removes all that belongs to frames from number `n` on, also in arrays that no visible frame has.
    pub(super) fn remove_from(&self, n: usize) -> Result<()> {
        let late = |e: &Entry| number(&e.name).is_some_and(|i| i >= n);
        for head in self.storage.list(&self.name(HEADS)).iter().filter(|e| e.bytes.is_some() && late(e)) {
            self.storage.remove(&self.name(&within(HEADS, &head.name)))?;
        }
        for array in self.storage.list(&self.group).iter().filter(|e| e.bytes.is_none()) {
            let group = self.name(&array.name);
            let pieces = within(&group, PIECES);
            for piece in self.storage.list(&pieces).iter().filter(|e| e.bytes.is_none() && late(e)) {
                self.storage.remove(&within(&pieces, &piece.name))?;
            }
            if array.name != HEADS && !self.arrays.contains_key(&array.name) {
                // The array of a layer whose first frame never was; if it is anything else it is not empty and stays.
                self.storage.prune(&pieces);
                if self.storage.list(&group).iter().all(|e| e.name == METADATA) {
                    self.storage.remove(&within(&group, METADATA))?;
                    self.storage.prune(&group);
                }
            }
        }
        Ok(())
    }

    /// Puts a small blob in the place of another one. A kill leaves one of them whole.
    pub(super) fn swap(&self, name: &str, keep: Keep, bytes: &[u8]) -> Result<()> {
        crate::storage::write_bytes(&*self.storage, &self.name(name), keep, bytes)
    }

    /// Copies an array into another recording: coordinates whole, of layers the first `n` frames.
    pub(super) fn copy_array(&self, name: &str, n: usize, to: &Self) -> Result<()> {
        let pieces = within(name, PIECES);
        // The one number of a place has no dimensions and no group.
        if self.storage.bytes(&self.name(&pieces)).is_some() {
            return self.copy_blob(&pieces, to);
        }
        for Entry { name, bytes } in self.storage.list(&self.name(&pieces)) {
            let piece = within(&pieces, &name);
            if bytes.is_some() {
                self.copy_blob(&piece, to)?;
            } else if number(&name).is_some_and(|i| i < n) {
                self.copy_group(&piece, to)?;
            }
        }
        Ok(())
    }

    fn copy_group(&self, group: &str, to: &Self) -> Result<()> {
        for Entry { name, bytes } in self.storage.list(&self.name(group)) {
            let name = within(group, &name);
            if bytes.is_some() { self.copy_blob(&name, to) } else { self.copy_group(&name, to) }?;
        }
        Ok(())
    }

    pub(super) fn copy_blob(&self, name: &str, to: &Self) -> Result<()> {
        let place = self.storage.place(&self.name(name));
        let mut blob = self.storage.open(&self.name(name)).map_err(Error::io(&place, "copy"))?;
        to.storage.write(&to.name(name), Keep::Loose, &mut |out| {
            io::copy(&mut blob.input, out).map(drop).map_err(Error::io(&place, "copy"))
        })
    }
}

/// Removes a recording, of which [`HEADS`] is left to the last: it tells what the group is.
pub(super) fn remove_all(storage: &dyn Storage, group: &str) -> Result<()> {
    // Half of a recording must not look like one.
    storage.remove(&within(group, METADATA))?;
    for entry in storage.list(group).iter().filter(|e| e.name != HEADS) {
        storage.remove(&within(group, &entry.name))?;
    }
    storage.remove(group)
}

/// The number that a blob or group is named by.
fn number(name: &str) -> Option<usize> {
    name.split('.').next()?.parse().ok()
}

/// Bytes of all blobs of a group.
fn bytes_within(storage: &dyn Storage, group: &str) -> u64 {
    let bytes = |e: Entry| e.bytes.unwrap_or_else(|| bytes_within(storage, &within(group, &e.name)));
    storage.list(group).into_iter().map(bytes).sum()
}
