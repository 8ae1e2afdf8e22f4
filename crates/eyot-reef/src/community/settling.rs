//! Where colonies and algae come from: the first ones, larvae, fragments.

use super::colony::{Alga, Colony};
use super::geometry::RAYS;
use super::parameters::{Community, bad};
use super::plot::Plot;
use super::random::{Draws, Stream};
use super::site::{Place, Site};
use super::species::Species;
use eyot_core::math64::exp;
use eyot_core::{Control, Result};
use std::f32::consts::PI;

/// Age of the first colonies, months.
const INITIAL_AGE: u32 = 10;
/// Age of fragments: they are no settlers that turf could smother.
const FRAGMENT_AGE: u32 = 2;
/// The original program's offsets reach one unit of 10 cm too far to one side.
pub(super) const COMPAT_BIAS_M: f32 = 0.1;

/// Places on the habitable cells of a site.
struct Habitat<'a> {
    site: &'a Site,
    /// Habitable area of the cells so far, row by row, in cells; empty where everything is habitable.
    sums: Vec<f64>,
}

impl<'a> Habitat<'a> {
    fn new(site: &'a Site, chance: impl Fn(&Place) -> f32) -> Self {
        let mut sums = Vec::new();
        if let Some(g) = &site.ground {
            let mut sum = 0.0;
            for j in 0..g.depth.height() {
                for i in 0..g.depth.width() {
                    let [x, y] = [i, j].map(|n| ((n as f64 + 0.5) * g.cell_m) as f32);
                    sum += if site.contains(x, y) { f64::from(chance(&site.at(x, y))) } else { 0.0 };
                    sums.push(sum);
                }
            }
        }
        Self { site, sums }
    }

    /// Its area, m2.
    fn area_m2(&self) -> f64 {
        match &self.site.ground {
            Some(g) => self.sums.last().map_or(0.0, |cells| cells * g.cell_m * g.cell_m),
            None => self.site.area_m2(),
        }
    }

    fn place(&self, draws: Draws, who: u64) -> [f32; 2] {
        let Some(g) = self.site.ground.as_ref().filter(|_| !self.sums.is_empty()) else {
            return draws.place(who, self.site.width_m, self.site.length_m);
        };
        // 24 bits are too few to choose among the cells of a large raster.
        let u = f64::from(draws.bits(3 * who)) / 4_294_967_296.0 * self.sums[self.sums.len() - 1];
        let n = self.sums.partition_point(|&s| s <= u).min(self.sums.len() - 1);
        let at =
            |n: usize, k: u64, side: f64| ((n as f64 + f64::from(draws.unit(3 * who + k))) * g.cell_m).min(side) as f32;
        let columns = g.depth.width();
        [at(n % columns, 1, self.site.width_m), at(n / columns, 2, self.site.length_m)]
    }
}

/// tanh(light / saturation), relative to full light.
fn light_factor(light: f32, species: &Species) -> f32 {
    let tanh = |x: f64| {
        let e = exp(-2.0 * x);
        (1.0 - e) / (1.0 + e)
    };
    let s = f64::from(species.saturation_light);
    (tanh(f64::from(light) / s) / tanh(1.0 / s)) as f32
}

impl Plot {
    /// Fails if so many more individuals do not fit into the limits.
    pub(super) fn check_room(&self, what: &str, more: f64) -> Result<()> {
        let each = size_of::<Colony>() + size_of::<Alga>() + 2 * 4 * RAYS + 64;
        let all = more + (self.colonies.len() + self.algae.len()) as f64;
        if all > f64::from(u32::MAX / 2) {
            return Err(bad("community", what, format!("makes {all:.3e} individuals; 2e9 are possible on one plot")));
        }
        self.limits.check_bytes(&format!("a reef with {all:.0} individuals ({what})"), (all * each as f64) as u128)
    }

    /// Adds a colony, whatever is there; its rays are equal. Returns its id.
    ///
    /// # Errors
    /// If there is no such species, or radius or place are not finite numbers within the species' and the site's bounds.
    pub fn add_colony(&mut self, species: usize, x: f32, y: f32, radius: f32, age: u32) -> Result<u64> {
        let Some(s) = self.community.species.get(species) else {
            let reason = format!("there is no species {species}; there are {}", self.community.species.len());
            return Err(bad("colony", "species", reason));
        };
        if !(radius > 0.0 && radius <= s.max_radius) {
            return Err(bad("colony", "radius", format!("{radius} m is not within 0..={} m", s.max_radius)));
        }
        if !self.site.contains(x, y) {
            return Err(bad("colony", "x, y", format!("({x}, {y}) is not on the plot")));
        }
        self.push_colony(species, x, y, radius, age);
        Ok(self.next_id - 1)
    }

