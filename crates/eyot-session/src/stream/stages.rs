//! The steps of a recipe as stages, each of which holds a window of rows of the layer as that step leaves it.

use eyot_core::process::{Generator, Reach, Site};
use eyot_core::{Cancel, Control, Error, Field, Grid, LayerSpec, Result, World};
use eyot_recipe::{GenerateStep, Merge, Step, Work, layers};
use std::ops::Range;

/// Bytes of one layer's rows that are made at a time, about.
const BAND_BYTES: usize = 16 << 20;

/// Rows of a layer. On rims that wrap, numbers below 0 and from the grid's height on stand for the far side.
struct Window {
    rows: Range<isize>,
    field: Field,
}

impl Window {
    fn empty() -> Self {
        Self { rows: 0..0, field: Field::new(0, 0, 0.0) }
    }

    /// Row `y` of a grid of `height` rows.
    fn row(&self, y: isize, height: isize) -> &[f32] {
        let shift = if self.rows.contains(&y) { 0 } else { (y - self.rows.start).div_euclid(height) * height };
        self.field.row((y - shift - self.rows.start) as usize)
    }

    fn cut(&self, rows: Range<isize>, grid: &Grid) -> Field {
        let mut out = Field::new(grid.width, rows.len(), 0.0);
        for (to, y) in out.rows_mut().zip(rows) {
            to.copy_from_slice(self.row(y, grid.height as isize));
        }
        out
    }
}

/// One step and its layer after it.
struct Stage {
    label: String,
    layer: String,
    generator: Box<dyn Generator>,
    reach: Reach,
    seed: u64,
    merge: Merge,
    amount: f32,
    /// The stage that leaves the layer as this one finds it; none if the layer is new.
    base: Option<usize>,
    mask: Option<usize>,
    reads: Vec<(LayerSpec, usize)>,
    /// Largest value of the layer before this step, where the merge needs it.
    top: f32,
    window: Window,
}

/// All steps of a recipe.
pub(super) struct Stages {
    pub(super) grid: Grid,
    sea_level_m: f64,
    stages: Vec<Stage>,
    layers: Vec<(LayerSpec, usize)>,
    /// Rows that are made at a time.
    pub(super) band: usize,
    pub(super) cancel: Cancel,
}

impl Stages {
    /// The stages of the enabled steps, all of which must generate.
    pub(super) fn new(steps: &[Step], grid: Grid, sea_level_m: f64) -> Result<Self> {
        let mut this = Self {
            grid,
            sea_level_m,
            stages: Vec::new(),
            layers: Vec::new(),
            band: (BAND_BYTES / 4 / grid.width).clamp(1, grid.height),
            cancel: Cancel::default(),
        };
        for step in steps.iter().filter(|s| s.enabled) {
            if let Work::Generate(work) = &step.work {
                this.add(step, work, steps)?;
            }
        }
        Ok(this)
    }

    fn add(&mut self, step: &Step, work: &GenerateStep, steps: &[Step]) -> Result<()> {
        let generator = work.make()?;
        let find = |name: &str| {
            let found = self.layers.iter().find(|(spec, _)| spec.name == name);
            found.cloned().ok_or_else(|| Error::NoLayer { name: name.to_owned(), present: self.names() })
        };
        let mask = work.mask.as_deref().map(find).transpose()?.map(|(_, stage)| stage);
        let reads = generator.reads().into_iter().map(find).collect::<Result<Vec<_>>>()?;
        let base = find(&work.layer).ok().map(|(_, stage)| stage);
        let number = self.stages.len();
        match self.layers.iter_mut().find(|(spec, _)| spec.name == *work.layer) {
            Some((_, last)) => *last = number,
            None => self.layers.push((layers::spec(&work.layer, &step.name, steps), number)),
        }
        self.stages.push(Stage {
            label: format!("step {} ({})", step.number, step.name),
            layer: work.layer.clone(),
            reach: generator.reach(&self.grid),
            generator,
            seed: work.seed,
            merge: work.merge,
            amount: work.amount,
            base,
            mask,
            reads,
            top: 0.0,
            window: Window::empty(),
        });
        Ok(())
    }

    fn names(&self) -> String {
        self.layers.iter().map(|(spec, _)| &*spec.name).collect::<Vec<_>>().join(", ")
    }

    /// The layers in the order in which they come to be, each with its last stage.
    pub(super) fn layers(&self) -> &[(LayerSpec, usize)] {
        &self.layers
    }

    /// Stages that need the largest value of the layer before them, each with the stage that leaves it so.
    pub(super) fn below_tops(&self) -> Vec<(usize, usize)> {
        let merging = self.stages.iter().enumerate().filter(|(_, s)| s.merge.needs_top());
        merging.filter_map(|(k, s)| Some((k, s.base?))).collect()
    }

    pub(super) fn set_top(&mut self, stage: usize, top: f32) {
        self.stages[stage].top = top;
    }

    /// Rows of one layer's width that the windows hold together while rows are made.
    pub(super) fn rows_held(&self) -> usize {
        let middle = self.grid.height.saturating_sub(self.band) / 2;
        let band = middle..middle + self.band;
        let mut most = vec![0; self.stages.len()];
        for (_, target) in &self.layers {
            for (rows, need) in most.iter_mut().zip(self.needs(*target, &band)) {
                *rows = need.map_or(0, |n| n.len()).max(*rows);
            }
        }
        // The stage at work also holds its old window, base, mask and new values.
        most.iter().sum::<usize>() + 4 * most.iter().max().unwrap_or(&0)
    }

