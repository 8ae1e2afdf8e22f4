//! Meshes the same fields with Eyot, with `fast-surface-nets` and with `fidget`, one after the other, and prints time, triangles,
//! evenness, holes and errors.
//!
//! `cargo run --release -- THREADS` in this folder; Eyot and `fidget` use so many, `fast-surface-nets` has one. Times are the
//! best of seven by the clock, and of processor time.

use eyot_core::Limits;
use eyot_mesh::{
    Blend, Blobs, Kernel, Lattice, MeshingOptions, Point, Primitive, ScalarField, Solid, Volume, mesh_field,
};
use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use fidget::context::Tree;
use fidget::jit::JitShape;
use fidget::mesh::{Octree, Settings};
use fidget::render::ThreadPool;
use std::time::Instant;

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

/// The result, and the least seconds of seven runs: by the clock, and of processor time, all threads together, in which
/// others on the machine hardly matter.
fn best<T>(mut f: impl FnMut() -> T) -> (T, [f64; 2]) {
    let mut times = [f64::INFINITY; 2];
    let mut last = None;
    for _ in 0..7 {
        let (start, busy) = (Instant::now(), processor_seconds());
        last = Some(f());
        times[0] = times[0].min(start.elapsed().as_secs_f64());
        times[1] = times[1].min(processor_seconds() - busy);
    }
    (last.unwrap(), times)
}

fn processor_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux, which counts processor time");
    let of = |task: std::fs::DirEntry| std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
    let nanoseconds = |text: String| text.split(' ').next().and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0);
    tasks.flatten().map(|t| 1e-9 * nanoseconds(of(t))).sum()
}

fn report(name: &str, solid: &Solid, [clock, busy]: [f64; 2], volume: f64) {
    let (t, q) = (solid.topology(), solid.quality());
    println!(
        "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.3} | {:.2} % | {} | {:.4} % |",
        t.triangles,
        1e3 * clock,
        1e3 * busy,
        1e-6 * t.triangles as f64 / clock,
        q.mean,
        100.0 * q.slivers,
        t.open_edges + t.bad_edges + t.pinched_vertices,
        100.0 * (solid.volume() / volume - 1.0)
    );
}

/// Half the width of the cube in which everything lies: 128 voxels across, as many as `fidget` makes by halving.
const HALF: f32 = 1.28;
const DEPTH: u8 = 7;
const VOXEL: f32 = 2.0 * HALF / (1 << DEPTH) as f32;

/// A field, and the same for `fidget`, positive inside as well.
struct Case {
    name: &'static str,
    field: Box<dyn ScalarField>,
    tree: Tree,
}

fn length(p: [Tree; 3]) -> Tree {
    let [x, y, z] = p;
    (x.square() + y.square() + z.square()).sqrt()
}

fn ball() -> Case {
    let tree = Tree::from(1.0) - length([Tree::x(), Tree::y(), Tree::z()]);
    Case { name: "ball", field: Box::new(Of(|[x, y, z]| 1.0 - (x * x + y * y + z * z).sqrt())), tree }
}

/// Within a ball.
fn gyroid() -> Case {
    let field = |[x, y, z]: Point| {
        let [x, y, z] = [7.0 * x, 7.0 * y, 7.0 * z];
        let g = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
        (0.7 - g.abs()).min(4.0 * (1.0 - (x * x + y * y + z * z).sqrt() / 7.0))
    };
    let [x, y, z] = [Tree::x() * 7.0, Tree::y() * 7.0, Tree::z() * 7.0];
    let g = x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
    let inside = (Tree::from(1.0) - length([x, y, z]) / 7.0) * 4.0;
    Case { name: "gyroid", field: Box::new(Of(field)), tree: (Tree::from(0.7) - g.abs()).min(inside) }
}

/// Branches of one thickness.
fn branches(name: &'static str, cylinders: &[(Point, Point, f32)]) -> Case {
    let primitives: Vec<Primitive> = cylinders.iter().map(|&(a, b, r)| Primitive::cylinder(a, b, r)).collect();
    let field = Blobs::new(&primitives, Kernel::Muraki, Blend::Normalised, &Limits::default()).unwrap();
    let (mut sum, mut ninth) = (Tree::from(0.0), Tree::from(0.0));
    for &(a, b, r) in cylinders {
        let reach = r / Kernel::Muraki.radius_of(0.5);
        let axis: Point = std::array::from_fn(|i| b[i] - a[i]);
        let length2 = axis.iter().map(|v| v * v).sum::<f32>();
        let to = [Tree::x() - a[0], Tree::y() - a[1], Tree::z() - a[2]];
        let along = to.iter().zip(axis).fold(Tree::from(0.0), |sum, (t, v)| sum + t.clone() * v);
        let t = (along * (1.0 / length2)).max(0.0).min(1.0);
        let [dx, dy, dz] = [0, 1, 2].map(|i| to[i].clone() - t.clone() * axis[i]);
        let depth = (Tree::from(1.0) - (dx.square() + dy.square() + dz.square()) * (1.0 / (reach * reach))).max(0.0);
        let k = depth.square();
        ninth = ninth + k.square().square().square() * k.clone();
        sum = sum + k;
    }
    let tree = (ninth / sum.max(1e-9)).sqrt().sqrt().sqrt() - 0.5;
    Case { name, field: Box::new(field), tree }
}

