//! Terms: parameters of a built-in process that a recipe gives as expressions.
//!
//! An expression that is the same for all cells, for it depends on time and sea level alone, gives the process another number in
//! each step. One that differs from cell to cell goes into the rules themselves: a built-in rule leaves its graph behind, the
//! expression takes the place of the parameter's node, and the result is a [`Program`] that both engines run as they run
//! a recipe's own rules.
//!
//! # From a parameter to what rules know of it
//! Processes turn their parameters into those of their rules, with the length of a step or the size of a cell. How, is found by asking
//! the process for its plan at several values: `p = a + b w` or `p = a + b e^(-k w)`, `w` the parameter, its inverse or its square. What is
//! neither, or decides more than numbers in rules, can only change in time.

use crate::evaluate::{Evaluation, between};
use crate::meaning::{Given, Scope, Uses, Wanted, check};
use crate::mistake::Mistake;
use crate::rule::{DeclaredLayer, complete, split, stream};
use crate::unit::Measure;
use eyot_core::graph::{Graph, Node, Op};
use eyot_core::plan::{Plan, RuleKind};
use eyot_core::process::{Access, Action, Entry, LayerUse, Moment, Process};
use eyot_core::program::Program;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Slot};
use eyot_core::{Edge, Error, Grid, Limits, Result, Rim, World, intern};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Steps at which a parameter's way into the rules is looked at before it is taken for one.
const MOMENTS: [u64; 6] = [0, 1, 10, 333, 12_345, 1_000_003];

/// A parameter and the text that gives its value.
#[derive(Clone, Debug)]
pub struct TermDefinition {
    /// Name of the process.
    pub process: String,
    /// Name of the parameter.
    pub parameter: String,
    /// Its unit.
    pub unit: String,
    /// Its smallest and largest value; others are moved to the nearer one.
    pub range: (f32, f32),
    /// The text.
    pub text: String,
}

/// A parameter as a checked expression.
#[derive(Debug)]
pub struct Term {
    parameter: String,
    text: String,
    range: (f32, f32),
    /// Its value, kept within the range.
    graph: Graph,
    /// Where the parameters of the graph come from.
    given: Vec<Given>,
    declared: Vec<Arc<DeclaredLayer>>,
    needs: Vec<&'static str>,
}

/// Checks the text of a term.
///
/// # Errors
/// What is wrong, with its place.
pub fn term(definition: &TermDefinition, scope: &Scope) -> Result<Term, Mistake> {
    let d = definition;
    let name = format!("{}.{}", d.process, d.parameter);
    let mut uses = Uses::default();
    let wanted = Wanted::Parameter(&Measure::of(&d.unit), &d.parameter);
    let formula = check(&d.text, wanted, scope, &[], stream(&name, "term"), &mut uses)?;
    let whole = |e: Error| Mistake::at(&(0..d.text.len()), e.to_string(), "here");
    let list = |names: Vec<String>| names.iter().map(|n| intern(n)).collect::<Result<Vec<_>>>().map_err(whole);
    let params = list((0..uses.params.len()).map(|i| format!("given_{i}")).collect())?;
    let reads = list(uses.reads.clone())?;
    let graph = Graph::record(intern(&name).map_err(whole)?, params, reads, vec!["value"], |cell, params| {
        let value = Evaluation::new(&formula, params, cell).number().flushed();
        (vec![between(value, Real::of(d.range.0), Real::of(d.range.1))], Vec::new())
    });
    let (declared, needs) = split(&uses.reads, scope).map_err(whole)?;
    Ok(Term {
        parameter: d.parameter.clone(),
        text: d.text.clone(),
        range: d.range,
        graph,
        given: uses.params,
        declared,
        needs,
    })
}

impl Term {
    /// Name of the parameter.
    pub fn parameter(&self) -> &str {
        &self.parameter
    }

    /// The expression.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether its value may differ from cell to cell.
    pub fn varies(&self) -> bool {
        self.graph.nodes.iter().any(|op| matches!(op, Op::Read(..) | Op::X | Op::Y | Op::Uniform(_)))
    }

