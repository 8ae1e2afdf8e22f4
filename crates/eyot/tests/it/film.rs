//! Films: pictures along a path or of a run, each whole or not at all, going on where they stopped.

use crate::common;

use eyot::film::{FilmOptions, FilmPath, FilmProgress, Filmed, Subject, Video, film};
use eyot::view::ViewRequest;
use eyot::{Boundary, Cancel, Control, Field, Grid, Limits, Record, Run, RunError, RunOptions, Timeline, View, World};
use eyot_core::layer::known;
use std::collections::BTreeMap;
use std::path::Path;

fn world() -> World {
    let mut world = World::new(Grid::new(40, 30, 20.0, Boundary::CLOSED, &Limits::default()).unwrap(), 3);
    let cone = |x: usize, y: usize| 120.0 - 11.0 * (x as f32 - 22.0).hypot(y as f32 - 14.0);
    world.put(&known::HEIGHT, Field::from_fn(40, 30, cone)).unwrap();
    world
}

fn options(path: FilmPath) -> FilmOptions {
    let view = View { size: [48, 30], ..View::default() };
    FilmOptions {
        request: ViewRequest { view, ..ViewRequest::default() },
        path,
        frames: Some(6),
        fps: 25.0,
        video: Video::None,
        restart: false,
    }
}

fn make(o: &FilmOptions, out: &Path, told: &mut dyn FnMut(&FilmProgress)) -> Result<Filmed, RunError> {
    film(
        Subject::World(&world()),
        o,
        out,
        &eyot::host(&eyot::Registry::standard()),
        &Limits::default(),
        &Control::none(),
        told,
    )
}

/// The pictures in a folder.
fn frames(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(out).unwrap().map(|e| e.unwrap().path());
    let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
    files
        .filter(|p| p.extension().is_some_and(|e| e == "png"))
        .map(|p| (name(&p), std::fs::read(&p).unwrap()))
        .collect()
}

#[test]
fn an_orbit_goes_round_picture_by_picture() {
    let dir = tempfile::tempdir().unwrap();
    let (o, out) = (options(FilmPath::Orbit), dir.path().join("film"));
    let mut told = Vec::new();
    let filmed = make(&o, &out, &mut |p| told.push((p.done, p.seconds_left.is_some()))).unwrap();
    assert_eq!((filmed.drawn, filmed.frames, filmed.video), (6, 6, None));
    assert_eq!(told.first(), Some(&(0, false)));
    assert_eq!(told.last(), Some(&(6, true)));
    assert!(told[1].1, "after a picture there is a time left");
    let frames = frames(&out);
    assert_eq!(frames.len(), 6);
    let distinct: std::collections::BTreeSet<_> = frames.values().collect();
    assert_eq!(distinct.len(), 6, "every picture is another one");
}

#[test]
fn a_film_that_stands_still_begins_with_the_usual_view() {
    let dir = tempfile::tempdir().unwrap();
    let (o, out) = (options(FilmPath::Still), dir.path().join("film"));
    make(&o, &out, &mut |_| ()).unwrap();
    let still = dir.path().join("still.png");
    eyot::view::draw_view(&world(), &o.request, &still, &Limits::default()).unwrap();
    assert_eq!(std::fs::read(still).unwrap(), frames(&out)["frame_00000.png"]);
}

