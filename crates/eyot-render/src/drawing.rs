//! Drawings of lines, areas and words, such as charts and plans: kept as shapes, given as SVG or as pixels.
//!
//! Pixels are covered as far as a shape covers them: exactly along rows, at [`ROWS`] heights within each. Strokes are the union of
//! rectangles and discs, by the winding number, so that lines that cross themselves are no darker there.

use crate::picture::Picture;
use crate::text;
use std::fmt::Write;

/// Heights at which a pixel is looked at.
const ROWS: usize = 4;
/// Corners of a circle's polygon for each pixel of its radius, and the fewest.
const CORNERS_PER_PIXEL: f32 = 1.6;
const FEWEST_CORNERS: usize = 12;

/// A point: right and down from the top left corner.
pub type Place = [f32; 2];

/// A colour and how much it hides, 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 clear, 1 opaque.
    pub opacity: f32,
}

impl Ink {
    /// An opaque colour.
    pub const fn of(colour: [u8; 3]) -> Self {
        Self { colour, opacity: 1.0 }
    }
}

/// A line's ink and width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width.
    pub width: f32,
}

/// Which end of a text stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// What a drawing is made of; later shapes lie on earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An area with a border.
    Polygon {
        /// Its corners.
        points: Vec<Place>,
        /// What fills it.
        fill: Option<Ink>,
        /// Its border.
        line: Option<Stroke>,
        /// What a viewer of SVG shows when it is pointed at.
        title: String,
    },
    /// A disc.
    Circle {
        /// Its centre.
        at: Place,
        /// Its radius.
        radius: f32,
        /// What fills it.
        fill: Option<Ink>,
        /// Its border.
        line: Option<Stroke>,
        /// As of a polygon.
        title: String,
    },
    /// A line through points.
    Line {
        /// The points.
        points: Vec<Place>,
        /// Its ink and width.
        stroke: Stroke,
    },
    /// A line of text, [`Drawing::TEXT`] high.
    Text {
        /// Where the bottom of its letters stands.
        at: Place,
        /// Which end is there.
        anchor: Anchor,
        /// Its colour.
        colour: [u8; 3],
        /// The words.
        text: String,
    },
}

/// A drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width.
    pub width: f32,
    /// Height.
    pub height: f32,
    /// What is behind everything, sRGB.
    pub background: [u8; 3],
    /// What is on it.
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// Height of text.
    pub const TEXT: f32 = 16.0;

    /// Width of a text.
    pub fn text_width(text: &str) -> f32 {
        text::width(text) as f32
    }

    /// The drawing as SVG.
    pub fn svg(&self) -> String {
        let (w, h) = (self.width, self.height);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"Noto Sans Mono, DejaVu Sans Mono, monospace\" font-size=\"{}\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
            Self::TEXT,
            rgb(self.background)
        );
        let title = |title: &str, tag: &str| match title {
            "" => "/>".to_owned(),
            title => format!("><title>{}</title></{tag}>", escaped(title)),
        };
        let list = |points: &[Place]| {
            let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
            points.join(" ")
        };
        for shape in &self.shapes {
            // Writing to a string cannot fail.
            let _ = match shape {
                Shape::Polygon { points, fill, line, title: t } => {
                    writeln!(out, "<polygon points=\"{}\"{}{}", list(points), style(*fill, *line), title(t, "polygon"))
                }
                Shape::Circle { at: [x, y], radius, fill, line, title: t } => writeln!(
                    out,
                    "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"{}{}",
                    style(*fill, *line),
                    title(t, "circle")
                ),
                Shape::Line { points, stroke } => writeln!(
                    out,
                    "<polyline points=\"{}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"{}/>",
                    list(points),
                    style(None, Some(*stroke))
                ),
                Shape::Text { at: [x, y], anchor, colour, text } => {
                    let anchor = match anchor {
                        Anchor::Start => "start",
                        Anchor::Middle => "middle",
                        Anchor::End => "end",
                    };
                    writeln!(
                        out,
                        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
                        rgb(*colour),
                        escaped(text)
                    )
                }
            };
        }
        out + "</svg>\n"
    }

    /// The drawing as pixels, twice as many along each side as it is long.
    pub fn picture(&self) -> Picture {
        const SCALE: f32 = text::LARGE as f32;
        let side = |length: f32| (length * SCALE).round().max(1.0) as usize;
        let mut p = Picture::new(side(self.width), side(self.height), self.background);
        let scaled = |points: &[Place]| -> Vec<Place> { points.iter().map(|q| q.map(|v| v * SCALE)).collect() };
        let border = |points: &[Place], line: Stroke| {
            let mut closed = points.to_vec();
            closed.extend(points.first());
            outline(&closed, 0.5 * SCALE * line.width)
        };
        for shape in &self.shapes {
            match shape {
                Shape::Polygon { points, fill, line, .. } => {
                    let points = scaled(points);
                    fill.iter().for_each(|ink| cover(&mut p, &[upright(points.clone())], *ink));
                    line.iter().for_each(|line| cover(&mut p, &border(&points, *line), line.ink));
                }
                Shape::Circle { at, radius, fill, line, .. } => {
                    let points = disc(at.map(|v| v * SCALE), radius * SCALE);
                    fill.iter().for_each(|ink| cover(&mut p, std::slice::from_ref(&points), *ink));
                    line.iter().for_each(|line| cover(&mut p, &border(&points, *line), line.ink));
                }
                Shape::Line { points, stroke } => {
                    cover(&mut p, &outline(&scaled(points), 0.5 * SCALE * stroke.width), stroke.ink);
                }
                Shape::Text { at, anchor, colour, text } => {
                    let width = Self::text_width(text) * SCALE;
                    let left = at[0] * SCALE
                        - match anchor {
                            Anchor::Start => 0.0,
                            Anchor::Middle => 0.5 * width,
                            Anchor::End => width,
                        };
                    // Letters end a quarter above the bottom of their line.
                    let top = (at[1] - 0.78 * Self::TEXT) * SCALE;
                    text::draw_large(&mut p, left.max(0.0) as usize, top.max(0.0) as usize, text, *colour);
                }
            }
        }
        p
    }
}

