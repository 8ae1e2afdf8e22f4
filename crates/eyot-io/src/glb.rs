//! Binary glTF 2.0 (GLB), out: a terrain with its levels of detail, or a scene of bodies.

use crate::atomic::put;
use crate::error::{Error, Result};
use crate::scene::{Scene, SceneNode};
use crate::target::Target;
use eyot_mesh::{Lod, TerrainMesh};
use serde_json::{Value, json};

mod instances;

pub use instances::{Instances, write_instances_glb};

// Numbers of the glTF specification.
const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Share of the screen's height below which the next coarser level is enough, for levels 0, 1, 2, ... (each level has
/// about a quarter of the triangles, so it serves half the height).
const FIRST_SCREEN_COVERAGE: f64 = 0.5;

/// What a file of a terrain holds.
#[derive(Clone, Copy, Debug, Default)]
pub struct TerrainParts<'a> {
    /// The ground, finest first, as [`eyot_mesh::levels_of_detail`] makes it.
    pub levels: &'a [Lod],
    /// A skirt for each level, or none at all; see [`eyot_mesh::Tiling::skirt`].
    pub skirts: &'a [TerrainMesh],
    /// The surface of the water.
    pub water: Option<&'a TerrainMesh>,
    /// What the ground is called.
    pub name: &'a str,
}

impl TerrainParts<'_> {
    fn sound(&self) -> bool {
        let whole = |m: &TerrainMesh| !m.indices.is_empty() && consistent(m);
        !self.levels.is_empty()
            && self.levels.iter().all(|l| whole(&l.mesh))
            && (self.skirts.is_empty() || self.skirts.len() == self.levels.len())
            && self.skirts.iter().all(consistent)
            && self.water.is_none_or(whole)
    }
}

/// Writes a terrain as GLB, y up, in metres, with texture coordinates, vertex colours and one rough material.
///
/// The scene shows level 0; the others hang on its node by the extension `MSFT_lod`, so that viewers that do not know it
/// show level 0 alone. Colours are linear, as glTF wants them. A skirt is the second primitive of its level's mesh. Water is
/// a node of its own with a clear material. An attribute `rock` of the mesh becomes the custom attribute `_ROCK`.
///
/// # Errors
/// If there is no level or one without triangles, if the file would exceed 4 GiB (the format's bound), or if it cannot
/// be written.
pub fn write_terrain_glb<'a>(to: impl Into<Target<'a>>, parts: &TerrainParts<'_>) -> Result<()> {
    let to = to.into();
    if !parts.sound() {
        let remedy = "make the levels with eyot_mesh::levels_of_detail";
        return Err(Error::format(to.place(), "a terrain needs at least one level, each with triangles", remedy));
    }
    let (levels, name) = (parts.levels, parts.name);
    let mut document = Document::default();
    let mut materials = vec![material("ground", [1.0; 3])];
    levels.iter().enumerate().for_each(|(i, level)| document.add_level(level, parts.skirts.get(i), i, name));
    let mut scene = vec![0];
    if let Some(water) = parts.water {
        let attributes = document.attributes(&water.positions, &water.normals, &[], &water.texture);
        let extras = json!({"triangles": water.triangles()});
        document.add_mesh("water", attributes, &water.indices, materials.len(), extras);
        materials.push(water_material());
        scene.push(document.nodes.len());
        document.nodes.push(json!({"name": "water", "mesh": document.meshes.len() - 1}));
    }
    document.root["scenes"] = json!([{"nodes": scene}]);
    document.root["materials"] = materials.into();
    if levels.len() > 1 {
        let last = levels.len() as i32 - 1;
        let coverage = |i: i32| if i == last { 0.0 } else { FIRST_SCREEN_COVERAGE * 0.5f64.powi(i) };
        let coverage: Vec<f64> = (0..=last).map(coverage).collect();
        document.nodes[0]["extensions"] = json!({"MSFT_lod": {"ids": (1..levels.len()).collect::<Vec<_>>()}});
        document.nodes[0]["extras"] = json!({"MSFT_screencoverage": coverage});
        document.root["extensionsUsed"] = json!(["MSFT_lod"]);
    }
    document.write(&to, "lower max_vertices or write fewer levels")
}

