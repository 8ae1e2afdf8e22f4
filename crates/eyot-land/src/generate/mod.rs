//! Generators: what makes layers, each in a module of its own.
//!
//! A source makes a field from parameters and a seed; a filter transforms the layer that is there. Sizes are shares of the
//! grid's extent, so that the same recipe shows the same land at any resolution.

mod cone;
mod constant;
mod crater;
mod fbm;
mod noise;
mod ramp;
mod ridged;
mod smooth;
mod warp;

use eyot_core::process::{Entry, Generator};

pub use cone::Cone;
pub use constant::Constant;
pub use crater::Crater;
pub use fbm::Fbm;
pub use noise::Basis;
pub use ramp::Ramp;
pub use ridged::Ridged;
pub use smooth::Smooth;
pub use warp::Warp;

/// All generators that recipes can name.
pub const GENERATORS: &[Entry<dyn Generator>] = &[
    Entry::<dyn Generator>::generator::<Cone>("cone", &[]),
    Entry::<dyn Generator>::generator::<Constant>("constant", &[]),
    Entry::<dyn Generator>::generator::<Crater>("crater", &[]),
    Entry::<dyn Generator>::generator::<Fbm>("fbm", &["perlin1985", "perlin2002", "gustavson2022"]),
    Entry::<dyn Generator>::generator::<Ramp>("ramp", &[]),
    Entry::<dyn Generator>::generator::<Ridged>("ridged", &["ebert2003"]),
    Entry::<dyn Generator>::generator::<Smooth>("smooth", &[]),
    Entry::<dyn Generator>::generator::<Warp>("warp", &["ebert2003"]),
];
