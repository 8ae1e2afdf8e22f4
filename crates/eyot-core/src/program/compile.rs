//! From a graph to instructions on blocks of cells.
//!
//! Every instruction computes one value for all cells of a block before the next begins, so that the choice of what to do is
//! made once a block. Its operands lie in **places**: registers, which are blocks of scratch memory that values share as their
//! lifetimes allow; constants and parameters, which fill a block each, so that all operands are read alike; and rows of layers,
//! which are read where they lie. What costs is the way through the cache between two instructions, so pairs of operations
//! of which the second alone needs the first are one instruction.

use crate::graph::{Graph, Id, Op, operands};
use crate::lanes::WIDTH;

/// Scratch memory that registers and constants may take: they must stay in the first cache, beside the rows.
const SCRATCH_BYTES: usize = 24 << 10;
/// Fewest and most cells of a block.
const BLOCK: (usize, usize) = (64, 512);

/// Where an operand lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Register(u16),
    Constant(u16),
    Row(u16),
}

/// Two operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pair {
    Add,
    Sub,
    Mul,
    Min,
    Max,
}

/// What an instruction does with its operands, in their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    Pair(Pair),
    /// `second(first(a, b), c)`.
    Left(Pair, Pair),
    /// `second(c, first(a, b))`.
    Right(Pair, Pair),
    /// As `Left`, with constants for b and c: a clamp, or a line.
    Fixed(Pair, Pair),
    /// `last(first(a, b), second(c, d))`; sums, differences and products alone.
    Tree(Pair, Pair, Pair),
    Div,
    Neg,
    Sqrt,
    Abs,
    Floor,
    /// See [`Real::flushed`](crate::real::Real::flushed).
    Flush,
    /// `c` where `a < b`, else `d`.
    Select,
    Column,
    Uniform(u32),
    ToReal,
    Whole,
    BitsAdd,
    BitsMul,
    BitsXor,
    BitsAnd,
    BitsOr,
    Shl(u32),
    Shr(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instruction {
    pub(super) action: Action,
    pub(super) to: u16,
    /// Numbers of places: registers first, then constants, then rows.
    pub(super) from: [u16; 4],
}

/// What a constant place holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Constant {
    /// A node that is the same for all cells.
    Node(Id),
    /// The row's number.
    Row,
}

/// Instructions and what they need.
#[derive(Debug)]
pub(super) struct Code {
    pub(super) instructions: Vec<Instruction>,
    pub(super) registers: usize,
    /// Cells of a block.
    pub(super) block: usize,
    pub(super) constants: Vec<Constant>,
    /// Slot and offset of each row that is read.
    pub(super) rows: Vec<(usize, isize, isize)>,
    pub(super) outputs: Vec<u16>,
    pub(super) sums: Vec<u16>,
    /// The last instruction may write the only output where it belongs.
    pub(super) direct: bool,
}

impl Code {
    pub(super) fn of(graph: &Graph) -> Self {
        let mut compiler = Compiler::new(graph);
        compiler.fuse();
        compiler.emit()
    }
}

/// An instruction whose operands are still nodes.
#[derive(Clone, Copy)]
struct Step {
    action: Action,
    from: [Option<Id>; 4],
}

struct Compiler<'a> {
    graph: &'a Graph,
    /// The node that has the value: reinterpreted bits are the same bytes.
    same: Vec<Id>,
    steps: Vec<Option<Step>>,
    uses: Vec<usize>,
    /// Nodes that are the same for all cells.
    uniform: Vec<bool>,
}

impl<'a> Compiler<'a> {
    fn new(graph: &'a Graph) -> Self {
        let mut same: Vec<Id> = Vec::new();
        for (i, &op) in graph.nodes.iter().enumerate() {
            same.push(match op {
                Op::FromBits(a) | Op::ToBits(a) => same[a as usize],
                _ => i as Id,
            });
        }
        let zeros = vec![0.0; graph.params.len()];
        let uniform = graph.uniforms(&zeros).iter().map(Option::is_some).collect();
        let mut this = Self { graph, same, steps: Vec::new(), uses: vec![0; graph.nodes.len()], uniform };
        this.steps = (0..graph.nodes.len()).map(|i| this.step(i as Id)).collect();
        // From the last to the first: what nobody needs (the parts of what became one instruction) is not computed.
        for id in graph.outputs.iter().chain(&graph.sums) {
            this.uses[this.same[*id as usize] as usize] += 1;
        }
        for i in (0..graph.nodes.len()).rev() {
            if this.uses[i] == 0 {
                this.steps[i] = None;
            }
            let Some(step) = this.steps[i] else { continue };
            step.from.into_iter().flatten().for_each(|o| this.uses[o as usize] += 1);
        }
        this
    }

