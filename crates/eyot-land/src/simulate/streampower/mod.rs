//! Stream power: rivers cut into rising ground, and hillslopes creep. Ranges, connected valleys, graded rivers.
//!
//! # Equations
//! `z` height, `A` drained area, `S` slope along the way of the water, all in metres; `t` in years.
//! 1. `dz/dt = U - K A^m S^n + D laplacian(z)`.
//! 2. In steady state and without creep `S = (U / K)^(1/n) A^(-m/n)`: Flint's law with concavity `m / n` and steepness
//!    `(U / K)^(1/n)`.
//!
//! A step of `T` years lifts the ground by `U T`, lets the water cut it, and lets it creep. Cutting is implicit in the
//! downstream height (`law.rs`), from the outlets upstream (`stack.rs`), so that a step may be as long as one likes, and
//! nothing is ever cut below what it drains to.
//!
//! # Source
//! Howard 1994 (detachment-limited incision); the implicit step after Braun and Willett 2013; routing by steepest descent
//! over filled depressions (`crate::drainage`).
//!
//! # Differences
//! - Any `n > 0`, below 1 too, is solved to the last digit and cannot fail (`law.rs`).
//! - Lakes are base levels: what flows into one is cut to its surface, its bed is not cut, and its sill is, so that it empties.
//!
//! # Base level
//! Border cells of open rims hold their height. The sea is a base level for the land around it; its floor rises with the
//! uplift. Where there is neither, the lowest cell holds its height.
//!
//! # Layers
//! Reads and writes `height` and `height_rest` (m), which hold it in double precision together. Reads `uplift` and
//! `erodibility` (1) if the recipe makes them: factors on `U` and `K`, cell by cell.
//!
//! # Limits
//! Stable for steps of any length. The order of uplift, cutting and creep within a step makes an error that falls with its
//! length.
//!
//! # Conserves
//! What rises is in `ground.uplifted`, what rivers carry away in `ground.incised`, what creeps into cells that hold their
//! height in `ground.crept`; the ledger closes to rounding (`tests/streampower.rs`). Nothing is deposited.

mod creep;
mod heights;
mod law;
mod stack;

pub use heights::HEIGHT_REST;
