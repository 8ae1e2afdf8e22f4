//! A plain list of numbers.

use super::{Component, ComponentKind, Decoder, Encoder};
use crate::fingerprint::Fingerprint;
use std::sync::Arc;

/// Numbers whose meaning only their process knows, any bits. What is more than a handful deserves a kind of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers(pub Vec<f64>);

pub(super) static KIND: ComponentKind = ComponentKind {
    name: "numbers",
    version: 1,
    formerly: &[],
    decode: |_, from| Ok(Arc::new(Numbers::decode(from)?)),
};

impl Numbers {
    /// All that is left, as numbers.
    ///
    /// # Errors
    /// If those are no whole numbers of eight bytes.
    pub fn decode(from: &mut Decoder<'_>) -> crate::Result<Self> {
        if !from.left().is_multiple_of(8) {
            return Err(from.wrong(format!("{} bytes are no list of numbers", from.left())));
        }
        from.f64s((from.left() / 8) as usize).map(Self)
    }
}

impl Component for Numbers {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        out.f64s(&self.0);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        self.0.iter().for_each(|n| print.number(*n));
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}
