//! Prints the cover of each species over the years and draws the plot from above.
//!
//! `cargo run --release -p eyot-reef --example plot -- reef.svg [SIDE_M] [YEARS] [SEED]`

use eyot_reef::community::{Community, DIRECTIONS, Forcing, Form, Plot, RAYS, Site};
use std::error::Error;
use std::fmt::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: f64| arguments.get(i).map_or(Ok(default), |a| a.parse());
    let path = arguments.first().ok_or("give the path of the SVG")?;
    let (side, years, seed) = (number(1, 10.0)?, number(2, 50.0)? as u64, number(3, 1.0)? as u64);

    let community = Community::default();
    let names: Vec<String> = community.species.iter().map(|s| s.name.clone()).collect();
    let forcing = Forcing::chumbe(&community, seed)?;
    let mut plot = Plot::new(community, Site::flat(side, side), forcing, seed)?;
    println!("{:>4}  {}  {:>8} {:>6} {:>9}", "year", names.join("  "), "algae", "T* C", "mm/yr");
    for year in 0..years {
        let (mut hottest, mut limestone, mut last) = (0.0f32, 0.0, None);
        for _ in 0..12 {
            let census = plot.month()?;
            hottest = hottest.max(census.heat.index);
            limestone += census.limestone_m;
            last = Some(census);
        }
        let Some(census) = last else { break };
        let covers: Vec<String> = census
            .species
            .iter()
            .zip(&names)
            .map(|(s, name)| format!("{:>width$.1} %", 100.0 * s.cover, width = name.len() - 2))
            .collect();
        let algae = 100.0 * census.algae_cover;
        println!("{year:>4}  {}  {algae:>6.1} % {hottest:>6.2} {:>9.2}", covers.join("  "), 1e3 * limestone);
    }
    std::fs::write(path, svg(&plot)?)?;
    println!("{} colonies and {} algae drawn to {path}", plot.colonies().len(), plot.algae().len());
    Ok(())
}

/// The plot from above, large colonies below small ones; bleached ones are pale.
fn svg(plot: &Plot) -> Result<String, std::fmt::Error> {
    let (w, h) = (plot.site().width_m, plot.site().length_m);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"1000\" height=\"{:.0}\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#e9dfc6\"/>\n",
        1000.0 * h / w
    );
    let mut order: Vec<usize> = (0..plot.colonies().len()).collect();
    order.sort_by(|&a, &b| plot.colonies()[b].radius.total_cmp(&plot.colonies()[a].radius));
    for i in order {
        let (c, rays) = (&plot.colonies()[i], &plot.rays()[i]);
        let species = &plot.community().species[usize::from(c.species)];
        let [r, g, b] = species.colour.map(|v| (f32::from(v) + (250.0 - f32::from(v)) * c.bleaching) as u8);
        let fill = format!("fill=\"rgb({r},{g},{b})\" fill-opacity=\"0.85\" stroke=\"#222\" stroke-width=\"0.01\"");
        match species.form {
            Form::Branching => writeln!(out, "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {fill}/>", c.x, c.y, c.radius)?,
            Form::Massive => {
                let tip = |k: usize| (c.x + DIRECTIONS[k][0] * rays[k], c.y + DIRECTIONS[k][1] * rays[k]);
                let points: Vec<String> = (0..RAYS).map(tip).map(|(x, y)| format!("{x:.3},{y:.3}")).collect();
                writeln!(out, "<polygon points=\"{}\" {fill}/>", points.join(" "))?;
            }
        }
    }
    for a in plot.algae() {
        writeln!(
            out,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"#6b8e23\" fill-opacity=\"0.7\"/>",
            a.x, a.y, a.radius
        )?;
    }
    Ok(out + "</svg>\n")
}
