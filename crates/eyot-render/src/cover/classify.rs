//! The classes of a cell: grounds laid one over the other, from bare soil to snow.
//!
//! Each ground covers a share of what lay there before, so that shares sum to 1. With `S(a, b, x)` the smooth step, and the noises of the place
//! in every border:
//! 1. soil, dry grass, green grass, bushes and forest by moisture: that of the palette or the climate, more in hollows, on the shady side and by
//!    `wetness`, less on ridges and slopes; nothing where it is arid. Where there is a layer `forest`, it says where forest is. Trees end at the tree line, bushes somewhat above, grass on the way to the snow line.
//! 2. scree and rock by slope, in units of the slope at which half of the ground is rock. Cells round slopes off, so this begins
//!    at smaller slopes in larger cells: `(10 m / cell)^0.16`.
//! 3. mud where it is flat and wet, gravel where rivers ran.
//! 4. beaches where it is low and not steep; palms and bushes from a metre up, so that islets are green in the middle.
//! 5. snow by the snow line, lower on the shady side and in hollows, none on cliffs; ice by its layer.
//!
//! The sea's floor is sand, weed, mud by depth, rock by slope, and reef.

use super::looks::Palette;
use super::strip::Site;
use super::{Class, Cover, Weights};
use crate::math::{lerp, smoothstep};

/// Metres of height for a degree of temperature.
const LAPSE_M: f32 = 150.0;
/// Mean temperatures at which trees end, and at which it hardly ever thaws, °C.
const TREE_C: f32 = -1.7;
const SNOW_C: f32 = -10.0;

/// Covers a share of what was there.
fn lay(w: &mut Weights, class: Class, share: f32) {
    let share = share.clamp(0.0, 1.0);
    w.iter_mut().for_each(|v| *v *= 1.0 - share);
    w[class as usize] += share;
}

impl Cover {
    pub(super) fn classified(&self, s: &Site) -> Weights {
        let under = if self.sea { smoothstep(0.15, -0.15, s.z) } else { 0.0 };
        let mut w = if under < 1.0 { self.land(s) } else { Weights::default() };
        if under > 0.0 {
            let sea = self.floor(s);
            w.iter_mut().zip(sea).for_each(|(w, f)| *w = lerp(*w, f, under));
        }
        w
    }

    /// From 0 where a cell shows slopes to 1 where it holds whole valleys.
    fn coarse(&self) -> f32 {
        smoothstep(3_000.0, 20_000.0, self.cell[0].min(self.cell[1]))
    }

    /// Slope, as rise over run, at which half of the ground is rock.
    fn rock_slope(&self) -> f32 {
        match self.looks.rock_slope_deg {
            Some(deg) => deg.to_radians().tan(),
            None => ((10.0 / self.cell[0].min(self.cell[1])).powf(0.16)).clamp(0.30, 1.1) * self.tints.cliffs,
        }
    }

    /// Steepness of which 1 is half rock, with noise; what green does to cliffs aside.
    fn steepness(&self, s: &Site) -> f32 {
        s.slope / self.rock_slope() * (1.0 - 0.9 * self.coarse()) + 0.26 * s.fine + 0.16 * s.broad - 0.06 * s.hollow
    }

    /// Heights over the tree line and over the snow line, m, without noise, and moisture, 0..1.
    fn lines(&self, s: &Site) -> (f32, f32, f32) {
        let coarse = self.coarse();
        // Means over whole ranges say less of their heights.
        let lift = 1500.0 * coarse;
        let (mut trees, mut snow, moisture) = match s.climate {
            Some((t, rain)) => {
                let moisture = 0.32 * smoothstep(0.12, 0.5, rain) + 0.40 * smoothstep(0.45, 1.2, rain);
                ((TREE_C - t) * LAPSE_M, (SNOW_C - t) * LAPSE_M, moisture)
            }
            None => {
                let dry = 0.35 * coarse * smoothstep(500.0, 1900.0, s.z);
                (s.z - self.tints.trees - lift, s.z - self.tints.snow - lift, self.tints.moisture - dry)
            }
        };
        if let Some(line) = self.looks.tree_line_m {
            trees = s.z - line;
        }
        if let Some(line) = self.looks.snow_line_m {
            snow = s.z - line;
        }
        (trees, snow - self.tints.winter, lerp(moisture, 0.04, s.aridity))
    }

