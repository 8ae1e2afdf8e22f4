//! From words to a tree.
//!
//! ```text
//! text       = { name "=" or ";" } or
//! or         = and { "or" and }
//! and        = not { "and" not }
//! not        = "not" not | comparison
//! comparison = sum [ ( "<" | "<=" | ">" | ">=" | "==" | "!=" ) sum ]
//! sum        = product { ( "+" | "-" ) product }
//! product    = sign { ( "*" | "/" ) sign }
//! sign       = ( "-" | "+" ) sign | power
//! power      = atom [ "^" sign ]
//! atom       = number | name | name "[" whole "," whole "]" | name "(" [ or { "," or } ] ")" | "(" or ")"
//! ```

use crate::parse_error::ParseError;
use crate::token::{Token, tokens};
use crate::{MAX_BYTES, MAX_DEPTH, MAX_ITEMS};
use std::ops::Range;

/// Two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Or,
    And,
    Less,
    AtMost,
    Greater,
    AtLeast,
    Equal,
    Unequal,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

const COMPARISONS: [(&str, Binary); 6] = [
    ("<", Binary::Less),
    ("<=", Binary::AtMost),
    (">", Binary::Greater),
    (">=", Binary::AtLeast),
    ("==", Binary::Equal),
    ("!=", Binary::Unequal),
];

/// A part of a text.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) span: Range<usize>,
    pub(crate) kind: Kind,
}

#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Number(f64),
    Truth(bool),
    Name(String, Option<(i64, i64)>),
    Call(String, Range<usize>, Vec<Tree>),
    Negative(Box<Tree>),
    Not(Box<Tree>),
    Binary(Binary, Range<usize>, Box<[Tree; 2]>),
}

/// A whole text: names for parts, and the value.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    pub(crate) names: Vec<(String, Range<usize>, Tree)>,
    pub(crate) value: Tree,
}

impl Text {
    pub(crate) fn parse(text: &str) -> Result<Self, ParseError> {
        if text.len() > MAX_BYTES {
            let message = format!("this text has {} bytes, at most {MAX_BYTES} are allowed", text.len());
            return Err(ParseError::at(&(0..text.len()), message, "too long").help("split it into several rules"));
        }
        let mut reader = Reader { tokens: tokens(text)?, next: 0, depth: 0, items: 0 };
        let mut names = Vec::new();
        while let (Token::Name(name), Token::Symbol("=")) = (reader.peek(0), reader.peek(1)) {
            let (name, span) = (name.clone(), reader.span());
            reader.next += 2;
            let value = reader.or()?;
            if !reader.take(";") {
                let help = "a named part ends with a semicolon: `name = expression;`, the value comes last";
                return Err(reader.unexpected("`;`").help(help));
            }
            names.push((name, span, value));
        }
        let value = reader.or()?;
        match reader.peek(0) {
            Token::End => Ok(Self { names, value }),
            Token::Symbol("=") => Err(reader.unexpected("an operator").help("write == to compare")),
            Token::Symbol("@") => Err(reader.unexpected("an operator").help("offsets stand in brackets: water[1, -1]")),
            _ => Err(reader.unexpected("an operator or the end")),
        }
    }
}

struct Reader {
    tokens: Vec<(Token, Range<usize>)>,
    next: usize,
    depth: usize,
    items: usize,
}

impl Reader {
    fn peek(&self, ahead: usize) -> &Token {
        self.tokens.get(self.next + ahead).map_or(&Token::End, |(t, _)| t)
    }

    fn span(&self) -> Range<usize> {
        self.tokens.get(self.next).or(self.tokens.last()).map_or(0..0, |(_, s)| s.clone())
    }

    fn take(&mut self, symbol: &str) -> bool {
        let found = matches!(self.peek(0), Token::Symbol(s) if *s == symbol);
        self.next += usize::from(found);
        found
    }

    fn word(&mut self, word: &str) -> bool {
        let found = matches!(self.peek(0), Token::Name(n) if n == word);
        self.next += usize::from(found);
        found
    }

    fn unexpected(&self, wanted: &str) -> ParseError {
        let found = match self.peek(0) {
            Token::End => {
                return ParseError::at(&self.span(), format!("the text ends where {wanted} is needed"), "here");
            }
            Token::Number(_) => "a number".to_owned(),
            Token::Name(name) => format!("`{name}`"),
            Token::Symbol(symbol) => format!("`{symbol}`"),
        };
        ParseError::at(&self.span(), format!("{found} stands where {wanted} is needed"), "not expected")
    }

    /// Counts a part of the tree, which must not become too large for those who walk it.
    fn tree(&mut self, span: Range<usize>, kind: Kind) -> Result<Tree, ParseError> {
        self.items += 1;
        if self.items > MAX_ITEMS {
            let message = format!("this text has more than {MAX_ITEMS} numbers, names and operators");
            return Err(ParseError::at(&span, message, "too many").help("split it into several rules"));
        }
        Ok(Tree { span, kind })
    }

