//! What actions and generators hold while they work is what they say: runs are refused by these numbers before they begin.

// Reason for the exception: an allocator that counts is the only witness that sees every byte.
#![allow(unsafe_code)]

use eyot_core::process::{Entry, Generator, Moment, Process, Site};
use eyot_core::{Control, Field, Grid, Limits, Rim, World};
use eyot_land::drainage::{BYTES_PER_CELL, Base, Routing, fill, outlets};
use eyot_land::generate::GENERATORS;
use eyot_land::simulate::PROCESSES;
use serde_json::{Value, json};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, with what is held and the most that was.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands every call on to the system's allocator, and only counts.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Bytes that `work` held at its peak beyond what was held before, per cell.
fn peak<T>(grid: &Grid, work: impl FnOnce() -> T) -> (f64, T) {
    let before = HELD.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    let result = work();
    ((MOST.load(Ordering::Relaxed) - before) as f64 / grid.cells() as f64, result)
}

/// Rough land with depressions, a sea in one corner, and layers for those that look at others.
fn world() -> World {
    let grid = Grid::new(1021, 1009, 20.0, Rim::OPEN, &Limits::default()).unwrap();
    let mut world = World::new(grid, 1);
    let rough = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 257) as f32 + 0.3 * (x + y) as f32 - 20.0;
    let spec = eyot_core::layer::known::HEIGHT;
    world.put(&spec, Field::from_fn(grid.width, grid.height, rough)).unwrap();
    world
}

/// Holds if `measured` does not exceed what was said, and what was said is not half as much again.
fn assert_honest(what: &str, measured: f64, said: usize) {
    println!("{what}: {measured:.2} measured, {said} said");
    // Rows, tables and the allocator's own share do not grow with the grid.
    assert!(measured <= said as f64 + 1.0, "{what} held {measured:.1} bytes per cell and says {said}");
    assert!(said as f64 <= 1.5 * measured + 4.0, "{what} held {measured:.1} bytes per cell and says {said}");
}

fn process(name: &str, parameters: Value) -> Box<dyn Process> {
    let entry: &Entry<dyn Process> = PROCESSES.iter().find(|e| e.name == name).unwrap();
    (entry.make)(parameters).unwrap()
}

fn actions() {
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
        let mut world = world();
        process.layers().iter().for_each(|(spec, value)| drop(world.ensure(spec, *value)));
        if name == "streampower" {
            // Factors that vary take fields of their own.
            for factor in ["uplift", "erodibility"] {
                let spec = eyot_core::LayerSpec::new(factor, "1", "", (0.0, 9.0));
                world.ensure(&spec, 1.0);
            }
        }
        let (grid, action) = (world.grid, process.action().unwrap());
        let moment = Moment { grid, step: 0, turn: 0, sea_level_m: 0.0 };
        let (measured, outcome) = peak(&grid, || action.act(&moment, &mut world, &Control::none()));
        outcome.unwrap();
        assert_honest(&format!("{name} {parameters}"), measured, action.bytes_per_cell());
    }
}

fn drainage() {
    let world = world();
    let grid = &world.grid;
    let mut height = world.get("height").unwrap().to_vec();
    let (measured, cells) = peak(grid, || {
        let outlets = outlets(&height, grid, &Base::default()).unwrap();
        fill(&mut height, grid, &outlets, &Control::none()).unwrap();
        Routing::new(&height, grid, &outlets, &Control::none()).unwrap().upstream_cells()
    });
    assert_eq!(cells.len(), grid.cells());
    assert_honest("fill, route, count", measured, BYTES_PER_CELL);
}

fn generators() {
    let world = world();
    let base = world.get("height").unwrap();
    for entry in GENERATORS {
        let mut parameters = json!({});
        match entry.name {
            "flow" => parameters["routing"] = json!("multiple"),
            "smooth" => parameters["passes"] = json!(3),
            "remap" => parameters["points"] = json!([[0.0, 0.0], [100.0, 50.0]]),
            _ => {}
        }
        let generator: Box<dyn Generator> = (entry.make)(parameters).unwrap();
        let control = Control::none();
        let site = Site::whole(world.grid, 5, &world, &control);
        let (measured, field) = peak(&world.grid, || generator.generate(&site, base));
        field.unwrap_or_else(|e| panic!("{}: {e}", entry.name));
        assert_honest(entry.name, measured, generator.bytes_per_cell(&world.grid));
    }
}

/// One test: the counters see everything that the process allocates.
#[test]
fn memory_is_what_they_say() {
    actions();
    drainage();
    generators();
}
