//! Routing to several receivers, and what flows together, on every rim: exact sums, known surfaces, a second program of the
//! definitions, the same bytes for any number of threads.

use eyot_core::conformance::rims;
use eyot_core::{Boundary, Control, Grid, Limits};
use eyot_drainage::{Base, Neighbours, Routing, Spread, fill, outlets};

const FREEMAN: Spread = Spread::Multiple { exponent: 1.1 };

fn grid(w: usize, h: usize, rim: Boundary) -> Grid {
    Grid::new(w, h, 30.0, rim, &Limits::default()).unwrap()
}

/// Hash of a cell, 0..1.
fn unit(i: usize, seed: u64) -> f64 {
    let mut z = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ seed.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z >> 11) as f64 / (1_u64 << 53) as f64
}

/// Full land with slopes and flats, its outlets and its network.
fn land(g: &Grid, seed: u64) -> (Vec<f64>, Vec<bool>, Routing) {
    // Hills of several cells, rough ground on them.
    let mut z: Vec<f64> = (0..g.cells())
        .map(|i| {
            let (x, y) = ((i % g.width) as f64, (i / g.width) as f64);
            8.0 * (0.4 * x).sin() * (0.3 * y).cos() + 3.0 * unit(i, seed)
        })
        .collect();
    let out = outlets(&z, g, &Base::default()).unwrap();
    fill(&mut z, g, &out, &Control::none()).unwrap();
    let routing = Routing::new(&z, g, &out, &Control::none()).unwrap();
    (z, out, routing)
}

/// Shares of a cell with a lower neighbour, written from the papers: Freeman's with powers, Tarboton's with angles.
fn shares_by_hand(z: &[f64], g: &Grid, i: usize, spread: Spread) -> Vec<(usize, f64)> {
    let near = Neighbours::new(g);
    let fall = |j: usize| z[i] - z[j];
    let mut shares = Vec::new();
    match spread {
        Spread::Multiple { exponent } => {
            near.each(i, |d, j| {
                if fall(j) > 0.0 {
                    shares.push((j, (fall(j) / near.distance_m[d]).powf(exponent)));
                }
            });
        }
        Spread::Dinf => {
            let mut best = 0.0;
            for facet in 0..8 {
                // Edge and corner of the eight facets, counterclockwise of each edge first, as the rule on ties says.
                let edge = facet / 2 * 2;
                let corner = if facet % 2 == 0 { (edge + 7) % 8 } else { edge + 1 };
                let (d1, d2) = (near.distance_m[edge], near.distance_m[(edge + 2) % 8]);
                let Some(e1) = near.at(i, edge) else { continue };
                let s1 = fall(e1) / d1;
                let Some(e2) = near.at(i, corner) else {
                    if s1 > best {
                        (best, shares) = (s1, vec![(e1, 1.0)]);
                    }
                    continue;
                };
                let s2 = (z[e1] - z[e2]) / d2;
                let (mut r, mut s, widest) = (s2.atan2(s1), s1.hypot(s2), d2.atan2(d1));
                if r < 0.0 {
                    (r, s) = (0.0, s1);
                } else if r > widest {
                    (r, s) = (widest, fall(e2) / d1.hypot(d2));
                }
                if s > best {
                    (best, shares) = (s, vec![(e1, 1.0 - r / widest), (e2, r / widest)]);
                }
            }
        }
    }
    let sum: f64 = shares.iter().map(|s| s.1).sum();
    shares.into_iter().map(|(j, s)| (j, s / sum)).collect()
}

/// Areas in cells, cell after cell from the highest on; flats by the network.
fn areas_by_hand(z: &[f64], g: &Grid, routing: &Routing, spread: Spread) -> Vec<f64> {
    let mut area = vec![1.0; z.len()];
    // Along flats the network knows the order; donors have higher positions in it.
    let mut place = vec![0; z.len()];
    routing.order().iter().enumerate().for_each(|(k, &i)| place[i as usize] = k);
    let mut cells: Vec<usize> = (0..z.len()).collect();
    cells.sort_by(|&a, &b| z[b].total_cmp(&z[a]).then(place[b].cmp(&place[a])));
    for i in cells.into_iter().filter(|&i| !routing.is_outlet(i)) {
        let shares = shares_by_hand(z, g, i, spread);
        let shares = if shares.is_empty() { vec![(routing.receiver(i), 1.0)] } else { shares };
        shares.into_iter().for_each(|(j, s)| area[j] += area[i] * s);
    }
    area
}

