//! Programs give what the rules whose graphs they are give, bit by bit, in every way of running them.

use eyot_core::conformance::{self, random_world};
use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::graph::{Graph, Node};
use eyot_core::isa::Isa;
use eyot_core::plan::Plan;
use eyot_core::process::{Moment, Process, Scheduled, Span};
use eyot_core::program::{MAX_OPERATIONS, Program};
use eyot_core::real::{Bits, Real};
use eyot_core::rule::{Cell, MAX_READS, Read, Rule, Tally, TallyUnit, read};
use eyot_core::{Centering, Error, LayerSpec, rule_params};
use std::sync::Arc;

rule_params! {
    /// Parameters of [`Everything`].
    pub struct EverythingParams {
        /// A factor.
        factor,
        /// Another one.
        other,
    }
}

/// A rule with every operation that there is.
struct Everything;

impl Rule for Everything {
    const NAME: &'static str = "everything";
    const READS: &'static [Read] = &[read("stuff", 2), read("flow", 1)];
    const WRITES: &'static [&'static str] = &["stuff", "flow"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "stuff.counted", unit: TallyUnit::Count, sign: 0, meaning: "counted" }];
    type Params = EverythingParams<()>;
    type Out<R: Real> = [R; 2];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &EverythingParams<R>, c: &impl Cell<R>) -> ([R; 2], [R; 1]) {
        let h = c.here(0);
        let around = (c.at(0, 1, 0) - h).max(-p.factor).min(p.factor) + (c.at(0, -2, 2) * p.other - h) * p.factor;
        let wave = (c.x() * p.factor + c.y()).sin() + (c.uniform(7) - R::of(0.5)).exp().ln().abs().sqrt();
        let bits = h.to_bits().shr(9).and(R::Bits::of(63)).or(R::Bits::of(1)).xor(R::Bits::of(5)).add(R::Bits::of(2));
        let chosen = h.lt(c.here(1)).pick(wave.floor(), -around / (R::of(2.0) + wave * wave));
        let new = (R::of(0.5) * h + R::of(0.001) * chosen + p.other * bits.to_real()).flushed();
        let flow = (c.at(1, 0, -1) + c.at(1, 1, 0)).clamp(R::of(-1.0), new - p.factor * around);
        ([new.clamp(R::of(-3.0), R::of(3.0)), flow], [new.gt(R::of(1.0)).one() + wave])
    }
}

struct Typed;
struct Programmed(Arc<Program>);

fn layers() -> Vec<eyot_core::process::LayerUse> {
    let stuff = LayerSpec::new("stuff", "1", "", (-3.0, 3.0));
    vec![stuff.changed(0.0), LayerSpec::new("flow", "1", "", (-9.0, 9.0)).on(Centering::FaceX).changed(0.0)]
}

impl Process for Typed {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        layers()
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Everything>(EverythingParams { factor: 0.3, other: 0.01 });
    }
}

impl Process for Programmed {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        layers()
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push_program(&self.0, vec![0.3, 0.01]);
    }
}

fn scheduled(process: impl Process + 'static) -> Vec<Scheduled> {
    vec![Scheduled { name: "everything", process: Box::new(process), every: 1 }]
}

fn program() -> Arc<Program> {
    Program::new(Graph::of::<Everything>(), Everything::TALLIES.to_vec()).unwrap()
}

fn start(_: &str, u: f32) -> f32 {
    6.0 * u - 3.0
}

#[test]
fn the_engine_runs_a_program_as_the_reference_does() {
    conformance::check(&scheduled(Programmed(program())), &start).unwrap();
}

/// Also over rows of several blocks, which the shapes of the suite are too small for.
#[test]
fn a_program_gives_the_bits_of_its_rule() {
    for shape in [(1, 1), (63, 5), (64, 4), (1500, 9)] {
        for rim in conformance::rims() {
            let (typed, programmed) = (scheduled(Typed), scheduled(Programmed(program())));
            let before = random_world(shape, rim, 3, &typed, &start).unwrap();
            for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
                let run = |processes: &[Scheduled]| {
                    let mut world = before.clone();
                    let engine = CpuEngine { isa, ..CpuEngine::default() };
                    engine.simulate(&mut world, processes, Span { from: 0, steps: 3 }, &Control::none()).unwrap();
                    world
                };
                let (want, got) = (run(&typed), run(&programmed));
                assert_eq!(got.fingerprint(), want.fingerprint(), "{shape:?} {rim:?} {}", isa.name());
                // The program's graph has no part for what leaves; this rule lets nothing leave.
                assert_eq!(got.ledger, want.ledger, "{shape:?} {rim:?} {}", isa.name());
            }
        }
    }
}

