//! Trees as points: where each stands, what it is and how large, from the layers `forest` and `tree_size`, or from the cohorts of the
//! process `plants`, whose types, heights and ages they then have.
//!
//! A square lattice, finer than trees stand apart, has a candidate in each of its squares, at a place and with a rank that follow from the seed
//! and the number of the square. Those outside of the forest are left out. Then, in [`ROUNDS`] rounds, each candidate that has the
//! highest rank within the distance of trees is kept, and what stands closer to it is left out. So no two trees stand closer than the distance
//! (a Poisson disk; Bridson 2007), nothing of the lattice is seen, and a tree depends on what is within some distances around it alone: it is the same
//! whatever window is asked for, and on any number of threads.

use crate::stands::Stands;
use eyot_core::component::{Points, Type};
use eyot_core::rng::{Key, hash, unit};
use eyot_core::{Field, Result, World};
use eyot_noise::picture::fbm;
use rayon::prelude::*;

/// What a tree looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// Spruces, firs, larches: a cone.
    Conifer,
    /// Beeches, oaks, birches: a round crown.
    Broadleaf,
    /// Palms: a bare trunk with fronds at its top.
    Palm,
    /// Mountain pine, alder and other shrubs: as wide as high.
    Shrub,
}

impl Kind {
    /// All, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Conifer, Self::Broadleaf, Self::Palm, Self::Shrub];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Conifer => "conifer",
            Self::Broadleaf => "broadleaf",
            Self::Palm => "palm",
            Self::Shrub => "shrub",
        }
    }

    /// Height of the full-grown, m, and radius of the crown over the height.
    const fn shape(self) -> [f32; 2] {
        match self {
            Self::Conifer => [27.0, 0.15],
            Self::Broadleaf => [21.0, 0.27],
            Self::Palm => [17.0, 0.19],
            Self::Shrub => [6.0, 0.45],
        }
    }
}

/// A tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tree {
    /// Number of the square that it stands in: the same in every window.
    pub id: u64,
    /// What it looks like.
    pub kind: Kind,
    /// The type of plants that it belongs to, its number in [`TYPES`](crate::types::TYPES), where the world has types.
    pub species: Option<u8>,
    /// Where it stands: m east of the grid's west side, m south of its north side, height of the ground, m.
    pub place: [f32; 3],
    /// Height, m.
    pub height: f32,
    /// Radius of the crown, m.
    pub crown: f32,
    /// Age, years.
    pub age: f32,
    /// Turn about the upright axis, rad.
    pub yaw: f32,
}

/// Distance that trees keep, m.
pub const DISTANCE_M: f32 = 5.5;
/// Side of the lattice's squares over that distance: candidates beyond two squares are farther apart than trees.
const SIDE: f32 = 0.55;
/// How far trees look at each other, squares.
const NEAR: i64 = 2;
/// Rounds in which trees are kept. More would find place for a few more.
pub const ROUNDS: usize = 3;
/// Squares around a window that decide what stands in it.
const MARGIN: i64 = 2 * NEAR * ROUNDS as i64;
/// Most squares of a window.
const MAX_SQUARES: u64 = 1 << 27;
/// Size of patches of one kind, m.
const PATCH_M: f32 = 160.0;
/// Highest rank of candidates that are no trees.
const NONE: u32 = 0;

/// Streams of random numbers.
const RANK: u32 = 0x7472_6501;
const EAST: u32 = 0x7472_6502;
const SOUTH: u32 = 0x7472_6503;
const SHARE: u32 = 0x7472_6504;
const SIZE: u32 = 0x7472_6505;
const KIND: u32 = 0x7472_6506;
const YAW: u32 = 0x7472_6507;

/// The forest of a world.
pub struct Trees<'a> {
    world: &'a World,
    height: &'a Field,
    forest: &'a Field,
    size: Option<&'a Field>,
    warmth: Option<&'a Field>,
    /// Bushes, where the world has cohorts.
    shrubs: Option<&'a Field>,
    stands: Option<Stands<'a>>,
}

impl<'a> Trees<'a> {
    /// The trees of a world that has the layers `height` and `forest`; `None` for others.
    pub fn of(world: &'a World) -> Option<Self> {
        let stands = Stands::of(world);
        Some(Self {
            world,
            height: world.get("height")?,
            forest: world.get(&crate::FOREST.name)?,
            size: world.get(&crate::TREE_SIZE.name),
            warmth: world.get("temperature_mean"),
            shrubs: stands.as_ref().and_then(|_| world.get(&crate::layers::SHRUBS.name)),
            stands,
        })
    }

    /// How many trees there will be at most, roughly.
    pub fn most(&self) -> u64 {
        let covered = self.forest.sum() + self.shrubs.map_or(0.0, Field::sum);
        let area = covered * self.world.grid.cell_area_m2();
        (area / f64::from(DISTANCE_M * DISTANCE_M) * 0.85) as u64
    }

    /// True if the squares of the whole grid are not too many to be asked for at once.
    pub fn fits(&self) -> bool {
        let [w, h] = self.sides();
        let side = f64::from(DISTANCE_M * SIDE);
        ((f64::from(w) / side) * (f64::from(h) / side)) as u64 <= MAX_SQUARES
    }

