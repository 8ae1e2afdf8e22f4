//! Whole plots: the same bytes on any number of threads, nothing lost, nothing where it cannot live, and errors instead of panics.

#![allow(missing_docs)]

use crate::common;

use common::{bare, cool, quiet};
use eyot_core::{Cancel, Control, Error, Field, Limits};
use eyot_reef::community::{Census, Community, Forcing, Ground, Heat, Place, Plot, Site, Temperatures};
use proptest::prelude::*;

fn run(community: &Community, site: Site, seed: u64, months: usize) -> (Plot, Vec<Census>) {
    let forcing = Forcing::chumbe(community, seed).unwrap();
    let mut plot = Plot::new(community.clone(), site, forcing, seed).unwrap();
    let rows = (0..months).map(|_| plot.month().unwrap()).collect();
    (plot, rows)
}

#[test]
fn threads_change_nothing_and_seeds_everything() {
    for compat in [false, true] {
        let c = Community { compat, ..Default::default() };
        let with = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (plot, rows) = run(&c, Site::flat(30.0, 20.0), seed, 60);
                (plot.colonies().to_vec(), plot.rays().to_vec(), plot.algae().to_vec(), rows)
            })
        };
        let one = with(1, 7);
        assert!(one == with(3, 7) && one == with(8, 7));
        assert!(one.0 != with(1, 8).0);
    }
}

fn assert_books_balance(plot: &Plot, rows: &[Census], before: &mut [u64]) {
    for row in rows {
        for (n, s) in row.species.iter().enumerate() {
            assert_eq!(
                before[n] + s.recruits + s.fragments,
                s.colonies + s.deaths.all(),
                "month {} species {n}",
                row.month
            );
            before[n] = s.colonies;
        }
    }
    assert_eq!(rows.last().map(Census::colonies), Some(plot.colonies().len() as u64));
}

#[test]
fn births_and_deaths_account_for_every_colony() {
    let c = Community::default();
    let (forcing, site) = (Forcing::chumbe(&c, 3).unwrap(), Site::flat(20.0, 20.0));
    let mut plot = Plot::new(c, site, forcing, 3).unwrap();
    let mut before = vec![0; 4];
    plot.colonies().iter().for_each(|c| before[usize::from(c.species)] += 1);
    let rows: Vec<Census> = (0..240).map(|_| plot.month().unwrap()).collect();
    assert_books_balance(&plot, &rows, &mut before);
    let fragments: u64 = rows.iter().flat_map(|r| &r.species).map(|s| s.fragments).sum();
    assert!(fragments > 0);
    // Tables have the same columns every month.
    let names = ["a", "b", "c", "d"];
    let columns = |r: &Census| r.columns(&names).into_iter().map(|c| c.0).collect::<Vec<_>>();
    assert_eq!(columns(&rows[0]), columns(&rows[239]));
    assert_eq!(columns(&rows[0]).len(), 13 + 4 * 11);
}

