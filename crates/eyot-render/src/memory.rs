//! What pictures need, so that a caller can refuse before anything is allocated.
//!
//! The numbers count the arrays that are alive at the worst moment, cell by cell, node by node and pixel by pixel. Measured
//! on a height alone at 2048 x 2048 cells: a view 375 MB, for which 419 MB are asked here.

use crate::map::MapOptions;
use crate::mesh_view::{MeshViewOptions, SHADOW};
use crate::relief::ReliefOptions;
use crate::surface::Refinement;
use crate::view::ViewOptions;

/// Bytes that [`perspective`](crate::perspective) takes at most for a world of `cells` (columns, rows), beside the world.
pub fn perspective_bytes(cells: [usize; 2], o: &ViewOptions) -> u128 {
    let r = Refinement::new(cells[0].max(1), cells[1].max(1));
    // Heights, water, what is drawn of both, and colours on cells; surface, pyramid, light, colours and what rays read on
    // nodes; a float colour and a final one a pixel.
    32 * area(cells) + 68 * area(r.nodes) + 15 * area([o.width, o.height])
}

/// Bytes that [`relief`](crate::relief) takes at most for a world of `cells` (columns, rows), beside the world.
pub fn relief_bytes(cells: [usize; 2], o: &ReliefOptions) -> u128 {
    // While colours are made, three layers, slopes and means are there, too.
    let r = o.raster(cells[0].max(1), cells[1].max(1));
    48 * area(cells) + 55 * area([r.width, r.height])
}

/// Bytes that [`layer_map`](crate::layer_map) takes at most for a world of `cells` (columns, rows), beside the world.
pub fn layer_map_bytes(cells: [usize; 2], o: &MapOptions) -> u128 {
    let r = o.raster(cells[0].max(1), cells[1].max(1));
    24 * area(cells) + 20 * area([r.width, r.height])
}

/// Bytes that [`terrain_colours`](crate::terrain_colours) takes at most for `cells` (columns, rows), beside the world.
pub fn terrain_colours_bytes(cells: [usize; 2]) -> u128 {
    48 * area(cells)
}

/// Bytes that [`mesh_view`](crate::mesh_view) takes at most for parts with so many vertices and triangles, beside them.
pub fn mesh_view_bytes(vertices: u64, triangles: u64, o: &MeshViewOptions) -> u128 {
    // Samples of the picture and of the sun's map; places, normals and colours, and places on either picture; corners and lists.
    let samples = o.samples.clamp(1, 4);
    let hits = area([o.width * samples, o.height * samples]) + area([SHADOW, SHADOW]);
    24 * hits + 3 * area([o.width, o.height]) + 64 * u128::from(vertices) + 20 * u128::from(triangles)
}

fn area([width, height]: [usize; 2]) -> u128 {
    width as u128 * height as u128
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_cells_and_more_pixels_need_more() {
        let view = |n, width| perspective_bytes([n, n], &ViewOptions { width, height: 100, ..Default::default() });
        assert!(view(2048, 100) > view(1024, 100) && view(2048, 4000) > view(2048, 100));
        // 16384 x 16384 cells in 16 GiB would be a promise that cannot be kept: 27 GB.
        assert!(view(16384, 100) > 16 << 30);
        let flat = |n, max_size| relief_bytes([n, n], &ReliefOptions { max_size, ..Default::default() });
        assert!(flat(4096, 4096) > flat(4096, 512) && flat(4096, 512) > flat(2048, 512));
        assert!(layer_map_bytes([4096, 4096], &MapOptions::default()) > 24 << 24);
    }
}
