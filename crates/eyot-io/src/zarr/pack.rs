//! How the pieces of stores are compressed: with zstd, or with gzip by programs that are built without its C code. Both kinds
//! of programs read both kinds of stores.

use serde_json::{Value, json};
use std::io::{self, Read};

#[cfg(feature = "zstd")]
mod how {
    use super::*;

    /// The usual balance of zstd.
    const LEVEL: i32 = 3;

    pub(crate) fn codec() -> Value {
        json!({ "name": "zstd", "configuration": { "level": LEVEL, "checksum": false } })
    }

    pub(crate) fn pack(bytes: &[u8]) -> io::Result<Vec<u8>> {
        zstd::bulk::compress(bytes, LEVEL)
    }

    pub(crate) fn zstd_reader(bytes: &[u8]) -> io::Result<impl Read> {
        zstd::stream::read::Decoder::with_buffer(bytes)
    }
}

#[cfg(not(feature = "zstd"))]
mod how {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    /// Deflate's fastest levels come close to its best ones on numbers.
    const LEVEL: u32 = 4;

    pub(crate) fn codec() -> Value {
        json!({ "name": "gzip", "configuration": { "level": LEVEL } })
    }

    pub(crate) fn pack(bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::new(LEVEL));
        encoder.write_all(bytes)?;
        encoder.finish()
    }

    pub(crate) fn zstd_reader(bytes: &[u8]) -> io::Result<impl Read> {
        super::in_rust(bytes)
    }
}

/// The metadata of the codec that [`pack`] applies.
pub(super) use how::codec;
/// Compresses the bytes of a chunk. The same bytes give the same result.
pub(super) use how::pack;
/// What zstd compressed.
pub(super) use how::zstd_reader;

/// One frame of zstd, by Rust code alone.
#[cfg(any(test, not(feature = "zstd")))]
fn in_rust(bytes: &[u8]) -> io::Result<impl Read> {
    ruzstd::decoding::StreamingDecoder::new(bytes).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of numbers as layers have them.
    fn numbers() -> Vec<u8> {
        (0..20_000u32).flat_map(|i| ((i as f32 * 0.01).sin() * 100.0).to_le_bytes()).collect()
    }

    #[cfg(feature = "zstd")]
    #[test]
    fn rust_reads_what_c_has_packed() {
        for bytes in [Vec::new(), vec![7; 65_536], numbers()] {
            let packed = pack(&bytes).unwrap();
            for mut reader in
                [Box::new(zstd_reader(&packed).unwrap()) as Box<dyn Read>, Box::new(in_rust(&packed).unwrap())]
            {
                let mut back = Vec::new();
                reader.read_to_end(&mut back).unwrap();
                assert!(back == bytes, "{} bytes", bytes.len());
            }
        }
    }

    #[test]
    fn damaged_frames_are_errors() {
        let frame =
            ruzstd::encoding::compress_to_vec(numbers().as_slice(), ruzstd::encoding::CompressionLevel::Fastest);
        for i in 0..64.min(frame.len()) {
            let mut damaged = frame.clone();
            damaged[i] ^= 0x55;
            damaged.truncate(frame.len() - i);
            let mut out = Vec::new();
            let result = in_rust(&damaged).and_then(|r| r.take(1 << 20).read_to_end(&mut out));
            assert!(result.is_err() || out.len() <= 1 << 20, "byte {i}");
        }
    }
}
