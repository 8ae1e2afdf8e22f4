//! Texts as the engine runs them, against the same texts on one cell at a time.

use crate::evaluate::Evaluation;
use crate::typecheck::{Given, Known, Scope, Uses, Wanted, check};
use crate::unit::Measure;
use crate::{ExprProcess, LayerDefinition, RuleDefinition, layer, rule};
use eyot_core::conformance::{self, random_world};
use eyot_core::control::Control;
use eyot_core::engine::CpuEngine;
use eyot_core::isa::Isa;
use eyot_core::process::{Scheduled, Span};
use eyot_core::rng::{self, Key};
use eyot_core::rule::Cell;
use eyot_core::{BoundaryCondition, Error, LayerSpec, World};
use proptest::prelude::*;

const ALL: (f32, f32) = (f32::MIN, f32::MAX);

/// Layers `a` and `b` that the recipe declares.
fn scope() -> Scope {
    let mut scope = Scope::default();
    for (order, name) in ["a", "b"].into_iter().enumerate() {
        let spec = LayerSpec::new(name, "1", "", ALL);
        let d = LayerDefinition { spec: spec.clone(), measured: false, start: "random()".into(), parameters: vec![] };
        let declared = layer(&d, order, &scope).unwrap();
        scope.layers.push(Known { spec, measured: false, declared: Some(declared) });
    }
    scope
}

fn parameters() -> Vec<(String, f32)> {
    vec![("p".into(), 0.75), ("q".into(), -2.0)]
}

fn scheduled(text: &str) -> Vec<Scheduled> {
    let d = RuleDefinition {
        name: "r".into(),
        values: vec![("a".into(), text.into())],
        mask: None,
        parameters: parameters(),
    };
    let rule = rule(&d, None, &scope()).unwrap_or_else(|e| panic!("{text}: {e:?}"));
    let values = rule.parameters.iter().map(|(_, v)| *v).collect();
    vec![Scheduled { name: "r", process: Box::new(ExprProcess { rule, values }), every: 1 }]
}

fn start(_: &str, u: f32) -> f32 {
    4.0 * u - 2.0
}

/// A cell of a world, written to be obviously right.
struct One<'a> {
    world: &'a World,
    reads: &'a [String],
    x: usize,
    y: usize,
}

fn place(i: isize, n: usize, edge: BoundaryCondition) -> usize {
    if edge == BoundaryCondition::Wrap {
        i.rem_euclid(n as isize) as usize
    } else {
        i.clamp(0, n as isize - 1) as usize
    }
}

impl Cell<f32> for One<'_> {
    fn at(&self, slot: usize, dx: isize, dy: isize) -> f32 {
        let g = &self.world.grid;
        let (x, y) = (self.x as isize + dx, self.y as isize + dy);
        let field = &self.world.layer(&self.reads[slot]).unwrap().field;
        field.get(place(x, g.width, g.rim.x), place(y, g.height, g.rim.y))
    }
    fn x(&self) -> f32 {
        self.x as f32
    }
    fn y(&self) -> f32 {
        self.y as f32
    }
    fn uniform(&self, stream: u32) -> f32 {
        let cell = (self.y * self.world.grid.width + self.x) as u32;
        rng::unit::<f32>(rng::hash(Key::new(self.world.seed, stream, self.world.step), cell))
    }
}

/// What one step makes of every cell.
fn by_hand(text: &str, world: &World) -> Vec<f32> {
    let mut uses = Uses::default();
    let scope = scope();
    let first = crate::rule::stream("r", "");
    let wanted = Wanted::Number(&Measure::Unknown, "a");
    let formula = check(text, wanted, &scope, &parameters(), first, &mut uses).unwrap();
    let g = &world.grid;
    let own: Vec<f32> = parameters().iter().map(|p| p.1).collect();
    let value = |given: &Given| given.value(&own, g, world.sea_level_m, world.step);
    let params: Vec<f32> = uses.params.iter().map(value).collect();
    let cells = (0..g.height).flat_map(|y| (0..g.width).map(move |x| (x, y)));
    let at = |(x, y)| Evaluation::new(&formula, &params, &One { world, reads: &uses.reads, x, y }).number();
    // As every rule of a recipe ends.
    cells.map(at).map(|v| if v.abs() < 1e-30 { 0.0 } else { v }).collect()
}

