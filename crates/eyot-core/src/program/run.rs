//! Runs the instructions of a program over a row of cells.

// Reason for the exception: as in `kernel`, rows of several layers are read and written through raw pointers.
#![allow(unsafe_code)]

use super::Bound;
use super::compile::{Action, Code, Constant, Instruction, Pair};
use crate::isa::{Isa, LaneTask, run_lanes};
use crate::kernel::{RowJob, forget, leave_by};
use crate::lanes::{LaneBlock, Lanes, WIDTH};
use crate::real::{Bits, Real};
use crate::rng::{self, Key};
use crate::rule::{MAX_REACH, MAX_TALLIES};
use std::cell::RefCell;

/// Runs a program over the row.
pub(super) fn row(isa: Isa, bound: &Bound, job: &mut RowJob) {
    let (program, params) = (&*bound.program, &bound.params[..]);
    // What leaves is computed from the old state, so it comes before the row, which may overwrite it.
    if job.open.iter().any(|&o| o) {
        leave_by(job, |cell, side| program.graph.evaluate_boundary_outflow(params, cell, side));
    }
    if job.west_face.iter().any(|&f| f) {
        let (values, _) = program.graph.evaluate(params, &job.cell(-1));
        for (i, v) in values.iter().enumerate().filter(|(i, _)| job.west_face[*i]) {
            // SAFETY: column -1 is padding of the row that belongs to this job.
            unsafe { *job.out[i].offset(-1) = *v };
        }
    }
    let isa = job.place.isa(isa);
    if isa == Isa::Scalar {
        return scalar_row(bound, job);
    }
    SCRATCH.with_borrow_mut(|scratch| {
        scratch.prepare(&program.code, &bound.constants, job);
        run_lanes(isa, Blocks { code: &program.code, scratch, job });
    });
}

fn scalar_row(bound: &Bound, job: &mut RowJob) {
    let (program, params) = (&*bound.program, &bound.params[..]);
    // Sums are kept in sixteen parts as in lanes, so that the bits agree.
    let mut sums = [[0.0f32; WIDTH]; MAX_TALLIES];
    for x in 0..job.width {
        let (values, summands) = program.graph.evaluate(params, &job.cell(x as isize));
        for (i, v) in values.iter().enumerate() {
            // SAFETY: the schedule gives this row of the written layer to this job alone.
            unsafe { *job.out[i].add(x) = *v };
        }
        for (sum, v) in sums.iter_mut().zip(&summands).filter(|_| job.counted.contains(&x)) {
            sum[x % WIDTH] += v;
        }
    }
    for (total, sum) in job.sums.iter_mut().zip(&sums).take(program.code.sums.len()) {
        *total += sum.iter().map(|&v| f64::from(v)).sum::<f64>();
    }
}

