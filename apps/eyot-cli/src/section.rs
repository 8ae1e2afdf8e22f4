//! `section`: a cut through the land along a line.

use crate::args::{Reading, size};
use crate::excerpt::clipped;
use crate::{Failure, inspect, print, report};
use clap::Args;
use eyot::store::{self, SectionOptions};
use std::path::PathBuf;

/// Width of the picture unless something else is asked for, pixels.
const WIDTH: u32 = 2000;

#[derive(Args)]
#[command(after_help = "\
Examples:
  eyot section canyon                       from west to east through the highest place
  eyot section canyon --line 0,0.5,1,0.5    through the middle, in shares of width and height
  eyot section canyon --line 0m,2500m,4000m,2500m,8000m,0m --out bend.svg
  eyot section canyon --exaggeration 3 --size 2400x900

Points are given as x,y from the north-western corner, to the east and to the south: 0 to 1 for shares of the land, or metres with \
an m behind each number. Beds are those of the process `strata`; where there is none, the ground is of one kind. The areas that are \
printed are those of the cells that the line passes, down to the foot of the picture.")]
pub(crate) struct Section {
    /// Folder of a run, or a height map
    from: PathBuf,
    /// Points of the line, 2 to 100: x0,y0,x1,y1 and so on, as shares of the land or in metres [default: from west to east through the highest place]
    #[arg(long, value_name = "X,Y,...", allow_hyphen_values = true)]
    line: Option<String>,
    /// The picture, a .png or a .svg [default: FOLDER/section.png, or beside the height map]
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Factor on heights, 0.01 to 1000 [default: a round one that shows the relief; it is printed in the picture]
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = |s: &str| crate::args::number(s, 0.01, 1000.0))]
    exaggeration: Option<f32>,
    /// Width x height of the picture in pixels, legend included: 500 to 16384 x 300 to 16384; without a height it follows from the factor [default: 2000]
    #[arg(long, value_name = "WxH", allow_negative_numbers = true, value_parser = size)]
    size: Option<(u32, Option<u32>)>,
    /// Print line, exaggeration and areas as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: Reading,
}

/// Coordinates of points, each with whether it is in metres.
#[derive(Clone, Debug, PartialEq)]
struct Line(Vec<[(f64, bool); 2]>);

fn line(text: &str) -> Result<Line, String> {
    let help = "write x0,y0,x1,y1 with shares from 0 to 1, such as 0,0.5,1,0.5, or metres, such as 0m,300m,900m,300m";
    let number = |s: &str| {
        let s = s.trim();
        let (digits, metres) = s.strip_suffix('m').map_or((s, false), |d| (d, true));
        let value = digits.trim().parse::<f64>().ok().filter(|v| v.is_finite() && (metres || (0.0..=1.0).contains(v)));
        value.map(|v| (v, metres)).ok_or_else(|| help.to_owned())
    };
    let all = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    if all.len() < 4 || all.len() % 2 != 0 {
        return Err(help.to_owned());
    }
    Ok(Line(all.chunks_exact(2).map(|p| [p[0], p[1]]).collect()))
}

/// Draws a section.
pub(crate) fn section(args: &Section) -> Result<(), Failure> {
    let read =
        |text: &String| line(text).map_err(|help| report::usage(&format!("`{}` is no line", clipped(text, 60)), &help));
    let points = args.line.as_ref().map(read).transpose()?;
    let opened = inspect::open(&args.from, &args.reading)?;
    inspect::has_ground(&opened, &args.from)?;
    let (w, h) = args.size.unwrap_or((WIDTH, None));
    if !(500..=16384).contains(&w) || h.is_some_and(|h| !(300..=16384).contains(&h)) {
        return Err(report::usage(
            "a picture of this size",
            "choose 500 to 16384 pixels for the width, 300 to 16384 for the height",
        ));
    }
    let g = &opened.world.grid;
    let land = [g.width as f64 * g.cell_x_m, g.height as f64 * g.cell_y_m];
    let point = |p: &[(f64, bool); 2]| [0, 1].map(|i| if p[i].1 { p[i].0 } else { p[i].0 * land[i] });
    let out = args.out.clone().unwrap_or_else(|| {
        if args.from.is_dir() { args.from.join("section.png") } else { args.from.with_extension("eyot.section.png") }
    });
    let name = args.from.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let options = SectionOptions {
        line: points.iter().flat_map(|l| &l.0).map(point).collect(),
        size: (w, h),
        // As people wrote it: 1.1 and not 1.10000002.
        exaggeration: args.exaggeration.and_then(|e| e.to_string().parse().ok()),
        title: name,
    };
    let drawn = store::section(&opened.world, &options, &out).map_err(|e| report::run(&e))?;
    if args.json {
        let areas: serde_json::Map<_, _> =
            drawn.areas_m2.iter().map(|(name, area)| (name.clone(), serde_json::json!(area))).collect();
        let all = serde_json::json!({
            "file": out, "line_m": drawn.line, "length_m": drawn.length_m, "exaggeration": drawn.exaggeration,
            "floor_m": drawn.floor_m, "areas_m2": areas,
        });
        return print::line(&format!("{all:#}"));
    }
    let heights = if drawn.exaggeration == 1.0 {
        "heights to scale".to_owned()
    } else {
        format!("heights times {}", (drawn.exaggeration * 1e3).round() / 1e3)
    };
    print::line(&format!("wrote {}: {:.0} m long, {heights}", out.display(), drawn.length_m))?;
    print::line(&format!("areas above {:.1} m, m2:", drawn.floor_m))?;
    drawn.areas_m2.iter().try_for_each(|(name, area)| print::line(&format!("  {name:<20} {area:.0}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_shares_or_metres() {
        assert_eq!(line("0,0.5,1,0.5"), Ok(Line(vec![[(0.0, false), (0.5, false)], [(1.0, false), (0.5, false)]])));
        assert_eq!(line("0m, 5m,1,250.5m").map(|l| l.0[1]), Ok([(1.0, false), (250.5, true)]));
        for wrong in ["", "0,0", "0,0,1", "0,0,2,0", "0,0,x,0", "0,0,1,0,1", "0,0,nan,0", "0,0,infm,0", "-1,0,1,0"] {
            assert!(line(wrong).is_err(), "{wrong}");
        }
    }
}
