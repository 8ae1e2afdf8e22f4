//! What the command line takes.

use crate::recipe_cmd::limits;
use crate::{Failure, report};
use clap::{Args, Parser, Subcommand, ValueEnum};
use eyot::Preset;
use eyot::Stream;
use eyot::engines::Isa;
use eyot::formats::{ByteOrder, ReadOptions, RowOrder, Sample};
use eyot::{EngineChoice, EngineOptions, Limits, View};
use eyot_bench::cpu::BenchSubject;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  eyot list                                   what there is
  eyot run island --out island                make the built-in island
  eyot run island --size 256 --seed 3         smaller, and another one
  eyot new mine --from island                 a recipe of your own: mine.toml
  eyot run mine.toml --set volcano.height=400 with another height
  eyot render island --azimuth 120            look at it from another side
  eyot convert island/height.tif island.exr   another file format
  eyot describe cone                          what a generator or process takes

Exit codes of all commands:
  0    done
  1    failed: the work itself, or something that cannot be written
  2    refused: wrong usage, recipe or input; nothing was begun
  130  stopped by Ctrl-C; a run is then ready to resume";

/// Flags of pictures that no camera takes.
const FLAT: [&str; 2] = ["relief", "layer"];

/// Natural landscapes, from plates to polyps.
#[derive(Parser)]
#[command(name = "eyot", version, about, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Run a recipe: a file, or the name of a built-in one
    Run(Run),
    /// Continue a run that was stopped
    Resume(Resume),
    /// Run a recipe and send each step's changes to other programs
    Serve(crate::serve::Serve),
    /// List the frames of a recorded run
    Timeline(Timeline),
    /// Set a recorded run back, to be resumed from there
    Rewind(Rewind),
    /// Begin another run at a moment of a recorded one
    Branch(Branch),
    /// List built-in recipes, generators and processes
    List(List),
    /// Write a recipe file to start from
    New(New),
    /// Check a recipe without running it
    Check(Check),
    /// Explain a generator, a process or a table of the recipe
    Describe(Describe),
    /// Print the literature and data that a recipe rests on
    Cite(Cite),
    /// Print the JSON Schema of recipes, for editors
    Schema,
    /// Draw a picture of a finished run or of a height map
    Render(Render),
    /// Cut through a finished run or a height map along a line, and draw what lies below it
    Section(crate::section::Section),
    /// Film a finished run or a height map: pictures along a camera's path, and a video
    Film(crate::film::Film),
    /// Print statistics of a finished run or of a height map
    Stats(Stats),
    /// Run a recipe with each value of some parameters, and compare the results
    Sweep(Sweep),
    /// Convert a height map, or a layer of a run, into another format
    Convert(Convert),
    /// Measure how fast this machine works
    Bench(Bench),
    /// Say what this machine can simulate on, and test it
    Doctor(Doctor),
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot run island
  eyot run mine.toml --out results --set hydraulic.rain=0.004 --set step.2.enabled=false
  eyot run island --size 1024 --threads 4 --json > events.jsonl

--set changes the recipe before it is checked. Keys start with a key of the recipe (seed, sea_level, grid.cell, view.azimuth), \
a process (hydraulic.rain), the name of a step (volcano.height), a generator (cone.height) or step.NUMBER.")]
pub(crate) struct Run {
    /// A recipe file, or the name of a built-in recipe
    pub(crate) recipe: String,
    /// Folder for the results [default: the name of the recipe file without .toml, here]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) change: Change,
    #[command(flatten)]
    pub(crate) shape: Shape,
    #[command(flatten)]
    pub(crate) work: Work,
    /// Start over where a stopped run lies in the folder
    #[arg(long)]
    pub(crate) restart: bool,
    /// Overwrite files in the folder that are not of a former run
    #[arg(long)]
    pub(crate) force: bool,
    /// Give the commands of an earlier run again at the same steps: its run.json
    #[arg(long, value_name = "FILE")]
    pub(crate) replay: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct Change {
    /// Seed of all random numbers
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = seed)]
    pub(crate) seed: Option<u64>,
    /// Cells along the longer side, or columns x rows; the extent stays
    #[arg(long, value_name = "N|WxH", allow_negative_numbers = true, value_parser = size)]
    pub(crate) size: Option<(u32, Option<u32>)>,
    /// Change a key of the recipe; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Memory that the run may use, such as 8G or 500M
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) max_memory: Option<u64>,
}

