//! What a georeference says: if it is of use, and cell sizes in metres.

use crate::format::RasterFormat;
use crate::geotiff::keys::exceeds_code;
use eyot_core::{CoordinateSystem, Field, Georeference};

/// True if all of it is finite and neither a column nor a row is a step of no length.
pub(crate) fn is_sound(g: &Georeference) -> bool {
    let t = &g.transform;
    t.iter().all(|v| v.is_finite()) && t[1].hypot(t[4]) > 0.0 && t[2].hypot(t[5]) > 0.0
}

/// True if it is only what [`crate::About`] says of a grid without a place: metres, the south-west corner at (0, 0).
pub(crate) fn is_nowhere(g: &Georeference, height: usize) -> bool {
    let t = &g.transform;
    let corner = (t[0], t[3] + height as f64 * t[5]);
    !g.geographic && g.epsg.is_none() && g.system.is_none() && (t[2], t[4]) == (0.0, 0.0) && corner == (0.0, 0.0)
}

/// Turns a raster over that starts in the south or in the east, so that row 0 is north and column 0 west.
pub(crate) fn face_north(field: &mut Field, missing: &mut Option<Vec<bool>>, g: &mut Georeference) {
    let t = &mut g.transform;
    if (t[2], t[4]) != (0.0, 0.0) {
        return;
    }
    let (width, height) = (field.width(), field.height());
    if t[5] > 0.0 {
        for north in 0..height / 2 {
            let south = height - 1 - north;
            let row = field.row(north).to_vec();
            let other = field.row(south).to_vec();
            field.row_mut(north).copy_from_slice(&other);
            field.row_mut(south).copy_from_slice(&row);
        }
        if let Some(missing) = missing {
            *missing = missing.chunks_exact(width).rev().flatten().copied().collect();
        }
        t[3] += height as f64 * t[5];
        t[5] = -t[5];
    }
    if t[1] < 0.0 {
        field.rows_mut().for_each(<[f32]>::reverse);
        missing.iter_mut().for_each(|m| m.chunks_exact_mut(width).for_each(<[bool]>::reverse));
        t[0] += width as f64 * t[1];
        t[1] = -t[1];
    }
}

/// What other programs will not find of the coordinate system in a file of this format, as a sentence.
pub fn lossy_georef(g: &Georeference, format: RasterFormat) -> Option<&'static str> {
    let fits = g.epsg.is_some_and(|code| u16::try_from(code).is_ok());
    match (format, &g.system) {
        (RasterFormat::GeoTiff, Some(CoordinateSystem::GeoKeys { .. })) => None,
        (RasterFormat::GeoTiff, system) if !fits && (system.is_some() || g.epsg.is_some()) => {
            Some("the coordinate system has no EPSG code that a GeoTIFF could hold, and is lost; its transform is kept")
        }
        (RasterFormat::Zarr, Some(system @ CoordinateSystem::GeoKeys { .. })) => match g.epsg {
            None => Some("the coordinate system has no EPSG code; the store keeps it where only Eyot finds it"),
            Some(_) if exceeds_code(system) => Some(
                "the EPSG code is not all of the coordinate system; the store keeps the rest where only Eyot finds it",
            ),
            Some(_) => None,
        },
        _ => None,
    }
}

/// Metres per degree of longitude and latitude on the WGS 84 ellipsoid at `latitude` degrees.
///
/// The usual series of the ellipsoid's radii of curvature; below 0.01 m of the exact value per degree.
pub(crate) fn metres_per_degree(latitude: f64) -> (f64, f64) {
    let phi = latitude.to_radians();
    let lon = 111_412.84 * phi.cos() - 93.5 * (3.0 * phi).cos() + 0.118 * (5.0 * phi).cos();
    let lat = 111_132.92 - 559.82 * (2.0 * phi).cos() + 1.175 * (4.0 * phi).cos() - 0.0023 * (6.0 * phi).cos();
    (lon, lat)
}

/// Size of a cell in metres along columns and rows. Geographic coordinates are measured in the middle of the grid;
/// `metres_per_unit` says how long a unit of projected coordinates is.
pub(crate) fn cell_size_m(g: &Georeference, width: usize, height: usize, metres_per_unit: f64) -> (f64, f64) {
    let t = &g.transform;
    let (per_x, per_y) = if g.geographic {
        let middle = t[3] + width as f64 / 2.0 * t[4] + height as f64 / 2.0 * t[5];
        // At a pole a degree of longitude has no length.
        metres_per_degree(middle.clamp(-89.0, 89.0))
    } else {
        (metres_per_unit, metres_per_unit)
    };
    // Rotated grids: the length of the step that one column and one row make.
    ((t[1] * per_x).hypot(t[4] * per_y), (t[2] * per_x).hypot(t[5] * per_y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_have_their_known_lengths() {
        // NGA tables for WGS 84.
        for (latitude, lon, lat) in
            [(0.0, 111_319.5, 110_574.3), (45.0, 78_846.8, 111_131.8), (60.0, 55_800.0, 111_412.2)]
        {
            let (a, b) = metres_per_degree(latitude);
            assert!((a - lon).abs() < 1.0 && (b - lat).abs() < 1.0, "{latitude}: {a} {b}");
        }
    }

    #[test]
    fn rotated_and_projected_cells_keep_their_size() {
        let (s, c) = 0.3f64.sin_cos();
        let g =
            Georeference { transform: [5e5, 30.0 * c, 30.0 * s, 4e6, 30.0 * s, -30.0 * c], ..Georeference::default() };
        let (x, y) = cell_size_m(&g, 10, 10, 1.0);
        assert!((x - 30.0).abs() < 1e-9 && (y - 30.0).abs() < 1e-9);
    }
}
