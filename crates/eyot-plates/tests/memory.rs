//! What a step of plates holds while it works is what it says: runs are refused by this number before they begin.

// Reason for the exception: an allocator that counts is the only witness that sees every byte.
#![allow(unsafe_code)]

use eyot_core::process::{Moment, Process};
use eyot_core::{Control, Edge, Grid, Limits, Rim, World};
use eyot_plates::Tectonics;
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

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Large blocks grow where they are, or move without a copy.
        let held = HELD.fetch_add(size, Ordering::Relaxed) + size - layout.size();
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        MOST.fetch_max(held, Ordering::Relaxed);
        // SAFETY: the caller's promise.
        unsafe { System.realloc(at, layout, size) }
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

#[test]
fn a_step_holds_what_it_says() {
    let grid = Grid::new(515, 261, 78_125.0, Rim { x: Edge::Wrap, y: Edge::Closed }, &Limits::default()).unwrap();
    let mut most: f64 = 0.0;
    for (count, cycle) in [(2, 0.0), (10, 300.0), (30, 5.0)] {
        let plates = Tectonics { count, cycle, ..Tectonics::default() };
        let mut world = World::new(grid, 3);
        for (spec, value) in plates.layers() {
            world.ensure(&spec, value);
        }
        let action = plates.action().unwrap();
        plates.prepare(&mut world).unwrap();
        // New plates are made within them.
        for step in 0..12 {
            let moment = Moment { grid, step, turn: step, sea_level_m: 0.0 };
            let (bytes, _) = peak(&grid, || action.act(&moment, &mut world, &Control::none()).unwrap());
            most = most.max(bytes);
        }
        println!("{count} plates: {most:.1} bytes a cell");
    }
    let said = Tectonics::default().action().unwrap().bytes_per_cell() as f64;
    assert!(most <= 1.05 * said + 1.0 && said <= 1.5 * most + 4.0, "{most} measured, {said} said");
}
