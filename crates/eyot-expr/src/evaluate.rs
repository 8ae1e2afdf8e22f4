//! Computes checked formulas in any kind of number.

use crate::functions::{Around, Kind as Does};
use crate::syntax::Binary;
use crate::typecheck::{Form, Formula};
use eyot_core::real::Real;
use eyot_core::rule::Cell;
use std::cell::RefCell;
use std::collections::HashMap;

/// Something that holds or does not, cell by cell.
#[derive(Clone, Debug)]
pub(crate) enum Condition<R> {
    Always(bool),
    Less(R, R),
    Not(Box<Self>),
    Both(Box<[Self; 2]>),
    Either(Box<[Self; 2]>),
}

impl<R: Real> Condition<R> {
    /// `x` where it holds, else `y`.
    pub(crate) fn pick(&self, x: R, y: R) -> R {
        match self {
            Self::Always(holds) => {
                if *holds {
                    x
                } else {
                    y
                }
            }
            Self::Less(a, b) => R::select_lt(*a, *b, x, y),
            Self::Not(inner) => inner.pick(y, x),
            Self::Both(sides) => sides[0].pick(sides[1].pick(x, y), y),
            Self::Either(sides) => sides[0].pick(x, sides[1].pick(x, y)),
        }
    }
}

/// A formula on one cell.
pub(crate) struct Evaluation<'a, R, C> {
    formula: &'a Formula,
    params: &'a [R],
    cell: &'a C,
    /// Named parts, by number and by how far away they are seen; conditions as 1 or 0, so that they are computed but once.
    parts: RefCell<HashMap<(usize, isize, isize), R>>,
}

type Place = (isize, isize);

impl<'a, R: Real, C: Cell<R>> Evaluation<'a, R, C> {
    pub(crate) fn new(formula: &'a Formula, params: &'a [R], cell: &'a C) -> Self {
        Self { formula, params, cell, parts: RefCell::default() }
    }

    /// The value of a formula that gives a number.
    pub(crate) fn number(&self) -> R {
        self.real(&self.formula.value, (0, 0))
    }

    /// The value of a formula that gives a condition.
    pub(crate) fn condition(&self) -> Condition<R> {
        self.holds(&self.formula.value, (0, 0))
    }

    fn part(&self, number: usize, at: Place) -> R {
        let key = (number, at.0, at.1);
        if let Some(value) = self.parts.borrow().get(&key) {
            return *value;
        }
        let value = self.real(&self.formula.parts[number], at);
        self.parts.borrow_mut().insert(key, value);
        value
    }

    fn real(&self, form: &Form, at: Place) -> R {
        let whole = |n: isize| R::of(n as f32);
        match form {
            Form::Number(n) => R::of(*n),
            Form::Param(i) => self.params[*i],
            Form::Column if at.0 == 0 => self.cell.x(),
            Form::Column => self.cell.x() + whole(at.0),
            Form::Row if at.1 == 0 => self.cell.y(),
            Form::Row => self.cell.y() + whole(at.1),
            Form::Read(slot, dx, dy) => self.cell.at(*slot, at.0 + dx, at.1 + dy),
            Form::Random(stream) => self.cell.uniform(*stream),
            Form::Part(number, dx, dy) => self.part(*number, (at.0 + dx, at.1 + dy)),
            Form::Negative(a) => -self.real(a, at),
            Form::Arithmetic(op, sides) => {
                let (a, b) = (self.real(&sides[0], at), self.real(&sides[1], at));
                match op {
                    Binary::Add => a + b,
                    Binary::Subtract => a - b,
                    Binary::Multiply => a * b,
                    _ => a / b,
                }
            }
            Form::Whole(n, a) => power(self.real(a, at), *n),
            Form::Apply(Does::If, of) => self.holds(&of[0], at).pick(self.real(&of[1], at), self.real(&of[2], at)),
            Form::Apply(does, of) => {
                let value = |f: &Form| self.real(f, at);
                let values: Vec<R> = match does {
                    // Whichever stands first gives way to what is no number, so those that are always numbers come first.
                    Does::Min | Does::Max => {
                        let (sure, others): (Vec<&Form>, Vec<&Form>) =
                            of.iter().partition(|f| matches!(f, Form::Number(_) | Form::Param(_)));
                        sure.into_iter().chain(others).map(value).collect()
                    }
                    _ => of.iter().map(value).collect(),
                };
                apply(*does, &values)
            }
            Form::Around(kind, params, a) => self.around(*kind, params.map(|i| self.params.get(i).copied()), a, at),
            Form::Truth(_) | Form::Compare(..) | Form::Not(_) | Form::Both(_) | Form::Either(_) => {
                self.holds(form, at).pick(R::of(1.0), R::of(0.0))
            }
        }
    }

