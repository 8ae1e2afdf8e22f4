//! Numbers and texts as bytes, little-endian, and back.

use crate::record::Malformed;

/// Longest text in a record, bytes.
pub(crate) const MAX_TEXT: usize = 4096;

/// Writes numbers and texts.
pub(crate) trait Put {
    fn bytes(&mut self, bytes: &[u8]);
    fn u8(&mut self, v: u8) {
        self.bytes(&[v]);
    }
    fn u16(&mut self, v: u16) {
        self.bytes(&v.to_le_bytes());
    }
    fn u32(&mut self, v: u32) {
        self.bytes(&v.to_le_bytes());
    }
    fn u64(&mut self, v: u64) {
        self.bytes(&v.to_le_bytes());
    }
    fn i32(&mut self, v: i32) {
        self.bytes(&v.to_le_bytes());
    }
    fn f32(&mut self, v: f32) {
        self.bytes(&v.to_le_bytes());
    }
    fn f64(&mut self, v: f64) {
        self.bytes(&v.to_le_bytes());
    }
    /// Its length as 16 bits, then its bytes; cut where it is too long.
    fn text(&mut self, v: &str) {
        let text = &v[..v.floor_char_boundary(MAX_TEXT)];
        self.u16(text.len() as u16);
        self.bytes(text.as_bytes());
    }
}

impl Put for Vec<u8> {
    fn bytes(&mut self, bytes: &[u8]) {
        self.extend_from_slice(bytes);
    }
}

/// Reads numbers and texts; says where it could not.
pub(crate) struct Take<'a> {
    data: &'a [u8],
    at: usize,
}

impl<'a> Take<'a> {
    /// Errors name places of `data`, reading begins at `at`.
    pub(crate) fn new(data: &'a [u8], at: usize) -> Self {
        Self { data, at }
    }

    pub(crate) fn wrong(&self, what: impl Into<String>) -> Malformed {
        Malformed { at: self.at, what: what.into() }
    }

    pub(crate) fn left(&self) -> usize {
        self.data.len().saturating_sub(self.at)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let found = self.data.get(self.at..).and_then(|d| d.first_chunk::<N>()).copied();
        let found = found.ok_or_else(|| self.wrong(format!("{N} bytes are missing")))?;
        self.at += N;
        Ok(found)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, Malformed> {
        self.array().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn i32(&mut self) -> Result<i32, Malformed> {
        self.array().map(i32::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Result<f32, Malformed> {
        self.array().map(f32::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Result<f64, Malformed> {
        self.array().map(f64::from_le_bytes)
    }

    pub(crate) fn text(&mut self) -> Result<String, Malformed> {
        let length = usize::from(self.u16()?);
        if length > MAX_TEXT {
            return Err(self.wrong(format!("a text of {length} bytes, at most {MAX_TEXT}")));
        }
        let bytes = self.data.get(self.at..self.at + length);
        let bytes = bytes.ok_or_else(|| self.wrong(format!("a text of {length} bytes is cut off")))?;
        let text = std::str::from_utf8(bytes).map_err(|_| self.wrong("a text that is no UTF-8"))?;
        self.at += length;
        Ok(text.to_owned())
    }

    /// Bytes that a later version may use.
    pub(crate) fn zeros(&mut self, count: usize) -> Result<(), Malformed> {
        for _ in 0..count {
            if self.u8()? != 0 {
                self.at -= 1;
                return Err(self.wrong("a reserved byte is not 0"));
            }
        }
        Ok(())
    }

    /// Rows of a table are exactly what is left: nothing is allocated for a count that lies.
    pub(crate) fn table(&self, count: u64, stride: usize) -> Result<usize, Malformed> {
        if u128::from(count) * stride as u128 != self.left() as u128 {
            return Err(self.wrong(format!("{count} rows of {stride} bytes, but {} bytes are left", self.left())));
        }
        Ok(count as usize)
    }

    pub(crate) fn end(&self) -> Result<(), Malformed> {
        if self.left() > 0 {
            return Err(self.wrong(format!("{} bytes too many", self.left())));
        }
        Ok(())
    }
}
