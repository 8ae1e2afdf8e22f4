//! The one stepper: which plans an engine runs, and when something acts between them.
//!
//! A span of steps is cut into plans as long as the engine likes them. Processes that act cut a plan; the passes before them are run,
//! the world is lent to them, and planning goes on, so that nothing that cannot fail makes a chain of steps shorter. A step in which
//! something acts that can fail is a plan of its own, and what it changes is kept to go back to.

use crate::control::Control;
use crate::engine::{Ahead, Borrowed, Engine, EngineError};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::process::{ActionInstance, Locality, Moment, Scheduled, Span, clock_after, may_fail};
use crate::world::World;
use std::borrow::Cow;

/// Processes, with what they keep between their steps.
///
/// It belongs to one world. Whoever changes that world otherwise than by the simulation loses no more than time: what is kept can be
/// made anew from the world and is compared with it.
pub struct Simulation<P = Vec<Scheduled>> {
    processes: P,
    /// What acts, by the number of its process; made when it is first needed.
    instances: Vec<Option<Box<dyn ActionInstance>>>,
}

impl<P: AsRef<[Scheduled]>> Simulation<P> {
    /// A simulation of these processes.
    pub fn new(processes: P) -> Self {
        let instances = processes.as_ref().iter().map(|_| None).collect();
        Self { processes, instances }
    }

    /// The processes.
    pub fn processes(&self) -> &[Scheduled] {
        self.processes.as_ref()
    }

    /// Runs a span of steps on the world, whose halo is right if it is a window. Afterwards step and sea level of `world` are right; its layers and its ledger may be out of
    /// date until [`Engine::download`].
    ///
    /// # Errors
    /// If a parameter does not fit the world, the steps look further than a window's halo ([`reach`]), memory would exceed the limits
    /// or the clock of the world its bounds (before the first step), on a request to stop
    /// (the world is then in the state after some whole step; `world.step` tells which), if a value that is not finite turns up,
    /// and if the engine's device fails: the world is then what it was when it was last downloaded.
    pub fn advance(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        span: Span,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let outcome = self.span(engine, world, span, control);
        if outcome.as_ref().is_err_and(|e| !e.is_cancelled()) {
            engine.fall_back(world);
        }
        outcome
    }

    fn span(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        span: Span,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let processes = self.processes.as_ref();
        let missing = |world: &World| {
            let mut layers = processes.iter().flat_map(|s| s.process.layers());
            layers.any(|l| world.get(&l.spec.name).is_none())
        };
        if missing(world) {
            engine.download(world)?;
            engine.release();
        }
        prepare(engine, world, processes)?;
        check_window(world, processes, span)?;
        clock_after(processes, Moment::of(world), span)?;
        for (instance, s) in self.instances.iter_mut().zip(processes) {
            if let (None, Some(action)) = (&instance, s.process.action()) {
                *instance = Some(action.instantiate(world)?);
            }
        }
        let ahead = Ahead { processes, span, completes: 0, within_step: false };
        engine.begin(world, &ahead)?;
        let outcome = self.steps(engine, world, span, control);
        if matches!(outcome, Err(EngineError::Device(_))) {
            return outcome;
        }
        engine.end(world)?;
        outcome
    }

    fn steps(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        span: Span,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let (end, mut at, mut told) = (span.from + span.steps, span.from, 0);
        control.check()?;
        while at < end {
            let processes = self.processes.as_ref();
            let ahead = Ahead { processes, span: Span { from: at, steps: end - at }, completes: 0, within_step: false };
            // A step that may have to be taken back is no link of a chain.
            let (next, saved) = if may_fail(processes, at) {
                (at + 1, Some(engine.save(world, &written(processes, at))?))
            } else {
                let most = engine.plan_end(&ahead, at).min(end);
                ((at + 1..most).find(|&step| may_fail(processes, step)).unwrap_or(most), None)
            };
            let outcome = self.block(engine, world, at..next, ahead.span, saved.is_some(), control);
            if let Err(e) = outcome {
                if let Some(saved) = saved {
                    engine.restore(world, saved);
                    // What acts may be in the middle of a step, too.
                    self.instances.iter_mut().for_each(|i| *i = None);
                }
                return Err(e);
            }
            at = next;
            told = engine.completed();
            control.tick(told, span.steps)?;
        }
        engine.wait()?;
        if engine.completed() > told {
            control.tick(engine.completed(), span.steps)?;
        }
        Ok(())
    }

