//! Water runs as the land falls, and not as the grid lies: the share of diagonal steps in small channels.
//!
//! Isotropic is 0.414; criterion 0.38 to 0.45. Measured 0.411 to 0.442; with pipes to four neighbours the same lands have 0.298
//! to 0.322.

use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Scheduled, Span};
use eyot_core::rng::{self, Key};
use eyot_core::{Boundary, Field, Grid, Limits, World};
use eyot_drainage::Descent;
use eyot_land::analyse::diagonal_share;
use eyot_land::simulate::hydraulic::{FluxForm, Hydraulic};
use eyot_land::simulate::{Streampower, Thermal};

const SIZE: usize = 192;
/// Cells that drain through small channels.
const SMALL: std::ops::RangeInclusive<u32> = 30..=1000;

/// Rough ground: waves in random directions, lower ones the shorter they are. It can be turned by any angle.
fn rough(x: f64, y: f64) -> f64 {
    let random = |i: u32, stream| f64::from(rng::unit::<f32>(rng::hash(Key::new(7, stream, 0), i)));
    (0..160)
        .map(|i| {
            let length = 400.0 * 0.05_f64.powf(random(i, 0));
            let (angle, phase) = (std::f64::consts::TAU * random(i, 1), std::f64::consts::TAU * random(i, 2));
            let along = x * angle.cos() + y * angle.sin();
            0.03 * length * (std::f64::consts::TAU * along / length + phase).sin()
        })
        .sum()
}

/// Ground of cells of 10 m, turned by `degrees` about its middle.
fn land(degrees: f64, height: impl Fn(f64, f64) -> f64) -> World {
    let mut world = World::new(Grid::new(SIZE, SIZE, 10.0, Boundary::OPEN, &Limits::default()).unwrap(), 1);
    world.sea_level_m = -1e4;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let field = Field::from_fn(SIZE, SIZE, |x, y| {
        let (x, y) = (10.0 * (x as f64 - SIZE as f64 / 2.0), 10.0 * (y as f64 - SIZE as f64 / 2.0));
        height(cos * x + sin * y, cos * y - sin * x) as f32
    });
    world.ensure(&HEIGHT, 0.0).field = field;
    world
}

fn share(mut world: World, flux: FluxForm) -> f64 {
    let one = |name, process, every| Scheduled { name, process, every };
    let rain = Hydraulic { flux, rain: 0.002, capacity: 2.0, ..Hydraulic::default() };
    let processes = [
        one("hydraulic", Box::new(rain) as _, 1),
        one("thermal", Box::new(Thermal { talus: 42.0, ..Thermal::default() }) as _, 10),
    ];
    CpuEngine::default().simulate(&mut world, &processes, Span { from: 0, steps: 600 }, &Control::none()).unwrap();
    diagonal_share(world.get("height").unwrap(), &world.grid, None, SMALL).unwrap().unwrap()
}

#[test]
fn gullies_do_not_follow_the_grid() {
    let cone = |x: f64, y: f64| 500.0 - 0.5 * x.hypot(y) + 0.5 * rough(x, y);
    let cases: [(&str, World); 4] = [
        ("rough ground", land(0.0, rough)),
        ("cone", land(0.0, cone)),
        ("cone turned by 22.5 degrees", land(22.5, cone)),
        ("cone turned by 45 degrees", land(45.0, cone)),
    ];
    for (name, world) in cases {
        let (eight, four) = (share(world.clone(), FluxForm::Eight), share(world, FluxForm::Signed));
        println!("{name}: {eight:.3}, with four pipes {four:.3}");
        assert!((0.38..=0.45).contains(&eight), "{name}: {eight:.3}");
        assert!(four < eight, "{name}: {four:.3}");
    }
}

/// The measure itself, on ramps that are smooth but for a little noise: along an axis, diagonally, and all ways at once.
#[test]
fn the_measure_knows_directions() {
    let ramp = |degrees| {
        let w = land(degrees, |x, y| 0.2 * x + 1e-3 * rough(x, y));
        diagonal_share(w.get("height").unwrap(), &w.grid, None, SMALL).unwrap().unwrap()
    };
    let (axis, diagonal) = (ramp(0.0), ramp(45.0));
    println!("axis {axis:.3}, diagonal {diagonal:.3}");
    assert!(axis < 0.05 && diagonal > 0.95);
}

/// The smallest valleys of stream power keep less to the grid with rho8 than with the steepest of eight, larger ones no more.
#[test]
fn valleys_of_stream_power_keep_less_to_the_grid() {
    let shares = |directions| {
        let p = Streampower { directions, years_per_step: 20_000.0, ..Streampower::default() };
        let mut world = land(0.0, |x, y| 0.02 * rough(x, y));
        world.grid = Grid::new(SIZE, SIZE, 30.0, Boundary::OPEN, &Limits::default()).unwrap();
        let process = [Scheduled { name: "streampower", process: Box::new(p), every: 1 }];
        CpuEngine::default().simulate(&mut world, &process, Span { from: 0, steps: 60 }, &Control::none()).unwrap();
        let share = |cells| diagonal_share(world.get("height").unwrap(), &world.grid, None, cells).unwrap().unwrap();
        [share(8..=29), share(30..=299), share(300..=3000)]
    };
    let (rho8, d8) = (shares(Descent::Rho8), shares(Descent::D8));
    println!("rho8 {rho8:.3?}, d8 {d8:.3?}");
    // Measured 0.308, 0.301, 0.473 and 0.213, 0.281, 0.468; 0.414 if all directions were alike.
    assert!(0.414 - rho8[0] < 0.7 * (0.414 - d8[0]) && rho8[1] >= d8[1], "{rho8:?} {d8:?}");
    assert!([rho8[2], d8[2]].iter().all(|s| (0.38..0.5).contains(s)), "{rho8:?} {d8:?}");
}
