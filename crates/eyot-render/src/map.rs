//! Maps of single layers, with a legend.

use crate::arrows;
use crate::colour_map::ColourMap;
use crate::ground::{Ground, quantile};
use crate::hillshade::{Hillshade, automatic_exaggeration, gradient};
use crate::legend::{self, Scale};
use crate::math::{V3, mix};
use crate::picture::{Picture, decode, encode, quantise};
use crate::resample::Raster;
use crate::view::finite;
use eyot_core::layer::{Class, LayerSpec, known};
use eyot_core::{Result, World};
use rayon::prelude::*;

/// How a layer is mapped.
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// Grids with a longer side above this are averaged down to it, pixels.
    pub max_size: usize,
    /// Grids with a longer side below this are drawn with several pixels a cell, pixels.
    pub min_size: usize,
    /// Pixels of the map's longer side, instead of the two bounds; cells are then as nearly of one size as pixels allow. The legend adds rows, and columns to maps narrower than it.
    pub size: Option<usize>,
    /// Colours. `None` chooses by the layer's name and values.
    pub colours: Option<ColourMap>,
    /// Values at the two ends of the legend. `None` leaves out the rarest few.
    pub range: Option<(f32, f32)>,
    /// Logarithmic scale. `None` takes it for layers with a heavy tail.
    pub log: Option<bool>,
    /// Strength of a hillshade of the layer `height` under the colours, 0 to 1.
    pub hillshade: f32,
    /// Draw a legend with name, unit and ticks below the map.
    pub legend: bool,
    /// Names and colours of the classes whose numbers the layer holds; then nothing of the above but sizes, hillshade and legend matters.
    pub classes: Option<Vec<Class>>,
    /// Arrows over the map, for the flow of these two layers, to the east and to the south.
    pub arrows: Option<[&'static str; 2]>,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            max_size: 2048,
            min_size: 512,
            size: None,
            colours: None,
            range: None,
            log: None,
            hillshade: 0.5,
            legend: true,
            classes: None,
            arrows: None,
        }
    }
}

impl MapOptions {
    /// How cells become pixels, before the map is brought to its size.
    pub(crate) fn raster(&self, width: usize, height: usize) -> Raster {
        match self.size {
            None => Raster::new(width, height, self.min_size, self.max_size),
            Some(n) => Raster::around(width, height, n),
        }
    }
}

/// Cells without a value.
const MISSING: V3 = [0.62, 0.62, 0.62];

/// A map of one layer, north up. See [`MapOptions`].
///
/// # Errors
/// If the world has no layer of that name.
pub fn layer_map(world: &World, layer_name: &str, o: &MapOptions) -> Result<Picture> {
    let layer = world.layer(layer_name)?;
    if let Some(classes) = &o.classes {
        return class_map(world, layer_name, classes, o);
    }
    let values = layer.field.to_vec();
    let raster = o.raster(layer.field.width(), layer.field.height());
    let shown = raster.cells(&values);
    let (colours, scale) = choose(world, &layer.spec, &values, o);
    let shade = underlay(world, layer_name, &raster, finite(o.hillshade, 0.0).clamp(0.0, 1.0));
    let (w, h) = (raster.width, raster.height);
    let mut pixels = vec![[0u8; 3]; w * h];
    pixels.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let v = shown[y * w + x];
            let mut c = if v.is_finite() { colours.at(scale.place(v)) } else { MISSING };
            if let Some(s) = &shade {
                c = c.map(|e| encode((linear(e) * s[y * w + x]).min(1.0)));
            }
            *out = quantise(c, x, y);
        }
    });
    let mut map = Picture { width: w, height: h, pixels };
    if let Some(flow) = o.arrows {
        arrows::draw(&mut map, world, flow)?;
    }
    if let Some(n) = o.size {
        map = map.with_longer_side(n.clamp(1, 16384), false);
    }
    Ok(if o.legend { legend::below(&map, &layer.spec, colours, &scale) } else { map })
}

