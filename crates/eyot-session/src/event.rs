//! What goes into a run and what comes out of it.

use eyot_core::remedy::{Remedy, Wording};
use eyot_core::{Ledger, World};
use eyot_recipe::Change;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// What a client may ask of a run. Commands take effect between two steps.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Command {
    /// Wait after the present step.
    Pause,
    /// Go on.
    Resume,
    /// Do so many steps, then wait.
    Step(u64),
    /// Change the simulating step that is under way: a parameter of one of its processes (`hydraulic.rain`), the level of the sea
    /// (`sea_level`, m), or all cells of a layer (`layer.water`, its unit). What a recipe could not have is refused.
    Change(Change),
    /// Send the world as it is.
    Snapshot,
    /// Go back to the last recorded frame that has at most so many steps of simulation done. Later frames stay until the run
    /// goes on, so that one can go forth again.
    Rewind {
        /// Steps of simulation, of all steps of the recipe together.
        step: u64,
        /// Whether changes by hand that came later are dropped; else they will be made again.
        forget: bool,
    },
    /// Put the last recorded frame that has at most so many steps done into another folder, where it can be resumed.
    Branch {
        /// Steps of simulation, of all steps of the recipe together.
        step: u64,
        /// A new folder.
        out: PathBuf,
    },
    /// Write a checkpoint and end.
    Stop,
}

/// A command that changed the bytes, and when.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JournalEntry {
    /// Number of the recipe's step, from 1.
    pub recipe_step: usize,
    /// Steps of this simulation that were done when it took effect.
    pub step: u64,
    /// `process.field = value`, `sea_level = value` or `layer.name = value`; a line for each of those that were changed together.
    pub set: String,
}

/// How far a run is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Progress {
    /// Number of the recipe's step, from 1.
    pub recipe_step: usize,
    /// Steps done of this step of the recipe; for a generator its own measure.
    pub step: u64,
    /// All steps of this step of the recipe.
    pub total: u64,
    /// Steps per second lately; 0 while unknown.
    pub steps_per_s: f64,
    /// Seconds left for this step of the recipe, if known.
    pub eta_s: Option<f64>,
    /// Share of the whole run that is done, 0 to 1.
    pub overall: f64,
    /// Erosion score of the land as it was lately: deviation over mean of the largest steps to the four neighbours, without a unit. `None`
    /// for generators, and where nobody measures ([`Outputs::score`](crate::Outputs::score)).
    pub erosion_score: Option<f64>,
}

