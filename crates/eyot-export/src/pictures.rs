//! Pictures of a world: views, reliefs and maps, in a recipe's words.

use crate::error::ExportError;
use crate::estimate;
use eyot_core::{Control, Limits, Result, World};
use eyot_recipe::{Palette, Season, View};
use std::path::Path;
use {eyot_io as io, eyot_render as render};

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject<'a> {
    /// The land as a camera sees it.
    View,
    /// The land from above, with shaded relief.
    Relief,
    /// As `Relief`, with so many pixels along the longer side.
    ReliefAt(u32),
    /// A map of one layer.
    Layer(&'a str),
    /// As `Layer`, with so many pixels along the longer side of the map.
    LayerAt(&'a str, u32),
}

/// Draws a world into a PNG file.
///
/// # Errors
/// If `path` has another extension than `.png`, the layer is not there, the picture exceeds the limits, or the file cannot be
/// written, which is found out first.
pub fn draw_file(
    world: &World,
    options: &View,
    subject: Subject<'_>,
    path: &Path,
    limits: &Limits,
) -> std::result::Result<(), ExportError> {
    check_picture_name(path)?;
    if let Subject::Layer(name) | Subject::LayerAt(name, _) = subject {
        world.layer(name).map_err(ExportError::input)?;
    }
    let picture = draw(world, options, subject, limits, &Control::none()).map_err(ExportError::file)?;
    io::write_rgb_png(path, picture.width, picture.height, &picture.pixels).map_err(ExportError::file)
}

/// Fails unless a PNG picture can be written to `path`.
///
/// # Errors
/// If its extension is another, or nothing can be written there.
pub fn check_picture_name(path: &Path) -> std::result::Result<(), ExportError> {
    if let Some(other) = path.extension().filter(|e| !e.eq_ignore_ascii_case("png")) {
        let reason = format!("`{}` would be a PNG picture that is called .{}", path.display(), other.display());
        return Err(ExportError::refused(reason, "give it a name that ends in .png"));
    }
    io::check_place(path).map_err(ExportError::file)
}

/// Draws a picture as the options say.
///
/// # Errors
/// If the layer is not there, there is not enough memory, or `control` says stop.
pub fn draw(
    world: &World,
    options: &View,
    subject: Subject<'_>,
    limits: &Limits,
    control: &Control<'_>,
) -> Result<render::Picture> {
    let bytes = estimate::picture(&world.grid, options, subject);
    estimate::check("this picture", world, bytes, limits, estimate::picture_remedy())?;
    match subject {
        Subject::View => render::perspective_controlled(world, &view_options(options), control),
        Subject::Relief => render::relief_controlled(world, &relief_options(options, None), control),
        Subject::ReliefAt(n) => render::relief_controlled(world, &relief_options(options, Some(n)), control),
        Subject::Layer(name) => render::layer_map(world, name, &map_of(world, name, None)),
        Subject::LayerAt(name, n) => render::layer_map(world, name, &map_of(world, name, Some(n))),
    }
}

/// How a layer is mapped: classes by their names and colours, wind with arrows; with so many pixels along the longer side, if that is given.
pub fn map_options(layer: &str, size: Option<u32>) -> render::MapOptions {
    let arrows = ["wind_x", "wind_y"];
    render::MapOptions {
        classes: eyot_climate::zones::classes(layer)
            .or_else(|| eyot_strata::classes(layer))
            .or_else(|| eyot_plants::classes(layer))
            .map(<[_]>::to_vec),
        arrows: arrows.contains(&layer).then_some(arrows),
        size: size.map(|n| n as usize),
        ..Default::default()
    }
}

/// As [`map_options`] for a layer of this world: materials have the names that the world itself knows.
pub fn map_of(world: &World, layer: &str, size: Option<u32>) -> render::MapOptions {
    let o = map_options(layer, size);
    render::MapOptions { classes: eyot_strata::classes_of(world, layer).or(o.classes), ..o }
}

/// The ground's looks as the view of a recipe has them.
pub fn looks(v: &View) -> render::Looks {
    let palette = match v.palette {
        Palette::Temperate => render::Palette::Temperate,
        Palette::Tropical => render::Palette::Tropical,
        Palette::Alpine => render::Palette::Alpine,
        Palette::Desert => render::Palette::Desert,
        Palette::Arctic => render::Palette::Arctic,
        Palette::Volcanic => render::Palette::Volcanic,
        _ => render::Palette::Auto,
    };
    let season = match v.season {
        Season::Spring => render::Season::Spring,
        Season::Summer => render::Season::Summer,
        Season::Autumn => render::Season::Autumn,
        Season::Winter => render::Season::Winter,
    };
    let mut ramp: Vec<(f32, [f32; 3])> = v.ramp.iter().map(|s| (s.height, render::linear(s.colour.0))).collect();
    ramp.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The classes of the map are the colours of the ground.
    let kinds = eyot_strata::classes(&eyot_strata::MATERIAL.name).unwrap_or_default();
    let rocks = kinds.iter().map(|c| render::linear(c.colour)).collect();
    let (snow_line_m, tree_line_m) = (v.snow_line, v.tree_line);
    render::Looks { palette, ramp, snow_line_m, tree_line_m, season, rocks, ..Default::default() }
}

/// What the view of a recipe is to the camera.
pub fn view_options(v: &View) -> render::ViewOptions {
    let d = render::ViewOptions::default();
    render::ViewOptions {
        width: v.size[0] as usize,
        height: v.size[1] as usize,
        azimuth_deg: v.azimuth.unwrap_or(d.azimuth_deg),
        elevation_deg: v.elevation.or(d.elevation_deg),
        distance: v.distance.or(d.distance),
        field_of_view_deg: v.field_of_view.unwrap_or(d.field_of_view_deg),
        vertical_exaggeration: v.vertical_exaggeration.unwrap_or(d.vertical_exaggeration),
        sun_azimuth_deg: v.sun_azimuth.unwrap_or(d.sun_azimuth_deg),
        sun_elevation_deg: v.sun_elevation.unwrap_or(d.sun_elevation_deg),
        looks: looks(v),
        ..d
    }
}

/// What the view of a recipe is to a relief: its longer side bounds the relief's, unless that is given.
pub fn relief_options(v: &View, size: Option<u32>) -> render::ReliefOptions {
    let d = render::ReliefOptions::default();
    render::ReliefOptions {
        vertical_exaggeration: v.vertical_exaggeration.or(d.vertical_exaggeration),
        max_size: v.size[0].max(v.size[1]) as usize,
        size: size.map(|n| n as usize),
        sun_azimuth_deg: v.sun_azimuth.unwrap_or(d.sun_azimuth_deg),
        sun_elevation_deg: v.sun_elevation.unwrap_or(d.sun_elevation_deg),
        looks: looks(v),
        ..d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    /// The names of a choice of a recipe's view, each with its text, out of the schema that is made of the enumeration.
    fn choices(name: &str) -> Vec<(String, String)> {
        let schema = schemars::schema_for!(View).to_value();
        let all = schema["$defs"][name]["oneOf"].as_array().cloned().unwrap_or_default();
        let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
        all.iter().map(|c| (text(&c["const"]), text(&c["description"]))).collect()
    }

    #[test]
    fn recipes_and_pictures_have_the_same_palettes_and_seasons() {
        let (palettes, seasons) = (choices("Palette"), choices("Season"));
        assert!(palettes.len() == 7 && seasons.len() == 4, "{palettes:?} {seasons:?}");
        for (name, text) in palettes {
            let palette: Palette = serde_json::from_value(Value::from(name.clone())).unwrap();
            let drawn = looks(&View { palette, ..View::default() }).palette;
            assert_eq!(format!("{drawn:?}").to_lowercase(), name);
            if drawn != render::Palette::Auto {
                let [trees, snow] = drawn.lines_m();
                assert!(
                    text.ends_with(&format!("; trees to {trees} m, snow from {snow} m.")),
                    "{name}: {text}, {trees} {snow}"
                );
            }
        }
        for (name, _) in seasons {
            let season: Season = serde_json::from_value(Value::from(name.clone())).unwrap();
            let drawn = looks(&View { season, ..View::default() }).season;
            assert_eq!(format!("{drawn:?}").to_lowercase(), name);
        }
    }
}
