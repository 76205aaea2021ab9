use super::super::limits::tests::{numbers, only};
use super::super::table::{Cell, Cells, ColumnRef, Table};
use super::parameters::BLOCK;
use super::read;
use std::path::Path;
use zwidth_store::StoreError;

/// How numbers are written.
#[derive(Clone, Copy, PartialEq)]
enum As {
    Intel,
    Dec,
    Mips,
}

impl As {
    fn word(self, number: u16) -> [u8; 2] {
        if self == Self::Mips { number.to_be_bytes() } else { number.to_le_bytes() }
    }

    fn float(self, number: f32) -> [u8; 4] {
        match self {
            Self::Intel => number.to_le_bytes(),
            Self::Mips => number.to_be_bytes(),
            Self::Dec => {
                let [a, b, c, d] = (number * 4.0).to_le_bytes();
                [c, d, a, b]
            }
        }
    }
}

/// The value of a parameter.
#[derive(Clone)]
enum Value {
    Words(Vec<u16>),
    Floats(Vec<f32>),
    Texts(Vec<&'static str>),
}

/// A file as it is written.
#[derive(Clone)]
struct Written {
    numbers: As,
    is_float: bool,
    first: u16,
    last: u16,
    points: u16,
    channels: u16,
    samples: u16,
    parameters: Vec<(&'static str, &'static str, Value)>,
    /// The numbers of all frames; of whole ones as words.
    frames: Vec<f32>,
}

impl Written {
    fn bytes(&self) -> Vec<u8> {
        let Self { numbers, is_float, .. } = *self;
        let scale: f32 = if is_float { -1.0 } else { 0.1 };
        let mut head = vec![2, 0x50];
        for word in [self.points, self.channels * self.samples, self.first, self.last, 0] {
            head.extend(numbers.word(word));
        }
        head.extend(numbers.float(scale));
        head.extend(numbers.word(4));
        head.extend(numbers.word(self.samples));
        head.extend(numbers.float(100.0));
        head.resize(BLOCK, 0);
        let processor = match numbers {
            As::Intel => 84,
            As::Dec => 85,
            As::Mips => 86,
        };
        let mut section = vec![0, 0x50, 2, processor];
        let mut groups: Vec<&str> = Vec::new();
        for (group, name, value) in &self.parameters {
            let id = groups.iter().position(|known| known == group).unwrap_or_else(|| {
                groups.push(group);
                let id = groups.len();
                section.extend([group.len() as u8, (-(id as i8)) as u8]);
                section.extend(group.as_bytes());
                section.extend(numbers.word(3));
                section.push(0);
                id - 1
            });
            section.extend([name.len() as u8, id as u8 + 1]);
            section.extend(name.as_bytes());
            let (kind, size, data): (i8, Vec<u8>, Vec<u8>) = match value {
                Value::Words(words) => (
                    2,
                    vec![words.len() as u8],
                    words.iter().flat_map(|word| numbers.word(*word)).collect(),
                ),
                Value::Floats(floats) => (
                    4,
                    vec![floats.len() as u8],
                    floats.iter().flat_map(|float| numbers.float(*float)).collect(),
                ),
                Value::Texts(texts) => {
                    let longest = texts.iter().map(|text| text.len()).max().unwrap();
                    let texts_of = texts.iter().map(|text| format!("{text:longest$}"));
                    (
                        -1,
                        vec![longest as u8, texts.len() as u8],
                        texts_of.collect::<String>().into_bytes(),
                    )
                }
            };
            section.extend(numbers.word((2 + 2 + size.len() + data.len() + 1) as u16));
            section.extend([kind as u8, size.len() as u8]);
            section.extend(size);
            section.extend(data);
            section.push(0);
        }
        section.extend([0, 0]);
        assert!(section.len() <= 2 * BLOCK);
        section.resize(2 * BLOCK, 0);
        let frames = self.frames.iter().flat_map(|number| match is_float {
            true => numbers.float(*number).to_vec(),
            false => numbers.word(*number as i32 as u16).to_vec(),
        });
        [head, section, frames.collect()].concat()
    }
}

/// Three frames of a point and two channels of two samples each.
fn of_three(numbers: As, is_float: bool) -> Written {
    let frame = |i: u8| {
        let residual = if i == 2 { -1.0 } else { 0.0 };
        let i = f32::from(i);
        vec![10.0 * i, 20.0, -30.0, residual, 100.0 + i, 7.0, 200.0 + i, 9.0]
    };
    Written {
        numbers,
        is_float,
        first: 1,
        last: 3,
        points: 1,
        channels: 2,
        samples: 2,
        parameters: vec![
            ("POINT", "USED", Value::Words(vec![1])),
            ("POINT", "SCALE", Value::Floats(vec![if is_float { -1.0 } else { 0.1 }])),
            ("POINT", "LABELS", Value::Texts(vec!["hand"])),
            ("POINT", "UNITS", Value::Texts(vec!["mm"])),
            ("ANALOG", "LABELS", Value::Texts(vec!["Fx", "grip"])),
            ("ANALOG", "UNITS", Value::Texts(vec!["N", "V"])),
            ("ANALOG", "SCALE", Value::Floats(vec![0.5, 1.0])),
            ("ANALOG", "GEN_SCALE", Value::Floats(vec![2.0])),
            ("ANALOG", "OFFSET", Value::Words(vec![100, 0])),
            ("SUBJECTS", "NAMES", Value::Texts(vec!["P01"])),
        ],
        frames: (0..3_u8).flat_map(frame).collect(),
    }
}

/// A file of points and analog channels, for tests of other layers.
pub(in super::super) fn of_points_and_forces() -> Vec<u8> {
    of_three(As::Intel, true).bytes()
}

fn table_of(bytes: &[u8], part: Option<&str>, columns: &[&str]) -> Result<Table, StoreError> {
    only(columns, |take| read(Path::new("a.c3d"), bytes, part, take))
}

fn given(values: &[f64]) -> Vec<Option<f64>> {
    values.iter().copied().map(Some).collect()
}

#[test]
fn points_and_channels_are_read_from_every_processor_in_both_forms() {
    for as_is in [As::Intel, As::Dec, As::Mips] {
        for is_float in [true, false] {
            let bytes = of_three(as_is, is_float).bytes();
            let points = table_of(&bytes, Some("points"), &["time_s", "hand.x", "hand.z"]).unwrap();
            let scale = if is_float { 1.0 } else { f64::from(0.1_f32) };
            assert_eq!(numbers(&points, "time_s"), given(&[0.0, 0.01, 0.02]));
            // A point that was not seen is missing.
            let x = [Some(0.0), Some(10.0 * scale), None];
            assert_eq!(numbers(&points, "hand.x"), x);
            assert_eq!(numbers(&points, "hand.z")[..2], given(&[-30.0 * scale; 2]));
            let analog = table_of(&bytes, Some("analog"), &["time_s", "Fx", "grip"]).unwrap();
            assert_eq!(numbers(&analog, "Fx"), given(&[0.0, 100.0, 1.0, 101.0, 2.0, 102.0]));
            assert_eq!(numbers(&analog, "grip"), given(&[14.0, 18.0, 14.0, 18.0, 14.0, 18.0]));
            assert_eq!(numbers(&analog, "time_s")[5], Some(5.0 / 200.0));
            assert_eq!(
                (analog.units[&1].unit.as_str(), points.units[&1].unit.as_str()),
                ("N", "mm")
            );
        }
    }
}

#[test]
fn without_a_part_both_are_there_and_neither_is_put_on_the_times_of_the_other() {
    let bytes = of_points_and_forces();
    let table = table_of(&bytes, None, &["time_s", "analog/Fx"]).unwrap();
    assert_eq!(numbers(&table, "time_s").len(), 6);
    let table = table_of(&bytes, None, &["time_s", "analog/Fx", "points/hand.x"]).unwrap();
    assert!(matches!(&table.columns[0], Cells::Other(why) if why.contains("not the same rate")));
    let error = table_of(&bytes, Some("forces"), &["Fx"]).unwrap_err().to_string();
    assert!(error.contains("the file has no 'forces'; it has points and analog"), "{error}");
    let mut one = of_three(As::Intel, true);
    (one.channels, one.samples) = (0, 0);
    one.frames = [1.0, 2.0, 3.0, 0.0].repeat(3);
    let table = table_of(&one.bytes(), None, &["hand.y"]).unwrap();
    assert_eq!(numbers(&table, "hand.y"), given(&[2.0; 3]));
    let error = table_of(&one.bytes(), Some("analog"), &["Fx"]).unwrap_err().to_string();
    assert!(error.contains("no 'analog'; it has points"), "{error}");
}

#[test]
fn a_parameter_is_a_column_of_the_same_text_and_events_are_a_part() {
    let mut file = of_three(As::Intel, true);
    let table = table_of(&file.bytes(), Some("analog"), &["Fx", "SUBJECTS:NAMES"]).unwrap();
    let place = table.find(&ColumnRef::Name("SUBJECTS:NAMES".to_owned())).unwrap();
    assert_eq!((table.columns[place].len(), table.columns[place].cell(5)), (6, Cell::Text("P01")));
    file.parameters.extend([
        ("EVENT", "TIMES", Value::Floats(vec![0.0, 1.5, 1.0, 2.25])),
        ("EVENT", "LABELS", Value::Texts(vec!["onset", "end"])),
    ]);
    let table = table_of(&file.bytes(), Some("events"), &["time_s", "label"]).unwrap();
    assert_eq!(numbers(&table, "time_s"), given(&[1.5, 62.25]));
    assert_eq!(table.columns[1].cell(1), Cell::Text("end"));
    // Of a header, in seconds.
    let mut bytes = of_points_and_forces();
    bytes[298..302].copy_from_slice(&[0x39, 0x30, 1, 0]);
    bytes[304..308].copy_from_slice(&0.75_f32.to_le_bytes());
    bytes[396..400].copy_from_slice(b"GO  ");
    let table = table_of(&bytes, Some("events"), &["time_s", "label"]).unwrap();
    assert_eq!(numbers(&table, "time_s"), given(&[0.75]));
    assert_eq!(table.columns[1].cell(0), Cell::Text("GO"));
}

#[test]
fn words_without_a_sign_are_read_as_such_and_more_frames_than_a_word_counts() {
    let mut file = of_three(As::Intel, false);
    file.parameters.push(("ANALOG", "FORMAT", Value::Texts(vec!["UNSIGNED"])));
    file.parameters.retain(|(_, name, _)| !["OFFSET", "SCALE", "GEN_SCALE"].contains(name));
    file.parameters.push(("ANALOG", "OFFSET", Value::Words(vec![40_000, 0])));
    file.frames[4] = 65_000.0;
    let table = table_of(&file.bytes(), Some("analog"), &["Fx"]).unwrap();
    assert_eq!(numbers(&table, "Fx")[0], Some(25_000.0));
    // The header's count ends at 65,535; the parameters go on.
    let count = 70_000_u32;
    for named in [
        vec![
            ("TRIAL", "ACTUAL_START_FIELD", Value::Words(vec![1, 0])),
            ("TRIAL", "ACTUAL_END_FIELD", Value::Words(vec![(count % 65_536) as u16, 1])),
        ],
        vec![("POINT", "LONG_FRAMES", Value::Floats(vec![70_000.0]))],
    ] {
        let mut file = of_three(As::Intel, false);
        (file.channels, file.samples, file.last) = (0, 0, u16::MAX);
        file.parameters.extend(named);
        file.frames = (0..count).flat_map(|i| [(i % 1000) as f32, 0.0, 0.0, 0.0]).collect();
        let table = table_of(&file.bytes(), None, &["time_s", "hand.x"]).unwrap();
        assert_eq!(numbers(&table, "hand.x").len(), 70_000);
        assert_eq!((numbers(&table, "time_s")[69_999], &table.lost), (Some(699.99), &None));
    }
    // Above half of a word the last frame has no sign either, and the first is where the times begin.
    let mut file = of_three(As::Intel, true);
    (file.first, file.last) = (40_001, 40_003);
    let table = table_of(&file.bytes(), Some("points"), &["time_s"]).unwrap();
    assert_eq!(numbers(&table, "time_s"), given(&[400.0, 400.01, 400.02]));
    assert!(table.told[0].contains("the 40001th of the recording"), "{:?}", table.told);
}

#[test]
fn a_file_that_is_cut_off_says_how_many_frames_it_has_of_those_that_it_names() {
    let bytes = of_points_and_forces();
    let table = table_of(&bytes[..bytes.len() - 1], Some("points"), &["hand.x"]).unwrap();
    assert_eq!(table.lost.as_deref(), Some("it holds 2 of the 3 frames that it names"));
    assert_eq!(numbers(&table, "hand.x").len(), 2);
    for (bytes, words) in [
        (&bytes[..600], "its parameters are cut off"),
        (&bytes[..40], "its first block is not that of a C3D file"),
    ] {
        let error = table_of(bytes, Some("points"), &["hand.x"]).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let mut none = of_three(As::Intel, true);
    (none.points, none.channels) = (0, 0);
    none.parameters.clear();
    let error = table_of(&none.bytes(), None, &["x"]).unwrap_err().to_string();
    assert!(error.contains("neither points nor analog channels"), "{error}");
}

#[test]
fn no_damage_of_a_byte_ends_the_program() {
    let whole = of_points_and_forces();
    for at in (0..24).chain(512..800) {
        for byte in [0, 1, 0x7F, 0x80, 0xFF] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            for part in [None, Some("points"), Some("analog"), Some("events")] {
                let _: Result<Table, StoreError> =
                    table_of(&bytes, part, &["time_s", "hand.x", "Fx", "A:B"]);
            }
        }
    }
}
