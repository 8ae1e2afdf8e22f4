//! Prints a group of rules as a WGSL compute shader.
//!
//! All layers lie in one storage buffer, so that a shader needs two of them however many layers it touches, whatever the
//! limits of the device are: `state`, and `sums` for the ledger. Which copy of a layer is meant, the parameters and the keys of
//! the random numbers come in a small uniform block, the job, so that steps differ by that block alone.

use crate::group::{Group, JOB_HEAD, Source, Stage, THREADS, TILE};
use eyot_core::graph::{Graph, Id, Op};
use eyot_core::rule::Side;
use eyot_core::{Boundary, BoundaryCondition, Centering, GhostFill, LayerSpec};
use std::collections::{BTreeMap, HashSet};

/// Numbers before the first row of `state`, so that column -1 of every row has a place.
pub(crate) const BASE: usize = 64;

/// What a shader depends on beside its group.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) specs: &'a [LayerSpec],
    pub(crate) rim: Boundary,
    /// The grid is cut into slabs; rows beyond a slab are copies and are not wrapped.
    pub(crate) split: bool,
}

/// WGSL of a group; `graphs` are those of its stages.
pub(crate) fn wgsl(group: &Group, graphs: &[&Graph], setting: Setting<'_>) -> String {
    let mut out = Out { text: String::new(), indent: 0 };
    print(&mut out, group, graphs, setting);
    out.text
}

/// Text with indentation.
struct Out {
    text: String,
    indent: usize,
}

impl Out {
    fn line(&mut self, line: &str) {
        if line.starts_with('}') {
            self.indent -= 1;
        }
        if !line.is_empty() {
            self.text.extend(std::iter::repeat_n("    ", self.indent));
        }
        self.text.push_str(line);
        self.text.push('\n');
        if line.ends_with('{') {
            self.indent += 1;
        }
    }
}

/// Names of the fields of a job, each with its type; the order in which [`crate::engine`] fills them.
fn job_fields(group: &Group, graphs: &[&Graph], specs: &[LayerSpec]) -> Vec<(String, &'static str)> {
    let head = ["width", "height", "left", "top", "first_row", "end_row", "stride", "slots", "first_group", "groups"];
    debug_assert_eq!(head.len(), JOB_HEAD);
    let mut fields: Vec<(String, &str)> = head.iter().map(|n| ((*n).to_owned(), "i32")).collect();
    fields.extend(group.inputs.iter().map(|&l| (format!("from_{}", specs[l].name), "i32")));
    fields.extend(group.outputs.iter().map(|&(l, _)| (format!("to_{}", specs[l].name), "i32")));
    for (i, g) in graphs.iter().enumerate() {
        if is_random(g) {
            fields.extend([(format!("key_low_{i}"), "u32"), (format!("key_high_{i}"), "u32")]);
        }
        fields.extend(g.params.iter().map(|p| (format!("{p}_{i}"), "f32")));
        fields.extend((0..g.sums.len()).map(|k| (format!("account_{i}_{k}"), "i32")));
    }
    fields
}

/// The number that a node rounds; see [`eyot_core::real::Real::no_contract`].
fn rounded(graph: &Graph, op: Op) -> Option<Id> {
    let Op::FromBits(bits) = op else { return None };
    let Op::ToBits(number) = graph.nodes[bits as usize] else { return None };
    Some(number)
}

/// True if the rule asks for random numbers.
pub(crate) fn is_random(graph: &Graph) -> bool {
    graph.nodes.iter().any(|op| matches!(op, Op::Uniform(_)))
}

