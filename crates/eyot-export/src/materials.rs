//! What the ground is made of, as shares for game engines: grass, rock, sand and snow by slope, height and sea.
//!
//! Plainer than the colours of the pictures on purpose: three numbers that a level designer can turn. With s the slope in
//! degrees, h the height and S(a, b, x) the smooth step from 0 at a to 1 at b:
//! - rock = S(0.8 r, 1.2 r, s) with r the slope at which rock begins (`rock_slope`);
//! - snow = S(l - 100, l + 100, h) of the rest, with l the snow line (`snow_line`);
//! - sand = S(b, b / 2, h above the sea) of what is left, with b the height of beaches (`beach`), if there is a sea;
//! - grass is what remains.
//!
//! A cell's shares need its neighbours' heights and nothing else, so they are made while they are written.

use eyot_core::Result;
use eyot_io::Source;
use eyot_io::{self as io, About, Rows};
use eyot_recipe::Export;
use eyot_recipe::MATERIALS;
use rayon::prelude::*;

/// Half of the band in which snow fades out, m.
const SNOW_FADE_M: f32 = 100.0;

/// The shares of all materials, row by row.
pub(crate) struct Materials<'a> {
    height: Box<dyn Rows + 'a>,
    size: (usize, usize),
    about: About,
    ground: Ground,
}

impl<'a> Materials<'a> {
    /// Of the height of `source`, if there is one.
    pub(crate) fn of(source: &'a dyn Source, sea_level_m: f64, export: &Export) -> Option<Self> {
        let (about, height) = source.layer("height")?;
        let under = about.range.is_none_or(|(low, _)| f64::from(low) < sea_level_m);
        let ground = Ground {
            cell: (about.cell_m.0 as f32, about.cell_m.1 as f32),
            sea: under.then_some(sea_level_m as f32),
            rock_slope: export.rock_slope,
            beach: export.beach,
            snow_line: export.snow_line,
        };
        Some(Self { size: height.size(), height, about, ground })
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> (usize, usize) {
        self.size
    }

    /// The shares of whole rows from `first` on, each from 0 to 1; those of a cell sum to 1.
    pub(crate) fn read(&mut self, first: usize, out: &mut [[f32; 4]]) -> Result<()> {
        let (w, h) = self.size;
        // One more row on either side.
        let (from, to) = (first.saturating_sub(1), (first + out.len() / w + 1).min(h));
        let mut heights = vec![0.0; (to - from) * w];
        self.height.read(from, &mut heights)?;
        let ground = self.ground;
        out.par_chunks_mut(w).enumerate().for_each(|(i, out)| {
            let row = first + i - from;
            out.iter_mut().enumerate().for_each(|(x, shares)| *shares = ground.shares(&heights, w, x, row));
        });
        Ok(())
    }

    /// As [`Materials::read`], as bytes that sum to exactly 255.
    pub(crate) fn read_bytes(&mut self, first: usize, out: &mut [[u8; 4]]) -> Result<()> {
        let mut shares = vec![[0.0; 4]; out.len()];
        self.read(first, &mut shares)?;
        out.par_iter_mut().zip(shares).for_each(|(o, s)| *o = io::shares(s));
        Ok(())
    }
}

/// What decides of the shares beside the heights.
#[derive(Clone, Copy)]
struct Ground {
    cell: (f32, f32),
    sea: Option<f32>,
    rock_slope: f32,
    beach: f32,
    snow_line: f32,
}

impl Ground {
    /// The shares of a cell of some rows of `w` heights.
    fn shares(&self, heights: &[f32], w: usize, x: usize, row: usize) -> [f32; 4] {
        let z = heights[row * w + x];
        let slope = self.slope(heights, w, x, row).atan().to_degrees();
        let rock = step(0.8 * self.rock_slope, 1.2 * self.rock_slope, slope);
        let snow = (1.0 - rock) * step(self.snow_line - SNOW_FADE_M, self.snow_line + SNOW_FADE_M, z);
        // Under the sea it is sand even where there are no beaches.
        let shore = self.sea.map_or(0.0, |s| if z < s { 1.0 } else { step(self.beach, 0.5 * self.beach, z - s) });
        let sand = (1.0 - rock - snow).max(0.0) * shore;
        [(1.0 - rock - snow - sand).max(0.0), rock, sand, snow]
    }

