use super::super::limits::tests::{numbers, only};
use super::super::table::{Cell, Cells, ColumnRef, Table};
use super::read;
use flate2::Crc;
use std::path::Path;
use zwidth_store::StoreError;

const WRENCH: &str = "std_msgs/Header header\ngeometry_msgs/Wrench wrench # the force\nint32 KIND=3\nfloat64[] extra\n\
    ================================================================================\nMSG: std_msgs/Header\n\
    builtin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\nMSG: geometry_msgs/Wrench\n\
    Vector3 force\nVector3 torque\n\
    ================================================================================\nMSG: geometry_msgs/Vector3\n\
    float64 x\nfloat64 y\nfloat64 z\n";

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn schema(id: u16, name: &str, encoding: &str, description: &str) -> Vec<u8> {
    record(3, &[id.to_le_bytes().to_vec(), text(name), text(encoding), text(description)].concat())
}

fn channel(id: u16, schema: u16, topic: &str, encoding: &str) -> Vec<u8> {
    let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
    record(4, &[ids, text(topic), text(encoding), vec![0; 4]].concat())
}

fn message(channel: u16, log_time: u64, data: &[u8]) -> Vec<u8> {
    let head = [
        &channel.to_le_bytes()[..],
        &[0; 4],
        &log_time.to_le_bytes(),
        &(log_time + 1).to_le_bytes(),
    ]
    .concat();
    record(5, &[&head, data].concat())
}

fn chunk(records: &[u8], packing: &str, packed: &[u8]) -> Vec<u8> {
    let mut crc = Crc::new();
    crc.update(records);
    let head =
        [&[0; 16][..], &(records.len() as u64).to_le_bytes(), &crc.sum().to_le_bytes()].concat();
    record(
        6,
        &[head, text(packing), (packed.len() as u64).to_le_bytes().to_vec(), packed.to_vec()]
            .concat(),
    )
}

fn file(records: &[u8]) -> Vec<u8> {
    let closing = [record(15, &[0; 4]), record(2, &[0; 20])].concat();
    [
        super::MAGIC,
        &record(1, &[text("ros2"), text("test")].concat()),
        records,
        &closing,
        super::MAGIC,
    ]
    .concat()
}

/// A wrench in CDR at a stamp, the lowest byte first or last.
fn wrench(big: bool, s: i32, ns: u32, frame: &str, force: [f64; 3], extra: &[f64]) -> Vec<u8> {
    let mut out = Vec::new();
    let four = |out: &mut Vec<u8>, number: u32| {
        out.resize(out.len().next_multiple_of(4), 0);
        out.extend(if big { number.to_be_bytes() } else { number.to_le_bytes() });
    };
    let eight = |out: &mut Vec<u8>, number: f64| {
        out.resize(out.len().next_multiple_of(8), 0);
        out.extend(if big { number.to_be_bytes() } else { number.to_le_bytes() });
    };
    four(&mut out, s as u32);
    four(&mut out, ns);
    four(&mut out, frame.len() as u32 + 1);
    out.extend(frame.as_bytes());
    out.push(0);
    force.iter().for_each(|value| eight(&mut out, *value));
    [0.0; 3].iter().for_each(|value| eight(&mut out, *value));
    four(&mut out, extra.len() as u32);
    extra.iter().for_each(|value| eight(&mut out, *value));
    [vec![0, u8::from(!big), 0, 0], out].concat()
}

const SECOND: u64 = 1_000_000_000;

/// A file of two wrenches.
pub(in super::super) fn of_two_wrenches() -> Vec<u8> {
    let messages = [
        message(1, 100 * SECOND, &wrench(false, 5, 250, "tool", [1.0, 2.0, 3.0], &[7.0])),
        message(1, 101 * SECOND, &wrench(true, 6, 500, "", [-1.0, -2.0, -3.0], &[])),
    ];
    let records = [
        schema(1, "geometry_msgs/msg/WrenchStamped", "ros2msg", WRENCH),
        channel(1, 1, "/force", "cdr"),
        messages.concat(),
    ];
    file(&records.concat())
}

/// The same by a recorder that was killed at the second.
pub(in super::super) fn killed() -> Vec<u8> {
    let whole = of_two_wrenches();
    whole[..whole.len() - 60].to_vec()
}

