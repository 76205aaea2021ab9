//! The known facts about a session's trials: the record, the repeated trials, and the seal.

use crate::StoreError;
use std::path::Path;
use zwidth_study::{Event, PlannedTrial, Seal, SealedTrial, SessionRecord};

/// A session's trials as they are known now.
pub(crate) struct SessionTrials {
    pub(crate) trials: Vec<PlannedTrial>,
    /// The seal, once it was opened and verified.
    pub(crate) seal: Option<Seal>,
    pub(crate) problems: Vec<StoreError>,
}

/// Reads from record and events what is known of the trials. An unsealing that does not verify
/// opens nothing.
pub(crate) fn session_trials(
    record: &SessionRecord,
    events: &[Event],
    events_path: &Path,
) -> SessionTrials {
    let mut session =
        SessionTrials { trials: record.trials.clone(), seal: None, problems: Vec::new() };
    for (row, event) in events.iter().enumerate() {
        let Event::Unsealed { nonce, order } = event else { continue };
        match open(record, nonce, order) {
            Ok((seal, trials)) => (session.seal, session.trials) = (Some(seal), trials),
            Err(why) => {
                let remedy =
                    "nothing is unsealed by it; unseal with the seal that the session began with";
                session.problems.push(StoreError::new(events_path, why, remedy).row0(row));
            }
        }
    }
    // Once the modes are open: a trial that was done again has the mode of the one it replaces.
    for event in events {
        let Event::Superseded { trial, by } = event else { continue };
        let again = session.trials.iter().find(|t| t.trial == *trial).cloned();
        if let Some(again) = again.filter(|_| !session.trials.iter().any(|t| t.trial == *by)) {
            session.trials.push(PlannedTrial { trial: *by, ..again });
        }
    }
    session
}

