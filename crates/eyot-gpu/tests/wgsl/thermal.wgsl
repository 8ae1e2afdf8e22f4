// thermal_slump: tiles of 32 x 16 cells.

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
    to_height: i32,
    stay_x_0: f32,
    stay_y_0: f32,
    stay_d_0: f32,
    rate_0: f32,
    rate_d_0: f32,
    account_0_0: i32,
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

    // Rule `thermal_slump`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx < 0 || cx >= job.width || cy < 0 || cy >= job.end_row {
            continue;
        }
        let x = cx;
        let y = cy;
        let x_0 = cx;
        let x_m1 = max(cx - 1, 0);
        let x_p1 = min(cx + 1, job.width - 1);
        let y_0 = cy;
        let y_m1 = max(cy - 1, 0);
        let y_p1 = min(cy + 1, job.height - 1);
        let height_e = state[address(job.from_height, x_p1, y_0)];
        let height = state[address(job.from_height, x_0, y_0)];
        let n7 = height_e - height;
        let n8 = -(job.stay_x_0);
        let n9 = select(n8, n7, n8 < n7);
        let height_w = state[address(job.from_height, x_m1, y_0)];
        let n13 = height_w - height;
        let n14 = select(n8, n13, n8 < n13);
        let n17 = (n7 - select(job.stay_x_0, n9, n9 < job.stay_x_0)) + (n13 - select(job.stay_x_0, n14, n14 < job.stay_x_0));
        let height_s = state[address(job.from_height, x_0, y_p1)];
        let n19 = height_s - height;
        let n20 = -(job.stay_y_0);
        let n21 = select(n20, n19, n20 < n19);
        let height_n = state[address(job.from_height, x_0, y_m1)];
        let n25 = height_n - height;
        let n26 = select(n20, n25, n20 < n25);
        let n29 = (n19 - select(job.stay_y_0, n21, n21 < job.stay_y_0)) + (n25 - select(job.stay_y_0, n26, n26 < job.stay_y_0));
        let height_se = state[address(job.from_height, x_p1, y_p1)];
        let n31 = height_se - height;
        let n32 = -(job.stay_d_0);
        let n33 = select(n32, n31, n32 < n31);
        let height_nw = state[address(job.from_height, x_m1, y_m1)];
        let n37 = height_nw - height;
        let n38 = select(n32, n37, n32 < n37);
        let n41 = (n31 - select(job.stay_d_0, n33, n33 < job.stay_d_0)) + (n37 - select(job.stay_d_0, n38, n38 < job.stay_d_0));
        let height_sw = state[address(job.from_height, x_m1, y_p1)];
        let n43 = height_sw - height;
        let n44 = select(n32, n43, n32 < n43);
        let height_ne = state[address(job.from_height, x_p1, y_m1)];
        let n48 = height_ne - height;
        let n49 = select(n32, n48, n32 < n48);
        let n52 = (n43 - select(job.stay_d_0, n44, n44 < job.stay_d_0)) + (n48 - select(job.stay_d_0, n49, n49 < job.stay_d_0));
        let gain = rounded((job.rate_0 * (n17 + n29))) + rounded((job.rate_d_0 * (n41 + n52))); // (1)
        let slumped = rounded((height + gain)); // (1)
        state[address(job.to_height, cx, cy)] = slumped;
        {
            sum_0_0 += ((slumped - height) - gain);
        }
    }

    // Sums of the tile.
    let number = job.first_group + i32(group.y * groups.x + group.x);
    workgroupBarrier();
    parts[thread] = vec4<f32>(sum_0_0, 0.0, 0.0, 0.0);
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
    }
}
