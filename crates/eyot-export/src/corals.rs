//! What a reef of single colonies gives beside its layers: the census as a table, pictures of the plot, bodies.

use crate::dive;
use crate::error::ExportError;
use crate::estimate;
use crate::files::Job;
use crate::plots::{self, Curve, Story};
use crate::views;
use eyot_core::component::Attribute;
use eyot_core::process::parameters_from;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_core::{Field, Limits, Result, World};
use eyot_recipe::{ExportFormat, Recipe, What};
use eyot_reef::bodies::{Bodies, Body, Detail};
use eyot_reef::community::{Alga, Colony, Heat, Plot, Species};
use eyot_reef::corals::{CORALS, Corals};
use eyot_render::Drawing;
use io::{Scene, SceneMaterial, SceneMesh, SceneNode, Target};
use mesh::{Blend, Blobs, Kernel, Lattice, MeshingOptions, Primitive, Solid, mesh_field};
use serde_json::{Value, json};
use {eyot_io as io, eyot_mesh as mesh};

/// What to do about a reef that is too large.
fn remedy() -> Remedy {
    remedy!["export a smaller plot, leave out `corals`, or raise ", Setting::MaxMemory]
}
/// Linear colour of macroalgae.
pub(crate) const ALGAE: [u8; 4] = [52, 60, 14, 255];

/// The corals of a recipe, as its last step has them.
pub fn of(recipe: &Recipe) -> Option<Corals> {
    let corals = recipe.last_use(CORALS.name)?;
    parameters_from(corals.parameters.clone()).ok()
}

/// The census: a row for each month.
pub(crate) fn census(job: &Job<'_>, corals: &Corals) -> Result<io::Table> {
    Ok(io::Table::of(&*corals.census(job.world)?, job.attributes.clone()))
}

/// Cover of each species over the years.
pub(crate) fn cover(corals: &Corals, world: &World, title: &str) -> Result<Drawing> {
    let census = corals.census(world)?;
    let series = |c: &Attribute| -> Vec<f64> { (0..census.len()).map(|i| c.values.number(i)).collect() };
    let named = |name: &str| census.get(name).map_or_else(Vec::new, series);
    let ending =
        |ending: &str| census.columns().iter().filter(|c| c.name.ends_with(ending)).collect::<Vec<&Attribute>>();
    let (species, rules) = (&corals.community.species, &corals.community.heat);
    let of = |(s, c): (&'_ Species, &Attribute)| (s.name.clone(), s.colour, series(c));
    let corals: Vec<_> = species.iter().zip(ending(".cover")).map(of).collect();
    let mut curves: Vec<Curve<'_>> =
        corals.iter().map(|(name, colour, cover)| Curve { name, colour: *colour, cover: cover.clone() }).collect();
    curves.push(Curve { name: "macroalgae", colour: plots::ALGAE, cover: named("algae_cover") });
    let (bleached, all) = (ending(".bleached"), ending(".colonies"));
    let sum = |row: usize, of: &[&Attribute]| of.iter().map(|c| c.values.number(row)).sum::<f64>();
    let bleached = (0..census.len()).map(|row| sum(row, &bleached) / sum(row, &all).max(1.0)).collect();
    let heat = named("heat_index_c").into_iter().zip(named("degree_heating_weeks"));
    let bleaches = |(index, weeks): (f64, f64)| {
        let heat = Heat { index: index as f32, heating_weeks: weeks as f32, ..Heat::default() };
        species.iter().any(|s| heat.risks(rules, s).0 > 0.0)
    };
    let hot = heat.enumerate().filter(|(_, h)| bleaches(*h)).map(|(m, _)| m).collect();
    Ok(plots::cover(&Story { title, curves, bleached, hot }))
}

/// The plot from above.
pub(crate) fn plan(corals: &Corals, world: &World) -> std::result::Result<Drawing, ExportError> {
    Ok(plots::plan(&corals.plot(world).map_err(ExportError::file)?))
}

/// What stands on the sea floor.
pub(crate) struct Reef<'a> {
    world: &'a World,
    pub(crate) plot: Plot,
    pub(crate) seed: u64,
    pub(crate) sea_level: f32,
    /// A macroalga of a height of 1 m.
    pub(crate) alga: Solid,
    /// Lowest and highest place of the sea floor, m.
    heights: [f32; 2],
}

impl<'a> Reef<'a> {
    /// # Errors
    /// If the world's numbers are not those of these corals.
    pub(crate) fn new(corals: &Corals, world: &'a World) -> Result<Self> {
        let plot = corals.plot(world)?;
        let heights = world
            .layer("height")?
            .field
            .iter()
            .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        Ok(Self { world, plot, seed: world.seed, sea_level: world.sea_level_m as f32, alga: alga()?, heights })
    }

    /// Extent to the east and to the south, m.
    pub(crate) fn sides(&self) -> [f32; 2] {
        [self.plot.site().width_m as f32, self.plot.site().length_m as f32]
    }

    /// Edge of a cell, m.
    pub(crate) fn cell(&self) -> f32 {
        self.world.grid.cell_x_m as f32
    }

