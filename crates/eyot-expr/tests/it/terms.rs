//! Expressions in the place of parameters, in a process that knows its parameters in every form that there is.

use eyot_core::engine::CpuEngine;
use eyot_core::plan::Plan;
use eyot_core::process::{Entry, Moment, Process, Scheduled, Span};
use eyot_core::real::Real;
use eyot_core::reference::Reference;
use eyot_core::rule::{Cell, Read, Rule, Side, Tally, TallyUnit, read};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, LayerSpec, Limits, World, given, rule_params};
use eyot_expr::{Known, Obstacle, ParameterizedProcess, Scope, Term, TermDefinition, Terms, term};
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
    /// As its sine.
    #[schemars(range(min = 0.0, max = 3.0), extend("unit" = "1"))]
    wave: f32,
    /// As the share of a time, times its logarithm: no curve that a few values tell.
    #[schemars(range(min = 0.1, max = 1000.0), extend("unit" = "s"))]
    curved: f32,
    /// How often it is done.
    #[schemars(range(min = 1.0, max = 9.0), extend("unit" = "1"))]
    parts: f32,
    /// What is known to decide something.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "1"))]
    choice: f32,
    /// Taken past the plan.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    hidden: f32,
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
        let (wave, curved, parts, choice, hidden) = (1.0, 12.0, 1.0, 0.5, 0.25);
        let (exchange, nothing, together) = (0.1, 0.5, 1.0);
        Self { plain, scaled, rate, time, square, wave, curved, parts, choice, hidden, exchange, nothing, together }
    }
}

const DT: f32 = 0.7;
const STUFF: LayerSpec = LayerSpec::new("stuff", "m", "", (-1e6, 1e6));

impl Process for Pot {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![STUFF.changed(1.0)]
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        let (scaled, square) = (given!(plan, self.scaled), given!(plan, self.square));
        let (time, curved) = (given!(plan, self.time), given!(plan, self.curved));
        let sign = if given!(plan, self.choice).decides() < 0.0 { -1.0 } else { 1.0 };
        for _ in 0..self.parts as usize {
            plan.push_given::<Boil>(BoilParams {
                plain: given!(plan, self.plain),
                offset: 1.0 - 0.25 * scaled,
                product: 0.1 * given!(plan, self.together) * scaled,
                share: 1.0 - eyot_core::math::exp(-given!(plan, self.rate) * DT),
                follow: 1.0 - eyot_core::math::exp(-DT / time),
                square: square * square,
                wave: eyot_core::math::sin(given!(plan, self.wave)) + self.hidden - 0.25,
                curved: sign * (1.0 - eyot_core::math::exp(-DT / curved)) * eyot_core::math::ln(curved),
                exchange: self.exchange.into(),
                sea: (moment.sea_level_m as f32).into(),
            });
        }
    }
}

rule_params! {
    /// Parameters of [`Boil`].
    struct BoilParams { plain, offset, product, share, follow, square, wave, curved, exchange, sea }
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
        let made = p.plain * R::of(0.1) + steam - R::of(1e-4) * p.square * p.wave + p.curved;
        let moved = p.exchange * ((c.at(0, 1, 0) - h) + (c.at(0, -1, 0) - h));
        ([h + moved + made], [made])
    }

    #[inline(always)]
    fn boundary_outflow<R: Real>(p: &BoilParams<R>, c: &impl Cell<R>, side: Side) -> Option<[R; 1]> {
        Some([match side {
            Side::West | Side::East => p.plain * c.here(0),
            _ => R::of(0.0),
        }])
    }
}

static ENTRY: Entry<dyn Process> = Entry::<dyn Process>::process::<Pot>("pot", "", &[]);

/// Parameters that may differ from cell to cell, and expressions with chance, neighbours, places and time.
const TERMS: [(&str, &str); 8] = [
    ("plain", "0.5 * moss * step(0.3, u)"),
    ("scaled", "10 * mean4(moss) - 5 * random()"),
    ("rate", "0.1 * moss[1, -2]"),
    ("time", "5 + 40 * v"),
    ("square", "if(steps < 4, 2, 9 * moss)"),
    ("wave", "3 * moss"),
    ("curved", "1 + 30 * moss"),
    ("together", "1 + u"),
];

fn scope() -> Scope {
    let spec = LayerSpec::new("moss", "1", "", (0.0, 1.0));
    Scope { layers: vec![Known { spec, measured: true, declared: None }] }
}

fn checked(parameter: &str, text: &str) -> Arc<Term> {
    let schema = (ENTRY.schema)().to_value();
    let (unit, range) = eyot_expr::of_schema(&schema["properties"][parameter]);
    let definition =
        TermDefinition { process: "pot".into(), parameter: parameter.into(), unit, range, text: text.into() };
    Arc::new(term(&definition, &scope()).unwrap())
}

fn replaced(terms: &[(&str, &str)]) -> ParameterizedProcess {
    let list = terms.iter().map(|(name, text)| checked(name, text)).collect();
    ParameterizedProcess::new(&ENTRY, json!({}), Terms::new(list)).unwrap()
}

/// The process with one number of its own.
fn plain(name: &str, value: impl Into<Value>) -> Box<dyn Process> {
    let mut table = json!({});
    table[name] = value.into();
    (ENTRY.make)(table).unwrap()
}

