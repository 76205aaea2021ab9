//! What a disk does with the sectors of an unfinished or misdirected write, for [`crate::Memory`].

use super::SECTOR;

/// Numbers that follow from a seed (SplitMix64, Steele, Lea and Flood 2014).
#[derive(Debug, Clone)]
pub(crate) struct Draws(u64);

impl Draws {
    pub(crate) fn from(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below `n`; 0 below 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % (n.max(1) as u64)) as usize
    }

    pub(crate) fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// What a power cut leaves of a file: any of the sectors that were written since its last sync, and
/// of the others what was there, or zeros where the file was shorter. Its length is the old one, the
/// new one, or the end of a sector between.
pub(crate) fn torn(synced: &[u8], written: &[u8], draws: &mut Draws) -> Vec<u8> {
    if synced == written {
        return written.to_vec();
    }
    let between = synced.len() + draws.below(written.len().saturating_sub(synced.len()));
    let length = match draws.below(4) {
        0 => synced.len(),
        1 => between.next_multiple_of(SECTOR).min(written.len()),
        _ => written.len(),
    };
    let mut left = written[..length.min(written.len())].to_vec();
    for (number, sector) in left.chunks_mut(SECTOR).enumerate() {
        let at = number * SECTOR;
        let old = synced.get(at..).unwrap_or_default();
        let old = &old[..old.len().min(sector.len())];
        if draws.one_in(2) {
            sector[..old.len()].copy_from_slice(old);
            sector[old.len()..].fill(0);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_synced_stays_and_of_the_rest_any_subset_of_sectors_does() {
        let synced = vec![1_u8; 700];
        let written = [synced.clone(), vec![2; 1700]].concat();
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..500 {
            let left = torn(&synced, &written, &mut Draws::from(seed));
            assert!(left.starts_with(&synced) && left.len() <= written.len());
            // In its second sector new bytes follow old ones, or none of them is there.
            let tail: Vec<u8> = left[700..].to_vec();
            assert!(tail.iter().all(|byte| [0, 2].contains(byte)));
            kinds.insert((
                left.len(),
                left.chunks(SECTOR).map(|s| s.ends_with(&[2])).collect::<Vec<_>>(),
            ));
        }
        // Old, new, and three ends of sectors; of the longest every subset of the four sectors.
        let longest = kinds.iter().filter(|(length, _)| *length == written.len()).count();
        assert_eq!(longest, 16);
        let lengths: std::collections::BTreeSet<usize> = kinds.iter().map(|(l, _)| *l).collect();
        assert!(lengths.contains(&700) && lengths.contains(&1024) && lengths.contains(&1536));
    }

    /// A writer that trusts the last byte of what it appends takes zeros for its own data.
    #[test]
    fn a_line_that_ends_as_it_should_may_be_torn_before_its_end() {
        let line = [vec![b'x'; 1500], b"\n".to_vec()].concat();
        let lost = (0..200).filter(|seed| {
            let left = torn(b"", &line, &mut Draws::from(*seed));
            left.len() == line.len() && left.ends_with(b"\n") && left.contains(&0)
        });
        assert!(lost.count() > 20);
    }
}