    fn values(&self, moment: &Moment) -> Vec<f32> {
        self.given.iter().map(|g| g.value(&[], &moment.grid, moment.sea_level_m, moment.step)).collect()
    }

    /// The value of a term that does not vary.
    fn number(&self, moment: &Moment) -> f32 {
        self.graph.evaluate(&self.values(moment), &Nowhere).0[0]
    }
}

/// A cell for what needs none.
struct Nowhere;

impl Cell<f32> for Nowhere {
    fn at(&self, _slot: Slot, _dx: isize, _dy: isize) -> f32 {
        0.0
    }
    fn x(&self) -> f32 {
        0.0
    }
    fn y(&self) -> f32 {
        0.0
    }
    fn uniform(&self, _stream: u32) -> f32 {
        0.0
    }
}

/// A cell whose layers have other slots.
struct Moved<'a, C> {
    cell: &'a C,
    slots: &'a [usize],
}

impl<R: Real, C: Cell<R>> Cell<R> for Moved<'_, C> {
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> R {
        self.cell.at(self.slots[slot], dx, dy)
    }
    fn x(&self) -> R {
        self.cell.x()
    }
    fn y(&self) -> R {
        self.cell.y()
    }
    fn uniform(&self, stream: u32) -> R {
        self.cell.uniform(stream)
    }
}

/// Why a parameter cannot differ from cell to cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// It acts on matter between two cells, which would see different values of it.
    Between,
    /// No rule of cells depends on it.
    Unused,
    /// It decides which rules run or what else happens.
    Structure,
    /// A rule's parameter depends on it in a way that is not known.
    Curved(&'static str),
    /// A rule's parameter depends on this one, too, which is another expression.
    Shared(String),
    /// A rule with the expression in it is more than an engine handles.
    Limit(String),
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Between => {
                write!(f, "matter would be made or lost between two cells that see different values of it")
            }
            Self::Unused => write!(f, "no rule of cells depends on it here"),
            Self::Structure => write!(f, "it decides more than what happens in a cell"),
            Self::Curved(rule) => write!(f, "what it is to the rule `{rule}` has to be computed once for all cells"),
            Self::Shared(other) => write!(f, "its effect depends on `{other}`, which is an expression, too"),
            Self::Limit(reason) => write!(f, "{reason}"),
        }
    }
}

/// What of a process's parameter `v` a rule's parameter follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Seen {
    Itself,
    Inverse,
    Square,
}

impl Seen {
    fn of(self, v: f64) -> f64 {
        match self {
            Self::Itself => v,
            Self::Inverse => 1.0 / v,
            Self::Square => v * v,
        }
    }
}

/// How a rule's parameter follows a process's: `base + slope * w`, or `base + slope * exp(rate * w)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    seen: Seen,
    exponential: bool,
    base: f64,
    slope: f64,
    rate: f64,
}

