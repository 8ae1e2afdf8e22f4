//! Parameters of a process on their way to those of its rules.
//!
//! [`Given`] is a number that may know how it was computed: [`Process::plan`](crate::process::Process::plan) reads a parameter
//! through [`given!`](crate::given!), computes what its rules need, and hands it to
//! [`Plan::push_given`](crate::plan::Plan::push_given). The numbers are those that `f32` gives, bit by bit. Where a parameter is
//! *traced* ([`Plan::traced`](crate::plan::Plan::traced)), what is computed from it is recorded as well, as a graph with the
//! parameter as its input. Whatever takes the parameter's place, such as an expression over layers, so reaches the rules on the
//! way that the process itself wrote down.
//!
//! What decides more than numbers, such as how many passes there are, asks for [`Given::decides`]; the trace remembers it.

use crate::graph::{BitsNode, Graph, Id, Node, Op, recorded, traces};
use crate::plan::Plan;
use crate::real::{Bits, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Reads a parameter of a process, by the name of its field: `given!(plan, self.rain)`.
#[macro_export]
macro_rules! given {
    ($plan:ident, $owner:ident . $field:ident) => {
        $plan.given(stringify!($field), $owner.$field)
    };
}

/// Where a number comes from.
#[derive(Clone, Copy, Debug)]
enum Origin<N> {
    /// From the source code: the same in every step.
    Literal,
    /// From the grid, the moment or a parameter that is not traced.
    Number,
    /// From a traced parameter.
    Traced(N),
}

impl<N: Copy> Origin<N> {
    /// That of what has no node of its own.
    fn of(parts: &[Self]) -> Self {
        if parts.iter().all(|p| matches!(p, Self::Literal)) { Self::Literal } else { Self::Number }
    }

    fn is_traced(&self) -> bool {
        matches!(self, Self::Traced(_))
    }
}

/// A number that may know how it follows from traced parameters. Arithmetic is that of `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Given {
    value: f32,
    origin: Origin<Node>,
}

/// Integers beside [`Given`].
#[derive(Clone, Copy, Debug)]
pub struct GivenBits {
    value: u32,
    origin: Origin<BitsNode>,
}

impl From<f32> for Given {
    fn from(value: f32) -> Self {
        Self { value, origin: Origin::Number }
    }
}

impl Given {
    /// The traced parameter of this number.
    pub(crate) fn traced(value: f32, parameter: usize) -> Self {
        Self { value, origin: Origin::Traced(Node(traces::parameter(parameter))) }
    }

    /// The number, for what is more than a number to the rules: whether a pass runs, or how often. A traced parameter that
    /// comes here is known to decide.
    pub fn decides(self) -> f32 {
        if let Origin::Traced(node) = self.origin {
            traces::decided(node.0);
        }
        self.value
    }

    /// Radians from degrees, as [`f32::to_radians`].
    #[must_use]
    pub fn to_radians(self) -> Self {
        self * Self::of(std::f32::consts::PI / 180.0)
    }

    /// In double precision.
    pub fn wide(self) -> Wide {
        Wide { value: f64::from(self.value), origin: self.origin, times: 1.0, over: 1.0 }
    }

    pub(crate) fn value(self) -> f32 {
        self.value
    }

    /// The node of what depends on a traced parameter.
    pub(crate) fn trace(self) -> Option<Id> {
        if let Origin::Traced(node) = self.origin { Some(node.0) } else { None }
    }

    fn node(self) -> Node {
        match self.origin {
            Origin::Literal => Node::of(self.value),
            Origin::Number => Node(traces::number(self.value)),
            Origin::Traced(node) => node,
        }
    }

