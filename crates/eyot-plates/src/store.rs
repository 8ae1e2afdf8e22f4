//! The state of plates as layers and a component, so that a checkpoint holds all of it.

use crate::budget::Budget;
use crate::crust::{HIGHEST_M, units};
use crate::drift::Maps;
use crate::geometry::Geometry;
use crate::level::heights;
use crate::pairs::Pairs;
use crate::parameters::Tectonics;
use crate::plate::Plate;
use crate::plates::{Clock, Plates};
use crate::subduction::Volcanoes;
use eyot_core::component::{Decoder, Encoder, Numbers};
use eyot_core::{Component, ComponentKind, Error, Fingerprint, Grid, Result};
use std::sync::Arc;

/// Numbers before those of the plates, in version 1 and in fingerprints.
const HEAD: usize = 9;
/// Most plates of which a map of bytes can tell.
const MAX_PLATES: usize = 255;

/// What a world keeps of its plates beside the layers `plate`, `crust` and `crust_age`.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateState {
    plates: Vec<Plate>,
    /// What pairs of plates remember about each other.
    overlap: Pairs,
    brought: Pairs,
    over: Pairs,
    clock: Clock,
    /// Level of the sea at which the plates were made, m.
    pub sea_level_m: f64,
}

/// How they are read: version 1 is the list of numbers that worlds kept under `plates`.
pub static PLATE_STATE: ComponentKind = ComponentKind {
    name: "plates.state",
    version: 2,
    formerly: &["plates"],
    decode: |version, from| {
        let state = match version {
            1 => of_numbers(from)?,
            _ => PlateState::decode(from)?,
        };
        if state.numbers().iter().any(|v| !v.is_finite()) {
            return Err(from.wrong("numbers that are not finite"));
        }
        Ok(Arc::new(state))
    },
};

impl PlateState {
    /// All of it as numbers, in the order of version 1: how many plates, clock, plates, pairs, level of the sea.
    pub fn numbers(&self) -> Vec<f64> {
        let c = &self.clock;
        let head: [f64; HEAD] = [
            self.plates.len() as f64,
            c.steps as f64,
            c.cycle as f64,
            c.since_myr,
            c.level,
            c.rise,
            c.aim,
            f64::from(c.restarts),
            f64::from(u8::from(c.at_rest)),
        ];
        let plates = self.plates.iter().flat_map(Plate::numbers);
        let pairs = [&self.overlap, &self.brought, &self.over].into_iter().flat_map(|t| t.values().iter().copied());
        head.into_iter().chain(plates).chain(pairs).chain([self.sea_level_m]).collect()
    }

    fn decode(from: &mut Decoder<'_>) -> Result<Self> {
        let n = usize::from(from.u8()?);
        if n == 0 {
            return Err(from.wrong("a world without plates"));
        }
        let clock = Clock {
            steps: from.u64()?,
            cycle: from.u64()?,
            since_myr: from.f64()?,
            level: from.f64()?,
            rise: from.f64()?,
            aim: from.f64()?,
            restarts: from.u32()?,
            at_rest: from.u8()? != 0,
        };
        let plates = from.f64s(n * Plate::NUMBERS)?.chunks_exact(Plate::NUMBERS).map(Plate::from_numbers).collect();
        let mut pairs = || Ok::<_, Error>(Pairs::from_values(n, &from.f64s(n * n)?));
        let (overlap, brought, over) = (pairs()?, pairs()?, pairs()?);
        Ok(Self { plates, overlap, brought, over, clock, sea_level_m: from.f64()? })
    }
}