#[test]
fn a_film_that_was_stopped_goes_on_to_the_same_pictures() {
    let dir = tempfile::tempdir().unwrap();
    let (o, whole, parts) = (options(FilmPath::Fly), dir.path().join("whole"), dir.path().join("parts"));
    make(&o, &whole, &mut |_| {}).unwrap();
    let cancel = Cancel::default();
    let control = Control::new(cancel.clone(), &|_, _| {});
    let stop_after_two = &mut |p: &FilmProgress| {
        if p.done == 2 {
            cancel.raise();
        }
    };
    let stopped = film(
        Subject::World(&world()),
        &o,
        &parts,
        &eyot::host(&eyot::Registry::standard()),
        &Limits::default(),
        &control,
        stop_after_two,
    );
    assert!(matches!(stopped, Err(RunError::Stopped)));
    assert_eq!(frames(&parts).len(), 2);
    let filmed = make(&o, &parts, &mut |_| {}).unwrap();
    assert_eq!((filmed.drawn, filmed.frames), (4, 6));
    assert_eq!(frames(&whole), frames(&parts));
    // A picture that was removed is drawn again, and only that one.
    std::fs::remove_file(parts.join("frame_00003.png")).unwrap();
    assert_eq!(make(&o, &parts, &mut |_| {}).unwrap().drawn, 1);
    assert_eq!(frames(&whole), frames(&parts));
    // So is one that something else has cut short or written over.
    let picture = std::fs::read(parts.join("frame_00001.png")).unwrap();
    for broken in [&picture[..picture.len() - 5], b"broken"] {
        std::fs::write(parts.join("frame_00001.png"), broken).unwrap();
        assert_eq!(make(&o, &parts, &mut |_| {}).unwrap().drawn, 1);
    }
    assert_eq!(frames(&whole), frames(&parts));
}

#[test]
fn another_film_in_the_folder_is_kept_unless_it_may_go() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path();
    std::fs::write(out.join("frame_of_mine.png"), "mine").unwrap();
    let mut o = options(FilmPath::Orbit);
    make(&o, out, &mut |_| {}).unwrap();
    o.frames = Some(3);
    let e = make(&o, out, &mut |_| {}).unwrap_err();
    assert!(e.is_refusal() && e.to_string().contains("`restart`"), "{e}");
    assert_eq!(frames(out).len(), 7);
    o.restart = true;
    make(&o, out, &mut |_| {}).unwrap();
    assert_eq!(frames(out).keys().filter(|n| n.starts_with("frame_0")).count(), 3);
    assert_eq!(std::fs::read(out.join("frame_of_mine.png")).unwrap(), b"mine");
}

#[test]
fn key_frames_say_how_long_it_takes() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("way.toml");
    std::fs::write(&file, "[[key]]\ntime = 1\nazimuth = 90\n[[key]]\ntime = 1.4\nazimuth = 120\ndistance = 0.8\n")
        .unwrap();
    let mut o = FilmOptions { frames: None, fps: 10.0, ..options(FilmPath::File(file.clone())) };
    assert_eq!(make(&o, &dir.path().join("timed"), &mut |_| {}).unwrap().frames, 4);
    std::fs::write(&file, "[[key]]\nelevation = 95\n").unwrap();
    let e = make(&o, &dir.path().join("wrong"), &mut |_| {}).unwrap_err();
    assert!(e.is_refusal() && e.to_string().contains("elevation of key 1"), "{e}");
    assert!(!dir.path().join("wrong").exists(), "nothing is begun");
    o.fps = f32::NAN;
    std::fs::write(&file, "[[key]]\n").unwrap();
    assert!(make(&o, dir.path(), &mut |_| {}).unwrap_err().is_refusal());
}

#[test]
fn wrong_scenery_is_refused_before_anything_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("film");
    let mut o = options(FilmPath::Orbit);
    o.request.drape = Some("snow".to_owned());
    assert!(make(&o, &out, &mut |_| {}).unwrap_err().to_string().contains("snow"));
    o.request.drape = None;
    o.request.engine.choice = eyot::EngineChoice::Gpu;
    o.request.engine.adapter = Some("no such card".to_owned());
    let e = make(&o, &out, &mut |_| {}).unwrap_err();
    assert!(e.is_refusal() && e.to_string().contains("no such card"), "{e}");
    assert!(!out.exists());
}

#[test]
fn land_in_the_colours_of_a_layer_has_a_legend() {
    let dir = tempfile::tempdir().unwrap();
    let (plain, worn) = (dir.path().join("plain.png"), dir.path().join("worn.png"));
    let mut request = options(FilmPath::Orbit).request;
    request.view.size = [320, 200];
    eyot::view::draw_view(&world(), &request, &plain, &Limits::default()).unwrap();
    request.drape = Some("height".to_owned());
    eyot::view::draw_view(&world(), &request, &worn, &Limits::default()).unwrap();
    let size = |p: &Path| {
        let reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(p).unwrap())).read_info().unwrap();
        (reader.info().width, reader.info().height)
    };
    assert_eq!(size(&plain), (320, 200));
    assert!(size(&worn).0 == 320 && size(&worn).1 > 200, "{:?}", size(&worn));
}

