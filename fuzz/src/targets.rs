//! One reader each.

use std::path::{Path, PathBuf};
use zwidth_device::TwinParameters;
use zwidth_dynamics::{ModelScene, System};
use zwidth_import::Mapping;
use zwidth_import::readers::readers;
use zwidth_link::frame::Frames;
use zwidth_link::message::{FromBoard, ToBoard};
use zwidth_runner::{Records, Results};
use zwidth_store::{Layout, Memory, hostile};
use zwidth_study::{Calibration, Study, StudyId, study_changes};

/// A reader, given bytes.
pub type Target = Box<dyn Fn(&[u8]) + Send + Sync>;

/// Every target of our own files by its name, which is the folder of its seeds.
const OURS: [(&str, fn(&[u8])); 14] = [
    ("journal", journal),
    ("events", events),
    ("head", head),
    ("record", record),
    ("records", records),
    ("study", study),
    ("calibration", calibration),
    ("mapping", mapping),
    ("scene", scene),
    ("twin", twin),
    ("trial", trial),
    ("sweep", sweep),
    ("whole", whole),
    ("wire", wire),
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
