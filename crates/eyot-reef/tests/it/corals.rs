//! The process: a reef in a world, month by month.

use eyot_core::component::{Decoder, Encoder, Numbers};
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::Scheduled;
use eyot_core::{Component, ComponentKinds, Control, Field, Grid, LayerSpec, Limits, Rim, World};
use eyot_reef::community::Population;
use eyot_reef::corals::{CENSUS, CORALS, Corals, POPULATION, SEA, Sea};
use serde_json::{Value, json};

/// A slope from 1 to 15 m below the sea, 12 by 10 m.
fn slope() -> World {
    let grid = Grid::new(48, 40, 0.25, Rim::CLOSED, &Limits::default()).unwrap();
    let mut world = World::new(grid, 7);
    world.put(&HEIGHT, Field::from_fn(48, 40, |x, _| -1.0 - 14.0 * x as f32 / 47.0)).unwrap();
    world
}

fn population(world: &World) -> &Population {
    world.components.get(POPULATION).unwrap().unwrap()
}

fn census(world: &World) -> Vec<Vec<f64>> {
    let table = Corals::default().census(world).unwrap();
    (0..table.len()).map(|i| table.row(i).collect()).collect()
}

fn numbers(world: &World, name: &str) -> Vec<f64> {
    world.components.get::<Numbers>(name).unwrap().unwrap().0.clone()
}

fn months(world: &mut World, parameters: Value, steps: u64) {
    let process = (CORALS.make)(parameters).unwrap();
    let processes = [Scheduled { name: "corals", process, every: 1 }];
    let span = eyot_core::process::Span { from: 0, steps };
    CpuEngine::default().simulate(world, &processes, span, &Control::none()).unwrap();
}

#[test]
fn a_reef_goes_on_from_its_population_to_the_same_bits() {
    let (mut whole, mut parts) = (slope(), slope());
    months(&mut whole, json!({}), 30);
    for steps in [1, 12, 17] {
        months(&mut parts, json!({}), steps);
    }
    assert_eq!(population(&whole), population(&parts));
    assert_eq!(whole.components, parts.components);
    assert_eq!(whole.fingerprint(), parts.fingerprint());
    assert!(population(&whole).colonies().len() > 20 && population(&whole).months() == 30);
}

#[test]
fn the_ground_gains_what_the_colonies_build() {
    let mut world = slope();
    let before = world.get("height").unwrap().sum();
    months(&mut world, json!({}), 24);
    let area = 0.25 * 0.25;
    let (gain, booked) = ((world.get("height").unwrap().sum() - before) * area, world.ledger.amount("ground.corals"));
    assert!(booked > 0.01 && (gain - booked).abs() < 1e-9 * booked.abs() + 1e-9, "{gain} {booked}");
    // 4 to 7 mm a year on a full plot, here less: 24 months on 120 m2.
    assert!((0.1..2.5).contains(&booked), "{booked} m3");
    let limestone = world.get("limestone").unwrap().sum() * area;
    assert!((limestone / booked - 1.0).abs() < 1e-3, "{limestone} {booked}");
    let still = {
        let mut world = slope();
        months(&mut world, json!({"build": false}), 24);
        world.get("height").unwrap().sum()
    };
    assert_eq!(still, before);
}

#[test]
fn the_census_has_a_row_for_each_month() {
    let mut world = slope();
    months(
        &mut world,
        json!({"sea": "climate", "monthly_means": [28.0, 28.0, 28.0, 28.0, 27.0, 26.0, 25.0, 25.0, 25.0, 26.0, 27.0, 28.0]}),
        14,
    );
    let columns = Corals::default().census_columns();
    let rows = census(&world);
    assert_eq!((rows.len(), rows[0].len()), (14, columns.len()));
    assert!(rows.iter().enumerate().all(|(i, r)| r[0] == i as f64));
    let cover = world.get("coral_cover").unwrap();
    assert!(cover.iter().all(|c| (0.0..=1.0).contains(&c)) && cover.sum() > 10.0);
    // The cells' cover is that of the census, but for overlaps.
    let mean = cover.sum() / 1920.0;
    let census = rows[13][columns.iter().position(|c| c.name == "coral_cover").unwrap()];
    assert!(mean <= 1.1 * census && mean > 0.6 * census, "{mean} {census}");
}