#[derive(Args)]
pub(crate) struct Shape {
    /// Write the files of a program, too: unreal, unity, godot, blender or gis; may be repeated
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub(crate) preset: Vec<Preset>,
    /// Make the world while its files are written, so that it need not fit in memory: auto, always or never [default: auto,
    /// which does so with grids of more than 8192 x 8192 cells and those beyond --max-memory, if the recipe allows it]
    #[arg(long, value_name = "WHEN", default_value = "auto", hide_default_value = true, value_parser = stream)]
    pub(crate) stream: Stream,
}

#[derive(Args)]
pub(crate) struct Work {
    /// Threads [default: all cores]; they do not change a byte of the result
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) engine: Engine,
    /// Say nothing but errors, and after a stop how to go on; no warnings either
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// One event per line as JSON on the standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Seconds between two checkpoints
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) checkpoint_seconds: f64,
    /// Record the run: a frame of everything each so many steps, in timeline.zarr in the folder for the results
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true, value_parser = |s: &str| whole(s, 1))]
    pub(crate) record: Option<u64>,
    /// Bytes that the recording may take, such as 2GiB or 500M; old frames thin out
    #[arg(long, value_name = "BYTES", requires = "record", default_value = "2GiB", value_parser = bytes)]
    pub(crate) record_limit: u64,
}

#[derive(Args)]
#[command(after_help = "\
Runs the same erosion on the processor and on the graphics card that --engine gpu would take, and compares the results. \
The exit code is 0 only if they agree; where there is no graphics card, the processor is compared with itself.")]
pub(crate) struct Doctor {
    /// The graphics card to test, by a part of its name
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What carries out the work.
#[derive(Args)]
pub(crate) struct Engine {
    /// What simulates: cpu gives the same bytes on every machine, gpu the same within rounding, auto takes a graphics card if
    /// there is one [default: cpu; a stopped run goes on with what it had]
    #[arg(long, value_name = "WHICH", value_enum)]
    pub(crate) engine: Option<EngineName>,
    /// The graphics card to use, by a part of its name, which means --engine gpu; `eyot doctor` lists them
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

/// What draws views.
#[derive(Args)]
pub(crate) struct Draws {
    /// What draws views: cpu with rays, gpu with a graphics card or its software stand-in, auto with a graphics card if there is
    /// one; maps and reliefs are always drawn by the processor [default: cpu]
    #[arg(long, value_name = "WHICH", value_enum)]
    pub(crate) engine: Option<EngineName>,
    /// The graphics card to use, by a part of its name, which means --engine gpu; `eyot doctor` lists them
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
}

impl Draws {
    pub(crate) fn options(&self) -> Result<EngineOptions, Failure> {
        Ok(engine_options(self.engine, &self.adapter)?.unwrap_or_default())
    }
}

/// What the flags ask for; `None` if nothing.
fn engine_options(name: Option<EngineName>, adapter: &Option<String>) -> Result<Option<EngineOptions>, Failure> {
    let choice = match name {
        None if adapter.is_none() => return Ok(None),
        Some(EngineName::Cpu) if adapter.is_some() => {
            let help = "leave --adapter out, or choose --engine gpu";
            return Err(report::usage("--engine cpu takes no graphics adapter", help));
        }
        Some(EngineName::Auto) => EngineChoice::Auto,
        Some(EngineName::Cpu) => EngineChoice::Cpu,
        Some(EngineName::Gpu) | None => EngineChoice::Gpu,
    };
    Ok(Some(EngineOptions { choice, adapter: adapter.clone(), ..EngineOptions::default() }))
}

/// What to measure; `None` is the island.
#[derive(Clone, Copy)]
pub(crate) struct Measured(pub(crate) Option<BenchSubject>);

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum EngineName {
    Auto,
    Cpu,
    Gpu,
}

impl Engine {
    /// `None` if nothing was asked for.
    pub(crate) fn options(&self) -> Result<Option<EngineOptions>, Failure> {
        engine_options(self.engine, &self.adapter)
    }
}

#[derive(Args)]
pub(crate) struct Resume {
    /// The folder that the stopped run was writing to
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) work: Work,
    /// Memory that the run may use, such as 8G or 500M
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) max_memory: Option<u64>,
}

