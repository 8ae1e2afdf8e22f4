//! A volcanic island of one or more volcanoes, each of its own height, age and place, with all that tells one island from another.
//!
//! # Equations
//! Heights `z` in m over the sea, distances over the radius `R` of a volcano at the sea: `r = |p - c| / (R m)`. Places `p` are displaced by
//! noise, so that nothing is round or straight.
//! 1. Rift zones, two or three arms with unit directions `d_k`: `m = 1 + rifts sum_k a_k (max(0, u . d_k)^6 - 1/8)`, `u` the direction
//!    from the centre.
//! 2. Flank: `z = H (e^(-k s) - e^(-k)) / (e^(-k e) - e^(-k))` with `s = sqrt(r^2 + e^2)`: `k > 0` is concave as stratovolcanoes are,
//!    `k < 0` a shield; `e` rounds the summit off. Below the sea the flank falls by 0.35 at least.
//! 3. Everything hollow is a trough along a line from its head down to the sea, `t` the place along it (0 to 1), `d` the distance from it:
//!    `z' = min(z, z_h (1 - t)^2 - b t + g (sqrt(f^2 + w^2) - w))` with `f = max(0, d - w)`, a flat floor between walls of slope `g`. Calderas have no length, amphitheatre
//!    valleys are narrow (their number and depth grow with age), scars of giant landslides wide. `b` is how far the mouth is drowned.
//! 4. Young flanks carry cinder cones along the rifts, with craters. Volcanoes are joined by the larger of their heights.
//! 5. Surf cuts what rose less than `c` over the sea down to a platform: `z' = -2 - 0.1 (c - z)` where `z < c`; `c` is `cliffs` times the age
//!    and a noise, full to windward and a quarter in the lee.
//! 6. A shelf surrounds it all: `z' = max(z, -shelf_depth)` within `1 + shelf` radii and `radius`, then the slope of reef rubble, 1 in 2, to the floor.
//!
//! Minimum and maximum are rounded off over some metres.
//!
//! # Source
//! Forms and their order in time after MacDonald, Abbott and Peterson 1983 (shields, rift zones, calderas, amphitheatre valleys of the
//! Pacific's islands), Moore and others 1989 (giant landslides) and Ramalho and others 2013 (coasts, cliffs and shelves of ageing
//! islands). The formulas are Eyot's: they draw what these describe and simulate none of it.
//!
//! # Layers
//! Makes a new field from its parameters, the seed and the sea's level: the floor lies `depth` below that.
//!
//! # Limits
//! What is drawn is scaled and moved so that island and shelf lie within `radius` of the middle, but for the noise.

mod draw;
mod shape;

use super::check;
use super::noise::{Noise, PIECE, PIECE_COLUMNS, Piece};
use draw::Island;
use eyot_core::isa::Isa;
use eyot_core::lanes::WIDTH;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Error, Field, Grid, Result, rng};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shape::Chance;

/// A volcanic island, a different one for each seed. Pairs of numbers are the lowest and highest value that the seed draws from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct VolcanicIsland {
    /// How many volcanoes make the island: one is a Gough or a Moorea, two a Réunion, three a Rapa Nui.
    #[schemars(inner(range(min = 1, max = 8)), extend("unit" = "1"))]
    pub volcanoes: [u32; 2],
    /// Height over the sea that no volcano exceeds; age, calderas and valleys take from it.
    #[schemars(range(min = 0.0, max = 9000.0), extend("unit" = "m"))]
    pub height: f32,
    /// Share of the height by which the highest volcano of a seed may stay below it.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub variation: f32,
    /// Distance from the middle of the grid that island and shelf fill, as a share of the shorter side. At 0.5 they touch the rim.
    #[schemars(range(min = 0.05, max = 1.0), extend("unit" = "1"))]
    pub radius: f32,
    /// Age of the volcanoes: 0 is growing, with smooth flanks and cinder cones; at 0.5 valleys have cut deep; 1 is a skeleton of ridges
    /// whose valleys the sea has entered.
    #[schemars(inner(range(min = 0.0, max = 1.0)), extend("unit" = "1"))]
    pub age: [f32; 2],
    /// How far rift zones draw the volcanoes out into arms; 0 makes them round.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub rifts: f32,
    /// Probability that a volcano has a caldera. Old ones drain through a gap.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub calderas: f32,
    /// Probability that a flank of a volcano has slid into the sea.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub collapses: f32,
    /// How irregular coast, valleys and ridges are.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub roughness: f32,
    /// Height of sea cliffs on the oldest, windward coasts.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub cliffs: f32,
    /// Where the wind comes from, clockwise from north. The trades blow from the east.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub wind: f32,
    /// Width of the shelf around the island in its radii: half of it in places, all of it in others, and less around young volcanoes.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "1"))]
    pub shelf: f32,
    /// Depth of the shelf below the sea.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "m"))]
    pub shelf_depth: f32,
    /// Depth of the sea floor around the island.
    #[schemars(range(min = 0.0, max = 12000.0), extend("unit" = "m"))]
    pub depth: f32,
}

