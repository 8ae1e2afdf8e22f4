//! Where an octave's lattice lies on the land: its size, turn, offset and, on wrapping rims, its period.
//!
//! Metres become lattice coordinates by a matrix, `s = M p + offset`. Away from wrapping rims M is a rotation by an angle that
//! differs from octave to octave (so that no direction of the lattice adds up), divided by the feature size, and for
//! simplex followed by the map to coordinates along the triangle's edges.
//!
//! # Wrapping rims
//! Noise repeats with the extent W exactly if `M (W, 0)` is a vector of whole numbers and lattice points that differ by it have
//! the same gradient. So M is taken from a family whose columns are whole:
//! `M = Q T diag(1/W, 1/H)`, where T is an unturned lattice with a whole number of cells along each wrapping axis,
//! square `[k 0; 0 l]` or triangular `[k -l/2; 0 l]` (l even), and Q is a turn by a small Gaussian `a + bi` or Eisenstein
//! `a + b e^(i pi/3)` integer, which maps whole vectors to whole vectors. Rounding k and l stretches the lattice a little; the
//! turn is chosen so that this stays below 6 % where possible. Before a lattice point is hashed, whole periods are
//! taken off: `(tx, ty) = inverse(M) s` in units of the extent has a numerator and a denominator that are small whole numbers,
//! so `floor` in `f32` is exact.

use super::gradient::{COLUMN, ROW, hash};
use super::worley::Cells;
use super::{Basis, Noise};
use eyot_core::real::{Bits, Real};
use eyot_core::rng::mix64;
use eyot_core::{BoundaryCondition, Grid};

/// Noise on one kind of lattice, not yet scaled to -1..=1.
pub(super) trait Kernel {
    /// Value at lattice coordinates `origin + (u, v)`.
    fn at<R: Real, const TORUS: bool>(o: &Octave, origin: [u32; 2], u: R, v: R) -> R;
}

/// Bits of the fraction in fixed-point lattice coordinates. 23 bits remain for the lattice cell: enough for the largest
/// grids, and no rounding that depends on where on the grid a cell lies.
const FRACTION: u32 = 40;

/// One octave, ready to be evaluated on one grid.
#[derive(Clone, Debug)]
pub(super) struct Octave {
    /// Fixed-point lattice coordinates of the centre of cell (0, 0).
    start: [i64; 2],
    /// Fixed-point step from column to column.
    step_x: [i64; 2],
    /// Fixed-point step from row to row.
    step_y: [i64; 2],
    /// `step_x` as numbers.
    pub(super) stride: [f32; 2],
    /// M: lattice coordinates per metre.
    pub(super) per_metre: [[f32; 2]; 2],
    key: [u32; 2],
    /// What makes the kernel's values -1..=1.
    pub(super) scale: f32,
    /// Factor of this octave in the sum.
    pub(super) weight: f32,
    /// Where Worley's points lie and which distance counts.
    pub(super) cells: Cells,
    torus: Option<Torus>,
}

/// How to take whole periods off a lattice point.
#[derive(Clone, Copy, Debug)]
struct Torus {
    /// Numerators of `tx` and `ty`.
    numerator: [[f32; 2]; 2],
    /// One over their denominators; 0 along an axis that does not wrap.
    inverse: [f32; 2],
    /// The period of each axis in lattice coordinates.
    period: [[f32; 2]; 2],
}

type Matrix = [[f64; 2]; 2];

/// The kind of lattice under a noise.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Lattice {
    Squares,
    Triangles,
}

impl Lattice {
    fn under(basis: Basis) -> Self {
        if basis == Basis::Simplex { Self::Triangles } else { Self::Squares }
    }
}

fn product(a: Matrix, b: Matrix) -> Matrix {
    let mut m = [[0.0; 2]; 2];
    for r in 0..2 {
        for c in 0..2 {
            m[r][c] = a[r][0] * b[0][c] + a[r][1] * b[1][c];
        }
    }
    m
}

/// From places to coordinates along the edges of the lattice.
fn edges(lattice: Lattice) -> Matrix {
    match lattice {
        Lattice::Squares => [[1.0, 0.0], [0.0, 1.0]],
        // a e1 + b e2 = p with e1 = (1, 0), e2 = (1/2, sqrt(3)/2)
        Lattice::Triangles => [[1.0, -1.0 / 3f64.sqrt()], [0.0, 2.0 / 3f64.sqrt()]],
    }
}

