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

// The values at a texture coordinate that moves by `dx` and `dy` from pixel to pixel.
fn node_at(uv: vec2f, dx: vec2f, dy: vec2f) -> Node {
    let ground = textureSampleGrad(ground_map, smooth_sampler, uv, dx, dy);
    let relief = textureSampleGrad(relief_map, smooth_sampler, uv, dx, dy);
    let node = uv * vec2f(frame.nodes.xy) - 0.5;
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
