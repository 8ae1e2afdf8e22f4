// Cells of a scene from layers where they lie on the card: heights as drawn and depths of fresh water, the same as `Stage` in
// eyot-render, `stage.rs`; the colours of a layer; and the lowest and highest height of each patch.

struct Job {
    // Columns and rows of the scene's cells, cells of the world along a side of one of them, 1 if there is fresh water.
    cells: vec4u,
    // Columns and rows of the world's cells, first row of the world in this part, first row of the scene that is made of it.
    world: vec4u,
    // Where column 0 of the part's first row lies in each buffer (heights, water, colours), rows of the scene that are made.
    places: vec4u,
    // Distance of two rows in each buffer, words of a row of colours.
    strides: vec4u,
    // Level of the sea, or of the world's zero without one; factor on heights; depths between which a river comes into sight.
    scale: vec4f,
    // Values at the begin, in the middle and at the end of the colours; 0 evenly between the ends, 1 with a middle, 2 by the logarithm.
    colour: vec4f,
    // Columns and rows of patches of the finest level, quads along a side of one, nodes a cell.
    patches: vec4u,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read> heights: array<f32>;
@group(0) @binding(2) var<storage, read> waters: array<f32>;
@group(0) @binding(3) var tops: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var fresh: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var<storage, read> worn: array<f32>;
@group(0) @binding(6) var<storage, read> table: array<u32>;
@group(0) @binding(7) var<storage, read_write> colours: array<u32>;
@group(0) @binding(8) var made_tops: texture_2d<f32>;
@group(0) @binding(9) var<storage, read_write> spans: array<vec2f>;

// First column and row of the world in a cell of the scene, and those after the last.
fn square(id: vec2u) -> vec4u {
    let low = id * job.cells.z;
    return vec4u(low, min(low + job.cells.z, job.world.xy));
}

fn place(layer: u32, x: u32, y: u32) -> u32 {
    return job.places[layer] + (y - job.world.z) * job.strides[layer] + x;
}

@compute @workgroup_size(16, 16)
fn make_cells(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= job.cells.x || id.y >= job.places.w {
        return;
    }
    let to = vec2u(id.x, job.world.w + id.y);
    let area = square(to);
    var z = 0.0;
    var depth = 0.0;
    for (var y = area.y; y < area.w; y++) {
        for (var x = area.x; x < area.z; x++) {
            z += heights[place(0u, x, y)];
            if job.cells.w == 1u {
                depth += waters[place(1u, x, y)];
            }
        }
    }
    let count = f32((area.z - area.x) * (area.w - area.y));
    z = z / count - job.scale.x;
    if job.cells.w == 1u {
        depth = max(depth / count, 0.0);
        let t = clamp((depth - job.scale.z) / (job.scale.w - job.scale.z), 0.0, 1.0);
        // The water's surface, but not the film that rain leaves everywhere.
        z += depth * (t * t * (3.0 - 2.0 * t));
        textureStore(fresh, to, vec4f(depth, 0.0, 0.0, 0.0));
    }
    textureStore(tops, to, vec4f(z * job.scale.y, 0.0, 0.0, 0.0));
}

fn share(v: f32, a: f32, b: f32) -> f32 {
    if b > a {
        return clamp((v - a) / (b - a), 0.0, 1.0);
    }
    return 0.0;
}

// Place of a value along the colours, 0..1.
fn along(v: f32) -> f32 {
    let c = job.colour;
    if c.w == 2.0 {
        return share(log(max(v, c.x)), log(c.x), log(c.z));
    }
    if c.w == 0.0 {
        return share(v, c.x, c.z);
    }
    if v < c.y {
        return 0.4999 * share(v, c.x, c.y);
    }
    return 0.5 + 0.5 * share(v, c.y, c.z);
}

@compute @workgroup_size(16, 16)
fn make_colours(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= job.cells.x || id.y >= job.places.w {
        return;
    }
    let to = vec2u(id.x, job.world.w + id.y);
    let area = square(to);
    var v = 0.0;
    for (var y = area.y; y < area.w; y++) {
        for (var x = area.x; x < area.z; x++) {
            v += worn[place(2u, x, y)];
        }
    }
    v /= f32((area.z - area.x) * (area.w - area.y));
    let last = arrayLength(&table) - 1u;
    colours[to.y * job.strides.w + to.x] = table[min(u32(along(v) * f32(last) + 0.5), last)];
}

@compute @workgroup_size(64)
fn make_spans(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if i >= job.patches.x * job.patches.y {
        return;
    }
    // A node depends on the cells around it, two to each side; a vertex of the next level on one node more.
    let at = vec2u(i % job.patches.x, i / job.patches.x);
    let begin = at * job.patches.z / job.patches.w;
    let low = min(begin - min(begin, vec2u(3u)), job.cells.xy - 1u);
    let high = min((at + 1u) * job.patches.z / job.patches.w + 4u, job.cells.xy);
    var span = vec2f(textureLoad(made_tops, low, 0).x);
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            let z = textureLoad(made_tops, vec2u(x, y), 0).x;
            span = vec2f(min(span.x, z), max(span.y, z));
        }
    }
    spans[i] = span;
}
