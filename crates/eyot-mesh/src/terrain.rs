//! From a height field to one triangle mesh.

use crate::error::{Error, Result};
use crate::tiles::Tiling;
use eyot_core::{Error as CoreError, Field, Grid, Limits};
use rayon::prelude::*;

/// Bytes that one vertex with its share of triangles takes: position, normal, colour, texture coordinates, four attributes and two
/// triangles.
const BYTES_PER_VERTEX: u64 = 12 + 12 + 4 + 4 + 16 + 2 * 3 * 4;

/// Triangles with one vertex per sampled cell.
///
/// All vertex arrays have the same length.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TerrainMesh {
    /// Metres: x east, y up, z south; the origin is the middle of the grid at height 0.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors that point out of the ground.
    pub normals: Vec<[f32; 3]>,
    /// Linear (not sRGB) red, green, blue and an alpha of 255.
    pub colours: Vec<[u8; 4]>,
    /// Texture coordinates over the whole grid, whichever part of it the mesh shows: 0 at its western and northern border, 65535 at the
    /// eastern and southern one. A picture of the grid with a pixel a cell, such as a mask, lies with the middles of its pixels on the vertices.
    pub texture: Vec<[u16; 2]>,
    /// Numbers of each vertex beside these, such as shares of materials.
    pub attributes: Vec<Attribute>,
    /// Three per triangle, counter-clockwise seen from above.
    pub indices: Vec<u32>,
}

/// A number for every vertex.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Attribute {
    /// What it is.
    pub name: String,
    /// As many as there are vertices.
    pub values: Vec<f32>,
}

impl TerrainMesh {
    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }
}

/// How to make a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Most vertices that one mesh may have, at least 4. A grid with more cells is sampled with a stride; in tiles, the bound holds for each
    /// of them. The default of 1025 x 1025 makes a file of 80 MB with four levels of detail.
    pub max_vertices: u64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self { max_vertices: 1025 * 1025 }
    }
}

/// A mesh together with how it was sampled from the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// The triangles.
    pub mesh: TerrainMesh,
    /// Vertices from west to east.
    pub columns: usize,
    /// Vertices from north to south.
    pub rows: usize,
    /// Every how many cells a vertex stands; 1 if every cell has one. The last row and column always have theirs, so
    /// that the extent is kept.
    pub stride: usize,
    /// Columns and rows of the grid.
    pub cells: (usize, usize),
    /// Column and row of the first vertex among those of all tiles; (0, 0) of a mesh of the whole grid.
    pub first: (usize, usize),
}

impl Terrain {
    /// Gives every vertex the value of its cell. `values` are one a cell, row by row from the north.
    ///
    /// # Errors
    /// If there are not as many values as cells.
    pub fn add_attribute(&mut self, name: &str, values: &[f32]) -> Result<()> {
        let (w, h) = self.cells;
        if values.len() != w * h {
            let what = format!("the attribute `{name}` of a {w}x{h} mesh");
            return Err(CoreError::Shape { what, expected: w * h, found: values.len() }.into());
        }
        let (columns, stride, (east, south)) = (self.columns, self.stride, self.first);
        let cell = |i: usize, n: usize| (i * stride).min(n - 1);
        let at = |c: usize, r: usize| values[cell(south + r, h) * w + cell(east + c, w)];
        let values = collect(self.rows, |row| (0..columns).map(|c| at(c, row)).collect());
        self.mesh.attributes.push(Attribute { name: name.to_owned(), values });
        Ok(())
    }
}

/// Makes a mesh of `height` (m), with a vertex in the middle of every cell.
///
/// `colours` holds one linear RGB colour a cell in 0..=1, row by row from the north. If the grid has more cells than
/// `options.max_vertices` or `limits.max_vertices`, the smallest integer stride that fits is used and reported in
/// [`Terrain::stride`].
///
/// # Errors
/// If the grid has fewer than 2x2 cells, if field, colours and grid disagree in size, if a height is not finite, if
/// fewer than 4 vertices are allowed, or if the mesh exceeds `limits.max_bytes`. Nothing large is allocated before
/// these checks.
pub fn terrain(
    height: &Field,
    grid: &Grid,
    colours: &[[f32; 3]],
    options: &MeshOptions,
    limits: &Limits,
) -> Result<Terrain> {
    Tiling::new(grid, [1, 1], options, limits)?.terrain([0, 0], height, colours, limits)
}