    fn deeper(&mut self) -> Result<(), ParseError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let message = format!("parentheses, calls and signs are nested more than {MAX_DEPTH} deep");
            return Err(ParseError::at(&self.span(), message, "too deep").help("name parts: `part = ...; ...`"));
        }
        Ok(())
    }

    fn binary(&mut self, op: Binary, at: Range<usize>, a: Tree, b: Tree) -> Result<Tree, ParseError> {
        let span = a.span.start..b.span.end;
        self.tree(span, Kind::Binary(op, at, Box::new([a, b])))
    }

    fn or(&mut self) -> Result<Tree, ParseError> {
        let mut left = self.and()?;
        loop {
            let at = self.span();
            if !self.word("or") {
                return Ok(left);
            }
            let right = self.and()?;
            left = self.binary(Binary::Or, at, left, right)?;
        }
    }

    fn and(&mut self) -> Result<Tree, ParseError> {
        let mut left = self.not()?;
        loop {
            let at = self.span();
            if !self.word("and") {
                return Ok(left);
            }
            let right = self.not()?;
            left = self.binary(Binary::And, at, left, right)?;
        }
    }

    fn not(&mut self) -> Result<Tree, ParseError> {
        let start = self.span().start;
        if !self.word("not") {
            return self.comparison();
        }
        self.deeper()?;
        let inner = self.not()?;
        self.depth -= 1;
        self.tree(start..inner.span.end, Kind::Not(Box::new(inner)))
    }

    fn comparison(&mut self) -> Result<Tree, ParseError> {
        let left = self.sum()?;
        let Some((op, at)) = self.compares() else { return Ok(left) };
        let right = self.sum()?;
        let whole = self.binary(op, at, left, right)?;
        if let Some((_, second)) = self.compares() {
            let problem = ParseError::at(&second, "comparisons cannot be chained", "the second one");
            return Err(problem.help("write `a < b and b < c`"));
        }
        Ok(whole)
    }

    fn compares(&mut self) -> Option<(Binary, Range<usize>)> {
        let Token::Symbol(symbol) = self.peek(0) else { return None };
        let (_, op) = COMPARISONS.into_iter().find(|(s, _)| s == symbol)?;
        let at = self.span();
        self.next += 1;
        Some((op, at))
    }

    fn sum(&mut self) -> Result<Tree, ParseError> {
        let mut left = self.product()?;
        loop {
            let at = self.span();
            let op = if self.take("+") {
                Binary::Add
            } else if self.take("-") {
                Binary::Subtract
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            left = self.binary(op, at, left, right)?;
        }
    }

    fn product(&mut self) -> Result<Tree, ParseError> {
        let mut left = self.sign()?;
        loop {
            let at = self.span();
            let op = if self.take("*") {
                Binary::Multiply
            } else if self.take("/") {
                Binary::Divide
            } else {
                return Ok(left);
            };
            let right = self.sign()?;
            left = self.binary(op, at, left, right)?;
        }
    }

    fn sign(&mut self) -> Result<Tree, ParseError> {
        let start = self.span().start;
        let minus = self.take("-");
        if !minus && !self.take("+") {
            return self.power();
        }
        self.deeper()?;
        let inner = self.sign()?;
        self.depth -= 1;
        if !minus {
            return Ok(inner);
        }
        self.tree(start..inner.span.end, Kind::Negative(Box::new(inner)))
    }

    fn power(&mut self) -> Result<Tree, ParseError> {
        let base = self.atom()?;
        let at = self.span();
        if !self.take("^") {
            return Ok(base);
        }
        self.deeper()?;
        let exponent = self.sign()?;
        self.depth -= 1;
        self.binary(Binary::Power, at, base, exponent)
    }

    fn atom(&mut self) -> Result<Tree, ParseError> {
        let span = self.span();
        match self.peek(0).clone() {
            Token::Number(value) => {
                self.next += 1;
                self.tree(span, Kind::Number(value))
            }
            Token::Name(word) if ["and", "or", "not"].contains(&word.as_str()) => Err(self.unexpected("a value")),
            Token::Name(name) => {
                self.next += 1;
                self.after_name(name, span)
            }
            Token::Symbol("(") => {
                self.next += 1;
                self.deeper()?;
                let inner = self.or()?;
                self.depth -= 1;
                if !self.take(")") {
                    return Err(self.unexpected("`)`"));
                }
                Ok(inner)
            }
            _ => Err(self.unexpected("a value")),
        }
    }

    fn after_name(&mut self, name: String, span: Range<usize>) -> Result<Tree, ParseError> {
        if self.take("(") {
            self.deeper()?;
            let mut arguments = Vec::new();
            if !self.take(")") {
                loop {
                    arguments.push(self.or()?);
                    if self.take(")") {
                        break;
                    }
                    if !self.take(",") {
                        return Err(self.unexpected("`,` or `)`"));
                    }
                }
            }
            self.depth -= 1;
            let end = self.tokens[self.next - 1].1.end;
            return self.tree(span.start..end, Kind::Call(name, span, arguments));
        }
        if self.take("[") {
            let dx = self.whole()?;
            if !self.take(",") {
                return Err(self.unexpected("`,`").help(format!("write {name}[columns east, rows south]")));
            }
            let dy = self.whole()?;
            if !self.take("]") {
                return Err(self.unexpected("`]`"));
            }
            let end = self.tokens[self.next - 1].1.end;
            return self.tree(span.start..end, Kind::Name(name, Some((dx, dy))));
        }
        if self.take("@") {
            self.next -= 1;
            return Err(self.unexpected("an operator").help(format!("offsets stand in brackets: {name}[1, -1]")));
        }
        match name.as_str() {
            "true" => self.tree(span, Kind::Truth(true)),
            "false" => self.tree(span, Kind::Truth(false)),
            _ => self.tree(span, Kind::Name(name, None)),
        }
    }

    /// A whole number with its sign.
    fn whole(&mut self) -> Result<i64, ParseError> {
        let negative = self.take("-");
        if !negative {
            self.take("+");
        }
        match *self.peek(0) {
            Token::Number(n) if n.fract() == 0.0 && n < 1e9 => {
                self.next += 1;
                Ok(if negative { -(n as i64) } else { n as i64 })
            }
            _ => Err(self.unexpected("a whole number").help("offsets are whole numbers of cells: [east, south]")),
        }
    }
}
