//! A video of a film's pictures, made by ffmpeg where it is installed.

use eyot_core::Control;
use eyot_core::remedy::Remedy;
use eyot_session::RunError;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// How long it may take to hear of a request to stop.
const LOOK_EVERY: Duration = Duration::from_millis(30);

/// Which video is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
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
/// If the video cannot be put in its place, and [`RunError::Stopped`] on a request to stop.
pub(crate) fn make(
    out: &Path,
    video: Video,
    fps: f32,
    frames: u32,
    notes: &mut Vec<Remedy>,
    control: &Control<'_>,
) -> Result<Option<PathBuf>, RunError> {
    if video == Video::None {
        return Ok(None);
    }
    let half = format!(".part-{}", video.file());
    // Run in the folder: a % in its name would be taken for the number of a picture.
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg
        .current_dir(out)
        .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-framerate", &fps.to_string()])
        .args(["-i", "frame_%05d.png", "-frames:v", &frames.to_string()])
        .args(video.codec())
        // Players want even sides and colours at half the resolution.
        .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", &half]);
    let (path, half) = (out.join(video.file()), out.join(half));
    let reason = match finish(ffmpeg, control) {
        Ok(None) => {
            std::fs::rename(&half, &path).map_err(|source| RunError::Folder { path: path.clone(), source })?;
            return Ok(Some(path));
        }
        Ok(Some(words)) => format!("ffmpeg made no video: {}", words.lines().last().unwrap_or("it does not say why")),
        Err(Ended::Stopped) => {
            let _ = std::fs::remove_file(&half);
            return Err(RunError::Stopped);
        }
        Err(Ended::NotBegun(e)) if e.kind() == ErrorKind::NotFound => {
            "ffmpeg is not installed, so there is no video; install it and give the same command again".to_owned()
        }
        Err(Ended::NotBegun(e)) => format!("ffmpeg cannot be started, so there is no video: {e}"),
    };
    // What is left of a video that failed is of no use; that it cannot be removed matters less than the reason.
    let _ = std::fs::remove_file(&half);
    notes.push(reason.into());
    Ok(None)
}

/// Why a program did not come to its own end.
enum Ended {
    NotBegun(std::io::Error),
    Stopped,
}

/// Runs a program until it ends or the film is to stop; `Some` is what it said when it failed.
fn finish(mut program: Command, control: &Control<'_>) -> Result<Option<String>, Ended> {
    let program = program.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = program.spawn().map_err(Ended::NotBegun)?;
    // Read while it works: a program whose words nobody takes stands still.
    let words = child.stderr.take().map(|mut pipe| {
        std::thread::spawn(move || {
            let mut words = Vec::new();
            let _ = pipe.read_to_end(&mut words);
            String::from_utf8_lossy(&words).into_owned()
        })
    });
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if control.check().is_ok() => std::thread::sleep(LOOK_EVERY),
            Ok(None) | Err(_) => {
                // It may have ended by itself in the meantime.
                let _ = child.kill();
                let _ = child.wait();
                return Err(Ended::Stopped);
            }
        }
    };
    let words = words.and_then(|w| w.join().ok()).unwrap_or_default();
    Ok((!status.success()).then_some(words))
}