/// Version 1.
fn of_numbers(from: &mut Decoder<'_>) -> Result<PlateState> {
    let Numbers(numbers) = Numbers::decode(from)?;
    let n = numbers.first().map_or(0, |&n| n as usize);
    let expected = HEAD + n.min(MAX_PLATES) * Plate::NUMBERS + 3 * n.min(MAX_PLATES).pow(2) + 1;
    if !(1..=MAX_PLATES).contains(&n) || numbers.len() != expected {
        return Err(from.wrong(format!("{} numbers for {n} plates", numbers.len())));
    }
    let (plates, rest) = numbers[HEAD..].split_at(n * Plate::NUMBERS);
    let pairs = |i: usize| Pairs::from_values(n, &rest[i * n * n..(i + 1) * n * n]);
    Ok(PlateState {
        plates: plates.chunks_exact(Plate::NUMBERS).map(Plate::from_numbers).collect(),
        overlap: pairs(0),
        brought: pairs(1),
        over: pairs(2),
        clock: Clock {
            steps: numbers[1] as u64,
            cycle: numbers[2] as u64,
            since_myr: numbers[3],
            level: numbers[4],
            rise: numbers[5],
            aim: numbers[6],
            restarts: numbers[7] as u32,
            at_rest: numbers[8] != 0.0,
        },
        sea_level_m: numbers[expected - 1],
    })
}

impl Component for PlateState {
    fn kind(&self) -> &'static ComponentKind {
        &PLATE_STATE
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        let c = &self.clock;
        out.u8(self.plates.len() as u8);
        out.u64s(&[c.steps, c.cycle]);
        out.f64s(&[c.since_myr, c.level, c.rise, c.aim]);
        out.u32(c.restarts);
        out.u8(u8::from(c.at_rest));
        self.plates.iter().for_each(|p| out.f64s(&p.numbers()));
        [&self.overlap, &self.brought, &self.over].into_iter().for_each(|t| out.f64s(t.values()));
        out.f64(self.sea_level_m);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        self.numbers().into_iter().for_each(|n| print.number(n));
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.plates) + 3 * size_of_val(self.overlap.values())
    }
}

impl Plates {
    /// Everything that is not a map, in a world whose sea stands at `sea_level_m`.
    pub fn state(&self, sea_level_m: f64) -> PlateState {
        PlateState {
            plates: self.plates.clone(),
            overlap: self.overlap.clone(),
            brought: self.brought.clone(),
            over: self.over.clone(),
            clock: self.clock,
            sea_level_m,
        }
    }

    /// Puts a world together from its maps (owner, thickness in m, age in Myr; row by row from the north) and [`Plates::state`]. The
    /// budget starts anew; parameters are not checked again.
    ///
    /// # Errors
    /// If sizes do not fit.
    pub fn of_state(
        grid: &Grid,
        seed: u64,
        parameters: Tectonics,
        state: &PlateState,
        maps: (impl Iterator<Item = f32>, impl Iterator<Item = f32>, impl Iterator<Item = f32>),
    ) -> Result<Self> {
        let g = Geometry::new(grid);
        let n = state.plates.len();
        let maps = Maps {
            owner: maps.0.map(|o| (o as u8).min(n as u8 - 1)).collect(),
            crust: maps.1.map(|c| units(c.clamp(0.0, HIGHEST_M))).collect(),
            age: maps.2.map(|a| a.max(0.0)).collect(),
        };
        for (what, found) in [("owners", maps.owner.len()), ("crust", maps.crust.len()), ("ages", maps.age.len())] {
            if found != g.cells() {
                return Err(Error::Shape { what: format!("{what} of plates"), expected: g.cells(), found });
            }
        }
        let PlateState { plates, overlap, brought, over, clock, .. } = state.clone();
        let mut world = Self {
            g,
            seed,
            parameters,
            maps,
            height: vec![0.0; g.cells()],
            plates,
            overlap,
            brought,
            over,
            clock,
            budget: Budget::default(),
            volcanoes: Volcanoes::new(&g, seed),
            followed: false,
            course: None,
            spare: Maps::empty(g.cells()),
        };
        world.forget();
        Ok(world)
    }

    /// Forgets what [`Plates::of_state`] could not know: where crust came from, and heights finer than whole units of crust.
    pub(crate) fn forget(&mut self) {
        self.budget = Budget { start: self.crust_units(), ..Budget::default() };
        heights(self.g.width, &self.maps.crust, &mut self.maps.age, 0.0, self.clock.level, &mut self.height);
    }
}
