//! A plot as a list of numbers, and back: what checkpoints keep of it.

use super::colony::{Alga, Colony};
use super::forcing::Forcing;
use super::geometry::{RAYS, mean};
use super::parameters::{Community, bad};
use super::plot::Plot;
use super::site::Site;
use eyot_core::{Limits, Result};

/// Version of the order of numbers, and how many stand before the individuals.
const VERSION: f64 = 1.0;
const HEAD: usize = 10;
const COLONY: usize = 10 + RAYS;
const ALGA: usize = 6;
/// Whole numbers beyond this are not exact.
const MOST: f64 = 9_007_199_254_740_992.0;

impl Plot {
    /// Everything that the plot itself does not know from its parameters: date, individuals, turf.
    ///
    /// Version, month, next id, colonies, algae, cells of turf, next date and interval of small and of large disturbances; then each
    /// colony (id, species, age, x, y, radius, bleaching, light, vigour, limestone, 24 rays), each alga (id, age, x, y, radius,
    /// height), each cell of turf.
    pub fn numbers(&self) -> Vec<f64> {
        let (colonies, algae, turf) = (self.colonies.len(), self.algae.len(), self.turf.cover());
        let mut out = Vec::with_capacity(HEAD + colonies * COLONY + algae * ALGA + turf.len());
        out.extend([VERSION, self.month as f64, self.next_id as f64]);
        out.extend([colonies as f64, algae as f64, turf.len() as f64]);
        out.extend(self.calendars.iter().flat_map(|c| [c.next, c.shrunk]));
        for (c, rays) in self.colonies.iter().zip(&self.rays) {
            out.extend([c.id as f64, f64::from(c.species), f64::from(c.age)]);
            out.extend([c.x, c.y, c.radius, c.bleaching, c.light, c.vigour, c.calcified_kg].map(f64::from));
            out.extend(rays.map(f64::from));
        }
        for a in &self.algae {
            out.extend([a.id as f64, f64::from(a.age)]);
            out.extend([a.x, a.y, a.radius, a.height].map(f64::from));
        }
        out.extend(turf.iter().map(|&c| f64::from(c)));
        out
    }

    /// The plot whose [`Plot::numbers`] these are: it goes on from the same month to the same bits.
    ///
    /// # Errors
    /// As [`Plot::new`], or if the numbers are not those of such a plot.
    pub fn restore(
        community: Community,
        site: Site,
        forcing: Forcing,
        seed: u64,
        limits: Limits,
        numbers: &[f64],
    ) -> Result<Self> {
        let mut plot = Self::empty(community, site, forcing, seed, limits)?;
        let wrong = |what: &str| bad("community", "saved state", format!("{what}; it does not belong to this reef"));
        let Some((head, rest)) = numbers.split_at_checked(HEAD) else { return Err(wrong("too few numbers")) };
        if numbers.iter().any(|n| !n.is_finite()) || head[0] != VERSION {
            return Err(wrong("numbers of another kind"));
        }
        if head[1..6].iter().any(|n| !(0.0..MOST).contains(n) || n.fract() != 0.0) {
            return Err(wrong("counts that are none"));
        }
        let [colonies, algae, turf] = [head[3], head[4], head[5]].map(|n| n as usize);
        let expected = colonies as u128 * COLONY as u128 + algae as u128 * ALGA as u128 + turf as u128;
        if expected != rest.len() as u128 || turf != plot.turf.cover().len() {
            return Err(wrong(&format!("{} numbers", numbers.len())));
        }
        (plot.month, plot.next_id) = (head[1] as u64, head[2] as u64);
        for (calendar, pair) in plot.calendars.iter_mut().zip(head[6..].chunks_exact(2)) {
            (calendar.next, calendar.shrunk) = (pair[0], pair[1]);
        }
        let (colonies, rest) = rest.split_at(colonies * COLONY);
        let (algae, turf) = rest.split_at(algae * ALGA);
        for n in colonies.chunks_exact(COLONY) {
            let [x, y, radius, bleaching, light, vigour, calcified_kg] = std::array::from_fn(|i| n[3 + i] as f32);
            let rays: [f32; RAYS] = std::array::from_fn(|i| n[10 + i] as f32);
            let c = Colony {
                id: n[0] as u64,
                species: n[1] as u8,
                age: n[2] as u32,
                x,
                y,
                radius,
                bleaching,
                light,
                vigour,
                calcified_kg,
            };
            let species = plot.community.species.get(usize::from(c.species));
            let longest = species.map_or(0.0, |s| 1.001 * s.max_radius);
            let sound =
                rays.iter().all(|r| (0.0..=longest).contains(r)) && (mean(&rays) - radius).abs() <= 1e-3 * longest;
            if !sound || !(0.0..=1.0).contains(&bleaching) || !plot.keeps(x, y) {
                return Err(wrong(&format!("colony {}", c.id)));
            }
            plot.colonies.push(c);
            plot.rays.push(rays);
        }
        for n in algae.chunks_exact(ALGA) {
            let [x, y, radius, height] = std::array::from_fn(|i| n[2 + i] as f32);
            if !(0.0..=plot.community.algae.max_radius).contains(&radius) || !plot.keeps(x, y) {
                return Err(wrong(&format!("alga {}", n[0])));
            }
            plot.algae.push(Alga { id: n[0] as u64, age: n[1] as u32, x, y, radius, height });
        }
        if turf.iter().any(|c| !(0.0..=1.0).contains(c)) {
            return Err(wrong("turf"));
        }
        plot.turf.cover_mut().iter_mut().zip(turf).for_each(|(to, &from)| *to = from as f32);
        Ok(plot)
    }
}
