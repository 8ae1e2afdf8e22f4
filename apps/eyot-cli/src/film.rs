//! `film`: pictures along a camera's path, or of a run at work.

use crate::args::{Draws, Look, Reading, size};
use crate::progress::{bar, time};
use crate::wording::CommandLine;
use crate::{Failure, inspect, print, report};
use clap::Args;
use eyot::film::{FilmOptions, FilmPath, FilmProgress, Subject, Video};
use eyot::view::ViewRequest;
use eyot::{Cancel, Control, Limits, Registry, RunError, Timeline, View, host};
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Without a terminal a line is enough now and then.
const LINE_TIME: Duration = Duration::from_secs(10);

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot film island                                         once around it: 250 pictures
  eyot film island --path fly --size 1920x1080 --engine gpu
  eyot film island --path way.toml --fps 30 --out my-film
  eyot film island --drape water --frames 60
  eyot film island --run --frames 100                      how it came to be, step by step
  eyot film island --recording --path orbit                its recording, a picture for each frame
  eyot film canyon --recording --drape material   which rock comes to light as the land ages
  eyot film world --run --size 1920x1080                   a planet's history, as a map

A file of key frames:
  closed = false             # true: the last key is the first again
  [[key]]
  time = 0                   # s; without times the keys are evenly spaced
  azimuth = 205              # and elevation, distance, target, target_height, field_of_view
  [[key]]
  time = 5
  azimuth = 300              # what a key leaves out is as in the key before

Runs whose recipe says `from_above` in its view, as those of planets do, are drawn from above as a map, unless a path, a camera or \
--drape asks for a view. The map keeps its shape: it is as large as fits into --size, with even sides, and has no bars beside it. \
The processor draws it, also with --engine gpu.

The same command goes on with a film that was stopped. With ffmpeg installed, a video is made of the pictures.")]
pub(crate) struct Film {
    /// Folder of a run, or a height map
    from: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Folder for the pictures [default: FOLDER/film, or beside the height map]
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Film the run itself: its recipe is carried out again, by the processor, and filmed from the first step to the last
    #[arg(long)]
    run: bool,
    /// Play the recording that `eyot run --record` made
    #[arg(long, conflicts_with = "run")]
    recording: bool,
    /// The way of the camera: orbit, fly, still, or a TOML file of key frames; or above, which draws a map [default: as the recipe's
    /// `from_above` says, above, or orbit; still with --run and --recording]
    #[arg(long, value_name = "PATH", value_parser = way)]
    path: Option<FilmPath>,
    /// Pictures in all [default: 10 seconds, the time of the key frames, or the frames of the recording]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Pictures a second
    #[arg(long, value_name = "F", default_value = "25", allow_negative_numbers = true, value_parser = |s: &str| crate::args::number(s, 1.0, 240.0))]
    fps: f32,
    /// Width x height of the pictures in pixels; a map keeps its shape within them
    #[arg(long, value_name = "WxH", allow_negative_numbers = true, value_parser = size)]
    size: Option<(u32, Option<u32>)>,
    /// Show the land in the colours of this layer, with a legend
    #[arg(long, value_name = "NAME")]
    drape: Option<String>,
    /// The video to make where ffmpeg is installed: mp4, webm or none
    #[arg(long, value_name = "FORMAT", default_value = "mp4", value_parser = video)]
    video: Video,
    /// Replace the film of something else in the folder
    #[arg(long)]
    restart: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    engine: Draws,
    #[command(flatten)]
    look: Look,
}

