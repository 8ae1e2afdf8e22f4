//! Lakes and rivers against their definitions.

use eyot_core::component::{Features, Values};
use eyot_core::engine::CpuEngine;
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_noise::picture::fbm;
use eyot_water::rivers::Bed;
use eyot_water::{LAKES, RIVERS, Rivers, Springs, graph_stats};

/// Land with many hollows, which falls to the south-east.
fn land(size: usize, rim: Boundary) -> World {
    tilted(size, rim, [0.7, 0.7])
}

/// Land with many hollows that falls by so many m a cell to the east and to the south.
fn tilted(size: usize, rim: Boundary, fall: [f32; 2]) -> World {
    let mut world = World::new(Grid::new(size, size, 25.0, rim, &Limits::default()).unwrap(), 3);
    world.sea_level_m = -1000.0;
    let z = |x: usize, y: usize| {
        let (u, v) = (x as f32 / 40.0, y as f32 / 40.0);
        500.0 + 120.0 * fbm(u, v, 6, 5) - (fall[0] * x as f32 + fall[1] * y as f32)
    };
    world.put(&HEIGHT, Field::from_fn(size, size, z)).unwrap();
    world
}

fn run(world: &mut World, rivers: &Rivers) -> eyot_core::Result<()> {
    let steps = [Scheduled { name: "rivers", process: Box::new(rivers.clone()), every: 1 }];
    steps[0].process.check(&world.grid)?;
    CpuEngine::default().simulate(world, &steps, Span { from: 0, steps: 1 }, &Control::none()).map(drop)
}

fn column(features: &Features, name: &str) -> Vec<f64> {
    let values: &Values = &features.attributes().get(name).unwrap().values;
    (0..features.len()).map(|i| values.number(i)).collect()
}

fn small() -> Rivers {
    Rivers { min_discharge: 0.002, min_lake_area: 3000.0, width: 60.0, ..Rivers::default() }
}

#[test]
fn every_lake_is_level_to_the_bit_and_every_line_runs_down() {
    for rim in [Boundary::OPEN, Boundary::CLOSED, Boundary::WRAP] {
        let mut world = land(160, rim);
        run(&mut world, &small()).unwrap();
        let rivers = world.components.get::<Features>(RIVERS).unwrap().unwrap();
        let lakes = world.components.get::<Features>(LAKES).unwrap().unwrap();
        assert!(rivers.len() > 50 && lakes.len() > 5, "{} reaches, {} lakes", rivers.len(), lakes.len());
        for i in 0..rivers.len() {
            for line in rivers.parts(i) {
                assert!(line.is_sorted_by(|a, b| a[2] >= b[2]), "reach {i} runs uphill");
            }
        }
        let (id, next) = (column(rivers, "HYRIV_ID"), column(rivers, "NEXT_DOWN"));
        for i in 0..rivers.len() {
            // No loops, and the next reach begins where this one ends.
            let (mut at, mut steps) = (i, 0);
            while next[at] > 0.0 {
                at = next[at] as usize - 1;
                steps += 1;
                assert!(steps <= rivers.len(), "a loop at reach {}", id[i]);
            }
            if next[i] > 0.0 && rim != Boundary::WRAP {
                let end = *rivers.parts(i).last().unwrap().last().unwrap();
                let begin = rivers.parts(next[i] as usize - 1).next().unwrap()[0];
                assert_eq!(end, begin, "reach {} and the one after it", id[i]);
            }
        }
        // Levels: one a lake, met by all its water.
        let levels: Vec<f32> = column(lakes, "LEVEL_M").iter().map(|l| *l as f32).collect();
        let (height, level) = (world.get("height").unwrap().to_vec(), world.get("lake_level").unwrap().to_vec());
        let wet = (0..height.len()).filter(|&i| level[i] != height[i]);
        let mut cells = 0;
        for i in wet {
            assert!(level[i] > height[i] && levels.contains(&level[i]), "cell {i}");
            cells += 1;
        }
        let area: f64 = column(lakes, "AREA_SKM").iter().sum();
        assert!((area * 1e6 / world.grid.cell_area_m2() - f64::from(cells)).abs() <= 1.0, "{area} km2, {cells} cells");
        for i in 0..lakes.len() {
            assert!(lakes.parts(i).flatten().all(|v| v[2] == levels[i]), "the shore of lake {i}");
        }
    }
}

