//! What the names of a text are, and whether types, units and limits fit.

use crate::functions::{FUNCTIONS, Kind as Does, NAMES, function};
use crate::parse_error::ParseError;
use crate::rule::DeclaredLayer;
use crate::syntax::{Binary, Kind, Text, Tree};
use crate::unit::{Measure, Unit};
use eyot_core::rule::{MAX_REACH, MAX_READS};
use eyot_core::{Grid, LayerSpec};
use std::ops::Range;
use std::sync::Arc;

/// A layer that texts may name.
#[derive(Clone, Debug)]
pub struct Known {
    /// What it is.
    pub spec: LayerSpec,
    /// Whether its unit is known; if not, no sum with it is refused.
    pub measured: bool,
    /// Whose layer it is, if the recipe declares it.
    pub declared: Option<Arc<DeclaredLayer>>,
}

/// What texts may name.
#[derive(Clone, Debug, Default)]
pub struct Scope {
    /// Layers that exist when the rule runs, and those that the recipe declares.
    pub layers: Vec<Known>,
}

impl Scope {
    /// The layer of a name.
    pub fn layer(&self, name: &str) -> Option<&Known> {
        self.layers.iter().find(|k| k.spec.name == name)
    }
}

impl Known {
    pub(crate) fn measure(&self) -> Measure {
        if self.measured { Measure::of(&self.spec.unit) } else { Measure::Unknown }
    }
}

/// Where the value of a program's parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    /// The rule's own parameter of this number.
    Own(usize),
    SeaLevel,
    Steps,
    CellX,
    CellY,
    /// 1 / columns.
    PerColumn,
    /// 1 / rows.
    PerRow,
    /// 1 / cell_x^2.
    PerSquareX,
    PerSquareY,
    /// 0.5 / cell_x.
    HalfPerX,
    HalfPerY,
}

impl Given {
    /// The value in a step, of a rule with these parameters of its own.
    pub(crate) fn value(self, own: &[f32], g: &Grid, sea_level_m: f64, step: u64) -> f32 {
        match self {
            Self::Own(i) => own[i],
            Self::SeaLevel => sea_level_m as f32,
            Self::Steps => step as f32,
            Self::CellX => g.cell_x_m as f32,
            Self::CellY => g.cell_y_m as f32,
            Self::PerColumn => (1.0 / g.width as f64) as f32,
            Self::PerRow => (1.0 / g.height as f64) as f32,
            Self::PerSquareX => (1.0 / (g.cell_x_m * g.cell_x_m)) as f32,
            Self::PerSquareY => (1.0 / (g.cell_y_m * g.cell_y_m)) as f32,
            Self::HalfPerX => (0.5 / g.cell_x_m) as f32,
            Self::HalfPerY => (0.5 / g.cell_y_m) as f32,
        }
    }
}

/// A checked expression. Numbers and conditions are in their right places.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    Number(f32),
    /// A parameter of the program.
    Param(usize),
    Column,
    Row,
    Read(usize, isize, isize),
    Random(u32),
    /// A named part, as seen from so many cells east and south.
    Part(usize, isize, isize),
    Apply(Does, Vec<Form>),
    /// A cell's neighbours, and the parameters that distances need.
    Around(crate::functions::Around, [usize; 2], Box<Form>),
    Negative(Box<Form>),
    Arithmetic(Binary, Box<[Form; 2]>),
    /// To a whole power by products.
    Whole(u32, Box<Form>),
    Truth(bool),
    Compare(Binary, Box<[Form; 2]>),
    Not(Box<Form>),
    Both(Box<[Form; 2]>),
    Either(Box<[Form; 2]>),
}

/// What all texts of one rule use together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Uses {
    /// Layers in the order of their slots.
    pub(crate) reads: Vec<String>,
    /// Parameters of the program.
    pub(crate) params: Vec<Given>,
    /// Calls of `random` so far.
    pub(crate) randoms: u32,
}

