//! Vector files: points, lines and polygons with attributes for geographic programs, as GeoJSON, FlatGeobuf or GeoPackage.

#[cfg(feature = "vector")]
mod flatgeobuf;
mod geojson;
#[cfg(feature = "vector")]
mod geometry;
#[cfg(feature = "vector")]
mod geopackage;

#[cfg(feature = "vector")]
pub use flatgeobuf::write_flatgeobuf;
pub use geojson::write_geojson;
#[cfg(feature = "vector")]
pub use geopackage::write_geopackage;

#[cfg(feature = "vector")]
use eyot_core::CoordinateSystem;
use eyot_core::component::{Attributes, Features, Form, View};
use eyot_core::{Georeference, Grid};
use std::borrow::Cow;

/// Points, lines or polygons of a world, on their way into a file.
///
/// Coordinates are those of the world's georeference; without one, metres with the south-west corner of the grid at (0, 0), as in its
/// GeoTIFFs. Heights are metres.
pub struct Vectors<'a> {
    /// What the layer is called in the file.
    pub name: &'a str,
    shapes: Shapes<'a>,
    attributes: &'a Attributes,
    /// From (m east, m south) of the north-west corner to coordinates, in GDAL's order.
    transform: [f64; 6],
    georeference: Option<&'a Georeference>,
    kind: Kind,
}

/// What has coordinates.
enum Shapes<'a> {
    Points(&'a [[f32; 3]]),
    Edges(&'a [[f32; 3]], &'a [[u32; 2]]),
    Features(&'a Features),
}

impl Shapes<'_> {
    /// What all of them are: the simplest kind that holds every one.
    fn kind(&self) -> Kind {
        match self {
            Self::Points(_) => Kind::Point,
            Self::Edges(..) => Kind::Line,
            Self::Features(f) => {
                let many = match f.form() {
                    Form::Polygons => (0..f.len()).any(|i| f.polygons(i).len() > 1),
                    _ => (0..f.len()).any(|i| f.parts(i).count() > 1),
                };
                match (f.form(), many) {
                    (Form::Polygons, false) => Kind::Polygon,
                    (Form::Polygons, true) => Kind::MultiPolygon,
                    (_, false) => Kind::Line,
                    (_, true) => Kind::MultiLine,
                }
            }
        }
    }
}

/// What the features of a layer are, all of them alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Point,
    Line,
    MultiLine,
    Polygon,
    MultiPolygon,
}

/// One feature: of each polygon its rings, of lines each line as a polygon of one ring, of a point one vertex.
pub(crate) type Parts<'a> = Vec<Vec<Cow<'a, [[f32; 3]]>>>;

impl<'a> Vectors<'a> {
    /// What a component shows on the grid of its world; `None` for tables, which lie nowhere.
    pub fn of(name: &'a str, view: &'a View<'a>, grid: &Grid, georeference: Option<&'a Georeference>) -> Option<Self> {
        let (shapes, attributes) = match view {
            View::Points(points) => (Shapes::Points(points.positions()), points.attributes()),
            View::Lines(graph) => (Shapes::Edges(graph.nodes().positions(), graph.edges()), graph.edge_attributes()),
            View::Features(features) => (Shapes::Features(features), features.attributes()),
            _ => return None,
        };
        let (cx, cy) = (grid.cell_x_m, grid.cell_y_m);
        let transform = match georeference.map(|g| g.transform) {
            Some(t) => [t[0], t[1] / cx, t[2] / cy, t[3], t[4] / cx, t[5] / cy],
            None => [0.0, 1.0, 0.0, grid.height as f64 * cy, 0.0, -1.0],
        };
        let kind = shapes.kind();
        Some(Self { name, shapes, attributes, transform, georeference, kind })
    }

    /// How many features there are.
    pub fn len(&self) -> usize {
        match self.shapes {
            Shapes::Points(p) => p.len(),
            Shapes::Edges(_, e) => e.len(),
            Shapes::Features(f) => f.len(),
        }
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What all of them are.
    pub(crate) const fn kind(&self) -> Kind {
        self.kind
    }

    pub(crate) fn parts(&self, i: usize) -> Parts<'a> {
        match self.shapes {
            Shapes::Points(p) => vec![vec![Cow::Borrowed(&p[i..=i])]],
            Shapes::Edges(nodes, edges) => {
                vec![vec![Cow::Owned(edges[i].map(|n| nodes[n as usize]).to_vec())]]
            }
            Shapes::Features(f) if f.form() == Form::Polygons => {
                f.polygons(i).into_iter().map(|rings| rings.into_iter().map(Cow::Borrowed).collect()).collect()
            }
            Shapes::Features(f) => f.parts(i).map(|line| vec![Cow::Borrowed(line)]).collect(),
        }
    }

    /// Coordinates of a vertex: x to the east, y to the north, height.
    pub(crate) fn coordinates(&self, [x, y, z]: [f32; 3]) -> [f64; 3] {
        let (t, x, y) = (self.transform, f64::from(x), f64::from(y));
        [t[0] + x * t[1] + y * t[2], t[3] + x * t[4] + y * t[5], f64::from(z)]
    }

    pub(crate) const fn attributes(&self) -> &'a Attributes {
        self.attributes
    }

    /// EPSG code of the coordinates.
    pub(crate) fn epsg(&self) -> Option<u32> {
        self.georeference.and_then(|g| g.epsg)
    }

    /// Well-known text of the coordinate system, if that is how it is known.
    #[cfg(feature = "vector")]
    pub(crate) fn wkt(&self) -> Option<&'a str> {
        match self.georeference?.system.as_ref()? {
            CoordinateSystem::Text(text) if text.contains('[') => Some(text),
            _ => None,
        }
    }

    /// True if coordinates are degrees.
    pub(crate) fn is_geographic(&self) -> bool {
        self.georeference.is_some_and(|g| g.geographic)
    }
}
