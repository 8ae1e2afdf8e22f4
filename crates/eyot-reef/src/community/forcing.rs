//! Heat stress, month by month: what temperatures mean to corals.

use super::parameters::{Community, HeatRules, Stress, bad};
use super::random::{Draws, Stream};
use super::species::Species;
use super::temperature::{MONTH_DAYS, Temperatures, YEAR_DAYS};
use eyot_core::Result;
use eyot_core::math64::exp;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Heat stress of a month.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Heat {
    /// Heat index, C: the threshold plus the largest mean excess over it in a sliding window.
    pub index: f32,
    /// Largest degree heating weeks of the month, C week.
    pub heating_weeks: f32,
    /// Mean temperature, C.
    pub mean: f32,
}

impl Heat {
    /// Probability that a colony bleaches, and that it dies if it does.
    pub fn risks(&self, rules: &HeatRules, species: &Species) -> (f32, f32) {
        let share = |v: f32, low: f32, high: f32| (v - low) / (high - low);
        let (bleaching, death, sensitivity) = match rules.stress {
            Stress::Excess => (
                share(self.index, species.bleaching_min, species.bleaching_max),
                share(self.index, species.death_min, species.death_max),
                1.0,
            ),
            Stress::HeatingWeeks => {
                let [(b0, b1), (d0, d1)] = [rules.bleaching_weeks, rules.death_weeks].map(|[low, high]| (low, high));
                let weeks = self.heating_weeks;
                (share(weeks, b0, b1), share(weeks, d0, d1), species.heating_week_sensitivity)
            }
        };
        if bleaching < 0.0 {
            return (0.0, 0.0);
        }
        let bleaching = rules.least_bleaching + (1.0 - rules.least_bleaching) * bleaching;
        ((sensitivity * bleaching).clamp(0.0, 1.0), death.clamp(0.0, 1.0))
    }
}

/// How the temperature of a simulated climate varies around its monthly means: weather and warm years, each an anomaly that
/// forgets itself over some time (a first-order autoregressive process).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Variability {
    /// Standard deviation of the sea's weather.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "C"))]
    pub weather: f32,
    /// Time over which weather is forgotten.
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "d"))]
    pub weather_days: f32,
    /// Standard deviation of the anomaly of years.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "C"))]
    pub years: f32,
    /// Time over which that is forgotten.
    #[schemars(range(min = 10.0, max = 10000.0), extend("unit" = "d"))]
    pub years_days: f32,
    /// Warming.
    #[schemars(range(min = -1.0, max = 1.0), extend("unit" = "C/yr"))]
    pub trend: f32,
}

impl Default for Variability {
    /// Estimates for a tropical reef: 0.3 C over 10 days, 0.4 C over 200 days, no trend.
    fn default() -> Self {
        Self { weather: 0.3, weather_days: 10.0, years: 0.4, years_days: 200.0, trend: 0.0 }
    }
}

impl Variability {
    /// Adds variations to a series.
    pub fn vary(&self, series: &mut Temperatures, seed: u64) {
        let forgets = |days: f32| exp(-1.0 / f64::from(days));
        let (a, b) = (forgets(self.weather_days), forgets(self.years_days));
        let draws = Draws::new(seed, Stream::Weather, 0);
        let (mut weather, mut years) = (draws.normal(0), draws.normal(1));
        for (d, t) in series.days.iter_mut().enumerate() {
            let trend = f64::from(self.trend) * d as f64 / YEAR_DAYS as f64;
            *t += (f64::from(self.weather) * weather + f64::from(self.years) * years + trend) as f32;
            let next = 2 * (d as u64 + 1);
            weather = a * weather + (1.0 - a * a).sqrt() * draws.normal(next);
            years = b * years + (1.0 - b * b).sqrt() * draws.normal(next + 1);
        }
    }
}

/// Heat stress for all months to come.
#[derive(Clone, Debug)]
pub struct Forcing(Kind);

#[derive(Clone, Debug)]
enum Kind {
    /// One month after another; begins again with the first whole year when it is through.
    Series { first_month: usize, months: Vec<Heat> },
    /// Years that are drawn at random, and a severe one at equal intervals.
    Years { ordinary: Vec<[Heat; 12]>, severe: [Heat; 12], interval: u64, phase: u64, seed: u64 },
}

