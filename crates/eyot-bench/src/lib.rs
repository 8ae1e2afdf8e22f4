//! **Measurements**: [`cpu`] times engines, processes and algorithms on the processor, [`gpu`] on a graphics card, [`doctor`] says
//! what a machine can be used for. Front ends that show such numbers depend on this crate beside the facade; it is not published.

pub mod cpu;
pub mod doctor;
pub mod gpu;
mod rule;
