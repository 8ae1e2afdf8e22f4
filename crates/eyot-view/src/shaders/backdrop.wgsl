// What stands behind everything: sky, or the studio of a relief model.

@vertex
fn backdrop_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}

@fragment
fn backdrop_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let d = view_ray(position.xy);
    if is_block() {
        return developed(studio(d), position.xy, false);
    }
    return developed(sky(d), position.xy, false);
}
