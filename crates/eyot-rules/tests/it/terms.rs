//! Expressions in the place of parameters, in a process that knows its parameters in every form that there is.

use eyot_core::engine::CpuEngine;
use eyot_core::plan::Plan;
use eyot_core::process::{Entry, Moment, Process, Scheduled, Span};
use eyot_core::real::Real;
use eyot_core::reference::Reference;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::{Control, Edge, Field, Grid, LayerSpec, Limits, Rim, World, rule_params};
use eyot_rules::{Known, Obstacle, Replaced, Scope, Term, TermDefinition, Terms, term};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::sync::Arc;

/// Something with parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Pot {
    /// As it is.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "m/s"))]
    plain: f32,
    /// In another unit, and in two places.
    #[schemars(range(min = -100.0, max = 100.0), extend("unit" = "1"))]
    scaled: f32,
    /// As the share of a rate.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "1/s"))]
    rate: f32,
    /// As the share of a time.
    #[schemars(range(min = 0.1, max = 1000.0), extend("unit" = "s"))]
    time: f32,
    /// As its square.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "m"))]
    square: f32,
    /// In no form that is known.
    #[schemars(range(min = 0.0, max = 3.0), extend("unit" = "1"))]
    wave: f32,
    /// How often it is done.
    #[schemars(range(min = 1.0, max = 9.0), extend("unit" = "1"))]
    parts: f32,
    /// Between cells.
    #[schemars(range(min = 0.0, max = 0.25), extend("unit" = "1", "between_cells" = true))]
    exchange: f32,
    /// Nowhere.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    nothing: f32,
    /// Together with `scaled`.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1"))]
    together: f32,
}

impl Default for Pot {
    fn default() -> Self {
        let (plain, scaled, rate, time, square) = (0.3, -2.0, 0.05, 24.0, 5.0);
        Self { plain, scaled, rate, time, square, wave: 1.0, parts: 1.0, exchange: 0.1, nothing: 0.5, together: 1.0 }
    }
}

const DT: f32 = 0.7;
const STUFF: LayerSpec = LayerSpec::new("stuff", "m", "", (-1e6, 1e6));

impl Process for Pot {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![STUFF.changed(1.0)]
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        for _ in 0..self.parts as usize {
            plan.push::<Boil>(BoilParams {
                plain: self.plain,
                offset: 1.0 - 0.25 * self.scaled,
                product: 0.1 * self.together * self.scaled,
                share: 1.0 - eyot_core::math::exp(-self.rate * DT),
                follow: 1.0 - eyot_core::math::exp(-DT / self.time),
                square: self.square * self.square,
                wave: eyot_core::math::sin(self.wave),
                exchange: self.exchange,
                sea: moment.sea_level_m as f32,
            });
        }
    }
}

rule_params! {
    /// Parameters of [`Boil`].
    struct BoilParams { plain, offset, product, share, follow, square, wave, exchange, sea }
}

struct Boil;

impl Rule for Boil {
    const NAME: &'static str = "boil";
    const READS: &'static [Read] = &[read("stuff", 1)];
    const WRITES: &'static [&'static str] = &["stuff"];
    const TALLIES: &'static [Tally] =
        &[Tally { account: "stuff.made", unit: TallyUnit::Thickness, sign: 1, meaning: "made" }];
    type Params = BoilParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 1];

    #[inline(always)]
    fn cell<R: Real>(p: &BoilParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 1]) {
        let h = c.here(0);
        let steam = p.share * (p.offset - h) + p.follow * (p.product + p.sea);
        let made = p.plain * R::of(0.1) + steam - R::of(1e-4) * p.square * p.wave;
        let moved = p.exchange * ((c.at(0, 1, 0) - h) + (c.at(0, -1, 0) - h));
        ([h + moved + made], [made])
    }

    #[inline(always)]
    fn leaving<R: Real>(p: &BoilParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 1]> {
        Some([match side {
            Side::West | Side::East => p.plain * c.here(0),
            _ => R::of(0.0),
        }])
    }
}

static ENTRY: Entry<dyn Process> = Entry::<dyn Process>::process::<Pot>("pot", "", &[]);

/// Parameters that may differ from cell to cell, and expressions with chance, neighbours, places and time.
const TERMS: [(&str, &str); 5] = [
    ("plain", "0.5 * moss * step(0.3, u)"),
    ("scaled", "10 * mean4(moss) - 5 * random()"),
    ("rate", "0.1 * moss[1, -2]"),
    ("time", "5 + 40 * v"),
    ("square", "if(steps < 4, 2, 9 * moss)"),
];

fn scope() -> Scope {
    let spec = LayerSpec::new("moss", "1", "", (0.0, 1.0));
    Scope { layers: vec![Known { spec, measured: true, declared: None }] }
}

fn checked(parameter: &str, text: &str) -> Arc<Term> {
    let schema = (ENTRY.schema)().to_value();
    let (unit, range) = eyot_rules::of_schema(&schema["properties"][parameter]);
    let definition =
        TermDefinition { process: "pot".into(), parameter: parameter.into(), unit, range, text: text.into() };
    Arc::new(term(&definition, &scope()).unwrap())
}

fn replaced(terms: &[(&str, &str)]) -> Replaced {
    let list = terms.iter().map(|(name, text)| checked(name, text)).collect();
    Replaced::new(&ENTRY, json!({}), Terms::new(list)).unwrap()
}

/// The process with one number of its own.
fn plain(name: &str, value: impl Into<Value>) -> Box<dyn Process> {
    let mut table = json!({});
    table[name] = value.into();
    (ENTRY.make)(table).unwrap()
}

