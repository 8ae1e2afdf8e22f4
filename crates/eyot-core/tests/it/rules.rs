//! Rules of a test's own through the whole core: graphs fold, the reference carries on from any world, a run that is
//! stopped leaves whole steps.

use eyot_core::control::{Cancel, Control};
use eyot_core::engine::CpuEngine;
use eyot_core::graph::{Graph, Op, operands};
use eyot_core::plan::Plan;
use eyot_core::process::{Moment, Process, Scheduled, Span};
use eyot_core::real::Real;
use eyot_core::reference::Reference;
use eyot_core::rule::{Cell, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{Boundary, Centering, Error, Grid, LayerSpec, Limits, World, conformance, rule_params};
use std::sync::atomic::{AtomicU64, Ordering};

rule_params! {
    /// Parameters of all rules here.
    struct PushParams {
        /// Share that is kept.
        keep,
        /// Strength.
        push,
    }
}

const STUFF: LayerSpec = LayerSpec::new("stuff", "m", "Something that flows", (0.0, 10.0)).empty_outside();
const FLOW_X: LayerSpec = LayerSpec::new("flow_x", "m", "Flow to the east", (-10.0, 10.0)).on(Centering::FaceX);
const FLOW_Y: LayerSpec = LayerSpec::new("flow_y", "m", "Flow to the south", (-10.0, 10.0)).on(Centering::FaceY);

/// Flows remember and are pushed by differences and by chance.
struct Push;

impl Rule for Push {
    const NAME: &'static str = "test_push";
    const READS: &'static [Read] = &[read("stuff", 1), read("flow_x", 0), read("flow_y", 0)];
    const WRITES: &'static [&'static str] = &["flow_x", "flow_y"];
    type Params = PushParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &PushParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 0]) {
        let chance = R::of(0.5) + c.uniform(4);
        let x = p.keep * c.here(1) + p.push * chance * (c.here(0) - c.at(0, 1, 0));
        let y = p.keep * c.here(2) + p.push * chance * (c.here(0) - c.at(0, 0, 1));
        ([x, y], [])
    }
}

/// Stuff moves with the flows.
struct Move;

impl Rule for Move {
    const NAME: &'static str = "test_move";
    const READS: &'static [Read] = &[read("stuff", 0), read("flow_x", 1), read("flow_y", 1)];
    const WRITES: &'static [&'static str] = &["stuff"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "stuff.gained", unit: TallyUnit::Thickness, sign: 0, meaning: "Gains" }];
    type Params = PushParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(_: &PushParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let change = (c.at(1, -1, 0) - c.here(1)) + (c.at(2, 0, -1) - c.here(2));
        ([c.here(0) + change], [change.positive()])
    }
}

struct Flowing;

impl Process for Flowing {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![STUFF.changed(1.0), FLOW_X.changed(0.0), FLOW_Y.changed(0.0)]
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Push>(PushParams { keep: 0.5, push: 0.05 });
        plan.push::<Move>(PushParams { keep: 0.5, push: 0.05 });
    }
}

fn flowing() -> Vec<Scheduled> {
    vec![Scheduled { name: "flowing", process: Box::new(Flowing), every: 1 }]
}

fn first_world(rim: Boundary) -> World {
    conformance::random_world((29, 37), rim, 5, &flowing(), &|name, u| if name == "stuff" { u } else { 0.0 }).unwrap()
}

#[test]
fn rules_of_a_users_own_conform() {
    conformance::check(&flowing(), &|name, u| if name == "stuff" { u } else { u - 0.5 }).unwrap();
    conformance::check_graphs(&flowing(), Grid::new(20, 10, 1.0, Boundary::OPEN, &Limits::default()).unwrap());
}

