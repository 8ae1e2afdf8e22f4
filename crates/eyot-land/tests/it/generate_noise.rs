//! Noise: range, spread, equal directions, the same bytes everywhere, the same land on every grid, no seams.
use crate::common;

use common::{grid, make, spread, structure};
use eyot_core::isa::Isa;
use eyot_core::process::Generator;
use eyot_core::{Boundary, Control, Field, Grid};
use eyot_land::generate::fractal::{Fractal, Octaves};
use eyot_land::generate::noise::{Basis, Noise, Sum};
use eyot_land::generate::{Fbm, Ridged, Warp};

const BASES: [Basis; 6] =
    [Basis::Simplex, Basis::Perlin, Basis::Value, Basis::WorleyF1, Basis::WorleyF2, Basis::WorleyF2F1];

fn field(noise: &Noise, grid: &Grid) -> Field {
    noise.field(grid, 0..grid.height, Isa::best(), &Control::none()).unwrap()
}

/// Hills of the default size.
fn fbm(noise: Octaves, warp: f32) -> Fbm {
    Fbm { fractal: Fractal { noise, warp, ..Fbm::default().fractal } }
}

/// Root of the mean squared difference of two fields.
fn distance(a: &Field, b: &Field) -> f64 {
    let n = (a.width() * a.height()) as f64;
    (a.iter().zip(b.iter()).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / n).sqrt()
}

#[test]
fn range_mean_and_spread() {
    let g = grid(1024, 1024, 1.0, Boundary::CLOSED);
    // Measured: deviation of one octave and of four, and of ridges their mean and deviation.
    for (basis, one, four, ridge) in
        [(Basis::Simplex, 0.539, 0.331, (0.266, 0.216)), (Basis::Perlin, 0.305, 0.188, (0.547, 0.197))]
    {
        for seed in 0..3 {
            let noise = Noise { basis, scale_m: 16.0, seed, ..Noise::default() };
            for (octaves, sum, mean, deviation) in
                [(1, Sum::Fbm, 0.0, one), (4, Sum::Fbm, 0.0, four), (4, Sum::Ridged(2.0), ridge.0, ridge.1)]
            {
                let f = field(&Noise { octaves, sum, ..noise.clone() }, &g);
                let (low, high) = f.min_max();
                let floor = if sum == Sum::Fbm { -1.0 } else { 0.0 };
                assert!(low >= floor && high <= 1.0, "{low} to {high}");
                if sum == Sum::Fbm && octaves == 1 {
                    assert!(low < -0.85 && high > 0.85, "{basis:?}: {low} to {high} leaves much of the range unused");
                }
                let (m, d) = spread(&f);
                println!("{basis:?} {octaves} {sum:?}: {low:.3} to {high:.3}, mean {m:.4}, deviation {d:.4}");
                assert!((m - mean).abs() < 0.015, "{basis:?} {octaves} {sum:?}: mean {m}");
                assert!((d - deviation).abs() < 0.015, "{basis:?} {octaves} {sum:?}: deviation {d}");
            }
        }
    }
}

#[test]
fn all_directions_are_alike() {
    let g = grid(768, 768, 1.0, Boundary::CLOSED);
    let wrap = Grid { rim: Boundary::WRAP, ..g };
    for basis in BASES {
        for (g, octaves) in [(g, 6), (wrap, 6), (g, 1)] {
            // Distance 5, 10, 20 in eight directions: along the axes and by (3, 4).
            for k in [1, 2, 4] {
                let directions = [(5, 0), (0, 5), (3, 4), (4, 3), (-3, 4), (-4, 3)];
                let mut of = [0.0; 6];
                for seed in 0..4 {
                    let f = field(&Noise { basis, octaves, scale_m: 24.0, seed, ..Noise::default() }, &g);
                    for (o, (dx, dy)) in of.iter_mut().zip(directions) {
                        *o += structure(&f, k * dx, k * dy);
                    }
                }
                let (low, high) = of.iter().fold((f64::MAX, 0f64), |(a, b), &v| (a.min(v), b.max(v)));
                println!("{basis:?} {octaves} octaves, {:?}, distance {}: {:.4}", g.rim.x, 5 * k, high / low);
                assert!(high / low < 1.06, "{basis:?}, distance {}: {of:?}", 5 * k);
            }
        }
    }
}

