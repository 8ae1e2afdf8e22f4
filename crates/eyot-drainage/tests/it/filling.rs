//! Filling, breaching, routing and accumulation against their definitions, on every kind of rim.

use eyot_core::{Boundary, BoundaryCondition, Control, Error, Grid, Limits};
use eyot_drainage::{Base, BreachLimits, FlatRule, Height, Neighbours, Routing, breach, fill, outlets};
use proptest::prelude::*;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

const RIMS: [Boundary; 6] = [
    Boundary::CLOSED,
    Boundary::OPEN,
    Boundary::WRAP,
    Boundary { x: BoundaryCondition::Wrap, y: BoundaryCondition::Open },
    Boundary { x: BoundaryCondition::Open, y: BoundaryCondition::Wrap },
    Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Wrap },
];

fn grid(w: usize, h: usize, rim: Boundary) -> Grid {
    Grid::new(w, h, 30.0, rim, &Limits::default()).unwrap()
}

/// `levels` different heights, at random; few of them make plateaus.
fn rough(cells: usize, levels: u64, seed: u64) -> Vec<f32> {
    let mut s = seed | 1;
    let mut next = || {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        s >> 20
    };
    (0..cells).map(|_| (next() % levels) as f32 * 0.37 - 1.1).collect()
}

/// Random heights that have been smoothed, so that depressions are many cells wide.
fn hills(grid: &Grid, seed: u64) -> Vec<f32> {
    let mut z = rough(grid.cells(), 1 << 30, seed);
    let near = Neighbours::new(grid);
    for _ in 0..3 {
        z = (0..z.len())
            .map(|i| {
                let (mut sum, mut n) = (z[i], 1.0);
                near.each(i, |_, j| (sum, n) = (sum + z[j], n + 1.0));
                sum / n
            })
            .collect();
    }
    z
}

/// Barnes, Lehman & Mulla (2014), Algorithm 2, cell by cell.
fn priority_flood<T: Height>(height: &mut [T], grid: &Grid, outlets: &[bool]) {
    let near = Neighbours::new(grid);
    let mut closed = outlets.to_vec();
    let all = (0..height.len()).filter(|&i| outlets[i]);
    let mut open: BinaryHeap<_> = all.map(|i| Reverse((height[i].key(), i))).collect();
    let mut pits = VecDeque::new();
    while let Some(i) = pits.pop_front().or_else(|| open.pop().map(|Reverse((_, i))| i)) {
        let level = height[i];
        near.each(i, |_, j| {
            if !std::mem::replace(&mut closed[j], true) {
                if height[j] <= level {
                    height[j] = level;
                    pits.push_back(j);
                } else {
                    open.push(Reverse((height[j].key(), j)));
                }
            }
        });
    }
}

fn filled<T: Height>(z: &[T], grid: &Grid, out: &[bool]) -> Vec<T> {
    let mut f = z.to_vec();
    fill(&mut f, grid, out, &Control::none()).unwrap();
    f
}

fn route<T: Height>(z: &[T], grid: &Grid, out: &[bool]) -> Routing {
    Routing::new(z, grid, out, &Control::none()).unwrap()
}

fn with_threads<R: Send>(n: usize, f: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(f)
}

/// What holds for every network: all cells drain, downhill, and everything arrives.
fn check_network<T: Height>(f: &[T], grid: &Grid, out: &[bool], routing: &Routing) {
    let (near, order, cells) = (Neighbours::new(grid), routing.order(), routing.upstream_cells());
    let mut place = vec![usize::MAX; f.len()];
    order.iter().enumerate().for_each(|(k, &i)| place[i as usize] = k);
    assert!(place.iter().all(|&k| k < f.len()), "each cell is in the order once");
    for i in 0..f.len() {
        let r = routing.receiver(i);
        assert_eq!(routing.is_outlet(i), out[i], "cell {i}");
        if out[i] {
            assert_eq!((r, routing.distance_m(i)), (i, 0.0));
            continue;
        }
        assert!(place[r] < place[i] && f[r] <= f[i]);
        let d = usize::from(routing.directions()[i]);
        assert_eq!((near.at(i, d), routing.distance_m(i)), (Some(r), near.distance_m[d]));
        // The receiver is as steep as can be.
        let slope = |d: usize, j: usize| (f[i].to_f64() - f[j].to_f64()) / near.distance_m[d];
        near.each(i, |e, j| assert!(slope(e, j) <= slope(d, r) + 1e-12, "cell {i}: {} < {}", slope(d, r), slope(e, j)));
    }
    let arrived: u64 = (0..f.len()).filter(|&i| out[i]).map(|i| u64::from(cells[i])).sum();
    assert_eq!(arrived, f.len() as u64);
    let basins = routing.basins();
    for (i, &n) in cells.iter().enumerate().filter(|(i, _)| out[*i]) {
        assert_eq!(basins.iter().filter(|&&b| b as usize == i).count(), n as usize);
    }
}

