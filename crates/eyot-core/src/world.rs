//! The world: grid, layers, clock and seed.

use crate::component::Components;
use crate::domain::Domain;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::fingerprint::Fingerprint;
use crate::grid::{BoundaryCondition, Grid};
use crate::layer::{Centering, Layer, LayerSpec, known};
use crate::ledger::Ledger;
use crate::limits::MAX_STEP;
use serde::{Deserialize, Serialize};

/// Checks the clock of a world. What engines come to, what checkpoints are written with and what readers accept meets these bounds
/// and no others, so that whatever is written can be read.
///
/// # Errors
/// [`Error::Clock`] beyond [`MAX_STEP`], or if the sea is not within the range of heights.
pub fn check_clock(step: u64, sea_level_m: f64) -> Result<()> {
    let (low, high) = known::HEIGHT.range;
    let sound = step <= MAX_STEP && (f64::from(low)..=f64::from(high)).contains(&sea_level_m);
    if sound { Ok(()) } else { Err(Error::Clock { step, sea_level_m }) }
}

/// Where on Earth (or elsewhere) a grid lies; kept from an imported file to the exported one.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Georeference {
    /// Affine map from (column, row) of a cell's north-west corner to the file's own coordinates, in GDAL's order:
    /// `x = t[0] + col t[1] + row t[2]`, `y = t[3] + col t[4] + row t[5]`.
    pub transform: [f64; 6],
    /// EPSG code of the coordinate system, if known.
    pub epsg: Option<u32>,
    /// True if the coordinates are longitude and latitude in degrees.
    pub geographic: bool,
    /// Value that marks missing cells in the source file.
    pub nodata: Option<f64>,
    /// What the code does not say of the coordinate system, in the words of the source file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<CoordinateSystem>,
}

impl Georeference {
    /// Of the same extent in other cells: columns and rows before, and now.
    #[must_use]
    pub fn rescaled(&self, from: (usize, usize), to: (usize, usize)) -> Self {
        let (sx, sy) = (from.0 as f64 / to.0 as f64, from.1 as f64 / to.1 as f64);
        let t = self.transform;
        Self { transform: [t[0], t[1] * sx, t[2] * sy, t[3], t[4] * sx, t[5] * sy], ..self.clone() }
    }
}

/// A coordinate system that no EPSG code says, or not all of it, as a file had it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CoordinateSystem {
    /// The keys of a GeoTIFF (OGC 19-008r4).
    GeoKeys {
        /// Numbers of the key directory, four a key after a head of four.
        directory: Vec<u16>,
        /// Numbers that keys refer to.
        doubles: Vec<f64>,
        /// Texts that keys refer to.
        ascii: String,
    },
    /// Well-known text, or the name and code of another authority than EPSG.
    Text(String),
}

/// Everything that a run changes.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// Size of cells and rim. Of a window of a larger grid: of the cells that are held ([`Domain::held`]).
    pub grid: Grid,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Level of the sea, m, in the same datum as the height.
    pub sea_level_m: f64,
    /// Steps of simulation done so far; keys the random numbers.
    pub step: u64,
    /// Where the grid lies, if it came from a georeferenced file.
    pub georeference: Option<Georeference>,
    /// What entered, left, moved and was clamped.
    pub ledger: Ledger,
    /// What processes keep that is no layer, such as colonies or plates, by name. Checkpoints hold them and [`World::fingerprint`]
    /// covers them, so that a run goes on from exactly here.
    pub components: Components,
    /// If the grid is a part of a larger one: which.
    window: Option<Domain>,
    layers: Vec<Layer>,
}

impl World {
    /// A world without layers.
    pub fn new(grid: Grid, seed: u64) -> Self {
        Self {
            grid,
            seed,
            sea_level_m: 0.0,
            step: 0,
            georeference: None,
            ledger: Ledger::default(),
            components: Components::default(),
            window: None,
            layers: Vec::new(),
        }
    }

    /// A world without layers that is a part of a larger one. Files hold whole worlds only.
    pub fn of_window(domain: Domain, seed: u64) -> Self {
        let window = (!domain.is_whole()).then_some(domain);
        Self { window, ..Self::new(domain.held(), seed) }
    }

    /// Which part of which grid this is.
    pub fn domain(&self) -> Domain {
        self.window.unwrap_or_else(|| Domain::whole(self.grid))
    }

    /// True if this is a part of a larger world.
    pub const fn is_window(&self) -> bool {
        self.window.is_some()
    }

    /// The part of this whole world that a domain says, halo included: layers, clock and seed. Its ledger and its components are
    /// empty.
    ///
    /// # Errors
    /// If the domain is one of another grid, or this is a window itself.
    pub fn cut(&self, domain: Domain) -> Result<Self> {
        self.is_whole_of(&domain)?;
        let mut part = Self::of_window(domain, self.seed);
        (part.step, part.sea_level_m) = (self.step, self.sea_level_m);
        let columns: Vec<usize> = (0..part.grid.width as isize).map(|x| domain.column(x) as usize).collect();
        for layer in &self.layers {
            let field = &mut part.ensure(&layer.spec, 0.0).field;
            for y in 0..field.height() {
                let row = layer.field.row(domain.row(y as isize) as usize);
                field.row_mut(y).iter_mut().zip(&columns).for_each(|(v, &x)| *v = row[x]);
            }
            let faces = layer.field.outer_faces();
            let (west, north) = faces.split_at(self.grid.height);
            let rows = (0..field.height() as isize).map(|y| west[domain.row(y) as usize]);
            let faces: Vec<f32> = rows.chain(columns.iter().map(|&x| north[x])).collect();
            field.set_outer_faces(&faces)?;
        }
        Ok(part)
    }