    /// Extent of the grid, m.
    fn sides(&self) -> [f32; 2] {
        let g = &self.world.grid;
        [(g.width as f64 * g.cell_x_m) as f32, (g.height as f64 * g.cell_y_m) as f32]
    }

    /// All trees of the grid, row by row from the north-west.
    pub fn all(&self) -> Vec<Tree> {
        self.within([[0.0, 0.0], self.sides()])
    }

    /// The trees whose feet are within a window: its north-western and south-eastern corner, m from the grid's north-western one.
    pub fn within(&self, [low, high]: [[f32; 2]; 2]) -> Vec<Tree> {
        let side = DISTANCE_M * SIDE;
        let sides = self.sides();
        let [low, high] = [low, high].map(|p| [p[0].clamp(0.0, sides[0]), p[1].clamp(0.0, sides[1])]);
        let first = low.map(|v| (v / side).floor() as i64 - MARGIN);
        let last = high.map(|v| (v / side).ceil() as i64 + MARGIN);
        let (width, height) = ((last[0] - first[0]) as usize, (last[1] - first[1]) as usize);
        let lattice = Lattice { trees: self, first, width, height, side };
        let mut ranks = vec![NONE; width * height];
        ranks.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            row.iter_mut().enumerate().for_each(|(x, rank)| *rank = lattice.rank(x, y));
        });
        let mut kept = vec![false; width * height];
        for _ in 0..ROUNDS {
            lattice.round(&mut ranks, &mut kept);
        }
        let rows: Vec<Vec<Tree>> = kept
            .par_chunks(width)
            .enumerate()
            .map(|(y, row)| {
                let stand = row.iter().enumerate().filter(|(_, kept)| **kept).map(|(x, _)| lattice.tree(x, y));
                let inside =
                    |t: &Tree| (low[0]..high[0]).contains(&t.place[0]) && (low[1]..high[1]).contains(&t.place[1]);
                stand.filter(inside).collect()
            })
            .collect();
        rows.concat()
    }

    /// Share of the ground that trees and bushes cover at a place.
    fn cover(&self, x: f32, y: f32) -> f32 {
        let trees = self.at(self.forest, x, y);
        self.shrubs.map_or(trees, |shrubs| trees + (1.0 - trees) * self.at(shrubs, x, y))
    }

    /// A layer's value at a place, between the middles of four cells.
    fn at(&self, field: &Field, x: f32, y: f32) -> f32 {
        let g = &self.world.grid;
        let place = |v: f32, cell: f64, n: usize| (v / cell as f32 - 0.5).clamp(0.0, (n - 1) as f32);
        let (u, v) = (place(x, g.cell_x_m, g.width), place(y, g.cell_y_m, g.height));
        let (i, j) = (u as usize, v as usize);
        let (i1, j1) = ((i + 1).min(g.width - 1), (j + 1).min(g.height - 1));
        let (fx, fy) = (u - i as f32, v - j as f32);
        let north = field.get(i, j) * (1.0 - fx) + field.get(i1, j) * fx;
        let south = field.get(i, j1) * (1.0 - fx) + field.get(i1, j1) * fx;
        north * (1.0 - fy) + south * fy
    }
}

/// The squares of a window and its margin.
struct Lattice<'a> {
    trees: &'a Trees<'a>,
    first: [i64; 2],
    width: usize,
    height: usize,
    side: f32,
}

