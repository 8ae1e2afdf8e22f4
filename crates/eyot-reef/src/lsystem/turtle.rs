//! The turtle: from words to lines in space. z is up; it starts at the origin and looks up.

use super::context::Surroundings;
use super::derive::{Budget, Writer};
use super::grammar::{Grammar, bad};
use super::word::{Symbol, Word};
use eyot_core::math64::{cos_degrees, sin_degrees};
use eyot_core::rng::Key;
use eyot_core::vec3::{cross, dot};
use eyot_core::{Limits, Result};

/// A vector.
pub type Vector = [f64; 3];

/// A question to the environment.
#[derive(Clone, Copy, Debug)]
pub struct Ask<'a> {
    /// Letter of the query.
    pub name: char,
    /// Its numbers.
    pub numbers: &'a [f64],
    /// Where the turtle is.
    pub position: Vector,
    /// Where it looks.
    pub heading: Vector,
    /// What is up for it.
    pub up: Vector,
}

/// A drawn step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it begins.
    pub from: Vector,
    /// Where it ends.
    pub to: Vector,
    /// Width at both ends.
    pub widths: [f64; 2],
    /// Number of the colour.
    pub colour: u32,
    /// The segment that ends where this one begins and of which it grows, if there is one.
    pub parent: Option<u32>,
    /// Brackets that it stands in.
    pub depth: u32,
}

/// Points that are joined, each with the width there.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// Points.
    pub points: Vec<Vector>,
    /// Widths.
    pub widths: Vec<f64>,
    /// Number of the colour.
    pub colour: u32,
}

/// What the turtle drew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Drawn steps, in the order of the word.
    pub segments: Vec<Segment>,
    /// Outlines of filled shapes.
    pub polygons: Vec<Polyline>,
    /// Where the turtle stands at the end.
    pub end: Vector,
}

impl Drawing {
    /// Smallest and largest coordinates of what is drawn.
    pub fn bounds(&self) -> Option<[Vector; 2]> {
        let points = self.segments.iter().flat_map(|s| [s.from, s.to]);
        let points = points.chain(self.polygons.iter().flat_map(|p| p.points.iter().copied()));
        points.fold(None, |bounds, p| {
            let [low, high]: [Vector; 2] = bounds.unwrap_or([p, p]);
            Some([std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))])
        })
    }

    /// Segments joined to lines: each begins at a branching or a gap and runs along first children of the same colour.
    pub fn polylines(&self) -> Vec<Polyline> {
        let mut next: Vec<Option<usize>> = vec![None; self.segments.len()];
        let mut is_start = vec![true; self.segments.len()];
        for (i, s) in self.segments.iter().enumerate() {
            if let Some(parent) = s.parent.map(|p| p as usize)
                && next[parent].is_none()
                && self.segments[parent].colour == s.colour
                && self.segments[parent].depth == s.depth
            {
                next[parent] = Some(i);
                is_start[i] = false;
            }
        }
        let starts = (0..self.segments.len()).filter(|&i| is_start[i]);
        starts
            .map(|start| {
                let first = &self.segments[start];
                let (mut points, mut widths) = (vec![first.from], vec![first.widths[0]]);
                let mut at = Some(start);
                while let Some(i) = at {
                    points.push(self.segments[i].to);
                    widths.push(self.segments[i].widths[1]);
                    at = next[i];
                }
                Polyline { points, widths, colour: first.colour }
            })
            .collect()
    }
}

/// The turtle's state, which brackets save.
#[derive(Clone, Copy, Debug)]
struct Pose {
    position: Vector,
    heading: Vector,
    left: Vector,
    up: Vector,
    width: f64,
    /// Width at the end of the last segment, so that tapering branches have no steps.
    drawn_width: f64,
    colour: u32,
    parent: Option<u32>,
}

impl Pose {
    /// Turns `a` towards `b` by an angle in degrees; both are unit vectors at right angles.
    fn turn(a: &mut Vector, b: &mut Vector, degrees: f64) {
        let (s, c) = (sin_degrees(degrees), cos_degrees(degrees));
        let (p, q) = (*a, *b);
        *a = std::array::from_fn(|i| p[i] * c + q[i] * s);
        *b = std::array::from_fn(|i| q[i] * c - p[i] * s);
    }

