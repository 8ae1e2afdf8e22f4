//! Arrows on maps: where a flow of two layers goes, and how strong it is.

use crate::picture::Picture;
use eyot_core::{Field, Result, World};

/// Pixels between two arrows.
const SPACING: usize = 22;
/// Length of the longest arrow, pixels.
const LENGTH: f32 = 18.0;
/// Half the width of a stroke, pixels.
const STROKE: f32 = 0.55;
const INK: [f32; 3] = [24.0, 26.0, 32.0];

/// Draws arrows over a map of the world. `flow`: names of the layers of the flow to the east and to the south.
///
/// # Errors
/// If the world has no such layers.
pub(crate) fn draw(map: &mut Picture, world: &World, flow: [&str; 2]) -> Result<()> {
    let [east, south] = [&world.layer(flow[0])?.field, &world.layer(flow[1])?.field];
    let strongest = east.iter().chain(south.iter()).fold(0.0f32, |m, v| if v.is_finite() { m.max(v.abs()) } else { m });
    if strongest <= 0.0 {
        return Ok(());
    }
    for cy in (SPACING / 2..map.height).step_by(SPACING) {
        for cx in (SPACING / 2..map.width).step_by(SPACING) {
            let (u, v) = (mean(east, map, cx, cy), mean(south, map, cx, cy));
            let scale = LENGTH / strongest;
            arrow(map, [cx as f32, cy as f32], [u * scale, v * scale]);
        }
    }
    Ok(())
}

/// The value at a pixel, mean of the cells between it and the next arrows.
fn mean(field: &Field, map: &Picture, cx: usize, cy: usize) -> f32 {
    let cell = |p: usize, pixels: usize, cells: usize| (p * cells / pixels).min(cells - 1);
    let half = SPACING / 2;
    let columns = cell(cx.saturating_sub(half), map.width, field.width())..=cell(cx + half, map.width, field.width());
    let rows = cell(cy.saturating_sub(half), map.height, field.height())..=cell(cy + half, map.height, field.height());
    let (mut sum, mut count) = (0.0, 0.0);
    for y in rows {
        for v in columns.clone().map(|x| field.get(x, y)).filter(|v| v.is_finite()) {
            (sum, count) = (sum + v, count + 1.0);
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// An arrow through `middle` along `way`, pixels.
fn arrow(map: &mut Picture, middle: [f32; 2], way: [f32; 2]) {
    let length = way[0].hypot(way[1]);
    if length < 1.5 {
        return;
    }
    let along = way.map(|w| w / length);
    let tip = [middle[0] + 0.5 * way[0], middle[1] + 0.5 * way[1]];
    stroke(map, [middle[0] - 0.5 * way[0], middle[1] - 0.5 * way[1]], tip);
    let head = (0.38 * length).clamp(2.0, 5.0);
    for side in [-0.5, 0.5] {
        let back = [along[0] - side * along[1], along[1] + side * along[0]];
        stroke(map, [tip[0] - head * back[0], tip[1] - head * back[1]], tip);
    }
}

/// A straight stroke with soft edges.
fn stroke(map: &mut Picture, from: [f32; 2], to: [f32; 2]) {
    let low = |k: usize| (from[k].min(to[k]) - 2.0).max(0.0) as usize;
    let high = |k: usize, most: usize| ((from[k].max(to[k]) + 3.0).max(0.0) as usize).min(most);
    let run = [to[0] - from[0], to[1] - from[1]];
    let square = (run[0] * run[0] + run[1] * run[1]).max(1e-6);
    for y in low(1)..high(1, map.height) {
        for x in low(0)..high(0, map.width) {
            let off = [x as f32 - from[0], y as f32 - from[1]];
            let t = ((off[0] * run[0] + off[1] * run[1]) / square).clamp(0.0, 1.0);
            let distance = (off[0] - t * run[0]).hypot(off[1] - t * run[1]);
            let cover = (STROKE + 0.5 - distance).clamp(0.0, 1.0) * 0.85;
            let pixel = &mut map.pixels[y * map.width + x];
            for k in 0..3 {
                pixel[k] = (f32::from(pixel[k]) * (1.0 - cover) + INK[k] * cover).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Grid, LayerSpec, Limits};

    /// East wind draws level strokes, and calm air none.
    #[test]
    fn arrows_follow_the_flow() {
        let world = |u: f32, v: f32| {
            let mut w = World::new(Grid::new(8, 8, 1.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
            for (name, value) in [("u", u), ("v", v)] {
                w.put(&LayerSpec::new(name, "m/s", "", (-9.0, 9.0)), Field::new(8, 8, value)).unwrap();
            }
            w
        };
        let drawn = |u: f32, v: f32| {
            let mut map = Picture::new(SPACING, SPACING, [255; 3]);
            draw(&mut map, &world(u, v), ["u", "v"]).unwrap();
            map
        };
        let dark = |map: &Picture, x: usize, y: usize| map.get(x, y)[0] < 128;
        let middle = SPACING / 2;
        let east = drawn(5.0, 0.0);
        assert!((middle - 6..middle + 6).all(|x| dark(&east, x, middle)) && !dark(&east, middle - 6, middle - 3));
        // The head is at the eastern end.
        let inked = |map: &Picture, x: usize| (0..SPACING).filter(|&y| map.get(x, y)[0] < 250).count();
        let half = |columns: std::ops::Range<usize>| columns.map(|x| inked(&east, x)).sum::<usize>();
        assert!(half(middle + 1..SPACING) > half(0..middle), "{} {}", half(middle + 1..SPACING), half(0..middle));
        let south = drawn(0.0, 5.0);
        assert!((middle - 6..middle + 6).all(|y| dark(&south, middle, y)));
        assert!(drawn(0.0, 0.0).pixels.iter().all(|p| *p == [255; 3]));
    }
}
