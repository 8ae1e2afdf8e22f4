//! Units: products of powers of symbols.

use std::collections::BTreeMap;
use std::fmt;

/// Powers are kept in twelfths, so that square and cube roots have one.
const WHOLE: i32 = 12;

/// A unit such as `m2/s`; a plain number has none of the symbols.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Unit(BTreeMap<String, i32>);

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
        let mut unit = Self::default();
        let mut rest = text.trim();
        let mut sign = 1;
        while !rest.is_empty() {
            let symbol = |c: char| c.is_alphabetic() || "°%µ_".contains(c);
            let length = rest.find(|c: char| !symbol(c)).unwrap_or(rest.len());
            if length > 0 {
                let name = &rest[..length];
                rest = rest[length..].trim_start_matches('^');
                let n = rest.find(|c: char| !(c.is_ascii_digit() || c == '-')).unwrap_or(rest.len());
                let power: i32 = if n == 0 { 1 } else { rest[..n].parse().ok().filter(|p| (-9..=9).contains(p))? };
                rest = &rest[n..];
                unit.put(name, sign * power * WHOLE);
            } else if let Some(after) = rest.strip_prefix('1') {
                if after.starts_with(|c: char| c.is_ascii_digit()) {
                    return None;
                }
                rest = after;
            } else {
                return None;
            }
            // What stands between two factors.
            let after = rest.trim_start();
            sign = if after.starts_with('/') { -1 } else { 1 };
            let next = after.trim_start_matches(['/', '*', '·', '.']);
            if after.len() - next.len() > 2 || (next.is_empty() && !after.is_empty()) {
                return None;
            }
            rest = next.trim_start();
        }
        Some(unit)
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
            ("degC", "degC"),
            ("rad", "1"),
        ] {
            assert_eq!(shown(text).as_deref(), Some(want), "{text}");
        }
        for text in ["m/", "2", "12 m", "m)", "m***s", "m99"] {
            assert_eq!(shown(text), None, "{text}");
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
