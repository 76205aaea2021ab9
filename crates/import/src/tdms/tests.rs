use super::super::limits::tests::only;
use super::super::limits::{Budget, Take};
use super::super::table::{Cell, Cells, ColumnRef, Table};
use super::read;
use std::path::Path;
use zwidth_store::StoreError;

/// The value of a property.
pub(in super::super) enum Value<'a> {
    F64(f64),
    U32(u32),
    Text(&'a str),
    Moment(i64, u64),
}

/// Bytes of numbers in one order.
#[derive(Clone, Copy)]
struct Order {
    big: bool,
}

impl Order {
    fn word(self, number: u32) -> Vec<u8> {
        if self.big { number.to_be_bytes() } else { number.to_le_bytes() }.to_vec()
    }
    fn long(self, number: u64) -> Vec<u8> {
        if self.big { number.to_be_bytes() } else { number.to_le_bytes() }.to_vec()
    }
    fn text(self, text: &str) -> Vec<u8> {
        [self.word(text.len() as u32), text.as_bytes().to_vec()].concat()
    }
    fn property(self, (name, value): &(String, Value)) -> Vec<u8> {
        let (kind, bytes) = match value {
            Value::F64(number) => (0x0A, self.long(number.to_bits())),
            Value::U32(number) => (0x07, self.word(*number)),
            Value::Text(text) => (0x20, self.text(text)),
            Value::Moment(s, fraction) if self.big => {
                (0x44, [self.long(*s as u64), self.long(*fraction)].concat())
            }
            Value::Moment(s, fraction) => {
                (0x44, [self.long(*fraction), self.long(*s as u64)].concat())
            }
        };
        [self.text(name), self.word(kind), bytes].concat()
    }
}

