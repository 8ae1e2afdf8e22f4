//! Plates part: new oceanic crust fills the gap, and the edges of continents stretch into it.

use crate::changes::Changes;
use crate::crust::{OCEANIC_M, is_continental, units};
use crate::drift::Maps;
use crate::geometry::Geometry;
use crate::plate::Plate;
use crate::plates::SLIDES;

/// Fills the gaps that plates left, and returns the new crust, units.
///
/// The cell next to a gap in its plate's direction of motion is the plate's edge. If that is continental, it gives the gap a `stretch`
/// share of its crust, so rifted margins go down in steps; a second time it is too thin. It does not where the plate slips to the
/// side of its way.
pub(crate) fn fill(
    g: &Geometry,
    maps: &Maps,
    gaps: &[u32],
    (plates, shifts): (&[Plate], &[(i8, i8)]),
    stretch: f32,
    changes: &mut Changes,
) -> i64 {
    let mut made = 0;
    for &gap in gaps {
        let gap = gap as usize;
        let owner = maps.owner[gap];
        let (dx, dy) = shifts[usize::from(owner)];
        let edge = g.beside(gap, isize::from(dx), isize::from(dy));
        // A plate that slides along another one slips back and forth.
        let [vx, vy] = plates[usize::from(owner)].velocity;
        let (dx, dy) = (f64::from(dx), f64::from(dy));
        let parts = vx * dx + vy * dy > SLIDES * vx.hypot(vy) * dx.hypot(dy);
        let given = edge.filter(|&e| parts && maps.owner[e] == owner && is_continental(maps.crust[e])).map_or(0, |e| {
            let given = (maps.crust[e] as f32 * stretch) as i32;
            changes.add(e, -given);
            given
        });
        let new = (units(OCEANIC_M) - given).max(0);
        changes.add(gap, given + new);
        made += i64::from(new);
    }
    made
}