    fn holds(&self, form: &Form, at: Place) -> Condition<R> {
        let both = |sides: &[Form; 2]| Box::new([self.holds(&sides[0], at), self.holds(&sides[1], at)]);
        match form {
            Form::Truth(t) => Condition::Always(*t),
            Form::Not(a) => Condition::Not(Box::new(self.holds(a, at))),
            Form::Both(sides) => Condition::Both(both(sides)),
            Form::Either(sides) => Condition::Either(both(sides)),
            Form::Compare(op, sides) => {
                let (a, b) = (self.real(&sides[0], at), self.real(&sides[1], at));
                let less = |a, b| Condition::Less(a, b);
                let not = |c| Condition::Not(Box::new(c));
                match op {
                    Binary::Less => less(a, b),
                    Binary::Greater => less(b, a),
                    Binary::AtMost => not(less(b, a)),
                    Binary::AtLeast => not(less(a, b)),
                    Binary::Equal => not(Condition::Either(Box::new([less(a, b), less(b, a)]))),
                    _ => Condition::Either(Box::new([less(a, b), less(b, a)])),
                }
            }
            // A named condition.
            other => Condition::Less(R::of(0.0), self.real(other, at)),
        }
    }

    /// Opposite neighbours come first, so that mirrored worlds stay mirrored to the bit.
    fn around(&self, kind: Around, params: [Option<R>; 2], form: &Form, (x, y): Place) -> R {
        let at = |dx, dy| self.real(form, (x + dx, y + dy));
        let along = |join: fn(R, R) -> R| join(join(at(1, 0), at(-1, 0)), join(at(0, 1), at(0, -1)));
        let across = |join: fn(R, R) -> R| join(join(at(1, 1), at(-1, -1)), join(at(-1, 1), at(1, -1)));
        let add: fn(R, R) -> R = |a, b| a + b;
        let [px, py] = params.map(|p| p.unwrap_or(R::of(0.0)));
        let slopes = || [(at(1, 0) - at(-1, 0)) * px, (at(0, 1) - at(0, -1)) * py];
        match kind {
            Around::Sum4 => along(add),
            Around::Sum8 => along(add) + across(add),
            Around::Mean4 => along(add) * R::of(0.25),
            Around::Mean8 => (along(add) + across(add)) * R::of(0.125),
            Around::Min4 => along(R::min),
            Around::Min8 => along(R::min).min(across(R::min)),
            Around::Max4 => along(R::max),
            Around::Max8 => along(R::max).max(across(R::max)),
            Around::Laplacian => {
                let twice = at(0, 0) + at(0, 0);
                ((at(1, 0) + at(-1, 0)) - twice) * px + ((at(0, 1) + at(0, -1)) - twice) * py
            }
            Around::SlopeX => slopes()[0],
            Around::SlopeY => slopes()[1],
            Around::Slope => {
                let [a, b] = slopes();
                (a * a + b * b).sqrt()
            }
        }
    }
}

/// By squaring.
fn power<R: Real>(a: R, n: u32) -> R {
    match n {
        0 => R::of(1.0),
        1 => a,
        n if n.is_multiple_of(2) => power(a * a, n / 2),
        n => power(a * a, n / 2) * a,
    }
}

/// At least `low`, at most `high`. In this order what is no number stays so: a mistake must not turn into a plausible value.
pub(crate) fn between<R: Real>(v: R, low: R, high: R) -> R {
    high.min(low.max(v))
}

fn apply<R: Real>(does: Does, v: &[R]) -> R {
    let (zero, one, half) = (R::of(0.0), R::of(1.0), R::of(0.5));
    match does {
        Does::Abs => v[0].abs(),
        Does::Sign => v[0].gt(zero).pick(one, v[0].lt(zero).pick(-one, zero)),
        Does::Sqrt => v[0].positive().sqrt(),
        Does::Exp => v[0].exp(),
        Does::Ln => v[0].ln(),
        Does::Log2 => v[0].ln() * R::of(std::f32::consts::LOG2_E),
        Does::Log10 => v[0].ln() * R::of(std::f32::consts::LOG10_E),
        Does::Power => v[0].pow(v[1]),
        Does::Sin => v[0].sin(),
        Does::Cos => v[0].cos(),
        Does::Tan => v[0].sin() / v[0].cos(),
        Does::Floor => v[0].floor(),
        Does::Ceil => -(-v[0]).floor(),
        Does::Round => (v[0] + half).floor(),
        Does::Fract => v[0] - v[0].floor(),
        Does::Mod => v[0] - v[1] * (v[0] / v[1]).floor(),
        Does::Min => v[1..].iter().fold(v[0], |a, b| a.min(*b)),
        Does::Max => v[1..].iter().fold(v[0], |a, b| a.max(*b)),
        Does::Clamp => between(v[0], v[1], v[2]),
        Does::Mix => v[0] + (v[1] - v[0]) * v[2],
        Does::Step => v[1].lt(v[0]).pick(zero, one),
        Does::Smoothstep => eyot_core::math::smoothstep(v[0], v[1], v[2]),
        Does::Hypot => (v[0] * v[0] + v[1] * v[1]).sqrt(),
        // Evaluated where they stand.
        Does::If | Does::Random | Does::Around(_) => zero,
    }
}