fn print(o: &mut Out, group: &Group, graphs: &[&Graph], setting: Setting<'_>) {
    let names: Vec<&str> = graphs.iter().map(|g| g.name).collect();
    o.line(&format!("// {}: tiles of {} x {} cells.", names.join(", "), TILE[0], TILE[1]));
    o.line("");
    o.line("struct Job {");
    for (name, kind) in job_fields(group, graphs, setting.specs) {
        o.line(&format!("{name}: {kind},"));
    }
    o.line("}");
    o.line("@group(0) @binding(0) var<uniform> job: Job;");
    o.line("@group(0) @binding(1) var<storage, read_write> state: array<f32>;");
    o.line("@group(0) @binding(2) var<storage, read_write> sums: array<vec2<f32>>;");
    for (i, stage) in group.stages.iter().enumerate() {
        let side = side(stage.halo);
        for w in stage.writes.iter().filter(|w| w.tile) {
            o.line(&format!(
                "var<workgroup> tile_{i}_{}: array<f32, {}>;",
                setting.specs[w.layer].name,
                side[0] * side[1]
            ));
        }
    }
    helpers(o, graphs);
    let has_sums = graphs.iter().any(|g| !g.sums.is_empty());
    o.line("");
    o.line(&format!("@compute @workgroup_size({THREADS})"));
    o.line("fn main(");
    o.indent += 1;
    o.line("@builtin(workgroup_id) group: vec3<u32>,");
    o.line("@builtin(num_workgroups) groups: vec3<u32>,");
    o.line("@builtin(local_invocation_index) thread: u32,");
    o.indent -= 1;
    o.line(") {");
    o.line(&format!("let left = i32(group.x) * {} + job.left;", TILE[0]));
    o.line(&format!("let top = i32(group.y) * {} + job.top;", TILE[1]));
    for (i, g) in graphs.iter().enumerate() {
        (0..g.sums.len()).for_each(|k| o.line(&format!("var sum_{i}_{k} = 0.0;")));
    }
    for i in 0..group.stages.len() {
        if i > 0 {
            o.line("workgroupBarrier();");
        }
        StagePrinter { group, number: i, stage: &group.stages[i], graph: graphs[i], setting }.print(o);
    }
    if has_sums {
        post_sums(o, graphs);
    }
    o.line("}");
}

fn helpers(o: &mut Out, graphs: &[&Graph]) {
    o.line("");
    o.line("fn address(slot: i32, x: i32, y: i32) -> i32 {");
    o.line(&format!("return {BASE} + ((y - job.first_row) * job.slots + slot) * job.stride + x;"));
    o.line("}");
    o.line("fn wrapped(i: i32, n: i32) -> i32 {");
    o.line("return (i % n + n) % n;");
    o.line("}");
    if graphs.iter().any(|g| g.nodes.iter().any(|op| rounded(g, *op).is_some())) {
        o.line("// No compiler knows that no bit changes here, so that none fuses a product with a sum.");
        o.line("fn rounded(v: f32) -> f32 {");
        o.line("return bitcast<f32>(bitcast<u32>(v) ^ (u32(job.slots) >> 31u));");
        o.line("}");
    }
    if graphs.iter().any(|g| is_random(g)) {
        o.line("fn mix_round(a: u32) -> u32 {");
        o.line("let b = (a ^ (a >> 16u)) * 0x21f0aaadu;");
        o.line("let c = (b ^ (b >> 15u)) * 0x735a2d97u;");
        o.line("return c ^ (c >> 15u);");
        o.line("}");
        o.line("fn uniform_number(stream: u32, cell: u32, low: u32, high: u32) -> f32 {");
        o.line("let h = mix_round(mix_round(cell ^ low ^ (stream * 0x9e3779b9u)) + high + stream * 0x85ebca6bu);");
        o.line("return f32(h >> 8u) * (1.0 / 16777216.0);");
        o.line("}");
    }
    if graphs.iter().any(|g| !g.sums.is_empty()) {
        o.line(&format!("var<workgroup> parts: array<vec4<f32>, {THREADS}>;"));
        o.line("// A sum and what rounding took from it (Knuth's two-sum), so that thousands of steps lose nothing.");
        o.line("fn post(account: i32, value: f32, group: i32) {");
        o.line("let place = account * job.groups + group;");
        o.line("let old = sums[place];");
        o.line("let total = old.x + value;");
        o.line("let part = total - old.x;");
        o.line("sums[place] = vec2<f32>(total, old.y + ((old.x - (total - part)) + (value - part)));");
        o.line("}");
    }
}

