//! The sea: bottom seen through the water, reflected sky, the sun's glitter and foam.

use crate::math::{V3, add, dot, mix, mul, scale, smoothstep, unit};
use crate::scene::Scene;
use crate::water::{fresnel, refracted_cos, waves};
use eyot_noise::picture::fbm;

/// Colour of the sea's surface at `p` seen along `d`, a pixel being `footprint` m wide across the view.
pub(crate) fn sea(s: &Scene, p: V3, d: V3, footprint: f32) -> V3 {
    let unit_m = s.stage.extent / 42.0;
    let still = (-d[2]).max(1e-3);
    // On the flat sea a pixel is longer than wide; waves fade by a mean of both.
    let (wave, rough) = waves(p[0], p[1], unit_m, footprint / still.sqrt());
    let (u, v) = s.place(p);
    let extra = s.fall_off(p[0], p[1]);
    let depth_below = |u: f32, v: f32| -s.surface.height(u, v) / s.stage.exaggeration + extra;
    let surface_depth = depth_below(u, v).max(0.0);
    // Sheltered water is calm; gusts make the open sea uneven.
    let calm = 0.30 + 0.70 * smoothstep(0.1, 1.3, surface_depth / s.stage.clarity);
    let gusts = 1.0 + 0.5 * fbm(6.0 * p[0] / s.stage.extent, 9.0 * p[1] / s.stage.extent, 3, 71);
    let strength = calm * gusts;
    let normal = unit([-strength * wave[0], -strength * wave[1], 1.0]);
    let cos = (-dot(d, normal)).max(0.02);

    // The bottom, where the bent ray meets it.
    let down = refracted_cos(cos);
    let bend = (1.0 - down * down).max(0.0).sqrt() / down;
    let flat = (d[0] * d[0] + d[1] * d[1]).sqrt().max(1e-6);
    let reach = (surface_depth * s.stage.exaggeration).min(2.0 * s.stage.clarity) * bend;
    let way = [d[0] / flat * reach + normal[0] * surface_depth, d[1] / flat * reach + normal[1] * surface_depth];
    let (bu, bv) = (u + way[0] / s.surface.step[0], v + way[1] / s.surface.step[1]);
    let bottom = s.node(bu, bv);
    let depth = 0.5 * (depth_below(bu, bv).max(0.0) + surface_depth);
    let here = s.node(u, v);
    let open = s.open_sky(u, v);
    let sun_down = refracted_cos(s.stage.sky.sun[2].max(0.0));
    let path = 1.0 / down + 1.0 / sun_down;
    let floor_normal = unit([-bottom.rise[0], -bottom.rise[1], 1.0]);
    let tilt = (0.35 + 0.65 * dot(floor_normal, s.stage.sky.sun).max(0.0) / s.stage.sky.sun[2].max(0.1)).min(1.25);
    let wet = scale(bottom.albedo, tilt);
    let light =
        add(scale(s.stage.sky.sunlight, here.sun * s.stage.sky.sun[2].max(0.0)), scale(s.stage.sky.skylight, open));
    let body = mul(s.stage.sea_water.upwelling(wet, depth, path), light);

    // Waves that are too small to see tilt the mirror away from grazing angles.
    let f = fresnel((cos + 0.55 * rough * strength).min(1.0));
    let mut mirror = add(d, scale(normal, 2.0 * cos));
    mirror[2] = mirror[2].abs() + 0.6 * rough;
    let reflected = scale(s.stage.sky.clear(unit(mirror)), 0.45 + 0.55 * open);
    let mut c = add(scale(body, 1.0 - f), scale(reflected, f));

    // Glitter: how many of the small mirrors face half way to the sun (Cox and Munk's slopes).
    let half = unit(add(s.stage.sky.sun, scale(d, -1.0)));
    if half[2] > 0.05 {
        let spread = 0.004 + 0.9 * (rough * strength) * (rough * strength);
        let (sx, sy) = (half[0] / half[2] - normal[0] / normal[2], half[1] / half[2] - normal[1] / normal[2]);
        let facing = (-(sx * sx + sy * sy) / spread).exp() / (std::f32::consts::PI * spread);
        let glint = 0.25 * fresnel(dot(half, s.stage.sky.sun).max(0.0)) * facing / (half[2].powi(4) * cos.max(0.15));
        c = add(c, scale(s.stage.sky.sunlight, here.sun * glint.min(3.0)));
    }

    let white = foam(s, p, surface_depth, here.foam);
    if white > 0.0 {
        c = mix(c, scale(light, 0.62), white);
    }
    c
}

/// Cover of breaking waves, 0..1.
fn foam(s: &Scene, p: V3, depth: f32, surf: f32) -> f32 {
    if surf <= 0.01 {
        return 0.0;
    }
    let k = 260.0 / s.stage.extent;
    let broken = fbm(p[0] * k, p[1] * k, 3, 83) + 0.35 * fbm(p[0] * k * 0.12, p[1] * k * 0.12, 2, 85);
    let edge = smoothstep(0.10, 0.0, depth / s.stage.clarity);
    0.80 * smoothstep(0.30, 0.72, surf * (0.62 + 0.38 * edge) + 0.55 * broken)
}
