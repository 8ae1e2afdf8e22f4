//! Pictures of a plot as SVG: from above, and the cover of its species over the years.

use super::geometry::{DIRECTIONS, RAYS};
use super::plot::Plot;
use super::species::{Form, Species};
use std::fmt::Write;

/// Width of a picture, in pixels of its own.
const WIDTH: f64 = 1000.0;
/// Sand under the colonies.
const SAND: &str = "#e9dfc6";
/// Macroalgae.
const ALGAE: [u8; 3] = [107, 142, 35];

/// The plot from above, large colonies below small ones; bleached ones are pale. North is up.
pub fn plan_svg(plot: &Plot) -> String {
    let (w, h) = (plot.site().width_m, plot.site().length_m);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{WIDTH}\" height=\"{:.0}\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"{SAND}\"/>\n",
        WIDTH * h / w
    );
    let mut order: Vec<usize> = (0..plot.colonies().len()).collect();
    order.sort_by(|&a, &b| plot.colonies()[b].radius.total_cmp(&plot.colonies()[a].radius).then(a.cmp(&b)));
    for i in order {
        let (c, rays) = (&plot.colonies()[i], &plot.rays()[i]);
        let species = &plot.community().species[usize::from(c.species)];
        let [r, g, b] = species.colour.map(|v| (f32::from(v) + (250.0 - f32::from(v)) * c.bleaching) as u8);
        let style = format!("fill=\"rgb({r},{g},{b})\" fill-opacity=\"0.85\" stroke=\"#222\" stroke-width=\"0.01\"");
        let shape = match species.form {
            Form::Branching => format!("<circle cx=\"{:.3}\" cy=\"{:.3}\" r=\"{:.3}\"", c.x, c.y, c.radius),
            Form::Massive => {
                let tip = |k: usize| (c.x + DIRECTIONS[k][0] * rays[k], c.y + DIRECTIONS[k][1] * rays[k]);
                let points: Vec<String> = (0..RAYS).map(tip).map(|(x, y)| format!("{x:.3},{y:.3}")).collect();
                format!("<polygon points=\"{}\"", points.join(" "))
            }
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{shape} {style}><title>{} {}, {} months</title></{}>",
            species.name,
            c.id,
            c.age,
            tag(species)
        );
    }
    let [r, g, b] = ALGAE;
    for a in plot.algae() {
        let _ = writeln!(
            out,
            "<circle cx=\"{:.3}\" cy=\"{:.3}\" r=\"{:.3}\" fill=\"rgb({r},{g},{b})\" fill-opacity=\"0.7\"/>",
            a.x, a.y, a.radius
        );
    }
    out + "</svg>\n"
}

fn tag(species: &Species) -> &'static str {
    if species.form == Form::Branching { "circle" } else { "polygon" }
}

/// A curve of [`cover_svg`].
pub struct Curve<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// sRGB.
    pub colour: [u8; 3],
    /// Share of the plot at the end of each month, 0 to 1.
    pub cover: Vec<f64>,
}

impl<'a> Curve<'a> {
    /// The colour of macroalgae in all pictures.
    pub fn of_algae(cover: Vec<f64>) -> Self {
        Curve { name: "macroalgae", colour: ALGAE, cover }
    }
}