    /// The value of an operation on numbers, and its node if one of them is traced.
    fn from_all(all: &[Self], value: f32, node: impl FnOnce() -> Node) -> Self {
        if all.iter().any(|g| g.origin.is_traced()) {
            return Self { value, origin: Origin::Traced(node()) };
        }
        let literal = all.iter().all(|g| matches!(g.origin, Origin::Literal));
        Self { value, origin: if literal { Origin::Literal } else { Origin::Number } }
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident),*) => {$(
        impl $trait for Given {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let value = self.value.$method(other.value);
                Self::from_all(&[self, other], value, || self.node().$method(other.node()))
            }
        }
        impl $trait<f32> for Given {
            type Output = Self;
            fn $method(self, other: f32) -> Self {
                self.$method(Self::from(other))
            }
        }
        impl $trait<Given> for f32 {
            type Output = Given;
            fn $method(self, other: Given) -> Given {
                Given::from(self).$method(other)
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Given {
    type Output = Self;
    fn neg(self) -> Self {
        Self::from_all(&[self], -self.value, || -self.node())
    }
}

impl Real for Given {
    type Bits = GivenBits;
    fn of(value: f32) -> Self {
        Self { value, origin: Origin::Literal }
    }
    fn sqrt(self) -> Self {
        Self::from_all(&[self], Real::sqrt(self.value), || self.node().sqrt())
    }
    fn abs(self) -> Self {
        Self::from_all(&[self], Real::abs(self.value), || self.node().abs())
    }
    fn floor(self) -> Self {
        Self::from_all(&[self], Real::floor(self.value), || self.node().floor())
    }
    fn select_lt(a: Self, b: Self, x: Self, y: Self) -> Self {
        let value = f32::select_lt(a.value, b.value, x.value, y.value);
        Self::from_all(&[a, b, x, y], value, || Node::select_lt(a.node(), b.node(), x.node(), y.node()))
    }
    fn to_bits(self) -> GivenBits {
        let origin = match self.origin {
            Origin::Literal => Origin::Literal,
            Origin::Number => Origin::Number,
            Origin::Traced(node) => Origin::Traced(node.to_bits()),
        };
        GivenBits { value: self.value.to_bits(), origin }
    }
    fn from_bits(bits: GivenBits) -> Self {
        let origin = match bits.origin {
            Origin::Literal => Origin::Literal,
            Origin::Number => Origin::Number,
            Origin::Traced(node) => Origin::Traced(Node::from_bits(node)),
        };
        Self { value: f32::from_bits(bits.value), origin }
    }
    fn to_int_bits(self) -> GivenBits {
        let origin = match self.origin {
            Origin::Literal => Origin::Literal,
            Origin::Number => Origin::Number,
            Origin::Traced(node) => Origin::Traced(node.to_int_bits()),
        };
        GivenBits { value: self.value.to_int_bits(), origin }
    }
    fn no_contract(self) -> Self {
        Self::from_all(&[self], self.value, || self.node().no_contract())
    }
}

impl GivenBits {
    fn node(self) -> BitsNode {
        match self.origin {
            Origin::Literal => BitsNode::of(self.value),
            Origin::Number => Node(traces::number(f32::from_bits(self.value))).to_bits(),
            Origin::Traced(node) => node,
        }
    }

    fn with(self, other: Self, value: u32, node: impl FnOnce(BitsNode, BitsNode) -> BitsNode) -> Self {
        let origin = if self.origin.is_traced() || other.origin.is_traced() {
            Origin::Traced(node(self.node(), other.node()))
        } else {
            Origin::of(&[self.origin, other.origin])
        };
        Self { value, origin }
    }

    fn shifted(self, value: u32, node: impl FnOnce(BitsNode) -> BitsNode) -> Self {
        let origin = if let Origin::Traced(n) = self.origin { Origin::Traced(node(n)) } else { self.origin };
        Self { value, origin }
    }
}

impl Bits for GivenBits {
    type Real = Given;
    fn of(value: u32) -> Self {
        Self { value, origin: Origin::Literal }
    }
    fn add(self, other: Self) -> Self {
        self.with(other, Bits::add(self.value, other.value), Bits::add)
    }
    fn mul(self, other: Self) -> Self {
        self.with(other, Bits::mul(self.value, other.value), Bits::mul)
    }
    fn xor(self, other: Self) -> Self {
        self.with(other, self.value ^ other.value, Bits::xor)
    }
    fn and(self, other: Self) -> Self {
        self.with(other, self.value & other.value, Bits::and)
    }
    fn or(self, other: Self) -> Self {
        self.with(other, self.value | other.value, Bits::or)
    }
    fn shl(self, n: u32) -> Self {
        self.shifted(Bits::shl(self.value, n), |node| node.shl(n))
    }
    fn shr(self, n: u32) -> Self {
        self.shifted(Bits::shr(self.value, n), |node| node.shr(n))
    }
    fn to_real(self) -> Given {
        let origin = match self.origin {
            Origin::Literal => Origin::Literal,
            Origin::Number => Origin::Number,
            Origin::Traced(node) => Origin::Traced(node.to_real()),
        };
        Given { value: self.value.to_real(), origin }
    }
}

/// A [`Given`] in double precision, on its way through factors of the grid. In a cell it is computed in single precision: the last
/// bits may differ from what [`Wide::narrow`] gives to all cells.
#[derive(Clone, Copy, Debug)]
pub struct Wide {
    value: f64,
    origin: Origin<Node>,
    /// Factor and divisor of the node that are still to be applied.
    times: f64,
    over: f64,
}

impl Mul<f64> for Wide {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        Self { value: self.value * other, times: self.times * other, ..self }
    }
}

impl Div<f64> for Wide {
    type Output = Self;
    fn div(self, other: f64) -> Self {
        Self { value: self.value / other, over: self.over * other, ..self }
    }
}

impl Wide {
    /// The smaller one.
    #[must_use]
    pub fn min(self, most: f64) -> Self {
        let value = self.value.min(most);
        let origin = self.narrow().origin;
        let origin = if let Origin::Traced(n) = origin {
            Origin::Traced(Real::min(n, Node(traces::number(most as f32))))
        } else {
            origin
        };
        Self { value, origin, times: 1.0, over: 1.0 }
    }

    /// Rounded to single precision.
    pub fn narrow(self) -> Given {
        let Origin::Traced(mut node) = self.origin else {
            return Given { value: self.value as f32, origin: self.origin };
        };
        if self.times != 1.0 {
            node = node * Node(traces::number(self.times as f32));
        }
        if self.over != 1.0 {
            node = node / Node(traces::number(self.over as f32));
        }
        Given { value: self.value as f32, origin: Origin::Traced(node) }
    }

    /// As [`Given::decides`].
    pub fn decides(self) -> f64 {
        if let Origin::Traced(node) = self.origin {
            traces::decided(node.0);
        }
        self.value
    }
}

/// How parameters of one pass follow from traced ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The rule's parameters that do, by their numbers.
    pub params: Vec<usize>,
    /// The traced parameters that they follow from, by their numbers in [`Plan::traced`].
    pub sources: Vec<usize>,
    /// Numbers of this step that are used on the way.
    pub numbers: Vec<f32>,
    /// Values of `params` from `sources` and `numbers`, in this order.
    pub graph: Graph,
}

/// What a plan has recorded of its traced parameters.
#[derive(Debug, Default)]
pub struct Trace {
    nodes: Vec<Op>,
    numbers: Vec<f32>,
    decided: Vec<Id>,
    /// Pass, parameter of its rule, and node.
    given: Vec<(usize, usize, Id)>,
}

impl Plan {
    /// Plans while the parameters `names` are traced.
    pub fn traced(names: &[&str], plan: impl FnOnce(&mut Self)) -> (Self, Trace) {
        let mut own = Self { traced: names.iter().map(|n| (*n).to_owned()).collect(), ..Self::default() };
        let ((), builder) = recorded(|| plan(&mut own));
        let given = std::mem::take(&mut own.given);
        own.traced.clear();
        let trace = Trace { nodes: builder.nodes, numbers: builder.numbers, decided: builder.decided, given };
        (own, trace)
    }
}

impl Trace {
    /// The traced parameters that decide more than numbers.
    pub fn decided(&self) -> Vec<usize> {
        self.sources(&self.decided)
    }

    /// The traced parameters that reach a rule.
    pub fn used(&self) -> Vec<usize> {
        self.sources(&self.given.iter().map(|(_, _, id)| *id).collect::<Vec<_>>())
    }

    fn sources(&self, roots: &[Id]) -> Vec<usize> {
        let mut all: Vec<usize> = self.inputs(roots).filter_map(traces::as_parameter).collect();
        all.sort_unstable();
        all
    }

    /// Numbers of the parameters of the nodes that `roots` need.
    fn inputs(&self, roots: &[Id]) -> impl Iterator<Item = u32> + '_ {
        let needed = crate::graph::needed(&self.nodes, roots);
        self.nodes.iter().zip(needed).filter_map(|(op, needed)| match op {
            Op::Param(i) if needed => Some(*i),
            _ => None,
        })
    }

    /// How parameters of the pass of this number follow from traced ones; `None` if none does.
    pub fn way(&self, pass: usize, name: &'static str) -> Option<Way> {
        let own = self.given.iter().filter(|(p, ..)| *p == pass);
        let (params, outputs): (Vec<usize>, Vec<Id>) = own.map(|(_, param, id)| (*param, *id)).unzip();
        if params.is_empty() {
            return None;
        }
        let sources = self.sources(&outputs);
        let captured: Vec<u32> = self.inputs(&outputs).filter(|i| traces::as_parameter(*i).is_none()).collect();
        let numbers = captured.iter().filter_map(|i| traces::as_number(*i)).map(|i| self.numbers[i]).collect();
        let place = |i: u32| match traces::as_parameter(i) {
            Some(source) => sources.iter().position(|s| *s == source),
            None => captured.iter().position(|c| *c == i).map(|c| sources.len() + c),
        };
        let moved = |op: &Op| match *op {
            // What is not needed is dropped, whatever it reads.
            Op::Param(i) => Op::Param(place(i).unwrap_or_default() as u32),
            op => op,
        };
        let nodes = self.nodes.iter().map(moved).collect();
        let graph = Graph::of_nodes(name, nodes, outputs);
        Some(Way { params, sources, numbers, graph })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::rule::{Cell, Slot};

    struct Nowhere;
    impl Cell<f32> for Nowhere {
        fn at(&self, _: Slot, _: isize, _: isize) -> f32 {
            0.0
        }
        fn x(&self) -> f32 {
            0.0
        }
        fn y(&self) -> f32 {
            0.0
        }
        fn uniform(&self, _: u32) -> f32 {
            0.0
        }
    }

    /// Something of every operation.
    fn way<R: Real>(a: R, b: R, dt: R) -> R {
        let share = R::of(1.0) - math::exp(-dt / a);
        let turned = math::sin(a * b) + math::ln(a.abs() + R::of(0.5)) + (a * a + b).sqrt().floor();
        (share * turned).max(b - dt).clamp(R::of(-3.0), R::of(3.0)).no_contract()
    }

    /// The numbers are those of `f32`, and so is what the trace computes from others, bit by bit.
    #[test]
    fn traces_compute_what_the_code_computes() {
        let numbers = [0.3_f32, 1.0, 2.5, 24.0, 917.25];
        let (mut plan, dt) = (Plan::default(), 0.7_f32);
        assert_eq!(way(plan.given("a", 2.5), plan.given("b", 0.25), dt.into()).value(), way(2.5, 0.25, dt));
        assert!(way(plan.given("a", 2.5), plan.given("b", 0.25), dt.into()).trace().is_none());
        plan.traced = vec!["a".into(), "b".into()];
        let (id, builder) = recorded(|| way(plan.given("a", 2.5), plan.given("b", 0.25), dt.into()).trace().unwrap());
        let trace = Trace { nodes: builder.nodes, numbers: builder.numbers, decided: vec![], given: vec![(0, 3, id)] };
        let way_of = trace.way(0, "test").unwrap();
        assert_eq!((&way_of.params[..], &way_of.sources[..]), (&[3][..], &[0, 1][..]));
        assert!(way_of.numbers.iter().all(|n| n.abs() == dt) && !way_of.numbers.is_empty());
        for (a, b) in numbers.iter().flat_map(|a| numbers.map(|b| (*a, b))) {
            let all: Vec<f32> = [a, b].into_iter().chain(way_of.numbers.iter().copied()).collect();
            let found = way_of.graph.evaluate(&all, &Nowhere).0[0];
            assert_eq!(found.to_bits(), way(a, b, dt).to_bits(), "{a} {b}: {found}");
        }
    }

    /// Numbers of a step are no part of a way: it is the same in every step.
    #[test]
    fn ways_are_the_same_in_every_step() {
        let of = |dt: f32| {
            let (_, builder) = recorded(|| ());
            assert!(builder.nodes.is_empty());
            let plan = Plan { traced: vec!["a".into()], ..Plan::default() };
            let (id, builder) =
                recorded(|| way(plan.given("a", 2.5), Given::from(dt * 3.0), dt.into()).trace().unwrap());
            let trace =
                Trace { nodes: builder.nodes, numbers: builder.numbers, decided: vec![], given: vec![(0, 0, id)] };
            trace.way(0, "test").unwrap().graph
        };
        assert_eq!(of(0.1), of(55.0));
    }

    #[test]
    fn what_decides_is_known() {
        let (_, trace) = Plan::traced(&["a", "b", "c"], |plan| {
            let (a, b) = (plan.given("a", 2.0), plan.given("b", 3.0));
            assert_eq!((a * b).decides(), 6.0);
            assert_eq!(plan.given("c", 4.0).wide().decides(), 4.0);
            assert_eq!(plan.given("d", 4.0).decides(), 4.0);
        });
        assert_eq!((trace.decided(), trace.used()), (vec![0, 1, 2], vec![]));
    }

    /// Double precision loses nothing where the parameter is a number.
    #[test]
    fn wide_numbers_are_computed_in_double_precision() {
        let (x, grid) = (5e5_f32, 1234.567_f64);
        let wide = |g: Given| (g.wide() * 3600.0 * 0.3 / (grid * grid)).min(0.05).narrow();
        assert_eq!(wide(x.into()).value(), (f64::from(x) * 3600.0 * 0.3 / (grid * grid)).min(0.05) as f32);
        let plan = Plan { traced: vec!["a".into()], ..Plan::default() };
        let (id, builder) = recorded(|| wide(plan.given("a", x)).trace().unwrap());
        let trace = Trace { nodes: builder.nodes, numbers: builder.numbers, decided: vec![], given: vec![(0, 0, id)] };
        let way = trace.way(0, "test").unwrap();
        for x in [0.0, 1.0, 33.0, 8e4] {
            let all: Vec<f32> = std::iter::once(x).chain(way.numbers.iter().copied()).collect();
            let (found, expected) = (way.graph.evaluate(&all, &Nowhere).0[0], wide(x.into()).value());
            assert!((found - expected).abs() <= 3e-7 * expected, "{x}: {found} {expected}");
        }
    }
}
