//! What the beds of a world are made of: kept in the world, so that it can be cut open without its recipe.
//!
//! Layers say where the beds lie (`bed_datum`) and how deep they are worn (`bedrock`); which beds there are, is the same for all
//! cells. [`Strata`](crate::Strata) puts it into the component [`STRATA`] before its first step, and again whenever its parameters
//! have changed. So a checkpoint, a frame of a recording and a world from any program know their beds, too.

use crate::materials::{Material, hexadecimal};
use eyot_core::component::{Decoder, Encoder};
use eyot_core::{Component, ComponentKind, Fingerprint, Result, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Slots of new rock: the layers `new_rock_1` to `new_rock_6`.
pub const SLOTS: usize = 6;

/// What the layers `bed_1` to `bed_4` say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Surfaces {
    /// Nothing: beds are as thick everywhere.
    #[default]
    Flat,
    /// How much lower the bottom of the bed lies here than its thickness says, m: what a generator with amplitude makes.
    Lower,
    /// The height of the bottom of the bed, m, before dip, folds and faults: what is imported.
    Height,
}

/// Name of the component.
pub const STRATA: &str = "strata";
/// Longest name of a material in a file, bytes.
const LONGEST: usize = 256;
/// Length of a colour in a file, bytes.
const COLOUR: usize = 7;
/// Most beds in a file.
const MOST: usize = 255;

/// A bed of a [`Sequence`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    /// Its place in [`Sequence::materials`].
    pub material: u8,
    /// Thickness along the vertical, m.
    pub thickness_m: f32,
}

/// Materials and the sequence of beds, from the top down.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Materials, in the order of their numbers in the layer `material`.
    pub materials: Vec<Material>,
    /// The material of loose ground: its place in the list.
    pub loose: u8,
    /// The beds; the last one goes on for ever unless the sequence repeats.
    pub beds: Vec<Layered>,
    /// Whether the sequence begins again below its last bed and above its first.
    pub repeat: bool,
    /// What the layers `bed_1` to `bed_4` say of the bottoms of the first beds.
    pub surfaces: Surfaces,
    /// Height from which those that are heights are counted, m.
    pub top_m: f32,
    /// The materials of the layers `new_rock_1` to `new_rock_6`: none, or six.
    pub stages: Vec<u8>,
}

/// How it is read.
pub static SEQUENCE: ComponentKind = ComponentKind {
    name: "strata.sequence",
    version: 2,
    formerly: &[],
    decode: |version, from| Ok(Arc::new(Sequence::decode(version, from)?)),
};

impl Sequence {
    /// That of a world; `None` if it has no strata.
    ///
    /// # Errors
    /// If what lies under the name is of another kind.
    pub fn of(world: &World) -> Result<Option<&Self>> {
        world.components.get(STRATA)
    }

    /// Thickness of the whole sequence, m.
    pub fn thickness_m(&self) -> f64 {
        self.beds.iter().map(|b| f64::from(b.thickness_m)).sum()
    }

    /// Adds the thickness of each material between two depths below the datum to `sums`, m, for a sequence that repeats.
    pub(crate) fn add_between(&self, from: f64, to: f64, sums: &mut [f64]) {
        let whole = self.thickness_m();
        let mut top = 0.0;
        for bed in &self.beds {
            let thickness = f64::from(bed.thickness_m);
            // How much of this bed lies above a depth, counted from the first turn.
            let above = |depth: f64| {
                let turns = (depth / whole).floor();
                turns * thickness + (depth - turns * whole - top).clamp(0.0, thickness)
            };
            sums[usize::from(bed.material)] += above(to) - above(from);
            top += thickness;
        }
    }

    fn decode(version: u32, from: &mut Decoder<'_>) -> Result<Self> {
        let mut materials = Vec::new();
        for _ in 0..from.u8()? {
            let name = from.text(LONGEST)?;
            let (talus, erodibility, density) = (from.f32()?, from.f32()?, from.f32()?);
            // Files of version 1 know no colours.
            let colour = if version < 2 { String::new() } else { from.text(COLOUR)? };
            if !colour.is_empty() && hexadecimal(&colour).is_none() {
                return Err(from.wrong(format!("a colour of `{name}` that is none")));
            }
            let colour = Some(colour).filter(|c| !c.is_empty());
            let material = Material { name, talus, erodibility, density, colour };
            if ![material.talus, material.erodibility, material.density].iter().all(|v| v.is_finite() && *v >= 0.0) {
                return Err(from.wrong(format!("numbers of `{}` that cannot be", material.name)));
            }
            materials.push(material);
        }
        let (loose, repeat, count) = (from.u8()?, from.u8()?, usize::from(from.u8()?));
        let mut beds = Vec::new();
        for _ in 0..count {
            beds.push(Layered { material: from.u8()?, thickness_m: from.f32()? });
        }
        let surfaces = match from.u8()? {
            0 => Surfaces::Flat,
            1 => Surfaces::Lower,
            2 => Surfaces::Height,
            other => return Err(from.wrong(format!("surfaces of a kind {other}"))),
        };
        let (top_m, stages) = (from.f32()?, usize::from(from.u8()?));
        let stages = from.u8s(stages)?;
        let known = |n: u8| usize::from(n) < materials.len();
        let sound = |b: &Layered| known(b.material) && b.thickness_m.is_finite() && b.thickness_m > 0.0;
        let fits = [0, SLOTS].contains(&stages.len()) && stages.iter().all(|n| known(*n)) && top_m.is_finite();
        if beds.is_empty() || repeat > 1 || !known(loose) || !beds.iter().all(sound) || !fits {
            return Err(from.wrong("beds that cannot be"));
        }
        Ok(Self { materials, loose, beds, repeat: repeat == 1, surfaces, top_m, stages })
    }
}

impl Component for Sequence {
    fn kind(&self) -> &'static ComponentKind {
        &SEQUENCE
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        // `Strata` has at most 255 materials and 13 beds.
        out.u8(self.materials.len().min(MOST) as u8);
        for m in self.materials.iter().take(MOST) {
            out.text(&m.name);
            [m.talus, m.erodibility, m.density].into_iter().for_each(|v| out.f32(v));
            out.text(m.colour.as_deref().unwrap_or_default());
        }
        out.u8(self.loose);
        out.u8(u8::from(self.repeat));
        out.u8(self.beds.len().min(MOST) as u8);
        for b in self.beds.iter().take(MOST) {
            out.u8(b.material);
            out.f32(b.thickness_m);
        }
        out.u8(self.surfaces as u8);
        out.f32(self.top_m);
        out.u8(self.stages.len().min(MOST) as u8);
        out.bytes(&self.stages);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        for m in &self.materials {
            m.name.bytes().for_each(|b| print.word(u64::from(b)));
            print.values(&[m.talus, m.erodibility, m.density]);
            m.colour.iter().flat_map(|c| c.bytes()).for_each(|b| print.word(u64::from(b)));
        }
        print.word(u64::from(self.loose));
        print.word(u64::from(self.repeat));
        for b in &self.beds {
            print.word(u64::from(b.material));
            print.values(&[b.thickness_m]);
        }
        print.word(self.surfaces as u64);
        print.values(&[self.top_m]);
        self.stages.iter().for_each(|n| print.word(u64::from(*n)));
    }

    fn bytes(&self) -> usize {
        let names: usize = self.materials.iter().map(|m| m.name.len()).sum();
        names + size_of_val(&*self.materials) + size_of_val(&*self.beds) + self.stages.len()
    }
}
