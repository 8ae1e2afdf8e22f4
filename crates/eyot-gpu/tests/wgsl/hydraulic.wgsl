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
        let n6 = select(job.sea_0, height, job.sea_0 < height);
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = n6 + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let n10 = job.keep_0 * flux_x;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let n12 = select(job.sea_0, height_e, job.sea_0 < height_e);
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n14 = n12 + water_e;
        let n15 = head - n14;
        let n16 = job.push_x_0 * n15;
        let east = n10 + n16; // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let n19 = job.keep_0 * flux_x_w;
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let n21 = select(job.sea_0, height_w, job.sea_0 < height_w);
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n23 = n21 + water_w;
        let n24 = n23 - head;
        let n25 = job.push_x_0 * n24;
        let west = n19 + n25; // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let n28 = job.keep_0 * flux_y;
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let n30 = select(job.sea_0, height_s, job.sea_0 < height_s);
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n32 = n30 + water_s;
        let n33 = head - n32;
        let n34 = job.push_y_0 * n33;
        let south = n28 + n34; // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let n37 = job.keep_0 * flux_y_n;
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let n39 = select(job.sea_0, height_n, job.sea_0 < height_n);
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n41 = n39 + water_n;
        let n42 = n41 - head;
        let n43 = job.push_y_0 * n42;
        let north = n37 + n43; // (1)
        let n46 = select(0.0f, east, 0.0f < east);
        let n47 = select(0.0f, west, west < 0.0f);
        let n48 = n46 - n47;
        let n49 = select(0.0f, south, 0.0f < south);
        let n50 = select(0.0f, north, north < 0.0f);
        let n51 = n49 - n50;
        let out = n48 + n51;
        let n53 = job.dt_0 * out;
        let n54 = water / n53;
        let afford = select(1.0f, n54, water < n53); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n59 = select(1e-6f, water, 1e-6f < water);
        let n60 = sediment / n59;
        let n61 = abs(east);
        let n63 = select(east, 0.0f, n61 < 1e-30f);
        let n64 = abs(south);
        let n65 = select(south, 0.0f, n64 < 1e-30f);
        let n66 = afford * n60;
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
        let n23 = n20 * afford;
        let afford_e = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n25 = n21 * afford_e;
        let n26 = n23 + n25;
        let afford_sediment = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let n28 = n20 * afford_sediment;
        let afford_sediment_e = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n30 = n21 * afford_sediment_e;
        let n31 = n28 + n30;
        let raw_x_w = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_m1_face - left + 1)], x_m1_face_inside && y_0_inside);
        let n33 = select(0.0f, raw_x_w, 0.0f < raw_x_w);
        let n34 = select(0.0f, raw_x_w, raw_x_w < 0.0f);
        let afford_w = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n36 = n33 * afford_w;
        let n37 = n34 * afford;
        let n38 = n36 + n37;
        let afford_sediment_w = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n40 = n33 * afford_sediment_w;
        let n41 = n34 * afford_sediment;
        let n42 = n40 + n41;
        let raw_y = select(0.0, tile_0_raw_y[(y_0_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside);
        let n44 = select(0.0f, raw_y, 0.0f < raw_y);
        let n45 = select(0.0f, raw_y, raw_y < 0.0f);
        let n46 = n44 * afford;
        let afford_s = select(0.0, tile_0_afford[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n48 = n45 * afford_s;
        let n49 = n46 + n48;
        let n50 = n44 * afford_sediment;
        let afford_sediment_s = select(0.0, tile_0_afford_sediment[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n52 = n45 * afford_sediment_s;
        let n53 = n50 + n52;
        let raw_y_n = select(0.0, tile_0_raw_y[(y_m1_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_face_inside);
        let n55 = select(0.0f, raw_y_n, 0.0f < raw_y_n);
        let n56 = select(0.0f, raw_y_n, raw_y_n < 0.0f);
        let afford_n = select(0.0, tile_0_afford[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n58 = n55 * afford_n;
        let n59 = n56 * afford;
        let n60 = n58 + n59;
        let afford_sediment_n = select(0.0, tile_0_afford_sediment[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n62 = n55 * afford_sediment_n;
        let n63 = n56 * afford_sediment;
        let n64 = n62 + n63;
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let n66 = n38 - n26;
        let n67 = n60 - n49;
        let n68 = n66 + n67;
        let n69 = job.dt_1 * n68;
        let moved = water + n69; // (3)
        let n71 = select(0.0f, moved, 0.0f < moved);
        let n73 = water + n71;
        let n74 = 0.5f * n73;
        let n75 = 0.5f * job.dx_1;
        let n76 = n38 + n26;
        let n77 = n75 * n76;
        let n78 = 0.5f * job.dy_1;
        let n79 = n60 + n49;
        let n80 = n78 * n79;
        let n81 = n77 * n77;
        let n82 = n80 * n80;
        let n83 = n81 + n82;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let n86 = height_e - height_w;
        let n87 = job.slope_x_1 * n86;
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let n90 = height_s - height_n;
        let n91 = job.slope_y_1 * n90;
        let n92 = n87 * n87;
        let n93 = n91 * n91;
        let n94 = n92 + n93;
        let n95 = select(job.dry_1, n74, job.dry_1 < n74);
        let n96 = n95 * n95;
        let n97 = 1.0f + n94;
        let n98 = n96 * n97;
        let n99 = 1.0f / n98;
        let n100 = n83 * n97;
        let speed_squared = n100 * n99; // (4)
        let n102 = n94 * n96;
        let n103 = n102 * n99;
        let n104 = select(job.sine2_min_1, n103, job.sine2_min_1 < n103);
        let sine_squared = select(job.sine2_max_1, n104, n104 < job.sine2_max_1); // (5)
        let n106 = select(job.speed2_max_1, speed_squared, speed_squared < job.speed2_max_1);
        let n107 = select(0.0f, n106, job.dry_1 < n74);
        let n108 = n107 * sine_squared;
        let n109 = sqrt(n108);
        let n110 = job.capacity_1 * n109;
        let n111 = n74 * job.ramp_1;
        let n112 = select(1.0f, n111, n111 < 1.0f);
        let capacity = n110 * n112; // (6)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n115 = n42 - n31;
        let n116 = n64 - n53;
        let n117 = n115 + n116;
        let n118 = job.dt_1 * n117;
        let carried = sediment + n118; // (7)
        let n120 = select(0.0f, carried, 0.0f < carried);
        let height = state[address(job.from_height, x_0, y_0)];
        let n122 = select(height_w, height_e, height_e < height_w);
        let n123 = select(height_n, height_s, height_s < height_n);
        let n124 = select(n123, n122, n122 < n123);
        let n125 = capacity - n120;
        let n126 = select(0.0f, n125, 0.0f < n125);
        let n127 = job.dig_1 * n126;
        let n128 = height - n124;
        let n129 = select(0.0f, n128, 0.0f < n128);
        let n130 = job.dig_limit_1 * n129;
        let n131 = select(n130, n127, n127 < n130);
        let n132 = -(n125);
        let n133 = select(0.0f, n132, 0.0f < n132);
        let n134 = job.settle_1 * n133;
        let n137 = select(n131, 0.0f, height < job.sea_1);
        let n138 = select(n134, n120, height < job.sea_1);
        let n139 = height - n137;
        let n141 = abs(height);
        let n142 = n141 + n120;
        let n143 = 1.1920929e-7f * n142;
        let n144 = n120 - n143;
        let n145 = select(0.0f, n144, 0.0f < n144);
        let n146 = select(n145, n138, n138 < n145);
        let new_height = n139 + n146; // (7)
        let n148 = height - new_height;
        let n149 = n120 + n148;
        let n150 = abs(n149);
        let new_load = select(n149, 0.0f, n150 < 1e-30f); // (7)
        let n153 = select(job.keep_1, 0.0f, height < job.sea_1);
        let n154 = n71 * n153;
        let n155 = job.rain_1 * job.dt_1;
        let n156 = select(n155, 0.0f, height < job.sea_1);
        let n157 = n154 + n156;
        let n158 = abs(n157);
        let new_water = select(n157, 0.0f, n158 < 1e-30f); // (8)
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
            let n135 = n127 - n131;
            let n136 = select(n135, 0.0f, height < job.sea_1);
            let n160 = n71 - n154;
            let n161 = new_water - n154;
            let n162 = select(n160, 0.0f, height < job.sea_1);
            let n163 = select(0.0f, n160, height < job.sea_1);
            let n164 = n71 - moved;
            let n165 = select(0.0f, 1.0f, job.speed2_max_1 < speed_squared);
            let n166 = select(0.0f, n165, job.dry_1 < n74);
            let n167 = n120 - carried;
            sum_1_0 += n161;
            sum_1_1 += n162;
            sum_1_2 += n163;
            sum_1_3 += n164;
            sum_1_4 += n136;
            sum_1_5 += n166;
            sum_1_7 += n167;
            if cx == 0 {
                let n168 = -(n38);
                let n169 = -(n42);
                let n170 = job.dt_1 * n168;
                let n171 = job.dt_1 * n169;
                sum_1_2 += n170;
                sum_1_6 += n171;
            }
            if cx == job.width - 1 {
                let n172 = job.dt_1 * n26;
                let n173 = job.dt_1 * n31;
                sum_1_2 += n172;
                sum_1_6 += n173;
            }
            if cy == 0 {
                let n174 = -(n60);
                let n175 = -(n64);
                let n176 = job.dt_1 * n174;
                let n177 = job.dt_1 * n175;
                sum_1_2 += n176;
                sum_1_6 += n177;
            }
            if cy == job.height - 1 {
                let n178 = job.dt_1 * n49;
                let n179 = job.dt_1 * n53;
                sum_1_2 += n178;
                sum_1_6 += n179;
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
        let n6 = select(job.sea_0, height, job.sea_0 < height);
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let head = n6 + water;
        let flux_x = select(0.0, state[address(job.from_flux_x, x_0_face, y_0)], y_0_inside);
        let n10 = job.keep_0 * flux_x;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let n12 = select(job.sea_0, height_e, job.sea_0 < height_e);
        let water_e = select(0.0, state[address(job.from_water, x_p1, y_0)], x_p1_inside && y_0_inside);
        let n14 = n12 + water_e;
        let n15 = head - n14;
        let n16 = job.push_x_0 * n15;
        let east = n10 + n16; // (1)
        let flux_x_w = select(0.0, state[address(job.from_flux_x, x_m1_face, y_0)], x_m1_face_inside && y_0_inside);
        let n19 = job.keep_0 * flux_x_w;
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let n21 = select(job.sea_0, height_w, job.sea_0 < height_w);
        let water_w = select(0.0, state[address(job.from_water, x_m1, y_0)], x_m1_inside && y_0_inside);
        let n23 = n21 + water_w;
        let n24 = n23 - head;
        let n25 = job.push_x_0 * n24;
        let west = n19 + n25; // (1)
        let flux_y = select(0.0, state[address(job.from_flux_y, x_0, y_0_face)], x_0_inside);
        let n28 = job.keep_0 * flux_y;
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let n30 = select(job.sea_0, height_s, job.sea_0 < height_s);
        let water_s = select(0.0, state[address(job.from_water, x_0, y_p1)], x_0_inside && y_p1_inside);
        let n32 = n30 + water_s;
        let n33 = head - n32;
        let n34 = job.push_y_0 * n33;
        let south = n28 + n34; // (1)
        let flux_y_n = select(0.0, state[address(job.from_flux_y, x_0, y_m1_face)], x_0_inside && y_m1_face_inside);
        let n37 = job.keep_0 * flux_y_n;
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let n39 = select(job.sea_0, height_n, job.sea_0 < height_n);
        let water_n = select(0.0, state[address(job.from_water, x_0, y_m1)], x_0_inside && y_m1_inside);
        let n41 = n39 + water_n;
        let n42 = n41 - head;
        let n43 = job.push_y_0 * n42;
        let north = n37 + n43; // (1)
        let n46 = select(0.0f, east, 0.0f < east);
        let n47 = select(0.0f, west, west < 0.0f);
        let n48 = n46 - n47;
        let n49 = select(0.0f, south, 0.0f < south);
        let n50 = select(0.0f, north, north < 0.0f);
        let n51 = n49 - n50;
        let out = n48 + n51;
        let n53 = job.dt_0 * out;
        let n54 = water / n53;
        let afford = select(1.0f, n54, water < n53); // (2)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n59 = select(1e-6f, water, 1e-6f < water);
        let n60 = sediment / n59;
        let n61 = abs(east);
        let n63 = select(east, 0.0f, n61 < 1e-30f);
        let n64 = abs(south);
        let n65 = select(south, 0.0f, n64 < 1e-30f);
        let n66 = afford * n60;
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
        let n23 = n20 * afford;
        let afford_e = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n25 = n21 * afford_e;
        let n26 = n23 + n25;
        let afford_sediment = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_0_inside);
        let n28 = n20 * afford_sediment;
        let afford_sediment_e = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_p1 - left + 1)], x_p1_inside && y_0_inside);
        let n30 = n21 * afford_sediment_e;
        let n31 = n28 + n30;
        let raw_x_w = select(0.0, tile_0_raw_x[(y_0 - top + 1) * 34 + (x_m1_face - left + 1)], x_m1_face_inside && y_0_inside);
        let n33 = select(0.0f, raw_x_w, 0.0f < raw_x_w);
        let n34 = select(0.0f, raw_x_w, raw_x_w < 0.0f);
        let afford_w = select(0.0, tile_0_afford[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n36 = n33 * afford_w;
        let n37 = n34 * afford;
        let n38 = n36 + n37;
        let afford_sediment_w = select(0.0, tile_0_afford_sediment[(y_0 - top + 1) * 34 + (x_m1 - left + 1)], x_m1_inside && y_0_inside);
        let n40 = n33 * afford_sediment_w;
        let n41 = n34 * afford_sediment;
        let n42 = n40 + n41;
        let raw_y = select(0.0, tile_0_raw_y[(y_0_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside);
        let n44 = select(0.0f, raw_y, 0.0f < raw_y);
        let n45 = select(0.0f, raw_y, raw_y < 0.0f);
        let n46 = n44 * afford;
        let afford_s = select(0.0, tile_0_afford[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n48 = n45 * afford_s;
        let n49 = n46 + n48;
        let n50 = n44 * afford_sediment;
        let afford_sediment_s = select(0.0, tile_0_afford_sediment[(y_p1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_p1_inside);
        let n52 = n45 * afford_sediment_s;
        let n53 = n50 + n52;
        let raw_y_n = select(0.0, tile_0_raw_y[(y_m1_face - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_face_inside);
        let n55 = select(0.0f, raw_y_n, 0.0f < raw_y_n);
        let n56 = select(0.0f, raw_y_n, raw_y_n < 0.0f);
        let afford_n = select(0.0, tile_0_afford[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n58 = n55 * afford_n;
        let n59 = n56 * afford;
        let n60 = n58 + n59;
        let afford_sediment_n = select(0.0, tile_0_afford_sediment[(y_m1 - top + 1) * 34 + (x_0 - left + 1)], x_0_inside && y_m1_inside);
        let n62 = n55 * afford_sediment_n;
        let n63 = n56 * afford_sediment;
        let n64 = n62 + n63;
        let water = select(0.0, state[address(job.from_water, x_0, y_0)], x_0_inside && y_0_inside);
        let n66 = n38 - n26;
        let n67 = n60 - n49;
        let n68 = n66 + n67;
        let n69 = job.dt_1 * n68;
        let moved = water + n69; // (3)
        let n71 = select(0.0f, moved, 0.0f < moved);
        let n73 = water + n71;
        let n74 = 0.5f * n73;
        let n75 = 0.5f * job.dx_1;
        let n76 = n38 + n26;
        let n77 = n75 * n76;
        let n78 = 0.5f * job.dy_1;
        let n79 = n60 + n49;
        let n80 = n78 * n79;
        let n81 = n77 * n77;
        let n82 = n80 * n80;
        let n83 = n81 + n82;
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let n86 = height_e - height_w;
        let n87 = job.slope_x_1 * n86;
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let n90 = height_s - height_n;
        let n91 = job.slope_y_1 * n90;
        let n92 = n87 * n87;
        let n93 = n91 * n91;
        let n94 = n92 + n93;
        let n95 = select(job.dry_1, n74, job.dry_1 < n74);
        let n96 = n95 * n95;
        let n97 = 1.0f + n94;
        let n98 = n96 * n97;
        let n99 = 1.0f / n98;
        let n100 = n83 * n97;
        let speed_squared = n100 * n99; // (4)
        let n102 = n94 * n96;
        let n103 = n102 * n99;
        let n104 = select(job.sine2_min_1, n103, job.sine2_min_1 < n103);
        let sine_squared = select(job.sine2_max_1, n104, n104 < job.sine2_max_1); // (5)
        let n106 = select(job.speed2_max_1, speed_squared, speed_squared < job.speed2_max_1);
        let n107 = select(0.0f, n106, job.dry_1 < n74);
        let n108 = n107 * sine_squared;
        let n109 = sqrt(n108);
        let n110 = job.capacity_1 * n109;
        let n111 = n74 * job.ramp_1;
        let n112 = select(1.0f, n111, n111 < 1.0f);
        let capacity = n110 * n112; // (6)
        let sediment = select(0.0, state[address(job.from_sediment, x_0, y_0)], x_0_inside && y_0_inside);
        let n115 = n42 - n31;
        let n116 = n64 - n53;
        let n117 = n115 + n116;
        let n118 = job.dt_1 * n117;
        let carried = sediment + n118; // (7)
        let n120 = select(0.0f, carried, 0.0f < carried);
        let height = state[address(job.from_height, x_0, y_0)];
        let n122 = select(height_w, height_e, height_e < height_w);
        let n123 = select(height_n, height_s, height_s < height_n);
        let n124 = select(n123, n122, n122 < n123);
        let n125 = capacity - n120;
        let n126 = select(0.0f, n125, 0.0f < n125);
        let n127 = job.dig_1 * n126;
        let n128 = height - n124;
        let n129 = select(0.0f, n128, 0.0f < n128);
        let n130 = job.dig_limit_1 * n129;
        let n131 = select(n130, n127, n127 < n130);
        let n132 = -(n125);
        let n133 = select(0.0f, n132, 0.0f < n132);
        let n134 = job.settle_1 * n133;
        let n137 = select(n131, 0.0f, height < job.sea_1);
        let n138 = select(n134, n120, height < job.sea_1);
        let n139 = height - n137;
        let n141 = abs(height);
        let n142 = n141 + n120;
        let n143 = 1.1920929e-7f * n142;
        let n144 = n120 - n143;
        let n145 = select(0.0f, n144, 0.0f < n144);
        let n146 = select(n145, n138, n138 < n145);
        let new_height = n139 + n146; // (7)
        let n148 = height - new_height;
        let n149 = n120 + n148;
        let n150 = abs(n149);
        let new_load = select(n149, 0.0f, n150 < 1e-30f); // (7)
        let n153 = select(job.keep_1, 0.0f, height < job.sea_1);
        let n154 = n71 * n153;
        let n155 = job.rain_1 * job.dt_1;
        let n156 = select(n155, 0.0f, height < job.sea_1);
        let n157 = n154 + n156;
        let n158 = abs(n157);
        let new_water = select(n157, 0.0f, n158 < 1e-30f); // (8)
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
            let n135 = n127 - n131;
            let n136 = select(n135, 0.0f, height < job.sea_1);
            let n160 = n71 - n154;
            let n161 = new_water - n154;
            let n162 = select(n160, 0.0f, height < job.sea_1);
            let n163 = select(0.0f, n160, height < job.sea_1);
            let n164 = n71 - moved;
            let n165 = select(0.0f, 1.0f, job.speed2_max_1 < speed_squared);
            let n166 = select(0.0f, n165, job.dry_1 < n74);
            let n167 = n120 - carried;
            sum_1_0 += n161;
            sum_1_1 += n162;
            sum_1_2 += n163;
            sum_1_3 += n164;
            sum_1_4 += n136;
            sum_1_5 += n166;
            sum_1_7 += n167;
            if cx == 0 {
                let n168 = -(n38);
                let n169 = -(n42);
                let n170 = job.dt_1 * n168;
                let n171 = job.dt_1 * n169;
                sum_1_2 += n170;
                sum_1_6 += n171;
            }
            if cx == job.width - 1 {
                let n172 = job.dt_1 * n26;
                let n173 = job.dt_1 * n31;
                sum_1_2 += n172;
                sum_1_6 += n173;
            }
            if cy == 0 {
                let n174 = -(n60);
                let n175 = -(n64);
                let n176 = job.dt_1 * n174;
                let n177 = job.dt_1 * n175;
                sum_1_2 += n176;
                sum_1_6 += n177;
            }
            if cy == job.height - 1 {
                let n178 = job.dt_1 * n49;
                let n179 = job.dt_1 * n53;
                sum_1_2 += n178;
                sum_1_6 += n179;
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