fn agrees(text: &str, shape: (usize, usize), seed: u64) {
    for (i, rim) in conformance::rims().into_iter().enumerate().filter(|(i, _)| *i as u64 % 3 == seed % 3) {
        let processes = scheduled(text);
        let mut world = random_world(shape, rim, seed + i as u64, &processes, &start).unwrap();
        (world.step, world.sea_level_m) = (11, 0.25);
        let want = by_hand(text, &world);
        for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
            let mut got = world.clone();
            let engine = CpuEngine { isa, ..CpuEngine::default() };
            match engine.simulate(&mut got, &processes, Span { from: 0, steps: 1 }, &Control::none()) {
                Ok(()) | Err(Error::NotFinite { .. }) => {}
                Err(e) => panic!("{e}"),
            }
            for (n, (got, want)) in got.layer("a").unwrap().field.iter().zip(&want).enumerate() {
                let same = got.to_bits() == want.to_bits() || (got.is_nan() && want.is_nan());
                assert!(same, "`{text}` in cell {n} of {shape:?}, {rim:?}, {}: {got}, not {want}", isa.name());
            }
        }
    }
}

/// Texts of numbers. Functions of neighbours get texts without random numbers and offsets.
fn texts() -> impl Strategy<Value = String> {
    let quiet = prop_oneof![
        (-30i32..30).prop_map(|n| format!("{:?}", f64::from(n) / 8.0)),
        proptest::sample::select(vec!["a", "b", "p", "q", "x", "u", "v", "steps", "sea_level", "row", "pi"])
            .prop_map(str::to_owned),
    ];
    let quiet = grown(quiet.boxed(), false);
    let leaf = prop_oneof![
        4 => quiet.clone(),
        2 => (-2i32..3, -2i32..3).prop_map(|(x, y)| format!("a[{x}, {y}]")),
        1 => Just("random()".to_owned()),
        2 => (proptest::sample::select(vec!["sum4", "sum8", "mean4", "mean8", "min4", "min8", "max4", "max8", "laplacian",
            "slope", "slope_x", "slope_y"]), quiet).prop_map(|(f, a)| format!("{f}({a})")),
    ];
    grown(leaf.boxed(), true)
}

fn grown(leaf: BoxedStrategy<String>, large: bool) -> BoxedStrategy<String> {
    let (depth, size) = if large { (3, 16) } else { (1, 4) };
    leaf.prop_recursive(depth, size, 3, |inner| {
        let two = ["+", "-", "*", "/"];
        let compare = ["<", "<=", ">", ">=", "==", "!="];
        let one = ["abs", "sqrt", "exp", "ln", "sin", "cos", "floor", "ceil", "round", "fract", "sign", "log10", "-"];
        let condition = (inner.clone(), proptest::sample::select(compare.to_vec()), inner.clone(), any::<u8>())
            .prop_map(|(a, op, b, n)| match n % 4 {
                0 => format!("{a} {op} {b} and a > 0"),
                1 => format!("{a} {op} {b} or not b > p"),
                2 => format!("not ({a} {op} {b})"),
                _ => format!("{a} {op} {b}"),
            });
        prop_oneof![
            (inner.clone(), proptest::sample::select(two.to_vec()), inner.clone())
                .prop_map(|(a, op, b)| format!("({a} {op} {b})")),
            (proptest::sample::select(one.to_vec()), inner.clone()).prop_map(|(f, a)| format!("{f}({a})")),
            (proptest::sample::select(vec!["min", "max", "step", "hypot", "mod", "pow"]), inner.clone(), inner.clone())
                .prop_map(|(f, a, b)| format!("{f}({a}, {b} + 0.5)")),
            (proptest::sample::select(vec!["clamp", "mix", "smoothstep"]), inner.clone(), inner.clone())
                .prop_map(|(f, a, b)| format!("{f}({a}, {b}, 1.5)")),
            (condition, inner.clone(), inner.clone()).prop_map(|(c, a, b)| format!("if({c}, {a}, {b})")),
            (inner.clone(), 0u32..9).prop_map(|(a, n)| format!("({a})^{n}")),
        ]
    })
    .boxed()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn any_text_gives_the_bits_of_the_scalar_reference(
        text in texts(), width in 1usize..80, height in 1usize..5, seed in 0u64..1000,
    ) {
        let mut uses = Uses::default();
        let wanted = Wanted::Number(&Measure::Unknown, "a");
        // What is refused (a division by what is always 0, a constant that is not finite) is tested elsewhere.
        let valid = check(&text, wanted, &scope(), &parameters(), 0, &mut uses).is_ok() && can_be(&text);
        prop_assume!(valid);
        agrees(&text, (width, height), seed);
    }
}

