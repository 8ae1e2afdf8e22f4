//! The velocity of fresh water for the eye: direction, and speed as a share of what is quick in this world.
//!
//! Worlds with the layers `flux_x` and `flux_y` say themselves how their water moves. Rivers that came from drained areas are only
//! depths of water: they flow towards the sea or the rim, each cell into the neighbour from which a flood that rises from there would
//! reach it (Barnes, Lehman & Mulla 2014, priority-flood), as fast as Manning's formula says.

use eyot_core::{Field, World};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Less than a millimetre is a film, not a stream.
const LEAST: f32 = 1e-3;

/// Two signed bytes a cell, eastward and southward, and two of filling; `None` if nothing flows.
pub(crate) fn flow(world: &World) -> Option<Vec<[i8; 4]>> {
    let water = world.get("water")?;
    let velocity = match (world.get("flux_x"), world.get("flux_y")) {
        (Some(flux_x), Some(flux_y)) => {
            of_fluxes(flux_x, flux_y, world.get("flux_se").zip(world.get("flux_sw")), water)
        }
        _ => of_depths(world, world.get("height")?, water),
    };
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

/// `flux_x` and `flux_y` live on the eastern and southern faces of cells; a cell's velocity is the mean of its two faces over its
/// depth of water. Fluxes to the south-eastern and the south-western neighbour are added where there are any.
fn of_fluxes(flux_x: &Field, flux_y: &Field, diagonal: Option<(&Field, &Field)>, water: &Field) -> Vec<[f32; 2]> {
    let (w, h) = (water.width(), water.height());
    let mut out = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let depth = water.get(x, y);
            let east = flux_x.get(x, y) + if x > 0 { flux_x.get(x - 1, y) } else { 0.0 };
            let south = flux_y.get(x, y) + if y > 0 { flux_y.get(x, y - 1) } else { 0.0 };
            let (falling, rising) = diagonal.map_or((0.0, 0.0), |(se, sw)| {
                let from_nw = if x > 0 && y > 0 { se.get(x - 1, y - 1) } else { 0.0 };
                let from_ne = if x + 1 < w && y > 0 { sw.get(x + 1, y - 1) } else { 0.0 };
                (from_nw + se.get(x, y), from_ne + sw.get(x, y))
            });
            let v = [0.5 * (east + (falling - rising)) / depth, 0.5 * (south + (falling + rising)) / depth];
            let flows = depth > LEAST && v[0].is_finite() && v[1].is_finite();
            out.push(if flows { v } else { [0.0; 2] });
        }
    }
    out
}

/// Cells that a direction is averaged over downstream: neighbours know eight directions only.
const AHEAD: usize = 5;
/// Cells that its fall is averaged over: floors in steps would make it flow by fits and starts.
const AHEAD_OF_FALL: usize = 20;
/// Least fall of a river: depths made for the eye may leave none.
const LEAST_FALL: f32 = 1e-3;
/// Water whose surface falls less than this from end to end for each of its cells is a lake.
const LEVEL: f32 = 1e-5;

