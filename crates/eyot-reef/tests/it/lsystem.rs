//! Grammars of the literature, with their lengths, segments and extents; and what every engine of L-systems must do right.

#![allow(missing_docs)]

use eyot_core::Limits;
use eyot_reef::lsystem::{Drawing, Grammar, Word};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn derive(text: &str, steps: u32) -> (Grammar, Word) {
    let grammar = Grammar::parse(text).unwrap();
    let word = grammar.derive(steps, 1, &Limits::default()).unwrap();
    (grammar, word)
}

fn draw(text: &str, steps: u32) -> (Word, Drawing) {
    let (grammar, word) = derive(text, steps);
    let drawing = grammar.draw(&word, 1, &Limits::default()).unwrap();
    (word, drawing)
}

fn lengths(text: &str, steps: std::ops::RangeInclusive<u32>) -> Vec<usize> {
    steps.map(|n| derive(text, n).1.len()).collect()
}

/// Segments that differ, directions aside.
fn distinct(drawing: &Drawing) -> usize {
    let key = |p: [f64; 3]| p.map(|v| (v * 1e6).round() as i64);
    let set: BTreeSet<_> =
        drawing.segments.iter().map(|s| (key(s.from).min(key(s.to)), key(s.from).max(key(s.to)))).collect();
    set.len()
}