/// Whether constants of the text stay finite.
fn can_be(text: &str) -> bool {
    let d = RuleDefinition {
        name: "r".into(),
        values: vec![("a".into(), text.into())],
        mask: None,
        parameters: parameters(),
    };
    rule(&d, None, &scope()).is_ok()
}

#[test]
fn texts_mean_what_they_say() {
    // Each is always 1.
    for text in [
        "if(1 < 2, 1, 0)",
        "1 + 2 * 3 - 6",
        "2 ^ 3 ^ 2 / 512",
        "-2 ^ 2 + 5",
        "if(not 1 > 2 and 3 >= 3 or false, 1, 0)",
        "a[0, 0] - a + 1",
        "if(sum8(1) == 8 and sum4(1) == 4 and mean8(3) == 3, 1, 0)",
        "half = 0.5; whole = half + half; whole",
        "near = a >= a; if(near and near, 1, 0)",
        "max(min(3, 2, 4), 1) - 1",
        "clamp(5, 0, 1)",
        "step(0.5, 0.5) # a comment",
        "round(0.5) + floor(-0.5) + ceil(0.2)",
        "mod(-1, 3) - 1",
        "smoothstep(0, 1, 2)",
        "mix(0, 2, 0.5)",
        "sqrt(-4) + 1",
        "if(a == a and not a != a and a <= a, 1, 0)",
        "row_of = row; row_of[0, 1] - row",
        "if(u > 0 and u < 1 and abs(x - (column + 0.5) * cell_x) < 0.01, 1, 0)",
        "sign(-3) * sign(-0.1)",
        "laplacian(x * x / 2) - laplacian(y * 0) + 0 * laplacian(a)",
    ] {
        let mut world = random_world((5, 4), eyot_core::Boundary::WRAP, 1, &scheduled(text), &start).unwrap();
        let span = Span { from: 0, steps: 1 };
        CpuEngine::default().simulate(&mut world, &scheduled(text), span, &Control::none()).unwrap();
        let field = &world.layer("a").unwrap().field;
        assert!(field.iter().all(|v| (v - 1.0).abs() < 1e-5), "{text}: {:?}", field.iter().collect::<Vec<_>>());
    }
}

#[test]
fn rules_pass_the_suite_of_the_core() {
    for text in [
        "0.5 * a + 0.1 * (mean8(b[0, 0]) - a[2, -1]) + 0.01 * random()",
        "if(a > b[1, 1] and random() < p, mean4(a), 0.9 * b)",
        "exp(-abs(laplacian(a))) + sin(0.1 * x) * steps",
    ] {
        conformance::check(&scheduled(text), &start).unwrap();
        conformance::check_access(&scheduled(text), &start).unwrap();
        assert!(conformance::check_windows(&scheduled(text), &start).unwrap(), "{text}");
    }
}

#[test]
fn calls_of_random_differ_and_are_uniform() {
    let processes = scheduled("if(random() == random(), 1, 0) + random()");
    let mut world = random_world((64, 64), eyot_core::Boundary::CLOSED, 1, &processes, &start).unwrap();
    CpuEngine::default().simulate(&mut world, &processes, Span { from: 0, steps: 1 }, &Control::none()).unwrap();
    let field = &world.layer("a").unwrap().field;
    let mean = field.iter().map(f64::from).sum::<f64>() / 4096.0;
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
}

