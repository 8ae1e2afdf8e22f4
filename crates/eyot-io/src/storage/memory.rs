//! Blobs in memory: for hosts without files, and for tests.

use super::{Blob, Entry, Fill, FillGroup, Keep, Storage, within};
use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Cursor, ErrorKind};
use std::ops::Bound;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Blobs in memory. Clones share them.
#[derive(Clone, Default)]
pub struct Memory(Arc<Mutex<Blobs>>);

type Blobs = BTreeMap<String, Bytes>;

/// The bytes of a blob, shared by those who read it.
#[derive(Clone)]
struct Bytes(Arc<Vec<u8>>);

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Memory {
    /// Without any blob.
    pub fn new() -> Self {
        Self::default()
    }

    /// Names of all blobs, in order.
    pub fn names(&self) -> Vec<String> {
        self.blobs().keys().cloned().collect()
    }

    fn blobs(&self) -> MutexGuard<'_, Blobs> {
        // Every change is one insertion or removal at a time: there is no half of one.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Memory({} blobs)", self.blobs().len())
    }
}

/// Names of a group begin with this.
fn prefix(group: &str) -> String {
    if group.is_empty() { String::new() } else { format!("{group}/") }
}

/// Names of the blobs in a group, however deep.
fn names_in(blobs: &Blobs, group: &str) -> Vec<String> {
    let prefix = prefix(group);
    let from = (Bound::Included(prefix.clone()), Bound::Unbounded);
    blobs.range(from).map(|(name, _)| name.clone()).take_while(|name| name.starts_with(&prefix)).collect()
}

impl Storage for Memory {
    fn place(&self, name: &str) -> PathBuf {
        PathBuf::from(name)
    }

    fn open(&self, name: &str) -> io::Result<Blob> {
        let bytes = self.blobs().get(name).cloned().ok_or(ErrorKind::NotFound)?;
        Ok(Blob { bytes: bytes.0.len() as u64, input: Box::new(Cursor::new(bytes)) })
    }

    fn bytes(&self, name: &str) -> Option<u64> {
        self.blobs().get(name).map(|b| b.0.len() as u64)
    }

    fn is_group(&self, name: &str) -> bool {
        name.is_empty() || !names_in(&self.blobs(), name).is_empty()
    }

    fn make_group(&self, _: &str) -> Result<()> {
        Ok(())
    }

    fn write(&self, name: &str, _: Keep, fill: &mut Fill<'_>) -> Result<()> {
        let mut bytes = Cursor::new(Vec::new());
        fill(&mut bytes)?;
        self.blobs().insert(name.to_owned(), Bytes(Arc::new(bytes.into_inner())));
        Ok(())
    }

    fn write_group(&self, name: &str, mark: &str, fill: &mut FillGroup<'_>) -> Result<()> {
        let former = self.bytes(name).is_some() || self.is_group(name);
        if former && self.bytes(&within(name, mark)).is_none() {
            let problem = format!("something else is there already, which holds no {mark}");
            return Err(Error::format(&self.place(name), problem, "choose another name, or remove it first"));
        }
        let new = Mutex::new(Blobs::new());
        fill(&|piece, bytes| {
            let mut new = new.lock().unwrap_or_else(PoisonError::into_inner);
            new.insert(within(name, piece), Bytes(Arc::new(bytes.to_vec())));
            Ok(())
        })?;
        let mut blobs = self.blobs();
        for name in names_in(&blobs, name) {
            blobs.remove(&name);
        }
        blobs.append(&mut new.into_inner().unwrap_or_else(PoisonError::into_inner));
        Ok(())
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        let mut blobs = self.blobs();
        if let Some(bytes) = blobs.remove(from) {
            blobs.insert(to.to_owned(), bytes);
            return Ok(());
        }
        let names = names_in(&blobs, from);
        if names.is_empty() {
            return Err(Error::io(&self.place(from), "rename")(ErrorKind::NotFound.into()));
        }
        for name in names {
            if let Some(bytes) = blobs.remove(&name) {
                blobs.insert(format!("{to}{}", &name[from.len()..]), bytes);
            }
        }
        Ok(())
    }

    fn remove(&self, name: &str) -> Result<()> {
        let mut blobs = self.blobs();
        blobs.remove(name);
        for name in names_in(&blobs, name) {
            blobs.remove(&name);
        }
        Ok(())
    }

    fn prune(&self, _: &str) {}

    fn list(&self, name: &str) -> Vec<Entry> {
        let (blobs, prefix) = (self.blobs(), prefix(name));
        let mut entries: Vec<Entry> = Vec::new();
        for name in names_in(&blobs, name) {
            let rest = &name[prefix.len()..];
            let entry = match rest.split_once('/') {
                Some((group, _)) => Entry { name: group.to_owned(), bytes: None },
                None => Entry { name: rest.to_owned(), bytes: blobs.get(&name).map(|b| b.0.len() as u64) },
            };
            if entries.last() != Some(&entry) {
                entries.push(entry);
            }
        }
        entries
    }

    fn tidy(&self, _: &str) {}
}
