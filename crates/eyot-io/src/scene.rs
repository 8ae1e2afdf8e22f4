//! Bodies at their places, as files of meshes take them.

use crate::error::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// A closed surface. Places are m: x to the east, y up, z to the south.
#[derive(Clone, Copy, Debug)]
pub struct SceneMesh<'a> {
    /// Name.
    pub name: &'a str,
    /// Vertices.
    pub positions: &'a [[f32; 3]],
    /// Unit vectors out of the body, as many.
    pub normals: &'a [[f32; 3]],
    /// Linear red, green, blue and alpha, as many.
    pub colours: &'a [[u8; 4]],
    /// Texture coordinates, as many or none.
    pub texture: &'a [[f32; 2]],
    /// Three per triangle, counter-clockwise from outside.
    pub indices: &'a [u32],
    /// Number of its material.
    pub material: usize,
}

/// What a surface is made of. Vertex colours are multiplied by its own.
#[derive(Clone, Copy, Debug)]
pub struct SceneMaterial<'a> {
    /// Name.
    pub name: &'a str,
    /// Linear red, green and blue, 0..=1.
    pub colour: [f32; 3],
}

/// A place at which a mesh is shown.
#[derive(Clone, Debug)]
pub struct SceneNode {
    /// Name.
    pub name: String,
    /// Number of its mesh. Several nodes may show the same one.
    pub mesh: usize,
    /// Where its origin lies, m.
    pub place: [f32; 3],
    /// Turn about the upright axis, radians.
    pub turn: f32,
    /// Factor on all lengths.
    pub size: f32,
    /// What else is known of it, such as species and age; `Null` for nothing.
    pub extras: Value,
}

/// Bodies at their places.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// Name.
    pub name: &'a str,
    /// Meshes.
    pub meshes: Vec<SceneMesh<'a>>,
    /// Materials.
    pub materials: Vec<SceneMaterial<'a>>,
    /// What is shown.
    pub nodes: Vec<SceneNode>,
}

impl SceneNode {
    /// A direction of the mesh, turned.
    pub(crate) fn direction(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let (s, c) = self.turn.sin_cos();
        [c * x + s * z, y, c * z - s * x]
    }

    /// A place of the mesh, in the scene.
    pub(crate) fn position(&self, p: [f32; 3]) -> [f32; 3] {
        let p = self.direction(p);
        std::array::from_fn(|i| self.place[i] + self.size * p[i])
    }
}

