//! The one place that says which crates read, write, draw and analyse.

pub(crate) use {eyot_io as io, eyot_land::analyse, eyot_render as render};