fn grid(rim: Boundary) -> Grid {
    Grid::new(37, 19, 10.0, rim, &Limits::default()).unwrap()
}

fn world(rim: Boundary) -> World {
    let mut world = World::new(grid(rim), 5);
    world.put(&scope().layers[0].spec, Field::from_fn(37, 19, |x, y| ((x * 7 + y * 13) % 10) as f32 / 9.0)).unwrap();
    world.put(&STUFF, Field::from_fn(37, 19, |x, y| ((x * 3 + y * 5) % 11) as f32 - 4.0)).unwrap();
    world
}

/// The stuff after some steps on a ring.
fn after(steps: u64, process: Box<dyn Process>) -> Field {
    let mut world = world(Boundary::WRAP);
    run(&mut world, steps, process);
    world.get("stuff").unwrap().clone()
}

fn run(world: &mut World, steps: u64, process: Box<dyn Process>) {
    let processes = [Scheduled { name: "pot", process, every: 1 }];
    CpuEngine::default().simulate(world, &processes, Span { from: 0, steps }, &Control::none()).unwrap();
}

/// The same as the number, to the bit, whatever it is to the rule.
#[test]
fn what_is_the_same_in_all_cells_is_the_number() {
    let numbers = [
        ("plain", 0.75),
        ("scaled", 3.0),
        ("rate", 0.09),
        ("time", 11.0),
        ("square", 8.0),
        ("wave", 2.25),
        ("curved", 3.5),
        ("together", 2.5),
    ];
    for (name, value) in numbers {
        let expected = after(9, plain(name, value));
        assert_ne!(expected, after(9, plain(name, 1.5 * value)), "{name} does nothing");
        for text in [format!("{value}"), format!("{value} + 0 * moss"), format!("if(moss > -1, {value}, 0)")] {
            assert_eq!(expected, after(9, Box::new(replaced(&[(name, &text)]))), "{name} as `{text}`");
        }
    }
}

/// Several expressions at once, on all rims: the engine is the reference, bit by bit.
#[test]
fn the_engine_agrees_with_the_reference() {
    let edges = [BoundaryCondition::Closed, BoundaryCondition::Open, BoundaryCondition::Wrap];
    for rim in edges.iter().flat_map(|&x| edges.iter().map(move |&y| Boundary { x, y })) {
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

/// What each cell gets is what the process gives where that number is everybody's, to the bit.
#[test]
fn each_cell_has_its_own_number() {
    let moss = world(Boundary::WRAP).get("moss").unwrap().clone();
    for (name, _) in TERMS {
        let low = if name == "scaled" { -7.0 } else { 0.5 };
        let varied = after(1, Box::new(replaced(&[(name, &format!("{low} + 2 * moss"))])));
        for (x, y) in [(0, 0), (3, 7), (20, 11), (36, 18)] {
            let value = low + 2.0 * moss.get(x, y);
            let (a, b) = (varied.get(x, y), after(1, plain(name, value)).get(x, y));
            assert_eq!(a.to_bits(), b.to_bits(), "{name} = {value}: {a} instead of {b}");
        }
    }
}

/// A line through two values, and an exponential through three, is not what `curved` is to its rule: both are off by more than
/// rounding at a value in between, where the expression is not.
#[test]
fn no_curve_through_a_few_values_is_what_the_process_computes() {
    let way = |v: f64| (1.0 - (-f64::from(DT) / v).exp()) * v.ln();
    let at = [0.0, 1.0, 2.0].map(|i| 6.0 + 12.0 * i / 2.0);
    let middle = 9.0;
    let line = way(at[0]) + (way(at[2]) - way(at[0])) * (middle - at[0]) / (at[2] - at[0]);
    let ratio = (way(at[2]) - way(at[1])) / (way(at[1]) - way(at[0]));
    let part = (way(at[0]) - way(at[1])) / (1.0 - ratio);
    let bend = way(at[0]) - part + part * ratio.powf((middle - at[0]) / (at[1] - at[0]));
    assert!((line - way(middle)).abs() > 1e-2 && (bend - way(middle)).abs() > 1e-4, "{line} {bend} {}", way(middle));
    let varied = after(1, Box::new(replaced(&[("curved", "9 + 0 * moss")])));
    assert_eq!(varied, after(1, plain("curved", 9.0)));
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
        process.obstacle(&grid(Boundary::WRAP)).map(|(name, o)| (name.to_owned(), o))
    };
    let of = |name: &str, o| Some((name.to_owned(), o));
    assert_eq!(obstacle(&TERMS), None);
    for (name, why) in [
        ("parts", Obstacle::Structure),
        ("choice", Obstacle::Structure),
        ("hidden", Obstacle::Structure),
        ("exchange", Obstacle::Between),
        ("nothing", Obstacle::Unused),
    ] {
        assert_eq!(obstacle(&[(name, "1 + moss")]), of(name, why));
        // As a number that changes in time it can be anything.
        assert_eq!(obstacle(&[(name, "1 + 0.1 * steps")]), None, "{name}");
    }
    assert_eq!(
        ParameterizedProcess::possible(&ENTRY),
        ["plain", "scaled", "rate", "time", "square", "wave", "curved", "together"]
    );
}
