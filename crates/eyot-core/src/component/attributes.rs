//! Named columns of equal length: what tables, points and graphs are made of.

use super::{Decoder, Encoder};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;

/// Columns of a table at most.
const MAX_COLUMNS: usize = 1 << 14;
/// Bytes of a name or a unit at most.
const MAX_TEXT: usize = 256;
/// Whole numbers beyond this are no exact 64-bit floating-point numbers.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Type {
    /// Bytes.
    U8,
    /// Whole numbers of 32 bits.
    U32,
    /// Whole numbers of 64 bits; rows of numbers hold them exactly up to 2^53.
    U64,
    /// Single precision; NaN where nothing is known.
    F32,
    /// Double precision; NaN where nothing is known.
    F64,
}

impl Type {
    const ALL: [Self; 5] = [Self::U8, Self::U32, Self::U64, Self::F32, Self::F64];

    /// Bytes of a value.
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
        }
    }

    /// True for whole numbers.
    pub const fn is_whole(self) -> bool {
        matches!(self, Self::U8 | Self::U32 | Self::U64)
    }

    /// True if `value` is one.
    fn holds(self, value: f64) -> bool {
        let most = match self {
            Self::U8 => f64::from(u8::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::U64 => MAX_EXACT,
            Self::F32 | Self::F64 => return true,
        };
        (0.0..=most).contains(&value) && value.fract() == 0.0 && value.is_sign_positive()
    }
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Bytes.
    U8(Vec<u8>),
    /// Whole numbers of 32 bits.
    U32(Vec<u32>),
    /// Whole numbers of 64 bits.
    U64(Vec<u64>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

/// The same for the values of every type.
macro_rules! each {
    ($values:expr, $v:ident => $do:expr) => {
        match $values {
            Values::U8($v) => $do,
            Values::U32($v) => $do,
            Values::U64($v) => $do,
            Values::F32($v) => $do,
            Values::F64($v) => $do,
        }
    };
}

impl Values {
    /// None yet.
    pub fn new(of: Type) -> Self {
        match of {
            Type::U8 => Self::U8(Vec::new()),
            Type::U32 => Self::U32(Vec::new()),
            Type::U64 => Self::U64(Vec::new()),
            Type::F32 => Self::F32(Vec::new()),
            Type::F64 => Self::F64(Vec::new()),
        }
    }

    /// What they are.
    pub const fn of(&self) -> Type {
        match self {
            Self::U8(_) => Type::U8,
            Self::U32(_) => Type::U32,
            Self::U64(_) => Type::U64,
            Self::F32(_) => Type::F32,
            Self::F64(_) => Type::F64,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        each!(self, v => v.len())
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value `i` as a number.
    pub fn number(&self, i: usize) -> f64 {
        match self {
            Self::U8(v) => f64::from(v[i]),
            Self::U32(v) => f64::from(v[i]),
            Self::U64(v) => v[i] as f64,
            Self::F32(v) => f64::from(v[i]),
            Self::F64(v) => v[i],
        }
    }

    /// Adds a number that [`Type::holds`] has found to be of this type.
    fn push(&mut self, value: f64) {
        match self {
            Self::U8(v) => v.push(value as u8),
            Self::U32(v) => v.push(value as u32),
            Self::U64(v) => v.push(value as u64),
            Self::F32(v) => v.push(value as f32),
            Self::F64(v) => v.push(value),
        }
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        match self {
            Self::U8(v) => out.bytes(v),
            Self::U32(v) => out.u32s(v),
            Self::U64(v) => out.u64s(v),
            Self::F32(v) => out.f32s(v),
            Self::F64(v) => out.f64s(v),
        }
    }

    fn decode(of: Type, n: usize, from: &mut Decoder<'_>) -> Result<Self> {
        Ok(match of {
            Type::U8 => Self::U8(from.u8s(n)?),
            Type::U32 => Self::U32(from.u32s(n)?),
            Type::U64 => Self::U64(from.u64s(n)?),
            Type::F32 => Self::F32(from.f32s(n)?),
            Type::F64 => Self::F64(from.f64s(n)?),
        })
    }
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Its name, once among its columns.
    pub name: String,
    /// Unit of its numbers; `1` for counts and shares.
    pub unit: String,
    /// Its values.
    pub values: Values,
}

/// Columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    columns: Vec<Attribute>,
    len: usize,
}

impl Attributes {
    /// Columns from names, units and types, without rows.
    pub fn new<'a>(columns: impl IntoIterator<Item = (&'a str, &'a str, Type)>) -> Self {
        let column = |(name, unit, of): (&str, &str, Type)| Attribute {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: Values::new(of),
        };
        Self { columns: columns.into_iter().map(column).collect(), len: 0 }
    }

    /// Columns that are there.
    ///
    /// # Errors
    /// If they are not all of `len` values, or two of them have the same name.
    pub fn of(columns: Vec<Attribute>, len: usize) -> Result<Self> {
        for (i, c) in columns.iter().enumerate() {
            if c.values.len() != len {
                return Err(Error::Shape {
                    what: format!("column `{}`", c.name),
                    expected: len,
                    found: c.values.len(),
                });
            }
            if columns[..i].iter().any(|other| other.name == c.name) {
                return Err(Error::Component { name: c.name.clone(), reason: "two columns have this name".into() });
            }
        }
        Ok(Self { columns, len })
    }

    /// Rows.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True if there are no rows.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// From left to right.
    pub fn columns(&self) -> &[Attribute] {
        &self.columns
    }

    /// The column of that name.
    pub fn get(&self, name: &str) -> Option<&Attribute> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// Row `i` as numbers.
    pub fn row(&self, i: usize) -> impl Iterator<Item = f64> + '_ {
        self.columns.iter().map(move |c| c.values.number(i))
    }

    /// Adds a row, whole or not at all.
    ///
    /// # Errors
    /// If it has not one number for each column, or a number is not of its column's type.
    pub fn push(&mut self, row: &[f64]) -> Result<()> {
        if row.len() != self.columns.len() {
            return Err(Error::Shape { what: "a row".into(), expected: self.columns.len(), found: row.len() });
        }
        if let Some((c, v)) = self.columns.iter().zip(row).find(|(c, v)| !c.values.of().holds(**v)) {
            let reason = format!("{v} is no value of the type {:?}", c.values.of());
            return Err(Error::Component { name: c.name.clone(), reason });
        }
        self.columns.iter_mut().zip(row).for_each(|(c, v)| c.values.push(*v));
        self.len += 1;
        Ok(())
    }

    /// Keeps the rows for whose number `keep` holds, in their order.
    pub fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        for c in &mut self.columns {
            each!(&mut c.values, v => {
                let mut i = 0;
                v.retain(|_| {
                    i += 1;
                    keep(i - 1)
                });
            });
        }
        self.len = (0..self.len).filter(|&i| keep(i)).count();
    }

    pub(super) fn encode(&self, out: &mut Encoder<'_>) {
        out.u32(self.columns.len() as u32);
        for c in &self.columns {
            out.text(&c.name);
            out.text(&c.unit);
            out.u8(Type::ALL.iter().position(|t| *t == c.values.of()).unwrap_or_default() as u8);
        }
        self.columns.iter().for_each(|c| c.values.encode(out));
    }

    /// Columns of `len` values.
    pub(super) fn decode(len: usize, from: &mut Decoder<'_>) -> Result<Self> {
        let n = from.u32()? as usize;
        if n > MAX_COLUMNS {
            return Err(from.wrong(format!("{n} columns, at most {MAX_COLUMNS} can be")));
        }
        let mut heads = Vec::new();
        for _ in 0..n {
            let (name, unit, of) = (from.text(MAX_TEXT)?, from.text(MAX_TEXT)?, from.u8()?);
            let Some(of) = Type::ALL.get(usize::from(of)) else {
                return Err(from.wrong(format!("column `{name}` is of the type {of}")));
            };
            heads.push((name, unit, *of));
        }
        let mut columns = Vec::new();
        for (name, unit, of) in heads {
            columns.push(Attribute { name, unit, values: Values::decode(of, len, from)? });
        }
        Self::of(columns, len).map_err(|e| from.wrong(e.to_string()))
    }

    /// Names and values, column by column.
    pub(super) fn fingerprint(&self, print: &mut Fingerprint) {
        for c in &self.columns {
            print.begin(&c.name);
            (0..self.len).for_each(|i| match &c.values {
                Values::U64(v) => print.word(v[i]),
                other => print.number(other.number(i)),
            });
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let column = |c: &Attribute| c.name.len() + c.unit.len() + self.len * c.values.of().bytes();
        self.columns.iter().map(column).sum()
    }
}
