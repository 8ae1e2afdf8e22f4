//! What a client asks of a run while it is at work.

use crate::event::{Command, Event};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use std::time::Duration;

/// A paused run looks this often whether something is due.
const LOOK: Duration = Duration::from_secs(1);

/// The commands of a client, and how far it lets the run go.
pub(super) struct Commands {
    inbox: Receiver<Command>,
    outbox: Sender<Event>,
    /// Steps that may still be done before waiting; `None` while nobody paused.
    allowance: Option<u64>,
    /// Whether the client knows that the run waits.
    told: bool,
}

/// What a run has to do next.
pub(super) enum Asked {
    /// Its own work.
    GoOn,
    /// End here.
    Stop,
    /// Nothing: it is paused. A moment for what is due.
    Wait,
    /// Change a parameter.
    Set(String),
    /// Show the world.
    Snapshot,
    /// Go back to a recorded frame; true if later changes by hand are dropped.
    Rewind(u64, bool),
    /// Put a recorded frame into another folder.
    Branch(u64, PathBuf),
}

impl Commands {
    pub(super) fn new(inbox: Receiver<Command>, outbox: Sender<Event>, paused: bool) -> Self {
        Self { inbox, outbox, allowance: paused.then_some(0), told: false }
    }

    /// Steps that may be done before the next look; at least one.
    pub(super) fn allowed(&self) -> u64 {
        self.allowance.map_or(u64::MAX, |n| n.max(1))
    }

    /// Counts steps that were done.
    pub(super) fn did(&mut self, steps: u64) {
        self.allowance = self.allowance.map(|n| n.saturating_sub(steps));
    }

    /// What is to be done now, after `step` steps of the recipe's step `number`. Waits a while if the run is paused.
    pub(super) fn next(&mut self, number: usize, step: u64) -> Asked {
        loop {
            let command = if self.allowance == Some(0) {
                if !std::mem::replace(&mut self.told, true) {
                    self.tell(Event::Paused { recipe_step: number, step });
                }
                match self.inbox.recv_timeout(LOOK) {
                    Ok(command) => command,
                    Err(RecvTimeoutError::Timeout) => return Asked::Wait,
                    // Nobody is left who could let it go on.
                    Err(RecvTimeoutError::Disconnected) => return Asked::Stop,
                }
            } else {
                match self.inbox.try_recv() {
                    Ok(command) => command,
                    Err(TryRecvError::Empty | TryRecvError::Disconnected) => return Asked::GoOn,
                }
            };
            match command {
                Command::Pause => {
                    self.told &= self.allowance == Some(0);
                    self.allowance = Some(0);
                }
                Command::Resume => {
                    self.allowance = None;
                    self.tell(Event::Resumed);
                }
                Command::Step(n) => {
                    self.allowance = Some(n);
                    self.told = false;
                }
                Command::Set(set) => return Asked::Set(set),
                Command::Snapshot => return Asked::Snapshot,
                Command::Rewind { step, forget } => return Asked::Rewind(step, forget),
                Command::Branch { step, out } => return Asked::Branch(step, out),
                Command::Stop => return Asked::Stop,
            }
        }
    }

    fn tell(&self, event: Event) {
        // A client that has gone does not stop a run; its files are still wanted.
        let _ = self.outbox.send(event);
    }
}