    /// Lowest and highest place of the sea floor, m.
    pub(crate) fn heights(&self) -> [f32; 2] {
        self.heights
    }

    /// True if depths differ so much that its light does.
    pub(crate) fn is_slope(&self) -> bool {
        self.heights[1] - self.heights[0] > 5.0
    }

    /// Share of rock at a place, if a step has said where it is.
    pub(crate) fn substrate(&self, x: f32, y: f32) -> Option<f32> {
        self.world.get("substrate").map(|layer| self.between(layer, x, y).clamp(0.0, 1.0))
    }

    /// Height of the sea floor under a place.
    pub(crate) fn floor(&self, x: f32, y: f32) -> f32 {
        self.world.get("height").map_or(0.0, |height| self.between(height, x, y))
    }

    /// Rise of the sea floor to the east and to the south under a colony of this radius.
    pub(crate) fn slope(&self, x: f32, y: f32, radius: f32) -> [f32; 2] {
        let r = radius.max(0.5 * self.cell());
        let rise = |dx: f32, dy: f32| (self.floor(x + dx, y + dy) - self.floor(x - dx, y - dy)) / (2.0 * r);
        // Bodies that are sheared further look like flags.
        [rise(r, 0.0), rise(0.0, r)].map(|s| s.clamp(-1.0, 1.0))
    }

    /// A layer's value at a place, between the middles of four cells.
    fn between(&self, layer: &Field, x: f32, y: f32) -> f32 {
        let grid = &self.world.grid;
        let place = |v: f32, size: f64, n: usize| (f64::from(v) / size - 0.5).clamp(0.0, n as f64 - 1.0);
        let (x, y) = (place(x, grid.cell_x_m, grid.width), place(y, grid.cell_y_m, grid.height));
        let (i, j) = (x as usize, y as usize);
        let at = |i: usize, j: usize| f64::from(layer.get(i.min(grid.width - 1), j.min(grid.height - 1)));
        let along = |j: usize| at(i, j) + (at(i + 1, j) - at(i, j)) * (x - i as f64);
        (along(j) + (along(j + 1) - along(j)) * (y - j as f64)) as f32
    }

    fn corals<'b>(&'b self, bodies: &'b Bodies) -> impl Iterator<Item = (&'b Colony, &'b Body)> {
        self.plot.colonies().iter().filter_map(|c| Some((c, bodies.of(c.id)?)))
    }

    pub(crate) fn algae(&self) -> impl Iterator<Item = &Alga> {
        self.plot.algae().iter().filter(|a| a.height > 0.0)
    }

    /// Writes all bodies as GLB, OBJ or PLY.
    ///
    /// # Errors
    /// If nothing lives, or the file cannot be written.
    pub(crate) fn write(&self, bodies: &Bodies, to: Target<'_>, name: &str, format: ExportFormat) -> io::Result<()> {
        let species: &[Species] = &self.plot.community().species;
        let names: Vec<String> = self.corals(bodies).map(|(c, _)| label(c, species)).collect();
        let colours = vec![ALGAE; self.alga.positions.len()];
        let mut meshes: Vec<SceneMesh<'_>> = self
            .corals(bodies)
            .zip(&names)
            .map(|((c, b), name)| SceneMesh {
                name,
                positions: &b.solid.positions,
                normals: &b.solid.normals,
                colours: &b.colours,
                // Nothing of a GLB wears a texture; whoever paints takes the OBJ.
                texture: if format == ExportFormat::Obj { &b.texture } else { &[] },
                indices: &b.solid.indices,
                material: usize::from(c.species),
            })
            .collect();
        let mut nodes: Vec<SceneNode> = self
            .corals(bodies)
            .zip(&names)
            .enumerate()
            .map(|(mesh, ((c, _), name))| {
                let about = json!({
                    "id": c.id, "species": species[usize::from(c.species)].name, "age_months": c.age,
                    "radius_m": c.radius, "bleaching": c.bleaching,
                });
                self.node(name.clone(), mesh, [c.x, c.y], 1.0, about)
            })
            .collect();
        if self.algae().next().is_some() {
            let mesh = meshes.len();
            meshes.push(SceneMesh {
                name: "macroalga",
                positions: &self.alga.positions,
                normals: &self.alga.normals,
                colours: &colours,
                texture: &[],
                indices: &self.alga.indices,
                material: species.len(),
            });
            nodes.extend(self.algae().map(|a| {
                let about = json!({ "id": a.id, "age_months": a.age, "height_m": a.height });
                SceneNode {
                    turn: turn(a),
                    ..self.node(format!("macroalga {}", a.id), mesh, [a.x, a.y], a.height, about)
                }
            }));
        }
        let mut materials: Vec<SceneMaterial<'_>> =
            species.iter().map(|s| SceneMaterial { name: &s.name, colour: [1.0; 3] }).collect();
        materials.push(SceneMaterial { name: "macroalgae", colour: [1.0; 3] });
        let scene = Scene { name, meshes, materials, nodes };
        match format {
            ExportFormat::Obj => io::write_scene_obj(to, &scene),
            ExportFormat::Ply => io::write_scene_ply(to, &scene),
            _ => io::write_scene_glb(to, &scene),
        }
    }

    fn node(&self, name: String, mesh: usize, [x, y]: [f32; 2], size: f32, extras: Value) -> SceneNode {
        SceneNode { name, mesh, place: [x, self.floor(x, y), y], turn: 0.0, size, extras }
    }
}

