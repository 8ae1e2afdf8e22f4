//! Braids: the threads of a river that carries more gravel than it can move in one bed.
//!
//! # Rule
//! 1. A reach braids where its slope exceeds `0.0125 Q^-0.44`, `Q` in m3/s, above which Leopold and Wolman found rivers to braid.
//! 2. Two or three threads swing about the reach's line, by `1.6 W` at most and over about `12 W`, `W` the width of the whole river: the
//!    first two against each other, so that they meet where they cross the line, the third twice as often. The swing of each varies along
//!    the way, by lot for each reach. Towards the ends, and where there is no flood plain, threads fall together.
//! 3. Each of `n` threads carries `Q / n`.
//!
//! # Source
//! Leopold & Wolman (1957), River channel patterns: braided, meandering and straight, USGS Professional Paper 282-B; Ashmore (2013),
//! Morphology and dynamics of braided rivers, Treatise on Geomorphology 9, 289-312, for the length and width of bars.
//!
//! # Differences
//! Leopold and Wolman take the bankfull discharge, here it is the mean of the year, which is smaller: fewer reaches braid. Threads do not move.

use crate::lines::{distance, length};
use eyot_core::math64::{pow, sin_degrees as sin};
use eyot_core::rng::{Key, hash, unit};

/// Steeper rivers are torrents and do not braid, 1.
const STEEPEST: f64 = 0.02;
/// Length of a swing, widths.
const WAVE: f64 = 12.0;
/// How far threads swing, widths.
const SWING: f64 = 1.6;
/// Stream of random numbers.
const STREAM: u32 = 0x4252_4149;

/// Whether a river of that slope and discharge (m3/s) braids where it has room.
pub fn braids(slope: f64, discharge: f64) -> bool {
    slope <= STEEPEST && slope > 0.0125 * pow(discharge.max(1e-9), -0.44)
}

/// The threads of the reach along `line` (vertices about a width apart), each with as many vertices. `number` is the reach's own, for its
/// lot. `plain(p)`: whether `p` is flood plain.
pub fn threads(
    line: &[[f64; 2]],
    width_m: f64,
    seed: u64,
    number: u32,
    plain: impl Fn([f64; 2]) -> bool,
) -> Vec<Vec<[f64; 2]>> {
    let lot = |k: u64| f64::from(unit::<f32>(hash(Key::new(seed, STREAM, k), number)));
    let whole = length(line);
    let wave = WAVE * width_m * (0.8 + 0.4 * lot(0));
    let turn = 360.0;
    let swing = |thread: usize, s: f64| {
        let way = turn * s / wave;
        let lag = 0.5 * sin(way / 2.3 + turn * lot(1));
        let size = SWING * width_m * (0.75 + 0.25 * sin(way / 2.7 + turn * lot(2 + thread as u64)));
        size * match thread {
            0 => sin(way),
            1 => -sin(way + lag),
            _ => 0.5 * sin(2.0 * way + turn * lot(5)),
        }
    };
    let last = line.len() - 1;
    let thread = |t: usize| {
        let (mut s, mut off, mut normals) = (0.0, Vec::with_capacity(line.len()), Vec::with_capacity(line.len()));
        for i in 0..=last {
            let (a, b) = (line[i.saturating_sub(1)], line[(i + 1).min(last)]);
            s += if i > 0 { distance(line[i - 1], line[i]) } else { 0.0 };
            let size = distance(a, b).max(1e-9);
            let normal = [(b[1] - a[1]) / size, (a[0] - b[0]) / size];
            let end = (s.min(whole - s) / (0.5 * wave)).clamp(0.0, 1.0);
            let want = swing(t, s) * end * end * (3.0 - 2.0 * end);
            let to = [0, 1].map(|c| line[i][c] + want * normal[c]);
            off.push(if plain(to) { want } else { 0.0 });
            normals.push(normal);
        }
        // Threads turn back to the line smoothly, where there is no plain too.
        for _ in 0..2 {
            let before = off.clone();
            for i in 1..last {
                off[i] = 0.25 * before[i - 1] + 0.5 * before[i] + 0.25 * before[i + 1];
            }
        }
        (0..=last).map(|i| [0, 1].map(|c| line[i][c] + off[i] * normals[i][c])).collect()
    };
    (0..2 + usize::from(lot(6) > 0.4)).map(thread).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steep_rivers_braid_and_threads_meet_at_both_ends() {
        // Leopold and Wolman's line: 0.0125 at 1 m3/s, 0.00165 at 100.
        assert!(braids(0.013, 1.0) && !braids(0.012, 1.0) && braids(0.0017, 100.0) && !braids(0.0016, 100.0));
        assert!(!braids(0.03, 100.0));
        let line: Vec<[f64; 2]> = (0..200).map(|i| [10.0 * f64::from(i), 5.0]).collect();
        for number in 0..20 {
            let found = threads(&line, 10.0, 7, number, |_| true);
            assert!((2..=3).contains(&found.len()));
            for thread in &found {
                assert_eq!((thread[0], thread[199], thread.len()), (line[0], line[199], 200));
                let far = thread.iter().map(|p| (p[1] - 5.0).abs()).fold(0.0, f64::max);
                assert!((3.0..=16.0).contains(&far), "{far}");
            }
            let apart = |i: usize| (found[0][i][1] - found[1][i][1]).abs();
            assert!((20..180).any(|i| apart(i) > 15.0) && (20..180).any(|i| apart(i) < 6.0));
            assert!(threads(&line, 10.0, 7, number, |_| false).iter().all(|t| *t == line));
        }
    }
}