rule_params! {
    /// Parameters of [`Slump`].
    pub struct SlumpParams {
        /// Difference that stays.
        stay,
        /// Share of the rest that moves.
        rate,
    }
}

/// What exceeds a difference slumps: thermal erosion as `eyot-land` has it.
struct Slump;

#[inline(always)]
fn excess<R: Real>(c: &impl Cell<R>, dx: isize, dy: isize, stay: R) -> R {
    let d = c.at(0, dx, dy) - c.here(0);
    d - d.clamp(-stay, stay)
}

impl Rule for Slump {
    const NAME: &'static str = "slump";
    const READS: &'static [Read] = &[read("stuff", 1)];
    const WRITES: &'static [&'static str] = &["stuff"];
    type Params = SlumpParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    #[inline(always)]
    fn cell<R: Real>(p: &SlumpParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let x = excess(c, 1, 0, p.stay) + excess(c, -1, 0, p.stay);
        let y = excess(c, 0, 1, p.stay) + excess(c, 0, -1, p.stay);
        let d = (excess(c, 1, 1, p.stay) + excess(c, -1, -1, p.stay))
            + (excess(c, -1, 1, p.stay) + excess(c, 1, -1, p.stay));
        ([c.here(0) + (p.rate * (x + y) + p.rate * R::of(0.5) * d)], [])
    }
}

struct Slumping(Option<Arc<Program>>);

impl Process for Slumping {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        layers()
    }
    fn plan(&self, _: &Moment, plan: &mut Plan) {
        match &self.0 {
            Some(program) => plan.push_program(program, vec![0.3, 0.04]),
            None => plan.push::<Slump>(SlumpParams { stay: 0.3, rate: 0.04 }),
        }
    }
}

/// `cargo test --release -p eyot-core --test it programs -- --ignored --nocapture` on a quiet machine.
#[test]
#[ignore = "times depend on what else the machine does"]
fn a_program_takes_at_most_twice_the_time_of_its_rule() {
    // So small that a run ends before the system gives the processor to somebody else.
    let n = 512;
    let program = Program::new(Graph::of::<Slump>(), vec![]).unwrap();
    let both = [scheduled(Slumping(None)), scheduled(Slumping(Some(program)))];
    let before = random_world((n, n), eyot_core::Boundary::CLOSED, 3, &both[0], &start).unwrap();
    let (mut worlds, mut best) = ([before.clone(), before], [f64::MAX; 2]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        for _ in 0..300 {
            for ((world, processes), best) in worlds.iter_mut().zip(&both).zip(&mut best) {
                let begun = std::time::Instant::now();
                let span = Span { from: 0, steps: 2 };
                CpuEngine::default().simulate(world, processes, span, &Control::none()).unwrap();
                *best = best.min(begun.elapsed().as_secs_f64() / 2.0);
            }
        }
    });
    assert_eq!(worlds[0].fingerprint(), worlds[1].fingerprint());
    let per = best.map(|t| 1e9 * t / (n * n) as f64);
    println!("Rust {:.3} ns a cell, program {:.3} ns, ratio {:.2}", per[0], per[1], per[1] / per[0]);
    assert!(best[1] < 2.0 * best[0]);
}

#[test]
fn a_program_that_is_too_large_is_refused() {
    let reads: Vec<&'static str> = vec!["stuff"; MAX_READS + 1];
    let graph = Graph::record("wide", vec![], reads, vec!["stuff"], |c, _| (vec![c.here(0)], vec![]));
    assert!(matches!(Program::new(graph, vec![]), Err(Error::Limit { .. })));
    let graph = Graph::record("far", vec![], vec!["stuff"], vec!["stuff"], |c, _| (vec![c.at(0, 3, 0)], vec![]));
    assert!(matches!(Program::new(graph, vec![]), Err(Error::Limit { .. })));
    let graph = Graph::record("long", vec![], vec!["stuff"], vec!["stuff"], |c, _| {
        let sum = (0..MAX_OPERATIONS).fold(c.here(0), |sum, i| sum * (sum + Node::of(i as f32)));
        (vec![sum], vec![])
    });
    assert!(matches!(Program::new(graph, vec![]), Err(Error::Limit { .. })));
    let graph = Graph::record("infinite", vec![], vec!["stuff"], vec!["stuff"], |c, _| {
        (vec![c.here(0) + Node::of(1.0) / Node::of(0.0)], vec![])
    });
    assert!(matches!(Program::new(graph, vec![]), Err(Error::BadParameter { .. })));
}
