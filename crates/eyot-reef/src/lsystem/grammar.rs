//! Grammars: an axiom, rules, and how the turtle draws; and their text format.

use super::expression::{Expression, Names, read};
use super::text::Reader;
use super::word::{Symbol, Word};
use eyot_core::{Error, Result};

/// A grammar. [`Grammar::parse`] reads one; the format is described in [`lsystem`](crate::lsystem).
#[derive(Clone, Debug)]
pub struct Grammar {
    /// What derivation begins with.
    pub axiom: Word,
    /// Steps that the author suggests.
    pub steps: u32,
    /// How it is drawn.
    pub turtle: Turtle,
    pub(super) productions: Rules,
    /// Applied after each step until nothing changes, at most so often.
    pub(super) decompositions: Rules,
    pub(super) decomposition_depth: u32,
    /// Applied when a word is drawn, at most so often in a row.
    pub(super) interpretations: Rules,
    pub(super) interpretation_depth: u32,
    /// Symbols that contexts do not see.
    pub(super) ignored: Vec<Symbol>,
}

/// Settings of the turtle.
#[derive(Clone, Debug, PartialEq)]
pub struct Turtle {
    /// Turns without a number, degrees.
    pub angle: f64,
    /// Length of steps without a number.
    pub step: f64,
    /// Width at the beginning.
    pub width: f64,
    /// `!` without a number multiplies the width by this.
    pub thinning: f64,
    /// Symbols that draw like `F`.
    pub draws: Vec<Symbol>,
    /// Direction in which drawn steps bend.
    pub tropism: [f64; 3],
    /// How much: turn in radians per step at right angles to that direction.
    pub elasticity: f64,
}

impl Default for Turtle {
    fn default() -> Self {
        Self {
            angle: 90.0,
            step: 1.0,
            width: 1.0,
            thinning: 0.707,
            draws: vec![Symbol::of('F')],
            tropism: [0.0, 0.0, -1.0],
            elasticity: 0.0,
        }
    }
}

/// A module in the pattern of a rule; parameters are numbered through the whole pattern.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    pub(super) symbol: Symbol,
    pub(super) count: usize,
    /// Its first parameter.
    pub(super) first: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Rule {
    pub(super) left: Vec<Pattern>,
    pub(super) strict: Pattern,
    pub(super) right: Vec<Pattern>,
    pub(super) parameters: usize,
    pub(super) condition: Option<Expression>,
    pub(super) weight: Option<Expression>,
    pub(super) successor: Vec<(Symbol, Vec<Expression>)>,
}

/// Rules by the symbol that they replace.
#[derive(Clone, Debug, Default)]
pub(super) struct Rules(Vec<(Symbol, Vec<Rule>)>);

impl Rules {
    fn add(&mut self, rule: Rule) {
        match self.0.binary_search_by_key(&rule.strict.symbol, |r| r.0) {
            Ok(i) => self.0[i].1.push(rule),
            Err(i) => self.0.insert(i, (rule.strict.symbol, vec![rule])),
        }
    }

    /// Rules of a symbol, in the order of the text.
    pub(super) fn of(&self, symbol: Symbol) -> &[Rule] {
        self.0.binary_search_by_key(&symbol, |r| r.0).map_or(&[], |i| &self.0[i].1)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Longest text of a grammar, bytes.
const MAX_TEXT: usize = 1 << 20;
/// Depth of decompositions and interpretations unless the text says something else, and the largest one that it may say.
const DEPTH: (u32, u32) = (16, 1000);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Rules,
    Decomposition,
    Interpretation,
}

impl Grammar {
    /// Reads a grammar.
    ///
    /// # Errors
    /// The first line that cannot be understood, with its number.
    pub fn parse(text: &str) -> Result<Self> {
        if text.len() > MAX_TEXT {
            return Err(bad("text", format!("has {} bytes; {MAX_TEXT} are allowed", text.len())));
        }
        let mut grammar = Self {
            axiom: Word::default(),
            steps: 1,
            turtle: Turtle::default(),
            productions: Rules::default(),
            decompositions: Rules::default(),
            decomposition_depth: DEPTH.0,
            interpretations: Rules::default(),
            interpretation_depth: DEPTH.0,
            ignored: Vec::new(),
        };
        let (mut constants, mut section) = (Vec::new(), Section::Rules);
        for (n, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let read = match line.split_once("->") {
                Some((pattern, successor)) => rule(pattern, successor, &constants).map(|r| match section {
                    Section::Rules => grammar.productions.add(r),
                    Section::Decomposition => grammar.decompositions.add(r),
                    Section::Interpretation => grammar.interpretations.add(r),
                }),
                None => grammar.setting(line, &mut constants, &mut section),
            };
            read.map_err(|reason| bad(&format!("line {}", n + 1), reason))?;
        }
        if grammar.axiom.is_empty() {
            return Err(bad("axiom", "is missing; write `axiom: F`".into()));
        }
        Ok(grammar)
    }

