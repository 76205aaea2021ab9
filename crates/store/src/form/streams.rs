//! Numbers whose bytes were split into streams: the lowest byte of each, then the second of each, and
//! so on (Parquet's `BYTE_STREAM_SPLIT`). The parquet crate joins them byte by byte; a compiler
//! turns loops over whole streams into vector instructions.

use std::ops::Range;
use zwidth_numerics::wide::widest;

/// Numbers that are put together at a time.
const AT_ONCE: usize = 64;

/// A number of a recording whose bytes are split.
pub(crate) trait Joined {
    /// Fills all of `into` with numbers; `None` where the streams are not as long as they.
    fn join(streams: &[u8], into: &mut [f64]) -> Option<()>;
}

impl Joined for f64 {
    fn join(streams: &[u8], into: &mut [f64]) -> Option<()> {
        let (low, high) = streams.split_at_checked(into.len().checked_mul(4)?)?;
        if high.len() != low.len() {
            return None;
        }
        widest(
            #[inline(always)]
            || doubles(low, high, into),
        );
        Some(())
    }
}

impl Joined for f32 {
    fn join(streams: &[u8], into: &mut [f64]) -> Option<()> {
        if streams.len() != into.len().checked_mul(4)? {
            return None;
        }
        widest(
            #[inline(always)]
            || singles(streams, into),
        );
        Some(())
    }
}

/// Numbers of 64 bits from the streams of their lower and of their upper halves.
#[inline(always)]
fn doubles(low: &[u8], high: &[u8], into: &mut [f64]) {
    let [mut lows, mut highs] = [[0; AT_ONCE]; 2];
    let numbers = into.len();
    for (i, into) in into.chunks_mut(AT_ONCE).enumerate() {
        let some = i * AT_ONCE..i * AT_ONCE + into.len();
        words(low, numbers, some.clone(), &mut lows);
        words(high, numbers, some, &mut highs);
        for (into, (low, high)) in into.iter_mut().zip(lows.iter().zip(&highs)) {
            *into = f64::from_bits(u64::from(*high) << 32 | u64::from(*low));
        }
    }
}

/// Numbers of 32 bits.
#[inline(always)]
fn singles(streams: &[u8], into: &mut [f64]) {
    let mut room = [0; AT_ONCE];
    let numbers = into.len();
    for (i, into) in into.chunks_mut(AT_ONCE).enumerate() {
        words(streams, numbers, i * AT_ONCE..i * AT_ONCE + into.len(), &mut room);
        for (into, word) in into.iter_mut().zip(&room) {
            *into = f64::from(f32::from_bits(*word));
        }
    }
}

/// Some of the words whose four bytes lie in four streams of this length, the lowest first.
#[inline(always)]
fn words(streams: &[u8], length: usize, some: Range<usize>, words: &mut [u32; AT_ONCE]) {
    let stream = |k: usize| &streams[k * length..(k + 1) * length][some.clone()];
    let bytes = stream(0).iter().zip(stream(1)).zip(stream(2)).zip(stream(3));
    for (word, (((a, b), c), d)) in words.iter_mut().zip(bytes) {
        *word = u32::from_le_bytes([*a, *b, *c, *d]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split<const N: usize>(numbers: &[[u8; N]]) -> Vec<u8> {
        (0..N).flat_map(|k| numbers.iter().map(move |bytes| bytes[k])).collect()
    }

    #[test]
    fn numbers_come_back_bit_for_bit_and_streams_of_another_length_are_refused() {
        for n in [0, 1, 63, 64, 65, 200] {
            let wide: Vec<f64> = (0..n)
                .map(|i| f64::from_bits(u64::wrapping_mul(i, 0x9e37_79b9_7f4a_7c15)))
                .collect();
            let narrow: Vec<f32> = wide.iter().map(|v| *v as f32).collect();
            let streams = split(&wide.iter().map(|v| v.to_le_bytes()).collect::<Vec<_>>());
            let narrow_streams = split(&narrow.iter().map(|v| v.to_le_bytes()).collect::<Vec<_>>());
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let [mut found, mut found_narrow] = [vec![0.0; wide.len()], vec![0.0; narrow.len()]];
            f64::join(&streams, &mut found).unwrap();
            f32::join(&narrow_streams, &mut found_narrow).unwrap();
            assert_eq!(bits(&found), bits(&wide));
            assert_eq!(
                bits(&found_narrow),
                bits(&narrow.iter().map(|v| f64::from(*v)).collect::<Vec<_>>())
            );
            let mut other = vec![0.0; wide.len() + 1];
            assert_eq!(f64::join(&streams, &mut other), None);
            assert_eq!(f32::join(&narrow_streams, &mut other), None);
        }
    }
}
