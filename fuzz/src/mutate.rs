//! Damage: deterministic for a seed, without knowledge of the format but for a few words of it.

/// SplitMix64: any generator would do, this one needs no crate.
pub struct Random(u64);

impl Random {
    /// A generator that starts at `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, which must not be 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}

/// Numbers that headers dislike.
const NASTY: [u32; 10] = [0, 1, 0x7f, 0xff, 0xffff, 0x1_0000, 200_000, 0x7fff_ffff, 0x8000_0000, u32::MAX];

/// One to four changes to `bytes`; `other` is another input to take pieces from.
pub fn damage(bytes: &mut Vec<u8>, other: &[u8], words: &[&str], r: &mut Random) {
    let rounds = 1 << r.below(3);
    for _ in 0..rounds {
        // Headers and directories sit at the start; half of the damage goes there.
        let span = if r.below(2) == 0 { bytes.len().min(600) } else { bytes.len() };
        let at = r.below(span + 1).min(bytes.len().saturating_sub(1));
        let end = (at + 1 + r.below(16)).min(bytes.len());
        match r.below(if words.is_empty() { 7 } else { 9 }) {
            _ if bytes.is_empty() => bytes.extend_from_slice(other),
            0 => bytes[at] ^= 1 << r.below(8),
            1 => bytes[at] = r.bits() as u8,
            2 => {
                let value = NASTY[r.below(NASTY.len())];
                let nasty = if r.below(2) == 0 { value.to_le_bytes() } else { value.to_be_bytes() };
                let length = [1, 2, 4][r.below(3)];
                bytes[at..].iter_mut().zip(&nasty[..length]).for_each(|(b, n)| *b = *n);
            }
            3 if r.below(4) == 0 => bytes.truncate(at),
            3 | 4 => {
                let piece = bytes[at..end].to_vec();
                let to = r.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => drop(bytes.drain(at..end)),
            6 if !other.is_empty() => {
                let from = r.below(other.len());
                let piece = &other[from..(from + 1 + r.below(64)).min(other.len())];
                bytes.splice(at..end, piece.iter().copied());
            }
            6 => {}
            _ => {
                let word = words[r.below(words.len())].bytes();
                bytes.splice(at..if r.below(2) == 0 { at } else { end }, word);
            }
        }
    }
}
