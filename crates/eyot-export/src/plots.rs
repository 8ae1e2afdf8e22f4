//! Drawings of a reef: cover of its species over the years, and the plot as ecologists draw it.

use eyot_reef::community::{DIRECTIONS, Form, Plot, RAYS};
use eyot_render::{Anchor, Drawing, Ink, Place, Shape, Stroke};

/// Width of a drawing.
const WIDTH: f32 = 1000.0;
/// Sand under the colonies.
const SAND: [u8; 3] = [233, 223, 198];
/// Macroalgae.
pub(crate) const ALGAE: [u8; 3] = [107, 142, 35];
const INK: [u8; 3] = [40, 44, 48];
const GRID: [u8; 3] = [222, 222, 222];
/// Months that bleach somebody, and the bleached.
const HOT: [u8; 3] = [245, 196, 180];
const PALE: [u8; 3] = [208, 88, 60];
/// Where the chart stands, and how high its two parts are.
const LEFT: f32 = 76.0;
const TOP: f32 = 52.0;
const RIGHT: f32 = 262.0;
const COVER: f32 = 400.0;
const GAP: f32 = 34.0;
const BLEACHED: f32 = 90.0;

/// A curve of [`cover`].
pub(crate) struct Curve<'a> {
    /// Name in the legend.
    pub(crate) name: &'a str,
    /// sRGB.
    pub(crate) colour: [u8; 3],
    /// Share of the plot at the end of each month.
    pub(crate) cover: Vec<f64>,
}

/// What [`cover`] shows.
pub(crate) struct Story<'a> {
    pub(crate) title: &'a str,
    /// Corals first.
    pub(crate) curves: Vec<Curve<'a>>,
    /// Share of all colonies that are bleached, month by month.
    pub(crate) bleached: Vec<f64>,
    /// Months whose heat bleaches somebody.
    pub(crate) hot: Vec<usize>,
}

/// Room for a row of a legend, and for the name of a species in it.
const ROW: f32 = 25.0;
const NAME: f32 = 240.0;
/// Room above and below the scale and the legend of a plan.
const MARGIN: f32 = 20.0;

/// The plot from above, large colonies below small ones; bleached ones are pale. North is up. Below it a scale, and the colours of
/// those who live.
pub(crate) fn plan(plot: &Plot) -> Drawing {
    let (w, h) = (plot.site().width_m as f32, plot.site().length_m as f32);
    let scale = WIDTH / w.max(h);
    let at = |x: f32, y: f32| [x * scale, y * scale];
    let border = Stroke { ink: Ink { colour: [34; 3], opacity: 0.8 }, width: (0.01 * scale).clamp(0.1, 1.0) };
    let mut order: Vec<usize> = (0..plot.colonies().len()).collect();
    order.sort_by(|&a, &b| plot.colonies()[b].radius.total_cmp(&plot.colonies()[a].radius).then(a.cmp(&b)));
    let colonies = order.into_iter().map(|i| {
        let (c, rays) = (&plot.colonies()[i], &plot.rays()[i]);
        let species = &plot.community().species[usize::from(c.species)];
        let colour = species.colour.map(|v| (f32::from(v) + (250.0 - f32::from(v)) * c.bleaching) as u8);
        let (fill, line) = (Some(Ink { colour, opacity: 0.85 }), Some(border));
        let title = format!("{} {}, {} months", species.name, c.id, c.age);
        match species.form {
            Form::Branching => Shape::Circle { at: at(c.x, c.y), radius: c.radius * scale, fill, line, title },
            Form::Massive => {
                let tip = |k: usize| at(c.x + DIRECTIONS[k][0] * rays[k], c.y + DIRECTIONS[k][1] * rays[k]);
                Shape::Polygon { points: (0..RAYS).map(tip).collect(), fill, line, title }
            }
        }
    });
    let weed = Some(Ink { colour: ALGAE, opacity: 0.7 });
    let algae = plot.algae().iter().map(|a| Shape::Circle {
        at: at(a.x, a.y),
        radius: a.radius * scale,
        fill: weed,
        line: None,
        title: String::new(),
    });
    let mut shapes: Vec<Shape> = colonies.chain(algae).collect();
    let lives = |n: usize| plot.colonies().iter().any(|c| usize::from(c.species) == n);
    let species = plot.community().species.iter().enumerate().filter(|(n, _)| lives(*n));
    let mut legend: Vec<(&str, [u8; 3])> = species.map(|(_, s)| (s.name.as_str(), s.colour)).collect();
    if !plot.algae().is_empty() {
        legend.push(("macroalgae", ALGAE));
    }
    let (width, below) = ((w * scale).max(2.0 * MARGIN + NAME), h * scale);
    let columns = (((width - 2.0 * MARGIN) / NAME) as usize).max(1);
    let height = below + 2.0 * MARGIN + ROW * (1 + legend.len().div_ceil(columns)) as f32;
    // What reaches over the rim of the plot is cut off there.
    let paper = |from: Place, to: Place| Shape::Polygon {
        points: vec![from, [to[0], from[1]], to, [from[0], to[1]]],
        fill: Some(Ink::of([255; 3])),
        line: None,
        title: String::new(),
    };
    shapes.push(paper([0.0, below], [width, height]));
    if width > w * scale {
        shapes.push(paper([w * scale, 0.0], [width, below]));
    }
    let text = |x: f32, y: f32, text: String| Shape::Text { at: [x, y], anchor: Anchor::Start, colour: INK, text };
    let length = scale_length(w.max(h));
    let (bar, y) = (length * scale, below + MARGIN + 10.0);
    for points in [
        vec![[MARGIN, y], [MARGIN + bar, y]],
        vec![[MARGIN, y - 5.0], [MARGIN, y + 5.0]],
        vec![[MARGIN + bar, y - 5.0], [MARGIN + bar, y + 5.0]],
    ] {
        shapes.push(Shape::Line { points, stroke: Stroke { ink: Ink::of(INK), width: 2.0 } });
    }
    shapes.push(text(MARGIN + bar + 12.0, y + 5.0, format!("{length} m, north is up")));
    for (n, (name, colour)) in legend.into_iter().enumerate() {
        let at = [MARGIN + NAME * (n % columns) as f32 + 8.0, y + ROW * (1 + n / columns) as f32 + 6.0];
        shapes.push(Shape::Circle { at, radius: 8.0, fill: Some(Ink::of(colour)), line: None, title: String::new() });
        shapes.push(text(at[0] + 16.0, at[1] + 5.0, name.to_owned()));
    }
    Drawing { width, height, background: SAND, shapes }
}

