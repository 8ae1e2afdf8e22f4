//! No process prefers a direction: mirrored and turned worlds stay mirrored and turned, to the bit.
//!
//! Criterion: 1e-6 relative in single precision, exact where a rule's sums can be ordered symmetrically. All of them can:
//! opposite neighbours are added first, then the two axes, so everything here is compared exactly.

use eyot_core::conformance::{random_world, rims};
use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::plan::Plan;
use eyot_core::process::{Moment, Process, Scheduled, Span};
use eyot_core::{Boundary, BoundaryCondition, Grid, Limits, World};
use eyot_drainage::{Descent, Routing, RoutingRule};
use eyot_land::simulate::drainage::Depressions;
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic, SPRINGS};
use eyot_land::simulate::reef::{Light, Limit, Reef};
use eyot_land::simulate::{Drainage, Holes, Seabed, Streampower, Thermal, Wetness};

fn one(process: impl Process + 'static) -> Scheduled {
    Scheduled { name: "test", process: Box::new(process), every: 1 }
}

/// Does nothing but ask for the layer of springs, which the hydraulic process expects to find.
struct Springs;

impl Process for Springs {
    fn layers(&self) -> Vec<eyot_core::process::LayerUse> {
        vec![SPRINGS.changed(0.0)]
    }
    fn plan(&self, _: &Moment, _: &mut Plan) {}
}

fn variants() -> Vec<(&'static str, Vec<Scheduled>)> {
    let hydraulic = Hydraulic { time_step: 0.2, rain: 0.01, springs: 0.01, ..Default::default() };
    let reef = Reef { years_per_step: 1.0, diffusivity: 3.0, sea_level_rise: 0.01, ..Default::default() };
    vec![
        ("hydraulic", vec![one(Springs), one(hydraulic.clone())]),
        ("hydraulic signed", vec![one(Springs), one(Hydraulic { flux: FluxForm::Signed, ..hydraulic.clone() })]),
        ("hydraulic classic", vec![one(Springs), one(Hydraulic { flux: FluxForm::Classic, ..hydraulic.clone() })]),
        ("thermal", vec![one(Thermal::default())]),
        ("thermal inverted", vec![one(Thermal { inverted: true, ..Default::default() })]),
        ("seabed", vec![one(Seabed::default())]),
        ("holes", vec![one(Springs), one(hydraulic.clone()), one(Holes::default())]),
        ("reef", vec![one(reef.clone())]),
        ("reef in light", vec![one(Reef { limit: Limit::Light, light: Light::Saturating, ..Default::default() })]),
        ("wetness", vec![one(Springs), one(hydraulic.clone()), one(Wetness::default())]),
        (
            "all",
            vec![
                one(Springs),
                one(hydraulic),
                one(Thermal::default()),
                one(Wetness::default()),
                one(Seabed::default()),
                one(reef),
            ],
        ),
    ]
}

fn start(layer: &str, u: f32) -> f32 {
    match layer {
        "height" => 12.0 * u - 4.0,
        "water" => (2.0 * u - 0.8).max(0.0),
        "sediment" => 0.1 * u,
        "limestone" => (2.0 * u - 1.0).max(0.0),
        "reef_floor" => 12.0 * u - 6.0,
        // Fluxes begin at rest: a mirror turns their sign and moves them to the other face.
        name if name.starts_with("flux") || name.starts_with("outflow") => 0.0,
        _ => u,
    }
}

/// A way to turn a world of `w` x `h` cells: where the cell (x, y) goes.
struct Turn {
    name: &'static str,
    swaps_axes: bool,
    to: fn(usize, usize, usize, usize) -> (usize, usize),
}

const TURNS: [Turn; 4] = [
    Turn { name: "mirrored east-west", swaps_axes: false, to: |x, y, w, _| (w - 1 - x, y) },
    Turn { name: "mirrored north-south", swaps_axes: false, to: |x, y, _, h| (x, h - 1 - y) },
    Turn { name: "turned by 90 degrees", swaps_axes: true, to: |x, y, _, h| (h - 1 - y, x) },
    Turn { name: "mirrored on the diagonal", swaps_axes: true, to: |x, y, _, _| (y, x) },
];

impl Turn {
    fn turn(&self, world: &World) -> World {
        let g = world.grid;
        let mut grid = g;
        if self.swaps_axes {
            (grid.width, grid.height) = (g.height, g.width);
            (grid.cell_x_m, grid.cell_y_m) = (g.cell_y_m, g.cell_x_m);
            grid.rim = Boundary { x: g.rim.y, y: g.rim.x };
        }
        let mut turned = World::new(grid, world.seed);
        turned.sea_level_m = world.sea_level_m;
        for l in world.layers() {
            let field = &mut turned.ensure(&l.spec, 0.0).field;
            for y in 0..g.height {
                for x in 0..g.width {
                    let (tx, ty) = (self.to)(x, y, g.width, g.height);
                    field.set(tx, ty, l.field.get(x, y));
                }
            }
        }
        turned
    }
}

