//! Actions: work on the whole world between the passes of rules.

use eyot_core::engine::{CpuEngine, MemoryEstimate};
use eyot_core::plan::Plan;
use eyot_core::process::{Action, ActionInstance, Locality, Moment, Process, Scheduled, Span};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{Boundary, Cancel, Control, Grid, LayerSpec, Limits, Result, World, rule_params};

const LEVEL: LayerSpec = LayerSpec::new("level", "m", "", (-1e9, 1e9));

rule_params! {
    /// Parameters of [`Double`].
    pub struct DoubleParams {
        /// How much more.
        more,
    }
}

/// Doubles the level, and counts the cells.
struct Double;

impl Rule for Double {
    const NAME: &'static str = "double";
    const READS: &'static [Read] = &[read("level", 1)];
    const WRITES: &'static [&'static str] = &["level"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "level.doubled", meaning: "", unit: TallyUnit::Count, sign: 0 }];
    type Params = DoubleParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    fn cell<R: Real>(p: &DoubleParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        // Neighbours that are equal everywhere, so that wrong padding shows.
        let mean = R::of(0.25) * (c.at(0, 1, 0) + c.at(0, -1, 0) + c.at(0, 0, 1) + c.at(0, 0, -1));
        ([mean + p.more * c.here(0)], [R::of(1.0)])
    }
}

struct Rules;

impl Process for Rules {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![LEVEL.changed(1.0)]
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Double>(DoubleParams { more: 1.0 });
    }
}

/// Adds one; is asked to stop in step `stop`, after it has changed half of the world.
#[derive(Clone)]
struct AddOne {
    stop: Option<(u64, Cancel)>,
}

impl Process for AddOne {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![LEVEL.changed(1.0)]
    }
    fn action(&self) -> Option<&dyn Action> {
        Some(self)
    }
}

impl Action for AddOne {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        Locality::Cell
    }

    fn bytes_per_cell(&self) -> usize {
        100
    }
}

impl ActionInstance for AddOne {
    fn act(&mut self, moment: &Moment, world: &mut World, control: &Control<'_>) -> Result<()> {
        assert_eq!(moment.turn, moment.step / 2);
        world.ledger.add("level.added", 1.0, "m", "", 1);
        let mut done = false;
        world.layer_mut("level")?.field.map_in_place(|v| if std::mem::replace(&mut done, true) { v } else { v + 1.0 });
        if let Some((_, cancel)) = self.stop.as_ref().filter(|(step, _)| *step == moment.step) {
            cancel.raise();
        }
        control.check()?;
        let mut first = true;
        world.layer_mut("level")?.field.map_in_place(|v| if std::mem::take(&mut first) { v } else { v + 1.0 });
        Ok(())
    }
}

pub(crate) fn scheduled(stop: Option<(u64, Cancel)>) -> Vec<Scheduled> {
    vec![
        Scheduled { name: "rules", process: Box::new(Rules), every: 1 },
        Scheduled { name: "add", process: Box::new(AddOne { stop }), every: 2 },
        Scheduled { name: "again", process: Box::new(Rules), every: 1 },
    ]
}

pub(crate) fn world(rim: Boundary) -> World {
    World::new(Grid::new(37, 9, 1.0, rim, &Limits::default()).unwrap(), 1)
}

#[test]
fn actions_take_their_turn_between_rules() {
    for rim in [Boundary::CLOSED, Boundary::OPEN, Boundary::WRAP] {
        let mut w = world(rim);
        let span = Span { from: 0, steps: 7 };
        CpuEngine::default().simulate(&mut w, &scheduled(None), span, &Control::none()).unwrap();
        let expected = (0..7).fold(1.0, |v, step| (2.0 * v + if step % 2 == 0 { 1.0 } else { 0.0 }) * 2.0);
        assert!(
            w.get("level").unwrap().iter().all(|v| v == expected),
            "{rim:?}: {:?}",
            w.get("level").unwrap().get(0, 0)
        );
        assert_eq!((w.step, w.ledger.amount("level.added")), (7, 4.0));
        assert_eq!(w.ledger.amount("level.doubled"), 7.0 * 2.0 * 37.0 * 9.0);
    }
}

