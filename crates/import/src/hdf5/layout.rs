//! Parts of HDF5 files that the library cannot read, and that are changed in memory before it does:
//! layouts of chunks as HDF5 2.0 writes them, and a user block that was cut off.
//!
//! The library (hdf5-pure 0.47) refuses version 5 of the message, which differs from version 4 in
//! one way: the sizes of filtered chunks always have eight bytes, not as few as a chunk needs. The
//! index of the chunks also says how many bytes they have, and the library looks there. So such
//! messages are changed to version 4, in memory, before the library reads them.
//!
//! Source: HDF5 2.0.0, `H5Olayout.c` and `H5Dfarray.c`; Bob Jenkins, `lookup3.c`, `hashlittle`, for the checksum.

use super::raw::Raw;
use std::collections::BTreeSet;
use std::ops::Range;

const LAYOUT: u16 = 0x08;
const READ: u8 = 4;
const WRITTEN: u8 = 5;

/// Makes every layout of version 5 one of version 4. Headers are sought by their signature: a group may hold
/// them in an index.
pub(super) fn make_older(bytes: &mut [u8]) {
    let mut changes = Vec::new();
    let mut seen = BTreeSet::new();
    if let Some((raw, _)) = Raw::open(bytes) {
        let headers = bytes.windows(4).enumerate().filter(|(_, window)| window == b"OHDR");
        for (at, _) in headers {
            for message in raw.messages(at, &mut seen) {
                let is_newer = message.kind == LAYOUT && bytes.get(message.from) == Some(&WRITTEN);
                changes.extend(message.summed.filter(|_| is_newer).map(|sum| (message.from, sum)));
            }
        }
    }
    for (version, summed) in changes {
        if is_whole(bytes, &summed) {
            bytes[version] = READ;
            put_checksum(bytes, summed);
        }
    }
}

/// Writes where the file begins, if that is not where its superblock stands: a block before it was cut off,
/// such as the text that MATLAB puts first. HDF5's own library does so too (`H5Fsuper.c`).
pub(super) fn put_beginning(bytes: &mut [u8]) {
    let Some((raw, _)) = Raw::open(bytes) else { return };
    let base = raw.base;
    let size = raw.address_size;
    let version = bytes[base + 8];
    let addresses = base + if version < 2 { 24 + 4 * usize::from(version) } else { 12 };
    // Behind the address of the file's beginning and another one: that of its end.
    let start = raw.number(addresses, size);
    let end = raw.number(addresses + 2 * size, size);
    let (Some(named), Some(end)) = (start, end) else { return };
    if named == base {
        return;
    }
    // The checksum stands behind four addresses.
    let summed = base..addresses + 4 * size;
    if version >= 2 && !is_whole(bytes, &summed) {
        return;
    }
    let end = end.wrapping_sub(named).wrapping_add(base);
    for (at, address) in [(addresses, base), (addresses + 2 * size, end)] {
        bytes[at..at + size].copy_from_slice(&(address as u64).to_le_bytes()[..size]);
    }
    if version >= 2 {
        put_checksum(bytes, summed);
    }
}

/// Whether the checksum behind a block is its own: what has another is damaged, or no block at all.
fn is_whole(bytes: &[u8], block: &Range<usize>) -> bool {
    let stored = bytes.get(block.end..block.end + 4);
    let sum = bytes.get(block.clone()).map(|block| checksum(block).to_le_bytes());
    sum.is_some_and(|sum| stored == Some(&sum[..]))
}

fn put_checksum(bytes: &mut [u8], block: Range<usize>) {
    let sum = checksum(&bytes[block.clone()]).to_le_bytes();
    bytes[block.end..block.end + 4].copy_from_slice(&sum);
}

