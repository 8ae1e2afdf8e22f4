//! One run per folder: a lock that the system releases when its owner dies, however it dies.

use crate::error::RunError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Name of the lock file in an output folder.
pub(crate) const LOCK_FILE: &str = "eyot.lock";

/// Holds the lock of a folder until it is dropped.
pub(crate) struct FolderLock {
    path: PathBuf,
    _file: File,
}

impl FolderLock {
    /// Takes the lock of a folder. A file left behind by a dead process does not hold it.
    pub(crate) fn take(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join(LOCK_FILE);
        let fail = |source| RunError::Folder { path: path.clone(), source };
        // The former owner may remove its file between our opening and our locking it: then try again.
        for _ in 0..16 {
            let mut file =
                OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path).map_err(fail)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut pid = String::new();
                    // The pid is only for the message; on some systems a locked file cannot be read.
                    let _ = file.read_to_string(&mut pid);
                    return Err(RunError::Busy { folder: folder.to_owned(), pid: pid.trim().parse().ok() });
                }
                // File systems without locks: better an unguarded run than none.
                Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(e)) => return Err(fail(e)),
            }
            if !same_file(&file, &path) {
                continue;
            }
            file.set_len(0).map_err(fail)?;
            writeln!(file, "{}", std::process::id()).map_err(fail)?;
            return Ok(Self { path, _file: file });
        }
        Err(RunError::Busy { folder: folder.to_owned(), pid: None })
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Nothing depends on the file being gone: without its owner it locks nothing.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(unix)]
fn same_file(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn same_file(_file: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_run_is_refused_and_a_dead_ones_file_is_not_in_the_way() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(LOCK_FILE), "4194304\n").unwrap();
        let first = FolderLock::take(folder.path()).unwrap();
        match FolderLock::take(folder.path()) {
            Err(RunError::Busy { pid, .. }) => assert_eq!(pid, Some(std::process::id())),
            _ => panic!("the folder was locked twice"),
        }
        drop(first);
        assert!(!folder.path().join(LOCK_FILE).exists());
        FolderLock::take(folder.path()).unwrap();
    }
}