/// Cells where lattice lines would show: no row or column may have less variance than the others.
#[test]
fn no_row_or_column_stands_out() {
    for rim in [Boundary::CLOSED, Boundary::WRAP] {
        for basis in BASES {
            let (g, n) = (grid(256, 256, 1.0, rim), 256);
            let (mut rows, mut columns) = (vec![0.0; n], vec![0.0; n]);
            for seed in 0..24 {
                let f = field(&Noise { basis, scale_m: 32.0, seed, ..Noise::default() }, &g);
                for y in 0..n {
                    for x in 0..n {
                        let v = f64::from(f.get(x, y)).powi(2);
                        rows[y] += v;
                        columns[x] += v;
                    }
                }
            }
            for lines in [rows, columns] {
                let (low, high) = lines.iter().fold((f64::MAX, 0f64), |(a, b), &v| (a.min(v), b.max(v)));
                assert!(high / low < 1.9, "{basis:?} {rim:?}: {}", high / low);
            }
        }
    }
}

#[test]
fn the_same_bytes_for_all_isas_and_threads() {
    for rim in [
        Boundary::CLOSED,
        Boundary::WRAP,
        Boundary { x: eyot_core::BoundaryCondition::Wrap, y: eyot_core::BoundaryCondition::Open },
    ] {
        for basis in BASES {
            for (sum, warp_m) in [
                (Sum::Fbm, 0.0),
                (Sum::Ridged(2.0), 0.0),
                (Sum::Fbm, 90.0),
                (Sum::Ridged(3.0), 40.0),
                (Sum::Billow, 0.0),
            ] {
                let g = Grid { width: 541, height: 67, cell_x_m: 3.0, cell_y_m: 4.0, rim };
                let noise = Noise {
                    basis,
                    sum,
                    scale_m: 300.0,
                    octaves: if basis == Basis::Simplex { 12 } else { 3 },
                    seed: 5,
                    ..Noise::default()
                };
                let reference = noise.warped_field(warp_m, &g, 0..67, Isa::Scalar, &Control::none()).unwrap();
                for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
                    for threads in [1, 2, 3, 8] {
                        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                        let f = pool.install(|| noise.warped_field(warp_m, &g, 0..67, isa, &Control::none())).unwrap();
                        let same = f.iter().zip(reference.iter()).all(|(a, b)| a.to_bits() == b.to_bits());
                        assert!(same, "{basis:?} {sum:?} {rim:?} {} {threads} threads", isa.name());
                    }
                }
            }
        }
    }
}

#[test]
fn seeds_make_different_land() {
    let g = grid(256, 256, 1.0, Boundary::CLOSED);
    for basis in BASES {
        let fields: Vec<_> =
            [0, 1, 2, 1 << 40].map(|seed| field(&Noise { basis, scale_m: 16.0, seed, ..Noise::default() }, &g)).into();
        for (i, a) in fields.iter().enumerate() {
            for b in &fields[..i] {
                let ((mean_a, deviation_a), (mean_b, deviation_b)) = (spread(a), spread(b));
                let product = |(a, b): (f32, f32)| (f64::from(a) - mean_a) * (f64::from(b) - mean_b);
                let correlation =
                    a.iter().zip(b.iter()).map(product).sum::<f64>() / 65536.0 / (deviation_a * deviation_b);
                assert!(correlation.abs() < 0.1, "{correlation}");
            }
        }
    }
}

/// The mean of the 4x4 fine cells that lie in each coarse cell.
fn coarsened(f: &Field) -> Field {
    Field::from_fn(f.width() / 4, f.height() / 4, |x, y| {
        (0..16).map(|k| f.get(4 * x + k % 4, 4 * y + k / 4)).sum::<f32>() / 16.0
    })
}

