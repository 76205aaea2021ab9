//! A table beside recordings that says which of their trials do not count → exclusions in the
//! sessions' logs.

use super::blocks::blake3_of;
use super::context::Context;
use super::errors::{Errors, all};
use super::identity::{counted, id};
use super::limits::Budget;
use super::mapping::{Exclusions, TrialFrom};
use super::recording::Recording;
use super::report::{FileReport, Report};
use super::table::ColumnRef;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_store::{StoreError, StudyData, TrialName, commit_events, trial_sources};
use zwidth_study::Event;

/// Excludes the trials that tables name: all of them, or none. What is excluded already stays as it is.
///
/// # Errors
/// Everything found wrong with the tables; a trial that the study does not have.
pub(super) fn import(
    context: &Context,
    form: &Exclusions,
    files: &[PathBuf],
    utc: &str,
) -> Result<Report, Errors> {
    let data = StudyData::load_from(context.files, context.layout);
    let data = data.map_err(|errors| errors.into_iter().collect::<Errors>())?;
    let sources = trial_sources(context.files, context.layout)?;
    let budget = Budget::default();
    let take = context.take(form.columns().collect(), &budget);
    let converted =
        context.convert(files, &take, |recording| read(context, form, recording, &sources))?;
    let mut events = BTreeMap::<_, Vec<Event>>::new();
    let mut reports = Vec::new();
    let mut excluded = BTreeSet::new();
    for table in converted {
        let (rows, mut report) = table.parsed;
        let mut new = 0;
        let mut before = 0;
        let mut shifted = false;
        for Excluded { row, trial: (participant, session, number), reason } in rows {
            let log = data.sessions.iter().find(|log| {
                (&log.record.participant, &log.record.session) == (&participant, &session)
            });
            // Numbers that a table names count as those of the recordings do; a trial that is found by its
            // recording has the study's own number.
            let is_theirs = matches!(form.trial, TrialFrom::Labels(_));
            let one_more = is_theirs && log.is_some_and(|log| log.record.counted_from_zero);
            let trial = number + u32::from(one_more);
            shifted |= one_more;
            let entry = data.trials.iter().find(|entry| {
                let meta = &entry.meta;
                (&meta.participant, &meta.session, meta.trial) == (&participant, &session, trial)
            });
            let (Some(entry), Some(log)) = (entry, log) else {
                let what = format!("{participant} {session} has no trial {number}");
                let error =
                    StoreError::new(&table.path, what, "mend the row, or leave it out with when");
                return Err(error.row0(row).into());
            };
            if entry.excluded.is_some() {
                before += 1;
            } else if excluded.insert((participant, session, trial)) {
                new += 1;
                events.entry(&log.events_path).or_default().push(Event::Excluded { trial, reason });
            }
        }
        report.made.push(format!("{new} trials excluded"));
        if shifted {
            let note = "trials are counted from 0 in the recordings, and so in this table: trial 0 is trial 1 here";
            report.told.push(note.to_owned());
        }
        if before > 0 {
            report.told.push(format!("{before} rows are about trials that are excluded already"));
        }
        reports.push(report);
    }
    let logs: Vec<(&Path, &[Event])> =
        events.iter().map(|(path, events)| (path.as_path(), events.as_slice())).collect();
    // All of them in one step: a study with half of its exclusions would be another study.
    commit_events(context.files, context.layout, utc, &logs)?;
    Ok(Report {
        study: context.layout.study().clone(),
        files: reports,
        trials: 0,
        sweeps: 0,
        sessions: 0,
        answers: 0,
        exclusions: excluded.len(),
        participants: 0,
        against_plan: Vec::new(),
    })
}

/// A trial that a row (from 0) excludes, and why.
struct Excluded {
    row: usize,
    trial: TrialName,
    reason: String,
}

fn read(
    context: &Context,
    form: &Exclusions,
    recording: &Recording,
    sources: &BTreeMap<String, BTreeSet<TrialName>>,
) -> Result<(Vec<Excluded>, FileReport), Errors> {
    let used = all(form.columns().map(|column| recording.find(column)))?;
    let rows = recording.rows(&context.mapping.file, &[], &[])?;
    let mut meant = Vec::new();
    for row in &rows.kept {
        let mut is_meant = true;
        for (column, words) in &form.when {
            let cell = recording.cell(column, *row)?.to_string();
            is_meant &= words.contains(&cell);
        }
        if is_meant {
            meant.push(*row);
        }
    }
    let excluded = all(meant.iter().map(|row| {
        let reason = form.reason.value("reason", recording, *row, |text| Ok(text.to_owned()))?;
        let trials = match &form.trial {
            TrialFrom::Recording { column, folder } => {
                from_recording(recording, *row, column, folder, sources)?
            }
            TrialFrom::Labels(labels) => {
                let [participant, session, trial] = &**labels;
                vec![(
                    participant.value("participant", recording, *row, id)?,
                    session.value("session", recording, *row, id)?,
                    trial.value("trial", recording, *row, |text| counted("trial", text))?,
                )]
            }
        };
        let excluded =
            trials.into_iter().map(|trial| Excluded { row: *row, trial, reason: reason.clone() });
        Ok::<_, Errors>(excluded.collect::<Vec<_>>())
    }))?;
    let report = context.file_report(recording, &rows, meant.len(), &used)?;
    Ok((excluded.into_iter().flatten().collect(), report))
}

