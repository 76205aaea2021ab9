//! A header and the contents of files as one text of bytes: what goes to an executor and what comes
//! back.
//!
//! The length of the header (8 bytes, little endian) and the header as JSON; then for each content
//! its length and its bytes.

use anyhow::{Context as _, ensure};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Puts a header and contents together.
pub(crate) fn pack(header: &impl Serialize, contents: &[Vec<u8>]) -> anyhow::Result<Vec<u8>> {
    let header = serde_json::to_vec(header)?;
    let mut packed = Vec::new();
    for part in std::iter::once(&header).chain(contents) {
        packed.extend((part.len() as u64).to_le_bytes());
        packed.extend(part);
    }
    Ok(packed)
}

/// Takes them apart again.
///
/// # Errors
/// Bytes that [`pack`] has not written.
pub(crate) fn unpack<H: DeserializeOwned>(packed: &[u8]) -> anyhow::Result<(H, Vec<Vec<u8>>)> {
    let mut rest = packed;
    let header = serde_json::from_slice(next(&mut rest)?).context("its header is damaged")?;
    let mut contents = Vec::new();
    while !rest.is_empty() {
        contents.push(next(&mut rest)?.to_vec());
    }
    Ok((header, contents))
}

fn next<'b>(rest: &mut &'b [u8]) -> anyhow::Result<&'b [u8]> {
    let (length, behind) = rest.split_first_chunk::<8>().context("it ends within a length")?;
    let length = u64::from_le_bytes(*length);
    ensure!(length <= behind.len() as u64, "it ends {length} bytes too early");
    let (part, behind) = behind.split_at(usize::try_from(length)?);
    *rest = behind;
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_packed_comes_out_again_and_nothing_else_does() {
        let contents = vec![b"one".to_vec(), Vec::new(), vec![0, 255]];
        let packed = pack(&"header", &contents).unwrap();
        assert_eq!(unpack::<String>(&packed).unwrap(), ("header".to_owned(), contents.clone()));
        for length in 0..packed.len() {
            let cut = unpack::<String>(&packed[..length]);
            assert!(cut.is_err() || cut.unwrap().1.len() < contents.len(), "{length}");
        }
        let mut long = packed;
        long[7] = 255;
        assert!(unpack::<String>(&long).is_err());
    }
}
