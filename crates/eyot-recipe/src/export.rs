//! What follows from an export's keys alone: its files, the layers that it takes, and whether it can be streamed.

use crate::diagnostic::alternatives;
use crate::keys::{Export, ExportFormat, Preset, What};
use std::collections::BTreeMap;

/// Layers that only exports know: the shares of the ground, in the order of red, green, blue and alpha.
pub const MATERIALS: [&str; 4] = ["grass", "rock", "sand", "snow"];

/// The classes of the ground that exports know, finer than [`MATERIALS`].
pub const GROUND: [&str; 16] = [
    "deep_sea",
    "sea_floor",
    "weed",
    "reef",
    "wet_sand",
    "beach",
    "mud",
    "lush_grass",
    "dry_grass",
    "shrub",
    "forest",
    "gravel",
    "scree",
    "bare_rock",
    "soil",
    "snow_cover",
];

/// The masks of presets that are no materials, in the order of their files. All but `wetness`, which is a layer of its own, are known to
/// exports alone: `flow` and `shore` of any land, `river` where there is `water`, `wear` and `deposit` where there is [`GROUND_BEFORE`].
pub const MASKS: [&str; 6] = ["flow", "wear", "deposit", "river", "wetness", "shore"];

/// The bed whose top a layer of an export is, counted from 1: of `bed_1_top` to `bed_13_top`, which exports make where there are `strata`.
pub fn bed_of_top(layer: &str) -> Option<usize> {
    let number = layer.strip_prefix("bed_")?.strip_suffix("_top")?;
    number.parse().ok().filter(|n: &usize| (1..=13).contains(n) && n.to_string() == number)
}

/// The layer that keeps the ground before it was eroded.
pub const GROUND_BEFORE: &str = "ground_before";

/// Vertices along a side of landscapes that Unreal Engine makes of whole components.
const UNREAL: [usize; 5] = [505, 1009, 2017, 4033, 8129];
/// Vertices along a side of Unity's terrains.
const UNITY: [usize; 8] = [33, 65, 129, 257, 513, 1025, 2049, 4097];

/// Texts that `format` could be in earlier versions, when it said what a file holds as well, and the lines that say the same now.
const FORMER: [(&str, &str); 9] = [
    ("mask", "what = \"mask\""),
    ("splat", "what = \"splat\""),
    ("map", "what = \"map\""),
    ("census", "what = \"census\""),
    ("plots", "what = \"plots\""),
    ("corals", "what = \"corals\""),
    ("coralsobj", "what = \"corals\"\nformat = \"obj\""),
    ("coralsply", "what = \"corals\"\nformat = \"ply\""),
    ("dive", "what = \"dive\""),
];

/// [`FORMER`] for the schema, where the check of keys finds it.
pub(crate) fn former_formats() -> BTreeMap<&'static str, &'static str> {
    FORMER.into_iter().collect()
}

impl Export {
    /// Keys that belong to one thing alone: whether this export shows it, and if not, to what the key belongs.
    pub(crate) fn narrow_keys(&self) -> [(&'static str, bool, &'static str); 5] {
        let terrain = self.shows() == What::Terrain;
        let glb = self.preset.is_none() && terrain && self.formats().first() == Some(&ExportFormat::Glb);
        let mesh = (terrain && self.preset.is_none()) || self.preset == Some(Preset::Blender);
        [
            ("tiles", glb, "a terrain as `glb`"),
            ("skirt", glb && self.tiles != [1, 1], "a terrain in `tiles`"),
            ("water", mesh, "a terrain"),
            ("vertices", mesh, "a terrain"),
            ("interval", self.preset.is_none() && self.shows() == What::Contours, "`contours`"),
        ]
    }

    /// What it shows: as the key says, or what its format is for.
    pub fn shows(&self) -> What {
        match (&self.what, self.format) {
            (Some(what), _) => what.clone(),
            (None, Some(format)) => format.shows().unwrap_or(What::Layers),
            (None, None) => What::Layers,
        }
    }