fn table_of(bytes: &[u8], topic: Option<&str>, columns: &[&str]) -> Result<Table, StoreError> {
    only(columns, |take| read(Path::new("a.mcap"), bytes, topic, take))
}

#[test]
fn a_message_is_a_row_of_its_values_by_path_in_both_orders_of_bytes() {
    let names = [
        "header.stamp",
        "header.frame_id",
        "wrench.force.x",
        "wrench.force.z",
        "extra[0]",
        "log_time",
    ];
    let table = table_of(&of_two_wrenches(), None, &names).unwrap();
    let some = |values: [f64; 2]| values.map(Some).to_vec();
    assert_eq!(numbers(&table, "wrench.force.x"), some([1.0, -1.0]));
    assert_eq!(numbers(&table, "wrench.force.z"), some([3.0, -3.0]));
    assert_eq!(numbers(&table, "header.stamp"), some([5_000_000_250.0, 6_000_000_500.0]));
    assert_eq!(numbers(&table, "log_time"), some([100e9, 101e9]));
    // A list may be shorter in another message.
    assert_eq!(numbers(&table, "extra[0]"), [Some(7.0), None]);
    let place = table.find(&ColumnRef::Name("header.frame_id".to_owned())).unwrap();
    assert_eq!([0, 1].map(|row| table.columns[place].cell(row)), [Cell::Text("tool"), Cell::Empty]);
    assert!(table.units.values().all(|unit| unit.unit == "ns" && unit.is_type));
    assert!(table.lost.is_none());
}

#[test]
fn chunks_are_unpacked_and_a_damaged_one_is_told() {
    let whole = of_two_wrenches();
    let begin = super::MAGIC.len() + record(1, &[text("ros2"), text("test")].concat()).len();
    let end =
        whole.len() - super::MAGIC.len() - record(15, &[0; 4]).len() - record(2, &[0; 20]).len();
    let records = &whole[begin..end];
    let lz4 = {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        std::io::Write::write_all(&mut encoder, records).unwrap();
        encoder.finish().unwrap()
    };
    let zstd = zstd::stream::encode_all(records, 0).unwrap();
    for (packing, packed) in [("", records), ("zstd", &zstd), ("lz4", &lz4)] {
        let table =
            table_of(&file(&chunk(records, packing, packed)), None, &["wrench.force.y"]).unwrap();
        assert_eq!(numbers(&table, "wrench.force.y"), [Some(2.0), Some(-2.0)], "{packing}");
        // Another sum than that of its records.
        let mut damaged = file(&[chunk(records, packing, packed), records.to_vec()].concat());
        damaged[begin + 9 + 24] ^= 1;
        let table = table_of(&damaged, None, &["wrench.force.y"]).unwrap();
        assert!(table.lost.as_ref().unwrap().contains("is damaged"), "{:?}", table.lost);
        assert_eq!(numbers(&table, "wrench.force.y").len(), 2);
    }
    let mut only = file(&chunk(records, "zstd", &zstd));
    only[begin + 9 + 24] ^= 1;
    let error = table_of(&only, Some("/force"), &["x"]).unwrap_err().to_string();
    assert!(error.contains("the chunk at byte") && error.contains("is damaged"), "{error}");
    let error =
        table_of(&file(&chunk(records, "snappy", records)), None, &["x"]).unwrap_err().to_string();
    assert!(error.contains("packed by 'snappy'"), "{error}");
    let mut huge = chunk(records, "zstd", &zstd);
    huge[9 + 16..9 + 24].copy_from_slice(&u64::MAX.to_le_bytes());
    let error = table_of(&file(&huge), None, &["x"]).unwrap_err().to_string();
    assert!(error.contains("unpacks to more than"), "{error}");
}

#[test]
fn a_recorder_that_was_killed_leaves_all_but_its_last_record() {
    let whole = of_two_wrenches();
    let end =
        whole.len() - super::MAGIC.len() - record(15, &[0; 4]).len() - record(2, &[0; 20]).len();
    // Without the end: nothing is missing; within the last message: that is.
    let table = table_of(&whole[..end], None, &["wrench.force.x"]).unwrap();
    assert_eq!((numbers(&table, "wrench.force.x").len(), &table.lost), (2, &None));
    let table = table_of(&whole[..end - 5], None, &["wrench.force.x"]).unwrap();
    assert_eq!(numbers(&table, "wrench.force.x"), [Some(1.0)]);
    assert!(table.lost.as_ref().unwrap().contains("hold no whole record"), "{:?}", table.lost);
}

