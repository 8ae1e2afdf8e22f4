//! Bodies of trees, simple enough for hundreds of thousands of copies: each stands at the origin, is 1 m high, and its crown has a radius of 1 m,
//! so that a copy's size is crown, height, crown.

use eyot_core::rng::{Key, hash, unit};
use eyot_plants::trees::Kind;

/// A closed surface with colours. Places are m: x to the east, y up, z to the south.
#[derive(Default)]
pub(crate) struct Body {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub colours: Vec<[u8; 4]>,
    pub indices: Vec<u32>,
}

/// Linear colours of leaves, in the shade of the crown and in the light, and of the trunk.
fn colours(kind: Kind) -> [[f32; 3]; 3] {
    match kind {
        Kind::Conifer => [[0.008, 0.022, 0.012], [0.026, 0.062, 0.026], [0.060, 0.036, 0.022]],
        Kind::Palm => [[0.022, 0.050, 0.012], [0.075, 0.130, 0.030], [0.120, 0.095, 0.066]],
        Kind::Shrub => [[0.018, 0.036, 0.012], [0.060, 0.092, 0.030], [0.060, 0.045, 0.030]],
        _ => [[0.016, 0.036, 0.010], [0.056, 0.102, 0.022], [0.070, 0.050, 0.036]],
    }
}

/// The body of a kind.
pub(crate) fn body(kind: Kind) -> Body {
    let [shade, light, wood] = colours(kind);
    let mut body = Body::default();
    let number = |i: u32| unit::<f32>(hash(Key::new(kind as u64, 0x626f_6479, 0), i));
    match kind {
        Kind::Conifer => {
            body.cone([0.0; 3], [0.14, 0.14], [0.0, 0.5], 6, [wood, wood]);
            // Skirts of branches, each narrower than the one below.
            for i in 0..5u32 {
                let k = i as f32 / 5.0;
                let radius = (1.0 - 0.86 * k) * (0.92 + 0.16 * number(i));
                let lean = [0.05 * (number(10 + i) - 0.5), 0.05 * (number(20 + i) - 0.5)];
                let foot = [lean[0], 0.10 + 0.165 * i as f32, lean[1]];
                body.skirt(foot, radius, 0.33 - 0.012 * i as f32, 9, i, [shade, light]);
            }
        }
        Kind::Palm => {
            body.cone([0.0; 3], [0.10, 0.06], [0.0, 0.92], 6, [wood, wood]);
            for i in 0..11u32 {
                let turn = i as f32 * 2.399_963;
                body.frond(turn, 0.86 + 0.1 * number(i), 0.12 + 0.16 * number(i + 20), [shade, light]);
            }
        }
        Kind::Shrub => {
            for i in 0..4u32 {
                let (s, c) = (i as f32 * 2.399_963).sin_cos();
                let r = 0.42 + 0.2 * number(i);
                body.blob([0.48 * c, 0.42 + 0.12 * number(9 + i), 0.48 * s], [r, 0.44, r], i, [shade, light]);
            }
        }
        _ => {
            body.cone([0.0; 3], [0.09, 0.06], [0.0, 0.55], 6, [wood, wood]);
            body.blob([0.0, 0.66, 0.0], [0.74, 0.33, 0.74], 0, [shade, light]);
            for i in 1..6u32 {
                let (s, c) = (i as f32 * 1.256_637 + number(i)).sin_cos();
                let r = 0.42 + 0.12 * number(30 + i);
                body.blob([0.5 * c, 0.44 + 0.3 * number(40 + i), 0.5 * s], [r, 0.22, r], i, [shade, light]);
            }
        }
    }
    body
}

fn byte(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn unit3(v: [f32; 3]) -> [f32; 3] {
    let l = v.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-9);
    v.map(|x| x / l)
}

impl Body {
    fn vertex(&mut self, at: [f32; 3], normal: [f32; 3], colour: [f32; 3]) -> u32 {
        self.positions.push(at);
        self.normals.push(unit3(normal));
        self.colours.push([byte(colour[0]), byte(colour[1]), byte(colour[2]), 255]);
        self.positions.len() as u32 - 1
    }

    /// A blunt cone about the upright axis through `foot`, from one radius and height to another.
    fn cone(&mut self, foot: [f32; 3], radii: [f32; 2], heights: [f32; 2], sides: u32, colours: [[f32; 3]; 2]) {
        let first = self.positions.len() as u32;
        for i in 0..sides {
            let (s, c) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
            for k in 0..2 {
                let at = [foot[0] + radii[k] * c, foot[1] + heights[k], foot[2] + radii[k] * s];
                self.vertex(at, [c, radii[0] - radii[1], s], colours[k]);
            }
        }
        for i in 0..sides {
            let (a, b) = (first + 2 * i, first + 2 * ((i + 1) % sides));
            self.indices.extend([a, a + 1, b, b, a + 1, b + 1]);
        }
    }

