//! Pictures of layers where they lie on the card, on a device that a window would own: those of the world that is brought back.

use crate::common;
use crate::draw::{difference, keep};
use eyot_core::layer::known;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Control, Field, Grid, Limits, World};
use eyot_gpu::{Gpu, GpuEngine, GpuError, Options};
use eyot_land::simulate::Thermal;
use eyot_land::simulate::hydraulic::Hydraulic;
use eyot_render::{MapOptions, Picture, ViewOptions};
use eyot_testing::one;
use eyot_view::{Canvas, Renderer, Scene};

const SIZE: [u32; 2] = [320, 180];

/// A device of somebody else, with no more than these limits.
fn guest(limits: wgpu::Limits) -> Option<Gpu> {
    common::gpu()?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (device, queue) = pollster::block_on(async {
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.unwrap();
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        adapter.request_device(&descriptor).await.unwrap()
    });
    Some(Gpu::from_parts(device, queue).unwrap())
}

/// Ridges, 200 m high, without a sea.
fn ridges(width: usize, height: usize) -> World {
    let mut world = World::new(Grid::new(width, height, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
    let field = Field::from_fn(width, height, |x, y| {
        let (x, y) = (x as f32, y as f32);
        300.0 + 60.0 * (0.09 * x).sin() * (0.07 * y).cos() + 25.0 * (0.31 * x + 0.2 * y).sin() + 0.3 * y
    });
    world.put(&known::HEIGHT, field).unwrap();
    world
}

fn erosion() -> Vec<Scheduled> {
    vec![one(Hydraulic { rain: 0.05, ..Default::default() }), one(Thermal::default())]
}

fn options() -> ViewOptions {
    ViewOptions { width: SIZE[0] as usize, height: SIZE[1] as usize, ..ViewOptions::default() }
}

fn simulate(engine: &mut GpuEngine, world: &mut World, from: u64, steps: u64) {
    engine.simulate(world, &erosion(), Span { from, steps }, &Control::none()).unwrap();
}

/// An engine, a renderer and a world after some steps.
fn begun(gpu: Gpu, options: Options, mut world: World) -> (GpuEngine, Renderer, World) {
    let mut engine = GpuEngine::new(gpu, options, None).unwrap();
    let renderer = Renderer::new(engine.gpu()).unwrap();
    simulate(&mut engine, &mut world, 0, 8);
    engine.download(&mut world).unwrap();
    (engine, renderer, world)
}

fn picture(engine: &GpuEngine, renderer: &mut Renderer, scene: &Scene) -> Picture {
    let camera = scene.stage().camera(&options());
    let picture = renderer.draw(engine.gpu(), scene, &camera, SIZE, 0.0).unwrap().take(engine.gpu()).unwrap();
    keep(&picture);
    picture
}

/// A simulation goes on and its picture follows on the card; then the same of the world that is brought back.
fn compare(name: &str, gpu: Gpu, how: Options, world: World, layer: &str) {
    let (mut engine, mut renderer, mut world) = begun(gpu, how, world);
    let colours = MapOptions::default();
    let mut scene = Scene::of_layer(engine.gpu(), &renderer, &world, layer, &options(), &colours).unwrap();
    let old = picture(&engine, &mut renderer, &scene);
    simulate(&mut engine, &mut world, 8, 80);

    let before = engine.work();
    scene.follow(&renderer, &engine).unwrap();
    scene.settled(engine.gpu()).unwrap();
    let work = engine.work().since(before);
    assert_eq!(work.layers_back, 0, "{name}: no layer comes back");
    assert!(work.bytes_back * 8 < 4 * world.grid.cells() as u64, "{name}: {} bytes came back", work.bytes_back);
    let followed = picture(&engine, &mut renderer, &scene);

    engine.download(&mut world).unwrap();
    assert!(engine.work().since(before).layers_back > 0, "{name}: this is counted");
    scene.update(engine.gpu(), &renderer, &world, &["height", layer]).unwrap();
    let updated = picture(&engine, &mut renderer, &scene);
    let (moved, off) = (difference(&old, &followed), difference(&followed, &updated));
    println!("{name}: {moved:.3} of 255 moved, {off:.5} of 255 off, {} bytes came back", work.bytes_back);
    assert!(moved > 0.1, "{name}: the picture moved by {moved}");
    assert!(off < 0.02, "{name}: off by {off}");
}

#[test]
fn a_picture_of_layers_on_the_card_is_that_of_the_world_brought_back() {
    for layer in ["height", "water"] {
        let Some(gpu) = guest(wgpu::Limits::default()) else { return };
        compare(layer, gpu, Options::default(), ridges(256, 200), layer);
    }
}

#[test]
fn grids_in_slabs_are_drawn_without_seams() {
    let Some(gpu) = guest(wgpu::Limits::default()) else { return };
    compare("slabs", gpu, Options::default().most_bytes(1 << 20), ridges(256, 200), "height");
}

#[test]
fn worlds_that_are_too_large_are_averaged_on_the_card() {
    // 2100 cells become 1050, in three slabs.
    let limits = wgpu::Limits { max_texture_dimension_2d: 3072, ..wgpu::Limits::default() };
    let Some(gpu) = guest(limits) else { return };
    compare("coarser", gpu, Options::default().most_bytes(6 << 20), ridges(2100, 60), "height");
}

#[test]
fn rivers_follow_in_natural_colours() {
    let Some(gpu) = guest(wgpu::Limits::default()) else { return };
    let (mut engine, mut renderer, mut world) = begun(gpu, Options::default(), ridges(200, 160));
    let mut scene = Scene::from_world(engine.gpu(), &renderer, &world, &options()).unwrap();
    let camera = scene.stage().camera(&options());
    let mut distances = |engine: &GpuEngine, scene: &Scene| {
        renderer.distances(engine.gpu(), scene, &camera, SIZE).unwrap().take(engine.gpu()).unwrap()
    };
    let old = distances(&engine, &scene);
    simulate(&mut engine, &mut world, 8, 80);
    let other = Renderer::new(engine.gpu()).unwrap();
    scene.follow(&other, &engine).unwrap();
    scene.settled(engine.gpu()).unwrap();
    let followed = distances(&engine, &scene);
    engine.download(&mut world).unwrap();
    scene.update(engine.gpu(), &other, &world, &["height", "water"]).unwrap();
    let updated = distances(&engine, &scene);
    let apart = |a: &[f32], b: &[f32]| {
        let far = |(p, q): &(&f32, &f32)| (*p - *q).abs() > 1e-3 * p.min(**q);
        a.iter().zip(b).filter(|(p, q)| p.is_finite() && q.is_finite()).filter(far).count()
    };
    let (moved, off) = (apart(&old, &followed), apart(&followed, &updated));
    println!("{moved} pixels moved, {off} are off");
    assert!(moved > 100 && off * 1000 < updated.len(), "{moved} pixels moved, {off} are off");
}

#[test]
fn other_worlds_and_layers_are_refused() {
    let Some(gpu) = guest(wgpu::Limits::default()) else { return };
    let (mut engine, renderer, world) = begun(gpu, Options::default(), ridges(64, 48));
    let mut other = Scene::from_world(engine.gpu(), &renderer, &ridges(65, 48), &options()).unwrap();
    let e = other.follow(&renderer, &engine).unwrap_err();
    assert!(matches!(&e, GpuError::Core(_)) && e.to_string().contains("65x48"), "{e}");
    engine.release();
    let mut scene = Scene::from_world(engine.gpu(), &renderer, &world, &options()).unwrap();
    let e = scene.follow(&renderer, &engine).unwrap_err();
    assert!(e.to_string().contains("missing"), "{e}");
}

#[test]
fn a_hosts_own_texture_gets_the_same_picture() {
    let Some(gpu) = guest(wgpu::Limits::default()) else { return };
    let (engine, mut renderer, world) = begun(gpu, Options::default(), ridges(96, 64));
    let gpu = engine.gpu();
    let scene = Scene::from_world(gpu, &renderer, &world, &options()).unwrap();
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("a window"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let canvas = Canvas::new(&view, wgpu::TextureFormat::Rgba8Unorm, SIZE);
    let before = engine.work();
    renderer.paint(gpu, &scene, &scene.stage().camera(&options()), 0.0, &canvas).unwrap();
    assert_eq!(engine.work().since(before).bytes_back, 0);

    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let shown = gpu.buffer("what the window shows", u64::from(4 * SIZE[0] * SIZE[1]), usage).unwrap();
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE[0]), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &shown, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    gpu.queue().submit([encoder.finish()]);
    let bytes = gpu.complete(gpu.read_mapped(shown)).unwrap();
    let pixels: Vec<[u8; 3]> = bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect();
    assert!(pixels == picture(&engine, &mut renderer, &scene).pixels);
}
