//! Chores of the workspace: `cargo xtask help`.

mod gallery;
mod palette;

use std::process::ExitCode;

fn main() -> ExitCode {
    let done = match std::env::args().nth(1).as_deref() {
        Some("gallery") => gallery::write(),
        _ => {
            println!("cargo xtask gallery     draws what each generator makes, into docs/gallery");
            println!("cargo test -p xtask     checks the invariants that ARCHITECTURE.md marks with a star");
            println!(".ci/run                 runs everything that continuous integration runs");
            Ok(())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("{e}");
            ExitCode::FAILURE
        }
    }
}