#[test]
fn areas_are_those_of_the_definitions_and_sum_exactly_on_every_rim() {
    for (k, rim) in rims().into_iter().enumerate() {
        for (w, h, cell_y_m) in [(37, 29, 30.0), (24, 31, 45.0), (1, 9, 30.0), (2, 2, 30.0), (9, 1, 30.0), (2, 7, 60.0)]
        {
            let g = Grid { cell_y_m, ..grid(w, h, rim) };
            let (z, out, routing) = land(&g, k as u64);
            for spread in
                [FREEMAN, Spread::Multiple { exponent: 1.0 }, Spread::Multiple { exponent: 6.0 }, Spread::Dinf]
            {
                let area = routing.spread_area_m2(&z, &g, spread, &Control::none()).unwrap();
                let at_outlets: f64 = (0..area.len()).filter(|&i| out[i]).map(|i| area[i]).sum();
                assert_eq!(at_outlets, g.cells() as f64 * g.cell_area_m2(), "{spread:?} {rim:?} {w} x {h}");
                let expected = areas_by_hand(&z, &g, &routing, spread);
                let mut amounts = vec![1.0; g.cells()];
                routing.accumulate_spread(&z, &g, spread, &mut amounts, &Control::none()).unwrap();
                for i in 0..area.len() {
                    let here = format!("{spread:?} {rim:?} {w} x {h} cell {i}: {} for {}", amounts[i], expected[i]);
                    // Powers are those of single precision.
                    let tolerance = if spread == Spread::Dinf { 1e-12 } else { 1e-6 };
                    assert!((amounts[i] - expected[i]).abs() < tolerance * expected[i], "{here}");
                    // Areas are counted in millionths of a cell; what rounding down moves adds up downstream.
                    assert!((area[i] / g.cell_area_m2() - expected[i]).abs() < 1e-3, "{here}");
                }
            }
        }
    }
}

