//! Pictures of a reef: as a diver sees it, from the side, and from above.
//!
//! Plots that a diver overlooks are drawn whole, on a sea floor that goes on around them. Larger ones, slopes above all, are a block
//! from the side, as in textbooks, and the diver stands where most corals live. Each body is as fine as its pixels ask for.

use crate::corals::{ALGAE, Reef, turn};
use eyot_core::rng::mix64;
use eyot_core::{Limits, Result};
use eyot_reef::bodies::{Body, ColonyShape, Detail, Sculptor};
use eyot_reef::community::Colony;
use eyot_render::{Camera, Haze, MeshPart, MeshViewOptions, Picture, mesh_view, mesh_view_bytes};
use rayon::prelude::*;

/// Pixels of the diver's picture.
const DIVE: [usize; 2] = [1400, 900];
/// Columns of the pictures from the side and from above.
const WIDE: usize = 1600;
/// Light that clear water takes, 1/m, red first, and the colour of far water.
const WATER: Haze = Haze { per_m: [0.16, 0.05, 0.045], veil: [0.02, 0.16, 0.24] };
/// Linear colours of sand, of reef rock, of turf on it, and of the sides of a block.
const SAND: [f32; 3] = [118.0, 104.0, 78.0];
const ROCK: [f32; 3] = [66.0, 54.0, 42.0];
const TURF: [f32; 3] = [46.0, 50.0, 22.0];
const CUT: [f32; 3] = [52.0, 46.0, 37.0];
/// Depth of a band on the sides of a block, m; more where there would be more than [`MOST_BANDS`].
const BAND_M: f32 = 5.0;
const MOST_BANDS: f32 = 200.0;
/// Plots up to this side are overlooked from one place, m.
const OVERLOOKED_M: f32 = 25.0;
/// What a diver on a larger one sees, m: further out there is only water.
const SIGHT_M: f32 = 45.0;
/// Share of the water above that a picture from outside shows: all of it would leave the deep black.
const SHOWN_DEPTH: f32 = 0.35;
/// Least radius of a colony that is drawn, in pixels.
const LEAST_PIXELS: f32 = 0.7;
/// How finely bodies are meshed that have so many pixels along their radius at most.
const DETAILS: [(f32, Detail); 3] = [
    (5.0, Detail { solid_m: 0.6, open_m: 0.2, per_radius: 3.0, rounds: 0 }),
    (18.0, Detail { solid_m: 0.25, open_m: 0.06, per_radius: 5.0, rounds: 1 }),
    (f32::INFINITY, Detail { solid_m: 0.1, open_m: 0.03, per_radius: 8.0, rounds: 1 }),
];

/// Bytes that the diver's picture takes of a sea floor without corals, which every reef is asked for.
pub(crate) fn least_bytes() -> u128 {
    let camera = Camera::looking([0.0, -1.0, 1.0], [0.0; 3], 48.0);
    mesh_view_bytes(0, 0, &MeshViewOptions::new(camera, DIVE, Some(WATER)))
}

/// A picture to be made.
struct Shot {
    camera: Camera,
    size: [usize; 2],
    haze: Option<Haze>,
    /// Only what is so near to this place, m.
    within: Option<([f32; 2], f32)>,
    /// Ends at the plot's border, with walls, instead of going on.
    is_block: bool,
}

/// The sea floor as a mesh.
#[derive(Default)]
struct Floor {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colours: Vec<[u8; 4]>,
    indices: Vec<u32>,
}

/// The three pictures, in the order of the files.
///
/// # Errors
/// If a body cannot be made, or a picture exceeds the limits.
pub(crate) fn pictures(reef: &Reef<'_>, limits: &Limits) -> Result<Vec<Picture>> {
    let shots = shots(reef);
    let bodies = bodies(reef, &shots)?;
    shots.iter().map(|shot| draw(reef, &bodies, shot, limits)).collect()
}

