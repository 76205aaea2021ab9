//! Files of a few bytes that claim gigabytes: each is one error, and no memory is allocated for it.

use super::*;
use crate::{Files, Memory, RealFiles, read_parquet, write_table};
use arrow::array::{ArrayRef, BinaryArray, Float64Array, RecordBatch};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::properties::WriterProperties;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Thrift's compact protocol, as far as a footer needs it.
#[derive(Default)]
struct Thrift(Vec<u8>);

impl Thrift {
    fn varint(mut self, mut value: u64) -> Self {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
        self
    }

    /// The head of a field that lies `step` behind the one before it.
    fn field(mut self, step: u8, kind: u8) -> Self {
        self.0.push(step << 4 | kind);
        self
    }

    fn number(self, step: u8, kind: u8, value: i64) -> Self {
        self.field(step, kind).varint((value << 1 ^ value >> 63).cast_unsigned())
    }

    fn list(mut self, step: u8, kind: u8, length: u64) -> Self {
        self = self.field(step, LIST);
        self.0.push(LONG << 4 | kind);
        self.varint(length)
    }

    fn end(mut self) -> Self {
        self.0.push(0);
        self
    }

    /// An element of a schema: with a number of children, or a column of doubles that may be null.
    fn element(self, name: &str, children: Option<i64>) -> Self {
        let (step, mut this) = match children {
            None => (1, self.number(1, I32, 5).number(2, I32, 1).0), // a double, optional
            Some(_) => (4, self.0),
        };
        this.push(step << 4 | BINARY);
        this.push(u8::try_from(name.len()).unwrap());
        this.extend_from_slice(name.as_bytes());
        let this = Self(this);
        children.into_iter().fold(this, |this, n| this.number(1, I32, n)).end()
    }
}

/// A whole file with this footer and nothing else.
fn file(footer: &Thrift) -> Vec<u8> {
    let length = u32::try_from(footer.0.len()).unwrap().to_le_bytes();
    [MAGIC.as_slice(), &footer.0, &length, MAGIC].concat()
}

/// A footer of one column and no row group that claims these rows.
fn claims(rows: i64) -> Thrift {
    let schema = Thrift::default().number(1, I32, 1).list(1, STRUCT, 2);
    let schema = schema.element("schema", Some(1)).element("t_s", None);
    schema.number(1, I64, rows).list(1, STRUCT, 0).end()
}

/// What reading a file says that has these bytes.
fn error(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    RealFiles.write_synced(&path, bytes).unwrap();
    read_parquet(&path).unwrap_err().to_string()
}

#[test]
fn a_footer_that_claims_a_million_million_rows_is_refused_by_its_number() {
    let said = error(&file(&claims(1_000_000_000_000)));
    assert!(said.contains("claims 1000000000000 rows, and at most 33554432 are read"), "{said}");
    let said = error(&file(&claims(-1)));
    assert!(said.contains("claims -1 rows"), "{said}");
}

#[test]
fn a_list_of_more_row_groups_than_bytes_follow_is_damage() {
    let schema = Thrift::default().number(1, I32, 1).list(1, STRUCT, 1).element("schema", Some(0));
    let said = error(&file(&schema.number(1, I64, 1).list(1, STRUCT, 1 << 31)));
    assert!(said.contains("its footer is damaged"), "{said}");
}

#[test]
fn more_row_groups_than_their_numbers_can_count_are_refused() {
    let mut footer =
        Thrift::default().number(1, I32, 1).list(1, STRUCT, 1).element("schema", Some(0));
    footer = footer.number(1, I64, 1).list(1, STRUCT, 40_000);
    for _ in 0..40_000 {
        footer = footer.end();
    }
    assert!(error(&file(&footer.end())).contains("more than 32767 row groups"));
}

#[test]
fn columns_nested_without_end_are_refused_before_a_reader_calls_itself() {
    let mut schema = Thrift::default().number(1, I32, 1).list(1, STRUCT, 100_001);
    for _ in 0..100_000 {
        schema = schema.element("s", Some(1));
    }
    let footer = schema.element("t_s", None).number(1, I64, 1).list(1, STRUCT, 0).end();
    assert!(error(&file(&footer)).contains("nested more than 32 deep"));
}

#[test]
fn structures_within_structures_are_damage() {
    let mut footer = Thrift::default();
    for _ in 0..100_000 {
        footer = footer.field(9, STRUCT);
    }
    assert!(error(&file(&footer)).contains("its footer is damaged"));
}

#[test]
fn a_footer_longer_than_its_file_is_none() {
    let mut bytes = file(&claims(1));
    let at = bytes.len() - TAIL;
    bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(error(&bytes).contains("its end is missing"));
}

#[test]
fn more_columns_than_the_limit_are_refused() {
    let columns = (0..=MOST_COLUMNS).map(|i| {
        let values: ArrayRef = Arc::new(Float64Array::from(vec![1.0]));
        (format!("c{i}"), values)
    });
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let said = error(&packed(&batch));
    assert!(said.contains("claims 1025 columns, and at most 1024 are read"), "{said}");
}

