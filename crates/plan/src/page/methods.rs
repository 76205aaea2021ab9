//! What the methods in words describe: what was recorded, and which stages a run has for it.

use crate::page::people::participants;
use crate::page::preregistered::preregistered;
use crate::{compare, curves, identify, likert, replay};
use std::collections::BTreeMap;
use zwidth_report::Recorded;
use zwidth_store::StudyData;

/// What was recorded for a study, and which results a run makes of it.
pub fn recorded(data: &StudyData) -> Recorded {
    let answers = &data.answers;
    let with_samples =
        data.counting().map(|t| (&t.meta.participant, &t.meta.session, t.meta.trial));
    let with_answers = answers.iter().map(|a| (&a.participant, &a.session, a.trial));
    let mut trials: Vec<_> = with_samples.chain(with_answers).collect();
    trials.sort();
    trials.dedup();
    // Sorted, so that trials of one session follow each other.
    let mut sessions: Vec<_> = trials.iter().map(|(p, s, _)| (*p, *s)).collect();
    sessions.dedup();
    let mut sources = BTreeMap::new();
    // By the footers of trials that have a file; a record is asked for the others alone, so that none
    // is counted twice.
    for trial in &data.trials {
        *sources.entry(trial.meta.source).or_default() += 1;
    }
    for log in &data.sessions {
        *sources.entry(log.record.source).or_default() +=
            log.record.trials.iter().filter(|t| !t.samples).count();
    }
    for sweep in &data.sweeps {
        *sources.entry(sweep.source).or_default() += 1;
    }
    let imported = data.trials.iter().filter_map(|trial| trial.said.file.get("made_by_import"));
    let made_by_import =
        imported.flat_map(|columns| columns.split("; ")).map(str::to_owned).collect();
    let compared = compare::compared(data);
    let plan = preregistered(data, &compared);
    let participants = participants(data);
    let bounded = data.study.compare.bounds.keys().map(ToString::to_string);
    let primary = data.study.compare.primary.metrics().map(ToString::to_string);
    let metrics = bounded.chain(primary).chain(compared.iter().cloned());
    let words = metrics.filter_map(|name| {
        let words = zwidth_metrics::in_words(&data.study, &name)?;
        let words = match compare::chosen_after(data, &name) {
            Some(why) => format!("{words} ({})", why.trim_end_matches('.')),
            None => words,
        };
        Some((name, words))
    });
    let mut unmet: BTreeMap<String, usize> = BTreeMap::new();
    for trial in data.trials.iter().filter(|trial| trial.is_unmet) {
        let mode = data.study.mode(&trial.meta.mode);
        let label = mode.map_or_else(|| "sealed".to_owned(), |mode| mode.label.clone());
        *unmet.entry(label).or_default() += 1;
    }
    Recorded {
        unmet,
        words: words.collect(),
        made_by_import,
        participants,
        sessions: sessions.len(),
        trials: trials.len(),
        sampled: data.counting().next().is_some(),
        sweeps: data.sweeps.len(),
        sources,
        compared,
        curves: curves::of_study(data).is_some(),
        answers: likert::tally(data).is_some(),
        guesses: likert::blinding(data).is_some(),
        // Without the lever's length the table of replays has nothing but reasons why not.
        replayed: replay::of_study(data).is_some() && data.study.device.lever_m.is_some(),
        identified: identify::known_plant(data).is_some(),
        plan: plan.map(|plan| plan.sentences(participants)).unwrap_or_default(),
    }
}
