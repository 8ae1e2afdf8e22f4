//! Generators by name.
//!
//! Sources make a field from parameters and a seed; filters change the field that is there. All of them look at metres, not
//! at cells, so that a recipe on a finer grid shows the same land.

use eyot_core::process::{Entry, Generator, check_ranges as check};
use eyot_core::{Grid, about};

mod billow;
mod breach;
mod circles;
mod cone;
mod constant;
mod crater;
mod diamond_square;
mod faulting;
mod fbm;
mod fill;
mod flow;
pub mod fractal;
mod hypsometry;
pub mod mask;
pub use eyot_noise::plane as noise;
mod ramp;
mod random_additions;
pub mod remap;
mod ridged;
pub mod smooth;
mod subdivide;
mod terraces;
mod volcanic_island;
pub mod warp;
pub mod worley;

pub use billow::Billow;
pub use breach::Breach;
pub use circles::Circles;
pub use cone::Cone;
pub use constant::Constant;
pub use crater::Crater;
pub use diamond_square::DiamondSquare;
pub use faulting::Faulting;
pub use fbm::Fbm;
pub use fill::Fill;
pub use flow::Flow;
pub use hypsometry::Hypsometry;
pub use mask::{MaskCurvature, MaskHeight, MaskNoise, MaskSlope};
pub use ramp::Ramp;
pub use random_additions::RandomAdditions;
pub use remap::Remap;
pub use ridged::Ridged;
pub use smooth::Smooth;
pub use terraces::Terraces;
pub use volcanic_island::VolcanicIsland;
pub use warp::Warp;
pub use worley::Worley;

/// All generators that recipes can name.
pub const GENERATORS: &[Entry<dyn Generator>] = &[
    Entry::<dyn Generator>::generator::<Billow>("billow", about!("billow.rs"), &["ebert2003", "perlin2002"]),
    Entry::<dyn Generator>::generator::<Breach>("breach", about!("breach.rs"), &["lindsay2015", "lindsay2016"]),
    Entry::<dyn Generator>::generator::<Circles>("circles", about!("circles.rs"), &[]),
    Entry::<dyn Generator>::generator::<Cone>("cone", about!("cone.rs"), &[]),
    Entry::<dyn Generator>::generator::<Constant>("constant", about!("constant.rs"), &[]),
    Entry::<dyn Generator>::generator::<Crater>("crater", about!("crater.rs"), &[]),
    Entry::<dyn Generator>::generator::<DiamondSquare>(
        "diamond_square",
        about!("diamond_square.rs"),
        &["fournier1982", "miller1986"],
    ),
    Entry::<dyn Generator>::generator::<Faulting>("faulting", about!("faulting.rs"), &["mandelbrot1975", "voss1985"]),
    Entry::<dyn Generator>::generator::<Fbm>(
        "fbm",
        about!("fbm.rs"),
        &["perlin1985", "perlin2001", "perlin2002", "gustavson2022", "ebert2003"],
    ),
    Entry::<dyn Generator>::generator::<Fill>(
        "fill",
        about!("fill.rs"),
        &["barnes2014", "barnes2016", "cordonnier2019"],
    ),
    Entry::<dyn Generator>::generator::<Flow>(
        "flow",
        about!("flow.rs"),
        &["ocallaghan1984", "barnes2014flats", "freeman1991", "tarboton1997"],
    ),
    Entry::<dyn Generator>::generator::<Hypsometry>("hypsometry", about!("hypsometry.rs"), &["gerteis2017"]),
    Entry::<dyn Generator>::generator::<MaskCurvature>("mask_curvature", about!("mask/curvature.rs"), &[]),
    Entry::<dyn Generator>::generator::<MaskHeight>("mask_height", about!("mask/height.rs"), &[]),
    Entry::<dyn Generator>::generator::<MaskNoise>("mask_noise", about!("mask/noise.rs"), &["perlin2001"]),
    Entry::<dyn Generator>::generator::<MaskSlope>("mask_slope", about!("mask/slope.rs"), &[]),
    Entry::<dyn Generator>::generator::<Ramp>("ramp", about!("ramp.rs"), &[]),
    Entry::<dyn Generator>::generator::<RandomAdditions>(
        "random_additions",
        about!("random_additions.rs"),
        &["voss1985", "saupe1988"],
    ),
    Entry::<dyn Generator>::generator::<Remap>("remap", about!("remap.rs"), &["fritsch1980"]),
    Entry::<dyn Generator>::generator::<Ridged>(
        "ridged",
        about!("ridged.rs"),
        &["musgrave1989", "ebert2003", "perlin2001", "perlin2002"],
    ),
    Entry::<dyn Generator>::generator::<Smooth>("smooth", about!("smooth.rs"), &[]),
    Entry::<dyn Generator>::generator::<Terraces>("terraces", about!("terraces.rs"), &[]),
    Entry::<dyn Generator>::generator::<VolcanicIsland>(
        "volcanic_island",
        about!("volcanic_island/mod.rs"),
        &["macdonald1983", "moore1989", "ramalho2013"],
    ),
    Entry::<dyn Generator>::generator::<Warp>("warp", about!("warp.rs"), &["ebert2003"]),
    Entry::<dyn Generator>::generator::<Worley>("worley", about!("worley.rs"), &["worley1996"]),
];

/// Size of features: `size_m`, or if that is 0, `share` of the grid's longer side.
fn scale_m(grid: &Grid, share: f32, size_m: f32) -> f64 {
    let (w, h) = grid.extent_m();
    if size_m > 0.0 { f64::from(size_m) } else { f64::from(share) * w.max(h) }
}
