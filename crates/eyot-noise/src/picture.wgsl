// Gradient noise; the same as in `picture.rs` beside this file.

fn hash(x: i32, y: i32, seed: u32) -> u32 {
    var h = (bitcast<u32>(x) * 0x8da6b343u) ^ (bitcast<u32>(y) * 0xd8163841u) ^ (seed * 0xcb1ab31fu);
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12u)) * 0x297a2d39u;
    return h ^ (h >> 15u);
}

// Sixteen unit directions that avoid the axes.
fn gradient(x: i32, y: i32, seed: u32) -> vec2f {
    let h = hash(x, y, seed) & 15u;
    let ray = h >> 2u;
    let g = select(
        select(vec2f(0.9807853, 0.19509032), vec2f(0.8314696, 0.55557024), ray == 1u),
        select(vec2f(0.55557024, 0.8314696), vec2f(0.19509032, 0.9807853), ray == 3u),
        ray >= 2u,
    );
    let turn = h & 3u;
    return select(select(g, vec2f(-g.y, g.x), turn == 1u), select(-g, vec2f(g.y, -g.x), turn == 3u), turn >= 2u);
}

// Value in about -1..1, then its two derivatives.
fn noise_with_slope(p: vec2f, seed: u32) -> vec3f {
    let base = floor(p);
    let i = vec2i(base);
    let t = p - base;
    let ga = gradient(i.x, i.y, seed);
    let gb = gradient(i.x + 1, i.y, seed);
    let gc = gradient(i.x, i.y + 1, seed);
    let gd = gradient(i.x + 1, i.y + 1, seed);
    let a = dot(ga, t);
    let b = dot(gb, t - vec2f(1.0, 0.0));
    let c = dot(gc, t - vec2f(0.0, 1.0));
    let d = dot(gd, t - vec2f(1.0, 1.0));
    let s = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let ds = 30.0 * t * t * (t - 1.0) * (t - 1.0);
    let k = a - b - c + d;
    let value = a + s.x * (b - a) + s.y * (c - a) + s.x * s.y * k;
    let corner = ga + s.x * (gb - ga) + s.y * (gc - ga) + s.x * s.y * (ga - gb - gc + gd);
    let slope = corner + ds * (vec2f(b - a, c - a) + s.yx * k);
    return 1.4 * vec3f(value, slope);
}

fn noise(p: vec2f, seed: u32) -> f32 {
    return noise_with_slope(p, seed).x;
}

// Octaves, each turned against the last by an angle that no lattice repeats.
fn fbm(place: vec2f, octaves: u32, seed: u32) -> f32 {
    var p = place;
    var sum = 0.0;
    var amplitude = 0.5;
    for (var i = 0u; i < octaves; i++) {
        sum += amplitude * noise(p, seed + i);
        amplitude *= 0.5;
        p = vec2f(1.621 * p.x - 1.222 * p.y + 17.3, 1.222 * p.x + 1.621 * p.y - 9.1);
    }
    return sum;
}
