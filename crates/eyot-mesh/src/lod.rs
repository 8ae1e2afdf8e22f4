//! Coarser levels of a terrain mesh, by edge collapses that leave the rim in place, or on its straight lines.
//!
//! The simplifier at hand (`meshopt`) works on solids: it refuses collapses that turn a triangle by more than 75 degrees,
//! which on steep ground still lets triangles fold under each other in several collapses. So it is shown a flattened copy,
//! in which a triangle that turns over turns by nearly 180 degrees, and whose distances are vertical ones. Rounding can
//! still let a sliver through; corners of such triangles are locked and the level is made again.

use crate::simplifier;
use crate::terrain::{Attribute, Terrain, TerrainMesh};
use eyot_core::{Control, Result};
use rayon::prelude::*;

/// A level counts as coarser only if it saves at least this share of triangles; with the rim locked, small meshes
/// stop shrinking, and a level that saves less is not worth its memory.
const WORTHWHILE: f64 = 0.9;
/// Root mean square of the slopes of the flattened copy. Measured on the terrains of the tests: at slopes of 0.3, hundreds
/// of triangles fold at a quarter of their number, at 0.1 tens, at 0.01 hardly one and then in the plane alone. Errors are
/// the same; at 0.001 they grow, because heights drown in the simplifier's preference for even triangles.
const FLATTENED_SLOPE: f64 = 0.01;
/// Attempts at a level without folded triangles.
const ATTEMPTS: usize = 12;

/// One level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Lod {
    /// The mesh; every vertex is used by a triangle, and every triangle faces up.
    pub mesh: TerrainMesh,
    /// Share of the full mesh's triangles that this level has, in 0..=1.
    pub ratio: f64,
    /// Largest vertical distance from a vertex of the full mesh, m.
    pub error_m: f32,
}

/// What coarser levels may do to the rim of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rim {
    /// Nothing: all levels of neighbouring tiles fit together.
    #[default]
    Fixed,
    /// Leave out vertices of its four straight sides, but not the corners. Tiles of different levels then need a skirt
    /// ([`crate::Tiling::skirt`]), and small tiles get much coarser levels.
    Straight,
}

/// The mesh itself and coarser levels of it, finest first.
///
/// `ratios` are shares of the full mesh's triangles to aim at, in falling order, for example `[0.25, 0.0625]`. Level 0
/// is the full mesh with its triangles ordered for the vertex cache. Vertices on the rim never move, so tiles of one
/// landscape fit together at any mix of levels. Seen from above, a level covers the same area once, like the full mesh.
/// Levels that the locked rim keeps from getting markedly smaller are left out, so there may be fewer levels than ratios;
/// values outside 0..1 are left out, too.
pub fn levels_of_detail(terrain: &Terrain, ratios: &[f64]) -> Vec<Lod> {
    // Without anybody to stop it, it comes to its end.
    levels_of_detail_controlled(terrain, ratios, Rim::Fixed, &Control::none()).unwrap_or_default()
}

/// As [`levels_of_detail`], with a choice about the rim; can be stopped between two levels.
///
/// # Errors
/// On a request to stop.
pub fn levels_of_detail_controlled(
    terrain: &Terrain,
    ratios: &[f64],
    rim: Rim,
    control: &Control<'_>,
) -> Result<Vec<Lod>> {
    let full = terrain.mesh.triangles();
    let mut levels = vec![Lod { mesh: compact(&terrain.mesh, &terrain.mesh.indices), ratio: 1.0, error_m: 0.0 }];
    if full == 0 {
        return Ok(levels);
    }
    for &ratio in ratios.iter().filter(|r| (0.0..1.0).contains(*r)) {
        control.check()?;
        let finer = &levels[levels.len() - 1].mesh;
        let target = 3 * ((full as f64 * ratio) as usize).max(1);
        let Some(indices) = simplify(finer, target, rim) else { continue };
        if indices.is_empty() || indices.len() as f64 >= WORTHWHILE * finer.indices.len() as f64 {
            continue;
        }
        let mesh = compact(finer, &indices);
        let error_m = vertical_error(terrain, &mesh);
        levels.push(Lod { ratio: mesh.triangles() as f64 / full as f64, mesh, error_m });
    }
    Ok(levels)
}

/// Indices of about `target` length whose triangles all face up, or `None` if that failed.
fn simplify(mesh: &TerrainMesh, target: usize, rim: Rim) -> Option<Vec<u32>> {
    let flat = flattened(mesh);
    let how = |locked: &[bool]| simplifier::simplify_open(&mesh.indices, &flat, locked, target, rim == Rim::Fixed);
    without_folds(mesh, corners(&flat), how)
}