fn label(c: &Colony, species: &[Species]) -> String {
    format!("{} {}", species[usize::from(c.species)].name, c.id)
}

/// Macroalgae share a mesh and are turned, each by its own number.
pub(crate) fn turn(a: &Alga) -> f32 {
    a.id as f32
}

/// Fronds of a macroalga that bend apart, 1 m high.
fn alga() -> Result<Solid> {
    let frond = |k: usize| {
        let (s, c) = (k as f32 * 2.399_963).sin_cos();
        let lean = 0.1 + 0.05 * k as f32;
        let (knee, tip) = ([0.5 * lean * c, 0.5, 0.5 * lean * s], [lean * c, 1.0 - 0.06 * k as f32, lean * s]);
        [
            Primitive { ends: [[0.0; 3], knee], radii: [0.035, 0.045] },
            Primitive { ends: [knee, tip], radii: [0.045, 0.02] },
        ]
    };
    let primitives: Vec<Primitive> = (0..6).flat_map(frond).collect();
    let limits = Limits::default();
    let fault = |e: mesh::Error| eyot_core::Error::BadParameter {
        owner: "alga".into(),
        field: "body".into(),
        reason: e.to_string(),
    };
    let blobs = Blobs::new(&primitives, Kernel::Muraki, Blend::Normalised, &limits).map_err(fault)?;
    let lattice = Lattice::over([-0.6, -0.1, -0.6], [0.6, 1.1, 0.6], 0.015, &limits).map_err(fault)?;
    Ok(mesh_field(&blobs, &lattice, &MeshingOptions { rounds: 1 }, &limits).map_err(fault)?.largest_piece())
}

/// Writes the files of an export of corals, in the order of [`eyot_recipe::Export::files`].
pub(crate) fn write(
    job: &mut Job<'_>,
    corals: &Corals,
    what: &What,
    formats: &[ExportFormat],
    files: &[String],
) -> std::result::Result<(), ExportError> {
    match what {
        What::Census => {
            let table = census(job, corals).map_err(ExportError::file)?;
            views::write_table(job, &table, formats[0], &files[0])
        }
        What::Plots => {
            let drawings = [cover(corals, job.world, job.name).map_err(ExportError::file)?, plan(corals, job.world)?];
            for (format, names) in formats.iter().zip(files.chunks(drawings.len())) {
                for (name, drawing) in names.iter().zip(&drawings) {
                    let path = job.file(name)?;
                    write_drawing(drawing, *format, path).map_err(ExportError::file)?;
                }
            }
            Ok(())
        }
        _ => write_bodies(job, corals, what, formats[0], files),
    }
}

fn write_drawing(drawing: &Drawing, format: ExportFormat, to: Target<'_>) -> io::Result<()> {
    if format == ExportFormat::Svg {
        return io::write_text(to, &drawing.svg());
    }
    let picture = drawing.picture();
    io::write_rgb_png(to, picture.width, picture.height, &picture.pixels)
}

/// Writes what needs bodies: a file of meshes, or pictures.
fn write_bodies(
    job: &mut Job<'_>,
    corals: &Corals,
    what: &What,
    format: ExportFormat,
    files: &[String],
) -> std::result::Result<(), ExportError> {
    let reef = Reef::new(corals, job.world).map_err(ExportError::file)?;
    if *what == What::Dive {
        let pictures = dive::pictures(&reef, job.limits).map_err(ExportError::file)?;
        for (name, picture) in files.iter().zip(pictures) {
            let path = job.file(name)?;
            io::write_rgb_png(path, picture.width, picture.height, &picture.pixels).map_err(ExportError::file)?;
        }
        return Ok(());
    }
    if reef.plot.colonies().is_empty() && reef.algae().next().is_none() {
        job.tell(format!("`{}` is not written: nothing lives on the plot any more", files[0]));
        return Ok(());
    }
    // Arrays are written as they are; names and numbers of the nodes take room of their own.
    let nodes = 2048 * (reef.plot.colonies().len() + reef.plot.algae().len()) as u128;
    let needed = Bodies::bytes(&reef.plot, Detail::default()) + nodes;
    estimate::check("the bodies of corals", job.world, needed, job.limits, remedy()).map_err(ExportError::file)?;
    let mut bodies = Bodies::new(reef.plot.community(), reef.seed, Detail::default()).map_err(ExportError::file)?;
    bodies.update(&reef.plot).map_err(ExportError::file)?;
    let (name, path) = (job.name, job.file(&files[0])?);
    reef.write(&bodies, path, name, format).map_err(ExportError::file)
}
