//! `convert`: from one file format to another.

use crate::args::Convert;
use crate::wording::CommandLine;
use crate::{Failure, print, recipe_cmd, report};
use eyot::formats::ReadOptions;
use eyot::formats::{ConvertOptions, convert as run};

/// Converts a file.
pub(crate) fn convert(args: &Convert) -> Result<(), Failure> {
    let options = ConvertOptions {
        read: ReadOptions {
            low_m: args.from_range.map(|r| r.0),
            high_m: args.from_range.map(|r| r.1),
            nodata: args.nodata,
            size: args.from_size.map(|(w, h)| (w as usize, h.unwrap_or(w) as usize)),
            sample: args.from_type.map(|t| t.0),
            byte_order: args.from_type.map(|t| t.1),
            row_order: args.from_rows,
            ..ReadOptions::default()
        },
        layers: args.layer.clone(),
        range: args.range,
        byte_order: args.bytes,
        row_order: args.rows,
        cell_m: args.cell,
        preset: args.preset,
        size: args.size,
        tiles: args.tiles.map(|(x, y)| [x, y.unwrap_or(x)]),
        vertices: args.vertices,
        force: args.force,
    };
    let done =
        run(&args.from, &args.to, &options, &recipe_cmd::limits(args.max_memory)).map_err(|e| report::run(&e))?;
    done.notes.iter().for_each(|n| print::note(&format!("note: {}", n.worded(&CommandLine))));
    for file in &done.files {
        print::line(&format!("wrote {}", file.display()))?;
    }
    Ok(())
}