    /// Takes the values inside a window's rows and columns, where both have a layer. Clock, ledger and components stay.
    ///
    /// # Errors
    /// As [`World::cut`].
    pub fn paste(&mut self, part: &Self) -> Result<()> {
        let domain = part.domain();
        self.is_whole_of(&domain)?;
        let (width, height) = (self.grid.width, self.grid.height);
        let ring = self.grid.rim.x == BoundaryCondition::Wrap;
        for layer in &part.layers {
            let Ok(own) = self.layer_mut(&layer.spec.name) else { continue };
            let (mut faces, theirs) = (own.field.outer_faces(), layer.field.outer_faces());
            for (y, held) in domain.rows().zip(domain.inside_rows()) {
                own.field.row_mut(y)[domain.columns()].copy_from_slice(&layer.field.row(held)[domain.inside_columns()]);
                // The face before the first column of a ring is that after the last one.
                if ring && domain.columns().end == width {
                    faces[y] = layer.field.get(domain.inside_columns().end - 1, held);
                } else if !ring && domain.columns().start == 0 {
                    faces[y] = theirs[held];
                }
            }
            if domain.rows().start == 0 {
                let north = part.grid.height + domain.inside_columns().start;
                let columns = domain.columns();
                let (from, count) = (height + columns.start, columns.len());
                faces[from..from + count].copy_from_slice(&theirs[north..north + count]);
            }
            own.field.set_outer_faces(&faces)?;
        }
        Ok(())
    }

    fn is_whole_of(&self, domain: &Domain) -> Result<()> {
        if self.is_window() || *domain.global() != self.grid {
            let reason = "a window can only be cut out of the whole grid of which it is one";
            return Err(Error::BadGrid(reason.to_owned()));
        }
        Ok(())
    }

    /// All layers, in the order in which they were made.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    pub(crate) fn layers_mut(&mut self) -> &mut [Layer] {
        &mut self.layers
    }

    /// The layer `name`, if it exists.
    pub fn get(&self, name: &str) -> Option<&Field> {
        self.layers.iter().find(|l| l.spec.name == name).map(|l| &l.field)
    }

    /// The layer `name`.
    ///
    /// # Errors
    /// If there is none; the error lists those that exist.
    pub fn layer(&self, name: &str) -> Result<&Layer> {
        self.layers.iter().find(|l| l.spec.name == name).ok_or_else(|| self.missing(name))
    }

    /// The layer `name`, to change.
    ///
    /// # Errors
    /// As [`World::layer`].
    pub fn layer_mut(&mut self, name: &str) -> Result<&mut Layer> {
        match self.layers.iter().position(|l| l.spec.name == name) {
            Some(i) => Ok(&mut self.layers[i]),
            None => Err(self.missing(name)),
        }
    }

    /// The layer that `spec` names; made with `value` everywhere if it does not exist yet.
    pub fn ensure(&mut self, spec: &LayerSpec, value: f32) -> &mut Layer {
        let i = match self.layers.iter().position(|l| l.spec.name == spec.name) {
            Some(i) => i,
            None => {
                // Two buffers a layer while the engine runs: keep their cache offsets apart.
                let cache_offset = 2 * self.layers.len();
                let field = Field::with_cache_offset(self.grid.width, self.grid.height, value, cache_offset);
                self.layers.push(Layer { spec: spec.clone(), field });
                self.layers.len() - 1
            }
        };
        &mut self.layers[i]
    }

    /// Puts `field` in as the layer that `spec` names, replacing an older one.
    ///
    /// # Errors
    /// If the field's size is not the grid's.
    pub fn put(&mut self, spec: &LayerSpec, field: Field) -> Result<()> {
        if (field.width(), field.height()) != (self.grid.width, self.grid.height) {
            return Err(Error::Shape {
                what: format!("layer `{}` of {}x{}", spec.name, self.grid.width, self.grid.height),
                expected: self.grid.cells(),
                found: field.width() * field.height(),
            });
        }
        match self.layers.iter_mut().find(|l| l.spec.name == spec.name) {
            Some(l) => l.field = field,
            None => self.layers.push(Layer { spec: spec.clone(), field }),
        }
        Ok(())
    }

    /// Removes the layer `name` and returns it.
    pub fn remove(&mut self, name: &str) -> Option<Layer> {
        self.layers.iter().position(|l| l.spec.name == name).map(|i| self.layers.remove(i))
    }

    /// The first value of any layer that is not finite, as an error that names the place.
    ///
    /// # Errors
    /// If there is such a value.
    pub fn check_finite(&self, after: &str) -> Result<()> {
        for l in &self.layers {
            if let Some((x, y, value)) = l.field.find_not_finite() {
                return Err(Error::NotFinite { layer: l.spec.name.to_string(), value, x, y, after: after.to_owned() });
            }
        }
        Ok(())
    }

    /// A 64-bit fingerprint of grid, clock and every byte of every layer (FNV-1a over the bit patterns).
    pub fn fingerprint(&self) -> u64 {
        let mut print = Fingerprint::new(&self.grid, self.step, self.sea_level_m);
        for l in &self.layers {
            print.begin(&l.spec.name);
            l.field.rows().for_each(|r| print.values(r));
            if l.spec.centering != Centering::Cell {
                print.values(&l.field.outer_faces());
            }
        }
        for (name, component) in self.components.iter() {
            print.begin(name);
            component.fingerprint(&mut print);
        }
        print.value()
    }

    fn missing(&self, name: &str) -> Error {
        let present: Vec<&str> = self.layers.iter().map(|l| &*l.spec.name).collect();
        Error::NoLayer { name: name.to_owned(), present: present.join(", ") }
    }
}