/// What leaves over an open rim is on faces beyond the first row and column; who copies a world copies them.
#[test]
fn the_reference_carries_on_from_any_world() {
    for rim in conformance::rims() {
        let mut w = first_world(rim);
        let go = |w: &mut World, from, steps| {
            CpuEngine::default().simulate(w, &flowing(), Span { from, steps }, &Control::none()).unwrap();
        };
        go(&mut w, 0, 6);
        let mut reference = Reference::<f32>::new(&w);
        reference.simulate(&flowing(), 5);
        go(&mut w, 6, 5);
        assert_eq!((w.step, reference.step), (11, 11));
        for l in w.layers() {
            for y in 0..37 {
                for x in 0..29 {
                    let (a, b) = (l.field.get(x, y), reference.get(&l.spec.name, x, y));
                    assert!(
                        a.to_bits() == b.to_bits(),
                        "{rim:?} {} at ({x}, {y}): {a:e}, reference {b:e}",
                        l.spec.name
                    );
                }
            }
        }
    }
}

#[test]
fn a_cancelled_run_leaves_whole_steps() {
    for (chain, when) in [(0, 1), (1, 1), (1, 7), (2, 5), (3, 7), (5, 1), (64, 1)] {
        let engine = CpuEngine { chain, ..Default::default() };
        let cancel = Cancel::default();
        let (last, raised) = (AtomicU64::new(0), cancel.clone());
        let progress = |done: u64, total: u64| {
            assert_eq!(total, 20);
            assert!(done > last.swap(done, Ordering::Relaxed), "progress only grows");
            if done >= when {
                raised.raise();
            }
        };
        let mut stopped = first_world(Boundary::OPEN);
        let outcome =
            engine.simulate(&mut stopped, &flowing(), Span { from: 0, steps: 20 }, &Control::new(cancel, &progress));
        assert!(matches!(outcome, Err(Error::Cancelled(_))), "chain {chain}");
        assert_eq!(stopped.step, last.load(Ordering::Relaxed), "the world says how far it is");
        assert!((when..=20).contains(&stopped.step));

        let mut straight = first_world(Boundary::OPEN);
        let span = Span { from: 0, steps: stopped.step };
        engine.simulate(&mut straight, &flowing(), span, &Control::none()).unwrap();
        assert_eq!(stopped.fingerprint(), straight.fingerprint(), "chain {chain} stopped at {}", stopped.step);
        assert_eq!(stopped.ledger, straight.ledger);

        // And it may be carried on to where it would have been.
        let rest = Span { from: stopped.step, steps: 20 - stopped.step };
        engine.simulate(&mut stopped, &flowing(), rest, &Control::none()).unwrap();
        let mut whole = first_world(Boundary::OPEN);
        engine.simulate(&mut whole, &flowing(), Span { from: 0, steps: 20 }, &Control::none()).unwrap();
        assert_eq!(stopped.fingerprint(), whole.fingerprint());
        assert_eq!(stopped.ledger, whole.ledger);
    }
}

#[test]
fn a_refused_run_changes_nothing() {
    let mut w = first_world(Boundary::CLOSED);
    let before = w.fingerprint();
    let limits = Limits { max_bytes: 1000, ..Limits::default() };
    let engine = CpuEngine { limits, ..Default::default() };
    let outcome = engine.simulate(&mut w, &flowing(), Span { from: 0, steps: 1 }, &Control::none());
    assert!(matches!(outcome, Err(Error::Limit { .. })));
    assert_eq!(w.fingerprint(), before);
}

/// Spreads a layer of its own, for which a second copy is needed.
struct Spread;

impl Rule for Spread {
    const NAME: &'static str = "test_spread";
    const READS: &'static [Read] = &[read("smoke", 1)];
    const WRITES: &'static [&'static str] = &["smoke"];
    type Params = PushParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &PushParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([p.keep * (c.at(0, -1, 0) + c.at(0, 1, 0))], [])
    }
}

/// Sub-steps that make several chains of one step, the last of which needs more memory than the others.
struct Late;

impl Process for Late {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        let smoke = LayerSpec::new("smoke", "1", "Something that spreads", (0.0, 1.0));
        vec![STUFF.changed(1.0), FLOW_X.changed(0.0), FLOW_Y.changed(0.0), smoke.changed(1.0)]
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        for _ in 0..12 {
            plan.push::<Push>(PushParams { keep: 0.5, push: 0.05 });
            plan.push::<Move>(PushParams { keep: 0.5, push: 0.05 });
        }
        plan.push::<Spread>(PushParams { keep: 0.5, push: 0.0 });
    }
}

