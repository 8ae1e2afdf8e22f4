//! What a window does, through this crate alone: it owns the device, engine and view are its guests, and what is drawn is what lies on
//! the card.

use crate::common;
use eyot::engines::{self, Gpu, wgpu};
use eyot::session::{Budget, Clock, Host, Memory, Session, SessionOptions, Status};
use eyot::view::{Picture, Renderer, Scene, ViewOptions};
use eyot::{Command, EngineChoice, EngineOptions, Registry};
use std::sync::Arc;

const RIDGES: &str = r#"
name = "Ridges"
[grid]
size = [48, 40]
cell = 20.0
[[step]]
generate = "fbm"
amplitude = 200.0
[[step]]
simulate = ["thermal"]
steps = 100
thermal.talus = 5.0
"#;

/// The device of a window.
fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let opened = pollster::block_on(async {
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.ok()?;
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        adapter.request_device(&descriptor).await.ok()
    });
    assert!(opened.is_some() || std::env::var_os("EYOT_REQUIRE_GPU").is_none(), "no device");
    opened
}

#[test]
fn a_window_draws_a_running_world_where_it_lies() {
    let Some((device, queue)) = device() else { return eprintln!("skipped: no device") };
    let guest = move || Gpu::from_parts(device.clone(), queue.clone());
    let gpu = Arc::new(guest().unwrap());
    let open = move |_: &EngineOptions, limits| engines::polled(guest()?, limits);
    let host = Host::new(&Registry::standard(), Clock::system()).with_storage(Memory::new()).with_engines(open);
    let engine = EngineOptions { choice: EngineChoice::Gpu, ..EngineOptions::default() };
    let options = SessionOptions { paused: true, engine: Some(engine), ..SessionOptions::default() };
    let mut session = Session::new(common::recipe(RIDGES, &[]), options, host).unwrap();
    let steps = |session: &mut Session, n: u64| {
        session.command(Command::Step(n));
        while !matches!(session.advance(Budget::Piece).unwrap(), Status::Paused | Status::Finished) {
            std::thread::yield_now();
        }
    };
    // The generator counts as one.
    steps(&mut session, 2);
    let mut renderer = Renderer::new(&gpu).unwrap();
    let view = ViewOptions { width: 160, height: 90, ..ViewOptions::default() };
    let mut scene = Scene::from_world(&gpu, &renderer, session.world(), &view).unwrap();
    let camera = scene.stage().camera(&view);
    let draw = |renderer: &mut Renderer, scene: &Scene| -> Picture {
        renderer.draw(&gpu, scene, &camera, [160, 90], 0.0).unwrap().take(&gpu).unwrap()
    };
    let before = draw(&mut renderer, &scene);
    assert!(before.pixels.iter().any(|p| *p != before.pixels[0]), "an empty picture");
    steps(&mut session, 60);
    let engine = engines::on_card(session.engine()).expect("the card works");
    scene.follow(&renderer, engine).unwrap();
    let after = draw(&mut renderer, &scene);
    let differ = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 8);
    let moved = before.pixels.iter().zip(&after.pixels).filter(|(a, b)| differ(a, b)).count();
    assert!(moved > before.pixels.len() / 50, "{moved} of {} pixels moved", before.pixels.len());
}