impl Octave {
    /// Octave number `index` with features of `size_m`.
    pub(super) fn new(noise: &Noise, grid: &Grid, size_m: f64, index: u32, weight: f32) -> Self {
        let lattice = Lattice::under(noise.basis);
        let key = mix64(mix64(noise.seed) ^ u64::from(index));
        let offset = mix64(key);
        let (m, torus) = match (grid.rim.x, grid.rim.y) {
            (BoundaryCondition::Wrap, _) | (_, BoundaryCondition::Wrap) => {
                let (m, torus) = periodic(lattice, grid, size_m, index);
                (m, Some(torus))
            }
            _ => (turned(lattice, size_m, index, noise.seed), None),
        };
        let fixed = |v: f64| (v * (1u64 << FRACTION) as f64) as i64;
        let along = |x_m: f64, y_m: f64| [m[0][0] * x_m + m[0][1] * y_m, m[1][0] * x_m + m[1][1] * y_m];
        let corner = along(0.5 * grid.cell_x_m, 0.5 * grid.cell_y_m);
        let step_x = along(grid.cell_x_m, 0.0);
        let fraction = |bits: u64| (bits >> 40) as f64 / f64::from(1 << 24);
        let cells = Cells::new(noise.basis, noise.jitter);
        let scale = match noise.basis {
            Basis::Perlin => super::perlin::SCALE,
            Basis::Simplex => super::simplex::SCALE,
            Basis::Value => 1.0,
            Basis::WorleyF1 | Basis::WorleyF2 | Basis::WorleyF2F1 => 1.0 / cells.middle,
        };
        Self {
            start: [fixed(corner[0] + fraction(offset)), fixed(corner[1] + fraction(offset << 24))],
            step_x: step_x.map(fixed),
            step_y: along(0.0, grid.cell_y_m).map(fixed),
            stride: step_x.map(|v| v as f32),
            per_metre: m.map(|r| r.map(|v| v as f32)),
            key: [key as u32, (key >> 32) as u32],
            scale,
            weight,
            cells,
            torus,
        }
    }

    /// True if the lattice repeats along an axis.
    pub(super) fn wraps(&self) -> bool {
        self.torus.is_some()
    }

    /// Fixed-point coordinates of a cell.
    #[inline(always)]
    pub(super) fn place(&self, x: i64, y: i64) -> [i64; 2] {
        [
            self.start[0] + x * self.step_x[0] + y * self.step_y[0],
            self.start[1] + x * self.step_x[1] + y * self.step_y[1],
        ]
    }

    /// Coordinates `columns` further east.
    #[inline(always)]
    pub(super) fn east(&self, place: [i64; 2], columns: i64) -> [i64; 2] {
        [place[0] + columns * self.step_x[0], place[1] + columns * self.step_x[1]]
    }

    /// Cell of the lattice and fraction within it.
    #[inline(always)]
    pub(super) fn split(place: i64) -> (u32, f32) {
        let fraction = (place >> (FRACTION - 24)) as u32 & 0x00ff_ffff;
        ((place >> FRACTION) as u32, fraction as i32 as f32 * (1.0 / 16_777_216.0))
    }

    /// Column and row of a lattice point, as [`hash`] takes them.
    #[inline(always)]
    pub(super) fn hash_legs<R: Real>(&self, origin: [u32; 2], iu: R, iv: R) -> (R::Bits, R::Bits) {
        let column = iu.to_int_bits().mul(R::Bits::of(COLUMN));
        let row = iv.to_int_bits().mul(R::Bits::of(ROW));
        (
            column.add(R::Bits::of(origin[0].wrapping_mul(COLUMN).wrapping_add(self.key[0]))),
            row.add(R::Bits::of(origin[1].wrapping_mul(ROW).wrapping_add(self.key[1]))),
        )
    }

    /// Hashes of the corners of a square of the lattice: (0, 0), (1, 0), (0, 1) and (1, 1).
    #[inline(always)]
    pub(super) fn corner_hashes<R: Real, const TORUS: bool>(&self, origin: [u32; 2], iu: R, iv: R) -> [R::Bits; 4] {
        if TORUS {
            [
                self.wrapped_hash(origin, iu, iv),
                self.wrapped_hash(origin, iu + R::of(1.0), iv),
                self.wrapped_hash(origin, iu, iv + R::of(1.0)),
                self.wrapped_hash(origin, iu + R::of(1.0), iv + R::of(1.0)),
            ]
        } else {
            let (column, row) = self.hash_legs(origin, iu, iv);
            let (column1, row1) = (column.add(R::Bits::of(COLUMN)), row.add(R::Bits::of(ROW)));
            [hash(column, row), hash(column1, row), hash(column, row1), hash(column1, row1)]
        }
    }

    /// Hash of a lattice point after whole periods were taken off.
    #[inline(always)]
    pub(super) fn wrapped_hash<R: Real>(&self, origin: [u32; 2], iu: R, iv: R) -> R::Bits {
        let Some(t) = &self.torus else { return R::Bits::of(0) };
        let i = iu + R::of(origin[0] as i32 as f32);
        let j = iv + R::of(origin[1] as i32 as f32);
        // One half keeps the rounded quotient on the right side of whole numbers; the numerators are whole.
        let tx = i * R::of(t.numerator[0][0]) + j * R::of(t.numerator[0][1]) + R::of(0.5);
        let ty = i * R::of(t.numerator[1][0]) + j * R::of(t.numerator[1][1]) + R::of(0.5);
        let (tx, ty) = ((tx * R::of(t.inverse[0])).floor(), (ty * R::of(t.inverse[1])).floor());
        let i = i - tx * R::of(t.period[0][0]) - ty * R::of(t.period[1][0]);
        let j = j - tx * R::of(t.period[0][1]) - ty * R::of(t.period[1][1]);
        let (column, row) = self.hash_legs([0, 0], i, j);
        hash(column, row)
    }
}

