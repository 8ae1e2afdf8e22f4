//! Storage of one layer: padded rows, so that hot loops need neither bounds checks nor tails.

// Reason for the exception: the engine hands out rows of one field to several threads at once.
#![allow(unsafe_code)]

use crate::control::Control;
use crate::error::{Error, Result};
use crate::lanes::WIDTH;
use rayon::prelude::*;
use std::ops::Range;

/// Floats left of column 0. One lane block, so that rules may be evaluated at column -1 and read one further.
pub(crate) const PAD_LEFT: usize = 2 * WIDTH;
/// Rows stored above row 0: faces on the north side of an open rim live there.
pub(crate) const PAD_TOP: usize = 1;
/// CacheOffsets that differ: two cache lines each make 4096 bytes.
pub(crate) const CACHE_OFFSETS: usize = 32;
/// Rows that are handed out between two looks at the stop button.
const BAND: usize = 128;

/// A `width` x `height` array of `f32`, row 0 north, stored in rows with padding on both sides.
///
/// The padding is scratch space of the engine; only the interior is a value of the field, and all that `==` compares. What
/// layers on faces keep beyond it ([`Field::outer_faces`]) is compared by their [`Layer`](crate::Layer).
pub struct Field {
    data: Vec<f32>,
    width: usize,
    height: usize,
    stride: usize,
    /// Index of (0, 0) in `data`.
    origin: usize,
    /// Cache lines by which the rows are moved, below [`CACHE_OFFSETS`].
    cache_offset: usize,
}

/// Floats from one row to the next.
const fn stride(width: usize) -> usize {
    let stride = PAD_LEFT + width.next_multiple_of(WIDTH) + WIDTH;
    // Rows whose distance is a multiple of 4096 bytes would alias each other in the same way.
    if (stride * 4).is_multiple_of(1024) { stride + WIDTH } else { stride }
}

impl Field {
    /// A field of `value`s.
    pub fn new(width: usize, height: usize, value: f32) -> Self {
        Self::with_cache_offset(width, height, value, 0)
    }

