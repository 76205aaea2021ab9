//! The log of the sweeps: the hash of each, as a session's log has those of its trials.

use crate::disk::atomic::take_away;
use crate::disk::walk::files_below;
use crate::form::sweep::{entry, read_sweep_from};
use crate::judge::logged_sweeps::logged;
use crate::{Files, Layout, StoreError, Sweep, append_events, hex_blake3, sweep_bytes, write_new};
use std::path::PathBuf;
use zwidth_study::{ActuatorId, Event};

/// Says in the log that these sweeps were recorded, in one write.
///
/// # Errors
/// A log that cannot be read to its end; the write that failed.
pub fn log_sweeps(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
    sweeps: &[(ActuatorId, u32, String)],
) -> Result<(), StoreError> {
    let events = sweeps.iter().cloned();
    let events: Vec<Event> = events
        .map(|(actuator, sweep, blake3)| Event::SweepRecorded { actuator, sweep, blake3 })
        .collect();
    if events.is_empty() {
        Ok(())
    } else {
        append_events(files, &layout.sweep_events(), utc, &events)
    }
}

/// Writes a sweep's file, and says in the log that it was recorded; gives the file's path.
///
/// # Errors
/// A sweep of that number that is there already; a log that cannot be read to its end; the write
/// that failed. Then the sweep is not there.
pub fn record_sweep(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
    sweep: &Sweep,
) -> Result<PathBuf, StoreError> {
    let path = layout.sweep(&sweep.actuator, sweep.sweep);
    let bytes = sweep_bytes(sweep, &path)?;
    write_new(files, &path, &bytes)?;
    let logged = (sweep.actuator.clone(), sweep.sweep, hex_blake3(&bytes));
    let done = log_sweeps(files, layout, utc, &[logged]);
    done.map_err(|error| take_away(files, &path, error))?;
    Ok(path)
}

/// Takes sweeps in that the log does not speak of: a kill came between the file and its line, or an
/// older version wrote them. Their paths.
///
/// # Errors
/// A log that cannot be read; a write that failed. A sweep that cannot be read stays as it is, for
/// `verify` to tell.
pub(crate) fn take_in(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
) -> Result<Vec<PathBuf>, StoreError> {
    let logged = logged(files, layout)?;
    let mut readable = Vec::new();
    for path in
        files_below(files, &layout.sweeps())?.into_iter().filter(|path| !logged.contains_key(path))
    {
        let Ok(sweep) = read_sweep_from(files, &path) else { continue };
        if let Ok(entry) = entry(files, layout, path, sweep.actuator.clone()) {
            readable.push((entry.path, (sweep.actuator, sweep.sweep, entry.blake3)));
        }
    }
    let (paths, sweeps): (Vec<PathBuf>, Vec<_>) = readable.into_iter().unzip();
    log_sweeps(files, layout, utc, &sweeps)?;
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{UTC, folder_with_study};
    use crate::{Quantity, RealFiles, StudyData, recover, verify, verify_with};
    use std::collections::BTreeMap;
    use std::sync::Mutex;
    use zwidth_study::Source;

    fn write(layout: &Layout, number: u32, last: f64) -> (ActuatorId, u32, String) {
        let actuator: ActuatorId = "motor".parse().unwrap();
        let sweep = Sweep {
            actuator: actuator.clone(),
            sweep: number,
            source: Source::Recorded,
            command: Quantity { name: "voltage".into(), unit: "V".into() },
            response: Quantity { name: "force".into(), unit: "N".into() },
            t_s: None,
            command_values: vec![0.0, 1.0],
            response_values: vec![0.0, last],
            file: BTreeMap::new(),
        };
        let path = layout.sweep(&actuator, number);
        let bytes = sweep_bytes(&sweep, &path).unwrap();
        let _ = std::fs::remove_file(&path);
        write_new(&RealFiles, &path, &bytes).unwrap();
        (actuator, number, hex_blake3(&bytes))
    }

    fn counting(layout: &Layout) -> usize {
        StudyData::load(layout).unwrap().sweeps.len()
    }

    #[test]
    fn a_sweep_that_was_changed_deleted_or_written_anew_is_found_and_left_out() {
        let (_folder, layout) = folder_with_study();
        let sweeps: Vec<_> = (1..=3).map(|n| write(&layout, n, 0.26)).collect();
        log_sweeps(&RealFiles, &layout, UTC, &sweeps).unwrap();
        assert_eq!((counting(&layout), verify(&layout)), (3, vec![]));
        let counted = Mutex::new(Vec::new());
        let found = verify_with(&layout, &|all| counted.lock().unwrap().push(all));
        assert_eq!((found, counted.into_inner().unwrap()), (vec![], vec![3, 3, 3]));
        write(&layout, 2, 0.27);
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.what.contains("its hash differs from the log of the sweeps"), "{finding}");
        assert_eq!(counting(&layout), 2);
        write(&layout, 2, 0.26);
        let path = layout.sweep(&sweeps[2].0, 3);
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.what.contains("its file is missing"), "a folder in its place: {finding}");
    }

    #[test]
    fn a_sweep_that_no_log_speaks_of_does_not_count_until_recover_takes_it_in() {
        let (_folder, layout) = folder_with_study();
        write(&layout, 1, 0.26);
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.remedy.contains("zwidth recover"), "{finding}");
        assert_eq!(counting(&layout), 0);
        let done: Vec<_> =
            recover(&RealFiles, &layout, UTC).into_iter().map(Result::unwrap).collect();
        assert_eq!(done.len(), 1);
        let done = &done[0];
        assert!(done.to_string().contains("now in the log"), "{done}");
        assert_eq!((counting(&layout), verify(&layout)), (1, vec![]));
    }
}
