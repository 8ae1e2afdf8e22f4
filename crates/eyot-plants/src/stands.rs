//! Stands: which of the cohorts of the process `plants` a single tree belongs to, and how large and how old it is.

use crate::trees::Kind;
use crate::types::{BIOMASS, Form, PlantType, STEM, TYPES, WOODY};
use eyot_core::{Field, World};

/// The cohorts of a world.
pub(crate) struct Stands<'a> {
    cohorts: Vec<Cohort<'a>>,
    cell_m: [f32; 2],
}

struct Cohort<'a> {
    number: usize,
    biomass: &'a Field,
    stem: &'a Field,
}

/// What stands in one place.
pub(crate) struct Standing {
    /// Its number in [`TYPES`].
    pub number: usize,
    pub kind: Kind,
    /// Height, m.
    pub height: f32,
    /// Age, years.
    pub age: f32,
}

impl<'a> Stands<'a> {
    /// The cohorts of a world that has some.
    pub(crate) fn of(world: &'a World) -> Option<Self> {
        let cohort = |number: usize| {
            Some(Cohort { number, biomass: world.get(BIOMASS[number])?, stem: world.get(STEM[number])? })
        };
        let cohorts: Vec<Cohort<'a>> = (0..WOODY).filter_map(cohort).collect();
        let cell_m = [world.grid.cell_x_m as f32, world.grid.cell_y_m as f32];
        (!cohorts.is_empty()).then_some(Self { cohorts, cell_m })
    }

    /// What stands at a place (m from the north-western corner), chosen by a number from 0 to 1 among the types there by the area of their
    /// leaves, and by another one smaller or larger than the mean of its cohort.
    pub(crate) fn at(&self, place: [f32; 2], choice: f32, vigour: f32) -> Option<Standing> {
        let cell = |i: usize, n: usize| ((place[i] / self.cell_m[i]) as usize).min(n - 1);
        let size = |f: &Field| (f.width(), f.height());
        let (w, h) = size(self.cohorts[0].biomass);
        let (x, y) = (cell(0, w), cell(1, h));
        let leaves = |c: &Cohort<'_>| {
            let (t, stem) = (&TYPES[c.number], c.stem.get(x, y));
            let biomass = c.biomass.get(x, y);
            if biomass > 0.0 { biomass / t.mass_of(stem) * stem.powf(1.75) } else { 0.0 }
        };
        let all: Vec<f32> = self.cohorts.iter().map(leaves).collect();
        let mut left = choice * all.iter().sum::<f32>();
        let place = all.iter().position(|share| {
            left -= share;
            left < 0.0
        })?;
        let c = &self.cohorts[place];
        let t = &TYPES[c.number];
        let stem = (c.stem.get(x, y) * (0.7 + 0.6 * vigour)).min(t.stem);
        let kind = match t.form {
            Form::Conifer => Kind::Conifer,
            Form::Shrub => Kind::Shrub,
            Form::Broadleaf | Form::Grass => Kind::Broadleaf,
        };
        Some(Standing { number: c.number, kind, height: t.height_of(stem), age: years(t, stem) })
    }
}

/// Years in which a stem of a type grows so thick in half of the light: JABOWA, by steps of its diameter.
fn years(t: &PlantType, stem_m: f32) -> f32 {
    const STEPS: usize = 24;
    let (foot, rise) = (t.foot(), t.height - t.foot());
    let (b2, b3) = (2.0 * rise / t.stem, rise / (t.stem * t.stem));
    let step = (stem_m / STEPS as f32).max(1e-5);
    let year = |i: usize| {
        let d = (i as f32 + 0.5) * step;
        let left = (1.0 - d * t.height_of(d) / (t.stem * t.height)).max(0.02);
        let rate = 0.5 * 0.01 * t.growth * d * left / (2.0 * foot + d * (3.0 * b2 - 4.0 * b3 * d));
        step / rate.max(1e-6)
    };
    (0..STEPS).map(year).sum::<f32>().min(t.age)
}