    /// Makes the rows from `first` on of the layer as `target` leaves it; at most [`Stages::band`] of them.
    pub(super) fn read(&mut self, target: usize, first: usize, out: &mut [f32]) -> Result<()> {
        let rows = first..first + out.len() / self.grid.width;
        for (stage, need) in self.needs(target, &rows).into_iter().enumerate() {
            if let Some(need) = need {
                self.extend(stage, need)?;
            }
        }
        let (window, height) = (&self.stages[target].window, self.grid.height as isize);
        for (to, y) in out.chunks_exact_mut(self.grid.width).zip(rows) {
            to.copy_from_slice(window.row(y as isize, height));
        }
        Ok(())
    }

    /// The rows that each stage up to `target` must have for some rows of the target.
    fn needs(&self, target: usize, rows: &Range<usize>) -> Vec<Option<Range<isize>>> {
        let mut needs: Vec<Option<Range<isize>>> = vec![None; target + 1];
        needs[target] = Some(rows.start as isize..rows.end as isize);
        for k in (0..=target).rev() {
            let Some(own) = needs[k].clone() else { continue };
            let stage = &self.stages[k];
            let around = stage.reach.around_any(&self.grid, &own);
            let looked_at = stage.base.into_iter().chain(stage.reads.iter().map(|r| r.1)).map(|from| (from, &around));
            for (from, rows) in looked_at.chain(stage.mask.map(|from| (from, &own))) {
                let hull = match &needs[from] {
                    Some(n) => n.start.min(rows.start)..n.end.max(rows.end),
                    None => rows.clone(),
                };
                // No row twice.
                needs[from] = Some(Reach::Cell.around_any(&self.grid, &hull));
            }
        }
        needs
    }

    /// Moves the window of a stage to `need`; rows that it has already are kept.
    fn extend(&mut self, k: usize, need: Range<isize>) -> Result<()> {
        let old = &self.stages[k].window.rows;
        if !old.is_empty() && old.start <= need.start && need.end <= old.end {
            return Ok(());
        }
        let kept = old.start.max(need.start)..old.end.min(need.end);
        let mut field = Field::new(self.grid.width, need.len(), 0.0);
        let missing = if kept.is_empty() {
            vec![need.clone()]
        } else {
            for y in kept.clone() {
                let row = self.stages[k].window.field.row((y - old.start) as usize);
                field.row_mut((y - need.start) as usize).copy_from_slice(row);
            }
            vec![need.start..kept.start, kept.end..need.end]
        };
        let height = self.grid.height as isize;
        for piece in missing {
            let mut at = piece.start;
            while at < piece.end {
                // Beyond a rim that wraps the numbers start again.
                let turn = at.div_euclid(height) * height;
                let end = piece.end.min(turn + height);
                let made = self.make(k, (at - turn) as usize..(end - turn) as usize)?;
                for (y, row) in (at..end).zip(made.rows()) {
                    field.row_mut((y - need.start) as usize).copy_from_slice(row);
                }
                at = end;
            }
        }
        self.stages[k].window = Window { rows: need, field };
        Ok(())
    }

    /// Some rows of a layer as a stage leaves it, from the windows of the stages before.
    fn make(&self, k: usize, rows: Range<usize>) -> Result<Field> {
        let (stage, grid) = (&self.stages[k], &self.grid);
        let own = rows.start as isize..rows.end as isize;
        let around = stage.reach.around(grid, &rows);
        let cut = |from: Option<usize>, rows: &Range<isize>| match from {
            Some(from) => self.stages[from].window.cut(rows.clone(), grid),
            None => Field::new(grid.width, rows.len(), 0.0),
        };
        let base = cut(stage.base, &around);
        let mut world = World::new(Grid { height: around.len(), ..*grid }, stage.seed);
        world.sea_level_m = self.sea_level_m;
        for (spec, from) in &stage.reads {
            world.put(spec, cut(Some(*from), &around))?;
        }
        let control = Control::new(self.cancel.clone(), &|_, _| {});
        let site = Site { grid: *grid, rows: rows.clone(), seed: stage.seed, world: &world, control: &control };
        let new = stage.generator.generate(&site, &base)?;
        if (new.width(), new.height()) != (grid.width, rows.len()) {
            return Err(Error::Shape {
                what: format!("the result of {}", stage.label),
                expected: grid.width * rows.len(),
                found: new.width() * new.height(),
            });
        }
        let mut merged = if around == own { base } else { cut(stage.base, &own) };
        let mask = stage.mask.map(|from| cut(Some(from), &own));
        stage.merge.apply_below(stage.top, &mut merged, &new, stage.amount, mask.as_ref());
        match merged.find_not_finite() {
            None => Ok(merged),
            Some((x, y, value)) => Err(Error::NotFinite {
                layer: stage.layer.clone(),
                value,
                x,
                y: rows.start + y,
                after: stage.label.clone(),
            }),
        }
    }
}
