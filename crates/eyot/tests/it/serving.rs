//! Runs that are served: clients know what the run knows, and cannot hold it up.

use eyot::live::{Body, Client, Control, Ending, Gone, Options, Order, Permission, Scene, Status};
use eyot::live::{ServeOptions, Serving};
use eyot::{Command, Event, Limits, Overrides, RECIPES, Recipe, RecipeSource, Registry, Run, RunOptions, World, host};
use eyot_reef::corals::Corals;
use std::time::Duration;

/// No test waits for this long; it only ends those that would wait for ever.
const LONG: Duration = Duration::from_secs(120);

fn recipe(text: &str, set: &[String], size: Option<u32>) -> Recipe {
    let source = RecipeSource { name: "test.toml".into(), text: text.into(), folder: ".".into() };
    let overrides = Overrides { set: set.to_vec(), size: size.map(|s| (s, None)), ..Overrides::default() };
    Recipe::parse(source, overrides, &Registry::standard(), &Limits::default()).unwrap()
}

/// Four metres and so many months.
fn reef(months: u64) -> Recipe {
    let text = RECIPES.iter().find(|r| r.name == "reef").unwrap().text;
    recipe(text, &[format!("colonies.steps={months}"), "grid.size=32".into()], None)
}

fn island() -> Recipe {
    let text = "name = \"Rain\"\n[grid]\nsize = [48, 32]\ncell = 20.0\n[[step]]\ngenerate = \"cone\"\nheight = 200.0\n\
                [[step]]\nsimulate = [\"hydraulic\"]\nsteps = 50\n[view]\nenabled = false\n";
    recipe(text, &[], None)
}

fn layers(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

fn client(serving: &Serving) -> Client {
    let client = Client::connect(serving.address()).unwrap();
    client.set_patience(Some(LONG)).unwrap();
    client
}

/// Follows to the close, and returns it.
fn to_the_close(client: &mut Client) -> (u16, String) {
    loop {
        match client.follow() {
            Ok(_) => {}
            Err(Gone::Closed(code, reason)) => return (code, reason),
            Err(e) => panic!("{e}"),
        }
    }
}

/// What a client ought to know of a world, from the world itself.
fn assert_shows(scene: &Scene, world: &World, names: &[&str]) {
    for (layer, name) in scene.layers.iter().zip(names) {
        let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&layer.as_ref().unwrap().values), bits(&world.get(name).unwrap().to_vec()), "{name}");
    }
    assert_eq!((scene.layers.len(), scene.moment.steps_done), (names.len(), world.step));
}

fn assert_shows_reef(scene: &Scene, world: &World) {
    let corals = Corals::default();
    let plot = corals.plot(world).unwrap();
    let mut living: Vec<_> = plot.colonies().iter().zip(plot.rays()).collect();
    living.sort_by_key(|(c, _)| c.id);
    assert!(living.len() > 5, "{} colonies", living.len());
    assert_eq!(scene.colonies.len(), living.len());
    for (seen, (c, rays)) in scene.colonies.iter().zip(living) {
        assert_eq!((seen.id, u8::try_from(seen.species).unwrap(), seen.bleached), (c.id, c.species, c.bleaching > 0.0));
        assert_eq!((seen.x, seen.y, seen.radius, seen.bleaching), (c.x, c.y, c.radius, c.bleaching));
        assert_eq!((seen.rays, i64::from(seen.settled)), (*rays, world.step as i64 - i64::from(c.age)));
        assert!(seen.height > 0.0 && seen.reach >= 0.999 * seen.radius);
    }
    let mut algae = plot.algae().to_vec();
    algae.sort_by_key(|a| a.id);
    let key = |a: &eyot_reef::community::Alga| (a.id, a.x, a.y, a.radius, a.height);
    let seen: Vec<_> = scene.algae.iter().map(|a| (a.id, a.x, a.y, a.radius, a.height)).collect();
    assert_eq!(seen, algae.iter().map(key).collect::<Vec<_>>());
    let census = corals.census(world).unwrap();
    assert_eq!(scene.moment.census, census.row(census.len() - 1).collect::<Vec<f64>>());
}

