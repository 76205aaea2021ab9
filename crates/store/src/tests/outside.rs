//! Tables of metrics that other programs computed: given as a whole or not at all, the last one counts, and damage is
//! told.

use crate::tests::crashes::{UTC, study as recorded};
use crate::{
    Entered, Fault, Files, FirstErrors, GivenFile, Layout, Memory, OutsideRow, StudyData, Survives,
    give_metric, next_table, recover, verify_from, withdraw_metric,
};
use std::path::PathBuf;
use zwidth_study::{Better, MetricId, OutsideMetric};

fn metric(unit: &str) -> OutsideMetric {
    let own = OutsideMetric::new("grip_peak".parse().unwrap(), unit, "largest grip").unwrap();
    OutsideMetric { better: Better::Lower, program: Some("grip.py 1.2".into()), ..own }
}

/// A study with one trial that is done, and the row of it.
fn study() -> (Memory, Layout, OutsideRow) {
    let (disk, layout) = recorded(true);
    let data = StudyData::load_from(&disk, &layout).unwrap();
    let entry = &data.trials[0];
    let row = OutsideRow {
        participant: entry.meta.participant.clone(),
        session: entry.meta.session.clone(),
        trial: entry.meta.trial,
        value: Some(0.1 + 0.2),
        recording: entry.blake3.clone(),
    };
    (disk, layout, row)
}

fn give(
    disk: &dyn Files,
    layout: &Layout,
    unit: &str,
    row: &OutsideRow,
) -> Result<PathBuf, FirstErrors> {
    let from = GivenFile { name: "grip.csv", blake3: "0123" };
    let rows = std::slice::from_ref(row);
    give_metric(disk, layout, Entered { utc: UTC, by: None }, &metric(unit), rows, from)
}

/// The tables that the log speaks of, each with the reason why it does not count.
fn tables(disk: &Memory, layout: &Layout) -> Vec<(u32, Option<String>)> {
    let data = StudyData::load_from(disk, layout).unwrap();
    data.outside.into_iter().map(|own| (own.table, own.why_not)).collect()
}

/// The only finding of `verify`, and its words.
fn finding(disk: &Memory, layout: &Layout) -> String {
    let [finding] = verify_from(disk, layout).try_into().unwrap();
    finding.to_string()
}

#[test]
fn the_last_table_of_a_metric_counts_and_none_is_overwritten() {
    let (disk, layout, row) = study();
    let first = give(&disk, &layout, "N", &row).unwrap();
    let bytes = disk.read(&first, u64::MAX).unwrap();
    let second = give(&disk, &layout, "N", &OutsideRow { value: None, ..row.clone() }).unwrap();
    assert!(first.ends_with("raw/demo/own/grip_peak.0001.parquet"), "{first:?}");
    assert!(second.ends_with("raw/demo/own/grip_peak.0002.parquet"), "{second:?}");
    assert_eq!(disk.read(&first, u64::MAX).unwrap(), bytes);
    let replaced = Some("table 2 took its place".to_owned());
    assert_eq!(tables(&disk, &layout), [(1, replaced.clone()), (2, None)]);
    let data = StudyData::load_from(&disk, &layout).unwrap();
    assert_eq!(data.study.from_tables, [metric("N")]);
    let id: MetricId = "grip_peak".parse().unwrap();
    let by = Entered { utc: UTC, by: None };
    withdraw_metric(&disk, &layout, by, &id, "wrong channel").unwrap();
    let withdrawn = Some("withdrawn: wrong channel".to_owned());
    assert_eq!(tables(&disk, &layout), [(1, replaced), (2, withdrawn)]);
    assert!(StudyData::load_from(&disk, &layout).unwrap().study.from_tables.is_empty());
    let error = withdraw_metric(&disk, &layout, by, &id, "again").unwrap_err().to_string();
    assert!(error.contains("no table of a metric grip_peak counts"), "{error}");
    assert_eq!(verify_from(&disk, &layout), []);
}

#[test]
fn a_metric_has_one_unit_until_it_is_withdrawn() {
    let (disk, layout, row) = study();
    give(&disk, &layout, "N", &row).unwrap();
    let error = next_table(&disk, &layout, &metric("mN")).unwrap_err().to_string();
    assert!(error.contains("grip_peak has the unit N, not mN"), "{error}");
    assert!(give(&disk, &layout, "mN", &row).is_err());
    let by = Entered { utc: UTC, by: None };
    withdraw_metric(&disk, &layout, by, &metric("N").id, "these were millinewtons").unwrap();
    assert!(give(&disk, &layout, "mN", &row).unwrap().ends_with("grip_peak.0002.parquet"));
    let data = StudyData::load_from(&disk, &layout).unwrap();
    assert_eq!(data.study.from_tables, [metric("mN")]);
}

