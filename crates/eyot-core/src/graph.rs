//! Rules as expression graphs: a rule runs once on [`Node`]s and leaves its graph behind.
//!
//! Equal subexpressions are one node. The GPU engine prints the graph as WGSL, and it can be evaluated cell by cell,
//! which the tests use to show that it means what the rule means, bit by bit.

use crate::real::{Bits, Real};
use crate::rule::{Cell, ParamSet, Rule, Side, Slot};
use std::any::TypeId;
use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::Mutex;

/// Number of a node in its graph; operands always have smaller numbers.
pub type Id = u32;

/// One operation. Floats are kept as bit patterns, so that nodes can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The names say it: real operations first, then those on 32-bit unsigned integers.
pub enum Op {
    Const(u32),
    Param(u32),
    Read(u32, i32, i32),
    X,
    Y,
    Uniform(u32),
    Add(Id, Id),
    Sub(Id, Id),
    Mul(Id, Id),
    Div(Id, Id),
    Neg(Id),
    Sqrt(Id),
    Abs(Id),
    Floor(Id),
    SelectLt(Id, Id, Id, Id),
    FromBits(Id),
    ToReal(Id),
    BitsConst(u32),
    ToBits(Id),
    Whole(Id),
    BitsAdd(Id, Id),
    BitsMul(Id, Id),
    BitsXor(Id, Id),
    BitsAnd(Id, Id),
    BitsOr(Id, Id),
    Shl(Id, u32),
    Shr(Id, u32),
}

impl Op {
    /// True if the value is an integer, false if it is real.
    pub fn is_bits(self) -> bool {
        use Op::*;
        matches!(
            self,
            BitsConst(_)
                | ToBits(_)
                | Whole(_)
                | BitsAdd(..)
                | BitsMul(..)
                | BitsXor(..)
                | BitsAnd(..)
                | BitsOr(..)
                | Shl(..)
                | Shr(..)
        )
    }
}

/// The expression graph of one rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Name of the rule.
    pub name: &'static str,
    /// Operations; operands come before their users.
    pub nodes: Vec<Op>,
    /// Names of the parameters.
    pub params: Vec<&'static str>,
    /// Layers read.
    pub reads: Vec<&'static str>,
    /// Layers written.
    pub writes: Vec<&'static str>,
    /// Nodes of the new values.
    pub outputs: Vec<Id>,
    /// Nodes of the sums.
    pub sums: Vec<Id>,
    /// Nodes of what leaves through each side of an open rim, in the order of [`Side::ALL`]; empty where nothing does.
    pub boundary_outflow: [Vec<Id>; 4],
    /// Names that the rule gives to some of its values; see [`Real::named`].
    pub names: Vec<(Id, &'static str)>,
}

#[derive(Default)]
pub(crate) struct Builder {
    pub(crate) nodes: Vec<Op>,
    known: HashMap<Op, Id>,
    names: Vec<(Id, &'static str)>,
    /// Numbers of a step; see [`traces`].
    pub(crate) numbers: Vec<f32>,
    /// Nodes whose values decided something.
    pub(crate) decided: Vec<Id>,
}

thread_local! {
    static BUILDER: RefCell<Builder> = RefCell::default();
}

/// Runs something and gives back the nodes that it made; those that were there before are there again afterwards.
pub(crate) fn recorded<T>(run: impl FnOnce() -> T) -> (T, Builder) {
    let outer = BUILDER.replace(Builder::default());
    let result = run();
    (result, BUILDER.replace(outer))
}

/// Inputs of traces of parameters: they are parameters of the graph, traced ones by their number, numbers of a step behind them.
pub(crate) mod traces {
    use super::{BUILDER, Id, Op, push};

    const FIRST_NUMBER: u32 = 1 << 16;

    pub(crate) fn parameter(number: usize) -> Id {
        push(Op::Param(number as u32))
    }

    /// A number that may differ from step to step.
    pub(crate) fn number(value: f32) -> Id {
        let place = BUILDER.with_borrow_mut(|b| {
            b.numbers.push(value);
            b.numbers.len() as u32 - 1
        });
        push(Op::Param(FIRST_NUMBER + place))
    }

    pub(crate) fn decided(node: Id) {
        BUILDER.with_borrow_mut(|b| b.decided.push(node));
    }