/// A round length for a scale, m: between a tenth and a quarter of the longer side.
fn scale_length(side: f32) -> f32 {
    let power = 10.0f32.powi((0.25 * side).log10().floor() as i32);
    let round = [5.0, 2.0, 1.0].into_iter().find(|n| n * power <= 0.25 * side).unwrap_or(1.0) * power;
    // Powers of ten below one are not exact.
    (round * 1e4).round() / 1e4
}

/// Cover over the years with a grid, a legend and a mark at each hot month; below, how many colonies are bleached.
pub(crate) fn cover(story: &Story<'_>) -> Drawing {
    let curves = &story.curves;
    let months = curves.iter().map(|c| c.cover.len()).max().unwrap_or(0).max(2);
    // A census comes from a file: whatever it claims to cover, the scale has seven lines at most.
    let most = curves.iter().flat_map(|c| c.cover.iter().copied()).filter(|c| c.is_finite()).fold(0.01, f64::max);
    let step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].into_iter().find(|s| most / s <= 6.0);
    let step = step.unwrap_or_else(|| (most / 6.0).ceil());
    let top = (most / step).ceil() * step;
    let width = WIDTH - LEFT - RIGHT;
    let (bottom, low) = (TOP + COVER, TOP + COVER + GAP + BLEACHED);
    let x = |month: usize| LEFT + width * month as f32 / (months - 1) as f32;
    let y = |cover: f64| TOP + COVER * (1.0 - (cover / top) as f32);
    let share = |share: f64| low - BLEACHED * share as f32;
    let mut shapes = Vec::new();
    let mut line = |points: Vec<Place>, colour: [u8; 3], width: f32| {
        shapes.push(Shape::Line { points, stroke: Stroke { ink: Ink::of(colour), width } });
    };
    for &month in &story.hot {
        line(vec![[x(month), TOP], [x(month), bottom]], HOT, 1.5);
        line(vec![[x(month), bottom + GAP], [x(month), low]], HOT, 1.5);
    }
    let levels: Vec<f64> = (0..=(top / step).round() as usize).map(|n| n as f64 * step).collect();
    levels.iter().for_each(|&c| line(vec![[LEFT, y(c)], [LEFT + width, y(c)]], GRID, 1.0));
    [0.0, 0.5, 1.0].iter().for_each(|&s| line(vec![[LEFT, share(s)], [LEFT + width, share(s)]], GRID, 1.0));
    for (n, curve) in curves.iter().enumerate() {
        line(curve.cover.iter().enumerate().map(|(m, &c)| [x(m), y(c)]).collect(), curve.colour, 2.0);
        let row = legend_row(n);
        line(vec![[LEFT + width + 18.0, row], [LEFT + width + 42.0, row]], curve.colour, 3.0);
    }
    line(story.bleached.iter().enumerate().map(|(m, &s)| [x(m), share(s)]).collect(), PALE, 1.8);
    let mut text = |x: f32, y: f32, anchor: Anchor, text: String| {
        shapes.push(Shape::Text { at: [x, y], anchor, colour: INK, text });
    };
    text(LEFT, 30.0, Anchor::Start, story.title.to_owned());
    levels.iter().for_each(|&c| text(LEFT - 10.0, y(c) + 5.0, Anchor::End, format!("{:.0} %", 100.0 * c)));
    [0.0, 1.0].iter().for_each(|&s| text(LEFT - 10.0, share(s) + 5.0, Anchor::End, format!("{:.0} %", 100.0 * s)));
    let years = months as f64 / 12.0;
    let apart = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().find(|a| years / a <= 8.0).unwrap_or(500.0);
    for year in (0..=(years / apart) as usize).map(|n| n as f64 * apart) {
        let month = ((12.0 * year) as usize).min(months - 1);
        text(x(month), low + 24.0, Anchor::Middle, format!("{year:.0}"));
    }
    text(LEFT + 0.5 * width, low + 48.0, Anchor::Middle, "years".into());
    for (n, curve) in curves.iter().enumerate() {
        text(LEFT + width + 50.0, legend_row(n) + 5.0, Anchor::Start, curve.name.to_owned());
    }
    text(LEFT + width + 18.0, bottom + GAP + 12.0, Anchor::Start, "bleached colonies".into());
    if !story.hot.is_empty() {
        text(LEFT + width + 18.0, bottom + GAP + 34.0, Anchor::Start, "(bars: hot months)".into());
    }
    Drawing { width: WIDTH, height: low + 66.0, background: [255; 3], shapes }
}

