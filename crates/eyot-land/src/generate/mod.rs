//! Generators by name.
use eyot_core::process::{Entry, Generator};

mod cone;
pub use cone::Cone;

/// All generators that recipes can name.
pub const GENERATORS: &[Entry<dyn Generator>] = &[Entry::<dyn Generator>::generator::<Cone>("cone", &[])];
