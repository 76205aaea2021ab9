//! Each part of a session in turn contradicts all the others.

use super::*;
use crate::form::head::head_of;
use crate::tests::crashes::{FOUR, UTC, ended_as, meta, planned, record, rows, study_alone, toml};
use crate::{
    RealFiles, StudyData, TrialFile, append_events, laid_down, lay_down, record_bytes, verify,
    write_new,
};
use std::fs;
use std::path::PathBuf;
use zwidth_study::{Calibration, Event, Source, TrialMeta};

/// A simulated session of one trial, with everything that a record can say.
struct Laid {
    _folder: tempfile::TempDir,
    layout: Layout,
    record: SessionRecord,
    path: PathBuf,
}

impl Laid {
    /// With the first line of its log, or as sessions were begun before there was one.
    fn new(with_first_line: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = study_alone(folder.path());
        let calibration = Calibration::thesis();
        let hash = hex_blake3(calibration.to_toml().unwrap().as_bytes());
        let record = SessionRecord {
            source: Source::Twin,
            device: Some("twin 1".to_owned()),
            calibration: Some(calibration),
            calibration_blake3: Some(hash.clone()),
            rate_hz: Some(1000.0),
            seed: Some(7),
            ..record(&layout, vec![planned(1)])
        };
        let path = layout.session(&record.participant, &record.session);
        if with_first_line {
            lay_down(&RealFiles, &layout, UTC, &record, &toml(&layout)).unwrap();
        } else {
            let copy = layout.study_copy(&record.participant, &record.session);
            write_new(&RealFiles, &copy, &toml(&layout)).unwrap();
            write_new(&RealFiles, &path, &record_bytes(&path, &record).unwrap()).unwrap();
        }
        let says = [
            ("study_blake3", record.study_blake3.clone()),
            ("calibration_blake3", hash),
            ("device", "twin 1".to_owned()),
            ("seed", "7".to_owned()),
        ];
        let file: TrialFile = says.into_iter().map(|(k, v)| (k.to_owned(), v)).collect();
        let meta = TrialMeta { source: Source::Twin, ..meta(1) };
        let protocol = crate::Protocol::default();
        let journal = ended_as(&RealFiles, &layout, &meta, &file, &protocol, &rows(0, 3));
        journal.finish(&RealFiles, &layout, FOUR, UTC).unwrap();
        let laid = Self { _folder: folder, layout, record, path };
        assert_eq!((verify(&laid.layout), laid.counting()), (vec![], 1));
        laid
    }

    fn counting(&self) -> usize {
        StudyData::load(&self.layout).unwrap().counting().count()
    }

    /// The trial does not count, and its mark is the footer's.
    fn check_left_out(&self, field: &str) {
        assert_eq!(self.counting(), 0, "{field}");
        let data = StudyData::load(&self.layout).unwrap();
        assert!(data.trials.iter().all(|t| t.meta.source == Source::Twin), "{field}");
    }

    /// Writes the record anew with something changed.
    fn edit(&self, change: impl Fn(&mut SessionRecord)) {
        let mut record = self.record.clone();
        change(&mut record);
        assert_ne!(record, self.record);
        fs::write(&self.path, record.to_json().unwrap()).unwrap();
    }
}

