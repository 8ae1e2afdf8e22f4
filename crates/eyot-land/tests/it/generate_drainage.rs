//! The generators `breach`, `fill` and `flow`: what they are asked for on every rim, and nothing else.
use crate::common;

use common::grid;
use eyot_core::conformance::rims;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Generator, Site};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, World};
use eyot_drainage::{Base, Routing, RoutingRule, fill, outlets};
use eyot_land::generate::{Breach, Fill, Flow};

const SEA_M: f64 = -9.0;

/// Hills with many depressions, some of them below the sea.
fn hills(g: &Grid) -> Field {
    Field::from_fn(g.width, g.height, |x, y| {
        let rough = ((x * 37 + y * y * 13) % 101) as f32 * 0.03;
        10.0 * (0.35 * x as f32).sin() * (0.3 * y as f32).cos() + rough
    })
}

fn make(what: &dyn Generator, g: Grid, base: &Field) -> Field {
    let mut world = World::new(g, 1);
    world.sea_level_m = SEA_M;
    world.put(&HEIGHT, base.clone()).unwrap();
    let control = Control::none();
    what.generate(&Site::whole(g, 1, &world, &control), base).unwrap()
}

fn base(closed_rims: bool) -> Base<'static> {
    Base { closed_rims, sea_level_m: Some(SEA_M), mask: None }
}

/// Without depressions, and nothing else moved: filling changes nothing any more.
fn drains(f: &Field, g: &Grid, out: &[bool]) -> bool {
    let mut again = f.to_vec();
    fill(&mut again, g, out, &Control::none()).unwrap();
    again == f.to_vec()
}

fn each_grid(mut test: impl FnMut(Grid, bool, Field, Vec<bool>)) {
    for rim in rims() {
        for (w, h) in [(61, 44), (1, 30), (2, 2)] {
            for closed_rims in [false, true] {
                let g = grid(w, h, 25.0, rim);
                let land = hills(&g);
                let out = outlets(&land.to_vec(), &g, &base(closed_rims)).unwrap();
                test(g, closed_rims, land, out);
            }
        }
    }
}

#[test]
fn fill_raises_depressions_and_nothing_else() {
    each_grid(|g, closed_rims, land, out| {
        let level = make(&Fill { closed_rims, ..Fill::default() }, g, &land);
        let mut expected = land.to_vec();
        fill(&mut expected, &g, &out, &Control::none()).unwrap();
        assert_eq!(level.to_vec(), expected, "{:?}", g.rim);
        assert!(drains(&level, &g, &out));

        let slope = 0.002;
        let tilted = make(&Fill { closed_rims, slope }, g, &land);
        let routing = Routing::new(&level.to_vec(), &g, &out, &Control::none()).unwrap();
        let (level, tilted) = (level.to_vec(), tilted.to_vec());
        for i in (0..g.cells()).filter(|&i| !routing.is_outlet(i)) {
            let fall = f64::from(tilted[i]) - f64::from(tilted[routing.receiver(i)]);
            // Heights of ten metres are rounded to a micrometre.
            assert!(fall >= f64::from(slope) * routing.distance_m(i) - 2e-6, "{:?}: {fall}", g.rim);
            assert!(tilted[i] >= level[i]);
        }
        assert!((0..g.cells()).filter(|&i| out[i]).all(|i| tilted[i] == level[i]), "outlets keep their height");
    });
}

#[test]
fn breach_cuts_within_its_bounds_and_fills_the_rest() {
    let mut cut = 0;
    each_grid(|g, closed_rims, land, out| {
        let bounds = Breach { max_depth: 6.0, max_length: 400.0, closed_rims, fill: false };
        let trenches = make(&bounds, g, &land);
        for (i, (new, old)) in trenches.iter().zip(land.iter()).enumerate() {
            assert!(new <= old && old - new <= 6.0 + 1e-5, "{:?}: from {old} to {new}", g.rim);
            assert!(!out[i] || new == old, "outlets keep their height");
            cut += usize::from(new < old);
        }
        let full = make(&Breach { fill: true, ..bounds }, g, &land);
        assert!(drains(&full, &g, &out), "{:?}", g.rim);
        let mut expected = trenches.to_vec();
        fill(&mut expected, &g, &out, &Control::none()).unwrap();
        assert_eq!(full.to_vec(), expected);
        let none = Breach { max_depth: 0.0, ..bounds };
        assert_eq!(make(&Breach { fill: false, ..none }, g, &land), land, "no depth, no trench");
    });
    // measured: 510
    assert!(cut > 300, "{cut} cells were cut");
}

#[test]
fn flow_gathers_all_land_and_leaves_the_height() {
    each_grid(|g, closed_rims, land, out| {
        for routing in [RoutingRule::D8, RoutingRule::Multiple, RoutingRule::Dinf] {
            let area = make(&Flow { routing, closed_rims, ..Flow::default() }, g, &land);
            let arrived: f64 = area.iter().zip(&out).filter(|(_, o)| **o).map(|(a, _)| f64::from(a)).sum();
            let whole = g.cells() as f64 * g.cell_area_m2();
            // Areas are rounded to single precision at last.
            assert!((arrived / whole - 1.0).abs() < 1e-6, "{routing:?} {:?}: {arrived} of {whole}", g.rim);
            assert!(area.iter().all(|a| f64::from(a) >= g.cell_area_m2()));
        }
    });
}

/// Water that may not leave over a closed rim runs elsewhere.
#[test]
fn closed_rims_decide() {
    let g = grid(40, 30, 25.0, Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Closed });
    let ramp = Field::from_fn(40, 30, |x, y| x as f32 + 0.01 * y as f32);
    let area = |closed_rims| make(&Flow { closed_rims, ..Flow::default() }, g, &ramp);
    let west = |f: &Field| (0..30).map(|y| f64::from(f.get(0, y))).sum::<f64>() / g.cell_area_m2();
    // Without outlets the lowest cell gathers everything; with them each western cell keeps its row.
    assert_eq!(f64::from(area(false).get(0, 0)), 1200.0 * g.cell_area_m2());
    assert!(area(true).get(0, 0) < 50.0 * g.cell_area_m2() as f32 && west(&area(true)) < 1200.0);
}