#[test]
fn json_is_read_by_path_too_and_numbers_without_decimals_are_numbers() {
    let data = [
        r#"{"t":1,"f":{"x":1,"y":"a"},"l":[1,2]}"#,
        r#"{"t":1764500000123456789,"f":{"x":1.5,"y":"b"},"l":[3,null]}"#,
    ];
    let messages = data.iter().zip(1..).map(|(data, at)| message(1, at, data.as_bytes()));
    let records = [
        schema(1, "F", "jsonschema", "{}"),
        channel(1, 1, "f", "json"),
        messages.collect::<Vec<_>>().concat(),
    ];
    let table =
        table_of(&file(&records.concat()), Some("f"), &["t", "f.x", "f.y", "l[1]"]).unwrap();
    assert_eq!(numbers(&table, "f.x"), [Some(1.0), Some(1.5)]);
    assert_eq!(numbers(&table, "l[1]"), [Some(2.0), None]);
    let place = table.find(&ColumnRef::Name("t".to_owned())).unwrap();
    assert_eq!(table.columns[place].cell(1), Cell::Text("1764500000123456789"), "no digit is lost");
}

#[test]
fn a_topic_must_be_meant_and_written_in_a_form_that_is_read() {
    let two = [
        channel(1, 0, "a", "json"),
        channel(2, 0, "b", "json"),
        message(1, 0, b"{}"),
        message(2, 0, b"{}"),
    ];
    let one = |channel: Vec<u8>, schema: Vec<u8>| {
        file(&[schema, channel, message(1, 0, &[0, 1, 0, 0])].concat())
    };
    for (bytes, topic, words) in [
        (file(&two.concat()), None, "2 topics have messages: 'a', 'b'"),
        (file(&two.concat()), Some("c"), "no message is of topic 'c'; the file has 'a', 'b'"),
        (file(&[]), None, "the file has no messages"),
        (one(channel(1, 0, "a", "ros1"), Vec::new()), None, "those of ROS 1"),
        (
            one(channel(1, 1, "a", "protobuf"), schema(1, "F", "protobuf", "")),
            None,
            "'protobuf', described by 'protobuf'",
        ),
        (
            one(channel(1, 1, "a", "cdr"), schema(1, "p/msg/F", "ros2msg", "wstring s\n")),
            None,
            "wide letters",
        ),
        (b"XX".to_vec(), None, "does not begin as one"),
    ] {
        let error = table_of(&bytes, topic, &["x"]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // Shorter than its definition: told, and its row has no values.
    let short = one(channel(1, 1, "a", "cdr"), schema(1, "p/msg/F", "ros2msg", "float64 x\n"));
    let table = table_of(&short, None, &["x", "log_time"]).unwrap();
    assert_eq!(table.lost.as_deref(), Some("1 messages are not as their description says"));
}

#[test]
fn long_lists_are_no_columns_and_a_message_without_fields_has_a_byte() {
    let definition = "p/None nothing\nuint8[] picture\nfloat64 after\n===\nMSG: p/None\n";
    let picture = [
        vec![0, 1, 0, 0, 9, 0, 0, 0],
        1000_u32.to_le_bytes().to_vec(),
        vec![1; 1000],
        2.5_f64.to_le_bytes().to_vec(),
    ]
    .concat();
    let records = [
        schema(1, "p/msg/P", "ros2msg", definition),
        channel(1, 1, "a", "cdr"),
        message(1, 0, &picture),
    ];
    let table = table_of(&file(&records.concat()), None, &["picture", "after"]).unwrap();
    assert_eq!(numbers(&table, "after"), [Some(2.5)]);
    assert!(
        table
            .columns
            .iter()
            .any(|cells| matches!(cells, Cells::Other(why) if why.contains("1000 values")))
    );
}

#[test]
fn no_damage_of_a_byte_ends_the_program() {
    let whole = of_two_wrenches();
    for at in 0..whole.len() {
        for byte in [0, 1, 0x7F, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            let _: Result<Table, StoreError> =
                table_of(&bytes, None, &["header.stamp", "wrench.force.x", "extra[0]"]);
        }
    }
}
