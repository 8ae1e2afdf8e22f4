//! What a reef of single colonies gives beside its layers: the census as a table, pictures of the plot, bodies.

use super::Job;
use crate::backend::{io, mesh, render};
use crate::error::RunError;
use crate::keys::ExportFormat;
use crate::need;
use crate::recipe::{Actor, Recipe, Work};
use eyot_core::process::parameters_from;
use eyot_core::{Limits, Result, World};
use eyot_reef::bodies::{Bodies, Body, Detail};
use eyot_reef::community::{Alga, Colony, Curve, Plot, Species, cover_svg, plan_svg};
use eyot_reef::corals::{CENSUS, CORALS, Corals};
use io::{Scene, SceneMaterial, SceneMesh, SceneNode};
use mesh::{Blend, Blobs, Kernel, Lattice, MeshingOptions, Primitive, Solid, mesh_field};
use render::{Camera, Haze, MeshPart, MeshViewOptions, Picture, mesh_view, mesh_view_bytes};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Pixels of the picture from the side, and along each side of that from above.
const SIDE: [usize; 2] = [1400, 900];
const ABOVE: usize = 1100;
/// Cells along a side of the sea floor's mesh.
const GROUND: usize = 160;
/// What to do about a reef that is too large.
const REMEDY: &str = "export a smaller plot, leave out `corals` and `dive`, or raise --max-memory";
/// Light that clear water takes, 1/m, red first, and the colour of far water.
const WATER: Haze = Haze { per_m: [0.16, 0.05, 0.045], veil: [0.02, 0.16, 0.24] };
/// Beyond this way, m, nothing is left but that colour.
const SIGHT_M: f32 = 120.0;
/// Linear colours of sand and of macroalgae.
const SAND: [u8; 4] = [118, 104, 78, 255];
const ALGAE: [u8; 4] = [52, 60, 14, 255];

/// The corals of a recipe, as its last step has them.
pub(crate) fn of(recipe: &Recipe) -> Option<Corals> {
    let steps = recipe.steps.iter().rev().filter(|s| s.enabled);
    let uses = steps.filter_map(|s| if let Work::Simulate(w) = &s.work { Some(&w.processes) } else { None });
    let corals =
        uses.flatten().find(|u| u.enabled && matches!(&u.actor, Actor::Process(e) if e.name == CORALS.name))?;
    parameters_from(corals.parameters.clone()).ok()
}

/// The census as comma-separated values: a line of names, then one for each month.
pub(super) fn census(corals: &Corals, world: &World) -> String {
    let columns = corals.census_columns();
    let mut out = columns.join(",") + "\n";
    for row in rows(corals, world) {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// Cover of each species over the years.
pub(super) fn cover(corals: &Corals, world: &World, title: &str) -> String {
    let (columns, rows) = (corals.census_columns(), rows(corals, world));
    let column = |name: &str| columns.iter().position(|c| c == name);
    let series = |i: usize| rows.iter().map(|r| r[i]).collect();
    let covers = columns.iter().enumerate().filter(|(_, c)| c.ends_with(".cover")).map(|(i, _)| i);
    let species = &corals.community.species;
    let mut curves: Vec<Curve<'_>> =
        species.iter().zip(covers).map(|(s, i)| Curve { name: &s.name, colour: s.colour, cover: series(i) }).collect();
    curves.extend(column("algae_cover").map(|i| Curve::of_algae(series(i))));
    // The hottest month of a year that bleaches somebody.
    let least = species.iter().map(|s| f64::from(s.bleaching_min)).fold(f64::INFINITY, f64::min);
    let hot = column("heat_index_c").map_or_else(Vec::new, |i| {
        rows.iter().enumerate().filter(|(_, r)| r[i] >= least).map(|(m, _)| m as u64).collect()
    });
    cover_svg(title, &curves, &hot)
}

/// The plot from above.
pub(super) fn plan(corals: &Corals, world: &World) -> std::result::Result<String, RunError> {
    Ok(plan_svg(&corals.plot(world).map_err(RunError::file)?))
}

fn rows<'a>(corals: &Corals, world: &'a World) -> Vec<&'a [f64]> {
    let columns = corals.census_columns().len();
    world.features.get(CENSUS).map_or_else(Vec::new, |numbers| numbers.chunks_exact(columns).collect())
}

/// Everything that stands on the sea floor, with its body.
pub(super) struct Reef<'a> {
    world: &'a World,
    plot: Plot,
    bodies: Bodies,
    /// A macroalga of a height of 1 m.
    alga: Solid,
}

impl<'a> Reef<'a> {
    /// # Errors
    /// If the world's numbers are not those of these corals, if a body cannot be made, or if all of them exceed the limits.
    pub(super) fn new(corals: &Corals, world: &'a World, limits: &Limits) -> Result<Self> {
        let plot = corals.plot(world)?;
        need::check("the bodies of corals", world, Bodies::bytes(&plot, Detail::default()), limits, REMEDY)?;
        let mut bodies = Bodies::new(plot.community(), world.seed, Detail::default())?;
        bodies.update(&plot)?;
        Ok(Self { world, plot, bodies, alga: alga()? })
    }

