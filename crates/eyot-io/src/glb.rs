//! Binary glTF 2.0 (GLB), out: a terrain with its levels of detail.

use crate::atomic::{put, write_atomically};
use crate::error::{Error, Result};
use eyot_mesh::{Lod, TerrainMesh};
use serde_json::{Value, json};
use std::path::Path;

// Numbers of the glTF specification.
const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Share of the screen's height below which the next coarser level is enough, for levels 0, 1, 2, ... (each level has
/// about a quarter of the triangles, so it serves half the height).
const FIRST_SCREEN_COVERAGE: f64 = 0.5;

/// Writes a terrain as GLB, y up, in metres, with vertex colours and one rough material.
///
/// `levels` are finest first, as [`eyot_mesh::levels_of_detail`] makes them. The scene shows level 0; the others hang
/// on its node by the extension `MSFT_lod`, so that viewers that do not know it show level 0 alone. Colours are linear,
/// as glTF wants them. An attribute `rock` of the mesh becomes the custom attribute `_ROCK`.
///
/// # Errors
/// If there is no level or one without triangles, if the file would exceed 4 GiB (the format's bound), or if it cannot
/// be written.
pub fn write_terrain_glb(path: &Path, levels: &[Lod], name: &str) -> Result<()> {
    if levels.is_empty() || levels.iter().any(|l| l.mesh.indices.is_empty() || !consistent(&l.mesh)) {
        let remedy = "make the levels with eyot_mesh::levels_of_detail";
        return Err(Error::format(path, "a terrain needs at least one level, each with triangles", remedy));
    }
    let mut document = Document::default();
    levels.iter().enumerate().for_each(|(i, level)| document.add(level, i, name));
    let binary_bytes = document.offset;
    let mut text = document.finish(levels.len()).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() as u64 + 8 + binary_bytes;
    let too_large = || {
        let problem = format!("the terrain needs {total} bytes, GLB holds at most 4 GiB");
        Error::format(path, problem, "lower max_vertices or write fewer levels")
    };
    let total = u32::try_from(total).map_err(|_| too_large())?;

    write_atomically(path, |file| {
        let word = |v: u32| v.to_le_bytes();
        put(file, path, &[*b"glTF", word(2), word(total), word(text.len() as u32), *b"JSON"].concat())?;
        put(file, path, &text)?;
        put(file, path, &[word(binary_bytes as u32), *b"BIN\0"].concat())?;
        let mut buffer = Vec::new();
        for level in levels {
            // In the order in which `Document::add` lays the views out; all are multiples of 4 bytes.
            let m = &level.mesh;
            for vectors in [&m.positions, &m.normals] {
                for part in vectors.chunks(1 << 16) {
                    buffer.clear();
                    buffer.extend(part.iter().flatten().flat_map(|v| v.to_le_bytes()));
                    put(file, path, &buffer)?;
                }
            }
            put(file, path, m.colours.as_flattened())?;
            for part in m.attributes.iter().flat_map(|a| a.values.chunks(1 << 16)) {
                buffer.clear();
                buffer.extend(part.iter().flat_map(|v| v.to_le_bytes()));
                put(file, path, &buffer)?;
            }
            for part in m.indices.chunks(1 << 16) {
                buffer.clear();
                buffer.extend(part.iter().flat_map(|v| v.to_le_bytes()));
                put(file, path, &buffer)?;
            }
        }
        Ok(())
    })
}

fn consistent(m: &TerrainMesh) -> bool {
    let n = m.positions.len();
    m.normals.len() == n
        && m.colours.len() == n
        && m.attributes.iter().all(|a| a.values.len() == n)
        && m.indices.len().is_multiple_of(3)
        && m.indices.iter().all(|&i| (i as usize) < n)
}

/// The JSON part while it grows.
#[derive(Default)]
struct Document {
    accessors: Vec<Value>,
    views: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    /// Bytes of the binary part so far.
    offset: u64,
}

