//! Arithmetic in grammars: numbers, names, `+ - * / ^`, comparisons, `&& || !`, and a few functions.
//!
//! Truth is 1, everything but 0 is true. Angles are in degrees.
//!
//! This is another language than that of recipes' expressions (`eyot-expr`), which has `and`, `or` and `not`, units, cells and
//! neighbours, and no chained comparisons. It stands between the signs of a word, where `+`, `-`, `/`, `&`, `^` and `!` turn the turtle,
//! so that nothing can be cut into tokens before it is known where an expression ends: it is read as far as it goes.

use super::text::Reader;
use eyot_core::math64::{cos_degrees, exp, ln, pow, sin_degrees};

/// What an expression is evaluated with.
pub(super) struct Scope<'a> {
    /// Values of the parameters.
    pub(super) values: &'a [f64],
    /// Makes the next random number in [0, 1).
    pub(super) random: &'a mut dyn FnMut() -> f64,
}

/// An expression whose names have been resolved.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    Number(f64),
    Parameter(usize),
    Unary(char, Box<Expression>),
    Binary(Operator, Box<[Expression; 2]>),
    Call(Function, Vec<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operator {
    Or,
    And,
    Equal,
    Unequal,
    LessEqual,
    GreaterEqual,
    Less,
    Greater,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Function {
    Sin,
    Cos,
    Sqrt,
    Abs,
    Floor,
    Exp,
    Ln,
    Min,
    Max,
    Mod,
    Random,
}

const FUNCTIONS: [(&str, Function, usize); 11] = [
    ("sin", Function::Sin, 1),
    ("cos", Function::Cos, 1),
    ("sqrt", Function::Sqrt, 1),
    ("abs", Function::Abs, 1),
    ("floor", Function::Floor, 1),
    ("exp", Function::Exp, 1),
    ("ln", Function::Ln, 1),
    ("min", Function::Min, 2),
    ("max", Function::Max, 2),
    ("mod", Function::Mod, 2),
    ("random", Function::Random, 2),
];

/// Operators from the loosest to the tightest; longer ones before those that they begin with.
const LEVELS: [&[(&str, Operator)]; 5] = [
    &[("||", Operator::Or)],
    &[("&&", Operator::And)],
    &[
        ("==", Operator::Equal),
        ("!=", Operator::Unequal),
        ("<=", Operator::LessEqual),
        (">=", Operator::GreaterEqual),
        ("<", Operator::Less),
        (">", Operator::Greater),
    ],
    &[("+", Operator::Add), ("-", Operator::Subtract)],
    &[("*", Operator::Multiply), ("/", Operator::Divide)],
];

/// Deepest nesting: parsing and evaluation are recursive.
const MAX_DEPTH: usize = 100;

impl Expression {
    pub(super) fn evaluate(&self, scope: &mut Scope<'_>) -> f64 {
        match self {
            Self::Number(n) => *n,
            Self::Parameter(i) => scope.values[*i],
            Self::Unary('-', e) => -e.evaluate(scope),
            Self::Unary(_, e) => truth(e.evaluate(scope) == 0.0),
            Self::Binary(op, sides) => {
                let [a, b] = [sides[0].evaluate(scope), sides[1].evaluate(scope)];
                op.apply(a, b)
            }
            Self::Call(f, arguments) => {
                let a = arguments[0].evaluate(scope);
                let b = arguments.get(1).map_or(0.0, |b| b.evaluate(scope));
                match f {
                    Function::Sin => sin_degrees(a),
                    Function::Cos => cos_degrees(a),
                    Function::Sqrt => a.max(0.0).sqrt(),
                    Function::Abs => a.abs(),
                    Function::Floor => a.floor(),
                    Function::Exp => exp(a),
                    Function::Ln => ln(a),
                    Function::Min => a.min(b),
                    Function::Max => a.max(b),
                    Function::Mod => a.rem_euclid(b),
                    Function::Random => a + (b - a) * (scope.random)(),
                }
            }
        }
    }

    /// Value of an expression without parameters.
    pub(super) fn constant(&self) -> f64 {
        self.evaluate(&mut Scope { values: &[], random: &mut || 0.0 })
    }
}

fn truth(t: bool) -> f64 {
    f64::from(u8::from(t))
}

impl Operator {
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Equal => truth(a == b),
            Self::Unequal => truth(a != b),
            Self::LessEqual => truth(a <= b),
            Self::GreaterEqual => truth(a >= b),
            Self::Less => truth(a < b),
            Self::Greater => truth(a > b),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => pow(a, b),
        }
    }
}

/// Names that an expression may use: parameters by their place, and constants.
pub(super) struct Names<'a> {
    pub(super) parameters: &'a [String],
    pub(super) constants: &'a [(String, f64)],
}

/// Reads an expression as far as it goes.
pub(super) fn read(reader: &mut Reader<'_>, names: &Names<'_>) -> Result<Expression, String> {
    level(reader, names, 0, 0)
}

