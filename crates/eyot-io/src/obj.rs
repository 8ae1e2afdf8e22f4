//! Wavefront OBJ, out: a terrain mesh as text, for programs that read nothing better.

use crate::atomic::{put, write_atomically};
use crate::error::{Error, Result};
use eyot_mesh::TerrainMesh;
use std::fmt::Write;
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
    // Line breaks end names.
    let name: String = name.chars().map(|c| if c.is_alphanumeric() || "_-".contains(c) { c } else { '_' }).collect();
    write_atomically(path, |file| {
        let mut text = format!("# Eyot, metres, y up\no {name}\n");
        let mut flush = |text: &mut String| {
            put(file, path, text.as_bytes())?;
            text.clear();
            Ok(())
        };
        for (positions, colours) in mesh.positions.chunks(LINES).zip(mesh.colours.chunks(LINES)) {
            for ([x, y, z], c) in positions.iter().zip(colours) {
                let [r, g, b] = [c[0], c[1], c[2]].map(|v| f32::from(v) / 255.0);
                // Writing to a string cannot fail.
                let _ = writeln!(text, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}");
            }
            flush(&mut text)?;
        }
        for normals in mesh.normals.chunks(LINES) {
            for [x, y, z] in normals {
                let _ = writeln!(text, "vn {x:.5} {y:.5} {z:.5}");
            }
            flush(&mut text)?;
        }
        for triangles in mesh.indices.chunks(3 * LINES) {
            for t in triangles.chunks_exact(3) {
                // Numbers start at 1.
                let [a, b, c] = [t[0] + 1, t[1] + 1, t[2] + 1];
                let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
            }
            flush(&mut text)?;
        }
        Ok(())
    })
}
