//! What lies below the rims of a world that knows its beds: the cut sides of its relief model.

use crate::math::V3;
use crate::picture::linear;
use eyot_core::{Result, World};
use eyot_strata::Subsurface;

/// Columns for each cell of a side, and the most of a side.
const PER_CELL: usize = 4;
const MOST: usize = 8192;

/// A side of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    West,
    East,
    North,
    South,
}

/// A stretch of one kind of ground, m over the picture's height 0.
#[derive(Clone, Copy, Debug)]
struct Layered {
    top: f32,
    bottom: f32,
    colour: V3,
}

/// What a place of a side shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rock {
    /// Linear colour.
    pub(crate) colour: V3,
    /// Height over a surface that lies as the bed does, m.
    pub(crate) bedding: f32,
    /// Way to the next contact, up or down, m.
    pub(crate) contact: f32,
}

/// The columns of the four sides.
pub(crate) struct Cut {
    sides: [Vec<Vec<Layered>>; 4],
    /// Columns of each side for each cell.
    per_cell: [f32; 4],
}

impl Cut {
    /// Those of a world down to `floor_m`, with heights over `datum_m`; `None` if it has no strata.
    ///
    /// # Errors
    /// If the world has no height, or its strata are damaged.
    pub(crate) fn of(world: &World, datum_m: f32, floor_m: f32) -> Result<Option<Self>> {
        let below = Subsurface::of(world)?;
        if below.sequence().is_none() {
            return Ok(None);
        }
        let (last_x, last_y) = ((world.grid.width - 1) as f64, (world.grid.height - 1) as f64);
        let mut runs = Vec::new();
        let mut side = |cells: usize, place: &dyn Fn(f64) -> [f64; 2]| {
            let count = ((cells - 1) * PER_CELL).clamp(1, MOST);
            let per_cell = count as f64 / (cells.max(2) - 1) as f64;
            let column = |i: usize| {
                let [x, y] = place(i as f64 / per_cell);
                below.at(x, y, f64::from(floor_m), &mut runs);
                let of = |r: &eyot_strata::Run| Layered {
                    top: r.top_m as f32 - datum_m,
                    bottom: r.bottom_m as f32 - datum_m,
                    colour: linear(below.kinds()[r.kind].colour),
                };
                runs.iter().map(of).collect()
            };
            ((0..=count).map(column).collect::<Vec<_>>(), per_cell as f32)
        };
        let (width, height) = (world.grid.width, world.grid.height);
        let (west, west_per) = side(height, &|y| [0.0, y]);
        let (east, east_per) = side(height, &|y| [last_x, y]);
        let (north, north_per) = side(width, &|x| [x, 0.0]);
        let (south, south_per) = side(width, &|x| [x, last_y]);
        Ok(Some(Self { sides: [west, east, north, south], per_cell: [west_per, east_per, north_per, south_per] }))
    }

    /// What lies at a height (m) of a side, so many cells from its western or northern end.
    pub(crate) fn at(&self, side: Side, along: f32, z: f32) -> Option<Rock> {
        let columns = &self.sides[side as usize];
        let i = (along * self.per_cell[side as usize]).round().max(0.0) as usize;
        let column = &columns[i.min(columns.len() - 1)];
        // Above all of it, and below, it is as at its ends: surfaces are drawn smoother than they are.
        let n = column.iter().position(|r| z >= r.bottom).unwrap_or(column.len().checked_sub(1)?);
        let here = column[n];
        let over = if n > 0 { (here.top - z).abs() } else { f32::INFINITY };
        let last = n + 1 == column.len();
        let under = if last { f32::INFINITY } else { (z - here.bottom).abs() };
        let bedding = z - if last { here.top } else { here.bottom };
        Some(Rock { colour: here.colour, bedding, contact: over.min(under) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known::HEIGHT;
    use eyot_core::{Boundary, Field, Grid, Limits};
    use eyot_strata::materials::colour;
    use eyot_strata::{BED_DATUM, BEDROCK, Bed, STRATA, Strata};

    #[test]
    fn sides_show_the_beds_of_their_rims() {
        let grid = Grid::new(5, 9, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let mut w = World::new(grid, 1);
        w.put(&HEIGHT, Field::new(5, 9, 130.0)).unwrap();
        assert!(Cut::of(&w, 0.0, 0.0).unwrap().is_none(), "no strata, no cut");
        w.put(&BEDROCK, Field::new(5, 9, 120.0)).unwrap();
        // Limestone from 100 m, 10 m lower with each row, on granite.
        w.put(&BED_DATUM, Field::from_fn(5, 9, |_, y| 140.0 - 10.0 * y as f32)).unwrap();
        let bed = |material: &str| Bed { material: material.into(), thickness: 40.0 };
        let strata = Strata { beds: vec![bed("limestone"), bed("granite")], ..Strata::default() };
        w.components.insert(STRATA, strata.sequence().unwrap());
        let cut = Cut::of(&w, 50.0, 0.0).unwrap().unwrap();
        let is = |side, along, z: f32, n: usize| {
            let rock = cut.at(side, along, z - 50.0).unwrap();
            assert_eq!(rock.colour, linear(colour(n)), "{side:?}, {along} cells along, {z} m");
            rock
        };
        for side in [Side::West, Side::East] {
            is(side, 0.0, 140.0, 0);
            is(side, 0.0, 121.0, 0);
            is(side, 0.0, 119.0, 3);
            assert!((is(side, 0.0, 101.0, 3).contact - 1.0).abs() < 1e-3);
            is(side, 0.0, 99.0, 6);
            // Two rows and a half to the south the contact lies 25 m lower.
            assert!((is(side, 2.5, 76.0, 3).bedding - 1.0).abs() < 1e-3);
            is(side, 2.5, 74.0, 6);
            is(side, 2.5, -500.0, 6);
        }
        is(Side::North, 3.0, 101.0, 3);
        is(Side::North, 3.0, 99.0, 6);
        is(Side::South, 3.0, 21.0, 3);
        is(Side::South, 3.0, 19.0, 6);
    }
}