#[derive(Args)]
pub(crate) struct Timeline {
    /// The folder of a recorded run; it may be at work
    pub(crate) folder: PathBuf,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot run island --record 50                  record a run
  eyot timeline island                         see what there is
  eyot rewind island --to 600
  eyot resume island                           the same bytes as the first time

Later frames are dropped. Results of a finished run stay until the run has been resumed to its end.")]
pub(crate) struct Rewind {
    /// The folder of a recorded run that is not at work
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) moment: Moment,
    /// Drop later changes by hand; else they will be made again at their steps
    #[arg(long)]
    pub(crate) forget: bool,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot branch island --to 600 --out wetter --set hydraulic.rain=0.004
  eyot resume wetter")]
pub(crate) struct Branch {
    /// The folder of a recorded run that is not at work; it stays as it is
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) moment: Moment,
    /// A new folder for the other run
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Change a key of the recipe from there on; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Drop later changes by hand; else they will be made again at their steps
    #[arg(long)]
    pub(crate) forget: bool,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A recorded moment.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub(crate) struct Moment {
    /// The last frame that has at most so many steps of simulation done
    #[arg(long, value_name = "STEP", allow_negative_numbers = true, value_parser = |s: &str| whole(s, 0))]
    to: Option<u64>,
    /// The frame of this number, as `eyot timeline` lists them
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = |s: &str| whole(s, 0))]
    frame: Option<u64>,
}

impl Moment {
    pub(crate) fn get(&self) -> eyot::timeline::Moment {
        match self.frame {
            Some(n) => eyot::timeline::Moment::Frame(usize::try_from(n).unwrap_or(usize::MAX)),
            // One of both is there.
            None => eyot::timeline::Moment::Step(self.to.unwrap_or_default()),
        }
    }
}