#[test]
fn a_finer_grid_shows_the_same_land() {
    for rim in [Boundary::CLOSED, Boundary::WRAP] {
        let (coarse, fine) = (grid(256, 256, 40.0, rim), grid(1024, 1024, 10.0, rim));
        let (flat, flat_fine) = (Field::new(256, 256, 0.0), Field::new(1024, 1024, 0.0));
        let mut worst = 0f64;
        for basis in BASES {
            // The kinks of cellular noise are rounded off by the mean over cells (measured: 0.060 for ridges of F2 - F1).
            let most = if matches!(basis, Basis::Simplex | Basis::Perlin | Basis::Value) { 0.03 } else { 0.1 };
            let of = |octaves| Octaves { basis, octaves, ..Octaves::default() };
            let ridged = Ridged::default();
            let crests = Octaves { basis, ..ridged.fractal.noise.clone() };
            let generators: [&dyn Generator; 4] = [
                &fbm(of(8), 0.0),
                &fbm(of(12), 0.3),
                &Ridged { fractal: Fractal { noise: crests, ..ridged.fractal.clone() }, ..ridged },
                &fbm(Octaves { scale_m: 2000.0, lacunarity: 1.9, ..of(8) }, 0.0),
            ];
            for what in generators {
                let (a, b) = (make(what, &flat, coarse, 3), coarsened(&make(what, &flat_fine, fine, 3)));
                let relative = distance(&a, &b) / spread(&b).1;
                worst = worst.max(relative);
                assert!(relative < most, "{basis:?}: {relative}");
            }
            // A filter: its displacement is the same land, too.
            let fbm = fbm(of(5), 0.0);
            let warp = Warp { noise: of(3), ..Warp::default() };
            let a = make(&warp, &make(&fbm, &flat, coarse, 3), coarse, 4);
            let b = coarsened(&make(&warp, &make(&fbm, &flat_fine, fine, 3), fine, 4));
            let relative = distance(&a, &b) / spread(&b).1;
            worst = worst.max(relative);
            assert!(relative < most, "warp, {basis:?}: {relative}");
        }
        println!("{:?}: root mean square difference up to {worst:.4} of the relief", rim.x);
    }
}

/// First and second differences across the seam are like those elsewhere.
#[test]
fn wrapping_rims_have_no_seam() {
    let g = grid(256, 192, 10.0, Boundary::WRAP);
    for basis in BASES {
        for warp in [0.0, 0.5] {
            let noise = Octaves { basis, octaves: 4, ..Octaves::default() };
            let fbm = make(&fbm(noise, warp), &Field::new(256, 192, 0.0), g, 8);
            let warped = make(&Warp::default(), &fbm, g, 8);
            for f in [fbm, warped] {
                for along_x in [true, false] {
                    let (n, lines) = if along_x { (256, 192) } else { (192, 256) };
                    let at = |i: usize, line: usize| if along_x { f.get(i % n, line) } else { f.get(line, i % n) };
                    // Largest first and second difference of each step along the axis, over all lines.
                    let (mut first, mut second) = (vec![0f32; n], vec![0f32; n]);
                    for line in 0..lines {
                        for i in 0..n {
                            let (a, b, c) = (at(i, line), at(i + 1, line), at(i + 2, line));
                            first[i] = first[i].max((b - a).abs());
                            second[i] = second[i].max((a - 2.0 * b + c).abs());
                        }
                    }
                    for d in [first, second] {
                        let inside = d[..n - 2].iter().copied().fold(0.0, f32::max);
                        let seam = d[n - 2..].iter().copied().fold(0.0, f32::max);
                        assert!(seam <= 1.05 * inside, "{basis:?}: {seam} at the seam, {inside} inside");
                    }
                }
            }
        }
    }
}

/// Far from the origin of a large grid the noise is as smooth as near it: the twelfth octave alone, 16384 cells east.
#[test]
fn large_grids_lose_no_precision() {
    // The distances of cellular noise have kinks.
    for basis in [Basis::Simplex, Basis::Perlin, Basis::Value] {
        let g = grid(16384, 8, 1.0, Boundary::CLOSED);
        // Features of 64 cells and smooth: second differences are small, and rounding would dominate them.
        let noise = Noise { basis, octaves: 1, scale_m: 64.0, ..Noise::default() };
        let f = field(&noise, &g);
        let third = |x: usize| {
            (0..8)
                .map(|y| (f.get(x, y) - 3.0 * f.get(x + 1, y) + 3.0 * f.get(x + 2, y) - f.get(x + 3, y)).abs())
                .fold(0.0, f32::max)
        };
        let near = (0..4096).map(third).fold(0.0, f32::max);
        let far = (12288..16380).map(third).fold(0.0, f32::max);
        assert!(far < 1.5 * near && far < 1e-3, "{near:e} near, {far:e} far");
        // All twelve octaves: nothing blows up, and the finest ones are there.
        let all = Noise { basis, octaves: 12, scale_m: 4096.0, gain: 1.0, ..Noise::default() };
        let (_, deviation) = spread(&field(&all, &g));
        assert!(deviation > 0.03, "{deviation}");
    }
}
