//! Gradient noise for colours, waves and clouds: a pure function of position and seed.

use crate::{fade, fade_slope, floor};

/// The same functions for shaders: `hash`, `gradient`, `noise_with_slope`, `noise` and `fbm`.
pub const WGSL: &str = include_str!("picture.wgsl");

/// Integer hash of a lattice point.
#[inline]
pub fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut h =
        (x as u32).wrapping_mul(0x8da6_b343) ^ (y as u32).wrapping_mul(0xd816_3841) ^ seed.wrapping_mul(0xcb1a_b31f);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// Sixteen unit directions that avoid the axes, so that the lattice leaves no crosses.
const GRADIENTS: [[f32; 2]; 16] = {
    const A: [f32; 4] = [0.980_785_3, 0.831_469_6, 0.555_570_24, 0.195_090_32];
    let mut g = [[0.0; 2]; 16];
    let mut i = 0;
    while i < 4 {
        let (c, s) = (A[i], A[3 - i]);
        g[4 * i] = [c, s];
        g[4 * i + 1] = [-s, c];
        g[4 * i + 2] = [-c, -s];
        g[4 * i + 3] = [s, -c];
        i += 1;
    }
    g
};

/// Gradient noise in about -1..1 with its two derivatives.
#[inline]
pub fn noise_with_slope(x: f32, y: f32, seed: u32) -> (f32, f32, f32) {
    let (ix, iy) = (floor(x), floor(y));
    let (u, v) = (x - ix as f32, y - iy as f32);
    let g = |dx: i32, dy: i32| GRADIENTS[(hash(ix.wrapping_add(dx), iy.wrapping_add(dy), seed) & 15) as usize];
    let (ga, gb, gc, gd) = (g(0, 0), g(1, 0), g(0, 1), g(1, 1));
    let a = ga[0] * u + ga[1] * v;
    let b = gb[0] * (u - 1.0) + gb[1] * v;
    let c = gc[0] * u + gc[1] * (v - 1.0);
    let d = gd[0] * (u - 1.0) + gd[1] * (v - 1.0);
    let (su, sv, du, dv) = (fade(u), fade(v), fade_slope(u), fade_slope(v));
    let k = a - b - c + d;
    let value = a + su * (b - a) + sv * (c - a) + su * sv * k;
    let corner =
        |i: usize| ga[i] + su * (gb[i] - ga[i]) + sv * (gc[i] - ga[i]) + su * sv * (ga[i] - gb[i] - gc[i] + gd[i]);
    let slope_x = corner(0) + du * (b - a + sv * k);
    let slope_y = corner(1) + dv * (c - a + su * k);
    // Gradient noise rarely passes 0.7.
    (1.4 * value, 1.4 * slope_x, 1.4 * slope_y)
}

/// Gradient noise in about -1..1.
#[inline]
pub fn noise(x: f32, y: f32, seed: u32) -> f32 {
    noise_with_slope(x, y, seed).0
}

/// `octaves` of noise, each turned against the last by an angle that no lattice repeats; about -1..1.
#[inline]
pub fn fbm(mut x: f32, mut y: f32, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut amplitude) = (0.0, 0.5);
    for i in 0..octaves {
        sum += amplitude * noise(x, y, seed.wrapping_add(i));
        amplitude *= 0.5;
        // 2.03 times a turn by 37 degrees.
        (x, y) = (1.621 * x - 1.222 * y + 17.3, 1.222 * x + 1.621 * y - 9.1);
    }
    sum
}
