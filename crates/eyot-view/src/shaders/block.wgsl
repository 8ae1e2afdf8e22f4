// The relief model: cut sides, the ground that it stands on and the backdrop; the same as in eyot-render, `block.rs`.

struct WallVertex {
    @builtin(position) @invariant position: vec4f,
    @location(0) place: vec3f,
    @location(1) ground: f32,
    @location(2) @interpolate(flat) side: u32,
}

// A strip below the rim of a patch: the same vertices as the patch, and below each the base. `w` names the side: west, east,
// north, south.
@vertex
fn wall_vertex(@builtin(vertex_index) vertex: u32, @location(0) patch_place: vec4u) -> WallVertex {
    let side = patch_place.w;
    let along = vertex >> 1u;
    let far = select(0u, PATCH, (side & 1u) == 1u);
    let corner = select(vec2u(along, far), vec2u(far, along), side < 2u);
    let top = ground_vertex(patch_place.z, patch_place.xy, corner);
    let high = select(top.z, max(top.z, 0.0), is_sea());
    let place = vec3f(top.xy, select(high, frame.block.x, (vertex & 1u) == 1u));
    return WallVertex(projected(vec4f(place, 1.0)), place, top.z, side);
}

@fragment
fn wall_fragment(in: WallVertex) -> @location(0) vec4f {
    let p = in.place;
    let d = normalize(p - frame.eye.xyz);
    let out = select(-1.0, 1.0, (in.side & 1u) == 1u);
    let normal = select(vec3f(0.0, out, 0.0), vec3f(out, 0.0, 0.0), in.side < 2u);
    let facing = max(dot(normal, frame.sun.xyz), 0.0);
    // The ground below sends light up; the foot of the wall sees less of everything.
    let up = (p.z - frame.block.x) / max(in.ground - frame.block.x, 1e-6);
    let ambient = 0.55 * frame.skylight.rgb + 0.07 * frame.sunlight.rgb;
    let light = 0.92 * facing * frame.sunlight.rgb + ambient * (0.62 + 0.38 * soft(0.0, 0.4, up));
    if p.z > in.ground {
        return developed(water_wall(p, d, in.ground, normal, light), in.position.xy, false);
    }
    return developed(strata(p, in.ground) * light, in.position.xy, false);
}

fn bed(i: f32) -> vec3f {
    return frame.beds[hash(i32(i), 7, 19u) % 5u].rgb;
}

// Beds that lie nearly level, so that valleys cut through them, with soil on top.
fn strata(p: vec3f, ground: f32) -> vec3f {
    let along = (p.x + 1.37 * p.y) / frame.scale.x;
    let thick = frame.block.y - frame.block.x;
    let below = ground - p.z;
    let bent = p.z + 0.05 * thick * fbm(vec2f(5.0 * along, 0.2), 3u, 5u);
    let t = 11.0 * bent / thick + 0.4 * noise(vec2f(9.0 * along, 3.1), 8u);
    let i = floor(t);
    var c = mix(bed(i), bed(i + 1.0), soft(0.80, 1.0, t - i));
    let grain = fbm(vec2f(160.0 * along, 40.0 * bent / thick), 3u, 9u);
    c *= 1.0 + 0.16 * grain + 0.10 * noise(vec2f(3.0 * along, 60.0 * bent / thick), 12u);
    let soil = (0.011 + 0.005 * fbm(vec2f(20.0 * along, 1.0), 2u, 14u)) * frame.scale.x;
    let dry = select(0.0, 1.0, ground > 0.0 || !is_sea());
    return mix(c, frame.soil.rgb, 0.85 * soft(soil, 0.45 * soil, below) * dry);
}

// A cut through the sea: a pane of water, paler above and dark below.
fn water_wall(p: vec3f, d: vec3f, ground: f32, normal: vec3f, light: vec3f) -> vec3f {
    let depth = -p.z / frame.scale.z;
    let deep = max(
        soft(0.0, 1.0, min(depth / (3.0 * frame.scale.y), 1.0)),
        0.35 * soft(0.0, 1.0, p.z / min(ground, -1e-6)),
    );
    let pane = mix(frame.pane.rgb, frame.deep_pane.rgb, deep) * light * 0.8;
    let f = fresnel(max(-dot(d, normal), 0.1));
    return pane * (1.0 - f) + 0.6 * f * frame.studio.rgb;
}

// Ground and backdrop of the studio.
fn studio(d: vec3f) -> vec3f {
    let backdrop = 0.94 * frame.studio.rgb;
    if d.z > -1e-4 {
        return backdrop;
    }
    let way = (frame.block.x - frame.eye.z) / d.z;
    let p = frame.eye.xy + d.xy * way;
    let off = length(max(max(-p, p - frame.size.xy), vec2f(0.0)));
    // The block hides part of the sky close to it.
    let tall = 0.55 * (frame.block.y - frame.block.x);
    let contact = 0.50 * exp(-off / (0.25 * tall)) + 0.22 * exp(-off / tall);
    let lit = mix(1.02 * frame.studio.rgb, 0.40 * frame.studio.rgb, 0.85 * block_shadow(p));
    return mix(lit * (1.0 - 0.75 * contact), backdrop, soft(1.2, 3.2, off / frame.scale.x));
}

// Shadow of the block at a point of the ground.
fn block_shadow(p: vec2f) -> f32 {
    let flat = max(length(frame.sun.xy), 1e-6);
    let towards = frame.sun.xy / flat;
    let tangent = frame.sun.z / flat;
    var from_way = 0.0;
    var to_way = (frame.block.y - frame.block.x) / max(tangent, 0.02) * 1.3;
    for (var axis = 0u; axis < 2u; axis++) {
        let a = -p[axis] / towards[axis];
        let b = (frame.size[axis] - p[axis]) / towards[axis];
        if abs(towards[axis]) < 1e-6 {
            if p[axis] < 0.0 || p[axis] > frame.size[axis] {
                return 0.0;
            }
            continue;
        }
        from_way = max(from_way, min(a, b));
        to_way = min(to_way, max(a, b));
    }
    if from_way >= to_way {
        return 0.0;
    }
    var horizon = 0.0;
    for (var i = 0u; i < 40u; i++) {
        // Denser at the near end, where the walls stand.
        let f = f32(i) / 39.0;
        let way = from_way + (to_way - from_way) * f * f;
        let height = height_at(p + towards * way) - frame.block.x;
        horizon = max(horizon, height / max(way, 1e-3 * frame.scale.x));
    }
    return soft(0.80 * tangent, 1.20 * tangent, horizon);
}
