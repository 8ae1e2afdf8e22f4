//! Noise in the plane and its sums over octaves.
//!
//! - [`Basis::Perlin`]: square lattice, quintic fade. [`Basis::Simplex`]: lattice of triangles, radial kernel. Both have unit
//!   gradients at angles chosen by an integer hash, are scaled so that no value lies outside -1..=1 (the bound is reached only if all
//!   gradients around a point agree), and are zero at lattice points.
//! - [`Basis::Value`]: a number at each point of a square lattice, blended with the quintic fade.
//! - [`Basis::WorleyF1`], `F2`, `F2F1`: distances to points strewn over a square lattice, see `worley`. Their mean is not 0.
//! - fBm: `sum gain^o n_o / sum gain^o`, so it stays within -1..=1 too.
//! - ridged multifractal (Musgrave): `s_o = (1 - |n_o|)^2 w_o`, `w_0 = 1`, `w_(o+1) = clamp(sharpness s_o, 0, 1)`, summed and
//!   divided in the same way: within 0..=1. Crests get detail, valleys stay smooth.
//! - billow: `sum gain^o (2 |n_o| - 1) / sum gain^o`.
//! - domain warp: the place at which the noise is looked up is displaced by two other noises.
//!
//! # Coordinates
//! Features are measured in metres and looked up at the centres of cells, so the same noise on a finer grid shows the same
//! land. Octaves that a grid cannot show are faded out: full down to features of two cells, none at one cell; the
//! division is by the full sum, so that nothing else changes with the grid. Each octave is turned against the others and
//! moved by a fraction of a lattice cell; on wrapping rims everything repeats with the extent (see `lattice`).
//!
//! # Speed
//! Places are kept in fixed point for each block of sixteen cells and only the rest within the block is `f32`: no precision is
//! lost on large grids. All ISAs give the same bits; rows may be computed in any order by any number of threads.

mod gradient;
mod lattice;
mod perlin;
mod simplex;
mod value;
mod worley;

use eyot_core::isa::{Isa, LaneTask, run_lanes};
use eyot_core::lanes::{LaneBlock, WIDTH};
use eyot_core::real::Real;
use eyot_core::{Control, Field, Grid, Result, rng};
pub use gradient::{COLUMN, ROW, hash};
use lattice::{Kernel, Octave};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;
use std::ops::Range;

/// Which noise is summed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Basis {
    /// Triangles: the same in all directions. One octave's standard deviation is 0.54 of the bound.
    #[default]
    Simplex,
    /// Squares: a little blockier (directions differ by 4 %). One octave's standard deviation is 0.31 of the bound.
    Perlin,
    /// Random heights on squares: plump and irregular hills. One octave's standard deviation is 0.45 of the bound.
    Value,
    /// Distance to the nearest of strewn points: pits with sharp ridges between them.
    #[serde(rename = "worley_f1")]
    WorleyF1,
    /// Distance to the second nearest point: facets.
    #[serde(rename = "worley_f2")]
    WorleyF2,
    /// Second nearest minus nearest: plates with cracks between them.
    #[serde(rename = "worley_f2_f1")]
    WorleyF2F1,
}

/// How octaves are put together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Sum {
    /// Plain weighted sum, within -1..=1.
    Fbm,
    /// Sum of folded octaves, within -1..=1.
    Billow,
    /// Ridged multifractal, within 0..=1; each octave is weighted by the one before times this number.
    Ridged(f32),
}

/// A noise over the plane.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Which noise is summed.
    pub basis: Basis,
    /// How.
    pub sum: Sum,
    /// Number of octaves.
    pub octaves: u32,
    /// Edge of the first octave's lattice, m: about the distance from a hill to the next valley.
    pub scale_m: f64,
    /// Ratio of the feature sizes of one octave and the next.
    pub lacunarity: f64,
    /// Ratio of the heights of one octave and the one before.
    pub gain: f64,
    /// How far Worley's points lie from the middles of their squares, 0..=1.
    pub jitter: f32,
    /// Decides everything that is random.
    pub seed: u64,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            basis: Basis::Simplex,
            sum: Sum::Fbm,
            octaves: 8,
            scale_m: 1000.0,
            lacunarity: 2.0,
            gain: 0.5,
            jitter: 1.0,
            seed: 0,
        }
    }
}