impl Way {
    /// Finds it from values of the rule's parameter: `even` at evenly spaced values, `inverse` at values whose inverses are
    /// evenly spaced, `others` anywhere.
    fn find(even: &[(f64, f64)], inverse: &[(f64, f64)], others: &[(f64, f64)]) -> Option<Self> {
        let all = || even.iter().chain(inverse).chain(others).filter(|(_, p)| p.is_finite());
        let (low, high) = all().fold((f64::MAX, f64::MIN), |(l, h), (_, p)| (l.min(*p), h.max(*p)));
        let (spread, largest) = (high - low, high.abs().max(low.abs()));
        let off = |way: &Self| {
            let miss = all().map(|(v, p)| (way.at(*v) - p).abs());
            miss.fold(0.0, |m: f64, d| if d.is_nan() { f64::INFINITY } else { m.max(d) })
        };
        let candidates = [
            Self::line(even, Seen::Itself),
            Self::approach(even, Seen::Itself),
            Self::line(inverse, Seen::Inverse),
            Self::approach(inverse, Seen::Inverse),
            Self::line(even, Seen::Square),
        ];
        let mut found: Vec<(f64, Self)> = candidates.into_iter().flatten().map(|w| (off(&w), w)).collect();
        found.retain(|(off, _)| off.is_finite());
        // Within what single precision leaves of it, the first that fits is meant. What processes compute on the way may have
        // been rounded more coarsely than the result; then the best is.
        let exact = 1e-5 * spread + 4e-7 * largest;
        let first = found.iter().find(|(off, _)| *off <= exact);
        let best = || found.iter().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(off, _)| *off <= 3e-3 * spread);
        first.or_else(best).map(|(_, way)| *way)
    }

    fn line(at: &[(f64, f64)], seen: Seen) -> Option<Self> {
        let (first, last) = (at.first()?, at.last()?);
        let (w0, w1) = (seen.of(first.0), seen.of(last.0));
        let slope = (last.1 - first.1) / (w1 - w0);
        let base = first.1 - slope * w0;
        // Rounding of single precision makes no offset.
        let base = if base.abs() <= 1e-6 * last.1.abs().max(first.1.abs()) { 0.0 } else { base };
        let slope = if base == 0.0 && (slope - 1.0).abs() < 1e-6 { 1.0 } else { slope };
        Some(Self { seen, exponential: false, base, slope, rate: 0.0 })
    }

    fn approach(at: &[(f64, f64)], seen: Seen) -> Option<Self> {
        let (first, last) = (at.first()?, at.last()?);
        let middle = at.get(at.len() / 2)?;
        let (w0, w1) = (seen.of(first.0), seen.of(middle.0));
        let ratio = (last.1 - middle.1) / (middle.1 - first.1);
        let rate = ratio.ln() / (w1 - w0);
        let part = (first.1 - middle.1) / (1.0 - ratio);
        let way = Self { seen, exponential: true, base: first.1 - part, slope: part * (-rate * w0).exp(), rate };
        (ratio > 0.0 && ratio != 1.0 && way.base.is_finite() && way.slope.is_finite()).then_some(way)
    }

    fn at(&self, value: f64) -> f64 {
        let w = self.seen.of(value);
        self.base + self.slope * if self.exponential { (self.rate * w).exp() } else { w }
    }

    /// The rule's parameter where the process's is `value`, from the numbers of [`Way::numbers`].
    fn node(&self, value: Node, numbers: &[Node]) -> Node {
        let w = match self.seen {
            Seen::Itself => value,
            Seen::Inverse => Node::of(1.0) / value,
            Seen::Square => value * value,
        };
        match numbers {
            [base, slope, rate] => *base + *slope * (*rate * w).exp(),
            [base, slope] => *base + *slope * w,
            [slope] => *slope * w,
            _ => w,
        }
    }

    fn numbers(&self) -> Vec<f32> {
        let all = [self.base, self.slope, self.rate].map(|v| v as f32);
        let count = match (self.exponential, self.base == 0.0, self.slope == 1.0) {
            (true, ..) => return all.to_vec(),
            (false, true, true) => 0..0,
            (false, true, false) => 1..2,
            (false, false, _) => 0..2,
        };
        all[count].to_vec()
    }

    /// What ways have in common whose programs are the same.
    fn shape(&self) -> (Seen, usize) {
        (self.seen, self.numbers().len())
    }
}

/// A parameter of a rule that a term decides.
struct Link {
    pass: usize,
    param: usize,
    term: usize,
    way: Way,
}

/// What a program is made of: the rule, and its parameters' terms and shapes.
type Key = (RuleKind, Vec<(usize, usize, (Seen, usize))>);

/// All terms of a process in a step.
#[derive(Debug, Default)]
pub struct Terms {
    list: Vec<Arc<Term>>,
    programs: Mutex<HashMap<Key, Arc<Program>>>,
}

impl Terms {
    /// Terms of one process, each of another parameter.
    pub fn new(list: Vec<Arc<Term>>) -> Arc<Self> {
        Arc::new(Self { list, programs: Mutex::default() })
    }

    /// The terms.
    pub fn list(&self) -> &[Arc<Term>] {
        &self.list
    }

    /// Without that of a parameter.
    #[must_use]
    pub fn without(&self, parameter: &str) -> Arc<Self> {
        Self::new(self.list.iter().filter(|t| t.parameter != parameter).cloned().collect())
    }
}