/// What is wrong is found at its character: text, the characters in question, words of the message.
#[test]
fn mistakes_have_their_place() {
    let deep = format!("{}a{}", "(".repeat(50), ")".repeat(50));
    let long = vec!["a"; 400].join(" + ");
    let cases: [(&str, &str, &str); 40] = [
        ("a + watre", "watre", "nothing is called `watre`"),
        ("a + (b", "", "ends where `)`"),
        ("a b", "b", "stands where an operator"),
        ("", "", "ends where a value"),
        ("a + * b", "*", "stands where a value"),
        ("a && b", "&&", "means nothing"),
        ("a = 3", "", "ends where `;`"),
        ("q = a < 3; q", "q", "is the name of something else"),
        ("c = 3", "", "ends where `;`"),
        ("a + (b > 1)", "b > 1", "condition where a number"),
        ("if(a, 1, 2)", "a", "number where a condition"),
        ("not a", "a", "number where a condition"),
        ("a and b > 1", "a", "number where a condition"),
        ("a > 1", "a > 1", "condition where a number"),
        ("min(a)", "min(a)", "takes 2 to 16 arguments, not 1"),
        ("clamp(a, 1)", "clamp(a, 1)", "takes 3 arguments, not 2"),
        ("foo(a)", "foo", "no function `foo`"),
        ("a(1)", "a", "`a` is no function"),
        ("random + 1", "random", "is a function"),
        ("a[3, 0]", "a[3, 0]", "looks 3 cells away"),
        ("a[-1, 4]", "a[-1, 4]", "looks 4 cells away"),
        ("mean4(a[2, 0])", "a[2, 0]", "3 cells away"),
        ("mean4(mean4(mean4(a)))", "mean4(a)", "nested more than 2"),
        ("far = a[2, 0]; far[1, 0]", "far[1, 0]", "3 cells away"),
        ("a[0.5, 0]", "0.5", "whole number"),
        ("a[1]", "]", "stands where `,`"),
        ("a@(1, 0)", "@", "stands where an operator"),
        ("p[1, 0]", "p[1, 0]", "has no neighbours"),
        ("mean4(random())", "random()", "its own cell's"),
        ("dice = random(); dice[1, 0]", "dice[1, 0]", "its own cell's"),
        ("1 / 0", "0", "divides by zero"),
        ("a / (2 - 2)", "2 - 2", "divides by zero"),
        ("mod(a, 0)", "0", "divides by zero"),
        ("1e39", "1e39", "beyond what a number can be"),
        ("1e38 * 1e38", "1e38 * 1e38", "beyond what a number can be"),
        ("a < b < 3", "<", "cannot be chained"),
        ("a ? b", "?", "means nothing"),
        ("a + é", "é", "means nothing"),
        (&deep, "(", "nested more than 40"),
        (&long, "a", "more than 512"),
    ];
    for (text, place, message) in cases {
        let mut uses = Uses::default();
        let wanted = Wanted::Number(&Measure::Unknown, "a");
        let mistake = check(text, wanted, &scope(), &parameters(), 0, &mut uses).expect_err(text);
        assert!(mistake.message.contains(message), "`{text}`: {}", mistake.message);
        // The deep one is where the limit is met, the long one the whole that became too large.
        if text.len() < 60 {
            assert_eq!(&text[mistake.span.clone()], place, "`{text}`: {mistake:?}");
        }
        assert!(mistake.help.is_some() || mistake.unknown.is_some() || message.contains("where"), "{text}");
    }
    let mut uses = Uses::default();
    let over = "a+".repeat(3000) + "a";
    let e = check(&over, Wanted::Condition, &scope(), &[], 0, &mut uses).unwrap_err();
    assert!(e.message.contains("6001 bytes"), "{}", e.message);
}

#[test]
fn units_that_do_not_go_together_are_found() {
    let mut scope = scope();
    for (name, unit) in [("water", "m"), ("heat", "degC"), ("speed", "m/s"), ("share", "1"), ("area", "m2")] {
        scope.layers.push(Known { spec: LayerSpec::new(name, unit, "", ALL), measured: true, declared: None });
    }
    let metres = Measure::of("m");
    let check =
        |text: &str| check(text, Wanted::Number(&metres, "water"), &scope, &parameters(), 0, &mut Uses::default());
    for text in [
        "water + 0.1 * heat",
        "water + p * speed",
        "sqrt(area) + water",
        "area / water + water * exp(share)",
        "if(heat > 3, water, sea_level)",
        "water * share + x + laplacian(water) * area",
        "mean4(water) + a",
        "hypot(water, y) * (water / sea_level)",
        "(water^3)^(1/3) + area^0.5",
        "water + slope(water) * cell_x",
    ] {
        assert!(check(text).is_ok(), "{text}: {:?}", check(text));
    }
    for (text, place, words) in [
        ("water + heat", "+", "m and °C do not go together"),
        ("water + share", "+", "m and 1"),
        ("if(water > heat, water, water)", ">", "m and °C"),
        ("max(water, speed)", "speed", "m and m/s"),
        ("exp(water) * water", "water", "takes a plain number, this is in m"),
        ("heat", "heat", "this is in °C, the layer `water` in m"),
        ("water * water", "water * water", "this is in m2"),
        ("laplacian(water)", "laplacian(water)", "this is in 1/m"),
        ("if(share > 0, water, heat)", "heat", "m and °C"),
        ("share^water", "water", "an exponent takes a plain number"),
        ("step(sea_level, u) * water", "u", "m and 1"),
    ] {
        let mistake = check(text).expect_err(text);
        assert!(mistake.message.contains(words), "{text}: {}", mistake.message);
        assert_eq!(&text[mistake.span.clone()], place, "{text}");
    }
}

