//! Files that exist whole or not at all.

use crate::error::{Error, Result};
use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Large enough that a raster row is one call to the system.
const BUFFER_BYTES: usize = 1 << 18;

/// Names of temporary files begin and end like this.
const PREFIX: &str = ".eyot-";
const SUFFIX: &str = ".tmp";

/// Writes a file so that at every moment, even through a crash or a full disk, `path` is the former file or the whole
/// new one.
///
/// `write` fills a temporary file in the same folder (names start with `.eyot-`); it is then flushed to the disk,
/// renamed to `path`, and the folder is flushed. Nothing is left behind on failure.
///
/// # Errors
/// If the folder does not exist or may not be written to, if `path` is there already but no ordinary file, if the disk
/// is full, or what `write` returns.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let (folder, temporary) = open(path)?;
    // From here on, dropping `name` removes the temporary file.
    let (file, name) = temporary.into_parts();
    // Tells `remove_leftovers` that somebody is at work on it; where there are no locks, nothing is ever removed.
    let _ = file.try_lock();
    let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
    write(&mut out)?;
    let file = out.into_inner().map_err(|e| Error::io(path, "write")(e.into_error()))?;
    file.sync_all().map_err(Error::io(path, "write"))?;
    drop(file);
    name.persist(path).map_err(|e| Error::io(path, "rename the finished file to")(e.error))?;
    sync_folder(folder).map_err(Error::io(folder, "flush the folder"))
}

/// Finds out whether [`write_atomically`] could begin to write `path`, for those who would rather know before their work.
///
/// # Errors
/// As [`write_atomically`] before it writes.
pub fn check_place(path: &Path) -> Result<()> {
    open(path).map(drop)
}

/// The folder of `path` and a new temporary file in it.
fn open(path: &Path) -> Result<(&Path, tempfile::NamedTempFile)> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if path.file_name().is_none() {
        return Err(Error::format(path, "this is not the name of a file", "add a file name"));
    }
    // Renaming onto a device would replace the device: `/dev/null` is a plausible output name.
    if let Ok(there) = fs::metadata(path)
        && !there.is_file()
    {
        let kind = if there.is_dir() { "a folder" } else { "no ordinary file" };
        return Err(Error::format(path, format!("this is {kind} already"), "choose another file name"));
    }
    let temporary = builder().tempfile_in(folder).map_err(|e| Error::io(folder, "write to the folder")(bare(e)))?;
    Ok((folder, temporary))
}

/// As [`write_atomically`] for a folder: `write` fills a temporary folder beside `path`, which then takes its place.
///
/// A former folder is replaced if it holds `mark`, the file that tells what it is; nothing else is ever removed.
pub(crate) fn write_folder_atomically(path: &Path, mark: &str, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let parent = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if path.file_name().is_none() {
        return Err(Error::format(path, "this is not the name of a folder", "add a name"));
    }
    let former = fs::symlink_metadata(path).is_ok();
    if former && !path.join(mark).is_file() {
        let problem = format!("something else is there already, which holds no {mark}");
        return Err(Error::format(path, problem, "choose another name, or remove it first"));
    }
    let temporary = folder_builder(PREFIX, SUFFIX)
        .tempdir_in(parent)
        .map_err(|e| Error::io(parent, "write to the folder")(bare(e)))?;
    // Tells `remove_leftovers` that somebody is at work in it.
    let lock = File::open(temporary.path()).ok();
    let _ = lock.as_ref().map(File::try_lock);
    write(temporary.path()).map_err(|e| e.moved(temporary.path(), path))?;
    // A folder cannot be renamed onto another one: the former steps aside for a moment.
    let aside = match former {
        true => {
            // Not named like a leftover: were this process killed here, the former folder would still be there.
            let aside = folder_builder(".eyot-former-", "").tempdir_in(parent);
            let aside = aside.map_err(|e| Error::io(parent, "write to the folder")(bare(e)))?;
            fs::rename(path, aside.path().join("former")).map_err(Error::io(path, "replace"))?;
            Some(aside)
        }
        false => None,
    };
    if let Err(e) = fs::rename(temporary.path(), path) {
        if let Some(aside) = &aside {
            // The first failure is what is reported; the former folder comes back if it can.
            let _ = fs::rename(aside.path().join("former"), path);
        }
        return Err(Error::io(path, "rename the finished folder to")(e));
    }
    // It has another name now, so there is nothing left to remove.
    let _ = temporary.keep();
    sync_folder(parent).map_err(Error::io(parent, "flush the folder"))
}