    pub(crate) fn as_parameter(input: u32) -> Option<usize> {
        (input < FIRST_NUMBER).then_some(input as usize)
    }

    pub(crate) fn as_number(input: u32) -> Option<usize> {
        input.checked_sub(FIRST_NUMBER).map(|i| i as usize)
    }
}

fn push(op: Op) -> Id {
    BUILDER.with_borrow_mut(|b| {
        if let Some(&id) = b.known.get(&op) {
            return id;
        }
        let id = b.nodes.len() as Id;
        b.nodes.push(op);
        b.known.insert(op, id);
        id
    })
}

/// A real number yet to be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node(pub(crate) Id);

/// An integer yet to be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitsNode(Id);

macro_rules! operators {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait for Node {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(push(Op::$trait(self.0, other.0)))
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Node {
    type Output = Self;
    fn neg(self) -> Self {
        Self(push(Op::Neg(self.0)))
    }
}

impl Real for Node {
    type Bits = BitsNode;
    fn of(v: f32) -> Self {
        Self(push(Op::Const(v.to_bits())))
    }
    fn sqrt(self) -> Self {
        Self(push(Op::Sqrt(self.0)))
    }
    fn abs(self) -> Self {
        Self(push(Op::Abs(self.0)))
    }
    fn floor(self) -> Self {
        Self(push(Op::Floor(self.0)))
    }
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        Self(push(Op::SelectLt(a.0, b.0, x.0, y.0)))
    }
    fn to_bits(self) -> BitsNode {
        BitsNode(push(Op::ToBits(self.0)))
    }
    fn from_bits(bits: BitsNode) -> Self {
        Self(push(Op::FromBits(bits.0)))
    }
    fn to_int_bits(self) -> BitsNode {
        BitsNode(push(Op::Whole(self.0)))
    }
    fn no_contract(self) -> Self {
        Self::from_bits(self.to_bits())
    }
    fn named(self, name: &'static str) -> Self {
        BUILDER.with_borrow_mut(|b| b.names.push((self.0, name)));
        self
    }
}

impl Bits for BitsNode {
    type Real = Node;
    fn of(v: u32) -> Self {
        Self(push(Op::BitsConst(v)))
    }
    fn add(self, other: Self) -> Self {
        Self(push(Op::BitsAdd(self.0, other.0)))
    }
    fn mul(self, other: Self) -> Self {
        Self(push(Op::BitsMul(self.0, other.0)))
    }
    fn xor(self, other: Self) -> Self {
        Self(push(Op::BitsXor(self.0, other.0)))
    }
    fn and(self, other: Self) -> Self {
        Self(push(Op::BitsAnd(self.0, other.0)))
    }
    fn or(self, other: Self) -> Self {
        Self(push(Op::BitsOr(self.0, other.0)))
    }
    fn shl(self, n: u32) -> Self {
        Self(push(Op::Shl(self.0, n)))
    }
    fn shr(self, n: u32) -> Self {
        Self(push(Op::Shr(self.0, n)))
    }
    fn to_real(self) -> Node {
        Node(push(Op::ToReal(self.0)))
    }
}

/// A cell on which a rule leaves its graph; see [`Graph::record`].
#[derive(Clone, Copy, Debug)]
pub struct Recorder(());

impl Cell<Node> for Recorder {
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> Node {
        Node(push(Op::Read(slot as u32, dx as i32, dy as i32)))
    }
    fn x(&self) -> Node {
        Node(push(Op::X))
    }
    fn y(&self) -> Node {
        Node(push(Op::Y))
    }
    fn uniform(&self, stream: u32) -> Node {
        Node(push(Op::Uniform(stream)))
    }
}

impl Graph {
    /// Runs the rule once and keeps what it did.
    pub fn of<U: Rule>() -> Self {
        let ids = |nodes: &[Node]| nodes.iter().map(|n| n.0).collect();
        let ((out, sums, boundary_outflow), builder) = recorded(|| {
            let mut next = 0;
            let params = U::Params::build(|_| {
                next += 1;
                Node(push(Op::Param(next - 1)))
            });
            let (out, sums) = U::cell(&params, &Recorder(()));
            let boundary_outflow = Side::ALL
                .map(|side| U::boundary_outflow(&params, &Recorder(()), side).map_or(vec![], |s| ids(s.as_ref())));
            (out, sums, boundary_outflow)
        });
        let mut graph = Self {
            name: U::NAME,
            nodes: builder.nodes,
            params: U::Params::NAMES.to_vec(),
            reads: U::READS.iter().map(|r| r.layer).collect(),
            writes: U::WRITES.to_vec(),
            outputs: ids(out.as_ref()),
            sums: ids(sums.as_ref()),
            boundary_outflow,
            names: builder.names,
        };
        graph.drop_unused();
        graph
    }

    /// Records what `rule` does with a cell and the parameters: new values of `writes`, and summands.
    pub fn record(
        name: &'static str,
        params: Vec<&'static str>,
        reads: Vec<&'static str>,
        writes: Vec<&'static str>,
        rule: impl FnOnce(&Recorder, &[Node]) -> (Vec<Node>, Vec<Node>),
    ) -> Self {
        let ((outputs, sums), builder) = recorded(|| {
            let values: Vec<Node> = (0..params.len()).map(|i| Node(push(Op::Param(i as u32)))).collect();
            rule(&Recorder(()), &values)
        });
        let ids = |nodes: Vec<Node>| nodes.into_iter().map(|n| n.0).collect();
        let (outputs, sums) = (ids(outputs), ids(sums));
        let boundary_outflow = Default::default();
        let mut graph = Self {
            name,
            nodes: builder.nodes,
            params,
            reads,
            writes,
            outputs,
            sums,
            boundary_outflow,
            names: builder.names,
        };
        graph.drop_unused();
        graph
    }

    /// The same rule with parameters that each cell computes for itself. `reads` and `params` are those of this graph and
    /// further ones behind them; `values` gives the parameters of this graph from all parameters of the new one.
    #[must_use]
    pub fn with_parameters(
        &self,
        reads: Vec<&'static str>,
        params: Vec<&'static str>,
        values: impl FnOnce(&Recorder, &[Node]) -> Vec<Node>,
    ) -> Self {
        let ids = |nodes: Vec<Node>| nodes.into_iter().map(|n| n.0).collect::<Vec<Id>>();
        let ((outputs, sums, boundary_outflow), builder) = recorded(|| {
            let all: Vec<Node> = (0..params.len()).map(|i| Node(push(Op::Param(i as u32)))).collect();
            let cell = Recorder(());
            let own = values(&cell, &all);
            let (outputs, sums) = self.evaluate(&own, &cell);
            let boundary_outflow =
                Side::ALL.map(|side| self.evaluate_boundary_outflow(&own, &cell, side).map_or(vec![], ids));
            (ids(outputs), ids(sums), boundary_outflow)
        });
        let (nodes, names) = (builder.nodes, Vec::new());
        let mut graph = Self {
            name: self.name,
            nodes,
            params,
            reads,
            writes: self.writes.clone(),
            outputs,
            sums,
            boundary_outflow,
            names,
        };
        graph.drop_unused();
        graph
    }

    /// Values of nodes that read parameters alone.
    pub(crate) fn of_nodes(name: &'static str, nodes: Vec<Op>, outputs: Vec<Id>) -> Self {
        let (boundary_outflow, names) = (Default::default(), Vec::new());
        let (params, reads, writes, sums) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut graph = Self { name, nodes, params, reads, writes, outputs, sums, boundary_outflow, names };
        graph.drop_unused();
        graph
    }

    /// Computes what depends on constants alone, and drops what nothing needs any more.
    pub(crate) fn fold(&mut self) {
        let mut known: HashMap<Op, Id> = HashMap::new();
        let (mut nodes, mut renamed) = (Vec::<Op>::new(), Vec::<Id>::with_capacity(self.nodes.len()));
        for &op in &self.nodes {
            let op = map_operands(op, |o| renamed[o as usize]);
            let of = operands(op);
            let constant = |id: Id| match nodes[id as usize] {
                Op::Const(c) | Op::BitsConst(c) => Some(c),
                _ => None,
            };
            let fixed = of[0].is_some() && of.into_iter().flatten().all(|id| constant(id).is_some());
            let op = if fixed {
                let bits = |id: Id| constant(id).unwrap_or_default();
                let value = apply(op, |id| f32::from_bits(bits(id)), bits);
                match value {
                    Value::Real(v) => Op::Const(v.to_bits()),
                    Value::Bits(v) => Op::BitsConst(v),
                }
            } else {
                op
            };
            let id = *known.entry(op).or_insert_with(|| {
                nodes.push(op);
                nodes.len() as Id - 1
            });
            renamed.push(id);
        }
        self.nodes = nodes;
        self.rename(&renamed);
        self.drop_unused();
    }

    /// Gives what points to nodes their new numbers.
    fn rename(&mut self, renamed: &[Id]) {
        let boundary_outflow = self.boundary_outflow.iter_mut().flatten();
        let named = self.names.iter_mut().map(|(id, _)| id);
        let all = self.outputs.iter_mut().chain(&mut self.sums).chain(boundary_outflow).chain(named);
        all.for_each(|id| *id = renamed[*id as usize]);
    }

    /// Removes nodes that nothing needs.
    fn drop_unused(&mut self) {
        let roots: Vec<Id> =
            self.outputs.iter().chain(&self.sums).chain(self.boundary_outflow.iter().flatten()).copied().collect();
        let used = self.needed(&roots);
        let mut renamed = vec![0; self.nodes.len()];
        let mut kept = Vec::new();
        for (i, &op) in self.nodes.iter().enumerate() {
            if used[i] {
                renamed[i] = kept.len() as Id;
                kept.push(map_operands(op, |o| renamed[o as usize]));
            }
        }
        self.nodes = kept;
        self.names.retain(|(id, _)| used[*id as usize]);
        self.rename(&renamed);
    }

    /// For each node whether one of `roots` needs it.
    pub fn needed(&self, roots: &[Id]) -> Vec<bool> {
        needed(&self.nodes, roots)
    }

    /// How often each node is an operand or a sum; outputs count twice, since they may go to several places.
    pub fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.nodes.len()];
        let of_nodes = self.nodes.iter().flat_map(|op| operands(*op).into_iter().flatten());
        let all = of_nodes.chain(self.sums.iter().chain(self.boundary_outflow.iter().flatten()).copied());
        all.for_each(|id| uses[id as usize] += 1);
        self.outputs.iter().for_each(|id| uses[*id as usize] += 2);
        uses
    }