proptest! {
    #[test]
    fn small_grids(w in 1_usize..12, h in 1_usize..12, levels in 1_u64..9, rim in 0_usize..6, sea: bool, map: bool, seed: u64) {
        let g = Grid { cell_y_m: 20.0, ..grid(w, h, RIMS[rim]) };
        let z = rough(g.cells(), levels, seed);
        let base = Base { closed_rims: map, sea_level_m: sea.then_some(-0.5), mask: None };
        let out = outlets(&z, &g, &base).unwrap();
        let mut slow = z.clone();
        priority_flood(&mut slow, &g, &out);
        let fast = filled(&z, &g, &out);
        prop_assert_eq!(&fast, &slow);
        check_network(&fast, &g, &out, &route(&fast, &g, &out));
        let wide: Vec<f64> = z.iter().map(|&z| z.into()).collect();
        let f64s = filled(&wide, &g, &out);
        prop_assert!(f64s.iter().zip(&fast).all(|(a, b)| *a == f64::from(*b)));
        prop_assert_eq!(route(&f64s, &g, &out), route(&fast, &g, &out));
        let shortest = Routing::with_flats(&fast, &g, &out, FlatRule::Shortest, &Control::none()).unwrap();
        check_network(&fast, &g, &out, &shortest);
    }

    /// With a way out below everything and no bounds, breaching drains everything.
    #[test]
    fn breached_land_needs_no_filling(w in 1_usize..14, h in 1_usize..14, levels in 2_u64..40, rim in 0_usize..6, seed: u64) {
        let g = grid(w, h, RIMS[rim]);
        let z = rough(g.cells(), levels, seed);
        let lowest = z.iter().copied().fold(f32::INFINITY, f32::min);
        let mask: Vec<bool> = z.iter().map(|&z| z == lowest).collect();
        let mut b = z.clone();
        let free = BreachLimits { max_depth_m: f64::INFINITY, max_length_m: f64::INFINITY };
        breach(&mut b, &g, &mask, &free, &Control::none()).unwrap();
        prop_assert!(b.iter().zip(&z).all(|(b, z)| b <= z));
        prop_assert_eq!(filled(&b, &g, &mask), b);
    }

    #[test]
    fn breaching_keeps_its_bounds(w in 3_usize..20, h in 3_usize..20, depth in 0.0_f64..4.0, length in 0.0_f64..200.0, seed: u64) {
        let g = grid(w, h, Boundary::OPEN);
        let z = rough(g.cells(), 1 << 30, seed).into_iter().map(|z| z * 1e-8).collect::<Vec<f32>>();
        let out = outlets(&z, &g, &Base::default()).unwrap();
        let mut b = z.clone();
        let bounds = BreachLimits { max_depth_m: depth, max_length_m: length };
        breach(&mut b, &g, &out, &bounds, &Control::none()).unwrap();
        for i in 0..z.len() {
            prop_assert!(b[i] <= z[i] && f64::from(z[i] - b[i]) <= depth + 1e-6);
            prop_assert!(!out[i] || b[i] == z[i]);
        }
        // Less to fill than before, nowhere more.
        let (before, after) = (filled(&z, &g, &out), filled(&b, &g, &out));
        prop_assert!(after.iter().zip(&before).all(|(a, b)| a <= b));
        if depth == 0.0 || length < 60.0 {
            prop_assert_eq!(b, z);
        }
    }
}

#[test]
fn bands_and_threads_change_nothing() {
    // Bands of 8 rows, of 22 rows, and a tall one.
    for (w, h) in [(8192, 41), (3000, 70), (3, 50_000), (1, 70_000), (70_000, 1), (66_000, 2)] {
        for (k, rim) in RIMS.into_iter().enumerate() {
            let g = grid(w, h, rim);
            let z = if k % 2 == 0 { hills(&g, 5 + k as u64) } else { rough(g.cells(), 12, 3) };
            let out = outlets(&z, &g, &Base::default()).unwrap();
            let mut slow = z.clone();
            priority_flood(&mut slow, &g, &out);
            let free = BreachLimits { max_depth_m: 0.2, max_length_m: 500.0 };
            let work = || {
                let f = filled(&z, &g, &out);
                let mut b = z.clone();
                breach(&mut b, &g, &out, &free, &Control::none()).unwrap();
                (route(&f, &g, &out), f, b)
            };
            let one = with_threads(1, work);
            assert_eq!(one.1, slow, "{w} x {h}, {rim:?}");
            assert_eq!(one, with_threads(3, work), "{w} x {h}, {rim:?}");
            let cells = one.0.upstream_cells();
            assert_eq!((0..g.cells()).filter(|&i| out[i]).map(|i| cells[i] as usize).sum::<usize>(), g.cells());
            assert!((0..g.cells()).all(|i| one.0.is_outlet(i) == out[i]));
        }
    }
}

