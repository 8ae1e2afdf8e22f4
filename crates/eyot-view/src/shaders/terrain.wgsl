// The ground: a quadtree of patches whose vertices morph into the next coarser level before it takes over, so that neither cracks
// nor jumps show (Strugar 2009, continuous distance-dependent level of detail).

struct GroundVertex {
    @builtin(position) @invariant position: vec4f,
    @location(0) place: vec3f,
}

// Quads along a side of a patch; as in `detail.rs`.
const PATCH: u32 = 32u;

fn node_of(level: u32, index: vec2u) -> vec2f {
    return vec2f(min(index << vec2u(level), frame.nodes.xy - 1u));
}

fn height_of(level: u32, index: vec2u) -> f32 {
    return textureLoad(heights, vec2i(frame.levels[level].xy + index), 0).x;
}

// A vertex of a patch in m. Distances are level ones, and the camera's height is the same for all, so that both sides of a seam
// agree on how far a vertex has morphed.
fn ground_vertex(level: u32, first: vec2u, corner: vec2u) -> vec3f {
    let last = frame.levels[level].zw;
    let index = min(first + corner, last);
    let node = node_of(level, index);
    var place = vec3f(node * frame.size.zw, height_of(level, index));
    if level < frame.nodes.z {
        let above = frame.levels[level + 1u].zw;
        // The rim stays the rim.
        let parent = select(index >> vec2u(1u), above, index == last);
        let way = place.xy - frame.eye.xy;
        let distance = sqrt(dot(way, way) + frame.detail.z);
        let end = frame.detail.x * f32(1u << level);
        let morph = clamp((distance / end - frame.detail.y) / (1.0 - frame.detail.y), 0.0, 1.0);
        let coarse = vec3f(node_of(level + 1u, parent) * frame.size.zw, height_of(level + 1u, parent));
        place = mix(place, coarse, morph);
    }
    // Ground at the very level of the sea would flicker with it.
    if is_sea() && place.z <= 0.0 {
        place.z -= 2e-5 * frame.scale.x;
    }
    return place;
}

@vertex
fn terrain_vertex(@builtin(vertex_index) vertex: u32, @location(0) patch_place: vec4u) -> GroundVertex {
    let corner = vec2u(vertex % (PATCH + 1u), vertex / (PATCH + 1u));
    let place = ground_vertex(patch_place.z, patch_place.xy, corner);
    return GroundVertex(projected(vec4f(place, 1.0)), place);
}

@fragment
fn terrain_fragment(in: GroundVertex) -> @location(0) vec4f {
    let uv = map_place(in.place.xy);
    let node = node_at(uv, dpdx(uv), dpdy(uv));
    let way = in.place - frame.eye.xyz;
    let distance = length(way);
    let d = way / distance;
    if frame.detail.w == 1.0 {
        return developed(painted(node), in.position.xy, true);
    }
    let c = land(in.place, node, d, pixel_on_ground(in.place.xy, frame.picture.z * distance), uv);
    return developed(through_air(c, d, distance), in.position.xy, false);
}

// Colours of a layer under soft light: level ground in full light keeps the legend's colour.
fn painted(node: Node) -> vec3f {
    let normal = normalize(vec3f(-node.rise, 1.0));
    let light = dot(irradiance(normal, 0.4 + 0.6 * node.sun, node.open), vec3f(0.3, 0.5, 0.2));
    let level = dot(irradiance(vec3f(0.0, 0.0, 1.0), 1.0, 1.0), vec3f(0.3, 0.5, 0.2));
    return node.albedo * mix(1.0, light / level, 0.7);
}

// What a pixel covers: seen at a grazing angle it is much longer on the ground than wide.
struct Pixel {
    // The way from its near to its far end, m.
    long: vec2f,
    // Samples along that way.
    taps: f32,
    // Size of what a sample must not show, m.
    footprint: f32,
}

// A pixel around `p` that is `across` m wide.
fn pixel_on_ground(p: vec2f, across: f32) -> Pixel {
    let a = dpdx(p);
    let b = dpdy(p);
    let long = select(a, b, dot(b, b) > dot(a, a));
    let way = length(long);
    let taps = clamp(ceil(way / max(across, 1e-6) - 0.5), 1.0, 8.0);
    return Pixel(long, taps, max(across, way / taps));
}

// A sample's place.
fn tap_of(p: vec2f, pixel: Pixel, tap: f32) -> vec2f {
    return p + pixel.long * ((tap + 0.5) / pixel.taps - 0.5);
}

