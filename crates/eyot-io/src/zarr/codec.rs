//! Codecs of arrays, in: what turns the bytes of a file back into values.

use super::array::{Reason, broken, name, sizes};
use super::pack;
use crate::sample::{ByteOrder, Sample};
use serde_json::Value;
use std::io::Read;

/// One codec.
pub(super) enum Codec {
    Zstd,
    Gzip,
    Crc32c,
    Sharding(Box<Shards>),
}

/// The codecs of an array in the order in which they were applied, the order of bytes apart.
pub(super) struct Codecs {
    chain: Vec<Codec>,
    pub(super) order: ByteOrder,
}

/// A piece that consists of smaller ones.
pub(super) struct Shards {
    chunk: Vec<u64>,
    inner: Codecs,
    index_at_end: bool,
    index_checksum: bool,
}

impl Codec {
    /// Reads a list of codecs for pieces of the shape `piece`.
    pub(super) fn chain(value: &Value, piece: &[u64], sample: Sample) -> Result<Codecs, Reason> {
        let Some(list) = value.as_array() else { return broken("the codecs are no list") };
        let mut chain = Vec::new();
        let mut order = None;
        for c in list {
            let configuration = &c["configuration"];
            let codec = match name(c) {
                // The only codecs that take values, not bytes.
                Some("transpose") => {
                    let straight: Vec<u64> = (0..piece.len() as u64).collect();
                    if sizes(&configuration["order"], "order")? != straight {
                        return broken("transposed arrays are not read");
                    }
                    continue;
                }
                Some("bytes") if order.is_none() => {
                    order = Some(match configuration["endian"].as_str() {
                        None | Some("little") => ByteOrder::Little,
                        Some("big") => ByteOrder::Big,
                        Some(other) => return broken(format!("the order of bytes `{other}`")),
                    });
                    continue;
                }
                Some("sharding_indexed") if order.is_none() => {
                    let shards = Shards::of(configuration, piece, sample)?;
                    order = Some(shards.inner.order);
                    Codec::Sharding(Box::new(shards))
                }
                Some("zstd") => Codec::Zstd,
                Some("gzip") => Codec::Gzip,
                Some("crc32c") => Codec::Crc32c,
                other => return broken(format!("the codec `{}` is not read", other.unwrap_or("?"))),
            };
            chain.push(codec);
        }
        match order {
            Some(order) => Ok(Codecs { chain, order }),
            None => broken("no codec turns values into bytes"),
        }
    }
}

impl Codecs {
    /// Chunks in a piece of this shape.
    pub(super) fn chunks(&self, piece: &[u64]) -> u128 {
        let within = |c: &Codec| match c {
            Codec::Sharding(s) => piece.iter().zip(&s.chunk).map(|(p, c)| u128::from(p / c)).product(),
            _ => 1,
        };
        self.chain.iter().map(within).max().unwrap_or(1)
    }

    /// The bytes of the values of a piece.
    pub(super) fn decode(
        &self,
        mut bytes: Vec<u8>,
        shape: &[u64],
        sample: Sample,
        fill: &[u8],
    ) -> Result<Vec<u8>, String> {
        let needed = shape.iter().product::<u64>() as usize * sample.bytes();
        // Checksums and indices make intermediate forms a little longer than the values.
        let most = needed + needed / 8 + (1 << 20);
        for codec in self.chain.iter().rev() {
            bytes = match codec {
                Codec::Zstd => {
                    unpack(pack::zstd_reader(&bytes).map_err(|e| format!("broken zstd data: {e}"))?, most, "zstd")?
                }
                Codec::Gzip => unpack(flate2::read::MultiGzDecoder::new(bytes.as_slice()), most, "gzip")?,
                Codec::Crc32c => {
                    checked(&mut bytes)?;
                    bytes
                }
                Codec::Sharding(shards) => shards.decode(&bytes, shape, sample, fill)?,
            };
        }
        if bytes.len() != needed {
            return Err(format!("the chunk has {} bytes, {needed} are needed", bytes.len()));
        }
        Ok(bytes)
    }
}

fn unpack(reader: impl Read, most: usize, what: &str) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    reader.take(most as u64 + 1).read_to_end(&mut out).map_err(|e| format!("broken {what} data: {e}"))?;
    if out.len() > most { Err("the chunk holds more than its shape".to_owned()) } else { Ok(out) }
}

/// Takes the checksum off and compares it.
fn checked(bytes: &mut Vec<u8>) -> Result<(), String> {
    let Some(at) = bytes.len().checked_sub(4) else { return Err("the chunk ends too early".to_owned()) };
    let stored = bytes.split_off(at);
    if crc32c::crc32c(bytes).to_le_bytes()[..] != stored[..] {
        return Err("the checksum does not fit".to_owned());
    }
    Ok(())
}

