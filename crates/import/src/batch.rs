//! Everything an import makes, as bytes; and writing it, all or nothing.

use super::context::Context;
use super::errors::Errors;
use super::identity::{FromZero, Identity};
use super::report::{FileReport, Report, Unplanned};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_store::commit::Change;
use zwidth_store::{
    Files, Layout, Staged, StoreError, hex_blake3, laid_down, new_log, record_bytes, replace,
};
use zwidth_study::{ActuatorId, Event, PlannedTrial, SessionRecord};

/// Everything that an import is about to write.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// New files, whole.
    pub(super) outputs: Vec<(PathBuf, Output)>,
    /// New event logs.
    pub(super) logs: Vec<(PathBuf, Vec<Event>)>,
    /// New events for existing logs.
    pub(super) added: BTreeMap<PathBuf, Vec<Event>>,
    /// The columns (from 1) of a questionnaire whose answers new sessions have.
    pub(super) answer_columns: Vec<usize>,
    /// The new sweeps, for the log of the study's sweeps.
    pub(super) sweeps: Vec<(ActuatorId, u32, String)>,
    /// The report on every file read.
    pub(super) files: Vec<FileReport>,
}

/// A new file.
#[derive(Debug)]
pub(super) enum Output {
    Bytes(Vec<u8>),
    /// Written beside its place.
    Staged(Staged),
}

impl From<Vec<u8>> for Output {
    fn from(bytes: Vec<u8>) -> Self {
        Self::Bytes(bytes)
    }
}

impl Output {
    /// BLAKE3 of the file, hexadecimal.
    pub(super) fn blake3(&self) -> String {
        match self {
            Self::Bytes(bytes) => hex_blake3(bytes),
            Self::Staged(staged) => staged.blake3.clone(),
        }
    }
}

impl Batch {
    /// Removes what was written beside its place and is not published.
    pub(super) fn discard(&self, disk: &dyn Files) {
        for (_, output) in &self.outputs {
            if let Output::Staged(staged) = output {
                staged.discard(disk);
            }
        }
    }

