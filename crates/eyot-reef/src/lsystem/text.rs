//! Reading the text of a grammar, sign by sign.

use eyot_core::text::number_length;

/// What is left of a line.
pub(super) struct Reader<'a> {
    rest: &'a str,
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text.trim_start() }
    }

    pub(super) fn is_done(&self) -> bool {
        self.rest.is_empty()
    }

    /// The beginning of what is left, for messages.
    pub(super) fn rest(&self) -> String {
        self.rest.chars().take(20).collect()
    }

    /// Takes a text if it comes next.
    pub(super) fn take(&mut self, text: &str) -> bool {
        let Some(rest) = self.rest.strip_prefix(text) else { return false };
        self.rest = rest.trim_start();
        true
    }

    /// Takes the next sign, whatever it is.
    pub(super) fn sign(&mut self) -> Option<char> {
        let c = self.rest.chars().next()?;
        self.rest = self.rest[c.len_utf8()..].trim_start();
        Some(c)
    }

    pub(super) fn name(&mut self) -> Option<String> {
        let fits = |(i, c): (usize, char)| c.is_ascii_alphabetic() || c == '_' || i > 0 && c.is_ascii_digit();
        let end = self.rest.char_indices().find(|&c| !fits(c)).map_or(self.rest.len(), |c| c.0);
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        (!name.is_empty()).then(|| name.to_owned())
    }

    /// A number without sign, if one comes next.
    pub(super) fn number(&mut self) -> Option<Result<f64, String>> {
        let bytes = self.rest.as_bytes();
        if !bytes.first().is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
            return None;
        }
        let (number, rest) = self.rest.split_at(number_length(self.rest));
        self.rest = rest.trim_start();
        let parsed = number.parse::<f64>().ok().filter(|n| n.is_finite());
        Some(parsed.ok_or_else(|| format!("`{number}` is no number")))
    }
}
