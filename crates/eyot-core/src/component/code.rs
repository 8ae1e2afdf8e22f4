//! How components become bytes, and how bytes that anybody may have written become components.

use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::limits::Limits;
use std::io::{self, Read, Write};

/// Bytes that are read or written at a time.
const PART: usize = 1 << 16;

/// Takes a component's numbers, little-endian. What goes wrong with the bytes shows in [`Encoder::finish`], so that components need
/// not care.
pub struct Encoder<'a> {
    out: &'a mut dyn Write,
    buffer: Vec<u8>,
    fault: Option<io::Error>,
}

impl<'a> Encoder<'a> {
    /// Writes to `out`, in large parts.
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, buffer: Vec::with_capacity(PART), fault: None }
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// The first that `out` had.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush();
        self.fault.map_or(Ok(()), Err)
    }

    fn flush(&mut self) {
        if self.fault.is_none() {
            self.fault = self.out.write_all(&self.buffer).err();
        }
        self.buffer.clear();
    }

    /// Bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for part in bytes.chunks(PART) {
            if self.buffer.len() + part.len() > PART {
                self.flush();
            }
            self.buffer.extend(part);
        }
    }

    /// A byte.
    pub fn u8(&mut self, value: u8) {
        self.bytes(&[value]);
    }

    /// Four bytes.
    pub fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    /// Eight bytes.
    pub fn u64(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    /// Four bytes, any bits.
    pub fn f32(&mut self, value: f32) {
        self.bytes(&value.to_le_bytes());
    }

    /// Eight bytes, any bits.
    pub fn f64(&mut self, value: f64) {
        self.bytes(&value.to_le_bytes());
    }

    /// What [`Decoder::count`] reads.
    pub fn count(&mut self, n: usize) {
        self.u64(n as u64);
    }

    /// A length of four bytes, and the text.
    pub fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.bytes(text.as_bytes());
    }

    /// Numbers without their count.
    pub fn u32s(&mut self, values: &[u32]) {
        values.iter().for_each(|v| self.u32(*v));
    }

    /// Numbers without their count.
    pub fn u64s(&mut self, values: &[u64]) {
        values.iter().for_each(|v| self.u64(*v));
    }

    /// Numbers without their count.
    pub fn f32s(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.f32(*v));
    }

    /// Numbers without their count.
    pub fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.f64(*v));
    }
}

/// Gives a component's numbers back. It knows how many bytes there are and reads no further.
pub struct Decoder<'a> {
    name: &'a str,
    input: &'a mut dyn Read,
    /// Bytes still to be handed out.
    left: u64,
    /// Bytes that were read, and how many of them were handed out.
    buffer: Vec<u8>,
    at: usize,
    grid: &'a Grid,
    limits: &'a Limits,
}

impl<'a> Decoder<'a> {
    /// Reads `bytes` bytes of the component `name` of a world on `grid`.
    pub fn new(name: &'a str, input: &'a mut dyn Read, bytes: u64, grid: &'a Grid, limits: &'a Limits) -> Self {
        Self { name, input, left: bytes, buffer: Vec::new(), at: 0, grid, limits }
    }

    /// Bytes that are still to be read.
    pub const fn left(&self) -> u64 {
        self.left
    }

    /// The grid of the component's world.
    pub const fn grid(&self) -> &'a Grid {
        self.grid
    }

    /// What may be allocated.
    pub const fn limits(&self) -> &'a Limits {
        self.limits
    }

    /// An error that names the component.
    pub fn wrong(&self, reason: impl Into<String>) -> Error {
        Error::Component { name: self.name.to_owned(), reason: reason.into() }
    }

    /// # Errors
    /// If bytes are left over.
    pub fn finish(&self) -> Result<()> {
        if self.left > 0 {
            return Err(self.wrong(format!("{} bytes are left over", self.left)));
        }
        Ok(())
    }

    /// How many of something follow that take at least `bytes_each` (1 or more) bytes each.
    ///
    /// # Errors
    /// If there is no room for so many.
    pub fn count(&mut self, bytes_each: u64) -> Result<usize> {
        let n = self.u64()?;
        self.check_room(n, bytes_each)?;
        Ok(n as usize)
    }

    fn check_room(&self, n: u64, bytes_each: u64) -> Result<()> {
        if u128::from(n) * u128::from(bytes_each) > u128::from(self.left) || usize::try_from(n).is_err() {
            return Err(self.wrong(format!("{n} values do not fit in {} bytes", self.left)));
        }
        Ok(())
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        if bytes.len() as u64 > self.left {
            return Err(self.wrong("it is cut short"));
        }
        let mut done = 0;
        while done < bytes.len() {
            if self.at == self.buffer.len() {
                self.buffer.resize(self.left.min(PART as u64) as usize, 0);
                self.at = 0;
                self.input.read_exact(&mut self.buffer).map_err(|e| self.wrong(format!("it cannot be read: {e}")))?;
            }
            let n = (self.buffer.len() - self.at).min(bytes.len() - done);
            bytes[done..done + n].copy_from_slice(&self.buffer[self.at..self.at + n]);
            (self.at, done, self.left) = (self.at + n, done + n, self.left - n as u64);
        }
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// A byte.
    ///
    /// # Errors
    /// This and all that follow: if there are not so many bytes.
    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    /// Four bytes.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// Eight bytes.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// Four bytes, any bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f32(&mut self) -> Result<f32> {
        Ok(f32::from_le_bytes(self.array()?))
    }

    /// Eight bytes, any bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// A text of at most `most` bytes.
    ///
    /// # Errors
    /// As [`Decoder::u8`], or if it is longer or no UTF-8.
    pub fn text(&mut self, most: usize) -> Result<String> {
        let n = self.u32()? as usize;
        if n > most {
            return Err(self.wrong(format!("a text of {n} bytes, at most {most} can be")));
        }
        String::from_utf8(self.u8s(n)?).map_err(|_| self.wrong("a text that is none"))
    }

    /// So many bytes.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u8s(&mut self, n: usize) -> Result<Vec<u8>> {
        self.check_room(n as u64, 1)?;
        let mut bytes = vec![0; n];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// So many numbers.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u32s(&mut self, n: usize) -> Result<Vec<u32>> {
        self.numbers(n, u32::from_le_bytes)
    }

    /// So many numbers.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u64s(&mut self, n: usize) -> Result<Vec<u64>> {
        self.numbers(n, u64::from_le_bytes)
    }

    /// So many numbers, any bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f32s(&mut self, n: usize) -> Result<Vec<f32>> {
        self.numbers(n, f32::from_le_bytes)
    }

    /// So many numbers, any bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f64s(&mut self, n: usize) -> Result<Vec<f64>> {
        self.numbers(n, f64::from_le_bytes)
    }

    fn numbers<const N: usize, T>(&mut self, n: usize, of: fn([u8; N]) -> T) -> Result<Vec<T>> {
        self.check_room(n as u64, N as u64)?;
        let mut values = Vec::with_capacity(n);
        let mut buffer = vec![0; N * n.min(PART / N)];
        while values.len() < n {
            let bytes = &mut buffer[..N * (n - values.len()).min(PART / N)];
            self.fill(bytes)?;
            values.extend(bytes.chunks_exact(N).map(|b| of(std::array::from_fn(|i| b[i]))));
        }
        Ok(values)
    }
}
