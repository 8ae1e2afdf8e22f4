//! Statistics of every generator that draws lots, and where those of the others are tested.
//!
//! | generator | mean, deviation | spectrum | directions alike | no seam | no creases | threads |
//! |---|---|---|---|---|---|---|
//! | `circles` | here | none: discs of two sizes | here | here | - | here |
//! | `diamond_square`, `random_additions` | here | here: `2 H + 2` | here | here | here | here |
//! | `faulting` | here | here: 3 | here | here | - | here |
//! | `fbm` (all bases), `ridged`, `billow` | here, `generate_noise` | here | here, `generate_noise` | here | `generate_noise` | here |
//! | `worley` | here | none: kinks at one scale | here | here | `generate_noise` | here |
//! | `mask_noise` | here, `generate_filters` | none: cut off at 0 and 1 | here | here | - | here |
//! | `warp` | moves what is there (`generate_shapes`) | - | `generate_noise` | `generate_noise` | - | `generate_noise` |
//!
//! `volcanic_island` draws forms and not noise: `islands` holds its seeds against each other.
//!
//! The others compute what a formula says, cell by cell, and are held against it: [`BY_FORMULA`].
use crate::common;

use common::{grid, make_named, spread, structure};
use eyot_core::{Boundary, BoundaryCondition, Field, Grid};
use eyot_land::analyse::spectral_beta;
use eyot_land::generate::GENERATORS;
use serde_json::{Value, json};

/// A source, and what was measured of it on 512 x 512 cells, the mean of four seeds.
struct Case {
    name: &'static str,
    parameters: Value,
    mean: f64,
    deviation: f64,
    /// Spectral exponent, if the method has one.
    beta: Option<f64>,
    /// Bound of the largest over the smallest mean squared difference of six directions; about twice the excess measured.
    anisotropy: f64,
    /// Bound of the largest over the smallest share of sixteen directions of slopes, likewise.
    falls: f64,
}

/// Generators without lots, and the tests that compare each with its formula.
const BY_FORMULA: [(&str, &str, &str); 16] = [
    ("breach", include_str!("generate_drainage.rs"), "breach_cuts_within_its_bounds_and_fills_the_rest"),
    ("cone", include_str!("generate_shapes.rs"), "cone_is_the_formula"),
    ("constant", include_str!("generate_shapes.rs"), "ramp_and_constant"),
    ("crater", include_str!("generate_shapes.rs"), "crater_folds_exactly"),
    ("fill", include_str!("generate_drainage.rs"), "fill_raises_depressions_and_nothing_else"),
    ("flow", include_str!("generate_drainage.rs"), "flow_gathers_all_land_and_leaves_the_height"),
    ("hypsometry", include_str!("generate_filters.rs"), "hypsometry_gives_the_asked_ocean_and_keeps_the_order"),
    ("mask_curvature", include_str!("generate_filters.rs"), "masks_of_curvature_tell_ridges_from_valleys"),
    ("mask_height", include_str!("generate_filters.rs"), "masks_of_height_and_slope_meet_their_bands"),
    ("mask_slope", include_str!("generate_filters.rs"), "masks_of_height_and_slope_meet_their_bands"),
    ("ramp", include_str!("generate_shapes.rs"), "ramp_and_constant"),
    ("remap", include_str!("generate_filters.rs"), "curves_pass_through_their_points_and_never_overshoot"),
    ("smooth", include_str!("generate_shapes.rs"), "smoothing_one_cell_gives_a_round_gaussian"),
    ("terraces", include_str!("generate_filters.rs"), "terraces_are_level_and_keep_the_order"),
    ("volcanic_island", include_str!("islands.rs"), "twelve_seeds_are_twelve_islands"),
    ("warp", include_str!("generate_shapes.rs"), "warp_moves_and_does_not_make"),
];

#[test]
fn every_generator_is_tested() {
    let drawn: Vec<&str> = cases().iter().map(|c| c.name).collect();
    for name in GENERATORS.iter().map(|e| e.name) {
        let by_formula = BY_FORMULA.iter().find(|f| f.0 == name);
        assert!(by_formula.is_some() || drawn.contains(&name), "`{name}` has neither statistics nor a formula");
        if let Some((_, file, test)) = by_formula {
            assert!(file.contains(&format!("fn {test}()")), "there is no test `{test}` any more");
        }
    }
}

