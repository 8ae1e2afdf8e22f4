//! Geomorphons: ten landforms, told apart by what a person on the spot would see in eight directions.
//!
//! # Equations
//! Along each of the eight grid directions, over `R` cells: `zenith` is the largest and `nadir` the smallest elevation
//! angle `atan((z_j - z) / distance_j)`. The direction counts as *higher* if `zenith + nadir > t`, as *lower* if
//! `zenith + nadir < -t`, else as *level*; `t` is the flatness threshold. The numbers of higher and lower directions
//! select the form from a table.
//!
//! # Source
//! Jasiewicz & Stepinski (2013), Geomorphons: a pattern recognition approach to classification and mapping of landforms,
//! Geomorphology 182, 147-156: ternary operator, and table (Fig. 4) as GRASS GIS r.geomorphon uses it.
//!
//! # Differences
//! r.geomorphon today takes the larger of the two angles instead of their sum; with it, 26 instead of 31 % of the Jacksboro
//! tile are slopes. The reference table was made with the paper's rule. `R` counts cells in all directions, so diagonals
//! look sqrt 2 farther. Directions that leave the grid at once count as level; others end at the rim.

use super::check_fits;
use eyot_core::{BoundaryCondition, Field, Grid, Result};
use eyot_drainage::STEPS;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A landform; the order is that of the shares in [`TerrainStats`](super::TerrainStats).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[repr(u8)]
#[non_exhaustive]
pub enum Landform {
    /// Level all around.
    Flat,
    /// Lower all around.
    Peak,
    /// Lower on both sides of a crest.
    Ridge,
    /// The edge of a flat towards lower ground.
    Shoulder,
    /// A ridge that runs down a slope.
    Spur,
    /// Higher on one side, lower on the other.
    Slope,
    /// A valley that runs down a slope.
    Hollow,
    /// The edge of a flat towards higher ground.
    Footslope,
    /// Higher on both sides of a line.
    Valley,
    /// Higher all around.
    Pit,
}

impl Landform {
    /// All forms, by number.
    pub const ALL: [Self; 10] = [
        Self::Flat,
        Self::Peak,
        Self::Ridge,
        Self::Shoulder,
        Self::Spur,
        Self::Slope,
        Self::Hollow,
        Self::Footslope,
        Self::Valley,
        Self::Pit,
    ];

    /// The form with `lower` and `higher` directions, together at most 8.
    fn from_counts(lower: usize, higher: usize) -> Self {
        Self::ALL[usize::from(TABLE[lower][higher])]
    }
}

/// Form by number of lower (row) and of higher directions (column); 10 marks impossible pairs.
#[rustfmt::skip]
const TABLE: [[u8; 9]; 9] = {
    const FL: u8 = 0; const PK: u8 = 1; const RI: u8 = 2; const SH: u8 = 3; const SP: u8 = 4; const SL: u8 = 5;
    const HL: u8 = 6; const FS: u8 = 7; const VL: u8 = 8; const PT: u8 = 9; const NO: u8 = 10;
    [
        [FL, FL, FL, FS, FS, VL, VL, VL, PT],
        [FL, FL, FS, FS, FS, VL, VL, VL, NO],
        [FL, SH, SL, SL, HL, HL, VL, NO, NO],
        [SH, SH, SL, SL, SL, HL, NO, NO, NO],
        [SH, SH, SP, SL, SL, NO, NO, NO, NO],
        [RI, RI, SP, SP, NO, NO, NO, NO, NO],
        [RI, RI, RI, NO, NO, NO, NO, NO, NO],
        [RI, RI, NO, NO, NO, NO, NO, NO, NO],
        [PK, NO, NO, NO, NO, NO, NO, NO, NO],
    ]
};

/// The landform of each cell, row by row, seen over `radius_cells` with differences below `flat_deg` taken as level.
///
/// # Errors
/// If `height` has another size than `grid`.
pub fn geomorphons(height: &Field, grid: &Grid, radius_cells: usize, flat_deg: f64) -> Result<Vec<Landform>> {
    check_fits(height, grid)?;
    let (w, h) = (grid.width, grid.height);
    // Farther than the grid there is nothing, or, on a ring, nothing new.
    let r = radius_cells.min(w.max(h));
    let framed = Framed::new(height, grid, r);
    let (sin, cos) = flat_deg.to_radians().sin_cos();
    let (sin, cos) = (sin as f32, cos as f32);
    let mut forms = vec![Landform::Flat; w * h];
    forms.par_chunks_mut(w).enumerate().for_each_init(
        || (vec![0.0_f32; w], vec![0.0_f32; w], vec![0_u8; w], vec![0_u8; w]),
        |(zenith, nadir, higher, lower), (y, forms)| {
            higher.fill(0);
            lower.fill(0);
            let here = framed.row(y, 0, 0);
            for (dx, dy) in STEPS {
                let step_m = (dx as f64 * grid.cell_x_m).hypot(dy as f64 * grid.cell_y_m);
                zenith.fill(f32::NEG_INFINITY);
                nadir.fill(f32::INFINITY);
                for j in 1..=r as isize {
                    let per_m = (1.0 / (step_m * j as f64)) as f32;
                    let there = framed.row(y, j * dx, j * dy);
                    for x in 0..w {
                        // NaN beyond the rim loses both comparisons.
                        let tangent = (there[x] - here[x]) * per_m;
                        zenith[x] = if tangent > zenith[x] { tangent } else { zenith[x] };
                        nadir[x] = if tangent < nadir[x] { tangent } else { nadir[x] };
                    }
                }
                // zenith + nadir > t without arc tangents: with a and b their tangents the sum A + B has the sign of a + b, and
                // sin(A + B - t) > 0 is (a + b) cos t > (1 - a b) sin t. A direction without cells gives NaN: level.
                for x in 0..w {
                    let (sum, less) = (zenith[x] + nadir[x], (1.0 - zenith[x] * nadir[x]) * sin);
                    higher[x] += u8::from((sum > 0.0) & (sum * cos > less));
                    lower[x] += u8::from((sum < 0.0) & (-sum * cos > less));
                }
            }
            for x in 0..w {
                forms[x] = Landform::from_counts(usize::from(lower[x]), usize::from(higher[x]));
            }
        },
    );
    Ok(forms)
}

