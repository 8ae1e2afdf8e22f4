//! Sessions whose engine must not be waited for, as in a browser: the bytes of a run, asked for again and again.

use crate::common;
use eyot::engines::{self, Gpu};
use eyot::session::{Budget, Clock, Host, Memory, OpenEngine, Opened, Session, SessionOptions, Status};
use eyot::{Change, Command, EngineChoice, EngineOptions, Event, JournalEntry, Limits, Outcome, Record, Registry};
use eyot_core::engine::{CpuEngine, CpuRunner, DeviceError, Engine, Hesitant};
use eyot_gpu::{GpuEngine, Options as GpuOptions};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// Rules alone, an action that cannot fail, and one whose steps are taken back if it does.
const RIVERS: &str = r#"
name = "Rivers"
[grid]
size = [40, 32]
cell = 20.0
[[step]]
generate = "fbm"
amplitude = 120.0
[[step]]
simulate = ["hydraulic", "streampower"]
steps = 60
streampower.every = 7
[[step]]
generate = "smooth"
[[step]]
simulate = ["thermal"]
steps = 20
"#;

struct Cpu(Hesitant<CpuRunner>);

impl OpenEngine for Cpu {
    fn engine(&self) -> &dyn Engine {
        &self.0
    }

    fn engine_mut(&mut self) -> &mut dyn Engine {
        &mut self.0
    }
}

fn hesitant(_: &EngineOptions, limits: Limits) -> Result<Opened, DeviceError> {
    let engine = CpuEngine { limits, ..CpuEngine::default() };
    Ok(Opened { engine: Box::new(Cpu(Hesitant::new(engine.runner()))), warning: None })
}

/// Frames and looks that cut the steps, a checkpoint after each chunk, and a change by hand.
fn options() -> SessionOptions {
    SessionOptions {
        checkpoint_every: Duration::ZERO,
        record: Some(Record { every: 16, max_bytes: 1 << 30 }),
        replay: vec![JournalEntry { recipe_step: 2, step: 24, set: "hydraulic.rain=0.01".to_owned() }],
        engine: Some(EngineOptions { choice: EngineChoice::Auto, ..EngineOptions::default() }),
        chunk: Some(8),
        ..SessionOptions::default()
    }
}

fn session(host: Host, options: SessionOptions) -> Session {
    Session::new(common::recipe(RIVERS, &[]), options, host).unwrap()
}

fn host(memory: &Memory) -> Host {
    Host::new(&Registry::standard(), Clock::system()).with_storage(memory.clone())
}

/// Asks until the session waits for a command or ends; how often it waited for its engine.
fn poll(s: &mut Session) -> (u32, Status) {
    let mut waited = 0;
    loop {
        match s.advance(Budget::Time(Duration::from_millis(50))).unwrap() {
            Status::Waiting => waited += 1,
            Status::Working => {}
            status => return (waited, status),
        }
        std::thread::yield_now();
    }
}

fn whole(host: Host) -> (u32, Outcome) {
    let mut s = session(host, options());
    let (waited, status) = poll(&mut s);
    assert_eq!(status, Status::Finished);
    assert!(!s.events().iter().any(|e| matches!(e, Event::Warning { .. })));
    (waited, s.into_outcome().unwrap())
}

/// Steps of the world that was last shown.
fn seen(s: &mut Session) -> u64 {
    let world = |e| if let Event::Snapshot { world, .. } = e { Some(world) } else { None };
    s.events().into_iter().find_map(world).unwrap().step
}

fn frames(memory: &Memory) -> Vec<String> {
    memory.names().into_iter().filter(|n| n.starts_with("timeline.zarr")).collect()
}

#[test]
fn a_session_that_waits_for_its_engine_makes_the_same_bytes() {
    let (straight, polled) = (Memory::new(), Memory::new());
    let (none, one) = whole(host(&straight));
    let (waited, other) = whole(host(&polled).with_engines(hesitant));
    assert!(none == 0 && waited > 40, "{waited}");
    assert_eq!((one.fingerprint, &one.world), (other.fingerprint, &other.world));
    assert_eq!(frames(&straight), frames(&polled));
}