/// A process with terms.
pub struct Replaced {
    entry: &'static Entry<dyn Process>,
    parameters: Map<String, Value>,
    terms: Arc<Terms>,
    /// The process with numbers for all parameters.
    plain: Box<dyn Process>,
    probes: OnceLock<Vec<Probes>>,
}

/// A process at several values of one of its parameters.
struct Probes {
    /// Evenly spaced, then with evenly spaced inverses, then anywhere.
    values: [Vec<f64>; 3],
    processes: Vec<Box<dyn Process>>,
}

impl Probes {
    fn new(at: &Map<String, Value>, entry: &'static Entry<dyn Process>, name: &str, range: (f32, f32)) -> Self {
        let usual = at.get(name).cloned().unwrap_or_else(|| (entry.defaults)()[name].clone()).as_f64().unwrap_or(0.0);
        let (low, high) = (f64::from(range.0), f64::from(range.1));
        let scale = if usual == 0.0 { (high - low).min(1.0) } else { usual.abs() };
        let spaced = |from: f64, to: f64| (0..5).map(|i| from + (to - from) * f64::from(i) / 4.0).collect::<Vec<_>>();
        let even = spaced((usual - scale).max(low), (usual + 2.0 * scale).min(high));
        let inverse = if usual > 0.0 && 0.5 * usual >= low && 2.0 * usual <= high {
            spaced(0.5 / usual, 2.0 / usual).into_iter().map(|w| 1.0 / w).collect()
        } else {
            Vec::new()
        };
        let ends = [low, high].into_iter().filter(|v| v.abs() <= 1e4 * scale).collect();
        // The process keeps single precision; what it is asked at must be what it hears.
        let values: [Vec<f64>; 3] =
            [even, inverse, ends].map(|v: Vec<f64>| v.into_iter().map(|v| f64::from(v as f32)).collect());
        let processes = values.iter().flatten().filter_map(|v| {
            let mut parameters = at.clone();
            parameters.insert(name.to_owned(), Value::from(*v));
            (entry.make)(Value::Object(parameters)).ok()
        });
        Self { processes: processes.collect(), values }
    }
}

impl fmt::Debug for Replaced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Replaced")
            .field("process", &self.entry.name)
            .field("terms", &self.terms)
            .finish_non_exhaustive()
    }
}

impl Replaced {
    /// The process of `entry` with these parameters, and with terms for others.
    ///
    /// # Errors
    /// If they are no parameters of it.
    pub fn new(
        entry: &'static Entry<dyn Process>,
        parameters: Value,
        terms: Arc<Terms>,
    ) -> Result<Self, serde_json::Error> {
        let plain = (entry.make)(parameters.clone())?;
        let parameters = if let Value::Object(map) = parameters { map } else { Map::new() };
        Ok(Self { entry, parameters, terms, plain, probes: OnceLock::new() })
    }

    fn varying(&self) -> impl Iterator<Item = (usize, &Arc<Term>)> {
        self.terms.list.iter().enumerate().filter(|(_, t)| t.varies())
    }

    fn changes(&self) -> bool {
        self.terms.list.iter().any(|t| !t.varies())
    }

    /// The parameters with the numbers of this moment.
    fn numbers(&self, moment: &Moment) -> Map<String, Value> {
        let mut all = self.parameters.clone();
        for term in self.terms.list.iter().filter(|t| !t.varies()) {
            let number = term.number(moment);
            if !number.is_nan() {
                all.insert(term.parameter.clone(), Value::from(f64::from(number)));
            }
        }
        all
    }

    /// True if an expression gives no number at this moment.
    fn is_lost(&self, moment: &Moment) -> bool {
        self.terms.list.iter().any(|t| !t.varies() && t.number(moment).is_nan())
    }

    /// Does something with the process as it is at this moment.
    fn now<T>(&self, moment: &Moment, what: impl FnOnce(&dyn Process) -> T) -> T {
        let made = self.changes().then(|| (self.entry.make)(Value::Object(self.numbers(moment))).ok()).flatten();
        what(made.as_deref().unwrap_or(&*self.plain))
    }