    /// Rise over run by central differences, one-sided on the rim.
    fn slope(&self, heights: &[f32], w: usize, x: usize, row: usize) -> f32 {
        let height = |x: usize, y: usize| heights[y * w + x];
        let (west, east) = (x.saturating_sub(1), (x + 1).min(w - 1));
        let (north, south) = (row.saturating_sub(1), (row + 1).min(heights.len() / w - 1));
        let dx = (height(east, row) - height(west, row)) / ((east - west).max(1) as f32 * self.cell.0);
        let dy = (height(x, south) - height(x, north)) / ((south - north).max(1) as f32 * self.cell.1);
        (dx * dx + dy * dy).sqrt()
    }
}

/// The rows of one material.
struct Share<'a> {
    all: Materials<'a>,
    index: usize,
    /// In 255ths that sum to 1 over all materials.
    bytes: bool,
}

impl Rows for Share<'_> {
    fn size(&self) -> (usize, usize) {
        self.all.size()
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> Result<()> {
        if self.bytes {
            let mut bytes = vec![[0; 4]; out.len()];
            self.all.read_bytes(first, &mut bytes)?;
            out.iter_mut().zip(bytes).for_each(|(o, b)| *o = f32::from(b[self.index]) / 255.0);
        } else {
            let mut shares = vec![[0.0; 4]; out.len()];
            self.all.read(first, &mut shares)?;
            out.iter_mut().zip(shares).for_each(|(o, s)| *o = s[self.index]);
        }
        Ok(())
    }
}

/// A layer of the source or else a material: exact shares, or those of `bytes`.
pub(crate) fn layer<'a>(
    source: &'a dyn Source,
    name: &str,
    sea_level_m: f64,
    export: &Export,
    bytes: bool,
) -> Option<(About, Box<dyn Rows + 'a>)> {
    if let Some(found) = source.layer(name) {
        return Some(found);
    }
    let index = MATERIALS.iter().position(|m| *m == name)?;
    let all = Materials::of(source, sea_level_m, export)?;
    let about = About {
        name: name.to_owned(),
        unit: "1".to_owned(),
        meaning: format!("Share of the ground that is {name}"),
        range: Some((0.0, 1.0)),
        ..all.about.clone()
    };
    Some((about, Box::new(Share { all, index, bytes })))
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
    use eyot_core::{Field, Grid, Limits, Rim, World};

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
        let mut materials = Materials::of(&world, 0.0, &export).unwrap();
        assert_eq!(materials.size(), (64, 3));
        let mut whole = vec![[0; 4]; 64 * 3];
        materials.read_bytes(0, &mut whole).unwrap();
        assert!(whole.iter().all(|w| w.iter().map(|&v| u32::from(v)).sum::<u32>() == 255));
        for (x, material) in [(5, 2), (15, 2), (25, 0), (40, 1), (60, 3)] {
            assert_eq!(whole[64 + x][material], 255, "{x}: {:?}", whole[64 + x]);
        }
        // The same from a row alone, which sees its neighbours all the same.
        let mut row = vec![[0; 4]; 64];
        materials.read_bytes(1, &mut row).unwrap();
        assert_eq!(row, whole[64..128]);

        // A wall of 45 degrees is half rock where rock begins at 45: no multiple of 1/255.
        let export = Export { rock_slope: 45.0, ..export };
        let read = |bytes| {
            let (about, mut rows) = layer(&world, "rock", 0.0, &export, bytes).unwrap();
            let mut out = vec![0.0; 64 * 3];
            rows.read(0, &mut out).unwrap();
            ((about.name, about.unit), out)
        };
        let (said, exact) = read(false);
        let (_, bytes) = read(true);
        assert_eq!(said, ("rock".to_owned(), "1".to_owned()));
        assert!((exact[64 + 40] - 0.5).abs() < 1e-6 && (bytes[64 + 40] * 255.0 - 127.5).abs() > 0.4);
        assert!(exact.iter().zip(&bytes).all(|(e, b)| (e - b).abs() < 1.0 / 255.0));
        assert!(layer(&world, "moss", 0.0, &export, true).is_none());
    }
}
