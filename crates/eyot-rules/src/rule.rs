//! Layers and rules: from texts to programs, and from programs to processes.

use crate::evaluate::{Evaluation, between};
use crate::meaning::{Formula, Given, Scope, Uses, Wanted, check};
use crate::mistake::{Mistake, Part, Problem};
use crate::unit::Measure;
use eyot_core::graph::Graph;
use eyot_core::plan::Plan;
use eyot_core::process::{LayerUse, Moment, Process};
use eyot_core::program::{MAX_PARAMS, Program};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Tally, TallyUnit};
use eyot_core::{Error, Grid, LayerSpec, Result, intern};
use std::borrow::Cow;
use std::sync::Arc;

/// A layer that a recipe declares.
#[derive(Clone, Debug)]
pub struct LayerDefinition {
    /// What it is; without a range of its own it has all numbers.
    pub spec: LayerSpec,
    /// Whether the recipe gives its unit; if not, units are not checked.
    pub measured: bool,
    /// Its first values: a text.
    pub start: String,
    /// Parameters that the text may name.
    pub parameters: Vec<(String, f32)>,
}

/// A rule that a recipe declares.
#[derive(Clone, Debug)]
pub struct RuleDefinition {
    /// Its name.
    pub name: String,
    /// Layers that it writes, and their new values.
    pub values: Vec<(String, String)>,
    /// Where it applies; everywhere if not given.
    pub mask: Option<String>,
    /// Parameters that its texts may name.
    pub parameters: Vec<(String, f32)>,
}

/// A program and where its parameters come from.
#[derive(Clone, Debug)]
struct Ready {
    program: Arc<Program>,
    params: Vec<Given>,
}

/// A checked layer.
#[derive(Debug)]
pub struct DeclaredLayer {
    /// What it is.
    pub spec: LayerSpec,
    /// Its place among the recipe's layers.
    order: usize,
    start: Ready,
    parameters: Vec<f32>,
    /// Declared layers that its start value reads.
    before: Vec<Arc<DeclaredLayer>>,
    /// Other layers that it reads.
    needs: Vec<&'static str>,
}

impl DeclaredLayer {
    /// Adds the pass that gives it its first values, with the parameters that it was declared with.
    pub(crate) fn begin(&self, moment: &Moment, plan: &mut Plan) {
        self.start.push(&self.parameters, moment, plan);
    }
}

/// A checked rule.
#[derive(Debug)]
pub struct TextRule {
    /// Its name.
    pub name: &'static str,
    /// Parameters and their values unless a step gives others.
    pub parameters: Vec<(String, f32)>,
    ready: Option<Ready>,
    /// Declared layers that it reads or writes, and those that these need, in the recipe's order.
    declared: Vec<Arc<DeclaredLayer>>,
    needs: Vec<&'static str>,
}

/// Checks a layer; `order` is its place among the recipe's layers, of which `scope` holds those before it.
///
/// # Errors
/// What is wrong, with its place.
pub fn layer(definition: &LayerDefinition, order: usize, scope: &Scope) -> Result<Arc<DeclaredLayer>, Vec<Problem>> {
    let d = definition;
    let one = |problem| vec![problem];
    let measure = if d.measured { Measure::of(&d.spec.unit) } else { Measure::Unknown };
    let mut uses = Uses::default();
    let wanted = Wanted::Number(&measure, &d.spec.name);
    let formula = check(&d.start, wanted, scope, &d.parameters, stream(&d.spec.name, "start"), &mut uses)
        .map_err(|m| one((Part::Start, m)))?;
    let writes = vec![Write { formula, spec: d.spec.clone(), old: None, counted: false }];
    // Start values are no steps, so nobody counts what is clamped in them.
    let name = format!("{}_start", d.spec.name);
    let ready = ready(&name, writes, None, uses.clone(), false).map_err(|e| one(whole(&e)))?;
    let (before, needs) = split(&uses.reads, scope).map_err(|e| one(whole(&e)))?;
    Ok(Arc::new(DeclaredLayer {
        spec: d.spec.clone(),
        order,
        start: ready,
        parameters: d.parameters.iter().map(|(_, v)| *v).collect(),
        before,
        needs,
    }))
}

