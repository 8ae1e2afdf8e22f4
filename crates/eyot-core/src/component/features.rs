//! Features: lines and polygons with attributes, such as rivers, lakes and watersheds, as geographic programs know them.

use super::{Attributes, Component, ComponentKind, Decoder, Encoder, Shape, Type, View};
use crate::error::{Error, Result};
use crate::fingerprint::Fingerprint;
use std::borrow::Cow;
use std::sync::Arc;

/// What the parts of [`Features`] are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Form {
    /// Lines of two vertices or more.
    #[default]
    Lines,
    /// Rings of four vertices or more whose last one is the first. Seen from above with north up, a ring that runs counter-clockwise is
    /// the outside of a polygon, and those that run clockwise after it are its holes.
    Polygons,
}

impl Form {
    const ALL: [Self; 2] = [Self::Lines, Self::Polygons];

    /// Why these vertices are none of its parts.
    fn problem(self, part: &[[f32; 3]]) -> Option<String> {
        if let Some(v) = part.iter().find(|v| v.iter().any(|c| !c.is_finite())) {
            return Some(format!("a vertex at {v:?}"));
        }
        let least = if self == Self::Lines { 2 } else { 4 };
        if part.len() < least {
            return Some(format!("a part of {} vertices, {least} are the least", part.len()));
        }
        (self == Self::Polygons && part.first() != part.last()).then(|| "a ring that is not closed".to_owned())
    }
}

impl Form {
    /// Why these parts are no feature.
    fn problem_of<'p>(self, mut parts: impl Iterator<Item = &'p [[f32; 3]]> + Clone) -> Option<String> {
        let Some(first) = parts.clone().next() else { return Some("a feature without parts".into()) };
        let hole = self == Self::Polygons && signed_double_area(first) < 0.0;
        parts
            .find_map(|part| self.problem(part))
            .or_else(|| hole.then(|| "a hole comes before the ring around it".into()))
    }
}

/// Lines or polygons with attributes. Each feature has one part or more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    form: Form,
    vertices: Vec<[f32; 3]>,
    /// For each part the number of vertices up to its end.
    part_ends: Vec<u32>,
    /// For each feature the number of parts up to its end.
    feature_ends: Vec<u32>,
    attributes: Attributes,
}

pub(super) static KIND: ComponentKind = ComponentKind {
    name: "features",
    version: 1,
    formerly: &[],
    decode: |_, from| Ok(Arc::new(Features::decode(from)?)),
};

/// Twice the area that a ring encloses, m2: positive if it runs counter-clockwise seen from above with north up.
pub fn signed_double_area(ring: &[[f32; 3]]) -> f64 {
    let Some(origin) = ring.first() else { return 0.0 };
    // From the first vertex on, so that far from the corner of the grid nothing is lost; y runs south.
    let local = |v: &[f32; 3]| [f64::from(v[0]) - f64::from(origin[0]), f64::from(origin[1]) - f64::from(v[1])];
    ring.windows(2)
        .map(|pair| {
            let ([ax, ay], [bx, by]) = (local(&pair[0]), local(&pair[1]));
            ax * by - bx * ay
        })
        .sum()
}

