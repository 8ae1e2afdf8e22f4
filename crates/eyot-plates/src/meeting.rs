//! Two plates on one cell: which one stays on top, and what goes under.
//!
//! Each pair of plates has a polarity, which says who overrides whom along their whole border, so that borders do not become combs
//! whose teeth go over and under in turns. It follows the plate that brings continents to the border, and changes only when the
//! other one clearly brings more. What stays on top is the thicker crust, whoever owned it: continents do not sink.

use crate::crust::is_continental;

/// A plate's crust on a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Holder {
    pub(crate) owner: u8,
    /// Thickness, units.
    pub(crate) crust: i32,
    /// Age, Myr.
    pub(crate) age: f32,
}

/// How crust ended on a cell where it could not stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Oceanic crust under whatever is on top.
    Sinks,
    /// Continental crust under continental crust.
    Collides,
    /// Crust that went over the rim of the grid, in this direction (columns, rows).
    Boundary(i8, i8),
}

/// Crust that lost its cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// The cell where it happened.
    pub(crate) cell: u32,
    pub(crate) kind: Kind,
    /// The plate that has the cell now.
    pub(crate) over: u8,
    /// The plate that does not.
    pub(crate) under: u8,
    /// Crust that went under, units.
    pub(crate) crust: i32,
    /// Its age, Myr.
    pub(crate) age: f32,
    /// Whether `over` and `under` came with continental crust.
    pub(crate) continental: (bool, bool),
}

impl Contact {
    pub(crate) fn at_rim(cell: u32, owner: u8, crust: i32, out: (i8, i8)) -> Self {
        let c = is_continental(crust);
        Self {
            cell,
            kind: Kind::Boundary(out.0, out.1),
            over: owner,
            under: owner,
            crust,
            age: 0.0,
            continental: (c, c),
        }
    }
}

/// Who overrides whom.
pub(crate) struct Polarity<'a> {
    pub(crate) plates: usize,
    /// For each pair `p * plates + q`, true if `p` overrides `q`.
    pub(crate) over: &'a [bool],
}

impl Polarity<'_> {
    /// The crust that stays, and what became of the other.
    pub(crate) fn meet(&self, cell: u32, a: Holder, b: Holder) -> (Holder, Contact) {
        let a_over = self.over[usize::from(a.owner) * self.plates + usize::from(b.owner)];
        let (over, under) = if a_over { (a, b) } else { (b, a) };
        let continental = (is_continental(over.crust), is_continental(under.crust));
        // Continents that arrive on the plate that sinks are scraped off and grow onto the other one.
        let (top, sinks) = if continental.1 && !continental.0 { (under, over) } else { (over, under) };
        let kind = if continental == (true, true) { Kind::Collides } else { Kind::Sinks };
        let contact = Contact {
            cell,
            kind,
            over: over.owner,
            under: under.owner,
            crust: sinks.crust,
            age: sinks.age,
            continental,
        };
        (Holder { owner: over.owner, ..top }, contact)
    }
}
