// The surface between its nodes.

struct Node {
    albedo: vec3f,
    foam: f32,
    rise: vec2f,
    fresh: f32,
    // Share of the sun's disc in view.
    sun: f32,
    // Open share of the sky.
    open: f32,
}

// Texture coordinates of a place, in m.
fn map_place(p: vec2f) -> vec2f {
    return (p / frame.size.zw + 0.5) / vec2f(frame.nodes.xy);
}

// The values at a texture coordinate that moves by `dx` and `dy` from pixel to pixel. A pixel that is long on the ground, as all are
// towards the horizon, is the mean of up to four samples along its longer axis: samplers that do this themselves differ from driver
// to driver.
fn node_at(place: vec2f, dx: vec2f, dy: vec2f) -> Node {
    let size = vec2f(frame.nodes.xy);
    let a = dx * size;
    let b = dy * size;
    let is_b = dot(b, b) > dot(a, a);
    let long = max(length(select(a, b, is_b)), 1e-6);
    let short = abs(a.x * b.y - a.y * b.x) / long;
    let taps = clamp(ceil(long / max(short, 1.0)), 1.0, 4.0);
    let level = log2(max(long / taps, 1.0));
    // All beyond the rim is as the rim.
    let uv = clamp(place, vec2f(-0.01), vec2f(1.01));
    let axis = select(dx, dy, is_b);
    var ground = vec4f(0.0);
    var relief = vec4f(0.0);
    for (var i = 0.0; i < taps; i += 1.0) {
        let tap = uv + axis * ((i + 0.5) / taps - 0.5);
        ground += textureSampleLevel(ground_map, smooth_sampler, tap, level);
        relief += textureSampleLevel(relief_map, smooth_sampler, tap, level);
    }
    ground /= taps;
    relief /= taps;
    let node = uv * size - 0.5;
    let light_uv = (node / frame.block.z + 0.5) / vec2f(frame.flags.zw);
    let light = textureSampleLevel(light_map, smooth_sampler, light_uv, 0.0).xy;
    return Node(ground.rgb, ground.a, relief.xy, relief.z, soft(0.0, 1.0, light.x), light.y);
}

// Height at a place in m, linear between nodes; clamped to the rim.
fn height_at(p: vec2f) -> f32 {
    let last = vec2f(frame.nodes.xy) - 1.0;
    let node = clamp(p / frame.size.zw, vec2f(0.0), last);
    let base = min(vec2i(node), vec2i(last) - 1);
    let t = node - vec2f(base);
    let a = textureLoad(heights, base, 0).x;
    let b = textureLoad(heights, base + vec2i(1, 0), 0).x;
    let c = textureLoad(heights, base + vec2i(0, 1), 0).x;
    let d = textureLoad(heights, base + vec2i(1, 1), 0).x;
    return mix(mix(a, b, t.x), mix(c, d, t.x), t.y);
}

// How much of a river or lake a depth of fresh water makes.
fn river_cover(depth: f32) -> f32 {
    return soft(frame.tone.y, frame.tone.z, depth);
}
