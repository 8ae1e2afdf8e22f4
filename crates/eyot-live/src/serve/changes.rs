//! Changes that clients ask for: from the stream to the run, and what became of them back to who asked.

use eyot_recipe::Change;
use serde_json::Value;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// What those hear whose changes come too late.
pub(super) const OVER: &str = "the run has ended";
/// Changes that may wait for the run's next look at its commands.
const MOST: usize = 256;

/// The change that a client's path and value mean.
///
/// # Errors
/// Why they mean none.
pub(super) fn change(path: &str, value: &str) -> Result<Change, String> {
    let value: Value = serde_json::from_str(value).map_err(|e| format!("the value is no JSON: {e}"))?;
    match &value {
        Value::Null => Err("the value is null; give a number, a text, true, false, a list or a table".to_owned()),
        Value::Object(entries) if path.is_empty() && !entries.is_empty() => Ok(Change { path: Vec::new(), value }),
        _ if path.is_empty() => Err("say what to change, such as hydraulic.rain, sea_level or layer.water".to_owned()),
        _ => Ok(Change::new(path, value)),
    }
}

/// Who asked for the changes that the run has not answered yet; it answers in the order in which it was asked.
#[derive(Default)]
pub(super) struct Pending(Mutex<Asked>);

#[derive(Default)]
struct Asked {
    /// Clients, and the texts of their changes.
    waiting: VecDeque<(u64, String)>,
    ended: bool,
}

impl Pending {
    /// Gives a change to the run.
    ///
    /// # Errors
    /// If the run has ended or too many wait.
    pub(super) fn give(&self, client: u64, change: Change, send: impl FnOnce(Change) -> bool) -> Result<(), String> {
        let mut asked = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if asked.waiting.len() >= MOST {
            return Err(format!("{MOST} changes wait already"));
        }
        let text = change.to_string();
        // Under the lock: nobody else's change comes in between.
        if asked.ended || !send(change) {
            return Err(OVER.to_owned());
        }
        asked.waiting.push_back((client, text));
        Ok(())
    }

    /// The run has answered a change: who asked for it, if it was a client.
    pub(super) fn made(&self, text: &str) -> Option<u64> {
        let mut asked = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let place = asked.waiting.iter().position(|(_, t)| t == text)?;
        asked.waiting.remove(place).map(|(client, _)| client)
    }

    /// The run has ended: whose changes come to nothing.
    pub(super) fn end(&self) -> Vec<u64> {
        let mut asked = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        asked.ended = true;
        asked.waiting.drain(..).map(|(client, _)| client).collect()
    }
}
