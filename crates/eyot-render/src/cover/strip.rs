//! Rows of the layers that ground is classified by, and what they say of one cell.

use super::Cover;
use crate::climate;
use crate::math::{V3, mix, smoothstep};
use eyot_core::World;
use eyot_noise::picture::fbm;

/// Rows to the north and to the south of a cell that its classes depend on.
pub const HALO: usize = 2;

/// The layers that are read where a world has them, the height first.
pub const LAYERS: [&str; 14] = [
    "height",
    "wetness",
    "limestone",
    "growth",
    "aridity",
    "temperature_mean",
    "temperature",
    "rain_mean",
    "precipitation",
    "ice",
    "material",
    "forest",
    "shrubs",
    "grass",
];
const HEIGHT: usize = 0;
const WETNESS: usize = 1;
const LIMESTONE: usize = 2;
const GROWTH: usize = 3;
const ARIDITY: usize = 4;
const WARMTH: [usize; 2] = [5, 6];
const RAIN: [usize; 2] = [7, 8];
const ICE: usize = 9;
const MATERIAL: usize = 10;
const FOREST: usize = 11;
const SHRUBS: usize = 12;
const GRASS: usize = 13;

/// Whole rows of the [`LAYERS`] of a world.
pub struct Strip {
    width: usize,
    /// The world's row that is the first here.
    first: usize,
    values: [Option<Vec<f32>>; LAYERS.len()],
}

impl Strip {
    /// All rows of a world. One without a height has none.
    pub fn whole(world: &World) -> Self {
        Self::new(world.grid.width, 0, LAYERS.map(|name| world.get(name).map(|f| f.to_vec())))
    }

    /// Rows of `width` cells from the row `first` of a world on, in the order of [`LAYERS`].
    pub fn new(width: usize, first: usize, values: [Option<Vec<f32>>; LAYERS.len()]) -> Self {
        Self { width, first, values }
    }

    fn rows(&self) -> usize {
        self.values[HEIGHT].as_ref().map_or(0, |v| v.len() / self.width)
    }

    /// The value of a layer; nothing where there is no such layer, number or cell.
    fn get(&self, layer: usize, x: usize, row: usize) -> Option<f32> {
        self.values[layer].as_ref().map(|v| v[row * self.width + x]).filter(|v| v.is_finite())
    }

    /// The first of two layers that is there.
    fn either(&self, layers: [usize; 2], x: usize, row: usize) -> Option<f32> {
        let layer = layers.into_iter().find(|&l| self.values[l].is_some())?;
        Some(self.get(layer, x, row).unwrap_or(0.0))
    }

    /// The plane that fits the cells up to [`HALO`] away best: its height in their middle and its rise a cell eastward and southward. Single
    /// rough cells are no cliffs.
    fn plane(&self, x: usize, row: usize, z: impl Fn(usize, usize) -> f32) -> (f32, [f32; 2]) {
        let span = |i: usize, n: usize| (i.saturating_sub(HALO), (i + HALO).min(n - 1));
        let ((x0, x1), (y0, y1)) = (span(x, self.width), span(row, self.rows()));
        let middle = |a: usize, b: usize| 0.5 * (a + b) as f32;
        let (mx, my) = (middle(x0, x1), middle(y0, y1));
        let centre = z(x, row);
        let (mut sum, mut rise, mut squares) = (0.0, [0.0; 2], [0.0f32; 2]);
        for y in y0..=y1 {
            for x in x0..=x1 {
                // Heights over the middle cell's are small numbers, which add up without loss.
                let (dx, dy, dz) = (x as f32 - mx, y as f32 - my, z(x, y) - centre);
                sum += dz;
                rise = [rise[0] + dx * dz, rise[1] + dy * dz];
                squares = [squares[0] + dx * dx, squares[1] + dy * dy];
            }
        }
        let count = ((x1 - x0 + 1) * (y1 - y0 + 1)) as f32;
        (centre + sum / count, [rise[0] / squares[0].max(1.0), rise[1] / squares[1].max(1.0)])
    }

    /// Mean over the cells up to `reach` away, those beyond the rim left out.
    fn mean(&self, x: usize, row: usize, reach: usize, value: impl Fn(usize, usize) -> f32) -> f32 {
        let (x0, x1) = (x.saturating_sub(reach), (x + reach).min(self.width - 1));
        let (y0, y1) = (row.saturating_sub(reach), (row + reach).min(self.rows() - 1));
        let mut sum = 0.0;
        for y in y0..=y1 {
            for x in x0..=x1 {
                sum += value(x, y);
            }
        }
        sum / ((x1 - x0 + 1) * (y1 - y0 + 1)) as f32
    }
}