/// What the system says, without the temporary name that `tempfile` adds: nobody asked for a file of that name.
fn bare(e: io::Error) -> io::Error {
    let text = e.to_string();
    io::Error::new(e.kind(), text.split(" at path ").next().unwrap_or_default())
}

fn folder_builder(prefix: &'static str, suffix: &'static str) -> tempfile::Builder<'static, 'static> {
    let mut b = tempfile::Builder::new();
    b.prefix(prefix).suffix(suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        b.permissions(fs::Permissions::from_mode(0o777));
    }
    b
}

/// Removes temporary files of [`write_atomically`] whose writer was killed. A file that is still being written is locked by
/// its writer and stays.
pub fn remove_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|n| n.starts_with(PREFIX) && n.ends_with(SUFFIX));
        if !ours {
            continue;
        }
        let (path, kind) = (entry.path(), entry.file_type());
        if kind.as_ref().is_ok_and(fs::FileType::is_dir) {
            if File::open(&path).is_ok_and(|f| f.try_lock().is_ok()) {
                let _ = fs::remove_dir_all(&path);
            }
        } else if kind.is_ok_and(|t| t.is_file())
            && File::options().write(true).open(&path).is_ok_and(|f| f.try_lock().is_ok())
        {
            // What cannot be removed is in nobody's way either.
            let _ = fs::remove_file(&path);
        }
    }
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut b = tempfile::Builder::new();
    b.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Temporary files are private by default, results are not; the system still applies the user's umask.
        b.permissions(fs::Permissions::from_mode(0o666));
    }
    b
}

/// Makes the rename itself durable. Not every file system lets a folder be flushed; those that do not need no flush or
/// offer none.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    match File::open(folder).and_then(|f| f.sync_all()) {
        Err(e)
            if matches!(
                e.kind(),
                io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// Writes `bytes` with the error that names `path`.
pub(crate) fn put(out: &mut (impl Write + ?Sized), path: &Path, bytes: &[u8]) -> Result<()> {
    out.write_all(bytes).map_err(Error::io(path, "write"))
}

/// Runs an encoder of another crate on `out`. Some wrap the system's errors until nobody can tell a full disk from a bad
/// image; here, the first refusal of the system wins over whatever the encoder makes of it.
pub(crate) fn watched<W: Write + ?Sized>(
    out: &mut W,
    path: &Path,
    encode: impl FnOnce(Watched<'_, W>) -> Result<()>,
) -> Result<()> {
    let refusal = Cell::new(None);
    let result = encode(Watched { out, refusal: &refusal });
    match (result, refusal.take()) {
        (Err(_), Some(e)) => Err(Error::io(path, "write")(e)),
        (result, _) => result,
    }
}

/// A writer that remembers why it failed; see [`watched`].
pub(crate) struct Watched<'a, W: ?Sized> {
    out: &'a mut W,
    refusal: &'a Cell<Option<io::Error>>,
}

impl<W: ?Sized> Watched<'_, W> {
    fn remember<T>(&self, result: io::Result<T>) -> io::Result<T> {
        if let Err(e) = &result
            && e.kind() != io::ErrorKind::Interrupted
        {
            let copy =
                e.raw_os_error().map_or_else(|| io::Error::new(e.kind(), e.to_string()), io::Error::from_raw_os_error);
            self.refusal.set(Some(copy));
        }
        result
    }
}

impl<W: Write + ?Sized> Write for Watched<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.out.write(bytes);
        self.remember(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.out.flush();
        self.remember(result)
    }
}

