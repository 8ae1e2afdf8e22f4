//! A closed surface of triangles.

use super::vector::{cross, dot, sub};
use crate::primitive::Point;

/// A closed surface. All vertex arrays have the same length.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Solid {
    /// Vertices.
    pub positions: Vec<Point>,
    /// Unit vectors out of the body.
    pub normals: Vec<Point>,
    /// Three per triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

impl Solid {
    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Corners of each triangle.
    pub fn corners(&self) -> impl ExactSizeIterator<Item = [Point; 3]> + '_ {
        self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| self.positions[i as usize]))
    }

    /// Volume, by the divergence theorem; negative if the surface is inside out.
    pub fn volume(&self) -> f64 {
        let wide = |p: Point| p.map(f64::from);
        let six = |[a, b, c]: [Point; 3]| {
            let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (wide(a), wide(b), wide(c));
            ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        };
        self.corners().map(six).sum::<f64>() / 6.0
    }

    /// Area of the surface.
    pub fn area(&self) -> f64 {
        let twice = |[a, b, c]: [Point; 3]| {
            let n = cross(sub(b, a), sub(c, a));
            f64::from(dot(n, n)).sqrt()
        };
        0.5 * self.corners().map(twice).sum::<f64>()
    }

    /// The connected piece with the most triangles; of several such the one whose vertices come first.
    #[must_use]
    pub fn largest_piece(self) -> Self {
        let pieces = self.pieces();
        let mut sizes = vec![0usize; self.positions.len()];
        self.indices.chunks_exact(3).for_each(|t| sizes[pieces[t[0] as usize] as usize] += 1);
        let most = sizes.iter().copied().max().unwrap_or(0);
        if 3 * most == self.indices.len() {
            return self;
        }
        let kept = sizes.iter().position(|&n| n == most).unwrap_or(0) as u32;
        let mut new = vec![u32::MAX; self.positions.len()];
        let mut piece = Self::default();
        for (i, slot) in new.iter_mut().enumerate().filter(|(i, _)| pieces[*i] == kept) {
            *slot = piece.positions.len() as u32;
            piece.positions.push(self.positions[i]);
            piece.normals.push(self.normals[i]);
        }
        piece.indices.extend(self.indices.iter().map(|&i| new[i as usize]).filter(|&i| i != u32::MAX));
        piece
    }

    /// For each vertex the first vertex of its connected piece.
    pub(crate) fn pieces(&self) -> Vec<u32> {
        let mut root: Vec<u32> = (0..self.positions.len() as u32).collect();
        let find = |root: &mut Vec<u32>, mut i: u32| {
            while root[i as usize] != i {
                let up = root[root[i as usize] as usize];
                root[i as usize] = up;
                i = up;
            }
            i
        };
        for t in self.indices.chunks_exact(3) {
            let known = [t[0], t[1], t[2]].map(|i| root[i as usize]);
            if known[0] == known[1] && known[0] == known[2] {
                continue;
            }
            let roots = known.map(|i| find(&mut root, i));
            let first = roots[0].min(roots[1]).min(roots[2]);
            // Those of the triangle as well, so that the next one at the same vertices sees it at once.
            [roots[0], roots[1], roots[2], t[0], t[1], t[2]].into_iter().for_each(|i| root[i as usize] = first);
        }
        (0..root.len() as u32).map(|i| find(&mut root, i)).collect()
    }
}