fn level(reader: &mut Reader<'_>, names: &Names<'_>, n: usize, depth: usize) -> Result<Expression, String> {
    if depth > MAX_DEPTH {
        return Err("an expression is nested too deeply".into());
    }
    let Some(operators) = LEVELS.get(n) else { return power(reader, names, depth) };
    let mut left = level(reader, names, n + 1, depth)?;
    let mut terms = 0;
    while let Some((_, op)) = operators.iter().find(|(text, _)| reader.take(text)) {
        // A chain is as deep as it is long.
        terms += 1;
        if terms > MAX_DEPTH {
            return Err("an expression is too long".into());
        }
        let right = level(reader, names, n + 1, depth + 1)?;
        left = Expression::Binary(*op, Box::new([left, right]));
    }
    Ok(left)
}

fn power(reader: &mut Reader<'_>, names: &Names<'_>, depth: usize) -> Result<Expression, String> {
    let base = factor(reader, names, depth)?;
    if !reader.take("^") {
        return Ok(base);
    }
    // To the right first: 2^3^2 is 2^9.
    if depth > MAX_DEPTH {
        return Err("an expression is nested too deeply".into());
    }
    let exponent = power(reader, names, depth + 1)?;
    Ok(Expression::Binary(Operator::Power, Box::new([base, exponent])))
}

fn factor(reader: &mut Reader<'_>, names: &Names<'_>, depth: usize) -> Result<Expression, String> {
    if depth > MAX_DEPTH {
        return Err("an expression is nested too deeply".into());
    }
    for sign in ["-", "!"] {
        if reader.take(sign) {
            let inner = power(reader, names, depth + 1)?;
            return Ok(Expression::Unary(if sign == "-" { '-' } else { '!' }, Box::new(inner)));
        }
    }
    if reader.take("(") {
        let inner = level(reader, names, 0, depth + 1)?;
        return if reader.take(")") { Ok(inner) } else { Err(format!("expected `)` at `{}`", reader.rest())) };
    }
    if let Some(number) = reader.number() {
        return number.map(Expression::Number);
    }
    let Some(name) = reader.name() else { return Err(format!("expected a number or a name at `{}`", reader.rest())) };
    if let Some((_, function, count)) = FUNCTIONS.iter().find(|f| f.0 == name)
        && reader.take("(")
    {
        let mut arguments = vec![level(reader, names, 0, depth + 1)?];
        while reader.take(",") {
            arguments.push(level(reader, names, 0, depth + 1)?);
        }
        return if reader.take(")") && arguments.len() == *count {
            Ok(Expression::Call(*function, arguments))
        } else {
            Err(format!("`{name}` takes {count} arguments in parentheses"))
        };
    }
    if let Some(i) = names.parameters.iter().rposition(|p| *p == name) {
        return Ok(Expression::Parameter(i));
    }
    let constant = names.constants.iter().rev().find(|c| c.0 == name);
    constant.map(|c| Expression::Number(c.1)).ok_or_else(|| format!("there is no parameter or constant `{name}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, String> {
        let names = Names { parameters: &["x".into(), "y".into()], constants: &[("R".into(), 1.5)] };
        let mut reader = Reader::new(text);
        let e = read(&mut reader, &names)?;
        if !reader.is_done() {
            return Err(format!("left over: {}", reader.rest()));
        }
        Ok(e.evaluate(&mut Scope { values: &[3.0, 4.0], random: &mut || 0.25 }))
    }

    #[test]
    fn expressions_have_their_values() {
        for (text, want) in [
            ("1 + 2*3", 7.0),
            ("(1+2)*3 - -1", 10.0),
            ("2^3^2", 512.0),
            ("-2^2", -4.0),
            ("x*x + y*y == 25 && !(x > y)", 1.0),
            ("x < 3 || y != 4", 0.0),
            ("x <= 3", 1.0),
            ("sqrt(x*x+y*y)/R", 10.0 / 3.0),
            ("max(x, y) - min(x,y) + mod(-1, 3)", 3.0),
            ("sin(90) + cos(180) + abs(-2) + floor(2.7)", 4.0),
            ("random(2, 6)", 3.0),
            ("1e-1 + .5", 0.6),
        ] {
            let got = value(text).unwrap();
            assert!((got - want).abs() < 1e-12, "{text}: {got} {want}");
        }
    }

    #[test]
    fn nonsense_is_refused_without_a_crash() {
        let (deep, long) = ("(".repeat(100_000), "1+".repeat(100_000));
        for text in [
            "",
            "1 +",
            "z",
            "sin(1,2)",
            "max(1)",
            "(1",
            "1e999x",
            "sin",
            &deep,
            &long,
            &"-".repeat(100_000),
            &"2^".repeat(100_000),
        ] {
            assert!(value(text).is_err(), "{}", &text[..text.len().min(20)]);
        }
    }
}