#[test]
fn no_process_prefers_a_direction() {
    for (name, processes) in variants() {
        for rim in rims() {
            for (width, height) in [(19, 13), (16, 16), (1, 9)] {
                let mut world = random_world((width, height), rim, 3, &processes, &start).unwrap();
                world.sea_level_m = 0.5;
                let run = |w: &mut World| {
                    CpuEngine::default()
                        .simulate(w, &processes, Span { from: 0, steps: 40 }, &Control::none())
                        .unwrap();
                };
                let mut straight = world.clone();
                run(&mut straight);
                for turn in TURNS {
                    let mut turned = turn.turn(&world);
                    run(&mut turned);
                    for l in straight.layers().iter().filter(|l| {
                        let n = &l.spec.name;
                        !n.starts_with("flux") && !n.starts_with("outflow")
                    }) {
                        let other = turned.get(&l.spec.name).unwrap();
                        for y in 0..height {
                            for x in 0..width {
                                let (tx, ty) = (turn.to)(x, y, width, height);
                                let (a, b) = (l.field.get(x, y), other.get(tx, ty));
                                assert!(
                                    a == b,
                                    "{name} {rim:?} {width}x{height} {}: {} at ({x}, {y}) is {a:e}, {b:e}",
                                    turn.name,
                                    l.spec.name
                                );
                            }
                        }
                    }
                    for (account, a) in straight.ledger.iter() {
                        let b = turned.ledger.amount(account);
                        assert!(
                            (a.amount - b).abs() <= 1e-6 * a.amount.abs() + 1e-9,
                            "{name} {}: {account}",
                            turn.name
                        );
                    }
                }
            }
        }
    }
}

/// Shows that the comparison can fail: a world that has been shifted by a cell is not the same.
#[test]
fn a_shift_is_no_symmetry_of_a_closed_world() {
    let processes = vec![one(Thermal::default())];
    let rim = Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Closed };
    let world = random_world((16, 16), rim, 3, &processes, &start).unwrap();
    let shift = Turn { name: "shifted", swaps_axes: false, to: |x, y, w, _| ((x + 1) % w, y) };
    let run = |mut w: World| {
        CpuEngine::default().simulate(&mut w, &processes, Span { from: 0, steps: 40 }, &Control::none()).unwrap();
        w
    };
    assert_ne!(shift.turn(&run(world.clone())).get("height"), run(shift.turn(&world)).get("height"));
}

/// Ground without depressions or ties: down to a pit by the shortest way over the grid and its rings, on rough ground.
fn funnel(shape: (usize, usize), rim: Boundary, processes: &[Scheduled]) -> World {
    let mut world = random_world(shape, rim, 5, processes, &|_, u| u).unwrap();
    world.grid.cell_y_m = world.grid.cell_x_m;
    // The pit lies under water, so that it is no depression, and nothing else does.
    world.sea_level_m = 2.0;
    let away = |i: usize, pit: usize, n: usize, edge: BoundaryCondition| {
        let d = i.abs_diff(pit);
        if edge == BoundaryCondition::Wrap { d.min(n - d) as f32 } else { d as f32 }
    };
    let (w, h) = shape;
    let height = &mut world.layer_mut("height").unwrap().field;
    for y in 0..h {
        for x in 0..w {
            let d = away(x, w / 3, w, rim.x).hypot(away(y, h / 2, h, rim.y));
            height.set(x, y, 3.0 * d + height.get(x, y));
        }
    }
    if let Ok(rest) = world.layer_mut("height_rest") {
        rest.field.map_in_place(|_| 0.0);
    }
    world
}

