//! A plot: everybody who lives on it, and what happens to them in a month.

use super::algae::Shore;
use super::census::{Census, Deaths, SpeciesCensus};
use super::colony::{Alga, Colony};
use super::competition::{Neighbours, Verdict, is_branching};
use super::disturbance::{self, Calendar};
use super::forcing::{Forcing, Heat};
use super::geometry::{Rays, mean};
use super::index::{Extent, Index};
use super::parallel::{map, map_in_order, map_mut};
use super::parameters::{Community, bad};
use super::random::{Draws, Stream};
use super::site::Site;
use super::turf::TurfGrid;
use eyot_core::{Control, Field, Limits, Result};
use std::f32::consts::PI;

/// Density of aragonite, kg/m3.
const ARAGONITE: f64 = 2930.0;

/// A community at its place.
pub struct Plot {
    pub(super) community: Community,
    pub(super) site: Site,
    pub(super) limits: Limits,
    pub(super) seed: u64,
    forcing: Forcing,
    /// Months done.
    pub(super) month: u64,
    pub(super) colonies: Vec<Colony>,
    /// Of the colonies, in their order.
    pub(super) rays: Vec<Rays>,
    pub(super) algae: Vec<Alga>,
    pub(super) turf: TurfGrid,
    pub(super) next_id: u64,
    pub(super) calendars: [Calendar; 2],
    /// Deaths of this month by species.
    deaths: Vec<Deaths>,
    /// Recruits and fragments of this month by species.
    pub(super) births: Vec<(u64, u64)>,
    coral_index: Index,
    alga_index: Index,
    grown: Vec<Rays>,
    verdicts: Vec<Verdict>,
}

impl Plot {
    /// A plot with the first corals, algae and turf on it.
    ///
    /// # Errors
    /// If a parameter or the site cannot work, or if they make more individuals than fit into the default limits.
    pub fn new(community: Community, site: Site, forcing: Forcing, seed: u64) -> Result<Self> {
        Self::under(community, site, forcing, seed, &Control::none())
    }

    /// As [`Plot::new`], within other limits and stopped on request.
    ///
    /// # Errors
    /// As [`Plot::new`], or on a request to stop.
    pub fn under(community: Community, site: Site, forcing: Forcing, seed: u64, control: &Control<'_>) -> Result<Self> {
        let mut plot = Self::empty(community, site, forcing, seed, *control.limits())?;
        plot.populate(control)?;
        let draws = Draws::new(seed, Stream::Placing, u64::MAX);
        plot.turf = TurfGrid::new(&plot.site, &plot.community.turf, draws);
        Ok(plot)
    }

    /// Finds what keeps a plot from being made, before anything is allocated.
    ///
    /// # Errors
    /// If a parameter or the site cannot work, or exceeds the limits.
    pub fn check(community: &Community, site: &Site, limits: &Limits) -> Result<()> {
        community.check()?;
        site.check(community, limits)?;
        disturbance::check(community, site)
    }

    /// A bare plot.
    ///
    /// # Errors
    /// If a parameter or the site cannot work, or exceeds the limits.
    pub fn empty(community: Community, site: Site, forcing: Forcing, seed: u64, limits: Limits) -> Result<Self> {
        Self::check(&community, &site, &limits)?;
        let mut turf = TurfGrid::new(&site, &community.turf, Draws::new(seed, Stream::Placing, 0));
        turf.set(0.0);
        let interval = |kind: u64| Draws::new(seed, Stream::Interval, kind);
        let calendars = [
            Calendar::new(&community.small_disturbances, interval(0)),
            Calendar::new(&community.large_disturbances, interval(1)),
        ];
        let species = community.species.len();
        Ok(Self {
            community,
            site,
            limits,
            seed,
            forcing,
            month: 0,
            colonies: Vec::new(),
            rays: Vec::new(),
            algae: Vec::new(),
            turf,
            next_id: 0,
            calendars,
            deaths: vec![Deaths::default(); species],
            births: vec![(0, 0); species],
            coral_index: Index::default(),
            alga_index: Index::default(),
            grown: Vec::new(),
            verdicts: Vec::new(),
        })
    }