    /// Arithmetic operations of a cell: everything but constants, parameters, reads, coordinates and reinterpreted bits. A
    /// comparison with its choice counts as one. What only cells at the rim do does not count.
    pub fn operations(&self) -> usize {
        let free = |op: &&Op| {
            use Op::*;
            !matches!(op, Const(_) | BitsConst(_) | Param(_) | Read(..) | X | Y | Uniform(_) | FromBits(_) | ToBits(_))
        };
        let roots: Vec<Id> = self.outputs.iter().chain(&self.sums).copied().collect();
        self.nodes.iter().zip(self.needed(&roots)).filter(|(op, needed)| *needed && free(op)).count()
    }

    /// Farthest offset at which the layer in `slot` is read.
    pub fn reach(&self, slot: Slot) -> usize {
        let far = |op: &Op| match *op {
            Op::Read(s, dx, dy) if s as usize == slot => dx.unsigned_abs().max(dy.unsigned_abs()) as usize,
            _ => 0,
        };
        self.nodes.iter().map(far).max().unwrap_or(0)
    }

    /// The bits of each node that is the same for all cells, because it needs nothing but constants and parameters.
    pub(crate) fn uniforms(&self, params: &[f32]) -> Vec<Option<u32>> {
        let mut values: Vec<Option<u32>> = Vec::with_capacity(self.nodes.len());
        for &op in &self.nodes {
            let bits = |id: Id| values[id as usize].unwrap_or_default();
            let value = match op {
                Op::Param(i) => Some(params[i as usize].to_bits()),
                Op::Read(..) | Op::X | Op::Y | Op::Uniform(_) => None,
                _ if operands(op).into_iter().flatten().any(|o| values[o as usize].is_none()) => None,
                _ => match apply(op, |id| f32::from_bits(bits(id)), bits) {
                    Value::Real(v) => Some(v.to_bits()),
                    Value::Bits(v) => Some(v),
                },
            };
            values.push(value);
        }
        values
    }

