//! Runs a recipe in WebAssembly without any glue: numbers and one piece of memory go in and out.
//!
//! The host writes texts into the memory that [`eyot_text`] makes: before [`eyot_run`] a recipe and changes of it
//! (`step.2.steps=8`), one after the other with a zero between them, before [`eyot_layer`] the name of a layer. If a call
//! returns 0, [`eyot_message`] says why.

// Reason for the exception: names that the host can find count as unsafe, for another library might have the same ones.
#![allow(unsafe_code)]

use eyot::session::{Budget, Clock, Host, Memory, Session, SessionOptions, Status};
use eyot::{Limits, Overrides, Recipe, RecipeSource, Registry, World};
use std::error::Error;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Steps of simulation between two looks at whether there is more to do.
const STEPS: u64 = 16;

static STATE: Mutex<State> =
    Mutex::new(State { text: Vec::new(), message: String::new(), values: Vec::new(), fingerprint: 0, world: None });

struct State {
    text: Vec<u8>,
    message: String,
    values: Vec<f32>,
    fingerprint: u64,
    world: Option<World>,
}

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Memory for a text of `bytes`, until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_text(bytes: usize) -> *mut u8 {
    let mut state = state();
    state.text = vec![0; bytes];
    state.text.as_mut_ptr()
}

/// Runs the recipe in the text with `size` cells along its longer side. Returns 1, or 0 if it failed.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_run(size: u32) -> u32 {
    // A panic ends in a trap, which says nothing; the message can still be read.
    std::panic::set_hook(Box::new(|panic| {
        if let Ok(mut state) = STATE.try_lock() {
            state.message = panic.to_string();
        }
    }));
    let text = std::mem::take(&mut state().text);
    let result = run(&text, size);
    let mut state = state();
    state.world = None;
    match result {
        Ok((world, fingerprint)) => (state.world, state.fingerprint) = (Some(world), fingerprint),
        Err(e) => state.message = e.to_string(),
    }
    u32::from(state.world.is_some())
}

fn run(text: &[u8], size: u32) -> Result<(World, u64), Box<dyn Error>> {
    let mut texts = std::str::from_utf8(text)?.split('\0').map(str::to_owned);
    let text = texts.next().unwrap_or_default();
    let overrides = Overrides { size: Some((size, None)), set: texts.collect(), ..Overrides::default() };
    let registry = Registry::standard();
    let source = RecipeSource { name: "recipe.toml".into(), text, folder: ".".into() };
    let recipe = Recipe::parse(source, overrides, &registry, &Limits::default())?;
    // Bare WebAssembly has no clock; nothing here depends on the time.
    let host = Host::new(&registry, Clock::new(|| Duration::ZERO)).with_storage(Memory::default());
    let mut session = Session::new(recipe, SessionOptions::default(), host)?;
    while session.advance(Budget::Steps(STEPS))? == Status::Working {}
    let outcome = session.into_outcome().filter(|o| o.finished).ok_or("the run did not finish")?;
    Ok((outcome.world, outcome.fingerprint))
}

/// Fingerprint of the last run's world.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_fingerprint() -> u64 {
    state().fingerprint
}

/// Fetches the layer that the text names and returns the number of its values, row by row from the north; 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_layer() -> usize {
    let mut state = state();
    let name = String::from_utf8_lossy(&std::mem::take(&mut state.text)).into_owned();
    let layer =
        state.world.as_ref().map(|world| world.layer(&name).map(|l| l.field.rows().flatten().copied().collect()));
    match layer {
        Some(Ok(values)) => state.values = values,
        Some(Err(e)) => (state.values, state.message) = (Vec::new(), e.to_string()),
        None => (state.values, state.message) = (Vec::new(), "nothing has been run".to_owned()),
    }
    state.values.len()
}

/// The values that [`eyot_layer`] fetched.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_values() -> *const f32 {
    state().values.as_ptr()
}

/// What went wrong last, as UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_message() -> *const u8 {
    state().message.as_ptr()
}

/// Its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn eyot_message_bytes() -> usize {
    state().message.len()
}
