//! The ledger: what entered, left, moved and was clamped, account by account.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Accounts that several processes keep: what one of them lets in, another may let out.
pub mod known {
    use crate::rule::{Tally, TallyUnit};

    const fn thickness(account: &'static str, sign: i8, meaning: &'static str) -> Tally {
        Tally { account, unit: TallyUnit::Thickness, sign, meaning }
    }

    /// Rain.
    pub const RAIN: Tally = thickness("water.rain", 1, "Rain that fell");
    /// Water that dried.
    pub const EVAPORATED: Tally = thickness("water.evaporated", -1, "Water that evaporated");
    /// Water that left.
    pub const DRAINED: Tally = thickness("water.drained", -1, "Water that reached the sea or left over an open rim");
    /// Ground out of nothing, or into it.
    pub const GROUND_ROUNDED: Tally =
        thickness("ground.rounded", 1, "Ground that rounding of heights made, or lost where negative");
    /// Water out of nothing.
    pub const WATER_CLAMPED: Tally =
        thickness("water.clamped", 1, "Water added where rounding had made a depth negative");
}

/// Accounts by name, for example `water.rain` (m3) or `hydraulic.dig_limited` (m3).
///
/// Amounts are volumes in m3 unless the account's unit says otherwise. An account's name starts with what it belongs to.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Ledger {
    accounts: BTreeMap<String, Account>,
}

/// One account of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Account {
    /// Sum so far.
    pub amount: f64,
    /// Unit of the sum.
    pub unit: String,
    /// One sentence: what is counted here.
    pub meaning: String,
    /// +1 if it adds to the material before the dot, -1 if it takes away, 0 if it only reports (clamps, moves).
    pub sign: i8,
}

impl Ledger {
    /// Adds `amount` to an account, which is opened if need be.
    pub fn add(&mut self, name: &str, amount: f64, unit: &str, meaning: &str, sign: i8) {
        match self.accounts.get_mut(name) {
            Some(a) => a.amount += amount,
            None => {
                let account = Account { amount, unit: unit.to_owned(), meaning: meaning.to_owned(), sign };
                self.accounts.insert(name.to_owned(), account);
            }
        }
    }

    /// Makes `amount` the sum of an account, which is opened if need be.
    pub fn set(&mut self, name: &str, amount: f64, unit: &str, meaning: &str, sign: i8) {
        let account = Account { amount, unit: unit.to_owned(), meaning: meaning.to_owned(), sign };
        self.accounts.insert(name.to_owned(), account);
    }

    /// Amount of an account, 0 if it was never opened.
    pub fn amount(&self, name: &str) -> f64 {
        self.accounts.get(name).map_or(0.0, |a| a.amount)
    }

    /// Net gain of a material over all its accounts, m3.
    pub fn net(&self, material: &str) -> f64 {
        self.accounts
            .iter()
            .filter(|(n, _)| n.split_once('.').is_some_and(|(m, _)| m == material))
            .map(|(_, a)| f64::from(a.sign) * a.amount)
            .sum()
    }

    /// All accounts by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Account)> {
        self.accounts.iter().map(|(n, a)| (n.as_str(), a))
    }
}
