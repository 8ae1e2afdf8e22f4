//! The measures of a real tile, held against numbers that other programs computed.

use eyot_core::{Boundary, Field, Grid, Limits};
use eyot_land::analyse::{LandformShares, TerrainOptions, TerrainStats, terrain_stats};

const COLUMNS: usize = 403;
const ROWS: usize = 344;

fn data(path: &str) -> Vec<u8> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn tile() -> Field {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif");
    let raster = eyot_io::read_raster(&path, &eyot_io::ReadOptions::default(), &Limits::default()).unwrap();
    assert_eq!((raster.field.width(), raster.field.height(), raster.filled()), (COLUMNS, ROWS, 0));
    raster.field
}

/// The tile as the reference table saw it: columns drawn together to square cells by linear interpolation, with the
/// latitude 36.6 N of the source's metadata, from column 0 on. The rows are 92.7 m apart.
fn squared() -> (Field, Grid) {
    let z = tile();
    let step = 1.0 / 36.6_f64.to_radians().cos();
    let columns = ((COLUMNS - 1) as f64 / step) as usize + 1;
    let square = Field::from_fn(columns, ROWS, |x, y| {
        let at = x as f64 * step;
        let (i, t) = (at as usize, at.fract());
        let (a, b) = (f64::from(z.get(i, y)), f64::from(z.get((i + 1).min(COLUMNS - 1), y)));
        (a + (b - a) * t) as f32
    });
    (square, Grid::new(columns, ROWS, 92.66, Boundary::CLOSED, &Limits::default()).unwrap())
}

fn measure(z: &Field, grid: &Grid) -> TerrainStats {
    let options =
        TerrainOptions { channel_area_m2: Some(5e6), concavity_area_m2: Some(1e6), ..TerrainOptions::default() };
    terrain_stats(z, grid, None, &options, &Limits::default()).unwrap()
}

/// Row "jacksboro_90m" of the reference table, computed with other programs. The tolerances say how well a definition is
/// known: the table has three digits, its exact resampling is not recorded, and moving that by a fraction of a column moves
/// pits and depressions by 1 to 3 %.
///
/// The last six depend on the routing. The table's let each cell drain to the neighbour from which priority flood reached it,
/// without regard to distance; with that routing our definitions give Hack 0.6237, density 0.2978 and theta 0.570. Steepest
/// descent gives 0.5933, 0.2946 and 0.634 here, and an independent program the same (`jacksboro_network.py`). Theta is the
/// least certain measure: on heights rounded to metres the few bins of the trunk streams decide it.
#[test]
fn measures_agree_with_the_reference_table() {
    let (z, grid) = squared();
    let s = measure(&z, &grid);
    println!("{}", serde_json::to_string_pretty(&s).unwrap());
    let rows = [
        ("hypsometric integral", s.hypsometric_integral, 0.348, 0.001),
        ("slope mean", s.slope_mean_deg, 12.9, 0.05),
        ("slope p95", s.slope_p95_deg, 24.3, 0.05),
        ("slope skew", s.slope_skew, 0.105, 0.004),
        ("beta 2D", s.beta_2d, 3.29, 0.02),
        ("H", s.hurst, 0.700, 0.003),
        ("curvature skew", s.curvature_skew, -0.0766, 0.0005),
        ("pits per 1000", s.pits_per_1000, 11.6, 0.1),
        ("depression fraction", s.depression_fraction, 0.0541, 0.0005),
        ("mean fill", s.fill_mean_m, 0.279, 0.004),
        ("theta", s.concavity, 0.558, 0.08),
        ("Hack", s.hack, 0.624, 0.035),
        ("R_B", s.horton_bifurcation, 3.57, 0.1),
        ("R_L", s.horton_length, 2.54, 0.15),
        ("R_A", s.horton_area, 3.91, 0.15),
        ("drainage density", s.drainage_density_per_km, 0.298, 0.004),
    ];
    let mut wrong = Vec::new();
    for (name, ours, theirs, tolerance) in rows {
        let ours = ours.unwrap_or_else(|| panic!("{name} is missing"));
        println!("{name:22} {ours:9.4} {theirs:9.4} {:+.2} %", 100.0 * (ours / theirs - 1.0));
        if (ours - theirs).abs() > tolerance {
            wrong.push(name);
        }
    }
    let reference = [0.0, 0.032, 0.148, 0.004, 0.174, 0.313, 0.132, 0.008, 0.151, 0.038];
    let ours = s.landforms.as_ref().map(LandformShares::to_array).unwrap();
    for (o, r) in ours.into_iter().zip(reference) {
        println!("{o:.4} {r:.4}");
        if (o - r).abs() > 0.002 {
            wrong.push("geomorphons");
        }
    }
    assert!((ours.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// `fixtures/jacksboro_network.py`: routing, orders and fits written a second time in numpy, orders by pyflwdir.
#[test]
fn the_network_agrees_with_numpy_and_pyflwdir() {
    let theirs: serde_json::Value = serde_json::from_slice(&data("tests/fixtures/jacksboro_network.json")).unwrap();
    let s = measure(&tile(), &Grid::new(COLUMNS, ROWS, 90.0, Boundary::CLOSED, &Limits::default()).unwrap());
    let ours = serde_json::to_value(&s).unwrap();
    for (name, value) in theirs.as_object().unwrap() {
        let (a, b) = (ours[name].as_f64().unwrap(), value.as_f64().unwrap());
        assert!((a - b).abs() <= 1e-6 * b.abs(), "{name}: {a}, numpy found {b}");
    }
}

/// The tile as it is, on its own oblong cells: the same land, so measures that do not see single cells stay close.
#[test]
fn oblong_cells_measure_the_same_land() {
    let (square, square_grid) = squared();
    let a = measure(&square, &square_grid);
    let oblong = Grid {
        cell_x_m: 74.4,
        cell_y_m: 92.66,
        ..Grid::new(COLUMNS, ROWS, 1.0, Boundary::CLOSED, &Limits::default()).unwrap()
    };
    let b = measure(&tile(), &oblong);
    println!("{}", serde_json::to_string_pretty(&b).unwrap());
    let close = |name: &str, a: Option<f64>, b: Option<f64>, tolerance: f64| {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((a - b).abs() <= tolerance, "{name}: {a} on square, {b} on oblong cells");
    };
    close("hypsometric integral", a.hypsometric_integral, b.hypsometric_integral, 0.01);
    close("slope", a.slope_mean_deg, b.slope_mean_deg, 0.7);
    close("beta", a.beta_2d, b.beta_2d, 0.15);
    close("density", a.drainage_density_per_km, b.drainage_density_per_km, 0.02);
    close("Hack", a.hack, b.hack, 0.05);
    close("R_A", a.horton_area, b.horton_area, 0.5);
    for (a, b) in a.landforms.unwrap().to_array().into_iter().zip(b.landforms.unwrap().to_array()) {
        assert!((a - b).abs() < 0.02, "{a} {b}");
    }
}
