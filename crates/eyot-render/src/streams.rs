//! Rivers and lakes that a world keeps as lines and outlines, drawn as finely as the picture is: rivers with their width, lakes level.

use eyot_core::World;
use eyot_core::component::{Features, Form};

/// A river is drawn at least so wide, in points of the picture.
const LEAST_WIDTH: f32 = 1.2;
/// How strongly the narrowest river shows.
const LEAST_COVER: f32 = 0.6;

/// Lines and outlines in metres from the grid's north-western corner.
pub(crate) struct Streams {
    /// Lines with the width of their water.
    rivers: Vec<(Vec<[f32; 2]>, f32)>,
    /// Rings with the level of the water in them.
    lakes: Vec<(Vec<Vec<[f32; 2]>>, f32)>,
}

/// Points that are drawn: their number, the place of the first and their distance, m.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) points: [usize; 2],
    pub(crate) first_m: [f32; 2],
    pub(crate) step_m: [f32; 2],
}

impl Streams {
    /// Those of a world; `None` if it keeps no rivers as lines.
    pub(crate) fn of(world: &World) -> Option<Self> {
        let component = |name: &str| world.components.get::<Features>(name).ok().flatten();
        let lines = component("rivers").filter(|r| r.form() == Form::Lines)?;
        let plane = |part: &[[f32; 3]]| part.iter().map(|v| [v[0], v[1]]).collect::<Vec<_>>();
        let number = |of: &Features, name: &str, i: usize| of.attributes().get(name).map(|a| a.values.number(i) as f32);
        let rivers = (0..lines.len())
            .filter(|&i| number(lines, "LAKE_ID", i).is_none_or(|lake| lake == 0.0))
            .flat_map(|i| lines.parts(i).map(move |part| (plane(part), number(lines, "WIDTH_M", i).unwrap_or(0.0))))
            .collect();
        let shores = ["lakes", "oxbow_lakes"].into_iter().filter_map(component).filter(|l| l.form() == Form::Polygons);
        let lakes = shores.flat_map(|l| {
            (0..l.len()).map(move |i| {
                let level = l.parts(i).next().map_or(0.0, |ring| ring[0][2]);
                (l.parts(i).map(plane).collect(), level)
            })
        });
        Some(Self { rivers, lakes: lakes.collect() })
    }

    /// How much of each point a river covers, 0..1.
    pub(crate) fn cover(&self, frame: &Frame) -> Vec<f32> {
        let step = frame.step_m[0].max(frame.step_m[1]);
        let mut cover = vec![0.0_f32; frame.points[0] * frame.points[1]];
        for (line, width) in &self.rivers {
            let half = 0.5 * width.max(LEAST_WIDTH * step);
            let strength = (width / (LEAST_WIDTH * step)).sqrt().clamp(LEAST_COVER, 1.0);
            for pair in line.windows(2) {
                let reach = half + 0.5 * step;
                for_points(frame, [pair[0], pair[1]], reach, |i, r| {
                    cover[i] = cover[i].max(strength * ((reach - r) / step).clamp(0.0, 1.0));
                });
            }
        }
        cover
    }

    /// The level of the lake at each point, m; NaN where there is none.
    pub(crate) fn levels(&self, frame: &Frame) -> Vec<f32> {
        let [w, h] = frame.points;
        let mut levels = vec![f32::NAN; w * h];
        for (rings, level) in &self.lakes {
            let ys = rings.iter().flatten().map(|v| v[1]);
            let (low, high) = ys.fold((f32::MAX, f32::MIN), |(a, b), y| (a.min(y), b.max(y)));
            let row = |y: f32| (y - frame.first_m[1]) / frame.step_m[1];
            let from = row(low).ceil().max(0.0) as usize;
            for y in from..h.min((row(high).floor() + 1.0).max(0.0) as usize) {
                let at = frame.first_m[1] + y as f32 * frame.step_m[1];
                let mut crossings: Vec<f32> = rings
                    .iter()
                    .flat_map(|ring| ring.windows(2))
                    .filter(|p| (p[0][1] > at) != (p[1][1] > at))
                    .map(|p| p[0][0] + (at - p[0][1]) / (p[1][1] - p[0][1]) * (p[1][0] - p[0][0]))
                    .collect();
                crossings.sort_unstable_by(f32::total_cmp);
                for span in crossings.chunks_exact(2) {
                    let column = |x: f32| (x - frame.first_m[0]) / frame.step_m[0];
                    let (a, b) = (column(span[0]).ceil().max(0.0) as usize, column(span[1]).floor());
                    if b >= 0.0 && a < w {
                        levels[y * w + a..=y * w + (b as usize).min(w - 1).max(a)].fill(*level);
                    }
                }
            }
        }
        levels
    }
}

/// Calls `f(point, distance)` for the points at most `reach` m from the line between two places.
fn for_points(frame: &Frame, [a, b]: [[f32; 2]; 2], reach: f32, mut f: impl FnMut(usize, f32)) {
    let span = |c: usize| {
        let place = |v: f32| (v - frame.first_m[c]) / frame.step_m[c];
        let low = place(a[c].min(b[c]) - reach).ceil().max(0.0) as usize;
        (low, (place(a[c].max(b[c]) + reach).floor() + 1.0).clamp(0.0, frame.points[c] as f32) as usize)
    };
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let ((x0, x1), (y0, y1)) = (span(0), span(1));
    for y in y0..y1 {
        for x in x0..x1 {
            let p = [
                frame.first_m[0] + x as f32 * frame.step_m[0] - a[0],
                frame.first_m[1] + y as f32 * frame.step_m[1] - a[1],
            ];
            let t = if square > 0.0 { ((p[0] * along[0] + p[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
            let r = (p[0] - t * along[0]).hypot(p[1] - t * along[1]);
            if r <= reach {
                f(y * frame.points[0] + x, r);
            }
        }
    }
}