/// A file of these columns, strongly packed and without our footer.
fn packed(batch: &RecordBatch) -> Vec<u8> {
    let zstd = Compression::ZSTD(ZstdLevel::try_new(3).unwrap());
    let properties =
        WriterProperties::builder().set_compression(zstd).set_dictionary_enabled(false).build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties)).unwrap();
    writer.write(batch).unwrap();
    writer.close().unwrap();
    bytes
}

#[test]
fn a_column_that_unpacks_to_more_than_the_limit_is_refused_before_it_is_unpacked() {
    let block = vec![0_u8; 1 << 20];
    let blocks: ArrayRef = Arc::new(BinaryArray::from_iter_values((0..70).map(|_| &block)));
    let bytes = packed(&RecordBatch::try_from_iter([("bomb", blocks)]).unwrap());
    assert!(bytes.len() < 1 << 20, "{} bytes are no bomb", bytes.len());
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(&bytes::Bytes::from(bytes.clone())).unwrap();
    let said = check_pages(&bytes, &metadata, |_| true).unwrap_err();
    assert!(said.contains("column bomb unpacks to more than 67108864 bytes"), "{said}");
    assert_eq!(check_pages(&bytes, &metadata, |_| false), Ok(0));
}

#[test]
fn row_groups_that_claim_other_rows_than_the_file_are_refused() {
    // A run of one value takes a few bytes whatever its length: the claim of the group alone
    // decides the memory.
    let values: ArrayRef = Arc::new(Float64Array::from(vec![1.0; 3]));
    let bytes = packed(&RecordBatch::try_from_iter([("x", values)]).unwrap());
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(&bytes::Bytes::from(bytes)).unwrap();
    assert!(check_size(Path::new("x"), &metadata, "").is_ok());
    let groups = metadata.row_groups();
    for claimed in
        [vec![1_000_000_000_000], vec![2], vec![-3], vec![i64::MIN, -1], vec![4, -1], vec![]]
    {
        let other = |n: &i64| groups[0].clone().into_builder().set_num_rows(*n).build().unwrap();
        let metadata = parquet::file::metadata::ParquetMetaDataBuilder::new(
            parquet::file::metadata::FileMetaData::new(
                1,
                3,
                None,
                None,
                groups[0].schema_descr_ptr(),
                None,
            ),
        )
        .set_row_groups(claimed.iter().map(other).collect())
        .build();
        let said = check_size(Path::new("x"), &metadata, "").unwrap_err().to_string();
        assert!(said.contains("claims 3 rows, and its row groups others"), "{said}");
    }
}

#[test]
fn a_file_of_ours_with_any_byte_of_its_tail_changed_is_an_error_or_the_same_and_takes_no_more_memory()
 {
    let values: ArrayRef = Arc::new(Float64Array::from(vec![1.0; 5]));
    let batch = RecordBatch::try_from_iter([("x", values)]).unwrap();
    let whole = write_table(&batch, BTreeMap::new(), Path::new("x.parquet")).unwrap();
    let memory = Memory::new();
    let here = Path::new("/x.parquet");
    for at in 0..whole.len() {
        for bit in [0, 3, 7] {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << bit;
            memory.put(here, &bytes);
            if let Ok(file) = crate::form::opened::ParquetFile::open(&memory, here) {
                assert_eq!(file.rows, 5);
            }
        }
    }
}

/// A file that is open for writing alone gives what a disk does that fails in the middle.
#[test]
fn a_file_that_the_system_does_not_give_is_not_called_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.parquet");
    let column = Arc::new(Float64Array::from(vec![1.0; 100])) as ArrayRef;
    let batch = RecordBatch::try_from_iter([("a", column)]).unwrap();
    let bytes = write_table(&batch, BTreeMap::new(), &path).unwrap();
    std::fs::write(&path, &bytes).unwrap();
    let metadata =
        ParquetMetaDataReader::new().parse_and_finish(&bytes::Bytes::from(bytes)).unwrap();
    let content = |file| Content::on_disk(file, std::fs::metadata(&path).unwrap().len());
    let pages = |content: &Content| check_pages_in(content, &metadata, MOST_COLUMN_BYTES, |_| true);
    let read = content(std::fs::File::open(&path).unwrap());
    assert!(check_footer_in(&read).is_ok() && pages(&read).is_ok());
    let refused = content(std::fs::File::options().append(true).open(&path).unwrap());
    assert!(matches!(check_footer_in(&refused), Err(Why::System(_))));
    assert!(matches!(pages(&refused), Err(Why::System(_))));
    let cut = Content::on_disk(std::fs::File::open(&path).unwrap(), 4);
    assert!(matches!(pages(&cut), Err(Why::Claim(what)) if what.contains("damaged")));
}
