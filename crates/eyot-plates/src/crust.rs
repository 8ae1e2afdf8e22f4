//! Thickness of crust, counted so that sums are exact.
//!
//! A thickness is a whole number of units of 1/128 m. Whatever moves crust moves whole units, so nothing is lost to rounding,
//! sums do not depend on their order, and up to 131 km a layer of `f32` holds every value exactly.

/// Units in a metre.
pub const UNITS_PER_M: i32 = 128;
/// Thickness of new oceanic crust, m (White, McKenzie and O'Nions 1992: 7.1 km on average).
pub const OCEANIC_M: f32 = 7_000.0;
/// Crust at least this thick is continental: it cannot sink, m.
pub const CONTINENTAL_M: f32 = 20_000.0;
/// Crust of a continent's lowland, m.
pub const LOWLAND_M: f32 = 36_000.0;
/// No cell may hold more than this, m: what a layer can hold exactly.
pub const HIGHEST_M: f32 = 100_000.0;

/// Units in `metres`, rounded down.
#[inline]
pub(crate) fn units(metres: f32) -> i32 {
    (metres * UNITS_PER_M as f32) as i32
}

/// The whole units that are nearest to a thickness, which is never negative.
#[inline]
pub(crate) fn nearest_units(metres: f32) -> i32 {
    (metres * UNITS_PER_M as f32 + 0.5) as i32
}

/// Metres in `units`, exactly.
#[inline]
pub(crate) fn metres(units: i32) -> f32 {
    units as f32 * (1.0 / UNITS_PER_M as f32)
}

/// True if crust of so many units is continental.
#[inline]
pub(crate) fn is_continental(units: i32) -> bool {
    units >= CONTINENTAL_M as i32 * UNITS_PER_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_hold_every_thickness_exactly() {
        for u in (0..units(HIGHEST_M)).step_by(997) {
            assert_eq!(units(metres(u)), u);
        }
        assert!(is_continental(units(CONTINENTAL_M)) && !is_continental(units(CONTINENTAL_M) - 1));
    }
}
