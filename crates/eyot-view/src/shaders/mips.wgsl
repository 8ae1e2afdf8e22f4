// The next smaller picture of a map: means over two by two texels.

@group(0) @binding(0) var fine: texture_2d<f32>;
@group(0) @binding(1) var coarse: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(16, 16)
fn make_mip(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarse)) {
        return;
    }
    let last = vec2i(textureDimensions(fine)) - 1;
    let at = 2 * vec2i(id.xy);
    let sum = textureLoad(fine, min(at, last), 0)
        + textureLoad(fine, min(at + vec2i(1, 0), last), 0)
        + textureLoad(fine, min(at + vec2i(0, 1), last), 0)
        + textureLoad(fine, min(at + vec2i(1, 1), last), 0);
    textureStore(coarse, vec2i(id.xy), 0.25 * sum);
}