/// Cover over the years, with a grid, a legend, and a mark at each month of `hot`.
pub fn cover_svg(title: &str, curves: &[Curve<'_>], hot: &[u64]) -> String {
    const LEFT: f64 = 70.0;
    const TOP: f64 = 50.0;
    const HEIGHT: f64 = 420.0;
    const RIGHT: f64 = 230.0;
    let months = curves.iter().map(|c| c.cover.len()).max().unwrap_or(0).max(2);
    let most = curves.iter().flat_map(|c| c.cover.iter().copied()).fold(0.01, f64::max);
    let step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].into_iter().find(|s| most / s <= 6.0).unwrap_or(1.0);
    let top = (most / step).ceil() * step;
    let width = WIDTH - LEFT - RIGHT;
    let x = |month: f64| LEFT + width * month / (months - 1) as f64;
    let y = |cover: f64| TOP + HEIGHT * (1.0 - cover / top);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {0}\" width=\"{WIDTH}\" height=\"{0}\" \
         font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"{WIDTH}\" height=\"{0}\" fill=\"#fff\"/>\n\
         <text x=\"{LEFT}\" y=\"30\" font-size=\"18\">{1}</text>\n",
        TOP + HEIGHT + 60.0,
        escaped(title)
    );
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    for &month in hot {
        let at = x(month as f64);
        line(format!("<line x1=\"{at:.1}\" y1=\"{TOP}\" x2=\"{at:.1}\" y2=\"{}\" stroke=\"#f3b8a8\"/>", TOP + HEIGHT));
    }
    for n in 0..=(top / step).round() as usize {
        let (cover, at) = (n as f64 * step, y(n as f64 * step));
        line(format!("<line x1=\"{LEFT}\" y1=\"{at:.1}\" x2=\"{}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>", LEFT + width));
        line(format!(
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{:.0} %</text>",
            LEFT - 8.0,
            at + 5.0,
            100.0 * cover
        ));
    }
    let years = months as f64 / 12.0;
    let apart = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().find(|a| years / a <= 8.0).unwrap_or(500.0);
    for n in 0..=(years / apart) as usize {
        let (year, at) = (n as f64 * apart, x((12.0 * n as f64 * apart).min((months - 1) as f64)));
        line(format!("<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{year:.0}</text>", TOP + HEIGHT + 22.0));
    }
    line(format!(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">years</text>",
        LEFT + 0.5 * width,
        TOP + HEIGHT + 46.0
    ));
    for (n, curve) in curves.iter().enumerate() {
        let [r, g, b] = curve.colour;
        let points: Vec<String> =
            curve.cover.iter().enumerate().map(|(m, &c)| format!("{:.1},{:.1}", x(m as f64), y(c))).collect();
        let stroke = format!("stroke=\"rgb({r},{g},{b})\" stroke-width=\"2\" fill=\"none\"");
        line(format!("<polyline points=\"{}\" {stroke}/>", points.join(" ")));
        let (at, row) = (LEFT + width + 16.0, TOP + 14.0 + 24.0 * n as f64);
        line(format!("<line x1=\"{at}\" y1=\"{row}\" x2=\"{}\" y2=\"{row}\" {stroke}/>", at + 22.0));
        line(format!("<text x=\"{}\" y=\"{}\">{}</text>", at + 30.0, row + 5.0, escaped(curve.name)));
    }
    out + "</svg>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::{Community, Forcing, Site};
    use super::*;

    #[test]
    fn pictures_show_every_colony_and_every_month() {
        let community = Community::default();
        let forcing = Forcing::chumbe(&community, 3).unwrap();
        let mut plot = Plot::new(community, Site::flat(8.0, 4.0), forcing, 3).unwrap();
        for _ in 0..5 {
            plot.month().unwrap();
        }
        let plan = plan_svg(&plot);
        let shapes = plan.matches("<circle").count() + plan.matches("<polygon").count();
        assert_eq!(shapes, plot.colonies().len() + plot.algae().len());
        assert!(plan.contains("height=\"500\"") && plan.ends_with("</svg>\n"));
        let curve = Curve { name: "Porites <lobata>", colour: [1, 2, 3], cover: vec![0.1, 0.35, 0.2] };
        let chart = cover_svg("A & B", &[curve, Curve::of_algae(vec![0.0; 3])], &[1]);
        assert!(chart.contains("Porites &lt;lobata&gt;") && chart.contains("A &amp; B"));
        // The highest of 35 % under a grid that ends at 40 %.
        assert!(chart.contains(">40 %<") && !chart.contains(">50 %<"));
        assert_eq!(chart.matches("<polyline").count(), 2);
    }
}
