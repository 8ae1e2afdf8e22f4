//! What follows from an export's keys alone: its files, the layers that it takes, and whether it can be streamed.

use crate::keys::{Export, ExportFormat, Preset};

/// Layers that only exports know: the shares of the ground, in the order of red, green, blue and alpha.
pub const MATERIALS: [&str; 4] = ["grass", "rock", "sand", "snow"];

/// Vertices along a side of landscapes that Unreal Engine makes of whole components.
const UNREAL: [usize; 5] = [505, 1009, 2017, 4033, 8129];
/// Vertices along a side of Unity's terrains.
const UNITY: [usize; 8] = [33, 65, 129, 257, 513, 1025, 2049, 4097];

impl Export {
    /// False for exports that always show the height.
    pub fn uses_layers(&self) -> bool {
        match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => {
                !self.format.is_of_corals()
                    && !matches!(self.format, ExportFormat::Glb | ExportFormat::Obj | ExportFormat::Splat)
            }
        }
    }

    /// True for layers that only exports know: the shares of materials.
    pub fn knows(&self, layer: &str) -> bool {
        let takes = match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => self.format != ExportFormat::Map,
        };
        takes && MATERIALS.contains(&layer)
    }

    /// True for exports that make triangles or vertices of cells.
    pub fn needs_two_cells(&self) -> bool {
        match self.preset {
            Some(preset) => preset != Preset::Gis,
            None => matches!(self.format, ExportFormat::Glb | ExportFormat::Obj),
        }
    }

    /// True if its files can be written while the world is made, one band of rows after the other.
    pub fn streams(&self) -> bool {
        match self.preset {
            Some(preset) => preset == Preset::Gis,
            None => !self.format.is_of_corals() && !matches!(self.format, ExportFormat::Glb | ExportFormat::Obj),
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
        match (self.format, self.format.extension()) {
            (ExportFormat::Zarr, _) => vec![format!("{p}world.zarr")],
            (ExportFormat::Exr, _) if self.layers.len() > 1 => vec![format!("{p}layers.exr")],
            (_, Some(extension)) => each(&format!(".{extension}")),
            (ExportFormat::Glb, _) => vec![format!("{p}terrain.glb")],
            (ExportFormat::Obj, _) => vec![format!("{p}terrain.obj")],
            (ExportFormat::Splat, _) => vec![format!("{p}splat.png")],
            (ExportFormat::Mask, _) => each("_mask.png"),
            (ExportFormat::Census, _) => vec![format!("{p}census.csv")],
            (ExportFormat::Parquet, _) => vec![format!("{p}census.parquet")],
            (ExportFormat::Plots, _) => {
                ["cover.svg", "plot.svg", "cover.png", "plot.png"].map(|n| format!("{p}{n}")).to_vec()
            }
            (ExportFormat::Corals, _) => vec![format!("{p}corals.glb")],
            (ExportFormat::CoralsObj, _) => vec![format!("{p}corals.obj")],
            (ExportFormat::CoralsPly, _) => vec![format!("{p}corals.ply")],
            (ExportFormat::Dive, _) => ["dive", "side", "above"].map(|n| format!("{p}{n}.png")).to_vec(),
            _ => each("_map.png"),
        }
    }
}

impl ExportFormat {
    /// True for what `corals` leaves beside layers.
    pub fn is_of_corals(self) -> bool {
        use ExportFormat::{Census, Corals, CoralsObj, CoralsPly, Dive, Parquet, Plots};
        matches!(self, Census | Parquet | Plots | Corals | CoralsObj | CoralsPly | Dive)
    }

    /// The extension of its files without the dot, if it writes values of layers as a raster.
    pub fn extension(self) -> Option<&'static str> {
        Some(match self {
            Self::Png16 => "png",
            Self::GeoTiff => "tif",
            Self::R32 => "r32",
            Self::R16 => "r16",
            Self::Exr => "exr",
            Self::Npy => "npy",
            Self::Zarr => "zarr",
            _ => return None,
        })
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
