//! Generators by name.
//!
//! Sources make a field from parameters and a seed; filters change the field that is there. All of them look at metres, not
//! at cells, so that a recipe on a finer grid shows the same land.

use eyot_core::process::{Entry, Generator, check_ranges as check};
use eyot_core::{Control, Field, Grid, Result};
use rayon::prelude::*;

mod breach;
mod cone;
mod constant;
mod crater;
mod fbm;
mod fill;
mod flow;
pub mod noise;
mod ramp;
mod ridged;
mod smooth;
pub mod warp;

pub use breach::Breach;
pub use cone::Cone;
pub use constant::Constant;
pub use crater::Crater;
pub use fbm::Fbm;
pub use fill::Fill;
pub use flow::Flow;
pub use ramp::Ramp;
pub use ridged::Ridged;
pub use smooth::Smooth;
pub use warp::Warp;

/// All generators that recipes can name.
pub const GENERATORS: &[Entry<dyn Generator>] = &[
    Entry::<dyn Generator>::generator::<Breach>("breach", &["lindsay2015", "lindsay2016"]),
    Entry::<dyn Generator>::generator::<Cone>("cone", &[]),
    Entry::<dyn Generator>::generator::<Constant>("constant", &[]),
    Entry::<dyn Generator>::generator::<Crater>("crater", &[]),
    Entry::<dyn Generator>::generator::<Fbm>("fbm", &["perlin1985", "perlin2001", "perlin2002", "ebert2003"]),
    Entry::<dyn Generator>::generator::<Fill>("fill", &["barnes2014", "barnes2016", "cordonnier2019"]),
    Entry::<dyn Generator>::generator::<Flow>("flow", &["ocallaghan1984", "barnes2014flats", "freeman1991"]),
    Entry::<dyn Generator>::generator::<Ramp>("ramp", &[]),
    Entry::<dyn Generator>::generator::<Ridged>("ridged", &["musgrave1989", "ebert2003", "perlin2001", "perlin2002"]),
    Entry::<dyn Generator>::generator::<Smooth>("smooth", &[]),
    Entry::<dyn Generator>::generator::<Warp>("warp", &["ebert2003"]),
];

/// Rows that are handed out between two looks at the stop button.
const BAND: usize = 128;

/// Computes the rows of a new field in parallel; `row` gets the row's number and its cells, which are 0.
fn fill(grid: &Grid, control: &Control<'_>, row: impl Fn(usize, &mut [f32]) + Sync) -> Result<Field> {
    let mut field = Field::new(grid.width, grid.height, 0.0);
    let mut rows: Vec<&mut [f32]> = field.rows_mut().collect();
    for (band, rows) in rows.chunks_mut(BAND).enumerate() {
        control.tick((band * BAND) as u64, grid.height as u64)?;
        rows.par_iter_mut().enumerate().for_each(|(y, cells)| row(band * BAND + y, cells));
    }
    Ok(field)
}

/// Size of features: `size_m`, or if that is 0, `share` of the grid's longer side.
fn scale_m(grid: &Grid, share: f32, size_m: f32) -> f64 {
    let (w, h) = grid.extent_m();
    if size_m > 0.0 { f64::from(size_m) } else { f64::from(share) * w.max(h) }
}