const SLIDES: &str = r#"
name = "Slides"
[grid]
size = [24, 20]
cell = 20.0
[[step]]
generate = "cone"
height = 150.0
[[step]]
simulate = ["thermal"]
steps = 30
[[step]]
generate = "fbm"
amount = 0.1
[[step]]
simulate = ["hydraulic", "thermal"]
steps = 10
"#;

#[test]
fn the_film_of_a_run_ends_with_its_world_and_goes_on_after_a_stop() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    let world = common::run(common::recipe(SLIDES, &[]), &run);
    // Water comes with the second simulation; before it there is none.
    let mut o = FilmOptions { frames: Some(5), ..options(FilmPath::Still) };
    o.request.drape = Some("water".to_owned());
    let (whole, parts) = (dir.path().join("whole"), dir.path().join("parts"));
    let make = |out: &Path, control: &Control<'_>, told: &mut dyn FnMut(&FilmProgress)| {
        film(Subject::Run(&run), &o, out, &eyot::host(&eyot::Registry::standard()), &Limits::default(), control, told)
    };
    assert_eq!(make(&whole, &Control::none(), &mut |_| {}).unwrap().drawn, 5);
    let pictures = frames(&whole);
    assert!(pictures["frame_00000.png"] != pictures["frame_00004.png"], "the land changes");
    let last = dir.path().join("last.png");
    eyot::view::draw_view(&world, &o.request, &last, &Limits::default()).unwrap();
    assert_eq!(std::fs::read(&last).unwrap(), pictures["frame_00004.png"]);

    let cancel = Cancel::default();
    let control = Control::new(cancel.clone(), &|_, _| {});
    let stopped = make(&parts, &control, &mut |p| {
        if p.done == 2 {
            cancel.raise();
        }
    });
    assert!(matches!(stopped, Err(RunError::Stopped)));
    assert_eq!(make(&parts, &Control::none(), &mut |_| {}).unwrap().drawn, 3);
    assert_eq!(frames(&parts), pictures);
}