#[test]
fn a_bowl_fills_to_its_rim() {
    // z = r^2 within r < 20 and a plain at 400 with a notch at 256 leading out: everything below 256 fills to 256.
    let g = grid(61, 61, Boundary::OPEN);
    let z: Vec<f32> = (0..g.cells())
        .map(|i| {
            let (x, y) = (i % 61, i / 61);
            let (dx, dy) = (x as f32 - 30.0, y as f32 - 30.0);
            let bowl = (dx * dx + dy * dy).min(400.0);
            if y == 30 && x >= 46 { bowl.min(256.0) } else { bowl }
        })
        .collect();
    let out = outlets(&z, &g, &Base::default()).unwrap();
    let f = filled(&z, &g, &out);
    assert!(z.iter().zip(&f).all(|(&a, &b)| b == a.max(256.0)));
    // Tilted, every cell lies above its receiver.
    let routing = route(&f, &g, &out);
    let mut tilted = f.clone();
    routing.tilt(&mut tilted, 1e-4).unwrap();
    for i in (0..g.cells()).filter(|&i| !out[i]) {
        let fall = f64::from(tilted[i]) - f64::from(tilted[routing.receiver(i)]);
        assert!(fall >= 0.99e-4 * routing.distance_m(i), "{fall}");
        assert!(tilted[i] >= f[i] && tilted[i] < f[i] + 1.0);
    }
    routing.tilt(&mut tilted, f64::NAN).unwrap_err();
}

#[test]
fn a_plane_drains_down_its_slope() {
    let g = grid(6, 5, Boundary::OPEN);
    let z: Vec<f32> = (0..30).map(|i| (i % 6) as f32).collect();
    let out = outlets(&z, &g, &Base::default()).unwrap();
    let routing = route(&z, &g, &out);
    let cells = routing.upstream_cells();
    // The west cell of each inner row collects its own row but the eastern border cell, which is an outlet.
    assert_eq!([cells[0], cells[6], cells[12], cells[18], cells[24]], [1, 5, 5, 5, 1]);
    assert_eq!(routing.upstream_area_m2(&g)[6], 5.0 * 900.0);
    assert_eq!(routing.longest_upstream_m()[6], 120.0);
    let mut rain = vec![0.5; 30];
    routing.accumulate(&mut rain).unwrap();
    assert!(rain.iter().zip(&cells).all(|(r, c)| *r == 0.5 * f64::from(*c)));
    assert!(matches!(routing.accumulate(&mut [0.0; 3]), Err(Error::Shape { .. })));
}

#[test]
fn narrow_cells_make_diagonals_less_steep() {
    // 3 down over hypot(1, 4) is flatter than 1 down over 1.
    let g = Grid { cell_x_m: 1.0, cell_y_m: 4.0, ..grid(3, 3, Boundary::OPEN) };
    let z = [9.0, 9.0, 2.0, 9.0, 5.0, 4.0, 9.0, 9.0, 9.0_f64];
    let out = outlets(&z, &g, &Base::default()).unwrap();
    assert_eq!(route(&z, &g, &out).receiver(4), 5);
    assert_eq!(route(&z, &Grid { cell_y_m: 1.0, ..g }, &out).receiver(4), 2);
}

/// A plateau of 21 x 9 between walls, open to the east.
fn plateau() -> (Grid, Vec<f32>, Vec<bool>) {
    let g = grid(23, 11, Boundary::CLOSED);
    let z = (0..g.cells())
        .map(|i| {
            let (x, y) = (i % 23, i / 23);
            if x == 0 || y == 0 || y == 10 { 9.0 } else { f32::from(u8::from(x < 22)) }
        })
        .collect();
    (g, z, (0..23 * 11).map(|i| i % 23 == 22).collect())
}

