//! Prints the cover of each species over the years and draws the plot from above.
//!
//! `cargo run --release -p eyot-reef --example plot -- reef.svg [SIDE_M] [YEARS] [SEED]`
fn main() {}