    /// Lives through a month.
    ///
    /// # Errors
    /// If it would make more individuals than the limits allow.
    pub fn month(&mut self) -> Result<Census> {
        self.month_under(&Control::none())
    }

    /// As [`Plot::month`], stopped on request: the plot is then in the midst of the month and of no further use.
    ///
    /// # Errors
    /// As [`Plot::month`], or on a request to stop.
    pub fn month_under(&mut self, control: &Control<'_>) -> Result<Census> {
        self.deaths.fill(Deaths::default());
        self.births.fill((0, 0));
        let heat = self.forcing.heat(self.month);
        self.bleach(heat);
        control.check()?;
        self.index();
        self.compete(control)?;
        self.grow_algae(control)?;
        self.turf.grow(&self.community, &self.coral_index, control)?;
        self.bury_losers();
        control.check()?;
        self.break_and_fragment()?;
        self.scatter_algae()?;
        let disturbances = self.disturb(control)?;
        self.recruit(control)?;
        let mut census = self.census();
        control.check()?;
        census.heat = heat;
        census.disturbances = disturbances;
        self.feed_back(census.rugosity);
        census.grazing = self.graze(&census);
        self.month += 1;
        Ok(census)
    }

    /// Lives through so many months and hands each census to `report`.
    ///
    /// # Errors
    /// As [`Plot::month`], or on a request to stop.
    pub fn run(&mut self, months: u64, control: &Control<'_>, mut report: impl FnMut(Census)) -> Result<()> {
        for done in 0..months {
            report(self.month_under(control)?);
            control.tick(done + 1, months)?;
        }
        Ok(())
    }

    /// Months done.
    pub const fn months(&self) -> u64 {
        self.month
    }

    /// The parameters.
    pub const fn community(&self) -> &Community {
        &self.community
    }

    /// The place.
    pub const fn site(&self) -> &Site {
        &self.site
    }

    /// Living colonies, in the order in which they came.
    pub fn colonies(&self) -> &[Colony] {
        &self.colonies
    }

    /// Lengths of the colonies' rays, m, in the order of [`Plot::colonies`].
    pub fn rays(&self) -> &[Rays] {
        &self.rays
    }

    /// Living macroalgae, in the order in which they came.
    pub fn algae(&self) -> &[Alga] {
        &self.algae
    }

    /// Cover of turf at a place, 0..=1.
    pub fn turf_at(&self, x: f32, y: f32) -> f32 {
        self.turf.at(x, y)
    }

    /// Sets the cover of turf everywhere, 0..=1.
    ///
    /// # Errors
    /// If it is something else.
    pub fn set_turf(&mut self, cover: f32) -> Result<()> {
        if !(0.0..=1.0).contains(&cover) {
            return Err(bad("turf", "cover", format!("{cover} is not within 0..=1")));
        }
        self.turf.set(cover);
        Ok(())
    }

    /// Heat: colonies bleach and die, or recover.
    fn bleach(&mut self, heat: Heat) {
        let (community, month) = (&self.community, self.month);
        let risks: Vec<(f32, f32)> = community.species.iter().map(|s| heat.risks(&community.heat, s)).collect();
        let [bleaching, death] = [Stream::Bleaching, Stream::HeatDeath].map(|s| Draws::new(self.seed, s, month));
        let fate = |_: usize, c: &mut Colony| -> bool {
            let (p_bleach, p_death) = risks[usize::from(c.species)];
            let before = c.bleaching;
            if bleaching.chance(c.id, p_bleach) {
                if death.chance(c.id, p_death) {
                    return false;
                }
                c.bleaching = 1.0;
            } else {
                // Rounding must not leave a trace of bleaching.
                c.bleaching =
                    if before > community.heat.recovery + 1e-4 { before - community.heat.recovery } else { 0.0 };
            }
            c.vigour = match (community.compat, is_branching(community, c)) {
                (false, _) => 1.0 - c.bleaching,
                // The original program forgets it for massive corals, and is a month late for branching ones.
                (true, false) => 1.0,
                (true, true) => 1.0 - before,
            };
            true
        };
        let alive = map_mut(&mut self.colonies, fate);
        self.bury(&alive, |d| &mut d.heat);
    }

