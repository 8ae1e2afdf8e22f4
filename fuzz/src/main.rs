//! `eyot-fuzz [--seconds S] [--seed N] [TARGET...]`: damages the corpus of each target for a while and stops at the first
//! input that breaks something, which is written to `fuzz/findings`.

// Reason for the exception: only an allocator sees what is asked for; memory that is asked for and not touched is in no
// other account.
#![allow(unsafe_code)]

use eyot_fuzz::mutate::{Random, damage};
use eyot_fuzz::{MAX_BYTES, TARGETS, Target, corpus, target};
use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// No input may keep a target busy for longer.
const MAX_TIME: Duration = Duration::from_secs(10);
/// Larger inputs find nothing that small ones do not.
const MAX_INPUT: usize = 1 << 16;

/// The system's allocator, and how much of it is in use.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: the system's allocator does all the work; the counters change nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> ExitCode {
    let (mut seconds, mut seed, mut chosen) = (10.0, 1, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|n| n.parse::<f64>().ok()).filter(|n| *n >= 0.0);
        match (word.as_str(), target(&word)) {
            ("--seconds", _) => seconds = number().unwrap_or(seconds),
            ("--seed", _) => seed = number().unwrap_or(1.0) as u64,
            (_, Some(t)) => chosen.push(t),
            _ => {
                let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
                eprintln!("eyot-fuzz [--seconds S] [--seed N] [TARGET...]; targets: {}", names.join(", "));
                return ExitCode::from(2);
            }
        }
    }
    if chosen.is_empty() {
        chosen.extend(TARGETS);
    }
    // A panic is reported below, with its input.
    std::panic::set_hook(Box::new(|_| {}));
    let sound = chosen.into_iter().filter(|t| !fuzz(t, seconds, seed)).count() == 0;
    if sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Works on one target. False if something broke.
fn fuzz(target: &Target, seconds: f64, seed: u64) -> bool {
    let inputs: Vec<Vec<u8>> = corpus::inputs(target).into_iter().map(|(_, bytes)| bytes).collect();
    let mut r = Random::new(seed);
    let (begun, mut done, mut accepted, mut most) = (Instant::now(), 0_u64, 0_u64, 0);
    while (done as usize) < inputs.len() || begun.elapsed().as_secs_f64() < seconds {
        let mut input = inputs[done as usize % inputs.len()].clone();
        // First all of them as they are.
        if done as usize >= inputs.len() {
            let other = &inputs[r.below(inputs.len())];
            damage(&mut input, other, target.words, &mut r);
            input.truncate(MAX_INPUT);
        }
        PEAK.store(NOW.load(Ordering::Relaxed), Ordering::Relaxed);
        let before = NOW.load(Ordering::Relaxed);
        let start = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
        let (time, bytes) = (start.elapsed(), PEAK.load(Ordering::Relaxed).saturating_sub(before));
        most = most.max(bytes);
        done += 1;
        let broken = match result {
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                Some(text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic").to_owned())
            }
            Ok(_) if bytes > MAX_BYTES => Some(format!("{} MiB were allocated", bytes >> 20)),
            Ok(_) if time > MAX_TIME => Some(format!("it took {time:?}")),
            Ok(sound) => {
                accepted += u64::from(sound);
                None
            }
        };
        if let Some(what) = broken {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("findings");
            let path = folder.join(format!("{}-{seed}-{done}", target.name));
            let kept = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, &input));
            let place = kept.map_or_else(|e| format!("which cannot be written: {e}"), |()| path.display().to_string());
            println!("{}: {what}; the input is {place}", target.name);
            return false;
        }
    }
    println!(
        "{:<12} {done:>9} inputs, {accepted:>8} accepted, {:>7.0} a second, at most {:>4} MiB",
        target.name,
        done as f64 / begun.elapsed().as_secs_f64(),
        most >> 20
    );
    true
}
