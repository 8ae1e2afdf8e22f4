//! Truth tables: every class of the three schemes on both sides of every limit.

use eyot_climate::zones::*;

/// The value itself and the next one above.
fn sides(limit: f32) -> [f32; 2] {
    [limit, f32::from_bits(if limit >= 0.0 { limit.to_bits() + 1 } else { limit.to_bits() - 1 })]
}

fn name(table: &[eyot_core::layer::Class], number: f32) -> &'static str {
    assert_eq!(number.fract(), 0.0);
    table[number as usize].name
}

#[test]
fn tables_have_a_name_for_every_number() {
    assert_eq!(SOURCE_ZONES.len() - 3, 38, "37 zones and the polar desert, after ocean, lake and river");
    assert_eq!((HOLDRIDGE_PROVINCES.len(), KOEPPEN_CLASSES.len()), (9, 31));
    for table in ["zone", "holdridge", "humidity_province", "koeppen"] {
        let classes = classes(table).unwrap();
        let mut names: Vec<&str> = classes.iter().map(|c| c.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), classes.len(), "{table}");
        let mut colours: Vec<[u8; 3]> = classes.iter().map(|c| c.colour).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), classes.len(), "{table}");
    }
    assert!(classes("height").is_none());
}

/// Belts and columns of the source: the limit itself is the colder and the drier one.
#[test]
fn the_source_s_table_at_every_limit() {
    let belts = ["subpolar", "boreal", "cool temperate", "warm temperate", "subtropical", "tropical"];
    for (i, limit) in [-0.8, -0.3, 0.0, 0.25, 0.5].into_iter().enumerate() {
        let [low, high] = sides(limit).map(|t| name(SOURCE_ZONES, source_zone(t, 0.0)));
        assert!(low.starts_with(belts[i]) && high.starts_with(belts[i + 1]), "{limit}: {low}, {high}");
    }
    // The last class of a belt takes all that is wetter.
    let columns = [4, 5, 6, 7, 7, 8];
    for (belt, temperature) in [-1.0f32, -0.5, -0.1, 0.1, 0.4, 0.9].into_iter().enumerate() {
        let first = source_zone(temperature, 0.0);
        for (i, limit) in [0.1, 0.25, 0.35, 0.5, 0.6, 0.75, 0.8].into_iter().enumerate() {
            let column = |k: usize| first + k.min(columns[belt] - 1) as f32;
            assert_eq!(sides(limit).map(|q| source_zone(temperature, q)), [column(i), column(i + 1)], "{limit}");
        }
    }
    assert_eq!(name(SOURCE_ZONES, source_zone(1.0, 1.0)), "tropical rain forest");
    assert_eq!(name(SOURCE_ZONES, source_zone(0.9, 0.2)), "tropical desert scrub");
    assert_eq!(name(SOURCE_ZONES, source_zone(-0.5, 0.3)), "boreal moist forest");
}

#[test]
fn holdridge_at_every_limit() {
    let belts = ["polar", "subpolar", "boreal", "cool temperate", "warm temperate", "subtropical", "tropical"];
    for (i, limit) in [1.5, 3.0, 6.0, 12.0, 18.0, 24.0].into_iter().enumerate() {
        let [low, high] = sides(limit).map(|t| name(SOURCE_ZONES, life_zone(t, 600.0)));
        assert!(low.starts_with(belts[i]) && high.starts_with(belts[i + 1]), "{limit}: {low}, {high}");
    }
    let tropical = [
        "tropical desert",
        "tropical desert scrub",
        "tropical thorn woodland",
        "tropical very dry forest",
        "tropical dry forest",
        "tropical moist forest",
        "tropical wet forest",
        "tropical rain forest",
    ];
    for (i, limit) in [125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0].into_iter().enumerate() {
        assert_eq!(sides(limit).map(|p| name(SOURCE_ZONES, life_zone(26.0, p))), [tropical[i], tropical[i + 1]]);
    }
    // One known place of each belt (Holdridge's chart).
    for (t, p, zone) in [
        (2.0f32, 100.0f32, "subpolar dry tundra"),
        (4.0, 400.0, "boreal moist forest"),
        (9.0, 300.0, "cool temperate steppe"),
        (15.0, 700.0, "warm temperate dry forest"),
        (21.0, 1500.0, "subtropical moist forest"),
        (1.0, 500.0, "polar desert"),
    ] {
        assert_eq!(name(SOURCE_ZONES, life_zone(t, p)), zone);
    }
}