/// Blocks of lanes in one piece of a row. Small enough that the scratch of a piece stays in the first-level cache.
pub const PIECE: usize = 32;
/// Columns in one piece of a row.
pub const PIECE_COLUMNS: usize = PIECE * WIDTH;
/// One number a column of a piece, in blocks of lanes.
pub type Piece = [[f32; WIDTH]; PIECE];

/// A noise made ready for one grid.
pub struct Prepared {
    basis: Basis,
    sum: Sum,
    octaves: Vec<Octave>,
    isa: Isa,
}

impl Noise {
    /// Makes the noise ready for a grid.
    pub fn prepare(&self, grid: &Grid, isa: Isa) -> Prepared {
        let cell_m = grid.cell_x_m.max(grid.cell_y_m);
        let (mut size_m, mut height, mut total) = (self.scale_m, 1.0, 0.0);
        let mut heights = Vec::new();
        for _ in 0..self.octaves {
            let visible = (size_m / cell_m - 1.0).clamp(0.0, 1.0);
            heights.push((size_m, height * visible));
            total += height;
            size_m /= self.lacunarity;
            height *= self.gain;
        }
        let octaves = (0u32..)
            .zip(heights)
            .take_while(|(_, (_, height))| *height > 0.0)
            .map(|(index, (size_m, height))| Octave::new(self, grid, size_m, index, (height / total) as f32))
            .collect();
        Prepared { basis: self.basis, sum: self.sum, octaves, isa }
    }

    /// The noise at the cells of some rows of a grid.
    ///
    /// # Errors
    /// On a request to stop.
    pub fn field(&self, grid: &Grid, rows: Range<usize>, isa: Isa, control: &Control<'_>) -> Result<Field> {
        let noise = self.prepare(grid, isa);
        Field::from_rows(grid.width, rows, control, |y, row| {
            for (x, piece) in (0..).step_by(PIECE_COLUMNS).zip(row.chunks_mut(PIECE_COLUMNS)) {
                let mut out = [[0.0; WIDTH]; PIECE];
                noise.piece(x, y, piece.len().div_ceil(WIDTH), None, &mut out);
                piece.copy_from_slice(&out.as_flattened()[..piece.len()]);
            }
        })
    }

    /// A pair of noises like this one to displace places with, independent of it and of each other.
    pub fn displacement(&self, octaves: u32) -> [Self; 2] {
        [0x6561_7374, 0x736f_7574].map(|stream| Self {
            sum: Sum::Fbm,
            seed: rng::mix64(self.seed ^ stream),
            octaves,
            ..self.clone()
        })
    }

    /// The noise at the cells of some rows of a grid, each looked up at a place that is displaced by up to `strength_m`.
    ///
    /// # Errors
    /// On a request to stop.
    pub fn warped_field(
        &self,
        strength_m: f64,
        grid: &Grid,
        rows: Range<usize>,
        isa: Isa,
        control: &Control<'_>,
    ) -> Result<Field> {
        if strength_m == 0.0 {
            return self.field(grid, rows, isa, control);
        }
        let noise = self.prepare(grid, isa);
        let away = self.displacement(self.octaves.min(4)).map(|n| n.prepare(grid, isa));
        Field::from_rows(grid.width, rows, control, |y, row| {
            for (x, piece) in (0..).step_by(PIECE_COLUMNS).zip(row.chunks_mut(PIECE_COLUMNS)) {
                let blocks = piece.len().div_ceil(WIDTH);
                let mut shift = [[[0.0; WIDTH]; PIECE]; 2];
                for (noise, shift) in away.iter().zip(&mut shift) {
                    noise.piece(x, y, blocks, None, shift);
                    shift.as_flattened_mut().iter_mut().for_each(|v| *v *= strength_m as f32);
                }
                let mut out = [[0.0; WIDTH]; PIECE];
                noise.piece(x, y, blocks, Some(&shift), &mut out);
                piece.copy_from_slice(&out.as_flattened()[..piece.len()]);
            }
        })
    }
}

