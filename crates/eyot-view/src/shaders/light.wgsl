// Sky, haze, the light on surfaces and the film's curve; the same as in eyot-render, `sky.rs`, `scene.rs` and `picture.rs`.

// Forward scattering by haze: Henyey and Greenstein's phase function.
fn phase(g: f32, mu: f32) -> f32 {
    let x = 1.0 + g * g - 2.0 * g * mu;
    return (1.0 - g * g) / (x * sqrt(x));
}

// Clear air in the direction `d`; below the horizon as at the horizon.
fn clear_air(d: vec3f) -> vec3f {
    let up = max(d.z, 0.0);
    let blue = 1.0 - exp(-4.2 * up);
    let c = mix(frame.horizon.rgb, frame.zenith.rgb, blue * (0.86 + 0.14 * up));
    let mu = dot(d, frame.sun.xyz);
    let haze = 0.018 * phase(0.62, mu) * (0.35 + 0.65 * exp(-3.0 * up)) + 0.0022 * phase(0.94, mu);
    return c + frame.glow.rgb * haze;
}

// Density of a row of clouds, here and a little towards the sun.
fn heaps(azimuth: f32, elevation: f32, up: f32, tall: f32, fineness: f32, to_sun: f32, seed: u32) -> vec2f {
    let shift = 0.13 / fineness;
    let bank = fbm(vec2f(0.21 * fineness * azimuth, 0.3), 2u, seed ^ 7u);
    let here = fbm(vec2f(fineness * azimuth, 1.35 * fineness * elevation), 5u, seed);
    let there =
        fbm(vec2f(fineness * (azimuth + shift * to_sun), 1.35 * fineness * (elevation + shift)), 5u, seed);
    let higher = up + shift / tall;
    let rest = 0.8 * bank + 0.6 * frame.tone.w - 0.20;
    return vec2f(
        0.95 * here + rest - 0.55 * up * sqrt(abs(up)),
        0.95 * there + rest - 0.55 * higher * sqrt(abs(higher)),
    );
}

// Two rows of trade-wind cumulus: flat bases, heaped tops, lit from the sun's side.
fn clouds(behind: vec3f, d: vec3f) -> vec3f {
    let azimuth = atan2(d.x, -d.y);
    let to_sun = sin(atan2(frame.sun.x, -frame.sun.y) - azimuth);
    let elevation = asin(clamp(d.z, -1.0, 1.0));
    var c = behind;
    for (var k = 0u; k < 2u; k++) {
        // Far and low first, then near and high.
        let row = select(vec4f(0.012, 0.040, 26.0, 0.45), vec4f(0.030, 0.100, 11.0, 0.20), k == 1u);
        let up = (elevation - row.x) / row.y;
        if up < -0.3 || up >= 1.6 {
            continue;
        }
        let seed = frame.nodes.w ^ (0xc1u + 16u * k);
        var density = heaps(azimuth, elevation, up, row.y, row.z, to_sun, seed);
        // The bearing jumps at south: fade into what continues from the other side.
        let seam = 0.5 * soft(PI - 0.2, PI, abs(azimuth));
        if seam > 0.0 {
            let other = heaps(azimuth - sign(azimuth) * 2.0 * PI, elevation, up, row.y, row.z, to_sun, seed);
            density += seam * (other - density);
        }
        let body = soft(0.0, 0.16, density.x) * soft(-0.10, 0.10, up + 0.25 * density.x);
        let shade = soft(-0.10, 0.20, density.x - density.y) * (0.60 + 0.40 * soft(-0.1, 0.6, up));
        let lit = 0.36 * frame.sunlight.rgb + 0.50 * frame.skylight.rgb;
        let dark = 0.62 * frame.skylight.rgb + 0.085 * frame.sunlight.rgb;
        c = mix(c, mix(mix(dark, lit, shade), behind, row.w), 0.94 * body);
    }
    return c;
}

// The sky as the eye sees it: air, clouds and the sun's disc.
fn sky(d: vec3f) -> vec3f {
    var c = clear_air(d);
    if frame.tone.w > 0.0 && d.z > 0.004 {
        c = clouds(c, d);
    }
    return c + frame.sunlight.rgb * 12.0 * soft(0.99993, 0.99997, dot(d, frame.sun.xyz));
}

// A surface seen along `d` through `way` m of air. Blue is scattered more than red.
fn through_air(surface: vec3f, d: vec3f, way: f32) -> vec3f {
    let optical = frame.scale.w * way;
    if optical <= 0.0 {
        return surface;
    }
    let left = exp(-vec3f(0.72, 0.95, 1.28) * optical);
    let level = normalize(vec3f(d.xy, max(d.z, 0.0) + 0.035));
    return surface * left + 0.94 * clear_air(level) * (1.0 - left);
}

// Light that falls on a surface: the sun, the open sky, and sunlit ground for what is not sky.
fn irradiance(normal: vec3f, sun: f32, open: f32) -> vec3f {
    let direct = frame.sunlight.rgb * sun * max(dot(normal, frame.sun.xyz), 0.0);
    let above = frame.skylight.rgb * open * (0.62 + 0.38 * normal.z);
    let bounce = frame.sunlight.rgb * (0.050 * (1.0 - open) + 0.028 * (1.0 - normal.z));
    return direct + above + bounce;
}

fn encode(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn decode(c: vec3f) -> vec3f {
    return select(pow((c + 0.055) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

// Light to the value that the target stores, with half a step of dither against banding. Colours of layers keep their legend's
// values; all else goes through a filmic curve (Narkowicz' fit of the ACES reference).
fn developed(light: vec3f, pixel: vec2f, is_data: bool) -> vec4f {
    let x = max(light * frame.tone.x, vec3f(0.0));
    let film = min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), vec3f(1.0));
    let c = encode(select(film, clamp(light, vec3f(0.0), vec3f(1.0)), is_data));
    let step = f32(hash(i32(pixel.x), i32(pixel.y), 77u) & 0xffffu) / 65536.0 - 0.5;
    let value = clamp(c + step / 255.0, vec3f(0.0), vec3f(1.0));
    return vec4f(select(value, decode(value), frame.picture.w == 1.0), 1.0);
}