/// A picture for each frame, which shows what the frame holds; more pictures hold frames for longer, under a camera that moves.
#[test]
fn the_film_of_a_recording_shows_its_frames() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    let record = Some(Record { every: 8, max_bytes: 1 << 30 });
    let options_of_run = RunOptions { out: Some(run.clone()), record, ..RunOptions::default() };
    Run::start(common::recipe(SLIDES, &[]), options_of_run).unwrap().join().unwrap();
    let timeline = Timeline::open(&run, &Limits::default()).unwrap();
    let steps: Vec<u64> = timeline.frames().iter().map(|f| f.steps_done).collect();
    assert_eq!(steps, [0, 8, 16, 24, 30, 32, 40]);
    let play = |o: &FilmOptions, out: &str| {
        let out = dir.path().join(out);
        let filmed = film(
            Subject::Recording(&run),
            o,
            &out,
            &eyot::host(&eyot::Registry::standard()),
            &Limits::default(),
            &Control::none(),
            &mut |_| {},
        )
        .unwrap();
        (filmed.frames, frames(&out))
    };
    let o = FilmOptions { frames: None, ..options(FilmPath::Still) };
    let (count, pictures) = play(&o, "whole");
    // Steps 0, 8, 16, 24, 32, 40: the frame of step 30 is none of every eighth.
    assert_eq!((count, pictures.len()), (6, 6));
    let distinct: std::collections::BTreeSet<_> = pictures.values().collect();
    assert_eq!(distinct.len(), 6, "the land changes");
    let last = dir.path().join("last.png");
    eyot::view::draw_view(&timeline.load(6, &eyot::component_kinds()).unwrap(), &o.request, &last, &Limits::default())
        .unwrap();
    assert_eq!(std::fs::read(&last).unwrap(), pictures["frame_00005.png"]);
    let (count, slow) = play(&FilmOptions { frames: Some(11), ..o.clone() }, "slow");
    assert_eq!(count, 11);
    assert_eq!(slow["frame_00001.png"], slow["frame_00000.png"]);
    assert_eq!(slow["frame_00010.png"], pictures["frame_00005.png"]);
    let (_, moving) = play(&FilmOptions { frames: Some(11), ..options(FilmPath::Orbit) }, "moving");
    assert_ne!(moving["frame_00001.png"], moving["frame_00000.png"]);
    // What is lost is told, and the frame before it stays.
    std::fs::remove_file(run.join("timeline.zarr/.frames/1.eyot")).unwrap();
    std::fs::write(run.join("timeline.zarr/height/c/3/0/0"), "damaged").unwrap();
    std::fs::write(run.join("timeline.zarr/height/c/6/0/0"), "damaged").unwrap();
    let out = dir.path().join("gaps");
    let none = (&Limits::default(), Control::none());
    let filmed = film(
        Subject::Recording(&run),
        &o,
        &out,
        &eyot::host(&eyot::Registry::standard()),
        none.0,
        &none.1,
        &mut |_| {},
    )
    .unwrap();
    assert_eq!(filmed.notes.len(), 3, "{:?}", filmed.notes);
    for (note, frame) in filmed.notes.iter().zip(["frame 1 of step 8", "frame 3 of step 24", "frame 6 of step 40"]) {
        assert!(note.to_string().contains(frame) && note.to_string().contains("timeline.zarr"), "{note}");
    }
    let gaps = frames(&out);
    assert_eq!(gaps.len(), 5, "the last frame that can be read is of step 32");
    let last = dir.path().join("last-whole.png");
    eyot::view::draw_view(&timeline.load(5, &eyot::component_kinds()).unwrap(), &o.request, &last, &Limits::default())
        .unwrap();
    assert_eq!(std::fs::read(&last).unwrap(), gaps["frame_00004.png"]);
    assert_eq!(gaps["frame_00001.png"], gaps["frame_00000.png"]);
    assert_eq!(gaps["frame_00003.png"], gaps["frame_00002.png"]);
    // Without a recording there is nothing to play.
    let e = film(
        Subject::Recording(dir.path()),
        &o,
        &dir.path().join("none"),
        &eyot::host(&eyot::Registry::standard()),
        &Limits::default(),
        &Control::none(),
        &mut |_| {},
    );
    assert!(e.unwrap_err().is_refusal() && !dir.path().join("none").exists());
}

#[test]
fn a_film_of_what_is_no_run_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let (o, out) = (options(FilmPath::Still), dir.path().join("film"));
    let refused = |run: &Path| {
        let e = film(
            Subject::Run(run),
            &o,
            &out,
            &eyot::host(&eyot::Registry::standard()),
            &Limits::default(),
            &Control::none(),
            &mut |_| {},
        )
        .unwrap_err();
        assert!(e.is_refusal() && !out.exists(), "{e}");
        e.to_string()
    };
    assert!(refused(&dir.path().join("nowhere")).contains("nowhere"));
    let hill = dir.path().join("hill");
    let cone = SLIDES.split("[[step]]").take(2).collect::<Vec<_>>().join("[[step]]");
    common::run(common::recipe(&cone, &[]), &hill);
    assert!(refused(&hill).contains("simulates nothing"));
}

#[test]
fn dry_land_is_dry_from_the_first_picture_on() {
    let dir = tempfile::tempdir().unwrap();
    let dry = "[[step]]\ngenerate = \"constant\"\nlayer = \"aridity\"\nvalue = 1.0\n";
    let (wet, desert) = (dir.path().join("wet"), dir.path().join("desert"));
    common::run(common::recipe(SLIDES, &[]), &wet);
    common::run(common::recipe(&format!("{SLIDES}{dry}"), &[]), &desert);
    let o = FilmOptions { frames: Some(2), ..options(FilmPath::Still) };
    let first = |run: &Path| {
        film(
            Subject::Run(run),
            &o,
            &run.join("film"),
            &eyot::host(&eyot::Registry::standard()),
            &Limits::default(),
            &Control::none(),
            &mut |_| {},
        )
        .unwrap();
        frames(&run.join("film"))["frame_00000.png"].clone()
    };
    assert!(first(&wet) != first(&desert));
}

