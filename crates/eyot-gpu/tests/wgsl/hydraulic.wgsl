// hydraulic_flux, hydraulic_erode: tiles of 32 x 16 cells.

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
    to_height: i32,
    to_water: i32,
    to_sediment: i32,
    to_flux_x: i32,
    to_flux_y: i32,
    push_x_0: f32,
    push_y_0: f32,
    keep_0: f32,
    dt_0: f32,
    sea_0: f32,
    dt_1: f32,
    dx_1: f32,
    dy_1: f32,
    slope_x_1: f32,
    slope_y_1: f32,
    rain_1: f32,
    keep_1: f32,
    dry_1: f32,
    speed2_max_1: f32,
    sine2_min_1: f32,
    sine2_max_1: f32,
    capacity_1: f32,
    ramp_1: f32,
    dig_1: f32,
    settle_1: f32,
    dig_limit_1: f32,
    sea_1: f32,
    account_1_0: i32,
    account_1_1: i32,
    account_1_2: i32,
    account_1_3: i32,
    account_1_4: i32,
    account_1_5: i32,
    account_1_6: i32,
    account_1_7: i32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;
var<workgroup> tile_0_raw_x: array<f32, 612>;
var<workgroup> tile_0_raw_y: array<f32, 612>;
var<workgroup> tile_0_afford: array<f32, 612>;
var<workgroup> tile_0_afford_sediment: array<f32, 612>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
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
    var sum_1_0 = 0.0;
    var sum_1_1 = 0.0;
    var sum_1_2 = 0.0;
    var sum_1_3 = 0.0;
    var sum_1_4 = 0.0;
    var sum_1_5 = 0.0;
    var sum_1_6 = 0.0;
    var sum_1_7 = 0.0;

    // Rule `hydraulic_flux`, and on 1 cells around the tile.
    for (var c = thread; c < 612u; c += 256u) {
        let cx = left + i32(c % 34u) - 1;
        let cy = top + i32(c / 34u) - 1;
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.height {
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
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = select(job.sea_0, height, job.sea_0 < height) + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n14 = select(job.sea_0, height_e, job.sea_0 < height_e) + water_e;
        let east = (job.keep_0 * flux_x) + (job.push_x_0 * (head - n14)); // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n23 = select(job.sea_0, height_w, job.sea_0 < height_w) + water_w;
        let west = (job.keep_0 * flux_x_w) + (job.push_x_0 * (n23 - head)); // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n32 = select(job.sea_0, height_s, job.sea_0 < height_s) + water_s;
        let south = (job.keep_0 * flux_y) + (job.push_y_0 * (head - n32)); // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n41 = select(job.sea_0, height_n, job.sea_0 < height_n) + water_n;
        let north = (job.keep_0 * flux_y_n) + (job.push_y_0 * (n41 - head)); // (1)
        let n48 = select(0.0f, east, 0.0f < east) - select(0.0f, west, west < 0.0f);
        let n51 = select(0.0f, south, 0.0f < south) - select(0.0f, north, north < 0.0f);
        let out = n48 + n51;
        let n53 = job.dt_0 * out;
        let afford = select(1.0f, (water / n53), water < n53); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let concentration = sediment / select(1e-6f, water, 1e-6f < water); // (2)
        let n63 = select(east, 0.0f, abs(east) < 1e-30f);
        let n65 = select(south, 0.0f, abs(south) < 1e-30f);
        let n66 = afford * concentration;
        tile_0_raw_x[c] = n63;
        tile_0_raw_y[c] = n65;
        tile_0_afford[c] = afford;
        tile_0_afford_sediment[c] = n66;
    }
    workgroupBarrier();

    // Rule `hydraulic_erode`.
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
        let raw_x = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_0_face - left + 1)], y_0_inside);
        let n20 = select(0.0f, raw_x, 0.0f < raw_x);
        let n21 = select(0.0f, raw_x, raw_x < 0.0f);
        let afford = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let afford_e = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n26 = (n20 * afford) + (n21 * afford_e);
        let afford_sediment = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let afford_sediment_e = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n31 = (n20 * afford_sediment) + (n21 * afford_sediment_e);
        let raw_x_w = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_m1_face - left + 1)], x_m1_face_inside && y_0_inside);
        let n33 = select(0.0f, raw_x_w, 0.0f < raw_x_w);
        let n34 = select(0.0f, raw_x_w, raw_x_w < 0.0f);
        let afford_w = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n38 = (n33 * afford_w) + (n34 * afford);
        let afford_sediment_w = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n42 = (n33 * afford_sediment_w) + (n34 * afford_sediment);
        let raw_y = select(0.0, tile_0_raw_y[(y_0_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside);
        let n44 = select(0.0f, raw_y, 0.0f < raw_y);
        let n45 = select(0.0f, raw_y, raw_y < 0.0f);
        let afford_s = select(0.0, tile_0_afford[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n49 = (n44 * afford) + (n45 * afford_s);
        let afford_sediment_s = select(0.0, tile_0_afford_sediment[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n53 = (n44 * afford_sediment) + (n45 * afford_sediment_s);
        let raw_y_n = select(0.0, tile_0_raw_y[(y_m1_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_face_inside);
        let n55 = select(0.0f, raw_y_n, 0.0f < raw_y_n);
        let n56 = select(0.0f, raw_y_n, raw_y_n < 0.0f);
        let afford_n = select(0.0, tile_0_afford[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n60 = (n55 * afford_n) + (n56 * afford);
        let afford_sediment_n = select(0.0, tile_0_afford_sediment[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n64 = (n55 * afford_sediment_n) + (n56 * afford_sediment);
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let moved = water + (job.dt_1 * ((n38 - n26) + (n60 - n49))); // (3)
        let wet = select(0.0f, moved, 0.0f < moved); // (3)
        let mean_depth = 0.5f * (water + wet); // (4)
        let flow_x = (0.5f * job.dx_1) * (n38 + n26); // (4)
        let flow_y = (0.5f * job.dy_1) * (n60 + n49); // (4)
        let flow_squared = (flow_x * flow_x) + (flow_y * flow_y); // (4)
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let slope_x = job.slope_x_1 * (height_e - height_w); // (5)
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let slope_y = job.slope_y_1 * (height_s - height_n); // (5)
        let slope_squared = (slope_x * slope_x) + (slope_y * slope_y); // (5)
        let n95 = select(job.dry_1, mean_depth, job.dry_1 < mean_depth);
        let depth_squared = n95 * n95; // (4)
        let n97 = 1.0f + slope_squared;
        let n99 = 1.0f / (depth_squared * n97);
        let speed_squared = (flow_squared * n97) * n99; // (4)
        let n103 = (slope_squared * depth_squared) * n99;
        let n104 = select(job.sine2_min_1, n103, job.sine2_min_1 < n103);
        let sine_squared = select(job.sine2_max_1, n104, n104 < job.sine2_max_1); // (5)
        let n106 = select(job.speed2_max_1, speed_squared, speed_squared < job.speed2_max_1);
        let capped_squared = select(0.0f, n106, job.dry_1 < mean_depth); // (4)
        let n111 = mean_depth * job.ramp_1;
        let capacity = (job.capacity_1 * sqrt((capped_squared * sine_squared))) * select(1.0f, n111, n111 < 1.0f); // (6)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let carried = sediment + (job.dt_1 * ((n42 - n31) + (n64 - n53))); // (7)
        let load = select(0.0f, carried, 0.0f < carried); // (7)
        let height = state[address(job.from_height, x_0, y_0)];
        let n122 = select(height_w, height_e, height_e < height_w);
        let n123 = select(height_n, height_s, height_s < height_n);
        let lowest = select(n123, n122, n122 < n123);
        let missing = capacity - load; // (7)
        let wish = job.dig_1 * select(0.0f, missing, 0.0f < missing); // (7)
        let n128 = height - lowest;
        let n130 = job.dig_limit_1 * select(0.0f, n128, 0.0f < n128);
        let may_dig = select(n130, wish, wish < n130); // (7)
        let n132 = -(missing);
        let dug = select(may_dig, 0.0f, height < job.sea_1); // (7)
        let settled = select((job.settle_1 * select(0.0f, n132, 0.0f < n132)), load, height < job.sea_1); // (7)
        let n144 = load - (1.1920929e-7f * (abs(height) + load));
        let n145 = select(0.0f, n144, 0.0f < n144);
        let new_height = (height - dug) + select(n145, settled, settled < n145); // (7)
        let n149 = load + (height - new_height);
        let new_load = select(n149, 0.0f, abs(n149) < 1e-30f); // (7)
        let kept = wet * select(job.keep_1, 0.0f, height < job.sea_1); // (8)
        let n156 = select((job.rain_1 * job.dt_1), 0.0f, height < job.sea_1);
        let n157 = kept + n156;
        let new_water = select(n157, 0.0f, abs(n157) < 1e-30f); // (8)
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
            state[address(job.to_flux_x, cx, cy)] = n26;
        }
        if cx >= 0 {
            state[address(job.to_flux_y, cx, cy)] = n49;
        }
        if cx >= 0 && cy >= 0 {
            let lost = wet - kept; // (8)
            let n166 = select(0.0f, select(0.0f, 1.0f, job.speed2_max_1 < speed_squared), job.dry_1 < mean_depth);
            sum_1_0 += (new_water - kept);
            sum_1_1 += select(lost, 0.0f, height < job.sea_1);
            sum_1_2 += select(0.0f, lost, height < job.sea_1);
            sum_1_3 += (wet - moved);
            sum_1_4 += select((wish - may_dig), 0.0f, height < job.sea_1);
            sum_1_5 += n166;
            sum_1_7 += (load - carried);
            if cx == 0 {
                sum_1_2 += (job.dt_1 * (-(n38)));
                sum_1_6 += (job.dt_1 * (-(n42)));
            }
            if cx == job.width - 1 {
                sum_1_2 += (job.dt_1 * n26);
                sum_1_6 += (job.dt_1 * n31);
            }
            if cy == 0 {
                sum_1_2 += (job.dt_1 * (-(n60)));
                sum_1_6 += (job.dt_1 * (-(n64)));
            }
            if cy == job.height - 1 {
                sum_1_2 += (job.dt_1 * n49);
                sum_1_6 += (job.dt_1 * n53);
            }
        }
    }

    // Sums of the tile.
    let number = job.first_group + i32(group.y * groups.x + group.x);
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_1_0, sum_1_1, sum_1_2, sum_1_3);
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
        post(job.account_1_0, total.x, number);
        post(job.account_1_1, total.y, number);
        post(job.account_1_2, total.z, number);
        post(job.account_1_3, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_1_4, sum_1_5, sum_1_6, sum_1_7);
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
        post(job.account_1_4, total.x, number);
        post(job.account_1_5, total.y, number);
        post(job.account_1_6, total.z, number);
        post(job.account_1_7, total.w, number);
    }
}

// hydraulic_flux, hydraulic_erode: tiles of 32 x 16 cells.

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
    to_height: i32,
    to_water: i32,
    to_sediment: i32,
    to_flux_x: i32,
    to_flux_y: i32,
    push_x_0: f32,
    push_y_0: f32,
    keep_0: f32,
    dt_0: f32,
    sea_0: f32,
    dt_1: f32,
    dx_1: f32,
    dy_1: f32,
    slope_x_1: f32,
    slope_y_1: f32,
    rain_1: f32,
    keep_1: f32,
    dry_1: f32,
    speed2_max_1: f32,
    sine2_min_1: f32,
    sine2_max_1: f32,
    capacity_1: f32,
    ramp_1: f32,
    dig_1: f32,
    settle_1: f32,
    dig_limit_1: f32,
    sea_1: f32,
    account_1_0: i32,
    account_1_1: i32,
    account_1_2: i32,
    account_1_3: i32,
    account_1_4: i32,
    account_1_5: i32,
    account_1_6: i32,
    account_1_7: i32,
}
@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read_write> state: array<f32>;
@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;
var<workgroup> tile_0_raw_x: array<f32, 612>;
var<workgroup> tile_0_raw_y: array<f32, 612>;
var<workgroup> tile_0_afford: array<f32, 612>;
var<workgroup> tile_0_afford_sediment: array<f32, 612>;

fn address(slot: i32, x: i32, y: i32) -> i32 {
    return 64 + ((y - job.first_row) * job.slots + slot) * job.stride + x;
}
fn wrapped(i: i32, n: i32) -> i32 {
    return (i % n + n) % n;
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
    var sum_1_0 = 0.0;
    var sum_1_1 = 0.0;
    var sum_1_2 = 0.0;
    var sum_1_3 = 0.0;
    var sum_1_4 = 0.0;
    var sum_1_5 = 0.0;
    var sum_1_6 = 0.0;
    var sum_1_7 = 0.0;

    // Rule `hydraulic_flux`, and on 1 cells around the tile.
    for (var c = thread; c < 612u; c += 256u) {
        let cx = left + i32(c % 34u) - 1;
        let cy = top + i32(c / 34u) - 1;
        if cx < -1 || cx >= job.width || cy < -1 || cy >= job.height {
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
        let height = state[address(job.from_height, x_0, y_0)];
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = select(job.sea_0, height, job.sea_0 < height) + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n14 = select(job.sea_0, height_e, job.sea_0 < height_e) + water_e;
        let east = (job.keep_0 * flux_x) + (job.push_x_0 * (head - n14)); // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n23 = select(job.sea_0, height_w, job.sea_0 < height_w) + water_w;
        let west = (job.keep_0 * flux_x_w) + (job.push_x_0 * (n23 - head)); // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n32 = select(job.sea_0, height_s, job.sea_0 < height_s) + water_s;
        let south = (job.keep_0 * flux_y) + (job.push_y_0 * (head - n32)); // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n41 = select(job.sea_0, height_n, job.sea_0 < height_n) + water_n;
        let north = (job.keep_0 * flux_y_n) + (job.push_y_0 * (n41 - head)); // (1)
        let n48 = select(0.0f, east, 0.0f < east) - select(0.0f, west, west < 0.0f);
        let n51 = select(0.0f, south, 0.0f < south) - select(0.0f, north, north < 0.0f);
        let out = n48 + n51;
        let n53 = job.dt_0 * out;
        let afford = select(1.0f, (water / n53), water < n53); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let concentration = sediment / select(1e-6f, water, 1e-6f < water); // (2)
        let n63 = select(east, 0.0f, abs(east) < 1e-30f);
        let n65 = select(south, 0.0f, abs(south) < 1e-30f);
        let n66 = afford * concentration;
        tile_0_raw_x[c] = n63;
        tile_0_raw_y[c] = n65;
        tile_0_afford[c] = afford;
        tile_0_afford_sediment[c] = n66;
    }
    workgroupBarrier();

    // Rule `hydraulic_erode`.
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
        let raw_x = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_0_face - left + 1)], y_0_inside);
        let n20 = select(0.0f, raw_x, 0.0f < raw_x);
        let n21 = select(0.0f, raw_x, raw_x < 0.0f);
        let afford = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let afford_e = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n26 = (n20 * afford) + (n21 * afford_e);
        let afford_sediment = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let afford_sediment_e = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n31 = (n20 * afford_sediment) + (n21 * afford_sediment_e);
        let raw_x_w = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_m1_face - left + 1)], x_m1_face_inside && y_0_inside);
        let n33 = select(0.0f, raw_x_w, 0.0f < raw_x_w);
        let n34 = select(0.0f, raw_x_w, raw_x_w < 0.0f);
        let afford_w = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n38 = (n33 * afford_w) + (n34 * afford);
        let afford_sediment_w = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n42 = (n33 * afford_sediment_w) + (n34 * afford_sediment);
        let raw_y = select(0.0, tile_0_raw_y[(y_0_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside);
        let n44 = select(0.0f, raw_y, 0.0f < raw_y);
        let n45 = select(0.0f, raw_y, raw_y < 0.0f);
        let afford_s = select(0.0, tile_0_afford[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n49 = (n44 * afford) + (n45 * afford_s);
        let afford_sediment_s = select(0.0, tile_0_afford_sediment[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n53 = (n44 * afford_sediment) + (n45 * afford_sediment_s);
        let raw_y_n = select(0.0, tile_0_raw_y[(y_m1_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_face_inside);
        let n55 = select(0.0f, raw_y_n, 0.0f < raw_y_n);
        let n56 = select(0.0f, raw_y_n, raw_y_n < 0.0f);
        let afford_n = select(0.0, tile_0_afford[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n60 = (n55 * afford_n) + (n56 * afford);
        let afford_sediment_n = select(0.0, tile_0_afford_sediment[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n64 = (n55 * afford_sediment_n) + (n56 * afford_sediment);
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let moved = water + (job.dt_1 * ((n38 - n26) + (n60 - n49))); // (3)
        let wet = select(0.0f, moved, 0.0f < moved); // (3)
        let mean_depth = 0.5f * (water + wet); // (4)
        let flow_x = (0.5f * job.dx_1) * (n38 + n26); // (4)
        let flow_y = (0.5f * job.dy_1) * (n60 + n49); // (4)
        let flow_squared = (flow_x * flow_x) + (flow_y * flow_y); // (4)
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let slope_x = job.slope_x_1 * (height_e - height_w); // (5)
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let slope_y = job.slope_y_1 * (height_s - height_n); // (5)
        let slope_squared = (slope_x * slope_x) + (slope_y * slope_y); // (5)
        let n95 = select(job.dry_1, mean_depth, job.dry_1 < mean_depth);
        let depth_squared = n95 * n95; // (4)
        let n97 = 1.0f + slope_squared;
        let n99 = 1.0f / (depth_squared * n97);
        let speed_squared = (flow_squared * n97) * n99; // (4)
        let n103 = (slope_squared * depth_squared) * n99;
        let n104 = select(job.sine2_min_1, n103, job.sine2_min_1 < n103);
        let sine_squared = select(job.sine2_max_1, n104, n104 < job.sine2_max_1); // (5)
        let n106 = select(job.speed2_max_1, speed_squared, speed_squared < job.speed2_max_1);
        let capped_squared = select(0.0f, n106, job.dry_1 < mean_depth); // (4)
        let n111 = mean_depth * job.ramp_1;
        let capacity = (job.capacity_1 * sqrt((capped_squared * sine_squared))) * select(1.0f, n111, n111 < 1.0f); // (6)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let carried = sediment + (job.dt_1 * ((n42 - n31) + (n64 - n53))); // (7)
        let load = select(0.0f, carried, 0.0f < carried); // (7)
        let height = state[address(job.from_height, x_0, y_0)];
        let n122 = select(height_w, height_e, height_e < height_w);
        let n123 = select(height_n, height_s, height_s < height_n);
        let lowest = select(n123, n122, n122 < n123);
        let missing = capacity - load; // (7)
        let wish = job.dig_1 * select(0.0f, missing, 0.0f < missing); // (7)
        let n128 = height - lowest;
        let n130 = job.dig_limit_1 * select(0.0f, n128, 0.0f < n128);
        let may_dig = select(n130, wish, wish < n130); // (7)
        let n132 = -(missing);
        let dug = select(may_dig, 0.0f, height < job.sea_1); // (7)
        let settled = select((job.settle_1 * select(0.0f, n132, 0.0f < n132)), load, height < job.sea_1); // (7)
        let n144 = load - (1.1920929e-7f * (abs(height) + load));
        let n145 = select(0.0f, n144, 0.0f < n144);
        let new_height = (height - dug) + select(n145, settled, settled < n145); // (7)
        let n149 = load + (height - new_height);
        let new_load = select(n149, 0.0f, abs(n149) < 1e-30f); // (7)
        let kept = wet * select(job.keep_1, 0.0f, height < job.sea_1); // (8)
        let n156 = select((job.rain_1 * job.dt_1), 0.0f, height < job.sea_1);
        let n157 = kept + n156;
        let new_water = select(n157, 0.0f, abs(n157) < 1e-30f); // (8)
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
            state[address(job.to_flux_x, cx, cy)] = n26;
        }
        if cx >= 0 {
            state[address(job.to_flux_y, cx, cy)] = n49;
        }
        if cx >= 0 && cy >= 0 {
            let lost = wet - kept; // (8)
            let n166 = select(0.0f, select(0.0f, 1.0f, job.speed2_max_1 < speed_squared), job.dry_1 < mean_depth);
            sum_1_0 += (new_water - kept);
            sum_1_1 += select(lost, 0.0f, height < job.sea_1);
            sum_1_2 += select(0.0f, lost, height < job.sea_1);
            sum_1_3 += (wet - moved);
            sum_1_4 += select((wish - may_dig), 0.0f, height < job.sea_1);
            sum_1_5 += n166;
            sum_1_7 += (load - carried);
            if cx == 0 {
                sum_1_2 += (job.dt_1 * (-(n38)));
                sum_1_6 += (job.dt_1 * (-(n42)));
            }
            if cx == job.width - 1 {
                sum_1_2 += (job.dt_1 * n26);
                sum_1_6 += (job.dt_1 * n31);
            }
            if cy == 0 {
                sum_1_2 += (job.dt_1 * (-(n60)));
                sum_1_6 += (job.dt_1 * (-(n64)));
            }
            if cy == job.height - 1 {
                sum_1_2 += (job.dt_1 * n49);
                sum_1_6 += (job.dt_1 * n53);
            }
        }
    }

    // Sums of the tile.
    let number = job.first_group + i32(group.y * groups.x + group.x);
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_1_0, sum_1_1, sum_1_2, sum_1_3);
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
        post(job.account_1_0, total.x, number);
        post(job.account_1_1, total.y, number);
        post(job.account_1_2, total.z, number);
        post(job.account_1_3, total.w, number);
    }
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_1_4, sum_1_5, sum_1_6, sum_1_7);
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
        post(job.account_1_4, total.x, number);
        post(job.account_1_5, total.y, number);
        post(job.account_1_6, total.z, number);
        post(job.account_1_7, total.w, number);
    }
}