    fn setting(&mut self, line: &str, constants: &mut Vec<(String, f64)>, section: &mut Section) -> Result<(), String> {
        let (key, value) = line.split_once(':').ok_or("expected `name: value`, or a rule with `->`")?;
        let value = value.trim();
        let numbers =
            || -> Result<Vec<f64>, String> { value.split_whitespace().map(|v| constant(v, constants)).collect() };
        let number = || numbers().and_then(|n| if n.len() == 1 { Ok(n[0]) } else { Err("expected one number".into()) });
        let count = |max: u32| {
            number().and_then(|n| {
                let fits = n >= 0.0 && n <= f64::from(max) && n.fract() == 0.0;
                if fits { Ok(n as u32) } else { Err(format!("{n} is no whole number within 0..={max}")) }
            })
        };
        let symbols = || -> Result<Vec<Symbol>, String> {
            Ok(modules(value, &Names { parameters: &[], constants })?.into_iter().map(|m| m.0).collect())
        };
        match key.trim() {
            "axiom" => {
                self.axiom = Word::default();
                for (symbol, numbers) in modules(value, &Names { parameters: &[], constants })? {
                    self.axiom.push(symbol, numbers.iter().map(Expression::constant));
                }
                balanced(self.axiom.symbols().iter().copied())?;
            }
            "steps" => self.steps = count(100_000)?,
            "angle" => self.turtle.angle = number()?,
            "step" => self.turtle.step = number()?,
            "width" => self.turtle.width = number()?,
            "thinning" => self.turtle.thinning = number()?,
            "draw" => self.turtle.draws = symbols()?,
            "ignore" => self.ignored = symbols()?,
            "elasticity" => self.turtle.elasticity = number()?,
            "tropism" => {
                self.turtle.tropism = numbers()?.try_into().map_err(|_| "expected three numbers".to_owned())?;
            }
            "define" => {
                let (name, value) = value.split_once('=').ok_or("expected `define: NAME = VALUE`")?;
                let mut reader = Reader::new(name);
                let name = reader.name().filter(|_| reader.is_done()).ok_or("expected a name before `=`")?;
                let value = constant(value, constants)?;
                constants.push((name, value));
            }
            "rules" => *section = Section::Rules,
            "decomposition" => {
                *section = Section::Decomposition;
                self.decomposition_depth = if value.is_empty() { DEPTH.0 } else { count(DEPTH.1)? };
            }
            "interpretation" => {
                *section = Section::Interpretation;
                self.interpretation_depth = if value.is_empty() { DEPTH.0 } else { count(DEPTH.1)? };
            }
            other => {
                return Err(format!(
                    "there is no setting `{other}`; there are axiom, steps, angle, step, width, thinning, draw, ignore, tropism, \
                     elasticity, define, rules, decomposition, interpretation"
                ));
            }
        }
        Ok(())
    }
}

fn constant(text: &str, constants: &[(String, f64)]) -> Result<f64, String> {
    let mut reader = Reader::new(text);
    let value = read(&mut reader, &Names { parameters: &[], constants })?.constant();
    if !reader.is_done() {
        return Err(format!("`{}` is left over", reader.rest()));
    }
    if value.is_finite() { Ok(value) } else { Err(format!("`{}` is not a finite number", text.trim())) }
}

/// Reads modules whose numbers are expressions.
fn modules(text: &str, names: &Names<'_>) -> Result<Vec<(Symbol, Vec<Expression>)>, String> {
    let mut reader = Reader::new(text);
    let mut modules = Vec::new();
    while let Some(symbol) = symbol(&mut reader)? {
        let mut numbers = Vec::new();
        if reader.take("(") {
            numbers.push(read(&mut reader, names)?);
            while reader.take(",") {
                numbers.push(read(&mut reader, names)?);
            }
            if !reader.take(")") {
                return Err(format!("expected `)` at `{}`", reader.rest()));
            }
        }
        modules.push((symbol, numbers));
    }
    Ok(modules)
}

fn symbol(reader: &mut Reader<'_>) -> Result<Option<Symbol>, String> {
    match reader.sign() {
        Some('?') => match reader.sign().filter(char::is_ascii_alphabetic) {
            Some(name) => Ok(Some(Symbol::query(name))),
            None => Err("a query is `?` and a letter".into()),
        },
        Some(sign @ ('(' | ')' | ',' | '<' | '>')) => Err(format!("`{sign}` is no symbol")),
        sign => Ok(sign.map(Symbol::of)),
    }
}

/// Brackets must close what they open.
fn balanced(symbols: impl Iterator<Item = Symbol>) -> Result<(), String> {
    let mut depth = 0i64;
    for s in symbols {
        depth += i64::from(s == Symbol::of('[')) - i64::from(s == Symbol::of(']'));
        if depth < 0 {
            return Err("`]` without `[`".into());
        }
    }
    if depth == 0 { Ok(()) } else { Err("`[` without `]`".into()) }
}

fn rule(pattern: &str, successor: &str, constants: &[(String, f64)]) -> Result<Rule, String> {
    let (pattern, weight) = pattern.rsplit_once('@').map_or((pattern, None), |(p, w)| (p, Some(w)));
    let (pattern, condition) = pattern.split_once(':').map_or((pattern, None), |(p, c)| (p, Some(c)));
    let (left, pattern) = pattern.split_once('<').unwrap_or(("", pattern));
    let (strict, right) = pattern.split_once('>').unwrap_or((pattern, ""));
    let mut parameters = Vec::new();
    let [left, strict, right] = [left, strict, right].map(|text| patterns(text, &mut parameters));
    let (left, strict, right) = (left?, strict?, right?);
    let [strict] = strict[..] else { return Err("a rule replaces exactly one module".into()) };
    if [Symbol::of('['), Symbol::of(']')].contains(&strict.symbol) {
        return Err("brackets cannot be replaced".into());
    }
    if left.iter().any(|p| [Symbol::of('['), Symbol::of(']')].contains(&p.symbol)) {
        return Err("a left context is a path and has no brackets".into());
    }
    balanced(right.iter().map(|p| p.symbol))?;
    let names = Names { parameters: &parameters, constants };
    let whole = |text: &str| {
        let mut reader = Reader::new(text);
        let e = read(&mut reader, &names)?;
        if reader.is_done() { Ok(e) } else { Err(format!("`{}` is left over", reader.rest())) }
    };
    // `*` is always true, as in the literature.
    let condition = condition.filter(|c| c.trim() != "*").map(whole).transpose()?;
    let weight = weight.map(whole).transpose()?;
    let successor = modules(successor, &names)?;
    balanced(successor.iter().map(|m| m.0))?;
    Ok(Rule { left, strict, right, parameters: parameters.len(), condition, weight, successor })
}

/// Reads modules whose numbers are names; `*` is no context at all.
fn patterns(text: &str, parameters: &mut Vec<String>) -> Result<Vec<Pattern>, String> {
    if text.trim() == "*" {
        return Ok(Vec::new());
    }
    let mut reader = Reader::new(text);
    let mut patterns = Vec::new();
    while let Some(symbol) = symbol(&mut reader)? {
        let first = parameters.len();
        if reader.take("(") {
            loop {
                let name = reader.name().ok_or_else(|| format!("expected a name at `{}`", reader.rest()))?;
                if parameters.contains(&name) {
                    return Err(format!("the parameter `{name}` is there twice"));
                }
                parameters.push(name);
                if !reader.take(",") {
                    break;
                }
            }
            if !reader.take(")") {
                return Err(format!("expected `)` at `{}`", reader.rest()));
            }
        }
        patterns.push(Pattern { symbol, count: parameters.len() - first, first });
    }
    Ok(patterns)
}

pub(super) fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "grammar".into(), field: field.into(), reason }
}