fn grid(rim: Rim) -> Grid {
    Grid::new(37, 19, 10.0, rim, &Limits::default()).unwrap()
}

fn world(rim: Rim) -> World {
    let mut world = World::new(grid(rim), 5);
    world.put(&scope().layers[0].spec, Field::from_fn(37, 19, |x, y| ((x * 7 + y * 13) % 10) as f32 / 9.0)).unwrap();
    world.put(&STUFF, Field::from_fn(37, 19, |x, y| ((x * 3 + y * 5) % 11) as f32 - 4.0)).unwrap();
    world
}

/// The stuff after some steps on a ring.
fn after(steps: u64, process: Box<dyn Process>) -> Field {
    let mut world = world(Rim::WRAP);
    run(&mut world, steps, process);
    world.get("stuff").unwrap().clone()
}

fn run(world: &mut World, steps: u64, process: Box<dyn Process>) {
    let processes = [Scheduled { name: "pot", process, every: 1 }];
    CpuEngine::default().simulate(world, &processes, Span { from: 0, steps }, &Control::none()).unwrap();
}

/// The same as the number: to the bit where it is one number for all cells, or where the rule knows it as it is.
#[test]
fn what_is_the_same_in_all_cells_is_the_number() {
    let numbers =
        [("plain", 0.75, 0.0), ("scaled", 3.0, 3e-5), ("rate", 0.09, 3e-5), ("time", 11.0, 3e-5), ("square", 8.0, 0.0)];
    for (name, value, tolerance) in numbers {
        let expected = after(9, plain(name, value));
        for (text, tolerance) in [(format!("{value}"), 0.0), (format!("{value} + 0 * moss"), tolerance)] {
            let found = after(9, Box::new(replaced(&[(name, &text)])));
            let worst = expected.iter().zip(found.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst <= tolerance, "{name} as `{text}` is off by {worst}");
        }
    }
}

/// Several expressions at once, on all rims: the engine is the reference, bit by bit.
#[test]
fn the_engine_agrees_with_the_reference() {
    let edges = [Edge::Closed, Edge::Open, Edge::Wrap];
    for rim in edges.iter().flat_map(|&x| edges.iter().map(move |&y| Rim { x, y })) {
        let mut world = world(rim);
        let mut reference = Reference::<f32>::new(&world);
        let before = world.clone();
        run(&mut world, 9, Box::new(replaced(&TERMS)));
        let process: Box<dyn Process> = Box::new(replaced(&TERMS));
        reference.simulate(&[Scheduled { name: "pot", process, every: 1 }], 9);
        for (x, y) in (0..19).flat_map(|y| (0..37).map(move |x| (x, y))) {
            let (a, b) = (world.get("stuff").unwrap().get(x, y), reference.get("stuff", x, y));
            assert_eq!(a.to_bits(), b.to_bits(), "{a} {b} at {x} {y} on {rim:?}");
        }
        assert_ne!(world.get("stuff"), before.get("stuff"));
        let (own, other) = (world.ledger.amount("stuff.made"), reference.ledger["stuff.made"]);
        assert!((own - other).abs() <= 1e-5 * other.abs().max(1e3), "{own} {other} on {rim:?}");
    }
}

/// What each cell gets is what the process gives where that number is everybody's.
#[test]
fn each_cell_has_its_own_number() {
    let moss = world(Rim::WRAP).get("moss").unwrap().clone();
    for (name, _) in TERMS {
        let low = if name == "scaled" { -7.0 } else { 0.5 };
        let varied = after(1, Box::new(replaced(&[(name, &format!("{low} + 5 * moss"))])));
        for (x, y) in [(0, 0), (3, 7), (20, 11), (36, 18)] {
            let value = low + 5.0 * moss.get(x, y);
            let (a, b) = (varied.get(x, y), after(1, plain(name, value)).get(x, y));
            assert!((a - b).abs() <= 2e-5 * (1.0 + b.abs()), "{name} = {value}: {a} instead of {b}");
        }
    }
}

/// Beyond the range is its end.
#[test]
fn values_are_kept_within_the_range() {
    let end = after(9, plain("plain", 10.0));
    for text in ["1000 + 1 * moss", "1000 + 1 * steps"] {
        assert_eq!(after(9, Box::new(replaced(&[("plain", text)]))), end, "{text}");
    }
}

#[test]
fn what_cannot_differ_from_cell_to_cell_says_why() {
    let obstacle = |terms: &[(&str, &str)]| {
        let process = replaced(terms);
        process.obstacle(&grid(Rim::WRAP)).map(|(name, o)| (name.to_owned(), o))
    };
    let of = |name: &str, o| Some((name.to_owned(), o));
    assert_eq!(obstacle(&TERMS), None);
    for (name, why) in [
        ("wave", Obstacle::Curved("boil")),
        ("parts", Obstacle::Structure),
        ("exchange", Obstacle::Between),
        ("nothing", Obstacle::Unused),
    ] {
        assert_eq!(obstacle(&[(name, "1 + moss")]), of(name, why));
        // As a number that changes in time it can be anything.
        assert_eq!(obstacle(&[(name, "1 + 0.1 * steps")]), None, "{name}");
    }
    let shared = obstacle(&[("scaled", "1 + moss"), ("together", "1 + 0.5 * moss")]);
    assert_eq!(shared, of("together", Obstacle::Shared("scaled".into())));
    assert_eq!(Replaced::possible(&ENTRY), ["plain", "scaled", "rate", "time", "square", "together"]);
}
