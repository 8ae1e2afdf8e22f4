//! A section through the land as a drawing: what lies below a line, with axes and a legend.
//!
//! The picture asks for the column at every pixel, with surfaces that run straight from cell to cell
//! ([`Subsurface::at`]); the areas are those of the cells that the line passes ([`areas_m2`]).

use crate::error::ExportError;
use eyot_core::layer::known::{HEIGHT, WATER};
use eyot_core::{Field, World};
use eyot_io as io;
use eyot_recipe::keys::NO_SEA_M;
use eyot_render::{Anchor, Drawing, Ink, Place, Shape, Stroke};
use eyot_strata::section::{areas_m2, check};
use eyot_strata::{Run, Subsurface};
use std::collections::BTreeMap;
use std::path::Path;

const LEFT: f32 = 84.0;
const RIGHT: f32 = 36.0;
const TOP: f32 = 76.0;
/// Room of the lower axis.
const AXIS: f32 = 62.0;
/// Height of a row of the legend.
const ROW: f32 = 26.0;
const PAPER: [u8; 3] = [252, 252, 250];
const INK: [u8; 3] = [40, 44, 48];
const GRID: [u8; 3] = [224, 226, 228];
const SEA: [u8; 3] = [136, 184, 212];
const FRESH: [u8; 3] = [64, 132, 196];
/// Less water than this is not drawn, m.
const THIN_M: f64 = 0.02;
/// How far a line may be off where points are left out, a tenth of a pixel.
const OFF: f32 = 0.05;
/// Exaggerations to choose from, and the share of the plot's height that the relief may take.
const FACTORS: [f64; 18] =
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0, 50.0];
const RELIEF: f64 = 0.5;
/// Room above the highest place, as a share of the plot's height.
const SKY: f64 = 0.1;

/// How a section is drawn.
#[derive(Clone, Debug, Default)]
pub struct SectionOptions {
    /// The line: m from the western rim and m from the northern one. Empty: from west to east through the highest cell.
    pub line: Vec<[f64; 2]>,
    /// Width of the picture, and its height if that is given, pixels.
    pub size: (u32, Option<u32>),
    /// Factor on heights; `None` chooses a round one that shows the relief.
    pub exaggeration: Option<f64>,
    /// What stands above it.
    pub title: String,
}

/// A section that has been drawn.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The drawing.
    pub drawing: Drawing,
    /// The line, as in [`SectionOptions::line`].
    pub line: Vec<[f64; 2]>,
    /// Its length, m.
    pub length_m: f64,
    /// Factor on heights.
    pub exaggeration: f64,
    /// Lowest height that is shown, m.
    pub floor_m: f64,
    /// Names of what is shown and areas, m2, from the surface down.
    pub areas_m2: Vec<(String, f64)>,
}

/// Draws a section into a file, as SVG or PNG by its name.
///
/// # Errors
/// If the name has another extension, the world has no height, the line is none on its grid, the exaggeration leaves no room for the
/// relief, or the file cannot be written.
pub fn write_section(world: &World, options: &SectionOptions, path: &Path) -> Result<Drawn, ExportError> {
    let extension = path.extension().map(|e| e.to_ascii_lowercase()).unwrap_or_default();
    if extension != "png" && extension != "svg" {
        let reason = format!("`{}` is no name of a section", path.display());
        return Err(ExportError::refused(reason, "give it a name that ends in .png or .svg"));
    }
    io::check_place(path).map_err(ExportError::file)?;
    let drawn = section(world, options)?;
    if extension == "svg" {
        io::write_text(path, &drawn.drawing.svg()).map_err(ExportError::file)?;
    } else {
        let p = drawn.drawing.picture();
        io::write_rgb_png(path, p.width, p.height, &p.pixels).map_err(ExportError::file)?;
    }
    Ok(drawn)
}

/// The column below a point of the line.
struct Sample {
    runs: Vec<Run>,
    ground: f64,
    /// Surface of fresh water.
    water: Option<f64>,
    sea: Option<f64>,
}

