//! The one stepper: which plans an engine runs, and when something acts between them.
//!
//! A span of steps is cut into plans as long as the engine likes them. Processes that act cut a plan; the passes before them are run,
//! the world is lent to them, and planning goes on, so that nothing that cannot fail makes a chain of steps shorter. A step in which
//! something acts that can fail is a plan of its own, and what it changes is kept to go back to.
//!
//! Some hosts must not wait for a device. Its engine then says [`EngineError::NotReady`] before it has changed anything, and the span
//! keeps its place until it is asked to go on.

use crate::control::Control;
use crate::engine::{Ahead, Borrowed, Engine, EngineError, Saved};
use crate::error::{Error, Result};
use crate::plan::Plan;
use crate::process::{ActionInstance, Locality, Moment, Scheduled, Span, changed_by_failure, clock_after, may_fail};
use crate::world::World;
use std::borrow::Cow;
use std::ops::Range;

/// Processes, with what they keep between their steps.
///
/// It belongs to one world. Whoever changes that world otherwise than by the simulation loses no more than time: what is kept can be
/// made anew from the world and is compared with it.
pub struct Simulation<P = Vec<Scheduled>> {
    processes: P,
    /// What acts, by the number of its process; made when it is first needed.
    instances: Vec<Option<Box<dyn ActionInstance>>>,
    /// The span whose engine was not ready.
    under_way: Option<Box<UnderWay>>,
}

/// How far a span has come.
struct UnderWay {
    span: Span,
    /// The first step that is not complete.
    at: u64,
    /// Steps that the caller was last told of.
    told: u64,
    block: Option<Block>,
    /// How the steps went, once only the end is left to do.
    outcome: Option<Result<(), EngineError>>,
}

/// How far the steps have come that are planned together.
struct Block {
    /// Those that are not planned yet, among them the one that is being planned.
    steps: Range<u64>,
    /// How many there were.
    count: u64,
    /// The process whose turn it is in the first of them, and what is to be done for it.
    turn: usize,
    stage: Stage,
    moment: Moment,
    /// Passes that were not run yet.
    plan: Plan,
    /// As [`Ahead::within_step`].
    within_step: bool,
    /// From the block on, to the end of the span.
    ahead: Span,
    /// What to go back to, if something acts that may fail.
    saved: Option<Saved>,
}

/// What is to be done for a process in a step.
#[derive(Clone, Copy)]
enum Stage {
    Plan,
    /// The passes so far, since it acts.
    Run,
    Act,
}

impl<P: AsRef<[Scheduled]>> Simulation<P> {
    /// A simulation of these processes.
    pub fn new(processes: P) -> Self {
        let instances = processes.as_ref().iter().map(|_| None).collect();
        Self { processes, instances, under_way: None }
    }

    /// The processes.
    pub fn processes(&self) -> &[Scheduled] {
        self.processes.as_ref()
    }