/// The numbers that worlds kept of a reef before there were components, which are still its share of the fingerprint.
fn former(population: &Population) -> Vec<f64> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes);
    population.encode(&mut encoder);
    encoder.finish().unwrap();
    // Version 2: month, next id and calendars; then individuals whose fields stand in the order of version 1.
    let mut at = 0;
    let mut take = |n: usize| {
        at += n;
        &bytes[at - n..at]
    };
    let mut whole = |n: usize| {
        let mut eight = [0; 8];
        eight[..n].copy_from_slice(take(n));
        u64::from_le_bytes(eight)
    };
    let (month, next_id) = (whole(8), whole(8));
    let calendars = [0; 4].map(|_| f64::from_bits(whole(8)));
    let mut individuals = Vec::new();
    let mut counts = Vec::new();
    for (wholes, singles) in [(&[8, 1, 4][..], 7 + 24), (&[8, 4], 4), (&[], 1)] {
        counts.push(whole(8));
        for _ in 0..counts[counts.len() - 1] {
            individuals.extend(wholes.iter().map(|n| whole(*n) as f64));
            individuals.extend((0..singles).map(|_| f64::from(f32::from_bits(whole(4) as u32))));
        }
    }
    let head = [1.0, month as f64, next_id as f64, counts[0] as f64, counts[1] as f64, counts[2] as f64];
    head.into_iter().chain(calendars).chain(individuals).collect()
}

fn decoded(version: u32, bytes: &[u8], grid: &Grid) -> eyot_core::Result<std::sync::Arc<dyn Component>> {
    let (mut input, limits) = (bytes, Limits::default());
    let mut decoder = Decoder::new(POPULATION, &mut input, bytes.len() as u64, grid, &limits);
    ComponentKinds::core().with(eyot_reef::COMPONENTS).decode("reef.population", version, &mut decoder)
}

#[test]
fn populations_are_read_in_both_versions_and_keep_their_fingerprint() {
    let mut world = slope();
    months(&mut world, json!({}), 12);
    let numbers = former(population(&world));
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let old = decoded(1, &bytes, &world.grid).unwrap();
    assert!(old.equals(population(&world)));
    let print = world.fingerprint();
    world.components.insert(POPULATION, Numbers(numbers));
    assert_eq!(world.fingerprint(), print);
    assert!(Corals::default().plot(&world).err().unwrap().to_string().contains("is a `numbers`"));
    world.components.insert_shared(POPULATION, old);
    // So is the census, which goes on as a table.
    let rows = census(&world);
    world.components.insert(CENSUS, Numbers(rows.concat()));
    assert_eq!((census(&world), world.fingerprint()), (rows, print));
    months(&mut world, json!({}), 1);
    let mut straight = slope();
    months(&mut straight, json!({}), 13);
    assert_eq!(world.components, straight.components);
}

#[test]
fn strangers_numbers_are_refused_by_name() {
    let mut world = slope();
    months(&mut world, json!({}), 2);
    let sound = former(population(&world));
    let corals = Corals::default();
    corals.plot(&world).unwrap();
    type Spoil = fn(&mut Vec<f64>);
    let spoils: [Spoil; 8] = [
        |n| n.truncate(5),
        |n| n.truncate(n.len() - 1),
        |n| n[0] = 2.0,
        |n| n[3] = 1e300,
        |n| n[12] = f64::NAN,
        |n| n[11] = 77.0,
        |n| n[13] = -500.0,
        |n| n[25] = 1e9,
    ];
    for (i, spoil) in spoils.iter().enumerate() {
        let mut numbers = sound.clone();
        spoil(&mut numbers);
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let e = match decoded(1, &bytes, &world.grid) {
            // What only its community and its place can tell.
            Ok(population) => {
                world.components.insert_shared(POPULATION, population);
                corals.plot(&world).err().map(|e| e.to_string()).unwrap_or_default()
            }
            Err(e) => e.to_string(),
        };
        assert!(e.contains("does not belong to this reef") || e.contains("component `corals`"), "{i}: {e}");
    }
}

#[test]
fn parameters_that_cannot_work_are_named() {
    let grid = slope().grid;
    let refused = |corals: Corals, words: &str| {
        let e = corals.check(&grid).unwrap_err().to_string();
        assert!(e.contains(words), "{e}");
    };
    refused(Corals { attenuation: -1.0, ..Corals::default() }, "attenuation");
    refused(Corals { sea: Sea::Measured, ..Corals::default() }, "needs the name of a file");
    let text = |text: &str| text.to_owned();
    let measured = |series: &str| Corals { sea: Sea::Measured, temperatures: text(series), ..Corals::default() };
    refused(measured("2001-01,27\n2001-02,warm"), "temperatures: line 2");
    refused(measured("2001-01;27\n2001-02;30,7"), "write 30.7");
    refused(measured("2001-01,27\n2001-02,30,7"), "`7` is one column too many");
    refused(measured("2001-01\t27\t\n2001-02\t28\t3"), "line 2: `3` is one column too many");
    let mut nameless = Corals::default();
    nameless.community.species[0].name = "a\nb".to_owned();
    refused(nameless, "is no name of a species");
    let mut shapeless = Corals::default();
    shapeless.community.species[2].body.grammar = "nope".to_owned();
    refused(shapeless, "grammar");
    refused(Corals { sea: Sea::Chumbe, ..measured("2001-01,27") }, "add sea = \"measured\"");
    refused(Corals { severe_interval: 0, ..Corals::default() }, "severe_interval");
    let oblong = Grid { cell_y_m: 0.5, ..grid };
    assert!(Corals::default().check(&oblong).unwrap_err().to_string().contains("square"));
    assert!((CORALS.make)(json!({"attenuaton": 1.0})).is_err());
}