/// What the classes of one cell depend on.
pub(super) struct Site {
    /// Height above the sea or the world's zero, m.
    pub z: f32,
    /// Rise over run.
    pub slope: f32,
    /// From -1, steep towards the midday sun of the northern hemisphere, to 1, steep away from it.
    pub shade: f32,
    /// Hollow (positive) or ridge (negative), about -1..1.
    pub hollow: f32,
    /// Noise over the land, over hills and over single cells, each about -0.6..0.6.
    pub region: f32,
    pub broad: f32,
    pub fine: f32,
    pub wetness: f32,
    pub aridity: f32,
    /// Share of reef or of limestone that a reef left.
    pub reef: f32,
    /// Temperature, °C, and rain as a share of what plants could use, of a world with a climate.
    pub climate: Option<(f32, f32)>,
    /// Share that ice covers.
    pub ice: f32,
    /// Share that trees cover, where the world knows it.
    pub forest: Option<f32>,
    /// Shares that bushes and grass cover, where the world knows them.
    pub low: Option<[f32; 2]>,
    /// Colour of the rock or of the loose ground, where the world knows it.
    pub rock: Option<V3>,
}

impl Cover {
    pub(super) fn site(&self, strip: &Strip, x: usize, y: usize) -> Site {
        let row = y - strip.first;
        let z = |x: usize, row: usize| strip.get(HEIGHT, x, row).unwrap_or(self.low) - self.datum;
        let (here, cell) = (z(x, row), self.cell[0].min(self.cell[1]));
        let (around, [gx, gy]) = strip.plane(x, row, z);
        let (gx, gy) = (gx / self.cell[0], gy / self.cell[1]);
        let slope = gx.hypot(gy);
        let place = [x as f32 * self.cell[0], y as f32 * self.cell[1]];
        // Lengths in metres, but never so short that single cells differ at random.
        let noise = |metres: f32, cells: f32, octaves: u32, salt: u32| {
            let length = metres.max(cells * self.cell[0].max(self.cell[1]));
            self.variation * fbm(place[0] / length, place[1] / length, octaves, self.seed ^ salt)
        };
        let (region, broad, fine) = (noise(4200.0, 90.0, 3, 0x9e), noise(620.0, 22.0, 4, 0), noise(75.0, 5.0, 3, 0x51));
        let share = |layer: usize| strip.get(layer, x, row).unwrap_or(0.0).clamp(0.0, 1.0);
        let climate = strip.either(WARMTH, x, row).zip(strip.either(RAIN, x, row)).map(|(t, _)| {
            let t = t + 2.0 * broad + 1.2 * fine;
            // Land cover does not follow single cells. Rain against what plants could use, as Holdridge has it; a cold country needs little.
            let rain = strip.mean(x, row, 1, |x, row| strip.either(RAIN, x, row).unwrap_or(0.0));
            (t, rain.max(0.0) / (58.93 * t.clamp(2.0, 30.0)))
        });
        Site {
            z: here,
            slope,
            shade: gy / (1.0 + slope * slope).sqrt(),
            hollow: (4.0 * (around - here) / cell).clamp(-1.5, 1.5),
            region,
            broad,
            fine,
            wetness: share(WETNESS),
            aridity: share(ARIDITY),
            reef: share(GROWTH).max(smoothstep(0.2, 2.5, strip.get(LIMESTONE, x, row).unwrap_or(0.0))),
            climate,
            ice: self.ice(strip, x, row),
            forest: strip.get(FOREST, x, row).map(|share| share.clamp(0.0, 1.0)),
            low: strip
                .get(SHRUBS, x, row)
                .zip(strip.get(GRASS, x, row))
                .map(|(shrubs, grass)| [shrubs, grass].map(|share| share.clamp(0.0, 1.0))),
            rock: self.rock_colour(strip, x, row),
        }
    }

    /// Half of it the cell's own colour, half that of its neighbours, so that beds do not end in stairs.
    fn rock_colour(&self, strip: &Strip, x: usize, row: usize) -> Option<V3> {
        let colour = |x: usize, row: usize| {
            let number = strip.get(MATERIAL, x, row)?;
            self.looks.rocks.get(number as usize).copied()
        };
        let own = colour(x, row)?;
        let around: V3 =
            std::array::from_fn(|i| strip.mean(x, row, 1, |x, row| colour(x, row).map_or(own[i], |c| c[i])));
        Some(mix(own, around, 0.5))
    }

    /// A lake that fills a cell's hollow alone is far smaller than the cell, and as white spots such lakes would be all that is seen of a cold
    /// plain: ice shows where there is more of it around.
    fn ice(&self, strip: &Strip, x: usize, row: usize) -> f32 {
        let cover = |x: usize, row: usize| strip.get(ICE, x, row).map_or(0.0, climate::cover);
        match cover(x, row) {
            c if c > 0.0 => c * smoothstep(0.1, 0.4, strip.mean(x, row, HALO, cover)),
            c => c,
        }
    }
}
