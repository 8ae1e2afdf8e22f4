//! Bodies from fields: closed, manifold, as exact as the lattice allows, the same bytes however they are made.

use eyot_core::Limits;
use eyot_core::rng::mix64;
use eyot_mesh::{
    Blend, Blobs, Error, Kernel, Lattice, MeshingOptions, Point, Primitive, Remesher, ScalarField, Solid, Volume,
    Within, mesh_field, solid_levels,
};

struct Of<F: Fn(Point) -> f32 + Sync>(F);

impl<F: Fn(Point) -> f32 + Sync> ScalarField for Of<F> {
    fn value(&self, p: Point) -> f32 {
        (self.0)(p)
    }
}

fn mesh(field: &dyn ScalarField, low: Point, high: Point, voxel: f32, rounds: u32) -> Solid {
    let limits = Limits::default();
    let lattice = Lattice::over(low, high, voxel, &limits).unwrap();
    mesh_field(field, &lattice, &MeshingOptions { rounds }, &limits).unwrap()
}

fn length(p: Point) -> f32 {
    (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt()
}

fn ball(p: Point) -> f32 {
    1.0 - length(p)
}

/// M1: closed, one piece without handles, no degenerate triangles, every triangle looks outwards, second order in volume.
#[test]
fn a_ball_is_exact_to_second_order() {
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    for rounds in [0, 3] {
        let error = |n: u32| {
            let solid = mesh(&Of(ball), [-1.4; 3], [1.4; 3], 2.8 / n as f32, rounds);
            let t = solid.topology();
            assert!(t.is_closed_manifold() && t.euler() == 2 && t.pieces == 1, "{t:?}");
            for (p, n) in solid.positions.iter().zip(&solid.normals) {
                assert!((0..3).all(|i| (p[i] / length(*p) - n[i]).abs() < 1e-2), "{p:?} {n:?}");
            }
            let degenerate = solid.indices.chunks_exact(3).filter(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| solid.positions[i as usize].map(f64::from));
                let edge = |to: [f64; 3]| [0, 1, 2].map(|i| to[i] - a[i]);
                let (u, v) = (edge(b), edge(c));
                let cross = [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
                let outwards: f64 = (0..3).map(|i| cross[i] * (a[i] + b[i] + c[i])).sum();
                assert!(outwards >= 0.0, "a triangle looks inwards");
                outwards == 0.0
            });
            let degenerate = degenerate.count();
            assert!(1000 * degenerate <= solid.triangles(), "{degenerate} of {} are degenerate", solid.triangles());
            1.0 - solid.volume() / exact
        };
        let errors = [16, 32, 64, 128].map(error);
        // A radius of 22.4 voxels: 64 points across the ball and what is left of a box around it.
        assert!(errors[2] > 0.0 && errors[2] < if rounds == 0 { 0.0012 } else { 0.0008 }, "{errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((1.8..2.2).contains(&order), "{order} {errors:?}");
        }
    }
}

#[test]
fn relaxed_triangles_are_even() {
    let bodies: [(&str, Box<dyn ScalarField>); 4] = [
        ("ball", Box::new(Of(ball))),
        (
            "gyroid",
            Box::new(Of(|[x, y, z]| {
                let [x, y, z] = [5.0 * x, 5.0 * y, 5.0 * z];
                x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos() + 0.3
            })),
        ),
        ("torus", Box::new(Of(|[x, y, z]| 0.3 - length([(x * x + y * y).sqrt() - 0.9, z, 0.0])))),
        ("blobs", Box::new(blobs(60, 7, Blend::Normalised))),
    ];
    for (name, field) in &bodies {
        for rounds in [0, 1, 2] {
            let solid = mesh(field.as_ref(), [-1.5; 3], [1.5; 3], 0.05, rounds);
            let (q, t) = (solid.quality(), solid.topology());
            assert!(t.is_closed_manifold(), "{name}: {t:?}");
            // Plain marching cubes have slivers; one round is enough.
            assert!(if rounds == 0 { q.slivers > 0.05 } else { q.slivers < 0.002 && q.mean > 0.85 }, "{name}: {q:?}");
        }
    }
}

fn unit(seed: u64) -> f32 {
    (mix64(seed) >> 40) as f32 / (1u64 << 24) as f32
}

