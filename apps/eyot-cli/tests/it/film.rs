//! `eyot film`, and views by another engine.

use crate::common;

use common::{eyot, said, text};
use std::path::Path;

/// A folder with a run of a small hill in `hill`.
fn hill(folder: &Path) {
    let recipe = "name = \"Hill\"\n[grid]\nsize = 24\ncell = 20.0\n[[step]]\ngenerate = \"cone\"\nheight = 90.0\n";
    std::fs::write(folder.join("hill.toml"), recipe).unwrap();
    said(folder, &["run", "hill.toml", "--quiet"], 0, &[]);
}

const SMALL: [&str; 6] = ["--size", "32x20", "--frames", "3", "--fps", "5"];

#[test]
fn a_film_is_made_and_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    let args: Vec<&str> = ["film", "hill"].into_iter().chain(SMALL).collect();
    let o = eyot(dir.path(), &args).env("PATH", "").output().unwrap();
    let words = text(&o);
    assert!(o.status.success() && words.contains("3 pictures in hill/film"), "{words}");
    assert!(words.contains("ffmpeg is not installed"), "{words}");
    let o = eyot(dir.path(), &args).env("PATH", "").output().unwrap();
    assert!(text(&o).contains("(3 were there)"), "{}", text(&o));
    let other: Vec<&str> = args.iter().copied().chain(["--azimuth", "10"]).collect();
    said(dir.path(), &other, 2, &["another film", "--restart"]);
}

