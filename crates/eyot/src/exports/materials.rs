//! What the ground is made of, as shares for game engines: grass, rock, sand and snow by slope, height and sea.
//!
//! Plainer than the colours of the pictures on purpose: three numbers that a level designer can turn. With s the slope in
//! degrees, h the height and S(a, b, x) the smooth step from 0 at a to 1 at b:
//! - rock = S(0.8 r, 1.2 r, s) with r the slope at which rock begins (`rock_slope`);
//! - snow = S(l - 100, l + 100, h) of the rest, with l the snow line (`snow_line`);
//! - sand = S(b, b / 2, h above the sea) of what is left, with b the height of beaches (`beach`), if there is a sea;
//! - grass is what remains.

use crate::backend::io;
use crate::error::RunError;
use crate::keys::Export;
use eyot_core::{Field, Limits, World};

/// The materials in the order of red, green, blue and alpha.
pub(crate) const MATERIALS: [&str; 4] = ["grass", "rock", "sand", "snow"];
/// Half of the band in which snow fades out, m.
const SNOW_FADE_M: f32 = 100.0;

type Sized<T> = (Vec<T>, (usize, usize));

/// The shares of all cells, row by row from the north, each of which sums to 255.
pub(super) fn weights(world: &World, export: &Export, limits: &Limits) -> Result<Sized<[u8; 4]>, RunError> {
    let height = &world.layer("height").map_err(super::file)?.field;
    let (w, h) = (height.width(), height.height());
    limits.check_bytes("the splat map", (w * h) as u128 * 4).map_err(super::file)?;
    let sea = (f64::from(height.min_max().0) < world.sea_level_m).then_some(world.sea_level_m as f32);
    let cell = (world.grid.cell_x_m as f32, world.grid.cell_y_m as f32);
    let mut out = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let slope = slope(height, x, y, cell).atan().to_degrees();
            let z = height.get(x, y);
            let rock = step(0.8 * export.rock_slope, 1.2 * export.rock_slope, slope);
            let snow = (1.0 - rock) * step(export.snow_line - SNOW_FADE_M, export.snow_line + SNOW_FADE_M, z);
            // Under the sea it is sand even where there are no beaches.
            let shore = sea.map_or(0.0, |s| if z < s { 1.0 } else { step(export.beach, 0.5 * export.beach, z - s) });
            let sand = (1.0 - rock - snow).max(0.0) * shore;
            out.push(io::shares([1.0 - rock - snow - sand, rock, sand, snow]));
        }
    }
    Ok((out, (w, h)))
}

/// A mask of one material, or of a layer with values from 0 to 1. As in steps with a `mask`, what is less counts as 0 and
/// what is more as 1; `note` hears of it.
pub(super) fn mask(
    world: &World,
    name: &str,
    export: &Export,
    limits: &Limits,
    note: &dyn Fn(String),
) -> Result<Sized<u8>, RunError> {
    if let Some(layer) = world.get(name) {
        let size = (layer.width(), layer.height());
        limits.check_bytes("the mask", (size.0 * size.1) as u128).map_err(super::file)?;
        let (low, high) = layer.min_max();
        if low < 0.0 || high > 1.0 {
            note(format!(
                "layer `{name}` holds values from {low} to {high}; in a mask those below 0 are 0 and those above 1 are 1"
            ));
        }
        return Ok((layer.iter().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect(), size));
    }
    let (weights, size) = weights(world, export, limits)?;
    let i = MATERIALS.iter().position(|m| *m == name).unwrap_or(0);
    Ok((weights.iter().map(|w| w[i]).collect(), size))
}

/// Rise over run by central differences, one-sided on the rim.
fn slope(height: &Field, x: usize, y: usize, cell: (f32, f32)) -> f32 {
    let (west, east) = (x.saturating_sub(1), (x + 1).min(height.width() - 1));
    let (north, south) = (y.saturating_sub(1), (y + 1).min(height.height() - 1));
    let dx = (height.get(east, y) - height.get(west, y)) / ((east - west).max(1) as f32 * cell.0);
    let dy = (height.get(x, south) - height.get(x, north)) / ((south - north).max(1) as f32 * cell.1);
    (dx * dx + dy * dy).sqrt()
}

/// The smooth step from 0 at `a` to 1 at `b`; falls if `b` is less. A hard step if both are equal.
fn step(a: f32, b: f32, x: f32) -> f32 {
    if a == b {
        return if x >= a { 1.0 } else { 0.0 };
    }
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;
    use eyot_core::{Grid, Rim};

    #[test]
    fn slopes_beaches_and_peaks_have_their_materials() {
        let limits = Limits::default();
        let mut world = World::new(Grid::new(64, 3, 10.0, Rim::CLOSED, &limits).unwrap(), 1);
        // Seabed, a flat beach, meadow, a 45 degree wall and a snow field.
        let z = |x: usize| match x {
            0..10 => -20.0,
            10..20 => 1.0,
            20..30 => 50.0,
            30..50 => 50.0 + 10.0 * (x - 29) as f32,
            _ => 250.0,
        };
        world.put(&known::HEIGHT, Field::from_fn(64, 3, |x, _| z(x))).unwrap();
        let export = Export { snow_line: 150.0, ..Export::default() };
        let (w, size) = weights(&world, &export, &limits).unwrap();
        assert_eq!(size, (64, 3));
        assert!(w.iter().all(|w| w.iter().map(|&v| u32::from(v)).sum::<u32>() == 255));
        for (x, material) in [(5, 2), (15, 2), (25, 0), (40, 1), (60, 3)] {
            assert_eq!(w[64 + x][material], 255, "{x}: {:?}", w[64 + x]);
        }
        let notes = std::cell::RefCell::new(Vec::new());
        let mask = |name| mask(&world, name, &export, &limits, &|n| notes.borrow_mut().push(n)).unwrap().0;
        assert!(mask("rock").iter().zip(&w).all(|(r, w)| *r == w[1]));
        assert!(notes.borrow().is_empty());
        // Below the sea, and far above 1 m.
        let height = mask("height");
        assert_eq!((height[0], height[40]), (0, 255));
        assert!(notes.borrow()[0].contains("from -20 to 250"), "{notes:?}");
    }
}