#[test]
fn a_rule_reads_ten_layers_and_no_more() {
    let mut scope = scope();
    for i in 0..12 {
        let spec = LayerSpec { name: format!("l{i}").into(), ..LayerSpec::new("", "1", "", ALL) };
        scope.layers.push(Known { spec, measured: false, declared: None });
    }
    let text: Vec<String> = (0..11).map(|i| format!("l{i}")).collect();
    let (ten, eleven) = (text[..10].join(" + "), text.join(" + "));
    let check = |text: &str| check(text, Wanted::Number(&Measure::Unknown, "a"), &scope, &[], 0, &mut Uses::default());
    assert!(check(&ten).is_ok());
    let mistake = check(&eleven).unwrap_err();
    assert_eq!(&eleven[mistake.span.clone()], "l10");
}

/// Words that would be wrong in a shader or the same as its own.
#[test]
fn named_conditions_do_not_grow() {
    let mut text = "c0 = a > 0;".to_owned();
    for i in 1..60 {
        text += &format!("c{i} = c{} and c{} or not c{};", i - 1, i - 1, i - 1);
    }
    text += "if(c59, 1, 0)";
    agrees(&text, (7, 3), 0);
}

/// A rule of layer `a`, which has a range.
fn ranged(text: &str) -> Vec<Scheduled> {
    let mut scope = scope();
    scope.layers[0].spec.range = (0.0, 1.0);
    let d = RuleDefinition {
        name: "r".into(),
        values: vec![("a".into(), text.into())],
        mask: None,
        parameters: parameters(),
    };
    let rule = rule(&d, None, &scope).unwrap();
    let values = rule.parameters.iter().map(|(_, v)| *v).collect();
    vec![Scheduled { name: "r", process: Box::new(ExprProcess { rule, values }), every: 1 }]
}

/// 0/0 is no value within the range: the run ends and says where. Infinity is beyond every range, and is moved and counted.
#[test]
fn what_is_no_number_does_not_become_one() {
    const NONE: &str = "hole = if(column == 3 and row == 2, 0, 1); none = hole / hole - 1 + a;";
    for isa in Isa::ALL.into_iter().filter(|i| i.is_available()) {
        let run = |processes: Vec<Scheduled>| {
            let mut world = random_world((21, 5), eyot_core::Boundary::CLOSED, 1, &processes, &start).unwrap();
            let engine = CpuEngine { isa, ..CpuEngine::default() };
            let ended = engine.simulate(&mut world, &processes, Span { from: 0, steps: 1 }, &Control::none());
            (ended, world)
        };
        for text in ["none", "clamp(none, 0, 1)", "max(none, 0)", "min(p, none)", "max(0, min(none, 1), q)"] {
            match run(ranged(&format!("{NONE} {text}"))).0 {
                Err(Error::NotFinite { layer, x: 3, y: 2, .. }) => assert_eq!(layer, "a"),
                other => panic!("{text}, {}: {other:?}", isa.name()),
            }
        }
        let (ended, world) = run(ranged("1 / (column - 3)"));
        ended.unwrap();
        assert!(world.layer("a").unwrap().field.iter().all(|v| (0.0..=1.0).contains(&v)));
        // Three columns in the west, and infinity in the fourth.
        assert_eq!(world.ledger.amount("r.clamped"), 20.0, "{}", isa.name());
    }
}