    /// A cone of branches with a ragged lower rim, closed below.
    fn skirt(
        &mut self,
        foot: [f32; 3],
        radius: f32,
        height: f32,
        sides: u32,
        salt: u32,
        [shade, light]: [[f32; 3]; 2],
    ) {
        let first = self.positions.len() as u32;
        let number = |i: u32| unit::<f32>(hash(Key::new(7, salt, 0), i));
        for i in 0..2 * sides {
            let (s, c) = (std::f32::consts::TAU * (i as f32 + 0.6 * number(i)) / (2 * sides) as f32).sin_cos();
            // Every other point lies farther in and higher: twigs.
            let (r, up) = if i % 2 == 0 { (1.0, -0.03) } else { (0.74, 0.02) };
            let r = radius * r * (0.88 + 0.24 * number(100 + i));
            self.vertex(
                [foot[0] + r * c, foot[1] + up, foot[2] + r * s],
                [c, 0.75, s],
                if i % 2 == 0 { light } else { shade },
            );
        }
        let tip = self.vertex([foot[0], foot[1] + height, foot[2]], [0.0, 1.0, 0.0], light);
        for i in 0..2 * sides {
            self.indices.extend([first + i, tip, first + (i + 1) % (2 * sides)]);
        }
        // The underside has normals of its own.
        let below = self.positions.len() as u32;
        for i in 0..2 * sides {
            let [x, y, z] = self.positions[(first + i) as usize];
            self.vertex([x, y, z], [0.2 * (x - foot[0]), -radius, 0.2 * (z - foot[2])], shade);
        }
        let heart = self.vertex([foot[0], foot[1] + 0.3 * height, foot[2]], [0.0, -1.0, 0.0], shade);
        for i in 0..2 * sides {
            self.indices.extend([below + i, below + (i + 1) % (2 * sides), heart]);
        }
    }

    /// An uneven ellipsoid, darker below.
    fn blob(&mut self, middle: [f32; 3], radii: [f32; 3], salt: u32, [shade, light]: [[f32; 3]; 2]) {
        const RINGS: u32 = 5;
        const SIDES: u32 = 8;
        let first = self.positions.len() as u32;
        let number = |i: u32| unit::<f32>(hash(Key::new(9, salt, 1), i));
        for ring in 0..=RINGS {
            let (sin, cos) = (std::f32::consts::PI * ring as f32 / RINGS as f32).sin_cos();
            for side in 0..SIDES {
                let (s, c) = (std::f32::consts::TAU * (side as f32 + 0.5 * (ring % 2) as f32) / SIDES as f32).sin_cos();
                let poles = ring == 0 || ring == RINGS;
                let out = if poles { 1.0 } else { 0.84 + 0.3 * number(ring * SIDES + side) };
                let d = [sin * c, cos, sin * s];
                let at = std::array::from_fn(|i| middle[i] + radii[i] * out * d[i]);
                let lit = (0.5 + 0.5 * cos) * (0.7 + 0.5 * (out - 0.84));
                let colour = std::array::from_fn(|i| shade[i] + (light[i] - shade[i]) * lit.clamp(0.0, 1.0));
                self.vertex(at, [d[0] / radii[0], d[1] / radii[1], d[2] / radii[2]], colour);
            }
        }
        for ring in 0..RINGS {
            for side in 0..SIDES {
                let at = |r: u32, s: u32| first + r * SIDES + s % SIDES;
                let [a, b, c, d] = [at(ring, side), at(ring, side + 1), at(ring + 1, side), at(ring + 1, side + 1)];
                if ring > 0 {
                    self.indices.extend([a, b, c]);
                }
                if ring + 1 < RINGS {
                    self.indices.extend([b, d, c]);
                }
            }
        }
    }

    /// A leaf of a palm, which rises, bends and hangs; seen from both sides.
    fn frond(&mut self, turn: f32, height: f32, rise: f32, [shade, light]: [[f32; 3]; 2]) {
        const PARTS: u32 = 5;
        let (s, c) = turn.sin_cos();
        for side in [1.0f32, -1.0] {
            let first = self.positions.len() as u32;
            for i in 0..=PARTS {
                let k = i as f32 / PARTS as f32;
                let (out, up) = (k, height + 2.0 * rise * k * (1.0 - k) - 0.30 * k * k * k);
                let half = 0.17 * (1.0 - (2.0 * k - 0.8).abs().min(1.0)).max(0.06);
                for w in [-half, half] {
                    let colour = if side > 0.0 { light } else { shade };
                    self.vertex([out * c - w * s, up - 0.6 * w.abs(), out * s + w * c], [0.0, side, 0.0], colour);
                }
            }
            for i in 0..PARTS {
                let a = first + 2 * i;
                let quad = [a, a + 1, a + 2, a + 2, a + 1, a + 3];
                self.indices.extend(if side > 0.0 {
                    quad
                } else {
                    [quad[0], quad[2], quad[1], quad[3], quad[5], quad[4]]
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_have_a_height_and_a_radius_of_about_one_and_face_outwards() {
        for kind in Kind::ALL {
            let b = body(kind);
            let top = b.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
            let wide = b.positions.iter().map(|p| p[0].hypot(p[2])).fold(0.0, f32::max);
            assert!((0.9..=1.12).contains(&top) && (0.85..=1.25).contains(&wide), "{kind:?}: {top} high, {wide} wide");
            assert!(b.indices.len() / 3 < 600 && b.normals.len() == b.positions.len());
            let inwards = b.indices.chunks(3).filter(|t| {
                let [p, q, r] = [0, 1, 2].map(|i| b.positions[t[i] as usize]);
                let (u, v): ([f32; 3], [f32; 3]) =
                    (std::array::from_fn(|i| q[i] - p[i]), std::array::from_fn(|i| r[i] - p[i]));
                let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                let mean: [f32; 3] = std::array::from_fn(|i| t.iter().map(|&k| b.normals[k as usize][i]).sum::<f32>());
                (0..3).map(|i| n[i] * mean[i]).sum::<f32>() < -1e-6
            });
            let share = inwards.count() as f32 / (b.indices.len() / 3) as f32;
            assert!(share < 0.02, "{kind:?}: {share}");
        }
    }
}