/// An object as a segment describes it: its path, the type and number of its values in a chunk, or none, and its
/// properties.
type Described<'a> = (&'a str, Option<(u32, u64)>, Vec<(String, Value<'a>)>);

/// A segment of these objects and values; `flags` are added to its table of contents.
fn segment(flags: u32, objects: &[Described], raw: &[u8]) -> Vec<u8> {
    let order = Order { big: flags & (1 << 6) != 0 };
    let mut described = order.word(objects.len() as u32);
    for (path, index, properties) in objects {
        described.extend(order.text(path));
        match index {
            Some((kind, values)) => {
                described.extend([order.word(20), order.word(*kind), order.word(1)].concat());
                described.extend(order.long(*values));
            }
            None => described.extend(order.word(u32::MAX)),
        }
        described.extend(order.word(properties.len() as u32));
        described.extend(properties.iter().flat_map(|property| order.property(property)));
    }
    if objects.is_empty() {
        described.clear();
    }
    let toc = flags
        | if objects.is_empty() { 0 } else { 1 << 1 }
        | if raw.is_empty() { 0 } else { 1 << 3 };
    let next = (described.len() + raw.len()) as u64;
    let lead_in = [
        toc.to_le_bytes().to_vec(),
        order.word(4713),
        order.long(next),
        order.long(described.len() as u64),
    ];
    [b"TDSm".to_vec(), lead_in.concat(), described, raw.to_vec()].concat()
}

const NEW: u32 = 1 << 2;
const INTERLEAVED: u32 = 1 << 5;
const BIG: u32 = 1 << 6;

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn named(name: &str, value: Value<'static>) -> (String, Value<'static>) {
    (name.to_owned(), value)
}

/// Properties of a waveform of this step.
fn every(step: f64) -> Vec<(String, Value<'static>)> {
    vec![named("wf_increment", Value::F64(step)), named("wf_start_offset", Value::F64(0.0))]
}

/// A file of an angle and a force in a group.
pub(in super::super) fn of_two(step: f64, angle: &[f64], force: &[f64]) -> Vec<u8> {
    let channel = |path, values: &[f64]| (path, Some((0x0A, values.len() as u64)), every(step));
    let objects = [channel("/'rig'/'angle'", angle), channel("/'rig'/'F'", force)];
    segment(NEW, &objects, &[doubles(angle), doubles(force)].concat())
}

/// A file of a fast force and a slow angle, in groups of their own.
pub(in super::super) fn of_two_rates() -> Vec<u8> {
    let channel = |path, values, step| (path, Some((0x0A, values)), every(step));
    let objects = [channel("/'fast'/'F'", 4, 0.001), channel("/'slow'/'angle'", 2, 0.01)];
    segment(NEW, &objects, &doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
}

fn table_of(bytes: &[u8], group: Option<&str>, columns: &[&str]) -> Result<Table, StoreError> {
    only(columns, |take| read(Path::new("a.tdms"), bytes, group, take))
}

fn numbers(table: &Table, name: &str) -> Vec<f64> {
    let numbers = super::super::limits::tests::numbers(table, name);
    numbers.into_iter().map(Option::unwrap).collect()
}

fn error(bytes: &[u8], group: Option<&str>, columns: &[&str]) -> String {
    table_of(bytes, group, columns).unwrap_err().to_string()
}

#[test]
fn channels_of_a_group_come_with_their_times_however_the_segments_lie() {
    let two = ["time_s", "angle", "F"];
    let check = |bytes: &[u8]| {
        let table = table_of(bytes, None, &two).unwrap();
        assert_eq!(numbers(&table, "time_s"), [0.0, 0.5, 1.0, 1.5]);
        assert_eq!(numbers(&table, "angle"), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(numbers(&table, "F"), [-1.0, -2.0, -3.0, -4.0]);
        assert_eq!(table.lost, None);
    };
    check(&of_two(0.5, &[1.0, 2.0, 3.0, 4.0], &[-1.0, -2.0, -3.0, -4.0]));
    // Chunks that follow each other in a segment, and a segment that says nothing new.
    let chunks = [doubles(&[1.0, 2.0, -1.0, -2.0]), doubles(&[3.0, 4.0, -3.0, -4.0])];
    let channel = |path| (path, Some((0x0A, 2)), every(0.5));
    let objects = || [channel("/'rig'/'angle'"), channel("/'rig'/'F'")];
    check(&segment(NEW, &objects(), &chunks.concat()));
    check(&[segment(NEW, &objects(), &chunks[0]), segment(0, &[], &chunks[1])].concat());
    // Values side by side, and the highest byte first.
    let rows = doubles(&[1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0]);
    check(&segment(NEW | INTERLEAVED, &objects(), &rows));
    let turned: Vec<u8> =
        rows.as_chunks::<8>().0.iter().flat_map(|eight| eight.iter().rev().copied()).collect();
    check(&segment(NEW | INTERLEAVED | BIG, &objects(), &turned));
}

#[test]
fn a_channel_that_a_later_segment_leaves_out_keeps_its_values_and_the_others_go_on() {
    let first = of_two(0.5, &[1.0], &[-1.0]);
    // Without a new list: F has no values here, and angle as many as before.
    let second = segment(0, &[("/'rig'/'F'", None, Vec::new())], &doubles(&[2.0]));
    let bytes = [first, second].concat();
    let table = table_of(&bytes, None, &["angle", "F"]).unwrap();
    assert_eq!((numbers(&table, "angle"), numbers(&table, "F")), (vec![1.0, 2.0], vec![-1.0]));
}

#[test]
fn whole_numbers_texts_truths_and_moments_are_read() {
    let texts = |lines: &[&str]| {
        let ends = lines.iter().scan(0_u32, |end, line| {
            *end += line.len() as u32;
            Some(end.to_le_bytes())
        });
        [ends.flatten().collect::<Vec<u8>>(), lines.concat().into_bytes()].concat()
    };
    let objects = [
        ("/'g'/'n'", Some((0x02, 2)), Vec::new()),
        ("/'g'/'it''s'", Some((0x21, 2)), Vec::new()),
        ("/'g'/'when'", Some((0x44, 2)), Vec::new()),
    ];
    let moments = [(1_u64 << 63, 5_i64), (0, 6)]
        .map(|(fraction, s)| [fraction.to_le_bytes(), s.to_le_bytes()].concat());
    let raw = [vec![0xFE, 0xFF, 3, 0], vec![1, 0], moments.concat()].concat();
    let bytes = segment(NEW, &objects, &raw);
    let table = table_of(&bytes, Some("g"), &["n", "it's", "when"]).unwrap();
    assert_eq!((numbers(&table, "n"), numbers(&table, "it's")), (vec![-2.0, 3.0], vec![1.0, 0.0]));
    assert_eq!(numbers(&table, "when"), [5.5e9, 6e9]);
    assert_eq!(table.units[&3].unit, "ns");
    // A text's index names its bytes too.
    let raw = texts(&["ab", "", "ö"]);
    let mut bytes = segment(NEW, &[("/'g'/'who'", Some((0x20, 3)), Vec::new())], &raw);
    let place = bytes.windows(8).position(|eight| eight == 3_u64.to_le_bytes()).unwrap() + 8;
    bytes.splice(place..place, (raw.len() as u64).to_le_bytes());
    for at in [12, 20] {
        let length = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) + 8;
        bytes[at..at + 8].copy_from_slice(&length.to_le_bytes());
    }
    let table = table_of(&bytes, None, &["who"]).unwrap();
    let cells = [0, 1, 2].map(|row| table.columns[1].cell(row));
    assert_eq!(cells, [Cell::Text("ab"), Cell::Empty, Cell::Text("ö")]);
}

#[test]
fn counts_are_scaled_by_the_scales_that_the_file_names() {
    let of = |properties: Vec<(String, Value<'static>)>| {
        let raw: Vec<u8> = [10_i16, -20].iter().flat_map(|count| count.to_le_bytes()).collect();
        segment(NEW, &[("/'g'/'F'", Some((0x02, 2)), properties)], &raw)
    };
    let linear = |i: u32, source: u32, slope: f64, intercept: f64| {
        vec![
            named(&format!("NI_Scale[{i}]_Scale_Type"), Value::Text("Linear")),
            named(&format!("NI_Scale[{i}]_Linear_Slope"), Value::F64(slope)),
            named(&format!("NI_Scale[{i}]_Linear_Y_Intercept"), Value::F64(intercept)),
            named(&format!("NI_Scale[{i}]_Linear_Input_Source"), Value::U32(source)),
        ]
    };
    let scaled = |properties: Vec<(String, Value<'static>)>| {
        let table = table_of(&of(properties), None, &["F"]).unwrap();
        numbers(&table, "F")
    };
    let half = || linear(0, u32::MAX, 0.5, 1.0);
    assert_eq!(scaled(half()), [6.0, -9.0]);
    let two = [half(), linear(1, 0, 10.0, 0.0), vec![named("NI_Number_Of_Scales", Value::U32(2))]];
    assert_eq!(scaled(two.into_iter().flatten().collect()), [60.0, -90.0]);
    // What was scaled already stays as it is.
    let status = named("NI_Scaling_Status", Value::Text("scaled"));
    assert_eq!(scaled(half().into_iter().chain([status]).collect()), [10.0, -20.0]);
    let of_type = |kind| named("NI_Scale[0]_Scale_Type", Value::Text(kind));
    let polynomial = (0..3).map(|i| {
        named(&format!("NI_Scale[0]_Polynomial_Coefficients[{i}]"), Value::F64([1.0, 0.0, 2.0][i]))
    });
    let size = named("NI_Scale[0]_Polynomial_Coefficients_Size", Value::U32(3));
    let properties = polynomial.chain([of_type("Polynomial"), size]).collect();
    assert_eq!(scaled(properties), [201.0, 801.0]);
    let table = [("Pre_Scaled", [20.0, 0.0, -10.0]), ("Scaled", [4.0, 0.0, 1.0])];
    let table = table.into_iter().flat_map(|(of, values)| {
        let values = (0..3).map(move |i| {
            named(&format!("NI_Scale[0]_Table_{of}_Values[{i}]"), Value::F64(values[i]))
        });
        values.chain([named(&format!("NI_Scale[0]_Table_{of}_Values_Size"), Value::U32(3))])
    });
    // Within the curve by a straight line, and level past its end.
    assert_eq!(scaled(table.chain([of_type("Table")]).collect()), [2.0, 1.0]);
    for (properties, words) in [
        (vec![of_type("Strain")], "their scale 'Strain' is not computed here"),
        (vec![of_type("Linear")], "its scale 0 lacks NI_Scale[0]_Linear_Slope"),
        (linear(0, 0, 1.0, 0.0), "its scale 0 takes what scale 0 gives, which comes later"),
        (vec![named("NI_Number_Of_Scales", Value::U32(99))], "it has 99 scales"),
    ] {
        let table = table_of(&of(properties), None, &["F"]).unwrap();
        assert!(matches!(&table.columns[1], Cells::Other(why) if why.contains(words)), "{words}");
    }
}

#[test]
fn channels_of_several_groups_and_rates_are_never_put_on_each_others_times() {
    let bytes = of_two_rates();
    let table = table_of(&bytes, None, &["time_s", "fast/F", "slow/angle"]).unwrap();
    let why = "'fast/F' and 'slow/angle' have not the same times (1000 Hz from 0 s on; 100 Hz from 0 s on)";
    assert!(
        matches!(&table.columns[0], Cells::Other(what) if what.starts_with(why)),
        "{:?}",
        table.columns[0]
    );
    let table = table_of(&bytes, Some("slow"), &["time_s", "angle"]).unwrap();
    assert_eq!(numbers(&table, "time_s"), [0.0, 0.01]);
    let words = error(&bytes, Some("none"), &["F"]);
    assert!(
        words.contains("no group 'none' with channels; the file has 'fast', 'slow'"),
        "{words}"
    );
}

#[test]
fn a_rate_without_a_start_is_a_rate_and_a_second_start_is_told() {
    let start = |s| named("wf_start_time", Value::Moment(s, 0));
    let step = || named("wf_increment", Value::F64(0.25));
    let one = |properties| {
        segment(NEW, &[("/'g'/'F'", Some((0x0A, 2)), properties)], &doubles(&[1.0, 2.0]))
    };
    let table = table_of(&one(vec![step()]), None, &["time_s", "F"]).unwrap();
    assert_eq!(numbers(&table, "time_s"), [0.0, 0.25]);
    assert!(table.doubts.is_empty());
    let bytes = [one(vec![step(), start(100)]), one(vec![step(), start(200)])].concat();
    let table = table_of(&bytes, None, &["time_s", "F"]).unwrap();
    assert!(table.doubts[0].contains("begins anew within the file"), "{:?}", table.doubts);
    let table = table_of(&one(Vec::new()), None, &["time_s", "F"]).unwrap();
    assert!(matches!(&table.columns[0], Cells::Other(why) if why.contains("has no wf_increment")));
}

#[test]
fn a_file_that_was_never_closed_is_read_as_far_as_whole_rows_go() {
    let whole = of_two(0.5, &[1.0, 2.0, 3.0], &[-1.0, -2.0, -3.0]);
    let mut open = whole.clone();
    open[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    let cut = |bytes: &[u8], less: usize| bytes[..bytes.len() - less].to_vec();
    for (bytes, rows, words) in [
        (open.clone(), 3, None),
        (cut(&open, 4), 2, Some("the last 12 bytes of the segment at byte 1 hold no whole row")),
        (cut(&whole, 8), 2, Some("the file is cut off: its last segment lacks 8 bytes")),
        ([whole.clone(), b"junk".to_vec()].concat(), 3, Some("the bytes from")),
        ([whole.clone(), whole[..40].to_vec()].concat(), 3, Some("is cut off in its description")),
    ] {
        let table = table_of(&bytes, None, &["angle", "F"]).unwrap();
        assert_eq!((numbers(&table, "angle").len(), numbers(&table, "F").len()), (rows, rows));
        assert_eq!(table.lost.is_some(), words.is_some());
        assert!(
            words.is_none_or(|words| table.lost.as_ref().unwrap().contains(words)),
            "{:?}",
            table.lost
        );
    }
}

#[test]
fn what_nothing_can_be_made_of_is_refused() {
    let daqmx =
        segment(NEW | 1 << 7, &[("/'g'/'F'", Some((0x0A, 1)), Vec::new())], &doubles(&[1.0]));
    for (bytes, words) in [
        (daqmx, "its values are those of DAQmx"),
        (b"TDSh".to_vec(), "does not begin with 'TDSm'"),
        (segment(NEW, &[("/'g'/'F'", Some((0x99, 1)), Vec::new())], b"1"), "unknown type, 0x99"),
        (segment(NEW, &[("g", Some((0x0A, 1)), Vec::new())], b"1"), "'g' is no path"),
        (
            segment(NEW, &[("/'g'/'F'", Some((0x0A, u64::MAX)), Vec::new())], b"1"),
            "claims more values",
        ),
        (
            segment(
                INTERLEAVED,
                &[
                    ("/'g'/'a'", Some((0x0A, 1)), Vec::new()),
                    ("/'g'/'b'", Some((0x0A, 2)), Vec::new()),
                ],
                &doubles(&[1.0, 2.0, 3.0]),
            ),
            "not the same number of values",
        ),
    ] {
        let found = error(&bytes, None, &["F"]);
        assert!(found.contains(words), "{found}");
    }
    let mut texts =
        segment(NEW, &[("/'g'/'who'", Some((0x20, u64::MAX)), Vec::new())], b"12345678");
    let place = texts.windows(8).position(|eight| eight == u64::MAX.to_le_bytes()).unwrap() + 8;
    texts.splice(place..place, 8_u64.to_le_bytes());
    for at in [12, 20] {
        let length = u64::from_le_bytes(texts[at..at + 8].try_into().unwrap()) + 8;
        texts[at..at + 8].copy_from_slice(&length.to_le_bytes());
    }
    let found = error(&texts, None, &["who"]);
    assert!(found.contains("claims more values"), "{found}");
    let complex = segment(NEW, &[("/'g'/'z'", Some((0x0010_000D, 1)), Vec::new())], &[0; 16]);
    let table = table_of(&complex, None, &["z"]).unwrap();
    assert!(matches!(&table.columns[1], Cells::Other(why) if why.contains("complex")));
}

#[test]
fn no_damage_of_a_byte_ends_the_program() {
    let whole = of_two(0.5, &[1.0, 2.0], &[-1.0, -2.0]);
    for at in 0..whole.len() {
        for byte in [0, 1, 0x7F, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            let _: Result<Table, StoreError> = table_of(&bytes, None, &["time_s", "angle", "F"]);
        }
    }
}

#[test]
fn what_fuzzers_found_is_refused_or_read() {
    let found = include_bytes!("../../../../fuzz/seeds/tdms/more_texts_than_ends");
    let _: Result<Table, StoreError> = table_of(found, None, &["time_s", "F", "angle"]);
    let columns: Vec<ColumnRef> = (1..=8).map(ColumnRef::Position).collect();
    let budget = Budget::default();
    let take = Take::of(columns.iter().collect(), &budget);
    let _: Result<Table, StoreError> = read(Path::new("a.tdms"), found, None, &take);
}
