//! Hydraulic erosion.
mod signed;
pub use signed::{Erode, ErodeParams, Flux, FluxParams};
