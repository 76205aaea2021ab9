//! Tables that are too long to be read: they are written only for programs.

use crate::{compare, identify, replay};
use std::collections::BTreeSet;
use zwidth_store::{StudyData, TrialEntry};

/// A table that grows with trials or participants and has more rows than this is written for programs
/// alone: printed, it would have a hundred pages.
const MOST_READ: usize = 5000;

/// The names of the tables that may have more rows than anybody reads.
pub(crate) fn for_programs(data: &StudyData) -> BTreeSet<String> {
    longer_than(MOST_READ, data)
}

fn longer_than(most: usize, data: &StudyData) -> BTreeSet<String> {
    let study = &data.study;
    let trials = data.counting().count();
    let mut people = BTreeSet::new();
    let mut conditions = BTreeSet::new();
    // One by one: a set that is collected is a list of all trials first.
    for TrialEntry { meta: m, .. } in data.counting() {
        people.insert(&m.participant);
        conditions.insert((&m.participant, &m.session, &m.environment, &m.mode));
    }
    let contrasts = people.len() * study.environments.len() * study.compare.contrasts.len();
    let mut long = BTreeSet::new();
    for (name, rows) in [
        ("metrics", trials),
        ("replay", trials * replay::rows_of_a_trial(data)),
        ("identify.trials", identify::taken(data).0.len()),
        ("conditions", conditions.len()),
        ("answers", data.answers.len() + data.answers_left_out.len()),
    ] {
        if rows > most {
            long.insert(name.to_owned());
        }
    }
    if contrasts > most {
        let compared = compare::compared(data).into_iter();
        long.extend(compared.map(|metric| format!("participants_{metric}")));
    }
    long
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::data;

    #[test]
    fn a_table_with_more_rows_than_anybody_reads_is_for_programs_alone() {
        let study = data();
        assert_eq!(study.counting().count(), 2);
        let long = |most| longer_than(most, &study).into_iter().collect::<Vec<_>>();
        // Two trials, of one condition; each is replayed with two models three ways.
        assert_eq!((long(12), long(2)), (vec![], vec!["replay".to_owned()]));
        assert_eq!(long(1), ["metrics", "replay"]);
        assert_eq!(long(0)[..2], ["conditions", "metrics"]);
        assert!(for_programs(&study).is_empty());
    }
}