/// Width (x) and height (z).
fn extent(drawing: &Drawing) -> [f64; 2] {
    let [low, high] = drawing.bounds().unwrap();
    [high[0] - low[0], high[2] - low[2]]
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// L1.
#[test]
fn strings_grow_by_fibonacci() {
    let algae = "axiom: b\n b -> a\n a -> ab";
    assert_eq!(lengths(algae, 0..=10), [1, 1, 2, 3, 5, 8, 13, 21, 34, 55, 89]);
    assert_eq!(derive(algae, 5).1.to_string(), "abaababa");
    // Anabaena: long and short cells, polar to the right (a, b) or to the left (c, d).
    let anabaena = "axiom: a\n a -> cb\n c -> da\n b -> a\n d -> c";
    assert_eq!(lengths(anabaena, 0..=10), [1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144]);
}

/// L1: among them Koch's quadratic curve, 5^n segments after n steps.
#[test]
fn curves_have_their_lengths_segments_and_extents() {
    let koch = "axiom: F-F-F-F\n F -> F-F+F+FF-F-F+F";
    assert_eq!(lengths(koch, 0..=3), [7, 59, 475, 3803]);
    let drawing = draw(koch, 3).1;
    let [low, high] = drawing.bounds().unwrap();
    assert_eq!((drawing.segments.len(), drawing.end), (2048, [0.0; 3]));
    assert_eq!((low[0], low[2], high[0], high[2]), (-21.0, -21.0, 85.0, 85.0));

    for (text, lengths_want, n, segments, size) in [
        ("axiom: F-F-F-F\n F -> F+FF-FF-F-F+F+FF-F-F+F+FF+FF-F", &[7, 123, 2211][..], 2, 1296, Some([64.0, 64.0])),
        (
            "axiom: F+F+F+F\n F -> F+f-FF+F+FF+Ff+FF-f+FF-F-FF-Ff-FFF\n f -> ffffff",
            &[7, 139, 2595],
            2,
            1296,
            Some([64.0, 64.0]),
        ),
        ("axiom: F-F-F-F\n F -> FF-F-F-F-F-F+F", &[7], 4, 16384, None),
        ("axiom: F-F-F-F\n F -> FF-F-F-F-FF", &[7], 4, 9604, Some([81.0, 81.0])),
        ("axiom: F-F-F-F\n F -> FF-F+F-F-FF", &[7], 3, 1372, None),
        ("axiom: F-F-F-F\n F -> FF-F--F-F", &[7], 4, 2500, Some([81.0, 81.0])),
        ("axiom: F-F-F-F\n F -> F-FF--F-F", &[7], 5, 12500, None),
        ("axiom: F-F-F-F\n F -> F-F+F-F-F", &[7], 4, 2500, None),
    ] {
        assert_eq!(lengths(text, 0..=lengths_want.len() as u32 - 1), lengths_want, "{text}");
        let drawing = draw(text, n).1;
        assert_eq!((drawing.segments.len(), drawing.end), (segments, [0.0; 3]), "{text}");
        if let Some(size) = size {
            assert_eq!(extent(&drawing), size, "{text}");
        }
    }
    let last_and_distinct = |text: &str, n: u32| {
        let (word, drawing) = draw(text, n);
        (word.len(), distinct(&drawing))
    };
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> FF-F-F-F-F-F+F", 4), (30427, 5184));
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> FF-F-F-F-FF", 4), (16007, 5184));
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> FF-F+F-F-FF", 3), (2287, 564));
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> FF-F--F-F", 4), (4999, 1412));
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> F-FF--F-F", 5), (24999, 6736));
    assert_eq!(last_and_distinct("axiom: F-F-F-F\n F -> F-F+F-F-F", 4), (4999, 1024));

    let snowflake = "axiom: -F\n F -> F+F-F-F+F";
    assert_eq!(lengths(snowflake, 0..=4), [2, 10, 50, 250, 1250]);
    let drawing = draw(snowflake, 4).1;
    assert_eq!((drawing.segments.len(), drawing.end, extent(&drawing)[1]), (625, [81.0, 0.0, 0.0], 40.0));
}

#[test]
fn space_filling_curves_fill_their_space() {
    let distance = |p: [f64; 3]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    let dragon = "axiom: L\n draw: LR\n L -> L+R+\n R -> -L-R";
    assert_eq!(lengths(dragon, 0..=3), [1, 4, 10, 22]);
    let (word, drawing) = draw(dragon, 10);
    assert_eq!((word.len(), drawing.segments.len(), distinct(&drawing)), (3070, 1024, 1024));
    assert_eq!(distance(drawing.end), 32.0);

    let arrowhead = "axiom: R\n angle: 60\n draw: LR\n L -> R+L+R\n R -> L-R-L";
    assert_eq!(lengths(arrowhead, 0..=6), [1, 5, 17, 53, 161, 485, 1457]);
    let drawing = draw(arrowhead, 6).1;
    assert!(
        near(distance(drawing.end), 64.0, 1e-9) && near(extent(&drawing)[0], 54.5596, 1e-4),
        "{:?}",
        extent(&drawing)
    );
    assert_eq!(drawing.segments.len(), 729);

    let hexagonal = "axiom: L\n angle: 60\n draw: LR\n L -> L+R++R-L--LL-R+\n R -> -L+RR++R+L--L-R";
    assert_eq!(lengths(hexagonal, 0..=4), [1, 15, 113, 799, 5601]);
    assert_eq!(draw(hexagonal, 4).1.segments.len(), 2401);

    let quadratic = "axiom: -R\n draw: LR\n L -> LL-R-R+L+L-R-RL+R+LLR-L+R+LL+R-LR-R-L+L+RR-\n R -> +LL-R-R+L+LR+L-RR-L-R+LRR-L-RL+L+R-R-L+L+RR";
    assert_eq!(lengths(quadratic, 0..=2), [2, 44, 1094]);
    let drawing = draw(quadratic, 2).1;
    assert_eq!((drawing.segments.len(), drawing.end, extent(&drawing)), (625, [25.0, 0.0, 0.0], [25.0, 25.0]));

    let hilbert = "axiom: L\n L -> +RF-LFL-FR+\n R -> -LF+RFR+FL-";
    assert_eq!(lengths(hilbert, 0..=5), [1, 11, 51, 211, 851, 3411]);
    let drawing = draw(hilbert, 5).1;
    assert_eq!((drawing.segments.len(), extent(&drawing)), (1023, [31.0, 31.0]));

    let cube = "axiom: A\n A -> B-F+CFC+F-D&F^D-F+&&CFC+F+B//\n B -> A&F^CFB^F^D^^-F-D^|F^B|FC^F^A//\n \
                C -> |D^|F^B-F+C^F^A&&FA&F^C+F+B^F^D//\n D -> |CFB-F+B|FA&F^A&&FB-F+B|FC//";
    for (n, length, segments, side) in [(1, 29, 7, 2), (2, 271, 63, 4), (3, 2155, 511, 8)] {
        let (word, drawing) = draw(cube, n);
        assert_eq!((word.len(), drawing.segments.len()), (length, segments));
        let key = |p: [f64; 3]| p.map(|v| v.round() as i64);
        let points: BTreeSet<_> = drawing.segments.iter().flat_map(|s| [key(s.from), key(s.to)]).collect();
        let [low, high] = drawing.bounds().unwrap();
        assert_eq!(points.len(), side * side * side);
        assert!((0..3).all(|i| near(high[i] - low[i], side as f64 - 1.0, 1e-9)));
    }
}

#[test]
fn bracketed_plants_have_their_height() {
    for (text, n, length, segments, different, height) in [
        ("axiom: F\n angle: 25.7\n F -> F[+F]F[-F]F", 5, 7811, 3125, 3125, 243.0),
        ("axiom: F\n angle: 20\n F -> F[+F]F[-F][F]", 5, 9373, 3125, 1760, 63.0),
        ("axiom: F\n angle: 22.5\n F -> FF-[-F+F+F]+[+F-F-F]", 4, 11116, 4096, 3344, 55.8983),
        ("axiom: X\n angle: 20\n X -> F[+X]F[-X]+X\n F -> FF", 7, 13956, 4118, 0, 248.93),
        ("axiom: X\n angle: 25.7\n X -> F[+X][-X]FX\n F -> FF", 7, 12863, 4118, 0, 254.0),
        ("axiom: X\n angle: 22.5\n X -> F-[[X]+X]+F[+FX]-X\n F -> FF", 5, 6263, 1488, 1000, 80.1663),
    ] {
        let (word, drawing) = draw(text, n);
        assert_eq!((word.len(), drawing.segments.len()), (length, segments), "{text}");
        assert!(near(extent(&drawing)[1], height, 5e-3), "{text}: {:?}", extent(&drawing));
        assert!(different == 0 || distinct(&drawing) == different, "{text}: {}", distinct(&drawing));
    }
    let wide = draw("axiom: X\n angle: 20\n X -> F[+X]F[-X]+X\n F -> FF", 7).1;
    assert!(near(extent(&wide)[0], 140.2, 0.05), "{:?}", extent(&wide));
    let bush = "axiom: A\n angle: 22.5\n A -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\n F -> S/////F\n S -> FL\n L -> ['''^^{-f+f+f-|-f+f+f}]";
    assert_eq!(lengths(bush, 0..=7), [1, 35, 221, 800, 2642, 8294, 25481, 77399]);
    let leaves = draw(bush, 4).1.polygons;
    assert!(!leaves.is_empty() && leaves.iter().all(|l| l.points.len() == 7));
}

/// Rules of Hogeweg and Hesper: successors of 0 and 1 between 0 and 0, 0 and 1, and so on.
fn hogeweg(angle: f64, successors: [&str; 8]) -> String {
    let mut text = format!("axiom: F1F1F1\n angle: {angle}\n ignore: +-F\n");
    for (i, s) in successors.iter().enumerate() {
        text += &format!("{} < {} > {} -> {s}\n", i >> 2, i >> 1 & 1, i & 1);
    }
    text + "+ -> -\n- -> +\n"
}

#[test]
fn context_sensitive_grammars_have_their_lengths() {
    for (successors, n, length, steps) in [
        (["0", "1[+F1F1]", "1", "1", "0", "1F1", "0", "0"], 30, 6910, 2501),
        (["1", "1[-F1F1]", "1", "1", "0", "1F1", "1", "0"], 30, 19199, 5626),
        (["0", "1", "0", "1[+F1F1]", "0", "1F1", "0", "0"], 26, 2926, 944),
        (["1", "0", "0", "1F1", "1", "1[+F1F1]", "1", "0"], 24, 7145, 2356),
        (["0", "1[-F1F1]", "1", "1", "0", "1F1", "1", "0"], 26, 2428, 824),
    ] {
        let (_, word) = derive(&hogeweg(22.5, successors), n);
        assert_eq!((word.len(), word.count('F')), (length, steps), "{successors:?}");
    }
}

#[test]
fn contexts_skip_branches_and_may_name_them() {
    // The example of the literature: BC < S > G[H]M fits S in ABC[DE][SG[HI[JK]L]MNO].
    let word = |context: &str| derive(&format!("axiom: ABC[DE][SG[HI[JK]L]MNO]\n {context} -> x"), 1).1.to_string();
    assert_eq!(word("BC < S > G[H]M"), "ABC[DE][xG[HI[JK]L]MNO]");
    assert_eq!(word("ABC < S > GMN"), "ABC[DE][xG[HI[JK]L]MNO]");
    assert_eq!(word("BC < S > G[HI[J]L]MNO"), "ABC[DE][xG[HI[JK]L]MNO]");
    for other in ["E < S", "S > GH", "S > G[I]M", "S > GMNOP", "S > G[H]O"] {
        assert_eq!(word(other), "ABC[DE][SG[HI[JK]L]MNO]", "{other}");
    }
    // Signals up and down an axis with branches, ignored symbols between.
    let up = "axiom: J[I]I[I]I[I]I\n J < I -> J";
    assert_eq!(derive(up, 1).1.to_string(), "J[J]J[I]I[I]I");
    assert_eq!(derive(up, 2).1.to_string(), "J[J]J[J]J[I]I");
    let down = "axiom: I[I]I[I]I[I]J\n ignore: +\n I > J -> J";
    assert_eq!(derive(down, 3).1.to_string(), "J[I]J[I]J[I]J");
    assert_eq!(derive("axiom: A+B\n ignore: +\n A < B -> C", 1).1.to_string(), "A+C");
    assert_eq!(derive("axiom: A+B\n A < B -> C", 1).1.to_string(), "A+B");
    // Parameters of contexts, and conditions.
    let flow = "axiom: A(1)A(5)A(2)\n A(l) < A(x) > A(r) : l < r -> A(x + l * r)";
    assert_eq!(derive(flow, 1).1.to_string(), "A(1)A(7)A(2)");
}

#[test]
fn parametric_grammars_compute() {
    let branching = "axiom: A(1)\n angle: 85\n define: R = 1.456\n A(s) -> F(s)[+A(s/R)][-A(s/R)]";
    let (word, drawing) = draw(branching, 11);
    let total: f64 =
        drawing.segments.iter().map(|s| (0..3).map(|i| (s.to[i] - s.from[i]).powi(2)).sum::<f64>().sqrt()).sum();
    assert_eq!((word.count('F'), drawing.segments.len()), (2047, 2047));
    assert!(near(total, 85.24953, 1e-5), "{total}");

    let trees = "axiom: -(90)F(1)\n angle: 86\n define: c = 1\n define: p = 0.3\n define: q = c - p\n define: h = (p*q)^0.5\n \
                 F(x) -> F(x*p)+F(x*h)--F(x*h)+F(x*q)";
    for n in 1..7 {
        let (_, word) = derive(trees, n);
        let total: f64 =
            (0..word.len()).filter(|&i| word.symbols()[i].to_string() == "F").map(|i| word.numbers(i)[0]).sum();
        assert_eq!(word.count('F'), 4usize.pow(n));
        assert!(near(total, 1.916_515_1f64.powi(n as i32), 1e-4), "{n}: {total}");
    }

    let ternary = "axiom: !(1)F(200)/(45)A\n define: d1 = 94.74\n define: d2 = 132.63\n define: a = 18.95\n define: lr = 1.109\n \
                   define: vr = 1.732\n A -> !(vr)F(50)[&(a)F(50)A]/(d1)[&(a)F(50)A]/(d2)[&(a)F(50)A]\n F(l) -> F(l*lr)\n \
                   !(w) -> !(w*vr)";
    let (_, word) = derive(ternary, 6);
    assert_eq!((word.count('F'), word.count('A')), (1457, 729));
}

/// The coral of the source: 25 branches, of which each grows two more with a probability of 0.9 and one with 0.1.
fn coral() -> String {
    let branches = "[&(30)A]".repeat(25);
    format!("axiom: {branches}\nangle: 25\nA @ 0.5 -> F[+A][-A]\nA @ 0.4 -> F[&A][^A]\nA @ 0.1 -> F[+A]\n")
}

#[test]
fn stochastic_rules_come_as_often_as_they_weigh() {
    let grammar = Grammar::parse(&coral()).unwrap();
    let (mut counts, mut segments) = ([0.0f64; 3], 0.0);
    let seeds = 2000;
    for seed in 0..seeds {
        let first = grammar.derive(1, seed, &Limits::default()).unwrap().to_string();
        counts[0] += first.matches("F[+A][-A]").count() as f64;
        counts[1] += first.matches("F[&A][^A]").count() as f64;
        counts[2] += first.matches("F[+A]]").count() as f64;
        // Parents are kept: 25 (1 + 1.9 + 1.9^2 + 1.9^3) segments, the last ones still as apices.
        let last = grammar.derive(3, seed, &Limits::default()).unwrap();
        segments += (last.count('F') + last.count('A')) as f64;
    }
    let n = 25.0 * seeds as f64;
    let chi2: f64 = counts.iter().zip([0.5, 0.4, 0.1]).map(|(c, p)| (c - n * p).powi(2) / (n * p)).sum();
    // Two degrees of freedom: 99.99 % lie below 18.4.
    assert!(counts.iter().sum::<f64>() == n && chi2 < 18.4, "{counts:?} {chi2}");
    let mean = segments / seeds as f64;
    let want: f64 = 25.0 * (1.0 + 1.9 + 1.9f64.powi(2) + 1.9f64.powi(3));
    assert!(near(want, 334.2, 0.05) && near(mean, want, 1.5), "{mean} {want}");
    // The same seed gives the same word, another one another.
    let of = |seed: u64| grammar.derive(6, seed, &Limits::default()).unwrap();
    assert!(of(3) == of(3) && of(3) != of(4));
}

#[test]
fn threads_change_nothing() {
    let grammar = Grammar::parse(&coral()).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| grammar.derive(10, 5, &Limits::default()).unwrap())
    };
    let one = with(1);
    assert!(one.len() > 30_000 && one == with(4));
}

