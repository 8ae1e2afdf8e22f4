//! Prints the cover of each species over the years.
//!
//! `cargo run --release -p eyot-reef --example plot -- [SIDE_M] [YEARS] [SEED]`

use eyot_reef::community::{Community, Forcing, Plot, Site};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: f64| arguments.get(i).map_or(Ok(default), |a| a.parse());
    let (side, years, seed) = (number(0, 10.0)?, number(1, 50.0)? as u64, number(2, 1.0)? as u64);

    let community = Community::default();
    let names: Vec<String> = community.species.iter().map(|s| s.name.clone()).collect();
    let forcing = Forcing::chumbe(&community, seed)?;
    let mut plot = Plot::new(community, Site::flat(side, side), forcing, seed)?;
    println!("{:>4}  {}  {:>8} {:>6} {:>9}", "year", names.join("  "), "algae", "T* C", "mm/yr");
    for year in 0..years {
        let (mut hottest, mut limestone, mut last) = (0.0f32, 0.0, None);
        for _ in 0..12 {
            let census = plot.month()?;
            hottest = hottest.max(census.heat.index);
            limestone += census.limestone_m;
            last = Some(census);
        }
        let Some(census) = last else { break };
        let covers: Vec<String> = census
            .species
            .iter()
            .zip(&names)
            .map(|(s, name)| format!("{:>width$.1} %", 100.0 * s.cover, width = name.len() - 2))
            .collect();
        let algae = 100.0 * census.algae_cover;
        println!("{year:>4}  {}  {algae:>6.1} % {hottest:>6.2} {:>9.2}", covers.join("  "), 1e3 * limestone);
    }
    println!("{} colonies and {} algae", plot.colonies().len(), plot.algae().len());
    Ok(())
}
