//! The island that a seed draws: volcanoes and what is on and in them.

use super::VolcanicIsland;
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::rng::{self, Key};

/// An island, in metres from the middle of the grid to the east and south.
pub(super) struct Island {
    pub volcanoes: Vec<Volcano>,
    /// Distance from the middle at which the shelf ends.
    pub room_m: f64,
    /// Unit direction to windward.
    pub windward: [f64; 2],
    pub cliffs_m: f64,
    /// Width of the shelf in radii of the volcanoes.
    pub shelf: f64,
    pub shelf_depth_m: f64,
    pub depth_m: f64,
}

/// One volcano.
pub(super) struct Volcano {
    pub centre: [f64; 2],
    /// Radius at the sea without rifts.
    pub radius_m: f64,
    /// Height over the sea.
    pub height_m: f64,
    pub age: f64,
    /// Concave above 0, a shield below.
    pub concavity: f64,
    /// Radii over which the summit is rounded off.
    pub round: f64,
    /// Directions of the rift zones and how far each draws the volcano out.
    pub rifts: Vec<([f64; 2], f64)>,
    pub cones: Vec<Cone>,
    pub troughs: Vec<Trough>,
}

/// A cinder cone.
pub(super) struct Cone {
    pub centre: [f64; 2],
    pub radius_m: f64,
    pub height_m: f64,
}

/// A caldera, a valley or the scar of a landslide.
pub(super) struct Trough {
    /// Where it begins.
    pub head: [f64; 2],
    /// Unit direction downhill.
    pub down: [f64; 2],
    /// Distance from the head over which the floor falls to the sea.
    pub length_m: f64,
    /// Length of the floor's line: 0 for what has walls all around.
    pub open_m: f64,
    /// Half the width of the floor at the head, and how much wider it is at the sea, as a share.
    pub width_m: f64,
    pub widening: f64,
    /// Height of the floor at the head over the sea, and its depth under the sea at the mouth.
    pub head_m: f64,
    pub drowned_m: f64,
    /// Slope of the walls.
    pub wall: f64,
}

/// Random numbers in the order in which they are asked for.
struct Draw {
    key: Key,
    next: u32,
}

