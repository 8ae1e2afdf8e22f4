//! The surface of a sea, of lakes and of rivers as a mesh of its own.

use crate::lod::{compact, without_folds};
use crate::simplifier;
use crate::terrain::TerrainMesh;
use crate::tiles::Tiling;
use eyot_core::Field;

/// How far above or below that with a vertex on every cell the surface may be, m. A level surface loses nearly all of its triangles at any value.
const ERROR_M: f32 = 0.02;
/// How far its edge may move, in distances of vertices: it lies a whole one beyond the shore, under the ground.
const EDGE: f32 = 0.3;
/// A level surface goes on over cells that lie at most so far below it and do not count as water, m.
const FILM_M: f32 = 0.5;

/// Where water lies open.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct OpenWater {
    /// Height of its surface, m, one a cell, row by row from the north; NaN where there is none.
    pub level: Vec<f32>,
    /// Whether it stands, as in the sea and in lakes, where neighbours have the very same level.
    pub standing: Vec<bool>,
}

impl Tiling {
    /// The surface of the water on a tile; nothing where there is none.
    ///
    /// It goes on for one vertex beyond the shore, so that the ground cuts it where the shore is: standing water at its own level, below the
    /// ground, and running water down to the ground. Vertices on rims that tiles share are the same bits in both.
    pub fn water(&self, tile: [usize; 2], water: &OpenWater, height: &Field) -> Option<TerrainMesh> {
        let cells = self.grid.cells();
        if water.level.len() != cells || water.standing.len() != cells || height.width() * height.height() != cells {
            return None;
        }
        let (first, [columns, rows]) = self.window(tile);
        let number = |c: usize, r: usize| {
            let [x, y] = self.cell_of(c, r);
            y * self.grid.width + x
        };
        let wet = |c: usize, r: usize| water.level[number(c, r)].is_finite();
        let mut mesh = TerrainMesh::default();
        let mut vertex = vec![u32::MAX; columns * rows];
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let (c, r) = (first[0] + column, first[1] + row);
                if !(wet(c, r) || wet(c + 1, r) || wet(c, r + 1) || wet(c + 1, r + 1)) {
                    continue;
                }
                let corner = [[0, 0], [0, 1], [1, 0], [1, 0], [0, 1], [1, 1]];
                for [dx, dy] in corner {
                    let slot = &mut vertex[(row + dy) * columns + column + dx];
                    if *slot == u32::MAX {
                        *slot = mesh.positions.len() as u32;
                        let [x, z] = self.place(c + dx, r + dy);
                        mesh.positions.push([x, self.surface(water, height, c + dx, r + dy), z]);
                        mesh.texture.push(self.texture(c + dx, r + dy));
                    }
                    mesh.indices.push(*slot);
                }
            }
        }
        if mesh.indices.is_empty() {
            return None;
        }
        mesh.normals = normals(&mesh);
        let step = self.grid.cell_x_m.min(self.grid.cell_y_m) as f32 * self.stride as f32;
        let corners = [self.place(first[0], first[1]), self.place(first[0] + columns - 1, first[1] + rows - 1)];
        Some(simplified(mesh, corners, EDGE * step))
    }

    /// Height of the surface at a vertex, m.
    fn surface(&self, water: &OpenWater, height: &Field, column: usize, row: usize) -> f32 {
        let [x, y] = self.cell_of(column, row);
        let w = self.grid.width;
        let here = water.level[y * w + x];
        if here.is_finite() {
            return here;
        }
        let ground = height.get(x, y);
        let (mut any, mut standing) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        for r in row.saturating_sub(1)..=(row + 1).min(self.samples[1] - 1) {
            for c in column.saturating_sub(1)..=(column + 1).min(self.samples[0] - 1) {
                let [x, y] = self.cell_of(c, r);
                let i = y * w + x;
                let level = water.level[i];
                any = any.max(level);
                if water.standing[i] && ground > level - FILM_M {
                    standing = standing.max(level);
                }
            }
        }
        if standing.is_finite() { standing } else { any.min(ground) }
    }
}

/// Upward normals, each the mean of the triangles around it by area.
fn normals(mesh: &TerrainMesh) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0f64; 3]; mesh.positions.len()];
    for t in mesh.indices.chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| mesh.positions[i as usize].map(f64::from));
        let (u, v) = ([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for i in t {
            (0..3).for_each(|k| sums[*i as usize][k] += n[k]);
        }
    }
    let unit = |n: [f64; 3]| {
        let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
        // All triangles face up, so there is a length.
        n.map(|v| (v / length) as f32)
    };
    sums.into_iter().map(unit).collect()
}

/// With as few triangles as the errors allow; vertices on the tile's rim stay.
fn simplified(mesh: TerrainMesh, [low, high]: [[f32; 2]; 2], edge_m: f32) -> TerrainMesh {
    let on_rim = |p: &[f32; 3]| p[0] == low[0] || p[0] == high[0] || p[2] == low[1] || p[2] == high[1];
    let locked = mesh.positions.iter().map(on_rim).collect();
    // The simplifier knows one distance: heights are stretched until their error is as long as that of edges.
    let stretch = edge_m / ERROR_M;
    let stretched: Vec<[f32; 3]> = mesh.positions.iter().map(|p| [p[0], p[1] * stretch, p[2]]).collect();
    let how = |locked: &[bool]| simplifier::simplify_within(&mesh.indices, &stretched, locked, edge_m);
    match without_folds(&mesh, locked, how) {
        Some(fewer) if !fewer.is_empty() => compact(&mesh, &fewer),
        _ => mesh,
    }
}
