//! A video of a film's pictures, made by ffmpeg where it is installed.

use crate::error::RunError;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Which video is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Video {
    /// None.
    None,
    /// `film.mp4`: H.264, for everything.
    #[default]
    Mp4,
    /// `film.webm`: VP9, for web pages.
    Webm,
}

impl Video {
    fn file(self) -> &'static str {
        if self == Self::Webm { "film.webm" } else { "film.mp4" }
    }

    fn codec(self) -> &'static [&'static str] {
        match self {
            Self::Webm => &["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0"],
            _ => &["-c:v", "libx264", "-crf", "17", "-preset", "slow", "-movflags", "+faststart"],
        }
    }
}

/// Makes the video; without ffmpeg, or if that fails, a note says what to do.
///
/// # Errors
/// If the video cannot be put in its place.
pub(super) fn make(
    out: &Path,
    video: Video,
    fps: f32,
    frames: u32,
    notes: &mut Vec<String>,
) -> Result<Option<PathBuf>, RunError> {
    if video == Video::None {
        return Ok(None);
    }
    let (path, half) = (out.join(video.file()), out.join(format!(".part-{}", video.file())));
    let rate = fps.to_string();
    let run = Command::new("ffmpeg")
        .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-framerate", &rate, "-i"])
        .arg(out.join("frame_%05d.png"))
        .args(["-frames:v", &frames.to_string()])
        .args(video.codec())
        // Players want even sides and colours at half the resolution.
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
        .arg(&half)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output();
    let reason = match run {
        Ok(o) if o.status.success() => {
            std::fs::rename(&half, &path).map_err(|source| RunError::Folder { path: path.clone(), source })?;
            return Ok(Some(path));
        }
        Ok(o) => {
            // What is left of a video that failed is of no use; that it cannot be removed matters less than the reason.
            let _ = std::fs::remove_file(&half);
            let text = String::from_utf8_lossy(&o.stderr);
            format!("ffmpeg made no video: {}", text.lines().last().unwrap_or("it does not say why"))
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            "ffmpeg is not installed, so there is no video; install it and give the same command again".to_owned()
        }
        Err(e) => format!("ffmpeg cannot be started, so there is no video: {e}"),
    };
    notes.push(reason);
    Ok(None)
}