/// Rivers of which only the depth is known. A depth is drawn as if it were a river's all over, so that wide water, which would
/// carry the same through a larger section, is slowed down by its width.
fn of_depths(world: &World, height: &Field, water: &Field) -> Vec<[f32; 2]> {
    let grid = &world.grid;
    let (w, h) = (grid.width, grid.height);
    let sea_level = world.sea_level_m as f32;
    let surface: Vec<f32> = height.iter().zip(water.iter()).map(|(z, d)| z + d).collect();
    let wet: Vec<bool> = (height.iter().zip(water.iter()))
        .map(|(z, d)| d > LEAST && d.is_finite() && z.is_finite() && z >= sea_level)
        .collect();
    let around = |i: usize| (0..8).map(move |k| neighbour(i, k, w, h));
    let at_sea = |i: usize| around(i).flatten().any(|j| height.get(j % w, j / w) < sea_level);
    let at_rim = |i: usize| around(i).any(|j| j.is_none());

    let from_bank = from_bank(&wet, w, h);
    let cell = [grid.cell_x_m as f32, grid.cell_y_m as f32];
    let mut out = vec![[0.0; 2]; w * h];
    let (mut seen, mut known) = (vec![false; w * h], vec![false; w * h]);
    let mut next = vec![usize::MAX; w * h];
    for first in (0..w * h).filter(|&i| wet[i]) {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let (mut body, mut n) = (vec![first], 0);
        while let Some(&i) = body.get(n) {
            n += 1;
            for j in around(i).flatten().filter(|&j| wet[j]) {
                if !std::mem::replace(&mut seen[j], true) {
                    body.push(j);
                }
            }
        }
        let fold = |f: fn(f32, f32) -> f32, start: f32| body.iter().map(|&i| surface[i]).fold(start, f);
        let fall = fold(f32::max, f32::NEG_INFINITY) - fold(f32::min, f32::INFINITY);
        if fall <= LEVEL * body.len() as f32 * cell[0] {
            continue;
        }
        // Its mouths: all places at the sea, else where it is lowest at the rim, else where it is lowest.
        let key = |i: usize| (order(surface[i]), i);
        let mut heap: BinaryHeap<_> = body.iter().filter(|i| at_sea(**i)).map(|&i| Reverse(key(i))).collect();
        if heap.is_empty() {
            let at_rim = body.iter().copied().filter(|&i| at_rim(i)).min_by_key(|&i| key(i));
            heap.extend(at_rim.or_else(|| body.iter().copied().min_by_key(|&i| key(i))).map(|i| Reverse(key(i))));
        }
        heap.iter().for_each(|Reverse((_, i))| known[*i] = true);
        while let Some(Reverse((_, i))) = heap.pop() {
            for j in around(i).flatten().filter(|&j| wet[j]) {
                if !std::mem::replace(&mut known[j], true) {
                    next[j] = i;
                    heap.push(Reverse(key(j)));
                }
            }
        }
        for i in body {
            let place = |i: usize| [(i % w) as f32 * cell[0], (i / w) as f32 * cell[1]];
            let way = |a: usize, b: usize| [0, 1].map(|k| place(b)[k] - place(a)[k]);
            let (mut end, mut near, mut length) = (i, i, 0.0);
            for n in 0..AHEAD_OF_FALL {
                let to = next[end];
                if to == usize::MAX {
                    break;
                }
                let v = way(end, to);
                length += v[0].hypot(v[1]);
                end = to;
                if n < AHEAD {
                    near = end;
                }
            }
            let way = way(i, near);
            let straight = way[0].hypot(way[1]);
            if straight > 0.0 {
                let fall = ((surface[i] - surface[end]) / length).max(LEAST_FALL);
                let depth = water.get(i % w, i / w);
                let speed = depth.powf(2.0 / 3.0) * fall.sqrt() / (from_bank[i] as f32).max(1.0);
                out[i] = way.map(|v| v / straight * speed);
            }
        }
    }
    // A mouth flows as what comes to it.
    for i in (0..w * h).filter(|&i| wet[i] && next[i] == usize::MAX) {
        let above: Vec<[f32; 2]> = around(i).flatten().filter(|&j| next[j] == i).map(|j| out[j]).collect();
        if !above.is_empty() {
            out[i] = [0, 1].map(|k| above.iter().map(|v| v[k]).sum::<f32>() / above.len() as f32);
        }
    }
    out
}