impl Uses {
    pub(crate) fn param(&mut self, given: Given) -> usize {
        self.params.iter().position(|p| *p == given).unwrap_or_else(|| {
            self.params.push(given);
            self.params.len() - 1
        })
    }

    /// The slot of a layer.
    pub(crate) fn slot(&mut self, layer: &str) -> usize {
        self.reads.iter().position(|r| r == layer).unwrap_or_else(|| {
            self.reads.push(layer.to_owned());
            self.reads.len() - 1
        })
    }
}

/// A checked text.
#[derive(Clone, Debug)]
pub(crate) struct Formula {
    pub(crate) parts: Vec<Form>,
    pub(crate) value: Form,
}

/// What a text must give.
#[derive(Clone, Copy)]
pub(crate) enum Wanted<'a> {
    /// A number in this unit: of a layer of this name.
    Number(&'a Measure, &'a str),
    /// A number in this unit: a parameter of this name.
    Parameter(&'a Measure, &'a str),
    Condition,
}

/// What is known of a part of a text.
#[derive(Clone)]
struct Found {
    form: Form,
    /// `None` for a condition.
    measure: Option<Measure>,
    /// How far it looks.
    reach: usize,
    random: bool,
    /// Its value, if it has but one.
    constant: Option<f64>,
}

struct Part {
    name: String,
    found: Found,
}

struct Checker<'a> {
    scope: &'a Scope,
    parameters: &'a [(String, f32)],
    /// First bits of this rule's streams of random numbers.
    stream: u32,
    uses: &'a mut Uses,
    parts: Vec<Part>,
}

/// Checks a text.
pub(crate) fn check(
    text: &str,
    wanted: Wanted<'_>,
    scope: &Scope,
    parameters: &[(String, f32)],
    stream: u32,
    uses: &mut Uses,
) -> Result<Formula, ParseError> {
    let tree = Text::parse(text)?;
    let mut checker = Checker { scope, parameters, stream, uses, parts: Vec::new() };
    for (name, span, value) in &tree.names {
        let here = parameters.iter().any(|(p, _)| p == name) || checker.parts.iter().any(|p| p.name == *name);
        if here || crate::functions::meaning(name).is_some() || scope.layer(name).is_some() {
            let message = format!("`{name}` is the name of something else");
            return Err(ParseError::at(span, message, "taken").help("choose another name for this part"));
        }
        let found = checker.any(value, 0)?;
        checker.parts.push(Part { name: name.clone(), found });
    }
    let value = match wanted {
        Wanted::Condition => checker.condition(&tree.value, 0)?,
        Wanted::Number(..) | Wanted::Parameter(..) => checker.number(&tree.value, 0)?,
    };
    let whose = match wanted {
        Wanted::Number(wanted, layer) => Some((wanted, format!("the layer `{layer}`"))),
        Wanted::Parameter(wanted, name) => Some((wanted, format!("the parameter `{name}`"))),
        Wanted::Condition => None,
    };
    if let (Some((wanted, whose)), Some(found)) = (whose, &value.measure)
        && let Err((has, needs)) = found.with(wanted)
    {
        let message = format!("this is in {has}, {whose} in {needs}");
        let help = format!("a factor that you write takes any unit: {}", factor(&needs, &has));
        return Err(ParseError::at(&tree.value.span, message, format!("in {has}")).help(help));
    }
    Ok(Formula { parts: checker.parts.into_iter().map(|p| p.found.form).collect(), value: value.form })
}

fn factor(wanted: &Unit, found: &Unit) -> String {
    format!("0.5 * ... stands for 0.5 {wanted} for each {found}")
}