/// M of a lattice that fills the plane, turned.
fn turned(lattice: Lattice, size_m: f64, index: u32, seed: u64) -> Matrix {
    // The first octave's angle comes from the seed, through a rational parametrisation of the circle: the platform's sine
    // might differ in the last bit from machine to machine.
    let t = (mix64(seed ^ 0x7475_726e) >> 40) as f64 / f64::from(1 << 24);
    let (mut c, mut s) = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
    // Each further octave turns by the golden section of the lattice's symmetry: 90 degrees for squares, 60 for triangles.
    let (dc, ds) = match lattice {
        Lattice::Squares => (0.564_634_886_417_550_3, 0.825_340_805_389_046_5),
        Lattice::Triangles => (0.797_772_979_000_846, 0.602_957_937_153_260_8),
    };
    for _ in 0..index {
        (c, s) = (c * dc - s * ds, s * dc + c * ds);
    }
    let scale = 1.0 / size_m;
    product(edges(lattice), [[c * scale, -s * scale], [s * scale, c * scale]])
}

/// M of a lattice that repeats with the grid's extent along the axes that wrap.
fn periodic(lattice: Lattice, grid: &Grid, size_m: f64, index: u32) -> (Matrix, Torus) {
    // Turns by a Gaussian or Eisenstein integer, from octave to octave another one; the last two are for few features.
    const TURNS: [[[i32; 2]; 8]; 2] = [
        [[2, 1], [1, 3], [3, 2], [1, 2], [2, 3], [3, 1], [1, 1], [1, 0]],
        [[1, 2], [1, 1], [3, 1], [2, 1], [1, 3], [3, 2], [1, 1], [1, 0]],
    ];
    let turns = &TURNS[usize::from(lattice == Lattice::Triangles)];
    let (w, h) = grid.extent_m();
    let (wrap_x, wrap_y) = (grid.rim.x == BoundaryCondition::Wrap, grid.rim.y == BoundaryCondition::Wrap);
    let mut best = (f64::INFINITY, [1, 0], 1.0, 1.0);
    for k in 0..turns.len() {
        let turn = if k < 6 { turns[(index as usize + k) % 6] } else { turns[k] };
        let (cells_x, cells_y) = ideal_cells(lattice, turn, w / size_m, h / size_m);
        let k = if wrap_x { cells_x.round().max(1.0) } else { cells_x };
        let l = match (wrap_y, lattice) {
            (false, _) => cells_y,
            (true, Lattice::Squares) => cells_y.round().max(1.0),
            (true, Lattice::Triangles) => (2.0 * (cells_y / 2.0).round()).max(2.0),
        };
        let stretch = |n: f64, ideal: f64| (n / ideal).max(ideal / n) - 1.0;
        let error = stretch(k, cells_x).max(stretch(l, cells_y));
        if error < best.0 {
            best = (error, turn, k, l);
        }
        if error <= 0.06 {
            break;
        }
    }
    let (_, turn, k, l) = best;
    let [a, b] = turn.map(f64::from);
    let (q, t, numerator, norm) = match lattice {
        Lattice::Squares => ([[a, -b], [b, a]], [[k, 0.0], [0.0, l]], [[a, b], [-b, a]], [a * a + b * b; 2]),
        Lattice::Triangles => {
            let n = a * a + a * b + b * b;
            ([[a, -b], [b, a + b]], [[k, -l / 2.0], [0.0, l]], [[2.0 * a + b, a + 2.0 * b], [-b, a]], [2.0 * n, n])
        }
    };
    let periods = product(q, t);
    let torus = Torus {
        numerator: numerator.map(|r| r.map(|v| v as f32)),
        inverse: [
            if wrap_x { (1.0 / (norm[0] * k)) as f32 } else { 0.0 },
            if wrap_y { (1.0 / (norm[1] * l)) as f32 } else { 0.0 },
        ],
        period: [[periods[0][0] as f32, periods[1][0] as f32], [periods[0][1] as f32, periods[1][1] as f32]],
    };
    ([[periods[0][0] / w, periods[0][1] / h], [periods[1][0] / w, periods[1][1] / h]], torus)
}

/// Cells of the unturned lattice along the extent that would stretch nothing.
fn ideal_cells(lattice: Lattice, [a, b]: [i32; 2], features_x: f64, features_y: f64) -> (f64, f64) {
    match lattice {
        Lattice::Squares => {
            let length = f64::from(a * a + b * b).sqrt();
            (features_x / length, features_y / length)
        }
        Lattice::Triangles => {
            let length = f64::from(a * a + a * b + b * b).sqrt();
            (features_x / length, features_y / length * 2.0 / 3f64.sqrt())
        }
    }
}
