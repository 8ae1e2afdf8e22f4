//! Words of an expression.

use crate::mistake::Mistake;
use eyot_core::remedy;
use eyot_core::remedy::Action;
use eyot_core::text::number_length;
use std::ops::Range;

/// A word.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token {
    Number(f64),
    Name(String),
    Symbol(&'static str),
    End,
}

/// Symbols, longer ones before those that they begin with.
const SYMBOLS: [&str; 19] =
    ["<=", ">=", "==", "!=", "<", ">", "=", "+", "-", "*", "/", "^", "(", ")", "[", "]", ",", ";", "@"];

/// What others write for our words.
const FOREIGN: [(&str, &str); 5] =
    [("&&", "and"), ("||", "or"), ("!", "not"), ("%", "mod(a, b)"), ("?", "if(condition, a, b)")];

/// The words of a text with their bytes; the last is [`Token::End`].
pub(crate) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, Mistake> {
    let (mut out, mut at) = (Vec::new(), 0);
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        if c.is_whitespace() {
            at += c.len_utf8();
        } else if c == '#' {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if c.is_ascii_digit() || c == '.' {
            let n = number_length(rest);
            let span = at..at + n;
            let value: f64 = rest[..n].parse().map_err(|_| {
                Mistake::at(&span, format!("`{}` is no number", &rest[..n]), "here").help("for example 0.5 or 2e-3")
            })?;
            if !(value as f32).is_finite() {
                let message = format!("{} is beyond what a number can be", &rest[..n]);
                return Err(Mistake::at(&span, message, "too large").help("the largest is 3.4e38"));
            }
            out.push((Token::Number(value), span));
            at += n;
        } else if c.is_ascii_alphabetic() || c == '_' {
            let n = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
            out.push((Token::Name(rest[..n].to_owned()), at..at + n));
            at += n;
        } else if let Some(symbol) = SYMBOLS.into_iter().find(|s| rest.starts_with(s)) {
            out.push((Token::Symbol(symbol), at..at + symbol.len()));
            at += symbol.len();
        } else {
            let foreign = FOREIGN.into_iter().find(|(s, _)| rest.starts_with(s));
            let n = foreign.map_or(c.len_utf8(), |(s, _)| s.len());
            let problem = Mistake::at(&(at..at + n), format!("`{}` means nothing here", &rest[..n]), "not expected");
            return Err(match foreign {
                Some((_, ours)) => problem.help(format!("write {ours}")),
                None => {
                    let expressions = Action::Describe("expressions".to_owned());
                    problem.help(remedy![expressions, " says what may stand there"])
                }
            });
        }
    }
    out.push((Token::End, text.len()..text.len()));
    Ok(out)
}
