//! Names that come from a text and live as long as the program, as those of rules in Rust do.
//!
//! Rules, layers and accounts are named by `&'static str`s, which engines copy and compare freely. A name from a recipe is kept
//! once and never given back, so that many recipes with the same names cost no more than one.

use crate::error::{Error, Result};
use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};

/// Most names of one program.
const MOST: usize = 1 << 16;
/// Longest name, bytes.
const LONGEST: usize = 256;

/// `name`, kept for the rest of the program.
///
/// # Errors
/// If it is longer than 256 bytes, or if there are 65536 others already.
pub fn intern(name: &str) -> Result<&'static str> {
    static NAMES: Mutex<Option<HashSet<&'static str>>> = Mutex::new(None);
    let too_many = |what: &str, needed: usize, limit: usize| Error::Limit {
        what: what.to_owned(),
        needed: needed.to_string(),
        limit: limit.to_string(),
        remedy: "use fewer and shorter names, or start the program anew".into(),
    };
    if name.len() > LONGEST {
        return Err(too_many("the bytes of a name", name.len(), LONGEST));
    }
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let names = names.get_or_insert_with(HashSet::new);
    if let Some(known) = names.get(name) {
        return Ok(known);
    }
    if names.len() >= MOST {
        return Err(too_many("the names of all recipes so far", names.len() + 1, MOST));
    }
    let kept: &'static str = Box::leak(name.to_owned().into_boxed_str());
    names.insert(kept);
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_kept_once() {
        let (a, b) = (intern("once").unwrap(), intern(&["on", "ce"].concat()).unwrap());
        assert!(std::ptr::eq(a, b));
        assert!(intern(&"x".repeat(257)).is_err());
    }
}