    /// Evaluates the graph for one cell: new values and sums.
    pub fn evaluate<R: Real>(&self, params: &[R], cell: &impl Cell<R>) -> (Vec<R>, Vec<R>) {
        let values = self.values(params, cell);
        (pick(&values, &self.outputs), pick(&values, &self.sums))
    }

    /// Evaluates what leaves through a side of a border cell; `None` if nothing ever leaves there.
    pub fn evaluate_boundary_outflow<R: Real>(&self, params: &[R], cell: &impl Cell<R>, side: Side) -> Option<Vec<R>> {
        let boundary_outflow = &self.boundary_outflow[side as usize];
        (!boundary_outflow.is_empty()).then(|| pick(&self.values(params, cell), boundary_outflow))
    }

    /// The value of each node that is no integer.
    fn values<R: Real>(&self, params: &[R], cell: &impl Cell<R>) -> Vec<R> {
        // One of the two is meant, as [`Op::is_bits`] says.
        let (mut reals, mut bits) = (Vec::<R>::new(), Vec::<R::Bits>::new());
        for &op in &self.nodes {
            let value = match op {
                Op::Param(i) => Value::Real(params[i as usize]),
                Op::Read(s, dx, dy) => Value::Real(cell.at(s as usize, dx as isize, dy as isize)),
                Op::X => Value::Real(cell.x()),
                Op::Y => Value::Real(cell.y()),
                Op::Uniform(stream) => Value::Real(cell.uniform(stream)),
                _ => apply(op, |id| reals[id as usize], |id| bits[id as usize]),
            };
            let (real, integer) = match value {
                Value::Real(v) => (v, R::Bits::of(0)),
                Value::Bits(v) => (R::of(0.0), v),
            };
            reals.push(real);
            bits.push(integer);
        }
        reals
    }
}

