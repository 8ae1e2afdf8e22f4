//! Worlds that are too large for a texture, in coarser cells.

use eyot_core::{Field, Grid, Limits, World};
use eyot_gpu::Result;
use std::borrow::Cow;

/// Layers that a scene reads, beside the one that it may wear.
const READ: [&str; 11] = [
    "height",
    "water",
    "wetness",
    "limestone",
    "growth",
    "aridity",
    "material",
    "flux_x",
    "flux_y",
    "flux_se",
    "flux_sw",
];

/// `world`, or means over squares of `cells` of it.
///
/// # Errors
/// If the coarser grid is none, which a sound world does not give.
pub(crate) fn shrunk<'a>(world: &'a World, cells: usize, also: Option<&str>) -> Result<Cow<'a, World>> {
    if cells <= 1 {
        return Ok(Cow::Borrowed(world));
    }
    let g = &world.grid;
    let grid = Grid {
        width: g.width.div_ceil(cells),
        height: g.height.div_ceil(cells),
        cell_x_m: g.cell_x_m * cells as f64,
        cell_y_m: g.cell_y_m * cells as f64,
        ..*g
    };
    let mut out = World::new(grid.checked(&Limits::default())?, world.seed);
    out.sea_level_m = world.sea_level_m;
    for layer in world.layers() {
        if READ.contains(&&*layer.spec.name) || also == Some(&*layer.spec.name) {
            // There is no mean of kinds.
            let shrunk = if layer.spec.name == "material" { middles } else { means };
            out.put(&layer.spec, shrunk(&layer.field, grid.width, grid.height, cells))?;
        }
    }
    Ok(Cow::Owned(out))
}

fn middles(field: &Field, width: usize, height: usize, cells: usize) -> Field {
    let middle = |i: usize, n: usize| (i * cells + cells / 2).min(n - 1);
    Field::from_fn(width, height, |x, y| field.get(middle(x, field.width()), middle(y, field.height())))
}

fn means(field: &Field, width: usize, height: usize, cells: usize) -> Field {
    Field::from_fn(width, height, |x, y| {
        let (mut sum, mut n) = (0.0f64, 0u32);
        for row in y * cells..((y + 1) * cells).min(field.height()) {
            let values = &field.row(row)[x * cells..((x + 1) * cells).min(field.width())];
            for v in values.iter().filter(|v| v.is_finite()) {
                (sum, n) = (sum + f64::from(*v), n + 1);
            }
        }
        if n > 0 { (sum / f64::from(n)) as f32 } else { f32::NAN }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::Boundary;
    use eyot_core::layer::known;

    #[test]
    fn means_keep_extent_and_values() {
        let mut world = World::new(Grid::new(7, 4, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 3);
        world.put(&known::HEIGHT, Field::from_fn(7, 4, |x, _| x as f32)).unwrap();
        let s = shrunk(&world, 2, None).unwrap();
        assert_eq!((s.grid.width, s.grid.height, s.grid.cell_x_m), (4, 2, 20.0));
        assert_eq!(s.get("height").unwrap().row(1), [0.5, 2.5, 4.5, 6.0]);
        assert!(matches!(shrunk(&world, 1, None).unwrap(), Cow::Borrowed(_)));
    }
}