fn cases() -> Vec<Case> {
    let case = |name, parameters, mean, deviation, beta, anisotropy, falls| Case {
        name,
        parameters,
        mean,
        deviation,
        beta,
        anisotropy,
        falls,
    };
    let d2 = |distance| json!({ "scale": 0.05, "amplitude": 100.0, "distance": distance });
    let of_basis = |basis| json!({ "scale": 0.1, "amplitude": 100.0, "basis": basis });
    vec![
        // beta = 2 H + 2 with H = -log2 roughness: 4 and 3.03 (measured 4.05 and 3.07).
        case("diamond_square", json!({ "scale": 0.1, "amplitude": 1000.0 }), 0.0, 175.0, Some(4.0), 1.1, 1.25),
        case(
            "diamond_square",
            json!({ "scale": 0.1, "amplitude": 1000.0, "roughness": 0.7 }),
            0.0,
            128.0,
            Some(3.03),
            1.03,
            1.08,
        ),
        // beta = 2 H + 2 (measured 3.84 and 3.03).
        case("random_additions", json!({ "scale": 0.1, "amplitude": 100.0 }), 0.0, 79.0, Some(3.8), 1.09, 1.15),
        case(
            "random_additions",
            json!({ "scale": 0.1, "amplitude": 100.0, "hurst": 0.5, "ratio": 0.8 }),
            0.0,
            62.0,
            Some(3.0),
            1.02,
            1.04,
        ),
        // H = 1/2 (measured 3.03 and 2.96). Slopes lie at few scarps, so their directions are a small sample.
        case("faulting", json!({ "amplitude": 100.0, "width": 0.002 }), 0.0, 80.0, Some(3.0), 1.2, 2.6),
        case("circles", json!({ "radius": 0.06, "height": 100.0 }), 139.0, 54.3, None, 1.02, 1.06),
        case("fbm", json!({ "scale": 0.1, "amplitude": 100.0 }), 0.0, 31.2, Some(3.23), 1.08, 1.11),
        case("fbm", json!({ "scale": 0.1, "amplitude": 100.0, "basis": "value" }), 1.5, 25.8, Some(3.92), 1.12, 1.15),
        case("fbm", of_basis("perlin"), 0.0, 17.9, Some(3.69), 1.02, 1.08),
        case("fbm", of_basis("worley_f1"), -38.1, 16.0, Some(3.43), 1.04, 1.06),
        case("fbm", of_basis("worley_f2"), -6.5, 14.1, Some(3.35), 1.04, 1.05),
        case("fbm", of_basis("worley_f2_f1"), -63.1, 15.3, Some(2.71), 1.03, 1.05),
        case("fbm", json!({ "scale": 0.1, "amplitude": 100.0, "warp": 0.4 }), 0.0, 31.1, Some(2.71), 1.08, 1.25),
        case("ridged", of_basis("perlin"), 53.0, 18.9, Some(3.03), 1.03, 1.05),
        case("ridged", of_basis("simplex"), 25.0, 20.5, Some(2.07), 1.11, 1.2),
        case("mask_noise", json!({ "scale": 0.1, "level": 0.0, "edge": 2.0 }), 0.5, 0.22, None, 1.08, 1.1),
        case("billow", json!({ "scale": 0.1, "amplitude": 100.0 }), -49.0, 20.5, Some(2.9), 1.04, 1.08),
        case("worley", d2("f1"), 30.6, 13.5, None, 1.03, 1.15),
        case("worley", d2("f2"), 46.7, 11.9, None, 1.05, 1.12),
        case("worley", d2("f2_f1"), 17.9, 13.3, None, 1.03, 1.5),
    ]
}

/// How often the land falls towards each sixteenth of the compass: the largest share over the smallest.
fn directions(fields: &[Field]) -> f64 {
    let mut bins = [0f64; 16];
    for f in fields {
        for y in 1..f.height() - 1 {
            for x in 1..f.width() - 1 {
                let (dx, dy) = (f.get(x + 1, y) - f.get(x - 1, y), f.get(x, y + 1) - f.get(x, y - 1));
                let turn = f64::from(dy).atan2(f64::from(dx)) / std::f64::consts::TAU + 1.0;
                // Half a bin further, so that the axes lie in the middle of bins.
                bins[((turn + 1.0 / 32.0) * 16.0) as usize % 16] += 1.0;
            }
        }
    }
    let (low, high) = bins.iter().fold((f64::MAX, 0f64), |(a, b), &v| (a.min(v), b.max(v)));
    high / low
}