fn shots(reef: &Reef<'_>) -> [Shot; 3] {
    let [w, h] = reef.sides();
    let far = w.max(h);
    let is_small = far <= OVERLOOKED_M;
    let [low, high] = reef.heights();
    let middle = [0.5 * w, 0.5 * h, reef.floor(0.5 * w, 0.5 * h)];
    let (dive, within) = if is_small {
        let eye = [0.4 * w, h + 0.3 * far, middle[2] + 0.28 * far];
        (Camera::looking(eye, [0.5 * w, 0.45 * h, middle[2]], 48.0), None)
    } else {
        diver(reef)
    };
    // From so far away that parallel lines look parallel. The longer side is the picture's width.
    let deep = 0.5 * (low + high);
    let distance = 2.4 * far + 0.5 * w.min(h);
    let rise = 0.42 * distance;
    let (side_eye, from_above) = if w >= h {
        ([0.5 * w, 0.5 * h + distance, deep + rise], w / h)
    } else {
        ([0.5 * w + distance, 0.5 * h, deep + rise], w / h)
    };
    let (shown, way) = ((w.min(h) * 0.42 + (high - low) + 0.12 * far) / far, distance.hypot(rise));
    let rows = |share: f32| ((WIDE as f32 * share) as usize).clamp(300, 1200);
    let side_rows = rows(1.06 * shown);
    let angle = |length: f32, way: f32| (2.0 * (0.5 * length / way).atan()).to_degrees();
    let side_view = angle(1.1 * far * side_rows as f32 / WIDE as f32, way - 0.5 * w.min(h));
    let above_rows = rows(1.0 / from_above);
    // Narrow plots do not fill the width.
    let (height, share) = (3.0 * far, above_rows as f32 / WIDE as f32);
    let above_view = angle(1.01 * (w * share).max(h), height);
    [
        Shot { camera: dive, size: DIVE, haze: Some(WATER), within, is_block: false },
        Shot {
            camera: Camera::looking(side_eye, [middle[0], middle[1], deep], side_view.max(5.0)),
            size: [WIDE, side_rows],
            haze: None,
            within: None,
            is_block: true,
        },
        // Colours are judged from above, so there the water is left out.
        Shot {
            camera: Camera::looking([middle[0], middle[1] + 0.01, middle[2] + height], middle, above_view.max(5.0)),
            size: [WIDE.min((above_rows as f32 * from_above.max(1.0)) as usize + 1), above_rows],
            haze: None,
            within: None,
            is_block: !is_small,
        },
    ]
}

/// A diver who looks up the slope at the place with most corals, and what there is to see from there.
fn diver(reef: &Reef<'_>) -> (Camera, Option<([f32; 2], f32)>) {
    const CELL: f32 = 6.0;
    let [w, h] = reef.sides();
    let (columns, rows) = ((w / CELL).ceil() as usize, (h / CELL).ceil() as usize);
    let mut cover = vec![0.0f32; columns * rows];
    for c in reef.plot.colonies() {
        let at = |v: f32, n: usize| ((v / CELL) as usize).min(n - 1);
        cover[at(c.y, rows) * columns + at(c.x, columns)] += c.area_m2();
    }
    // In good light, with room for the diver.
    let suits = |x: f32, y: f32| {
        let depth = reef.sea_level - reef.floor(x, y);
        let inside = x > 12.0 && x < w - 12.0 && y > 12.0 && y < h - 12.0;
        if (4.0..=20.0).contains(&depth) && inside { 1.0 } else { 0.01 }
    };
    let place = |n: usize| [((n % columns) as f32 + 0.5) * CELL, ((n / columns) as f32 + 0.5) * CELL];
    let worth = |n: usize| {
        let [x, y] = place(n);
        cover[n].min(0.8 * CELL * CELL) * suits(x, y)
    };
    let best = (0..cover.len()).max_by(|&a, &b| worth(a).total_cmp(&worth(b)).then(b.cmp(&a))).unwrap_or(0);
    let [x, y] = place(best);
    let slope = |dx: f32, dy: f32| reef.floor(x + dx, y + dy) - reef.floor(x - dx, y - dy);
    let (east, south) = (slope(8.0, 0.0), slope(0.0, 8.0));
    let steep = east.hypot(south).max(1e-6);
    // Down the slope and a little aside, for straight up a wall there is no depth; and where no boulder blocks the view.
    let down = [-east / steep, -south / steep];
    let target = reef.floor(x, y) + 0.6;
    let stand = |(angle, away): (f32, f32)| {
        let (s, c) = angle.sin_cos();
        let (ex, ey) = (x + away * (c * down[0] - s * down[1]), y + away * (c * down[1] + s * down[0]));
        [ex, ey, (reef.floor(ex, ey) + 2.2).max(target + 1.2).min(reef.sea_level - 0.5)]
    };
    // The nearest side of a colony that is higher than the grass, from the eye and half way to the target.
    let room = |[ex, ey, eye]: [f32; 3]| {
        let free = |px: f32, py: f32, pz: f32| {
            let far = |c: &Colony| {
                let up = reef.floor(c.x, c.y) + 0.6 * c.radius - pz;
                (c.x - px).hypot(c.y - py).hypot(up) - c.radius
            };
            let large = reef.plot.colonies().iter().filter(|c| c.radius > 0.25);
            large.map(far).fold(6.0f32, f32::min)
        };
        let half = [0.5 * (ex + x), 0.5 * (ey + y), 0.5 * (eye + target) + 0.4];
        free(ex, ey, eye).min(1.5 + free(half[0], half[1], half[2]))
    };
    let angles = (-3..=3).map(|a| 0.3 * a as f32);
    let stands: Vec<[f32; 3]> = angles.flat_map(|a| [7.0, 8.5, 10.0].map(|away| (0.45 + a, away))).map(stand).collect();
    let [ex, ey, eye] =
        stands.iter().copied().max_by(|a, b| room(*a).total_cmp(&room(*b))).unwrap_or(stand((0.45, 8.5)));
    let camera = Camera::looking([ex, ey, eye], [x, y, target], 55.0);
    (camera, Some(([ex, ey], SIGHT_M)))
}

