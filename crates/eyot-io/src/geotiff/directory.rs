//! Directories of a TIFF file as bytes, classic or BigTIFF, little-endian.

/// The value of a tag.
#[derive(Clone)]
pub(super) enum Tagged {
    Short(Vec<u16>),
    Long(Vec<u32>),
    /// Numbers of 32 bits in classic files and of 64 in big ones.
    Offset(Vec<u64>),
    Double(Vec<f64>),
    Ascii(String),
}

impl Tagged {
    /// TIFF's number of the type, the number of values, and the values.
    fn encode(&self, big: bool) -> (u16, u64, Vec<u8>) {
        match self {
            Self::Short(v) => (3, v.len() as u64, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Self::Long(v) => (4, v.len() as u64, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Self::Offset(v) if big => (16, v.len() as u64, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Self::Offset(v) => (4, v.len() as u64, v.iter().flat_map(|n| (*n as u32).to_le_bytes()).collect()),
            Self::Double(v) => (12, v.len() as u64, v.iter().flat_map(|n| n.to_le_bytes()).collect()),
            Self::Ascii(s) => (2, s.len() as u64 + 1, [s.as_bytes(), &[0]].concat()),
        }
    }
}

/// Bytes of the header, up to where anything may follow.
pub(super) const fn header_bytes(big: bool) -> usize {
    if big { 16 } else { 8 }
}

/// The header of a file whose first directory is at `first`.
pub(super) fn header(first: u64, big: bool) -> Vec<u8> {
    let mut out = b"II".to_vec();
    if big {
        out.extend([43, 0, 8, 0, 0, 0]);
        out.extend(first.to_le_bytes());
    } else {
        out.extend([42, 0]);
        out.extend((first as u32).to_le_bytes());
    }
    out
}

/// A directory that starts at `at`, followed by those of its values that do not fit into it; the next directory follows
/// immediately unless this is the last. Tags must be in ascending order.
pub(super) fn directory(tags: &[(u16, Tagged)], at: u64, last: bool, big: bool) -> Vec<u8> {
    let (word, entry) = if big { (8, 20) } else { (4, 12) };
    let number = |out: &mut Vec<u8>, n: u64| out.extend(&n.to_le_bytes()[..word]);
    let length = if big { 8 } else { 2 } + tags.len() * entry + word;
    let mut out = Vec::with_capacity(length);
    let mut values = Vec::new();
    out.extend(&(tags.len() as u64).to_le_bytes()[..if big { 8 } else { 2 }]);
    for (tag, value) in tags {
        let (kind, count, mut bytes) = value.encode(big);
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        number(&mut out, count);
        if bytes.len() <= word {
            bytes.resize(word, 0);
            out.extend(bytes);
        } else {
            number(&mut out, at + (length + values.len()) as u64);
            bytes.resize(bytes.len().next_multiple_of(8), 0);
            values.extend(bytes);
        }
    }
    let end = (length + values.len()).next_multiple_of(8);
    number(&mut out, if last { 0 } else { at + end as u64 });
    out.extend(values);
    out.resize(end, 0);
    out
}