    /// Runs a span of steps on the world, whose halo is right if it is a window. Afterwards step and sea level of `world` are right; its
    /// layers and its ledger may be out of date until [`Engine::download`].
    ///
    /// After [`EngineError::NotReady`] the same call goes on with the span, which has the bytes of one without a break. Until it has come
    /// to its end the world must be left alone; [`Engine::fall_back`] gives it up, with this simulation.
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
        let mut under_way = self.under_way.take();
        let outcome = self.span(engine, world, span, &mut under_way, control);
        match &outcome {
            Err(EngineError::NotReady) => self.under_way = under_way,
            Err(e) if !e.is_cancelled() => engine.fall_back(world),
            Err(_) | Ok(()) => {}
        }
        outcome
    }

    fn span(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        span: Span,
        under_way: &mut Option<Box<UnderWay>>,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let u = match under_way {
            Some(u) => u,
            None => {
                self.begin(engine, world, span)?;
                under_way.insert(Box::new(UnderWay { span, at: span.from, told: 0, block: None, outcome: None }))
            }
        };
        let outcome = match u.outcome.take() {
            Some(outcome) => outcome,
            None => match self.steps(engine, world, u, control) {
                Err(e @ (EngineError::Device(_) | EngineError::NotReady)) => return Err(e),
                outcome => outcome,
            },
        };
        let end = engine.end(world);
        if matches!(end, Err(EngineError::NotReady)) {
            u.outcome = Some(outcome);
            return end;
        }
        end.and(outcome)
    }

    /// What comes before the first step of a span.
    fn begin(&mut self, engine: &mut dyn Engine, world: &mut World, span: Span) -> Result<(), EngineError> {
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
        engine.begin(world, &Ahead { processes, span, completes: 0, within_step: false })
    }

    fn steps(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        u: &mut UnderWay,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let end = u.span.from + u.span.steps;
        if u.block.is_none() {
            control.check()?;
        }
        while u.at < end {
            if u.block.is_none() {
                u.block = Some(self.next_block(engine, world, u.at..end)?);
            }
            let Some(block) = &mut u.block else { break };
            let next = block.steps.end;
            let outcome = self.block(engine, world, block, control);
            if matches!(outcome, Err(EngineError::NotReady)) {
                return outcome;
            }
            let saved = u.block.take().and_then(|block| block.saved);
            if let (Err(_), Some(saved)) = (&outcome, saved) {
                engine.restore(world, saved);
                // What acts may be in the middle of a step, too.
                self.instances.iter_mut().for_each(|i| *i = None);
            }
            outcome?;
            u.at = next;
            u.told = engine.completed();
            control.tick(u.told, u.span.steps)?;
        }
        engine.wait()?;
        if engine.completed() > u.told {
            control.tick(engine.completed(), u.span.steps)?;
        }
        Ok(())
    }

    /// The steps that are planned together, of those that are left.
    fn next_block(&self, engine: &mut dyn Engine, world: &mut World, left: Range<u64>) -> Result<Block, EngineError> {
        let processes = self.processes.as_ref();
        let (at, end) = (left.start, left.end);
        let ahead = Span { from: at, steps: end - at };
        // A step that may have to be taken back is no link of a chain.
        let (next, saved) = if may_fail(processes, at) {
            (at + 1, Some(engine.save(world, &kept(processes, at))?))
        } else {
            let most =
                engine.plan_end(&Ahead { processes, span: ahead, completes: 0, within_step: false }, at).min(end);
            ((at + 1..most).find(|&step| may_fail(processes, step)).unwrap_or(most), None)
        };
        Ok(Block {
            steps: at..next,
            count: next - at,
            turn: 0,
            stage: Stage::Plan,
            moment: Moment::of(world),
            plan: Plan::default(),
            within_step: false,
            ahead,
            saved,
        })
    }

    /// Some steps as one chain, which only actions interrupt. On an error the passes before it have been done and the clock has not
    /// moved; who acts and may fail therefore needs a copy to go back to.
    fn block(
        &mut self,
        engine: &mut dyn Engine,
        world: &mut World,
        b: &mut Block,
        control: &Control<'_>,
    ) -> Result<(), EngineError> {
        let processes = self.processes.as_ref();
        let control = &control.within(engine.limits());
        let part = Ahead { processes, span: b.ahead, completes: 0, within_step: b.within_step };
        while !b.steps.is_empty() {
            let step = b.steps.start;
            while let Some((s, instance)) = processes.get(b.turn).zip(self.instances.get_mut(b.turn)) {
                if s.is_due(step) {
                    if let Stage::Plan = b.stage {
                        s.plan(step, &mut b.moment, &mut b.plan);
                        b.stage = Stage::Run;
                    }
                    if let Some(instance) = instance {
                        if let Stage::Run = b.stage {
                            b.within_step = b.saved.is_none();
                            engine.run(world, &b.plan, &Ahead { within_step: b.within_step, ..part })?;
                            (b.plan, b.stage) = (Plan::default(), Stage::Act);
                        }
                        let moment = &b.moment;
                        let work = &mut |world: &mut World| instance.act(moment, world, control);
                        engine.lend(world, &Borrowed::by(&*s.process), work)?;
                    }
                    s.process.advance(&mut b.moment);
                }
                (b.turn, b.stage) = (b.turn + 1, Stage::Plan);
            }
            b.moment.step += 1;
            (b.steps.start, b.turn) = (step + 1, 0);
        }
        // Nothing can stop the passes after the last action.
        engine.run(world, &b.plan, &Ahead { completes: b.count, within_step: b.within_step, ..part })?;
        (world.step, world.sea_level_m) = (b.moment.step, b.moment.sea_level_m);
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

/// Layers of which a step that may fail needs a copy to go back to.
fn kept(processes: &[Scheduled], local_step: u64) -> Vec<Cow<'static, str>> {
    changed_by_failure(processes.iter().filter(|s| s.is_due(local_step)))
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