#[test]
fn commands_reach_a_session_that_waits_for_its_engine() {
    let (_, straight) = whole(host(&Memory::new()));
    let memory = Memory::new();
    let mut s = session(host(&memory).with_engines(hesitant), SessionOptions { paused: true, ..options() });
    let paused = |s: &mut Session| assert_eq!(poll(s).1, Status::Paused);
    paused(&mut s);
    s.command(Command::Step(33));
    paused(&mut s);
    s.events();
    s.command(Command::Snapshot);
    paused(&mut s);
    // A generator counts as one.
    assert_eq!(seen(&mut s), 32);
    s.command(Command::Rewind { step: 20, forget: false });
    s.command(Command::Snapshot);
    paused(&mut s);
    assert_eq!(seen(&mut s), 16);
    // Stopped in the midst of a chunk, and resumed.
    s.command(Command::Step(20));
    assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Waiting);
    s.command(Command::Stop);
    assert_eq!(poll(&mut s).1, Status::Stopped);
    let options = SessionOptions { replay: Vec::new(), ..options() };
    let mut s = Session::resume(options, host(&memory).with_engines(hesitant)).unwrap();
    s.command(Command::Change(Change::new("hydraulic.rian", 0.5)));
    assert_eq!(poll(&mut s).1, Status::Finished);
    assert_eq!(s.into_outcome().unwrap().fingerprint, straight.fingerprint);
}

#[test]
fn a_run_goes_on_with_an_engine_that_it_must_not_wait_for() {
    let (_, straight) = whole(host(&Memory::new()));
    let options = eyot::RunOptions { replay: options().replay, chunk: Some(8), ..eyot::RunOptions::default() };
    let host = host(&Memory::new()).with_engines(hesitant);
    let run = eyot_session::Run::start(common::recipe(RIVERS, &[]), options, &host).unwrap();
    assert_eq!(run.join().unwrap().fingerprint, straight.fingerprint);
}

/// A card, and how often somebody has waited for it.
struct Card(GpuEngine, Arc<AtomicU64>);

impl OpenEngine for Card {
    fn engine(&self) -> &dyn Engine {
        &self.0
    }

    fn engine_mut(&mut self) -> &mut dyn Engine {
        self.1.store(self.0.work().waits, Relaxed);
        &mut self.0
    }
}

#[test]
fn a_session_on_a_card_never_waits_for_it_and_makes_the_same_bytes() {
    let asked = EngineOptions { choice: EngineChoice::Gpu, ..EngineOptions::default() };
    let gpu = match eyot_gpu::blocking::open(&engines::adapter(&asked)) {
        Ok(gpu) => gpu,
        Err(e) => {
            assert!(std::env::var_os("EYOT_REQUIRE_GPU").is_none(), "{e}");
            return eprintln!("skipped: {e}");
        }
    };
    let gpu = Arc::new(gpu);
    let guest = move || Gpu::from_parts(gpu.device().clone(), gpu.queue().clone());
    let counted = |polled: bool| {
        let (waits, guest) = (Arc::new(AtomicU64::new(0)), guest.clone());
        let count = Arc::clone(&waits);
        let open = move |_: &EngineOptions, limits| {
            let engine = GpuEngine::new(guest()?, GpuOptions::default().limits(limits).polled(polled), None)?;
            Ok(Opened { engine: Box::new(Card(engine, count.clone())), warning: None })
        };
        let (waited, outcome) = whole(host(&Memory::new()).with_engines(open));
        (waited, waits.load(Relaxed), outcome)
    };
    let (none, blocked, straight) = counted(false);
    assert!(none == 0 && blocked > 0, "{none} {blocked}");
    let (waited, blocked, polled) = counted(true);
    println!("asked again {waited} times");
    assert!(waited > 0 && blocked == 0, "{waited} {blocked}");
    assert_eq!((straight.fingerprint, &straight.world), (polled.fingerprint, &polled.world));
    let open = move |_: &EngineOptions, limits| engines::polled(guest()?, limits);
    let (waited, as_guest) = whole(host(&Memory::new()).with_engines(open));
    assert!(waited > 0 && as_guest.fingerprint == straight.fingerprint, "{waited}");
}
