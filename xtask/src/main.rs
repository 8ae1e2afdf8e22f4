//! Chores of the workspace: `cargo xtask help`.

fn main() {
    println!("cargo test -p xtask    checks the invariants that ARCHITECTURE.md marks with a star");
    println!(".ci/run                runs everything that continuous integration runs");
}