impl Draw {
    fn unit(&mut self) -> f64 {
        self.next += 1;
        f64::from(rng::unit::<f32>(rng::hash(self.key, self.next)))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn happens(&mut self, probability: f32) -> bool {
        self.unit() < f64::from(probability)
    }

    /// `n` directions, one in each of `n` equal sectors, in degrees.
    fn around(&mut self, n: usize) -> Vec<f64> {
        let turn = self.between(0.0, 360.0);
        (0..n).map(|i| turn + 360.0 / n as f64 * (i as f64 + self.between(0.1, 0.9))).collect()
    }
}

/// Unit vector of an angle in degrees, clockwise from north.
fn towards(degrees: f64) -> [f64; 2] {
    [sin_degrees(degrees), -cos_degrees(degrees)]
}

/// `from + by towards`.
fn along(from: [f64; 2], by: f64, towards: [f64; 2]) -> [f64; 2] {
    [from[0] + by * towards[0], from[1] + by * towards[1]]
}

impl Island {
    /// The island of a seed on a grid with a shorter side of `side_m`.
    pub(super) fn draw(p: &VolcanicIsland, side_m: f64, seed: u64) -> Self {
        let mut draw = Draw { key: Key::new(seed, 0x1511e, 0), next: 0 };
        let [few, many] = p.volcanoes.map(f64::from);
        let count = (few + (many - few + 1.0) * draw.unit()).floor().min(many) as usize;
        let [youngest, oldest] = p.age.map(f64::from);
        let height_m = f64::from(p.height) * (1.0 - f64::from(p.variation) * draw.unit());

        // Volcanoes follow each other along a line that bends; the next one is younger or older by chance.
        let mut heading = draw.between(0.0, 360.0);
        let (mut centre, mut before) = ([0.0; 2], 0.0);
        let highest = (draw.unit() * count as f64) as usize;
        let mut volcanoes: Vec<Volcano> = Vec::with_capacity(count);
        for i in 0..count {
            let radius = if i == highest { 1.0 } else { draw.between(0.5, 0.85) };
            heading += draw.between(-50.0, 50.0);
            if i > 0 {
                centre = along(centre, draw.between(0.5, 0.72) * (before + radius), towards(heading));
            }
            before = radius;
            let age = draw.between(youngest, oldest);
            // Age lowers; a lower neighbour is not as high for its width.
            let of_height = if i == highest { 1.0 } else { radius * draw.between(0.65, 1.05) };
            volcanoes.push(Volcano {
                centre,
                radius_m: radius,
                height_m: height_m * of_height * (1.0 - 0.2 * age),
                age,
                concavity: draw.between(-0.6, 1.6),
                round: draw.between(0.1, 0.2),
                rifts: Vec::new(),
                cones: Vec::new(),
                troughs: Vec::new(),
            });
        }
        fit(&mut volcanoes, p, side_m, &mut draw);
        for v in &mut volcanoes {
            v.dress(p, &mut draw);
        }
        let age = volcanoes.iter().map(|v| v.age * v.radius_m).sum::<f64>()
            / volcanoes.iter().map(|v| v.radius_m).sum::<f64>();
        Self {
            volcanoes,
            room_m: 0.94 * f64::from(p.radius) * side_m,
            windward: towards(f64::from(p.wind)),
            cliffs_m: f64::from(p.cliffs) * age,
            shelf: f64::from(p.shelf),
            shelf_depth_m: f64::from(p.shelf_depth).min(f64::from(p.depth)),
            depth_m: f64::from(p.depth),
        }
    }
}

/// Scales and moves volcanoes of relative size, so that they and their shelf fill the circle that they may fill.
fn fit(volcanoes: &mut [Volcano], p: &VolcanicIsland, side_m: f64, draw: &mut Draw) {
    let reach =
        |v: &Volcano| v.radius_m * (1.1 + 0.35 * f64::from(p.rifts) + 0.6 * f64::from(p.shelf) * (0.5 + 0.5 * v.age));
    // The box around them all, then the circle around its middle.
    let edge =
        |axis: usize, sign: f64| volcanoes.iter().map(|v| sign * v.centre[axis] + reach(v)).fold(f64::MIN, f64::max);
    let middle = [0, 1].map(|axis| 0.5 * (edge(axis, 1.0) - edge(axis, -1.0)));
    let far = |v: &Volcano| {
        let [x, y] = [v.centre[0] - middle[0], v.centre[1] - middle[1]];
        (x * x + y * y).sqrt() + reach(v)
    };
    let widest = volcanoes.iter().map(far).fold(f64::MIN, f64::max);
    let room = f64::from(p.radius) * side_m;
    let scale = room / widest;
    let aside = along([0.0; 2], 0.05 * room * draw.unit(), towards(draw.between(0.0, 360.0)));
    for v in volcanoes {
        v.centre = [0, 1].map(|i| scale * (v.centre[i] - middle[i]) + aside[i]);
        v.radius_m *= scale;
    }
}

impl Volcano {
    /// Rifts, cones, caldera, scar and valleys.
    fn dress(&mut self, p: &VolcanicIsland, draw: &mut Draw) {
        let (r, h, age) = (self.radius_m, self.height_m, self.age);
        let arms = if draw.unit() < 0.4 { 2 } else { 3 };
        let turn = draw.between(0.0, 360.0);
        for i in 0..arms {
            let angle = turn + 360.0 / f64::from(arms) * f64::from(i) + draw.between(-22.0, 22.0);
            self.rifts.push((towards(angle), f64::from(p.rifts) * draw.between(0.35, 1.0)));
        }

        // Cones stand along the rifts of young volcanoes.
        let cones = ((1.0 - age) * draw.between(4.0, 12.0)) as usize;
        for i in 0..cones {
            let (arm, _) = self.rifts[i % self.rifts.len()];
            let out = draw.between(0.25, 0.95) * r;
            let aside = draw.between(-0.16, 0.16) * r;
            let centre = along(along(self.centre, out, arm), aside, [-arm[1], arm[0]]);
            let radius_m = r * draw.between(0.05, 0.1);
            self.cones.push(Cone { centre, radius_m, height_m: radius_m * draw.between(0.35, 0.6) });
        }

        // A caldera, wider on old volcanoes; without one, a crater.
        let caldera = draw.happens(p.calderas);
        let wide = if caldera { draw.between(0.18, 0.3) + 0.08 * age } else { draw.between(0.03, 0.07) };
        let deep = if caldera { draw.between(0.3, 0.5) + 0.15 * age } else { draw.between(0.04, 0.12) };
        let summit = along(self.centre, 0.3 * wide * r * draw.unit(), towards(draw.between(0.0, 360.0)));
        let floor_m = h * (1.0 - wide).powi(2) * (1.0 - deep);
        let basin = Trough {
            head: summit,
            down: [0.0, 1.0],
            length_m: 1e12,
            open_m: 0.0,
            width_m: 0.75 * wide * r,
            widening: 0.0,
            head_m: floor_m,
            drowned_m: 0.0,
            wall: draw.between(0.7, 1.1),
        };

        // A flank that slid away takes the summit's side with it.
        let slid = draw.happens(p.collapses).then(|| draw.between(0.0, 360.0));
        if let Some(angle) = slid {
            let down = towards(angle);
            let head = along(self.centre, draw.between(-0.08, 0.15) * r, down);
            let length_m = 1.05 * r;
            self.troughs.push(Trough {
                head,
                down,
                length_m,
                open_m: 3.0 * length_m,
                width_m: draw.between(0.12, 0.2) * r,
                widening: draw.between(0.6, 1.4),
                head_m: h * draw.between(0.3, 0.5),
                drowned_m: 10.0 + 20.0 * age,
                wall: draw.between(0.7, 1.0),
            });
        }

        // Valleys: more, longer and deeper with age. On old volcanoes the first one drains the caldera.
        let valleys = (draw.between(2.0, 4.0) + 7.0 * age) as usize;
        for (i, angle) in draw.around(valleys).into_iter().enumerate() {
            let down = towards(angle);
            let gap = i == 0 && caldera && age > 0.35;
            let short = draw.unit();
            let out = if gap { 0.3 * wide } else { 0.9 * wide + 0.12 + 0.4 * short * short };
            let head = along(if gap { summit } else { self.centre }, out * r, down);
            let length_m = (1.02 - out).max(0.2) * r;
            let kept = draw.between(0.75, 0.95) - 0.5 * age;
            self.troughs.push(Trough {
                head,
                down,
                length_m,
                open_m: 3.0 * length_m,
                width_m: draw.between(0.02, 0.05) * r * (1.0 + age),
                widening: draw.between(0.5, 2.5),
                head_m: if gap { floor_m } else { (h * (1.0 - out) * kept).max(0.0) },
                drowned_m: age * draw.between(0.0, 0.05) * h,
                wall: draw.between(0.55, 0.9),
            });
        }
        self.troughs.push(basin);
    }
}