/// What a run tells its client.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Event {
    /// The run has begun.
    Started {
        /// The recipe's name.
        name: String,
        /// Columns and rows.
        size: [usize; 2],
        /// Size of a cell, m.
        cell_m: [f64; 2],
        /// Seed.
        seed: u64,
        /// Steps of the recipe that will be done.
        steps: usize,
        /// The engine: processor and its instruction set, or graphics card and its name.
        engine: String,
        /// Threads at work.
        threads: usize,
        /// Whether it continues a stopped run.
        resumed: bool,
        /// Where the files go.
        out: Option<PathBuf>,
    },
    /// A step of the recipe has begun.
    StepBegun {
        /// Number of the recipe's step, from 1.
        number: usize,
        /// Its name.
        name: String,
        /// Steps of the simulation; 1 for a generator.
        total: u64,
    },
    /// A step of the recipe is done.
    StepDone {
        /// Number of the recipe's step, from 1.
        number: usize,
        /// Its name.
        name: String,
        /// Time it took since the run began or was resumed, s.
        seconds: f64,
    },
    /// How far the run is.
    Progress(Progress),
    /// The simulations that are left will take minutes, by the first steps of the one under way. Told once a simulation at most.
    Long {
        /// Time that is expected from now on, s: of this simulation and of those after it, all by the pace of this one.
        seconds: f64,
        /// Steps that were timed.
        timed: u64,
        /// Whether later simulations have other processes, whose pace is not known yet.
        rough: bool,
    },
    /// The run waits for a command.
    Paused {
        /// Number of the recipe's step, from 1.
        recipe_step: usize,
        /// Steps done of it.
        step: u64,
    },
    /// The run goes on.
    Resumed,
    /// Something was changed by hand.
    Changed(JournalEntry),
    /// A change by hand was not made; the run goes on.
    NotChanged {
        /// As in [`JournalEntry::set`].
        set: String,
        /// One sentence.
        reason: Remedy,
    },
    /// Something that the client should know; the run goes on.
    Warning {
        /// One sentence.
        message: Remedy,
    },
    /// The state of the ledger.
    Ledger {
        /// All accounts.
        ledger: Ledger,
    },
    /// A checkpoint was written.
    Checkpoint {
        /// The file.
        path: PathBuf,
    },
    /// A frame of the recording was written.
    Recorded {
        /// Its number, from 0; frames are numbered anew when old ones thin out.
        frame: usize,
        /// Steps of simulation done.
        steps_done: u64,
        /// Bytes of its files.
        bytes: u64,
    },
    /// The run went back to a recorded frame.
    Rewound {
        /// Number of the frame, from 0.
        frame: usize,
        /// Steps of simulation done.
        steps_done: u64,
        /// Number of the recipe's step that comes next or is under way, from 1.
        recipe_step: usize,
        /// Steps done of it.
        step: u64,
    },
    /// A recorded frame was put into another folder.
    Branched {
        /// The folder.
        out: PathBuf,
        /// Steps of simulation done.
        steps_done: u64,
    },
    /// The world as it is.
    Snapshot {
        /// Number of the recipe's step, from 1.
        recipe_step: usize,
        /// Steps done of it.
        step: u64,
        /// A copy of the world.
        #[serde(skip)]
        world: Arc<World>,
    },
    /// Clients may connect.
    Serving {
        /// Where.
        url: String,
        /// The port.
        port: u16,
        /// Where those connect who may give orders, if anybody may.
        control: Option<String>,
    },
    /// A client has connected.
    Joined {
        /// Its number, from 1.
        client: u64,
        /// Where it is.
        address: String,
    },
    /// A client is gone.
    Left {
        /// Its number.
        client: u64,
        /// Where it was.
        address: String,
        /// Why.
        reason: String,
    },
    /// Somebody was not let in.
    Refused {
        /// Where it is.
        address: String,
        /// Why.
        reason: String,
    },
    /// A file of the result is being made.
    Writing {
        /// The file.
        path: PathBuf,
    },
    /// The run is done.
    Done {
        /// The files that it wrote.
        outputs: Vec<PathBuf>,
        /// Fingerprint of the world, hexadecimal.
        fingerprint: String,
        /// Time at work, s.
        seconds: f64,
    },
    /// The run was stopped.
    Stopped {
        /// Where it can be continued from.
        checkpoint: Option<PathBuf>,
    },
    /// The run failed.
    Failed {
        /// What happened.
        message: Remedy,
        /// What to do about it.
        help: Option<Remedy>,
    },
}

impl Event {
    /// The same in the words of a front end.
    #[must_use]
    pub fn worded(&self, wording: &dyn Wording) -> Self {
        match self {
            Self::Warning { message } => Self::Warning { message: message.worded(wording).into() },
            Self::NotChanged { set, reason } => {
                Self::NotChanged { set: set.clone(), reason: reason.worded(wording).into() }
            }
            Self::Failed { message, help } => Self::Failed {
                message: message.worded(wording).into(),
                help: help.as_ref().map(|h| h.worded(wording).into()),
            },
            other => other.clone(),
        }
    }

    /// True for the last thing that a run tells.
    pub fn is_last(&self) -> bool {
        matches!(self, Self::Done { .. } | Self::Stopped { .. } | Self::Failed { .. })
    }
}
