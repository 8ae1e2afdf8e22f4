//! Units: products of powers of symbols.

use crate::parse_error::ParseError;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

/// Powers are kept in twelfths, so that square and cube roots have one.
const WHOLE: i32 = 12;

/// A unit such as `m2/s`; a plain number has none of the symbols.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Unit(BTreeMap<String, i32>);

/// A symbol of a text, and its power.
struct Factor {
    symbol: Range<usize>,
    power: i32,
}

/// How units are written.
const GRAMMAR: &str =
    "write symbols with powers, a space or / between them, such as m, m2/s, kg m-3 or 1/yr; 1 is a plain number";

/// Symbols that take a prefix.
const SCALED: [&str; 19] =
    ["m", "g", "s", "K", "A", "mol", "cd", "N", "Pa", "J", "W", "V", "Hz", "lm", "lx", "l", "t", "yr", "E"];
/// Symbols that take none.
const PLAIN: [&str; 24] = [
    "°C", "degC", "C", "degree", "deg", "°", "rad", "sr", "min", "h", "d", "day", "week", "month", "year", "years",
    "a", "ha", "L", "%", "‰", "ppm", "cell", "cells",
];
const PREFIXES: [&str; 11] = ["n", "u", "µ", "μ", "m", "c", "d", "h", "k", "M", "G"];

/// Checks the unit of a recipe's own layer: how it is written, and whether its symbols are known.
///
/// # Errors
/// The first mistake, with its place in the text.
pub fn check(text: &str) -> Result<(), ParseError> {
    let is_known = |symbol: &str| {
        let scaled = || PREFIXES.iter().filter_map(|p| symbol.strip_prefix(p)).any(|rest| SCALED.contains(&rest));
        PLAIN.contains(&symbol) || SCALED.contains(&symbol) || scaled()
    };
    let factors = Unit::read(text)?;
    let Some(factor) = factors.iter().find(|f| !is_known(&text[f.symbol.clone()])) else { return Ok(()) };
    let message = format!("there is no unit `{}`", &text[factor.symbol.clone()]);
    let help = format!(
        "there is {}, with prefixes from n to G, and {}; 1 is a plain number, also for what is counted",
        SCALED.join(" "),
        PLAIN.join(" ")
    );
    Err(ParseError::at(&factor.symbol, message, "unknown unit").help(help))
}

/// What is known of a value's unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Measure {
    /// A number that somebody wrote, or a parameter: it has the unit that is needed.
    Free,
    /// Nothing is known, so nothing is checked.
    Unknown,
    /// This one.
    Of(Unit),
}

impl Unit {
    /// Reads `m2/s`, `m^2 s^-1`, `kg/m3`, `1/yr`; `None` if it is none of these.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        Self::read(text).ok().map(|factors| {
            let mut unit = Self::default();
            factors.iter().for_each(|f| unit.put(&text[f.symbol.clone()], f.power * WHOLE));
            unit
        })
    }

    /// The factors of a text.
    fn read(text: &str) -> Result<Vec<Factor>, ParseError> {
        let wrong = |at: usize, message: &str, label: &str| {
            let end = at + text[at..].chars().next().map_or(0, char::len_utf8);
            Err(ParseError::at(&(at..end), message, label).help(GRAMMAR))
        };
        let mut factors = Vec::new();
        let end = text.trim_end().len();
        let (mut at, mut sign) = (text.len() - text.trim_start().len(), 1);
        while at < end {
            let rest = &text[at..end];
            let length = rest.find(|c: char| !(c.is_alphabetic() || "°%‰_".contains(c))).unwrap_or(rest.len());
            if length > 0 {
                let symbol = at..at + length;
                at += length;
                let caret = usize::from(text[at..end].starts_with('^'));
                let from = at + caret;
                let digits = &text[from..end];
                let n = digits.find(|c: char| !(c.is_ascii_digit() || c == '-')).unwrap_or(digits.len());
                if n == 0 && caret == 1 {
                    return wrong(at, "a power has no exponent", "of what power?");
                }
                let power = if n == 0 { Some(1) } else { digits[..n].parse().ok().filter(|p| (-9..=9).contains(p)) };
                let Some(power) = power.filter(|p| *p != 0) else {
                    let problem =
                        ParseError::at(&(from..from + n), "no unit has such a power", "from -9 to 9, but not 0");
                    return Err(problem.help(GRAMMAR));
                };
                factors.push(Factor { symbol, power: sign * power });
                at = from + n;
            } else if rest.starts_with('1') {
                at += 1;
            } else {
                return wrong(at, "this is no symbol of a unit", "not expected");
            }
            // What stands between two factors.
            let after = &text[at..end];
            let between = after.len() - after.trim_start_matches([' ', '/', '*', '·', '.']).len();
            let signs: String = after[..between].chars().filter(|c| *c != ' ').collect();
            sign = if signs == "/" { -1 } else { 1 };
            if after.is_empty() {
                break;
            }
            match (between, signs.chars().count()) {
                (0, _) => return wrong(at, "symbols of a unit run together", "a space or / before this?"),
                (_, 0 | 1) if between < after.len() => at += between,
                _ => return wrong(at, "a unit has signs without symbols", "not expected"),
            }
        }
        Ok(factors)
    }

    pub(crate) fn metres(power: i32) -> Self {
        let mut unit = Self::default();
        unit.put("m", power * WHOLE);
        unit
    }

    pub(crate) fn is_plain(&self) -> bool {
        self.0.is_empty()
    }

    fn put(&mut self, name: &str, power: i32) {
        let name = match name {
            "yr" | "year" | "years" | "a" => "yr",
            "deg" | "°" => "degree",
            "C" | "degC" => "°C",
            "rad" => return,
            other => other,
        };
        let sum = self.0.entry(name.to_owned()).or_default();
        *sum += power;
        if *sum == 0 {
            self.0.remove(name);
        }
    }

    /// The product of this and `other` to a power.
    pub(crate) fn times(&self, other: &Self, power: i32) -> Self {
        let mut unit = self.clone();
        other.0.iter().for_each(|(name, p)| unit.put(name, p * power));
        unit
    }

    /// To the power of a number; `None` if that is none of twelfths.
    pub(crate) fn power(&self, exponent: f64) -> Option<Self> {
        let mut unit = Self::default();
        for (name, p) in &self.0 {
            let power = f64::from(*p) * exponent;
            if power.fract() != 0.0 || power.abs() > 1e6 {
                return None;
            }
            unit.put(name, power as i32);
        }
        Some(unit)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factor = |(name, p): (&String, i32)| match (p / WHOLE, p % WHOLE) {
            (1, 0) => name.clone(),
            (n, 0) => format!("{name}{n}"),
            _ => format!("{name}^{:.2}", f64::from(p) / f64::from(WHOLE)),
        };
        let (over, under): (Vec<_>, Vec<_>) = self.0.iter().partition(|(_, p)| **p > 0);
        let over: Vec<String> = over.into_iter().map(|(n, p)| factor((n, *p))).collect();
        let under: Vec<String> = under.into_iter().map(|(n, p)| format!("/{}", factor((n, -p)))).collect();
        let over = if over.is_empty() { "1".to_owned() } else { over.join(" ") };
        write!(f, "{over}{}", under.concat())
    }
}