fn legend_row(n: usize) -> f32 {
    TOP + 12.0 + 25.0 * n as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_reef::community::{Community, Forcing, Site};

    #[test]
    fn drawings_show_every_colony_and_every_month() {
        let community = Community::default();
        let forcing = Forcing::chumbe(&community, 3).unwrap();
        let mut plot = Plot::new(community, Site::flat(8.0, 4.0), forcing, 3).unwrap();
        for _ in 0..5 {
            plot.month().unwrap();
        }
        let drawing = plan(&plot);
        let species: Vec<&str> = plot.community().species.iter().map(|s| s.name.as_str()).collect();
        let living = (0..species.len()).filter(|&n| plot.colonies().iter().any(|c| usize::from(c.species) == n));
        let words: Vec<&String> = drawing
            .shapes
            .iter()
            .filter_map(|s| if let Shape::Text { text, .. } = s { Some(text) } else { None })
            .collect();
        assert_eq!(words[0], "2 m, north is up");
        assert!(
            living.clone().all(|n| words.iter().any(|w| *w == species[n])) && words.iter().any(|w| *w == "macroalgae")
        );
        // Paper below, the scale and its ends, and a spot with a name for each kind.
        let kinds = living.count() + 1;
        assert_eq!(drawing.shapes.len(), plot.colonies().len() + plot.algae().len() + 1 + 3 + 1 + 2 * kinds);
        let rows = 1 + kinds.div_ceil(4);
        assert_eq!((drawing.width, drawing.height), (1000.0, 500.0 + 40.0 + 25.0 * rows as f32));
        let bar =
            drawing.shapes.iter().find_map(|s| if let Shape::Line { points, .. } = s { Some(points) } else { None });
        assert_eq!(bar.map(|p| p[1][0] - p[0][0]), Some(2.0 * 1000.0 / 8.0));
        assert_eq!([0.5, 3.9, 4.0, 10.0, 100.0, 4000.0].map(scale_length), [0.1, 0.5, 1.0, 2.0, 20.0, 1000.0]);
        let curve = |name, cover| Curve { name, colour: [1, 2, 3], cover };
        let curves = vec![curve("Porites <lobata>", vec![0.1, 0.35, 0.2]), curve("macroalgae", vec![0.0; 3])];
        let story = Story { title: "A & B", curves, bleached: vec![0.0, 1.0, 0.5], hot: vec![1] };
        let chart = cover(&story).svg();
        assert!(chart.contains("Porites &lt;lobata&gt;") && chart.contains("A &amp; B"));
        // The highest of 35 % under a grid that ends at 40 %.
        assert!(chart.contains(">40 %<") && !chart.contains(">50 %<"));
        // Hot months in both parts, grids, curves with their legend, the bleached.
        assert_eq!(chart.matches("<polyline").count(), 2 + 5 + 3 + 2 * 2 + 1);
        let wild = |cover| Story { title: "", curves: vec![curve("x", cover)], bleached: vec![], hot: vec![] };
        for cover_of in [1.0, 3.0, 1e9, 1e300, f64::INFINITY, f64::NAN, -1e9] {
            let drawing = cover(&wild(vec![cover_of, 0.5]));
            assert!(drawing.shapes.len() < 40, "{} shapes for {cover_of}", drawing.shapes.len());
        }
        let picture = cover(&story).picture();
        assert_eq!((picture.width, picture.height), (2000, 2 * (TOP + COVER + GAP + BLEACHED + 66.0) as usize));
        assert!(picture.pixels.contains(&[1, 2, 3]) && picture.pixels.contains(&PALE));
    }
}
