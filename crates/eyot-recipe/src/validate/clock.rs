//! Where the sea of a recipe comes to.

use super::Validator;
use crate::diagnostic::Diagnostic;
use crate::node::Node;
use crate::recipe::{Step, Work};
use eyot_core::Grid;
use eyot_core::process::{Moment, Span, clock_after};

/// Steps of a simulation that are gone through; beyond them the run itself finds out, before the step. So many take less than a
/// millisecond, and half a second where parameters are expressions of time.
const FORESEEN: u64 = 1 << 15;

impl Validator<'_> {
    /// Refuses steps after which the world would have a sea that no world can have.
    pub(super) fn clock(&mut self, doc: &Node, grid: Option<Grid>, sea_level_m: f64, steps: &[Step]) {
        let Some(grid) = grid.filter(|_| self.out.is_empty()) else { return };
        let mut moment = Moment::whole(grid, 0, sea_level_m);
        for step in steps.iter().filter(|s| s.enabled) {
            let Work::Simulate(work) = &step.work else { continue };
            let Ok(scheduled) = work.schedule() else { return };
            match clock_after(&scheduled, moment, Span { from: 0, steps: work.steps.min(FORESEEN) }) {
                Ok(after) => moment = after,
                Err(e) => {
                    let span =
                        doc.get("step").and_then(|n| n.elements().get(step.number - 1)).unwrap_or(doc).span.clone();
                    let message = format!("step {} ({}) goes too far: {e}", step.number, step.name);
                    let help = "do fewer `steps`, let each be shorter, or let the sea rise or fall less in it";
                    return self.out.push(Diagnostic::at(span, message, "this simulation").help(help));
                }
            }
            if work.steps > FORESEEN {
                return;
            }
        }
    }
}
