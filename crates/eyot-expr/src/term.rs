//! Terms: parameters of a built-in process that a recipe gives as expressions.
//!
//! An expression that is the same for all cells, for it depends on time and sea level alone, gives the process another number in
//! each step. One that differs from cell to cell goes into the rules themselves: a built-in rule leaves its graph behind, the
//! expression takes the place of the parameter's node, and the result is a [`Program`] that both engines run as they run
//! a recipe's own rules.
//!
//! # From a parameter to what rules know of it
//! Processes turn their parameters into those of their rules, with the length of a step or the size of a cell. They write this down
//! in numbers that can be traced ([`eyot_core::given`]), and the trace becomes a part of the program: each cell computes what the
//! process would, in the same operations. A parameter that decides more than numbers in rules can only change in time. Whether one
//! does is told by the trace, and found by planning with other values of it, so that nothing that a process decides on another way
//! goes unnoticed.

use crate::evaluate::{Evaluation, between};
use crate::parse_error::ParseError;
use crate::rule::{DeclaredLayer, complete, split, stream};
use crate::typecheck::{Given, Scope, Uses, Wanted, check};
use crate::unit::Measure;
use eyot_core::component::Shape;
use eyot_core::given::{Trace, Way};
use eyot_core::graph::{Graph, Id, Op};
use eyot_core::plan::{Pass, Plan, RuleKind};
use eyot_core::process::{Access, Action, Entry, LayerUse, Moment, Process};
use eyot_core::program::Program;
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Slot};
use eyot_core::{Boundary, BoundaryCondition, Error, Grid, Limits, Result, World, intern};
use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

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
pub fn term(definition: &TermDefinition, scope: &Scope) -> Result<Term, ParseError> {
    let d = definition;
    let name = format!("{}.{}", d.process, d.parameter);
    let mut uses = Uses::default();
    let wanted = Wanted::Parameter(&Measure::of(&d.unit), &d.parameter);
    let formula = check(&d.text, wanted, scope, &[], stream(&name, "term"), &mut uses)?;
    let whole = |e: Error| ParseError::at(&(0..d.text.len()), e.to_string(), "here");
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
#[non_exhaustive]
pub enum Obstacle {
    /// It acts on matter between two cells, which would see different values of it.
    Between,
    /// No rule of cells depends on it.
    Unused,
    /// It decides which rules run or what else happens.
    Structure,
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
            Self::Limit(reason) => write!(f, "{reason}"),
        }
    }
}

/// What a program is made of: the rule, which of its parameters follow from which terms, and how.
type Key = (RuleKind, Vec<usize>, Vec<usize>, Vec<Op>, Vec<Id>);

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
pub struct ParameterizedProcess {
    entry: &'static Entry<dyn Process>,
    parameters: Map<String, Value>,
    terms: Arc<Terms>,
    /// The process with numbers for all parameters.
    plain: Box<dyn Process>,
}

impl fmt::Debug for ParameterizedProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ParameterizedProcess")
            .field("process", &self.entry.name)
            .field("terms", &self.terms)
            .finish_non_exhaustive()
    }
}

