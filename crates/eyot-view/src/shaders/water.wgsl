// Colour and waves of water; the same as in eyot-render, `water.rs`, but the waves move.

// Share of light that a water surface reflects (Schlick).
fn fresnel(cosine: f32) -> f32 {
    let c = clamp(1.0 - cosine, 0.0, 1.0);
    return 0.02 + 0.98 * c * c * c * c * c;
}

// Cosine of the refracted direction under water.
fn refracted(cosine: f32) -> f32 {
    return sqrt(1.0 - max(1.0 - cosine * cosine, 0.0) / (1.333 * 1.333));
}

// Light that comes up through the surface, as an albedo: `floor_colour` below `depth` m, light and view going `path` times that.
fn upwelling(floor_colour: vec3f, depth: f32, path: f32, absorb: vec3f, deep: vec3f, build: vec3f) -> vec3f {
    let d = max(depth, 0.0);
    return floor_colour * exp(-absorb * d * path) + deep * (1.0 - exp(-build * d * path * 0.5));
}

// Length relative to the unit, slope, and the turn of the lattice as cosine and sine; crests lie across the wind.
const TRAINS = array<vec4f, 5>(
    vec4f(1.0, 0.030, 0.921, 0.391),
    vec4f(0.41, 0.042, 0.731, 0.682),
    vec4f(0.173, 0.052, 0.990, -0.139),
    vec4f(0.071, 0.058, 0.559, 0.829),
    vec4f(0.029, 0.060, 0.857, 0.515),
);

// Slopes of small waves `time` s after the start, and the roughness of those that are too small to see. Each train travels as
// waves of its length do on deep water: c = sqrt(g length / 2 pi).
fn waves(p: vec2f, unit_m: f32, footprint: f32, time: f32) -> vec3f {
    var trains = TRAINS;
    var sum = vec3f(0.0);
    for (var i = 0u; i < 5u; i++) {
        let train = trains[i];
        let length = train.x * unit_m;
        let keep = soft(3.2, 1.1, footprint * 2.0 / length);
        sum.z += train.y * (1.0 - keep);
        if keep <= 0.0 {
            continue;
        }
        let c = train.z;
        let s = train.w;
        let travelled = sqrt(9.81 * length / (2.0 * PI)) * time;
        // Crests are longer than wide.
        let lattice = vec2f((c * p.x + s * p.y - travelled) / length, (c * p.y - s * p.x) / (1.8 * length));
        let slope = noise_with_slope(lattice, 900u + i).yz;
        let k = train.y * keep * 0.55;
        sum.x += k * (c * slope.x - s * slope.y / 1.8);
        sum.y += k * (s * slope.x + c * slope.y / 1.8);
    }
    return sum;
}