#[test]
fn heights_roughness_and_directions() {
    let mut wrong = Vec::new();
    for rim in [Boundary::CLOSED, Boundary::WRAP] {
        let g = grid(512, 512, 10.0, rim);
        for c in cases() {
            let fields: Vec<Field> = (0..4).map(|seed| make_named(c.name, &c.parameters, g, seed)).collect();
            let n = fields.len() as f64;
            let mean = fields.iter().map(|f| spread(f).0).sum::<f64>() / n;
            let deviation = fields.iter().map(|f| spread(f).1).sum::<f64>() / n;
            let beta = fields.iter().map(|f| spectral_beta(f, &g).unwrap().unwrap()).sum::<f64>() / n;
            let along = [(5, 0), (0, 5), (3, 4), (4, 3), (-3, 4), (-4, 3)];
            let of = along.map(|(dx, dy)| fields.iter().map(|f| structure(f, dx, dy)).sum::<f64>());
            let anisotropy = of.iter().fold(0f64, |a, &b| a.max(b)) / of.iter().fold(f64::MAX, |a, &b| a.min(b));
            let falls = directions(&fields);
            println!(
                "{:?} {} {}: mean {mean:.2}, deviation {deviation:.2}, beta {beta:.3}, anisotropy {anisotropy:.4}, falls {falls:.3}",
                rim.x, c.name, c.parameters
            );
            let mut hold = |what: &str, got: f64, want: f64, tolerance: f64| {
                if (got - want).abs() > tolerance {
                    wrong.push(format!("{:?} {} {}: {what} {got}, not {want}", rim.x, c.name, c.parameters));
                }
            };
            hold("mean", mean, c.mean, 0.3 * c.deviation);
            hold("deviation", deviation, c.deviation, 0.15 * c.deviation);
            if let Some(want) = c.beta {
                hold("beta", beta, want, 0.15);
            }
            hold("anisotropy", anisotropy, 1.0, c.anisotropy - 1.0);
            hold("directions of slopes", falls, 1.0, c.falls - 1.0);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// First and second differences across the seam are like those elsewhere.
#[test]
fn wrapping_rims_have_no_seam() {
    for rim in [
        Boundary::WRAP,
        Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open },
        Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Wrap },
    ] {
        for (w, h) in [(256, 192), (250, 131)] {
            let g = grid(w, h, 10.0, rim);
            for c in cases() {
                let f = make_named(c.name, &c.parameters, g, 8);
                for along_x in [true, false] {
                    if (if along_x { rim.x } else { rim.y }) != BoundaryCondition::Wrap {
                        continue;
                    }
                    let (n, lines) = if along_x { (w, h) } else { (h, w) };
                    let at = |i: usize, line: usize| if along_x { f.get(i % n, line) } else { f.get(line, i % n) };
                    // Mean squared first and second difference of each step along the axis, over all lines.
                    let (mut first, mut second) = (vec![0f64; n], vec![0f64; n]);
                    for line in 0..lines {
                        for i in 0..n {
                            let (a, b, c) = (at(i, line), at(i + 1, line), at(i + 2, line));
                            first[i] += f64::from(b - a).powi(2);
                            second[i] += f64::from(a - 2.0 * b + c).powi(2);
                        }
                    }
                    for (d, what) in [(first, "first"), (second, "second")] {
                        let inside = d[..n - 2].iter().copied().fold(0.0, f64::max);
                        let seam = d[n - 2..].iter().copied().fold(0.0, f64::max);
                        assert!(
                            seam <= 1.05 * inside,
                            "{} {} {rim:?}: {what} {seam} at the seam, {inside} inside",
                            c.name,
                            c.parameters
                        );
                    }
                }
            }
        }
    }
}

/// No row and no column is rougher or smoother than others: the lattices of subdivision leave no creases.
#[test]
fn no_lattice_line_shows() {
    for (name, parameters) in [
        ("diamond_square", json!({ "scale": 0.25, "roughness": 0.6 })),
        ("random_additions", json!({ "scale": 0.25, "hurst": 0.6 })),
    ] {
        let (g, n) = (grid(256, 256, 10.0, Boundary::CLOSED), 256);
        let (mut rows, mut columns) = (vec![0.0; n], vec![0.0; n]);
        for seed in 0..24 {
            let f = make_named(name, &parameters, g, seed);
            for y in 1..n - 1 {
                for x in 1..n - 1 {
                    let bend = |a: f32, b: f32, c: f32| f64::from(a - 2.0 * b + c).powi(2);
                    rows[y] += bend(f.get(x, y - 1), f.get(x, y), f.get(x, y + 1));
                    columns[x] += bend(f.get(x - 1, y), f.get(x, y), f.get(x + 1, y));
                }
            }
        }
        for lines in [&rows[1..n - 1], &columns[1..n - 1]] {
            let (low, high) = lines.iter().fold((f64::MAX, 0f64), |(a, b), &v| (a.min(v), b.max(v)));
            println!("{name}: {:.3}", high / low);
            assert!(high / low < 1.5, "{name}: {}", high / low);
        }
    }
}

#[test]
fn the_same_bytes_for_all_threads() {
    for rim in [Boundary::CLOSED, Boundary::WRAP, Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open }] {
        let g = Grid { width: 333, height: 167, cell_x_m: 3.0, cell_y_m: 4.0, rim };
        for c in cases() {
            let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let reference = pool(1).install(|| make_named(c.name, &c.parameters, g, 5));
            for threads in [2, 3, 8] {
                let f = pool(threads).install(|| make_named(c.name, &c.parameters, g, 5));
                let same = f.iter().zip(reference.iter()).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{} on {threads} threads", c.name);
            }
        }
    }
}
