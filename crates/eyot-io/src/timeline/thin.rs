//! Room for new frames: older ones are dropped, and the others move up, so that arrays stay without gaps.
//!
//! What is to be done is written down first. The root then shows only the frames that keep their numbers, until all is done;
//! a kill at any moment leaves a store that opens, and [`Timeline::finish_thinning`] does the rest.

use super::{Frame, HEADS, Timeline};
use crate::error::{Error, Result};
use crate::storage::{Folder, Keep, Storage, read_bytes, within};
use eyot_core::MAX_STEP;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the file that says what is to be done.
const PLAN: &str = "thinning.json";
/// More frames than a recording has.
pub(super) const MAX_FRAMES: usize = 1 << 20;
/// More than a plan for all of them takes.
const MAX_PLAN_BYTES: u64 = 64 << 20;

/// What is to be done.
#[derive(Debug, Serialize, Deserialize)]
struct Plan {
    /// Frames before.
    frames: usize,
    /// Numbers and steps of the frames that stay, in order.
    keep: Vec<(usize, u64)>,
    /// Whether the others are gone.
    dropped: bool,
}

impl Plan {
    /// Frames that keep their numbers.
    fn unmoved(&self) -> usize {
        self.keep.iter().enumerate().take_while(|(to, (from, _))| to == from).count()
    }

    fn is_sound(&self) -> bool {
        let rising = |w: &[(usize, u64)]| w[0].0 < w[1].0 && w[0].1 < w[1].1;
        self.frames <= MAX_FRAMES
            && self.keep.windows(2).all(rising)
            && self.keep.first().is_some_and(|k| k.0 == 0)
            && self.keep.last().is_some_and(|k| k.0 < self.frames && k.1 <= MAX_STEP)
    }
}

/// True if a killed run had begun to drop frames of this recording: until that is done, it shows only the first ones.
pub fn is_cut_off(path: &Path) -> bool {
    let (storage, group) = Folder::around(path);
    is_cut_off_in(&storage, &group)
}

/// As [`is_cut_off`], in the group of a storage.
pub fn is_cut_off_in(storage: &dyn Storage, group: &str) -> bool {
    storage.bytes(&within(group, &plan_name())).is_some()
}

fn plan_name() -> String {
    within(HEADS, PLAN)
}

impl Timeline {
    /// Drops frames until one more of `most` bytes fits beside `fixed` bytes of other files.
    pub(super) fn make_room(&mut self, most: u64, fixed: u64) -> Result<()> {
        while self.frames.iter().map(|f| f.bytes).sum::<u64>() + most + fixed > self.record.max_bytes {
            if self.frames.len() < 2 {
                let problem = format!(
                    "a bound of {} bytes does not hold two frames of {most} bytes and {fixed} bytes beside them",
                    self.record.max_bytes
                );
                return Err(Error::format(&self.place(""), problem, "raise the bound of the recording"));
            }
            // What is missing holds no room and goes first.
            let whole: Vec<usize> = (0..self.frames.len()).filter(|&i| i == 0 || self.frames[i].is_there).collect();
            let steps: Vec<u64> = whole.iter().map(|&i| self.frames[i].step).collect();
            self.thin(&kept(&steps).into_iter().map(|i| whole[i]).collect::<Vec<_>>())?;
        }
        Ok(())
    }

    fn thin(&mut self, keep: &[usize]) -> Result<()> {
        let keep = keep.iter().map(|&i| (i, self.frames[i].step)).collect();
        let plan = Plan { frames: self.frames.len(), keep, dropped: false };
        self.write_plan(&plan)?;
        self.carry_out(plan)
    }

    /// Does what a killed run had begun.
    pub(super) fn finish_thinning(&mut self) -> Result<()> {
        if self.storage.bytes(&self.name(&plan_name())).is_none() {
            return Ok(());
        }
        let path = self.place(&plan_name());
        let text = read_bytes(&*self.storage, &self.name(&plan_name()), MAX_PLAN_BYTES)?;
        let plan = serde_json::from_slice(&text).ok().filter(Plan::is_sound);
        let plan = plan.ok_or_else(|| Error::format(&path, "this file is damaged", "remove the recording"))?;
        self.carry_out(plan)
    }

