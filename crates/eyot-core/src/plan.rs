//! Plans: lists of passes, with the layers that each reads (and how far) and writes.

use crate::erased::{ErasedRule, Typed};
use crate::given::Given;
use crate::graph::{self, Graph};
use crate::layer::LayerSpec;
use crate::program::{Bound, Program};
use crate::rng::Key;
use crate::rule::{MAX_REACH, MAX_READS, MAX_TALLIES, MAX_WRITES, ParamSet, Read, Rule, Tally};
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::sync::Arc;

pub use crate::erased::RuleKind;

/// Rules with their parameters, in the order in which they run.
#[derive(Default)]
pub struct Plan {
    pub(crate) passes: Vec<Pass>,
    pub(crate) scratch: Vec<LayerSpec>,
    pub(crate) step: u64,
    /// Names of the parameters that are traced.
    pub(crate) traced: Vec<String>,
    /// What the trace is for: pass, parameter of its rule, and node.
    pub(crate) given: Vec<(usize, usize, graph::Id)>,
}

/// One rule with its parameters, at one step.
pub struct Pass {
    pub(crate) rule: Box<dyn ErasedRule>,
    pub(crate) step: u64,
}

impl Plan {
    /// Adds a pass of rule `U`.
    ///
    /// # Panics
    /// If the rule declares more reads, writes, sums or reach than an engine handles, or does not keep to what it declares:
    /// mistakes in the rule, which would otherwise reach memory that is not its own.
    pub fn push<U: Rule>(&mut self, params: <U::Params as ParamSet>::Of<f32>)
    where
        <U::Params as ParamSet>::Of<f32>: Send + Sync,
    {
        const {
            assert!(U::READS.len() <= MAX_READS, "too many reads");
            assert!(U::WRITES.len() <= MAX_WRITES, "too many writes");
            assert!(U::TALLIES.len() <= MAX_TALLIES, "too many sums");
            let mut i = 0;
            while i < U::READS.len() {
                assert!(U::READS[i].reach <= MAX_REACH, "reach too long");
                i += 1;
            }
        }
        graph::check::<U>();
        self.passes.push(Pass { rule: Box::new(Typed::<U> { params, rule: PhantomData }), step: self.step });
    }

    /// The parameter `name` of the process that plans, which is `value`; see [`given!`](crate::given!).
    pub fn given(&self, name: &str, value: f32) -> Given {
        let place = self.traced.iter().position(|traced| traced == name);
        place.map_or_else(|| Given::from(value), |place| Given::traced(value, place))
    }

    /// As [`Plan::push`], with parameters that follow from those of the process, so that these may be expressions.
    ///
    /// # Panics
    /// As [`Plan::push`].
    pub fn push_given<U: Rule>(&mut self, params: <U::Params as ParamSet>::Of<Given>)
    where
        <U::Params as ParamSet>::Of<f32>: Send + Sync,
    {
        let mut place = 0;
        let params = U::Params::map(&params, |_, given: Given| {
            self.given.extend(given.trace().map(|node| (self.passes.len(), place, node)));
            place += 1;
            given.value()
        });
        self.push::<U>(params);
    }

    /// Adds a pass of a rule that came as a text, with values for the parameters of its graph.
    ///
    /// # Panics
    /// If there are more or fewer values than parameters.
    pub fn push_program(&mut self, program: &Arc<Program>, params: Vec<f32>) {
        assert_eq!(params.len(), program.graph().params.len(), "parameters of `{}`", program.graph().name);
        self.passes.push(Pass { rule: Box::new(Bound::new(program, params)), step: self.step });
    }

    /// Adds the passes of another plan; `instead` may give a program, with its parameters, for the pass of this number.
    ///
    /// # Panics
    /// As [`Plan::push_program`].
    pub fn append(&mut self, other: Self, mut instead: impl FnMut(usize, &Pass) -> Option<(Arc<Program>, Vec<f32>)>) {
        for (i, pass) in other.passes.into_iter().enumerate() {
            match instead(i, &pass) {
                Some((program, params)) => self.push_program(&program, params),
                None => self.passes.push(Pass { step: self.step, ..pass }),
            }
        }
        other.scratch.iter().for_each(|spec| self.scratch(spec));
    }

    /// Declares a layer that lives only between the passes of a step and is never seen outside.
    pub fn scratch(&mut self, spec: &LayerSpec) {
        if !self.scratch.iter().any(|s| s.name == spec.name) {
            self.scratch.push(spec.clone());
        }
    }

    /// The passes in their order.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Scratch layers declared by the passes.
    pub fn scratch_layers(&self) -> &[LayerSpec] {
        &self.scratch
    }

    /// How far from a cell the values lie, at most, of which its own depend after all passes: what a window's halo must have for the
    /// cells inside to be right. Sums are kept inside alone.
    pub fn reach(&self) -> usize {
        // From the last pass to the first: how far around the window each layer must be right.
        let mut needed: BTreeMap<&str, usize> = BTreeMap::new();
        for pass in self.passes.iter().rev() {
            let around = pass.writes().iter().filter_map(|w| needed.remove(w)).max().unwrap_or(0);
            for r in pass.reads() {
                let place = needed.entry(r.layer).or_default();
                *place = (*place).max(around + r.reach);
            }
        }
        needed.into_values().max().unwrap_or(0)
    }

    /// Layers of which the engine holds two copies: those that some pass writes while it reads their neighbouring cells.
    pub fn doubled_layers(&self) -> Vec<&'static str> {
        let around = |p: &Pass, layer: &str| p.reads().iter().any(|r| r.layer == layer && r.reach > 0);
        let mut names: Vec<&str> =
            self.passes.iter().flat_map(|p| p.writes().iter().copied().filter(move |w| around(p, w))).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

impl Pass {
    /// Name of the rule.
    pub fn name(&self) -> &'static str {
        self.rule.name()
    }
    /// Layers read.
    pub fn reads(&self) -> &[Read] {
        self.rule.reads()
    }
    /// Layers written.
    pub fn writes(&self) -> &[&'static str] {
        self.rule.writes()
    }
    /// Expression graph of the rule.
    pub fn graph(&self) -> Graph {
        self.rule.graph()
    }
    /// Sums kept.
    pub fn tallies(&self) -> &[Tally] {
        self.rule.tallies()
    }
    /// Which rule it is.
    pub fn kind(&self) -> RuleKind {
        self.rule.kind()
    }
    /// What all cells of a stream of random numbers share; the stream itself is still to be mixed in.
    pub fn key(&self, seed: u64) -> Key {
        Key::new(seed, 0, self.step)
    }
    /// Parameter values in the order of the graph's names.
    pub fn params(&self) -> Vec<f32> {
        self.rule.params()
    }
}
