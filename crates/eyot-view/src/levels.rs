//! The surface's levels: where each lies in the texture of heights.

/// Most levels of a surface; as in the shaders.
pub(crate) const MAX_LEVELS: usize = 16;

/// Quads along a side of a patch; as in `terrain.wgsl`.
pub(crate) const PATCH: u32 = 32;

/// A pyramid of node grids side by side in one texture. Node `i` of level `l` is node `min(i 2^l, last)` of the finest level, so
/// that all levels end at the same rim.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Levels {
    /// Columns and rows of nodes of the finest level.
    pub(crate) nodes: [u32; 2],
    /// Place of each level in the texture, and its last column and row.
    pub(crate) places: Vec<[u32; 4]>,
    /// Size of the texture.
    pub(crate) texture: [u32; 2],
}

impl Levels {
    pub(crate) fn new(nodes: [u32; 2]) -> Self {
        let last = |n: u32, level: usize| (n - 1).div_ceil(1 << level);
        let mut places = vec![[0, 0, nodes[0] - 1, nodes[1] - 1]];
        let (mut width, mut rows) = (nodes[0], 0);
        while places[places.len() - 1][2..].iter().any(|n| *n > PATCH) && places.len() < MAX_LEVELS {
            let level = places.len();
            let [x, y] = nodes.map(|n| last(n, level));
            // All coarser levels stand in one column beside the finest.
            places.push([nodes[0], rows, x, y]);
            width = width.max(nodes[0] + x + 1);
            rows += y + 1;
        }
        Self { nodes, places, texture: [width, rows.max(nodes[1])] }
    }

    /// The coarsest level.
    pub(crate) fn top(&self) -> usize {
        self.places.len() - 1
    }

    /// The places as a uniform block holds them.
    pub(crate) fn uniform(&self) -> [[u32; 4]; MAX_LEVELS] {
        let mut out = [[0; 4]; MAX_LEVELS];
        out[..self.places.len()].copy_from_slice(&self.places);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_do_not_overlap_and_end_at_the_rim() {
        for nodes in [[2, 2], [25, 25], [1001, 501], [27, 1021], [4096, 4096], [25, 2000]] {
            let l = Levels::new(nodes);
            let top = l.places[l.top()];
            assert!(top[2] <= PATCH && top[3] <= PATCH, "{nodes:?}: {top:?}");
            for (i, a) in l.places.iter().enumerate() {
                assert!(a[0] + a[2] < l.texture[0] && a[1] + a[3] < l.texture[1], "{nodes:?}, level {i}");
                assert!((a[2] << i) >= nodes[0] - 1 && (a[3] << i) >= nodes[1] - 1);
                for b in &l.places[i + 1..] {
                    let apart = |k: usize| a[k] + a[k + 2] < b[k] || b[k] + b[k + 2] < a[k];
                    assert!(apart(0) || apart(1), "{nodes:?}: {a:?} {b:?}");
                }
            }
            assert!(l.texture[1] <= nodes[1] + 2 * MAX_LEVELS as u32 && l.texture[0] <= nodes[0] * 3 / 2 + 1);
        }
    }
}
