//! Numbers whose bytes were split into streams: the lowest byte of each, then the second of each, and
//! so on (Parquet's `BYTE_STREAM_SPLIT`). The parquet crate joins them byte by byte; a compiler
//! turns loops over whole streams into vector instructions.

use std::ops::Range;
use zwidth_numerics::wide::widest;

/// Numbers that are put together at a time.
const AT_ONCE: usize = 64;

/// A number of a recording whose bytes are split.
pub(crate) trait Joined {
    /// Adds so many numbers; `None` where the streams are not as long as they.
    fn join(streams: &[u8], numbers: usize, into: &mut Vec<f64>) -> Option<()>;
}

impl Joined for f64 {
    fn join(streams: &[u8], numbers: usize, into: &mut Vec<f64>) -> Option<()> {
        let (low, high) = streams.split_at_checked(numbers.checked_mul(4)?)?;
        if high.len() != low.len() {
            return None;
        }
        widest(
            #[inline(always)]
            || doubles(low, high, numbers, into),
        );
        Some(())
    }
}

impl Joined for f32 {
    fn join(streams: &[u8], numbers: usize, into: &mut Vec<f64>) -> Option<()> {
        if streams.len() != numbers.checked_mul(4)? {
            return None;
        }
        widest(
            #[inline(always)]
            || singles(streams, numbers, into),
        );
        Some(())
    }
}

/// Numbers of 64 bits from the streams of their lower and of their upper halves.
#[inline(always)]
fn doubles(low: &[u8], high: &[u8], numbers: usize, into: &mut Vec<f64>) {
    let [mut lows, mut highs] = [[0; AT_ONCE]; 2];
    for from in (0..numbers).step_by(AT_ONCE) {
        let some = from..numbers.min(from + AT_ONCE);
        words(low, numbers, some.clone(), &mut lows);
        words(high, numbers, some.clone(), &mut highs);
        let both = lows.iter().zip(&highs).take(some.len());
        into.extend(
            both.map(|(low, high)| f64::from_bits(u64::from(*high) << 32 | u64::from(*low))),
        );
    }
}

/// Numbers of 32 bits.
#[inline(always)]
fn singles(streams: &[u8], numbers: usize, into: &mut Vec<f64>) {
    let mut room = [0; AT_ONCE];
    for from in (0..numbers).step_by(AT_ONCE) {
        let some = from..numbers.min(from + AT_ONCE);
        words(streams, numbers, some.clone(), &mut room);
        let words = room.iter().take(some.len());
        into.extend(words.map(|word| f64::from(f32::from_bits(*word))));
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
            let (mut found, mut found_narrow) = (Vec::new(), Vec::new());
            f64::join(&streams, wide.len(), &mut found).unwrap();
            f32::join(&narrow_streams, narrow.len(), &mut found_narrow).unwrap();
            assert_eq!(bits(&found), bits(&wide));
            assert_eq!(
                bits(&found_narrow),
                bits(&narrow.iter().map(|v| f64::from(*v)).collect::<Vec<_>>())
            );
            for other in [wide.len() + 1, usize::MAX] {
                assert_eq!(f64::join(&streams, other, &mut found), None);
                assert_eq!(f32::join(&narrow_streams, other, &mut found), None);
            }
        }
    }
}
