//! Worlds in the hands of a session's host, and sessions in folders.

use crate::stubs::{GOOD, parse, registry};

use eyot::session::{Budget, Clock, Host, Session, SessionOptions, Status};
use eyot::{Recipe, Run, RunError, RunOptions, World};

fn recipe() -> Recipe {
    parse(GOOD, &["step.2.steps=40"]).unwrap()
}

fn session() -> Session {
    let mut s = Session::new(recipe(), SessionOptions::default(), Host::new(&registry(), Clock::system())).unwrap();
    while s.world().step < 10 {
        s.advance(Budget::Steps(1)).unwrap();
    }
    s
}

fn finish(mut s: Session) -> World {
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    s.into_outcome().unwrap().world
}

#[test]
fn a_lent_world_is_the_sessions_own_and_goes_back() {
    let mut s = session();
    let place = |world: &World| world.layer("height").unwrap().field.as_strided().0.as_ptr();
    let world = s.lend().unwrap();
    let lent = place(&world);
    assert!(s.lend().is_none() && s.checkpoint_bytes().unwrap().is_none());
    assert_eq!(s.advance(Budget::Piece).unwrap(), Status::Paused);
    s.restore(world);
    assert_eq!(place(s.world()), lent);
    assert_eq!(finish(s), finish(session()));
}

#[test]
fn what_the_host_puts_in_has_an_account_and_must_be_finite() {
    let mut s = session();
    s.edit(|world| world.layer_mut("height").unwrap().field.map_in_place(|h| h + 2.0)).unwrap();
    let (account, added) = (s.world().ledger.amount("ground.by_hand"), 2.0 * s.world().grid.cells() as f64);
    assert!((account / (added * s.world().grid.cell_area_m2()) - 1.0).abs() < 1e-5, "{account}");
    assert_ne!(finish(s), finish(session()));
    let mut s = session();
    let spoilt = s.edit(|world| world.layer_mut("height").unwrap().field.set(0, 0, f32::NAN));
    assert!(matches!(spoilt, Err(RunError::Input { .. })));
}

#[test]
fn bytes_of_a_checkpoint_go_on_without_a_folder() {
    let mut s = session();
    let bytes = s.checkpoint_bytes().unwrap().unwrap();
    let host = Host::new(&registry(), Clock::system());
    let again = eyot_session::Run::session_of(&bytes, RunOptions::default(), &host).unwrap();
    assert_eq!(finish(again), finish(s));
    assert!(eyot_session::Run::session_of(&bytes[..bytes.len() / 2], RunOptions::default(), &host).is_err());
}

#[test]
fn a_session_has_its_folder_for_itself_until_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let options = || RunOptions { out: Some(out.clone()), ..RunOptions::default() };
    let mut s = Run::session(recipe(), options()).unwrap();
    s.advance(Budget::Steps(1)).unwrap();
    assert!(matches!(Run::start(recipe(), options()), Err(RunError::Busy { .. })));
    s.command(eyot::Command::Stop);
    while s.advance(Budget::Piece).unwrap() == Status::Working {}
    assert!(matches!(Run::session(recipe(), options()), Err(RunError::Unfinished { .. })));
    let again = Run::resume_session(&out, &registry(), RunOptions::default()).unwrap();
    let whole = Run::start(recipe(), RunOptions::default()).unwrap().join().unwrap();
    assert_eq!(finish(again), whole.world);
    assert!(out.join("run.json").exists() && !out.join("eyot.lock").exists());
}
