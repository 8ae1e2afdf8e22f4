//! What is kept of rivers and lakes: features and points with their attributes.

use crate::course::{Course, Pattern};
use crate::lakes::Lakes;
use crate::lines::{distance, length_m};
use crate::network::{End, Network, Reach};
use crate::rivers::Section;
use crate::shores;
use eyot_core::component::{Features, Form, Points, Type, signed_double_area};
use eyot_core::process::SECONDS_PER_YEAR;
use eyot_core::{Grid, Result};

/// What makes a waterfall: fall (m), slope (1), water (m3/s).
const FALL: (f64, f64, f64) = (5.0, 0.5, 0.5);

/// What is said of a reach; the names are those of HydroRIVERS where it has them.
const RIVER_ATTRIBUTES: [(&str, &str, Type); 16] = [
    ("HYRIV_ID", "1", Type::U32),
    ("NEXT_DOWN", "1", Type::U32),
    ("MAIN_RIV", "1", Type::U32),
    ("LENGTH_KM", "km", Type::F64),
    ("DIST_DN_KM", "km", Type::F64),
    ("DIST_UP_KM", "km", Type::F64),
    ("UPLAND_SKM", "km2", Type::F64),
    ("DIS_AV_CMS", "m3/s", Type::F64),
    ("ORD_STRA", "1", Type::U8),
    ("WIDTH_M", "m", Type::F64),
    ("DEPTH_M", "m", Type::F64),
    ("SLOPE", "1", Type::F64),
    ("LAKE_ID", "1", Type::U32),
    ("END", "1", Type::U8),
    ("PATTERN", "1", Type::U8),
    ("THREADS", "1", Type::U8),
];

/// The rivers as lines, one a reach, and the waterfalls on them. `section(reach)`: width and depth of each of its threads.
pub fn rivers(
    network: &Network,
    courses: &[Course],
    found: &Lakes,
    grid: &Grid,
    section: impl Fn(&Reach, usize) -> Section,
) -> Result<(Features, Points)> {
    let reaches = &network.reaches;
    let length: Vec<f64> = courses.iter().map(|c| length_m(&c.line)).collect();
    let drained = found.routing.upstream_cells();
    let upwards = found.routing.longest_upstream_m();
    let down = way_down(network, &length);
    let mut rivers = Features::new(Form::Lines, RIVER_ATTRIBUTES);
    let mut falls =
        Points::new([("drop", "m", Type::F32), ("discharge", "m3/s", Type::F32), ("slope", "1", Type::F32)]);
    for (k, (reach, course)) in reaches.iter().zip(courses).enumerate() {
        let section = section(reach, course.thread_count());
        let fall = f64::from(course.line[0][2]) - f64::from(course.line[course.line.len() - 1][2]);
        let last = reach.cells[reach.cells.len() - 2] as usize;
        let id = |r: u32| f64::from(r + 1);
        let end = match reach.end {
            End::Reach => 0.0,
            End::Sea => 1.0,
            End::Rim => 2.0,
            End::Lake => 3.0,
            End::Hollow => 4.0,
        };
        let pattern = match course.pattern {
            Pattern::Led => 0.0,
            Pattern::Meandering => 1.0,
            Pattern::Braided => 2.0,
        };
        let row = [
            id(k as u32),
            reach.next.map_or(0.0, id),
            id(reach.mouth),
            length[k] / 1000.0,
            down[k] / 1000.0,
            upwards[last] / 1000.0,
            f64::from(drained[last]) * grid.cell_area_m2() / 1e6,
            reach.discharge,
            f64::from(reach.order),
            section.width_m,
            section.depth_m,
            if length[k] > 0.0 { fall / length[k] } else { 0.0 },
            f64::from(reach.lake),
            end,
            pattern,
            course.thread_count() as f64,
        ];
        let lines: Vec<&[[f32; 3]]> = course.lines().collect();
        rivers.push(&lines, &row)?;
        if reach.lake == 0 {
            waterfalls(reach, course, found, &mut falls)?;
        }
    }
    Ok((rivers, falls))
}

/// Of each reach the way from its end to the mouth, m.
fn way_down(network: &Network, length: &[f64]) -> Vec<f64> {
    let reaches = &network.reaches;
    let mut down = vec![f64::NAN; reaches.len()];
    for k in 0..reaches.len() {
        let (mut way, mut at) = (vec![k], k);
        while let Some(next) = reaches[at].next.map(|n| n as usize).filter(|_| down[at].is_nan()) {
            way.push(next);
            at = next;
        }
        for at in way.into_iter().rev() {
            down[at] = reaches[at].next.map_or(0.0, |n| down[n as usize] + length[n as usize]);
        }
    }
    down
}

