//! Streams beside a session: given as a whole or not at all, the last table counts, and damage is told.

use crate::tests::crashes::{UTC, study as recorded};
use crate::{
    BesideChannel, BesideStream, Entered, Fault, Files, FirstErrors, GivenFile, Layout, Memory,
    StudyData, Survives, give_beside, recover, verify_from, withdraw_beside,
};
use arrow::array::{Float64Array, StringArray};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const BY: Entered<'_> = Entered { utc: UTC, by: None };

/// Two samples of a stream, of which the second is of the first trial.
fn stream(id: &str) -> BesideStream {
    BesideStream {
        id: id.parse().unwrap(),
        stamp_s: vec![1.0, 1.5],
        recorder_s: vec![101.0, 101.5],
        in_trial: vec![None, Some((1, 0.25))],
        channels: vec![
            BesideChannel {
                name: "biceps".to_owned(),
                unit: "mV".to_owned(),
                label: "m. biceps".to_owned(),
                values: Arc::new(Float64Array::from(vec![Some(0.5), None])),
            },
            BesideChannel {
                name: "word".to_owned(),
                unit: "1".to_owned(),
                label: "a word".to_owned(),
                values: Arc::new(StringArray::from(vec!["a", "b"])),
            },
        ],
        about: BTreeMap::from([("uid".to_owned(), "7d".to_owned())]),
    }
}

fn study() -> (Memory, Layout) {
    recorded(true)
}

/// Gives both streams beside the only session.
fn give(disk: &Memory, layout: &Layout) -> Result<Vec<PathBuf>, FirstErrors> {
    let data = StudyData::load_from(disk, layout).unwrap();
    give_of(disk, layout, &data)
}

fn give_of(
    disk: &dyn Files,
    layout: &Layout,
    data: &StudyData,
) -> Result<Vec<PathBuf>, FirstErrors> {
    let from = GivenFile { name: "lab.xdf", blake3: "0123" };
    give_beside(disk, layout, BY, &data.sessions[0], &[stream("emg"), stream("gaze")], from)
}

/// The tables that the log speaks of, each with the reason why it does not count.
fn tables(disk: &Memory, layout: &Layout) -> Vec<(String, u32, Option<String>)> {
    let data = StudyData::load_from(disk, layout).unwrap();
    data.beside.into_iter().map(|own| (own.stream.to_string(), own.table, own.why_not)).collect()
}

fn both() -> [(String, u32, Option<String>); 2] {
    ["emg", "gaze"].map(|id| (id.to_owned(), 1, None))
}

#[test]
fn the_last_table_of_a_stream_counts_and_none_is_overwritten() {
    let (disk, layout) = study();
    let first = give(&disk, &layout).unwrap();
    assert!(
        first[0].ends_with("raw/demo/beside/participant=P01/session=S01/emg.0001.parquet"),
        "{first:?}"
    );
    let bytes = disk.read(&first[0], u64::MAX).unwrap();
    let second = give(&disk, &layout).unwrap();
    assert!(second[1].ends_with("session=S01/gaze.0002.parquet"), "{second:?}");
    assert_eq!(disk.read(&first[0], u64::MAX).unwrap(), bytes);
    let data = StudyData::load_from(&disk, &layout).unwrap();
    let emg = "emg".parse().unwrap();
    withdraw_beside(&disk, &layout, BY, &data.sessions[0], &emg, "electrodes off").unwrap();
    let replaced = Some("table 2 took its place".to_owned());
    let withdrawn = Some("withdrawn: electrodes off".to_owned());
    let of = |id: &str, table, why: &Option<String>| (id.to_owned(), table, why.clone());
    assert_eq!(
        tables(&disk, &layout),
        [
            of("emg", 1, &replaced),
            of("gaze", 1, &replaced),
            of("emg", 2, &withdrawn),
            of("gaze", 2, &None)
        ]
    );
    let data = StudyData::load_from(&disk, &layout).unwrap();
    let again = withdraw_beside(&disk, &layout, BY, &data.sessions[0], &emg, "again").unwrap_err();
    assert!(again.to_string().contains("no table of a stream emg counts"), "{again}");
    assert!(again.remedy.contains("gaze"), "{again}");
    assert_eq!(verify_from(&disk, &layout), []);
}

#[test]
fn a_table_that_is_altered_missing_or_unknown_is_told() {
    let (disk, layout) = study();
    let path = give(&disk, &layout).unwrap().swap_remove(0);
    assert_eq!(verify_from(&disk, &layout), []);
    let whole = disk.read(&path, u64::MAX).unwrap();
    let finding = || {
        let [finding] = verify_from(&disk, &layout).try_into().unwrap();
        finding.to_string()
    };
    let mut damaged = whole.clone();
    damaged[whole.len() / 3] ^= 4;
    disk.put(&path, &damaged);
    assert!(finding().contains("its hash differs from the session's log"));
    disk.remove(&path).unwrap();
    assert!(finding().contains("its file is missing"));
    disk.put(&path, &whole);
    disk.put(&path.with_file_name("emg.0007.parquet"), &whole);
    assert!(finding().contains("no session's log mentions the table"));
    disk.remove(&path.with_file_name("emg.0007.parquet")).unwrap();
    disk.put(&path.with_file_name("emg.csv"), b"1,2");
    assert!(finding().contains("only Parquet files belong in this tree"));
}

#[test]
fn a_kill_at_any_step_leaves_all_tables_with_their_lines_or_none() {
    for end in [Survives::Everything, Survives::Synced, Survives::Names, Survives::Half] {
        for n in 0.. {
            let (disk, layout) = study();
            let data = StudyData::load_from(&disk, &layout).unwrap();
            disk.fail_in(n, Fault::End);
            let made = give_of(&disk, &layout, &data);
            let killed = disk.has_failed();
            disk.restart(end);
            let found = recover(&disk, &layout, UTC);
            let what = format!("step {n}, {end:?} survives: {found:?}");
            assert!(found.iter().all(Result::is_ok), "{what}");
            assert_eq!(verify_from(&disk, &layout), [], "{what}");
            let count = tables(&disk, &layout).len();
            assert!([0, 2].contains(&count), "{what}");
            assert!(made.is_err() || count == 2, "{what}: what was acknowledged is gone");
            if count == 0 {
                assert!(give(&disk, &layout).is_ok(), "{what}");
            }
            assert_eq!(tables(&disk, &layout), both(), "{what}");
            if !killed {
                assert!(n > 8, "{n} steps");
                break;
            }
        }
    }
}
