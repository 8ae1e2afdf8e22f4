//! Derives a grammar and draws it from the side: one that is built in, or one from a file.
//!
//! `cargo run --release -p eyot-reef --example grammar -- tree.svg [tree|bush|coral|FILE] [STEPS] [SEED]`

use eyot_core::Limits;
use eyot_reef::lsystem::{Drawing, Grammar};
use std::error::Error;
use std::fmt::Write;

/// A tree with three branches at each fork, which grow longer and sag.
const TREE: &str = "
axiom: !(0.4)F(0.5)/(45)A(1)
steps: 7
define: spread = 26
define: thin = 0.62
tropism: 0 0 -1
elasticity: 0.12
A(l) -> !F(l)[&(spread)/(random(-20,20))F(l*0.8)A(l*0.85)]/(110)[&(spread)F(l*0.8)A(l*0.8)]/(125)[&(spread)F(l*0.7)A(l*0.82)]
thinning: 0.6
";

/// A bush whose shoots keep growing.
const BUSH: &str = "
axiom: !(1)X
angle: 22.5
steps: 5
thinning: 0.75
X @ 2 -> F-[!&[X]+X]+F[!+FX]/(137)-X
X @ 1 -> F[!^X]F[!-X]/(137)+X
F -> FF
";

/// A branching coral: 25 first branches over a dome, of which each grows two more, or seldom one.
const CORAL: &str = "
axiom: T(25)
angle: 25
steps: 4
width: 1.6
define: turn = 137.5
T(n) : n > 0 -> [/(turn*n)&(85*sqrt(n/25))A(6)]T(n-1)
decomposition: 30
T(n) : n > 0 -> [/(turn*n)&(85*sqrt(n/25))A(6)]T(n-1)
rules:
A(l) @ 0.5 -> F(l)/(random(0,180))[+(random(20,30))!(1.4)A(l*0.9)][-(random(20,30))!(1.4)A(l*0.9)]
A(l) @ 0.4 -> F(l)/(random(0,180))[&(random(20,30))!(1.2)A(l*0.8)][^(random(20,30))!(1.4)A(l)]
A(l) @ 0.1 -> F(l)[+(random(-15,15))A(l*0.9)]
interpretation:
A(l) -> F(l)
";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("give the path of the SVG")?;
    let text = match arguments.get(1).map_or("tree", String::as_str) {
        "tree" => TREE.to_owned(),
        "bush" => BUSH.to_owned(),
        "coral" => CORAL.to_owned(),
        file => std::fs::read_to_string(file)?,
    };
    let grammar = Grammar::parse(&text)?;
    let steps = arguments.get(2).map_or(Ok(grammar.steps), |a| a.parse())?;
    let seed = arguments.get(3).map_or(Ok(1), |a| a.parse())?;
    let word = grammar.derive(steps, seed, &Limits::default())?;
    let drawing = grammar.draw(&word, seed, &Limits::default())?;
    println!("{} modules, {} segments, {} lines", word.len(), drawing.segments.len(), drawing.polylines().len());
    std::fs::write(path, svg(&drawing)?)?;
    Ok(())
}

/// From the side: x to the right, z up.
fn svg(drawing: &Drawing) -> Result<String, Box<dyn Error>> {
    let [low, high] = drawing.bounds().ok_or("nothing is drawn")?;
    let (w, h) = (high[0] - low[0], high[2] - low[2]);
    let margin = 0.03 * w.max(h).max(1e-9);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} {} {} {}\" width=\"900\" height=\"900\">\n\
         <rect x=\"-1e6\" y=\"-1e6\" width=\"2e6\" height=\"2e6\" fill=\"#f4f1e6\"/>\n",
        low[0] - margin,
        -high[2] - margin,
        w + 2.0 * margin,
        h + 2.0 * margin
    );
    // What is far away is drawn first, and paler.
    let mut order: Vec<_> = drawing.segments.iter().collect();
    order.sort_by(|a, b| b.from[1].total_cmp(&a.from[1]));
    for s in order {
        let far = (s.from[1] - low[1]) / (high[1] - low[1]).max(1e-9);
        let [r, g, b] = [(86.0, 90.0), (62.0, 90.0), (44.0, 90.0)].map(|(near, more)| (near + more * far) as u8);
        writeln!(
            out,
            "<line x1=\"{:.3}\" y1=\"{:.3}\" x2=\"{:.3}\" y2=\"{:.3}\" stroke=\"rgb({r},{g},{b})\" stroke-width=\"{:.4}\" \
             stroke-linecap=\"round\"/>",
            s.from[0],
            -s.from[2],
            s.to[0],
            -s.to[2],
            0.5 * (s.widths[0] + s.widths[1])
        )?;
    }
    Ok(out + "</svg>\n")
}