#[derive(Args)]
pub(crate) struct List {
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct New {
    /// Name of the landscape; the file is NAME.toml
    pub(crate) name: PathBuf,
    /// The built-in recipe to start from
    #[arg(long, value_name = "RECIPE", default_value = "island")]
    pub(crate) from: String,
}

#[derive(Args)]
#[command(after_help = "\
It refuses what `eyot run` would refuse before its first step, and reads imported files for it. It does not look at the folder \
for the results, nor at --replay.")]
pub(crate) struct Check {
    /// A recipe file, or the name of a built-in recipe
    pub(crate) recipe: String,
    /// Print the recipe that is in force: every key with its value, defaults and --set among them
    #[arg(long)]
    pub(crate) effective: bool,
    #[command(flatten)]
    pub(crate) change: Change,
    #[command(flatten)]
    pub(crate) shape: Shape,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot cite island
  eyot cite mine.toml --format bibtex > mine.bib")]
pub(crate) struct Cite {
    /// A recipe file, or the name of a built-in recipe
    pub(crate) recipe: String,
    /// A list to read, BibTeX, or CSL-JSON for reference managers
    #[arg(long, value_enum, default_value = "text")]
    pub(crate) format: CiteFormat,
    #[command(flatten)]
    pub(crate) change: Change,
}

/// How citations are printed.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum CiteFormat {
    Text,
    Bibtex,
    Json,
}

#[derive(Args)]
pub(crate) struct Describe {
    /// A generator, a process, a table (recipe, grid, step, generate, simulate, schedule, layer, rule, export, view), expressions
    /// or layers
    pub(crate) name: String,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot render island
  eyot render island --azimuth 120 --elevation 20 --size 1920x1080 --out south-east.png
  eyot render island --layer water
  eyot render island --drape water --engine gpu
  eyot render map.tif --relief")]
pub(crate) struct Render {
    /// Folder of a run, or a height map
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// The picture, a .png [default: FOLDER/render.png, or beside the height map]
    #[arg(long, short, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Draw a map of this layer instead of a view
    #[arg(long, value_name = "NAME", conflicts_with = "relief")]
    pub(crate) layer: Option<String>,
    /// From above, with shaded relief
    #[arg(long)]
    pub(crate) relief: bool,
    /// Draw the land in the colours of this layer, with a legend
    #[arg(long, value_name = "NAME", conflicts_with_all = ["relief", "layer"])]
    pub(crate) drape: Option<String>,
    #[command(flatten)]
    pub(crate) engine: Draws,
    /// Width x height of a view in pixels; the longer side of a relief or of a map [default: what the recipe's view says]
    #[arg(long, value_name = "WxH", allow_negative_numbers = true, value_parser = size)]
    pub(crate) size: Option<(u32, Option<u32>)>,
    #[command(flatten)]
    pub(crate) look: Look,
}

/// Camera and sun.
#[derive(Args)]
pub(crate) struct Look {
    /// Where the camera stands, degrees clockwise from north
    #[arg(conflicts_with_all = FLAT)]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = |s: &str| number(s, -360.0, 360.0))]
    pub(crate) azimuth: Option<f32>,
    /// How high the camera stands, degrees over the horizon
    #[arg(conflicts_with_all = FLAT)]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = |s: &str| number(s, 1.0, 89.0))]
    pub(crate) elevation: Option<f32>,
    /// Distance of the camera from the middle of the grid, in lengths of its longer side [default: all of the land in the picture]
    #[arg(conflicts_with_all = FLAT)]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |s: &str| number(s, 0.05, 50.0))]
    pub(crate) distance: Option<f32>,
    /// Angle of view from bottom to top, degrees
    #[arg(conflicts_with_all = FLAT)]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = |s: &str| number(s, 5.0, 120.0))]
    pub(crate) field_of_view: Option<f32>,
    /// Factor on heights [default: what the recipe's view says, or 1]
    #[arg(conflicts_with = "layer")]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |s: &str| number(s, 0.01, 100.0))]
    pub(crate) exaggeration: Option<f32>,
    /// Where the sun stands, degrees clockwise from north
    #[arg(conflicts_with = "layer")]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = |s: &str| number(s, -360.0, 360.0))]
    pub(crate) sun_azimuth: Option<f32>,
    /// How high the sun stands, degrees over the horizon
    #[arg(conflicts_with = "layer")]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = |s: &str| number(s, 1.0, 89.0))]
    pub(crate) sun_elevation: Option<f32>,
}

impl Look {
    /// Whether it says where a camera stands or how it sees.
    pub(crate) fn has_camera(&self) -> bool {
        [self.azimuth, self.elevation, self.distance, self.field_of_view].iter().any(Option::is_some)
    }