impl Default for VolcanicIsland {
    fn default() -> Self {
        Self {
            volcanoes: [1, 3],
            height: 1150.0,
            variation: 0.5,
            radius: 0.46,
            age: [0.1, 1.0],
            rifts: 0.5,
            calderas: 0.6,
            collapses: 0.4,
            roughness: 0.5,
            cliffs: 60.0,
            wind: 80.0,
            shelf: 0.35,
            shelf_depth: 4.0,
            depth: 130.0,
        }
    }
}

impl Generator for VolcanicIsland {
    fn generate(&self, site: &Site<'_>, _base: &Field) -> Result<Field> {
        self.check(&site.grid)?;
        let g = site.grid;
        let (w_m, h_m) = g.extent_m();
        let island = Island::draw(self, w_m.min(h_m), site.seed);
        let size_m = f64::from(self.radius) * w_m.min(h_m);
        let rough = f64::from(self.roughness);
        // Bends of coasts and valleys, the ground itself, and what differs along the coast.
        let noise = |stream: u64, scale_m: f64, octaves: u32| {
            Noise { scale_m, octaves, seed: rng::mix64(site.seed ^ stream), ..Noise::default() }
                .prepare(&g, Isa::best())
        };
        let noises = [
            noise(0x77, 0.55 * size_m, 5),
            noise(0x7e, 0.55 * size_m, 5),
            noise(0x67, 0.3 * size_m, 8),
            noise(0x63, 0.5 * size_m, 3),
        ];
        let bend_m = 0.3 * rough * size_m;
        let sea = site.world.sea_level_m;
        Field::from_rows(g.width, site.rows.clone(), site.control, |y, row| {
            let y_m = (y as f64 + 0.5) * g.cell_y_m - 0.5 * h_m;
            for (x0, piece) in (0..).step_by(PIECE_COLUMNS).zip(row.chunks_mut(PIECE_COLUMNS)) {
                let mut values: [Piece; 4] = [[[0.0; WIDTH]; PIECE]; 4];
                for (noise, out) in noises.iter().zip(&mut values) {
                    noise.piece(x0, y, piece.len().div_ceil(WIDTH), None, out);
                }
                let [bend_x, bend_y, ground, coast] = values.each_ref().map(|v| v.as_flattened());
                for (i, v) in piece.iter_mut().enumerate() {
                    let x_m = ((x0 + i) as f64 + 0.5) * g.cell_x_m - 0.5 * w_m;
                    let place = [x_m + bend_m * f64::from(bend_x[i]), y_m + bend_m * f64::from(bend_y[i])];
                    let chance = Chance { ground: rough * f64::from(ground[i]), coast: f64::from(coast[i]) };
                    *v = (sea + island.height_m(place, chance)) as f32;
                }
            }
        })
    }

    fn check(&self, _grid: &Grid) -> Result<()> {
        check("volcanic_island", self)?;
        let pairs = [("volcanoes", self.volcanoes.map(|n| n as f32)), ("age", self.age)];
        match pairs.into_iter().find(|(_, [low, high])| low > high) {
            Some((field, [low, high])) => Err(Error::BadParameter {
                owner: "volcanic_island".into(),
                field: field.into(),
                reason: format!("the lowest value, {low}, must not be above the highest, {high}"),
            }),
            None => Ok(()),
        }
    }

    fn reach(&self, _grid: &Grid) -> Reach {
        Reach::Cell
    }
}