#[test]
fn decomposition_happens_after_each_step_and_interpretation_only_in_the_drawing() {
    // A decomposes into as many cells as it is long.
    let text = "axiom: A(3)\n A(x) -> A(x + 1)\n decomposition: 20\n A(x) : x > 1 -> A(x - 1)B";
    assert_eq!(derive(text, 0).1.to_string(), "A(1)BB");
    assert_eq!(derive(text, 1).1.to_string(), "A(1)BBB");
    let text = "axiom: L(2)\n L(n) -> L(n + 1)\n interpretation:\n L(n) : n > 0 -> F[+F]L(n - 1)";
    let (word, drawing) = draw(text, 2);
    assert_eq!((word.to_string().as_str(), drawing.segments.len()), ("L(4)", 8));
    assert_eq!(extent(&drawing), [1.0, 4.0]);
    // A recursion without end stops at its depth.
    let endless = "axiom: A\n A -> A\n interpretation: 50\n A -> FA";
    assert_eq!(draw(endless, 1).1.segments.len(), 50);
}

#[test]
fn cuts_take_the_rest_of_their_branch() {
    assert_eq!(derive("axiom: A[B%C[D]E]F", 1).1.to_string(), "A[B]F");
    assert_eq!(derive("axiom: A%B[C]", 1).1.to_string(), "A");
    let shed = "axiom: X[A[B]C]Y\n A -> A%";
    assert_eq!(derive(shed, 1).1.to_string(), "X[A]Y");
}

