//! What a client knows: the state put together from records.

use crate::record::{Alga, Body, Changed, Colony, Ending, Hello, Moment, Record, Status, Why};
use crate::scene::{Raster, Scene};
use std::collections::BTreeMap;

/// Most cells of all layers together that a mirror keeps unless it is told otherwise: 256 MiB.
const MAX_CELLS: u64 = 1 << 26;

/// The state of a run as records have told it. Refuses what no server would send.
#[derive(Clone, Debug)]
pub struct Mirror {
    /// Cells of layers that may still be allocated.
    cells_left: u64,
    hello: Option<Hello>,
    moment: Option<Moment>,
    colonies: BTreeMap<u64, Colony>,
    algae: BTreeMap<u64, Alga>,
    layers: Vec<Option<Raster>>,
    /// Records of the moment under way that are still to come.
    more: u32,
    status: Status,
    end: Option<(Ending, String)>,
    snapshots: u64,
    refused: Option<String>,
    changed: Option<Changed>,
}

impl Default for Mirror {
    fn default() -> Self {
        Self::within(MAX_CELLS)
    }
}

impl Mirror {
    /// A mirror that knows nothing yet and keeps at most so many cells of layers.
    pub fn within(most_cells: u64) -> Self {
        Self {
            cells_left: most_cells,
            hello: None,
            moment: None,
            colonies: BTreeMap::new(),
            algae: BTreeMap::new(),
            layers: Vec::new(),
            more: 0,
            status: Status::default(),
            end: None,
            snapshots: 0,
            refused: None,
            changed: None,
        }
    }

    /// Takes a record. True if it completes a moment, so that the state may be looked at.
    ///
    /// # Errors
    /// If the record does not fit what came before.
    pub fn take(&mut self, record: Record) -> Result<bool, String> {
        let head = matches!(record.body, Body::Snapshot(_) | Body::Step(_));
        let part = matches!(record.body, Body::Colonies { .. } | Body::Algae { .. } | Body::Gone(_) | Body::Tile(_));
        if (head || !part) != (self.more == 0) {
            return Err(format!("{} records of a moment are missing", self.more));
        }
        if part && self.more != record.more + 1 {
            return Err(format!("{} records should follow, not {}", self.more - 1, record.more));
        }
        self.more = record.more;
        match record.body {
            Body::Hello(hello) if self.hello.is_none() => {
                self.layers = vec![None; hello.layers.len()];
                self.hello = Some(hello);
                return Ok(false);
            }
            _ if self.hello.is_none() => return Err("the first record is no hello".to_owned()),
            Body::Hello(_) => return Err("a second hello".to_owned()),
            Body::Snapshot(moment) => {
                self.colonies.clear();
                self.algae.clear();
                let cells = |r: &Raster| r.values.len() as u64;
                self.cells_left += self.layers.iter().flatten().map(cells).sum::<u64>();
                self.layers.fill(None);
                self.snapshots += 1;
                self.moment = Some(moment);
            }
            Body::Step(moment) => match &self.moment {
                None => return Err("a change before the first state".to_owned()),
                Some(before) if before.number + 1 != moment.number => {
                    return Err(format!("moment {} after {}", moment.number, before.number));
                }
                Some(_) => self.moment = Some(moment),
            },
            Body::Colonies { why, rows, .. } => {
                let species = self.hello.as_ref().map_or(0, |h| h.species.len());
                for c in rows {
                    if usize::from(c.species) >= species {
                        return Err(format!("colony {} is of species {}, which there is not", c.id, c.species));
                    }
                    put(&mut self.colonies, c.id, c, why)?;
                }
            }
            Body::Algae { why, rows } => {
                for a in rows {
                    put(&mut self.algae, a.id, a, why)?;
                }
            }
            Body::Gone(ids) => {
                for id in ids {
                    if self.colonies.remove(&id).is_none() && self.algae.remove(&id).is_none() {
                        return Err(format!("{id} is gone, but never was there"));
                    }
                }
            }
            Body::Tile(tile) => {
                let [w, h] = self.hello.as_ref().map_or([0; 2], |h| h.size);
                let fits = |at: u32, size: u32, all: u32| at.checked_add(size).is_some_and(|end| end <= all);
                let Some(raster) = self.layers.get_mut(usize::from(tile.layer)) else {
                    return Err(format!("layer {}, which there is not", tile.layer));
                };
                if !fits(tile.at[0], tile.size[0], w) || !fits(tile.at[1], tile.size[1], h) {
                    return Err(format!("a tile of {:?} at {:?} in {w} x {h} cells", tile.size, tile.at));
                }
                let raster = match raster {
                    Some(raster) => raster,
                    None => {
                        let cells = u64::from(w) * u64::from(h);
                        self.cells_left = self
                            .cells_left
                            .checked_sub(cells)
                            .ok_or_else(|| format!("layers of {w} x {h} cells; this client keeps fewer"))?;
                        raster.insert(Raster { width: w, values: vec![0.0; cells as usize] })
                    }
                };
                let (width, columns) = (w as usize, tile.size[0] as usize);
                for (y, row) in tile.values.chunks_exact(columns.max(1)).enumerate() {
                    let begin = (tile.at[1] as usize + y) * width + tile.at[0] as usize;
                    raster.values[begin..begin + columns].copy_from_slice(row);
                }
            }
            Body::Status(status) => {
                self.status = status;
                return Ok(false);
            }
            Body::End { how, message } => {
                self.end = Some((how, message));
                return Ok(false);
            }
            Body::Refused(message) => {
                self.refused = Some(message);
                return Ok(false);
            }
            Body::Changed(changed) => {
                self.changed = Some(changed);
                return Ok(false);
            }
            Body::Order(_) => return Err("an order from a server".to_owned()),
        }
        if self.more > 0 {
            return Ok(false);
        }
        let living = [self.colonies.len() as u32, self.algae.len() as u32];
        match &self.moment {
            Some(m) if m.living != living => Err(format!("{living:?} live, there should be {:?}", m.living)),
            _ => Ok(true),
        }
    }

    /// What the stream is about, once it is known.
    pub fn hello(&self) -> Option<&Hello> {
        self.hello.as_ref()
    }

    /// Where the run is, once a state is known.
    pub fn moment(&self) -> Option<&Moment> {
        self.moment.as_ref()
    }

    /// The whole state, once one is known.
    pub fn scene(&self) -> Option<Scene> {
        Some(Scene {
            moment: self.moment.clone()?,
            colonies: self.colonies.values().copied().collect(),
            algae: self.algae.values().copied().collect(),
            layers: self.layers.clone(),
        })
    }

    /// Whether the run works.
    pub fn status(&self) -> Status {
        self.status
    }

    /// How the run ended, if it has.
    pub fn end(&self) -> Option<&(Ending, String)> {
        self.end.as_ref()
    }

    /// Whole states that came: more than one if this client was too slow for all changes.
    pub fn snapshots(&self) -> u64 {
        self.snapshots
    }

    /// The last change by hand since this client is here.
    pub fn changed(&self) -> Option<&Changed> {
        self.changed.as_ref()
    }

    /// Why the last order was refused, if one was.
    pub fn refused(&self) -> Option<&str> {
        self.refused.as_deref()
    }
}

fn put<T>(all: &mut BTreeMap<u64, T>, id: u64, one: T, why: Why) -> Result<(), String> {
    let was_there = all.insert(id, one).is_some();
    if was_there == (why == Why::Changed) {
        Ok(())
    } else {
        Err(format!("{id} is {why:?}, but was there: {was_there}"))
    }
}
