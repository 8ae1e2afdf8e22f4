//! From a height field to one triangle mesh.

use crate::error::{Error, Result};
use eyot_core::{Error as CoreError, Field, Grid, Limits};
use rayon::prelude::*;

/// Bytes that one vertex with its share of triangles takes: position, normal, colour, four attributes and two triangles.
const BYTES_PER_VERTEX: u64 = 12 + 12 + 4 + 16 + 2 * 3 * 4;

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
    /// Most vertices that the mesh may have, at least 4. A grid with more cells is sampled with a stride. The default
    /// of four million makes a file of about 200 MB that common viewers still open.
    pub max_vertices: u64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self { max_vertices: 4 << 20 }
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
        let (columns, stride) = (self.columns, self.stride);
        let cell = |i: usize, n: usize| (i * stride).min(n - 1);
        let values = collect(self.rows, |row| (0..columns).map(|c| values[cell(row, h) * w + cell(c, w)]).collect());
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
    let (w, h) = (grid.width, grid.height);
    if w < 2 || h < 2 {
        return Err(Error::NoTriangle { width: w, height: h });
    }
    for (what, found) in [("the height field", height.width() * height.height()), ("the colours", colours.len())] {
        if found != w * h || height.width() != w {
            return Err(CoreError::Shape { what: format!("{what} of a {w}x{h} mesh"), expected: w * h, found }.into());
        }
    }
    if let Some((x, y, value)) = height.find_not_finite() {
        return Err(Error::NotFinite { value, x, y });
    }
    // Indices are u32, whatever the limits allow.
    let max_vertices = options.max_vertices.min(limits.max_vertices).min(u64::from(u32::MAX));
    if max_vertices < 4 {
        return Err(Error::TooFewVertices { max_vertices });
    }
    let stride = stride_for(w, h, max_vertices);
    let (columns, rows) = (samples(w, stride), samples(h, stride));
    let vertices = columns as u64 * rows as u64;
    limits.check_bytes("a terrain mesh", u128::from(vertices) * u128::from(BYTES_PER_VERTEX))?;

    let cells = Sampling { height, grid, columns, rows, stride };
    let per_row = |row: usize| (0..columns).map(move |column| (column, row));
    let positions: Vec<[f32; 3]> = collect(rows, |row| per_row(row).map(|(c, r)| cells.position(c, r)).collect());
    let normals = collect(rows, |row| per_row(row).map(|(c, r)| cells.normal(c, r)).collect());
    let colours = collect(rows, |row| {
        per_row(row).map(|(c, r)| quantise(colours[cells.cell(r, h) * w + cells.cell(c, w)])).collect()
    });
    let indices = collect(rows - 1, |row| {
        (0..columns - 1).flat_map(|column| split_quad(&positions, columns, column, row)).collect()
    });
    let mesh = TerrainMesh { positions, normals, colours, attributes: Vec::new(), indices };
    Ok(Terrain { mesh, columns, rows, stride, cells: (w, h) })
}

/// Bytes that a mesh of `width` x `height` cells and its levels of detail take at most while they are made, beside the
/// heights and colours.
///
/// Measured with four levels at 2048 x 2048 cells: 291 bytes a vertex, most of them in the search for the first edges to
/// collapse; attributes, their copies in the levels and the flattened positions come on top.
pub fn terrain_bytes(width: usize, height: usize, options: &MeshOptions, limits: &Limits) -> u128 {
    let (w, h) = (width.max(2), height.max(2));
    let stride = stride_for(w, h, options.max_vertices.min(limits.max_vertices).clamp(4, u64::from(u32::MAX)));
    380 * samples(w, stride) as u128 * samples(h, stride) as u128
}

/// Runs `row` for all rows on all cores and joins the results in order.
fn collect<T: Send>(rows: usize, row: impl Fn(usize) -> Vec<T> + Sync + Send) -> Vec<T> {
    (0..rows).into_par_iter().flat_map_iter(row).collect()
}

/// Samples along an axis of `n` cells: every `stride`-th and the last.
fn samples(n: usize, stride: usize) -> usize {
    (n - 1).div_ceil(stride) + 1
}

/// The smallest stride with at most `max` samples; `max` is at least 4, so a stride of the longer side always fits.
fn stride_for(w: usize, h: usize, max: u64) -> usize {
    let fits = |s: usize| samples(w, s) as u128 * samples(h, s) as u128 <= u128::from(max);
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
    low
}

/// Which cells the vertices stand on.
struct Sampling<'a> {
    height: &'a Field,
    grid: &'a Grid,
    columns: usize,
    rows: usize,
    stride: usize,
}

impl Sampling<'_> {
    /// Cell of sample `i` along an axis of `n` cells.
    fn cell(&self, i: usize, n: usize) -> usize {
        (i * self.stride).min(n - 1)
    }

    fn position(&self, column: usize, row: usize) -> [f32; 3] {
        let (w, h) = (self.grid.width, self.grid.height);
        let (x, y) = (self.cell(column, w), self.cell(row, h));
        // In f64: at 1e6 cells, f32 would lose the half cell.
        let east = (x as f64 + 0.5 - w as f64 / 2.0) * self.grid.cell_x_m;
        let south = (y as f64 + 0.5 - h as f64 / 2.0) * self.grid.cell_y_m;
        [east as f32, self.height.get(x, y), south as f32]
    }

    /// Upward normal from the slope between the neighbouring vertices; one-sided at the rim.
    fn normal(&self, column: usize, row: usize) -> [f32; 3] {
        let (w, h) = (self.grid.width, self.grid.height);
        let (x, y) = (self.cell(column, w), self.cell(row, h));
        let (west, east) = (self.cell(column.saturating_sub(1), w), self.cell((column + 1).min(self.columns - 1), w));
        let (north, south) = (self.cell(row.saturating_sub(1), h), self.cell((row + 1).min(self.rows - 1), h));
        let slope = |a: f32, b: f32, cells: usize, size: f64| (f64::from(b) - f64::from(a)) / (cells as f64 * size);
        let dx = slope(self.height.get(west, y), self.height.get(east, y), east - west, self.grid.cell_x_m);
        let dz = slope(self.height.get(x, north), self.height.get(x, south), south - north, self.grid.cell_y_m);
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
            samples(100, t.stride - 1) * samples(40, t.stride - 1) > 300,
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
