//! Prints a rule's graph as a WGSL compute shader.
//!
//! Layers are storage buffers of `width * height` floats, row 0 north; parameters and the grid are uniforms, so that
//! values may change between steps without compiling again.

use crate::graph::{Graph, Id, Op};
use crate::layer::{Beyond, LayerSpec};
use std::fmt::Write;

/// Side of a workgroup tile, cells.
pub const WORKGROUP: [u32; 2] = [32, 8];

/// WGSL of `graph`; `spec` tells how each layer behaves at the rim.
pub fn wgsl(graph: &Graph, spec: impl Fn(&str) -> LayerSpec) -> String {
    let mut s = String::new();
    let w = &mut s;
    // Writing to a String cannot fail.
    let _ = print(w, graph, &spec);
    s
}

fn print(w: &mut String, g: &Graph, spec: &dyn Fn(&str) -> LayerSpec) -> std::fmt::Result {
    writeln!(
        w,
        "// Rule `{}`: {} nodes, reads {}, writes {}.\n",
        g.name,
        g.nodes.len(),
        g.reads.join(", "),
        g.writes.join(", ")
    )?;
    writeln!(
        w,
        "struct Grid {{\n    width: i32,\n    height: i32,\n    rim_x: u32, // 0 closed, 1 open, 2 wrap\n    rim_y: u32,\n    key_low: u32,\n    key_high: u32,\n}}"
    )?;
    writeln!(w, "struct Params {{")?;
    if g.params.is_empty() {
        writeln!(w, "    unused: f32,")?;
    }
    for p in g.params {
        writeln!(w, "    {p}: f32,")?;
    }
    writeln!(
        w,
        "}}\n@group(0) @binding(0) var<uniform> grid: Grid;\n@group(0) @binding(1) var<uniform> params: Params;"
    )?;
    let mut binding = 2;
    for r in &g.reads {
        writeln!(w, "@group(0) @binding({binding}) var<storage, read> in_{r}: array<f32>;")?;
        binding += 1;
    }
    for o in &g.writes {
        writeln!(w, "@group(0) @binding({binding}) var<storage, read_write> out_{o}: array<f32>;")?;
        binding += 1;
    }
    writeln!(
        w,
        "\nfn resolve(i: i32, n: i32, rim: u32) -> i32 {{\n    if rim == 2u {{ return (i % n + n) % n; }}\n    return clamp(i, 0, n - 1);\n}}"
    )?;
    for r in &g.reads {
        let l = spec(r);
        let zero = |b: Beyond| if b == Beyond::Zero { "true" } else { "false" };
        writeln!(w, "fn at_{r}(x: i32, y: i32) -> f32 {{")?;
        for (axis, n) in [("x", "width"), ("y", "height")] {
            writeln!(w, "    if {axis} < 0 || {axis} >= grid.{n} {{")?;
            writeln!(
                w,
                "        if (grid.rim_{axis} == 0u && {}) || (grid.rim_{axis} == 1u && {}) {{ return 0.0; }}",
                zero(l.beyond_closed),
                zero(l.beyond_open)
            )?;
            writeln!(w, "    }}")?;
        }
        writeln!(
            w,
            "    let row = resolve(y, grid.height, grid.rim_y);\n    let column = resolve(x, grid.width, grid.rim_x);\n    return in_{r}[row * grid.width + column];\n}}"
        )?;
    }
    writeln!(
        w,
        "fn mix_round(a: u32) -> u32 {{\n    let b = (a ^ (a >> 16u)) * 0x21f0aaadu;\n    let c = (b ^ (b >> 15u)) * 0x735a2d97u;\n    return c ^ (c >> 15u);\n}}"
    )?;
    writeln!(
        w,
        "fn uniform_number(stream: u32, cell: u32) -> f32 {{\n    let h = mix_round(mix_round(cell ^ grid.key_low ^ (stream * 0x9e3779b9u)) + grid.key_high + stream * 0x85ebca6bu);\n    return f32(h >> 8u) * (1.0 / 16777216.0);\n}}"
    )?;
    writeln!(w, "\n@compute @workgroup_size({}, {})", WORKGROUP[0], WORKGROUP[1])?;
    writeln!(
        w,
        "fn main(@builtin(global_invocation_id) id: vec3<u32>) {{\n    let x = i32(id.x);\n    let y = i32(id.y);\n    if x >= grid.width || y >= grid.height {{ return; }}\n    let cell = u32(y * grid.width + x);"
    )?;
    for (i, &op) in g.nodes.iter().enumerate() {
        writeln!(w, "    let n{i} = {};", expression(g, op))?;
    }
    for (o, id) in g.writes.iter().zip(&g.outputs) {
        writeln!(w, "    out_{o}[cell] = n{id};")?;
    }
    writeln!(w, "}}")
}

fn expression(g: &Graph, op: Op) -> String {
    let n = |i: Id| format!("n{i}");
    let two = |a: Id, o: &str, b: Id| format!("n{a} {o} n{b}");
    match op {
        Op::Const(c) => float(f32::from_bits(c)),
        Op::BitsConst(c) => format!("{c:#x}u"),
        Op::Param(i) => format!("params.{}", g.params[i as usize]),
        Op::Read(s, dx, dy) => format!("at_{}({}, {})", g.reads[s as usize], offset("x", dx), offset("y", dy)),
        Op::X => "f32(x)".into(),
        Op::Y => "f32(y)".into(),
        Op::Uniform(stream) => format!("uniform_number({stream}u, cell)"),
        Op::Add(a, b) | Op::BitsAdd(a, b) => two(a, "+", b),
        Op::Sub(a, b) => two(a, "-", b),
        Op::Mul(a, b) | Op::BitsMul(a, b) => two(a, "*", b),
        Op::Div(a, b) => two(a, "/", b),
        Op::BitsXor(a, b) => two(a, "^", b),
        Op::BitsAnd(a, b) => two(a, "&", b),
        Op::BitsOr(a, b) => two(a, "|", b),
        Op::Neg(a) => format!("-n{a}"),
        Op::Sqrt(a) => format!("sqrt(n{a})"),
        Op::Abs(a) => format!("abs(n{a})"),
        Op::Floor(a) => format!("floor(n{a})"),
        Op::SelectLt(a, b, p, q) => format!("select({}, {}, n{a} < n{b})", n(q), n(p)),
        Op::FromBits(a) => format!("bitcast<f32>(n{a})"),
        Op::ToBits(a) => format!("bitcast<u32>(n{a})"),
        Op::ToReal(a) => format!("f32(bitcast<i32>(n{a}))"),
        Op::Whole(a) => format!("bitcast<u32>(i32(n{a}))"),
        Op::Shl(a, k) => format!("n{a} << {k}u"),
        Op::Shr(a, k) => format!("n{a} >> {k}u"),
    }
}

fn offset(axis: &str, d: i32) -> String {
    match d {
        0 => axis.to_owned(),
        d if d > 0 => format!("{axis} + {d}"),
        d => format!("{axis} - {}", -d),
    }
}

/// A literal that WGSL reads back as the same f32.
fn float(v: f32) -> String {
    if v.is_finite() { format!("f32({v:?})") } else { format!("bitcast<f32>({:#x}u)", v.to_bits()) }
}