    /// Every part can be done again, wherever it was cut off.
    fn carry_out(&mut self, plan: Plan) -> Result<()> {
        let steps: Vec<u64> = plan.keep.iter().map(|k| k.1).collect();
        let unmoved = plan.unmoved();
        self.commit(self.arrays.clone(), &steps[..unmoved])?;
        let plan = if plan.dropped { plan } else { self.drop_frames(plan)? };
        for (to, (from, step)) in plan.keep.iter().enumerate().skip(unmoved) {
            self.move_frame(*from, *step, to)?;
        }
        self.write_times(&steps, 0)?;
        self.commit(self.arrays.clone(), &steps)?;
        let frame = |(i, &step)| Frame {
            step,
            bytes: self.frame_bytes(i),
            is_there: self.storage.bytes(&self.head_name(i)).is_some(),
        };
        self.frames = steps.iter().enumerate().map(frame).collect();
        self.storage.remove(&self.name(&plan_name()))
    }

    fn drop_frames(&mut self, plan: Plan) -> Result<Plan> {
        for i in (0..plan.frames).filter(|i| !plan.keep.iter().any(|k| k.0 == *i)) {
            self.remove_frame(i)?;
        }
        let plan = Plan { dropped: true, ..plan };
        self.write_plan(&plan)?;
        Ok(plan)
    }

    fn write_plan(&self, plan: &Plan) -> Result<()> {
        let text = serde_json::to_vec(plan)
            .map_err(|e| Error::format(&self.place(&plan_name()), e.to_string(), "report it"))?;
        self.swap(&plan_name(), Keep::Thrifty, &text)
    }
}

/// Which frames of these steps stay when a new one is to come: the first, and most of the newest. About a quarter goes, no two
/// neighbours, and first those that leave the smallest gap for their age; so gaps come to grow with age.
fn kept(steps: &[u64]) -> Vec<usize> {
    let n = steps.len();
    if n <= 2 {
        return vec![0];
    }
    let gap_for_age = |i: &usize| (steps[i + 1] - steps[i - 1]) as f64 / (steps[n - 1] + 1 - steps[*i]) as f64;
    let mut inner: Vec<usize> = (1..n - 1).collect();
    // Of equals the older ones come first.
    inner.sort_by(|a, b| gap_for_age(a).total_cmp(&gap_for_age(b)));
    let (mut drop, mut left) = (vec![false; n], (n / 4).max(1));
    for i in inner {
        if left > 0 && !drop[i - 1] && !drop[i + 1] {
            drop[i] = true;
            left -= 1;
        }
    }
    (0..n).filter(|i| !drop[*i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_newest_frames_stay_and_old_ones_thin_out() {
        assert_eq!(kept(&[0, 5]), [0]);
        assert_eq!(kept(&[0, 5, 6]), [0, 2]);
        assert_eq!(kept(&[0, 10, 20, 30, 40, 50, 60, 70]), [0, 2, 4, 5, 6, 7]);
        let mut steps: Vec<u64> = Vec::new();
        for t in 0..2000 {
            if steps.len() == 16 {
                steps = kept(&steps).into_iter().map(|i| steps[i]).collect();
                assert!(steps[0] == 0 && steps.len() < 16 && steps.last() == Some(&(t - 1)), "{steps:?}");
            }
            steps.push(t);
        }
        let gaps: Vec<u64> = steps.windows(2).map(|w| w[1] - w[0]).collect();
        assert_eq!(gaps.last(), Some(&1));
        // The oldest gap is not the whole past.
        assert!(gaps.iter().all(|g| *g < 1400), "{steps:?}");
    }

    #[test]
    fn plans_of_others_are_looked_at() {
        let plan = |frames, keep: &[(usize, u64)]| Plan { frames, keep: keep.to_vec(), dropped: false };
        assert!(plan(4, &[(0, 0), (2, 9), (3, 10)]).is_sound());
        for bad in [plan(3, &[(0, 0), (3, 9)]), plan(3, &[(1, 0)]), plan(3, &[]), plan(9, &[(0, 0), (5, 9), (4, 10)])] {
            assert!(!bad.is_sound(), "{bad:?}");
        }
        assert!(!plan(usize::MAX, &[(0, 0)]).is_sound());
        assert!(!plan(3, &[(0, 0), (1, u64::MAX)]).is_sound());
    }
}