    /// Height of the sea floor under a place, between the middles of four cells.
    fn floor(&self, x: f32, y: f32) -> f32 {
        let (Some(height), grid) = (self.world.get("height"), &self.world.grid) else { return 0.0 };
        let place = |v: f32, size: f64, n: usize| (f64::from(v) / size - 0.5).clamp(0.0, n as f64 - 1.0);
        let (x, y) = (place(x, grid.cell_x_m, grid.width), place(y, grid.cell_y_m, grid.height));
        let (i, j) = (x as usize, y as usize);
        let at = |i: usize, j: usize| f64::from(height.get(i.min(grid.width - 1), j.min(grid.height - 1)));
        let along = |j: usize| at(i, j) + (at(i + 1, j) - at(i, j)) * (x - i as f64);
        (along(j) + (along(j + 1) - along(j)) * (y - j as f64)) as f32
    }

    fn corals(&self) -> impl Iterator<Item = (&Colony, &Body)> {
        self.plot.colonies().iter().filter_map(|c| Some((c, self.bodies.of(c.id)?)))
    }

    fn algae(&self) -> impl Iterator<Item = &Alga> {
        self.plot.algae().iter().filter(|a| a.height > 0.0)
    }

    /// Writes all bodies as GLB, OBJ or PLY.
    ///
    /// # Errors
    /// If nothing lives, or the file cannot be written.
    pub(super) fn write(&self, path: &Path, name: &str, format: ExportFormat) -> io::Result<()> {
        let species: &[Species] = &self.plot.community().species;
        let names: Vec<String> = self.corals().map(|(c, _)| label(c, species)).collect();
        let colours = vec![ALGAE; self.alga.positions.len()];
        let mut meshes: Vec<SceneMesh<'_>> = self
            .corals()
            .zip(&names)
            .map(|((c, b), name)| SceneMesh {
                name,
                positions: &b.solid.positions,
                normals: &b.solid.normals,
                colours: &b.colours,
                texture: &b.texture,
                indices: &b.solid.indices,
                material: usize::from(c.species),
            })
            .collect();
        let mut nodes: Vec<SceneNode> = self
            .corals()
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
            ExportFormat::CoralsObj => io::write_scene_obj(path, &scene),
            ExportFormat::CoralsPly => io::write_scene_ply(path, &scene),
            _ => io::write_scene_glb(path, &scene),
        }
    }

    fn node(&self, name: String, mesh: usize, [x, y]: [f32; 2], size: f32, extras: Value) -> SceneNode {
        SceneNode { name, mesh, place: [x, self.floor(x, y), y], turn: 0.0, size, extras }
    }

    /// Vertices and triangles of the corals' bodies.
    fn counts(&self) -> [u64; 2] {
        let count = |[v, t]: [u64; 2], s: &Solid| [v + s.positions.len() as u64, t + s.triangles() as u64];
        self.corals().map(|c| &c.1.solid).fold([0; 2], count)
    }

    /// Bytes that a file of all bodies takes while it is written: names and numbers of its nodes. Arrays are written as they are.
    fn file_bytes(&self) -> u128 {
        2048 * (self.plot.colonies().len() + self.plot.algae().len()) as u128
    }

    /// The reef as a diver sees it, and from above; the water is left out there, because colours are judged from above.
    fn views(&self) -> [MeshViewOptions; 2] {
        let (w, h) = (self.plot.site().width_m as f32, self.plot.site().length_m as f32);
        let middle = [0.5 * w, 0.5 * h, self.floor(0.5 * w, 0.5 * h)];
        let far = w.max(h);
        let side =
            Camera::looking([0.4 * w, h + 0.3 * far, middle[2] + 0.28 * far], [0.5 * w, 0.45 * h, middle[2]], 48.0);
        let above = Camera::looking([middle[0], middle[1] + 0.01, middle[2] + 1.3 * far], middle, 46.0);
        [MeshViewOptions::new(side, SIDE, Some(WATER)), MeshViewOptions::new(above, [ABOVE, ABOVE], None)]
    }

    /// Bytes that the larger picture takes while it is drawn: each alga is drawn by itself.
    fn picture_bytes(&self) -> u128 {
        let (algae, ground) = (self.algae().count() as u64, ((GROUND + 1) * (GROUND + 1)) as u64);
        let [vertices, triangles] = self.counts();
        let vertices = vertices + ground + algae * self.alga.positions.len() as u64;
        let triangles = triangles + 2 * ground + algae * self.alga.triangles() as u64;
        self.views().iter().map(|v| mesh_view_bytes(vertices, triangles, v)).fold(0, u128::max)
    }

    /// What [`Reef::views`] sees.
    fn pictures(&self) -> [Picture; 2] {
        let (ground, normals, triangles) = self.ground();
        let colours = vec![SAND; ground.len()];
        let fronds = vec![ALGAE; self.alga.positions.len()];
        let mut parts = vec![MeshPart {
            positions: &ground,
            normals: &normals,
            colours: &colours,
            indices: &triangles,
            place: [0.0; 3],
            turn: 0.0,
            size: 1.0,
            shades: false,
        }];
        parts.extend(self.corals().map(|(c, b)| MeshPart {
            positions: &b.solid.positions,
            normals: &b.solid.normals,
            colours: &b.colours,
            indices: &b.solid.indices,
            place: [c.x, c.y, self.floor(c.x, c.y)],
            turn: 0.0,
            size: 1.0,
            shades: true,
        }));
        parts.extend(self.algae().map(|a| MeshPart {
            positions: &self.alga.positions,
            normals: &self.alga.normals,
            colours: &fronds,
            indices: &self.alga.indices,
            place: [a.x, a.y, self.floor(a.x, a.y)],
            turn: turn(a),
            size: a.height,
            shades: true,
        }));
        self.views().map(|view| mesh_view(&parts, &view))
    }

    /// The sea floor as a mesh, and beyond the plot as far as water lets see, so that no edge is in the picture.
    fn ground(&self) -> (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<u32>) {
        let (w, h) = (self.plot.site().width_m as f32, self.plot.site().length_m as f32);
        let far = (2.0 * w.max(h)).max(SIGHT_M);
        const N: usize = GROUND;
        // Two thirds of the points are within the plot, and those beyond are denser near it.
        let place = |i: usize, side: f32| {
            let t = 3.0 * i as f32 / N as f32 - 1.0;
            match t {
                t if t < -0.5 => (2.0 * (t + 0.5)).powi(3) * far,
                t if t > 1.5 => side + (2.0 * (t - 1.5)).powi(3) * far,
                t => (t + 0.5) / 2.0 * side,
            }
        };
        let points = (0..=N).flat_map(|j| (0..=N).map(move |i| (place(i, w), place(j, h))));
        // Beyond the plot, the floor levels out.
        let middle = self.floor(0.5 * w, 0.5 * h);
        let floor = |x: f32, y: f32| {
            let outside = (-x).max(x - w).max(-y).max(y - h).max(0.0);
            middle + (self.floor(x, y) - middle) / (1.0 + (4.0 * outside / w.max(h)).powi(2))
        };
        let positions: Vec<[f32; 3]> = points.map(|(x, y)| [x, floor(x, y), y]).collect();
        let at = |i: usize, j: usize| positions[j.min(N) * (N + 1) + i.min(N)];
        let normals = (0..=N)
            .flat_map(|j| (0..=N).map(move |i| (i, j)))
            .map(|(i, j)| {
                let (e, w) = (at(i + 1, j), at(i.saturating_sub(1), j));
                let (s, n) = (at(i, j + 1), at(i, j.saturating_sub(1)));
                let slope = |a: [f32; 3], b: [f32; 3], k: usize| (a[1] - b[1]) / (a[k] - b[k]).max(1e-6);
                let normal = [-slope(e, w, 0), 1.0, -slope(s, n, 2)];
                let length = normal.iter().map(|v| v * v).sum::<f32>().sqrt();
                normal.map(|v| v / length)
            })
            .collect();
        let row = N as u32 + 1;
        let cells = (0..N as u32).flat_map(|j| (0..N as u32).map(move |i| j * row + i));
        let triangles = cells.flat_map(|c| [c, c + row, c + 1, c + 1, c + row, c + row + 1]).collect();
        (positions, normals, triangles)
    }
}

