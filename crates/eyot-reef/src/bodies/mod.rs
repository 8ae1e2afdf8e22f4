//! Bodies of corals: one closed surface for each colony, with the volume and the footprint that the community gives it.
//!
//! A colony's rays make an outline, its species and its own random numbers a skeleton (`skeleton/`), the skeleton a field, and
//! the field a mesh (`eyot_mesh::mesh_field`). The colony of the next month is the same body, grown.
//!
//! ```
//! use eyot_reef::bodies::{Bodies, Detail};
//! use eyot_reef::community::{Community, Forcing, Plot, Site};
//!
//! let community = Community::default();
//! let forcing = Forcing::chumbe(&community, 1)?;
//! let mut plot = Plot::new(community, Site::flat(3.0, 3.0), forcing, 1)?;
//! plot.month()?;
//! let mut bodies = Bodies::new(plot.community(), 1, Detail::default())?;
//! bodies.update(&plot)?;
//! let topology = bodies.of(plot.colonies()[0].id).unwrap().solid.topology();
//! assert!(topology.is_closed_manifold() && topology.pieces == 1);
//! # Ok::<(), eyot_core::Error>(())
//! ```
//!
//! # Equations
//! 1. Volume: `solid_share 2/3 pi r^3`, `r` being the mean ray: what the community's limestone adds up to.
//! 2. Footprint: the polygon of the rays for massive competitors, the disc of the mean ray for branching ones, as the community
//!    has it. It is compared with the body's shadow straight down, or, for bodies with gaps, with the area within its farthest
//!    points in 24 directions.
//! 3. The thickness of branches is the isosurface that has the volume on a coarse lattice; then the body is stretched a little,
//!    along the ground and upwards, until both fit.
//!
//! # Source
//! The reef thesis, chapter 5; its bodies swell to 1.26 to 1.72 times their volume, and branching ones fall into pieces at its voxel
//! of 3 cm. Voxels here are at most 1.1 times as long as the thinnest branch's radius, whatever [`Detail`] asks for: a cylinder
//! with a radius of 0.87 voxels always contains a connected row of lattice points. Coarse bodies have fewer and thicker branches.

mod colour;
mod measure;
mod plan;

pub use plan::{BodyPlan, Shape};

use crate::community::{Colony, Community, Form, Plot, Rays, Species};
use crate::lsystem::{Grammar, Segment};
use crate::skeleton::{self, Chance, Cut, GRAMMARS, Outline, Plan, Relief, ReliefKind, skeleton};
use colour::Paint;
use eyot_core::rng::mix64;
use eyot_core::{Error, Limits, Result};
use eyot_mesh::{Blend, Blobs, Kernel, Lattice, MeshingOptions, Point, Primitive, ScalarField, Solid, mesh_field};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f32::consts::PI;
use std::sync::Arc;

/// How finely bodies are meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Longest voxel of solid bodies, m.
    pub solid_m: f32,
    /// Longest voxel of bodies with branches, columns or leaves, m.
    pub open_m: f32,
    /// Least voxels along a radius; twice as many for open bodies.
    pub per_radius: f32,
    /// Rounds of [`MeshingOptions`].
    pub rounds: u32,
}

impl Default for Detail {
    /// The source's voxels: 10 cm and 3 cm.
    fn default() -> Self {
        Self { solid_m: 0.1, open_m: 0.03, per_radius: 8.0, rounds: 1 }
    }
}

impl Detail {
    /// For pictures from near by.
    pub const fn fine() -> Self {
        Self { solid_m: 0.03, open_m: 0.012, per_radius: 24.0, rounds: 2 }
    }
}

/// A colony as bodies see it.
#[derive(Clone, Copy, Debug)]
pub struct ColonyShape<'a> {
    /// Number of the colony, to which its random numbers belong.
    pub id: u64,
    /// Number of its species.
    pub species: usize,
    /// Lengths of its rays, m.
    pub rays: &'a Rays,
    /// 1 fully bleached, 0 healthy.
    pub bleaching: f32,
    /// Rise of the ground to the east and to the south. The body is sheared along, which keeps volume and footprint.
    pub slope: [f32; 2],
}

