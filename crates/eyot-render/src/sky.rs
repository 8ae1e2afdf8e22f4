//! The sky: a clear-day gradient with the sun's glow, fair-weather clouds, and the haze that lies over distance.

use crate::math::{V3, add, dot, mix, mul, scale, smoothstep};
use crate::noise::fbm;

/// Light of sun and sky for one picture. Colours are linear; 1 is what a white sheet sends back at noon, about.
pub(crate) struct Sky {
    /// Direction to the sun.
    pub(crate) sun: V3,
    /// Light of the sun on a surface that faces it.
    pub(crate) sunlight: V3,
    /// Light of the open sky on a level surface.
    pub(crate) skylight: V3,
    zenith: V3,
    horizon: V3,
    glow: V3,
    clouds: f32,
    seed: u32,
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
            skylight: mix([0.16, 0.20, 0.34], [0.40, 0.53, 0.74], strength),
            zenith: mix([0.030, 0.060, 0.170], [0.055, 0.190, 0.560], strength),
            horizon: mix([0.52, 0.36, 0.30], [0.50, 0.70, 0.93], high),
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
        c = add(c, scale(self.glow, 0.026 * phase(0.62) * (0.35 + 0.65 * (-3.0 * up).exp()) + 0.0022 * phase(0.94)));
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

    /// A thin field of cumulus: noise on a plane overhead, lit by how dense it is towards the sun.
    fn cloud(&self, behind: V3, d: V3) -> V3 {
        // A curved shell instead of a plane keeps the far field from shrinking to a line.
        let way = 1.0 / (d[2] + 0.055);
        let (x, y) = (d[0] * way * 1.15, d[1] * way * 1.15);
        let cover = 0.24 - 0.36 * self.clouds;
        let shape = |x: f32, y: f32| {
            fbm(x * 0.55, y * 0.55, 2, self.seed ^ 0xc1) * 0.55
                + fbm(x * 1.3 + 5.0, y * 1.3, 5, self.seed ^ 0xc2) * 0.75
        };
        let density = shape(x, y);
        let body = smoothstep(cover, cover + 0.30, density);
        if body <= 0.0 {
            return behind;
        }
        let towards = shape(x + 0.16 * self.sun[0], y + 0.16 * self.sun[1]);
        let shade = smoothstep(-0.22, 0.22, density - towards);
        let lit = add(mul(self.sunlight, [0.40, 0.40, 0.40]), scale(self.skylight, 0.35));
        let dark = add(scale(self.skylight, 0.72), scale(self.sunlight, 0.09));
        let colour = mix(dark, lit, 0.35 + 0.65 * shade * (1.0 - 0.35 * body));
        // Distance swallows the clouds near the horizon.
        let near = smoothstep(0.004, 0.16, d[2]);
        mix(behind, mix(behind, colour, 0.45 + 0.55 * near), 0.86 * body * near.sqrt())
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