    fn op(&self, id: Id) -> Op {
        self.graph.nodes[self.same[id as usize] as usize]
    }

    /// What computes a node; nothing for constants, parameters and rows.
    fn step(&self, id: Id) -> Option<Step> {
        use Op::*;
        if self.uniform[id as usize] {
            return None;
        }
        let op = self.graph.nodes[id as usize];
        let mut from = operands(op).map(|o| o.map(|o| self.same[o as usize]));
        let action = match op {
            Const(_) | BitsConst(_) | Param(_) | Read(..) | Y | FromBits(_) | ToBits(_) => return None,
            X => Action::Column,
            Uniform(stream) => Action::Uniform(stream),
            Add(..) => Action::Pair(Pair::Add),
            Sub(..) => Action::Pair(Pair::Sub),
            Mul(..) => Action::Pair(Pair::Mul),
            Div(..) => Action::Div,
            Neg(_) => Action::Neg,
            Sqrt(_) => Action::Sqrt,
            Abs(_) => Action::Abs,
            Floor(_) => Action::Floor,
            SelectLt(a, b, x, y) => {
                let [a, b, x, y] = [a, b, x, y].map(|i| self.same[i as usize]);
                let small = self.op(b) == Const(1e-30f32.to_bits()) && self.op(x) == Const(0);
                // As `Real` defines the smaller and the larger one.
                if (a, b) == (x, y) {
                    from = [Some(a), Some(b), None, None];
                    Action::Pair(Pair::Min)
                } else if (a, b) == (y, x) {
                    from = [Some(x), Some(y), None, None];
                    Action::Pair(Pair::Max)
                } else if small && matches!(self.op(a), Abs(v) if self.same[v as usize] == y) {
                    from = [Some(y), None, None, None];
                    Action::Flush
                } else {
                    Action::Select
                }
            }
            ToReal(_) => Action::ToReal,
            Whole(_) => Action::Whole,
            BitsAdd(..) => Action::BitsAdd,
            BitsMul(..) => Action::BitsMul,
            BitsXor(..) => Action::BitsXor,
            BitsAnd(..) => Action::BitsAnd,
            BitsOr(..) => Action::BitsOr,
            Shl(_, n) => Action::Shl(n),
            Shr(_, n) => Action::Shr(n),
        };
        Some(Step { action, from })
    }

    /// Makes one instruction of two where the second alone needs the first.
    fn fuse(&mut self) {
        for i in 0..self.steps.len() {
            let Some(Step { action: Action::Pair(second), from: [Some(a), Some(b), ..] }) = self.steps[i] else {
                continue;
            };
            let inner = |id: Id| match self.steps[id as usize] {
                Some(Step { action: Action::Pair(first), from: [Some(p), Some(q), ..] })
                    if self.uses[id as usize] == 1 =>
                {
                    Some((first, p, q))
                }
                _ => None,
            };
            let plain = |p: Pair| matches!(p, Pair::Add | Pair::Sub | Pair::Mul);
            let (fused, gone) = match (inner(a), inner(b)) {
                (Some((f, p, q)), Some((g, r, s))) if plain(f) && plain(g) && plain(second) => {
                    let from = [p, q, r, s].map(Some);
                    (Step { action: Action::Tree(f, g, second), from }, vec![a, b])
                }
                (Some((f, p, q)), _) => {
                    (Step { action: Action::Left(f, second), from: [Some(p), Some(q), Some(b), None] }, vec![a])
                }
                (None, Some((f, p, q))) => {
                    (Step { action: Action::Right(f, second), from: [Some(p), Some(q), Some(a), None] }, vec![b])
                }
                (None, None) => continue,
            };
            self.steps[i] = Some(fused);
            gone.into_iter().for_each(|id| self.steps[id as usize] = None);
        }
    }