/// What `how` makes of a mesh, some of whose vertices are locked, with more of them locked as long as triangles fold.
pub(crate) fn without_folds(
    mesh: &TerrainMesh,
    mut locked: Vec<bool>,
    how: impl Fn(&[bool]) -> Option<Vec<u32>>,
) -> Option<Vec<u32>> {
    for _ in 0..ATTEMPTS {
        let indices = how(&locked)?;
        let folded: Vec<&[u32]> = indices.chunks_exact(3).filter(|t| area_from_above(mesh, t) <= 0.0).collect();
        if folded.is_empty() {
            return Some(indices);
        }
        // The neighbours as well: a collapse beside the sliver made it.
        let mut near = vec![false; locked.len()];
        folded.into_iter().flatten().for_each(|&i| near[i as usize] = true);
        for t in mesh.indices.chunks_exact(3).filter(|t| t.iter().any(|&i| near[i as usize])) {
            t.iter().for_each(|&i| locked[i as usize] = true);
        }
    }
    None
}

/// Which vertices are the four corners of a rectangle.
fn corners(positions: &[[f32; 3]]) -> Vec<bool> {
    let range = |axis: usize| {
        let along = positions.iter().map(move |p| p[axis]);
        [along.clone().fold(f32::INFINITY, f32::min), along.fold(f32::NEG_INFINITY, f32::max)]
    };
    let (easts, souths) = (range(0), range(2));
    positions.iter().map(|p| easts.contains(&p[0]) && souths.contains(&p[2])).collect()
}

/// The positions with heights in another unit, in which slopes are gentle.
fn flattened(mesh: &TerrainMesh) -> Vec<[f32; 3]> {
    let (mut rises, mut runs) = (0.0, 0.0);
    for t in mesh.indices.chunks_exact(3) {
        let [a, b] = [t[0], t[1]].map(|i| mesh.positions[i as usize].map(f64::from));
        rises += (a[1] - b[1]).powi(2);
        runs += (a[0] - b[0]).powi(2) + (a[2] - b[2]).powi(2);
    }
    let slope = (rises / runs).sqrt();
    let unit = if slope > 0.0 { (FLATTENED_SLOPE / slope) as f32 } else { 1.0 };
    mesh.positions.iter().map(|p| [p[0], p[1] * unit, p[2]]).collect()
}

/// Twice the area of a triangle as seen from above, in m^2; negative if it faces down.
fn area_from_above(mesh: &TerrainMesh, triangle: &[u32]) -> f64 {
    let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|i| flat(mesh.positions[i as usize]));
    cross(a, b, c)
}

/// East and south of a position. Differences of `f32` are exact in `f64`.
fn flat(p: [f32; 3]) -> [f64; 2] {
    [p[0].into(), p[2].into()]
}

/// Twice the area of a triangle of points in the plane, positive as glTF's fronts are seen from above.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[1] - a[1]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// The largest vertical distance of a vertex of the full mesh from a level, m.
fn vertical_error(full: &Terrain, level: &TerrainMesh) -> f32 {
    let (columns, positions) = (full.columns, &full.mesh.positions);
    let easts: Vec<f64> = positions[..columns].iter().map(|p| p[0].into()).collect();
    let souths: Vec<f64> = positions.iter().step_by(columns).map(|p| p[2].into()).collect();
    let between = |list: &[f64], values: [f64; 3]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        list.partition_point(|&v| v < low)..list.partition_point(|&v| v <= high)
    };
    let of_triangle = |t: &[u32]| -> f64 {
        let corners = [t[0], t[1], t[2]].map(|i| level.positions[i as usize]);
        let [a, b, c] = corners.map(flat);
        let area = cross(a, b, c);
        let mut most = 0.0f64;
        for row in between(&souths, [a[1], b[1], c[1]]) {
            for column in between(&easts, [a[0], b[0], c[0]]) {
                let p = [easts[column], souths[row]];
                let weights = [cross(p, b, c), cross(a, p, c), cross(a, b, p)];
                if weights.iter().all(|&w| w >= 0.0) {
                    let height: f64 = weights.iter().zip(corners).map(|(w, v)| w * f64::from(v[1])).sum();
                    most = most.max((height / area - f64::from(positions[row * columns + column][1])).abs());
                }
            }
        }
        most
    };
    level.indices.par_chunks_exact(3).map(of_triangle).reduce(|| 0.0, f64::max) as f32
}