    /// The view of a recipe as these flags change it, in a picture of `size`.
    pub(crate) fn over(&self, view: &View, size: [u32; 2]) -> Result<View, Failure> {
        if !size.iter().all(|n| (16..=16384).contains(n)) {
            return Err(report::usage(
                &format!("a picture of {}x{} pixels", size[0], size[1]),
                "choose 16 to 16384 pixels along each side",
            ));
        }
        Ok(View {
            size,
            azimuth: self.azimuth.or(view.azimuth),
            elevation: self.elevation.or(view.elevation),
            distance: self.distance.or(view.distance),
            field_of_view: self.field_of_view.or(view.field_of_view),
            vertical_exaggeration: self.exaggeration.or(view.vertical_exaggeration),
            sun_azimuth: self.sun_azimuth.or(view.sun_azimuth),
            sun_elevation: self.sun_elevation.or(view.sun_elevation),
            ..view.clone()
        })
    }
}

#[derive(Args)]
pub(crate) struct Stats {
    /// Folder of a run, or a height map
    pub(crate) from: PathBuf,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Area that must drain through a cell to make it a channel; without it 600 cells of a map of 512 x 512, on finer and coarser grids
    /// the same share of the map. The drainage density follows it, so compare maps with one area
    #[arg(long, value_name = "M2", allow_negative_numbers = true, value_parser = area)]
    pub(crate) channel_area: Option<f64>,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// As a table of two columns, measure and value
    #[arg(long, conflicts_with = "json")]
    pub(crate) csv: bool,
    /// Draw the hypsometric curve, slope against drained area, and profiles of the largest rivers into this folder, as SVG and PNG
    #[arg(long, value_name = "DIR")]
    pub(crate) plots: Option<PathBuf>,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot sweep island --set hydraulic.rain=0.001..0.005:5 --out rain
  eyot sweep island --size 128 --set seed=1..12:12
  eyot sweep mine.toml --set thermal.talus=20,30,40 --set hydraulic.rain=0.001..0.004:4

The folder gets sweep.csv and sweep.json with the statistics of each run, sheet.png with a picture of each, and runs/ with what is done. \
Given again, the command goes on where it was stopped, and makes only runs that are not there yet.")]
pub(crate) struct Sweep {
    /// A recipe file, or the name of a built-in recipe
    pub(crate) recipe: String,
    /// A parameter and its values: KEY=LOW..HIGH:COUNT for values at equal distances, KEY=A,B,C for a list, KEY=VALUE for one; may be
    /// repeated, and then all combinations are run
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub(crate) set: Vec<String>,
    /// Folder for the results [default: the name of the recipe file without .toml and -sweep, here]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Cells along the longer side, or columns x rows; the extent stays
    #[arg(long, value_name = "N|WxH", allow_negative_numbers = true, value_parser = size)]
    pub(crate) size: Option<(u32, Option<u32>)>,
    /// Memory that all runs together may use, such as 8G or 500M; fewer run at a time if they need more
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Threads of all runs together [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// Area that must drain through a cell to make it a channel, as of `eyot stats`
    #[arg(long, value_name = "M2", value_parser = area)]
    pub(crate) channel_area: Option<f64>,
    /// Pixels along the longer side of each picture of the sheet
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(32..=1024))]
    pub(crate) picture: u32,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// What a height map may leave open, and the memory that reading and all that follows may use.
#[derive(Args)]
pub(crate) struct Reading {
    /// Columns x rows of an input without header
    #[arg(long, value_name = "N|WxH", value_parser = size)]
    pub(crate) from_size: Option<(u32, Option<u32>)>,
    /// Numbers of an input without header: u8, u16le, u16be, i16le, f32le, f64be, ...
    #[arg(long, value_name = "TYPE", value_parser = sample)]
    pub(crate) from_type: Option<(Sample, ByteOrder)>,
    /// Which row of an input without header comes first
    #[arg(long, value_name = "ROW", value_parser = row_order)]
    pub(crate) from_rows: Option<RowOrder>,
    /// Heights that the smallest and the largest whole number of the input stand for, m
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, value_parser = range)]
    pub(crate) from_range: Option<(f64, f64)>,
    /// Number in the input that marks missing cells
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub(crate) nodata: Option<f64>,
    /// Memory that may be used, such as 8G or 500M
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) max_memory: Option<u64>,
}