    /// Adds a session record and an event log for every session among `trials`, which stand in the
    /// order of `identities`; `events` are those of each trial, and `sources`, where the trials
    /// have no files to say so, the hashes of what they were imported from.
    pub(super) fn add_sessions(
        &mut self,
        context: &Context,
        identities: &[Identity],
        trials: &[PlannedTrial],
        events: Vec<Vec<Event>>,
        sources: &[&str],
    ) -> Result<(), StoreError> {
        type Session<'t> = (Vec<(&'t PlannedTrial, Vec<Event>)>, BTreeSet<String>);
        let mut sessions: BTreeMap<_, Session> = BTreeMap::new();
        for (at, ((i, trial), events)) in identities.iter().zip(trials).zip(events).enumerate() {
            let session = sessions.entry((&i.participant, &i.session)).or_default();
            session.0.push((trial, events));
            session.1.extend(sources.get(at).map(|source| (*source).to_owned()));
        }
        // Answers that are imported later name trials by the table's numbers, which may begin at 0.
        let counted_from_zero = FromZero::of(identities).trial;
        for ((participant, session), (mut trials, imported_from)) in sessions {
            trials.sort_by_key(|(t, _)| t.trial);
            let record = SessionRecord {
                imported_from: imported_from.into_iter().collect(),
                answer_columns: self.answer_columns.clone(),
                counted_from_zero,
                ..SessionRecord::new(
                    participant.clone(),
                    session.clone(),
                    context.mapping.source(),
                    context.software,
                    context.study_blake3.clone(),
                    trials.iter().map(|(t, _)| (*t).clone()).collect(),
                )
            };
            let path = context.layout.session(participant, session);
            let json = record_bytes(&path, &record)?;
            let laid_down = laid_down(&json);
            self.outputs.push((
                context.layout.study_copy(participant, session),
                context.study_toml.clone().into(),
            ));
            self.outputs.push((path, json.into()));
            let events = trials.into_iter().flat_map(|(_, events)| events);
            let events = std::iter::once(laid_down).chain(events).collect();
            self.logs.push((context.layout.events(participant, session), events));
        }
        Ok(())
    }

    /// The report on the whole import.
    pub(super) fn report(self, layout: &Layout, against_plan: Vec<Unplanned>) -> Report {
        let [trials, sweeps] = [layout.trials(), layout.sweeps()].map(|folder| {
            self.outputs.iter().filter(|(path, _)| path.starts_with(&folder)).count()
        });
        let new = self.logs.iter().map(|(_, events)| events);
        let events = new.chain(self.added.values()).flatten();
        Report {
            study: layout.study().clone(),
            trials,
            sweeps,
            sessions: self.logs.len(),
            answers: events.filter(|event| matches!(event, Event::Answer { .. })).count(),
            files: self.files,
            exclusions: 0,
            participants: 0,
            against_plan,
        }
    }

    /// Writes everything, or nothing: when a write fails, what was written before is removed again;
    /// when the process is killed, the next import or `recover` does that
    /// ([`zwidth_store::commit`]).
    ///
    /// # Errors
    /// The write that failed, saying what was removed, and any file that could not be removed.
    pub(super) fn write(
        &self,
        disk: &dyn Files,
        layout: &Layout,
        utc: &str,
        written: &dyn Fn(usize),
    ) -> Result<(), Errors> {
        if self.outputs.is_empty() && self.sweeps.is_empty() && self.added.is_empty() {
            return Ok(());
        }
        let mut logs: Vec<(PathBuf, Output)> = Vec::new();
        for (path, events) in &self.logs {
            logs.extend(new_log(path, utc, events)?.into_iter().map(|(p, b)| (p, b.into())));
        }
        let files: Vec<(&Path, &Output)> =
            self.outputs.iter().chain(&logs).map(|(path, out)| (path.as_path(), out)).collect();
        // Before the first is written: what is taken back must be the import's own.
        if let Some((path, _)) = files.iter().find(|(path, _)| disk.kind(path).is_some()) {
            self.discard(disk);
            let what = "it exists already; nothing was imported";
            return Err(StoreError::new(path, what, "finished files never change").into());
        }
        let hashes: Vec<(&Path, String)> =
            files.iter().map(|(path, output)| (*path, output.blake3())).collect();
        let sweeps = self.sweeps.iter().cloned();
        let sweeps: Vec<Event> = sweeps
            .map(|(actuator, sweep, blake3)| Event::SweepRecorded { actuator, sweep, blake3 })
            .collect();
        let log = layout.sweep_events();
        let added = self.added.iter().map(|(log, events)| (log.as_path(), events.as_slice()));
        let appended: Vec<(&Path, &[Event])> =
            added.chain([(log.as_path(), sweeps.as_slice())]).collect();
        let committed = Change::of(disk, layout, utc.into(), &hashes, &appended)
            .map_err(|error| vec![error])
            .and_then(|change| {
                change.make("imported", || {
                    for (path, output) in &files {
                        // That nothing lies there was looked at for all of them.
                        match output {
                            Output::Bytes(bytes) => replace(disk, path, bytes)?,
                            Output::Staged(staged) => staged.publish(disk, path)?,
                        }
                        written(files.len());
                    }
                    Ok(())
                })
            });
        committed.map_err(|errors| {
            self.discard(disk);
            errors.into_iter().collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{FORCE, ONE, World, trials_map};
    use std::path::PathBuf;
    use zwidth_store::{Fault, Files as _, Memory, StoreError, StudyData};

    fn two_trials(world: &World) -> Vec<PathBuf> {
        ["a.csv", "b.csv"]
            .map(|n| world.file(n, format!("t,f\n0,{}\n1,2\n", u8::from(n == "a.csv"))))
            .to_vec()
    }

    /// Imports two trials onto a disk in memory that fails at step `n`.
    fn import_failing_at(n: u64, fault: Fault) -> (Memory, World, Result<(), Vec<StoreError>>) {
        let (world, disk) = (World::new(), Memory::new());
        let study = std::fs::read(world.layout.study_toml()).unwrap();
        disk.put(&world.layout.study_toml(), &study);
        disk.fail_in(n, fault);
        let done = world.import_on(&trials_map(&[ONE, FORCE]), &two_trials(&world), &disk);
        (disk, world, done.map(drop))
    }

    #[test]
    fn a_full_disk_at_any_step_leaves_nothing_and_the_error_says_so() {
        for fault in 0.. {
            let (disk, world, done) = import_failing_at(fault, Fault::Full);
            let Err(errors) = done else {
                // The list, two trials, a record, the study's copy, a log and its head at 4 steps
                // each, 2 for each of 4 folders, and the sync after the list is removed: all were
                // tried. The removal itself is a step that a full disk takes.
                assert_eq!(fault, 38);
                let data = StudyData::load_from(&disk, &world.layout).unwrap();
                assert_eq!(data.counting().count(), 2);
                break;
            };
            let left = disk.list(&world.layout.raw()).unwrap();
            assert_eq!(left.len(), 1, "only study.toml, fault {fault}: {left:?}");
            let [error] = errors.as_slice() else { panic!("{errors:?}") };
            assert!(error.what.contains("nothing was imported"), "{error}");
            assert!(error.remedy.contains("free some space"), "{error}");
        }
    }

    #[test]
    fn what_cannot_be_removed_again_is_named() {
        let (_, _, done) = import_failing_at(16, Fault::ReadOnly);
        let errors = done.unwrap_err();
        assert!(errors[0].what.contains("could not be removed again"), "{errors:?}");
        assert!(errors[1].path.ends_with("trial-001.parquet"), "{errors:?}");
    }

    /// Where a mount of its own is made for the test below, and the kind of disk it is.
    const DISK: &str = "ZWIDTH_TEST_DISK";

    /// Runs the next test again in a user and mount namespace, on a disk of its own.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_disk_that_is_full_or_read_only_leaves_nothing() {
        for (disk, size) in [("full", "24k"), ("read-only", "1m")] {
            let folder = tempfile::tempdir().unwrap();
            let script = format!(
                "mount -t tmpfs -o size={size} none \"$1\" && cd \"$1\" && exec \"$2\" --nocapture --exact \"$3\""
            );
            let mut command = std::process::Command::new("unshare");
            command.args(["-Urm", "sh", "-c", &script, "sh"]).arg(folder.path());
            command.arg(std::env::current_exe().unwrap()).arg("batch::tests::on_a_disk_of_its_own");
            let Ok(output) = command.env(DISK, disk).output() else {
                println!("skipped: there is no `unshare` here");
                return;
            };
            let said = format!(
                "{}{}",
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
            if said.contains("unshare:") || said.contains("mount:") {
                println!("skipped: no mount of one's own here: {said}");
                return;
            }
            assert!(output.status.success() && said.contains("1 passed"), "{said}");
        }
    }

    #[test]
    fn on_a_disk_of_its_own() {
        let Ok(disk) = std::env::var(DISK) else { return };
        let here = std::env::current_dir().unwrap();
        let study = zwidth_study::template(&"demo".parse().unwrap());
        let world = World::below(&here, &study);
        let files = two_trials(&world);
        if disk == "read-only" {
            let mut mount = std::process::Command::new("mount");
            assert!(mount.args(["-o", "remount,ro", "."]).status().unwrap().success());
        }
        let errors = world.import(&trials_map(&[ONE, FORCE]), &files).unwrap_err();
        let [error] = errors.as_slice() else { panic!("{errors:?}") };
        assert!(error.what.contains("nothing was imported"), "{error}");
        let remedy = if disk == "full" { "free some space" } else { "make the folder writable" };
        assert!(error.remedy.contains(remedy), "{error}");
        assert_eq!(world.written(), ["study.toml"]);
    }
}