/// The given triangles, ordered for the vertex cache, with the vertices that they use in order of first use.
pub(crate) fn compact(mesh: &TerrainMesh, indices: &[u32]) -> TerrainMesh {
    let ordered = simplifier::order_for_cache(indices, mesh.positions.len());
    let mut new_index = vec![u32::MAX; mesh.positions.len()];
    let mut used = Vec::with_capacity(mesh.positions.len().min(ordered.len()));
    let indices = ordered
        .into_iter()
        .map(|old| {
            let slot = &mut new_index[old as usize];
            if *slot == u32::MAX {
                *slot = used.len() as u32;
                used.push(old as usize);
            }
            *slot
        })
        .collect();
    TerrainMesh {
        positions: used.iter().map(|&i| mesh.positions[i]).collect(),
        normals: used.iter().map(|&i| mesh.normals[i]).collect(),
        // Water has one colour, that of its material.
        colours: used.iter().filter_map(|&i| mesh.colours.get(i).copied()).collect(),
        texture: used.iter().map(|&i| mesh.texture[i]).collect(),
        attributes: mesh
            .attributes
            .iter()
            .map(|a| Attribute { name: a.name.clone(), values: used.iter().map(|&i| a.values[i]).collect() })
            .collect(),
        indices,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::{MeshOptions, terrain};
    use eyot_core::{Boundary, Field, Grid, Limits};
    use std::collections::{BTreeMap, BTreeSet};

    fn land(w: usize, h: usize, cell: (f64, f64), height: impl FnMut(usize, usize) -> f32) -> Terrain {
        let grid = Grid { cell_y_m: cell.1, ..Grid::new(w, h, cell.0, Boundary::CLOSED, &Limits::default()).unwrap() };
        let grey = vec![[0.5; 3]; w * h];
        let height = Field::from_fn(w, h, height);
        terrain(&height, &grid, &grey, &MeshOptions::default(), &Limits::default()).unwrap()
    }

    fn hills(n: usize) -> Terrain {
        land(n, n, (10.0, 10.0), |x, y| 40.0 * ((x as f32 * 0.15).sin() + (y as f32 * 0.11).cos()))
    }

    /// A number in 0..1 that looks random.
    fn hash(x: usize, y: usize) -> f32 {
        let mut n = (x as u32).wrapping_mul(0x9e37_79b9) ^ (y as u32).wrapping_mul(0x85eb_ca6b);
        n = (n ^ n >> 15).wrapping_mul(0x2c1b_3c6d);
        n = (n ^ n >> 12).wrapping_mul(0x297a_2d39);
        (n >> 8) as f32 / (1u32 << 24) as f32
    }

    /// Octaves of value noise with ridges: steep, with sharp crests.
    fn mountains(x: usize, y: usize) -> f32 {
        let octave = |size: usize| {
            let (i, j) = (x / size, y / size);
            let (u, v) = ((x % size) as f32 / size as f32, (y % size) as f32 / size as f32);
            let row = |j| hash(i + 977 * size, j) * (1.0 - u) + hash(i + 1 + 977 * size, j) * u;
            let noise = row(j) * (1.0 - v) + row(j + 1) * v;
            size as f32 * (1.0 - (2.0 * noise - 1.0).abs())
        };
        30.0 * [1, 2, 4, 8, 16, 32].map(octave).iter().sum::<f32>()
    }

    /// Terrains on which triangles of other simplifiers fold.
    fn terrains() -> Vec<(&'static str, Terrain)> {
        vec![
            ("hills", hills(129)),
            ("mountains", land(200, 150, (10.0, 10.0), mountains)),
            ("tall mountains", land(129, 129, (1.0, 1.0), mountains)),
            ("oblong cells", land(90, 140, (30.0, 4.0), mountains)),
            ("noise", land(100, 100, (10.0, 10.0), |x, y| 500.0 * hash(x, y))),
            ("cliffs", land(120, 120, (5.0, 5.0), |x, y| 300.0 * ((x / 7 + y / 11) % 4) as f32)),
            ("a wall", land(100, 100, (1.0, 1.0), |x, y| if x + y / 3 > 60 { 1000.0 } else { 0.0 })),
            ("needles", land(100, 90, (10.0, 10.0), |x, y| if (x * 7 + y * 3) % 29 == 0 { 2000.0 } else { 1.0 })),
            ("flat", land(80, 60, (10.0, 10.0), |_, _| -3.0)),
        ]
    }

    /// Vertices on edges that only one triangle has.
    fn rim(mesh: &TerrainMesh) -> BTreeSet<[u32; 3]> {
        let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for t in mesh.indices.chunks_exact(3) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((a.min(b), a.max(b))).or_default() += 1;
            }
        }
        assert!(edges.values().all(|&n| n <= 2), "an edge has more than two triangles");
        let rim = edges.into_iter().filter(|&(_, n)| n == 1).flat_map(|((a, b), _)| [a, b]);
        rim.map(|i| mesh.positions[i as usize].map(f32::to_bits)).collect()
    }

    #[test]
    fn levels_shrink_keep_the_rim_and_use_every_vertex() {
        let full = hills(65);
        let levels = levels_of_detail(&full, &[0.25, 0.1]);
        assert_eq!(levels.len(), 3);
        assert_eq!(levels[0].mesh.triangles(), full.mesh.triangles());
        let full_rim = rim(&full.mesh);
        assert_eq!(full_rim.len(), 4 * 64);
        for l in &levels {
            assert_eq!(rim(&l.mesh), full_rim);
            let used: BTreeSet<u32> = l.mesh.indices.iter().copied().collect();
            assert_eq!(used.len(), l.mesh.positions.len());
            assert_eq!((l.mesh.normals.len(), l.mesh.colours.len()), (used.len(), used.len()));
        }
    }

    /// All triangles face up and their areas add up to that of the land: each place is covered once.
    #[test]
    fn no_triangle_of_any_level_folds() {
        for (name, full) in terrains() {
            let ratios = [0.25, 0.0625, 0.03];
            let levels = levels_of_detail(&full, &ratios);
            assert!(levels.len() >= 3, "{name}: {} levels", levels.len());
            let (first, last) = (full.mesh.positions[0], full.mesh.positions[full.mesh.positions.len() - 1]);
            let land = f64::from(last[0] - first[0]) * f64::from(last[2] - first[2]);
            let full_rim = rim(&full.mesh);
            for (l, wanted) in levels.iter().zip([1.0].iter().chain(&ratios)) {
                let areas: Vec<f64> = l.mesh.indices.chunks_exact(3).map(|t| area_from_above(&l.mesh, t)).collect();
                assert!(areas.iter().all(|&a| a > 0.0), "{name}, {}: a triangle faces down", l.ratio);
                let area = areas.iter().sum::<f64>() / 2.0;
                assert!((area / land - 1.0).abs() < 1e-6, "{name}, {}: {area} of {land} m^2", l.ratio);
                assert_eq!(rim(&l.mesh), full_rim, "{name}, {}", l.ratio);
                // The rim alone has many of a small mesh's vertices.
                assert!(*wanted < 0.05 || (l.ratio - wanted).abs() < 0.02, "{name}: {} for {wanted}", l.ratio);
            }
        }
    }

    #[test]
    fn errors_are_the_largest_vertical_distances() {
        for (name, full) in [("hills", hills(41)), ("mountains", land(40, 30, (10.0, 10.0), mountains))] {
            let levels = levels_of_detail(&full, &[0.25]);
            let level = &levels[1].mesh;
            // One vertex after the other against one triangle after the other.
            let distance = |p: &[f32; 3]| {
                let inside = level.indices.chunks_exact(3).find_map(|t| {
                    let [a, b, c] = [t[0], t[1], t[2]].map(|i| level.positions[i as usize].map(f64::from));
                    let (dx, dz) = (f64::from(p[0]) - a[0], f64::from(p[2]) - a[2]);
                    let det = (b[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (b[2] - a[2]);
                    let u = (dx * (c[2] - a[2]) - (c[0] - a[0]) * dz) / det;
                    let v = ((b[0] - a[0]) * dz - dx * (b[2] - a[2])) / det;
                    let hit = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
                    hit.then(|| (a[1] + u * (b[1] - a[1]) + v * (c[1] - a[1]) - f64::from(p[1])).abs())
                });
                inside.unwrap()
            };
            let most = full.mesh.positions.iter().map(distance).fold(0.0, f64::max);
            let said = f64::from(levels[1].error_m);
            assert!((said - most).abs() < 1e-3 * most, "{name}: {said} {most}");
        }
        // Gentle land needs few triangles.
        let levels = levels_of_detail(&hills(129), &[0.25, 0.0625]);
        assert!(levels[1].error_m < 1.5 && levels[2].error_m < 5.0, "{} {}", levels[1].error_m, levels[2].error_m);
        let flat = land(50, 50, (10.0, 10.0), |x, y| x as f32 - 2.0 * y as f32);
        assert!(levels_of_detail(&flat, &[0.2]).iter().all(|l| l.error_m < 1e-3));
    }

    #[test]
    fn a_mesh_that_is_all_rim_has_one_level() {
        assert_eq!(levels_of_detail(&hills(2), &[0.5, 0.25]).len(), 1);
        assert_eq!(levels_of_detail(&hills(9), &[f64::NAN, 1.5, -1.0]).len(), 1);
    }
}