#[test]
fn queries_tell_place_and_directions_and_ask_the_environment() {
    let place = "axiom: F(2)-(90)F(3)?P(0,0,0)?H(0,0,0)[&(90)f(1)?P(0,0,0)]";
    let text = derive(place, 1).1.to_string();
    assert_eq!(text, "F(2)-(90)F(3)?P(3,0,2)?H(1,0,0)[&(90)f(1)?P(3,1,2)]");
    // Growth stops where the environment says so: below a roof at z = 5.
    let grammar = Grammar::parse("axiom: A?E(1)\n A > ?E(free) : free > 0 -> FA").unwrap();
    let roof = |ask: &eyot_reef::lsystem::Ask<'_>| {
        assert_eq!((ask.name, ask.heading), ('E', [0.0, 0.0, 1.0]));
        vec![if ask.position[2] < 5.0 { 1.0 } else { 0.0 }]
    };
    let word = grammar.derive_in(20, 1, &Limits::default(), &roof).unwrap();
    assert_eq!(word.to_string(), "FFFFFA?E(0)");
}

#[test]
fn tropism_bends_towards_its_direction() {
    let text = |e: f64| format!("axiom: -(90)F\n tropism: 0 0 1\n elasticity: {e}\n F -> FF");
    let straight = draw(&text(0.0), 5).1;
    let bent = draw(&text(0.1), 5).1;
    assert_eq!(straight.end, [32.0, 0.0, 0.0]);
    assert!(bent.end[2] > 20.0 && bent.end[0] < 15.0);
    let last = bent.segments.last().unwrap();
    let length: f64 = (0..3).map(|i| (last.to[i] - last.from[i]).powi(2)).sum();
    assert!(near(length, 1.0, 1e-12) && last.to[2] - last.from[2] > 0.99);
    // Against it nothing pulls sideways.
    assert_eq!(draw("axiom: FFF\n tropism: 0 0 -1\n elasticity: 1", 0).1.end, [0.0, 0.0, 3.0]);
}

