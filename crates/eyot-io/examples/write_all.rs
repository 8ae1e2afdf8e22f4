//! Writes everything that this crate can write into a folder, for `ci/check_outputs.py`.
//!
//! Usage: `cargo run -p eyot-io --example write_all -- FOLDER`

use eyot_core::{Boundary, Field, Georeference, Grid, LayerSpec, Limits, World, layer::known};
use eyot_io::{
    About, RasterFormat, ReadOptions, Rows, Scene, SceneMaterial, SceneMesh, SceneNode, TerrainParts, checkpoint,
    read_raster, shares, write_exr, write_layer, write_mask, write_rgb_png, write_scene_glb, write_scene_obj,
    write_scene_ply, write_splat, write_store, write_terrain_glb, write_terrain_obj,
};
use eyot_mesh::{
    Blend, Blobs, Kernel, Lattice, MeshOptions, MeshingOptions, Primitive, levels_of_detail, mesh_field, terrain,
};
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: write_all FOLDER")?);
    std::fs::create_dir_all(&folder)?;
    let limits = Limits::default();
    for (name, world) in worlds(&limits)? {
        for layer in world.layers() {
            for format in RasterFormat::ALL {
                let file = format!("{name}-{}.{}", layer.spec.name, format.extension());
                write_layer(&folder.join(file), &world, layer, format)?;
            }
        }
        let about: Vec<About> = world.layers().iter().map(|l| About::of(&world, l)).collect();
        let mut fields: Vec<&Field> = world.layers().iter().map(|l| &l.field).collect();
        let mut all: Vec<(&About, &mut dyn Rows)> =
            about.iter().zip(&mut fields).map(|(a, f)| (a, f as &mut dyn Rows)).collect();
        write_store(&folder.join(format!("{name}.zarr")), &mut all, &serde_json::Map::new())?;
        if name != "one" {
            write_exr(&folder.join(format!("{name}.exr")), &mut all)?;
        }
        splat(&folder, name, &world)?;
        checkpoint::save(&folder.join(format!("{name}.ckpt")), &world, "", &serde_json::Value::Null)?;
        if world.grid.width > 1 && world.grid.height > 1 {
            mesh(&folder, name, &world, &limits)?;
        }
    }
    bodies(&folder, &limits)
}

/// Two bodies, of which one stands in three places.
fn bodies(folder: &Path, limits: &Limits) -> Result<()> {
    let shapes = [
        vec![Primitive::ball([0.0, 0.5, 0.0], 0.6), Primitive::cone([0.0; 3], [0.6, 1.2, 0.1], [0.4, 0.2])],
        vec![Primitive::cylinder([0.0; 3], [0.0, 0.8, 0.0], 0.2), Primitive::cylinder([0.0; 3], [0.4, 0.7, 0.3], 0.15)],
    ];
    let mesh = |primitives: &Vec<Primitive>| -> Result<eyot_mesh::Solid> {
        let field = Blobs::new(primitives, Kernel::Muraki, Blend::Normalised, limits)?;
        let lattice = Lattice::over([-1.0; 3], [1.5; 3], 0.06, limits)?;
        Ok(mesh_field(&field, &lattice, &MeshingOptions::default(), limits)?)
    };
    let solids = shapes.iter().map(mesh).collect::<Result<Vec<_>>>()?;
    let colours: Vec<Vec<[u8; 4]>> = solids
        .iter()
        .map(|s| s.positions.iter().map(|p| [200, (120.0 * p[1].max(0.0)) as u8, 60, 255]).collect())
        .collect();
    let texture: Vec<Vec<[f32; 2]>> =
        solids.iter().map(|s| s.positions.iter().map(|p| [p[0], p[2]]).collect()).collect();
    let meshes: Vec<SceneMesh> = (0..2)
        .map(|i| SceneMesh {
            name: ["boulder", "finger \"a\""][i],
            positions: &solids[i].positions,
            normals: &solids[i].normals,
            colours: &colours[i],
            texture: if i == 0 { &texture[0] } else { &[] },
            indices: &solids[i].indices,
            material: i,
        })
        .collect();
    let node = |name: &str, mesh: usize, place: [f32; 3], turn: f32, size: f32, extras: serde_json::Value| SceneNode {
        name: name.into(),
        mesh,
        place,
        turn,
        size,
        extras,
    };
    let null = serde_json::Value::Null;
    let scene = Scene {
        name: "bodies",
        meshes,
        materials: vec![
            SceneMaterial { name: "Porites lobata", colour: [1.0; 3] },
            SceneMaterial { name: "alga", colour: [0.8, 1.0, 0.8] },
        ],
        nodes: vec![
            node(
                "colony 1",
                0,
                [0.0; 3],
                0.0,
                1.0,
                serde_json::json!({"species": "Porites lobata", "age_months": 240}),
            ),
            node("alga 2", 1, [3.0, 0.0, 0.0], 0.0, 1.0, null.clone()),
            node("alga 3", 1, [3.0, 0.2, 2.0], 1.0, 0.5, null.clone()),
            node("alga 4", 1, [-3.0, 0.0, 1.0], -2.0, 1.5, null),
        ],
    };
    write_scene_glb(&folder.join("bodies.glb"), &scene)?;
    write_scene_obj(&folder.join("bodies.obj"), &scene)?;
    Ok(write_scene_ply(&folder.join("bodies.ply"), &scene)?)
}

