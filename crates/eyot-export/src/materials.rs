//! What the ground is made of, as shares for game engines: the materials grass, rock, sand and snow, and the finer classes of the ground.
//!
//! They are the classification that pictures take their colours from ([`eyot_render::cover`]), so that a mask is where the picture shows it. A
//! material is the sum of its classes. `rock_slope`, `beach` and `snow_line` of an export, and palette, tree line and season of the recipe's view
//! change it.
//!
//! A cell's shares need two rows of neighbours and nothing else, so they are made while they are written.

use crate::files::Job;
use crate::{below, masks};
use eyot_core::{Result, World};
use eyot_io::Source;
use eyot_io::{self as io, About, Rows};
use eyot_recipe::{Export, GROUND, MATERIALS};
use eyot_render::Looks;
use eyot_render::cover::{Cover, HALO, LAYERS, Strip, Weights, materials};
use rayon::prelude::*;

/// What decides of the shares beside the layers.
pub(crate) struct Ground<'a> {
    /// The world; of a streamed one, an overview in coarser cells.
    world: &'a World,
    pub(crate) looks: Looks,
}

impl<'a> Ground<'a> {
    /// Of a world that looks like this.
    #[cfg(test)]
    pub(crate) fn new(world: &'a World, looks: Looks) -> Self {
        Self { world, looks }
    }

    /// Of the job's world as an export sees it.
    pub(crate) fn of(job: &Job<'a>, export: &Export) -> Self {
        let looks = Looks {
            rock_slope_deg: export.rock_slope,
            beach_m: export.beach,
            snow_line_m: export.snow_line.or(job.looks.snow_line_m),
            ..job.looks.clone()
        };
        Self { world: job.world, looks }
    }
}

/// The layers of a world that its ground and its masks follow from.
pub(crate) fn layers(world: &World) -> Vec<&'static str> {
    LAYERS.into_iter().filter(|name| world.get(name).is_some()).chain(masks::layers(world)).collect()
}

/// The shares of all materials, row by row.
pub(crate) struct Materials<'a> {
    layers: [Option<Box<dyn Rows + 'a>>; LAYERS.len()],
    size: (usize, usize),
    about: About,
    cover: Cover,
}

impl<'a> Materials<'a> {
    /// Of the ground of `source`, if there is a height.
    pub(crate) fn of(source: &'a dyn Source, ground: &Ground<'_>) -> Option<Self> {
        let (about, height) = source.layer("height")?;
        let size = height.size();
        let layers = LAYERS.map(|name| source.layer(name).map(|(_, rows)| rows).filter(|rows| rows.size() == size));
        // Without a range, which only layers without values lack, all of it counts as sea.
        let low = about.range.map_or(f32::MIN, |(low, _)| low);
        let looks =
            ground.looks.resolved(|name| LAYERS.iter().zip(&layers).any(|(l, rows)| *l == name && rows.is_some()));
        let cell_m = [about.cell_m.0, about.cell_m.1];
        let cover = Cover::new(cell_m, low, ground.world.sea_level_m, ground.world.seed, &looks);
        Some(Self { layers, size, about, cover })
    }

    /// Columns and rows.
    pub(crate) fn size(&self) -> (usize, usize) {
        self.size
    }

    /// What `share` makes of the classes of each cell of whole rows from `first` on.
    fn each<T: Send>(&mut self, first: usize, out: &mut [T], share: impl Fn(&Weights) -> T + Sync) -> Result<()> {
        let (w, h) = self.size;
        let (from, to) = (first.saturating_sub(HALO), (first + out.len() / w + HALO).min(h));
        let mut values: [Option<Vec<f32>>; LAYERS.len()] = Default::default();
        for (values, rows) in values.iter_mut().zip(&mut self.layers) {
            if let Some(rows) = rows {
                let mut band = vec![0.0; (to - from) * w];
                rows.read(from, &mut band)?;
                *values = Some(band);
            }
        }
        let (strip, cover) = (Strip::new(w, from, values), &self.cover);
        out.par_chunks_mut(w).enumerate().for_each(|(i, out)| {
            out.iter_mut().enumerate().for_each(|(x, o)| *o = share(&cover.weights(&strip, x, first + i)));
        });
        Ok(())
    }

    /// The shares of whole rows from `first` on as bytes that sum to exactly 255.
    pub(crate) fn read_bytes(&mut self, first: usize, out: &mut [[u8; 4]]) -> Result<()> {
        self.each(first, out, |w| io::shares(materials(w)))
    }
}

/// What a raster of shares holds.
#[derive(Clone, Copy)]
enum Part {
    /// A material by its number.
    Material(usize),
    /// A class of the ground by its number.
    Class(usize),
}

/// The rows of one material or class.
struct Share<'a> {
    all: Materials<'a>,
    part: Part,
    /// In 255ths that sum to 1 over all materials.
    bytes: bool,
}

impl Rows for Share<'_> {
    fn size(&self) -> (usize, usize) {
        self.all.size()
    }

    fn read(&mut self, first: usize, out: &mut [f32]) -> Result<()> {
        let (part, bytes) = (self.part, self.bytes);
        self.all.each(first, out, |w| match part {
            Part::Material(i) if bytes => f32::from(io::shares(materials(w))[i]) / 255.0,
            Part::Material(i) => materials(w)[i],
            Part::Class(i) => w[i],
        })
    }
}

