//! One reader each.

use crate::seeds::{firmata_settings, text_settings};
use std::path::{Path, PathBuf};
use zwidth_device::TwinParameters;
use zwidth_device::mock::Mock;
use zwidth_dynamics::{ModelScene, System};
use zwidth_import::Mapping;
use zwidth_import::readers::readers;
use zwidth_link::firmata::{End, I2cReply, I2cRequest, Parser, Pin};
use zwidth_link::framed::frame::Frames;
use zwidth_link::framed::message::{FromBoard, ToBoard};
use zwidth_link::text::{Field, Lines, Template};
use zwidth_link::{AngleAt, Board, Settings, hostile as rig};
use zwidth_runner::{Records, Results};
use zwidth_store::{Layout, Memory, hostile};
use zwidth_study::{
    Calibration, Known, People, PeopleForm, PersonColumn, Study, StudyId, study_changes,
};

/// A reader, given bytes.
pub type Target = Box<dyn Fn(&[u8]) + Send + Sync>;

/// Every target of our own files by its name, which is the folder of its seeds.
const OURS: [(&str, fn(&[u8])); 18] = [
    ("journal", journal),
    ("events", events),
    ("head", head),
    ("record", record),
    ("records", records),
    ("study", study),
    ("people", people),
    ("calibration", calibration),
    ("mapping", mapping),
    ("scene", scene),
    ("twin", twin),
    ("trial", trial),
    ("sweep", sweep),
    ("whole", whole),
    ("wire", wire),
    ("firmata", firmata),
    ("lines", lines),
    ("participant", participant),
];

pub fn named(name: &str) -> Option<Target> {
    let ours = OURS.iter().find(|(known, _)| *known == name);
    let theirs = || readers().find(|reader| reader.word() == name);
    ours.map(|(_, target)| Box::new(target) as Target).or_else(|| {
        theirs().map(|reader| -> Target { Box::new(move |bytes| drop(reader.read(bytes))) })
    })
}

pub fn names() -> Vec<&'static str> {
    OURS.iter().map(|(name, _)| *name).chain(readers().map(|reader| reader.word())).collect()
}

