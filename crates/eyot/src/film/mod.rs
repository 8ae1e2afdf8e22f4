//! Films: pictures along a camera's path, of a run at work or of a recording, and a video of them.
//!
//! A film is a folder of numbered PNG files and a `film.json` that says what they show. Each picture appears whole or not at all, so
//! a film that was stopped goes on with the first one that is missing.

mod map;
mod path_file;
mod reel;
mod rerun;
mod video;

use crate::artist::{ViewRenderer, ViewRequest};
use eyot_core::layer::known::ARIDITY;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Control, Limits, World};
use eyot_export::pictures::view_options;
use eyot_io as io;
use eyot_recipe::View;
use eyot_render::{CameraPath, Picture};
use eyot_session::{Host, RunError, shell_word};
use map::Map;
use reel::{Playing, Reel};
use rerun::{Made, Rerun};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

pub use video::Video;

/// How long a film takes if nothing says so.
const USUAL_SECONDS: f32 = 10.0;

/// What the pictures of a folder show.
const MANIFEST: &str = "film.json";

/// The way of the camera.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilmPath {
    /// Once around the land.
    Orbit,
    /// A flight around and over the land.
    Fly,
    /// The camera stands where the view puts it.
    Still,
    /// No camera: reliefs of the land from above, north up, drawn by the processor. They are as large as the view's size allows in the
    /// map's own shape, with even sides.
    Above,
    /// Key frames from a TOML file.
    File(PathBuf),
}

/// How a film is made.
#[derive(Clone, Debug)]
pub struct FilmOptions {
    /// Camera at the start, sun, size, colours and engine.
    pub request: ViewRequest,
    /// The way of the camera.
    pub path: FilmPath,
    /// Pictures; 1 to [`MOST_FRAMES`]. `None` takes ten seconds, or the time that a file of key frames names; of a recording,
    /// as many as it would have frames if none had been dropped.
    pub frames: Option<u32>,
    /// Pictures a second, 1 to 240.
    pub fps: f32,
    /// Which video is made of the pictures if ffmpeg is there.
    pub video: Video,
    /// Whether a film of something else in the folder may be overwritten.
    pub restart: bool,
}

/// Most pictures of a film.
pub const MOST_FRAMES: u32 = 100_000;

/// How far a film is.
#[derive(Clone, Debug)]
pub struct FilmProgress {
    /// Pictures that are there.
    pub done: u32,
    /// Pictures in all.
    pub frames: u32,
    /// Seconds that the rest will take, once there is something to tell it from.
    pub seconds_left: Option<f64>,
    /// The engine that draws.
    pub engine: String,
}

/// A finished film.
#[derive(Clone, Debug)]
pub struct Filmed {
    /// Pictures that were drawn now; the others were there.
    pub drawn: u32,
    /// Pictures in all.
    pub frames: u32,
    /// The video, if one was made.
    pub video: Option<PathBuf>,
    /// Things to know.
    pub notes: Vec<Remedy>,
}

/// What a film shows.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A world, which stands still.
    World(&'a World),
    /// The finished run in a folder: its recipe is carried out again, by the processor, and the pictures show the land from the
    /// first step of its simulations to the last.
    Run(&'a Path),
    /// The recording in the folder of a run, which may be at work or have ended early: each picture shows the last frame that can be
    /// read and is no later than its moment.
    Recording(&'a Path),
}

/// Films a world, a run or a recording into the folder `out`. Runs are carried out again with registry and engines of the `host`.
///
/// # Errors
/// [`RunError::Input`] if the options or the path's file are wrong, the folder holds another film, or there is no such run or
/// recording; [`RunError::Stopped`] on a request to stop, after which the same call goes on; and as pictures and runs fail.
pub fn film(
    subject: Subject<'_>,
    options: &FilmOptions,
    out: &Path,
    host: &Host,
    limits: &Limits,
    control: &Control<'_>,
    tell: &mut dyn FnMut(&FilmProgress),
) -> Result<Filmed, RunError> {
    let (made, reel);
    let land = match subject {
        Subject::World(world) => Land { world, moves: None },
        Subject::Run(folder) => {
            made = Made::open(folder, host, limits)?;
            Land { world: &made.world, moves: Some(Moves::Run(&made)) }
        }
        Subject::Recording(folder) => {
            reel = Reel::open(folder, host.registry.components(), limits)?;
            Land { world: &reel.last, moves: Some(Moves::Recording(&reel)) }
        }
    };
    shoot(&land, options, out, limits, control, tell)
}

/// What is filmed.
struct Land<'a> {
    /// The world in its last state, which scales all pictures.
    world: &'a World,
    /// Where earlier states come from, if they are to be seen.
    moves: Option<Moves<'a>>,
}

/// Where the states of a world that changes come from.
#[derive(Clone, Copy)]
enum Moves<'a> {
    /// Its run, which is done again.
    Run(&'a Made),
    /// Its recording.
    Recording(&'a Reel),
}

impl Moves<'_> {
    const fn name(self) -> &'static str {
        match self {
            Self::Run(_) => "its run",
            Self::Recording(_) => "its recording",
        }
    }
}

