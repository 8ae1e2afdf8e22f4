//! What beds are made of and how they lie, as recipes say it, and as the rules need it.

use super::{MOST_BENDS, Strata, Surfaces};
use crate::materials::hexadecimal;
use crate::sequence::{Layered, SLOTS, Sequence};
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Beds above the one without a bottom.
pub const MOST_BEDS: usize = 12;
/// Beds whose bottoms can be layers of their own.
pub(crate) const SURFACES: usize = 4;

/// A bed of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bed {
    /// Name of its material.
    pub material: String,
    /// Thickness, measured along the vertical. That of the last bed has no meaning unless the sequence repeats.
    #[schemars(range(min = 0.01, max = 20000.0), extend("unit" = "m"))]
    pub thickness: f32,
}

/// A wave of the beds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fold {
    /// From crest to crest.
    #[schemars(range(min = 1.0, max = 1000000.0), extend("unit" = "m"))]
    pub wavelength: f32,
    /// Half the way from crest to trough.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "m"))]
    pub amplitude: f32,
    /// Direction across the crests, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub direction: f32,
    /// Way from the middle of the grid to a crest.
    #[schemars(range(min = -1000000.0, max = 1000000.0), extend("unit" = "m"))]
    pub crest: f32,
}

impl Default for Fold {
    fn default() -> Self {
        Self { wavelength: 4000.0, amplitude: 150.0, direction: 0.0, crest: 0.0 }
    }
}

/// An upright plane along which the beds are displaced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fault {
    /// Direction in which it runs, clockwise from north.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "degree"))]
    pub strike: f32,
    /// How far it passes the middle of the grid, to the right of its direction.
    #[schemars(range(min = -1000000.0, max = 1000000.0), extend("unit" = "m"))]
    pub distance: f32,
    /// How much higher the beds lie to the right of it.
    #[schemars(range(min = -10000.0, max = 10000.0), extend("unit" = "m"))]
    pub throw: f32,
}

impl Default for Fault {
    fn default() -> Self {
        Self { strike: 0.0, distance: 0.0, throw: 100.0 }
    }
}

pub(super) fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "strata".into(), field: field.into(), reason }
}

/// `1 bed`, `2 beds`.
fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

pub(super) fn tangent(degrees: f32) -> f64 {
    sin_degrees(f64::from(degrees)) / cos_degrees(f64::from(degrees))
}

