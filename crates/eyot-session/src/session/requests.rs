//! What a client asks of a session while it is at work.

use crate::event::{Command, Event};
use crate::host::Events;
use eyot_recipe::Change;
use std::collections::VecDeque;
use std::path::PathBuf;

/// The commands of a client, and how far it lets the session go.
pub(crate) struct Requests {
    queue: VecDeque<Command>,
    events: Events,
    /// Steps that may still be done before waiting; `None` while nobody paused.
    allowance: Option<u64>,
    /// Whether the client knows that the session waits.
    told: bool,
}

/// What a session has to do next.
pub(crate) enum Request {
    /// Its own work.
    GoOn,
    /// End here.
    Stop,
    /// Nothing: it is paused.
    Wait,
    /// Change a parameter.
    Change(Change),
    /// Show the world.
    Snapshot,
    /// Go back to a recorded frame; true if later changes by hand are dropped.
    Rewind(u64, bool),
    /// Put a recorded frame into another folder.
    Branch(u64, PathBuf),
}

impl Requests {
    pub(crate) fn new(events: Events, paused: bool) -> Self {
        Self { queue: VecDeque::new(), events, allowance: paused.then_some(0), told: false }
    }

    pub(crate) fn push(&mut self, command: Command) {
        self.queue.push_back(command);
    }

    /// True if somebody wants to see the world, or to change it.
    pub(crate) fn want_world(&self) -> bool {
        self.queue.iter().any(|c| match c {
            Command::Snapshot => true,
            Command::Change(change) => change.touches_world(),
            _ => false,
        })
    }

    /// Steps that may be done before the next look; at least one.
    pub(crate) fn allowed(&self) -> u64 {
        self.allowance.map_or(u64::MAX, |n| n.max(1))
    }

    /// Counts steps that were done.
    pub(crate) fn did(&mut self, steps: u64) {
        self.allowance = self.allowance.map(|n| n.saturating_sub(steps));
    }

    /// What is to be done now, after `step` steps of the recipe's step `number`.
    pub(crate) fn next(&mut self, number: usize, step: u64) -> Request {
        loop {
            let waits = self.allowance == Some(0);
            if waits && !std::mem::replace(&mut self.told, true) {
                self.events.tell(Event::Paused { recipe_step: number, step });
            }
            let Some(command) = self.queue.pop_front() else {
                return if waits { Request::Wait } else { Request::GoOn };
            };
            match command {
                Command::Pause => {
                    self.told &= waits;
                    self.allowance = Some(0);
                }
                Command::Resume => {
                    self.allowance = None;
                    self.events.tell(Event::Resumed);
                }
                Command::Step(n) => {
                    self.allowance = Some(n);
                    self.told = false;
                }
                Command::Change(change) => return Request::Change(change),
                Command::Snapshot => return Request::Snapshot,
                Command::Rewind { step, forget } => return Request::Rewind(step, forget),
                Command::Branch { step, out } => return Request::Branch(step, out),
                Command::Stop => return Request::Stop,
            }
        }
    }
}