/// The states, one after the other.
enum States<'a> {
    Run(&'a Made, Box<Rerun>),
    Recording(Playing<'a>),
}

impl<'a> States<'a> {
    fn begin(moves: Moves<'a>, limits: &Limits, control: &Control<'_>) -> Result<Self, RunError> {
        Ok(match moves {
            Moves::Run(made) => Self::Run(made, Box::new(made.start(limits, control)?)),
            Moves::Recording(reel) => Self::Recording(reel.play()),
        })
    }

    /// The world that a picture shows, unless it is that of the picture before.
    fn of(&mut self, picture: u32, frames: u32, control: &Control<'_>) -> Result<Option<Arc<World>>, RunError> {
        match self {
            Self::Run(made, rerun) => rerun.world_at(made.moment(picture, frames), control).map(Some),
            Self::Recording(playing) => playing.world_at(picture, frames),
        }
    }

    fn notes(self) -> Vec<Remedy> {
        match self {
            Self::Run(_, mut rerun) => std::mem::take(&mut rerun.notes),
            Self::Recording(playing) => playing.notes(),
        }
    }
}

impl Land<'_> {
    /// An early state with the layers that a picture needs, though later steps make them: as empty ones, but for how dry the land
    /// is. That is its look from the beginning.
    fn whole(&self, early: Arc<World>, drape: Option<&str>) -> Arc<World> {
        let missing = |name: &&str| early.get(name).is_none();
        let look: &str = &ARIDITY.name;
        let names: Vec<&str> = ["height", look].into_iter().chain(drape).filter(missing).collect();
        let layers: Vec<_> = names.iter().filter_map(|n| self.world.layer(n).ok()).collect();
        if layers.is_empty() {
            return early;
        }
        let mut world = Arc::unwrap_or_clone(early);
        for layer in layers {
            let early = world.ensure(&layer.spec, 0.0);
            if layer.spec.name == look {
                early.field = layer.field.clone();
            }
        }
        Arc::new(world)
    }
}