/// The checksum of a block of metadata, lookup3 from 0.
fn checksum(bytes: &[u8]) -> u32 {
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    let [mut a, mut b, mut c] = [0xdead_beef_u32.wrapping_add(length); 3];
    let mut rest = bytes;
    loop {
        let (block, behind) = rest.split_at(rest.len().min(12));
        if block.is_empty() {
            return c;
        }
        let [x, y, z] = [0, 4, 8].map(|at| {
            let bytes = block.iter().skip(at).take(4).rev();
            bytes.fold(0_u32, |word, byte| word << 8 | u32::from(*byte))
        });
        a = a.wrapping_add(x);
        b = b.wrapping_add(y);
        c = c.wrapping_add(z);
        if behind.is_empty() {
            break;
        }
        a = a.wrapping_sub(c) ^ c.rotate_left(4);
        c = c.wrapping_add(b);
        b = b.wrapping_sub(a) ^ a.rotate_left(6);
        a = a.wrapping_add(c);
        c = c.wrapping_sub(b) ^ b.rotate_left(8);
        b = b.wrapping_add(a);
        a = a.wrapping_sub(c) ^ c.rotate_left(16);
        c = c.wrapping_add(b);
        b = b.wrapping_sub(a) ^ a.rotate_left(19);
        a = a.wrapping_add(c);
        c = c.wrapping_sub(b) ^ b.rotate_left(4);
        b = b.wrapping_add(a);
        rest = behind;
    }
    c = (c ^ b).wrapping_sub(b.rotate_left(14));
    a = (a ^ c).wrapping_sub(c.rotate_left(11));
    b = (b ^ a).wrapping_sub(a.rotate_left(25));
    c = (c ^ b).wrapping_sub(b.rotate_left(16));
    a = (a ^ c).wrapping_sub(c.rotate_left(4));
    b = (b ^ a).wrapping_sub(a.rotate_left(14));
    (c ^ b).wrapping_sub(b.rotate_left(24))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hdf5_pure::{File, FileBuilder};

    #[test]
    fn a_layout_of_version_5_is_read_as_one_of_version_4_and_damage_stays_damage() {
        let mut file = FileBuilder::new();
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let data = file.create_dataset("t").with_f64_data(&values).with_shape(&[100]);
        data.with_chunks(&[7]).with_deflate(6);
        let older = file.finish().unwrap();
        // As HDF5 2.0 writes it.
        let mut newer = older.clone();
        let header = (0..older.len()).filter(|at| older[*at..].starts_with(b"OHDR"));
        let (raw, _) = Raw::open(&older).unwrap();
        let mut changed = 0;
        for message in header.flat_map(|at| raw.messages(at, &mut BTreeSet::new())) {
            if message.kind == LAYOUT && older[message.from] == READ {
                let summed = message.summed.unwrap();
                newer[message.from] = WRITTEN;
                put_checksum(&mut newer, summed);
                changed += 1;
            }
        }
        assert_eq!(changed, 1);
        let read = |bytes: &[u8]| {
            let file = File::from_bytes(bytes.to_vec()).map_err(|e| e.to_string())?;
            file.dataset("t").and_then(|data| data.read_f64()).map_err(|e| e.to_string())
        };
        assert!(read(&newer).unwrap_err().contains("layout version"));
        let mut damaged = newer.clone();
        make_older(&mut newer);
        assert_eq!((&newer, read(&newer)), (&older, Ok(values)));
        let at = (0..damaged.len()).find(|at| damaged[*at..].starts_with(b"OHDR")).unwrap();
        for place in at + 10..at + 60 {
            let before = damaged.clone();
            damaged[place] ^= 0x10;
            let mut read = damaged.clone();
            make_older(&mut read);
            assert_eq!(read.len(), damaged.len());
            damaged = before;
        }
    }

    #[test]
    fn the_checksum_is_that_of_its_author() {
        // The second is lookup3.c's own, `driver5`.
        assert_eq!(checksum(b""), 0xdead_beef);
        assert_eq!(checksum(b"Four score and seven years ago"), 0x1777_0551);
    }
}
