//! Meshes the same fields with Eyot and with `fast-surface-nets`, one after the other on one thread, and prints time, triangles,
//! evenness, holes and errors.
//!
//! `cargo run --release` in this folder. Times are the best of seven.

use eyot_core::Limits;
use eyot_mesh::{Blend, Blobs, Kernel, Lattice, MeshingOptions, Point, Primitive, ScalarField, Solid, mesh_field};
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use std::time::Instant;

struct Of(fn(Point) -> f32);

impl ScalarField for Of {
    fn value(&self, p: Point) -> f32 {
        (self.0)(p)
    }
}

/// Values that are already there, so that a run times the meshing alone.
struct Table {
    first: f32,
    voxel: f32,
    n: usize,
    values: Vec<f32>,
}

impl Table {
    fn new(field: &dyn ScalarField, reach: f32, voxel: f32) -> Self {
        let half = (reach / voxel).ceil() as i32 + 2;
        let n = (2 * half + 1) as usize;
        let first = -half as f32 * voxel;
        let at = |i: usize| (i as i32 - half) as f32 * voxel;
        let xs: Vec<f32> = (0..n).map(at).collect();
        let mut values = vec![0.0; n * n * n];
        for (row, v) in values.chunks_mut(n).enumerate() {
            field.row(&xs, at(row % n), at(row / n), v);
        }
        Self { first, voxel, n, values }
    }

    fn index(&self, v: f32) -> usize {
        (((v - self.first) / self.voxel).round().max(0.0) as usize).min(self.n - 1)
    }
}

impl ScalarField for Table {
    fn value(&self, p: Point) -> f32 {
        let [x, y, z] = p.map(|v| self.index(v));
        self.values[(z * self.n + y) * self.n + x]
    }

    fn row(&self, xs: &[f32], y: f32, z: f32, values: &mut [f32]) {
        let row = (self.index(z) * self.n + self.index(y)) * self.n;
        let first = self.index(xs[0]);
        for (i, v) in values.iter_mut().enumerate() {
            *v = self.values[row + (first + i).min(self.n - 1)];
        }
    }
}

fn best<T>(mut f: impl FnMut() -> T) -> (T, f64) {
    let mut time = f64::INFINITY;
    let mut last = None;
    for _ in 0..7 {
        let start = Instant::now();
        last = Some(f());
        time = time.min(start.elapsed().as_secs_f64());
    }
    (last.unwrap(), time)
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
        let table = Table::new(field.as_ref(), 1.3, voxel);
        let lattice = Lattice::over([-1.3; 3], [1.3; 3], voxel, &limits).unwrap();
        let fine = Lattice::over([-1.3; 3], [1.3; 3], 0.25 * voxel, &limits).unwrap();
        let volume = mesh_field(field.as_ref(), &fine, &MeshingOptions { rounds: 1 }, &limits).unwrap().volume();
        println!("\n{name}, {} points\n| mesher | triangles | ms | M triangles/s | evenness | slivers | flaws | volume |", table.n.pow(3));
        println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
        let shape = RuntimeShape::<u32, 3>::new([table.n as u32; 3]);
        assert_eq!(shape.size() as usize, table.values.len());
        let inverted: Vec<f32> = table.values.iter().map(|v| -v).collect();
        let mut buffer = SurfaceNetsBuffer::default();
        let ((), time) = best(|| surface_nets(&inverted, &shape, [0; 3], [table.n as u32 - 1; 3], &mut buffer));
        let solid = Solid {
            positions: buffer.positions.iter().map(|p| p.map(|v| table.first + v * voxel)).collect(),
            normals: buffer.normals.clone(),
            indices: buffer.indices.clone(),
        };
        report("fast-surface-nets, values given", &solid, time, volume);
        let run = |field: &dyn ScalarField, rounds: u32| best(|| mesh_field(field, &lattice, &MeshingOptions { rounds }, &limits).unwrap());
        let (solid, time) = run(&table, 0);
        report("Eyot, values given, not relaxed", &solid, time, volume);
        for rounds in [0, 1, 2] {
            let (solid, time) = run(field.as_ref(), rounds);
            report(&format!("Eyot, field, {rounds} rounds"), &solid, time, volume);
        }
        let ((), time) = best(|| drop(Table::new(field.as_ref(), 1.3, voxel)));
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