fn mesh(folder: &Path, name: &str, world: &World, limits: &Limits) -> Result<()> {
    let height = &world.layer("height")?.field;
    let (low, high) = height.iter().fold((f32::MAX, f32::MIN), |(a, b), v| (a.min(v), b.max(v)));
    let grey: Vec<[f32; 3]> = height.iter().map(|v| [0.1 + 0.8 * (v - low) / (high - low).max(1e-6); 3]).collect();
    let pixels: Vec<[u8; 3]> = grey.iter().map(|c| c.map(|v| (v.sqrt() * 255.0) as u8)).collect();
    write_rgb_png(&folder.join(format!("{name}-picture.png")), world.grid.width, world.grid.height, &pixels)?;
    let mut t = terrain(height, &world.grid, &grey, &MeshOptions { max_vertices: 300_000 }, limits)?;
    let wet: Vec<f32> = height.iter().map(|v| if v < low + 0.3 * (high - low) { 1.0 } else { 0.0 }).collect();
    t.add_attribute("wet", &wet)?;
    let levels = levels_of_detail(&t, &[0.25, 0.0625]);
    for l in &levels {
        println!(
            "{name}: {} triangles, {} vertices, error {} m",
            l.mesh.triangles(),
            l.mesh.positions.len(),
            l.error_m
        );
    }
    write_terrain_obj(&folder.join(format!("{name}.obj")), &levels[0].mesh, None, name)?;
    let parts = TerrainParts { levels: &levels, name, ..TerrainParts::default() };
    write_terrain_glb(&folder.join(format!("{name}.glb")), &parts)?;
    Ok(())
}

/// Weights of made-up materials, and one of them as a mask.
fn splat(folder: &Path, name: &str, world: &World) -> Result<()> {
    let size = (world.grid.width, world.grid.height);
    let weights: Vec<[u8; 4]> =
        (0..world.grid.cells()).map(|i| shares([(i % 7) as f32, 0.3, (i % 11) as f32, 1.0])).collect();
    let path = folder.join(format!("{name}-splat.png"));
    write_splat(&path, size, &["grass", "rock", "sand", "snow"], &mut |first, out| {
        out.copy_from_slice(&weights[first * size.0..][..out.len()]);
        Ok(())
    })?;
    let mask = Field::from_fn(size.0, size.1, |x, y| f32::from(weights[y * size.0 + x][0]) / 255.0);
    Ok(write_mask(&folder.join(format!("{name}-mask.png")), &mut &mask)?)
}

fn worlds(limits: &Limits) -> Result<Vec<(&'static str, World)>> {
    let made = |width: usize, height: usize, georeference: Option<Georeference>| -> Result<World> {
        let mut world = World::new(Grid::new(width, height, 10.0, Boundary::CLOSED, limits)?, 7);
        world.georeference = georeference;
        let hill = |x: usize, y: usize| {
            let (u, v) = (x as f32 / 40.0, y as f32 / 55.0);
            300.0 * u.sin() * v.cos() + 40.0 * (3.1 * u + v).sin() - 120.0
        };
        world.put(&known::HEIGHT, Field::from_fn(width, height, hill))?;
        world.put(&known::WATER, Field::from_fn(width, height, |x, y| (-hill(x, y)).max(0.0)))?;
        // Names and units beyond ASCII, and the value that usually marks missing cells.
        let odd =
            LayerSpec { unit: "m²".into(), meaning: "Fläche".into(), ..LayerSpec::new("odd", "", "", (-1e4, 1e4)) };
        world.put(&odd, Field::from_fn(width, height, |x, y| if (x + y) % 7 == 0 { -9999.0 } else { 0.1 }))?;
        Ok(world)
    };
    let utm = Georeference {
        transform: [500_010.0, 10.0, 0.0, 4_100_020.0, 0.0, -10.0],
        epsg: Some(32611),
        geographic: false,
        nodata: Some(-32768.0),
        ..Georeference::default()
    };
    let raster = read_raster(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("../eyot-recipe/data/jacksboro.tif"),
        &ReadOptions::default(),
        limits,
    )?;
    let (x, y) = raster.cell_m.ok_or("no cell size")?;
    println!("jacksboro: cells of {x} x {y} m");
    let grid =
        Grid { cell_y_m: y, ..Grid::new(raster.field.width(), raster.field.height(), x, Boundary::OPEN, limits)? };
    let mut jacksboro = World::new(grid, 7);
    jacksboro.georeference = raster.georeference;
    jacksboro.put(&known::HEIGHT, raster.field)?;
    Ok(vec![
        ("one", made(1, 1, None)?),
        ("small", made(3, 7, None)?),
        ("row", made(600, 1, None)?),
        ("hills", made(1025, 700, None)?),
        ("utm", made(513, 257, Some(utm))?),
        ("jacksboro", jacksboro),
    ])
}