#[test]
fn turtles_level_themselves_and_taper() {
    let (_, drawing) = draw("axiom: &(30)/(77)$?L(0,0,0)!(2)F!F['(3)F][F]F\n thinning: 0.5", 0);
    let widths: Vec<[f64; 2]> = drawing.segments.iter().map(|s| s.widths).collect();
    assert_eq!(widths[..2], [[2.0, 2.0], [1.0, 1.0]]);
    assert_eq!(drawing.segments.iter().map(|s| s.colour).collect::<Vec<_>>(), [0, 0, 3, 0, 0]);
    assert_eq!(
        drawing.segments.iter().map(|s| s.parent).collect::<Vec<_>>(),
        [None, Some(0), Some(1), Some(1), Some(1)]
    );
    let (_, word) = derive("axiom: &(30)/(77)$?L(0,0,0)", 0);
    assert!(word.numbers(3)[2].abs() < 1e-12);
}

#[test]
fn polylines_join_the_segments_of_an_axis() {
    let (_, drawing) = draw("axiom: FF[+FF]F[-F]ffF", 0);
    let lines = drawing.polylines();
    let points: Vec<usize> = lines.iter().map(|l| l.points.len()).collect();
    assert_eq!(points, [4, 3, 2, 2]);
    assert_eq!((lines[0].points[3], lines[1].points[0]), ([0.0, 0.0, 3.0], [0.0, 0.0, 2.0]));
    assert!(lines.iter().all(|l| l.points.len() == l.widths.len()));
}

