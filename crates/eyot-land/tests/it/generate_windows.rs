//! A generator that says how far it looks gives the same bytes in windows of any height as in one piece.
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Boundary, BoundaryCondition, Control, Field, Grid, Limits, World};
use eyot_land::generate::GENERATORS;
use serde_json::{Value, json};

/// The rows of `field` that `rows` number; numbers may lie beyond a wrapping rim.
fn cut(field: &Field, rows: std::ops::Range<isize>) -> Field {
    let h = field.height() as isize;
    Field::from_fn(field.width(), rows.len(), |x, y| field.get(x, (rows.start + y as isize).rem_euclid(h) as usize))
}

/// A world of some rows of the base, as the layer `height`.
fn world(grid: Grid, base: &Field) -> World {
    let mut world = World::new(Grid { height: base.height(), ..grid }, 1);
    world.put(&HEIGHT, base.clone()).unwrap();
    world
}

fn in_windows(what: &dyn Generator, grid: Grid, base: &Field, height: usize) -> Field {
    let reach = what.reach(&grid);
    let mut made = Field::new(grid.width, grid.height, f32::NAN);
    for start in (0..grid.height).step_by(height) {
        let rows = start..(start + height).min(grid.height);
        let held = cut(base, reach.around(&grid, &rows));
        let (world, control) = (world(grid, &held), Control::none());
        let site = Site { rows: rows.clone(), ..Site::whole(grid, 7, &world, &control) };
        let part = what.generate(&site, &held).unwrap();
        assert_eq!((part.width(), part.height()), (grid.width, rows.len()));
        rows.zip(part.rows()).for_each(|(y, row)| made.row_mut(y).copy_from_slice(row));
    }
    made
}

/// Parameters beside the defaults that change how far a generator looks or what it looks at.
fn variants(name: &str) -> Vec<Value> {
    let more = match name {
        "crater" => vec![json!({ "level_m": 40.0, "crest_m": 5.0 })],
        "fbm" => vec![json!({ "warp": 0.4 }), json!({ "basis": "perlin", "octaves": 3 })],
        "smooth" => vec![
            json!({ "sigma_m": 35.0, "passes": 2 }),
            json!({ "kernel": "binomial", "passes": 5 }),
            json!({ "kernel": "gentle", "passes": 3 }),
        ],
        "terraces" => vec![json!({ "step_m": 12.0 })],
        "remap" => {
            vec![json!({ "from": [0.0, 90.0], "clamp": false }), json!({ "from": [5.0, 50.0], "curve": "linear" })]
        }
        "mask_slope" => vec![json!({ "scale_m": 50.0, "to": 60.0 })],
        "mask_curvature" => vec![json!({ "shape": "concave", "scale_m": 140.0 })],
        "diamond_square" => vec![json!({ "scale_m": 77.0, "roughness": 0.7 })],
        "worley" => vec![json!({ "distance": "f1", "jitter": 0.5 })],
        "warp" => vec![json!({ "strength": 0.1, "interpolation": "linear" })],
        _ => Vec::new(),
    };
    std::iter::once(json!({})).chain(more).collect()
}

#[test]
fn windows_make_the_same_bytes() {
    let mut tried = Vec::new();
    for rim in [
        Boundary::CLOSED,
        Boundary::OPEN,
        Boundary::WRAP,
        Boundary { x: BoundaryCondition::Closed, y: BoundaryCondition::Wrap },
    ] {
        let grid = Grid { width: 45, height: 150, cell_x_m: 10.0, cell_y_m: 14.0, rim };
        let grid = grid.checked(&Limits::default()).unwrap();
        let base = Field::from_fn(45, 150, |x, y| ((x * 37 + y * y * 13) % 101) as f32);
        for entry in GENERATORS {
            for parameters in variants(entry.name) {
                let what = (entry.make)(parameters.clone()).unwrap();
                if what.reach(&grid) == Reach::Whole {
                    continue;
                }
                tried.push(entry.name);
                let (world, control) = (world(grid, &base), Control::none());
                let whole = what.generate(&Site::whole(grid, 7, &world, &control), &base).unwrap();
                for height in [1, 7, 64] {
                    let made = in_windows(&*what, grid, &base, height);
                    let same = made.iter().zip(whole.iter()).all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "{} {parameters}: windows of {height} rows on {rim:?}", entry.name);
                }
            }
        }
    }
    let whole = ["breach", "fill", "flow", "hypsometry"];
    for name in GENERATORS.iter().map(|e| e.name).filter(|n| !whole.contains(n)) {
        assert!(tried.contains(&name), "{name} can be cut, but says that it cannot");
    }
}
