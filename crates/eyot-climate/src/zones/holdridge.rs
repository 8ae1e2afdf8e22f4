//! Holdridge's life zones and humidity provinces by their own limits.

use super::exceeded;
use super::source::{POLAR_DESERT, in_belt};
use eyot_core::layer::{Class, class};
use eyot_core::real::Real;

/// Potential evapotranspiration of a degree of biotemperature, mm a year.
const PET_PER_DEGREE: f32 = 58.93;

/// Names and colours of the humidity provinces.
pub const HOLDRIDGE_PROVINCES: &[Class] = &[
    class("ocean", [0, 0, 102]),
    class("superarid", [240, 214, 140]),
    class("perarid", [232, 220, 130]),
    class("arid", [214, 222, 120]),
    class("semiarid", [178, 214, 110]),
    class("subhumid", [130, 200, 110]),
    class("humid", [80, 180, 120]),
    class("perhumid", [40, 150, 140]),
    class("superhumid", [20, 110, 150]),
];

/// Mean over the year of the temperature within 0..=30 degrees, for a year that swings by `swing` about `mean`: six
/// pairs of months.
#[inline(always)]
pub fn biotemperature<R: Real>(mean: R, swing: R) -> R {
    let mut sum = R::of(0.0);
    for cosine in [0.965_925_8, std::f32::consts::FRAC_1_SQRT_2, 0.258_819_04] {
        let step = swing * R::of(cosine);
        sum = sum + (growing(mean + step) + growing(mean - step));
    }
    sum * R::of(1.0 / 6.0)
}

/// Temperature in which plants grow.
#[inline(always)]
fn growing<R: Real>(celsius: R) -> R {
    celsius.clamp(R::of(0.0), R::of(30.0))
}

/// The life zone by biotemperature (degrees) and precipitation (mm a year). Below 1.5 degrees it is polar desert.
#[inline(always)]
pub fn life_zone<R: Real>(biotemperature: R, precipitation: R) -> R {
    let belt = exceeded(biotemperature, [3.0, 6.0, 12.0, 18.0, 24.0]);
    let class = in_belt(belt, exceeded(precipitation, [125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0]));
    biotemperature.gt(R::of(1.5)).pick(class, R::of(POLAR_DESERT))
}

/// The humidity province by the ratio of potential evapotranspiration to precipitation: 1 superarid to 8 superhumid.
#[inline(always)]
pub fn province<R: Real>(biotemperature: R, precipitation: R) -> R {
    // Rain against the evaporation over each limit needs no division, and no rain at all is superarid.
    let pet = R::of(PET_PER_DEGREE) * biotemperature;
    let mut class = R::of(1.0);
    for ratio in [16.0, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25] {
        class = class + (R::of(ratio) * precipitation).gt(pet).one();
    }
    class
}
