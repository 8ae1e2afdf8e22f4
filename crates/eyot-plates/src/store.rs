//! The state of plates as layers and numbers, so that a checkpoint holds all of it.

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
use eyot_core::{Error, Grid, Result};

/// Numbers before those of the plates.
const HEAD: usize = 9;

impl Plates {
    /// Everything that is not a map.
    pub fn numbers(&self) -> Vec<f64> {
        let c = &self.clock;
        let head = [
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
        head.into_iter().chain(plates).chain(pairs).collect()
    }

    /// Puts a world together from its maps (owner, thickness in m, age in Myr; row by row from the north) and [`Plates::numbers`]. The
    /// budget starts anew; parameters are not checked again.
    ///
    /// # Errors
    /// If sizes do not fit, or a number is not one that plates have.
    pub fn restore(
        grid: &Grid,
        seed: u64,
        parameters: Tectonics,
        numbers: &[f64],
        maps: (impl Iterator<Item = f32>, impl Iterator<Item = f32>, impl Iterator<Item = f32>),
    ) -> Result<Self> {
        let g = Geometry::new(grid);
        let n = numbers.first().map_or(0, |&n| n as usize);
        let expected = HEAD + n * Plate::NUMBERS + 3 * n * n;
        if !(1..256).contains(&n) || numbers.len() != expected || numbers.iter().any(|v| !v.is_finite()) {
            return Err(Error::Shape { what: "numbers of plates".into(), expected, found: numbers.len() });
        }
        let (plates, pairs) = numbers[HEAD..].split_at(n * Plate::NUMBERS);
        let pairs: Vec<Pairs> = pairs.chunks_exact(n * n).map(|v| Pairs::from_values(n, v)).collect();
        let [overlap, brought, over] = <[Pairs; 3]>::try_from(pairs).unwrap_or_default();
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
        let clock = Clock {
            steps: numbers[1] as u64,
            cycle: numbers[2] as u64,
            since_myr: numbers[3],
            level: numbers[4],
            rise: numbers[5],
            aim: numbers[6],
            restarts: numbers[7] as u32,
            at_rest: numbers[8] != 0.0,
        };
        let mut world = Self {
            g,
            seed,
            parameters,
            maps,
            height: vec![0.0; g.cells()],
            plates: plates.chunks_exact(Plate::NUMBERS).map(Plate::from_numbers).collect(),
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

    /// Forgets what [`Plates::restore`] could not know: where crust came from, and heights finer than whole units of crust.
    pub(crate) fn forget(&mut self) {
        self.budget = Budget { start: self.crust_units(), ..Budget::default() };
        heights(self.g.width, &self.maps.crust, &mut self.maps.age, 0.0, self.clock.level, &mut self.height);
    }
}
