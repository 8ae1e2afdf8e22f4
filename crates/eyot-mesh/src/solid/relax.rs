//! Vertices spread out over the surface, so that triangles become even.
//!
//! Marching cubes leave slivers where the surface passes close to a lattice point. Each vertex moves towards the middle of its
//! neighbours, along the surface alone, and then back onto the surface by a step of Newton's method:
//! 1. `p <- p - f g / |g|^2`
//! 2. `p <- p + s (m - n (n . m))`, `m` being the way to the mean of the neighbours and `n` the normal `-g / |g|`.
//!
//! No vertex goes farther than half a voxel from where it was. All vertices move at once, so their order does not matter.

use super::block::Source;
use super::vector::{add, dot, scale, sub};
use crate::primitive::Point;
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

/// A vertex.
#[derive(Clone, Copy)]
pub(crate) struct Vertex {
    pub(crate) position: Point,
    pub(crate) normal: Point,
}

/// Vertices with what is around them.
pub(crate) struct Net<'a> {
    /// Vertices of each block, and its field.
    pub(crate) blocks: Vec<(Range<usize>, Source<'a>)>,
    /// Where vertices begin.
    home: Vec<Point>,
    voxel: f32,
    starts: Vec<u32>,
    neighbours: Vec<u32>,
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
        let mut here: Vec<Vertex> = self.home.iter().map(|&position| Vertex { position, normal: [0.0; 3] }).collect();
        let mut there = here.clone();
        self.onto_surface(&mut here);
        for _ in 0..rounds {
            for _ in 0..GLIDES {
                self.glide(&here, &mut there);
                std::mem::swap(&mut here, &mut there);
            }
            self.onto_surface(&mut here);
        }
        here
    }

    /// The vertices where they begin, with their normals.
    pub(crate) fn unmoved(&self) -> Vec<Vertex> {
        let mut vertices = vec![Vertex { position: [0.0; 3], normal: [0.0; 3] }; self.home.len()];
        self.each_block(&mut vertices, |(range, source), vertices| {
            let points = &self.home[range.clone()];
            let mut slopes = vec![(0.0, [0.0; 3]); points.len()];
            source.with(|field| field.slopes(points, self.voxel, &mut slopes));
            for ((v, (_, gradient)), &position) in vertices.iter_mut().zip(slopes).zip(points) {
                let square = dot(gradient, gradient);
                let is_sound = square > 0.0 && square.is_finite();
                let normal = if is_sound { scale(gradient, -1.0 / square.sqrt()) } else { [0.0; 3] };
                *v = Vertex { position, normal };
            }
        });
        vertices
    }

    fn onto_surface(&self, vertices: &mut [Vertex]) {
        self.each_block(vertices, |(range, source), vertices| {
            let points: Vec<Point> = vertices.iter().map(|v| v.position).collect();
            let mut slopes = vec![(0.0, [0.0; 3]); points.len()];
            source.with(|field| field.slopes(&points, self.voxel, &mut slopes));
            for ((v, (value, gradient)), home) in vertices.iter_mut().zip(slopes).zip(&self.home[range.clone()]) {
                let square = dot(gradient, gradient);
                // Where the field is flat or no number, the vertex stays.
                if square > 0.0 && square.is_finite() && value.is_finite() {
                    let step = self.at_most(scale(gradient, -value / square));
                    v.position = self.leashed(*home, add(v.position, step));
                    v.normal = scale(gradient, -1.0 / square.sqrt());
                }
            }
        });
    }

    fn glide(&self, from: &[Vertex], to: &mut [Vertex]) {
        self.each_block(to, |(range, _), to| {
            for (i, to) in range.clone().zip(to) {
                let Vertex { position, normal } = from[i];
                *to = from[i];
                let around = &self.neighbours[self.starts[i] as usize..self.starts[i + 1] as usize];
                if around.is_empty() {
                    continue;
                }
                let sum = around.iter().fold([0.0; 3], |sum, &n| add(sum, from[n as usize].position));
                let way = sub(scale(sum, 1.0 / around.len() as f32), position);
                let along = sub(way, scale(normal, dot(normal, way)));
                to.position = self.leashed(self.home[i], add(position, scale(along, GLIDE)));
            }
        });
    }

    fn each_block(&self, out: &mut [Vertex], f: impl Fn(&(Range<usize>, Source<'a>), &mut [Vertex]) + Sync) {
        each_block(&self.blocks, |b| b.0.clone(), out, f);
    }

    /// Not farther from home than the leash.
    fn leashed(&self, home: Point, p: Point) -> Point {
        add(home, self.at_most(sub(p, home)))
    }

    fn at_most(&self, way: Point) -> Point {
        let (square, most) = (dot(way, way), LEASH * self.voxel);
        if square > most * most { scale(way, most / square.sqrt()) } else { way }
    }
}

/// Calls `f` with each block and its part of `out`, which the ranges of the blocks divide in their order.
pub(crate) fn each_block<B: Sync, T: Send>(
    blocks: &[B],
    range: impl Fn(&B) -> Range<usize>,
    out: &mut [T],
    f: impl Fn(&B, &mut [T]) + Sync,
) {
    let many = out.len() > MANY;
    let mut rest = out;
    let mut parts = Vec::with_capacity(blocks.len());
    for b in blocks {
        let (part, after) = std::mem::take(&mut rest).split_at_mut(range(b).len());
        parts.push((b, part));
        rest = after;
    }
    if many {
        parts.into_par_iter().for_each(|(b, part)| f(b, part));
    } else {
        parts.into_iter().for_each(|(b, part)| f(b, part));
    }
}