impl Features {
    /// No features yet, with attributes by name, unit and type.
    pub fn new<'a>(form: Form, attributes: impl IntoIterator<Item = (&'a str, &'a str, Type)>) -> Self {
        Self { form, attributes: Attributes::new(attributes), ..Self::default() }
    }

    /// Adds a feature of these parts, whole or not at all. Vertices are m east of the grid's west side, m south of its north side, m
    /// above the datum of the height.
    ///
    /// # Errors
    /// If a part is not what [`Form`] says, the first ring of a feature is a hole, or `row` does not fit the attributes.
    pub fn push(&mut self, parts: &[&[[f32; 3]]], row: &[f64]) -> Result<()> {
        if let Some(reason) = self.form.problem_of(parts.iter().copied()) {
            return Err(Error::Component { name: "features".into(), reason });
        }
        let vertices = self.vertices.len() + parts.iter().map(|p| p.len()).sum::<usize>();
        if u32::try_from(vertices).is_err() {
            return Err(Error::Limit {
                what: "lines and polygons".into(),
                needed: format!("{vertices} vertices"),
                limit: format!("{} vertices", u32::MAX),
                remedy: "choose a smaller grid".into(),
            });
        }
        self.attributes.push(row)?;
        for part in parts {
            self.vertices.extend_from_slice(part);
            self.part_ends.push(self.vertices.len() as u32);
        }
        self.feature_ends.push(self.part_ends.len() as u32);
        Ok(())
    }

    /// What the parts are.
    pub const fn form(&self) -> Form {
        self.form
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.feature_ends.len()
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.feature_ends.is_empty()
    }

    /// The vertices of all features, in their order.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// The parts of feature `i`.
    pub fn parts(&self, i: usize) -> impl Iterator<Item = &[[f32; 3]]> + Clone + '_ {
        let first = if i == 0 { 0 } else { self.feature_ends[i - 1] as usize };
        (first..self.feature_ends[i] as usize).map(|part| {
            let begin = if part == 0 { 0 } else { self.part_ends[part - 1] as usize };
            &self.vertices[begin..self.part_ends[part] as usize]
        })
    }

    /// The polygons of feature `i`: of each the ring around it and its holes. Lines have none.
    pub fn polygons(&self, i: usize) -> Vec<Vec<&[[f32; 3]]>> {
        let mut polygons: Vec<Vec<&[[f32; 3]]>> = Vec::new();
        for ring in self.parts(i).filter(|_| self.form == Form::Polygons) {
            match polygons.last_mut() {
                Some(polygon) if signed_double_area(ring) < 0.0 => polygon.push(ring),
                _ => polygons.push(vec![ring]),
            }
        }
        polygons
    }

    /// What else is known of them.
    pub const fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    fn decode(from: &mut Decoder<'_>) -> Result<Self> {
        let form = from.u8()?;
        let Some(form) = Form::ALL.get(usize::from(form)).copied() else {
            return Err(from.wrong(format!("features of the form {form}")));
        };
        let n = from.count(12)?;
        let vertices: Vec<[f32; 3]> = from.f32s(3 * n)?.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        let part_ends = ends(from, n)?;
        let feature_ends = ends(from, part_ends.len())?;
        let attributes = Attributes::decode(feature_ends.len(), from)?;
        let features = Self { form, vertices, part_ends, feature_ends, attributes };
        for i in 0..features.len() {
            if let Some(problem) = form.problem_of(features.parts(i)) {
                return Err(from.wrong(problem));
            }
        }
        Ok(features)
    }
}

/// Numbers that rise to `last`.
fn ends(from: &mut Decoder<'_>, last: usize) -> Result<Vec<u32>> {
    let n = from.count(4)?;
    let ends = from.u32s(n)?;
    let rises = ends.first().is_none_or(|first| *first > 0) && ends.is_sorted_by(|a, b| a < b);
    if !rises || ends.last().map_or(0, |end| *end as usize) != last {
        return Err(from.wrong("features whose parts do not follow each other"));
    }
    Ok(ends)
}

impl Component for Features {
    fn kind(&self) -> &'static ComponentKind {
        &KIND
    }

    fn encode(&self, out: &mut Encoder<'_>) {
        out.u8(Form::ALL.iter().position(|f| *f == self.form).unwrap_or_default() as u8);
        out.count(self.vertices.len());
        out.f32s(self.vertices.as_flattened());
        for ends in [&self.part_ends, &self.feature_ends] {
            out.count(ends.len());
            out.u32s(ends);
        }
        self.attributes.encode(out);
    }

    fn fingerprint(&self, print: &mut Fingerprint) {
        print.word(self.form as u64);
        print.word(self.vertices.len() as u64);
        print.values(self.vertices.as_flattened());
        self.part_ends.iter().chain(&self.feature_ends).for_each(|end| print.word(u64::from(*end)));
        self.attributes.fingerprint(print);
    }

    fn bytes(&self) -> usize {
        let ends = size_of_val(&*self.part_ends) + size_of_val(&*self.feature_ends);
        size_of_val(&*self.vertices) + ends + self.attributes.bytes()
    }

    fn views(&self) -> &'static [(&'static str, Shape)] {
        &[("", Shape::Features)]
    }

    fn view(&self, name: &str) -> Option<View<'_>> {
        name.is_empty().then_some(View::Features(Cow::Borrowed(self)))
    }
}
