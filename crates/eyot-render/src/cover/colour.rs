//! Colours of the classes: no ground is one flat colour.

use super::palette::Pairs;
use super::strip::Site;
use super::{Class, Cover, Weights};
use crate::math::{V3, add, mix, scale, smoothstep};
use eyot_noise::picture::{hash, noise};

/// Thickness of beds of rock, m, and in cells where these are larger.
const BED_M: f32 = 42.0;
const BED_CELLS: f32 = 0.9;

/// How much of bare rock's colour is that of its kind.
const ROCK: f32 = 0.9;

impl Cover {
    /// The colour of a place with these classes.
    pub(super) fn coloured(&self, s: &Site, w: &Weights) -> V3 {
        let k = &self.tints;
        let mut pairs = k.pairs;
        let mut beds = k.beds;
        let mut towards = |other: &super::palette::Kind, share: f32| {
            if share > 0.0 {
                blend(&mut pairs, &other.pairs, share);
                beds.iter_mut().zip(other.beds).for_each(|(b, o)| *b = mix(*b, o, share));
            }
        };
        if let Some((t, _)) = s.climate {
            towards(&k.cold, smoothstep(5.0, -3.0, t));
            towards(&k.hot, smoothstep(16.0, 24.0, t));
        }
        towards(&k.arid, s.aridity);
        // Living ground changes over hills, stone from place to place.
        let green = smoothstep(-0.40, 0.40, 0.8 * s.broad + 0.5 * s.region + 0.5 * s.fine - 0.12 * s.hollow);
        let stone = smoothstep(-0.35, 0.35, s.fine + 0.4 * s.broad);
        let mut c = [0.0; 3];
        for (class, (&w, pair)) in Class::ALL.into_iter().zip(w.iter().zip(&pairs)) {
            if w <= 0.0 {
                continue;
            }
            let of = match class {
                Class::Rock if s.z > 0.0 || !self.sea => {
                    let share = if s.rock.is_some() { ROCK } else { 0.62 };
                    mix(mix(pair[0], pair[1], stone), self.rock(s, &beds), share)
                }
                Class::Scree => {
                    let share = if s.rock.is_some() { 0.6 } else { 0.22 };
                    mix(mix(pair[0], pair[1], stone), self.rock(s, &beds), share)
                }
                Class::Soil => {
                    let soil = mix(pair[0], pair[1], green);
                    s.rock.map_or(soil, |rock| mix(soil, rock, 0.55))
                }
                Class::Reef | Class::Rock | Class::Gravel | Class::Weed => mix(pair[0], pair[1], stone),
                Class::Snow => mix(pair[0], pair[1], smoothstep(-0.2, 0.6, s.shade + 0.4 * s.broad)),
                _ => mix(pair[0], pair[1], green),
            };
            c = add(c, scale(of, w));
        }
        if !self.looks.ramp.is_empty() {
            c = self.ramped(s, w, c);
        }
        let bright = w[Class::Snow as usize];
        // Land far and wide is a little warmer here and cooler there.
        let drift = 0.07 * s.region * (1.0 - bright);
        let even = 1.0 - 0.85 * bright;
        scale([c[0] * (1.0 + drift), c[1], c[2] * (1.0 - drift)], 1.0 + even * (0.13 * s.fine + 0.11 * s.broad))
    }

    /// Colours of the land by its height in the place of those of its classes.
    fn ramped(&self, s: &Site, w: &Weights, c: V3) -> V3 {
        let ramp = &self.looks.ramp;
        let above = ramp.partition_point(|(z, _)| *z <= s.z);
        let land = match (above.checked_sub(1).map(|i| ramp[i]), ramp.get(above)) {
            (Some((low, a)), Some((high, b))) => mix(a, *b, (s.z - low) / (high - low).max(1e-6)),
            (Some((_, a)), None) => a,
            (None, first) => first.map_or(c, |(_, b)| *b),
        };
        let wet: f32 =
            [Class::DeepSea, Class::SeaFloor, Class::Weed, Class::Reef].iter().map(|class| w[*class as usize]).sum();
        mix(land, c, wet.min(1.0))
    }

    /// The colour of the rock: what the world says, with a breath of thin beds, or beds that are made up.
    fn rock(&self, s: &Site, beds: &[V3; 5]) -> V3 {
        let bed = self.bed(s, beds);
        s.rock.map_or(bed, |rock| {
            let light = |c: V3| (c[0] + c[1] + c[2]) / 3.0;
            let mean = beds.iter().map(|&b| light(b)).sum::<f32>() / beds.len() as f32;
            scale(rock, 1.0 + 0.35 * (light(bed) / mean.max(1e-3) - 1.0))
        })
    }

    /// The colour of a bed of rock, with a short passage from one to the next. Beds lie nearly level, so that all walls show them at
    /// the same height.
    fn bed(&self, s: &Site, beds: &[V3; 5]) -> V3 {
        let thick = BED_M.max(BED_CELLS * self.cell[0].min(self.cell[1]));
        let height = (s.z + self.datum) / thick + 0.35 * s.broad + 0.9 * s.region + 0.15 * s.fine;
        let one = |height: f32| {
            let i = height.floor();
            let pick = |i: f32| {
                let c = beds[hash(i as i32, 11, 23) as usize % beds.len()];
                scale(c, 1.0 + 0.14 * noise(0.37 * i, 5.2, 31))
            };
            mix(pick(i), pick(i + 1.0), smoothstep(0.75, 1.0, height - i))
        };
        mix(one(height), one(4.3 * height + 0.37), 0.3)
    }
}

fn blend(pairs: &mut Pairs, other: &Pairs, share: f32) {
    for (pair, other) in pairs.iter_mut().zip(other) {
        *pair = [mix(pair[0], other[0], share), mix(pair[1], other[1], share)];
    }
}