#[test]
fn dry_lakes_have_no_outlet_and_lose_what_comes_in() {
    let dry = Rivers { rain: 0.4, evaporation: 1.4, min_discharge: 1e-4, ..small() };
    let mut world = land(200, Boundary::CLOSED);
    let wet_area = {
        let mut wet = world.clone();
        run(&mut wet, &small()).unwrap();
        graph_stats(&wet).unwrap().unwrap().lake_area_km2
    };
    run(&mut world, &dry).unwrap();
    let stats = graph_stats(&world).unwrap().unwrap();
    assert!(
        stats.closed_lakes > 2 && stats.lake_area_km2 < 0.7 * wet_area,
        "{stats:?}, {wet_area} km2 where it is wet"
    );
    let lakes = world.components.get::<Features>(LAKES).unwrap().unwrap();
    let climate = eyot_water::runoff::Climate { rain: f64::from(dry.rain), evaporation: f64::from(dry.evaporation) };
    let (inflow, outflow, area) =
        (column(lakes, "INFLOW_CMS"), column(lakes, "OUTFLOW_CMS"), column(lakes, "AREA_SKM"));
    for i in (0..lakes.len()).filter(|&i| outflow[i] == 0.0) {
        let lost = area[i] * 1e6 * climate.lake_loss() / eyot_core::process::SECONDS_PER_YEAR;
        // To a cell of its surface.
        let cell = world.grid.cell_area_m2() * climate.lake_loss() / eyot_core::process::SECONDS_PER_YEAR;
        assert!((inflow[i] - lost).abs() <= 3.0 * cell + 0.2 * lost, "lake {i}: {} in, {lost} lost", inflow[i]);
    }
}

#[test]
fn what_is_filled_and_dug_is_in_the_ledger() {
    let mut world = land(120, Boundary::OPEN);
    let before = world.get("height").unwrap().sum() * world.grid.cell_area_m2();
    run(&mut world, &small()).unwrap();
    let after = world.get("height").unwrap().sum() * world.grid.cell_area_m2();
    let net = world.ledger.net("ground");
    assert!(world.ledger.amount("ground.carved") > 0.0 && world.ledger.amount("ground.silted") > 0.0);
    assert!((after - before - net).abs() < 1e-6 * before.abs(), "{} against {net}", after - before);
}

#[test]
fn threads_change_no_byte() {
    let prints: Vec<u64> = [1, 2, 3, 8]
        .into_iter()
        .map(|n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let mut world = land(300, Boundary::OPEN);
            pool.install(|| run(&mut world, &small())).unwrap();
            world.fingerprint()
        })
        .collect();
    assert!(prints.iter().all(|p| *p == prints[0]), "{prints:?}");
}

#[test]
fn springs_in_a_band_count_their_passes_and_dig_by_them() {
    let band = Rivers {
        springs: Springs::Band,
        spring_count: 40,
        spring_low: 300.0,
        spring_high: 480.0,
        bed: Bed::Passes,
        pass_depth: 0.5,
        ..small()
    };
    let mut world = land(160, Boundary::OPEN);
    let before = world.get("height").unwrap().to_vec();
    run(&mut world, &band).unwrap();
    let passes = world.get("river_passes").unwrap().to_vec();
    let most = passes.iter().copied().fold(0.0, f32::max);
    assert!((2.0..=40.0).contains(&most), "{most} passes");
    let after = world.get("height").unwrap();
    let dug = (0..before.len()).filter(|&i| passes[i] >= 2.0 && before[i] - after.row(i / 160)[i % 160] > 0.4).count();
    assert!(dug > 20, "{dug} cells");
}

