//! Words: sequences of modules, a module being a symbol with numbers.

use std::fmt;

/// A symbol: one sign, or a query (`?P`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Symbol(u32);

/// Marks queries; no character is that large.
const QUERY: u32 = 1 << 31;

impl Symbol {
    /// The symbol of a sign.
    pub const fn of(sign: char) -> Self {
        Self(sign as u32)
    }

    /// The query of this name.
    pub const fn query(name: char) -> Self {
        Self(name as u32 | QUERY)
    }

    /// Name of the query, if it is one.
    pub fn query_name(self) -> Option<char> {
        (self.0 & QUERY != 0).then(|| char::from_u32(self.0 & !QUERY)).flatten()
    }

    /// The sign, if it is no query.
    pub fn sign(self) -> Option<char> {
        char::from_u32(self.0)
    }
}

impl fmt::Display for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.query_name(), self.sign()) {
            (Some(name), _) => write!(f, "?{name}"),
            (None, Some(sign)) => write!(f, "{sign}"),
            (None, None) => Ok(()),
        }
    }
}

/// A sequence of modules.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Word {
    symbols: Vec<Symbol>,
    /// Where the numbers of each module end.
    ends: Vec<u32>,
    numbers: Vec<f64>,
}

impl Word {
    /// Bytes that a module without numbers takes.
    pub(super) const MODULE_BYTES: usize = size_of::<Symbol>() + size_of::<u32>();

    /// Modules.
    pub fn len(&self) -> usize {
        self.symbols.len()
    }

    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.symbols.is_empty()
    }

    /// Symbols of the modules.
    pub fn symbols(&self) -> &[Symbol] {
        &self.symbols
    }

    /// Numbers of module `i`.
    pub fn numbers(&self, i: usize) -> &[f64] {
        &self.numbers[self.range(i)]
    }

    pub(super) fn numbers_mut(&mut self, i: usize) -> &mut [f64] {
        let range = self.range(i);
        &mut self.numbers[range]
    }

    fn range(&self, i: usize) -> std::ops::Range<usize> {
        let from = if i == 0 { 0 } else { self.ends[i - 1] };
        from as usize..self.ends[i] as usize
    }

    /// Bytes that the modules take.
    pub fn bytes(&self) -> usize {
        self.len() * Self::MODULE_BYTES + size_of_val(self.numbers.as_slice())
    }

    /// How often a sign occurs.
    pub fn count(&self, sign: char) -> usize {
        self.symbols.iter().filter(|s| **s == Symbol::of(sign)).count()
    }

    /// Appends a module.
    pub fn push(&mut self, symbol: Symbol, numbers: impl IntoIterator<Item = f64>) {
        self.numbers.extend(numbers);
        self.symbols.push(symbol);
        self.ends.push(self.numbers.len() as u32);
    }

    pub(super) fn append(&mut self, other: &Self) {
        let base = self.numbers.len() as u32;
        self.symbols.extend_from_slice(&other.symbols);
        self.ends.extend(other.ends.iter().map(|e| e + base));
        self.numbers.extend_from_slice(&other.numbers);
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, symbol) in self.symbols.iter().enumerate() {
            write!(f, "{symbol}")?;
            if let [first, rest @ ..] = self.numbers(i) {
                write!(f, "({first}")?;
                rest.iter().try_for_each(|n| write!(f, ",{n}"))?;
                f.write_str(")")?;
            }
        }
        Ok(())
    }
}