    /// How it is written: as the key says, or what is usual for what it shows; `plots` without a format are written in all of theirs.
    pub fn formats(&self) -> Vec<ExportFormat> {
        match (self.format, self.shows()) {
            (Some(format), _) => vec![format],
            (None, What::Plots) => What::Plots.formats().to_vec(),
            (None, what) => vec![what.formats()[0]],
        }
    }

    /// False for exports that always show the height, or no layers.
    pub fn uses_layers(&self) -> bool {
        match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => matches!(self.shows(), What::Layers | What::Mask | What::Map),
        }
    }

    /// True for layers that only exports know: the shares of materials and of classes of the ground, masks, and tops of beds.
    pub fn knows(&self, layer: &str) -> bool {
        let takes = match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => matches!(self.shows(), What::Layers | What::Mask),
        };
        let mask = MASKS.contains(&layer) && layer != "wetness";
        takes && (MATERIALS.contains(&layer) || GROUND.contains(&layer) || mask || bed_of_top(layer).is_some())
    }

    /// True for exports that make triangles or vertices of cells.
    pub fn needs_two_cells(&self) -> bool {
        match self.preset {
            Some(preset) => preset != Preset::Gis,
            None => self.shows() == What::Terrain,
        }
    }

    /// True if its files can be written while the world is made, one band of rows after the other.
    pub fn streams(&self) -> bool {
        let whole = |l: &String| MASKS.contains(&l.as_str()) || bed_of_top(l).is_some();
        if self.uses_layers() && self.layers.iter().any(|l| self.knows(l) && whole(l)) {
            // These follow from the whole of the land, or from what only whole worlds keep.
            return false;
        }
        match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => matches!(self.shows(), What::Layers | What::Splat | What::Mask | What::Map),
        }
    }

    /// The names of the files that it writes, without the descriptions beside them.
    pub fn files(&self) -> Vec<String> {
        let p = &self.prefix;
        let each = |ending: &str| self.layers.iter().map(|l| format!("{p}{l}{ending}")).collect();
        if let Some(preset) = self.preset {
            return match preset {
                Preset::Gis => each(".tif"),
                other => other.files(p),
            };
        }
        let formats = self.formats();
        let all = |names: &[&str]| {
            formats.iter().flat_map(|f| names.iter().map(move |n| format!("{p}{n}.{}", f.extension()))).collect()
        };
        match (self.shows(), formats[0]) {
            (What::Layers, ExportFormat::Zarr) => all(&["world"]),
            (What::Layers, ExportFormat::Exr) if self.layers.len() > 1 => all(&["layers"]),
            (What::Layers, format) => each(&format!(".{}", format.extension())),
            (What::Mask, _) => each("_mask.png"),
            (What::Map, _) => each("_map.png"),
            (What::Terrain, _) if self.tiles != [1, 1] => self.tile_files("terrain"),
            (What::Terrain, _) => all(&["terrain"]),
            (What::Splat, _) => all(&["splat"]),
            (What::Census, _) => all(&["census"]),
            (What::Plots, _) => all(&["cover", "plot"]),
            (What::Corals, _) => all(&["corals"]),
            (What::Dive, _) => all(&["dive", "side", "above"]),
            (What::Contours, _) => all(&["contours"]),
            (What::View(name), _) => all(&[&name]),
        }
    }

    /// The name of the file of one of the [`MASKS`] of a preset.
    pub fn mask_file(&self, mask: &str) -> String {
        format!("{}{}_{mask}.png", self.prefix, self.preset.map_or("", Preset::name))
    }

    /// The names of the tiles of a terrain, row by row from the north-west, and of the list of them.
    ///
    /// Numbers of columns and rows follow the name as Unreal Engine looks for them in the names of tiles that it imports: `_x0_y0`.
    pub fn tile_files(&self, name: &str) -> Vec<String> {
        let (p, [nx, ny]) = (&self.prefix, self.tiles);
        let tile = |(x, y)| format!("{p}{name}_x{x}_y{y}.glb");
        let all = (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y)));
        all.map(tile).chain([format!("{p}{name}.json")]).collect()
    }

    /// What is wrong with `what` and `format` together, and what would be right.
    pub fn format_problem(&self) -> Option<(String, String)> {
        let format = self.format?;
        let quoted = |formats: &[ExportFormat]| alternatives(formats.iter().map(|f| f.name()));
        let Some(what) = &self.what else {
            if format.shows().is_some() {
                return None;
            }
            let message = format!("`format = \"{}\"` does not say what the file holds", format.name());
            let which = What::ALL.into_iter().filter(|w| w.formats().contains(&format));
            let names: Vec<String> = which.map(|w| w.name().to_owned()).collect();
            let help = match format {
                // Until there was `what`, this was the census.
                ExportFormat::Parquet => "write\nwhat = \"census\"\nformat = \"parquet\"".to_owned(),
                _ => format!("add `what`: it may be {}", alternatives(names.iter().map(String::as_str))),
            };
            return Some((message, help));
        };
        let formats = what.formats();
        let message = format!("`what = \"{}\"` is not written as `{}`", what.name(), format.name());
        (!formats.contains(&format)).then(|| (message, format!("it is written as {}", quoted(formats))))
    }
}

