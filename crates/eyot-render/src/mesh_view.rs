//! Views of triangle meshes: sun with shadows, light of the sky that crevices keep out, and water between.
//!
//! Triangles go into a z-buffer (`raster.rs`) from the camera and from the sun. Pixels are taken [`MeshViewOptions::samples`] times
//! in each direction and averaged.

use crate::camera::Camera;
use crate::math::{V3, add, attenuate, cross, direction, dot, mix, mul, scale, unit};
use crate::picture::{Picture, quantise, tone_map};
use crate::raster::{Hit, NONE, rasterise};
use rayon::prelude::*;

/// A mesh at a place. Its own coordinates are those of glTF: x to the east, y up, z to the south.
#[derive(Clone, Copy, Debug)]
pub struct MeshPart<'a> {
    /// Vertices, m.
    pub positions: &'a [V3],
    /// Unit vectors out of the body.
    pub normals: &'a [V3],
    /// Linear red, green and blue; the fourth number is not looked at.
    pub colours: &'a [[u8; 4]],
    /// Three per triangle.
    pub indices: &'a [u32],
    /// Where its origin lies: m east, south and up.
    pub place: V3,
    /// Turn about the upright axis, radians, as in a scene of glTF.
    pub turn: f32,
    /// Factor on all lengths.
    pub size: f32,
    /// Whether it throws shadows. A ground that does not leaves the whole map of shadows to what stands on it.
    pub shades: bool,
}

impl MeshPart<'_> {
    /// A direction of the mesh as it stands: east, south and up.
    fn direction(&self, [x, y, z]: V3) -> V3 {
        let (s, c) = self.turn.sin_cos();
        [c * x + s * z, c * z - s * x, y]
    }

    /// A vertex as it stands, m east, south and up.
    fn position(&self, p: V3) -> V3 {
        add(scale(self.direction(p), self.size), self.place)
    }
}

/// Water between the camera and what it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haze {
    /// Light lost on the way, 1/m.
    pub per_m: V3,
    /// Linear colour of far water.
    pub veil: V3,
}

/// How a mesh is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshViewOptions {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Where from. Its coordinates are m east, south and up.
    pub camera: Camera,
    /// Where the sun stands, degrees from the north over the east.
    pub sun_azimuth_deg: f32,
    /// How high it stands, degrees.
    pub sun_elevation_deg: f32,
    /// Linear colours behind everything, at the bottom and at the top of the picture.
    pub background: [V3; 2],
    /// Water, if there is any.
    pub haze: Option<Haze>,
    /// Samples of a pixel in each direction, 1..=4.
    pub samples: usize,
}

impl MeshViewOptions {
    /// A picture of `width` and `height` with a high sun in the south-west, before a pale sky or in water.
    pub fn new(camera: Camera, [width, height]: [usize; 2], haze: Option<Haze>) -> Self {
        Self {
            width,
            height,
            camera,
            sun_azimuth_deg: 215.0,
            sun_elevation_deg: 55.0,
            background: haze.map_or([[0.3, 0.4, 0.45], [0.5, 0.62, 0.7]], |h| [h.veil; 2]),
            haze,
            samples: 2,
        }
    }
}

/// Light of the sun and of the sky.
const SUN: V3 = [1.25, 1.2, 1.1];
const SKY: V3 = [0.42, 0.48, 0.55];
/// Light from below, of the sky's.
const FROM_BELOW: f32 = 0.35;
/// Pixels along the side of the shadow map.
pub(crate) const SHADOW: usize = 2048;
/// How far crevices are looked for, as a share of the scene's size, and in how many places.
const CREVICE: f32 = 0.02;
const LOOKS: usize = 20;

/// A picture of meshes. The bytes do not depend on the number of threads.
///
/// Triangles with a corner behind the camera are left out; large grounds should have many.
///
/// # Panics
/// If a part's arrays differ in length, or an index is out of range.
pub fn mesh_view(parts: &[MeshPart<'_>], o: &MeshViewOptions) -> Picture {
    let scene = Scene::new(parts);
    let n = o.samples.clamp(1, 4);
    let size = [o.width * n, o.height * n];
    let hits = rasterise(&scene.seen(&o.camera, size), &scene.indices, size);
    let sun = Sun::new(&scene, direction(o.sun_azimuth_deg, o.sun_elevation_deg));
    let shot = Shot { scene: &scene, sun: &sun, hits: &hits, size, o };
    let mut picture = Picture::new(o.width, o.height, [0; 3]);
    picture.pixels.par_chunks_mut(o.width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            for (dy, dx) in (0..n).flat_map(|dy| (0..n).map(move |dx| (dy, dx))) {
                sum = add(sum, tone_map(shot.colour(x * n + dx, y * n + dy)));
            }
            *pixel = quantise(scale(sum, 1.0 / (n * n) as f32), x, y);
        }
    });
    picture
}

