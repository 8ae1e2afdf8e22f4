//! Rules whose type has been forgotten: what plans hold.

use crate::graph::Graph;
use crate::isa::Isa;
use crate::kernel::{self, RowJob};
use crate::real::Real;
use crate::rule::{Cell, ParamSet, Read, Rule, Side, Slot, Tally};
use std::any::TypeId;
use std::marker::PhantomData;

/// Which rule a pass runs. Passes of one kind differ in their parameters and their step alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RuleKind {
    /// A rule that is a type.
    Type(TypeId),
    /// A [`Program`](crate::program::Program), by its number.
    Program(u64),
}

/// A rule whose type has been forgotten.
pub(crate) trait ErasedRule: Send + Sync {
    fn kind(&self) -> RuleKind;
    fn name(&self) -> &'static str;
    fn reads(&self) -> &[Read];
    fn writes(&self) -> &[&'static str];
    fn tallies(&self) -> &[Tally];
    fn params(&self) -> Vec<f32>;
    fn graph(&self) -> Graph;
    /// Evaluates one row; see [`kernel`](crate::kernel).
    fn row(&self, isa: Isa, job: &mut RowJob);
    /// New values and sums of one cell in double precision.
    fn cell_f64(&self, view: &View<'_, f64>) -> (Vec<f64>, Vec<f64>);
    /// New values and sums of one cell in single precision.
    fn cell_f32(&self, view: &View<'_, f32>) -> (Vec<f32>, Vec<f32>);
    /// What leaves through a side, in double precision.
    fn leaving_f64(&self, view: &View<'_, f64>, side: Side) -> Option<Vec<f64>>;
}

pub(crate) struct Typed<U: Rule> {
    pub(crate) params: <U::Params as ParamSet>::Of<f32>,
    pub(crate) rule: PhantomData<fn() -> U>,
}

impl<U: Rule> ErasedRule for Typed<U>
where
    <U::Params as ParamSet>::Of<f32>: Send + Sync,
{
    fn kind(&self) -> RuleKind {
        RuleKind::Type(TypeId::of::<U>())
    }
    fn name(&self) -> &'static str {
        U::NAME
    }
    fn reads(&self) -> &[Read] {
        U::READS
    }
    fn writes(&self) -> &[&'static str] {
        U::WRITES
    }
    fn tallies(&self) -> &[Tally] {
        U::TALLIES
    }
    fn params(&self) -> Vec<f32> {
        let mut values = Vec::new();
        U::Params::map(&self.params, |_, v| values.push(v));
        values
    }
    fn graph(&self) -> Graph {
        Graph::of::<U>()
    }
    fn row(&self, isa: Isa, job: &mut RowJob) {
        kernel::row::<U>(isa, &self.params, job);
    }
    fn cell_f64(&self, view: &View<'_, f64>) -> (Vec<f64>, Vec<f64>) {
        let p = U::Params::map(&self.params, |_, v| f64::from(v));
        let (out, sums) = U::cell(&p, view);
        (out.as_ref().to_vec(), sums.as_ref().to_vec())
    }
    fn cell_f32(&self, view: &View<'_, f32>) -> (Vec<f32>, Vec<f32>) {
        let (out, sums) = U::cell(&self.params, view);
        (out.as_ref().to_vec(), sums.as_ref().to_vec())
    }
    fn leaving_f64(&self, view: &View<'_, f64>, side: Side) -> Option<Vec<f64>> {
        let p = U::Params::map(&self.params, |_, v| f64::from(v));
        U::boundary_outflow(&p, view, side).map(|s| s.as_ref().to_vec())
    }
}

/// A cell seen through closures; slow, for references and tests.
pub(crate) struct View<'a, T> {
    pub(crate) at: &'a dyn Fn(Slot, isize, isize) -> T,
    pub(crate) uniform: &'a dyn Fn(u32) -> T,
    pub(crate) x: T,
    pub(crate) y: T,
}

impl<T: Real> Cell<T> for View<'_, T> {
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> T {
        (self.at)(slot, dx, dy)
    }
    fn x(&self) -> T {
        self.x
    }
    fn y(&self) -> T {
        self.y
    }
    fn uniform(&self, stream: u32) -> T {
        (self.uniform)(stream)
    }
}