/// A map of classes. A pixel takes the class of the cell in its middle: there is nothing between two classes.
fn class_map(world: &World, layer_name: &str, classes: &[Class], o: &MapOptions) -> Result<Picture> {
    let layer = world.layer(layer_name)?;
    let (width, height) = (layer.field.width(), layer.field.height());
    let raster = o.raster(width, height);
    let shade = underlay(world, layer_name, &raster, finite(o.hillshade, 0.0).clamp(0.0, 1.0));
    let (w, h) = (raster.width, raster.height);
    let mut shares = vec![0usize; classes.len()];
    layer.field.iter().for_each(|v| shares[number(v, classes)] += 1);
    let mut pixels = vec![[0u8; 3]; w * h];
    pixels.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let cell = layer.field.get((2 * x + 1) * width / (2 * w), (2 * y + 1) * height / (2 * h));
            let lit = shade.as_ref().map_or(1.0, |s| s[y * w + x]);
            *out = classes[number(cell, classes)]
                .colour
                .map(|c| (255.0 * encode((decode(c) * lit).min(1.0))).round() as u8);
        }
    });
    let mut map = Picture { width: w, height: h, pixels };
    if let Some(n) = o.size {
        map = map.picked(n.clamp(1, 16384));
    }
    Ok(if o.legend { legend::of_classes(&map, &layer.spec, classes, &shares) } else { map })
}

/// The class that a value stands for; what stands for none counts as the first.
fn number(value: f32, classes: &[Class]) -> usize {
    let n = value.round();
    if n >= 0.0 && n < classes.len() as f32 { n as usize } else { 0 }
}

/// The colours of one layer's map, for a relief that wears them, and its legend.
pub struct LayerColours {
    /// Linear colours, cell by cell.
    pub colours: Vec<[f32; 3]>,
    spec: LayerSpec,
    map: ColourMap,
    scale: Scale,
    /// Instead of both: classes, with how many cells are of each.
    classes: Option<(Vec<Class>, Vec<usize>)>,
}

impl LayerColours {
    /// Colours of the layer as [`layer_map`] chooses them. Hillshade, sizes and `legend` of the options do not matter here.
    ///
    /// # Errors
    /// If the world has no layer of that name.
    pub fn new(world: &World, layer_name: &str, o: &MapOptions) -> Result<Self> {
        let layer = world.layer(layer_name)?;
        let values = layer.field.to_vec();
        let (map, scale) = choose(world, &layer.spec, &values, o);
        let classes = o.classes.clone().map(|c| (c, Vec::new()));
        let mut this = Self { colours: Vec::new(), spec: layer.spec.clone(), map, scale, classes };
        this.paint(&values);
        Ok(this)
    }

    /// Takes the values of a later state of the world; the scale stays.
    ///
    /// # Errors
    /// If the world has no such layer.
    pub fn follow(&mut self, world: &World) -> Result<()> {
        let values = world.layer(&self.spec.name)?.field.to_vec();
        self.paint(&values);
        Ok(())
    }

    fn paint(&mut self, values: &[f32]) {
        if let Some((classes, shares)) = &mut self.classes {
            *shares = vec![0; classes.len()];
            values.iter().for_each(|v| shares[number(*v, classes)] += 1);
            self.colours = values.iter().map(|v| classes[number(*v, classes)].colour.map(decode)).collect();
            return;
        }
        let one = |v: &f32| if v.is_finite() { self.map.at(self.scale.place(*v)) } else { MISSING };
        self.colours = values.par_iter().map(|v| one(v).map(linear)).collect();
    }

    /// The colours along the scale, at `count` places at the same distance, for those who look them up.
    pub fn table(&self, count: usize) -> ColourTable {
        let last = count.max(2) - 1;
        if let Some((classes, _)) = &self.classes {
            let to = classes.len() as f32 - 1.0;
            let class = |i: usize| classes[number(i as f32 / last as f32 * to, classes)].colour.map(decode);
            return ColourTable { colours: (0..=last).map(class).collect(), from: 0.0, middle: None, to, log: false };
        }
        let colours = (0..=last).map(|i| self.map.at(i as f32 / last as f32).map(linear)).collect();
        let (from, middle, to, log) = match self.scale {
            Scale::Linear { from, to } => (from, None, to, false),
            Scale::Middle { from, middle, to } => (from, Some(middle), to, false),
            Scale::Log { from, to } => (from, None, to, true),
        };
        ColourTable { colours, from, middle, to, log }
    }

    /// `picture` with the legend below it.
    pub fn with_legend(&self, picture: &Picture) -> Picture {
        if let Some((classes, shares)) = &self.classes {
            return legend::of_classes(picture, &self.spec, classes, shares);
        }
        legend::below(picture, &self.spec, self.map, &self.scale)
    }
}

