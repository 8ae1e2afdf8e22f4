//! Derivation: all modules of a word are replaced at once, step by step.

use super::context::Surroundings;
use super::expression::Scope;
use super::grammar::{Grammar, Rule, Rules};
use super::turtle::{Ask, answer};
use super::word::{Symbol, Word};
use eyot_core::rng::{Key, hash, unit};
use eyot_core::{Error, Limits, Result};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Modules that one task replaces.
const TASK: usize = 4096;
const OPEN: Symbol = Symbol::of('[');
const CLOSE: Symbol = Symbol::of(']');
const CUT: Symbol = Symbol::of('%');
/// Streams of random numbers of productions and of decompositions.
const STREAMS: [u32; 2] = [0x1575_0001, 0x1575_0002];

/// Bytes that a word may take, counted by all who write parts of it.
pub(super) struct Budget {
    used: AtomicU64,
    limit: u64,
}

impl Budget {
    pub(super) fn new(limits: &Limits) -> Self {
        // Numbers of a word have 32-bit places.
        Self { used: AtomicU64::new(0), limit: limits.max_bytes.min(8 << 30) }
    }

    /// Takes bytes. Fails if and only if all bytes together are too many, in whatever order they are taken.
    pub(super) fn take(&self, bytes: usize) -> Result<()> {
        let used = self.used.fetch_add(bytes as u64, Ordering::Relaxed) + bytes as u64;
        if used <= self.limit {
            return Ok(());
        }
        Err(Error::Limit {
            what: "the word of a grammar".into(),
            needed: format!("more than {} MiB", self.limit >> 20),
            limit: format!("{} MiB", self.limit >> 20),
            remedy: "derive fewer steps, or raise the limit".into(),
        })
    }
}

impl Grammar {
    /// Derives so many steps from the axiom. Random numbers depend on seed, step and place of the module.
    ///
    /// # Errors
    /// If a word would take more bytes than the limits allow, before it does.
    pub fn derive(&self, steps: u32, seed: u64, limits: &Limits) -> Result<Word> {
        self.derive_in(steps, seed, limits, &|_| Vec::new())
    }

    /// As [`Grammar::derive`], in an environment: after each step it is asked about every query other than `?P`, `?H`, `?U` and
    /// `?L`, which the turtle fills with its place and directions. Answers overwrite the query's numbers.
    ///
    /// # Errors
    /// As [`Grammar::derive`], and if the interpretation of a word with queries is too long.
    pub fn derive_in(
        &self,
        steps: u32,
        seed: u64,
        limits: &Limits,
        environment: &dyn Fn(&Ask<'_>) -> Vec<f64>,
    ) -> Result<Word> {
        let mut word = self.axiom.clone();
        self.settle(&mut word, seed, 0, limits, environment)?;
        for step in 0..u64::from(steps) {
            word = self.step(&self.productions, &word, Key::new(seed, STREAMS[0], step), limits)?;
            self.settle(&mut word, seed, step + 1, limits, environment)?;
        }
        Ok(word)
    }

    /// What follows each step: cuts, decomposition, answers to queries.
    fn settle(
        &self,
        word: &mut Word,
        seed: u64,
        step: u64,
        limits: &Limits,
        environment: &dyn Fn(&Ask<'_>) -> Vec<f64>,
    ) -> Result<()> {
        if !self.decompositions.is_empty() {
            for depth in 0..self.decomposition_depth {
                let key = Key::new(seed, STREAMS[1], (step << 16) + u64::from(depth));
                if !word.symbols().iter().any(|&s| !self.decompositions.of(s).is_empty()) {
                    break;
                }
                *word = self.step(&self.decompositions, word, key, limits)?;
            }
        }
        if word.symbols().contains(&CUT) {
            *word = cut(word);
        }
        if word.symbols().iter().any(|s| s.query_name().is_some()) {
            answer(self, word, limits, environment)?;
        }
        Ok(())
    }

    fn step(&self, rules: &Rules, word: &Word, key: Key, limits: &Limits) -> Result<Word> {
        let has_context = |r: &Rule| !r.left.is_empty() || !r.right.is_empty();
        let with_contexts = word.symbols().iter().any(|&s| rules.of(s).iter().any(has_context));
        let surroundings = Surroundings::new(word, &self.ignored, with_contexts);
        let budget = Budget::new(limits);
        let parts: Result<Vec<Word>> = (0..word.len().div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let (mut part, mut writer) = (Word::default(), Writer::new(rules, key));
                for at in task * TASK..((task + 1) * TASK).min(word.len()) {
                    writer.replace(word, &surroundings, at, &mut part, &budget)?;
                }
                Ok(part)
            })
            .collect();
        let parts = parts?;
        if let [_] = parts[..] {
            return Ok(parts.into_iter().next().unwrap_or_default());
        }
        let mut whole = Word::default();
        parts.iter().for_each(|p| whole.append(p));
        Ok(whole)
    }
}

/// Replaces modules by a set of rules.
pub(super) struct Writer<'a> {
    rules: &'a Rules,
    key: Key,
    values: Vec<f64>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(rules: &'a Rules, key: Key) -> Self {
        Self { rules, key, values: Vec::new() }
    }