/// The trials that were imported from the recording that a row names.
fn from_recording(
    table: &Recording,
    row: usize,
    column: &ColumnRef,
    folder: &Path,
    sources: &BTreeMap<String, BTreeSet<TrialName>>,
) -> Result<Vec<TrialName>, StoreError> {
    let name = table.cell(column, row)?.to_string();
    let path = table.path.parent().unwrap_or(Path::new("")).join(folder).join(&name);
    let blake3 = blake3_of(&path).map_err(|error| {
        let what = format!("{}: {}", path.display(), error.what);
        let remedy = "set folder in [exclude] to where the recordings lie, seen from the table";
        table.row_error(row, &what, remedy)
    })?;
    sources.get(&blake3).map(|trials| trials.iter().cloned().collect()).ok_or_else(|| {
        let what = format!("no trial of the study was imported from {}", path.display());
        table.row_error(row, &what, "import the recordings first, or leave the row out with when")
    })
}

#[cfg(test)]
mod tests {
    use super::super::world::{FORCE, ONE, World, trials_map};
    use zwidth_study::Event;

    const TABLE: &str = "file,who,n,outcome\nP1_1.csv,P1,1,COMPLETED\nP1_2.csv,P1,2,ABORTED\nP2_1.csv,P2,1,ABORTED\n";
    const BY_FILE: &str = "kind = \"exclusions\"\n[exclude]\nrecording = \"file\"\nfolder = \"tables/..\"\n\
                           when = { outcome = [\"ABORTED\"] }\nreason = { column = \"outcome\" }\n";

    fn world() -> World {
        let world = World::new();
        let named = ONE.replace("\"P01\"", "{ name = \"who\" }");
        let map = trials_map(&["[name]\npattern = '(?<who>P\\d)_'\n", &named, FORCE]);
        let names = ["P1_1.csv", "P1_2.csv", "P2_1.csv"];
        // Each has other bytes: a recording counts once.
        let files = names.map(|name| {
            let sum: u32 = name.bytes().zip(1..).map(|(byte, place)| u32::from(byte) * place).sum();
            world.file(name, format!("t,f\n0,{sum}\n1,2\n"))
        });
        world.import(&map, &files).unwrap();
        world
    }

    #[test]
    fn trials_are_excluded_by_the_recordings_that_a_table_names_and_once() {
        let world = world();
        let table = world.file("attempts.csv", TABLE);
        std::fs::create_dir(table.with_file_name("tables")).unwrap();
        let report = world.import(BY_FILE, std::slice::from_ref(&table)).unwrap();
        assert_eq!(report.exclusions, 2);
        assert!(report.to_string().contains("2 exclusions"), "{report}");
        let excluded = Event::Excluded { trial: 2, reason: "ABORTED".to_owned() };
        assert_eq!(world.events("P1", "S01").last(), Some(&excluded));
        let again = world.import(BY_FILE, &[table]).unwrap();
        assert_eq!(again.exclusions, 0);
        let words = "2 rows are about trials that are excluded already";
        assert!(again.to_string().contains(words), "{again}");
    }

    #[test]
    fn trials_are_excluded_by_their_labels_and_a_wrong_row_excludes_none() {
        let world = world();
        let map = "kind = \"exclusions\"\n[exclude]\nparticipant = { column = \"who\" }\nsession = \"S01\"\n\
                   trial = { column = \"n\" }\nreason = \"aborted\"\n";
        let all = world.file("all.csv", TABLE.replace("P2,1", "P2,7"));
        let errors = world.import(map, &[all]).unwrap_err();
        let words = "P2 S01 has no trial 7";
        assert!(errors[0].what.contains(words) && errors[0].row == Some(3), "{errors:?}");
        assert!(!world.events("P1", "S01").iter().any(|e| matches!(e, Event::Excluded { .. })));
        let lost = world.file("lost.csv", TABLE.replace("P1_2", "P1_9"));
        let by_file = BY_FILE.replace("folder = \"tables/..\"\n", "");
        let errors = world.import(&by_file, &[lost]).unwrap_err();
        let text = errors[0].to_string();
        assert!(text.contains("P1_9.csv") && errors[0].row == Some(2), "{errors:?}");
        assert_eq!(world.import(map, &[world.file("b.csv", TABLE)]).unwrap().exclusions, 3);
    }

    /// A table of theirs need not have a row with a 0.
    #[test]
    fn numbers_that_recordings_count_from_0_are_theirs_in_a_table_too() {
        let world = World::new();
        let map = trials_map(&[ONE, "trial = { column = \"n\" }\n", FORCE]);
        let rows: String = (0..4).map(|n| format!("0,{n},{n}\n1,2,{n}\n")).collect();
        world.import(&map, &[world.file("a.csv", format!("t,f,n\n{rows}"))]).unwrap();
        let map = "kind = \"exclusions\"\n[exclude]\nparticipant = \"P01\"\nsession = \"S01\"\n\
                   trial = { column = \"n\" }\nreason = \"aborted\"\n";
        let report = world.import(map, &[world.file("b.csv", "n\n2\n")]).unwrap();
        assert!(report.to_string().contains("trial 0 is trial 1 here"), "{report}");
        let excluded = Event::Excluded { trial: 3, reason: "aborted".to_owned() };
        assert_eq!(world.events("P01", "S01").last(), Some(&excluded));
        world.refuses(map, &world.file("c.csv", "n\n4\n"), "P01 S01 has no trial 4", None);
    }
}
