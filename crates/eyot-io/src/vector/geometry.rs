//! One feature of [`Vectors`] for the writers of binary geometry.

use super::{Kind, Vectors};
use geozero::error::Result;
use geozero::{GeomProcessor, GeozeroGeometry};

/// Feature `i`.
pub(super) struct Feature<'a, 'v> {
    pub vectors: &'a Vectors<'v>,
    pub i: usize,
}

impl GeozeroGeometry for Feature<'_, '_> {
    fn process_geom<P: GeomProcessor>(&self, to: &mut P) -> Result<()> {
        let parts = self.vectors.parts(self.i);
        let vertices = |line: &[[f32; 3]], to: &mut P| {
            line.iter().enumerate().try_for_each(|(n, v)| {
                let [x, y, z] = self.vectors.coordinates(*v);
                to.coordinate(x, y, Some(z), None, None, None, n)
            })
        };
        let lines = |rings: &[std::borrow::Cow<'_, [[f32; 3]]>], tagged: bool, first: usize, to: &mut P| {
            rings.iter().enumerate().try_for_each(|(n, ring)| {
                to.linestring_begin(tagged, ring.len(), first + n)?;
                vertices(ring, to)?;
                to.linestring_end(tagged, first + n)
            })
        };
        match self.vectors.kind() {
            Kind::Point => {
                to.point_begin(0)?;
                parts.iter().flatten().try_for_each(|p| vertices(p, to))?;
                to.point_end(0)
            }
            Kind::Line => parts.iter().try_for_each(|rings| lines(rings, true, 0, to)),
            Kind::MultiLine => {
                to.multilinestring_begin(parts.len(), 0)?;
                parts.iter().enumerate().try_for_each(|(n, rings)| lines(rings, false, n, to))?;
                to.multilinestring_end(0)
            }
            Kind::Polygon => parts.iter().try_for_each(|rings| {
                to.polygon_begin(true, rings.len(), 0)?;
                lines(rings, false, 0, to)?;
                to.polygon_end(true, 0)
            }),
            Kind::MultiPolygon => {
                to.multipolygon_begin(parts.len(), 0)?;
                parts.iter().enumerate().try_for_each(|(n, rings)| {
                    to.polygon_begin(false, rings.len(), n)?;
                    lines(rings, false, 0, to)?;
                    to.polygon_end(false, n)
                })?;
                to.multipolygon_end(0)
            }
        }
    }
}
