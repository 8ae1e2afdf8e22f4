//! All bodies of a plot of 10 x 10 m at the source's voxels, and what a month costs.

use criterion::{Criterion, criterion_group, criterion_main};
use eyot_reef::bodies::{Bodies, Detail};
use eyot_reef::community::{Community, Forcing, Plot, Site};
use std::hint::black_box;

fn bodies(c: &mut Criterion) {
    let community = Community::default();
    let forcing = Forcing::chumbe(&community, 1).expect("a forcing");
    let mut plot = Plot::new(community, Site::flat(10.0, 10.0), forcing, 1).expect("a plot");
    plot.month().expect("a month");
    let all = || {
        let mut bodies = Bodies::new(plot.community(), 1, Detail::default()).expect("bodies");
        bodies.update(&plot).expect("bodies");
        bodies
    };
    let made = all();
    let triangles: usize = plot.colonies().iter().filter_map(|c| made.of(c.id)).map(|b| b.solid.triangles()).sum();
    println!("{} colonies, {triangles} triangles", plot.colonies().len());
    let mut group = c.benchmark_group("bodies");
    group.sample_size(10);
    group.bench_function("all of 10 x 10 m", |b| b.iter(|| black_box(all())));
    group.finish();
}

criterion_group!(benches, bodies);
criterion_main!(benches);