// Light that the ground sends along `-d`.
fn land(p: vec3f, node: Node, d: vec3f, pixel: Pixel, uv: vec2f) -> vec3f {
    var rise = node.rise;
    var colour = node.albedo;
    // Crowns of trees and broken stone, below the size of cells: bumps as large as a pixel shows.
    let sum = colour.r + colour.g + colour.b + 1e-6;
    let green = soft(0.02, 0.16, (colour.g - colour.r) / sum);
    let pale = soft(0.55, 1.2, sum);
    let rough = (0.42 + 0.50 * green) * (1.0 - 0.92 * pale);
    var size = 5.3 * frame.scale.x / 512.0;
    for (var k = 0u; k < 6u; k++) {
        let keep = soft(0.85, 0.30, pixel.footprint / size) * rough;
        if keep <= 0.0 {
            break;
        }
        var n = vec3f(0.0);
        for (var tap = 0.0; tap < pixel.taps; tap += 1.0) {
            let at = tap_of(p.xy, pixel, tap);
            let q = vec2f(0.83 * at.x + 0.56 * at.y, 0.83 * at.y - 0.56 * at.x);
            n += noise_with_slope(q / size, 300u + k);
        }
        n /= pixel.taps;
        // Longer bumps would be hills that are not there.
        let s = 0.24 * keep * soft(150.0, 50.0, size);
        rise += s * vec2f(0.83 * n.y - 0.56 * n.z, 0.56 * n.y + 0.83 * n.z);
        colour *= 1.0 + (0.44 - 0.20 * green) * keep * n.x;
        size *= 0.47;
    }
    let normal = normalize(vec3f(-rise, 1.0));
    var c = colour * irradiance(normal, node.sun, node.open);
    // Leaves and dust send light back the way it came and let it through at the rim.
    let rim = clamp(1.0 + dot(d, normal), 0.0, 1.0);
    c *= 1.0 + 0.25 * rim * rim * green;
    let cover = river_cover(node.fresh);
    if cover > 0.0 {
        c = mix(c, river(p, node, d, pixel, uv), cover);
    }
    return c;
}

// Light of fresh water: the mean of the samples, since a wave that glitters is far brighter than its slope on average.
fn river(p: vec3f, node: Node, d: vec3f, pixel: Pixel, uv: vec2f) -> vec3f {
    var sum = vec3f(0.0);
    for (var tap = 0.0; tap < pixel.taps; tap += 1.0) {
        sum += river_at(tap_of(p.xy, pixel, tap), node, d, pixel.footprint, uv);
    }
    return sum / pixel.taps;
}

fn river_at(p: vec2f, node: Node, d: vec3f, footprint: f32, uv: vec2f) -> vec3f {
    let wave = river_waves(p, footprint, uv);
    let normal = normalize(vec3f(-node.rise - wave, 1.0));
    let cosine = -dot(d, normal);
    let light = irradiance(normal, node.sun, node.open);
    let path = 1.2 + 1.0 / refracted(clamp(cosine, 0.0, 1.0));
    let body = upwelling(
        node.albedo, node.fresh, path, frame.fresh_absorb.rgb, frame.fresh_deep.rgb, frame.fresh_build.rgb,
    ) * light;
    let reflected = d + normal * (2.0 * cosine);
    let f = fresnel(max(cosine, 0.12));
    return body * (1.0 - f) + clear_air(reflected) * f * node.open;
}

// Waves of a pond as a share of those of a sheltered sea; as in eyot-render, `scene.rs`.
const CALM: f32 = 0.4;

// Slopes of waves that the flow carries along: two copies, each carried for one period and then begun again while the other shows
// (Vlachos 2010, water flow in Portal 2). Where nothing flows they are low and travel with the wind; quick water is rough, so that
// the eye can follow it.
fn river_waves(p: vec2f, footprint: f32, uv: vec2f) -> vec2f {
    let unit_m = frame.scale.x / 260.0;
    let time = frame.eye.w;
    if frame.block.w == 0.0 {
        return CALM * waves(p, unit_m, footprint, time).xy;
    }
    let flow = textureSampleLevel(flow_map, smooth_sampler, uv, 0.0).xy;
    let speed = length(flow);
    let period = 2.0;
    // Carried by up to a length of the longest waves in a period.
    let carry = flow * unit_m;
    let a = fract(time / period + 0.5);
    let b = fract(time / period);
    let first = waves(p - carry * (a - 0.5), unit_m, footprint, 0.0).xy;
    let second = waves(p - carry * (b - 0.5), unit_m, footprint, 0.0).xy;
    let carried = (CALM + 2.6 * speed) * mix(first, second, abs(2.0 * a - 1.0));
    return mix(CALM * waves(p, unit_m, footprint, time).xy, carried, soft(0.02, 0.15, speed));
}