/// Memory that a thread keeps from row to row.
#[derive(Default)]
struct Scratch {
    /// Registers, then constants.
    memory: Vec<Lanes>,
    /// Where each place lies, and whether it moves on with the columns: registers, constants, rows from column 0 on.
    places: Vec<(*mut f32, usize)>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl Scratch {
    fn prepare(&mut self, code: &Code, constants: &[f32], job: &RowJob) {
        let block = code.block / WIDTH;
        let (registers, all) = (code.registers * block, (code.registers + code.constants.len()) * block);
        if self.memory.len() < all {
            self.memory.resize(all, Lanes([0.0; WIDTH]));
        }
        let used = job.width.div_ceil(WIDTH).min(block);
        let places = self.memory[registers..all].chunks_exact_mut(block);
        for ((lanes, constant), value) in places.zip(&code.constants).zip(constants) {
            let value = if *constant == Constant::Row { job.place.row() } else { *value };
            lanes[..used].fill(Lanes([value; WIDTH]));
        }
        self.places.clear();
        let memory = self.memory.as_mut_ptr().cast::<f32>();
        for i in 0..code.registers + code.constants.len() {
            // SAFETY: there is room for all of them.
            self.places.push((unsafe { memory.add(i * code.block) }, 0));
        }
        for &(slot, dx, dy) in &code.rows {
            let row = job.rows[slot][(dy + MAX_REACH as isize) as usize];
            // SAFETY: rows are padded by at least a block of lanes on both sides (`Field`), and dx is at most MAX_REACH.
            self.places.push((unsafe { row.offset(dx) }.cast_mut(), 1));
        }
        // What an operand that an instruction does not have would be; it is never read.
        self.places.push((memory, 0));
    }
}

/// An operand: where its first cells lie.
#[derive(Clone, Copy)]
struct Source(*const f32);

impl Source {
    #[inline(always)]
    fn load<L: LaneBlock>(self, i: usize) -> L {
        // SAFETY: `source` made it of a place that holds as many blocks of lanes as are asked for.
        L::from_array(unsafe { self.0.add(i * WIDTH).cast::<[f32; WIDTH]>().read_unaligned() })
    }
}

/// Where a result goes, and how many blocks of lanes it has.
#[derive(Clone, Copy)]
struct Target {
    first: *mut f32,
    lanes: usize,
}

impl Target {
    #[inline(always)]
    fn store<L: LaneBlock>(self, i: usize, v: L) {
        // SAFETY: as for `Source::load`; nobody else uses a register or the row of the written layer.
        unsafe { self.first.add(i * WIDTH).cast::<[f32; WIDTH]>().write_unaligned(v.to_array()) };
    }
}

/// A function of one, two, three or four numbers, as a type: closures would not be compiled for the instruction set.
trait Function {
    fn of<R: Real>(v: [R; 4]) -> R;
}

macro_rules! functions {
    ($($name:ident($a:ident $(, $b:ident $(, $c:ident, $d:ident)?)?) $e:expr;)*) => {$(
        struct $name;
        impl Function for $name {
            #[inline(always)]
            fn of<R: Real>([$a, _b, _c, _d]: [R; 4]) -> R {
                $(let $b = _b; $(let ($c, $d) = (_c, _d);)?)?
                $e
            }
        }
    )*};
}
functions! {
    Add(a, b) a + b;
    Sub(a, b) a - b;
    Mul(a, b) a * b;
    Min(a, b) a.min(b);
    Max(a, b) a.max(b);
    Div(a, b) a / b;
    Neg(a) -a;
    Sqrt(a) a.sqrt();
    Abs(a) a.abs();
    Floor(a) a.floor();
    Flush(a) a.flushed();
    Select(a, b, c, d) R::select_lt(a, b, c, d);
    ToReal(a) real_of(a.to_bits());
    Whole(a) R::from_bits(a.to_int_bits());
    BitsAdd(a, b) R::from_bits(a.to_bits().add(b.to_bits()));
    BitsMul(a, b) R::from_bits(a.to_bits().mul(b.to_bits()));
    BitsXor(a, b) R::from_bits(a.to_bits().xor(b.to_bits()));
    BitsAnd(a, b) R::from_bits(a.to_bits().and(b.to_bits()));
    BitsOr(a, b) R::from_bits(a.to_bits().or(b.to_bits()));
}

#[inline(always)]
fn real_of<B: Bits>(bits: B) -> B::Real {
    bits.to_real()
}

/// `Q(P(a, b), c)`.
struct Left<P, Q>(std::marker::PhantomData<(P, Q)>);
/// `Q(c, P(a, b))`.
struct Right<P, Q>(std::marker::PhantomData<(P, Q)>);

/// `S(P(a, b), Q(c, d))`.
struct Tree<P, Q, S>(std::marker::PhantomData<(P, Q, S)>);

impl<P: Function, Q: Function, S: Function> Function for Tree<P, Q, S> {
    #[inline(always)]
    fn of<R: Real>([a, b, c, d]: [R; 4]) -> R {
        S::of([P::of([a, b, c, d]), Q::of([c, d, c, d]), c, d])
    }
}

impl<P: Function, Q: Function> Function for Left<P, Q> {
    #[inline(always)]
    fn of<R: Real>([a, b, c, d]: [R; 4]) -> R {
        Q::of([P::of([a, b, c, d]), c, c, d])
    }
}

impl<P: Function, Q: Function> Function for Right<P, Q> {
    #[inline(always)]
    fn of<R: Real>([a, b, c, d]: [R; 4]) -> R {
        Q::of([c, P::of([a, b, c, d]), c, d])
    }
}

struct Blocks<'a> {
    code: &'a Code,
    scratch: &'a mut Scratch,
    job: &'a mut RowJob,
}