fn blobs(n: u64, seed: u64, blend: Blend) -> Blobs {
    let primitives: Vec<Primitive> = (0..n)
        .map(|i| {
            let at = |k: u64| 2.0 * unit(mix64(seed) ^ (100 * i + k)) - 1.0;
            let (a, b) = ([at(0), at(1), at(2)], [at(3), at(4), at(5)]);
            let b = [0, 1, 2].map(|i| a[i] + 0.4 * b[i]);
            let r = 0.12 + 0.05 * at(6);
            match i % 3 {
                0 => Primitive::ball(a, r),
                1 => Primitive::cylinder(a, b, r),
                _ => Primitive::cone(a, b, [r, 0.5 * r]),
            }
        })
        .collect();
    Blobs::new(&primitives, Kernel::Muraki, blend, &Limits::default()).unwrap()
}

/// Random numbers at the points of a small lattice, outside everywhere else.
struct Noise {
    seed: u64,
    n: i32,
    voxel: f32,
    values: &'static [f32],
}

impl ScalarField for Noise {
    fn value(&self, p: Point) -> f32 {
        let i = p.map(|v| (v / self.voxel).round() as i32);
        if i.iter().any(|&v| v < 0 || v >= self.n) {
            return -1.0;
        }
        let at = (i[2] * self.n + i[1]) * self.n + i[0];
        self.values[(mix64(self.seed ^ (at as u64 * 0x9e37)) % self.values.len() as u64) as usize]
    }
}

/// M1: all 256 sets of corners, and random ones.
#[test]
fn any_signs_and_any_saddles_close() {
    // All sets of corners of a single cell, with values that turn the saddles of its faces both ways.
    for inside in 0..256u64 {
        for magnitudes in 0..12u64 {
            let value = |c: u64| {
                let size = [1.0, 0.2, 3.0][(mix64(magnitudes << 8 | c) % 3) as usize];
                if inside >> c & 1 == 1 { size } else { -size }
            };
            let field = Of(move |p: Point| {
                let i = p.map(|v| v.round() as i32);
                if i.iter().all(|v| (0..2).contains(v)) { value((i[0] + 2 * i[1] + 4 * i[2]) as u64) } else { -1.0 }
            });
            let t = mesh(&field, [-1.0; 3], [2.0; 3], 1.0, 0).topology();
            assert!(t.is_closed_manifold() && t.euler() >= 2 * t.pieces as i64 - 8, "{inside} {magnitudes}: {t:?}");
            assert_eq!(t.pieces == 0, inside == 0);
        }
    }
    // Random 3^3 grids and larger ones across the seams of blocks, with values that are often 0 exactly, or equal.
    let kinds: [&[f32]; 3] = [&[-1.0, 1.0], &[-1.0, 0.0, 1.0], &[-2.0, -0.5, 0.0, 1e-30, 0.25, 3.0]];
    for seed in 0..3000u64 {
        let values = kinds[(seed % 3) as usize];
        let n = if seed % 100 == 0 { 21 } else { 3 };
        let field = Noise { seed, n, voxel: 1.0, values };
        let solid = mesh(&field, [-1.0; 3], [n as f32; 3], 1.0, (seed % 2) as u32);
        let t = solid.topology();
        assert!(t.is_closed_manifold(), "{seed}: {t:?}");
        assert!(seed % 2 == 1 || solid.volume() >= 0.0, "{seed}: inside out");
    }
}

/// M2: a mesh made in blocks is the mesh made whole.
#[test]
fn threads_and_blocks_change_nothing() {
    let field = blobs(200, 3, Blend::Normalised);
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mesh(&field, [-1.6; 3], [1.6; 3], 0.04, 2))
    };
    let one = make(1);
    assert!(one.triangles() > 20_000 && one.topology().is_closed_manifold());
    assert!(one == make(2) && one == make(7));
    // The part of a block has the bits of the whole: a field that never says what is near gives the same bytes.
    let whole = Of(|p| field.value(p));
    let plain = |f: &dyn ScalarField| mesh(f, [-1.6; 3], [1.6; 3], 0.04, 0);
    let (a, b) = (plain(&field), plain(&whole));
    assert!(a.positions == b.positions && a.indices == b.indices, "seams are exact bit by bit");
}

