//! Programs: rules that are no Rust: they came as a text, or a text replaces parameters of them.
//!
//! A [`Program`] is an expression graph with what a rule declares. The GPU engine prints its graph as it prints every
//! rule's. The CPU engine runs it in blocks of cells: `compile` turns the graph into a short list of instructions on blocks,
//! `run` carries them out, compiled for each instruction set. The results are those of
//! [`Graph::evaluate`](crate::graph::Graph::evaluate) for each cell, bit by bit.

mod compile;
mod run;

use crate::erased::{ErasedRule, RuleKind, View};
use crate::error::{Error, Result};
use crate::graph::{Graph, Op};
use crate::isa::Isa;
use crate::kernel::RowJob;
use crate::names::intern;
use crate::rule::{MAX_REACH, MAX_READS, MAX_TALLIES, MAX_WRITES, Read, Side, Tally};
use compile::{Code, Constant};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Most operations of a program's graph.
pub const MAX_OPERATIONS: usize = 4096;
/// Most parameters of a program.
pub const MAX_PARAMS: usize = 64;

/// A rule from an expression graph.
#[derive(Debug)]
pub struct Program {
    number: u64,
    graph: Graph,
    reads: Vec<Read>,
    tallies: Vec<Tally>,
    code: Code,
}

impl Program {
    /// A program of a graph, as [`Graph::record`] makes one, and of the accounts of its sums.
    ///
    /// # Errors
    /// If it reads, writes, sums or computes more than an engine handles, reaches farther, or has a constant that is not finite.
    pub fn new(mut graph: Graph, tallies: Vec<Tally>) -> Result<Arc<Self>> {
        graph.fold();
        let limit = |what: &str, found: usize, most: usize| {
            if found <= most {
                return Ok(());
            }
            Err(Error::Limit {
                what: format!("rule `{}`", graph.name),
                needed: format!("{found} {what}"),
                limit: most.to_string(),
                remedy: "split it into several rules".into(),
            })
        };
        limit("layers to read", graph.reads.len(), MAX_READS)?;
        limit("layers to write", graph.writes.len(), MAX_WRITES)?;
        limit("sums", graph.sums.len(), MAX_TALLIES)?;
        limit("parameters", graph.params.len(), MAX_PARAMS)?;
        limit("operations", graph.nodes.len(), MAX_OPERATIONS)?;
        let reads: Vec<Read> =
            (0..).zip(&graph.reads).map(|(i, &layer)| Read { layer, reach: graph.reach(i) }).collect();
        limit("cells of reach", reads.iter().map(|r| r.reach).max().unwrap_or(0), MAX_REACH)?;
        let sound = |op: &Op| if let Op::Const(c) = op { f32::from_bits(*c).is_finite() } else { true };
        if !graph.nodes.iter().all(sound) {
            return Err(Error::BadParameter {
                owner: graph.name.to_owned(),
                field: "constants".to_owned(),
                reason: "what is computed from numbers alone is not finite".to_owned(),
            });
        }
        // The printer of shaders takes a layer's name for what is read; that of a recipe's layer may be a word of WGSL.
        for (id, op) in (0..).zip(&graph.nodes) {
            if let Op::Read(slot, dx, dy) = *op {
                let sign = |d: i32| format!("{}{}", if d < 0 { "m" } else { "p" }, d.unsigned_abs());
                let name = format!("of_{}_{}_{}", graph.reads[slot as usize], sign(dx), sign(dy));
                graph.names.push((id, intern(&name)?));
            }
        }
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let code = Code::of(&graph);
        Ok(Arc::new(Self { number: NUMBER.fetch_add(1, Ordering::Relaxed), graph, reads, tallies, code }))
    }

    /// The graph.
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Layers read.
    pub fn reads(&self) -> &[Read] {
        &self.reads
    }
}

/// A program with values for its parameters.
pub(crate) struct Bound {
    program: Arc<Program>,
    params: Vec<f32>,
    /// Values of the code's constants.
    constants: Vec<f32>,
}

impl Bound {
    pub(crate) fn new(program: &Arc<Program>, params: Vec<f32>) -> Self {
        let uniforms = program.graph.uniforms(&params);
        let value = |c: &Constant| match c {
            Constant::Node(id) => f32::from_bits(uniforms[*id as usize].unwrap_or_default()),
            Constant::Row => 0.0,
        };
        let constants = program.code.constants.iter().map(value).collect();
        Self { program: Arc::clone(program), params, constants }
    }
}

impl ErasedRule for Bound {
    fn kind(&self) -> RuleKind {
        RuleKind::Program(self.program.number)
    }
    fn name(&self) -> &'static str {
        self.program.graph.name
    }
    fn reads(&self) -> &[Read] {
        &self.program.reads
    }
    fn writes(&self) -> &[&'static str] {
        &self.program.graph.writes
    }
    fn tallies(&self) -> &[Tally] {
        &self.program.tallies
    }
    fn params(&self) -> Vec<f32> {
        self.params.clone()
    }
    fn graph(&self) -> Graph {
        self.program.graph.clone()
    }
    fn row(&self, isa: Isa, job: &mut RowJob) {
        run::row(isa, self, job);
    }
    fn cell_f64(&self, view: &View<'_, f64>) -> (Vec<f64>, Vec<f64>) {
        let params: Vec<f64> = self.params.iter().map(|&v| f64::from(v)).collect();
        self.program.graph.evaluate(&params, view)
    }
    fn cell_f32(&self, view: &View<'_, f32>) -> (Vec<f32>, Vec<f32>) {
        self.program.graph.evaluate(&self.params, view)
    }
    fn leaving_f64(&self, view: &View<'_, f64>, side: Side) -> Option<Vec<f64>> {
        let params: Vec<f64> = self.params.iter().map(|&v| f64::from(v)).collect();
        self.program.graph.evaluate_boundary_outflow(&params, view, side)
    }
}
