//! Meanders: bends that grow and wander where a river runs slowly through a wide valley.
//!
//! # Equations
//! With `C` the curvature, `W` the width, `s` the way along the line, `xi` the way upstream:
//! 1. `R0 = k W C`, `k = 60 m a year`: how fast a bend would move if it stood alone.
//! 2. `R = sinuosity^(-2/3) (-R0 + 2.5 <R0>)`, `<R0>` the mean of `R0` upstream with weights `exp(-2 C_f xi / D)`, `C_f = 0.011`. The sum over
//!    all that lies upstream is a recursive filter, `I_i = e^(-a ds) I_(i-1) + R0_i ds`, one step a vertex.
//! 3. Vertices move along their normals, `p' = p + R dt n`, by at most half their distance. Where two banks come closer than the river is
//!    wide, the bend between them is cut off and stays as an oxbow lake.
//!
//! Ends stay where they are, since other reaches meet there; where the ground beside the river is no flood plain it stays, too.
//!
//! # Source
//! Howard & Knutson (1984), Sufficient conditions for river meandering: a simulation approach, Water Resources Research 20, 1659-1667;
//! Paris et al. (2023), Authoring and simulating meandering rivers, ACM Transactions on Graphics 42, article 241.
//!
//! # Differences
//! `D` of equation 2 is a 32nd of the width, as in rivers that meander, whatever depth the river is drawn with: wavelengths then are
//! about eleven widths.

use crate::lines::{distance, length, resampled, smooth};

/// Speed of a bend, m a year.
const SPEED: f64 = 60.0;
/// Weight of what lies upstream.
const UPSTREAM: f64 = 2.5;
/// Friction.
const FRICTION: f64 = 0.011;
/// Width of a meandering river over its depth.
const WIDTH_OVER_DEPTH: f64 = 32.0;
/// Distance of vertices, widths.
const SPACING: f64 = 1.0;
/// Distance of banks below which a bend is cut off, widths.
const CUT_OFF: f64 = 1.5;
/// Length of a step for a metre of width, years: bends of wide rivers move no faster than those of narrow ones.
const STEP_YEARS: f64 = 0.005;
/// Steps at most: a river on a narrow plain never winds as much as was asked for.
const STEPS: usize = 600;

/// A river's line after it has wandered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Meandered {
    /// Its vertices, about a width apart; the first and the last as they were.
    pub line: Vec<[f64; 2]>,
    /// Bends that were cut off.
    pub oxbows: Vec<Vec<[f64; 2]>>,
}

/// Lets the river `line` of `width_m` wander until it is `sinuosity` times as long as the straight way, at most for 600 steps.
/// `plain(p)`: whether the place `p` is flood plain; a river does not move off it.
pub fn meander(line: &[[f64; 2]], width_m: f64, sinuosity: f64, plain: impl Fn([f64; 2]) -> bool) -> Meandered {
    let spacing = SPACING * width_m;
    let mut found = Meandered { line: resampled(line, spacing), oxbows: Vec::new() };
    for step in 0..STEPS {
        if found.line.len() < 8 || winding(&found.line, width_m) >= sinuosity {
            break;
        }
        found.line = resampled(&moved(&found.line, width_m, &plain), spacing);
        // Banks draw near slowly.
        if step % 8 == 7 {
            cut_off(&mut found, width_m);
        }
    }
    // Where the ground held some vertices and not others, corners are left.
    smooth(&mut found.line);
    found
}

/// Length over the straight way.
fn winding(line: &[[f64; 2]], width_m: f64) -> f64 {
    (length(line) / distance(line[0], line[line.len() - 1]).max(width_m)).max(1.0)
}