#[test]
fn water_gathers_in_the_middle_of_a_plateau() {
    let (g, z, out) = plateau();
    let cells = route(&z, &g, &out).upstream_cells();
    let at = |x: usize, y: usize| cells[y * 23 + x];
    // All rows flow eastwards from the west wall, but near the walls they turn to the middle first: the row in the middle
    // gets more than any other, and rows are mirror images of each other.
    let east: Vec<u32> = (1..10).map(|y| at(21, y)).collect();
    assert_eq!(east.iter().max(), Some(&east[4]), "{east:?}");
    assert!(east[0] <= 2 && east[4] > 2 * 21, "{east:?}");
    // By shortest ways each row keeps its water.
    let straight = Routing::with_flats(&z, &g, &out, FlatRule::Shortest, &Control::none()).unwrap().upstream_cells();
    assert!(
        (2..9).all(|y| straight[y * 23 + 21] <= 40),
        "{:?}",
        (1..10).map(|y| straight[y * 23 + 21]).collect::<Vec<_>>()
    );
}

#[test]
fn a_dam_is_breached_where_it_is_cheapest() {
    // A valley that falls eastwards by 1 a cell, with a dam two cells thick, of height 3 but in the north, where it is 2.
    let g = Grid { cell_x_m: 1.0, cell_y_m: 1.0, ..grid(12, 7, Boundary::CLOSED) };
    let z: Vec<f64> = (0..g.cells())
        .map(|i| {
            let (x, y) = ((i % 12) as f64, i / 12);
            let dam = if (6..8).contains(&(i % 12)) { if y == 1 { 2.0 } else { 3.0 } } else { 0.0 };
            if y == 0 || y == 6 { 50.0 } else { 20.0 - x + dam }
        })
        .collect();
    let out: Vec<bool> = (0..g.cells()).map(|i| i % 12 == 11).collect();
    let breached = |depth: f64, length: f64| {
        let mut b = z.clone();
        let bounds = BreachLimits { max_depth_m: depth, max_length_m: length };
        breach(&mut b, &g, &out, &bounds, &Control::none()).unwrap();
        let dug: Vec<(usize, f64)> = (0..z.len()).filter(|&i| b[i] < z[i]).map(|i| (i, z[i] - b[i])).collect();
        (dug, b)
    };
    // The lake stands at 15 before the dam (x = 5); behind it lies 12 (x = 8): a trench of two cells, 14 and 13 high, through
    // the north, where 16 and 15 stood.
    let (dug, b) = breached(10.0, 10.0);
    assert_eq!(dug.iter().map(|d| d.0).collect::<Vec<_>>(), [12 + 6, 12 + 7], "{dug:?}");
    assert!((b[18] - 14.0).abs() < 1e-12 && (b[19] - 13.0).abs() < 1e-12, "{dug:?}");
    assert_eq!(filled(&b, &g, &out), b);
    // Too shallow or too short, and it stays.
    assert!(breached(0.5, 10.0).0.is_empty());
    assert!(breached(10.0, 2.5).0.is_empty());
    let bad = BreachLimits { max_depth_m: -1.0, max_length_m: 1.0 };
    let error = breach(&mut z.clone(), &g, &out, &bad, &Control::none()).unwrap_err().to_string();
    assert!(error.contains("max_depth"), "{error}");
}

#[test]
fn more_cells_than_32_bits_can_number_are_refused() {
    let g = Grid { width: 1 << 17, height: 1 << 16, cell_x_m: 1.0, cell_y_m: 1.0, rim: Boundary::OPEN };
    let errors = [
        outlets::<f32>(&[], &g, &Base::default()).unwrap_err(),
        fill::<f32>(&mut [], &g, &[], &Control::none()).unwrap_err(),
        Routing::new::<f32>(&[], &g, &[], &Control::none()).unwrap_err(),
    ];
    for e in errors {
        assert!(e.to_string().contains("8589934592 cells"), "{e}");
    }
}

#[test]
fn stops_leave_the_heights_alone() {
    let g = grid(50, 50, Boundary::OPEN);
    let z = rough(g.cells(), 100, 4);
    let out = outlets(&z, &g, &Base::default()).unwrap();
    let cancel = eyot_core::Cancel::default();
    cancel.raise();
    let control = Control::new(cancel, &|_, _| {});
    let free = BreachLimits { max_depth_m: 9.0, max_length_m: 900.0 };
    let mut kept = z.clone();
    assert!(matches!(fill(&mut kept, &g, &out, &control), Err(Error::Cancelled(_))));
    assert!(matches!(breach(&mut kept, &g, &out, &free, &control), Err(Error::Cancelled(_))));
    assert!(matches!(Routing::new(&kept, &g, &out, &control), Err(Error::Cancelled(_))));
    assert_eq!(kept, z);
}
