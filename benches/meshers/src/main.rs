//! Meshes the same fields with Eyot and with `fast-surface-nets`, one after the other on one thread, and prints time, triangles,
//! evenness, holes and errors.
//!
//! `cargo run --release` in this folder. Times are the best of seven.

use eyot_core::Limits;
use eyot_mesh::{Blend, Blobs, Kernel, Lattice, MeshingOptions, Point, Primitive, ScalarField, Solid, Volume, mesh_field};
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

struct Of(fn(Point) -> f32);

impl ScalarField for Of {
    fn value(&self, p: Point) -> f32 {
        (self.0)(p)
    }
}

/// Values at all points of a cube, so that a run times the meshing alone.
fn sampled(field: &dyn ScalarField, reach: f32, voxel: f32) -> (Volume, usize) {
    let half = (reach / voxel).ceil() as i32 + 2;
    let n = (2 * half + 1) as usize;
    let line: Vec<f32> = (-half..=half).map(|i| i as f32 * voxel).collect();
    let mut values = vec![0.0; n * n * n];
    field.fill([&line, &line, &line], &mut values);
    (Volume::new([-half; 3], [n; 3], voxel, values).unwrap(), n)
}

/// The result, and the least seconds of processor time of seven runs, all threads together: others on the machine hardly matter.
fn best<T>(mut f: impl FnMut() -> T) -> (T, f64) {
    let mut time = f64::INFINITY;
    let mut last = None;
    for _ in 0..7 {
        let start = processor_seconds();
        last = Some(f());
        time = time.min(processor_seconds() - start);
    }
    (last.unwrap(), time)
}

fn processor_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux, which counts processor time");
    let of = |task: std::fs::DirEntry| std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
    let nanoseconds = |text: String| text.split(' ').next().and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0);
    tasks.flatten().map(|t| 1e-9 * nanoseconds(of(t))).sum()
}

fn report(name: &str, solid: &Solid, time: f64, volume: f64) {
    let (t, q) = (solid.topology(), solid.quality());
    println!(
        "| {name} | {} | {:.2} | {:.2} | {:.3} | {:.2} % | {} | {:.4} % |",
        t.triangles,
        1e3 * time,
        1e-6 * t.triangles as f64 / time,
        q.mean,
        100.0 * q.slivers,
        t.open_edges + t.bad_edges + t.pinched_vertices,
        100.0 * (solid.volume() / volume - 1.0)
    );
}

fn main() {
    rayon_of_one();
    let limits = Limits::default();
    let blobs: Vec<Primitive> = (0..200u64)
        .map(|i| {
            let at = |k: u64| (eyot_core::rng::mix64(31 * i + k) >> 40) as f32 / (1u64 << 24) as f32 * 1.8 - 0.9;
            Primitive::cylinder([at(0), at(1), at(2)], [at(3), at(4), at(5)].map(|v| 0.9 * v), 0.05)
        })
        .collect();
    let blobs = Blobs::new(&blobs, Kernel::Muraki, Blend::Normalised, &limits).unwrap();
    let gyroid = |[x, y, z]: Point| {
        let [x, y, z] = [7.0 * x, 7.0 * y, 7.0 * z];
        let g = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
        // Within a ball.
        (0.7 - g.abs()).min(4.0 * (1.0 - (x * x + y * y + z * z).sqrt() / 7.0))
    };
    let fields: [(&str, Box<dyn ScalarField>); 3] = [
        ("ball", Box::new(Of(|[x, y, z]| 1.0 - (x * x + y * y + z * z).sqrt()))),
        ("gyroid", Box::new(Of(gyroid))),
        ("200 cylinders", Box::new(blobs)),
    ];
    for (name, field) in &fields {
        let voxel = 0.02;
        let (volume_values, n) = sampled(field.as_ref(), 1.3, voxel);
        let low = -((n / 2) as f32) * voxel;
        let lattice = Lattice::over([-1.3; 3], [1.3; 3], voxel, &limits).unwrap();
        let fine = Lattice::over([-1.3; 3], [1.3; 3], 0.25 * voxel, &limits).unwrap();
        let volume = mesh_field(field.as_ref(), &fine, &MeshingOptions { rounds: 1 }, &limits).unwrap().volume();
        println!("\n{name}, {} points\n| mesher | triangles | ms | M triangles/s | evenness | slivers | flaws | volume |", n.pow(3));
        println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
        let shape = RuntimeShape::<u32, 3>::new([n as u32; 3]);
        assert_eq!(shape.size() as usize, volume_values.values().len());
        let inverted: Vec<f32> = volume_values.values().iter().map(|v| -v).collect();
        let mut buffer = SurfaceNetsBuffer::default();
        let ((), time) = best(|| surface_nets(&inverted, &shape, [0; 3], [n as u32 - 1; 3], &mut buffer));
        let solid = Solid {
            positions: buffer.positions.iter().map(|p| p.map(|v| low + v * voxel)).collect(),
            normals: buffer.normals.clone(),
            indices: buffer.indices.clone(),
        };
        report("fast-surface-nets, values given", &solid, time, volume);
        let run = |field: &dyn ScalarField, lattice: &Lattice, rounds: u32| {
            best(|| mesh_field(field, lattice, &MeshingOptions { rounds }, &limits).unwrap())
        };
        for rounds in [0, 1] {
            let (solid, time) = run(&volume_values, &volume_values.lattice(&limits).unwrap(), rounds);
            report(&format!("Eyot, values given, {rounds} rounds"), &solid, time, volume);
        }
        for rounds in [0, 1, 2] {
            let (solid, time) = run(field.as_ref(), &lattice, rounds);
            report(&format!("Eyot, field, {rounds} rounds"), &solid, time, volume);
        }
        let ((), time) = best(|| drop(sampled(field.as_ref(), 1.3, voxel)));
        println!("sampling all points takes {:.2} ms", 1e3 * time);
    }
}

/// One thread: the other crate has no more.
fn rayon_of_one() {
    // SAFETY is not asked for: the pool reads the variable before any thread is there.
    if std::env::var_os("RAYON_NUM_THREADS").is_none() {
        println!("set RAYON_NUM_THREADS=1 to compare on one thread");
    }
}