/// Adds the sums of all invocations in a fixed order: sixteen by sixteen, four accounts at a time.
fn post_sums(o: &mut Out, graphs: &[&Graph]) {
    let all: Vec<(usize, usize)> =
        graphs.iter().enumerate().flat_map(|(i, g)| (0..g.sums.len()).map(move |k| (i, k))).collect();
    o.line("");
    o.line("// Sums of the tile.");
    o.line("let number = job.first_group + i32(group.y * groups.x + group.x);");
    for four in all.chunks(4) {
        let value = |n: usize| four.get(n).map_or("0.0".to_owned(), |(i, k)| format!("sum_{i}_{k}"));
        o.line("workgroupBarrier();");
        o.line(&format!("parts[thread] = vec4<f32>({}, {}, {}, {});", value(0), value(1), value(2), value(3)));
        o.line("workgroupBarrier();");
        o.line("if thread % 16u == 0u {");
        o.line("var part = parts[thread];");
        o.line("for (var i = 1u; i < 16u; i++) {");
        o.line("part += parts[thread + i];");
        o.line("}");
        o.line("parts[thread] = part;");
        o.line("}");
        o.line("workgroupBarrier();");
        o.line("if thread == 0u {");
        o.line("var total = parts[0];");
        o.line(&format!("for (var i = 16u; i < {THREADS}u; i += 16u) {{"));
        o.line("total += parts[i];");
        o.line("}");
        for ((i, k), lane) in four.iter().zip(["x", "y", "z", "w"]) {
            o.line(&format!("post(job.account_{i}_{k}, total.{lane}, number);"));
        }
        o.line("}");
    }
}

/// Columns and rows of a tile with its halo.
fn side(halo: usize) -> [usize; 2] {
    [TILE[0] + 2 * halo, TILE[1] + 2 * halo]
}

/// An axis of the grid.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Axis {
    X,
    Y,
}

struct StagePrinter<'a> {
    group: &'a Group,
    number: usize,
    stage: &'a Stage,
    graph: &'a Graph,
    setting: Setting<'a>,
}