impl<W: Seek + ?Sized> Seek for Watched<'_, W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let result = self.out.seek(to);
        self.remember(result)
    }
}

/// The 4-byte little-endian form of a row, in `buffer`.
pub(crate) fn row_bytes<'a>(row: &[f32], buffer: &'a mut Vec<u8>) -> &'a [u8] {
    buffer.clear();
    buffer.extend(row.iter().flat_map(|v| v.to_le_bytes()));
    buffer
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn replaces_the_whole_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        for content in [&b"the first, longer content"[..], b"second"] {
            write_atomically(&path, |f| put(f, &path, content)).unwrap();
            assert_eq!(fs::read(&path).unwrap(), content);
        }
        assert_eq!(names(folder.path()), ["a.bin"]);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(mode & 0o400, 0o400);
        }
    }

    #[test]
    fn files_of_killed_writers_are_removed_and_those_at_work_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        for name in [".eyot-dead.tmp", ".eyot-other", "mine.tmp"] {
            fs::write(folder.path().join(name), b"x").unwrap();
        }
        write_atomically(&path, |f| {
            remove_leftovers(folder.path());
            put(f, &path, b"whole")
        })
        .unwrap();
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, [".eyot-other", "a.bin", "mine.tmp"]);
    }

    #[test]
    fn a_failing_writer_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, b"former").unwrap();
        let e = write_atomically(&path, |f| {
            put(f, &path, &[1; 1 << 20])?;
            Err(Error::format(&path, "made up", "none"))
        });
        assert!(e.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"former");
        assert_eq!(names(folder.path()), ["a.bin"]);
        // Also when the writer panics: the guard of the temporary file runs on unwinding.
        let panicked = std::panic::catch_unwind(|| write_atomically(&path, |_| panic!("on purpose")));
        assert!(panicked.is_err());
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn missing_folders_folders_and_devices_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let e = write_atomically(&folder.path().join("none/a.bin"), |_| Ok(())).unwrap_err().to_string();
        assert!(e.contains("none") && e.contains("make its folder"), "{e}");
        let e = write_atomically(folder.path(), |_| Ok(())).unwrap_err().to_string();
        assert!(e.contains("a folder already"), "{e}");
        #[cfg(unix)]
        {
            let e = write_atomically(Path::new("/dev/null"), |_| Ok(())).unwrap_err().to_string();
            assert!(e.contains("no ordinary file"), "{e}");
            assert!(write_atomically(Path::new("/"), |_| Ok(())).is_err());
        }
    }

    #[test]
    fn what_fails_in_a_temporary_folder_is_named_by_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.zarr");
        let e = write_folder_atomically(&path, "mark", |temporary| {
            Err(Error::io(&temporary.join("height/c"), "write")(io::ErrorKind::StorageFull.into()))
        });
        assert_eq!(e.unwrap_err().path(), path.join("height/c"));
        assert_eq!(names(folder.path()), [""; 0]);
    }

    /// `/dev/full` fails every write like a full disk; the wording is what users see.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_called_one() {
        let path = Path::new("height.tif");
        let mut full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let e = put(&mut full, path, b"x").unwrap_err().to_string();
        assert!(e.contains("height.tif") && e.contains("make room"), "{e}");
        let mut full = BufWriter::new(full);
        let hidden = watched(&mut full, path, |mut w| {
            let wrapped = w.write_all(&[0; 1 << 16]).map_err(|_| Error::format(path, "bad image", ""));
            wrapped.and_then(|()| w.flush().map_err(|_| Error::format(path, "bad image", "")))
        });
        let e = hidden.unwrap_err().to_string();
        assert!(e.contains("make room"), "{e}");
        // What is left in the buffer cannot be written either; not even on dropping.
        let _ = full.into_parts();
    }

    /// A folder that nobody may write to, root included; skipped where there is no such folder.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_read_only_folder_is_called_one() {
        let e = write_atomically(Path::new("/proc/eyot.bin"), |_| Ok(())).unwrap_err().to_string();
        assert!(e.contains("/proc"), "{e}");
    }
}