impl ParameterizedProcess {
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
        Ok(Self { entry, parameters, terms, plain })
    }

    /// Terms that may differ from cell to cell.
    fn varying(&self) -> impl Iterator<Item = &Arc<Term>> {
        self.terms.list.iter().filter(|t| t.varies())
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

    /// The plan of a step, and what it has recorded of the varying terms' parameters.
    fn traced(&self, moment: &Moment) -> (Plan, Trace) {
        let names: Vec<&str> = self.varying().map(|t| t.parameter.as_str()).collect();
        self.now(moment, |process| Plan::traced(&names, |plan| process.plan(moment, plan)))
    }

    /// The program of a pass some of whose parameters follow from terms, and its parameters.
    fn program(&self, moment: &Moment, pass: &Pass, way: Way) -> Result<(Arc<Program>, Vec<f32>)> {
        let varying: Vec<&Arc<Term>> = self.varying().collect();
        let terms: Vec<&Arc<Term>> = way.sources.iter().map(|source| varying[*source]).collect();
        let mut params = pass.params();
        params.extend(&way.numbers);
        terms.iter().for_each(|term| params.extend(term.values(moment)));
        let key = (pass.kind(), way.params, way.sources, way.graph.nodes.clone(), way.graph.outputs.clone());
        let mut programs = self.terms.programs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(program) = programs.get(&key) {
            return Ok((Arc::clone(program), params));
        }
        let graph = pass.graph();
        let (mut reads, mut names) = (graph.reads.clone(), graph.params.clone());
        let (own, numbers) = (names.len(), way.numbers.len());
        while names.len() < params.len() {
            names.push(intern(&format!("given_{}", names.len()))?);
        }
        let slots: Vec<Vec<usize>> = terms.iter().map(|term| slots(&mut reads, &term.graph.reads)).collect();
        let graph = graph.with_parameters(reads, names, |cell, all| {
            let (mut values, mut next) = (all[..own].to_vec(), own + numbers);
            let mut inputs = Vec::new();
            for (term, slots) in terms.iter().zip(&slots) {
                let given = &all[next..next + term.given.len()];
                next += given.len();
                inputs.extend(term.graph.evaluate(given, &Moved { cell, slots }).0);
            }
            inputs.extend(&all[own..own + numbers]);
            let (found, _) = way.graph.evaluate(&inputs, cell);
            key.1.iter().zip(found).for_each(|(param, value)| values[*param] = value);
            values
        });
        let program = Program::new(graph, pass.tallies().to_vec())?;
        programs.insert(key, Arc::clone(&program));
        Ok((program, params))
    }

    /// The plan of a step, or which term cannot be a part of it.
    fn planned(&self, moment: &Moment) -> Result<Plan, (usize, Obstacle)> {
        if self.is_lost(moment) {
            return self.lost(self.now(moment, |p| planned(p, moment)));
        }
        let (plain, trace) = self.traced(moment);
        if let Some(number) = trace.decided().first() {
            return Err((*number, Obstacle::Structure));
        }
        let mut instead = Vec::new();
        for (i, pass) in plain.passes().iter().enumerate() {
            let way = trace.way(i, pass.name());
            let first = way.as_ref().map_or(0, |way| way.sources[0]);
            let program = way.map(|way| self.program(moment, pass, way)).transpose();
            instead.push(program.map_err(|e| (first, Obstacle::Limit(e.to_string())))?);
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
        if let Some(term) = self.varying().find(|t| between(t)) {
            return Some((&term.parameter, Obstacle::Between));
        }
        let varying: Vec<&Arc<Term>> = self.varying().collect();
        varying.first()?;
        let mut used = Vec::new();
        // Angles and years begin anew after a while.
        for step in MOMENTS {
            let moment = Moment { turn: step, ..Moment::whole(*grid, step, 0.0) };
            let plain = Plain::of(self, &moment);
            used.extend(plain.trace.used());
            for (number, term) in varying.iter().enumerate() {
                if !plain.values(number, term.range).iter().all(|value| plain.agrees(number, *value)) {
                    return Some((&term.parameter, Obstacle::Structure));
                }
            }
            if let Err((number, obstacle)) = self.planned(&moment) {
                return Some((&varying[number].parameter, obstacle));
            }
        }
        let unused = (0..varying.len()).find(|number| !used.contains(number))?;
        Some((&varying[unused].parameter, Obstacle::Unused))
    }

    /// Names of the parameters of a process that may differ from cell to cell, all others having their defaults.
    pub fn possible(entry: &'static Entry<dyn Process>) -> Vec<String> {
        let schema = (entry.schema)().to_value();
        let Ok(process) = (entry.make)(Value::Object(Map::new())) else { return Vec::new() };
        // What decides the number of parts of a step does so on fine grids.
        let rim = Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Closed };
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

/// Places of `wanted` among `reads`; what is missing there is added.
fn slots(reads: &mut Vec<&'static str>, wanted: &[&'static str]) -> Vec<usize> {
    let place = |layer: &&'static str| {
        reads.iter().position(|r| r == layer).unwrap_or_else(|| {
            reads.push(layer);
            reads.len() - 1
        })
    };
    wanted.iter().map(place).collect()
}

/// What a process does beside its plan: layers with the bits of their first values, needs, and the bits of the sea level after it.
#[derive(PartialEq)]
struct Beside(Vec<(String, u32)>, Vec<String>, u64);

impl Beside {
    fn of(process: &dyn Process, moment: &Moment) -> Self {
        let layers = process.layers().into_iter().map(|l| (l.spec.name.to_string(), l.start.to_bits()));
        let needs = process.needs().into_iter().map(|name| name.to_string());
        let mut moved = *moment;
        process.advance(&mut moved);
        Self(layers.collect(), needs.collect(), moved.sea_level_m.to_bits())
    }
}