#[test]
fn a_step_that_lacks_memory_for_its_last_pass_is_not_begun() {
    let late = || vec![Scheduled { name: "late", process: Box::new(Late), every: 1 }];
    let mut w = conformance::random_world((29, 37), Boundary::OPEN, 5, &late(), &|_, u| u).unwrap();
    let before = w.clone();
    // Four fields of 93 x 39 values with their rims, 12 sums of 37 rows; a fifth field does not fit.
    let limits = Limits { max_bytes: 4 * 93 * 39 * 4 + 8 * 12 * 37, ..Limits::default() };
    let engine = CpuEngine { limits, ..Default::default() };
    let outcome = engine.simulate(&mut w, &late(), Span { from: 0, steps: 1 }, &Control::none());
    assert!(matches!(outcome, Err(Error::Limit { .. })), "{outcome:?}");
    assert_eq!(w, before);
}

/// Multiplies 1e30 with itself.
struct Explode;

impl Rule for Explode {
    const NAME: &'static str = "test_explode";
    const READS: &'static [Read] = &[read("stuff", 0)];
    const WRITES: &'static [&'static str] = &["stuff"];
    type Params = PushParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(_: &PushParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([c.here(0) * R::of(1e30)], [])
    }
}

struct Exploding;

impl Process for Exploding {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![STUFF.changed(1.0)]
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Explode>(PushParams { keep: 0.0, push: 0.0 });
    }
}

#[test]
fn what_is_not_finite_is_reported() {
    let mut w = World::new(Grid::new(3, 3, 1.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
    let processes = [Scheduled { name: "exploding", process: Box::new(Exploding), every: 1 }];
    let outcome = CpuEngine::default().simulate(&mut w, &processes, Span { from: 0, steps: 3 }, &Control::none());
    assert!(matches!(outcome, Err(Error::NotFinite { x: 0, y: 0, .. })), "{outcome:?}");
}

// -------------------------------------------------------------------------------------------------------------- Graphs

/// Says the same thing three times.
struct Repeats;

impl Rule for Repeats {
    const NAME: &'static str = "test_repeats";
    const READS: &'static [Read] = &[read("stuff", 1), read("flow_x", 0)];
    const WRITES: &'static [&'static str] = &["stuff", "flow_x"];
    type Params = PushParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 0];

    fn cell<R: Real>(p: &PushParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 0]) {
        let length = || (c.at(0, 1, 0) * c.at(0, 1, 0) + p.keep * c.here(1)).sqrt();
        // Nobody needs this.
        let _ = c.at(0, -1, -1).exp() * p.push;
        ([length() + length(), length() * R::of(2.0)], [])
    }
}

/// Layers of nothing but 3 and 4.
struct ThreeAndFour;

impl Cell<f32> for ThreeAndFour {
    fn at(&self, slot: usize, _: isize, _: isize) -> f32 {
        [3.0, 4.0][slot]
    }
    fn x(&self) -> f32 {
        0.0
    }
    fn y(&self) -> f32 {
        0.0
    }
    fn uniform(&self, _: u32) -> f32 {
        0.0
    }
}

#[test]
fn repeated_expressions_are_one_node() {
    let g = Graph::of::<Repeats>();
    // stuff(1, 0), flow_x, keep, two products, their sum, its root, the constant, and the two results.
    assert_eq!(g.nodes.len(), 10, "{:#?}", g.nodes);
    assert_eq!(g.nodes.iter().filter(|op| matches!(op, Op::Sqrt(_))).count(), 1);
    assert!(!g.nodes.iter().any(|op| matches!(op, Op::Read(0, -1, -1))), "what nobody needs is gone");
    for (i, &op) in g.nodes.iter().enumerate() {
        assert!(operands(op).into_iter().flatten().all(|o| (o as usize) < i), "operands come first");
        assert_eq!(g.nodes.iter().position(|&o| o == op), Some(i), "no node twice");
    }
    assert_eq!((g.reach(0), g.reach(1)), (1, 0));
    let (out, sums) = g.evaluate(&[4.0, 0.0], &ThreeAndFour);
    assert_eq!((out, sums), (vec![10.0, 10.0], vec![]));
}
