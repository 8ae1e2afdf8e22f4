//! Who may give orders, and which.

use crate::record::Permission;
use std::collections::hash_map::RandomState;
use std::fmt;
use std::hash::BuildHasher;

/// Who may give orders. Everybody who connects may watch.
#[derive(Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Control {
    /// Nobody.
    #[default]
    Nobody,
    /// Who knows this text and connects to `ws://ADDRESS/?token=TEXT`: not every page and program of this machine.
    Token(String),
    /// Everybody who connects.
    Everybody,
}

/// Without the token: it would stand in every log.
impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nobody => "Nobody",
            Self::Token(_) => "Token(..)",
            Self::Everybody => "Everybody",
        })
    }
}

impl Control {
    /// A token that nobody can guess: 128 bits.
    pub fn random() -> Self {
        // The only random numbers of the standard library: keyed hashes, whose keys come from the system.
        let part = || RandomState::new().hash_one("eyot");
        Self::Token(format!("{:016x}{:016x}", part(), part()))
    }

    /// True for a token that can stand in an address as it is: 8 to 128 letters, digits, `-` and `_`.
    pub fn is_token(text: &str) -> bool {
        (8..=128).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_'))
    }

    /// Whether who asks for this path and query may give orders.
    pub(crate) fn admits(&self, query: Option<&str>) -> bool {
        match self {
            Self::Nobody => false,
            Self::Everybody => true,
            Self::Token(token) => {
                let mut given = query.unwrap_or_default().split('&').filter_map(|p| p.strip_prefix("token="));
                given.any(|g| is_same(g.as_bytes(), token.as_bytes()))
            }
        }
    }

    /// What to say to those who may not do what an order needs; `changes` says whether anybody may change anything.
    pub(crate) fn refusal(&self, needs: Permission, changes: bool) -> &'static str {
        match (self, needs) {
            (Self::Nobody, _) => "this server takes no orders",
            (_, Permission::Change) if !changes => "nobody may change this run: the server was not told to allow it",
            (Self::Token(_) | Self::Everybody, _) => "orders need the token that the server printed when it began",
        }
    }
}

/// How long it takes says nothing about where two texts differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_random_and_asked_for() {
        let Control::Token(token) = Control::random() else { panic!("no token") };
        assert!(Control::is_token(&token) && Control::random() != Control::Token(token.clone()));
        let control = Control::Token(token.clone());
        assert!(control.admits(Some(&format!("token={token}"))) && control.admits(Some(&format!("a=b&token={token}"))));
        for wrong in [None, Some(""), Some("token="), Some(&*token), Some(&*format!("token={}", &token[1..]))] {
            assert!(!control.admits(wrong), "{wrong:?}");
        }
        assert!(!format!("{control:?}").contains(&token));
        assert!(Control::Everybody.admits(None) && !Control::Nobody.admits(None));
        assert!(!Control::is_token("short") && !Control::is_token("with space") && !Control::is_token("with&and"));
    }
}
