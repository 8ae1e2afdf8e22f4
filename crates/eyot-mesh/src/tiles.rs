//! A grid cut into tiles that are meshes of their own and fit together.

use crate::error::{Error, Result};
use crate::lod::Lod;
use crate::terrain::{MeshOptions, Terrain, TerrainMesh};
use eyot_core::{Grid, Limits};

/// How a grid is sampled and cut into tiles.
///
/// Tiles share the vertices of their common rims. All have about the same number of quads; where that leaves a rest, the southern and
/// eastern ones have one more.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiling {
    /// The grid.
    pub(crate) grid: Grid,
    /// Tiles from west to east and from north to south.
    pub(crate) tiles: [usize; 2],
    /// Every how many cells a vertex stands, the same in all tiles.
    pub(crate) stride: usize,
    /// Vertices of the whole grid from west to east and from north to south.
    pub(crate) samples: [usize; 2],
}

impl Tiling {
    /// Cuts `grid` into `tiles` (from west to east, from north to south), with the smallest stride at which no tile has more vertices than
    /// allowed.
    ///
    /// # Errors
    /// If the grid has fewer than 2x2 cells, if there would be more tiles than quads along a side, or if fewer than 4 vertices are allowed.
    pub fn new(grid: &Grid, tiles: [usize; 2], options: &MeshOptions, limits: &Limits) -> Result<Self> {
        let (w, h) = (grid.width, grid.height);
        if w < 2 || h < 2 {
            return Err(Error::NoTriangle { width: w, height: h });
        }
        // Indices are u32, whatever the limits allow.
        let max_vertices = options.max_vertices.min(limits.max_vertices).min(u64::from(u32::MAX));
        if max_vertices < 4 {
            return Err(Error::TooFewVertices { max_vertices });
        }
        let along = |n: usize, stride: usize, tiles: usize| (n - 1).div_ceil(stride).div_ceil(tiles.max(1)) + 1;
        let fits = |s: usize| along(w, s, tiles[0]) as u128 * along(h, s, tiles[1]) as u128 <= u128::from(max_vertices);
        // The count falls as the stride grows, so halving finds the first stride that fits.
        let (mut low, mut high) = (1, w.max(h));
        while low < high {
            let middle = low + (high - low) / 2;
            if fits(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        let samples = [w, h].map(|n| (n - 1).div_ceil(low) + 1);
        if (0..2).any(|axis| tiles[axis] == 0 || tiles[axis] > samples[axis] - 1) {
            return Err(Error::TooManyTiles { tiles, quads: samples.map(|n| n - 1) });
        }
        Ok(Self { grid: *grid, tiles, stride: low, samples })
    }

    /// Every how many cells a vertex stands; 1 if every cell has one.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// All tiles, row by row from the north-west: how many lie to the west and to the north.
    pub fn all(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [nx, ny] = self.tiles;
        (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y]))
    }

    /// Column and row of the first vertex of a tile, and its number of columns and rows.
    pub(crate) fn window(&self, tile: [usize; 2]) -> ([usize; 2], [usize; 2]) {
        let cut = |axis: usize, i: usize| i * (self.samples[axis] - 1) / self.tiles[axis];
        let first = [cut(0, tile[0]), cut(1, tile[1])];
        (first, [cut(0, tile[0] + 1) - first[0] + 1, cut(1, tile[1] + 1) - first[1] + 1])
    }

    /// Cells along an axis of `n` that vertices from `first` on and their neighbours stand on or between.
    pub(crate) fn cells_near(&self, first: usize, count: usize, n: usize) -> std::ops::RangeInclusive<usize> {
        self.cell(first.saturating_sub(1), n)..=self.cell(first + count, n)
    }

    /// Cell of sample `i` along an axis of `n` cells.
    pub(crate) fn cell(&self, i: usize, n: usize) -> usize {
        (i * self.stride).min(n - 1)
    }

    /// Column and row of the cell of a vertex.
    pub(crate) fn cell_of(&self, column: usize, row: usize) -> [usize; 2] {
        [self.cell(column, self.grid.width), self.cell(row, self.grid.height)]
    }