impl Shot {
    fn shows(&self, x: f32, y: f32) -> bool {
        self.within.is_none_or(|([cx, cy], reach)| (x - cx).hypot(y - cy) < reach)
    }

    /// Pixels of a length at a place.
    fn pixels(&self, length: f32, place: [f32; 3]) -> f32 {
        let far = (0..3).map(|i| (place[i] - self.camera.eye[i]).powi(2)).sum::<f32>().sqrt();
        length / (far.max(0.1) * self.camera.pixel(self.size[1]))
    }
}

/// A body for each colony that any picture shows, in the order of the colonies.
fn bodies(reef: &Reef<'_>, shots: &[Shot; 3]) -> Result<Vec<Option<Body>>> {
    let community = reef.plot.community();
    let sculptors: Vec<Sculptor> =
        DETAILS.iter().map(|(_, detail)| Sculptor::new(community, reef.seed, *detail)).collect::<Result<_>>()?;
    let colonies = reef.plot.colonies().par_iter().zip(reef.plot.rays());
    colonies
        .map(|(c, rays)| {
            let place = [c.x, c.y, reef.floor(c.x, c.y)];
            let shown = shots.iter().filter(|s| s.shows(c.x, c.y)).map(|s| s.pixels(c.radius, place));
            let pixels = shown.fold(0.0, f32::max);
            if pixels < LEAST_PIXELS {
                return Ok(None);
            }
            let sculptor = &sculptors[DETAILS.iter().position(|(most, _)| pixels <= *most).unwrap_or(0)];
            let shape = ColonyShape {
                id: c.id,
                species: usize::from(c.species),
                rays,
                bleaching: c.bleaching,
                slope: reef.slope(c.x, c.y, c.radius),
            };
            sculptor.body(&shape).map(Some)
        })
        .collect()
}

