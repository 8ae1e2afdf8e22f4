//! Ice and rock are found again.

use crate::common::{layer, run, world};
use eyot_core::{Boundary, World};
use eyot_ice::Glaciers;

/// A ridge beside a fjord, under snow.
fn coast(rim: Boundary) -> World {
    let mut world = world((64, 48), 100.0, rim, |x, y| {
        let (x, y) = (x as f32 - 31.5, y as f32 - 24.0);
        1500.0 - 60.0 * x.abs() - 12.0 * y + 90.0 * (0.5 * y).sin()
    });
    world.sea_level_m = 0.0;
    world
}

fn sum(world: &World, name: &str) -> f64 {
    layer(world, name).iter().map(|v| f64::from(*v)).sum::<f64>() * world.grid.cell_area_m2()
}

#[test]
fn the_ledger_closes() {
    for rim in [Boundary::OPEN, Boundary::CLOSED, Boundary::WRAP] {
        let mut world = coast(rim);
        let before = sum(&world, "height");
        let glaciers = Glaciers { ela: 600.0, ice_years: 60.0, ..Glaciers::default() };
        run(&mut world, &glaciers, 3).unwrap();
        let amount = |name: &str| world.ledger.amount(name);
        let ice = sum(&world, "glacier");
        assert!(ice > 1e8 && amount("glacier.melted") > 1e8, "{ice} {}", amount("glacier.melted"));
        assert!((world.ledger.net("glacier") - ice).abs() < 1e-6 * ice, "{} {ice}", world.ledger.net("glacier"));
        assert!(amount("glacier.rounded").abs() < 1e-5 * amount("glacier.snow"), "{}", amount("glacier.rounded"));
        let gained = sum(&world, "height") - before;
        let taken = amount("ground.taken_by_ice");
        assert!(taken > 1e6 && (world.ledger.net("ground") - gained).abs() < 1e-6 * taken, "{taken} {gained}");
        assert!(world.ledger.net("debris").abs() < 1e-6 * taken && amount("debris.washed_out") > 0.0);
        assert!(layer(&world, "glacier").iter().all(|h| *h >= 0.0));
        assert_eq!(amount("glacier.left") > 0.0, rim == Boundary::OPEN);
        assert!(amount("glacier.calved") > 0.0);
    }
}

#[test]
fn mirrored_land_has_mirrored_ice() {
    let mut world = coast(Boundary::CLOSED);
    run(&mut world, &Glaciers { ela: 600.0, ice_years: 40.0, ..Glaciers::default() }, 1).unwrap();
    let ice = layer(&world, "glacier");
    let thick = ice.iter().fold(0.0f32, |a, b| a.max(*b));
    for y in 0..48 {
        for x in 0..64 {
            let (a, b) = (ice[y * 64 + x], ice[y * 64 + 63 - x]);
            assert!((a - b).abs() < 1e-3 * thick, "{a} and {b} of {thick} m at {x}, {y}");
        }
    }
}

#[test]
fn a_climate_gives_the_balance_where_there_is_one() {
    use eyot_core::{Field, LayerSpec};
    let mut world = coast(Boundary::CLOSED);
    let put = |world: &mut World, name: &'static str, value: f32| {
        world.put(&LayerSpec::new(name, "1", "Climate", (-1e4, 1e4)), Field::new(64, 48, value)).unwrap();
    };
    put(&mut world, "precipitation", 2000.0);
    put(&mut world, "temperature", 12.0);
    let glaciers = Glaciers { ela: -5000.0, ice_years: 5.0, ..Glaciers::default() };
    run(&mut world, &glaciers, 1).unwrap();
    assert_eq!(sum(&world, "glacier"), 0.0, "it is warm");
    put(&mut world, "temperature", -12.0);
    run(&mut world, &glaciers, 1).unwrap();
    assert!(sum(&world, "glacier") > 1e8, "it is cold");
}