#[cfg(unix)]
#[test]
fn ffmpeg_gets_all_pictures_and_its_video_its_place() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    let bin = dir.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    // Writes what it was asked into the last argument, which is the file to make.
    let script = "#!/bin/sh\nfor last; do :; done\necho \"$@\" >\"$last\"\n";
    std::fs::write(bin.join("ffmpeg"), script).unwrap();
    std::fs::set_permissions(bin.join("ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let args: Vec<&str> = ["film", "hill", "--video", "webm"].into_iter().chain(SMALL).collect();
    let o = eyot(dir.path(), &args).env("PATH", &bin).output().unwrap();
    assert!(text(&o).contains("wrote hill/film/film.webm"), "{}", text(&o));
    let asked = std::fs::read_to_string(dir.path().join("hill/film/film.webm")).unwrap();
    assert!(asked.contains("-framerate 5") && asked.contains("frame_%05d.png") && asked.contains("vp9"), "{asked}");
    // A failure is told, and the pictures stay.
    std::fs::write(bin.join("ffmpeg"), "#!/bin/sh\necho no such codec >&2\nexit 1\n").unwrap();
    let o = eyot(dir.path(), &args).env("PATH", &bin).output().unwrap();
    assert!(o.status.success() && text(&o).contains("ffmpeg made no video: no such codec"), "{}", text(&o));
    // A % in the folder's name is none of ffmpeg's business, and quiet is quiet.
    std::fs::write(bin.join("ffmpeg"), script).unwrap();
    let to: Vec<&str> = args.iter().copied().chain(["--out", "100%03d", "--quiet"]).collect();
    let o = eyot(dir.path(), &to).env("PATH", &bin).output().unwrap();
    assert!(o.status.success() && text(&o).is_empty(), "{}", text(&o));
    let asked = std::fs::read_to_string(dir.path().join("100%03d/film.webm")).unwrap();
    assert!(!asked.contains("100%03d"), "{asked}");
}

#[cfg(unix)]
#[test]
fn a_stop_does_not_wait_for_ffmpeg() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    let bin = dir.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    // Would end by itself long after the test's patience.
    std::fs::write(bin.join("ffmpeg"), "#!/bin/sh\n: >begun\nexec /bin/sleep 600\n").unwrap();
    std::fs::set_permissions(bin.join("ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let args: Vec<&str> = ["film", "hill"].into_iter().chain(SMALL).collect();
    let mut film = eyot(dir.path(), &args).env("PATH", &bin).spawn().unwrap();
    while !dir.path().join("hill/film/begun").exists() {
        assert!(film.try_wait().unwrap().is_none(), "it has not come to ffmpeg");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let pid = film.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(film.wait().unwrap().code(), Some(130));
    assert!(!dir.path().join("hill/film/film.mp4").exists());
}

#[test]
fn a_run_is_filmed_while_it_is_done_again() {
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    // So steep that it slides.
    let recipe = std::fs::read_to_string(dir.path().join("hill.toml")).unwrap().replace("90.0", "900.0");
    let more = "[[step]]\nsimulate = [\"thermal\"]\nsteps = 40\n";
    std::fs::write(dir.path().join("slides.toml"), recipe + more).unwrap();
    said(dir.path(), &["run", "slides.toml", "--out", "slides", "--quiet"], 0, &[]);
    let args: Vec<&str> = ["film", "slides", "--run", "--video", "none"].into_iter().chain(SMALL).collect();
    said(dir.path(), &args, 0, &["3 pictures in slides/film"]);
    let frame = |i: u32| std::fs::read(dir.path().join(format!("slides/film/frame_0000{i}.png"))).unwrap();
    assert!(frame(0) != frame(2), "the land changes");
    // A hill that nothing happens to is no film.
    said(dir.path(), &["film", "hill", "--run"], 2, &["simulates nothing"]);
}

#[test]
fn what_cannot_be_filmed_or_drawn_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    let refused: [(&[&str], &[&str]); 8] = [
        (&["film", "hill", "--path", "way.toml"], &["way.toml", "[[key]]"]),
        (&["film", "hill", "--path", "round"], &["orbit, fly, still or above"]),
        (&["film", "hill", "--drape", "heigth"], &["did you mean --drape height?"]),
        (&["film", "nowhere"], &["nowhere"]),
        (&["render", "hill", "--engine", "gpu", "--adapter", "no such card"], &["no graphics adapter", "no such card"]),
        (&["render", "hill", "--adapter", "no such card"], &["no graphics adapter", "no such card"]),
        (&["render", "hill", "--engine", "cpu", "--adapter", "any"], &["--engine cpu takes no graphics adapter"]),
        (&["render", "hill", "--engine", "gpu", "--relief"], &["drawn by the processor", "--drape"]),
    ];
    for (args, answers) in refused {
        said(dir.path(), args, 2, answers);
    }
    assert!(!dir.path().join("hill/film").exists());
    // A world without land.
    let recipe = std::fs::read_to_string(dir.path().join("hill.toml")).unwrap();
    let flat = recipe.replace("height = 90.0", "height = 90.0\nlayer = \"alive\"");
    std::fs::write(dir.path().join("flat.toml"), flat).unwrap();
    said(dir.path(), &["run", "flat.toml", "--quiet"], 0, &[]);
    for verb in ["render", "film"] {
        said(dir.path(), &[verb, "flat"], 2, &["no layer `height`", "eyot render flat --layer alive"]);
    }
    said(dir.path(), &["render", "flat", "--layer", "alive"], 0, &["wrote"]);
}

#[test]
fn a_graphics_card_draws_the_same_view() {
    let dir = tempfile::tempdir().unwrap();
    hill(dir.path());
    let args = ["render", "hill", "--engine", "gpu", "--size", "64x40"];
    let o = eyot(dir.path(), &args).output().unwrap();
    let words = text(&o);
    if !o.status.success() && words.contains("no graphics adapter") {
        assert!(std::env::var_os("EYOT_REQUIRE_GPU").is_none(), "{words}");
        eprintln!("skipped: {words}");
        return;
    }
    assert!(o.status.success() && words.contains("drawn by gpu ("), "{words}");
    assert!(dir.path().join("hill/render.png").is_file());
    said(dir.path(), &["render", "hill", "--engine", "auto", "--size", "64x40"], 0, &["drawn by"]);
}

/// A planet is filmed as its map, unless a camera or a path is named; then as ever.
#[test]
fn planets_are_filmed_from_above() {
    let dir = tempfile::tempdir().unwrap();
    let recipe = "name = \"Planet\"\n[grid]\nsize = [48, 24]\nextent_m = [4e7, 2e7]\n[view]\nfrom_above = true\n[[step]]\n\
                  generate = \"fbm\"\namplitude = 4000.0\n[[step]]\nsimulate = [\"thermal\"]\nsteps = 4\n";
    std::fs::write(dir.path().join("planet.toml"), recipe).unwrap();
    said(dir.path(), &["run", "planet.toml", "--record", "2", "--quiet"], 0, &[]);
    let size = |out: &str, more: &[&str]| {
        let args: Vec<&str> = ["film", "planet", "--size", "64x40", "--frames", "2", "--video", "none", "--out", out]
            .into_iter()
            .chain(more.iter().copied())
            .collect();
        said(dir.path(), &args, 0, &["2 pictures"]);
        // Width and height stand at the beginning of every PNG.
        let png = std::fs::read(dir.path().join(out).join("frame_00001.png")).unwrap();
        [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()))
    };
    assert_eq!(size("still", &[]), [64, 32]);
    assert_eq!(size("run", &["--run"]), [64, 32]);
    assert_eq!(size("recording", &["--recording"]), [64, 32]);
    assert_eq!(size("light", &["--sun-azimuth", "20"]), [64, 32]);
    assert_eq!(size("path", &["--path", "still"]), [64, 40]);
    assert_eq!(size("camera", &["--run", "--elevation", "40"]), [64, 40]);
    assert!(size("worn", &["--recording", "--drape", "height"])[1] > 40);
}
