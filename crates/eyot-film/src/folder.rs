//! The folder of a film.

use eyot_core::remedy;
use eyot_core::remedy::Setting;
use eyot_session::{RunError, shell_word};
use serde_json::Value;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What the pictures of a folder show.
const MANIFEST: &str = "film.json";

/// Makes the folder ready: for a new film, or for more of the same.
pub(crate) fn prepare(out: &Path, manifest: &Value, restart: bool) -> Result<(), RunError> {
    let fail = |source| RunError::Folder { path: out.to_owned(), source };
    std::fs::create_dir_all(out).map_err(fail)?;
    let file = out.join(MANIFEST);
    let text = format!("{manifest:#}\n");
    let there = std::fs::read_to_string(&file).ok();
    if there.as_deref() == Some(&*text) {
        return Ok(());
    }
    let mut former: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(out).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if is_frame(&path) {
            former.push(path);
        }
    }
    if !restart && (there.is_some() || !former.is_empty()) {
        let reason = remedy![
            format!("`{}` holds pictures of another film; remove them with ", out.display()),
            Setting::Restart,
            format!(", or choose another folder than {}", shell_word(out)),
        ];
        return Err(RunError::refused(reason, "the same world, path, size and engine go on where they stopped"));
    }
    for path in former {
        std::fs::remove_file(&path).map_err(|source| RunError::Folder { path, source })?;
    }
    eyot_export::write_text(&file, &text).map_err(RunError::file)
}

/// True for a PNG with its beginning and its end: pictures appear whole, but others may have written over them.
pub(crate) fn is_picture(path: &Path) -> bool {
    const BEGINNING: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
    const END: [u8; 8] = *b"IEND\xae\x42\x60\x82";
    let ends = || {
        let mut file = File::open(path)?;
        let (mut first, mut last) = ([0; 8], [0; 8]);
        file.read_exact(&mut first)?;
        file.seek(SeekFrom::End(-8))?;
        file.read_exact(&mut last)?;
        Ok::<_, std::io::Error>((first, last))
    };
    ends().is_ok_and(|found| found == (BEGINNING, END))
}

/// True for the names that films give to their pictures.
fn is_frame(path: &Path) -> bool {
    path.file_name().and_then(|n| n.to_str()).is_some_and(|n| {
        n.strip_prefix("frame_")
            .and_then(|n| n.strip_suffix(".png"))
            .is_some_and(|n| n.len() == 5 && n.bytes().all(|b| b.is_ascii_digit()))
    })
}
