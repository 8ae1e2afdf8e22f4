//! The source's table: six belts of temperature with four to eight classes of humidity, and four kinds of water.

use super::exceeded;
use eyot_core::layer::{Class, class};
use eyot_core::real::Real;

/// Number of the sea.
pub(crate) const OCEAN: f32 = 0.0;
/// Number of lakes.
pub(crate) const LAKE: f32 = 1.0;
/// Number of rivers.
pub(crate) const RIVER: f32 = 2.0;
/// Number of land under ice.
pub(crate) const POLAR_DESERT: f32 = 3.0;

/// Number of the first class of each belt, from the coldest on; the one after the last belt ends it.
pub(crate) const FIRST: [f32; 7] = [4.0, 8.0, 13.0, 19.0, 26.0, 33.0, 41.0];

/// Names and colours: those of Holdridge's triangle, ocean, lake, river and polar desert in the source's.
pub const SOURCE_ZONES: &[Class] = &[
    class("ocean", [0, 0, 102]),
    class("lake", [0, 0, 204]),
    class("river", [0, 102, 204]),
    class("polar desert", [255, 255, 255]),
    class("subpolar dry tundra", [128, 128, 128]),
    class("subpolar moist tundra", [96, 128, 128]),
    class("subpolar wet tundra", [64, 128, 144]),
    class("subpolar rain tundra", [32, 128, 192]),
    class("boreal desert", [160, 160, 128]),
    class("boreal dry scrub", [128, 160, 128]),
    class("boreal moist forest", [96, 160, 128]),
    class("boreal wet forest", [64, 160, 144]),
    class("boreal rain forest", [32, 160, 192]),
    class("cool temperate desert", [192, 192, 128]),
    class("cool temperate desert scrub", [160, 192, 128]),
    class("cool temperate steppe", [128, 192, 128]),
    class("cool temperate moist forest", [96, 192, 128]),
    class("cool temperate wet forest", [64, 192, 144]),
    class("cool temperate rain forest", [32, 192, 192]),
    class("warm temperate desert", [224, 224, 128]),
    class("warm temperate desert scrub", [192, 224, 128]),
    class("warm temperate thorn scrub", [160, 224, 128]),
    class("warm temperate dry forest", [128, 224, 128]),
    class("warm temperate moist forest", [96, 224, 128]),
    class("warm temperate wet forest", [64, 224, 144]),
    class("warm temperate rain forest", [32, 224, 192]),
    class("subtropical desert", [240, 240, 128]),
    class("subtropical desert scrub", [208, 240, 128]),
    class("subtropical thorn woodland", [176, 240, 128]),
    class("subtropical dry forest", [128, 240, 128]),
    class("subtropical moist forest", [96, 240, 128]),
    class("subtropical wet forest", [64, 240, 144]),
    class("subtropical rain forest", [32, 240, 176]),
    class("tropical desert", [255, 255, 128]),
    class("tropical desert scrub", [224, 255, 128]),
    class("tropical thorn woodland", [192, 255, 128]),
    class("tropical very dry forest", [160, 255, 128]),
    class("tropical dry forest", [128, 255, 128]),
    class("tropical moist forest", [96, 255, 128]),
    class("tropical wet forest", [64, 255, 144]),
    class("tropical rain forest", [32, 255, 160]),
];

/// The number of the class in belt `belt` (0 the coldest) and column `column` (0 the driest); wetter ones than the belt
/// has count as its last.
#[inline(always)]
pub(crate) fn in_belt<R: Real>(belt: R, column: R) -> R {
    let (mut first, mut last) = (R::of(FIRST[0]), R::of(FIRST[1] - 1.0));
    for i in 1..6 {
        let here = belt.gt(R::of(i as f32 - 0.5));
        first = here.pick(R::of(FIRST[i]), first);
        last = here.pick(R::of(FIRST[i + 1] - 1.0), last);
    }
    (first + column).min(last)
}

/// The class of land without ice by abstract temperature and humidity.
#[inline(always)]
pub fn source_zone<R: Real>(temperature: R, humidity: R) -> R {
    let belt = exceeded(temperature, [-0.8, -0.3, 0.0, 0.25, 0.5]);
    in_belt(belt, exceeded(humidity, [0.1, 0.25, 0.35, 0.5, 0.6, 0.75, 0.8]))
}
