//! Who took part in a study.

use std::collections::BTreeSet;
use zwidth_store::StudyData;

/// The participant of recordings in which nobody took part, as of a device driven by its own motor.
const NOBODY: &str = "none";

/// How many people gave a trial or an answer that counts.
pub(crate) fn participants(data: &StudyData) -> usize {
    let of_trials = data.counting().map(|trial| &trial.meta.participant);
    let of_answers = data.answers.iter().map(|answer| &answer.participant);
    let mut people: BTreeSet<_> = of_trials.chain(of_answers).collect();
    people.retain(|participant| participant.as_str() != NOBODY);
    people.len()
}