impl Strata {
    pub(super) fn number(&self, field: &str, name: &str) -> Result<usize> {
        self.materials.iter().position(|m| m.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.materials.iter().map(|m| m.name.as_str()).collect();
            bad(field, format!("there is no material `{name}`; there are {}", names.join(", ")))
        })
    }

    /// What a world keeps of its beds.
    ///
    /// # Errors
    /// If there is no material of a name.
    pub fn sequence(&self) -> Result<Sequence> {
        let number = |field: &str, name: &String| self.number(field, name).map(|n| n as u8);
        let bed = |(n, bed): (usize, &Bed)| {
            let material = number(&format!("beds.{}.material", n + 1), &bed.material)?;
            Ok(Layered { material, thickness_m: bed.thickness })
        };
        let stages = self.stages.iter().filter(|_| self.new_rock).map(|name| number("stages", name));
        Ok(Sequence {
            materials: self.materials.clone(),
            loose: number("loose", &self.loose)?,
            beds: self.beds.iter().enumerate().map(bed).collect::<Result<_>>()?,
            repeat: self.repeat,
            surfaces: self.surfaces,
            top_m: self.top,
            stages: stages.collect::<Result<_>>()?,
        })
    }

    /// Thickness of the whole sequence, m.
    pub(super) fn sequence_m(&self) -> f32 {
        self.beds.iter().map(|b| b.thickness).sum()
    }

    /// Finds numbers and counts that cannot be; names are looked up by [`Strata::profile`].
    pub(super) fn fits(&self) -> Result<()> {
        let fit = |what: &str, value: f32, low: f32, high: f32| {
            let fits = (low..=high).contains(&value);
            if fits { Ok(()) } else { Err(bad(what, format!("{value} is outside {low}..={high}"))) }
        };
        if self.materials.len() > 255 {
            return Err(bad("materials", format!("{}; there can be 255", count(self.materials.len(), "material"))));
        }
        for m in &self.materials {
            fit(&format!("materials.{}.talus", m.name), m.talus, 1.0, 89.0)?;
            fit(&format!("materials.{}.erodibility", m.name), m.erodibility, 0.0, 1000.0)?;
            fit(&format!("materials.{}.density", m.name), m.density, 100.0, 10000.0)?;
            if m.name.is_empty() {
                return Err(bad("materials", "a material has no name".into()));
            }
            if let Some(colour) = m.colour.as_deref().filter(|c| hexadecimal(c).is_none()) {
                let reason =
                    format!("`{colour}` is no colour; write # and six digits from 0 to f, such as \"#5a6b3c\"");
                return Err(bad(&format!("materials.{}.colour", m.name), reason));
            }
            if self.materials.iter().filter(|o| o.name == m.name).count() > 1 {
                return Err(bad("materials", format!("there are two of the name `{}`", m.name)));
            }
        }
        for (what, count) in [("folds", self.folds.len()), ("faults", self.faults.len())] {
            if count > MOST_BENDS {
                return Err(bad(what, format!("{count} {what}; there can be {MOST_BENDS}")));
            }
        }
        for f in &self.folds {
            fit("folds.wavelength", f.wavelength, 1.0, 1e6)?;
            fit("folds.amplitude", f.amplitude, 0.0, 1e4)?;
            fit("folds.direction", f.direction, -360.0, 360.0)?;
            fit("folds.crest", f.crest, -1e6, 1e6)?;
        }
        for f in &self.faults {
            fit("faults.strike", f.strike, -360.0, 360.0)?;
            fit("faults.distance", f.distance, -1e6, 1e6)?;
            fit("faults.throw", f.throw, -1e4, 1e4)?;
        }
        if self.repeat && self.surfaces != Surfaces::Flat {
            let reason = "beds whose bottoms are layers cannot repeat; take one of the two";
            return Err(bad("surfaces", reason.into()));
        }
        self.stages_fit()?;
        let thickness =
            |(n, bed): (usize, &Bed)| fit(&format!("beds.{}.thickness", n + 1), bed.thickness, 0.01, 20000.0);
        self.beds.iter().enumerate().try_for_each(thickness)
    }

    /// Finds stages of new rock that cannot be, whether there is new rock or not: who switches it on later is not to be surprised.
    fn stages_fit(&self) -> Result<()> {
        if self.stages.len() != SLOTS {
            return Err(bad(
                "stages",
                format!("{}; new rock has {SLOTS} stages", count(self.stages.len(), "material")),
            ));
        }
        for (n, name) in self.stages.iter().enumerate() {
            let field = format!("stages.{}", n + 1);
            self.number(&field, name)?;
            if self.stages[..n].contains(name) {
                return Err(bad(&field, format!("`{name}` is a stage already: each hardens to another material")));
            }
        }
        Ok(())
    }

    /// Bottoms of the beds below the datum, m, with their materials: of a sequence that has been checked, since every step asks for it.
    ///
    /// # Errors
    /// If there are too few or too many beds, or no material of a name.
    pub(super) fn profile(&self) -> Result<Profile<f32>> {
        if self.beds.is_empty() || self.beds.len() > MOST_BEDS + 1 {
            return Err(bad("beds", format!("{}; there can be 1 to {}", count(self.beds.len(), "bed"), MOST_BEDS + 1)));
        }
        let layer = |bottom: f32, n: usize| {
            let m = &self.materials[n];
            // Rock that does not wear at all takes longer than any step.
            let wear = (1.0 / m.erodibility).min(1e12);
            [bottom, n as f32, m.erodibility, tangent(m.talus) as f32, wear]
        };
        let loose = layer(0.0, self.number("loose", &self.loose)?);
        let mut all = Vec::with_capacity(self.beds.len());
        let mut bottom = 0.0;
        for (n, bed) in self.beds.iter().enumerate() {
            bottom += bed.thickness;
            all.push(layer(bottom, self.number(&format!("beds.{}.material", n + 1), &bed.material)?));
        }
        let last = all.pop().unwrap_or(loose);
        // Beds that are missing are the last one, and end above everything.
        let [_, material, erodibility, slope, wear] = last;
        let mut beds = [[-1e30, material, erodibility, slope, wear]; MOST_BEDS];
        beds[..all.len()].copy_from_slice(&all);
        // The last bed ends below everything, and its wear has an account as that of the others has.
        if let Some(bed) = beds.get_mut(all.len()) {
            bed[0] = 1e20;
        }
        let mut slots = [[0.0; 4]; SLOTS];
        if self.new_rock {
            for (slot, name) in slots.iter_mut().zip(&self.stages) {
                let [_, material, erodibility, slope, wear] = layer(0.0, self.number("stages", name)?);
                *slot = [material, erodibility, slope, wear];
            }
        }
        Ok(Profile { beds, last, loose, slots })
    }
}

/// Bottom below the datum (m), number, erodibility, tangent of the steepest slope and 1 / erodibility, at most 1e12, of each bed.
#[derive(Clone, Copy)]
pub(super) struct Profile<T> {
    pub(super) beds: [[T; 5]; MOST_BEDS],
    pub(super) last: [T; 5],
    pub(super) loose: [T; 5],
    /// Those of new rock, without a bottom.
    pub(super) slots: [[T; 4]; SLOTS],
}