impl Lattice<'_> {
    /// 32 random bits of a square of the whole lattice.
    fn bits(&self, stream: u32, [x, y]: [i64; 2]) -> u32 {
        let row = hash(Key::new(self.trees.world.seed, stream, 0), y as u32);
        hash(Key { low: row, high: stream }, x as u32)
    }

    fn number(&self, stream: u32, square: [i64; 2]) -> f32 {
        unit::<f32>(self.bits(stream, square))
    }

    fn square(&self, x: usize, y: usize) -> [i64; 2] {
        [self.first[0] + x as i64, self.first[1] + y as i64]
    }

    /// Where the candidate of a square stands, m.
    fn place(&self, square: [i64; 2]) -> [f32; 2] {
        let at = |i: i64, stream: u32| (i as f32 + self.number(stream, square)) * self.side;
        [at(square[0], EAST), at(square[1], SOUTH)]
    }

    /// The rank of a square's candidate; [`NONE`] where no tree can stand.
    fn rank(&self, x: usize, y: usize) -> u32 {
        let (square, t) = (self.square(x, y), self.trees);
        let ([px, py], [w, h]) = (self.place(square), t.sides());
        let inside = px >= 0.0 && py >= 0.0 && px < w && py < h;
        if !inside || self.number(SHARE, square) >= t.cover(px, py) {
            return NONE;
        }
        self.bits(RANK, square).max(NONE + 1)
    }

    /// Squares around one, itself left out.
    fn around(&self, x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let near = NEAR as usize;
        let (xs, ys) = (
            x.saturating_sub(near)..(x + near + 1).min(self.width),
            y.saturating_sub(near)..(y + near + 1).min(self.height),
        );
        ys.flat_map(move |j| xs.clone().map(move |i| (i, j))).filter(move |p| *p != (x, y))
    }

    fn close(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        let (p, q) = (self.place(self.square(a.0, a.1)), self.place(self.square(b.0, b.1)));
        (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) < DISTANCE_M * DISTANCE_M
    }

    /// Keeps the highest of those that are left, and leaves out what is too close to them.
    fn round(&self, ranks: &mut Vec<u32>, kept: &mut [bool]) {
        let at = |ranks: &[u32], (x, y): (usize, usize)| ranks[y * self.width + x];
        let new: Vec<bool> = (0..self.width * self.height)
            .into_par_iter()
            .map(|i| {
                let here = (i % self.width, i / self.width);
                // Of two that have the same rank, the first one stands.
                let higher = |p: (usize, usize)| (at(ranks, p), i) > (ranks[i], p.1 * self.width + p.0);
                ranks[i] != NONE
                    && !self.around(here.0, here.1).any(|p| at(ranks, p) != NONE && higher(p) && self.close(here, p))
            })
            .collect();
        let left: Vec<u32> = (0..self.width * self.height)
            .into_par_iter()
            .map(|i| {
                let here = (i % self.width, i / self.width);
                let taken = |p: (usize, usize)| new[p.1 * self.width + p.0] && self.close(here, p);
                if ranks[i] == NONE || new[i] || self.around(here.0, here.1).any(taken) { NONE } else { ranks[i] }
            })
            .collect();
        *ranks = left;
        kept.iter_mut().zip(new).for_each(|(kept, new)| *kept |= new);
    }

    fn tree(&self, x: usize, y: usize) -> Tree {
        let (square, t) = (self.square(x, y), self.trees);
        let [px, py] = self.place(square);
        let size = t.size.map_or(1.0, |f| t.at(f, px, py)).clamp(0.02, 1.0);
        // Kinds keep together: what stands around is of the same kind more often than not.
        let patch = fbm(px / PATCH_M, py / PATCH_M, 3, t.world.seed as u32 ^ KIND);
        let mixed = (0.5 + 0.9 * patch + 0.4 * (self.number(KIND, square) - 0.5)).clamp(0.0, 0.999);
        let kind = kind(size, t.warmth.map(|f| t.at(f, px, py)), mixed);
        let vigour = self.number(SIZE, square);
        let stands = t.stands.as_ref().and_then(|stands| stands.at([px, py], self.number(KIND, square), vigour));
        let kind = stands.as_ref().map_or(kind, |s| s.kind);
        let [full, crown] = kind.shape();
        let height = stands.as_ref().map_or(full * size * (0.55 + 0.55 * vigour), |s| s.height);
        let age = stands.as_ref().map_or(15.0 + 185.0 * vigour * vigour, |s| s.age);
        let sides = (t.world.grid.width as f64 * t.world.grid.cell_x_m / f64::from(self.side)) as u64 + 2;
        Tree {
            id: square[1] as u64 * sides + square[0] as u64,
            kind,
            species: stands.map(|s| s.number as u8),
            place: [px, py, t.at(t.height, px, py)],
            height,
            // Crowns of neighbours reach into each other a little.
            crown: (crown * height * (0.85 + 0.3 * self.number(YAW, square))).min(0.7 * DISTANCE_M),
            age,
            yaw: std::f32::consts::TAU * self.number(YAW, square),
        }
    }
}

/// What grows where trees reach this share of their full size, at this mean temperature (°C) if it is known.
fn kind(size: f32, warmth: Option<f32>, u: f32) -> Kind {
    // Without a climate, trees that stay small stand where it is cold.
    let warmth = warmth.unwrap_or(1.0 + 9.0 * size);
    if size < 0.3 && u < 0.5 {
        Kind::Shrub
    } else if warmth > 20.0 {
        if u < 0.35 { Kind::Palm } else { Kind::Broadleaf }
    } else if u < ((warmth - 6.0) / 6.0).clamp(0.0, 0.9) {
        Kind::Broadleaf
    } else {
        Kind::Conifer
    }
}

/// Trees as points with attributes, for tables.
///
/// # Errors
/// If a height is not finite.
pub fn points(trees: &[Tree]) -> Result<Points> {
    let mut columns = vec![
        ("id", "1", Type::U64),
        ("kind", "1", Type::U8),
        ("height", "m", Type::F32),
        ("crown", "m", Type::F32),
        ("age", "a", Type::F32),
        ("yaw", "rad", Type::F32),
    ];
    let with_species = trees.iter().any(|t| t.species.is_some());
    columns.extend(with_species.then_some(("species", "1", Type::U8)));
    let mut points = Points::new(columns);
    for t in trees {
        let row = [
            t.id as f64,
            f64::from(t.kind as u8),
            t.height.into(),
            t.crown.into(),
            t.age.into(),
            t.yaw.into(),
            t.species.unwrap_or_default().into(),
        ];
        points.push(t.place, &row[..if with_species { 7 } else { 6 }])?;
    }
    Ok(points)
}
