//! Vertices spread out over the surface, so that triangles become even.
//!
//! Marching cubes leave slivers where the surface passes close to a lattice point. Each vertex moves towards the middle of its
//! neighbours, along the surface alone, and then back onto the surface by a step of Newton's method:
//! 1. `p <- p - f g / |g|^2`
//! 2. `p <- p + s (m - n (n . m))`, `m` being the way to the mean of the neighbours and `n` the normal `-g / |g|`.
//!
//! No vertex goes farther than half a voxel from where it was. All vertices move at once, so their order does not matter.

use super::block::Source;
use super::field::Point;
use super::vector::{add, dot, scale, sub};
use rayon::prelude::*;
use std::ops::Range;

/// Steps along the surface between two of Newton's.
const GLIDES: u32 = 2;
/// Part of the way to the mean of the neighbours.
const GLIDE: f32 = 0.6;
/// Farthest way from the beginning, in voxels. It keeps vertices within what their block knows of the field, and triangles from
/// folding.
const LEASH: f32 = 0.5;
/// Vertices from which on all threads help.
const MANY: usize = 2000;

/// Vertices with what is around them.
pub(crate) struct Net<'a> {
    /// Vertices of each block, and its field.
    pub(crate) blocks: Vec<(Range<usize>, Source<'a>)>,
    /// Where vertices begin.
    pub(crate) home: Vec<Point>,
    pub(crate) voxel: f32,
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

/// A vertex.
#[derive(Clone, Copy)]
pub(crate) struct Vertex {
    pub(crate) position: Point,
    pub(crate) normal: Point,
}

impl<'a> Net<'a> {
    pub(crate) fn new(blocks: Vec<(Range<usize>, Source<'a>)>, home: Vec<Point>, indices: &[u32], voxel: f32) -> Self {
        // In a closed manifold every neighbour is at the end of one directed edge.
        let mut starts = vec![0u32; home.len() + 1];
        indices.iter().for_each(|&i| starts[i as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let (mut neighbours, mut next) = (vec![0; indices.len()], starts.clone());
        for t in indices.chunks_exact(3) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                neighbours[next[a as usize] as usize] = b;
                next[a as usize] += 1;
            }
        }
        Self { blocks, home, voxel, starts, neighbours }
    }

    /// The vertices after so many rounds.
    pub(crate) fn relaxed(&self, rounds: u32) -> Vec<Vertex> {
        let start: Vec<Vertex> = self.home.iter().map(|&position| Vertex { position, normal: [0.0; 3] }).collect();
        let mut vertices = self.onto_surface(&start);
        for _ in 0..rounds {
            for _ in 0..GLIDES {
                vertices = self.glide(&vertices);
            }
            vertices = self.onto_surface(&vertices);
        }
        vertices
    }

    /// The vertices where they begin, with their normals.
    pub(crate) fn unmoved(&self) -> Vec<Vertex> {
        let start: Vec<Vertex> = self.home.iter().map(|&position| Vertex { position, normal: [0.0; 3] }).collect();
        let pulled = self.onto_surface(&start);
        pulled.iter().zip(&self.home).map(|(v, &position)| Vertex { position, normal: v.normal }).collect()
    }

    fn onto_surface(&self, vertices: &[Vertex]) -> Vec<Vertex> {
        let of_block = |(range, source): &(Range<usize>, Source<'_>)| -> Vec<Vertex> {
            source.with(|field| {
                let pulled = |i: usize| {
                    let p = vertices[i].position;
                    let (value, gradient) = field.slope(p, self.voxel);
                    let square = dot(gradient, gradient);
                    // Where the field is flat or no number, the vertex stays.
                    if !(square > 0.0 && square.is_finite() && value.is_finite()) {
                        return vertices[i];
                    }
                    let step = scale(gradient, -value / square);
                    let normal = scale(gradient, -1.0 / square.sqrt());
                    Vertex { position: self.leashed(i, add(p, self.at_most(step))), normal }
                };
                range.clone().map(pulled).collect()
            })
        };
        self.each_block(of_block)
    }

    fn glide(&self, vertices: &[Vertex]) -> Vec<Vertex> {
        let of_block = |(range, _): &(Range<usize>, Source<'_>)| -> Vec<Vertex> {
            let moved = |i: usize| {
                let Vertex { position, normal } = vertices[i];
                let around = &self.neighbours[self.starts[i] as usize..self.starts[i + 1] as usize];
                if around.is_empty() {
                    return vertices[i];
                }
                let sum = around.iter().fold([0.0; 3], |sum, &n| add(sum, vertices[n as usize].position));
                let way = sub(scale(sum, 1.0 / around.len() as f32), position);
                let along = sub(way, scale(normal, dot(normal, way)));
                Vertex { position: self.leashed(i, add(position, scale(along, GLIDE))), normal }
            };
            range.clone().map(moved).collect()
        };
        self.each_block(of_block)
    }

    fn each_block(&self, f: impl Fn(&(Range<usize>, Source<'a>)) -> Vec<Vertex> + Sync) -> Vec<Vertex> {
        if self.home.len() < MANY {
            return self.blocks.iter().flat_map(&f).collect();
        }
        let parts: Vec<Vec<Vertex>> = self.blocks.par_iter().map(&f).collect();
        parts.into_iter().flatten().collect()
    }

    /// Not farther from home than the leash.
    fn leashed(&self, i: usize, p: Point) -> Point {
        add(self.home[i], self.at_most(sub(p, self.home[i])))
    }

    fn at_most(&self, way: Point) -> Point {
        let (length, most) = (dot(way, way).sqrt(), LEASH * self.voxel);
        if length > most { scale(way, most / length) } else { way }
    }
}
