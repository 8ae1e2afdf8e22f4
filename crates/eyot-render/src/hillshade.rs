//! Hillshade from several directions: a main light, two at its sides and one overhead, so that no slope is lost.

use crate::ground::{Ground, quantile, slopes};
use crate::math::{V3, direction, dot, unit};

/// Lights with their weights, mirror images of each other about the main light.
pub(crate) struct Hillshade {
    lights: [(V3, f32); 4],
    exaggeration: f32,
    /// Steepest slope that is drawn, rise over run; slopes come near to it.
    steepest: f32,
}

/// Exaggeration from which on slopes are no longer those of ground that one could stand on.
const OF_PLANETS: f32 = 12.0;

impl Hillshade {
    pub(crate) fn new(azimuth_deg: f32, elevation_deg: f32, exaggeration: f32) -> Self {
        let light = |turn: f32, lift: f32| direction(azimuth_deg + turn, (elevation_deg + lift).min(90.0));
        Self {
            lights: [
                (light(0.0, 0.0), 0.62),
                (light(62.0, 0.0), 0.17),
                (light(-62.0, 0.0), 0.17),
                ([0.0, 0.0, 1.0], 0.22),
            ],
            exaggeration,
            // A range that is a cell wide would be a black line on a map of a planet.
            steepest: if exaggeration > OF_PLANETS { 1.2 } else { f32::INFINITY },
        }
    }

    /// Brightness of a slope (rise per metre eastward and southward), about 0..1.
    pub(crate) fn at(&self, slope: [f32; 2]) -> f32 {
        let [east, south] = slope.map(|s| s * self.exaggeration);
        let n = unit([-east, -south, (1.0 + (east * east + south * south) / self.steepest.powi(2)).sqrt()]);
        0.05 + self.lights.iter().map(|(l, weight)| weight * dot(n, *l).max(0.0)).sum::<f32>()
    }

    /// Brightness of level ground.
    pub(crate) fn level(&self) -> f32 {
        self.at([0.0; 2])
    }
}

/// Rise per metre eastward and southward at a pixel: Sobel's kernel, borders repeated.
pub(crate) fn gradient(z: &[f32], w: usize, h: usize, cell: [f32; 2], x: usize, y: usize) -> [f32; 2] {
    let (x0, x1) = (x.saturating_sub(1), (x + 1).min(w - 1));
    let (y0, y1) = (y.saturating_sub(1), (y + 1).min(h - 1));
    let at = |x: usize, y: usize| z[y * w + x];
    let east = (at(x1, y0) + at(x1, y1)) + 2.0 * at(x1, y);
    let west = (at(x0, y0) + at(x0, y1)) + 2.0 * at(x0, y);
    let south = (at(x0, y1) + at(x1, y1)) + 2.0 * at(x, y1);
    let north = (at(x0, y0) + at(x1, y0)) + 2.0 * at(x, y0);
    let run = |a: usize, b: usize, cell: f32| 4.0 * (b - a).max(1) as f32 * cell;
    [(east - west) / run(x0, x1, cell[0]), (south - north) / run(y0, y1, cell[1])]
}

/// Brings the steeper quarter of the land to a slope that shades well. Cells of many kilometres, which flatten mountains, take more of it.
pub(crate) fn automatic_exaggeration(g: &Ground) -> f32 {
    let all = slopes(g);
    let step = (all.len() / 65_536).max(1) | 1;
    let land: Vec<f32> = (0..all.len()).step_by(step).filter(|&i| !g.sea || g.z[i] > 0.0).map(|i| all[i]).collect();
    if land.is_empty() {
        return 1.0;
    }
    let most = OF_PLANETS.max(g.cell[0].max(g.cell[1]) / 500.0);
    (0.55 / quantile(&land, 0.75).max(1e-6)).clamp(0.7, most)
}