    /// Removes colonies and counts them under a cause of death.
    pub(super) fn bury(&mut self, alive: &[bool], cause: impl Fn(&mut Deaths) -> &mut u64) {
        // Most months nobody dies of most causes, and whoever stands before the first dead stays in place.
        let Some(first) = alive.iter().position(|lives| !lives) else { return };
        let mut kept = first;
        for (i, &lives) in alive.iter().enumerate().skip(first) {
            if lives {
                self.colonies.swap(kept, i);
                self.rays.swap(kept, i);
                kept += 1;
            } else {
                *cause(&mut self.deaths[usize::from(self.colonies[i].species)]) += 1;
            }
        }
        self.colonies.truncate(kept);
        self.rays.truncate(kept);
    }

    fn index(&mut self) {
        let community = &self.community;
        let halo = self.halo_m();
        let extent =
            Extent { from: [-halo; 2], to: [self.site.width_m as f32 + halo, self.site.length_m as f32 + halo] };
        let entry = |i: usize, c: &Colony| {
            c.entry(i, &self.rays[i], &community.species[usize::from(c.species)], community.compat)
        };
        let corals = map(&self.colonies, entry);
        self.coral_index.fill(extent, community.max_radius(), corals.iter().copied());
        let algae = self.algae.iter().enumerate().map(|(i, a)| a.entry(i));
        self.alga_index.fill(extent, community.algae.max_radius, algae);
    }