    /// Some steps as one chain, which only actions interrupt. On an error the passes before it have been done and the clock has not
    /// moved; who acts and may fail therefore needs a copy to go back to.
    fn block(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        steps: std::ops::Range<u64>,
        ahead: Span,
        saved: bool,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let processes = self.processes.as_ref();
        let mut moment = Moment::of(world);
        let control = &control.within(engine.limits());
        let mut plan = Plan::default();
        let mut ahead = Ahead { processes, span: ahead, completes: 0, within_step: false };
        let count = steps.end - steps.start;
        for step in steps {
            for (s, instance) in processes.iter().zip(&mut self.instances).filter(|(s, _)| s.is_due(step)) {
                s.plan(step, &mut moment, &mut plan);
                if let Some(instance) = instance {
                    ahead.within_step = !saved;
                    engine.run(world, &std::mem::take(&mut plan), &ahead)?;
                    let work = &mut |world: &mut World| instance.act(&moment, world, control);
                    engine.lend(world, &Borrowed::by(&*s.process), work)?;
                }
                s.process.advance(&mut moment);
            }
            moment.step += 1;
        }
        // Nothing can stop the passes after the last action.
        ahead.completes = count;
        engine.run(world, &plan, &ahead)?;
        (world.step, world.sea_level_m) = (moment.step, moment.sea_level_m);
        Ok(())
    }
}

/// How far the steps of a span look, with all that they pass on to each other: the halo that a window needs for them.
pub fn reach(processes: &[Scheduled], mut moment: Moment, span: Span) -> Locality {
    let (mut plan, mut reach) = (Plan::default(), 0);
    for step in span.from..span.from + span.steps {
        for s in processes.iter().filter(|s| s.is_due(step)) {
            s.plan(step, &mut moment, &mut plan);
            if let Some(action) = s.process.action() {
                reach += std::mem::take(&mut plan).reach();
                match action.locality() {
                    Locality::Cell => {}
                    Locality::Rows(n) => reach += n,
                    Locality::Whole => return Locality::Whole,
                }
            }
            s.process.advance(&mut moment);
        }
        moment.step += 1;
    }
    match reach + plan.reach() {
        0 => Locality::Cell,
        n => Locality::Rows(n),
    }
}

fn check_window(world: &World, processes: &[Scheduled], span: Span) -> Result<()> {
    if !world.is_window() {
        return Ok(());
    }
    let needed = match reach(processes, Moment::of(world), span) {
        Locality::Cell => 0,
        Locality::Rows(n) => n,
        Locality::Whole => {
            return Err(Error::Window("something that acts in these steps needs the whole grid".to_owned()));
        }
    };
    let halo = world.domain().halo();
    if needed > halo {
        return Err(Error::Window(format!("these steps look {needed} cells far, its halo has {halo}")));
    }
    Ok(())
}

/// Layers that a step may change.
fn written(processes: &[Scheduled], local_step: u64) -> Vec<Cow<'static, str>> {
    let due = processes.iter().filter(|s| s.is_due(local_step));
    let mut names: Vec<_> = due.flat_map(|s| s.process.writes()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// What comes before the first step: finds what cannot work, and makes the layers that the processes need, whose first values the
/// engine computes.
///
/// # Errors
/// If the world does not fit its grid or the limits, a parameter does not fit the world, or the first values of a layer depend on
/// neighbours where the world is a window.
pub fn prepare(engine: &mut dyn Engine, world: &mut World, processes: &[Scheduled]) -> Result<(), EngineError> {
    // Engines reach rows by address, so a world that does not fit its grid must not get further than this.
    world.grid.checked(&engine.limits())?;
    let held = world.domain().held();
    if (held.width, held.height) != (world.grid.width, world.grid.height) {
        return Err(Error::Window(format!("it holds {}x{} cells", held.width, held.height)).into());
    }
    for l in world.layers() {
        let (expected, found) = (world.grid.cells(), l.field.width() * l.field.height());
        if (l.field.width(), l.field.height()) != (world.grid.width, world.grid.height) {
            return Err(Error::Shape { what: format!("layer `{}`", l.spec.name), expected, found }.into());
        }
    }
    processes.iter().try_for_each(|s| s.process.check(world.domain().global()))?;
    for s in processes {
        s.process.needs().into_iter().try_for_each(|name| world.layer(name).map(|_| ()))?;
        for l in s.process.layers() {
            let missing = world.get(&l.spec.name).is_none();
            world.ensure(&l.spec, l.start);
            if missing {
                let moment = Moment::of(world);
                let mut plan = Plan { step: world.step, ..Plan::default() };
                s.process.start(&l.spec.name, &moment, &mut plan);
                if world.is_window() && plan.reach() > 0 {
                    let name = &l.spec.name;
                    return Err(Error::Window(format!("the first values of `{name}` depend on more of it")).into());
                }
                if !plan.passes().is_empty() {
                    engine.apply(world, &plan)?;
                }
            }
        }
        s.process.prepare(world)?;
    }
    Ok(())
}