    /// Adds a macroalga, as high as it is wide, whatever is there. Returns its id.
    ///
    /// # Errors
    /// If radius or place are not finite numbers within the parameters' and the site's bounds.
    pub fn add_alga(&mut self, x: f32, y: f32, radius: f32) -> Result<u64> {
        let most = self.community.algae.max_radius;
        if !(radius > 0.0 && radius <= most) {
            return Err(bad("alga", "radius", format!("{radius} m is not within 0..={most} m")));
        }
        if !self.site.contains(x, y) {
            return Err(bad("alga", "x, y", format!("({x}, {y}) is not on the plot")));
        }
        self.push_alga(x, y, radius, radius, 0);
        Ok(self.next_id - 1)
    }

    fn push_colony(&mut self, species: usize, x: f32, y: f32, radius: f32, age: u32) {
        let s = &self.community.species[species];
        let light = light_factor(self.site.at(x, y).light, s);
        let id = self.next_id;
        self.next_id += 1;
        let species = species as u8;
        self.colonies.push(Colony {
            id,
            species,
            age,
            x,
            y,
            radius,
            bleaching: 0.0,
            light,
            vigour: 1.0,
            calcified_kg: 0.0,
        });
        self.rays.push([radius; RAYS]);
    }

    fn push_alga(&mut self, x: f32, y: f32, radius: f32, height: f32, age: u32) {
        let id = self.next_id;
        self.next_id += 1;
        self.algae.push(Alga { id, age, x, y, radius, height });
    }

    /// Places the first corals and algae at random until they cover their share of the habitable ground.
    pub(super) fn populate(&mut self, control: &Control<'_>) -> Result<()> {
        let draws = |kind: u64| Draws::new(self.seed, Stream::Placing, kind);
        let mut corals = Vec::new();
        for (n, s) in self.community.species.iter().enumerate() {
            let habitat = Habitat::new(&self.site, |p| p.suits(s));
            let target = habitat.area_m2() * f64::from(s.initial_cover);
            self.check_room("initial_cover", target / mean_area(s.max_initial_radius))?;
            let (places, sizes) = (draws(2 * n as u64), draws(2 * n as u64 + 1));
            let (mut area, mut who) = (0.0, 0);
            while area < target {
                control.check()?;
                let radius = (sizes.unit(who) * s.max_initial_radius).max(s.recruit_radius);
                let [x, y] = habitat.place(places, who);
                corals.push((n, x, y, radius));
                area += f64::from(PI * radius * radius);
                who += 1;
            }
        }
        for (n, x, y, radius) in corals {
            control.check()?;
            self.push_colony(n, x, y, radius, INITIAL_AGE);
        }
        self.populate_algae(control)
    }

    fn populate_algae(&mut self, control: &Control<'_>) -> Result<()> {
        let rules = self.community.algae.clone();
        let habitat = Habitat::new(&self.site, |p| suits_algae(p, &self.community));
        let target = habitat.area_m2() * f64::from(rules.initial_cover);
        self.check_room("algae.initial_cover", target / mean_area(rules.max_radius))?;
        let draws = |kind: u64| Draws::new(self.seed, Stream::Placing, 1000 + kind);
        let (places, sizes) = (draws(0), draws(1));
        let mut algae = Vec::new();
        let (mut area, mut who) = (0.0, 0);
        while area < target {
            control.check()?;
            let radius = (sizes.unit(3 * who) * rules.max_radius).max(rules.recruit_radius);
            let height = sizes.unit(3 * who + 1) * rules.max_height;
            let age = (sizes.unit(3 * who + 2) * rules.max_age as f32) as u32;
            let [x, y] = habitat.place(places, who);
            algae.push((x, y, radius, height, age));
            area += f64::from(PI * radius * radius);
            who += 1;
        }
        for (x, y, radius, height, age) in algae {
            self.push_alga(x, y, radius, height, age);
        }
        Ok(())
    }

    /// Larvae and algal recruits of this month settle.
    pub(super) fn recruit(&mut self, control: &Control<'_>) -> Result<()> {
        for n in 0..self.community.species.len() {
            let s = &self.community.species[n];
            if !is_due(self.month, s.first_recruitment, s.recruitment_interval) {
                continue;
            }
            let count = self.larvae(n);
            self.check_room("recruitment", count)?;
            let (places, holds) = self.settling(Stream::Settling, n as u64);
            for who in 0..count as u64 {
                control.check()?;
                let [x, y] = places.place(who, self.site.width_m, self.site.length_m);
                let s = &self.community.species[n];
                if holds.chance(who, self.hold(x, y, |p| p.suits(s))) {
                    self.push_colony(n, x, y, s.recruit_radius, 0);
                    self.births[n].0 += 1;
                }
            }
        }
        let rules = &self.community.algae;
        if is_due(self.month, rules.first_recruitment, rules.recruitment_interval) {
            let (count, radius) = (f64::from(rules.recruits) * self.site.area_m2(), rules.recruit_radius);
            self.check_room("algae.recruits", count)?;
            let (places, holds) = self.settling(Stream::AlgaSettling, 0);
            for who in 0..count as u64 {
                control.check()?;
                let [x, y] = places.place(who, self.site.width_m, self.site.length_m);
                if holds.chance(who, self.hold(x, y, |p| suits_algae(p, &self.community))) {
                    self.push_alga(x, y, radius, radius, 0);
                }
            }
        }
        Ok(())
    }

