//! What must hold of the repository as a whole.

mod architecture;
mod circles;
mod crates;
mod gallery;
mod how_to;
mod verification;
