//! One run per folder: a lock that the system releases when its owner dies, however it dies.

use crate::error::RunError;
use eyot_core::remedy;
use eyot_core::remedy::Setting;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Name of the lock file in an output folder.
pub(crate) const LOCK_FILE: &str = "eyot.lock";
/// A process number is far shorter; anything longer is no lock.
const MAX_BYTES: u64 = 64;

/// Holds the lock of a folder until it is dropped.
pub(crate) struct FolderLock {
    path: PathBuf,
    file: File,
}

impl FolderLock {
    /// Takes the lock of a folder. A file left behind by a dead process does not hold it; what is no lock of a run is not
    /// touched.
    pub(crate) fn take(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join(LOCK_FILE);
        let fail = |source| RunError::Folder { path: path.clone(), source };
        // The former owner may remove its file between our opening and our locking it: then try again.
        for _ in 0..16 {
            // A link would lead to a file that is not ours to write, a pipe nowhere.
            if std::fs::symlink_metadata(&path).is_ok_and(|m| !m.is_file()) {
                return Err(foreign(&path));
            }
            let mut file =
                OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path).map_err(fail)?;
            let locked = file.try_lock();
            let mut text = String::new();
            // On some systems a file that another process has locked cannot be read, and no number stands in one of letters.
            let read = (&mut file).take(MAX_BYTES).read_to_string(&mut text);
            match locked {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(RunError::Busy { folder: folder.to_owned(), pid: text.trim().parse().ok() });
                }
                // File systems without locks: better an unguarded run than none.
                Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => {}
                Err(TryLockError::Error(e)) => return Err(fail(e)),
            }
            if !same_file(&file, &path) {
                continue;
            }
            if read.is_err() || !text.trim().bytes().all(|b| b.is_ascii_digit()) {
                return Err(foreign(&path));
            }
            // From here on the file goes with its owner, also if the disk is full.
            let mut lock = Self { path: path.clone(), file };
            lock.sign().map_err(fail)?;
            return Ok(lock);
        }
        Err(RunError::Busy { folder: folder.to_owned(), pid: None })
    }

    /// Writes who holds the lock.
    fn sign(&mut self) -> std::io::Result<()> {
        self.file.set_len(0)?;
        self.file.rewind()?;
        writeln!(self.file, "{}", std::process::id())
    }
}

fn foreign(path: &Path) -> RunError {
    RunError::refused(
        format!("`{}` is not the lock of a run", path.display()),
        remedy!["move it away, or choose another folder with ", Setting::Out],
    )
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Nothing depends on the file being gone: without its owner it locks nothing. Where the folder has been replaced, the
        // lock in it is that of another run.
        if same_file(&self.file, &self.path) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

#[cfg(unix)]
fn same_file(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    // Not through a link that has been put there meanwhile.
    match (file.metadata(), std::fs::symlink_metadata(path)) {
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

    #[cfg(unix)]
    #[test]
    fn what_is_no_lock_is_not_touched() {
        let folder = tempfile::tempdir().unwrap();
        let (victim, lock) = (folder.path().join("victim"), folder.path().join(LOCK_FILE));
        std::fs::write(&victim, "4711").unwrap();
        let refused = || matches!(FolderLock::take(folder.path()), Err(RunError::Input { .. }));
        // A link to a file, to nothing, the file itself by another name, and a file of letters.
        std::os::unix::fs::symlink(&victim, &lock).unwrap();
        assert!(refused() && std::fs::read_to_string(&victim).unwrap() == "4711");
        std::fs::remove_file(&lock).unwrap();
        std::os::unix::fs::symlink(folder.path().join("nothing"), &lock).unwrap();
        assert!(refused() && !folder.path().join("nothing").exists());
        std::fs::remove_file(&lock).unwrap();
        std::fs::write(&victim, "precious").unwrap();
        std::fs::hard_link(&victim, &lock).unwrap();
        assert!(refused() && std::fs::read_to_string(&victim).unwrap() == "precious");
        std::fs::remove_file(&lock).unwrap();
        std::fs::create_dir(&lock).unwrap();
        assert!(refused());
    }
}
