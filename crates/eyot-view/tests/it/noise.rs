//! The noise of shaders is the noise of rays.

use crate::common;
use eyot_noise::picture;

const SIDE: usize = 64;

/// At 4096 places and with as many seeds: the hash to the bit, noise, slopes and octaves within rounding.
#[test]
fn shaders_and_rays_have_the_same_noise() {
    let Some(gpu) = common::gpu() else { return };
    let source = format!(
        "{}\n{}",
        picture::WGSL,
        "
@group(0) @binding(0) var<storage, read_write> out: array<vec4f>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    let cell = vec2i(i32(i % 64u) - 32, i32(i / 64u) - 32);
    let p = vec2f(cell) * 0.375 + 0.0625;
    out[2u * i] = vec4f(noise_with_slope(p, i), fbm(p, 4u, i));
    out[2u * i + 1u] = vec4f(f32(hash(cell.x, cell.y, i) >> 8u), 0.0, 0.0, 0.0);
}"
    );
    let module = gpu.device().create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("noise"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("noise"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let bytes = (SIDE * SIDE * 32) as u64;
    let out = gpu.buffer("noise", bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC).unwrap();
    let bind = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: out.as_entire_binding() }],
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bind, &[]);
        pass.dispatch_workgroups((SIDE * SIDE / 64) as u32, 1, 1);
    }
    gpu.queue().submit([encoder.finish()]);
    let found = gpu.complete(gpu.read(&out, 0, bytes).unwrap()).unwrap();
    let found: Vec<f32> = found.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let (mut worst, mut largest) = (0.0_f32, 0.0_f32);
    for i in 0..SIDE * SIDE {
        let (cx, cy, seed) = ((i % SIDE) as i32 - 32, (i / SIDE) as i32 - 32, i as u32);
        let (x, y) = (cx as f32 * 0.375 + 0.0625, cy as f32 * 0.375 + 0.0625);
        let (value, slope_x, slope_y) = picture::noise_with_slope(x, y, seed);
        assert_eq!(found[8 * i + 4], (picture::hash(cx, cy, seed) >> 8) as f32, "hash of {cx} {cy} {seed}");
        for (k, expected) in [value, slope_x, slope_y, picture::fbm(x, y, 4, seed)].into_iter().enumerate() {
            worst = worst.max((found[8 * i + k] - expected).abs());
            largest = largest.max(expected.abs());
        }
    }
    println!("largest difference {worst:e}, largest value {largest}");
    assert!(worst < 2e-5 && largest > 1.0, "{worst:e} {largest}");
}
