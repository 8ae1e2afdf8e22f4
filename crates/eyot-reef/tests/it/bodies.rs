//! Bodies of corals: closed and whole, as large as the community says, and the same one month after month.

use eyot_core::rng::mix64;
use eyot_mesh::Topology;
use eyot_reef::bodies::{Bodies, Body, BodyPlan, ColonyShape, Detail, Sculptor, Shape};
use eyot_reef::community::{Community, DIRECTIONS, Forcing, Form, Plot, RAYS, Rays, Site, Species};
use proptest::prelude::*;
use rayon::prelude::*;

/// The species of the source, and one of each other growth form.
fn all_forms() -> Community {
    let mut community = Community::default();
    let massive = community.species[0].clone();
    let form = |shape: Shape, form: Form, height: f32, solid_share: f32| Species {
        name: format!("{shape:?}"),
        form,
        solid_share,
        body: BodyPlan { shape, height, ..BodyPlan::default() },
        ..massive.clone()
    };
    community.species.extend([
        form(Shape::Columnar, Form::Branching, 1.2, 0.35),
        form(Shape::Encrusting, Form::Massive, 0.1, 0.12),
        form(Shape::Foliaceous, Form::Branching, 1.0, 0.2),
        form(Shape::Laminar, Form::Branching, 0.5, 0.17),
        form(Shape::FreeLiving, Form::Massive, 0.35, 0.3),
    ]);
    community
}

fn unit(seed: u64) -> f32 {
    (mix64(seed) >> 40) as f32 / (1u64 << 24) as f32
}

/// Rays as competition leaves them: some smooth waves, some stopped by neighbours.
fn rays(seed: u64, radius: f32) -> Rays {
    let waves: [f32; 4] = std::array::from_fn(|i| unit(mix64(seed) + i as u64));
    std::array::from_fn(|k| {
        let turn = k as f32 / RAYS as f32 * std::f32::consts::TAU;
        let wave = 0.12 * (turn + 6.0 * waves[0]).sin() + 0.08 * (2.0 * turn + 6.0 * waves[1]).sin();
        // A neighbour's straight front cuts off a side.
        let front = (DIRECTIONS[k][0] * (6.0 * waves[2]).cos() + DIRECTIONS[k][1] * (6.0 * waves[2]).sin()).max(1e-3);
        let stopped = (0.35 + 0.65 * waves[3]) / front;
        radius * (1.0 + wave).min(stopped)
    })
}

fn body(sculptor: &Sculptor, species: usize, id: u64, rays: &Rays) -> Body {
    sculptor.body(&ColonyShape { id, species, rays, bleaching: 0.0, slope: [0.0; 2] }).unwrap()
}

fn is_whole(t: Topology) -> bool {
    t.is_closed_manifold() && t.pieces == 1
}

