//! The next step of plates, made on threads of its own while the world goes on.
//!
//! A step needs nothing but what the step before it left, so it can begin as soon as that is there; what others do to the land
//! meanwhile is added when the world has come to the next step. Whether a step was made ahead decides nothing but the time: what it
//! was made from is compared with the world, and where anything differs, such as after a rewind, it is made anew.

use crate::crust::metres;
use crate::geometry::rows_at_once;
use crate::plates::Plates;
use crate::process::{CRUST, CRUST_AGE, PLATE, STATE};
use crate::store::PlateState;
use eyot_core::{Field, Grid, World};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::sync::mpsc::{Receiver, sync_channel};

/// Plates as a world keeps them.
pub(crate) struct Before {
    grid: Grid,
    seed: u64,
    pub(crate) state: PlateState,
    pub(crate) owner: Vec<u8>,
    crust: Vec<i32>,
    age: Vec<f32>,
    /// Above the sea, m.
    pub(crate) height: Vec<f32>,
}

impl Before {
    /// True if `world` keeps these.
    fn are_of(&self, world: &World) -> bool {
        let Ok(Some(state)) = world.components.get::<PlateState>(STATE) else { return false };
        let bits = |s: &PlateState| s.numbers().into_iter().map(f64::to_bits).collect::<Vec<_>>();
        if (world.grid, world.seed) != (self.grid, self.seed) || bits(state) != bits(&self.state) {
            return false;
        }
        let [Some(plate), Some(crust), Some(age)] = [&PLATE, &CRUST, &CRUST_AGE].map(|l| world.get(&l.name)) else {
            return false;
        };
        let width = self.grid.width;
        (0..self.grid.height).into_par_iter().with_min_len(rows_at_once(width)).all(|y| {
            let cells = y * width..(y + 1) * width;
            same(plate, y, self.owner[cells.clone()].iter().map(|&o| f32::from(o)))
                && same(crust, y, self.crust[cells.clone()].iter().map(|&c| metres(c)))
                && same(age, y, self.age[cells].iter().copied())
        })
    }
}

/// True if a row of a field holds just these values. Looks at all of them, which is quicker than to stop at the first.
fn same(field: &Field, y: usize, values: impl Iterator<Item = f32>) -> bool {
    field.row(y).iter().zip(values).fold(0, |differ, (a, b)| differ | (a.to_bits() ^ b.to_bits())) == 0
}

/// Plates after a step, and before it.
pub(crate) struct Made {
    pub(crate) plates: Plates,
    pub(crate) before: Before,
}

impl Made {
    /// Makes a step of plates that a world keeps with this state.
    pub(crate) fn new(grid: &Grid, state: PlateState, mut plates: Plates) -> Self {
        plates.forget();
        let before = Before {
            grid: *grid,
            seed: plates.seed,
            state,
            owner: plates.maps.owner.clone(),
            crust: plates.maps.crust.clone(),
            age: plates.maps.age.clone(),
            height: plates.height.clone(),
        };
        plates.followed = true;
        plates.step();
        Self { plates, before }
    }
}

impl Plates {
    /// Adds to the land what others have done to it since `before`, where its plate has carried it; `height` is the world's, in which
    /// the sea stands at `sea` m.
    pub(crate) fn add_changes(&mut self, before: &Before, height: &Field, sea: f32) {
        let (course, width) = (self.course.take(), self.g.width);
        let change = |(y, x): (usize, usize)| height.row(y)[x] - sea - before.height[y * width + x];
        self.shape(&|row, new| match &course {
            Some(course) => course.trace(&before.owner, row, |column, from| new[column] += change(from)),
            None => new.iter_mut().enumerate().for_each(|(column, h)| *h += change((row, column))),
        });
    }
}

/// The next step.
#[derive(Default)]
pub(crate) struct Lookahead {
    threads: Option<ThreadPool>,
    step: Option<Step>,
}

enum Step {
    /// Not begun.
    Waits(Box<(PlateState, Plates)>),
    UnderWay(Receiver<Made>),
}

impl Lookahead {
    /// Begins a step of plates that a world keeps with this state. If not `at_once`, it is only begun when it is asked for: for
    /// a world that does nothing in the meantime.
    pub(crate) fn begin(&mut self, grid: &Grid, state: PlateState, plates: Plates, at_once: bool) {
        if self.threads.is_none() && at_once {
            // As many as the world's own: whoever waits for the step should not wait longer than for one of its own.
            let threads = rayon::ThreadPoolBuilder::new().num_threads(rayon::current_num_threads());
            // A step that panics drops its sender, and is made again where its message can be seen.
            self.threads = threads.thread_name(|_| "plates".into()).panic_handler(|_| ()).build().ok();
        }
        self.step = Some(match &self.threads {
            Some(threads) if at_once => {
                let (sender, receiver) = sync_channel(1);
                let grid = *grid;
                threads.spawn(move || drop(sender.send(Made::new(&grid, state, plates))));
                Step::UnderWay(receiver)
            }
            _ => Step::Waits(Box::new((state, plates))),
        });
    }

    /// The step that was begun, if it is one of the plates in `world`; waits for it.
    pub(crate) fn take(&mut self, world: &World) -> Option<Made> {
        let made = match self.step.take()? {
            Step::Waits(waiting) => {
                let (state, plates) = *waiting;
                Made::new(&world.grid, state, plates)
            }
            Step::UnderWay(receiver) => receiver.recv().ok()?,
        };
        made.before.are_of(world).then_some(made)
    }
}