type Edit = (&'static str, fn(&mut SessionRecord));

/// Fields that the footers of trials speak of, too.
const IN_FOOTERS: [Edit; 10] = [
    ("source", |r| r.source = Source::Recorded),
    ("device", |r| r.device = Some("rig 1".to_owned())),
    ("calibration", |r| r.calibration.as_mut().unwrap().motor.force_n[1] = 4.0),
    ("calibration_blake3", |r| r.calibration_blake3 = Some("0".repeat(64))),
    ("seed", |r| r.seed = Some(8)),
    ("environment", |r| r.trials[0].environment = "spring_wall".parse().unwrap()),
    ("mode", |r| r.trials[0].mode = "active".parse().unwrap()),
    ("kind", |r| r.trials[0].kind = zwidth_study::Kind::Familiarisation),
    ("repeat", |r| r.trials[0].repeat = 2),
    ("study_blake3", |r| r.study_blake3 = "0".repeat(64)),
];

/// Fields that the record alone has.
const ALONE: [Edit; 4] = [
    ("rate_hz", |r| r.rate_hz = Some(120.0)),
    ("software", |r| r.software = "other".to_owned()),
    ("order", |r| {
        let scheme = zwidth_study::OrderScheme::Williams;
        r.order =
            Some(zwidth_study::OrderRecord { scheme, participant_number: 2, session_number: 1 });
    }),
    ("trial", |r| r.trials.push(planned(2))),
];

#[test]
fn each_field_of_a_record_that_is_edited_is_found_and_leaves_its_trials_out() {
    for (field, edit) in IN_FOOTERS.into_iter().chain(ALONE) {
        let laid = Laid::new(true);
        laid.edit(edit);
        let found = verify(&laid.layout);
        let is_told = found.iter().any(|f| f.path == laid.path && f.what.contains("by its log"));
        assert!(is_told, "{field}: {found:?}");
        laid.check_left_out(field);
    }
}

#[test]
fn where_no_log_knows_the_record_the_footers_and_the_calibrations_hash_speak_against_each_edited_field()
 {
    for (field, edit) in IN_FOOTERS {
        let laid = Laid::new(false);
        laid.edit(edit);
        let found = verify(&laid.layout);
        assert!(!found.is_empty(), "{field}: {found:?}");
        laid.check_left_out(field);
    }
}

#[test]
fn a_record_that_lost_its_log_beside_a_trial_is_not_laid_down_anew() {
    let laid = Laid::new(true);
    let log = laid.layout.events(&laid.record.participant, &laid.record.session);
    fs::remove_file(&log).unwrap();
    fs::remove_file(head_of(&log)).unwrap();
    assert_eq!(crate::recover(&RealFiles, &laid.layout, UTC), []);
    assert!(!log.exists() && laid.counting() == 0);
    assert!(verify(&laid.layout).iter().any(|f| f.what.contains("does not mention trial 1")));
}

#[test]
fn a_session_whose_record_is_gone_is_not_laid_down_anew() {
    let laid = Laid::new(true);
    fs::remove_file(&laid.path).unwrap();
    let path = laid.layout.events(&laid.record.participant, &laid.record.session);
    let log = fs::read(&path).unwrap();
    let again = lay_down(&RealFiles, &laid.layout, UTC, &laid.record, &toml(&laid.layout));
    assert!(again.unwrap_err().what.contains("its record is missing"));
    assert!(!laid.path.exists());
    assert_eq!(fs::read(&path).unwrap(), log);
}

#[test]
fn a_whole_session_is_read_and_one_that_was_never_laid_down_is_none() {
    let laid = Laid::new(true);
    let (participant, session) = (&laid.record.participant, &laid.record.session);
    let whole =
        crate::read_session(&RealFiles, &laid.layout, participant, session).unwrap().unwrap();
    assert_eq!((whole.trials.len(), whole.log.record), (1, laid.record.clone()));
    assert!(whole.log.events.contains(&laid_down(&fs::read(&laid.path).unwrap())));
    let other = "S02".parse().unwrap();
    assert_eq!(crate::read_session(&RealFiles, &laid.layout, participant, &other), Ok(None));
    // A copy alone is what a kill before the record leaves.
    fs::write(laid.layout.study_copy(participant, &other), "").unwrap();
    assert_eq!(crate::read_session(&RealFiles, &laid.layout, participant, &other), Ok(None));
    let event = Event::Note { trial: None, text: "x".to_owned() };
    append_events(&RealFiles, &laid.layout.events(participant, &other), UTC, &[event]).unwrap();
    let [finding] = crate::read_session(&RealFiles, &laid.layout, participant, &other)
        .unwrap_err()
        .try_into()
        .unwrap();
    assert!(finding.what.contains("record is missing, and its log is there"), "{finding}");
}
