//! Chores of the workspace: `cargo xtask help`.

mod book;
mod gallery;
mod links;
mod palette;
mod reference;
mod warnings;
mod wheel;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask book [FOLDER]   builds the book into FOLDER [default: target/book] and checks its links
cargo xtask gallery         draws what each generator makes, into docs/gallery
cargo xtask wheel           builds the Python package into target/wheels
cargo test -p xtask         checks the invariants that ARCHITECTURE.md marks with a star, and the links of all documents
.ci/commands FILE...        runs the commands that documents show
.ci/run                     runs everything that continuous integration runs";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["book"] => book::build(&root().join("target/book")),
        ["book", folder] => book::build(Path::new(folder)),
        ["wheel"] => wheel::build(&root()),
        ["gallery"] => gallery::write().map_err(|e| e.to_string()),
        _ => {
            println!("{HELP}");
            Ok(())
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(problems) => {
            eprintln!("{problems}");
            ExitCode::FAILURE
        }
    }
}

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
