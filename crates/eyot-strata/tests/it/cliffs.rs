//! What beds make of a landscape: cliffs that stay cliffs while they retreat, and benches on hard rock.

use crate::{go, scheduled};
use eyot_core::layer::known::HEIGHT;
use eyot_core::process::Scheduled;
use eyot_core::{Boundary, BoundaryCondition, Field, Grid, Limits, World};
use eyot_land::simulate::Streampower;
use eyot_strata::{Bed, Rockfall, Strata};

fn bed(material: &str, thickness: f32) -> Bed {
    Bed { material: material.into(), thickness }
}

/// Rivers, beds, and what comes down from them.
fn ageing(beds: Strata) -> [Scheduled; 3] {
    let rivers = Streampower {
        years_per_step: 1000.0,
        uplift: 0.0,
        erodibility: 1e-5,
        diffusivity: 0.0,
        ..Streampower::default()
    };
    [scheduled(rivers), scheduled(beds), scheduled(Rockfall::default())]
}

fn land(size: [usize; 2], cell_m: f64, y: BoundaryCondition, height: impl Fn(usize, usize) -> f32) -> World {
    let rim = Boundary { x: BoundaryCondition::Open, y };
    let mut w = World::new(Grid::new(size[0], size[1], cell_m, rim, &Limits::default()).unwrap(), 1);
    w.sea_level_m = -12_000.0;
    w.put(&HEIGHT, Field::from_fn(size[0], size[1], height)).unwrap();
    w
}

/// Where the middle row of a scarp that falls to the east crosses this height, in cells.
fn crossing(w: &World, height: f32) -> f32 {
    let h = w.get("height").unwrap();
    let row: Vec<f32> = (0..w.grid.width).map(|x| h.get(x, 1)).collect();
    let x = row.windows(2).rposition(|p| p[0] >= height && height > p[1]).unwrap();
    x as f32 + (row[x] - height) / (row[x] - row[x + 1])
}

/// Angle of a scarp between 25 and 85 m, degrees.
fn angle(w: &World) -> f32 {
    (60.0 / (10.0 * (crossing(w, 25.0) - crossing(w, 85.0)))).atan().to_degrees()
}

/// A plateau at 100 m in the west, a plain in the east, and 45 degrees between them. Rivers wear it back.
#[test]
fn a_scarp_with_a_caprock_stays_a_cliff_and_one_without_smooths_out() {
    let retreated = |beds: Vec<Bed>, formed: u64| {
        let mut w = land([100, 3], 10.0, BoundaryCondition::Wrap, |x, _| {
            (700.0 - 10.0 * x as f32).clamp(2.0 - 0.02 * x as f32, 101.0 - 0.01 * x as f32)
        });
        let all = ageing(Strata { beds, top: 101.5, ..Strata::default() });
        go(&mut w, &all, formed);
        let (start, first) = (crossing(&w, 85.0), angle(&w));
        let mut angles = vec![first];
        while start - crossing(&w, 85.0) < 15.0 {
            assert!(w.step < 2000, "it retreats");
            go(&mut w, &all, 25);
            angles.push(angle(&w));
        }
        angles
    };
    // Fifteen cells of retreat. The cliff needs a while to find its form; measured 62 to 66 degrees, and 45 to 37 without a caprock.
    let capped = retreated(vec![bed("granite", 15.0), bed("sandstone", 500.0)], 200);
    let uniform = retreated(vec![bed("sandstone", 500.0)], 1);
    println!("with a caprock {capped:.1?}, without {uniform:.1?} degrees");
    let kept = capped.iter().all(|a| (a - capped[0]).abs() < 5.0);
    assert!(kept && capped[0] > 50.0, "{capped:.1?}");
    assert!(uniform[0] - uniform[uniform.len() - 1] > 6.0, "{uniform:.1?}");
}

/// The same rivers on the same slope, in beds and in rock without beds that wears as much on the whole.
#[test]
fn hard_beds_make_benches() {
    let age = |beds: Vec<Bed>| {
        let mut w = land([64, 64], 20.0, BoundaryCondition::Open, |x, y| {
            let (u, v) = (x as f32 / 63.0, y as f32 / 63.0);
            let waves = (9.0 * u + 5.0 * v).sin() + (11.0 * v - 6.0 * u).cos() + (23.0 * v + 2.0 * u).sin();
            240.0 * (1.0 - u) + 6.0 * waves + ((x * 7919 + y * 104_729 + x * y * 31) % 1021) as f32 / 300.0
        });
        let all = ageing(Strata { beds, top: 240.0, repeat: true, ..Strata::default() });
        go(&mut w, &all, 300);
        let h = w.get("height").unwrap();
        // Hard beds begin at 210, 170, 130, 90, 50 and 10 m.
        let near = h.iter().filter(|h| (0..6).any(|i| (h - (210.0 - 40.0 * i as f32)).abs() < 2.0)).count();
        (near, h.sum() / 4096.0)
    };
    let (in_beds, mean) = age(vec![bed("sandstone", 30.0), bed("granite", 10.0)]);
    let (without, mean_without) = age(vec![bed("schist", 40.0)]);
    println!("{in_beds} cells of a land of {mean:.1} m on average, without beds {without} of {mean_without:.1} m");
    assert!(in_beds > 2 * without, "{in_beds} and {without} cells");
    assert!((mean - mean_without).abs() < 4.0, "as much was worn: {mean} and {mean_without} m");
}