#[test]
fn a_stop_within_an_action_leaves_whole_steps() {
    let (mut whole, mut stopped) = (world(Boundary::WRAP), world(Boundary::WRAP));
    let engine = CpuEngine::default();
    engine.simulate(&mut whole, &scheduled(None), Span { from: 0, steps: 4 }, &Control::none()).unwrap();
    let cancel = Cancel::default();
    let control = Control::new(cancel.clone(), &|_, _| {});
    let span = Span { from: 0, steps: 9 };
    let outcome = engine.simulate(&mut stopped, &scheduled(Some((4, cancel))), span, &control);
    assert!(matches!(outcome, Err(eyot_core::Error::Cancelled(_))));
    assert_eq!(stopped, whole);
    // Going on gives what an uninterrupted run gives.
    engine.simulate(&mut stopped, &scheduled(None), Span { from: 4, steps: 5 }, &Control::none()).unwrap();
    let mut straight = world(Boundary::WRAP);
    engine.simulate(&mut straight, &scheduled(None), Span { from: 0, steps: 9 }, &Control::none()).unwrap();
    assert_eq!(stopped, straight);
}

/// A copy of the level in another layer.
struct Echo;

impl Rule for Echo {
    const NAME: &'static str = "echo";
    const READS: &'static [Read] = &[read("level", 0)];
    const WRITES: &'static [&'static str] = &["echo"];
    type Params = DoubleParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    fn cell<R: Real>(_: &DoubleParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([c.here(0)], [])
    }
}

impl Process for Echo {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![LEVEL.read(1.0), LayerSpec::new("echo", "m", "", (-1e9, 1e9)).written(0.0)]
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Echo>(DoubleParams { more: 0.0 });
    }
}

/// What comes after the last process that can fail has not acted when that fails: nothing of it is copied.
#[test]
fn a_copy_to_go_back_to_holds_what_was_changed_by_then() {
    let processes = |stop: Option<(u64, Cancel)>, first: bool| {
        let mut all = scheduled(stop);
        all.insert(if first { 0 } else { 3 }, Scheduled { name: "echo", process: Box::new(Echo), every: 1 });
        all
    };
    let fields = |first: bool| {
        let w = world(Boundary::CLOSED);
        MemoryEstimate::of(&w.grid, 2, &processes(None, first)).fields
    };
    assert_eq!((fields(true), fields(false)), (5, 4), "level and echo, a second level, and copies of those before");
    for first in [true, false] {
        let (mut whole, mut stopped) = (world(Boundary::WRAP), world(Boundary::WRAP));
        let engine = CpuEngine::default();
        engine.simulate(&mut whole, &processes(None, first), Span { from: 0, steps: 4 }, &Control::none()).unwrap();
        let cancel = Cancel::default();
        let control = Control::new(cancel.clone(), &|_, _| {});
        let span = Span { from: 0, steps: 9 };
        let outcome = engine.simulate(&mut stopped, &processes(Some((4, cancel)), first), span, &control);
        assert!(matches!(outcome, Err(eyot_core::Error::Cancelled(_))));
        assert_eq!(stopped, whole);
    }
}

#[test]
fn what_an_action_takes_is_refused_before_the_first_step() {
    let mut w = world(Boundary::CLOSED);
    let need = MemoryEstimate::of(&w.grid, 1, &scheduled(None));
    // The layer, its second copy for a rule that looks around, and the copy to go back to.
    assert_eq!((need.fields, need.action_bytes_per_cell), (3, 100));
    let bytes = need.bytes(&w.grid);
    assert!(bytes > 37 * 9 * 100, "{bytes}");
    let within =
        |most: u64| CpuEngine { limits: Limits { max_bytes: most, ..Limits::default() }, ..Default::default() };
    let span = Span { from: 0, steps: 1 };
    let refused = within(bytes as u64 - 1).simulate(&mut w, &scheduled(None), span, &Control::none()).unwrap_err();
    assert!(matches!(refused, eyot_core::Error::Limit { .. }), "{refused}");
    assert_eq!((w.step, w.ledger.amount("level.added")), (0, 0.0));
    within(bytes as u64).simulate(&mut w, &scheduled(None), span, &Control::none()).unwrap();
}