/// The body of a colony. Places are m from its centre: x to the east, y up, z to the south.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The surface.
    pub solid: Solid,
    /// Linear red, green, blue and an alpha of 255 for each vertex.
    pub colours: Vec<[u8; 4]>,
    /// Spherical texture coordinates for each vertex.
    pub texture: Vec<[f32; 2]>,
    /// Length of the voxels that it was meshed with, m.
    pub voxel_m: f32,
    /// Volume and footprint, m3 and m2, and what they were to be.
    pub fit: Fit,
}

/// How well a body fits.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Fit {
    /// Volume, m3: what it is and what was wanted.
    pub volume: [f32; 2],
    /// Footprint, m2: what it is and what was wanted.
    pub footprint: [f32; 2],
    /// What the body was stretched by along the ground and upwards.
    pub stretch: [f32; 2],
}

impl Fit {
    /// Relative errors of volume and footprint.
    pub fn errors(&self) -> [f32; 2] {
        [self.volume, self.footprint].map(|[is, wanted]| (is / wanted - 1.0).abs())
    }
}

/// Makes bodies: the species' plans, ready to use.
pub struct Sculptor {
    species: Vec<Species>,
    grammars: Vec<Option<Grammar>>,
    seed: u64,
    detail: Detail,
}

const KERNEL: Kernel = Kernel::Muraki;
/// Bodies are stretched by at most this and its inverse.
const MAX_STRETCH: f32 = 1.8;
/// Voxels that bodies reach into the ground.
const FOOT: f32 = 0.25;
/// Voxels over the radius of the thinnest branch.
const VOXELS_PER_THICKNESS: f32 = 1.1;

impl Sculptor {
    /// # Errors
    /// If a grammar cannot be read, or a plan or the detail is out of its range.
    pub fn new(community: &Community, seed: u64, detail: Detail) -> Result<Self> {
        let positive = [detail.solid_m, detail.open_m, detail.per_radius].iter().all(|v| v.is_finite() && *v > 0.0);
        if !positive || detail.per_radius > 200.0 {
            return Err(bad("detail", "voxels must be longer than 0 and at most 200 along a radius".into()));
        }
        let grammar = |s: &Species| match s.body.shape {
            Shape::Branching => {
                let known = GRAMMARS.iter().find(|g| g.0 == s.body.grammar);
                Grammar::parse(known.map_or(s.body.grammar.as_str(), |g| g.1)).map(Some)
            }
            _ => Ok(None),
        };
        for s in &community.species {
            eyot_core::process::check_ranges(&format!("community.species `{}`.body", s.name), &s.body)?;
        }
        let grammars = community.species.iter().map(grammar).collect::<Result<_>>()?;
        Ok(Self { species: community.species.clone(), grammars, seed, detail })
    }

    /// The body of a colony.
    ///
    /// # Errors
    /// If rays are no finite numbers or all 0, if there is no such species, or if its grammar makes too much.
    pub fn body(&self, colony: &ColonyShape<'_>) -> Result<Body> {
        self.grown(colony, &mut None)
    }

