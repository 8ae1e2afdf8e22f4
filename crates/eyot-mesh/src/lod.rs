//! Coarser levels of a terrain mesh, by edge collapses that leave the rim in place.

use crate::terrain::TerrainMesh;
use eyot_core::{Control, Result};
use meshopt::{SimplifyOptions, VertexDataAdapter, utilities::typed_to_bytes};

/// A level counts as coarser only if it saves at least this share of triangles; with the rim locked, small meshes
/// stop shrinking, and a level that saves less is not worth its memory.
const WORTHWHILE: f64 = 0.9;

/// One level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Lod {
    /// The mesh; every vertex is used by a triangle.
    pub mesh: TerrainMesh,
    /// Share of the full mesh's triangles that this level has, in 0..=1.
    pub ratio: f64,
    /// Estimate of the largest distance to the full mesh, m.
    pub error_m: f32,
}

/// The mesh itself and coarser levels of it, finest first.
///
/// `ratios` are shares of the full mesh's triangles to aim at, in falling order, for example `[0.25, 0.0625]`. Level 0
/// is the full mesh with its triangles ordered for the vertex cache. Vertices on the rim never move, so tiles of one
/// landscape fit together at any mix of levels. Levels that the locked rim keeps from getting markedly smaller are
/// left out, so there may be fewer levels than ratios; values outside 0..1 are left out, too.
pub fn levels_of_detail(mesh: &TerrainMesh, ratios: &[f64]) -> Vec<Lod> {
    // Without anybody to stop it, it comes to its end.
    levels_of_detail_controlled(mesh, ratios, &Control::none()).unwrap_or_default()
}

/// As [`levels_of_detail`]; can be stopped between two levels.
///
/// # Errors
/// On a request to stop.
pub fn levels_of_detail_controlled(mesh: &TerrainMesh, ratios: &[f64], control: &Control<'_>) -> Result<Vec<Lod>> {
    let full = mesh.triangles();
    let mut levels = vec![Lod { mesh: compact(mesh, &mesh.indices), ratio: 1.0, error_m: 0.0 }];
    if mesh.positions.is_empty() {
        return Ok(levels);
    }
    for &ratio in ratios.iter().filter(|r| (0.0..1.0).contains(*r)) {
        control.check()?;
        let finer = &levels[levels.len() - 1];
        let target = 3 * ((full as f64 * ratio) as usize).max(1);
        let (indices, error) = simplify(&finer.mesh, target);
        let worthwhile = (indices.len() as f64) < WORTHWHILE * finer.mesh.indices.len() as f64;
        if indices.is_empty() || !worthwhile {
            continue;
        }
        // Each level is made from the one before, so the distances add up at worst.
        let error_m = finer.error_m + error;
        let mesh = compact(&finer.mesh, &indices);
        levels.push(Lod { ratio: mesh.triangles() as f64 / full as f64, mesh, error_m });
    }
    Ok(levels)
}

/// Indices of about `target` length, and the error in metres.
fn simplify(mesh: &TerrainMesh, target: usize) -> (Vec<u32>, f32) {
    let bytes = typed_to_bytes(&mesh.positions);
    let Ok(vertices) = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) else {
        return (Vec::new(), 0.0);
    };
    let mut error = 0.0;
    let options = SimplifyOptions::LockBorder | SimplifyOptions::ErrorAbsolute;
    let indices = meshopt::simplify(&mesh.indices, &vertices, target, f32::MAX, options, Some(&mut error));
    (indices, error)
}

/// The given triangles, ordered for the vertex cache, with the vertices that they use in order of first use.
fn compact(mesh: &TerrainMesh, indices: &[u32]) -> TerrainMesh {
    let ordered = meshopt::optimize_vertex_cache(indices, mesh.positions.len());
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
        colours: used.iter().map(|&i| mesh.colours[i]).collect(),
        indices,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::{MeshOptions, terrain};
    use eyot_core::{Field, Grid, Limits, Rim};
    use std::collections::{BTreeMap, BTreeSet};

    fn hills(n: usize) -> TerrainMesh {
        let grid = Grid::new(n, n, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
        let height = Field::from_fn(n, n, |x, y| 40.0 * ((x as f32 * 0.15).sin() + (y as f32 * 0.11).cos()));
        let grey = vec![[0.5; 3]; n * n];
        terrain(&height, &grid, &grey, &MeshOptions::default(), &Limits::default()).unwrap().mesh
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
        let mesh = hills(65);
        let levels = levels_of_detail(&mesh, &[0.25, 0.1]);
        assert_eq!(levels.len(), 3);
        assert_eq!(levels[0].mesh.triangles(), mesh.triangles());
        let full_rim = rim(&mesh);
        assert_eq!(full_rim.len(), 4 * 64);
        for (finer, coarser) in levels.iter().zip(&levels[1..]) {
            assert!(coarser.mesh.triangles() < finer.mesh.triangles());
            assert!(coarser.error_m >= finer.error_m && coarser.error_m < 80.0);
        }
        for l in &levels {
            assert_eq!(rim(&l.mesh), full_rim);
            let used: BTreeSet<u32> = l.mesh.indices.iter().copied().collect();
            assert_eq!(used.len(), l.mesh.positions.len());
            assert_eq!((l.mesh.normals.len(), l.mesh.colours.len()), (used.len(), used.len()));
        }
        assert!((levels[1].ratio - 0.25).abs() < 0.02, "{}", levels[1].ratio);
    }

    #[test]
    fn a_mesh_that_is_all_rim_has_one_level() {
        assert_eq!(levels_of_detail(&hills(2), &[0.5, 0.25]).len(), 1);
        assert_eq!(levels_of_detail(&TerrainMesh::default(), &[0.5]).len(), 1);
        assert_eq!(levels_of_detail(&hills(9), &[f64::NAN, 1.5, -1.0]).len(), 1);
    }
}