impl Tiling {
    /// The terrain of a tile, counted from the north-west; see [`terrain`]. Vertices on a rim that two tiles share are the same bits in both,
    /// normals included, for slopes are those of the whole grid.
    ///
    /// # Errors
    /// As [`terrain`]; heights are looked at where the tile has them.
    pub fn terrain(&self, tile: [usize; 2], height: &Field, colours: &[[f32; 3]], limits: &Limits) -> Result<Terrain> {
        let (w, h) = (self.grid.width, self.grid.height);
        for (what, found) in [("the height field", height.width() * height.height()), ("the colours", colours.len())] {
            if found != w * h || height.width() != w {
                return Err(
                    CoreError::Shape { what: format!("{what} of a {w}x{h} mesh"), expected: w * h, found }.into()
                );
            }
        }
        let (first, [columns, rows]) = self.window(tile);
        for y in self.cells_near(first[1], rows, h) {
            for x in self.cells_near(first[0], columns, w) {
                let value = height.get(x, y);
                if !value.is_finite() {
                    return Err(Error::NotFinite { value, x, y });
                }
            }
        }
        let vertices = columns as u64 * rows as u64;
        limits.check_bytes("a terrain mesh", u128::from(vertices) * u128::from(BYTES_PER_VERTEX))?;

        let s = Sampling { height, tiling: self };
        let per_row = |row: usize| (0..columns).map(move |column| (first[0] + column, first[1] + row));
        let positions: Vec<[f32; 3]> = collect(rows, |row| per_row(row).map(|(c, r)| s.position(c, r)).collect());
        let normals = collect(rows, |row| per_row(row).map(|(c, r)| s.normal(c, r)).collect());
        let colours = collect(rows, |row| {
            per_row(row).map(|(c, r)| quantise(colours[self.cell(r, h) * w + self.cell(c, w)])).collect()
        });
        let texture = collect(rows, |row| per_row(row).map(|(c, r)| self.texture(c, r)).collect());
        let indices = collect(rows - 1, |row| {
            (0..columns - 1).flat_map(|column| split_quad(&positions, columns, column, row)).collect()
        });
        let mesh = TerrainMesh { positions, normals, colours, texture, attributes: Vec::new(), indices };
        let (stride, first) = (self.stride, (first[0], first[1]));
        Ok(Terrain { mesh, columns, rows, stride, cells: (w, h), first })
    }
}

/// Bytes that a mesh of `width` x `height` cells and its levels of detail take at most while they are made, beside the
/// heights and colours.
///
/// Measured with four levels at 2048 x 2048 cells: 291 bytes a vertex, most of them in the search for the first edges to
/// collapse; attributes, their copies in the levels and the flattened positions come on top.
///
/// Of tiles, of which few are made at a time, the levels of all are held until the last is made: 110 bytes a vertex.
pub fn terrain_bytes(grid: &Grid, tiles: [usize; 2], options: &MeshOptions, limits: &Limits) -> u128 {
    let all = Grid { width: grid.width.max(2), height: grid.height.max(2), ..*grid };
    let Ok(tiling) = Tiling::new(&all, tiles, options, limits) else { return 0 };
    let [columns, rows] = tiling.samples.map(|n| n as u128);
    let one = columns.div_ceil(tiles[0] as u128) * rows.div_ceil(tiles[1] as u128);
    let at_once = (rayon::current_num_threads() as u128).min(tiles[0] as u128 * tiles[1] as u128);
    380 * one * at_once + if tiles == [1, 1] { 0 } else { 110 * columns * rows }
}

/// Runs `row` for all rows on all cores and joins the results in order.
pub(crate) fn collect<T: Send>(rows: usize, row: impl Fn(usize) -> Vec<T> + Sync + Send) -> Vec<T> {
    (0..rows).into_par_iter().flat_map_iter(row).collect()
}

/// The samples that meshes take of a grid.
pub(crate) struct Sampling<'a> {
    pub(crate) height: &'a Field,
    pub(crate) tiling: &'a Tiling,
}

impl Sampling<'_> {
    fn position(&self, column: usize, row: usize) -> [f32; 3] {
        let [x, y] = self.tiling.cell_of(column, row);
        let [east, south] = self.tiling.place(column, row);
        [east, self.height.get(x, y), south]
    }

    /// Upward normal from the slope between the neighbouring vertices; one-sided at the rim.
    fn normal(&self, column: usize, row: usize) -> [f32; 3] {
        let t = self.tiling;
        let [x, y] = t.cell_of(column, row);
        let [west, north] = t.cell_of(column.saturating_sub(1), row.saturating_sub(1));
        let [east, south] = t.cell_of((column + 1).min(t.samples[0] - 1), (row + 1).min(t.samples[1] - 1));
        let slope = |a: f32, b: f32, cells: usize, size: f64| (f64::from(b) - f64::from(a)) / (cells as f64 * size);
        let dx = slope(self.height.get(west, y), self.height.get(east, y), east - west, t.grid.cell_x_m);
        let dz = slope(self.height.get(x, north), self.height.get(x, south), south - north, t.grid.cell_y_m);
        let length = (dx * dx + dz * dz + 1.0).sqrt();
        [(-dx / length) as f32, (1.0 / length) as f32, (-dz / length) as f32]
    }
}

/// Two triangles for the quad whose north-west vertex is (column, row).
///
/// The quad is cut along the diagonal with the smaller difference in height: a fixed diagonal would put saw teeth on
/// every ridge that runs the other way.
fn split_quad(positions: &[[f32; 3]], columns: usize, column: usize, row: usize) -> [u32; 6] {
    let nw = row * columns + column;
    let (ne, sw, se) = (nw + 1, nw + columns, nw + columns + 1);
    let drop = |a: usize, b: usize| (positions[a][1] - positions[b][1]).abs();
    let corners = if drop(nw, se) < drop(ne, sw) { [nw, sw, se, nw, se, ne] } else { [nw, sw, ne, ne, sw, se] };
    corners.map(|i| i as u32)
}