    /// The body of a colony whose drawing is known from the month before, or made here.
    fn grown(&self, colony: &ColonyShape<'_>, drawing: &mut Option<Drawing>) -> Result<Body> {
        let Some(species) = self.species.get(colony.species) else {
            return Err(bad("species", format!("there is none of number {}", colony.species)));
        };
        let sound = colony.rays.iter().all(|r| r.is_finite() && *r >= 0.0) && colony.rays.iter().any(|r| *r > 1e-6);
        if !sound {
            return Err(bad("rays", "they must be finite lengths, not all of them 0".into()));
        }
        if !(colony.slope.iter().all(|s| s.is_finite()) && colony.bleaching.is_finite()) {
            return Err(bad("slope", "slope and bleaching must be finite numbers".into()));
        }
        let chance = Chance::new(self.seed, colony.id);
        let outline = Outline::new(colony.rays);
        let r = outline.radius;
        let volume = species.solid_share * 2.0 / 3.0 * PI * r * r * r;
        if let (None, Some(grammar)) = (&drawing, &self.grammars[colony.species]) {
            *drawing = Some(skeleton::drawing(grammar, chance)?.into());
        }
        let drawing = drawing.as_deref().unwrap_or_default();
        let (mut solid, voxel_m) = self.surface(colony.species, drawing, &outline, volume, chance)?;
        let fit = fit(&mut solid, species, &outline, volume);
        let top = solid.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
        let paint = Paint {
            colours: species.body.colours,
            bleaching: colony.bleaching,
            pale_ends: if species.body.shape.is_open() { 0.4 } else { 0.08 },
            chance,
        };
        let colours = colour::colours(&solid, r, top.max(1e-6), &paint);
        let texture = colour::texture(&solid);
        shear(&mut solid, colony.slope);
        Ok(Body { solid, colours, texture, voxel_m, fit })
    }

    /// The surface before it is fitted, and its voxel.
    fn surface(
        &self,
        number: usize,
        drawing: &[Segment],
        outline: &Outline,
        volume: f32,
        chance: Chance,
    ) -> Result<(Solid, f32)> {
        let plan = &self.species[number].body;
        let height = plan.height;
        let per_radius = self.detail.per_radius;
        let solid_voxel = self.detail.solid_m.min(outline.radius / per_radius);
        match plan.shape {
            Shape::Encrusting => self.relief(ReliefKind::Encrusting, height, outline, solid_voxel, chance),
            Shape::FreeLiving => self.relief(ReliefKind::FreeLiving, height, outline, solid_voxel, chance),
            Shape::Massive => {
                let plan = Plan::Massive { roughness: plan.roughness };
                let primitives = skeleton(&plan, outline, height, volume, chance);
                self.boulder(&primitives, outline, solid_voxel)
            }
            Shape::Branching | Shape::Columnar | Shape::Foliaceous | Shape::Laminar => {
                let voxel = self.detail.open_m.min(0.5 * outline.radius / per_radius);
                let thinnest = voxel / VOXELS_PER_THICKNESS;
                let plan = match plan.shape {
                    Shape::Columnar => Plan::Columnar,
                    Shape::Foliaceous => Plan::Foliaceous,
                    Shape::Laminar => Plan::Laminar,
                    _ => Plan::Branching { drawing, full_radius: self.species[number].max_radius, thinnest },
                };
                let primitives = skeleton(&plan, outline, height, volume, chance);
                self.open(&primitives, volume, voxel)
            }
        }
    }

    /// A body that is a height over the ground.
    fn relief(
        &self,
        kind: ReliefKind,
        height: f32,
        outline: &Outline,
        voxel: f32,
        chance: Chance,
    ) -> Result<(Solid, f32)> {
        let height = height * outline.radius;
        let voxel = voxel.min(0.5 * height);
        let relief = Relief::new(outline, kind, height, chance);
        let cut = Cut { field: Box::new(relief), outline: None, foot: FOOT * voxel, steepness: 1.0 / height };
        let reach = 1.05 * outline.rays.iter().copied().fold(0.0, f32::max);
        mesh(&cut, [[-reach, -voxel, -reach], [reach, 1.5 * height, reach]], voxel, self.detail.rounds)
    }

    /// A solid body within its outline.
    fn boulder(&self, primitives: &[Primitive], outline: &Outline, voxel: f32) -> Result<(Solid, f32)> {
        let r = outline.radius;
        let blobs = Blobs::new(primitives, KERNEL, Blend::Normalised, &Limits::default()).map_err(meshing)?;
        // A kernel's slope at 1/2 is 0.83 over the radius of the ball, about 0.3 of the body's.
        let cut = Cut { field: Box::new(blobs), outline: Some(outline), foot: FOOT * voxel, steepness: 2.5 / r };
        let reach = 1.2 * outline.rays.iter().copied().fold(0.0, f32::max);
        mesh(&cut, [[-reach, -voxel, -reach], [reach, 2.0 * r, reach]], voxel, self.detail.rounds)
    }

