//! The text of the shaders that draw.

/// Drawing: every stage of a picture in one module.
pub fn picture() -> String {
    [
        include_str!("shaders/frame.wgsl"),
        eyot_noise::picture::WGSL,
        include_str!("shaders/light.wgsl"),
        include_str!("shaders/surface.wgsl"),
        include_str!("shaders/water.wgsl"),
        include_str!("shaders/terrain.wgsl"),
        include_str!("shaders/sea.wgsl"),
        include_str!("shaders/block.wgsl"),
        include_str!("shaders/backdrop.wgsl"),
    ]
    .concat()
}

/// From cells to the maps that pictures read.
pub const MAPS: &str = include_str!("shaders/maps.wgsl");

/// From layers on the card to cells.
pub const CARD: &str = include_str!("shaders/card.wgsl");

/// From a map to its next smaller level.
pub const MIPS: &str = include_str!("shaders/mips.wgsl");