/// The line a step later.
fn moved(line: &[[f64; 2]], width_m: f64, plain: &impl Fn([f64; 2]) -> bool) -> Vec<[f64; 2]> {
    let n = line.len();
    let slowed = eyot_core::math64::pow(winding(line, width_m), -2.0 / 3.0);
    let fade = 2.0 * FRICTION * WIDTH_OVER_DEPTH / width_m;
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut out = line.to_vec();
    for i in 1..n - 1 {
        let (a, p, b) = (line[i - 1], line[i], line[i + 1]);
        let ds = distance(a, p).max(1e-6);
        let r0 = SPEED * width_m * curvature(a, p, b);
        let kept = eyot_core::math64::exp(-fade * ds);
        (sum, weight) = (kept * sum + r0 * ds, kept * weight + ds);
        let rate = slowed * (-r0 + UPSTREAM * sum / weight);
        // Other reaches meet the ends.
        let ends = (i.min(n - 1 - i) as f64 / 6.0).min(1.0);
        let most = 0.5 * ds;
        let move_m = (ends * rate * STEP_YEARS * width_m).clamp(-most, most);
        let (tx, ty) = (b[0] - a[0], b[1] - a[1]);
        let size = (tx * tx + ty * ty).sqrt().max(1e-9);
        // Outwards: away from the centre of the bend.
        let to = [p[0] + move_m * ty / size, p[1] - move_m * tx / size];
        if plain(to) {
            out[i] = to;
        }
    }
    out
}

/// Curvature at `p`, 1/m: positive where the line turns clockwise with y to the south, so that its normal to the left is outwards.
fn curvature(a: [f64; 2], p: [f64; 2], b: [f64; 2]) -> f64 {
    let cross = (p[0] - a[0]) * (b[1] - p[1]) - (p[1] - a[1]) * (b[0] - p[0]);
    2.0 * cross / (distance(a, p) * distance(p, b) * distance(a, b)).max(1e-12)
}

/// Takes out bends whose banks have met.
fn cut_off(found: &mut Meandered, width_m: f64) {
    let near = CUT_OFF * width_m;
    // Closer along the line than a bend can be.
    let apart = 8;
    let mut i = 0;
    while i + apart < found.line.len() {
        let meets = (i + apart..found.line.len()).rev().find(|&j| distance(found.line[i], found.line[j]) < near);
        if let Some(j) = meets {
            let bend: Vec<[f64; 2]> = found.line.drain(i + 1..j).collect();
            if bend.len() > 3 {
                found.oxbows.push(bend);
            }
        }
        i += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::rng::{Key, hash, unit};

    /// A straight river with small bends by lot.
    fn straight(width_m: f64, n: usize) -> Vec<[f64; 2]> {
        let key = Key::new(5, 1, 0);
        (0..n).map(|i| [i as f64 * width_m, 0.3 * width_m * f64::from(unit::<f32>(hash(key, i as u32)))]).collect()
    }

    /// Mean way of two crossings of the line from the first to the last vertex, widths.
    fn wavelength(line: &[[f64; 2]], width_m: f64) -> f64 {
        let y: Vec<f64> = line.iter().map(|p| p[1]).collect();
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        let inner = &line[line.len() / 5..line.len() * 4 / 5];
        let crossings = inner.windows(2).filter(|p| (p[0][1] > mean) != (p[1][1] > mean)).count();
        2.0 * (inner[inner.len() - 1][0] - inner[0][0]) / crossings as f64 / width_m
    }

    #[test]
    fn bends_grow_to_wavelengths_of_about_eleven_widths_and_are_cut_off() {
        for width in [5.0, 40.0] {
            let start = straight(width, 400);
            for sinuosity in [1.4, 1.8] {
                let young = meander(&start, width, sinuosity, |_| true);
                let waves = wavelength(&young.line, width);
                assert!((8.0..=14.0).contains(&waves), "{waves} widths at {width} m, {sinuosity}");
                assert!(winding(&young.line, width) < sinuosity + 0.1);
            }
            let old = meander(&start, width, 9.0, |_| true);
            assert!(!old.oxbows.is_empty(), "{}", winding(&old.line, width));
            assert_eq!((old.line[0], old.line[old.line.len() - 1]), (start[0], start[399]));
        }
    }

    #[test]
    fn rivers_stay_on_their_flood_plain() {
        let kept = meander(&straight(20.0, 200), 20.0, 3.0, |p| p[1].abs() < 60.0);
        assert!(kept.line.iter().all(|p| p[1].abs() < 61.0));
    }
}
