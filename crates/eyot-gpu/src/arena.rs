//! The card's memory of one simulation: all layers, cut into slabs of rows where one buffer would be too large.
//!
//! A row of the buffer holds that row of every layer, one after the other, so that a slab is one piece however many layers
//! there are. Copies of a layer are **slots**. Slabs share [`GHOST`] rows with their neighbours, which are copied after each
//! dispatch; a grid in one slab needs none.

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::group::{GHOST, TILE};
use crate::layer_view::{LayerPart, LayerView};
use crate::reading::Reading;
use crate::shader::BASE;
use eyot_core::{BoundaryCondition, Field, Grid};
use std::pin::Pin;
use std::sync::atomic::Ordering;
use std::task::{Context, Poll};
use wgpu::BufferUsages;

/// Bytes that are moved to or from the card at once.
const PIECE: usize = 32 << 20;

/// Rows of the grid in one buffer.
pub(crate) struct Slab {
    pub(crate) first: usize,
    pub(crate) rows: usize,
    pub(crate) state: wgpu::Buffer,
    pub(crate) bind: wgpu::BindGroup,
    /// Number of its first tile among all tiles.
    pub(crate) first_group: usize,
}

/// See the module.
pub(crate) struct Arena {
    pub(crate) grid: Grid,
    pub(crate) slots: usize,
    pub(crate) stride: usize,
    pub(crate) slabs: Vec<Slab>,
    /// Sums for the ledger: for each account, for each tile, the sum and what rounding took from it.
    pub(crate) sums: wgpu::Buffer,
    pub(crate) accounts: usize,
    /// Tiles of all slabs.
    pub(crate) groups: usize,
}

/// Tiles that cover so many columns and rows; one more each way, since tiles may begin on the faces before the first.
fn tiles(columns: usize, rows: usize) -> usize {
    (columns + 1).div_ceil(TILE[0]) * (rows + 1).div_ceil(TILE[1])
}

/// Distance of two rows of a layer in numbers: column -1 has its place at the end of the row before.
fn stride(grid: &Grid) -> usize {
    (grid.width + 1).next_multiple_of(32)
}

impl Arena {
    /// Bytes of one slot of the whole grid.
    pub(crate) fn slot_bytes(grid: &Grid) -> u64 {
        4 * (stride(grid) * (grid.height + 1)) as u64
    }