/// A layer of the source or else a material, a class or one of the [`masks`]: exact, or as shares of `bytes`.
pub(crate) fn layer<'a>(
    source: &'a dyn Source,
    name: &str,
    ground: &Ground<'_>,
    bytes: bool,
) -> Option<(About, Box<dyn Rows + 'a>)> {
    if let Some(found) = source.layer(name) {
        return Some(found);
    }
    let (place, height) = source.layer("height")?;
    let whole = height.size() == (ground.world.grid.width, ground.world.grid.height);
    if whole && let Some(top) = below::top(ground.world, name).ok().flatten() {
        let about = About {
            name: name.to_owned(),
            unit: "m".to_owned(),
            meaning: below::TOP.to_owned(),
            range: Some(top.min_max()),
            ..place
        };
        return Some((about, Box::new(masks::Whole { size: height.size(), values: top.to_vec() })));
    }
    // A mask is made of the whole world, so there is none of a streamed one.
    if whole && let Some(mask) = masks::of(ground.world, name, ground).ok().flatten() {
        let mask = if bytes { mask.shares() } else { mask };
        let about = About {
            name: name.to_owned(),
            unit: mask.unit.to_owned(),
            meaning: mask.meaning.to_owned(),
            range: Some(mask.range()),
            ..place
        };
        return Some((about, Box::new(masks::Whole { size: height.size(), values: mask.values })));
    }
    drop(height);
    let material = MATERIALS.iter().position(|m| *m == name).map(Part::Material);
    let part = material.or_else(|| GROUND.iter().position(|c| *c == name).map(Part::Class))?;
    let all = Materials::of(source, ground)?;
    let about = About {
        name: name.to_owned(),
        unit: "1".to_owned(),
        meaning: format!("Share of the ground that is {}", name.replace('_', " ")),
        range: Some((0.0, 1.0)),
        ..all.about.clone()
    };
    Some((about, Box::new(Share { all, part, bytes })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;
    use eyot_core::{Boundary, Field, Grid, Limits, World};
    use eyot_render::{Class, terrain_colours};

    #[test]
    fn recipes_and_pictures_have_the_same_classes() {
        assert_eq!(Class::ALL.map(Class::name), GROUND);
        assert!(GROUND.iter().all(|c| !MATERIALS.contains(c)));
    }

    #[test]
    fn slopes_beaches_and_peaks_have_their_materials() {
        let limits = Limits::default();
        let mut world = World::new(Grid::new(64, 3, 10.0, Boundary::CLOSED, &limits).unwrap(), 1);
        // Seabed, a flat beach, meadow, a 60 degree wall and a snow field.
        let z = |x: usize| match x {
            0..10 => -20.0,
            10..20 => 1.0,
            20..30 => 50.0,
            30..50 => 50.0 + 17.3 * (x - 29) as f32,
            _ => 450.0,
        };
        world.put(&known::HEIGHT, Field::from_fn(64, 3, |x, _| z(x))).unwrap();
        let ground = Ground::new(&world, Looks { snow_line_m: Some(200.0), beach_m: Some(3.0), ..Looks::default() });
        let mut materials = Materials::of(&world, &ground).unwrap();
        assert_eq!(materials.size(), (64, 3));
        let mut whole = vec![[0; 4]; 64 * 3];
        materials.read_bytes(0, &mut whole).unwrap();
        assert!(whole.iter().all(|w| w.iter().map(|&v| u32::from(v)).sum::<u32>() == 255));
        for (x, material) in [(5, 2), (15, 2), (25, 0), (40, 1), (60, 3)] {
            assert!(whole[64 + x][material] > 180, "{x}: {:?}", whole[64 + x]);
        }
        // The same from a row alone, which sees its neighbours all the same.
        let mut row = vec![[0; 4]; 64];
        materials.read_bytes(1, &mut row).unwrap();
        assert_eq!(row, whole[64..128]);

        // Exact shares, those of bytes, and classes.
        let read = |name, bytes| {
            let (about, mut rows) = layer(&world, name, &ground, bytes).unwrap();
            let mut out = vec![0.0; 64 * 3];
            rows.read(0, &mut out).unwrap();
            ((about.name, about.unit), out)
        };
        let (said, exact) = read("rock", false);
        let (_, bytes) = read("rock", true);
        assert_eq!(said, ("rock".to_owned(), "1".to_owned()));
        assert!(exact.iter().zip(&bytes).all(|(e, b)| (e - b).abs() < 1.0 / 255.0));
        let classes: f32 = GROUND.iter().map(|c| read(c, false).1[64 + 40]).sum();
        assert!((classes - 1.0).abs() < 1e-5, "{classes}");
        assert!(layer(&world, "moss", &ground, true).is_none());
    }

    /// What the splat map calls rock or grass is what the picture shows: grey, or green and yellow, with little blue.
    #[test]
    fn masks_are_where_pictures_show_them() {
        let mut world = World::new(Grid::new(96, 96, 20.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
        let hills = |x: f32, y: f32| 500.0 + 260.0 * (0.09 * x).sin() * (0.11 * y).cos();
        world.put(&known::HEIGHT, Field::from_fn(96, 96, |x, y| hills(x as f32, y as f32))).unwrap();
        let looks = Looks::default();
        let mut shares = vec![[0u8; 4]; 96 * 96];
        Materials::of(&world, &Ground::new(&world, looks.clone())).unwrap().read_bytes(0, &mut shares).unwrap();
        let colours = terrain_colours(&world, &looks).unwrap();
        let (mut grass, mut rock) = (0, 0);
        for (s, c) in shares.iter().zip(&colours) {
            if s[0] > 240 {
                grass += 1;
                assert!(c[2] < 0.6 * c[1], "grass of the colour {c:?}");
            } else if s[1] > 240 {
                rock += 1;
                assert!(c[2] > 0.6 * c[1], "rock of the colour {c:?}");
            }
        }
        assert!(grass > 500 && rock > 100, "{grass} cells of grass, {rock} of rock");
    }
}