    /// Computes some `rows` of a larger field in parallel; `row` gets the row's number there and its cells, which are 0.
    ///
    /// # Errors
    /// On a request to stop.
    pub fn from_rows(
        width: usize,
        rows: Range<usize>,
        control: &Control<'_>,
        row: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Result<Self> {
        let mut field = Self::new(width, rows.len(), 0.0);
        let mut made: Vec<&mut [f32]> = field.rows_mut().collect();
        for (band, cells) in made.chunks_mut(BAND).enumerate() {
            let first = rows.start + band * BAND;
            control.tick((first - rows.start) as u64, rows.len() as u64)?;
            cells.par_iter_mut().enumerate().for_each(|(y, cells)| row(first + y, cells));
        }
        Ok(field)
    }

    /// As [`Field::new`], with the rows moved by `cache_offset` cache lines.
    ///
    /// Arrays whose bases agree modulo 4096 bytes slow each other down (a load after a store to the same low
    /// address bits waits for it); the engine gives each array of a world another cache offset.
    pub fn with_cache_offset(width: usize, height: usize, value: f32, cache_offset: usize) -> Self {
        let stride = stride(width);
        let cache_offset = cache_offset % CACHE_OFFSETS;
        let lead = cache_offset * 2 * WIDTH;
        let len = lead + stride * (height + PAD_TOP) + WIDTH;
        // Zeroed pages come from the system without being touched.
        let mut data = vec![0.0; len + WIDTH];
        let misaligned = data.as_ptr().align_offset(64);
        let origin = if misaligned < WIDTH { misaligned } else { 0 } + lead + PAD_TOP * stride + PAD_LEFT;
        if value != 0.0 {
            data.fill(value);
        }
        Self { data, width, height, stride, origin, cache_offset }
    }

    /// A copy of interior and outer faces with another cache offset.
    pub(crate) fn at_cache_offset(&self, cache_offset: usize) -> Self {
        let mut f = Self::with_cache_offset(self.width, self.height, 0.0, cache_offset);
        for y in 0..self.height {
            f.row_mut(y).copy_from_slice(self.row(y));
        }
        // Both have the same number of faces, so this cannot fail.
        let _ = f.set_outer_faces(&self.outer_faces());
        f
    }

    /// The cache offset, below [`CACHE_OFFSETS`].
    pub(crate) fn cache_offset(&self) -> usize {
        self.cache_offset
    }

    /// A field with the given values, row by row from the north.
    ///
    /// # Errors
    /// If `values` has another length than `width * height`.
    pub fn from_slice(width: usize, height: usize, values: &[f32]) -> Result<Self> {
        if values.len() != width * height {
            return Err(Error::Shape {
                what: format!("a field of {width}x{height}"),
                expected: width * height,
                found: values.len(),
            });
        }
        let mut f = Self::new(width, height, 0.0);
        for (y, row) in values.chunks_exact(width.max(1)).enumerate() {
            f.row_mut(y).copy_from_slice(row);
        }
        Ok(f)
    }

    /// A field computed cell by cell from (column, row).
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Self {
        let mut out = Self::new(width, height, 0.0);
        for y in 0..height {
            for (x, v) in out.row_mut(y).iter_mut().enumerate() {
                *v = f(x, y);
            }
        }
        out
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes that a field of this size holds, padding included, before there is one: never less than [`Field::bytes`].
    pub fn bytes_of(width: usize, height: usize) -> u128 {
        let lead = (CACHE_OFFSETS - 1) * 2 * WIDTH + 2 * WIDTH;
        4 * (lead as u128 + stride(width) as u128 * (height as u128 + PAD_TOP as u128))
    }

    /// Bytes held, padding included.
    pub fn bytes(&self) -> usize {
        self.data.len() * 4
    }

    /// Rows and columns, as arrays of other libraries say their shape.
    pub fn shape(&self) -> [usize; 2] {
        [self.height, self.width]
    }

    /// The interior without a copy, and the stride from one row to the next, in floats: the value at (x, y) is
    /// `values[y * stride + x]`. Values from `width` to `stride` of a row are padding: scratch space of the engine,
    /// never a value of the field. The stride is larger than the width, and its address and size may differ from field to field.
    pub fn as_strided(&self) -> (&[f32], usize) {
        (&self.data[self.interior()], self.stride)
    }

    /// As [`Field::as_strided`], to write to. Whatever is written to the padding is lost.
    pub fn as_strided_mut(&mut self) -> (&mut [f32], usize) {
        let interior = self.interior();
        (&mut self.data[interior], self.stride)
    }

    /// From the first to the last value.
    fn interior(&self) -> std::ops::Range<usize> {
        if self.width == 0 || self.height == 0 {
            // A field without values may end before its origin.
            return 0..0;
        }
        self.origin..self.origin + (self.height - 1) * self.stride + self.width
    }

    /// Value at (column, row).
    ///
    /// # Panics
    /// If the cell is outside the field.
    pub fn get(&self, x: usize, y: usize) -> f32 {
        self.row(y)[x]
    }

    /// Sets the value at (column, row).
    ///
    /// # Panics
    /// If the cell is outside the field.
    pub fn set(&mut self, x: usize, y: usize, v: f32) {
        self.row_mut(y)[x] = v;
    }

    /// One row.
    ///
    /// # Panics
    /// If `y` is not below the height.
    pub fn row(&self, y: usize) -> &[f32] {
        assert!(y < self.height, "row {y} of a field with {} rows", self.height);
        let start = self.origin + y * self.stride;
        &self.data[start..start + self.width]
    }

    /// One row, to change.
    ///
    /// # Panics
    /// If `y` is not below the height.
    pub fn row_mut(&mut self, y: usize) -> &mut [f32] {
        assert!(y < self.height, "row {y} of a field with {} rows", self.height);
        let start = self.origin + y * self.stride;
        &mut self.data[start..start + self.width]
    }

    /// The rows from north to south.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> + '_ {
        (0..self.height).map(|y| self.row(y))
    }

    /// The rows from north to south, to change; disjoint, so that they may go to several threads.
    pub fn rows_mut(&mut self) -> impl Iterator<Item = &mut [f32]> + '_ {
        let (start, width) = (self.origin, self.width);
        // A field without rows may end before its origin.
        self.data
            .get_mut(start..)
            .unwrap_or_default()
            .chunks_mut(self.stride)
            .take(self.height)
            .map(move |r| &mut r[..width])
    }