    /// Makes the buffers. `most_bytes` bounds one of them, beside the device's own bound.
    ///
    /// # Errors
    /// If the device has not enough memory, or a single row exceeds its bounds.
    pub(crate) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        job: &wgpu::Buffer,
        grid: Grid,
        slots: usize,
        accounts: usize,
        most_bytes: u64,
    ) -> Result<Self> {
        let limits = gpu.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(most_bytes);
        let stride = stride(&grid);
        let row = 4 * (stride * slots) as u64;
        let fits = |rows: usize, ghosts: usize| 4 * BASE as u64 + row * (rows + ghosts) as u64 <= most;
        let count = if fits(grid.height, 1) {
            1
        } else {
            let mut count = 2;
            while count < grid.height / GHOST && !fits(grid.height.div_ceil(count), 2 * GHOST) {
                count += 1;
            }
            if grid.height / count < GHOST || !fits(grid.height.div_ceil(count), 2 * GHOST) {
                return Err(GpuError::Limits {
                    adapter: gpu.name().to_owned(),
                    what: format!("{slots} layers of {} columns", grid.width),
                    needed: format!("{} MiB for {GHOST} rows", (3 * GHOST as u64 * row) >> 20),
                    limit: format!("{} MiB in one piece", most >> 20),
                });
            }
            count
        };
        let cut = |i: usize| i * grid.height / count;
        let groups: usize = (0..count).map(|i| tiles(grid.width, cut(i + 1) - cut(i))).sum();
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let sums = gpu.buffer("sums for the ledger", 8 * (accounts.max(1) * groups) as u64, usage)?;
        let (mut slabs, mut first_group) = (Vec::new(), 0);
        for i in 0..count {
            let (first, rows) = (cut(i), cut(i + 1) - cut(i));
            let ghosts = if count > 1 { 2 * GHOST } else { 1 };
            let size = 4 * BASE as u64 + row * (rows + ghosts) as u64;
            let state = gpu.buffer("the layers", size, usage)?;
            let bind = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("slab"),
                layout,
                entries: &[
                    wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer: job,
                            offset: 0,
                            size: wgpu::BufferSize::new(crate::group::JOB_BYTES),
                        }),
                    },
                    wgpu::BindGroupEntry { binding: 1, resource: state.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 2, resource: sums.as_entire_binding() },
                ],
            });
            slabs.push(Slab { first, rows, state, bind, first_group });
            first_group += tiles(grid.width, rows);
        }
        Ok(Self { grid, slots, stride, slabs, sums, accounts, groups })
    }

    /// True if the grid is cut.
    pub(crate) fn split(&self) -> bool {
        self.slabs.len() > 1
    }

    /// Rows that a slab holds above its own.
    fn above(&self) -> usize {
        if self.split() { GHOST } else { 1 }
    }

    /// The row of the grid that is the first of a slab's buffer.
    pub(crate) fn first_row(&self, slab: &Slab) -> i32 {
        slab.first as i32 - self.above() as i32
    }

    /// Bytes from the begin of a slab's buffer to column -1 of a row of a slot.
    pub(crate) fn offset(&self, slab: &Slab, slot: usize, y: isize) -> u64 {
        let row = (y - self.first_row(slab) as isize) as usize;
        4 * (BASE + (row * self.slots + slot) * self.stride - 1) as u64
    }

    /// Copies the rows that slabs share from those whose own they are.
    pub(crate) fn share(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = self.slabs.len();
        let wraps = self.grid.rim.y == BoundaryCondition::Wrap;
        let row = 4 * (self.slots * self.stride) as u64;
        let bytes = row * GHOST as u64;
        for i in 0..if self.split() { count } else { 0 } {
            if i + 1 == count && !wraps {
                break;
            }
            let (upper, lower) = (&self.slabs[i], &self.slabs[(i + 1) % count]);
            // From column -1 on, which lies one number before the row.
            let (own, ghost) = (
                self.offset(lower, 0, lower.first as isize),
                self.offset(upper, 0, (upper.first + upper.rows) as isize),
            );
            encoder.copy_buffer_to_buffer(&lower.state, own, &upper.state, ghost, bytes);
            let last = (upper.first + upper.rows - GHOST) as isize;
            let (own, ghost) =
                (self.offset(upper, 0, last), self.offset(lower, 0, lower.first as isize - GHOST as isize));
            encoder.copy_buffer_to_buffer(&upper.state, own, &lower.state, ghost, bytes);
        }
    }

    /// Brings a layer to a slot.
    pub(crate) fn upload(&self, gpu: &Gpu, slot: usize, field: &Field) -> Result<()> {
        let (width, height) = (self.grid.width, self.grid.height);
        let faces = field.outer_faces();
        let (west, north) = faces.split_at(height);
        let row_bytes = 4 * (width + 1);
        for slab in &self.slabs {
            let first = if slab.first == 0 { -1 } else { slab.first as isize };
            let rows: Vec<isize> = (first..(slab.first + slab.rows) as isize).collect();
            for piece in rows.chunks((PIECE / row_bytes).max(1)) {
                let mut values: Vec<f32> = Vec::with_capacity(piece.len() * (width + 1));
                for &y in piece {
                    values.push(if y < 0 { 0.0 } else { west[y as usize] });
                    values.extend_from_slice(if y < 0 { north } else { field.row(y as usize) });
                }
                let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
                let staging = gpu.buffer("a layer on its way", (piece.len() * row_bytes) as u64, usage)?;
                gpu.queue.write_buffer(&staging, 0, bytemuck::cast_slice(&values));
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                for (i, &y) in piece.iter().enumerate() {
                    let to = self.offset(slab, slot, y);
                    encoder.copy_buffer_to_buffer(&staging, (i * row_bytes) as u64, &slab.state, to, row_bytes as u64);
                }
                gpu.queue.submit([encoder.finish()]);
            }
        }
        gpu.check()
    }

    /// Begins to bring a slot back.
    pub(crate) fn request(&self, gpu: &Gpu, slot: usize) -> Result<Pending> {
        let row_bytes = 4 * (self.grid.width + 1);
        let mut pieces = Vec::new();
        for slab in &self.slabs {
            let first = if slab.first == 0 { -1 } else { slab.first as isize };
            let rows: Vec<isize> = (first..(slab.first + slab.rows) as isize).collect();
            for piece in rows.chunks((PIECE / row_bytes).max(1)) {
                let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
                let staging = gpu.buffer("a layer on its way back", (piece.len() * row_bytes) as u64, usage)?;
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                for (i, &y) in piece.iter().enumerate() {
                    let from = self.offset(slab, slot, y);
                    encoder.copy_buffer_to_buffer(
                        &slab.state,
                        from,
                        &staging,
                        (i * row_bytes) as u64,
                        row_bytes as u64,
                    );
                }
                gpu.queue.submit([encoder.finish()]);
                pieces.push(Piece { first: piece[0], rows: piece.len(), bytes: gpu.read_mapped(staging) });
            }
        }
        gpu.check()?;
        gpu.traffic.layers.fetch_add(1, Ordering::Relaxed);
        Ok(Pending { width: self.grid.width, height: self.grid.height, pieces, arrived: 0 })
    }

    /// A slot where it lies.
    pub(crate) fn view(&self, slot: usize) -> LayerView<'_> {
        let more_rows = if self.split() { GHOST } else { 0 };
        let parts = self.slabs.iter().map(|slab| LayerPart {
            buffer: &slab.state,
            first_row: slab.first,
            rows: slab.rows,
            more_rows,
            offset: (self.offset(slab, slot, slab.first as isize) / 4 + 1) as usize,
            row_stride: self.slots * self.stride,
        });
        LayerView { width: self.grid.width, height: self.grid.height, parts: parts.collect() }
    }

    /// Begins to bring the sums of the accounts back, if there are any.
    pub(crate) fn request_sums(&self, gpu: &Gpu) -> Result<Option<Reading>> {
        if self.accounts == 0 {
            return Ok(None);
        }
        gpu.read(&self.sums, 0, 8 * (self.accounts * self.groups) as u64).map(Some)
    }

    /// The sum of each account, folded in the order of the tiles.
    pub(crate) fn totals(&self, bytes: &[u8]) -> Vec<f64> {
        let pairs: Vec<[f32; 2]> = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let total = |tiles: &[[f32; 2]]| tiles.iter().map(|[sum, rest]| f64::from(*sum) + f64::from(*rest)).sum();
        pairs.chunks_exact(self.groups).map(total).collect()
    }
}