impl Prepared {
    /// Values of `blocks` blocks from column `x` of row `y`, looked up `shift` metres east and south of the cells.
    ///
    /// Column and row may lie outside the grid; `x` should be a multiple of the block.
    pub fn piece(&self, x: usize, y: usize, blocks: usize, shift: Option<&[Piece; 2]>, out: &mut Piece) {
        let mut memory = [[1.0; WIDTH]; PIECE];
        for octave in &self.octaves {
            let row = Row {
                octave,
                x: x as i64,
                y: y as i64,
                sum: self.sum,
                shift,
                memory: &mut memory[..blocks],
                out: &mut out[..blocks],
            };
            match self.basis {
                Basis::Perlin => row.of::<perlin::Perlin>(self.isa),
                Basis::Simplex => row.of::<simplex::Simplex>(self.isa),
                Basis::Value => row.of::<value::Value>(self.isa),
                Basis::WorleyF1 | Basis::WorleyF2 | Basis::WorleyF2F1 => row.of::<worley::Worley>(self.isa),
            }
        }
    }
}

/// One octave of one piece of a row.
struct Row<'a> {
    octave: &'a Octave,
    x: i64,
    y: i64,
    sum: Sum,
    shift: Option<&'a [Piece; 2]>,
    /// Weights that ridges hand from octave to octave.
    memory: &'a mut [[f32; WIDTH]],
    out: &'a mut [[f32; WIDTH]],
}

/// The lattice is a parameter of the type, so that the long part of the loop contains no choice. How octaves are summed and whether
/// the place is displaced is asked once a block: as parameters they would make six programs of each, for no gain in speed.
struct Task<'a, K, const TORUS: bool>(Row<'a>, PhantomData<K>);

impl<'a> Row<'a> {
    fn of<K: Kernel>(self, isa: Isa) {
        if self.octave.wraps() {
            Task::<'a, K, true>(self, PhantomData).go(isa);
        } else {
            Task::<'a, K, false>(self, PhantomData).go(isa);
        }
    }
}

/// What stays the same along a piece.
#[derive(Clone, Copy)]
struct Constants {
    sum: Sum,
    per_metre: [[f32; 2]; 2],
    scale: f32,
    weight: f32,
    sharpness: f32,
}

/// Adds one octave to `sum`; the place is that of a block plus `ramp` plus a displacement.
#[inline(always)]
fn cell<R: Real, K: Kernel, const TORUS: bool>(
    o: &Octave,
    place: [i64; 2],
    ramp: [R; 2],
    shift: Option<[R; 2]>,
    c: Constants,
    memory: R,
    sum: R,
) -> (R, R) {
    let ((iu, fu), (iv, fv)) = (Octave::split(place[0]), Octave::split(place[1]));
    let (mut u, mut v) = (R::of(fu) + ramp[0], R::of(fv) + ramp[1]);
    if let Some([dx, dy]) = shift {
        u = u + (dx * R::of(c.per_metre[0][0]) + dy * R::of(c.per_metre[0][1]));
        v = v + (dx * R::of(c.per_metre[1][0]) + dy * R::of(c.per_metre[1][1]));
    }
    let n = K::at::<R, TORUS>(o, [iu, iv], u, v) * R::of(c.scale);
    match c.sum {
        Sum::Ridged(_) => {
            let edge = R::of(1.0) - n.abs();
            let signal = edge * edge * memory;
            let memory = (signal * R::of(c.sharpness)).clamp(R::of(0.0), R::of(1.0));
            (sum + signal * R::of(c.weight), memory)
        }
        Sum::Billow => (sum + (n.abs() + n.abs() - R::of(1.0)) * R::of(c.weight), memory),
        Sum::Fbm => (sum + n, memory),
    }
}

