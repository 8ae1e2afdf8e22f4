//! The statistics of the original program: means over many seeds lie within two standard deviations of its runs.

use eyot_reef::community::{Community, Forcing, Plot, Site};
use rayon::prelude::*;

/// Per month: colonies and cover (%) of each species, macroalgae and their cover (%).
type Row = [f64; 10];

fn months(side: f64, months: u64, seed: u64) -> Vec<Row> {
    let community = Community { compat: true, ..Default::default() };
    let forcing = Forcing::chumbe(&community, seed).unwrap();
    let mut plot = Plot::new(community, Site::flat(side, side), forcing, seed).unwrap();
    (0..months)
        .map(|_| {
            let c = plot.month().unwrap();
            let mut row = [0.0; 10];
            for (n, s) in c.species.iter().enumerate() {
                (row[n], row[4 + n]) = (s.colonies as f64, 100.0 * s.cover);
            }
            (row[8], row[9]) = (c.algae as f64, 100.0 * c.algae_cover);
            row
        })
        .collect()
}

fn mean(rows: &[Row]) -> Row {
    std::array::from_fn(|i| rows.iter().map(|r| r[i]).sum::<f64>() / rows.len() as f64)
}

/// Means over months 300 to 599 and 20 seeds, about 1.2 s of processor time each.
#[test]
fn the_default_plot_has_the_statistics_of_the_original() {
    let runs: Vec<Row> = (0..20u64).into_par_iter().map(|seed| mean(&months(40.0, 600, seed)[300..])).collect();
    let got = mean(&runs);
    // Mean and standard deviation of four runs of the original.
    let source = [
        ("Porites lobata, colonies", 0, 168.0, 7.0),
        ("Porites lutea, colonies", 1, 134.0, 24.0),
        ("Acropora muricata, colonies", 2, 526.0, 101.0),
        ("Pocillopora damicornis, colonies", 3, 940.0, 142.0),
        ("Porites lobata, cover", 4, 8.1, 0.8),
        ("Porites lutea, cover", 5, 8.0, 1.9),
        ("Acropora muricata, cover", 6, 13.7, 2.6),
        ("Pocillopora damicornis, cover", 7, 8.7, 1.3),
        ("macroalgae, number", 8, 1595.0, 11.0),
    ];
    for (what, i, mean, sd) in source {
        println!("{what}: {:.2}, the original {mean} +- {sd}", got[i]);
    }
    println!("macroalgae, cover: {:.2}", got[9]);
    for (what, i, mean, sd) in source {
        assert!((got[i] - mean).abs() <= 2.0 * sd, "{what}: {:.2}, the original {mean} +- {sd}", got[i]);
    }
    assert!((5.5..=6.5).contains(&got[9]), "cover of macroalgae {:.2} %", got[9]);
    // No species was lost in the original's four runs.
    assert!(runs.iter().flat_map(|r| &r[..4]).all(|&n| n > 0.0));
}

/// Means over the first 100 months of small plots. The standard deviation of the original's eight runs follows from their range:
/// that of eight normal numbers is 2.85 standard deviations on average.
#[test]
fn small_plots_have_the_statistics_of_the_original() {
    for (side, mean_of_source, range) in
        [(5.0, 13.2, 19.5 - 7.9), (10.0, 83.4, 97.6 - 54.6), (15.0, 220.3, 257.0 - 190.0)]
    {
        let corals = |seed: u64| mean(&months(side, 100, seed))[..4].iter().sum::<f64>();
        let runs: Vec<f64> = (0..60u64).into_par_iter().map(corals).collect();
        let got = runs.iter().sum::<f64>() / runs.len() as f64;
        println!("{side} m: {got:.1} corals, the original {mean_of_source} +- {:.1}", range / 2.85);
        assert!(
            (got - mean_of_source).abs() <= 2.0 * range / 2.85,
            "{side} m: {got} corals, the original {mean_of_source}"
        );
    }
}

/// The first census of the original shows 34 to 35 % of corals and 18 % of algae, that after a year 38 to 39 %.
#[test]
fn the_first_year_is_that_of_the_original() {
    let runs: Vec<Vec<Row>> = (0..20u64).into_par_iter().map(|seed| months(40.0, 13, seed)).collect();
    let corals = |month: usize| runs.iter().map(|r| r[month][4..8].iter().sum::<f64>()).sum::<f64>() / 20.0;
    let algae = |month: usize| runs.iter().map(|r| r[month][9]).sum::<f64>() / 20.0;
    println!("{:.1} % and {:.1} % corals, {:.1} % and {:.1} % algae", corals(0), corals(12), algae(0), algae(12));
    assert!((corals(0) - 34.5).abs() < 1.5 && (corals(12) - 38.5).abs() < 2.0);
    assert!((algae(0) - 18.0).abs() < 1.5 && (algae(12) - 5.8).abs() < 1.0);
}
