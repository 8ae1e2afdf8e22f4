//! Whether a module stands in the context that a rule asks for.

use super::grammar::{Pattern, Rule};
use super::word::{Symbol, Word};

const OPEN: Symbol = Symbol::of('[');
const CLOSE: Symbol = Symbol::of(']');

/// A word as contexts see it.
pub(super) struct Surroundings<'a> {
    word: &'a Word,
    ignored: &'a [Symbol],
    /// For brackets the place of the other one.
    partner: Vec<u32>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(word: &'a Word, ignored: &'a [Symbol], with_contexts: bool) -> Self {
        let mut partner = Vec::new();
        if with_contexts {
            partner = vec![u32::MAX; word.len()];
            let mut open = Vec::new();
            for (i, &s) in word.symbols().iter().enumerate() {
                if s == OPEN {
                    open.push(i);
                } else if s == CLOSE
                    && let Some(j) = open.pop()
                {
                    (partner[i], partner[j]) = (j as u32, i as u32);
                }
            }
        }
        Self { word, ignored, partner }
    }

    /// Fills the rule's parameters if it fits module `at`, its condition aside.
    pub(super) fn fits(&self, rule: &Rule, at: usize, values: &mut Vec<f64>) -> bool {
        values.clear();
        values.resize(rule.parameters, 0.0);
        self.takes(&rule.strict, at, values)
            && self.fits_left(&rule.left, at, values)
            && (rule.right.is_empty() || self.fits_right(&rule.right, at + 1, values).is_some())
    }

    fn takes(&self, pattern: &Pattern, at: usize, values: &mut [f64]) -> bool {
        let numbers = self.word.numbers(at);
        if self.word.symbols()[at] != pattern.symbol || numbers.len() != pattern.count {
            return false;
        }
        values[pattern.first..pattern.first + pattern.count].copy_from_slice(numbers);
        true
    }

    /// The left context is the path from the module down to the root: branches that end before it are passed over.
    fn fits_left(&self, left: &[Pattern], at: usize, values: &mut [f64]) -> bool {
        let mut i = at;
        for pattern in left.iter().rev() {
            loop {
                if i == 0 {
                    return false;
                }
                i -= 1;
                let s = self.word.symbols()[i];
                if s == CLOSE {
                    i = self.partner[i] as usize;
                } else if s != OPEN && !self.ignored.contains(&s) {
                    break;
                }
            }
            if !self.takes(pattern, i, values) {
                return false;
            }
        }
        true
    }

    /// The right context begins with the module at `i`; branches that it does not name are passed over. Returns where it ends.
    fn fits_right(&self, right: &[Pattern], mut i: usize, values: &mut [f64]) -> Option<usize> {
        let Some((first, rest)) = right.split_first() else { return Some(i) };
        loop {
            let &s = self.word.symbols().get(i)?;
            if s == CLOSE {
                return None;
            }
            if self.ignored.contains(&s) {
                i += 1;
                continue;
            }
            if s == OPEN {
                let end = self.partner[i] as usize;
                // The context names a branch: this one, or one of the next.
                if first.symbol == OPEN {
                    let inner = closing(rest);
                    if self.fits_right(&rest[..inner], i + 1, values).is_some()
                        && let Some(after) = self.fits_right(&rest[inner + 1..], end + 1, values)
                    {
                        return Some(after);
                    }
                }
                i = end + 1;
                continue;
            }
            if first.symbol == OPEN || !self.takes(first, i, values) {
                return None;
            }
            return self.fits_right(rest, i + 1, values);
        }
    }
}

/// Place of the bracket that closes what was opened before these patterns.
fn closing(patterns: &[Pattern]) -> usize {
    let mut depth = 0;
    for (i, p) in patterns.iter().enumerate() {
        if p.symbol == OPEN {
            depth += 1;
        } else if p.symbol == CLOSE {
            if depth == 0 {
                return i;
            }
            depth -= 1;
        }
    }
    patterns.len()
}
