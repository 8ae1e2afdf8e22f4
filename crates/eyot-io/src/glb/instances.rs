//! Many copies of few bodies: GLB with `EXT_mesh_gpu_instancing`.

use super::{ARRAY_BUFFER, Data, Document, FLOAT, bounds, material};
use crate::error::{Error, Result};
use crate::scene::SceneMesh;
use crate::target::Target;
use serde_json::json;

/// Copies of a body. Places are m: x to the east, y up, z to the south.
#[derive(Clone, Debug)]
pub struct Instances<'a> {
    /// The body; its material is its number among those of the file, which have its name.
    pub mesh: SceneMesh<'a>,
    /// Where the copies' origins lie.
    pub places: Vec<[f32; 3]>,
    /// Turns about the upright axis, rad, as many.
    pub turns: Vec<f32>,
    /// Factors on lengths, as many.
    pub sizes: Vec<[f32; 3]>,
}

/// Writes copies of bodies as GLB: a node for each body, whose copies are attributes `TRANSLATION`, `ROTATION` and `SCALE` of the extension
/// `EXT_mesh_gpu_instancing`, which whoever reads the file has to know. Bodies without a copy are left out.
///
/// # Errors
/// If there is no copy, if arrays differ in length, if the file would exceed 4 GiB (the format's bound), or if it cannot be written.
pub fn write_instances_glb<'a>(to: impl Into<Target<'a>>, name: &str, bodies: &[Instances<'_>]) -> Result<()> {
    let to = to.into();
    let bodies: Vec<&Instances<'_>> = bodies.iter().filter(|b| !b.places.is_empty()).collect();
    let whole = |b: &&Instances<'_>| {
        let (n, vertices) = (b.places.len(), b.mesh.positions.len());
        b.turns.len() == n
            && b.sizes.len() == n
            && !b.mesh.indices.is_empty()
            && b.mesh.normals.len() == vertices
            && b.mesh.colours.len() == vertices
            && b.mesh.indices.iter().all(|&i| (i as usize) < vertices)
    };
    if bodies.is_empty() || !bodies.iter().all(whole) {
        let problem = "there is no copy of a body, or arrays of different lengths";
        return Err(Error::format(to.place(), problem, "give every copy a place, a turn and a size"));
    }
    let rotation = |turn: &f32| {
        let (sin, cos) = (0.5 * turn).sin_cos();
        [0.0, sin, 0.0, cos]
    };
    let turns: Vec<Vec<[f32; 4]>> = bodies.iter().map(|b| b.turns.iter().map(rotation).collect()).collect();
    let mut document = Document::default();
    for (i, (body, turns)) in bodies.iter().zip(&turns).enumerate() {
        let m = &body.mesh;
        let attributes = document.attributes(m.positions, m.normals, m.colours, &[]);
        document.add_mesh(m.name, attributes, m.indices, i, json!({}));
        let n = body.places.len();
        let (min, max) = bounds(&body.places);
        let vector = json!({"componentType": FLOAT, "count": n, "type": "VEC3"});
        let place = json!({"componentType": FLOAT, "count": n, "type": "VEC3", "min": min, "max": max});
        let turn = json!({"componentType": FLOAT, "count": n, "type": "VEC4"});
        let copies = json!({
            "TRANSLATION": document.accessor(ARRAY_BUFFER, Data::Vectors(&body.places), place),
            "ROTATION": document.accessor(ARRAY_BUFFER, Data::Fours(turns), turn),
            "SCALE": document.accessor(ARRAY_BUFFER, Data::Vectors(&body.sizes), vector),
        });
        document.nodes.push(json!({
            "name": m.name, "mesh": i, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": copies}},
        }));
    }
    let all: Vec<usize> = (0..bodies.len()).collect();
    document.root["scenes"] = json!([{"name": name, "nodes": all, "extras": {"kind": "instances"}}]);
    document.root["materials"] = bodies.iter().map(|b| material(b.mesh.name, [1.0; 3])).collect();
    document.root["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    document.root["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    document.write(&to, "write fewer copies in a file")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn copies_are_attributes_of_one_node_a_body() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("copies.glb");
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let (normals, colours) = ([[0.0, 0.0, 1.0]; 3], [[9, 9, 9, 255]; 3]);
        let mesh = SceneMesh {
            name: "leaf",
            positions: &positions,
            normals: &normals,
            colours: &colours,
            texture: &[],
            indices: &[0, 1, 2],
            material: 0,
        };
        let places = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let body = Instances { mesh, places, turns: vec![0.0, 1.0], sizes: vec![[1.0; 3], [2.0; 3]] };
        write_instances_glb(&path, "two", std::slice::from_ref(&body)).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let word = |i: usize| u32::from_le_bytes(bytes[i..i + 4].try_into().unwrap()) as usize;
        let document: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        assert_eq!(document["extensionsRequired"], json!(["EXT_mesh_gpu_instancing"]));
        let copies = &document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let read = |name: &str, i: usize| {
            let accessor = &document["accessors"][copies[name].as_u64().unwrap() as usize];
            assert_eq!(accessor["count"], 2);
            let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
            f32::from_bits(word(28 + word(12) + view["byteOffset"].as_u64().unwrap() as usize + 4 * i) as u32)
        };
        assert_eq!((read("TRANSLATION", 4), read("SCALE", 3), read("ROTATION", 3)), (5.0, 2.0, 1.0));
        assert!((read("ROTATION", 5) - 0.5f32.sin()).abs() < 1e-6);
        assert!(write_instances_glb(&path, "none", &[Instances { turns: vec![], ..body }]).is_err());
    }
}