    /// All values, row by row.
    pub fn iter(&self) -> impl Iterator<Item = f32> + '_ {
        self.rows().flat_map(|r| r.iter().copied())
    }

    /// All values in one vector, row by row.
    pub fn to_vec(&self) -> Vec<f32> {
        let mut v = Vec::with_capacity(self.width * self.height);
        self.rows().for_each(|r| v.extend_from_slice(r));
        v
    }

    /// Values on the faces west of column 0 (north to south) and north of row 0 (west to east), which layers of fluxes
    /// have on an open rim: `height + width` numbers. With [`Field::to_vec`] this is the whole state of such a layer.
    pub fn outer_faces(&self) -> Vec<f32> {
        let west = (0..self.height).map(|y| self.data[self.origin + y * self.stride - 1]);
        let north = self.origin - self.stride;
        west.chain(self.data[north..north + self.width].iter().copied()).collect()
    }

    /// Puts back what [`Field::outer_faces`] gave.
    ///
    /// # Errors
    /// If there are not `height + width` values.
    pub fn set_outer_faces(&mut self, faces: &[f32]) -> Result<()> {
        if faces.len() != self.height + self.width {
            return Err(Error::Shape {
                what: "outer faces".into(),
                expected: self.height + self.width,
                found: faces.len(),
            });
        }
        for (y, v) in faces[..self.height].iter().enumerate() {
            self.data[self.origin + y * self.stride - 1] = *v;
        }
        let north = self.origin - self.stride;
        self.data[north..north + self.width].copy_from_slice(&faces[self.height..]);
        Ok(())
    }

    /// Changes every value.
    pub fn map_in_place(&mut self, mut f: impl FnMut(f32) -> f32) {
        self.rows_mut().for_each(|r| r.iter_mut().for_each(|v| *v = f(*v)));
    }

    /// Sum in f64, rows folded from north to south.
    pub fn sum(&self) -> f64 {
        self.rows().map(|r| r.iter().map(|&v| f64::from(v)).sum::<f64>()).sum()
    }

    /// Smallest and largest value; (NaN, NaN) never: values that are not numbers are skipped.
    pub fn min_max(&self) -> (f32, f32) {
        self.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
    }

    /// The first value that is not finite, with its column and row.
    pub fn find_not_finite(&self) -> Option<(usize, usize, f32)> {
        self.rows().enumerate().find_map(|(y, r)| {
            // The sum of finite values can overflow, so a bad sum only means: look closer.
            let suspicious = !r.iter().map(|v| v * 0.0).sum::<f32>().eq(&0.0);
            suspicious.then(|| r.iter().position(|v| !v.is_finite()).map(|x| (x, y, r[x]))).flatten()
        })
    }

    /// Pointer to (0, 0) and the distance of rows, for the engine.
    pub(crate) fn raw(&mut self) -> RawField {
        // SAFETY: origin lies inside data by construction.
        RawField { origin: unsafe { self.data.as_mut_ptr().add(self.origin) }, stride: self.stride }
    }
}

impl Clone for Field {
    /// Copies the interior and the outer faces, with the same cache offset.
    fn clone(&self) -> Self {
        self.at_cache_offset(self.cache_offset)
    }
}

impl PartialEq for Field {
    fn eq(&self, other: &Self) -> bool {
        self.width == other.width && self.height == other.height && self.rows().eq(other.rows())
    }
}

impl std::fmt::Debug for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Field({}x{})", self.width, self.height)
    }
}

/// Where the rows of a field lie in memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RawField {
    pub(crate) origin: *mut f32,
    pub(crate) stride: usize,
}

// SAFETY: a RawField is only an address; the engine's schedule decides who may use which row when.
unsafe impl Send for RawField {}
// SAFETY: as above.
unsafe impl Sync for RawField {}

impl RawField {
    /// Address of column 0 of row `y`; `y` may be -1.
    pub(crate) fn row(self, y: isize) -> *mut f32 {
        self.origin.wrapping_offset(y * self.stride as isize)
    }
}
