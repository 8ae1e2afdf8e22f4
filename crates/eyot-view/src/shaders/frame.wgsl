// What every shader of a picture shares. Lengths in m east, south and up; colours are linear.

struct Frame {
    // Where the camera stands; w: seconds since the film began.
    eye: vec4f,
    // Middle of the picture; w: near plane.
    forward: vec4f,
    // w: half the picture's width at distance 1.
    right: vec4f,
    // w: half the picture's height at distance 1.
    up: vec4f,
    // Columns, rows, length of a pixel at distance 1, 1 if the target itself puts colours on the sRGB curve.
    picture: vec4f,
    // Range of the finest level, share of a range where morphing begins, square of the height over the land, 1 for layer colours.
    detail: vec4f,
    // Distance of the outermost nodes, distance of neighbours.
    size: vec4f,
    // Longer side of the grid, clarity of the sea, factor on heights, optical depth of the air per metre.
    scale: vec4f,
    // Exposure, depths between which a river comes into sight, cover of clouds.
    tone: vec4f,
    // Base and top of the relief model, nodes a texel of the light map, 1 if there is a layer of flow.
    block: vec4f,
    // Columns and rows of nodes, finest level with nothing above it, seed of the clouds.
    nodes: vec4u,
    // 1 for a sea, 1 for a relief model, columns and rows of the light map.
    flags: vec4u,
    sun: vec4f,
    sunlight: vec4f,
    skylight: vec4f,
    zenith: vec4f,
    horizon: vec4f,
    glow: vec4f,
    sea_absorb: vec4f,
    sea_deep: vec4f,
    sea_build: vec4f,
    fresh_absorb: vec4f,
    fresh_deep: vec4f,
    fresh_build: vec4f,
    soil: vec4f,
    studio: vec4f,
    pane: vec4f,
    deep_pane: vec4f,
    beds: array<vec4f, 5>,
    // Every level of the surface: its place in the texture of heights, its last column and row.
    levels: array<vec4u, 16>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Heights as drawn, level by level.
@group(0) @binding(1) var heights: texture_2d<f32>;
// Albedo and cover of foam.
@group(0) @binding(2) var ground_map: texture_2d<f32>;
// Rise eastward and southward, depth of fresh water.
@group(0) @binding(3) var relief_map: texture_2d<f32>;
// Height of the sun's disc over the horizon, open share of the sky.
@group(0) @binding(4) var light_map: texture_2d<f32>;
// Velocity of fresh water, as a share of the quickest.
@group(0) @binding(5) var flow_map: texture_2d<f32>;
@group(0) @binding(6) var smooth_sampler: sampler;

const PI: f32 = 3.14159265;

// Clip coordinates of a point (w = 1) or of a direction (w = 0); the depth is near / distance, so that it is exact far away.
fn projected(place: vec4f) -> vec4f {
    let v = place.xyz - frame.eye.xyz * place.w;
    return vec4f(
        dot(frame.right.xyz, v) / frame.right.w,
        dot(frame.up.xyz, v) / frame.up.w,
        frame.forward.w * place.w,
        dot(frame.forward.xyz, v),
    );
}

// Direction through a point of the picture, in pixels.
fn view_ray(pixel: vec2f) -> vec3f {
    let a = (pixel.x - 0.5 * frame.picture.x) * frame.picture.z;
    let b = (0.5 * frame.picture.y - pixel.y) * frame.picture.z;
    return normalize(frame.forward.xyz + frame.right.xyz * a + frame.up.xyz * b);
}

fn is_sea() -> bool {
    return frame.flags.x == 1u;
}

fn is_block() -> bool {
    return frame.flags.y == 1u;
}

// 0 at or below `lo`, 1 at or above `hi`; falls instead if `lo > hi`, which WGSL's own does not promise.
fn soft(lo: f32, hi: f32, x: f32) -> f32 {
    let t = clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