/// Drainage and rivers turn with the world: to the bit where one way is the steepest, and to rounding where shares of many
/// neighbours are added in turn. Creep takes one axis after the other: beside rims that hold their height, which comes first
/// shows in the second order of a step, and most near a critical slope (tenfold steps, a hundredfold difference).
#[test]
fn no_river_prefers_a_direction() {
    let drainage = |routing| vec![one(Drainage { routing, ..Drainage::default() })];
    let rivers = Streampower { years_per_step: 500.0, uplift: 2e-4, diffusivity: 0.0, ..Default::default() };
    let creeping = Streampower { diffusivity: 5e-5, ..rivers.clone() };
    let variants = [
        ("drainage d8", drainage(RoutingRule::D8), 0.0),
        ("drainage dinf", drainage(RoutingRule::Dinf), 0.0),
        ("drainage multiple", drainage(RoutingRule::Multiple), 1e-6),
        ("rivers", vec![one(rivers.clone())], 0.0),
        ("rivers with deposition", vec![one(Streampower { deposition: 1.0, ..rivers.clone() })], 1e-6),
        ("rivers, n = 1.3", vec![one(Streampower { slope_exponent: 1.3, ..rivers })], 0.0),
        ("rivers and creep", vec![one(creeping.clone())], 1e-4),
        (
            "rivers and critical creep",
            vec![one(Streampower { critical_slope: 5.0, diffusivity: 5e-6, ..creeping })],
            2e-5,
        ),
    ];
    for (name, processes, tolerance) in variants {
        for rim in rims() {
            for shape in [(19, 13), (16, 16), (1, 9)] {
                let world = funnel(shape, rim, &processes);
                let straight = turned_alike(&world, &processes, 6, tolerance, &format!("{name} {rim:?} {shape:?}"));
                assert_ne!(straight.fingerprint(), world.fingerprint());
            }
        }
    }
}

/// What steps make of a world, after a look that they make the turned of it of every turned one, within `tolerance` of values above 1.
fn turned_alike(world: &World, processes: &[Scheduled], steps: u64, tolerance: f32, what: &str) -> World {
    let run = |mut w: World| {
        CpuEngine::default().simulate(&mut w, processes, Span { from: 0, steps }, &Control::none()).unwrap();
        w
    };
    let straight = run(world.clone());
    for turn in TURNS {
        let (there, back) = (turn.turn(&straight), run(turn.turn(world)));
        for l in there.layers().iter().filter(|l| l.spec.name != "height_rest") {
            let other = back.get(&l.spec.name).unwrap();
            for (a, b) in l.field.iter().zip(other.iter()) {
                let here = format!("{what} {}: {} {a} {b}", turn.name, l.spec.name);
                assert!((a - b).abs() <= tolerance * a.abs().max(1.0), "{here}");
            }
        }
    }
    straight
}

/// Ground in six terraces, so that lakes, flats and equally steep ways are everywhere. No cell lies on a line of symmetry of these
/// grids, where two ways can be alike in everything.
#[test]
fn no_lake_prefers_a_direction() {
    let drainage = |routing| vec![one(Drainage { routing, ..Drainage::default() })];
    let breached = Drainage { depressions: Depressions::Breach, ..Drainage::default() };
    let rivers = Streampower { years_per_step: 500.0, uplift: 2e-4, diffusivity: 0.0, ..Default::default() };
    let variants = [
        ("drainage d8", drainage(RoutingRule::D8), 0.0),
        ("drainage multiple", drainage(RoutingRule::Multiple), 1e-5),
        ("drainage breached", vec![one(breached)], 0.0),
        ("rivers", vec![one(rivers.clone())], 0.0),
        ("rivers rho8", vec![one(Streampower { directions: Descent::Rho8, ..rivers })], 0.0),
    ];
    for (name, processes, tolerance) in variants {
        for rim in rims() {
            for (shape, seed) in [((18, 12), 1), ((18, 12), 2), ((10, 16), 3), ((30, 26), 4)] {
                let mut world = random_world(shape, rim, seed, &processes, &|_, u| u).unwrap();
                world.sea_level_m = -1.0;
                let height = &mut world.layer_mut("height").unwrap().field;
                height.map_in_place(|h| (6.0 * h).floor());
                if let Ok(rest) = world.layer_mut("height_rest") {
                    rest.field.map_in_place(|_| 0.0);
                }
                turned_alike(&world, &processes, 4, tolerance, &format!("{name} {rim:?} {shape:?}"));
            }
        }
    }
}

/// Which of several equally steep ways is taken, the place decides: all come up.
#[test]
fn ties_are_drawn() {
    let grid = Grid::new(40, 40, 1.0, Boundary::OPEN, &Limits::default()).unwrap();
    // Every third cell of every third row stands above level ground.
    let z: Vec<f64> = (0..1600).map(|i| if i % 40 % 3 == 1 && i / 40 % 3 == 1 { 1.0 } else { 0.0 }).collect();
    let out: Vec<bool> = z.iter().map(|&z| z < 1.0).collect();
    let routing = Routing::new(&z, &grid, &out, &Control::none()).unwrap();
    let mut taken = [0; 9];
    routing.directions().iter().for_each(|&d| taken[usize::from(d)] += 1);
    println!("ways taken: {taken:?}");
    assert!([0, 2, 4, 6].iter().all(|&d| (25..60).contains(&taken[d])), "{taken:?}");
    assert!([1, 3, 5, 7].iter().all(|&d| taken[d] == 0), "{taken:?}");
}