impl Reading {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            low_m: self.from_range.map(|r| r.0),
            high_m: self.from_range.map(|r| r.1),
            nodata: self.nodata,
            size: self.from_size.map(|(w, h)| (w as usize, h.unwrap_or(w) as usize)),
            sample: self.from_type.map(|t| t.0),
            byte_order: self.from_type.map(|t| t.1),
            row_order: self.from_rows,
            ..ReadOptions::default()
        }
    }

    pub(crate) fn limits(&self) -> Limits {
        limits(self.max_memory)
    }
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot convert map.tif map.exr
  eyot convert island island.zarr                       all layers of a run
  eyot convert island water.tif --layer water
  eyot convert map.raw map.tif --from-size 1025 --from-type u16le --from-range 0,600 --cell 2
  eyot convert map.tif unreal --preset unreal           into the folder `unreal`
  eyot convert island land.glb --tiles 4x4              sixteen meshes that fit together

Formats by name: .tif .png .r16 .raw .r32 .exr .npy .zarr, and meshes .glb .obj. Floats of 32 bits keep their bits and whole \
numbers of 16 bits their values; georeference, cell size and what else a file says of itself go along.")]
pub(crate) struct Convert {
    /// A height map, a Zarr store, or the folder of a run
    pub(crate) from: PathBuf,
    /// The file to write; with --preset, a folder
    pub(crate) to: PathBuf,
    /// Arrays of a Zarr store, channels of an EXR, or layers of a run; .zarr, .exr and gis take several [default: all that
    /// the output can hold, or the height]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub(crate) layer: Vec<String>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Heights that 0 and 65535 stand for in an output of 16 bits, m [default: those of the input, or its range]
    #[arg(long, value_name = "LOW,HIGH", allow_hyphen_values = true, value_parser = range)]
    pub(crate) range: Option<(f64, f64)>,
    /// Size of a cell, m, or west-east x north-south
    #[arg(long, value_name = "M|MxM", value_parser = cell)]
    pub(crate) cell: Option<(f64, f64)>,
    /// Write the files of a program: unreal, unity, godot, blender or gis
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub(crate) preset: Option<Preset>,
    /// Vertices along each side, for unreal and unity [default: the program's size nearest to the input's]
    #[arg(long, value_name = "N")]
    pub(crate) size: Option<u32>,
    /// Cut a mesh into so many tiles with levels of detail and skirts, west-east x north-south: NAME_x0_y0.glb and so on, and NAME.json
    #[arg(long, value_name = "N|WxH", value_parser = tiles)]
    pub(crate) tiles: Option<(u32, Option<u32>)>,
    /// Most vertices of a mesh, or of each of its tiles [default: 1050625, about 80 MB]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(4..=100_000_000))]
    pub(crate) vertices: Option<u64>,
    /// Order of bytes of an output without header: little or big [default: little]
    #[arg(long, value_name = "ORDER", value_parser = byte_order)]
    pub(crate) bytes: Option<ByteOrder>,
    /// Which row of an output without header comes first: north or south [default: north; for unity south]
    #[arg(long, value_name = "ROW", value_parser = row_order)]
    pub(crate) rows: Option<RowOrder>,
    /// Overwrite what is there already
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot bench hydraulic --size 2048
  eyot bench noise --threads 1 --json")]
pub(crate) struct Bench {
    /// What to measure: hydraulic, signed (that with four pipes), thermal, rule, noise, reef, drainage, rivers, glaciers, streampower,
    /// strata, plants, community, slope, bodies, world, plates or drift; on a graphics card also island, 3000 steps of the
    /// recipe of that name
    #[arg(value_name = "WHAT", value_parser = subject)]
    pub(crate) what: Measured,
    /// Cells along each side, metres for community, slope and bodies [default: 512, 40 for community, 400 for slope, 10 for
    /// bodies]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=32768))]
    pub(crate) size: Option<u32>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// Instruction set: scalar, baseline, avx2 or avx512 [default: the best that this processor has]
    #[arg(long, value_name = "NAME", value_parser = isa)]
    pub(crate) isa: Option<Isa>,
    /// Hydraulic erosion as published in 2007 instead of Eyot's own form
    #[arg(long)]
    pub(crate) classic: bool,
    #[command(flatten)]
    pub(crate) engine: Engine,
    /// Passes that the GPU engine puts into one dispatch [default: as many as pay]; 1 switches fusing off
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=16))]
    pub(crate) passes: Option<u8>,
    /// Seconds to spend on measuring; warming up comes on top
    #[arg(long, value_name = "S", default_value = "5")]
    pub(crate) seconds: f64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

