//! How the columns of a Parquet file are compressed: an error names an unsupported codec, instead
//! of calling it damage.

use crate::StoreError;
use parquet::basic::CompressionCodec;
use parquet::file::metadata::ParquetMetaData;
use std::path::Path;

/// Checks that every column of a Parquet file is compressed in a way that this program reads.
///
/// # Errors
/// The first column that is not, with what it is compressed with and what to do.
pub fn check_codecs(path: &Path, metadata: &ParquetMetaData) -> Result<(), StoreError> {
    let mut columns = metadata.row_groups().iter().flat_map(|group| group.columns());
    let unread = columns
        .find_map(|c| unread(c.compression_codec()).map(|name| (c.column_path().string(), name)));
    unread.map_or(Ok(()), |(column, name)| {
        let what = format!("compressed with {name}, which this program does not read");
        Err(StoreError::new(path, what, "write it anew with zstd, snappy or none").column(column))
    })
}

/// The name of a compression that is not read.
fn unread(codec: CompressionCodec) -> Option<&'static str> {
    match codec {
        CompressionCodec::UNCOMPRESSED | CompressionCodec::SNAPPY | CompressionCodec::ZSTD => None,
        CompressionCodec::GZIP => Some("gzip"),
        CompressionCodec::LZO => Some("LZO"),
        CompressionCodec::BROTLI => Some("Brotli"),
        CompressionCodec::LZ4 => Some("LZ4 (Hadoop's framing)"),
        CompressionCodec::LZ4_RAW => Some("LZ4"),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::form::read::tests::written;
    use crate::form::write::write_parquet;
    use crate::{Signal, TableParts, read_footer, read_parquet, read_trial};
    use arrow::array::{ArrayRef, Float64Array, RecordBatch};
    use bytes::Bytes;
    use parquet::file::metadata::{ParquetMetaDataReader, ParquetMetaDataWriter, RowGroupMetaData};
    use std::sync::Arc;

    /// A Parquet file's bytes, its footer saying that every column is compressed with `codec`.
    pub(crate) fn said_to_be(bytes: &[u8], codec: CompressionCodec) -> Vec<u8> {
        let file = Bytes::copy_from_slice(bytes);
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let group = |group: &RowGroupMetaData| {
            let column = |c: &parquet::file::metadata::ColumnChunkMetaData| {
                c.clone().into_builder().set_compression_codec(codec).build().unwrap()
            };
            let columns = group.columns().iter().map(column).collect();
            group.clone().into_builder().set_column_metadata(columns).build().unwrap()
        };
        let groups = metadata.row_groups().iter().map(group).collect();
        let metadata = metadata.into_builder().set_row_groups(groups).build();
        let mut changed = bytes.to_vec();
        ParquetMetaDataWriter::new(&mut changed, &metadata).finish().unwrap();
        changed
    }

    fn check(codec: CompressionCodec, expect: Option<&str>) {
        let f: ArrayRef = Arc::new(Float64Array::from(vec![0.5, 1.5]));
        let batch = RecordBatch::try_from_iter([("f", f)]).unwrap();
        let written = write_parquet(&batch, Default::default(), Path::new("a.parquet")).unwrap();
        let file = Bytes::from(said_to_be(&written, codec));
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).unwrap();
        let found = check_codecs(Path::new("a.parquet"), &metadata).err().map(|e| e.to_string());
        let words = |name: &str| {
            format!(
                "a.parquet, column f: compressed with {name}, which this program does not read; \
                 write it anew with zstd, snappy or none"
            )
        };
        assert_eq!(found, expect.map(words));
    }

    #[test]
    fn what_is_compressed_in_a_way_that_is_not_read_is_named_with_its_column() {
        check(CompressionCodec::GZIP, Some("gzip"));
        check(CompressionCodec::BROTLI, Some("Brotli"));
        check(CompressionCodec::LZ4, Some("LZ4 (Hadoop's framing)"));
        check(CompressionCodec::LZ4_RAW, Some("LZ4"));
        check(CompressionCodec::LZO, Some("LZO"));
    }

    #[test]
    fn what_is_read_passes() {
        check(CompressionCodec::ZSTD, None);
        check(CompressionCodec::SNAPPY, None);
        check(CompressionCodec::UNCOMPRESSED, None);
    }

    #[test]
    fn a_file_compressed_with_what_is_not_read_is_named_so_and_not_called_damaged() {
        let (_folder, _, path) = written();
        let bytes = std::fs::read(&path).unwrap();
        let codecs = [
            ("gzip", CompressionCodec::GZIP),
            ("Brotli", CompressionCodec::BROTLI),
            ("LZ4", CompressionCodec::LZ4_RAW),
        ];
        for (name, codec) in codecs {
            std::fs::write(&path, said_to_be(&bytes, codec)).unwrap();
            let words = format!("compressed with {name}, which this program does not read");
            for error in [
                read_trial(&path, Signal::all()).unwrap_err(),
                read_footer(&path).unwrap_err(),
                read_parquet(&path).unwrap_err(),
                TableParts::open(&path, Some(&["t_s"])).map(drop).unwrap_err(),
            ] {
                assert_eq!(error.what, words);
                assert_eq!(error.column.as_deref(), Some("t_s"));
            }
        }
    }
}
