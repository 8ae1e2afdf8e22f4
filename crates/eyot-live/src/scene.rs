//! The state that a stream shows, and the records that lead from one to the next.

use crate::record::{Alga, Body, Colony, Hello, Moment, PART, RAYS, Record, Tile, Why};
use std::cmp::Ordering;

/// Everything that a client can know at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Where the run is. Number and counts of the living are filled in by whoever sends it.
    pub moment: Moment,
    /// Colonies, by their ids.
    pub colonies: Vec<Colony>,
    /// Macroalgae, by their ids.
    pub algae: Vec<Alga>,
    /// A field for each layer of [`Hello`]; `None` for those that no step has made yet.
    pub layers: Vec<Option<Raster>>,
}

/// The values of a layer, row by row from the north.
#[derive(Clone, Debug, Default)]
pub struct Raster {
    /// Columns.
    pub width: u32,
    /// Values.
    pub values: Vec<f32>,
}

impl Raster {
    fn height(&self) -> u32 {
        self.values.len().checked_div(self.width as usize).unwrap_or(0) as u32
    }

    fn row(&self, y: u32) -> &[f32] {
        let w = self.width as usize;
        &self.values[y as usize * w..(y as usize + 1) * w]
    }
}

impl PartialEq for Raster {
    /// Bit by bit: what is not a number equals itself, and 0 is not -0.
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width && same(&self.values, &other.values)
    }
}

