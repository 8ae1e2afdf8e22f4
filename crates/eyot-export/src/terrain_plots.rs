//! Plots of a terrain's curves as drawings and pictures.

use crate::chart::{Axis, COLOURS, Chart, Curve};
use crate::error::ExportError;
use eyot_io as io;
use eyot_land::analyse::TerrainCurves;
use std::path::{Path, PathBuf};

/// Writes `hypsometry`, `slope_area` and `rivers` as `.svg` and `.png` into a folder that is there, and says which.
///
/// # Errors
/// If a file cannot be written.
pub fn terrain_plots(curves: &TerrainCurves, name: &str, folder: &Path) -> Result<Vec<PathBuf>, ExportError> {
    let mut files = Vec::new();
    for (file, chart) in charts(curves, name) {
        let drawing = chart.draw();
        let path = folder.join(format!("{file}.svg"));
        io::write_text(&path, &drawing.svg()).map_err(ExportError::file)?;
        files.push(path);
        let (path, p) = (folder.join(format!("{file}.png")), drawing.picture());
        io::write_rgb_png(&path, p.width, p.height, &p.pixels).map_err(ExportError::file)?;
        files.push(path);
    }
    Ok(files)
}

fn charts(c: &TerrainCurves, name: &str) -> [(&'static str, Chart); 3] {
    let axis = |label: &str, log| Axis { label: label.to_owned(), log };
    let curve = |name: String, colour, points: Vec<[f64; 2]>, line| Curve { name, colour, points, line };
    let area_km2 = c.channel_area_m2 / 1e6;
    let mut slope_area = vec![curve("median of a bin".into(), COLOURS[0], c.slope_area.clone(), false)];
    if let Some(([theta, k], (first, last))) = c.fit.zip(c.slope_area.first().zip(c.slope_area.last())) {
        let at = |p: &[f64; 2]| [p[0], k * p[0].powf(-theta)];
        slope_area.push(curve(format!("theta = {theta:.2}"), COLOURS[1], vec![at(first), at(last)], true));
    }
    let river = |(i, line): (usize, &Vec<[f64; 2]>)| {
        let points = line.iter().map(|p| [p[0] / 1000.0, p[1]]).collect();
        curve(format!("river {}", i + 1), COLOURS[i % COLOURS.len()], points, true)
    };
    [
        (
            "hypsometry",
            Chart {
                title: format!("{name}: hypsometric curve of the land"),
                x: axis("share of the land that lies higher", false),
                y: axis("height (m)", false),
                curves: vec![curve(String::new(), COLOURS[0], c.hypsometry.clone(), true)],
                note: String::new(),
            },
        ),
        (
            "slope_area",
            Chart {
                title: format!("{name}: slope and drained area, S = k A^-theta"),
                x: axis("drained area (m2)", true),
                y: axis("slope (m/m)", true),
                curves: slope_area,
                note: format!("from a fifth of the channel area of {area_km2:.3} km2 on"),
            },
        ),
        (
            "rivers",
            Chart {
                title: format!("{name}: profiles of the largest rivers"),
                x: axis("distance from the mouth (km)", false),
                y: axis("height (m)", false),
                curves: c.rivers.iter().enumerate().map(river).collect(),
                note: format!("where more than {area_km2:.3} km2 drain"),
            },
        ),
    ]
}