fn quantise(rgb: [f32; 3]) -> [u8; 4] {
    // NaN becomes 0: `clamp` keeps it and the cast maps it to zero.
    let [r, g, b] = rgb.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::Boundary;

    fn grid(w: usize, h: usize, cell: f64) -> Grid {
        Grid::new(w, h, cell, Boundary::CLOSED, &Limits::default()).unwrap()
    }

    fn build(height: &Field, grid: &Grid, max_vertices: u64) -> Result<Terrain> {
        let grey = vec![[0.5; 3]; grid.cells()];
        terrain(height, grid, &grey, &MeshOptions { max_vertices }, &Limits::default())
    }

    /// Area of the mesh seen from above, positive if all triangles are counter-clockwise from there.
    fn area_from_above(m: &TerrainMesh) -> f64 {
        m.indices
            .chunks_exact(3)
            .map(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| m.positions[i as usize].map(f64::from));
                let up = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]);
                assert!(up > 0.0, "triangle {t:?} faces down");
                up / 2.0
            })
            .sum()
    }

    #[test]
    fn covers_the_area_between_cell_centres_once_and_faces_up() {
        let g = grid(7, 5, 10.0);
        let bumpy = Field::from_fn(7, 5, |x, y| ((x * 7 + y * 13) % 5) as f32);
        let t = build(&bumpy, &g, 1000).unwrap();
        assert_eq!((t.stride, t.columns, t.rows), (1, 7, 5));
        assert_eq!(t.mesh.triangles(), 2 * 6 * 4);
        assert!((area_from_above(&t.mesh) - 60.0 * 40.0).abs() < 1e-6);
        assert_eq!(t.mesh.positions[0], [-30.0, bumpy.get(0, 0), -20.0]);
    }

    #[test]
    fn a_plane_has_its_analytic_normal_everywhere() {
        let g = Grid { cell_y_m: 4.0, ..grid(9, 6, 2.0) };
        // Rises 0.5 m per m to the east and 0.25 m per m to the south.
        let plane = Field::from_fn(9, 6, |x, y| x as f32 + y as f32);
        let length = (0.25f32 + 0.0625 + 1.0).sqrt();
        for n in build(&plane, &g, 1000).unwrap().mesh.normals {
            for (found, expected) in n.iter().zip([-0.5 / length, 1.0 / length, -0.25 / length]) {
                assert!((found - expected).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn large_grids_are_sampled_and_keep_their_extent() {
        let g = grid(100, 40, 1.0);
        let t = build(&Field::new(100, 40, 0.0), &g, 300).unwrap();
        assert!(t.columns * t.rows <= 300 && t.stride > 1);
        assert!(
            (99usize.div_ceil(t.stride - 1) + 1) * (39usize.div_ceil(t.stride - 1) + 1) > 300,
            "stride {} is not the smallest",
            t.stride
        );
        assert!((area_from_above(&t.mesh) - 99.0 * 39.0).abs() < 1e-3);
        assert_eq!(build(&Field::new(100, 40, 0.0), &g, 4).unwrap().mesh.triangles(), 2);
    }

    #[test]
    fn refuses_what_cannot_be_a_mesh() {
        for (w, h) in [(1, 1), (1, 9), (9, 1)] {
            let e = build(&Field::new(w, h, 0.0), &grid(w, h, 1.0), 100).unwrap_err();
            assert!(matches!(e, Error::NoTriangle { .. }), "{e}");
        }
        let g = grid(3, 3, 1.0);
        let mut bad = Field::new(3, 3, 0.0);
        assert!(matches!(build(&bad, &g, 3).unwrap_err(), Error::TooFewVertices { max_vertices: 3 }));
        assert!(matches!(build(&Field::new(3, 4, 0.0), &g, 9).unwrap_err(), Error::Core(_)));
        assert!(matches!(build(&Field::new(9, 1, 0.0), &g, 9).unwrap_err(), Error::Core(_)));
        bad.set(2, 1, f32::NAN);
        assert!(matches!(build(&bad, &g, 9).unwrap_err(), Error::NotFinite { x: 2, y: 1, .. }));
        let tight = Limits { max_bytes: 100, ..Limits::default() };
        let colours = [[0.0; 3]; 9];
        let e = terrain(&Field::new(3, 3, 0.0), &g, &colours, &MeshOptions::default(), &tight).unwrap_err();
        assert!(matches!(e, Error::Core(CoreError::Limit { .. })), "{e}");
    }

    #[test]
    fn colours_are_quantised_and_bounded() {
        assert_eq!(quantise([0.0, 0.5, 1.0]), [0, 128, 255, 255]);
        assert_eq!(quantise([-1.0, 7.0, f32::NAN]), [0, 255, 0, 255]);
    }
}