impl Scene<'_> {
    /// # Errors
    /// If there is nothing to show, arrays differ in length, or a number points to nothing.
    pub(crate) fn check(&self, path: &Path) -> Result<()> {
        let fail = |problem: String, remedy: &'static str| Err(Error::format(path, problem, remedy));
        if self.nodes.is_empty() {
            return fail("there is no body to write".into(), "add nodes that show meshes");
        }
        for m in &self.meshes {
            let n = m.positions.len();
            let lengths =
                m.normals.len() == n && m.colours.len() == n && (m.texture.is_empty() || m.texture.len() == n);
            let indices = m.indices.len().is_multiple_of(3) && m.indices.iter().all(|&i| (i as usize) < n);
            if !lengths || !indices || m.indices.is_empty() {
                let problem = format!("the mesh `{}` has no triangles, or arrays of different lengths", m.name);
                return fail(problem, "give every vertex a normal and a colour, and triangles of vertices that exist");
            }
            if m.material >= self.materials.len() {
                return fail(
                    format!("the mesh `{}` has a material that is not there", m.name),
                    "add it to the materials",
                );
            }
        }
        for n in &self.nodes {
            if n.mesh >= self.meshes.len() {
                return fail(format!("the node `{}` shows a mesh that is not there", n.name), "add it to the meshes");
            }
            let numbers = [n.place[0], n.place[1], n.place[2], n.turn, n.size];
            if !(numbers.iter().all(|v| v.is_finite()) && n.size > 0.0) {
                return fail(
                    format!("the node `{}` has no finite place, turn or size", n.name),
                    "give it finite numbers",
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{Scene, SceneMaterial, SceneMesh, SceneNode, write_scene_glb, write_scene_obj, write_scene_ply};
    use serde_json::{Value, json};

    const PLACES: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const NORMALS: [[f32; 3]; 4] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const COLOURS: [[u8; 4]; 4] = [[255, 0, 10, 255]; 4];
    const INDICES: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];

    fn scene(texture: &[[f32; 2]]) -> Scene<'_> {
        let mesh = SceneMesh {
            name: "tetrahedron",
            positions: &PLACES,
            normals: &NORMALS,
            colours: &COLOURS,
            texture,
            indices: &INDICES,
            material: 0,
        };
        let node = |name: &str, x: f32, turn: f32, size: f32, extras: Value| SceneNode {
            name: name.into(),
            mesh: 0,
            place: [x, 0.0, 0.0],
            turn,
            size,
            extras,
        };
        Scene {
            name: "two",
            meshes: vec![mesh],
            materials: vec![SceneMaterial { name: "coral", colour: [1.0; 3] }],
            nodes: vec![
                node("one", 0.0, 0.0, 1.0, json!({"age_months": 3})),
                node("other\n1", 5.0, std::f32::consts::FRAC_PI_2, 2.0, Value::Null),
            ],
        }
    }

    #[test]
    fn nodes_share_a_mesh_in_glb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.glb");
        write_scene_glb(&path, &scene(&[[0.0, 1.0]; 4])).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let word = |i: usize| u32::from_le_bytes(bytes[i..i + 4].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        assert_eq!((word(8), document["nodes"].as_array().unwrap().len()), (bytes.len(), 2));
        assert_eq!(
            (&document["meshes"][0]["name"], document["meshes"].as_array().unwrap().len()),
            (&json!("tetrahedron"), 1)
        );
        assert_eq!(document["nodes"][0]["extras"], json!({"age_months": 3}));
        assert!(
            document["nodes"][0].get("rotation").is_none() && document["nodes"][1]["scale"] == json!([2.0, 2.0, 2.0])
        );
        let attributes = &document["meshes"][0]["primitives"][0]["attributes"];
        assert!(attributes.get("TEXCOORD_0").is_some() && attributes.get("COLOR_0").is_some());
    }

    #[test]
    fn obj_and_ply_put_every_node_at_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let (obj, ply) = (folder.path().join("s.obj"), folder.path().join("s.ply"));
        write_scene_obj(&obj, &scene(&[])).unwrap();
        let text = std::fs::read_to_string(&obj).unwrap();
        assert!(text.contains("o one\n") && text.contains("o other_1\n"), "{text}");
        assert_eq!((text.matches("\nv ").count(), text.matches("\nf ").count()), (8, 8));
        // A quarter turn to the left seen from above takes x to -z; then twice as large, and 5 m east.
        let second = text.lines().filter(|l| l.starts_with("v ")).nth(5).unwrap();
        let numbers: Vec<f32> = second.split(' ').skip(1).map(|v| v.parse().unwrap()).collect();
        assert!((numbers[0] - 5.0).abs() < 1e-6 && numbers[1] == 0.0 && (numbers[2] + 2.0).abs() < 1e-6, "{second}");
        assert!(text.ends_with("f 6//6 8//8 7//7\n"), "{text}");
        write_scene_ply(&ply, &scene(&[])).unwrap();
        let bytes = std::fs::read(&ply).unwrap();
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        assert_eq!(bytes.len() - end, 8 * (6 * 4 + 3) + 8 * 13);
        assert_eq!(&bytes[end + 24..end + 27], [255, 0, 56], "linear 10 is sRGB 56");
        assert_eq!(&bytes[bytes.len() - 13..], [3, 5, 0, 0, 0, 7, 0, 0, 0, 6, 0, 0, 0]);
    }

    #[test]
    fn scenes_that_contradict_themselves_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.glb");
        let fails = |change: &dyn Fn(&mut Scene<'_>)| {
            let mut scene = scene(&[]);
            change(&mut scene);
            let error = write_scene_glb(&path, &scene).unwrap_err().to_string();
            assert!(!path.exists());
            error
        };
        assert!(fails(&|s| s.nodes.clear()).contains("no body"));
        assert!(fails(&|s| s.meshes[0].normals = &NORMALS[..3]).contains("tetrahedron"));
        assert!(fails(&|s| s.meshes[0].indices = &[0, 1, 4]).contains("tetrahedron"));
        assert!(fails(&|s| s.meshes[0].material = 1).contains("material"));
        assert!(fails(&|s| s.nodes[1].mesh = 7).contains("mesh that is not there"));
        assert!(fails(&|s| s.nodes[0].size = f32::NAN).contains("finite"));
    }
}
