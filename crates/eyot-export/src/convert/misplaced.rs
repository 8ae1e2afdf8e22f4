//! Options that could not have an effect, which somebody who gave them would not notice.

use super::{Conversion, Input, Output};
use crate::error::ExportError;
use eyot_core::remedy;
use eyot_core::remedy::{Remedy, Setting};
use eyot_io::{Numbers, Raster, RasterFormat};
use eyot_recipe::{ExportFormat, Preset};

/// Extensions of files, which name no folder that somebody means.
const FILES: [&str; 11] = ["tif", "tiff", "png", "r16", "raw", "r32", "exr", "npy", "zarr", "glb", "obj"];

impl Conversion<'_> {
    /// What is wrong with an option, and the remedy.
    pub(super) fn misplaced(&self) -> Option<Remedy> {
        let (input, output, options) = (self.input.display(), self.output.display(), self.options);
        let (named, several) = (!options.layers.is_empty(), options.layers.len() > 1);
        let is_run = self.from == Input::Run;
        let shows_height =
            matches!(self.to, Output::Mesh(_) | Output::Preset(_)) && self.to != Output::Preset(Preset::Gis);
        let bare_output = matches!(self.to, Output::Raster(RasterFormat::R16 | RasterFormat::R32));
        let quantised = matches!(self.to, Output::Raster(format) if format.is_quantised());
        let is_preset = options.preset.is_some();
        let bare = options.read.size.is_some() || options.read.sample.is_some() || options.read.row_order.is_some();
        let ranged = options.read.low_m.is_some() || options.read.high_m.is_some();
        let has_header = self.input.is_dir()
            || self
                .input
                .extension()
                .and_then(|e| RasterFormat::from_extension(e.to_str()?))
                .is_some_and(|f| !matches!(f, RasterFormat::R16 | RasterFormat::R32));
        let leave_out = |setting: Setting| remedy!["leave out ", setting];
        let checks = [
            (named && self.from == Input::One, format!("`{input}` holds a single layer"), leave_out(Setting::Layer)),
            (
                named && is_run && shows_height,
                format!("`{output}` shows the height of a run"),
                leave_out(Setting::Layer),
            ),
            (
                several && !self.to.takes_several(),
                format!("`{output}` holds a single layer"),
                remedy!["name one with ", Setting::Layer, ", or write .zarr or .exr"],
            ),
            (
                bare && (is_run || has_header),
                format!("`{input}` says its size and its numbers itself"),
                remedy![leave_out(Setting::InputSize), ", ", Setting::InputType, " and ", Setting::InputRows,],
            ),
            (
                (ranged || options.read.nodata.is_some()) && is_run,
                format!("`{input}` holds a run, whose layers are numbers as they are"),
                remedy![leave_out(Setting::InputRange), " and ", Setting::Nodata],
            ),
            (
                options.tiles.is_some() && self.to != Output::Mesh(ExportFormat::Glb),
                format!("`{output}` is no mesh as glTF, which can be cut into tiles"),
                remedy![leave_out(Setting::Tiles), ", or write .glb"],
            ),
            (
                options.vertices.is_some() && !matches!(self.to, Output::Mesh(_)),
                format!("`{output}` is no mesh"),
                leave_out(Setting::Vertices),
            ),
            (
                options.range.is_some() && !quantised,
                match is_preset {
                    true => "a preset chooses the scale itself".to_owned(),
                    false => format!("`{output}` holds values as they are, without a scale"),
                },
                remedy![
                    leave_out(Setting::Range),
                    ", or write .png or .r16; what whole numbers of the input stand for is ",
                    Setting::InputRange,
                ],
            ),
            (
                options.byte_order.is_some() && !bare_output,
                match is_preset {
                    true => "a preset chooses the order of bytes itself".to_owned(),
                    false => format!("`{output}` has an order of bytes of its own"),
                },
                remedy![leave_out(Setting::ByteOrder), ", or write .r16, .raw or .r32"],
            ),
            (
                options.row_order.is_some() && !bare_output && options.preset != Some(Preset::Unity),
                match is_preset {
                    true => "this preset chooses the order of rows itself".to_owned(),
                    false => format!("`{output}` has its north on top like every file of its kind"),
                },
                remedy![leave_out(Setting::Rows), ", or write .r16, .raw or .r32"],
            ),
            (
                is_preset && self.output.extension().is_some_and(|e| FILES.iter().any(|f| e.eq_ignore_ascii_case(f))),
                format!("`{output}` would be a folder with the files of the preset"),
                remedy!["give it another name, or leave out ", Setting::Preset, " to write one file"],
            ),
            (
                options.size.is_some() && !is_preset,
                format!("`{output}` keeps the size of the input"),
                remedy![leave_out(Setting::Size), ", or choose ", Setting::Preset.to("unreal"), " or unity"],
            ),
        ];
        let wrong = checks.into_iter().find(|(wrong, ..)| *wrong).map(|(_, why, remedy)| remedy![why, "; ", remedy]);
        let size = || {
            let (problem, help) = options.preset?.size_problem(options.size?)?;
            Some(match help.split_once("`size`") {
                Some((before, after)) => {
                    remedy![format!("{problem}; {before}"), Setting::Size, after.to_owned()]
                }
                None => format!("{problem}; {help}").into(),
            })
        };
        wrong.or_else(size)
    }

    /// What only the content of the file can tell.
    pub(super) fn check(&self, raster: &Raster) -> Result<(), ExportError> {
        let input = self.input.display();
        let read = &self.options.read;
        if (read.low_m.is_some() || read.high_m.is_some()) && raster.numbers != Numbers::Scaled {
            let message = "holds values as they are, which have no scale; leave out ";
            return Err(ExportError::input(remedy![format!("`{input}` {message}"), Setting::InputRange]));
        }
        if self.options.cell_m.is_some() && raster.georeference.is_some() {
            let message = "says where it lies, and so how large its cells are; leave out ";
            return Err(ExportError::input(remedy![format!("`{input}` {message}"), Setting::Cell]));
        }
        let folder_of_several = self.to == Output::Preset(Preset::Gis);
        if folder_of_several && (raster.name.starts_with('.') || raster.name.contains(['/', '\\', '\0'])) {
            let name = &raster.name;
            return Err(ExportError::input(format!(
                "`{input}` has a layer {name:?}, which cannot name a file; rename it"
            )));
        }
        Ok(())
    }
}
