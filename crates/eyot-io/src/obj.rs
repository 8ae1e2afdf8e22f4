//! Wavefront OBJ, out: meshes as text, for programs that read nothing better.

use crate::atomic::{put, write_atomically};
use crate::error::{Error, Result};
use crate::scene::{Scene, SceneNode};
use eyot_mesh::TerrainMesh;
use std::fmt::Write;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Lines that are put together before they are written.
const LINES: usize = 1 << 14;

/// Writes a mesh as OBJ, y up, in metres, with normals and, after each position, its linear colour, as most programs read
/// it.
///
/// # Errors
/// If the mesh has no triangles or its arrays differ in length, or if the file cannot be written.
pub fn write_terrain_obj(path: &Path, mesh: &TerrainMesh, name: &str) -> Result<()> {
    let n = mesh.positions.len();
    if mesh.indices.is_empty() || mesh.normals.len() != n || mesh.colours.len() != n {
        return Err(Error::format(path, "the mesh has no triangles", "make it with eyot_mesh::terrain"));
    }
    write_atomically(path, |file| {
        put(file, path, b"# Eyot, metres, y up\n")?;
        let object = Object {
            name,
            positions: &mesh.positions,
            normals: &mesh.normals,
            colours: &mesh.colours,
            indices: &mesh.indices,
            first: 1,
            node: None,
        };
        object.write(path, file)
    })
}

/// Writes bodies as OBJ: an object for each node, at its place, y up, in metres.
///
/// # Errors
/// If the scene contradicts itself, or if the file cannot be written.
pub fn write_scene_obj(path: &Path, scene: &Scene<'_>) -> Result<()> {
    scene.check(path)?;
    write_atomically(path, |file| {
        put(file, path, b"# Eyot, bodies, metres, y up\n")?;
        let mut first = 1;
        for node in &scene.nodes {
            let m = &scene.meshes[node.mesh];
            let object = Object {
                name: &node.name,
                positions: m.positions,
                normals: m.normals,
                colours: m.colours,
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
    indices: &'a [u32],
    /// Number of its first vertex in the file, from 1.
    first: u64,
    /// Where it stands; at the origin without one.
    node: Option<&'a SceneNode>,
}

impl Object<'_> {
    fn write(&self, path: &Path, file: &mut BufWriter<File>) -> Result<()> {
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
                let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
            }
            flush(&mut text)?;
        }
        Ok(())
    }
}