/// Mean monthly temperatures at Chumbe, Zanzibar, 1997 to 2010 without 1998, C.
pub const CHUMBE: [f32; 12] = [28.27, 28.37, 28.89, 28.51, 27.87, 26.84, 25.85, 25.25, 25.40, 26.04, 27.34, 28.44];
/// Largest mean excess over 29 C in 20 days of 1998, C.
const CHUMBE_1998: f32 = 1.55;
/// The same of 1997 and 1999 to 2010. Those of 1997, 2000 to 2005, 2007 and 2008 are only known to be at most 0.37, which bleaches
/// nothing; 0.2 stands for them.
const CHUMBE_YEARS: [f32; 13] = [0.2, 0.43, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.51, 0.2, 0.2, 0.70, 0.98];

/// Middle of the warm spells of ordinary years (11 April) and of 1998 (5 to 6 April), days; their standard deviation, days.
///
/// Only the excesses are known. These days are chosen so that the original program's cover comes out (`tests/it/source.rs`): the
/// spell of 1998 straddles two months, which see an index of 29.7 and 30.2 C.
const ORDINARY_DAY: f64 = 100.0;
const SEVERE_DAY: f64 = 94.5;
const SPELL_DAYS: f64 = 10.0;

impl Forcing {
    /// Severe years lie so far apart in [`Forcing::chumbe`].
    pub const SEVERE_INTERVAL: u32 = 15;

    /// Years as measured at Chumbe, Zanzibar: a severe one (1998) every fifteen years, the others in random order.
    ///
    /// # Errors
    /// If the rules of heat cannot work.
    pub fn chumbe(community: &Community, seed: u64) -> Result<Self> {
        Self::chumbe_every(community, Self::SEVERE_INTERVAL, seed)
    }

    /// As [`Forcing::chumbe`], with another interval between severe years.
    ///
    /// The days are not those of the logger: a warm spell in April on top of [`CHUMBE`], as high as gives the year's known largest
    /// mean excess.
    ///
    /// # Errors
    /// If the rules of heat cannot work, or the interval is 0.
    pub fn chumbe_every(community: &Community, severe_interval: u32, seed: u64) -> Result<Self> {
        community.heat.check()?;
        if severe_interval == 0 {
            return Err(bad("forcing", "severe_interval", "needs at least one year".into()));
        }
        let year = |excess: f32, day: f64| -> [Heat; 12] {
            let series = warm_spell(excess, day, community);
            let months = months_of(&series, community);
            std::array::from_fn(|m| months[m])
        };
        let interval = u64::from(severe_interval);
        let phase = u64::from(Draws::new(seed, Stream::Year, u64::MAX).bits(0)) % interval;
        Ok(Self(Kind::Years {
            ordinary: CHUMBE_YEARS.map(|excess| year(excess, ORDINARY_DAY)).to_vec(),
            severe: year(CHUMBE_1998, SEVERE_DAY),
            interval,
            phase,
            seed,
        }))
    }

    /// A measured or simulated series. It begins with its first January and begins again when its last whole year is through;
    /// a series of less than a whole year from January on is taken as it is.
    ///
    /// # Errors
    /// If it holds no whole month, or the rules of heat cannot work.
    pub fn series(temperatures: &Temperatures, community: &Community) -> Result<Self> {
        community.heat.check()?;
        let months = months_of(temperatures, community);
        if months.is_empty() {
            return Err(bad("forcing", "temperatures", "hold no whole month".into()));
        }
        let skip = (12 - temperatures.first_month) % 12;
        let whole = months.len().saturating_sub(skip) / 12 * 12;
        if whole == 0 {
            return Ok(Self(Kind::Series { first_month: temperatures.first_month, months }));
        }
        Ok(Self(Kind::Series { first_month: 0, months: months[skip..skip + whole].to_vec() }))
    }

    /// The same heat every month; 0 C for a sea that never bleaches anything.
    pub fn constant(heat: Heat) -> Self {
        Self(Kind::Series { first_month: 0, months: vec![heat] })
    }