    /// Writes what becomes of module `at`; itself if no rule fits. True if a rule did.
    pub(super) fn replace(
        &mut self,
        word: &Word,
        surroundings: &Surroundings<'_>,
        at: usize,
        out: &mut Word,
        budget: &Budget,
    ) -> Result<bool> {
        let mut draws = 0;
        let key = self.key;
        let mut random = || {
            draws += 1;
            // Every module has its own numbers, however many its neighbours need.
            let one = Key { low: key.low.wrapping_add(0x9e37_79b9u32.wrapping_mul(draws)), high: key.high };
            f64::from(unit::<f32>(hash(one, at as u32)))
        };
        let symbol = word.symbols()[at];
        let Some(rule) = choose(self.rules.of(symbol), surroundings, at, &mut self.values, &mut random) else {
            let numbers = word.numbers(at);
            budget.take(Word::MODULE_BYTES + size_of_val(numbers))?;
            out.push(symbol, numbers.iter().copied());
            return Ok(false);
        };
        let numbers: usize = rule.successor.iter().map(|m| m.1.len()).sum();
        budget.take(rule.successor.len() * Word::MODULE_BYTES + numbers * size_of::<f64>())?;
        let mut scope = Scope { values: &self.values, random: &mut random };
        for (symbol, expressions) in &rule.successor {
            out.push(*symbol, expressions.iter().map(|e| e.evaluate(&mut scope)));
        }
        Ok(true)
    }
}

/// The first rule that fits; if it has a weight, one of all fitting rules with weights, by chance.
fn choose<'r>(
    rules: &'r [Rule],
    surroundings: &Surroundings<'_>,
    at: usize,
    values: &mut Vec<f64>,
    random: &mut dyn FnMut() -> f64,
) -> Option<&'r Rule> {
    let mut weighted: Vec<(&Rule, f64)> = Vec::new();
    for rule in rules {
        if !weighted.is_empty() && rule.weight.is_none() || !surroundings.fits(rule, at, values) {
            continue;
        }
        let mut scope = Scope { values, random };
        if rule.condition.as_ref().is_some_and(|c| c.evaluate(&mut scope) == 0.0) {
            continue;
        }
        match &rule.weight {
            None => return Some(rule),
            Some(w) => weighted.push((rule, w.evaluate(&mut scope).max(0.0))),
        }
    }
    let total: f64 = weighted.iter().map(|w| w.1).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut left = random() * total;
    let chosen = weighted.iter().find(|(_, w)| {
        left -= w;
        left < 0.0
    });
    let rule = chosen.or(weighted.iter().rfind(|w| w.1 > 0.0))?.0;
    surroundings.fits(rule, at, values).then_some(rule)
}

/// The word without cut signs and the rest of their branches.
fn cut(word: &Word) -> Word {
    let (mut kept, mut i) = (Word::default(), 0);
    while i < word.len() {
        if word.symbols()[i] != CUT {
            kept.push(word.symbols()[i], word.numbers(i).iter().copied());
            i += 1;
            continue;
        }
        let mut depth = 0;
        while i < word.len() {
            match word.symbols()[i] {
                OPEN => depth += 1,
                CLOSE if depth == 0 => break,
                CLOSE => depth -= 1,
                _ => {}
            }
            i += 1;
        }
    }
    kept
}