    /// East and south of a vertex, m from the middle of the grid.
    pub(crate) fn place(&self, column: usize, row: usize) -> [f32; 2] {
        let g = &self.grid;
        let [x, y] = self.cell_of(column, row);
        // In f64: at 1e6 cells, f32 would lose the half cell.
        let at = |i: usize, n: usize, cell: f64| ((i as f64 + 0.5 - n as f64 / 2.0) * cell) as f32;
        [at(x, g.width, g.cell_x_m), at(y, g.height, g.cell_y_m)]
    }

    /// Texture coordinates of a vertex; see [`TerrainMesh::texture`].
    pub(crate) fn texture(&self, column: usize, row: usize) -> [u16; 2] {
        let [x, y] = self.cell_of(column, row);
        let part = |i: usize, n: usize| ((i as f64 + 0.5) / n as f64 * 65535.0).round() as u16;
        [part(x, self.grid.width), part(y, self.grid.height)]
    }

    /// Which rims of a tile it shares with another: west, east, north and south.
    fn shared(&self, tile: [usize; 2]) -> [bool; 4] {
        [tile[0] > 0, tile[0] + 1 < self.tiles[0], tile[1] > 0, tile[1] + 1 < self.tiles[1]]
    }

    /// A wall from the rims that a tile shares with others down by `depth_m`, for one of its levels of detail. Where tiles of different
    /// levels meet, one rim is above the other; the wall of the upper one hides what would be seen through the gap.
    pub fn skirt(&self, tile: [usize; 2], full: &Terrain, level: &TerrainMesh, depth_m: f32) -> TerrainMesh {
        let sides = sides(full);
        let mut out = TerrainMesh::default();
        for (side, _) in sides.iter().zip(self.shared(tile)).filter(|(_, shared)| *shared) {
            for [a, b] in rim_edges(level, side) {
                let first = out.positions.len() as u32;
                for (i, down) in [(a, 0.0), (b, 0.0), (a, depth_m), (b, depth_m)] {
                    let [x, y, z] = level.positions[i];
                    out.positions.push([x, y - down, z]);
                    out.normals.push(level.normals[i]);
                    out.colours.push(level.colours[i]);
                    out.texture.push(level.texture[i]);
                }
                // From outside counter-clockwise: the triangle inside passes the edge from a to b, this from b to a.
                out.indices.extend([1, 0, 2, 1, 2, 3].map(|i| first + i));
            }
        }
        out
    }
}

/// A straight side of a tile: 0 for a line from north to south, 2 for one from west to east, and where it is.
type Side = (usize, f32);

/// West, east, north and south.
fn sides(full: &Terrain) -> [Side; 4] {
    let p = &full.mesh.positions;
    let last = p[p.len() - 1];
    [(0, p[0][0]), (0, last[0]), (2, p[0][2]), (2, last[2])]
}

/// Edges on a side, each in the direction in which its only triangle passes it.
fn rim_edges(mesh: &TerrainMesh, &(axis, at): &Side) -> Vec<[usize; 2]> {
    let on = |i: u32| mesh.positions[i as usize][axis] == at;
    let passes = |t: &[u32]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let edges = mesh.indices.chunks_exact(3).flat_map(passes).filter(|[a, b]| on(*a) && on(*b));
    edges.map(|edge| edge.map(|i| i as usize)).collect()
}

/// The largest vertical distance of a vertex on the rim of the full mesh from the rim of a level, m.
pub fn rim_error(full: &Terrain, level: &Lod) -> f32 {
    let along = |mesh: &TerrainMesh, &(axis, at): &Side| {
        let on = mesh.positions.iter().filter(|p| p[axis] == at);
        let mut line: Vec<[f64; 2]> = on.map(|p| [f64::from(p[2 - axis]), f64::from(p[1])]).collect();
        line.sort_by(|a, b| a[0].total_cmp(&b[0]));
        line
    };
    let of_side = |side: &Side| {
        let coarse = along(&level.mesh, side);
        let away = |[x, z]: [f64; 2]| {
            let i = coarse.partition_point(|p| p[0] < x).clamp(1, coarse.len() - 1);
            let ([x0, z0], [x1, z1]) = (coarse[i - 1], coarse[i]);
            (z0 + (z1 - z0) * (x - x0) / (x1 - x0) - z).abs()
        };
        along(&full.mesh, side).into_iter().map(away).fold(0.0, f64::max)
    };
    sides(full).iter().map(of_side).fold(0.0, f64::max) as f32
}
