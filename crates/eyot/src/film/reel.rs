//! A recording that is played for a film.

use super::MOST_FRAMES;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Worded};
use eyot_core::{ComponentKinds, Limits, World};
use eyot_session::RunError;
use eyot_session::timeline::{Damaged, Timeline};
use std::path::Path;
use std::sync::Arc;

/// A recording with its last state.
pub(super) struct Reel {
    timeline: Timeline,
    kinds: ComponentKinds,
    /// The world of its last frame that can be read.
    pub(super) last: World,
    /// The moments of its first and last frame that can be read, in steps.
    span: (u64, u64),
    /// Frames that can not, as far as that is known.
    damaged: Vec<Damaged>,
}

impl Reel {
    /// Opens the recording in the folder of a run.
    ///
    /// # Errors
    /// If there is none, or none of its frames can be read.
    pub(super) fn open(folder: &Path, kinds: &ComponentKinds, limits: &Limits) -> Result<Self, RunError> {
        let timeline = Timeline::open(folder, limits)?;
        let mut damaged = timeline.damaged().to_vec();
        for frame in timeline.frames().iter().rev() {
            match timeline.load(frame.frame, kinds) {
                Ok(last) => {
                    let span = (timeline.frames()[0].steps_done, frame.steps_done);
                    return Ok(Self { last, span, damaged, kinds: kinds.clone(), timeline });
                }
                Err(e) => damaged.push(Damaged { frame: frame.frame, steps_done: frame.steps_done, reason: e.into() }),
            }
        }
        let reason = match damaged.first() {
            Some(d) => remedy![
                format!("the recording in `{}` holds no frame that can be read: ", folder.display()),
                d.sentence(),
            ],
            None => format!("the recording in `{}` holds no frame", folder.display()).into(),
        };
        Err(RunError::refused(reason, "resume its run, or film another one"))
    }

    /// Pictures: one for each frame that there would be if none had been dropped.
    pub(super) fn usual_frames(&self) -> u32 {
        let (first, last) = self.span;
        ((last - first) / self.timeline.record().every + 1).min(u64::from(MOST_FRAMES)) as u32
    }

    pub(super) fn play(&self) -> Playing<'_> {
        Playing { reel: self, shown: None, damaged: self.damaged.clone() }
    }

    /// The place in the list of frames of what a picture shows: moments follow each other evenly, and a single picture shows the end.
    fn frame_at(&self, picture: u32, frames: u32) -> usize {
        let (first, last) = self.span;
        let share = if frames <= 1 { 1.0 } else { f64::from(picture) / f64::from(frames - 1) };
        let moment = first + (share * (last - first) as f64).round() as u64;
        self.timeline.frames().partition_point(|f| f.steps_done <= moment).max(1) - 1
    }
}

/// A recording while it is played.
pub(super) struct Playing<'a> {
    reel: &'a Reel,
    /// The number of the frame that was shown last.
    shown: Option<usize>,
    damaged: Vec<Damaged>,
}

impl Playing<'_> {
    /// The world that a picture shows, unless it is that of the picture before. An earlier frame takes the place of one that cannot be
    /// read, or a later one at the beginning.
    pub(super) fn world_at(&mut self, picture: u32, frames: u32) -> Result<Option<Arc<World>>, RunError> {
        let there = self.reel.timeline.frames();
        let at = self.reel.frame_at(picture, frames);
        for frame in there[..=at].iter().rev().chain(&there[at + 1..]) {
            if self.damaged.iter().any(|d| d.frame == frame.frame) {
                continue;
            }
            if self.shown == Some(frame.frame) {
                return Ok(None);
            }
            match self.reel.timeline.load(frame.frame, &self.reel.kinds) {
                Ok(world) => {
                    self.shown = Some(frame.frame);
                    return Ok(Some(Arc::new(world)));
                }
                Err(e) => {
                    self.damaged.push(Damaged { frame: frame.frame, steps_done: frame.steps_done, reason: e.into() })
                }
            }
        }
        Err(RunError::file("no frame of the recording can be read any more"))
    }

    pub(super) fn notes(mut self) -> Vec<Remedy> {
        self.damaged.sort_by_key(|d| d.frame);
        self.damaged.iter().map(|d| remedy![d.sentence(), "; another frame is shown in its place"]).collect()
    }
}