/// For each node whether one of `roots` needs it.
pub(crate) fn needed(nodes: &[Op], roots: &[Id]) -> Vec<bool> {
    let mut used = vec![false; nodes.len()];
    roots.iter().for_each(|&id| used[id as usize] = true);
    for i in (0..nodes.len()).rev() {
        if used[i] {
            operands(nodes[i]).into_iter().flatten().for_each(|o| used[o as usize] = true);
        }
    }
    used
}

fn pick<R: Copy>(values: &[R], ids: &[Id]) -> Vec<R> {
    ids.iter().map(|&i| values[i as usize]).collect()
}

/// What an operation gives.
enum Value<R: Real> {
    Real(R),
    Bits(R::Bits),
}

/// The operation on values that are known. Reads, coordinates and parameters are none of its own, and give 0.
fn apply<R: Real>(op: Op, f: impl Fn(Id) -> R, b: impl Fn(Id) -> R::Bits) -> Value<R> {
    use Value::{Bits as B, Real as V};
    match op {
        Op::Param(_) | Op::Read(..) | Op::X | Op::Y | Op::Uniform(_) => V(R::of(0.0)),
        Op::Const(c) => V(R::of(f32::from_bits(c))),
        Op::Add(a, c) => V(f(a) + f(c)),
        Op::Sub(a, c) => V(f(a) - f(c)),
        Op::Mul(a, c) => V(f(a) * f(c)),
        Op::Div(a, c) => V(f(a) / f(c)),
        Op::Neg(a) => V(-f(a)),
        Op::Sqrt(a) => V(f(a).sqrt()),
        Op::Abs(a) => V(f(a).abs()),
        Op::Floor(a) => V(f(a).floor()),
        Op::SelectLt(a, c, p, q) => V(R::select_lt(f(a), f(c), f(p), f(q))),
        Op::FromBits(a) => V(R::from_bits(b(a))),
        Op::ToReal(a) => V(real_of(b(a))),
        Op::BitsConst(c) => B(R::Bits::of(c)),
        Op::ToBits(a) => B(f(a).to_bits()),
        Op::Whole(a) => B(f(a).to_int_bits()),
        Op::BitsAdd(a, c) => B(b(a).add(b(c))),
        Op::BitsMul(a, c) => B(b(a).mul(b(c))),
        Op::BitsXor(a, c) => B(b(a).xor(b(c))),
        Op::BitsAnd(a, c) => B(b(a).and(b(c))),
        Op::BitsOr(a, c) => B(b(a).or(b(c))),
        Op::Shl(a, n) => B(b(a).shl(n)),
        Op::Shr(a, n) => B(b(a).shr(n)),
    }
}

