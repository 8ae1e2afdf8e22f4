//! Typed state of a world that is no raster: tables, points, graphs, lines and polygons, strata, and whatever a process brings along.
//!
//! A [`Component`] encodes itself, has its share of the world's fingerprint and says how much memory it holds. Its
//! [`ComponentKind`] names it and decodes it again, from bytes that anybody may have written. [`Components`] are those of one world,
//! by name. Checkpoints and recordings take this one way, so that a process with a state of its own writes no file format; what others
//! are shown of it, in files, is a [`View`].
//!
//! # What every decoder keeps to
//! 1. Counts are read by [`Decoder::count`], which knows how many bytes are left: nothing is allocated for what is not there.
//! 2. Numbers that could not have come from a sound state are refused, so that those who use a component need no checks.
//! 3. A component that was encoded and decoded equals itself, and has the same fingerprint.

mod attributes;
mod code;
mod columns;
mod features;
mod graph;
mod kinds;
mod numbers;
mod points;
mod set;
mod table;

pub use attributes::{Attribute, Attributes, Type, Values};
pub use code::{Decoder, Encoder};
pub use columns::{Columns, Run};
pub use features::{Features, Form, signed_double_area};
pub use graph::Graph;
pub use kinds::{ComponentKind, ComponentKinds};
pub use numbers::Numbers;
pub use points::Points;
pub use set::Components;
pub use table::Table;

use crate::fingerprint::Fingerprint;
use std::any::Any;
use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::Arc;

/// State of a world beside its layers.
pub trait Component: Erased + Debug + Send + Sync {
    /// What it is called and how it is decoded.
    fn kind(&self) -> &'static ComponentKind;

    /// Writes everything that [`ComponentKind::decode`] needs, in the order of [`ComponentKind::version`].
    fn encode(&self, out: &mut Encoder<'_>);

    /// Adds its content to the fingerprint of its world: equal components add the same, on every machine.
    fn fingerprint(&self, print: &mut Fingerprint);

    /// Bytes of memory that it holds.
    fn bytes(&self) -> usize;

    /// What exports and streams can show of it, by name; the name of what it is as a whole is empty.
    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[]
    }

    /// One of its [`Component::views`].
    fn view(&self, name: &str) -> Option<View<'_>> {
        let _ = name;
        None
    }
}

/// What a [`View`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shape {
    /// Rows of named columns.
    Table,
    /// Places with attributes.
    Points,
    /// Places and the lines between them.
    Lines,
    /// Lines or polygons with attributes.
    Features,
}

/// A component, or a part of it, as those see it who do not know its type. Points of a component that does not know the ground have
/// the height 0: they stand on it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum View<'a> {
    /// Rows of named columns.
    Table(Cow<'a, Table>),
    /// Places with attributes.
    Points(Cow<'a, Points>),
    /// Places and the lines between them.
    Lines(Cow<'a, Graph>),
    /// Lines or polygons with attributes.
    Features(Cow<'a, Features>),
}

/// What [`Components`] do with a component whose type they do not know. Every component that can be cloned and compared has it.
pub trait Erased: Any {
    /// A copy.
    fn copy(&self) -> Arc<dyn Component>;
    /// True if the other one is of the same type and equal.
    fn equals(&self, other: &dyn Component) -> bool;
    /// To be downcast.
    fn as_any(&self) -> &dyn Any;
    /// To be downcast.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<T: Component + Clone + PartialEq> Erased for T {
    fn copy(&self) -> Arc<dyn Component> {
        Arc::new(self.clone())
    }

    fn equals(&self, other: &dyn Component) -> bool {
        other.as_any().downcast_ref::<T>() == Some(self)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