fn whole(text: &str, least: u64) -> Result<u64, String> {
    text.parse().ok().filter(|n| *n >= least).ok_or_else(|| format!("write a whole number of at least {least}"))
}

fn seed(text: &str) -> Result<u64, String> {
    text.trim().parse().map_err(|_| format!("write a whole number from 0 to {}", u64::MAX))
}

fn stream(text: &str) -> Result<Stream, String> {
    match text {
        "auto" => Ok(Stream::Auto),
        "always" => Ok(Stream::Always),
        "never" => Ok(Stream::Never),
        _ => Err("choose auto, always or never".to_owned()),
    }
}

/// `None` for the island, which is no subject of its own on the processor.
fn subject(text: &str) -> Result<Measured, String> {
    if text == "island" {
        Ok(Measured(None))
    } else {
        text.parse().map(|s| Measured(Some(s))).map_err(|e: eyot::Error| e.to_string())
    }
}

fn isa(text: &str) -> Result<Isa, String> {
    Isa::ALL.into_iter().find(|i| i.name() == text).ok_or_else(|| "choose scalar, baseline, avx2 or avx512".to_owned())
}

fn preset(text: &str) -> Result<Preset, String> {
    Preset::from_name(text).ok_or_else(|| "choose unreal, unity, godot, blender or gis".to_owned())
}

fn sample(text: &str) -> Result<(Sample, ByteOrder), String> {
    Sample::parse(text).ok_or_else(|| "write a type such as u16le, u16be, i16le, u8, f32le or f64be".to_owned())
}

fn byte_order(text: &str) -> Result<ByteOrder, String> {
    match text {
        "little" => Ok(ByteOrder::Little),
        "big" => Ok(ByteOrder::Big),
        _ => Err("choose little or big".to_owned()),
    }
}

fn row_order(text: &str) -> Result<RowOrder, String> {
    match text {
        "north" => Ok(RowOrder::NorthFirst),
        "south" => Ok(RowOrder::SouthFirst),
        _ => Err("choose north or south".to_owned()),
    }
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let number = |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match text.split_once(',').and_then(|(a, b)| number(a).zip(number(b))) {
        Some((low, high)) if low < high => Ok((low, high)),
        _ => Err("write two heights in metres, the lower one first, such as -50,1200".to_owned()),
    }
}

fn cell(text: &str) -> Result<(f64, f64), String> {
    let metres = |s: &str| s.trim().parse::<f64>().ok().filter(|v| (1e-6..=1e7).contains(v));
    let (x, y) = text.split_once(['x', 'X']).unwrap_or((text, text));
    metres(x).zip(metres(y)).ok_or_else(|| "write metres such as 10, or 10x12.5".to_owned())
}

pub(crate) fn size(text: &str) -> Result<(u32, Option<u32>), String> {
    let side = |s: &str| match s.trim().parse::<u32>() {
        Ok(n) if n > 0 => Ok(n),
        _ => Err("write a whole number such as 512, or columns x rows such as 512x256".to_owned()),
    };
    match text.split_once(['x', 'X']) {
        Some((w, h)) => Ok((side(w)?, Some(side(h)?))),
        None => Ok((side(text)?, None)),
    }
}

