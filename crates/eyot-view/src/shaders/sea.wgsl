// The sea: bottom seen through the water, reflected sky, the sun's glitter and foam; the same as in eyot-render, `sea.rs`.

struct SeaVertex {
    @builtin(position) position: vec4f,
}

// Four triangles from below the camera to the horizon, or the two of a relief model's pane.
@vertex
fn sea_vertex(@builtin(vertex_index) vertex: u32) -> SeaVertex {
    if is_block() {
        let i = vertex % 3u;
        let half = vec2u(i & 1u, i >> 1u);
        let corner = select(half, 1u - half, vertex > 2u);
        return SeaVertex(projected(vec4f(vec2f(corner) * frame.size.xy, 0.0, 1.0)));
    }
    let side = (vertex / 3u + max(vertex % 3u, 1u) - 1u) % 4u;
    let far = vec4f(select(-1.0, 1.0, side == 0u || side == 3u), select(-1.0, 1.0, side < 2u), 0.0, 0.0);
    let below = vec4f(frame.eye.xy, 0.0, 1.0);
    return SeaVertex(projected(select(far, below, vertex % 3u == 0u)));
}

@fragment
fn sea_fragment(in: SeaVertex) -> @location(0) vec4f {
    let d = view_ray(in.position.xy);
    let down = max(-d.z, 1e-6);
    let distance = frame.eye.z / down;
    let p = frame.eye.xyz + d * distance;
    let uv = map_place(p.xy);
    // At the horizon neighbouring pixels lie so far apart that only the coarsest texel is left.
    let dx = clamp(dpdx(uv), vec2f(-1.0), vec2f(1.0));
    let dy = clamp(dpdy(uv), vec2f(-1.0), vec2f(1.0));
    if distance > 3e3 * frame.scale.x {
        return developed(sky(d), in.position.xy, false);
    }
    let c = sea(p, d, frame.picture.z * distance, uv, dx, dy);
    return developed(through_air(c, d, distance), in.position.xy, false);
}

// Depth added near and beyond the rim so that the open sea shows no corner of the grid.
fn fall_off(p: vec2f) -> f32 {
    if is_block() {
        return 0.0;
    }
    let half = 0.5 * frame.size.xy;
    let margin = 0.11 * min(half.x, half.y);
    let corner = 0.75 * min(half.x, half.y);
    let q = abs(p - half) - half + corner;
    let outside = length(max(q, vec2f(0.0))) + min(max(q.x, q.y), 0.0) - corner;
    if outside < -3.0 * margin {
        return 0.0;
    }
    let wander = 1.25 * margin * fbm(5.0 * p / frame.scale.x, 4u, 61u);
    let t = soft(-1.6 * margin, 1.4 * margin, outside + wander);
    return 4.0 * frame.scale.y * t * t;
}

// Light that the sea's surface at `p` sends along `-d`; a pixel is `footprint` m wide across the view.
fn sea(p: vec3f, d: vec3f, footprint: f32, uv: vec2f, dx: vec2f, dy: vec2f) -> vec3f {
    let clarity = frame.scale.y;
    let tall = frame.scale.z;
    let still = max(-d.z, 1e-3);
    // On the flat sea a pixel is longer than wide; waves fade by a mean of both.
    let wave = waves(p.xy, frame.scale.x / 42.0, footprint / sqrt(still), frame.eye.w);
    let extra = fall_off(p.xy);
    let surface_depth = max(extra - height_at(p.xy) / tall, 0.0);
    // Sheltered water is calm; gusts make the open sea uneven.
    let calm = 0.30 + 0.70 * soft(0.1, 1.3, surface_depth / clarity);
    let gusts = 1.0 + 0.5 * fbm(vec2f(6.0, 9.0) * p.xy / frame.scale.x, 3u, 71u);
    let strength = calm * gusts;
    let normal = normalize(vec3f(-strength * wave.xy, 1.0));
    let cosine = max(-dot(d, normal), 0.02);

    // The bottom, where the bent ray meets it.
    let down = refracted(cosine);
    let bend = sqrt(max(1.0 - down * down, 0.0)) / down;
    let flat = max(length(d.xy), 1e-6);
    let reach = min(surface_depth * tall, 2.0 * clarity) * bend;
    let way = d.xy / flat * reach + normal.xy * surface_depth;
    let bottom = node_at(map_place(p.xy + way), dx, dy);
    let here = node_at(uv, dx, dy);
    let depth = 0.5 * (max(extra - height_at(p.xy + way) / tall, 0.0) + surface_depth);
    let sun_up = max(frame.sun.z, 0.0);
    let path = 1.0 / down + 1.0 / refracted(sun_up);
    let floor_normal = normalize(vec3f(-bottom.rise, 1.0));
    let tilt = min(0.35 + 0.65 * max(dot(floor_normal, frame.sun.xyz), 0.0) / max(frame.sun.z, 0.1), 1.25);
    let light = frame.sunlight.rgb * here.sun * sun_up + frame.skylight.rgb * here.open;
    let body = upwelling(
        bottom.albedo * tilt, depth, path, frame.sea_absorb.rgb, frame.sea_deep.rgb, frame.sea_build.rgb,
    ) * light;

    // Waves that are too small to see tilt the mirror away from grazing angles.
    let rough = wave.z;
    let f = fresnel(min(cosine + 0.55 * rough * strength, 1.0));
    var mirror = d + normal * (2.0 * cosine);
    mirror.z = abs(mirror.z) + 0.6 * rough;
    var c = body * (1.0 - f) + clear_air(normalize(mirror)) * (0.45 + 0.55 * here.open) * f;

    // Glitter: how many of the small mirrors face half way to the sun (Cox and Munk's slopes).
    let half = normalize(frame.sun.xyz - d);
    if half.z > 0.05 {
        let spread = 0.004 + 0.9 * (rough * strength) * (rough * strength);
        let s = half.xy / half.z - normal.xy / normal.z;
        let facing = exp(-dot(s, s) / spread) / (PI * spread);
        let steep = half.z * half.z * half.z * half.z;
        let glint = 0.25 * fresnel(max(dot(half, frame.sun.xyz), 0.0)) * facing / (steep * max(cosine, 0.15));
        c += frame.sunlight.rgb * here.sun * min(glint, 3.0);
    }
    return mix(c, 0.62 * light, foam(p.xy, surface_depth, here.foam));
}

// Cover of breaking waves; their pattern drifts to the shore with the waves.
fn foam(p: vec2f, depth: f32, surf: f32) -> f32 {
    if surf <= 0.01 {
        return 0.0;
    }
    let k = 260.0 / frame.scale.x;
    let drift = vec2f(0.921, 0.391) * 0.6 * frame.eye.w;
    let q = p * k - drift;
    let broken = fbm(q, 3u, 83u) + 0.35 * fbm(q * 0.12, 2u, 85u);
    let edge = soft(0.10, 0.0, depth / frame.scale.y);
    return 0.80 * soft(0.30, 0.72, surf * (0.62 + 0.38 * edge) + 0.55 * broken);
}
