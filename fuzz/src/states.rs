//! Stopped runs whose components have changed field by field: what a checkpoint claims must be refused, or harmless to go on from.

use crate::{limits, worlds};
use eyot::session::{Budget, Clock, Host, Memory, Session, SessionOptions, Status};
use eyot::{Command, Handle, Limits, Overrides, Recipe, RecipeSource, Registry, Run, RunOptions};
use eyot_io::checkpoint;
use eyot_io::storage::{Keep, read_bytes, write_bytes};
use std::io::Cursor;
use std::sync::OnceLock;

/// Runs whose components are those of all processes that keep any.
const RUNS: [&str; 2] = [
    "seed = 5\n[grid]\nsize = 8\ncell = 0.25\n[[step]]\ngenerate = \"constant\"\nvalue = -5.0\n\
     [[step]]\nsimulate = [\"corals\"]\nsteps = 12\n[view]\nenabled = false\n\
     [[export]]\nwhat = \"census\"\n[[export]]\nwhat = \"plots\"\n[[export]]\nwhat = \"map\"\nlayers = [\"coral_cover\"]\n",
    "seed = 5\n[grid]\nsize = 24\ncell = 50000.0\n[[step]]\nsimulate = [\"plates\"]\nsteps = 12\n",
];
/// Steps before the checkpoint, and those that are done from a changed one.
const BEFORE: u64 = 9;
const AFTER: u64 = 2;
const CHECKPOINT: &str = "checkpoint.eyot";

/// A run, and changes of its components: number of the run; then for each change the component, where in it (two bytes), how many
/// bytes (1 to 8), and eight bytes of which so many are put there.
pub(crate) fn read(bytes: &[u8]) -> bool {
    loaded(bytes).is_some_and(|checkpoint| go_on(&checkpoint))
}

/// The changed checkpoint, if it can be read; it can then be written, too.
pub fn loaded(bytes: &[u8]) -> Option<Vec<u8>> {
    let [run, changes @ ..] = bytes else { return None };
    let sound = checkpoints()[usize::from(*run) % RUNS.len()].clone();
    let changed = changes.chunks_exact(12).take(8).fold(sound, |bytes, c| {
        let value = &c[4..4 + usize::from(c[3] % 8) + 1];
        worlds::changed(bytes, usize::from(c[0]), usize::from(u16::from_le_bytes([c[1], c[2]])), value)
    });
    let kinds = eyot::component_kinds();
    let loaded = checkpoint::read(Cursor::new(&changed), &limits(), &kinds).ok()?;
    let mut again = Vec::new();
    checkpoint::write(&mut again, &loaded.world, &loaded.recipe_toml, &loaded.state).expect("what was read");
    Some(changed)
}

/// Goes on from a checkpoint for some steps. False if that was refused.
fn go_on(checkpoint: &[u8]) -> bool {
    let memory = Memory::new();
    write_bytes(&memory, CHECKPOINT, Keep::Loose, checkpoint).expect("room for a checkpoint");
    let options = SessionOptions { limits: limits(), ..SessionOptions::default() };
    let Ok(mut session) = Session::resume(options, host(&memory)) else { return false };
    while session.world().step < BEFORE + AFTER {
        match session.advance(Budget::Steps(1)) {
            Ok(Status::Working) => {}
            Ok(_) => break,
            Err(_) => return false,
        }
    }
    true
}

/// Goes on from a changed checkpoint to the end of its run, with all files that are made of it. False if that was refused.
pub fn finished(bytes: &[u8]) -> bool {
    let Some(checkpoint) = loaded(bytes) else { return false };
    let folder = tempfile::tempdir().expect("a folder for a run");
    std::fs::write(folder.path().join(CHECKPOINT), checkpoint).expect("room for a checkpoint");
    let options = RunOptions { limits: limits(), threads: Some(1), ..RunOptions::default() };
    Run::resume(folder.path(), &Registry::standard(), options).and_then(Handle::join).is_ok()
}

fn host(memory: &Memory) -> Host {
    Host::new(&Registry::standard(), Clock::system()).with_storage(memory.clone())
}

/// The checkpoint of each of [`RUNS`].
fn checkpoints() -> &'static [Vec<u8>] {
    static MADE: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    MADE.get_or_init(|| RUNS.iter().map(|text| stopped(text)).collect())
}

fn stopped(text: &str) -> Vec<u8> {
    let memory = Memory::new();
    let source = RecipeSource { name: "run.toml".into(), text: text.into(), folder: ".".into() };
    let recipe = Recipe::parse(source, Overrides::default(), &Registry::standard(), &Limits::default());
    let recipe = recipe.unwrap_or_else(|e| panic!("{e}"));
    let mut session = Session::new(recipe, SessionOptions::default(), host(&memory)).expect("a session");
    while session.world().step < BEFORE {
        session.advance(Budget::Steps(1)).expect("a step");
    }
    session.command(Command::Stop);
    while session.advance(Budget::Piece).expect("an end") == Status::Working {}
    read_bytes(&memory, CHECKPOINT, 1 << 24).expect("a checkpoint")
}

/// Each run as it is.
pub(crate) fn seeds() -> Vec<Vec<u8>> {
    vec![vec![0], vec![1]]
}

/// Numbers that no field should have, in the widths of fields.
pub(crate) const NASTY: [&[u8]; 14] = [
    &[0xff],
    &[0; 4],
    &[0xff; 4],
    &(1_u32 << 28).to_le_bytes(),
    &1e9f32.to_le_bytes(),
    &(-1e30f32).to_le_bytes(),
    &f32::NAN.to_le_bytes(),
    &[0; 8],
    &[0xff; 8],
    &(1_u64 << 33).to_le_bytes(),
    &1e9f64.to_le_bytes(),
    &(-1.0f64).to_le_bytes(),
    &(-1e300f64).to_le_bytes(),
    &f64::NAN.to_le_bytes(),
];

/// Puts each of some bad numbers into each field of each component, one at a time, and hands over the input that does so. Of what
/// goes on for long only the first `most` bytes are changed.
pub fn field_by_field(most: usize, mut each: impl FnMut(&[u8])) {
    for (run, checkpoint) in checkpoints().iter().enumerate() {
        for (number, (_, _, part)) in worlds::parts(checkpoint).into_iter().enumerate() {
            for at in 0..part.len().min(most) {
                // Fields begin anywhere: texts and bytes stand before them.
                for nasty in NASTY.iter().filter(|n| at + n.len() <= part.len()) {
                    let mut input = vec![run as u8, number as u8, at as u8, (at >> 8) as u8, nasty.len() as u8 - 1];
                    input.extend(nasty.iter().copied().chain([0; 8]).take(8));
                    each(&input);
                }
            }
        }
    }
}