#[test]
fn what_changed_alone_is_meshed_again_with_the_same_bytes() {
    let limits = Limits::default();
    let lattice = Lattice::over([-1.6; 3], [1.6; 3], 0.03, &limits).unwrap();
    let options = MeshingOptions::default();
    let mut remesher = Remesher::new(lattice, options);
    let primitive = |i: u64, grown: f32| {
        let at = |k: u64| 2.4 * unit(100 * i + k) - 1.2;
        Primitive::ball([at(0), at(1), at(2)], if i == 5 { 0.15 * grown } else { 0.15 })
    };
    for (step, grown) in [1.0, 1.0, 1.3, 0.6].into_iter().enumerate() {
        // In the last step some are gone and one is new.
        let numbers = if step < 3 { 0..40u64 } else { 3..41 };
        let all: Vec<Primitive> = numbers.map(|i| primitive(i, grown)).collect();
        let field = Blobs::new(&all, Kernel::Wyvill, Blend::Normalised, &limits).unwrap();
        let update = remesher.update(&field, &limits).unwrap();
        match step {
            0 => assert_eq!(update.kept, 0),
            1 => assert_eq!(update.meshed, 0),
            2 => assert!(0 < update.meshed && 5 * update.meshed < update.kept, "{update:?}"),
            _ => assert!(0 < update.meshed && update.meshed < update.kept, "{update:?}"),
        }
        assert!(remesher.solid() == mesh_field(&field, &lattice, &options, &limits).unwrap(), "step {step}");
    }
}

#[test]
fn bodies_of_primitives_keep_their_size() {
    let limits = Limits::default();
    let ball_volume = 4.0 / 3.0 * std::f64::consts::PI * 0.5f64.powi(3);
    for kernel in Kernel::ALL {
        // Alone, a ball has its own radius with every kernel.
        let volume = |n: usize, blend: Blend| {
            let balls = vec![Primitive::ball([0.1, 0.0, 0.0], 0.5); n];
            let solid = mesh(&Blobs::new(&balls, kernel, blend, &limits).unwrap(), [-1.5; 3], [1.5; 3], 0.05, 1);
            assert!(solid.topology().is_closed_manifold());
            solid.volume() / ball_volume
        };
        assert!((volume(1, Blend::Sum) - 1.0).abs() < 0.01, "{kernel:?}");
        assert!((volume(1, Blend::Normalised) - 1.0).abs() < 0.01, "{kernel:?}");
        // Ten on top of each other: the sum swells, the other does not.
        assert!(volume(10, Blend::Sum) > 1.7, "{kernel:?}");
        assert!((volume(10, Blend::Normalised) - 1.0).abs() < 0.01, "{kernel:?}");
    }
    // Overlapping balls and cylinders, against the union of them by counting points.
    let field = blobs(60, 7, Blend::Normalised);
    let swollen = blobs(60, 7, Blend::Sum);
    let (a, b) =
        (mesh(&field, [-1.6; 3], [1.6; 3], 0.04, 1).volume(), mesh(&swollen, [-1.6; 3], [1.6; 3], 0.04, 1).volume());
    assert!(b > 1.05 * a, "{a} {b}");
}

#[test]
fn gradients_are_those_of_the_values() {
    for kernel in Kernel::ALL {
        for blend in [Blend::Sum, Blend::Normalised] {
            let shapes = [
                Primitive::ball([0.0; 3], 0.5),
                Primitive::cylinder([0.2, 0.1, 0.0], [0.9, 0.3, 0.2], 0.3),
                Primitive::cone([0.0, 0.3, 0.1], [0.1, 1.0, 0.0], [0.4, 0.15]),
            ];
            let field = Blobs::new(&shapes, kernel, blend, &Limits::default()).unwrap();
            for i in 0..300u64 {
                let p: Point = [0u64, 1, 2].map(|k| 1.6 * unit(10 * i + k) - 0.4);
                let (value, gradient) = field.slope(p, 0.1);
                assert_eq!(value, field.value(p));
                let central = Of(|p| field.value(p)).slope(p, 0.02).1;
                let off = (0..3).map(|k| (gradient[k] - central[k]).abs()).fold(0.0, f32::max);
                // Kernels have kinks in their second derivatives.
                assert!(off < 0.05 * (1.0 + length(gradient)), "{kernel:?} {blend:?} {p:?}: {gradient:?} {central:?}");
            }
        }
    }
}

