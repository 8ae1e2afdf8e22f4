//! Plans (placeholder).
/// A list of passes.
#[derive(Default)]
pub struct Plan {}
