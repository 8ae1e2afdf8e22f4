//! Meshes a field of your own, or metaballs from a file, and writes the body as GLB, OBJ or PLY.
//!
//! `cargo run --release -p eyot-io --example surface -- gyroid gyroid.glb [VOXEL]`
//! `cargo run --release -p eyot-io --example surface -- balls.txt balls.ply [VOXEL]`
//!
//! A file of metaballs has a ball in each line, `x y z radius`, or a rounded cone, `x y z radius x y z radius`; `#` begins a comment.

use eyot_core::Limits;
use eyot_io::{Scene, SceneMaterial, SceneMesh, SceneNode, write_scene_glb, write_scene_obj, write_scene_ply};
use eyot_mesh::{
    Blend, Blobs, Kernel, Lattice, MeshingOptions, Point, Primitive, ScalarField, Solid, mesh_field, solid_levels,
};
use std::path::Path;
use std::time::Instant;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// A sheet along the gyroid, a surface that divides space into two equal labyrinths.
struct Gyroid;

impl ScalarField for Gyroid {
    fn value(&self, [x, y, z]: Point) -> f32 {
        0.35 - (x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()).abs()
    }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, out, ..] = &arguments[..] else { return Err("usage: surface gyroid|FILE OUT [VOXEL]".into()) };
    let voxel: Option<f32> = arguments.get(2).map(|v| v.parse()).transpose()?;
    let limits = Limits::default();
    let mesh = |field: &dyn ScalarField, low: Point, high: Point| -> Result<Solid> {
        let longest = (0..3).map(|i| high[i] - low[i]).fold(0.0, f32::max);
        let lattice = Lattice::over(low, high, voxel.unwrap_or(longest / 100.0), &limits)?;
        let start = Instant::now();
        let solid = mesh_field(field, &lattice, &MeshingOptions::default(), &limits)?;
        println!("{} triangles in {:.2} ms", solid.triangles(), 1e3 * start.elapsed().as_secs_f64());
        Ok(solid)
    };
    let solid = if what == "gyroid" {
        mesh(&Gyroid, [-6.3; 3], [6.3; 3])?
    } else {
        let balls = Blobs::new(&read(&std::fs::read_to_string(what)?)?, Kernel::Muraki, Blend::Normalised, &limits)?;
        let [low, high] = balls.bounds().ok_or("the file has no ball")?;
        mesh(&balls, low, high)?
    };
    println!("{:?}\n{:?}\nvolume {}, area {}", solid.topology(), solid.quality(), solid.volume(), solid.area());
    for l in solid_levels(&solid, &[0.5, 0.25, 0.125]) {
        println!("level of {} triangles, error {}", l.solid.triangles(), l.error);
    }
    write(Path::new(out), &solid)
}

fn read(text: &str) -> Result<Vec<Primitive>> {
    let lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.trim_start().starts_with('#'));
    lines
        .map(|(i, line)| {
            let numbers: Vec<f32> = line.split_whitespace().map(str::parse).collect::<std::result::Result<_, _>>()?;
            match numbers[..] {
                [x, y, z, r] => Ok(Primitive::ball([x, y, z], r)),
                [x, y, z, r, u, v, w, s] => Ok(Primitive::cone([x, y, z], [u, v, w], [r, s])),
                _ => Err(format!("line {}: four numbers make a ball, eight a cone", i + 1).into()),
            }
        })
        .collect()
}

fn write(path: &Path, solid: &Solid) -> Result<()> {
    let colours = vec![[196, 180, 150, 255]; solid.positions.len()];
    let mesh = SceneMesh {
        name: "body",
        positions: &solid.positions,
        normals: &solid.normals,
        colours: &colours,
        texture: &[],
        indices: &solid.indices,
        material: 0,
    };
    let node = SceneNode {
        name: "body".into(),
        mesh: 0,
        place: [0.0; 3],
        turn: 0.0,
        size: 1.0,
        extras: serde_json::Value::Null,
    };
    let material = SceneMaterial { name: "body", colour: [1.0; 3] };
    let scene = Scene { name: "surface", meshes: vec![mesh], materials: vec![material], nodes: vec![node] };
    match path.extension().and_then(|e| e.to_str()) {
        Some("obj") => write_scene_obj(path, &scene)?,
        Some("ply") => write_scene_ply(path, &scene)?,
        _ => write_scene_glb(path, &scene)?,
    }
    Ok(())
}
