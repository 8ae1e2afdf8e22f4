//! `convert`: from one file format to another.

use crate::args::Convert;
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::formats::{ConvertOptions, convert as run};

/// Converts a file.
pub(crate) fn convert(args: &Convert) -> Result<(), Failure> {
    let options = ConvertOptions {
        read: args.reading.options(),
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
    let done = run(&args.from, &args.to, &options, &args.reading.limits()).map_err(|e| report::run(&e))?;
    done.notes.iter().for_each(|n| print::note(&format!("note: {}", n.worded(&CommandLine))));
    for file in &done.files {
        print::line(&format!("wrote {}", file.display()))?;
    }
    Ok(())
}