#[test]
fn many_points_at_once_have_the_bits_of_one() {
    for kernel in Kernel::ALL {
        for blend in [Blend::Sum, Blend::Normalised] {
            let cones: Vec<Primitive> = (0..40)
                .map(|i| {
                    let at = |k: u64| 2.0 * unit(100 * i + k) - 1.0;
                    let (a, b) = ([at(0), at(1), at(2)], [at(3), at(4), at(5)]);
                    match i % 3 {
                        0 => Primitive::ball(a, 0.2),
                        1 => Primitive::cylinder(a, b, 0.15),
                        _ => Primitive::cone(a, b, [0.2, 0.05]),
                    }
                })
                .collect();
            let field = Blobs::new(&cones, kernel, blend, &Limits::default()).unwrap();
            let Within::Part(part) = field.within([-2.0; 3], [2.0; 3]) else { panic!("there is something") };
            // 17 and 21 are no multiples of the lanes.
            let line = |n: usize, step: f32| -> Vec<f32> { (0..n).map(|i| step * i as f32 - 1.3).collect() };
            let (xs, ys, zs) = (line(21, 0.13), line(17, 0.151), line(5, 0.55));
            let mut values = vec![f32::NAN; xs.len() * ys.len() * zs.len()];
            part.fill([&xs, &ys, &zs], &mut values);
            let points: Vec<Point> = zs
                .iter()
                .flat_map(|&z| ys.iter().map(move |&y| (y, z)))
                .flat_map(|(y, z)| xs.iter().map(move |&x| [x, y, z]))
                .collect();
            assert!(points.iter().zip(&values).all(|(&p, v)| field.value(p).to_bits() == v.to_bits()), "{kernel:?}");
            let mut slopes = vec![(f32::NAN, [0.0; 3]); points.len()];
            part.slopes(&points, 0.1, &mut slopes);
            assert!(points.iter().zip(&slopes).all(|(&p, s)| field.slope(p, 0.1) == *s), "{kernel:?} {blend:?}");
            assert!(points.iter().zip(&slopes).all(|(&p, s)| field.value(p) == s.0), "{kernel:?} {blend:?}");
        }
    }
}

#[test]
fn given_values_make_the_body_of_their_field() {
    let (limits, voxel) = (Limits::default(), 0.05);
    let field = blobs(60, 7, Blend::Normalised);
    let half = 33;
    let line: Vec<f32> = (-half..=half).map(|i| i as f32 * voxel).collect();
    let mut values = vec![0.0; line.len().pow(3)];
    field.fill([&line, &line, &line], &mut values);
    let volume = Volume::new([-half; 3], [line.len(); 3], voxel, values).unwrap();
    let lattice = volume.lattice(&limits).unwrap();
    let plain = |field: &dyn ScalarField, rounds: u32| {
        mesh_field(field, &lattice, &MeshingOptions { rounds }, &limits).unwrap()
    };
    let (given, own) = (plain(&volume, 0), plain(&field, 0));
    assert!(given.triangles() > 10_000 && given.positions == own.positions && given.indices == own.indices);
    let along: Vec<f32> =
        given.normals.iter().zip(&own.normals).map(|(a, b)| (0..3).map(|i| a[i] * b[i]).sum()).collect();
    assert!(along.iter().filter(|d| **d > 0.7).count() as f32 > 0.9 * along.len() as f32);
    let relaxed = plain(&volume, 1);
    let ratio = relaxed.volume() / own.volume();
    assert!(relaxed.topology().is_closed_manifold());
    assert!(relaxed.quality().slivers < 0.01, "{:?}", relaxed.quality());
    // Newton's steps on trilinear patches cut the corners of coarse voxels.
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    // Between the points and beyond them.
    let point = [0.31, -0.22, 0.17];
    let (value, gradient) = volume.slope(point, voxel);
    let central = Of(|p| volume.value(p)).slope(point, 0.1 * voxel).1;
    assert_eq!(value, volume.value(point));
    assert!(
        (0..3).all(|i| (gradient[i] - central[i]).abs() < 0.02 * (1.0 + length(gradient))),
        "{gradient:?} {central:?}"
    );
    assert_eq!(volume.value([9.0, 0.0, 0.0]), volume.value([half as f32 * voxel, 0.0, 0.0]));
    // A body that fills it all is closed by the outermost points.
    let full = Volume::new([2; 3], [21; 3], 0.1, vec![1.0; 9261]).unwrap();
    let solid = mesh_field(&full, &full.lattice(&limits).unwrap(), &MeshingOptions::default(), &limits).unwrap();
    assert!(solid.topology().is_closed_manifold() && (solid.volume() - 8.0).abs() < 0.4, "{}", solid.volume());
    for (size, n) in [([3, 3, 3], 26), ([1, 4, 4], 16), ([1 << 23, 1, 1], 1 << 23)] {
        let e = Volume::new([0; 3], size, 1.0, vec![0.0; n]).map(|_| ()).unwrap_err().to_string();
        assert!(e.contains("values; it needs one each"), "{e}");
    }
    assert!(Volume::new([0; 3], [2; 3], f32::NAN, vec![0.0; 8]).is_err());
}

