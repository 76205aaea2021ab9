//! What each fuzz target does with its bytes: they take the place of one file of a small whole study in memory, which
//! is then read, verified and recovered. Whatever the bytes are, nothing panics, looking changes nothing, and recovering
//! loses nothing.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use zwidth_store::{
    Journal, Layout, Memory, Quantity, StudyData, Sweep, TrialFile, append_events, hex_blake3, lay_down,
    log_sweeps, recover, sweep_bytes, verify_from, write_new,
};
use zwidth_study::{
    Event, Flags, Kind, ParticipantId, PlannedTrial, Sample, SessionId, SessionRecord, Source, Status, TrialMeta,
    Voltages, template,
};

const UTC: &str = "2026-01-01T00:00:00Z";
/// Samples of a trial: enough for two frames of its journal.
const SAMPLES: usize = 6;

/// The study that hostile files are put into: a session with one trial recorded and one in its journal, and a sweep.
pub static STUDY: LazyLock<(Memory, Layout)> = LazyLock::new(|| {
    let (disk, layout) = (Memory::new(), Layout::new(Path::new("/root"), "demo".parse().unwrap()));
    let text = template(layout.study());
    disk.put(&layout.study_toml(), text.as_bytes());
    let trials = [1, 2].map(planned).to_vec();
    let hash = hex_blake3(text.as_bytes());
    let record = SessionRecord::new(participant(), session(), Source::Recorded, "fuzz", hash, trials);
    lay_down(&disk, &layout, UTC, &record, text.as_bytes()).unwrap();
    let mut first = journal(&disk, &layout, 1);
    first.end().unwrap();
    first.finish(&disk, &layout, Some(4), UTC).unwrap();
    drop(journal(&disk, &layout, 2));
    let note = Event::Note { trial: Some(1), text: "a note".into() };
    append_events(&disk, &layout.events(&participant(), &session()), UTC, &[note]).unwrap();
    sweep(&disk, &layout);
    (disk, layout)
});

fn participant() -> ParticipantId {
    "P01".parse().unwrap()
}

fn session() -> SessionId {
    "S01".parse().unwrap()
}

fn planned(trial: u32) -> PlannedTrial {
    PlannedTrial {
        trial,
        repeat: trial,
        kind: Kind::Trial,
        environment: "spring".parse().unwrap(),
        mode: "hybrid".parse().unwrap(),
        samples: true,
    }
}

fn journal(disk: &Memory, layout: &Layout, trial: u32) -> Journal {
    let PlannedTrial { repeat, kind, environment, mode, .. } = planned(trial);
    let (status, source) = (Status::Complete, Source::Recorded);
    let (participant, session) = (participant(), session());
    let meta =
        TrialMeta { participant, session, trial, repeat, kind, status, environment, mode, likert: None, source };
    let mut journal = Journal::create(disk, layout, &meta, &TrialFile::new()).unwrap();
    let rows: Vec<Sample> = (0..SAMPLES).map(sample).collect();
    rows.chunks(SAMPLES / 2).for_each(|rows| journal.append(rows).unwrap());
    journal
}

fn sample(i: usize) -> Sample {
    let x = i as f64;
    Sample {
        t_s: 1e-3 * x,
        t_device_s: None,
        theta_rad: 0.01 * x,
        theta_dot_rad_s: 10.0,
        force_ex_n: 0.1 * x,
        voltages: Voltages { motor_v: 0.1 * x, brake_v: 0.0 },
        force_age_s: Some(0.003),
        theta_raw: Some(i as u16),
        force_cmd_n: 0.026 * x,
        flags: Flags::MOTOR_ON,
    }
}