/// All triangles in one list; m east, south and up.
struct Scene {
    positions: Vec<V3>,
    normals: Vec<V3>,
    colours: Vec<V3>,
    indices: Vec<u32>,
    /// How many of them, from the first on, are of parts that throw shadows.
    shading: usize,
    /// The box of these parts.
    low: V3,
    high: V3,
}

impl Scene {
    fn new(parts: &[MeshPart<'_>]) -> Self {
        let mut scene = Self {
            positions: vec![],
            normals: vec![],
            colours: vec![],
            indices: vec![],
            shading: 0,
            low: [f32::MAX; 3],
            high: [f32::MIN; 3],
        };
        let (shading, other): (Vec<_>, Vec<_>) = parts.iter().partition(|p| p.shades);
        for part in &shading {
            scene.add(part);
        }
        scene.shading = scene.indices.len();
        for p in &scene.positions {
            scene.low = std::array::from_fn(|i| scene.low[i].min(p[i]));
            scene.high = std::array::from_fn(|i| scene.high[i].max(p[i]));
        }
        for part in &other {
            scene.add(part);
        }
        if scene.low[0] > scene.high[0] {
            (scene.low, scene.high) = ([0.0; 3], [0.0; 3]);
        }
        scene
    }

    fn add(&mut self, part: &MeshPart<'_>) {
        assert!(part.normals.len() == part.positions.len() && part.colours.len() == part.positions.len());
        let first = self.positions.len() as u32;
        self.positions.extend(part.positions.iter().map(|&p| part.position(p)));
        self.normals.extend(part.normals.iter().map(|&n| part.direction(n)));
        self.colours.extend(part.colours.iter().map(|c| [c[0], c[1], c[2]].map(|v| f32::from(v) / 255.0)));
        self.indices.extend(part.indices.iter().map(|i| first + i));
    }

    /// Vertices as the rasteriser wants them.
    fn seen(&self, camera: &Camera, size: [usize; 2]) -> Vec<V3> {
        let focal = 1.0 / camera.pixel(size[1]);
        let project = |p: &V3| {
            let to = [p[0] - camera.eye[0], p[1] - camera.eye[1], p[2] - camera.eye[2]];
            let far = dot(to, camera.forward);
            if far < 0.02 {
                return [0.0, 0.0, -1.0];
            }
            let (x, y) = (dot(to, camera.right) / far, dot(to, camera.up) / far);
            [0.5 * size[0] as f32 + x * focal, 0.5 * size[1] as f32 - y * focal, 1.0 / far]
        };
        self.positions.par_iter().map(project).collect()
    }

    fn blend(&self, hit: &Hit, of: &[V3]) -> V3 {
        let corner = |i: usize| scale(of[self.indices[3 * hit.triangle as usize + i] as usize], hit.shares[i]);
        add(add(corner(0), corner(1)), corner(2))
    }

    fn size(&self) -> f32 {
        (0..3).map(|i| self.high[i] - self.low[i]).fold(0.0, f32::max)
    }
}

/// Directional light with a map of what it meets first.
struct Sun {
    towards: V3,
    right: V3,
    up: V3,
    middle: V3,
    pixel: f32,
    depths: Vec<f32>,
}

impl Sun {
    fn new(scene: &Scene, towards: V3) -> Self {
        let right = unit(cross([0.1, 0.9, 0.2], towards));
        let up = cross(towards, right);
        let middle = scale(add(scene.low, scene.high), 0.5);
        let half = 0.5 * (0..3).map(|i| (scene.high[i] - scene.low[i]).powi(2)).sum::<f32>().sqrt();
        let pixel = 2.0 * half.max(1e-6) / SHADOW as f32;
        let mut sun = Self { towards, right, up, middle, pixel, depths: Vec::new() };
        // Nearness is the height towards the sun, above 0 for all that the map covers.
        let vertices: Vec<V3> = scene.positions.par_iter().map(|&p| sun.on_map(p)).collect();
        let hits = rasterise(&vertices, &scene.indices[..scene.shading], [SHADOW; 2]);
        sun.depths = hits.iter().map(|h| h.nearness).collect();
        sun
    }