impl Sample {
    /// Leaves out what lies below a height, m.
    fn end_at(&mut self, floor_m: f64) {
        self.runs.retain(|r| r.top_m > floor_m);
        if let Some(last) = self.runs.last_mut() {
            last.bottom_m = last.bottom_m.max(floor_m);
        }
    }
}

/// Draws a section.
///
/// # Errors
/// As [`write_section`].
pub fn section(world: &World, o: &SectionOptions) -> Result<Drawn, ExportError> {
    let below = Subsurface::of(world).map_err(ExportError::input)?;
    let height = &world.layer(&HEIGHT.name).map_err(ExportError::input)?.field;
    let line = if o.line.is_empty() { through_the_top(world, height) } else { o.line.clone() };
    let length_m = check(&world.grid, &line).map_err(ExportError::input)?;
    let width = 0.5 * o.size.0 as f32;
    let plot_width = width - LEFT - RIGHT;
    if plot_width < 100.0 {
        return Err(ExportError::refused(format!("a section of {} pixels", o.size.0), "choose at least 500 pixels"));
    }
    // Pixels, and points at both ends.
    let count = (2.0 * plot_width) as usize;
    let places: Vec<[f64; 2]> =
        (0..=count).map(|k| on_grid(world, along(&line, length_m * k as f64 / count as f64))).collect();
    let mut samples: Vec<Sample> = places.iter().map(|p| sample(world, &below, height, *p)).collect();
    let tops = samples.iter().map(|s| s.water.into_iter().chain(s.sea).fold(s.ground, f64::max));
    let high = tops.fold(f64::NEG_INFINITY, f64::max);
    let low = samples.iter().map(|s| s.ground).fold(f64::INFINITY, f64::min);
    let per_unit = length_m / f64::from(plot_width);
    let relief = (high - low).max(1e-3 * length_m.min(1000.0));

    // First the kinds that are there, then the room that their legend leaves.
    let mut seen = legend(&below, world, &samples);
    let order: Vec<usize> = seen.iter().filter_map(|(_, _, kind)| *kind).collect();
    let name_width = seen.iter().map(|e| Drawing::text_width(&e.0)).fold(0.0, f32::max) + 52.0;
    let columns = ((plot_width / name_width) as usize).max(1);
    let foot = AXIS + ROW * seen.len().div_ceil(columns) as f32 + 10.0;
    let room = |total: f32| f64::from(total - TOP - foot);
    let plot_height = match (o.size.1, o.exaggeration) {
        (Some(h), _) => room(0.5 * h as f32),
        (None, Some(e)) => (relief * e / per_unit / RELIEF).clamp(120.0, 4000.0),
        // Steep land is drawn to scale in a higher picture, and not squashed.
        (None, None) => (1.01 * relief / length_m / RELIEF).clamp(0.36, 1.2) * f64::from(plot_width),
    };
    if plot_height < 60.0 {
        return Err(ExportError::refused("the legend leaves no room for the section", "make the picture higher"));
    }
    let most = (1.0 - SKY) * plot_height * per_unit / relief;
    let exaggeration = match o.exaggeration {
        Some(e) if e > most => {
            let reason = format!("heights times {e} do not fit into the picture, times {most:.3} do");
            return Err(ExportError::refused(reason, "choose less, or a higher picture"));
        }
        Some(e) => e,
        None => FACTORS.into_iter().rev().find(|e| e * relief / per_unit <= RELIEF * plot_height).unwrap_or(most),
    };
    let per_z = per_unit / exaggeration;
    let z_high = high + SKY * plot_height * per_z;
    let floor_m = z_high - plot_height * per_z;
    samples.iter_mut().for_each(|s| s.end_at(floor_m));
    seen.retain(|(_, _, kind)| kind.is_none_or(|n| samples.iter().flat_map(|s| &s.runs).any(|r| r.kind == n)));

    let at = |k: usize, z: f64| -> Place {
        let x = LEFT + plot_width * k as f32 / count as f32;
        [x, TOP + ((z_high - z) / per_z).clamp(0.0, plot_height) as f32]
    };
    let bottom = TOP + plot_height as f32;
    let mut shapes = Vec::new();
    let frame = Frame { width, plot_width, bottom, length_m, z_high, floor_m };
    frame.grid(&mut shapes);
    for (colour, name, level) in
        [(SEA, "sea", (|s: &Sample| s.sea) as fn(&Sample) -> Option<f64>), (FRESH, "fresh water", |s: &Sample| s.water)]
    {
        let wet: Vec<Slice> =
            samples.iter().enumerate().filter_map(|(k, s)| level(s).map(|z| (k, z, s.ground))).collect();
        for part in parts(&wet) {
            shapes.push(area(&part, &at, colour, name));
        }
    }
    // Ground below everything, so that no paper shines through between two beds.
    let ground: Vec<Slice> = samples.iter().enumerate().map(|(k, s)| (k, s.ground, floor_m)).collect();
    shapes.push(area(&ground, &at, [110, 100, 90], ""));
    let mut runs: BTreeMap<(Option<i32>, usize), Vec<Slice>> = BTreeMap::new();
    for (k, s) in samples.iter().enumerate() {
        s.runs.iter().for_each(|r| runs.entry((r.bed, r.kind)).or_default().push((k, r.top_m, r.bottom_m)));
    }
    for ((_, kind), list) in &runs {
        let kind = &below.kinds()[*kind];
        parts(list).iter().for_each(|part| shapes.push(area(part, &at, kind.colour, &kind.name)));
    }
    let contact = Stroke { ink: Ink { colour: [40, 30, 24], opacity: 0.55 }, width: 0.7 };
    for ((bed, _), list) in &runs {
        let covered = |(k, top, _): &&Slice| bed.is_some() && *top < samples[*k].runs[0].top_m;
        let tops: Vec<_> = list.iter().filter(covered).copied().collect();
        for part in parts(&tops) {
            let points = part.iter().map(|(k, top, _)| at(*k, *top)).collect();
            shapes.push(Shape::Line { points: thinned(points), stroke: contact });
        }
    }
    let surface = samples.iter().enumerate().map(|(k, s)| at(k, s.ground)).collect();
    shapes.push(Shape::Line { points: thinned(surface), stroke: Stroke { ink: Ink::of(INK), width: 1.4 } });
    frame.words(&mut shapes, o, &line, exaggeration);
    for (i, (name, colour, _)) in seen.iter().enumerate() {
        let (x, y) = (LEFT + name_width * (i % columns) as f32, bottom + AXIS + ROW * (i / columns) as f32);
        let line = Some(Stroke { ink: Ink::of(INK), width: 0.8 });
        let points = vec![[x, y - 8.0], [x + 26.0, y - 8.0], [x + 26.0, y + 8.0], [x, y + 8.0]];
        shapes.push(Shape::Polygon { points, fill: Some(Ink::of(*colour)), line, title: String::new() });
        shapes.push(text([x + 36.0, y + 5.0], Anchor::Start, name));
    }
    let areas = areas_m2(&below, &world.grid, &line, floor_m).map_err(ExportError::input)?;
    // As the legend has them; what is too thin for any of the samples comes last.
    let others = (0..areas.len()).filter(|kind| !order.contains(kind));
    let all = order.iter().copied().chain(others).filter(|kind| areas[*kind] > 0.0);
    let names = all.map(|kind| (below.kinds()[kind].name.clone(), areas[kind]));
    let drawing = Drawing { width, height: bottom + foot, background: PAPER, shapes };
    Ok(Drawn { drawing, line, length_m, exaggeration, floor_m, areas_m2: names.collect() })
}