    /// A body of thin parts, so thick that it has the volume.
    fn open(&self, primitives: &[Primitive], volume: f32, voxel: f32) -> Result<(Solid, f32)> {
        let blobs = Blobs::new(primitives, KERNEL, Blend::Normalised, &Limits::default()).map_err(meshing)?;
        let Some([low, high]) = blobs.bounds() else { return Ok((Solid::default(), voxel)) };
        let thin = |p: &Primitive| p.radii[0].min(p.radii[1]);
        let thinnest = primitives.iter().map(thin).fold(f32::INFINITY, f32::min);
        let mean = primitives.iter().map(thin).sum::<f32>() / primitives.len() as f32;
        // Finer sampling would say nothing new.
        let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
        let spacing = (1.5 * voxel).min(1.2 * mean).max(size / 250.0);
        let iso = measure::iso_of_volume(&blobs, KERNEL, volume, spacing, mean);
        let factor = KERNEL.radius_of(iso) / KERNEL.radius_of(0.5);
        let voxel = voxel.min(VOXELS_PER_THICKNESS * factor * thinnest);
        let field = Box::new(blobs.with_iso(iso));
        let cut = Cut { field, outline: None, foot: FOOT * voxel, steepness: 0.8 / mean };
        mesh(&cut, [[low[0], -voxel, low[2]], high], voxel, self.detail.rounds)
    }
}

/// The largest piece of a field's surface, and the voxel.
fn mesh(field: &dyn ScalarField, [low, high]: [Point; 2], voxel: f32, rounds: u32) -> Result<(Solid, f32)> {
    let limits = Limits::default();
    let lattice = Lattice::over(low, high, voxel, &limits).map_err(meshing)?;
    let solid = mesh_field(field, &lattice, &MeshingOptions { rounds }, &limits).map_err(meshing)?;
    Ok((solid.largest_piece(), voxel))
}

/// Stretches a body until it has the wanted volume and footprint.
fn fit(solid: &mut Solid, species: &Species, outline: &Outline, volume: f32) -> Fit {
    let footprint = match species.form {
        Form::Massive => outline.area(),
        Form::Branching => PI * outline.radius * outline.radius,
    };
    let covered = if species.body.shape.is_open() { measure::hull(solid) } else { measure::shadow(solid) };
    let has = solid.volume() as f32;
    let within = |v: f32| if v.is_finite() { v.clamp(1.0 / MAX_STRETCH, MAX_STRETCH) } else { 1.0 };
    let wide = within((footprint / covered).sqrt());
    let tall = within(volume / (has * wide * wide));
    for p in &mut solid.positions {
        *p = [p[0] * wide, p[1] * tall, p[2] * wide];
    }
    for n in &mut solid.normals {
        // Normals go with the inverse.
        *n = unit([n[0] / wide, n[1] / tall, n[2] / wide]);
    }
    Fit {
        volume: [has * wide * wide * tall, volume],
        footprint: [covered * wide * wide, footprint],
        stretch: [wide, tall],
    }
}

/// Lets a body stand on sloping ground.
fn shear(solid: &mut Solid, [east, south]: [f32; 2]) {
    if (east, south) == (0.0, 0.0) {
        return;
    }
    for (p, n) in solid.positions.iter_mut().zip(&mut solid.normals) {
        p[1] += east * p[0] + south * p[2];
        *n = unit([n[0] - east * n[1], n[1], n[2] - south * n[1]]);
    }
}

fn unit(v: Point) -> Point {
    let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
    if length > 0.0 { v.map(|c| c / length) } else { [0.0, 1.0, 0.0] }
}

fn bad(field: &str, reason: String) -> Error {
    Error::BadParameter { owner: "bodies".into(), field: field.into(), reason }
}

fn meshing(e: eyot_mesh::Error) -> Error {
    match e {
        eyot_mesh::Error::Core(e) => e,
        other => bad("body", other.to_string()),
    }
}