#[test]
fn triangles_are_shaded_from_their_own_side() {
    // Twigs hardly thicker than a voxel, with sharp crotches.
    let twigs: Vec<Primitive> = (0..60u64)
        .map(|i| {
            let at = |k: u64| 2.0 * unit(100 * i + k) - 1.0;
            Primitive::cone([0.0, -0.8, 0.0], [at(0), 0.5 + 0.5 * at(1), at(2)], [0.07, 0.05])
        })
        .collect();
    let field = Blobs::new(&twigs, Kernel::Muraki, Blend::Normalised, &Limits::default()).unwrap();
    let solid = mesh(&field, [-1.4; 3], [1.4; 3], 0.055, 1);
    let against = solid.indices.chunks_exact(3).zip(solid.corners()).filter(|(t, [a, b, c])| {
        let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        let face = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let shade = |i: usize| t.iter().map(|&n| solid.normals[n as usize][i]).sum::<f32>();
        (0..3).map(|i| face[i] * shade(i)).sum::<f32>() <= 0.0
    });
    let share = against.count() as f32 / solid.triangles() as f32;
    assert!(solid.triangles() > 5_000 && share < 0.005, "{share} of {}", solid.triangles());
}

#[test]
fn bad_input_is_refused_with_a_reason() {
    let limits = Limits::default();
    let lattice =
        |low, high, voxel| Lattice::over([low; 3], [high; 3], voxel, &limits).map(|_| ()).unwrap_err().to_string();
    assert!(lattice(0.0, 1.0, f32::NAN).contains("finite numbers"));
    assert!(lattice(0.0, 1.0, 0.0).contains("longer than 0"));
    assert!(lattice(1.0, 1.0, 0.1).contains("empty"));
    assert!(lattice(0.0, 1e9, 1e-3).contains("a million voxels"));
    assert!(lattice(0.0, 1e5, 1.0).contains("choose a longer voxel"));
    let bad =
        [Primitive::ball([0.0; 3], f32::NAN), Primitive::ball([0.0; 3], 0.0), Primitive::ball([f32::INFINITY; 3], 1.0)];
    for p in bad {
        let all = [Primitive::ball([0.0; 3], 1.0), p];
        let e = Blobs::new(&all, Kernel::Muraki, Blend::Sum, &limits).map(|_| ()).unwrap_err();
        assert!(e.to_string().contains("primitive 1"), "{e}");
    }
    let box_of = Lattice::over([-1.0; 3], [1.0; 3], 0.1, &limits).unwrap();
    let options = MeshingOptions::default();
    let holed = Of(|p| if length(p) < 0.2 { f32::NAN } else { ball(p) });
    assert!(matches!(mesh_field(&holed, &box_of, &options, &limits), Err(Error::FieldNotFinite { .. })));
    let few = Limits { max_vertices: 100, ..limits };
    assert!(mesh_field(&Of(ball), &box_of, &options, &few).unwrap_err().to_string().contains("100 vertices"));
    // Nothing inside, or nothing but inside: no triangle, or the box.
    assert_eq!(mesh(&Of(|_| -1.0), [-1.0; 3], [1.0; 3], 0.1, 1), Solid::default());
    let full = mesh(&Of(|_| 1.0), [-1.0; 3], [1.0; 3], 0.1, 1);
    assert!(full.topology().is_closed_manifold() && full.topology().euler() == 2);
    assert!((full.volume() - 8.0).abs() < 0.2, "{}", full.volume());
    assert!(Blobs::new(&[], Kernel::Muraki, Blend::Sum, &limits).unwrap().bounds().is_none());

    /// Says of the lower half that it holds nothing.
    struct Liar;
    impl ScalarField for Liar {
        fn value(&self, p: Point) -> f32 {
            ball(p)
        }
        fn within(&self, _low: Point, high: Point) -> Within<'_> {
            if high[0] < 0.3 { Within::Nothing } else { Within::Whole }
        }
    }
    let lattice = Lattice::over([-1.5; 3], [1.5; 3], 0.05, &limits).unwrap();
    assert!(matches!(mesh_field(&Liar, &lattice, &options, &limits), Err(Error::FieldOverlooked { .. })));
}

