//! Groups: which passes run in one dispatch.
//!
//! A workgroup computes a tile of the grid. If pass B reads around itself what pass A writes, both can run in one dispatch if A
//! is computed on as many cells more on each side of the tile (its **halo**) and left in the workgroup's own memory for B. A
//! little is then computed twice, but nothing between the two goes through the card's memory, which is what most rules wait
//! for. A chain of passes is cut into groups greedily, as long as the tiles fit.
//!
//! A group never overwrites what another workgroup may still have to read: a layer that any stage reads beyond its own cell is
//! stored to the layer's other copy.

use eyot_core::plan::{Pass, RuleKind};
use eyot_core::{Boundary, BoundaryCondition, Centering, LayerSpec};

/// Columns and rows of a tile.
pub(crate) const TILE: [usize; 2] = [32, 16];
/// Invocations of a workgroup; each computes several cells.
pub(crate) const THREADS: usize = 256;
/// Largest halo and reach of a group together, which is also how many rows neighbouring slabs share.
pub(crate) const GHOST: usize = 8;
/// Most numbers that a dispatch gets: parameters, keys, slots.
pub(crate) const JOB_WORDS: usize = 256;
/// Bytes of the uniform block of a dispatch.
pub(crate) const JOB_BYTES: u64 = 4 * JOB_WORDS as u64;
/// Bytes of a workgroup's memory that every WebGPU device has.
pub(crate) const SHARED_BYTES: usize = 16384;
/// Words of every job before those of its stages.
pub(crate) const JOB_HEAD: usize = 10;

/// What a chain of passes may be cut into.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Numbers in a workgroup's memory.
    pub(crate) shared: usize,
    /// Passes of a group.
    pub(crate) passes: usize,
}

/// Where a stage reads a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    /// In the card's memory, as it was before the group.
    Card,
    /// In the workgroup's memory: the output `write` of an earlier stage.
    Tile { stage: usize, write: usize },
}

/// What a stage does with an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Target {
    /// The layer.
    pub(crate) layer: usize,
    /// A later stage reads it.
    pub(crate) tile: bool,
    /// It is the layer's value after the group.
    pub(crate) stored: bool,
}

/// One pass of a group.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Stage {
    pub(crate) rule: RuleKind,
    /// Layer and source of each read.
    pub(crate) reads: Vec<(usize, Source)>,
    pub(crate) writes: Vec<Target>,
    /// Cells beyond the tile on each side that it is computed on.
    pub(crate) halo: usize,
}

/// Passes that run in one dispatch.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Group {
    pub(crate) stages: Vec<Stage>,
    /// Layers read from the card's memory.
    pub(crate) inputs: Vec<usize>,
    /// Layers stored, and whether to their other copy.
    pub(crate) outputs: Vec<(usize, bool)>,
}

/// The layers of a simulation; those of the world come first, scratch layers after them.
pub(crate) struct Layers<'a> {
    pub(crate) specs: &'a [LayerSpec],
    pub(crate) world_layers: usize,
}

impl Layers<'_> {
    fn find(&self, name: &str) -> Option<usize> {
        self.specs.iter().position(|s| s.name == name)
    }
}

/// Cuts `passes` into groups. `None` if a pass names a layer that does not exist.
pub(crate) fn groups(passes: &[Pass], layers: &Layers<'_>, bounds: Bounds) -> Option<Vec<Group>> {
    let (mut groups, mut start) = (Vec::new(), 0);
    while start < passes.len() {
        let mut group = analyse(passes, start, start + 1, layers)?;
        let mut end = start + 1;
        while end < passes.len() && end - start < bounds.passes {
            let longer = analyse(passes, start, end + 1, layers)?;
            if longer.shared() > bounds.shared
                || longer.reach(passes, start) > GHOST
                || longer.words(passes, start) > JOB_WORDS
            {
                break;
            }
            (group, end) = (longer, end + 1);
        }
        groups.push(group);
        start = end;
    }
    Some(groups)
}