fn same(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

impl Scene {
    /// Puts individuals in the order of their ids, and counts them.
    pub(crate) fn tidy(&mut self) {
        self.colonies.sort_unstable_by_key(|c| c.id);
        self.algae.sort_unstable_by_key(|a| a.id);
        self.moment.living = [self.colonies.len() as u32, self.algae.len() as u32];
    }

    /// Bytes that it holds, about.
    pub(crate) fn bytes(&self) -> usize {
        let layers: usize = self.layers.iter().flatten().map(|r| size_of_val(&*r.values)).sum();
        layers + size_of_val(&*self.colonies) + size_of_val(&*self.algae) + size_of::<Self>()
    }

    /// The whole state as records.
    pub(crate) fn snapshot(&self, hello: &Hello) -> Vec<Record> {
        let mut bodies = vec![Body::Snapshot(self.moment.clone())];
        add_colonies(&mut bodies, Why::All, hello.rays, &self.colonies);
        add_algae(&mut bodies, Why::All, &self.algae);
        for (i, raster) in self.layers.iter().enumerate() {
            if let Some(raster) = raster {
                add_tiles(&mut bodies, i as u16, raster, 0, raster.height(), [0, raster.width]);
            }
        }
        numbered(bodies)
    }

    /// What leads from `before` here as records.
    pub(crate) fn changes(&self, before: &Self, hello: &Hello) -> Vec<Record> {
        let mut bodies = vec![Body::Step(self.moment.clone())];
        let colonies = compare(&before.colonies, &self.colonies, |c| c.id);
        let algae = compare(&before.algae, &self.algae, |a| a.id);
        let mut gone = colonies.gone;
        gone.extend(algae.gone);
        for part in gone.chunks(PART / 8) {
            bodies.push(Body::Gone(part.to_vec()));
        }
        add_colonies(&mut bodies, Why::Born, hello.rays, &colonies.born);
        add_colonies(&mut bodies, Why::Changed, hello.rays, &colonies.changed);
        add_algae(&mut bodies, Why::Born, &algae.born);
        add_algae(&mut bodies, Why::Changed, &algae.changed);
        for (i, raster) in self.layers.iter().enumerate() {
            match (before.layers.get(i).and_then(Option::as_ref), raster) {
                (Some(old), Some(new)) if old.width == new.width && old.values.len() == new.values.len() => {
                    add_changed_tiles(&mut bodies, i as u16, old, new);
                }
                (_, Some(new)) => add_tiles(&mut bodies, i as u16, new, 0, new.height(), [0, new.width]),
                (_, None) => {}
            }
        }
        numbered(bodies)
    }
}

/// Each record says how many of its moment follow.
fn numbered(bodies: Vec<Body>) -> Vec<Record> {
    let count = bodies.len();
    bodies.into_iter().enumerate().map(|(i, body)| Record { more: (count - 1 - i) as u32, body }).collect()
}

fn add_colonies(bodies: &mut Vec<Body>, why: Why, rays: bool, all: &[Colony]) {
    let stride = 40 + if rays { 4 * RAYS } else { 0 };
    bodies.extend(all.chunks(PART / stride).map(|part| Body::Colonies { why, rays, rows: part.to_vec() }));
}

fn add_algae(bodies: &mut Vec<Body>, why: Why, all: &[Alga]) {
    bodies.extend(all.chunks(PART / 32).map(|part| Body::Algae { why, rows: part.to_vec() }));
}

/// The rows from `top` to before `bottom` and the columns of `span`, in tiles of at most [`PART`].
fn add_tiles(bodies: &mut Vec<Body>, layer: u16, raster: &Raster, top: u32, bottom: u32, span: [u32; 2]) {
    let most = (PART / 4) as u32;
    for left in (span[0]..span[1]).step_by(most as usize) {
        let width = most.min(span[1] - left);
        let rows = (most / width).max(1);
        for y in (top..bottom).step_by(rows as usize) {
            let height = rows.min(bottom - y);
            let part = |y: u32| raster.row(y)[left as usize..(left + width) as usize].iter().copied();
            let values = (y..y + height).flat_map(part).collect();
            bodies.push(Body::Tile(Tile { layer, at: [left, y], size: [width, height], values }));
        }
    }
}

/// A tile for each run of rows that differ, as wide as needed.
fn add_changed_tiles(bodies: &mut Vec<Body>, layer: u16, old: &Raster, new: &Raster) {
    // Rows and columns of the run that is under way: first, and one past the last.
    let mut run: Option<[[u32; 2]; 2]> = None;
    for y in 0..new.height() {
        let (a, b) = (old.row(y), new.row(y));
        let differs = |(a, b): (&f32, &f32)| a.to_bits() != b.to_bits();
        match a.iter().zip(b).position(differs) {
            None => {
                if let Some([rows, span]) = run.take() {
                    add_tiles(bodies, layer, new, rows[0], rows[1], span);
                }
            }
            Some(first) => {
                let last = a.iter().zip(b).rposition(differs).unwrap_or(first);
                let (first, end) = (first as u32, last as u32 + 1);
                let [rows, span] = run.unwrap_or([[y, y], [first, end]]);
                run = Some([[rows[0], y + 1], [span[0].min(first), span[1].max(end)]]);
            }
        }
    }
    if let Some([rows, span]) = run {
        add_tiles(bodies, layer, new, rows[0], rows[1], span);
    }
}

/// What became of individuals.
struct Compared<T> {
    born: Vec<T>,
    changed: Vec<T>,
    gone: Vec<u64>,
}

/// Walks through two lists that are in the order of their ids.
fn compare<T: Copy + PartialEq>(before: &[T], now: &[T], id: impl Fn(&T) -> u64) -> Compared<T> {
    let mut found = Compared { born: Vec::new(), changed: Vec::new(), gone: Vec::new() };
    let (mut old, mut new) = (before.iter().peekable(), now.iter().peekable());
    loop {
        let order = match (old.peek(), new.peek()) {
            (None, None) => return found,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(a), Some(b)) => id(a).cmp(&id(b)),
        };
        match order {
            Ordering::Less => found.gone.extend(old.next().map(&id)),
            Ordering::Greater => found.born.extend(new.next()),
            Ordering::Equal => {
                if let (Some(a), Some(b)) = (old.next(), new.next())
                    && a != b
                {
                    found.changed.push(*b);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_hold_what_differs_and_are_never_too_long() {
        let old = Raster { width: 5, values: vec![0.0; 20] };
        let mut new = old.clone();
        (new.values[6], new.values[13], new.values[3]) = (1.0, 2.0, -0.0);
        let mut bodies = Vec::new();
        add_changed_tiles(&mut bodies, 1, &old, &new);
        let [Body::Tile(tile)] = &bodies[..] else { panic!("{bodies:?}") };
        assert_eq!((tile.at, tile.size), ([1, 0], [3, 3]));
        assert_eq!(tile.values, [0.0, 0.0, -0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
        // A row that is longer than a record, and many short ones.
        for (width, height) in [(700_000, 2), (300, 3000)] {
            let raster = Raster { width, values: vec![1.0; width as usize * height] };
            let mut bodies = Vec::new();
            add_tiles(&mut bodies, 0, &raster, 0, height as u32, [0, width]);
            let mut cells = 0;
            for body in bodies {
                let Body::Tile(tile) = &body else { panic!("{body:?}") };
                cells += tile.values.len();
                assert!(Record::from(body).encode().len() <= PART + 64);
            }
            assert_eq!(cells, width as usize * height);
        }
    }
}