#[test]
fn thousands_of_random_colonies_are_closed_whole_and_of_their_size() {
    let community = all_forms();
    let sculptor = Sculptor::new(&community, 1, Detail::default()).unwrap();
    let wrong: Vec<String> = (0..2016u64)
        .into_par_iter()
        .filter_map(|id| {
            let species = (id % community.species.len() as u64) as usize;
            let largest = community.species[species].max_radius.min(1.2);
            // Recruits of 2 mm to full-grown colonies, small ones more often.
            let radius = 0.002 + (largest - 0.002) * unit(id ^ 0xabc).powi(3);
            let shape = rays(id, radius);
            let b = body(&sculptor, species, id, &shape);
            let (t, q) = (b.solid.topology(), b.solid.quality());
            let [volume, footprint] = b.fit.errors();
            let measured = (b.solid.volume() as f32 / b.fit.volume[1] - 1.0).abs();
            let solid = !matches!(
                community.species[species].body.shape,
                Shape::Branching | Shape::Foliaceous | Shape::Laminar | Shape::Columnar
            );
            let unit_normals =
                b.solid.normals.iter().all(|n| (n.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-3);
            let fits = volume < 0.05 && footprint < 0.05 && measured < 0.05;
            let shaped = is_whole(t) && t.euler() <= 2 && (!solid || t.euler() == 2) && unit_normals;
            (!(fits && shaped && q.slivers < 0.01)).then(|| {
                let name = &community.species[species].name;
                format!(
                    "{id} {name} r {radius}: {t:?} Euler {} {:?} {measured} slivers {}",
                    t.euler(),
                    b.fit,
                    q.slivers
                )
            })
        })
        .collect();
    assert!(wrong.is_empty(), "{} wrong, such as\n{}", wrong.len(), wrong[..wrong.len().min(12)].join("\n"));
}

#[test]
fn a_colony_grows_month_by_month_as_the_same_body() {
    let community = all_forms();
    let sculptor = Sculptor::new(&community, 1, Detail::default()).unwrap();
    for (species, s) in community.species.iter().enumerate() {
        let mut last: Option<(Body, f32)> = None;
        for month in 0..12 {
            let r = 0.16 + 0.13 / 12.0 * month as f32;
            let shape = rays(5, r);
            let b = body(&sculptor, species, 42, &shape);
            assert!(is_whole(b.solid.topology()), "{} month {month}", s.name);
            if let Some((before, r_before)) = &last {
                // Larger by what it grew, and hardly anything else: no point of the smaller body is far from the larger one.
                let ratio = b.solid.volume() / before.solid.volume();
                let expected = f64::from((r / r_before).powi(3));
                assert!((ratio / expected - 1.0).abs() < 0.03, "{} month {month}: {ratio} {expected}", s.name);
                let far = before.solid.positions.iter().step_by(41).map(|p| nearest(&b, *p)).fold(0.0, f32::max);
                assert!(far < 0.35 * r, "{} month {month}: {far} of {r}", s.name);
            }
            last = Some((b, r));
        }
        // The same numbers make the same bytes; another colony is another body.
        let shape = rays(5, 0.3);
        assert_eq!(body(&sculptor, species, 42, &shape), body(&sculptor, species, 42, &shape));
        assert_ne!(body(&sculptor, species, 42, &shape).colours, body(&sculptor, species, 43, &shape).colours);
    }
}

fn nearest(body: &Body, p: [f32; 3]) -> f32 {
    let square = |q: &[f32; 3]| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f32>();
    body.solid.positions.iter().map(square).fold(f32::INFINITY, f32::min).sqrt()
}

#[test]
fn bodies_stay_within_their_outline() {
    let community = all_forms();
    let sculptor = Sculptor::new(&community, 1, Detail::default()).unwrap();
    for species in 0..community.species.len() {
        for id in 0..6u64 {
            let shape = rays(id, 0.3);
            let b = body(&sculptor, species, id, &shape);
            let limit = 1.25 * shape.iter().copied().fold(0.0, f32::max);
            let highest = b.solid.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
            assert!(b.solid.positions.iter().all(|p| p[0].hypot(p[2]) < limit && p[1] > -0.02), "{species} {id}");
            assert!(highest > 0.01 && highest < 0.6, "{species} {id}: {highest} m high");
        }
    }
}

#[test]
fn bleaching_pales_and_slopes_shear() {
    let community = Community::default();
    let sculptor = Sculptor::new(&community, 1, Detail::default()).unwrap();
    let shape = rays(1, 0.25);
    for species in 0..4 {
        let make = |bleaching: f32, slope: [f32; 2]| {
            sculptor.body(&ColonyShape { id: 9, species, rays: &shape, bleaching, slope }).unwrap()
        };
        let (healthy, half, white) = (make(0.0, [0.0; 2]), make(0.5, [0.0; 2]), make(1.0, [0.0; 2]));
        let mean = |b: &Body| {
            let sum = |i: usize| b.colours.iter().map(|c| f32::from(c[i])).sum::<f32>() / b.colours.len() as f32;
            [sum(0), sum(1), sum(2)]
        };
        let [h, m, w] = [&healthy, &half, &white].map(mean);
        assert!((0..3).all(|i| h[i] < m[i] && m[i] < w[i]), "{h:?} {m:?} {w:?}");
        assert!(w[0] - w[2] < 30.0, "a skeleton is nearly white: {w:?}");
        assert_eq!(healthy.solid, white.solid);
        let steep = make(0.0, [0.5, -0.2]);
        assert_eq!((steep.solid.indices == healthy.solid.indices, is_whole(steep.solid.topology())), (true, true));
        assert!((steep.solid.volume() / healthy.solid.volume() - 1.0).abs() < 1e-4);
        assert!(healthy.texture.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
    }
}

#[test]
fn only_colonies_that_changed_get_new_bodies() {
    let community = Community::default();
    let forcing = Forcing::chumbe(&community, 2).unwrap();
    let mut plot = Plot::new(community, Site::flat(3.0, 3.0), forcing, 2).unwrap();
    plot.month().unwrap();
    let mut bodies = Bodies::new(plot.community(), 2, Detail::default()).unwrap();
    assert_eq!(bodies.update(&plot).unwrap(), plot.colonies().len());
    assert_eq!(bodies.update(&plot).unwrap(), 0);
    for _ in 0..3 {
        plot.month().unwrap();
        bodies.update(&plot).unwrap();
        // What has been followed month by month is what is made at once.
        let mut fresh = Bodies::new(plot.community(), 2, Detail::default()).unwrap();
        fresh.update(&plot).unwrap();
        for c in plot.colonies() {
            assert!(bodies.of(c.id).unwrap() == fresh.of(c.id).unwrap());
            assert!(is_whole(bodies.of(c.id).unwrap().solid.topology()));
        }
    }
    assert!(bodies.of(u64::MAX).is_none());
}

#[test]
fn bodies_hold_no_more_than_they_say() {
    for (seed, detail) in [(1, Detail::default()), (2, Detail { open_m: 0.02, solid_m: 0.05, ..Detail::default() })] {
        let community = Community::default();
        let forcing = Forcing::chumbe(&community, seed).unwrap();
        let mut plot = Plot::new(community, Site::flat(4.0, 4.0), forcing, seed).unwrap();
        plot.month().unwrap();
        let mut bodies = Bodies::new(plot.community(), seed, detail).unwrap();
        bodies.update(&plot).unwrap();
        let held = |b: &Body| 36 * b.solid.positions.len() + 4 * b.solid.indices.len();
        let held: u128 = plot.colonies().iter().map(|c| held(bodies.of(c.id).unwrap()) as u128).sum();
        let said = Bodies::bytes(&plot, detail);
        assert!(held > 1 << 20 && held < said, "{held} {said}");
    }
}

#[test]
fn bad_colonies_and_plans_are_refused_with_a_reason() {
    let community = Community::default();
    let sculptor = Sculptor::new(&community, 1, Detail::default()).unwrap();
    let fails = |species: usize, rays: &Rays| {
        sculptor.body(&ColonyShape { id: 1, species, rays, bleaching: 0.0, slope: [0.0; 2] }).unwrap_err().to_string()
    };
    assert!(fails(0, &[f32::NAN; RAYS]).contains("finite"));
    assert!(fails(0, &[0.0; RAYS]).contains("finite"));
    let steep = ColonyShape { id: 1, species: 0, rays: &[0.1; RAYS], bleaching: 0.0, slope: [f32::NAN, 0.0] };
    assert!(sculptor.body(&steep).unwrap_err().to_string().contains("slope"));
    assert!(fails(9, &[0.1; RAYS]).contains("none of number 9"));
    let with = |change: &dyn Fn(&mut Species), detail: Detail| {
        let mut community = Community::default();
        change(&mut community.species[2]);
        Sculptor::new(&community, 1, detail).map(|_| ()).unwrap_err().to_string()
    };
    assert!(with(&|_| (), Detail { solid_m: 0.0, ..Detail::default() }).contains("voxels"));
    assert!(with(&|s| s.body.height = -1.0, Detail::default()).contains("height"));
    assert!(!with(&|s| s.body.grammar = "axiom: F(\n".into(), Detail::default()).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Any rays at all: a needle, a star, a crumb.
    #[test]
    fn any_rays_make_a_whole_body(
        species in 0usize..9,
        id in any::<u64>(),
        shape in prop::array::uniform24(prop_oneof![3 => 0.01f32..0.4, 1 => Just(0.0f32), 1 => Just(0.4f32)]),
    ) {
        let sculptor = Sculptor::new(&all_forms(), 3, Detail::default()).unwrap();
        prop_assume!(shape.iter().any(|r| *r > 0.0));
        let b = body(&sculptor, species, id, &shape);
        prop_assert!(is_whole(b.solid.topology()), "{:?}", b.solid.topology());
        prop_assert!(b.solid.volume() > 0.0);
    }
}