impl Checker<'_> {
    fn number(&mut self, tree: &Tree, around: usize) -> Result<Found, ParseError> {
        let found = self.any(tree, around)?;
        if found.measure.is_some() {
            return Ok(found);
        }
        let problem = ParseError::at(&tree.span, "this is a condition where a number is needed", "true or false");
        Err(problem.help("choose numbers for both cases: if(condition, 1, 0)"))
    }

    fn condition(&mut self, tree: &Tree, around: usize) -> Result<Found, ParseError> {
        let found = self.any(tree, around)?;
        if found.measure.is_none() {
            return Ok(found);
        }
        let problem = ParseError::at(&tree.span, "this is a number where a condition is needed", "a number");
        Err(problem.help("compare it: ... > 0"))
    }

    /// `around` is how far the functions outside of this part look from the cell.
    fn any(&mut self, tree: &Tree, around: usize) -> Result<Found, ParseError> {
        match &tree.kind {
            Kind::Number(n) => Ok(constant(*n)),
            Kind::Truth(t) => {
                Ok(Found { form: Form::Truth(*t), measure: None, reach: 0, random: false, constant: None })
            }
            Kind::Name(name, offset) => self.name(name, *offset, &tree.span, around),
            Kind::Call(name, at, arguments) => self.call(name, at, arguments, tree, around),
            Kind::Negative(inner) => {
                let a = self.number(inner, around)?;
                Ok(Found { constant: a.constant.map(|v| -v), form: Form::Negative(Box::new(a.form)), ..a })
            }
            Kind::Not(inner) => {
                let a = self.condition(inner, around)?;
                Ok(Found { form: Form::Not(Box::new(a.form)), ..a })
            }
            Kind::Binary(op, at, sides) => self.binary(*op, at, sides, tree, around),
        }
    }

    fn name(
        &mut self,
        name: &str,
        offset: Option<(i64, i64)>,
        span: &Range<usize>,
        around: usize,
    ) -> Result<Found, ParseError> {
        let (dx, dy) = offset.unwrap_or_default();
        let far = dx.unsigned_abs().max(dy.unsigned_abs()) as usize;
        if let Some(i) = self.parts.iter().position(|p| p.name == name) {
            let part = self.parts[i].found.clone();
            self.reaches(span, part.reach, far, around)?;
            self.stays(span, part.random, far + around)?;
            return Ok(Found { form: Form::Part(i, dx as isize, dy as isize), reach: part.reach + far, ..part });
        }
        if let Some(known) = self.scope.layer(name) {
            self.reaches(span, 0, far, around)?;
            let measure = known.measure();
            if !self.uses.reads.iter().any(|r| r == name) && self.uses.reads.len() >= MAX_READS {
                let message = format!("a rule reads at most {MAX_READS} layers, this one more");
                return Err(ParseError::at(span, message, "one too many").help("split it into several rules"));
            }
            let slot = self.uses.slot(name);
            let form = Form::Read(slot, dx as isize, dy as isize);
            return Ok(Found { form, measure: Some(measure), reach: far, random: false, constant: None });
        }
        if offset.is_some() {
            let problem = ParseError::at(span, format!("`{name}` has no neighbours"), "no layer");
            let known = self.scope.layers.iter().map(|k| k.spec.name.to_string()).collect();
            return Err(problem.help("offsets go with layers and named parts").among(name, known));
        }
        if let Some(i) = self.parameters.iter().position(|(p, _)| p == name) {
            let form = Form::Param(self.uses.param(Given::Own(i)));
            return Ok(Found { form, measure: Some(Measure::Free), reach: 0, random: false, constant: None });
        }
        self.always(name).ok_or_else(|| self.nothing(name, span))
    }

    /// A name that is always there.
    fn always(&mut self, name: &str) -> Option<Found> {
        let known = NAMES.iter().find(|n| n.name == name)?;
        let mut param = |given| Form::Param(self.uses.param(given));
        let product = |a, b| Form::Arithmetic(Binary::Multiply, Box::new([a, b]));
        let middle = |at| Form::Arithmetic(Binary::Add, Box::new([at, Form::Number(0.5)]));
        let form = match name {
            "x" => product(middle(Form::Column), param(Given::CellX)),
            "y" => product(middle(Form::Row), param(Given::CellY)),
            "u" => product(middle(Form::Column), param(Given::PerColumn)),
            "v" => product(middle(Form::Row), param(Given::PerRow)),
            "column" => Form::Column,
            "row" => Form::Row,
            "cell_x" => param(Given::CellX),
            "cell_y" => param(Given::CellY),
            "steps" => param(Given::Steps),
            "sea_level" => param(Given::SeaLevel),
            _ => return Some(constant(std::f64::consts::PI)),
        };
        Some(Found { form, measure: Some(Measure::of(known.unit)), reach: 0, random: false, constant: None })
    }

    fn nothing(&self, name: &str, span: &Range<usize>) -> ParseError {
        if function(name).is_some() {
            let problem = ParseError::at(span, format!("`{name}` is a function"), "without its arguments");
            return problem.help(format!("write {name}({})", function(name).map_or("", |f| f.arguments)));
        }
        let layers = self.scope.layers.iter().map(|k| k.spec.name.to_string());
        let parts = self.parts.iter().map(|p| p.name.clone());
        let parameters = self.parameters.iter().map(|(p, _)| p.clone());
        let known = layers.chain(parts).chain(parameters).chain(NAMES.iter().map(|n| n.name.to_owned())).collect();
        ParseError::at(span, format!("nothing is called `{name}` here"), "unknown name").among(name, known)
    }

    fn reaches(&self, span: &Range<usize>, own: usize, far: usize, around: usize) -> Result<(), ParseError> {
        if own + far + around <= MAX_REACH {
            return Ok(());
        }
        let message = match (own, around) {
            (0, 0) => format!("this looks {far} cells away, a rule at most {MAX_REACH}"),
            _ => format!(
                "together with what is around it this looks {} cells away, a rule at most {MAX_REACH}",
                own + far + around
            ),
        };
        Err(ParseError::at(span, message, "too far").help("let another rule bring what is farther away closer"))
    }

    fn stays(&self, span: &Range<usize>, random: bool, far: usize) -> Result<(), ParseError> {
        if !random || far == 0 {
            return Ok(());
        }
        let message = "a random number is its own cell's; those of neighbours cannot be seen";
        Err(ParseError::at(span, message, "random").help("keep it in a layer, and read that layer around the cell"))
    }

    fn call(
        &mut self,
        name: &str,
        at: &Range<usize>,
        arguments: &[Tree],
        tree: &Tree,
        around: usize,
    ) -> Result<Found, ParseError> {
        let Some(function) = function(name) else {
            if self.scope.layer(name).is_some() || self.parts.iter().any(|p| p.name == name) {
                let problem = ParseError::at(at, format!("`{name}` is no function"), "a layer");
                return Err(problem.help(format!("neighbours stand in brackets: {name}[1, 0]")));
            }
            let known = FUNCTIONS.iter().map(|f| f.name.to_owned()).collect();
            return Err(
                ParseError::at(at, format!("there is no function `{name}`"), "unknown function").among(name, known)
            );
        };
        let (least, most) = function.count;
        if !(least..=most).contains(&arguments.len()) {
            let values = |n: usize| if n == 1 { "1 argument".to_owned() } else { format!("{n} arguments") };
            let wanted = if least == most { values(least) } else { format!("{least} to {most} arguments") };
            let message = format!("`{name}` takes {wanted}, not {}", arguments.len());
            let help = format!("write {name}({}): {}", function.arguments, function.meaning);
            return Err(ParseError::at(&tree.span, message, "wrong number of arguments").help(help));
        }
        match function.kind {
            Does::Random => {
                self.stays(&tree.span, true, around)?;
                self.uses.randoms += 1;
                let form = Form::Random(self.stream.wrapping_add(self.uses.randoms));
                Ok(Found { form, measure: Some(Measure::Free), reach: 0, random: true, constant: None })
            }
            Does::If => self.choice(arguments, around),
            Does::Around(kind) => self.around(kind, &arguments[0], tree, around),
            Does::Power => self.power(&arguments[0], &arguments[1], around),
            kind => self.plain_function(kind, name, arguments, around),
        }
    }

    fn choice(&mut self, arguments: &[Tree], around: usize) -> Result<Found, ParseError> {
        let c = self.condition(&arguments[0], around)?;
        let (a, b) = (self.number(&arguments[1], around)?, self.number(&arguments[2], around)?);
        let measure = agree(&[(&a, &arguments[1]), (&b, &arguments[2])])?;
        Ok(Found {
            measure: Some(measure),
            reach: c.reach.max(a.reach).max(b.reach),
            random: c.random || a.random || b.random,
            constant: None,
            form: Form::Apply(Does::If, vec![c.form, a.form, b.form]),
        })
    }

    fn around(
        &mut self,
        kind: crate::functions::Around,
        argument: &Tree,
        tree: &Tree,
        around: usize,
    ) -> Result<Found, ParseError> {
        use crate::functions::Around::*;
        if around + 1 > MAX_REACH {
            let message = format!("functions of neighbours are nested more than {MAX_REACH} deep");
            return Err(ParseError::at(&tree.span, message, "too far").help("let another rule compute the inner one"));
        }
        let a = self.number(argument, around + 1)?;
        let measure = a.measure.clone().unwrap_or(Measure::Unknown);
        let (params, measure) = match kind {
            Laplacian => {
                let params = [self.uses.param(Given::PerSquareX), self.uses.param(Given::PerSquareY)];
                (params, measure.times(&Measure::Of(Unit::metres(-2)), 1))
            }
            SlopeX | SlopeY | Slope => {
                let params = [self.uses.param(Given::HalfPerX), self.uses.param(Given::HalfPerY)];
                (params, measure.times(&Measure::Of(Unit::metres(-1)), 1))
            }
            _ => ([0, 0], measure),
        };
        let form = Form::Around(kind, params, Box::new(a.form));
        Ok(Found { form, measure: Some(measure), reach: a.reach + 1, random: a.random, constant: None })
    }

    fn plain_function(
        &mut self,
        kind: Does,
        name: &str,
        arguments: &[Tree],
        around: usize,
    ) -> Result<Found, ParseError> {
        let mut found = Vec::new();
        for argument in arguments {
            found.push(self.number(argument, around)?);
        }
        if kind == Does::Mod && found[1].constant == Some(0.0) {
            let problem = ParseError::at(&arguments[1].span, "this divides by zero", "always 0");
            return Err(problem.help("give the length of the interval"));
        }
        let of = |i: usize| found[i].measure.clone().unwrap_or(Measure::Unknown);
        let all: Vec<(&Found, &Tree)> = found.iter().zip(arguments).collect();
        let measure = match kind {
            Does::Exp | Does::Ln | Does::Log2 | Does::Log10 | Does::Sin | Does::Cos | Does::Tan => {
                plain(&found[0], &arguments[0], name)?;
                Measure::plain()
            }
            Does::Sqrt => of(0).power(0.5),
            Does::Sign => Measure::plain(),
            Does::Step | Does::Smoothstep => agree(&all).map(|_| Measure::plain())?,
            Does::Mix => {
                plain(&found[2], &arguments[2], "the share of mix")?;
                agree(&all[..2])?
            }
            _ => agree(&all)?,
        };
        Ok(Found {
            measure: Some(measure),
            reach: found.iter().map(|f| f.reach).max().unwrap_or(0),
            random: found.iter().any(|f| f.random),
            constant: None,
            form: Form::Apply(kind, found.into_iter().map(|f| f.form).collect()),
        })
    }

    fn power(&mut self, base: &Tree, exponent: &Tree, around: usize) -> Result<Found, ParseError> {
        let (a, b) = (self.number(base, around)?, self.number(exponent, around)?);
        plain(&b, exponent, "an exponent")?;
        let measure = a.measure.clone().unwrap_or(Measure::Unknown);
        let (reach, random) = (a.reach.max(b.reach), a.random || b.random);
        let whole = b.constant.filter(|n| n.fract() == 0.0 && (0.0..=8.0).contains(n));
        let (form, measure, constant) = match (whole, b.constant) {
            (Some(n), _) => (
                Form::Whole(n as u32, Box::new(a.form)),
                if n == 0.0 { Measure::plain() } else { measure.power(n) },
                a.constant.map(|v| v.powi(n as i32)),
            ),
            (None, Some(n)) => (Form::Apply(Does::Power, vec![a.form, b.form]), measure.power(n), None),
            (None, None) => {
                plain(&a, base, "the base of an exponent that changes")?;
                (Form::Apply(Does::Power, vec![a.form, b.form]), Measure::plain(), None)
            }
        };
        Ok(Found { form, measure: Some(measure), reach, random, constant })
    }

    fn binary(
        &mut self,
        op: Binary,
        at: &Range<usize>,
        sides: &[Tree; 2],
        tree: &Tree,
        around: usize,
    ) -> Result<Found, ParseError> {
        use Binary::*;
        if op == Power {
            return self.power(&sides[0], &sides[1], around);
        }
        let logic = matches!(op, Or | And);
        let mut side = |tree: &Tree| if logic { self.condition(tree, around) } else { self.number(tree, around) };
        let (a, b) = (side(&sides[0])?, side(&sides[1])?);
        let (reach, random) = (a.reach.max(b.reach), a.random || b.random);
        let forms = Box::new([a.form.clone(), b.form.clone()]);
        let numbers = [(&a, &sides[0]), (&b, &sides[1])];
        let (form, measure, constant) = match op {
            Or => (Form::Either(forms), None, None),
            And => (Form::Both(forms), None, None),
            Less | AtMost | Greater | AtLeast | Equal | Unequal => {
                agree(&numbers).map_err(|m| ParseError { span: at.clone(), ..m })?;
                (Form::Compare(op, forms), None, None)
            }
            _ => {
                let of = |f: &Found| f.measure.clone().unwrap_or(Measure::Unknown);
                let measure = match op {
                    Multiply => of(&a).times(&of(&b), 1),
                    Divide => of(&a).times(&of(&b), -1),
                    _ => agree(&numbers).map_err(|m| ParseError { span: at.clone(), ..m })?,
                };
                if op == Divide && b.constant == Some(0.0) {
                    let problem = ParseError::at(&sides[1].span, "this divides by zero", "always 0");
                    return Err(problem.help("leave the division out, or divide by something else"));
                }
                let values = a.constant.zip(b.constant);
                let constant = values.map(|(a, b)| match op {
                    Multiply => a * b,
                    Divide => a / b,
                    Add => a + b,
                    _ => a - b,
                });
                if constant.is_some_and(|v| !(v as f32).is_finite()) {
                    let problem = ParseError::at(&tree.span, "this is beyond what a number can be", "too large");
                    return Err(problem.help("the largest is 3.4e38"));
                }
                (Form::Arithmetic(op, forms), Some(measure), constant)
            }
        };
        Ok(Found { form, measure, reach, random, constant })
    }
}

fn constant(n: f64) -> Found {
    Found { form: Form::Number(n as f32), measure: Some(Measure::Free), reach: 0, random: false, constant: Some(n) }
}

/// The unit that all values share.
fn agree(values: &[(&Found, &Tree)]) -> Result<Measure, ParseError> {
    let mut all = Measure::Free;
    for (found, tree) in values {
        let own = found.measure.clone().unwrap_or(Measure::Unknown);
        all = all.with(&own).map_err(|(before, this)| {
            let message = format!("{before} and {this} do not go together");
            let help = format!("a factor that you write takes any unit: {}", factor(&before, &this));
            ParseError::at(&tree.span, message, format!("in {this}")).help(help)
        })?;
    }
    Ok(all)
}

/// Refuses what has a unit.
fn plain(found: &Found, tree: &Tree, what: &str) -> Result<(), ParseError> {
    match &found.measure {
        Some(Measure::Of(unit)) if !unit.is_plain() => {
            let message = format!("{what} takes a plain number, this is in {unit}");
            let help = format!("divide by something in {unit}, or multiply by a number");
            Err(ParseError::at(&tree.span, message, format!("in {unit}")).help(help))
        }
        _ => Ok(()),
    }
}