    fn on_map(&self, p: V3) -> V3 {
        let to = [p[0] - self.middle[0], p[1] - self.middle[1], p[2] - self.middle[2]];
        let half = 0.5 * SHADOW as f32;
        [
            half + dot(to, self.right) / self.pixel,
            half + dot(to, self.up) / self.pixel,
            2.0 * half + dot(to, self.towards) / self.pixel,
        ]
    }

    /// Share of the sun that reaches a point.
    fn reaches(&self, p: V3, normal: V3) -> f32 {
        let facing = dot(normal, self.towards);
        if facing <= 0.0 {
            return 0.0;
        }
        // Off the surface by more than the map's pixels, or it would shade itself.
        let off = add(p, scale(normal, 2.0 * self.pixel));
        let [x, y, depth] = self.on_map(off);
        // Sixteen pixels of the map, those at the rim by the share that a window of three pixels around the point has of them.
        let (x, y) = (x - 0.5, y - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let shares = |f: f32| [1.0 - f, 1.0, 1.0, f].map(|s| s / 3.0);
        let (across, down) = (shares(x - i), shares(y - j));
        let mut lit = 0.0;
        for (dj, down) in down.into_iter().enumerate() {
            for (di, across) in across.into_iter().enumerate() {
                let (i, j) = (i as i32 + di as i32 - 1, j as i32 + dj as i32 - 1);
                let inside = (0..SHADOW as i32).contains(&i) && (0..SHADOW as i32).contains(&j);
                let free = !inside || self.depths[j as usize * SHADOW + i as usize] <= depth + 1.0;
                lit += if free { across * down } else { 0.0 };
            }
        }
        lit
    }
}

struct Shot<'a> {
    scene: &'a Scene,
    sun: &'a Sun,
    hits: &'a [Hit],
    size: [usize; 2],
    o: &'a MeshViewOptions,
}

impl Shot<'_> {
    fn colour(&self, x: usize, y: usize) -> V3 {
        let hit = &self.hits[y * self.size[0] + x];
        if hit.triangle == NONE {
            let up = 1.0 - y as f32 / self.size[1] as f32;
            return mix(self.o.background[0], self.o.background[1], up);
        }
        let (p, normal) = self.surface(hit, x, y);
        let colour = self.scene.blend(hit, &self.scene.colours);
        let facing = dot(normal, self.sun.towards).max(0.0);
        let sun = scale(SUN, facing * self.sun.reaches(p, normal));
        let open = self.openness(x, y, p, normal);
        let sky = scale(SKY, open * (FROM_BELOW + (1.0 - FROM_BELOW) * (0.5 + 0.5 * normal[2])));
        let lit = mul(colour, add(sun, sky));
        let Some(haze) = self.o.haze else { return lit };
        let clear = attenuate(haze.per_m, 1.0 / hit.nearness);
        let veil: V3 = std::array::from_fn(|i| haze.veil[i] * (1.0 - clear[i]));
        add(mul(lit, clear), veil)
    }

    /// Point and normal of a hit.
    fn surface(&self, hit: &Hit, x: usize, y: usize) -> (V3, V3) {
        let ray = self.o.camera.ray(x as f32 + 0.5, y as f32 + 0.5, self.size);
        // The buffer holds the distance along the camera's axis.
        let way = 1.0 / (hit.nearness * dot(ray, self.o.camera.forward));
        let normal = unit(self.scene.blend(hit, &self.scene.normals));
        (add(self.o.camera.eye, scale(ray, way)), normal)
    }