/// The seal that an event opens, and the trials with their modes.
fn open(
    record: &SessionRecord,
    nonce: &str,
    order: &[SealedTrial],
) -> Result<(Seal, Vec<PlannedTrial>), String> {
    let Some(commitment) = &record.commitment else {
        return Err("the session was not sealed, so there is nothing to unseal".to_owned());
    };
    let opened = Seal::from_event(nonce, order).and_then(|seal| {
        seal.verify(commitment)?;
        let trials = seal.opened(&record.trials)?;
        Ok((seal, trials))
    });
    opened.map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use crate::tests::crashes::{
        FOUR, UTC, ended_as, folder_with_study, meta, planned, protocol, record, rows, study_alone,
        toml,
    };
    use crate::{
        Layout, RealFiles, SessionLog, Signal, StudyData, TrialFile, append_events, laid_down,
        lay_down, verify,
    };
    use std::path::PathBuf;
    use zwidth_study::{
        Event, Kind, ModeId, PlannedTrial, Seal, SessionRecord, Source, Study, TrialMeta, order,
        template,
    };

    /// A sealed session of six trials and one to practise, all recorded; the second was done again
    /// as the eighth.
    struct Sealed {
        _folder: tempfile::TempDir,
        layout: Layout,
        seal: Seal,
        trials: Vec<PlannedTrial>,
    }

    impl Sealed {
        fn new() -> Self {
            let _folder = tempfile::tempdir().unwrap();
            let layout = study_alone(_folder.path());
            let mut study = Study::from_toml(&template(layout.study())).unwrap();
            (study.design.repeats, study.design.familiarisation) = (1, 1);
            let trials = order::draw(&study, 1, 1, 3);
            let seal = Seal::new([9; 32], &trials);
            let masked = seal.masked(&trials);
            let sealed = Self { _folder, layout, seal, trials };
            let record = SessionRecord {
                commitment: Some(sealed.seal.commitment()),
                source: Source::Twin,
                ..record(&sealed.layout, masked.clone())
            };
            lay_down(&RealFiles, &sealed.layout, UTC, &record, &toml(&sealed.layout)).unwrap();
            let again = PlannedTrial { trial: 8, mode: sealed.seal.code(8), ..masked[1].clone() };
            sealed.append(Event::Superseded { trial: 2, by: 8 });
            masked.iter().chain([&again]).for_each(|planned| sealed.run(planned));
            sealed
        }

        fn record(&self) -> PathBuf {
            self.layout.session(&meta(1).participant, &meta(1).session)
        }

        fn append(&self, event: Event) {
            let log = self.layout.events(&meta(1).participant, &meta(1).session);
            append_events(&RealFiles, &log, UTC, &[event]).unwrap();
        }

        fn run(&self, planned: &PlannedTrial) {
            let PlannedTrial { trial, repeat, kind, environment, mode, .. } = planned.clone();
            let log = StudyData::load(&self.layout).unwrap().sessions.pop();
            let source = log.map_or(Source::Twin, |log| log.record.source);
            let meta = TrialMeta { repeat, kind, environment, mode, source, ..meta(trial) };
            let file = TrialFile::new();
            let journal =
                ended_as(&RealFiles, &self.layout, &meta, &file, &protocol(), &rows(0, 3));
            journal.finish(&RealFiles, &self.layout, FOUR, UTC).unwrap();
        }

        fn load(&self) -> StudyData {
            StudyData::load(&self.layout).unwrap()
        }
    }

    #[test]
    fn sealed_trials_do_not_count_and_say_how_they_will_and_that_is_no_finding() {
        let sealed = Sealed::new();
        let data = sealed.load();
        assert_eq!((data.problems.clone(), verify(&sealed.layout)), (vec![], vec![]));
        assert!(data.sessions[0].is_sealed());
        assert_eq!((data.counting().count(), data.answers.len()), (0, 0));
        let why = |trial: usize| data.trials[trial - 1].why_not().unwrap();
        for other in &data.answers_left_out {
            assert_eq!(other.why_not, why(other.answer.trial as usize), "{other:?}");
        }
        assert!(data.answers_left_out.iter().any(|other| other.why_not == why(3)));
        assert_eq!(why(3), "sealed: unseal with `zwidth unseal demo -p P01 -s S01`");
        assert_eq!(why(1), "familiarisation");
        assert_eq!(why(2), "superseded by trial 8");
    }

    #[test]
    fn nothing_names_a_mode_before_it_is_unsealed() {
        let sealed = Sealed::new();
        let data = sealed.load();
        // A session knows the study, as everybody does.
        let without_study = |log: &SessionLog| SessionLog { study: None, ..log.clone() };
        let logs: Vec<_> = data.sessions.iter().map(without_study).collect();
        let shown = format!("{:?} {logs:?}", data.trials);
        for path in crate::disk::walk::files_below(&RealFiles, &sealed.layout.raw()).unwrap() {
            if !path.to_string_lossy().ends_with("study.toml") {
                let content =
                    [path.display().to_string().as_bytes(), &std::fs::read(&path).unwrap()]
                        .concat();
                let content = String::from_utf8_lossy(&content) + shown.as_str();
                for mode in ["active", "passive", "hybrid"] {
                    assert!(!content.contains(mode), "{mode} in {}", path.display());
                }
            }
        }
    }

    #[test]
    fn unsealed_every_trial_has_its_mode_and_repeat_and_counts() {
        let sealed = Sealed::new();
        sealed.append(sealed.seal.event());
        let data = sealed.load();
        assert_eq!((data.problems.clone(), verify(&sealed.layout)), (vec![], vec![]));
        let mut expected: Vec<_> =
            sealed.trials.iter().map(|t| (t.mode.clone(), t.repeat)).collect();
        expected.push(expected[1].clone());
        let found: Vec<_> =
            data.trials.iter().map(|t| (t.meta.mode.clone(), t.meta.repeat)).collect();
        assert_eq!(found, expected);
        let conditions: Vec<_> = data.counting().map(|t| t.meta.condition()).collect();
        assert_eq!(conditions.len(), 6);
        let mut answered: Vec<_> = data.answers.iter().map(|a| a.condition.clone()).collect();
        let mut planned = data.study.conditions();
        answered.sort();
        planned.sort();
        assert_eq!(answered, planned);
        let read = data.trials[4].read([Signal::Theta]).unwrap();
        assert_eq!(read.meta, data.trials[4].meta);
        assert!(data.trials.iter().filter(|t| t.meta.kind == Kind::Trial).count() == 7);
    }

    #[test]
    fn an_unsealing_that_does_not_verify_is_an_error_and_opens_nothing() {
        let sealed = Sealed::new();
        let mut swapped = sealed.seal.clone();
        let (a, b) = (swapped.order[1].mode.clone(), swapped.order[2].mode.clone());
        (swapped.order[1].mode, swapped.order[2].mode) = (b, a);
        sealed.append(swapped.event());
        let data = sealed.load();
        assert!(data.sessions[0].is_sealed() && data.counting().count() == 0);
        let [problem] = data.problems.as_slice() else { panic!("{:?}", data.problems) };
        assert!(problem.row == Some(19) && problem.what.contains("began with"), "{problem}");
        // The right one still opens it, and the wrong one stays a finding.
        sealed.append(sealed.seal.event());
        assert_eq!((sealed.load().counting().count(), verify(&sealed.layout).len()), (6, 1));
    }

    #[test]
    fn a_session_that_was_not_sealed_cannot_be_unsealed() {
        let (_folder, layout) = folder_with_study();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        append_events(&RealFiles, &log, UTC, &[Seal::new([1; 32], &[]).event()]).unwrap();
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.what.contains("nothing to unseal"), "{finding}");
    }

    #[test]
    fn a_trial_with_another_code_is_left_out_and_found() {
        let sealed = Sealed::new();
        let stranger = PlannedTrial { trial: 9, ..sealed.seal.masked(&sealed.trials)[3].clone() };
        sealed.append(Event::Superseded { trial: 4, by: 9 });
        sealed.run(&stranger);
        sealed.append(sealed.seal.event());
        let data = sealed.load();
        assert_eq!(data.counting().count(), 5);
        let [problem] = data.problems.as_slice() else { panic!("{:?}", data.problems) };
        assert!(problem.what.contains("is not the code of this trial"), "{problem}");
    }

    #[test]
    fn a_sealed_trial_that_nobody_vouches_for_is_told_once_and_not_by_its_code() {
        let sealed = Sealed::new();
        std::fs::remove_file(sealed.record()).unwrap();
        let found = verify(&sealed.layout);
        assert!(found.len() == 1 && found[0].path == sealed.record(), "{found:?}");
        let (_folder, layout) = folder_with_study();
        let sealed = Sealed { _folder, layout, seal: sealed.seal, trials: Vec::new() };
        sealed.run(&sealed.seal.masked(&[planned(1)])[0]);
        let [finding] = verify(&sealed.layout).try_into().unwrap();
        let words = "in its session's record";
        assert!(finding.what.contains(words), "a code in an open session: {finding}");
    }

    #[test]
    fn a_sealed_record_that_gives_the_order_away_is_found() {
        let sealed = Sealed::new();
        let text = std::fs::read_to_string(sealed.record()).unwrap();
        let check = |from: &str, to: &str, words: &str| {
            let changed = text.replacen(from, to, 1);
            std::fs::write(sealed.record(), &changed).unwrap();
            // As if it had been laid down so.
            let log = sealed.layout.events(&meta(1).participant, &meta(1).session);
            std::fs::remove_file(&log).unwrap();
            std::fs::remove_file(crate::form::head::head_of(&log)).unwrap();
            append_events(&RealFiles, &log, UTC, &[laid_down(changed.as_bytes())]).unwrap();
            let found = verify(&sealed.layout);
            assert!(found.iter().any(|f| f.what.contains(words)), "{found:?}");
        };
        let code: ModeId = sealed.seal.code(3);
        check(code.as_str(), "hybrid", "its record names the mode of trial 3");
        check("\"commitment\"", "\"seed\": 3, \"commitment\"", "holds the seed");
        check(&sealed.seal.commitment(), "12", "not 64 hexadecimal digits");
    }
}