    fn emit(self) -> Code {
        let n = self.steps.len();
        let roots = self.graph.outputs.iter().chain(&self.graph.sums).map(|i| self.same[*i as usize]);
        let mut last_use = vec![0; n];
        for (i, step) in self.steps.iter().enumerate() {
            step.iter().flat_map(|s| s.from).flatten().for_each(|o| last_use[o as usize] = i);
        }
        roots.for_each(|id| last_use[id as usize] = n);
        let mut code = Code {
            instructions: Vec::new(),
            registers: 0,
            block: 0,
            constants: Vec::new(),
            rows: Vec::new(),
            outputs: Vec::new(),
            sums: Vec::new(),
            direct: false,
        };
        let mut places: Vec<Option<Place>> = vec![None; n];
        let mut placed: Vec<(Action, u16, [Place; 4])> = Vec::new();
        let mut free: Vec<u16> = Vec::new();
        for i in 0..n {
            // Constants that only constants need have no place.
            if self.same[i] as usize == i && (!self.uniform[i] || self.uses[i] > 0) {
                places[i] = code.outside(i as Id, self.graph.nodes[i], self.uniform[i]);
            }
            let Some(step) = self.steps[i] else { continue };
            let nowhere = Place::Constant(0);
            let from = step.from.map(|o| o.and_then(|o| places[o as usize]).unwrap_or(nowhere));
            // Each cell of a block is read before it is written, so a value may take the place of one that ends here.
            let mut ending: Vec<u16> = Vec::new();
            for o in step.from.into_iter().flatten().filter(|o| last_use[*o as usize] == i) {
                if let Some(Place::Register(r)) = places[o as usize]
                    && !ending.contains(&r)
                {
                    ending.push(r);
                }
            }
            free.extend(ending);
            let to = free.pop().unwrap_or_else(|| {
                code.registers += 1;
                (code.registers - 1) as u16
            });
            places[i] = Some(Place::Register(to));
            let action = match (step.action, from) {
                (Action::Left(f, g), [_, Place::Constant(_), Place::Constant(_), _]) => Action::Fixed(f, g),
                (action, _) => action,
            };
            placed.push((action, to, from));
        }
        let number = |place: Place| match place {
            Place::Register(r) => r,
            Place::Constant(c) => code.registers as u16 + c,
            Place::Row(r) => (code.registers + code.constants.len()) as u16 + r,
        };
        let instruction =
            |&(action, to, from): &(Action, u16, [Place; 4])| Instruction { action, to, from: from.map(number) };
        let instructions = placed.iter().map(instruction).collect();
        let place = |id: &Id| number(places[self.same[*id as usize] as usize].unwrap_or(Place::Constant(0)));
        let (outputs, sums) =
            (self.graph.outputs.iter().map(place).collect(), self.graph.sums.iter().map(place).collect());
        (code.instructions, code.outputs, code.sums) = (instructions, outputs, sums);
        let last = code.instructions.last().map(|i| i.to);
        code.direct = matches!(code.outputs[..], [only] if Some(only) == last) && code.sums.is_empty();
        let most = SCRATCH_BYTES / (size_of::<f32>() * (code.registers + code.constants.len()).max(1));
        code.block = most.clamp(BLOCK.0, BLOCK.1) / WIDTH * WIDTH;
        code
    }
}

impl Code {
    /// The place of a value that no instruction computes.
    fn outside(&mut self, id: Id, op: Op, uniform: bool) -> Option<Place> {
        let constant = match op {
            _ if uniform => Constant::Node(id),
            Op::Y => Constant::Row,
            Op::Read(slot, dx, dy) => {
                self.rows.push((slot as usize, dx as isize, dy as isize));
                return Some(Place::Row(self.rows.len() as u16 - 1));
            }
            _ => return None,
        };
        self.constants.push(constant);
        Some(Place::Constant(self.constants.len() as u16 - 1))
    }
}
