//! Charts of numbers over numbers: lines and points between two axes, with a grid and a legend.

use eyot_render::{Anchor, Drawing, Ink, Place, Shape, Stroke};

const WIDTH: f32 = 1000.0;
const HEIGHT: f32 = 640.0;
const LEFT: f32 = 104.0;
const RIGHT: f32 = 40.0;
const TOP: f32 = 64.0;
const BOTTOM: f32 = 76.0;
const INK: [u8; 3] = [40, 44, 48];
const GRID: [u8; 3] = [222, 222, 222];
/// Marks along an axis, at most.
const MARKS: f64 = 7.0;
const ROW: f32 = 25.0;

/// Colours that are told apart by colour-blind people, too (Okabe and Ito 2008).
pub(crate) const COLOURS: [[u8; 3]; 5] = [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 88, 92]];

/// A direction of a chart.
pub(crate) struct Axis {
    /// What is measured, with its unit.
    pub label: String,
    /// Whether equal ways are equal factors.
    pub log: bool,
}

/// What is drawn of one thing.
pub(crate) struct Curve {
    /// Name in the legend; none for what needs no name.
    pub name: String,
    /// sRGB.
    pub colour: [u8; 3],
    /// Right and up.
    pub points: Vec<[f64; 2]>,
    /// A line through the points, or else a disc on each.
    pub line: bool,
}

/// A chart; see [`Chart::draw`].
pub(crate) struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
    /// Said below the title.
    pub note: String,
}

/// How an axis places its numbers.
struct Scale {
    log: bool,
    low: f64,
    high: f64,
    marks: Vec<f64>,
}

impl Scale {
    fn of(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let good = values.filter(|v| v.is_finite() && (!axis.log || *v > 0.0));
        let (mut low, mut high) = good.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            (low, high) = if axis.log { (1.0, 10.0) } else { (0.0, 1.0) };
        }
        if axis.log {
            let (first, last) =
                (low.log10().floor() as i32, (high.log10().ceil() as i32).max(low.log10().floor() as i32 + 1));
            let marks = (first..=last).map(|e| 10f64.powi(e)).collect();
            return Self { log: true, low: f64::from(first), high: f64::from(last), marks };
        }
        let span = (high - low).max(1e-9 * high.abs()).max(1e-12);
        let power = 10f64.powf((span / MARKS).log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * power).find(|s| span / s <= MARKS).unwrap_or(power * 10.0);
        let (first, last) = ((low / step).floor() as i64, (high / step).ceil() as i64);
        let last = last.max(first + 1);
        let marks: Vec<f64> = (first..=last).map(|i| i as f64 * step).collect();
        Self { log: false, low: first as f64 * step, high: last as f64 * step, marks }
    }

    /// From 0 at the low end to 1 at the high one.
    fn part(&self, v: f64) -> Option<f32> {
        let v = if self.log { v.log10() } else { v };
        v.is_finite().then(|| ((v - self.low) / (self.high - self.low)) as f32)
    }

    fn text(&self, v: f64) -> String {
        if self.log {
            let e = v.log10().round() as i32;
            return if (-3..=3).contains(&e) { format!("{v}") } else { format!("1e{e}") };
        }
        let step = self.marks[1] - self.marks[0];
        let places = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{v:.places$}")
    }
}

