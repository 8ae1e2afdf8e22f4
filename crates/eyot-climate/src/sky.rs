//! Sun, seasons and latitudes: what depends on the row and the hour alone.

use crate::units::hours_per_step;
use eyot_core::process::Moment;
use eyot_core::real::Real;
use eyot_core::{Grid, math};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The year. Processes of one world should agree about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Seasons {
    /// Tilt of the axis: how far from the equator the noon sun wanders in a year. 0 makes no seasons.
    #[schemars(range(min = 0.0, max = 90.0), extend("unit" = "degree", "shared" = true))]
    pub tilt: f32,
    /// Length of a year. Forty days are as short as air can follow: it crosses a continent in ten, and in a shorter
    /// year rain would come a season late. Land, sea and soil store for a matching time. 0 stops the sun at the northern
    /// spring.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "h", "shared" = true))]
    pub year: f32,
}

impl Default for Seasons {
    fn default() -> Self {
        Self { tilt: 23.4, year: 960.0 }
    }
}

impl Seasons {
    /// Time of the year at this moment: 0 in the northern spring, pi / 2 in its summer, rad.
    pub fn phase(&self, moment: &Moment) -> f32 {
        if self.year > 0.0 { turned(hours(moment), TAU / f64::from(self.year)) } else { 0.0 }
    }

    /// Latitude at which the noon sun stands overhead, rad.
    pub fn declination(&self, moment: &Moment) -> f32 {
        // All processes of a world share the tilt, so that it is a number and no expression.
        self.tilt.to_radians() * math::sin(self.phase(moment))
    }
}

/// Hours of weather before this moment.
pub fn hours(moment: &Moment) -> f64 {
    hours_per_step(&moment.grid) * moment.step as f64
}

/// The angle after so many hours at this speed, within a turn, rad.
pub fn turned(hours: f64, radians_per_hour: f64) -> f32 {
    (hours * radians_per_hour).rem_euclid(TAU) as f32
}

/// Parameters of [`latitude`]: the number of rows, and the latitude of half a row, rad.
pub(crate) fn rows(grid: &Grid) -> (f32, f32) {
    (grid.height as f32, (FRAC_PI_2 / grid.height as f64) as f32)
}

/// Latitude of the middle of row `y`, rad, north positive. Rows that mirror each other have opposite ones to the bit:
/// whole numbers are subtracted before anything is rounded.
#[inline(always)]
pub(crate) fn latitude<R: Real>(rows: R, half_row: R, y: R) -> R {
    (((rows - R::of(1.0)) - (y + y)) * half_row).no_contract()
}

/// Latitude of the southern edge of row `y`, rad.
#[inline(always)]
pub(crate) fn edge_latitude<R: Real>(rows: R, half_row: R, y: R) -> R {
    (((rows - R::of(2.0)) - (y + y)) * half_row).no_contract()
}

/// How much colder the sun's way over the sky makes it, from 0 where it passes overhead at noon to 2 where it stays on the
/// horizon, by the sine of the angle between: even within the tropics, steep in the middle latitudes.
#[inline(always)]
pub(crate) fn polewards<R: Real>(s: R) -> R {
    let s2 = (s * s).no_contract();
    s2 + (s2 * s2).no_contract()
}

/// How much of the storms of the middle latitudes there is, 0..=1: most at 45 degrees, next to none within the tropics and
/// around the poles.
#[inline(always)]
pub(crate) fn storminess<R: Real>(latitude: R) -> R {
    let s = sine(latitude);
    let s2 = (s * s).no_contract();
    // The square of the sine of twice the latitude.
    let square = R::of(4.0) * s2 * (R::of(1.0) - s2);
    (square * square).no_contract()
}

/// Sine of an angle within a quarter turn of 0, rad; error at most 4e-6. The general function takes four times as long.
#[inline(always)]
pub(crate) fn sine<R: Real>(x: R) -> R {
    let x2 = x * x;
    // Winds are made of small differences of what is made of this.
    let p = (R::of(2.755_731_9e-6) * x2).no_contract() + R::of(-1.984_127e-4);
    let p = (p * x2).no_contract() + R::of(8.333_333e-3);
    let p = (p * x2).no_contract() + R::of(-1.666_666_7e-1);
    x + (x * x2 * p).no_contract()
}

/// Cosine of an angle of some turns, rad; error at most 5e-6.
#[inline(always)]
pub(crate) fn cosine<R: Real>(x: R) -> R {
    let turns = ((x * R::of(1.0 / std::f32::consts::TAU)).no_contract() + R::of(0.5)).floor();
    let within = x - (turns * R::of(std::f32::consts::TAU)).no_contract();
    sine(R::of(std::f32::consts::FRAC_PI_2) - within.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_good_enough() {
        for i in -2000..=2000 {
            let x = i as f32 * 0.006;
            assert!((f64::from(cosine(x)) - f64::from(x).cos()).abs() < 5e-6, "{x}");
            let x = i as f32 * std::f32::consts::FRAC_PI_2 / 2000.0;
            assert!((f64::from(sine(x)) - f64::from(x).sin()).abs() < 4e-6, "{x}");
        }
    }
}