fn sweep(disk: &Memory, layout: &Layout) {
    let quantity = |name: &str, unit: &str| Quantity { name: name.into(), unit: unit.into() };
    let sweep = Sweep {
        actuator: "motor".parse().unwrap(),
        sweep: 1,
        source: Source::Recorded,
        command: quantity("voltage", "V"),
        response: quantity("force", "N"),
        t_s: None,
        command_values: vec![0.0, 1.0, 2.0],
        response_values: vec![0.0, 0.26, 0.52],
        file: BTreeMap::new(),
    };
    let path = layout.sweep(&sweep.actuator, 1);
    let bytes = sweep_bytes(&sweep, &path).unwrap();
    write_new(disk, &path, &bytes).unwrap();
    log_sweeps(disk, layout, UTC, &[(sweep.actuator, 1, hex_blake3(&bytes))]).unwrap();
}

/// Each target that puts its bytes into the study, and where.
pub fn places() -> [(&'static str, PathBuf); 8] {
    let layout = &STUDY.1;
    let (p, s) = (participant(), session());
    [
        ("journal", layout.journal(&p, &s, 2)),
        ("trial", layout.trial(&p, &s, 1)),
        ("sweep", layout.sweep(&"motor".parse().unwrap(), 1)),
        ("events", layout.events(&p, &s)),
        ("head", layout.events(&p, &s).with_extension("head")),
        ("record", layout.session(&p, &s)),
        ("study", layout.study_toml()),
        ("study_copy", layout.study_copy(&p, &s)),
    ]
}

/// Puts `bytes` in the place of the target's file, and looks at the whole study.
pub fn in_study(target: &str, bytes: &[u8]) {
    let (disk, layout) = (STUDY.0.copy(), &STUDY.1);
    if let Some((_, path)) = places().iter().find(|(name, _)| *name == target) {
        disk.put(path, bytes);
    }
    let raw = layout.raw();
    let before = disk.below(&raw);
    let _ = StudyData::load_from(&disk, layout);
    verify_from(&disk, layout);
    assert!(before == disk.below(&raw), "looking changed a file");
    let found = recover(&disk, layout, UTC);
    let after = disk.below(&raw);
    before.iter().for_each(|(path, bytes)| kept(path, bytes, &after));
    let again = recover(&disk, layout, UTC);
    assert!(!again.iter().any(Result::is_ok), "a second recovery did something: {found:?} then {again:?}");
}

/// Whether a file is there after recovering: as it was, or, if it was a journal, as a trial or set aside. Logs and their
/// heads may be mended.
fn kept(path: &Path, bytes: &[u8], after: &BTreeMap<PathBuf, Vec<u8>>) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if after.get(path).is_some_and(|now| now == bytes) {
        return;
    }
    if name.ends_with(".events.jsonl") || name.ends_with(".events.head") {
        assert!(after.contains_key(path), "{name} is gone");
    } else {
        assert!(name.ends_with(".journal"), "{name} was changed or removed");
        let aside = after.iter().any(|(now, content)| {
            now.to_string_lossy().contains(".damaged") && content == bytes
        });
        let trial = after.keys().any(|now| now.ends_with("trial-002.parquet"));
        assert!(aside || trial || !has_rows(bytes), "{name} is gone, and {} bytes with it", bytes.len());
    }
}

/// Whether a journal is long enough to hold rows behind its header.
fn has_rows(journal: &[u8]) -> bool {
    /// The first line, a header of its least length, a frame of one row.
    const SHORTEST: usize = 17 + 37 + 300 + 37 + 77;
    journal.len() >= SHORTEST && journal.iter().any(|byte| *byte != 0)
}

/// The text of some bytes, as the readers of text files take it.
fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// A mapping file.
pub fn mapping(bytes: &[u8]) {
    if let Some(text) = text(bytes) {
        let _ = zwidth_store::import::Mapping::from_toml(text, Path::new("map.toml"));
    }
}

/// A scene file: what passes its checks is computed with, to finite numbers or a named refusal.
pub fn scene(bytes: &[u8]) {
    let Some(Ok(scene)) = text(bytes).map(zwidth_dynamics::Scene::from_toml) else { return };
    let _ = zwidth_dynamics::System::new(scene);
}

/// `twin.toml`.
pub fn twin(bytes: &[u8]) {
    let read = text(bytes).map(toml::from_str::<zwidth_device::TwinParameters>);
    if let Some(Ok(twin)) = read {
        let _ = twin.check();
    }
}
