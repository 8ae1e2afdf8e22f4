// wetness_remember: tiles of 32 x 16 cells.

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
    from_flux_x: i32,
    from_flux_y: i32,
    from_flux_se: i32,
    from_flux_sw: i32,
    from_wetness: i32,
    to_wetness: i32,
    half_dx_0: f32,
    half_dy_0: f32,
    per_river_0: f32,
    share_0: f32,
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

    // Rule `wetness_remember`.
    for (var c = thread; c < 512u; c += 256u) {
        let cx = left + i32(c % 32u);
        let cy = top + i32(c / 32u);
        if cx >= job.width || cy >= job.end_row {
            continue;
        }
        let x = wrapped(cx, job.width);
        let y = wrapped(cy, job.height);
        let x_0 = wrapped(cx, job.width);
        let x_m1 = wrapped(cx - 1, job.width);
        let x_p1 = wrapped(cx + 1, job.width);
        let y_0 = wrapped(cy, job.height);
        let y_m1 = wrapped(cy - 1, job.height);
        let flux_se_nw = state[address(job.from_flux_se, x_m1, y_m1)];
        let flux_se = state[address(job.from_flux_se, x_0, y_0)];
        let n6 = flux_se_nw + flux_se;
        let flux_sw_ne = state[address(job.from_flux_sw, x_p1, y_m1)];
        let flux_sw = state[address(job.from_flux_sw, x_0, y_0)];
        let n9 = flux_sw_ne + flux_sw;
        let flux_x_w = state[address(job.from_flux_x, x_m1, y_0)];
        let flux_x = state[address(job.from_flux_x, x_0, y_0)];
        let n15 = job.half_dx_0 * ((flux_x_w + flux_x) + (n6 - n9));
        let flux_y_n = state[address(job.from_flux_y, x_0, y_m1)];
        let flux_y = state[address(job.from_flux_y, x_0, y_0)];
        let n21 = job.half_dy_0 * ((flux_y_n + flux_y) + (n6 + n9));
        let n26 = sqrt(((n15 * n15) + (n21 * n21))) * job.per_river_0;
        let wetness = state[address(job.from_wetness, x_0, y_0)];
        let n32 = wetness + (job.share_0 * (select(1.0f, n26, n26 < 1.0f) - wetness));
        let n36 = select(n32, 0.0f, abs(n32) < 1e-30f);
        state[address(job.to_wetness, cx, cy)] = n36;
    }
}