#[test]
fn what_contradicts_itself_is_refused() {
    let upside_down = Rivers { springs: Springs::Band, spring_low: 900.0, spring_high: 100.0, ..small() };
    let outside = Rivers { springs: Springs::Band, spring_low: 5000.0, spring_high: 6000.0, ..small() };
    let passes = Rivers { bed: Bed::Passes, ..small() };
    for (rivers, words) in [(upside_down, "spring_high"), (outside, "the land lies from"), (passes, "springs")] {
        let mut world = land(64, Boundary::OPEN);
        let error = run(&mut world, &rivers).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn the_graph_has_the_form_of_real_ones() {
    let mut world = land(512, Boundary::OPEN);
    run(&mut world, &small()).unwrap();
    let s = graph_stats(&world).unwrap().unwrap();
    assert!((s.width_exponent.unwrap() - 0.5).abs() < 0.02, "{s:?}");
    assert!((0.45..0.7).contains(&s.hack_exponent.unwrap()), "{s:?}");
    assert!((3.0..5.5).contains(&s.bifurcation_ratio.unwrap()), "{s:?}");
}

#[test]
fn headings_do_not_follow_the_grid() {
    // The land itself falls between the directions of the grid.
    let mut world = tilted(512, Boundary::OPEN, [0.9, 0.37]);
    run(&mut world, &Rivers { min_discharge: 0.0005, ..small() }).unwrap();
    let rivers = world.components.get::<Features>(RIVERS).unwrap().unwrap();
    let (mut along, mut all) = (0.0, 0.0);
    let lake = column(rivers, "LAKE_ID");
    for line in (0..rivers.len()).filter(|&i| lake[i] == 0.0).flat_map(|i| rivers.parts(i)) {
        for pair in line.windows(2) {
            let (dx, dy) = (f64::from(pair[1][0] - pair[0][0]), f64::from(pair[1][1] - pair[0][1]));
            let turn = dy.atan2(dx).to_degrees().rem_euclid(45.0);
            let length = dx.hypot(dy);
            (along, all) = (along + if turn.min(45.0 - turn) <= 1.0 { length } else { 0.0 }, all + length);
        }
    }
    // Alike in all directions would be 0.044.
    assert!(along / all <= 0.05, "{:.4} of the headings", along / all);
}

/// A slow river through a wide plain winds, and its graph stays sound.
#[test]
fn slow_rivers_in_plains_meander() {
    let mut world = World::new(Grid::new(300, 120, 25.0, Boundary::CLOSED, &Limits::default()).unwrap(), 3);
    world.sea_level_m = -1000.0;
    // A plain that falls to the east between two walls, with a faint trough in its middle.
    let z = |x: usize, y: usize| {
        let off = (y as f32 - 59.5).abs();
        200.0 - 0.004 * x as f32 + 0.002 * off + if off > 50.0 { 40.0 } else { 0.0 }
    };
    world.put(&HEIGHT, Field::from_fn(300, 120, z)).unwrap();
    let winding = Rivers { sinuosity: 1.5, min_discharge: 0.02, width: 20.0, ..Rivers::default() };
    let straight = Rivers { sinuosity: 1.0, ..winding.clone() };
    let length = |rivers: &Rivers| {
        let mut world = world.clone();
        run(&mut world, rivers).unwrap();
        let found = world.components.get::<Features>(RIVERS).unwrap().unwrap();
        for i in 0..found.len() {
            assert!(found.parts(i).all(|line| line.is_sorted_by(|a, b| a[2] >= b[2])), "reach {i} runs uphill");
        }
        graph_stats(&world).unwrap().unwrap().length_km
    };
    let (wound, plain) = (length(&winding), length(&straight));
    assert!(wound > 1.02 * plain, "{wound} km, {plain} km as the cells lead");
}

/// A plain, `fall` m lower from cell to cell, below a funnel of hills that its river comes from.
fn trough(fall: f32) -> World {
    let mut world = World::new(Grid::new(500, 160, 25.0, Boundary::CLOSED, &Limits::default()).unwrap(), 3);
    world.sea_level_m = -1000.0;
    let z = |x: usize, y: usize| {
        let off = (y as f32 - 79.5).abs();
        let hills = 0.01 * off * (160.0 - x as f32).max(0.0);
        200.0 - fall * x as f32 + 0.01 * off + hills
    };
    world.put(&HEIGHT, Field::from_fn(500, 160, z)).unwrap();
    world
}

/// Where no two reaches may cross, no two segments of their lines do, but for threads of one reach.
fn crossings(rivers: &Features) -> usize {
    let mut all: Vec<(usize, [[f32; 3]; 2])> = Vec::new();
    for i in 0..rivers.len() {
        all.extend(rivers.parts(i).flat_map(|line| line.windows(2)).map(|p| (i, [p[0], p[1]])));
    }
    let side = |a: [f32; 3], b: [f32; 3], p: [f32; 3]| {
        let f = |v: f32| f64::from(v);
        (f(b[0]) - f(a[0])) * (f(p[1]) - f(a[1])) - (f(b[1]) - f(a[1])) * (f(p[0]) - f(a[0]))
    };
    let cross = |s: &[[f32; 3]; 2], t: &[[f32; 3]; 2]| {
        side(s[0], s[1], t[0]) * side(s[0], s[1], t[1]) < 0.0 && side(t[0], t[1], s[0]) * side(t[0], t[1], s[1]) < 0.0
    };
    all.sort_by(|a, b| a.1[0][0].total_cmp(&b.1[0][0]));
    let mut found = 0;
    for (k, (i, s)) in all.iter().enumerate() {
        let near = all[k + 1..].iter().take_while(|(_, t)| t[0][0] - s[0][0] < 100.0);
        found += near.filter(|(j, t)| i != j && cross(s, t)).count();
    }
    found
}

#[test]
fn rivers_that_are_steep_for_their_water_braid_and_slow_ones_leave_oxbow_lakes() {
    for (fall, braided) in [(0.4, true), (0.004, false)] {
        let mut world = trough(fall);
        let rivers = Rivers { rain: 4.0, min_discharge: 0.05, width: 25.0, sinuosity: 2.2, ..Rivers::default() };
        run(&mut world, &rivers).unwrap();
        let stats = graph_stats(&world).unwrap().unwrap();
        assert_eq!((stats.braided > 0, stats.meandering > 0), (braided, !braided), "{stats:?}");
        assert_eq!(stats.oxbow_lakes > 0, !braided, "{stats:?}");
        let found = world.components.get::<Features>(RIVERS).unwrap().unwrap();
        let threads = column(found, "THREADS");
        for i in 0..found.len() {
            assert_eq!(found.parts(i).count(), threads[i] as usize);
            for line in found.parts(i) {
                assert!(line.is_sorted_by(|a, b| a[2] >= b[2]), "reach {i} runs uphill");
            }
        }
        assert_eq!(crossings(found), 0, "{stats:?}");
        let oxbows = world.components.get::<Features>(eyot_water::OXBOWS).unwrap().unwrap();
        let level = column(oxbows, "LEVEL_M");
        for i in 0..oxbows.len() {
            assert!(oxbows.parts(i).flatten().all(|v| f64::from(v[2]) == level[i]));
        }
        let none = Rivers { braids: false, sinuosity: 1.0, ..rivers };
        let mut led = trough(fall);
        run(&mut led, &none).unwrap();
        let stats = graph_stats(&led).unwrap().unwrap();
        assert_eq!((stats.braided, stats.meandering, stats.oxbow_lakes), (0, 0, 0));
    }
}

/// What stood on the land and what stands there afterwards differ by what the ledger says.
#[test]
fn water_that_runs_off_is_in_the_ledger() {
    let mut world = land(96, Boundary::OPEN);
    world.put(&eyot_core::layer::known::WATER, Field::from_fn(96, 96, |x, y| ((x + y) % 7) as f32)).unwrap();
    let stood = world.layer("water").unwrap().field.sum() * world.grid.cell_area_m2();
    run(&mut world, &small()).unwrap();
    let stands = world.layer("water").unwrap().field.sum() * world.grid.cell_area_m2();
    assert!(stands > 0.0 && stands < stood);
    assert!((stood + world.ledger.net("water") - stands).abs() < 1e-9 * stood);
}
