//! A community of corals: single colonies, macroalgae and turf that grow, fight for space, bleach, break, die and settle, month by
//! month, on a plot of sea floor.
//!
//! # Entities
//! A colony is a centre and 24 rays, 15 degrees apart; `r` is their mean. Massive colonies cover the polygon through the rays'
//! ends, branching ones and algae a disc. Turf has a cover on each cell of a grid. Species are data ([`Species`]).
//!
//! # A month
//! Everybody sees the others as they were when the month began; only deaths by overgrowth are settled one after another.
//! 1. Heat. `T* = threshold + max over the month of (sum of the excess of the last 20 days) / 20`. A colony bleaches with
//!    `P = 0.3 + 0.7 (T* - bleaching_min) / (bleaching_max - bleaching_min)` if `T* >= bleaching_min`, and then dies with
//!    `P = (T* - death_min) / (death_max - death_min)`; others recover by 0.17. Degree heating weeks can decide instead.
//! 2. Growth. A ray grows by `growth / 12`, times 0.7 for each neighbour that covers its tip, and 0.3 more if that one is larger.
//!    Branches stop at massive bodies. Bleached neighbours cover nothing.
//! 3. Overgrowth. A colony dies if discs of its neighbours overlap 75 % of its own, or if one engulfs it
//!    (`r_other > r + distance`). Against massive neighbours branching colonies count larger ones only.
//! 4. Turf kills settlers of age 0 and 1 with `P = cover / 2`.
//! 5. Algae grow 3 cm, in width and then in height, and die of age, under larger corals or taller algae.
//! 6. Turf grows 5 points, times 0.9 for each coral wider than a cell that overlaps it.
//! 7. Full-grown branching colonies fragment with `P = 0.002 surface_factor`; those that nobody supports break with
//!    `P = 0.001 surface_factor`. Algae above 30 cm fragment.
//! 8. Disturbances clear discs of 2 to 4 m every year and of 5 to 10 m every third year.
//! 9. Larvae settle: `N = floor(sum of 2 pi r^2 surface_factor propagules retention)` over mature colonies, and as many from
//!    elsewhere.
//! 10. Census, then grazing: algae die, and cells of turf lose half, with
//!     `p = 0.08 (1 - (7.5 % / cover)^2) + 0.14`. While rugosity feeds back (`feedback_from`), the middle of that range,
//!     0.18, is `0.18 (rugosity - 1) / 2.5`, and the intervals of disturbances shrink by a tenth for each year with a rugosity
//!     below 1.75.
//!
//! # Source
//! The individual-based model of Kubicek, Muhando and Reuter 2012 in its published parameters and described behaviour. Light
//! limits growth after Bosscher and Schlager 1992; degree heating weeks are those of NOAA Coral Reef Watch (Liu and others 2003).
//! `tests/it/source.rs` compares with runs of the original program.
//!
//! # Differences
//! With `compat` the model behaves like the original program. Without it:
//! - Bleaching slows growth by its grade, at once. The original forgets it for massive corals and is a month late for branching
//!   ones (`recovery_takes_six_months_and_slows_growth`).
//! - Among branching corals the larger one shades more; in the original the smaller one (`neighbours_slow_the_rays...`).
//! - `competition` weighs who is larger; the original reads it and forgets it (same test).
//! - Who leaves the plot is lost. In the original branching corals and algae live up to 10 m outside and count as cover
//!   (`nobody_leaves_the_plot_except_in_the_original`).
//! - Algae end at their largest height (`algae_give_way...`), and have 0, 1 or 2 fragments instead of 0 or 2
//!   (`algae_grow_in_width...`).
//! - Larvae come from elsewhere, too, whatever lives here (`imported_recruits`), so that a reef outlives centuries
//!   (`a_reef_outlives_centuries`); in the original a species that is gone never comes back.
//! - Fragments and discs are not biased by 10 cm. The heat index sums 20 days, not 21 (both:
//!   `the_original_throws_fragments_too_far...`). Gaps in temperatures are bridged instead of being cold
//!   (`tables_of_days_and_months_are_read`).
//! - Disturbances come in proportion to the area; in the original a plot of any size gets one (`disturbances_fit_the_area...`).
//!
//! In both:
//! - All act on the same month's state instead of one after another in random order. A heat index looks at the days of its own
//!   month only.
//! - The days of the sea at Chumbe are not those of the logger, see [`Forcing::chumbe`].
//! - Depth, light and substrate decide where larvae find hold; light slows growth. Flat plots without rasters know neither.
//! - Of the original's slips without consequences, that a probability of death outlasts the heat which nobody bleaches in, and that turf and
//!   settlers look at each other one by one, there is no trace. Algae grow 30 mm a month, as in its files, not 30 cm.
//! - Fragments have an age of two months and are no settlers for turf. What shades turf is a coral wider than its cell.
//!
//! # Limestone
//! A colony makes `density solid_share 2 pi r^2 e` of aragonite a month, `e` being the mean extension of its rays before they end at
//! the largest radius: the growth of a hemisphere. Colonies of full size go on; what they make falls off as rubble.
//! The plot's limestone is that mass over 2930 kg/m3 and over one minus the porosity: 4 to 7 mm a year on the default plot, within
//! the 5 mm a year of Holocene reefs and the 12 mm a year that the terrain's reef grows in the best light.
//!
//! # Conserves
//! Colonies: births and deaths by cause account for every one (`births_and_deaths_account_for_every_colony`).

mod algae;
mod census;
mod colony;
mod competition;
mod disturbance;
mod forcing;
mod geometry;
mod grazing;
mod index;
mod parallel;
mod parameters;
mod plot;
mod population;
mod random;
mod settling;
mod site;
mod species;
mod temperature;
mod turf;

pub use census::{Census, CensusColumn, Deaths, SpeciesCensus};
pub use colony::{Alga, Colony};
pub use forcing::{CHUMBE, Forcing, Heat, Variability};
pub(crate) use geometry::sector as sector_of;
pub use geometry::{DIRECTIONS, RAYS, Rays};
pub use grazing::grazing_probability;
pub use parameters::{Algae, Community, Disturbances, Grazing, HeatRules, Stress, Turf};
pub use plot::Plot;
pub use population::{POPULATION, Population};
pub use site::{Ground, MAX_SIDE_M, Place, Site};
pub use species::{Form, Species};
pub use temperature::Temperatures;
pub(crate) use temperature::{MONTH_DAYS, YEAR_DAYS};