/// What [`LayerColours::table`] gives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ColourTable {
    /// Linear colours, from the begin of the scale to its end.
    pub colours: Vec<[f32; 3]>,
    /// The value at the begin.
    pub from: f32,
    /// The value in the middle of the table; values on both sides of it are scaled on their own.
    pub middle: Option<f32>,
    /// The value at the end.
    pub to: f32,
    /// Places go by the logarithm.
    pub log: bool,
}

/// Encoded value to linear light.
fn linear(e: f32) -> f32 {
    let t = e.clamp(0.0, 1.0) * 255.0;
    let (lo, hi) = (decode(t as u8), decode((t as u8).saturating_add(1)));
    lo + (hi - lo) * t.fract()
}

/// Colours and scale for a layer.
fn choose(world: &World, spec: &LayerSpec, values: &[f32], o: &MapOptions) -> (ColourMap, Scale) {
    let step = (values.len() / 262_144).max(1) | 1;
    let mut sample: Vec<f32> = values.iter().copied().step_by(step).filter(|v| v.is_finite()).collect();
    if sample.is_empty() {
        sample.push(0.0);
    }
    let is_height = spec.name == known::HEIGHT.name;
    let (low, high) = (quantile(&sample, 0.0), quantile(&sample, 1.0));
    let colours = o.colours.unwrap_or_else(|| match &*spec.name {
        _ if is_height => ColourMap::Heights,
        "precipitation" => ColourMap::Blues,
        n if n.contains("water") || n.contains("rain") || n.contains("flow") || n.contains("wet") => ColourMap::Blues,
        n if n.starts_with("temperature") && low < 0.0 && high > 0.0 => ColourMap::Diverging,
        n if n.contains("temperature") || n.contains("light") || n.contains("uplift") => ColourMap::Magma,
        _ if low < 0.0 && high > 0.0 => ColourMap::Diverging,
        _ => ColourMap::Viridis,
    });
    let positive: Vec<f32> = sample.iter().copied().filter(|v| *v > 0.0).collect();
    let heavy =
        !positive.is_empty() && low >= 0.0 && high > 0.0 && quantile(&positive, 0.99) > 30.0 * quantile(&positive, 0.5);
    let log = o.log.unwrap_or(heavy && !colours.has_middle()) && high > 0.0 && !positive.is_empty();
    let (mut from, mut to) = match o.range {
        Some((a, b)) if a.is_finite() && b.is_finite() && a < b => (a, b),
        _ if is_height => (low, high),
        _ if log => (quantile(&positive, 0.02).max(high * 1e-6), high),
        _ => (quantile(&sample, 0.002), quantile(&sample, 0.998)),
    };
    if from >= to {
        (from, to) =
            if low < high { (low, high) } else { (low - 0.5 * low.abs().max(1.0), low + 0.5 * low.abs().max(1.0)) };
    }
    let middle = colours.has_middle().then(|| {
        let sea = world.sea_level_m as f32;
        // Without a sea the whole of the land tints serves the land.
        if is_height { if sea.is_finite() { sea.clamp(from, to) } else { from } } else { 0.0f32.clamp(from, to) }
    });
    (colours, if log { Scale::log(from, to) } else { Scale::linear(from, to, middle, is_height) })
}

/// Brightness under the colours, from the layer `height` if there is one.
fn underlay(world: &World, layer_name: &str, raster: &Raster, strength: f32) -> Option<Vec<f32>> {
    if strength <= 0.0 || world.get(&known::HEIGHT.name).is_none() {
        return None;
    }
    let ground = Ground::new(world).ok()?;
    let z = raster.map(&ground.z);
    let (w, h) = (raster.width, raster.height);
    let cell = raster.pixel_m(&ground);
    let shade = Hillshade::new(315.0, 42.0, automatic_exaggeration(&ground));
    let strength = if layer_name == known::HEIGHT.name { strength } else { 0.75 * strength };
    let mut out = vec![1.0; w * h];
    out.par_chunks_mut(w).enumerate().for_each(|(y, row)| {
        for (x, o) in row.iter_mut().enumerate() {
            let s = shade.at(gradient(&z, w, h, cell, x, y)) / shade.level();
            *o = mix([1.0; 3], [s; 3], strength)[0];
        }
    });
    Some(out)
}