impl StagePrinter<'_> {
    fn print(&self, o: &mut Out) {
        let (halo, side) = (self.stage.halo, side(self.stage.halo));
        o.line("");
        let around = if halo > 0 { format!(", and on {halo} cells around the tile") } else { String::new() };
        o.line(&format!("// Rule `{}`{around}.", self.graph.name));
        o.line(&format!("for (var c = thread; c < {}u; c += {THREADS}u) {{", side[0] * side[1]));
        let back = if halo > 0 { format!(" - {halo}") } else { String::new() };
        o.line(&format!("let cx = left + i32(c % {}u){back};", side[0]));
        o.line(&format!("let cy = top + i32(c / {}u){back};", side[0]));
        let mut outside = Vec::new();
        for (axis, at, n) in [(Axis::X, "cx", "job.width"), (Axis::Y, "cy", "job.height")] {
            if self.edge(axis) != BoundaryCondition::Wrap {
                outside.push(format!("{at} < {}", self.first(axis)));
            }
            // Without a halo nobody reads what lies beyond the grid or the slab.
            let n = if halo == 0 && axis == Axis::Y { "job.end_row" } else { n };
            if halo == 0 || self.edge(axis) != BoundaryCondition::Wrap {
                outside.push(format!("{at} >= {n}"));
            }
        }
        if !outside.is_empty() {
            o.line(&format!("if {} {{", outside.join(" || ")));
            o.line("continue;");
            o.line("}");
        }
        self.coordinates(o);
        let mut known = HashSet::new();
        let mut names = Names::new(self.graph);
        self.nodes(o, &self.graph.needed(&self.graph.outputs), &mut known, &mut names);
        self.kept_reads(o, &mut known, &mut names);
        self.writes(o, &names);
        self.sums(o, &known, &mut names);
        o.line("}");
    }

    /// Reads what sums alone need of layers that are about to be overwritten in place.
    fn kept_reads(&self, o: &mut Out, known: &mut HashSet<Id>, names: &mut Names) {
        let g = self.graph;
        let roots: Vec<Id> = g.sums.iter().chain(g.boundary_outflow.iter().flatten()).copied().collect();
        let needed = g.needed(&roots);
        for (i, &op) in g.nodes.iter().enumerate() {
            let (Op::Read(slot, ..), id) = (op, i as Id) else { continue };
            let layer = self.stage.reads[slot as usize].0;
            if needed[i] && self.stage.writes.iter().any(|w| w.layer == layer) && known.insert(id) {
                let value = self.expression(op, names);
                let (name, comment) = names.define(g, id);
                o.line(&format!("let {name} = {value};{comment}"));
            }
        }
    }

    fn edge(&self, axis: Axis) -> BoundaryCondition {
        if axis == Axis::X { self.setting.rim.x } else { self.setting.rim.y }
    }

    /// First column or row that this stage computes.
    fn first(&self, axis: Axis) -> i32 {
        let face = if axis == Axis::X { Centering::FaceX } else { Centering::FaceY };
        let writes = self.stage.writes.iter().any(|w| self.setting.specs[w.layer].centering == face);
        if writes && self.edge(axis) == BoundaryCondition::Open { -1 } else { 0 }
    }

    /// First column or row of a layer that exists.
    fn first_of(&self, spec: &LayerSpec, axis: Axis) -> i32 {
        let face = if axis == Axis::X { Centering::FaceX } else { Centering::FaceY };
        if spec.centering == face && self.edge(axis) == BoundaryCondition::Open { -1 } else { 0 }
    }

    /// The cell's own column and row, and those of all that it reads.
    fn coordinates(&self, o: &mut Out) {
        for (axis, name, n) in [(Axis::X, "x", "job.width"), (Axis::Y, "y", "job.height")] {
            let at = format!("c{name}");
            match self.edge(axis) {
                BoundaryCondition::Wrap => o.line(&format!("let {name} = wrapped({at}, {n});")),
                _ => o.line(&format!("let {name} = {at};")),
            }
        }
        let mut lines: BTreeMap<String, String> = BTreeMap::new();
        for &op in &self.graph.nodes {
            let Op::Read(slot, dx, dy) = op else { continue };
            for (axis, d) in [(Axis::X, dx), (Axis::Y, dy)] {
                let (name, value, inside) = self.neighbour(slot as usize, axis, d);
                lines.insert(format!("let {name} = "), format!("{value};"));
                if let Some((name, condition)) = inside {
                    lines.insert(format!("let {name} = "), format!("{condition};"));
                }
            }
        }
        for (name, value) in lines {
            o.line(&format!("{name}{value}"));
        }
    }

    /// Name and value of a neighbour's column or row for a read of `slot`, and name and value of the condition under which it
    /// is there if the layer is empty beyond the rim.
    fn neighbour(&self, slot: usize, axis: Axis, d: i32) -> (String, String, Option<(String, String)>) {
        let (layer, source) = self.stage.reads[slot];
        let spec = &self.setting.specs[layer];
        let (at, n, letter) = match axis {
            Axis::X => ("cx", "job.width", "x"),
            Axis::Y => ("cy", "job.height", "y"),
        };
        let moved = match d {
            0 => at.to_owned(),
            d if d > 0 => format!("{at} + {d}"),
            d => format!("{at} - {}", -d),
        };
        let step = match d {
            0 => "0".to_owned(),
            d if d > 0 => format!("p{d}"),
            d => format!("m{}", -d),
        };
        let edge = self.edge(axis);
        if edge == BoundaryCondition::Wrap {
            let in_place = matches!(source, Source::Tile { .. }) || (axis == Axis::Y && self.setting.split);
            return if in_place {
                (format!("{letter}_{step}_plain"), moved, None)
            } else {
                (format!("{letter}_{step}"), format!("wrapped({moved}, {n})"), None)
            };
        }
        let first = self.first_of(spec, axis);
        let (low, high) = (self.first(axis) + d < first, d > 0);
        let value = match (low, high) {
            (true, _) => format!("max({moved}, {first})"),
            (_, true) => format!("min({moved}, {n} - 1)"),
            _ => moved.clone(),
        };
        let face = if first < 0 { "_face" } else { "" };
        let beyond = if edge == BoundaryCondition::Open { spec.beyond_open } else { spec.beyond_closed };
        let inside = (beyond == GhostFill::Zero && (low || high)).then(|| {
            let condition = if low { format!("{moved} >= {first}") } else { format!("{moved} < {n}") };
            (format!("{letter}_{step}{face}_inside"), condition)
        });
        (format!("{letter}_{step}{face}"), value, inside)
    }

    /// The value that a read gives.
    fn read(&self, slot: usize, dx: i32, dy: i32) -> String {
        let (layer, source) = self.stage.reads[slot];
        let name = &self.setting.specs[layer].name;
        let (x, _, x_inside) = self.neighbour(slot, Axis::X, dx);
        let (y, _, y_inside) = self.neighbour(slot, Axis::Y, dy);
        let value = match source {
            Source::Card => format!("state[address(job.from_{name}, {x}, {y})]"),
            Source::Tile { stage, .. } => {
                let halo = self.group.stages[stage].halo;
                let width = side(halo)[0];
                format!("tile_{stage}_{name}[({y} - top + {halo}) * {width} + ({x} - left + {halo})]")
            }
        };
        let inside: Vec<String> = [x_inside, y_inside].into_iter().flatten().map(|(name, _)| name).collect();
        if inside.is_empty() { value } else { format!("select(0.0, {value}, {})", inside.join(" && ")) }
    }

    /// Prints the nodes that are needed and not yet known.
    fn nodes(&self, o: &mut Out, needed: &[bool], known: &mut HashSet<Id>, names: &mut Names) {
        for (i, &op) in self.graph.nodes.iter().enumerate() {
            let id = i as Id;
            if !needed[i] || known.contains(&id) || Names::is_inline(op) {
                continue;
            }
            known.insert(id);
            let value = self.expression(op, names);
            if names.is_part(self.graph, id, &value) {
                names.put(op, id, value);
                continue;
            }
            let (name, comment) = names.define(self.graph, id);
            o.line(&format!("let {name} = {value};{comment}"));
        }
    }

    /// Condition under which the cell is one that this tile answers for.
    fn own(&self, faces: bool) -> Vec<String> {
        let mut conditions = Vec::new();
        if self.stage.halo > 0 {
            conditions.extend(["cx >= left".into(), format!("cx < left + {}", TILE[0])]);
            conditions.extend(["cy >= top".into(), format!("cy < top + {}", TILE[1])]);
            conditions.extend(["cx < job.width".into(), "cy < job.end_row".into()]);
        }
        if !faces {
            for axis in [Axis::X, Axis::Y] {
                if self.first(axis) < 0 {
                    conditions.push(format!("{} >= 0", if axis == Axis::X { "cx" } else { "cy" }));
                }
            }
        }
        conditions
    }

    fn writes(&self, o: &mut Out, names: &Names) {
        for (w, &id) in self.stage.writes.iter().zip(&self.graph.outputs) {
            let spec = &self.setting.specs[w.layer];
            let mut value = names.value(self.graph, self.number, id);
            // A face on a closed rim is shut.
            if spec.centering == Centering::FaceX && self.setting.rim.x == BoundaryCondition::Closed {
                value = format!("select({value}, 0.0, x == job.width - 1)");
            }
            if spec.centering == Centering::FaceY && self.setting.rim.y == BoundaryCondition::Closed {
                value = format!("select({value}, 0.0, y == job.height - 1)");
            }
            if w.tile {
                o.line(&format!("tile_{}_{}[c] = {value};", self.number, spec.name));
            }
            if w.stored {
                let mut conditions = self.own(true);
                for (axis, at) in [(Axis::X, "cx"), (Axis::Y, "cy")] {
                    if self.first(axis) < self.first_of(spec, axis) {
                        conditions.push(format!("{at} >= 0"));
                    }
                }
                let store = format!("state[address(job.to_{}, cx, cy)] = {value};", spec.name);
                if conditions.is_empty() {
                    o.line(&store);
                } else {
                    o.line(&format!("if {} {{", conditions.join(" && ")));
                    o.line(&store);
                    o.line("}");
                }
            }
        }
    }

    fn sums(&self, o: &mut Out, known: &HashSet<Id>, names: &mut Names) {
        if self.graph.sums.is_empty() {
            return;
        }
        let conditions = self.own(false);
        o.line(&if conditions.is_empty() { "{".to_owned() } else { format!("if {} {{", conditions.join(" && ")) });
        let mut inner = known.clone();
        self.nodes(o, &self.graph.needed(&self.graph.sums), &mut inner, names);
        for (k, &id) in self.graph.sums.iter().enumerate() {
            self.add(o, names, k, id);
        }
        let rim = self.setting.rim;
        for (side, boundary_outflow) in Side::ALL.into_iter().zip(&self.graph.boundary_outflow) {
            let (edge, condition) = match side {
                Side::West => (rim.x, "cx == 0"),
                Side::East => (rim.x, "cx == job.width - 1"),
                Side::North => (rim.y, "cy == 0"),
                Side::South => (rim.y, "cy == job.height - 1"),
            };
            if edge != BoundaryCondition::Open || boundary_outflow.is_empty() {
                continue;
            }
            o.line(&format!("if {condition} {{"));
            // Names inside the braces end with them.
            let mut names = names.clone();
            self.nodes(o, &self.graph.needed(boundary_outflow), &mut inner.clone(), &mut names);
            for (k, &id) in boundary_outflow.iter().enumerate() {
                self.add(o, &names, k, id);
            }
            o.line("}");
        }
        o.line("}");
    }

    fn add(&self, o: &mut Out, names: &Names, sum: usize, id: Id) {
        if self.graph.nodes[id as usize] != Op::Const(0) {
            let value = names.value(self.graph, self.number, id);
            o.line(&format!("sum_{}_{sum} += {value};", self.number));
        }
    }

    fn expression(&self, op: Op, names: &Names) -> String {
        let n = |id: Id| names.value(self.graph, self.number, id);
        if let Some(number) = rounded(self.graph, op) {
            return format!("rounded({})", n(number));
        }
        let two = |a: Id, sign: &str, b: Id| format!("{} {sign} {}", n(a), n(b));
        match op {
            Op::Const(_) | Op::BitsConst(_) | Op::Param(_) | Op::X | Op::Y => unreachable!("printed where it is used"),
            Op::Read(slot, dx, dy) => self.read(slot as usize, dx, dy),
            Op::Uniform(stream) => {
                let i = self.number;
                format!("uniform_number({stream}u, u32(y * job.width + x), job.key_low_{i}, job.key_high_{i})")
            }
            Op::Add(a, b) | Op::BitsAdd(a, b) => two(a, "+", b),
            Op::Sub(a, b) => two(a, "-", b),
            Op::Mul(a, b) | Op::BitsMul(a, b) => two(a, "*", b),
            Op::Div(a, b) => two(a, "/", b),
            Op::BitsXor(a, b) => two(a, "^", b),
            Op::BitsAnd(a, b) => two(a, "&", b),
            Op::BitsOr(a, b) => two(a, "|", b),
            Op::Neg(a) => format!("-({})", n(a)),
            Op::Sqrt(a) => format!("sqrt({})", n(a)),
            Op::Abs(a) => format!("abs({})", n(a)),
            Op::Floor(a) => format!("floor({})", n(a)),
            Op::SelectLt(a, b, p, q) => format!("select({}, {}, {} < {})", n(q), n(p), n(a), n(b)),
            Op::FromBits(a) => format!("bitcast<f32>({})", n(a)),
            Op::ToBits(a) => format!("bitcast<u32>({})", n(a)),
            Op::ToReal(a) => format!("f32(bitcast<i32>({}))", n(a)),
            Op::Whole(a) => format!("bitcast<u32>(i32({}))", n(a)),
            Op::Shl(a, k) => format!("{} << {k}u", n(a)),
            Op::Shr(a, k) => format!("{} >> {k}u", n(a)),
        }
    }
}