    /// Which parameters of the plan's rules the varying terms decide.
    fn links(&self, moment: &Moment, plan: &Plan) -> Result<Vec<Link>, (usize, Obstacle)> {
        let made: Vec<Probes>;
        let probes = if self.changes() {
            made = self.make_probes(&self.numbers(moment));
            &made
        } else {
            self.probes.get_or_init(|| self.make_probes(&self.parameters))
        };
        let mut links: Vec<Link> = Vec::new();
        for ((number, _), probes) in self.varying().zip(probes) {
            let before = links.len();
            let plans: Vec<Plan> = probes.processes.iter().map(|p| planned(&**p, moment)).collect();
            let fail = |obstacle| Err((number, obstacle));
            if plans.len() != probes.values.iter().flatten().count() || plans.iter().any(|p| !alike(p, plan)) {
                return fail(Obstacle::Structure);
            }
            let params: Vec<Vec<Vec<f32>>> =
                plans.iter().map(|p| p.passes().iter().map(eyot_core::plan::Pass::params).collect()).collect();
            for (i, pass) in plan.passes().iter().enumerate() {
                for param in 0..pass.params().len() {
                    let mut at = probes.values.iter().flatten().zip(&params).map(|(v, p)| (*v, f64::from(p[i][param])));
                    let points: [Vec<(f64, f64)>; 3] =
                        [0, 1, 2].map(|k| at.by_ref().take(probes.values[k].len()).collect());
                    let first = points[0][0].1;
                    if points.iter().flatten().all(|(_, p)| p.to_bits() == first.to_bits()) {
                        continue;
                    }
                    if let Some(other) = links.iter().find(|l| (l.pass, l.param) == (i, param)) {
                        return fail(Obstacle::Shared(self.terms.list[other.term].parameter.clone()));
                    }
                    let Some(way) = Way::find(&points[0], &points[1], &points[2]) else {
                        return fail(Obstacle::Curved(pass.name()));
                    };
                    links.push(Link { pass: i, param, term: number, way });
                }
            }
            if links.len() == before {
                return fail(Obstacle::Unused);
            }
        }
        Ok(links)
    }

    fn make_probes(&self, at: &Map<String, Value>) -> Vec<Probes> {
        self.varying().map(|(_, t)| Probes::new(at, self.entry, &t.parameter, t.range)).collect()
    }

