//! Measures of a graph of rivers and its lakes: Horton's ratios, Hack's law, sinuosity, density, widths.
//!
//! # Source
//! Horton 1945 and Strahler 1957 for the ratios (the mean over orders of the ratios between neighbouring ones, by a straight line through
//! the logarithms); Hack 1957.

use crate::lines::{distance, length_m, plane};
use crate::{LAKES, OXBOWS, RIVERS};
use eyot_core::component::{Attributes, Features};
use eyot_core::math64::{exp, ln};
use eyot_core::{Result, World};
use serde::Serialize;

/// What is said of the rivers and lakes that a world keeps.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GraphStats {
    /// Reaches outside of lakes.
    pub reaches: usize,
    /// River systems: mouths.
    pub systems: usize,
    /// Length of all rivers, km.
    pub length_km: f64,
    /// Length of rivers for an area of the grid, km/km2.
    pub density_per_km: f64,
    /// Highest order.
    pub highest_order: u8,
    /// How many times fewer streams the next order has; `None` below three orders.
    pub bifurcation_ratio: Option<f64>,
    /// How many times longer the streams of the next order are.
    pub length_ratio: Option<f64>,
    /// `L ~ A^h`: the longest way from the divide over the drained area, over all reaches' lower ends.
    pub hack_exponent: Option<f64>,
    /// Length of streams over the straight way, mean by length, of reaches of ten vertices or more.
    pub sinuosity: Option<f64>,
    /// `w ~ Q^b`.
    pub width_exponent: Option<f64>,
    /// Reaches that made bends of their own.
    pub meandering: usize,
    /// Reaches in several threads.
    pub braided: usize,
    /// Bends that were cut off and stay as lakes.
    pub oxbow_lakes: usize,
    /// Waters that stand.
    pub lakes: usize,
    /// Of those without an outflow.
    pub closed_lakes: usize,
    /// Their area, km2.
    pub lake_area_km2: f64,
    /// Their volume, km3.
    pub lake_volume_km3: f64,
}

/// Measures the rivers and lakes that `world` keeps; `None` if it keeps none.
///
/// # Errors
/// If components of those names are something else.
pub fn graph_stats(world: &World) -> Result<Option<GraphStats>> {
    let Some(rivers) = world.components.get::<Features>(RIVERS)? else { return Ok(None) };
    let area_km2 = world.grid.cells() as f64 * world.grid.cell_area_m2() / 1e6;
    let mut stats = of_rivers(rivers, area_km2);
    if let Some(lakes) = world.components.get::<Features>(LAKES)? {
        stats.lakes = lakes.len();
        stats.closed_lakes = column(lakes.attributes(), "OUTFLOW_CMS").iter().filter(|q| **q <= 0.0).count();
        stats.lake_area_km2 = column(lakes.attributes(), "AREA_SKM").iter().sum();
        stats.lake_volume_km3 = column(lakes.attributes(), "VOLUME_M3").iter().sum::<f64>() / 1e9;
    }
    stats.oxbow_lakes = world.components.get::<Features>(OXBOWS)?.map_or(0, Features::len);
    Ok(Some(stats))
}

/// The values of an attribute; none if it is missing.
fn column(attributes: &Attributes, name: &str) -> Vec<f64> {
    let found = attributes.get(name).map(|a| &a.values);
    found.map_or_else(Vec::new, |v| (0..v.len()).map(|i| v.number(i)).collect())
}

fn of_rivers(rivers: &Features, area_km2: f64) -> GraphStats {
    let of = |name: &str| column(rivers.attributes(), name);
    let (next, order, length, lake) = (of("NEXT_DOWN"), of("ORD_STRA"), of("LENGTH_KM"), of("LAKE_ID"));
    let (area, longest) = (of("UPLAND_SKM"), of("DIST_UP_KM"));
    let (discharge, width, threads) = (of("DIS_AV_CMS"), of("WIDTH_M"), of("THREADS"));
    let n = rivers.len();
    if [&next, &order, &length, &lake, &area, &longest, &discharge, &width, &threads].iter().any(|c| c.len() != n) {
        return GraphStats::default();
    }
    let open: Vec<usize> = (0..n).filter(|k| lake[*k] == 0.0).collect();
    let length_km: f64 = open.iter().map(|k| length[*k]).sum();
    let highest = order.iter().copied().fold(0.0, f64::max) as u8;
    // A stream is a chain of reaches of one order: it ends where the next one has another.
    let (mut streams, mut lengths) = (vec![0.0; usize::from(highest) + 1], vec![0.0; usize::from(highest) + 1]);
    for k in 0..n {
        let ends = next[k] == 0.0 || order[next[k] as usize - 1] != order[k];
        streams[order[k] as usize] += f64::from(u8::from(ends));
        lengths[order[k] as usize] += length[k];
    }
    let orders: Vec<usize> = (1..=usize::from(highest)).collect();
    let slope = |values: Vec<f64>| {
        let points: Vec<(f64, f64)> = orders.iter().map(|o| *o as f64).zip(values.into_iter().map(ln)).collect();
        (points.len() >= 3).then(|| line(&points)).flatten()
    };
    let counts = slope(orders.iter().map(|o| streams[*o]).collect());
    let means = slope(orders.iter().map(|o| lengths[*o] / streams[*o].max(1.0)).collect());
    let hack: Vec<(f64, f64)> = open
        .iter()
        .filter(|k| area[**k] > 0.0 && longest[**k] > 0.0)
        .map(|k| (ln(area[*k]), ln(longest[*k])))
        .collect();
    let widths: Vec<(f64, f64)> = open
        .iter()
        .filter(|k| discharge[**k] > 0.0 && width[**k] > 0.0 && threads[**k] == 1.0)
        .map(|k| (ln(discharge[*k]), ln(width[*k])))
        .collect();
    GraphStats {
        reaches: open.len(),
        systems: next.iter().filter(|n| **n == 0.0).count(),
        length_km,
        density_per_km: if area_km2 > 0.0 { length_km / area_km2 } else { 0.0 },
        highest_order: highest,
        bifurcation_ratio: counts.map(|s| exp(-s)),
        length_ratio: means.map(exp),
        hack_exponent: line(&hack),
        sinuosity: sinuosity(rivers, &open),
        width_exponent: line(&widths),
        meandering: of("PATTERN").iter().filter(|p| **p == 1.0).count(),
        braided: of("PATTERN").iter().filter(|p| **p == 2.0).count(),
        ..GraphStats::default()
    }
}

fn sinuosity(rivers: &Features, open: &[usize]) -> Option<f64> {
    let (mut along, mut straight) = (0.0, 0.0);
    for line in open.iter().flat_map(|k| rivers.parts(*k)).filter(|l| l.len() >= 10) {
        along += length_m(line);
        straight += distance(plane(&line[0]), plane(&line[line.len() - 1]));
    }
    (straight > 0.0).then(|| along / straight)
}

/// The slope of the straight line through points by least squares.
fn line(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let (xx, xy) = points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p.0 - x) * (p.0 - x), b + (p.0 - x) * (p.1 - y)));
    (points.len() >= 2 && xx > 0.0).then(|| xy / xx)
}