#[test]
fn surfaces_through_lattice_points_and_across_the_border_close() {
    // A cube whose faces, edges and corners lie on lattice points; a ball that touches them; an octahedron.
    let bodies: [(&str, Box<dyn ScalarField>, f64); 3] = [
        ("cube", Box::new(Of(|p| 0.5 - p.iter().fold(0.0f32, |m, v| m.max(v.abs())))), 1.0),
        ("ball", Box::new(Of(|p| 0.5 - length(p))), std::f64::consts::FRAC_PI_6),
        ("octahedron", Box::new(Of(|p| 0.5 - p.iter().map(|v| v.abs()).sum::<f32>())), 1.0 / 6.0),
    ];
    for (name, field, volume) in &bodies {
        for rounds in [0, 1] {
            let solid = mesh(field.as_ref(), [-1.0; 3], [1.0; 3], 0.0625, rounds);
            let t = solid.topology();
            assert!(t.is_closed_manifold() && t.euler() == 2, "{name} {rounds}: {t:?}");
            assert!((solid.volume() / volume - 1.0).abs() < 0.06, "{name} {rounds}: {}", solid.volume());
            assert!(solid.normals.iter().all(|n| (length(*n) - 1.0).abs() < 1e-4));
        }
    }
    // Half a ball, cut by the box.
    let half = mesh(&Of(ball), [-1.5, 0.0, -1.5], [1.5; 3], 0.05, 1);
    assert!(half.topology().is_closed_manifold() && half.topology().euler() == 2);
    assert!((half.volume() / 2.0944 - 1.0).abs() < 0.01, "{}", half.volume());
    assert!(half.positions.iter().all(|p| p[1] > -0.01));
}

#[test]
fn coarser_levels_stay_closed() {
    for (seed, voxel) in [(1, 0.05), (2, 0.04), (9, 0.06)] {
        let solid = mesh(&blobs(50, seed, Blend::Normalised), [-1.6; 3], [1.6; 3], voxel, 1);
        let full = solid.topology();
        let levels = solid_levels(&solid, &[0.5, 0.25, 0.1]);
        assert!(levels.len() >= 2, "{} levels of {full:?}", levels.len());
        for l in &levels {
            let t = l.solid.topology();
            assert!(t.is_closed_manifold() && (1..=full.pieces).contains(&t.pieces), "{t:?}");
            assert_eq!(l.vertices.len(), l.solid.positions.len());
            assert!(l.vertices.iter().zip(&l.solid.positions).all(|(&i, p)| solid.positions[i as usize] == *p));
            // Collapses cut corners, the more of them the more.
            assert!(
                (l.solid.volume() / solid.volume() - 1.0).abs() < 0.05 / l.ratio,
                "{} {}",
                l.ratio,
                l.solid.volume()
            );
        }
    }
    assert!(solid_levels(&Solid::default(), &[0.5]).is_empty());
}

#[test]
fn a_gyroid_is_one_sheet_and_the_largest_piece_is_found() {
    let two = Of(|[x, y, z]| ball([x, y, z]).max(0.3 - length([x - 2.0, y, z])));
    let both = mesh(&two, [-1.5, -1.5, -1.5], [2.6, 1.5, 1.5], 0.1, 1);
    assert_eq!(both.topology().pieces, 2);
    let one = both.clone().largest_piece();
    assert_eq!((one.topology().pieces, one.topology().euler()), (1, 2));
    assert!(one.triangles() < both.triangles() && one.positions.iter().all(|p| p[0] < 1.1));
    assert_eq!(one.clone().largest_piece(), one);
}