    fn land(&self, s: &Site) -> Weights {
        let (trees, snow, moisture) = self.lines(s);
        let steep = self.steepness(s);
        let flat = smoothstep(0.30, 0.08, s.slope);
        let m = moisture
            + 0.20 * s.broad
            + 0.12 * s.region
            + 0.08 * s.fine
            + 0.07 * s.hollow
            + 0.14 * s.shade
            + 0.25 * smoothstep(0.02, 0.25, s.wetness)
            - 0.10 * smoothstep(0.4, 1.1, steep);
        let mut w = Weights::default();
        w[Class::Soil as usize] = 1.0;
        lay(&mut w, Class::DryGrass, smoothstep(0.06, 0.30, m));
        // Green on the way up turns into turf.
        let height = trees + 240.0 * s.broad + 110.0 * s.fine - 90.0 * s.hollow + 170.0 * s.shade;
        let turf = smoothstep(-350.0, 500.0, height);
        lay(&mut w, Class::Grass, smoothstep(0.34, 0.60, m) * (1.0 - 0.75 * turf));
        let bushes = 0.8 * smoothstep(0.40, 0.60, m + 0.30 * s.fine) * smoothstep(420.0, 60.0, height);
        match s.low {
            // Grass in the shade of what is taller is not counted: of the open ground it covers so much.
            Some([shrubs, grass]) => {
                let open = 1.0 - s.forest.unwrap_or(0.0).max(shrubs);
                lay(&mut w, Class::Soil, smoothstep(0.5, 0.1, grass / open.max(0.2)));
                lay(&mut w, Class::Shrub, shrubs);
            }
            None => lay(&mut w, Class::Shrub, bushes),
        }
        let woods = smoothstep(0.47, 0.62, m + 0.18 * s.fine) * smoothstep(150.0, -150.0, height);
        // Meadows and fields lie where it is level.
        let clearing = 0.75 * flat * smoothstep(0.05, 0.30, s.region + 0.8 * s.broad);
        lay(&mut w, Class::Forest, s.forest.unwrap_or(woods * (1.0 - clearing)));
        // From the trees to the snow life thins out.
        let way = height / (trees - snow).clamp(200.0, 2500.0);
        let bare = smoothstep(0.30, 0.95, way);
        lay(&mut w, Class::Scree, 0.85 * bare * (0.75 + 0.25 * smoothstep(-0.2, 0.2, s.fine)));
        // Green climbs cliffs where it is wet and low; where it is arid or high even gentle slopes are bare.
        let dry = smoothstep(0.30, 0.05, m);
        let steep = steep - 0.20 * smoothstep(0.50, 0.80, m) + 0.22 * bare + 0.40 * dry;
        lay(&mut w, Class::Scree, 0.7 * smoothstep(0.62, 0.88, steep) * bare.max(0.25 * (1.0 - dry)));
        lay(&mut w, Class::Rock, smoothstep(0.84, 1.16, steep));
        let level = smoothstep(0.06, 0.02, s.slope);
        let swamp = smoothstep(0.04, 0.14, s.wetness).max(0.7 * smoothstep(0.82, 1.0, m + 0.2 * s.hollow));
        lay(&mut w, Class::Mud, 0.8 * level * swamp * smoothstep(100.0, -200.0, height));
        lay(&mut w, Class::Gravel, 0.8 * smoothstep(0.18, 0.60, s.wetness));
        if self.sea {
            self.beach(s, m, &mut w);
        }
        let fall = snow + 210.0 * s.broad + 120.0 * s.fine + 160.0 * s.shade + 70.0 * s.hollow;
        lay(
            &mut w,
            Class::Snow,
            smoothstep(-180.0, 260.0, fall) * smoothstep(1.40, 0.80, steep - 0.22 * bare - 0.15 * s.hollow),
        );
        lay(&mut w, Class::Snow, s.ice);
        w
    }

    fn beach(&self, s: &Site, m: f32, w: &mut Weights) {
        let high = self.looks.beach_m.unwrap_or(3.0) * (1.0 - self.coarse());
        if high <= 0.0 {
            return;
        }
        let band = high * (1.0 + 0.9 * s.broad + 0.5 * s.fine) * (1.0 + 0.4 * s.reef);
        let sand = smoothstep(1.25 * band, 0.60 * band, s.z) * smoothstep(0.42, 0.20, s.slope);
        // Palms stand a metre above the waves.
        let palms = 0.95 * smoothstep(0.42, 0.62, m + 0.5 * s.fine + 0.2) * smoothstep(0.26 * high, 0.55 * high, s.z);
        if palms > 0.0 && sand > 0.0 && self.looks.palette == Palette::Tropical {
            lay(w, Class::Sand, 0.8 * sand);
            lay(w, Class::Forest, 0.95 * sand * palms);
            lay(w, Class::Sand, sand * (1.0 - palms));
        } else {
            lay(w, Class::Sand, sand);
        }
        lay(w, Class::WetSand, sand * smoothstep(0.8, 0.15, s.z + 0.4 * s.fine));
    }

    fn floor(&self, s: &Site) -> Weights {
        let depth = (-s.z).max(0.0);
        let mut w = Weights::default();
        w[Class::SeaFloor as usize] = 1.0;
        lay(&mut w, Class::WetSand, 0.6 * smoothstep(1.5, 0.0, depth));
        lay(&mut w, Class::DeepSea, smoothstep(14.0, 70.0, depth * (1.0 + 0.5 * s.broad)));
        let patch = smoothstep(0.10, 0.32, s.fine + 0.45 * s.broad);
        lay(&mut w, Class::Weed, 0.62 * patch * smoothstep(0.8, 3.0, depth) * smoothstep(30.0, 14.0, depth));
        lay(&mut w, Class::Rock, 0.8 * smoothstep(0.85, 1.25, self.steepness(s)));
        lay(&mut w, Class::Reef, 0.92 * s.reef * smoothstep(60.0, 30.0, depth));
        w
    }
}
