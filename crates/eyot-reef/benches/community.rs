//! Months a second of the community, to notice when a change makes it slower. Comparisons are made by `eyot bench community`.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use eyot_reef::community::{Community, Forcing, Plot, Site};
use std::time::Duration;

fn community(c: &mut Criterion) {
    let mut group = c.benchmark_group("community");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(4));
    // The default plot, and a slope of about 100,000 individuals.
    for (name, width, length) in [("plot", 40.0, 40.0), ("slope", 200.0, 230.0)] {
        let parameters = Community::default();
        let forcing = Forcing::chumbe(&parameters, 1).expect("the defaults are sound");
        let mut plot = Plot::new(parameters, Site::flat(width, length), forcing, 1).expect("the defaults are sound");
        (0..24).for_each(|_| _ = plot.month().expect("it fits"));
        println!("{name}: {} colonies, {} algae", plot.colonies().len(), plot.algae().len());
        group.bench_function(name, |b| {
            b.iter_batched(|| (), |()| plot.month().expect("it fits"), BatchSize::PerIteration)
        });
    }
    group.finish();
}

criterion_group!(benches, community);
criterion_main!(benches);