/// Writes bodies as GLB: a mesh for each, nodes that show them at their places, names, materials, vertex colours and, where there
/// are some, texture coordinates. Several nodes may show the same mesh.
///
/// # Errors
/// If the scene contradicts itself, if the file would exceed 4 GiB (the format's bound), or if it cannot be written.
pub fn write_scene_glb<'a>(to: impl Into<Target<'a>>, scene: &Scene<'_>) -> Result<()> {
    let to = to.into();
    scene.check(to.place())?;
    let mut document = Document::default();
    for mesh in &scene.meshes {
        let mut attributes = document.attributes(mesh.positions, mesh.normals, mesh.colours, &[]);
        if !mesh.texture.is_empty() {
            let pair = json!({"componentType": FLOAT, "count": mesh.texture.len(), "type": "VEC2"});
            attributes["TEXCOORD_0"] = json!(document.accessor(ARRAY_BUFFER, Data::Pairs(mesh.texture), pair));
        }
        document.add_mesh(mesh.name, attributes, mesh.indices, mesh.material, json!({}));
    }
    document.nodes.extend(scene.nodes.iter().map(node));
    let all: Vec<usize> = (0..scene.nodes.len()).collect();
    document.root["scenes"] = json!([{"name": scene.name, "nodes": all, "extras": {"kind": "bodies"}}]);
    document.root["materials"] = scene.materials.iter().map(|m| material(m.name, m.colour)).collect();
    document.write(&to, "write fewer bodies or choose longer voxels")
}

fn material(name: &str, [r, g, b]: [f32; 3]) -> Value {
    let surface = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0});
    json!({"name": name, "pbrMetallicRoughness": surface})
}

/// Water that lets half of the ground through; what is below its surface is drawn by the ground.
fn water_material() -> Value {
    json!({
        "name": "water",
        "pbrMetallicRoughness": {"baseColorFactor": [0.012, 0.075, 0.105, 0.72], "metallicFactor": 0.0, "roughnessFactor": 0.08},
        "alphaMode": "BLEND",
    })
}

fn node(n: &SceneNode) -> Value {
    let mut node = json!({"name": n.name, "mesh": n.mesh, "translation": n.place});
    if n.turn != 0.0 {
        let (sin, cos) = (0.5 * n.turn).sin_cos();
        node["rotation"] = json!([0.0, sin, 0.0, cos]);
    }
    if n.size != 1.0 {
        node["scale"] = json!([n.size, n.size, n.size]);
    }
    if !n.extras.is_null() {
        node["extras"] = n.extras.clone();
    }
    node
}

fn consistent(m: &TerrainMesh) -> bool {
    let n = m.positions.len();
    m.normals.len() == n
        && (m.colours.len() == n || m.colours.is_empty())
        && m.texture.len() == n
        && m.attributes.iter().all(|a| a.values.len() == n)
        && m.indices.len().is_multiple_of(3)
        && m.indices.iter().all(|&i| (i as usize) < n)
}