/// The steps of a reach over which water falls.
fn waterfalls(reach: &Reach, course: &Course, found: &Lakes, falls: &mut Points) -> Result<()> {
    for (k, pair) in reach.cells.windows(2).enumerate() {
        let (above, below) = (pair[0] as usize, pair[1] as usize);
        let drop = f64::from(found.surface[above]) - f64::from(found.surface[below]);
        let (slope, discharge) = (drop / found.routing.distance_m(above), found.discharge[above]);
        if drop > FALL.0 && slope > FALL.1 && discharge > FALL.2 {
            let at = course.place.partition_point(|p| (*p as usize) < k);
            falls.push(course.line[at], &[drop, discharge, slope])?;
        }
    }
    Ok(())
}

/// The lakes as polygons. `ground`: heights below the water, m.
pub fn lakes(found: &Lakes, ground: &[f32], grid: &Grid) -> Result<Features> {
    let mut features = Features::new(
        Form::Polygons,
        [
            ("LAKE_ID", "1", Type::U32),
            ("LEVEL_M", "m", Type::F32),
            ("AREA_SKM", "km2", Type::F64),
            ("VOLUME_M3", "m3", Type::F64),
            ("DEPTH_AVG", "m", Type::F64),
            ("DEPTH_MAX", "m", Type::F64),
            ("SHORE_KM", "km", Type::F64),
            ("INFLOW_CMS", "m3/s", Type::F64),
            ("OUTFLOW_CMS", "m3/s", Type::F64),
            ("RES_TIME_Y", "a", Type::F64),
            ("OUTLET_X", "m", Type::F64),
            ("OUTLET_Y", "m", Type::F64),
        ],
    );
    for (id, rings) in shores::shores(found, ground, grid).into_iter().enumerate().skip(1) {
        let lake = found.lakes[id];
        let parts: Vec<&[[f32; 3]]> = rings.iter().map(Vec::as_slice).collect();
        let area_m2 = f64::from(lake.cells) * grid.cell_area_m2();
        let place = |i: u32| {
            let (x, y) = (i as usize % grid.width, i as usize / grid.width);
            [(x as f64 + 0.5) * grid.cell_x_m, (y as f64 + 0.5) * grid.cell_y_m]
        };
        let outlet = lake.outlet.map_or([f64::NAN; 2], place);
        let row = [
            id as f64,
            f64::from(lake.level),
            area_m2 / 1e6,
            lake.volume_m3,
            lake.volume_m3 / area_m2,
            lake.max_depth_m,
            rings.iter().map(|ring| length_m(ring)).sum::<f64>() / 1000.0,
            lake.inflow,
            lake.outflow,
            if lake.inflow > 0.0 { lake.volume_m3 / lake.inflow / SECONDS_PER_YEAR } else { f64::NAN },
            outlet[0],
            outlet[1],
        ];
        if !parts.is_empty() {
            features.push(&parts, &row)?;
        }
    }
    Ok(features)
}

/// The oxbow lakes as polygons, each as wide as its river was.
pub fn oxbows(network: &Network, courses: &[Course], width: impl Fn(&Reach) -> f64) -> Result<Features> {
    let mut features = Features::new(
        Form::Polygons,
        [
            ("HYRIV_ID", "1", Type::U32),
            ("LEVEL_M", "m", Type::F32),
            ("AREA_SKM", "km2", Type::F64),
            ("LENGTH_KM", "km", Type::F64),
            ("WIDTH_M", "m", Type::F64),
        ],
    );
    for (k, (reach, course)) in network.reaches.iter().zip(courses).enumerate() {
        let width = width(reach);
        for oxbow in &course.oxbows {
            let mut ring: Vec<[f32; 3]> = Vec::new();
            let line = &oxbow.line;
            let last = line.len() - 1;
            for side in [1.0, -1.0] {
                let bank = |i: usize| {
                    let (a, b) = (line[i.saturating_sub(1)], line[(i + 1).min(last)]);
                    let size = distance(a, b).max(1e-9);
                    // The water narrows to its ends.
                    let half = side * width * if i == 0 || i == last { 0.15 } else { 0.5 };
                    let normal = [(b[1] - a[1]) / size, (a[0] - b[0]) / size];
                    [(line[i][0] + half * normal[0]) as f32, (line[i][1] + half * normal[1]) as f32, oxbow.level]
                };
                if side > 0.0 {
                    ring.extend((0..=last).map(bank));
                } else {
                    ring.extend((0..=last).rev().map(bank));
                }
            }
            ring.push(ring[0]);
            let area = signed_double_area(&ring);
            if area < 0.0 {
                ring.reverse();
            }
            let km = crate::lines::length(line) / 1000.0;
            let row = [(k + 1) as f64, f64::from(oxbow.level), 0.5 * area.abs() / 1e6, km, width];
            features.push(&[&ring], &row)?;
        }
    }
    Ok(features)
}