fn shoot(
    land: &Land<'_>,
    options: &FilmOptions,
    out: &Path,
    limits: &Limits,
    control: &Control<'_>,
    tell: &mut dyn FnMut(&FilmProgress),
) -> Result<Filmed, RunError> {
    let keys = match &options.path {
        FilmPath::File(file) => Some(path_file::read(file)?),
        _ => None,
    };
    check(options)?;
    let mut eye = Eye::open(land, options, keys.as_ref(), limits, control)?;
    let seconds = if let (Some(true), Eye::Camera { path, .. }) = (keys.map(|k| k.is_timed()), &eye) {
        path.duration()
    } else {
        USUAL_SECONDS
    };
    let usual = || match land.moves {
        Some(Moves::Recording(reel)) => reel.usual_frames(),
        _ => (seconds * options.fps).round().clamp(1.0, MOST_FRAMES as f32) as u32,
    };
    let frames = options.frames.unwrap_or_else(usual);

    let manifest = manifest(land, options, &eye, frames);
    prepare(out, &manifest, options.restart)?;
    let name = |i: u32| out.join(format!("frame_{i:05}.png"));
    let missing: Vec<u32> = (0..frames).filter(|i| !is_picture(&name(*i))).collect();
    let moves = land.moves.filter(|_| !missing.is_empty());
    let mut states = moves.map(|m| States::begin(m, limits, control)).transpose()?;
    let begun = Instant::now();
    for (drawn, &i) in missing.iter().enumerate() {
        control.check().map_err(|_| RunError::Stopped)?;
        let left = (missing.len() - drawn) as f64;
        let seconds_left = (drawn > 0).then(|| begun.elapsed().as_secs_f64() / drawn as f64 * left);
        tell(&FilmProgress { done: frames - left as u32, frames, seconds_left, engine: eye.name() });
        if let Some(states) = &mut states
            && let Some(world) = states.of(i, frames, control)?
        {
            eye.follow(land.whole(world, options.request.drape.as_deref()), control)?;
        }
        let picture = eye.picture(i, frames, options, land.world, control)?;
        io::write_rgb_png(&name(i), picture.width, picture.height, &picture.pixels).map_err(RunError::file)?;
    }
    tell(&FilmProgress { done: frames, frames, seconds_left: Some(0.0), engine: eye.name() });
    let mut notes = eye.notes();
    notes.extend(states.into_iter().flat_map(States::notes));
    let video = video::make(out, options.video, options.fps, frames, &mut notes, control)?;
    Ok(Filmed { drawn: missing.len() as u32, frames, video, notes })
}

/// What looks at the land.
enum Eye {
    Camera { renderer: ViewRenderer, path: CameraPath },
    Above(Map),
}

impl Eye {
    fn open(
        land: &Land<'_>,
        options: &FilmOptions,
        keys: Option<&path_file::Keys>,
        limits: &Limits,
        control: &Control<'_>,
    ) -> Result<Self, RunError> {
        if options.path == FilmPath::Above {
            return Map::of(land.world, land.moves.is_some(), &options.request, limits).map(Self::Above);
        }
        let renderer = ViewRenderer::new(land.world, &options.request, limits, control)?;
        let view = view_options(&options.request.view);
        let path = match (&options.path, keys) {
            (FilmPath::Fly, _) => CameraPath::fly(renderer.stage(), &view),
            (FilmPath::Still, _) => CameraPath::still(renderer.stage(), &view),
            (_, Some(keys)) => keys.path(renderer.stage().pose(&view)),
            _ => CameraPath::orbit(renderer.stage(), &view),
        };
        Ok(Self::Camera { renderer, path })
    }

    /// The engine at work, for people.
    fn name(&self) -> String {
        match self {
            Self::Camera { renderer, .. } => renderer.name(),
            Self::Above(_) => "cpu".to_owned(),
        }
    }

    /// Takes over a later state of the world.
    fn follow(&mut self, world: Arc<World>, control: &Control<'_>) -> Result<(), RunError> {
        match self {
            Self::Camera { renderer, .. } => renderer.follow(&world, control),
            Self::Above(map) => map.draw(&world, control),
        }
    }

    fn picture(
        &mut self,
        i: u32,
        frames: u32,
        options: &FilmOptions,
        land: &World,
        control: &Control<'_>,
    ) -> Result<Cow<'_, Picture>, RunError> {
        match self {
            Self::Camera { renderer, path } => {
                // A closed path's last picture is the one before its first.
                let last = if path.closed { frames } else { (frames - 1).max(1) };
                let camera = renderer.stage().camera_at(&path.pose(i as f32 / last as f32));
                renderer.draw(&camera, options.request.view.size, i as f32 / options.fps, control).map(Cow::Owned)
            }
            Self::Above(map) => map.picture(land, control).map(Cow::Borrowed),
        }
    }

    fn notes(self) -> Vec<Remedy> {
        match self {
            Self::Camera { renderer, .. } => renderer.notes,
            Self::Above(map) => map.notes,
        }
    }
}