    /// Heat of a month; month 0 is a January, unless a series shorter than a year begins otherwise.
    pub fn heat(&self, month: u64) -> Heat {
        match &self.0 {
            Kind::Series { months, .. } => months[(month % months.len() as u64) as usize],
            Kind::Years { ordinary, severe, interval, phase, seed } => {
                let (year, m) = (month / 12, (month % 12) as usize);
                if (year + phase) % interval == interval - 1 {
                    return severe[m];
                }
                let pick = Draws::new(*seed, Stream::Year, year).bits(0) as usize;
                ordinary[pick % ordinary.len()][m]
            }
        }
    }

    /// Month of the year of month 0: 0 is January.
    pub fn first_month(&self) -> usize {
        match &self.0 {
            Kind::Series { first_month, .. } => *first_month,
            Kind::Years { .. } => 0,
        }
    }
}

/// A year of [`CHUMBE`] with a warm spell around a day, whose largest mean excess over 29 C in 20 days is `excess`.
fn warm_spell(excess: f32, day: f64, community: &Community) -> Temperatures {
    let calm = Temperatures::of_climate(&CHUMBE, 1);
    let shape: Vec<f32> = (0..YEAR_DAYS)
        .map(|d| {
            let t = (d as f64 - day) / SPELL_DAYS;
            exp(-0.5 * t * t) as f32
        })
        .collect();
    let warmer = |height: f32| -> Vec<f32> { calm.days.iter().zip(&shape).map(|(t, s)| t + height * s).collect() };
    let (mut low, mut high) = (0.0f32, 8.0f32);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        let most = excesses(&warmer(middle), 29.0, 20 + usize::from(community.compat), 20.0).fold(0.0, f32::max);
        if most < excess { low = middle } else { high = middle }
    }
    Temperatures { first_month: 0, days: warmer(high) }
}

/// Sum of what the last `window` days exceed `threshold`, over `divisor`, day by day.
fn excesses(days: &[f32], threshold: f32, window: usize, divisor: f32) -> impl Iterator<Item = f32> + '_ {
    let excess = move |d: usize| (days[d] - threshold).max(0.0);
    // Sums anew for each day: a running sum would drag its rounding errors along.
    (0..days.len()).map(move |d| (d.saturating_sub(window - 1)..=d).map(excess).sum::<f32>() / divisor)
}