#[test]
fn a_table_that_is_damaged_missing_exchanged_or_not_in_the_log_is_told_and_left_out() {
    let (disk, layout, row) = study();
    let path = give(&disk, &layout, "N", &row).unwrap();
    assert_eq!(verify_from(&disk, &layout), []);
    let whole = disk.read(&path, u64::MAX).unwrap();
    let left_out = || StudyData::load_from(&disk, &layout).unwrap().study.from_tables.is_empty();
    for byte in [whole.len() / 3, whole.len() - 20] {
        let mut damaged = whole.clone();
        damaged[byte] ^= 4;
        disk.put(&path, &damaged);
        assert!(finding(&disk, &layout).contains("grip_peak.0001.parquet"), "{byte}");
        assert!(left_out(), "{byte}");
    }
    // A whole table, with another value.
    let other = OutsideRow { value: Some(9.0), ..row.clone() };
    let bytes = crate::outside_bytes(&metric("N"), 1, &[other], &path).unwrap();
    disk.put(&path, &bytes);
    assert!(finding(&disk, &layout).contains("its hash differs from the log"));
    assert!(left_out());
    disk.remove(&path).unwrap();
    assert!(finding(&disk, &layout).contains("its file is missing"));
    assert!(left_out());
    disk.put(&path, &whole);
    let stray = layout.own_table(&metric("N").id, 7);
    disk.put(&stray, &whole);
    assert!(finding(&disk, &layout).contains("does not mention it: left out"));
    assert!(!left_out());
}

#[test]
fn a_changed_line_of_the_log_is_noticed_and_no_table_counts() {
    let (disk, layout, row) = study();
    give(&disk, &layout, "N", &row).unwrap();
    let log = layout.own_events();
    let text = String::from_utf8(disk.read(&log, u64::MAX).unwrap()).unwrap();
    disk.put(&log, text.replace("grip.py 1.2", "grip.py 1.3").as_bytes());
    let found = verify_from(&disk, &layout);
    assert!(found.iter().any(|f| f.what.contains("the checksum does not match")), "{found:?}");
    assert!(StudyData::load_from(&disk, &layout).unwrap().outside.is_empty());
}

#[test]
fn values_of_a_recording_that_is_another_one_now_are_told_and_named() {
    let (disk, layout, row) = study();
    let other = OutsideRow { recording: "0".repeat(64), ..row.clone() };
    give(&disk, &layout, "N", &other).unwrap();
    let data = StudyData::load_from(&disk, &layout).unwrap();
    assert_eq!(data.outside[0].outdated, [(row.participant, row.session, row.trial)]);
    assert!(finding(&disk, &layout).contains("of its 1 trials 1 have a recording that changed"));
}

#[test]
fn a_kill_at_any_step_leaves_the_table_with_its_line_or_neither() {
    for end in [Survives::Everything, Survives::Synced, Survives::Names, Survives::Half] {
        for n in 0.. {
            let (disk, layout, row) = study();
            disk.fail_in(n, Fault::End);
            let made = give(&disk, &layout, "N", &row);
            let killed = disk.has_failed();
            disk.restart(end);
            let found = recover(&disk, &layout, UTC);
            let what = format!("step {n}, {end:?} survives: {found:?}");
            assert!(found.iter().all(Result::is_ok), "{what}");
            assert_eq!(verify_from(&disk, &layout), [], "{what}");
            let count = tables(&disk, &layout).len();
            assert!(made.is_err() || count == 1, "{what}: what was acknowledged is gone");
            if count == 0 {
                assert!(give(&disk, &layout, "N", &row).is_ok(), "{what}");
            }
            assert_eq!(tables(&disk, &layout), [(1, None)], "{what}");
            if !killed {
                assert!(n > 8, "{n} steps");
                break;
            }
        }
    }
}

#[test]
fn an_error_at_any_step_gives_nothing() {
    for fault in [Fault::Full, Fault::ReadOnly] {
        for n in 0.. {
            let (disk, layout, row) = study();
            let before = disk.below(&layout.raw());
            disk.fail_in(n, fault);
            let made = give(&disk, &layout, "N", &row);
            let failed = disk.has_failed();
            disk.restart(Survives::Everything);
            let what = format!("{fault:?} from step {n}: {made:?}");
            match &made {
                Ok(_) => assert_eq!(tables(&disk, &layout), [(1, None)], "{what}"),
                Err(errors) if errors[0].what.contains("is not known") => {
                    assert_eq!(fault, Fault::ReadOnly, "{what}");
                }
                Err(_) => {
                    assert_eq!(tables(&disk, &layout), [], "{what}");
                    let found = recover(&disk, &layout, UTC);
                    assert!(found.iter().all(Result::is_ok), "{what}: {found:?}");
                    assert_eq!(disk.below(&layout.raw()), before, "{what}");
                }
            }
            if !failed {
                assert!(n > 8, "{n} steps");
                break;
            }
        }
    }
}