/// Checks a rule against the layers that are there when it runs. One without values makes its layers and changes nothing;
/// `own` is the layer whose rule it is.
///
/// # Errors
/// Everything that is wrong, with its places.
pub fn rule(
    definition: &RuleDefinition,
    own: Option<&Arc<DeclaredLayer>>,
    scope: &Scope,
) -> Result<Arc<TextRule>, Vec<Problem>> {
    let d = definition;
    let (mut problems, mut uses, mut writes) = (Vec::new(), Uses::default(), Vec::new());
    let first = stream(&d.name, "");
    let mask = d.mask.as_ref().and_then(|text| {
        let checked = check(text, Wanted::Condition, scope, &d.parameters, first, &mut uses);
        checked.map_err(|m| problems.push((Part::Mask, m))).ok()
    });
    for (name, text) in &d.values {
        let Some(known) = scope.layer(name) else {
            let layers = scope.layers.iter().map(|k| k.spec.name.to_string()).collect();
            let mistake = Mistake::at(&(0..0), format!("there is no layer `{name}` to change"), "unknown layer");
            problems.push((Part::Value(name.clone()), mistake.among(name, layers)));
            continue;
        };
        let measure = known.measure();
        match check(text, Wanted::Number(&measure, name), scope, &d.parameters, first, &mut uses) {
            Ok(formula) => {
                let counted = known.measured && known.spec.unit == "m";
                let old = (mask.is_some() || counted).then(|| uses.slot(name));
                writes.push(Write { formula, spec: known.spec.clone(), old, counted });
            }
            Err(mistake) => problems.push((Part::Value(name.clone()), mistake)),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let one = |e: Error| vec![whole(&e)];
    let written: Vec<String> = d.values.iter().map(|(name, _)| name.clone()).collect();
    let layers: Vec<String> = uses.reads.iter().chain(&written).cloned().collect();
    let (mut declared, mut needs) = split(&layers, scope).map_err(one)?;
    declared.extend(own.cloned());
    complete(&mut declared, &mut needs);
    let ready = if writes.is_empty() { None } else { Some(ready(&d.name, writes, mask, uses, true).map_err(one)?) };
    Ok(Arc::new(TextRule {
        name: intern(&d.name).map_err(one)?,
        parameters: d.parameters.clone(),
        ready,
        declared,
        needs,
    }))
}

fn whole(e: &Error) -> Problem {
    (Part::Whole, Mistake::at(&(0..0), e.to_string(), "here"))
}

/// First of the streams of random numbers of a rule; each has 1024, more than a text has places for.
pub(crate) fn stream(name: &str, role: &str) -> u32 {
    let bytes = name.bytes().chain([0]).chain(role.bytes());
    let hash = bytes.fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
    0x4000_0000 | (hash & 0x0fff_fc00)
}

pub(crate) type Split = (Vec<Arc<DeclaredLayer>>, Vec<&'static str>);

/// Layers that the recipe declares, and others.
pub(crate) fn split(names: &[String], scope: &Scope) -> Result<Split> {
    let (mut declared, mut needs) = (Vec::<Arc<DeclaredLayer>>::new(), Vec::new());
    for name in names {
        match scope.layer(name).and_then(|k| k.declared.as_ref()) {
            Some(layer) => declared.push(Arc::clone(layer)),
            None => needs.push(intern(name)?),
        }
    }
    complete(&mut declared, &mut needs);
    Ok((declared, needs))
}

/// Adds what the start values need, and puts everything in the recipe's order.
pub(crate) fn complete(declared: &mut Vec<Arc<DeclaredLayer>>, needs: &mut Vec<&'static str>) {
    for layer in declared.clone() {
        declared.extend(layer.before.iter().cloned());
        needs.extend(&layer.needs);
    }
    declared.sort_by_key(|l| l.order);
    declared.dedup_by_key(|l| l.order);
    needs.sort_unstable();
    needs.dedup();
}

/// A layer that a program writes.
struct Write {
    formula: Formula,
    spec: LayerSpec,
    /// Slot of its old values, where they are needed.
    old: Option<usize>,
    /// Its changes are matter, which has an account.
    counted: bool,
}

impl Write {
    fn clamped(&self) -> bool {
        self.spec.range.0 > f32::MIN || self.spec.range.1 < f32::MAX
    }
}

/// Makes a program of formulas.
fn ready(name: &str, writes: Vec<Write>, mask: Option<Formula>, uses: Uses, counts: bool) -> Result<Ready> {
    if uses.params.len() > MAX_PARAMS {
        return Err(Error::Limit {
            what: format!("rule `{name}`"),
            needed: format!("{} parameters", uses.params.len()),
            limit: MAX_PARAMS.to_string(),
            remedy: "split it into several rules".into(),
        });
    }
    let reads = uses.reads.iter().map(|r| intern(r)).collect::<Result<Vec<_>>>()?;
    let written = writes.iter().map(|w| intern(&w.spec.name)).collect::<Result<Vec<_>>>()?;
    let params = (0..uses.params.len()).map(|i| intern(&format!("given_{i}"))).collect::<Result<Vec<_>>>()?;
    let mut tallies = Vec::new();
    for w in writes.iter().filter(|w| w.counted) {
        let by = if *w.spec.name == *name { "next" } else { name };
        tallies.push(Tally {
            account: intern(&format!("{}.{by}", w.spec.name))?,
            unit: TallyUnit::Thickness,
            sign: 1,
            meaning: intern(&format!("what the rule `{name}` of the recipe adds, less what it takes"))?,
        });
    }
    let counts = counts && writes.iter().any(Write::clamped);
    if counts {
        tallies.push(Tally {
            account: intern(&format!("{name}.clamped"))?,
            unit: TallyUnit::Count,
            sign: 0,
            meaning: intern("new values outside the layer's range, which were moved to its end")?,
        });
    }
    let graph = Graph::record(intern(name)?, params, reads, written, |cell, params| {
        let (mut values, mut sums) = (Vec::new(), Vec::new());
        let mut outside = Real::of(0.0);
        for w in &writes {
            let raw = Evaluation::new(&w.formula, params, cell).number().flushed();
            let (low, high) = (Real::of(w.spec.range.0), Real::of(w.spec.range.1));
            let mut value = if w.clamped() { between(raw, low, high) } else { raw };
            let mut beyond = is_beyond(raw, low, high);
            if let Some(old) = w.old.map(|slot| cell.here(slot)) {
                if let Some(mask) = &mask {
                    let inside = Evaluation::new(mask, params, cell).condition();
                    value = inside.pick(value, old);
                    beyond = inside.pick(beyond, Real::of(0.0));
                }
                if w.counted {
                    sums.push(value - old);
                }
            }
            if w.clamped() {
                outside = outside + beyond;
            }
            values.push(value);
        }
        if counts {
            sums.push(outside);
        }
        (values, sums)
    });
    Ok(Ready { program: Program::new(graph, tallies)?, params: uses.params })
}

/// 1 where a value is not within a range. What is no number ends the run, so nobody counts it.
fn is_beyond<R: Real>(v: R, low: R, high: R) -> R {
    let (zero, one) = (R::of(0.0), R::of(1.0));
    v.lt(low).pick(one, high.lt(v).pick(one, zero))
}

impl Ready {
    /// Values of the program's parameters.
    fn values(&self, own: &[f32], moment: &Moment) -> Vec<f32> {
        let value = |given: &Given| given.value(own, &moment.grid, moment.sea_level_m, moment.step);
        self.params.iter().map(value).collect()
    }

    fn push(&self, own: &[f32], moment: &Moment, plan: &mut Plan) {
        plan.push_program(&self.program, self.values(own, moment));
    }
}

impl TextRule {
    /// Arithmetic operations of a cell.
    pub fn operations(&self) -> usize {
        self.ready.as_ref().map_or(0, |r| r.program.graph().operations())
    }

    /// The program; none if the rule changes nothing.
    pub fn program(&self) -> Option<&Arc<Program>> {
        self.ready.as_ref().map(|r| &r.program)
    }
}

/// A rule with values for its parameters, as a process.
#[derive(Clone, Debug)]
pub struct Acting {
    /// The rule.
    pub rule: Arc<TextRule>,
    /// Values in the order of its parameters.
    pub values: Vec<f32>,
}

impl Process for Acting {
    fn layers(&self) -> Vec<LayerUse> {
        // A rule changes few of the layers that it declares; the others are read by it or by their start values.
        let written = self.writes();
        let declared = self.rule.declared.iter().map(|l| l.spec.clone());
        declared.map(|l| if written.contains(&l.name) { l.changed(0.0) } else { l.read(0.0) }).collect()
    }

    fn writes(&self) -> Vec<Cow<'static, str>> {
        let written = self.rule.program().map_or(&[][..], |p| &p.graph().writes);
        written.iter().map(|name| Cow::Borrowed(*name)).collect()
    }

    fn start(&self, name: &str, moment: &Moment, plan: &mut Plan) {
        if let Some(layer) = self.rule.declared.iter().find(|l| l.spec.name == name) {
            // The rule of a layer has its parameters, which a step may have changed.
            let own = if name == self.rule.name { &self.values } else { &layer.parameters };
            layer.start.push(own, moment, plan);
        }
    }

    fn needs(&self) -> Vec<&'static str> {
        self.rule.needs.clone()
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        let unfit = self.rule.parameters.iter().zip(&self.values).find(|(_, v)| !v.is_finite());
        unfit.map_or(Ok(()), |((name, _), value)| {
            Err(Error::BadParameter {
                owner: self.rule.name.to_owned(),
                field: name.clone(),
                reason: format!("{value} is beyond what a number can be; the largest is 3.4e38"),
            })
        })
    }

    fn plan(&self, moment: &Moment, plan: &mut Plan) {
        if let Some(ready) = &self.rule.ready {
            ready.push(&self.values, moment, plan);
        }
    }
}