    fn neighbours(&self) -> Neighbours<'_> {
        let (corals, algae) = (&self.coral_index, &self.alga_index);
        Neighbours { community: &self.community, corals, algae, rays: &self.rays }
    }

    /// What everybody's neighbours do to them; nobody changes yet.
    fn compete(&mut self, control: &Control<'_>) -> Result<()> {
        let neighbours = self.neighbours();
        let results = map_in_order(&self.colonies, self.coral_index.order(), |i, me| {
            let mut grown = Rays::default();
            if control.check().is_err() {
                return (grown, Verdict::default());
            }
            let verdict = neighbours.compete(i, me, &mut grown);
            (grown, verdict)
        });
        let (grown, verdicts) = results.into_iter().unzip();
        (self.grown, self.verdicts) = (grown, verdicts);
        control.check()
    }

    /// Those who are overgrown die, one after another in random order, so that of two that overgrow each other one lives; turf
    /// takes settlers; the others grow.
    fn bury_losers(&mut self) {
        let order = Draws::new(self.seed, Stream::Order, self.month);
        let mut losers: Vec<usize> = (0..self.colonies.len()).filter(|&i| self.verdicts[i].overgrown).collect();
        losers.sort_unstable_by_key(|&i| (order.bits(self.colonies[i].id), i));
        let mut alive = vec![true; self.colonies.len()];
        let neighbours = self.neighbours();
        for i in losers {
            alive[i] = !neighbours.is_overgrown(i, &self.colonies[i], &alive);
        }
        std::mem::swap(&mut self.rays, &mut self.grown);
        let (rays, verdicts, species) = (&self.rays, &self.verdicts, &self.community.species);
        map_mut(&mut self.colonies, |i, c| {
            let species = &species[usize::from(c.species)];
            let surface = 2.0 * PI * c.radius * c.radius;
            c.calcified_kg = surface * verdicts[i].extension * species.skeletal_density * species.solid_share;
            c.radius = mean(&rays[i]);
        });
        let smothered = self.smothered(&alive);
        // The verdicts of the dead are of no further use.
        let mut keep = alive.iter().zip(&smothered).map(|(a, s)| *a && !*s);
        self.verdicts.retain(|_| keep.next().unwrap_or(false));
        self.bury(&alive, |d| &mut d.overgrowth);
        let lives: Vec<bool> = alive.iter().zip(smothered).filter(|(a, _)| **a).map(|(_, s)| !s).collect();
        self.bury(&lives, |d| &mut d.turf);
        self.colonies.iter_mut().for_each(|c| c.age += 1);
    }

    /// Settlers that turf kills.
    fn smothered(&self, alive: &[bool]) -> Vec<bool> {
        let draws = Draws::new(self.seed, Stream::Turf, self.month);
        let risk = |c: &Colony| self.community.turf.kills_settlers * self.turf.at(c.x, c.y);
        self.colonies.iter().zip(alive).map(|(c, alive)| *alive && c.age <= 1 && draws.chance(c.id, risk(c))).collect()
    }

    /// Algae grow, and die of age, of corals and of taller algae.
    fn grow_algae(&mut self, control: &Control<'_>) -> Result<()> {
        let shore = Shore {
            corals: &self.coral_index,
            algae: &self.alga_index,
            colonies: &self.colonies,
            rays: &self.rays,
            draws: Shore::stream(self.seed, self.month),
        };
        let fates = map_in_order(&self.algae, self.alga_index.order(), |_, a| {
            if control.check().is_err() {
                return (false, false);
            }
            let dies = a.age > self.community.algae.max_age || shore.is_displaced(a);
            (!dies, !dies && shore.is_shaded(a, |_| true))
        });
        control.check()?;
        let mut alive: Vec<bool> = fates.iter().map(|f| f.0).collect();
        let order = Draws::new(self.seed, Stream::Order, self.month);
        let mut losers: Vec<usize> = (0..fates.len()).filter(|&i| fates[i].1).collect();
        losers.sort_unstable_by_key(|&i| (order.bits(self.algae[i].id), i));
        for i in losers {
            alive[i] = !shore.is_shaded(&self.algae[i], |other| alive[other]);
        }
        let mut next = alive.into_iter();
        self.algae.retain(|_| next.next().unwrap_or(false));
        self.algae.iter_mut().for_each(|a| a.grow(&self.community));
        Ok(())
    }

    /// Full-grown branching colonies drop fragments; those that nobody supports may break.
    fn break_and_fragment(&mut self) -> Result<()> {
        let [breakage, fragmentation] =
            [Stream::Breakage, Stream::Fragmentation].map(|s| Draws::new(self.seed, s, self.month));
        let mut alive = vec![true; self.colonies.len()];
        let mut parents = Vec::new();
        for (i, c) in self.colonies.iter().enumerate().filter(|(_, c)| is_branching(&self.community, c)) {
            let species = &self.community.species[usize::from(c.species)];
            let (breaks, fragments) = (
                self.community.breakage * species.surface_factor,
                self.community.fragmentation * species.surface_factor,
            );
            // Means of equal rays may round to just below them.
            if c.radius >= 0.9999 * species.max_radius && fragmentation.chance(c.id, fragments) {
                parents.push((*c, 0));
            }
            if !self.verdicts[i].supported && breakage.chance(c.id, breaks) {
                alive[i] = false;
                parents.push((*c, 1));
            }
        }
        self.bury(&alive, |d| &mut d.breakage);
        for (parent, event) in parents {
            match event {
                0 => self.scatter(&parent, 0)?,
                event => self.fragment(&parent, event)?,
            }
        }
        Ok(())
    }

    /// A colony that dies may leave fragments.
    pub(super) fn fragment(&mut self, parent: &Colony, event: u64) -> Result<()> {
        let factor = self.community.species[usize::from(parent.species)].surface_factor;
        let draws = Draws::new(self.seed, Stream::Fragmentation, u64::MAX - self.month * 4 - event);
        if is_branching(&self.community, parent) && draws.chance(parent.id, self.community.fragmentation * factor) {
            self.scatter(parent, event)?;
        }
        Ok(())
    }

    /// Counts everybody. With `compat` those outside the plot count too.
    fn census(&self) -> Census {
        let area = self.site.area_m2();
        let counts = |x: f32, y: f32| self.community.compat || self.site.contains(x, y);
        let mut species = vec![SpeciesCensus::default(); self.community.species.len()];
        let (mut surface, mut covered) = (0.0, 0.0);
        for c in self.colonies.iter().filter(|c| counts(c.x, c.y)) {
            let s = &mut species[usize::from(c.species)];
            let disc = f64::from(c.area_m2());
            s.colonies += 1;
            s.bleached += u64::from(c.is_bleached());
            s.cover += disc / area;
            s.calcified_kg += f64::from(c.calcified_kg);
            covered += disc;
            surface += 2.0 * disc * f64::from(self.community.species[usize::from(c.species)].surface_factor);
        }
        for (n, s) in species.iter_mut().enumerate() {
            s.deaths = self.deaths[n];
            (s.recruits, s.fragments) = self.births[n];
        }
        let mass: f64 = species.iter().map(|s| s.calcified_kg).sum();
        let algae = || self.algae.iter().filter(|a| counts(a.x, a.y));
        Census {
            month: self.month,
            species,
            algae: algae().count() as u64,
            algae_cover: algae().map(|a| f64::from(a.area_m2())).sum::<f64>() / area,
            turf_cover: self.turf.mean(),
            rugosity: ((surface + (area - covered).max(0.0)) / area).sqrt(),
            limestone_m: self.limestone_m3(mass) / area,
            ..Census::default()
        }
    }

    /// Volume of limestone, pores included, that skeletons of this mass (kg) become, m3.
    fn limestone_m3(&self, mass_kg: f64) -> f64 {
        mass_kg / (ARAGONITE * (1.0 - f64::from(self.community.porosity)))
    }

    /// Adds what the last month's skeletons become to a layer of limestone (m) on square cells, row 0 north, that begins at the
    /// plot's corner. Waves spread it into a flat heap (a paraboloid) that reaches `range_m` from a colony's centre, or as far as
    /// the colony if that is wider. None leaves the layer.
    ///
    /// # Errors
    /// On a request to stop; then a part of it is missing.
    pub fn deposit(&self, cell_m: f64, range_m: f64, limestone: &mut Field, control: &Control<'_>) -> Result<()> {
        let (w, h) = (limestone.width() as isize, limestone.height() as isize);
        let mut heap = Vec::new();
        for c in self.colonies.iter().filter(|c| c.calcified_kg > 0.0) {
            control.check()?;
            let [x, y] = [c.x, c.y].map(|v| f64::from(v) / cell_m);
            let reach = range_m.max(f64::from(c.radius)) / cell_m;
            let within =
                |v: f64, n: isize| ((v - reach).floor() as isize).max(0)..=((v + reach).floor() as isize).min(n - 1);
            let (columns, rows) = (within(x, w), within(y, h));
            heap.clear();
            for j in rows.clone() {
                let dy = j as f64 + 0.5 - y;
                heap.extend(columns.clone().map(|i| {
                    let dx = i as f64 + 0.5 - x;
                    (1.0 - (dx * dx + dy * dy) / (reach * reach)).max(0.0)
                }));
            }
            let shares: f64 = heap.iter().sum();
            let all = self.limestone_m3(f64::from(c.calcified_kg)) / (cell_m * cell_m);
            if shares <= 0.0 {
                // Less than a cell: where the centre is.
                let [i, j] = [(x, w), (y, h)].map(|(v, n)| (v.max(0.0) as usize).min(n as usize - 1));
                limestone.set(i, j, limestone.get(i, j) + all as f32);
                continue;
            }
            let (first, last) = (*columns.start() as usize, *columns.end() as usize);
            for (j, shares_of_row) in rows.zip(heap.chunks_exact(last + 1 - first)) {
                let row = &mut limestone.row_mut(j as usize)[first..=last];
                row.iter_mut().zip(shares_of_row).for_each(|(cell, share)| *cell += (all * share / shares) as f32);
            }
        }
        Ok(())
    }
}