/// Number of a sample, top and bottom, m.
type Slice = (usize, f64, f64);

/// From west to east through the highest cell.
fn through_the_top(world: &World, height: &Field) -> Vec<[f64; 2]> {
    let highest = |y: &usize| height.row(*y).iter().copied().fold(f32::NEG_INFINITY, f32::max);
    // Of several the northernmost.
    let row = (0..height.height()).rev().max_by(|a, b| highest(a).total_cmp(&highest(b))).unwrap_or_default();
    let g = &world.grid;
    let y = (row as f64 + 0.5) * g.cell_y_m;
    vec![[0.0, y], [g.width as f64 * g.cell_x_m, y]]
}

/// The place so many metres along a line.
fn along(line: &[[f64; 2]], mut way: f64) -> [f64; 2] {
    for [a, b] in line.array_windows::<2>() {
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        if way <= length && length > 0.0 {
            return [0, 1].map(|i| a[i] + (b[i] - a[i]) * way / length);
        }
        way -= length;
    }
    line.last().copied().unwrap_or_default()
}

/// Columns and rows, 0 in the middle of the first cell.
fn on_grid(world: &World, p: [f64; 2]) -> [f64; 2] {
    [p[0] / world.grid.cell_x_m - 0.5, p[1] / world.grid.cell_y_m - 0.5]
}