/// A disk with this one file, and where it lies.
fn disk(bytes: &[u8]) -> (Memory, PathBuf) {
    let (disk, path) = (Memory::new(), PathBuf::from("/x/participant=P01/session=S01/trial-001"));
    disk.put(&path, bytes);
    (disk, path)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn journal(bytes: &[u8]) {
    let (disk, path) = disk(bytes);
    if let Ok(rows) = hostile::journal(&disk, &path) {
        assert!(rows * 8 <= bytes.len(), "{rows} rows of {} bytes", bytes.len());
    }
}

fn events(bytes: &[u8]) {
    let (disk, path) = disk(bytes);
    let _ = hostile::events(&disk, &path);
}

/// The head first, up to a zero; its log behind it.
fn head(bytes: &[u8]) {
    let at = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let (disk, path) = disk(bytes.get(at + 1..).unwrap_or_default());
    disk.put(&hostile::head_of(&path), &bytes[..at]);
    let _ = hostile::events(&disk, &path);
}

/// Bytes of either end: what is read of them is written as it was read.
fn wire(bytes: &[u8]) {
    let mut frames = Frames::default();
    for frame in bytes.iter().filter_map(|byte| frames.push(*byte)) {
        if let Some(message) = ToBoard::read(&frame) {
            assert_eq!(ToBoard::read(&message.frame(frame.sequence)), Some(message));
        }
        if let Some(message) = FromBoard::read(&frame) {
            assert_eq!(FromBoard::read(&message.frame(frame.sequence)), Some(message));
        }
    }
}

/// Bytes of either end of Firmata: what is read of them is written as it was read; then both ends
/// hear them.
fn firmata(bytes: &[u8]) {
    for end in [End::Host, End::Board] {
        let mut parser = Parser::new(end);
        for byte in bytes {
            let Some(message) = parser.push(*byte) else { continue };
            let mut written = Vec::new();
            message.write(&mut written);
            let (last, head) = written.split_last().expect("a message has a byte");
            let mut again = Parser::new(end);
            assert!(head.iter().all(|byte| again.push(*byte).is_none()));
            assert_eq!(again.push(*last), Some(message));
        }
    }
    let low: Vec<u8> = bytes.iter().map(|byte| byte & 0x7F).collect();
    let pins = Pin::read_all(&low);
    assert_eq!(Pin::read_all(&Pin::write_all(&pins)), pins);
    if let Some(request) = I2cRequest::read(&low) {
        assert_eq!(I2cRequest::read(&request.data()), Some(request));
    }
    if let Some(reply) = I2cReply::read(&low) {
        assert_eq!(I2cReply::read(&reply.data()), Some(reply));
    }
    for angle in [AngleAt::Analog(0), AngleAt::I2c] {
        both_ends(&firmata_settings(angle), bytes);
    }
}

/// Lines of a template that is the first of them: what is read is written as it was read; then both
/// ends hear them.
fn lines(bytes: &[u8]) {
    const FIELDS: [Field; 5] =
        [Field::Millis, Field::Micros, Field::Counts, Field::Hx711, Field::Any];
    let at = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    if let Ok(template) = Template::parse(&text(&bytes[..at]), &FIELDS, &[]) {
        let mut lines = Lines::from_anywhere();
        for byte in &bytes[at..] {
            let Some(values) = lines.push(*byte).and_then(|line| template.read(line)) else {
                continue;
            };
            let mut written = Vec::new();
            template.write(&values, &mut written);
            assert!(written.len() < template.longest() + 1 || template.has(Field::Any));
            let line = written.strip_suffix(b"\n").expect("a line ends");
            assert!(template.has(Field::Any) || template.read(line) == Some(values));
        }
    }
    both_ends(&text_settings(), bytes);
}

/// A host and a board that hear these bytes.
fn both_ends(settings: &Settings, bytes: &[u8]) {
    if let Ok(told) = rig::hear(settings, bytes) {
        assert!(told.counts.len() <= bytes.len() && told.damaged <= bytes.len() as u64);
    }
    let mut board = Board::by(settings, Mock::default(), Vec::new()).expect("settings");
    let mut out = Vec::new();
    board.take(0.0, bytes, &mut out).expect("a device that is there");
    // The longest answer to three bytes is what all pins can do.
    assert!(out.len() <= 200 * (bytes.len() + 4), "{} bytes said to {}", out.len(), bytes.len());
}

fn record(bytes: &[u8]) {
    let _ = hostile::record(Path::new("P01_S01.json"), &text(bytes));
}

fn layout() -> Option<Layout> {
    Some(Layout::new(Path::new("/r"), StudyId::new("demo").ok()?))
}

fn records(bytes: &[u8]) {
    let Some(layout) = layout() else { return };
    let disk = Memory::new();
    disk.put(&Results::records_file(&layout), bytes);
    let _ = Records::read(&Results::new(&layout, &disk));
}

fn study(bytes: &[u8]) {
    if let Ok(study) = Study::from_toml(&text(bytes)) {
        assert!(study_changes(&study, &study).is_empty(), "a study differs from itself");
    }
}

/// A participants' file in CSV, or in TOML: the first byte says which.
fn people(bytes: &[u8]) {
    let Some((which, bytes)) = bytes.split_first() else { return };
    let form = if which % 2 == 0 { PeopleForm::Csv } else { PeopleForm::Toml };
    let id = |name: &str| name.parse().expect("an id");
    let levels = ["novice", "expert"].map(|level| level.parse().expect("a level")).to_vec();
    let columns = [
        PersonColumn { id: id("group"), known: Known::Level { levels, assigned: false } },
        PersonColumn { id: id("age_years"), known: Known::Number { unit: "years".to_owned() } },
    ];
    match People::read(&text(bytes), form, &columns) {
        Ok(people) => {
            for (_, row) in people.iter() {
                assert!(row.keys().all(|column| columns.iter().any(|own| own.id == *column)));
            }
        }
        Err(errors) => {
            let shown: Vec<String> = errors.iter().map(ToString::to_string).collect();
            assert!(!shown.is_empty() && shown.iter().all(|e| !e.contains(['\n', '\u{1b}'])));
        }
    }
}

fn calibration(bytes: &[u8]) {
    if let Ok(calibration) = Calibration::from_toml(&text(bytes)) {
        for force_n in [0.0, 1.0, -1e9] {
            assert!(
                calibration.motor.voltage_v(force_n).is_finite()
                    && calibration.brake.voltage_v(force_n).is_finite()
            );
        }
    }
}

fn mapping(bytes: &[u8]) {
    let _ = Mapping::from_toml(&text(bytes), Path::new("map.toml"));
}

fn scene(bytes: &[u8]) {
    if let Ok(scene) = ModelScene::from_toml(&text(bytes)) {
        let _ = System::new(scene);
    }
}

fn twin(bytes: &[u8]) {
    if let Ok(twin) = toml::from_str::<TwinParameters>(&text(bytes))
        && twin.check().is_ok()
    {
        let _ = twin.plant(None);
    }
}

fn trial(bytes: &[u8]) {
    let (disk, path) = disk(bytes);
    let _ = hostile::trial(&disk, &path);
}

fn sweep(bytes: &[u8]) {
    let (disk, path) = disk(bytes);
    let _ = hostile::sweep(&disk, &path);
}

/// A study of one session with these bytes as one of its files: the first byte says which.
/// Everything that is said of it can be shown.
fn whole(bytes: &[u8]) {
    let (Some(layout), Some((which, bytes))) = (layout(), bytes.split_first()) else { return };
    let disk = Memory::new();
    disk.put(&layout.study_toml(), zwidth_study::template(layout.study()).as_bytes());
    let session = layout.session(&"P01".parse().expect("an id"), &"S01".parse().expect("an id"));
    let name = |name: &str| session.with_file_name(name);
    let place = match which % 4 {
        0 => session.clone(),
        1 => name("P01_S01.events.jsonl"),
        2 => name("P01_S01.study.toml"),
        _ => layout.study_toml(),
    };
    disk.put(&place, bytes);
    for finding in zwidth_store::verify_from(&disk, &layout) {
        let shown = finding.to_string();
        assert!(!shown.contains(['\n', '\u{1b}', '\u{202e}']), "{shown:?}");
    }
}

/// What a participant's screen and its session send each other, and where the session is found.
fn participant(bytes: &[u8]) {
    assert!(
        zwidth_acquire::hostile::is_read_as_written(bytes),
        "it is read otherwise when written"
    );
}
