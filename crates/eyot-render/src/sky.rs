//! The sky: a clear-day gradient with the sun's glow, fair-weather clouds, and the haze that lies over distance.

use crate::math::{V3, add, dot, mix, mul, scale, smoothstep};
use eyot_noise::picture::fbm;
use std::f32::consts::PI;

/// Light of sun and sky for one picture. Colours are linear; 1 is what a white sheet sends back at noon, about.
#[derive(Clone, Copy, Debug)]
pub struct Sky {
    /// Direction to the sun.
    pub sun: V3,
    /// Light of the sun on a surface that faces it.
    pub sunlight: V3,
    /// Light of the open sky on a level surface.
    pub skylight: V3,
    /// Colour of clear air overhead.
    pub zenith: V3,
    /// Colour of clear air at the horizon.
    pub horizon: V3,
    /// Light that haze scatters forward, around the sun.
    pub glow: V3,
    /// Fair-weather clouds, 0 to 1.
    pub clouds: f32,
    /// Seed of the clouds.
    pub seed: u32,
}

impl Sky {
    pub(crate) fn new(sun: V3, clouds: f32, seed: u32) -> Self {
        // 0 with the sun on the horizon, 1 from 25 degrees up.
        let high = smoothstep(-0.02, 0.42, sun[2]);
        let low = [1.0, 0.52, 0.24];
        let warm = mix(low, [1.0, 0.955, 0.88], high.sqrt());
        let strength = smoothstep(-0.08, 0.30, sun[2]);
        Self {
            sun,
            sunlight: scale(warm, 2.75 * strength),
            skylight: mix([0.16, 0.20, 0.34], [0.47, 0.585, 0.75], strength),
            zenith: mix([0.030, 0.060, 0.170], [0.055, 0.190, 0.560], strength),
            horizon: mix([0.66, 0.40, 0.27], [0.40, 0.62, 0.92], high),
            glow: scale(warm, 0.25 + 0.75 * strength),
            clouds: clouds.clamp(0.0, 1.0),
            seed,
        }
    }

    /// Clear air in the direction `d`; below the horizon as at the horizon.
    pub(crate) fn clear(&self, d: V3) -> V3 {
        let up = d[2].max(0.0);
        let blue = 1.0 - (-4.2 * up).exp();
        let mut c = mix(self.horizon, self.zenith, blue * (0.86 + 0.14 * up));
        // Forward scattering by haze: Henyey and Greenstein's phase function, wide and narrow.
        let mu = dot(d, self.sun);
        let phase = |g: f32| {
            let x = 1.0 + g * g - 2.0 * g * mu;
            (1.0 - g * g) / (x * x.sqrt())
        };
        c = add(c, scale(self.glow, 0.018 * phase(0.62) * (0.35 + 0.65 * (-3.0 * up).exp()) + 0.0022 * phase(0.94)));
        c
    }

    /// The sky as the eye sees it: air, clouds and the sun's disc.
    pub(crate) fn seen(&self, d: V3) -> V3 {
        let mut c = self.clear(d);
        if self.clouds > 0.0 && d[2] > 0.004 {
            c = self.cloud(c, d);
        }
        let disc = smoothstep(0.999_93, 0.999_97, dot(d, self.sun));
        add(c, scale(self.sunlight, 12.0 * disc))
    }

    /// Two rows of trade-wind cumulus over the horizon: flat bases, heaped tops, lit from the sun's side.
    fn cloud(&self, behind: V3, d: V3) -> V3 {
        let azimuth = d[0].atan2(-d[1]);
        let to_sun = (self.sun[0].atan2(-self.sun[1]) - azimuth).sin();
        let elevation = d[2].clamp(-1.0, 1.0).asin();
        let mut c = behind;
        // Far and low first, then near and high.
        for (k, (base, tall, fineness, clear)) in
            [(0.012, 0.040, 26.0, 0.45), (0.030, 0.100, 11.0, 0.20)].into_iter().enumerate()
        {
            let up = (elevation - base) / tall;
            if !(-0.3..1.6).contains(&up) {
                continue;
            }
            let seed = self.seed ^ (0xc1 + 16 * k as u32);
            let heaps = |azimuth: f32| {
                let lump = |turn: f32, lift: f32| {
                    fbm(fineness * (azimuth + turn), 1.35 * fineness * (elevation + lift), 5, seed)
                };
                let bank = fbm(0.21 * fineness * azimuth, 0.3, 2, seed ^ 7);
                let heap = |turn: f32, lift: f32, up: f32| {
                    0.95 * lump(turn, lift) + 0.8 * bank - 0.55 * up * up.abs().sqrt() + 0.6 * self.clouds - 0.20
                };
                let shift = 0.13 / fineness;
                [heap(0.0, 0.0, up), heap(shift * to_sun, shift, up + shift / tall)]
            };
            let [mut density, mut towards] = heaps(azimuth);
            // The bearing jumps at south: fade into what continues from the other side.
            let seam = smoothstep(PI - 0.2, PI, azimuth.abs()) * 0.5;
            if seam > 0.0 {
                let other = heaps(azimuth - azimuth.signum() * 2.0 * PI);
                density += seam * (other[0] - density);
                towards += seam * (other[1] - towards);
            }
            let body = smoothstep(0.0, 0.16, density) * smoothstep(-0.10, 0.10, up + 0.25 * density);
            if body <= 0.0 {
                continue;
            }
            let shade = smoothstep(-0.10, 0.20, density - towards) * (0.60 + 0.40 * smoothstep(-0.1, 0.6, up));
            let lit = add(scale(self.sunlight, 0.36), scale(self.skylight, 0.50));
            let dark = add(scale(self.skylight, 0.62), scale(self.sunlight, 0.085));
            let colour = mix(mix(dark, lit, shade), behind, clear);
            c = mix(c, colour, 0.94 * body);
        }
        c
    }

    /// Light of air over a surface seen in direction `d` through haze of transmittance `clear`.
    pub(crate) fn through_air(&self, surface: V3, d: V3, optical: f32) -> V3 {
        // Blue is scattered more than red: nearer hills turn blue before they turn pale.
        let left = [(-0.72 * optical).exp(), (-0.95 * optical).exp(), (-1.28 * optical).exp()];
        let level = crate::math::unit([d[0], d[1], d[2].max(0.0) + 0.035]);
        let air = scale(self.clear(level), 0.94);
        add(mul(surface, left), mul(air, left.map(|l| 1.0 - l)))
    }
}