const PLANET: &str = r#"
name = "Planet"
[grid]
size = [48, 24]
extent_m = [4e7, 2e7]
rim = ["wrap", "closed"]
[view]
from_above = true
[[step]]
generate = "fbm"
amplitude = 4000.0
[[step]]
simulate = ["thermal"]
steps = 6
[[step]]
generate = "fbm"
merge = "add"
amplitude = 2000.0
"#;

/// Each picture is the relief of its world, in the map's shape and not in that of the size.
#[test]
fn a_film_from_above_is_of_reliefs() {
    let dir = tempfile::tempdir().unwrap();
    let run = dir.path().join("run");
    let options_of_run = RunOptions {
        out: Some(run.clone()),
        record: Some(Record { every: 2, max_bytes: 1 << 30 }),
        ..RunOptions::default()
    };
    let world = Run::start(common::recipe(PLANET, &[]), options_of_run).unwrap().join().unwrap().world;
    let mut o = FilmOptions { frames: Some(2), ..options(FilmPath::Above) };
    o.request.view.size = [96, 60];
    // Maps are the processor's, whoever is asked.
    o.request.engine.choice = eyot::EngineChoice::Gpu;
    let relief = dir.path().join("relief.png");
    let subject = eyot::store::Subject::ReliefAt(96);
    eyot::store::draw(&world, &o.request.view, subject, &relief, &Limits::default()).unwrap();
    let relief = std::fs::read(relief).unwrap();
    for (name, subject) in
        [("still", Subject::World(&world)), ("run", Subject::Run(&run)), ("recording", Subject::Recording(&run))]
    {
        let out = dir.path().join(name);
        let filmed = film(
            subject,
            &o,
            &out,
            &eyot::host(&eyot::Registry::standard()),
            &Limits::default(),
            &Control::none(),
            &mut |_| {},
        )
        .unwrap();
        assert!(filmed.notes.iter().any(|n| n.to_string().contains("96 x 48 pixels")), "{:?}", filmed.notes);
        assert!(filmed.notes.iter().any(|n| n.to_string().contains("by the processor")), "{:?}", filmed.notes);
        let pictures = frames(&out);
        assert!(pictures["frame_00001.png"] == relief, "{name}: the last picture is no relief of the world");
        assert_eq!(pictures["frame_00000.png"] == relief, name == "still", "{name}");
    }
    o.request.drape = Some("height".to_owned());
    assert!(make(&o, &dir.path().join("worn"), &mut |_| {}).unwrap_err().is_refusal());
}

/// The recipe of a run says how it is seen, in its file or by `--set`.
#[test]
fn a_run_knows_whether_it_is_seen_from_above() {
    let dir = tempfile::tempdir().unwrap();
    let seen = |name: &str, set: &[&str]| {
        let out = dir.path().join(name);
        let overrides =
            eyot::Overrides { set: set.iter().map(|s| (*s).to_owned()).collect(), ..eyot::Overrides::default() };
        let recipe = common::parse(PLANET, &[], overrides, &Limits::default()).unwrap();
        let record = Some(Record { every: 2, max_bytes: 1 << 30 });
        let options = RunOptions { out: Some(out.clone()), record, ..RunOptions::default() };
        Run::start(recipe, options).unwrap().join().unwrap();
        let recorded = Timeline::open(&out, &Limits::default()).unwrap().view().unwrap();
        assert_eq!(eyot::store::open(&out, &Limits::default()).unwrap().view, recorded);
        recorded
    };
    assert!(seen("map", &[]).from_above);
    assert!(!seen("view", &["view.from_above=false"]).from_above);
}