fn rgb([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn style(fill: Option<Ink>, line: Option<Stroke>) -> String {
    let paint = |what: &str, ink: Ink| {
        let opacity = if ink.opacity < 1.0 { format!(" {what}-opacity=\"{}\"", ink.opacity) } else { String::new() };
        format!(" {what}=\"{}\"{opacity}", rgb(ink.colour))
    };
    let fill = fill.map_or(" fill=\"none\"".to_owned(), |ink| paint("fill", ink));
    fill + &line.map_or(String::new(), |l| format!("{} stroke-width=\"{}\"", paint("stroke", l.ink), l.width))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn disc([x, y]: Place, radius: f32) -> Vec<Place> {
    let n = FEWEST_CORNERS.max((CORNERS_PER_PIXEL * radius) as usize);
    let corner = |i: usize| {
        let (s, c) = (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
        [x + radius * c, y + radius * s]
    };
    (0..n).map(corner).collect()
}

/// A polygon with a positive area, so that those of one stroke add up.
fn upright(mut points: Vec<Place>) -> Vec<Place> {
    let next = points.iter().cycle().skip(1);
    let area: f32 = points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    if area < 0.0 {
        points.reverse();
    }
    points
}

/// What a pen with this radius covers along a line.
fn outline(points: &[Place], radius: f32) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = points.iter().map(|p| disc(*p, radius)).collect();
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy);
        if length > 1e-6 {
            let [nx, ny] = [-dy / length * radius, dx / length * radius];
            let corners =
                vec![[a[0] + nx, a[1] + ny], [a[0] - nx, a[1] - ny], [b[0] - nx, b[1] - ny], [b[0] + nx, b[1] + ny]];
            parts.push(upright(corners));
        }
    }
    parts
}

/// Lays ink on everything with a winding number other than 0.
fn cover(p: &mut Picture, polygons: &[Vec<Place>], ink: Ink) {
    let points = || polygons.iter().flatten();
    let (low, high) = points().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), q| (l.min(q[1]), h.max(q[1])));
    let (first, last) = (low.floor().max(0.0) as usize, (high.ceil().max(0.0) as usize).min(p.height));
    if first >= last || p.width == 0 {
        return;
    }
    // The edges of each row of pixels.
    let mut edges: Vec<Vec<[Place; 2]>> = vec![Vec::new(); last - first];
    for polygon in polygons {
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let rows = (a[1].min(b[1]).max(0.0) as usize).max(first)..=(a[1].max(b[1]).max(0.0) as usize).min(last - 1);
            rows.for_each(|y| edges[y - first].push([*a, *b]));
        }
    }
    let mut covered = vec![0.0f32; p.width];
    let mut crossings: Vec<(f32, i32)> = Vec::new();
    for (y, edges) in (first..last).zip(&edges) {
        covered.fill(0.0);
        for k in 0..ROWS {
            let at = y as f32 + (k as f32 + 0.5) / ROWS as f32;
            crossings.clear();
            crossings.extend(edges.iter().filter(|[a, b]| (a[1] <= at) != (b[1] <= at)).map(|[a, b]| {
                let x = a[0] + (at - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                (x, if a[1] < b[1] { 1 } else { -1 })
            }));
            crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let (mut winding, mut from) = (0, 0.0);
            for &(x, turn) in &crossings {
                if winding == 0 {
                    from = x;
                }
                winding += turn;
                if winding == 0 {
                    span(&mut covered, from, x, 1.0 / ROWS as f32);
                }
            }
        }
        let row = &mut p.pixels[y * p.width..(y + 1) * p.width];
        for (pixel, &share) in row.iter_mut().zip(&covered).filter(|(_, c)| **c > 0.0) {
            let a = ink.opacity * share.min(1.0);
            *pixel = std::array::from_fn(|i| {
                let (under, over) = (f32::from(pixel[i]), f32::from(ink.colour[i]));
                (under + a * (over - under) + 0.5) as u8
            });
        }
    }
}