impl Shards {
    fn of(configuration: &Value, piece: &[u64], sample: Sample) -> Result<Self, Reason> {
        let chunk = sizes(&configuration["chunk_shape"], "chunk_shape")?;
        let fits = |(c, p): (&u64, &u64)| *c > 0 && p.is_multiple_of(*c);
        if chunk.len() != piece.len() || !chunk.iter().zip(piece).all(fits) {
            return broken(format!("chunks of {chunk:?} do not divide shards of {piece:?}"));
        }
        let index: Option<Vec<&str>> =
            configuration["index_codecs"].as_array().map(|l| l.iter().filter_map(name).collect());
        let index_checksum = match index.as_deref() {
            Some(["bytes"]) => false,
            Some(["bytes", "crc32c"]) => true,
            _ => return broken("unknown codecs of a shard's index"),
        };
        if configuration["index_codecs"][0]["configuration"]["endian"] == "big" {
            return broken("indices of shards that start with the most significant byte are not read");
        }
        let inner = Codec::chain(&configuration["codecs"], &chunk, sample)?;
        // Each level would hold all values once more.
        if inner.chain.iter().any(|c| matches!(c, Codec::Sharding(_))) {
            return broken("shards within shards are not read");
        }
        Ok(Self { chunk, inner, index_at_end: configuration["index_location"] != "start", index_checksum })
    }

    fn decode(&self, bytes: &[u8], shape: &[u64], sample: Sample, fill: &[u8]) -> Result<Vec<u8>, String> {
        let short = || "the shard ends too early".to_owned();
        let counts: Vec<usize> = shape.iter().zip(&self.chunk).map(|(s, c)| (s / c) as usize).collect();
        let chunks: usize = counts.iter().product();
        let length = chunks
            .checked_mul(16)
            .and_then(|n| n.checked_add(if self.index_checksum { 4 } else { 0 }))
            .filter(|&n| n <= bytes.len())
            .ok_or_else(short)?;
        let at = if self.index_at_end { bytes.len() - length } else { 0 };
        let mut index = bytes[at..at + length].to_vec();
        if self.index_checksum {
            checked(&mut index)?;
        }
        let size = sample.bytes();
        let values = shape.iter().product::<u64>() as usize;
        let mut out = fill.repeat(values);
        // Chunks that share bytes would take far more work than the shard has bytes.
        let mut unclaimed = bytes.len() as u64;
        for (i, entry) in index.chunks_exact(16).enumerate() {
            let number = |b: &[u8]| u64::from_le_bytes(std::array::from_fn(|j| b[j]));
            let (offset, length) = (number(&entry[..8]), number(&entry[8..]));
            if (offset, length) == (u64::MAX, u64::MAX) {
                continue;
            }
            let end = offset.checked_add(length).filter(|&e| e <= bytes.len() as u64).ok_or_else(short)?;
            unclaimed = unclaimed.checked_sub(length).ok_or("the chunks of the shard overlap")?;
            let packed = bytes[offset as usize..end as usize].to_vec();
            let chunk = self.inner.decode(packed, &self.chunk, sample, fill)?;
            place(&chunk, &self.chunk, &mut out, shape, &position(i, &counts), size);
        }
        Ok(out)
    }
}

/// Indices along each dimension of the `i`-th of `counts` chunks.
fn position(mut i: usize, counts: &[usize]) -> Vec<usize> {
    let mut at = vec![0; counts.len()];
    for (a, n) in at.iter_mut().zip(counts).rev() {
        *a = i % n;
        i /= n;
    }
    at
}

/// Copies a chunk to its place in a shard, line by line.
fn place(chunk: &[u8], chunk_shape: &[u64], out: &mut [u8], shape: &[u64], at: &[usize], size: usize) {
    let Some(line) = chunk_shape.last().map(|&n| n as usize) else {
        out.copy_from_slice(chunk);
        return;
    };
    for (i, bytes) in chunk.chunks_exact(line * size).enumerate() {
        // Which line of the chunk this is, along all dimensions but the last.
        let lines: Vec<usize> = chunk_shape[..chunk_shape.len() - 1].iter().map(|&n| n as usize).collect();
        let within = position(i, &lines);
        let mut start = 0;
        for d in 0..shape.len() {
            let inside = within.get(d).copied().unwrap_or(0);
            start = start * shape[d] as usize + at[d] * chunk_shape[d] as usize + inside;
        }
        out[start * size..][..bytes.len()].copy_from_slice(bytes);
    }
}
