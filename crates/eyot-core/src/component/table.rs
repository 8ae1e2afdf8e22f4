//! Tables: rows of numbers that a process adds as time goes on, such as a census.

use super::{Attribute, Attributes, Component, ComponentKind, Encoder, Shape, Type, View};
use crate::error::Result;
use crate::fingerprint::Fingerprint;
use std::borrow::Cow;
use std::sync::Arc;

/// Named columns, and rows that are appended. Dereferences to its [`Attributes`] to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table(Attributes);

pub(super) static KIND: ComponentKind = ComponentKind {
    name: "table",
    version: 1,
    formerly: &[],
    decode: |_, from| {
        let rows = from.u64()?;
        // Rows without columns would be free.
        let most = from.left();
        if rows > most {
            return Err(from.wrong(format!("{rows} rows do not fit in {most} bytes")));
        }
        let columns = Attributes::decode(rows as usize, from)?;
        if columns.columns().is_empty() && rows > 0 {
            return Err(from.wrong("rows without columns"));
        }
        Ok(Arc::new(Table(columns)))
    },
};

impl Table {
    /// A table of columns by name, unit and type, without rows.
    pub fn new<'a>(columns: impl IntoIterator<Item = (&'a str, &'a str, Type)>) -> Self {
        Self(Attributes::new(columns))
    }

    /// A table of columns that are there.
    ///
    /// # Errors
    /// If they are not equally long, or two of them have the same name.
    pub fn of(columns: Vec<Attribute>) -> Result<Self> {
        let len = columns.first().map_or(0, |c| c.values.len());
        Attributes::of(columns, len).map(Self)
    }

    /// Adds a row, whole or not at all.
    ///
    /// # Errors
    /// If it has not one number for each column, or a number is not of its column's type.
    pub fn push(&mut self, row: &[f64]) -> Result<()> {
        self.0.push(row)
    }
}

impl std::ops::Deref for Table {
    type Target = Attributes;

    fn deref(&self) -> &Attributes {
        &self.0
    }
}

impl Component for Table {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        out.count(self.len());
        self.0.encode(out);
    }

    /// The numbers row by row, and nothing of what columns are called: a table is fingerprinted as the list of numbers that it was in
    /// earlier versions.
    fn fingerprint(&self, print: &mut Fingerprint) {
        (0..self.len()).for_each(|i| self.row(i).for_each(|n| print.number(n)));
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("", Shape::Table)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        name.is_empty().then_some(View::Table(Cow::Borrowed(self)))
    }
}
