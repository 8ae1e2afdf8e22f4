//! The kinds of components that a program knows.

use super::{Component, Decoder, columns, features, graph, numbers, points, table};
use crate::error::{Error, Result};
use std::sync::Arc;

/// A kind of components: what it is called in files, and how it is read.
#[derive(Debug)]
pub struct ComponentKind {
    /// Its name in files: never another one, and never that of another kind. Kinds of a process begin with a word of its own.
    pub name: &'static str,
    /// Version of the encoding that [`Component::encode`] writes, from 1 on.
    pub version: u32,
    /// Names of lists of numbers that this kind stands for in files from before there were kinds. They are read as version 1.
    pub formerly: &'static [&'static str],
    /// Reads what [`Component::encode`] wrote in a version up to [`ComponentKind::version`]; what is left over is found by the caller.
    pub decode: fn(version: u32, from: &mut Decoder<'_>) -> Result<Arc<dyn Component>>,
}

/// Those of this crate.
const CORE: [&ComponentKind; 6] =
    [&numbers::KIND, &table::KIND, &points::KIND, &graph::KIND, &features::KIND, &columns::KIND];

/// All kinds that a program can read.
///
/// A component of another kind is refused by name, and is not carried along as bytes: without its type nobody can say its share of
/// the fingerprint, and a process that does not find its state would begin anew without a word.
#[derive(Clone, Debug)]
pub struct ComponentKinds(Vec<&'static ComponentKind>);

impl Default for ComponentKinds {
    fn default() -> Self {
        Self::core()
    }
}

impl ComponentKinds {
    /// Tables, points, graphs, features, columns and lists of numbers.
    pub fn core() -> Self {
        Self(CORE.to_vec())
    }

    /// These and more; a kind of the same name replaces the former one.
    #[must_use]
    pub fn with(mut self, kinds: impl IntoIterator<Item = &'static ComponentKind>) -> Self {
        for kind in kinds {
            self.0.retain(|k| k.name != kind.name);
            self.0.push(kind);
        }
        self
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &'static ComponentKind> + '_ {
        self.0.iter().copied()
    }

    /// The kind that a list of numbers of this name stood for, before there were kinds.
    pub fn of_former(&self, name: &str) -> &'static ComponentKind {
        self.iter().find(|k| k.formerly.contains(&name)).unwrap_or(&numbers::KIND)
    }

    /// Decodes all bytes of a component.
    ///
    /// # Errors
    /// If no such kind is known, its encoding is of a later version, or the bytes are not those of such a component.
    pub fn decode(&self, kind: &str, version: u32, from: &mut Decoder<'_>) -> Result<Arc<dyn Component>> {
        let Some(known) = self.iter().find(|k| k.name == kind) else {
            return Err(from.wrong(format!("it is a `{kind}`, which this program does not know")));
        };
        if !(1..=known.version).contains(&version) {
            let reason = format!("a `{kind}` of version {version}, this program reads 1 to {}", known.version);
            return Err(from.wrong(reason));
        }
        let component = (known.decode)(version, from)?;
        from.finish()?;
        Ok(component)
    }
}

/// The error of a component that is of another type than asked for.
pub(super) fn other_kind(name: &str, component: &dyn Component) -> Error {
    let reason = format!("it is a `{}`, and not what this process keeps", component.kind().name);
    Error::Component { name: name.to_owned(), reason }
}