fn label(c: &Colony, species: &[Species]) -> String {
    format!("{} {}", species[usize::from(c.species)].name, c.id)
}

/// Macroalgae share a mesh and are turned, each by its own number.
fn turn(a: &Alga) -> f32 {
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

/// Writes what needs bodies: a file of meshes, or two pictures.
pub(super) fn write_bodies(
    job: &mut Job<'_>,
    corals: &Corals,
    format: ExportFormat,
    files: &[String],
) -> std::result::Result<(), RunError> {
    let reef = Reef::new(corals, job.world, job.limits).map_err(RunError::file)?;
    let held = Bodies::bytes(&reef.plot, Detail::default());
    let check = |what: &str, bytes: u128| need::check(what, job.world, held + bytes, job.limits, REMEDY);
    if format == ExportFormat::Dive {
        check("the pictures of corals", reef.picture_bytes()).map_err(RunError::file)?;
        for (name, picture) in files.iter().zip(reef.pictures()) {
            let path = job.file(name)?;
            io::write_rgb_png(&path, picture.width, picture.height, &picture.pixels).map_err(RunError::file)?;
        }
        return Ok(());
    }
    if reef.plot.colonies().is_empty() && reef.algae().next().is_none() {
        (job.note)(format!("`{}` is not written: nothing lives on the plot any more", files[0]));
        return Ok(());
    }
    check("the file of corals", reef.file_bytes()).map_err(RunError::file)?;
    let (name, path) = (job.name, job.file(&files[0])?);
    reef.write(&path, name, format).map_err(RunError::file)
}
