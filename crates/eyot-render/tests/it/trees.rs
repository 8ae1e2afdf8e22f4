//! Single trees in views.

use eyot_core::layer::known;
use eyot_core::{Boundary, Field, Grid, LayerSpec, Limits, World};
use eyot_render::{ViewOptions, perspective};

/// A slope with a forest on its western half.
fn slope(forest: bool) -> World {
    let mut world = World::new(Grid::new(40, 40, 10.0, Boundary::CLOSED, &Limits::default()).unwrap(), 5);
    world.put(&known::HEIGHT, Field::from_fn(40, 40, |_, y| 100.0 - 2.0 * y as f32)).unwrap();
    if forest {
        let share = |x: usize, _| if x < 20 { 1.0 } else { 0.0 };
        let spec = LayerSpec::new("forest", "1", "", (0.0, 1.0));
        world.put(&spec, Field::from_fn(40, 40, share)).unwrap();
    }
    world
}

#[test]
fn trees_stand_in_the_picture_where_the_forest_is() {
    let o = ViewOptions { width: 240, height: 150, azimuth_deg: 180.0, ..ViewOptions::default() };
    let picture = perspective(&slope(true), &o).unwrap();
    let light = |p: &[u8; 3]| p.iter().map(|v| f32::from(*v)).sum::<f32>();
    // Columns of the middle rows, on both sides: trees are darker than grass, and light differs from one to the next.
    let look = |columns: std::ops::Range<usize>| {
        let values: Vec<f32> = (60..95)
            .flat_map(|y| columns.clone().map(move |x| (x, y)))
            .map(|(x, y)| light(&picture.pixels[y * 240 + x]))
            .collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32;
        (mean, spread.sqrt())
    };
    let ((wood, rough), (grass, smooth)) = (look(70..110), look(130..170));
    assert!(wood < 0.7 * grass && rough / wood > 3.0 * smooth / grass, "{wood} {rough}, {grass} {smooth}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert!(pool.install(|| perspective(&slope(true), &o)).unwrap() == picture, "the same on any number of threads");
    assert!(perspective(&slope(false), &o).unwrap() != picture);
}