impl LaneTask for Blocks<'_> {
    type Out = ();
    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let (code, width) = (self.code, self.job.width);
        let (first, end) = (self.job.counted.start, self.job.counted.end as isize);
        let places = &self.scratch.places;
        let mut sums = [L::of(0.0); MAX_TALLIES];
        let mut x = 0;
        while x < width {
            let lanes = (width - x).min(code.block).div_ceil(WIDTH);
            let last = code.instructions.len().wrapping_sub(1);
            for (i, instruction) in code.instructions.iter().enumerate() {
                let mut first = places[instruction.to as usize].0;
                if code.direct && i == last {
                    // SAFETY: as in `kernel::lanes_body`. Nothing of these cells is read after this instruction.
                    first = unsafe { self.job.out[0].add(x) };
                }
                let from = [
                    source(places, instruction.from[0], x),
                    source(places, instruction.from[1], x),
                    source(places, instruction.from[2], x),
                    source(places, instruction.from[3], x),
                ];
                carry_out::<L>(instruction, Target { first, lanes }, from, self.job, x);
            }
            if !code.direct {
                for (i, &place) in code.outputs.iter().enumerate() {
                    let from = source(places, place, x);
                    // SAFETY: as above.
                    let to = Target { first: unsafe { self.job.out[i].add(x) }, lanes };
                    for l in 0..lanes {
                        to.store(l, from.load::<L>(l));
                    }
                }
            }
            for (sum, &place) in sums.iter_mut().zip(&code.sums) {
                let from = source(places, place, x);
                for l in 0..lanes {
                    // Lanes beyond the last column hold nothing of this world.
                    let live = L::of((end - (x + l * WIDTH) as isize) as f32);
                    *sum = *sum + L::index().lt(live).pick(from.load::<L>(l), L::of(0.0));
                    if x + l * WIDTH < first {
                        forget(std::slice::from_mut(sum), first - x - l * WIDTH);
                    }
                }
            }
            x += code.block;
        }
        for (total, sum) in self.job.sums.iter_mut().zip(&sums).take(code.sums.len()) {
            *total += sum.to_array().iter().map(|&v| f64::from(v)).sum::<f64>();
        }
    }
}

#[inline(always)]
fn source(places: &[(*mut f32, usize)], place: u16, x: usize) -> Source {
    let (first, moves) = places[place as usize];
    // SAFETY: rows have a column x; what is no row does not move.
    Source(unsafe { first.add(moves * x) })
}

#[inline(always)]
fn carry_out<L: LaneBlock>(instruction: &Instruction, to: Target, from: [Source; 4], job: &RowJob, x: usize) {
    match instruction.action {
        Action::Pair(Pair::Add) => two::<L, Add>(to, from),
        Action::Pair(Pair::Sub) => two::<L, Sub>(to, from),
        Action::Pair(Pair::Mul) => two::<L, Mul>(to, from),
        Action::Pair(Pair::Min) => two::<L, Min>(to, from),
        Action::Pair(Pair::Max) => two::<L, Max>(to, from),
        Action::Left(Pair::Add, second) => left::<L, Add>(second, to, from),
        Action::Left(Pair::Sub, second) => left::<L, Sub>(second, to, from),
        Action::Left(Pair::Mul, second) => left::<L, Mul>(second, to, from),
        Action::Left(Pair::Min, second) => left::<L, Min>(second, to, from),
        Action::Left(Pair::Max, second) => left::<L, Max>(second, to, from),
        Action::Right(Pair::Add, second) => right::<L, Add>(second, to, from),
        Action::Right(Pair::Sub, second) => right::<L, Sub>(second, to, from),
        Action::Right(Pair::Mul, second) => right::<L, Mul>(second, to, from),
        Action::Right(Pair::Min, second) => right::<L, Min>(second, to, from),
        Action::Right(Pair::Max, second) => right::<L, Max>(second, to, from),
        Action::Fixed(Pair::Add, second) => fixed::<L, Add>(second, to, from),
        Action::Fixed(Pair::Sub, second) => fixed::<L, Sub>(second, to, from),
        Action::Fixed(Pair::Mul, second) => fixed::<L, Mul>(second, to, from),
        Action::Fixed(Pair::Min, second) => fixed::<L, Min>(second, to, from),
        Action::Fixed(Pair::Max, second) => fixed::<L, Max>(second, to, from),
        Action::Tree(Pair::Add, second, last) => tree::<L, Add>(second, last, to, from),
        Action::Tree(Pair::Sub, second, last) => tree::<L, Sub>(second, last, to, from),
        Action::Tree(_, second, last) => tree::<L, Mul>(second, last, to, from),
        Action::Div => two::<L, Div>(to, from),
        Action::Neg => one::<L, Neg>(to, from),
        Action::Sqrt => one::<L, Sqrt>(to, from),
        Action::Abs => one::<L, Abs>(to, from),
        Action::Floor => one::<L, Floor>(to, from),
        Action::Flush => one::<L, Flush>(to, from),
        Action::Select => four::<L, Select>(to, from),
        Action::ToReal => one::<L, ToReal>(to, from),
        Action::Whole => one::<L, Whole>(to, from),
        Action::BitsAdd => two::<L, BitsAdd>(to, from),
        Action::BitsMul => two::<L, BitsMul>(to, from),
        Action::BitsXor => two::<L, BitsXor>(to, from),
        Action::BitsAnd => two::<L, BitsAnd>(to, from),
        Action::BitsOr => two::<L, BitsOr>(to, from),
        Action::Shl(n) => {
            for i in 0..to.lanes {
                to.store(i, L::from_bits(from[0].load::<L>(i).to_bits().shl(n)));
            }
        }
        Action::Shr(n) => {
            for i in 0..to.lanes {
                to.store(i, L::from_bits(from[0].load::<L>(i).to_bits().shr(n)));
            }
        }
        Action::Column => {
            for i in 0..to.lanes {
                to.store(i, job.place.columns::<L>(x + i * WIDTH));
            }
        }
        Action::Uniform(stream) => uniform::<L>(stream, to, job, x),
    }
}

