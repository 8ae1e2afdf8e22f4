//! Rules: what one cell does in one pass, written once.
//!
//! A rule is a type with a generic function [`Rule::cell`]. It reads layers around its cell through a [`Cell`] view and
//! returns the new values of that cell. It writes only itself, allocates nothing, cannot fail and has no branches on
//! values (`a.lt(b).pick(x, y)` instead), so that the same source runs in lanes, on scalars and on a GPU.

use crate::real::Real;

/// Position of a layer in a rule's list of reads.
pub type Slot = usize;

/// A layer that a rule reads, and how far from its own cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Read {
    /// Name of the layer.
    pub layer: &'static str,
    /// Largest |dx| or |dy|, at most [`MAX_REACH`].
    pub reach: usize,
}

/// Shorthand for [`Read`].
pub const fn read(layer: &'static str, reach: usize) -> Read {
    Read { layer, reach }
}

/// Largest reach of a rule, in cells.
pub const MAX_REACH: usize = 2;
/// Most layers that a rule may read.
pub const MAX_READS: usize = 10;
/// Most layers that a rule may write.
pub const MAX_WRITES: usize = 8;
/// Most sums that a rule may keep.
pub const MAX_TALLIES: usize = 16;

/// A sum over cells and steps that a rule keeps for the ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally {
    /// Account in the ledger.
    pub account: &'static str,
    /// What is summed.
    pub unit: TallyUnit,
    /// +1 if it adds to the material, -1 if it takes away, 0 if it only reports.
    pub sign: i8,
    /// One sentence: what is counted.
    pub meaning: &'static str,
}

/// What a tally adds up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TallyUnit {
    /// Thickness in m; the ledger multiplies by the cell's area and shows m3.
    Thickness,
    /// Events.
    Count,
}

/// A side of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Column -1.
    West,
    /// Column `width`.
    East,
    /// Row -1.
    North,
    /// Row `height`.
    South,
}

impl Side {
    /// All four.
    pub const ALL: [Self; 4] = [Self::West, Self::East, Self::North, Self::South];
}

/// What a rule sees.
pub trait Cell<R: Real> {
    /// Value of the layer in `slot`, `dx` columns east and `dy` rows south of this cell.
    fn at(&self, slot: Slot, dx: isize, dy: isize) -> R;
    /// Value of the layer in `slot` here.
    #[inline(always)]
    fn here(&self, slot: Slot) -> R {
        self.at(slot, 0, 0)
    }
    /// Column.
    fn x(&self) -> R;
    /// Row.
    fn y(&self) -> R;
    /// A random number in [0, 1), keyed by seed, stream, cell and step.
    fn uniform(&self, stream: u32) -> R;
}

/// Parameters of a rule by name, for every kind of number.
///
/// Implemented by [`rule_params!`](crate::rule_params) for the struct at `T = ()`.
pub trait ParamSet: 'static {
    /// The struct with fields of type `T`.
    type Of<T: Copy + 'static>: Copy;
    /// The fields' names in their order.
    const NAMES: &'static [&'static str];
    /// Makes the struct field by field.
    fn build<U: Copy + 'static>(f: impl FnMut(&'static str) -> U) -> Self::Of<U>;
    /// Converts field by field.
    fn map<T: Copy + 'static, U: Copy + 'static>(p: &Self::Of<T>, f: impl FnMut(&'static str, T) -> U) -> Self::Of<U>;
}

/// Declares the parameter struct of a rule: generic over the kind of number, all fields public.
#[macro_export]
macro_rules! rule_params {
    ($(#[$meta:meta])* $vis:vis struct $name:ident { $($(#[$fmeta:meta])* $field:ident),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug)]
        $vis struct $name<T> { $($(#[$fmeta])* pub $field: T),* }
        impl $crate::rule::ParamSet for $name<()> {
            type Of<T: Copy + 'static> = $name<T>;
            const NAMES: &'static [&'static str] = &[$(stringify!($field)),*];
            #[allow(unused_variables, unused_mut)]
            fn build<U: Copy + 'static>(mut f: impl FnMut(&'static str) -> U) -> $name<U> {
                $name { $($field: f(stringify!($field))),* }
            }
            #[inline(always)]
            #[allow(unused_variables, unused_mut)]
            fn map<T: Copy + 'static, U: Copy + 'static>(
                p: &$name<T>, mut f: impl FnMut(&'static str, T) -> U,
            ) -> $name<U> {
                $name { $($field: f(stringify!($field), p.$field)),* }
            }
        }
    };
}

/// What one cell does in one pass.
pub trait Rule: 'static {
    /// Name in messages, WGSL and benchmarks.
    const NAME: &'static str;
    /// Layers it reads; the position is the [`Slot`].
    const READS: &'static [Read];
    /// Layers it writes, in the order of the returned values.
    const WRITES: &'static [&'static str];
    /// Sums it keeps, in the order of the returned values.
    const TALLIES: &'static [Tally] = &[];
    /// Parameters: the struct made by [`rule_params!`](crate::rule_params) at `()`.
    type Params: ParamSet;
    /// New values: `[R; WRITES.len()]`.
    type Out<R: Real>: AsRef<[R]>;
    /// Summands: `[R; TALLIES.len()]`.
    type Sums<R: Real>: AsRef<[R]>;

    /// The rule.
    fn cell<R: Real>(p: &<Self::Params as ParamSet>::Of<R>, c: &impl Cell<R>) -> (Self::Out<R>, Self::Sums<R>);

    /// What leaves the world through `side` of this border cell when that rim is open, in addition to the sums of
    /// [`Rule::cell`]. `None` if nothing ever leaves.
    #[inline(always)]
    fn boundary_outflow<R: Real>(
        _p: &<Self::Params as ParamSet>::Of<R>,
        _c: &impl Cell<R>,
        _side: Side,
    ) -> Option<Self::Sums<R>> {
        None
    }
}