/// L1.
#[test]
fn brackets_stay_in_balance() {
    for text in [
        "axiom: F\n F -> F[+F]F[-F]F",
        "axiom: X\n X -> F-[[X]+X]+F[+FX]-X\n F -> FF",
        "axiom: A\n A -> [+A%B][-A]\n B -> [B]B",
    ] {
        for n in 0..=5 {
            let word = derive(text, n).1.to_string();
            let depths: Vec<i64> = word
                .chars()
                .scan(0, |depth, c| {
                    *depth += i64::from(c == '[') - i64::from(c == ']');
                    Some(*depth)
                })
                .collect();
            assert!(
                depths.iter().all(|&d| d >= 0) && depths.last().is_none_or(|&d| d == 0),
                "{text} after {n}: {word}"
            );
        }
    }
    assert!(Grammar::parse("axiom: F]").is_err() || Grammar::parse("axiom: F[").is_err());
}

/// L1.
#[test]
fn explosions_are_refused_before_memory_is_gone() {
    let limits = Limits { max_bytes: 1 << 20, ..Limits::default() };
    let bomb = Grammar::parse("axiom: F\n F -> FFFFFFFFFF").unwrap();
    let refused = bomb.derive(100, 1, &limits).unwrap_err().to_string();
    assert!(refused.contains("the word of a grammar"), "{refused}");
    let endless = Grammar::parse("axiom: A\n A -> A\n decomposition: 1000\n A -> AA").unwrap();
    assert!(endless.derive(1, 1, &limits).is_err());
    let drawn = Grammar::parse("axiom: A\n A -> A\n interpretation: 1000\n A -> FAA").unwrap();
    let word = drawn.derive(1, 1, &limits).unwrap();
    assert!(drawn.draw(&word, 1, &limits).is_err());
    let far = Grammar::parse("axiom: F(1)\n F(x) -> F(x*x*1e300 + 1e300)").unwrap();
    let word = far.derive(3, 1, &limits).unwrap();
    assert!(far.draw(&word, 1, &limits).unwrap_err().to_string().contains("range of numbers"));
}