    fn turn_left(&mut self, degrees: f64) {
        Self::turn(&mut self.heading, &mut self.left, degrees);
    }

    fn pitch_up(&mut self, degrees: f64) {
        Self::turn(&mut self.heading, &mut self.up, degrees);
    }

    fn roll_left(&mut self, degrees: f64) {
        Self::turn(&mut self.left, &mut self.up, degrees);
    }

    /// Rolls so that `left` is horizontal.
    fn level(&mut self) {
        let left = cross([0.0, 0.0, 1.0], self.heading);
        let length = dot(left, left).sqrt();
        if length > 1e-9 {
            self.left = left.map(|v| v / length);
            self.up = cross(self.heading, self.left);
        }
    }

    /// Bends towards a direction, by `elasticity` radians times the sine of the angle between.
    fn bend(&mut self, tropism: Vector, elasticity: f64) {
        let axis = cross(self.heading, tropism);
        let length = dot(axis, axis).sqrt();
        if length * elasticity == 0.0 {
            return;
        }
        let axis = axis.map(|v| v / length);
        let degrees = (elasticity * length).to_degrees();
        let (s, c) = (sin_degrees(degrees), cos_degrees(degrees));
        for v in [&mut self.heading, &mut self.left, &mut self.up] {
            // Rodrigues: v cos + (axis x v) sin + axis (axis . v) (1 - cos)
            let (across, along) = (cross(axis, *v), dot(axis, *v) * (1.0 - c));
            *v = std::array::from_fn(|i| v[i] * c + across[i] * s + axis[i] * along);
        }
    }
}

/// A walk over a word, interpretation rules applied on the way.
struct Walk<'a> {
    grammar: &'a Grammar,
    pose: Pose,
    stack: Vec<Pose>,
    drawing: Drawing,
    outline: Vec<(Vec<Vector>, Vec<f64>)>,
    budget: Budget,
    key: Key,
}

/// Stream of the random numbers of interpretation rules.
const STREAM: u32 = 0x1575_0003;

impl<'a> Walk<'a> {
    fn new(grammar: &'a Grammar, seed: u64, limits: &Limits) -> Self {
        let width = grammar.turtle.width;
        let pose = Pose {
            position: [0.0; 3],
            heading: [0.0, 0.0, 1.0],
            left: [-1.0, 0.0, 0.0],
            up: [0.0, -1.0, 0.0],
            width,
            drawn_width: width,
            colour: 0,
            parent: None,
        };
        Self {
            grammar,
            pose,
            stack: Vec::new(),
            drawing: Drawing::default(),
            outline: Vec::new(),
            budget: Budget::new(limits),
            key: Key::new(seed, STREAM, 0),
        }
    }

    /// Follows a module, or what interpretation makes of it.
    fn follow(&mut self, word: &Word, surroundings: &Surroundings<'_>, at: usize, depth: u32) -> Result<()> {
        let symbol = word.symbols()[at];
        let rules = &self.grammar.interpretations;
        if depth < self.grammar.interpretation_depth && !rules.of(symbol).is_empty() {
            let mut inner = Word::default();
            let key = Key { low: self.key.low ^ depth.wrapping_mul(0x9e37_79b9), high: self.key.high };
            if Writer::new(rules, key).replace(word, surroundings, at, &mut inner, &self.budget)? {
                let around = Surroundings::new(&inner, &self.grammar.ignored, true);
                return (0..inner.len()).try_for_each(|i| self.follow(&inner, &around, i, depth + 1));
            }
        }
        self.command(symbol, word.numbers(at))
    }