impl What {
    /// What needs no name of a table, of points or of lines.
    pub const ALL: [Self; 10] = [
        Self::Layers,
        Self::Terrain,
        Self::Splat,
        Self::Mask,
        Self::Map,
        Self::Census,
        Self::Plots,
        Self::Corals,
        Self::Dive,
        Self::Contours,
    ];

    /// Name in recipes.
    pub fn name(&self) -> &str {
        match self {
            Self::Layers => "layers",
            Self::Terrain => "terrain",
            Self::Splat => "splat",
            Self::Mask => "mask",
            Self::Map => "map",
            Self::Census => "census",
            Self::Plots => "plots",
            Self::Corals => "corals",
            Self::Dive => "dive",
            Self::Contours => "contours",
            Self::View(name) => name,
        }
    }

    /// How it can be written, the usual format first.
    pub fn formats(&self) -> &'static [ExportFormat] {
        use ExportFormat::{
            Csv, Exr, FlatGeobuf, GeoJson, GeoPackage, GeoTiff, Glb, Npy, Obj, Parquet, Ply, Png, Png16, R16, R32, Svg,
            Zarr,
        };
        match self {
            Self::Layers => &[GeoTiff, Png16, R16, R32, Exr, Npy, Zarr],
            Self::Terrain => &[Glb, Obj],
            Self::Splat | Self::Mask | Self::Map | Self::Dive => &[Png],
            Self::Census => &[Csv, Parquet],
            Self::View(_) => &[Csv, Parquet, GeoJson, FlatGeobuf, GeoPackage],
            Self::Contours => &[GeoJson, FlatGeobuf, GeoPackage],
            Self::Plots => &[Svg, Png],
            Self::Corals => &[Glb, Obj, Ply],
        }
    }

    /// True for what `corals` leaves beside layers.
    pub fn is_of_corals(&self) -> bool {
        matches!(self, Self::Census | Self::Plots | Self::Corals | Self::Dive)
    }
}

impl ExportFormat {
    /// All formats.
    pub const ALL: [Self; 17] = [
        Self::GeoTiff,
        Self::Png16,
        Self::R16,
        Self::R32,
        Self::Exr,
        Self::Npy,
        Self::Zarr,
        Self::Glb,
        Self::Obj,
        Self::Ply,
        Self::Csv,
        Self::Parquet,
        Self::GeoJson,
        Self::FlatGeobuf,
        Self::GeoPackage,
        Self::Png,
        Self::Svg,
    ];

