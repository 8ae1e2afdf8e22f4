//! Points: what stands somewhere, such as colonies and trees.

use super::{Attribute, Attributes, Component, ComponentKind, Decoder, Encoder, Shape, Type, View};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use std::borrow::Cow;
use std::sync::Arc;

/// Places with attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    positions: Vec<[f32; 3]>,
    attributes: Attributes,
}

pub(super) static KIND: ComponentKind =
    ComponentKind { name: "points", version: 1, formerly: &[], decode: |_, from| Ok(Arc::new(Points::decode(from)?)) };

impl Points {
    /// No points yet, with attributes by name, unit and type.
    pub fn new<'a>(attributes: impl IntoIterator<Item = (&'a str, &'a str, Type)>) -> Self {
        Self { positions: Vec::new(), attributes: Attributes::new(attributes) }
    }

    /// Points at `positions` (m east of the grid's west side, m south of its north side, m above the datum of the height).
    ///
    /// # Errors
    /// If a position is not finite, or an attribute has not a value for each.
    pub fn of(positions: Vec<[f32; 3]>, attributes: Vec<Attribute>) -> Result<Self> {
        if let Some(p) = positions.iter().find(|p| p.iter().any(|v| !v.is_finite())) {
            return Err(nowhere(*p));
        }
        let attributes = Attributes::of(attributes, positions.len())?;
        Ok(Self { positions, attributes })
    }

    /// Adds a point.
    ///
    /// # Errors
    /// If the position is not finite, or `row` does not fit the attributes.
    pub fn push(&mut self, position: [f32; 3], row: &[f64]) -> Result<()> {
        if position.iter().any(|v| !v.is_finite()) {
            return Err(nowhere(position));
        }
        self.attributes.push(row)?;
        self.positions.push(position);
        Ok(())
    }

    /// Keeps the points for whose number `keep` holds, in their order.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        self.attributes.retain(&keep);
        let mut i = 0;
        self.positions.retain(|_| {
            i += 1;
            keep(i - 1)
        });
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Where they are: m from the west side, m from the north side, m above the datum of the height.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// What else is known of them.
    pub const fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    pub(super) fn encode_points(&self, out: &mut Encoder<'_>) {
        out.count(self.len());
        self.positions.iter().for_each(|p| out.f32s(p));
        self.attributes.encode(out);
    }

    pub(super) fn decode(from: &mut Decoder<'_>) -> Result<Self> {
        let n = from.count(12)?;
        let positions: Vec<[f32; 3]> = from.f32s(3 * n)?.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        if positions.as_flattened().iter().any(|v| !v.is_finite()) {
            return Err(from.wrong("a position that is not finite"));
        }
        Ok(Self { positions, attributes: Attributes::decode(n, from)? })
    }

    pub(super) fn add_to(&self, print: &mut Fingerprint) {
        print.word(self.len() as u64);
        print.values(self.positions.as_flattened());
        self.attributes.fingerprint(print);
    }

    pub(super) fn held(&self) -> usize {
        size_of_val(&*self.positions) + self.attributes.bytes()
    }
}

fn nowhere(position: [f32; 3]) -> Error {
    Error::Component { name: "points".into(), reason: format!("a point at {position:?}") }
}

impl Component for Points {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        self.encode_points(out);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        self.add_to(print);
    }

    fn bytes(&self) -> usize {
        self.held()
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("", Shape::Points)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        name.is_empty().then_some(View::Points(Cow::Borrowed(self)))
    }
}