fn draw(reef: &Reef<'_>, bodies: &[Option<Body>], shot: &Shot, limits: &Limits) -> Result<Picture> {
    let floor = floor(reef, shot);
    let is_tinted = shot.haze.is_none() && reef.is_slope();
    let tint = |depth: f32| if is_tinted { daylight(SHOWN_DEPTH * depth) } else { [1.0; 3] };
    let depth = |x: f32, y: f32| reef.sea_level - reef.floor(x, y);
    let seen: Vec<_> = reef
        .plot
        .colonies()
        .iter()
        .zip(bodies)
        .filter_map(|(c, b)| Some((c, b.as_ref()?)))
        .filter(|(c, _)| {
            shot.shows(c.x, c.y) && shot.pixels(c.radius, [c.x, c.y, reef.floor(c.x, c.y)]) >= LEAST_PIXELS
        })
        .collect();
    let colours: Vec<Vec<[u8; 4]>> = seen
        .par_iter()
        .map(|(c, b)| {
            let light = tint(depth(c.x, c.y));
            b.colours.iter().map(|v| dimmed(*v, light)).collect()
        })
        .collect();
    let algae: Vec<_> = reef
        .algae()
        .filter(|a| shot.shows(a.x, a.y) && shot.pixels(a.height, [a.x, a.y, reef.floor(a.x, a.y)]) >= 2.0)
        .collect();
    // Every alga of a depth has the same colours.
    let fronds: Vec<Vec<[u8; 4]>> =
        (0..=60).map(|d| vec![dimmed(ALGAE, tint(d as f32)); reef.alga.positions.len()]).collect();
    let mut parts = vec![MeshPart {
        positions: &floor.positions,
        normals: &floor.normals,
        colours: &floor.colours,
        indices: &floor.indices,
        place: [0.0; 3],
        turn: 0.0,
        size: 1.0,
        shades: false,
    }];
    parts.extend(seen.iter().zip(&colours).map(|((c, b), colours)| MeshPart {
        positions: &b.solid.positions,
        normals: &b.solid.normals,
        colours,
        indices: &b.solid.indices,
        place: [c.x, c.y, reef.floor(c.x, c.y)],
        turn: 0.0,
        size: 1.0,
        shades: true,
    }));
    parts.extend(algae.iter().map(|a| MeshPart {
        positions: &reef.alga.positions,
        normals: &reef.alga.normals,
        colours: &fronds[(depth(a.x, a.y).max(0.0) as usize).min(60)],
        indices: &reef.alga.indices,
        place: [a.x, a.y, reef.floor(a.x, a.y)],
        turn: turn(a),
        size: a.height,
        shades: true,
    }));
    let mut options = MeshViewOptions::new(shot.camera, shot.size, shot.haze);
    if shot.is_block {
        options.background = [[0.012, 0.05, 0.075], [0.05, 0.2, 0.27]];
    }
    let sum = |f: fn(&MeshPart<'_>) -> usize| parts.iter().map(|p| f(p) as u64).sum::<u64>();
    let (vertices, triangles) = (sum(|p| p.positions.len()), sum(|p| p.indices.len() / 3));
    limits.check_bytes("a picture of the reef", mesh_view_bytes(vertices, triangles, &options))?;
    Ok(mesh_view(&parts, &options))
}

/// What so much water leaves of the daylight.
fn daylight(depth: f32) -> [f32; 3] {
    WATER.per_m.map(|k| (-k * depth.max(0.0)).exp())
}

fn dimmed(colour: [u8; 4], light: [f32; 3]) -> [u8; 4] {
    std::array::from_fn(|i| light.get(i).map_or(colour[i], |l| (f32::from(colour[i]) * l) as u8))
}

/// Places of the floor's vertices along a side of so many metres: `reach` is where they begin and end.
fn lines(side: f32, reach: [f32; 2], spacing: f32) -> Vec<f32> {
    let (from, to) = (reach[0].max(0.0), reach[1].min(side));
    let n = (((to - from) / spacing).ceil() as usize).clamp(2, 700);
    (0..=n).map(|i| from + (to - from) * i as f32 / n as f32).collect()
}

/// The sea floor: within the plot as fine as its cells, around it ever coarser, or with walls where a block ends.
fn floor(reef: &Reef<'_>, shot: &Shot) -> Floor {
    let [w, h] = reef.sides();
    let far = w.max(h);
    let reach = |centre: usize, side: f32| {
        shot.within.map_or([0.0, side], |(at, reach)| [at[centre] - 1.2 * reach, at[centre] + 1.2 * reach])
    };
    let spacing = (0.7 * reef.cell()).max(far / 700.0);
    let (mut xs, mut ys) = (lines(w, reach(0, w), spacing), lines(h, reach(1, h), spacing));
    if !shot.is_block {
        // Twice as far again, so that no edge is in the picture.
        for (line, side) in [(&mut xs, w), (&mut ys, h)] {
            let out = |n: usize| 2.0 * far.max(SIGHT_M) * (n as f32 / 24.0).powi(2);
            if line.first() == Some(&0.0) {
                line.splice(0..0, (1..=24).rev().map(|n| -out(n)));
            }
            if line.last() == Some(&side) {
                line.extend((1..=24).map(|n| side + out(n)));
            }
        }
    }
    let middle = reef.floor(0.5 * w, 0.5 * h);
    let height = |x: f32, y: f32| {
        if reef.is_slope() {
            // A slope goes on as it is: mirrored, so that no edge shows.
            return reef.floor(mirrored(x, w), mirrored(y, h));
        }
        // Beyond the plot, the floor levels out.
        let outside = (-x).max(x - w).max(-y).max(y - h).max(0.0);
        middle + (reef.floor(x, y) - middle) / (1.0 + (4.0 * outside / far).powi(2))
    };
    let is_tinted = shot.haze.is_none() && reef.is_slope();
    let mut floor = Floor::default();
    for &y in &ys {
        for &x in &xs {
            let z = height(x, y);
            floor.positions.push([x, z, y]);
            let mut colour = ground(reef, mirrored(x, w), mirrored(y, h));
            if is_tinted {
                let light = daylight(SHOWN_DEPTH * (reef.sea_level - z));
                colour = std::array::from_fn(|i| colour[i] * light[i]);
            }
            floor.colours.push(bytes(colour));
        }
    }
    let (columns, rows) = (xs.len(), ys.len());
    floor.normals = (0..rows * columns).map(|n| normal(&floor.positions, columns, rows, n)).collect();
    let row = columns as u32;
    for j in 0..rows as u32 - 1 {
        for c in (0..row - 1).map(|i| j * row + i) {
            floor.indices.extend([c, c + row, c + 1, c + 1, c + row, c + row + 1]);
        }
    }
    if shot.is_block {
        let foot = reef.heights()[0] - 0.04 * far;
        let at = |i: usize, j: usize| j * columns + i;
        let south: Vec<usize> = (0..columns).map(|i| at(i, rows - 1)).collect();
        let east: Vec<usize> = (0..rows).rev().map(|j| at(columns - 1, j)).collect();
        let north: Vec<usize> = (0..columns).rev().map(|i| at(i, 0)).collect();
        let west: Vec<usize> = (0..rows).map(|j| at(0, j)).collect();
        for (edge, out) in
            [(south, [0.0, 0.0, 1.0]), (east, [1.0, 0.0, 0.0]), (north, [0.0, 0.0, -1.0]), (west, [-1.0, 0.0, 0.0])]
        {
            floor.wall(&edge, reef.sea_level, foot, out);
        }
    }
    floor
}

impl Floor {
    /// A wall from an edge of the floor down to the foot, seen from outside: a band for each [`BAND_M`] of depth, as on the scales of
    /// maps.
    fn wall(&mut self, edge: &[usize], sea_level: f32, foot: f32, out: [f32; 3]) {
        let top = edge.iter().map(|&n| self.positions[n][1]).fold(foot, f32::max);
        let each = BAND_M.max((top - foot) / MOST_BANDS);
        let band = |z: f32| ((sea_level - z) / each).floor() as i32;
        for band in band(top)..=band(foot) {
            let first = self.positions.len() as u32;
            let [upper, lower] = [band, band + 1].map(|n| sea_level - n as f32 * each);
            let shade = if band % 2 == 0 { 1.0 } else { 0.82 };
            let light = daylight(SHOWN_DEPTH * (sea_level - upper));
            let colour = bytes(std::array::from_fn(|i| shade * light[i] * CUT[i]));
            for &n in edge {
                let [x, z, y] = self.positions[n];
                self.positions.extend([[x, upper.min(z), y], [x, lower.max(foot).min(z), y]]);
                self.normals.extend([out; 2]);
                self.colours.extend([colour; 2]);
            }
            for n in (0..edge.len() as u32 - 1).map(|n| first + 2 * n) {
                self.indices.extend([n, n + 1, n + 2, n + 2, n + 1, n + 3]);
            }
        }
    }
}

fn normal(positions: &[[f32; 3]], columns: usize, rows: usize, n: usize) -> [f32; 3] {
    let (i, j) = (n % columns, n / columns);
    let at = |i: usize, j: usize| positions[j.min(rows - 1) * columns + i.min(columns - 1)];
    let (e, w) = (at(i + 1, j), at(i.saturating_sub(1), j));
    let (s, n) = (at(i, j + 1), at(i, j.saturating_sub(1)));
    let slope = |a: [f32; 3], b: [f32; 3], k: usize| (a[1] - b[1]) / (a[k] - b[k]).max(1e-6);
    let normal = [-slope(e, w, 0), 1.0, -slope(s, n, 2)];
    let length = normal.iter().map(|v| v * v).sum::<f32>().sqrt();
    normal.map(|v| v / length)
}

/// Linear colour of the bare floor at a place of the plot, as bytes are.
fn ground(reef: &Reef<'_>, x: f32, y: f32) -> [f32; 3] {
    let Some(rock) = reef.substrate(x, y) else { return SAND };
    let turf = reef.plot.turf_at(x, y);
    // Grains, patches and crusts that no layer knows of.
    let cell = |size: f32| (((y / size) as u64) << 32) | (x / size) as u64;
    let speckle = |size: f32| (mix64(cell(size)) >> 40) as f32 / (1u64 << 24) as f32 - 0.5;
    let bright = 1.0 + 0.16 * speckle(0.3) + 0.12 * speckle(1.1);
    std::array::from_fn(|i| {
        let stone = ROCK[i] + 0.6 * turf * (TURF[i] - ROCK[i]);
        bright * (SAND[i] + rock * (stone - SAND[i]))
    })
}

fn bytes(colour: [f32; 3]) -> [u8; 4] {
    let [r, g, b] = colour.map(|v| v.clamp(0.0, 255.0) as u8);
    [r, g, b, 255]
}

/// A coordinate mirrored into 0..=side.
fn mirrored(v: f32, side: f32) -> f32 {
    let t = v.rem_euclid(2.0 * side);
    if t > side { 2.0 * side - t } else { t }
}