    /// What an export of this format shows that does not say it; `None` where it has to.
    pub fn shows(self) -> Option<What> {
        match self {
            Self::GeoTiff | Self::Png16 | Self::R16 | Self::R32 | Self::Exr | Self::Npy | Self::Zarr => {
                Some(What::Layers)
            }
            Self::Glb | Self::Obj => Some(What::Terrain),
            Self::Ply => Some(What::Corals),
            Self::Svg => Some(What::Plots),
            Self::Csv | Self::Parquet | Self::Png | Self::GeoJson | Self::FlatGeobuf | Self::GeoPackage => None,
        }
    }

    /// Name in recipes.
    pub fn name(self) -> &'static str {
        match self {
            Self::GeoTiff => "geotiff",
            Self::Png16 => "png16",
            Self::FlatGeobuf => "flatgeobuf",
            Self::GeoPackage => "geopackage",
            other => other.extension(),
        }
    }

    /// The extension of its files without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::GeoTiff => "tif",
            Self::Png16 | Self::Png => "png",
            Self::R16 => "r16",
            Self::R32 => "r32",
            Self::Exr => "exr",
            Self::Npy => "npy",
            Self::Zarr => "zarr",
            Self::Glb => "glb",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            Self::GeoJson => "geojson",
            Self::FlatGeobuf => "fgb",
            Self::GeoPackage => "gpkg",
            Self::Svg => "svg",
        }
    }
}

