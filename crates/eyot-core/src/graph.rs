//! Rules as expression graphs: a rule runs once on [`Node`]s and leaves its graph behind.
//!
//! Equal subexpressions are one node. The GPU engine prints the graph as WGSL, and it can be evaluated cell by cell,
//! which the tests use to show that it means what the rule means, bit by bit.

use crate::real::{Bits, Real};
use crate::rng;
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
    pub params: &'static [&'static str],
    /// Layers read.
    pub reads: Vec<&'static str>,
    /// Layers written.
    pub writes: Vec<&'static str>,
    /// Nodes of the new values.
    pub outputs: Vec<Id>,
    /// Nodes of the sums.
    pub sums: Vec<Id>,
    /// Nodes of what leaves through each side of an open rim, in the order of [`Side::ALL`]; empty where nothing does.
    pub leaving: [Vec<Id>; 4],
    /// Names that the rule gives to some of its values; see [`Real::named`].
    pub names: Vec<(Id, &'static str)>,
}

#[derive(Default)]
struct Builder {
    nodes: Vec<Op>,
    known: HashMap<Op, Id>,
    names: Vec<(Id, &'static str)>,
}

thread_local! {
    static BUILDER: RefCell<Builder> = RefCell::default();
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
pub struct Node(Id);

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
    fn whole(self) -> BitsNode {
        BitsNode(push(Op::Whole(self.0)))
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

struct Recorder;

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
        BUILDER.with_borrow_mut(|b| *b = Builder::default());
        let mut next = 0;
        let params = U::Params::build(|_| {
            next += 1;
            Node(push(Op::Param(next - 1)))
        });
        let (out, sums) = U::cell(&params, &Recorder);
        let ids = |nodes: &[Node]| nodes.iter().map(|n| n.0).collect();
        let leaving = Side::ALL.map(|side| U::leaving(&params, &Recorder, side).map_or(vec![], |s| ids(s.as_ref())));
        let builder = BUILDER.with_borrow_mut(std::mem::take);
        let mut graph = Self {
            name: U::NAME,
            nodes: builder.nodes,
            params: U::Params::NAMES,
            reads: U::READS.iter().map(|r| r.layer).collect(),
            writes: U::WRITES.to_vec(),
            outputs: ids(out.as_ref()),
            sums: ids(sums.as_ref()),
            leaving,
            names: builder.names,
        };
        graph.drop_unused();
        graph
    }

    /// Removes nodes that nothing needs.
    fn drop_unused(&mut self) {
        let roots: Vec<Id> =
            self.outputs.iter().chain(&self.sums).chain(self.leaving.iter().flatten()).copied().collect();
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
        let leaving = self.leaving.iter_mut().flatten();
        self.outputs.iter_mut().chain(&mut self.sums).chain(leaving).for_each(|id| *id = renamed[*id as usize]);
        self.names.retain(|(id, _)| used[*id as usize]);
        self.names.iter_mut().for_each(|(id, _)| *id = renamed[*id as usize]);
    }

    /// For each node whether one of `roots` needs it.
    pub fn needed(&self, roots: &[Id]) -> Vec<bool> {
        let mut used = vec![false; self.nodes.len()];
        roots.iter().for_each(|&id| used[id as usize] = true);
        for i in (0..self.nodes.len()).rev() {
            if used[i] {
                operands(self.nodes[i]).into_iter().flatten().for_each(|o| used[o as usize] = true);
            }
        }
        used
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

    /// Evaluates the graph for one cell: new values and sums.
    pub fn evaluate(
        &self,
        params: &[f32],
        x: f32,
        y: f32,
        read: impl Fn(Slot, isize, isize) -> f32,
        key: impl Fn(u32) -> u32,
    ) -> (Vec<f32>, Vec<f32>) {
        let mut v: Vec<u32> = Vec::with_capacity(self.nodes.len());
        for &op in &self.nodes {
            let f = |i: Id| f32::from_bits(v[i as usize]);
            let b = |i: Id| v[i as usize];
            let r = |f: f32| f.to_bits();
            let value = match op {
                Op::Const(c) | Op::BitsConst(c) => c,
                Op::Param(i) => r(params[i as usize]),
                Op::Read(s, dx, dy) => r(read(s as usize, dx as isize, dy as isize)),
                Op::X => r(x),
                Op::Y => r(y),
                Op::Uniform(stream) => r(rng::unit::<f32>(key(stream))),
                Op::Add(a, c) => r(f(a) + f(c)),
                Op::Sub(a, c) => r(f(a) - f(c)),
                Op::Mul(a, c) => r(f(a) * f(c)),
                Op::Div(a, c) => r(f(a) / f(c)),
                Op::Neg(a) => r(-f(a)),
                Op::Sqrt(a) => r(f(a).sqrt()),
                Op::Abs(a) => r(f(a).abs()),
                Op::Floor(a) => r(f(a).floor()),
                Op::SelectLt(a, c, p, q) => {
                    if f(a) < f(c) {
                        b(p)
                    } else {
                        b(q)
                    }
                }
                Op::FromBits(a) | Op::ToBits(a) => b(a),
                Op::ToReal(a) => r(Bits::to_real(b(a))),
                Op::Whole(a) => Real::whole(f(a)),
                Op::BitsAdd(a, c) => b(a).wrapping_add(b(c)),
                Op::BitsMul(a, c) => b(a).wrapping_mul(b(c)),
                Op::BitsXor(a, c) => b(a) ^ b(c),
                Op::BitsAnd(a, c) => b(a) & b(c),
                Op::BitsOr(a, c) => b(a) | b(c),
                Op::Shl(a, n) => b(a) << n,
                Op::Shr(a, n) => b(a) >> n,
            };
            v.push(value);
        }
        let pick = |ids: &[Id]| ids.iter().map(|&i| f32::from_bits(v[i as usize])).collect();
        (pick(&self.outputs), pick(&self.sums))
    }
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
        BUILDER.with_borrow_mut(|b| *b = Builder::default());
        let [values, sums] = run();
        assert!(values == U::WRITES.len() && sums == U::TALLIES.len(), "rule `{}` gives {values} values", U::NAME);
        for op in BUILDER.with_borrow_mut(std::mem::take).nodes {
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
        let (out, sums) = U::cell(&params(), &Recorder);
        [out.as_ref().len(), sums.as_ref().len()]
    });
    for side in Side::ALL {
        record(&|| {
            let sums = U::leaving(&params(), &Recorder, side);
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