fn tiles(text: &str) -> Result<(u32, Option<u32>), String> {
    match size(text) {
        Ok((x, y)) if x <= 64 && y.unwrap_or(x) <= 64 => Ok((x, y)),
        _ => Err("write tiles from west to east x from north to south, 1 to 64 each, such as 4x4".to_owned()),
    }
}

pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let help = "write a number with K, M, G or T, such as 8G";
    let text = text.trim().trim_end_matches(['B', 'b']).trim_end_matches('i');
    let (number, shift) = match text.char_indices().next_back() {
        Some((i, 'k' | 'K')) => (&text[..i], 10),
        Some((i, 'm' | 'M')) => (&text[..i], 20),
        Some((i, 'g' | 'G')) => (&text[..i], 30),
        Some((i, 't' | 'T')) => (&text[..i], 40),
        _ => (text, 0),
    };
    let n: f64 = number.trim().parse().map_err(|_| help.to_owned())?;
    let bytes = n * (1_u64 << shift) as f64;
    if bytes.is_finite() && bytes >= 1.0 { Ok(bytes as u64) } else { Err(help.to_owned()) }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(s) if (0.0..=1e9).contains(&s) => Ok(s),
        _ => Err("write seconds from 0 to 1e9".to_owned()),
    }
}

fn area(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(m2) if m2 > 0.0 && m2 <= 1e18 => Ok(m2),
        _ => Err("write an area in m2, above 0: 1e6 is a square kilometre".to_owned()),
    }
}

pub(crate) fn number(text: &str, low: f32, high: f32) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if (low..=high).contains(&x) => Ok(x),
        _ => Err(format!("write a number from {low} to {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_is_sound() {
        Cli::command().debug_assert();
    }

    /// Help is wrapped to the terminal, at most 100 columns: lines that are broken by hand would be broken twice.
    #[test]
    fn paragraphs_of_help_stand_on_one_line() {
        for verb in Cli::command().get_subcommands() {
            let text = verb.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<&str> = text.lines().collect();
            for (line, next) in lines.iter().zip(lines.iter().skip(1).chain([&""])) {
                let whole = line.is_empty() || line.ends_with(':') || next.is_empty() || next.starts_with(' ');
                assert!(whole && (!line.starts_with(' ') || line.len() <= 100), "{}: {line}", verb.get_name());
            }
        }
    }

    /// The page of the book that lists the command's verbs and flags is written by hand.
    #[test]
    fn the_book_names_every_verb_and_flag() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/book/src/reference/command.md");
        let page = std::fs::read_to_string(page).expect("a page of the book");
        for verb in Cli::command().get_subcommands() {
            let start = format!("| `eyot {}", verb.get_name());
            let row =
                page.lines().find(|l| l.starts_with(&start)).unwrap_or_else(|| panic!("reference/command.md: {start}"));
            for flag in verb.get_arguments().filter_map(|a| a.get_long()) {
                assert!(row.contains(&format!("`--{flag}")), "reference/command.md, `{}`: --{flag}", verb.get_name());
            }
        }
    }

    #[test]
    fn sizes_and_bytes() {
        assert_eq!(size("512"), Ok((512, None)));
        assert_eq!(size("512x256"), Ok((512, Some(256))));
        assert!(size("0").is_err() && size("ax3").is_err() && size("-5").is_err() && size("").is_err());
        assert_eq!(bytes("8G"), Ok(8 << 30));
        assert_eq!(bytes("1.5KiB"), Ok(1536));
        assert!(
            bytes("").is_err()
                && bytes("G").is_err()
                && bytes("-1G").is_err()
                && bytes("nanG").is_err()
                && bytes("é").is_err()
        );
    }
}
