//! Thermal erosion as a rule of a recipe's own, for comparison with the same rule in Rust.

use eyot_core::layer::known::HEIGHT;
use eyot_core::{Error, LayerSpec, Result};
use eyot_expr::{ExprProcess, Known, LayerDefinition, Problem, RuleDefinition, Scope, layer, rule};
use eyot_land::simulate::Thermal;

/// The operations of `eyot_land::simulate::thermal`, in its order.
const SLUMP: &str = "
    e = height[1, 0] - height;   w = height[-1, 0] - height;
    s = height[0, 1] - height;   n = height[0, -1] - height;
    se = height[1, 1] - height;  nw = height[-1, -1] - height;
    sw = height[-1, 1] - height; ne = height[1, -1] - height;
    along = ((e - clamp(e, -stay, stay)) + (w - clamp(w, -stay, stay)))
        + ((s - clamp(s, -stay, stay)) + (n - clamp(n, -stay, stay)));
    across = ((se - clamp(se, -stay_d, stay_d)) + (nw - clamp(nw, -stay_d, stay_d)))
        + ((sw - clamp(sw, -stay_d, stay_d)) + (ne - clamp(ne, -stay_d, stay_d)));
    height + (rate * along + rate_d * across)";

/// On square cells, with the parameters that the process has if nobody gives others.
pub(crate) fn thermal(cell_m: f64) -> Result<ExprProcess> {
    let usual = Thermal::default();
    let angle = usual.talus.to_radians();
    let tangent = f64::from(eyot_core::math::sin(angle) / eyot_core::math::cos(angle));
    let parameters = [
        ("stay", (tangent * cell_m) as f32),
        ("stay_d", (tangent * (2.0 * cell_m * cell_m).sqrt()) as f32),
        ("rate", usual.rate / 12.0),
        ("rate_d", usual.rate / 24.0),
    ];
    // Without range and unit nothing is clamped and counted, as in the rule in Rust.
    let spec = LayerSpec { range: (f32::MIN, f32::MAX), ..HEIGHT };
    let height = LayerDefinition { spec: spec.clone(), measured: false, start: "0".to_owned(), parameters: Vec::new() };
    let declared = layer(&height, 0, &Scope::default()).map_err(wrong)?;
    let scope = Scope { layers: vec![Known { spec, measured: false, declared: Some(declared) }] };
    let definition = RuleDefinition {
        name: "slump".to_owned(),
        values: vec![("height".to_owned(), SLUMP.to_owned())],
        mask: None,
        parameters: parameters.iter().map(|(name, v)| ((*name).to_owned(), *v)).collect(),
    };
    let rule = rule(&definition, None, &scope).map_err(wrong)?;
    let values = rule.parameters.iter().map(|(_, v)| *v).collect();
    Ok(ExprProcess { rule, values })
}

fn wrong(problems: Vec<Problem>) -> Error {
    let reason = problems.into_iter().map(|(_, m)| m.message).collect::<Vec<_>>().join("; ");
    Error::BadParameter { owner: "bench".to_owned(), field: "rule".to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use crate::cpu::{BenchSubject, case};
    use eyot_core::Control;
    use eyot_core::engine::CpuEngine;
    use eyot_core::process::Span;

    #[test]
    fn the_text_gives_the_bytes_of_the_rule_in_rust() {
        let run = |what| {
            let (mut world, processes) = case(what, false, 70).unwrap();
            CpuEngine::default()
                .simulate(&mut world, &processes, Span { from: 0, steps: 20 }, &Control::none())
                .unwrap();
            world.layer("height").unwrap().field.to_vec()
        };
        assert_eq!(run(BenchSubject::Rule), run(BenchSubject::Thermal));
    }
}