    /// Share of the sky that no surface near by hides: points around the pixel that rise over the surface's plane hide some.
    fn openness(&self, x: usize, y: usize, p: V3, normal: V3) -> f32 {
        let reach = CREVICE * self.scene.size();
        let far = dot([0, 1, 2].map(|i| p[i] - self.o.camera.eye[i]), self.o.camera.forward);
        let pixels = (reach / (far * self.o.camera.pixel(self.size[1]))).clamp(2.0, 0.2 * self.size[1] as f32);
        let mut hidden = 0.0;
        for look in 0..LOOKS {
            // A sunflower's seeds, turned by the pixel so that no pattern shows.
            let turn = 2.399_963 * look as f32 + ((x * 7 + y * 13) % 16) as f32 * 0.39;
            let radius = pixels * ((look as f32 + 0.5) / LOOKS as f32).sqrt();
            let (i, j) = (x as f32 + radius * turn.cos(), y as f32 + radius * turn.sin());
            if i < 0.0 || j < 0.0 || i >= self.size[0] as f32 || j >= self.size[1] as f32 {
                continue;
            }
            let (i, j) = (i as usize, j as usize);
            let other = &self.hits[j * self.size[0] + i];
            if other.triangle == NONE {
                continue;
            }
            let ray = self.o.camera.ray(i as f32 + 0.5, j as f32 + 0.5, self.size);
            let way = 1.0 / (other.nearness * dot(ray, self.o.camera.forward));
            let q = add(self.o.camera.eye, scale(ray, way));
            let to = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let length = dot(to, to).sqrt();
            if length > 0.0 {
                // What is far away hides little: it may be anything behind or before.
                let near = (1.0 - length / (2.0 * reach)).max(0.0);
                hidden += (dot(to, normal) / length - 0.1).max(0.0) * near;
            }
        }
        (1.0 - 2.2 * hidden / LOOKS as f32).clamp(0.15, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ground of 4 x 4 m, and a roof of 0.4 m 1 m above its middle.
    fn scene() -> [(Vec<V3>, Vec<V3>, Vec<u32>); 2] {
        let quad = |x: f32, z: f32, half: f32, y: f32| {
            let corners =
                [[x - half, y, z - half], [x + half, y, z - half], [x + half, y, z + half], [x - half, y, z + half]];
            (corners.to_vec(), vec![[0.0, 1.0, 0.0]; 4], vec![0, 3, 1, 1, 3, 2])
        };
        [quad(0.0, 0.0, 2.0, 0.0), quad(0.0, 0.0, 0.2, 1.0)]
    }

    fn view(parts: &[(Vec<V3>, Vec<V3>, Vec<u32>)], haze: Option<Haze>) -> Picture {
        let colours: Vec<Vec<[u8; 4]>> = parts.iter().map(|p| vec![[128, 128, 128, 255]; p.0.len()]).collect();
        let parts: Vec<MeshPart<'_>> = parts
            .iter()
            .zip(&colours)
            .enumerate()
            .map(|(i, (p, c))| MeshPart {
                positions: &p.0,
                normals: &p.1,
                colours: c,
                indices: &p.2,
                place: [0.0; 3],
                turn: 0.0,
                size: 1.0,
                shades: i > 0,
            })
            .collect();
        let options = MeshViewOptions {
            width: 101,
            height: 101,
            camera: Camera::looking([0.0, 0.01, 6.0], [0.0; 3], 45.0),
            sun_azimuth_deg: 90.0,
            sun_elevation_deg: 45.0,
            background: [[0.0; 3]; 2],
            haze,
            samples: 1,
        };
        mesh_view(&parts, &options)
    }

    #[test]
    fn the_sun_in_the_east_throws_shadows_to_the_west() {
        let picture = view(&scene(), None);
        // 45 degrees from the middle to the picture's rim are 2.49 m on the ground: 20.3 pixels a metre.
        let at = |east: f32, south: f32| picture.get((50.5 + 20.3 * east) as usize, (50.5 + 20.3 * south) as usize)[1];
        let (lit, shade) = (at(1.2, 0.5), at(-1.0, 0.0));
        assert!(u32::from(lit) > 40 + u32::from(shade), "{lit} {shade}");
        assert!(at(-1.0, 0.6).abs_diff(lit) < 3 && at(-0.5, 0.0).abs_diff(lit) < 12, "no shadow beside it");
        assert_eq!(picture.get(1, 1), [0, 0, 0], "nothing is there");
        // The roof hides the ground beneath, not the other way round.
        assert!(at(0.0, 0.0) > 60);
    }

    #[test]
    fn water_veils_and_threads_change_nothing() {
        let haze = Haze { per_m: [0.5, 0.1, 0.1], veil: [0.0, 0.1, 0.3] };
        let (clear, veiled) = (view(&scene(), None).get(75, 75), view(&scene(), Some(haze)).get(75, 75));
        assert!(veiled[0] < clear[0] / 2 && veiled[2] > veiled[0], "{clear:?} {veiled:?}");
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
        assert_eq!(pool(1).install(|| view(&scene(), None)), pool(5).install(|| view(&scene(), None)));
        assert!(view(&[], None).pixels.iter().all(|p| *p == [0; 3]));
    }
}
