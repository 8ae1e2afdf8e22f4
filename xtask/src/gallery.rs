//! A picture of what each generator makes, for the book: sources as they are, filters before and after or with the depth
//! of their change, masks beside the land that they were made of.

use crate::palette;
use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions, World};
use eyot_render::{self as render, Picture, ReliefOptions, Setting, ViewOptions};
use std::error::Error;
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Land for filters and masks to work on.
const LAND: &str =
    "[[step]]\ngenerate = \"fbm\"\namplitude = 1800.0\nscale = 0.6\noctaves = 6\ngain = 0.42\nwarp = 0.2\n";
const HEAD: &str = "seed = 4\n[grid]\nsize = 240\ncell = 40.0\n";

/// How a generator is shown.
enum Show {
    /// Alone.
    Source(String),
    /// Alone, with its sea.
    Island(String),
    /// The land before and after.
    Filter(String),
    /// The land, and beside it how deep it is changed.
    Depth(String),
    /// A layer beside the land.
    Mask(String),
}

/// Choices that each have a picture of their own, beside that of the default.
const CHOICES: [(&str, &str); 3] = [("fbm", "basis"), ("worley", "distance"), ("smooth", "kernel")];

/// The same with another choice.
fn varied(name: &str, key: &str, choice: &str) -> Show {
    let step = format!("[[step]]\ngenerate = \"{name}\"\n{key} = \"{choice}\"\n");
    // One pass of three by three cells shows nothing.
    if name == "smooth" { Show::Filter(format!("{step}passes = 12\n")) } else { Show::Source(step) }
}

/// The step that shows the generator at its best: its defaults, unless these show nothing.
fn shown(name: &str, filter: bool) -> Show {
    let plain = format!("[[step]]\ngenerate = \"{name}\"\n");
    match name {
        "constant" => Show::Source(format!("{plain}value = 100.0\n")),
        "ramp" => Show::Source(format!("{plain}direction = 30.0\nhigh = 2000.0\n")),
        "import" => Show::Source(format!("{plain}file = \"builtin:jacksboro.tif\"\n")),
        "smooth" => Show::Filter(format!("{plain}sigma_m = 200.0\n")),
        "terraces" => Show::Filter(format!("{plain}count = 6\nsoftness = 0.3\n")),
        "mask_height" => Show::Mask(format!("{plain}layer = \"mask\"\nfrom = 0.0\nto = 600.0\n")),
        "flow" => Show::Mask(format!(
            "{plain}layer = \"mask\"\n[[step]]\ngenerate = \"remap\"\nlayer = \"mask\"\n\
             from = [0.0, 4e5]\nto = [0.0, 1.0]\npoints = [[0.0, 0.0], [0.03, 0.45], [1.0, 1.0]]\n"
        )),
        // What they do to hollows shows in no view.
        "fill" | "breach" => Show::Depth(plain),
        "volcanic_island" => Show::Island(plain),
        "crater" => Show::Filter(format!("{plain}level = 0.55\ncrest_m = 40.0\n")),
        _ if name.starts_with("mask_") => Show::Mask(format!("{plain}layer = \"mask\"\n")),
        _ if filter => Show::Filter(plain),
        _ => Show::Source(plain),
    }
}

/// The world that a recipe makes, with its sea.
fn coast(steps: &str) -> Result<World> {
    let text = format!("{HEAD}{steps}");
    let source = RecipeSource { name: "gallery".into(), text, folder: ".".into() };
    let recipe = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default())?;
    Ok(Run::start(recipe, RunOptions::default())?.join()?.world)
}

/// The same as dry land, whatever its heights are.
fn world(steps: &str) -> Result<World> {
    let mut world = coast(steps)?;
    if let Some(height) = world.get("height") {
        world.sea_level_m = f64::from(height.min_max().0) - 1.0;
    }
    Ok(world)
}

fn view(world: &World, width: usize, height: usize) -> Result<Picture> {
    let options = ViewOptions { width, height, sea: false, setting: Setting::Block, ..ViewOptions::default() };
    Ok(render::perspective(world, &options)?)
}

/// Two pictures of the same height with a narrow gap.
fn pair(a: &Picture, b: &Picture) -> Picture {
    const GAP: usize = 4;
    let mut both = Picture::new(a.width + GAP + b.width, a.height, [255; 3]);
    for (y, row) in both.pixels.chunks_mut(a.width + GAP + b.width).enumerate() {
        row[..a.width].copy_from_slice(&a.pixels[y * a.width..][..a.width]);
        row[a.width + GAP..].copy_from_slice(&b.pixels[y * b.width..][..b.width]);
    }
    both
}

/// The land from above, and beside it shares from 0, black, to 1, white.
fn beside(land: &World, shares: &[f32]) -> Result<Picture> {
    let relief = ReliefOptions { min_size: 240, max_size: 240, sea: false, ..ReliefOptions::default() };
    let grey = shares.iter().map(|v| [(255.0 * v.clamp(0.0, 1.0)).round() as u8; 3]).collect();
    let shares = Picture { width: land.grid.width, height: land.grid.height, pixels: grey };
    Ok(pair(&render::relief(land, &relief)?, &shares))
}

/// The picture of one generator.
fn picture(show: Show) -> Result<Picture> {
    match show {
        Show::Source(step) => view(&world(&step)?, 384, 240),
        Show::Island(step) => {
            let options = ViewOptions { width: 384, height: 240, ..ViewOptions::default() };
            Ok(render::perspective(&coast(&step)?, &options)?)
        }
        Show::Filter(step) => {
            let after = world(&format!("{LAND}{step}"))?;
            Ok(pair(&view(&world(LAND)?, 240, 180)?, &view(&after, 240, 180)?))
        }
        Show::Depth(step) => {
            let (before, after) = (world(LAND)?, world(&format!("{LAND}{step}"))?);
            let changes = before.layer("height")?.field.iter().zip(after.layer("height")?.field.iter());
            let changes: Vec<f32> = changes.map(|(a, b)| (b - a).abs()).collect();
            let most = changes.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
            // The root shows shallow places, too.
            let share: Vec<f32> = changes.iter().map(|d| (d / most).sqrt()).collect();
            beside(&before, &share)
        }
        Show::Mask(step) => {
            let world = world(&format!("{LAND}{step}"))?;
            let mask: Vec<f32> = world.layer("mask")?.field.iter().collect();
            beside(&world, &mask)
        }
    }
}

/// Draws all pictures.
pub(crate) fn write() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/gallery");
    std::fs::create_dir_all(&folder)?;
    for entry in Registry::standard().generators() {
        let generator = (entry.make)((entry.defaults)())?;
        draw(&folder, entry.name, shown(entry.name, generator.is_filter()))?;
    }
    for (name, key) in CHOICES {
        let about = eyot::describe(name, &Registry::standard())?;
        let parameter = about.parameters.iter().find(|p| p.name == key).ok_or("no such parameter")?;
        for choice in parameter.choices.iter().filter(|c| parameter.default != c.value.as_str()) {
            draw(&folder, &format!("{name}-{}", choice.value), varied(name, key, &choice.value))?;
        }
    }
    Ok(())
}

fn draw(folder: &Path, name: &str, show: Show) -> Result<()> {
    let path = folder.join(format!("{name}.png"));
    palette::write(&path, &picture(show)?)?;
    println!("{name:20} {:4} kB", std::fs::metadata(&path)?.len() / 1024);
    Ok(())
}