impl Preset {
    /// Name in recipes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreal => "unreal",
            Self::Unity => "unity",
            Self::Godot => "godot",
            Self::Blender => "blender",
            Self::Gis => "gis",
        }
    }

    /// The preset of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Unreal, Self::Unity, Self::Godot, Self::Blender, Self::Gis].into_iter().find(|p| p.name() == name)
    }

    /// Vertices along a side that the program accepts; empty if it accepts all.
    pub fn sizes(self) -> &'static [usize] {
        match self {
            Self::Unreal => &UNREAL,
            Self::Unity => &UNITY,
            _ => &[],
        }
    }

    /// The names of its files; `gis` names them like the layers and has none here.
    pub fn files(self, prefix: &str) -> Vec<String> {
        let (p, n) = (prefix, self.name());
        let mut files: Vec<String> = match self {
            Self::Gis => return Vec::new(),
            Self::Unreal => vec![format!("{p}{n}_height.png"), format!("{p}{n}_height.r16")],
            Self::Unity => vec![format!("{p}{n}_height.raw"), format!("{p}{n}_splat.png")],
            Self::Godot => vec![format!("{p}{n}_height.exr"), format!("{p}{n}_splat.png")],
            Self::Blender => vec![format!("{p}{n}_terrain.glb"), format!("{p}{n}_height.exr")],
        };
        if matches!(self, Self::Unreal | Self::Blender) {
            files.extend(MATERIALS.map(|m| format!("{p}{n}_{m}.png")));
        }
        files.extend(MASKS.map(|m| format!("{p}{n}_{m}.png")));
        // What says how to use the others comes last.
        files.push(format!("{p}{n}.json"));
        files
    }

    /// What is wrong with a size, and what would be right.
    pub fn size_problem(self, size: u32) -> Option<(String, String)> {
        let (sizes, name) = (self.sizes(), self.name());
        if sizes.contains(&(size as usize)) {
            return None;
        }
        if sizes.is_empty() {
            return Some((format!("the preset `{name}` keeps the size of the grid"), "leave `size` out".to_owned()));
        }
        let list: Vec<String> = sizes.iter().map(usize::to_string).collect();
        Some((format!("{size} is no size for the preset `{name}`"), format!("choose {}", list.join(", "))))
    }

    /// A prefix for its files that no other export uses: `gis` writes files that are named like layers.
    pub fn free_prefix(self, others: &[Export]) -> String {
        let mut export = Export { preset: Some(self), ..Export::default() };
        let taken: Vec<String> = others.iter().filter(|e| e.enabled).flat_map(Export::files).collect();
        while export.files().iter().any(|f| taken.contains(f)) {
            export.prefix = format!("{}_{}", self.name(), export.prefix);
        }
        export.prefix
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RecipeDoc;

    fn export(text: &str) -> Export {
        RecipeDoc::parse(&format!("[[export]]\n{text}")).unwrap_or_else(|p| panic!("{text}: {p}")).exports.remove(0)
    }

    #[test]
    fn names_are_those_of_recipes() {
        for what in What::ALL {
            assert_eq!(export(&format!("what = '{}'", what.name())).what, Some(what));
        }
        for format in ExportFormat::ALL {
            assert_eq!(export(&format!("format = '{}'", format.name())).format, Some(format));
            assert!(What::ALL.iter().any(|w| w.formats().contains(&format)), "{format:?}");
            // What is left out must be something that this format can show.
            assert!(format.shows().is_none_or(|w| w.formats().contains(&format)), "{format:?}");
        }
        assert_eq!(export("what = 'corals.colonies'").what, Some(What::View("corals.colonies".into())));
    }

    #[test]
    fn files_have_the_names_that_they_always_had() {
        for (text, files) in [
            ("", "height.tif"),
            ("format = 'png16'", "height.png"),
            ("format = 'zarr'", "world.zarr"),
            ("format = 'exr'\nlayers = ['a', 'b']", "layers.exr"),
            ("format = 'npy'\nlayers = ['a', 'b']", "a.npy b.npy"),
            ("format = 'glb'", "terrain.glb"),
            ("what = 'terrain'\nformat = 'obj'\nprefix = 'x_'", "x_terrain.obj"),
            ("format = 'glb'\ntiles = [2, 1]", "terrain_x0_y0.glb terrain_x1_y0.glb terrain.json"),
            ("what = 'mask'\nlayers = ['rock']", "rock_mask.png"),
            ("what = 'map'", "height_map.png"),
            ("what = 'splat'", "splat.png"),
            ("what = 'census'", "census.csv"),
            ("what = 'census'\nformat = 'parquet'", "census.parquet"),
            ("what = 'plots'", "cover.svg plot.svg cover.png plot.png"),
            ("format = 'svg'", "cover.svg plot.svg"),
            ("what = 'corals'", "corals.glb"),
            ("format = 'ply'", "corals.ply"),
            ("what = 'dive'", "dive.png side.png above.png"),
            ("what = 'contours'", "contours.geojson"),
            ("what = 'contours'\nformat = 'geopackage'", "contours.gpkg"),
            ("what = 'corals.algae'", "corals.algae.csv"),
            ("what = 'rivers'\nformat = 'flatgeobuf'", "rivers.fgb"),
        ] {
            assert_eq!(export(text).files().join(" "), files, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_written_so_is_told_with_what_can() {
        for what in What::ALL.into_iter().chain([What::View("a.b".into())]) {
            for format in ExportFormat::ALL {
                let export = Export { what: Some(what.clone()), format: Some(format), ..Export::default() };
                let fits = what.formats().contains(&format);
                assert_eq!(export.format_problem().is_none(), fits, "{what:?} {format:?}");
            }
        }
        let problem = |text: &str| export(text).format_problem().map(|(message, help)| format!("{message}; {help}"));
        let told = "`what = \"terrain\"` is not written as `r16`; it is written as `glb` or `obj`";
        assert_eq!(problem("what = 'terrain'\nformat = 'r16'").as_deref(), Some(told));
        let told = "`format = \"csv\"` does not say what the file holds; add `what`: it may be `census`";
        assert_eq!(problem("format = 'csv'").as_deref(), Some(told));
        assert!(problem("format = 'parquet'").unwrap().ends_with("write\nwhat = \"census\"\nformat = \"parquet\""));
    }

    #[test]
    fn former_formats_are_answered_with_lines_that_work() {
        for (former, lines) in FORMER {
            let told = RecipeDoc::parse(&format!("[[export]]\nformat = '{former}'")).unwrap_err();
            assert_eq!(told.diagnostics.len(), 1, "{told}");
            let help = told.diagnostics[0].help.as_ref().unwrap().to_string();
            assert_eq!(help, format!("write\n{lines}"));
            assert!(export(lines).format_problem().is_none(), "{lines}");
        }
    }
}