fn check(o: &FilmOptions) -> Result<(), RunError> {
    let refuse = |reason: String, help: Remedy| Err(RunError::refused(reason, help));
    if let Some(n) = o.frames.filter(|n| !(1..=MOST_FRAMES).contains(n)) {
        return refuse(format!("a film of {n} pictures"), remedy!["choose ", Setting::Frames, " from 1 to 100000"]);
    }
    if !(o.fps.is_finite() && (1.0..=240.0).contains(&o.fps)) {
        return refuse(format!("{} pictures a second", o.fps), remedy!["choose ", Setting::Fps, " from 1 to 240"]);
    }
    if o.path == FilmPath::Above && o.request.drape.is_some() {
        return refuse(
            "a film from above shows the land in its own colours".to_owned(),
            remedy!["choose another ", Setting::Path, ", or leave out ", Setting::Drape],
        );
    }
    Ok(())
}

/// Everything that decides the pictures.
fn manifest(land: &Land<'_>, o: &FilmOptions, eye: &Eye, frames: u32) -> Value {
    let path = if let Eye::Camera { path, .. } = eye { Some(path) } else { None };
    let keys: Vec<Value> = path
        .into_iter()
        .flat_map(|p| &p.keys)
        .map(|k| {
            let p = &k.pose;
            json!({
                "time": k.time, "azimuth": p.azimuth_deg, "elevation": p.elevation_deg, "distance": p.distance,
                "target": p.target, "target_height": p.target_height, "field_of_view": p.field_of_view_deg,
            })
        })
        .collect();
    json!({
        "engine_version": eyot_session::VERSION,
        "world": format!("{:016x}", land.world.fingerprint()),
        "shows": land.moves.map_or("the world", Moves::name),
        "engine": eye.name(),
        "frames": frames,
        "fps": o.fps,
        "view": View { from_above: path.is_none(), ..o.request.view.clone() },
        "drape": o.request.drape,
        "closed": path.is_some_and(|p| p.closed),
        "keys": keys,
    })
}

/// Makes the folder ready: for a new film, or for more of the same.
fn prepare(out: &Path, manifest: &Value, restart: bool) -> Result<(), RunError> {
    let fail = |source| RunError::Folder { path: out.to_owned(), source };
    std::fs::create_dir_all(out).map_err(fail)?;
    let file = out.join(MANIFEST);
    let text = format!("{manifest:#}\n");
    let there = std::fs::read_to_string(&file).ok();
    if there.as_deref() == Some(&*text) {
        return Ok(());
    }
    let mut former: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(out).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if is_frame(&path) {
            former.push(path);
        }
    }
    if !restart && (there.is_some() || !former.is_empty()) {
        let reason = remedy![
            format!("`{}` holds pictures of another film; remove them with ", out.display()),
            Setting::Restart,
            format!(", or choose another folder than {}", shell_word(out)),
        ];
        return Err(RunError::refused(reason, "the same world, path, size and engine go on where they stopped"));
    }
    for path in former {
        std::fs::remove_file(&path).map_err(|source| RunError::Folder { path, source })?;
    }
    eyot_export::write_text(&file, &text).map_err(RunError::file)
}

/// True for a PNG with its beginning and its end: pictures appear whole, but others may have written over them.
fn is_picture(path: &Path) -> bool {
    const BEGINNING: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
    const END: [u8; 8] = *b"IEND\xae\x42\x60\x82";
    let ends = || {
        let mut file = File::open(path)?;
        let (mut first, mut last) = ([0; 8], [0; 8]);
        file.read_exact(&mut first)?;
        file.seek(SeekFrom::End(-8))?;
        file.read_exact(&mut last)?;
        Ok::<_, std::io::Error>((first, last))
    };
    ends().is_ok_and(|found| found == (BEGINNING, END))
}

/// True for the names that films give to their pictures.
fn is_frame(path: &Path) -> bool {
    path.file_name().and_then(|n| n.to_str()).is_some_and(|n| {
        n.strip_prefix("frame_")
            .and_then(|n| n.strip_suffix(".png"))
            .is_some_and(|n| n.len() == 5 && n.bytes().all(|b| b.is_ascii_digit()))
    })
}
