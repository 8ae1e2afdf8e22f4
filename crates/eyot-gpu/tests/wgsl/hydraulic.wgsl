// hydraulic_eight_flux: tiles of 32 x 16 cells.

struct Job {
    width: i32,
    height: i32,
    left: i32,
    top: i32,
    first_row: i32,
    end_row: i32,
    stride: i32,
    slots: i32,
    first_group: i32,
    groups: i32,
    from_height: i32,
    from_water: i32,
    from_sediment: i32,
    from_flux_x: i32,
    from_flux_y: i32,
    from_flux_se: i32,
    from_flux_sw: i32,
    to_raw_x: i32,
    to_raw_y: i32,
    to_raw_se: i32,
    to_raw_sw: i32,
    to_afford: i32,
    to_afford_sediment: i32,
    push_x_0: f32,
    push_y_0: f32,
    push_d_0: f32,
    keep_0: f32,
    dt_0: f32,
    sea_0: f32,
    first_x_0: f32,
    last_x_0: f32,
    first_y_0: f32,
    last_y_0: f32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let left = i32(group.x) * 32 + job.left;
    let top = i32(group.y) * 16 + job.top;

    // Rule `hydraulic_eight_flux`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.end_row {
            continue;
        }
        let x = cx;
        let y = cy;
        let x_0 = max(cx, 0);
        let x_0_face = cx;
        let x_0_inside = cx >= 0;
        let x_m1 = max(cx - 1, 0);
        let x_m1_face = max(cx - 1, -1);
        let x_m1_face_inside = cx - 1 >= -1;
        let x_m1_inside = cx - 1 >= 0;
        let x_p1 = min(cx + 1, job.width - 1);
        let x_p1_inside = cx + 1 < job.width;
        let y_0 = max(cy, 0);
        let y_0_face = cy;
        let y_0_inside = cy >= 0;
        let y_m1 = max(cy - 1, 0);
        let y_m1_face = max(cy - 1, -1);
        let y_m1_face_inside = cy - 1 >= -1;
        let y_m1_inside = cy - 1 >= 0;
        let y_p1 = min(cy + 1, job.height - 1);
        let y_p1_inside = cy + 1 < job.height;
        let n14 = select(0.0f, 1.0f, job.first_x_0 < f32(x));
        let n15 = select(0.0f, 1.0f, f32(x) < job.last_x_0);
        let n16 = select(0.0f, 1.0f, job.first_y_0 < f32(y));
        let n17 = select(0.0f, 1.0f, f32(y) < job.last_y_0);
        let push_x = job.push_x_0 - (job.push_d_0 * (n16 + n17)); // (1)
        let push_y = job.push_y_0 - (job.push_d_0 * (n14 + n15)); // (1)
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = select(job.sea_0, height, job.sea_0 < height) + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n33 = select(job.sea_0, height_e, job.sea_0 < height_e) + water_e;
        let east = (job.keep_0 * flux_x) + (push_x * (head - n33)); // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n42 = select(job.sea_0, height_w, job.sea_0 < height_w) + water_w;
        let west = (job.keep_0 * flux_x_w) + (push_x * (n42 - head)); // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n51 = select(job.sea_0, height_s, job.sea_0 < height_s) + water_s;
        let south = (job.keep_0 * flux_y) + (push_y * (head - n51)); // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n60 = select(job.sea_0, height_n, job.sea_0 < height_n) + water_n;
        let north = (job.keep_0 * flux_y_n) + (push_y * (n60 - head)); // (1)
        let flux_se = select(0.0, state[address(job.from_flux_se, x_0, y_0)], x_0_inside && y_0_inside);
        let height_se = state[address(job.from_height, x_p1, y_p1)];
        let water_se = select(0.0, state[address(job.from_water, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let n70 = select(job.sea_0, height_se, job.sea_0 < height_se) + water_se;
        let se = (n17 * n15) * ((job.keep_0 * flux_se) + (job.push_d_0 * (head - n70))); // (1)
        let flux_se_nw = select(0.0, state[address(job.from_flux_se, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let height_nw = state[address(job.from_height, x_m1, y_m1)];
        let water_nw = select(0.0, state[address(job.from_water, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let n81 = select(job.sea_0, height_nw, job.sea_0 < height_nw) + water_nw;
        let n84 = (job.keep_0 * flux_se_nw) + (job.push_d_0 * (n81 - head));
        let nw = (n16 * n14) * n84; // (1)
        let flux_sw = select(0.0, state[address(job.from_flux_sw, x_0, y_0)], x_0_inside && y_0_inside);
        let height_sw = state[address(job.from_height, x_m1, y_p1)];
        let water_sw = select(0.0, state[address(job.from_water, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let n92 = select(job.sea_0, height_sw, job.sea_0 < height_sw) + water_sw;
        let sw = (n17 * n14) * ((job.keep_0 * flux_sw) + (job.push_d_0 * (head - n92))); // (1)
        let flux_sw_ne = select(0.0, state[address(job.from_flux_sw, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let height_ne = state[address(job.from_height, x_p1, y_m1)];
        let water_ne = select(0.0, state[address(job.from_water, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let n103 = select(job.sea_0, height_ne, job.sea_0 < height_ne) + water_ne;
        let n106 = (job.keep_0 * flux_sw_ne) + (job.push_d_0 * (n103 - head));
        let ne = (n16 * n15) * n106; // (1)
        let n110 = select(0.0f, east, 0.0f < east) - select(0.0f, west, west < 0.0f);
        let n113 = select(0.0f, south, 0.0f < south) - select(0.0f, north, north < 0.0f);
        let n117 = select(0.0f, se, 0.0f < se) - select(0.0f, nw, nw < 0.0f);
        let n120 = select(0.0f, sw, 0.0f < sw) - select(0.0f, ne, ne < 0.0f);
        let out = job.dt_0 * ((n110 + n113) + (n117 + n120)); // (2)
        let afford = select(1.0f, (water / out), water < out); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let concentration = sediment / select(1e-6f, water, 1e-6f < water); // (2)
        let n132 = select(east, 0.0f, abs(east) < 1e-30f);
        let n134 = select(south, 0.0f, abs(south) < 1e-30f);
        let n136 = select(se, 0.0f, abs(se) < 1e-30f);
        let n138 = select(sw, 0.0f, abs(sw) < 1e-30f);
        let n139 = afford * concentration;
        if cy >= 0 {
            state[address(job.to_raw_x, cx, cy)] = n132;
        }
        if cx >= 0 {
            state[address(job.to_raw_y, cx, cy)] = n134;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_raw_se, cx, cy)] = n136;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_raw_sw, cx, cy)] = n138;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_afford, cx, cy)] = afford;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_afford_sediment, cx, cy)] = n139;
        }
    }
}

// hydraulic_eight_erode: tiles of 32 x 16 cells.

struct Job {
    width: i32,
    height: i32,
    left: i32,
    top: i32,
    first_row: i32,
    end_row: i32,
    stride: i32,
    slots: i32,
    first_group: i32,
    groups: i32,
    from_height: i32,
    from_water: i32,
    from_sediment: i32,
    from_raw_x: i32,
    from_raw_y: i32,
    from_raw_se: i32,
    from_raw_sw: i32,
    from_afford: i32,
    from_afford_sediment: i32,
    to_height: i32,
    to_water: i32,
    to_sediment: i32,
    to_flux_x: i32,
    to_flux_y: i32,
    to_flux_se: i32,
    to_flux_sw: i32,
    dt_0: f32,
    dx_0: f32,
    dy_0: f32,
    slope_x_0: f32,
    slope_y_0: f32,
    rain_0: f32,
    keep_0: f32,
    dry_0: f32,
    speed2_max_0: f32,
    sine2_min_0: f32,
    sine2_max_0: f32,
    capacity_0: f32,
    ramp_0: f32,
    dig_0: f32,
    settle_0: f32,
    dig_limit_0: f32,
    sea_0: f32,
    account_0_0: i32,
    account_0_1: i32,
    account_0_2: i32,
    account_0_3: i32,
    account_0_4: i32,
    account_0_5: i32,
    account_0_6: i32,
    account_0_7: i32,
    account_0_8: i32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
}
// No compiler knows that no bit changes here, so that none fuses a product with a sum.
fn rounded(v: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(v) ^ (u32(job.slots) >> 31u));
}
var<workgroup> parts: array<vec4<f32>, 256>;
// A sum and what rounding took from it (Knuth's two-sum), so that thousands of steps lose nothing.
fn post(account: i32, value: f32, group: i32) {
    let place = account * job.groups + group;
    let old = sums[place];
    let total = old.x + value;
    let part = total - old.x;
    sums[place] = vec2<f32>(total, old.y + ((old.x - (total - part)) + (value - part)));
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let left = i32(group.x) * 32 + job.left;
    let top = i32(group.y) * 16 + job.top;
    var sum_0_0 = 0.0;
    var sum_0_1 = 0.0;
    var sum_0_2 = 0.0;
    var sum_0_3 = 0.0;
    var sum_0_4 = 0.0;
    var sum_0_5 = 0.0;
    var sum_0_6 = 0.0;
    var sum_0_7 = 0.0;
    var sum_0_8 = 0.0;

    // Rule `hydraulic_eight_erode`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.end_row {
            continue;
        }
        let x = cx;
        let y = cy;
        let x_0 = max(cx, 0);
        let x_0_face = cx;
        let x_0_inside = cx >= 0;
        let x_m1 = max(cx - 1, 0);
        let x_m1_face = max(cx - 1, -1);
        let x_m1_face_inside = cx - 1 >= -1;
        let x_m1_inside = cx - 1 >= 0;
        let x_p1 = min(cx + 1, job.width - 1);
        let x_p1_inside = cx + 1 < job.width;
        let y_0 = max(cy, 0);
        let y_0_face = cy;
        let y_0_inside = cy >= 0;
        let y_m1 = max(cy - 1, 0);
        let y_m1_face = max(cy - 1, -1);
        let y_m1_face_inside = cy - 1 >= -1;
        let y_m1_inside = cy - 1 >= 0;
        let y_p1 = min(cy + 1, job.height - 1);
        let y_p1_inside = cy + 1 < job.height;
        let raw_x = select(0.0, state[address(job.from_raw_x, x_0_face, y_0)], y_0_inside);
        let afford_e = select(0.0, state[address(job.from_afford, x_p1, y_0)], x_p1_inside && y_0_inside);
        let afford = select(0.0, state[address(job.from_afford, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_sediment_e = select(0.0, state[address(job.from_afford_sediment, x_p1, y_0)], x_p1_inside && y_0_inside);
        let afford_sediment = select(0.0, state[address(job.from_afford_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n25 = raw_x * select(afford, afford_e, raw_x < 0.0f);
        let n26 = raw_x * select(afford_sediment, afford_sediment_e, raw_x < 0.0f);
        let raw_x_w = select(0.0, state[address(job.from_raw_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let afford_w = select(0.0, state[address(job.from_afford, x_m1, y_0)], x_m1_inside && y_0_inside);
        let afford_sediment_w = select(0.0, state[address(job.from_afford_sediment, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n31 = select(afford_sediment_w, afford_sediment, raw_x_w < 0.0f);
        let n32 = raw_x_w * select(afford_w, afford, raw_x_w < 0.0f);
        let n33 = raw_x_w * n31;
        let raw_y = select(0.0, state[address(job.from_raw_y, x_0, y_0_face)], x_0_inside);
        let afford_s = select(0.0, state[address(job.from_afford, x_0, y_p1)], x_0_inside && y_p1_inside);
        let afford_sediment_s = select(0.0, state[address(job.from_afford_sediment, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n39 = raw_y * select(afford, afford_s, raw_y < 0.0f);
        let n40 = raw_y * select(afford_sediment, afford_sediment_s, raw_y < 0.0f);
        let raw_y_n = select(0.0, state[address(job.from_raw_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let afford_n = select(0.0, state[address(job.from_afford, x_0, y_m1)], x_0_inside && y_m1_inside);
        let afford_sediment_n = select(0.0, state[address(job.from_afford_sediment, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n45 = select(afford_sediment_n, afford_sediment, raw_y_n < 0.0f);
        let n46 = raw_y_n * select(afford_n, afford, raw_y_n < 0.0f);
        let n47 = raw_y_n * n45;
        let raw_se = select(0.0, state[address(job.from_raw_se, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_se = select(0.0, state[address(job.from_afford, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let afford_sediment_se = select(0.0, state[address(job.from_afford_sediment, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let n52 = select(afford_sediment, afford_sediment_se, raw_se < 0.0f);
        let n53 = raw_se * select(afford, afford_se, raw_se < 0.0f);
        let raw_se_nw = select(0.0, state[address(job.from_raw_se, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let afford_nw = select(0.0, state[address(job.from_afford, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let afford_sediment_nw = select(0.0, state[address(job.from_afford_sediment, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let n59 = select(afford_sediment_nw, afford_sediment, raw_se_nw < 0.0f);
        let n60 = raw_se_nw * select(afford_nw, afford, raw_se_nw < 0.0f);
        let raw_sw = select(0.0, state[address(job.from_raw_sw, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_sw = select(0.0, state[address(job.from_afford, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let afford_sediment_sw = select(0.0, state[address(job.from_afford_sediment, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let n66 = select(afford_sediment, afford_sediment_sw, raw_sw < 0.0f);
        let n67 = raw_sw * select(afford, afford_sw, raw_sw < 0.0f);
        let raw_sw_ne = select(0.0, state[address(job.from_raw_sw, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let afford_ne = select(0.0, state[address(job.from_afford, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let afford_sediment_ne = select(0.0, state[address(job.from_afford_sediment, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let n73 = select(afford_sediment_ne, afford_sediment, raw_sw_ne < 0.0f);
        let n74 = raw_sw_ne * select(afford_ne, afford, raw_sw_ne < 0.0f);
        let n76 = n60 + n53;
        let n77 = n74 + n67;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let height_se = state[address(job.from_height, x_p1, y_p1)];
        let height_nw = state[address(job.from_height, x_m1, y_m1)];
        let height_ne = state[address(job.from_height, x_p1, y_m1)];
        let height_sw = state[address(job.from_height, x_m1, y_p1)];
        let n86 = height_se - height_nw;
        let n87 = height_ne - height_sw;
        let n91 = select(height_w, height_e, height_e < height_w);
        let n92 = select(height_n, height_s, height_s < height_n);
        let n93 = select(n92, n91, n91 < n92);
        let n94 = select(height_nw, height_se, height_se < height_nw);
        let n95 = select(height_sw, height_ne, height_ne < height_sw);
        let n96 = select(n95, n94, n94 < n95);
        let n103 = ((n32 - n25) + (n46 - n39)) + ((n60 - n53) + (n74 - n67));
        let n109 = ((raw_se_nw * n59) - (raw_se * n52)) + ((raw_sw_ne * n73) - (raw_sw * n66));
        let flow_x = (0.5f * job.dx_0) * ((n32 + n25) + (n76 - n77)); // (4)
        let flow_y = (0.5f * job.dy_0) * ((n46 + n39) + (n76 + n77)); // (4)
        let slope_x = (0.16666667f * job.slope_x_0) * ((4.0f * (height_e - height_w)) + (n86 + n87)); // (5)
        let slope_y = (0.16666667f * job.slope_y_0) * ((4.0f * (height_s - height_n)) + (n86 - n87)); // (5)
        let lowest = select(n96, n93, n93 < n96);
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let moved = water + (job.dt_0 * n103); // (3)
        let wet = select(0.0f, moved, 0.0f < moved); // (3)
        let mean_depth = 0.5f * (water + wet); // (4)
        let flow_squared = (flow_x * flow_x) + (flow_y * flow_y); // (4)
        let slope_squared = (slope_x * slope_x) + (slope_y * slope_y); // (5)
        let n149 = select(job.dry_0, mean_depth, job.dry_0 < mean_depth);
        let depth_squared = n149 * n149; // (4)
        let n151 = 1.0f + slope_squared;
        let n153 = 1.0f / (depth_squared * n151);
        let speed_squared = (flow_squared * n151) * n153; // (4)
        let n157 = (slope_squared * depth_squared) * n153;
        let n158 = select(job.sine2_min_0, n157, job.sine2_min_0 < n157);
        let sine_squared = select(job.sine2_max_0, n158, n158 < job.sine2_max_0); // (5)
        let n160 = select(job.speed2_max_0, speed_squared, speed_squared < job.speed2_max_0);
        let capped_squared = select(0.0f, n160, job.dry_0 < mean_depth); // (4)
        let n165 = mean_depth * job.ramp_0;
        let capacity = (job.capacity_0 * sqrt((capped_squared * sine_squared))) * select(1.0f, n165, n165 < 1.0f); // (6)
        let carried = sediment + (job.dt_0 * (((n33 - n26) + (n47 - n40)) + n109)); // (7)
        let load = select(0.0f, carried, 0.0f < carried); // (7)
        let missing = capacity - load; // (7)
        let wish = job.dig_0 * select(0.0f, missing, 0.0f < missing); // (7)
        let n174 = height - lowest;
        let n176 = job.dig_limit_0 * select(0.0f, n174, 0.0f < n174);
        let may_dig = select(n176, wish, wish < n176); // (7)
        let n178 = -(missing);
        let dug = select(may_dig, 0.0f, height < job.sea_0); // (7)
        let settled = select((job.settle_0 * select(0.0f, n178, 0.0f < n178)), load, height < job.sea_0); // (7)
        let n190 = load - (1.1920929e-7f * (abs(height) + load));
        let n191 = select(0.0f, n190, 0.0f < n190);
        let n194 = bitcast<u32>(((height - dug) + select(n191, settled, settled < n191)));
        let new_height = rounded(((height - dug) + select(n191, settled, settled < n191))); // (7)
        let n196 = height - new_height;
        let n197 = load + n196;
        let new_load = select(n197, 0.0f, abs(n197) < 1e-30f); // (7)
        let kept = wet * select(job.keep_0, 0.0f, height < job.sea_0); // (8)
        let n204 = select((job.rain_0 * job.dt_0), 0.0f, height < job.sea_0);
        let n205 = kept + n204;
        let new_water = select(n205, 0.0f, abs(n205) < 1e-30f); // (8)
        if cx >= 0 && cy >= 0 {
            state[address(job.to_height, cx, cy)] = new_height;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_water, cx, cy)] = new_water;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_sediment, cx, cy)] = new_load;
        }
        if cy >= 0 {
            state[address(job.to_flux_x, cx, cy)] = n25;
        }
        if cx >= 0 {
            state[address(job.to_flux_y, cx, cy)] = n39;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_flux_se, cx, cy)] = n53;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_flux_sw, cx, cy)] = n67;
        }
        if cx >= 0 && cy >= 0 {
            let lost = wet - kept; // (8)
            let n214 = select(0.0f, select(0.0f, 1.0f, job.speed2_max_0 < speed_squared), job.dry_0 < mean_depth);
            sum_0_0 += (new_water - kept);
            sum_0_1 += select(lost, 0.0f, height < job.sea_0);
            sum_0_2 += select(0.0f, lost, height < job.sea_0);
            sum_0_3 += (wet - moved);
            sum_0_4 += select((wish - may_dig), 0.0f, height < job.sea_0);
            sum_0_5 += n214;
            sum_0_6 += select(0.0f, n196, 0.0f < n196);
            sum_0_8 += (load - carried);
            if cx == 0 {
                sum_0_2 += (job.dt_0 * (-(n32)));
                sum_0_7 += (job.dt_0 * (-(n33)));
            }
            if cx == job.width - 1 {
                sum_0_2 += (job.dt_0 * n25);
                sum_0_7 += (job.dt_0 * n26);
            }
            if cy == 0 {
                sum_0_2 += (job.dt_0 * (-(n46)));
                sum_0_7 += (job.dt_0 * (-(n47)));
            }
            if cy == job.height - 1 {
                sum_0_2 += (job.dt_0 * n39);
                sum_0_7 += (job.dt_0 * n40);
            }
        }
    }

    // Sums of the tile.
    let number = job.first_group + i32(group.y * groups.x + group.x);
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_0, sum_0_1, sum_0_2, sum_0_3);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_0, total.x, number);
        post(job.account_0_1, total.y, number);
        post(job.account_0_2, total.z, number);
        post(job.account_0_3, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_4, sum_0_5, sum_0_6, sum_0_7);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_4, total.x, number);
        post(job.account_0_5, total.y, number);
        post(job.account_0_6, total.z, number);
        post(job.account_0_7, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_8, 0.0, 0.0, 0.0);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_8, total.x, number);
    }
}

// hydraulic_eight_flux: tiles of 32 x 16 cells.

struct Job {
    width: i32,
    height: i32,
    left: i32,
    top: i32,
    first_row: i32,
    end_row: i32,
    stride: i32,
    slots: i32,
    first_group: i32,
    groups: i32,
    from_height: i32,
    from_water: i32,
    from_sediment: i32,
    from_flux_x: i32,
    from_flux_y: i32,
    from_flux_se: i32,
    from_flux_sw: i32,
    to_raw_x: i32,
    to_raw_y: i32,
    to_raw_se: i32,
    to_raw_sw: i32,
    to_afford: i32,
    to_afford_sediment: i32,
    push_x_0: f32,
    push_y_0: f32,
    push_d_0: f32,
    keep_0: f32,
    dt_0: f32,
    sea_0: f32,
    first_x_0: f32,
    last_x_0: f32,
    first_y_0: f32,
    last_y_0: f32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let left = i32(group.x) * 32 + job.left;
    let top = i32(group.y) * 16 + job.top;

    // Rule `hydraulic_eight_flux`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.end_row {
            continue;
        }
        let x = cx;
        let y = cy;
        let x_0 = max(cx, 0);
        let x_0_face = cx;
        let x_0_inside = cx >= 0;
        let x_m1 = max(cx - 1, 0);
        let x_m1_face = max(cx - 1, -1);
        let x_m1_face_inside = cx - 1 >= -1;
        let x_m1_inside = cx - 1 >= 0;
        let x_p1 = min(cx + 1, job.width - 1);
        let x_p1_inside = cx + 1 < job.width;
        let y_0 = max(cy, 0);
        let y_0_face = cy;
        let y_0_inside = cy >= 0;
        let y_m1 = max(cy - 1, 0);
        let y_m1_face = max(cy - 1, -1);
        let y_m1_face_inside = cy - 1 >= -1;
        let y_m1_inside = cy - 1 >= 0;
        let y_p1 = min(cy + 1, job.height - 1);
        let y_p1_inside = cy + 1 < job.height;
        let n14 = select(0.0f, 1.0f, job.first_x_0 < f32(x));
        let n15 = select(0.0f, 1.0f, f32(x) < job.last_x_0);
        let n16 = select(0.0f, 1.0f, job.first_y_0 < f32(y));
        let n17 = select(0.0f, 1.0f, f32(y) < job.last_y_0);
        let push_x = job.push_x_0 - (job.push_d_0 * (n16 + n17)); // (1)
        let push_y = job.push_y_0 - (job.push_d_0 * (n14 + n15)); // (1)
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = select(job.sea_0, height, job.sea_0 < height) + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n33 = select(job.sea_0, height_e, job.sea_0 < height_e) + water_e;
        let east = (job.keep_0 * flux_x) + (push_x * (head - n33)); // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n42 = select(job.sea_0, height_w, job.sea_0 < height_w) + water_w;
        let west = (job.keep_0 * flux_x_w) + (push_x * (n42 - head)); // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n51 = select(job.sea_0, height_s, job.sea_0 < height_s) + water_s;
        let south = (job.keep_0 * flux_y) + (push_y * (head - n51)); // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n60 = select(job.sea_0, height_n, job.sea_0 < height_n) + water_n;
        let north = (job.keep_0 * flux_y_n) + (push_y * (n60 - head)); // (1)
        let flux_se = select(0.0, state[address(job.from_flux_se, x_0, y_0)], x_0_inside && y_0_inside);
        let height_se = state[address(job.from_height, x_p1, y_p1)];
        let water_se = select(0.0, state[address(job.from_water, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let n70 = select(job.sea_0, height_se, job.sea_0 < height_se) + water_se;
        let se = (n17 * n15) * ((job.keep_0 * flux_se) + (job.push_d_0 * (head - n70))); // (1)
        let flux_se_nw = select(0.0, state[address(job.from_flux_se, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let height_nw = state[address(job.from_height, x_m1, y_m1)];
        let water_nw = select(0.0, state[address(job.from_water, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let n81 = select(job.sea_0, height_nw, job.sea_0 < height_nw) + water_nw;
        let n84 = (job.keep_0 * flux_se_nw) + (job.push_d_0 * (n81 - head));
        let nw = (n16 * n14) * n84; // (1)
        let flux_sw = select(0.0, state[address(job.from_flux_sw, x_0, y_0)], x_0_inside && y_0_inside);
        let height_sw = state[address(job.from_height, x_m1, y_p1)];
        let water_sw = select(0.0, state[address(job.from_water, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let n92 = select(job.sea_0, height_sw, job.sea_0 < height_sw) + water_sw;
        let sw = (n17 * n14) * ((job.keep_0 * flux_sw) + (job.push_d_0 * (head - n92))); // (1)
        let flux_sw_ne = select(0.0, state[address(job.from_flux_sw, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let height_ne = state[address(job.from_height, x_p1, y_m1)];
        let water_ne = select(0.0, state[address(job.from_water, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let n103 = select(job.sea_0, height_ne, job.sea_0 < height_ne) + water_ne;
        let n106 = (job.keep_0 * flux_sw_ne) + (job.push_d_0 * (n103 - head));
        let ne = (n16 * n15) * n106; // (1)
        let n110 = select(0.0f, east, 0.0f < east) - select(0.0f, west, west < 0.0f);
        let n113 = select(0.0f, south, 0.0f < south) - select(0.0f, north, north < 0.0f);
        let n117 = select(0.0f, se, 0.0f < se) - select(0.0f, nw, nw < 0.0f);
        let n120 = select(0.0f, sw, 0.0f < sw) - select(0.0f, ne, ne < 0.0f);
        let out = job.dt_0 * ((n110 + n113) + (n117 + n120)); // (2)
        let afford = select(1.0f, (water / out), water < out); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let concentration = sediment / select(1e-6f, water, 1e-6f < water); // (2)
        let n132 = select(east, 0.0f, abs(east) < 1e-30f);
        let n134 = select(south, 0.0f, abs(south) < 1e-30f);
        let n136 = select(se, 0.0f, abs(se) < 1e-30f);
        let n138 = select(sw, 0.0f, abs(sw) < 1e-30f);
        let n139 = afford * concentration;
        if cy >= 0 {
            state[address(job.to_raw_x, cx, cy)] = n132;
        }
        if cx >= 0 {
            state[address(job.to_raw_y, cx, cy)] = n134;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_raw_se, cx, cy)] = n136;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_raw_sw, cx, cy)] = n138;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_afford, cx, cy)] = afford;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_afford_sediment, cx, cy)] = n139;
        }
    }
}

// hydraulic_eight_erode: tiles of 32 x 16 cells.

struct Job {
    width: i32,
    height: i32,
    left: i32,
    top: i32,
    first_row: i32,
    end_row: i32,
    stride: i32,
    slots: i32,
    first_group: i32,
    groups: i32,
    from_height: i32,
    from_water: i32,
    from_sediment: i32,
    from_raw_x: i32,
    from_raw_y: i32,
    from_raw_se: i32,
    from_raw_sw: i32,
    from_afford: i32,
    from_afford_sediment: i32,
    to_height: i32,
    to_water: i32,
    to_sediment: i32,
    to_flux_x: i32,
    to_flux_y: i32,
    to_flux_se: i32,
    to_flux_sw: i32,
    dt_0: f32,
    dx_0: f32,
    dy_0: f32,
    slope_x_0: f32,
    slope_y_0: f32,
    rain_0: f32,
    keep_0: f32,
    dry_0: f32,
    speed2_max_0: f32,
    sine2_min_0: f32,
    sine2_max_0: f32,
    capacity_0: f32,
    ramp_0: f32,
    dig_0: f32,
    settle_0: f32,
    dig_limit_0: f32,
    sea_0: f32,
    account_0_0: i32,
    account_0_1: i32,
    account_0_2: i32,
    account_0_3: i32,
    account_0_4: i32,
    account_0_5: i32,
    account_0_6: i32,
    account_0_7: i32,
    account_0_8: i32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
}
// No compiler knows that no bit changes here, so that none fuses a product with a sum.
fn rounded(v: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(v) ^ (u32(job.slots) >> 31u));
}
var<workgroup> parts: array<vec4<f32>, 256>;
// A sum and what rounding took from it (Knuth's two-sum), so that thousands of steps lose nothing.
fn post(account: i32, value: f32, group: i32) {
    let place = account * job.groups + group;
    let old = sums[place];
    let total = old.x + value;
    let part = total - old.x;
    sums[place] = vec2<f32>(total, old.y + ((old.x - (total - part)) + (value - part)));
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let left = i32(group.x) * 32 + job.left;
    let top = i32(group.y) * 16 + job.top;
    var sum_0_0 = 0.0;
    var sum_0_1 = 0.0;
    var sum_0_2 = 0.0;
    var sum_0_3 = 0.0;
    var sum_0_4 = 0.0;
    var sum_0_5 = 0.0;
    var sum_0_6 = 0.0;
    var sum_0_7 = 0.0;
    var sum_0_8 = 0.0;

    // Rule `hydraulic_eight_erode`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.end_row {
            continue;
        }
        let x = cx;
        let y = cy;
        let x_0 = max(cx, 0);
        let x_0_face = cx;
        let x_0_inside = cx >= 0;
        let x_m1 = max(cx - 1, 0);
        let x_m1_face = max(cx - 1, -1);
        let x_m1_face_inside = cx - 1 >= -1;
        let x_m1_inside = cx - 1 >= 0;
        let x_p1 = min(cx + 1, job.width - 1);
        let x_p1_inside = cx + 1 < job.width;
        let y_0 = max(cy, 0);
        let y_0_face = cy;
        let y_0_inside = cy >= 0;
        let y_m1 = max(cy - 1, 0);
        let y_m1_face = max(cy - 1, -1);
        let y_m1_face_inside = cy - 1 >= -1;
        let y_m1_inside = cy - 1 >= 0;
        let y_p1 = min(cy + 1, job.height - 1);
        let y_p1_inside = cy + 1 < job.height;
        let raw_x = select(0.0, state[address(job.from_raw_x, x_0_face, y_0)], y_0_inside);
        let afford_e = select(0.0, state[address(job.from_afford, x_p1, y_0)], x_p1_inside && y_0_inside);
        let afford = select(0.0, state[address(job.from_afford, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_sediment_e = select(0.0, state[address(job.from_afford_sediment, x_p1, y_0)], x_p1_inside && y_0_inside);
        let afford_sediment = select(0.0, state[address(job.from_afford_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n25 = raw_x * select(afford, afford_e, raw_x < 0.0f);
        let n26 = raw_x * select(afford_sediment, afford_sediment_e, raw_x < 0.0f);
        let raw_x_w = select(0.0, state[address(job.from_raw_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let afford_w = select(0.0, state[address(job.from_afford, x_m1, y_0)], x_m1_inside && y_0_inside);
        let afford_sediment_w = select(0.0, state[address(job.from_afford_sediment, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n31 = select(afford_sediment_w, afford_sediment, raw_x_w < 0.0f);
        let n32 = raw_x_w * select(afford_w, afford, raw_x_w < 0.0f);
        let n33 = raw_x_w * n31;
        let raw_y = select(0.0, state[address(job.from_raw_y, x_0, y_0_face)], x_0_inside);
        let afford_s = select(0.0, state[address(job.from_afford, x_0, y_p1)], x_0_inside && y_p1_inside);
        let afford_sediment_s = select(0.0, state[address(job.from_afford_sediment, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n39 = raw_y * select(afford, afford_s, raw_y < 0.0f);
        let n40 = raw_y * select(afford_sediment, afford_sediment_s, raw_y < 0.0f);
        let raw_y_n = select(0.0, state[address(job.from_raw_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let afford_n = select(0.0, state[address(job.from_afford, x_0, y_m1)], x_0_inside && y_m1_inside);
        let afford_sediment_n = select(0.0, state[address(job.from_afford_sediment, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n45 = select(afford_sediment_n, afford_sediment, raw_y_n < 0.0f);
        let n46 = raw_y_n * select(afford_n, afford, raw_y_n < 0.0f);
        let n47 = raw_y_n * n45;
        let raw_se = select(0.0, state[address(job.from_raw_se, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_se = select(0.0, state[address(job.from_afford, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let afford_sediment_se = select(0.0, state[address(job.from_afford_sediment, x_p1, y_p1)], x_p1_inside && y_p1_inside);
        let n52 = select(afford_sediment, afford_sediment_se, raw_se < 0.0f);
        let n53 = raw_se * select(afford, afford_se, raw_se < 0.0f);
        let raw_se_nw = select(0.0, state[address(job.from_raw_se, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let afford_nw = select(0.0, state[address(job.from_afford, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let afford_sediment_nw = select(0.0, state[address(job.from_afford_sediment, x_m1, y_m1)], x_m1_inside && y_m1_inside);
        let n59 = select(afford_sediment_nw, afford_sediment, raw_se_nw < 0.0f);
        let n60 = raw_se_nw * select(afford_nw, afford, raw_se_nw < 0.0f);
        let raw_sw = select(0.0, state[address(job.from_raw_sw, x_0, y_0)], x_0_inside && y_0_inside);
        let afford_sw = select(0.0, state[address(job.from_afford, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let afford_sediment_sw = select(0.0, state[address(job.from_afford_sediment, x_m1, y_p1)], x_m1_inside && y_p1_inside);
        let n66 = select(afford_sediment, afford_sediment_sw, raw_sw < 0.0f);
        let n67 = raw_sw * select(afford, afford_sw, raw_sw < 0.0f);
        let raw_sw_ne = select(0.0, state[address(job.from_raw_sw, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let afford_ne = select(0.0, state[address(job.from_afford, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let afford_sediment_ne = select(0.0, state[address(job.from_afford_sediment, x_p1, y_m1)], x_p1_inside && y_m1_inside);
        let n73 = select(afford_sediment_ne, afford_sediment, raw_sw_ne < 0.0f);
        let n74 = raw_sw_ne * select(afford_ne, afford, raw_sw_ne < 0.0f);
        let n76 = n60 + n53;
        let n77 = n74 + n67;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let height_se = state[address(job.from_height, x_p1, y_p1)];
        let height_nw = state[address(job.from_height, x_m1, y_m1)];
        let height_ne = state[address(job.from_height, x_p1, y_m1)];
        let height_sw = state[address(job.from_height, x_m1, y_p1)];
        let n86 = height_se - height_nw;
        let n87 = height_ne - height_sw;
        let n91 = select(height_w, height_e, height_e < height_w);
        let n92 = select(height_n, height_s, height_s < height_n);
        let n93 = select(n92, n91, n91 < n92);
        let n94 = select(height_nw, height_se, height_se < height_nw);
        let n95 = select(height_sw, height_ne, height_ne < height_sw);
        let n96 = select(n95, n94, n94 < n95);
        let n103 = ((n32 - n25) + (n46 - n39)) + ((n60 - n53) + (n74 - n67));
        let n109 = ((raw_se_nw * n59) - (raw_se * n52)) + ((raw_sw_ne * n73) - (raw_sw * n66));
        let flow_x = (0.5f * job.dx_0) * ((n32 + n25) + (n76 - n77)); // (4)
        let flow_y = (0.5f * job.dy_0) * ((n46 + n39) + (n76 + n77)); // (4)
        let slope_x = (0.16666667f * job.slope_x_0) * ((4.0f * (height_e - height_w)) + (n86 + n87)); // (5)
        let slope_y = (0.16666667f * job.slope_y_0) * ((4.0f * (height_s - height_n)) + (n86 - n87)); // (5)
        let lowest = select(n96, n93, n93 < n96);
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let moved = water + (job.dt_0 * n103); // (3)
        let wet = select(0.0f, moved, 0.0f < moved); // (3)
        let mean_depth = 0.5f * (water + wet); // (4)
        let flow_squared = (flow_x * flow_x) + (flow_y * flow_y); // (4)
        let slope_squared = (slope_x * slope_x) + (slope_y * slope_y); // (5)
        let n149 = select(job.dry_0, mean_depth, job.dry_0 < mean_depth);
        let depth_squared = n149 * n149; // (4)
        let n151 = 1.0f + slope_squared;
        let n153 = 1.0f / (depth_squared * n151);
        let speed_squared = (flow_squared * n151) * n153; // (4)
        let n157 = (slope_squared * depth_squared) * n153;
        let n158 = select(job.sine2_min_0, n157, job.sine2_min_0 < n157);
        let sine_squared = select(job.sine2_max_0, n158, n158 < job.sine2_max_0); // (5)
        let n160 = select(job.speed2_max_0, speed_squared, speed_squared < job.speed2_max_0);
        let capped_squared = select(0.0f, n160, job.dry_0 < mean_depth); // (4)
        let n165 = mean_depth * job.ramp_0;
        let capacity = (job.capacity_0 * sqrt((capped_squared * sine_squared))) * select(1.0f, n165, n165 < 1.0f); // (6)
        let carried = sediment + (job.dt_0 * (((n33 - n26) + (n47 - n40)) + n109)); // (7)
        let load = select(0.0f, carried, 0.0f < carried); // (7)
        let missing = capacity - load; // (7)
        let wish = job.dig_0 * select(0.0f, missing, 0.0f < missing); // (7)
        let n174 = height - lowest;
        let n176 = job.dig_limit_0 * select(0.0f, n174, 0.0f < n174);
        let may_dig = select(n176, wish, wish < n176); // (7)
        let n178 = -(missing);
        let dug = select(may_dig, 0.0f, height < job.sea_0); // (7)
        let settled = select((job.settle_0 * select(0.0f, n178, 0.0f < n178)), load, height < job.sea_0); // (7)
        let n190 = load - (1.1920929e-7f * (abs(height) + load));
        let n191 = select(0.0f, n190, 0.0f < n190);
        let n194 = bitcast<u32>(((height - dug) + select(n191, settled, settled < n191)));
        let new_height = rounded(((height - dug) + select(n191, settled, settled < n191))); // (7)
        let n196 = height - new_height;
        let n197 = load + n196;
        let new_load = select(n197, 0.0f, abs(n197) < 1e-30f); // (7)
        let kept = wet * select(job.keep_0, 0.0f, height < job.sea_0); // (8)
        let n204 = select((job.rain_0 * job.dt_0), 0.0f, height < job.sea_0);
        let n205 = kept + n204;
        let new_water = select(n205, 0.0f, abs(n205) < 1e-30f); // (8)
        if cx >= 0 && cy >= 0 {
            state[address(job.to_height, cx, cy)] = new_height;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_water, cx, cy)] = new_water;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_sediment, cx, cy)] = new_load;
        }
        if cy >= 0 {
            state[address(job.to_flux_x, cx, cy)] = n25;
        }
        if cx >= 0 {
            state[address(job.to_flux_y, cx, cy)] = n39;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_flux_se, cx, cy)] = n53;
        }
        if cx >= 0 && cy >= 0 {
            state[address(job.to_flux_sw, cx, cy)] = n67;
        }
        if cx >= 0 && cy >= 0 {
            let lost = wet - kept; // (8)
            let n214 = select(0.0f, select(0.0f, 1.0f, job.speed2_max_0 < speed_squared), job.dry_0 < mean_depth);
            sum_0_0 += (new_water - kept);
            sum_0_1 += select(lost, 0.0f, height < job.sea_0);
            sum_0_2 += select(0.0f, lost, height < job.sea_0);
            sum_0_3 += (wet - moved);
            sum_0_4 += select((wish - may_dig), 0.0f, height < job.sea_0);
            sum_0_5 += n214;
            sum_0_6 += select(0.0f, n196, 0.0f < n196);
            sum_0_8 += (load - carried);
            if cx == 0 {
                sum_0_2 += (job.dt_0 * (-(n32)));
                sum_0_7 += (job.dt_0 * (-(n33)));
            }
            if cx == job.width - 1 {
                sum_0_2 += (job.dt_0 * n25);
                sum_0_7 += (job.dt_0 * n26);
            }
            if cy == 0 {
                sum_0_2 += (job.dt_0 * (-(n46)));
                sum_0_7 += (job.dt_0 * (-(n47)));
            }
            if cy == job.height - 1 {
                sum_0_2 += (job.dt_0 * n39);
                sum_0_7 += (job.dt_0 * n40);
            }
        }
    }

    // Sums of the tile.
    let number = job.first_group + i32(group.y * groups.x + group.x);
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_0, sum_0_1, sum_0_2, sum_0_3);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_0, total.x, number);
        post(job.account_0_1, total.y, number);
        post(job.account_0_2, total.z, number);
        post(job.account_0_3, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_4, sum_0_5, sum_0_6, sum_0_7);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_4, total.x, number);
        post(job.account_0_5, total.y, number);
        post(job.account_0_6, total.z, number);
        post(job.account_0_7, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_8, 0.0, 0.0, 0.0);
    workgroupBarrier();
    if thread % 16u == 0u {
        var part = parts[thread];
        for (var i = 1u; i < 16u; i++) {
            part += parts[thread + i];
        }
        parts[thread] = part;
    }
    workgroupBarrier();
    if thread == 0u {
        var total = parts[0];
        for (var i = 16u; i < 256u; i += 16u) {
            total += parts[i];
        }
        post(job.account_0_8, total.x, number);
    }
}