/// What a view of the binary part holds; all begin at multiples of 4 bytes.
#[derive(Clone, Copy)]
enum Data<'a> {
    Vectors(&'a [[f32; 3]]),
    Pairs(&'a [[f32; 2]]),
    Fours(&'a [[f32; 4]]),
    Colours(&'a [[u8; 4]]),
    Scalars(&'a [f32]),
    /// Shares of 65535.
    Shares(&'a [[u16; 2]]),
    Indices(&'a [u32]),
    /// Indices below 65535, in two bytes each: the number that these cannot say ends strips of triangles.
    Short(&'a [u32]),
}

impl Data<'_> {
    fn bytes(self) -> usize {
        match self {
            Self::Vectors(v) => size_of_val(v),
            Self::Pairs(v) => size_of_val(v),
            Self::Fours(v) => size_of_val(v),
            Self::Colours(v) => size_of_val(v),
            Self::Scalars(v) => size_of_val(v),
            Self::Shares(v) => size_of_val(v),
            Self::Indices(v) => size_of_val(v),
            Self::Short(v) => 2 * v.len(),
        }
    }

    /// Hands the bytes on, part by part.
    fn write(self, mut put: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
        const PART: usize = 1 << 16;
        let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        match self {
            Self::Vectors(v) => v.chunks(PART).try_for_each(|part| put(&floats(part.as_flattened()))),
            Self::Fours(v) => v.chunks(PART).try_for_each(|part| put(&floats(part.as_flattened()))),
            Self::Pairs(v) => v.chunks(PART).try_for_each(|part| put(&floats(part.as_flattened()))),
            Self::Scalars(v) => v.chunks(PART).try_for_each(|part| put(&floats(part))),
            Self::Colours(v) => put(v.as_flattened()),
            Self::Shares(v) => v.chunks(PART).try_for_each(|part| {
                put(&part.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
            }),
            Self::Short(v) => {
                let bytes = |part: &[u32]| part.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect::<Vec<u8>>();
                v.chunks(PART).try_for_each(|part| put(&bytes(part)))?;
                put(&[0; 3][..self.bytes().next_multiple_of(4) - self.bytes()])
            }
            Self::Indices(v) => {
                let bytes = |part: &[u32]| part.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>();
                v.chunks(PART).try_for_each(|part| put(&bytes(part)))
            }
        }
    }
}

/// A file while it grows.
struct Document<'a> {
    /// What is written of its own: scenes, materials, extensions.
    root: Value,
    accessors: Vec<Value>,
    views: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    /// What the views hold.
    data: Vec<Data<'a>>,
    /// Bytes of the binary part so far.
    offset: u64,
}

impl Default for Document<'_> {
    fn default() -> Self {
        let root = json!({"asset": {"version": "2.0", "generator": "Eyot"}, "scene": 0});
        Self { root, accessors: vec![], views: vec![], meshes: vec![], nodes: vec![], data: vec![], offset: 0 }
    }
}

impl<'a> Document<'a> {
    fn add_level(&mut self, level: &'a Lod, skirt: Option<&'a TerrainMesh>, index: usize, name: &str) {
        let m = &level.mesh;
        let mut attributes = self.attributes(&m.positions, &m.normals, &m.colours, &m.texture);
        for a in &m.attributes {
            // glTF wants an underscore before names of its users; Blender makes attributes of the mesh of them.
            let scalar = json!({"componentType": FLOAT, "count": a.values.len(), "type": "SCALAR"});
            let accessor = self.accessor(ARRAY_BUFFER, Data::Scalars(&a.values), scalar);
            attributes[format!("_{}", a.name.to_uppercase())] = json!(accessor);
        }
        let name = if index == 0 { name.to_owned() } else { format!("{name} level {index}") };
        let extras = json!({"triangles": m.triangles(), "error_m": level.error_m});
        self.add_mesh(&name, attributes, &m.indices, 0, extras);
        if let Some(s) = skirt.filter(|s| !s.indices.is_empty()) {
            let attributes = self.attributes(&s.positions, &s.normals, &s.colours, &s.texture);
            let mut primitive = self.primitive(attributes, &s.indices, 0);
            primitive["extras"] = json!({"part": "skirt"});
            if let Some(primitives) = self.meshes.last_mut().and_then(|m| m["primitives"].as_array_mut()) {
                primitives.push(primitive);
            }
        }
        self.nodes.push(json!({"name": name, "mesh": index}));
    }

    fn attributes(
        &mut self,
        positions: &'a [[f32; 3]],
        normals: &'a [[f32; 3]],
        colours: &'a [[u8; 4]],
        texture: &'a [[u16; 2]],
    ) -> Value {
        let n = positions.len();
        let (min, max) = bounds(positions);
        let place = json!({"componentType": FLOAT, "count": n, "type": "VEC3", "min": min, "max": max});
        let vector = json!({"componentType": FLOAT, "count": n, "type": "VEC3"});
        let colour = json!({"componentType": UNSIGNED_BYTE, "normalized": true, "count": n, "type": "VEC4"});
        let mut attributes = json!({
            "POSITION": self.accessor(ARRAY_BUFFER, Data::Vectors(positions), place),
            "NORMAL": self.accessor(ARRAY_BUFFER, Data::Vectors(normals), vector),
        });
        if !colours.is_empty() {
            attributes["COLOR_0"] = json!(self.accessor(ARRAY_BUFFER, Data::Colours(colours), colour));
        }
        if !texture.is_empty() {
            let pair = json!({"componentType": UNSIGNED_SHORT, "normalized": true, "count": n, "type": "VEC2"});
            attributes["TEXCOORD_0"] = json!(self.accessor(ARRAY_BUFFER, Data::Shares(texture), pair));
        }
        attributes
    }

    fn add_mesh(&mut self, name: &str, attributes: Value, indices: &'a [u32], material: usize, extras: Value) {
        let mut mesh = json!({"name": name, "primitives": [self.primitive(attributes, indices, material)]});
        if extras.as_object().is_some_and(|e| !e.is_empty()) {
            mesh["extras"] = extras;
        }
        self.meshes.push(mesh);
    }

    fn primitive(&mut self, attributes: Value, indices: &'a [u32], material: usize) -> Value {
        let short = indices.iter().all(|&i| i < 65_535);
        let (kind, data) =
            if short { (UNSIGNED_SHORT, Data::Short(indices)) } else { (UNSIGNED_INT, Data::Indices(indices)) };
        let accessor = json!({"componentType": kind, "count": indices.len(), "type": "SCALAR"});
        let indices = self.accessor(ELEMENT_ARRAY_BUFFER, data, accessor);
        json!({"attributes": attributes, "indices": indices, "material": material})
    }

    /// Adds a view of the data and an accessor over all of it, and returns the accessor's index.
    fn accessor(&mut self, target: u32, data: Data<'a>, mut accessor: Value) -> usize {
        let bytes = data.bytes();
        self.views.push(json!({"buffer": 0, "byteOffset": self.offset, "byteLength": bytes, "target": target}));
        self.data.push(data);
        self.offset += bytes.next_multiple_of(4) as u64;
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn write(mut self, to: &Target<'_>, remedy: &'static str) -> Result<()> {
        let path = to.place();
        self.root["nodes"] = self.nodes.into();
        self.root["meshes"] = self.meshes.into();
        self.root["accessors"] = self.accessors.into();
        self.root["bufferViews"] = self.views.into();
        self.root["buffers"] = json!([{"byteLength": self.offset}]);
        let mut text = self.root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() as u64 + 8 + self.offset;
        let too_large = || Error::format(path, format!("{total} bytes are needed, GLB holds at most 4 GiB"), remedy);
        let total = u32::try_from(total).map_err(|_| too_large())?;
        to.write(|file| {
            let word = |v: u32| v.to_le_bytes();
            put(file, path, &[*b"glTF", word(2), word(total), word(text.len() as u32), *b"JSON"].concat())?;
            put(file, path, &text)?;
            put(file, path, &[word(self.offset as u32), *b"BIN\0"].concat())?;
            self.data.iter().try_for_each(|data| data.write(|bytes| put(file, path, bytes)))
        })
    }
}

/// Smallest and largest coordinates. They are written with the digits of the `f32`, which validators compare exactly.
fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    positions.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
        (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Field, Grid, Limits};
    use eyot_mesh::{MeshOptions, levels_of_detail, terrain};

    fn levels(ratios: &[f64]) -> Vec<Lod> {
        let grid = Grid::new(40, 30, 10.0, Boundary::CLOSED, &Limits::default()).unwrap();
        let height = Field::from_fn(40, 30, |x, y| 20.0 * (x as f32 * 0.3).sin() + y as f32);
        let green = vec![[0.1, 0.6, 0.2]; 1200];
        let t = terrain(&height, &grid, &green, &MeshOptions::default(), &Limits::default()).unwrap();
        levels_of_detail(&t, ratios)
    }

    fn write(path: &std::path::Path, levels: &[Lod], name: &str) -> Result<()> {
        write_terrain_glb(path, &TerrainParts { levels, name, ..TerrainParts::default() })
    }

    #[test]
    fn the_chunks_add_up_and_only_level_0_is_in_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.glb");
        let levels = levels(&[0.5, 0.25]);
        assert_eq!(levels.len(), 3);
        write(&path, &levels, "Isle \"A\"").unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let word = |i: usize| u32::from_le_bytes(bytes[i..i + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let json_len = word(12);
        let document: Value = serde_json::from_slice(&bytes[20..20 + json_len]).unwrap();
        assert_eq!(word(20 + json_len) + 28 + json_len, bytes.len());
        assert_eq!(document["scenes"], json!([{"nodes": [0]}]));
        assert_eq!(document["nodes"][0]["extensions"]["MSFT_lod"]["ids"], json!([1, 2]));
        assert_eq!(document["nodes"][0]["extras"]["MSFT_screencoverage"].as_array().unwrap().len(), 3);
        assert_eq!(document["extensionsUsed"], json!(["MSFT_lod"]));
        // First position, as bytes.
        let start = 28 + json_len;
        assert_eq!(bytes[start..start + 4], levels[0].mesh.positions[0][0].to_le_bytes());
    }

    #[test]
    fn one_level_needs_no_extension_and_none_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.glb");
        write(&path, &levels(&[]), "t").unwrap();
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        assert!(!text.contains("MSFT_lod") && text.contains("\"generator\":\"Eyot\""));
        assert!(write(&path, &[], "t").is_err());
        let empty = Lod { mesh: TerrainMesh::default(), ratio: 1.0, error_m: 0.0 };
        assert!(write(&path, &[empty], "t").is_err());
    }
}