/// One from the beginning, one that comes in the middle, one after the end: all of them end with the world itself.
#[test]
fn clients_end_with_the_world_of_the_run() {
    let names = ["height", "coral_cover"];
    let options = ServeOptions { layers: layers(&names), wait: 1, ..ServeOptions::default() };
    let serving = Serving::start(reef(36), RunOptions::default(), options, &host(&Registry::standard())).unwrap();
    let mut first = client(&serving);
    while first.mirror().moment().is_none_or(|m| m.step[0] < 12) {
        first.follow().unwrap();
    }
    let mut second = client(&serving);
    while !serving.events().recv_timeout(LONG).unwrap().is_last() {}
    let mut third = client(&serving);
    while third.mirror().end().is_none() || third.mirror().moment().is_none() {
        third.follow().unwrap();
    }
    let closing = std::thread::spawn(move || serving.join(LONG).unwrap());
    for c in [&mut first, &mut second, &mut third] {
        assert_eq!(to_the_close(c), (1000, "the run is done".to_owned()));
    }
    let outcome = closing.join().unwrap();
    assert!(outcome.finished);
    // A floor, then a moment for each month.
    assert_eq!((first.mirror().moment().unwrap().number, first.mirror().snapshots()), (36, 1));
    for c in [&first, &second, &third] {
        let scene = c.mirror().scene().unwrap();
        assert_shows(&scene, &outcome.world, &names);
        assert_shows_reef(&scene, &outcome.world);
        assert_eq!(c.mirror().end().unwrap().0, Ending::Done);
        assert_eq!((scene.moment.recipe_step, scene.moment.step), (2, [36, 36]));
        assert!((20.0..35.0).contains(&scene.moment.temperature_c));
    }
    let hello = first.mirror().hello().unwrap();
    assert_eq!(hello.species.iter().map(|s| s.form).collect::<Vec<_>>(), [0, 0, 1, 1]);
    assert!(hello.rays && hello.columns.contains(&"coral_cover".to_owned()));
    // Nobody's looking changes the run.
    let alone = Run::start(reef(36), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(alone.fingerprint, outcome.fingerprint);
}

#[test]
fn layers_of_any_world_are_sent_every_so_many_steps() {
    let names = ["height", "water"];
    let options = ServeOptions { layers: layers(&names), every: 20, wait: 1, ..ServeOptions::default() };
    let serving = Serving::start(island(), RunOptions::default(), options, &host(&Registry::standard())).unwrap();
    let mut c = client(&serving);
    let mut steps = Vec::new();
    let closing = std::thread::spawn(move || {
        while !serving.events().recv_timeout(LONG).unwrap().is_last() {}
        serving.join(LONG).unwrap()
    });
    while let Ok(seen) = c.follow() {
        let moment = c.mirror().moment();
        steps.extend(seen.and(moment).map(|m| (m.recipe_step, m.step[0])));
    }
    let outcome = closing.join().unwrap();
    assert_eq!(steps, [(1, 1), (2, 20), (2, 40), (2, 50)]);
    assert_shows(&c.mirror().scene().unwrap(), &outcome.world, &names);
    assert!(c.mirror().hello().unwrap().species.is_empty() && c.mirror().scene().unwrap().colonies.is_empty());
}

/// A client pauses the run, does five steps, and lets it go on; nobody else can. One that reads nothing is there all the time.
#[test]
fn clients_pause_and_step_and_resume() {
    let server = Options { control: Control::Token("open-sesame".into()), ..Options::default() };
    let options = ServeOptions { wait: 2, server, ..ServeOptions::default() };
    let serving =
        Serving::start(reef(1_000_000), RunOptions::default(), options, &host(&Registry::standard())).unwrap();
    let deaf = client(&serving);
    let client = |_: &Serving| {
        let client = Client::connect_with(serving.address(), "open-sesame").unwrap();
        client.set_patience(Some(LONG)).unwrap();
        client
    };
    let mut c = client(&serving);
    c.order(Order::Pause).unwrap();
    while c.mirror().status() != Status::Paused {
        c.follow().unwrap();
    }
    // It may wait before anything was made; the sea floor is a step as well.
    let here = c.mirror().moment().map_or(0, |m| m.steps_done);
    c.order(Order::Step(5)).unwrap();
    while c.mirror().moment().is_none_or(|m| m.steps_done < here + 4) {
        c.follow().unwrap();
    }
    // Whoever joins sees where it waits.
    let mut other = client(&serving);
    let waits = |c: &Client| c.mirror().status() == Status::Paused;
    while other.mirror().moment().is_none_or(|m| m.steps_done < here + 4) || !waits(&other) {
        other.follow().unwrap();
    }
    let there = other.mirror().moment().unwrap().steps_done;
    assert!((here + 4..=here + 5).contains(&there), "{here} to {there}");
    other.order(Order::Resume).unwrap();
    while other.mirror().refused().is_none() {
        other.follow().unwrap();
    }
    assert!(other.mirror().refused().unwrap().contains("holds the run"), "{:?}", other.mirror().refused());
    assert!(waits(&other));
    c.order(Order::Resume).unwrap();
    while c.mirror().moment().is_none_or(|m| m.steps_done < there + 10) {
        c.follow().unwrap();
    }
    serving.remote().send(Command::Stop);
    drop((c, other, deaf));
    assert!(!serving.join(LONG).unwrap().finished);
}

/// A stop leaves a checkpoint, clients hear of it and have seen what it holds; the rest is served from there.
#[test]
fn a_stopped_run_goes_on_with_its_clients() {
    let folder = tempfile::tempdir().unwrap();
    let run = || RunOptions { out: Some(folder.path().into()), ..RunOptions::default() };
    let options = || ServeOptions { layers: layers(&["height"]), wait: 1, ..ServeOptions::default() };
    let slow = ServeOptions { rate: Some(3.0), ..options() };
    let serving = Serving::start(reef(30), run(), slow, &host(&Registry::standard())).unwrap();
    let mut c = client(&serving);
    while c.mirror().moment().is_none_or(|m| m.step[0] < 5) {
        c.follow().unwrap();
    }
    serving.remote().send(Command::Stop);
    let closing = std::thread::spawn(move || serving.join(LONG).unwrap());
    assert_eq!(to_the_close(&mut c), (1001, "the run was stopped".to_owned()));
    assert_eq!(c.mirror().end().unwrap().0, Ending::Stopped);
    let stopped = closing.join().unwrap();
    assert!(!stopped.finished && folder.path().join("checkpoint.eyot").exists());
    assert_shows(&c.mirror().scene().unwrap(), &stopped.world, &["height"]);
    assert_shows_reef(&c.mirror().scene().unwrap(), &stopped.world);

    let serving = Serving::resume(folder.path(), run(), options(), &host(&Registry::standard())).unwrap();
    let mut c = client(&serving);
    while c.mirror().moment().is_none() {
        c.follow().unwrap();
    }
    assert!(c.mirror().moment().unwrap().steps_done >= stopped.world.step);
    let closing = std::thread::spawn(move || serving.join(LONG).unwrap());
    assert_eq!(to_the_close(&mut c).0, 1000);
    let outcome = closing.join().unwrap();
    assert_shows_reef(&c.mirror().scene().unwrap(), &outcome.world);
    let alone = Run::start(reef(30), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(alone.fingerprint, outcome.fingerprint);
}

#[test]
fn what_cannot_be_served_is_refused_before_anything_begins() {
    let start = |options| {
        Serving::start(island(), RunOptions::default(), options, &host(&Registry::standard())).map(drop).unwrap_err()
    };
    let e = start(ServeOptions { layers: layers(&["height", "snow"]), ..ServeOptions::default() });
    assert!(e.is_refusal() && e.to_string().contains("`snow`; there is: height, water"), "{e}");
    let e = start(ServeOptions { layers: layers(&["height", "height"]), ..ServeOptions::default() });
    assert!(e.is_refusal() && e.to_string().contains("twice"), "{e}");
    let open = Options { listen: "0.0.0.0:0".parse().unwrap(), ..Options::default() };
    let e = start(ServeOptions { server: open, ..ServeOptions::default() });
    assert!(e.is_refusal() && e.help().unwrap().to_string().contains("`public`"), "{e}");
    let small = RunOptions { limits: Limits { max_bytes: 1000, ..Limits::default() }, ..RunOptions::default() };
    let options = ServeOptions { layers: layers(&["height"]), ..ServeOptions::default() };
    let e = Serving::start(island(), small, options, &host(&Registry::standard())).map(drop).unwrap_err();
    assert!(e.help().unwrap().to_string().contains("`max_memory`"), "{e}");
    // The port is free again.
    let serving =
        Serving::start(island(), RunOptions::default(), ServeOptions::default(), &host(&Registry::standard())).unwrap();
    let taken = Options { listen: serving.address(), ..Options::default() };
    let e = start(ServeOptions { server: taken, ..ServeOptions::default() });
    assert!(e.help().unwrap().to_string().contains("the address"), "{e}");
    while !matches!(serving.events().recv_timeout(LONG).unwrap(), Event::Done { .. }) {}
    assert!(serving.join(LONG).unwrap().finished);
}

/// What a client changes stands in the journal and is made again by a replay; what cannot be is refused, and the run goes on.
#[test]
fn clients_with_the_permission_change_the_run_and_its_journal_replays() {
    let run = || RunOptions { paused: true, ..RunOptions::default() };
    let server = Options { control: Control::Everybody, changes: true, ..Options::default() };
    let options = ServeOptions { server, layers: layers(&["height", "water"]), ..ServeOptions::default() };
    let serving = Serving::start(island(), run(), options, &host(&Registry::standard())).unwrap();
    let mut c = client(&serving);
    c.order(Order::Step(11)).unwrap();
    while c.mirror().moment().is_none_or(|m| m.step[0] < 10) {
        c.follow().unwrap();
    }
    assert_eq!(c.mirror().hello().unwrap().may, Permission::Change);
    for (path, value, words) in [
        ("hydraulic.rian", "0.5", "did you mean `rain`?"),
        ("hydraulic.rain", "-1", "rain"),
        ("hydraulic.rain", "1e999", "no JSON"),
        ("hydraulic.rain", "null", "null"),
        ("thermal.talus", "30", "this step simulates `hydraulic`"),
        ("", "3", "say what to change"),
        ("sea_level", "1e9", "the sea would stand at"),
        ("sea_level", "\"low\"", "must be a number"),
        ("layer.snow", "0", "no layer `snow`"),
        ("layer.water", "-2", "takes 0 to 12000 m"),
        ("layer.flux_x", "1", "takes 0 alone"),
        ("layer", "3", "no layer is named"),
    ] {
        c.set(path, value).unwrap();
        let told = loop {
            if let Body::Refused(told) = c.record().unwrap().body {
                break told;
            }
        };
        assert!(told.contains(words), "{path}={value}: {told}");
    }
    let sets = [
        ("hydraulic.rain", "0.002"),
        ("sea_level", "20"),
        ("", r#"{"layer":{"water":0.5},"hydraulic":{"rain":0.001}}"#),
    ];
    for (path, value) in sets {
        c.set(path, value).unwrap();
        let changed = loop {
            match c.record().unwrap().body {
                Body::Changed(changed) => break changed,
                Body::Refused(told) => panic!("{told}"),
                _ => {}
            }
        };
        assert_eq!((changed.recipe_step, changed.step), (2, 10));
    }
    // Who comes now sees what was changed, though the run still waits.
    let mut late = client(&serving);
    // Pictures are made beside the run: the first may still be the one before.
    let sees = |late: &Client| {
        let scene = late.mirror().scene().unwrap();
        let wet = scene.layers[1].as_ref().unwrap().values.iter().all(|v| *v == 0.5);
        wet && (scene.moment.sea_level_m, scene.moment.step[0]) == (20.0, 10)
    };
    while late.follow().unwrap().is_none() || !sees(&late) {}
    c.order(Order::Resume).unwrap();
    let closing = std::thread::spawn(move || serving.join(LONG).unwrap());
    while c.record().is_ok() {}
    assert_eq!(to_the_close(&mut late).0, 1000);
    let outcome = closing.join().unwrap();
    let journal: Vec<_> = outcome.journal.iter().map(|e| (e.step, &*e.set)).collect();
    let both = "layer.water = 0.5\nhydraulic.rain = 0.001";
    assert_eq!(journal[..2], [(10, "hydraulic.rain = 0.002"), (10, "sea_level = 20")]);
    assert!(journal.len() == 3 && (journal[2] == (10, both) || journal[2].1.lines().count() == 2), "{journal:?}");
    assert_eq!(outcome.world.sea_level_m, 20.0);
    assert!(outcome.world.ledger.amount("water.by_hand") > 0.0);
    let replay = outcome.journal.clone();
    for chunk in [None, Some(3)] {
        let again = RunOptions { replay: replay.clone(), chunk, ..RunOptions::default() };
        let again = Run::start(island(), again).unwrap().join().unwrap();
        assert_eq!((again.fingerprint, &again.journal), (outcome.fingerprint, &replay));
        assert_eq!(again.world, outcome.world);
    }
    let untouched = Run::start(island(), RunOptions::default()).unwrap().join().unwrap();
    assert_ne!(untouched.fingerprint, outcome.fingerprint);
}