#[test]
fn bad_grammars_are_refused_with_the_line() {
    for (text, part) in [
        ("", "axiom"),
        ("F -> FF", "axiom"),
        ("axiom: F\nF -> F[F", "line 2: `[` without `]`"),
        ("axiom: F]", "line 1: `]` without `[`"),
        ("axiom: F\nFG -> F", "exactly one module"),
        ("axiom: F\n[ -> F", "brackets cannot be replaced"),
        ("axiom: F\nA[B < F -> F", "no brackets"),
        ("axiom: F\nF(x,x) -> F", "there twice"),
        ("axiom: F\nF(x) -> F(y)", "no parameter or constant `y`"),
        ("axiom: F\nF(x) : x > -> F", "expected a number"),
        ("axiom: F(1/0)\nF(x) : x x -> F", "left over"),
        ("axiom: F\ncolour: 3", "no setting `colour`"),
        ("axiom: F\nsteps: -1", "whole number"),
        ("axiom: F\ntropism: 1 2", "three numbers"),
        ("axiom: ?1", "a query is"),
        ("axiom: F(2", "expected `)`"),
        ("nonsense", "line 1"),
    ] {
        let got = Grammar::parse(text).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(got.contains(part), "{text:?}: {got}");
    }
}

proptest! {
    #[test]
    fn any_text_is_a_grammar_or_refused(text in "(axiom: [AF+\\-\\[\\](1)]{1,12}\n)?([AF(x)<>:@ +*/.0-9\\[\\]%?P-]{1,16}-> [AF(x+1)\\[\\]%,?P]{0,16}\n){0,4}") {
        if let Ok(grammar) = Grammar::parse(&text) {
            let limits = Limits { max_bytes: 1 << 20, ..Limits::default() };
            if let Ok(word) = grammar.derive(6, 1, &limits) {
                let _ = grammar.draw(&word, 1, &limits);
            }
        }
    }
}