#[inline(always)]
fn left<L: LaneBlock, P: Function>(second: Pair, to: Target, from: [Source; 4]) {
    match second {
        Pair::Add => three::<L, Left<P, Add>>(to, from),
        Pair::Sub => three::<L, Left<P, Sub>>(to, from),
        Pair::Mul => three::<L, Left<P, Mul>>(to, from),
        Pair::Min => three::<L, Left<P, Min>>(to, from),
        Pair::Max => three::<L, Left<P, Max>>(to, from),
    }
}

#[inline(always)]
fn right<L: LaneBlock, P: Function>(second: Pair, to: Target, from: [Source; 4]) {
    match second {
        Pair::Add => three::<L, Right<P, Add>>(to, from),
        Pair::Sub => three::<L, Right<P, Sub>>(to, from),
        Pair::Mul => three::<L, Right<P, Mul>>(to, from),
        Pair::Min => three::<L, Right<P, Min>>(to, from),
        Pair::Max => three::<L, Right<P, Max>>(to, from),
    }
}

#[inline(always)]
fn fixed<L: LaneBlock, P: Function>(second: Pair, to: Target, from: [Source; 4]) {
    match second {
        Pair::Add => line::<L, Left<P, Add>>(to, from),
        Pair::Sub => line::<L, Left<P, Sub>>(to, from),
        Pair::Mul => line::<L, Left<P, Mul>>(to, from),
        Pair::Min => line::<L, Left<P, Min>>(to, from),
        Pair::Max => line::<L, Left<P, Max>>(to, from),
    }
}

#[inline(always)]
fn tree<L: LaneBlock, P: Function>(second: Pair, last: Pair, to: Target, from: [Source; 4]) {
    match second {
        Pair::Add => branches::<L, P, Add>(last, to, from),
        Pair::Sub => branches::<L, P, Sub>(last, to, from),
        _ => branches::<L, P, Mul>(last, to, from),
    }
}

#[inline(always)]
fn branches<L: LaneBlock, P: Function, Q: Function>(last: Pair, to: Target, from: [Source; 4]) {
    match last {
        Pair::Add => four::<L, Tree<P, Q, Add>>(to, from),
        Pair::Sub => four::<L, Tree<P, Q, Sub>>(to, from),
        _ => four::<L, Tree<P, Q, Mul>>(to, from),
    }
}

#[inline(always)]
fn line<L: LaneBlock, F: Function>(to: Target, [a, b, c, _]: [Source; 4]) {
    let (b, c) = (b.load::<L>(0), c.load::<L>(0));
    for i in 0..to.lanes {
        let a = a.load::<L>(i);
        to.store(i, F::of([a, b, c, a]));
    }
}

#[inline(always)]
fn one<L: LaneBlock, F: Function>(to: Target, [a, ..]: [Source; 4]) {
    for i in 0..to.lanes {
        let a = a.load::<L>(i);
        to.store(i, F::of([a; 4]));
    }
}

#[inline(always)]
fn two<L: LaneBlock, F: Function>(to: Target, [a, b, ..]: [Source; 4]) {
    for i in 0..to.lanes {
        let (a, b) = (a.load::<L>(i), b.load::<L>(i));
        to.store(i, F::of([a, b, a, a]));
    }
}

#[inline(always)]
fn three<L: LaneBlock, F: Function>(to: Target, [a, b, c, _]: [Source; 4]) {
    for i in 0..to.lanes {
        let (a, b, c) = (a.load::<L>(i), b.load::<L>(i), c.load::<L>(i));
        to.store(i, F::of([a, b, c, a]));
    }
}

#[inline(always)]
fn four<L: LaneBlock, F: Function>(to: Target, [a, b, c, d]: [Source; 4]) {
    for i in 0..to.lanes {
        let (a, b, c, d) = (a.load::<L>(i), b.load::<L>(i), c.load::<L>(i), d.load::<L>(i));
        to.store(i, F::of([a, b, c, d]));
    }
}

/// Random numbers of the cells from column `x` on.
#[inline(always)]
fn uniform<L: LaneBlock>(stream: u32, to: Target, job: &RowJob, x: usize) {
    let key = Key::new(job.seed, stream, job.step);
    for i in 0..to.lanes {
        let first = job.place.first_number(x + i * WIDTH);
        let mut cells = [0; WIDTH];
        let mut l = 0;
        while l < WIDTH {
            cells[l] = first.wrapping_add(l as u32);
            l += 1;
        }
        to.store(i, rng::unit::<L>(rng::hash(key, L::bits_from_array(cells))));
    }
}