    /// The program of a pass with its links, and its parameters.
    fn program(
        &self,
        moment: &Moment,
        pass: &eyot_core::plan::Pass,
        links: &[&Link],
    ) -> Result<(Arc<Program>, Vec<f32>)> {
        let key = (pass.kind(), links.iter().map(|l| (l.param, l.term, l.way.shape())).collect());
        let mut params = pass.params();
        for link in links {
            params.extend(link.way.numbers());
            params.extend(self.terms.list[link.term].values(moment));
        }
        let mut programs = self.terms.programs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(program) = programs.get(&key) {
            return Ok((Arc::clone(program), params));
        }
        let graph = pass.graph();
        let (mut reads, mut names) = (graph.reads.clone(), graph.params.clone());
        let own = names.len();
        let mut slots = Vec::new();
        for link in links {
            let term = &self.terms.list[link.term];
            let slot = |layer: &&'static str| {
                reads.iter().position(|r| r == layer).unwrap_or_else(|| {
                    reads.push(layer);
                    reads.len() - 1
                })
            };
            slots.push(term.graph.reads.iter().map(slot).collect::<Vec<usize>>());
            for _ in 0..link.way.numbers().len() + term.given.len() {
                names.push(intern(&format!("given_{}", names.len()))?);
            }
        }
        let graph = graph.with_parameters(reads, names, |cell, all| {
            let (mut values, mut next) = (all[..own].to_vec(), own);
            for (link, slots) in links.iter().zip(&slots) {
                let term = &self.terms.list[link.term];
                let numbers = &all[next..next + link.way.numbers().len()];
                let given = &all[next + numbers.len()..][..term.given.len()];
                next += numbers.len() + given.len();
                let (value, _) = term.graph.evaluate(given, &Moved { cell, slots });
                values[link.param] = link.way.node(value[0], numbers);
            }
            values
        });
        let program = Program::new(graph, pass.tallies().to_vec())?;
        programs.insert(key, Arc::clone(&program));
        Ok((program, params))
    }

    /// The plan of a step, or which term cannot be a part of it.
    fn planned(&self, moment: &Moment) -> Result<Plan, (usize, Obstacle)> {
        let plain = self.now(moment, |p| planned(p, moment));
        if self.is_lost(moment) {
            return self.lost(plain);
        }
        if self.varying().next().is_none() {
            return Ok(plain);
        }
        let links = self.links(moment, &plain)?;
        let mut instead = Vec::new();
        for (i, pass) in plain.passes().iter().enumerate() {
            let here: Vec<&Link> = links.iter().filter(|l| l.pass == i).collect();
            let program = (!here.is_empty()).then(|| self.program(moment, pass, &here)).transpose();
            instead.push(program.map_err(|e| (here[0].term, Obstacle::Limit(e.to_string())))?);
        }
        let mut plan = Plan::default();
        plan.append(plain, |i, _| instead[i].take());
        Ok(plan)
    }

    /// A plan whose rules know no number for their parameters: the values that it makes are none, which ends the run and says where.
    fn lost(&self, plain: Plan) -> Result<Plan, (usize, Obstacle)> {
        let instead: Result<Vec<_>> = plain
            .passes()
            .iter()
            .map(|pass| {
                let program = Program::new(pass.graph(), pass.tallies().to_vec())?;
                Ok((program, vec![f32::NAN; pass.params().len()]))
            })
            .collect();
        let mut instead = instead.map_err(|e| (0, Obstacle::Limit(e.to_string())))?.into_iter();
        let mut plan = Plan::default();
        plan.append(plain, |_, _| instead.next());
        Ok(plan)
    }

    /// What keeps a term from being one, by the parameter's name, on this grid.
    pub fn obstacle(&self, grid: &Grid) -> Option<(&str, Obstacle)> {
        let schema = (self.entry.schema)().to_value();
        let between = |t: &Term| schema["properties"][&t.parameter]["between_cells"].as_bool().unwrap_or(false);
        if let Some((_, term)) = self.varying().find(|(_, t)| between(t)) {
            return Some((&term.parameter, Obstacle::Between));
        }
        let layers =
            |p: &dyn Process| p.layers().into_iter().map(|l| (l.spec.name, l.start.to_bits())).collect::<Vec<_>>();
        let moment = Moment { grid: *grid, step: 0, turn: 0, sea_level_m: 0.0 };
        let sea = |p: &dyn Process| {
            let mut moved = moment;
            p.advance(&mut moved);
            moved.sea_level_m.to_bits()
        };
        for ((_, term), probes) in self.varying().zip(self.make_probes(&self.parameters)) {
            let same = |p: &dyn Process| layers(p) == layers(&*self.plain) && sea(p) == sea(&*self.plain);
            if !probes.processes.iter().all(|p| same(&**p)) {
                return Some((&term.parameter, Obstacle::Structure));
            }
        }
        // Angles and years begin anew after a while: what is a straight line at first is none then.
        let (number, obstacle) = MOMENTS.iter().find_map(|&step| {
            let later = Moment { step, turn: step, ..moment };
            self.planned(&later).err()
        })?;
        Some((&self.terms.list[number].parameter, obstacle))
    }

    /// Names of the parameters of a process that may differ from cell to cell, all others having their defaults.
    pub fn possible(entry: &'static Entry<dyn Process>) -> Vec<String> {
        let schema = (entry.schema)().to_value();
        let Ok(process) = (entry.make)(Value::Object(Map::new())) else { return Vec::new() };
        // What decides the number of parts of a step does so on fine grids.
        let rim = Rim { x: Edge::Wrap, y: Edge::Closed };
        let grid = |cell| Grid::new(64, 64, cell, rim, &Limits::default());
        let (Ok(coarse), Ok(fine)) = (grid(1000.0), grid(10.0)) else { return Vec::new() };
        if process.action().is_some() {
            return Vec::new();
        }
        let own: Vec<String> = numbers(&schema).map(|(name, _)| name.clone()).collect();
        let fits = |name: &String| {
            let (unit, range) = of_schema(&schema["properties"][name]);
            let text = "0 * column + row".to_owned();
            let definition =
                TermDefinition { process: entry.name.to_owned(), parameter: name.clone(), unit, range, text };
            let Ok(term) = term(&TermDefinition { unit: "?".into(), ..definition }, &Scope::default()) else {
                return false;
            };
            let replaced = Self::new(entry, Value::Object(Map::new()), Terms::new(vec![Arc::new(term)]));
            let parts = |r: &Self| matches!(r.obstacle(&fine), Some((_, Obstacle::Structure)));
            replaced.is_ok_and(|r| r.obstacle(&coarse).is_none() && !parts(&r))
        };
        own.into_iter().filter(fits).collect()
    }
}