/// What the process `climate` leaves: a mean of 27 degrees over the sea, 1.5 more in the northern summer, 30 more on land.
fn with_climate(mut world: World) -> World {
    let land = |x: usize| if x < 8 { 30.0 } else { 0.0 };
    world.layer_mut("height").unwrap().field =
        Field::from_fn(48, 40, |x, _| if x < 8 { 3.0 } else { -1.0 - 0.3 * x as f32 });
    let values: [(&'static str, &dyn Fn(usize) -> f32); 3] = [
        ("temperature_mean", &|x| 27.0 + land(x)),
        ("temperature_cos", &|_| 0.0),
        ("temperature_sin", &|x| 1.5 + land(x)),
    ];
    for (name, value) in values {
        let spec = LayerSpec::new(name, "°C", "a test's", (-600.0, 600.0));
        world.put(&spec, Field::from_fn(48, 40, |x, _| value(x))).unwrap();
    }
    world
}

#[test]
fn the_sea_has_the_climate_of_its_world_as_it_was_when_it_began() {
    let mut world = with_climate(slope());
    let still = json!({"sea": "world", "variability": {"weather": 0.0, "years": 0.0}});
    months(&mut world, still.clone(), 6);
    let means = numbers(&world, SEA);
    // The warmest month is June, whose middle is 87 days after the beginning of spring; land counts for nothing.
    assert!(means.len() == 12 && means.iter().all(|t| (25.4..28.6).contains(t)), "{means:?}");
    let june = 27.0 + 1.5 * (360.0f64 * (166.0 - 79.0) / 365.0).to_radians().sin();
    assert!((means[5] - june).abs() < 1e-5 && means.iter().all(|t| *t <= means[5]), "{means:?}");
    let columns = Corals::default().census_columns();
    let at = columns.iter().position(|c| c.name == "temperature_c").unwrap();
    let row = |world: &World, month: usize| census(world)[month][at];
    assert!((row(&world, 5) - means[5]).abs() < 0.02, "{} {}", row(&world, 5), means[5]);
    // A climate that changes later does not change the sea of a reef that has begun, also after a break.
    let warmer = Field::new(48, 40, 35.0);
    world.layer_mut("temperature_mean").unwrap().field = warmer;
    months(&mut world, still.clone(), 12);
    assert_eq!(numbers(&world, SEA), means);
    assert!((row(&world, 17) - row(&world, 5)).abs() < 0.5);
    world.components.insert(SEA, Numbers(vec![27.0; 3]));
    let corals: Corals = serde_json::from_value(still).unwrap();
    assert!(corals.plot(&world).err().unwrap().to_string().contains("twelve temperatures"));
    // Without a climate there is nothing to take.
    let process = (CORALS.make)(json!({"sea": "world"})).unwrap();
    assert_eq!(process.needs(), ["temperature_mean", "temperature_cos", "temperature_sin"]);
}

#[test]
fn a_measured_sea_is_what_the_table_says() {
    let mut world = slope();
    let series: String = (1..=12).map(|m| format!("2001-{m:02}, {}\n", 20 + m)).collect();
    months(&mut world, json!({"sea": "measured", "temperatures": series}), 14);
    let columns = Corals::default().census_columns();
    let at = columns.iter().position(|c| c.name == "temperature_c").unwrap();
    let means: Vec<f64> = census(&world).iter().map(|r| r[at]).collect();
    let want: Vec<f64> = (0..14).map(|m| 21.0 + f64::from(m % 12)).collect();
    assert!(means.iter().zip(&want).all(|(a, b)| (a - b).abs() < 1e-4), "{means:?}");
}

#[test]
fn what_the_process_says_can_be_shown_is_what_the_world_shows() {
    let mut world = slope();
    months(&mut world, json!({}), 2);
    let mut said = (CORALS.make)(json!({})).unwrap().views();
    said.sort_by_key(|(name, _)| *name);
    let mut shown: Vec<_> = world.components.views().collect();
    shown.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(said.iter().map(|(name, shape)| (*name, *shape)).eq(shown.iter().map(|(name, s)| (name.as_str(), *s))));
}
