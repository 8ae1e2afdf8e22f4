//! Gradient noise at one point: Perlin's on squares, simplex on triangles.
//!
//! Both give values within -1..=1 with mean 0, are twice continuously differentiable, and repeat with whole periods of the
//! lattice when asked to. Gradients are pairs of independent uniform numbers, so that no direction is preferred on average
//! and none is missing, as with tables of eight.

use eyot_core::real::{Bits, Real};

/// Position on the lattice of one octave, and the period after which it repeats.
#[derive(Clone, Copy)]
pub(super) struct Place<R> {
    pub(super) x: R,
    pub(super) y: R,
    /// Lattice cells around the world to the east; 0 where it does not repeat.
    pub(super) period_x: R,
    /// Lattice cells around the world to the south; 0 where it does not repeat.
    pub(super) period_y: R,
}

/// Mixes lattice coordinates, already multiplied by [`PRIME_X`] and [`PRIME_Y`], into 32 bits.
#[inline(always)]
fn mixed<B: Bits>(x: B, y: B, seed: B) -> B {
    let h = x.xor(y).xor(seed).mul(B::of(0x27d4_eb2d));
    h.xor(h.shr(15)).mul(B::of(0x85eb_ca6b))
}

const PRIME_X: u32 = 0x1f1b_4df5;
const PRIME_Y: u32 = 0x6f64_05cb;

/// The gradient at a lattice point, times the offset from it. Components are uniform within -32768..32768.
#[inline(always)]
fn slope<R: Real>(h: R::Bits, dx: R, dy: R) -> R {
    // The high bits of a product are the well mixed ones.
    let half = R::of(32768.0);
    let gx = h.shr(16).to_real() - half;
    let gy = h.shr(8).and(R::Bits::of(0xffff)).to_real() - half;
    gx * dx + gy * dy
}

/// `i` modulo the whole `period`, for multiples of a half; `i` itself where the period is 0.
#[inline(always)]
fn around<R: Real, const WRAP: bool>(i: R, period: R) -> R {
    if WRAP {
        let safe = period.max(R::of(1.0));
        // A quarter off, so that rounding cannot push a multiple of the period below; simplex columns are halves.
        let turns = ((i + R::of(0.25)) / safe).floor();
        period.gt(R::of(0.5)).pick(i - turns * safe, i)
    } else {
        i
    }
}

/// Perlin noise: quintic interpolation between the four corners of a square. At most 1.
#[inline(always)]
pub(super) fn perlin<R: Real, const WRAP: bool>(p: Place<R>, seed: u32) -> R {
    let one = R::of(1.0);
    let (x0, y0) = (p.x.floor(), p.y.floor());
    let (dx, dy) = (p.x - x0, p.y - y0);
    let hx0 = hashed_x::<R, WRAP>(x0, p.period_x);
    let hy0 = hashed_y::<R, WRAP>(y0, p.period_y);
    let (hx1, hy1) = if WRAP {
        (hashed_x::<R, WRAP>(x0 + one, p.period_x), hashed_y::<R, WRAP>(y0 + one, p.period_y))
    } else {
        (hx0.add(R::Bits::of(PRIME_X)), hy0.add(R::Bits::of(PRIME_Y)))
    };
    let s = R::Bits::of(seed);
    let a = slope(mixed(hx0, hy0, s), dx, dy);
    let b = slope(mixed(hx1, hy0, s), dx - one, dy);
    let c = slope(mixed(hx0, hy1, s), dx, dy - one);
    let d = slope(mixed(hx1, hy1, s), dx - one, dy - one);
    let (u, v) = (quintic(dx), quintic(dy));
    let north = a + u * (b - a);
    let south = c + u * (d - c);
    // In the middle of a cell with all components at their largest this is 1.
    (north + v * (south - north)) * R::of(1.0 / 32768.0)
}

#[inline(always)]
fn hashed_x<R: Real, const WRAP: bool>(i: R, period: R) -> R::Bits {
    around::<R, WRAP>(i, period).whole().mul(R::Bits::of(PRIME_X))
}

#[inline(always)]
fn hashed_y<R: Real, const WRAP: bool>(i: R, period: R) -> R::Bits {
    around::<R, WRAP>(i, period).whole().mul(R::Bits::of(PRIME_Y))
}

/// `6 t^5 - 15 t^4 + 10 t^3`.
#[inline(always)]
fn quintic<R: Real>(t: R) -> R {
    t * t * t * (t * (t * R::of(6.0) - R::of(15.0)) + R::of(10.0))
}

/// Height of a row of triangles with sides of 1.
pub(super) const ROW: f32 = 0.866_025_4;

/// Simplex noise: the sum of three bumps at the corners of an equilateral triangle.
///
/// Rows of triangles run east and every second row is shifted by half a side, so the pattern repeats after any whole number
/// of columns and any even number of rows (the tiling of Gustavson and McEwan 2022). `y` counts rows, whose distance is
/// [`ROW`]. The node (i, j) lies at column `i - j / 2`.
#[inline(always)]
pub(super) fn simplex<R: Real, const WRAP: bool>(p: Place<R>, seed: u32) -> R {
    let (half, one) = (R::of(0.5), R::of(1.0));
    let skewed = p.x + half * p.y;
    let (i, j) = (skewed.floor(), p.y.floor());
    let (u, v) = (skewed - i, p.y - j);
    let dx = u - half * v;
    // The second corner is one row further where u < v, else one column.
    let further = u.lt(v).one();
    let a = bump::<R, WRAP>(i, j, dx, v, &p, seed);
    let b = bump::<R, WRAP>(i + (one - further), j + further, dx - (one - R::of(1.5) * further), v - further, &p, seed);
    let c = bump::<R, WRAP>(i + one, j + one, dx - half, v - one, &p, seed);
    (a + b + c) * R::of(BUMPS / 32768.0)
}

/// One over the largest sum of three bumps, for gradients that all point at the worst place.
const BUMPS: f32 = 11.67;

#[inline(always)]
fn bump<R: Real, const WRAP: bool>(i: R, j: R, dx: R, dy: R, p: &Place<R>, seed: u32) -> R {
    let dy = dy * R::of(ROW);
    let t = (R::of(0.75) - (dx * dx + dy * dy)).positive();
    let (x, y) = if WRAP {
        let row = around::<R, true>(j, p.period_y);
        // Unskewed, wrapped, and skewed again.
        let column = around::<R, true>(i - R::of(0.5) * j, p.period_x) + R::of(0.5) * row;
        (column, row)
    } else {
        (i, j)
    };
    let h = mixed(x.whole().mul(R::Bits::of(PRIME_X)), y.whole().mul(R::Bits::of(PRIME_Y)), R::Bits::of(seed));
    let t2 = t * t;
    t2 * t2 * slope(h, dx, dy)
}