struct Piece {
    first: isize,
    rows: usize,
    bytes: Reading,
}

/// A layer on its way back from the card: a future, or something to look at now and then with [`Pending::try_take`].
pub struct Pending {
    width: usize,
    height: usize,
    pieces: Vec<Piece>,
    arrived: usize,
}

impl Pending {
    /// True once it has arrived. Does not wait.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn is_ready(&mut self) -> Result<bool> {
        while let Some(piece) = self.pieces.get(self.arrived) {
            if !piece.bytes.is_ready()? {
                return Ok(false);
            }
            self.arrived += 1;
        }
        Ok(true)
    }

    /// The layer once it has arrived. Does not wait.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn try_take(&mut self) -> Result<Option<Field>> {
        if self.is_ready()? { self.field().map(Some) } else { Ok(None) }
    }

    /// The layer; waits for it if need be.
    ///
    /// # Errors
    /// If the device was lost, and in a browser, which does not wait, if it has not arrived.
    pub fn take(self, gpu: &Gpu) -> Result<Field> {
        gpu.complete(self)
    }

    fn field(&self) -> Result<Field> {
        let mut field = Field::new(self.width, self.height, 0.0);
        let mut faces = vec![0.0; self.height + self.width];
        for piece in &self.pieces {
            piece.bytes.with(|bytes| {
                let values: &[f32] = bytemuck::cast_slice(bytes);
                for (row, y) in values.chunks_exact(self.width + 1).take(piece.rows).zip(piece.first..) {
                    if y < 0 {
                        faces[self.height..].copy_from_slice(&row[1..]);
                    } else {
                        faces[y as usize] = row[0];
                        field.row_mut(y as usize).copy_from_slice(&row[1..]);
                    }
                }
            })?;
        }
        field.set_outer_faces(&faces)?;
        Ok(field)
    }
}

impl Future for Pending {
    type Output = Result<Field>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        while let Some(piece) = self.pieces.get(self.arrived) {
            match piece.bytes.poll_ready(context) {
                Poll::Ready(Ok(())) => self.arrived += 1,
                Poll::Ready(Err(e)) => return Poll::Ready(Err(e)),
                Poll::Pending => return Poll::Pending,
            }
        }
        Poll::Ready(self.field())
    }
}