/// What values are called in one stage.
#[derive(Clone)]
struct Names {
    of: Vec<Option<String>>,
    taken: HashSet<String>,
    uses: Vec<usize>,
}

/// Longest formula that stands within another one, characters.
const LONGEST_PART: usize = 56;

impl Names {
    fn new(graph: &Graph) -> Self {
        Self { of: vec![None; graph.nodes.len()], taken: HashSet::new(), uses: graph.uses() }
    }

    /// True for a short formula that nobody has named and that is needed in one place only: it reads better there.
    fn is_part(&self, graph: &Graph, id: Id, formula: &str) -> bool {
        let plain = !matches!(graph.nodes[id as usize], Op::Read(..) | Op::Uniform(_));
        let nameless = graph.names.iter().all(|(n, _)| *n != id);
        plain && nameless && self.uses[id as usize] == 1 && formula.len() <= LONGEST_PART
    }

    /// Makes a formula what its node is called.
    fn put(&mut self, op: Op, id: Id, formula: String) {
        use Op::{Abs, Floor, FromBits, SelectLt, Sqrt, ToBits, ToReal, Whole};
        let closed =
            matches!(op, Sqrt(_) | Abs(_) | Floor(_) | SelectLt(..) | FromBits(_) | ToBits(_) | ToReal(_) | Whole(_));
        self.of[id as usize] = Some(if closed { formula } else { format!("({formula})") });
    }

