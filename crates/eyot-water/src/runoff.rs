//! Runoff: what is left of rain and snow after plants and soil have had theirs.

use eyot_core::math64::exp;

/// Share of the rain that evaporates, by Budyko's curve: `[phi tanh(1 / phi) (1 - exp(-phi))]^(1/2)`. `aridity`: evaporation that heat
/// could drive over the rain, phi >= 0.
pub fn budyko(aridity: f64) -> f64 {
    if aridity <= 0.0 {
        return 0.0;
    }
    let e = exp(-2.0 / aridity);
    let tanh = (1.0 - e) / (1.0 + e);
    (aridity * tanh * (1.0 - exp(-aridity))).sqrt().min(1.0)
}

/// Evaporation that the heat of a place could drive, m a year, by its mean temperature in degrees C: Turc's
/// `0.3 + 0.025 T + 0.00005 T^3`, 0 where that is negative.
pub fn evaporation_of(temperature: f64) -> f64 {
    (0.3 + 0.025 * temperature + 0.000_05 * temperature * temperature * temperature).max(0.0)
}

/// Rain and evaporation of a cell, m a year.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Climate {
    /// Rain and snow.
    pub rain: f64,
    /// What open water loses, and what wet ground could.
    pub evaporation: f64,
}

impl Climate {
    /// What runs off dry land, m a year.
    pub fn runoff(&self) -> f64 {
        (self.rain - self.evaporated()).max(0.0)
    }

    /// What open water loses beyond what the same land would, m a year, >= 0.
    pub fn lake_loss(&self) -> f64 {
        (self.evaporation - self.evaporated()).max(0.0)
    }

    fn evaporated(&self) -> f64 {
        if self.rain > 0.0 { self.rain * budyko(self.evaporation / self.rain) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budyko_keeps_to_both_limits() {
        for phi in [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 50.0] {
            let share = budyko(phi);
            assert!(share <= 1.0 && share <= phi, "phi {phi}: {share}");
        }
        assert!((budyko(1.0) - 0.694).abs() < 1e-3, "the curve at 1");
        let dry = Climate { rain: 0.2, evaporation: 1.8 };
        assert!(dry.runoff() < 0.01 && dry.lake_loss() > 1.6);
    }
}