    /// Numbers for places and for finding hold.
    fn settling(&self, stream: Stream, kind: u64) -> (Draws, Draws) {
        let draws = |k: u64| Draws::new(self.seed, stream, self.month * 1024 + 2 * kind + k);
        (draws(0), draws(1))
    }

    /// Larvae of a species that come to settle, its own and those from elsewhere.
    pub fn larvae(&self, species: usize) -> f64 {
        let s = &self.community.species[species];
        let mature = |c: &&Colony| usize::from(c.species) == species && 2.0 * c.radius >= s.mature_diameter;
        let radii2: f64 = self.colonies.iter().filter(mature).map(|c| f64::from(c.radius).powi(2)).sum();
        let surface_cm2 = 2.0 * std::f64::consts::PI * radii2 * 1e4 * f64::from(s.surface_factor);
        let own = (surface_cm2 * f64::from(s.propagules) * f64::from(s.retention)).floor();
        let open = if self.community.compat { 0.0 } else { s.imported_recruits };
        let fixed = f64::from(open) * self.site.area_m2();
        own + (own * f64::from(self.community.import_factor) + fixed).floor()
    }

    /// Fragments of a colony land around it. `event` tells several fragmentations of a month apart.
    pub(super) fn scatter(&mut self, parent: &Colony, event: u64) -> Result<()> {
        let (n, count) = (usize::from(parent.species), self.community.fragments);
        self.check_room("fragments", f64::from(count))?;
        let draws = Draws::new(self.seed, Stream::FragmentPlace, self.month * 4 + event);
        for i in 0..count {
            let s = &self.community.species[n];
            let (radius, range) = (s.fragment_radius, s.fragment_range);
            let who = parent.id * 128 + u64::from(i);
            let [x, y] = self.landing(parent.x, parent.y, range, draws, who);
            let hold = self.hold(x, y, |p| p.suits(&self.community.species[n]));
            if self.keeps(x, y) && draws.chance(3 * who + 2, hold) {
                self.push_colony(n, x, y, radius, FRAGMENT_AGE);
                self.births[n].1 += 1;
            }
        }
        Ok(())
    }

    /// Fragments of algae land around them, and those lose height.
    pub(super) fn scatter_algae(&mut self) -> Result<()> {
        let numbers = Draws::new(self.seed, Stream::AlgaFragments, self.month);
        let counts: Vec<u32> = self.algae.iter().map(|a| a.fragments(&self.community, numbers)).collect();
        self.check_room("algae.max_fragments", counts.iter().map(|&n| f64::from(n)).sum())?;
        let rules = self.community.algae.clone();
        let draws = Draws::new(self.seed, Stream::FragmentPlace, self.month * 4 + 3);
        for (n, count) in counts.into_iter().enumerate().filter(|(_, count)| *count > 0) {
            let parent = self.algae[n];
            self.algae[n].height -= rules.fragment_radius;
            for i in 0..count {
                let who = parent.id * 128 + u64::from(i);
                let [x, y] = self.landing(parent.x, parent.y, rules.fragment_range, draws, who);
                let hold = self.hold(x, y, |p| suits_algae(p, &self.community));
                if self.keeps(x, y) && draws.chance(3 * who + 2, hold) {
                    self.push_alga(x, y, rules.fragment_radius, rules.fragment_radius, 0);
                }
            }
        }
        Ok(())
    }

    /// Chance to find hold at a place: 1 without rasters of the ground.
    fn hold(&self, x: f32, y: f32, chance: impl Fn(&Place) -> f32) -> f32 {
        if self.site.ground.is_some() { chance(&self.site.at(x, y)) } else { 1.0 }
    }

    fn landing(&self, x: f32, y: f32, range: f32, draws: Draws, who: u64) -> [f32; 2] {
        let width = 2.0 * range + if self.community.compat { COMPAT_BIAS_M } else { 0.0 };
        [x - range + draws.unit(3 * who) * width, y - range + draws.unit(3 * who + 1) * width]
    }

    /// True if somebody at this place lives on: on the plot, or with `compat` not too far outside.
    pub(super) fn keeps(&self, x: f32, y: f32) -> bool {
        let halo = f64::from(self.halo_m());
        let within = |v: f32, side: f64| (-halo..=side + halo).contains(&f64::from(v));
        within(x, self.site.width_m) && within(y, self.site.length_m)
    }

    /// How far outside the plot branching corals and algae may live, m.
    pub(super) fn halo_m(&self) -> f32 {
        if self.community.compat { 10.0 } else { 0.0 }
    }
}

/// Chance that an alga finds hold.
fn suits_algae(place: &Place, community: &Community) -> f32 {
    if (0.0..=community.algae.max_depth).contains(&place.depth) { place.substrate } else { 0.0 }
}

/// Mean area of discs with radii from 0 to `max`, m2.
fn mean_area(max: f32) -> f64 {
    f64::from(PI * max * max / 3.0)
}

fn is_due(month: u64, first: u32, interval: u32) -> bool {
    month >= u64::from(first) && (month - u64::from(first)).is_multiple_of(u64::from(interval))
}
