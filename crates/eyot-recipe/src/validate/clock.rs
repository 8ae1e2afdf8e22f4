//! Where the sea of a recipe comes to.

use super::Validator;
use crate::diagnostic::Diagnostic;
use crate::node::Node;
use crate::recipe::{ProcessUse, Step, Work, schedule};
use eyot_core::process::{Moment, Span, clock_after};
use eyot_core::{Error, Grid};

/// Steps of a simulation that are gone through; beyond them the run itself finds out, before the step. So many take less than a
/// millisecond, and half a second where parameters are expressions of time.
const FORESEEN: u64 = 1 << 15;

/// Goes through simulations one after the other, of which each has its processes and its steps to do, and finds the first that would
/// leave the world with a sea that no world can have, by its place in the list.
///
/// # Errors
/// That place, and why.
pub fn foresee<'a>(
    mut moment: Moment,
    simulations: impl IntoIterator<Item = (&'a [ProcessUse], Span)>,
) -> Result<(), (usize, Error)> {
    for (i, (uses, span)) in simulations.into_iter().enumerate() {
        // Recipes that were checked have none such.
        let Ok(scheduled) = schedule(uses) else { return Ok(()) };
        let seen = Span { steps: span.steps.min(FORESEEN), ..span };
        moment = clock_after(&scheduled, moment, seen).map_err(|e| (i, e))?;
        if span.steps > FORESEEN {
            break;
        }
    }
    Ok(())
}

impl Validator<'_> {
    /// Refuses steps after which the world would have a sea that no world can have.
    pub(super) fn clock(&mut self, doc: &Node, grid: Option<Grid>, sea_level_m: f64, steps: &[Step]) {
        let Some(grid) = grid.filter(|_| self.out.is_empty()) else { return };
        let simulations: Vec<_> = steps.iter().filter(|s| s.enabled).filter_map(simulation).collect();
        let each = simulations.iter().map(|(_, uses, span)| (*uses, *span));
        if let Err((i, e)) = foresee(Moment::whole(grid, 0, sea_level_m), each) {
            let step = simulations[i].0;
            let span = doc.get("step").and_then(|n| n.elements().get(step.number - 1)).unwrap_or(doc).span.clone();
            let message = format!("step {} ({}) goes too far: {e}", step.number, step.name);
            let help = "do fewer `steps`, let each be shorter, or let the sea rise or fall less in it";
            self.out.push(Diagnostic::at(span, message, "this simulation").help(help));
        }
    }
}

fn simulation(step: &Step) -> Option<(&Step, &[ProcessUse], Span)> {
    match &step.work {
        Work::Simulate(work) => Some((step, &work.processes, Span { from: 0, steps: work.steps })),
        Work::Generate(_) => None,
    }
}
