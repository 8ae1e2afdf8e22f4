//! What the language knows beside layers and parameters: names and functions.

/// A name that is always there.
#[derive(Clone, Copy, Debug)]
pub struct Name {
    /// The name.
    pub name: &'static str,
    /// Unit, `1` for a plain number.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

const fn name(name: &'static str, unit: &'static str, meaning: &'static str) -> Name {
    Name { name, unit, meaning }
}

/// All names.
pub const NAMES: [Name; 11] = [
    name("x", "m", "distance of the cell's middle from the western rim"),
    name("y", "m", "distance of the cell's middle from the northern rim"),
    name("u", "1", "the same as a share of the width, from 0 in the west to 1 in the east"),
    name("v", "1", "the same as a share of the height, from 0 in the north to 1 in the south"),
    name("column", "1", "number of the column, from 0 in the west"),
    name("row", "1", "number of the row, from 0 in the north"),
    name("cell_x", "m", "size of a cell from west to east"),
    name("cell_y", "m", "size of a cell from north to south"),
    name("steps", "1", "steps that the world has done before this one (rounded above 16777216)"),
    name("sea_level", "m", "level of the sea"),
    name("pi", "1", "3.1415927"),
];

/// What a function does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Abs,
    Sign,
    Sqrt,
    Exp,
    Ln,
    Log2,
    Log10,
    Power,
    Sin,
    Cos,
    Tan,
    Floor,
    Ceil,
    Round,
    Fract,
    Mod,
    Min,
    Max,
    Clamp,
    Mix,
    Step,
    Smoothstep,
    Hypot,
    If,
    Random,
    Around(Around),
}

/// What a function does with the cells around one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Around {
    Sum4,
    Sum8,
    Mean4,
    Mean8,
    Min4,
    Min8,
    Max4,
    Max8,
    Laplacian,
    SlopeX,
    SlopeY,
    Slope,
}

/// A function.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// Its arguments, for people.
    pub arguments: &'static str,
    /// What it gives.
    pub meaning: &'static str,
    pub(crate) kind: Kind,
    /// Fewest and most arguments.
    pub(crate) count: (usize, usize),
}

const fn of(
    name: &'static str,
    arguments: &'static str,
    count: (usize, usize),
    kind: Kind,
    meaning: &'static str,
) -> Function {
    Function { name, arguments, meaning, kind, count }
}

const fn around(name: &'static str, kind: Around, meaning: &'static str) -> Function {
    of(name, "a", (1, 1), Kind::Around(kind), meaning)
}

/// All functions.
pub const FUNCTIONS: [Function; 38] = [
    of("if", "condition, a, b", (3, 3), Kind::If, "a where the condition holds, else b"),
    of("min", "a, b, ...", (2, 16), Kind::Min, "the smallest"),
    of("max", "a, b, ...", (2, 16), Kind::Max, "the largest"),
    of("clamp", "a, low, high", (3, 3), Kind::Clamp, "a, but at least low and at most high"),
    of("mix", "a, b, t", (3, 3), Kind::Mix, "a + (b - a) t"),
    of("step", "edge, a", (2, 2), Kind::Step, "0 where a is below the edge, else 1"),
    of("smoothstep", "low, high, a", (3, 3), Kind::Smoothstep, "0 below low, 1 above high, a cubic curve between them"),
    of("abs", "a", (1, 1), Kind::Abs, "magnitude"),
    of("sign", "a", (1, 1), Kind::Sign, "-1, 0 or 1"),
    of("floor", "a", (1, 1), Kind::Floor, "largest whole number not above"),
    of("ceil", "a", (1, 1), Kind::Ceil, "smallest whole number not below"),
    of("round", "a", (1, 1), Kind::Round, "nearest whole number, halves upwards"),
    of("fract", "a", (1, 1), Kind::Fract, "a - floor(a)"),
    of("mod", "a, b", (2, 2), Kind::Mod, "a - b floor(a / b)"),
    of("sqrt", "a", (1, 1), Kind::Sqrt, "square root; of less than 0 it is 0"),
    of(
        "pow",
        "a, b",
        (2, 2),
        Kind::Power,
        "a to the power b, also a^b; for whole b up to 8 products, else 0 where a is not above 0",
    ),
    of("exp", "a", (1, 1), Kind::Exp, "e to the power a"),
    of("ln", "a", (1, 1), Kind::Ln, "natural logarithm; of 0 and less it is about -87"),
    of("log", "a", (1, 1), Kind::Ln, "the same as ln"),
    of("log2", "a", (1, 1), Kind::Log2, "logarithm to base 2"),
    of("log10", "a", (1, 1), Kind::Log10, "logarithm to base 10"),
    of("sin", "a", (1, 1), Kind::Sin, "sine of an angle in radians"),
    of("cos", "a", (1, 1), Kind::Cos, "cosine of an angle in radians"),
    of("tan", "a", (1, 1), Kind::Tan, "tangent of an angle in radians"),
    of("hypot", "a, b", (2, 2), Kind::Hypot, "square root of a^2 + b^2"),
    of(
        "random",
        "",
        (0, 0),
        Kind::Random,
        "a number from 0 to less than 1, another one for each cell, step and place in the text",
    ),
    around("sum4", Around::Sum4, "sum over the 4 neighbours that share an edge"),
    around("sum8", Around::Sum8, "sum over the 8 neighbours"),
    around("mean4", Around::Mean4, "mean of the 4 neighbours"),
    around("mean8", Around::Mean8, "mean of the 8 neighbours"),
    around("min4", Around::Min4, "smallest of the 4 neighbours"),
    around("min8", Around::Min8, "smallest of the 8 neighbours"),
    around("max4", Around::Max4, "largest of the 4 neighbours"),
    around("max8", Around::Max8, "largest of the 8 neighbours"),
    around("laplacian", Around::Laplacian, "sum of the second derivatives, per m2"),
    around("slope_x", Around::SlopeX, "derivative towards the east, per m"),
    around("slope_y", Around::SlopeY, "derivative towards the south, per m"),
    around("slope", Around::Slope, "length of the gradient, per m"),
];

/// The function of a name.
pub(crate) fn function(name: &str) -> Option<&'static Function> {
    static ALL: [Function; 38] = FUNCTIONS;
    ALL.iter().find(|f| f.name == name)
}

/// Words that stand between values.
const WORDS: [&str; 5] = ["and", "or", "not", "true", "false"];

/// Names that mean nothing yet and are kept for what may come: choices and loops, constants, coordinates, time.
const RESERVED: [&str; 27] = [
    "else",
    "then",
    "where",
    "let",
    "for",
    "in",
    "return",
    "e",
    "tau",
    "inf",
    "nan",
    "z",
    "lat",
    "lon",
    "latitude",
    "longitude",
    "t",
    "dt",
    "time",
    "second",
    "minute",
    "hour",
    "day",
    "week",
    "month",
    "year",
    "season",
];

/// What a name means in expressions, as the end of a sentence that begins with it; no part and no parameter may have it.
pub fn meaning(name: &str) -> Option<&'static str> {
    if function(name).is_some() {
        return Some("is a function in expressions");
    }
    if let Some(known) = NAMES.iter().find(|n| n.name == name) {
        return Some(if known.name == "pi" { "is a number in expressions" } else { "is known in expressions" });
    }
    WORDS.contains(&name).then_some("is a word of expressions")
}

/// Why no layer and no rule may have a name, as [`meaning`]. Files keep the names of layers, so some are kept for later.
pub fn taken(name: &str) -> Option<&'static str> {
    let later = || RESERVED.contains(&name).then_some("is kept for expressions of later versions");
    meaning(name).or_else(later)
}