#[test]
fn provinces_at_every_ratio_of_evapotranspiration_to_rain() {
    let names = ["superarid", "perarid", "arid", "semiarid", "subhumid", "humid", "perhumid", "superhumid"];
    for (i, ratio) in [16.0f32, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25].into_iter().enumerate() {
        let rain = 58.93f32 * 10.0 / ratio;
        let found = [rain * 0.999_999, rain * 1.000_001].map(|p| name(HOLDRIDGE_PROVINCES, province(10.0, p)));
        assert_eq!(found, [names[i], names[i + 1]], "{ratio}");
    }
    assert_eq!(name(HOLDRIDGE_PROVINCES, province(25.0, 0.0)), "superarid");
}

#[test]
fn biotemperature_leaves_out_frost_and_heat() {
    assert!(biotemperature(-40.0, 10.0) == 0.0 && (biotemperature(45.0, 5.0) - 30.0f32).abs() < 1e-5);
    assert!((biotemperature(15.0f32, 10.0) - 15.0).abs() < 1e-5);
    // Half the year above freezing: the mean of the positive half of a cosine is 1 / pi of its swing.
    assert!((biotemperature(0.0f32, 20.0) - 20.0 / std::f32::consts::PI).abs() < 0.15);
}

/// A year of 800 mm that falls evenly; the warmest month may be changed.
fn even(mean: f32, swing: f32) -> Months<f32> {
    Months {
        mean,
        warmest: mean + swing,
        coldest: mean - swing,
        fourth: mean + 0.7 * swing,
        rain: 2000.0,
        summer_share: 0.5,
        summer_driest: 160.0,
        summer_wettest: 170.0,
        winter_driest: 160.0,
        winter_wettest: 170.0,
    }
}

fn class(m: &Months<f32>) -> &'static str {
    name(KOEPPEN_CLASSES, koeppen(m)).split(' ').next().unwrap()
}

/// Sets one number just below a limit, then at it or just above, and compares the classes.
fn at(limit: f32, below: &str, above: &str, set: impl Fn(f32) -> Months<f32>) {
    let e = 1e-4 * limit.abs().max(1.0);
    assert_eq!([class(&set(limit - e)), class(&set(limit + e))], [below, above], "{limit}");
}

#[test]
fn koeppen_by_temperature_at_every_limit() {
    at(18.0, "Cfa", "Af", |coldest| Months { coldest, ..even(25.0, 3.0) });
    at(0.0, "Dfa", "Cfa", |coldest| Months { coldest, ..even(15.0, 10.0) });
    at(-38.0, "Dfd", "Dfc", |coldest| Months { coldest, fourth: 5.0, ..even(-5.0, 20.0) });
    at(22.0, "Cfb", "Cfa", |warmest| Months { warmest, fourth: 15.0, ..even(12.0, 8.0) });
    at(22.0, "Dfb", "Dfa", |warmest| Months { warmest, fourth: 15.0, ..even(5.0, 12.0) });
    at(10.0, "Cfc", "Cfb", |fourth| Months { fourth, ..even(8.0, 6.0) });
    at(10.0, "Dfc", "Dfb", |fourth| Months { fourth, ..even(1.0, 14.0) });
    at(10.0, "ET", "Dfc", |warmest| Months { warmest, fourth: 5.0, ..even(-5.0, 12.0) });
    at(0.0, "EF", "ET", |warmest| Months { warmest, fourth: -5.0, ..even(-20.0, 12.0) });
}

