//! Rules that came as texts on the GPU against the reference: every rim, alone and in groups with rules in Rust.

use eyot_core::conformance::{random_world, rims};
use eyot_core::control::Control;
use eyot_core::process::{Scheduled, Span};
use eyot_core::reference::Reference;
use eyot_core::{Boundary, LayerSpec, World};
use eyot_expr::{ExprProcess, Known, LayerDefinition, RuleDefinition, Scope, layer, rule};
use eyot_gpu::{GpuEngine, Options};
use eyot_land::simulate::Thermal;

use crate::common;

/// Words of WGSL and of its printer among them: a layer may have any name.
const NAMES: [&str; 4] = ["loop", "state", "job_0", "x_p1"];

fn scope() -> Scope {
    let mut scope = Scope::default();
    for (order, name) in NAMES.into_iter().enumerate() {
        let spec = LayerSpec::new(name, "1", "", (f32::MIN, f32::MAX));
        let d = LayerDefinition { spec: spec.clone(), measured: false, start: "random()".into(), parameters: vec![] };
        let declared = layer(&d, order, &scope).unwrap();
        scope.layers.push(Known { spec, measured: false, declared: Some(declared) });
    }
    let height = eyot_core::layer::known::HEIGHT;
    scope.layers.push(Known { spec: height, measured: true, declared: None });
    scope
}

fn scheduled(name: &'static str, values: &[(&str, &str)], mask: Option<&str>) -> Scheduled {
    let values = values.iter().map(|(l, t)| ((*l).to_owned(), (*t).to_owned())).collect();
    let parameters = vec![("width".to_owned(), 0.25), ("to_loop".to_owned(), 0.5), ("from_state".to_owned(), 1.5)];
    let d = RuleDefinition { name: name.into(), values, mask: mask.map(Into::into), parameters };
    let rule = rule(&d, None, &scope()).unwrap_or_else(|e| panic!("{e:?}"));
    let values = rule.parameters.iter().map(|(_, v)| *v).collect();
    Scheduled { name, process: Box::new(ExprProcess { rule, values }), every: 1 }
}

/// Texts with every function, choices that rounding cannot turn, and rules in Rust between them.
fn all() -> Vec<(&'static str, Vec<Scheduled>)> {
    let thermal = || Scheduled { name: "thermal", process: Box::new(Thermal::default()), every: 1 };
    let everything = "0.5 * loop + 0.1 * (mean8(state) - loop[1, -2]) + 0.01 * exp(-abs(laplacian(loop)))
        + 0.01 * sin(0.1 * x) * cos(v) + width * 0.1 * pow(abs(state) + 0.1, from_state) + 0.01 * floor(u * 3)
        + 0.001 * min8(x_p1) * max4(state) + 0.01 * sqrt(abs(loop)) + 0.001 * steps + 0.01 * ln(1 + abs(state))
        + 0.01 * random() + 0.001 * mod(column, 3) + 0.01 * slope(state) + 0.001 * state^3";
    vec![
        ("everything", vec![scheduled("everything", &[("loop", everything)], None)]),
        (
            "several",
            vec![
                scheduled(
                    "a",
                    &[("loop", "mean4(state)"), ("state", "0.5 * loop + to_loop * random()")],
                    Some("row > 1"),
                ),
                thermal(),
                scheduled("b", &[("height", "height + 0.1 * (random() - 0.5)")], None),
                scheduled("c", &[("job_0", "if(random() < 0.3 and not random() > 0.5, 1, x_p1[0, 1])")], None),
            ],
        ),
        ("life", vec![scheduled("life", &[("x_p1", LIFE)], None)]),
    ]
}

const LIFE: &str = "n = sum8(if(x_p1 > 0.5, 1, 0)); if(n == 3 or (n == 2 and x_p1 > 0.5), 1, 0)";

fn start(name: &str, u: f32) -> f32 {
    if name == "height" { 100.0 * u } else { u }
}

fn check(options: Options, shapes: &[(usize, usize)], steps: u64) {
    let Some(gpu) = common::gpu() else { return };
    let mut engine = GpuEngine::new(gpu, options, None).unwrap();
    for (name, processes) in all() {
        for &shape in shapes {
            for (i, rim) in rims().into_iter().enumerate() {
                let mut world = random_world(shape, rim, 7 + i as u64, &processes, &start).unwrap();
                let mut reference = Reference::<f32>::new(&world);
                reference.simulate(&processes, steps);
                let span = Span { from: 0, steps };
                engine.simulate(&mut world, &processes, span, &Control::none()).unwrap();
                engine.download(&mut world).unwrap();
                engine.release();
                compare(name, &world, &reference, rim);
            }
        }
    }
}

fn compare(name: &str, world: &World, reference: &Reference<f32>, rim: Boundary) {
    for l in world.layers() {
        let scale = l.field.iter().fold(1.0_f32, |m, v| m.max(v.abs()));
        for y in 0..world.grid.height {
            for x in 0..world.grid.width {
                let (got, want) = (l.field.get(x, y), reference.get(&l.spec.name, x, y));
                let most = if name == "life" { 0.0 } else { 32.0 * f32::EPSILON * scale };
                assert!(
                    (got - want).abs() <= most,
                    "{name}: {} at ({x}, {y}): {got}, not {want}; {rim:?}",
                    l.spec.name
                );
            }
        }
    }
    for (account, want) in &reference.ledger {
        let got = world.ledger.amount(account);
        assert!((got - want).abs() <= 1e-5 * want.abs() + 1e-2, "{account}: {got}, not {want}");
    }
}

#[test]
fn texts_equal_the_reference() {
    check(Options::default(), &[(1, 1), (3, 5), (33, 17), (70, 40)], 1);
}

#[test]
fn texts_in_groups_equal_the_reference() {
    check(Options::default().most_passes(8), &[(27, 51)], 4);
}

/// As on the processor, 0/0 is not moved into the range of its layer.
#[test]
fn what_is_no_number_does_not_become_one() {
    let Some(gpu) = common::gpu() else { return };
    let mut engine = GpuEngine::new(gpu, Options::default(), None).unwrap();
    let mut scope = scope();
    scope.layers[0].spec.range = (0.0, 1.0);
    for value in ["none", "clamp(none, 0, 1)", "max(none, 0)"] {
        let text = format!("hole = if(column == 3 and row == 2, 0, 1); none = hole / hole - 1 + loop; {value}");
        let values = vec![("loop".to_owned(), text)];
        let d = RuleDefinition { name: "r".into(), values, mask: None, parameters: Vec::new() };
        let process = Box::new(ExprProcess { rule: rule(&d, None, &scope).unwrap(), values: Vec::new() });
        let processes = vec![Scheduled { name: "r", process, every: 1 }];
        let mut world = random_world((21, 5), Boundary::CLOSED, 1, &processes, &start).unwrap();
        let span = Span { from: 0, steps: 1 };
        let ended = engine.simulate(&mut world, &processes, span, &Control::none());
        let ended =
            ended.map_err(|e| e.to_string()).and_then(|()| engine.download(&mut world).map_err(|e| e.to_string()));
        engine.release();
        let said = ended.expect_err(value);
        assert!(said.contains("loop") && said.contains("column 3, row 2"), "{value}: {said}");
    }
}
