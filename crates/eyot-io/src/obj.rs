//! Wavefront OBJ, out: meshes as text, for programs that read nothing better.

use crate::atomic::put;
use crate::error::{Error, Result};
use crate::scene::{Scene, SceneNode};
use crate::target::Target;
use eyot_mesh::TerrainMesh;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Lines that are put together before they are written.
const LINES: usize = 1 << 14;
/// Linear colour of water.
const WATER: [u8; 4] = [3, 19, 27, 255];

/// Writes a mesh as OBJ, y up, in metres, with texture coordinates, normals and, after each position, its linear colour, as most
/// programs read it. The surface of the water is an object of its own, `water`.
///
/// # Errors
/// If the mesh has no triangles or its arrays differ in length, or if the file cannot be written.
pub fn write_terrain_obj<'a>(
    to: impl Into<Target<'a>>,
    mesh: &TerrainMesh,
    water: Option<&TerrainMesh>,
    name: &str,
) -> Result<()> {
    let to = to.into();
    let path = to.place();
    let n = mesh.positions.len();
    if mesh.indices.is_empty() || [mesh.normals.len(), mesh.colours.len(), mesh.texture.len()] != [n; 3] {
        return Err(Error::format(path, "the mesh has no triangles", "make it with eyot_mesh::terrain"));
    }
    to.write(|file| {
        put(file, path, b"# Eyot, metres, y up\n")?;
        let mut object = |name, m: &TerrainMesh, colours: &[[u8; 4]], first| {
            let (positions, normals, texture, indices) = (&m.positions, &m.normals, &m.texture, &m.indices);
            Object { name, positions, normals, colours, texture, indices, first, node: None }.write(path, file)
        };
        object(name, mesh, &mesh.colours, 1)?;
        match water {
            Some(w) => object("water", w, &vec![WATER; w.positions.len()], 1 + n as u64),
            None => Ok(()),
        }
    })
}

/// Writes bodies as OBJ: an object for each node, at its place, y up, in metres.
///
/// # Errors
/// If the scene contradicts itself, or if the file cannot be written.
pub fn write_scene_obj<'a>(to: impl Into<Target<'a>>, scene: &Scene<'_>) -> Result<()> {
    let to = to.into();
    let path = to.place();
    scene.check(path)?;
    to.write(|file| {
        put(file, path, b"# Eyot, bodies, metres, y up\n")?;
        let mut first = 1;
        for node in &scene.nodes {
            let m = &scene.meshes[node.mesh];
            let object = Object {
                name: &node.name,
                positions: m.positions,
                normals: m.normals,
                colours: m.colours,
                texture: &[],
                indices: m.indices,
                first,
                node: Some(node),
            };
            object.write(path, file)?;
            first += m.positions.len() as u64;
        }
        Ok(())
    })
}

struct Object<'a> {
    name: &'a str,
    positions: &'a [[f32; 3]],
    normals: &'a [[f32; 3]],
    colours: &'a [[u8; 4]],
    /// As many or none.
    texture: &'a [[u16; 2]],
    indices: &'a [u32],
    /// Number of its first vertex in the file, from 1.
    first: u64,
    /// Where it stands; at the origin without one.
    node: Option<&'a SceneNode>,
}

impl Object<'_> {
    fn write(&self, path: &Path, file: &mut dyn io::Write) -> Result<()> {
        // Line breaks end names.
        let name: String =
            self.name.chars().map(|c| if c.is_alphanumeric() || "_-".contains(c) { c } else { '_' }).collect();
        let mut text = format!("o {name}\n");
        let mut flush = |text: &mut String| {
            put(file, path, text.as_bytes())?;
            text.clear();
            Ok(())
        };
        for (positions, colours) in self.positions.chunks(LINES).zip(self.colours.chunks(LINES)) {
            for (&p, c) in positions.iter().zip(colours) {
                let [x, y, z] = self.node.map_or(p, |n| n.position(p));
                let [r, g, b] = [c[0], c[1], c[2]].map(|v| f32::from(v) / 255.0);
                // Writing to a string cannot fail.
                let _ = writeln!(text, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}");
            }
            flush(&mut text)?;
        }
        for texture in self.texture.chunks(LINES) {
            for t in texture {
                let [u, v] = t.map(|v| f32::from(v) / 65535.0);
                // OBJ counts upward from the bottom of the picture.
                let _ = writeln!(text, "vt {u:.6} {:.6}", 1.0 - v);
            }
            flush(&mut text)?;
        }
        for normals in self.normals.chunks(LINES) {
            for &n in normals {
                let [x, y, z] = self.node.map_or(n, |node| node.direction(n));
                let _ = writeln!(text, "vn {x:.5} {y:.5} {z:.5}");
            }
            flush(&mut text)?;
        }
        for triangles in self.indices.chunks(3 * LINES) {
            for t in triangles.chunks_exact(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| u64::from(i) + self.first);
                let _ = if self.texture.is_empty() {
                    writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}")
                } else {
                    writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
                };
            }
            flush(&mut text)?;
        }
        Ok(())
    }
}