#[test]
fn koeppen_by_rain_at_every_limit() {
    // Tropics: 60 mm in the driest month, else 100 - P / 25.
    at(60.0, "Am", "Af", |summer_driest| Months { summer_driest, ..even(26.0, 2.0) });
    at(20.0, "Aw", "Am", |winter_driest| Months { winter_driest, ..even(26.0, 2.0) });
    // Dryness: the limit is 20 T, and 140 or 280 mm if the rain is even or falls in summer.
    let dry = |share: f32, mean: f32| move |rain: f32| Months { rain, summer_share: share, ..even(mean, 2.0) };
    at(540.0, "BSh", "Af", dry(0.5, 20.0));
    at(400.0, "BSh", "Af", dry(0.2, 20.0));
    at(680.0, "BSh", "Af", dry(0.8, 20.0));
    at(270.0, "BWh", "BSh", dry(0.5, 20.0));
    at(170.0, "BWk", "BSk", dry(0.5, 10.0));
    at(340.0, "BSk", "Cfb", |rain| Months { rain, fourth: 11.0, ..even(10.0, 4.0) });
    at(18.0, "BSk", "BSh", |mean| Months { mean, rain: 400.0, ..even(18.0, 10.0) });
    // The share at which rain counts as that of one half of the year.
    at(0.7, "Cfa", "BSh", |summer_share| Months { rain: 600.0, summer_share, ..even(20.0, 10.0) });
    at(0.3, "Cfa", "BSh", |summer_share| Months { rain: 460.0, summer_share, ..even(20.0, 10.0) });
    // Dry summers and winters.
    let summer = |d: f32| Months { summer_driest: d, winter_wettest: 150.0, ..even(16.0, 8.0) };
    at(40.0, "Csa", "Cfa", summer);
    at(100.0 / 3.0, "Csa", "Cfa", |d| Months { winter_wettest: 100.0, ..summer(d) });
    let winter = |d: f32| Months { winter_driest: d, summer_wettest: 200.0, ..even(16.0, 8.0) };
    at(20.0, "Cwa", "Cfa", winter);
    at(20.0, "Dwa", "Dfa", |d| Months { coldest: -5.0, ..winter(d) });
    at(40.0, "Dsb", "Dfb", |d| Months { coldest: -5.0, warmest: 20.0, fourth: 12.0, ..summer(d) });
}

/// Every class can be reached, each by its own criteria.
#[test]
fn every_class_of_koeppen_exists() {
    let mut seen = std::collections::BTreeSet::new();
    for mean in (-40..32).step_by(2) {
        for swing in [1.0f32, 5.0, 6.0, 12.0, 16.0, 20.0, 24.0, 30.0, 36.0] {
            for (driest, wettest) in [(1.0, 30.0), (5.0, 160.0), (25.0, 100.0), (50.0, 200.0), (90.0, 200.0)] {
                for wet_summer in [false, true] {
                    for rain in [50.0, 250.0, 500.0, 900.0, 2500.0f32] {
                        let (s, w) = if wet_summer { (wettest, driest) } else { (driest, wettest) };
                        let m = Months {
                            rain,
                            summer_driest: s,
                            summer_wettest: s,
                            winter_driest: w,
                            winter_wettest: w,
                            ..even(mean as f32, swing)
                        };
                        seen.insert(class(&m));
                        let middle =
                            Months { summer_driest: driest, winter_driest: driest, ..even(mean as f32, swing) };
                        seen.insert(class(&middle));
                    }
                }
            }
        }
    }
    let missing: Vec<&str> =
        KOEPPEN_CLASSES[1..].iter().map(|c| c.name.split(' ').next().unwrap()).filter(|c| !seen.contains(c)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// The months of two known years: a Mediterranean one and a monsoon.
#[test]
fn months_come_from_the_first_harmonic() {
    // Warm in phase with (0, 1); rain against it.
    let dry_summer = Months::of_harmonics(17.0f32, [0.0, 8.0, 8.0], 700.0, [0.0, -650.0]);
    assert!((dry_summer.warmest - 24.9).abs() < 0.1 && (dry_summer.coldest - 9.1).abs() < 0.1);
    assert!(dry_summer.summer_driest < 6.0 && dry_summer.winter_wettest > 100.0 && dry_summer.summer_share < 0.3);
    assert_eq!(class(&dry_summer), "Csa");
    let monsoon = Months::of_harmonics(24.0f32, [3.0, 4.0, 5.0], 1500.0, [900.0, 1200.0]);
    assert!((monsoon.summer_wettest - 248.6).abs() < 1.0 && monsoon.winter_driest < 3.0 && monsoon.summer_share > 0.7);
    // Twelve months of the same year, one by one.
    let month = |i: usize| {
        let a = std::f32::consts::TAU * (i as f32 + 0.5) / 12.0;
        (1500.0 + 0.988_615_9 * (900.0 * a.cos() + 1200.0 * a.sin())) / 12.0
    };
    let wettest = (0..12).map(month).fold(0.0, f32::max);
    assert!((monsoon.summer_wettest - wettest).abs() < 0.04 * wettest);
    // Rain a quarter of a year after the warmth falls evenly on both halves.
    let late = Months::of_harmonics(10.0f32, [0.0, 8.0, 8.0], 1200.0, [600.0, 0.0]);
    assert!((late.summer_share - 0.5).abs() < 1e-3 && (late.summer_wettest - late.winter_wettest).abs() < 0.1);
}
