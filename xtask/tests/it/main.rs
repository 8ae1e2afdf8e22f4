//! What must hold of the repository as a whole.

mod architecture;
mod circles;
mod crates;
mod enums;
mod gallery;
mod how_to;
mod verification;