/// Adds to the pixels between two places of a row as much of each as lies between them.
fn span(covered: &mut [f32], from: f32, to: f32, weight: f32) {
    let (from, to) = (from.max(0.0), to.min(covered.len() as f32));
    if to <= from {
        return;
    }
    let (first, last) = (from as usize, (to as usize).min(covered.len() - 1));
    for x in first..=last {
        let inside = to.min(x as f32 + 1.0) - from.max(x as f32);
        covered[x] += weight * inside.max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing(shapes: Vec<Shape>) -> Drawing {
        Drawing { width: 60.0, height: 40.0, background: [255; 3], shapes }
    }

    /// Ink on a picture, in pixels of the drawing.
    fn inked(d: &Drawing) -> f64 {
        d.picture().pixels.iter().map(|c| f64::from(255 - c[0]) / 255.0).sum::<f64>() / 4.0
    }

    #[test]
    fn areas_are_covered_exactly() {
        let black = Some(Ink::of([0; 3]));
        let title = String::new;
        let triangle = vec![[10.3, 5.2], [50.1, 12.7], [21.4, 33.9]];
        let area = 0.5 * ((50.1 - 10.3) * (33.9 - 5.2) - (21.4 - 10.3) * (12.7 - 5.2));
        let polygon = |points| Shape::Polygon { points, fill: black, line: None, title: title() };
        assert!((inked(&drawing(vec![polygon(triangle.clone())])) - area).abs() < 1.0);
        let turned: Vec<Place> = triangle.into_iter().rev().collect();
        assert!((inked(&drawing(vec![polygon(turned)])) - area).abs() < 1.0);
        let circle = Shape::Circle { at: [30.0, 20.0], radius: 12.0, fill: black, line: None, title: title() };
        assert!((inked(&drawing(vec![circle])) / (std::f64::consts::PI * 144.0) - 1.0).abs() < 0.01);
        // A line that comes back on itself is no darker, and its ends are round.
        let stroke = Stroke { ink: Ink { colour: [0; 3], opacity: 0.5 }, width: 4.0 };
        let line = |points| Shape::Line { points, stroke };
        let once = inked(&drawing(vec![line(vec![[10.0, 20.0], [50.0, 20.0]])]));
        let twice = inked(&drawing(vec![line(vec![[10.0, 20.0], [50.0, 20.0], [10.0, 20.0]])]));
        assert!(
            (once - 0.5 * (160.0 + std::f64::consts::PI * 4.0)).abs() < 1.5 && (once - twice).abs() < 0.01,
            "{once} {twice}"
        );
        // What lies outside is left out.
        let beyond = vec![[-50.0, -50.0], [200.0, -50.0], [200.0, 200.0], [-50.0, 200.0]];
        assert!((inked(&drawing(vec![polygon(beyond)])) - 2400.0).abs() < 0.1);
        assert_eq!(inked(&drawing(vec![line(vec![]), line(vec![[f32::NAN; 2]; 2])])), 0.0);
    }

    #[test]
    fn words_stand_where_their_anchor_says_and_svg_is_well_formed() {
        let text = |anchor, x: f32| Shape::Text { at: [x, 30.0], anchor, colour: [0; 3], text: "A<&>B".into() };
        let columns = |anchor, x| {
            let p = drawing(vec![text(anchor, x)]).picture();
            let inked = (0..p.width).filter(|&x| (0..p.height).any(|y| p.get(x, y)[0] < 100));
            inked.fold((usize::MAX, 0), |(l, h), x| (l.min(x), h.max(x)))
        };
        let width = 2 * Drawing::text_width("A<&>B") as usize;
        let (start, middle, end) =
            (columns(Anchor::Start, 10.0), columns(Anchor::Middle, 30.0), columns(Anchor::End, 55.0));
        assert!(start.0 >= 20 && start.1 <= 20 + width, "{start:?}");
        assert!(middle.0 >= 60 - width / 2 && middle.1 <= 60 + width / 2, "{middle:?}");
        assert!(end.1 <= 110 && end.1 + 8 > 110, "{end:?}");
        let svg = drawing(vec![text(Anchor::End, 10.0)]).svg();
        assert!(svg.contains("A&lt;&amp;&gt;B") && svg.contains("text-anchor=\"end\"") && svg.ends_with("</svg>\n"));
    }
}