fn sample(world: &World, below: &Subsurface<'_>, height: &Field, p: [f64; 2]) -> Sample {
    let mut runs = Vec::new();
    below.at(p[0], p[1], f64::MIN, &mut runs);
    let ground = runs.first().map_or(0.0, |r| r.top_m);
    let cell = |at: f64, n: usize| at.round().clamp(0.0, (n - 1) as f64) as usize;
    let (x, y) = (cell(p[0], height.width()), cell(p[1], height.height()));
    // The level of the nearest cell: lakes are level up to their shores.
    let depth = world.get(&WATER.name).map_or(0.0, |w| f64::from(w.get(x, y)));
    let water = (depth > THIN_M).then(|| f64::from(height.get(x, y)) + depth).filter(|level| *level > ground);
    let sea = (world.sea_level_m > NO_SEA_M && ground < world.sea_level_m).then_some(world.sea_level_m);
    Sample { runs, ground, water: water.filter(|w| sea.is_none_or(|s| *w > s + THIN_M)), sea }
}

/// What the legend says, with colours and kinds of ground: water, what lies loose, and all beds from the top down.
fn legend(below: &Subsurface<'_>, world: &World, samples: &[Sample]) -> Vec<(String, [u8; 3], Option<usize>)> {
    let mut seen = Vec::new();
    if samples.iter().any(|s| s.water.is_some()) {
        seen.push(("fresh water".to_owned(), FRESH, None));
    }
    if samples.iter().any(|s| s.sea.is_some()) {
        seen.push((format!("sea, level {} m", round(world.sea_level_m)), SEA, None));
    }
    // Where each kind lies highest: what is no bed comes first.
    let mut kinds: Vec<(Option<i32>, usize)> = Vec::new();
    for r in samples.iter().flat_map(|s| &s.runs) {
        match kinds.iter_mut().find(|(_, kind)| *kind == r.kind) {
            Some((bed, _)) => *bed = (*bed).min(r.bed),
            None => kinds.push((r.bed, r.kind)),
        }
    }
    kinds.sort_unstable();
    seen.extend(kinds.into_iter().map(|(_, k)| (below.kinds()[k].name.clone(), below.kinds()[k].colour, Some(k))));
    seen
}

/// Cuts a list of samples where some are missing.
fn parts(list: &[Slice]) -> Vec<Vec<Slice>> {
    list.chunk_by(|a, b| a.0 + 1 == b.0).map(<[_]>::to_vec).collect()
}

/// The area between the tops and bottoms of samples that follow each other; it reaches halfway to those on both sides.
fn area(part: &[Slice], at: &impl Fn(usize, f64) -> Place, colour: [u8; 3], title: &str) -> Shape {
    let step = at(1, 0.0)[0] - at(0, 0.0)[0];
    let side = |z: fn(&Slice) -> f64| {
        let mut points: Vec<Place> = part.iter().map(|s| at(s.0, z(s))).collect();
        let (first, last) = (points[0], points[points.len() - 1]);
        points.insert(0, [first[0] - 0.5 * step, first[1]]);
        points.push([last[0] + 0.5 * step, last[1]]);
        thinned(points)
    };
    let mut points = side(|s| s.1);
    points.extend(side(|s| s.2).into_iter().rev());
    Shape::Polygon { points, fill: Some(Ink::of(colour)), line: None, title: title.to_owned() }
}