/// Triangles over the square of the voxels along a radius, at most, of bodies with gaps and of others.
const OPEN_TRIANGLES: f32 = 110.0;
const SOLID_TRIANGLES: f32 = 60.0;
/// Bytes of a triangle and of half a vertex: place, normal, colour, texture; those of a drawing.
const BYTES_PER_TRIANGLE: f64 = 12.0 + 0.5 * 36.0;
const DRAWING: u128 = 128 << 10;

/// What a grammar draws for a colony.
type Drawing = Arc<[Segment]>;

/// What is known of a colony from its last month.
#[derive(Clone)]
struct Known {
    stamp: u64,
    body: Arc<Body>,
    drawing: Option<Drawing>,
}

/// The bodies of a plot, of which only those are meshed again whose colony has changed.
pub struct Bodies {
    sculptor: Sculptor,
    bodies: HashMap<u64, Known>,
}

impl Bodies {
    /// # Errors
    /// As [`Sculptor::new`].
    pub fn new(community: &Community, seed: u64, detail: Detail) -> Result<Self> {
        Ok(Self { sculptor: Sculptor::new(community, seed, detail)?, bodies: HashMap::new() })
    }

    /// Bytes that the bodies of a plot hold at most, with what making one takes on each thread: what to ask a limit for before
    /// they are made.
    pub fn bytes(plot: &Plot, detail: Detail) -> u128 {
        let of = |colony: &Colony| {
            let open = plot.community().species[usize::from(colony.species)].body.shape.is_open();
            let (voxel, least, triangles, drawing) = if open {
                (detail.open_m, 2.0 * detail.per_radius, OPEN_TRIANGLES, DRAWING)
            } else {
                (detail.solid_m, detail.per_radius, SOLID_TRIANGLES, 0)
            };
            let voxels = (colony.radius / voxel).max(least);
            (f64::from(triangles * voxels * voxels) * BYTES_PER_TRIANGLE) as u128 + drawing
        };
        let (sum, most) = plot.colonies().iter().map(of).fold((0, 0), |(sum, most), n| (sum + n, n.max(most)));
        // Samples, vertices, neighbours and blocks, while they move.
        sum + 8 * most * rayon::current_num_threads() as u128
    }

    /// Follows the plot: makes bodies of new colonies and of those that grew, bleached or recovered, and forgets the dead. Returns
    /// how many it made.
    ///
    /// # Errors
    /// As [`Sculptor::body`].
    pub fn update(&mut self, plot: &Plot) -> Result<usize> {
        let make = |(colony, rays): (&Colony, &Rays)| -> Result<(u64, Known, bool)> {
            let stamp = stamp(colony, rays);
            let known = self.bodies.get(&colony.id);
            if let Some(known) = known.filter(|k| k.stamp == stamp) {
                return Ok((colony.id, known.clone(), false));
            }
            let shape = ColonyShape {
                id: colony.id,
                species: usize::from(colony.species),
                rays,
                bleaching: colony.bleaching,
                slope: [0.0; 2],
            };
            let mut drawing = known.and_then(|k| k.drawing.clone());
            let body = Arc::new(self.sculptor.grown(&shape, &mut drawing)?);
            Ok((colony.id, Known { stamp, body, drawing }, true))
        };
        let all: Vec<_> =
            plot.colonies().par_iter().zip(plot.rays()).with_max_len(1).map(make).collect::<Result<_>>()?;
        let made = all.iter().filter(|b| b.2).count();
        self.bodies = all.into_iter().map(|(id, known, _)| (id, known)).collect();
        Ok(made)
    }

    /// The body of a colony.
    pub fn of(&self, colony: u64) -> Option<&Body> {
        self.bodies.get(&colony).map(|k| k.body.as_ref())
    }
}

/// A number that changes with all that a colony's body depends on.
fn stamp(colony: &Colony, rays: &Rays) -> u64 {
    let numbers = rays.iter().chain([&colony.bleaching]);
    numbers.fold(u64::from(colony.species), |stamp, v| mix64(stamp ^ u64::from(v.to_bits())))
}