/// On a plane that falls in any direction, water goes straight down: the two shares weigh their directions to that of the plane.
#[test]
fn dinf_runs_straight_down_planes() {
    let g = grid(3, 3, Boundary::OPEN);
    for k in 0..32 {
        let angle = (f64::from(k) + 0.1) / 32.0 * std::f64::consts::TAU;
        let (east, south) = (angle.sin(), -angle.cos());
        let z: Vec<f64> = (0..9).map(|i| -(east * (i % 3) as f64 + south * (i / 3) as f64)).collect();
        let out = outlets(&z, &g, &Base::default()).unwrap();
        let routing = Routing::new(&z, &g, &out, &Control::none()).unwrap();
        let mut amounts = vec![0.0; 9];
        amounts[4] = 1.0;
        routing.accumulate_spread(&z, &g, Spread::Dinf, &mut amounts, &Control::none()).unwrap();
        let (mut sum, mut mean) = (0.0, 0.0);
        Neighbours::new(&g).each(4, |d, j| {
            let turned = d as f64 * std::f64::consts::FRAC_PI_4 - angle;
            let turned = (turned + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
            assert!(amounts[j] == 0.0 || turned.abs() <= std::f64::consts::FRAC_PI_4, "{k}: {amounts:?}");
            sum += amounts[j];
            mean += amounts[j] * turned;
        });
        assert!((sum - 1.0).abs() < 1e-15 && mean.abs() < 1e-12, "{k}: off by {mean}");
    }
}

/// On a cone the area upstream per contour is r / 2 in all directions. D8 gathers it on eight lines.
#[test]
fn cones_are_drained_evenly() {
    let g = grid(65, 65, Boundary::OPEN);
    let cone: Vec<f64> =
        (0..g.cells()).map(|i| 100.0 - ((i % 65) as f64 - 32.0).hypot((i / 65) as f64 - 32.0)).collect();
    let out = outlets(&cone, &g, &Base::default()).unwrap();
    let routing = Routing::new(&cone, &g, &out, &Control::none()).unwrap();
    let unevenness = |a: &[f64]| {
        let ring: Vec<f64> = (0..a.len()).filter(|&i| ((100.0 - cone[i]) - 20.0).abs() < 0.5).map(|i| a[i]).collect();
        let mean = ring.iter().sum::<f64>() / ring.len() as f64;
        (ring.iter().map(|v| (v / mean - 1.0).powi(2)).sum::<f64>() / ring.len() as f64).sqrt()
    };
    let of = |spread| unevenness(&routing.spread_area_m2(&cone, &g, spread, &Control::none()).unwrap());
    let (freeman, dinf, d8) = (of(FREEMAN), of(Spread::Dinf), unevenness(&routing.upstream_area_m2(&g)));
    println!("Freeman {freeman:.3}, D-infinity {dinf:.3}, D8 {d8:.3}");
    assert!(freeman < 0.05 * d8 && dinf < 0.3 * d8, "{freeman}, {dinf} and {d8}");
}

/// With a large exponent all water takes the steepest way. Rough ground has no ties.
#[test]
fn large_exponents_gather_like_d8() {
    let g = grid(65, 65, Boundary::OPEN);
    let mut z: Vec<f64> = (0..g.cells()).map(|i| unit(i, 9)).collect();
    let out = outlets(&z, &g, &Base::default()).unwrap();
    fill(&mut z, &g, &out, &Control::none()).unwrap();
    let routing = Routing::new(&z, &g, &out, &Control::none()).unwrap();
    let mut a = vec![1.0; g.cells()];
    let gathered = Spread::Multiple { exponent: 100.0 };
    routing.accumulate_spread(&z, &g, gathered, &mut a, &Control::none()).unwrap();
    let cells = routing.upstream_cells();
    let same = (0..a.len()).filter(|&i| (a[i] - f64::from(cells[i])).abs() < 0.05 * a[i]).count();
    // Elsewhere a second neighbour is steep within a few percent.
    assert!(same as f64 > 0.8 * a.len() as f64, "{same}");
    for exponent in [-1.0, 101.0, f64::NAN] {
        let e = routing.accumulate_spread(&z, &g, Spread::Multiple { exponent }, &mut a, &Control::none()).unwrap_err();
        assert!(e.to_string().contains("exponent"), "{e}");
    }
}

/// Many bands, so that cells wait for each other across borders in several rounds.
#[test]
fn threads_change_no_byte_of_anything_that_gathers() {
    for (w, h, rim) in [(600, 1200, Boundary::OPEN), (40_000, 31, Boundary::WRAP), (3, 90_000, Boundary::CLOSED)] {
        let g = grid(w, h, rim);
        let (z, out, routing) = land(&g, 4);
        let all = || {
            let mut rain: Vec<f64> = (0..g.cells()).map(|i| unit(i, 1)).collect();
            routing.accumulate(&mut rain).unwrap();
            let area = |spread| routing.spread_area_m2(&z, &g, spread, &Control::none()).unwrap();
            let mut amounts: Vec<f64> = (0..g.cells()).map(|i| unit(i, 2)).collect();
            routing.accumulate_spread(&z, &g, FREEMAN, &mut amounts, &Control::none()).unwrap();
            let sums = [rain, area(FREEMAN), area(Spread::Dinf), amounts, routing.longest_upstream_m()];
            (routing.upstream_cells(), sums.map(|v| v.into_iter().map(f64::to_bits).collect::<Vec<_>>()))
        };
        let with = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(all);
        let one = with(1);
        // One cell after the other, by the order of the network.
        let mut cells = vec![1_u32; g.cells()];
        for i in routing.order().into_iter().rev().map(|i| i as usize).filter(|&i| !out[i]) {
            cells[routing.receiver(i)] += cells[i];
        }
        assert_eq!(one.0, cells, "{w} x {h}");
        for n in [2, 3, 8] {
            assert!(with(n) == one, "{w} x {h} on {n} threads");
        }
    }
}

#[test]
fn stops_are_heard() {
    let g = grid(50, 50, Boundary::OPEN);
    let (z, _, routing) = land(&g, 3);
    let cancel = eyot_core::Cancel::default();
    cancel.raise();
    let control = Control::new(cancel, &|_, _| {});
    for spread in [FREEMAN, Spread::Dinf] {
        let outcome = routing.spread_area_m2(&z, &g, spread, &control);
        assert!(matches!(outcome, Err(eyot_core::Error::Cancelled(_))));
    }
}