/// G2, for individuals: what the census says is covered is the area of the living colonies, so that cover and what is free sum
/// to 1 while bodies stand side by side, and the counts of a seed are always the same.
#[test]
fn cover_and_free_ground_sum_to_one() {
    let mut plot = bare(quiet(), cool(), 40.0, 1);
    // Far enough from each other for all the months.
    for (species, x) in [(0, 5.0f32), (1, 15.0), (2, 25.0), (3, 35.0)] {
        for y in [10.0, 20.0, 30.0] {
            plot.add_colony(species, x, y, 0.2, 5).unwrap();
        }
    }
    for _ in 0..24 {
        let row = plot.month().unwrap();
        assert_eq!(row.colonies(), 12);
        let area = 40.0 * 40.0;
        let mut of_species = [0.0f64; 4];
        for c in plot.colonies() {
            of_species[usize::from(c.species)] += std::f64::consts::PI * f64::from(c.radius).powi(2);
        }
        for (s, m2) in row.species.iter().zip(of_species) {
            assert!((s.cover - m2 / area).abs() <= 1e-6, "month {}: {} for {m2} m2", row.month, s.cover);
        }
        let free = area - of_species.iter().sum::<f64>();
        assert!((row.coral_cover() + free / area - 1.0).abs() <= 1e-6);
    }
    let counts = |seed: u64| {
        let (_, rows) = run(&Community::default(), Site::flat(20.0, 20.0), seed, 48);
        rows.iter().map(|r| r.species.iter().map(|s| s.colonies).collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    assert_eq!(counts(11), counts(11));
    assert_ne!(counts(11), counts(12));
}

/// A slope from the beach down to 60 m, with sand in its eastern half.
fn slope() -> Ground {
    let depth = Field::from_fn(20, 30, |_, y| y as f32 * 2.2 - 4.0);
    let mut ground = Ground::of_depth(2.0, depth, 0.05, 1.0);
    ground.substrate = Field::from_fn(20, 30, |x, _| if x < 10 { 1.0 } else { 0.0 });
    ground
}

#[test]
fn corals_settle_only_where_depth_light_and_ground_let_them() {
    let c = Community::default();
    let (plot, _) = run(&c, Site::of_ground(slope()), 4, 60);
    assert!(plot.colonies().len() > 100 && plot.algae().len() > 50);
    for colony in plot.colonies() {
        let place = plot.site().at(colony.x, colony.y);
        let species = &plot.community().species[usize::from(colony.species)];
        assert!(place.substrate > 0.0 && place.suits(species) > 0.0, "{colony:?} at {place:?}");
        assert!(place.depth >= species.min_depth && place.depth <= species.max_depth);
    }
    assert!(plot.algae().iter().all(|a| a.x < 20.0 && plot.site().at(a.x, a.y).depth <= 30.0));
    // Least light ends Porites above its deepest place.
    let (mut dim, deep) = (Community::default(), Place { depth: 30.0, light: 0.22, substrate: 1.0 });
    dim.species[0].min_light = 0.3;
    assert_eq!((deep.suits(&dim.species[0]), deep.suits(&dim.species[1])), (0.0, 1.0));
    // Deep colonies grow slower: tanh(e^(-0.05 g) / 0.125).
    let mut plot = Plot::empty(quiet(), Site::of_ground(slope()), cool(), 1, Limits::default()).unwrap();
    for y in [13.0, 41.0] {
        plot.add_colony(0, 5.0, y, 0.1, 5).unwrap();
    }
    plot.month().unwrap();
    for colony in plot.colonies() {
        let depth = plot.site().at(colony.x, colony.y).depth;
        let want = (f64::from(-0.05 * depth).exp() / 0.125).tanh() * 0.0116 / 12.0;
        assert!((f64::from(colony.radius) - 0.1 - want).abs() < 1e-7, "{colony:?}");
    }
    assert!(plot.colonies()[1].radius < plot.colonies()[0].radius - 1e-5);
}

#[test]
fn nobody_leaves_the_plot_except_in_the_original() {
    for compat in [false, true] {
        let c = Community { compat, ..Default::default() };
        let (plot, rows) = run(&c, Site::flat(10.0, 10.0), 3, 60);
        let outside = plot.algae().iter().filter(|a| !plot.site().contains(a.x, a.y)).count();
        assert_eq!(outside > 0, compat);
        assert!(plot.algae().iter().all(|a| a.x > -10.1 && a.x < 20.1 && a.y > -10.1 && a.y < 20.1));
        assert!(rows.iter().all(|r| r.algae_cover < 1.0));
    }
}

/// Three hundred years with a severe one in fifteen: no species is lost, and the reef of the end is as rich as that of the middle.
#[test]
fn a_reef_outlives_centuries() {
    let community = Community::default();
    let forcing = Forcing::chumbe(&community, 5).unwrap();
    let mut plot = Plot::new(community, Site::flat(20.0, 20.0), forcing, 5).unwrap();
    let rows: Vec<Census> = (0..3600).map(|_| plot.month().unwrap()).collect();
    let mean = |months: &[Census]| months.iter().map(Census::coral_cover).sum::<f64>() / months.len() as f64;
    let (middle, end) = (mean(&rows[1200..2400]), mean(&rows[2400..]));
    println!("cover {middle:.3} and {end:.3}");
    assert!(middle > 0.15 && end > 0.15 && (end / middle - 1.0).abs() < 0.3, "{middle} {end}");
    let last = rows.last().unwrap();
    assert!(last.species.iter().all(|s| s.colonies > 5), "{:?}", last.species);
}

#[test]
fn more_hot_years_and_more_storms_leave_fewer_corals() {
    let cover = |c: &Community, severe_every: u32| {
        let mean = |seed: u64| {
            let forcing = Forcing::chumbe_every(c, severe_every, seed).unwrap();
            let mut plot = Plot::new(c.clone(), Site::flat(20.0, 20.0), forcing, seed).unwrap();
            (0..360).map(|_| plot.month().unwrap().coral_cover()).skip(240).sum::<f64>() / 120.0
        };
        (0..4).map(mean).sum::<f64>() / 4.0
    };
    let usual = Community::default();
    let mut stormy = Community::default();
    stormy.large_disturbances.interval = 4.0;
    let (calm, hot, rough) = (cover(&usual, 15), cover(&usual, 4), cover(&stormy, 15));
    assert!(hot < 0.6 * calm && rough < 0.8 * calm, "{calm} {hot} {rough}");
}

#[test]
fn hostile_parameters_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Community)| {
        let mut c = Community::default();
        change(&mut c);
        let made = Plot::empty(c, Site::flat(10.0, 10.0), cool(), 1, Limits::default());
        made.err().map(|e| e.to_string()).unwrap_or_default()
    };
    for (change, part) in [
        (&(|c: &mut Community| c.shade = f32::NAN) as &dyn Fn(&mut Community), "shade"),
        (&|c| c.overgrowth = -1.0, "overgrowth"),
        (&|c| c.species[1].growth = f32::INFINITY, "Porites lutea"),
        (&|c| c.species[2].bleaching_max = 20.0, "bleaching_min"),
        (&|c| c.species[2].recruit_radius = 0.9, "recruit_radius"),
        (&|c| c.species[3].name = "Porites lobata".into(), "is there twice"),
        (&|c| c.species = vec![c.species[0].clone(); 300], "256"),
        (&|c| c.algae.max_radius = 0.01, "max_radius"),
        (&|c| c.turf.cell = 0.0, "cell"),
        (&|c| c.heat.death_weeks = [9.0, 8.0], "death_weeks"),
        (&|c| c.heat.bleaching_weeks = [f32::NAN, 8.0], "bleaching_weeks"),
        (&|c| c.small_disturbances.events = f32::INFINITY, "events"),
        (&|c| c.heat.window = 0, "window"),
        (&|c| c.large_disturbances.min_diameter = 11.0, "large_disturbances.min_diameter"),
        (&|c| c.porosity = 1.0, "porosity"),
    ] {
        let text = refused(change);
        assert!(text.contains(part), "{part}: {text}");
    }
    let site = |width_m: f64, ground: Option<Ground>| {
        let site = Site { width_m, length_m: 10.0, ground };
        Plot::empty(Community::default(), site, cool(), 1, Limits::default())
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    for side in [0.0, -3.0, f64::NAN, f64::INFINITY, 1e9] {
        assert!(site(side, None).contains("width_m"), "{side}");
    }
    let ground = || Ground::of_depth(1.0, Field::new(10, 10, 5.0), 0.1, 1.0);
    assert!(site(20.0, Some(ground())).contains("do not cover"));
    assert!(site(10.0, Some(Ground { cell_m: f64::NAN, ..ground() })).contains("cell_m"));
    assert!(site(10.0, Some(Ground { light: Field::new(9, 10, 1.0), ..ground() })).contains("light"));
    assert!(site(10.0, Some(Ground { substrate: Field::new(10, 10, 2.0), ..ground() })).contains("substrate"));
    assert!(site(10.0, Some(Ground { depth: Field::new(10, 10, f32::NAN), ..ground() })).contains("depth"));
    assert!(Forcing::chumbe_every(&Community::default(), 0, 1).is_err());
    let mut endless = Community::default();
    endless.large_disturbances.events = 10_000.0;
    let made = Plot::empty(endless, Site::flat(4000.0, 4000.0), cool(), 1, Limits::default());
    assert!(made.err().unwrap().to_string().contains("large_disturbances.events"));
    let mut plot = bare(quiet(), cool(), 10.0, 1);
    for (species, x, radius) in
        [(9, 5.0, 0.1), (0, 11.0, 0.1), (0, f32::NAN, 0.1), (0, 5.0, f32::NAN), (0, 5.0, 0.0), (3, 5.0, 0.4)]
    {
        assert!(plot.add_colony(species, x, 5.0, radius, 0).is_err(), "{species} {x} {radius}");
    }
    assert!(plot.add_alga(5.0, 5.0, 1.0).is_err() && plot.set_turf(2.0).is_err());
}

#[test]
fn floods_of_individuals_are_refused_before_memory_is_taken() {
    // 16 km2 full of corals of a millimetre.
    let mut tiny = Community::default();
    for s in &mut tiny.species {
        (s.max_initial_radius, s.recruit_radius) = (0.001, 0.001);
    }
    let made = Plot::new(tiny, Site::flat(4000.0, 4000.0), cool(), 1);
    assert!(made.err().unwrap().to_string().contains("initial_cover"));
    // Larvae without number.
    let mut fertile = Community::default();
    fertile.species[3].retention = 1.0;
    fertile.species[3].propagules = 1e6;
    let mut plot = bare(fertile, cool(), 40.0, 1);
    plot.add_colony(3, 5.0, 5.0, 0.3, 50).unwrap();
    let refused = (0..3).find_map(|_| plot.month().err()).unwrap();
    assert!(refused.to_string().contains("recruitment"), "{refused}");
    // No species at all, and nowhere to live, are fine.
    let bare_rock = Community { species: Vec::new(), ..Default::default() };
    assert!(Plot::new(bare_rock, Site::flat(5.0, 5.0), cool(), 1).unwrap().month().is_ok());
    let land = Ground::of_depth(1.0, Field::new(10, 10, -5.0), 0.1, 1.0);
    let mut plot = Plot::new(Community::default(), Site::of_ground(land), cool(), 1).unwrap();
    assert_eq!((plot.colonies().len(), plot.algae().len()), (0, 0));
    assert_eq!((0..24).map(|_| plot.month().unwrap().colonies()).sum::<u64>(), 0);
}

/// The limit of the run binds first settlers and recruits, and a request to stop is heard in the midst of both.
#[test]
fn settling_keeps_to_limits_and_hears_a_stop() {
    let flat = || Site::flat(40.0, 40.0);
    let none = Control::none();
    let small = none.within(Limits { max_bytes: 1 << 16, ..Limits::default() });
    let made = Plot::under(Community::default(), flat(), cool(), 1, &small);
    assert!(matches!(made.err(), Some(Error::Limit { what, .. }) if what.contains("individuals")));
    let cancel = Cancel::default();
    let control = Control::new(cancel.clone(), &|_, _| {});
    let mut plot = Plot::under(Community::default(), flat(), cool(), 1, &control).unwrap();
    assert_eq!(
        plot.month_under(&control).unwrap(),
        Plot::new(Community::default(), flat(), cool(), 1).unwrap().month().unwrap()
    );
    cancel.raise();
    assert!(matches!(plot.month_under(&control), Err(Error::Cancelled(_))));
    assert!(matches!(Plot::under(Community::default(), flat(), cool(), 1, &control).err(), Some(Error::Cancelled(_))));
    assert!(plot.deposit(1.0, 3.0, &mut Field::new(40, 40, 0.0), &control).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn random_plots_stay_sound(
        seed in any::<u64>(),
        (width, length) in (0.2f64..25.0, 0.2f64..25.0),
        compat in any::<bool>(),
        (growth, overgrowth, fragments) in (0.0f32..1.0, 0.05f32..2.0, 0u32..6),
        (max_radius, retention) in (0.2f32..6.0, 0.0f32..1e-7),
        heat in 28.0f32..32.0,
        cover in 0.0f32..1.0,
    ) {
        let mut c = Community { compat, overgrowth, fragments, breakage: 0.01, fragmentation: 0.01, ..Default::default() };
        for s in &mut c.species {
            (s.growth, s.max_radius, s.retention, s.initial_cover) = (growth, max_radius, retention.max(s.retention), cover);
            s.max_initial_radius = s.max_initial_radius.min(max_radius);
        }
        let forcing = Forcing::constant(Heat { index: heat, ..Default::default() });
        let mut plot = Plot::new(c, Site::flat(width, length), forcing, seed).unwrap();
        for _ in 0..30 {
            let row = plot.month().unwrap();
            prop_assert!(row.coral_cover().is_finite() && row.algae_cover.is_finite() && row.rugosity >= 0.9);
            prop_assert!((0.0..=1.0).contains(&row.turf_cover) && (0.0..=1.0).contains(&row.grazing));
        }
        prop_assert!(plot.colonies().windows(2).all(|w| w[0].id < w[1].id));
        prop_assert_eq!(plot.colonies().len(), plot.rays().len());
        for (c, rays) in plot.colonies().iter().zip(plot.rays()) {
            prop_assert!(rays.iter().all(|&r| r > 0.0 && r <= max_radius));
            prop_assert!((0.0..=1.0).contains(&c.bleaching) && c.calcified_kg >= 0.0 && c.calcified_kg.is_finite());
            prop_assert!(compat || plot.site().contains(c.x, c.y));
        }
        prop_assert!(plot.algae().iter().all(|a| a.radius <= 0.175 && a.height > 0.0));
    }

    #[test]
    fn temperatures_of_any_text_are_read_or_refused(text in "[0-9.,;\\-\n a-z]{0,200}") {
        if let Ok(series) = Temperatures::parse(&text, false) {
            prop_assert!(!series.days.is_empty() && series.days.iter().all(|t| t.is_finite()));
            let _ = Forcing::series(&series, &Community::default());
        }
    }
}
