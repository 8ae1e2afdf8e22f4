//! Accounts of the ledger whose sums grow on the card.

use eyot_core::Ledger;
use eyot_core::rule::{Tally, TallyUnit};

/// An account of the ledger whose sum grows on the card.
pub(super) struct Account {
    pub(super) tally: Tally,
    /// What it held before.
    pub(super) before: f64,
    /// What was last written to the ledger.
    pub(super) written: f64,
}

impl Account {
    /// Makes the ledger's amount what there was before and the sum on the card. Written like this, and not as what the sum has grown
    /// by since the last time, it does not depend on how often somebody has looked.
    pub(super) fn post(&mut self, ledger: &mut Ledger, total: f64, area: f64) {
        let t = &self.tally;
        let (scale, unit) = match t.unit {
            TallyUnit::Thickness => (area, "m3"),
            TallyUnit::Count => (1.0, "1"),
        };
        // Actions keep accounts, too.
        self.before += ledger.amount(t.account) - self.written;
        self.written = self.before + scale * total;
        ledger.set(t.account, self.written, unit, t.meaning, t.sign);
    }
}
