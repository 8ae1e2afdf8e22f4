//! A parsed document in which every key and value knows its place.

use crate::diagnostic::Diagnostic;
use serde_json::{Number, Value};
use toml::de::{DeTable, DeValue};

/// A stretch of one of the sources of a recipe.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Span {
    /// Index of the source: 0 is the recipe, the flags follow.
    pub source: usize,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// A value with its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) span: Span,
    pub(crate) kind: Kind,
}

/// What a value is.
#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Bool(bool),
    Int(i128),
    Float(f64),
    Text(String),
    Date(String),
    Array(Vec<Node>),
    Table(Vec<(Key, Node)>),
}

/// A key with its place.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) span: Span,
    pub(crate) name: String,
}

impl Node {
    /// Parses a document; all errors of the parser come back.
    pub(crate) fn parse(text: &str, source: usize) -> Result<Node, Vec<Diagnostic>> {
        let (table, errors) = DeTable::parse_recoverable(text);
        if errors.is_empty() {
            return Ok(Node { span: Span { source, start: 0, end: 0 }, kind: table_of(table.get_ref(), source) });
        }
        Err(errors
            .iter()
            .map(|e| {
                let span = e.span().unwrap_or(0..0);
                let span = Span { source, start: span.start.min(text.len()), end: span.end.min(text.len()) };
                let help = if e.message().contains("duplicate key") {
                    "each key may appear once in a table; remove one of them"
                } else {
                    "recipes are TOML: `key = value` lines, text in quotes, tables in [brackets]"
                };
                Diagnostic::at(span, format!("not valid TOML: {}", e.message()), "here").help(help)
            })
            .collect())
    }

    /// The entries of a table, nothing for anything else.
    pub(crate) fn entries(&self) -> &[(Key, Node)] {
        match &self.kind {
            Kind::Table(t) => t,
            _ => &[],
        }
    }

    /// The elements of an array, nothing for anything else.
    pub(crate) fn elements(&self) -> &[Node] {
        match &self.kind {
            Kind::Array(a) => a,
            _ => &[],
        }
    }

    /// The value of a key of a table.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|(k, _)| k.name == key).map(|(_, v)| v)
    }

    /// Text of a text value.
    pub(crate) fn text(&self) -> Option<&str> {
        match &self.kind {
            Kind::Text(t) => Some(t),
            _ => None,
        }
    }

    /// What the value is, in a recipe author's words.
    pub(crate) fn describe(&self) -> String {
        match &self.kind {
            Kind::Bool(b) => format!("`{b}`"),
            Kind::Int(i) => format!("the number {i}"),
            Kind::Float(x) => format!("the number {x}"),
            Kind::Text(t) if t.chars().count() <= 40 => format!("the text \"{t}\""),
            Kind::Text(_) => "a text".to_owned(),
            Kind::Date(d) => format!("the date {d}"),
            Kind::Array(a) => format!("a list of {}", a.len()),
            Kind::Table(_) => "a table".to_owned(),
        }
    }

    /// The value as JSON; numbers that JSON does not have become null.
    pub(crate) fn to_json(&self) -> Value {
        match &self.kind {
            Kind::Bool(b) => Value::Bool(*b),
            Kind::Int(i) => u64::try_from(*i)
                .map(Value::from)
                .or_else(|_| i64::try_from(*i).map(Value::from))
                .unwrap_or_else(|_| Number::from_f64(*i as f64).map_or(Value::Null, Value::Number)),
            Kind::Float(x) => Number::from_f64(*x).map_or(Value::Null, Value::Number),
            Kind::Text(t) | Kind::Date(t) => Value::String(t.clone()),
            Kind::Array(a) => a.iter().map(Node::to_json).collect(),
            Kind::Table(t) => Value::Object(t.iter().map(|(k, v)| (k.name.clone(), v.to_json())).collect()),
        }
    }

    /// Puts a value at a path of keys; tables on the way are made, tables that meet are united.
    pub(crate) fn put(&mut self, key: &Key, value: Node) {
        if !matches!(self.kind, Kind::Table(_)) {
            self.kind = Kind::Table(Vec::new());
        }
        let Kind::Table(entries) = &mut self.kind else { return };
        match entries.iter_mut().find(|(k, _)| k.name == key.name) {
            Some((_, old)) if matches!((&old.kind, &value.kind), (Kind::Table(_), Kind::Table(_))) => {
                if let Kind::Table(new) = value.kind {
                    new.into_iter().for_each(|(k, v)| old.put(&k, v));
                }
            }
            Some((k, old)) => {
                k.span = key.span.clone();
                *old = value;
            }
            None => entries.push((key.clone(), value)),
        }
    }
}

fn table_of(table: &DeTable<'_>, source: usize) -> Kind {
    let mut entries: Vec<(Key, Node)> = table
        .iter()
        .map(|(k, v)| {
            let key = Key { span: span_of(k.span(), source), name: k.get_ref().to_string() };
            (key, Node { span: span_of(v.span(), source), kind: kind_of(v.get_ref(), source) })
        })
        .collect();
    entries.sort_by_key(|(k, _)| k.span.start);
    Kind::Table(entries)
}

fn kind_of(value: &DeValue<'_>, source: usize) -> Kind {
    match value {
        DeValue::String(s) => Kind::Text(s.to_string()),
        DeValue::Integer(i) => match i128::from_str_radix(&i.as_str().replace('_', ""), i.radix()) {
            Ok(n) => Kind::Int(n),
            Err(_) => Kind::Float(f64::INFINITY),
        },
        DeValue::Float(x) => Kind::Float(x.as_str().replace('_', "").parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(b) => Kind::Bool(*b),
        DeValue::Datetime(d) => Kind::Date(d.to_string()),
        DeValue::Array(a) => Kind::Array(
            a.iter().map(|v| Node { span: span_of(v.span(), source), kind: kind_of(v.get_ref(), source) }).collect(),
        ),
        DeValue::Table(t) => table_of(t, source),
    }
}

fn span_of(range: std::ops::Range<usize>, source: usize) -> Span {
    Span { source, start: range.start, end: range.end }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_point_at_keys_and_values() {
        let text = "a = 1\n[b]\nc.d = [1.5, 'x']\n";
        let doc = Node::parse(text, 0).unwrap();
        let d = doc.get("b").unwrap().get("c").unwrap().get("d").unwrap();
        assert_eq!(&text[d.span.start..d.span.end], "[1.5, 'x']");
        assert_eq!(d.to_json(), serde_json::json!([1.5, "x"]));
    }

    #[test]
    fn broken_text_is_an_error_with_a_place() {
        for text in [
            "a = ",
            "[grid",
            "a = 1\na = 2",
            "= 3",
            "a = 'x",
            "\u{0}",
            "a = 99999999999999999999999999999999999999999999999",
        ] {
            match Node::parse(text, 0) {
                Ok(_) => assert!(text.starts_with("a = 999"), "{text}"),
                Err(e) => assert!(!e.is_empty()),
            }
        }
    }

    #[test]
    fn large_seeds_survive() {
        let doc = Node::parse("seed = 18446744073709551615", 0);
        if let Ok(doc) = doc {
            assert_eq!(doc.get("seed").unwrap().to_json(), serde_json::json!(u64::MAX));
        }
    }
}