    /// True for what is written where it is used.
    fn is_inline(op: Op) -> bool {
        matches!(op, Op::Const(_) | Op::BitsConst(_) | Op::Param(_) | Op::X | Op::Y)
    }

    /// Name of a node and a comment with its equation.
    fn define(&mut self, graph: &Graph, id: Id) -> (String, String) {
        let given = graph.names.iter().find(|(n, _)| *n == id).map(|(_, name)| *name);
        let (name, comment) = match (given, graph.nodes[id as usize]) {
            (Some(given), _) => {
                let (equation, name) = given.rsplit_once(' ').unwrap_or(("", given));
                let comment = if equation.is_empty() { String::new() } else { format!(" // {equation}") };
                (name.to_owned(), comment)
            }
            (None, Op::Read(slot, dx, dy)) => {
                (format!("{}{}", graph.reads[slot as usize], compass(dx, dy)), String::new())
            }
            _ => (format!("n{id}"), String::new()),
        };
        // Words of the language itself can be no names.
        let free = !naga::keywords::wgsl::RESERVED.contains(&name.as_str()) && self.taken.insert(name.clone());
        let name = if free { name } else { format!("{name}_{id}") };
        self.of[id as usize] = Some(name.clone());
        (name, comment)
    }

    fn value(&self, graph: &Graph, stage: usize, id: Id) -> String {
        match graph.nodes[id as usize] {
            Op::Const(c) => float(f32::from_bits(c)),
            Op::BitsConst(c) => format!("{c:#x}u"),
            Op::Param(i) => format!("job.{}_{stage}", graph.params[i as usize]),
            Op::X => "f32(x)".into(),
            Op::Y => "f32(y)".into(),
            _ => self.of[id as usize].clone().unwrap_or_else(|| format!("n{id}")),
        }
    }
}

/// `_e` for the eastern neighbour, `_nww` for the one a row up and two columns to the west.
fn compass(dx: i32, dy: i32) -> String {
    let repeat = |letter: &str, n: i32| letter.repeat(n.unsigned_abs() as usize);
    let y = repeat(if dy < 0 { "n" } else { "s" }, dy);
    let x = repeat(if dx < 0 { "w" } else { "e" }, dx);
    if dx == 0 && dy == 0 { String::new() } else { format!("_{y}{x}") }
}

/// A literal that WGSL reads back as the same f32.
fn float(v: f32) -> String {
    if !v.is_finite() {
        return format!("bitcast<f32>({:#x}u)", v.to_bits());
    }
    if v.is_sign_negative() { format!("({v:?}f)") } else { format!("{v:?}f") }
}
