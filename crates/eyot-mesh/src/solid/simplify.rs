//! Coarser levels of a body, still closed and a manifold.
//!
//! The simplifier at hand (`meshopt`) collapses edges by quadric errors. It does not ask whether the two ends of an edge have more
//! than two neighbours in common, so that now and then sheets end up stuck together. The vertices of such places are locked and
//! the level is made again.

use super::solid_mesh::Solid;
use crate::primitive::Point;
use crate::simplifier;
use std::collections::BTreeMap;

/// Attempts at a level that is a manifold.
const ATTEMPTS: usize = 12;
/// A level counts as coarser only if it saves at least this share of triangles.
const WORTHWHILE: f64 = 0.9;

/// A level of detail of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidLod {
    /// The surface; its vertices are some of the full one's, with their normals.
    pub solid: Solid,
    /// Numbers of its vertices in the full surface, for what else belongs to vertices.
    pub vertices: Vec<u32>,
    /// Share of the full surface's triangles.
    pub ratio: f64,
    /// The simplifier's estimate of the distance between both surfaces.
    pub error: f32,
}

/// Coarser levels of a closed manifold, for falling shares of its triangles. Shares outside 0..1 are left out, and so are levels
/// that would save little or could not be kept a manifold. Pieces too small for a level may vanish from it, but never all.
pub fn solid_levels(solid: &Solid, ratios: &[f64]) -> Vec<SolidLod> {
    let mut levels: Vec<SolidLod> = Vec::new();
    let mut size = solid.indices.len();
    for &ratio in ratios.iter().filter(|r| (0.0..1.0).contains(*r)) {
        // A tetrahedron is the least; the simplifier aborts if asked for more triangles than there are.
        let target = 3 * ((solid.triangles() as f64 * ratio) as usize).max(4);
        if target >= size {
            continue;
        }
        let Some((indices, error)) = simplify(solid, target) else { continue };
        if indices.len() as f64 >= WORTHWHILE * size as f64 {
            continue;
        }
        size = indices.len();
        let (coarse, vertices) = compact(solid, &indices);
        levels.push(SolidLod {
            ratio: coarse.triangles() as f64 / solid.triangles() as f64,
            solid: coarse,
            vertices,
            error,
        });
    }
    levels
}

fn simplify(solid: &Solid, target: usize) -> Option<(Vec<u32>, f32)> {
    let mut locked = vec![false; solid.positions.len()];
    for _ in 0..ATTEMPTS {
        let (indices, error) = simplifier::simplify_closed(&solid.indices, &solid.positions, &locked, target)?;
        let coarse = Solid { positions: solid.positions.clone(), normals: Vec::new(), indices };
        let bad = flaws(&coarse);
        if bad.is_empty() {
            return (!coarse.indices.is_empty()).then_some((coarse.indices, error));
        }
        // The neighbours in the full surface as well: a collapse beside the flaw made it.
        let mut near = vec![false; locked.len()];
        bad.iter().for_each(|&i| near[i as usize] = true);
        for t in solid.indices.chunks_exact(3).filter(|t| t.iter().any(|&i| near[i as usize])) {
            t.iter().for_each(|&i| locked[i as usize] = true);
        }
    }
    None
}

/// Vertices at edges without exactly two triangles, and pinched ones.
fn flaws(solid: &Solid) -> Vec<u32> {
    let mut edges: BTreeMap<(u32, u32), [u32; 2]> = BTreeMap::new();
    let mut uses = vec![0; solid.positions.len()];
    for t in solid.indices.chunks_exact(3) {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)] += 1;
            uses[a as usize] += 1;
        }
    }
    let bad = edges.into_iter().filter(|(_, n)| *n != [1, 1]).flat_map(|((a, b), _)| [a, b]);
    bad.chain(solid.pinched(&uses)).collect()
}

/// The vertices that triangles use, in the order of their first use, and their numbers before.
fn compact(solid: &Solid, indices: &[u32]) -> (Solid, Vec<u32>) {
    let mut new = vec![u32::MAX; solid.positions.len()];
    let mut used = Vec::new();
    let indices = simplifier::order_for_cache(indices, solid.positions.len())
        .into_iter()
        .map(|old| {
            if new[old as usize] == u32::MAX {
                new[old as usize] = used.len() as u32;
                used.push(old);
            }
            new[old as usize]
        })
        .collect();
    let pick = |from: &[Point]| used.iter().map(|&i| from[i as usize]).collect();
    (Solid { positions: pick(&solid.positions), normals: pick(&solid.normals), indices }, used)
}