/// The line without the points that it hardly needs, after Ramer, Douglas and Peucker.
fn thinned(points: Vec<Place>) -> Vec<Place> {
    let mut keep = vec![false; points.len()];
    let mut open = vec![(0, points.len().saturating_sub(1))];
    if let (Some(first), Some(_)) = (keep.first_mut(), points.last()) {
        *first = true;
        let last = keep.len() - 1;
        keep[last] = true;
    }
    while let Some((a, b)) = open.pop() {
        let (p, q) = (points[a], points[b]);
        let slope = (q[1] - p[1]) / (q[0] - p[0]).max(1e-6);
        let off = |i: usize| (points[i][1] - (p[1] + slope * (points[i][0] - p[0]))).abs();
        let worst = (a + 1..b).max_by(|i, j| off(*i).total_cmp(&off(*j)));
        if let Some(i) = worst.filter(|i| off(*i) > OFF) {
            keep[i] = true;
            open.extend([(a, i), (i, b)]);
        }
    }
    points.into_iter().zip(keep).filter_map(|(p, k)| k.then_some(p)).collect()
}

fn text(at: Place, anchor: Anchor, text: &str) -> Shape {
    Shape::Text { at, anchor, colour: INK, text: text.to_owned() }
}

/// Metres without needless digits.
fn round(m: f64) -> f64 {
    (m * 10.0).round() / 10.0
}

/// Round values within bounds, about `most` of them, and how many places they have.
fn marks(low: f64, high: f64, most: f64) -> (Vec<f64>, usize) {
    let power = 10f64.powf(((high - low) / most).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * power).into_iter().find(|s| (high - low) / s <= most);
    let step = step.unwrap_or(10.0 * power);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let places = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    ((first..=last).map(|i| i as f64 * step).collect(), places)
}

/// The eighth of the compass to which a way leads, from metres to the east and to the south.
fn compass([x, y]: [f64; 2]) -> &'static str {
    let eighth = (x.atan2(-y) / std::f64::consts::FRAC_PI_4).round() as i32;
    ["N", "NE", "E", "SE", "S", "SW", "W", "NW"][eighth.rem_euclid(8) as usize]
}

/// Axes and words around a section.
struct Frame {
    width: f32,
    plot_width: f32,
    bottom: f32,
    length_m: f64,
    z_high: f64,
    floor_m: f64,
}

impl Frame {
    fn x(&self, m: f64) -> f32 {
        LEFT + self.plot_width * (m / self.length_m) as f32
    }

    fn y(&self, z: f64) -> f32 {
        TOP + (self.bottom - TOP) * ((self.z_high - z) / (self.z_high - self.floor_m)) as f32
    }

    /// Lines and numbers of both axes.
    fn grid(&self, shapes: &mut Vec<Shape>) {
        let right = LEFT + self.plot_width;
        let mut line = |points: Vec<Place>| {
            shapes.push(Shape::Line { points, stroke: Stroke { ink: Ink::of(GRID), width: 1.0 } });
        };
        let (heights, z_places) =
            marks(self.floor_m, self.z_high, f64::from((self.bottom - TOP) / 44.0).clamp(2.0, 12.0));
        let (ways, x_places) = marks(0.0, self.length_m, f64::from(self.plot_width / 100.0).clamp(2.0, 12.0));
        heights.iter().for_each(|z| line(vec![[LEFT, self.y(*z)], [right, self.y(*z)]]));
        ways.iter().for_each(|m| line(vec![[self.x(*m), TOP], [self.x(*m), self.bottom]]));
        for z in heights {
            let label = format!("{z:.z_places$}");
            shapes.push(text([LEFT - 10.0, self.y(z) + 5.0], Anchor::End, &label));
        }
        for m in ways {
            let label = format!("{m:.x_places$}");
            shapes.push(text([self.x(m), self.bottom + 22.0], Anchor::Middle, &label));
        }
    }

