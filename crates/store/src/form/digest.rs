//! The digest of a column, value by value.

use crate::Storage;

/// Values that are narrowed at a time.
const AT_ONCE: usize = 1 << 12;

/// The digest of a column as its values come.
#[derive(Debug)]
pub(crate) struct ColumnDigest {
    hasher: blake3::Hasher,
    storage: Storage,
}

impl ColumnDigest {
    pub(crate) fn new(storage: Storage) -> Self {
        Self { hasher: blake3::Hasher::new(), storage }
    }

    /// Takes the next values, as they come back from the file.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn add(&mut self, values: &[f64]) {
        if self.storage != Storage::F32 {
            self.take(values);
            return;
        }
        for values in values.chunks(AT_ONCE) {
            let narrow: Vec<f64> = values.iter().map(|v| f64::from(*v as f32)).collect();
            self.take(&narrow);
        }
    }

    /// The bytes of values, each with its lowest first.
    fn take(&mut self, values: &[f64]) {
        if cfg!(target_endian = "little") {
            self.hasher.update(bytemuck::cast_slice(values));
            return;
        }
        for value in values {
            self.hasher.update(&value.to_le_bytes());
        }
    }

    /// The digest of all, hexadecimal.
    pub(crate) fn end(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// Digest of a column's values as they come back from the file.
pub(crate) fn column_digest(values: &[f64], storage: Storage) -> String {
    let mut digest = ColumnDigest::new(storage);
    digest.add(values);
    digest.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_one_digest_however_it_comes() {
        let values: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 0.1).collect();
        for storage in [Storage::F64, Storage::F32] {
            let mut parts = ColumnDigest::new(storage);
            values.chunks(777).for_each(|part| parts.add(part));
            assert_eq!(parts.end(), column_digest(&values, storage));
        }
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(column_digest(&values, Storage::F64), crate::hex_blake3(&bytes));
    }
}