/// The height with a frame of `r` cells around it: the far side on a ring, else NaN.
struct Framed {
    data: Vec<f32>,
    width: usize,
    stride: usize,
    r: usize,
}

impl Framed {
    fn new(height: &Field, grid: &Grid, r: usize) -> Self {
        let (width, stride) = (grid.width, grid.width + 2 * r);
        let mut data = vec![f32::NAN; stride * (grid.height + 2 * r)];
        for (y, out) in data.chunks_exact_mut(stride).enumerate() {
            let y = y as isize - r as isize;
            if grid.rim.y != BoundaryCondition::Wrap && !(0..grid.height as isize).contains(&y) {
                continue;
            }
            let row = height.row(grid.wrap_y(y));
            out[r..r + width].copy_from_slice(row);
            if grid.rim.x == BoundaryCondition::Wrap {
                for i in 0..r {
                    out[r - 1 - i] = row[width - 1 - i % width];
                    out[r + width + i] = row[i % width];
                }
            }
        }
        Self { data, width, stride, r }
    }

    /// Row `y` moved by (`dx`, `dy`) cells, each at most `r`.
    fn row(&self, y: usize, dx: isize, dy: isize) -> &[f32] {
        let start = (y + self.r).wrapping_add_signed(dy) * self.stride + self.r.wrapping_add_signed(dx);
        &self.data[start..start + self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    /// The form in the middle of a 21 x 21 grid of 10 m cells whose height is `f(east, south)` in m from the middle.
    fn middle(f: impl Fn(f32, f32) -> f32) -> Landform {
        let grid = Grid::new(21, 21, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let z = Field::from_fn(21, 21, |x, y| f((x as f32 - 10.0) * 10.0, (y as f32 - 10.0) * 10.0));
        geomorphons(&z, &grid, 10, 1.0).unwrap()[10 * 21 + 10]
    }

    #[test]
    fn shapes_have_their_names() {
        assert_eq!(middle(|_, _| 3.0), Landform::Flat);
        assert_eq!(middle(|x, _| 0.01 * x), Landform::Flat); // 0.57 degrees: below the threshold
        assert_eq!(middle(|x, y| -x.hypot(y)), Landform::Peak);
        assert_eq!(middle(|x, y| x.hypot(y)), Landform::Pit);
        assert_eq!(middle(|x, _| -x.abs()), Landform::Ridge);
        assert_eq!(middle(|x, _| x.abs()), Landform::Valley);
        assert_eq!(middle(|x, _| x), Landform::Slope);
        assert_eq!(middle(|x, y| y - 0.5 * x.abs()), Landform::Spur);
        assert_eq!(middle(|x, y| y + 0.5 * x.abs()), Landform::Hollow);
        assert_eq!(middle(|x, _| x.min(0.0)), Landform::Shoulder);
        assert_eq!(middle(|x, _| x.max(0.0)), Landform::Footslope);
    }

    #[test]
    fn turning_the_land_upside_down_swaps_the_forms() {
        let grid = Grid {
            cell_x_m: 7.0,
            ..Grid::new(
                50,
                40,
                10.0,
                Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open },
                &Limits::default(),
            )
            .unwrap()
        };
        let mut s = 5_u64;
        let mut z = Field::from_fn(50, 40, |_, _| {
            s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (s >> 40) as f32 * 1e-5
        });
        let up = geomorphons(&z, &grid, 4, 1.0).unwrap();
        z.map_in_place(|z| -z);
        let down = geomorphons(&z, &grid, 4, 1.0).unwrap();
        let swapped = |f| match f {
            Landform::Peak => Landform::Pit,
            Landform::Pit => Landform::Peak,
            Landform::Ridge => Landform::Valley,
            Landform::Valley => Landform::Ridge,
            other => other,
        };
        // The table itself is symmetric only in these.
        let plain = [Landform::Peak, Landform::Pit, Landform::Ridge, Landform::Valley];
        assert!(up.iter().zip(&down).filter(|(a, _)| plain.contains(a)).all(|(&a, &b)| swapped(a) == b));
        assert!(plain.iter().all(|f| up.contains(f)));
    }

    #[test]
    fn arc_tangents_would_say_the_same() {
        let t = 1.0_f64.to_radians();
        for a in -40..=40 {
            for b in -40..=a {
                let (a, b) = ((f64::from(a) * 0.2).sinh() * 0.1, (f64::from(b) * 0.2).sinh() * 0.1);
                let (sum, less) = (a + b, (1.0 - a * b) * t.sin());
                let by_angle = a.atan() + b.atan();
                assert_eq!(by_angle > t, sum > 0.0 && sum * t.cos() > less, "{a} {b}");
                assert_eq!(by_angle < -t, sum < 0.0 && -sum * t.cos() > less, "{a} {b}");
            }
        }
    }

    #[test]
    fn one_cell_is_flat() {
        for rim in [Boundary::CLOSED, Boundary::WRAP] {
            let grid = Grid::new(1, 1, 10.0, rim, &Limits::default()).unwrap();
            assert_eq!(geomorphons(&Field::new(1, 1, 4.0), &grid, 10, 1.0).unwrap(), [Landform::Flat]);
        }
    }
}