/// The passes `start..end` as one group.
fn analyse(passes: &[Pass], start: usize, end: usize, layers: &Layers<'_>) -> Option<Group> {
    let group = &passes[start..end];
    let mut writer: Vec<Option<(usize, usize)>> = vec![None; layers.specs.len()];
    let mut stages = Vec::new();
    for (i, pass) in group.iter().enumerate() {
        let mut reads = Vec::new();
        for r in pass.reads() {
            let layer = layers.find(r.layer)?;
            let source = writer[layer].map_or(Source::Card, |(stage, write)| Source::Tile { stage, write });
            reads.push((layer, source));
        }
        let mut writes = Vec::new();
        for (w, name) in pass.writes().iter().enumerate() {
            let layer = layers.find(name)?;
            writer[layer] = Some((i, w));
            writes.push(Target { layer, tile: false, stored: false });
        }
        stages.push(Stage { rule: pass.kind(), reads, writes, halo: 0 });
    }
    // From the last to the first: what later stages need of earlier ones.
    for i in (0..stages.len()).rev() {
        for (r, (_, source)) in stages[i].reads.clone().into_iter().enumerate() {
            if let Source::Tile { stage, write } = source {
                let needed = stages[i].halo + group[i].reads()[r].reach;
                stages[stage].halo = stages[stage].halo.max(needed);
                stages[stage].writes[write].tile = true;
            }
        }
    }
    let mut outputs = Vec::new();
    for (layer, last) in writer.iter().enumerate() {
        let Some((stage, write)) = *last else { continue };
        if is_needed(&passes[end..], &layers.specs[layer].name, layer < layers.world_layers) {
            stages[stage].writes[write].stored = true;
            let elsewhere = stages.iter().zip(group).any(|(s, pass)| {
                let mut reads = s.reads.iter().zip(pass.reads());
                reads.any(|(&(l, source), r)| l == layer && source == Source::Card && s.halo + r.reach > 0)
            });
            outputs.push((layer, elsewhere));
        }
    }
    let card = |&(l, source): &(usize, Source)| (source == Source::Card).then_some(l);
    let mut inputs: Vec<usize> = stages.iter().flat_map(|s| s.reads.iter().filter_map(card)).collect();
    inputs.sort_unstable();
    inputs.dedup();
    Some(Group { stages, inputs, outputs })
}

/// True if one of `later` reads the layer before it is overwritten, or nobody overwrites it and it is part of the world.
fn is_needed(later: &[Pass], name: &str, of_world: bool) -> bool {
    for pass in later {
        if pass.reads().iter().any(|r| r.layer == name) {
            return true;
        }
        if pass.writes().contains(&name) {
            return false;
        }
    }
    of_world
}

impl Group {
    /// Numbers in the workgroup's memory.
    pub(crate) fn shared(&self) -> usize {
        let area = |halo: usize| (TILE[0] + 2 * halo) * (TILE[1] + 2 * halo);
        self.stages.iter().map(|s| area(s.halo) * s.writes.iter().filter(|w| w.tile).count()).sum()
    }

    /// How far beyond the tile it reads the card's memory.
    fn reach(&self, passes: &[Pass], start: usize) -> usize {
        let far = self.stages.iter().zip(&passes[start..]).flat_map(|(s, pass)| {
            let card = s.reads.iter().zip(pass.reads()).filter(|((_, source), _)| *source == Source::Card);
            card.map(|(_, r)| s.halo + r.reach).chain([s.halo])
        });
        far.max().unwrap_or(0)
    }

    /// Words of its job.
    fn words(&self, passes: &[Pass], start: usize) -> usize {
        let stages = self.stages.iter().zip(&passes[start..]);
        JOB_HEAD
            + self.inputs.len()
            + self.outputs.len()
            + stages.map(|(_, p)| 2 + p.params().len() + p.tallies().len()).sum::<usize>()
    }

    /// 1 along the axes on which the group also computes faces beyond the first column or row.
    pub(crate) fn outer_faces(&self, specs: &[LayerSpec], rim: Boundary) -> [usize; 2] {
        let writes = |centering: Centering| {
            self.stages.iter().flat_map(|s| &s.writes).any(|w| specs[w.layer].centering == centering)
        };
        [
            usize::from(rim.x == BoundaryCondition::Open && writes(Centering::FaceX)),
            usize::from(rim.y == BoundaryCondition::Open && writes(Centering::FaceY)),
        ]
    }

    /// Bytes that a cell moves between the card's memory and the processors: each layer once.
    pub(crate) fn bytes_per_cell(&self) -> usize {
        4 * (self.inputs.len() + self.outputs.len())
    }
}