impl<K: Kernel, const TORUS: bool> Task<'_, K, TORUS> {
    fn go(self, isa: Isa) {
        match isa {
            Isa::Scalar => self.one_by_one(),
            _ => run_lanes(isa, self),
        }
    }

    #[inline(always)]
    fn constants(&self) -> Constants {
        let o = self.0.octave;
        let (scale, sharpness) = match self.0.sum {
            // A plain sum needs the product only.
            Sum::Fbm => (o.scale * o.weight, 0.0),
            Sum::Billow => (o.scale, 0.0),
            Sum::Ridged(sharpness) => (o.scale, sharpness),
        };
        Constants { sum: self.0.sum, per_metre: o.per_metre, scale, weight: o.weight, sharpness }
    }

    /// The reference: the same function, one cell at a time.
    fn one_by_one(self) {
        let c = self.constants();
        let Row { octave: o, x, y, shift, memory, out, .. } = self.0;
        let mut place = o.place(x, y);
        for (b, (memory, out)) in memory.iter_mut().zip(out).enumerate() {
            for lane in 0..WIDTH {
                let ramp = o.stride.map(|s| lane as f32 * s);
                let shift = shift.map(|[dx, dy]| [dx[b][lane], dy[b][lane]]);
                (out[lane], memory[lane]) = cell::<f32, K, TORUS>(o, place, ramp, shift, c, memory[lane], out[lane]);
            }
            place = o.east(place, WIDTH as i64);
        }
    }
}

impl<K: Kernel, const TORUS: bool> LaneTask for Task<'_, K, TORUS> {
    type Out = ();

    #[inline(always)]
    fn run<L: LaneBlock>(self) {
        let c = self.constants();
        let Row { octave: o, x, y, shift, memory, out, .. } = self.0;
        let mut place = o.place(x, y);
        let ramp = [L::index() * L::of(o.stride[0]), L::index() * L::of(o.stride[1])];
        for b in 0..out.len().min(memory.len()) {
            // No closure: the compiler would not build it for the instruction set.
            #[allow(clippy::manual_map)]
            let shift = match shift {
                Some([dx, dy]) => Some([L::from_array(dx[b]), L::from_array(dy[b])]),
                None => None,
            };
            let sum = L::from_array(out[b]);
            let (sum, weights) = cell::<L, K, TORUS>(o, place, ramp, shift, c, L::from_array(memory[b]), sum);
            out[b] = sum.to_array();
            memory[b] = weights.to_array();
            place = o.east(place, WIDTH as i64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, BoundaryCondition, Limits};

    /// One period further on, on either axis, the noise is the same: seamless in value and in all slopes.
    #[test]
    fn noise_on_wrapping_rims_repeats_with_the_extent() {
        let rims = [
            (BoundaryCondition::Wrap, BoundaryCondition::Wrap),
            (BoundaryCondition::Wrap, BoundaryCondition::Closed),
            (BoundaryCondition::Open, BoundaryCondition::Wrap),
        ];
        let mut worst = 0.0f32;
        for (x, y) in rims {
            for (w, h, cell_y_m) in
                [(64usize, 64usize, 10.0), (96, 32, 10.0), (32, 160, 7.0), (512, 16, 10.0), (16, 16, 3.0)]
            {
                let grid = Grid { width: w, height: h, cell_x_m: 10.0, cell_y_m, rim: Boundary { x, y } };
                let grid = grid.checked(&Limits::default()).unwrap();
                for basis in [Basis::Simplex, Basis::Perlin, Basis::Value, Basis::WorleyF1, Basis::WorleyF2] {
                    for (scale_m, sum) in
                        [(800.0, Sum::Fbm), (77.0, Sum::Fbm), (160.0, Sum::Ridged(2.0)), (20.0, Sum::Fbm)]
                    {
                        let noise = Noise { basis, sum, scale_m, seed: 9, ..Noise::default() };
                        let noise = noise.prepare(&grid, Isa::best());
                        for row in 0..h {
                            let at = |x, y| {
                                let mut out = [[0.0; WIDTH]; PIECE];
                                noise.piece(x, y, w / WIDTH, None, &mut out);
                                out
                            };
                            let here = at(0, row);
                            let there = at(
                                if x == BoundaryCondition::Wrap { w } else { 0 },
                                if y == BoundaryCondition::Wrap { row + h } else { row },
                            );
                            for (a, b) in here.as_flattened().iter().zip(there.as_flattened()) {
                                worst = worst.max((a - b).abs());
                            }
                        }
                    }
                }
            }
        }
        assert!(worst < 2e-6, "{worst}");
        println!("largest difference one period away: {worst:e}");
    }
}
