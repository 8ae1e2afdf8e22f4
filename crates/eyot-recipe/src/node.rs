//! A parsed document in which every key and value knows its place.

use crate::diagnostic::{Diagnostic, alternatives};
use eyot_core::process::LIKE;
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
                    "each key may appear once in a table; remove one of them".to_owned()
                } else if let Some(help) = slip(text, span.start) {
                    help
                } else {
                    "recipes are TOML: `key = value` lines, text in quotes, tables in [brackets]".to_owned()
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

    /// As [`Node::elements`], to be changed; `None` for what is no array.
    pub(crate) fn elements_mut(&mut self) -> Option<&mut Vec<Node>> {
        match &mut self.kind {
            Kind::Array(a) => Some(a),
            _ => None,
        }
    }

    /// The value of a key of a table, to be changed.
    pub(crate) fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        match &mut self.kind {
            Kind::Table(t) => t.iter_mut().find(|(k, _)| k.name == key).map(|(_, v)| v),
            _ => None,
        }
    }

    /// The value of a key of a table, which is made if there is none; `None` for what is no table.
    pub(crate) fn entry(&mut self, key: Key, value: impl FnOnce() -> Node) -> Option<&mut Node> {
        let Kind::Table(t) = &mut self.kind else { return None };
        let at = t.iter().position(|(k, _)| k.name == key.name).unwrap_or_else(|| {
            t.push((key, value()));
            t.len() - 1
        });
        Some(&mut t[at].1)
    }

    /// The value at a path such as `beds.2.material`: keys of tables, and in lists numbers, from 1 on, or names. Of a path that leads
    /// nowhere as far as it leads; `None` if that is nowhere.
    pub(crate) fn at_path(&self, path: &str) -> Option<&Node> {
        let child = |name: &str| match &self.kind {
            Kind::Array(items) => {
                let numbered = name.parse::<usize>().ok().and_then(|n| items.get(n.checked_sub(1)?));
                numbered.or_else(|| items.iter().find(|e| e.name() == Some(name)))
            }
            _ => self.get(name),
        };
        // Names may have dots in them.
        let dots = path.match_indices('.').map(|(i, _)| i);
        let ends = std::iter::once(path.len()).chain(dots);
        ends.filter_map(|end| Some((child(&path[..end])?, path.get(end + 1..).unwrap_or_default())))
            .map(|(node, rest)| if rest.is_empty() { node } else { node.at_path(rest).unwrap_or(node) })
            .next()
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

    /// Puts a value at a path of keys; tables on the way are made, tables that meet are united, and a table that meets a list of
    /// tables with names changes those that it names.
    ///
    /// # Errors
    /// If it names one that is not in such a list and does not say what that is like.
    pub(crate) fn put(&mut self, key: &Key, value: Node) -> Result<(), Diagnostic> {
        if !matches!(self.kind, Kind::Table(_)) {
            self.kind = Kind::Table(Vec::new());
        }
        let Kind::Table(entries) = &mut self.kind else { return Ok(()) };
        let Some((k, old)) = entries.iter_mut().find(|(k, _)| k.name == key.name) else {
            entries.push((key.clone(), value));
            return Ok(());
        };
        match (&mut old.kind, value.kind) {
            (Kind::Table(_), Kind::Table(new)) => new.into_iter().try_for_each(|(k, v)| old.put(&k, v)),
            (Kind::Array(list), Kind::Table(new)) if list.iter().any(|e| e.name().is_some()) => {
                new.into_iter().try_for_each(|(name, v)| change_named(list, key, &name, v))
            }
            (_, kind) => {
                k.span = key.span.clone();
                *old = Node { span: value.span, kind };
                Ok(())
            }
        }
    }

    /// The text `name` of a table.
    fn name(&self) -> Option<&str> {
        self.get("name").and_then(Self::text)
    }
}

/// Changes the table of that name in a list, or adds it.
fn change_named(list: &mut Vec<Node>, of: &Key, name: &Key, value: Node) -> Result<(), Diagnostic> {
    let span = name.span.clone();
    if let Some(element) = list.iter_mut().find(|e| e.name() == Some(name.name.as_str())) {
        let Kind::Table(new) = value.kind else {
            let message = format!("`{}.{}` must be a table, not {}", of.name, name.name, value.describe());
            return Err(Diagnostic::at(span, message, "here"));
        };
        return new.into_iter().try_for_each(|(k, v)| element.put(&k, v));
    }
    if value.get(LIKE).is_none() {
        let known: Vec<&str> = list.iter().filter_map(Node::name).collect();
        let help = format!(
            "the recipe lists {}; another one says whose values it takes: {LIKE} = \"NAME\"",
            alternatives(known)
        );
        return Err(
            Diagnostic::at(span.clone(), format!("`{}` has no `{}`", of.name, name.name), "not there").help(help)
        );
    }
    let mut new = Node { span, kind: value.kind };
    let text = Node { span: name.span.clone(), kind: Kind::Text(name.name.clone()) };
    new.put(&Key { span: name.span.clone(), name: "name".to_owned() }, text)?;
    list.push(new);
    Ok(())
}

/// What was most likely meant on the line of a mistake: a number with a decimal comma, or a path with backslashes.
fn slip(text: &str, at: usize) -> Option<String> {
    // What surprises a parser is often the end of the line before.
    let at = text.floor_char_boundary(at);
    let before = text[..at].strip_suffix('\n').unwrap_or(&text[..at]);
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    let line = text[start..].lines().next()?;
    let (_, value) = line.split_once('=')?;
    let value = value.split('#').next().unwrap_or_default().trim();
    let digits = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    if let Some((whole, part)) = value.split_once(',')
        && digits(whole.trim_start_matches(['-', '+']))
        && digits(part)
    {
        return Some(format!("numbers have a decimal point: write {whole}.{part}"));
    }
    let path = value.strip_prefix('"')?.trim_end_matches('"');
    path.contains('\\').then(|| {
        format!("in double quotes a backslash begins an escape; write the path as \"{}\"", path.replace('\\', "/"))
    })
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
    fn paths_lead_through_tables_and_lists() {
        let text =
            "beds = [{ m = 'a' }, { m = 'b' }]\n[materials]\n'rim 1.5' = { talus = 5 }\n[[list]]\nname = 'c'\nv = 7\n";
        let doc = Node::parse(text, 0).unwrap();
        let at = |path: &str| doc.at_path(path).map(|n| n.to_json());
        assert_eq!(at("beds.2.m"), Some(serde_json::json!("b")));
        assert_eq!(at("materials.rim 1.5.talus"), Some(serde_json::json!(5)));
        assert_eq!(at("list.c.v"), Some(serde_json::json!(7)));
        // As far as it leads.
        assert_eq!(at("beds.2.thickness"), Some(serde_json::json!({ "m": "b" })));
        assert_eq!(at("beds.0"), at("beds"));
        assert!(at("folds.1").is_none());
    }

    #[test]
    fn large_seeds_survive() {
        let doc = Node::parse("seed = 18446744073709551615", 0);
        if let Ok(doc) = doc {
            assert_eq!(doc.get("seed").unwrap().to_json(), serde_json::json!(u64::MAX));
        }
    }
}