/// Films a run or a height map.
pub(crate) fn film(args: &Film) -> Result<(), Failure> {
    // A recording can be of a run that has no world yet.
    let opened = if args.recording { None } else { Some(inspect::open(&args.from, &args.reading)?) };
    if let Some(opened) = &opened {
        inspect::has_ground(opened, &args.from)?;
    }
    if let (Some(layer), Some(opened)) = (&args.drape, &opened) {
        inspect::known(opened, &args.from, "drape", layer)?;
    }
    // A recording tells of its recipe itself.
    let own = match &opened {
        Some(opened) => opened.view.clone(),
        None => recorded_view(&args.from, &args.reading.limits())?,
    };
    let path = match (&args.path, own.from_above) {
        (Some(path), _) => path.clone(),
        _ if args.drape.is_some() || args.look.has_camera() => args.way_of_camera(),
        (None, true) => FilmPath::Above,
        _ => args.way_of_camera(),
    };
    let size = match args.size {
        None => own.size,
        Some((w, None)) if path == FilmPath::Above => [w, w],
        Some((w, h)) => [w, h.unwrap_or((w * 5 / 8).max(1))],
    };
    let view = args.look.over(&own, size)?;
    let options = FilmOptions {
        request: ViewRequest { view, drape: args.drape.clone(), engine: args.engine.options()? },
        path,
        frames: args.frames,
        fps: args.fps,
        video: args.video,
        restart: args.restart,
    };
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| if args.from.is_dir() { args.from.join("film") } else { args.from.with_extension("film") });
    let cancel = Cancel::default();
    let stop = cancel.clone();
    let handler = move || {
        if stop.is_raised() {
            std::process::exit(130);
        }
        print::note("stopping after this picture; Ctrl-C again ends at once");
        stop.raise();
    };
    if let Err(e) = ctrlc::set_handler(handler) {
        print::note(&format!("warning: Ctrl-C will end the film in the middle of a picture: {e}"));
    }
    let control = Control::new(cancel, &|_, _| {});
    let mut shown = Shown::new(args.quiet);
    let limits = args.reading.limits();
    let tell: &mut dyn FnMut(&FilmProgress) = &mut |p| shown.show(p);
    // A run reads its world itself.
    let opened = opened.filter(|_| !args.run);
    let subject = match &opened {
        Some(opened) => Subject::World(&opened.world),
        None if args.run => Subject::Run(&args.from),
        None => Subject::Recording(&args.from),
    };
    let filmed = eyot::film::film(subject, &options, &out, &host(&Registry::standard()), &limits, &control, tell);
    shown.end();
    let filmed = match filmed {
        Err(RunError::Stopped) => {
            print::note("stopped; the same command goes on");
            return Err(Failure::Stopped);
        }
        other => other.map_err(|e| report::run(&e))?,
    };
    if args.quiet {
        return Ok(());
    }
    filmed.notes.iter().for_each(|n| print::note(&format!("note: {}", n.worded(&CommandLine))));
    let there = filmed.frames - filmed.drawn;
    let kept = if there > 0 { format!(" ({there} were there)") } else { String::new() };
    print::line(&format!("{} pictures in {}{kept}", filmed.frames, out.display()))?;
    match filmed.video {
        Some(video) => print::line(&format!("wrote {}", video.display())),
        None => Ok(()),
    }
}

impl Film {
    /// The way of a camera about which nothing was said.
    fn way_of_camera(&self) -> FilmPath {
        if self.run || self.recording { FilmPath::Still } else { FilmPath::Orbit }
    }
}

/// The view of a recorded run's recipe.
fn recorded_view(folder: &Path, limits: &Limits) -> Result<View, Failure> {
    let timeline = Timeline::open(folder, limits);
    timeline.and_then(|t| t.view()).map_err(|e| report::run(&e))
}

/// How far the film is, on the terminal.
struct Shown {
    quiet: bool,
    bar: Option<ProgressBar>,
    last_line: Option<Instant>,
}

impl Shown {
    fn new(quiet: bool) -> Self {
        Self { quiet, bar: None, last_line: None }
    }

    fn show(&mut self, p: &FilmProgress) {
        if self.quiet {
            return;
        }
        let left = p.seconds_left.map_or(String::new(), |s| format!(", {} left", time(s)));
        if std::io::stderr().is_terminal() {
            let new = || bar("{prefix} {bar:30.cyan/black} {pos}/{len}{msg}", u64::from(p.frames));
            let bar = self.bar.get_or_insert_with(new);
            bar.set_prefix(p.engine.clone());
            bar.set_position(u64::from(p.done));
            bar.set_message(left);
        } else if self.last_line.is_none_or(|at| at.elapsed() >= LINE_TIME) && p.done < p.frames {
            self.last_line = Some(Instant::now());
            print::note(&format!("  {}: {} of {} pictures{left}", p.engine, p.done, p.frames));
        }
    }

    fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

fn way(text: &str) -> Result<FilmPath, String> {
    match text {
        "orbit" => Ok(FilmPath::Orbit),
        "fly" => Ok(FilmPath::Fly),
        "still" => Ok(FilmPath::Still),
        "above" => Ok(FilmPath::Above),
        file if Path::new(file).extension().is_some_and(|e| e == "toml") => Ok(FilmPath::File(file.into())),
        _ => Err("choose orbit, fly, still or above, or give a .toml file of key frames".to_owned()),
    }
}

fn video(text: &str) -> Result<Video, String> {
    match text {
        "mp4" => Ok(Video::Mp4),
        "webm" => Ok(Video::Webm),
        "none" => Ok(Video::None),
        _ => Err("choose mp4, webm or none".to_owned()),
    }
}
