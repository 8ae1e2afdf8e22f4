//! Where a community lives: a rectangle, and what the terrain makes of it.

use super::parameters::{Community, bad};
use super::species::Species;
use eyot_core::math64::exp;
use eyot_core::{Field, Limits, Result};

/// Longest side of a plot, m. Places are kept in single precision, which tells a quarter of a millimetre apart there.
pub const MAX_SIDE_M: f64 = 4096.0;

/// A rectangle of sea floor. x runs from the west side, y from the north side, both in metres.
pub struct Site {
    /// Extent along x, m.
    pub width_m: f64,
    /// Extent along y, m.
    pub length_m: f64,
    /// Depth, light and substrate; without it every place is right for everybody.
    pub ground: Option<Ground>,
}

/// Rasters of the sea floor that cover a site. Row 0 is north, column 0 is west.
pub struct Ground {
    /// Edge of a cell, m.
    pub cell_m: f64,
    /// Depth of the water, m; negative on land.
    pub depth: Field,
    /// Light at the floor as a share of the light at the surface, 0..=1.
    pub light: Field,
    /// Chance that a larva finds hold, 0..=1: 1 on rock, 0 on sand.
    pub substrate: Field,
}

/// What a colony finds at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Depth of the water, m.
    pub depth: f32,
    /// Share of the light at the surface.
    pub light: f32,
    /// Chance that a larva finds hold.
    pub substrate: f32,
}

impl Place {
    /// What a site without rasters has everywhere: 5 m of water, full light, rock.
    pub const FLAT: Self = Self { depth: 5.0, light: 1.0, substrate: 1.0 };

    /// Chance that a larva or a fragment of a species finds hold here.
    pub fn suits(&self, species: &Species) -> f32 {
        let here = (species.min_depth..=species.max_depth).contains(&self.depth) && self.light >= species.min_light;
        if here { self.substrate } else { 0.0 }
    }
}

impl Ground {
    /// Ground of these depths (m) with light that falls off as `e^(-attenuation depth)` and one substrate everywhere.
    /// 0.04 to 0.16 per metre are clear ocean to coastal water (Bosscher and Schlager 1992).
    pub fn of_depth(cell_m: f64, depth: Field, attenuation: f32, substrate: f32) -> Self {
        let (w, h) = (depth.width(), depth.height());
        let light = Field::from_fn(w, h, |x, y| exp(-f64::from(attenuation * depth.get(x, y).max(0.0))) as f32);
        Self { cell_m, depth, light, substrate: Field::new(w, h, substrate) }
    }
}

impl Site {
    /// A rectangle on which every place is right.
    pub const fn flat(width_m: f64, length_m: f64) -> Self {
        Self { width_m, length_m, ground: None }
    }

    /// All of a ground.
    pub fn of_ground(ground: Ground) -> Self {
        let side = |n: usize| n as f64 * ground.cell_m;
        Self { width_m: side(ground.depth.width()), length_m: side(ground.depth.height()), ground: Some(ground) }
    }

    /// Area, m2.
    pub fn area_m2(&self) -> f64 {
        self.width_m * self.length_m
    }

    /// True within the rectangle.
    pub fn contains(&self, x: f32, y: f32) -> bool {
        (0.0..=self.width_m).contains(&f64::from(x)) && (0.0..=self.length_m).contains(&f64::from(y))
    }

    /// What is at a place; outside the rectangle what is at its border.
    pub fn at(&self, x: f32, y: f32) -> Place {
        let Some(g) = &self.ground else { return Place::FLAT };
        let cell = |v: f32, n: usize| ((f64::from(v.max(0.0)) / g.cell_m) as usize).min(n - 1);
        let (i, j) = (cell(x, g.depth.width()), cell(y, g.depth.height()));
        Place { depth: g.depth.get(i, j), light: g.light.get(i, j), substrate: g.substrate.get(i, j) }
    }

    /// # Errors
    /// If sides are out of range, or rasters do not cover the rectangle, or hold something else than their numbers, or turf would
    /// need more cells than the limits allow.
    pub(super) fn check(&self, community: &Community, limits: &Limits) -> Result<()> {
        let owner = "site";
        for (field, side) in [("width_m", self.width_m), ("length_m", self.length_m)] {
            if !(0.1..=MAX_SIDE_M).contains(&side) {
                let reason = format!("{side} m is not within 0.1..={MAX_SIDE_M} m");
                return Err(bad(owner, field, reason));
            }
        }
        let cells = |side: f64| (side / f64::from(community.turf.cell)).ceil() as usize;
        limits.check_cells(cells(self.width_m), cells(self.length_m))?;
        let Some(g) = &self.ground else { return Ok(()) };
        if !(g.cell_m > 0.0 && g.cell_m.is_finite()) {
            return Err(bad(owner, "cell_m", format!("{} is not a length", g.cell_m)));
        }
        let (w, h) = (g.depth.width(), g.depth.height());
        let covers = |n: usize, side: f64| (n as f64 * g.cell_m) >= side * (1.0 - 1e-6);
        if w == 0 || h == 0 || !covers(w, self.width_m) || !covers(h, self.length_m) {
            let reason =
                format!("{w} x {h} cells of {} m do not cover {} x {} m", g.cell_m, self.width_m, self.length_m);
            return Err(bad(owner, "depth", reason));
        }
        let ranges = [
            ("depth", &g.depth, -12000.0..=12000.0),
            ("light", &g.light, 0.0..=1.0),
            ("substrate", &g.substrate, 0.0..=1.0),
        ];
        for (name, field, range) in ranges {
            if (field.width(), field.height()) != (w, h) {
                let reason = format!("has {} x {} cells, depth has {w} x {h}", field.width(), field.height());
                return Err(bad(owner, name, reason));
            }
            if let Some(v) = field.iter().find(|v| !range.contains(v)) {
                return Err(bad(owner, name, format!("holds {v}, which is outside {range:?}")));
            }
        }
        Ok(())
    }
}
