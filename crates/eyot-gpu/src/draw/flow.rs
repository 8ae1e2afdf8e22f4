//! The velocity of fresh water for the eye: direction, and speed as a share of what is quick in this world.

use eyot_core::{Field, World};

/// Two signed bytes a cell, eastward and southward, and two of filling; `None` if nothing flows.
///
/// `flux_x` and `flux_y` live on the eastern and southern faces of cells; a cell's velocity is the mean of its two faces over its
/// depth of water.
pub(crate) fn flow(world: &World) -> Option<Vec<[i8; 4]>> {
    let [flux_x, flux_y, water] = ["flux_x", "flux_y", "water"].map(|n| world.get(n));
    let velocity = velocity(flux_x?, flux_y?, water?);
    let mut speeds: Vec<f32> = velocity.iter().map(|v| v[0].hypot(v[1])).filter(|s| *s > 0.0).collect();
    if speeds.is_empty() {
        return None;
    }
    let i = (speeds.len() - 1) * 19 / 20;
    let quick = speeds.select_nth_unstable_by(i, f32::total_cmp).1.max(f32::MIN_POSITIVE);
    let byte = |v: f32| (127.0 * v).round() as i8;
    Some(
        velocity
            .iter()
            .map(|v| {
                let share = 1.0 / v[0].hypot(v[1]).max(quick);
                [byte(v[0] * share), byte(v[1] * share), 0, 0]
            })
            .collect(),
    )
}

fn velocity(flux_x: &Field, flux_y: &Field, water: &Field) -> Vec<[f32; 2]> {
    // Less than a millimetre is a film, not a stream.
    const LEAST: f32 = 1e-3;
    let (w, h) = (water.width(), water.height());
    let mut out = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let depth = water.get(x, y);
            let east = flux_x.get(x, y) + if x > 0 { flux_x.get(x - 1, y) } else { 0.0 };
            let south = flux_y.get(x, y) + if y > 0 { flux_y.get(x, y - 1) } else { 0.0 };
            let v = [0.5 * east / depth, 0.5 * south / depth];
            let flows = depth > LEAST && v[0].is_finite() && v[1].is_finite();
            out.push(if flows { v } else { [0.0; 2] });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;
    use eyot_core::{Grid, LayerSpec, Limits, Rim};

    #[test]
    fn water_that_flows_east_flows_east() {
        let mut world = World::new(Grid::new(5, 4, 10.0, Rim::CLOSED, &Limits::default()).unwrap(), 1);
        assert!(flow(&world).is_none());
        let spec = |n: &'static str| LayerSpec::new(n, "m/s", "Flux", (-1e6, 1e6));
        world.put(&known::WATER, Field::from_fn(5, 4, |_, y| if y == 2 { 1.0 } else { 0.0 })).unwrap();
        world.put(&spec("flux_x"), Field::from_fn(5, 4, |_, _| 0.3)).unwrap();
        world.put(&spec("flux_y"), Field::new(5, 4, 0.0)).unwrap();
        let f = flow(&world).unwrap();
        assert_eq!((f[2 * 5 + 2], f[5 + 2]), ([127, 0, 0, 0], [0; 4]));
    }
}