impl Document {
    fn add(&mut self, level: &Lod, index: usize, name: &str) {
        let m = &level.mesh;
        let n = m.positions.len();
        let (min, max) = bounds(&m.positions);
        let position = self.accessor(
            ARRAY_BUFFER,
            12 * n,
            json!({"componentType": FLOAT, "count": n, "type": "VEC3", "min": min, "max": max}),
        );
        let normal = self.accessor(ARRAY_BUFFER, 12 * n, json!({"componentType": FLOAT, "count": n, "type": "VEC3"}));
        let colour = self.accessor(
            ARRAY_BUFFER,
            4 * n,
            json!({"componentType": UNSIGNED_BYTE, "normalized": true, "count": n, "type": "VEC4"}),
        );
        let mut attributes = json!({"POSITION": position, "NORMAL": normal, "COLOR_0": colour});
        for a in &m.attributes {
            // glTF wants an underscore before names of its users; Blender makes attributes of the mesh of them.
            let scalar = json!({"componentType": FLOAT, "count": n, "type": "SCALAR"});
            attributes[format!("_{}", a.name.to_uppercase())] = json!(self.accessor(ARRAY_BUFFER, 4 * n, scalar));
        }
        let count = m.indices.len();
        let indices = self.accessor(
            ELEMENT_ARRAY_BUFFER,
            4 * count,
            json!({"componentType": UNSIGNED_INT, "count": count, "type": "SCALAR"}),
        );
        let name = if index == 0 { name.to_owned() } else { format!("{name} level {index}") };
        self.meshes.push(json!({
            "name": name,
            "primitives": [{
                "attributes": attributes,
                "indices": indices,
                "material": 0
            }],
            "extras": {"triangles": m.triangles(), "error_m": level.error_m}
        }));
        self.nodes.push(json!({"name": name, "mesh": index}));
    }

    /// Adds a view of `bytes` and an accessor over all of it, and returns the accessor's index.
    fn accessor(&mut self, target: u32, bytes: usize, mut accessor: Value) -> usize {
        self.views.push(json!({"buffer": 0, "byteOffset": self.offset, "byteLength": bytes, "target": target}));
        self.offset += bytes as u64;
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn finish(mut self, levels: usize) -> Value {
        let mut extra = json!({});
        if levels > 1 {
            let coverage: Vec<f64> = (0..levels as i32)
                .map(|i| if i as usize == levels - 1 { 0.0 } else { FIRST_SCREEN_COVERAGE * 0.5f64.powi(i) })
                .collect();
            self.nodes[0]["extensions"] = json!({"MSFT_lod": {"ids": (1..levels).collect::<Vec<_>>()}});
            self.nodes[0]["extras"] = json!({"MSFT_screencoverage": coverage});
            extra = json!(["MSFT_lod"]);
        }
        let mut document = json!({
            "asset": {"version": "2.0", "generator": "Eyot"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": [{
                "name": "ground",
                "pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
            }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.offset}]
        });
        if levels > 1 {
            document["extensionsUsed"] = extra;
        }
        document
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
    use eyot_core::{Field, Grid, Limits, Rim};
    use eyot_mesh::{MeshOptions, levels_of_detail, terrain};

    fn levels(ratios: &[f64]) -> Vec<Lod> {
        let grid = Grid::new(40, 30, 10.0, Rim::CLOSED, &Limits::default()).unwrap();
        let height = Field::from_fn(40, 30, |x, y| 20.0 * (x as f32 * 0.3).sin() + y as f32);
        let green = vec![[0.1, 0.6, 0.2]; 1200];
        let t = terrain(&height, &grid, &green, &MeshOptions::default(), &Limits::default()).unwrap();
        levels_of_detail(&t, ratios)
    }

    #[test]
    fn the_chunks_add_up_and_only_level_0_is_in_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.glb");
        let levels = levels(&[0.5, 0.25]);
        assert_eq!(levels.len(), 3);
        write_terrain_glb(&path, &levels, "Isle \"A\"").unwrap();
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
        write_terrain_glb(&path, &levels(&[]), "t").unwrap();
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        assert!(!text.contains("MSFT_lod") && text.contains("\"generator\":\"Eyot\""));
        assert!(write_terrain_glb(&path, &[], "t").is_err());
        let empty = Lod { mesh: TerrainMesh::default(), ratio: 1.0, error_m: 0.0 };
        assert!(write_terrain_glb(&path, &[empty], "t").is_err());
    }
}
