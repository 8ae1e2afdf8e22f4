//! What actions and generators hold while they work is what they say: runs are refused by these numbers before they begin.

use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Entry, Generator, Moment, Process, Site};
use eyot_core::{Boundary, Control, Field, Grid, LayerSpec, Limits, World};
use eyot_drainage::{BYTES_PER_CELL, Base, Routing, fill, outlets};
use eyot_land::generate::GENERATORS;
use eyot_land::simulate::PROCESSES;
use eyot_testing::counting::{Counting, peak};
use serde_json::{Value, json};

#[global_allocator]
static COUNTING: Counting = Counting;

/// The height at (column, row).
type Heights = fn(usize, usize) -> f32;

/// Land that is hard to drain: a plain, on which all is one flat; the most pits that there can be; hills with some of both.
const LANDS: [(&str, Heights); 3] = [
    ("plain", |_, _| 5.0),
    ("pits", |x, y| if x % 2 == 1 && y % 2 == 1 { hashed(x, y) } else { 100.0 + hashed(x, y) }),
    ("hills", |x, y| 0.3 * (x + y) as f32 + (0.1 * hashed(x / 3, y / 3)).floor() - 20.0),
];

/// A number from 0 to 256.
fn hashed(x: usize, y: usize) -> f32 {
    ((x * 7919 + y * 104_729 + x * y * 31) % 1021) as f32 * 0.25
}

fn world(land: Heights) -> World {
    let grid = Grid::new(515, 521, 20.0, Boundary::OPEN, &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    world.put(&HEIGHT, Field::from_fn(grid.width, grid.height, land)).unwrap();
    world
}

/// What did not hold, all of it, so that one run of the test says every number.
#[derive(Default)]
struct Findings(Vec<String>);

impl Findings {
    /// Notes it if what was measured on some land exceeds what was said, or if that is half as much again.
    fn compare(&mut self, what: &str, measured: [f64; LANDS.len()], said: usize) {
        let measured = measured.into_iter().fold(0.0, f64::max);
        println!("{what}: {measured:.2} measured, {said} said");
        // Rows, tables and the allocator's own share do not grow with the grid.
        if measured > 1.05 * said as f64 + 1.0 || said as f64 > 1.5 * measured + 4.0 {
            self.0.push(format!("{what} held {measured:.1} bytes per cell and says {said}"));
        }
    }
}

fn process(name: &str, parameters: Value) -> Box<dyn Process> {
    let entry: &Entry<dyn Process> = PROCESSES.iter().find(|e| e.name == name).unwrap();
    (entry.make)(parameters).unwrap()
}

fn actions(found: &mut Findings) {
    for (name, parameters) in [
        ("drainage", json!({})),
        ("drainage", json!({ "routing": "multiple" })),
        ("drainage", json!({ "depressions": "fill" })),
        ("drainage", json!({ "depressions": "breach" })),
        ("streampower", json!({})),
        ("streampower", json!({ "slope_exponent": 1.7 })),
        ("streampower", json!({ "diffusivity": 0.0 })),
    ] {
        let process = process(name, parameters.clone());
        let action = process.action().unwrap();
        let most = LANDS.map(|(land, heights)| {
            let mut world = world(heights);
            for l in process.layers() {
                world.ensure(&l.spec, l.start);
            }
            if name == "streampower" {
                // Factors that vary take room of their own.
                for factor in ["uplift", "erodibility"] {
                    world.ensure(&LayerSpec::new(factor, "1", "", (0.0, 9.0)), 1.0);
                }
            }
            let (grid, sea_level_m) = (world.grid, 0.0);
            let moment = Moment::whole(grid, 0, sea_level_m);
            let (measured, outcome) = peak(&grid, || {
                let mut instance = action.instantiate(&world)?;
                instance.act(&moment, &mut world, &Control::none())
            });
            outcome.unwrap();
            println!("  {land}: {measured:.2}");
            measured
        });
        found.compare(&format!("{name} {parameters}"), most, action.bytes_per_cell());
    }
}

fn drainage(found: &mut Findings) {
    let most = LANDS.map(|(land, heights)| {
        let world = world(heights);
        let grid = &world.grid;
        let mut height = world.get("height").unwrap().to_vec();
        let (measured, cells) = peak(grid, || {
            let outlets = outlets(&height, grid, &Base::default()).unwrap();
            fill(&mut height, grid, &outlets, &Control::none()).unwrap();
            Routing::new(&height, grid, &outlets, &Control::none()).unwrap().upstream_cells()
        });
        assert_eq!(cells.len(), grid.cells());
        println!("  {land}: {measured:.2}");
        measured
    });
    found.compare("fill, route, count", most, BYTES_PER_CELL);
}

fn generators(found: &mut Findings) {
    for entry in GENERATORS {
        let mut parameters = json!({});
        match entry.name {
            "flow" => parameters["routing"] = json!("multiple"),
            "smooth" => parameters["passes"] = json!(3),
            "remap" => parameters["points"] = json!([[0.0, 0.0], [100.0, 50.0]]),
            _ => {}
        }
        let generator: Box<dyn Generator> = (entry.make)(parameters).unwrap();
        let mut said = 0;
        let most = LANDS.map(|(_, heights)| {
            let (world, control) = (world(heights), Control::none());
            let base = world.get("height").unwrap();
            let site = Site::whole(world.grid, 5, &world, &control);
            said = generator.bytes_per_cell(&world.grid);
            let (measured, field) = peak(&world.grid, || generator.generate(&site, base));
            field.unwrap_or_else(|e| panic!("{}: {e}", entry.name));
            measured
        });
        found.compare(entry.name, most, said);
    }
}

/// One test: the counters see everything that the process allocates.
#[test]
fn memory_is_what_they_say() {
    let mut found = Findings::default();
    actions(&mut found);
    drainage(&mut found);
    generators(&mut found);
    assert!(found.0.is_empty(), "{:#?}", found.0);
}