    fn command(&mut self, symbol: Symbol, numbers: &[f64]) -> Result<()> {
        let turtle = &self.grammar.turtle;
        let angle = numbers.first().copied().unwrap_or(turtle.angle);
        if turtle.draws.contains(&symbol) {
            return self.forward(numbers.first().copied().unwrap_or(turtle.step), true);
        }
        match symbol.sign().unwrap_or(' ') {
            'f' => self.forward(numbers.first().copied().unwrap_or(turtle.step), false)?,
            '+' => self.pose.turn_left(angle),
            '-' => self.pose.turn_left(-angle),
            '&' => self.pose.pitch_up(-angle),
            '^' => self.pose.pitch_up(angle),
            '\\' => self.pose.roll_left(angle),
            '/' => self.pose.roll_left(-angle),
            '|' => self.pose.turn_left(180.0),
            '$' => self.pose.level(),
            '!' => self.pose.width = numbers.first().copied().unwrap_or(self.pose.width * turtle.thinning),
            '\'' => self.pose.colour = numbers.first().map_or(self.pose.colour + 1, |n| n.max(0.0) as u32),
            '[' => {
                self.budget.take(size_of::<Pose>())?;
                self.stack.push(self.pose);
            }
            ']' => self.pose = self.stack.pop().unwrap_or(self.pose),
            '{' => {
                let here = (vec![self.pose.position], vec![self.pose.width]);
                self.outline.push(here);
            }
            '.' => self.vertex()?,
            '}' => {
                if let Some((points, widths)) = self.outline.pop() {
                    self.drawing.polygons.push(Polyline { points, widths, colour: self.pose.colour });
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn vertex(&mut self) -> Result<()> {
        if let Some((points, widths)) = self.outline.last_mut() {
            self.budget.take(size_of::<Vector>() + size_of::<f64>())?;
            points.push(self.pose.position);
            widths.push(self.pose.width);
        }
        Ok(())
    }

    fn forward(&mut self, length: f64, draw: bool) -> Result<()> {
        let turtle = &self.grammar.turtle;
        let from = self.pose.position;
        let to = std::array::from_fn(|i| from[i] + length * self.pose.heading[i]);
        self.pose.position = to;
        // Inside an outline steps are its edges.
        if !self.outline.is_empty() {
            return self.vertex();
        }
        if !draw {
            (self.pose.parent, self.pose.drawn_width) = (None, self.pose.width);
            return Ok(());
        }
        self.budget.take(size_of::<Segment>())?;
        let start =
            if self.pose.parent.is_some() { self.pose.drawn_width.min(self.pose.width) } else { self.pose.width };
        let segment = Segment {
            from,
            to,
            widths: [start, self.pose.width],
            colour: self.pose.colour,
            parent: self.pose.parent,
            depth: self.stack.len() as u32,
        };
        self.pose.parent = Some(self.drawing.segments.len() as u32);
        self.pose.drawn_width = self.pose.width;
        self.drawing.segments.push(segment);
        self.pose.bend(turtle.tropism, turtle.elasticity);
        Ok(())
    }
}

impl Grammar {
    /// Draws a word.
    ///
    /// # Errors
    /// If the drawing would take more bytes than the limits allow, or leaves the range of numbers.
    pub fn draw(&self, word: &Word, seed: u64, limits: &Limits) -> Result<Drawing> {
        let mut walk = Walk::new(self, seed, limits);
        let surroundings = Surroundings::new(word, &self.ignored, !self.interpretations.is_empty());
        (0..word.len()).try_for_each(|i| walk.follow(word, &surroundings, i, 0))?;
        walk.drawing.end = walk.pose.position;
        let sound = |v: &Vector| v.iter().all(|x| x.is_finite());
        if !walk.drawing.segments.iter().all(|s| sound(&s.to) && s.widths.iter().all(|w| w.is_finite())) {
            return Err(bad("step", "lengths, angles or widths left the range of numbers".into()));
        }
        Ok(walk.drawing)
    }
}

/// Fills the numbers of all queries of a word.
pub(super) fn answer(
    grammar: &Grammar,
    word: &mut Word,
    limits: &Limits,
    environment: &dyn Fn(&Ask<'_>) -> Vec<f64>,
) -> Result<()> {
    let asked = word.clone();
    let mut walk = Walk::new(grammar, 0, limits);
    let surroundings = Surroundings::new(&asked, &grammar.ignored, !grammar.interpretations.is_empty());
    for i in 0..asked.len() {
        let Some(name) = asked.symbols()[i].query_name() else {
            walk.follow(&asked, &surroundings, i, 0)?;
            continue;
        };
        let Pose { position, heading, left, up, .. } = walk.pose;
        let numbers = asked.numbers(i);
        let answers = match name {
            'P' => position.to_vec(),
            'H' => heading.to_vec(),
            'L' => left.to_vec(),
            'U' => up.to_vec(),
            _ => environment(&Ask { name, numbers, position, heading, up }),
        };
        for (number, answer) in word.numbers_mut(i).iter_mut().zip(answers) {
            *number = answer;
        }
    }
    Ok(())
}