fn real_of<B: Bits>(bits: B) -> B::Real {
    bits.to_real()
}

/// Records a rule once per type and compares what it does with what it declares.
///
/// # Panics
/// If it reads a slot or reaches farther than declared, or gives back other numbers of values.
pub(crate) fn check<U: Rule>() {
    static CHECKED: Mutex<Vec<TypeId>> = Mutex::new(Vec::new());
    let mut checked = CHECKED.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if checked.contains(&TypeId::of::<U>()) {
        return;
    }
    let record = |run: &dyn Fn() -> [usize; 2]| {
        let ([values, sums], builder) = recorded(run);
        assert!(values == U::WRITES.len() && sums == U::TALLIES.len(), "rule `{}` gives {values} values", U::NAME);
        for op in builder.nodes {
            if let Op::Read(slot, dx, dy) = op {
                let reach = dx.unsigned_abs().max(dy.unsigned_abs()) as usize;
                let declared = U::READS.get(slot as usize);
                assert!(
                    declared.is_some_and(|r| reach <= r.reach),
                    "rule `{}` reads slot {slot} at ({dx}, {dy}), but declares {declared:?}",
                    U::NAME
                );
            }
        }
    };
    let params = || U::Params::build(|_| Node(push(Op::Param(0))));
    record(&|| {
        let (out, sums) = U::cell(&params(), &Recorder(()));
        [out.as_ref().len(), sums.as_ref().len()]
    });
    for side in Side::ALL {
        record(&|| {
            let sums = U::boundary_outflow(&params(), &Recorder(()), side);
            [U::WRITES.len(), sums.map_or(U::TALLIES.len(), |s| s.as_ref().len())]
        });
    }
    checked.push(TypeId::of::<U>());
}

/// The operands of an operation, `None` where it has fewer than four.
pub fn operands(op: Op) -> [Option<Id>; 4] {
    use Op::*;
    match op {
        Const(_) | Param(_) | Read(..) | X | Y | Uniform(_) | BitsConst(_) => [None; 4],
        Neg(a)
        | Sqrt(a)
        | Abs(a)
        | Floor(a)
        | FromBits(a)
        | ToReal(a)
        | ToBits(a)
        | Whole(a)
        | Shl(a, _)
        | Shr(a, _) => [Some(a), None, None, None],
        Add(a, b)
        | Sub(a, b)
        | Mul(a, b)
        | Div(a, b)
        | BitsAdd(a, b)
        | BitsMul(a, b)
        | BitsXor(a, b)
        | BitsAnd(a, b)
        | BitsOr(a, b) => [Some(a), Some(b), None, None],
        SelectLt(a, b, x, y) => [Some(a), Some(b), Some(x), Some(y)],
    }
}

fn map_operands(op: Op, f: impl Fn(Id) -> Id) -> Op {
    use Op::*;
    match op {
        Const(_) | Param(_) | Read(..) | X | Y | Uniform(_) | BitsConst(_) => op,
        Neg(a) => Neg(f(a)),
        Sqrt(a) => Sqrt(f(a)),
        Abs(a) => Abs(f(a)),
        Floor(a) => Floor(f(a)),
        FromBits(a) => FromBits(f(a)),
        ToReal(a) => ToReal(f(a)),
        ToBits(a) => ToBits(f(a)),
        Whole(a) => Whole(f(a)),
        Shl(a, n) => Shl(f(a), n),
        Shr(a, n) => Shr(f(a), n),
        Add(a, b) => Add(f(a), f(b)),
        Sub(a, b) => Sub(f(a), f(b)),
        Mul(a, b) => Mul(f(a), f(b)),
        Div(a, b) => Div(f(a), f(b)),
        BitsAdd(a, b) => BitsAdd(f(a), f(b)),
        BitsMul(a, b) => BitsMul(f(a), f(b)),
        BitsXor(a, b) => BitsXor(f(a), f(b)),
        BitsAnd(a, b) => BitsAnd(f(a), f(b)),
        BitsOr(a, b) => BitsOr(f(a), f(b)),
        SelectLt(a, b, x, y) => SelectLt(f(a), f(b), f(x), f(y)),
    }
}