/// Cylinders at random, one through the other.
fn heap() -> Case {
    let cylinders: Vec<_> = (0..200u64)
        .map(|i| {
            let at = |k: u64| (eyot_core::rng::mix64(31 * i + k) >> 40) as f32 / (1u64 << 24) as f32 * 1.8 - 0.9;
            ([at(0), at(1), at(2)], [at(3), at(4), at(5)].map(|v| 0.9 * v), 0.05)
        })
        .collect();
    branches("200 cylinders", &cylinders)
}

/// Branches that fork from one foot, as a coral's.
fn coral() -> Case {
    let mut cylinders = Vec::new();
    let mut tips: Vec<(Point, Point)> = vec![([0.0, -0.9, 0.0], [0.0, 1.0, 0.0])];
    for generation in 0..6u64 {
        let mut next = Vec::new();
        for (i, (from, way)) in tips.iter().enumerate() {
            for side in 0..2 {
                let number = 1000 * generation + 10 * i as u64 + side;
                let at = |k: u64| (eyot_core::rng::mix64(7 * number + k) >> 40) as f32 / (1u64 << 24) as f32 - 0.5;
                let lean = 1.4;
                let way: Point = [way[0] + lean * at(0), (way[1] + lean * at(1)).max(0.1), way[2] + lean * at(2)];
                let scale = 0.3 * 0.97f32.powi(generation as i32) / way.iter().map(|v| v * v).sum::<f32>().sqrt();
                let to = [0, 1, 2].map(|i| from[i] + scale * way[i]);
                cylinders.push((*from, to, 0.045));
                next.push((to, way));
            }
        }
        tips = next;
    }
    branches("coral of 126 branches", &cylinders)
}

/// What `fidget` makes of a field: octree and mesh.
fn fidget_mesh(shape: &JitShape, pool: Option<&ThreadPool>) -> fidget::mesh::Mesh {
    let bound = shape.clone().try_into().expect("x, y and z alone");
    let settings = Settings { depth: DEPTH, threads: pool, ..Default::default() };
    Octree::build(&bound, &settings).expect("nobody cancels").walk_dual()
}

fn main() {
    let threads: usize = std::env::args().nth(1).map_or(1, |n| n.parse().expect("a number of threads"));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| run(threads));
}

fn run(threads: usize) {
    let limits = Limits::default();
    let theirs = match threads {
        1 => None,
        n => Some(ThreadPool::Custom(rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads"))),
    };
    for Case { name, field, tree } in [ball(), gyroid(), heap(), coral()] {
        let field = field.as_ref();
        let lattice = |voxel: f32| Lattice::over([-1.26; 3], [1.26; 3], voxel, &limits).unwrap();
        let mesh = |field: &dyn ScalarField, lattice: &Lattice, rounds: u32| {
            mesh_field(field, lattice, &MeshingOptions { rounds }, &limits).unwrap()
        };
        let volume = mesh(field, &lattice(0.25 * VOXEL), 1).volume();
        let (values, n) = sampled(field, HALF, VOXEL);
        println!("\n{name}, {} points, {threads} threads", n.pow(3));
        println!(
            "| mesher | triangles | ms | ms of processors | M triangles/s | evenness | slivers | flaws | volume |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
        let shape = RuntimeShape::<u32, 3>::new([n as u32; 3]);
        assert_eq!(shape.size() as usize, values.values().len());
        let inverted: Vec<f32> = values.values().iter().map(|v| -v).collect();
        let mut buffer = SurfaceNetsBuffer::default();
        let ((), time) = best(|| surface_nets(&inverted, &shape, [0; 3], [n as u32 - 1; 3], &mut buffer));
        let low = -((n / 2) as f32) * VOXEL;
        let solid = Solid {
            positions: buffer.positions.iter().map(|p| p.map(|v| low + v * VOXEL)).collect(),
            normals: buffer.normals.clone(),
            indices: buffer.indices.clone(),
        };
        report("fast-surface-nets, values given", &solid, time, volume);
        let given = values.lattice(&limits).unwrap();
        for rounds in [0, 1] {
            let (solid, time) = best(|| mesh(&values, &given, rounds));
            report(&format!("Eyot, values given, {rounds} rounds"), &solid, time, volume);
        }
        // It lies in a cube from -1 to 1 and is negative inside.
        let tree = Tree::from(0.0) - tree.remap_xyz(Tree::x() * HALF, Tree::y() * HALF, Tree::z() * HALF);
        let shape = JitShape::from(tree);
        let (found, time) = best(|| fidget_mesh(&shape, theirs.as_ref()));
        let solid = Solid {
            positions: found.vertices.iter().map(|p| [p.x * HALF, p.y * HALF, p.z * HALF]).collect(),
            normals: Vec::new(),
            indices: found.triangles.iter().flat_map(|t| [t.x as u32, t.y as u32, t.z as u32]).collect(),
        };
        report("fidget, field", &solid, time, volume);
        for rounds in [0, 1] {
            let (solid, time) = best(|| mesh(field, &lattice(VOXEL), rounds));
            report(&format!("Eyot, field, {rounds} rounds"), &solid, time, volume);
        }
        let (_, [clock, _]) = best(|| sampled(field, HALF, VOXEL));
        println!("sampling all points takes {:.2} ms", 1e3 * clock);
    }
}