/// Parameters that are real numbers.
pub fn numbers(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    let number = |p: &&Value| p["type"] == "number" && p["format"] == "float";
    schema["properties"].as_object().into_iter().flatten().filter(move |(_, p)| number(p))
}

/// Unit and range of a parameter.
pub fn of_schema(property: &Value) -> (String, (f32, f32)) {
    let bound = |key: &str, or: f32| property[key].as_f64().map_or(or, |v| v as f32);
    let unit = property["unit"].as_str().unwrap_or("?").to_owned();
    (unit, (bound("minimum", f32::MIN), bound("maximum", f32::MAX)))
}

fn planned(process: &dyn Process, moment: &Moment) -> Plan {
    let mut plan = Plan::default();
    process.plan(moment, &mut plan);
    plan
}

/// Whether two plans differ in parameters alone.
fn alike(a: &Plan, b: &Plan) -> bool {
    a.passes().len() == b.passes().len() && a.passes().iter().zip(b.passes()).all(|(a, b)| a.kind() == b.kind())
}

impl Process for Replaced {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = self.plain.layers();
        // What the process writes alone is read now if a term names it.
        let named = |name: &str| self.terms.list.iter().any(|t| t.needs.iter().any(|n| *n == name));
        layers.iter_mut().filter(|l| named(&l.spec.name)).for_each(|l| {
            if l.access == Access::Write {
                l.access = Access::Change;
            }
        });
        layers.extend(self.declared().iter().map(|layer| layer.spec.clone().read(0.0)));
        layers
    }

    fn start(&self, name: &str, moment: &Moment, plan: &mut Plan) {
        match self.declared().into_iter().find(|l| l.spec.name == name) {
            Some(layer) => layer.begin(moment, plan),
            None => self.plain.start(name, moment, plan),
        }
    }

    fn needs(&self) -> Vec<&'static str> {
        let own: Vec<_> = self.plain.layers().into_iter().map(|l| l.spec.name).collect();
        let mut needs = self.plain.needs();
        needs.extend(self.terms.list.iter().flat_map(|t| &t.needs).filter(|n| !own.iter().any(|o| o == *n)));
        needs.sort_unstable();
        needs.dedup();
        needs
    }

    fn check(&self, grid: &Grid) -> Result<()> {
        self.plain.check(grid)?;
        self.obstacle(grid).map_or(Ok(()), |(parameter, obstacle)| {
            Err(Error::BadParameter {
                owner: self.entry.name.to_owned(),
                field: parameter.to_owned(),
                reason: format!("it cannot differ from cell to cell: {obstacle}"),
            })
        })
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        self.plain.prepare(world)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        // `check` has found the ways, and they are the process's own: no later moment has others.
        let planned = self.planned(moment).unwrap_or_else(|_| self.now(moment, |p| planned(p, moment)));
        plan.append(planned, |_, _| None);
    }

    fn action(&self) -> Option<&dyn Action> {
        self.plain.action()
    }

    fn seconds_per_step(&self, grid: &Grid) -> Option<f64> {
        self.plain.seconds_per_step(grid)
    }

    fn advance(&self, moment: &mut Moment) {
        let now = *moment;
        self.now(&now, |p| p.advance(moment));
    }
}

impl Replaced {
    fn declared(&self) -> Vec<Arc<DeclaredLayer>> {
        let mut declared: Vec<_> = self.terms.list.iter().flat_map(|t| t.declared.iter().cloned()).collect();
        complete(&mut declared, &mut Vec::new());
        declared
    }
}