impl Chart {
    /// The chart, with round numbers at both ends of its axes.
    pub(crate) fn draw(&self) -> Drawing {
        let all = |k: usize| self.curves.iter().flat_map(move |c| c.points.iter().map(move |p| p[k]));
        let (x, y) = (Scale::of(&self.x, all(0)), Scale::of(&self.y, all(1)));
        let right = |part: f32| LEFT + part * (WIDTH - LEFT - RIGHT);
        let down = |part: f32| HEIGHT - BOTTOM - part * (HEIGHT - TOP - BOTTOM);
        let mut shapes = Vec::new();
        let text = |at: Place, anchor, text: &str| Shape::Text { at, anchor, colour: INK, text: text.to_owned() };
        let line =
            |points: Vec<Place>, colour, width| Shape::Line { points, stroke: Stroke { ink: Ink::of(colour), width } };
        for &mark in &x.marks {
            let Some(at) = x.part(mark).map(right) else { continue };
            shapes.push(line(vec![[at, down(0.0)], [at, down(1.0)]], GRID, 1.0));
            shapes.push(text([at, down(0.0) + 24.0], Anchor::Middle, &x.text(mark)));
        }
        for &mark in &y.marks {
            let Some(at) = y.part(mark).map(down) else { continue };
            shapes.push(line(vec![[right(0.0), at], [right(1.0), at]], GRID, 1.0));
            shapes.push(text([right(0.0) - 10.0, at + 5.0], Anchor::End, &y.text(mark)));
        }
        let corner = [right(0.0), down(0.0)];
        shapes.push(line(vec![[corner[0], down(1.0)], corner, [right(1.0), corner[1]]], INK, 1.5));
        shapes.push(text([right(0.5), HEIGHT - 18.0], Anchor::Middle, &self.x.label));
        // Above its axis, so that it can be read without turning the head.
        shapes.push(text([16.0, TOP - 12.0], Anchor::Start, &self.y.label));
        shapes.push(text([WIDTH / 2.0, 24.0], Anchor::Middle, &self.title));
        shapes.push(text([right(1.0), TOP - 12.0], Anchor::End, &self.note));
        for c in &self.curves {
            let place = |p: &[f64; 2]| Some([right(x.part(p[0])?), down(y.part(p[1])?)]);
            let points: Vec<Place> = c.points.iter().filter_map(place).collect();
            if c.line {
                shapes.push(line(points, c.colour, 2.0));
            } else {
                let fill = Some(Ink::of(c.colour));
                let disc = |at| Shape::Circle { at, radius: 4.5, fill, line: None, title: String::new() };
                shapes.extend(points.into_iter().map(disc));
            }
        }
        let named: Vec<&Curve> = self.curves.iter().filter(|c| !c.name.is_empty()).collect();
        let width = named.iter().map(|c| Drawing::text_width(&c.name)).fold(0.0, f32::max) + 44.0;
        for (i, c) in named.into_iter().enumerate() {
            let (from, at) = (right(1.0) - width, down(1.0) + 20.0 + ROW * i as f32);
            if c.line {
                shapes.push(line(vec![[from, at], [from + 26.0, at]], c.colour, 3.0));
            } else {
                let (at, fill) = ([from + 13.0, at], Some(Ink::of(c.colour)));
                shapes.push(Shape::Circle { at, radius: 4.5, fill, line: None, title: String::new() });
            }
            shapes.push(text([from + 36.0, at + 5.0], Anchor::Start, &c.name));
        }
        Drawing { width: WIDTH, height: HEIGHT, background: [255; 3], shapes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_round_marks_that_hold_all_values() {
        let linear = Axis { label: String::new(), log: false };
        let s = Scale::of(&linear, [3.1, 96.2].into_iter());
        assert_eq!((s.low, s.high, s.marks.len()), (0.0, 100.0, 6));
        assert_eq!(s.text(40.0), "40");
        let s = Scale::of(&linear, [5.0, 5.0].into_iter());
        assert!(s.low <= 5.0 && s.high > 5.0);
        let s = Scale::of(&linear, [0.001, 0.0062].into_iter());
        assert_eq!(s.text(s.marks[1]), "0.002");
        let log = Axis { label: String::new(), log: true };
        let s = Scale::of(&log, [0.0, 250.0, 9.1e6].into_iter());
        assert_eq!((s.low, s.high), (2.0, 7.0));
        assert_eq!((s.text(100.0), s.text(1e7)), ("100".to_owned(), "1e7".to_owned()));
        assert_eq!(s.part(0.0), None);
        // Nothing at all still makes a chart.
        let none = Chart { title: "t".into(), x: linear, y: log, curves: vec![], note: String::new() };
        assert!(none.draw().svg().contains("</svg>"));
    }
}
