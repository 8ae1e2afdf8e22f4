//! Expressions of layers and rules.

use eyot_core::conformance::random_world;
use eyot_core::engine::CpuEngine;
use eyot_core::process::{Scheduled, Span};
use eyot_core::{Boundary, Control, LayerSpec};
use eyot_expr::{ExprProcess, Known, LayerDefinition, Part, RuleDefinition, Scope, layer, rule};

pub(crate) const WORDS: &[&str] = &[
    "a",
    "b",
    "p",
    "x",
    "y",
    "u",
    "v",
    "steps",
    "sea_level",
    "pi",
    "if(",
    "min(",
    "max(",
    "clamp(",
    "mean4(",
    "mean8(",
    "sum8(",
    "laplacian(",
    "slope(",
    "random()",
    "exp(",
    "ln(",
    "pow(",
    "sqrt(",
    "and",
    "or",
    "not",
    "true",
    "<",
    "<=",
    "==",
    "!=",
    "+",
    "-",
    "*",
    "/",
    "^",
    "(",
    ")",
    "[1, 0]",
    "[-2, 2]",
    "[",
    "]",
    ",",
    ";",
    "=",
    "#",
    "\n",
    "0",
    "1",
    "0.5",
    "1e38",
    "1e-38",
    "é",
];

/// A text as the next value of a layer: refused with a place, or run for a step.
pub(crate) fn read(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut scope = Scope::default();
    for (order, name) in ["a", "b"].into_iter().enumerate() {
        let spec = LayerSpec::new(name, if order == 0 { "1" } else { "m" }, "", (-1e6, 1e6));
        let d = LayerDefinition { spec: spec.clone(), measured: true, start: "0".into(), parameters: Vec::new() };
        let declared = layer(&d, order, &scope).expect("a sound layer");
        scope.layers.push(Known { spec, measured: true, declared: Some(declared) });
    }
    let parameters = vec![("p".to_owned(), 0.5)];
    let d = RuleDefinition { name: "r".into(), values: vec![("a".into(), text.clone())], mask: None, parameters };
    match rule(&d, None, &scope) {
        Ok(rule) => {
            let process = Box::new(ExprProcess { rule, values: vec![0.5] });
            let processes = [Scheduled { name: "r", process, every: 1 }];
            let mut world = random_world((5, 3), Boundary::WRAP, 1, &processes, &|_, u| u).expect("a world");
            // A value that is not finite is an error of its own.
            let _ = CpuEngine::default().simulate(&mut world, &processes, Span { from: 0, steps: 1 }, &Control::none());
            true
        }
        Err(problems) => {
            assert!(!problems.is_empty(), "refused without a reason");
            for (part, mistake) in problems {
                let place = text.get(mistake.span.clone());
                assert!(part == Part::Whole || place.is_some(), "a place outside the text: {mistake:?}");
                assert!(!mistake.message.is_empty());
            }
            false
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let texts = [
        "clamp(0.98 * a + 0.02 * step(0.01, b), 0, 1)",
        "near = sum8(a); if(near == 3 or (near == 2 and a > 0.5), 1, 0)",
        "a[1, -1] + mean4(a) * p - mean8(a) * a / (1 + a^2)",
        "if(random() < exp(-abs(u - v)) and not b > sea_level, min(a, 1, steps), max(a, -1)) # a comment",
        "c = a > 0; d = c and not c; if(d, 1, 0.5)",
    ];
    texts.iter().map(|t| t.as_bytes().to_vec()).collect()
}
