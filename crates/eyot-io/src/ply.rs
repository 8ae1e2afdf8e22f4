//! Stanford PLY, out: bodies as one binary mesh, for programs that measure and print.

use crate::atomic::put;
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::target::Target;

/// Vertices or triangles that are put together before they are written.
const PART: usize = 1 << 14;

/// Writes bodies as binary little-endian PLY, all at their places in one mesh, y up, in metres, with normals and sRGB colours.
///
/// # Errors
/// If the scene contradicts itself, if it has more vertices than 32-bit numbers can count, or if the file cannot be written.
pub fn write_scene_ply<'a>(to: impl Into<Target<'a>>, scene: &Scene<'_>) -> Result<()> {
    let to = to.into();
    let path = to.place();
    scene.check(path)?;
    let count =
        |f: fn(&crate::scene::SceneMesh<'_>) -> usize| scene.nodes.iter().map(|n| f(&scene.meshes[n.mesh])).sum();
    let (vertices, triangles): (usize, usize) = (count(|m| m.positions.len()), count(|m| m.indices.len() / 3));
    if i32::try_from(vertices).is_err() {
        let problem = format!("{vertices} vertices are more than PLY's numbers can count");
        return Err(Error::format(path, problem, "write fewer bodies or choose longer voxels"));
    }
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment Eyot, bodies, metres, y up\nelement vertex {vertices}\n"
    );
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        header += &format!("property float {name}\n");
    }
    for name in ["red", "green", "blue"] {
        header += &format!("property uchar {name}\n");
    }
    header += &format!("element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n");
    let to_srgb: Vec<u8> = (0..=255).map(srgb).collect();
    to.write(|file| {
        put(file, path, header.as_bytes())?;
        let mut bytes = Vec::new();
        for node in &scene.nodes {
            let m = &scene.meshes[node.mesh];
            for first in (0..m.positions.len()).step_by(PART) {
                for i in first..(first + PART).min(m.positions.len()) {
                    let numbers = [node.position(m.positions[i]), node.direction(m.normals[i])];
                    bytes.extend(numbers.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
                    bytes.extend(m.colours[i][..3].iter().map(|&c| to_srgb[usize::from(c)]));
                }
                put(file, path, &bytes)?;
                bytes.clear();
            }
        }
        let mut first = 0;
        for node in &scene.nodes {
            let m = &scene.meshes[node.mesh];
            for part in m.indices.chunks(3 * PART) {
                for t in part.chunks_exact(3) {
                    bytes.push(3);
                    bytes.extend(t.iter().flat_map(|i| (first + i).to_le_bytes()));
                }
                put(file, path, &bytes)?;
                bytes.clear();
            }
            first += m.positions.len() as u32;
        }
        Ok(())
    })
}

/// A byte of linear light as sRGB.
fn srgb(linear: u8) -> u8 {
    let c = f32::from(linear) / 255.0;
    let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded + 0.5) as u8
}