/// A process with numbers for all parameters at a moment, and what it says of those that are to be expressions.
struct Plain<'a> {
    replaced: &'a ParameterizedProcess,
    moment: &'a Moment,
    parameters: Map<String, Value>,
    /// What the process does beside its plan.
    beside: Option<Beside>,
    plan: Plan,
    trace: Trace,
    /// The numbers of the varying terms' parameters.
    usual: Vec<f32>,
}

impl<'a> Plain<'a> {
    fn of(replaced: &'a ParameterizedProcess, moment: &'a Moment) -> Self {
        let (parameters, (plan, trace)) = (replaced.numbers(moment), replaced.traced(moment));
        let defaults = (replaced.entry.defaults)();
        let number = |t: &Arc<Term>| parameters.get(&t.parameter).unwrap_or(&defaults[&t.parameter]).as_f64();
        let usual = replaced.varying().map(|t| number(t).unwrap_or(0.0) as f32).collect();
        let process = (replaced.entry.make)(Value::Object(parameters.clone())).ok();
        let beside = process.map(|process| Beside::of(&*process, moment));
        Self { replaced, moment, parameters, beside, plan, trace, usual }
    }

    /// Values at which a process that decides something by a parameter is likely to decide otherwise.
    fn values(&self, number: usize, (low, high): (f32, f32)) -> Vec<f32> {
        let usual = self.usual[number];
        let scale = if usual == 0.0 { (high - low).min(1.0) } else { usual.abs() };
        let around = [-2.0, -1.0, 0.5, 0.93, 1.37, 2.0, 3.1, 10.0].map(|part| part * scale);
        let all = around.into_iter().chain([0.0, low, high]);
        all.map(|value| value.clamp(low, high)).filter(|value| value.abs() < 1e12).collect()
    }

    /// Whether the process with another number for a parameter does what the trace says.
    fn agrees(&self, number: usize, value: f32) -> bool {
        let name = self.replaced.varying().nth(number).map(|t| t.parameter.clone()).unwrap_or_default();
        let mut parameters = self.parameters.clone();
        parameters.insert(name, Value::from(f64::from(value)));
        let Ok(process) = (self.replaced.entry.make)(Value::Object(parameters)) else { return false };
        let plan = planned(&*process, self.moment);
        let passes = self.plan.passes();
        self.beside.as_ref() == Some(&Beside::of(&*process, self.moment))
            && plan.passes().len() == passes.len()
            && plan.passes().iter().enumerate().all(|(i, pass)| {
                pass.kind() == passes[i].kind() && self.same(i, &passes[i], &pass.params(), number, value)
            })
    }

    /// Whether a pass has the parameters that the trace gives it.
    fn same(&self, i: usize, pass: &Pass, found: &[f32], number: usize, value: f32) -> bool {
        let mut expected = pass.params();
        if let Some(way) = self.trace.way(i, pass.name()) {
            let input = |source: &usize| if *source == number { value } else { self.usual[*source] };
            let inputs: Vec<f32> = way.sources.iter().map(input).chain(way.numbers).collect();
            let (values, _) = way.graph.evaluate(&inputs, &Nowhere);
            way.params.iter().zip(values).for_each(|(param, value)| expected[*param] = value);
        }
        // What the process computes in double precision, cells compute in single.
        let close = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-5 * a.abs().max(b.abs()) || a.is_nan() && b.is_nan();
        expected.iter().zip(found).all(|(a, b)| close(*a, *b))
    }
}

fn planned(process: &dyn Process, moment: &Moment) -> Plan {
    let mut plan = Plan::default();
    process.plan(moment, &mut plan);
    plan
}

impl Process for ParameterizedProcess {
    fn layers(&self) -> Vec<LayerUse> {
        let mut layers = self.plain.layers();
        // What the process writes alone is read now if a term names it.
        let named = |name: &str| self.terms.list.iter().any(|t| t.needs.contains(&name));
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

    fn views(&self) -> Vec<(&'static str, Shape)> {
        self.plain.views()
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        self.plain.prepare(world)
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        // `check` has found what cannot be planned. Should a later moment be one, its values are none rather than wrong ones.
        let plain = || self.now(moment, |p| planned(p, moment));
        let planned = self.planned(moment).or_else(|_| self.lost(plain())).unwrap_or_else(|_| plain());
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

impl ParameterizedProcess {
    fn declared(&self) -> Vec<Arc<DeclaredLayer>> {
        let mut declared: Vec<_> = self.terms.list.iter().flat_map(|t| t.declared.iter().cloned()).collect();
        complete(&mut declared, &mut Vec::new());
        declared
    }
}
