// The maps that pictures read, made from cells: a smooth surface on nodes, its coarser levels, slopes, colours, and the light that
// does not depend on the camera. The same as in eyot-render, `surface.rs` and `light.rs`.

struct Job {
    // Columns and rows of cells, nodes a cell, 1 if there is fresh water.
    cells: vec4u,
    // Columns and rows of nodes, level that the light is read from, nodes a texel of the light map.
    nodes: vec4u,
    // Columns and rows of the light map.
    light: vec4u,
    // Distance of neighbours in m, level below which nothing lies, top of the surface.
    size: vec4f,
    // Direction to the sun in nodes per metre, tangents of the penumbra's two edges.
    sun: vec4f,
    levels: array<vec4u, 16>,
}

struct Turn {
    level: vec4u,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<uniform> turn: Turn;
@group(0) @binding(2) var cells_top: texture_2d<f32>;
@group(0) @binding(3) var cells_fresh: texture_2d<f32>;
@group(0) @binding(4) var cells_ground: texture_2d<f32>;
@group(0) @binding(5) var heights: texture_storage_2d<r32float, read_write>;
@group(0) @binding(6) var ground_map: texture_storage_2d<rgba16float, write>;
@group(0) @binding(7) var relief_map: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var light_map: texture_storage_2d<rgba16float, write>;

// The cubic B-spline.
fn b_spline(t: f32) -> vec4f {
    let s = 1.0 - t;
    return vec4f(s * s * s, 4.0 - 6.0 * t * t + 3.0 * t * t * t, 4.0 - 6.0 * s * s + 3.0 * s * s * s, t * t * t) / 6.0;
}

fn mitchell_near(x: f32) -> f32 {
    return (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0;
}

fn mitchell_far(x: f32) -> f32 {
    return (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0;
}

// Mitchell and Netravali's cubic (1/3, 1/3).
fn mitchell(t: f32) -> vec4f {
    return vec4f(mitchell_far(1.0 + t), mitchell_near(t), mitchell_near(1.0 - t), mitchell_far(2.0 - t));
}

fn cell(i: vec2i) -> vec2i {
    return clamp(i, vec2i(0), vec2i(job.cells.xy) - 1);
}

fn between(node: vec2u) -> vec2f {
    return vec2f(node % job.cells.z) / f32(job.cells.z);
}

@compute @workgroup_size(16, 16)
fn make_heights(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= job.nodes.xy) {
        return;
    }
    let base = vec2i(id.xy / job.cells.z) - 1;
    let t = between(id.xy);
    var kx = b_spline(t.x);
    var ky = b_spline(t.y);
    var sum = 0.0;
    for (var j = 0; j < 4; j++) {
        var row = 0.0;
        for (var i = 0; i < 4; i++) {
            row += kx[i] * textureLoad(cells_top, cell(base + vec2i(i, j)), 0).x;
        }
        sum += ky[j] * row;
    }
    textureStore(heights, vec2i(id.xy), vec4f(sum, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(16, 16)
fn make_ground(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= job.nodes.xy) {
        return;
    }
    let base = vec2i(id.xy / job.cells.z) - 1;
    let t = between(id.xy);
    var kx = b_spline(t.x);
    var ky = b_spline(t.y);
    var sum = vec4f(0.0);
    for (var j = 0; j < 4; j++) {
        var row = vec4f(0.0);
        for (var i = 0; i < 4; i++) {
            row += kx[i] * textureLoad(cells_ground, cell(base + vec2i(i, j)), 0);
        }
        sum += ky[j] * row;
    }
    textureStore(ground_map, vec2i(id.xy), sum);
}

@compute @workgroup_size(16, 16)
fn make_relief(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= job.nodes.xy) {
        return;
    }
    let at = vec2i(id.xy);
    let low = max(at - 1, vec2i(0));
    let high = min(at + 1, vec2i(job.nodes.xy) - 1);
    let rise = vec2f(
        textureLoad(heights, vec2i(high.x, at.y)).x - textureLoad(heights, vec2i(low.x, at.y)).x,
        textureLoad(heights, vec2i(at.x, high.y)).x - textureLoad(heights, vec2i(at.x, low.y)).x,
    ) / (vec2f(high - low) * job.size.xy);
    var fresh = 0.0;
    if job.cells.w == 1u {
        let base = vec2i(id.xy / job.cells.z) - 1;
        let t = between(id.xy);
        var kx = mitchell(t.x);
        var ky = mitchell(t.y);
        for (var j = 0; j < 4; j++) {
            for (var i = 0; i < 4; i++) {
                fresh += ky[j] * kx[i] * textureLoad(cells_fresh, cell(base + vec2i(i, j)), 0).x;
            }
        }
    }
    textureStore(relief_map, at, vec4f(rise, max(fresh, 0.0), 0.0));
}

// A level of the surface from the next finer one, by the weights 1 2 1. Along the rim only along the rim, so that it keeps its place.
@compute @workgroup_size(16, 16)
fn make_level(@builtin(global_invocation_id) id: vec3u) {
    let to = job.levels[turn.level.x];
    let from_level = job.levels[turn.level.x - 1u];
    if any(id.xy > to.zw) {
        return;
    }
    let last = vec2i(from_level.zw);
    let at = min(2 * vec2i(id.xy), last);
    let reach = select(vec2i(1), vec2i(0), (at == vec2i(0)) | (at == last));
    var sum = 0.0;
    for (var j = -1; j <= 1; j++) {
        for (var i = -1; i <= 1; i++) {
            let weight = f32((2 - abs(i)) * (2 - abs(j)));
            let place = at + vec2i(i, j) * reach;
            sum += weight * textureLoad(heights, vec2i(from_level.xy) + place).x;
        }
    }
    textureStore(heights, vec2i(to.xy + id.xy), vec4f(sum / 16.0, 0.0, 0.0, 0.0));
}

// Height between nodes of the level that light is read from, `place` in its own nodes.
fn level_height(place: vec2f) -> f32 {
    let level = job.levels[job.nodes.z];
    let last = vec2f(level.zw);
    let p = clamp(place, vec2f(0.0), last);
    let base = min(vec2i(p), vec2i(level.zw) - 1);
    let t = p - vec2f(base);
    let corner = vec2i(level.xy) + base;
    let a = textureLoad(heights, corner).x;
    let b = textureLoad(heights, corner + vec2i(1, 0)).x;
    let c = textureLoad(heights, corner + vec2i(0, 1)).x;
    let d = textureLoad(heights, corner + vec2i(1, 1)).x;
    return mix(mix(a, b, t.x), mix(c, d, t.x), t.y);
}

// How far the sun's disc stands above the horizon of a place, 0..1 from its low to its high edge.
fn above_horizon(start: vec2f, z: f32) -> f32 {
    let scale = f32(1u << job.nodes.z);
    let along = job.sun.xy / scale;
    let step = 1.0 / max(abs(along.x), abs(along.y));
    let last = vec2f(job.levels[job.nodes.z].zw);
    let from_place = start / scale;
    var horizon = job.sun.z;
    var way = 1.5 * step;
    loop {
        let place = from_place + along * way;
        if z + horizon * way > job.size.w || any(place < vec2f(0.0)) || any(place >= last) {
            break;
        }
        horizon = max(horizon, (level_height(place) - z) / way);
        if horizon >= job.sun.w {
            return 0.0;
        }
        // Far away a node covers less of the penumbra.
        way += step * (1.0 + 0.01 * way / step);
    }
    return (job.sun.w - horizon) / (job.sun.w - job.sun.z);
}

// Open share of the sky: cosine weighted, from the horizons in twelve directions.
fn open_sky(start: vec2f, z: f32) -> f32 {
    var reach = array<f32, 9>(1.0, 2.0, 3.2, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0);
    let scale = f32(1u << job.nodes.z);
    let texel = f32(max(job.nodes.x, job.nodes.y)) / 400.0;
    let last = vec2f(job.levels[job.nodes.z].zw);
    var sum = 0.0;
    for (var k = 0u; k < 12u; k++) {
        let angle = (f32(k) + 0.3) * 6.2831853 / 12.0;
        let direction = vec2f(sin(angle), cos(angle));
        var tangent = 0.0;
        for (var l = 0u; l < 9u; l++) {
            let offset = direction * reach[l] * max(texel, 1.0);
            let place = (start + offset) / scale;
            if any(place < vec2f(0.0)) || any(place > last) {
                break;
            }
            let height = max(level_height(place), job.size.z);
            tangent = max(tangent, (height - z) / length(offset * job.size.xy));
        }
        sum += 1.0 / (1.0 + tangent * tangent);
    }
    return sum / 12.0;
}

@compute @workgroup_size(16, 16)
fn make_light(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= job.light.xy) {
        return;
    }
    let start = min(vec2f(id.xy * job.nodes.w), vec2f(job.nodes.xy) - 1.0);
    let scale = f32(1u << job.nodes.z);
    // What lies below the sea is lit at its surface.
    let z = max(level_height(start / scale), job.size.z);
    textureStore(light_map, vec2i(id.xy), vec4f(above_horizon(start, z), open_sky(start, z), 0.0, 0.0));
}