/// Heat of the whole months of a series.
fn months_of(series: &Temperatures, community: &Community) -> Vec<Heat> {
    let rules = &community.heat;
    let window = rules.window as usize + usize::from(community.compat);
    let warmest = if rules.warmest_month > 0.0 { rules.warmest_month } else { series.warmest_month() };
    // NOAA Coral Reef Watch: days at least 1 C above the warmest month count, over twelve weeks.
    let hot: Vec<f32> = series.days.iter().map(|t| t - warmest).map(|h| if h >= 1.0 { h } else { 0.0 }).collect();
    let weeks: Vec<f32> = excesses(&hot, 0.0, 84, 7.0).collect();
    let mut from = 0;
    (0..series.months())
        .map(|n| {
            let days = from..from + MONTH_DAYS[(series.first_month + n) % 12];
            from = days.end;
            let most = |v: &[f32]| v.iter().copied().fold(0.0, f32::max);
            // A month looks at its own days only, so that no hot day counts in two months.
            let excess =
                |v: &[f32]| -> Vec<f32> { excesses(v, rules.threshold, window, rules.window as f32).collect() };
            Heat {
                index: rules.threshold + most(&excess(&series.days[days.clone()])),
                heating_weeks: most(&weeks[days.clone()]),
                mean: series.days[days.clone()].iter().sum::<f32>() / days.len() as f32,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_years_of_chumbe_have_their_known_index() {
        let community = Community::default();
        // The warmest day that was measured had 30.68 C.
        let spell = warm_spell(CHUMBE_1998, SEVERE_DAY, &community);
        let warmest = spell.days.iter().copied().fold(0.0, f32::max);
        assert!((warmest - 30.68).abs() < 0.3, "{warmest}");
        for excess in CHUMBE_YEARS.into_iter().chain([CHUMBE_1998]) {
            let spell = warm_spell(excess, ORDINARY_DAY, &community);
            let most = excesses(&spell.days, 29.0, 20, 20.0).fold(0.0, f32::max);
            assert!((most - excess).abs() < 1e-3, "{most} {excess}");
            let index = months_of(&spell, &community).iter().map(|h| h.index).fold(0.0, f32::max);
            assert!((excess - 0.05..excess + 1e-3).contains(&(index - 29.0)), "{index} {excess}");
        }
    }

    #[test]
    fn severe_years_come_at_equal_intervals_from_a_random_phase() {
        let community = Community::default();
        let mut phases = Vec::new();
        for seed in 0..40 {
            let forcing = Forcing::chumbe(&community, seed).unwrap();
            let severe: Vec<u64> = (0..60).filter(|y| forcing.heat(12 * y + 3).index > 30.1).collect();
            assert_eq!(severe.len(), 4);
            assert!(severe.windows(2).all(|w| w[1] - w[0] == 15));
            phases.push(severe[0]);
        }
        phases.sort_unstable();
        phases.dedup();
        assert!(phases.len() > 10, "{phases:?}");
    }

    #[test]
    fn degree_heating_weeks_count_days_above_the_warmest_month() {
        let mut community = Community::default();
        community.heat.warmest_month = 28.0;
        // 35 days at 30 C: 2 C times 5 weeks, all within twelve weeks; 28.9 C is no hot day.
        let mut days = vec![28.9f32; 365];
        days[40..75].fill(30.0);
        let heat = months_of(&Temperatures { first_month: 0, days }, &community);
        let weeks: Vec<f32> = heat.iter().map(|h| h.heating_weeks).collect();
        assert!((weeks[2] - 10.0).abs() < 1e-4 && (weeks[3] - 10.0).abs() < 1e-4, "{weeks:?}");
        assert_eq!((weeks[0], weeks[6]), (0.0, 0.0));
        let risks = |sensitivity: f32, weeks: f32| {
            let rules = HeatRules { stress: Stress::HeatingWeeks, ..Default::default() };
            let species = Species { heating_week_sensitivity: sensitivity, ..Default::default() };
            Heat { heating_weeks: weeks, ..Default::default() }.risks(&rules, &species)
        };
        assert_eq!((risks(1.0, 3.9), risks(1.0, 16.0)), ((0.0, 0.0), (1.0, 8.0 / 12.0)));
        assert!(risks(0.25, 16.0).0 == 0.25 && (risks(1.5, 10.0).0 - 0.975).abs() < 1e-6);
    }

    #[test]
    fn a_series_begins_with_its_first_january_and_repeats() {
        let community = Community::default();
        let text: String =
            (0..30).map(|i| format!("{}-{:02},{}\n", 2000 + (i + 6) / 12, (i + 6) % 12 + 1, 20 + i % 12)).collect();
        let series = Temperatures::parse(&text, false).unwrap();
        let forcing = Forcing::series(&series, &community).unwrap();
        let means: Vec<f32> = (0..26).map(|m| forcing.heat(m).mean).collect();
        assert_eq!((means[0], means[23], means[24]), (26.0, 25.0, 26.0));
        let short =
            Forcing::series(&Temperatures::parse("2001-05,28\n2001-06,29", false).unwrap(), &community).unwrap();
        assert_eq!((short.first_month(), short.heat(0).mean, short.heat(3).mean), (4, 28.0, 29.0));
    }

    #[test]
    fn variations_have_their_spread() {
        let mut series = Temperatures::of_climate(&[27.0; 12], 400);
        Variability { trend: 0.0, ..Default::default() }.vary(&mut series, 3);
        let n = series.days.len() as f64;
        let mean = series.days.iter().map(|&t| f64::from(t)).sum::<f64>() / n;
        let sd = (series.days.iter().map(|&t| (f64::from(t) - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!((mean - 27.0).abs() < 0.06 && (sd - 0.5).abs() < 0.04, "{mean} {sd}");
    }
}
