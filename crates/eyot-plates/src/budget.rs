//! Where crust came from and where it went.

use crate::crust::UNITS_PER_M;
use eyot_core::Ledger;

/// Sums of thickness over cells, in units, so exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Budget {
    /// There when the plates were made.
    pub start: i64,
    /// New at mid-ocean ridges.
    pub ridges: i64,
    /// New in volcanoes behind trenches.
    pub arcs: i64,
    /// Sunk into the mantle at trenches.
    pub subducted: i64,
    /// Sunk into the mantle because no column can be as high.
    pub delaminated: i64,
    /// Added by others that raised the land.
    pub deposited: i64,
    /// Taken by others that lowered the land.
    pub removed: i64,
    /// Moved out over an open rim.
    pub left: i64,
}

impl Budget {
    /// What must be there.
    pub fn net(&self) -> i64 {
        self.start + self.ridges + self.arcs + self.deposited
            - self.subducted
            - self.delaminated
            - self.removed
            - self.left
    }

    /// Adds everything to the accounts of a ledger.
    pub(crate) fn post(&self, ledger: &mut Ledger, cell_area_m2: f64) {
        let accounts = [
            ("crust.start", self.start, "Crust at the beginning", 1),
            ("crust.ridges", self.ridges, "New crust at mid-ocean ridges", 1),
            ("crust.arcs", self.arcs, "New crust in volcanoes behind trenches", 1),
            ("crust.deposited", self.deposited, "Crust under land that other processes raised, its root included", 1),
            ("crust.subducted", self.subducted, "Crust that sank into the mantle at trenches", -1),
            ("crust.delaminated", self.delaminated, "Crust that sank because no column can be as high", -1),
            ("crust.removed", self.removed, "Crust under land that other processes lowered, its root included", -1),
            ("crust.left", self.left, "Crust that moved out over an open rim", -1),
        ];
        for (name, units, meaning, sign) in accounts.into_iter().filter(|a| a.1 != 0) {
            ledger.add(name, units as f64 / f64::from(UNITS_PER_M) * cell_area_m2, "m3", meaning, sign);
        }
    }
}