/// A finite height as a number that sorts.
fn order(z: f32) -> i32 {
    let bits = z.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

/// The neighbour in one of eight directions, straight ones first; none beyond the rim.
fn neighbour(i: usize, k: usize, w: usize, h: usize) -> Option<usize> {
    const OFF: [[isize; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]];
    let x = (i % w).checked_add_signed(OFF[k][0]).filter(|x| *x < w)?;
    let y = (i / w).checked_add_signed(OFF[k][1]).filter(|y| *y < h)?;
    Some(y * w + x)
}

/// How many cells it is from each wet cell to dry land; 1 at the bank.
fn from_bank(wet: &[bool], w: usize, h: usize) -> Vec<u32> {
    let mut far = vec![0; wet.len()];
    let mut queue: VecDeque<usize> = (0..wet.len()).filter(|&i| !wet[i]).collect();
    while let Some(i) = queue.pop_front() {
        for j in (0..4).filter_map(|k| neighbour(i, k, w, h)) {
            if wet[j] && far[j] == 0 {
                far[j] = far[i] + 1;
                queue.push_back(j);
            }
        }
    }
    far
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::layer::known;
    use eyot_core::{Boundary, Grid, LayerSpec, Limits};

    #[test]
    fn water_that_flows_east_flows_east() {
        let mut world = World::new(Grid::new(5, 4, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
        assert!(flow(&world).is_none());
        let spec = |n: &'static str| LayerSpec::new(n, "m/s", "Flux", (-1e6, 1e6));
        world.put(&known::WATER, Field::from_fn(5, 4, |_, y| if y == 2 { 1.0 } else { 0.0 })).unwrap();
        world.put(&spec("flux_x"), Field::from_fn(5, 4, |_, _| 0.3)).unwrap();
        world.put(&spec("flux_y"), Field::new(5, 4, 0.0)).unwrap();
        let f = flow(&world).unwrap();
        assert_eq!((f[2 * 5 + 2], f[5 + 2]), ([127, 0, 0, 0], [0; 4]));
    }

    /// A valley that falls to the south, with a river that bends and a lake that does not flow.
    fn river() -> World {
        let (w, h) = (40, 60);
        let mut world = World::new(Grid::new(w, h, 30.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
        world.sea_level_m = 0.0;
        let bed = |x: usize, y: usize| x == if y < 30 { 10 } else { 14 } || (y == 30 && (10..=14).contains(&x));
        let lake = |x: usize, y: usize| (26..34).contains(&x) && (20..30).contains(&y);
        // Flat floors: all that tells the direction is the whole of the way.
        let floor = |y: usize| 100.0 - 5.0 * (y / 6) as f32;
        let height = |x, y| if lake(x, y) { 50.0 } else { floor(y) + if bed(x, y) { 0.0 } else { 8.0 } };
        world.put(&known::HEIGHT, Field::from_fn(w, h, height)).unwrap();
        let water = |x, y| {
            if bed(x, y) {
                1.0 + 0.05 * y as f32
            } else if lake(x, y) {
                4.0
            } else {
                0.0
            }
        };
        world.put(&known::WATER, Field::from_fn(w, h, water)).unwrap();
        world
    }

    #[test]
    fn rivers_without_fluxes_flow_downstream_and_lakes_stand() {
        let world = river();
        let f = flow(&world).unwrap();
        let at = |x: usize, y: usize| f[y * 40 + x];
        for y in (0..28).chain(31..60) {
            let v = at(if y < 30 { 10 } else { 14 }, y);
            assert!(v[1] > 20, "row {y}: {v:?}");
        }
        assert!(at(11, 30)[0] > 20, "east in the bend: {:?}", at(11, 30));
        assert_eq!((at(29, 25), at(20, 10)), ([0; 4], [0; 4]), "a lake and dry land");
        // A river that ends in the sea flows there, though the land rises beyond.
        let mut to_the_sea = river();
        to_the_sea.sea_level_m = 90.0;
        let f = flow(&to_the_sea).unwrap();
        assert!(f[5 * 40 + 10][1] > 20 && f[40 * 40 + 14] == [0; 4], "{:?}", f[5 * 40 + 10]);
    }

    #[test]
    fn wide_water_is_slow() {
        let (w, h) = (30, 30);
        let mut world = World::new(Grid::new(w, h, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 1);
        world.sea_level_m = -1e3;
        world.put(&known::HEIGHT, Field::from_fn(w, h, |_, y| 90.0 - y as f32)).unwrap();
        let wide = |y: usize| if (10..20).contains(&y) { 9 } else { 1 };
        let water = |x: usize, y: usize| if x.abs_diff(15) < wide(y) { 1.0 } else { 0.0 };
        world.put(&known::WATER, Field::from_fn(w, h, water)).unwrap();
        let f = flow(&world).unwrap();
        let speed = |x: usize, y: usize| f32::from(f[y * w + x][0]).hypot(f32::from(f[y * w + x][1]));
        assert!(speed(15, 15) < 0.5 * speed(15, 3) && speed(15, 15) > 0.0);
    }
}