impl Measure {
    /// Of a layer's unit.
    pub(crate) fn of(unit: &str) -> Self {
        Unit::parse(unit).map_or(Self::Unknown, Self::Of)
    }

    pub(crate) fn plain() -> Self {
        Self::Of(Unit::default())
    }

    /// What the sum of two values has, or both units if there is none.
    pub(crate) fn with(&self, other: &Self) -> Result<Self, (Unit, Unit)> {
        match (self, other) {
            (Self::Unknown, _) | (_, Self::Unknown) => Ok(Self::Unknown),
            (Self::Free, one) | (one, Self::Free) => Ok(one.clone()),
            (Self::Of(a), Self::Of(b)) if a == b => Ok(self.clone()),
            (Self::Of(a), Self::Of(b)) => Err((a.clone(), b.clone())),
        }
    }

    /// What the product of this and `other` to a power has. Somebody's number may carry any unit into it.
    pub(crate) fn times(&self, other: &Self, power: i32) -> Self {
        match (self, other) {
            (Self::Unknown, _) | (_, Self::Unknown) => Self::Unknown,
            (Self::Of(a), Self::Of(b)) => Self::Of(a.times(b, power)),
            _ => Self::Free,
        }
    }

    pub(crate) fn power(&self, exponent: f64) -> Self {
        match self {
            Self::Of(unit) => unit.power(exponent).map_or(Self::Unknown, Self::Of),
            other => other.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Option<String> {
        Unit::parse(text).map(|u| u.to_string())
    }

    #[test]
    fn units_are_read_and_shown() {
        for (text, want) in [
            ("1", "1"),
            ("", "1"),
            ("m", "m"),
            ("m2/s", "m2/s"),
            ("m^2 s^-1", "m2/s"),
            ("kg/m3", "kg/m3"),
            ("1/year", "1/yr"),
            ("m/a", "m/yr"),
            ("m*m", "m2"),
            ("m/m", "1"),
            ("m/s/s", "m/s2"),
            ("degC", "°C"),
            ("C week", "week °C"),
            ("1 / yr", "1/yr"),
            (" m ", "m"),
            ("µmol/m2/s", "µmol/m2/s"),
            ("rad", "1"),
        ] {
            assert_eq!(shown(text).as_deref(), Some(want), "{text}");
        }
        for text in ["m/", "2", "12 m", "m)", "m***s", "m99"] {
            assert_eq!(shown(text), None, "{text}");
        }
    }

    #[test]
    fn units_of_recipes_are_known() {
        for text in [
            "1",
            "",
            "m",
            "kg/m2",
            "t/ha",
            "°C",
            "mm/yr",
            "Myr",
            "kPa",
            "%",
            "µmol m-2 s-1",
            "1/month",
            "cells",
            "uE/m2/s",
        ] {
            assert!(check(text).is_ok(), "{text}: {:?}", check(text));
        }
        for (text, span, part) in [
            ("furlong", 0..7, "no unit `furlong`"),
            ("furlong^1e9", 9..10, "run together"),
            ("kg/trees", 3..8, "no unit `trees`"),
            ("m^99", 2..4, "such a power"),
            ("m0", 1..2, "such a power"),
            ("m--2", 1..4, "such a power"),
            ("m^", 1..2, "no exponent"),
            ("m^/s", 1..2, "no exponent"),
            ("m2s", 2..3, "run together"),
            ("10 m", 1..2, "run together"),
            ("m/", 1..2, "signs without"),
            ("m//s", 1..2, "signs without"),
            ("/s", 0..1, "no symbol"),
            ("m²", 1..3, "run together"),
            ("(m)", 0..1, "no symbol"),
            ("kkg", 0..3, "no unit `kkg`"),
        ] {
            let mistake = check(text).unwrap_err();
            assert!(mistake.span == span && mistake.message.contains(part), "{text}: {mistake:?}");
        }
    }

    #[test]
    fn units_are_multiplied() {
        let [m, s] = ["m", "s"].map(|t| Unit::parse(t).unwrap());
        assert_eq!(m.times(&s, -1).to_string(), "m/s");
        assert_eq!(m.power(0.5).unwrap().times(&m.power(0.5).unwrap(), 1), m);
        assert!(m.power(0.3).is_none());
    }
}
