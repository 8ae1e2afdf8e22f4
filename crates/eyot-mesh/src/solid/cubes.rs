//! Marching cubes whose cells fit together: which triangles a cell has.
//!
//! A corner is inside or outside; edges between the two kinds carry a vertex. On each face the vertices are joined by lines. Where
//! all four edges of a face carry one, the sign of the bilinear saddle decides, which both cells at the face see alike
//! (the asymptotic decider, Nielson and Hamann 1991). The lines of a cell's six faces make closed loops, and each loop is
//! filled with triangles. No triangle edge within a cell joins two vertices of the same face: such an edge could lie on
//! one of the neighbour, and four triangles would share it. Loops that cannot be filled so get a vertex in their middle.
//!
//! So each edge has two triangles, and the triangles around each vertex, one loop from each of the four cells at its
//! lattice edge, make one fan: the surface is a closed manifold whatever the corners are. Loops are never joined by a
//! tunnel through the cell (the cases that Chernyaev 1995 adds), which changes how bodies thinner than a cell hang together and
//! nothing else.

use std::sync::OnceLock;

/// Corners at the ends of each of a cell's edges. Corner `c` is at x, y, z = bits 0, 1, 2 of `c`; edges along x come first.
pub(crate) const EDGES: [[u8; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Corners of each face, counter-clockwise from outside the cell: -x, +x, -y, +y, -z, +z.
pub(crate) const FACES: [[u8; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Numbers from here on in [`Triangles::corners`] are middles of loops.
pub(crate) const MIDDLE: u8 = 12;

/// What fills a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    /// Edges whose vertices they join, or [`MIDDLE`] plus the number of a loop's middle. From outside the body
    /// counter-clockwise.
    pub(crate) corners: Vec<[u8; 3]>,
    /// Edges of the loops that have a vertex in their middle.
    pub(crate) middles: Vec<Vec<u8>>,
}

/// All fillings.
pub(crate) struct Table {
    /// For each set of corners inside: faces that are ambiguous, and where its fillings begin.
    cases: Vec<(u8, usize)>,
    fillings: Vec<Triangles>,
}

impl Table {
    /// The table, made at the first call.
    pub(crate) fn get() -> &'static Self {
        static TABLE: OnceLock<Table> = OnceLock::new();
        TABLE.get_or_init(Self::new)
    }

    fn new() -> Self {
        let mut table = Self { cases: Vec::new(), fillings: Vec::new() };
        for inside in 0..=255u8 {
            let ambiguous = (0..6).filter(|&f| is_ambiguous(inside, f)).fold(0u8, |set, f| set | 1 << f);
            table.cases.push((ambiguous, table.fillings.len()));
            for choice in 0..1u32 << ambiguous.count_ones() {
                table.fillings.push(fill(inside, spread(choice, ambiguous)));
            }
        }
        table
    }

    /// The filling of a cell. `inside` has a bit for each corner that is inside, `value` gives the values there.
    #[inline]
    pub(crate) fn filling(&self, inside: u8, value: impl Fn(u8) -> f32) -> &Triangles {
        let (ambiguous, first) = self.cases[usize::from(inside)];
        let (mut choice, mut bit) = (0, 1);
        if ambiguous != 0 {
            for face in (0..6).filter(|f| ambiguous >> f & 1 == 1) {
                // Positive corners are joined if the saddle (ac - bd) / (a + c - b - d) is: a and c positive, b and d not.
                let [a, b, c, d] = FACES[face].map(&value);
                let (inner, outer) = if a > 0.0 { (a * c, b * d) } else { (b * d, a * c) };
                if inner > outer {
                    choice |= bit;
                }
                bit <<= 1;
            }
        }
        &self.fillings[first + choice]
    }
}

/// The bits of `choice` at the places where `mask` has bits.
fn spread(choice: u32, mask: u8) -> u8 {
    let places = (0..6).filter(|f| mask >> f & 1 == 1);
    places.enumerate().fold(0, |set, (i, f)| set | ((choice >> i & 1) as u8) << f)
}

fn is_inside(inside: u8, corner: u8) -> bool {
    inside >> corner & 1 == 1
}

fn is_ambiguous(inside: u8, face: usize) -> bool {
    let [a, b, c, d] = FACES[face].map(|c| is_inside(inside, c));
    a == c && b == d && a != b
}

fn edge_between(a: u8, b: u8) -> u8 {
    let wanted = [a.min(b), a.max(b)];
    EDGES.iter().position(|e| *e == wanted).map_or(0, |i| i as u8)
}

/// Faces of each edge, as bits.
fn faces_of(edge: u8) -> u8 {
    let [a, b] = EDGES[usize::from(edge)];
    (0..6).filter(|&f| FACES[f].contains(&a) && FACES[f].contains(&b)).fold(0, |set, f| set | 1 << f)
}

/// Fills a cell, given the ambiguous faces on which inside corners are joined.
fn fill(inside: u8, joined: u8) -> Triangles {
    // Lines run with the inside to their left, as seen from outside the cell.
    let mut next = [None; 12];
    for (f, face) in FACES.iter().enumerate() {
        let step = |i: usize| (face[i % 4], face[(i + 1) % 4]);
        for i in 0..4 {
            let (a, b) = step(i);
            if !is_inside(inside, a) || is_inside(inside, b) {
                continue;
            }
            // The outline leaves the inside here. The line goes to where it entered it, or, if the inside is joined across
            // the face, to where it enters it next.
            let (mut k, back) = (i, !(is_ambiguous(inside, f) && joined >> f & 1 == 1));
            loop {
                k = if back { k + 3 } else { k + 1 } % 4;
                let (c, d) = step(k);
                if !is_inside(inside, c) && is_inside(inside, d) {
                    next[usize::from(edge_between(a, b))] = Some(edge_between(c, d));
                    break;
                }
            }
        }
    }
    let mut triangles = Triangles::default();
    for start in 0..12u8 {
        let mut outline = Vec::new();
        let mut at = start;
        while let Some(following) = next[usize::from(at)].take() {
            outline.push(at);
            at = following;
        }
        if outline.is_empty() {
            continue;
        }
        // From outside the body it is the other way round.
        outline.reverse();
        match polygon(&outline) {
            Some(filled) => triangles.corners.extend(filled),
            None => {
                let middle = MIDDLE + triangles.middles.len() as u8;
                let n = outline.len();
                triangles.corners.extend((0..n).map(|i| [outline[i], outline[(i + 1) % n], middle]));
                triangles.middles.push(outline);
            }
        }
    }
    triangles
}

/// Triangles that fill a loop without joining two vertices of one face, if there are such.
fn polygon(outline: &[u8]) -> Option<Vec<[u8; 3]>> {
    let n = outline.len();
    if n < 3 {
        return Some(Vec::new());
    }
    let allowed = |i: usize, j: usize| j - i == 1 || faces_of(outline[i]) & faces_of(outline[j]) == 0;
    // The apex over the closing edge: from the middle outwards, so that triangles are even.
    let mut order: Vec<usize> = (1..n - 1).collect();
    order.sort_by_key(|&k| (2 * k).abs_diff(n - 1));
    order.into_iter().filter(|&k| allowed(0, k) && allowed(k, n - 1)).find_map(|k| {
        let mut filled = polygon(&outline[..=k])?;
        filled.push([outline[0], outline[k], outline[n - 1]]);
        filled.extend(polygon(&outline[k..])?);
        Some(filled)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn lines_of_all_cells_close_and_face_lines_are_the_only_open_edges() {
        let table = Table::get();
        assert_eq!((table.fillings[0].corners.len(), table.fillings.last().unwrap().corners.len()), (0, 0));
        for (inside, &(ambiguous, first)) in table.cases.iter().enumerate() {
            for choice in 0..1usize << ambiguous.count_ones() {
                let filling = &table.fillings[first + choice];
                // Directed edges of the triangles: inner ones come both ways, the others lie on faces, once.
                let mut seen = BTreeMap::new();
                for t in &filling.corners {
                    for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                        assert_ne!(a, b);
                        assert_eq!(seen.insert((a, b), ()), None, "case {inside}: an edge twice in one direction");
                    }
                }
                let mut lines = [0; 6];
                for &(a, b) in seen.keys() {
                    let both = seen.contains_key(&(b, a));
                    let shared = if a.max(b) < MIDDLE { faces_of(a) & faces_of(b) } else { 0 };
                    assert_eq!(both, shared == 0, "case {inside}: {a}-{b}");
                    if shared != 0 {
                        lines[shared.trailing_zeros() as usize] += 1;
                    }
                }
                for (face, n) in lines.iter().enumerate() {
                    let corners = FACES[face].map(|c| is_inside(inside as u8, c));
                    let changes = (0..4).filter(|&i| corners[i] != corners[(i + 1) % 4]).count();
                    assert_eq!(2 * n, changes, "case {inside}, face {face}");
                }
                let vertices = (0..12u8).filter(|&e| {
                    let [a, b] = EDGES[usize::from(e)];
                    is_inside(inside as u8, a) != is_inside(inside as u8, b)
                });
                assert!(
                    vertices.into_iter().all(|e| filling.corners.iter().flatten().any(|&c| c == e)),
                    "case {inside}"
                );
            }
        }
    }
}