    /// Title, ends and bends of the line, and what the axes measure.
    fn words(&self, shapes: &mut Vec<Shape>, o: &SectionOptions, line: &[[f64; 2]], exaggeration: f64) {
        let right = LEFT + self.plot_width;
        let mut stroke = |points: Vec<Place>, opacity: f32, width| {
            shapes.push(Shape::Line { points, stroke: Stroke { ink: Ink { colour: INK, opacity }, width } });
        };
        stroke(vec![[LEFT, TOP], [LEFT, self.bottom], [right, self.bottom], [right, TOP]], 1.0, 1.2);
        let letter = |i: usize| char::from(b'A' + (i % 26) as u8);
        let last = line.len() - 1;
        let way = [0, 1].map(|i| line[last][i] - line[0][i]);
        let ends = [compass([-way[0], -way[1]]), compass(way)];
        let mut passed = 0.0;
        let mut names = Vec::new();
        for (i, p) in line.iter().enumerate() {
            if let Some(before) = i.checked_sub(1).map(|b| line[b]) {
                passed += (p[0] - before[0]).hypot(p[1] - before[1]);
            }
            let x = self.x(passed);
            let (anchor, name) = match i {
                0 => (Anchor::Start, format!("{} ({})", letter(0), ends[0])),
                _ if i == last => (Anchor::End, format!("{} ({})", letter(i), ends[1])),
                _ => (Anchor::Middle, letter(i).to_string()),
            };
            if i > 0 && i < last {
                stroke(vec![[x, TOP], [x, self.bottom]], 0.4, 1.0);
            }
            names.push(text([x, TOP - 8.0], anchor, &name));
        }
        shapes.extend(names);
        let letters = format!("{}-{}", letter(0), letter(last));
        let title =
            if o.title.is_empty() { format!("Section {letters}") } else { format!("{}: section {letters}", o.title) };
        shapes.push(text([LEFT, 26.0], Anchor::Start, &title));
        let scale = if exaggeration == 1.0 {
            "heights to scale".to_owned()
        } else {
            format!("vertical exaggeration {exaggeration}x", exaggeration = (exaggeration * 1e3).round() / 1e3)
        };
        shapes.push(text([right, 26.0], Anchor::End, &scale));
        let place = |p: [f64; 2]| format!("({}, {})", round(p[0]), round(p[1]));
        let from = format!("{} {}, {} {}", letter(0), place(line[0]), letter(last), place(line[last]));
        shapes.push(text([right, self.bottom + 42.0], Anchor::End, &format!("{from} m from the north-west corner")));
        shapes.push(text([LEFT, self.bottom + 42.0], Anchor::Start, "distance along the line (m)"));
        shapes.push(text([12.0, TOP - 28.0], Anchor::Start, "height (m)"));
        debug_assert!(right <= self.width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, Limits};
    use eyot_strata::{BED_DATUM, BEDROCK, Bed, STRATA, Strata};

    /// 40 x 10 cells of 25 m: an island of 90 m in a sea of 20 m, with a lake on it and beds below.
    fn island(strata: bool) -> World {
        let grid = Grid::new(40, 10, 25.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let mut w = World::new(grid, 1);
        let ground = |x: usize, y: usize| 90.0 - 6.0 * (x as f32 - 20.0).abs() - y as f32;
        w.put(&HEIGHT, Field::from_fn(40, 10, ground)).unwrap();
        w.put(&WATER, Field::from_fn(40, 10, |x, y| if (25..30).contains(&x) { 70.0 - ground(x, y) } else { 0.0 }))
            .unwrap();
        w.sea_level_m = 20.0;
        if strata {
            w.put(&BEDROCK, Field::from_fn(40, 10, |x, y| ground(x, y) - 2.0)).unwrap();
            w.put(&BED_DATUM, Field::new(40, 10, 80.0)).unwrap();
            let bed = |material: &str| Bed { material: material.into(), thickness: 30.0 };
            let beds = Strata { beds: vec![bed("limestone"), bed("schist"), bed("granite")], ..Strata::default() };
            w.components.insert(STRATA, beds.sequence().unwrap());
        }
        w
    }

    fn wide() -> SectionOptions {
        SectionOptions { size: (1000, None), title: "Isle".into(), ..SectionOptions::default() }
    }

    fn words(d: &Drawn) -> String {
        let texts =
            d.drawing.shapes.iter().filter_map(|s| if let Shape::Text { text, .. } = s { Some(text) } else { None });
        texts.map(|t| format!("{t}\n")).collect()
    }

    #[test]
    fn sections_show_beds_water_and_sea_with_legend_and_scales() {
        let d = section(&island(true), &wide()).unwrap();
        let said = words(&d);
        for word in [
            "Isle: section A-B",
            "A (W)",
            "B (E)",
            "height (m)",
            "distance along the line (m)",
            "fresh water",
            "sea, level 20 m",
            "regolith",
            "limestone",
            "schist",
            "granite",
            "A (0, 12.5), B (1000, 12.5) m",
        ] {
            assert!(said.contains(word), "{word}: {said}");
        }
        assert!(
            said.contains(&format!("vertical exaggeration {}x", d.exaggeration)) || d.exaggeration == 1.0,
            "{said}"
        );
        // Through the highest row, and of all that is below: 1000 m long, with the heights of its cells.
        let whole: f64 = d.areas_m2.iter().map(|(_, a)| a).sum();
        let cells: f64 = (0..40).map(|x| 25.0 * (90.0 - 6.0 * f64::from(x - 20).abs() - d.floor_m)).sum();
        assert!((whole / cells - 1.0).abs() < 1e-6, "{whole} {cells}");
        // Colours of all of them are in the picture, at both scales.
        let p = d.drawing.picture();
        assert_eq!(p.width, 1000);
        let (sea, fresh) = (p.pixels.contains(&SEA), p.pixels.contains(&FRESH));
        assert!(sea && fresh && [0, 3, 4, 6].iter().all(|n| p.pixels.contains(&eyot_strata::materials::colour(*n))));
        let svg = d.drawing.svg();
        assert!(svg.contains("<title>schist</title>") && svg.len() < 40_000, "{}", svg.len());
    }

    #[test]
    fn sections_of_worlds_without_strata_bend_and_are_stretched_as_asked() {
        let line = vec![[0.0, 0.0], [500.0, 125.0], [500.0, 250.0]];
        let o = SectionOptions { line, exaggeration: Some(2.0), ..wide() };
        let d = section(&island(false), &o).unwrap();
        let said = words(&d);
        assert!(
            said.contains("vertical exaggeration 2x") && said.contains("ground") && !said.contains("limestone"),
            "{said}"
        );
        assert!(said.contains("A (NW)") && said.contains("\nB\n") && said.contains("C (SE)"), "{said}");
        // A metre upwards is as long as two along the line.
        let marks = |at: usize| {
            let lines = d.drawing.shapes.iter().filter_map(|s| match s {
                Shape::Line { points, stroke } if stroke.ink == Ink::of(GRID) => Some(points),
                _ => None,
            });
            let mut at: Vec<f32> = lines.filter(|p| p[0][at] == p[1][at]).map(|p| p[0][at]).collect();
            at.sort_by(f32::total_cmp);
            at[1] - at[0]
        };
        let numbers = |words: &str| words.lines().filter_map(|l| l.parse::<f32>().ok()).collect::<Vec<_>>();
        let all = numbers(&said);
        let rise = (all[1] - all[0]) / marks(1);
        let way = (all[all.len() - 1] - all[all.len() - 2]) / marks(0);
        assert!((way / rise - 2.0).abs() < 1e-2, "{way} {rise}");
        let tall = SectionOptions { size: (1000, Some(700)), exaggeration: Some(200.0), ..wide() };
        assert!(section(&island(false), &tall).unwrap_err().to_string().contains("do not fit"));
        let beyond = SectionOptions { line: vec![[0.0, 0.0], [2000.0, 0.0]], ..wide() };
        assert!(section(&island(false), &beyond).unwrap_err().to_string().contains("outside the land"));
        let folder = tempfile::tempdir().unwrap();
        assert!(write_section(&island(false), &wide(), &folder.path().join("a.jpg")).is_err());
        write_section(&island(false), &wide(), &folder.path().join("a.svg")).unwrap();
    }

    #[test]
    fn a_component_of_another_kind_is_no_sequence() {
        let mut w = island(true);
        w.components.insert(STRATA, eyot_core::component::Table::default());
        assert!(w.components.of_any_kind(STRATA).is_some_and(|c| c.kind().name == "table"));
        assert!(section(&w, &wide()).unwrap_err().to_string().contains("strata"));
    }
}
